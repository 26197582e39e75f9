"""Targets for observations, the tables that they are read from, and the arguments of a fit."""

from __future__ import annotations

from typing import Any

import fullbody
import numpy as np
import pandas as pd
from astropy import units as u
from fullbody import observing
from hypothesis import strategies as st

from .calls import _ANY, _NUMBERS, _POSITIVE, _or_any, _target
from .target import Target, check_finite

_TIMES = st.lists(st.floats(0.0, 5.0), min_size=1, max_size=4)
_UNITS = st.sampled_from([None, u.h, u.km, u.mas, u.mag, u.km / u.s])


def _columns(size: int) -> Any:
    """Return a strategy of the values of a column, some with a unit, and some of any kind."""
    values = st.lists(st.one_of(st.floats(-5.0, 5.0), st.just(np.nan)), min_size=size, max_size=size)
    with_unit = st.builds(lambda column, unit: column if unit is None else column * unit, values, _UNITS)
    return _or_any(st.one_of(values, with_unit))


_GEOMETRIES = st.fixed_dictionaries(
    {"times": _or_any(st.just([0.0, 6.0])), "to_observer": _or_any(st.just([1e3, 2e2, 4e2]))},
    optional={
        "to_sun": _or_any(st.sampled_from([[1e4, 0.0, 0.0], [[1e4, 0.0, 0.0], [0.0, 1e4, 0.0]]])),
        "frame": _or_any(st.sampled_from([None, "ecliptic", "equatorial"])),
        "light_time": _or_any(st.just(False)),
    },
)
_BODIES = {name: _or_any(st.sampled_from([0, 1, "Alpha", "Beta"])) for name in ("body", "about")}
_SIGMA = _or_any(_POSITIVE)
_OBSERVED = _TIMES.flatmap(
    lambda times: st.one_of(
        st.tuples(
            st.just("RadarAstrometry"),
            st.fixed_dictionaries(
                {"times": _or_any(st.just(times)), "sigma": st.one_of(_SIGMA, st.tuples(_SIGMA, _SIGMA)), **_BODIES},
                optional={"range": _columns(len(times)), "range_rate": _columns(len(times))},
            ),
        ),
        st.tuples(
            st.just("Astrometry"),
            st.fixed_dictionaries(
                {"times": _or_any(st.just(times)), "sigma": _SIGMA, **_BODIES}
                | {name: _columns(len(times)) for name in ("east", "north")},
                optional={"correlation": _or_any(st.floats(-1.0, 1.0)), "photocentre": _or_any(st.booleans())},
            ),
        ),
        st.tuples(
            st.just("Photometry"),
            st.fixed_dictionaries(
                {"times": _or_any(st.just(times)), "magnitude": _columns(len(times)), "sigma": _SIGMA},
                optional={
                    "albedo": _or_any(st.floats(0.0, 1.0)),
                    "zero": _or_any(st.just("free")),
                    "sun_radius": _or_any(st.floats(0.0, 0.1)),
                    "night": _or_any(st.just(list(range(len(times))))),
                },
            ),
        ),
    )
)
#: A run of 1999 KW4, which is computed once.
_SYSTEM, _STATE = fullbody.systems.kw4()
_SYSTEM = _SYSTEM.with_options(frame="ecliptic")
_RUN = _SYSTEM.integrate(_STATE, 6.0, dense=True)


def _check_observed(arguments: tuple[dict[str, Any], tuple[str, dict[str, Any]], Any]) -> None:
    geometry, (kind, options), jitter = arguments
    data = getattr(observing, kind)(**options, geometry=observing.Geometry(**geometry))
    assert repr(data)
    assert len(data) >= 1
    if jitter is not None:
        data = data.with_jitter(jitter)
    check_finite(data.pulls(_RUN), *data.errors(_SYSTEM))


def _table(names: tuple[str, ...]) -> Any:
    """Return a strategy of columns of two rows, most of which are numbers of a usual size."""
    usual = st.lists(st.floats(0.1, 5.0), min_size=2, max_size=2)
    numbers = st.lists(_NUMBERS, min_size=2, max_size=2)
    column = _or_any(st.one_of(usual, usual, numbers), 9)
    return st.fixed_dictionaries({name: column for name in ("times", *names)})


def _check_table(arguments: tuple[dict[str, Any], dict[str, Any]]) -> None:
    columns, options = arguments
    geometry = observing.Geometry([0.0, 6.0], to_observer=[1e3, 2e2, 4e2], light_time=False)
    for kind in (observing.RadarAstrometry, observing.Astrometry, observing.Photometry):
        try:
            # Columns that pandas refuses do not reach this package.
            table = pd.DataFrame(columns)
        except (ValueError, TypeError, OverflowError):
            return
        try:
            check_finite(kind.from_table(table, geometry=geometry, **options).pulls(_RUN))
        except fullbody.FullbodyError:
            continue


def _setup(mass: float, a: float) -> Any:
    if not (0.5 < mass < 5.0 and 1.0 < a < 5.0):
        # Close and heavy bodies would take millions of steps.
        raise ValueError("mass or a is out of range")
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (mass, 0.1)]
    state = fullbody.State([[0.0] * 3, [a, 0.0, 0.0]], [[0.0] * 3, [0.1, 0.9, 0.3]])
    return fullbody.System(bodies, G=1.0, gravity="point"), state


_VIEW = observing.Geometry([0.0, 9.0], to_observer=[1e3, 2e2, 4e2], light_time=False)
_RANGES = observing.RadarAstrometry(
    [1.0, 2.0, 3.0, 4.0], range=[0.5, 1.5, 1.0, -1.0], sigma=0.5, body=1, about=0, geometry=_VIEW
)
_START = _or_any(st.floats(1.5, 3.5))
_FREE = st.builds(
    lambda start, options: fullbody.fitting.Free(start, **options),
    _START,
    st.fixed_dictionaries(
        {},
        optional={
            "min": _or_any(st.floats(0.0, 1.0)),
            "max": _or_any(st.floats(2.0, 20.0)),
            "prior": _or_any(st.tuples(_NUMBERS, _POSITIVE)),
        },
    ),
)
_FITS = st.fixed_dictionaries(
    {"parameters": _or_any(st.fixed_dictionaries({"mass": st.one_of(_FREE, _START), "a": st.one_of(_FREE, _START)}))},
    optional={
        "observations": _or_any(st.sampled_from([_RANGES, [_RANGES, _RANGES]])),
        "loss": _or_any(st.sampled_from(["linear", "huber", fullbody.fitting.Outliers()])),
        "starts": _or_any(st.sampled_from([1, 2, [{"mass": 2.0, "a": 2.5}]])),
        "rng": _or_any(st.integers(0, 3)),
    },
)


def _check_fit(arguments: dict[str, Any]) -> None:
    result = fullbody.fit(
        _setup,
        arguments.pop("parameters"),
        arguments.pop("observations", _RANGES),
        integrator=fullbody.Verner65(rtol=1e-6, atol=1e-6),
        **arguments,
    )
    assert repr(result)
    check_finite(list(result.values.values()), result.chi2, result.correlation)
    assert not np.isnan(result.covariance).any()


TARGETS: list[Target] = [
    _target(
        "observations", st.tuples(_GEOMETRIES, _OBSERVED, st.one_of(st.none(), _or_any(_POSITIVE))), _check_observed
    ),
    _target(
        "observations-table",
        st.tuples(
            st.sampled_from(
                [
                    ("range", "sigma_range"),
                    ("range_rate", "sigma_range_rate"),
                    ("range", "range_rate", "sigma_range", "sigma_range_rate"),
                    ("east", "north", "sigma_east", "sigma_north"),
                    ("magnitude", "sigma"),
                ]
            ).flatmap(_table),
            st.fixed_dictionaries(
                {},
                optional={
                    "columns": _or_any(st.just({"times": "sigma"})),
                    "unit": _ANY,
                    "dates": _or_any(st.sampled_from([("jd", "utc"), ("iso", "tdb"), ("mjd", "x")])),
                },
            ),
        ),
        _check_table,
    ),
    _target("fit", _FITS, _check_fit),
]
