"""Particles in pictures: a map of impacts, and dots with trails in the 3D view."""

import base64

import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import particles, plots


@pytest.fixture(scope="module")
def flown():
    """Grains off Beta: some escape, some fall back."""
    system, state = fullbody.systems.kw4()
    grains = fullbody.Particles.ejecta(
        system, state, "Beta", longitude=1.0, latitude=0.3, speed=np.linspace(0.1, 1.5, 40), number=40, seed=3
    )
    flight = system.fly(state, grains, 20.0, output=0.5, escape=particles.Escape(10.0))
    assert {"impact", "escape"} <= set(flight.fate)
    return system.integrate(state, 20.0, output=1.0), flight


def test_impacts_lie_where_they_were(flown):
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
        figure = plots.impacts(flight, "Beta", colour=colour).figure
        assert unit in figure.axes[1].get_ylabel()
        plt.close(figure)
    with pytest.raises(fullbody.InvalidInput, match="colour is 'mass'; expected one of 'time'"):
        plots.impacts(flight, 0, colour="mass")
    with pytest.raises(fullbody.InvalidInput, match="Gamma"):
        plots.impacts(flight, "Gamma")


def test_the_view_has_the_particles_places(flown):
    run, flight = flown
    shown = run.view(flight=flight)._data["particles"]
    times = np.frombuffer(base64.b64decode(shown["time"]))
    places = np.frombuffer(base64.b64decode(shown["position"]), dtype="<f4").reshape(shown["count"], len(times), 3)
    np.testing.assert_array_equal(times, flight.time)
    masses = np.asarray(run.system.masses)
    # The barycentre of this system stays where it is.
    centre = masses @ run.position[0] / masses.sum()
    np.testing.assert_allclose(places, flight.position.swapaxes(0, 1) - centre, atol=1e-6)
    # One that is gone has no place in the page either.
    assert np.isnan(places[flight.fate == "escape", -1]).all()


def test_flights_that_cannot_be_shown_are_refused(flown):
    run, flight = flown
    system, state = run.system, run[0]
    with pytest.raises(fullbody.InvalidInput, match="flight has 0 samples within the run"):
        run.view(flight=system.fly(state, fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]]), 1.0))
    other, start = fullbody.systems.case1()
    with pytest.raises(fullbody.InvalidInput, match="among other bodies"):
        other.integrate(start, 1.0).view(flight=flight)
