"""Light curves beside the light of a sphere, from which a scan of periods starts."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import are_dates
from ..base.limits import POSITIVE
from ..base.unit_names import unit_named
from ..base.units import DEFAULT_UNITS, UNITLESS, Units, as_quantity, is_quantity, without_unit
from ..errors import InconsistentInput, InvalidInput, caution
from ..model.bodies import Body
from ..model.freeform import ConvexShape
from ..model.state import State
from ..motion.system import System
from ..observing import Photometry
from ..observing.brightness import Epochs, Photometer
from ..observing.times import to_system_times
from ..observing.vectors import local_geometry
from ..typing import Floats
from .losses import LINEAR
from .point import InnerSolution, model_of

#: The default range of periods in hours: from the limit of rubble piles to a day.
_RANGE = (2.2, 24.0)
#: The largest number of periods.
_MOST = 2_000_000


class Curves:
    """The magnitudes of K times of a body alone, compared with those of a sphere.

    The ``times`` (K,) are those at which the light left the body, in hours if they are dates or Quantities
    (``has_units``). The ``pulls`` (K,) are the residuals of the sphere in magnitudes, divided by the errors ``sigma``
    (K,), the ``basis`` (K, L) has orthonormal columns that span the linear unknowns, divided by the errors, and
    ``lights`` (2, K, 3) are unit vectors to the observer and to the Sun, in the ``frame`` of the poles. The sphere has
    facets with ``normals`` (F, 3) and ``areas`` (F,).
    """

    def __init__(self, data: list[Photometry], frame: str | None) -> None:
        self.has_units = are_dates(data[0].times) or is_quantity(data[0].times)
        options: dict[str, Any] = {"units": DEFAULT_UNITS, "frame": frame} if self.has_units else {"G": 1.0}
        if are_dates(data[0].times):
            options["epoch"] = data[0].times[0].tdb
        sphere = ConvexShape([0.0], reference_radius="1 km" if self.has_units else 1.0)
        self.normals, self.areas = sphere.normals, without_unit(sphere.areas)
        self._system = System([Body(sphere, mass="1e12 kg" if self.has_units else 1.0)], **options)
        models, times, lights = [], [], []
        for item in data:
            emission = item.emission(self._system)
            start = State(np.zeros((1, 3)), np.zeros((1, 3)), time=emission[0])
            models.append(model_of(item, self._system.integrate(start, emission[-1], output=emission)))
            local, clock = (
                local_geometry(item.geometry, self._system),
                to_system_times(item.times, self._system, "times"),
            )
            times.append(self._system.context.units.strip(emission, "time", "times"))
            lights.append([local.observer(clock), local.sun(clock)])
        self._laws, self._counts = [item.law for item in data], [len(part) for part in times]
        self.times, self.sigma = np.concatenate(times), np.concatenate([item.sigma for item in data])
        self.pulls = np.concatenate([model.pulls.ravel() for model in models])
        self.basis = InnerSolution(models, LINEAR).projection.basis
        self.lights = np.concatenate(lights, axis=1)
        self.lights /= np.linalg.norm(self.lights, axis=-1, keepdims=True)

    @property
    def numbers(self) -> tuple[Floats, ...]:
        """All numbers on which a scan of these data depends."""
        return self.times, self.sigma, self.pulls, self.basis, self.lights

    def light(self, lights: Floats, weights: Any) -> Any:
        """Return the light (K, C) in directions (2, K, 3) of bodies whose facets have weights (F, C) for areas."""
        ends, parts = np.cumsum([0, *self._counts]), []
        for law, first, last in zip(self._laws, ends, ends[1:], strict=False):
            count = last - first
            poses = np.zeros((count, 1, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (count, 1, 1))
            epochs = Epochs(self.times[first:last], *poses, *lights[:, first:last])
            photometer = Photometer(self._system, law, 1.0, False, 0.0)
            parts.append(photometer.derivatives(epochs, True).areas[0][:, 0] @ weights)
        return np.concatenate(parts)


def scanned_periods(periods: Any, curves: Curves, step: float) -> tuple[Any, Floats]:
    """Return the unit of the periods, None for plain numbers, and the periods (N,) in hours, or as plain numbers."""
    span = float(np.ptp(curves.times))
    if not span > 0.0:
        raise InvalidInput("data have no span of time, which would determine a period; expected two times or more")
    if periods is None:
        if not curves.has_units:
            raise InvalidInput("periods is None beside times without a unit; expected (shortest, longest)")
        periods = unit_named("h") * np.array(_RANGE)
    periods = as_quantity(periods, "periods", "time")
    if is_quantity(periods) != curves.has_units:
        expected = "a Quantity" if curves.has_units else "plain numbers"
        raise InvalidInput(f"periods is {periods!r}; expected {expected}, as the times of the data are")
    unit = periods.unit if is_quantity(periods) else None
    units, dimension = (Units(DEFAULT_UNITS), "time") if unit else (UNITLESS, "number")
    hours = units.numbers(periods, dimension, "periods", ("N",), POSITIVE)
    values = np.unique(hours)
    if len(values) != len(hours) or len(values) < 2:
        raise InvalidInput(f"periods is {periods!r}; expected (shortest, longest), or different periods")
    fraction = np.diff(1.0 / values[::-1]) * span
    if len(values) == 2:
        # Equal steps of the frequency are steps of the period in proportion to P^2.
        count = float(fraction[0]) / step
        if count < 2.0:
            raise InvalidInput(
                f"periods is {periods!r}, shorter than two steps of {step * values[0] ** 2 / span:.3g}; expected a "
                "longer range: data over this span of time cannot tell these periods apart"
            )
        if count > _MOST:
            raise InvalidInput(
                f"periods is {periods!r}, which takes {count:.3g} steps for data over this span of time; expected a "
                f"range with at most {_MOST} steps"
            )
        values = 1.0 / np.linspace(1.0 / values[0], 1.0 / values[1], int(np.ceil(count)) + 1)
    elif fraction.max() > 0.5:
        caution(
            f"periods has steps of up to {fraction.max():.3g} P^2/T; minima are half of P^2/T apart and may be missed",
            InconsistentInput,
        )
    return unit, values
