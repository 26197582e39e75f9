"""The harmonic series against the rules over surfaces, in poses and for shapes drawn at random."""

import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Polyhedron, Sphere, State, System
from fullbody.errors import NotConverged
from support import matrix, ready, reference
from support.meshes import icosphere


def pose(rng, distance):
    direction, attitude = rng.normal(size=3), rng.normal(size=(2, 4))
    separation = distance * direction / np.linalg.norm(direction)
    return State([np.zeros(3), separation], np.zeros((2, 3)), attitude / np.linalg.norm(attitude, axis=1)[:, None])


def rock(rng, size):
    mesh = icosphere(1, (1.0, 0.8, 0.6))
    vertices = np.asarray(mesh.vertices) * size * (1.0 + 0.1 * rng.uniform(-1.0, 1.0, size=(len(mesh.vertices), 1)))
    return Polyhedron(vertices, mesh.faces)


def differences(bodies, state, tolerance, exact="surface", **options):
    """Errors of the harmonic series against an exact rule, relative to the force and its lever arm of length one."""
    exact = System(bodies, G=1.0, gravity=exact).interactions(state)
    series = System(bodies, G=1.0, gravity="harmonic", gravity_tolerance=tolerance, **options).interactions(state)
    force = np.linalg.norm(exact.force[0])
    energy = abs(series.potential_energy / exact.potential_energy - 1.0)
    return (
        np.linalg.norm(series.force - exact.force, axis=1).max() / force,
        np.linalg.norm(series.torque - exact.torque, axis=1).max() / force,
        energy,
    )


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("tolerance", [1e-6, 1e-10, 1e-14])
def test_the_series_differs_from_the_surface_integrals_by_less_than_the_tolerance(seed, tolerance):
    rng = np.random.default_rng(seed)
    first = Ellipsoid(1.0, 0.9, 0.7) if seed % 2 else rock(rng, 1.0)
    bodies = [Body(first, mass=2.0, name="A"), Body(rock(rng, 0.4), mass=0.3, name="B")]
    state = pose(rng, rng.uniform(2.0, 4.0))
    for error in differences(bodies, state, tolerance):
        assert error < tolerance + 3e-14


@pytest.mark.parametrize("second", [Sphere(0.5), PointMass(), Ellipsoid(0.6, 0.5, 0.5)], ids=repr)
def test_the_series_of_two_smooth_bodies_is_exact(second):
    rng = np.random.default_rng(7)
    bodies = [Body(Ellipsoid(0.7, 1.0, 0.5), mass=1.0, name="A"), Body(second, mass=1.0, name="B")]
    for distance in (1.9, 3.0, 20.0):
        for error in differences(bodies, pose(rng, distance), 1e-14):
            assert error < 2e-14


@pytest.mark.parametrize("case", range(7))
def test_radar_shapes_interact_as_by_the_integrals_over_their_faces(case):
    values = reference("kw4_shapes")["cases"][case]
    radar, _ = ready("kw4", shape="radar")
    bodies = [Body(body.shape, mass=1.0, name=body.name) for body in radar.bodies]
    zeros = np.zeros((2, 3))
    state = State([np.zeros(3), values["separation"]], zeros, attitude=values["attitude"], spin=zeros)
    result = System(bodies, G=1.0).interactions(state)
    assert result.potential_energy == pytest.approx(values["potential_energy"], rel=1e-14)
    force = np.array(values["force_on_first"])
    size = np.linalg.norm(force)
    assert np.linalg.norm(result.force - [force, -force], axis=1).max() < 2e-14 * size
    torques = np.array([values["torque_first"], values["torque_second"]])
    # The distant torques of the integrals have lost digits: sums in extended precision agree with the series to 7e-15.
    lost = 3e-16 if values["separation"][0] ** 2 > 50.0 else 1e-17
    allowed = 5e-14 * np.linalg.norm(torques, axis=1) + lost * size
    assert (np.linalg.norm(result.torque - torques, axis=1) < allowed).all()


@pytest.mark.parametrize("case", range(3))
def test_tetrahedra_interact_as_in_arbitrary_precision(case):
    values = reference("tetrahedra")
    pose = values["cases"][case]
    assert float(pose["error"]) < 1e-20
    bodies = [Body(Polyhedron(values[which], values["faces"]), mass=1.0, name=which) for which in ("first", "second")]
    frames = [body.working_frame for body in bodies]
    # The working frames are the inertial frame, the second one moved by the separation.
    rotations = [matrix(frame.attitude).T for frame in frames]
    moved = np.array([np.zeros(3), pose["separation"]])
    position = [at - rotation @ frame.position for at, rotation, frame in zip(moved, rotations, frames, strict=True)]
    attitude = [frame.attitude * [1, -1, -1, -1] for frame in frames]
    state = State(position, np.zeros((2, 3)), attitude=attitude, spin=np.zeros((2, 3)))
    result = System(bodies, G=1.0, gravity="harmonic").interactions(state)
    force = np.array(pose["force_on_second"], dtype=float)
    size = np.linalg.norm(force)
    assert np.linalg.norm(result.force - [-force, force], axis=1).max() < 2e-14 * size
    for k, which in enumerate(("torque_on_first", "torque_on_second")):
        torque = np.array(pose[which], dtype=float)
        # Vertices about the centre of mass are rounded, so that the force has a lever of about 2e-16.
        assert np.linalg.norm(rotations[k] @ result.torque[k] - torque) < 5e-14 * np.linalg.norm(torque) + 4e-16 * size


def test_voids_are_summed_within_the_tolerance():
    rng = np.random.default_rng(3)
    hollow = Composite([Part(rock(rng, 1.0), mass=2.0), Part(Sphere(0.3), mass=-0.5, position=[0.2, 0.1, 0.0])])
    bodies = [Body(hollow, name="A"), Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, name="B")]
    for error in differences(bodies, pose(rng, 2.5), 1e-12):
        assert error < 2e-12


@pytest.mark.parametrize("seed", range(6))
def test_no_error_exceeds_the_bound_with_voids(seed):
    rng = np.random.default_rng(seed)
    bodies = []
    for name, size in (("A", 1.0), ("B", rng.uniform(0.3, 0.7))):
        axes, at = size * rng.uniform(0.5, 1.0, size=3), rng.normal(size=(2, 3))
        at *= np.array([[1.2 * size], [0.3 * axes.min()]]) / np.linalg.norm(at, axis=1, keepdims=True)
        lobe = Part(Ellipsoid(*(0.5 * axes)), mass=rng.uniform(0.1, 0.5), position=at[0])
        void = Part(Ellipsoid(*(0.4 * axes)), mass=-rng.uniform(0.05, 0.4), position=at[1])
        bodies.append(Body(Composite([Part(Ellipsoid(*axes), mass=1.0), lobe, void]), name=name))
    results = []
    for tolerance in 10.0 ** rng.uniform(-10.0, -2.0, size=25):
        state = pose(rng, rng.uniform(4.0, 9.0))
        results.append(max(differences(bodies, state, tolerance, exact="focal")[:2]) / tolerance)
    # The bound is careful, but not empty.
    assert 1e-5 < max(results) < 1.0


def test_a_fixed_order_is_a_truncated_series():
    rng = np.random.default_rng(5)
    bodies = [Body(rock(rng, 1.0), mass=2.0, name="A"), Body(rock(rng, 0.5), mass=0.3, name="B")]
    state = pose(rng, 3.0)
    errors = [differences(bodies, state, 1e-14, order=n)[0] for n in (2, 4, 8, 16)]
    assert (np.diff(np.log10(errors)) < -0.5).all(), errors
    odd = System(bodies, G=1.0, gravity="multipole:3").interactions(state)
    even = [System(bodies, G=1.0, gravity=f"multipole:{n}").interactions(state) for n in (2, 4)]
    # Neither is the third degree nothing, nor does it agree with the fourth.
    apart = [np.linalg.norm(other.force[0] - odd.force[0]) for other in even]
    assert min(apart) > 1e-6 * np.linalg.norm(odd.force[0])


def test_spheres_that_meet_are_named():
    rng = np.random.default_rng(1)
    bodies = [Body(rock(rng, 1.0), mass=2.0, name="A"), Body(rock(rng, 1.0), mass=0.3, name="B")]
    state = State([[0, 0, 0], [0, 0, 1.5]], np.zeros((2, 3)))
    with pytest.raises(NotConverged, match=r"harmonic between A and B .* their moments diverges"):
        System(bodies, G=1.0, gravity="harmonic").interactions(state)
    # The default takes the rule over faces there.
    assert np.isfinite(System(bodies, G=1.0).interactions(state).force).all()


def test_degrees_past_the_highest_are_refused():
    rng = np.random.default_rng(1)
    bodies = [Body(rock(rng, 1.0), mass=2.0, name="A"), Body(rock(rng, 0.4), mass=0.3, name="B")]
    state = pose(rng, 1.8)
    with pytest.raises(NotConverged, match=r"harmonic between A and B .* degrees up to 80 do not reach"):
        System(bodies, G=1.0, gravity="harmonic").interactions(state)
    # A larger tolerance needs lower degrees.
    for error in differences(bodies, state, 1e-4):
        assert error < 1e-4


def test_three_bodies_attract_pair_by_pair():
    rng = np.random.default_rng(9)
    shapes = (rock(rng, 1.0), rock(rng, 0.4), Ellipsoid(0.5, 0.4, 0.3))
    bodies = [
        Body(shape, mass=mass, name=name) for shape, mass, name in zip(shapes, (2.0, 0.3, 0.4), "ABC", strict=True)
    ]
    position = [[0.0, 0.0, 0.0], [2.8, 0.4, -0.3], [-1.0, 3.0, 0.8]]
    zeros = np.zeros((3, 3))
    attitude = rng.normal(size=(3, 4))
    state = State(position, zeros, attitude / np.linalg.norm(attitude, axis=1)[:, None])
    exact, result = (System(bodies, G=1.0, gravity=gravity).interactions(state) for gravity in ("surface", "harmonic"))
    scale = np.abs(exact.force).max()
    np.testing.assert_allclose(result.force, exact.force, rtol=0.0, atol=3e-14 * scale)
    np.testing.assert_allclose(result.torque, exact.torque, rtol=0.0, atol=3e-14 * scale)


@pytest.mark.parametrize("seed", range(4))
def test_derivatives_are_those_of_the_surface_integrals(seed):
    rng = np.random.default_rng(seed)
    first = Ellipsoid(1.0, 0.9, 0.7) if seed % 2 else rock(rng, 1.0)
    second = Sphere(0.4) if seed == 3 else rock(rng, 0.4)
    bodies = [Body(first, mass=2.0, name="A"), Body(second, mass=0.3, name="B")]
    state = pose(rng, 2.6)
    exact, series = (System(bodies, G=1.0, gravity=gravity) for gravity in ("surface", "harmonic"))
    names = [name for name in exact.parameters if name.startswith(("semi-axis", "scale", "mass", "G"))]
    exact_jacobian, other = exact.jacobian(state, names), series.jacobian(state, names)
    np.testing.assert_allclose(
        other.rates, exact_jacobian.rates, atol=1e-11 * np.abs(exact_jacobian.rates).max(), rtol=0.0
    )
    for name in names:
        size = np.abs(exact_jacobian.by_parameter[name]).max()
        np.testing.assert_allclose(
            other.by_parameter[name], exact_jacobian.by_parameter[name], atol=1e-10 * size, rtol=0.0
        )
