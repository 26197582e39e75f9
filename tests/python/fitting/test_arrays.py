"""Parameters of fits that are arrays: names, values, errors, priors, draws, files and samples."""

import astropy.units as u
import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import observing
from fullbody.fitting import Free
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
def fitted():
    return fullbody.fit(setup, PARAMETERS, DATA)


def test_each_number_of_an_array_is_a_parameter_with_its_own_prior(fitted):
    assert fitted.names[:4] == ("position[0, 0]", "position[0, 1]", "position[0, 2]", "position[1, 0]")
    # Each number has a normal measurement and a normal prior: the posterior has the sum of their weights.
    weights = SIGMA**-2 + PRIOR**-2.0
    expected = (TRUE * SIGMA**-2 + MEAN * PRIOR**-2.0) / weights
    np.testing.assert_allclose(fitted.values["position"], expected, atol=1e-9)
    np.testing.assert_allclose(fitted.sigma["position"], weights**-0.5, rtol=1e-8)
    np.testing.assert_allclose(fitted.covariance, np.diag(1 / weights.ravel()), atol=1e-9)
    assert fitted.dof == 6 + 4 - 6
    assert not fitted.differenced


def test_a_number_of_an_array_may_end_at_its_bound():
    held = fullbody.fit(setup, {"position": Free(TRUE - 0.2, max=TRUE + np.array([[0, 0, 0], [-0.1, 1, 1]]))}, DATA)
    assert "position[1, 0]" in held.at_bounds
    assert abs(held.values["position"][1, 0] - 0.2) < 1e-9


def test_arrays_and_numbers_may_stand_side_by_side_with_units():
    def united(position, shift):
        system, state = setup((position + shift).to_value("km"))
        return fullbody.System(system.bodies, units=("km", "hour", "kg")), state

    data = observing.Measured("positions", positions_of, TRUE.ravel() * u.km, 1 * u.m, [0.0, 1.0])
    shift = Free(0.1 * u.km, prior=(0.05 * u.km, 2 * u.m))
    both = fullbody.fit(united, {"position": Free(TRUE * 1e3 * u.m), "shift": shift}, data)
    assert both.values["position"].unit == u.m
    np.testing.assert_allclose(both.values["position"].to_value("km"), TRUE - 0.05, atol=1e-9)
    assert abs(both.values["shift"].to_value("m") - 50) < 1e-6
    # Each number has the error of the data and that of the shift.
    np.testing.assert_allclose(both.sigma["position"].to_value("m"), np.full((2, 3), 5**0.5), rtol=1e-6)


def test_draws_are_arrays_that_sweeps_take(fitted):
    draws = fitted.draw(2000, 1)
    assert draws.columns["position"].shape == (2000, 2, 3)
    spread = draws.columns["position"].std(axis=0)
    np.testing.assert_allclose(spread, fitted.sigma["position"], rtol=0.1)
    few = fitted.draw(3, 1)
    table = fullbody.sweep(setup, few, 1.0, measure=lambda run: {"x": run.position[0, 1, 0]})
    np.testing.assert_allclose(table.x.values, few.columns["position"][:, 1, 0])
    assert table.position.dims == ("row", "position_0", "position_1")


def test_a_store_of_a_sweep_knows_rows_of_arrays_again(fitted, tmp_path):
    few, options = fitted.draw(3, 1), {"measure": lambda run: {"x": run.position[0, 1, 0]}, "store": tmp_path / "s"}
    first = fullbody.sweep(setup, few, 1.0, key="positions", **options)
    second = fullbody.sweep(setup, few, 1.0, key="positions", **options)
    assert first.identical(second)


def test_files_keep_arrays(fitted, tmp_path):
    fitted.save(tmp_path / "fit.nc")
    again = fullbody.load(tmp_path / "fit.nc")
    assert again == fitted
    np.testing.assert_array_equal(again.values["position"], fitted.values["position"])
    np.testing.assert_array_equal(again.minima[0].values["position"], fitted.minima[0].values["position"])
    np.testing.assert_array_equal(again.parameters.sigma, fitted.parameters.sigma)
    np.testing.assert_array_equal(again.parameters.upper, fitted.parameters.upper)


def test_the_posterior_takes_arrays_and_its_gradient_is_flat(fitted):
    value, gradient = fitted.log_posterior({"position": fitted.values["position"] + 0.01}, gradient=True)
    pulls = 0.01 * (SIGMA**-2 + PRIOR**-2.0).ravel()
    np.testing.assert_allclose(gradient, -pulls, atol=1e-6)
    assert value == fitted.log_posterior((fitted.values["position"] + 0.01).ravel())
    refused(r"value of position has shape \(6,\); expected \(2, 3\)", fitted.log_posterior, {"position": np.zeros(6)})
    refused(r"values has 'position\[0, 0\]'", fitted.log_posterior, {"position[0, 0]": 1.0})


def test_samples_have_the_dimensions_of_the_array(fitted):
    samples = fitted.sample(steps=15, walkers=12, rng=3)
    assert samples.position.dims == ("chain", "draw", "position_dim_0", "position_dim_1")
    np.testing.assert_allclose(samples.position.std(("chain", "draw")), fitted.sigma["position"], rtol=0.6)
    mean = fitted.derived(lambda run: run.position[0].mean(), [0.0], samples=samples, n=20, rng=1)
    assert abs(mean.sigma / np.sqrt(np.sum(fitted.sigma["position"] ** 2)) * 6 - 1) < 0.6
    figure = fitted.plot.corner(samples)
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
