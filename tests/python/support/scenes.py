"""Shared systems of the tests of external forces: a pair under a Sun, a single body, formulas in longdouble."""

import fullbody
import numpy as np
from fullbody.forces import Byorp, Function, ThirdBody, Tide, Yorp

from support import body_list

#: The pair has a = 1 and n = 1.
G = 1.0


def pair(mass=1e-2, small=(0.12, 0.10, 0.08), **options):
    """An oblate primary and a synchronous triaxial secondary at distance one, the first state in the xy-plane."""
    bodies = body_list(A=(fullbody.Ellipsoid(0.3, 0.29, 0.25), 1.0 - mass), B=(fullbody.Ellipsoid(*small), mass))
    system = fullbody.System(bodies, G=G, **options)
    r, v = np.array([1.0, 0, 0]), np.array([0, 1.0, 0.1])
    state = fullbody.State(
        [-mass * r, (1 - mass) * r], [-mass * v, (1 - mass) * v], spin=[[0.3, -0.2, 5.0], [0.0, 0.05, 1.0]]
    )
    return system, state


def sun(**options):
    """A third body whose tide on the pair is some 1e-4 of the pair's own attraction."""
    orbit = fullbody.KeplerElements(2000.0, 0.3, 0.4, 1.0, 2.0, 0.3)
    return ThirdBody(**({"mu": 1e6, "orbit": orbit, "of": "system", "name": "Sun"} | options))


def drag(time, state):
    """A force that depends on time, position and velocity, and a torque."""
    force = -1e-5 * state.velocity + 1e-6 * np.cos(0.3 * time) * state.position
    return force, -1e-6 * state.spin


#: One of each kind, as functions of nothing, for a pair.
KINDS = {
    "Sun": sun,
    "tide": lambda: Tide(on="A", by="B", k2=0.3, lag=0.1, name="tide"),
    "YORP": lambda: Yorp(on="A", along=1e-6, across=2e-6, name="YORP"),
    "BYORP": lambda: Byorp(on="B", about="A", force=1e-6, name="BYORP"),
    "own": lambda: Function(drag, name="own"),
}


def body_alone(shape=None, mass=1.0, spin=(0.0, 0.0, 1.0), attitude=(1.0, 0, 0, 0)):
    """One body at rest at the origin."""
    shape = fullbody.Ellipsoid(1.0, 0.8, 0.5) if shape is None else shape
    system = fullbody.System([fullbody.Body(shape, mass=mass, name="A")], G=G)
    return system, fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]], attitude=[attitude], spin=[spin])


def at_rest(position, mu, name="Sun", span=1e3):
    """A third body that stands still: a table of one position."""
    times = np.linspace(-span, span, 5)
    return ThirdBody(mu=mu, times=times, positions=np.tile(position, (5, 1)), of="body", name=name)


def relative(run):
    """Position and velocity of the second body from the first, (K, 6)."""
    both = np.concatenate([run.position, run.velocity], axis=2)
    return both[:, 1] - both[:, 0]


def kepler_position(elements, mu, time):
    """Position on an ellipse or hyperbola by Newton's method in longdouble (Murray & Dermott 1999, Sec. 2.4)."""
    a, e, i, node, argument, mean = (np.longdouble(x) for x in elements)
    mean = mean + np.sqrt(np.longdouble(mu) / abs(a) ** 3) * np.longdouble(time)
    x = mean if e < 1 else np.arcsinh(mean / e)
    for _ in range(60):
        if e < 1:
            change = (x - e * np.sin(x) - mean) / (1 - e * np.cos(x))
        else:
            change = (e * np.sinh(x) - x - mean) / (e * np.cosh(x) - 1)
        x = x - change
        if abs(change) <= 1e-18 * abs(x):
            break
    if e < 1:
        plane = np.array([a * (np.cos(x) - e), a * np.sqrt(1 - e * e) * np.sin(x)])
    else:
        plane = np.array([a * (np.cosh(x) - e), -a * np.sqrt(e * e - 1) * np.sinh(x)])
    cn, sn, ci, si, cw, sw = (f(t) for t in (node, i, argument) for f in (np.cos, np.sin))
    axes = np.array(
        [
            [cn * cw - sn * sw * ci, -cn * sw - sn * cw * ci],
            [sn * cw + cn * sw * ci, -sn * sw + cn * cw * ci],
            [sw * si, cw * si],
        ]
    )
    return axes @ plane


def differential(r, p, mu):
    """The acceleration of a point at r relative to the origin by a mass at p: the difference, in longdouble."""
    r, p = np.asarray(r, dtype=np.longdouble), np.asarray(p, dtype=np.longdouble)
    d = p - r
    return mu * (d / np.sqrt(d @ d) ** 3 - p / np.sqrt(p @ p) ** 3)
