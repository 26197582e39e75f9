"""Forces outside their range of validity raise a warning or an error instead of giving wrong numbers."""

import threading

import fullbody
import numpy as np
import pytest
from fullbody import forces
from fullbody.errors import ForceFailed
from support import refused
from support.scenes import differential, pair

POINTS = [fullbody.Body(fullbody.PointMass(), mass=mass, name=name) for mass, name in ((0.99, "A"), (0.01, "B"))]
SPHERES = [
    fullbody.Body(fullbody.Sphere(radius), mass=mass, name=name)
    for radius, mass, name in ((0.3, 0.99, "A"), (0.1, 0.01, "B"))
]


def table(first, last, count, point, mu=1e-3):
    times = np.linspace(first, last, count)
    return forces.ThirdBody(mu=mu, times=times, positions=[point(time) for time in times], of="body", name="bullet")


@pytest.mark.parametrize("gap", [1e-9, -1e-9, 1e-12, -1e-12, 1e-14, -1e-14])
def test_the_force_of_a_third_body_near_a_parabola_keeps_its_digits(gap):
    e = 1.0 - gap
    orbit = fullbody.KeplerElements(100.0 / (1.0 - e), e, 0.3, 0.4, 0.5, 0.0)
    comet = forces.ThirdBody(mu=1e4, orbit=orbit, of="body", name="comet")
    system = fullbody.System(POINTS, G=1.0, forces=[comet])
    for time in np.linspace(-40.0, 41.0, 13):
        state = fullbody.State(position=[[-0.01, 0, 0], [0.99, 0, 0]], velocity=np.zeros((2, 3)), time=time)
        expected = differential([0.99, 0, 0], system.third_body("comet", time)[0], 1e4)
        result = system.loads(state)["comet"].force[1] / 0.01
        assert np.linalg.norm(result - expected) < 1e-13 * np.linalg.norm(expected)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_yorp_that_stops_a_spin_ends_the_run_there(direction):
    """The spin ends at C spin / torque; it would turn over from step to step there."""
    system = fullbody.System(SPHERES, G=1.0, forces=[forces.Yorp("A", along=-direction * 1e-2, name="YORP")])
    state = pair()[1].replace(spin=[[0.0, 0.0, 3.0], [0.0, 0.0, 1.0]])
    stop = direction * 0.4 * 0.99 * 0.3**2 * 3.0 / 1e-2
    with pytest.raises(ForceFailed, match=r"YORP.*spin of A to a stop") as caught:
        system.integrate(state, 2.0 * stop, output=0.1)
    assert caught.value.force == "YORP"
    assert 0.0 <= (stop - caught.value.time) * direction < 1.0
    run = caught.value.run
    np.testing.assert_allclose(run.spin[:, 0, 2], 3.0 * (1.0 - run.time / stop), atol=1e-12)
    assert abs(run.energy_drift).max() < 1e-12
    system.integrate(state, 0.999 * stop)


def test_yorp_of_a_body_that_does_not_spin_is_refused():
    system = fullbody.System(SPHERES, G=1.0, forces=[forces.Yorp("A", along=1e-2)])
    state = pair()[1].replace(spin=[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for use in (system.loads, lambda state: system.integrate(state, 1.0)):
        with pytest.raises(ForceFailed, match="A does not spin"):
            use(state)


def test_each_thread_receives_its_own_error():
    def fail(time, state):
        raise ValueError(threading.current_thread().name)

    system = pair()[0].with_forces([forces.Function(fail)])
    wrong = []

    def use():
        for _ in range(30):
            with pytest.raises(ForceFailed) as caught:
                system.loads(pair()[1])
            cause = caught.value.__cause__
            if not isinstance(cause, ValueError) or cause.args != (threading.current_thread().name,):
                wrong.append(repr(caught.value))

    threads = [threading.Thread(target=use) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_an_error_without_a_message_is_named_by_its_class():
    def fail(time, state):
        return {}[0.5]

    with pytest.raises(ForceFailed, match=r"force fail at time .*: KeyError: 0\.5"):
        pair()[0].with_forces([forces.Function(fail)]).integrate(pair()[1], 1.0)


def test_loads_that_are_not_finite_are_refused():
    orbit = fullbody.KeplerElements(1e160, 0.3, 0.4, 1.0, 2.0, 0.3)
    system = pair()[0].with_forces([forces.ThirdBody(mu=1e6, orbit=orbit, of="system", name="Sun")])
    with pytest.raises(ForceFailed, match=r"Sun .*not finite"):
        system.loads(pair()[1])


def still(time, state):
    return 0.0 * state.position


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "'still'"),
        ([forces.Function(still, name="other", depends_on_velocity=False)], "'still'"),
        (forces.Function(still), "sequence of forces"),
        ([still], "forces has <function still"),
        ([forces.Function(still)], "depends_on_velocity of still is True; expected False"),
        ([forces.ThirdBody(mu=1.0, times=range(5), positions=np.ones((5, 3)), of="body", name="still")], "a ThirdBody"),
    ],
)
def test_a_simulation_from_a_file_requires_its_functions(tmp_path, arguments, words):
    system, state = pair()
    system = system.with_forces([forces.Function(still, depends_on_velocity=False)])
    fullbody.Simulation(system, state, integrator=fullbody.SymplecticSplitting(step=0.1)).save(tmp_path / "pair.sim")
    refused(words, lambda: fullbody.Simulation.load(tmp_path / "pair.sim", forces=arguments))


def test_lags_from_texts_and_from_inconsistent_rates():
    from astropy import units as u

    arguments = {"Q": 50.0, "tide": "semidiurnal"}
    lag = forces.lag_from_quality_factor(**arguments, mean_motion="20 deg / h", spin="2 deg / min")
    assert lag.unit == u.hour
    assert abs(lag.value * 50.0 * 2.0 * np.radians(100.0) - 1.0) < 1e-15
    lag = forces.lag_from_quality_factor(**arguments, mean_motion=20.0 * u.rad / u.hour, spin=-20.0 * u.rad / u.hour)
    assert abs(lag.to_value(u.s) - 3600.0 / 4000.0) < 1e-15
    unit = u.rad / u.hour
    for spin, rate in ((2.0, 0.3 * unit), (2.0 * unit, 0.3), ([0, 0, 2.0], 0.3), ("fast", 0.3), (np.nan, 0.3)):
        refused("spin", forces.lag_from_quality_factor, **arguments, mean_motion=rate, spin=spin)


@pytest.mark.parametrize("name", ["sun", "earth"])
def test_ephemerides_keep_their_digits_over_many_periods(name):
    """A first guess of the table's step that is a whole period sees no motion."""
    from astropy import units as u

    orbit = fullbody.KeplerElements(1.0 * u.au, 0.3, 0.1, 0.2, 0.3, 0.4)
    mu = 132712440041.279419 * u.km**3 / u.s**2
    period = (2.0 * np.pi * np.sqrt((1.0 * u.au) ** 3 / mu)).to(u.day)
    arguments = {"date": "2000-01-01 TDB", "orbit": orbit}
    system, _ = fullbody.systems.kw4(units=True, frame="ecliptic")
    points = []
    for count in (1, 16):
        body = forces.ThirdBody.from_ephemeris(name, duration=count * period, **arguments)
        points.append(system.with_forces([body]).third_body(body.name, np.linspace(0, 1, 20) * period)[0])
    distance = np.linalg.norm(points[0], axis=1)
    assert (np.linalg.norm(points[1] - points[0], axis=1) < 1e-8 * distance).all()
