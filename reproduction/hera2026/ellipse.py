"""The uniformly precessing ellipse that fits an interval of an orbit best, as observers of mutual events fit one.

The mean motion n is that of the longitude in the mean plane of the orbit. The distance is fitted by

    r = a (1 - e cos(nu t - phase)),

with the frequency nu within a band about n, so that the apses advance at n - nu. The share of the variance of the
distance that such an ellipse explains, its coherence, shows whether the orbit was one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar

if TYPE_CHECKING:
    from fullbody import Run

__all__ = ["Ellipse", "fitted_ellipse"]

_Array = npt.NDArray[np.float64]

#: The band of precession rates, rad/h, and the number of rates in it that are tried first.
BAND: Final = (np.deg2rad(-8.0) / 24.0, np.deg2rad(16.0) / 24.0)
TRIALS: Final = 121


@dataclass(frozen=True)
class Ellipse:
    """An ellipse that precesses uniformly, fitted to the positions of an interval.

    Attributes
    ----------
    period : float
        The mean sidereal period, hours.
    eccentricity : float
    precession : float
        The rate at which the apses advance, degrees a day.
    coherence : float
        The share of the variance of the distance that the ellipse explains, at most 1.
    """

    period: float
    eccentricity: float
    precession: float
    coherence: float


def fitted_ellipse(run: Run) -> Ellipse:
    """Fit a uniformly precessing ellipse to the relative orbit of the second body about the first one.

    Parameters
    ----------
    run : Run
        Samples of an interval of many revolutions, at most a quarter of a revolution apart.

    Returns
    -------
    Ellipse
    """
    time = run.time - run.time.mean()
    position = run.position[:, 1] - run.position[:, 0]
    distance = np.linalg.norm(position, axis=1)
    longitude = _longitude(position, run.velocity[:, 1] - run.velocity[:, 0])
    motion = float(np.polyfit(time, longitude, 1)[0])
    trials = motion - np.linspace(BAND[0], BAND[1], TRIALS)
    step = float(trials[0] - trials[1])
    best = trials[np.argmin([_residual(time, distance, float(rate)) for rate in trials])]
    rate = float(
        minimize_scalar(
            lambda trial: _residual(time, distance, trial),
            bounds=(best - step, best + step),
            method="bounded",
            options={"xatol": 1e-9},
        ).x
    )
    a, cosine, sine = np.linalg.lstsq(_columns(time, rate), distance, rcond=None)[0]
    # The longitude contains 2 e sin(M) at the same frequency, which changes n unless the revolutions are whole.
    columns = np.concatenate([_columns(time, rate), time[:, None]], axis=1)
    motion = float(np.linalg.lstsq(columns, longitude, rcond=None)[0][3])
    variance = float(np.sum((distance - distance.mean()) ** 2))
    return Ellipse(
        2.0 * np.pi / motion,
        float(np.hypot(cosine, sine) / a),
        float(np.rad2deg(motion - rate) * 24.0),
        1.0 - _residual(time, distance, rate) / variance,
    )


def _longitude(position: _Array, velocity: _Array) -> _Array:
    """Return the unwrapped longitude (K,) in the plane normal to the mean angular momentum."""
    normal = np.cross(position, velocity).mean(axis=0)
    normal /= np.linalg.norm(normal)
    x = np.cross(normal, [normal[1], normal[2], normal[0]])
    x /= np.linalg.norm(x)
    return np.unwrap(np.arctan2(position @ np.cross(normal, x), position @ x))


def _columns(time: _Array, rate: float) -> _Array:
    return np.stack([np.ones_like(time), np.cos(rate * time), np.sin(rate * time)], axis=1)


def _residual(time: _Array, distance: _Array, rate: float) -> float:
    """Return the sum of the squared residuals of the best ellipse with a frequency."""
    columns = _columns(time, rate)
    # The normal equations of three columns are well conditioned, and faster than a decomposition of the columns.
    solution = np.linalg.solve(columns.T @ columns, columns.T @ distance)
    residual = distance - columns @ solution
    return float(residual @ residual)
