"""A body alone: the closed forms of torque-free rotation (Landau & Lifshitz, Mechanics, section 37)."""

import fullbody
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation
from scipy.special import ellipj
from support import angle_between, inertia, rot_x, rot_z

AXES = (1.3, 1.0, 0.6)  # a > b > c, so that I_1 < I_2 < I_3
MASS = 2.5
MOMENTS = inertia(MASS, AXES)


def euler_frame(spin_momentum, phi):
    """Attitude with L along the inertial z: R = Rz(phi) Rx(theta) Rz(psi), from L in the body frame."""
    x, y, z = spin_momentum
    theta = np.arctan2(np.hypot(x, y), z)
    psi = np.arctan2(x, y)
    return rot_z(phi) @ rot_x(theta) @ rot_z(psi)


class Jacobi:
    """Spin of a triaxial body, exact; at t = 0 it has no y-component."""

    def __init__(self, moments, wx, wz):
        first, middle, last = moments
        energy2 = first * wx**2 + last * wz**2
        square = (first * wx) ** 2 + (last * wz) ** 2
        # Beyond the separatrix the roles of the first and last axis are exchanged.
        self.swapped = square < energy2 * middle
        if self.swapped:
            first, last = last, first
        self.momentum = np.sqrt(square)
        self.amplitudes = (
            np.sqrt((energy2 * last - square) / (first * (last - first))),
            np.sqrt((energy2 * last - square) / (middle * (last - middle))),
            np.sqrt((square - energy2 * first) / (last * (last - first))),
        )
        self.rate = np.sqrt((last - middle) * (square - energy2 * first) / (first * middle * last))
        self.m = (middle - first) * (energy2 * last - square) / ((last - middle) * (square - energy2 * first))

    def spin(self, t):
        sn, cn, dn, _ = ellipj(self.rate * np.asarray(t), self.m)
        values = [amplitude * f for amplitude, f in zip(self.amplitudes, (cn, sn, dn), strict=True)]
        return np.stack(values[::-1] if self.swapped else values)


def to_quaternion(frame):
    return np.roll(Rotation.from_matrix(frame).as_quat(), 1)


def alone(shape, frame, spin, until, times):
    body = fullbody.Body(shape, mass=MASS)
    attitude = [to_quaternion(frame)]
    state = fullbody.State([[1.0, -2.0, 3.0]], [[0.1, 0.2, -0.3]], attitude, [spin])
    return fullbody.System([body], G=1.0).integrate(state, until, output=times)


# Either side of the separatrix, near each stable axis and close to the separatrix itself.
SPINS = {"about x": (1.0, 0.2), "about z": (0.2, 1.0), "inside": (1.0, 0.45), "outside": (1.0, 0.9)}


@pytest.mark.parametrize("name", SPINS)
def test_a_triaxial_body_rotates_as_jacobis_functions(name):
    exact = Jacobi(MOMENTS, *SPINS[name])
    times = np.array([0.0, 0.7, 3.1, 11.0, 40.0, 100.0])
    spin = [SPINS[name][0], 0.0, SPINS[name][1]]
    frame = euler_frame(MOMENTS * spin, 0.0)
    run = alone(fullbody.Ellipsoid(*AXES), frame, spin, 100.0, times)
    assert np.abs(run.spin[:, 0] - exact.spin(times).T).max() < 2e-13
    assert np.abs(run.energy_drift).max() < 1e-14
    # The angular momentum keeps its direction in space, which ties the attitude to the spin; the turn about it is that
    # of an independent integration of the angle, dphi/dt = L (I_1 w_1^2 + I_2 w_2^2) / (I_1^2 w_1^2 + I_2^2 w_2^2).
    assert run.angular_momentum_drift.max() < 2e-14

    def rate(t):
        w, (i1, i2, _) = exact.spin(t), MOMENTS
        return exact.momentum * (i1 * w[0] ** 2 + i2 * w[1] ** 2) / ((i1 * w[0]) ** 2 + (i2 * w[1]) ** 2)

    for state in run[:5]:
        phi = quad(rate, 0.0, state.time, epsabs=1e-13, epsrel=1e-13, limit=500)[0]
        expected = euler_frame(MOMENTS * exact.spin(state.time), phi)
        assert angle_between(expected, state.rotation_matrix[0]) < 2e-12
    assert np.abs(run.position[-1, 0] - [11.0, 18.0, -27.0]).max() < 1e-13 * 27
    assert (run.velocity[-1, 0] == [0.1, 0.2, -0.3]).all()


@pytest.mark.parametrize("axes", [(1.0, 1.0, 0.4), (0.5, 0.5, 1.2)], ids=["oblate", "prolate"])
def test_a_symmetric_top_precesses_at_the_closed_form(axes):
    """L turns about the figure axis at -(I_3 - I_1) / I_1 w_3, and that axis about L at L / I_1."""
    across, _, along = moments = inertia(MASS, axes)
    spin = np.array([0.0, 0.6, 1.1])
    momentum = moments * spin
    length = np.linalg.norm(momentum)
    rate = (along - across) / across * spin[2]
    times = np.array([0.0, 1.0, 10.0, 77.0])
    run = alone(fullbody.Ellipsoid(*axes), euler_frame(momentum, 0.0), spin, 77.0, times)
    for state in run:
        t = state.time
        expected = np.array([-0.6 * np.sin(rate * t), 0.6 * np.cos(rate * t), 1.1])
        assert np.abs(state.spin[0] - expected).max() < 1e-13
        assert angle_between(euler_frame(moments * expected, length / across * t), state.rotation_matrix[0]) < 1e-12


def test_a_sphere_rotates_uniformly():
    spin = np.array([0.3, -0.5, 0.7])
    run = alone(fullbody.Sphere(0.8), np.eye(3), spin, 50.0, [50.0])
    assert np.abs(run.spin[0, 0] - spin).max() < 1e-15
    angle = np.linalg.norm(spin) * 50.0
    axis = spin / np.linalg.norm(spin)
    expected = [np.cos(angle / 2), *(np.sin(angle / 2) * axis)]
    assert min(np.abs(run.attitude[0, 0] - expected).max(), np.abs(run.attitude[0, 0] + expected).max()) < 1e-13
