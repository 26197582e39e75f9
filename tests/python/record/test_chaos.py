"""MEGNO and Lyapunov exponents: regular motion, a moon that tumbles, and two neighbouring runs."""

import fullbody
import numpy as np
import pytest
from support import refused
from support.flows import deviation, displaced, scales
from support.meshes import box


def moon(out_of_round, e, faceted=False):
    """A moon on an eccentric orbit whose shape has this (B - A)/C: Wisdom, Peale & Mignard (1984), Icarus 58, 137.

    Faceted bodies are a cube and a box with the moments of the ellipsoids.
    """
    a, c = 1.0, 0.75
    # (B - A)/C = (a^2 - b^2)/(a^2 + b^2).
    b = a * np.sqrt((1 - out_of_round) / (1 + out_of_round))
    # A box has the moments m/12 (q^2 + r^2), an ellipsoid m/5 (b^2 + c^2).
    solid = (lambda *axes: box(*(np.sqrt(2.4) * np.array(axes)))) if faceted else fullbody.Ellipsoid
    planet = fullbody.Body(solid(10.0, 10.0, 10.0), mass=1.0, name="planet")
    satellite = fullbody.Body(solid(a, b, c * b), mass=1e-6, name="moon")
    system = fullbody.System([planet, satellite], G=1.0)
    r, v = fullbody.KeplerElements(100.0, e, 0.0, 0.0, 0.0, 0.0).to_cartesian(float(system.mu()))
    n = np.sqrt(float(system.mu()) / 100.0**3)
    angles, spin = [[0.05, 0.03, 0.4], [0.02 * n, 0.0, 1.1 * n]]
    state = fullbody.State.from_tait_bryan([0 * r, r], [0 * v, v], [0 * r, angles], [0 * r, spin])
    return system, state, 2 * np.pi / n


FAST = fullbody.Verner98(rtol=1e-11, atol=1e-11)


@pytest.fixture(scope="module")
def tumbling_moon():
    # Hyperion's shape and eccentricity.
    system, state, period = moon(0.26, 0.1)
    run = system.integrate(state, 60 * period, output=5 * period, integrator=FAST, chaos=True)
    return system, state, period, run


def test_megno_of_regular_motion_tends_to_two():
    system, state, period = moon(0.01, 0.0)
    run = system.integrate(state, 200 * period, output=50 * period, integrator=FAST, chaos=True)
    assert abs(run.megno[-1] - 2.0) < 0.1
    # The deviation grows with the time, not with its exponential.
    assert run.fast_lyapunov[-1] < 12.0


def test_megno_of_chaotic_motion_grows(tumbling_moon):
    _, _, period, run = tumbling_moon
    assert run.megno[-1] > 5.0
    # MEGNO is about half the exponent times the time.
    assert 0.5 < 2.0 * run.megno[-1] / (run.lyapunov[-1] * run.time[-1]) < 2.0
    # The Lyapunov time of Hyperion is a few orbits.
    assert 0.2 < run.lyapunov[-1] * period < 3.0


def test_polyhedra_have_the_lyapunov_exponent_of_ellipsoids_of_their_moments():
    # Their fields differ by the hexadecapoles: 1e-4 of the torque at this distance, periodically.
    options = {"output": "ends", "integrator": FAST, "chaos": True}
    results = []
    for faceted in (False, True):
        system, state, period = moon(0.26, 0.1, faceted)
        results.append(system.integrate(state, 4 * period, **options))
    exact, faceted = results
    assert exact.lyapunov[-1] * exact.time[-1] > 4.0
    assert abs(faceted.lyapunov[-1] / exact.lyapunov[-1] - 1.0) < 5e-4
    assert abs(faceted.megno[-1] / exact.megno[-1] - 1.0) < 5e-4


def test_the_lyapunov_exponent_is_that_of_neighbouring_runs(tumbling_moon):
    # Two runs 1e-8 apart, in natural sizes; the second is brought back to that distance after every orbit.
    system, state, period, run = tumbling_moon
    size, total, now = scales(system, state), 0.0, state
    neighbour = displaced(state, 1, 2, 0, 1e-8)
    for k in range(1, 61):
        now, neighbour = (system.integrate(s, k * period, output="ends", integrator=FAST)[-1] for s in (now, neighbour))
        apart = deviation(now, neighbour) / size
        total += np.log(np.linalg.norm(apart) / 1e-8)
        back = deviation(now, neighbour) * (1e-8 / np.linalg.norm(apart))
        neighbour = now
        for j in range(24):
            neighbour = displaced(neighbour, j // 12, j % 12 // 3, j % 3, back[j])
    assert 0.8 < total / (60 * period) / run.lyapunov[-1] < 1.25


def test_the_motion_has_the_same_bits_and_files_keep_all(tumbling_moon, tmp_path):
    system, state, period, run = tumbling_moon
    reference = system.integrate(state, 20 * period, output=5 * period, integrator=FAST)
    assert np.array_equal(reference.position[:4], run.position[:4])
    run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc") == run
    refused("chaos=True", lambda: reference.megno)


def test_splittings_measure_megno_too():
    system, state, period = moon(0.01, 0.0)
    steps = fullbody.SymplecticSplitting(step=period / 40)
    run = system.integrate(state, 100 * period, output="ends", integrator=steps, chaos=True)
    assert abs(run.megno[-1] - 2.0) < 0.2


def test_sweeps_measure_megno():
    def setup(e):
        system, state, _ = moon(0.26, e)
        return system, state

    period = moon(0.26, 0.0)[2]
    runs = fullbody.integrate_many([setup(0.0), setup(0.1)], 5 * period, output="ends", integrator=FAST, chaos=True)
    options = {"measure": lambda run: {"megno": run.megno[-1]}, "integrator": FAST, "chaos": True}
    result = fullbody.sweep(setup, {"e": [0.0, 0.1]}, 5 * period, **options)
    assert np.array_equal(result.megno.values, [run.megno[-1] for run in runs])
    both = fullbody.integrate_many([setup(0.1)], 5 * period, output="ends", derivatives=["G"])
    assert both[0].sensitivity["G"].shape == (2, 24)


@pytest.mark.parametrize("spin", [[0.0, 0.0, 0.0], [0.3, -0.2, 0.1]])
def test_free_motion_whose_steps_have_no_bound_has_a_megno_of_two(spin):
    # A deviation that grows in proportion to the time has a MEGNO of 2, within ln(t)/t.
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)], G=1.0)
    state = fullbody.State(position=[[0.0, 0.0, 0.0]], velocity=[[0.0, 0.0, 0.0]], spin=[spin])
    run = system.integrate(state, 1e5, output="ends", chaos=True)
    assert abs(run.megno[-1] - 2.0) < 1e-2


@pytest.mark.parametrize("integrator", [FAST, fullbody.LieGroupVariational(step=0.01)], ids=["verner98", "lie"])
def test_the_exponent_of_a_spin_about_the_middle_axis_is_eulers(integrator):
    # Euler's equations linearised: exp(lambda t) with lambda = spin sqrt((I2 - I1)(I3 - I2)/(I1 I3)).
    shape = fullbody.Ellipsoid(1.0, 0.8, 0.6)
    system = fullbody.System([fullbody.Body(shape, mass=1.0)], G=1.0)
    first, middle, last = system.bodies[0].inertia
    rate = np.sqrt((middle - first) * (last - middle) / (first * last))
    state = fullbody.State(position=[[0.0, 0.0, 0.0]], velocity=[[0.0, 0.0, 0.0]], spin=[[0.0, 1.0, 0.0]])
    for until in (100.0, -100.0):
        run = system.integrate(state, until, output=10.0, integrator=integrator, chaos=True)
        growth = run.lyapunov * np.abs(run.time)
        assert abs((growth[-1] - growth[-3]) / 20.0 - rate) < 1e-4 * rate
        # MEGNO grows by half the exponent, and by what goes with one over the time.
        assert abs((run.megno[-1] - run.megno[-3]) / 10.0 - rate) < 0.05 * rate
