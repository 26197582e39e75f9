"""The covariance of fitted parameters, and the combinations of them that the data do not constrain."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .free import Parameters

__all__ = ["Covariance"]

_Array = npt.NDArray[np.float64]

#: The ratio of singular values below which a combination of parameters counts as unconstrained.
_SINGULAR = 1e-9
#: The smallest coefficient of a combination that its text includes.
_NAMED = 0.05


class Covariance:
    """The inverse of an information matrix J^T J.

    Parameters
    ----------
    matrix : ndarray, (R, P)
        The root J of the information.
    parameters : Parameters

    Attributes
    ----------
    matrix : ndarray, (P, P)
        Rows and columns of unconstrained parameters are zero, with infinity on the diagonal.
    condition : float
        The ratio of the largest to the smallest singular value of J with columns of length one.
    weakest : ndarray, (P,)
        The combination of parameters, in units of the inverse lengths of the columns, that is constrained least.
    unconstrained : str or None
        That combination as text, if it is not constrained at all.
    """

    def __init__(self, matrix: _Array, parameters: Parameters) -> None:
        norms = np.linalg.norm(matrix, axis=0)
        scale = np.divide(1.0, norms, out=np.zeros_like(norms), where=norms > 0.0)
        _, sizes, vectors = np.linalg.svd(matrix * scale, full_matrices=False)
        good = sizes > _SINGULAR * sizes[0]
        self.weakest = vectors[-1]
        # Beyond the precision of doubles this value is only a lower bound of the ratio.
        self.condition = float(sizes[0] / max(sizes[-1], 1e-16 * sizes[0])) if sizes[0] > 0.0 else np.inf
        self.unconstrained = None if good.all() else _combination(vectors[-1], norms, parameters)
        self.matrix = vectors[good].T @ (vectors[good] / sizes[good, None] ** 2) * np.outer(scale, scale)
        lost = (np.abs(vectors[~good]) > _NAMED).any(axis=0)
        self.matrix[lost] = self.matrix[:, lost] = 0.0
        self.matrix[lost, lost] = np.inf


def _combination(vector: _Array, norms: _Array, parameters: Parameters) -> str:
    """Return the combination of parameters along a unit vector of scaled ones as text."""
    parts = []
    for k in np.argsort(-np.abs(vector), kind="stable"):
        if abs(vector[k]) > _NAMED:
            # A parameter without any effect has no scale, and is shown in its own unit.
            per = 1.0 / norms[k] if norms[k] > 0.0 else 1.0
            sign = "+" if vector[k] > 0.0 else "-"
            parts.append(f"{parameters.names[k]} {sign} {parameters.shown(k, abs(vector[k]) * per)} s")
    if len(parts) == 1:
        return str(parameters.names[int(np.argmax(np.abs(vector)))])
    return ", ".join(parts) + " together, for any s"
