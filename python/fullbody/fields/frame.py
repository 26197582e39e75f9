"""The rotating frame of a pair of bodies, its equilibrium points, and the Roche lobes, which the inner point bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.kinds import whole_number
from ..base.units import Units, need
from ..base.values import ArrayFields
from ..errors import InvalidInput, caution
from ..model.context import Context
from ..model.failures import explaining
from ..model.gravity import Gravity, gravity_at
from ..model.polyhedron import Polyhedron
from ..typing import Array, Floats, Scalar

#: Relative rates of change of accelerations or figures above which these are not at rest in the frame.
_STEADY = 1e-3
#: Real parts of eigenvalues that count as zero, in units of the rate.
_NEUTRAL = 1e-6
#: The distance, in separations, below which two points are the same.
_SAME = 1e-6
#: The number of steps in which a ray searches for the surface, and of halvings of the last one.
_STEPS, _HALVINGS = 200, 50


class Frame:
    """The frame that rotates with a pair of bodies, in numbers of the units of its system.

    It has an angular velocity, the ``rate``, and the ``distance`` between the bodies' centres, which are at ``centres``
    (2, 3) in it; ``origin`` and ``drift`` (3,) are position and velocity of the barycentre, inertial. The matrices
    ``rotation`` (3, 3) and ``attitudes`` (2, 3, 3) lead from the rotating frame and from the body frames to the
    inertial frame, and ``primary`` is the index of the heavier body.
    """

    def __init__(self, context: Context, core: _core.State) -> None:
        if len(context) != 2:
            raise InvalidInput(f"system has {len(context)} bodies; expected 2")
        self.context, masses = context, context.masses
        self.primary = int(masses[1] > masses[0])
        heavy, light = self.primary, 1 - self.primary
        fractions = masses / masses.sum()
        self.origin, self.drift = fractions @ core.position, fractions @ core.velocity
        r, v = (vectors[light] - vectors[heavy] for vectors in (core.position, core.velocity))
        h = np.cross(r, v)
        self.distance = float(np.linalg.norm(r))
        if not np.linalg.norm(h) > 1e-12 * self.distance * np.linalg.norm(v):
            raise InvalidInput("the bodies move along a line; expected bodies that orbit each other")
        self.rate = float(np.linalg.norm(h) / self.distance**2)
        x, z = r / self.distance, h / np.linalg.norm(h)
        self.rotation = np.stack([x, np.cross(z, x), z], axis=1)
        self._poses, self.attitudes = (core.position[None], core.attitude[None]), core.rotation_matrix
        self.centres = (core.position - self.origin) @ self.rotation
        self._warn_if_moving(core)

    def _warn_if_moving(self, core: _core.State) -> None:
        """Warn if the pair is not at rest in the frame."""
        with explaining(self.context, core):
            force = self.context.core.interactions(core)[0]
        centripetal = -self.context.masses[:, None] * self.rate**2 * (self.centres * [1.0, 1.0, 0.0]) @ self.rotation.T
        imbalance = float(np.abs(force - centripetal).max() / np.abs(centripetal).max())
        velocity = core.velocity[1] - core.velocity[0]
        radial = float(abs(velocity @ self.rotation[:, 0]) / np.linalg.norm(velocity))
        rates = {
            f"their gravity differs by {imbalance:.2g} from the force that keeps them at rest in it": imbalance,
            f"they approach or recede at {radial:.2g} of their speed": radial,
        }
        large = ", and ".join(text for text, rate in rates.items() if rate > _STEADY)
        deviations = [f"the bodies are not on a circular orbit ({large})"] if large else []
        for k, (rotation, name) in enumerate(zip(core.rotation_matrix, self.context.names, strict=True)):
            spin, inertia = core.spin[k], rotation @ np.diag(self.context.bodies[k].inertia) @ rotation.T
            cross = np.cross(np.eye(3), rotation @ spin - self.rate * self.rotation[:, 2])
            change = float(np.abs(inertia @ cross - cross @ inertia).max())
            if change > _STEADY * self.rate * float(np.abs(inertia).max()):
                deviations.append(f"{name} rotates in the frame, and its figure with it")
        if deviations:
            caution(f"{'; '.join(deviations)}: the rotating frame and the field in it are those of the state's time")

    def jacobi(self, x: Floats) -> Floats:
        """Return Jacobi's constant at rest at points (..., 3) of the frame."""
        return 2.0 * self.gravity(x).potential + self.rate**2 * (x[..., 0] ** 2 + x[..., 1] ** 2)

    def gravity(self, x: Floats) -> Gravity:
        """Return gravity as numbers, at points of the frame and along inertial axes."""
        return gravity_at(self.context.attraction, *self._poses, self.origin + x @ self.rotation.T, Units())

    def acceleration_and_gradient(self, x: Floats) -> tuple[Floats, Floats]:
        """Return half the gradient of C, which is the acceleration at rest in the frame, and its derivatives."""
        gravity = self.gravity(x)
        outward = self.rate**2 * np.array([1.0, 1.0, 0.0])
        return (
            gravity.field @ self.rotation + outward * x,
            self.rotation.T @ gravity.gradient @ self.rotation + np.diag(outward),
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Equilibrium(ArrayFields):
    """A point where a particle can rest in the rotating frame.

    Attributes
    ----------
    name : str
        ``"L1"`` to ``"L5"``: between the bodies, behind the lighter one, behind the heavier one, 60 degrees before and
        behind the lighter one. Further points, which two point masses do not have, are ``"E6"`` and so on.
    position : ndarray or Quantity, (3,)
        Position in the rotating frame.
    jacobi : float or Quantity
        Jacobi's constant at the point.
    eigenvalues : ndarray or Quantity, (6,)
        Complex eigenvalues of the linear motion about the point, per unit of time.
    stable : bool
        Whether no eigenvalue has a positive real part.
    """

    name: str
    position: Array
    jacobi: Scalar
    eigenvalues: Any
    stable: bool


def equilibria(pair: Any) -> list[Equilibrium]:
    """Find the points outside of the bodies where a particle can rest, and the linear motion about them.

    Newton's method starts from the points of two point masses and from a grid about the bodies. It needs scipy.
    """
    frame = pair.frame
    points: list[tuple[str, Floats]] = []
    # The grid is in separations, too.
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    grid = [r * np.array([np.cos(a), np.sin(a), 0.0]) for r in (0.4, 0.7, 1.1) for a in angles]
    for name, seed in [*_of_points(frame), *(("", seed) for seed in grid)]:
        x = _root(frame, seed)
        if x is None or any(np.linalg.norm(x - other) < _SAME for _, other in points):
            continue
        # The extent of the bodies may remove a classical point; the search then finds another point.
        classical = name and np.linalg.norm(x - seed) < 0.3
        points.append((name if classical else f"E{6 + sum(other[0] == 'E' for other, _ in points)}", x))
    return [_described(frame, name, x * frame.distance) for name, x in points]


def _of_points(frame: Frame) -> list[tuple[str, Floats]]:
    """Return the equilibrium points of two point masses, in units of the separation."""
    with need("analysis", "an equilibrium point"):
        from scipy.optimize import brentq

    light = float(frame.context.masses[1 - frame.primary] / frame.context.masses.sum())

    def acceleration(x: float) -> float:
        from_heavy, from_light = x + light, x - 1.0 + light
        return x - (1.0 - light) * from_heavy / abs(from_heavy) ** 3 - light * from_light / abs(from_light) ** 3

    gap = 1e-9
    spans = ((gap - light, 1.0 - light - gap), (1.0 - light + gap, 2.5), (-2.5, -light - gap))
    collinear = [np.array([brentq(acceleration, *span, xtol=1e-15), 0.0, 0.0]) for span in spans]
    triangular = [np.array([0.5 - light, sign * np.sqrt(0.75), 0.0]) for sign in (1.0, -1.0)]
    return list(zip(("L1", "L2", "L3", "L4", "L5"), [*collinear, *triangular], strict=True))


def _root(frame: Frame, seed: Floats) -> Floats | None:
    """Return the equilibrium point, in separations, that Newton's method finds outside of the bodies, or ``None``."""
    with need("analysis", "an equilibrium point"):
        from scipy.optimize import root

    scale = frame.rate**2

    def equations(x: Floats) -> tuple[Floats, Floats]:
        acceleration, jacobian = frame.acceleration_and_gradient(x * frame.distance)
        return acceleration / (scale * frame.distance), jacobian / scale

    x: Floats = root(equations, seed, jac=True, options={"xtol": 1e-14}).x
    value, jacobian = equations(x)
    x = x - np.linalg.solve(jacobian, value)
    # The remaining acceleration is round-off of the gravity of the nearest body.
    if not np.abs(equations(x)[0]).max() < 1e-11 * np.abs(jacobian).max() or np.abs(x).max() > 3.0:
        return None
    # Within a body gravity has a source.
    return None if np.trace(frame.gravity(x * frame.distance).gradient) < -0.01 * scale else x


def _described(frame: Frame, name: str, x: Floats) -> Equilibrium:
    """Describe a point by its eigenvalues: x'' = W x + 2 Omega (y', -x', 0), W the derivatives of the acceleration."""
    coriolis = 2.0 * frame.rate * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    _, gradient = frame.acceleration_and_gradient(x)
    eigenvalues: Any = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [gradient, coriolis]]))
    attach, stable = frame.context.units.attach, bool(eigenvalues.real.max() < _NEUTRAL * frame.rate)
    jacobi = attach(frame.jacobi(x)[()], "potential")
    return Equilibrium(name, attach(x, "length"), jacobi, attach(eigenvalues, "spin"), stable)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RocheLobe(ArrayFields):
    """The Roche lobe of a body: it holds matter at rest in the rotating frame inside this surface.

    Attributes
    ----------
    name : str
        Name of the body.
    jacobi : float or Quantity
        Jacobi's constant on the surface: that of the equilibrium point between the bodies.
    points : ndarray or Quantity, (rows + 1, 2 rows + 1, 3)
        Points of the surface in the rotating frame: rows from the end at that equilibrium point to the opposite one,
        columns about the axis, with the last equal to the first.
    volume : float or Quantity
        Volume of the mesh through the points, which is smaller than the lobe by about 3.7 parts in ``rows**2``.
    radius : float or Quantity
        Radius of the sphere with that volume.
    """

    name: str
    jacobi: Scalar
    points: Array
    volume: Scalar
    radius: Scalar


def roche_lobe(pair: Any, body: int | str, *, rows: int = 90) -> RocheLobe:
    """Return the surface of a body's Roche lobe, which has the Jacobi constant of the point between the bodies.

    Parameters
    ----------
    body : int or str
        The body's index in the system, or its name.
    rows : int
        Number of rows of the mesh from end to end.
    """
    frame, rows, index = pair.frame, whole_number(rows, "rows", 4), pair.frame.context.index(body, "body")
    inner = _root(frame, _of_points(frame)[0][1])
    if inner is None:
        names = " and ".join(frame.context.names)
        raise InvalidInput(f"there is no equilibrium point between {names}: they have no lobes")
    units = frame.context.units
    centre, tip = frame.centres[index], inner * frame.distance - frame.centres[index]
    level = float(frame.jacobi(inner * frame.distance))
    tip_distance = float(np.linalg.norm(tip))
    axis = tip / tip_distance
    normal = np.array([-axis[1], axis[0], 0.0])
    polar, angle = np.meshgrid(np.pi * np.arange(1, rows) / rows, np.pi * np.arange(2 * rows) / rows, indexing="ij")
    ring = np.cos(angle)[..., None] * normal + np.sin(angle)[..., None] * np.cross(axis, normal)
    rays = np.cos(polar)[..., None] * axis + np.sin(polar)[..., None] * ring
    rays = np.concatenate([np.stack([axis, -axis]), rays.reshape(-1, 3)])
    distance = _crossings(frame, centre, rays, level, tip_distance)
    # The surface ends at the point in a cone, where a ray finds no crossing.
    distance[0] = tip_distance
    flat = centre + distance[:, None] * rays
    first, last = (np.broadcast_to(end, (1, 2 * rows, 3)) for end in flat[:2])
    points = np.concatenate([first, flat[2:].reshape(rows - 1, 2 * rows, 3), last])
    volume = Polyhedron(flat, _faces(rows)).volume
    return RocheLobe(
        frame.context.names[index],
        units.attach(np.float64(level), "potential"),
        units.attach(np.concatenate([points, points[:, :1]], axis=1), "length"),
        units.attach(volume, "volume"),
        units.attach((volume * 3.0 / (4.0 * np.pi)) ** (1.0 / 3.0), "length"),
    )


def _crossings(frame: Frame, centre: Floats, rays: Floats, level: float, tip_distance: float) -> Floats:
    """Return the distance on each ray where Jacobi's constant first falls below the level, or else that of the tip."""
    low, high = np.zeros(len(rays)), np.full(len(rays), tip_distance)
    outward = np.arange(len(rays))
    for distance in tip_distance * np.linspace(0.0, 1.0, _STEPS + 1)[1:]:
        below = frame.jacobi(centre + distance * rays[outward]) < level
        high[outward[below]] = distance
        outward = outward[~below]
        low[outward] = distance
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = frame.jacobi(centre + middle[:, None] * rays) < level
        low, high = np.where(below, low, middle), np.where(below, middle, high)
    return high


def _faces(rows: int) -> npt.NDArray[np.int64]:
    """Return triangles between two ends, the first vertices, and rings of points between them."""
    count = 2 * rows
    column = np.arange(count)
    following = (column + 1) % count
    rings = 2 + count * np.arange(rows - 1)[:, None]
    first = np.stack([np.zeros_like(column), rings[0] + column, rings[0] + following], axis=1)
    last = np.stack([np.ones_like(column), rings[-1] + following, rings[-1] + column], axis=1)
    a, b, c, d = rings[:-1] + column, rings[:-1] + following, rings[1:] + column, rings[1:] + following
    between = [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, c, b), (b, c, d))]
    return np.concatenate([first, *between, last])
