"""Results of fits: copies, files and tables, the limit on proposals, warnings, and derived quantities."""

import copy
import pickle
import warnings

import fullbody
import numpy as np
import pytest
from fullbody.errors import InconsistentInput
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


def test_a_fit_that_stops_at_the_limit_on_proposals_shows_no_errors(radar, result):
    far = {"mass": 2.4, "a": 2.45}
    with pytest.warns(InconsistentInput, match="stopped after 2 proposals, the limit"):
        stopped = fullbody.fit(pair, far, radar, proposals=2)
    assert stopped.chi2 > 2.0 * result.chi2
    text = repr(stopped)
    assert text.startswith("Fit, not at a minimum")
    rows = [line.split() for line in text.splitlines() if line.strip().startswith(("mass ", "a "))]
    assert [row[2] for row in rows] == ["-", "-"]
    table = stopped.to_table()
    assert table["sigma"].mask.all()
    assert "correlation" not in table.meta
    complete = fullbody.fit(pair, far, radar, proposals=100)
    assert not complete.message
    assert complete.chi2 == pytest.approx(result.chi2, rel=1e-9)
    refused("proposals is 0; expected a whole number above zero", lambda: fullbody.fit(pair, far, radar, proposals=0))


def test_a_warning_of_a_setup_is_shown_once_a_fit(radar):
    calls = []

    def setup(mass, a):
        warnings.warn(f"mass is {mass:.17g}", UserWarning, stacklevel=1)
        warnings.warn("another one", UserWarning, stacklevel=1)
        calls.append(mass)
        return pair(mass, a)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fit = fullbody.fit(setup, START, radar)
        fit.log_posterior({"mass": 2.35, "a": 2.55})
        fit.derived(lambda run: run.system.masses[0])
    assert len(calls) > 10
    assert [str(item.message) for item in caught] == ["mass is 2.3599999999999999", "another one"]
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="mass is"):
            fullbody.fit(setup, START, radar)


def test_a_derived_quantity_has_the_spread_of_samples(result):
    """The logarithm of the mass has the samples' own standard deviation, to the first order that of the fit."""
    samples = result.sample(steps=60, rng=3).isel(draw=slice(20, None))
    by_samples = result.derived(lambda run: np.log(run.system.masses[0]), samples=samples, n=320, rng=1)
    assert by_samples.value == pytest.approx(np.log(result.values["mass"]), rel=1e-12)
    assert by_samples.draws.shape == (320,)
    assert by_samples.sigma == pytest.approx(float(np.log(samples["mass"]).std(ddof=1)), rel=1e-9)
    assert by_samples.sigma == pytest.approx(result.derived(lambda run: np.log(run.system.masses[0])).sigma, rel=0.3)
    refused(
        "rng is None; expected a whole number",
        lambda: result.derived(lambda run: run.system.masses[0], samples=samples),
    )
    options = {"samples": samples, "n": 10**6, "rng": 1}
    refused(
        "n is 1000000; expected a whole number", lambda: result.derived(lambda run: run.system.masses[0], **options)
    )
    few = {"n": 5, "rng": 1}
    refused("samples is 3; expected a Dataset with mass, a", result.derived, lambda run: 1.0, samples=3, **few)
    results = iter([1.0, 1.0, np.nan])
    refused("result of the derived quantity is nan", result.derived, lambda run: next(results), samples=samples, **few)
