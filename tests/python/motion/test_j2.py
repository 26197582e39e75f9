"""A small far satellite of an oblate primary precesses as first-order theory says, and the rest falls as its second.

Secular rates: Murray & Dermott (1999), Solar System Dynamics, eqs. 6.249-6.250; Vallado, Fundamentals of Astrodynamics,
eqs. 9-38 and 9-40. Per revolution, with p = a (1 - e^2),

    node:       -3 pi   J2 (R/p)^2 cos i
    periapsis:  3/2 pi  J2 (R/p)^2 (5 cos^2 i - 1).

A homogeneous spheroid has J2 R^2 = (I_33 - I_11) / m = (a^2 - c^2) / 5. What first order leaves out, second order in J2
and J4, is smaller by (R/p)^2: the relative difference falls with the square of the distance.
"""

import fullbody
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

A, C = 1.0, 0.6
J2_R2 = (A * A - C * C) / 5.0
E, INCLINATION = 0.2, np.deg2rad(40.0)
ORBITS = 12
DISTANCES = (20.0, 40.0, 80.0)


def osculating(run):
    """Node and argument of periapsis from position and velocity, by their textbook vectors; G m = 1."""
    r = run.position[:, 1] - run.position[:, 0]
    v = run.velocity[:, 1] - run.velocity[:, 0]
    h = np.cross(r, v)
    node = np.stack([-h[:, 1], h[:, 0], 0 * h[:, 0]], axis=1)
    node /= np.linalg.norm(node, axis=1)[:, None]
    periapsis = np.cross(v, h) - r / np.linalg.norm(r, axis=1)[:, None]
    across = np.cross(h / np.linalg.norm(h, axis=1)[:, None], node)
    argument = np.arctan2((periapsis * across).sum(axis=1), (periapsis * node).sum(axis=1))
    return np.unwrap(np.arctan2(node[:, 1], node[:, 0])), np.unwrap(argument), (r * v).sum(axis=1)


def advance_per_orbit(a):
    """Node's and periapsis' advance from one passage of the periapsis to the last, per revolution."""
    primary = fullbody.Body(fullbody.Ellipsoid(A, A, C), mass=1.0)
    # Light enough that the primary, at rest, is not turned; G m = 1.
    satellite = fullbody.Body(fullbody.PointMass(), mass=1e-15)
    system = fullbody.System([primary, satellite], G=1.0)
    r, v = fullbody.KeplerElements(a, E, INCLINATION, 0.3, 0.5, 0.0).to_cartesian(1.0)
    period = 2 * np.pi * a**1.5
    state = fullbody.State([[0, 0, 0], r], [[0, 0, 0], v])
    run = system.integrate(state, (ORBITS + 0.5) * period, output=period / 400)
    node, argument, radial = osculating(run)
    passage = CubicSpline(run.time, radial)
    end = brentq(passage, (ORBITS - 0.2) * period, (ORBITS + 0.2) * period, xtol=1e-12 * period)
    return [(CubicSpline(run.time, angle)(end) - angle[0]) / ORBITS for angle in (node, argument)]


def test_node_and_periapsis_precess_at_the_first_order_rate_but_for_the_square_of_the_distance():
    rows = []
    for a in DISTANCES:
        small = J2_R2 / (a * (1 - E * E)) ** 2
        cosine = np.cos(INCLINATION)
        theory = [-3 * np.pi * small * cosine, 1.5 * np.pi * small * (5 * cosine**2 - 1)]
        rows.append(np.array(advance_per_orbit(a)) / theory - 1)
    excess = np.abs(rows)
    # Second order is of the relative size J2 (R/p)^2: 3.5e-4 at the nearest distance, with factors of a few.
    assert (excess < 10 * J2_R2 / (np.array(DISTANCES)[:, None] * (1 - E * E)) ** 2).all()
    assert np.polyfit(np.log(DISTANCES), np.log(excess), 1)[0] == pytest.approx([-2.0] * 2, abs=0.05)
