"""The event of a third body that is nearest, against the periapsis of its orbit."""

import fullbody
import numpy as np
import pytest
from fullbody import events, forces
from fullbody.errors import InvalidInput

MU = 3.986e5 * 3600.0**2


def passing(of="body"):
    """1999 KW4 with the Earth on a hyperbola of 80,000 km, nearest at 10 h."""
    system, state = fullbody.systems.kw4()
    orbit = fullbody.KeplerElements(a=-1.0e4, e=9.0, i=0.4, Omega=1.0, omega=2.0, M=0.0)
    earth = forces.ThirdBody(mu=MU, orbit=orbit, of=of, time=10.0, name="Earth")
    tide = forces.Tide("Alpha", "Beta", k2=1e-5, lag=0.01)
    return system.with_forces([tide, earth]), state


@pytest.mark.parametrize("of", ["body", "system"])
def test_the_closest_approach_is_the_periapsis_of_the_orbit(of):
    """The pull on the pair's quadrupole moves the barycentre by less than the tolerance."""
    system, state = passing(of)
    run = system.integrate(state, 30.0, output=30.0, events=[events.ClosestApproach("Earth")])
    (happened,) = run.events
    assert abs(happened.time - 10.0) < 1e-7
    distance = np.linalg.norm(system.third_body("Earth", happened.time)[0])
    assert distance == pytest.approx(1.0e4 * 8.0, rel=1e-12)


def test_it_may_end_the_run_either_way():
    system, state = passing()
    approach = events.ClosestApproach("Earth", terminal=True)
    run = system.integrate(state, 30.0, events=[approach])
    assert run.stop_reason == "event"
    assert abs(run.time[-1] - 10.0) < 1e-7
    back = system.integrate(state.replace(time=30.0), 0.0, events=[approach])
    assert back.stop_reason == "event"
    assert abs(back.time[-1] - 10.0) < 1e-7


def test_other_forces_are_refused_by_name():
    system, state = passing()
    with pytest.raises(InvalidInput, match="force of ClosestApproach is 'Mars'; expected one of Earth"):
        system.integrate(state, 1.0, events=[events.ClosestApproach("Mars")])
    with pytest.raises(
        InvalidInput, match="force of ClosestApproach is 'tide on Alpha', a Tide; expected one of Earth"
    ):
        system.integrate(state, 1.0, events=[events.ClosestApproach("tide on Alpha")])
    with pytest.raises(InvalidInput, match="expected a ThirdBody of the system, which has none"):
        system.with_forces([]).integrate(state, 1.0, events=[events.ClosestApproach("Earth")])
