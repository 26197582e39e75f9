"""All relative equilibria of a given angular momentum, and the state of least energy."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ..base.attributes import WithUnit
from ..base.limits import POSITIVE
from ..base.tables import Table, Tabled, facts, head, number
from ..base.units import plain
from ..errors import BodiesOverlap, NotConverged
from ..model.state import State, wrap
from ..motion.system import System
from ..typing import Scalar
from ._newton import Axes, EquilibriumProblem, aligned, alignments, contact, converged, rotation_at, scan
from ._pair import Pair
from .equilibrium import RelativeEquilibrium

#: Energies and separations whose relative difference is less than this are equal.
_SAME = 1e-12


class Touching(Tabled):
    """Two bodies at rest upon each other that turn together.

    Attributes
    ----------
    system : System
    state : State
    """

    def __init__(self, pair: Pair, axes: Axes, distance: float, angular_momentum: float) -> None:
        pose = aligned(axes, distance)
        poles = [axes[k][1] for k in range(2)]
        inertia = pair.mass * pose.distance**2 + sum(pair.inertia[k][poles[k]] for k in range(2))
        rate = angular_momentum / inertia
        self.rotation = rotation = EquilibriumProblem(pair, (None, None), {}).rotation(pose, rate)
        self.system: System = pair.system
        self.state: State = wrap(pair.state(pose, rotation.velocity, rotation.spins), pair.context)
        self._pressure = pair.mass * rate**2 * pose.distance + float(pair.loads(pose)[0][0])

    separation = WithUnit[Scalar]("Distance between the centres.", "rotation.pose.distance", "length")
    rate = WithUnit[Scalar]("Rate at which the pair turns, in radians per unit of time.", "rotation.rate", "spin")
    energy = WithUnit[Scalar]("Total energy with the barycentre at rest.", "rotation.energy", "energy")

    @property
    def rests(self) -> bool:
        """Whether the bodies stay in contact: gravity exceeds what is needed to keep them on their circular paths."""
        return bool(self._pressure < 0.0)

    def _tables(self) -> tuple[Table, ...]:
        rows = facts(self, "separation", "rate", "energy")
        return (Table("Touching bodies", (), [*rows, ("rest upon each other", "yes" if self.rests else "no")]),)

    def __repr__(self) -> str:
        rests = "at rest upon each other" if self.rests else "pulled apart by the rotation"
        return f"Touching(separation={number(self.separation)}, energy={number(self.energy)}, {rests})"


class Equilibria(Tabled):
    """The equilibria of one angular momentum, found by :func:`equilibria`.

    Attributes
    ----------
    angular_momentum : float or Quantity
    apart : tuple of RelativeEquilibrium
        Equilibria without contact, in ascending order of energy.
    touching : tuple of Touching
        Bodies at rest upon each other along principal axes, in ascending order of energy.
    missed : tuple of str
        Messages about alignments from which the search reached no equilibrium; for ellipsoids they occur only at folds.
    """

    def __init__(
        self, angular_momentum: Any, apart: list[RelativeEquilibrium], touching: list[Touching], missed: list[str]
    ) -> None:
        self.angular_momentum = angular_momentum
        self.apart = tuple(sorted(apart, key=_energy))
        self.touching = tuple(sorted(touching, key=_energy))
        self.missed = tuple(missed)

    @cached_property
    def _all(self) -> list[RelativeEquilibrium | Touching]:
        return sorted([*self.apart, *self.touching], key=_energy)

    @property
    def least(self) -> RelativeEquilibrium | Touching:
        """The state of least energy, in which a pair ends that loses energy and keeps its angular momentum."""
        if not self._all:
            raise NotConverged("no equilibrium was found, neither apart nor touching; see .missed")
        return self._all[0]

    def _tables(self) -> tuple[Table, ...]:
        names = ("separation", "energy")
        units = [getattr(getattr(one, name), "unit", "") for one in self._all[:1] for name in names] or ["", ""]
        rows = [(*(number(float(plain(getattr(one, name)))) for name in names), _kind(one)) for one in self._all]
        header = (head("separation", units[0]), head("energy", units[1]), "kind")
        return (Table(f"Equilibria of angular momentum {number(self.angular_momentum)}", header, list(rows)),)

    def __repr__(self) -> str:
        return (
            f"Equilibria({len(self.apart)} apart, {len(self.touching)} touching, "
            f"angular_momentum={number(self.angular_momentum)}, least: {self.least!r})"
        )


def _energy(candidate: RelativeEquilibrium | Touching) -> float:
    return candidate.rotation.energy


def _kind(candidate: RelativeEquilibrium | Touching) -> str:
    if isinstance(candidate, Touching):
        return "touching"
    return "minimum" if candidate.energetically_stable else "stable" if candidate.linearly_stable else "unstable"


def equilibria(system: System, angular_momentum: Any) -> Equilibria:
    """Find all relative equilibria with a given angular momentum and both bodies locked, and the one of least energy.

    Parameters
    ----------
    system : System
        Two bodies without external forces.
    angular_momentum : float or Quantity
        Total angular momentum about the barycentre.

    Notes
    -----
    At a given angular momentum J the equilibria are the stationary points of the amended potential
    V = U + J . I^-1 J / 2 (Smale 1970, Scheeres 2006). The search takes every alignment of principal axes along the
    line and along J, at all separations from contact outwards, and finishes with Newton's method. Where bodies rest
    upon each other along principal axes, V counts with the distance of contact. Equilibria with tilted axes and contact
    at other points are not searched.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> found = fullbody.analysis.equilibria(system, 8e11)
    >>> found.least.energetically_stable, len(found.apart)
    (True, 70)
    """
    pair = Pair(system)
    value = system.context.units.number(angular_momentum, "angular momentum", "angular_momentum", POSITIVE)
    apart: list[RelativeEquilibrium] = []
    touching: list[Touching] = []
    missed: list[str] = []
    for axes in alignments(pair):
        distance = contact(pair, axes)
        start = aligned(axes, 2.0 * distance if distance > 0.0 else 1.0)
        problem = EquilibriumProblem(pair, (pair.axis(0, start), pair.axis(1, start)), {})
        for separation in scan(problem, axes, distance, value).crossings(value):
            guess = rotation_at(problem, aligned(axes, float(separation)))
            if guess is None:
                continue
            try:
                candidate = RelativeEquilibrium(problem, converged(problem, guess, "angular_momentum", value))
            except (NotConverged, BodiesOverlap) as error:
                missed.append(str(error))
                continue
            if not any(_same(candidate, other) for other in apart):
                apart.append(candidate)
        if distance > 0.0:
            touching_case = Touching(pair, axes, distance, value)
            if touching_case.rests:
                touching.append(touching_case)
    return Equilibria(system.context.units.attach(np.float64(value), "angular momentum"), apart, touching, missed)


def _same(candidate: RelativeEquilibrium, other: RelativeEquilibrium) -> bool:
    """Return whether two equilibria are the same."""
    first, second = (np.array([e.rotation.pose.distance, e.rotation.energy]) for e in (candidate, other))
    return bool(np.all(np.abs(first - second) <= _SAME * np.abs(first)))
