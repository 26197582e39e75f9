"""Mutual events of random binaries beside a dense scan of their outlines, by formulas that the program does not use."""

import fullbody
import numpy as np
import pytest
from fullbody import observing

KINDS = ("occultation", "eclipse")


def binary(rng):
    """Two ellipsoids: thin, long, round and small ones, on any orbit, turning fast or slowly; a run, and its period."""
    axes = [[1.0, 0.7, 0.4], [1.0, 1.0, 0.05], [1.0, 0.15, 0.1], [1.0, 1.0, 1.0]]
    axes = [np.array(axes[rng.integers(4)]), 10 ** rng.uniform(-1.2, 0) * np.array(axes[rng.integers(4)])]
    mass = [1.0, rng.choice([1e-3, 0.1, 0.9])]
    bodies = [fullbody.Body(fullbody.Ellipsoid(*a), mass=m, name=n) for a, m, n in zip(axes, mass, "AB", strict=True)]
    system = fullbody.System(bodies, G=1.0, gravity="point")
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


def overlap(axes, states, d, i, j):
    """How far outline i is from that of j before it, by the function of Perram & Wertheim less one: (K,)."""
    plane = np.linalg.svd(d[None])[2][1:]
    turn = fullbody.base.rotations.matrices(states["attitude"][:, [i, j]])
    first, second = (
        np.einsum("xa,kab,b,kcb,yc->kxy", plane, turn[:, m], axes[k] ** 2, turn[:, m], plane)
        for m, k in enumerate((i, j))
    )
    way = states["position"][:, j] - states["position"][:, i]
    r = way @ plane.T

    def function(s):
        mixed = (1 - s)[:, None, None] * first + s[:, None, None] * second
        return s * (1 - s) * np.einsum("kx,kx->k", r, np.linalg.solve(mixed, r[..., None])[..., 0])

    low, high, golden = np.zeros(len(r)), np.ones(len(r)), (np.sqrt(5) - 1) / 2
    for _ in range(60):
        left, right = high - golden * (high - low), low + golden * (high - low)
        up = function(left) > function(right)
        low, high = np.where(up, low, left), np.where(up, right, high)
    margin = np.sqrt(function(0.5 * (low + high))) - 1
    # Bodies whose spheres are apart are in the order of their centres.
    return np.where(way @ d > 0, margin, np.abs(margin) + 1e-3)


@pytest.mark.parametrize("seed", range(16))
def test_events_are_those_of_a_dense_scan(seed):
    axes, run, directions, far = binary(np.random.default_rng(seed))
    view = {name: 1e3 * far * d for name, d in zip(("to_observer", "to_sun"), directions, strict=True)}
    first, last = sorted([0.0, run.time[-1]])
    found = observing.mutual_events(run, observing.Geometry([first - 1, last + 1], light_time=False, **view))
    times = np.linspace(first, last, 1501)[1:-1]
    for kind, d in zip(KINDS, directions, strict=True):
        for i, j in ((0, 1), (1, 0)):
            spans = [
                (first if one.begin is None else one.begin, last if one.end is None else one.end)
                for one in found
                if (one.kind, one.body) == (kind, "AB"[i])
            ]

            def compare(at, kind=kind, d=d, i=i, j=j, spans=spans):
                margin = overlap(axes, run.dense._core.states(at), d, i, j)
                within = np.any([(at >= a) & (at <= b) for a, b in spans], axis=0) if spans else np.zeros(len(at), bool)
                wrong = (within != (margin < 0)) & (np.abs(margin) > 1e-7)
                assert not wrong.any(), (kind, i, spans, at[wrong][0], margin[wrong][0])
                return margin

            margin = compare(times)
            # Between times at which the outlines are nearly in touch there may be a shorter event.
            dips = np.flatnonzero((margin[1:-1] < 0.2) & (margin[1:-1] <= np.minimum(margin[:-2], margin[2:]))) + 1
            for k in dips[:12]:
                compare(np.linspace(times[k - 1], times[k + 1], 101))
