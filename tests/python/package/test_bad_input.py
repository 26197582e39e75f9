"""Numbers, bodies and options that are wrong are refused with the name, the value and what was expected."""

import inspect
import reprlib
from dataclasses import is_dataclass

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import (
    Body,
    Component,
    Ellipsoid,
    KeplerElements,
    Part,
    PointMass,
    Sphere,
    State,
    System,
    Verner98,
    events,
    forces,
    observing,
    particles,
)
from fullbody.base.kinds import Declared, Number, kinds_of
from fullbody.errors import InvalidInput
from support import refused_with

NAN, INF = float("nan"), float("inf")
POSITION = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
VELOCITY = [[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]]
BODIES = [Body(Sphere(1.0), mass=1.0, name="Alpha"), Body(Sphere(1.0), mass=1.0, name="Beta")]
SYSTEM = System(BODIES, G=1.0)
START = State(POSITION, VELOCITY)

# Fields that classes declare. For each range: what errors expect, and numbers that are out of it.
FINITE = "a finite number", (NAN, INF, -INF)
NOT_NEGATIVE = "a finite number, zero or above", (NAN, INF, -INF, -1.5)
POSITIVE = "a finite number above zero", (NAN, INF, -INF, 0.0, -1.5)
NONZERO = "a finite number that is not zero", (NAN, INF, -INF, 0.0)
FRACTION = "a number from 0 to 1", (NAN, INF, -0.1, 1.1)
TOLERANCE = "a number from 0 to below 1", (NAN, INF, -1e-13, 1.0)
SHARE = "a number above 0 and below 1", (NAN, INF, 0.0, 1.0)
EXPONENT = "a number from 0 to 1e+06", (NAN, INF, -0.1, 1e20)
PEAK = "a number from 1e-06 to 1e+06", (NAN, INF, -0.1, 0.0, 1e20)
CUTOFF = "an angle above zero, at most pi/2", (NAN, INF, -0.1, 0.0, 1.6)
PERIOD = "a time other than zero", (NAN, 0.0)
ORBIT = KeplerElements(1, 0, 0, 0, 0, 0)
PATH = {"times": [0, 1, 2, 3], "positions": np.ones((4, 3))}


def of(what, make, names, *arguments):
    """Fields of one class, with the words that errors add to their names."""
    return {name: (f"{name}{what}", lambda x, name=name: make(**{name: x}), *arguments) for name in names.split()}


def error(call):
    with pytest.raises(InvalidInput) as caught:
        call()
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, fullbody.FullbodyError)
    return str(caught.value)


def ellipsoid(**options):
    return Ellipsoid(**({"a": 1.0, "b": 1.0, "c": 1.0} | options))


def third_body(**options):
    path = {} if "orbit" in options else PATH
    return forces.ThirdBody(**path | ({} if {"mass", "GM"} & set(options) else {"mu": 1.0}) | options, of="body")


def occultation(**options):
    return events.Occultation("A", "B", toward=np.ones((4, 3)), **options)


def tide(**options):
    return forces.Tide(on="A", by="B", **{"k2": 0.1, "lag": 1.0} | options, name="T")


def yorp(**options):
    return forces.Yorp("A", along=1.0, **options, name="Y")


def byorp(**options):
    return forces.Byorp("B", "A", **({} if "coefficient" in options else {"force": 1.0}) | options, name="Y")


def heat(**options):
    return forces.BinaryYarkovsky("B", "A", **{"pressure": 1.0, "lag": 0.3} | options, name="Y")


def part(**options):
    return Part(Sphere(1.0), **({} if {"density", "GM"} & {*options} else {"mass": 1.0}) | options)


def component(**options):
    return Component(**({"diameter": 1.0} if {"tilt", "mass", "density"} & {*options} else {}) | options, name="Moon")


#: Name in errors, a call that takes it, a unit, the range, and the shape of an array, by class and field.
FIELDS = {
    "model.Ellipsoid": {
        name: (f"semi-axis {name}", lambda x, name=name: ellipsoid(**{name: x}), u.m, POSITIVE) for name in "abc"
    },
    "model.Sphere": of("", Sphere, "radius", u.m, POSITIVE),
    "model.Part": {
        **of(" of a part", part, "mass", u.kg, NONZERO),
        **of(" of a part", part, "GM", u.m**3 / u.s**2, NONZERO),
        **of(" of a part", part, "density", u.kg / u.m**3, NONZERO),
        **of(" of a part", part, "position", u.m, FINITE, (3,)),
        **of(" of a part", part, "attitude", None, FINITE, (4,)),
    },
    "events.Separation": of(" of Separation", events.Separation, "value", u.m, POSITIVE),
    "events.Escape": of(" of Escape", events.Escape, "distance", u.m, POSITIVE),
    "events.Occultation": {
        **of(" of Occultation", occultation, "times", u.s, FINITE, (4,)),
        **of(" of Occultation", occultation, "slowness", None, FINITE),
    },
    "record._Adaptive": of("", Verner98, "rtol atol", None, TOLERANCE),
    "record.LieGroupVariational": of("", fullbody.LieGroupVariational, "step", u.s, POSITIVE),
    "record.SymplecticSplitting": of("", fullbody.SymplecticSplitting, "step", u.s, POSITIVE),
    "forces.Yorp": {
        **of(" of Y", yorp, "obliquity", u.rad, FINITE, (4,)),
        **of(" of Y", yorp, "pressure", u.Pa, POSITIVE),
        **of(" of Y", yorp, "radius", u.m, POSITIVE),
    },
    "forces.Byorp": {
        **of(" of Y", byorp, "force", u.N, FINITE, (3,)),
        **of(" of Y", byorp, "coefficient", None, FINITE, (3,)),
        **of(" of Y", byorp, "torque", u.N * u.m, FINITE, (3,)),
        **of(" of Y", byorp, "pressure", u.Pa, POSITIVE),
        **of(" of Y", byorp, "radius", u.m, POSITIVE),
    },
    "forces.BinaryYarkovsky": {
        **of(" of Y", heat, "pressure", u.Pa, POSITIVE),
        **of(" of Y", heat, "lag", u.rad, FINITE),
        **of(" of Y", heat, "albedo emissivity", None, FRACTION),
        **of(" of Y", heat, "radius primary_radius", u.m, POSITIVE),
    },
    "forces.ThirdBody": {
        **of(" of third body", third_body, "mass", u.kg, POSITIVE),
        **of(" of third body", third_body, "mu GM", u.m**3 / u.s**2, POSITIVE),
        **of(" of third body", third_body, "time", u.s, FINITE),
        **of(" of third body", third_body, "times", u.s, FINITE, (4,)),
        **of(" of third body", third_body, "positions", u.m, FINITE, (4, 3)),
    },
    "forces.Tide": {
        **of(" of T", tide, "k2", None, FINITE),
        **of(" of T", tide, "lag", u.s, FINITE),
        **of(" of T", tide, "radius", u.m, POSITIVE),
    },
    "particles.Shadow": of(" of Shadow", particles.Shadow, "visible", None, SHARE),
    "particles.Bounce": {
        **of(" of Bounce", lambda **x: particles.Bounce(**x, rest_speed=1.0), "normal", None, FRACTION),
        **of(" of Bounce", lambda **x: particles.Bounce(normal=0.5, rest_speed=1.0, **x), "tangential", None, FRACTION),
        **of(" of Bounce", lambda **x: particles.Bounce(normal=0.5, **x), "rest_speed", u.m / u.s, POSITIVE),
    },
    "particles.EscapeDistance": of(" of EscapeDistance", particles.EscapeDistance, "distance", u.m, POSITIVE),
    "particles.Radiation": {
        **of(" of Radiation", particles.Radiation, "strength", u.N, NOT_NEGATIVE),
        **of(" of Radiation", particles.Radiation, "radius", u.m, POSITIVE),
    },
    "observing.LommelSeeligerLambert": of(
        " of LommelSeeligerLambert", observing.LommelSeeligerLambert, "lambert", None, FINITE
    ),
    "observing.Hapke": {
        **of(" of Hapke", observing.Hapke, "single_scattering_albedo opposition_amplitude", None, FINITE),
        **of(" of Hapke", observing.Hapke, "opposition_width asymmetry", None, FINITE),
        **of(" of Hapke", observing.Hapke, "roughness", u.rad, FINITE),
    },
    "observing.Cosine": of(" of Cosine", observing.Cosine, "C R", None, EXPONENT),
    "observing.PeakedLaw": {
        **of(" of Gaussian", observing.Gaussian, "C", None, PEAK),
        **of(" of Gaussian", lambda **x: observing.Gaussian(1.0, **x), "R", None, EXPONENT),
        **of(" of Gaussian", lambda **x: observing.Gaussian(1.0, **x), "cutoff", u.rad, CUTOFF),
    },
}
#: Classes that check their numbers one by one, or have those of a base class.
OTHERS = {
    "observing.Hagfors": {
        **of(" of Hagfors", observing.Hagfors, "C", None, PEAK),
        **of(" of Hagfors", lambda **x: observing.Hagfors(1.0, **x), "R", None, EXPONENT),
        **of(" of Hagfors", lambda **x: observing.Hagfors(1.0, **x), "cutoff", u.rad, CUTOFF),
    },
    "model.Body": {
        **of(" of Alpha", lambda **x: Body(Sphere(1.0), name="Alpha", **x), "mass", u.kg, POSITIVE),
        **of(" of Alpha", lambda **x: Body(Sphere(1.0), name="Alpha", **x), "density", u.kg / u.m**3, POSITIVE),
    },
    "setups.Component": {
        **of(" of Moon", component, "semi_axes diameters", u.m, POSITIVE, (3,)),
        **of(" of Moon", component, "diameter", u.m, POSITIVE),
        **of(" of Moon", component, "mass", u.kg, POSITIVE),
        **of(" of Moon", component, "density", u.kg / u.m**3, POSITIVE),
        **of(" of Moon", lambda **x: component(diameter=1.0, **x), "rotation_period", u.s, PERIOD),
        **of(" of Moon", lambda **x: component(diameter=1.0, **x), "rotation_angle", u.rad, FINITE),
        **of(" of Moon", component, "tilt", u.rad, FINITE),
    },
}
ALL = {f"{owner}.{name}": field for owner, fields in (FIELDS | OTHERS).items() for name, field in fields.items()}


def test_every_declared_number_is_in_the_table():
    def classes(owner):
        return {owner}.union(*(classes(heir) for heir in owner.__subclasses__()))

    declared = {
        f"{owner.__module__.split('.')[1]}.{owner.__name__}.{name}"
        for owner in classes(Declared)
        for name, kind in (kinds_of(owner) if is_dataclass(owner) else {}).items()
        if isinstance(kind, Number)
        and owner.__module__.startswith("fullbody.")
        and name in inspect.get_annotations(owner)
    }
    assert declared == {f"{owner}.{name}" for owner, fields in FIELDS.items() for name in fields}


@pytest.mark.parametrize("name", ALL)
def test_each_declared_number_refuses_what_it_cannot_be(name):
    what, make, unit, (expected, outside), *shape = ALL[name]
    good = np.arange(1.0, 1.0 + np.prod(shape or 1)).reshape(shape[0] if shape else ())
    expected = expected.replace("a finite number", "finite numbers").replace("is not", "are not") if shape else expected

    def told(value):
        message = error(lambda: make(value))
        assert message.startswith(what + " ")
        return message

    for value in outside:
        arguments = good.copy()
        arguments[(-1,) * arguments.ndim] = value
        assert f"; expected {expected}" in told(arguments if shape else value)
        assert f"{value:g}" in told(arguments)
        assert len(told(arguments)) < 400
    for value in ("wide", True, 1j, b"1", 10**309):
        assert told(value).startswith(f"{what} is {reprlib.repr(value)}; expected {expected}")
    assert told(np.ma.masked) == f"{what} is masked; expected numbers throughout"
    assert "shape (1, 1, 2)" in told([[[1.0, 2.0]]])
    message = told(good * u.cd)
    if unit is None:
        assert message == f"{what} has the unit cd; expected pure numbers"
    else:
        assert message.startswith(f"{what} has the unit cd; expected a unit such as ")
        assert u.Unit(message.partition(" such as ")[2]).is_equivalent(unit)


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
    (lambda: SYSTEM.interactions(THREE), "bodies ... 3; expected 2"),
    (lambda: SYSTEM.energy(THREE), "bodies ... 3; expected 2"),
    (lambda: SYSTEM.momentum(THREE), "bodies ... 3; expected 2"),
    (lambda: SYSTEM.angular_momentum(THREE), "bodies ... 3; expected 2"),
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


def test_what_looks_odd_and_is_right_is_taken():
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
