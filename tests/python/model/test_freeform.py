"""Free-form shapes: series of spherical harmonics, and the polytopes of Minkowski's problem."""

import pickle

import fullbody
import numpy as np
import pytest
from fullbody import ConvexShape, HarmonicShape
from fullbody.model.geodesic import geodesic_mesh, mesh_harmonics
from scipy.integrate import quad
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y
from support import refused


def coefficients(degree, size=0.1):
    """Coefficients that fall with the degree, without those of degrees 0 and 1."""
    degrees = np.floor(np.sqrt(np.arange((degree + 1) ** 2) + 0.5))
    return np.where(degrees > 1, size * np.random.default_rng(degree).normal(size=len(degrees)) / (1 + degrees), 0.0)


def real_harmonic(degree, order, directions):
    """A real spherical harmonic with a mean square of one and without the sign (-1)^m, by scipy."""
    x, y, z = directions.T
    complex_value = sph_harm_y(degree, abs(order), np.arccos(z), np.arctan2(y, x)) * np.sqrt(4 * np.pi)
    if order == 0:
        return complex_value.real
    return np.sqrt(2) * (-1) ** order * (complex_value.real if order > 0 else complex_value.imag)


def facet_areas(normals, polyhedron):
    """The areas of the facets of a polyhedron with these normals, from its triangles."""
    vertices = np.asarray(getattr(polyhedron.vertices, "value", polyhedron.vertices))
    a, b, c = np.moveaxis(vertices[polyhedron.faces], 1, 0)
    across = np.cross(b - a, c - a) / 2
    size = np.linalg.norm(across, axis=1)
    nearest = ((across / size[:, None]) @ normals.T).argmax(axis=1)
    assert np.linalg.norm(across / size[:, None] - normals[nearest], axis=1).max() < 1e-6
    return np.bincount(nearest, size, len(normals))


def of_ellipsoid(axes, degree, **options):
    """The ConvexShape whose areas are those of an ellipsoid, by their series up to a degree: 1/curvature is
    (abc)^2 / |A n|^4."""
    mesh = geodesic_mesh(20)
    inverse = np.prod(axes) ** 2 / np.sum((mesh.points * axes) ** 2, axis=1) ** 2
    series = np.linalg.lstsq(mesh_harmonics(20, degree), np.log(inverse), rcond=None)[0]
    return ConvexShape(series, degree=degree, **options)


@pytest.mark.parametrize(("degree", "order"), [(0, 0), (1, -1), (1, 0), (1, 1), (2, -2), (3, 2), (5, -3), (8, 8)])
def test_harmonics_are_those_of_scipy(degree, order):
    result = mesh_harmonics(3, 8)[:, degree * degree + degree + order]
    np.testing.assert_allclose(result, real_harmonic(degree, order, geodesic_mesh(3).points), atol=1e-13)


@pytest.mark.parametrize("parts", [1, 2, 5])
def test_a_geodesic_mesh_covers_the_sphere_once(parts):
    mesh = geodesic_mesh(parts)
    assert (len(mesh.points), len(mesh.faces)) == (10 * parts**2 + 2, 20 * parts**2)
    assert abs(mesh.solid_angles.sum() - 4 * np.pi) < 1e-13
    assert abs(mesh.solid_angles @ mesh.points).max() < 1e-14
    assert sorted(map(sorted, ConvexHull(mesh.points).simplices.tolist())) == sorted(map(sorted, mesh.faces.tolist()))


def test_the_logarithm_of_the_radius_is_the_series():
    series = coefficients(4)
    shape = HarmonicShape(series, degree=4, reference_radius=3.0)
    radii = np.linalg.norm(shape.vertices, axis=1)
    orders = [(n, m) for n in range(5) for m in range(-n, n + 1)]
    parts = [c * real_harmonic(n, m, shape.vertices / radii[:, None]) for c, (n, m) in zip(series, orders, strict=True)]
    np.testing.assert_allclose(np.log(radii / 3.0), sum(parts), atol=1e-14)


def test_the_volume_of_a_spheroidal_series_converges_with_the_square_of_the_size_of_faces():
    # The volume is 2 pi / 3 times the integral of r^3 over z; the series has a term of degree 2 alone.
    exact = 2 * np.pi / 3 * quad(lambda z: np.exp(-0.3 * np.sqrt(5) * (3 * z * z - 1) / 2), -1, 1, epsabs=1e-13)[0]
    errors = [HarmonicShape([0] * 6 + [-0.1, 0, 0], faces=faces).volume / exact - 1 for faces in (500, 2000)]
    assert -0.03 < errors[0] < 0
    assert abs(errors[0] / errors[1] - 4) < 0.1


def test_a_harmonic_shape_is_a_polyhedron_in_every_respect():
    shape = HarmonicShape(coefficients(5), reference_radius=2.0, faces=320)
    unitless = fullbody.Polyhedron(shape.vertices, shape.faces)
    assert shape == unitless
    first, second = (fullbody.Body(item, density=1.5) for item in (shape, unitless))
    np.testing.assert_array_equal(first.inertia, second.inertia)
    np.testing.assert_array_equal(first.working_frame.attitude, second.working_frame.attitude)
    assert first.gravity([0.0, 0.0, 9.0], G=1.0).potential == second.gravity([0.0, 0.0, 9.0], G=1.0).potential


def test_facets_of_minkowskis_polytope_have_the_areas():
    even = np.floor(np.sqrt(np.arange(81) + 0.5)) % 2 == 0
    for series in (coefficients(2, 0.3), coefficients(6, 0.5), np.where(even, coefficients(8, 2.0), 0.0)):
        shape = ConvexShape(series, reference_radius=2.0, faces=400)
        solid = shape.polyhedron()
        result = facet_areas(shape.normals, solid)
        # The areas that close at the least sum of squared changes over areas are areas times 1 + m.n.
        change = result / shape.areas - 1
        multiplier = np.linalg.lstsq(shape.normals, change, rcond=None)[0]
        assert np.abs(shape.areas * (change - shape.normals @ multiplier)).max() < 1e-9 * shape.areas.max()
        assert np.abs(result @ shape.normals).max() < 1e-9 * result.sum()
        assert solid.volume > 0


def test_minkowskis_polytope_of_an_ellipsoids_curvature_is_the_ellipsoid():
    axes = np.array([1.2, 1.0, 0.85])
    errors = []
    for faces in (252, 1002):
        solid = of_ellipsoid(axes, 10, faces=faces).polyhedron()
        corners = solid.vertices[solid.faces].reshape(-1, 3)
        # The planes of the facets touch the ellipsoid.
        a, b, c = np.moveaxis(solid.vertices[solid.faces], 1, 0)
        across = np.cross(b - a, c - a)
        normals = across / np.linalg.norm(across, axis=1)[:, None]
        heights = np.sum(normals * (a - (corners.max(axis=0) + corners.min(axis=0)) / 2), axis=1)
        weights = np.linalg.norm(across, axis=1)
        relative = heights / np.sqrt(np.sum((normals * axes) ** 2, axis=1)) - 1
        errors.append(np.sqrt(weights @ relative**2 / weights.sum()))
    assert errors[0] < 0.02
    assert errors[1] < 0.35 * errors[0]


def test_facets_that_cannot_close_are_refused():
    refused(r"areas of the facets times normals have a sum of 0.8\d+ of", ConvexShape([0, 3.0, 0, 0]).polyhedron)


def test_the_first_coefficient_is_the_size():
    series = coefficients(3)
    larger = np.concatenate([[2 * np.log(3.0)], series[1:]])
    shape, other = ConvexShape(series, reference_radius=3.0), ConvexShape(larger)
    np.testing.assert_allclose(shape.areas, other.areas, rtol=1e-14)
    grown = HarmonicShape([np.log(3.0), *series[1:]])
    np.testing.assert_allclose(grown.vertices, HarmonicShape(series, reference_radius=3.0).vertices, rtol=1e-13)


def test_a_convex_shape_spins_uniformly_about_any_axis_in_the_frame_of_its_series():
    body = fullbody.Body(ConvexShape(coefficients(4, 0.5)), mass=1.0)
    assert body.working_frame.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]
    assert not body.working_frame.position.any()
    system, spin = fullbody.System([body], G=1.0), np.array([0.3, -0.2, 0.6])
    start = fullbody.State([[0.0] * 3], [[0.0] * 3], spin=[spin])
    end = system.integrate(start, 40.0, output="ends")[-1]
    expected = Rotation.from_rotvec(40.0 * spin).as_matrix()
    np.testing.assert_allclose(end.rotation_matrix[0], expected, atol=1e-11)


@pytest.mark.parametrize("kind", [HarmonicShape, ConvexShape])
def test_files_and_pickles_keep_the_series(kind, tmp_path):
    shape = kind(coefficients(4), reference_radius="2 km", faces=200)
    system = fullbody.System([fullbody.Body(shape, mass="5e13 kg", name="A")], units=True)
    start = fullbody.State([[0.0] * 3], [[0.0] * 3], spin=[[0.0, 0.0, 0.5]])
    run = system.integrate(start, 2.0)
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again == run
    assert type(again.system["A"].shape) is kind
    np.testing.assert_array_equal(again.system["A"].shape.coefficients, shape.coefficients)
    assert abs(again.system["A"].shape.reference_radius.to_value("km") - 2) < 1e-14
    assert pickle.loads(pickle.dumps(system)) == system


def test_changed_and_composed_harmonic_shapes_keep_their_vertices():
    shape = HarmonicShape(coefficients(4), faces=200)
    bodies = [fullbody.Body(shape, mass=1.0, name="A"), fullbody.Body(fullbody.PointMass(), mass=0.1, name="B")]
    grown = fullbody.System(bodies, G=1.0).changed("scale of A", 0.5)["A"].shape
    assert isinstance(grown, HarmonicShape)
    assert abs(grown.reference_radius - 1.5) < 1e-14
    two = fullbody.Composite([fullbody.Part(shape, mass=1.0), fullbody.Part(fullbody.Sphere(0.1), mass=0.1)])
    system = fullbody.System([fullbody.Body(two, name="C")], G=1.0)
    assert pickle.loads(pickle.dumps(system)) == system


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: HarmonicShape([1, 2, 3]), r"coefficients of HarmonicShape has 3 numbers; expected \(L \+ 1\)\^2"),
        (lambda: ConvexShape(np.zeros(48), degree=6), "coefficients of ConvexShape has 48 numbers; expected 49 for de"),
        (lambda: HarmonicShape([]), "coefficients of HarmonicShape has 0 numbers"),
        (lambda: HarmonicShape([0, np.nan, 0, 0]), "coefficients of HarmonicShape is .*nan"),
        (lambda: HarmonicShape([0, 5.0, 0, 0]), "radii of HarmonicShape have logarithms from -8.66"),
        (lambda: ConvexShape([500.0]), "areas of ConvexShape per solid angle have logarithms from 500 to 500"),
        (lambda: HarmonicShape([0.0], reference_radius=-1.0), "reference_radius of HarmonicShape is -1.0"),
        (lambda: HarmonicShape([0.0], faces=3), "faces is 3; expected a whole number from 12"),
        (lambda: HarmonicShape([0.0], degree=-1), "degree of HarmonicShape is -1"),
        (lambda: HarmonicShape([[0.0]]), r"coefficients of HarmonicShape has shape \(1, 1\)"),
        (lambda: fullbody.Body(ConvexShape([0.0]), density=2.0), "expected a mass: a ConvexShape has no volume"),
    ],
)
def test_series_that_make_no_shape_are_refused(call, message):
    refused(message, call)


def test_what_needs_vertices_refuses_a_convex_shape_and_names_its_polyhedron():
    body = fullbody.Body(ConvexShape([0.0], faces=100), mass=1.0, name="A")
    other = fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name="B")
    alone, far = fullbody.System([body], G=1.0), {"positions": np.full((4, 3), 1e3), "times": [0, 1, 2, 3]}
    calls = [
        lambda: fullbody.System([body, other], G=1.0),
        lambda: body.gravity([0.0, 0.0, 3.0], G=1.0),
        lambda: body.harmonics(4),
        body.fitted_ellipsoid,
        lambda: fullbody.System([body], G=1.0, forces=[fullbody.forces.ThirdBody(mu=1.0, **far, of="body")]),
        lambda: fullbody.Particles.from_surface(
            alone, fullbody.State([[0.0] * 3], [[0.0] * 3]), "A", longitude=0.0, latitude=0.0, speed=1.0
        ),
    ]
    for call in calls:
        refused(r"A is .*polyhedron\(\)", call)
    joined = fullbody.System([fullbody.Body(body.shape.polyhedron(), mass=1.0), other], G=1.0)
    assert len(joined) == 2
