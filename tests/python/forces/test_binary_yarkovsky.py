"""The binary Yarkovsky effect: against heat computed facet by facet, its signs, its range, and its derivatives."""

import fullbody
import numpy as np
import pytest
from astropy import constants
from astropy import units as u
from fullbody import Sphere
from fullbody.errors import ForceFailed
from fullbody.forces import BinaryYarkovsky, solar_pressure
from support import body_list, ready, refused_with
from support.flows import central_of_state, displaced
from support.meshes import icosphere

MASS, SECONDARY = 1e-3, 0.05


def pair(spin, distance=3.0, tilt=0.0, speed=1.0, lean=0.0, forces=()):
    """A ball on a circle about a ball of radius one, its spin in mean motions, leant from the orbit's normal."""
    system = fullbody.System(body_list(A=(Sphere(1.0), 1.0), B=(Sphere(SECONDARY), MASS)), G=1.0, forces=forces)
    n = np.sqrt((1.0 + MASS) / distance**3)
    r, v = np.array([distance, 0.0, 0.0]), n * distance * speed * np.array([0.0, np.cos(tilt), np.sin(tilt)])
    axis = np.array([0.0, -np.sin(tilt - lean), np.cos(tilt - lean)])
    share = MASS / (1.0 + MASS)
    fractions = np.array([-share, 1 - share])[:, None]
    state = fullbody.State(fractions * r, fractions * v, spin=[[0, 0, 0], spin * n * axis])
    return system, state, n


def heat(**arguments):
    return BinaryYarkovsky("B", "A", **{"pressure": 1.0, "lag": 0.3, "name": "H"} | arguments)


def along(force, spin, **arguments):
    """The component of the force along the motion."""
    system, state, _ = pair(spin, **arguments)
    load = system.with_forces([force]).loads(state)["H"]
    v = np.asarray(state.velocity[1])
    np.testing.assert_allclose(load.force[1] - (load.force[1] @ v) * v / (v @ v), 0.0, atol=1e-15)
    np.testing.assert_array_equal(load.force[0], 0.0)
    return load.force[1] @ v / np.linalg.norm(v)


def direct(spin, thermal, incident, count=4096):
    """The mean force along the motion by facets of a ball, in units of pressure and area, for plane heat conduction.

    ``thermal`` is n T. ``incident`` gives for anomalies (K,), at zero on the far side of the Sun's direction +x, and
    unit vectors (K, 3) of the ball's position, vectors of light (J, K, 3): directions times flux.
    """
    ball = icosphere(2)
    corners = np.asarray(ball.vertices)[np.asarray(ball.faces)]
    cross = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    normals, area = cross / area[:, None], area * 4 * np.pi / area.sum()
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    point = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    c, s = np.cos(spin * angle), np.sin(spin * angle)
    to_body = np.zeros((count, 3, 3))
    to_body[:, 0, 0], to_body[:, 0, 1], to_body[:, 1, 0], to_body[:, 1, 1], to_body[:, 2, 2] = c, s, -s, c, 1.0
    absorbed = np.zeros((count, len(normals)))
    for light in incident(angle, point):
        absorbed += np.maximum(np.einsum("kij,kj->ki", to_body, light) @ normals.T, 0.0)
    frequency = np.arange(count // 2 + 1)
    response = 1.0 / (1.0 + (1.0 + 1.0j) * np.sqrt(frequency * thermal) / 2.0)
    radiated = np.fft.irfft(np.fft.rfft(absorbed, axis=0) * response[:, None], count, axis=0)
    force = np.einsum("kij,ki->kj", to_body, -2.0 / 3.0 * (radiated * area) @ normals)
    ahead = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    return (force * ahead).sum(axis=1).mean()


@pytest.mark.parametrize("spin", [3, -1, 0])
@pytest.mark.parametrize("thermal", [0.2, 5.0])
def test_the_shadow_gives_the_force_of_heat_computed_facet_by_facet(spin, thermal):
    """The Sun is missing within arcsin(1/3) of the side away from it; the primary reflects and radiates nothing."""

    def sunlight(angle, point):
        dark = (point[:, 0] < 0) & (np.abs(point[:, 1]) < 1.0 / 3.0)
        yield np.where(dark, 0.0, 1.0)[:, None] * [1.0, 0.0, 0.0]

    lag = np.arctan2(*(np.sqrt(abs(1 - spin) * thermal) / 2 * np.array([1.0, 1.0]) + [0.0, 1.0]))
    expected = direct(spin, thermal, sunlight) * SECONDARY**2
    assert along(heat(lag=lag, albedo=0.0, emissivity=0.0), spin) == pytest.approx(expected, rel=4e-3)


def test_the_light_of_the_primary_gives_the_force_of_heat_computed_facet_by_facet():
    """A Lambertian ball far away, whose facets return the sunlight at once."""
    ball, distance = icosphere(2), 40.0
    corners = np.asarray(ball.vertices)[np.asarray(ball.faces)]
    cross = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    cross *= np.sqrt(1.0) * 4 * np.pi / np.linalg.norm(cross, axis=1).sum()
    normals = cross / np.linalg.norm(cross, axis=1)[:, None]

    def returned(angle, point):
        received = np.maximum(cross[:, 0], 0.0)
        flux = np.maximum(point @ normals.T, 0.0) @ received / (np.pi * distance**2)
        yield -point * flux[:, None]

    spin, thermal = 3, 1.0
    lag = np.arctan2(*(np.sqrt(2 * thermal) / 2 * np.array([1.0, 1.0]) + [0.0, 1.0]))
    with_light, without = (along(heat(lag=lag, albedo=0.0, emissivity=e), spin, distance=distance) for e in (1.0, 0.0))
    expected = direct(spin, thermal, returned, 1024) * SECONDARY**2
    assert with_light - without == pytest.approx(expected, rel=1e-2)
    assert expected > 0.0 > without


def test_the_mean_shadow_of_a_tilted_orbit_is_an_elliptic_integral():
    from scipy.special import ellipe

    flat = {"emissivity": 0.0, "albedo": 0.0}
    for k in (0.2, 0.5, 0.69):
        tilted = along(heat(**flat), 3.0, tilt=np.arcsin(k / 3.0))
        assert tilted / along(heat(**flat), 3.0) == pytest.approx(2 / np.pi * ellipe(k * k), abs=3e-4)


def test_a_fast_rotator_drifts_inwards_and_a_slow_or_retrograde_one_outwards():
    assert along(heat(), 2.0) < 0.0 < along(heat(), 0.5)
    assert along(heat(), -2.0) == pytest.approx(-along(heat(), 2.0))


def test_the_orbit_drifts_by_2_F_over_m_n():
    force = heat(pressure=1e-5)
    system, state, n = pair(3.0)
    until = 20 * 2 * np.pi / n
    ends = [s.integrate(state, until, output=[until]).elements().a[0] for s in (system.with_forces([force]), system)]
    thrust = along(force, 3.0)
    # The force acts on the secondary alone, and the relative motion has the reduced mass.
    assert (ends[0] - ends[1]) / until == pytest.approx(2 * thrust / (MASS * n), rel=3e-3)


def test_thermal_inertia_gives_the_parameter_of_the_textbook():
    """Theta = Gamma sqrt(nu) / (e sigma T^3), with the temperature T of the subsolar point."""
    system, state = ready("didymos_after_dart", units=True)
    primary, secondary = system.names
    pressure = solar_pressure("1.644 au", 0.384)
    arguments = {
        "pressure": pressure,
        "pole": (0.0569, -0.0172, 0.9982),
        "albedo": 0.05,
        "emissivity": 0.95,
        "name": "H",
    }
    r, v = (np.asarray((part[1] - part[0]).si.value) for part in (state.position, state.velocity))
    rate = np.linalg.norm(np.cross(r, v)) / (r @ r)
    spin = np.array(state.spin.value)
    spin[1] *= 3.0
    state = fullbody.State(state.position, state.velocity, attitude=state.attitude, spin=spin * state.spin.unit)
    nu = 3.0 * state.spin[1, 2].to_value("rad / s") / 3.0 - rate
    sigma, flux = constants.sigma_sb.value, pressure.to_value("Pa") * constants.c.value
    temperature = (0.95 * flux / (0.95 * sigma)) ** 0.25
    theta = 250.0 * np.sqrt(nu) / (0.95 * sigma * temperature**3)
    lag = np.arctan(0.5 * theta / (1.0 + 0.5 * theta))
    forces = [
        BinaryYarkovsky(secondary, primary, thermal_inertia=inertia, **arguments)
        for inertia in (250.0, "250 J / (m2 K s(1/2))", 0.25 * u.kW * u.s**0.5 / (u.m**2 * u.K))
    ]
    forces.append(BinaryYarkovsky(secondary, primary, lag=lag * u.rad, **arguments))
    result = [system.with_forces([force]).loads(state)["H"].force[1].to_value("N") for force in forces]
    for item in result[1:]:
        np.testing.assert_allclose(item, result[0], rtol=1e-9)


@pytest.mark.parametrize("units", [None, ("km", "hour", "kg")])
def test_derivatives_are_those_of_differences(units):
    """The force has a lag in a system without units, and a thermal inertia in one with units."""
    system, state, _ = pair(2.5, tilt=0.05, lean=0.1)
    arguments = {"lag": 0.3, "pressure": 3e-3}
    if units:
        # The parameter Theta is about 0.5.
        arguments = {"lag": None, "thermal_inertia": 8e-4, "pressure": 3e-3 * u.kg / (u.km * u.h**2)}
        system = fullbody.System(system.bodies, G=1.0, units=units)
    forced = system.with_forces([heat(pole=(0.05, 0.1, 1.0), **arguments)])
    unitless = lambda value: np.asarray(getattr(value, "value", value))  # noqa: E731
    result = MASS * (unitless(forced.jacobian(state).rates) - unitless(system.jacobian(state).rates))[15:18]
    size = np.abs(unitless(forced.loads(state)["H"].force)).max()
    for point in np.ndindex(2, 4, 3):
        force = lambda by, point=point: unitless(forced.loads(displaced(state, *point, by))["H"].force[1])  # noqa: E731
        expected = central_of_state(force, 1e-4)
        assert result[:, np.ravel_multi_index(point, (2, 4, 3))] == pytest.approx(expected, abs=1e-7 * size)


def test_a_sensitivity_is_that_of_the_pressure():
    system, state, _ = pair(2.5)
    runs = {}
    for pressure in (0.99e-3, 1e-3, 1.01e-3):
        forced = system.with_forces([heat(pressure=pressure)])
        runs[pressure] = forced.integrate(state, 10.0, output="ends", derivatives=["factor of H"])
    result = runs[1e-3].sensitivity["factor of H"][-1][12:15]
    expected = (runs[1.01e-3].position[-1, 1] - runs[0.99e-3].position[-1, 1]) / 0.02
    assert result == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_a_saved_run_has_the_force_with_its_thermal_inertia(tmp_path):
    system, state = ready("didymos_after_dart", units=True)
    spin = state.spin * [[1.0], [3.0]]
    arguments = {"pressure": "2e-6 Pa", "pole": (0.0569, -0.0172, 0.9982), "name": "H"}
    for response in ({"thermal_inertia": 320.0}, {"lag": "10 deg"}):
        forced = system.with_forces([BinaryYarkovsky("Dimorphos", "Didymos", **arguments, **response)])
        run = forced.integrate(state.replace(spin=spin), "1 h", output="ends")
        run.save(tmp_path / "run.nc")
        again = fullbody.load(tmp_path / "run.nc").system.forces[0]
        for role in ("thermal_inertia", "lag"):
            first, second = (getattr(force, role) for force in (forced.forces[0], again))
            assert (first is None) == (second is None)
            if first is not None:
                assert u.Quantity(second).si.value == pytest.approx(u.Quantity(first).si.value, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"spin": 1.05}, "differs from the mean motion by 0.050"),
        ({"spin": 3.0, "speed": 1.06}, "eccentricity 0.12"),
        ({"spin": 3.0, "tilt": 0.25}, "inclined to the orbit round the Sun"),
        ({"spin": 3.0, "lean": 0.6}, "inclined to the orbit's normal"),
    ],
)
def test_a_motion_out_of_the_range_of_the_formula_is_refused(arguments, words):
    system, state, _ = pair(**arguments)
    with pytest.raises(ForceFailed, match=words):
        system.with_forces([heat()]).integrate(state, 1.0)


@pytest.mark.parametrize(
    ("arguments", "pieces"),
    [
        ({"lag": None}, "thermal_inertia and lag of H are None and None ... one of the two"),
        ({"thermal_inertia": 200.0}, "thermal_inertia and lag of H ... one of the two"),
        ({"lag": 0.8}, "lag of H ... 0.8 ... above 0 and below pi/4"),
        ({"lag": 0.0}, "lag of H ... 0"),
        ({"pressure": 0.0}, "pressure of H ... above zero"),
        ({"albedo": 1.2}, "albedo of H is 1.2 ... from 0 to 1"),
        ({"emissivity": -0.1}, "emissivity of H is -0.1 ... from 0 to 1"),
        ({"lag": None, "thermal_inertia": -3.0}, "thermal_inertia of H ... -3.0 ... above zero"),
        ({"lag": None, "thermal_inertia": "3 kg"}, "thermal_inertia of H ... kg"),
        ({"lag": None, "thermal_inertia": 3.0, "albedo": 1.0}, "albedo and emissivity ... 1.0 ... warms"),
        ({"pole": (0, 0, 0)}, "pole of H"),
    ],
)
def test_bad_arguments_are_refused_by_name(arguments, pieces):
    refused_with(pieces, lambda: heat(**arguments))


def test_forces_that_do_not_suit_the_system_are_refused_by_name():
    system, _, _ = pair(3.0)
    refused_with(
        "thermal_inertia of H ... no units ... or a lag",
        lambda: system.with_forces([heat(lag=None, thermal_inertia=9.0)]),
    )
    refused_with("radius of H ... 2 ... at most the primary_radius", lambda: system.with_forces([heat(radius=2.0)]))
    points = fullbody.System(body_list(A=(fullbody.PointMass(), 1.0), B=(Sphere(0.1), 1.0)), G=1.0)
    refused_with("primary_radius of H is not given ... a point", lambda: points.with_forces([heat()]))
