"""Bad input is refused with the package's errors, which name the body or quantity, the value and what was expected."""

import inspect

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Body, Ellipsoid, KeplerElements, PointMass, Sphere, State, System, Verner98
from fullbody.errors import BodiesOverlap, InvalidInput, StepSizeTooSmall
from support import points

NAN, INF = float("nan"), float("inf")
POSITION = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
VELOCITY = [[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]]
BODIES = [Body(Sphere(1.0), mass=1.0, name="Alpha"), Body(Sphere(1.0), mass=1.0, name="Beta")]
SYSTEM = System(BODIES, G=1.0)
START = State(POSITION, VELOCITY)


def changed(**changes):
    return lambda: State(**{"position": POSITION, "velocity": VELOCITY, **changes})


def put(name, value, row=1, column=2):
    """A state with one component of a quantity replaced."""
    array = {"attitude": np.tile([1.0, 0, 0, 0], (2, 1)), "spin": np.zeros((2, 3))}.get(name)
    array = np.array({"position": POSITION, "velocity": VELOCITY}[name]) if array is None else array
    array[row, column] = value
    return changed(**{name: array})


def refused(call, *words):
    """The call raises InvalidInput, also a ValueError and a FullbodyError, with these words."""
    with pytest.raises(InvalidInput) as caught:
        call()
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, fullbody.FullbodyError)
    message = str(caught.value).lower()
    for word in words:
        assert str(word).lower() in message, message
    assert len(message) < 400


@pytest.mark.parametrize("value", [0.0, -1.5, NAN, INF, -INF, "wide", None, [1.0, 2.0], 1j])
def test_lengths_masses_and_densities(value):
    expected = "expected a finite number above zero"
    refused(lambda: Ellipsoid(1.0, value, 1.0), "semi-axis b", repr(value), expected)
    refused(lambda: Sphere(value), "radius", repr(value), expected)
    if value is not None:
        refused(lambda: Body(Sphere(1.0), mass=value, name="Alpha"), "mass", "Alpha", repr(value), expected)
        refused(lambda: Body(Sphere(1.0), density=value, name="Alpha"), "density", "Alpha", repr(value), expected)


def test_mass_or_density():
    refused(lambda: Body(Sphere(1.0), mass=1.0, density=1.0, name="Alpha"), "Alpha", "both", "expected one")
    refused(lambda: Body(Sphere(1.0), name="Alpha"), "Alpha", "neither", "expected one")
    refused(lambda: Body(PointMass(), density=2.0, name="Alpha"), "Alpha", "density", "2.0", "expected a mass")


def test_no_shape_no_name():
    refused(lambda: Body("round", mass=1.0, name="Alpha"), "shape", "Alpha", "'round'", "expected")
    refused(lambda: Body(Sphere(1.0), mass=1.0, name=3), "name", "3", "expected")


@pytest.mark.parametrize("value", [NAN, INF, -INF])
@pytest.mark.parametrize("name", ["position", "velocity", "attitude", "spin"])
def test_components_that_are_not_finite(name, value):
    refused(put(name, value), name, "body 1", "component 2", value, "expected a finite number")
    refused(put(name, value, row=0), name, "body 0", "component 2", value)


@pytest.mark.parametrize("value", [NAN, INF])
def test_time_and_angles_that_are_not_finite(value):
    refused(changed(time=value), "time", value, "finite")
    angles = [[0, 0, 0], [0, value, 0]]
    refused(lambda: State.from_tait_bryan(POSITION, VELOCITY, angles), "angles", "body 1", value, "finite")


def test_zero_quaternion():
    refused(changed(attitude=[[1, 0, 0, 0], [0, 0, 0, 0]]), "attitude", "body 1", "0, 0, 0, 0", "non-zero")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"position": [0, 0, 0]}, ["position", "[3]", "(N, 3)"]),
        ({"position": 5.0}, ["position", "(N, 3)"]),
        ({"position": None}, ["position"]),
        ({"position": [[0, 0], [1, 1]]}, ["position", "[2, 2]", "(N, 3)"]),
        ({"position": [[[0, 0, 0]]]}, ["position", "(N, 3)"]),
        ({"position": [[0, 0, 0], [1, 2]]}, ["position", "expected numbers"]),
        ({"position": "here"}, ["position", "'here'", "expected numbers"]),
        ({"position": [[1j, 0, 0], [5, 0, 0]]}, ["position", "expected numbers"]),
        ({"position": np.array([[1j, 0, 0], [5, 0, 0]])}, ["position", "1.j", "expected numbers"]),
        ({"position": np.array([[1j, 0, 0], [5, 0, 0]]) * u.km}, ["position", "1000.j", "expected numbers"]),
        ({"attitude": np.array([[1j, 0, 0, 0]] * 2) * u.percent}, ["attitude", "0.01j", "expected numbers"]),
        ({"velocity": [[0, 0, 0]]}, ["velocity", "1", "expected 2"]),
        ({"attitude": [[1, 0, 0], [1, 0, 0]]}, ["attitude", "[2, 3]", "(N, 4)"]),
        ({"attitude": [[1, 0, 0, 0]]}, ["attitude", "1", "expected 2"]),
        ({"spin": [[0, 0, 0]] * 3}, ["spin", "3", "expected 2"]),
        ({"spin": "fast"}, ["spin", "'fast'", "expected numbers"]),
        ({"time": [0.0, 1.0]}, ["time", "(2,)", "single number"]),
    ],
)
def test_wrong_shapes(changes, words):
    refused(changed(**changes), *words)


def test_wrong_shape_of_angles():
    refused(lambda: State.from_tait_bryan(POSITION, VELOCITY, [[0, 0]] * 2), "angles", "[2, 2]", "(N, 3)")


def test_number_of_bodies():
    three = State([*POSITION, [9, 9, 9]], [*VELOCITY, [0, 0, 0]])
    for call in (SYSTEM.interactions, SYSTEM.energy, SYSTEM.momentum, SYSTEM.angular_momentum):
        refused(lambda call=call: call(three), "bodies", "3", "expected 2")
    refused(lambda: SYSTEM.integrate(three, 1.0), "bodies", "3", "expected 2")
    refused(lambda: System([], G=1.0), "bodies", "0", "at least one")
    refused(lambda: System([BODIES[0], "Beta"], G=1.0), "bodies", "'Beta'", "Body")
    refused(lambda: System(3, G=1.0), "bodies", "3", "Body")
    refused(lambda: State(np.zeros((0, 3)), np.zeros((0, 3))), "position")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"gravity": "magic"}, ["gravity", "magic", "surface", "focal", "multipole", "point"]),
        ({"gravity": "multipole:1"}, ["gravity", "multipole:1", "2 to 60"]),
        ({"gravity": "multipole:x"}, ["gravity", "multipole:x"]),
        ({"gravity": "multipole:100"}, ["gravity", "multipole:100", "60"]),
        ({"gravity": 3}, ["gravity is 3; expected text"]),
        ({"attitude_chart": "euler"}, ["attitude_chart", "euler", "quaternion", "tait_bryan"]),
        ({"vector_path": "sse"}, ["vector_path", "sse", "auto", "portable"]),
        ({"vector_path": None}, ["vector_path is None; expected text"]),
        ({"gravity_tolerance": -1e-14}, ["gravity_tolerance", "expected"]),
        ({"gravity_tolerance": 0.0}, ["gravity_tolerance", "0", "expected"]),
        ({"gravity_tolerance": NAN}, ["gravity_tolerance", "nan"]),
        ({"gravity_tolerance": "1e-3x"}, ["gravity_tolerance is '1e-3x'", "expected a number such as 1e-14"]),
        ({"order": (0, 8)}, ["order", "(0, 8)", "expected"]),
        ({"order": (-1, 8)}, ["order is (-1, 8); expected (n, m), whole numbers"]),
        ({"order": (10**9, 8)}, ["order", "1000000000", "expected"]),
        ({"order": (10**30, 8)}, ["order is (1000000000000000000000000000000, 8); expected (n, m)"]),
        ({"order": (4.5, 8)}, ["order is (4.5, 8); expected (n, m), whole numbers"]),
        ({"order": 8}, ["order is 8; expected (n, m), whole numbers"]),
        ({"G": NAN}, ["G is", "nan", "finite"]),
        ({"G": INF}, ["G is", "inf", "finite"]),
        ({"G": -1.0}, ["G is", "-1", "zero or above"]),
        ({"G": "Newton"}, ["G is", "'Newton'"]),
        ({"G": [1.0]}, ["G", "(1,)", "expected a finite number"]),
        ({"G": None}, ["G is not given", "expected"]),
        ({"units": ("km", "hour")}, ["units", "('km', 'hour')", "expected (length, time, mass)"]),
        ({"units": ("km", "kg", "hour")}, ["units", "'kg'", "unit of time"]),
        ({"units": ("km", "hour", "parrot")}, ["units", "parrot"]),
        ({"units": 3}, ["units", "3"]),
    ],
)
def test_options_of_a_system(options, words):
    refused(lambda: System(BODIES, **{"G": 1.0, **options}), *words)


def test_an_order_may_be_a_list_or_numbers_of_numpy():
    assert System(BODIES, G=1.0, order=[8, np.int64(16)]).options["order"] == (8, 16)


@pytest.mark.parametrize(
    ("period", "words"),
    [
        (1 * u.km, ["has the unit km; expected a unit such as s"]),
        ("1 km", ["has the unit km"]),
        (NAN, ["is nan; expected a time other than zero"]),
        (0, ["is 0; expected a time other than zero"]),
        (0 * u.hour, ["is <Quantity 0. h>; expected a time other than zero"]),
        ([1.0, 2.0], ["(2,)", "expected a time other than zero"]),
        ("soon", ["'soon'", "'2.5 h'"]),
    ],
)
def test_rotation_periods_of_a_component(period, words):
    refused(lambda: fullbody.Component(diameter=1, rotation_period=period, name="Moon"), "_period of Moon", *words)


def test_angles_of_a_component():
    for name in ("tilt", "rotation_angle"):
        for value, what in ((NAN, "is nan; expected a finite"), (1 * u.km, "has the unit km; expected a unit such")):
            refused(lambda n=name, v=value: fullbody.Component(diameter=1, **{n: v}), f"{name} of a component {what}")
    for period in (INF, -INF, -3.0, "-2 h", 5 * u.min):
        fullbody.Component(diameter=1, rotation_period=period)


def test_options_that_do_not_exist():
    kept = "'gravty' is not an option of with_options, which keeps bodies, G and units; did you mean 'gravity'? "
    refused(lambda: SYSTEM.with_options(gravty="point"), kept + "expected some of gravity, ")
    for make in (fullbody.systems.kw4, fullbody.systems.case1, fullbody.systems.didymos):
        refused(lambda make=make: make(gravty="point"), "'gravty'", "did you mean 'gravity'? expected some of gravity")
    refused(lambda: fullbody.systems.didymos(epoch="2022-09-26 TDB"), "epoch is '2022-09-26 TDB'; expected none")
    refused(lambda: START.replace(positon=POSITION), "'positon'", "did you mean 'position'?", "velocity, attitude")
    # What inspect and the editors see is the function itself.
    assert "gravity_tolerance" in inspect.signature(System).parameters


def test_which_number_is_mu():
    run = SYSTEM.integrate(START, 1.0)
    with pytest.raises(TypeError, match="positional"):
        run.elements(2.0, 0, 1)
    assert run.elements(2.0) == run.elements(mu=2.0, body=1, about=0) == run.elements()
    refused(lambda: run.elements(about="Alfa"), "about is 'Alfa'; did you mean 'Alpha'? expected one of Alpha, Beta")


@pytest.mark.parametrize("value", [-1e-13, NAN, INF, 1.0, "small", None, True])
@pytest.mark.parametrize("name", ["rtol", "atol"])
def test_tolerances(name, value):
    refused(lambda: Verner98(**{name: value}), name, repr(value), "expected a number")


def test_both_tolerances_zero():
    """To Verner98 they mean the shortest steps that are of use."""
    refused(lambda: fullbody.Verner87(rtol=0.0, atol=0), "rtol and atol", "0", "expected")
    assert Verner98(rtol=0.0, atol=0) == Verner98.to_roundoff()


@pytest.mark.parametrize("value", ["rk4", "verner98", Verner98, 3])
def test_unknown_integrator(value):
    refused(lambda: SYSTEM.integrate(START, 1.0, integrator=value), "integrator", repr(value), "Verner98")


@pytest.mark.parametrize("value", [NAN, INF, -INF, "later", None, [1.0, 2.0], 1j])
def test_until(value):
    refused(lambda: SYSTEM.integrate(START, value), "until", "expected")


@pytest.mark.parametrize(
    ("output", "words"),
    [
        (NAN, ["nan", "spacing above zero"]),
        (INF, ["inf", "spacing above zero"]),
        (0.0, ["0", "spacing above zero"]),
        (-1.0, ["-1", "spacing above zero"]),
        (1e-300, ["until is 1.0", "1e-300", "at most"]),
        ("often", ["'often'", "expected"]),
        ([0.0, NAN], ["nan", "finite"]),
        ([0.5, 0.2], ["0.5", "0.2", "direction"]),
        ([0.5, 0.5], ["0.5", "twice"]),
        ([-1.0, 0.5], ["-1", "from 0 to 1"]),
        ([0.5, 2.0], ["2", "from 0 to 1"]),
        ([[0.0, 1.0]], ["(1, 2)", "(K,)"]),
    ],
)
def test_output(output, words):
    refused(lambda: SYSTEM.integrate(START, 1.0, output=output), "output", *words)


def test_an_end_that_is_too_far_for_a_spacing_is_named_beside_it():
    refused(lambda: SYSTEM.integrate(START, 1e300, output=0.1), "until", "1e+300", "output is 0.1", "samples; expected")


def test_not_a_state_not_a_system():
    refused(lambda: SYSTEM.integrate("here", 1.0), "state", "'here'", "State")
    refused(lambda: SYSTEM.interactions(3), "state", "3", "State")
    refused(lambda: fullbody.Simulation("S", START), "system", "'S'", "System")


def test_places_of_bodies_that_do_not_exist():
    run = SYSTEM.integrate(START, 1.0)
    refused(lambda: SYSTEM.mu(0, 7), "about is 7; expected 0 to 1, one of the 2 bodies")
    refused(lambda: SYSTEM.mu(0, 0), "body and about are 0 and 0, both Alpha; expected two bodies")
    refused(lambda: SYSTEM.mu("Beta", 1), "body and about are 'Beta' and 1, both Beta; expected two bodies")
    refused(lambda: run.elements(body=5), "body is 5; expected 0 to 1, one of the 2 bodies")
    for event in (fullbody.events.Contact(0, 5), fullbody.events.PlaneCrossing(1, 5)):
        what = f"about of {type(event).__name__} is 5; expected 0 to 1, one of the 2 bodies"
        refused(lambda event=event: SYSTEM.integrate(START, 1.0, events=[event]), what)
    alone = System(BODIES[:1], G=1.0)
    refused(lambda: alone.mu(0, 1), "about is 1; expected 0, the only body")


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        ((0.0, 0.0, 0, 0, 0, 0), ["semi-major axis", "0", "above zero"]),
        ((-1.0, 0.5, 0, 0, 0, 0), ["semi-major axis", "-1", "above zero", "ellipse"]),
        ((1.0, 1.5, 0, 0, 0, 0), ["semi-major axis", "1", "below zero", "hyperbola"]),
        ((1.0, 1.0, 0, 0, 0, 0), ["eccentricity", "1", "parabola"]),
        ((1.0, -0.1, 0, 0, 0, 0), ["eccentricity", "-0.1", "zero or above"]),
        ((1.0, 0.1, 4.0, 0, 0, 0), ["inclination", "4", "[0, pi]"]),
        ((1.0, 0.1, -1.0, 0, 0, 0), ["inclination", "-1", "[0, pi]"]),
        ((NAN, 0.1, 0, 0, 0, 0), ["semi-major axis", "nan", "finite"]),
        ((1.0, NAN, 0, 0, 0, 0), ["eccentricity", "nan", "finite"]),
        ((1.0, 0.1, 0, INF, 0, 0), ["node", "inf", "finite"]),
        ((1.0, 0.1, 0, 0, NAN, 0), ["periapsis", "nan", "finite"]),
        ((1.0, 0.1, 0, 0, 0, INF), ["mean anomaly", "inf", "finite"]),
        (("far", 0.1, 0, 0, 0, 0), ["a is", "'far'", "numbers"]),
        (([1.0, 2.0], [0.1, 0.2, 0.3], 0, 0, 0, 0), ["shapes"]),
    ],
)
def test_elements_of_no_orbit(elements, words):
    refused(lambda: KeplerElements(*elements), *words)


@pytest.mark.parametrize("mu", [0.0, -1.0, NAN, INF, "heavy", [1.0, 2.0]])
def test_mu(mu):
    orbit = KeplerElements(1.0, 0.1, 0, 0, 0, 0)
    for call in (orbit.to_cartesian, orbit.period, lambda m: KeplerElements.from_cartesian([1, 0, 0], [0, 1, 0], m)):
        refused(lambda call=call: call(mu), "mu", "expected")


@pytest.mark.parametrize(
    ("r", "v", "words"),
    [
        ([0, 0, 0], [0, 1, 0], ["distance", "0", "coincide"]),
        ([1, 0, 0], [0, NAN, 0], ["velocity", "nan", "finite"]),
        ([1, INF, 0], [0, 1, 0], ["position", "inf", "finite"]),
        ([1, 0, 0], [1, 0, 0], ["angular momentum", "straight line"]),
        ([1, 0, 0], [0, 0, 0], ["angular momentum", "straight line"]),
        ([1, 0], [0, 1], ["(2,)", "(..., 3)"]),
        ([1, 0, 0], [[0, 1, 0]], ["(3,)", "(1, 3)"]),
    ],
)
def test_cartesian_states_without_elements(r, v, words):
    refused(lambda: KeplerElements.from_cartesian(r, v, 1.0), *words)


def test_period_of_a_hyperbola():
    refused(lambda: KeplerElements(-1.0, 1.5, 0, 0, 0, 0).period(1.0), "eccentricity", "1.5", "period")


@pytest.mark.parametrize("points", [[NAN, 0, 0], [INF, 0, 0], [1, 2], [], 3.0, None, "there"])
def test_points_of_a_field(points):
    body = Body(Ellipsoid(1.0, 2.0, 3.0), mass=1.0, name="Alpha")
    refused(lambda: body.gravity(points, 1.0), "point", "expected")


@pytest.mark.parametrize("G", [NAN, INF, "Newton"])
def test_constant_of_a_field(G):
    refused(lambda: BODIES[0].gravity([9, 0, 0], G).potential, "G", "expected")


def test_systems_by_name():
    refused(lambda: fullbody.systems.kw4_ho2021("cube"), "shape", "'cube'", "'ellipsoid' or 'spheroid'")
    refused(lambda: fullbody.systems.kw4("cube"), "shape", "'cube'", "'ellipsoid' or 'radar'")
    refused(lambda: fullbody.systems.case2(NAN), "theta_0", "nan")
    refused(lambda: START.replace(colour="red"), "colour")


def test_falling_points_end_at_the_time_of_the_closed_form():
    """From rest at distance d two points meet after pi sqrt(d^3 / (8 G M))."""
    system = points(1.0, 3.0, G=2.0)
    state = State([[0, 0, 0], [1.5, 0, 0]], np.zeros((2, 3)), time=1.0)
    with pytest.raises(StepSizeTooSmall) as caught:
        system.integrate(state, 10.0)
    error = caught.value
    assert isinstance(error, fullbody.FullbodyError)
    assert isinstance(error, RuntimeError)
    assert error.time == pytest.approx(1.0 + np.pi * np.sqrt(1.5**3 / (8 * 2.0 * 4.0)), rel=1e-9)
    assert abs(error.step) < 1e-12
    assert "time" in str(error)
    assert error.run.time[-1] <= error.time
    assert np.isfinite(error.run.position).all()


def test_bodies_that_meet_stop_with_their_names_and_the_time():
    """Spheres falling from rest overlap at d = 2 R after t = sqrt(d^3 / (2 G M)) (sqrt(x (1 - x)) + acos sqrt x)."""
    system = System(BODIES, G=1.0)
    state = State([[0, 0, 0], [6.0, 0, 0]], np.zeros((2, 3)))
    x = 2.0 / 6.0
    contact = np.sqrt(6.0**3 / (2 * 2.0)) * (np.sqrt(x * (1 - x)) + np.arccos(np.sqrt(x)))
    with pytest.raises(BodiesOverlap, match="Alpha") as caught:
        system.integrate(state, 50.0)
    error = caught.value
    assert error.bodies == ("Alpha", "Beta")
    assert "Beta" in str(error)
    # Found at the first step's end inside; the steps are long compared with the accuracy of the run.
    assert contact <= error.time < 1.2 * contact
    assert np.isfinite(error.run.position).all()


def test_integrating_into_the_past_of_a_collision_is_fine():
    state = State([[0, 0, 0], [6.0, 0, 0]], [[0, 0, 0], [0.6, 0.4, 0]])
    assert SYSTEM.integrate(state, -1.0).time[-1] == -1.0


@pytest.mark.filterwarnings("ignore:A and B start at 1 km / h relative to each other")
def test_overlaps_say_how_far_or_when():
    """Two spheres of radius one whose centres are 1.5 apart, or fall at each other from 5 with speed one: at 3 they
    touch."""
    near = State([[0, 0, 0], [1.5, 0, 0]], VELOCITY)
    for call, what in (
        (lambda: SYSTEM.integrate(near, 1.0), "Alpha and Beta overlap at the start, their centres 1.5 apart;"),
        (lambda: fullbody.Simulation(SYSTEM, near), "Alpha and Beta overlap at the start, their centres 1.5 apart;"),
        (lambda: SYSTEM.energy(near), "Alpha and Beta overlap, their centres 1.5 apart;"),
        (lambda: SYSTEM.interactions(near), "Alpha and Beta overlap, their centres 1.5 apart;"),
    ):
        with pytest.raises(BodiesOverlap, match=what) as caught:
            call()
        assert "Contact" not in str(caught.value)
        assert caught.value.bodies == ("Alpha", "Beta")
        assert isinstance(caught.value, RuntimeError)
    units = System([Body(Sphere(1.0), mass=1e9, name=name) for name in "AB"], units=("km", "hour", "kg"))
    falling = State(POSITION, [[0, 0, 0], [-1, 0, 0]])

    def steps():
        sim = fullbody.Simulation(units, falling, integrator=fullbody.SymplecticSplitting(step=0.1))
        while True:
            sim.step()

    for run in (lambda: units.integrate(falling, 9.0, output=1.0), steps):
        what = r"A and B overlap at time \d(\.\d+)? h; .*events\.Contact"
        with pytest.raises(BodiesOverlap, match=what) as caught:
            run()
        assert 2.9 < caught.value.time < 9.0
    with pytest.raises(BodiesOverlap) as caught:
        units.integrate(falling, 9.0, output=1.0)
    assert caught.value.run.time[-2].value == 2.0
    assert 2.0 < caught.value.run.time[-1].value < 3.0


def test_events_that_are_text():
    refused(
        lambda: SYSTEM.integrate(START, 1.0, events="Periapsis"),
        "events is 'Periapsis', which is text; expected a list",
    )


def test_numbers_beyond_all_floats_and_text_in_disguise():
    huge = 10**309
    for call, what in (
        (lambda: State([[0, 0, 0], [huge, 0, 0]], VELOCITY), "position is .*; expected numbers"),
        (lambda: System(SYSTEM.bodies, G=huge), "G is .*; expected a finite number"),
        (lambda: SYSTEM.integrate(START, huge), "until is .*; expected a finite number"),
        (lambda: fullbody.KeplerElements(huge, 0, 0, 0, 0, 0), "a is .*; expected"),
        (lambda: System(SYSTEM.bodies, G=b"1"), "G is b'1'; expected a finite number"),
        (lambda: State(POSITION, np.array([["1", "2", "3"]] * 2, dtype=object)), "velocity is .*; expected numbers"),
        (lambda: SYSTEM.integrate(START, 1.0, output=True), "output is True; expected None, 'ends', a spacing"),
        (lambda: fullbody.systems.case2(None), "theta_0 is None; expected an angle"),
        (lambda: fullbody.systems.case2("x"), "theta_0 is 'x'; expected an angle"),
    ):
        refused(call, *what.split(".*"))
    assert fullbody.systems.case2("5 deg")[1] == fullbody.systems.case2(np.radians(5.0))[1]
