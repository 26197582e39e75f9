"""Periodic motions of a pair, apart from a turn of the whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import rotations
from ..base.arguments import integer, named_options
from ..base.tables import Table, Tabled, number
from ..base.units import numbers, scalar
from ..errors import BodiesOverlap, InvalidInput, NotConverged
from ..model.state import State
from ..motion.simulation import System
from ..typing import Scalar
from ._flow import SPINS, TURNS, Point, flow, generators, momentum_rows, rotation_vector
from ._linear import complement, even, kernel
from ._pair import Array, Pair, Pose, cross
from .equilibrium import pose_of

__all__ = ["PeriodicOrbit", "periodic_orbit"]

_HELD = ("period", "energy", "angular_momentum")
#: Steps of Newton's method at most, and those in a row that may bring nothing.
_STEPS, _LOST = 40, 6
#: Segments, unless more are asked for.
_MOST = 32
#: The longest step, in the units of :meth:`_Shooting.units`, and directions in which nothing is known.
_LONGEST, _UNKNOWN = 0.2, 1e-9
#: How far from the unit circle a multiplier of a stable orbit may lie.
_ROUND = 1e-6
_HALF_TURNS = np.eye(4)


class PeriodicOrbit(Tabled):
    """A motion that repeats after its period, turned as a whole about the angular momentum; see :func:`periodic_orbit`.

    Attributes
    ----------
    system : System
    state : State
        One of its states: barycentre at rest in the origin, angular momentum along z.
    closure : float
        By how much the motion misses its start after one period, in units of the separation, its rate, and radians.
    """

    def __init__(self, shooting: _Shooting, closure: float, transition: Array) -> None:
        pair, point = shooting.pair, shooting.points[0]
        self.system: System = shooting.system
        self.state: State = self.system._state(pair.state(point.pose, point.velocity, point.spin))
        self.closure = closure
        self._shooting = shooting
        self._transition = transition

    @property
    def period(self) -> Scalar:
        """After which the motion repeats."""
        found: Scalar = self.system._units.attach(self._shooting.period, "time")
        return found

    @property
    def turn(self) -> Scalar:
        """The angle, -pi to pi, by which the whole has turned about the angular momentum after a period."""
        angle = float(np.remainder(self._shooting.angle + np.pi, 2 * np.pi) - np.pi)
        found: Scalar = self.system._units.attach(angle, "angle")
        return found

    @property
    def half_turns(self) -> dict[str, str]:
        """Bodies that come back turned by half a turn about one of their axes, which an ellipsoid does not show."""
        turned = {}
        for name, own in zip(self.system.names, self._shooting.half, strict=True):
            if own > 0:
                turned[name] = "xyz"[own - 1]
        return turned

    @cached_property
    def energy(self) -> Scalar:
        """Total energy with the barycentre at rest."""
        value = self._shooting.points[0].energy(self._shooting.pair)
        found: Scalar = self.system._units.attach(value, "energy")
        return found

    @cached_property
    def angular_momentum(self) -> Scalar:
        """Total angular momentum, along z."""
        value = float(self._shooting.points[0].angular_momentum(self._shooting.pair)[2])
        found: Scalar = self.system._units.attach(value, "angular momentum")
        return found

    @cached_property
    def monodromy(self) -> Array:
        """Departures after a period by those at its start (18, 18), turned back as the orbit itself.

        In order: the separation and its rate, and for each body a rotation vector in its frame and its spin; in the
        system's units.
        """
        shooting = self._shooting
        return np.asarray(np.linalg.solve(shooting.target_slopes()[0], self._transition))

    @cached_property
    def multipliers(self) -> npt.NDArray[np.complex128]:
        """Floquet multipliers, of the largest size first.

        Those at 1 by the symmetries are taken away: of the motion itself, the turn about z and turns of bodies about
        their axes, and of the energy, the angular momentum and those of bodies about their axes. Of two bodies without
        axes of symmetry 12 are left.
        """
        shooting, pair = self._shooting, self._shooting.pair
        point, units = shooting.points[0], shooting.units()
        rows = [point.energy_row(pair), *momentum_rows(pair, point)]
        for k, axis in enumerate(shooting.axes):
            ways = np.eye(3) if axis == 3 else np.zeros((0, 3)) if axis is None else np.eye(3)[[axis]]
            for way in ways:
                row = np.zeros(18)
                row[SPINS[k]] = way
                if axis == 3:
                    # The spin of a sphere as seen from without.
                    row[TURNS[k]] = -way @ cross(point.spin[k])
                rows.append(row)
        moves = np.column_stack([point.rates(pair), generators(point, shooting.axes)])
        still = kernel(even(np.array(rows) * units))
        basis = still @ complement(even((still.T @ (moves / units[:, np.newaxis])).T).T)
        values = np.linalg.eigvals(basis.T @ (self.monodromy * units / units[:, np.newaxis]) @ basis)
        found: npt.NDArray[np.complex128] = values[np.argsort(-np.abs(values), kind="stable")].astype(np.complex128)
        return found

    @property
    def linearly_stable(self) -> bool:
        """Whether all multipliers lie on the unit circle, to 1e-6."""
        return bool(np.all(np.abs(np.abs(self.multipliers) - 1.0) < _ROUND))

    def _tables(self) -> tuple[Table, ...]:
        names = ("period", "turn", "energy", "angular_momentum")
        rows = [(name.replace("_", " "), number(getattr(self, name))) for name in names]
        rows.append(("closure", f"{self.closure:.2g}"))
        rows.append(("largest multiplier", f"{abs(self.multipliers[0]):.8g}"))
        rows.append(("linearly stable", "yes" if self.linearly_stable else "no"))
        return (Table("Periodic orbit", (), list(rows)),)

    def __repr__(self) -> str:
        stable = "linearly stable" if self.linearly_stable else f"largest multiplier {abs(self.multipliers[0]):.6g}"
        return (
            f"PeriodicOrbit(period={number(self.period)}, turn={number(self.turn, 6)}, closure={self.closure:.1g}, "
            f"{stable})"
        )


@dataclass
class _Shooting:
    """Points along an orbit at equal times, its period, and by what its end is turned against its start."""

    system: System
    pair: Pair
    points: list[Point]
    period: float
    angle: float
    axes: tuple[int | None, int | None]
    #: For each body 0, or 1 to 3 for a half turn about x, y or z.
    half: list[int]
    #: Turns of bodies about their axes of symmetry.
    own: Array

    def units(self) -> Array:
        """Units (18,) of departures: the separation, its rate, radians."""
        d = self.points[0].pose.distance
        n = np.sqrt(self.pair.strength / (self.pair.mass * d**3))
        return np.concatenate([np.repeat([d, d * n], 3), np.repeat([1.0, n, 1.0, n], 3)])

    def own_turns(self) -> Array:
        """Quaternions (2, 4) by which bodies turn in their frames beside the whole."""
        found = np.array([_HALF_TURNS[half] for half in self.half])
        for k, axis in enumerate(self.axes):
            if axis is not None and axis < 3:
                found[k] = rotations.turn(axis, float(self.own[k]))
        return found

    def target(self) -> Point:
        """Where the orbit has to end."""
        return self.points[0].turned(self.angle, self.own_turns())

    def target_slopes(self) -> tuple[Array, Array]:
        """Of the target with the start (18, 18), and with the angle and the bodies' own turns (18, 3)."""
        target = self.target()
        whole = rotations.matrices(rotations.turn(2, self.angle))
        start, turns = np.zeros((18, 18)), np.zeros((18, 3))
        start[:3, :3] = start[3:6, 3:6] = whole
        turns[:, 0] = generators(target, (None, None))[:, 0]
        for k, own in enumerate(rotations.matrices(self.own_turns())):
            start[TURNS[k], TURNS[k]] = start[SPINS[k], SPINS[k]] = own.T
            axis = self.axes[k]
            if axis is not None and axis < 3:
                way = np.eye(3)[axis]
                turns[TURNS[k], 1 + k], turns[SPINS[k], 1 + k] = way, -np.cross(way, target.spin[k])
        return start, turns


@named_options
def periodic_orbit(
    system: System,
    state: State,
    period: Any,
    *,
    hold: str | Sequence[str] = ("energy", "angular_momentum"),
    segments: int | None = None,
    tolerance: float = 1e-12,
) -> PeriodicOrbit:
    """Find the periodic motion near a state, apart from a turn of the whole, by multiple shooting.

    Parameters
    ----------
    system : System
        Two bodies, without forces from outside.
    state : State
        Near the orbit, such as :meth:`Modes.excited` gives.
    period : float or Quantity
        About the period.
    hold : str or sequence of str
        What keeps the value that it has at the start: of ``"period"``, ``"energy"`` and ``"angular_momentum"``. Orbits
        make families with two parameters; where fewer than two are held, the orbit that is nearest to the start is
        found.
    segments : int, optional
        Into how many parts the period is divided; unless given, one for each revolution. More of them find orbits that
        are very unstable or long.
    tolerance : float
        The closure that is asked for; see :attr:`PeriodicOrbit.closure`.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    InvalidInput
    NotConverged
        Where no orbit is found.
    BodiesOverlap

    Notes
    -----
    After the period the whole is turned by an angle about the angular momentum, which is found with the orbit; bodies
    may be turned besides by any angle about their axes of symmetry, and ellipsoids by half a turn about a principal
    axis, whichever is nearest to what the start does. Attitudes of spheres and points do not count. The linear
    equations of Newton's method, with the derivatives of the motion by :attr:`fullbody.Run.transition`, are solved by
    least squares, of least change where they leave a choice: of the phase, of the turn of the whole, and within a
    family.

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
    if not isinstance(system, System):
        raise InvalidInput(f"system is {system!r}; expected a System")
    time = system._units.number(period, "time", "period")
    if time <= 0.0:
        raise InvalidInput(f"period is {period!r}; expected a number above zero")
    within = scalar(numbers(tolerance, "tolerance"), "tolerance")
    if not 0.0 < within < np.inf:
        raise InvalidInput(f"tolerance is {tolerance!r}; expected a number above zero")
    held = _held(hold)
    pose, turn = pose_of(pair, state, "state")
    count = _segments(pair, pose, time, segments)
    shooting, ends = _first(system, pair, Point.of(system._strip(state)), pose, turn, time, count)
    first = shooting.points[0]
    kept = {"period": time, "energy": first.energy(pair), "angular_momentum": float(first.angular_momentum(pair)[2])}
    best, lost = np.inf, 0
    for _ in range(_STEPS):
        matrix, missing = _equations(shooting, ends, held, kept)
        closure = float(np.abs(missing).max())
        if closure <= within and closure >= 0.1 * best:
            break
        lost = 0 if closure < 0.5 * best else lost + 1
        best = min(best, closure)
        if lost > _LOST:
            break
        step: Array = np.asarray(np.linalg.lstsq(matrix, -missing, rcond=_UNKNOWN)[0])
        step *= min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
        shooting, ends = _stepped(shooting, step, count)
    if closure > within:
        raise NotConverged(
            f"no periodic orbit found: the best that Newton's method came by misses its start by {best:.2g}, of the "
            f"separation or in radians, the last one after the period "
            f"{number(system._units.attach(np.float64(shooting.period), 'time'))}; expected a start nearer to one, "
            f"more segments than {count}, or less to hold"
        )
    transition = np.eye(18)
    for _, part in ends:
        transition = part @ transition
    return PeriodicOrbit(shooting, closure, transition)


def _held(hold: str | Sequence[str]) -> tuple[str, ...]:
    held = (hold,) if isinstance(hold, str) else tuple(hold)
    for name in held:
        if name not in _HELD:
            raise InvalidInput(f"hold has {name!r}; expected some of {', '.join(_HELD)}")
    return held


_Ends = list[tuple[Point, Array]]


def _segments(pair: Pair, pose: Pose, time: float, segments: Any) -> int:
    """How many segments: as many as asked for, or one for each revolution of a circular orbit."""
    if segments is None:
        revolution = 2 * np.pi * np.sqrt(pair.mass * pose.distance**3 / pair.strength)
        return int(np.clip(np.ceil(time / revolution - 0.5), 1, _MOST))
    count = integer(segments)
    if count is None or count < 1:
        raise InvalidInput(f"segments is {segments!r}; expected a whole number, 1 or more")
    return count


def _first(
    system: System, pair: Pair, start: Point, pose: Pose, turn: Array, time: float, count: int
) -> tuple[_Shooting, _Ends]:
    """The start in its pose in axes turned by a matrix, and what its motion is nearest to."""
    point = Point(pose, turn @ start.velocity, start.spin)
    axes = (pair.axis(0, pose), pair.axis(1, pose))
    points, ends = [point], _Ends()
    for _ in range(count):
        ends.append(flow(pair, points[-1], time / count))
        points.append(ends[-1][0])
    end = points.pop()
    angle = float(np.arctan2(end.pose.r[1], end.pose.r[0]) - np.arctan2(point.pose.r[1], point.pose.r[0]))
    shooting = _Shooting(system, pair, points, time, angle, axes, [0, 0], np.zeros(2))
    whole = point.turned(angle, np.array([_HALF_TURNS[0]] * 2))
    for k in range(2):
        axis, back = axes[k], whole.pose.attitude[k]
        if axis is None and system.bodies[k]._semi_axes(system._units) is not None:
            misses = [
                float(np.linalg.norm(rotation_vector(end.pose.attitude[k], rotations.product(back, half))))
                for half in _HALF_TURNS
            ]
            shooting.half[k] = int(np.argmin(misses))
        elif axis is not None and axis < 3:
            w, *q = rotations.product(back * [1.0, -1.0, -1.0, -1.0], end.pose.attitude[k])
            shooting.own[k] = 2 * np.arctan2(q[axis], w)
    return shooting, ends


def _equations(shooting: _Shooting, ends: _Ends, held: tuple[str, ...], kept: dict[str, float]) -> tuple[Array, Array]:
    """The linear equations of a step (18 K + H, 18 K + 4), and what is missing (18 K + H,), in units of departures.

    Unknown are the departures of all points, the logarithm of the period, the angle, and the bodies' own turns.
    """
    pair, count, units = shooting.pair, len(ends), shooting.units()
    matrix = np.zeros((18 * count + len(held), 18 * count + 4))
    missing = np.zeros(len(matrix))
    start, turns = shooting.target_slopes()
    for k, (end, transition) in enumerate(ends):
        rows = slice(18 * k, 18 * k + 18)
        last = k == count - 1
        target = shooting.target() if last else shooting.points[k + 1]
        missing[rows] = end.less(target) / units
        matrix[rows, rows] += transition * units / units[:, np.newaxis]
        following = slice(0, 18) if last else slice(18 * k + 18, 18 * k + 36)
        matrix[rows, following] -= (start if last else np.eye(18)) * units / units[:, np.newaxis]
        matrix[rows, 18 * count] = end.rates(pair) * shooting.period / count / units
        if last:
            matrix[rows, 18 * count + 1 :] = -turns / units[:, np.newaxis]
    for k, axis in enumerate(shooting.axes):
        if axis == 3:
            for part in range(count):
                for rows in (TURNS[k], SPINS[k]):
                    place = slice(18 * part + rows.start, 18 * part + rows.stop)
                    matrix[place], missing[place] = 0.0, 0.0
                    matrix[:, place] = 0.0
    point = shooting.points[0]
    for row, name in enumerate(held, start=18 * count):
        if name == "period":
            matrix[row, 18 * count] = 1.0
            missing[row] = np.log(shooting.period / kept[name])
            continue
        slope = point.energy_row(pair) if name == "energy" else momentum_rows(pair, point)[2]
        value = point.energy(pair) if name == "energy" else float(point.angular_momentum(pair)[2])
        unit = float(np.abs(slope * units).max())
        matrix[row, :18] = slope * units / unit
        missing[row] = (value - kept[name]) / unit
    return matrix, missing


def _stepped(shooting: _Shooting, step: Array, count: int) -> tuple[_Shooting, _Ends]:
    """The orbit after a step, of which less is taken where the bodies would overlap."""
    units = shooting.units()
    for _ in range(6):
        points = [p.moved(step[18 * k : 18 * k + 18] * units) for k, p in enumerate(shooting.points)]
        period = shooting.period * float(np.exp(step[18 * count]))
        angle = shooting.angle + float(step[18 * count + 1])
        own = shooting.own + step[18 * count + 2 :]
        new = _Shooting(shooting.system, shooting.pair, points, period, angle, shooting.axes, list(shooting.half), own)
        try:
            return new, [flow(shooting.pair, point, period / count) for point in points]
        except BodiesOverlap as error:
            overlap = error
            step = step / 2
    raise overlap
