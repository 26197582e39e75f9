"""Particles in pictures: a map of impacts, and dots with trails in the 3D view."""

import base64

import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import particles, plots
from fullbody.errors import InvalidInput
from support import data_of, refused


@pytest.fixture(scope="module")
def flown():
    """Grains off Beta: some escape, some fall back."""
    system, state = fullbody.systems.kw4()
    options = {"longitude": 1.0, "latitude": 0.3, "speed": np.linspace(0.1, 1.5, 40), "n": 40, "rng": 3}
    grains = fullbody.Particles.ejecta(system, state, "Beta", **options)
    flight = system.fly(state, grains, 20.0, output=0.5, escape=particles.EscapeDistance(10.0))
    assert {"impact", "escape"} <= set(flight.fate)
    return system.integrate(state, 20.0, output=1.0), flight


def test_the_map_of_impacts_has_their_positions(flown):
    _, flight = flown
    for body, name in enumerate(flight.system.names):
        ax = plots.impacts(flight, name)
        (dots,) = ax.collections
        struck = flight.fate_body == body
        expected = np.degrees([flight.longitude[struck], flight.latitude[struck]]).T
        np.testing.assert_array_equal(dots.get_offsets(), expected)
        np.testing.assert_array_equal(dots.get_array(), flight.fate_time[struck])
        assert ax.get_title() == f"{name}, {struck.sum()} of 40 particles"
        plt.close(ax.figure)
    _, mine = plt.subplots()
    assert plots.impacts(flight, 0, mine, colour=None, s=9) is mine
    assert mine.collections[0].get_sizes() == [9]
    plt.close(mine.figure)
    for colour, unit in (("speed", "system units"), ("incidence", "deg")):
        ax = plots.impacts(flight, "Beta", colour=colour)
        assert unit in ax.child_axes[0].get_ylabel()
        plt.close(ax.figure)
    refused("colour is 'mass'; expected 'time'", lambda: plots.impacts(flight, 0, colour="mass"))
    refused("Gamma", lambda: plots.impacts(flight, "Gamma"))


def test_the_view_has_the_positions_of_particles(flown):
    run, flight = flown
    shown = data_of(run.view(flight=flight).to_html())[0]["particles"]
    times = np.frombuffer(base64.b64decode(shown["time"]))
    positions = np.frombuffer(base64.b64decode(shown["position"]), dtype="<f4").reshape(shown["count"], len(times), 3)
    samples = slice(None, None, shown["parts"])
    np.testing.assert_allclose(times[samples], flight.time, rtol=1e-15)
    masses = np.asarray(run.system.masses)
    # The barycentre of this system stays where it is.
    centre = masses @ run.position[0] / masses.sum()
    np.testing.assert_allclose(positions[:, samples], flight.position.swapaxes(0, 1) - centre, atol=1e-6)
    # One that is gone has no place in the page either.
    assert np.isnan(positions[flight.fate == "escape", -1]).all()


def test_flights_that_cannot_be_drawn_are_refused(flown):
    run, flight = flown
    system, state = run.system, run[0]
    with pytest.raises(InvalidInput, match="flight has 0 samples within the run"):
        run.view(flight=system.fly(state, fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]]), 1.0))
    other, start = fullbody.systems.case1()
    refused("among other bodies", lambda: other.integrate(start, 1.0).view(flight=flight))


@pytest.mark.parametrize("name", ["c", "color"])
def test_particles_may_be_coloured(flown, name):
    flight = flown[-1]
    with pytest.raises(InvalidInput, match=f"{name} is given beside colour='time'; expected colour=None"):
        fullbody.plots.impacts(flight, 1, **{name: "red"})
    dots = fullbody.plots.impacts(flight, 1, colour=None, **{name: "red"}).collections[0]
    assert (dots.get_facecolor()[0] == [1, 0, 0, 1]).all()


def test_trails_follow_the_orbit_and_end_on_the_ground():
    """Chords between samples a sixth of a turn apart are nearer to the body by a seventh of the distance."""
    body = fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name="A")
    system = fullbody.System([body], G=1.0)
    state = fullbody.State([[0, 0, 0]], [[0, 0, 0]], spin=[[0, 0, 0.1]])
    run = system.integrate(state, 20.0, output=1.0, dense=True)
    grains = fullbody.Particles([[2, 0, 0], [2, 0, 0]], [[0, np.sqrt(0.5), 0], [0, 0, 0]])
    period = 2 * np.pi * np.sqrt(8.0)
    flight = run.fly(grains, output=period / 6)
    shown = data_of(run.view(flight=flight).to_html())[0]["particles"]
    times = np.frombuffer(base64.b64decode(shown["time"]))
    positions = np.frombuffer(base64.b64decode(shown["position"]), dtype="<f4").reshape(2, len(times), 3)
    assert len(times) > 6 * len(flight.time)
    np.testing.assert_allclose(np.linalg.norm(positions[0], axis=1), 2.0, rtol=0.01)
    # The other one falls, and lies on the turning body.
    landed = np.frombuffer(base64.b64decode(shown["landed"]))
    assert np.isnan(landed[0])
    assert landed[1] == flight.fate_time[1]
    assert (np.linalg.norm(positions[1], axis=1) > 0.98).all()


def test_the_view_shows_its_speed_and_switches_trails(flown):
    run, flight = flown
    page = run.view(flight=flight).to_html()
    assert 'class="fullbody-trails" type="checkbox" checked' in page
    assert "At speed 1 the whole run takes 30 seconds." in page
    assert "@media (max-width: 640px)" in page
