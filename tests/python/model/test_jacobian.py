"""The derivatives of loads and rates at a state: arbitrary precision, differences, and what symmetry demands."""

import fullbody
import numpy as np
import pytest
from support import body_list, points, reference, refused, worst
from support.flows import SOLIDS, central_of_state, displaced, inertia, rates, scales, solids, tumbling

PAIRS = reference("derivatives")["pairs"]


def pair(case, gravity, mass=(2.0, 3.0), G=0.5):
    """The system and state of a case, with bodies elsewhere than at the origin."""
    axes = [np.array(case[name], dtype=float) for name in ("axes_a", "axes_b")]
    bodies = [fullbody.Body(fullbody.Ellipsoid(*a), mass=m, name=n) for a, m, n in zip(axes, mass, "AB", strict=True)]
    point = np.array([0.3, -0.1, 0.2])
    state = fullbody.State.from_tait_bryan(
        [point, point + np.array(case["separation"], dtype=float)],
        np.zeros((2, 3)),
        np.array([case["angles_a"], case["angles_b"]], dtype=float),
    )
    return fullbody.System(bodies, G=G, gravity=gravity), state


def blocks(jacobian):
    """Derivatives of A's force and of both torques by the separation and by the rotations of A and B."""
    force = jacobian.force_by_position[0], jacobian.force_by_rotation[0]
    torques = [(jacobian.torque_by_position[k], jacobian.torque_by_rotation[k]) for k in (0, 1)]
    for position, rotation in (force, *torques):
        yield from (position[:, 1], rotation[:, 0], rotation[:, 1])


@pytest.mark.parametrize("gravity", ["focal", "surface"])
@pytest.mark.parametrize("case", PAIRS, ids=[case["name"] for case in PAIRS])
def test_jacobians_have_the_reference_values(case, gravity):
    system, state = pair(case, gravity)
    names = [f"semi-axis {axis} of {body}" for body in "AB" for axis in "abc"]
    jacobian = system.jacobian(state, names)
    expected = np.array(case["jacobian"], dtype=float) * float(system.G) * 2.0 * 3.0
    for i, block in enumerate(blocks(jacobian)):
        assert worst(block, expected[3 * (i // 3) :, 3 * (i % 3) :][:3, :3]) < 1e-12
    # Rates are accelerations, and torques over moments, which the parameter changes too; there is no spin.
    torques = system.interactions(state).torque
    for k, name in enumerate(names):
        by, column = jacobian.by_parameter[name], expected[:, 9 + k]
        assert worst(by[3:6] * 2.0, column[0:3]) < 1e-12
        assert worst(-by[15:18] * 3.0, column[0:3]) < 1e-12
        for body, rows, spins in ((0, column[3:6], by[9:12]), (1, column[6:9], by[21:24])):
            moments = inertia(system.bodies[body])
            slope = 0.4 * system.bodies[body].mass * getattr(system.bodies[body].shape, "abc"[k % 3])
            change = np.where(np.arange(3) == k % 3, 0.0, slope) * (k // 3 == body)
            rate = spins * moments + torques[body] / moments * change
            assert worst(rate, rows, np.abs(expected[3:, 9:]).max()) < 1e-12


POSES = reference("pair_jacobians")


@pytest.mark.parametrize("gravity", ["focal", "surface"])
@pytest.mark.parametrize("case", POSES, ids=[case["name"] for case in POSES])
def test_jacobians_of_near_and_far_poses_keep_their_digits(case, gravity):
    # The expected values have 18 digits (tests/data/make_derivatives.py).
    system, state = pair(case, gravity)
    jacobian = system.jacobian(state)
    expected = np.array(case["jacobian"], dtype=float) * float(system.G) * 2.0 * 3.0
    for i, block in enumerate(blocks(jacobian)):
        of_reference = expected[3 * (i // 3) :, 3 * (i % 3) :][:3, :3]
        # A sphere has no torque.
        scale = max(np.abs(of_reference).max(), 1e-6 * np.abs(expected[0:3, 0:3]).max())
        assert worst(block, of_reference, scale) < 1e-12


FACETED = [("box", other) for other in SOLIDS] + [("ellipsoid", "octahedron"), ("point", "octahedron")]


@pytest.mark.parametrize(
    ("made", "step", "tolerance"),
    [
        *((tumbling(gravity), 1e-3, 1e-9) for gravity in ("focal", "surface", "point", "multipole:2", "multipole:4")),
        *((tumbling(gravity), 1e-3, 1e-9) for gravity in ("multipole:8", "harmonic")),
        *((solids("box", other, 1.25), 5e-4, 1e-7) for other in ("ellipsoid", "octahedron")),
        *((solids(*pair, 2.5), 2e-3, 1e-7) for pair in FACETED),
        *((solids("box", other, 12.0), 2e-3, 1e-7) for other in ("ellipsoid", "octahedron", "composite")),
        *((solids("box", "ellipsoid", 2.6, f"multipole:{degree}"), 1e-3, 1e-9) for degree in (2, 6)),
        *((solids("octahedron", "box", 2.6, f"multipole:{degree}"), 1e-3, 1e-9) for degree in (2, 6)),
        *((solids("composite", "box", 2.6, f"multipole:{degree}"), 1e-3, 1e-9) for degree in (2, 6)),
        (solids("box", "sphere", 2.6, "multipole:4"), 1e-3, 1e-9),
    ],
)
def test_derivatives_of_rates_are_differences(made, step, tolerance):
    system, state = made
    size, names = scales(system, state), system.parameters
    actual = system.jacobian(state, names)
    assert worst(actual.flow, rates(system, state)) < 1e-12
    for k in (0, 4, 7, 14, 20):
        point = (k // 12, k % 12 // 3, k % 3)
        change = central_of_state(lambda by, point=point: rates(system, displaced(state, *point, by)), step * size[k])
        if point[1] == 2:
            # A rotation by theta also moves the axes of the spin: d(theta)/dt = dspin - spin x theta.
            change[12 * point[0] + 6 : 12 * point[0] + 9] -= np.cross(state.spin[point[0]], np.eye(3)[point[2]])
        assert worst(actual.rates[:, k] / size, change / size) < tolerance
    for name in names:
        change = central_of_state(lambda by, name=name: rates(system.changed(name, by), state), 0.2 * step)
        assert worst(actual.by_parameter[name] / size, change / size) < tolerance, name


def test_far_bodies_lose_no_digits():
    # MacCullagh's torque on B, -3 G m x cross (I x) / |x|^5 from far away; of its size, not of lever times force.
    system, state = tumbling()
    far = fullbody.State(
        np.array(state.position) * [[1.0], [3e4]], state.velocity, state.attitude, state.spin, time=state.time
    )
    moments = np.diag(inertia(system.bodies[1]))
    quaternion = far.rotation_matrix[1]
    x = quaternion.T @ (far.position[0] - far.position[1])
    r = np.linalg.norm(x)
    rate = np.cross(np.eye(3), moments @ x) + np.cross(x, moments.T).reshape(3, 3)
    expected = 3.0 * (rate.T / r**5 - 5.0 * np.outer(np.cross(x, moments @ x), x) / r**7)
    actual = system.jacobian(far).torque_by_position[1, :, 0] @ quaternion
    assert worst(actual, expected) < 1e-8


def test_jacobians_have_units_and_names():
    system, state = fullbody.systems.kw4(units=True)
    jacobian = system.jacobian(state, ["mass of Beta"])
    assert jacobian.force_by_position.unit.is_equivalent("N/m")
    assert list(jacobian.by_parameter) == ["mass of Beta"]
    refused("mass of Alpha", lambda: system.jacobian(state, ["mass of Gamma"]))
    assert points(1.0, 1.0).parameters == ("G", "mass of body 0", "mass of body 1")


def test_every_parameter_that_is_named_is_taken():
    for options in ({"sun": True}, {"gravity": "multipole:4"}, {}):
        system, state = fullbody.systems.didymos(**options)
        assert "semi-axis a of Dimorphos" in system.parameters
        refused("(?s)mass of X.*semi-axis a", system.jacobian, state, ["mass of X"])
        run = system.integrate(state, 0.1, output="ends", derivatives=system.parameters)
        assert set(run.sensitivity) == set(system.parameters)


ATTITUDE = [0.9, 0.1, 0.3, 0.3]


def beside(axes, distance, mu=50.0):
    """A pair beside a third body at rest at a distance, and its state; the second body has these semi-axes."""
    bodies = body_list(A=(fullbody.Ellipsoid(1.0, 0.9, 0.8), 1.0), B=(fullbody.Ellipsoid(*axes), 0.3))
    path = np.tile(distance * np.array([0.6, 0.48, 0.64]), (4, 1))
    sun = fullbody.forces.ThirdBody(mu=mu, times=[-10.0, 0.0, 5.0, 10.0], positions=path, of="body", name="Sun")
    state = fullbody.State(
        [[0, 0, 0], [4.0, 0, 0]],
        [[0, 0, 0], [0, 0.55, 0.05]],
        [[1, 0, 0, 0], ATTITUDE],
        [[0, 0.1, 0.5], [0.1, 0.05, 0.15]],
    )
    return fullbody.System(bodies, G=1.0, forces=[sun]), state


@pytest.mark.parametrize("distance", [5.0, 40.0])
@pytest.mark.parametrize("axes", [(0.5, 0.4, 0.3), (0.3, 0.5, 0.4), (0.4, 0.5, 0.3), (0.4, 0.4, 0.4)])
def test_derivatives_by_semi_axes_beside_a_third_body_are_differences(axes, distance):
    def sunlit(axes):
        """The third body's share in the acceleration and spin rate of B."""
        system, state = beside(axes, distance)
        loads = system.loads(state)["Sun"]
        return np.array([loads.force[1] / 0.3, loads.torque[1] / inertia(system.bodies[1])])

    system, state = beside(axes, distance)
    for k, axis in enumerate("abc"):
        name, step = f"semi-axis {axis} of B", 2e-3 * axes[k]
        derivatives = (entry.jacobian(state, [name]).by_parameter[name] for entry in (system, system.with_forces([])))
        actual = np.subtract(*derivatives)[[[15, 16, 17], [21, 22, 23]]]
        weights = ((1, 0.8), (2, -0.2), (3, 4 / 105), (4, -1 / 280))
        expected = sum(w * np.subtract(*(sunlit(axes + s * step * np.eye(3)[k]) for s in (m, -m))) for m, w in weights)
        # The force is mostly that on a point, in whose rounding the differences end.
        rounding = 1e-14 * np.abs(sunlit(axes)).max(axis=1)
        error = np.abs(step * actual - expected).max(axis=1)
        assert (error < 1e-10 * np.abs(expected).max(axis=1) + rounding).all()


def test_derivatives_by_semi_axes_beside_a_far_third_body_are_maccullaghs():
    # The torque is MacCullagh's, 3 mu D x cross x / r^5 with D = diag(a^2, b^2, c^2) m / 5.
    axes, far = np.array([0.5, 0.4, 0.3]), 4e6
    pair, _ = beside(axes, far)
    system = fullbody.System([pair.bodies[1]], G=1.0, forces=pair.forces)
    state = fullbody.State([[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]], [ATTITUDE])
    x = state.rotation_matrix[0].T @ (far * np.array([0.6, 0.48, 0.64]))
    moments = (axes @ axes - axes**2) / 5.0
    for k, axis in enumerate("abc"):
        of_k = np.where(np.arange(3) == k, 2.0 * axes[k] / 5.0, 0.0)
        slope, torque = (150.0 * np.cross(d * x, x) / np.linalg.norm(x) ** 5 for d in (of_k, axes**2 / 5.0))
        expected = slope / moments - torque / moments**2 * (of_k.sum() - of_k)
        name = f"semi-axis {axis} of B"
        assert worst(system.jacobian(state, [name]).by_parameter[name][9:12], expected) < 1e-11
