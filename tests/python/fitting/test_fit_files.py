"""Copies, files and tables of fits, and quantities that are derived from them."""

import copy
import pickle

import fullbody
import numpy as np
import pytest
from support import refused
from support.fits import START, pair


def test_a_fit_is_copied_pickled_and_saved(fitted, tmp_path):
    path = tmp_path / "fit.nc"
    fitted.save(path)
    read = fullbody.load(path)
    for other in (copy.deepcopy(fitted), pickle.loads(pickle.dumps(fitted)), read):
        assert other == fitted
        assert other.values == fitted.values
        np.testing.assert_array_equal(other.draw(5, 1).columns["mass"], fitted.draw(5, 1).columns["mass"])
        np.testing.assert_allclose(other.run.position[-1], fitted.run.position[-1], rtol=1e-13)
        assert repr(other) == repr(fitted)
    assert read.system == fitted.system
    assert read.state == fitted.state
    refused("keeps neither the setup nor the observations", lambda: read.log_posterior(START))
    assert fitted != fullbody.load(path).values


def test_the_table_of_a_fit_has_its_values(fitted):
    table = fitted.to_table()
    assert list(table["parameter"]) == list(fitted.names)
    assert list(table["value"]) == list(fitted.values.values())
    assert list(table["sigma"]) == list(fitted.sigma.values())
    assert table.meta["dof"] == fitted.dof


def test_a_derived_quantity_has_the_error_of_its_derivatives(fitted):
    product = fitted.derived(lambda run: run.system.masses[0] ** 2)
    assert product.value == pytest.approx(fitted.values["mass"] ** 2, rel=1e-12)
    assert product.sigma == pytest.approx(2 * fitted.values["mass"] * fitted.sigma["mass"], rel=1e-6)

    def separation(run):
        return np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1).mean()

    times = np.linspace(0.0, 10.0, 21)
    mean = fitted.derived(separation, times)
    columns = fitted.draw(300, 1).columns
    draws = [pair(mass, a) for mass, a in zip(columns["mass"], columns["a"], strict=True)]
    values = [separation(system.integrate(state, 10.0, output=times)) for system, state in draws]
    assert mean.sigma == pytest.approx(np.std(values), rel=0.2)


@pytest.mark.parametrize("calls", [1, 2])
def test_a_derived_quantity_of_changing_shape_is_refused(fitted, calls):
    shapes = iter([1] * calls)
    refused(
        r"cannot be differentiated .*gave shape \(2,\); expected \(1,\)",
        lambda: fitted.derived(lambda run: np.ones(next(shapes, 2)) * run.system.masses[0]),
    )
