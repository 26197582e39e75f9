"""Composites: bodies of several parts, against sums over ordinary bodies and closed forms."""

from itertools import permutations, product

import fullbody
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Sphere
from fullbody.errors import InconsistentInput, InvalidInput
from support import inertia, matrix, meshes, quaternion_product, refused
from support.meshes import close

AXES = (1.0, 0.8, 0.5)
PROBE = Body(Ellipsoid(0.7, 0.5, 0.3), mass=0.4, name="probe")


def quaternion(seed=0):
    q = np.random.default_rng(seed).normal(size=4)
    return q / np.linalg.norm(q)


def lump(seed=0):
    """Overlapping lobes with a boulder, a void and a mass point, none of them in a special place."""
    return [
        Part(Ellipsoid(*AXES), density=2.0, position=(0.3, 0.1, -0.2), attitude=quaternion(seed)),
        Part(Ellipsoid(0.6, 0.5, 0.4), mass=1.7, position=(-0.9, 0.4, 0.1), attitude=quaternion(seed + 1)),
        Part(Sphere(0.1), density=-2.0, position=(0.4, 0.0, -0.3)),
        Part(Sphere(0.2), mass=0.1, position=(0.2, 1.0, 0.5)),
        Part(PointMass(), mass=0.2, position=(0.2, -0.3, 0.1)),
    ]


def pose(distance):
    return meshes.pose(distance * np.array([0.48, -0.6, 0.64]), spin=1.0)


METHODS = ("focal", "surface", "multipole:8")


@pytest.mark.parametrize("gravity", METHODS)
def test_coincident_parts_of_half_the_density_are_one_body(gravity):
    complete = Body(Ellipsoid(*AXES), density=3.0, name="A")
    halves = Body(Composite([Part(Ellipsoid(*AXES), density=1.5)] * 2), name="A")
    close(halves.inertia, complete.inertia, 1e-15)
    for distance in (2.1, 9.0, 1e4):
        pairs = (fullbody.System([body, PROBE], G=1.3, gravity=gravity) for body in (halves, complete))
        f, g = (pair.interactions(pose(distance)) for pair in pairs)
        close(f.force, g.force, 1e-14)
        close(f.torque, g.torque, 1e-14, scale=np.abs(g.force).max())
        close(f.potential_energy, g.potential_energy, 1e-14)


def test_confocal_layers_of_equal_mass_have_equal_fields():
    # Maclaurin's theorem.
    thin, thick = 0.3, 0.9
    shapes = [[Ellipsoid(*np.sqrt(np.square(AXES) + k)) for k in ks] for ks in ((0.0, thin), (thin, thick))]
    layers = [
        Composite(
            [Part(outer, mass=4.0 * np.prod(outer.semi_axes)), Part(inner, mass=-4.0 * np.prod(inner.semi_axes))]
        ).with_mass(1.0)
        for inner, outer in shapes
    ]
    ball = Body(Sphere(0.4), mass=0.7, name="ball")
    state = pose(3.0)
    inner, outer = (fullbody.System([Body(layer, name="A"), ball], G=1.0).interactions(state) for layer in layers)
    # The layers are 3 and 4 times lighter than what they are the differences of.
    close(inner.force, outer.force, 1e-14)
    close(inner.torque, outer.torque, 1e-13)
    assert np.abs(inner.torque).max() > 0.01 * np.abs(inner.force).max()


def test_a_homothetic_shell_has_no_field_inside():
    # Newton, Principia I, Prop. 91, Cor. 3.
    rng = np.random.default_rng(0)
    shell = Body(Composite.layers(Ellipsoid(*AXES), fractions=(1.0, 0.6), densities=(3.0, 0.0)))
    inside = shell.gravity(rng.uniform(-1, 1, (50, 3)) * 0.6 / np.sqrt(3.0) * AXES, G=1.0)
    outer, inner = (Body(Ellipsoid(*(np.array(AXES) * f)), density=3.0) for f in (1.0, 0.6))
    surface = np.linalg.norm(outer.gravity([AXES[0], 0.0, 0.0], G=1.0).field)
    assert max(np.abs(inside.field).max(), np.abs(inside.gradient).max()) < 1e-15 * surface
    assert np.ptp(inside.potential) < 1e-14
    beyond = rng.normal(size=(50, 3)) * 3.0
    beyond = beyond[np.square(beyond / AXES).sum(axis=1) > 1.0]
    for what in ("potential", "field", "gradient"):
        result, complete, core = (getattr(body.gravity(beyond, G=1.0), what) for body in (shell, outer, inner))
        close(result, complete - core, 1e-14)
    close(shell.inertia, inertia(outer.mass, AXES) * (1.0 - 0.6**5), 1e-14)


def test_parts_that_nearly_cancel_cause_a_warning():
    shells = {
        thin: Body(Composite.layers(Sphere(1.0), fractions=(1.0, 1.0 - thin), densities=(3.0, 0.0)), name="shell")
        for thin in (0.3, 1e-9)
    }
    fullbody.System([shells[0.3], PROBE], G=1.0)
    message = r"parts 0 and 1 of shell, of 12\.5664 and -12\.5664 in mass, nearly cancel: .* by 1e-07 of their size"
    with pytest.warns(InconsistentInput, match=message):
        system = fullbody.System([shells[1e-9], PROBE], G=1.0)
    result = system.interactions(pose(2.5))
    exact = fullbody.System([Body(Sphere(1.0), mass=shells[1e-9].mass, name="shell"), PROBE], G=1.0)
    error = np.abs(result.force / exact.interactions(pose(2.5)).force - 1.0).max()
    assert error < 1e-7
    # Who asks for no more is not told.
    fullbody.System([shells[1e-9], PROBE], G=1.0, gravity_tolerance=1e-8)


def test_principal_frames_of_composites_are_numpys_sums():
    parts = lump()
    body = Body(Composite(parts))
    volumes = [4.0 / 3.0 * np.pi * np.prod(p.shape.semi_axes) if p.density is not None else 1.0 for p in parts]
    masses = np.array([(p.mass or p.density) * v for p, v in zip(parts, volumes, strict=True)])
    centres = np.array([p.position for p in parts])
    assert body.mass == pytest.approx(masses.sum(), rel=1e-15)
    centre = masses @ centres / masses.sum()
    tensor = np.zeros((3, 3))
    for part, mass, point in zip(parts, masses, centres - centre, strict=True):
        rotation, axes = matrix(part.attitude), part.shape.semi_axes or (0.0, 0.0, 0.0)
        tensor += rotation @ np.diag(inertia(mass, axes)) @ rotation.T
        tensor += mass * (point @ point * np.eye(3) - np.outer(point, point))
    rotated = matrix(body.working_frame.attitude)
    close(rotated @ tensor @ rotated.T, np.diag(body.inertia), 1e-14)
    close(rotated @ centre + body.working_frame.position, np.zeros(3), 1e-15, scale=1.0)
    # No other naming and directing of the axes, a signed permutation, is nearer to the working frame.
    remaining = [
        s @ np.eye(3)[list(o)] for o in permutations(range(3)) for s in map(np.diag, product((1, -1), repeat=3))
    ]
    assert np.trace(rotated) >= max(np.trace(s @ rotated) for s in remaining if np.linalg.det(s) > 0.0) - 1e-14


def test_a_degenerate_principal_frame_is_next_to_the_working_frame():
    def attitude(parts):
        return Body(Composite(parts)).working_frame.attitude

    unturned = np.array([1.0, 0.0, 0.0, 0.0])
    # All moments equal: parts on a cube's corners, turned.
    q = quaternion()
    corners = [matrix(q) @ np.array([x, y, z]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    close(attitude([Part(Sphere(0.5), mass=1.0, position=c) for c in corners]), unturned, 0.0)
    # Two equal, about an axis that the working frame has: nothing is turned; the shift leaves it so.
    for axis in np.eye(3):
        ends = [Part(Sphere(0.5), mass=m, position=3.0 * axis * m + (5.0, 6.0, 7.0)) for m in (1.0, 2.0)]
        close(attitude(ends), unturned, 0.0)
    # About another axis: the shortest turn from there to the nearest axis of the working frame.
    axis = np.array([0.36, -0.48, 0.8])
    ends = [Part(Sphere(0.5), mass=1.0, position=s * axis) for s in (-1, 1)]
    shortest = np.array([1.0 + axis[2], *np.cross(axis, [0.0, 0.0, 1.0])])
    close(attitude(ends), shortest / np.linalg.norm(shortest), 1e-15)
    across = np.array([0.8, 0.6, 0.0])
    ring = [s * v for v in (across, np.cross(axis, across)) for s in (-1, 1)]
    around = attitude([Part(Sphere(0.5), mass=1.0, position=point) for point in ring])
    close(around, shortest / np.linalg.norm(shortest), 1e-15)
    # Different ones along the working frame's axes: whichever is the largest.
    for axes in ((1, 2, 3), (3, 2, 1), (2, 3, 1)):
        close(attitude([Part(Ellipsoid(*axes), mass=1.0)]), unturned, 0.0)


def direct(parts, state, gravity):
    """Force on both bodies, torques in their frames and energy, from pairs of ordinary bodies and lever arms."""
    frame = Body(Composite(parts)).working_frame
    into = matrix(frame.attitude)
    (first, second), (p, q) = state.position, state.attitude
    total, torques, energy = np.zeros(3), np.zeros((2, 3)), 0.0
    for part in parts:
        mass = part.mass if part.mass is not None else part.density * 4.0 / 3.0 * np.pi * np.prod(part.shape.semi_axes)
        # Gravity is linear in the mass.
        body = Body(part.shape, mass=abs(mass), name="part")
        point = into @ np.array(part.position) + frame.position
        part_attitude = quaternion_product(p, quaternion_product(frame.attitude, part.attitude))
        part_state = fullbody.State([first + matrix(p) @ point, second], np.zeros((2, 3)), attitude=[part_attitude, q])
        f = fullbody.System([body, PROBE], G=1.3, gravity=gravity).interactions(part_state)
        sign = np.sign(mass)
        total += sign * f.force[0]
        torques[0] += sign * (into @ matrix(part.attitude) @ f.torque[0] + np.cross(point, matrix(p).T @ f.force[0]))
        torques[1] += sign * f.torque[1]
        energy += sign * f.potential_energy
    return total, torques, energy


@pytest.mark.parametrize("distance", [2.9, 12.0, 1e5])
@pytest.mark.parametrize("gravity", METHODS)
def test_interactions_are_the_sum_over_parts(gravity, distance):
    parts, state = lump(), pose(distance)
    f = fullbody.System([Body(Composite(parts)), PROBE], G=1.3, gravity=gravity).interactions(state)
    force, torques, energy = direct(parts, state, gravity)
    # Far away the torque is a difference: levers times forces that are all but parallel.
    close(f.force, np.array([force, -force]), 1e-14)
    close(f.torque, torques, 2e-14, scale=np.linalg.norm(force))
    close(f.potential_energy, energy, 1e-14)


def test_the_quadratures_name_parts_and_method():
    bodies = [Body(Composite(lump()), name="A"), PROBE, Body(Ellipsoid(0.2, 0.2, 0.1), mass=0.1, name="C")]
    position = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 5.0, 0.0]]
    for gravity in ("focal", "multipole:4"):
        system = fullbody.System(bodies, G=1.0, gravity=gravity)
        rows = fullbody.Simulation(system, fullbody.State(position, np.zeros((3, 3)))).quadrature
        expected = [(("A", other), (part, 0)) for other in ("probe", "C") for part in range(5)]
        assert [(row["pair"], row["parts"]) for row in rows] == [*expected, (("probe", "C"), None)]
        assert {row["method"] for row in rows} == {gravity}
        for row in rows:
            if gravity == "focal":
                assert row["integrated"] in row["pair"]
                assert row["points"] >= 1
            else:
                assert (row["integrated"], row["points"], row["order"]) == (None, None, None)


@pytest.mark.parametrize(
    "integrator",
    [
        fullbody.Verner98(1e-13, 1e-13),
        fullbody.DormandPrince54(1e-12, 1e-12),
        fullbody.SymplecticSplitting(0.01, "ABA864"),
        fullbody.LieGroupVariational(0.002),
    ],
    ids=lambda i: type(i).__name__,
)
def test_composites_keep_energy_and_momenta(integrator):
    second = [Part(Ellipsoid(0.5, 0.4, 0.3), mass=0.5), Part(Sphere(0.3), mass=0.2, position=(0.7, 0.1, 0.0))]
    system = fullbody.System([Body(Composite(lump()), name="A"), Body(Composite(second), name="B")], G=1.0)
    state = fullbody.State(
        [[0, 0, 0], [3.5, 0, 0.3]], [[0, 0, 0], [0, 1.3, 0.2]], pose(1.0).attitude, [[0.2, 0.1, 0.9]] * 2
    )
    run = system.integrate(state, 3.0, integrator=integrator)
    energy, momentum = np.abs(run.energy_drift).max(), np.abs(run.angular_momentum_drift).max()
    limit = 1e-12 if "Verner" in str(integrator) or "Dormand" in str(integrator) else 1e-5
    assert energy < limit, energy
    # Fixed steps conserve it to round-off, since kicks and drifts do.
    assert momentum < 1e-12, momentum
    # The motion does matter: the bodies turn by more than a radian, and their spins change.
    assert np.abs(np.diff(run.spin[[0, -1]], axis=0)).max() > 0.01


def test_the_point_method_takes_a_composite_as_a_point():
    state = pose(7.0)
    points = fullbody.System([Body(Composite(lump()), name="A"), PROBE], G=1.0, gravity="point").interactions(state)
    r = state.position[1]
    force = Body(Composite(lump())).mass * PROBE.mass / np.linalg.norm(r) ** 3 * r
    close(points.force, np.array([force, -force]), 1e-15)
    assert not points.torque.any()


def test_many_parts_are_not_printed_one_by_one():
    rng = np.random.default_rng(3)
    points = [Part(fullbody.PointMass(), mass=1.0, position=point) for point in rng.normal(size=(3000, 3))]
    body = fullbody.Body(Composite(points))
    for text in (repr(body), body._repr_html_()):
        assert "2980 more" in text
        assert len(text) < 20_000


def test_parts_by_their_gm_are_parts_by_their_mass():
    locations = ([0.0, 0.0, 0.0], [1.5, 0.2, 0.0])
    moon = Body(Sphere(0.1), mass=0.01, name="moon")

    def system(**options):
        parts = [Part(Sphere(0.5), position=point, **options) for point in locations]
        return fullbody.System([Body(Composite(parts), name="pair"), moon], G=2.0)

    result, expected = system(GM=3.0), system(mass=1.5)
    assert result.masses.tolist() == expected.masses.tolist() == [3.0, 0.01]
    assert result.bodies[0] == expected.bodies[0]
    with_units = Composite(
        [Part(Sphere("0.5 km"), GM="1 km3/h2", position=[x, "0 km", "0 km"]) for x in ("0 km", "1 km")]
    )
    G = fullbody.System([moon], units=("km", "h", "kg")).G
    assert Body(with_units).mass.to_value("kg") == pytest.approx(2.0 / G.to_value("km3 / (kg h2)"), rel=1e-14)
    alone = Part(Sphere(0.5), GM=3.0)
    with pytest.raises(InvalidInput, match=r"part 0 of .* follows from its GM and the G of a system"):
        Body(Composite([alone, alone]), name="pair").inertia  # noqa: B018
    refused("both a mass and a GM", lambda: Part(Sphere(0.5), mass=1.0, GM=3.0))
    bodies = expected.with_body("moon", Sphere(0.1), GM=0.5)
    assert bodies.masses[1] == 0.25
    with pytest.raises(InvalidInput, match=r"GM of pair is 1\.0; expected a mass beside a composite"):
        expected.with_body("pair", Composite([Part(Sphere(0.5), mass=1.0)]), GM=1.0)
