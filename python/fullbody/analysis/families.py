"""Many relative equilibria: families, followed around their folds, and all of a given angular momentum."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..base.attributes import WithUnit
from ..base.kinds import choice, instance, whole_number
from ..base.limits import POSITIVE
from ..base.tables import Table, Tabled, facts, head, number
from ..base.units import need, without_unit
from ..errors import BodiesOverlap, NotConverged
from ..motion.system import System
from ..typing import Array, Floats
from . import pictures
from ._newton import Axes, aligned, alignments, contact, converged, corrected, scan
from ._pair import Pair
from ._rotation import Rotation
from .equilibrium import RelativeEquilibrium, UniformRotation

#: Step lengths along the branch in the units of :meth:`Rotation.scales`: the first, the longest and the
#: shortest.
_FIRST_STEP, _LONGEST_STEP, _SHORTEST_STEP = 0.01, 0.05, 1e-7
#: Quantities that may fold, which means that they have an extreme along a branch.
_FOLDING: tuple[Literal["separation", "angular_momentum"], ...] = ("separation", "angular_momentum")
#: The energy of an equilibrium, by which they are sorted.
_ENERGY = attrgetter("rotation.point.energy")
#: Energies and separations whose relative difference is less than this are equal.
_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Fold:
    """The ``equilibrium`` of a branch at which a ``quantity``, separation or angular momentum, is extreme."""

    quantity: str
    equilibrium: RelativeEquilibrium

    def __repr__(self) -> str:
        value = number(getattr(self.equilibrium, self.quantity))
        return f"Fold({self.quantity}={value} at a separation of {number(self.equilibrium.separation)})"


def _column(text: str, name: str, dimension: str) -> WithUnit[Array]:
    """Return a property of branches: numbers of each equilibrium (K, ...)."""
    get = attrgetter(name)
    return WithUnit(
        text, lambda branch: np.array([without_unit(get(member)) for member in branch.equilibria]), dimension
    )


class Branch(Tabled):
    """A family of relative equilibria, made by :func:`branch`; ``branch[k]`` is its k-th equilibrium.

    Attributes
    ----------
    equilibria : tuple of RelativeEquilibrium
        The K equilibria in the order of the branch.
    folds : tuple of Fold
        The extremes of separation or angular momentum, in the order of the branch.
    end : str
        Why the branch ends: ``"reached"`` at the value of ``until``; ``"contact"``, where the bodies would overlap;
        ``"steps"``, after the number of steps that were allowed; ``"lost"``, where Newton's method found no further
        equilibrium however short the step.
    """

    def __init__(self, equilibria: list[RelativeEquilibrium], folds: list[Fold], end: str) -> None:
        self.equilibria, self.folds, self.end = tuple(equilibria), tuple(folds), end
        self.system = equilibria[0].system

    separation = _column("Distances (K,) between the centres.", "separation", "length")
    rate = _column("Rates (K,) at which the pair rotates.", "rate", "spin")
    angular_momentum = _column("Total angular momenta (K,).", "angular_momentum", "angular momentum")
    energy = _column("Total energies (K,).", "energy", "energy")
    frequency = _column(
        "Frequencies (K, M) of the modes, ascending; zero for modes that grow without oscillating.",
        "modes.frequency",
        "spin",
    )

    @property
    def linearly_stable(self) -> npt.NDArray[np.bool_]:
        """Whether each equilibrium (K,) is linearly stable: no mode grows."""
        return np.array([member.linearly_stable for member in self.equilibria])

    @property
    def energetically_stable(self) -> npt.NDArray[np.bool_]:
        """Whether each equilibrium (K,) is energetically stable: the energy has a minimum there."""
        return np.array([member.energetically_stable for member in self.equilibria])

    plot = pictures.branch

    def __len__(self) -> int:
        return len(self.equilibria)

    def __getitem__(self, index: int) -> RelativeEquilibrium:
        return self.equilibria[index]

    def _tables(self) -> tuple[Table, ...]:
        rows = [("folds", "; ".join(map(repr, self.folds)) or "none"), ("end", self.end)]
        for name in ("separation", "angular_momentum", "energy"):
            first, last = (number(getattr(self.equilibria[k], name)) for k in (0, -1))
            rows.append((name.replace("_", " "), f"from {first} to {last}"))
        return (Table(f"Branch of {len(self)} relative equilibria", (), list(rows)),)

    def __repr__(self) -> str:
        ends = " to ".join(number(self.equilibria[k].separation) for k in (0, -1))
        folds = f"{len(self.folds)} fold{'s' if len(self.folds) != 1 else ''}"
        return f"Branch({len(self)} equilibria, separation {ends}, {folds}, end={self.end!r})"


def branch(
    equilibrium: RelativeEquilibrium,
    over: Literal["separation", "angular_momentum"] = "separation",
    *,
    until: Any,
    steps: int = 400,
) -> Branch:
    """Follow the family of a relative equilibrium to another separation or angular momentum, around its folds.

    Parameters
    ----------
    equilibrium : RelativeEquilibrium
        The spins of its bodies that are not locked are kept.
    over : {"separation", "angular_momentum"}
        The quantity whose final value is ``until``. The branch sets out towards it; behind a fold it may come back
        without having reached it.
    until : float or Quantity
    steps : int
        The largest number of steps.

    Notes
    -----
    The method is pseudo-arclength continuation (Keller 1977): a step along the tangent of the family, and Newton's
    method in the space normal to it, which is regular at folds. Folds are the roots of the tangent's component, found
    by scipy's ``brentq``.

    Examples
    --------
    >>> import fullbody
    >>> system, _ = fullbody.systems.kw4()
    >>> far = fullbody.analysis.relative_equilibrium(system, separation=4.0)
    >>> fullbody.analysis.branch(far, "separation", until=3.0)
    Branch(... equilibria, separation 4 to 3, 1 fold, end='reached')
    """
    instance(equilibrium, "equilibrium", RelativeEquilibrium)
    choice(over, "over", _FOLDING)
    dimension = "length" if over == "separation" else "angular momentum"
    goal = equilibrium.system.context.units.number(until, dimension, "until", POSITIVE)
    count = whole_number(steps, "steps")
    rotation = equilibrium.rotation
    sign = np.sign(goal - rotation.quantity(over))
    members, folds = [equilibrium], list[Fold]()
    if sign == 0.0:
        return Branch(members, folds, "reached")
    tangent = _tangent(rotation)
    tangent = tangent * sign * (np.sign(_derivative(rotation, tangent, over)) or 1.0)
    length, end = _FIRST_STEP, "steps"
    while len(members) <= count:
        try:
            following = corrected(rotation, tangent, length)
        except (BodiesOverlap, NotConverged) as error:
            length /= 2
            if length >= _SHORTEST_STEP:
                continue
            end = "contact" if isinstance(error, BodiesOverlap) else "lost"
            break
        next_tangent = _tangent(following)
        next_tangent = next_tangent * np.sign(next_tangent @ tangent)
        if next_tangent @ tangent < 0.95 and length > _FIRST_STEP / 10:
            length /= 2
            continue
        for quantity in _FOLDING:
            if _derivative(rotation, tangent, quantity) * _derivative(following, next_tangent, quantity) < 0.0:
                fold = _fold(rotation, tangent, length, quantity)
                folds.append(Fold(quantity, RelativeEquilibrium(fold)))
        if (following.quantity(over) - goal) * sign >= 0.0:
            members.append(RelativeEquilibrium(converged(following, over, goal)))
            end = "reached"
            break
        members.append(RelativeEquilibrium(following))
        rotation, tangent, length = following, next_tangent, min(1.3 * length, _LONGEST_STEP)
    return Branch(members, folds, end)


def _tangent(rotation: Rotation) -> Floats:
    """Return the unit tangent (10,) of the family at a rotation, in the units of its scales."""
    return np.linalg.svd(rotation.equations()[0])[2][-1]


def _derivative(rotation: Rotation, tangent: Floats, quantity: Any) -> float:
    """Return the derivative of a quantity along a direction."""
    return float(rotation.quantity_gradient(quantity) @ (tangent * rotation.scales()[1]))


def _fold(rotation: Rotation, tangent: Floats, length: float, quantity: Any) -> Rotation:
    """Find the extreme of a quantity within a step."""
    with need("analysis", "a branch of equilibria"):
        from scipy.optimize import brentq

    def derivative(step: float) -> float:
        middle = corrected(rotation, tangent, step)
        middle_tangent = _tangent(middle)
        return _derivative(middle, middle_tangent * np.sign(middle_tangent @ tangent), quantity)

    return corrected(rotation, tangent, brentq(derivative, 0.0, length, xtol=1e-14, rtol=1e-14))


class Touching(UniformRotation):
    """Two bodies at rest upon each other that rotate together.

    Attributes
    ----------
    system : System
    state : State
    """

    def __init__(self, pair: Pair, axes: Axes, distance: float, angular_momentum: float) -> None:
        # The angular momentum of uniform rotation is proportional to the rate.
        unit = Rotation(pair, aligned(axes, distance), 1.0, (None, None), {})
        super().__init__(unit.at(unit.pose, angular_momentum / unit.quantity("angular_momentum")))

    @property
    def rests(self) -> bool:
        """Whether the bodies stay in contact: gravity exceeds the centripetal force on their circular paths."""
        return bool(self.rotation.residual()[0] < 0.0)

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
    failures : tuple of str
        Messages about alignments from which the search reached no equilibrium; for ellipsoids they occur only at folds.
    """

    def __init__(
        self, angular_momentum: Any, apart: list[RelativeEquilibrium], touching: list[Touching], failures: list[str]
    ) -> None:
        self.angular_momentum = angular_momentum
        self.apart = tuple(sorted(apart, key=_ENERGY))
        self.touching = tuple(sorted(touching, key=_ENERGY))
        self.failures = tuple(failures)

    @cached_property
    def _all(self) -> list[RelativeEquilibrium | Touching]:
        return sorted([*self.apart, *self.touching], key=_ENERGY)

    @property
    def least(self) -> RelativeEquilibrium | Touching:
        """The state of least energy, which a pair reaches that loses energy but no angular momentum."""
        if not self._all:
            raise NotConverged("no equilibrium was found, neither apart nor touching; see .failures")
        return self._all[0]

    def _tables(self) -> tuple[Table, ...]:
        names = ("separation", "energy")
        units = [getattr(getattr(state, name), "unit", "") for state in self._all[:1] for name in names] or ["", ""]
        rows = [
            (*(number(float(without_unit(getattr(state, name)))) for name in names), _kind(state))
            for state in self._all
        ]
        header = (*map(head, names, units), "kind")
        return (Table(f"Equilibria of angular momentum {number(self.angular_momentum)}", header, list(rows)),)

    def __repr__(self) -> str:
        return (
            f"Equilibria({len(self.apart)} apart, {len(self.touching)} touching, "
            f"angular_momentum={number(self.angular_momentum)}, least: {self.least!r})"
        )


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
    failures: list[str] = []
    for axes in alignments(pair):
        distance = contact(pair, axes)
        pose = aligned(axes, 2.0 * distance if distance > 0.0 else 1.0)
        start = Rotation(pair, pose, 0.0, pair.axes(pose), {})
        for separation in scan(start, axes, distance, value).crossings(value):
            guess = start.balanced(aligned(axes, float(separation)))
            if guess is None:
                continue
            try:
                candidate = RelativeEquilibrium(converged(guess, "angular_momentum", value))
            except (NotConverged, BodiesOverlap) as error:
                failures.append(str(error))
                continue
            if not any(np.allclose(_numbers(candidate), _numbers(other), _TOLERANCE, 0.0) for other in apart):
                apart.append(candidate)
        if distance > 0.0:
            pair_in_contact = Touching(pair, axes, distance, value)
            if pair_in_contact.rests:
                touching.append(pair_in_contact)
    return Equilibria(system.context.units.attach(np.float64(value), "angular momentum"), apart, touching, failures)


def _numbers(candidate: RelativeEquilibrium) -> tuple[float, float]:
    """Return the separation and the energy, which are equal for equal equilibria alone."""
    return candidate.rotation.pose.distance, _ENERGY(candidate)
