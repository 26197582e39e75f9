"""The Sun and other point masses on prescribed paths: forces and motion of a pair."""

import fullbody
import numpy as np
import pytest
from astropy.coordinates import BarycentricMeanEcliptic, SkyCoord
from fullbody.errors import InvalidInput
from fullbody.forces import ThirdBody
from support import reference, refused, worst
from support.scenes import at_rest, differential, kepler_position, pair, relative, sun

DATA = reference("third_body")
TIGHT = fullbody.Verner98(rtol=1e-14, atol=1e-14)


def spheres():
    """The pair of the reference, with its barycentre at rest at the origin."""
    first, second, third = DATA["masses"]
    bodies = [fullbody.Body(fullbody.Sphere(r), mass=m) for r, m in ((0.7, first), (0.2, second))]
    system = fullbody.System(bodies, G=DATA["G"])
    r, v = fullbody.KeplerElements(*DATA["mutual_elements"]).to_cartesian(system.mu())
    share = second / (first + second)
    state = fullbody.State([-share * r, (1 - share) * r], [-share * v, (1 - share) * v])
    orbit = fullbody.KeplerElements(*DATA["elements_of_the_system_about_the_third_body"])
    return system, state, ThirdBody(mass=third, orbit=orbit, of="system", name="Sun")


def test_a_thousand_hours_agree_with_extended_precision():
    system, state, third = spheres()
    expected = np.array([[float(x) for x in row] for row in DATA["relative_states"]])
    free = system.integrate(state, 1000.0, output=DATA["times"])
    run = system.with_forces([third]).integrate(state, 1000.0, output=DATA["times"])
    assert np.abs(relative(run) - expected)[:, :3].max() < 1e-9
    assert np.abs(relative(run) - expected)[:, 3:].max() < 1e-9
    assert np.abs(relative(free) - expected)[-1].max() > 1e-3
    assert run.statistics.steps == pytest.approx(free.statistics.steps, rel=0.1)
    assert abs(run.energy_drift).max() < 1e-12


@pytest.mark.parametrize("distance", [3.0, 30.0, 1e4, 1e8])
def test_the_difference_of_pulls_keeps_its_digits(distance):
    """The plain difference in longdouble (19 digits) loses 8 digits at 1e8."""
    point = distance * np.array([0.6, -0.64, 0.48])
    bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=m) for m in (2.0, 0.5)]
    position = np.array([[0.25, 0.5, -0.125], [-1.0, -2.0, 0.5]])
    system = fullbody.System(bodies, G=1.0, forces=[at_rest(point, 3.0)])
    force = system.loads(fullbody.State(position, np.zeros((2, 3))))["Sun"].force
    for k, mass in enumerate(system.masses):
        expected = mass * differential(position[k], point, 3.0)
        assert worst(force[k], expected) < 1e-15 + 1e-18 * distance


@pytest.mark.parametrize("e", [0.0, 0.3, 0.95, 1.5])
def test_third_bodies_follow_keplers_equation(e):
    bodies = [fullbody.Body(fullbody.PointMass(), mass=mass) for mass in (2.0, 1.0)]
    system = fullbody.System(bodies, G=0.5)
    a = 50.0 if e < 1 else -50.0
    elements = (a, e, 0.4, 1.0, 2.0, 0.3)
    for of, sign in (("system", -1.0), ("body", 1.0)):
        third = ThirdBody(mu=7.0, orbit=fullbody.KeplerElements(*elements), of=of, time=4.0, name="Sun")
        times = np.array([-300.0, 4.0, 17.0, 1000.0])
        position, velocity = system.with_forces([third]).third_body("Sun", times)
        expected = [sign * kepler_position(elements, 8.5, t - 4.0) for t in times]
        assert worst(position, expected) < 3e-14
        h = 1e-3
        ahead, behind = (
            np.array([kepler_position(elements, 8.5, t - 4.0 + s * h) for t in times]) * sign for s in (1, -1)
        )
        assert worst(velocity, (ahead - behind) / (2 * h)) < 1e-7
        item, _ = system.with_forces([third]).third_body("Sun", 17.0)
        assert (item == position[2]).all()


def test_a_table_of_positions_gives_the_motion_of_its_orbit():
    system, state = pair()
    third = sun()
    times = np.linspace(-1.0, 21.0, 201)
    positions = system.with_forces([third]).third_body("Sun", times)[0]
    table = ThirdBody(mu=1e6, times=times, positions=positions, of="body", name="Sun")
    ends = [relative(system.with_forces([force]).integrate(state, 20.0, output=[20.0])) for force in (third, table)]
    effect = np.abs(ends[0] - relative(system.integrate(state, 20.0, output=[20.0]))).max()
    assert np.abs(ends[0] - ends[1]).max() < 1e-8 * effect


# Invariances: what the physics does not know of.


def end(system, state, forces, until=20.0):
    return system.with_forces(forces).integrate(state, until, output=[until], integrator=TIGHT)


def test_forces_do_not_depend_on_the_motion_of_the_barycentre_and_the_origin_of_time():
    system, state = pair()
    original = end(system, state, [sun(time=3.0)])
    shift, speed = np.array([1024.0, -512.0, 64.0]), np.array([3.0, -8.0, 0.5])
    moved = fullbody.State(state.position + shift, state.velocity + speed, state.attitude, state.spin, time=1000.0)
    shifted = end(system, moved, [sun(time=1003.0)], 1020.0)
    np.testing.assert_allclose(relative(shifted), relative(original), rtol=0, atol=2e-12)
    np.testing.assert_allclose(shifted.spin, original.spin, rtol=0, atol=2e-11)
    np.testing.assert_allclose(
        shifted.position - original.position, (shift + 20 * speed) + 0 * original.position, atol=1e-11
    )
    # Energy of the barycentre's motion comes in; the impulse is what it was.
    np.testing.assert_allclose(shifted.impulse["Sun"], original.impulse["Sun"], atol=1e-16)
    assert abs(shifted.energy_drift).max() < 1e-13


def test_a_run_back_returns_to_its_start():
    system, state = pair()
    world = system.with_forces([sun()])
    sim = fullbody.Simulation(world, state, integrator=TIGHT)
    forward = sim.integrate(30.0, output=[30.0])
    back = sim.integrate(0.0, output=[0.0])
    np.testing.assert_allclose(back.position[0], state.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(back.spin[0], state.spin, rtol=0, atol=3e-12)
    np.testing.assert_allclose(back.work["Sun"], -forward.work["Sun"], rtol=1e-9)
    again = world.integrate(forward[-1], 0.0, output=[0.0], integrator=TIGHT)
    np.testing.assert_allclose(relative(again), relative(back), rtol=0, atol=1e-10)


# Limits.


@pytest.mark.filterwarnings("ignore:the tide of Sun")
def test_a_third_body_of_hardly_any_mass_changes_nothing():
    system, state = pair()
    free = system.integrate(state, 20.0, output=2.0)
    run = system.with_forces([sun(mu=1e-280)]).integrate(state, 20.0, output=2.0)
    assert (run.position == free.position).all()
    assert (run.spin == free.spin).all()


def test_spheres_and_points_get_no_torque():
    for shape in (fullbody.Sphere(0.4), fullbody.PointMass(), fullbody.Ellipsoid(0.4, 0.4, 0.4)):
        system = fullbody.System([fullbody.Body(shape, mass=1.0)], G=1.0, forces=[at_rest([1.0, 2.0, 3.0], 5.0)])
        state = fullbody.State([[0.0, 0, 0]], [[0.0, 0, 0]])
        loads = system.loads(state)["Sun"]
        assert (loads.torque == 0).all()
        # Alone it is its own barycentre, where the pull is taken off.
        assert np.abs(loads.force).max() < 1e-16


@pytest.mark.parametrize(("rows", "warned"), [(6, True), (12, False)])
def test_coarse_tables_cause_a_warning(rows, warned, recwarn):
    # The error of a cubic spline on a circle with n rows a turn: (2 pi/n)^4/384, 3e-3 and 2e-4.
    angles = 2 * np.pi * np.arange(-rows, 3 * rows) / rows
    circle = np.stack([40 * np.cos(angles), 40 * np.sin(angles), 0 * angles], axis=1)
    third = ThirdBody(mu=1.0, times=angles, positions=circle, of="body", name="Moon")
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)], G=1.0, forces=[third])
    state = fullbody.State(position=[[0.0, 0.0, 0.0]], velocity=[[0.0, 0.0, 0.0]])
    system.integrate(state, 1.0, output="ends")
    result = [str(warning.message) for warning in recwarn]
    middle = np.pi / rows
    wrong = np.linalg.norm(system.third_body("Moon", middle)[0] - 40 * np.array([np.cos(middle), np.sin(middle), 0]))
    if warned:
        assert len(result) == 1
        assert "positions of Moon are so far apart" in result[0]
        stated = float(result[0].split("wrong by about ")[1].split()[0])
        assert 0.5 < stated / (wrong / 40) < 2.0
    else:
        assert not result


FRAMES = ("ecliptic", "equatorial", "galactic", BarycentricMeanEcliptic(equinox="J2015"))


@pytest.mark.parametrize("system_frame", ["ecliptic", "equatorial", "galactic"])
@pytest.mark.parametrize("arguments", FRAMES)
def test_a_path_in_another_frame_is_turned_into_that_of_the_system(system_frame, arguments):
    """The place in its own frame by another program's Kepler orbit, turned by astropy's coordinates."""
    rng, times = np.random.default_rng(17), [0.0, 2.0, 4.0, 7.0]
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (2.0, 1.0)]
    system = fullbody.System(bodies, G=0.5, frame=system_frame)
    names = {"ecliptic": "barycentricmeanecliptic", "equatorial": "icrs"}
    for _ in range(5):
        elements = (50.0, rng.uniform(0, 0.8), rng.uniform(0, 3.1), *rng.uniform(0, 6.2, 3))
        orbit = fullbody.KeplerElements(*elements, frame=arguments)
        points = [kepler_position(elements, 8.5, t).astype(float) for t in times]
        position = SkyCoord(
            *np.transpose(points), representation_type="cartesian", frame=names.get(str(arguments), arguments)
        )
        expected = position.transform_to(names.get(system_frame, system_frame)).cartesian.xyz.T
        third = ThirdBody(mu=7.0, orbit=orbit, of="body", name="Sun")
        changed = system.with_forces([third])
        assert worst(changed.third_body("Sun", times)[0], expected) < 1e-13
        again = fullbody.System(list(changed), G=0.5, frame=system_frame, forces=changed.forces)
        assert again == changed
        table = ThirdBody(mu=7.0, times=times, positions=points, frame=arguments, of="body", name="Sun")
        assert worst(system.with_forces([table]).third_body("Sun", times)[0], expected) < 1e-13


def test_a_path_in_a_frame_beside_a_system_without_one_is_refused():
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (2.0, 1.0)]
    orbit = fullbody.KeplerElements(50.0, 0.1, 0.2, 0.3, 0.4, 0.5, frame="ecliptic")
    third = ThirdBody(mu=7.0, orbit=orbit, of="body", name="Sun")
    refused("path of Sun is in the frame 'ecliptic'", lambda: fullbody.System(bodies, G=0.5, forces=[third]))
    with pytest.raises(InvalidInput, match="path of Sun: cannot rotate from the frame 'ecliptic' to 'orbit'"):
        fullbody.System(bodies, G=0.5, frame="orbit", forces=[third])
    wrong = fullbody.KeplerElements(50.0, 0.1, 0.2, 0.3, 0.4, 0.5, frame="eclptic")
    refused("cannot rotate from the frame 'eclptic'", lambda: ThirdBody(mu=7.0, orbit=wrong, of="body"))
    refused("frame of third body is 'icrs' beside an orbit", ThirdBody, mu=7.0, orbit=orbit, frame="icrs", of="body")
