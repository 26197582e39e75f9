"""Integration of tangent vectors: closed forms, symplecticity, samples within steps."""

import fullbody
import numpy as np
import pytest
from scipy.linalg import expm
from support import pair_of_points, worst
from support.flows import TIGHT, scaled, tumbling

COARSE = [
    fullbody.DormandPrince54(rtol=1e-2, atol=1e-2),
    fullbody.Verner65(rtol=1e-3, atol=1e-3),
    fullbody.Verner76(rtol=1e-3, atol=1e-3),
    fullbody.Verner87(rtol=1e-2, atol=1e-2),
    fullbody.Verner98(rtol=1e-2, atol=1e-2),
]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_lone_body_rotates_about_a_principal_axis(axis):
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
    # Some of the steps are too long for the sweeps and are divided; the motion may have any error.
    system, state = pair_of_points(0.7)
    run = system.integrate(state, 30.0, output=[3.0, 30.0], integrator=integrator, derivatives=True)
    form = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    for phi in run.transition:
        relative = phi[12:18, 12:18] - phi[0:6, 12:18]
        size = np.abs(relative).max() ** 2
        assert worst(relative.T @ form @ relative, form, size) < 1e-13


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
    sampled = system.integrate(state, 4.0, output=0.11, derivatives=["G"], chaos=True)
    assert np.array_equal(few.transition[-1], sampled.transition[-1])
    assert np.array_equal(few.megno[-1], sampled.megno[-1])


def test_matrices_at_samples_within_a_step_are_as_exact_as_those_at_its_end():
    # A lone body about its middle axis, where an exponential solves the equations, with steps as long as a tolerance
    # of 1e-11 allows: samples are a tenth of them apart.
    body = fullbody.Body(fullbody.Ellipsoid(1.0, 0.6, 0.1), mass=1.0)
    system = fullbody.System([body], G=1.0)
    state = fullbody.State([np.zeros(3)], [np.zeros(3)], [[1.0, 0.0, 0.0, 0.0]], [[0.0, 3.0, 0.0]])
    integrator = fullbody.Verner98(rtol=1e-11, atol=1e-11)
    run = system.integrate(state, 2.0, output=np.linspace(0.0, 2.0, 200), integrator=integrator, derivatives=True)
    assert run.statistics.steps < 20
    rates = system.jacobian(state).rates
    errors = [worst(phi, expm(t * rates)) for t, phi in zip(run.time, run.transition, strict=True)]
    assert max(errors) < 3e-13
