"""Energy and angular momentum are compared with those of the start, whatever is recorded and wherever a run goes."""

import copy
import pickle

import fullbody
import numpy as np
import pytest
from fullbody.commands.cli import main
from fullbody.errors import BodiesOverlap
from support import points, refused

MASSES, G = np.array([0.7, 0.2, 0.1]), 1.3
LOOSE = fullbody.DormandPrince54(1e-6, 1e-6)
START = fullbody.State([[0.1, 0, 0], [1, 0, 0.1], [0, -4, 0]], [[0, 0.1, 0], [0, 1.1, 0], [0.6, 0, 0.1]], time=2.0)
DRIFTS = ("energy_drift", "energy_drift_orbital", "angular_momentum_drift")


def by_hand(state):
    """Kinetic and potential energy and angular momentum of points."""
    r, v = state.position, state.velocity
    potential = -G * sum(MASSES[i] * MASSES[j] / np.linalg.norm(r[i] - r[j]) for i, j in ((0, 1), (0, 2), (1, 2)))
    return 0.5 * MASSES @ (v**2).sum(axis=1), potential, MASSES @ np.cross(r, v)


def drifts_by_hand(start, states):
    """The three drifts (3, K) since a state; points have no energy of rotation."""
    kinetic, potential, momentum = by_hand(start)
    rows = []
    for k, p, j in map(by_hand, states):
        change = (k + p - kinetic - potential) / abs(kinetic + potential)
        rows.append((change, change, np.linalg.norm(j - momentum) / np.linalg.norm(momentum)))
    return np.reshape(rows, (-1, 3)).T


def drifts(of):
    return np.array([getattr(of, name) for name in DRIFTS])


def three():
    return points(*MASSES, G=G)


@pytest.mark.parametrize(
    "output",
    [None, 1.5, [32.0], [20.0, 30.0], [2.0, 32.0], []],
    ids=["steps", "spacing", "end", "late", "both", "none"],
)
@pytest.mark.parametrize("until", [32.0, -28.0], ids=["forwards", "backwards"])
def test_drifts_count_from_the_start_whatever_is_recorded(output, until):
    if until < START.time and isinstance(output, list):
        output = [2 * START.time - time for time in output]
    run = three().integrate(START, until, output=output, integrator=LOOSE)
    assert np.abs(drifts(run) - drifts_by_hand(START, run)).max(initial=0.0) < 1e-14
    if len(run):
        # The tolerance is loose enough that there is something to see.
        assert (np.abs(drifts(run)[:, -1]) > 1e-8).all()
    kinetic, potential, momentum = by_hand(START)
    assert run.start.time == START.time
    energy = run.start.energy
    assert (energy.translational, energy.rotational, energy.potential) == pytest.approx((kinetic, 0, potential))
    assert energy.total == pytest.approx(kinetic + potential, rel=1e-14)
    assert run.start.angular_momentum == pytest.approx(momentum, rel=1e-14)


def test_the_spin_energy_of_kw4_does_not_hide_the_drift_of_the_orbit():
    system, state = fullbody.systems.kw4()
    run = system.integrate(state, 1000.0, output=[1000.0], integrator=fullbody.Verner98(1e-5, 1e-5))
    first, last = system.energy(state), system.energy(run[0])
    change = last.total - first.total
    assert run.energy_drift[0] == pytest.approx(change / first.total, rel=1e-6)
    assert run.energy_drift[0] > 1e-9
    assert run.energy_drift_orbital[0] == pytest.approx(change / abs(first.translational + first.potential), rel=1e-6)
    moved = system.angular_momentum(run[0]) - system.angular_momentum(state)
    expected = np.linalg.norm(moved) / np.linalg.norm(system.angular_momentum(state))
    assert run.angular_momentum_drift[0] == pytest.approx(expected, rel=1e-6)


def test_a_recorded_start_is_the_start_to_the_last_bit():
    system, state = fullbody.systems.kw4()
    run = system.integrate(state, 20.0, output=5.0)
    assert run.start.energy.total == run.energy[0]
    assert run.start.energy.rotational == run.rotational_energy[0]
    assert np.array_equal(run.start.angular_momentum, run.angular_momentum[0])
    assert all(getattr(run, name)[0] == 0.0 for name in DRIFTS)


def test_slices_copies_pickles_and_files_keep_the_start(tmp_path):
    run = three().integrate(START, 32.0, output=1.5, integrator=LOOSE)
    for part in (slice(5, None), slice(None, None, 3), slice(-1, None), slice(3, 3), [3, 7]):
        assert np.array_equal(drifts(run[part]), drifts(run)[:, part])
        assert run[part].start == run.start
    tail = run[7:]
    tail.save(tmp_path / "late.nc")
    again = fullbody.load(tmp_path / "late.nc")
    for twin in (copy.copy(tail), copy.deepcopy(tail), pickle.loads(pickle.dumps(tail)), again):
        assert twin == tail
        assert twin.start == tail.start
        assert np.array_equal(drifts(twin), drifts(tail))
    other = three().integrate(run[3], 32.0, output=1.5, integrator=LOOSE)
    assert other[2:] != tail


def test_the_start_in_xarray_has_units():
    system, state = fullbody.systems.kw4(units=True)
    run = system.integrate(state, 20.0, output=[10.0, 20.0])
    dataset, start = run.to_xarray(), run.start
    assert dataset.start_time.item() == start.time.to_value("h") == 0.0
    assert dataset.start_energy.sel(part="potential").item() == start.energy.potential.value
    assert np.array_equal(dataset.start_angular_momentum, start.angular_momentum.value)
    assert dataset.start_energy.attrs["units"] == dataset.energy.attrs["units"]
    drift = (dataset.energy.sel(part="total") - dataset.start_energy.sel(part="total")) / dataset.start_energy[0]
    assert np.array_equal(drift, run.energy_drift)


def test_the_drift_of_a_simulation_covers_all_its_runs(tmp_path):
    sim = fullbody.Simulation(three(), START, integrator=LOOSE)
    assert drifts(sim).tolist() == [0.0, 0.0, 0.0]
    for until in (12.0, 32.0, 20.0):
        begin = sim.state
        run = sim.integrate(until, output=[until])
        assert run.start.time == begin.time
        assert np.abs(drifts(run) - drifts_by_hand(begin, run)).max() < 1e-14
        assert np.abs(drifts(sim) - drifts_by_hand(START, [sim.state])[:, 0]).max() < 1e-14
    sim.save(tmp_path / "three.sim")
    for _ in range(20):
        sim.step()
    drift = drifts_by_hand(START, [sim.state])[:, 0]
    assert np.abs(drifts(sim) - drift).max() < 1e-14
    assert (np.abs(drift) > 1e-8).all()
    assert sim.start == fullbody.Simulation(three(), START).start
    assert np.array_equal(drifts(copy.copy(sim)), drifts(sim))
    # A file knows where it began.
    again = fullbody.Simulation.load(tmp_path / "three.sim")
    assert again.integrate(32.0, output=[32.0]).start.time == 20.0
    assert np.abs(drifts(again) - drifts_by_hand(START, [again.state])[:, 0]).max() < 1e-14
    # Set to a state, it begins there.
    sim.state = sim.state
    assert sim.start.time == sim.time
    assert drifts(sim).tolist() == [0.0, 0.0, 0.0]


def test_runs_cut_short_keep_the_start():
    bodies = [fullbody.Body(fullbody.Sphere(0.5), mass=1.0)] * 2
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State([[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [0, 0.1, 0]], time=1.0)
    expected = system.energy(state).total
    for output in (None, []):
        with pytest.raises(BodiesOverlap) as caught:
            system.integrate(state, 100.0, output=output)
        assert caught.value.run.start.time == 1.0
        assert caught.value.run.start.energy.total == pytest.approx(expected, rel=1e-14)
        assert caught.value.run.energy_drift.shape == (len(caught.value.run),)
    stop = fullbody.events.Separation(0, 1, 2.0, terminal=True)
    run = system.integrate(state, 100.0, output=[100.0], events=[stop], integrator=LOOSE)
    assert len(run) == 1
    change = system.energy(run[0]).total - expected
    assert run.energy_drift[0] == pytest.approx(change / abs(expected), rel=1e-6)
    assert change != 0.0

    def never(state):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as failed:
        system.integrate(state, 2.0, output=[], events=[fullbody.events.Function(never)])
    assert failed.value.run.start.energy.total == pytest.approx(expected, rel=1e-14)


def test_the_table_of_a_run_has_its_start(tmp_path, capsys):
    run = three().integrate(START, 32.0, output=[20.0, 32.0], integrator=LOOSE)
    shown = {f"{np.abs(drift).max():.2e}" for drift in drifts(run)}
    run.save(tmp_path / "run.nc")
    assert main(["info", str(tmp_path / "run.nc")]) == 0
    for text in (run._repr_html_(), capsys.readouterr().out):
        assert all(value in text for value in shown)
        assert "start" in text
        assert "since the first sample" not in text
    line = run.plot.energy().lines[0]
    assert np.array_equal(line.get_ydata(), np.abs(run.energy_drift))
    # Where it is recorded, the span of the samples tells it.
    assert "start" not in three().integrate(START, 3.0)._repr_html_()
    assert "start" in three().integrate(START, 3.0, output=[])._repr_html_()


ARRAYS = ["start_time", "start_energy", "start_angular_momentum"]


@pytest.mark.parametrize(
    ("damaged", "message"),
    [
        (lambda data: data.drop_vars("start_energy"), "the file has no variable start_energy"),
        (lambda data: data.drop_vars(ARRAYS), "the file has no variable start_time"),
        (
            lambda data: data.assign(start_angular_momentum=("part", np.zeros(4))),
            "start_angular_momentum has the dimensions part; expected axis",
        ),
        (lambda data: data.assign(start_time=np.nan), r"start_time\[\] is nan; expected finite numbers"),
    ],
)
def test_damaged_starts_are_refused(damaged, message, tmp_path):
    dataset = three().integrate(START, 3.0, output=[3.0]).to_xarray()
    damaged(dataset).to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    refused(message, fullbody.load, tmp_path / "run.nc")


def falling():
    """Two spheres that meet long after the first samples."""
    bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=1.0, name=name) for name in "AB"]
    state = fullbody.State([[0, 0, 0], [2.0, 0, 0]], np.zeros((2, 3)))
    return fullbody.System(bodies, G=1.0), state


@pytest.mark.parametrize("output", ["ends", 100.0, [0.5, 90.0], None])
@pytest.mark.parametrize("derivatives", [False, True])
def test_the_last_sample_is_the_state_at_the_end_of_the_last_step(output, derivatives):
    system, state = falling()
    sim = fullbody.Simulation(system, state)
    with pytest.raises(BodiesOverlap) as caught:
        sim.integrate(100.0, output=output, derivatives=derivatives)
    run = caught.value.run
    assert run.time[-1] == sim.time > 1.5
    assert (run.position[-1] == sim.state.position).all()
    assert (np.diff(run.time) > 0).all()
    if derivatives:
        assert run.transition.shape == (len(run), 24, 24)
    # Free fall: v^2 = 2 G (m + m) (1/r - 1/d), from the start to that state.
    r, v = (np.linalg.norm(x[-1, 1] - x[-1, 0]) for x in (run.position, run.velocity))
    assert v**2 == pytest.approx(4.0 * (1.0 / r - 0.5), rel=1e-10)


def test_the_last_sample_of_an_interrupted_run_is_its_last_step():
    system, state = fullbody.systems.case1()
    seen = []

    def stop(done, total, description):
        seen.append(done)
        if done > 20.0:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError) as caught:
        system.integrate(state, 1e6, output="ends", progress=stop)
    run = caught.value.run
    assert len(run) == 2
    assert run.time[-1] == seen[-1]


SYSTEM, STATE = fullbody.systems.case1()
RUN = SYSTEM.integrate(STATE, 10.0, output=1.0, derivatives=True)


@pytest.mark.parametrize("index", [[0, 5, 9], (0, 5, 9), np.array([0, 5, -2]), np.isin(np.arange(11), [0, 5, 9])])
def test_a_list_or_a_mask_selects_these_samples(index):
    part = RUN[index]
    assert [*part] == [RUN[k] for k in (0, 5, 9)]
    np.testing.assert_array_equal(part.transition, RUN.transition[[0, 5, 9]])
    assert RUN[[9, 5, 0]].time.tolist() == [9.0, 5.0, 0.0]
    assert len(RUN[[]]) == len(RUN[np.zeros(11, bool)]) == 0


def test_indices_without_an_order_in_time_or_out_of_range_are_refused():
    for index in ([0, 0], [0, 5, 3], [[0, 1]]):
        refused(r"the index of samples is .*; expected a list of distinct indices", RUN.__getitem__, index)
    for index in ([99], [True] * 3, [0.5]):
        with pytest.raises(IndexError):
            RUN[index]


def test_states_are_those_of_samples_or_of_the_continuous_solution():
    run = SYSTEM.integrate(STATE, 10.0, output=1.0, dense=True)
    states = run.states([2.5, 7.0])
    np.testing.assert_array_equal(states["attitude"][0], run(2.5).attitude)
    np.testing.assert_allclose(states["position"][1], run.position[7], rtol=1e-12)
    back = SYSTEM.integrate(STATE, -10.0, output=1.0)
    np.testing.assert_array_equal(back.states([-7.0, -2.0])["spin"], back.spin[[7, 2]])
    refused(r"moment is -2\.5, of no sample; .* integrate with dense=True", lambda: back.states([-2.0, -2.5], "moment"))
    refused(r"time has shape \(1, 2\); expected \(K,\)", lambda: back.states([[-2.0, -3.0]]))
