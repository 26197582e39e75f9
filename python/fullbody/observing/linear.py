"""Linear unknowns of data: their names, and how the pulls depend on them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.projection import Projection
from ..typing import Floats


class LinearUnknown(NamedTuple):
    """An unknown on which the predictions of data depend linearly, such as a zero point.

    Attributes
    ----------
    name : str
        The name under which a fit lists it.
    unit : unit or None
        ``None`` for plain numbers.
    shared : bool
        Whether all data sets with an unknown of this name have it in common; otherwise each has its own.
    """

    name: str
    unit: Any = None
    shared: bool = False


class Held(NamedTuple):
    """The constants with which a :class:`LinearModel` of K rows of C numbers is differentiated.

    Attributes
    ----------
    values : ndarray, (L,)
        The linear unknowns.
    rows : ndarray, (K, C)
        Weights in the sum over the rows of each column of the design.
    design : ndarray, (K, C, L)
        Weights in the sum over all numbers of the design.
    """

    values: Floats
    rows: Floats
    design: Floats


class LinearModel(NamedTuple):
    """The pulls of data as a function of L linear unknowns: ``pulls`` minus ``design`` times the unknowns.

    Attributes
    ----------
    unknowns : tuple of LinearUnknown
        The L unknowns, in the order of the design's columns.
    pulls : ndarray, (K, C)
        The pulls with all linear unknowns zero.
    design : ndarray, (K, C, L)
        The derivatives of the predictions, divided by the errors as the pulls are.

    Examples
    --------
    >>> import numpy as np
    >>> from fullbody import observing
    >>> zero_point = observing.LinearUnknown("zero point")
    >>> model = observing.LinearModel((zero_point,), np.array([[3.0], [5.0]]), np.ones((2, 1, 1)))
    >>> values, pulls = model.solved()
    >>> values.round(12), pulls.ravel().round(12)
    (array([4.]), array([-1.,  1.]))
    """

    unknowns: tuple[LinearUnknown, ...]
    pulls: Floats
    design: Floats

    def solved(self) -> tuple[Floats, Floats]:
        """Return the unknowns (L,) at which the sum of the squared pulls is least, and the pulls (K, C) there."""
        values = self.projection().solve(self.pulls.ravel())
        return values, self.pulls - self.design @ values

    def projection(self) -> Projection:
        """Return the orthogonal factorisation of the design."""
        return Projection(
            self.design.reshape(self.pulls.size, len(self.unknowns)), [unknown.name for unknown in self.unknowns]
        )

    def contracted(self, held: Held) -> Floats:
        """Return the numbers (K C + L + 1,) that a fit differentiates.

        They are the pulls at the held unknowns, the weighted sum of each column of the design, and the weighted sum of
        all its numbers.
        """
        design = self.design.reshape(self.pulls.size, len(self.unknowns))
        pulls, total = self.pulls.ravel() - design @ held.values, np.vdot(held.design, self.design)
        return np.concatenate([pulls, held.rows.ravel() @ design, [total]])
