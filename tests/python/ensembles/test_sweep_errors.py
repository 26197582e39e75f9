"""Errors of sweeps: in single rows, which keep the others, and of arguments."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import fullbody
import numpy as np
import pandas as pd
import pytest
from astropy import units as u
from fullbody.ensembles import draws, paired
from fullbody.errors import InconsistentInput
from scipy import stats
from support import refused
from support.maps import angle, circle, expected

GRID = {"mass": [0.1, 0.5, 0.9], "distance": [1.0, 2.0]}
BALLS = [fullbody.Body(fullbody.Sphere(0.1), mass=1.0, name=name) for name in "AB"]


def failing_setup(kind):
    """A row of its own for each thing that goes wrong."""
    if kind == "setup":
        raise ValueError("no such setup")
    if kind == "input":
        return circle(mass=-1.0)
    if kind == "pair":
        return circle
    still = np.zeros((2, 3))
    if kind in ("collision", "overlap"):
        apart = 1.0 if kind == "collision" else 0.1
        return fullbody.System(BALLS, G=1.0), fullbody.State([[0, 0, 0], [apart, 0, 0]], still)
    if kind == "singular":
        system, state = circle()
        return system, state.replace(velocity=still)
    return circle(distance={"measure": 3.0, "ragged": 4.0, "kind": 5.0}.get(kind, 1.0))


def failing_measure(run):
    first = float(np.linalg.norm(run.position[0, 1] - run.position[0, 0])) if len(run) else np.nan
    if first == 3.0:
        raise KeyError("nothing there")
    if first == 5.0:
        return [first]
    return {"first": first, "reason": run.stop_reason, "list": [1.0] * (2 if first == 4.0 else 3)}


def test_an_error_of_a_row_affects_no_other_row():
    kinds = ["good", "setup", "input", "pair", "overlap", "collision", "singular", "measure", "kind", "ragged", "well"]
    result = fullbody.sweep(failing_setup, {"kind": kinds}, 2.0, measure=failing_measure)
    failures = {kind: tuple(str(result[name].sel(kind=kind).values) for name in FAILURE) for kind in kinds}
    assert failures["good"] == failures["well"] == ("", "", "")
    assert failures["setup"] == ("ValueError", "no such setup", "setup")
    assert failures["input"][::2] == ("InvalidInput", "setup")
    assert "-1.0" in failures["input"][1]
    assert failures["pair"][::2] == ("InvalidInput", "setup")
    assert "expected (system, state)" in failures["pair"][1]
    assert failures["overlap"][::2] == ("BodiesOverlap", "run")
    assert failures["collision"][::2] == ("BodiesOverlap", "run")
    assert "A and B" in failures["collision"][1]
    assert failures["singular"][0] in ("StepSizeTooSmall", "BodiesOverlap")
    assert failures["measure"] == ("KeyError", "'nothing there'", "measure")
    text = "measure gives [5.0]; expected a dict of names to numbers, arrays or texts"
    assert failures["kind"] == ("InvalidInput", text, "measure")
    assert "list of shape (2,), but of shape (3,) in row 0; expected one shape throughout" in failures["ragged"][1]
    # What there is of a run is measured; the collision of two spheres at rest is a result.
    assert result.reason.sel(kind="collision") == "unfinished"
    assert result["first"].sel(kind="collision") == 1.0
    assert np.isnan(result["first"].sel(kind=["setup", "input", "overlap", "measure", "kind"])).all()
    assert np.isnan(result["list"].sel(kind="ragged")).all()
    assert (result["first"].sel(kind=["good", "well"]) == 1.0).all()
    assert not np.isnan(result.where(result.error == "")["first"].sel(kind="good"))


FAILURE = ("error", "error_text", "error_stage")


def gap(run):
    return {"gap": np.linalg.norm(run.position[0, 1] - run.position[0, 0])}


def fussy(run, points=1):
    """A measure that fails for masses above a half and for runs that were cut short."""
    if run.stop_reason != "end":
        raise LookupError("no end")
    if run.system.masses[1] > 0.5:
        raise ArithmeticError("too heavy")
    return {"fuss": [1.0] * points}


def test_a_failing_measure_does_not_affect_the_others():
    first, last = GRID["distance"]
    measures = [gap, partial(fussy, points=2), angle]
    result = fullbody.sweep(circle, GRID, 0.8, measure=measures)
    np.testing.assert_allclose(result.angle, expected(result.mass, result.distance, 0.8), rtol=1e-12)
    assert result.gap.values.tolist() == [[first, last]] * 3
    np.testing.assert_array_equal(result.fuss[..., 1], [[1.0] * 2, [1.0] * 2, [np.nan] * 2])
    failures = [tuple(str(result[name][row, 1].values) for name in FAILURE) for row in range(3)]
    assert failures == [("", "", "")] * 2 + [("ArithmeticError", "fussy: too heavy", "measure")]


def test_the_text_of_a_row_names_all_its_errors():
    def second(run):
        if run.stop_reason != "end":
            raise KeyError("nothing")
        return {}

    divided = [gap, lambda run: {"one": 1 / (run.stop_reason == "end")}]
    for measure, failures in (
        (fussy, "LookupError in measure: no end"),
        (
            [gap, fussy, second],
            "LookupError in measure: fussy: no end; also KeyError in measure: second: 'nothing'",
        ),
        (divided, "ZeroDivisionError in measure: number 1: division by zero"),
    ):
        result = fullbody.sweep(failing_setup, {"kind": ["collision", "good"]}, 2.0, measure=measure)
        error, text, stage = (str(result[name][0].values) for name in FAILURE)
        assert (error, stage) == ("BodiesOverlap", "run")
        assert text.startswith("A and B")
        assert text.partition("; also ")[2] == failures


def test_values_of_a_row_are_kept_beside_an_invalid_one():
    def measure(run):
        heavy = run.system.masses[1] > 0.5
        return {"wrong": object() if heavy else 0.0, "list": [0.0] * (1 + heavy), "end": run.time[-1]}

    result = fullbody.sweep(circle, {"mass": [0.5, 0.9]}, 0.25, measure=measure)
    assert result.end.values.tolist() == [0.25, 0.25]
    assert np.isnan(result.wrong[1])
    assert np.isnan(result["list"][1]).all()
    text = str(result.error_text[1].values)
    assert text.startswith("measure gives wrong = <object")
    assert "; also InvalidInput in measure: measure gives list of shape (2,), but of shape (1,) in row 0" in text


def test_measures_that_give_one_name_twice_are_refused():
    with pytest.warns(InconsistentInput, match="ended with an error"):
        result = fullbody.sweep(circle, {"mass": [0.5]}, 0.25, measure=[gap, lambda run: {"gap": 0.0, "end": 1.0}])
    assert (float(result.gap[0]), float(result.end[0])) == (1.0, 1.0)
    assert str(result.error_text[0].values).startswith("number 1: measure gives gap, which a measure before it gives")


def test_a_sweep_whose_rows_all_fail_causes_a_warning(tmp_path):
    def setup(mass):
        if mass > 0.25:
            raise ValueError(f"{mass} is too heavy")
        return circle(mass)

    text = "all 3 rows of the sweep ended with an error; that of the first is ValueError in setup: 0.3 is too heavy"
    for storage in ({}, *[{"store": tmp_path / "map.nc", "key": "heavy"}] * 2):
        with pytest.warns(InconsistentInput, match=f"^{text}") as caught:
            result = fullbody.sweep(setup, {"mass": [0.3, 0.4, 0.5]}, 0.1, measure=angle, **storage)
        assert [item.filename for item in caught] == [__file__]
        assert (result.error == "ValueError").all()
    with pytest.warns(InconsistentInput, match="^the only row of the sweep ended with an error; that of the first is "):
        fullbody.sweep(setup, {"mass": 0.3}, 0.1, measure=angle)
    fullbody.sweep(setup, {"mass": [0.2, 0.3, 0.4]}, 0.1, measure=angle)


@pytest.mark.filterwarnings("ignore:all . rows of the sweep ended with an error")
def test_a_measure_takes_no_name_of_a_parameter_or_dimension():
    def measure(run):
        return {"a": np.zeros(2), "a_0": 1.0}

    result = fullbody.sweep(circle, {"mass": [0.1, 0.2, 0.3]}, 0.1, measure=measure)
    assert result["a"].dims == ("mass", "a_0")
    assert (result.error_text == "measure gives a_0, but a_0 is the name of a dimension of a").all()
    result = fullbody.sweep(lambda a_0: circle(a_0), {"a_0": [0.1, 0.2, 0.3]}, 0.1, measure=measure)
    failures = [f"measure gives {name}, but a_0 is the name of a parameter or kept for errors" for name in ("a", "a_0")]
    assert (result.error_text == "; also InvalidInput in measure: ".join(failures)).all()


def test_text_that_a_file_cannot_hold_is_an_error_of_its_row(tmp_path):
    def measure(run):
        match round(10 * run.system.masses[1]):
            case 1:
                raise ValueError("zero \0 and half a letter \udc80")
            case 2:
                return {"text": "half a letter \udc80"}
            case 3:
                return {"text": "zero \0"}
            case 4:
                return {".": 1.0}
        return {"text": "whole"}

    masses = [0.1, 0.2, 0.3, 0.4, 0.5]
    result = fullbody.sweep(circle, {"mass": masses}, 0.1, measure=measure, store=tmp_path / "map.nc", key="files")
    failures = result.error_text.values.tolist()
    assert failures[0] == r"zero \0 and half a letter \udc80"
    assert "expected text that UTF-8 has" in failures[1]
    assert "expected text that UTF-8 has" in failures[2]
    assert "the name '.'" in failures[3]
    assert result["text"].values.tolist() == ["", "", "", "", "whole"]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"setup": 3}, "setup is 3; expected a function"),
        ({"measure": None}, "measure is None; expected a function, the name of an observable, or a list of them"),
        ({"measure": []}, r"measure is \[\]; expected a function"),
        ({"measure": [angle, 3]}, "measure is .*3]; expected a function, the name"),
        ({"parameters": 3}, "parameters has 3; expected a mapping"),
        ({"parameters": []}, "parameters is empty"),
        ({"parameters": {"mass": []}}, r"mass has shape \(0,\)"),
        ({"parameters": {"mass": [[1.0, 2.0]]}}, r"mass has shape \(1, 2\)"),
        ({"parameters": {"mass": [1.0, "2"]}}, "mass is .*, texts and others"),
        ({"parameters": {"mass": [1.0, None]}}, "mass is"),
        ({"parameters": {"mass": [1.0, 2.0 * u.kg]}}, "mass mixes Quantities and plain numbers"),
        ({"parameters": {"mass": np.ma.array([1.0, 2.0], mask=[0, 1])}}, "mass has 1 masked"),
        ({"parameters": {"mass": stats.norm()}}, r"fullbody.ensembles.draws\(..., mass=...\)"),
        ({"parameters": {"masss": [1.0]}}, "'masss', which the setup does not take; did you mean 'mass'"),
        ({"parameters": {"rng": [1.0]}}, "kept for the random numbers"),
        ({"parameters": {"not a name": [1.0]}}, "'not a name'"),
        ({"parameters": [{"mass": [1.0]}, {"mass": [2.0]}]}, "'mass' twice"),
        ({"parameters": [draws(2), draws(3)]}, "two dimensions of the name 'draw'"),
        ({"parameters": paired(mass=[1.0], distance=[1.0, 2.0])}, "mass has 1, distance has 2; expected one length"),
        ({"parameters": paired()}, "there are none"),
        ({"parameters": {"error": [0.1]}, "setup": lambda error: None}, "'error', which is kept for what goes wrong"),
        ({"parameters": {"mass": ["zero \0."]}}, "mass is"),
        ({"parameters": pd.DataFrame({"mass": [0.1]}, index=pd.Index(["a"], name="a/b"))}, "name 'a/b'"),
        ({"parameters": {"mass": np.ones(10**6), "distance": np.ones(10**6)}}, "rows; expected at most 100000000"),
        ({"parameters": draws(10**12, mass=stats.norm()), "rng": 1}, "rows; expected at most"),
        ({"output": "end"}, "output is 'end'; expected numbers, or text with a unit"),
        ({"executor": ThreadPoolExecutor}, "executor is <class"),
        ({"parameters": draws(2, mass=stats.norm())}, "rng is None, but mass is drawn"),
        ({"parameters": draws(2, mass=lambda rng: rng.normal(size=2)), "rng": 1}, r"shape \(2,\); expected one number"),
        ({"rng": 1}, "rng is 1, but nothing is drawn"),
        ({"rng": -1}, "rng is -1; expected a whole number, zero or above"),
        ({"rng": 1.5}, "rng is 1.5; expected"),
        ({"rng": [1, 2]}, r"rng is \[1, 2\]; expected a whole number"),
        ({"setup": lambda mass, rng: None}, "rng is None, but the setup takes rng"),
        ({"measure": ["libration", "frate"]}, "measure has 'frate', which is no observable; did you mean 'fate'"),
        ({"setup": lambda mass, size: None}, "no 'size', which the setup needs"),
        ({"integrator": "ias15"}, "integrator is 'ias15'"),
        ({"events": [1]}, "events has 1"),
        ({"until": "soon"}, "until is 'soon'; expected numbers, or text with a unit, such as '2.5 h'"),
        ({"threads": 0}, "threads is 0; expected a whole number from 1 to 1024"),
        ({"threads": 5000, "executor": 3}, "threads is 5000; expected a whole number from 1 to 1024"),
        ({"chunk": 2.5}, "chunk is 2.5; expected a whole number above zero"),
        ({"executor": 3}, "executor is 3; expected one with the interface of concurrent.futures"),
    ],
)
def test_bad_arguments_of_sweeps_are_refused(change, text):
    arguments = {"setup": circle, "parameters": {"mass": [0.1]}, "until": 0.1, "measure": angle} | change
    refused(text, lambda: fullbody.sweep(**arguments))


def test_bad_draws_are_refused():
    refused("n is 0", lambda: draws(0))
    refused("mass is 3; expected a function", lambda: draws(2, mass=3))
