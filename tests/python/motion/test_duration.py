"""The end of a run as a time or as a length of time, and warnings of ends and spacings that are probably mistakes."""

import warnings

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody.errors import InconsistentInput, InvalidInput

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
    with pytest.raises(InvalidInput, match=f"{message} are given"):
        SYSTEM.integrate(LATER, **options)
    with pytest.raises(InvalidInput, match=f"{message} are given"):
        fullbody.Simulation(SYSTEM, LATER).integrate(**options)
    with pytest.raises(InvalidInput, match=f"{message} are given"):
        SYSTEM.fly(LATER, PARTICLE, **options)
    if options:
        with pytest.raises(InvalidInput, match=f"{message} are given"):
            run.fly(PARTICLE, **options)


def test_a_text_that_is_a_time_before_the_start_is_warned_of_with_what_the_run_does():
    with pytest.warns(InconsistentInput, match=r"runs? goes backwards by 6 h.*duration='1 day'"):
        assert SYSTEM.integrate(LATER, "1 day", output="ends").time[-1].to_value("h") == 24.0


def test_a_spacing_that_is_longer_than_the_run_is_warned_of():
    with pytest.warns(InconsistentInput, match="output is 100 h, .* the run is only 4 h long"):
        assert SYSTEM.integrate(LATER, duration=4.0, output=100.0).time.to_value("h").tolist() == [30.0, 34.0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(SYSTEM.integrate(LATER, duration=4.0, output=4.0)) == 2
        assert len(SYSTEM.integrate(LATER, 30.0, output=100.0)) == 1
        assert np.isclose(SYSTEM.integrate(LATER, 26.0, output="2 h").time[-1].value, 26.0)
