"""Radiation coefficients from shapes: against YORPLib, closed forms, symmetries, direct means and observed drifts."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Body, Composite, Ellipsoid, Part, Polyhedron, Sphere
from fullbody.forces import Byorp, Tide, lag_from_quality_factor, radiation_coefficients, solar_pressure
from scipy.spatial.transform import Rotation
from support import ready, reference, refused_with
from support.meshes import box, icosphere, octahedron

YORPLIB = reference("yorplib")
CONVEX = Polyhedron(YORPLIB["convex"]["vertices"], YORPLIB["convex"]["faces"])


def alone(shape):
    return Body(shape, mass=1.0, name="A")


def beta(**arguments):
    system, _ = ready("kw4", shape="radar", units=True)
    return radiation_coefficients(system["Beta"], **arguments)


def lumpy(level):
    """A smooth surface without symmetry, by triangles whose corners are on it."""
    ball = icosphere(level, (1.0, 0.9, 0.8))
    x, y, z = np.asarray(ball.vertices).T
    radius = 1.0 + 0.05 * (np.sin(2.0 * x + 1.0) * np.cos(1.5 * y - 0.5) + np.sin(x + 2.0 * y * z + 0.3))
    return Polyhedron(np.asarray(ball.vertices) * radius[:, None], ball.faces)


def secular(coefficients, obliquity=0.4):
    """The mean force and torque of a synchronous body, and the mean torques along and across a spin."""
    parts = (coefficients.synchronous_force(obliquity), coefficients.synchronous_torque(obliquity))
    return np.concatenate([*parts, coefficients.spin_torques(obliquity)])


@pytest.mark.parametrize(
    ("result", "expected", "tolerances"),
    [
        (lambda: radiation_coefficients(alone(CONVEX), order=3, latitudes=13, longitudes=2880), "convex", (1e-6, 1e-6)),
        # YORPLib lights each of the 2,292 faces as a whole, by the ray to its centre.
        (lambda: beta(order=2, latitudes=7, longitudes=360), "beta", (2e-5, 4e-4)),
    ],
)
def test_all_coefficients_are_those_of_yorplib(result, expected, tolerances):
    result, expected = result(), YORPLIB[expected]
    np.testing.assert_allclose(np.degrees(result.latitude)[::-1], expected["latitude"], rtol=0, atol=1e-12)
    for name, tolerance in zip(("force", "torque"), tolerances, strict=True):
        rows = np.array(expected[name]).reshape(len(result.latitude), -1, 3)[::-1]
        parts = [getattr(result, f"{name}_{kind}") for kind in ("cosine", "sine")]
        cosine, sine = (np.asarray(getattr(part, "value", part)) for part in parts)
        size = np.abs(rows).max()
        np.testing.assert_allclose(cosine[:, 0], rows[:, 0], rtol=0, atol=tolerance * size)
        np.testing.assert_allclose(cosine[:, 1:], rows[:, 1::2], rtol=0, atol=tolerance * size)
        np.testing.assert_allclose(sine[:, 1:], rows[:, 2::2], rtol=0, atol=tolerance * size)


def test_the_force_on_a_sphere_is_thirteen_ninths_of_its_cross_section():
    """The light takes pi r^2, and two thirds of the mean cosine, which is two thirds, come on top."""
    result = radiation_coefficients(alone(Sphere(2.0)), latitudes=5)
    assert result.force_cosine[2, 1] == pytest.approx([-13 / 9 * np.pi * 4, 0, 0], rel=1e-3, abs=1e-12)
    assert result.force_sine[2, 1] == pytest.approx([0, -13 / 9 * np.pi * 4, 0], rel=1e-3, abs=1e-12)


@pytest.mark.parametrize(
    "shape",
    [
        Ellipsoid(3.0, 2.0, 1.0),
        box(3.0, 2.0, 1.0),
        octahedron(3.0, 2.0, 1.0),
        Composite([Part(Sphere(1.0), mass=1.0, position=(x, 0.0, 0.0)) for x in (-2.0, 2.0)]),
    ],
    ids=["ellipsoid", "box", "octahedron", "two spheres"],
)
def test_a_body_with_the_symmetry_of_an_ellipsoid_has_no_secular_effect(shape):
    body = Body(shape, name="A") if isinstance(shape, Composite) else alone(shape)
    result = radiation_coefficients(body, longitudes=60, latitudes=31)
    size = np.abs(result.force_cosine).max()
    for obliquity in (0.0, 0.7, np.pi / 2, 2.0):
        assert np.abs(secular(result, obliquity)).max() < 1e-13 * size


def test_a_reflection_changes_the_sign_of_the_drift_and_of_the_torque_along_the_spin():
    """The reflection exchanges the two ends of the middle axis."""
    shape = lumpy(2)
    mirror = Polyhedron(np.asarray(shape.vertices) * [1.0, -1.0, 1.0], np.asarray(shape.faces)[:, ::-1])
    first, second = (radiation_coefficients(alone(entry), longitudes=60, latitudes=31) for entry in (shape, mirror))
    signs = [1, -1, 1, -1, 1, -1, -1, -1]
    size = np.abs(secular(first))
    assert size.min() > 1e-6
    np.testing.assert_allclose(secular(second), secular(first) * signs, rtol=1e-9, atol=1e-12)


def test_coefficients_converge_with_the_square_of_the_size_of_faces():
    result = [secular(radiation_coefficients(alone(lumpy(k)), longitudes=60, latitudes=31)) for k in (2, 3, 4)]
    errors = [np.abs(result[k + 1] - result[k]).max() for k in range(2)]
    assert 3.0 < errors[0] / errors[1] < 5.5
    assert errors[1] < 0.1 * np.abs(result[2]).max()


def direct_mean(shape, obliquity, eccentricity=0.5):
    """The torques along and across the spin of a convex body, over time on an eccentric orbit and all rotations."""
    corners = np.asarray(shape.vertices)[np.asarray(shape.faces)]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area, centre = 0.5 * np.linalg.norm(cross, axis=1), corners.mean(axis=1)
    normal = cross / (2.0 * area[:, None])
    pole, node = np.array([0.0, -np.sin(obliquity), np.cos(obliquity)]), np.array([1.0, 0.0, 0.0])
    anomaly = 2 * np.pi * (np.arange(180) + 0.5) / 180
    total, weight = np.zeros(3), 0.0
    for eccentric in anomaly:
        # Time passes by 1 - e cos E while E grows, and the pressure at that distance is its inverse square.
        distance = 1.0 - eccentricity * np.cos(eccentric)
        plus, minus = np.sqrt(1 + eccentricity), np.sqrt(1 - eccentricity)
        true = 2.0 * np.arctan2(plus * np.sin(eccentric / 2), minus * np.cos(eccentric / 2))
        sun = np.cos(true) * node + np.sin(true) * np.cross(pole, node)
        rotations = Rotation.from_rotvec(2 * np.pi * np.arange(180)[:, None] / 180 * [0, 0, 1.0])
        s = rotations.inv().apply(sun)
        mu0 = np.maximum(s @ normal.T, 0.0)
        force = -(mu0 * area)[..., None] * (s[:, None] + 2 / 3 * normal)
        total += rotations.apply(np.cross(centre, force).sum(axis=1)).mean(axis=0) / distance
        weight += 1.0 / distance
    return total[2] / weight, total[1] / weight


@pytest.mark.parametrize("obliquity", [0.5, 2.3])
def test_torques_are_means_over_time_on_an_eccentric_orbit(obliquity):
    """The mean pressure of solar_pressure times these is the mean of pressure and torque together."""
    result = radiation_coefficients(alone(CONVEX), latitudes=181)
    expected = direct_mean(CONVEX, obliquity)
    assert result.spin_torques(obliquity) == pytest.approx(expected, abs=2e-3 * max(map(abs, expected)))


def test_there_is_no_force_behind_the_primary():
    """A small ball is dark within the angle arcsin(R/d) of the line from the primary, in the plane of the orbit."""
    ball, primary = Body(Sphere(0.01), mass=1e-6, name="B"), Body(Sphere(1.0), mass=1.0)
    arguments = {"order": 1, "latitudes": 5, "longitudes": 3600}
    result = radiation_coefficients(ball, other=primary, position=[-3.0, 0.0, 0.0], **arguments)
    force = result.synchronous_force()
    # What is missing of a mean of zero is the light from the side of the primary, which pushes outwards.
    assert force == pytest.approx([-13 / 9 * 1e-4 * np.sin(np.arcsin(1 / 3)), 0.0, 0.0], rel=2e-3, abs=1e-9)
    assert result.outwards == 1


def test_the_radar_shape_of_1999_kw4_gives_the_drift_that_mcmahon_and_scheeres_predict():
    """They predict 7 cm a year; the observed drift of the mean anomaly, -0.65 deg/yr^2, has the same sign."""
    system, state = ready("kw4", shape="radar", units=True)
    byorp = beta(towards=(1, 0, 0)).byorp("Alpha", solar_pressure("0.642 au", 0.688), obliquity="168 deg")
    force = system.with_force(byorp).loads(state)["BYORP on Beta"].force[1, 1]
    n, a = 2 * np.pi / (17.4223 * u.h), 2.548 * u.km
    drift = (2 * force / (system["Beta"].mass * n)).to_value("cm / yr")
    anomaly = (-0.75 * n / a * (drift * u.cm / u.yr)).to_value("1 / yr2") * 180 / np.pi
    assert drift == pytest.approx(7.0, abs=0.3)
    assert -5.0 < anomaly < -0.65


def test_the_tide_of_1996_fg3_in_equilibrium_has_the_published_ratio_within_its_factor():
    """Scheirich et al. (2015): Q/k = 2.4e5 within a factor of five, for a secondary like that of 1999 KW4."""
    shape = beta(towards=(1, 0, 0))
    pressure = solar_pressure("1.0538 au", 0.3497)
    coefficient = float(shape.byorp("Alpha", 1.0 * u.Pa).force[1].to_value("km2 Pa") / shape.radius.value**2)
    system, state = ready("fg3_1996", secondary_ratios=(1.3, 1.2), units=True)
    primary, secondary = system.names
    # Both act against each other where BYORP shrinks the orbit.
    byorp = Byorp(secondary, primary, coefficient=-coefficient, normalization="quillen_2022", pressure=pressure)
    spins = {"mean_motion": state.spin[1, 2], "spin": state.spin[0, 2]}
    lag = lag_from_quality_factor(Q=100.0, tide="semidiurnal", **spins)
    loads = system.with_forces([byorp, Tide(primary, secondary, k2=1e-3, lag=lag)]).loads(state)
    work = [float((load.force * state.velocity).sum().to_value("W")) for load in loads.values()]
    assert work[0] < 0.0 < work[1]
    assert 2.4e5 / 5 < 1e5 * work[1] / -work[0] < 2.4e5 * 5


def test_components_follow_the_principal_axes_of_any_body_frame():
    """The two shapes are one solid whose axes have other names."""
    shape = lumpy(2)
    rotation = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    rotated = Polyhedron(np.asarray(shape.vertices) @ rotation.T, shape.faces)
    arguments = {"longitudes": 60, "latitudes": 31}
    first, second = (radiation_coefficients(alone(entry), **arguments) for entry in (shape, rotated))
    assert not np.allclose(alone(shape).inertia, alone(rotated).inertia)
    # The directions of two axes together are not defined.
    same = np.abs(secular(second)) - np.abs(secular(first))
    assert np.abs(same).max() < 1e-10


def test_forces_of_coefficients_are_means_of_the_instantaneous_ones():
    """A table for the torque of YORP, and the axes outwards and along the motion for BYORP."""
    result = radiation_coefficients(alone(lumpy(2)), longitudes=60, latitudes=31)
    yorp = result.yorp(2.0, rows=9)
    along, across = result.spin_torques(np.linspace(0, np.pi, 9))
    np.testing.assert_allclose(yorp.along, 2.0 * along, rtol=1e-14)
    np.testing.assert_allclose(yorp.across, 2.0 * across, rtol=1e-14)
    for towards, rotation in (((-1, 0.2, 0), 1), ((0.3, 0, 0), -1)):
        seen = radiation_coefficients(alone(lumpy(2)), towards=towards, longitudes=60, latitudes=31)
        byorp = seen.byorp("P", 2.0, obliquity=0.3)
        signs = np.array([rotation, rotation, 1.0])
        np.testing.assert_allclose(byorp.force, 2.0 * signs * result.synchronous_force(0.3), rtol=1e-14)
        np.testing.assert_allclose(byorp.torque, 2.0 * signs * result.synchronous_torque(0.3), rtol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "pieces"),
    [
        ({"body": Sphere(1.0)}, "body is Sphere ... expected a Body"),
        ({"body": Body(fullbody.PointMass(), mass=1.0, name="P")}, "P ... a point ... with a surface"),
        ({"position": [5.0, 0, 0]}, "other and position ... both or neither"),
        ({"other": alone(Sphere(1.0))}, "other and position ... both or neither"),
        ({"other": alone(Sphere(1.0)), "position": [5.0, 0]}, "position ... (2,) ... (3,)"),
        ({"towards": [0.0, 1.0, 0.0]}, "towards ... normal to ... long axis"),
        ({"order": 0}, "order is 0 ... above zero"),
        ({"latitudes": 90}, "latitudes is 90 ... odd"),
        ({"longitudes": 91}, "longitudes is 91 ... even"),
        ({"longitudes": 8}, "longitudes is 8 ... 10"),
    ],
)
def test_bad_input_is_refused_by_name(arguments, pieces):
    refused_with(pieces, lambda: radiation_coefficients(**{"body": alone(Ellipsoid(3.0, 2.0, 1.0))} | arguments))


@pytest.mark.parametrize(
    ("call", "pieces"),
    [
        (lambda result: result.spin_torques(4.0), "obliquity is 4.0 ... from 0 to pi"),
        (lambda result: result.synchronous_force([0.1, -0.1]), "obliquity ... -0.1 ... from 0 to pi"),
        (lambda result: result.yorp(0.0, on="A"), "pressure is 0.0 ... above zero"),
        (lambda result: result.yorp(1.0), "on is not given ... name"),
        (lambda result: result.yorp("1 Pa", on="A"), "pressure ... Pa ... radius ... both or neither"),
        (lambda result: result.byorp("B", 1.0, on="A", obliquity=[0.1]), "obliquity"),
    ],
)
def test_bad_arguments_of_means_and_forces_are_refused_by_name(call, pieces):
    result = radiation_coefficients(Body(Sphere(1.0), mass=1.0), longitudes=10, latitudes=5)
    refused_with(pieces, lambda: call(result))


def test_a_body_that_overlaps_the_other_one_is_refused():
    with pytest.raises(fullbody.errors.BodiesOverlap):
        radiation_coefficients(alone(Sphere(1.0)), other=Body(Sphere(1.0), mass=1.0), position=[1.5, 0.0, 0.0])
