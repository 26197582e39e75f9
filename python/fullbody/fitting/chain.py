"""Derivatives of what a setup returns, the start and the system's parameters, with respect to those of a fit.

A setup integrates nothing, so that its derivatives are computed by differences: those of the state, and of the
parameters that lead from one system to another. Motions cannot be differentiated with respect to a change that no
parameter of the system makes.

The surface of a polyhedron may change in any way, as that of a :class:`fullbody.HarmonicShape` does. Its vertices are
then differenced too, and the motion depends on them by the moments of inertia and the gravity coefficients alone: it is
differentiated for an equivalent system, in which the body has :class:`fullbody.StokesCoefficients` of a degree beyond
which its gravity does not count at the distance of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from ..base import rotations
from ..base.differences import Differences
from ..errors import InvalidInput
from ..model.bodies import Body
from ..model.description import functions
from ..model.freeform import ConvexShape
from ..model.shapes import PointMass
from ..model.state import State, strip
from ..model.stokes import harmonics_of
from ..model.surface import Deformation, Surface, surface_of
from ..motion.system import System
from ..typing import Floats
from .free import Parameters

#: The relative rounding error of numbers.
_ROUNDING = 1e-13
#: The part of a body's gravity, in units of that of a point, that its coefficients leave out, and the largest ratio of
#: the radius of a deformed body to the distance of another one.
_TRUNCATION, _NEAR = 1e-7, 0.8
#: The radius to which the coefficients of a body refer, over that of the sphere around it.
_ROOM = 1.2


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
    def rest(self) -> dict[str, Any]:
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
        both = zip(self.system.bodies, other.system.bodies, self.surfaces, other.surfaces, strict=False)
        return [k for k, (body, one, old, new) in enumerate(both) if old and new and _is_deformed(body, one, old, new)]

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
            mass = context.units.attach(context.masses[index], "mass")
            system = system.with_body(index, shape, mass=mass)
        return SetupResult(system, self.state)

    def gravity(self, index: int) -> Gravity | None:
        """Return the gravity of a body by which the others move; ``None`` if they are too near."""
        bodies, position, degree = self.system.context.bodies, self.core.position, 2
        reach = [max(body.semi_axes) if (s := surface_of(body)) is None else _reach(s) for body in bodies]
        for other, radius in enumerate(reach):
            if other != index:
                apart = float(np.linalg.norm(position[other] - position[index])) - radius
                ratio = reach[index] / max(apart, 1e-300)
                if ratio > _NEAR:
                    return None
                degree = max(degree, int(np.ceil(np.log(_TRUNCATION) / np.log(ratio))) - 1)
        return Gravity(degree, _ROOM * reach[index])

    def moved(self, other: SetupResult) -> Floats:
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
            paths = (*self.rest, *other.rest)
            differing = (path for path in paths if self.rest.get(path, ...) != other.rest.get(path, ...))
            unexplained = next(differing, None)
        return np.array([changed.get(name, 0.0) for name in self.parameters]), unexplained


@dataclass
class SetupDerivatives:
    """Derivatives of the system and state of a setup with respect to P parameters.

    Those of the ``start`` (12 N, P) are tangent vectors at the time of the start, those of the ``system`` are (P,) for
    each of its parameters that change; ``undifferentiable`` has the parameters that change something by which motions
    cannot be differentiated, with what that is. ``deformations`` has the displacements of surfaces by the names of the
    parameters that deform them; the parameters of the ``system`` are then those of the ``equivalent`` one.
    """

    start: Floats
    system: dict[str, Floats]
    undifferentiable: dict[str, str]
    deformations: dict[str, Deformation]
    equivalent: SetupResult


class _NewDeformation(Exception):
    """A body is deformed of which that was not yet known."""


class Chain:
    """The derivatives of a setup, wherever they are computed in a fit; the steps of differences are kept.

    The function ``make`` takes values (P,) and returns the :class:`SetupResult` of the setup.
    """

    def __init__(self, make: Callable[[Floats], SetupResult], parameters: Parameters) -> None:
        self._make, self._parameters = make, parameters
        self.differences = [Differences() for _ in parameters.names]
        #: The bodies that parameters deform, with their gravity.
        self._deforming: dict[int, Gravity | None] = {}

    def at(self, base: SetupResult, values: Floats) -> SetupDerivatives:
        """Differentiate at values (P,), for which the setup returns ``base``, or raise an error where it is not
        smooth.
        """
        # A body may have grown since the last time.
        self._deforming = {index: base.gravity(index) for index in self._deforming}
        while True:
            try:
                return self._at(base, values)
            except _NewDeformation:
                continue

    def _at(self, base: SetupResult, values: Floats) -> SetupDerivatives:
        tangent = len(base.core.position) * 12
        self._deforming = {index: base.gravity(index) for index in self._deforming}
        equivalent = base.equivalent(self._gravities())
        surfaces = {index: surface for index in self._gravities() if (surface := base.surfaces[index]) is not None}
        ends = np.cumsum([tangent + 1, len(equivalent.parameters), *(len(one.flat()) for one in surfaces.values())])
        columns = np.zeros((ends[-1], len(values)))
        undifferentiable: dict[str, str] = {}
        for k, name in enumerate(self._parameters.names):
            other: list[str] = []
            moving: set[int] = set()
            try:
                column = self._column(base, equivalent, surfaces, values, k, other, moving)
            except InvalidInput as error:
                raise InvalidInput(
                    f"setup cannot be differentiated with respect to {name} at {values[k]:.9g}: {error}"
                ) from error
            if other:
                undifferentiable[name] = other[0]
            elif column is None and moving:
                body = base.system.context.names[min(moving)]
                undifferentiable[name] = f"the principal axes of {body}, which turn at once where two moments are equal"
            elif column is None:
                raise InvalidInput(
                    f"the results of setup do not change evenly with {name} near {values[k]:.9g}; expected a function "
                    "without jumps, rounded numbers, tables without interpolation and random numbers"
                )
            else:
                columns[:, k] = column
        start, times = columns[:tangent], columns[tangent]
        if times.any():
            if "ThirdBody" in base.system.context.forces.values():
                # The barycentre of an earlier start would have another velocity than the nominal one.
                later = (name for name, time in zip(self._parameters.names, times, strict=True) if time)
                undifferentiable |= dict.fromkeys(later, "the time of the start beside a third body")
            # A start that is later by dt corresponds to one whose state is behind by f dt, with f the rates of change.
            start = start - np.outer(base.system.context.core.jacobian(base.core, [])[3], times)
        _, by_parameters, *by_surfaces = np.split(columns, ends[:-1])
        rows = zip(equivalent.parameters, by_parameters, strict=True)
        deformations: dict[str, Deformation] = {}
        for k, name in enumerate(self._parameters.names):
            both = zip(surfaces.items(), by_surfaces, strict=True)
            parts = {index: surface.unflattened(by[:, k]) for (index, surface), by in both if by[:, k].any()}
            if parts:
                deformations[name] = parts
        by_name = {name: row for name, row in rows if row.any()}
        return SetupDerivatives(start, by_name, undifferentiable, deformations, equivalent)

    def _column(
        self,
        base: SetupResult,
        equivalent: SetupResult,
        surfaces: dict[int, Surface],
        values: Floats,
        k: int,
        other: list[str],
        moving: set[int],
    ) -> Floats | None:
        """Return derivatives of start, time, parameters of the equivalent system and surfaces; ``other`` receives all
        other changes, and ``moving`` the bodies that are deformed.
        """
        parameters = np.abs(list(equivalent.parameters.values()))
        start = np.append(np.tile(np.repeat(np.arange(4), 3), len(base.core.position)), 4)
        # Coefficients of gravity, which are below one, have the rounding errors of the sums of which they are left.
        least = [0.0 if name in base.parameters else 1.0 for name in equivalent.parameters]
        sizes = [base.sizes(), np.maximum(parameters, least)]
        groups = [start, np.arange(len(parameters)) + 5]
        for surface in surfaces.values():
            sizes += [np.full(part.size, float(np.abs(part).max(initial=0.0))) for part in surface]
            groups.append(np.repeat(np.arange(3) + groups[-1].max() + 1, [part.size for part in surface]))
        noise = _ROUNDING * np.concatenate(sizes)

        def shifted(by: float) -> Floats:
            made = self._make(self._parameters.shifted(values, k, by))
            self._watch(base, made)
            moving.update(base.deformed(made))
            near = [index for index in moving if index not in surfaces]
            if near:
                names = base.system.context.names
                other.append(f"the shape of {names[near[0]]}, of which the sphere around it reaches another body")
                return np.zeros(len(noise))
            changes, unexplained = equivalent.changes(made.equivalent(self._gravities()))
            if unexplained is not None:
                other.append(unexplained)
                return np.zeros(len(noise))
            moved = [made.surfaces[index] for index in surfaces]
            shifts = [new.flat() - old.flat() for new, old in zip(moved, surfaces.values(), strict=True) if new]
            return np.concatenate([base.moved(made), changes, *shifts])

        size = self._parameters.size(k, values[k])
        return self.differences[k].derivative(shifted, size, noise, np.concatenate(groups), 0.1 * max(size, 1.0))

    def _gravities(self) -> dict[int, Gravity]:
        """Return the gravity of the deformed bodies by which motions are differentiated."""
        return {index: gravity for index, gravity in self._deforming.items() if gravity is not None}

    def _watch(self, base: SetupResult, made: SetupResult) -> None:
        """Raise an exception if a body is deformed of which that was not yet known."""
        if new := [index for index in base.deformed(made) if index not in self._deforming]:
            self._deforming |= {index: base.gravity(index) for index in new}
            raise _NewDeformation


def _is_deformed(body: Body, other: Body, old: Surface, new: Surface) -> bool:
    if [part.shape for part in old] != [part.shape for part in new]:
        return False
    if len(old.areas):
        return bool((np.abs(new.areas - old.areas) > _ROUNDING * old.areas.max()).any())
    if not np.array_equal(cast(Any, body.shape).faces, cast(Any, other.shape).faces):
        return False
    factor = _reach(new) / _reach(old)
    return bool((np.abs(new.given - factor * old.given) > _ROUNDING * np.abs(new.given).max()).any())


def _reach(surface: Surface) -> float:
    """Return the radius of the sphere around a polyhedron."""
    return float(np.sqrt(np.max(np.sum(surface.vertices**2, axis=1), initial=0.0)))
