"""Numbers, bodies and options that are wrong are refused with the name, the value and what was expected."""

import inspect

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Body, Component, KeplerElements, PointMass, Sphere, State, System, Verner98
from support import refused_with

NAN, INF = float("nan"), float("inf")
POSITION = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
VELOCITY = [[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]]
BODIES = [Body(Sphere(1.0), mass=1.0, name="Alpha"), Body(Sphere(1.0), mass=1.0, name="Beta")]
SYSTEM = System(BODIES, G=1.0)
START = State(POSITION, VELOCITY)

ORBIT = KeplerElements(1, 0, 0, 0, 0, 0)


def state(**changes):
    return lambda: State(**{"position": POSITION, "velocity": VELOCITY, **changes})


def system(**options):
    return lambda: System(BODIES, **{"G": 1.0, **options})


def integrate(until=1.0, state=START, **options):
    return lambda: SYSTEM.integrate(state, until, **options)


def output(value):
    return integrate(output=value)


def elements(a=1.0, e=0.1, i=0.0):
    return lambda: KeplerElements(a, e, i, 0, 0, 0)


def cartesian(r, v):
    return lambda: KeplerElements.from_cartesian(r, v, 1.0)


def measured(*masses):
    """Calls that take mu, with each of these values."""
    calls = ORBIT.to_cartesian, ORBIT.period, lambda mu: KeplerElements.from_cartesian([1, 0, 0], [0, 1, 0], mu)
    return [(lambda call=call, mu=mu: call(mu), "mu ... expected") for call in calls for mu in masses]


THREE = State([*POSITION, [9, 9, 9]], [*VELOCITY, [0, 0, 0]])
RUN = SYSTEM.integrate(START, 1.0)
COMPLEX = np.array([[1j, 0, 0], [5, 0, 0]])
#: Calls, and pieces of their errors in this order.
ODD = [
    (lambda: Body(Sphere(1.0), mass=1.0, density=1.0, name="Alpha"), "Alpha ... both ... expected one"),
    (lambda: Body(Sphere(1.0), name="Alpha"), "Alpha ... neither ... expected one"),
    (lambda: Body(PointMass(), density=2.0, name="Alpha"), "density of Alpha is 2.0; expected a mass"),
    (lambda: Body("round", mass=1.0, name="Alpha"), "shape of Alpha ... 'round' ... expected"),
    (lambda: Body(Sphere(1.0), mass=1.0, name=3), "name is 3; expected"),
    (state(attitude=[[1, 0, 0, 0], [0, 0, 0, 0]]), "attitude of body 1 ... 0, 0, 0, 0 ... non-zero"),
    (state(position=[[0, 0, 0], [0, 0, NAN]]), "position of body 1, component 2, is NaN; expected a finite number"),
    (state(spin=[[0, 0, INF], [0, 0, 0]]), "spin of body 0, component 2, is inf; expected a finite number"),
    (state(position=[0, 0, 0]), "position ... [3] ... (N, 3)"),
    (state(position=5.0), "position ... (N, 3)"),
    (state(position=[[0, 0], [1, 1]]), "position ... [2, 2] ... (N, 3)"),
    (state(position=[[[0, 0, 0]]]), "position ... (N, 3)"),
    (state(position=[[0, 0, 0], [1, 2]]), "position ... expected numbers"),
    (state(position=COMPLEX), "position ... 1.j ... expected numbers"),
    (state(position=COMPLEX * u.km), "position ... 1000.j ... expected numbers"),
    (state(attitude=np.array([[1j, 0, 0, 0]] * 2) * u.percent), "attitude ... 0.01j ... expected numbers"),
    (state(velocity=[[0, 0, 0]]), "velocity is 1; expected 2"),
    (state(velocity=np.array([["1", "2", "3"]] * 2, dtype=object)), "velocity is ... expected numbers"),
    (state(attitude=[[1, 0, 0], [1, 0, 0]]), "attitude ... [2, 3] ... (N, 4)"),
    (state(attitude=[[1, 0, 0, 0]]), "attitude is 1; expected 2"),
    (state(spin=[[0, 0, 0]] * 3), "spin is 3; expected 2"),
    (state(time=[0.0, 1.0]), "time ... (2,) ... single number"),
    (lambda: State.from_tait_bryan(POSITION, VELOCITY, [[0, 0]] * 2), "angles ... [2, 2] ... (N, 3)"),
    (lambda: State(np.zeros((0, 3)), np.zeros((0, 3))), "position"),
    (lambda: START.replace(positon=POSITION), "'positon' ... did you mean 'position'? ... velocity, attitude"),
    *(
        (lambda compute=compute: compute(THREE), "bodies ... 3; expected 2")
        for compute in (SYSTEM.interactions, SYSTEM.energy, SYSTEM.momentum, SYSTEM.angular_momentum)
    ),
    (integrate(state=THREE), "bodies ... 3; expected 2"),
    (integrate(state="here"), "state is 'here'; expected a State"),
    (lambda: SYSTEM.interactions(3), "state is 3; expected a State"),
    (lambda: fullbody.Simulation("S", START), "system is 'S'; expected a System"),
    (lambda: System([], G=1.0), "bodies ... 0 ... at least one"),
    (lambda: System([BODIES[0], "Beta"], G=1.0), "bodies ... 'Beta' ... Body"),
    (lambda: System(3, G=1.0), "bodies ... 3 ... Body"),
    (system(gravity="magic"), "gravity ... magic ... surface ... focal ... multipole ... point"),
    (system(gravity="multipole:1"), "gravity ... multipole:1 ... 2 to 60"),
    (system(gravity="multipole:x"), "gravity ... multipole:x"),
    (system(gravity="multipole:100"), "gravity ... multipole:100 ... 60"),
    (system(gravity=3), "gravity is 3; expected text"),
    (system(attitude_chart="euler"), "attitude_chart ... euler ... quaternion ... tait_bryan"),
    (system(vector_path="sse"), "vector_path ... sse ... auto ... portable"),
    (system(vector_path=None), "vector_path is None; expected text"),
    (system(gravity_tolerance=-1e-14), "gravity_tolerance ... expected"),
    (system(gravity_tolerance=0.0), "gravity_tolerance ... 0 ... expected"),
    (system(gravity_tolerance=NAN), "gravity_tolerance ... nan"),
    (system(gravity_tolerance="1e-3x"), "gravity_tolerance is '1e-3x', whose unit 'x' is not known; expected a number"),
    (system(gravity_tolerance=np.ma.masked), "gravity_tolerance is masked; expected numbers throughout"),
    (system(order=(0, 8)), "order is (0, 8); expected"),
    (system(order=(-1, 8)), "order is (-1, 8); expected (n, m), whole numbers"),
    (system(order=(10**9, 8)), "order is (1000000000, 8); expected"),
    (system(order=(10**30, 8)), "order is (1000000000000000000000000000000, 8); expected (n, m)"),
    (system(order=(4.5, 8)), "order is (4.5, 8); expected (n, m), whole numbers"),
    (system(order=8), "order is 8; expected (n, m), whole numbers"),
    (system(G=-1.0), "G is -1 ... zero or above"),
    (system(G=None), "G is not given ... expected"),
    (system(units=("km", "hour")), "units ... ('km', 'hour') ... expected (length, time, mass)"),
    (system(units=("km", "kg", "hour")), "units ... 'kg' ... unit of time"),
    (system(units=("km", "hour", "parrot")), "units ... parrot"),
    (system(units=3), "units ... 3"),
    (lambda: SYSTEM.with_options(gravty="point"), "'gravty' is not an option of with_options, which keeps bodies, G"),
    (lambda: SYSTEM.with_options(gravty="point"), "units; did you mean 'gravity'? expected some of gravity, "),
    (lambda: fullbody.systems.kw4(gravty="point"), "'gravty' ... did you mean 'gravity'? expected some of gravity"),
    (lambda: fullbody.systems.case1(gravty="point"), "'gravty' ... did you mean 'gravity'? expected some of gravity"),
    (lambda: fullbody.systems.didymos(epoch="2022-09-26 TDB"), "epoch is '2022-09-26 TDB'; expected none"),
    (lambda: fullbody.systems.kw4_ho2021("cube"), "shape is 'cube'; expected 'ellipsoid' or 'spheroid'"),
    (lambda: fullbody.systems.kw4("cube"), "shape is 'cube'; expected 'ellipsoid' or 'radar'"),
    (lambda: fullbody.systems.case2(NAN), "theta_0 ... nan"),
    (lambda: fullbody.systems.case2("x"), "theta_0 is 'x'; expected an angle"),
    (lambda: fullbody.Verner87(rtol=0.0, atol=0), "rtol and atol ... 0 ... expected"),
    *(
        (integrate(integrator=wrong), f"integrator is {wrong!r} ... Verner98")
        for wrong in ("rk4", "verner98", Verner98, 3)
    ),
    (integrate(None), "until ... expected"),
    (integrate([1.0, 2.0]), "until ... expected"),
    (integrate(1e300, output=0.1), "until ... 1e+300 ... output is 0.1 ... samples; expected"),
    (integrate(events="Periapsis"), "events is 'Periapsis', which is text; expected a list"),
    (output(NAN), "output ... nan ... spacing above zero"),
    (output(INF), "output ... inf ... spacing above zero"),
    (output(0.0), "output ... 0 ... spacing above zero"),
    (output(-1.0), "output ... -1 ... spacing above zero"),
    (output(1e-300), "until is 1.0 ... 1e-300 ... at most"),
    (output("often"), "output ... 'often' ... expected"),
    (output(True), "output is True; expected None, 'ends', a spacing"),
    (output([0.0, NAN]), "output ... nan ... finite"),
    (output([0.5, 0.2]), "output ... 0.5 ... 0.2 ... direction"),
    (output([0.5, 0.5]), "output ... 0.5 ... twice"),
    (output([-1.0, 0.5]), "output ... -1 ... from 0 to 1"),
    (output([0.5, 2.0]), "output ... 2 ... from 0 to 1"),
    (output([[0.0, 1.0]]), "output ... (1, 2) ... (K,)"),
    (lambda: SYSTEM.mu(0, 0), "body and about are 0 and 0, both Alpha; expected two bodies"),
    (lambda: SYSTEM.mu("Beta", 1), "body and about are 'Beta' and 1, both Beta; expected two bodies"),
    (lambda: SYSTEM.mu(0, np.ma.array(1, mask=True)), "about is masked_array ... expected 0 to 1"),
    (lambda: System(BODIES[:1], G=1.0).mu(0, 1), "about is 1; expected 0, the only body"),
    (lambda: RUN.elements(body=5), "body is 5; expected 0 to 1, one of the 2 bodies"),
    (elements(0.0, 0.0), "semi-major axis ... 0 ... above zero"),
    (elements(-1.0, 0.5), "semi-major axis ... -1 ... above zero ... ellipse"),
    (elements(1.0, 1.5), "semi-major axis ... 1 ... below zero ... hyperbola"),
    (elements(1.0, 1.0), "eccentricity ... 1 ... parabola"),
    (elements(1.0, -0.1), "eccentricity ... -0.1 ... zero or above"),
    (elements(i=4.0), "inclination ... 4 ... [0, pi]"),
    (elements(i=-1.0), "inclination ... -1 ... [0, pi]"),
    (elements([1.0, 2.0], [0.1, 0.2, 0.3]), "shapes"),
    *measured(0.0, -1.0, [1.0, 2.0]),
    (cartesian([0, 0, 0], [0, 1, 0]), "distance ... 0 ... coincide"),
    (cartesian([1, 0, 0], [1, 0, 0]), "angular momentum ... straight line"),
    (cartesian([1, 0, 0], [0, 0, 0]), "angular momentum ... straight line"),
    (cartesian([1, 0], [0, 1]), "(2,) ... (..., 3)"),
    (cartesian([1, 0, 0], [[0, 1, 0]]), "(3,) ... (1, 3)"),
    (lambda: KeplerElements(-1.0, 1.5, 0, 0, 0, 0).period(1.0), "eccentricity ... 1.5 ... period"),
    *(
        (lambda wrong=wrong: BODIES[0].gravity(wrong, 1.0), "point ... expected")
        for wrong in ([1, 2], [], 3.0, None, "x")
    ),
    (lambda: BODIES[0].gravity([9, 0, 0], "Newton"), "G ... expected"),
]


@pytest.mark.parametrize(("call", "pieces"), ODD, ids=lambda value: value if isinstance(value, str) else "")
def test_odd_input_is_refused_with_name_value_and_expectation(call, pieces):
    refused_with(pieces, call)


def test_unusual_valid_input_is_accepted():
    assert System(BODIES, G=1.0, order=[8, np.int64(16)]).options["order"] == (8, 16)
    assert Verner98(rtol=0.0, atol=0) == Verner98.to_roundoff()
    for period in (INF, -INF, -3.0, "-2 h", 5 * u.min):
        Component(diameter=1, rotation_period=period)
    assert fullbody.systems.case2("5 deg")[1] == fullbody.systems.case2(np.radians(5.0))[1]
    # Inspect and editors see the signature of the function itself.
    assert "gravity_tolerance" in inspect.signature(System).parameters


@pytest.mark.parametrize(
    "call",
    [
        lambda: SYSTEM.integrate(START, t_end=3.0),
        lambda: Sphere(r=1),
        lambda: Body(Sphere(1), m=1),
        lambda: SYSTEM.mu(i=0, j=1),
        lambda: KeplerElements(1, 0, 0, 0, 0, mean_anomaly=0),
    ],
)
def test_unknown_keywords_raise_pythons_own_error(call):
    with pytest.raises(TypeError, match="unexpected keyword argument"):
        call()


def test_mu_is_the_only_number_that_elements_of_a_run_take_by_position():
    with pytest.raises(TypeError, match="positional"):
        RUN.elements(2.0, 0, 1)
    assert RUN.elements(2.0) == RUN.elements(mu=2.0, body=1, about=0) == RUN.elements()
