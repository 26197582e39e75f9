"""Flights as datasets and files, and their representation as text."""

import fullbody
import numpy as np
import pytest
from fullbody.particles import Bounce, Escape, Function, Periapsis
from support import refused


@pytest.fixture(scope="module")
def flight():
    system, state = fullbody.systems.kw4(units=True)
    x = np.array([[4.0, 0.0, 0.0], [2.9, 0.0, 0.3], [0.0, 1.2, 0.0]])
    particles = fullbody.Particles(x, [[0.0, 0.0, 0.8], [0.0, 3.0, 0.0], [0.0, 0.0, 0.0]])

    def height(time, position, velocity):
        return position[2] - 0.1

    events = [Periapsis("Alpha"), Function(height)]
    return system.fly(state, particles, 10.0, output=5.0, escape=Escape(8.0), events=events)


def test_flights_tell_their_fates(flight):
    assert flight.fate.tolist() == ["flying", "escape", "impact"]
    assert repr(flight) == "Flight(3 particles, 3 samples: 1 flying, 1 impact, 1 escape)"
    assert flight.counts == {"flying": 1, "impact": 1, "escape": 1}
    assert "impact on Alpha" in flight._repr_html_()
    assert str(flight.speed.unit) == "km / h"
    assert {type(e.event).__name__ for e in flight.events} == {"Periapsis", "Function"}
    assert len(fullbody.Particles(np.eye(3), np.eye(3))) == 3


def test_a_file_holds_all_of_it(flight, tmp_path):
    path = tmp_path / "flight.nc"
    flight.save(path)
    again = fullbody.load_flight(path)
    assert again == flight
    assert again.system.names == ("Alpha", "Beta")
    np.testing.assert_array_equal(again.position, flight.position)
    assert [e.time for e in again.events] == [e.time for e in flight.events]
    refused("load_flight", lambda: fullbody.load(path))
    refused(r"\.nc", lambda: flight.save(tmp_path / "flight.txt"))


def test_a_damaged_file_is_refused(flight, tmp_path):
    path = tmp_path / "flight.nc"
    flight.save(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    refused("readable flight", lambda: fullbody.load_flight(path))


def test_a_dataset_of_a_flight_has_names_and_units(flight):
    data = flight.to_xarray()
    assert data.position.dims == ("time", "particle", "axis")
    assert data.position.attrs["units"] == "km"
    assert data.fate.attrs["flag_meanings"].split()[int(data.fate[2])] == "impact"


def test_equal_bounces_are_equal():
    assert Bounce(normal=0.5, rest=1.0) == Bounce(normal=0.5, rest=1.0) != Bounce(normal=0.6, rest=1.0)
