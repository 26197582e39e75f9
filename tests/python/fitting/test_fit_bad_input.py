"""What is wrong with a fit's arguments, observations or setup is named, and Ctrl-C does not lose what was found."""

import os
import signal

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.errors import InconsistentInput, Interrupted, InvalidInput
from fullbody.fitting import Free, Outliers
from support import refused
from support.fits import START, VIEW, pair

TRUE = {"mass": 2.353, "a": 2.55}
BETWEEN = {"a": Free(2.55, min=2.5, max=2.6)}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameters": {}}, "expected a dict of names to starts"),
        ({"parameters": {"a": "wide"}}, "start of a"),
        ({"parameters": {"a": np.nan}}, "expected a finite number"),
        ({"parameters": {"a": 2.5, "b": 1.0}}, "'b', which neither the setup nor observations take"),
        ({"parameters": {"a": Free(2.5, min=3.0)}}, "start of a is 2.5; expected one between"),
        ({"parameters": {"a": Free(2.5, min=3.0, max=2.0)}}, "expected min < max"),
        ({"parameters": {"a": Free(2.5, min=1 * u.km)}}, "expected a plain number, as its start has"),
        ({"observations": []}, "expected observations, or a list"),
        ({"observations": [3.0]}, "expected those of fullbody.observing"),
        ({"loss": "square"}, "loss is 'square'; expected one of linear"),
        ({"loss": lambda z: z}, "expected rho >= 0"),
        ({"starts": 0}, "starts is 0"),
        ({"setup": 3}, "setup is 3; expected a function"),
        ({"parameters": {"a": Free(2.55, min=np.nan)}}, "min of a is nan; expected a finite number"),
        ({"parameters": {"a": Free(2.55, prior=3.0)}}, r"prior of a is 3.0; expected \(mean, sigma\)"),
        ({"parameters": {"a": 1e300}}, "start of a is 1e.300; expected a finite number, of at most 1e.60 in size"),
        ({"parameters": {"a": Free(2.5, prior=(2.5, 1e-61))}}, "sigma of the prior of a is 1e-61"),
        ({"parameters": BETWEEN, "starts": [{"a": 2.0}]}, "starts has {'a': 2.0}, which is not within the bounds"),
        ({"parameters": BETWEEN, "starts": 2, "rng": -1}, "rng is -1; expected a whole number, zero or above"),
        ({"starts": "many"}, "starts is 'many'; expected a whole number above zero, or a list of starts"),
        ({"integrator": "Verner98"}, "integrator is 'Verner98'; expected one of fullbody's"),
        ({"observations": None}, "observations is None; expected observations, or a list"),
        ({"observations": observing.RadarAstrometry}, "parameters has no 'times', which .*RadarAstrometry.* needs"),
        ({"parameters": {"a": True}}, "start of a is True; expected numbers"),
        ({"parameters": {"a": Free(2.55, min=True)}}, "min of a is True; expected numbers"),
        ({"parameters": {"a": Free(2.55, prior=(2.5, True))}}, "sigma of the prior of a is True; expected numbers"),
        ({"parameters": {"a": Free(2.55, prior=(np.nan, 1.0))}}, "mean of the prior of a is nan"),
        ({"parameters": {"a": Free(2.55, prior={"mean": 2.5, "sigma": 1.0})}}, "mean of the prior of a is 'mean'"),
        ({"parameters": {"a": []}}, r"start of a is an array of shape \(0,\); expected one number or more"),
        ({"parameters": {"a": [2.5, np.inf]}}, r"start of a is \[2.5, inf\]; expected a finite number"),
        ({"parameters": {"a": Free([2.5, 2.6], min=[1.0] * 3)}}, r"min of a has shape \(3,\); expected \(2,\)"),
        ({"parameters": {"a": Free([2.5, 2.6], max=[3.0, 2.55])}}, r"start of a\[1\] is 2.6; expected one between"),
        ({"parameters": {"a": Free([2.5, 2.6], prior=(0, [1, 0]))}}, r"sigma of the prior of a\[1\] is 0"),
        ({"parameters": {"a": Free([2.5, 2.6], min=[np.nan, 0])}}, r"min of a is \[nan, 0\]; expected finite numbers"),
        ({"parameters": {"a": np.ma.masked}}, "start of a is masked"),
        ({"parameters": [("a", 2.55)]}, "expected a dict of names to starts"),
        ({"parameters": {1: 2.55}}, "parameters has the name 1; expected one that an argument"),
        ({"setup": lambda a, /: pair(a=a)}, "takes a by its position alone; expected arguments that have names"),
        ({"setup": lambda a: pair(mass=-a)}, "start of the fit is refused: InvalidInput: mass of the body is -2.55"),
        ({"observations": [[]]}, r"observations has \[\]; expected those of fullbody.observing"),
        ({"progress": 3}, "progress is 3; expected True or False, a title, or a function"),
        ({"starts": []}, "starts is empty"),
        ({"rng": True}, "rng is True; expected a whole number"),
        ({"loss": lambda z: 1.0}, "expected rho >= 0"),
        ({"loss": lambda z: np.full((3, *z.shape), np.nan)}, "expected rho >= 0"),
        ({"loss": ["linear"]}, r"loss is \['linear'\]; expected one of linear"),
        ({"parameters": {"a": Free(2.55, min=2.55, max=2.55)}}, "expected min < max"),
        ({"setup": lambda *a: pair()}, "parameters has 'a', which neither the setup nor observations take"),
        ({"observations": "radar"}, "observations has 'r'; expected those of fullbody.observing"),
    ],
)
def test_bad_arguments_are_refused(radar, options, message):
    arguments = {"setup": lambda a: pair(a=a), "parameters": {"a": 2.55}, "observations": radar} | options
    refused(
        message,
        fullbody.fit,
        arguments.pop("setup"),
        arguments.pop("parameters"),
        arguments.pop("observations"),
        **arguments,
    )


def test_bad_data_and_setups_are_refused(radar):
    few = observing.RadarAstrometry(radar.times[:1], range=radar.range[:1], sigma=0.02, body=1, about=0, geometry=VIEW)
    refused("2 parameters, and there are 1 numbers of data", fullbody.fit, pair, TRUE, few)
    other = {"range": radar.range, "sigma": 0.02, "about": 0, "geometry": radar.geometry}
    seventh = observing.RadarAstrometry(radar.times, body=7, **other)
    refused("body of RadarAstrometry is 7", lambda: fullbody.fit(pair, TRUE, seventh))
    with pytest.raises(InvalidInput, match="outside the span of the geometry"):
        fullbody.fit(pair, TRUE, observing.RadarAstrometry(radar.times + 90.0, body=1, **other))
    with pytest.raises(InvalidInput, match=r"do not change evenly with a near 2\.55"):
        fullbody.fit(lambda a: pair(a=2.5 + 1e-3 * np.floor(1e9 * a) % 7), {"a": 2.55}, radar)
    rng = np.random.default_rng(1)
    with pytest.raises(InvalidInput, match="do not change evenly with a"):
        fullbody.fit(lambda a: pair(a=a + 1e-3 * rng.normal()), {"a": 2.55}, radar)
    with pytest.raises(TypeError, match=r"expected \(system, state\)"):
        fullbody.fit(lambda a: None, {"a": 2.55}, radar)
    with pytest.raises(InvalidInput, match="mean distance has no times"):
        fullbody.fit(pair, {"a": 2.55}, observing.Measured("mean distance", lambda run: 1.0, 1.0, 0.1))
    for returned in (None, [radar]):
        with pytest.raises(TypeError, match=r"of observations returned .*; expected those of fullbody\.observing"):
            fullbody.fit(pair, {**TRUE, "jitter": 1.0}, lambda jitter, returned=returned: returned)


def test_a_row_whose_error_is_missing_is_left_out_with_a_warning(radar):
    sigma = np.where(radar.times > 29.0, np.nan, 0.02)
    with pytest.warns(InconsistentInput, match="1 of 15 rows of RadarAstrometry .* left out: row 14"):
        data = observing.RadarAstrometry(radar.times, range=radar.range, sigma=sigma, body=1, about=0, geometry=VIEW)
    assert fullbody.fit(pair, TRUE, data).dof == 12


@pytest.mark.parametrize(
    ("setup", "error", "message"),
    [
        (lambda a: 1 / 0, InvalidInput, "start of the fit is refused: ZeroDivisionError"),
        (lambda a: pair(a=np.nan), InvalidInput, "refused: InvalidInput: position of body 1.* is NaN"),
        # A mistake in the code of a setup is no refusal of its values.
        (lambda a: {}["moon"], KeyError, "moon"),
        (lambda a: pair(a=a)[0], TypeError, r"setup returned System.*; expected \(system, state\)"),
        (lambda a: (*pair(a=a), 1.0), TypeError, r"expected \(system, state\)"),
        (lambda a: pair(a=a) if a == 2.55 else 3, TypeError, r"setup returned 3; expected \(system, state\)"),
        (lambda a: pair(a=2.55 + 1e-3 * (a > 2.55)), InvalidInput, "do not change evenly with a near 2.55"),
    ],
)
def test_setups_without_a_system_and_a_state_are_refused(radar, setup, error, message):
    with pytest.raises(error, match=message):
        fullbody.fit(setup, {"a": 2.55}, radar)


def test_bodies_that_come_and_go_with_a_parameter_are_named(radar):
    def setup(a):
        bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (2.353, 0.1)[: 2 if a == 2.55 else 1]]
        state = fullbody.State([[0.0] * 3, [a, 0, 0]][: len(bodies)], [[0.0] * 3, [0.1, 0.9, 0.3]][: len(bodies)])
        return fullbody.System(bodies, G=1.0, gravity="point"), state

    with pytest.raises(InvalidInput, match=r"cannot be differentiated with respect to a near 2.55: no value near it"):
        fullbody.fit(setup, {"a": 2.55}, radar)


@pytest.mark.parametrize("call", [2, 6, 12])
def test_a_setup_that_fails_once_does_not_end_the_fit(radar, call):
    calls = []

    def setup(mass, a):
        calls.append(1)
        if len(calls) == call:
            raise ValueError("this time not")
        return pair(mass=mass, a=a)

    result = fullbody.fit(setup, START, radar)
    assert len(calls) > call
    assert not result.message
    assert result.chi2 == pytest.approx(fullbody.fit(pair, START, radar).chi2, rel=1e-7)


def test_observations_whose_number_depends_on_a_parameter_are_refused(radar):
    def data(mass):
        rows = slice(10 if mass < 2.355 else 15)
        values = {"range": radar.range[rows], "sigma": 0.02}
        return observing.RadarAstrometry(radar.times[rows], **values, body=1, about=0, geometry=VIEW)

    with pytest.warns(InconsistentInput, match="refused: InvalidInput: the observations have 10 numbers"):
        result = fullbody.fit(pair, START, data)
    assert result.refused


def test_as_many_data_as_parameters_leave_no_p_value(radar):
    rows = {"range": radar.range[:2], "sigma": 0.02, "body": 1, "about": 0, "geometry": VIEW}
    result = fullbody.fit(pair, START, observing.RadarAstrometry(radar.times[:2], **rows))
    assert (result.dof, result.p_value) == (0, None)
    assert result.chi2 < 1e-6
    data, several = observing.RadarAstrometry(radar.times[:2], **rows), {**START, "more": 0.0}
    message = "3 parameters, and there are 2 numbers of data and priors"
    refused(message, fullbody.fit, lambda mass, a, more: pair(mass + more, a), several, data)


def test_a_value_of_the_system_alone_needs_no_times():
    measured = observing.Measured("mass", lambda run: run.system.masses[0], 2.4, 0.1, times=[])
    result = fullbody.fit(lambda mass: pair(mass=mass), {"mass": 2.3}, measured)
    assert result.values["mass"] == pytest.approx(2.4, rel=1e-9)
    assert result.sigma["mass"] == pytest.approx(0.1, rel=1e-9)


def test_a_fit_that_walks_into_a_refused_value_names_the_bound_to_give():
    measured = observing.Measured("mass", lambda run: run.system.masses[0], -0.2, 0.1, times=[])
    with pytest.warns(InconsistentInput, match=r"expected a finite number above zero; give Free the bound min of mass"):
        result = fullbody.fit(lambda mass: pair(mass=mass), {"mass": 1.0}, measured)
    assert 0.0 < result.values["mass"] < 1e-9


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda fit: fit.draw(0, 1), "n is 0; expected a whole number above zero"),
        (lambda fit: fit.draw(2, "x"), "rng is 'x'; expected a whole number, zero or above"),
        (lambda fit: fit.draw(2, None), "rng is None; expected a whole number"),
        (lambda fit: fit.log_posterior([np.nan, 1.0]), "expected 2 finite numbers, or a dict by names"),
        (lambda fit: fit.log_posterior({"mass": "heavy", "a": 1.0}), "value of mass is 'heavy'"),
        (lambda fit: Outliers("few"), "fraction is 'few'; expected a number above 0 and below 1"),
        (lambda fit: Outliers(np.nan), "fraction is nan; expected a number above 0"),
    ],
)
def test_what_a_fit_cannot_do_is_refused(result, call, message):
    refused(message, lambda: call(result))


def test_an_interrupt_returns_the_best_so_far(radar):
    calls = []

    def setup(mass, a):
        calls.append(1)
        if len(calls) > 15:
            raise KeyboardInterrupt
        return pair(mass=mass, a=a)

    with pytest.warns(InconsistentInput, match="interrupted: the values are the best so far"):
        result = fullbody.fit(setup, START, radar)
    assert "interrupted" in result.message
    assert np.isfinite(result.chi2)
    calls[:] = [1] * 15
    with pytest.raises(Interrupted, match="nothing to return"):
        fullbody.fit(setup, START, radar)


def test_the_signal_of_ctrl_c_returns_the_best_so_far(radar):
    calls = []

    def setup(mass, a):
        calls.append(1)
        if len(calls) == 14:
            os.kill(os.getpid(), signal.SIGINT)
        return pair(mass=mass, a=a)

    with pytest.warns(InconsistentInput, match="interrupted: the values are the best so far"):
        result = fullbody.fit(setup, START, radar)
    assert result.message.startswith("interrupted")
    system, state = pair(**START)
    assert result.chi2 <= radar.chi2(system.integrate(state, 30.0, output=radar.times))
