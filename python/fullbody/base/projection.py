"""Linear unknowns of a problem of least squares, for which it is solved by an orthogonal factorisation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InvalidInput
from ..typing import Floats

#: The ratio of the smallest to the largest singular value of a design, with columns of length one, below which a
#: combination of its unknowns is lost: its error would be larger than those of the data by the inverse.
_SINGULAR = 1e-8
#: The length of a column relative to that of the longest one below which it has no effect.
_NOTHING = 1e-12
#: The smallest coefficient of a lost combination that an error names, relative to the largest.
_NAMED = 0.1


class Projection:
    """The factors Q R of a design A (M, L), whose product with L unknowns is subtracted from M numbers.

    Attributes
    ----------
    basis : ndarray, (M, L)
        The orthonormal columns of Q.
    log_determinant : float
        The logarithm of the determinant of A^T A.

    Raises
    ------
    InvalidInput
        For columns that cannot be told apart, which the error names.
    """

    def __init__(self, design: Floats, names: Sequence[str]) -> None:
        norms = np.linalg.norm(design, axis=0)
        # A column of rounding errors, such as of sines at multiples of pi, is none.
        scaled = design / np.where(norms > _NOTHING * norms.max(initial=0.0), norms, np.inf)
        self.basis, factor = np.linalg.qr(scaled)
        if len(names):
            _, sizes, vectors = np.linalg.svd(factor)
            # With fewer rows than unknowns there are more vectors than singular values.
            if len(design) < len(names) or not sizes[-1] > _SINGULAR * sizes[0]:
                lost = np.abs(vectors[-1])
                which = [name for name, part in zip(names, lost, strict=True) if part > _NAMED * lost.max()]
                raise InvalidInput(
                    f"the {len(design)} data leave {', '.join(which)} undetermined"
                    f"{' beside each other' if len(which) > 1 else ''}; expected times at which "
                    f"{'they differ' if len(which) > 1 else 'it has an effect'}, or fewer linear unknowns"
                )
        self._factor = factor * norms
        self.log_determinant = 2.0 * float(np.log(np.abs(np.diag(self._factor))).sum())

    def coordinates(self, values: Floats) -> Floats:
        """Return R times unknowns (L, ...): their coordinates in the basis."""
        return np.asarray(self._factor @ values)

    def unknowns(self, coordinates: Floats) -> Floats:
        """Return the unknowns (L, ...) with coordinates in the basis."""
        return np.linalg.solve(self._factor, coordinates) if len(self._factor) else coordinates

    def solve(self, numbers: Floats) -> Floats:
        """Return the unknowns (L, ...) at which the squares of what is left of numbers (M, ...) have the least sum."""
        return self.unknowns(self.basis.T @ numbers)

    @property
    def inverse(self) -> Floats:
        """The pseudo-inverse of the design, transposed (M, L): the derivative of half the ``log_determinant``."""
        return np.linalg.solve(self._factor, self.basis.T).T if len(self._factor) else self.basis

    def derivative(self, explicit: Floats, crossed: Floats, curvature: Floats | None = None) -> Floats:
        """Return the derivatives (M, P) of what a solution leaves (Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413).

        Parameters
        ----------
        explicit : ndarray, (M, P)
            Derivatives of what is left, r, for constant unknowns.
        crossed : ndarray, (L, P)
            Derivatives of A^T psi for constant psi, half the derivatives of the losses: r for least squares.
        curvature : ndarray, (M,), optional
            The derivatives of psi with respect to r, where the sum of losses is minimised instead of squares; then the
            implicit function theorem gives the formula.
        """
        lower = np.linalg.solve(self._factor.T, crossed) if len(self._factor) else crossed
        if curvature is None:
            return np.asarray(explicit - self.basis @ (self.basis.T @ explicit + lower))
        weighted = curvature[:, None] * self.basis
        moved = weighted.T @ explicit + lower
        return np.asarray(explicit - self.basis @ np.linalg.solve(weighted.T @ self.basis, moved))
