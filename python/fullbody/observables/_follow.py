"""Interpolation of an orbit along Kepler orbits, so that few samples contain all harmonics of an eccentric one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..typing import Floats

#: The least number of points per revolution, and the number of powers of e by which the harmonics fall within them.
_MIN_POINTS, _POWERS_OF_E = 16, 16.0


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
    vectors = np.cross(path.v, np.cross(path.r, path.v))
    vectors -= vectors.mean(axis=0)
    covariance = float(np.sum(vectors * (direction - direction.mean(axis=0))))
    circular = np.sum(path.v**2, axis=1) * distance
    return float(np.sum(vectors**2) / covariance if covariance > 0.0 else np.median(circular))


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
    return max(float(_MIN_POINTS), _POWERS_OF_E / float(np.arctanh(s) - s))


def interval(time: Floats, moments: Floats) -> npt.NDArray[np.intp]:
    """Return the indices of the steps between times in which moments are."""
    forward = np.sign(time[-1] - time[0])
    return np.clip(np.searchsorted(forward * time, forward * moments, side="right") - 1, 0, len(time) - 2)


def interpolated(path: Path, mu: float, moments: Floats) -> tuple[Path, Floats]:
    """Interpolate a path; return it with the relative errors (K - 1,) of each sample's Kepler orbit at the next sample.

    Each point is on the Kepler orbit of the sample before it, plus the cubic in time that corrects the orbit's error in
    position and velocity at the next sample.
    """
    time, r, v = path
    rows = _core.cartesian_to_elements(r, v, mu)
    motion = np.sqrt(mu / np.abs(rows[:, 0]) ** 3)

    def propagated(samples: npt.NDArray[np.intp], span: Floats) -> tuple[Floats, Floats]:
        elements = rows[samples]
        elements[:, 5] += motion[samples] * span
        return _core.elements_to_cartesian(np.ascontiguousarray(elements), mu)

    steps = np.diff(time)
    kepler_r, kepler_v = propagated(np.arange(len(steps)), steps)
    dr, dv = r[1:] - kepler_r, v[1:] - kepler_v
    k = interval(time, moments)
    h = steps[k, None]
    x = (moments - time[k])[:, None] / h
    kepler_r, kepler_v = propagated(k, moments - time[k])
    position = kepler_r + x**2 * (3 - 2 * x) * dr[k] + x**2 * (x - 1) * h * dv[k]
    velocity = kepler_v + 6 * x * (1 - x) / h * dr[k] + x * (3 * x - 2) * dv[k]
    return Path(moments, position, velocity), np.linalg.norm(dr, axis=1) / np.linalg.norm(r[1:], axis=1)
