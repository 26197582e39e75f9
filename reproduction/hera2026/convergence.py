"""The effects of the tolerance, the gravity rule, a triaxial Didymos and the number of members on the results."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from fullbody import Ellipsoid, State, System, Verner98

from . import measures, model, study, weights

if TYPE_CHECKING:
    import xarray

__all__ = ["CASES", "by_case", "by_number"]

#: The number of members that are run again; and by case the gravity, the tolerance, and the difference of Didymos'
#: equatorial axes in m.
COUNT: Final = 12
CASES: Final = {
    "as in the study": (model.GRAVITY, 1e-9, 0.0),
    "tolerance 1e-7": (model.GRAVITY, 1e-7, 0.0),
    "tolerance 1e-11": (model.GRAVITY, 1e-11, 0.0),
    "multipoles to the fourth order": ("multipole:4", 1e-9, 0.0),
    "triaxial Didymos, 819 x 801 m": (model.GRAVITY, 1e-9, 18.0),
}


def setup(gravity: str, difference: float, **values: float) -> tuple[System, State]:
    """Make the setup of the study with another gravity rule, and a difference of Didymos' equatorial axes in metres."""
    system, state = model.setup(**values)
    if difference:
        middle, polar = values["equatorial"] / 1e3, values["polar"] / 1e3
        a, b = (middle + sign * difference / 4e3 for sign in (1.0, -1.0))
        system = system.with_body(0, Ellipsoid(a, b, polar), mass=float(system.masses[0]))
    return system.with_options(gravity=gravity), state


def by_case(folder: Path, members: xarray.Dataset, progress: bool = False) -> dict[str, dict[str, Any]]:
    """Run some members again in each case to the end of the days observed and to arrival, and compare them."""
    rows = weights.resampled(weights.normalized(members.log_weight.values), COUNT)
    starts = {name: members[name].values[rows].astype(float) for name in model.NAMES}
    table: dict[str, dict[str, Any]] = {}
    reference: Any = None
    for k, (name, (gravity, tolerance, difference)) in enumerate(CASES.items()):
        result = study.sweep(
            partial(setup, gravity, difference),
            folder,
            f"convergence_{k}",
            starts,
            measures.ARRIVAL_TIME,
            partial(measures.measure, end=measures.ARRIVAL_TIME),
            progress,
            integrator=Verner98(tolerance, tolerance),
        )
        outcomes = measures.outcome_at_arrival(result)
        reference = (result, outcomes) if reference is None else reference
        table[name] = {
            "locked": float(np.mean(outcomes == "locked")),
            "same outcome": float(np.mean(outcomes == reference[1])),
            "period": 3600.0 * _median(result.observed_period - reference[0].observed_period),
            "precession": _median(result.observed_precession - reference[0].observed_precession),
        }
    return table


def _median(difference: xarray.DataArray) -> float:
    return float(np.nanmedian(np.abs(difference.values)))


def by_number(members: xarray.Dataset) -> dict[str, tuple[float, float]]:
    """Return the share of locked members and its sampling error from parts of the members, by their number."""
    locked = members.outcome.values == "locked"
    table = {}
    for count in (len(locked) // part for part in (4, 2, 1)):
        weight = weights.normalized(members.log_weight.values[:count])
        table[f"{count}"] = weights.share(weight, locked[:count])
    return table
