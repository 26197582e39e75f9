"""The system and the state that a setup has made, and the differences between two of them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from ..base import rotations
from ..model.bodies import Body
from ..model.description import functions
from ..model.freeform import ConvexShape
from ..model.shapes import PointMass
from ..model.state import State, strip
from ..model.stokes import harmonics_of
from ..model.surface import Surface, surface_of
from ..motion.system import System
from ..typing import Floats

#: The relative rounding error of numbers.
ROUNDING = 1e-13
#: The part of a body's gravity, in units of that of a point, that its coefficients leave out, and the largest ratio of
#: the radius of a deformed body to the distance of another one.
_TRUNCATION, _NEAR = 1e-7, 0.8
#: The radius to which the coefficients of a body refer, over that of the sphere around it.
_REFERENCE_RADIUS = 1.2


class Gravity(NamedTuple):
    """The degree of a body's Stokes coefficients, and the radius of the sphere to which they refer."""

    degree: int
    radius: float


class SetupResult:
    """A system and a state that a setup has made."""

    def __init__(self, system: System, state: State) -> None:
        self.system, self.state = system, state

    def __reduce__(self) -> Any:
        return (SetupResult, (self.system, self.state))

    @cached_property
    def core(self) -> Any:
        """The state as the core has it, in numbers of the system's units."""
        return strip(self.state, self.system.context)

    @cached_property
    def parameters(self) -> dict[str, float]:
        """The values of the system's parameters by their names."""
        return self.system.context.core.parameter_values

    @cached_property
    def settings(self) -> dict[str, Any]:
        """Units, settings and functions of the system, which no parameter of the system changes, by their names."""
        context = self.system.context
        return {
            **{f"notes {name}": context.notes[name] for name in ("units", "epoch", "frame")},
            **{f"settings {name}": value for name, value in context.core.settings.items()},
            **{f"the function of the force {force.name}": force for force in functions(self.system).values()},
        }

    @cached_property
    def surfaces(self) -> list[Surface | None]:
        """The surfaces of the bodies, ``None`` for those that are neither polyhedra nor convex shapes."""
        return [surface_of(body) for body in self.system.context.bodies]

    def deformed(self, other: SetupResult) -> list[int]:
        """Return the indices of the bodies whose surface has changed in another way than by a factor."""
        pairs = zip(self.system.bodies, other.system.bodies, self.surfaces, other.surfaces, strict=False)
        return [k for k, (body, changed, old, new) in enumerate(pairs) if _is_deformed(body, changed, old, new)]

    def equivalent(self, bodies: Mapping[int, Gravity]) -> SetupResult:
        """Return the result with other shapes, which move in the same way, of bodies by their index.

        A polyhedron becomes the Stokes coefficients of its gravity, and a convex shape a point.
        """
        system, context = self.system, self.system.context
        for index, (degree, radius) in bodies.items():
            if isinstance(system.bodies[index].shape, ConvexShape):
                shape: Any = PointMass()
            else:
                shape = harmonics_of(context.bodies[index], degree, context.units, radius)
            system = system.with_body(index, shape, mass=context.units.attach(context.masses[index], "mass"))
        return SetupResult(system, self.state)

    def gravity(self, index: int) -> Gravity | None:
        """Return the gravity of a body by which the others move; ``None`` if they are too near."""
        position, degree = self.core.position, 2
        bodies = zip(self.system.context.bodies, self.surfaces, strict=True)
        radii = [max(body.semi_axes) if surface is None else _radius(surface) for body, surface in bodies]
        for other, radius in enumerate(radii):
            if other != index:
                distance = float(np.linalg.norm(position[other] - position[index])) - radius
                ratio = radii[index] / max(distance, 1e-300)
                if ratio > _NEAR:
                    return None
                degree = max(degree, int(np.ceil(np.log(_TRUNCATION) / np.log(ratio))) - 1)
        return Gravity(degree, _REFERENCE_RADIUS * radii[index])

    def displacement(self, other: SetupResult) -> Floats:
        """Return the tangent vector from this state to another one with as many bodies, and the change of time.

        The array has the shape (12 N + 1,).
        """
        parts = [
            other.core.position - self.core.position,
            other.core.velocity - self.core.velocity,
            rotations.between(self.core.attitude, other.core.attitude),
            other.core.spin - self.core.spin,
        ]
        return np.append(np.stack(parts, axis=1).ravel(), other.core.time - self.core.time)

    def sizes(self) -> Floats:
        """Return sizes (12 N + 1,) of the components of the start, to which their rounding errors are relative."""
        core = self.core
        largest = [np.abs(core.position).max(), np.abs(core.velocity).max(), 1.0, np.abs(core.spin).max()]
        return np.append(np.tile(np.repeat(largest, 3), len(core.position)), abs(core.time))

    def changes(self, other: SetupResult) -> tuple[Floats, str | None]:
        """Return the changes (P,) of the parameters to another system, and what of it they leave unexplained."""
        changed, unexplained = self.system.context.core.parameter_changes(other.system.context.core)
        if unexplained is None:
            names = (*self.settings, *other.settings)
            differing = (name for name in names if self.settings.get(name, ...) != other.settings.get(name, ...))
            unexplained = next(differing, None)
        return np.array([changed.get(name, 0.0) for name in self.parameters]), unexplained


def _is_deformed(body: Body, other: Body, old: Surface | None, new: Surface | None) -> bool:
    if old is None or new is None or [part.shape for part in old] != [part.shape for part in new]:
        return False
    if len(old.areas):
        return bool((np.abs(new.areas - old.areas) > ROUNDING * old.areas.max()).any())
    if not np.array_equal(cast(Any, body.shape).faces, cast(Any, other.shape).faces):
        return False
    factor = _radius(new) / _radius(old)
    return bool((np.abs(new.working - factor * old.working) > ROUNDING * np.abs(new.working).max()).any())


def _radius(surface: Surface) -> float:
    """Return the radius of the sphere around a polyhedron."""
    return float(np.sqrt(np.max(np.sum(surface.vertices**2, axis=1), initial=0.0)))
