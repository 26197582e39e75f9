"""Radar: ranges and range rates of centres of mass."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.unit_names import unit_named
from ..base.units import is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .columns import DataColumn, Rows, column, jitter_of, positive_rows, refuse_rounded
from .data import Observations
from .vectors import Vectors

_KINDS = {"range": ("length", "km"), "range_rate": ("velocity", "km/s")}


class RangeAndRate(NamedTuple):
    """Ranges (K,) and range rates (K,); one of the two is ``None`` if it was not observed."""

    range: Any
    range_rate: Any


class RadarAstrometry(Observations):
    """Ranges and range rates of a body's centre of mass, from the observer or relative to another body.

    The range is the distance from the body, at the time when it reflects the signal, to the observer, at the time when
    the echo arrives. The range rate is its derivative with respect to the time of arrival. The path to the body is
    taken to be as long as the path back.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the echo arrives.
    range, range_rate : array_like or Quantity, (K,), optional
        One of them or both. Plain numbers are in the system's units. Rows with masked or NaN values are left out, with
        a warning.
    sigma : float or Quantity, or a pair of them
        Standard errors, () or (K,) each: of the ranges and of the range rates, as a pair where both are given.
    body : int or str
        The observed body: its index in the system, or its name.
    about : int or str, optional
        The body whose range and range rate are subtracted; none for absolute values.
    geometry : Geometry

    Raises
    ------
    InvalidInput
        For errors that are not above zero, and for shapes that do not fit.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> view = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
    >>> times, ranges = [10.0, 11.0] * u.h, [0.0, 0.0] * u.km
    >>> data = observing.RadarAstrometry(times, range=ranges, sigma=75 * u.m, body="Beta", about="Alpha", geometry=view)
    >>> data.predict(system.integrate(state, 12.0, dense=True)).range.shape
    (2,)
    """

    _columns = tuple(DataColumn(name, errors=f"sigma_{name}", required=False) for name in _KINDS)
    _options = ("body", "about")

    def __init__(
        self,
        times: Any,
        *,
        range: Any = None,
        range_rate: Any = None,
        sigma: Any,
        body: int | str = 1,
        about: int | str | None = None,
        geometry: Vectors,
    ) -> None:
        columns = {name: value for name, value in (("range", range), ("range_rate", range_rate)) if value is not None}
        if not columns:
            raise InvalidInput("range and range_rate are not given; expected one of them or both")
        errors = _one_or_pair(sigma, "sigma", len(columns))
        self._units: dict[str, Any] = {}
        numbers: dict[str, Floats] = {}
        for (name, value), error in zip(columns.items(), errors, strict=True):
            values, unit = column(value, f"{name} of RadarAstrometry", _KINDS[name][1])
            sigmas, unit_of_error = column(error, f"sigma of {name} of RadarAstrometry", _KINDS[name][1])
            if (unit is None) != (unit_of_error is None):
                raise InvalidInput(f"only one of {name} and its sigma has a unit; expected both or neither")
            refuse_rounded(value, values, sigmas, f"{name} of RadarAstrometry")
            self._units[name] = unit
            numbers |= {name: values, f"sigma_{name}": sigmas}
        rows = Rows(times, numbers, tuple(columns), "RadarAstrometry")
        super().__init__(rows, geometry)
        self.body, self.about = body, about
        self._values = {name: rows.column(name) for name in columns}
        self._sigma = {
            name: positive_rows(rows.column(f"sigma_{name}"), f"sigma of {name} of RadarAstrometry") for name in columns
        }

    @classmethod
    def _arguments(cls, read: dict[str, Any]) -> dict[str, Any]:
        sigma = [read.pop(f"sigma_{name}") for name in _KINDS if name in read]
        return dict(sigma=sigma if len(sigma) == 2 else sigma[0], **read)

    def _column(self, name: str) -> Any:
        kind = name.removeprefix("sigma_")
        return self._with_unit(kind, (self._values if kind == name else self._sigma).get(kind))

    @property
    def range(self) -> Any:
        """The ranges (K,); ``None`` if they were not observed."""
        return self._column("range")

    @property
    def range_rate(self) -> Any:
        """The range rates (K,); ``None`` if they were not observed."""
        return self._column("range_rate")

    def _with_unit(self, name: str, values: Any) -> Any:
        unit = self._units.get(name)
        return values if unit is None else (values * unit_named(_KINDS[name][1])).to(unit)

    def _in_units_of(self, columns: dict[str, Floats], system: SystemLike) -> Floats:
        """Return columns of ranges and range rates (K, C) in a system's units."""
        quantities = ((name, self._with_unit(name, values), _KINDS[name][0]) for name, values in columns.items())
        strip = system.context.units.strip
        return np.stack(
            [strip(q, dimension, f"{name} of RadarAstrometry") for name, q, dimension in quantities], axis=1
        )

    def _add_jitter(self, jitter: Any) -> None:
        sigma = {}
        for name, value in zip(self._values, _one_or_pair(jitter, "jitter", len(self._values)), strict=True):
            if is_quantity(value) != (self._units[name] is not None):
                raise InvalidInput(f"only one of {name} and its jitter has a unit; expected both or neither")
            width = jitter_of(value, _KINDS[name][1] if is_quantity(value) else None)
            sigma[name] = np.hypot(self._sigma[name], width)
        self._sigma = sigma

    def _observed(self, system: SystemLike) -> Floats:
        return self._in_units_of(self._values, system)

    def _standard_errors(self, system: SystemLike) -> Floats:
        return self._in_units_of(self._sigma, system)

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        result: dict[str, Any] = dict.fromkeys(_KINDS)
        for name, numbers in zip(self._values, values.T, strict=True):
            part, unit = system.context.units.attach(numbers, _KINDS[name][0]), self._units[name]
            result[name] = part if unit is None or not is_quantity(part) else part.to(unit)
        return RangeAndRate(**result)

    @property
    def components(self) -> tuple[str, ...]:
        """The names of the numbers of a row: range, range rate or both."""
        return tuple(name.replace("_", " ") for name in self._values)

    def _by_name(self, attached: RangeAndRate) -> dict[str, Any]:
        return dict(zip(self.components, (getattr(attached, name) for name in self._values), strict=True))

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        if self.about is None:
            body, about = system.context.index(self.body, "body"), None
        else:
            body, about = system.context.pair(self.body, self.about, " of RadarAstrometry")
        retarded = self._retarded(system, states, masses)
        to_observer = retarded.observer[:, None] - retarded.centre
        distance = np.sqrt(np.einsum("...x,...x->...", to_observer, to_observer))
        result = {"range": distance}
        if "range_rate" in self._values:
            velocity = retarded.observer_velocity[:, None] - retarded.velocity
            direction = to_observer / distance[..., None]
            # The speed of light may be infinite, and complex numbers cannot be divided by infinity.
            beta = np.einsum("...x,...x->...", direction, retarded.velocity) * (1.0 / retarded.light_speed)
            result["range_rate"] = np.einsum("...x,...x->...", direction, velocity) / (1.0 - beta)
        columns = [result[name] for name in self._values]
        relative = [c[..., body] if about is None else c[..., body] - c[..., about] for c in columns]
        return np.stack(relative, axis=-1)

    def _summary(self) -> list[tuple[str, str]]:
        return [("observed", ", ".join(self._values)), *super()._summary()]


def _one_or_pair(values: Any, what: str, count: int) -> Any:
    """Return values for the ranges, for the range rates, or for both, which are a pair."""
    pair = values if count == 2 else (values,)
    if not isinstance(pair, tuple | list) or len(pair) != count:
        raise InvalidInput(f"{what} is not a pair; expected one for the ranges and one for the range rates")
    return pair
