"""Events of particles are detected like those of bodies."""

import fullbody
import pytest


@pytest.mark.parametrize("width", [0.03, 0.01])
@pytest.mark.parametrize("direction", [0, 1, -1])
def test_two_zeros_near_a_minimum_are_found_for_bodies_and_particles(width, direction):
    """The function (t - 5)^2 - w^2 falls through zero at 5 - w and rises at 5 + w, within a step."""
    expected = {0: [5.0 - width, 5.0 + width], 1: [5.0 + width], -1: [5.0 - width]}[direction]
    system, state = fullbody.systems.kw4_ho2021()
    parabola = fullbody.events.Function(lambda s: (s.time - 5.0) ** 2 - width**2, direction=direction)
    run = system.integrate(state, 24.0, output=24.0, events=[parabola], dense=True)
    assert [event.time for event in run.events] == pytest.approx(expected, rel=1e-13)
    # Thirty kilometres away a particle takes steps of several hours.
    particles = fullbody.Particles([[30.0, 0.0, 0.0]], [[0.0, 2.0e-3, 0.0]])
    watched = fullbody.particles.Function(lambda t, x, v: (t - 5.0) ** 2 - width**2, direction=direction)
    flight = run.fly(particles, events=[watched])
    assert [event.time for event in flight.events] == pytest.approx(expected, rel=1e-13)


def test_a_zero_where_two_steps_meet_is_found_once():
    """The function vanishes at the end of a step: it belongs to that step, and not to the next one too."""
    system, state = fullbody.systems.kw4_ho2021()
    run = system.integrate(state, 24.0, output=24.0, dense=True)
    ends = []

    def clock(time, position, velocity):
        ends.append(time)
        return 1.0

    particles = fullbody.Particles([[5.0, 0.0, 0.0]], [[0.0, 0.5, 0.0]])
    run.fly(particles, events=[fullbody.particles.Function(clock)])
    joints = sorted({time for time in ends if 0.0 < time < 24.0 and ends.count(time) > 1})
    assert len(joints) > 3
    for joint in joints[:4]:
        event = fullbody.particles.Function(lambda t, x, v, joint=joint: t - joint)
        assert [found.time for found in run.fly(particles, events=[event]).events] == [joint]
