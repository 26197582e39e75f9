"""Radiation: the drift of an orbit by a given force, when it is switched off, and torques on a spin."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import ForceFailed
from fullbody.forces import Byorp, Yorp
from scipy.spatial.transform import Rotation
from support import body_list, inertia, matrix, worst
from support.scenes import body_alone


def synchronous(rotated=0.0, rate=1.0, axes=(0.1, 0.09, 0.08), mass=1e-3, primary=None, tilt=0.0, forces=()):
    """A triaxial secondary on a circle of radius one, its long axis turned from the line of the centres."""
    bodies = body_list(A=(primary or fullbody.Sphere(0.3), 1.0), B=(fullbody.Ellipsoid(*axes), mass))
    system = fullbody.System(bodies, G=1.0, forces=forces)
    # On the circle that the secondary's quadrupole leaves, so that nothing else librates.
    a, b, c = axes
    pull = (1 + mass) * (1 + 0.3 * (2 * a * a - b * b - c * c))
    n = np.sqrt(pull)
    r, v = np.array([1.0, 0, 0]), np.array([0, n, 0])
    share = mass / (1 + mass)
    q = np.array([np.cos(rotated / 2), 0, 0, np.sin(rotated / 2)])
    if tilt:
        q = [q[0] * np.cos(tilt / 2), q[0] * np.sin(tilt / 2), q[3] * np.sin(tilt / 2), q[3] * np.cos(tilt / 2)]
    state = fullbody.State(
        [-share * r, (1 - share) * r],
        [-share * v, (1 - share) * v],
        attitude=[[1.0, 0, 0, 0], q],
        spin=[[0, 0, 0], [0, 0, rate * n]],
    )
    return system, state


def thrust(force=1e-9):
    return Byorp(on="B", about="A", force=force, name="BYORP")


def drift_of(force, mass=1e-3, axes=(0.1, 0.09, 0.08)):
    return 2 * force / (mass * np.sqrt(1 + mass)) / (1 - 3 * inertia(mass, axes)[2] / mass)


@pytest.mark.parametrize("force", [2e-9, -2e-9])
def test_the_orbit_drifts_by_2_F_over_m_n(force):
    """Over twenty turns; by the difference to the run without, which takes off the secondary's quadrupole.

    The secondary keeps turning with the orbit, so that the orbit has the change of its spin as well: C dn/da of the
    m n a / 2 that dL/da is. Both ways, since the rate grows with a.
    """
    system, state = synchronous()
    until = 40 * np.pi
    ends = [s.integrate(state, until, output=[until]) for s in (system.with_forces([thrust(force)]), system)]
    drift = ends[0].elements().a[0] - ends[1].elements().a[0]
    assert drift / until == pytest.approx(drift_of(force), rel=3e-3)
    assert ends[0].switched_off == {"BYORP": 0}


@pytest.mark.parametrize("facing", [0.0, np.pi])
@pytest.mark.parametrize("force", [0.5, [0.2, -0.5, 0.3]])
def test_force_and_torque_are_fixed_in_the_body_frame_of_the_secondary(force, facing):
    system, _ = synchronous(axes=(0.09, 0.08, 0.1))
    r, v = fullbody.KeplerElements(1.0, 0.4, 0.0, 0.0, 0.0, 1.0).to_cartesian(1.001)
    speed = np.array([3.0, 0.0, 1.0])
    angle = np.arctan2(r[1], r[0]) + 0.3
    # The body's z is its long axis, which the attitude turns into the plane, and its y is the short one.
    rotation = matrix([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
    outwards, along, up = rotation.T
    axes = np.stack([-along, up, -outwards] if facing == 0.0 else [along, up, outwards], axis=1)
    q = np.roll(Rotation.from_matrix(axes).as_quat(), 1)
    rate = np.cross(r, v)[2] / (r @ r)
    moved = fullbody.State([0 * r, r], [speed, speed + v], attitude=[[1.0, 0, 0, 0], q], spin=[[0, 0, 0], [0, rate, 0]])
    torque = np.array([0.1, 0.7, -0.4])
    byorp = Byorp(on="B", about="A", force=force, torque=torque, name="BYORP")
    loads = system.with_forces([byorp]).loads(moved)["BYORP"]
    components = np.array([0.0, force, 0.0] if np.ndim(force) == 0 else force)
    np.testing.assert_allclose(loads.force, [[0, 0, 0], rotation @ components], rtol=0, atol=1e-15)
    np.testing.assert_allclose(loads.torque, [[0, 0, 0], axes.T @ rotation @ torque], rtol=0, atol=1e-15)


# Locked or not.


def swinging(rotated, rate, until=100.0, **arguments):
    system, state = synchronous(rotated, rate, **arguments)
    return system.with_forces([thrust()]).integrate(state, until)


@pytest.mark.parametrize("rotated", [0.0, 0.5, 1.2, -1.4, np.pi - 1.2])
def test_a_libration_of_any_size_stays_locked(rotated):
    run = swinging(rotated, 1.0)
    assert run.switched_off == {"BYORP": 0}
    # All the time: the work is the force times the way along the body's middle axis, turned along the motion.
    middle = np.array([matrix(q)[:, 1] for q in run.attitude[:, 1]]) * np.sign(np.cos(rotated))
    power = 1e-9 * np.sum(run.velocity[:, 1] * middle, axis=1)
    assert run.work["BYORP"][-1] == pytest.approx(np.trapezoid(power, run.time), rel=1e-4)


@pytest.mark.parametrize("rate", [2.0, 0.0, -1.0])
def test_a_circulating_secondary_is_not_pushed(rate):
    run = swinging(0.0, rate)
    assert run.switched_off == {"BYORP": 1}
    assert (run.work["BYORP"] == 0).all()


@pytest.mark.parametrize(("share", "times"), [(0.93, 0), (1.07, 1)])
def test_the_lock_ends_at_the_separatrix(share, times):
    """A pendulum with psi'^2 = w^2 at psi = 0 just turns over; w^2 is 3 (B - A)/C n^2."""
    a, b = 0.1, 0.09
    w = np.sqrt(3 * (a * a - b * b) / (a * a + b * b))
    run = swinging(0.0, 1.0 + share * w)
    assert run.switched_off == {"BYORP": times}
    r = run.position[:, 1] - run.position[:, 0]
    longitude = np.unwrap(np.arctan2(r[:, 1], r[:, 0]))
    psi = np.unwrap(2 * np.arctan2(run.attitude[:, 1, 3], run.attitude[:, 1, 0])) - longitude
    assert (np.ptp(psi) > 2 * np.pi) == bool(times)


def test_a_secondary_that_lies_on_its_side_is_not_pushed():
    assert swinging(0.0, 1.0, until=0.5, tilt=1.0).switched_off == {"BYORP": 1}
    assert swinging(0.0, 1.0, until=0.5, tilt=0.3).switched_off == {"BYORP": 0}


def test_each_run_counts_its_own_losses_of_lock():
    system, state = synchronous(0.0, 2.0)
    sim = fullbody.Simulation(system.with_forces([thrust()]), state)
    assert [sim.integrate(time).switched_off["BYORP"] for time in (5.0, 10.0)] == [1, 1]
    sim.state = synchronous()[1]
    assert sim.integrate(5.0).switched_off == {"BYORP": 0}


# The torque on a spin.

C = 0.4 * 0.25  # of a sphere of mass one and radius 1/2


def turning(eps, **arguments):
    """A sphere whose spin of 3 is at an obliquity, in the yz-plane, under a torque of radiation."""
    q = (np.cos(eps / 2), -np.sin(eps / 2), 0.0, 0.0)
    system, state = body_alone(fullbody.Sphere(0.5), spin=(0, 0, 3.0), attitude=q)
    return system.with_forces([Yorp(on="A", name="YORP", **arguments)]), state


def spin_of(run):
    return np.array([matrix(q) @ w for q, w in zip(run.attitude[:, 0], run.spin[:, 0], strict=True)])


@pytest.mark.parametrize("eps", [0.4, 2.0])
def test_spin_and_obliquity_change_as_the_closed_form(eps):
    """By d omega/dt = along/C and d eps/dt = across/(C omega), eps - eps_0 = across/along log(omega/omega_0)."""
    along, across = 2e-4, 3e-4
    system, state = turning(eps, along=along, across=across)
    run = system.integrate(state, 100.0, output=25.0)
    spin = spin_of(run)
    omega = 3.0 + along / C * run.time
    np.testing.assert_allclose(np.linalg.norm(spin, axis=1), omega, rtol=1e-12)
    obliquity = np.arctan2(np.hypot(spin[:, 0], spin[:, 1]), spin[:, 2])
    np.testing.assert_allclose(obliquity, eps + across / along * np.log(omega / 3.0), rtol=1e-12)
    # In the plane of the pole and the spin.
    np.testing.assert_allclose(spin[:, 0], 0.0, atol=1e-13)
    assert abs(run.energy_drift).max() < 1e-13


@pytest.mark.parametrize("pole", [(0.0, 0.0, 2.0), (1.0, -2.0, 0.5)])
def test_a_table_is_a_spline_in_the_obliquity(pole):
    from scipy.interpolate import CubicSpline

    obliquity = np.radians([0, 20, 50, 90, 110, 150, 180])
    along, across = np.cos(3 * obliquity), np.sin(2 * obliquity)
    for eps in (0.0, 0.3, 1.0, 2.5, 3.1):
        system, state = turning(eps, along=along, across=across, obliquity=obliquity, pole=pole)
        torque = state.rotation_matrix[0] @ system.loads(state)["YORP"].torque[0]
        axis = np.array([0.0, np.sin(eps), np.cos(eps)])
        unit = np.array(pole) / np.linalg.norm(pole)
        angle = np.arctan2(np.linalg.norm(np.cross(axis, unit)), axis @ unit)
        outwards = (axis * (axis @ unit)) - unit
        outwards /= np.linalg.norm(outwards) or 1.0
        expected = CubicSpline(obliquity, along)(angle) * axis + CubicSpline(obliquity, across)(angle) * outwards
        assert worst(torque, expected) < 1e-13


# The pole of the obliquity, where a torque across the spin has no direction.


def tilted(obliquity, across, until=None, **arguments):
    """A sphere with a spin of 3 at an obliquity, which a torque across the spin changes at the rate across / (C 3)."""
    attitude = (np.cos(obliquity / 2), -np.sin(obliquity / 2), 0.0, 0.0)
    system, state = body_alone(fullbody.Sphere(0.5), spin=(0, 0, 3.0), attitude=attitude)
    return system.with_forces([Yorp(on="A", along=0.0, across=across, name="YORP", **arguments)]), state


@pytest.mark.parametrize(
    ("obliquity", "across", "until"),
    [(0.02, -1e-3, 100.0), (np.pi - 0.02, 1e-3, 100.0), (0.02, 1e-3, -100.0), (np.pi - 0.02, -1e-3, -100.0)],
)
@pytest.mark.parametrize("derivatives", [False, True])
def test_a_spin_that_is_driven_to_its_pole_is_an_error_that_names_it(obliquity, across, until, derivatives):
    system, state = tilted(obliquity, across)
    with pytest.raises(ForceFailed, match=r"spin of A, at an obliquity of .* rad, to the pole by time") as caught:
        system.integrate(state, until, derivatives=derivatives)
    # The obliquity falls evenly; the last good state is a step before the pole.
    expected = np.copysign(0.02 * C * 3.0 / 1e-3, until)
    run = caught.value.run
    assert 0.5 * abs(expected) < abs(run.time[-1]) <= abs(expected)
    assert run.statistics.steps < 200
    spin = run[-1].rotation_matrix[0] @ run.spin[-1, 0]
    from_pole = np.arctan2(np.hypot(spin[0], spin[1]), abs(spin[2]))
    assert from_pole == pytest.approx(0.02 * (1.0 - run.time[-1] / expected), abs=1e-12)


def test_a_tumbling_body_that_is_driven_to_its_pole_ends_the_run():
    bodies = body_list(A=(fullbody.Ellipsoid(1.0, 0.9, 0.8), 1.0), B=(fullbody.Sphere(0.2), 1e-3))
    system = fullbody.System(bodies, G=1.0, forces=[Yorp(on="A", along=0.0, across=-1e-3)])
    spin = [[0.0, np.sin(0.02), np.cos(0.02)], [0, 0, 0]]
    state = fullbody.State([[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [0, 0.45, 0]], spin=spin)
    with pytest.raises(ForceFailed, match="to the pole by time") as caught:
        system.integrate(state, 200.0)
    assert caught.value.run.statistics.steps < 2000


def test_a_table_that_vanishes_at_the_poles_is_approached_exponentially():
    """By d eps/dt = -k sin(2 eps) with k = 1e-3 / (C 3), tan eps falls exponentially at the rate 2 k."""
    obliquity = np.linspace(0.0, np.pi, 181)
    arguments = {"obliquity": obliquity}
    system, state = tilted(0.3, 0.0)
    yorp = Yorp(on="A", along=np.zeros(181), across=-1e-3 * np.sin(2 * obliquity), name="YORP", **arguments)
    run = system.with_forces([yorp]).integrate(state, 2000.0, output=400.0)
    spin = np.array([state.rotation_matrix[0] @ state.spin[0] for state in run])
    result = np.hypot(spin[:, 0], spin[:, 1]) / spin[:, 2]
    expected = np.tan(0.3) * np.exp(-2e-3 / (C * 3.0) * run.time)
    np.testing.assert_allclose(result, expected, rtol=1e-5)
