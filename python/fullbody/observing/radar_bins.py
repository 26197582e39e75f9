"""Observed powers in bins of a radar's receiver, and their predictions: the base of spectra and of images."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.differences import difference
from ..base.figures import unit_of
from ..base.kinds import instance, whole_number
from ..base.limits import FINITE, Limits
from ..base.rotations import of_vectors, products
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, strip_to, without_unit
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .columns import DataColumn, Rows, column, jitter_of, positive_rows, refuse_rounded
from .data import Observations
from .echoes import Echo, EchoModel, RadarOptions, bin_edges
from .linear import LinearUnknown
from .predictions import DesignArgument, Errors
from .vectors import Vectors

#: The step of derivatives by differences, relative to the radius of a body, the width of its echo, or one radian. The
#: echo is precise to 1e-12, and changes over some hundredths of these, the widths of bins.
_STEP = 2e-5


class RadarEchoes(Observations):
    """Base class of radar spectra and delay-Doppler images: K rows of bins, with one error for each bin."""

    _columns = (DataColumn("power"), DataColumn("sigma"))
    _options = ("polarization", "gain", "looks")
    _depends_on_figures = True
    #: Coefficients of a polynomial in time that is added to the delays.
    delay_correction: tuple[Any, ...] = ()

    def __init__(
        self,
        times: Any,
        power: Any,
        sigma: Any,
        edges: dict[str, Any],
        geometry: Vectors,
        options: RadarOptions,
        gain: float | str,
        frequency_offset: Any,
        looks: float | None,
        polarization: str | None,
    ) -> None:
        owner = type(self).__name__
        values, self._unit = column(power, f"power of {owner}")
        sigmas, unit_of_sigma = column(sigma, f"sigma of {owner}", self._unit)
        if (unit_of_sigma is None) != (self._unit is None):
            raise InvalidInput("only one of power and sigma has a unit; expected both or neither")
        self._edges = edges
        self._bins = tuple(np.size(getattr(values, "value", values)) - 1 for values in edges.values())
        if values.shape[1:] != self._bins:
            expected = "(K, " + ", ".join(map(str, self._bins)) + ")"
            raise InvalidInput(f"power of {owner} has shape {values.shape}; expected {expected}, a number for each bin")
        if sigmas.ndim not in (0, 1, values.ndim):
            raise InvalidInput(f"sigma of {owner} has shape {sigmas.shape}; expected (), (K,) or {values.shape}")
        flat = {"power": values.reshape(len(values), -1)}
        flat["sigma"] = sigmas.reshape(len(sigmas), -1) if sigmas.ndim > 1 else sigmas
        rows = Rows(times, flat, (), owner)
        super().__init__(rows, geometry)
        size = flat["power"].shape[1]
        self._power, sigmas = rows.column("power", size), positive_rows(rows.column("sigma", size), f"sigma of {owner}")
        refuse_rounded(power, self._power.ravel(), sigmas.ravel(), f"power of {owner}")
        if looks is not None:
            number = UNITLESS.number(looks, "number", f"looks of {owner}", Limits(above=0.0))
            sigmas = sigmas + np.clip(self._power, 0.0, None) / np.sqrt(number)
        if polarization is not None:
            instance(polarization, f"polarization of {owner}", str, "a label such as 'OC' or 'SC', or None")
        if not (isinstance(gain, str) and gain == "free"):
            UNITLESS.number(gain, "number", f"gain of {owner}", Limits(text="'free' or a finite number"))
        self._sigma = sigmas
        self.options, self.exposure, self.frequency_offset = options, options.exposure, frequency_offset
        self.gain, self.looks, self.polarization = gain, looks, polarization

    @property
    def frequencies(self) -> Any:
        """The edges of the bins of frequency, as they were given."""
        return self._edges["frequencies"]

    @property
    def power(self) -> Any:
        """The observed powers, (K, F - 1) or (K, D - 1, F - 1)."""
        return self._shaped(self._power)

    @property
    def sigma(self) -> Any:
        """The standard errors, of the same shape, with the noise of the echo itself if the number of looks is known."""
        return self._shaped(self._sigma)

    def _shaped(self, values: Floats) -> Any:
        shaped = values.reshape(len(values), *self._bins)
        return shaped if self._unit is None else shaped * self._unit

    def _add_jitter(self, jitter: Any) -> None:
        self._sigma = np.hypot(self._sigma, jitter_of(jitter, self._unit))

    def _scale(self, system: SystemLike) -> float:
        """Return the number of the data's units in the unit of the predictions, the system's unit of area."""
        if self._unit is None or not self._unit.is_equivalent(unit_named("km2")):
            return 1.0
        return float(strip_to(1.0 * self._unit, system.context.units.unit("area"), "power"))

    def _observed(self, system: SystemLike) -> Floats:
        return self._power * self._scale(system)

    def _standard_errors(self, system: SystemLike) -> Floats:
        return self._sigma * self._scale(system)

    def _whiten(self, values: Floats, system: SystemLike, transposed: bool = False) -> Floats:
        sigma = self._standard_errors(system)
        return np.asarray(values / sigma.reshape(*sigma.shape, *[1] * (values.ndim - 2)))

    def errors(self, system: SystemLike) -> Errors:
        """Return the variances (K B, 1, 1) of all bins, which are independent, with and without a jitter."""
        both: list[Any] = [self, self if self._original is None else self._original]
        return Errors(*(data._standard_errors(system).reshape(-1, 1, 1) ** 2 for data in both))

    def _row(self, run: Record, row: int, linear: Mapping[str, Any] | None) -> tuple[Any, Any]:
        """Return the prediction and the residuals of one row, in the unit and the shape of the data."""
        row = whole_number(row, "row", least=0, most=len(self) - 1)
        predicted, residuals, _ = self._solved(run, linear)
        return self._attach(predicted, run.system)[row], self._attach(residuals, run.system)[row]

    def _edge_numbers(self, name: str, text: str) -> tuple[Floats, str]:
        """Return the edges of bins as they were given, and the label of their axis."""
        edges = as_quantity(self._edges[name], name)
        return without_unit(edges), f"{text} [{unit_of(edges)}]"

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return self._shaped(values / self._scale(system))

    def _linear_unknowns(self, system: SystemLike) -> tuple[LinearUnknown, ...]:
        return (LinearUnknown("gain"),) if self.gain == "free" else ()

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        if self.gain == "free":
            return np.zeros_like(self._power)
        return float(self.gain) * self._cross_sections(system, states, masses)

    def _design(self, system: SystemLike, states: dict[str, Floats]) -> Floats:
        if self.gain != "free":
            return super()._design(system, states)
        return self._cross_sections(system, states)[..., None]

    def _cross_sections(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        """Return the cross sections (K, B) of all bodies in the bins, averaged over the exposure."""
        model = EchoModel(system, self.geometry, self.options)

        def echo(time: float) -> Echo:
            retarded = self._retarded(system, states, masses, time)
            return self._corrected(model, model.echo(retarded, states), retarded.times)

        return model.mean_power(echo, self._edges_in(system)).sum(axis=1).reshape(len(self), -1)

    def _edges_in(self, system: SystemLike) -> dict[str, Floats]:
        return bin_edges(system, self._edges, type(self).__name__)

    def _corrected(self, model: EchoModel, echo: Echo, times: Floats) -> Echo:
        """Return echoes shifted by the offset of the frequency and by the polynomial of the delay."""
        units, owner = model.system.context.units, type(self).__name__
        coefficients = []
        for power, coefficient in enumerate(self.delay_correction):
            what = f"delay_correction[{power}] of {owner}"
            if is_quantity(coefficient := as_quantity(coefficient, what)):
                coefficient = float(strip_to(coefficient, units.unit("time") ** (1 - power), what))
            coefficients.append(UNITLESS.number(coefficient, "number", what, FINITE))
        delay, elapsed = np.polynomial.Polynomial(coefficients or [0.0]), times - self._clock(model.system).mean()
        offset = units.number(self.frequency_offset, "rate", f"frequency_offset of {owner}")
        shift = np.stack([offset - model.transmit_frequency * delay.deriv()(elapsed), delay(elapsed)], axis=-1)
        return Echo(echo.epochs, echo.at_centre + shift[:, None], echo.gradients)

    def _partial(self, system: SystemLike, states: dict[str, Floats], parameter: str) -> Floats:
        kind, _, body = parameter.partition(" of ")
        if kind != "mass" or body not in system.context.names:
            return super()._partial(system, states, parameter)
        if self.gain == "free":
            return np.zeros_like(self._power)
        # A mass moves the barycentre.
        masses = system.context.masses
        unit = np.eye(len(masses))[system.context.names.index(body)]
        reference = self._model(system, states)
        return difference(lambda by: self._model(system, states, masses + by * unit) - reference, masses.sum() * _STEP)

    def _partials(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str] = ()
    ) -> tuple[Floats, dict[str, Floats]]:
        """Return derivatives (K, B, 12 N) of the predictions with respect to the states, and (K, B) by parameters.

        They are differences: the echo below an edge is a smooth function of the states, precise to 1e-12.
        """
        direct = {name: self._partial(system, states, name) for name in parameters}
        if self.gain == "free":
            return np.zeros((*self._power.shape, 12 * len(system.context))), direct
        return float(self.gain) * self._by_states(system, states), direct

    def _design_arguments(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str]
    ) -> list[DesignArgument]:
        if self.gain != "free":
            return []
        with_unit_gain = copy.copy(self)
        with_unit_gain.gain = 1.0
        direct = {name: with_unit_gain._partial(system, states, name) for name in parameters}
        return [DesignArgument(np.ones((*self._power.shape, 1)), self._by_states(system, states), direct)]

    def _by_states(self, system: SystemLike, states: dict[str, Floats]) -> Floats:
        """Return the derivatives (K, B, 12 N) of the cross sections with respect to the states."""
        count = len(system.context)
        model = EchoModel(system, self.geometry, self.options)
        echo = model.echo(self._retarded(system, states), states)
        widths = model.half_widths(echo)[..., 0].max(axis=0) + np.diff(self._edges_in(system)["frequencies"]).max()
        # A velocity changes the frequency by 2 F / c, and a spin by this times the radius.
        speeds = widths * model.light_speed / (2.0 * model.transmit_frequency)
        reference = self._cross_sections(system, states)
        result = np.zeros((*self._power.shape, 12 * count))
        for body in range(count):
            radius = max(system.context.bodies[body].circumradius, np.finfo(float).tiny)
            sizes = {"position": radius, "velocity": speeds[body], "attitude": 1.0, "spin": speeds[body] / radius}
            for kind, (name, size) in enumerate(sizes.items()):
                for axis in range(3):

                    def change(by: float, body: int = body, name: str = name, axis: int = axis) -> Floats:
                        changed = states[name].copy()
                        if name == "attitude":
                            changed[:, body] = products(changed[:, body], of_vectors(by * np.eye(3)[axis]))
                        else:
                            changed[:, body, axis] += by
                        return self._cross_sections(system, {**states, name: changed}) - reference

                    result[..., 12 * body + 3 * kind + axis] = difference(change, _STEP * size)
        return result

    def _summary(self) -> list[tuple[str, str]]:
        bins = " x ".join(map(str, self._bins))
        return [("bins", bins), ("gain", str(self.gain)), ("law", repr(self.options.law))]
