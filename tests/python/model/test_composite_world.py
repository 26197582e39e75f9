"""Composites in the rest of the package: third bodies, contact, bad input, files, pictures."""

import astropy.units as u
import fullbody
import mpmath as mp
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Sphere
from fullbody.errors import BodiesOverlap, ForceFailed, InvalidInput
from support import data_of, matrix, refused
from support.meshes import close
from support.scenes import at_rest
from support.toml_texts import read

#: Balls on two axes whose centre of mass and principal axes are exactly those of the working frame.
PLACES = {(3.0, 0.0, 0.0): 1.0, (-1.0, 0.0, 0.0): 3.0, (0.0, 2.0, 0.0): 0.5, (0.0, -2.0, 0.0): 0.5}
CROSS = [Part(Sphere(0.5), mass=m, position=point) for point, m in PLACES.items()]
ATTITUDE = np.array([0.5, 0.1, -0.7, 0.5])
DIRECTION = np.array([0.48, -0.6, 0.64])


def load(body, point):
    """The load of a mass point that stays where it is on one body at rest."""
    system = fullbody.System([body], G=1.0, forces=[at_rest(point, 2.0)])
    return system.loads(fullbody.State([[0, 0, 0]], [[0, 0, 0]], attitude=[ATTITUDE]))["Sun"]


@pytest.mark.parametrize("distance", [4.0, 30.0, 1e4, 1e8, 1e12])
def test_third_bodies_act_on_composites_as_fifty_digits_say(distance):
    result = load(Body(Composite(CROSS), name="A"), distance * DIRECTION)
    frame = matrix(ATTITUDE / np.linalg.norm(ATTITUDE))
    with mp.workdps(50):
        exact = np.vectorize(mp.mpf, otypes=[object])
        point = exact(frame).T @ exact(distance * DIRECTION)
        lines = {p: point - exact(p) for p in [(0.0, 0.0, 0.0), *PLACES]}
        pulls = {p: 2 * line / mp.sqrt(line @ line) ** 3 for p, line in lines.items()}
        force = sum(m * (pulls[p] - pulls[0.0, 0.0, 0.0]) for p, m in PLACES.items())
        torque = sum(m * np.cross(exact(p), pulls[p]) for p, m in PLACES.items())
    for values, expected in ((result.torque[0], torque), (frame.T @ result.force[0], force)):
        close(values, expected.astype(float), 1e-14)


@pytest.mark.parametrize("distance", [2.0, 1e3, 1e9])
def test_third_bodies_act_on_split_ellipsoids_as_on_undivided_ones(distance):
    shape = Ellipsoid(1.0, 0.8, 0.5)
    halves = Composite([Part(shape, mass=m, position=(5.0, 6.0, 7.0)) for m in (0.7, 0.3)])
    result, expected = (load(body, distance * DIRECTION) for body in (Body(halves, name="A"), Body(shape, mass=1.0)))
    close(result.torque, expected.torque, 1e-13)
    close(result.force, expected.force, 1e-13)


def test_a_third_body_inside_a_part_is_refused():
    for parts, point in ((CROSS, (0.0, 2.0, 0.0)), ([Part(Ellipsoid(3, 2, 1), mass=1.0)], (2.0, 0.0, 0.0))):
        with pytest.raises((ForceFailed, InvalidInput), match="Sun"):
            load(Body(Composite(parts), name="A"), matrix(ATTITUDE / np.linalg.norm(ATTITUDE)) @ np.array(point))


def fly(parts, probe, position, velocity, spin=(0, 0, 0), until=20.0, integrator=None, **options):
    """A composite at the origin and a ball of this radius, without gravity."""
    system = fullbody.System([Body(Composite(parts), name="A"), Body(Sphere(probe), mass=1e-6, name="ball")], G=0.0)
    state = fullbody.State([[0, 0, 0], position], [[0, 0, 0], velocity], spin=[spin, (0, 0, 0)])
    return system.integrate(state, until, integrator=integrator or fullbody.Verner98(1e-11, 1e-11), **options)


def dumbbell(radius=1.0, arm=3.0, **kwargs):
    return [Part(Sphere(radius), mass=1.0, position=(s * arm, 0.0, 0.0), **kwargs) for s in (-1, 1)]


FIXED = [fullbody.SymplecticSplitting(1.7, "ABA864"), fullbody.LieGroupVariational(0.3)]


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
@pytest.mark.parametrize("integrator", [None, *FIXED], ids=str)
def test_balls_on_straight_lines_touch_when_a_quadratic_says(integrator):
    start, velocity = np.array([2.8, -10.0, 0.3]), np.array([0.1, 1.0, 0.02])
    with pytest.raises(BodiesOverlap) as caught:
        fly(dumbbell(), 0.5, start, velocity, integrator=integrator)
    # |start + velocity t - arm| = 1.5.
    d = start - (3.0, 0.0, 0.0)
    a, b, c = velocity @ velocity, d @ velocity, d @ d - 1.5**2
    assert caught.value.time == pytest.approx((-b - np.sqrt(b * b - a * c)) / a, rel=1e-10)


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
@pytest.mark.parametrize("terminal", [False, True])
@pytest.mark.parametrize("at", [3.2, 4.5 - 1e-6, 4.5 + 1e-6])
def test_a_swinging_arm_hits_a_ball_when_it_should(terminal, at):
    rate = 0.8
    # 3^2 + at^2 - 6 at sin(angle) = 1.5^2
    expected = np.arcsin(min(1.0, (9.0 + at**2 - 1.5**2) / (6.0 * at))) / rate
    watched = [fullbody.events.Contact("A", "ball", terminal=terminal)]
    swing = dumbbell(), 0.5, (0.0, at, 0.0), (0, 0, 0), (0, 0, rate)
    if at > 4.5:
        assert fly(*swing, events=watched).time[-1] == 20.0
        return
    if terminal:
        run = fly(*swing, events=watched)
        assert [event.time for event in run.events] == [run.time[-1]]
        result = run.time[-1]
    else:
        with pytest.raises(BodiesOverlap) as caught:
            fly(*swing)
        result = caught.value.time
    # Grazing, 1e-12 in the distance is 1e-9 in the time.
    assert result == pytest.approx(expected, rel=1e-11 if at < 4.0 else 1e-8)


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_no_contact_of_an_arm_is_too_short_to_be_seen():
    rng = np.random.default_rng(1)
    for _ in range(120):
        radius, (arm, rate, step) = 10 ** rng.uniform(-2.5, -0.5), rng.uniform([1, 0.3, 1], [4, 3, 6])
        meeting, miss = rng.uniform(0.2, step), rng.uniform(-1, 1) * 1.99 * radius
        velocity = rng.normal(size=3) * rng.choice([0.0, 0.3])
        end = np.array([np.cos(rate * meeting), np.sin(rate * meeting), 0.0])
        point = (arm + miss) * end - velocity * meeting

        def gap(times, point=point, velocity=velocity, arm=arm, rate=rate, radius=radius):
            """The distance to the nearest of the three balls."""
            ball = point + np.multiply.outer(times, velocity)
            tip = arm * np.stack([np.cos(rate * times), np.sin(rate * times), 0 * times], axis=-1)
            to_tips = [np.linalg.norm(ball - sign * tip, axis=-1) - 2 * radius for sign in (-1, 1)]
            return np.min([*to_tips, np.linalg.norm(ball, axis=-1) - 0.3 - radius], axis=0)

        if gap(np.array(0.0)) < 0.0:
            continue
        parts = [*dumbbell(radius, arm), Part(Sphere(0.3), mass=0.2)]
        integrator = fullbody.SymplecticSplitting(step / 1.001, "leapfrog")
        with pytest.raises(BodiesOverlap) as caught:
            fly(parts, radius, point, velocity, (0, 0, rate), until=step, integrator=integrator)
        result = caught.value.time
        assert abs(gap(np.array(result))) < 1e-11
        assert gap(np.linspace(0.0, result, 2000)[:-1]).min() > 0.0


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_a_ball_flies_between_two_others_without_contact():
    run = fly(dumbbell(), 0.5, (0.0, -10.0, 0.1), (0.0, 1.0, 0.0))
    assert run.time[-1] == 20.0
    # The gap is 4 wide.
    run = fly(dumbbell(), 1.999, (0.0, -10.0, 0.0), (0.0, 1.0, 0.0))
    assert run.time[-1] == 20.0
    with pytest.raises(BodiesOverlap):
        fly(dumbbell(), 2.001, (0.0, -10.0, 0.0), (0.0, 1.0, 0.0))


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_only_surfaces_outside_of_other_parts_touch():
    hull = Part(Ellipsoid(2.0, 1.5, 1.0), mass=5.0)
    void, stub = (Part(Sphere(0.4), mass=-0.1, position=p) for p in ((0.5, 0.2, 0.0), (-2.0, 0.0, 0.0)))
    for more, expected in (([], 7.5), ([void], 7.5), ([Part(PointMass(), mass=0.5)], 7.5), ([stub], 7.1)):
        frame = Body(Composite([hull, *more])).working_frame
        x = matrix(frame.attitude)[:, 0]
        with pytest.raises(BodiesOverlap) as caught:
            fly([hull, *more], 0.5, frame.position - 10.0 * x, x)
        assert caught.value.time == pytest.approx(expected, rel=1e-10)


def test_overlap_at_the_start_is_refused():
    bodies = [Body(Composite(dumbbell()), name="A"), Body(Composite(dumbbell()), name="B")]
    system = fullbody.System(bodies, G=1.0)
    # Crossed, one within the other's circumscribed sphere: apart; with an arm in the other's ball: not.
    quarter = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
    fine = fullbody.State([[0, 0, 0], [0, 0, 0.5]], np.zeros((2, 3)), attitude=[(1, 0, 0, 0), quarter])
    system.interactions(fine)
    with pytest.raises(BodiesOverlap, match="A and B overlap"):
        system.interactions(fine.replace(position=[[0, 0, 0], [3.0, -2.0, 0.5]]))


BALL = Part(Sphere(1.0), mass=1.0)
ROD = [Part(PointMass(), mass=1.0, position=(x, 0, 0)) for x in (0, 1)]
HOLLOW = [Part(Ellipsoid(2, 2, 0.1), mass=2.0), Part(Ellipsoid(0.1, 0.1, 3), mass=-1.0)]


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: Composite([]), "parts is empty"),
        (lambda: Composite(BALL), "parts is Part.*expected a sequence of Part"),
        (lambda: Composite([Sphere(1.0)]), "parts has Sphere.*expected a sequence of Part"),
        (lambda: Part(Composite([BALL]), mass=1.0), "shape of a part is Composite"),
        (lambda: Part(Sphere(1.0)), "a part is given neither mass nor density"),
        (lambda: Part(Sphere(1.0), mass=1.0, density=1.0), "a part is given both"),
        (lambda: Part(PointMass(), density=1.0), "a point has no volume"),
        (lambda: Part(Sphere(1.0), mass=1.0, attitude=(0, 0, 0, 0)), "attitude of a part is"),
        (lambda: Body(Composite([BALL]), mass=2.0), "is given a mass, and is a composite"),
        (lambda: Body(Composite([BALL]), density=2.0), "is given a density, and is a composite"),
        (lambda: Body(Composite([BALL, Part(Sphere(0.5), mass=-1.0)]), name="shell"), "mass of shell, .* is 0; exp"),
        (lambda: Body(Composite([BALL, Part(Sphere(0.5), mass=-2.0)])), "is -1; expected a finite sum above zero"),
        # The rounding of 0.1 + 0.2 - 0.3 is no mass.
        (lambda: Body(Composite([Part(Sphere(1.0), mass=m) for m in (0.1, 0.2, -0.3)])), "expected a finite sum"),
        (lambda: Body(Composite(ROD)), r"moments of inertia of body 0 is \[0, 0.5, 0.5\]; .* parts with extent"),
        (lambda: Body(Composite(HOLLOW)), "moments of inertia of body 0 is .*; expected"),
        (lambda: Composite.layers(Sphere(1.0), (0.9, 0.5), (1.0, 2.0)), "expected numbers that fall from 1"),
        (lambda: Composite.layers(Sphere(1.0), (1.0, 1.0), (1.0, 2.0)), "expected numbers that fall from 1"),
        (lambda: Composite.layers(Sphere(1.0), (), ()), "expected numbers that fall from 1"),
        (lambda: Composite.layers(Sphere(1.0), (1.0,), 2.0), "densities is 2.0; expected numbers"),
        (lambda: Composite.layers(Sphere(1.0), (1.0, 0.5), ("1 g/cm3", 2.0)), "expected all with a unit or none"),
        (lambda: Composite.layers(Sphere(1.0), (1.0, 0.5), (1.0,)), "densities has 1 numbers; expected 2"),
        (lambda: Composite.layers(Sphere(1.0), (1.0, 0.5), (1.0, -2.0)), "a density is -2.0"),
        (lambda: Composite.layers(PointMass(), (1.0,), (1.0,)), "shape is PointMass"),
        (lambda: Composite([BALL]).with_mass(-1.0), "mass is -1.0; expected a finite number above zero"),
        (lambda: Body(PointMass(), mass=1.0).fitted_ellipsoid(), "has no fitted ellipsoid"),
    ],
)
def test_bad_composites_are_refused(make, match):
    refused(match, make)


def test_composites_have_units():
    parts = [
        Part(Sphere("110 m"), density="2.4 g/cm3", position=["0.1 km", "0 m", "0 m"]),
        Part(Sphere(0.1 * u.km), mass=1e9 * u.kg),
    ]
    body = Body(Composite(parts), name="Selam")
    first = 2400.0 * 4.0 / 3.0 * np.pi * 110.0**3
    assert body.mass.to_value("kg") == pytest.approx(first + 1e9, rel=1e-14)
    assert body.working_frame.position[0].to_value("m") == pytest.approx(-100.0 * first / (first + 1e9), rel=1e-14)
    heavy = Composite(parts).with_mass("3e10 kg").parts[1]
    assert heavy.mass.to_value("kg") == pytest.approx(3e10 / (first + 1e9) * 1e9)
    assert body.density is None
    layers = Composite.layers(Sphere("1 km"), (1.0, 0.5), ("2 g/cm3", "3 g/cm3"))
    assert Body(layers).mass.to_value("kg") == pytest.approx(4e9 / 3.0 * np.pi * (2000.0 + 1000.0 / 8.0), rel=1e-14)
    with pytest.raises(InvalidInput, match="mass of part 1 has none; expected both or neither"):
        Body(Composite([parts[0], Part(Sphere("1 m"), mass=3.0)])).fitted_ellipsoid()
    # Plain numbers take a system's units.
    system = fullbody.System([Body(Composite([Part(Sphere(0.1), mass=5.0)]), name="A")], units=("km", "hour", "kg"))
    assert system["A"].shape.parts[0].shape.radius == 0.1 * u.km


def made():
    """A system with a composite in its orbit."""
    parts = [*CROSS, Part(Ellipsoid(0.5, 0.4, 0.3), density=-0.1, attitude=ATTITUDE), Part(PointMass(), mass=0.1)]
    bodies = [Body(Ellipsoid(3.0, 2.0, 1.0), mass=9.0, name="big"), Body(Composite(parts), name="small")]
    state = fullbody.State([[0, 0, 0], [12, 0, 1]], [[0, 0, 0], [0, 1.0, 0]], spin=[[0, 0, 1.0], [0.1, 0, 1.2]])
    return fullbody.System(bodies, units=("km", "hour", "kg"), G=1.0), state


TOML = """
[system]
units = ["km", "hour", "kg"]

[[body]]
name = "Alpha"
radius = 1.0
mass = 2e12

[[body]]
name = "Beta"
position = [6, 0, 0]
velocity = [0, 0.01, 0]
spin = [0, 0, 0.1]
  [[body.part]]
  radius = "300 m"
  density = "2 g/cm3"
  position = ["-250 m", 0, 0]
  [[body.part]]
  semi_axes = [0.3, 0.2, 0.1]
  mass = 1e11
  position = [0.25, 0, 0]
  angles = [0, 0, "90 deg"]
  [[body.part]]
  point = true
  mass = -1e9

[run]
until = 1.0
"""


def test_composites_are_read_from_toml(tmp_path):
    beta = read(tmp_path, TOML).system["Beta"]
    parts = beta.shape.parts
    assert [type(part.shape) for part in parts] == [Sphere, Ellipsoid, PointMass]
    np.testing.assert_allclose(parts[1].attitude, [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-16)
    assert beta.mass.to_value("kg") == pytest.approx(2e12 * 4.0 / 3.0 * np.pi * 0.3**3 + 1e11 - 1e9, rel=1e-14)
    for old, new, match in (
        ("[0.25, 0, 0]", "[0.25, 0]", r"body\[1\]\.part\[1\]\.position"),
        ("position = [0.25", "place = [0.25", r"body\[1\]\.part\[1\]\.place: is not a key"),
        ("mass = -1e9", "", r"body\[1\]\.part\[2\]: a part is given neither"),
        ("mass = -1e9", "mass = -1e13", r"body\[1\]\.part: mass of .*expected a finite sum above zero"),
        ("spin = [0, 0, 0.1]", "mass = 1e9", r"body\[1\]\.mass: is given beside \[\[body\.part\]\]"),
    ):
        refused(match, read, tmp_path, TOML.replace(old, new))


def test_pictures_draw_all_parts():
    system, state = made()
    run = system.integrate(state, 1.0, output=0.5)
    ax = run.plot.scene()
    # One surface of the ellipsoid and four of the composite, whose void has none.
    assert len(ax.collections) == 5
    # The farthest ball reaches 3.5 from the centre, and the axes 1.7 times that.
    low, high = ax.get_xlim()
    assert high - low > 12.0 + 3.5
    ax = run.plot.orbit()
    assert len(ax.patches) == 5
    assert "PointMass" in system["small"]._repr_html_()
    assert [len(parts) for parts in data_of(run.view().to_html())[0]["surfaces"]] == [1, 4]


def test_a_locked_dumbbell_librates_at_the_rate_of_its_moments():
    parts = dumbbell(0.1, 0.1)
    primary = fullbody.Component(diameter=0.7, rotation_period=3.0, mass=4.7e11, name="A")
    second = fullbody.Component(composite=Composite(parts), mass=1.7e10, name="B")
    with_units = {"units": ("km", "hour", "kg")}
    system, state = fullbody.binary(primary, second, semi_major_axis=3.3, elements="mean", **with_units)
    np.testing.assert_allclose(system.masses.to_value("kg"), [4.7e11, 1.7e10], rtol=1e-15)
    assert [part.mass.to_value("kg") for part in system["B"].shape.parts] == pytest.approx([8.5e9, 8.5e9], rel=1e-15)
    run = system.integrate(state.rotated("B", [0, 0, 1], 0.01), "900 hour", output="1 hour")
    swings = fullbody.observables.libration(run)
    # Murray & Dermott (1999), Eq. (5.45), with I = 2/5 m r^2 about the line of the balls and m d^2 more across it.
    along, across = 2 / 5 * 0.1**2, 2 / 5 * 0.1**2 + 0.1**2
    mu = system.G.to_value("km3 / (kg hour2)") * 4.7e11
    rate = np.sqrt(3 * (across - along) / across * mu / 3.3**3)
    # The next term is of the order of (0.2 / 6)^2, and the amplitude's of 0.01^2 / 4.
    assert swings.frequencies[0].to_value("rad / hour") == pytest.approx(rate, rel=5e-3)
    free = fullbody.Component(composite=Composite(parts), name="B")
    shared = {"total_mass": 1e12, "period": 60.0, "G": 1.0, "equal_density": True}
    refused("equal_density is given, and B is a composite", fullbody.binary, primary, free, **shared)
    for match, arguments in (
        ("composite of a component is", {"composite": parts}),
        ("has 2 of semi_axes, diameters", {"composite": Composite(parts), "diameter": 1.0}),
        ("given a density, and has a Composite", {"composite": Composite(parts), "density": 1.0}),
    ):
        refused(match, fullbody.Component, **arguments)
