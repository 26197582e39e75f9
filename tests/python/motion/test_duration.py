"""The end of a run as a time or as a length of time, and warnings of ends and spacings that are probably mistakes."""

import warnings

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody.errors import InconsistentInput, InvalidInput
from support import refused

SYSTEM, STATE = fullbody.systems.kw4(units=True)
LATER = STATE.replace(time=30.0 * u.h)
PARTICLE = fullbody.Particles([[0.0, 5.0, 0.0]], [[0.8, 0.0, 0.0]])


@pytest.mark.parametrize(("duration", "until"), [("4 h", 34.0), (4.0, 34.0), ("-4 h", 26.0)])
def test_a_duration_is_counted_from_the_time_of_the_state(duration, until):
    for run in (
        SYSTEM.integrate(LATER, duration=duration, output="ends"),
        fullbody.Simulation(SYSTEM, LATER).integrate(duration=duration, output="ends"),
    ):
        assert run.time.to_value("h").tolist() == [30.0, until]
        assert run == SYSTEM.integrate(LATER, until, output="ends")


def test_flights_take_a_duration_too():
    run = SYSTEM.integrate(LATER, 36.0, dense=True)
    for flight in (
        SYSTEM.fly(LATER, PARTICLE, duration="4 h", output="ends"),
        run.fly(PARTICLE, start=30.0, duration="4 h", output="ends"),
    ):
        assert flight.time.to_value("h").tolist() == [30.0, 34.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [({}, "neither until nor duration"), ({"until": 31.0, "duration": 1.0}, "both until and duration")],
)
def test_exactly_one_of_until_and_duration_is_expected(options, message):
    run = SYSTEM.integrate(LATER, 36.0, dense=True)
    refused(f"{message} are given", lambda: SYSTEM.integrate(LATER, **options))
    refused(f"{message} are given", lambda: fullbody.Simulation(SYSTEM, LATER).integrate(**options))
    refused(f"{message} are given", lambda: SYSTEM.fly(LATER, PARTICLE, **options))
    if options:
        refused(f"{message} are given", lambda: run.fly(PARTICLE, **options))


def test_an_end_as_text_before_the_start_causes_a_warning_of_a_backward_run():
    with pytest.warns(InconsistentInput, match=r"run goes backwards by 6 h.*duration='1 day'"):
        assert SYSTEM.integrate(LATER, "1 day", output="ends").time[-1].to_value("h") == 24.0


def test_a_spacing_longer_than_the_run_causes_a_warning():
    with pytest.warns(InconsistentInput, match="output is 100 h, .* the run is only 4 h long"):
        assert SYSTEM.integrate(LATER, duration=4.0, output=100.0).time.to_value("h").tolist() == [30.0, 34.0]
    with warnings.catch_warnings(action="error"):
        assert len(SYSTEM.integrate(LATER, duration=4.0, output=4.0)) == 2
        assert len(SYSTEM.integrate(LATER, 30.0, output=100.0)) == 1
        assert np.isclose(SYSTEM.integrate(LATER, 26.0, output="2 h").time[-1].value, 26.0)


def test_ensembles_sweeps_and_sections_count_a_duration_from_the_time_of_each_start():
    members = [(SYSTEM, STATE), (SYSTEM, LATER)]
    runs = fullbody.integrate_many(members, duration=["4 h", "2 h"], output="ends")
    assert [run.time[-1].to_value("h") for run in runs] == [4.0, 32.0]
    runs = fullbody.integrate_many(members, duration="4 h", output="ends")
    assert [run.time[-1].to_value("h") for run in runs] == [4.0, 34.0]

    def setup(late):
        return SYSTEM, STATE.replace(time=late * u.h)

    def end(run):
        return {"end": run.time[-1]}

    options = {"measure": end, "output": "ends"}
    for duration in ("3 h", 3.0, lambda late: 3.0):
        result = fullbody.sweep(setup, {"late": [0.0, 10.0]}, duration=duration, **options)
        assert result.end.values.tolist() == [3.0, 13.0]
    result = fullbody.sweep(lambda late, span: setup(late), {"late": [1.0], "span": [2.0]}, duration="span", **options)
    assert result.end.values.tolist() == [[3.0]]
    event = fullbody.events.Function(lambda state: state.time.to_value("h") - 31.5)
    ends = [
        len(fullbody.analysis.section(SYSTEM, LATER, event=event, duration=duration).crossings[0])
        for duration in ("1 h", "2 h")
    ]
    assert ends == [0, 1]
    for call in (
        lambda: fullbody.integrate_many(members),
        lambda: fullbody.sweep(setup, {"late": [0.0]}, **options),
        lambda: fullbody.analysis.section(SYSTEM, LATER, event=event),
    ):
        refused("neither until nor duration are given", call)
    with pytest.raises(InvalidInput, match=r"duration has 2 values; expected one, or 3"):
        fullbody.integrate_many([*members, members[0]], duration=[1.0, 2.0])


def test_an_ensemble_warns_once_of_backward_runs_and_once_of_its_spacing():
    members = [(SYSTEM, LATER.replace(time=late * u.h)) for late in (30.0, 31.0, 32.0)]
    with pytest.warns(InconsistentInput) as caught:
        fullbody.integrate_many(members, "1 day", output=100.0)
    texts = [str(warning.message) for warning in caught]
    assert len(texts) == 2
    assert "the run goes backwards by 6 h" in texts[0]
    assert "output is 100 h" in texts[1]


@pytest.mark.filterwarnings("always")
def test_sweeps_and_fits_warn_once_of_their_setup(recwarn):
    def setup(mass):
        # The density is too low for a body, which causes a warning.
        bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=mass * 1e3 * u.kg, name=name) for name in "AB"]
        state = fullbody.State([[0, 0, 0], [5.0, 0, 0]] * u.km, np.zeros((2, 3)))
        return fullbody.System(bodies, units=True), state

    fullbody.sweep(setup, {"mass": [1.0, 2.0, 3.0, 4.0]}, "1 h", measure="drift", output="ends")
    # The texts of the two bodies differ, so that each is warned of once.
    assert sorted(str(warning.message).partition(" has ")[0] for warning in recwarn.list) == ["A", "B"]
    recwarn.clear()

    def speed(run):
        return run.velocity[-1, 1, 0].to_value("km/h")

    data = [fullbody.observing.Measured(name, speed, -1e-12, 1e-13, times=[0.0, 1.0] * u.h) for name in ("one", "two")]
    fullbody.fit(setup, {"mass": 2.0}, data)
    assert sum("density" in str(warning.message) for warning in recwarn.list) == 2
    recwarn.clear()
    # Outside sweeps and fits every call warns.
    setup(1.0), setup(2.0)
    assert len(recwarn.list) == 4
