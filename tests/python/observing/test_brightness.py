"""Brightness of bodies: reference data of another program, sums over many points, ray casting, and what is refused."""

import json
import re

import fullbody
import numpy as np
import pytest
from fullbody import Body, Ellipsoid, Sphere, State, System, observing
from fullbody.errors import BodiesOverlap, InvalidInput
from fullbody.observing.laws import Law
from scipy.spatial.transform import Rotation
from support import DATA, body_list, refused
from support.meshes import octahedron


@pytest.fixture
def pair():
    """Two ellipsoids, the second one before the first as seen from +x."""
    bodies = body_list(A=(Ellipsoid(1.0, 0.8, 0.6), 1.0), B=(Ellipsoid(0.5, 0.4, 0.3), 0.1))
    attitude = [[1, 0, 0, 0], [0.7, 0.1, 0.7, 0.1]]
    return System(bodies, G=1.0), State([[0, 0, 0], [3.0, 0.4, 0.2]], np.zeros((2, 3)), attitude)


def test_two_nights_of_a_binary_are_those_of_another_program():
    data = json.loads((DATA / "light_curve.json").read_text())
    axes = np.array(data["axes"])
    system = System([Body(Ellipsoid(*a), mass=mass) for a, mass in zip(axes, data["mass"], strict=True)], G=data["G"])
    state = State(*(data[name] for name in ("position", "velocity", "attitude", "spin")))
    run = system.integrate(state, data["emitted"][-1], output=np.array(data["emitted"]))
    lines = data["to_observer"], data["to_sun"]
    results = np.array([observing.brightness(system, sample, *lines) for sample in run])
    alone = np.array([observing.brightness(system, sample, *lines, mutual=False) for sample in run])
    assert (results < 0.99 * alone).any(axis=0).all(), "each body is hidden now and then"
    light = np.array(data["light"])
    # At six epochs the other program is off, by 3e-11 to 1.5e-5 of the satellite: these were integrated in 22 digits.
    for row in json.loads((DATA / "hidden_light.json").read_text())["rows"]:
        state = State(row["position"], np.zeros((2, 3)), row["attitude"])
        k, expected = row["row"], observing.brightness(system, state, *lines)[1]
        assert abs(expected - row["exact"]) < 1e-14 * alone[k, 1]
        assert abs(light[k, 1] - row["exact"]) > 1e-11 * alone[k, 1]
        light[k, 1] = row["exact"]
    np.testing.assert_allclose(results / alone, light / alone, rtol=0, atol=1e-10)


def hapke(law, mu, mu0, phase, psi):
    """Hapke's law written out from the papers: T mu mu0 / (mu + mu0), for a smooth surface and a rough one."""
    w, b0, h, b = law.single_scattering_albedo, law.opposition_amplitude, law.opposition_width, law.asymmetry
    gamma = np.sqrt(1 - w)
    single = (1 - b * b) / (1 + 2 * b * np.cos(phase) + b * b) ** 1.5
    surge = b0 / (1 + np.tan(phase / 2) / h)

    def smooth(mu, mu0):
        functions = [(1 + 2 * x) / (1 + 2 * gamma * x) for x in (mu, mu0)]
        return w / 4 * mu0 / (mu + mu0) * ((1 + surge) * single + functions[0] * functions[1] - 1)

    if law.roughness == 0:
        return mu * smooth(mu, mu0)
    tan = np.tan(law.roughness)
    e, i = np.arccos(mu), np.arccos(mu0)
    e1 = {"e": np.exp(-2 / np.pi / tan / np.tan(e)), "i": np.exp(-2 / np.pi / tan / np.tan(i))}
    e2 = {"e": np.exp(-1 / np.pi / tan**2 / np.tan(e) ** 2), "i": np.exp(-1 / np.pi / tan**2 / np.tan(i) ** 2)}
    chi = 1 / np.sqrt(1 + np.pi * tan**2)
    eta_e = chi * (mu + np.sin(e) * tan * e2["e"] / (2 - e1["e"]))
    eta_i = chi * (mu0 + np.sin(i) * tan * e2["i"] / (2 - e1["i"]))
    f = np.exp(-2 * np.tan(psi / 2))
    s2, cos = np.sin(psi / 2) ** 2, np.cos(psi)
    near = i <= e
    below = np.where(near, 2 - e1["e"] - psi / np.pi * e1["i"], 2 - e1["i"] - psi / np.pi * e1["e"])
    along = np.where(near, cos * e2["e"] + s2 * e2["i"], e2["i"] - s2 * e2["e"])
    mu0_e = chi * (mu0 + np.sin(i) * tan * along / below)
    mu_e = chi * (mu + np.sin(e) * tan * np.where(near, e2["e"] - s2 * e2["i"], cos * e2["i"] + s2 * e2["e"]) / below)
    ratio = np.where(near, mu0 / eta_i, mu / eta_e)
    shadowing = mu_e / eta_e * mu0 / eta_i * chi / (1 - f + f * chi * ratio)
    return mu * smooth(mu_e, mu0_e) * shadowing


@pytest.mark.parametrize("roughness", [0.0, 0.35])
def test_hapkes_law_is_the_sum_over_many_points(roughness):
    law = observing.Hapke(asymmetry=-0.3, roughness=roughness)
    axes, phase = np.array([1.0, 0.8, 0.6]), 0.7
    system = System([Body(Ellipsoid(*axes), mass=1.0)], G=1.0)
    e, s = np.array([1.0, 0.0, 0.0]), np.array([np.cos(phase), 0.6 * np.sin(phase), 0.8 * np.sin(phase)])
    result = observing.brightness(system, State(np.zeros((1, 3)), np.zeros((1, 3))), e, s, law=law)[0]
    count = 200_000
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    angle = np.pi * (1 + 5**0.5) * np.arange(count)
    u = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)
    normal = u / axes
    size = np.linalg.norm(normal, axis=1)
    mu, mu0 = normal @ e / size, normal @ s / size
    on = (mu > 1e-9) & (mu0 > 1e-9)
    mu, mu0, size = mu[on], mu0[on], size[on]
    psi = np.arccos(np.clip((np.cos(phase) - mu * mu0) / np.sqrt((1 - mu**2) * (1 - mu0**2)), -1, 1))
    expected = np.sum(hapke(law, mu, mu0, phase, psi) * size) * axes.prod() * 4 * np.pi / count
    assert abs(result / expected - 1) < 1e-5


def test_units_names_and_the_derivatives_of_phase_functions(pair):
    system, state = pair
    e, s = np.array([1.0, 0.1, 0.0]), np.array([1.0, 0.5, 0.2])
    law = {"A": observing.Lambert(), "B": observing.LommelSeeliger(phase_function=observing.HG(0.2))}
    albedo = {"A": 0.3, "B": 0.1}
    result = observing.brightness_derivatives(system, state, e, s, law=law, albedo=albedo)
    reference = observing.brightness(system, state, e, s, law=law, albedo=albedo)
    np.testing.assert_allclose(result.brightness, reference, rtol=1e-11)
    np.testing.assert_allclose(result.albedo * [0.3, 0.1], reference, rtol=1e-11)
    h, unit = 1e-5, s / np.linalg.norm(s)
    for k in range(3):
        shift = np.eye(3)[k] - unit * unit[k]
        vectors = unit + h * shift, unit - h * shift
        ends = [observing.brightness(system, state, e, vector, law=law, albedo=albedo) for vector in vectors]
        np.testing.assert_allclose(result.to_sun[:, k], (ends[0] - ends[1]) / (2 * h), atol=1e-8)
    with_units = System([Body(Ellipsoid("1 km", "800 m", "600 m"), mass="1 kg")], units=True)
    single = State(np.zeros((1, 3)), np.zeros((1, 3)))
    area = observing.brightness(with_units, single, e, s)
    assert area.unit == "km2"
    bare = System([Body(Ellipsoid(1.0, 0.8, 0.6), mass=1.0)], G=1.0)
    np.testing.assert_allclose(area.value, observing.brightness(bare, single, e, s), rtol=1e-14)


def test_phase_functions_have_their_published_values():
    assert observing.HG(0.15)(np.array([0.0]))[0] == 1.0
    three = observing.HG1G2(0.3, 0.4)
    np.testing.assert_allclose(three(np.radians([0.0])), 1.0, rtol=1e-9)
    # At a node: G1 0.33486016 + G2 0.62884169, with the third function zero from 30 degrees on.
    np.testing.assert_allclose(three(np.radians([30.0])), 0.3 * 0.33486016 + 0.4 * 0.62884169, rtol=1e-9)
    np.testing.assert_allclose(three(np.radians([7.5 - 1e-9])), three(np.radians([7.5 + 1e-9])), rtol=1e-8)
    # The third function's slopes at its nodes, as Penttilä et al. (2016) print them.
    node, h = np.radians([0.3, 1.0, 2.0, 4.0, 8.0, 12.0, 20.0]), 1e-7
    slope = (observing.HG1G2(0.0, 0.0)(node + h) - observing.HG1G2(0.0, 0.0)(node - h)) / (2 * h)
    published = [-41.180439, -10.366915, -7.5784615, -3.6960950, -0.78605652, -0.46527012, -0.20459545]
    np.testing.assert_allclose(slope, published, rtol=2e-6)


def test_derivatives_of_phase_functions_hold_up_to_180_degrees():
    # The derivatives of HG and of a power of the angle, written out.
    def slope(angle):
        tan, rise = np.tan(angle / 2), 0.5 / np.cos(angle / 2) ** 2
        terms = [(0.85, 3.33, 0.63), (0.15, 1.87, 1.22)]
        return sum(-w * a * b * tan ** (b - 1) * rise * np.exp(-a * tan**b) for w, a, b in terms)

    system = System([Body(Sphere(1.0), mass=1.0)], G=1.0)
    state = State(np.zeros((1, 3)), np.zeros((1, 3)))
    for degrees in (0.01, 1.0, 30.0, 90.0, 150.0, 176.0, 179.0):
        angle = np.radians(degrees)
        e, s = np.array([1.0, 0, 0]), np.array([np.cos(angle), np.sin(angle), 0])
        laws = [observing.Lambert(), observing.Lambert(observing.HG(0.15))]
        bare, result = (observing.brightness_derivatives(system, state, e, s, law=law) for law in laws)
        factor = observing.HG(0.15)(np.array([angle]))[0]
        # The phase angle rises where the Sun's direction turns away from the observer's.
        perpendicular = np.array([-np.sin(angle), np.cos(angle), 0])
        expected = bare.to_sun[0] @ perpendicular * factor + bare.brightness[0] * slope(angle)
        scale = abs(bare.brightness[0] * slope(angle))
        assert abs(result.to_sun[0] @ perpendicular - expected) < 1e-9 * scale


def test_faces_have_albedos_of_their_own():
    shape = octahedron(1.0, 0.8, 0.6)
    system = System([Body(shape, mass=1.0, name="spotted")], G=1.0)
    state = State(np.zeros((1, 3)), np.zeros((1, 3)))
    e, s = [0.3, 0.5, 0.8], [0.9, 0.2, 0.3]
    parts = [observing.brightness(system, state, e, s, albedo=np.eye(8)[k])[0] for k in range(8)]
    assert np.count_nonzero(parts) == 2, "two faces look at both the observer and the Sun"
    albedo = np.linspace(0.1, 0.8, 8)
    for albedos in (albedo, {"spotted": albedo}):
        result = observing.brightness(system, state, e, s, albedo=albedos)[0]
        np.testing.assert_allclose(result, albedo @ parts, rtol=1e-14)
    with pytest.raises(InvalidInput, match="number of values of albedo of spotted is 3; expected one, or 8"):
        observing.brightness(system, state, e, s, albedo=[1.0, 1.0, 1.0])


def test_phase_function_is_any_function_of_the_phase_angle(pair):
    system, state = pair
    e, s = np.array([1.0, 0.1, 0.0]), np.array([1.0, 0.5, 0.2])
    angle = np.arccos(e @ s / np.linalg.norm(e) / np.linalg.norm(s))
    reference = observing.brightness(system, state, e, s)
    for function in (lambda angle: np.exp(-0.7 * angle), lambda angle: [np.exp(-0.7 * x) for x in angle]):
        law = observing.LommelSeeliger(phase_function=function)
        np.testing.assert_allclose(observing.brightness(system, state, e, s, law=law), reference * np.exp(-0.7 * angle))
    law = observing.LommelSeeliger(phase_function=lambda angle: 0.25)
    np.testing.assert_allclose(observing.brightness(system, state, e, s, law=law), 0.25 * reference, rtol=1e-15)
    with pytest.raises(InvalidInput, match=r"returns an array of shape \(3,\); expected \(1,\)"):
        observing.brightness(system, state, e, s, law=observing.Lambert(lambda angle: np.ones(3)))
    refused(r"phase_function of Lambert is 0\.15", lambda: observing.Lambert(phase_function=0.15))


@pytest.mark.parametrize("aside", [0.0, 0.6, 1.4, 1.0])
def test_light_is_finite_where_outlines_are_tangent(aside):
    # Concentric discs, discs that touch from inside and from outside, and a centre on the limb; the Sun along the axes.
    bodies = [Body(Sphere(1.0), mass=1.0), Body(Sphere(0.4), mass=0.1)]
    state = State([[0, 0, 0], [5.0, aside, 0]], np.zeros((2, 3)))
    for sun in ([1, 0, 0], [0, 1, 0], [-1, 0, 0]):
        result = observing.brightness_derivatives(System(bodies, G=1.0), state, [1, 0, 0], sun)
        for name in ("brightness", "position", "rotation", "semi_axes", "to_observer", "to_sun"):
            assert np.isfinite(getattr(result, name)).all(), (sun, name)
        assert ((result.brightness >= 0.0) & (result.brightness < 1.6)).all()


def test_bad_arguments_of_brightness_are_refused_by_name(pair):
    system, state = pair
    good = {"to_observer": [1, 0, 0], "to_sun": [1, 0.2, 0]}

    class Own(Law):
        pass

    for message, arguments in (
        ("to_sun has shape (2,)", {"to_sun": [1, 0]}),
        ("to_observer", {"to_observer": [0, 0, 0]}),
        ("to_observer", {"to_observer": [np.nan, 0, 0]}),
        ("albedo of A is -0.1", {"albedo": -0.1}),
        ("albedo has none for 'B'", {"albedo": {"A": 1.0}}),
        ("law names 'C'", {"law": {"C": observing.Lambert()}}),
        ("law of A is 'lambert'", {"law": "lambert"}),
        ("law of A is <function", {"law": lambda mu, mu0: mu * mu0}),
        ("Own is not one of the scattering laws", {"law": Own()}),
        ("single_scattering_albedo", {"law": observing.Hapke(single_scattering_albedo=1.2)}),
        ("returns nan at the phase angle", {"law": observing.LommelSeeliger(lambda angle: angle * np.nan)}),
        ("mutual", {"mutual": "yes"}),
        ("sun_radius", {"sun_radius": -1.0}),
    ):
        with pytest.raises(fullbody.FullbodyError, match=re.escape(message)):
            observing.brightness(system, state, **{**good, **arguments})
    near = state.replace(position=[[0, 0, 0], [0.3, 0, 0]])
    with pytest.raises(BodiesOverlap, match="A and B"):
        observing.brightness(system, near, **good)
    assert (observing.brightness(system, near, mutual=False, **good) > 0.0).all()


def test_a_point_is_dark_and_hides_nothing():
    bodies = [Body(Sphere(1.0), mass=1.0), Body(fullbody.PointMass(), mass=1.0)]
    state = State([[0, 0, 0], [3, 0, 0]], np.zeros((2, 3)))
    result = observing.brightness(System(bodies, G=1.0), state, [1, 0, 0], [1, 0, 0])
    np.testing.assert_allclose(result, [np.pi / 2, 0.0], rtol=1e-12)


def test_light_near_zero_phase_depends_on_the_orientation_of_the_scene_by_1e_11_at_most():
    # The outlines of an occultation and of its eclipse differ by less than the rule resolves.
    rng = np.random.default_rng(1)
    for _ in range(30):
        axes = [rng.uniform(0.4, 1.0, 3), rng.uniform(0.2, 1.0) * rng.uniform(0.4, 1.0, 3)]
        bodies = [fullbody.Body(fullbody.Ellipsoid(*a), mass=1.0, name=n) for a, n in zip(axes, "AB", strict=True)]
        system = fullbody.System(bodies, G=1.0)
        position = np.array([[0.0, 0.0, 0.0], [rng.uniform(2.1, 4.0), *rng.uniform(-1.0, 1.0, 2)]])
        rotations, side = Rotation.random(2, rng), rng.normal(size=2)
        results = []
        for phase in (0.0, 1e-15, 1e-14, 1e-13, 5e-13, 1e-12):
            for scene in (Rotation.identity(), Rotation.random(None, rng), Rotation.random(None, rng)):
                attitude = (scene * rotations).as_quat(scalar_first=True)
                state = fullbody.State(scene.apply(position), np.zeros((2, 3)), attitude)
                vectors = scene.apply([[1.0, 0.0, 0.0], [1.0, *(phase * side / np.linalg.norm(side))]])
                results.append(observing.brightness(system, state, *vectors))
        unshadowed = observing.brightness(system, state, *vectors, mutual=False)
        assert (np.ptp(results, axis=0) < 3e-11 * unshadowed).all()
