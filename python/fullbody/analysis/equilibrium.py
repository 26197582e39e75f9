"""Relative equilibria of a pair: motions at rest in a frame that rotates uniformly."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ..base import rotations
from ..base.attributes import WithUnit
from ..base.kinds import instance, whole_number
from ..base.limits import POSITIVE
from ..base.tables import Table, Tabled, facts, number, tables_of
from ..base.units import without_unit
from ..errors import InvalidInput, NotConverged
from ..model.composite import Composite, Part
from ..model.shapes import Ellipsoid, Sphere
from ..model.state import State
from ..motion.system import System
from ..typing import Floats, Scalar
from ._newton import Axes, aligned, contact, converged, long_axes, scan
from ._pair import Pair, PairPoint, Pose
from ._rotation import Kind, Rotation
from .modes import Modes, modes_of

#: Curvatures below this belong to directions in which the system does not change.
_FLAT = 1e-10
_DIMENSIONS: dict[Kind, str] = {"separation": "length", "angular_momentum": "angular momentum", "rate": "spin"}


class UniformRotation(Tabled):
    """A pair that rotates uniformly as one: the common part of equilibria and of bodies in contact."""

    def __init__(self, rotation: Rotation) -> None:
        self.rotation = rotation
        self.system: System = rotation.pair.system
        self.state: State = rotation.point.state

    separation = WithUnit[Scalar]("Distance between the centres.", "rotation.pose.distance", "length")
    rate = WithUnit[Scalar]("Rate Omega of the rotation, in radians per unit of time.", "rotation.rate", "spin")
    energy = WithUnit[Scalar]("Total energy with the barycentre at rest.", "rotation.point.energy", "energy")


class RelativeEquilibrium(UniformRotation):
    """Two bodies that rotate as one about their barycentre, made by :func:`relative_equilibrium` and others.

    Bodies that are not locked have, in addition, a steady spin about their axis of symmetry.

    Attributes
    ----------
    system : System
    state : State
        The state with the barycentre at rest in the origin, the angular momentum along z, and the second body in the
        half plane of the positive x-axis as seen from the first.
    """

    def __init__(self, rotation: Rotation) -> None:
        # The frame's x-axis runs through the projection of the separation.
        x, y, z = rotation.pose.r
        to_frame = rotations.about_axis(2, -np.arctan2(y, x))
        pose = Pose(np.array([np.hypot(x, y), 0.0, z]), rotations.products(to_frame, rotation.pose.attitude))
        super().__init__(rotation.at(pose, rotation.rate))

    period = WithUnit[Scalar](
        "Period of the rotation, 2 pi divided by the rate.", lambda owner: 2 * np.pi / owner.rotation.rate, "time"
    )
    angular_momentum = WithUnit[Scalar](
        "Total angular momentum about the barycentre, which is along z.",
        lambda owner: owner.rotation.quantity("angular_momentum"),
        "angular momentum",
    )

    @property
    def locked(self) -> tuple[str, ...]:
        """Names of the locked bodies, which always show the other body the same face."""
        return tuple(name for k, name in enumerate(self.system.names) if k not in self.rotation.spin)

    @cached_property
    def residual(self) -> float:
        """The largest residual of the balance: forces relative to G m m / r^2, torques relative to G m m / r."""
        rows, _ = self.rotation.scales()
        return float(np.abs(self.rotation.residual() / rows).max())

    @cached_property
    def modes(self) -> Modes:
        """Normal modes of small motions about the equilibrium."""
        return modes_of(self.rotation)

    @property
    def linearly_stable(self) -> bool:
        """Whether the equilibrium is linearly stable: no mode grows."""
        return not (without_unit(self.modes.growth) > 0.0).any()

    @cached_property
    def curvatures(self) -> Floats:
        """Eigenvalues (D,) of the Hessian of the amended potential, ascending.

        The variables are the separation in units of its length r, and rotation vectors of the bodies times
        sqrt(I / (m r^2)), with I the largest moment of inertia and m the reduced mass, without the symmetries; the unit
        of energy is G m_0 m_1 / r.
        """
        return self.rotation.amended_hessian()[0]

    @property
    def energetically_stable(self) -> bool:
        """Whether the energy has a minimum here among all states of this angular momentum: all curvatures are positive.

        If so, neither other conservative motions nor a slow loss of energy in locked bodies carry the pair away; bodies
        that are not locked keep their angular momentum about their axes.
        """
        return bool(np.all(np.asarray(self.curvatures) > _FLAT))

    def _free(self) -> dict[str, Scalar]:
        """Return the spins of the bodies that are not locked, by their names."""
        attach, names = self.system.context.units.attach, self.system.names
        return {names[body]: attach(spin, "spin") for body, spin in sorted(self.rotation.spin.items())}

    def _tables(self) -> tuple[Table, ...]:
        rows = facts(self, "separation", "rate", "period", "angular_momentum", "energy")
        rows.append(("locked", ", ".join(self.locked) or "neither body"))
        rows += [(f"spin of {name}", number(spin)) for name, spin in self._free().items()]
        rows.append(("linearly stable", "yes" if self.linearly_stable else "no"))
        rows.append(("minimum of energy", "yes" if self.energetically_stable else "no"))
        return (Table("Relative equilibrium", (), rows), *tables_of(self.modes))

    def __repr__(self) -> str:
        free = "".join(f", {name} spinning at {number(spin, 6)}" for name, spin in self._free().items())
        stable = "linearly stable" if self.linearly_stable else "unstable"
        stable = "a minimum of energy" if self.energetically_stable else f"{stable}, no minimum of energy"
        locked = " and ".join(self.locked) or "neither body"
        sizes = f"separation={number(self.separation)}, period={number(self.period)}"
        return f"RelativeEquilibrium({sizes}, {locked} locked{free}; {stable})"


def relative_equilibrium(
    system: System,
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
        Two bodies without external forces.
    separation, angular_momentum, rate : float or Quantity
        The value that the equilibrium has to have; exactly one of the three is given: the distance between the centres,
        the total angular momentum, or the rate at which the pair rotates.
    spin : dict, optional
        Spins of bodies about their axes of symmetry, by the names of the bodies that are not locked. Such a body is a
        sphere, a spheroid, or one that :func:`averaged` gave.
    axes : dict, optional
        The initial axes of bodies by their names: the body axis along the line between the bodies, and the one along
        the angular momentum, such as ``{"Beta": "yz"}``; by default those of least and of greatest inertia.
    start : State, optional
        A state whose poses are the initial guess instead; its angular momentum becomes the z-axis.

    Returns
    -------
    RelativeEquilibrium
        If two separations have the angular momentum, it is the one with the larger separation, unless a start near the
        other one is given.

    Raises
    ------
    NotConverged
        If no equilibrium is found, and at folds, where Newton's step is nearly singular.
    BodiesOverlap
        If the bodies would overlap.

    Notes
    -----
    With m the reduced mass, Omega along z and pi_k = I_k omega_k the method solves F = m Omega x (Omega x r) and M_k =
    Omega_k x pi_k for the separation, both attitudes and the rate; Omega_k is Omega in the frame of a body.

    Examples
    --------
    >>> import fullbody
    >>> system, _ = fullbody.systems.kw4()
    >>> equilibrium = fullbody.analysis.relative_equilibrium(system, separation=4.0)
    >>> equilibrium.linearly_stable, len(equilibrium.modes)
    (True, 7)
    """
    pair = Pair(system)
    targets: dict[Kind, Any] = {"separation": separation, "angular_momentum": angular_momentum, "rate": rate}
    targets = {kind: value for kind, value in targets.items() if value is not None}
    if len(targets) != 1:
        names = ", ".join(targets) or "none"
        raise InvalidInput(f"{names} given; expected one of separation, angular_momentum and rate")
    [(kind, quantity)] = targets.items()
    value = system.context.units.number(quantity, _DIMENSIONS[kind], kind, POSITIVE)
    if start is not None and axes is not None:
        raise InvalidInput("axes and start are both given; expected one of the two")
    body_axes = _axes(pair, axes)
    if start is not None:
        pose = upright(pair, start, "start").pose
    else:
        # This separation is a placeholder; the first guess for it is computed below.
        pose = aligned(body_axes, 2.0 * max(contact(pair, body_axes), 1e-3))
    guess = _guess(pair, pose, spin)
    if start is None:
        pose = aligned(body_axes, _distance(guess, body_axes, kind, value))
    # Kepler's rate is the first guess where gravity repels along the line.
    guess = guess.balanced(pose) or guess.at(pose, pair.orbital_rate(pose.distance))
    return RelativeEquilibrium(converged(guess, kind, value))


def _axes(pair: Pair, axes: Mapping[str, Any] | None) -> Axes:
    """Parse the axes along the line and the pole from words such as "xz"."""
    axes_of_bodies = list(long_axes(pair))
    for name, word in (axes or {}).items():
        body = pair.context.index(name, "a body of axes")
        letters = list(word) if isinstance(word, str | tuple | list) else []
        if len(letters) != 2 or not set(letters) <= set("xyz") or letters[0] == letters[1]:
            raise InvalidInput(f"axes of {name} is {word!r}; expected two of x, y and z, such as 'xz'")
        axes_of_bodies[body] = ("xyz".index(letters[0]), "xyz".index(letters[1]))
    return axes_of_bodies[0], axes_of_bodies[1]


def _guess(pair: Pair, pose: Pose, spin: Mapping[str, Any] | None) -> Rotation:
    """Return a pose at the rate zero, with the spins of the bodies that are not locked."""
    axes = pair.axes(pose)
    if spin is not None:
        instance(spin, "spin", Mapping, "spins by names of bodies, such as {'Alpha': 2.3}")
    spins = {}
    for name, value in (spin or {}).items():
        body = pair.context.index(name, "a body of spin")
        name = pair.system.names[body]
        if axes[body] is None:
            raise InvalidInput(
                f"spin has {name}, which has no axis of symmetry; expected a body that has one, such as its mean over "
                f"all rotations, fullbody.analysis.averaged(system, {name!r}), of enough copies="
            )
        spins[body] = pair.context.units.number(value, "spin", f"spin of {name}")
    return Rotation(pair, pose, 0.0, axes, spins)


def _distance(guess: Rotation, axes: Axes, kind: Kind, value: float) -> float:
    """Return the first guess for the separation."""
    pair = guess.pair
    if kind == "separation":
        return value
    if kind == "rate":
        return max(contact(pair, axes), float(np.cbrt(pair.strength / (pair.mass * value**2))))
    scanned = scan(guess, axes, contact(pair, axes), value)
    crossings = scanned.crossings(value)
    if len(crossings) == 0:
        least = int(scanned.angular_momentum.argmin())
        text = pair.context.units.text
        raise NotConverged(
            f"no relative equilibrium of these axes has the angular momentum {text(value, 'angular momentum')}; with "
            f"the bodies apart the least is about {text(scanned.angular_momentum[least], 'angular momentum', 5)}, at a "
            f"separation of {text(scanned.separation[least], 'length', 5)}"
        )
    return float(crossings[-1])


def upright(pair: Pair, state: State, what: str) -> PairPoint:
    """Return a state of a pair in axes with z along the angular momentum and the second body beside the first on x."""
    point = PairPoint.of(pair, state, what)
    r, total = point.pose.r, point.angular_momentum
    size = float(np.linalg.norm(total))
    if size == 0.0:
        raise InvalidInput(f"{what} has no angular momentum; expected one, whose direction is the axis of rotation")
    z = total / size
    x = r - (r @ z) * z
    if np.linalg.norm(x) <= 1e-12 * np.linalg.norm(r):
        raise InvalidInput(f"{what} has its bodies along its angular momentum; expected them in another direction")
    x /= np.linalg.norm(x)
    return point.rotated(rotations.quaternion([x, np.cross(z, x), z]))


def averaged(system: System, body: int | str, *, copies: int = 12) -> System:
    """Replace a body of a system by its mean over all rotations about its z-axis.

    The gravity of a fast primary that is not round acts on its locked companion almost as this mean does. The mean has
    an axis of symmetry, so that relative equilibria exist. It is a composite of copies at equal angles, exact to the
    degree 2 copies - 1 of the series of its gravity.

    Parameters
    ----------
    system : System
    body : int or str
        A body that is an ellipsoid and spins about its z-axis.
    copies : int
        Two or more.

    Examples
    --------
    >>> import fullbody
    >>> system, _ = fullbody.systems.kw4()
    >>> len(fullbody.analysis.averaged(system, "Alpha")["Alpha"].shape.parts)
    12
    """
    instance(system, "system", System)
    index = system.context.index(body, "body")
    old = system.bodies[index]
    count = whole_number(copies, "copies", 2)
    shape = instance(old.shape, system.names[index], Ellipsoid | Sphere, "an Ellipsoid")
    if isinstance(shape, Sphere) or shape.a == shape.b:
        return system
    mass, step = old.mass / count, np.pi / count
    parts = [Part(shape, mass=mass, attitude=rotations.about_axis(2, k * step)) for k in range(count)]
    return system.with_body(index, Composite(parts))
