"""Work, impulse and angular impulse of all forces balance energy and angular momentum, also in copies and files."""

import copy
import itertools
import pickle

import fullbody
import numpy as np
import pytest
from fullbody.forces import Function
from support import refused
from support.scenes import KINDS, pair, sun

COMBINATIONS = [names for count in (1, 2, 5) for names in itertools.combinations(KINDS, count)]
PAIRS = {
    "Verner98": fullbody.Verner98(rtol=1e-13, atol=1e-13),
    "Verner87": fullbody.Verner87(rtol=1e-12, atol=1e-12),
    "Verner76": fullbody.Verner76(rtol=1e-11, atol=1e-11),
    "Verner65": fullbody.Verner65(rtol=1e-10, atol=1e-10),
    "DormandPrince54": fullbody.DormandPrince54(rtol=1e-9, atol=1e-9),
}
NAMES = ("time", "position", "velocity", "attitude", "spin", "energy", "angular_momentum")


def forced(*names):
    system, state = pair(gravity="multipole:4")
    return system.with_forces([KINDS[name]() for name in names]), state


def equal(item, other):
    """Every bit is the same, those of work and impulse too."""
    same = all((getattr(item, name) == getattr(other, name)).all() for name in NAMES)
    return same and all(
        (mine[name] == theirs[name]).all()
        for mine, theirs in ((item.work, other.work), (item.angular_impulse, other.angular_impulse))
        for name in mine
    )


@pytest.mark.parametrize("names", COMBINATIONS, ids="-".join)
def test_work_closes_the_energy_to_round_off(names):
    system, state = forced(*names)
    run = system.integrate(state, 10.0)
    assert list(run.work) == list(run.impulse) == list(run.angular_impulse) == [f.name for f in system.forces]
    assert np.abs(run.energy_drift).max() < 1e-13
    assert np.abs(run.energy_drift_orbital).max() < 3e-12
    assert run.angular_momentum_drift.max() < 1e-13
    # The energy itself changes by more.
    assert all(np.abs(work).max() > 1e-9 for work in run.work.values())
    momentum = np.tensordot(run.velocity, system.masses, axes=([1], [0]))
    np.testing.assert_allclose(sum(run.impulse.values()), momentum - momentum[0], rtol=0, atol=1e-15)


def test_work_closes_the_energy_of_a_moving_barycentre():
    """Work counts with the velocity of the whole, moments about the origin: the drag there is 1e-4 of all of it."""
    system, state = forced(*KINDS)
    moved = fullbody.State(
        state.position + np.array([512.0, -256.0, 64.0]),
        state.velocity + np.array([4.0, 8.0, -1.0]),
        state.attitude,
        state.spin,
    )
    run = system.integrate(moved, 10.0)
    assert np.abs(run.work["own"][-1]) > 1e-4 * abs(run.start.energy.total)
    assert np.linalg.norm(run.angular_impulse["own"][-1]) > 1e-5 * np.linalg.norm(run.start.angular_momentum)
    assert np.abs(run.energy_drift).max() < 1e-13
    assert run.angular_momentum_drift.max() < 1e-13


@pytest.mark.parametrize("integrator", PAIRS.values(), ids=PAIRS)
def test_every_runge_kutta_pair_closes_the_energy(integrator):
    system, state = forced(*KINDS)
    run = system.integrate(state, 20.0, integrator=integrator)
    free = system.with_forces([]).integrate(state, 20.0, integrator=integrator)
    assert np.abs(run.energy_drift).max() < 3 * np.abs(free.energy_drift).max() + 1e-14
    assert run.angular_momentum_drift.max() < 3 * free.angular_momentum_drift.max() + 1e-14


@pytest.mark.parametrize(
    "integrator",
    [fullbody.SymplecticSplitting(step=0.02), fullbody.LieGroupVariational(step=0.02)],
    ids=["splitting", "variational"],
)
def test_work_of_fixed_steps_closes_the_energy(integrator):
    # The energy that kicks add is counted as work; the remaining drift is that of the run without.

    def steady(time, state):
        return 1e-5 * np.cos(time) * state.position

    system, state = pair(gravity="multipole:4")
    custom = Function(steady, depends_on_velocity=False, name="own")
    run = system.with_forces([sun(), custom]).integrate(state, 20.0, integrator=integrator)
    free = system.integrate(state, 20.0, integrator=integrator)
    size = np.abs(free.energy_drift).max()
    assert np.abs(run.energy_drift).max() < 1.2 * size + 1e-14
    assert run.angular_momentum_drift.max() < 1e-13 + 1.2 * free.angular_momentum_drift.max()
    assert np.abs(sum(run.work.values())).max() > 30 * size * abs(run.start.energy.total)


@pytest.mark.parametrize("kind", ["tide", "YORP", "BYORP", "own"])
@pytest.mark.parametrize("integrator", [fullbody.SymplecticSplitting(step=0.1), fullbody.LieGroupVariational(step=0.1)])
def test_forces_that_fixed_steps_do_not_support_are_refused_by_name(kind, integrator):
    system, state = forced("Sun", kind)
    refused(rf"(?s){kind}.*velocit", lambda: system.integrate(state, 1.0, integrator=integrator))


# Runs and their parts.


def test_a_slice_keeps_work_and_impulse():
    system, state = forced("Sun", "tide")
    run = system.integrate(state, 10.0, output=0.5)
    part = run[4::3]
    assert (part.work["Sun"] == run.work["Sun"][4::3]).all()
    assert (part.impulse["tide"] == run.impulse["tide"][4::3]).all()
    assert (part.energy_drift == run.energy_drift[4::3]).all()
    assert run.work["Sun"][0] == 0.0


@pytest.mark.parametrize("output", [None, 1.0])
def test_work_of_continued_runs_adds_up(output):
    system, state = forced("Sun", "tide", "own")
    complete = system.integrate(state, 10.0)
    sim = fullbody.Simulation(system, state)
    runs = [sim.integrate(5.0, output=output), sim.integrate(10.0, output=output)]
    for name in complete.work:
        total = sum(run.work[name][-1] for run in runs)
        assert total == pytest.approx(complete.work[name][-1], rel=1e-9, abs=1e-18)
        total = sum(run.angular_impulse[name][-1] for run in runs)
        np.testing.assert_allclose(total, complete.angular_impulse[name][-1], rtol=0, atol=1e-14)
    for run in runs:
        assert np.abs(run.energy_drift).max() < 1e-13
        assert run.angular_momentum_drift.max() < 1e-13
    assert abs(sim.energy_drift) < 1e-13
    assert sim.angular_momentum_drift < 1e-13


def test_a_state_that_is_set_starts_new_sums_of_work():
    system, state = forced("Sun", "tide")
    sim = fullbody.Simulation(system, state)
    first = sim.integrate(5.0)
    sim.state = state
    again = sim.integrate(5.0)
    assert equal(first, again)
    assert abs(sim.energy_drift) < 1e-13


def test_single_steps_add_to_the_work():
    system, state = forced("Sun", "tide")
    sim = fullbody.Simulation(system, state)
    for _ in range(10):
        sim.step()
    assert abs(sim.energy_drift) < 1e-14
    unitless = system.energy(sim.state).total - system.energy(state).total
    assert abs(unitless / system.energy(state).total) > 1e-9


# Files and copies.


@pytest.mark.parametrize("kind", KINDS)
def test_a_simulation_from_a_file_continues_bit_for_bit(kind, tmp_path):
    system, state = forced(kind)
    sim = fullbody.Simulation(system, state)
    sim.integrate(4.0, output=[4.0])
    sim.save(tmp_path / "half.sim")
    forces = [force for force in system.forces if isinstance(force, Function)]
    loaded = fullbody.Simulation.load(tmp_path / "half.sim", forces=forces)
    assert loaded.system == system
    assert loaded.energy_drift == sim.energy_drift
    item, other = sim.integrate(9.0), loaded.integrate(9.0)
    assert equal(item, other)
    assert item == other
    assert loaded.energy_drift == sim.energy_drift


def test_a_switch_is_kept_in_files(tmp_path):
    system, state = forced("BYORP")
    spin = np.array(state.spin)
    spin[1, 2] = 3.0
    lost = fullbody.State(state.position, state.velocity, state.attitude, spin)
    sim = fullbody.Simulation(system, lost)
    sim.integrate(2.0)
    sim.save(tmp_path / "x.sim")
    item, other = sim.integrate(4.0), fullbody.Simulation.load(tmp_path / "x.sim").integrate(4.0)
    assert item == other
    assert item.switched_off == {"BYORP": 1}
    assert (item.work["BYORP"] == 0).all()


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies_keep_work_and_impulse(duplicate):
    system, state = forced(*KINDS)
    run = system.integrate(state, 3.0)
    assert duplicate(system) == system
    assert duplicate(system).forces == system.forces
    assert equal(duplicate(run), run)
    assert duplicate(run) == run
    assert equal(duplicate(system).integrate(state, 3.0), run)
    sim = fullbody.Simulation(system, state)
    sim.integrate(1.0)
    if duplicate is not copy.copy:
        other = duplicate(sim)
        assert equal(other.integrate(3.0), sim.integrate(3.0))


def test_systems_are_equal_only_with_equal_forces():
    system, _ = pair()
    assert system.with_forces([sun()]) == system.with_forces([sun()])
    assert system.with_forces([sun()]) != system
    assert system.with_forces([sun(mu=2e6)]) != system.with_forces([sun()])
    assert system.with_forces([sun()]).with_forces([]) == system
    assert system.with_forces([sun()]).with_options(gravity="surface").forces == (sun(),)
