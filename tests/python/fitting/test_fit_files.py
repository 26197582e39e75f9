"""Copies, files and tables of fits, and quantities that are derived from them."""

import copy
import pickle

import fullbody
import numpy as np
import pytest
from support import refused
from support.fits import START, pair


def test_a_fit_is_copied_pickled_and_saved(found, tmp_path):
    path = tmp_path / "fit.nc"
    found.save(path)
    read = fullbody.load(path)
    for other in (copy.deepcopy(found), pickle.loads(pickle.dumps(found)), read):
        assert other == found
        assert other.values == found.values
        np.testing.assert_array_equal(other.draw(5, 1).columns["mass"], found.draw(5, 1).columns["mass"])
        np.testing.assert_allclose(other.run.position[-1], found.run.position[-1], rtol=1e-13)
        assert repr(other) == repr(found)
    assert read.system == found.system
    assert read.state == found.state
    refused("keeps neither the setup nor the observations", lambda: read.log_posterior(START))
    assert found != fullbody.load(path).values


def test_a_fit_from_a_file_draws_its_residuals(found, tmp_path):
    pytest.importorskip("matplotlib")
    found.save(tmp_path / "fit.nc")
    (ax,) = fullbody.load(tmp_path / "fit.nc").plot.residuals()
    columns = [line.get_ydata() for line in ax.lines]
    np.testing.assert_array_equal(np.stack(columns, axis=1), np.reshape(found.pulls[0], (len(found.pulls[0]), -1)))


def test_the_table_of_a_fit_has_its_values(found):
    table = found.to_table()
    assert list(table["parameter"]) == list(found.names)
    assert list(table["value"]) == list(found.values.values())
    assert list(table["sigma"]) == list(found.sigma.values())
    assert table.meta["dof"] == found.dof


def test_a_derived_quantity_has_the_error_of_its_derivatives(found):
    product = found.derived(lambda run: run.system.masses[0] ** 2)
    assert product.value == pytest.approx(found.values["mass"] ** 2, rel=1e-12)
    assert product.sigma == pytest.approx(2 * found.values["mass"] * found.sigma["mass"], rel=1e-6)

    def separation(run):
        return np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1).mean()

    times = np.linspace(0.0, 10.0, 21)
    mean = found.derived(separation, times)
    columns = found.draw(300, 1).columns
    draws = [pair(mass, a) for mass, a in zip(columns["mass"], columns["a"], strict=True)]
    values = [separation(system.integrate(state, 10.0, output=times)) for system, state in draws]
    assert mean.sigma == pytest.approx(np.std(values), rel=0.2)


@pytest.mark.parametrize("calls", [1, 2])
def test_a_derived_quantity_of_changing_shape_is_refused(found, calls):
    shapes = iter([1] * calls)
    refused(
        r"cannot be differentiated .*gave shape \(2,\); expected \(1,\)",
        lambda: found.derived(lambda run: np.ones(next(shapes, 2)) * run.system.masses[0]),
    )
