"""Measured values of anything that can be computed from a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..base import kinds
from ..base.kinds import instance
from ..base.limits import FINITE, POSITIVE, Limits
from ..base.tables import Table, Tabled
from ..base.units import UNITLESS, as_quantity, is_quantity, strip_to
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .pictures import draw
from .times import to_system_times


class Measured(Tabled):
    """A measured value, or several, of a function of a run: a period, a pole, a rate of precession, an amplitude.

    Parameters
    ----------
    name : str
    function : callable
        A function that takes a :class:`fullbody.Run` and returns the predicted value: a number, a Quantity or an array
        (C,).
    value : float, Quantity or array_like, () or (C,)
    sigma : float, Quantity or array_like, () or (C,)
        Standard errors.
    times : astropy Time, or array_like or Quantity, (K,), optional
        Times at which a fit samples the run that it passes to the function: dates, or times since the system's epoch.
        It may be empty for a function of the system alone.

    Raises
    ------
    InvalidInput
        For an error that is not above zero. When a run is compared: for a function that returns another shape or unit,
        or a value that is not finite.

    Examples
    --------
    >>> import fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.case1()
    >>> mean = observing.Measured("mean distance", lambda run: run.elements().a.mean(), 7.6, 0.1)
    >>> mean.residuals(system.integrate(state, 50.0)).shape
    (1,)
    """

    def __init__(self, name: str, function: Callable[[Any], Any], value: Any, sigma: Any, times: Any = None) -> None:
        self.name = instance(name, "name of a measured value", str, "text")
        self.function = kinds.function(function, f"function of {name!r}", "a function of a run")
        self.times = times
        value = as_quantity(value, f"value of {name}")
        self.unit = value.unit if is_quantity(value) else None
        self._value = np.atleast_1d(self._unitless(value, "value"))
        if self._value.ndim > 1:
            raise InvalidInput(f"value of {name} has shape {self._value.shape}; expected one number, or (C,)")
        errors = self._unitless(sigma, "sigma", POSITIVE)
        try:
            self._sigma = np.array(np.broadcast_to(errors, self._value.shape))
        except ValueError as error:
            raise InvalidInput(f"sigma of {name} has shape {np.shape(sigma)}; expected {self._value.shape}") from error

    def _unitless(self, value: Any, what: str, limits: Limits = FINITE) -> Floats:
        """Return numbers in the unit of the measured value."""
        value = as_quantity(value, f"{what} of {self.name}")
        if is_quantity(value) != (self.unit is not None):
            expected = "a plain number" if self.unit is None else f"a unit such as {self.unit}"
            raise InvalidInput(f"{what} of {self.name} is {value!r}; expected {expected}")
        numbers = value if self.unit is None else strip_to(value, self.unit, f"{what} of {self.name}")
        return UNITLESS.numbers(numbers, "number", f"{what} of {self.name}", limits=limits)

    def emission(self, system: SystemLike) -> Any:
        """Return the times (K,) of a system's clock at which the function needs samples, in their order.

        Raises
        ------
        InvalidInput
            If the measured value has no times.
        """
        if self.times is None:
            raise InvalidInput(f"{self.name} has no times; give Measured(..., times=) to say when its run is sampled")
        times = to_system_times(self.times, system, f"times of {self.name}")
        return system.context.units.attach(np.sort(times.ravel()), "time")

    @property
    def value(self) -> Any:
        """The measured values (C,)."""
        return self._with_unit(self._value)

    @property
    def sigma(self) -> Any:
        """The standard errors (C,) of the measured values."""
        return self._with_unit(self._sigma)

    def _with_unit(self, values: Floats) -> Any:
        return values if self.unit is None else values * self.unit

    def _prediction(self, run: Record) -> Floats:
        result = np.atleast_1d(self._unitless(self.function(run), "the function's result"))
        if result.shape != self._value.shape:
            raise InvalidInput(f"the function of {self.name} gave shape {result.shape}; expected {self._value.shape}")
        return result

    def predict(self, run: Record) -> Any:
        """Return the value of the function for a run (C,), with the unit of the measured value."""
        return self._with_unit(self._prediction(run))

    def residuals(self, run: Record) -> Any:
        """Return the measured values minus the predictions (C,)."""
        return self._with_unit(self._value - self._prediction(run))

    def pulls(self, run: Record) -> Floats:
        """Return the residuals (C,) divided by the standard errors."""
        return np.asarray((self._value - self._prediction(run)) / self._sigma)

    def chi2(self, run: Record) -> float:
        """Return the sum of the squares of the :meth:`pulls`."""
        return float(np.sum(self.pulls(run) ** 2))

    def plot(self, run: Record, axes: Any = None, **kwargs: Any) -> Any:
        """Draw the measured values with their errors over the predictions of a run, and below them the residuals.

        Parameters
        ----------
        run : Run
        axes : array of matplotlib Axes, (2, 1), optional
        **kwargs
            Passed to ``Axes.errorbar``.

        Returns
        -------
        ndarray of Axes, (2, 1)
        """
        indices = np.arange(len(self._value)), "index of the value"
        return draw(indices, {self.name: (self.predict(run), self.residuals(run), self.sigma)}, axes, kwargs)

    def _tables(self) -> tuple[Table, ...]:
        return (Table(self.name, (), [("value", str(self.value)), ("sigma", str(self.sigma))]),)

    def __repr__(self) -> str:
        return f"Measured({self.name!r}, {self.value} +- {self.sigma})"
