"""The light curve and the mutual events of each member in a night of the next apparition."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from fullbody import KeplerElements, State, Verner98, systems
from fullbody.observing import Geometry, LommelSeeliger, light_curve, mutual_events

from . import measures, model
from .inputs import IMPACT

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray

__all__ = ["NIGHT", "apparition", "night"]

#: The night for which events are predicted, near the greatest brightness while Hera is there.
NIGHT: Final = "2027-01-19T00:00:00"
#: The length of the light curve and the step between its points, hours.
HOURS: Final = 24.0
STEP: Final = 0.05


def apparition(dates: Any) -> Geometry:
    """Return the directions of the earth and the Sun from the system over some dates."""
    from astropy import units as u
    from astropy.time import Time

    published = systems.published("didymos_after_dart")
    a, e, *angles = published["heliocentric orbit (a, e, i, Omega, omega, M), ecliptic"]
    orbit = KeplerElements(a * u.au, e, *(angle * u.deg for angle in angles))
    epoch = Time(published["epoch of the heliocentric orbit"], format="jd", scale="tdb")
    return Geometry.from_orbit(orbit, epoch, span=dates)


def _geometry_in_hours(start: float, end: float) -> Geometry:
    """Return the geometry in km and hours since the impact, as systems without units take it."""
    from astropy import units as u
    from astropy.time import Time

    times = np.linspace(start - 24.0, end + 24.0, 60)
    dates = Time(IMPACT, scale="utc") + times * u.h
    geometry = apparition([dates[0], dates[-1]])
    vectors = (direction(dates[1:-1]).to_value("km") for direction in (geometry.to_observer, geometry.to_sun))
    return Geometry(times[1:-1], **dict(zip(("to_observer", "to_sun"), vectors, strict=True)), light_time=False)


def night(dataset: xarray.Dataset, members: npt.NDArray[np.intp]) -> dict[str, Any]:
    """Return light curves of some members over a day, from the middle of an occultation of Dimorphos by Didymos on.

    Returns
    -------
    dict
        ``time`` (T,) in hours from that middle; ``magnitude`` (M, T), reduced to unit distances and without its mean;
        ``shift`` (M,), the time of that middle after the beginning of the night; ``events``, a table of kinds and
        bodies with the middles and durations (M, 2) of the first of each kind after that middle; NaN for none.
    """
    night_start = measures.hours(NIGHT)
    geometry = _geometry_in_hours(measures.ARRIVAL_TIME, night_start + 3 * HOURS)
    time = np.arange(0.0, HOURS + STEP / 2, STEP)
    curves, shifts, events = [], [], []
    for member in members:
        row = dataset.isel(row=int(member))
        system, _ = model.setup(**{name: float(row[name]) for name in model.NAMES})
        position, velocity, attitude, spin = np.split(row.state.values, [3, 6, 10], axis=1)
        state = State(position, velocity, attitude, spin, time=measures.ARRIVAL_TIME)
        at_night = system.integrate(state, night_start, output="ends", integrator=Verner98(1e-9, 1e-9))[-1]
        run = system.integrate(at_night, night_start + 2.5 * HOURS, dense=True, integrator=Verner98(1e-9, 1e-9))
        member_events = mutual_events(run, geometry)
        middles = [
            event.middle
            for event in member_events
            if event.kind == "occultation" and event.body == "Dimorphos" and event.middle is not None
        ]
        if not middles:
            continue
        middle = middles[0]
        light = light_curve(run, middle + time, geometry, law=LommelSeeliger())
        curves.append(light - np.median(light))
        shifts.append(middle - night_start)
        events.append(_first_events(member_events, middle))
    kinds = sorted({kind for first in events for kind in first})
    missing = (np.nan, np.nan)
    return {
        "time": time,
        "magnitude": np.array(curves),
        "shift": np.array(shifts),
        "events": {kind: np.array([first.get(kind, missing) for first in events]) for kind in kinds},
    }


def _first_events(events: list[Any], middle: float) -> dict[str, tuple[float, float]]:
    """Return the first event of each kind and body from a time on: its middle after that time, and its duration."""
    result: dict[str, tuple[float, float]] = {}
    for event in events:
        if event.middle is not None and event.middle >= middle - 1e-9:
            result.setdefault(f"{event.kind} of {event.body}", (event.middle - middle, event.duration))
    return result
