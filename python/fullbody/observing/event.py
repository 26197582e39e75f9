"""The linear unknowns of an occultation at the least chi2, on which the predicted times depend almost linearly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..base.units import need
from ..typing import Floats
from .contacts import Body, Passage

#: The relative changes at which the search for the unknowns ends.
_TOLERANCES = {"xtol": 1e-9, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 200}
#: The step of derivatives along the imaginary axis.
_STEP = 1e-100

Indices = npt.NDArray[np.intp]


class Solution(NamedTuple):
    """The predictions of K rows with values of the L linear unknowns, and what leads to them.

    Attributes
    ----------
    values : ndarray, (L,)
    prediction : ndarray, (K,)
        Predictions relative to the times of the rows, with the offset and without errors of clocks.
    design : ndarray, (K, L)
        The derivatives of the predictions, errors of clocks included, with respect to the unknowns.
    chosen : ndarray of int, (K,)
        The body of each row.
    shift : ndarray, (K, 3)
        The displacement of the bodies by the offset.
    contacts : dict of int to (ndarray of int, Passage)
        For each body the rows that it was compared with, and their contacts.
    """

    values: Floats
    prediction: Floats
    design: Floats
    chosen: Indices
    shift: Floats
    contacts: dict[int, tuple[Indices, Passage]]


@dataclass
class Event:
    """An occultation of which all but the linear unknowns is given.

    Attributes
    ----------
    station, sign, sigma : ndarray, (K,)
        The station of each row; -1 for a disappearance, 1 for a reappearance, 0 for a miss; standard errors.
    passages : dict of int to (ndarray of int, Passage)
        For each body the rows that may be due to it, and what finds their contacts.
    seen : callable
        The function from a body and displacements (..., K, 3) of all bodies to the body as it is seen.
    axes : pair of ndarray, (K, 3)
        The displacements for offsets of one radian to the east and to the north.
    scale : float
        The number of radians in the unit of the offset.
    fixed : ndarray, (2,), or None
        The offset in radians, if it is no unknown.
    clocks : ndarray, (K, C)
        The derivatives of the predictions with respect to the errors of clocks.
    """

    station: Indices
    sign: Floats
    sigma: Floats
    passages: dict[int, tuple[Indices, Passage]]
    seen: Callable[[int, Any], Body]
    axes: tuple[Floats, Floats]
    scale: float
    fixed: Floats | None
    clocks: Floats

    def solution(self, at: Floats | None) -> Solution:
        """Return the solution at values of the unknowns, or without them that with the least chi2."""
        offsets = 2 if self.fixed is None else 0
        values = np.zeros(offsets + self.clocks.shape[1]) if at is None else at
        last = [self._at(values)]
        if at is not None or not offsets or len(values) > len(self.sign):
            return last[0]

        def latest(unknowns: Floats) -> Solution:
            if not np.array_equal(last[0].values, unknowns):
                last[0] = self._at(unknowns.copy())
            return last[0]

        def pulls(unknowns: Floats) -> Floats:
            return np.asarray((latest(unknowns).prediction + self.clocks @ unknowns[offsets:]) / self.sigma)

        def jacobian(unknowns: Floats) -> Floats:
            return np.asarray(latest(unknowns).design / self.sigma[:, None])

        with need("observing", "the offset of an occultation"):
            from scipy.optimize import least_squares

        return latest(least_squares(pulls, values, jacobian, method="lm", x_scale="jac", **_TOLERANCES).x)

    def _at(self, values: Floats) -> Solution:
        """Return the solution at values of the unknowns."""
        east, north = self.fixed if self.fixed is not None else values[:2] * self.scale
        shift = east * self.axes[0] + north * self.axes[1]
        solved = {
            body: (of, contacts.solve(self.seen(body, shift).of(of))) for body, (of, contacts) in self.passages.items()
        }
        chosen = self._chosen(solved)
        columns = []
        for axis in self.axes if self.fixed is None else ():
            moved = shift + 1j * _STEP * self.scale * axis
            changes = {
                body: (of, contacts.linearised(self.seen(body, moved).of(of)).imag / _STEP)
                for body, (of, contacts) in self.passages.items()
            }
            columns.append(picked(changes, chosen))
        design = np.column_stack([*columns, self.clocks])
        return Solution(values, picked(solved, chosen), design, chosen, shift, self.passages)

    def _chosen(self, solved: dict[int, tuple[Indices, Floats]]) -> Indices:
        """Return the body of each row: for each station the one whose predictions are nearest to what was observed."""
        bodies = np.array(list(solved), dtype=np.intp)
        cost = np.full((len(bodies), len(self.sign)), np.inf)
        for row, (of, predictions) in zip(cost, solved.values(), strict=True):
            # If several bodies should have been missed, the one that hides the star most counts.
            row[of] = np.where(self.sign[of] == 0.0, -np.abs(predictions), predictions**2)
        chosen = np.empty(len(self.sign), dtype=np.intp)
        for station in np.unique(self.station):
            rows = self.station == station
            chosen[rows] = bodies[np.argmin(cost[:, rows].sum(axis=1))]
        return chosen


def picked(predictions_of: dict[int, tuple[Indices, Any]], chosen: Indices) -> Any:
    """Return the numbers (..., K) of the chosen bodies, from those (..., M) of the rows of each body."""
    parts = list(predictions_of.values())
    kind = np.result_type(*(numbers for _, numbers in parts))
    values = np.zeros((*np.shape(parts[0][1])[:-1], len(chosen)), dtype=kind)
    for body, (of, numbers) in predictions_of.items():
        chosen_rows = chosen[of] == body
        values[..., of[chosen_rows]] = numbers[..., chosen_rows]
    return values
