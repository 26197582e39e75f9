"""Observers and Suns that are near: contacts and light beside rays that are cast, and beside Kepler's motion."""

from types import SimpleNamespace

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.observing.brightness import Epochs, Photometer
from scipy.optimize import brentq
from support import body_list, refused
from test_random_events import CASES, KINDS, binary, scan, spans

#: The speed of light, km/s.
C = 299792.458
#: The number of rays that graze a body.
COUNT = 120


def rotations(states):
    return fullbody.base.rotations.matrices(states.attitude)


def rays(axes, states, eye, i, j, angle):
    """The distances of the centre of j, in its unit sphere, from rays that graze body i at angles (K, M)."""
    # In the unit sphere of body i the rays touch it on a circle about the direction to the point.
    p = np.einsum("kab,ka->kb", rotations(states)[:, i], eye - states.position[:, i]) / axes[i]
    square = np.sum(p * p, axis=1)[:, None]
    first = np.cross(p, np.eye(3)[np.argmin(np.abs(p), axis=1)])
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(p, first) / np.sqrt(square)
    around = np.cos(angle)[..., None] * first[:, None] + np.sin(angle)[..., None] * second[:, None]
    circle = (p / square)[:, None] + np.sqrt(1 - 1 / square)[..., None] * around
    touched = np.einsum("kab,kmb->kma", rotations(states)[:, i], circle * axes[i]) + states.position[:, i, None]
    start, end = (
        np.einsum("kab,kma->kmb", rotations(states)[:, j], x - states.position[:, j, None]) / axes[j]
        for x in (np.broadcast_to(eye, touched.shape), touched)
    )
    vector = (end - start) / np.linalg.norm(end - start, axis=-1, keepdims=True)
    return np.linalg.norm(np.cross(start, vector), axis=-1)


def least(axes, states, eye, i, j, sign=1.0):
    """The least of these, or of their opposites, over all rays, on a grid that is refined."""
    middle, width = np.zeros((len(states.position), 1)), np.pi
    for count in (COUNT + 1, 41, 41, 41):
        angle = middle + np.linspace(-width, width, count)
        values = sign * rays(axes, states, eye, i, j, angle)
        middle = np.take_along_axis(angle, np.argmin(values, axis=1)[:, None], axis=1)
        width = 2 * width / (count - 1)
    return values.min(axis=1)


def in_front(states, eye, i, j):
    """Whether body j is nearer to the point than body i, for bodies whose spheres are apart."""
    distance = np.linalg.norm(states.position - eye, axis=2)
    return distance[:, j] < distance[:, i]


def overlap(axes, states, eye, i, j):
    """Negative where body j hides a part of body i: a ray that grazes one of them meets the other one."""
    margin = np.minimum(least(axes, states, eye, i, j), least(axes, states, eye, j, i)) - 1
    return np.where(in_front(states, eye, i, j), margin, np.abs(margin) + 1e-3)


def excess(axes, states, eye, i, j):
    """Negative where body j hides all of body i: all rays that graze i meet j."""
    margin = -least(axes, states, eye, i, j, -1.0) - 1
    return np.where(in_front(states, eye, i, j), margin, np.abs(margin) + 1e-3)


def near_events(seed):
    """A binary seen, and lit, from points at 1.1 to 1000 times its radius, with its mutual events."""
    rng = np.random.default_rng(1000 + seed)
    axes, run, directions, _ = binary(rng, units=("km", "s", "kg"))
    ends = sorted([0.0, float(run.time[-1].value)])
    at = run.dense(np.linspace(*ends, 400) * u.s)
    radius = max(np.linalg.norm(at.position[:, k], axis=1).max().value + axes[k].max() for k in (0, 1))
    eyes = [d / np.linalg.norm(d) * radius * rng.choice([1.1, 1.5, 5.0, 1e3]) for d in directions]
    view = {name: eye * u.km for name, eye in zip(("to_observer", "to_sun"), eyes, strict=True)}
    geometry = observing.Geometry([ends[0] - 1, ends[1] + 1] * u.s, light_time=False, **view)
    result = observing.mutual_events(run, geometry)
    return axes, run, eyes, ends, result


def states_of(run):
    """States of a run at times in numbers, about the barycentre."""
    weights = run.context.masses / run.context.masses.sum()

    def states(at):
        result = run.dense.core.states(np.ascontiguousarray(at))
        centre = result["position"] - np.einsum("n,knx->kx", weights, result["position"])[:, None]
        return SimpleNamespace(position=centre, attitude=result["attitude"])

    return states


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("seed", range(12))
def test_events_from_near_are_those_of_rays(seed):
    axes, run, eyes, ends, results = near_events(seed)
    results = [numbers(event) for event in results]
    for kind, k, i, j in CASES:
        hidden = spans(results, kind, "AB"[i], ends)
        scan(lambda s, k=k, i=i, j=j: overlap(axes, s, eyes[k], i, j), states_of(run), ends, 201, hidden)
        total = spans(results, kind, "AB"[i], ends, ("total_begin", "total_end"))
        for contact in {time for span in total for time in span} - {*ends}:
            assert abs(excess(axes, states_of(run)(np.array([contact])), eyes[k], i, j)[0]) < 1e-7
        for begin, end in hidden:
            at = np.linspace(begin, end, 53)[1:-1]
            inside = excess(axes, states_of(run)(at), eyes[k], i, j) < -1e-7
            within = np.any([(at >= a) & (at <= b) for a, b in total], axis=0) if total else np.zeros(len(at), bool)
            assert not (inside & ~within).any() or (inside.all() and [begin, end] == ends)


def numbers(event):
    """An event whose times are numbers."""
    names = ("begin", "end", "total_begin", "total_end")
    times = {name: None if getattr(event, name) is None else getattr(event, name).value for name in names}
    return observing.MutualEvent(event.kind, event.body, event.by, **times)


def kepler(t, a, e, n, share):
    """Position (3,) of a body of a Kepler pair at time t after periapsis, in 80-bit numbers."""
    mean = np.longdouble(n) * np.longdouble(t)
    anomaly = mean + e * np.sin(mean)
    for _ in range(8):
        anomaly -= (anomaly - e * np.sin(anomaly) - mean) / (1 - e * np.cos(anomaly))
    return share * a * np.array([np.cos(anomaly) - e, np.sqrt(1 - np.longdouble(e) ** 2) * np.sin(anomaly), 0])


WIDE = {"a": 80_000.0, "e": 0.2, "n": 1e-4}
SHARES, RADII = (-0.3, 0.7), (3000.0, 2000.0)


def wide(start):
    """A binary 80,000 km wide as a system with its state at a time, km, s and kg."""
    a, e, n = WIDE.values()
    bodies = body_list(**{k: (fullbody.Sphere(r), m) for r, m, k in zip(RADII, (0.7, 0.3), "AB", strict=True)})
    options = {"units": ("km", "s", "kg"), "frame": "ecliptic", "epoch": "2026-01-01 TDB"}
    system = fullbody.System(bodies, G=n**2 * a**3, gravity="point", **options)
    r, v = fullbody.KeplerElements(a, e, 0.0, 0.0, 0.0, n * start).to_cartesian(n**2 * a**3)
    return system, fullbody.State(np.outer(SHARES, r), np.outer(SHARES, v), time=start)


def retarded(arrival, eye, k):
    """Where body k was when the light left it that arrives at a point, and that time."""
    left = np.longdouble(arrival)
    for _ in range(6):
        position = kepler(left, *WIDE.values(), SHARES[k])
        left = arrival - np.sqrt(np.sum((eye - position) ** 2)) / C
    return position, left


def separation(vectors):
    """The angle between two spheres seen along these vectors from their centres, less that at contact."""
    distances = [np.sqrt(np.sum(vector**2)) for vector in vectors]
    units = [vector / length for vector, length in zip(vectors, distances, strict=True)]
    angle = 2 * np.arcsin(np.sqrt(np.sum((units[0] - units[1]) ** 2)) / 2)
    return float(angle - sum(np.arcsin(radius / length) for radius, length in zip(RADII, distances, strict=True)))


#: Observer and Sun, km, at 0.05 au and 0.4 au.
EYE, SUN = np.array([3.0e6, 6.5e6, 2.0e5]), np.array([-2.0e7, -5.5e7, 1.0e6])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", KINDS)
def test_contacts_in_a_wide_system_are_those_of_keplers_motion(kind):
    geometry = observing.Geometry([-1e5, 1e6] * u.s, to_observer=EYE * u.km, to_sun=SUN * u.km)

    def occultation(arrival):
        return separation([EYE - retarded(arrival, EYE, k)[0] for k in (0, 1)])

    def eclipse(passing):
        # Sunlight that passes the barycentre at this time passes each body at its own.
        vectors = []
        for k in (0, 1):
            time = np.longdouble(passing)
            for _ in range(6):
                vector = kepler(time, *WIDE.values(), SHARES[k]) - SUN
                time = passing + (np.sqrt(np.sum(vector**2)) - np.sqrt(np.sum(SUN**2))) / C
            vectors.append(vector)
        return separation(vectors)

    function = occultation if kind == "occultation" else eclipse
    delay = np.sqrt(np.sum(EYE**2)) / C if kind == "occultation" else 0.0
    times = np.linspace(0, 6e4, 400)
    values = [function(time + delay) for time in times]
    k = next(k for k in range(399) if values[k] > 0 > values[k + 1])
    expected = brentq(lambda time: function(time + delay), times[k], times[k + 1], xtol=1e-13, rtol=1e-15)
    system, state = wide(expected - 600.0)
    run = system.integrate(state, duration=2000.0, dense=True, integrator=fullbody.Verner98(1e-15, 1e-15))
    event = next(passage for passage in observing.mutual_events(run, geometry) if passage.kind == kind)
    behind = "AB".index(event.body)
    if kind == "occultation":
        assert event.begin.to_value("h") == pytest.approx((expected + delay) / 3600, abs=1e-12, rel=0)
    # A run that watches for the contact finds it at the time at the barycentre.
    condition = observing.occultation(system, geometry, event.body, event.by, kind=kind, direction=-1, terminal=True)
    stopped = system.integrate(state, duration=2000.0, events=[condition], integrator=fullbody.Verner98(1e-15, 1e-15))
    assert stopped.time[-1].to_value("h") == pytest.approx(expected / 3600, abs=1e-12, rel=0)
    if kind == "eclipse":
        # The light leaves the body that is hidden when it passes it.
        time = arrival = np.longdouble(expected)
        for _ in range(6):
            position = kepler(time, *WIDE.values(), SHARES[behind])
            time = expected + (np.sqrt(np.sum((position - SUN) ** 2)) - np.sqrt(np.sum(SUN**2))) / C
            arrival = time + np.sqrt(np.sum((EYE - position) ** 2)) / C
        assert event.begin.to_value("h") == pytest.approx(float(arrival) / 3600, abs=1e-12, rel=0)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("dense", [True, False])
def test_astrometry_of_a_wide_system_is_that_of_keplers_motion(dense):
    geometry = observing.Geometry([0, 1e6] * u.s, to_observer=EYE * u.km)
    times = [2000.0, 5000.0, 20000.0] * u.s
    data = observing.Astrometry(
        times, *np.zeros((2, 3)) * u.rad, 1 * u.mas, body="B", about="A", geometry=geometry, frame="ecliptic"
    )
    system, state = wide(1000.0)
    options = {"dense": True} if dense else {"output": data.emission(system)}
    run = system.integrate(state, 25000.0, integrator=fullbody.Verner98(1e-15, 1e-15), **options)
    for result, time in zip(data.predict(run).to_value("rad"), times.value, strict=True):
        vectors = [retarded(time, EYE, k)[0] - EYE for k in (0, 1)]
        direction = vectors[0] / np.sqrt(np.sum(vectors[0] ** 2))
        east = np.array([-direction[1], direction[0], 0]) / np.hypot(direction[0], direction[1])
        north = np.cross(direction, east)
        depth = direction @ vectors[1]
        expected = np.array([east @ vectors[1], north @ vectors[1]]) / depth
        assert np.abs(result - expected).max() < 2e-12 * np.abs(expected).max()


def cast(axes, position, rotation, eye, sun, i, hiders, count=40_000):
    """Lommel-Seeliger's light of body i at the origin's distances, by rays from points of its surface."""
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    angle = np.pi * (1 + 5**0.5) * np.arange(count)
    sphere = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)
    points = (sphere * axes[i]) @ rotation[i].T + position[i]
    normal = (sphere / axes[i]) @ rotation[i].T
    area = 4 * np.pi / count * np.prod(axes[i]) * np.linalg.norm(normal, axis=1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    cosines, share, free = [], np.ones(count), np.ones(count, dtype=bool)
    for point in (eye, sun):
        vector = point - points
        distance = np.linalg.norm(vector, axis=1)
        cosines.append(np.sum(normal * vector, axis=1) / distance)
        share *= np.sum(point**2) / distance**2
        for j in hiders:
            start, along = (points - position[j]) @ rotation[j] / axes[j], vector @ rotation[j] / axes[j]
            a, b, c = np.sum(along**2, axis=1), np.sum(start * along, axis=1), np.sum(start**2, axis=1) - 1
            free &= ~((b < 0) & (b * b > a * c))
    mu, mu0 = (np.maximum(cosine, 0) for cosine in cosines)
    return np.sum(np.where(free, mu * mu0 / np.maximum(mu + mu0, 1e-30), 0) * area * share)


def test_light_from_near_is_that_of_rays_up_to_the_size_of_bodies_over_the_distance():
    rng = np.random.default_rng(5)
    axes = np.array([[1.0, 0.8, 0.6], [0.5, 0.45, 0.3]])
    bodies = [fullbody.Body(fullbody.Ellipsoid(*a), mass=1.0, name=n) for a, n in zip(axes, "AB", strict=True)]
    photometer = Photometer(fullbody.System(bodies, G=1.0), observing.LommelSeeliger(), 1.0, True, 0.0)
    worst, differing = 0.0, 0
    for _ in range(24):
        # The second body is in front of the first one by a third of the distance, or far aside.
        eye, sun = np.array([520.0, 0.0, 0.0]), rng.normal(size=3) * 300 + [1500.0, 0, 0]
        axis = (eye, sun)[rng.integers(2)]
        first = rng.normal(size=3) * 20
        second = first + (axis - first) * rng.uniform(0.02, 0.3) + rng.normal(size=3) * rng.choice([0.4, 30.0])
        position, attitude = np.array([first, second]), rng.normal(size=(2, 4))
        attitude /= np.linalg.norm(attitude, axis=1)[:, None]
        rotation = fullbody.base.rotations.matrices(attitude)
        epoch = np.zeros(1), position[None], attitude[None], eye[None], sun[None], None
        finite, infinite = (photometer.brightness(Epochs(*epoch, distant))[0] for distant in (False, True))
        free, expected = (
            [cast(axes, position, rotation, eye, sun, k, hiders) for k, hiders in enumerate(hiding)]
            for hiding in ([[], []], [[1], [0]])
        )
        worst = max(worst, np.abs((finite - expected) / free).max())
        differing += np.abs((infinite - expected) / free).max() > 0.02
    assert worst < 2 / 300
    # One direction for both bodies would be wrong.
    assert differing > 10


@pytest.mark.filterwarnings("ignore")
def test_a_run_that_comes_as_near_as_the_observer_is_refused():
    system, state = fullbody.systems.didymos(units=True)
    view = observing.Geometry([-1.0, 30.0] * u.h, to_observer=[0.9, 0.0, 0.0] * u.km)
    condition = observing.occultation(system, view, "Dimorphos", "Didymos")
    message = r"distance of the observer, or the Sun, from the barycentre at time 0 is 0\."
    refused(message, system.integrate, state, 13 * u.h, events=[condition])
    run = system.integrate(state, 13 * u.h, dense=True)
    refused("the observer of the geometry is too near", observing.mutual_events, run, view)
