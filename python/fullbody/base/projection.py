"""Linear least squares by an orthogonal factorisation of the design."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InvalidInput
from ..typing import Floats

#: The ratio of the smallest to the largest singular value of a design, with columns scaled to length one, below which a
#: combination of its unknowns is undetermined: its error would exceed those of the data by the inverse.
_SINGULAR = 1e-8
#: The length of a column, relative to the longest one, below which it counts as zero.
_ZERO_COLUMN = 1e-12
#: The smallest coefficient, relative to the largest, with which an error names an unknown of such a combination.
_NAMED = 0.1


class Projection:
    """The factorisation A = Q R of a design A (M, L), whose product with L unknowns approximates M numbers.

    If the data leave a combination of the unknowns undetermined, the error has the names of these. The ``basis`` (M, L)
    is Q, and ``log_determinant`` the logarithm of the determinant of A^T A.
    """

    def __init__(self, design: Floats, names: Sequence[str]) -> None:
        norms = np.linalg.norm(design, axis=0)
        # A column of rounding errors, such as sines at multiples of pi, counts as zero and makes the design singular.
        scaled = design / np.where(norms > _ZERO_COLUMN * norms.max(initial=0.0), norms, np.inf)
        self.basis, factor = np.linalg.qr(scaled)
        if len(names):
            _, sizes, vectors = np.linalg.svd(factor)
            # A design with fewer rows than unknowns has fewer singular values than unknowns.
            if len(design) < len(names) or not sizes[-1] > _SINGULAR * sizes[0]:
                shares = np.abs(vectors[-1])
                undetermined = [
                    name for name, share in zip(names, shares, strict=True) if share > _NAMED * shares.max()
                ]
                raise InvalidInput(
                    f"the {len(design)} data leave {', '.join(undetermined)} undetermined"
                    f"{' beside each other' if len(undetermined) > 1 else ''}; expected times at which "
                    f"{'they differ' if len(undetermined) > 1 else 'it has an effect'}, or fewer linear unknowns"
                )
        self._factor = factor * norms
        self.log_determinant = 2.0 * float(np.log(np.abs(np.diag(self._factor))).sum())

    def coordinates(self, values: Floats) -> Floats:
        """Return the coordinates (L, ...) of unknowns in the basis, R times the unknowns."""
        return np.asarray(self._factor @ values)

    def unknowns(self, coordinates: Floats) -> Floats:
        """Return the unknowns (L, ...) that have these coordinates in the basis."""
        return np.linalg.solve(self._factor, coordinates) if len(self._factor) else coordinates

    def solve(self, numbers: Floats) -> Floats:
        """Return the unknowns (L, ...) at which the sum of the squared residuals of numbers (M, ...) is least."""
        return self.unknowns(self.basis.T @ numbers)

    @property
    def inverse(self) -> Floats:
        """The pseudo-inverse of the design, transposed (M, L): the derivative of half the ``log_determinant``."""
        return np.linalg.solve(self._factor, self.basis.T).T if len(self._factor) else self.basis

    def derivative(self, explicit: Floats, crossed: Floats, curvature: Floats | None = None) -> Floats:
        """Return the derivatives (M, P) of a solution's residuals (Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413).

        The derivatives of the residuals r for constant unknowns are ``explicit`` (M, P), and those of A^T psi for
        constant psi, half the derivatives of the losses, ``crossed`` (L, P): psi is r for least squares. If a sum of
        losses is minimised, the implicit function theorem takes the ``curvature`` (M,), the derivatives of psi by r.
        """
        lower = np.linalg.solve(self._factor.T, crossed) if len(self._factor) else crossed
        if curvature is None:
            return np.asarray(explicit - self.basis @ (self.basis.T @ explicit + lower))
        weighted = curvature[:, None] * self.basis
        right_side = weighted.T @ explicit + lower
        return np.asarray(explicit - self.basis @ np.linalg.solve(weighted.T @ self.basis, right_side))
