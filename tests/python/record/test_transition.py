"""Transition matrices and sensitivities against closed forms and the laws of mechanics."""

import fullbody
import numpy as np
import pytest
from mpmath import mp, mpf
from support import pair_of_points, refused, worst
from support.flows import TIGHT, energy_gradient, momentum_gradients, rates, scaled, scales, symplectic_form, tumbling
from support.scenes import pair


@pytest.fixture(scope="module", params=["focal", "surface"])
def tumble(request):
    system, state = tumbling(request.param)
    run = system.integrate(state, 12.0, output=[0.0, 3.3, 12.0], integrator=TIGHT, derivatives=["G", "mass of A"])
    return system, run


def test_the_motion_has_the_same_bits():
    system, state = tumbling()
    reference, with_them = (system.integrate(state, 5.0, derivatives=reference) for reference in (False, True))
    for name in ("time", "position", "velocity", "attitude", "spin", "energy"):
        assert np.array_equal(getattr(reference, name), getattr(with_them, name))


def test_transition_matrices_map_rates_to_rates(tumble):
    # A deviation along the motion stays one.
    system, run = tumble
    size = scales(system, run[0])
    for k in (1, 2):
        displaced = run.transition[k] @ rates(system, run[0])
        assert worst(displaced / size, rates(system, run[k]) / size) < 1e-11


def test_transition_matrices_keep_energy_and_momenta(tumble):
    system, run = tumble
    size = scales(system, run[0])
    assert np.array_equal(run.transition[0], np.eye(24))
    for k in (1, 2):
        for gradient in (energy_gradient, momentum_gradients):
            now, then = (gradient(system, run[i]) for i in (k, 0))
            assert worst(now @ run.transition[k] * size, then * size) < 1e-11


def test_transition_matrices_are_symplectic(tumble):
    system, run = tumble
    size = scales(system, run[0])
    for k in (1, 2):
        phi = run.transition[k]
        conserved = phi.T @ symplectic_form(system, run[k]) @ phi
        both = [size[:, np.newaxis] * form * size for form in (conserved, symplectic_form(system, run[0]))]
        # Terms of the sum are as large as the square of the matrix.
        growth = np.abs(scaled(phi, system, run[0])).max() ** 2
        assert worst(*both) < 1e-13 * growth
        assert worst(*both) < 1e-11


def test_transition_matrices_of_points_are_keplers():
    # Kepler's equation in 40 digits, differentiated there.
    mp.dps = 40
    system, state = pair_of_points(0.3)
    time = 9.0
    run = system.integrate(state, time, output="ends", integrator=TIGHT, derivatives=True)
    r0, v0 = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
    start = [mpf(float(x)) for x in (*r0, *v0)]
    step = mpf(10) ** -13
    expected = np.zeros((6, 6))
    for k in range(6):
        ends = []
        for sign in (1, -1):
            displaced = list(start)
            displaced[k] += sign * step
            ends.append(kepler(displaced, mpf(time), mpf(float(system.mu()))))
        expected[:, k] = [float((a - b) / (2 * step)) for a, b in zip(*ends, strict=True)]
    phi = run.transition[-1]
    # A move of the second body alone moves the relative orbit by as much.
    relative = phi[12:18, 12:18] - phi[0:6, 12:18]
    assert worst(relative, expected) < 1e-11
    assert worst(phi[12:18, 0:6] - phi[0:6, 0:6], -expected) < 1e-11
    # Points do not turn.
    assert worst(phi[6:9, 6:12], np.hstack([np.eye(3), time * np.eye(3)])) < 1e-14


def kepler(start, time, mu):
    """The state on an elliptic orbit after a time, by f and g of the change of the eccentric anomaly."""
    r, v = start[:3], start[3:]
    dot = sum(a * b for a, b in zip(r, v, strict=True))
    distance = mp.sqrt(sum(a * a for a in r))
    a = 1 / (2 / distance - sum(x * x for x in v) / mu)
    n = mp.sqrt(mu / a**3)
    s, c = dot / mp.sqrt(mu * a), 1 - distance / a
    mean = n * time
    change = mp.findroot(lambda x: x - c * mp.sin(x) + s * (1 - mp.cos(x)) - mean, mean)
    now = a * (1 - c * mp.cos(change) + s * mp.sin(change))
    f, g = 1 - a / distance * (1 - mp.cos(change)), time + (mp.sin(change) - change) / n
    df, dg = -mp.sqrt(mu * a) / (now * distance) * mp.sin(change), 1 - a / now * (1 - mp.cos(change))
    return [f * x + g * y for x, y in zip(r, v, strict=True)] + [df * x + dg * y for x, y in zip(r, v, strict=False)]


def test_the_transition_matrix_backwards_is_the_inverse(tumble):
    system, run = tumble
    back = system.integrate(run[2], 0.0, output="ends", integrator=TIGHT, derivatives=True)
    both = scaled(back.transition[-1] @ run.transition[2], system, run[0])
    growth = np.abs(scaled(run.transition[2], system, run[0])).max()
    assert worst(both, np.eye(24)) < 1e-12 * growth


def test_an_unknown_parameter_is_refused_with_the_known_ones():
    system, state = tumbling()
    refused(r'"mass of C".*"G".*"mass of A".*"mass of B"', system.integrate, state, 1.0, derivatives=["mass of C"])
    refused("which is text", lambda: system.integrate(state, 1.0, derivatives="G"))
    refused("derivatives=True", lambda: system.integrate(state, 1.0).transition)


def test_files_keep_derivatives(tumble, tmp_path):
    _, run = tumble
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again == run
    assert np.array_equal(again.sensitivity["mass of A"], run.sensitivity["mass of A"])
    assert run[1:].transition.shape == (2, 24, 24)


def test_entries_have_the_unit_of_row_by_column():
    system, state = fullbody.systems.kw4(units=True)
    assert fullbody.systems.kw4()[0].integrate(fullbody.systems.kw4()[1], 1.0).tangent_units is None
    other = fullbody.System(system.bodies, G=system.G, units=("m", "min", "kg"))
    runs = [case.integrate(state, "2 h", output="ends", derivatives=True) for case in (system, other)]
    first, second = (run.tangent_units for run in runs)
    assert [str(unit) for unit in first[12:24:3]] == ["km", "km / h", "rad", "rad / h"]
    factors = [(unit / other_unit).decompose().scale for unit, other_unit in zip(first, second, strict=True)]
    scaled = runs[0].transition[-1] * np.outer(factors, 1.0 / np.array(factors))
    size = np.abs(scaled).max(axis=1, keepdims=True)
    assert (np.abs(runs[1].transition[-1] - scaled) <= 1e-8 * size).all()


@pytest.mark.parametrize("integrator", [fullbody.Verner98(1e-13, 1e-13), fullbody.SymplecticSplitting(step=0.02)])
def test_the_matrices_of_consecutive_runs_multiply_to_that_of_one_run(integrator):
    elements = fullbody.KeplerElements(12.0, 0.3, 0.4, 1.0, 2.0, 0.3)
    system, state = pair(forces=[fullbody.forces.ThirdBody(mu=30.0, orbit=elements, of="system", name="Sun")])
    reference = system.integrate(state, 9.0, output="ends", integrator=integrator, derivatives=True).transition[-1]
    simulation = fullbody.Simulation(system, state, integrator=integrator)
    product, apart, last = np.eye(24), np.eye(24), state
    for until in (3.0, 4.0, 9.0):
        run = simulation.integrate(until, output="ends", derivatives=True)
        product = run.transition[-1] @ product
        again = system.integrate(last, until, output="ends", integrator=integrator, derivatives=True)
        apart, last = again.transition[-1] @ apart, run[-1]
    assert worst(product, reference) < 1e-10
    # Runs that each begin with a nominal barycentre of their own are another motion.
    assert worst(apart, reference) > 1e-6
