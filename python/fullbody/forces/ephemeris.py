"""Paths of the Sun and the planets relative to a system on its orbit about the Sun."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import epochs, rotations
from ..base.unit_names import unit_named
from ..base.units import Units, is_quantity, need, numbers, strip_to
from ..errors import InvalidInput
from ..frames import rotation
from ..orbit.elements import KeplerElements
from ..typing import Floats

if TYPE_CHECKING:
    from astropy.time import Time

#: G times the mass in km^3/s^2, from DE440 (Park et al. 2021, table 2), for planets together with their satellites.
GM = {
    "sun": 132712440041.279419,
    "mercury": 22031.868551,
    "venus": 324858.592,
    "earth": 398600.435507,
    "moon": 4902.800118,
    "earth-moon-barycenter": 403503.235625,
    "mars": 42828.375816,
    "jupiter": 126712764.1,
    "saturn": 37940584.8418,
    "uranus": 5794556.4,
    "neptune": 6836527.10058,
    "pluto": 975.5,
}
#: The largest error of the cubic spline, relative to the distance.
_SPLINE_ERROR = 1e-9
#: The longest step in s of a table of a planet, a ninth of the month.
_MAX_PLANET_STEP = 3.0 * 86400.0
#: The number of rows beyond either end of the path, since a spline has larger errors near the ends of its table.
_MARGIN = 8
#: The maximum number of rows of a table.
_MAX_ROWS = 200_000


def path(
    name: Any, date: Any, orbit: Any, duration: Any, epoch: Any, ephemeris: Any, frame: Any, units: Any
) -> dict[str, Any]:
    """Compute name, mu, times and positions of a third body; see :meth:`fullbody.forces.ThirdBody.from_ephemeris`."""
    with need("units", "an ephemeris"):
        from astropy import units as u

    body = name.lower() if isinstance(name, str) else name
    if body not in GM:
        raise InvalidInput(f"name is {name!r}; expected one of {', '.join(GM)}")
    system_units = Units(units)
    start = epochs.date(date, "date")
    axes = _axes(frame)
    from_sun, max_step = about_sun(orbit, start, start if epoch is None else epochs.date(epoch, "epoch"), system_units)

    def relative(times: Floats) -> Floats:
        """Return positions (T, 3) in km relative to the system, at times (T,) in seconds from the date."""
        position = -from_sun(times)
        if body != "sun":
            dates = start + times * u.s
            planet = barycentric(body, dates, ephemeris) - barycentric("sun", dates, ephemeris)
            position += planet @ rotation("equatorial", "ecliptic").T
        return np.asarray(position @ axes.T)

    length = _seconds(duration, system_units)
    if body != "sun":
        max_step = min(max_step, _MAX_PLANET_STEP)
    span = min(length, 0.0), max(length, 0.0)
    times, positions = dense_table(relative, *span, max_step, f"duration of the path of {body}")
    # A rotation matrix has no name to compare with the frame of a system.
    frame_name = {"frame": frame} if isinstance(frame, str) else {}
    arguments = {"mu": GM[body] * u.km**3 / u.s**2, "times": times * u.s, "positions": positions * u.km}
    if system_units.defined:
        kinds = {"mu": "mu", "times": "time", "positions": "length"}
        arguments = {key: system_units.strip(value, kinds[key], key) for key, value in arguments.items()}
        arguments["mu"] = float(arguments["mu"])
    return {"name": body.title(), **arguments, **frame_name}


def dense_table(
    relative: Callable[[Floats], Floats], first: float, last: float, max_step: float, name: str, margin: int = _MARGIN
) -> tuple[Floats, Floats]:
    """Return times (T,) in even steps and positions (T, 3) for a cubic spline with an error of 1e-9 of the distance.

    The error of a spline between even knots is a 384th of the fourth difference. Fourth differences over steps of about
    a period do not show the motion, so that ``max_step`` limits the steps. ``relative`` returns positions at times; the
    table has ``margin`` rows before ``first`` and after ``last``; ``name`` is the subject of the error message.
    """
    step = min((last - first) / 64, max_step)
    while True:
        count = int(np.ceil((last - first) / step)) + 1
        if margin == 0:
            # Without a margin the last row is exactly at the end.
            step = (last - first) / (count - 1)
        count += 2 * margin
        if count > _MAX_ROWS:
            raise InvalidInput(f"{name} needs more than {_MAX_ROWS} rows; expected a shorter one")
        times = np.asarray(first + step * (np.arange(count) - margin), dtype=np.float64)
        positions = relative(times)
        fourth = np.linalg.norm(np.diff(positions, n=4, axis=0), axis=1)
        error = float((fourth / 384 / np.linalg.norm(positions[2:-2], axis=1)).max())
        # The first and the last pieces of a spline have larger errors.
        error *= 1.0 if margin else 10.0
        if error <= _SPLINE_ERROR:
            return times, positions
        # The error is proportional to the fourth power of the step.
        step *= min(0.9 * (_SPLINE_ERROR / error) ** 0.25, 0.9)


def about_sun(orbit: Any, start: Time, epoch: Time, system_units: Units) -> tuple[Callable[[Floats], Floats], float]:
    """Return the heliocentric motion of a system and an eighth of its period in seconds.

    The motion is a function from times (T,) in seconds after ``start`` to positions (T, 3) in km along the ecliptic of
    J2000. The elements are those at ``epoch``.
    """
    if not isinstance(orbit, KeplerElements):
        raise InvalidInput(f"orbit is {orbit!r}; expected the KeplerElements of the system about the Sun")
    if orbit.frame is not None and not (isinstance(orbit.frame, str) and orbit.frame == "ecliptic"):
        orbit = orbit.to_frame(target="ecliptic")
    if np.ndim(orbit.e) > 0:
        raise InvalidInput(f"orbit is {orbit!r}; expected the elements of one orbit")
    if is_quantity(orbit.a):
        a = float(strip_to(orbit.a, unit_named("km"), "semi-major axis of orbit"))
    elif system_units.defined:
        a = float((numbers(orbit.a, "semi-major axis of orbit") * system_units.unit("length")).to_value("km"))
    else:
        expected = "expected a Quantity, such as 1.6442 * u.au, or units=(...)"
        raise InvalidInput(f"semi-major axis of orbit is {orbit.a!r}; {expected}")
    angle = Units().number
    e, i, node, argument, mean = (angle(getattr(orbit, key), "angle", key) for key in ("e", "i", "Omega", "omega", "M"))
    rate = np.sqrt(GM["sun"] / abs(a) ** 3)
    elapsed = (start - epoch).to_value("s")

    def position_at(times: Floats) -> Floats:
        anomaly = mean + rate * (times + elapsed)
        if e < 1.0:
            anomaly = np.remainder(anomaly, 2 * np.pi)
        ones = np.ones_like(times)
        orbits = KeplerElements(a * ones, e * ones, i * ones, node * ones, argument * ones, anomaly)
        return np.asarray(orbits.to_cartesian(GM["sun"])[0])

    return position_at, 2 * np.pi / rate / 8 if e < 1.0 else np.inf


def barycentric(body: Any, times: Time, ephemeris: Any) -> Floats:
    """Return positions (T, 3) of a body from the barycentre of the solar system in km, along the axes of the ICRF."""
    from astropy.coordinates import get_body_barycentric

    with need(None, f"the ephemeris {ephemeris!r}"):
        if ephemeris != "builtin":
            import_module("jplephem")
        try:
            position = get_body_barycentric(body, times, ephemeris=ephemeris)
        except (AttributeError, KeyError, ValueError, TypeError, OSError) as error:
            raise InvalidInput(f"{body} is not available from the ephemeris {ephemeris!r}: {error}") from error
    return np.asarray(position.xyz.to_value("km").T, dtype=np.float64)


def _axes(frame: Any) -> Floats:
    """Return the matrix (3, 3) from the ecliptic of J2000 to the axes of the system."""
    if isinstance(frame, str):
        return rotation("ecliptic", frame)
    matrix = numbers(frame, "frame")
    if matrix.shape != (3, 3) or not rotations.is_rotation(matrix):
        raise InvalidInput(f"frame is {frame!r}; expected 'ecliptic', 'equatorial' or a rotation matrix (3, 3)")
    return matrix


def _seconds(duration: Any, system_units: Units) -> float:
    """Return a duration, a Quantity, text or a number in the system's unit of time, in seconds."""
    units = system_units if system_units.defined else Units(("km", "s", "kg"))
    number = units.number(duration, "time", "duration")
    if not is_quantity(duration) and not isinstance(duration, str) and not system_units.defined:
        raise InvalidInput(f"duration is {duration!r}; expected a Quantity, text such as '30 day', or units=(...)")
    if number == 0.0:
        raise InvalidInput("duration is 0; expected a time, below zero for runs back in time")
    return float((number * units.unit("time")).to_value("s"))
