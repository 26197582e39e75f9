"""Warnings of input that is probably a mistake refer to the user's line; masked values are refused."""

import re
import warnings

import fullbody
import numpy as np
import pytest
from astropy import units as u
from astropy.table import Table
from astropy.utils.masked import Masked
from fullbody import Body, Component, Composite, Ellipsoid, KeplerElements, Part, PointMass, Sphere, State, System
from fullbody.errors import InconsistentInput, InvalidInput
from scipy.spatial.transform import Rotation
from support import points, refused

POSITION = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
VELOCITY = np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]])
START = State(POSITION, VELOCITY)
HIDDEN = np.ma.array(POSITION, mask=[[0, 0, 0], [1, 0, 0]])


def input_warnings(call):
    with warnings.catch_warnings(record=True, action="always") as caught:
        call()
    assert all(warning.category is InconsistentInput and warning.filename == __file__ for warning in caught), caught
    return [str(warning.message) for warning in caught]


@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda: State(HIDDEN, VELOCITY), "position has 1 masked value of 6"),
        (lambda: State(HIDDEN.tolist(), VELOCITY), "position is .*None"),
        (lambda: State([[0, 0, 0], [np.ma.masked, 0, 0]], VELOCITY), "position has 1 masked value of 3"),
        (lambda: State([np.zeros(3), HIDDEN[1]], VELOCITY), "position has 1 masked value of 3"),
        (lambda: State(np.array([[0] * 3, [np.ma.masked] * 3], dtype=object), VELOCITY), "position has 3 masked"),
        (lambda: State(Masked(POSITION * u.km, mask=HIDDEN.mask), VELOCITY), "position has 1 masked value"),
        (lambda: Component(semi_axes=np.ma.array([3.0, 2, 1], mask=[0, 0, 1])), "semi_axes of a component has 1"),
        (lambda: KeplerElements(HIDDEN[:, 0], 0, 0, 0, 0, 0), "a has 1 masked value of 2"),
        (lambda: points(1, 1).integrate(START, 2.0, output=np.ma.array([0.0, 1], mask=[0, 1])), "output has 1 masked"),
        (lambda: fullbody.frames.rotate(HIDDEN, "ecliptic", "equatorial"), "vectors has 1 masked value"),
        (lambda: fullbody.events.PlaneCrossing(normal=HIDDEN[1]), "normal of PlaneCrossing has 1 masked value"),
    ],
)
def test_masked_values_are_refused(call, what):
    refused(rf"(?s)^{what}", call)


def test_arrays_with_empty_masks_are_accepted():
    assert State(np.ma.array(POSITION), VELOCITY) == START
    sizes = [1.0, 2.0] * u.km
    for column in (Table({"a": sizes})["a"], Table({"a": sizes}, masked=True)["a"], Masked(sizes)):
        a = KeplerElements(column, 0, 0, 0, 0, 0).a
        assert type(a) is u.Quantity
        assert (a == sizes).all()


def test_quaternions_not_of_length_one_cause_a_warning():
    attitude = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    (text,) = input_warnings(lambda: State(POSITION, VELOCITY, [[1, 0, 0, 0], 2 * np.array(attitude)]))
    assert text.startswith("attitude of body 1 is [1.414")
    assert "of length 2, and is scaled to 1; expected a unit quaternion [w, x, y, z]" in text
    # Three digits of each component, or single precision.
    for near in (np.round(attitude, 3), np.float32(attitude)):
        assert input_warnings(lambda near=near: State(POSITION, VELOCITY, [near, near])) == []


def test_rotations_of_scipy_are_attitudes():
    rotations = Rotation.from_rotvec([[0.3, -0.2, 0.9], [2.0, 1.0, -0.5]])
    state = State.from_scipy(POSITION, VELOCITY, rotations, spin=[[1, 2, 3]] * 2, time=4.0)
    vector = np.array([1.0, -2.0, 0.5])
    assert np.allclose(state.rotation_matrix @ vector, rotations.apply(vector), rtol=0, atol=1e-15)
    quaternions = rotations.as_quat(scalar_first=True)
    assert np.allclose(state.attitude, quaternions * np.sign(state.attitude[:, :1]), atol=1e-15)
    assert State.from_scipy(POSITION, VELOCITY, [rotations[0], rotations[1]], [[1, 2, 3]] * 2, 4.0) == state
    for wrong in (None, "z", [1, 2], rotations.as_quat()):
        with pytest.raises(InvalidInput, match=r"(?s)^rotation is .*expected a scipy\.spatial\.transform\.Rotation"):
            State.from_scipy(POSITION, VELOCITY, wrong)
    refused("attitude is 1; expected 2", lambda: State.from_scipy(POSITION, VELOCITY, rotations[0]))


def thrown(direction, **options):
    return getattr(fullbody.Particles, direction)(*fullbody.systems.kw4(), "Beta", speed=0.1, **options)


@pytest.mark.parametrize(
    ("call", "what", "degrees"),
    [
        (lambda x: State.from_tait_bryan(POSITION, VELOCITY, [[0] * 3, x]), "angles has values up to", 90),
        (lambda x: KeplerElements(1, 0, 0, np.array([0.1, 1]) * x, 0, 0), "Omega has values up to", 180),
        (lambda x: KeplerElements(1, 0, 0, 0, x, 0), "omega is", 45.5),
        (lambda x: KeplerElements(1, 0, 0, 0, 0, x), "M is", 359.25),
        (lambda x: Component(diameter=1, tilt=x, name="Moon"), "tilt of Moon is", 30),
        (lambda x: Component(diameter=1, rotation_angle=x), "rotation_angle of a component is", 270),
        (lambda x: fullbody.frames.attitude(x, 0.1), "longitude of pole is", 120),
        (lambda x: fullbody.frames.attitude(0.1, 0.1, x), "angle is", 120),
        (lambda x: State(POSITION, VELOCITY).rotated(1, [0, 0, 1], x), "angle is", 10),
        (lambda x: State(POSITION, VELOCITY).rotated(1, [0, 0, 1], -x), "angle is", 10.5),
        (lambda x: thrown("from_surface", longitude=x, latitude=0.0), "longitude is", 270),
        (lambda x: thrown("from_surface", longitude=0.0, latitude=0.0, azimuth=x, elevation=0.5), "azimuth is", 200),
        (lambda x: thrown("ejecta", n=3, longitude=x, latitude=0.0), "longitude is", 270),
    ],
)
def test_angles_that_look_like_degrees_cause_a_warning(call, what, degrees):
    def warnings_of(value):
        return input_warnings(lambda: call(np.array([0, 0, value]) if what.startswith("angles") else value))

    (text,) = warnings_of(degrees)
    assert text.startswith(f"{what} {degrees:g} radians in size, {degrees / (2 * np.pi):.3g} turns; give degrees")
    assert warnings_of(np.radians(degrees)) == []
    if not what.startswith("angles"):
        assert warnings_of(degrees * u.deg) == []


def test_angles_of_many_revolutions_cause_no_warning():
    angles = [[0, 0, 0], [0.01, 0.02, 113.63912345678901]]
    assert input_warnings(lambda: State.from_tait_bryan(POSITION, VELOCITY, angles)) == []
    assert input_warnings(lambda: KeplerElements(1, 0, 0, 0, 0, np.linspace(0.0, 100.0 * np.pi, 50))) == []
    for angle in (-np.pi, 3.0, "10 deg", 4000 * u.deg, np.radians(500.0)):
        assert input_warnings(lambda angle=angle: START.rotated(1, [0, 0, 1], angle)) == []
    # The mean anomaly of a hyperbola is no angle.
    assert input_warnings(lambda: KeplerElements(-1, 1.3, 0, 0, 0, -30)) == []


def test_starts_far_from_bound_cause_a_warning():
    system, escape = points(3.0, 1.0), np.sqrt(2.0 * 4.0 / 5.0)
    limit = 10 * escape
    for times, expected in ((0.99, 0), (1.01, 1), (1000.0, 1)):
        state = State(POSITION, [[0, 0, 0], [0, 0, times * limit]])
        texts = input_warnings(lambda state=state: fullbody.Simulation(system, state))
        assert len(texts) == expected
        for text in texts:
            assert text.startswith(f"body 0 and body 1 start at {times * limit:.4g} relative to each other, ")
            assert f"{10 * times:.3g} times the speed of escape there, {escape:.4g};" in text
    # Without attraction nothing is bound or not.
    assert input_warnings(lambda: fullbody.Simulation(points(3.0, 1.0, G=0.0), State(POSITION, 100 * VELOCITY))) == []


def test_one_of_three_bodies_far_from_bound_causes_a_warning():
    system, state = fullbody.systems.sn263_2001(units=True)
    assert input_warnings(lambda: fullbody.Simulation(system, state)) == []
    wrong = state.velocity.copy()
    wrong[1] *= 3600
    (text,) = input_warnings(lambda: fullbody.Simulation(system, state.replace(velocity=wrong)))
    assert text.startswith(f"{system.names[1]} starts at ")
    assert "km / h relative to the barycentre of the others" in text


def pair_and_sun(distance, mass, separation=2.5):
    """Two points about each other and a third on a circle about all, plain numbers."""
    system = points(0.9, 0.1, mass)
    v = np.sqrt(1.0 / separation)
    position = [[0, 0, 0], [separation, 0, 0], [0, distance, 0]]
    return system, State(position, [[0, -0.1 * v, 0], [0, 0.9 * v, 0], [np.sqrt((1.0 + mass) / distance), 0, 0]])


@pytest.mark.parametrize(("distance", "digits"), [(1.01e3, "1e-12"), (1e5, "1e-10"), (1e8, "1e-07")])
def test_heavy_distant_bodies_cause_a_warning(distance, digits):
    far = 2.5 * distance
    system, state = pair_and_sun(far, 1e-4 * far**3)
    (text,) = input_warnings(lambda: fullbody.Simulation(system, state))
    assert text.startswith(f"body 2 is {far:.4g} from body 0 and body 1, which are 2.5 apart, and so heavy")
    step = 2.0 ** (np.floor(np.log2(far)) - 52)
    assert f"round at {step:.2g}, {step / 2.5:.2g} of their distance" in text
    assert "steps grow ever shorter" in text
    assert f"rtol and atol of {digits} or more" in text
    assert "or body 2 as a fullbody.forces.ThirdBody on a prescribed path" in text
    # A run that follows the advice causes no warning; fixed steps are not adapted, but lose as many digits.
    loose = fullbody.Verner98(float(digits), float(digits))
    assert input_warnings(lambda: fullbody.Simulation(system, state, integrator=loose)) == []
    (text,) = input_warnings(lambda: fullbody.Simulation(system, state, integrator=fullbody.SymplecticSplitting(0.1)))
    assert "Every step loses that much" in text
    assert text.endswith("or body 2 as a fullbody.forces.ThirdBody on a prescribed path, which costs no digits")
    # A nearer or lighter body leaves the barycentre with the pair.
    assert input_warnings(lambda: fullbody.Simulation(*pair_and_sun(0.95e3 * 2.5, 1e18))) == []
    assert input_warnings(lambda: fullbody.Simulation(*pair_and_sun(far, 1e-6 / distance))) == []


def test_the_tolerance_advised_for_a_heavy_distant_body_suffices():
    system, state = pair_and_sun(2.5e6, 1e14)
    (text,) = input_warnings(lambda: fullbody.Simulation(system, state))
    advised = float(text.partition("rtol and atol of ")[2].split()[0])

    def steps(system, state, tolerance):
        with warnings.catch_warnings(action="ignore", category=InconsistentInput):
            integrator = fullbody.Verner98(tolerance, tolerance)
            return system.integrate(state, 50.0, output=[], integrator=integrator).statistics.steps

    alone = points(0.9, 0.1), State(state.position[:2], state.velocity[:2])
    assert steps(system, state, advised) < 2 * steps(*alone, advised)
    assert steps(system, state, advised / 1000) > 4 * steps(*alone, advised / 1000)


def test_binaries_that_are_too_wide_cause_a_warning():
    def make(size, **options):
        primary = Component(diameter=size, density="2 g/cm3", rotation_period="3 h", name="P")
        secondary = Component(diameter=size / 10, density="2 g/cm3", name="S")
        return lambda: fullbody.binary(primary, secondary, semi_major_axis=3 * u.km, units=True, **options)

    assert input_warnings(make(1 * u.km)) == []
    assert input_warnings(make(30.1 * u.m)) == []
    (text,) = input_warnings(make(1 * u.m))
    assert text.startswith("the semi-major axis, 3 km, is 6000 times the longest semi-axis of the primary 'P', 0.0005")
    assert "expected at most 200 times" in text


@pytest.mark.parametrize(
    "shape",
    [Ellipsoid, lambda *axes: Composite([Part(Ellipsoid(*axes), mass=1 * u.kg)])],
    ids=["ellipsoid", "composite"],
)
def test_densities_in_a_wrong_unit_cause_a_warning(shape):
    system, _ = fullbody.systems.didymos(units=True)
    for unit, density in ((u.m, "2.*e.12"), (u.au, "8.*e-22")):
        axes = [0.0885, 0.087, 0.058] * unit
        (text,) = input_warnings(lambda axes=axes: system.with_body("Dimorphos", shape(*axes)))
        assert re.match(f"Dimorphos has a density of {density} kg/m3; expected 100", text)
    for right in (shape(*[0.0885, 0.087, 0.058] * u.km), PointMass()):
        assert input_warnings(lambda right=right: system.with_body("Dimorphos", right)) == []
    # Nothing can be checked in a system without units.
    assert input_warnings(lambda: fullbody.systems.case1()[0].with_body(0, Sphere(1e-3))) == []


def test_warnings_of_systems_with_units_have_units():
    system, state = fullbody.systems.kw4(units=True)
    (text,) = input_warnings(lambda: system.integrate(state.replace(velocity=state.velocity * 3600), 0.001))
    speed = np.linalg.norm(3600 * (state.velocity[1] - state.velocity[0])).to_value("km/h")
    assert text.startswith(f"Alpha and Beta start at {speed:.4g} km / h relative to each other")
    assert System(system.bodies, units=True).integrate(state, 0.001)


def test_numbers_in_a_wrong_unit_cause_a_warning():
    system, state = fullbody.systems.didymos(units=True)
    view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
    geometry = fullbody.observing.Geometry([0.0, 2.0] * u.day, **view)

    def astrometry(east, unit=1.0):
        offset = np.array([east]) * unit
        return fullbody.observing.Astrometry([1] * u.h, offset, 0 * offset, 0.01 * unit, geometry=geometry)

    def light(radius):
        return fullbody.observing.brightness(system, state, view["to_observer"], view["to_sun"], sun_radius=radius)

    def fly(ratio):
        lit, start = fullbody.systems.didymos(units=True, sun=True)
        particles = fullbody.Particles([[9.0, 0, 0]], [[0, 0, 0]], area_to_mass=ratio)
        return lit.fly(start, particles, 0.01, output="ends", radiation=fullbody.particles.Radiation())

    orbit = KeplerElements("1.6442 au", 0.38385, "3.4 deg", "73 deg", "319 deg", "232 deg", frame="ecliptic")

    def sun(mass):
        third = fullbody.forces.ThirdBody(mass=mass, orbit=orbit, of="system", name="Sun")
        return system.with_forces([third]).integrate(state, 0.1, output="ends")

    def yorp(along, **options):
        torque = fullbody.forces.Yorp("Didymos", along=along, **options)
        return system.with_forces([torque]).integrate(state, 0.01, output="ends")

    slow = System([Body(PointMass(), mass=1.0), Body(PointMass(), mass=1.0)], units=("km", "s", "kg"))

    def end(until, start=0.0):
        begin = State([[0.0, 0, 0], [1e6, 0, 0]], np.zeros((2, 3)), time=start)
        return slow.integrate(begin, until, output="ends")

    coefficient = {"normalization": "quillen_2022", "pressure": "4e-6 Pa"}
    date = "which looks like a date, and is taken as a time since time zero"
    for call, wrong, right, message in (
        (lambda options: yorp(1e-3, **options), [{}], [coefficient], "the torque of YORP on Didymos is 3.4e-07 times"),
        (yorp, ["1e4 N m"], ["0.2 N m"], "the torque of YORP on Didymos is 44 times the pressure of sunlight at 1 au"),
        (end, [2460000.5], [2460000.5, 2459999.5], f"until is 2460000.5, {date}: the run is 2460000.5 s long"),
        (end, ["2460000.5 d"], ["2022 d"], f"until is 2460000.5 d, {date}"),
        (end, ["2022.7 yr"], ["20 yr"], f"until is 2022.7 yr, {date}"),
        (astrometry, [0.5], [0.5, u.arcsec], "offsets of Astrometry have values up to 0.5 radians, 28.6 degrees"),
        (light, [0.27], ["0.27 deg"], "sun_radius is 0.27 radians, 15.5 degrees"),
        (fly, [0.01], ["0.01 m2/kg"], "area_to_mass of particles has values up to 1e[+]04 m2 / kg"),
        (sun, ["1.98841e15 kg"], ["1.98841e30 kg"], "the tide of Sun is .* of the bodies' own gravity"),
    ):
        (result,) = input_warnings(lambda call=call, wrong=wrong: call(*wrong))
        assert re.search(message, result), result
        assert not input_warnings(lambda call=call, right=right: call(*right))
