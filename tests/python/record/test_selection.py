"""Samples of a run that are selected by lists of indices and by masks; states at any times."""

import fullbody
import numpy as np
import pytest
from support import refused

SYSTEM, STATE = fullbody.systems.case1()
RUN = SYSTEM.integrate(STATE, 10.0, output=1.0, derivatives=True)


@pytest.mark.parametrize("index", [[0, 5, 9], (0, 5, 9), np.array([0, 5, -2]), np.isin(np.arange(11), [0, 5, 9])])
def test_a_list_or_a_mask_selects_these_samples(index):
    part = RUN[index]
    assert part.time.tolist() == [0.0, 5.0, 9.0]
    assert [state == RUN[k] for state, k in zip(part, (0, 5, 9), strict=True)] == [True] * 3
    np.testing.assert_array_equal(part.transition, RUN.transition[[0, 5, 9]])


def test_a_selection_keeps_the_start_and_has_drifts_of_its_own():
    whole = RUN.energy_drift
    part = RUN[[3, 7]]
    assert part.start == RUN.start
    assert part.energy_drift.tolist() == whole[[3, 7]].tolist()


def test_lists_against_the_order_of_time_and_empty_ones_select_too():
    assert RUN[[9, 5, 0]].time.tolist() == [9.0, 5.0, 0.0]
    assert len(RUN[[]]) == len(RUN[np.zeros(11, bool)]) == 0


@pytest.mark.parametrize("index", [[0, 0], [0, 5, 3], [[0, 1]]])
def test_lists_that_have_no_order_in_time_are_refused(index):
    refused(r"the index of samples is .*; expected a list of distinct indices", lambda: RUN[index])


@pytest.mark.parametrize("index", [[99], [True] * 3, [0.5]])
def test_indices_that_are_out_of_range_are_errors_of_numpy(index):
    with pytest.raises(IndexError):
        RUN[index]


def test_states_between_samples_come_from_the_continuous_solution():
    run = SYSTEM.integrate(STATE, 10.0, output=1.0, dense=True)
    states = run.states([2.5, 7.0])
    np.testing.assert_array_equal(states["attitude"][0], run(2.5).attitude)
    np.testing.assert_allclose(states["position"][1], run.position[7], rtol=1e-12)


def test_states_of_a_run_without_continuous_solution_are_those_of_samples():
    back = SYSTEM.integrate(STATE, -10.0, output=1.0)
    np.testing.assert_array_equal(back.states([-7.0, -2.0])["spin"], back.spin[[7, 2]])
    refused(r"moment is -2\.5, of no sample; .* integrate with dense=True", lambda: back.states([-2.0, -2.5], "moment"))
    refused(r"time has shape \(1, 2\); expected \(K,\)", lambda: back.states([[-2.0, -3.0]]))
