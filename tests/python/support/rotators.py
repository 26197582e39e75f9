"""Light curves of bodies alone over years, on circular orbits about the Sun."""

import astropy.units as u
import fullbody
import numpy as np
from astropy.time import Time
from fullbody import observing

EPOCH = Time("1980-01-01", scale="tdb")
AXES = (2.3, 1.9, 1.6)
TRUE = {"longitude": 272 * u.deg, "latitude": 52 * u.deg, "period": 8.4006 * u.h, "angle": 30 * u.deg}


def setup(longitude, latitude, period, angle, acceleration=None):
    """An ellipsoid alone, with a constant change of its rate of rotation unless that is None."""
    body = fullbody.Body(fullbody.Ellipsoid(*AXES * u.km), mass="6e13 kg", name="Alone")
    forces = []
    if acceleration is not None:
        along = {"along": acceleration, "normalization": "acceleration"}
        forces = [fullbody.forces.Yorp(on="Alone", pole=[0.0, 0.0, 1.0], **along)]
    units = {"units": ("km", "hour", "kg"), "frame": "ecliptic", "epoch": EPOCH}
    system = fullbody.System([body], forces=forces, **units)
    return system, fullbody.State.rotating(body, longitude, latitude, period, angle)


def geometry(days, inclination=0.04):
    """Directions from a body at 2.5 au to the Earth and to the Sun, on circular orbits, at days since the epoch."""
    body, earth = (2.0 * np.pi * days / (365.25 * a**1.5) for a in (2.5, 1.0))
    position = 2.5 * np.stack([np.cos(body), np.sin(body), inclination * np.sin(body)], axis=1)
    observer = np.stack([np.cos(earth), np.sin(earth), 0.0 * earth], axis=1)
    view = {"to_observer": (observer - position) * u.au, "to_sun": -position * u.au, "frame": "ecliptic"}
    return observing.Geometry(EPOCH + days * u.day, **view)


def nights(count, years, rng, points=25):
    """Days since the epoch (K,) of nights near opposition, each of seven hours."""
    synodic = 1.0 / (1.0 - 2.5**-1.5)
    oppositions = 0.25 * 365.25 + 365.25 * synodic * rng.integers(0, int(years / synodic), count)
    starts = np.unique(np.round(oppositions + rng.uniform(-30.0, 30.0, count)))
    return np.concatenate([start + np.sort(rng.uniform(0.0, 0.3, points)) for start in starts])


def light_curves(system, state, days, sigma, rng, **options):
    """Magnitudes of the light curve with normally distributed errors."""
    view = geometry(days)
    start, last = EPOCH, EPOCH + (days[-1] + 1.0) * u.day
    run = system.integrate(state, (last - start).to("h"), dense=True)
    times = EPOCH + days * u.day
    magnitude = observing.light_curve(run, times, view) + rng.normal(0.0, sigma, len(days))
    return observing.Photometry(times, magnitude, sigma, geometry=view, **options)
