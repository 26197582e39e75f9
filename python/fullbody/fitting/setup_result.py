"""The system and the state that a setup returns, and their derivatives with respect to the parameters of a fit.

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
from contextlib import suppress
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
    """The system and the state that a setup returns."""

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
        """Return the indices of the bodies whose surface is not a scaled copy of the one in this result."""
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
        """Return the changes (P,) of the parameters to another system, and a difference that no parameter makes."""
        changed, unexplained = self.system.context.core.parameter_changes(other.system.context.core)
        if unexplained is None:
            names = (*self.settings, *other.settings)
            differing = (name for name in names if self.settings.get(name, ...) != other.settings.get(name, ...))
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
    """A parameter deforms a body that is not among the deformed ones yet."""


class _Undifferentiable(Exception):
    """A parameter changes something by which motions cannot be differentiated; the text names it."""


class SetupDifferences:
    """The derivatives of a setup at any values in a fit; the steps of differences carry over to later values.

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
        while True:
            # A body may have grown since the last time.
            self._deforming = {index: base.gravity(index) for index in self._deforming}
            with suppress(_NewDeformation):
                return self._at(base, values)

    def _at(self, base: SetupResult, values: Floats) -> SetupDerivatives:
        names, context = self._parameters.names, base.system.context
        equivalent = base.equivalent(self._gravities())
        surfaces = {index: surface for index in self._gravities() if (surface := base.surfaces[index]) is not None}
        scales = _scales(base, equivalent, surfaces)
        columns = np.zeros((len(scales[0]), len(values)))
        undifferentiable: dict[str, str] = {}
        for k, name in enumerate(names):
            try:
                columns[:, k] = self._column(base, equivalent, surfaces, scales, values, k)
            except _Undifferentiable as reason:
                undifferentiable[name] = str(reason)
        sizes = [12 * len(context), 1, len(equivalent.parameters), *(len(part.flat()) for part in surfaces.values())]
        start, (times,), by_parameters, *by_surfaces = np.split(columns, np.cumsum(sizes)[:-1])
        if times.any():
            if "ThirdBody" in context.forces.values():
                # The barycentre of an earlier start would have another velocity than the nominal one.
                moving = (name for name, time in zip(names, times, strict=True) if time)
                undifferentiable |= dict.fromkeys(moving, "the time of the start beside a third body")
            # A start that is later by dt corresponds to one whose state is behind by f dt, with f the rates of change.
            start = start - np.outer(context.core.jacobian(base.core, [])[3], times)
        deformations: dict[str, Deformation] = {}
        for k, name in enumerate(names):
            pairs = zip(surfaces.items(), by_surfaces, strict=True)
            parts = {index: surface.unflattened(by[:, k]) for (index, surface), by in pairs if by[:, k].any()}
            if parts:
                deformations[name] = parts
        rows = zip(equivalent.parameters, by_parameters, strict=True)
        by_name = {name: row for name, row in rows if row.any()}
        return SetupDerivatives(start, by_name, undifferentiable, deformations, equivalent)

    def _column(
        self,
        base: SetupResult,
        equivalent: SetupResult,
        surfaces: dict[int, Surface],
        scales: tuple[Floats, Any],
        values: Floats,
        k: int,
    ) -> Floats:
        """Return derivatives of start, time, parameters of the equivalent system and surfaces."""
        deformed: set[int] = set()
        names, name = base.system.context.names, self._parameters.names[k]

        def shifted(by: float) -> Floats:
            shifted_result = self._make(self._parameters.shifted(values, k, by))
            deformed.update(base.deformed(shifted_result))
            if new := deformed - self._deforming.keys():
                self._deforming |= {index: base.gravity(index) for index in new}
                raise _NewDeformation
            if near := deformed - surfaces.keys():
                which = f"the shape of {names[min(near)]}"
                raise _Undifferentiable(f"{which}, of which the sphere around it reaches another body")
            changes, unexplained = equivalent.changes(shifted_result.equivalent(self._gravities()))
            if unexplained is not None:
                raise _Undifferentiable(unexplained)
            pairs = ((shifted_result.surfaces[index], old) for index, old in surfaces.items())
            shifts = [new.flat() - old.flat() for new, old in pairs if new]
            return np.concatenate([base.displacement(shifted_result), changes, *shifts])

        size = self._parameters.size(k, values[k])
        try:
            column = self.differences[k].derivative(shifted, size, *scales, 0.1 * max(size, 1.0))
        except InvalidInput as error:
            raise InvalidInput(
                f"setup cannot be differentiated with respect to {name} at {values[k]:.9g}: {error}"
            ) from error
        if column is None and deformed:
            which = f"the principal axes of {names[min(deformed)]}"
            raise _Undifferentiable(f"{which}, which jump where two moments are equal")
        if column is None:
            raise InvalidInput(
                f"the results of setup do not change evenly with {name} near {values[k]:.9g}; expected a function "
                "without jumps, rounded numbers, tables without interpolation and random numbers"
            )
        return column

    def _gravities(self) -> dict[int, Gravity]:
        """Return the gravity of the deformed bodies by which motions are differentiated."""
        return {index: gravity for index, gravity in self._deforming.items() if gravity is not None}


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


def _scales(base: SetupResult, equivalent: SetupResult, surfaces: dict[int, Surface]) -> tuple[Floats, Any]:
    """Return rounding errors of start, time, parameters and surfaces, and equal numbers for numbers of one kind."""
    parameters = np.abs(list(equivalent.parameters.values()))
    # Coefficients of gravity, which are below one, have the rounding errors of sums of larger terms.
    least = [0.0 if name in base.parameters else 1.0 for name in equivalent.parameters]
    sizes = [base.sizes(), np.maximum(parameters, least)]
    start = np.append(np.tile(np.repeat(np.arange(4), 3), len(base.core.position)), 4)
    groups = [start, np.arange(len(parameters)) + 5]
    for surface in surfaces.values():
        sizes += [np.full(part.size, float(np.abs(part).max(initial=0.0))) for part in surface]
        groups.append(np.repeat(np.arange(3) + groups[-1].max() + 1, [part.size for part in surface]))
    return ROUNDING * np.concatenate(sizes), np.concatenate(groups)
