"""The paper's short runs against trajectories of two independent programs, and its conserved quantities."""

import fullbody
import numpy as np
import pytest
from support import angle_between, reference, worst

RUNS = reference("trajectories")["runs"]
RULES = ("surface", "focal")

#: The references' own error in the dimensionless cases: 1.2e-13 in case 2 against a program in 80 bits. Their
#: 'agreement', the difference of two programs that share their fixed steps, is 5e-14.
ROUND_OFF = 1.5e-13


def build(key, **options):
    name, *shape = key.split()
    return getattr(fullbody.systems, name)(*shape, **options)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("key", RUNS)
def test_the_papers_runs_are_those_of_two_programs(key, rule):
    system, state = build(key, gravity=rule)
    tight = fullbody.Verner98(rtol=1e-15, atol=1e-15)
    run = system.integrate(state, 100.0, output=[row["time"] for row in RUNS[key]], integrator=tight)
    for row, sample in zip(RUNS[key], run, strict=True):
        expected = fullbody.State.from_tait_bryan(*(row[name] for name in ("position", "velocity", "angles", "spin")))
        # Rates are below 1 per unit time in every run, so that the positions' figure bounds the velocities too.
        limit = max(row["agreement"], ROUND_OFF)
        assert sample.time == row["time"]
        for name in ("position", "velocity", "spin"):
            assert np.abs(getattr(sample, name) - getattr(expected, name)).max() < limit, name
        assert angle_between(expected.rotation_matrix, sample.rotation_matrix).max() < limit


def test_default_tolerance_is_good_for_thirteen_digits():
    for key, rows in RUNS.items():
        system, state = build(key)
        run = system.integrate(state, 100.0, output=[50.0, 100.0])
        for row, position in zip(rows, run.position, strict=True):
            assert np.abs(position - row["position"]).max() < row["agreement"] + 4e-13


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("case", ["case1", "case2"])
def test_conserved_quantities_and_the_half_turn_symmetry_are_kept(case, rule):
    system, state = build(case, gravity=rule)
    run = system.integrate(state, 200.0)
    assert run.time[-1] == 200.0
    assert np.abs(run.energy_drift).max() < 1e-13
    # Most energy of case 2 is in the spins, so the drift is compared with the orbital energy as well.
    assert np.abs(run.energy_drift_orbital).max() < 1e-12
    assert run.angular_momentum_drift.max() < 1e-13
    # Recomputed from the states, so that the recorded figures are not taken on trust.
    ends = run[0], run[-1]
    assert worst(*(system.energy(state).total for state in ends)) < 1e-13
    assert worst(*(system.angular_momentum(state) for state in ends)) < 1e-13
    assert np.abs(run.position[:, :, 2]).max() < 1e-12
    assert np.abs(run.position.sum(axis=1)).max() < 1e-12
    spin = run.spin[:, :, 2]
    assert np.abs(spin - spin[0]).max() < 1e-14
