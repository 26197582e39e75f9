"""Derivatives of pairs with polyhedra: against differences of the loads, closed forms, and the laws of mechanics."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import NotConverged
from support import worst
from support.flows import (
    TIGHT,
    central_of_state,
    deviation,
    displaced,
    energy_gradient,
    momentum_gradients,
    scales,
    symplectic_form,
)
from support.meshes import box, icosphere, octahedron

SOLIDS = {
    "box": box(1.0, 0.8, 0.6),
    "octahedron": octahedron(0.7, 0.6, 0.5),
    "ellipsoid": fullbody.Ellipsoid(0.7, 0.5, 0.4),
    "sphere": fullbody.Sphere(0.5),
    "point": fullbody.PointMass(),
    "composite": fullbody.Composite(
        [
            fullbody.Part(box(0.5, 0.4, 0.3), mass=0.3, position=[0.3, 0.0, 0.0], attitude=[0.9, 0.1, 0.3, 0.2]),
            fullbody.Part(fullbody.Ellipsoid(0.3, 0.2, 0.25), mass=0.2, position=[-0.2, 0.1, 0.0]),
        ]
    ),
}
PAIRS = [("box", other) for other in SOLIDS] + [("ellipsoid", "octahedron"), ("point", "octahedron")]


def pair(first, second, distance, gravity="focal"):
    bodies = []
    for name, kind, mass in (("A", first, 1.0), ("B", second, 0.4)):
        given = {} if kind == "composite" else {"mass": mass}
        bodies.append(fullbody.Body(SOLIDS[kind], name=name, **given))
    away = distance * np.array([0.7, 0.6, -0.39])
    state = fullbody.State.from_tait_bryan(
        position=[-0.3 * away, 0.7 * away],
        velocity=[[0.0, -0.1, 0.02], [0.1, 0.5, 0.1]],
        angles=[[0.2, -0.3, 0.9], [1.0, 0.4, -0.5]],
        spin=[[0.1, -0.2, 0.5], [0.3, 0.1, -0.4]],
    )
    return fullbody.System(bodies, G=1.0, gravity=gravity), state


def flow(system, state):
    """The equations of motion by the interactions and the bodies' moments."""
    loads, rows = system.interactions(state), []
    for k, body in enumerate(system):
        moments, spin = body.inertia, state.spin[k]
        turning = loads.torque[k] - np.cross(spin, moments * spin)
        rate = turning / moments if np.all(moments) else np.zeros(3)
        rows += [state.velocity[k], loads.force[k] / body.mass, spin, rate]
    return np.concatenate(rows)


@pytest.mark.parametrize("distance", [1.25, 2.5, 12.0], ids=["faces", "layer", "far"])
@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_jacobians_are_those_of_the_loads(first, second, distance):
    system, state = pair(first, second, distance)
    size = scales(system, state)
    actual = system.jacobian(state)
    assert worst(actual.flow, flow(system, state)) < 1e-12
    for k in (0, 4, 7, 14, 20):
        place = (k // 12, k % 12 // 3, k % 3)
        step = 2e-3 * min(distance - 1.0, 1.0) * size[k]
        change = central_of_state(lambda by, place=place: flow(system, displaced(state, *place, by)), step)
        if place[1] == 2:
            change[12 * place[0] + 6 : 12 * place[0] + 9] -= np.cross(state.spin[place[0]], np.eye(3)[place[2]])
        assert worst(actual.rates[:, k] / size, change / size) < 1e-7


@pytest.mark.parametrize("second", ["sphere", "ellipsoid", "point"])
def test_the_surface_rule_beside_a_polyhedron_is_the_focal_one(second):
    focal, surface = (pair("box", second, 1.6, gravity) for gravity in ("focal", "surface"))
    loads = [system.interactions(state) for system, state in (focal, surface)]
    assert worst(loads[1].force, loads[0].force) < 1e-12
    assert worst(surface[0].jacobian(surface[1]).rates, focal[0].jacobian(focal[1]).rates) < 1e-11


@pytest.mark.parametrize("gravity", ["multipole:2", "multipole:6"])
@pytest.mark.parametrize(("first", "second"), [("box", "ellipsoid"), ("octahedron", "box"), ("composite", "box")])
def test_jacobians_of_the_series_of_polyhedra_are_differences(first, second, gravity):
    system, state = pair(first, second, 2.6, gravity)
    size = scales(system, state)
    actual = system.jacobian(state)
    assert worst(actual.flow, flow(system, state)) < 1e-13
    for k in (0, 4, 7, 14, 20):
        place = (k // 12, k % 12 // 3, k % 3)
        change = central_of_state(lambda by, place=place: flow(system, displaced(state, *place, by)), 1e-3 * size[k])
        if place[1] == 2:
            change[12 * place[0] + 6 : 12 * place[0] + 9] -= np.cross(state.spin[place[0]], np.eye(3)[place[2]])
        assert worst(actual.rates[:, k] / size, change / size) < 1e-9


@pytest.mark.parametrize(("first", "second"), [("box", "ellipsoid"), ("box", "octahedron"), ("composite", "box")])
def test_transition_matrices_are_symplectic_and_keep_what_motions_keep(first, second):
    system, state = pair(first, second, 1.5)
    size = scales(system, state)
    run = system.integrate(state, 0.6, output="ends", integrator=TIGHT, derivatives=True)
    phi = run.transition[1]
    form = [size[:, np.newaxis] * symplectic_form(system, run[k]) * size for k in (0, 1)]
    scaled = phi * size / size[:, np.newaxis]
    assert worst(scaled.T @ form[1] @ scaled, form[0]) < 1e-11
    now, then = (_energy(system, run[k]) for k in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-9
    now, then = (momentum_gradients(system, run[k]) for k in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-11


def _energy(system, state):
    gradient = energy_gradient(system, state)
    loads = system.interactions(state)
    for k in range(len(system)):
        gradient[12 * k : 12 * k + 3], gradient[12 * k + 6 : 12 * k + 9] = -loads.force[k], -loads.torque[k]
    return gradient


@pytest.mark.parametrize("distance", [1.25, 2.5])
@pytest.mark.parametrize(
    ("first", "second", "name"),
    [
        ("box", "ellipsoid", "scale of A"),
        ("ellipsoid", "box", "scale of B"),
        ("box", "octahedron", "scale of B"),
        ("sphere", "box", "scale of B"),
        ("box", "ellipsoid", "semi-axis a of B"),
        ("box", "sphere", "semi-axis c of B"),
        ("composite", "box", "position x of part 0 of A"),
        ("composite", "box", "mass of part 1 of A"),
    ],
)
def test_derivatives_by_parameters_of_polyhedra_are_differences(first, second, name, distance):
    system, state = pair(first, second, distance)
    size = scales(system, state)
    actual = system.jacobian(state, [name]).by_parameter[name]
    step = 2e-3 * min(distance - 1.0, 0.2)
    change = central_of_state(lambda by: flow(changed(system, name, by), state), step)
    assert worst(actual / size, change / size) < 1e-7


def changed(system, name, by):
    """The system made anew with a parameter changed."""
    bodies, label = list(system.bodies), name.rsplit(" ", 1)[1]
    k = system.index(label)
    shape, mass = bodies[k].shape, bodies[k].mass
    if name.startswith("scale"):
        larger = fullbody.Polyhedron((1.0 + by) * np.array(shape.vertices), shape.faces)
        bodies[k] = fullbody.Body(larger, mass=mass, name=label)
    elif name.startswith("semi-axis"):
        axes = np.array(shape.semi_axes) + by * np.array([letter == name[10] for letter in "abc"])
        bodies[k] = fullbody.Body(fullbody.Ellipsoid(*axes), mass=mass, name=label)
    else:
        parts = []
        for index, part in enumerate(shape.parts):
            own = by if f"part {index} " in name else 0.0
            heavier, moved = (own, 0.0) if name.startswith("mass") else (0.0, own)
            position = np.array(part.position) + np.array([moved, 0.0, 0.0])
            parts.append(fullbody.Part(part.shape, mass=part.mass + heavier, position=position, attitude=part.attitude))
        bodies[k] = fullbody.Body(fullbody.Composite(parts), name=label)
    return fullbody.System(bodies, G=1.0)


def test_a_fine_polyhedron_has_the_derivatives_of_its_ellipsoid():
    # The error of the mesh goes with the square of its edges.
    bodies = [fullbody.Body(fullbody.Ellipsoid(0.6, 0.5, 0.4), mass=0.4, name="B")]
    _, state = pair("ellipsoid", "ellipsoid", 2.0)
    exact = fullbody.System([fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.6), mass=1.0), *bodies], G=1.0)
    rates, errors = exact.jacobian(state).rates, []
    for level in (1, 2):
        mesh = icosphere(level, (1.0, 0.8, 0.6))
        system = fullbody.System([fullbody.Body(mesh, mass=1.0), *bodies], G=1.0)
        turn = system.bodies[0].working_frame
        assert np.allclose(np.abs(turn.attitude), [1.0, 0.0, 0.0, 0.0], atol=1e-12)
        errors.append(worst(system.jacobian(state).rates, rates))
    assert errors[1] < 0.4 * errors[0] < 0.1


def test_derivatives_reach_the_tolerance_or_say_that_they_do_not():
    # Rounding over the faces of a thin plate is as much larger as it is thin. Which of the tolerances it hides depends
    # on the order of the sums, and so on the machine: the loosest never, the tightest always.
    _, state = pair("box", "ellipsoid", 1.0)
    state = state.replace(attitude=[[1.0, 0.0, 0.0, 0.0]] * 2, position=[[0.0, 0.0, 0.0], [0.05, 0.03, 0.25]])
    other = fullbody.Body(fullbody.Ellipsoid(0.4, 0.3, 0.2), mass=1.0, name="B")
    for thickness in (1e-3, 1e-4, 1e-6):
        plate = fullbody.Body(box(1.0, 0.8, thickness), mass=1.0, name="A")

        def rates(tolerance, plate=plate):
            return fullbody.System([plate, other], G=1.0, gravity_tolerance=tolerance).jacobian(state).rates

        reference = rates(1e-8)
        refused = []
        for tolerance in (1e-13, 1e-12, 1e-11, 1e-10):
            try:
                assert worst(rates(tolerance), reference) < 1e3 * tolerance
            except NotConverged:
                refused.append(tolerance)
        assert thickness > 1e-6 or 1e-13 in refused


def test_derivatives_of_polyhedra_beside_a_third_body_are_differences():
    system, state = pair("box", "octahedron", 3.0)
    orbit = fullbody.KeplerElements(40.0, 0.2, 0.3, 0.1, 0.2, 0.4)
    sun = fullbody.forces.ThirdBody(mu=30.0, orbit=orbit, of="system", name="Sun")
    system, size = system.with_forces([sun]), scales(system, state)
    run = system.integrate(state, 1.0, output="ends", integrator=TIGHT, derivatives=["scale of A"])
    again = [
        system.with_forces([sun]).integrate(displaced(state, 0, 2, 1, by), 1.0, output="ends", integrator=TIGHT)[-1]
        for by in (-1e-4, 1e-4)
    ]
    assert worst(run.transition[1][:, 7] / size, deviation(*again) / 2e-4 / size) < 1e-7
