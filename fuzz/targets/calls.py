"""Targets for arguments: the constructors, and the use of their objects."""

from __future__ import annotations

import datetime
import decimal
import fractions
from collections.abc import Callable
from typing import Any

import fullbody
import numpy as np
from astropy import units as u
from fullbody import events
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from .target import Target, check_finite, check_object, check_start, check_state, package_errors_only

_NUMBERS = st.one_of(
    st.floats(),
    st.floats(-10.0, 10.0),
    st.integers(-5, 5),
    st.sampled_from([0, -1, 5e-324, 1e-300, 1e-30, 1e30, 1e150, 1.7e308, np.nan, np.inf, 10**400, -(10**30)]),
)
_UNITS = [u.km, u.m, u.au, u.s, u.h, u.kg, u.deg, u.rad, u.rad / u.h, u.deg / u.day, u.Hz, u.km / u.s, u.g / u.cm**3]
_UNITS += [u.K, u.one, u.percent, u.mag, u.m**3 / u.s**2]
_TEXTS = ["1 km", "2.5 h", "3 deg", "1 kg", "nan km", "1e400 m", "km", "", "Alpha", "focal", "point", "multipole:4"]
_TEXTS += ["multipole:-2", "multipole:99", "multipole:x", "surface", "tait_bryan", "portable", "avx2", "é\0", "\ud800"]


#: Anything at all.
_ANY = st.one_of(
    _NUMBERS,
    st.sampled_from(_TEXTS),
    st.text(max_size=3),
    st.sampled_from([None, True, False, b"1", ..., int, object(), len, {}, {"a": 1}, set(), range(3), 1j]),
    st.sampled_from(
        [
            *(decimal.Decimal("1.5"), decimal.Decimal("nan"), fractions.Fraction(1, 3), datetime.date(2020, 1, 1)),
            *(np.float32(1.5), np.int8(3), np.bool_(True), np.str_("a"), np.datetime64("2020-01-01"), np.longdouble(2)),
            *(
                np.ma.masked,
                np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0]),
                np.array(None),
                np.array("a"),
                np.zeros((0, 3)),
            ),
            *(u.km, 1 * u.km, [1, 2, 3] * u.km, [1 * u.km, 2 * u.s, 3], np.array([[1, 2], [3]], dtype=object)),
            *(np.array([], dtype=object), np.array([None, 1.0]), np.array([1.0, 2.0, 3.0], dtype=object), [[], [0.0]]),
        ]
    ),
    st.builds(lambda number, unit: u.Quantity(float(number), unit), st.floats(), st.sampled_from(_UNITS)),
    st.lists(_NUMBERS, max_size=5),
    st.lists(st.lists(_NUMBERS, max_size=4), max_size=3),
    st.lists(st.one_of(_NUMBERS, st.sampled_from(_TEXTS), st.none()), max_size=4).map(tuple),
    arrays.arrays(
        st.sampled_from([np.float64, np.float32, np.int32, np.bool_, np.complex128, np.dtype("U3")]),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
)
_POSITIVE = st.floats(1e-3, 10.0)


def _or_any(valid: Any, odds: int = 7) -> Any:
    """Return a strategy of valid values, and with these odds against it of anything."""
    return st.integers(0, odds).flatmap(lambda k: _ANY if k == 0 else valid)


def _rows(width: int, count: int = 2) -> Any:
    row = st.lists(st.floats(-10.0, 10.0), min_size=width, max_size=width)
    return st.lists(row, min_size=count, max_size=count)


_SHAPES = st.one_of(
    st.just(("PointMass", {})),
    st.fixed_dictionaries({"radius": _or_any(_POSITIVE)}).map(lambda arguments: ("Sphere", arguments)),
    st.fixed_dictionaries({axis: _or_any(_POSITIVE, 12) for axis in "abc"}).map(
        lambda arguments: ("Ellipsoid", arguments)
    ),
)
_BODIES = st.fixed_dictionaries(
    {"shape": _SHAPES},
    optional={
        "mass": _or_any(_POSITIVE),
        "density": _or_any(_POSITIVE),
        "name": _or_any(st.sampled_from(["A", "B", "Alpha", "ä", None])),
    },
)
_SYSTEMS = st.fixed_dictionaries(
    {"bodies": st.lists(_BODIES, min_size=0, max_size=3)},
    optional={
        "G": _or_any(_POSITIVE),
        "gravity": _or_any(st.sampled_from(["focal", "surface", "multipole:4", "point"])),
        "gravity_tolerance": _or_any(st.sampled_from([1e-14, 1e-8, 0.5])),
        "order": _or_any(st.sampled_from([None, (4, 8), (0, 0), (1, 1), (200, 3)])),
        "units": _or_any(st.sampled_from([None, True, ("km", "hour", "kg"), ("km", "km", "kg"), "kms"])),
        "attitude_chart": _or_any(st.sampled_from(["quaternion", "tait_bryan"])),
        "vector_path": _or_any(st.sampled_from(["auto", "portable"])),
        "epoch": _or_any(st.sampled_from([None, "2022-09-26 TDB", "2022"])),
        "frame": _or_any(st.sampled_from([None, "ecliptic"])),
    },
)
_STATES = st.fixed_dictionaries(
    {"position": _or_any(_rows(3)), "velocity": _or_any(_rows(3))},
    optional={"attitude": _or_any(_rows(4)), "spin": _or_any(_rows(3)), "time": _or_any(st.floats(-10, 10))},
)
_ANGLED = st.fixed_dictionaries(
    {"position": _or_any(_rows(3)), "velocity": _or_any(_rows(3)), "angles": _or_any(_rows(3))},
    optional={"spin": _or_any(_rows(3)), "time": _or_any(st.floats(-10, 10))},
)
_ELEMENTS = st.fixed_dictionaries(
    {
        "a": _or_any(st.floats(-5, 5)),
        "e": _or_any(st.floats(0, 3)),
        **{angle: _or_any(st.floats(-7, 7)) for angle in ("i", "Omega", "omega", "M")},
    }
)
_INTEGRATORS = st.one_of(
    st.tuples(
        st.sampled_from(["Verner98", "Verner87", "Verner76", "Verner65", "DormandPrince54"]),
        st.fixed_dictionaries({}, optional={name: _or_any(st.floats(1e-12, 0.1)) for name in ("rtol", "atol")}),
    ),
    st.tuples(st.just("LieGroupVariational"), st.fixed_dictionaries({"step": _or_any(st.floats(0.05, 1.0))})),
    st.tuples(
        st.just("SymplecticSplitting"),
        st.fixed_dictionaries(
            {"step": _or_any(st.floats(0.05, 1.0))},
            optional={"scheme": _or_any(st.sampled_from(["ABA864", "ABA1064", "leapfrog"]))},
        ),
    ),
)
_BODY = _or_any(st.sampled_from([0, 1, "A", "B"]))
_EVENTS = st.tuples(
    st.sampled_from([name for name in events.__all__ if name not in ("Event", "Occurrence")]),
    st.fixed_dictionaries(
        {},
        optional={
            **dict.fromkeys(("body", "about", "by"), _BODY),
            "value": _or_any(_POSITIVE),
            "distance": _or_any(_POSITIVE),
            "normal": _or_any(st.lists(st.floats(-1, 1), min_size=3, max_size=3)),
            "f": _or_any(st.sampled_from([lambda state: state.time - 0.5, lambda state: None, lambda state: np.nan])),
            "direction": _or_any(st.sampled_from([-1, 0, 1])),
            "terminal": _or_any(st.booleans()),
        },
    ),
)


def _shape(arguments: tuple[str, dict[str, Any]]) -> Any:
    return getattr(fullbody, arguments[0])(**arguments[1])


def _body(arguments: dict[str, Any]) -> Any:
    return fullbody.Body(**{**arguments, "shape": _shape(arguments["shape"])})


def _system(arguments: dict[str, Any]) -> Any:
    bodies = arguments["bodies"]
    return fullbody.System(**{**arguments, "bodies": [_body(body) for body in bodies]})


def _check_system(arguments: tuple[dict[str, Any], dict[str, Any]]) -> None:
    system = _system(arguments[0])
    check_finite(system.masses, system.G)
    check_object(system)
    for body in system.bodies:
        check_object(body)
    check_start(system, fullbody.State(**arguments[1]))


def _check_state(arguments: dict[str, Any]) -> None:
    state = fullbody.State(**arguments)
    check_state(state)
    check_state(state.replace(time=state.time))


def _check_angled(arguments: dict[str, Any]) -> None:
    check_state(fullbody.State.from_tait_bryan(**arguments))


def _check_elements(arguments: tuple[dict[str, Any], Any, Any, Any]) -> None:
    values, mu, r, v = arguments
    with package_errors_only():
        elements = fullbody.KeplerElements(**values)
        check_object(elements)
        check_finite(*elements.to_cartesian(mu))
    k = fullbody.KeplerElements.from_cartesian(r, v, mu)
    check_finite(k.a, k.e, k.i, k.Omega, k.omega, k.M)
    check_object(k)


class _LongEnough(fullbody.FullbodyError):
    """Ends a run that would take long."""


def _stop(*_: Any) -> None:
    raise _LongEnough("long enough")


def _check_run(arguments: tuple[Any, Any, Any, Any, list[Any]]) -> None:
    """Check a short run of case 1 with any integrator, end, output and events."""
    (kind, settings), until, output, event_arguments, dense = arguments
    integrator = getattr(fullbody, kind)(**settings)
    check_object(integrator)
    system, state = fullbody.systems.case1(gravity="point")
    run_events = []
    for name, values in event_arguments:
        event = getattr(events, name)
        values = {"body": 1, "by": 0, "f": lambda state: 1.0} | values
        run_events.append(event(**{key: value for key, value in values.items() if key in event.__dataclass_fields__}))
        assert repr(run_events[-1])
    run = system.integrate(
        state, until, output=output, integrator=integrator, events=run_events, dense=dense, progress=_stop
    )
    check_finite(*run.arrays.values())
    for occurrence in run.events:
        check_finite(occurrence.time)
    if run.dense is not None and len(run):
        check_state(run(run.time[-1]))


def _target(name: str, inputs: Any, check: Callable[[Any], None]) -> Target:
    def checked(arguments: Any) -> None:
        with package_errors_only():
            check(arguments)

    return Target(name, inputs, checked)


TARGETS: list[Target] = [
    _target("system", st.tuples(_SYSTEMS, _STATES), _check_system),
    _target("state", _STATES, _check_state),
    _target("tait-bryan", _ANGLED, _check_angled),
    _target(
        "elements",
        st.tuples(_ELEMENTS, _or_any(_POSITIVE), *[_or_any(st.lists(st.floats(-5, 5), min_size=3, max_size=3))] * 2),
        _check_elements,
    ),
    _target(
        "run",
        st.tuples(
            _INTEGRATORS,
            _or_any(st.floats(-3.0, 3.0)),
            _or_any(st.one_of(st.none(), st.floats(0.1, 1.0), st.lists(st.floats(0.0, 3.0), max_size=4))),
            st.lists(_EVENTS, max_size=2),
            st.booleans(),
        ),
        _check_run,
    ),
]
