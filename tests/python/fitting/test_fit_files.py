"""Copies, files and tables of fits, and quantities that are derived from them."""

import copy
import pickle

import fullbody
import numpy as np
import pytest
from support import refused
from support.fits import START, pair


def test_a_fit_is_copied_pickled_and_saved(result, tmp_path):
    path = tmp_path / "fit.nc"
    result.save(path)
    read = fullbody.load(path)
    for other in (copy.deepcopy(result), pickle.loads(pickle.dumps(result)), read):
        assert other == result
        assert other.values == result.values
        np.testing.assert_array_equal(other.draw(5, 1).columns["mass"], result.draw(5, 1).columns["mass"])
        np.testing.assert_allclose(other.run.position[-1], result.run.position[-1], rtol=1e-13)
        assert repr(other) == repr(result)
    assert read.system == result.system
    assert read.state == result.state
    refused("keeps neither the setup nor the observations", lambda: read.log_posterior(START))
    assert result != fullbody.load(path).values


def test_a_fit_from_a_file_draws_its_residuals(result, tmp_path):
    pytest.importorskip("matplotlib")
    result.save(tmp_path / "fit.nc")
    (ax,) = fullbody.load(tmp_path / "fit.nc").plot.residuals()
    columns = [line.get_ydata() for line in ax.lines]
    np.testing.assert_array_equal(np.stack(columns, axis=1), np.reshape(result.pulls[0], (len(result.pulls[0]), -1)))


def test_the_table_of_a_fit_has_its_values(result):
    table = result.to_table()
    assert list(table["parameter"]) == list(result.names)
    assert list(table["value"]) == list(result.values.values())
    assert list(table["sigma"]) == list(result.sigma.values())
    assert table.meta["dof"] == result.dof


def test_a_derived_quantity_has_the_error_of_its_derivatives(result):
    product = result.derived(lambda run: run.system.masses[0] ** 2)
    assert product.value == pytest.approx(result.values["mass"] ** 2, rel=1e-12)
    assert product.sigma == pytest.approx(2 * result.values["mass"] * result.sigma["mass"], rel=1e-6)

    def separation(run):
        return np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1).mean()

    times = np.linspace(0.0, 10.0, 21)
    mean = result.derived(separation, times)
    columns = result.draw(300, 1).columns
    draws = [pair(mass, a) for mass, a in zip(columns["mass"], columns["a"], strict=True)]
    values = [separation(system.integrate(state, 10.0, output=times)) for system, state in draws]
    assert mean.sigma == pytest.approx(np.std(values), rel=0.2)


@pytest.mark.parametrize("calls", [1, 2])
def test_a_derived_quantity_of_changing_shape_is_refused(result, calls):
    shapes = iter([1] * calls)
    refused(
        r"cannot be differentiated .*gave shape \(2,\); expected \(1,\)",
        lambda: result.derived(lambda run: np.ones(next(shapes, 2)) * run.system.masses[0]),
    )
