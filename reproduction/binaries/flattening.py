"""The probability that chance alone lowers chi2 as much as the flattening of Haumea does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody import observing
from fullbody.fitting import Fit
from scipy.stats import norm

from .pair import LOOSE

__all__ = ["Chance", "chance", "exceedance"]

_Array = npt.NDArray[np.float64]

#: The J2 of the differences that give the response to a flattening.
_SMALL = 1e-3
#: Numbers of draws, of draws at a time and of directions of the axis, and the seed.
_DRAWS, _BLOCK, _DIRECTIONS, _SEED = 1_000_000, 5_000, 2000, 1


@dataclass(frozen=True)
class Chance:
    """The falls of chi2 in simulated observations of three points.

    Attributes
    ----------
    fall : float
        By how much chi2 falls, to first order in J2, for the real observations.
    p_first : float
        The share of the simulated observations for which it falls by at least as much to first order.
    p_value : float
        The same share for the fall of the fits, which are not of first order.
    """

    fall: float
    p_first: float
    p_value: float

    @property
    def sigma(self) -> float:
        """The two-sided deviation of a normal distribution that has the probability of first order."""
        return float(norm.isf(self.p_first / 2.0))


def chance(points: Fit, spheroid: Callable[..., tuple[fullbody.System, fullbody.State]], fall: float) -> Chance:
    """Simulate by how much chi2 falls where a J2 above zero along a free axis is fitted to three points.

    Without a flattening its axis has no effect, so that the fall is no chi2 of three degrees of freedom: it is a
    maximum over directions. To first order the predictions are linear in the quadrupole J2 (n n - 1/3) of an axis n,
    which has five independent elements. What these add to the effects of the other parameters lies in five dimensions,
    where the errors of the observations are five independent normal numbers.

    Parameters
    ----------
    points
        The fit of three points.
    spheroid
        The setup with the parameters ``J2``, ``ra`` and ``dec`` beside those of the points.
    fall
        By how much chi2 of the fits falls.
    """
    data, best = points.observations, dict(points.values)

    def predicted(**changes: float) -> _Array:
        return _predicted(spheroid(**{"J2": 0.0, "ra": 0.0, "dec": 90.0, **best, **changes}), data)

    start = predicted()
    steps = {name: 0.1 * points.sigma[name] for name in points.names}
    jacobian = np.stack(
        [(predicted(**{k: best[k] + h}) - predicted(**{k: best[k] - h})) / (2.0 * h) for k, h in steps.items()], axis=1
    )
    # Six axes of an icosahedron, whose quadrupoles span all five dimensions.
    ratio = (1.0 + np.sqrt(5.0)) / 2.0
    axes = [[0, 1, ratio], [0, -1, ratio], [1, ratio, 0], [-1, ratio, 0], [ratio, 0, 1], [ratio, 0, -1]]
    responses = []
    for x, y, z in axes:
        ra, dec = np.degrees([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
        plus, minus = (predicted(J2=j2, ra=ra, dec=dec) for j2 in (_SMALL, -_SMALL))
        responses.append((plus - minus) / (2.0 * _SMALL))
    response = np.linalg.lstsq(_quadrupoles(np.array(axes, dtype=float)), np.array(responses), rcond=None)[0].T
    points_basis, _ = np.linalg.qr(jacobian)
    basis, triangular = np.linalg.qr(response - points_basis @ (points_basis.T @ response))
    # A Fibonacci lattice: directions that are spread evenly over half of the sphere.
    index = np.arange(_DIRECTIONS)
    z, angle = (index + 0.5) / _DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - z**2)
    axes_of_trial = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    directions = _quadrupoles(axes_of_trial) @ triangular.T
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    observed = np.concatenate([_whitened(data_set, _offsets(data_set)) for data_set in data])
    gain = float((directions @ (basis.T @ (observed - start))).max())
    first = max(0.0, gain) ** 2
    return Chance(first, exceedance(directions, first), exceedance(directions, fall))


def exceedance(directions: _Array, fall: float) -> float:
    """Return the probability that the largest positive component of a normal vector has a square above ``fall``.

    Parameters
    ----------
    directions : ndarray, (K, D)
        Unit vectors, along which the components of vectors of D independent normal numbers are taken.
    fall : float
    """
    rng, above = np.random.default_rng(_SEED), 0
    for _ in range(_DRAWS // _BLOCK):
        highest = (directions @ rng.standard_normal((directions.shape[1], _BLOCK))).max(axis=0)
        above += int((highest >= np.sqrt(fall)).sum())
    return above / _DRAWS


def _quadrupoles(axes: _Array) -> _Array:
    """Return the five independent elements of n n - 1/3 for unit vectors along the axes (K, 3), as (K, 5)."""
    x, y, z = (axes / np.linalg.norm(axes, axis=1)[:, None]).T
    return np.stack([x * y, y * z, z * x, x * x - y * y, z * z - 1.0 / 3.0], axis=1)


def _offsets(data: observing.Astrometry) -> _Array:
    return np.stack([data.east.to_value("arcsec"), data.north.to_value("arcsec")], axis=1)


def _whitened(data: observing.Astrometry, offsets: _Array) -> _Array:
    """Return offsets (K, 2) in arcsec in units of independent errors, as (2 K,)."""
    root = np.linalg.cholesky(data.covariance.to_value("arcsec2"))
    return np.asarray(np.linalg.solve(root, offsets[..., None])[..., 0].reshape(-1), dtype=np.float64)


def _predicted(setup: tuple[fullbody.System, fullbody.State], data: Sequence[observing.Astrometry]) -> _Array:
    system, state = setup
    times = [data_set.emission(system) for data_set in data]
    first = min(data_set[0] for data_set in times)
    start = system.integrate(state, first, output="ends", integrator=LOOSE)[-1]
    run = system.integrate(start, max(data_set[-1] for data_set in times), dense=True, integrator=LOOSE)
    return np.concatenate([_whitened(data_set, data_set.predict(run).to_value("arcsec")) for data_set in data])
