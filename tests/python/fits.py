"""Setups and simulated observations for the tests of fits: 1999 KW4 by radar, Didymos by its light curves."""

import astropy.units as u
import fullbody
import numpy as np
from fullbody import observing
from scipy.spatial.transform import Rotation

#: An integrator whose error is far below those of the observations.
QUICK = fullbody.Verner98(rtol=1e-11, atol=1e-11)
#: In km^3 / (kg h^2).
G = 6.6743e-20 * 3600.0**2


def kw4(mass=2.353, ratio=0.0574, a=2.55, c=0.6735, tilt=0.05, roll=0.02, libration=0.05):
    """1999 KW4 with Alpha's mass in 1e12 kg, its shortest semi-axis and the separation in km, its turns about x and y.

    The mutual orbit lies in the plane of the ecliptic, and starts on the x-axis at the speed of a circle.
    """
    masses = mass * 1e12, ratio * mass * 1e12
    alpha = fullbody.Body(fullbody.Ellipsoid(0.766, 0.7475, c), mass=masses[0], name="Alpha")
    beta = fullbody.Body(fullbody.Ellipsoid(0.285, 0.2315, 0.1745), mass=masses[1], name="Beta")
    system = fullbody.System([alpha, beta], G=G, units=("km", "hour", "kg"), frame="ecliptic")
    speed = np.sqrt(G * sum(masses) / a)
    share = masses[1] / sum(masses)
    separate = np.array([-share, 1.0 - share])[:, None]
    state = fullbody.State(
        position=separate * [a, 0.0, 0.0],
        velocity=separate * [0.0, speed, 0.0],
        spin=[[0.0, 0.0, 2.273], [0.0, 0.0, speed / a]],
    )
    state = state.rotated(0, [1, 0, 0], tilt).rotated(0, [0, 1, 0], roll)
    return system, state.rotated(1, [0, 0, 1], libration)


def view(hours, sun=False, share=1.0):
    """A view of a system at a share of 0.05 au that goes some degrees along the sky."""
    ends = share * np.array([[0.05, 0.01, 0.02], [0.047, 0.017, 0.022]]) * u.au
    sunlight = {"to_sun": np.array([[0.9, 0.4, 0.1], [0.89, 0.42, 0.1]]) * u.au} if sun else {}
    return observing.Geometry([-hours, hours] * u.h, to_observer=ends, frame="ecliptic", **sunlight)


def noisy(rng, system, state, times, hours, **places):
    """Ranges and range rates, of Beta relative to Alpha unless others are named, 75 m and 1 cm/s, with their noise."""
    options = {"sigma": (75 * u.m, 1 * u.cm / u.s), "geometry": view(hours)} | (
        places or {"body": "Beta", "about": "Alpha"}
    )
    zero = np.zeros(len(times))
    plain = observing.Radar(times, range=zero * u.km, range_rate=zero * u.cm / u.s, **options)
    found = plain.predict(system.integrate(state, hours, plain.emission(system), QUICK))
    noise = rng.normal(size=(2, len(times)))
    return observing.Radar(
        times, range=found.range + noise[0] * 75 * u.m, range_rate=found.range_rate + noise[1] * u.cm / u.s, **options
    )


def dimorphos(b=0.87, c=0.66, longitude=310.0, latitude=-80.0, period=11.92, phase=0.0, **options):
    """Didymos with a moon of the semi-axes 1 : b : c in a circle; its pole in degrees of the ecliptic.

    The period of the orbit, in h, is that of a circle about a point.
    """
    a = 0.0885
    moon = fullbody.Body(fullbody.Ellipsoid(a, a * b, a * c), density=2.4e12, name="Dimorphos")
    didymos = fullbody.Body(fullbody.Ellipsoid(0.394, 0.394, 0.29), density=2.8e12, name="Didymos")
    system = fullbody.System([didymos, moon], G=G, units=("km", "hour", "kg"), frame="ecliptic", **options)
    total = float(system.masses.sum().value)
    rate = 2 * np.pi / period
    apart = (G * total / rate**2) ** (1 / 3)
    share = float(system.masses[1].value) / total
    separate = np.array([-share, 1.0 - share])[:, None]
    # From the plane of the orbit, where the moon is at the angle of the phase, to the ecliptic.
    turn = Rotation.from_euler("zyz", [phase, np.pi / 2 - np.radians(latitude), np.radians(longitude)])
    state = fullbody.State.from_scipy(
        position=turn.apply(separate * [apart, 0, 0]),
        velocity=turn.apply(separate * [0, apart * rate, 0]),
        rotation=Rotation.concatenate([turn, turn]),
        spin=[[0, 0, 2.78], [0, 0, rate]],
    )
    return system, state
