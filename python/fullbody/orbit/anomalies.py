"""Other words for the argument of periapsis and the mean anomaly of an orbit, with the conventions of REBOUND.

On a retrograde orbit (i > 90 degrees) longitudes are counted against the motion: pomega = Omega - omega, theta =
pomega - f and l = pomega - M (Rein & Liu 2012, Astron. Astrophys. 537, A128, and the documentation of REBOUND).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import warn_if_degrees
from ..base.units import UNITLESS
from ..errors import InvalidInput

_Array = npt.NDArray[np.float64]


def one_of(given: dict[str, Any]) -> str:
    """Return the name of the one value that is given, or raise an error if there is none or several."""
    names = [name for name, value in given.items() if value is not None]
    if len(names) != 1:
        found = f"both {' and '.join(names)}" if names else f"no {next(iter(given))}"
        raise InvalidInput(f"the elements have {found}; expected one of {', '.join(given)}")
    return names[0]


def usual_angles(e: Any, i: Any, Omega: Any, periapsis: dict[str, Any], anomaly: dict[str, Any]) -> tuple[Any, Any]:
    """Return the argument of periapsis and the mean anomaly, from the one of each that is given.

    Parameters
    ----------
    e, i, Omega
        The other elements.
    periapsis : dict
        The values of ``omega`` and ``pomega``, of which one is not ``None``.
    anomaly : dict
        The same for ``M``, ``f``, ``l`` and ``theta``.
    """
    kind, name = one_of(periapsis), one_of(anomaly)
    omega, M = periapsis["omega"], anomaly["M"]
    if kind == "omega" and name == "M":
        return omega, M
    values = periapsis | anomaly | {"i": i, "Omega": Omega}
    plain = {key: UNITLESS.strip(value, "angle", key) for key, value in values.items() if value is not None}
    e = UNITLESS.strip(e, "number", "e")
    for key in {kind, name} - {"omega", "M"}:
        if key == "pomega" or (e < 1.0).all():
            warn_if_degrees(values[key], key)
    sense = np.where(np.cos(plain["i"]) > 0.0, 1.0, -1.0)
    if kind == "pomega":
        plain["omega"] = omega = sense * (plain["pomega"] - plain["Omega"])
    if name != "M":
        # A longitude becomes an angle from periapsis.
        angle = plain[name] if name == "f" else sense * (plain[name] - plain["Omega"]) - plain["omega"]
        M = angle if name == "l" else mean_anomaly(angle, e)
    return omega, M


def mean_anomaly(f: Any, e: Any) -> _Array:
    """Return the mean anomaly of a true anomaly, by Kepler's equation of an ellipse or of a hyperbola."""
    f, e = np.broadcast_arrays(np.asarray(f, dtype=np.float64), np.asarray(e, dtype=np.float64))
    if (outside := 1.0 + e * np.cos(f) <= 0.0).any():
        one, of = f[outside][0], e[outside][0]
        limit = f"expected below {np.arccos(-1.0 / of):.6g} in size"
        raise InvalidInput(f"the true anomaly is {one:.6g} on a hyperbola of e = {of:.6g}; {limit}")
    sine, cosine = np.sqrt(np.abs(1.0 - e)) * np.sin(f / 2.0), np.sqrt(1.0 + e) * np.cos(f / 2.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        eccentric, hyperbolic = 2.0 * np.arctan2(sine, cosine), 2.0 * np.arctanh(sine / cosine)
        found = np.where(e < 1.0, eccentric - e * np.sin(eccentric), e * np.sinh(hyperbolic) - hyperbolic)
    return found[()]
