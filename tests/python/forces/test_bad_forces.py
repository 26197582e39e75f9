"""Invalid forces raise errors with the force's name, the value and what was expected."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody.errors import ForceFailed, Interrupted, InvalidInput
from fullbody.forces import Byorp, Function, ThirdBody, Tide, Yorp, lag_from_quality_factor
from support import body_list, refused, refused_with
from support.scenes import KINDS, at_rest, drag, pair, sun

NAN, INF = float("nan"), float("inf")
SYSTEM, STATE = pair()
ELEMENTS = fullbody.KeplerElements


def tide(**arguments):
    return Tide(**({"on": "A", "by": "B", "k2": 0.3, "lag": 0.1, "name": "T"} | arguments))


def table(times=(0.0, 1.0, 2.0, 2.5), positions=None, mu=1e-3):
    positions = np.full((len(times), 3), 100.0) if positions is None else positions
    return ThirdBody(mu=mu, times=times, positions=positions, of="body", name="Sun")


def yorp(**arguments):
    return Yorp(**({"on": "A", "along": 1.0, "name": "Y"} | arguments))


def byorp(**arguments):
    return Byorp(**({"on": "B", "about": "A", "force": 1.0, "name": "Y"} | arguments))


#: Numbers out of range are in the table of tests/python/package; here is what belongs to one kind of force.
ODD = [
    (tide, {"lag": -1.0}, "lag of T ... -1 ... zero or above"),
    (tide, {"k2": 1.6}, "k2 of T ... 1.6 ... 0 to 1.5"),
    (tide, {"k2": -0.1}, "k2 of T ... -0.1 ... 0 to 1.5"),
    (tide, {"by": "A"}, "on and by of T ... A ... two bodies"),
    (tide, {"on": "Alpha"}, "on of T ... 'Alpha' ... A, B"),
    (tide, {"by": 7}, "by of T ... 7 ... 0 to 1"),
    (tide, {"on": None}, "on of T ... None"),
    (tide, {"on": True}, "on of T ... True"),
    (tide, {"name": 3}, "name ... 3 ... text"),
    (sun, {"mass": 1.0}, "mass and mu of Sun ... one of the two"),
    (sun, {"mu": None}, "mass and mu of Sun ... one of the two"),
    (sun, {"of": None}, "argument 'of' of Sun is None ... 'system' ... 'body'"),
    (sun, {"of": "sun"}, "argument 'of' of Sun is 'sun' ... 'system'"),
    (sun, {"orbit": (1, 2, 3, 4, 5, 6)}, "orbit of Sun ... KeplerElements"),
    (sun, {"orbit": None}, "path of Sun ... times and positions"),
    (sun, {"orbit": None, "times": [0, 1, 2, 3]}, "path of Sun ... times and positions"),
    (sun, {"times": [0, 1, 2, 3], "positions": np.ones((4, 3))}, "path of Sun ... orbit, or else"),
    (sun, {"orbit": ELEMENTS(np.array([1e3, 2e3]), 0.1, 0, 0, 0, 0)}, "Sun ... (2,)"),
    (ThirdBody, {"mass": 1.0}, "the path of third body is not clear; expected orbit, or else times"),
    (table, {"times": [0, 2, 1, 3]}, "times of Sun ... 2 followed by 1 ... rising"),
    (table, {"times": [0, 1, 1, 3]}, "times of Sun ... 1.0 and 1.0 in rows 1 and 2 ... round-off"),
    (table, {"times": [0.0, 5e-324, 1.0, 2.0, 3.0]}, "times of Sun are ... in rows 0 and 1; expected rows further"),
    (table, {"times": [0.0, 1.0, 2.0, 3.0, np.nextafter(3.0, 4.0)]}, "times of Sun are ... in rows 3 and 4; expected"),
    (table, {"times": [0, 1, 2]}, "times of Sun ... 3 ... four or more"),
    (table, {"positions": np.ones((4, 4))}, "Sun ... (4, 4) ... (T, 3)"),
    (table, {"positions": np.ones((5, 3))}, "Sun ... (5, 3) ... (T, 3)"),
    (table, {"times": np.zeros((2, 2)), "positions": np.ones((4, 3))}, "Sun ... (2, 2) ... (T,)"),
    (yorp, {"along": NAN}, "along of Y ... nan"),
    (yorp, {"across": INF}, "across of Y ... inf"),
    (yorp, {"along": [1.0, 2.0, 3.0]}, "along of Y ... one at each obliquity"),
    (yorp, {"along": 1 * u.N}, "along of Y has the unit N"),
    (yorp, {"pole": (0, 0, 0)}, "pole of Y ... zero"),
    (yorp, {"pole": (0, 1)}, "pole of Y ... (2,)"),
    (yorp, {"pole": (0, NAN, 1)}, "pole of Y ... nan"),
    (yorp, {"on": "Alpha"}, "on of Y ... 'Alpha'"),
    (yorp, {"obliquity": [0, 1, 2, 3.0]}, "obliquities of Y ... 0 to 3 ... 0 to pi"),
    (yorp, {"obliquity": [0, 60.0, 120.0, 180.0]}, "obliquities of Y ... 0 to 180 ... 0 to pi"),
    (yorp, {"obliquity": [0, 2, 1, np.pi]}, "obliquities of Y ... 2 followed by 1"),
    (yorp, {"obliquity": [0, 1, np.pi]}, "obliquities of Y ... four or more"),
    (yorp, {"obliquity": [0, 1, 2, np.pi], "along": [1, 2, 3]}, "along of Y ... at each obliquity"),
    (byorp, {"force": [1.0, 2.0]}, "force of Y ... (2,) ... a finite number, or three"),
    (byorp, {"about": "B"}, "on and about of Y ... B ... two bodies"),
    (byorp, {"about": "sun"}, "about of Y ... 'sun' ... A, B"),
    (Function, {"function": 3, "name": "f"}, "function of f is 3"),
    (Function, {"function": drag, "depends_on_velocity": "no"}, "depends_on_velocity of drag is 'no'"),
]


@pytest.mark.parametrize(("make", "arguments", "pieces"), ODD, ids=lambda part: part if isinstance(part, str) else "")
def test_a_wrong_argument_of_a_force_is_refused_by_name(make, arguments, pieces):
    refused_with(pieces, lambda: SYSTEM.with_forces([make(**arguments)]))


@pytest.mark.parametrize("value", [0.0, 1.5])
def test_the_ends_of_love_numbers_and_no_lag_are_allowed(value):
    loads = SYSTEM.with_forces([tide(k2=value, lag=0.0)]).loads(STATE)["T"]
    assert (loads.force == 0).all()


def test_a_secondary_without_a_longest_axis_has_no_byorp():
    shapes = {name: (fullbody.Ellipsoid(0.1, 0.1, c), 1.0) for c, name in ((0.1, "A"), (0.05, "B"))}
    bodies = body_list(**shapes)
    for on, about in (("A", "B"), ("B", "A")):
        with pytest.raises(InvalidInput, match=f"axes of {on}.*longest.*Y"):
            fullbody.System(bodies, G=1.0, forces=[Byorp(on=on, about=about, force=1.0, name="Y")])


def test_torques_on_points_are_refused():
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m, name=name) for m, name in ((1.0, "A"), (0.01, "B"))]
    points = fullbody.System(bodies, G=1.0)
    for force in (tide(radius=0.2), yorp()):
        refused(rf"on of {force.name} is the point A; expected a body with extent", points.with_forces, [force])
    refused("radius of T is not given, and A is a point", lambda: points.with_forces([tide()]))
    torque = Function(lambda t, s: (0 * s.position, [[0, 0, 0], [0, 0, 1.0]]), name="twist")
    state = fullbody.State(STATE.position, STATE.velocity)
    with pytest.raises(ForceFailed, match=r"twist.*torque on B, a point"):
        points.with_forces([torque]).integrate(state, 1.0)


@pytest.mark.parametrize(
    ("forces", "pieces"),
    [
        ([3], "3 ... fullbody.forces"),
        (sun(), "sequence ... ThirdBody"),
        ("Sun", "'S'"),
        ([ThirdBody], "class"),
        ([fullbody.forces.Force(name="x")], "x"),
        ([sun(), sun()], "Sun ... twice ... distinct"),
        ([tide(), KINDS["tide"](), tide(on="B", by="A")], "T ... twice"),
    ],
)
def test_bad_lists_of_forces_are_refused(forces, pieces):
    refused_with(pieces, lambda: SYSTEM.with_forces(forces))


def test_a_quality_factor_without_a_frequency_has_no_lag():
    for arguments in (
        {"Q": 0.0, "mean_motion": 1.0, "tide": "libration"},
        {"Q": 10.0, "mean_motion": NAN, "tide": "libration"},
        {"Q": 10.0, "mean_motion": 1.0, "tide": "monthly"},
        {"Q": 10.0, "mean_motion": 1.0, "tide": "semidiurnal"},
        {"Q": 10.0, "mean_motion": 1.0, "tide": "semidiurnal", "spin": 1.0},
        {"Q": 10.0, "mean_motion": 1.0, "tide": "libration", "spin": 2.0},
    ):
        with pytest.raises(InvalidInput):
            lag_from_quality_factor(**arguments)


# States and runs that do not fit a force.


@pytest.mark.parametrize(
    ("force", "text"),
    [
        (sun(mu=1.0, orbit=ELEMENTS(3.0, 0.9, 0, 0, 0, 3.0)), "periapsis distance of Sun is 0.29"),
        (sun(mu=1.0, orbit=ELEMENTS(0.3, 0.0, 0, 0, 0, 3.0)), "distance of Sun is 0.29"),
        (sun(mu=1.0, orbit=ELEMENTS(-1.0, 1.5, 0, 0, 0, -9.0), of="body"), "periapsis distance of Sun is 0.5"),
        (at_rest([1.1, 0, 0], 1.0), "distance of Sun is 1.1"),
    ],
)
def test_a_third_body_inside_the_system_is_refused(force, text):
    # Its reach is 0.99 for the centre of B and 0.12 for its size.
    world = SYSTEM.with_forces([force])
    for act in (lambda: world.integrate(STATE, 3.0), lambda: world.loads(STATE)):
        refused(f"{text}.*more than 1.1.*, out to which the system reaches", act)
    SYSTEM.with_forces([at_rest([1.2, 0, 0], 1e-9)]).integrate(STATE, 1e-3)


def test_a_third_body_that_runs_into_a_body_ends_the_run():
    times = np.linspace(0.0, 4.0, 9)
    path = table(times, np.outer(2.0 - times, [50.0, 30.0, 20.0]) - np.array([0.01, 0, 0]), mu=1e-9)
    with pytest.raises(ForceFailed, match=r"Sun.*inside A") as caught:
        SYSTEM.with_forces([path]).integrate(STATE, 4.0)
    assert caught.value.force == "Sun"
    assert 1.9 < caught.value.time < 2.1
    assert 0.0 < caught.value.run.time[-1] < 2.0


def test_a_table_that_ends_before_the_run_is_refused_before_the_first_step():
    world = SYSTEM.with_forces([table()])
    for until in (3.0, -1.0):
        with pytest.raises(InvalidInput, match=r"time of Sun is 0 to .*times from 0 to 2.5") as caught:
            world.integrate(STATE, until)
        assert len(caught.value.run) == 0
    sim = fullbody.Simulation(world, STATE)
    sim.integrate(2.0)
    refused(r"time of Sun is 2 to 3; expected times from 0 to 2.5", lambda: sim.integrate(3.0))
    assert sim.integrate(2.5).time[-1] == 2.5
    later_state = fullbody.State(STATE.position, STATE.velocity, STATE.attitude, STATE.spin, time=2.6)
    for act in (lambda: fullbody.Simulation(world, later_state), lambda: world.loads(later_state)):
        refused(r"time of Sun is 2.6", lambda act=act: act())


@pytest.mark.parametrize("integrator", [fullbody.Verner98(), fullbody.LieGroupVariational(step=0.15)])
@pytest.mark.parametrize("end", [2.5, -2.5])
def test_single_steps_end_with_the_table(integrator, end):
    world = SYSTEM.with_forces([table((-2.5, -2.0, -1.0, 0.0, 1.0, 2.0, 2.5))])
    sim = fullbody.Simulation(world, STATE, integrator=integrator)
    while abs(sim.time) < 2.5:
        sim.step(np.sign(end) * INF)
    assert sim.time == end
    refused(r"time of Sun is -?2\.5", lambda: sim.step(2.0 * end))
    sim.step(0.0)
    assert abs(sim.time) < 2.5


def test_bad_arguments_of_third_body_are_refused():
    world = SYSTEM.with_forces([table(), tide()])
    for name, time, text in (
        ("Son", 0.0, "did you mean 'Sun'"),
        ("T", 0.0, "name is 'T', a Tide; expected one of Sun"),
        ("Sun", NAN, "time of Sun is NaN"),
        ("Sun", 3.0, "time of Sun is 3; expected times from 0 to 2.5"),
        ("Sun", [0.0, -1.0], "time of Sun is -1"),
    ):
        refused(text, lambda name=name, time=time: world.third_body(name, time))
    with pytest.raises(InvalidInput, match="force of ClosestApproach is 'T', a Tide; expected one of Sun"):
        world.integrate(STATE, 1.0, events=[fullbody.events.ClosestApproach("T")])
    refused("name is 'Sun'", lambda: SYSTEM.third_body("Sun", 0.0))


@pytest.mark.filterwarnings("ignore:T has a lag of")
@pytest.mark.parametrize(
    "force",
    [sun(mu=1e300), tide(lag=1e300), yorp(along=1e300), Byorp(on="B", about="A", force=1e300, name="Y")],
    ids=["Sun", "tide", "YORP", "BYORP"],
)
def test_huge_forces_end_in_an_error(force):
    with pytest.raises(fullbody.FullbodyError) as caught:
        SYSTEM.with_forces([force]).integrate(STATE, 1.0)
    assert np.isfinite(caught.value.run.position).all()


@pytest.mark.parametrize("integrator", [fullbody.SymplecticSplitting(step=0.02), fullbody.Verner98()])
@pytest.mark.parametrize("quantity", ["velocity", "spin"])
def test_a_function_that_uses_velocities_in_spite_of_its_declaration_is_refused(integrator, quantity):
    custom = Function(lambda time, state: -1e-4 * getattr(state, quantity), name="own", depends_on_velocity=False)
    with pytest.raises(ForceFailed, match=r"own .*NaN.*with depends_on_velocity=False"):
        SYSTEM.with_forces([custom]).integrate(STATE, 1.0, integrator=integrator)


@pytest.mark.parametrize("size", [1e160, 1e300])
@pytest.mark.parametrize(
    "integrator",
    [
        fullbody.SymplecticSplitting(step=0.02),
        fullbody.SymplecticSplitting(step=0.02, scheme="leapfrog"),
        fullbody.LieGroupVariational(step=0.02),
        fullbody.Verner98(),
    ],
    ids=["splitting", "leapfrog", "variational", "verner98"],
)
@pytest.mark.parametrize("kind", ["force", "torque"])
def test_a_huge_force_function_ends_the_run_after_few_calls(integrator, size, kind):
    """Fixed steps search a step that is not taken for a contact, with squares that overflow: calls are counted."""
    calls = []

    def huge(time, state):
        calls.append(time)
        apart = size * np.array([[1.0, 0, 0], [-1.0, 0, 0]])
        return (apart, np.zeros((2, 3))) if kind == "force" else (np.zeros((2, 3)), apart)

    force = Function(huge, name="huge", depends_on_velocity=False)
    with pytest.raises(fullbody.FullbodyError) as caught:
        SYSTEM.with_forces([force]).integrate(STATE, 1.0, integrator=integrator)
    assert not isinstance(caught.value, Interrupted)
    assert "use a step of at most 0" not in str(caught.value)
    assert np.isfinite(caught.value.run.position).all()
    assert len(calls) < 20_000


@pytest.mark.parametrize(
    "integrator", [fullbody.SymplecticSplitting(step=4.0, scheme="leapfrog"), fullbody.LieGroupVariational(step=0.5)]
)
def test_a_third_body_at_the_barycentre_is_named(integrator):
    bodies = [fullbody.Body(fullbody.PointMass(), mass=1.0, name=name) for name in "AB"]
    times = np.arange(-8.0, 9.0)
    path = np.outer(times, [0.0, 0.0, 4.0])
    third = ThirdBody(mu=1e-6, times=times, positions=path, of="body", name="T")
    system = fullbody.System(bodies, G=1.0, forces=[third])
    state = fullbody.State([[-0.5, 0, 0], [0.5, 0, 0]], [[0, -(0.5**0.5), 0], [0, 0.5**0.5, 0]], time=-2.0)
    with pytest.raises(ForceFailed, match=r"T at time 0.*barycentre.*outside the system"):
        system.integrate(state, 2.0, integrator=integrator)
