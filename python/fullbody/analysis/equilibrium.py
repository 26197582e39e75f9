"""Relative equilibria of a pair: motions that look still from a frame that turns uniformly."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ..base import rotations
from ..base.arguments import integer, named_options
from ..base.tables import Table, Tabled, number
from ..errors import InvalidInput, NotConverged
from ..model.bodies import Body
from ..model.composite import Composite, Part
from ..model.shapes import Ellipsoid, Sphere
from ..model.state import State
from ..model.system import BaseSystem
from ..typing import Scalar
from ._linear import Rotation
from ._newton import Condition, Kind, Problem, converged
from ._pair import Array, Pair, Pose
from ._starts import Axes, aligned, contact, long_axes, rotation_at, scan
from .modes import Modes, departed, modes_of

__all__ = ["RelativeEquilibrium", "averaged", "relative_equilibrium"]

#: Curvatures below this are those of directions in which nothing changes.
_FLAT = 1e-10


class RelativeEquilibrium(Tabled):
    """Two bodies that turn as one about their barycentre, made by :func:`relative_equilibrium` and others.

    Bodies that are not locked spin at a steady rate about their axis of symmetry beside that.

    Attributes
    ----------
    system : System
    state : State
        Barycentre at rest in the origin, the angular momentum along z, the second body above the x-axis from the first.
    """

    def __init__(self, problem: Problem, rotation: Rotation) -> None:
        # The frame's x-axis goes through the projection of the separation.
        angle = -np.arctan2(rotation.pose.r[1], rotation.pose.r[0])
        turn = rotations.turn(2, angle)
        attitude = np.array([rotations.product(turn, q) for q in rotation.pose.attitude])
        r = np.array([np.hypot(*rotation.pose.r[:2]), 0.0, rotation.pose.r[2]])
        self._problem = problem
        self._rotation = problem.rotation(Pose(r, attitude), rotation.rate)
        self.system: BaseSystem = problem.pair.system
        self.state: State = departed(self._rotation, np.zeros(18))

    @property
    def separation(self) -> Scalar:
        """Distance of the centres."""
        found: Scalar = self.system._units.attach(self._rotation.pose.distance, "length")
        return found

    @property
    def rate(self) -> Scalar:
        """Rate Omega at which the pair turns."""
        found: Scalar = self.system._units.attach(self._rotation.rate, "spin")
        return found

    @property
    def period(self) -> Scalar:
        """2 pi by the rate."""
        found: Scalar = self.system._units.attach(2 * np.pi / self._rotation.rate, "time")
        return found

    @cached_property
    def angular_momentum(self) -> Scalar:
        """Total angular momentum about the barycentre, along z."""
        found: Scalar = self.system._units.attach(float(self._rotation.angular_momentum[2]), "angular momentum")
        return found

    @cached_property
    def energy(self) -> Scalar:
        """Total energy with the barycentre at rest."""
        found: Scalar = self.system._units.attach(self._rotation.energy, "energy")
        return found

    @property
    def locked(self) -> tuple[str, ...]:
        """Names of the bodies that always show the other one the same face."""
        return tuple(name for k, name in enumerate(self.system.names) if k not in self._problem.spin)

    @cached_property
    def residual(self) -> float:
        """What is missing to balance, the largest part: of the forces by G m m / r^2, of the torques by G m m / r."""
        rows, _ = self._problem.scales(self._rotation)
        return float(np.abs(self._problem.residual(self._rotation) / rows).max())

    @cached_property
    def modes(self) -> Modes:
        """Normal modes."""
        return modes_of(self._rotation)

    @property
    def linearly_stable(self) -> bool:
        """Whether no mode grows."""
        growth = self.modes.growth
        return not np.any(np.asarray(getattr(growth, "value", growth)) > 0.0)

    @cached_property
    def curvatures(self) -> Array:
        """Eigenvalues (D,) of the Hessian of the amended potential, ascending.

        The variables are the separation in units of its length r, and rotation vectors of the bodies times
        sqrt(I / (m r^2)), with I the largest moment of inertia and m the reduced mass, without the symmetries; the unit
        of energy is G m_0 m_1 / r.
        """
        return self._rotation.amended_hessian()[0]

    @property
    def energetically_stable(self) -> bool:
        """Whether the energy has a minimum here among all states of this angular momentum: no curvature is below zero.

        Then neither other conservative motions nor a slow loss of energy in locked bodies carry the pair away; bodies
        that are not locked keep their angular momentum about their axes.
        """
        return bool(np.all(np.asarray(self.curvatures) > _FLAT))

    def _tables(self) -> tuple[Table, ...]:
        names = ("separation", "rate", "period", "angular_momentum", "energy")
        rows = [(name.replace("_", " "), number(getattr(self, name))) for name in names]
        free = [name for name in self.system.names if name not in self.locked]
        rows.append(("locked", ", ".join(self.locked) or "neither body"))
        rows += [(f"spin of {name}", number(self._spin(self.system.names.index(name)))) for name in free]
        rows.append(("linearly stable", "yes" if self.linearly_stable else "no"))
        rows.append(("minimum of energy", "yes" if self.energetically_stable else "no"))
        return (Table("Relative equilibrium", (), list(rows)), *self.modes._tables())

    def _spin(self, body: int) -> Scalar:
        found: Scalar = self.system._units.attach(self._problem.spin[body], "spin")
        return found

    def __repr__(self) -> str:
        free = [
            f", {name} spinning at {number(self._spin(k), 6)}"
            for k, name in enumerate(self.system.names)
            if k in self._problem.spin
        ]
        stable = "linearly stable" if self.linearly_stable else "unstable"
        stable = "a minimum of energy" if self.energetically_stable else f"{stable}, no minimum of energy"
        locked = " and ".join(self.locked) or "neither body"
        return (
            f"RelativeEquilibrium(separation={number(self.separation)}, period={number(self.period)}, "
            f"{locked} locked{''.join(free)}; {stable})"
        )


@named_options
def relative_equilibrium(
    system: BaseSystem,
    *,
    separation: Any = None,
    angular_momentum: Any = None,
    rate: Any = None,
    spin: Mapping[str, Any] | None = None,
    axes: Mapping[str, Any] | None = None,
    start: State | None = None,
) -> RelativeEquilibrium:
    """Find a relative equilibrium of a pair by Newton's method with exact derivatives.

    Parameters
    ----------
    system : System
        Two bodies, without forces from outside.
    separation, angular_momentum, rate : float or Quantity
        One of the three, which the equilibrium is to have: the distance of the centres, the total angular momentum, or
        the rate at which the pair turns.
    spin : dict, optional
        By the names of bodies that are not locked their spins about their axes of symmetry; the others are locked. A
        body that is not locked needs such an axis: a sphere, a spheroid, or one that :func:`averaged` gave.
    axes : dict, optional
        By the names of bodies which of their axes to begin with along the line between the bodies and along the angular
        momentum, such as ``{"Beta": "yz"}``. Unless given these are the axes of least and of greatest inertia.
    start : State, optional
        Begin with the poses of this state instead, the angular momentum of which becomes the z-axis.

    Returns
    -------
    RelativeEquilibrium
        Of an angular momentum that two separations have, the one with the larger separation, unless a start near the
        other one is given.

    Raises
    ------
    InvalidInput
    NotConverged
        Where no equilibrium is found, and at folds, where Newton's step is nearly singular.
    BodiesOverlap
        Where the bodies would overlap.

    Notes
    -----
    With m the reduced mass, Omega along z and pi_k = I_k omega_k it solves F = m Omega x (Omega x r) and
    M_k = Omega_k x pi_k for the separation, both attitudes and the rate; Omega_k is Omega in the frame of a body.

    Examples
    --------
    >>> import fullbody
    >>> system, _ = fullbody.systems.kw4()
    >>> equilibrium = fullbody.analysis.relative_equilibrium(system, separation=4.0)
    >>> equilibrium.linearly_stable, len(equilibrium.modes)
    (True, 7)
    """
    pair = Pair(system)
    condition = _condition(system, separation, angular_momentum, rate)
    if start is not None and axes is not None:
        raise InvalidInput("axes and start are both given; expected one of the two")
    given = _axes(pair, axes)
    if start is not None:
        pose = pose_of(pair, start, "start")[0]
    else:
        # The true separation is found below.
        pose = aligned(given, 2.0 * max(contact(pair, given), 1e-3))
    problem = _problem(pair, pose, spin)
    if start is None:
        pose = aligned(given, _distance(problem, given, condition))
    # Where gravity does not pull along the line, Kepler's rate is a beginning.
    kepler = np.sqrt(pair.strength / (pair.mass * pose.distance**3))
    guess = rotation_at(problem, pose) or problem.rotation(pose, kepler)
    return RelativeEquilibrium(problem, converged(problem, guess, condition))


def _condition(system: BaseSystem, separation: Any, angular_momentum: Any, rate: Any) -> Condition:
    values = {"separation": separation, "angular_momentum": angular_momentum, "rate": rate}
    given = {name: value for name, value in values.items() if value is not None}
    if len(given) != 1:
        names = ", ".join(given) or "none"
        raise InvalidInput(f"{names} given; expected one of separation, angular_momentum and rate")
    [(name, value)] = given.items()
    dimension = {"separation": "length", "angular_momentum": "angular momentum", "rate": "spin"}[name]
    plain = system._units.number(value, dimension, name)
    if plain <= 0.0:
        raise InvalidInput(f"{name} is {value!r}; expected a number above zero")
    kind: Kind = name  # type: ignore[assignment]
    return Condition(kind, plain)


def _axes(pair: Pair, axes: Mapping[str, Any] | None) -> Axes:
    """Axes along the line and the pole, from words such as "xz"."""
    found = list(long_axes(pair))
    for name, word in (axes or {}).items():
        body = pair.system._place(name, "a body of axes")
        letters = list(word) if isinstance(word, str | tuple | list) else []
        if len(letters) != 2 or not set(letters) <= set("xyz") or letters[0] == letters[1]:
            raise InvalidInput(f"axes of {name} is {word!r}; expected two of x, y and z, such as 'xz'")
        found[body] = ("xyz".index(letters[0]), "xyz".index(letters[1]))
    first, second = found
    return first, second


def _problem(pair: Pair, pose: Pose, spin: Mapping[str, Any] | None) -> Problem:
    """The problem of a pair with the bodies that are not locked."""
    axes = (pair.axis(0, pose), pair.axis(1, pose))
    if spin is not None and not isinstance(spin, Mapping):
        raise InvalidInput(f"spin is {spin!r}; expected spins by names of bodies, such as {{'Alpha': 2.3}}")
    spins = {}
    for name, value in (spin or {}).items():
        body = pair.system._place(name, "a body of spin")
        called = pair.system.names[body]
        if axes[body] is None:
            raise InvalidInput(
                f"spin has {called}, which has no axis of symmetry; expected bodies that look the same when they turn "
                f"(fullbody.analysis.averaged(system, {called!r}) is the mean over its turns, of copies= enough)"
            )
        spins[body] = pair.system._units.number(value, "spin", f"spin of {called}")
    return Problem(pair, axes, spins)


def _distance(problem: Problem, axes: Axes, condition: Condition) -> float:
    """A separation to begin with."""
    pair = problem.pair
    if condition.kind == "separation":
        return condition.value
    if condition.kind == "rate":
        return max(contact(pair, axes), float(np.cbrt(pair.strength / (pair.mass * condition.value**2))))
    found = scan(problem, axes, contact(pair, axes), condition.value)
    places = found.crossings(condition.value)
    if len(places) == 0:
        least = int(found.angular_momentum.argmin())
        attach = pair.system._units.attach
        raise NotConverged(
            f"no relative equilibrium of these axes has the angular momentum "
            f"{number(attach(np.float64(condition.value), 'angular momentum'))}; with the bodies apart the least is "
            f"about {number(attach(found.angular_momentum[least], 'angular momentum'), 5)}, at a separation of "
            f"{number(attach(found.separation[least], 'length'), 5)}"
        )
    return float(places[-1])


def pose_of(pair: Pair, state: State, what: str) -> tuple[Pose, Array]:
    """The pose of a state in axes with z along the angular momentum, and the matrix that turns vectors into them."""
    core = pair.system._strip(state)
    if len(core.position) != 2:
        raise InvalidInput(f"{what} has {len(core.position)} bodies; expected two")
    r = core.position[1] - core.position[0]
    v = core.velocity[1] - core.velocity[0]
    total = pair.mass * np.cross(r, v) + np.einsum("kij,kj->i", core.rotation_matrix, pair.inertia * core.spin)
    size = float(np.linalg.norm(total))
    if size == 0.0:
        raise InvalidInput(f"{what} has no angular momentum, which gives the axis that all turns about; expected some")
    z = total / size
    x = r - (r @ z) * z
    if np.linalg.norm(x) <= 1e-12 * np.linalg.norm(r):
        raise InvalidInput(f"{what} has its bodies along its angular momentum; expected them beside it")
    x /= np.linalg.norm(x)
    turn = np.array([x, np.cross(z, x), z])
    q = rotations.quaternion(turn)
    return Pose(turn @ r, np.array([rotations.product(q, own) for own in core.attitude])), turn


@named_options
def averaged(system: BaseSystem, body: int | str, *, copies: int = 12) -> BaseSystem:
    """The system with a body replaced by its mean over all turns about its z-axis.

    A primary that is not round and spins fast is to its locked companion nearly what its mean is, which has an axis of
    symmetry: with the mean there are relative equilibria. The mean is a composite of copies at equal angles, exact to
    the degree 2 copies - 1 of the series of its gravity.

    Parameters
    ----------
    system : System
    body : int or str
        A body that is an ellipsoid; its z-axis is the one it spins about.
    copies : int
        How many, 2 or more.

    Returns
    -------
    System

    Examples
    --------
    >>> import fullbody
    >>> system, _ = fullbody.systems.kw4()
    >>> len(fullbody.analysis.averaged(system, "Alpha")["Alpha"].shape.parts)
    12
    """
    if not isinstance(system, BaseSystem):
        raise InvalidInput(f"system is {system!r}; expected a System")
    index = system._place(body, "body")
    old = system.bodies[index]
    count = integer(copies)
    if count is None or count < 2:
        raise InvalidInput(f"copies is {copies!r}; expected a whole number, 2 or more")
    if not isinstance(old.shape, Ellipsoid | Sphere):
        raise InvalidInput(f"{system.names[index]} is {old.shape!r}; expected an Ellipsoid")
    if isinstance(old.shape, Sphere) or old.shape.a == old.shape.b:
        return system
    parts = [
        Part(old.shape, mass=old.mass / count, attitude=rotations.turn(2, np.pi * k / count)) for k in range(count)
    ]
    bodies = list(system.bodies)
    bodies[index] = Body(Composite(parts), name=old.name)
    options = {**system.options, "forces": system.forces}
    return type(system)(bodies, system.G, units=system.units, **options)
