"""The arguments of Kepler elements: mu with the units that it gives, and other angles by the conventions of REBOUND.

On a retrograde orbit (i > 90 degrees) longitudes are counted against the motion: pomega = Omega - omega, theta =
pomega - f and l = pomega - M (Rein & Liu 2012, Astron. Astrophys. 537, A128, and the documentation of REBOUND).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import warn_if_degrees
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, numbers, scalar, strip_to, units_of
from ..errors import InvalidInput

_Array = npt.NDArray[np.float64]


def mu_and_units(length: Any, mu: Any, what: str) -> tuple[float, Any, Any]:
    """Return mu as a number, and its units of length and of inverse time, which are ``None`` for plain numbers."""
    mu = as_quantity(mu, "mu", "mu")
    system = units_of(mu)
    if not is_quantity(length) and system is not None:
        # Plain numbers are in the units of the system to which mu belongs.
        return float(mu.value), system.unit("length"), 1 / system.unit("time")
    if is_quantity(length) != is_quantity(mu):
        names, unit = ((what, "mu"), length.unit) if is_quantity(length) else (("mu", what), mu.unit)
        raise InvalidInput(f"{names[0]} has the unit {unit}, but {names[1]} has none; expected both or neither")
    if not is_quantity(length):
        return scalar(numbers(mu, "mu"), "mu"), None, None
    strip_to(length, unit_named("m"), what)
    strip_to(mu, unit_named("m3 / s2"), "mu")
    # Results are in the unit of time in which mu is given.
    powers = zip(mu.unit.bases, mu.unit.powers, strict=True)
    rate = 1 / next((base for base, power in powers if base.is_equivalent("s") and power), unit_named("s"))
    return scalar(strip_to(mu, length.unit**3 * rate**2, "mu"), "mu"), length.unit, rate


def in_unit(unit: Any, value: Any, what: str) -> Any:
    """Return a value as numbers in a unit; plain numbers are taken to be in it already."""
    return strip_to(value, unit, what) if is_quantity(value) else numbers(value, what)


def single_name(values: dict[str, Any]) -> str:
    """Return the name of the only value that is not ``None``, or raise an error if there is none or several."""
    names = [name for name, value in values.items() if value is not None]
    if len(names) != 1:
        which = f"both {' and '.join(names)}" if names else f"no {next(iter(values))}"
        raise InvalidInput(f"the elements have {which}; expected one of {', '.join(values)}")
    return names[0]


def since_periapsis(a: Any, T: Any, mu: Any, time: Any) -> Any:
    """Return the mean anomaly at a time after a passage through periapsis: that of the mean motion, of either sign."""
    if mu is None:
        raise InvalidInput(f"mu is not given beside T, which is {T!r}; expected G times the sum of the masses")
    a = as_quantity(a, "a", "length")
    mu, length, rate = mu_and_units(a, mu, "a")
    times = []
    for name, value in (("time", time), ("T", T)):
        value = as_quantity(value, name, "time")
        if is_quantity(value) and rate is None:
            raise InvalidInput(f"{name} has the unit {value.unit}, but mu has none; expected both or neither")
        times.append(in_unit(None if rate is None else 1 / rate, value, name))
    return np.sqrt(mu / np.abs(in_unit(length, a, "a")) ** 3) * (times[0] - times[1])


def usual_angles(e: Any, i: Any, Omega: Any, periapsis: dict[str, Any], anomaly: dict[str, Any]) -> tuple[Any, Any]:
    """Return the argument of periapsis and the mean anomaly, from the only value of each kind that is not ``None``."""
    kind, name = single_name(periapsis), single_name(anomaly)
    omega, M = periapsis["omega"], anomaly["M"]
    if kind == "omega" and name == "M":
        return omega, M
    values = periapsis | anomaly | {"i": i, "Omega": Omega}
    radians = {key: UNITLESS.strip(value, "angle", key) for key, value in values.items() if value is not None}
    e = UNITLESS.strip(e, "number", "e")
    for key in {kind, name} - {"omega", "M"}:
        if key == "pomega" or (e < 1.0).all():
            warn_if_degrees(values[key], key)
    sense = np.where(np.cos(radians["i"]) > 0.0, 1.0, -1.0)
    if kind == "pomega":
        radians["omega"] = omega = sense * (radians["pomega"] - radians["Omega"])
    if name != "M":
        # A longitude becomes an angle from periapsis.
        angle = radians[name] if name == "f" else sense * (radians[name] - radians["Omega"]) - radians["omega"]
        M = angle if name == "l" else mean_anomaly(angle, e)
    return omega, M


def mean_anomaly(f: Any, e: Any) -> _Array:
    """Return the mean anomaly of a true anomaly, by Kepler's equation of an ellipse or of a hyperbola."""
    f, e = np.broadcast_arrays(np.asarray(f, dtype=np.float64), np.asarray(e, dtype=np.float64))
    if (outside := 1.0 + e * np.cos(f) <= 0.0).any():
        angle, eccentricity = f[outside][0], e[outside][0]
        limit = f"expected below {np.arccos(-1.0 / eccentricity):.6g} in size"
        raise InvalidInput(f"the true anomaly is {angle:.6g} on a hyperbola of e = {eccentricity:.6g}; {limit}")
    sine, cosine = np.sqrt(np.abs(1.0 - e)) * np.sin(f / 2.0), np.sqrt(1.0 + e) * np.cos(f / 2.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        eccentric, hyperbolic = 2.0 * np.arctan2(sine, cosine), 2.0 * np.arctanh(sine / cosine)
        mean = np.where(e < 1.0, eccentric - e * np.sin(eccentric), e * np.sinh(hyperbolic) - hyperbolic)
    return mean[()]
