"""Maps over parameters: their rows, their results, and errors in single rows."""

import fullbody
import numpy as np
import pandas as pd
import pytest
from astropy import units as u
from fullbody import observables
from fullbody.ensembles import draws, paired
from fullbody.errors import InvalidInput
from numpy.random import SeedSequence, default_rng
from scipy import stats
from support.maps import angle, assert_same, circle, expected

GRID = {"mass": [0.1, 0.5, 0.9], "distance": [1.0, 2.0]}


def test_a_grid_has_the_closed_forms_of_its_parameters():
    result = fullbody.sweep(circle, GRID, 0.8, measure=angle)
    assert dict(result.sizes) == {"mass": 3, "distance": 2, "place_0": 2, "place_1": 3}
    assert result.angle.dims == ("mass", "distance")
    assert result.place.dims == ("mass", "distance", "place_0", "place_1")
    np.testing.assert_allclose(result.angle, expected(result.mass, result.distance, 0.8), rtol=1e-12)
    assert (result.error == "").all()
    system, state = circle(0.5, 2.0)
    assert (result.place.sel(mass=0.5, distance=2.0).values == system.integrate(state, 0.8).position[-1]).all()


def test_a_single_value_is_a_parameter_without_a_dimension():
    result = fullbody.sweep(circle, {"mass": 0.5, "distance": (1.0, 2.0)}, 0.5, measure=angle)
    assert result.angle.dims == ("distance",)
    assert result.mass == 0.5
    alone = fullbody.sweep(circle, {"mass": 0.5}, 0.5, measure=angle)
    assert alone.angle.dims == ()
    assert float(alone.angle) == float(result.angle[0])


def test_paired_columns_and_tables_have_one_dimension():
    rows = {"mass": [0.1, 0.5, 0.9], "distance": [1.0, 1.5, 2.0]}
    result = fullbody.sweep(circle, paired(**rows), 0.5, measure=angle)
    assert result.angle.dims == ("row",)
    assert result.distance.dims == ("row",)
    np.testing.assert_allclose(result.angle, expected(np.array(rows["mass"]), np.array(rows["distance"]), 0.5))
    table = fullbody.sweep(circle, pd.DataFrame(rows), 0.5, measure=angle)
    assert_same(result, table)
    named = pd.DataFrame(rows, index=pd.Index(["x", "y", "z"], name="sample"))
    result = fullbody.sweep(circle, named, 0.5, measure=angle)
    assert result.angle.dims == ("sample",)
    assert float(result.angle.sel(sample="y")) == float(table.angle[1])


def test_a_list_of_parameters_is_their_product():
    result = fullbody.sweep(
        lambda mass, distance, kind: circle(mass, distance * (2.0 if kind == "wide" else 1.0)),
        [{"kind": ["near", "wide"]}, paired(mass=[0.1, 0.5, 0.9], distance=[1.0, 1.5, 2.0])],
        0.5,
        measure=angle,
    )
    assert result.angle.dims == ("kind", "row")
    wide = expected(result.mass, 2.0 * result.distance, 0.5)
    np.testing.assert_allclose(result.angle.sel(kind="wide"), wide, rtol=1e-12)


def test_values_of_parameters_keep_their_types_in_the_setup():
    received = []

    def setup(**options):
        received.append(options)
        return circle()

    column = {"a": [1, 2], "b": np.array([1.5]), "c": ["x"], "d": [True], "e": [1, 2] * u.km, "f": 3 * u.deg}
    fullbody.sweep(setup, column, 0.1, measure=lambda run: {})
    assert len(received) == 4
    assert received[1] == {"a": 1, "b": 1.5, "c": "x", "d": True, "e": 2 * u.km, "f": 3 * u.deg}
    assert [type(received[0][name]) for name in "abcd"] == [int, float, str, bool]


def test_maps_keep_units_of_parameters_and_results():
    def setup(distance):
        body = fullbody.Body(fullbody.PointMass(), mass=1e12 * u.kg)
        system = fullbody.System([body, body], units=True)
        return system, fullbody.State([[0, 0, 0], [1, 0, 0]] * distance, np.zeros((2, 3)) * u.km / u.s)

    def measure(run):
        gap = np.linalg.norm(run.position[0, 1] - run.position[0, 0])
        return {"gap": gap.to("m") if gap > 2.5 * u.km else gap}

    result = fullbody.sweep(setup, {"distance": [2000, 3000] * u.m}, "1 min", measure=measure)
    assert result.distance.attrs["units"] == "m"
    assert result.gap.attrs["units"] == "km"
    np.testing.assert_allclose(result.gap, [2.0, 3.0], rtol=1e-15)


def test_draws_depend_on_the_seed_and_the_row_alone():
    parts = [draws(3, mass=lambda rng: rng.uniform(0.1, 0.9)), {"distance": [1.0, 2.0]}]
    result = fullbody.sweep(circle, parts, 0.5, measure=angle, rng=7)
    assert result.mass.dims == result.angle.dims == ("draw", "distance")
    # The first of two streams of each row's own is for the parameters, the second for the setup.
    streams = [row.spawn(2) for row in SeedSequence(7).spawn(6)]
    assert result.mass.values.ravel().tolist() == [default_rng(first).uniform(0.1, 0.9) for first, _ in streams]
    np.testing.assert_allclose(result.angle, expected(result.mass, result.distance, 0.5), rtol=1e-12)

    def setup(distance, rng):
        return circle(rng.uniform(0.1, 0.9), distance)

    inside = fullbody.sweep(setup, [draws(3), {"distance": [1.0, 2.0]}], 0.5, measure=angle, rng=7, chunk=4)
    mass = np.reshape([default_rng(second).uniform(0.1, 0.9) for _, second in streams], (3, 2))
    np.testing.assert_allclose(inside.angle, expected(mass, result.distance.values, 0.5), rtol=1e-12)


def test_a_generator_draws_the_seed():
    parts = [draws(3, mass=lambda rng: rng.uniform(0.1, 0.9))]
    result = fullbody.sweep(circle, parts, 0.5, measure=angle, rng=default_rng(7))
    seed = int(default_rng(7).integers(2**63))
    assert_same(result, fullbody.sweep(circle, parts, 0.5, measure=angle, rng=seed))


def test_draws_may_be_distributions_of_scipy_and_quantities():
    def setup(mass, distance):
        return circle(mass, distance.to_value("km"))

    parts = draws(4, mass=stats.uniform(0.1, 0.8), distance=lambda rng: rng.normal(2.0, 0.1) * u.km)
    result = fullbody.sweep(setup, parts, 0.5, measure=angle, rng=12)
    assert result.distance.attrs == {"units": "km"}
    rng = default_rng(SeedSequence(12).spawn(1)[0].spawn(2)[0])
    assert float(result.mass[0]) == stats.uniform(0.1, 0.8).rvs(random_state=rng)
    np.testing.assert_allclose(result.angle, expected(result.mass, result.distance, 0.5), rtol=1e-12)


def test_the_end_of_a_run_may_be_a_parameter_or_a_function():
    grid = {"mass": [0.1, 0.5], "distance": [1.0, 2.0]}
    period = fullbody.sweep(
        circle, grid, lambda mass, distance: 2 * np.pi / expected(mass, distance, 1.0) / 4, measure=angle
    )
    np.testing.assert_allclose(period.angle, np.pi / 2, rtol=1e-12)
    named = fullbody.sweep(lambda end: circle(), {"end": [0.1, 0.2]}, "end", measure=angle)
    np.testing.assert_allclose(named.angle, expected(0.5, 1.0, named.end), rtol=1e-12)


def test_a_measure_may_return_text_and_omit_values():
    def measure(run):
        far = run.position[0, 1, 0] > 1.5
        return {"fate": "far", "radius": None} if far else {"fate": "near", "radius": 1.0, "also": True}

    result = fullbody.sweep(circle, {"distance": [1.0, 2.0]}, 0.1, measure=measure)
    assert result.fate.values.tolist() == ["near", "far"]
    np.testing.assert_array_equal(result.radius, [1.0, np.nan])
    np.testing.assert_array_equal(result.also, [1.0, np.nan])


def test_names_of_observables_are_measures():
    def setup(angle):
        system, state = fullbody.systems.kw4(units=True)
        return system, state.rotated("Beta", [0, 0, 1], angle)

    def tumbling(run):
        return observables.tumbles(run, limit="30 deg", body="Beta", about="Alpha")

    measures = ["libration", tumbling, "spin_precession"]
    result = fullbody.sweep(setup, {"angle": [0.1, 0.6]}, "200 h", measure=measures, output="0.5 h")
    for k, start in enumerate((0.1, 0.6)):
        system, state = setup(start)
        run = system.integrate(state, "200 h", output="0.5 h")
        libration, tumbles = observables.libration(run), tumbling(run)
        assert result.libration[k] == libration.amplitude.to_value("rad")
        assert result.libration_period[k] == libration.period.to_value("h")
        assert result.largest_yaw[k] == tumbles.largest[2].to_value("rad")
        assert result.tumbles[k] == float(tumbles.time is not None)
        assert result.spin_precession[k] == observables.spin_precession(run).to_value("rad / h")
    assert result.libration_period.attrs == {"units": "h"}
    assert result.error.values.tolist() == ["", ""]


@pytest.mark.parametrize("order", [[3.0, 1.0, 1.01], [1.0, 3.0, 1.01], [3.0, 2.9]])
def test_the_unit_of_a_variable_comes_from_any_row_that_has_one(order):
    """A body that tumbles has no libration: its row has nan, and takes nothing from the others."""

    def setup(factor):
        system, state = fullbody.systems.kw4("ellipsoid", units=True)
        return system, state.replace(spin=state.spin * [[1.0], [factor]])

    def some(run):
        tumbling = run.spin[0, 1, 2] > 0.5 * u.rad / u.hour
        return {"angle": None if tumbling else 3.0 * u.deg, "axes": None if tumbling else [1.0, 2.0] * u.km}

    result = fullbody.sweep(setup, {"factor": order}, 1.0, measure=some)
    assert result.error.values.tolist() == [""] * len(order)
    with_numbers = [factor < 2.0 for factor in order]
    assert np.isfinite(result.angle.values).tolist() == with_numbers
    if any(with_numbers):
        assert (result.angle.attrs["units"], result.axes.attrs["units"]) == ("deg", "km")
        assert result.axes.shape == (len(order), 2)


@pytest.mark.parametrize(
    "values", [[2**63 + 1, 1], [2**53 + 1, 2], [2**63 - 1, -1], [np.int64(2**62 + 1), 3], [np.uint64(2**63 + 1), 1]]
)
def test_integers_are_kept_exactly(values):
    got = []

    def setup(n):
        got.append(n)
        return circle()

    result = fullbody.sweep(setup, {"n": values}, 0.1, measure=angle, threads=1)
    assert got == [int(value) for value in values] == result.n.values.tolist()
    assert all(type(n) is int for n in got)


@pytest.mark.parametrize("values", [[2**70, 1], [2**63, -1], [2**53 + 1, 0.5]])
def test_integers_that_one_column_cannot_hold_are_refused(values):
    with pytest.raises(InvalidInput, match=r"n is \[.*\], whole numbers that one column cannot hold exactly"):
        fullbody.sweep(lambda n: circle(), {"n": values}, 0.1, measure=angle)


def test_a_setup_may_use_random_numbers_or_none():
    def setup(mass, rng=None):
        return circle(mass if rng is None else rng.uniform())

    result = fullbody.sweep(setup, {"mass": [0.1, 0.2]}, 0.1, measure=angle)
    assert_same(result, fullbody.sweep(circle, {"mass": [0.1, 0.2]}, 0.1, measure=angle))
    drawn = fullbody.sweep(setup, {"mass": [0.1, 0.2]}, 0.1, measure=angle, rng=1)
    assert not np.array_equal(drawn.angle, result.angle)
