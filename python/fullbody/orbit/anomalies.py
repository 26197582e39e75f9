"""Other words for the argument of periapsis and the mean anomaly of an orbit, with the conventions of REBOUND.

On a retrograde orbit (i > 90 degrees) longitudes are counted against the motion: pomega = Omega - omega, theta =
pomega - f and l = pomega - M (Rein & Liu 2012, Astron. Astrophys. 537, A128, and the documentation of REBOUND).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import warn_if_degrees
from ..base.units import UNITLESS, as_quantity, is_quantity
from ..errors import InvalidInput
from .parameter import in_unit, mu_and_units

_Array = npt.NDArray[np.float64]


def single_name(values: dict[str, Any]) -> str:
    """Return the name of the one value that is given, or raise an error if there is none or several."""
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
