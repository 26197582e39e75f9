"""The rotating frame of a pair: equilibrium points, zero-velocity curves and Roche lobes of the classical problem."""

import copy
import pickle
import warnings

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Body, PointMass, Sphere, fields, plots
from fullbody.errors import InconsistentInput, InvalidInput
from support import matrix, refused


def circling(light, separation=2.0, G=0.7, shape=None, rotation=None, order=1):
    """Two balls on a circle, in any attitude of the orbit; the lighter one has this share of the mass 3."""
    rotation = np.eye(3) if rotation is None else rotation
    shares = np.array([1.0 - light, light])
    rate = np.sqrt(G * 3.0 / separation**3)
    positions = separation * np.array([[-light, 0, 0], [1.0 - light, 0, 0]])
    speeds = rate * np.cross([0, 0, 1.0], positions)
    bodies = [
        Body(shape or Sphere(0.05), mass=3.0 * share, name=name) for share, name in zip(shares, ("A", "B"), strict=True)
    ]
    state = fullbody.State(
        position=(positions @ rotation.T + [5.0, 1.0, -2.0])[::order],
        velocity=(speeds @ rotation.T + [0.1, 0.2, 0.3])[::order],
        spin=[rotation @ [0, 0, rate]] * 2,
    )
    return fields.Synodic(fullbody.System(bodies[::order], G=G), state)


def quintic(light):
    """L1, L2 and L3 from the barycentre, in separations: roots of Euler's quintics (Murray & Dermott 1999, ch. 3)."""
    m = light
    polynomials = (
        # The distance of L1 and L2 from the lighter body, of L3 from the heavier one.
        [1, -(3 - m), 3 - 2 * m, -m, 2 * m, -m],
        [1, 3 - m, 3 - 2 * m, -m, -2 * m, -m],
        [1, 2 + m, 1 + 2 * m, -(1 - m), -2 * (1 - m), -(1 - m)],
    )
    roots = [[r.real for r in np.roots(p) if abs(r.imag) < 1e-9 and r.real > 0] for p in polynomials]
    (first,), (two,), (three,) = roots
    return 1 - m - first, 1 - m + two, -m - three


TURN = matrix(np.array([0.5, 0.1, -0.7, 0.5]))


@pytest.mark.parametrize(("light", "order"), [(0.01, 1), (0.3, -1), (0.5, 1), (1e-4, -1)])
def test_two_balls_have_the_classical_points(light, order):
    pair = circling(light, rotation=TURN, order=order)
    assert pair.rate == pytest.approx(np.sqrt(0.7 * 3.0 / 8.0), rel=1e-14)
    points = {point.name: point for point in pair.equilibria()}
    assert list(points) == ["L1", "L2", "L3", "L4", "L5"]
    for name, x in zip(("L1", "L2", "L3"), quintic(light), strict=True):
        assert points[name].position == pytest.approx([2.0 * x, 0.0, 0.0], abs=1e-11)
        assert not points[name].stable
    for name, sign in (("L4", 1.0), ("L5", -1.0)):
        assert points[name].position == pytest.approx([1.0 - 2.0 * light, sign * np.sqrt(3.0), 0.0], abs=1e-11)
        # lambda^4 + lambda^2 + 27/4 mu (1 - mu) = 0 in units of the rate, and the free motion along z.
        planar = np.roots([1.0, 0.0, 1.0, 0.0, 6.75 * light * (1.0 - light)])
        expected = np.sort_complex(np.concatenate([planar, [1j, -1j]]).round(9))
        assert np.sort_complex((points[name].eigenvalues / pair.rate).round(9)) == pytest.approx(expected, abs=1e-8)
    # Bodies of equal mass have no lighter one; here no two are.
    position, speed = pair.to_inertial(points["L4"].position)
    pull = pair.system.gravity(pair_state(pair), position).field
    centre = pair.to_inertial([0.0, 0.0, 0.0])
    assert pull == pytest.approx(-(pair.rate**2) * (position - centre[0]), rel=1e-12)
    distance = np.linalg.norm(position - centre[0])
    assert np.linalg.norm(speed - centre[1]) == pytest.approx(pair.rate * distance, rel=1e-14)


def pair_state(pair):
    """The bodies of the frame, which are balls, at rest."""
    return fullbody.State(position=pair.to_inertial(pair.position)[0], velocity=np.zeros((2, 3)))


def test_stability_ends_at_rouths_mass():
    """Routh's mass solves 27 mu (1 - mu) = 1."""
    critical = 0.5 * (1.0 - np.sqrt(23.0 / 27.0))
    for light, stable in ((critical - 1e-5, True), (critical + 1e-5, False)):
        points = {point.name: point.stable for point in circling(light).equilibria()}
        assert (points["L4"], points["L5"]) == (stable, stable)


def test_the_rotating_frame_has_units():
    system, state = fullbody.systems.kw4(units=True)
    with pytest.warns(InconsistentInput, match="Alpha rotates in the frame"):
        with_units = fields.Synodic(system, state)
    assert with_units.rate.unit == u.rad / u.hour
    results = {point.name: point for point in with_units.equilibria()}
    assert results["L4"].position.unit == u.km
    assert results["L4"].jacobi.unit == u.km**2 / u.hour**2
    again = with_units.jacobi(results["L4"].position)
    assert again.to_value("m2/s2") == pytest.approx(results["L4"].jacobi.to_value("m2/s2"), rel=1e-14)
    assert with_units.roche_lobe("Beta", rows=12).volume.unit == u.km**3


def test_jacobis_constant_is_conserved():
    pair = circling(0.2, rotation=TURN)
    position, speed = pair.to_inertial([0.4, 1.3, 0.2], [0.1, -0.2, 0.1])
    dust = Body(PointMass(), mass=1e-25, name="dust")
    system = fullbody.System([*pair.system.bodies, dust], G=pair.system.G)
    begin = pair_state(pair)
    centre = pair.to_inertial(pair.position)
    state = fullbody.State(position=[*begin.position, position], velocity=[*centre[1], speed])
    run = system.integrate(state, 3.0, output=1.0)
    expected = pair.jacobi([0.4, 1.3, 0.2], [0.1, -0.2, 0.1])
    for k in range(len(run)):
        now = fields.Synodic(pair.system, fullbody.State(position=run.position[k, :2], velocity=run.velocity[k, :2]))
        origin = now.to_inertial([0.0, 0.0, 0.0])[0]
        axes = now.to_inertial(np.eye(3))[0] - origin
        x = axes @ (run.position[k, 2] - origin)
        v = axes @ (run.velocity[k, 2] - now.to_inertial(x)[1])
        assert now.jacobi(x, v) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(("q", "name"), [(0.05, "B"), (4.0, "A")])
def test_roche_lobes_have_eggletons_volume(q, name):
    """Eggleton's formula (1983, ApJ 268, 368) is good to one part in a hundred."""
    pair = circling(min(q, 1.0) / (1.0 + q), separation=1.0, shape=PointMass())
    lobe = pair.roche_lobe(name, rows=60)
    eggleton = 0.49 * q ** (2 / 3) / (0.6 * q ** (2 / 3) + np.log(1.0 + q ** (1 / 3)))
    assert lobe.radius == pytest.approx(eggleton, rel=0.01)
    levels = pair.jacobi(lobe.points[1:])
    assert levels == pytest.approx(np.full(levels.shape, lobe.jacobi), rel=1e-9)


def test_the_volume_of_a_roche_lobe_has_the_documented_error():
    """The error goes with 1/rows^2: two meshes give the volume itself."""
    pair = circling(0.2, separation=1.0, shape=PointMass())
    volumes = [pair.roche_lobe("B", rows=rows).volume for rows in (30, 60)]
    extrapolated = (4.0 * volumes[1] - volumes[0]) / 3.0
    assert (1.0 - volumes[1] / extrapolated) * 60**2 == pytest.approx(3.7, rel=0.1)


def test_zero_velocity_curves_close_above_the_level_of_L1():
    light, pair = 0.2, circling(0.2, separation=1.0, G=1.0 / 3.0, shape=PointMass())
    levels = {point.name: point.jacobi for point in pair.equilibria()}
    for level, pieces in ((levels["L1"] * 1.02, 3), (0.5 * (levels["L1"] + levels["L2"]), 2)):
        curves = pair.zero_velocity(level, extent=2.5)
        assert len(curves) == pieces
        for curve in curves:
            x, y = curve.T
            potential = (1.0 - light) / np.hypot(x + light, y) + light / np.hypot(x - 1.0 + light, y)
            assert 2.0 * potential + x * x + y * y == pytest.approx(np.full(len(curve), level), rel=2e-3)


def test_systems_without_a_circling_pair_are_refused():
    system, state = fullbody.systems.kw4()
    with pytest.raises(InvalidInput, match="system has 1 bodies; expected 2"):
        fields.Synodic(fullbody.System([Body(Sphere(1.0), mass=1.0)], G=1.0), state)
    refused("move along a line", lambda: fields.Synodic(system, state.replace(velocity=np.zeros((2, 3)))))
    with pytest.warns(InconsistentInput, match="not on a circular orbit .* Alpha rotates in the frame"):
        fields.Synodic(system, state.replace(velocity=1.2 * state.velocity))


def test_bad_arguments_of_the_rotating_frame_are_refused():
    pair = circling(0.3)
    refused("n is 1; expected a whole number, 2 or more", lambda: pair.plane(n=1))
    refused("extent is -1.0; expected a finite number above zero", lambda: pair.plane(-1.0))
    for velocity in ([np.nan, 0.0, 0.0], [1.0, 0.0]):
        for method in (pair.jacobi, pair.to_inertial):
            refused("velocity .*; expected .*finite numbers", method, [3.0, 0.0, 0.0], velocity)
    refused("points is .*; expected finite numbers", pair.to_inertial, [np.inf, 0.0, 0.0])


def test_the_warning_names_the_deviations_above_rounding():
    """At the end of an ellipse v^2 = G M (1 + e)/r, so that the pull is 1/(1 + e) of v^2/r."""
    bodies = [Body(fullbody.PointMass(), mass=mass, name=name) for mass, name in ((0.99, "A"), (0.01, "B"))]
    system, shares = fullbody.System(bodies, G=1.0), np.array([[-0.01], [0.99]])

    def deviations(position, velocity):
        with pytest.warns(InconsistentInput, match="^the bodies are not on a circular orbit") as caught:
            fields.Synodic(system, fullbody.State(shares * position, shares * velocity))
        return str(caught[0].message).partition("(")[2].partition(")")[0]

    e = 0.25
    axes = [np.array([np.cos(0.7), np.sin(0.7), 0.0]), np.array([-np.sin(0.7), np.cos(0.7), 0.0])]
    pull = deviations(axes[0], np.sqrt(1.0 + e) * axes[1])
    assert pull == f"their gravity differs by {1.0 - 1.0 / (1.0 + e):.2g} from the force that keeps them at rest in it"
    both = deviations(axes[0], np.sqrt(1.0 + e) * (axes[1] + axes[0]))
    assert both == f"{pull}, and they approach or recede at {np.sqrt(0.5):.2g} of their speed"
    assert deviations(axes[0], axes[1] + axes[0]) == both.partition(", and ")[2]


def test_pictures_of_the_rotating_frame_have_labels_and_units():
    system, state = fullbody.systems.kw4(units=True)
    field = fields.surface(system, state, "Beta", rows=8)
    ax = plots.surface_map(field)
    assert (ax.get_xlabel(), ax.get_title()) == ("longitude [deg]", "Beta")
    shown = ax.collections[0].get_array()
    assert np.asarray(shown[:128]) == pytest.approx(np.degrees(field.slope.value))
    corners = np.concatenate([path.vertices for path in ax.collections[0].get_paths()])
    assert np.abs(corners[:, 1]).max() == pytest.approx(90.0)
    assert ax.child_axes[0].get_ylabel() == "slope [deg]"
    scene = plots.surface_scene(field, "geopotential")
    assert scene.figure.axes[1].get_ylabel() == "geopotential [m² s⁻²]"
    refused("quantity is 'colour'; expected 'slope', 'geopotential'", lambda: plots.surface_map(field, "colour"))
    pair = circling(0.1)
    ax = plots.zero_velocity(pair)
    assert {text.get_text() for text in ax.texts} == {"L1", "L2", "L3", "L4", "L5"}
    assert len(plots.roche_lobes(pair, rows=8).collections) == 4


def test_a_rotating_frame_can_be_copied_and_pickled():
    system, state = fullbody.systems.kw4(units=True)
    with pytest.warns(InconsistentInput, match="rotating frame"):
        frame = fullbody.fields.Synodic(system, state)
    point = [0.5, 2.0, 0.1]
    for make in (copy.copy, copy.deepcopy, lambda frame: pickle.loads(pickle.dumps(frame))):
        with warnings.catch_warnings(action="error"):
            other = make(frame)
        assert repr(other) == repr(frame)
        assert (other.jacobi(point), other.rate) == (frame.jacobi(point), frame.rate)
        np.testing.assert_array_equal(other.position, frame.position)
