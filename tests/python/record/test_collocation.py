"""Integration of tangent vectors: closed forms, symplecticity, units of length and mass, samples within steps."""

import fullbody
import numpy as np
import pytest
from scipy.linalg import expm
from support import pair_of_points, worst
from support.flows import TIGHT, scaled, scales, tumbling

COARSE = [
    fullbody.DormandPrince54(rtol=1e-2, atol=1e-2),
    fullbody.Verner65(rtol=1e-3, atol=1e-3),
    fullbody.Verner76(rtol=1e-3, atol=1e-3),
    fullbody.Verner87(rtol=1e-2, atol=1e-2),
    fullbody.Verner98(rtol=1e-2, atol=1e-2),
]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_lone_body_turns_about_a_principal_axis(axis):
    # The variational equations have constant coefficients: an exponential solves them. For the middle axis it grows.
    body = fullbody.Body(fullbody.Ellipsoid(1.0, 0.6, 0.1), mass=1.0)
    system = fullbody.System([body], G=1.0)
    spin = np.zeros(3)
    spin[axis] = 3.0
    state = fullbody.State([np.zeros(3)], [np.zeros(3)], [[1.0, 0.0, 0.0, 0.0]], [spin])
    time = 2.0
    run = system.integrate(state, time, output=[0.7, time], integrator=TIGHT, derivatives=True)
    for k, t in enumerate(run.time):
        assert worst(run.transition[k], expm(t * system.jacobian(state).rates)) < 1e-12


@pytest.mark.parametrize("integrator", COARSE, ids=lambda integrator: type(integrator).__name__)
def test_matrices_of_points_are_symplectic_along_any_motion(integrator):
    # Whatever the error of the motion; some of the steps are too long for the sweeps and are divided.
    system, state = pair_of_points(0.7)
    run = system.integrate(state, 30.0, output=[3.0, 30.0], integrator=integrator, derivatives=True)
    form = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    for phi in run.transition:
        relative = phi[12:18, 12:18] - phi[0:6, 12:18]
        size = np.abs(relative).max() ** 2
        assert worst(relative.T @ form @ relative, form, size) < 1e-13


def all_parameters(system):
    return [name for name in system.parameters if not name.startswith("density")]


def test_matrices_scale_with_units_of_length_and_mass():
    # In units of length that are smaller by a factor f all places, velocities and semi-axes are f times as large, and G
    # f^3 times; in such units of mass all masses are f times as large, and G 1/f times.
    system, state = tumbling()
    run = system.integrate(state, 12.0, output="ends", integrator=TIGHT, derivatives=all_parameters(system))
    value = {"G": float(system.G)}
    for body in system.bodies:
        value[f"mass of {body.name}"] = body.mass
        value |= {f"semi-axis {axis} of {body.name}": getattr(body.shape, axis) for axis in "abc"}
    assert value.keys() == run.sensitivity.keys()

    def with_weight(weights):
        return sum(
            weight * value[name] * change[1]
            for name, change in run.sensitivity.items()
            for start, weight in weights.items()
            if name.startswith(start)
        )

    def centres(state):
        both = zip(state.position, state.velocity, strict=True)
        return np.concatenate([np.concatenate([r, v, np.zeros(6)]) for r, v in both])

    size = scales(system, state)
    moved = run.transition[1] @ centres(run[0]) + with_weight({"G": 3.0, "semi-axis": 1.0})
    assert worst(moved / size, centres(run[1]) / size) < 1e-11
    assert worst(with_weight({"mass": 1.0}) / size, with_weight({"G": 1.0}) / size) < 1e-11


def test_a_sample_within_a_step_is_the_end_of_a_run():
    system, state = tumbling()
    times = [1.03, 1.07, 2.9]
    within = system.integrate(state, 4.0, output=times, integrator=TIGHT, derivatives=["G"], chaos=True)
    for k, time in enumerate(times):
        ended = system.integrate(state, time, output="ends", integrator=TIGHT, derivatives=["G"], chaos=True)
        both = [scaled(phi, system, state) for phi in (within.transition[k], ended.transition[-1])]
        assert worst(*both) < 1e-12
        assert worst(within.sensitivity["G"][k], ended.sensitivity["G"][-1]) < 1e-12
        for name in ("megno", "lyapunov", "fast_lyapunov"):
            assert worst(getattr(within, name)[k], getattr(ended, name)[-1]) < 1e-7


def test_samples_change_no_bits():
    system, state = tumbling()
    few = system.integrate(state, 4.0, output="ends", derivatives=["G"], chaos=True)
    many = system.integrate(state, 4.0, output=0.11, derivatives=["G"], chaos=True)
    assert np.array_equal(few.transition[-1], many.transition[-1])
    assert np.array_equal(few.megno[-1], many.megno[-1])
