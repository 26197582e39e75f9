"""Particles have the time of the state that they were made from, and a flight starts there."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Particles
from fullbody.errors import InvalidInput
from support import refused


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state, "30 hour", dense=True)


def thrown(run, state):
    options = {"longitude": "10 deg", "latitude": "5 deg", "speed": "0.1 m/s"}
    return [
        Particles.from_surface(run.system, state, "Beta", **options),
        Particles.ejecta(run.system, state, "Beta", **options, n=3),
    ]


def test_a_flight_starts_at_the_time_of_its_particles(run):
    later = run("7.3 hour")
    for particles in thrown(run, later):
        assert particles.time == 7.3 * u.hour
        flight = run.fly(particles, output="ends")
        assert flight.time[0] == 7.3 * u.hour
        np.testing.assert_array_equal(flight.position[0], particles.position)
        assert flight == run.fly(particles, output="ends", start="438 min")
        assert (run.system.fly(later, particles, "30 hour", output="ends").fate == flight.fate).all()


def test_another_start_is_refused(run):
    for particles in thrown(run, run("7.3 hour")):
        with pytest.raises(InvalidInput, match=r"particles are those of time 7.3 h, but the flight starts at 0 h"):
            run.system.fly(run[0], particles, "30 hour")
        with pytest.raises(InvalidInput, match=r"particles are those of time 7.3 h, but the flight starts at 8 h"):
            run.fly(particles, start="8 hour")
        anywhen = Particles(particles.position, particles.velocity)
        assert anywhen.time is None
        assert anywhen != particles
        assert run.fly(anywhen, output="ends", start="7.3 hour") == run.fly(particles, output="ends")
    refused("time of particles is nan", lambda: Particles([[3.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]], time=np.nan))


def test_particles_show_their_time(run):
    assert repr(thrown(run, run("7.3 hour"))[1]) == "Particles(3 particles at time 7.3 h)"
