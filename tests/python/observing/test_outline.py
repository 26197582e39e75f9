"""Outlines in the sky against ellipses, cubes and rays, and measured points of a limb."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.time import Time
from fullbody import observing
from support import body_list, matrix, refused
from support.displacements import assert_by_kind, by_start
from support.meshes import box, icosphere

DISTANCE = 1e6
ATTITUDE = np.array([0.4, -0.5, 0.6, np.sqrt(0.23)])


def to_given_axes(shape):
    """The attitude in which the axes of a polyhedron's vertices are those of space."""
    return fullbody.Body(shape, mass=1.0).working_frame.attitude * [1.0, -1.0, -1.0, -1.0]


def seen(bodies, positions, attitudes=None, sun=(-1e8, 0.0, 0.0)):
    """A run of bodies at rest, seen along +x by a distant observer, so that y is east and z is north."""
    masses = [1e9] * len(bodies)
    named = body_list(**{name: (shape, mass) for name, shape, mass in zip("ABC", bodies, masses, strict=False)})
    system = fullbody.System(named, units=True, frame="equatorial", gravity="point")
    count = len(bodies)
    attitude = np.tile([1.0, 0, 0, 0], (count, 1)) if attitudes is None else attitudes
    state = fullbody.State(position=positions, velocity=np.zeros((count, 3)), attitude=attitude)
    run = system.integrate(state, 1e-3, dense=True)
    lines = {"to_observer": [-DISTANCE, 0, 0] * u.km, "to_sun": np.array(sun) * u.km}
    return run, observing.Geometry([-1.0, 1.0] * u.h, **lines, light_time=False)


def in_km(outlines):
    return outlines.points.to_value("rad") * DISTANCE


pytestmark = pytest.mark.filterwarnings("ignore:. has a density")


def test_points_are_on_the_projected_ellipse_at_their_position_angles():
    axes = np.array([3.0, 2.0, 1.0])
    run, geometry = seen([fullbody.Ellipsoid(*axes)], [[0, 0, 0]], ATTITUDE[None])
    points = in_km(observing.outline(run, 0.0, geometry, n=72))[0]
    rotation = matrix(ATTITUDE)
    shape = (rotation * axes**2 @ rotation.T)[1:, 1:]
    np.testing.assert_allclose(np.einsum("nx,xy,ny->n", points, np.linalg.inv(shape), points), 1.0, rtol=2e-5)
    angles = np.radians(np.arange(72) * 5.0)
    radii = np.hypot(*points.T)[:, None]
    np.testing.assert_allclose(points / radii, np.stack([np.sin(angles), np.cos(angles)], axis=1), atol=1e-5)


def test_outline_of_a_cube_seen_face_on_is_a_square():
    cube = box(2.0, 2.0, 2.0)
    run, geometry = seen([cube], [[0, 0, 0]], to_given_axes(cube)[None])
    points = in_km(observing.outline(run, 0.0, geometry, n=8))[0]
    expected = np.array([[0, 1], [1, 1], [1, 0], [1, -1], [0, -1], [-1, -1], [-1, 0], [-1, 1]])
    np.testing.assert_allclose(points, expected, atol=1e-5)


def test_outline_of_many_facets_is_that_of_the_ellipsoid():
    axes = np.array([3.0, 2.0, 1.0])
    shape = icosphere(5, axes)
    rotated = fullbody.base.rotations.product(ATTITUDE, to_given_axes(shape))
    both = [seen([body], [[0, 0, 0]], q[None]) for body, q in ((shape, rotated), (fullbody.Ellipsoid(*axes), ATTITUDE))]
    first, second = (in_km(observing.outline(run, 0.0, geometry)) for run, geometry in both)
    np.testing.assert_allclose(first, second, atol=2e-3)


def test_the_hidden_part_is_behind_the_other_body_and_within_its_disc():
    spheres = [fullbody.Sphere(2.0), fullbody.Sphere(1.0)]
    # B is nearer to the observer, at -x, and its disc overlaps the limb of A in the east.
    run, geometry = seen(spheres, [[0, 0, 0], [-10.0, 2.0, 0]])
    outlines = observing.outline(run, 0.0, geometry, n=720)
    points = in_km(outlines) - in_km(outlines)[1].mean(axis=0)
    np.testing.assert_array_equal(outlines.hidden[0], np.hypot(*points[0].T) < 1.0)
    assert 0 < outlines.hidden[0].sum() < 360
    assert not outlines.hidden[1].any()


@pytest.mark.parametrize("faceted", [False, True])
def test_a_limb_is_lit_on_the_side_of_the_sun_but_for_the_shadow_of_another_body(faceted):
    small = icosphere(4) if faceted else fullbody.Sphere(1.0)
    # The Sun is in the north, and B between it and a part of the northern limb of A.
    run, geometry = seen([fullbody.Sphere(2.0), small], [[0, 0, 0], [0.0, 0.5, 8.0]], sun=(0.0, 0.0, 1e9))
    outlines = observing.outline(run, 0.0, geometry, n=360)
    points = in_km(outlines)[0] - in_km(outlines)[0].mean(axis=0)
    expected = (points[:, 1] > 0.0) & ~(np.abs(points[:, 0] - 0.5) < 1.0)
    border = (np.abs(np.abs(points[:, 0] - 0.5) - 1.0) < 0.02) | (np.abs(points[:, 1]) < 1e-3)
    np.testing.assert_array_equal(outlines.lit[0][~border], expected[~border])


def test_bodies_without_a_size_are_points_and_arguments_are_checked():
    run, geometry = seen([fullbody.Sphere(2.0), fullbody.PointMass()], [[0, 0, 0], [0.0, 5.0, 0.0]])
    outlines = observing.outline(run, 0.0, geometry, n=12)
    np.testing.assert_array_equal(outlines.points[1], outlines.points[1][:1] * np.ones((12, 1)))
    refused("n is 2", lambda: observing.outline(run, 0.0, geometry, n=2))
    refused(r"time has shape \(2,\); expected one time", lambda: observing.outline(run, [0.0, 0.1], geometry))
    data = observing.Outline(0.0 * u.h, [1.0] * u.mas, [0.0] * u.mas, 1 * u.mas, body="B", geometry=geometry)
    refused("B is a point; expected a body with an outline", lambda: data.predict(run))


def measured(run, geometry, points, body="A", **options):
    east, north = (points / DISTANCE * u.rad).to("mas").T
    return observing.Outline(0.0 * u.h, east, north, 0.1 * u.mas, body=body, geometry=geometry, **options)


def test_residuals_are_distances_from_the_nearest_point_of_the_ellipse():
    run, geometry = seen([fullbody.Ellipsoid(3.0, 3.0, 1.0)], [[0, 0, 0]])
    middle = in_km(observing.outline(run, 0.0, geometry, n=4))[0].mean(axis=0)
    points = np.array([[3.5, 0.0], [0.0, 1.2], [0.0, -0.7], [2.4, 0.9]])
    data = measured(run, geometry, points + middle)
    result = data.residuals(run).to_value("rad") * DISTANCE
    # The nearest points of 100,000 on the ellipse.
    angles = np.linspace(0.0, 2 * np.pi, 100001)
    curve = np.stack([3.0 * np.cos(angles), np.sin(angles)], axis=1)
    distance = np.array([np.linalg.norm(curve - point, axis=1).min() for point in points])
    sign = np.where((points / [3.0, 1.0]) ** 2 @ [1.0, 1.0] > 1.0, 1.0, -1.0)
    np.testing.assert_allclose(result, sign * distance, atol=2e-5)


def test_residuals_of_a_polyhedron_are_distances_from_the_nearest_side_or_corner():
    cube = box(2.0, 2.0, 2.0)
    run, geometry = seen([cube], [[0, 0, 0]], to_given_axes(cube)[None])
    points = np.array([[1.3, 1.4], [1.5, 0.2], [0.7, 0.1], [-1.0, -1.2]])
    distances = measured(run, geometry, points).residuals(run).to_value("rad") * DISTANCE
    np.testing.assert_allclose(distances, [0.5, 0.5, -0.3, 0.2], atol=1e-5)


@pytest.mark.parametrize("faceted", [False, True])
def test_derivatives_are_differences_of_the_pulls(faceted):
    axes = (0.42, 0.40, 0.35)
    shape = icosphere(3, axes) if faceted else fullbody.Ellipsoid(*axes)
    system, state = fullbody.systems.didymos(units=True)
    bodies = [fullbody.Body(shape, mass=system.bodies[0].mass, name="Didymos"), system.bodies[1]]
    system = fullbody.System(bodies, units=True, frame=system.frame, gravity="point")
    lines = {"to_observer": [0.1, 0.01, 0.03] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au, "frame": "ecliptic"}
    geometry = observing.Geometry([0.0, 48.0] * u.h, **lines)
    run = system.integrate(state, "1 day", dense=True)
    time = 7.3 * u.h
    east, north = observing.outline(run, time, geometry, n=7).points[0][[2]].T * 1.02
    data = observing.Outline(time, east, north, 1e-3 * u.mas, body="Didymos", geometry=geometry)
    moment = system.integrate(state, data.emission(system)[0], output="ends")[-1]
    steps = {"position": 1e-5, "velocity": 1e-4, "rotation": 1e-5, "spin": 1e-4}
    exact, differences = by_start(data, system, moment, steps)
    assert_by_kind(exact, differences, 3e-6, 1e-8 * np.abs(differences).max())


def test_derivatives_by_the_spin_of_a_body_far_from_the_barycentre_are_differences():
    # The light leaves the body a second before that of the barycentre, and the body rotates in this time.
    bodies = body_list(A=(fullbody.Ellipsoid(3.0, 2.0, 1.0), 1e9), B=(fullbody.PointMass(), 1e9))
    system = fullbody.System(bodies, units=("km", "s", "kg"), frame="equatorial", gravity="point")
    position, spin = [[3e5, 0, 0], [-3e5, 0, 0]], [[1e-3, 2e-3, 1e-3], [0, 0, 0]]
    state = fullbody.State(position, np.zeros((2, 3)), attitude=[ATTITUDE, [1, 0, 0, 0]], spin=spin)
    run = system.integrate(state, 1000.0, dense=True)
    geometry = observing.Geometry([-1e5, 1e5] * u.s, to_observer=[-1e7, 0, 0] * u.km)
    offset = [1.6 / 1e7] * u.rad
    data = observing.Outline(700.0 * u.s, offset, offset, 1e-9 * u.rad, body="A", geometry=geometry)
    exact, differences = by_start(data, system, run(data.emission(system)[0]), {"spin": 1e-3})
    assert np.abs(differences[:, 9:12]).max() > 1.0
    np.testing.assert_allclose(exact[:, 9:12], differences[:, 9:12], rtol=1e-5)


def test_a_fit_finds_the_axes_and_the_pointing_from_the_points_of_a_limb():
    def setup(a, c):
        body = fullbody.Body(fullbody.Ellipsoid(a, a, c), mass=1e13, name="A")
        system = fullbody.System([body], units=("km", "h", "kg"), frame="equatorial")
        return system, fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)))

    lines = {"to_observer": [-DISTANCE, 0, 0] * u.km, "to_sun": [-1e8, 0.0, 0.0] * u.km}
    geometry = observing.Geometry([-1.0, 2.0] * u.h, **lines, light_time=False)
    system, state = setup(3.0, 2.0)
    run = system.integrate(state, 1.0, dense=True)
    east, north = observing.outline(run, 0.5 * u.h, geometry, n=60).points[0].T
    noise = np.random.default_rng(2).normal(scale=2.0, size=60) * u.mas

    def data(dx, dy):
        points = {"east": east + (5.0 - dx) * u.mas, "north": north + noise + (-3.0 - dy) * u.mas}
        return observing.Outline(0.5 * u.h, **points, sigma=2.0 * u.mas, body="A", geometry=geometry)

    fit = fullbody.fit(setup, {"a": 2.8, "c": 2.1, "dx": 0.0, "dy": 0.0}, [data])
    for name, value in {"a": 3.0, "c": 2.0, "dx": 5.0, "dy": -3.0}.items():
        assert abs(fit.values[name] - value) < 4.0 * fit.sigma[name]
    assert data(0.0, 0.0).plot(run)[0, 0].get_ylabel() == "distance from the outline [mas]"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sigma": -1.0 * u.mas}, "sigma of Outline has the value -4.*; expected standard errors above zero"),
        ({"sigma": 1.0}, "only one of east and sigma of Outline has a unit"),
        ({"north": [1.0] * u.mas}, "north of Outline has shape"),
        ({"body": "C"}, "'C'"),
        ({"east": np.zeros(3) * u.km}, "east of Outline has the unit km"),
    ],
)
def test_bad_outlines_are_refused_by_name(options, message):
    run, geometry = seen([fullbody.Sphere(2.0)], [[0, 0, 0]])
    arguments = {"east": np.zeros(3) * u.mas, "north": np.zeros(3) * u.mas, "sigma": 1 * u.mas, "body": "A"} | options
    refused(message, lambda: observing.Outline(0.0 * u.h, **arguments, geometry=geometry).predict(run))


def test_one_date_stands_for_all_points_and_distances_do_not_depend_on_the_system_of_units():
    bodies = body_list(A=(fullbody.Ellipsoid(3.0, 2.0, 1.0), 1e13))
    options = {"frame": "equatorial", "epoch": "2022-09-26 TDB"}
    date = Time("2022-09-26T00:30:00", scale="tdb")
    lines = {"to_observer": [-DISTANCE, 0, 0] * u.km, "to_sun": [-1e8, 0.0, 0.0] * u.km}
    geometry = observing.Geometry(date + [-2.0, 2.0] * u.h, **lines, light_time=False)
    system = fullbody.System(bodies, units=True, **options)
    run = system.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3))), 1.0, dense=True)
    points = {"east": [2.1, 0.0] * u.arcsec, "north": [0.0, 1.05] * u.arcsec}
    data = observing.Outline(date, **points, sigma=0.1 * u.arcsec, body="A", geometry=geometry)
    assert len(data.times) == 2
    km = (1.0 * u.arcsec).to_value("rad") * DISTANCE
    np.testing.assert_allclose(data.residuals(run).to_value("arcsec"), [2.1 - 2.0 / km, 1.05 - 1.0 / km], rtol=1e-6)


def test_tables_are_written_and_read_back():
    run, geometry = seen([fullbody.Sphere(2.0)], [[0, 0, 0]])
    data = measured(run, geometry, np.array([[2.1, 0.0], [0.0, 2.0]]))
    back = observing.Outline.from_table(data.to_table(), body="A", geometry=geometry)
    for name in ("east", "north", "sigma"):
        np.testing.assert_allclose(getattr(back, name).value, getattr(data, name).value, rtol=1e-15)
    np.testing.assert_array_equal(back.times.value, [0.0, 0.0])
