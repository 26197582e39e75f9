"""The harmonic series against the rules over surfaces, in poses and for shapes drawn at random."""

import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Polyhedron, Sphere, State, System
from fullbody.errors import NotConverged
from support.meshes import icosphere


def pose(rng, distance):
    direction, attitude = rng.normal(size=3), rng.normal(size=(2, 4))
    separation = distance * direction / np.linalg.norm(direction)
    return State([np.zeros(3), separation], np.zeros((2, 3)), attitude / np.linalg.norm(attitude, axis=1)[:, None])


def rock(rng, size):
    mesh = icosphere(1, (1.0, 0.8, 0.6))
    vertices = np.asarray(mesh.vertices) * size * (1.0 + 0.1 * rng.uniform(-1.0, 1.0, size=(len(mesh.vertices), 1)))
    return Polyhedron(vertices, mesh.faces)


def differences(bodies, state, tolerance, **options):
    """Errors of the harmonic series against the paper's integrals, relative to the force and its lever arm."""
    exact = System(bodies, G=1.0, gravity="surface").interactions(state)
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


def test_voids_are_summed_within_the_tolerance():
    rng = np.random.default_rng(3)
    hollow = Composite([Part(rock(rng, 1.0), mass=2.0), Part(Sphere(0.3), mass=-0.5, position=[0.2, 0.1, 0.0])])
    bodies = [Body(hollow, name="A"), Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, name="B")]
    for error in differences(bodies, pose(rng, 2.5), 1e-12):
        assert error < 2e-12


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


@pytest.mark.parametrize("seed", range(4))
def test_derivatives_are_those_of_the_surface_integrals(seed):
    rng = np.random.default_rng(seed)
    first = Ellipsoid(1.0, 0.9, 0.7) if seed % 2 else rock(rng, 1.0)
    second = Sphere(0.4) if seed == 3 else rock(rng, 0.4)
    bodies = [Body(first, mass=2.0, name="A"), Body(second, mass=0.3, name="B")]
    state = pose(rng, 2.6)
    exact, series = (System(bodies, G=1.0, gravity=gravity) for gravity in ("surface", "harmonic"))
    names = [name for name in exact.parameters if name.startswith(("semi-axis", "scale", "mass", "G"))]
    one, other = exact.jacobian(state, names), series.jacobian(state, names)
    np.testing.assert_allclose(other.rates, one.rates, atol=1e-11 * np.abs(one.rates).max(), rtol=0.0)
    for name in names:
        size = np.abs(one.by_parameter[name]).max()
        np.testing.assert_allclose(other.by_parameter[name], one.by_parameter[name], atol=1e-10 * size, rtol=0.0)
