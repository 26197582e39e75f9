"""Linear unknowns of data: their names, and how the pulls depend on them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.projection import Projection
from ..typing import Floats


class LinearUnknown(NamedTuple):
    """An unknown on which the predictions of data depend linearly.

    Attributes
    ----------
    name : str
    unit : unit or None
        ``None`` for plain numbers.
    shared : bool
        Whether it is one unknown in all data that have one of this name, or another one in each of them.
    """

    name: str
    unit: Any = None
    shared: bool = False


class Held(NamedTuple):
    """What is constant while a :class:`LinearModel` of K rows of C numbers is differentiated.

    Attributes
    ----------
    values : ndarray, (L,)
        The linear unknowns.
    rows : ndarray, (K, C)
        Weights of the rows of the design, which are summed for each of its columns.
    design : ndarray, (K, C, L)
        Weights of all numbers of the design, which are summed.
    """

    values: Floats
    rows: Floats
    design: Floats


class LinearModel(NamedTuple):
    """The pulls of data as a function of L linear unknowns: ``pulls`` minus ``design`` times the unknowns.

    Attributes
    ----------
    unknowns : tuple of LinearUnknown
    pulls : ndarray, (K, C)
        The pulls with all linear unknowns zero.
    design : ndarray, (K, C, L)
        The derivatives of the predictions, divided by the errors as the pulls are.
    """

    unknowns: tuple[LinearUnknown, ...]
    pulls: Floats
    design: Floats

    def solved(self) -> tuple[Floats, Floats]:
        """Return the unknowns (L,) with which the squares of the pulls have the least sum, and these pulls."""
        values = self.projection().solve(self.pulls.ravel())
        return values, self.pulls - self.design @ values

    def projection(self) -> Projection:
        """Return the factors of the design."""
        return Projection(self.design.reshape(self.pulls.size, len(self.unknowns)), [one.name for one in self.unknowns])

    def contracted(self, held: Held) -> Floats:
        """Return what a fit differentiates, (K C + L + 1,).

        These are the pulls for the unknowns that are held, the sums of the weighted rows of the design, and that of all
        its weighted numbers.
        """
        design = self.design.reshape(self.pulls.size, len(self.unknowns))
        pulls, total = self.pulls.ravel() - design @ held.values, np.vdot(held.design, self.design)
        return np.concatenate([pulls, held.rows.ravel() @ design, [total]])
