"""Interpolation of an orbit along Kepler orbits, so that few samples contain all harmonics of an eccentric one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _core
from ..typing import Floats

#: The least number of points per revolution, and the powers of e by which the harmonics fall within those points.
_LEAST, _FALL = 16, 16.0


class Path(NamedTuple):
    """A path: times (K,), positions and velocities (K, 3)."""

    time: Floats
    r: Floats
    v: Floats


def fitting_mu(path: Path) -> float:
    """Return the mu whose Kepler orbits fit the samples best, which makes a circle about an oblate body one of them.

    It solves v x (r x v) = mu (r/|r| + e) with a constant vector e by least squares. For motion that fits no orbit it
    is the median of the mu for which each sample would be on a circle.
    """
    distance = np.linalg.norm(path.r, axis=1)
    direction = path.r / distance[:, None]
    eccentricity_curve = np.cross(path.v, np.cross(path.r, path.v))
    eccentricity_curve -= eccentricity_curve.mean(axis=0)
    fit = float(np.sum(eccentricity_curve * (direction - direction.mean(axis=0))))
    return float(np.sum(eccentricity_curve**2) / fit if fit > 0.0 else np.median(np.sum(path.v**2, axis=1) * distance))


def periods(path: Path, mu: float) -> Floats:
    """Return the periods (K,) of the osculating orbits, infinite for open ones."""
    energy = np.sum(path.v**2, axis=1) / 2 - mu / np.linalg.norm(path.r, axis=1)
    size = np.where(energy < 0.0, -mu / 2 / np.where(energy < 0.0, energy, -1.0), np.inf)
    return np.asarray(2 * np.pi * np.sqrt(size**3 / mu))


def harmonics(path: Path, mu: float) -> float:
    """Return how many points per revolution resolve the harmonics of the most eccentric osculating ellipse.

    The k-th harmonic of an ellipse falls as exp(-k (artanh s - s)) with s = sqrt(1 - e^2) (Watson 1944, Theory of
    Bessel Functions, Sec. 8.4).
    """
    e = _core.cartesian_to_elements(path.r, path.v, mu)[:, 1]
    s = np.sqrt(1.0 - np.clip(e, 1e-3, 1.0 - 1e-9).max() ** 2)
    return max(float(_LEAST), _FALL / float(np.arctanh(s) - s))


def interval(time: Floats, moments: Floats) -> npt.NDArray[np.intp]:
    """Return the indices of the steps between times in which moments are."""
    forward = np.sign(time[-1] - time[0])
    return np.clip(np.searchsorted(forward * time, forward * moments, side="right") - 1, 0, len(time) - 2)


def along(path: Path, mu: float, moments: Floats) -> tuple[Path, Floats]:
    """Interpolate a path; return it with the relative misses (K - 1,) of each sample's Kepler orbit at the next sample.

    Each point is on the Kepler orbit of the sample before it, plus the cubic in time that corrects the orbit's miss in
    position and velocity at the next sample.
    """
    time, r, v = path
    rows = _core.cartesian_to_elements(r, v, mu)
    motion = np.sqrt(mu / np.abs(rows[:, 0]) ** 3)

    def moved(start: npt.NDArray[np.intp], span: Floats) -> tuple[Floats, Floats]:
        at = rows[start]
        at[:, 5] += motion[start] * span
        return _core.elements_to_cartesian(np.ascontiguousarray(at), mu)

    steps = np.diff(time)
    near, speed = moved(np.arange(len(steps)), steps)
    off, slip = r[1:] - near, v[1:] - speed
    k = interval(time, moments)
    h = steps[k, None]
    x = (moments - time[k])[:, None] / h
    near, speed = moved(k, moments - time[k])
    followed = Path(
        moments,
        near + x**2 * (3 - 2 * x) * off[k] + x**2 * (x - 1) * h * slip[k],
        speed + 6 * x * (1 - x) / h * off[k] + x * (3 * x - 2) * slip[k],
    )
    return followed, np.linalg.norm(off, axis=1) / np.linalg.norm(r[1:], axis=1)
