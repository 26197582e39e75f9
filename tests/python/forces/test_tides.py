"""Tides of constant time lag: the force of a lagging bulge, the secular rates of Hut, what is conserved."""

import fullbody
import mpmath as mp
import numpy as np
import pytest
from astropy import units as u
from fullbody.errors import InconsistentInput
from fullbody.forces import Tide
from support import matrix, reference, worst


def two(
    primary=None,
    satellite=None,
    mass=1e-3,
    orbit=(1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    spin=((0, 0, 0), (0, 0, 0)),
    **options,
):
    """Spheres or points of masses one and ``mass`` (G = 1) on an orbit, the first at rest in the origin."""
    shapes = (primary or fullbody.PointMass(), satellite or fullbody.PointMass())
    bodies = [fullbody.Body(s, mass=m, name=n) for s, m, n in zip(shapes, (1.0, mass), "AB", strict=True)]
    system = fullbody.System(bodies, G=1.0)
    r, v = fullbody.KeplerElements(*orbit).to_cartesian(system.mu())
    return system, fullbody.State([0 * r, r], [0 * v, v], spin=spin, **options)


def lagging(r, v, omega, mass, k2, radius, lag):
    """The part of first order in the lag of the force on the raiser (G = 1), from the potential of the bulge itself.

    The bulge that the raiser made when it stood at r* attracts it by k2 m R^5 (3 (r.r*)^2 - r^2 r*^2)/(2 r^5 r*^5). In
    axes that turn with the body it was at r* = r - lag (v - omega x r) the lag ago.
    """
    with mp.workdps(40):
        r, v, omega = (mp.matrix([mp.mpf(float(c)) for c in x]) for x in (r, v, omega))
        rotated = mp.matrix(
            [omega[1] * r[2] - omega[2] * r[1], omega[2] * r[0] - omega[0] * r[2], omega[0] * r[1] - omega[1] * r[0]]
        )

        def potential(x, y, z, delay):
            at = mp.matrix([x, y, z])
            was = r - delay * (v - rotated)
            a2, b2, ab = mp.fdot(at, at), mp.fdot(was, was), mp.fdot(at, was)
            return (3 * ab * ab - a2 * b2) / (2 * (a2 * b2) ** mp.mpf(2.5))

        order = [(1, 0, 0, 1), (0, 1, 0, 1), (0, 0, 1, 1)]
        slope = [mp.diff(potential, (r[0], r[1], r[2], 0), n) for n in order]
        return np.array([float(s) for s in slope]) * mass**2 * k2 * radius**5 * lag


@pytest.mark.parametrize("case", range(4))
def test_the_force_is_that_of_a_lagging_bulge(case):
    rng = np.random.default_rng(case)
    r, v, spin = rng.normal(size=(3, 3)) * [[3.0], [0.7], [2.0]]
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    system, _ = two(fullbody.Sphere(0.1), fullbody.Sphere(0.05), mass=0.3)
    speed = np.array([5.0, 2.0, 1.0])
    state = fullbody.State([r * 0, r], [speed, speed + v], attitude=[q, [1.0, 0, 0, 0]], spin=[spin, [7.0, 8.0, 9.0]])
    tide = Tide(on="A", by="B", k2=0.4, lag=0.02, radius=0.11, name="tide")
    loads = system.with_forces([tide]).loads(state)["tide"]
    expected = lagging(r, v, matrix(q) @ spin, 0.3, 0.4, 0.11, 0.02)
    assert worst(loads.force[1], expected) < 1e-14
    assert (loads.force[0] == -loads.force[1]).all()
    assert worst(matrix(q) @ loads.torque[0], -np.cross(r, expected)) < 1e-14
    assert (loads.torque[1] == 0).all()


def test_the_radius_is_that_of_the_sphere_of_equal_volume():
    system, state = two(fullbody.Ellipsoid(0.3, 0.2, 0.1))
    item, other = (
        system.with_forces([Tide(on="A", by="B", k2=0.4, lag=0.1, name="tide", **arguments)]).loads(state)["tide"].force
        for arguments in ({}, {"radius": (0.3 * 0.2 * 0.1) ** (1 / 3)})
    )
    np.testing.assert_allclose(item, other, rtol=1e-13)


# The law is tested in a short time, with a lag that no body could have.
@pytest.mark.filterwarnings("ignore:tide has a lag of")
@pytest.mark.parametrize("k2_lag", [6e5, 3e5])
def test_an_orbit_about_a_body_at_rest_decays_as_the_closed_form(k2_lag):
    """a(t) = R [(a/R)^8 - 48 k2 q (1+q) t/T]^(1/8), T = R^3/(G M lag), q the raiser's mass over the deformed one's.

    From da/dt = 2 F/(n m') with m' the reduced mass and F = 3 k2 G m^2 R^5 lag v/a^8. Left out are the turning of the
    deformed body, which takes up the orbit's angular momentum, and e^2, which is (da/dt / (n a))^2.
    """
    q, radius, a = 1e-6, 1.0, 5.0
    system, state = two(fullbody.Sphere(1.0), mass=q, orbit=(a, 0, 0.3, 0, 0, 0))
    tide = Tide(on="A", by="B", k2=1.0, lag=k2_lag, name="tide")
    times = np.linspace(0.0, 8000.0, 5)
    run = system.with_forces([tide]).integrate(state, times[-1], output=times)
    T = radius**3 / k2_lag
    expected = radius * ((a / radius) ** 8 - 48 * q * (1 + q) * times / T) ** 0.125
    # Over a turn a itself changes by e times as much as over the whole.
    assert expected[-1] < 0.98 * a
    assert worst(run.elements().a, expected) < 2e-4
    assert worst(run.elements().a - a, expected - a, a - expected[-1]) < 3e-3


def test_the_eccentricity_of_a_synchronous_satellite_falls_at_huts_rate():
    """de/dt / e = -(21/2) k2 n^2 lag (M/m) (R/a)^5; with Q = 1/(n lag) the -(21/2) k2/Q n (M/m) (R/a)^5 of textbooks.

    From Hut (1981), eq. 10: -27 (1 - 11/18) = -21/2. Left out are e^2, and how far the spin follows within a turn:
    15/2 k2 lag n (M/m) (R/a)^3.
    """
    m, radius, e, k2, lag = 1e-3, 0.2, 0.01, 1.0, 4e-5
    orbit, spin = (1.0, e, 0, 0, 0, 0), [[0, 0, 0], [0, 0, 1.0]]
    system, state = two(satellite=fullbody.Sphere(radius), mass=m, orbit=orbit, spin=spin)
    n = np.sqrt(system.mu())
    until = 60 * 2 * np.pi / n
    tide = Tide(on="B", by="A", k2=k2, lag=lag, name="tide")
    run = system.with_forces([tide]).integrate(state, until, output=[0.0, until])
    expected = -10.5 * k2 * n**2 * lag / m * radius**5
    assert np.diff(np.log(run.elements().e))[0] / until == pytest.approx(expected, rel=1e-2)


def test_tides_reduce_energy_and_keep_angular_momentum():
    rng = np.random.default_rng(7)
    system, state = two(
        fullbody.Sphere(0.3),
        fullbody.Sphere(0.2),
        mass=0.4,
        orbit=(1.0, 0.3, 2.0, 1.0, 0.5, 0.3),
        spin=rng.normal(size=(2, 3)) * 3,
    )
    tides = [Tide(on="A", by="B", k2=0.5, lag=0.05), Tide(on="B", by="A", k2=1.2, lag=0.1)]
    run = system.with_forces(tides).integrate(state, 60.0)
    assert (np.diff(run.energy) < 0).all()
    assert run.energy[-1] - run.energy[0] < -0.01 * abs(run.energy[0])
    for force in tides:
        assert (np.diff(run.work[force.name]) < 0).all()
        assert np.abs(run.angular_impulse[force.name]).max() < 1e-14
        assert np.abs(run.impulse[force.name]).max() < 1e-15
    size = np.linalg.norm(run.angular_momentum[0])
    assert np.abs(run.angular_momentum - run.angular_momentum[0]).max() < 1e-13 * size
    assert np.abs(run.energy_drift).max() < 1e-12


@pytest.mark.parametrize("case", range(3))
def test_spins_and_orbits_are_those_of_reboundx(case):
    """REBOUNDx has the effect tides_spin; bulges without a lag have a Love number of 1e-12 there."""
    data = reference("tides_spin")
    of = data["cases"][case]
    satellite = fullbody.Sphere(0.1)
    spin = [data["spin"], [0, 0, 0]]
    system, state = two(fullbody.Sphere(data["radius"]), satellite, mass=data["mass"], orbit=of["elements"], spin=spin)
    tide = Tide(on="A", by="B", k2=0.8, lag=data["k2_lag"] / 0.8)
    run = system.with_forces([tide]).integrate(state, data["time"], output=[data["time"]])
    np.testing.assert_allclose(run.position[0, 1] - run.position[0, 0], of["relative"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.velocity[0, 1] - run.velocity[0, 0], of["relative_velocity"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(matrix(run.attitude[0, 0]) @ run.spin[0, 0], of["spin"], rtol=0, atol=1e-9)
    free = system.integrate(state, data["time"], output=[data["time"]])
    assert np.abs(run.position - free.position).max() > 0.05


UPRIGHT, UPSIDE_DOWN = (1.0, 0, 0, 0), (0.0, 1, 0, 0)


@pytest.mark.parametrize(
    ("spin", "attitude", "rate", "angle"),
    [
        ([0.0, 0.0, 3.0], UPRIGHT, lambda n: 3.0 - n, "A turns relative to B"),
        ([0.0, 0.0, 3.0], UPSIDE_DOWN, lambda n: 3.0 + n, "A turns relative to B"),
        ([0.0, 0.0, 0.0], UPRIGHT, lambda n: n, "A turns relative to B"),
        # A synchronous body has the tides of its librations and of the eccentricity, of the frequency n.
        ([0.0, 0.0, None], UPRIGHT, lambda n: n, "B goes round A"),
        # About the line of the centres no spin is seen.
        ([9.0, 0.0, None], UPRIGHT, lambda n: n, "B goes round A"),
    ],
)
def test_a_lag_of_more_than_a_radian_causes_a_warning(spin, attitude, rate, angle):
    n = np.sqrt(1.001 / 1.3**3)
    rotated = [n if component is None else component for component in spin]
    arguments = {"orbit": (1.3, 0, 0, 0, 0, 0), "spin": [rotated, [0, 0, 0]], "attitude": [attitude, UPRIGHT]}
    system, state = two(fullbody.Sphere(0.1), **arguments)

    def begin(radians):
        world = system.with_forces([Tide(on="A", by="B", k2=0.1, lag=radians / rate(n), name="bulge")])
        return fullbody.Simulation(world, state)

    for radians in (0.999, 0.01):
        begin(radians)
    for radians in (1.001, 40.0):
        text = f"^bulge has a lag of .*, within which {angle} by {np.degrees(radians):.4g} degrees; .* first order"
        with pytest.warns(InconsistentInput, match=text):
            begin(radians)


def test_a_lag_in_a_wrong_unit_causes_a_warning():
    system, state = fullbody.systems.kw4(units=True)
    wrong = [Tide(on="Alpha", by="Beta", k2=1e-5, lag=60.0 * hour) for hour in (1.0, u.hour)]
    for tide in wrong:
        with pytest.warns(InconsistentInput, match="^tide on Alpha has a lag of 60 h, within which Alpha turns"):
            system.with_forces([tide]).integrate(state, 0.01)
    right = Tide(on="Alpha", by="Beta", k2=1e-5, lag=60.0 * u.s)
    system.with_forces([right]).integrate(state, 0.01)
    with pytest.warns(
        InconsistentInput, match="the starts of 1 of 2 members are probably a mistake; member 1: tide on Al"
    ):
        fullbody.integrate_many([(system.with_forces([tide]), state) for tide in (right, wrong[1])], 0.01)
