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

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.differences import Differences
from ..errors import InvalidInput
from ..model.surface import Deformation, Surface
from ..typing import Floats
from .free import Parameters
from .setup_result import ROUNDING, Gravity, SetupResult


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
    """A body is deformed that was not known to be."""


class _Undifferentiable(Exception):
    """A parameter changes something by which motions cannot be differentiated; the text says what that is."""


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
            made = self._make(self._parameters.shifted(values, k, by))
            deformed.update(base.deformed(made))
            if new := deformed - self._deforming.keys():
                self._deforming |= {index: base.gravity(index) for index in new}
                raise _NewDeformation
            if near := deformed - surfaces.keys():
                which = f"the shape of {names[min(near)]}"
                raise _Undifferentiable(f"{which}, of which the sphere around it reaches another body")
            changes, unexplained = equivalent.changes(made.equivalent(self._gravities()))
            if unexplained is not None:
                raise _Undifferentiable(unexplained)
            pairs = ((made.surfaces[index], old) for index, old in surfaces.items())
            shifts = [new.flat() - old.flat() for new, old in pairs if new]
            return np.concatenate([base.displacement(made), changes, *shifts])

        size = self._parameters.size(k, values[k])
        try:
            column = self.differences[k].derivative(shifted, size, *scales, 0.1 * max(size, 1.0))
        except InvalidInput as error:
            raise InvalidInput(
                f"setup cannot be differentiated with respect to {name} at {values[k]:.9g}: {error}"
            ) from error
        if column is None and deformed:
            which = f"the principal axes of {names[min(deformed)]}"
            raise _Undifferentiable(f"{which}, which turn at once where two moments are equal")
        if column is None:
            raise InvalidInput(
                f"the results of setup do not change evenly with {name} near {values[k]:.9g}; expected a function "
                "without jumps, rounded numbers, tables without interpolation and random numbers"
            )
        return column

    def _gravities(self) -> dict[int, Gravity]:
        """Return the gravity of the deformed bodies by which motions are differentiated."""
        return {index: gravity for index, gravity in self._deforming.items() if gravity is not None}


def _scales(base: SetupResult, equivalent: SetupResult, surfaces: dict[int, Surface]) -> tuple[Floats, Any]:
    """Return rounding errors of start, time, parameters and surfaces, and equal numbers for numbers of one kind."""
    parameters = np.abs(list(equivalent.parameters.values()))
    # Coefficients of gravity, which are below one, have the rounding errors of the sums of which they are left.
    least = [0.0 if name in base.parameters else 1.0 for name in equivalent.parameters]
    sizes = [base.sizes(), np.maximum(parameters, least)]
    start = np.append(np.tile(np.repeat(np.arange(4), 3), len(base.core.position)), 4)
    groups = [start, np.arange(len(parameters)) + 5]
    for surface in surfaces.values():
        sizes += [np.full(part.size, float(np.abs(part).max(initial=0.0))) for part in surface]
        groups.append(np.repeat(np.arange(3) + groups[-1].max() + 1, [part.size for part in surface]))
    return ROUNDING * np.concatenate(sizes), np.concatenate(groups)
