"""Parameters of the errors of observations, such as a jitter: their likelihood, and what the data tell about them.

Let p be the pulls, C the covariance of the errors, and A the derivatives of the predictions with respect to unknowns
that each prediction solves for, such as zero points. Minus twice the logarithm of the likelihood of what these leave of
the data is |p|^2 + ln det C + ln det (A^T C^-1 A), up to a constant (Patterson & Thompson 1971, Biometrika 58, 545).
Without the last term the errors would be too small by the part of the scatter that the unknowns follow (Neyman & Scott
1948, Econometrica 16, 1).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..typing import Floats


class NoiseDerivatives(NamedTuple):
    """Derivatives with respect to P parameters of the errors of all observations.

    They are half the derivatives (P,) of the sum of squared pulls and of the logarithms of the determinants, with the
    expected information (P, P) about the parameters, and the derivatives (P,) of the latter alone.
    """

    gradient: Floats
    information: Floats
    log_determinant: Floats


def log_determinant(errors: Any) -> float:
    """Return the logarithm of the determinants of C, minus that without a jitter."""
    pair = errors.covariance, errors.without_jitter
    wide, narrow = (np.diagonal(np.linalg.cholesky(c), axis1=1, axis2=2) for c in pair)
    return float(2.0 * np.log(wide / narrow).sum())


def without_jitter(errors: Any, design: Floats) -> Floats:
    """Return a design (K, C, L) divided by the errors without a jitter, from one that is divided by those with it."""
    wide, narrow = (np.linalg.cholesky(c) for c in (errors.covariance, errors.without_jitter))
    return np.asarray(np.linalg.solve(narrow, wide @ design))


def relative(covariance: Floats, other: Floats) -> Floats:
    """Return L^-1 (C' - C) L^-T for covariances C = L L^T and C' (K, C, C)."""
    factor = np.linalg.cholesky(covariance)
    half = np.linalg.solve(factor, other - covariance)
    return np.asarray(np.linalg.solve(factor, np.swapaxes(half, 1, 2)))


def derivatives(
    count: int,
    changes: Mapping[int, Mapping[int, Floats]],
    basis: Sequence[Floats],
    pulls: Sequence[Floats],
    by: Sequence[Floats],
) -> NoiseDerivatives:
    """Return the derivatives with respect to parameters that change the covariances C of observations.

    With S a relative change, Q an orthonormal basis of L^-1 A and M = I - Q Q^T, that of the logarithm of the
    determinants is the trace of M S, and the information about two parameters half the trace of M S M S'. The factor L
    of C changes by L T, where T is the lower triangle of S with half its diagonal, and the pulls p by -T p, if the
    linear unknowns stay the same: at their best values their change counts for nothing.

    Parameters
    ----------
    count : int
        The number of parameters.
    changes : mapping of mapping of ndarray, (K, C, C)
        The relative changes by the index of the parameter and that of the observations.
    basis, pulls, by : sequence of ndarray, (K C, L), (K C,) and (K C,)
        The rows of Q, the pulls, and half the derivatives of the losses by them, for each of the observations.
    """
    gradient, determinants = np.zeros(count), np.zeros(count)
    information, inner = np.zeros((count, count)), np.zeros((count, *[len(basis[0].T)] * 2))
    moved: dict[tuple[int, int], Floats] = {}
    for k, parts in changes.items():
        for i, change in parts.items():
            size = change.shape[-1]
            rows = basis[i].reshape(len(change), size, -1)
            moved[k, i] = np.einsum("kcd,kdl->kcl", change, rows)
            inner[k] += np.einsum("kcl,kcm->lm", rows, moved[k, i])
            lower = change * (np.tri(size, k=-1) + 0.5 * np.eye(size))
            gradient[k] -= np.einsum("kc,kcd,kd->", by[i].reshape(-1, size), lower, pulls[i].reshape(-1, size))
            determinants[k] += np.einsum("kcc->", change)
    for k, parts in changes.items():
        determinants[k] -= np.trace(inner[k])
        for other, others in changes.items():
            information[k, other] = np.vdot(inner[k], inner[other])
            for i in parts.keys() & others.keys():
                information[k, other] += np.vdot(parts[i], others[i]) - 2.0 * np.vdot(moved[k, i], moved[other, i])
    return NoiseDerivatives(gradient + 0.5 * determinants, 0.5 * information, determinants)
