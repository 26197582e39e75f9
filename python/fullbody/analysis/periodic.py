"""Periodic motions of a pair, up to a rotation of the pair."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import sequence
from ..base.attributes import WithUnit
from ..base.kinds import instance, whole_number
from ..base.limits import NONZERO, POSITIVE
from ..base.tables import Table, Tabled, facts, number
from ..base.units import UNITLESS, without_unit
from ..errors import FullbodyError, InvalidInput
from ..model.state import State
from ..motion.system import System
from ..typing import Floats, Scalar
from ._pair import Pair, PairPoint, without_symmetries
from ._shooting import Ends, Shooting, closed_orbit, segmented
from .equilibrium import RelativeEquilibrium, upright

#: The largest closure of members of a family.
_FAMILY_CLOSURE = 1e-12
_HELD = ("period", "energy", "angular_momentum")
#: The largest number of segments, unless the caller gives a number.
_MAX_SEGMENTS = 32
#: The largest distance from the unit circle of a multiplier of a stable orbit.
_UNIT_CIRCLE_TOLERANCE = 1e-6


class PeriodicOrbit(Tabled):
    """A motion that repeats after its period, up to a rotation about the angular momentum; see :func:`periodic_orbit`.

    Attributes
    ----------
    system : System
    state : State
        A state of the orbit, with the barycentre at rest in the origin and the angular momentum along z.
    closure : float
        Distance of the end of a period from its start, in units of the separation, its rate, and radians.
    """

    def __init__(self, shooting: Shooting, ends: Ends, closure: float) -> None:
        self.system: System = shooting.pair.system
        self.state: State = shooting.points[0].state
        self.closure, self._shooting = closure, shooting
        self._transition = reduce(lambda product, end: end[1] @ product, ends, np.eye(18))

    period = WithUnit[Scalar]("The time after which the motion repeats.", "_shooting.period", "time")

    rotation_angle = WithUnit[Scalar](
        "The angle, -pi to pi, by which the pair has rotated about the angular momentum after a period.",
        lambda orbit: float(np.remainder(orbit._shooting.angle + np.pi, 2 * np.pi) - np.pi),
        "angle",
    )
    energy = WithUnit[Scalar](
        "Total energy with the barycentre at rest.",
        lambda orbit: orbit._shooting.points[0].energy,
        "energy",
    )
    angular_momentum = WithUnit[Scalar](
        "Total angular momentum, which is along z.",
        lambda orbit: float(orbit._shooting.points[0].angular_momentum[2]),
        "angular momentum",
    )

    @property
    def half_turns(self) -> dict[str, str]:
        """Axes about which bodies have made a half turn after a period, which an ellipsoid does not show."""
        halves = zip(self.system.names, self._shooting.half_turns, strict=True)
        return {name: "xyz"[axis - 1] for name, axis in halves if axis > 0}

    @cached_property
    def monodromy(self) -> Floats:
        """The monodromy matrix (18, 18): the derivative of a tangent vector after a period by the first one.

        The rotation of the pair is removed. A tangent vector contains the changes of the separation and its rate, and
        for each body a rotation vector in its frame and the change of its spin, in the system's units.
        """
        order = np.arange(18).reshape(2, 3, 3).swapaxes(0, 1).ravel()
        return self._monodromy[np.ix_(order, order)]

    @cached_property
    def _monodromy(self) -> Floats:
        """The monodromy matrix with the pose before the velocities."""
        return np.asarray(np.linalg.solve(self._shooting.target_derivatives()[0], self._transition))

    @cached_property
    def multipliers(self) -> npt.NDArray[np.complex128]:
        """Floquet multipliers, in descending order of size.

        Multipliers that are 1 by symmetry are left out: for the motion itself, the rotation about z and rotations of
        bodies about their axes, and for the energy, the angular momentum and the angular momenta of bodies about their
        axes. Two bodies without axes of symmetry have 12 multipliers left.
        """
        point, units, axes = self._shooting.points[0], self._shooting.units(), self._shooting.axes
        rows = np.vstack([point.energy_row(), point.momentum_rows(axes)])
        basis = without_symmetries(rows, np.column_stack([point.rates(), point.symmetries(axes)]), units)
        values = np.linalg.eigvals(basis.T @ (self._monodromy * units / units[:, np.newaxis]) @ basis)
        return values[np.argsort(-np.abs(values), kind="stable")].astype(np.complex128)

    @property
    def linearly_stable(self) -> bool:
        """Whether the orbit is linearly stable: all multipliers lie within 1e-6 of the unit circle."""
        return bool(np.all(np.abs(np.abs(self.multipliers) - 1.0) < _UNIT_CIRCLE_TOLERANCE))

    def _tables(self) -> tuple[Table, ...]:
        rows = facts(self, "period", "rotation_angle", "energy", "angular_momentum")
        rows.append(("closure", f"{self.closure:.2g}"))
        rows.append(("largest multiplier", f"{abs(self.multipliers[0]):.8g}"))
        rows.append(("linearly stable", "yes" if self.linearly_stable else "no"))
        return (Table("Periodic orbit", (), rows),)

    def __repr__(self) -> str:
        stable = "linearly stable" if self.linearly_stable else f"largest multiplier {abs(self.multipliers[0]):.6g}"
        angle = f"rotation_angle={number(self.rotation_angle, 6)}"
        return f"PeriodicOrbit(period={number(self.period)}, {angle}, closure={self.closure:.1g}, {stable})"


def periodic_orbit(
    system: System,
    state: State,
    period: Any,
    *,
    hold: str | Sequence[str] = "angular_momentum",
    segments: int | None = None,
    tolerance: float = 1e-12,
) -> PeriodicOrbit:
    """Find by multiple shooting the periodic motion near a state, up to a rotation of the pair.

    Parameters
    ----------
    system : System
        Two bodies without external forces.
    state : State
        A state near the orbit, such as :meth:`Modes.excited` gives.
    period : float or Quantity
        Approximate period.
    hold : str or sequence of str
        Quantities that keep the values of the start: some of ``"period"``, ``"energy"`` and
        ``"angular_momentum"``. Orbits form families with two parameters; where fewer than two are held, the orbit
        nearest to the start is found. To hold the energy takes a better start, since the small energy of an oscillation
        is quadratic in its amplitude.
    segments : int, optional
        The number of parts into which the period is divided; by default one for each revolution. More segments find
        orbits that are very unstable or long.
    tolerance : float
        The largest accepted ``closure``, which is the distance of the orbit's end from its start.

    Raises
    ------
    NotConverged
        If no orbit is found.

    Notes
    -----
    After the period the pair is rotated by an angle about the angular momentum, which is found with the orbit. In
    addition bodies may be rotated by any angle about their axes of symmetry, and ellipsoids by a half turn about a
    principal axis; the rotations nearest to the motion of the start are taken. Attitudes of spheres and points are
    ignored. Newton's linear equations, with the derivatives of the motion from :attr:`fullbody.Run.transition`, are
    solved by least squares; where they are degenerate (phase, rotation of the pair, position along the family), the
    solution of least change is taken.

    Examples
    --------
    A libration of Dimorphos about an axisymmetric Didymos:

    >>> import fullbody
    >>> system, _ = fullbody.systems.didymos_after_dart()
    >>> mean = fullbody.analysis.averaged(system, "Didymos", copies=6)
    >>> equilibrium = fullbody.analysis.relative_equilibrium(mean, separation=1.19, spin={"Didymos": 2.78})
    >>> modes = equilibrium.modes
    >>> libration = int(modes.in_plane.argmax())
    >>> orbit = fullbody.analysis.periodic_orbit(mean, modes.excited(libration, 0.1), modes.period[libration])
    >>> orbit.closure < 1e-12
    True
    """
    pair = Pair(system)
    time = system.context.units.number(period, "time", "period", POSITIVE)
    largest_closure = UNITLESS.number(tolerance, "number", "tolerance", POSITIVE)
    expected = f"some of {', '.join(_HELD)}"
    held = (hold,) if isinstance(hold, str) else sequence(hold, str, "hold", expected, expected)
    for name in held:
        if name not in _HELD:
            raise InvalidInput(f"hold has {name!r}; expected {expected}")
    start = upright(pair, state, "state")
    values = {"period": time, "energy": start.energy, "angular_momentum": float(start.angular_momentum[2])}
    targets = {name: values[name] for name in held}
    guess, ends = segmented(start, time, _segments(start, time, segments))
    return PeriodicOrbit(*closed_orbit(guess, ends, targets, largest_closure))


def periodic_family(
    equilibrium: RelativeEquilibrium, mode: int, amplitudes: Any, *, segments: int | None = None
) -> tuple[PeriodicOrbit, ...]:
    """Find the family of periodic orbits that grows out of a mode of an equilibrium, at its angular momentum.

    Parameters
    ----------
    equilibrium : RelativeEquilibrium
    mode : int
        Index of the mode.
    amplitudes : array_like, (F,)
        Approximate amplitudes of the orbits, as in :meth:`Modes.excited`, ordered so that each is near the one before;
        the first has to be small.
    segments : int, optional
        Number of segments, as in :func:`periodic_orbit`.

    Raises
    ------
    NotConverged
        If an orbit is not found; the error's attribute ``orbits`` contains those before.

    Notes
    -----
    Each orbit is searched near the one before: its difference from the equilibrium is scaled by the ratio of the
    amplitudes, the angular momentum of the equilibrium is held, and the start changes only normal to that difference.

    Examples
    --------
    >>> import fullbody
    >>> system, _ = fullbody.systems.kw4()
    >>> equilibrium = fullbody.analysis.relative_equilibrium(system, separation=5.0)
    >>> family = fullbody.analysis.periodic_family(equilibrium, 3, [0.1, 0.2])
    >>> bool(family[0].period < family[1].period)
    True
    """
    instance(equilibrium, "equilibrium", RelativeEquilibrium)
    sizes = UNITLESS.numbers(amplitudes, "number", "amplitudes", ("A",), NONZERO)
    if not len(sizes):
        raise InvalidInput("amplitudes is empty; expected one or more")
    centre, modes = equilibrium.rotation.point, equilibrium.modes
    deviation = PairPoint.of(centre.pair, modes.excited(mode, sizes[0])).tangent_from(centre)
    time = float(without_unit(modes.period[mode]))
    if not np.isfinite(time):
        raise InvalidInput(f"mode is {mode!r}, which does not oscillate; expected one whose frequency is above zero")
    targets = {"angular_momentum": float(centre.angular_momentum[2])}
    orbits: list[PeriodicOrbit] = []
    for previous, size in zip((sizes[0], *sizes), sizes, strict=False):
        start = centre.displaced(deviation * (size / previous))
        count = _segments(start, time, segments)
        try:
            orbit = PeriodicOrbit(*closed_orbit(*segmented(start, time, count), targets, _FAMILY_CLOSURE, deviation))
        except FullbodyError as error:
            error.orbits = tuple(orbits)  # type: ignore[attr-defined]
            raise
        orbits.append(orbit)
        deviation = orbit._shooting.points[0].tangent_from(centre)
        time = orbit._shooting.period
    return tuple(orbits)


def _segments(start: PairPoint, time: float, segments: Any) -> int:
    """Return the number of segments: the given one, or one for each revolution of a circular orbit."""
    if segments is None:
        revolutions = time * start.pair.orbital_rate(start.pose.distance) / (2 * np.pi)
        return int(np.clip(np.ceil(revolutions - 0.5), 1, _MAX_SEGMENTS))
    return whole_number(segments, "segments")
