"""Options of light curves that are read from files, and standard errors of those whose files have none."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.arguments import options_of, refuse_unknown
from ..errors import InvalidInput, caution
from ..typing import Floats
from .columns import column
from .photometry import Photometry

#: The longest time in days over which a cubic approximates a light curve, and the least number of points with two
#: others before and after within that time from which a scatter is computed.
_SPAN, _FEWEST = 0.2, 3
#: The standard deviation of a normal distribution over the median of the sizes of its values.
_NORMAL = 1.482602218505602


#: Options of photometry that a file determines.
_OF_FILE = ("times", "magnitude", "sigma", "geometry", "zero", "night", "filter", "airmass", "reduced")


def refuse_options(options: Iterable[str], owner: str) -> None:
    """Raise an error for options that photometry does not have, or that a file determines."""
    refuse_unknown(options, [name for name in options_of(Photometry) if name not in _OF_FILE], owner)


class Curve(NamedTuple):
    """The times in ``days`` and magnitudes (K,) of a curve of a file, with its name in messages."""

    name: str
    days: Floats
    magnitude: Floats


def scatter(days: Floats, magnitude: Floats) -> float | None:
    """Return the standard deviation of magnitudes about cubics through the two points before and after each.

    It is ``None`` for a curve with too few points that are near to each other. The median makes it robust against
    outliers; a light curve that bends within a few points has a scatter above its noise.
    """
    order = np.argsort(days, kind="stable")
    if len(order) < 5:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(order, 5)
    times, values = days[windows], magnitude[windows]
    usable = (np.diff(times, axis=1) > 0.0).all(axis=1) & (times[:, 4] - times[:, 0] <= _SPAN)
    neighbours, middle = np.delete(times[usable], 2, axis=1), times[usable, 2]
    if len(neighbours) < _FEWEST:
        return None
    others = [[j for j in range(4) if j != k] for k in range(4)]
    weights = np.stack(
        [
            np.prod((middle[:, None] - neighbours[:, j]) / (neighbours[:, [k]] - neighbours[:, j]), axis=1)
            for k, j in enumerate(others)
        ],
        axis=1,
    )
    residuals = values[usable, 2] - np.sum(weights * np.delete(values[usable], 2, axis=1), axis=1)
    deviation = float(_NORMAL * np.median(np.abs(residuals) / np.sqrt(1.0 + np.sum(weights**2, axis=1))))
    return deviation if deviation > 0.0 else None


def standard_errors(sigma: Any, curves: Sequence[Curve], path: Any) -> Floats:
    """Return the standard errors (C,) of C curves: those given, or estimates from their scatter, with a warning."""
    if not (sigma is None or (isinstance(sigma, str) and sigma == "estimate")):
        errors = column(sigma, "sigma", "mag")[0]
        if errors.shape not in ((), (len(curves),)):
            raise InvalidInput(
                f"sigma has shape {errors.shape}; expected one number, or ({len(curves)},) for the curves"
            )
        return np.broadcast_to(errors, len(curves))
    estimates = [scatter(curve.days, curve.magnitude) for curve in curves]
    estimated = [estimate for estimate in estimates if estimate is not None]
    too_few = [curve.name for curve, estimate in zip(curves, estimates, strict=True) if estimate is None]
    if not estimated:
        raise InvalidInput(f"{path} has no errors, and {too_few[0]} too few points to estimate them; give sigma=")
    if sigma is None:
        others = ""
        if too_few:
            others = f"; {len(too_few)} curves with too few points, such as {too_few[0]}, have the median of the others"
        caution(
            f"{path} has no standard errors of {len(curves)} curves; they are estimated from the scatter about cubics "
            f"through neighbouring points, {min(estimated):.2g} to {max(estimated):.2g} mag"
            f"{others}; give sigma=, or sigma='estimate' to accept this"
        )
    return np.array([np.median(estimated) if estimate is None else estimate for estimate in estimates])
