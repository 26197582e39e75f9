"""Quantities at the boundary: in any unit in, in the system's units out, and the numbers are those without units."""

import pickle

import fullbody
import numpy as np
import pytest
from astropy import constants
from astropy import units as u
from astropy.time import Time
from fullbody.errors import InvalidInput
from support import refused, refused_with, worst

KM_H_KG = ("km", "hour", "kg")
PER_H = u.rad / u.hour


def test_system_with_units_gives_the_same_numbers():
    (system, state), (unitless, start) = fullbody.systems.kw4_ho2021(units=True), fullbody.systems.kw4_ho2021()
    assert np.array_equal(state.position.value, start.position)
    # Plain numbers are in the system's units.
    for initial in (state, start):
        assert np.array_equal(system.interactions(initial).force.value, unitless.interactions(start).force)
    run = system.integrate(state, 30 * u.hour, output=10 * u.hour)
    bare = unitless.integrate(start, 30.0, output=10.0)
    for name in ("time", "position", "velocity", "spin", "energy", "angular_momentum"):
        assert np.array_equal(getattr(run, name).value, getattr(bare, name)), name
    assert np.array_equal(run.attitude, bare.attitude)
    assert np.array_equal(run.energy_drift, bare.energy_drift)


def test_gravitational_constant_is_astropys():
    bodies = fullbody.systems.kw4_ho2021(units=True)[0].bodies
    default = fullbody.System(bodies, units=KM_H_KG).G
    assert (default / constants.G).to_value(u.one) == pytest.approx(1.0, rel=1e-15)
    assert fullbody.System(bodies, units=("AU", "yr", "solMass")).G.value == pytest.approx(4 * np.pi**2, rel=1e-3)
    constant = fullbody.System(bodies, G=6.67408e-11 * u.m**3 / u.kg / u.s**2, units=KM_H_KG)
    assert constant.G.value / 8.64960768e-13 == pytest.approx(1.0, rel=1e-15)


def test_mixed_units_are_converted():
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(766 * u.m, 0.7475 * u.km, 67350 * u.cm), mass=2.353e9 * u.t, name="Alpha"),
        fullbody.Body(fullbody.Ellipsoid(0.285, 0.2315, 0.1745), mass=135e6 * u.t, name="Beta"),
    ]
    system, state = fullbody.systems.kw4_ho2021(units=True)
    mixed = fullbody.System(bodies, G=system.G.to(u.m**3 / u.kg / u.s**2), units=KM_H_KG)
    other = fullbody.State(
        state.position.to(u.m), state.velocity.to(u.m / u.s), state.attitude, state.spin.to(u.deg / u.s), 0 * u.day
    )
    assert worst(mixed.interactions(other).force.value, system.interactions(state).force.value) < 1e-14
    run = mixed.integrate(other, 1 * u.day, output=6 * u.hour)
    expected = system.integrate(state, 24.0, output=6.0)
    assert run.time.unit == u.hour
    assert np.array_equal(run.time.value, [0, 6, 12, 18, 24])
    assert np.abs(run.position - expected.position).max() < 1e-11 * u.km
    assert np.abs(run.spin - expected.spin).max() < 1e-12 * PER_H


def test_differences_of_dates_are_times():
    start = Time("2026-12-01T00:00:00", scale="tdb")
    system, state = fullbody.systems.kw4(units=True, epoch=start)
    shifted = Time("2026-12-01T06:00:00", scale="tdb")
    run = system.integrate(state, shifted - system.epoch, output=start + [0, 3, 6] * u.hour - system.epoch)
    assert run.time.to_value(u.hour) == pytest.approx([0.0, 3.0, 6.0], abs=1e-12)
    refused(r"until is the date 2026-12-01.*such as date - system\.epoch", lambda: system.integrate(state, shifted))
    refused("output is the date", lambda: system.integrate(state, 6.0, output=[start, shifted]))


def test_quantities_into_a_system_without_units_are_refused():
    system, state = fullbody.systems.case1()
    kilometres = fullbody.State([[0, 0, 0], [9, 0, 0]] * u.km, np.zeros((2, 3)) * u.km / u.s)
    ball = fullbody.Body(fullbody.Sphere(1 * u.km), mass=1.0, name="Alpha")
    for call, words in (
        (lambda: system.integrate(state, 1 * u.hour), "until ... h ... the system has no units"),
        (lambda: system.integrate(state, 1.0, output=1 * u.hour), "output ... h ... the system has no units"),
        (lambda: system.interactions(kilometres), "position ... km ... the system has no units"),
        (lambda: fullbody.System([ball], G=1.0), "semi-axis ... Alpha ... km ... the system has no units"),
        (lambda: fullbody.System(system.bodies, G=constants.G), "G ... m3 / (kg s2) ... the system has no units"),
    ):
        refused_with(words, call)


def test_errors_for_numbers_without_units_beside_quantities_name_both():
    mixed = fullbody.Body(fullbody.Sphere(1 * u.km), mass=1.0, name="Alpha")
    unitless = fullbody.Body(fullbody.Sphere(1.0), mass=1.0)
    with_units = fullbody.Body(fullbody.Sphere(1 * u.km), mass=1 * u.kg)
    mu, r, v = 1 * u.km**3 / u.s**2, [1, 0, 0] * u.km, [0, 1, 0] * u.km / u.s
    orbit = fullbody.KeplerElements(1 * u.km, 0, 0, 0, 0, 0)
    for call, words in (
        (lambda: mixed.inertia, "semi-axis a has the unit km ... mass of Alpha has none"),
        (lambda: mixed.density, "semi-axis a has the unit km ... mass of Alpha has none"),
        (lambda: fullbody.Body(fullbody.Sphere(1 * u.km), density=2.0).mass, "axis a has ... density"),
        (lambda: fullbody.Ellipsoid(0.5 * u.km, 0.4, 0.3), "semi-axis a has the unit km ... semi-axis b has none"),
        (lambda: fullbody.Ellipsoid(0.5, 0.4, "0.3 km"), "semi-axis c has the unit km ... semi-axis a has none"),
        (lambda: unitless.gravity([2, 0, 0] * u.km).potential, "points has the unit km ... semi-axis a has none"),
        (lambda: mixed.gravity([2, 0, 0] * u.km).field, "points has the unit km ... mass of Alpha has none"),
        (lambda: with_units.gravity([2, 0, 0], 1.0).potential, "semi-axis a has the unit km ... points has none"),
        (lambda: with_units.gravity([2, 0, 0] * u.km, 1.0).potential, "points has the unit km ... G has none"),
        (lambda: unitless.gravity([2, 0, 0]).potential, "G is not given"),
        (lambda: orbit.to_cartesian(1.0), "a has the unit km ... mu has none"),
        (lambda: fullbody.KeplerElements(1, 0, 0, 0, 0, 0).period(mu), "mu has the unit km3 / s2 ... a has none"),
        (lambda: fullbody.KeplerElements.from_cartesian(r, [0, 1, 0], mu), "r has the unit km ... v has none"),
        (lambda: fullbody.KeplerElements.from_cartesian([1, 0, 0], v, 1.0), "v has the unit km / s ... r has none"),
        (lambda: fullbody.KeplerElements.from_cartesian(r, v, 1.0), "r has the unit km ... mu has none"),
    ):
        refused_with(words, call)
    # Its system knows, and its table leaves out what it cannot tell.
    assert fullbody.System([mixed], units=KM_H_KG).masses[0] == 1 * u.kg
    assert "density" not in mixed._repr_html_()
    assert "density" in with_units._repr_html_()


def test_parts_of_a_state_have_units_all_or_none():
    r, v = [[0, 0, 0], [9, 0, 0]], [[0, 0, 0], [0, 2, 0]]
    speed = u.km / u.hour
    with_units = fullbody.State(r * u.km, v * speed, spin=[[0, 0, 1]] * 2 * u.rad / u.hour, time=3 * u.hour)
    for position, velocity, words in (
        (r * u.km, v, "position has the unit km, but velocity has none"),
        (r, v * speed, "velocity has the unit km / h, but position has none"),
    ):
        for make in (
            lambda r, v: fullbody.State(r, v),
            lambda r, v: fullbody.State.from_tait_bryan(r, v, np.zeros((2, 3))),
            lambda r, v: fullbody.State(with_units.position, with_units.velocity).replace(position=r, velocity=v),
        ):
            refused(words, lambda make=make, position=position, velocity=velocity: make(position, velocity))
    for name, value in (("spin", [[0, 0, 2e-4]] * 2), ("time", 3.0)):
        refused(
            f"position has the unit km, but {name} has none", lambda change={name: value}: with_units.replace(**change)
        )
    refused("spin has the unit rad / h, but position has none", lambda: fullbody.State(r, v, spin=with_units.spin))
    # Zeros are zeros in any unit; attitudes have none.
    motionless = fullbody.State(r * u.km, np.zeros((2, 3)), spin=np.zeros((2, 3)), time=0.0)
    assert motionless.position[1, 0] == 9 * u.km
    assert fullbody.State([[0, 0, 0]], [[0, 1, 0]] * speed).velocity[0, 1] == 1 * speed


def test_bodies_of_a_system_with_units_have_them():
    # Beta's volume is 4/3 pi 0.285 0.2315 0.1745 km^3, in which 0.135e12 kg make 2799.3 kg/m^3.
    made = [
        fullbody.Body(fullbody.Ellipsoid(0.285, 0.2315, 0.1745), mass=0.135e12, name="Beta"),
        fullbody.Body(fullbody.Sphere(300 * u.m), density=2e12, name="mixed"),
        fullbody.Body(fullbody.Sphere(1 * u.m), mass=1 * u.t, name="whole"),
        fullbody.Body(fullbody.PointMass(), mass=7),
    ]
    system = fullbody.System(made, units=KM_H_KG)
    beta, mixed, with_units, point = system.bodies
    assert beta.shape == fullbody.Ellipsoid(0.285 * u.km, 0.2315 * u.km, 0.1745 * u.km)
    assert beta.mass == 0.135e12 * u.kg
    assert beta.density.to_value(u.kg / u.m**3) == pytest.approx(2799.3, rel=1e-4)
    assert beta.inertia.unit == u.kg * u.km**2
    assert "kg" in beta._repr_html_()
    assert mixed.density.to_value(u.g / u.cm**3) == pytest.approx(2.0, rel=1e-15)
    assert mixed.mass.to_value(u.kg) == pytest.approx(2000 * 4 / 3 * np.pi * 300**3, rel=1e-14)
    assert with_units == made[2]
    assert point.mass == 7 * u.kg
    assert (beta.name, point.name) == ("Beta", None)
    # The bodies that went in are unchanged; a system without units keeps the same objects.
    assert made[0].mass == 0.135e12
    assert not isinstance(made[0].shape.a, u.Quantity)
    assert fullbody.System(made[:1], G=1.0).bodies[0] is made[0]
    # Once more through it nothing changes.
    assert fullbody.System(system.bodies, units=KM_H_KG) == system
    assert system.with_options(gravity="point").bodies == system.bodies
    assert pickle.loads(pickle.dumps(system)).bodies == system.bodies
    np.testing.assert_allclose(system.masses.value, [0.135e12, 2e12 * 4 / 3 * np.pi * 0.3**3, 1000.0, 7.0], rtol=1e-14)


def test_exterior_gravity_has_units_and_newtons_numbers():
    moon = fullbody.Body(fullbody.Sphere(1737.4 * u.km), mass=7.342e22 * u.kg)
    distance = 1737.4e3
    potential = moon.gravity([[0, 0, 1737.4], [1737.4, 0, 0]] * u.km).potential
    np.testing.assert_allclose(potential.to_value(u.m**2 / u.s**2), constants.G.value * 7.342e22 / distance, rtol=1e-14)
    field = moon.gravity([0, 0, distance] * u.m, G=constants.G.to(u.km**3 / u.t / u.day**2)).field
    assert field.unit == u.m / u.day**2
    np.testing.assert_allclose(field[2].to_value(u.m / u.s**2), -constants.G.value * 7.342e22 / distance**2, rtol=1e-14)


def test_pure_numbers_have_no_unit():
    for call, what in (
        (lambda: fullbody.State([[0, 0, 0]], [[0, 0, 0]], attitude=[[1, 0, 0, 0]] * u.kg), "attitude has the unit kg"),
        (lambda: fullbody.KeplerElements(1.0, 5 * u.deg, 0, 0, 0, 0), "e has the unit deg"),
        (lambda: fullbody.Component(diameter=1.0, axis_ratios=(1, 1) * u.m), "axis_ratios of .* has the unit m"),
    ):
        refused(f"{what}; expected pure numbers", call)
    assert fullbody.KeplerElements(1.0, 20 * u.percent, 0, 0, 0, 0).period(1.0) == pytest.approx(2 * np.pi)


def test_texts_are_read_as_quantities():
    system, state = fullbody.systems.kw4(units=True)
    assert system.integrate(state, "0.5 day", output="6 hour").time.value.tolist() == [0, 6, 12]
    with pytest.raises(InvalidInput, match="until has the unit d, but the system has no units"):
        fullbody.systems.case1()[0].integrate(fullbody.systems.case1()[1], "1 day")
    for text, unknown in (("later", ""), ("1 parsnip", ", whose unit 'parsnip' is not known"), ("", "")):
        what = f"until is '{text}'{unknown}; expected a finite number, or text with a unit, such as '2.5 h'"
        refused(what, lambda text=text: system.integrate(state, text))
    refused(r"until is '10', which has no unit; .*'10 h', or a number", lambda: system.integrate(state, "10"))
    with pytest.raises(InvalidInput, match=r"position is '1', which has no unit; .*'1 km', or a num"):
        fullbody.State(position=[["1", 0, 0]], velocity=[[0, 0, 0]])


def test_times_are_read_as_people_write_them():
    system, state = fullbody.systems.kw4(units=("km", "s", "kg"), gravity="point")
    for text, seconds in {
        **{"30 days": 30 * 86400, "2 weeks": 14 * 86400, "3 hrs": 10800, "5 hours": 18000, "1 hour": 3600},
        **{"1 year": 31557600, "2 years": 63115200, "90 minutes": 5400, "90 mins": 5400, "10 secs": 10},
    }.items():
        shifted = state.replace(time=text)
        assert shifted.time.to_value(u.s) == pytest.approx(seconds, rel=1e-15)
    assert system.integrate(state, "3 hrs", output="ends").time[-1].value == pytest.approx(10800, rel=1e-15)


def test_texts_that_are_no_times_are_refused():
    system, state = fullbody.systems.kw4(units=True)
    # A month has no fixed length; M is mega, and 10 m are metres.
    for text, what in (
        ("1 month", "until is '1 month', whose unit 'month' is not known; expected .*'2.5 h'"),
        ("10 m", "until has the unit m"),
    ):
        refused(what, lambda text=text: system.integrate(state, text))
    # Units that the package understands are not registered for the rest of the process.
    with pytest.raises(ValueError, match="days"):
        u.Unit("days")


def test_elements_without_units_take_those_of_the_mu_of_a_system():
    system, _ = fullbody.systems.kw4(units=("km", "day", "kg"))
    unitless, with_units = (fullbody.KeplerElements(a, 0.1, 0.2, 0.3, 0.4, 0.5) for a in (2.5, 2.5 * u.km))
    mu = system.mu()
    for (r, v), (expected_r, expected_v) in (
        (unitless.to_cartesian(mu), with_units.to_cartesian(mu)),
        (unitless.to_cartesian(system.mu("Beta", "Alpha")), with_units.to_cartesian(mu.to(u.km**3 / u.day**2))),
    ):
        assert (r.unit, v.unit) == (u.km, u.km / u.day)
        assert (r == expected_r).all()
        assert (v == expected_v).all()
    assert unitless.period(mu) == with_units.period(mu)
    assert fullbody.KeplerElements.from_cartesian(r.value, v.value, mu).a.to_value("km") == pytest.approx(2.5)
    # Elements in metres give metres, although mu is in kilometres.
    assert fullbody.KeplerElements(2500 * u.m, 0.1, 0.2, 0.3, 0.4, 0.5).to_cartesian(mu)[0].unit == u.m
    for other in (1 * mu, mu.to(u.au**3 / u.yr**2), 3.0 * u.km**3 / u.s**2):
        refused(r"mu has the unit .*, but a has none; expected both", lambda other=other: unitless.to_cartesian(other))
    refused("v has the unit km / d, but r has none", lambda: fullbody.KeplerElements.from_cartesian(r.value, v, mu))


def test_semi_axes_with_units_are_one_quantity():
    axes = fullbody.Ellipsoid(2 * u.km, 1500 * u.m, "0.5 km").semi_axes
    assert type(axes) is u.Quantity
    assert axes.unit == u.km
    assert np.allclose(axes.value, [2.0, 1.5, 0.5], rtol=1e-15)
    assert (fullbody.Sphere(3 * u.m).semi_axes == [3, 3, 3] * u.m).all()
    assert fullbody.Ellipsoid(3, 2, 1).semi_axes == (3, 2, 1)
    component = fullbody.Component(semi_axes=[3 * u.km, 2 * u.km, 1 * u.km])
    assert (component.semi_axes == [3, 2, 1] * u.km).all()


def test_units_that_do_not_exist_are_refused():
    bodies = fullbody.systems.kw4()[0].bodies
    for units, what in (
        (("km", "houres", "kg"), "units has 'houres', which is not a unit; did you mean 'hour'?"),
        (("km", "hour", "kgx"), "units has 'kgx', which is not a unit; did you mean 'kg'?"),
        (("xyz", "hour", "kg"), "units has 'xyz', which is not a unit; expected"),
        (("hour", "km", "kg"), "units has 'h'; expected a unit of length"),
        ((1e-70 * u.km, "hour", "kg"), "units has <Quantity 1.e-70 km>, which is not a unit"),
        (("km", "hour"), r"units is \('km', 'hour'\); expected \(length, time, mass\)"),
    ):
        refused(what, lambda units=units: fullbody.System(bodies, units=units))
    assert fullbody.System(bodies, units=True) == fullbody.System(bodies, units=("km", "hour", "kg"))
    assert fullbody.System(bodies, G=1.0, units=False).units is None
    assert fullbody.System(bodies, G=1.0, units=np.False_).units is None
    assert fullbody.System(bodies, units=("kilometre", "hours", "kilograms")).units == ("km", "h", "kg")
    assert fullbody.System(bodies, units=np.True_).units == ("km", "h", "kg")


def test_times_outside_a_run_have_units():
    system, state = fullbody.systems.kw4(units=True, gravity="point")
    run = system.integrate(state, 10.0, dense=True)
    for time in (1e5 * u.hour, [1.0, 1e5] * u.hour):
        refused(r"time is 100000.0 h; expected one from 0.0 h to 10.0 h", lambda time=time: run(time))


def test_texts_are_read_in_shapes_elements_and_states():
    assert fullbody.Sphere("2 km") == fullbody.Sphere(2 * u.km)
    assert fullbody.KeplerElements(1.0, 0, "30 deg", 0, 0, 0).i == 30 * u.deg
    mixed = fullbody.State(position=[["1 km", "0 m", "0 km"]], velocity=[[0, 0, 0]])
    assert mixed.position[0, 0] == 1 * u.km
    with pytest.raises(InvalidInput, match="position mixes Quantities and plain numbers"):
        fullbody.State(position=[["1 km", 0, 0]], velocity=[[0, 0, 0]])


def test_lists_of_quantities_keep_their_units():
    r = np.array([1200.0, 0.0, 0.0]) * u.m
    state = fullbody.State(position=[0 * r, r], velocity=[[0 * u.km / u.h] * 3, [0 * u.m / u.s] * 3])
    assert state.position[1, 0] == 1.2 * u.km
    mixed = fullbody.State(position=[[0, 0, 0] * u.km, r], velocity=np.zeros((2, 3)))
    assert mixed.position[1, 0].to_value(u.m) == pytest.approx(1200.0, rel=1e-15)
    with pytest.raises(InvalidInput, match=r"position mixes Quantities and plain numbers"):
        fullbody.State(position=[[0, 0, 0], r], velocity=np.zeros((2, 3)))
    for unit in (u.Hz, u.mHz, u.kHz, u.Bq, u.s**-1):
        with pytest.raises(InvalidInput, match=rf"spin has the unit {unit}, which may count turns; expected an an"):
            fullbody.State(position=np.zeros((1, 3)), velocity=np.zeros((1, 3)), spin=[[0, 0, 1]] * unit)
    # Turns are angles.
    for unit, rate in ((u.cycle / u.s, 2 * np.pi), (u.deg / u.s, np.pi / 180)):
        state = fullbody.State(np.zeros((1, 3)) * u.km, np.zeros((1, 3)), spin=[[0, 0, 1]] * u.Unit(unit))
        assert state.spin[0, 2].to_value(u.rad / u.s) == pytest.approx(rate, rel=1e-15)
