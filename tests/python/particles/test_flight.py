"""Particles among moving bodies against conserved quantities, linear theory, bodies of tiny mass, and rebound."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Particles
from fullbody.errors import InvalidInput
from fullbody.particles import EscapeDistance, ParticleFunction, ParticlePeriapsis
from support import refused
from support.meshes import box

TURN = 2.0 * np.pi


def circular(mu, radii=(0.05, 0.02)):
    """Two spheres of masses 1 - mu and mu on a circle of radius one, G = 1: the angular velocity is one."""
    bodies = [
        fullbody.Body(fullbody.Sphere(radius), mass=mass, name=name)
        for radius, mass, name in zip(radii, (1.0 - mu, mu), "AB", strict=True)
    ]
    state = fullbody.State(
        position=[[-mu, 0.0, 0.0], [1.0 - mu, 0.0, 0.0]],
        velocity=[[0.0, -mu, 0.0], [0.0, 1.0 - mu, 0.0]],
        attitude=[[1.0, 0.0, 0.0, 0.0]] * 2,
        spin=[[0.0, 0.0, 1.0]] * 2,
    )
    return fullbody.System(bodies, G=1.0), state


def jacobi(mu, bodies, x, v):
    """Twice the constant, without its sign: energy less angular momentum, both in inertial axes."""
    first, second = (np.linalg.norm(x - bodies.position[k], axis=-1) for k in (0, 1))
    potential = (1.0 - mu) / first + mu / second
    return 0.5 * (v**2).sum(-1) - potential - (x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0])


def test_jacobis_constant_is_conserved_over_twenty_orbits():
    system, state = circular(0.01)
    exact, end = fullbody.Verner98.to_roundoff(), 20.0 * TURN
    run = system.integrate(state, end, output=[], integrator=exact, dense=True)
    x = np.array([[0.5, 0.0, 0.05], [0.0, -0.4, 0.0], [1.6, 0.3, 0.2], [-2.0, 0.0, 0.0]])
    r = np.linalg.norm(x, axis=1)[:, None]
    v = np.cross([0.0, 0.0, 1.0], x) / r * np.sqrt(1.0 / r)
    flight = run.fly(fullbody.Particles(x, v), output="ends", integrator=fullbody.Verner98(rtol=1e-14, atol=1e-14))
    first = jacobi(0.01, run(0.0), x, v)
    last = jacobi(0.01, run(end), flight.position[-1], flight.velocity[-1])
    assert set(flight.fate) == {"flying"}
    assert np.abs(last / first - 1.0).max() < 2e-13


def flown_as_bodies(system, state, particles, until, mass):
    """Ends (2, P, 3) of particles in position and velocity, in a run in which they are points of next to no mass."""
    count = len(particles)
    tiny = [fullbody.Body(fullbody.PointMass(), mass=mass, name=f"probe {k}") for k in range(count)]
    start = fullbody.State(
        position=[*state.position, *particles.position],
        velocity=[*state.velocity, *particles.velocity],
        attitude=[*state.attitude, *[[1.0, 0.0, 0.0, 0.0]] * count],
        spin=[*state.spin, *np.zeros((count, 3))],
    )
    extended = fullbody.System([*system.bodies, *tiny], G=system.G, forces=system.forces)
    end = extended.integrate(start, until, output="ends")[-1]
    return np.array([end.position[-count:], end.velocity[-count:]])


def test_a_particle_moves_as_a_body_of_negligible_mass():
    system, state = fullbody.systems.kw4()
    particles = fullbody.Particles([[4.0, 1.0, 0.4], [-1.4, 0.2, 0.0]], [[-0.2, 0.6, 0.1], [-0.2, -1.2, 0.1]])
    expected = flown_as_bodies(system, state, particles, 24.0, mass=1e-30)
    flight = system.fly(state, particles, 24.0, output="ends")
    assert np.abs([flight.position[-1], flight.velocity[-1]] - expected).max() < 1e-10


def test_particles_move_as_in_rebound():
    rebound = pytest.importorskip("rebound")
    masses, x = [1.0, 0.3], [[-0.6, 0.0, 0.0], [2.0, 0.0, 0.1]]
    v = [[0.0, -0.15, 0.0], [0.0, 0.5, 0.0]]
    probe, speed = [0.0, 4.0, 0.5], [-0.5, 0.1, 0.0]
    sim = rebound.Simulation()
    for mass, position, velocity in zip([*masses, 0.0], [*x, probe], [*v, speed], strict=True):
        names = dict(zip(("x", "y", "z", "vx", "vy", "vz"), [*position, *velocity], strict=True))
        sim.add(m=mass, **names)
    sim.N_active = 2
    sim.integrate(20.0)
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in masses]
    state = fullbody.State(position=x, velocity=v, attitude=[[1, 0, 0, 0]] * 2, spin=np.zeros((2, 3)))
    flight = fullbody.System(bodies, G=1.0).fly(state, fullbody.Particles([probe], [speed]), 20.0, output="ends")
    assert np.abs(flight.position[-1, 0] - sim.particles[2].xyz).max() < 1e-10


def cloud(number, seed=0):
    system, state = fullbody.systems.kw4()
    random = np.random.default_rng(seed)
    x = random.normal(size=(number, 3))
    x *= random.uniform(1.2, 6.0, number)[:, None] / np.linalg.norm(x, axis=1)[:, None]
    return system, state, x, np.cross([0.0, 0.0, 1.0], x) / np.linalg.norm(x, axis=1)[:, None] * 0.9


def test_results_depend_neither_on_threads_nor_on_neighbours():
    system, state, x, v = cloud(100)
    run = system.integrate(state, 24.0, dense=True)
    flights = [run.fly(fullbody.Particles(x, v), output=6.0, threads=threads) for threads in (1, 2, 3)]
    assert flights[0] == flights[1] == flights[2]
    assert system.fly(state, fullbody.Particles(x, v), 24.0, output=6.0) == flights[0]
    few = run.fly(fullbody.Particles(x[40:43], v[40:43]), output=6.0)
    np.testing.assert_array_equal(few.position, flights[0].position[:, 40:43])


def test_particles_return_to_their_start():
    system, state, x, v = cloud(20)
    run = system.integrate(state, 24.0, dense=True)
    forward = run.fly(fullbody.Particles(x, v), output="ends")
    fly = forward.fate == "flying"
    assert fly.sum() > 5
    last = fullbody.Particles(forward.last_position[fly], forward.last_velocity[fly])
    back = run.fly(last, 0.0, output="ends", start=24.0)
    assert np.abs(back.position[-1] - x[fly]).max() < 1e-8
    # A run that itself goes backwards leads to the same end.
    end = run[-1]
    reverse = system.integrate(end, 0.0, dense=True).fly(last, output="ends")
    assert np.abs(reverse.position[-1] - x[fly]).max() < 1e-8


def test_third_bodies_move_particles_as_they_move_bodies():
    system, state = fullbody.systems.kw4()
    orbit = fullbody.KeplerElements(a=95.7e6, e=0.69, i=0.68, Omega=4.29, omega=3.37, M=0.0)
    sunlit = system.with_forces([fullbody.forces.ThirdBody(mass=1.98841e30, orbit=orbit, of="system", name="Sun")])
    particles = fullbody.Particles([[9.0, 3.0, 2.0]], [[0.0, 0.5, 0.1]])
    expected = flown_as_bodies(sunlit, state, particles, 200.0, mass=1e-18)[0]
    result, without = (s.fly(state, particles, 200.0, output="ends").position[-1] for s in (sunlit, system))
    assert np.abs(result - expected).max() < 1e-9 < 1e-4 < np.abs(without - expected).max()


def test_particles_feel_composites_polyhedra_and_ellipsoids():
    ellipsoid = fullbody.Ellipsoid(1.0, 0.8, 0.6)
    parts = [fullbody.Part(ellipsoid, mass=0.5, position=(x, 0.0, 0.0)) for x in (-1.2, 1.2)]
    bodies = [
        fullbody.Body(fullbody.Composite(parts), name="A"),
        fullbody.Body(box(1.0, 1.0, 1.0), mass=0.4, name="B"),
        fullbody.Body(fullbody.Ellipsoid(1.1, 0.9, 0.6), mass=0.3, name="C"),
    ]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State(
        position=[[-1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, -6.0, 1.0]],
        velocity=[[0.0, -0.1, 0.0], [0.0, 0.3, 0.0], [0.3, 0.0, 0.0]],
        spin=[[0.1, 0.0, 0.3], [0.0, 0.2, 0.1], [0.1, 0.2, 0.3]],
    )
    particles = fullbody.Particles([[1.0, 3.5, 0.0]], [[-0.5, 0.0, 0.1]])
    expected = flown_as_bodies(system, state, particles, 5.0, mass=1e-12)[0]
    assert np.abs(system.fly(state, particles, 5.0, output="ends").position[-1] - expected).max() < 1e-10


def test_instructions_and_charts_change_round_off_alone():
    system, state, x, v = cloud(40)
    particles = fullbody.Particles(x, v)
    expected = system.fly(state, particles, 6.0, output="ends")
    variants = [{"vector_path": path} for path in fullbody.vector_paths()] + [{"attitude_chart": "tait_bryan"}]
    for options in variants:
        result = system.with_options(**options).fly(state, particles, 6.0, output="ends")
        assert result.fate.tolist() == expected.fate.tolist()
        np.testing.assert_allclose(result.position, expected.position, rtol=0.0, atol=1e-9)


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state, "30 hour", dense=True)


def thrown(run, state):
    options = {"longitude": "10 deg", "latitude": "5 deg", "speed": "0.1 m/s"}
    return [
        Particles.from_surface(run.system, state, "Beta", **options),
        Particles.ejecta(run.system, state, "Beta", **options, n=3),
    ]


def test_a_flight_starts_at_the_time_of_its_particles(run):
    later = run("7.3 hour")
    assert repr(thrown(run, later)[1]) == "Particles(3 particles at time 7.3 h)"
    for particles in thrown(run, later):
        assert particles.time == 7.3 * u.hour
        flight = run.fly(particles, output="ends")
        assert flight.time[0] == 7.3 * u.hour
        np.testing.assert_array_equal(flight.position[0], particles.position)
        assert flight == run.fly(particles, output="ends", start="438 min")
        assert (run.system.fly(later, particles, "30 hour", output="ends").fate == flight.fate).all()


def test_a_flight_of_particles_of_another_time_is_refused(run):
    for particles in thrown(run, run("7.3 hour")):
        with pytest.raises(InvalidInput, match=r"particles have the time 7.3 h, but the flight starts at 0 h"):
            run.system.fly(run[0], particles, "30 hour")
        refused(r"particles have the time 7.3 h, but the flight starts at 8 h", run.fly, particles, start="8 hour")
        anywhen = Particles(particles.position, particles.velocity)
        assert anywhen.time is None
        assert anywhen != particles
        assert run.fly(anywhen, output="ends", start="7.3 hour") == run.fly(particles, output="ends")
    refused("time of particles is nan", lambda: Particles([[3.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]], time=np.nan))


@pytest.fixture(scope="module")
def flight():
    system, state = fullbody.systems.kw4(units=True)
    x = np.array([[4.0, 0.0, 0.0], [2.9, 0.0, 0.3], [0.0, 1.2, 0.0]])
    particles = fullbody.Particles(x, [[0.0, 0.0, 0.8], [0.0, 3.0, 0.0], [0.0, 0.0, 0.0]])

    def height(time, position, velocity):
        return position[2] - 0.1

    events = [ParticlePeriapsis("Alpha"), ParticleFunction(height)]
    return system.fly(state, particles, 10.0, output=5.0, escape=EscapeDistance(8.0), events=events)


def test_the_repr_of_a_flight_has_its_fates(flight):
    assert flight.fate.tolist() == ["flying", "escape", "impact"]
    assert repr(flight) == "Flight(3 particles, 3 samples: 1 flying, 1 impact, 1 escape)"
    assert flight.counts == {"flying": 1, "impact": 1, "escape": 1}
    assert "impact on Alpha" in flight._repr_html_()
    assert str(flight.speed.unit) == "km / h"
    assert {type(e.event).__name__ for e in flight.events} == {"ParticlePeriapsis", "ParticleFunction"}
    assert len(fullbody.Particles(np.eye(3), np.eye(3))) == 3


def test_a_saved_flight_equals_the_original(flight, tmp_path):
    path = tmp_path / "flight.nc"
    flight.save(path)
    again = fullbody.load_flight(path)
    assert again == flight
    assert again.system.names == ("Alpha", "Beta")
    np.testing.assert_array_equal(again.position, flight.position)
    assert [e.time for e in again.events] == [e.time for e in flight.events]
    refused("load_flight", lambda: fullbody.load(path))
    refused(r"\.nc", lambda: flight.save(tmp_path / "flight.txt"))


def test_a_damaged_file_is_refused(flight, tmp_path):
    path = tmp_path / "flight.nc"
    flight.save(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    refused("readable flight", lambda: fullbody.load_flight(path))


def test_a_file_with_an_event_of_no_particle_is_refused(flight, tmp_path):
    data = flight.to_xarray()
    data["event_particle"][-1] = 3
    data.to_netcdf(tmp_path / "flight.nc", engine="h5netcdf")
    refused("particles of occurrences are not all from 0 to 2", lambda: fullbody.load_flight(tmp_path / "flight.nc"))


def test_a_dataset_of_a_flight_has_names_and_units(flight):
    data = flight.to_xarray()
    assert data.position.dims == ("time", "particle", "axis")
    assert data.position.attrs["units"] == "km"
    assert data.fate.attrs["flag_meanings"].split()[int(data.fate[2])] == "impact"
