"""Mutual events of random binaries, for scans that share no formula with the program: here of polyhedra."""

import fullbody
import numpy as np
import pytest
from fullbody import observing
from scipy.spatial import ConvexHull
from support.meshes import icosphere

KINDS = ("occultation", "eclipse")


def binary(rng, shape=lambda axes: fullbody.Ellipsoid(*axes), **options):
    """Two bodies: thin, long, round and small ones, on any orbit, turning fast or slowly; a run, and its semi-axis."""
    axes = [[1.0, 0.7, 0.4], [1.0, 1.0, 0.05], [1.0, 0.15, 0.1], [1.0, 1.0, 1.0]]
    axes = [np.array(axes[rng.integers(4)]), 10 ** rng.uniform(-1.2, 0) * np.array(axes[rng.integers(4)])]
    mass = [1.0, rng.choice([1e-3, 0.1, 0.9])]
    bodies = [fullbody.Body(shape(a), mass=m, name=n) for a, m, n in zip(axes, mass, "AB", strict=True)]
    system = fullbody.System(bodies, G=1.0, gravity="point", **options)
    nearest, e = (axes[0][0] + axes[1][0]) * rng.choice([1.02, 1.5, 4.0]), rng.choice([0.0, 0.3, 0.7])
    a, mu = nearest / (1 - e), sum(mass)
    r, v = fullbody.KeplerElements(a, e, 0.0, 0.0, *rng.uniform(0, 6, 2)).to_cartesian(mu)
    motion = np.sqrt(mu / a**3)
    share = np.array([-mass[1], mass[0]]) / mu
    attitude = rng.normal(size=(2, 4))
    spin = rng.normal(size=(2, 3)) * motion * rng.choice([0.5, 3.0, 10.0])
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    state = fullbody.State(np.outer(share, r), np.outer(share, v), attitude, spin)
    # Long steps, for which short events are easily missed, and short ones.
    tolerance = rng.choice([1e-13, 1e-3])
    until = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.5) * 2 * np.pi / motion
    run = system.integrate(state, until, dense=True, output=[until], integrator=fullbody.Verner98(tolerance, tolerance))
    tilt = min(1.0, sum(x[0] for x in axes) / nearest * rng.choice([0.0, rng.uniform(0, 1.1), 1.0]))
    angles = rng.uniform(0, 2 * np.pi, 2)
    directions = [np.array([np.cos(t), np.sin(t), 0.0]) * np.sqrt(1 - tilt**2) + [0, 0, tilt] for t in angles]
    return axes, run, directions, a


def planar(d):
    """Two unit vectors across a direction, (2, 3)."""
    return np.linalg.svd(d[None])[2][1:]


def apart(vertices, states, d, i, j):
    """How far the origin is from the differences of two polygons' points; negative within. For polyhedra: (K,)."""
    rotation, plane = fullbody.base.rotations.matrices(states.attitude), planar(d)
    first, second = (
        (vertices[m] @ np.swapaxes(rotation[:, m], 1, 2) + states.position[:, m, None]) @ plane.T for m in (i, j)
    )
    vector = states.position[:, j] - states.position[:, i]
    radius = sum(np.linalg.norm(vertices[m], axis=1).max() for m in (i, j))
    margin = np.linalg.norm(vector @ plane.T, axis=1) - radius
    for k in np.flatnonzero(margin < 0):
        differences = (second[k][None] - first[k][:, None]).reshape(-1, 2)
        margin[k] = ConvexHull(differences).equations[:, 2].max()
    # The sides' distances bound that of the corners from below, with the same sign.
    return np.where(vector @ d > 0, margin, np.abs(margin) + 1e-3)


def spans(result, kind, body, ends, names=("begin", "end")):
    """Times between which a body is hidden, or totally hidden; an end that is unknown is that of the run."""
    pairs = [[getattr(event, name) for name in names] for event in result if (event.kind, event.body) == (kind, body)]
    return [[b if a is None else a for a, b in zip(pair, ends, strict=True)] for pair in pairs if pair != [None, None]]


def scan(function, states, ends, count, hidden, rounding=1e-7):
    """Compare times at which a function is negative with spans, and again finely about the least values."""

    def compare(at):
        margin = function(states(at))
        within = np.any([(at >= a) & (at <= b) for a, b in hidden], axis=0) if hidden else np.zeros(len(at), bool)
        wrong = (within != (margin < 0)) & (np.abs(margin) > rounding)
        assert not wrong.any(), (hidden, at[wrong][0], margin[wrong][0])
        return margin

    for contact in {time for span in hidden for time in span} - {*ends}:
        assert abs(function(states(np.array([contact])))[0]) < rounding, contact
    times = np.linspace(*ends, count)[1:-1]
    margin = compare(times)
    # Between times at which the outlines are nearly in touch there may be a shorter event.
    dips = np.flatnonzero((margin[1:-1] < 0.2) & (margin[1:-1] <= np.minimum(margin[:-2], margin[2:]))) + 1
    for k in dips[:12]:
        compare(np.linspace(times[k - 1], times[k + 1], 101))


def events(run, directions, far):
    """The mutual events of a run in constant directions, and the times of its ends."""
    view = {name: 1e3 * far * d for name, d in zip(("to_observer", "to_sun"), directions, strict=True)}
    ends = sorted([0.0, run.time[-1]])
    geometry = observing.Geometry([ends[0] - 1, ends[1] + 1], light_time=False, **view)
    return observing.mutual_events(run, geometry), ends


CASES = [(kind, k, i, 1 - i) for k, kind in enumerate(KINDS) for i in (0, 1)]


@pytest.mark.parametrize("seed", range(4))
def test_events_of_polyhedra_are_those_of_a_dense_scan(seed):
    def mesh(axes):
        return icosphere(0, axes)

    _, run, directions, scale = binary(np.random.default_rng(seed), mesh)
    vertices = [body.shape.vertices for body in run.system]
    result, ends = events(run, directions, scale)
    for kind, k, i, j in CASES:
        hidden = spans(result, kind, "AB"[i], ends)
        scan(lambda s, k=k, i=i, j=j: apart(vertices, s, directions[k], i, j), run.dense, ends, 401, hidden)
