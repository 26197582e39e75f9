"""Invalid particles and options are refused, with the particle's index."""

import warnings

import fullbody
import numpy as np
import pytest
from fullbody.errors import InconsistentInput, Interrupted, InvalidInput
from fullbody.particles import Bounce, EscapeDistance, Particles, Radiation, Shadow
from support import refused


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.kw4()
    return system.integrate(state, 3.0, dense=True)


ONE = Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]])


@pytest.mark.parametrize(
    ("position", "velocity", "ratio", "says"),
    [
        ([3.0, 0.0, 0.0], [0.0, 0.8, 0.0], 0.0, "position of particles has shape"),
        ([[3.0, 0.0]], [[0.0, 0.8]], 0.0, "position of particles has shape"),
        ([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]] * 2, 0.0, "velocity of particles has shape"),
        ([[3.0, 0.0, 0.0], [np.nan, 0.0, 0.0]], [[0.0, 0.8, 0.0]] * 2, 0.0, "position of particle 1"),
        ([[3.0, 0.0, 0.0]] * 2, [[0.0, 0.8, 0.0], [0.0, np.inf, 0.0]], 0.0, "velocity of particle 1"),
        ([[3.0, 0.0, 0.0]] * 2, [[0.0, 0.8, 0.0]] * 2, [0.0, -1.0], "area_to_mass of particle 1"),
        ([[3.0, 0.0, 0.0]] * 2, [[0.0, 0.8, 0.0]] * 2, [0.0] * 3, "area_to_mass has shape"),
        (np.zeros((0, 3)), np.zeros((0, 3)), 0.0, "no rows"),
        ("three", [[0.0, 0.8, 0.0]], 0.0, "position"),
    ],
)
def test_arrays_of_a_wrong_shape_are_no_particles(position, velocity, ratio, says):
    refused(says, lambda: Particles(position, velocity, area_to_mass=ratio))


@pytest.mark.parametrize("value", [1e155, -1e155, 1e77, 1e308])
def test_numbers_whose_powers_overflow_are_refused_by_particle(value):
    # The square of 1e155 is above the largest double, 1.8e308; so is the fourth power of 1.2e77.
    start, still = [[3.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0.0, 0.8, 0.0], [0.0, 0.0, 0.0]]
    wrong = [[3.0, 0.0, 0.0], [0.0, value, 0.0]]
    for name, arguments in {
        "position": (wrong, still),
        "velocity": (start, wrong),
        "area_to_mass": (start, still, [0.0, abs(value)]),
    }.items():
        with pytest.raises(InvalidInput, match=f"^{name} of particle 1 is ") as caught:
            Particles(*arguments[:2], area_to_mass=arguments[2] if name == "area_to_mass" else 0.0)
        messages, expected = str(caught.value).split("; ")
        assert f"{abs(value):g}".replace("1e", "1.e") in messages.replace("1e", "1.e")
        assert expected == "expected finite numbers of at most 1e+60 in size, in units that keep them in range"


def test_numbers_out_of_range_in_the_units_of_the_system_are_refused():
    system, state = fullbody.systems.kw4(units=True)
    far = Particles([["9e59 pc", "0 km", "0 km"]], [["0 km/h"] * 3])
    refused(r"position of particle 0 is .*in units that keep them in range", lambda: system.fly(state, far, 1.0))


@pytest.mark.parametrize(("position", "speed"), [(1e60, 1.0), (3.0, 1e60), (1e60, 1e60), (-1e60, 1e60)])
def test_the_largest_finite_numbers_are_accepted(position, speed):
    system, state = fullbody.systems.kw4()
    pair = Particles([[3.0, 0.0, 0.0], [position, 0.0, 0.0]], [[0.0, 0.8, 0.0], [0.0, 0.0, speed]])
    flight = system.fly(state, pair, 1.0, output=0.5, escape=EscapeDistance(1e61))
    assert flight.fate.tolist() == ["flying", "flying"]
    np.testing.assert_allclose(flight.position[-1, 1], [position, 0.0, speed], rtol=1e-12, atol=1e-12)
    assert (flight.position[:, 0] == system.fly(state, ONE, 1.0, output=0.5).position[:, 0]).all()


@pytest.mark.parametrize("until", [1e150, 1e300])
def test_a_particle_whose_position_overflows_is_lost(until):
    system = fullbody.System([fullbody.Body(fullbody.Ellipsoid(1.0, 0.9, 0.8), mass=1e-6, name="A")], G=1.0)
    flight = system.fly(fullbody.State([[0, 0, 0]], [[0, 0, 0]]), Particles([[4.0, 0, 0]], [[0, 0, 1e60]]), until)
    assert flight.fate.tolist() == ["lost"]
    assert 0.0 <= flight.fate_time[0] < 1e15


def test_a_particle_that_passes_a_body_in_less_than_the_time_rounds(run):
    """The search for its contact ends, with a straight line or an impact; positions round at 1e44 there."""
    head_on = Particles([[1e60, 0.0, 0.0]], [[-1e60, 0.0, 0.0]])
    flight = run.fly(head_on, 2.0, output=0.5)
    assert flight.fate[0] in ("flying", "impact")
    assert np.isfinite(flight.last_position).all()
    np.testing.assert_allclose(flight.position[:2, 0, 0], [1e60, 0.5e60], rtol=1e-12)


@pytest.mark.parametrize("output", [None, "ends", 0.25, [0.0, 1.0]])
def test_a_particle_inside_a_body_is_refused(run, output):
    inside = Particles([[3.0, 0.0, 0.0], run[0].position[1] + np.array([0.05, 0.0, 0.0])], [[0.0, 0.8, 0.0]] * 2)
    refused("particle 1 is inside Beta", lambda: run.fly(inside, output=output))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"until": 4.0}, "until is 4"),
        ({"until": np.nan}, "until"),
        ({"start": -1.0}, "time of the particles"),
        ({"output": [0.0, 9.0]}, "output"),
        ({"contact": "bounce"}, "contact is"),
        ({"escape": 20.0}, "escape is"),
        ({"radiation": Radiation(by="Sun", strength=1.0, radius=1.0)}, "by of Radiation is 'Sun'"),
        ({"events": [Shadow()]}, "Shadow"),
        ({"events": ["shadow"]}, "events"),
        ({"threads": 0}, "threads"),
        ({"integrator": fullbody.SymplecticSplitting(step=0.1)}, "integrator"),
        ({"until": 0.0, "start": 3.0, "contact": Bounce(normal=0.5, rest_speed=1.0)}, "backwards"),
    ],
)
def test_bad_options_of_flights_are_refused(run, options, says):
    refused(says, lambda: run.fly(ONE, **options))


def test_bad_arguments_of_launches_and_runs_are_refused():
    system, state = fullbody.systems.kw4()
    launch = {"longitude": 0.0, "latitude": 0.0, "speed": 1.0}
    refused("dense=True", lambda: system.integrate(state, 1.0).fly(ONE))
    refused("f of ParticleFunction", lambda: fullbody.particles.ParticleFunction(3))
    refused("latitude", lambda: Particles.from_surface(system, state, "Beta", **launch | {"latitude": 2.0}))
    refused("n is 0", lambda: Particles.ejecta(system, state, 0, **launch, n=0))


def test_particles_take_units():
    system, state = fullbody.systems.kw4(units=True)
    refused("velocity has the unit", lambda: system.fly(state, Particles([[3.0, 0, 0]], [["1 kg"] * 3]), 1.0))
    reference = system.fly(state, ONE, 1.0, output="ends")
    metres = Particles([["3000 m", "0 m", "0 m"]], [["0 m/s", "0.8 km/h", "0 m/s"]])
    change = system.fly(state, metres, "1 hour", output="ends").position - reference.position
    assert np.abs(change.to_value("km")).max() < 1e-12


def test_a_force_function_of_bodies_is_left_out_with_a_warning():
    system, state = fullbody.systems.kw4()
    nothing = fullbody.forces.Function(lambda *_: (np.zeros((2, 3)), np.zeros((2, 3))), name="mine")
    with pytest.warns(InconsistentInput, match="mine is a function"):
        system.with_forces([nothing]).fly(state, ONE, 0.1)


def test_an_error_of_a_function_of_a_particle_keeps_the_flight():
    system, state = fullbody.systems.kw4()

    def fails(time, x, v):
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine") as caught:
        system.fly(state, ONE, 1.0, events=[fullbody.particles.ParticleFunction(fails)])
    assert len(caught.value.flight) == 1


def test_ctrl_c_returns_the_flight_so_far(run):
    def stop(done, total, description):
        raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        run.fly(ONE, output="ends", progress=stop)
    assert caught.value.flight.position.shape == (2, 1, 3)


def test_an_area_without_light_causes_a_warning(run):
    lit = Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]], area_to_mass=1e-3)
    with pytest.warns(InconsistentInput, match="radiation is not given"):
        run.fly(lit, 0.1)


def test_light_on_particles_without_an_area_causes_a_warning():
    system, state = fullbody.systems.didymos(units=True, sun=True)
    dark = Particles([["3 km", "0 km", "0 km"]], [["0 km/h", "0.4 km/h", "0 km/h"]])
    light = fullbody.particles.Radiation(by="Sun")
    with pytest.warns(InconsistentInput, match="no particle has an area_to_mass"):
        system.fly(state, dark, 0.1, radiation=light)
    with warnings.catch_warnings(action="error"):
        system.fly(state, dark, 0.1, radiation=light, events=[Shadow()])
