"""Derivatives with other methods of gravity, other integrators, external forces, and at events."""

from dataclasses import replace

import fullbody
import numpy as np
import pytest
from scipy.linalg import expm
from support import body_list, pair_of_points, refused, worst
from support.flows import (
    TIGHT,
    central_of_state,
    cross,
    deviation,
    momentum_gradients,
    scales,
    symplectic_form,
    tumbling,
)

STEPS = [
    fullbody.LieGroupVariational(step=0.05),
    fullbody.SymplecticSplitting(step=0.2),
    fullbody.SymplecticSplitting(step=0.2, scheme="leapfrog"),
]


@pytest.mark.parametrize("integrator", STEPS, ids=["lie", "aba864", "leapfrog"])
def test_transition_matrices_of_fixed_steps_are_symplectic(integrator):
    system, state = tumbling()
    size = scales(system, state)
    options = {"output": "ends", "integrator": integrator}
    run = system.integrate(state, 2.0, derivatives=True, **options)
    assert np.array_equal(run[1].position, system.integrate(state, 2.0, **options)[1].position)
    phi = run.transition[1]
    # The map is symplectic by itself, and keeps the angular momentum, whatever the length of its steps.
    conserved = phi.T @ symplectic_form(system, run[1]) @ phi
    scaled = [size[:, np.newaxis] * form * size for form in (conserved, symplectic_form(system, run[0]))]
    assert worst(*scaled) < 1e-12
    now, then = (momentum_gradients(system, run[i]) for i in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-12


@pytest.mark.parametrize("integrator", [*STEPS, TIGHT], ids=["lie", "aba864", "leapfrog", "verner98"])
def test_transition_matrices_of_points_rotate_uniformly(integrator):
    # d theta/dt = dspin - spin x theta and d spin/dt = 0 have constant coefficients: the exponential of their matrix.
    system, state = pair_of_points(0.3)
    spin = np.array([[0.4, -0.2, 0.3], [-1.1, 0.7, 0.5]])
    state = fullbody.State(state.position, state.velocity, state.attitude, spin)
    run = system.integrate(state, 2.0, output="ends", integrator=integrator, derivatives=True)
    for k in range(2):
        rates = np.block([[-cross(spin[k]), np.eye(3)], [np.zeros((3, 6))]])
        turning = slice(12 * k + 6, 12 * k + 12)
        assert worst(run.transition[1][turning, turning], expm(2.0 * rates)) < 1e-13


def test_composites_have_no_density_to_differentiate_by():
    first, second = (fullbody.Part(fullbody.Sphere(0.3), mass=m, position=[x, 0, 0]) for m, x in ((1, -0.2), (2, 0.1)))
    body = fullbody.Body(fullbody.Composite([first, second]), name="A")
    assert body.density is None
    numbers = [f"{what} of part {k} of A" for k in (0, 1) for what in ("mass", *(f"position {x}" for x in "xyz"))]
    assert fullbody.System([body], G=1.0).parameters == ("G", "mass of A", *numbers)


def test_derivatives_that_do_not_exist_are_refused_by_name():
    system, state = tumbling()
    drag = fullbody.forces.Function(lambda time, state: (np.zeros((2, 3)), np.zeros((2, 3))), name="drag")
    refused("drag", system.with_forces([drag]).integrate, state, 1.0, derivatives=True)


ESCAPE = fullbody.events.Escape("A", "B", distance=0.1, terminal=True)


@pytest.mark.parametrize(
    ("event", "velocity", "name"),
    [
        (fullbody.events.Contact("A", "B", terminal=True), [-0.15, 0.105, 0.1], "semi-axis a of B"),
        (ESCAPE, [0.1, 0.93, 0.1], "mass of A"),
        (ESCAPE, [0.1, 0.93, 0.1], "G"),
        (replace(ESCAPE, distance=8.0), [0.9, 0.7, 0.1], "G"),
        (replace(ESCAPE, distance=8.0), [0.9, 0.7, 0.1], "distance of Escape"),
    ],
    ids=["contact", "bound no more", "bound no more, by G", "far", "by distance"],
)
def test_derivatives_of_events_whose_function_has_the_parameter_are_differences(event, velocity, name):
    system, state = tumbling()
    state = state.replace(velocity=[state.velocity[0], velocity])

    def ended(by, names=()):
        of_event = name == "distance of Escape"
        watched = replace(event, distance=event.distance + by) if of_event else event
        changed = system if of_event or not by else system.changed(name, by)
        options = {"integrator": TIGHT, "events": [watched], "output": "ends"}
        return changed.integrate(state, 30.0, derivatives=names, **options)

    run = ended(0.0, [name] if name in system.parameters else True)
    assert run.stop_reason == "event"
    end = run.at_event()
    time = central_of_state(lambda by: float(ended(by).time[-1]), 1e-5)
    assert worst(end.time_sensitivity[name], time) < 1e-7
    moved = deviation(ended(-1e-5)[-1], ended(1e-5)[-1]) / 2e-5
    assert worst(end.sensitivity[name], moved) < 1e-4


def test_parts_of_a_run_and_files_keep_the_derivatives_of_events(tmp_path):
    system, state = tumbling()
    event = fullbody.events.Apoapsis("A", "B", terminal=True)
    run = system.integrate(state, 30.0, events=[event], derivatives=["mass of B"])
    run.save(tmp_path / "run.nc")
    for other in (run[:2], run[::-1], fullbody.load(tmp_path / "run.nc")):
        assert np.array_equal(other.at_event().time, run.at_event().time)
        assert other.at_event().time_sensitivity == run.at_event().time_sensitivity
    refused("one of the 1 events", lambda: run.at_event(1))
    refused("k is 0.5; expected the index", lambda: run.at_event(0.5))
    refused("derivatives=True", lambda: system.integrate(state, 30.0, events=[event]).at_event())


def sun_beside_a_composite(of):
    parts = [
        fullbody.Part(fullbody.Sphere(0.5), mass=0.6, position=(0.4, 0.1, 0.2)),
        fullbody.Part(fullbody.Ellipsoid(0.5, 0.4, 0.3), mass=0.4, position=(-0.5, 0.0, -0.1)),
    ]
    bodies = body_list(A=(fullbody.Composite(parts), None), B=(fullbody.Sphere(0.3), 0.2))
    orbit = fullbody.KeplerElements(40.0, 0.2, 0.3, 0.4, 0.5, 0.6)
    sun = fullbody.forces.ThirdBody(orbit=orbit, of=of, time=0.3, mass=300.0, name="Sun")
    position, velocity = [[-0.5, 0.0, 0.0], [2.5, 0.0, 0.0]], [[0.0, -0.1, 0.0], [0.0, 0.5, 0.1]]
    state = fullbody.State(position, velocity, spin=[[0.1, 0.2, 0.5], [0.0, 0.0, 0.4]])
    return fullbody.System(bodies, G=1.0, gravity="multipole:2", forces=[sun]), state


@pytest.mark.parametrize("of", ["system", "body"])
@pytest.mark.parametrize("integrator", [fullbody.Verner98(1e-12, 1e-12), fullbody.LieGroupVariational(step=0.05)])
def test_a_derivative_does_not_depend_on_others_requested(integrator, of):
    system, state = sun_beside_a_composite(of)
    names = [name for name in system.parameters if name.endswith("of Sun")] + ["mass of A", "G"]
    together = system.integrate(state, 4.0, integrator=integrator, derivatives=names).sensitivity
    for name in names:
        alone = system.integrate(state, 4.0, integrator=integrator, derivatives=[name]).sensitivity[name][-1]
        # The steps of an adaptive integrator depend on the derivatives that are asked for.
        np.testing.assert_allclose(together[name][-1], alone, rtol=0, atol=1e-8 * np.abs(alone).max(), err_msg=name)
