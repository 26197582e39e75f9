"""The small files of results for the page and the notebook of the study, and the numbers in them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt
from fullbody.base.atomic import replacing

from . import measures, model, weights
from .inputs import DATES, INPUTS

if TYPE_CHECKING:
    import xarray

__all__ = ["CRITERIA", "by_date", "by_evidence", "by_width", "criteria", "predictions", "save", "score"]
__all__ += ["scores", "sensitivities", "stored"]

#: Inputs whose sign only mirrors the motion.
SIGNLESS: Final = ("normal", "miss_normal", "yaw", "radial")
#: The numbers of members whose states and angles are stored, and of equally weighted ones that represent the posterior.
STORED: Final = 60
EQUAL: Final = 2000
#: Predicted quantities, with units and the decimals that are shown.
PREDICTED: Final = {
    "libration": ("deg", 0),
    "libration_period": ("h", 1),
    "obliquity": ("deg", 1),
    "last_roll": ("deg", 0),
    "spin_period": ("h", 2),
    "period": ("h", 3),
    "period_drift": ("s", 0),
    "semi_major_axis": ("m", 0),
    "eccentricity": ("", 3),
    "precession": ("deg/day", 1),
}
#: Scored quantities with their errors, which contain those of Hera and the width of the kernel.
SCORED: Final = {
    "libration": 3.0,
    "obliquity": 1.5,
    "eccentricity": 0.002,
    "period_drift": 8.0,
    "a_b": 0.02,
    "b_c": 0.03,
}
#: Widths of priors that are tried.
WIDTHS: Final = ("a_b", "b_c", "normal", "log_k2_q")
#: Likelihood ratios of the report of a change.
RATIOS: Final = (1.0, 3.0, 10.0, 30.0, np.inf)
#: Findings that the prediction makes improbable.
CRITERIA: Final = {
    "end over end": "the long axis of Dimorphos does not remain within 60 degrees of the direction to Didymos",
    "rolling and round": "Dimorphos rolls, and b/c is below 1.05",
    "rolling on an ellipse": "Dimorphos rolls, and its eccentricity is above 0.027",
    "locked and circular": "Dimorphos is locked, and its eccentricity is below 0.015",
    "locked and flat": "Dimorphos is locked, and b/c is above 1.35",
    "swinging": "Dimorphos is locked, and its long axis swings by more than 40 degrees to either side of Didymos",
    "tilted": "Dimorphos is locked, and its obliquity is above 20 degrees",
    "period": "the period has changed since the first 67 days by more than 90 seconds",
}


def stored(members: xarray.Dataset) -> xarray.Dataset:
    """Return the members in single precision, with the states and angles of some that represent the posterior."""
    result = members.drop_vars(["state", "angles", "error_text", "error_stage", "unmeasured"])
    for name in result.data_vars:
        if result[name].dtype.kind == "f" and name not in ("period", "observed_period", "log_weight"):
            result[name] = result[name].astype(np.float32)
    rows = np.unique(weights.resampled(weights.normalized(members.log_weight.values), STORED))
    # The name of this dimension is that of the files in the repository.
    result["member"] = "kept", rows
    result["angles"] = ("kept", "time", "angle"), members.angles.values[rows].astype(np.float32)
    result["state"] = ("kept", "body", "component"), members.state.values[rows]
    result["outcome"] = "row", measures.outcome_at_arrival(members).astype(str)
    return result


def save(dataset: xarray.Dataset, path: Path) -> None:
    """Write results, with compression."""
    encoding = {name: {"zlib": True, "complevel": 9} for name in dataset.data_vars if dataset[name].dtype.kind == "f"}
    with replacing(path) as temporary:
        dataset.to_netcdf(temporary, encoding=encoding)


def by_evidence(members: xarray.Dataset) -> list[dict[str, Any]]:
    """Return the share of locked members for likelihood ratios of the report of a change."""
    table = []
    for ratio in RATIOS:
        weight = weights.normalized(members.log_weight.values, members.changed.values, ratio)
        share, error = weights.share(weight, members.outcome.values == "locked")
        name = f"{ratio:.0f}" if np.isfinite(ratio) else "certain"
        table.append({"ratio": name, "locked": share, "error": error, "effective": weights.effective(weight)})
    return table


def by_date(members: xarray.Dataset) -> list[dict[str, Any]]:
    """Return the share of locked members at the dates, without and with the report of a change."""
    roll, pitch, yaw = (members[f"{name}_by_date"].values.T for name in ("roll", "pitch", "yaw"))
    table: list[dict[str, Any]] = []
    for k, date in enumerate(DATES):
        locked = measures.outcome(roll[k], pitch[k], yaw[k], members.fate.values) == "locked"
        table.append({"date": date[:10], **_shares(members, locked)})
    return table


def by_width(members: xarray.Dataset) -> list[dict[str, Any]]:
    """Return the share of locked members for halved and doubled widths of priors, without and with the change."""
    columns = {name: members[name].values.astype(float) for name in model.NAMES}
    locked = members.outcome.values == "locked"
    table: list[dict[str, Any]] = [{"prior": "as in the table of inputs", "factor": 1.0} | _shares(members, locked)]
    for name in WIDTHS:
        for factor in (0.5, 2.0):
            change = weights.widened(columns, name, factor)
            table.append({"prior": name, "factor": factor} | _shares(members, locked, change))
    return table


def _shares(members: xarray.Dataset, chosen: Any, change: Any = 0.0) -> dict[str, Any]:
    """Return the share of some members and its sampling error, without and with the report of a change.

    ``change`` is added to the logarithms of the weights.
    """
    row = {}
    for suffix, ratio in (("", 1.0), ("_changed", weights.EVIDENCE)):
        weight = weights.normalized(members.log_weight.values + change, members.changed.values, ratio)
        row[f"share{suffix}"], row[f"error{suffix}"] = weights.share(weight, chosen)
        row[f"effective{suffix}"] = weights.effective(weight)
    return row


def derived(dataset: xarray.Dataset) -> dict[str, npt.NDArray[np.float64]]:
    """Return the predicted numbers of all members, in the units of :data:`PREDICTED`."""
    numbers = {name: dataset[name].values.astype(float) for name in PREDICTED if name in dataset}
    numbers["spin_period"] = 2.0 * np.pi / dataset.spin.values.astype(float)
    numbers["period_drift"] = 3600.0 * (dataset.period.values - dataset.observed_period.values)
    numbers["semi_major_axis"] = 1e3 * numbers["semi_major_axis"]
    return {name: numbers[name] for name in PREDICTED}


def predictions(dataset: xarray.Dataset, chosen: Any, ratio: float = 1.0) -> dict[str, tuple[float, float, float]]:
    """Return the weighted median and limits of 90 per cent of the chosen members."""
    weight = weights.normalized(dataset.log_weight.values, dataset.changed.values, ratio) * chosen
    table = {}
    for name, values in derived(dataset).items():
        valid = np.isfinite(values) & (weight > 0.0)
        if valid.sum() < 5:
            table[name] = (np.nan, np.nan, np.nan)
            continue
        rows = weights.resampled(weight[valid] / weight[valid].sum(), EQUAL)
        middle, low, high = np.percentile(values[valid][rows], [50, 5, 95])
        table[name] = (float(middle), float(low), float(high))
    return table


def sensitivities(dataset: xarray.Dataset) -> dict[str, dict[str, float]]:
    """Return rank correlations of the predicted numbers with the inputs; NaN where nothing varies."""
    from scipy.stats import spearmanr

    rows = weights.resampled(weights.normalized(dataset.log_weight.values), EQUAL)
    numbers = derived(dataset) | {"locked": (dataset.outcome.values == "locked").astype(float)}
    inputs = {name: dataset[name].values for name in model.NAMES}
    inputs |= {name: np.abs(inputs[name]) for name in SIGNLESS}
    table: dict[str, dict[str, float]] = {}
    for name, values in numbers.items():
        valid = rows[np.isfinite(values[rows])]
        varies = len(valid) > 10 and np.ptp(values[valid]) > 0.0
        table[name] = {
            key: float(spearmanr(column[valid], values[valid]).statistic) if varies else np.nan
            for key, column in inputs.items()
        }
    return table


def criteria(dataset: xarray.Dataset) -> dict[str, npt.NDArray[np.bool_]]:
    """Return whether each member (M,) meets the findings of :data:`CRITERIA`, by their names."""
    numbers, b_c = derived(dataset), dataset.b_c.values
    locked, rolling = (dataset.outcome.values == word for word in ("locked", "rolling"))
    return {
        "end over end": dataset.outcome.values == "end over end",
        "rolling and round": rolling & (b_c < 1.05),
        "rolling on an ellipse": rolling & (numbers["eccentricity"] > 0.027),
        "locked and circular": locked & (numbers["eccentricity"] < 0.015),
        "locked and flat": locked & (b_c > 1.35),
        "swinging": locked & (numbers["libration"] > 40.0),
        "tilted": locked & (numbers["obliquity"] > 20.0),
        "period": np.abs(numbers["period_drift"]) > 90.0,
    }


def _scored(dataset: xarray.Dataset) -> npt.NDArray[np.float64]:
    numbers = derived(dataset) | {name: dataset[name].values.astype(float) for name in ("a_b", "b_c")}
    table = np.stack([numbers[name] / width for name, width in SCORED.items()], axis=1)
    return np.asarray(np.nan_to_num(table, nan=1e3))


def score(dataset: xarray.Dataset, outcome: str, finding: dict[str, float], ratio: float = 1.0) -> float:
    """Return the score of a finding: the logarithm of its predicted probability density, in units of the errors.

    The density is the weighted mean over the members with the outcome of normal densities with the errors of
    :data:`SCORED`, so that an outcome that no member has scores minus infinity.

    Parameters
    ----------
    dataset : xarray.Dataset
        The stored members.
    outcome : str
        ``"locked"``, ``"rolling"`` or ``"end over end"``.
    finding : dict
        Some of the numbers of :data:`SCORED`, in their units.
    ratio : float
        The likelihood ratio of the report of a change.
    """
    weight = weights.normalized(dataset.log_weight.values, dataset.changed.values, ratio)
    names = list(SCORED)
    columns = _scored(dataset)[:, [names.index(name) for name in finding]]
    offset = columns - np.array([value / SCORED[name] for name, value in finding.items()])
    density = np.exp(-0.5 * np.sum(offset**2, axis=1)) / (2.0 * np.pi) ** (len(finding) / 2)
    total = float(weight[dataset.outcome.values == outcome] @ density[dataset.outcome.values == outcome])
    return float(np.log(total)) if total > 0.0 else -np.inf


def scores(dataset: xarray.Dataset, ratio: float = 1.0) -> tuple[float, float, float]:
    """Return the weighted median and the 5 and 1 per cent quantiles of the scores of members among the others."""
    weight = weights.normalized(dataset.log_weight.values, dataset.changed.values, ratio)
    columns, words = _scored(dataset), dataset.outcome.values
    distance = np.sum((columns[:, None] - columns[None]) ** 2, axis=2)
    density = np.exp(-0.5 * distance) / (2.0 * np.pi) ** (len(SCORED) / 2) * (words[:, None] == words[None])
    np.fill_diagonal(density, 0.0)
    # An isolated member has the density of a normal distribution with its weight about itself, times a thousandth.
    floor = weight / (2.0 * np.pi) ** (len(SCORED) / 2) * 1e-3
    values = np.log(density @ weight + floor)
    rows = weights.resampled(weight, EQUAL)
    middle, low, least = np.percentile(values[rows], [50, 5, 1])
    return float(middle), float(low), float(least)


def reweighted(dataset: xarray.Dataset) -> xarray.Dataset:
    """Return equally weighted members that represent the posterior."""
    return dataset.isel(row=weights.resampled(weights.normalized(dataset.log_weight.values), EQUAL))


def masses(dataset: xarray.Dataset) -> tuple[float, float]:
    """Return the mean and the standard error of the mass of both bodies over the posterior, kg."""
    names = ("separation", "equatorial", "polar", "diameter", "density")
    weight = weights.normalized(dataset.log_weight.values)
    total = np.array([sum(model.masses(*row)) for row in np.stack([dataset[name].values for name in names], axis=1)])
    mean = float(weight @ total)
    return mean, float(np.sqrt(weight @ (total - mean) ** 2))


def prior_and_posterior(dataset: xarray.Dataset) -> dict[str, tuple[float, float, float, float]]:
    """Return mean and standard error of each number before and after the observations."""
    weight = weights.normalized(dataset.log_weight.values)
    table = {}
    for name in model.NAMES:
        values = dataset[name].values.astype(float)
        mean = float(weight @ values)
        table[name] = (INPUTS[name].value, INPUTS[name].sigma, mean, float(np.sqrt(weight @ (values - mean) ** 2)))
    return table


def normal_weights(dataset: xarray.Dataset, ratio: float) -> npt.NDArray[np.float64]:
    """Return the weights (M,) of the members with a likelihood ratio of the report of a change."""
    return weights.normalized(dataset.log_weight.values, dataset.changed.values, ratio)
