"""The impact of a projectile changes velocity and spin by its momentum and angular momentum."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from support import body_list, refused


def pair():
    bodies = body_list(A=(fullbody.Sphere(1.0), 8.0), B=(fullbody.Ellipsoid(0.5, 0.4, 0.3), 1.0))
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State.from_tait_bryan(
        [[0, 0, 0], [4, 0.5, 0.2]], [[0, 0, 0], [0.1, 1.5, 0.3]], [[0, 0, 0], [0.3, -0.2, 1.1]],
        [[0, 0, 0.1], [0.2, 0.1, 0.4]],
    )  # fmt: skip
    return system, state


@pytest.mark.parametrize(("longitude", "latitude"), [(0.3, 0.2), (-2.0, -1.0), (1.0, np.pi / 2)])
def test_momentum_and_angular_momentum_are_conserved(longitude, latitude):
    system, state = pair()
    direction = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])
    point = state.rotation_matrix[1] @ (direction / np.sqrt((direction**2 / np.array([0.5, 0.4, 0.3]) ** 2).sum()))
    velocity = -50.0 * point + [1.0, 2.0, -3.0]
    struck = state.impact(system, 1, mass=1e-3, velocity=velocity, longitude=longitude, latitude=latitude)
    # The body keeps its mass: the projectile gives what it has relative to the ground, which goes on.
    ground = state.velocity[1] + np.cross(state.rotation_matrix[1] @ state.spin[1], point)
    momentum = 1e-3 * (state.velocity[1] + velocity - ground)
    np.testing.assert_allclose(system.momentum(struck) - system.momentum(state), momentum, rtol=1e-11, atol=1e-13)
    rotated = system.angular_momentum(struck) - system.angular_momentum(state)
    np.testing.assert_allclose(rotated, np.cross(state.position[1] + point, momentum), rtol=1e-10, atol=1e-13)
    np.testing.assert_array_equal(struck.position, state.position)
    np.testing.assert_array_equal(struck.velocity[0], state.velocity[0])
    assert (struck.spin[1] != state.spin[1]).any()


def test_ejecta_enhance_the_momentum_along_their_direction():
    # Head on, the momentum is enhanced by beta; aslant, along the normal or a direction that is given.
    ball = fullbody.System([fullbody.Body(fullbody.Sphere(2.0), mass=5.0, name="A")], G=1.0)
    state = fullbody.State([[0, 0, 0]], [[0, 0, 0]])
    options = {"mass": 1e-3, "longitude": 0.0, "latitude": 0.0}
    head_on = state.impact(ball, 0, velocity=[-6.0, 0, 0], beta=3.5, **options)
    np.testing.assert_allclose(head_on.velocity[0], [-3.5 * 6e-3 / 5, 0, 0], rtol=1e-14)
    assert not head_on.spin.any()
    aslant = {"velocity": [-6.0, 3.0, 0], "beta": 2.0, **options}
    np.testing.assert_allclose(5e3 * state.impact(ball, 0, **aslant).velocity[0], [-12.0, 3.0, 0], rtol=1e-13)
    # Straight back where it came from.
    back = state.impact(ball, 0, ejecta=[60.0, -30.0, 0], **aslant)
    np.testing.assert_allclose(5e3 * back.velocity[0], [-12.0, 6.0, 0], rtol=1e-13)
    # A sphere's moment of inertia is 2/5 m r^2.
    np.testing.assert_allclose(back.spin[0], [0, 0, 2.0 * 6e-3 / (0.4 * 5 * 4)], rtol=1e-13)


def test_the_velocity_of_the_ground_counts():
    ball = fullbody.System([fullbody.Body(fullbody.Sphere(2.0), mass=5.0, name="A")], G=1.0)
    turning = fullbody.State([[0, 0, 0]], [[0.3, 0.2, 0.1]], spin=[[0, 0, 0.5]])
    # It comes down along the normal as the ground has it.
    struck = turning.impact(ball, 0, mass=1e-3, velocity=[-6.0, 1.0, 0], longitude=0.0, latitude=0.0)
    np.testing.assert_allclose(struck.spin, turning.spin, rtol=1e-15)


def test_impacts_have_units_and_axes_of_the_orbit():
    system, state = fullbody.systems.didymos(units=True)
    options = {"mass": 579.4 * u.kg, "longitude": "-90 deg", "latitude": 0.0, "beta": 3.61, "along": "orbit"}
    struck = state.impact(system, "Dimorphos", velocity=["0 km/s", "-6.14 km/s", "0 km/s"], **options)
    change = (struck.velocity - state.velocity)[1].to_value("mm/s")
    expected = 3.61 * 579.4 * 6.14e6 / system.masses[1].to_value("kg")
    assert np.linalg.norm(change) == pytest.approx(expected, rel=1e-6)
    assert change @ state.velocity[1].value < 0.0
    kicked = state.kick("Dimorphos", [0, -expected, 0] * u.mm / u.s, along="orbit")
    np.testing.assert_allclose(kicked.velocity.value, struck.velocity.value, rtol=0.0, atol=2e-8)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"velocity": [6.0, 0, 0]}, "leaves the surface there at .* along the normal; expected one that comes"),
        ({"mass": 0.0}, "mass of the projectile is 0.0; expected a finite number above zero"),
        ({"latitude": 2.0}, "latitude is 2.0; expected angles from"),
        ({"beta": np.nan}, "beta is nan; expected a finite number"),
        ({"velocity": [1.0, 2.0]}, r"velocity of the projectile has shape \(2,\); expected \(3,\), finite numbers"),
        ({"body": "C"}, "body of impact is 'C'"),
    ],
)
def test_what_is_no_impact_is_refused(change, text):
    system, state = pair()
    options = {"body": 0, "mass": 1.0, "velocity": [-6.0, 0, 0], "longitude": 0.0, "latitude": 0.0} | change
    refused(text, lambda: state.impact(system, **options))
