"""Setups and simulated observations for the tests of fits: two points and 1999 KW4 by radar, Didymos by its light."""

import functools

import astropy.units as u
import fullbody
import numpy as np
from fullbody import observing
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem
from scipy.spatial.transform import Rotation

from support.flows import central_of_state

#: An integrator whose error is far below those of the observations.
QUICK = fullbody.Verner98(rtol=1e-11, atol=1e-11)
#: The gravitational constant in km^3 / (kg h^2).
G = 6.6743e-20 * 3600.0**2


def kw4(mass=2.353, ratio=0.0574, a=2.55, c=0.6735, tilt=0.05, roll=0.02, libration=0.05, x=0.0, y=0.0):
    """1999 KW4 with Alpha's mass in 1e12 kg, shortest semi-axis and separation in km, and rotations about x and y.

    The mutual orbit starts at the speed of a circle, in the plane of the ecliptic, after a rotation of the system by
    the vector (x, y, 0).
    """
    masses = mass * 1e12, ratio * mass * 1e12
    alpha = fullbody.Body(fullbody.Ellipsoid(0.766, 0.7475, c), mass=masses[0], name="Alpha")
    beta = fullbody.Body(fullbody.Ellipsoid(0.285, 0.2315, 0.1745), mass=masses[1], name="Beta")
    system = fullbody.System([alpha, beta], G=G, units=("km", "hour", "kg"), frame="ecliptic")
    speed = np.sqrt(G * sum(masses) / a)
    share = masses[1] / sum(masses)
    separate = np.array([-share, 1.0 - share])[:, None]
    rotation = Rotation.from_rotvec([x, y, 0.0])
    return system, fullbody.State.from_scipy(
        position=rotation.apply(separate * [a, 0.0, 0.0]),
        velocity=rotation.apply(separate * [0.0, speed, 0.0]),
        rotation=[rotation * Rotation.from_euler("XY", [tilt, roll]), rotation * Rotation.from_euler("Z", libration)],
        spin=[[0.0, 0.0, 2.273], [0.0, 0.0, speed / a]],
    )


#: The geometry of radar observations of a pair of points.
VIEW = observing.Geometry([0.0, 100.0], to_observer=[1e3, 2e2, 4e2], light_time=False)


def pair(mass=2.353, a=2.55):
    """Two points without units, of which one starts in a circle about the other but for its speed."""
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (mass, 0.1)]
    system = fullbody.System(bodies, G=1.0, gravity="point")
    return system, fullbody.State(position=[[0.0] * 3, [a, 0, 0]], velocity=[[0.0] * 3, [0.1, 0.9, 0.3]])


#: Where fits of :func:`pair` start, near the values 2.353 and 2.55 of its observations.
START = {"mass": 2.36, "a": 2.545}


@functools.cache
def pair_radar():
    """Ranges and range rates of these points, as exact as 1e-2 of the orbit."""
    rng, (system, state) = np.random.default_rng(5), pair()
    options = {"sigma": (0.02, 0.01), "body": 1, "about": 0, "geometry": VIEW}
    times, zero = np.linspace(2.0, 30.0, 15), np.zeros(15)
    template = observing.RadarAstrometry(times, range=zero, range_rate=zero, **options)
    result = template.predict(system.integrate(state, 30.0, output=times))
    noise = rng.normal(size=(2, 15)) * [[0.02], [0.01]]
    return observing.RadarAstrometry(
        times, range=result.range + noise[0], range_rate=result.range_rate + noise[1], **options
    )


#: The number of rows of a geometry along a straight line, enough to tell it from an arc.
ROWS = 9


def view(hours, sun=False, share=1.0):
    """A view of a system at a share of 0.05 au that goes some degrees along the sky."""
    ends = share * np.array([[0.05, 0.01, 0.02], [0.047, 0.017, 0.022]]) * u.au
    sunlight = {"to_sun": np.linspace([0.9, 0.4, 0.1], [0.89, 0.42, 0.1], ROWS) * u.au} if sun else {}
    times = np.linspace(-hours, hours, ROWS) * u.h
    return observing.Geometry(times, to_observer=np.linspace(*ends, ROWS), frame="ecliptic", **sunlight)


def flyby(hours):
    """The vector to the Earth past 1999 KW4 in May 2001, on a straight line at 22 km/s: 0.0323 au away in mid-time."""
    nearest = 0.0323 * np.array([0.863, 0.505, 0.0]) * u.au
    displacement = np.array([9.6, -16.4, 10.9]) * u.km / u.s * (0.5 * hours * u.h)
    times = np.linspace(0.0, hours, ROWS) * u.h
    return observing.Geometry(
        times, to_observer=np.linspace(nearest - displacement, nearest + displacement, ROWS), frame="ecliptic"
    )


def noisy(rng, system, state, times, hours, **bodies):
    """Ranges and range rates, of Beta relative to Alpha unless others are named, 75 m and 1 cm/s, with their noise."""
    options = {"sigma": (75 * u.m, 1 * u.cm / u.s), "geometry": view(hours)} | (
        bodies or {"body": "Beta", "about": "Alpha"}
    )
    zero = np.zeros(len(times))
    template = observing.RadarAstrometry(times, range=zero * u.km, range_rate=zero * u.cm / u.s, **options)
    result = template.predict(system.integrate(state, hours, output=template.emission(system), integrator=QUICK))
    noise = rng.normal(size=(2, len(times)))
    return observing.RadarAstrometry(
        times, range=result.range + noise[0] * 75 * u.m, range_rate=result.range_rate + noise[1] * u.cm / u.s, **options
    )


def dimorphos(
    mass=5.28,
    polar=0.29,
    a=0.0885,
    b=0.87,
    c=0.66,
    longitude=310.0,
    latitude=-80.0,
    period=11.92,
    phase=0.0,
    roll=0.0,
    pitch=0.0,
    **options,
):
    """Didymos with a moon at rest in the frame that turns with the orbit, as tides leave it: it does not librate.

    The mass of Didymos is in 1e11 kg; its polar semi-axis and the longest one of the moon are in km, the moon's axes go
    as 1 : b : c. The pole is in degrees of the ecliptic, the period of the orbit in h.
    """
    didymos = fullbody.Body(fullbody.Ellipsoid(0.394, 0.394, polar), mass=mass * 1e11, name="Didymos")
    moon = fullbody.Body(fullbody.Ellipsoid(a, a * b, a * c), density=2.4e12, name="Dimorphos")
    pair = fullbody.System([didymos, moon], G=G)
    total, share, rate = pair.masses.sum(), pair.masses[1] / pair.masses.sum(), 2 * np.pi / period
    apart, still = (G * total / rate**2) ** (1 / 3), np.zeros((2, 3))
    for _ in range(4):
        # At rest the force is that which a circle needs; each pass leaves a hundredth of the error.
        force = -pair.interactions(fullbody.State([[0.0] * 3, [apart, 0.0, 0.0]], still)).force[1, 0]
        apart *= (force / (pair.masses[0] * share * apart * rate**2)) ** (1 / 3)
    separate = np.array([-share, 1.0 - share])[:, None]
    # The rotation from the plane of the orbit, in which the moon is at the angle of the phase, to the ecliptic.
    rotation = Rotation.from_euler("zyz", [phase, np.pi / 2 - np.radians(latitude), np.radians(longitude)])
    rotation = Rotation.from_rotvec([roll, pitch, 0.0], degrees=True) * rotation
    state = fullbody.State.from_scipy(
        position=rotation.apply(separate * [apart, 0, 0]),
        velocity=rotation.apply(separate * [0, apart * rate, 0]),
        rotation=Rotation.concatenate([rotation, rotation]),
        spin=[[0, 0, 2.78], [0, 0, rate]],
    )
    return fullbody.System(pair.bodies, G=G, units=("km", "hour", "kg"), frame="ecliptic", **options), state


def central_differences(problem, values, k, step):
    """Derivatives (R,) of all residuals with respect to parameter k, by fourth-order differences of complete runs."""
    return central_of_state(lambda change: problem.point(values + change * np.eye(len(values))[k]).rows, step)


def relative_errors(setup, start, observations, steps, measure=np.max):
    """A measure of the errors of the derivatives by some parameters, relative to the largest one, from differences.

    The steps of the differences are given by the names or the indices of the parameters. The light of facets has kinks
    where one of them reaches the limb, which few of the differences meet, so that the median of their errors is taken.
    """
    problem = Problem(setup, Parameters(start), observations, fullbody.Verner98())
    values = problem.parameters.start
    jacobian = problem.jacobian(problem.point(values))
    assert not jacobian.differenced
    errors = {}
    for name, step in steps.items():
        k = name if isinstance(name, int) else problem.parameters.names.index(name)
        expected = central_differences(problem, values, k, step)
        assert np.abs(expected).max() > 1e-7 / step
        errors[name] = float(measure(np.abs(jacobian.rows[:, k] - expected)) / np.abs(expected).max())
    return errors
