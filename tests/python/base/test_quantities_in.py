"""Every dimensional argument takes any unit of its kind, as Quantity or text, and refuses all else."""

import re
from collections import namedtuple

import fullbody
import numpy as np
import pytest
from astropy import constants
from astropy import units as u
from fullbody import (
    Body,
    Component,
    Ellipsoid,
    KeplerElements,
    LieGroupVariational,
    Simulation,
    Sphere,
    State,
    SymplecticSplitting,
    System,
    binary,
    frames,
)
from fullbody.errors import InvalidInput
from fullbody.events import Escape, Separation
from fullbody.observables import element_rates

UNITS = ("km", "hour", "kg")
SYSTEM, START = fullbody.systems.kw4(units=True)
R, V, W = START.position, START.velocity, START.spin
MU = SYSTEM.mu()
RUN = SYSTEM.integrate(START, 1.0, dense=True)
BALL = Body(Sphere(1 * u.km), mass=1e12 * u.kg)
SPEED, RATE = u.km / u.h, u.rad / u.h
ORBIT = {"a": 2 * u.km, "e": 0.1, "i": 0.1, "Omega": 0.2, "omega": 0.3, "M": 0.4}


def integrate(until=1 * u.h, **options):
    return SYSTEM.integrate(START, until, **options)


def stepped(until):
    sim = Simulation(SYSTEM, START)
    sim.step(until)
    return sim.time


def ellipsoid(**axes):
    return Ellipsoid(**{"a": 1 * u.km, "b": 1 * u.km, "c": 1 * u.km} | axes)


def orbit(**changed):
    return KeplerElements(**{**ORBIT, **changed})


def pair(primary=(), secondary=(), **changed):
    first = {"diameter": 1 * u.km, "density": 2000 * u.kg / u.m**3, "rotation_period": 3 * u.h, **dict(primary)}
    second = {"diameter": 0.3 * u.km, "density": 2000 * u.kg / u.m**3, **dict(secondary)}
    system, state = binary(
        Component(**{name: value for name, value in first.items() if value is not None}),
        Component(**{name: value for name, value in second.items() if value is not None}),
        **{"semi_major_axis": 2 * u.km, "units": UNITS, "mismatch_error": np.inf, "mismatch_warning": np.inf} | changed,
    )
    return (*(system.masses, state.position, state.velocity, state.spin, state.time), state.attitude)


def loose(**masses):
    """A pair whose components do not tell their masses."""
    return pair({"density": None}, {"density": None}, mass_ratio=0.1, **masses)


#: The argument's name in errors, a call that takes it, a good value, and the unit of results (None: pure numbers).
Case = namedtuple("Case", "what call value unit")

CASES = {
    "State position": Case("position", lambda x: State(x, V).position, R, u.km),
    "State velocity": Case("velocity", lambda x: State(R, x).velocity, V, SPEED),
    "State spin": Case("spin", lambda x: State(R, V, spin=x).spin, W, RATE),
    "State time": Case("time", lambda x: State(R, V, time=x).time, 3 * u.h, u.h),
    "State angles": Case("angles", lambda x: State.from_tait_bryan(R, V, x).tait_bryan, [[1, 2, 3]] * 2 * u.deg, None),
    "State.replace": Case("position", lambda x: START.replace(position=x).position, R, u.km),
    "Sphere": Case("radius", lambda x: Sphere(x).semi_axes[0], 1 * u.km, u.km),
    **{
        f"Ellipsoid {n}": Case(f"semi-axis {n}", lambda x, n=n: getattr(ellipsoid(**{n: x}), n), 2 * u.km, u.km)
        for n in "abc"
    },
    "Body mass": Case("mass", lambda x: Body(Sphere(1 * u.km), mass=x).density, 1 * u.kg, u.kg / u.km**3),
    "Body density": Case("density", lambda x: Body(Sphere(1 * u.km), density=x).mass, 1 * u.kg / u.km**3, u.kg),
    "potential points": Case("point", lambda x: BALL.gravity(x).potential, [3, 0, 0] * u.km, u.km**2 / u.s**2),
    "potential G": Case("G", lambda x: BALL.gravity([3, 0, 0] * u.km, x).potential, constants.G * 1, u.km**2 / u.s**2),
    "field points": Case("point", lambda x: BALL.gravity(x).field, [[3, 0, 0], [0, 4, 0]] * u.km, u.km / u.s**2),
    "field G": Case("G", lambda x: BALL.gravity([3, 0, 0] * u.km, x).field, constants.G * 1, u.km / u.s**2),
    "System G": Case("G", lambda x: System(SYSTEM.bodies, G=x, units=UNITS).G, SYSTEM.G, SYSTEM.G.unit),
    "integrate until": Case("until", lambda x: integrate(x).time, 2 * u.h, u.h),
    "integrate output": Case("output", lambda x: integrate(output=x).time, 0.25 * u.h, u.h),
    "integrate outputs": Case("output", lambda x: integrate(output=x).time, [0.25, 0.5] * u.h, u.h),
    "Simulation.step": Case("until", stepped, 0.01 * u.h, u.h),
    "Simulation.integrate": Case("until", lambda x: Simulation(SYSTEM, START).integrate(x).position, 1 * u.h, u.km),
    "splitting": Case("step", lambda x: integrate(integrator=SymplecticSplitting(x)).time, 0.25 * u.h, u.h),
    "variational": Case("step", lambda x: integrate(integrator=LieGroupVariational(x)).time, 0.25 * u.h, u.h),
    "Separation": Case("value of Separation", lambda x: integrate(events=[Separation(0, 1, x)]).time, 3 * u.km, u.h),
    "Escape": Case("distance of Escape", lambda x: integrate(events=[Escape(0, 1, x)]).time, 3 * u.km, u.h),
    "Run.elements mu": Case("mu", lambda x: RUN.elements(mu=x).a, MU, u.km),
    "element_rates mu": Case("mu", lambda x: element_rates(LONG, mu=x).mean_rates["a"], MU, u.km / u.h),
    "Dense": Case("time", lambda x: RUN(x).velocity, 0.5 * u.h, SPEED),
    "Dense times": Case("time", lambda x: RUN(x).spin, [0.5, 0.25] * u.h, RATE),
    "KeplerElements a": Case("a", lambda x: orbit(a=x).to_cartesian(MU)[0], 2 * u.km, u.km),
    **{
        f"KeplerElements {n}": Case(n, lambda x, n=n: orbit(**{n: x}).to_cartesian(MU)[1], 10 * u.deg, SPEED)
        for n in ("i", "Omega", "omega", "M")
    },
    "to_cartesian mu": Case("mu", lambda x: orbit().to_cartesian(x)[0], MU, u.km),
    "period mu": Case("mu", lambda x: orbit().period(x), MU, u.h),
    "from_cartesian r": Case("r", lambda x: KeplerElements.from_cartesian(x, V[1], MU).a, R[1], u.km),
    "from_cartesian v": Case("v", lambda x: KeplerElements.from_cartesian(R[1], x, MU).i, V[1], u.rad),
    "from_cartesian mu": Case("mu", lambda x: KeplerElements.from_cartesian(R[1], V[1], x).a, MU, u.km),
    "pole_vector longitude": Case("longitude", lambda x: frames.pole_vector(x, 0.1), 10 * u.deg, None),
    "pole_vector latitude": Case("latitude", lambda x: frames.pole_vector(0.1, x), 10 * u.deg, None),
    "rotate_pole": Case("longitude", lambda x: frames.rotate_pole(x, 0.1, "ecliptic", "icrs")[1], 10 * u.deg, u.rad),
    "attitude longitude": Case("longitude", lambda x: frames.attitude(x, 0.1), 10 * u.deg, None),
    "attitude latitude": Case("latitude", lambda x: frames.attitude(0.1, x), 10 * u.deg, None),
    "attitude angle": Case("angle", lambda x: frames.attitude(0.1, 0.1, x), 10 * u.deg, None),
    "binary semi_major_axis": Case("semi_major_axis", lambda x: pair(semi_major_axis=x)[1], 2 * u.km, u.km),
    "binary period": Case("period", lambda x: pair(semi_major_axis=None, period=x)[1], 10 * u.h, u.km),
    "binary total_mass": Case("total_mass", lambda x: loose(total_mass=x)[0], 1e12 * u.kg, u.kg),
    "binary G": Case("G", lambda x: pair(G=x)[2], SYSTEM.G, SPEED),
    "binary time": Case("time", lambda x: pair(time=x)[4], 1 * u.h, u.h),
    **{
        f"binary {name}": Case(name, lambda x, name=name: pair(**{name: x})[5], 10 * u.deg, None)
        for name in ("argument_of_periapsis", "mean_anomaly", "libration")
    },
    "binary pole": Case("pole", lambda x: pair(pole=x)[1], [10, 20] * u.deg, u.km),
    "Component pole": Case("pole", lambda x: pair({"pole": x})[5], [10, 20] * u.deg, None),
    "Component rotation_angle": Case("rotation_angle", lambda x: pair({"rotation_angle": x})[5], 10 * u.deg, None),
    "Component rotation_period": Case("rotation_period", lambda x: pair({"rotation_period": x})[3], 3 * u.h, RATE),
    "Component density": Case("density", lambda x: pair({"density": x})[0], 2000 * u.kg / u.m**3, u.kg),
    "Component mass": Case("mass", lambda x: pair({"density": None, "mass": x})[0], 1e12 * u.kg, u.kg),
    "Component diameter": Case("diameter", lambda x: pair({"diameter": x})[0], 1 * u.km, u.kg),
    **{
        f"Component {n}": Case(n, lambda x, n=n: pair({"diameter": None, n: x})[0], [0.9, 0.8, 0.7] * u.km, u.kg)
        for n in ("semi_axes", "diameters")
    },
}
LONG = SYSTEM.integrate(START, 40.0, output=1.0)
#: Arguments that are one number or many.
SCALARS_OR_ARRAYS = (
    "integrate output",
    "integrate outputs",
    "Dense",
    "Dense times",
    *(f"KeplerElements {name}" for name in ORBIT),
)
#: Names of arguments in errors of the core, which sees plain numbers.
CALLED = {
    "KeplerElements a": "semi-major axis",
    "KeplerElements i": "inclination",
    "KeplerElements Omega": "node",
    "KeplerElements omega": "periapsis",
    "KeplerElements M": "mean anomaly",
    "from_cartesian r": "position",
    "from_cartesian v": "velocity",
}
#: Endless: a step towards infinity, and a body that does not rotate.
ENDLESS = ("Simulation.step", "Component rotation_period")
OTHER = {"km": u.AU, "h": u.day, "kg": u.t, "deg": u.arcmin}
OTHER |= {"rad / h": u.deg / u.s, "km / h": u.m / u.s, "kg / m3": u.g / u.cm**3}


def numbers(result):
    return np.asarray(result.value if isinstance(result, u.Quantity) else result, dtype=float)


@pytest.mark.parametrize("name", CASES)
def test_any_unit_and_text_give_the_same_result(name):
    case = CASES[name]
    expected = case.call(case.value)
    if case.unit is None:
        assert not isinstance(expected, u.Quantity)
    else:
        assert isinstance(expected, u.Quantity)
        assert expected.unit.to(case.unit) == pytest.approx(1.0, rel=1e-15)
    other = case.value.to(OTHER.get(str(case.value.unit), case.value.si.unit))
    assert other.unit != case.value.unit or name.endswith(" G")
    result = case.call(other)
    result = result.to(case.unit) if case.unit is not None else result
    if not name.startswith("Simulation.step"):
        np.testing.assert_allclose(
            numbers(result), numbers(expected), rtol=1e-9, atol=1e-9 * abs(numbers(expected)).max()
        )

    def text(value):
        return [text(part) for part in value] if value.shape else f"{float(value.value)!r} {value.unit}"

    np.testing.assert_array_equal(numbers(case.call(text(case.value))), numbers(expected))


@pytest.mark.parametrize("name", CASES)
def test_other_units_shapes_and_values_that_are_not_finite_are_refused(name):
    case, value = CASES[name], CASES[name].value

    def message_for(wrong):
        with pytest.raises(InvalidInput) as caught:
            case.call(wrong)
        return str(caught.value)

    message = message_for(value.value * u.cd)
    assert case.what in message
    assert " cd" in message
    assert u.Unit(message.split("such as ")[-1]).is_equivalent(value.si.unit)
    for bad in (np.nan,) if name in ENDLESS else (np.nan, np.inf, -np.inf):
        wrong = value.copy()
        wrong[(-1,) * value.ndim] = bad * value.unit
        message = message_for(wrong).lower()
        assert CALLED.get(name, case.what).lower() in message
        assert str(bad) in message
    if name not in SCALARS_OR_ARRAYS:
        assert case.what in message_for(u.Quantity([value, value]) if value.ndim == 0 else value[..., :-1])
    if not name.endswith("points"):
        for wrong in ("wide", True, 1j, b"1", 10**309, np.ma.masked):
            message = message_for(wrong)
            assert re.search(rf"{re.escape(case.what)}\b.* (is|has) .*; expected ", message, re.DOTALL)
            assert "masked" in message or wrong is not np.ma.masked
