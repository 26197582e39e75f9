"""The linear unknowns of an occultation at the least chi2, on which the predicted times depend almost linearly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..base.units import need
from ..typing import Floats
from .contacts import ApparentBody, Indices, Passage
from .limbs import Limb
from .states import IMAGINARY_STEP

#: The relative changes at which the search for the unknowns ends.
_TOLERANCES = {"xtol": 1e-9, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 200}


class Solution(NamedTuple):
    """The predictions of K rows with values of the L linear unknowns, and what leads to them."""

    #: The values (L,) of the unknowns.
    values: Floats
    #: Predictions (K,) relative to the times of the rows, with the offset and without errors of clocks.
    prediction: Floats
    #: The derivatives (K, L) of the predictions, errors of clocks included, with respect to the unknowns.
    design: Floats
    #: The body of each row, (K,).
    body: Indices
    #: The displacement (K, 3) of the bodies by the offset.
    displacement: Floats


@dataclass
class Event:
    """An occultation of which all but the linear unknowns is given."""

    #: The station of each row; -1 for a disappearance, 1 for a reappearance, 0 for a miss; standard errors, (K,) each.
    station: Indices
    sign: Floats
    sigma: Floats
    #: For each body the rows that may be due to it, and the passage that finds their contacts.
    passages: dict[int, tuple[Indices, Passage]]
    #: The function from a body and displacements (..., K, 3) of all bodies to the apparent body.
    apparent: Callable[[int, Any], ApparentBody]
    #: The displacements (K, 3) for offsets of one radian to the east and to the north.
    axes: tuple[Floats, Floats]
    #: The number of radians in the unit of the offset.
    scale: float
    #: The offset (2,) in radians, if it is no unknown.
    fixed: Floats | None
    #: The derivatives (K, C) of the predictions with respect to the errors of clocks.
    clocks: Floats

    def solution(self, values: Floats | None) -> Solution:
        """Return the solution at values of the unknowns, or without them that with the least chi2."""
        offsets = 2 if self.fixed is None else 0
        if values is not None:
            return self._at(values)
        start = self._at(np.zeros(offsets + self.clocks.shape[1]))
        if not offsets or len(start.values) > len(self.sign):
            return start
        latest = [start]

        def at(unknowns: Floats) -> Solution:
            if not np.array_equal(latest[0].values, unknowns):
                latest[0] = self._at(unknowns.copy())
            return latest[0]

        def pulls(unknowns: Floats) -> Floats:
            return np.asarray((at(unknowns).prediction + self.clocks @ unknowns[offsets:]) / self.sigma)

        def jacobian(unknowns: Floats) -> Floats:
            return np.asarray(at(unknowns).design / self.sigma[:, None])

        with need("observing", "the offset of an occultation"):
            from scipy.optimize import least_squares

        return at(least_squares(pulls, start.values, jacobian, method="lm", x_scale="jac", **_TOLERANCES).x)

    def _at(self, values: Floats) -> Solution:
        """Return the solution at values of the unknowns."""
        east, north = self.fixed if self.fixed is not None else values[:2] * self.scale
        displacement = east * self.axes[0] + north * self.axes[1]
        solved = {
            body: (rows, passage.solve(self.apparent(body, displacement).of_rows(rows)))
            for body, (rows, passage) in self.passages.items()
        }
        bodies = self._bodies(solved)
        columns = []
        for axis in self.axes if self.fixed is None else ():
            displaced = displacement + 1j * IMAGINARY_STEP * self.scale * axis
            columns.append(self.linearised(self.apparent, displaced, bodies).imag / IMAGINARY_STEP)
        design = np.column_stack([*columns, self.clocks])
        return Solution(values, of_bodies(solved, bodies), design, bodies, displacement)

    def linearised(
        self,
        apparent: Callable[[int, Any], ApparentBody],
        displacement: Any,
        bodies: Indices,
        limbs: dict[int, list[Limb]] | None = None,
    ) -> Any:
        """Return the predictions (..., K) of the body of each row, to first order about the last contacts.

        The apparent bodies, their displacement and their ``limbs`` may differ from those that have these contacts.
        """
        changes = {
            body: (rows, passage.linearised(apparent(body, displacement).of_rows(rows), (limbs or {}).get(body)))
            for body, (rows, passage) in self.passages.items()
        }
        return of_bodies(changes, bodies)

    def _bodies(self, solved: dict[int, tuple[Indices, Floats]]) -> Indices:
        """Return the body of each row: for each station the one whose predictions are nearest to what was observed."""
        bodies = np.array(list(solved), dtype=np.intp)
        cost = np.full((len(bodies), len(self.sign)), np.inf)
        for of_body, (rows, predictions) in zip(cost, solved.values(), strict=True):
            # If a station sees no occultation by several bodies, the one that would hide the star most counts.
            of_body[rows] = np.where(self.sign[rows] == 0.0, -np.abs(predictions), predictions**2)
        result = np.empty(len(self.sign), dtype=np.intp)
        for station in np.unique(self.station):
            rows = self.station == station
            result[rows] = bodies[np.argmin(cost[:, rows].sum(axis=1))]
        return result


def of_bodies(predictions: dict[int, tuple[Indices, Any]], bodies: Indices) -> Any:
    """Return the numbers (..., K) of the body of each row, from those (..., M) of the rows of each body."""
    arrays = [numbers for _, numbers in predictions.values()]
    result = np.zeros((*np.shape(arrays[0])[:-1], len(bodies)), dtype=np.result_type(*arrays))
    for body, (rows, numbers) in predictions.items():
        is_chosen = bodies[rows] == body
        result[..., rows[is_chosen]] = numbers[..., is_chosen]
    return result
