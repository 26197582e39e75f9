"""The parameters of a fit: their initial values, units, bounds and priors."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import argument_names, suggestion
from ..base.limits import LARGEST, SMALLEST, Limits
from ..base.units import UNITLESS, gathered, is_quantity, refuse_booleans, strip_to
from ..base.values import ByName
from ..errors import InvalidInput
from ..typing import Floats

_RANGE = Limits(least=-LARGEST, most=LARGEST, text=f"a finite number, of at most {LARGEST} in size")
_SIGMA = Limits(least=SMALLEST, text=f"a number above zero, at least {SMALLEST}")


@dataclass(frozen=True)
class Free:
    """A parameter of a fit: its initial value, and the prior knowledge of it.

    Parameters
    ----------
    value : float, Quantity or text with a unit
        The initial value.
    min, max : float or Quantity, optional
        Bounds; none unless given.
    prior : (mean, sigma), optional
        Mean and standard error of a normal distribution, which enters as one more residual.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.Free(0.1, min=0.0, max=1.0)
    Free(value=0.1, min=0.0, max=1.0, prior=None)
    """

    value: Any
    _: KW_ONLY
    min: Any = None
    max: Any = None
    prior: Any = None


class Parameters:
    """Parameters as arrays (P,) of plain numbers, each in the unit of its start, ``None`` without one.

    Bounds ``lower`` and ``upper`` are infinite where there are none, and so is ``sigma`` of a prior.
    """

    def __init__(self, given: Any) -> None:
        if not isinstance(given, Mapping) or not given:
            raise InvalidInput(f"parameters is {given!r}; expected a dict of names to starts, one or more")
        given = argument_names(given)
        free = [value if isinstance(value, Free) else Free(value) for value in given.values()]
        self.names = tuple(given)
        starts = [gathered(one.value, f"start of {name}") for name, one in zip(self.names, free, strict=True)]
        self.units = tuple(value.unit if is_quantity(value) else None for value in starts)
        self.start = np.array([self._number(k, value, "start") for k, value in enumerate(starts)])
        self.lower, self.upper, self.mean, self.sigma = (np.empty(len(free)) for _ in range(4))
        for k, one in enumerate(free):
            self.lower[k] = -np.inf if one.min is None else self._number(k, one.min, "min")
            self.upper[k] = np.inf if one.max is None else self._number(k, one.max, "max")
            if not self.lower[k] < self.upper[k]:
                raise InvalidInput(f"bounds of {self.names[k]} are {one.min} and {one.max}; expected min < max")
            if not self.lower[k] <= self.start[k] <= self.upper[k]:
                raise InvalidInput(
                    f"start of {self.names[k]} is {one.value}; expected one between {one.min} and {one.max}"
                )
            self.mean[k], self.sigma[k] = self._prior(k, one.prior)

    def _number(self, k: int, value: Any, what: str) -> float:
        what, unit = f"{what} of {self.names[k]}", self.units[k]
        refuse_booleans(value, what)
        value = gathered(value, what)
        if is_quantity(value) != (unit is not None):
            expected = "a plain number" if unit is None else f"a unit such as {unit}"
            raise InvalidInput(f"{what} is {value!r}; expected {expected}, as its start has")
        return UNITLESS.number(value if unit is None else strip_to(value, unit, what), "number", what, _RANGE)

    def _prior(self, k: int, prior: Any) -> tuple[float, float]:
        if prior is None:
            return 0.0, np.inf
        try:
            mean, sigma = prior
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"prior of {self.names[k]} is {prior!r}; expected (mean, sigma)") from error
        found = self._number(k, mean, "mean of the prior"), self._number(k, sigma, "sigma of the prior")
        UNITLESS.number(found[1], "number", f"sigma of the prior of {self.names[k]}", _SIGMA)
        return found

    def __len__(self) -> int:
        return len(self.names)

    def only(self, names: Sequence[str]) -> Parameters:
        """Return the parameters with these names, in the same order."""
        found, places = copy.copy(self), [self.names.index(name) for name in names]
        found.names, found.units = tuple(names), tuple(self.units[k] for k in places)
        for what in ("start", "lower", "upper", "mean", "sigma"):
            setattr(found, what, getattr(self, what)[places])
        return found

    def extended(self, names: Sequence[str], units: Sequence[Any]) -> Parameters:
        """Return these parameters and further ones, which have neither bounds nor priors."""
        found = copy.copy(self)
        found.names, found.units = (*self.names, *names), (*self.units, *units)
        for what, value in (("start", 0.0), ("lower", -np.inf), ("upper", np.inf), ("mean", 0.0), ("sigma", np.inf)):
            setattr(found, what, np.append(getattr(self, what), np.full(len(names), value)))
        return found

    def named(self, values: Floats) -> dict[str, Any]:
        """Return values (P,), or columns (P, n), by their names with their units."""
        plain = (float(value) if np.ndim(value) == 0 else value for value in values)
        parts = zip(self.names, self.units, plain, strict=True)
        return ByName({name: value if unit is None else value * unit for name, unit, value in parts})

    def numbers(self, values: Any) -> Floats:
        """Return the plain numbers (P,) of values by their names, or of an array in the order of the names."""
        if not isinstance(values, Mapping):
            expected = Limits(text=f"{len(self)} finite numbers, or a dict by names")
            return UNITLESS.numbers(values, "number", "values", (len(self),), expected)
        for name in values:
            if name not in self.names:
                raise InvalidInput(f"values has {name!r}; {suggestion(str(name), self.names, 'all')}")
        if missing := [name for name in self.names if name not in values]:
            raise InvalidInput(f"values has no {missing[0]!r}; expected all of {', '.join(self.names)}")
        return np.array([self._number(k, values[name], "value") for k, name in enumerate(self.names)])

    def shifted(self, values: Floats, k: int, by: float) -> Floats:
        """Return values (P,) of which one is shifted, or raise an error if that is beyond its bounds."""
        moved = values.copy()
        moved[k] += by
        if not self.lower[k] <= moved[k] <= self.upper[k]:
            raise InvalidInput(f"{self.names[k]} is beyond its bounds")
        return moved

    def full_turn(self, k: int) -> float:
        """Return the number by which a parameter changes in a turn, if it is an angle."""
        unit = self.units[k]
        if unit is None:
            return 2.0 * np.pi
        return float((1.0 * unit).to_value("rad") ** -1) * 2.0 * np.pi if self.is_angle(k) else np.inf

    def is_angle(self, k: int) -> bool:
        """Return whether a parameter has a unit of angle."""
        return getattr(self.units[k], "physical_type", None) == "angle"

    def size(self, k: int, value: float) -> float:
        """Return a length over which the results of a setup are smooth, as far as it is known: a radian for angles."""
        if self.is_angle(k):
            return self.full_turn(k) / (2.0 * np.pi)
        return max(abs(value), abs(self.start[k])) or self.width(k)

    def width(self, k: int) -> float:
        """Return a length for a parameter that is zero: the error of its prior, the width of its bounds, or one."""
        lengths = (self.sigma[k], self.upper[k] - self.lower[k])
        return next((float(length) for length in lengths if np.isfinite(length)), 1.0)

    def at_bounds(self, values: Floats, norms: Floats) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Return which values are at their bounds: within 0.05 of the errors 1 / norms and 0.01 of the width."""
        near = np.divide(0.05, norms, out=np.zeros_like(norms), where=norms > 0.0)
        near = np.minimum(near, 0.01 * (self.upper - self.lower))
        return values - self.lower <= near, self.upper - values <= near

    def shown(self, k: int, value: float) -> str:
        """Return a parameter's value as text, with its unit."""
        return f"{value:.8g}" if self.units[k] is None else f"{value:.8g} {self.units[k]}"
