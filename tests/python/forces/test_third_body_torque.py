"""Torque and force of a third body on one with extent: near, far, by the third law, and the precession that follows."""

import fullbody
import mpmath as mp
import numpy as np
import pytest
from fullbody.forces import ThirdBody
from support import matrix, worst
from support.scenes import at_rest, body_alone

AXES = (1.0, 0.8, 0.5)
ATTITUDE = (0.5, 0.1, -0.7, 0.5)
DIRECTION = np.array([0.48, -0.6, 0.64])


def exact(axes, mass, x, mu):
    """Force beyond that on a point, and torque, in the body frame and 50 digits, on a body with the point mass at x.

    Minus the pull of the ellipsoid on the point (MacMillan 1930, Sec. 32, in Carlson's form).
    """
    with mp.workdps(50):
        a2 = [mp.mpf(float(a)) ** 2 for a in axes]
        x = [mp.mpf(float(c)) for c in x]
        r2 = mp.fsum(c * c for c in x)
        # 1/s(kappa) is nearly linear, so that Newton's method in it needs no more steps than digits to double.
        kappa = r2 - mp.fsum(a * c * c for a, c in zip(a2, x, strict=True)) / r2
        for _ in range(40):
            s = mp.fsum(c * c / (a + kappa) for a, c in zip(a2, x, strict=True))
            slope = mp.fsum(c * c / (a + kappa) ** 2 for a, c in zip(a2, x, strict=True))
            step = (1 - 1 / s) * s * s / slope
            kappa += step
            if abs(step) < mp.mpf(10) ** -48 * kappa:
                break
        s = [a + kappa for a in a2]
        rd = [mp.elliprd(s[(k + 1) % 3], s[(k + 2) % 3], s[k]) for k in range(3)]
        g = [-c * r for c, r in zip(x, rd, strict=True)]
        strength = mp.mpf(float(mass)) * mp.mpf(float(mu))
        excess = [-strength * (gi + c / r2 ** mp.mpf(1.5)) for gi, c in zip(g, x, strict=True)]
        torque = [-strength * (x[(k + 1) % 3] * g[(k + 2) % 3] - x[(k + 2) % 3] * g[(k + 1) % 3]) for k in range(3)]
        return np.array([float(v) for v in excess]), np.array([float(v) for v in torque])


def loads(distance, axes=AXES, mass=2.0, mu=3.0, direction=DIRECTION):
    """The force and torque that the system gives, the point mass at x in the body frame, and the rotation."""
    q = np.array(ATTITUDE) / np.linalg.norm(ATTITUDE)
    rotation = matrix(q)
    point = distance * rotation @ direction / np.linalg.norm(direction)
    system, state = body_alone(fullbody.Ellipsoid(*axes), mass=mass, attitude=q)
    reported = system.with_forces([at_rest(point, mu)]).loads(state)["Sun"]
    return reported.force[0], reported.torque[0], rotation.T @ point, rotation


@pytest.mark.parametrize("distance", [1.05, 1.3, 2.0, 5.0, 17.0, 100.0, 1e4, 1e8, 1e12])
@pytest.mark.parametrize("axes", [AXES, (1.0, 1.0, 0.3), (1.0, 0.2, 0.2), (1.0, 0.99999, 0.99998)])
def test_the_torque_keeps_its_digits_near_and_far(distance, axes):
    _, torque, x, _ = loads(distance, axes)
    _, expected = exact(axes, 2.0, x, 3.0)
    # Near the body it is the difference of two of Carlson's integrals.
    assert worst(torque, expected) < (1e-14 if distance < 10 else 3e-15)


@pytest.mark.parametrize("distance", [1.05, 1.3, 2.0, 5.0, 17.0, 100.0, 1e4, 1e8])
def test_the_force_beyond_that_on_a_point_is_the_exact_one(distance):
    force, _, x, rotation = loads(distance)
    expected, _ = exact(AXES, 2.0, x, 3.0)
    assert worst(rotation.T @ force, expected) < 3e-15 * max(1.0, 20.0 / np.log10(distance + 1))


@pytest.mark.parametrize("distance", [1.6, 2.5, 6.0])
def test_a_massive_point_exerts_the_same_loads(distance):
    """By the third law, torque and force are those of a system of this body and a point."""
    force, torque, x, rotation = loads(distance)
    bodies = [fullbody.Body(fullbody.Ellipsoid(*AXES), mass=2.0), fullbody.Body(fullbody.PointMass(), mass=3.0)]
    point = rotation @ x
    q = np.array(ATTITUDE) / np.linalg.norm(ATTITUDE)
    state = fullbody.State([[0, 0, 0], point], np.zeros((2, 3)), attitude=[q, [1, 0, 0, 0]])
    for gravity in ("surface", "focal"):
        both = fullbody.System(bodies, G=1.0, gravity=gravity).interactions(state)
        assert worst(torque, both.torque[0]) < 1e-13
        assert worst(force + 2.0 * 3.0 * point / distance**3, both.force[0]) < 1e-13
        assert worst(-force - 2.0 * 3.0 * point / distance**3, both.force[1]) < 1e-13


# Effect of the torque: the spin axis precesses about the normal of the orbit.


@pytest.mark.parametrize("e", [0.0, 0.4])
@pytest.mark.parametrize("obliquity", [25.0, 140.0])
def test_an_oblate_body_precesses_at_the_secular_rate(e, obliquity):
    """The rate is -(3/2) n_s^2/omega H cos eps (1 - e^2)^(-3/2); what is left out is n_s/omega times as large."""
    n_s, omega, c = 1.0, 400.0, 0.9
    H = (1 - c * c) / 2
    eps = np.radians(obliquity)
    # Far away, so that the next order of the field is 1e-10 of it; mu = n_s^2 a^3, the body's own mass aside.
    a = 1e5
    attitude = (np.cos(eps / 2), np.sin(eps / 2), 0, 0)
    system, state = body_alone(fullbody.Ellipsoid(1.0, 1.0, c), spin=(0, 0, omega), attitude=attitude)
    third = ThirdBody(mu=n_s**2 * a**3 - 1.0, orbit=fullbody.KeplerElements(a, e, 0, 0, 0.5, 0.3), of="system")
    year = 2 * np.pi / n_s
    integrator = fullbody.Verner98(rtol=1e-10, atol=1e-10)
    run = system.with_forces([third]).integrate(state, year, output=[0.0, year], integrator=integrator)
    pole = run.angular_momentum
    node = np.arctan2(pole[:, 1], pole[:, 0])
    expected = -1.5 * n_s**2 / omega * H * np.cos(eps) * (1 - e * e) ** -1.5
    assert np.diff(node)[0] / year == pytest.approx(expected, rel=10 * n_s / omega)
    # The obliquity comes back.
    tilt = np.arctan2(np.hypot(pole[:, 0], pole[:, 1]), pole[:, 2])
    assert np.diff(tilt)[0] == pytest.approx(0.0, abs=10 * n_s / omega * abs(expected) * year)
