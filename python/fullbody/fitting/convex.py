"""Convex inversion with a linear series: the light of a convex body as a function of its period and pole.

The light of a convex body is the integral of the scattering law over the directions n of its surface normals, weighted
by the area G(n) that the body has per solid angle of normals (Kaasalainen, Lamberg, Lumme & Bowell 1992, Astron.
Astrophys. 259, 318). If G is a series of spherical harmonics about the pole, the light is linear in the coefficients of
G. A rotation by phi about the pole multiplies the complex terms of order m by exp(i m phi), so that the integrals over
the sphere do not depend on the period: they are computed once for each pole.

If the pole is tilted by a small vector p, the longitude psi of the bisector between the directions to the observer and
to the Sun changes. An integral of order m is B exp(i m psi): psi is computed exactly, and B, here the reduced integral,
is nearly linear in p.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..model.geodesic import harmonics
from ..typing import Floats
from .curves import Curves
from .poles import tilted

#: The light relative to that of a sphere below which coefficients are refused: the series has become negative.
_MIN_LIGHT = 0.02
#: The relative decrease of the minimised sum below which iterations end, and their largest number.
_TOLERANCE, _MAX_ITERATIONS = 1e-3, 15
#: The damping of the first step, its factors after a step that lowers the sum and after one that does not, and the
#: damping above which iterations end.
_DAMPING, _EASED, _RAISED, _MAX_DAMPING = 5e-3, 0.2, 8.0, 1e3
#: The tilt, in radians, whose central differences are the derivatives of the reduced integrals.
_TILT = 0.1
#: The change in magnitudes per unit of the natural logarithm of the light.
_MAGNITUDES_PER_LOG = 2.5 / np.log(10.0)


class ConvexMinimum(NamedTuple):
    """The minima near B frequencies: chi2 (B,) without prior terms, frequencies (B,) and tilts of the pole (B, 2)."""

    chi2: Floats
    frequency: Floats
    tilt: Floats


class ConvexSeries:
    """The light of a convex body at the K times of light curves, for poles near the last of the ``axes`` (3, 3).

    The coefficients are relative to that of degree zero, which is one. The prior standard deviation of a coefficient of
    degree l is ``smoothness`` / l; those of degree one are not fixed at zero, although a closed surface has none. The
    ``limits``, in radians, are the largest tilt of the pole, and the largest change of the rotation angle over the span
    of the times.
    """

    def __init__(
        self, curves: Curves, axes: Floats, degree: int, smoothness: float, limits: tuple[float, float]
    ) -> None:
        terms = [(n, m) for n in range(degree + 1) for m in range(n + 1)]
        degrees, self._orders = (np.array(part) for part in zip(*terms, strict=True))
        self._has_sine, zonal = self._orders > 0, degrees * (degrees + 1)
        # The terms with cosine and sine are the parts of a complex harmonic, which a rotation multiplies by a phase.
        real = harmonics(curves.normals, degree)
        values = real[:, zonal + self._orders] + 1j * np.where(self._has_sine, real[:, zonal - self._orders], 0.0)
        weights = curves.areas[:, None] * values
        #: Vectors (K, 3) along the bisectors, in the frame of the axes.
        self._bisector = curves.lights.sum(axis=0) @ axes.T
        self._times, self._pulls, self._basis = curves.times, curves.pulls, curves.basis
        self._scale, self._limits = _MAGNITUDES_PER_LOG / curves.sigma, limits

        def reduced_integrals(tilt: Floats) -> Any:
            """Return B (K, C) of each harmonic about a tilted pole, relative to the integral of degree zero."""
            values = curves.light(curves.lights @ tilted(axes, tilt).T, weights)
            psi = self._longitudes(tilt[None])[0][0]
            return values / values[:, :1].real * np.exp(-1j * np.outer(psi, self._orders))

        steps = _TILT * np.eye(2)
        self._integrals = reduced_integrals(np.zeros(2))
        self._tilt_derivatives = [
            (reduced_integrals(step) - reduced_integrals(-step)) / (2.0 * _TILT) for step in steps
        ]
        degrees_of_unknowns = np.concatenate([degrees[1:], degrees[self._has_sine]])
        #: The inverse prior variances of coefficients, tilts and angle. The priors of tilts and angle keep the matrix
        #: regular for a sphere, whose light does not depend on them.
        self._prior = np.append(
            (degrees_of_unknowns / smoothness) ** 2, np.array([limits[0], limits[0], limits[1]]) ** -2.0
        )
        self._span = float(np.ptp(curves.times))
        #: The times from the middle of the span, in units of the span.
        self._relative_times = (curves.times - 0.5 * (curves.times.min() + curves.times.max())) / self._span

    def minimum(self, frequency: Floats) -> ConvexMinimum:
        """Return the minima near frequencies (B,), in radians per unit of time, by Levenberg and Marquardt's method.

        The unknowns x of each frequency are the coefficients, two tilts and the change of the angle over the span.
        """
        batch, size = len(frequency), len(self._prior)
        x, least, chi2 = np.zeros((batch, size)), np.full(batch, np.inf), np.full(batch, np.inf)
        matrix, gradient = np.empty((batch, size, size)), np.empty((batch, size))
        damping, trial, active = np.full(batch, _DAMPING), x.copy(), np.arange(batch)
        for _ in range(_MAX_ITERATIONS):
            evaluated = self._evaluated(frequency[active], trial[active])
            better = evaluated.total < least[active]
            gain = least[active] - evaluated.total
            accepted = active[better]
            x[accepted], least[accepted], chi2[accepted] = (
                trial[accepted],
                evaluated.total[better],
                evaluated.chi2[better],
            )
            matrix[accepted], gradient[accepted] = evaluated.matrix[better], evaluated.gradient[better]
            damping[active] *= np.where(better, _EASED, _RAISED)
            done = better & (gain <= _TOLERANCE * evaluated.total) | (damping[active] > _MAX_DAMPING)
            active = active[~done]
            if not len(active):
                break
            diagonal = np.einsum("bii->bi", matrix[active]) * damping[active, None]
            damped = matrix[active] + diagonal[:, None] * np.eye(size)
            step = -np.linalg.solve(damped, gradient[active, :, None])[..., 0]
            trial[active] = x[active] + step
            tilt = np.linalg.norm(trial[active, -3:-1], axis=1, keepdims=True)
            trial[active, -3:-1] *= self._limits[0] / np.maximum(tilt, self._limits[0])
            trial[active, -1] = np.clip(trial[active, -1], -self._limits[1], self._limits[1])
        return ConvexMinimum(chi2, frequency + x[:, -1] / self._span, x[:, -3:-1])

    def _evaluated(self, frequency: Floats, x: Floats) -> _Evaluated:
        """Return the minimised sum with its derivatives at unknowns x (B, n)."""
        tilt = x[:, -3:-1]
        psi, by_tilt = self._longitudes(tilt)
        angle = psi - np.outer(frequency, self._times) - np.outer(x[:, -1], self._relative_times)
        phasor = np.exp(1j * angle[..., None] * np.arange(self._orders.max() + 1))
        phasor = phasor[..., self._orders]
        slopes = [slope * phasor for slope in self._tilt_derivatives]
        terms = self._integrals * phasor + tilt[:, 0, None, None] * slopes[0] + tilt[:, 1, None, None] * slopes[1]
        design, light = self._design(terms), 1.0 + self._light(terms, x)
        by_angle = self._light(1j * self._orders * terms, x)
        columns = [self._light(slope, x) + by_angle * by_tilt[..., k] for k, slope in enumerate(slopes)]
        columns.append(-by_angle * self._relative_times)
        usable = (light > _MIN_LIGHT).all(axis=1)
        light = np.maximum(light, _MIN_LIGHT)
        rows = np.concatenate([design, np.stack(columns, axis=-1)], axis=-1) * (self._scale / light)[..., None]
        pulls = self._pulls + self._scale * np.log(light)
        projected_rows, projected_pulls = self._basis.T @ rows, pulls @ self._basis
        chi2 = np.where(usable, np.sum(pulls**2, axis=1) - np.sum(projected_pulls**2, axis=1), np.inf)
        matrix = rows.swapaxes(1, 2) @ rows - projected_rows.swapaxes(1, 2) @ projected_rows + np.diag(self._prior)
        gradient = (pulls[:, None] @ rows)[:, 0] - (projected_pulls[:, None] @ projected_rows)[:, 0] + self._prior * x
        return _Evaluated(chi2, chi2 + np.sum(self._prior * x**2, axis=1), gradient, matrix)

    def _design(self, terms: Any) -> Floats:
        """Return the relative light (B, K, C) of a unit of each coefficient: of cosines, then of sines."""
        return np.concatenate([terms[..., 1:].real, terms[..., self._has_sine].imag], axis=-1)

    def _light(self, terms: Any, x: Floats) -> Floats:
        """Return the relative light (B, K) of all coefficients except the constant one, which gives one."""
        count = terms.shape[-1] - 1
        series = np.zeros((len(x), count + 1), dtype=complex)
        series[:, 1:] = x[:, :count]
        series[:, self._has_sine] -= 1j * x[:, count:-3]
        return (terms @ series[..., None])[..., 0].real

    def _longitudes(self, tilt: Floats) -> tuple[Floats, Floats]:
        """Return the longitudes (B, K) of the bisectors about tilted poles (B, 2), and their derivatives (B, K, 2).

        The frame is rotated by the smallest rotation to the tilted pole (p_x, p_y, p_z): with q = (p_x h_x + p_y h_y) /
        (1 + p_z), the bisector h has the components h_x - p_x (h_z + q) and h_y - p_y (h_z + q).
        """
        p, (hx, hy, hz) = tilt[:, None], self._bisector.T
        pz = np.sqrt(1.0 - np.sum(p**2, axis=-1))
        along = p[..., 0] * hx + p[..., 1] * hy
        q = along / (1.0 + pz)
        x, y = hx - p[..., 0] * (hz + q), hy - p[..., 1] * (hz + q)
        by_tilt = []
        for k, h in enumerate((hx, hy)):
            dq = h / (1.0 + pz) + q * p[..., k] / (pz * (1.0 + pz))
            dx, dy = -p[..., 0] * dq - (hz + q) * (k == 0), -p[..., 1] * dq - (hz + q) * (k == 1)
            by_tilt.append((x * dy - y * dx) / (x * x + y * y))
        return np.arctan2(y, x), np.stack(by_tilt, axis=-1)


class _Evaluated(NamedTuple):
    """Chi2 and the minimised sum (B,), which is chi2 plus prior terms, with half the gradient (B, n) of the sum.

    The ``matrix`` (B, n, n) is half its second derivatives in the approximation of Gauss and Newton.
    """

    chi2: Floats
    total: Floats
    gradient: Floats
    matrix: Floats
