"""Forces, torques and energies of single poses: arbitrary-precision reference, the paper's formulas, limits."""

import fullbody
import numpy as np
import pytest
from fullbody import Body, Ellipsoid, PointMass, State, System
from support import reference, worst

CASES = {case["name"]: case for case in reference("mutual_forces")}


def numbers(case, name):
    value = case[name]
    return float(value) if isinstance(value, str) else np.array([float(v) for v in value])


def build(case, **options):
    bodies = [Body(Ellipsoid(*numbers(case, f"axes_{k}")), mass=m) for k, m in (("a", 2.0), ("b", 0.5))]
    state = State.from_tait_bryan(
        [[0.4, -0.3, 0.2], np.add(numbers(case, "separation"), [0.4, -0.3, 0.2])],
        np.zeros((2, 3)),
        [numbers(case, "angles_a"), numbers(case, "angles_b")],
    )
    return System(bodies, G=3.0, **options), state


@pytest.mark.parametrize("gravity", ["surface", "focal"])
@pytest.mark.parametrize("name", CASES)
def test_interactions_have_the_reference_values(name, gravity):
    case = CASES[name]
    f = build(case, gravity=gravity)[0].interactions(build(case)[1])
    scale = 3.0 * 2.0 * 0.5
    force = numbers(case, "force_on_a_inertial")
    assert worst(f.force[0] / scale, force) < 1e-13
    assert worst(f.force[1] / scale, -force) < 1e-13
    for k, body in enumerate("ab"):
        assert worst(f.torque[k] / scale, numbers(case, f"torque_on_{body}_body")) < 1e-12
    assert f.potential_energy / scale == pytest.approx(numbers(case, "potential_energy"), rel=1e-13)


def test_potential_is_continuous_at_the_surface():
    body = Body(Ellipsoid(1.0, 0.8, 0.5), mass=1.0)
    for direction in np.eye(3):
        at = direction * (1.0, 0.8, 0.5)
        assert body.gravity(at, 1.0).potential == pytest.approx(body.gravity(at * (1 + 1e-9), 1.0).potential, rel=1e-8)
    assert Body(fullbody.Sphere(2.0), mass=3.0).gravity([0, 0, 2.0], 1.0).field == pytest.approx(
        [0, 0, -0.75], rel=1e-15
    )


def test_three_bodies_are_the_sum_over_pairs():
    bodies = [Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0), Body(Ellipsoid(0.3, 0.3, 0.6), mass=2.0)]
    bodies.append(Body(PointMass(), mass=0.5))
    state = State(
        [[0, 0, 0], [2, 0.3, 0], [0.5, 2, 1]], np.zeros((3, 3)), [[1, 0, 0, 0], [0.5, 0.5, 0.5, 0.5], [1, 0, 0, 0]]
    )
    total = System(bodies, G=1.0).interactions(state)
    force, torque, energy = np.zeros((3, 3)), np.zeros((3, 3)), 0.0
    for i, j in ((0, 1), (0, 2), (1, 2)):
        pair = State(state.position[[i, j]], np.zeros((2, 3)), state.attitude[[i, j]])
        f = System([bodies[i], bodies[j]], G=1.0).interactions(pair)
        force[[i, j]] += f.force
        torque[[i, j]] += f.torque
        energy += f.potential_energy
    assert worst(total.force, force) < 1e-14
    assert worst(total.torque, torque) < 1e-13
    assert total.potential_energy == pytest.approx(energy, rel=1e-14)


PLACES = [(0.0087, 0.8198), (0.9838, 0.7486), (0.9742, 0.8015), (0.9873, 0.8164)]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-11])
@pytest.mark.parametrize(("across", "height"), PLACES)
def test_force_on_a_small_body_above_a_disc_has_the_tolerance(across, height, tolerance):
    c = 0.17
    unit = np.sqrt(1 - c * c)
    bodies = [Body(Ellipsoid(1, 1, c), mass=1.0), Body(Ellipsoid(2e-4, 1.9e-4, 1.8e-4), mass=1e-9)]
    for angle in (0.0, 0.3, 2.0):
        position = [across * np.cos(angle), across * np.sin(angle), height]
        state = State(position=[[0, 0, 0], np.multiply(position, unit)], velocity=np.zeros((2, 3)))
        exact = System(bodies, G=1.0, gravity="surface", gravity_tolerance=1e-13).interactions(state).force[1]
        force = System(bodies, G=1.0, gravity_tolerance=tolerance).interactions(state).force[1]
        assert np.linalg.norm(force - exact) < 3 * tolerance * np.linalg.norm(exact)


def test_a_fixed_order_is_as_exact_as_its_number_of_points():
    case = CASES["kw4"]
    exact = numbers(case, "force_on_a_inertial")
    errors = [
        worst(build(case, gravity="surface", order=order)[0].interactions(build(case)[1]).force[0] / 3.0, exact)
        for order in ((4, 8), (8, 16), (14, 28))
    ]
    assert errors[0] > 100 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e-13
    # Measured apart from this code: 128 nodes reach 2e-9 in the force.
    assert errors[1] < 1e-8
    for tolerance in (1e-4, 1e-8, 1e-12):
        system, state = build(case, gravity="surface", gravity_tolerance=tolerance)
        assert worst(system.interactions(state).force[0] / 3.0, exact) < tolerance
