"""Tables of vectors to the observer and to the Sun: from orbits about the Sun, and from SPICE kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base.epochs import date, dates
from ..base.foreign import are_dates, shown
from ..base.units import Units, need
from ..errors import InvalidInput
from ..forces.ephemeris import about_sun, barycentric, dense_table
from ..frames import rotation
from ..model.context import SystemLike
from ..spice.state import loaded, message_of, spiceypy
from ..typing import Floats
from .times import LIGHT_SPEED, kilometres, seconds, system_epoch

#: The arguments of a geometry, and the ends of its span in s since the first row.
VectorTable = tuple[dict[str, Any], tuple[float, float]]
#: The longest step in s: a ninth of a month, or a twentieth of a day for an observer who rotates with the Earth.
_LONGEST, _LONGEST_ON_EARTH = 3.0 * 86400.0, 0.05 * 86400.0
#: The number of iterations of the light time, each of which gains four digits, those of c over the speed.
_ITERATIONS = 4


def from_orbit(orbit: Any, epoch: Any, observer: Any, ephemeris: Any, span: Any, light_time: bool) -> VectorTable:
    """Compute the vectors of an orbit; see :meth:`fullbody.observing.Geometry.from_orbit`."""
    with need("observing", "an orbit about the Sun"):
        start, length = _span(span)
    from_sun, longest = about_sun(orbit, start, date(epoch, "epoch"), Units())
    return _table(from_sun, start, length, observer, ephemeris, light_time, "ecliptic", longest)


def from_system(
    system: SystemLike, sun: str, observer: Any, ephemeris: Any, span: Any, light_time: bool
) -> VectorTable:
    """Compute the vectors of a system with a Sun; see :meth:`fullbody.observing.Geometry.from_system`."""
    what = "a geometry from the system's own Sun"
    epoch, second, km = system_epoch(system, what), seconds(system, what), kilometres(system, what)
    if system.context.frame is None:
        raise InvalidInput(f"{what} needs the system's frame; give fullbody.System(..., frame='ecliptic')")
    index = system.context.third_body(sun, "sun")
    start, length = _span(span)
    since_epoch = float((start - epoch).to_value("s"))

    def from_sun(times: Floats) -> Floats:
        return np.asarray(-km * system.context.core.third_body(index, (times + since_epoch) / second)[0])

    return _table(from_sun, start, length, observer, ephemeris, light_time, system.context.frame, np.inf)


def _table(
    from_sun: Callable[[Floats], Floats],
    start: Any,
    length: float,
    observer: Any,
    ephemeris: Any,
    light_time: bool,
    frame: Any,
    longest: float,
) -> VectorTable:
    """Return the vectors of a geometry for a system with a position relative to the Sun (km) by seconds."""
    from astropy import units as u
    from astropy.coordinates import EarthLocation

    to_frame = rotation("equatorial", frame)
    on_earth = isinstance(observer, EarthLocation)
    name = "earth" if on_earth else observer.lower() if isinstance(observer, str) else observer

    def observer_at(times: Floats) -> Floats:
        dates = start + times * u.s
        position = barycentric(name, dates, ephemeris)
        if on_earth:
            position = position + observer.get_gcrs_posvel(dates)[0].xyz.to_value("km").T
        return np.asarray(position @ to_frame.T)

    def sun_at(times: Floats) -> Floats:
        return np.asarray(barycentric("sun", start + times * u.s, ephemeris) @ to_frame.T + from_sun(times))

    def to_observer(times: Floats) -> Floats:
        """Return the vectors to the observer for light that arrives, or leaves, at these times."""
        fixed, moving, sign = (observer_at, sun_at, -1.0) if light_time else (sun_at, observer_at, 1.0)
        end, delay = fixed(times), np.zeros_like(times)
        for _ in range(_ITERATIONS):
            separation = end - moving(times + sign * delay)
            delay = np.linalg.norm(separation, axis=1) / LIGHT_SPEED
        return np.asarray(-sign * separation)

    step = min(longest, _LONGEST_ON_EARTH if on_earth else _LONGEST)
    times, vectors = dense_table(to_observer, 0.0, length, step, f"the span of the observer {observer!r}")
    emitted = times - np.linalg.norm(vectors, axis=1) / LIGHT_SPEED if light_time else times
    table = {"to_observer": vectors * u.km, "to_sun": -from_sun(emitted) * u.km, "frame": frame}
    return {"times": start + times * u.s, **table}, (-times[0], length - times[0])


def from_spice(target: Any, observer: Any, kernels: Sequence[Any], span: Any, light_time: bool) -> VectorTable:
    """Compute vectors from SPICE kernels; see :meth:`fullbody.observing.Geometry.from_spice`."""
    from astropy import units as u

    spice = spiceypy()
    start, length = _span(span)
    et = float((start.jd1 - 2451545.0) * 86400.0 + start.jd2 * 86400.0)

    def vectors(whose: str, origin: str, times: Floats, how: str) -> Floats:
        try:
            return np.array([spice.spkpos(whose, et + time, "J2000", how, origin)[0] for time in times])
        except spice.utils.exceptions.SpiceyError as error:
            what = f"the position of {whose} from {origin} between {start.isot} and {(start + length * u.s).isot}"
            raise InvalidInput(f"the kernels do not contain {what}: {message_of(error)}") from error

    target, observer = str(target), str(observer)

    def to_observer(times: Floats) -> Floats:
        # Light arrives at the observer at these times, or leaves the target towards the observer.
        return -vectors(target, observer, times, "CN") if light_time else vectors(observer, target, times, "XCN")

    with loaded(kernels):
        times, rows = dense_table(to_observer, 0.0, length, _LONGEST, f"the span of the observer {observer}", margin=0)
        emitted = times - np.linalg.norm(rows, axis=1) / LIGHT_SPEED if light_time else times
        to_sun = vectors("SUN", target, emitted, "NONE")
    table = {"to_observer": rows * u.km, "to_sun": to_sun * u.km, "frame": "equatorial"}
    return {"times": start + times * u.s, **table}, (0.0, length)


def _span(span: Any) -> tuple[Any, float]:
    """Return the first date of a span, TDB, and its length in s."""
    from astropy.time import TimeDelta

    moment = dates(span, "span")
    if not are_dates(moment) or isinstance(span, str):
        expected = "expected dates, such as ['2022-09-26 TDB', '2022-10-26 TDB'] or a Time"
        raise InvalidInput(f"span is {shown(span)}; {expected}")
    moments = np.atleast_1d(moment.tdb)
    first, last = moments.min(), moments.max()
    length = float((last - first).to_value("s"))
    # For a single date the span is a second about it.
    return (first, length) if length > 0.0 else (first - TimeDelta(1.0, format="sec"), 2.0)
