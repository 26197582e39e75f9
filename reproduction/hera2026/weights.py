"""Weights of members: the change of the orbit after the days observed, shares with their sampling errors, priors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from . import posterior
from .inputs import INPUTS, Input

if TYPE_CHECKING:
    import xarray

__all__ = ["CHANGED_ECCENTRICITY", "EVIDENCE", "INCOHERENT", "changed", "effective", "inclusion", "normalized"]
__all__ += ["resampled", "share", "widened"]

_Array = npt.NDArray[np.float64]

#: An orbit counts as changed if the ellipse of its second interval has an eccentricity below this one, which is the
#: published error of three standard errors (S24), or explains less than this share of the variance of the distance.
CHANGED_ECCENTRICITY: Final = 0.016
INCOHERENT: Final = 0.7
#: Likelihood ratio of the report of a change: that if the orbit changed, over that if it did not.
EVIDENCE: Final = 10.0


def changed(
    dataset: xarray.Dataset, eccentricity: float = CHANGED_ECCENTRICITY, coherence: float = INCOHERENT
) -> npt.NDArray[np.bool_]:
    """Return whether each member's orbit in the second interval is nearly circular, or no precessing ellipse (M,)."""
    circular = dataset.observed_eccentricity_later.values < eccentricity
    return np.asarray(circular | (dataset.observed_coherence_later.values < coherence))


def normalized(logarithm: Any, change: Any = None, evidence: float = 1.0) -> _Array:
    """Return weights (M,) with the sum 1.

    Parameters
    ----------
    logarithm : array_like, (M,)
        Logarithms of the weights of the posterior; minus infinity for a weight of zero.
    change : array_like of bool, (M,), optional
        Whether the orbit changed after the days observed.
    evidence : float
        The likelihood ratio of the report that it changed, of a change to no change; infinite if the report is taken
        for certain.
    """
    values = np.asarray(logarithm, dtype=float)
    if change is not None:
        values = values - np.where(change, 0.0, np.log(evidence))
    weights = np.exp(values - values.max())
    return np.asarray(weights / weights.sum())


def effective(weights: _Array) -> float:
    """Return the number of members of equal weight that would have the same sampling error."""
    return float(1.0 / np.sum(weights**2))


def share(weights: _Array, chosen: Any) -> tuple[float, float]:
    """Return the weighted share of some members, and its sampling error for this number of members."""
    indicator = np.asarray(chosen, dtype=float)
    value = float(weights @ indicator)
    return value, float(np.sqrt(np.sum((weights * (indicator - value)) ** 2)))


def inclusion(logarithm: Any, change: Any, count: float) -> _Array:
    """Return the probabilities (M,) with which candidates are run to the end, with the sum ``count`` or less.

    They are in proportion to the larger one of two weights: that of the posterior, and that of the posterior if the
    orbit changed. Both answers then rest on as many members as possible.
    """
    largest = normalized(logarithm)
    if np.any(np.asarray(change) & (largest > 0.0)):
        largest = np.maximum(largest, normalized(logarithm, change, np.inf))
    factors = np.geomspace(1.0, 1e6, 400) * count / largest.sum()
    sums = np.array([np.minimum(1.0, factor * largest).sum() for factor in factors])
    return np.asarray(np.minimum(1.0, factors[max(0, np.searchsorted(sums, count) - 1)] * largest))


def widened(columns: Mapping[str, Any], name: str, factor: float, inputs: Mapping[str, Input] = INPUTS) -> _Array:
    """Return the change of the logarithms of the weights (M,) if the width of a prior is multiplied by a factor."""
    wider = {**inputs, name: replace(inputs[name], sigma=inputs[name].sigma * factor)}
    return posterior.prior(columns, wider) - posterior.prior(columns, inputs)


def resampled(weights: _Array, count: int) -> npt.NDArray[np.intp]:
    """Return indices (count,) of members in proportion to their weights, by systematic resampling."""
    steps = (np.arange(count) + 0.5) / count
    return np.searchsorted(np.cumsum(weights), steps).clip(max=len(weights) - 1)
