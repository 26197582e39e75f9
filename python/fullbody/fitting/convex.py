"""Convex inversion with a linear series: the light of a convex body as a function of its period and pole.

The light of a convex body is the integral of the scattering law over the directions n of its surface normals, weighted
by the area G(n) that the body has per solid angle of normals (Kaasalainen, Lamberg, Lumme & Bowell 1992, Astron.
Astrophys. 259, 318). With G a series of spherical harmonics about the pole the light is linear in its coefficients. A
rotation by phi about the pole multiplies the terms of order m by cos(m phi) and sin(m phi), so that the integrals over
the sphere do not depend on the period: they are computed once for each pole.

With a pole that is tilted by a small vector p the longitudes psi of the bisectors between the directions to the
observer and to the Sun change, which is taken into account exactly; what is left of the integrals, B exp(i m psi), is
linear in p to a good approximation.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..model.geodesic import harmonics
from ..typing import Floats
from .curves import Curves
from .poles import tilted

#: The least light relative to that of a sphere.
_MIN_LIGHT = 0.02
#: The relative change of the minimised sum and the damping at which iterations end, and their largest number.
_TOLERANCE, _MAX_DAMPING, _MAX_ITERATIONS = 1e-3, 1e3, 15
#: The tilt, in radians, over which integrals are differenced.
_TILT = 0.1
#: Magnitudes per unit of the natural logarithm of the light.
_MAGNITUDES = 2.5 / np.log(10.0)


class ConvexMinimum(NamedTuple):
    """The least chi2 (B,) near B frequencies, and the frequencies (B,) and tilts (B, 2) of the pole at which it is."""

    chi2: Floats
    frequency: Floats
    tilt: Floats


class ConvexSeries:
    """The light of a convex body at the K times of light curves, for poles near the last of some axes (3, 3).

    The prior standard deviation of a coefficient of degree l is ``smoothness`` / l, and the ``limits`` are the largest
    tilt of the pole, and the largest change of the rotation angle over the span of the times.
    """

    def __init__(
        self, curves: Curves, axes: Floats, degree: int, smoothness: float, limits: tuple[float, float]
    ) -> None:
        terms = [(n, m) for n in range(degree + 1) for m in range(n + 1)]
        degrees, self._orders = (np.array(part) for part in zip(*terms, strict=True))
        self._has_sine, zonal = self._orders > 0, degrees * (degrees + 1)
        # The cosine and the sine of an order are the parts of a complex harmonic, which a rotation gives a phase.
        real = harmonics(curves.normals, degree)
        values = real[:, zonal + self._orders] + 1j * np.where(self._has_sine, real[:, zonal - self._orders], 0.0)
        weights = curves.areas[:, None] * values
        #: Vectors between the directions to the observer and to the Sun, in the frame whose z-axis is the pole.
        self._bisector = curves.lights.sum(axis=0) @ axes.T
        self._times, self._pulls, self._basis = curves.times, curves.pulls, curves.basis
        self._scale, self._limits = _MAGNITUDES / curves.sigma, limits

        def reduced_integrals(tilt: Floats) -> Any:
            """Return the integrals (K, C) of the scattering law times each harmonic about a tilted pole."""
            values = curves.light(curves.lights @ tilted(axes, tilt).T, weights)
            psi = self._longitudes(tilt[None])[0][0]
            return values / values[:, :1].real * np.exp(-1j * np.outer(psi, self._orders))

        steps = _TILT * np.eye(2)
        self._integrals = reduced_integrals(np.zeros(2))
        self._tilt_derivatives = [
            (reduced_integrals(step) - reduced_integrals(-step)) / (2.0 * _TILT) for step in steps
        ]
        unknown = np.concatenate([degrees[1:], degrees[self._has_sine]])
        #: The squared inverse prior errors of coefficients, tilts and angle; the latter matter for a sphere alone.
        self._weight = np.append((unknown / smoothness) ** 2, np.array([limits[0], limits[0], limits[1]]) ** -2.0)
        #: The times from the middle, in units of the span.
        self._span = float(np.ptp(curves.times))
        self._relative_times = (curves.times - 0.5 * (curves.times.min() + curves.times.max())) / self._span

    def minimum(self, frequency: Floats) -> ConvexMinimum:
        """Return the minima near frequencies (B,), in radians per unit of time, by Levenberg and Marquardt's method."""
        batch, size = len(frequency), len(self._weight)
        x, least, chi2 = np.zeros((batch, size)), np.full(batch, np.inf), np.full(batch, np.inf)
        matrix, gradient = np.empty((batch, size, size)), np.empty((batch, size))
        damping, trial, active = np.full(batch, 5e-3), x.copy(), np.arange(batch)
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
            damping[active] *= np.where(better, 0.2, 8.0)
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
        """Return the minimised sum with its derivatives at coefficients, tilts and angles (B, n)."""
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
        matrix = rows.swapaxes(1, 2) @ rows - projected_rows.swapaxes(1, 2) @ projected_rows + np.diag(self._weight)
        gradient = (pulls[:, None] @ rows)[:, 0] - (projected_pulls[:, None] @ projected_rows)[:, 0] + self._weight * x
        return _Evaluated(chi2, chi2 + np.sum(self._weight * x**2, axis=1), gradient, matrix)

    def _design(self, terms: Any) -> Floats:
        """Return the relative light (B, K, n) of each unknown coefficient: cosines, then sines."""
        return np.concatenate([terms[..., 1:].real, terms[..., self._has_sine].imag], axis=-1)

    def _light(self, terms: Any, x: Floats) -> Floats:
        """Return the relative light (B, K) of all coefficients."""
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
    """Chi2 and the minimised sum (B,), with half its gradient (B, n) and the matrix (B, n, n) of Gauss and Newton."""

    chi2: Floats
    total: Floats
    gradient: Floats
    matrix: Floats
