"""Binaries from published numbers: Kepler's law and directions worked out by hand."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Component, binary
from fullbody.errors import BodiesOverlap, InconsistentInput, InvalidInput
from support import refused
from support.ready_systems import relative

INF = float("inf")
NAN = float("nan")
BIG = {"semi_axes": (1.0, 0.9, 0.8), "rotation_period": INF}
SMALL = {"semi_axes": (0.3, 0.2, 0.15)}
FIRST, SECOND = Component(**BIG, mass=3.0), Component(**SMALL, mass=1.0)


def test_sizes_have_their_closed_forms():
    expected = fullbody.Ellipsoid(1.0, 0.5, 0.25)
    assert Component(semi_axes=(1.0, 0.5, 0.25)).shape == expected
    assert Component(diameters=(2.0, 1.0, 0.5)).shape == expected
    # The sphere of equal volume has the radius (1 * 0.5 * 0.25)^(1/3) = 0.5.
    shape = Component(diameter=1.0, axis_ratios=(2.0, 2.0)).shape
    np.testing.assert_allclose([shape.a, shape.b, shape.c], [1.0, 0.5, 0.25], rtol=1e-15)
    assert Component(diameter=2 * u.km).shape == fullbody.Ellipsoid(1 * u.km, 1 * u.km, 1 * u.km)
    refused("expected one of them", lambda: Component(diameter=1.0, diameters=(1, 1, 1)))
    refused("beside a diameter", lambda: Component(diameters=(1, 1, 1), axis_ratios=(1.2, 1.0)))
    refused("both a mass and a density", lambda: Component(diameter=1.0, mass=1.0, density=1.0))


VOLUMES = 4 / 3 * np.pi * np.array([0.72, 0.009])


@pytest.mark.parametrize(
    ("first", "second", "pair", "expected"),
    [
        ({"mass": 3.0}, {"mass": 1.0}, {}, [3, 1]),
        ({"density": 2.0}, {"density": 1.0}, {}, VOLUMES * [2, 1]),
        ({"mass": 3.0}, {"density": 1.0}, {}, [3, VOLUMES[1]]),
        ({}, {}, {"total_mass": 4.0, "mass_ratio": 1 / 3}, [3, 1]),
        ({}, {}, {"total_mass": 4.0, "equal_density": True}, 4 * VOLUMES / sum(VOLUMES)),
        ({"mass": 3.0}, {}, {"total_mass": 4.0}, [3, 1]),
        ({}, {"mass": 1.0}, {"total_mass": 4.0}, [3, 1]),
        ({"mass": 3.0}, {}, {"mass_ratio": 1 / 3}, [3, 1]),
        ({}, {"mass": 1.0}, {"mass_ratio": 1 / 3}, [3, 1]),
        # By Kepler's law a = 4 and P = 8 pi make G M = 4 pi^2 64 / (64 pi^2) = 4.
        ({}, {}, {"semi_major_axis": 4.0, "period": 8 * np.pi, "mass_ratio": 1 / 3}, [3, 1]),
    ],
)
def test_masses_have_their_closed_forms(first, second, pair, expected):
    pair = {"semi_major_axis": 4.0, "eccentricity": 0.1, "elements": "osculating", **pair}
    system, _ = binary(Component(**BIG, **first), Component(**SMALL, **second), G=1.0, **pair)
    np.testing.assert_allclose(system.masses, expected, rtol=1e-14)


def test_period_and_semi_major_axis_obey_keplers_law():
    for arguments in ({"period": 8 * np.pi}, {"semi_major_axis": 4.0}, {"period": 8 * np.pi, "semi_major_axis": 4.0}):
        system, state = binary(FIRST, SECOND, G=1.0, eccentricity=0.2, elements="osculating", **arguments)
        np.testing.assert_allclose(relative(state)[0], [3.2, 0, 0], atol=1e-14)
        np.testing.assert_allclose(state.spin[1, 2], 0.25, rtol=1e-14)
        np.testing.assert_allclose(system.momentum(state), 0.0, atol=1e-14)


def test_contradictions_are_reported():
    arguments = {"period": 8 * np.pi, "semi_major_axis": 4.04, "eccentricity": 0.1}
    with pytest.warns(InconsistentInput, match=r"semi-major axis is 4 by .* and 4.04 by .* 0.99 %"):
        _, state = binary(FIRST, SECOND, G=1.0, **arguments, elements="osculating")
    np.testing.assert_allclose(relative(state)[0][0], 4.0 * 0.9, rtol=1e-14)
    refused("a difference of 20 %", lambda: binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=5.0))
    with pytest.raises(InvalidInput, match="total mass is 4 by the components and 5 by total_mass"):
        binary(FIRST, SECOND, G=1.0, period=1.0, total_mass=5.0)
    refused("mass ratio", lambda: binary(FIRST, SECOND, G=1.0, period=1.0, mass_ratio=0.5))
    binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=4.04, mismatch_warning=0.02)


def test_tolerances_of_zero_and_infinity_refuse_all_and_nothing():
    with pytest.raises(InvalidInput, match=r"0\.0999 %; expected agreement to mismatch_error=0$"):
        binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=4.004, mismatch_error=0)
    with pytest.warns(InconsistentInput, match="a difference of 20 %"):
        binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=5.0, mismatch_error=INF)


def test_poles_and_long_axes_point_where_stated():
    lon, lat = np.radians([310.0, -84.0])
    first = Component(**BIG | {"rotation_period": 2.0, "mass": 3.0, "pole": (1.0, 0.5), "rotation_angle": 0.3})
    orbit = {"semi_major_axis": 4.0, "eccentricity": 0.1, "mean_anomaly": 2.0, "argument_of_periapsis": 0.4}
    system, state = binary(first, SECOND, G=1.0, **orbit, pole=(lon, lat), libration=np.radians(10))
    r, v = relative(state)
    orbit_pole = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    direction = [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]
    np.testing.assert_allclose(orbit_pole, direction, atol=1e-14)
    elements = fullbody.KeplerElements.from_cartesian(r, v, system.mu())
    np.testing.assert_allclose([elements.omega, elements.M], [0.4, 2.0], rtol=1e-12)
    x, _, z = state.rotation_matrix[1].T
    np.testing.assert_allclose(z, direction, atol=1e-14)
    towards = -r / np.linalg.norm(r)
    np.testing.assert_allclose(x @ towards, np.cos(np.radians(10)), rtol=1e-13)
    np.testing.assert_allclose(np.cross(towards, x) @ z, np.sin(np.radians(10)), rtol=1e-12)
    np.testing.assert_allclose(state.attitude[0], fullbody.frames.attitude(1.0, 0.5, 0.3), atol=1e-15)
    np.testing.assert_allclose(state.spin[0], [0, 0, np.pi], rtol=1e-15)


def test_a_secondary_that_is_not_synchronous_rotates_as_stated():
    second = Component(**SMALL, mass=1.0, rotation_period=-4.0, rotation_angle=90 * u.deg)
    options = {"synchronous": False, "at_rest": "primary", "mismatch_warning": INF}
    _, state = binary(FIRST, second, G=1.0, semi_major_axis=4.0, **options)
    # Kepler's circle: G (m1 + m2) = 4.
    np.testing.assert_allclose(state.position, [[0, 0, 0], [4, 0, 0]], rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(state.velocity, [[0, 0, 0], [0, 1, 0]], rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(state.rotation_matrix[1][:, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(state.spin[1, 2], -np.pi / 2)


def test_binaries_have_units():
    first = Component(diameters=(1.53, 1.50, 1.35) * u.km, rotation_period=2.765 * u.hour)
    second = Component(diameters=(0.57, 0.46, 0.35) * u.km)
    orbit = {"total_mass": 2.49e12 * u.kg, "mass_ratio": 0.057, "period": 17.42 * u.hour, "elements": "osculating"}
    sky = {"pole": (105.4 * u.deg, -66 * u.deg), "frame": "ecliptic", "epoch": "2001-05-27 UTC"}
    system, state = binary(first, second, **orbit, **sky, mismatch_warning=INF, units=("m", "s", "kg"))
    # Ostro et al. (2006) publish a = 2.548 km with these.
    np.testing.assert_allclose(np.linalg.norm(relative(state)[0].to_value(u.km)), 2.548, rtol=1e-3)
    assert system.frame == "ecliptic"
    assert state.spin.unit == u.rad / u.s
    assert system.bodies[0].shape.a == 0.765 * u.km
    assert system.integrate(state, 1 * u.hour).dates[0].scale == "utc"


def test_bodies_that_overlap_at_the_start_are_refused():
    first, second = Component(diameter=2.0, mass=3.0, rotation_period=INF), Component(diameter=1.0, mass=1.0, name="B")
    binary(first, second, G=1.0, semi_major_axis=1.5001)
    for kind in ("osculating", "mean"):
        with pytest.raises(BodiesOverlap, match=r"body 0 and B overlap at the start, their centres 1\.4999 apart"):
            binary(first, second, G=1.0, semi_major_axis=1.4999, elements=kind)
    # At periapsis 1.35, at apoapsis 1.65.
    with pytest.raises(BodiesOverlap, match=r"1\.35 apart"):
        binary(first, second, G=1.0, semi_major_axis=1.5, eccentricity=0.1, gravity="point")
    binary(first, second, G=1.0, semi_major_axis=1.5, eccentricity=0.1, mean_anomaly=180 * u.deg)


def test_densities_that_no_asteroid_has_are_warned_of():
    # A sphere of 1 km across has 0.52360 km^3, in which 5.2360e11 kg make 1000 kg/m^3.
    ball = {"diameter": 1 * u.km, "rotation_period": INF}

    def weigh(mass, **options):
        masses = {"mass": mass, "name": "Ball"}, {"mass": 5.2360e11 * u.kg}
        first, second = (Component(**ball, **m) for m in masses)
        arguments = {"semi_major_axis": 3 * u.km, "synchronous": False, "units": ("km", "hour", "kg")}
        return binary(first, second, **arguments, **options)

    weigh(5.2360e11 * u.kg)
    for mass, density in ((5.2360e9 * u.kg, "10"), (2.0944e10 * u.t, "4e.04")):
        with pytest.warns(InconsistentInput, match=f"^Ball has a density of {density} kg/m3; expected 100"):
            weigh(mass)
    # A density of two is two kilograms a cubic kilometre in the units km, hour and kg.
    first, second = (Component(**ball, density=2.0, name=name) for name in ("Alpha", "Beta"))
    with pytest.warns(InconsistentInput) as caught:
        binary(first, second, semi_major_axis=3 * u.km, units=("km", "hour", "kg"), synchronous=False)
    start = "{} has a density of 2e-09 kg/m3; "
    assert {str(w.message).split("expected")[0] for w in caught} == {start.format("Alpha"), start.format("Beta")}


def test_a_rotation_that_is_not_stated_is_visible():
    still, turning = Component(diameter=2.0, mass=3.0), Component(diameter=2.0, mass=3.0, rotation_period=4.0)
    small = Component(diameter=0.2, mass=0.1, name="Beta")
    arguments = {"G": 1.0, "semi_major_axis": 5.0}
    with pytest.warns(InconsistentInput, match="primary 'body 0' has no rotation_period and starts without"):
        _, state = binary(still, small, **arguments)
    np.testing.assert_array_equal(state.spin[0], 0.0)
    with pytest.warns(InconsistentInput, match="secondary 'Beta' has no rotation_period"):
        _, state = binary(turning, small, synchronous=False, **arguments)
    np.testing.assert_allclose(state.spin, [[0, 0, np.pi / 2], [0, 0, 0]])
    # Said outright, no warning; a synchronous secondary turns with the orbit of n^2 a^3 = G M.
    _, state = binary(Component(diameter=2.0, mass=3.0, rotation_period=INF), small, **arguments)
    np.testing.assert_allclose(state.spin, [[0, 0, 0], [0, 0, np.sqrt(3.1 / 125)]])


def test_a_tilt_is_from_the_orbits_pole():
    # About the node: with the node at 90 degrees of longitude plus the pole's, along its horizontal axis.
    lon, lat = 0.7, 0.4
    shapes = Component(**BIG, mass=3.0), Component(**SMALL, mass=1.0, tilt="6 deg")
    _, state = binary(*shapes, G=1.0, semi_major_axis=5.0, pole=(lon, lat), elements="mean")
    z = state.rotation_matrix[1][:, 2]
    normal = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    node = np.array([-np.sin(lon), np.cos(lon), 0.0])
    np.testing.assert_allclose(z, np.cos(np.pi / 30) * normal + np.sin(np.pi / 30) * np.cross(node, normal), atol=1e-14)


def test_texts_with_units_are_taken():
    def made(convert):
        sizes, spin = ([*map(convert, texts)] for texts in (("1.53 km", "1.5 km", "1350 m"), ("2.765 hour", "2 g/cm3")))
        first = Component(diameters=sizes, rotation_period=spin[0], density=spin[1])
        second = Component(diameter=convert("0.45 km"), mass=convert("1.35e11 kg"))
        pole, period, anomaly = (convert("105.4 deg"), convert("-66 deg")), convert("17.42 hour"), convert("90 deg")
        return binary(first, second, period=period, pole=pole, mean_anomaly=anomaly, units=("km", "hour", "kg"))

    texts, quantities = made(str), made(u.Quantity)
    np.testing.assert_allclose(texts[0].masses.value, quantities[0].masses.value, rtol=1e-15)
    np.testing.assert_allclose(texts[1].position.value, quantities[1].position.value, rtol=1e-15)


def test_numbers_with_units_are_refused_by_a_system_without():
    sizes = {"diameter": 2 * u.km}, {"diameter": "0.2 km"}, {"diameters": ["2 km", "2 km", "1 km"]}, {"diameter": 2.0}
    for size in sizes:
        first, second = Component(**size, mass=1.0, rotation_period=3.0), Component(diameter=0.1, mass=0.01)
        period = 20 * u.h if size["diameter" if "diameter" in size else "diameters"] == 2.0 else 20.0
        refused(r"have units and the system has none; expected units=\('km', ", binary, first, second, period=period)
    arguments = {"period": 20 * u.h}
    first = Component(diameter=2 * u.km, density=2 * u.g / u.cm**3, rotation_period=3 * u.h)
    second = Component(diameter=0.2 * u.km, density=2 * u.g / u.cm**3)
    usual, same = (binary(first, second, units=units, **arguments)[1] for units in (True, ("km", "hour", "kg")))
    assert usual == same


NONE = {"mass": None}
POLES = 5, (1, 2, 3), (310.0, -84.0), "north", (0.0, 2.0)
TOTAL = {"total_mass": 1.0, "mass_ratio": 0.1, "period": 1.0}
ANGLES = r"is .*expected \(longitude, latitude\) in radians, the latitude from -pi/2 to pi/2, or Quantities"
TOLERANCE = "(is .*; expected a number, zero or above|has the unit km; expected pure numbers)$"
#: Parts of the first and the second component, arguments of the pair, and the error; ``None`` takes a default away.
REFUSED = [
    (NONE, NONE, {"period": 1.0, "semi_major_axis": None}, "the masses are not given"),
    (NONE, NONE, TOTAL | {"mass_ratio": None}, "shared is not given"),
    (NONE, NONE, TOTAL | {"period": None, "semi_major_axis": None}, "neither period nor"),
    (NONE, NONE, TOTAL | {"total_mass": -1.0}, "total_mass is -1.0"),
    (NONE, NONE, TOTAL | {"mass_ratio": 0.0}, "mass_ratio is 0.0"),
    (NONE, NONE, TOTAL | {"equal_density": True}, "expected one of the two"),
    (NONE, NONE, TOTAL | {"at_rest": "sun"}, "at_rest is 'sun'"),
    (NONE, NONE, TOTAL | {"total_mass": 1.0 * u.kg}, "no units"),
    (NONE, NONE, TOTAL | {"G": None}, "G is not given"),
    ({}, {}, {"elements": "true"}, "elements is 'true'"),
    ({}, {"rotation_period": 1.0}, {}, "the secondary has a rotation_period and is synchronous"),
    ({}, {"rotation_period": 2.0}, {"synchronous": False, "libration": 0.5}, r"libration is 0\.5 of a secondary"),
    ({}, {"rotation_angle": 1.0}, {}, r"rotation_angle is 1\.0 of a secondary that is synchronous; expected lib"),
    ({}, {}, {"libration": 10}, "libration is 10; expected radians, a turn at most"),
    ({}, {}, {"bodies": []}, "'bodies' is not an option of binary"),
    ({}, {}, {"peroid": 3.0}, r"'peroid' is not an option of binary; did you mean 'period'\?"),
    ({}, {}, {"period": 30.0, "gravty": "point"}, r"'gravty' is not an option of binary; did you mean 'gravity'\?"),
    ({"pole": (0.1, 0.2), "tilt": 0.1, "name": "Alpha"}, {}, {}, "Alpha is given both a pole and a tilt"),
    ({}, {}, {"pole": (1 * u.kg, 0.0)}, "longitude of pole has the unit kg; expected a unit such as rad"),
    ({}, {}, {"pole": (0.0, NAN)}, "latitude of pole is nan; expected a finite number"),
    ({}, {}, {"pole": ("x", 0.0)}, "longitude of pole is 'x'; expected a finite number"),
    *(({}, {}, {"pole": pole}, f"^pole {ANGLES}") for pole in POLES),
    *(({"pole": pole, "name": "Alpha"}, {}, {}, f"^pole of Alpha {ANGLES}") for pole in POLES),
    *(
        ({}, {}, {"eccentricity": e, "elements": kind}, f"^eccentricity is {e}; expected a number from 0 to below 1$")
        for e in (1.2, 1.0, -0.1, NAN)
        for kind in ("mean", "osculating", None)
    ),
    *(
        ({}, {}, {name: value, "period": period}, f"^{name} {TOLERANCE}")
        for name in ("mismatch_warning", "mismatch_error")
        for value in (NAN, -INF, -0.1, "a", None, (0.1, 0.2), 10**400, 0.1 * u.km)
        for period in (None, 8 * np.pi)
    ),
]


@pytest.mark.parametrize(("first", "second", "pair", "what"), REFUSED)
def test_invalid_binaries_are_refused_with_name_and_expectation(first, second, pair, what):
    def make():
        parts = Component(**BIG | {"mass": 3.0} | first), Component(**SMALL | {"mass": 1.0} | second)
        binary(*parts, **{"G": 1.0, "semi_major_axis": 5.0} | pair)

    refused(what, make)
