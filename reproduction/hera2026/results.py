"""The small files that the study leaves for its page and its notebook, and what they say."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from fullbody.base.atomic import replacing

from . import measures, model
from .inputs import INPUTS

if TYPE_CHECKING:
    import xarray

__all__ = ["consistent", "kept", "predictions", "refuting", "save", "sensitivities"]

#: Inputs whose sign does not matter to what is predicted, but for a mirror image.
SIGNLESS: Final = ("normal", "miss_normal", "yaw", "radial")
#: Members whose states and angles are kept.
KEPT: Final = 60
#: What is predicted, with units.
PREDICTED: Final = {
    "libration": "deg",
    "libration_period": "h",
    "obliquity": "deg",
    "last_roll": "deg",
    "spin_period": "h",
    "period": "h",
    "period_drift": "s",
    "semi_major_axis": "m",
    "eccentricity": "",
    "precession": "deg/day",
}


def complete(found: xarray.Dataset) -> xarray.Dataset:
    """The members that have an outcome."""
    return found.isel(row=np.flatnonzero(found.error.values != "NotComputed"))


def kept(found: xarray.Dataset) -> xarray.Dataset:
    """The map in single precision, with the states and angles of the first members alone."""
    found = complete(found)
    small = found.drop_vars(["state", "angles", "error_text", "unmeasured", "tumbles"])
    for name in small.data_vars:
        if small[name].dtype.kind == "f" and name not in ("longitude", "period", "period_after"):
            small[name] = small[name].astype(np.float32)
    few = found.isel(row=slice(KEPT)).rename(row="kept")
    angles, state = few.angles.astype(np.float32), few.state
    small["angles"] = ("kept", "time", "angle"), angles.values
    small["state"] = ("kept", "body", "component"), state.values
    small["outcome"] = "row", measures.outcome(found).astype(str)
    return small


def save(found: xarray.Dataset, path: Path) -> None:
    """Write the results, compressed."""
    packed = {name: {"zlib": True, "complevel": 9} for name in found.data_vars if found[name].dtype.kind == "f"}
    with replacing(path) as temporary:
        found.to_netcdf(temporary, encoding=packed)


def consistent(found: xarray.Dataset) -> Any:
    """Whether each member's own orbit shows the published advance of the apses, within three errors (row,)."""
    one = INPUTS["precession"]
    return np.abs(found.precession_after.values - one.value) < 3.0 * one.sigma


def derived(found: xarray.Dataset) -> dict[str, Any]:
    """The predicted numbers of all members, in the units of :data:`PREDICTED`."""
    numbers = {name: found[name].values.astype(float) for name in PREDICTED if name in found}
    numbers["spin_period"] = 2.0 * np.pi / found.spin.values
    numbers["period_drift"] = 3600.0 * (found.period.values - found.period_after.values)
    numbers["semi_major_axis"] = 1e3 * numbers["semi_major_axis"]
    return {name: numbers[name] for name in PREDICTED}


def predictions(found: xarray.Dataset, chosen: Any) -> dict[str, tuple[float, float, float]]:
    """Median and limits of 90 per cent of the chosen members, of what they have."""
    told = {}
    for name, values in derived(found).items():
        mine = values[chosen]
        mine = mine[np.isfinite(mine)]
        told[name] = tuple(np.percentile(mine, [50, 5, 95])) if len(mine) >= 5 else (np.nan,) * 3
    return told


def sensitivities(found: xarray.Dataset, chosen: Any) -> dict[str, dict[str, float]]:
    """Rank correlations of the predicted numbers with the inputs, of the chosen members; nan where nothing varies."""
    from scipy.stats import spearmanr

    numbers = derived(found) | {"locked": (found.outcome.values == "locked").astype(float)}
    inputs = {name: found[name].values for name in model.NAMES}
    inputs |= {name: np.abs(inputs[name]) for name in SIGNLESS}
    table: dict[str, dict[str, float]] = {}
    for name, values in numbers.items():
        good = chosen & np.isfinite(values)
        varies = good.sum() >= 10 and np.ptp(values[good]) > 0.0
        table[name] = {
            one: float(spearmanr(of[good], values[good]).statistic) if varies else np.nan for one, of in inputs.items()
        }
    return table


def refuting(found: xarray.Dataset) -> dict[str, Any]:
    """Which members are as :data:`reproduction.hera2026.report.REFUTED` says that Dimorphos is not, by its names."""
    numbers, b_c = derived(found), found.b_c.values
    locked, rolling = (found.outcome.values == word for word in ("locked", "rolling"))
    libration, obliquity, eccentricity = (numbers[name] for name in ("libration", "obliquity", "eccentricity"))
    advancing = locked & (np.abs(numbers["precession"] - 6.7) < 0.6)
    return {
        "tumbling": found.outcome.values == "tumbling",
        "rolling": rolling & ((b_c < 1.05) | (eccentricity > 0.027) | (obliquity < 7.0)),
        "locked": locked & ((libration > 40.0) | (obliquity > 30.0)),
        "locked, with apses that advance by 6.1 to 7.3 degrees a day": advancing
        & ((b_c > 1.25) | (eccentricity < 0.02)),
        "period": np.abs(numbers["period_drift"]) > 90.0,
    }
