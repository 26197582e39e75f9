"""Parameters of the errors of observations, such as a jitter: their likelihood, and what the data tell about them.

Let p be the pulls, C the covariance of the errors, and A the derivatives of the predictions with respect to unknowns
that each prediction solves for, such as zero points. Minus twice the logarithm of the likelihood of what these leave of
the data is |p|^2 + ln det C + ln det (A^T C^-1 A), up to a constant (Patterson & Thompson 1971, Biometrika 58, 545).
Without the last term the errors would be too small by the part of the scatter that the unknowns follow (Neyman & Scott
1948, Econometrica 16, 1).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..typing import Floats


class NoiseDerivatives(NamedTuple):
    """Derivatives with respect to P parameters of the errors of K rows of C numbers.

    They are those of the pulls (P, K, C) and of the logarithm of the determinant (P,), with the expected information
    (P, P) about the parameters.
    """

    pulls: Floats
    log_determinant: Floats
    information: Floats


def log_determinant(errors: Any) -> float:
    """Return the logarithm of the determinants of C and of A^T C^-1 A, minus that without a jitter."""
    return _log_determinant(errors.covariance, errors.design) - _log_determinant(errors.without_jitter, errors.design)


def _log_determinant(covariance: Floats, design: Floats) -> float:
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, design).reshape(factor[..., 0].size, -1)
    rows = 2.0 * np.log(np.diagonal(factor, axis1=1, axis2=2)).sum()
    return float(rows + np.linalg.slogdet(white.T @ white)[1])


def relative(covariance: Floats, other: Floats) -> Floats:
    """Return L^-1 (C' - C) L^-T for covariances C = L L^T and C' (K, C, C)."""
    factor = np.linalg.cholesky(covariance)
    half = np.linalg.solve(factor, other - covariance)
    return np.asarray(np.linalg.solve(factor, np.swapaxes(half, 1, 2)))


def derivatives(errors: Any, pulls: Floats, changes: Floats) -> NoiseDerivatives:
    """Return the derivatives with respect to parameters that change C by the relative ``changes`` (P, K, C, C).

    With S a relative change, Q an orthonormal basis of L^-1 A and M = I - Q Q^T, that of the logarithm of the
    determinants is the trace of M S, and the information about two parameters half the trace of M S M S'. The factor L
    of C changes by L T, where T is the lower triangle of S with half its diagonal, and the pulls by Q Q^T S p - T p.
    """
    white = np.linalg.solve(np.linalg.cholesky(errors.covariance), errors.design)
    basis = np.linalg.qr(white.reshape(pulls.size, -1))[0].reshape(white.shape)
    moved = np.einsum("pkcd,kdl->pkcl", changes, basis)
    inner = np.einsum("kcl,pkcm->plm", basis, moved)
    flat, along = changes.reshape(len(changes), -1), moved.reshape(len(changes), -1)
    information = 0.5 * (flat @ flat.T - 2.0 * along @ along.T + np.einsum("plm,qml->pq", inner, inner))
    size = changes.shape[-1]
    lower = changes * (np.tri(size, k=-1) + 0.5 * np.eye(size))
    solved = np.einsum("pkcl,kc->pl", moved, pulls)
    by = np.einsum("kcl,pl->pkc", basis, solved) - np.einsum("pkcd,kd->pkc", lower, pulls)
    return NoiseDerivatives(by, np.einsum("pkcc->p", changes) - np.einsum("pll->p", inner), information)
