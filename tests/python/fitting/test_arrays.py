"""Parameters of fits that are arrays: names, values, errors, priors, draws, files and samples."""

import astropy.units as u
import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import observing
from fullbody.fitting import Free
from fullbody.fitting.free import Parameters
from support import refused

TRUE = np.array([[1.0, -2.0, 0.5], [0.3, 0.7, -1.1]])
SIGMA = 0.1


def setup(position, speed=0.0):
    """Two points at rest, whose positions are an array (2, 3)."""
    bodies = [fullbody.Body(fullbody.PointMass(), mass=1e-30, name=name) for name in "AB"]
    system = fullbody.System(bodies, G=1.0)
    return system, fullbody.State(position, [[speed, 0.0, 0.0], [0.0] * 3])


def positions_of(run):
    return run.position[0].ravel()


DATA = observing.Measured("positions", positions_of, TRUE.ravel(), SIGMA, [0.0, 1.0])
PRIOR = np.array([[0.1, 0.2, np.inf], [0.05, 0.1, np.inf]])
MEAN = np.array([[0.8, -1.9, 0.0], [0.3, 0.8, 0.0]])
PARAMETERS = {"position": Free(TRUE + 0.2, prior=(MEAN, PRIOR), max=[[np.inf, np.inf, np.inf], [9.0, 9.0, 9.0]])}


@pytest.fixture(scope="module")
def result():
    return fullbody.fit(setup, PARAMETERS, DATA)


def test_each_number_of_an_array_is_a_parameter_with_its_own_prior(result):
    assert result.names[:4] == ("position[0, 0]", "position[0, 1]", "position[0, 2]", "position[1, 0]")
    # Each number has a normal measurement and a normal prior: the posterior has the sum of their weights.
    weights = SIGMA**-2 + PRIOR**-2.0
    expected = (TRUE * SIGMA**-2 + MEAN * PRIOR**-2.0) / weights
    np.testing.assert_allclose(result.values["position"], expected, atol=1e-9)
    np.testing.assert_allclose(result.sigma["position"], weights**-0.5, rtol=1e-8)
    np.testing.assert_allclose(result.covariance, np.diag(1 / weights.ravel()), atol=1e-9)
    assert result.dof == 6 + 4 - 6
    assert not result.differenced


def test_a_number_of_an_array_may_end_at_its_bound():
    held = fullbody.fit(setup, {"position": Free(TRUE - 0.2, max=TRUE + np.array([[0, 0, 0], [-0.1, 1, 1]]))}, DATA)
    assert "position[1, 0]" in held.at_bounds
    assert abs(held.values["position"][1, 0] - 0.2) < 1e-9


def test_arrays_and_numbers_may_stand_side_by_side_with_units():
    def with_units(position, shift):
        system, state = setup((position + shift).to_value("km"))
        return fullbody.System(system.bodies, units=("km", "hour", "kg")), state

    data = observing.Measured("positions", positions_of, TRUE.ravel() * u.km, 1 * u.m, [0.0, 1.0])
    shift = Free(0.1 * u.km, prior=(0.05 * u.km, 2 * u.m))
    result_with_units = fullbody.fit(with_units, {"position": Free(TRUE * 1e3 * u.m), "shift": shift}, data)
    assert result_with_units.values["position"].unit == u.m
    np.testing.assert_allclose(result_with_units.values["position"].to_value("km"), TRUE - 0.05, atol=1e-9)
    assert abs(result_with_units.values["shift"].to_value("m") - 50) < 1e-6
    # Each number has the error of the data and that of the shift.
    np.testing.assert_allclose(result_with_units.sigma["position"].to_value("m"), np.full((2, 3), 5**0.5), rtol=1e-6)


def test_draws_are_arrays_that_sweeps_take(result):
    draws = result.draw(2000, 1)
    assert draws.columns["position"].shape == (2000, 2, 3)
    spread = draws.columns["position"].std(axis=0)
    np.testing.assert_allclose(spread, result.sigma["position"], rtol=0.1)
    few = result.draw(3, 1)
    table = fullbody.sweep(setup, few, 1.0, measure=lambda run: {"x": run.position[0, 1, 0]})
    np.testing.assert_allclose(table.x.values, few.columns["position"][:, 1, 0])
    assert table.position.dims == ("row", "position_0", "position_1")


def test_a_store_of_a_sweep_knows_rows_of_arrays_again(result, tmp_path):
    few, options = result.draw(3, 1), {"measure": lambda run: {"x": run.position[0, 1, 0]}, "store": tmp_path / "s"}
    first = fullbody.sweep(setup, few, 1.0, key="positions", **options)
    second = fullbody.sweep(setup, few, 1.0, key="positions", **options)
    assert first.identical(second)


def test_files_keep_arrays(result, tmp_path):
    result.save(tmp_path / "fit.nc")
    again = fullbody.load(tmp_path / "fit.nc")
    assert again == result
    np.testing.assert_array_equal(again.values["position"], result.values["position"])
    np.testing.assert_array_equal(again.minima[0].values["position"], result.minima[0].values["position"])
    np.testing.assert_array_equal(again.parameters.sigma, result.parameters.sigma)
    np.testing.assert_array_equal(again.parameters.upper, result.parameters.upper)


def test_the_posterior_takes_arrays_and_its_gradient_is_flat(result):
    value, gradient = result.log_posterior({"position": result.values["position"] + 0.01}, gradient=True)
    pulls = 0.01 * (SIGMA**-2 + PRIOR**-2.0).ravel()
    np.testing.assert_allclose(gradient, -pulls, atol=1e-6)
    assert value == result.log_posterior((result.values["position"] + 0.01).ravel())
    refused(r"value of position has shape \(6,\); expected \(2, 3\)", result.log_posterior, {"position": np.zeros(6)})
    refused(r"values has 'position\[0, 0\]'", result.log_posterior, {"position[0, 0]": 1.0})


def test_samples_have_the_dimensions_of_the_array(result):
    samples = result.sample(steps=15, walkers=12, rng=3)
    assert samples.position.dims == ("chain", "draw", "position_dim_0", "position_dim_1")
    np.testing.assert_allclose(samples.position.std(("chain", "draw")), result.sigma["position"], rtol=0.6)
    mean = result.derived(lambda run: run.position[0].mean(), [0.0], samples=samples, n=20, rng=1)
    assert abs(mean.sigma / np.sqrt(np.sum(result.sigma["position"] ** 2)) * 6 - 1) < 0.6
    figure = result.plot.corner(samples)
    assert len(figure.axes) == 36
    plt.close(figure)


def test_starts_may_be_arrays():
    several = fullbody.fit(
        setup,
        {"position": Free(TRUE, min=-5.0, max=5.0)},
        DATA,
        starts=[{"position": TRUE + 1}, {"position": TRUE - 1}],
    )
    np.testing.assert_allclose(several.values["position"], TRUE, atol=1e-9)
    assert several.minima[0].starts == 2
    spread = fullbody.fit(setup, {"position": Free(TRUE, min=-5.0, max=5.0)}, DATA, starts=3, rng=1)
    assert spread.minima[0].starts == 3


def test_observations_may_take_arrays():
    def data(offset):
        return observing.Measured(
            "positions",
            lambda run: run.position[0].ravel() + np.tile(offset, 2),
            np.ravel(TRUE) + 0.5,
            SIGMA,
            [0.0, 1.0],
        )

    def still():
        return setup(TRUE)

    shifted = fullbody.fit(still, {"offset": Free([0.0, 0.1, 0.2])}, data)
    np.testing.assert_allclose(shifted.values["offset"], 0.5, atol=1e-9)
    np.testing.assert_allclose(shifted.sigma["offset"], SIGMA / np.sqrt(2), rtol=1e-6)


def test_a_parameter_next_to_zero_has_the_size_of_its_prior():
    # A tenth of its error: steps relative to a value of 1e-9 would change nothing.
    parameters = Parameters({"x": Free(1e-9, prior=(0.0, 2.0)), "y": Free([3.0, 0.0], prior=(0.0, [np.inf, 0.5]))})
    assert [parameters.size(k, value) for k, value in enumerate(parameters.start)] == [0.2, 3.0, 0.05]
    assert parameters.size(1, -4.0) == 4.0
