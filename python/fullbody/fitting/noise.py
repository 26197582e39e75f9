"""Derivatives of the likelihood, and expected information, for parameters of the errors such as a jitter.

Let p be the pulls, the residuals divided by their errors, C the covariance of the errors, and A the derivatives of the
predictions with respect to linear unknowns, such as zero points, which are solved for at each point of the fit. Minus
twice the logarithm of the restricted likelihood, that of the data without the part that the unknowns can absorb, is
|p|^2 + ln det C + ln det (A^T C^-1 A) up to a constant (Patterson & Thompson 1971, Biometrika 58, 545). Without the
last term the errors would be underestimated, since the unknowns absorb a part of the scatter (Neyman & Scott 1948,
Econometrica 16, 1).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..typing import Floats


def log_determinant(errors: Any) -> float:
    """Return the logarithm of the determinant of C, minus that of the covariance without a jitter."""
    covariances = errors.covariance, errors.without_jitter
    with_jitter, without = (np.diagonal(np.linalg.cholesky(c), axis1=1, axis2=2) for c in covariances)
    return float(2.0 * np.log(with_jitter / without).sum())


def design_without_jitter(errors: Any, design: Floats) -> Floats:
    """Return a design (K, C, L) divided by the errors without a jitter, from the design divided by those with it."""
    with_jitter, without = (np.linalg.cholesky(c) for c in (errors.covariance, errors.without_jitter))
    blocks = design.reshape(*with_jitter.shape[:2], -1)
    return np.asarray(np.linalg.solve(without, with_jitter @ blocks)).reshape(design.shape)


def relative_change(covariance: Floats, other: Floats) -> Floats:
    """Return L^-1 (C' - C) L^-T for covariances C = L L^T and C' (B, S, S) of blocks of numbers."""
    factor = np.linalg.cholesky(covariance)
    left = np.linalg.solve(factor, other - covariance)
    return np.asarray(np.linalg.solve(factor, np.swapaxes(left, 1, 2)))


def derivatives(
    values: Floats,
    changes: Mapping[int, Mapping[int, Floats]],
    basis: Sequence[Floats],
    pulls: Sequence[Floats],
    half_slopes: Sequence[Floats],
) -> tuple[Floats, Floats, Floats]:
    """Return the gradient (P,) of minus the logarithm of the likelihood at values (P,) of parameters, of which some
    change the covariances C of observations, with the information (P, P) that is expected about them, which vanishes
    with a jitter, and the inverse squared lengths (P,) over which they change the errors, which do not.

    The ``changes`` are the relative derivatives S (B, C, C) by the index of the parameter and that of the observations;
    ``basis``, ``pulls`` and ``half_slopes`` are for each of the observations the rows (K C, L) of Q, the pulls (K C,),
    and half the derivatives (K C,) of the losses by the pulls.

    Let C = L L^T, S the relative derivative L^-1 dC L^-T, Q an orthonormal basis of L^-1 A and M = I - Q Q^T. The
    derivative of the logarithm of the determinants is the trace of M S, and the information about two parameters is
    half the trace of M S M S'. The derivative of the factor L is L T, where T is the lower triangle of S with half its
    diagonal, and that of the pulls p is -T p at fixed linear unknowns. The linear unknowns are at the minimum, where
    their change has no effect to first order.
    """
    count, unknowns = len(values), len(basis[0].T)
    gradient, traces = np.zeros(count), np.zeros(count)
    information, inner = np.zeros((count, count)), np.zeros((count, unknowns, unknowns))
    products: dict[tuple[int, int], Floats] = {}
    for k, parts in changes.items():
        for i, change in parts.items():
            size = change.shape[-1]
            rows = basis[i].reshape(len(change), size, -1)
            products[k, i] = np.einsum("kcd,kdl->kcl", change, rows)
            inner[k] += np.einsum("kcl,kcm->lm", rows, products[k, i])
            lower = change * (np.tri(size, k=-1) + 0.5 * np.eye(size))
            gradient[k] -= np.einsum("kc,kcd,kd->", half_slopes[i].reshape(-1, size), lower, pulls[i].reshape(-1, size))
            traces[k] += np.einsum("kcc->", change)
    for k, parts in changes.items():
        traces[k] -= np.trace(inner[k])
        for j, other_parts in changes.items():
            information[k, j] = np.vdot(inner[k], inner[j])
            for i in parts.keys() & other_parts.keys():
                information[k, j] += np.vdot(parts[i], other_parts[i])
                information[k, j] -= 2.0 * np.vdot(products[k, i], products[j, i])
    widths = 0.5 * np.abs(traces) / np.maximum(np.abs(values), 1e-300)
    return gradient + 0.5 * traces, 0.5 * information, widths
