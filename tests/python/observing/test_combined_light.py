"""Centres of light against sums over the surface, cubes in closed form, and bodies that are far apart."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.base import rotations
from fullbody.observing.brightness import Epochs, Photometer
from support import body_list, matrix, refused
from support.meshes import box, icosphere

AXES = np.array([3.0, 2.0, 1.0])
ATTITUDE = np.array([0.4, -0.5, 0.6, np.sqrt(0.23)])
SIGHT, SUN = np.array([0.3, -0.2, 0.9]), np.array([-0.5, 0.3, 0.7])
#: A sphere that hides a part of the ellipsoid from the observer, and the Sun from another part.
CENTRE, RADIUS = 3.5 * SIGHT / np.linalg.norm(SIGHT) + [0.4, -0.3, 0.2], 0.8


def moments(shape, law, hidden, attitude=ATTITUDE, hider=fullbody.Sphere(RADIUS)):  # noqa: B008
    """The brightness of a body and its first moments, beside a sphere or alone."""
    bodies = [fullbody.Body(shape, mass=1.0, name="A")]
    bodies += [fullbody.Body(hider, mass=1.0, name="B")] if hidden else []
    position = np.stack([np.zeros(3), CENTRE])[: len(bodies)]
    attitudes = np.stack([attitude, [1.0, 0, 0, 0]])[: len(bodies)]
    photometer = Photometer(fullbody.System(bodies, G=1.0), law, 1.0, True, 0.0)
    return photometer.moments(Epochs(np.zeros(1), position[None], attitudes[None], SIGHT[None], SUN[None]))[0, 0]


def summed(law, hidden, n=500):
    """The same by a sum over the midpoints of 2 n^2 cells of the unit sphere."""
    theta, phi = np.meshgrid((np.arange(n) + 0.5) / n * np.pi, (np.arange(2 * n) + 0.5) / n * np.pi, indexing="ij")
    sphere = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1).reshape(-1, 3)
    rotation = matrix(ATTITUDE)
    normals = sphere / AXES
    size = np.linalg.norm(normals, axis=1)
    directions = [vector / np.linalg.norm(vector) for vector in (SIGHT, SUN)]
    mu, mu0 = (normals @ rotation.T @ vector / size for vector in directions)
    points = sphere * AXES @ rotation.T
    seen = (mu > 0.0) & (mu0 > 0.0)
    for vector in directions if hidden else ():
        separation = CENTRE - points
        along = separation @ vector
        seen &= ~((along > 0.0) & (np.sum(separation**2, axis=1) - along**2 < RADIUS**2))
    area = AXES.prod() * size * np.sin(theta).ravel() * (np.pi / n) ** 2
    light = np.where(seen, law(np.where(seen, mu, 1.0), np.where(seen, mu0, 1.0)), 0.0) * area
    return light.sum(), light @ points


LAWS = {
    "Lommel-Seeliger": (observing.LommelSeeliger(), lambda mu, mu0: mu * mu0 / (mu + mu0)),
    "Lambert": (observing.Lambert(), lambda mu, mu0: mu * mu0),
}


@pytest.mark.parametrize("hidden", [False, True])
@pytest.mark.parametrize("name", LAWS)
def test_first_moments_of_an_ellipsoid_are_sums_over_its_surface(name, hidden):
    law, function = LAWS[name]
    brightness, *moment = moments(fullbody.Ellipsoid(*AXES), law, hidden)
    total, sums = summed(function, hidden)
    # Cells that the outline of the sphere crosses count as a whole.
    tolerance = 1e-4 if hidden else 1e-5
    assert brightness == pytest.approx(total, rel=tolerance)
    np.testing.assert_allclose(moment, sums, atol=tolerance * 3.0 * total)


@pytest.mark.parametrize("hidden", [False, True])
def test_first_moments_of_many_facets_approach_those_of_the_ellipsoid(hidden):
    law = observing.LommelSeeliger()
    shape = icosphere(5, AXES)
    frame = fullbody.Body(shape, mass=1.0).working_frame
    rotated = rotations.product(ATTITUDE, rotations.inverse(np.array(frame.attitude)))
    faceted = moments(shape, law, hidden, rotated)
    exact = moments(fullbody.Ellipsoid(*AXES), law, hidden)
    # 20,480 facets have chords that lie inside by 2e-4 of the radius.
    np.testing.assert_allclose(faceted, exact, atol=1.2e-3 * exact[0])


def test_light_of_an_ellipsoid_behind_facets_has_the_centre_of_what_is_left():
    hider = icosphere(4, RADIUS)
    law = observing.LommelSeeliger()
    result = moments(fullbody.Ellipsoid(*AXES), law, True, hider=hider)
    exact = moments(fullbody.Ellipsoid(*AXES), law, True)
    np.testing.assert_allclose(result, exact, atol=5e-4 * exact[0])
    alone = moments(fullbody.Ellipsoid(*AXES), law, False)
    assert np.abs(exact[1:] / exact[0] - alone[1:] / alone[0]).max() > 5e-3


def test_centre_of_light_of_a_half_hidden_square_is_that_of_the_other_half():
    bodies = body_list(A=(box(2.0, 2.0, 2.0), 1.0), B=(box(2.0, 2.0, 1.0), 1.0))
    system = fullbody.System(bodies, G=1.0)
    # B is above A and covers 0.5 < x < 1 of its upper face; both faces are lit and seen from above.
    position = np.array([[[0.0, 0, 0], [1.5, 0.0, 5.0]]])
    frames = [np.array(body.working_frame.attitude) for body in bodies]
    attitude = np.stack([rotations.inverse(frame) for frame in frames])[None]
    up = np.array([[0.0, 0.0, 1.0]])
    result = Photometer(system, observing.Lambert(), 1.0, True, 0.0).moments(
        Epochs(np.zeros(1), position, attitude, up, up)
    )[0]
    np.testing.assert_allclose(result[0], [3.0, 3.0 * -0.25, 0.0, 3.0 * 1.0], atol=1e-13)
    np.testing.assert_allclose(result[1], [4.0, 0.0, 0.0, 4.0 * 0.5], atol=1e-13)


def pair(**options):
    bodies = body_list(A=(fullbody.Sphere(3.0), 9e12), B=(fullbody.Sphere(1.0), 1e12))
    system = fullbody.System(bodies, units=True, frame="equatorial", **options)
    state = fullbody.State(position=[[0, -2.0, 0], [0, 18.0, 0]], velocity=np.zeros((2, 3)), time=0.0)
    return system.integrate(state, 1.0, dense=True)


def view(to_sun):
    return observing.Geometry(
        [-1.0, 5.0] * u.h, to_observer=[-1e6, 0, 0] * u.km, to_sun=to_sun * u.km, light_time=False
    )


def test_light_of_two_spheres_is_centred_between_them_by_their_areas_and_albedos():
    run = pair()
    light = observing.combined_light(run, [0.0] * u.h, view([-1e8, 0, 0]), albedo={"A": 0.5, "B": 2.0})
    # At opposition the light of a sphere is its area times its albedo, and its centre is on the line of sight.
    share = 2.0 / (0.5 * 9.0 + 2.0)
    assert light.offset[0, 0].to_value("rad") == pytest.approx((-2.0 + 20.0 * share) / 1e6, rel=1e-5)
    assert abs(light.offset[0, 1].to_value("rad")) < 1e-15
    assert light.brightness[0].to_value("km2") == pytest.approx(np.pi / 2 * (0.5 * 9.0 + 2.0), rel=1e-5)
    np.testing.assert_allclose(light.centre[0, 1].to_value("km"), -2.0 + 20.0 * share, rtol=1e-5)


def test_centre_of_light_is_on_the_sunlit_side():
    run = pair()
    light = observing.combined_light(run, [0.0] * u.h, view([0.0, 0.0, 1e8]), mutual=False)
    # The observer is at -x, so that the Sun is to the north.
    assert light.offset[0, 1] > 1 * u.mas * 100


def test_where_no_light_comes_from_the_offset_is_zero():
    system = fullbody.System(body_list(A=(fullbody.Sphere(3.0), 9e12)), units=True, frame="equatorial")
    run = system.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3))), 1.0, dense=True)
    light = observing.combined_light(run, [0.0, 0.5] * u.h, view([1e8, 0.0, 0.0]))
    np.testing.assert_array_equal(light.offset.value, 0.0)
    np.testing.assert_array_equal(light.brightness.value, 0.0)


def test_a_hidden_satellite_leaves_the_centre_to_the_primary():
    bodies = body_list(A=(fullbody.Sphere(3.0), 9e12), B=(fullbody.Sphere(1.0), 1e12))
    system = fullbody.System(bodies, units=True, frame="equatorial")
    state = fullbody.State(position=[[-1.0, 0, 0], [9.0, 0.5, 0]], velocity=np.zeros((2, 3)))
    run = system.integrate(state, 0.1, dense=True)
    light = observing.combined_light(run, [0.0] * u.h, view([-1e8, 0, 0]))
    # The barycentre is at y = 0.05 km.
    assert light.centre[0, 1].to_value("km") == pytest.approx(-0.05, abs=1e-6)
    unhidden = observing.combined_light(run, [0.0] * u.h, view([-1e8, 0, 0]), mutual=False)
    assert unhidden.centre[0, 1].to_value("km") == pytest.approx(0.0, abs=1e-6)


def test_directions_alone_and_unknown_frames_are_refused():
    run = pair()
    directions = observing.Geometry([-1.0, 5.0] * u.h, to_observer=[-1e6, 0, 0], to_sun=[-1e6, 0, 0], light_time=False)
    message = "a centre of light needs the distance of the observer, and the geometry has directions alone"
    refused(message, lambda: observing.combined_light(run, [0.0] * u.h, directions))
    no_frame = fullbody.System(run.system.bodies, units=True).integrate(run[0], 0.1, dense=True)
    refused("a centre of light needs the axes", lambda: observing.combined_light(no_frame, [0.0] * u.h, directions))
