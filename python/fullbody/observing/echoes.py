"""Radar echoes of the bodies of a system: what a radar transmits, and the cross sections in bins of its receiver.

With U the sum of the unit vectors from a body to the receiver and to the transmitter, the echo of a point at x from the
body's centre of mass is later than that of the centre by -x.U / c, and higher in frequency by (F / c) [(omega x x).U +
x.dU/dt], with the frequency F that is transmitted. The last term is the apparent rotation due to the motion on the sky.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.kinds import choice, flag, instance
from ..base.limits import FINITE, Limits
from ..base.rotations import matrices
from ..base.units import need
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .brightness import Epochs, by_name
from .laws import Cosine, RadarLaw
from .states import DISTANT, RetardedStates, refuse_near
from .times import LIGHT_SPEED, exposure_rule, kilometres, seconds
from .vectors import SystemGeometry, Vectors, local_geometry

#: The lowest frequency of a transmitter in Hz, below which echoes of small bodies are no reflections by a surface.
_LOWEST = 1e6
#: Relative size of a change of frequency over a surface up to which it is rounding.
_PARALLEL = 1e-14
#: The number of cells to the narrowest bin on which an echo is computed before it is weighted.
_CELLS = 16


@dataclass(frozen=True, eq=False)
class RadarOptions:
    """The transmitted frequency and the options of radar echoes, which are arguments of the public functions."""

    transmit_frequency: Any
    law: Any = Cosine()  # noqa: RUF009
    mutual: bool = True
    transmitter: Vectors | None = None
    exposure: Any = 0.0
    frequency_response: str = "bin"
    delay_response: str = "bin"

    def __post_init__(self) -> None:
        flag(self.mutual, "mutual")
        choice(self.frequency_response, "frequency_response", ("bin", "sinc2"))
        choice(self.delay_response, "delay_response", ("bin", "triangle2"))
        if self.transmitter is not None:
            instance(self.transmitter, "transmitter", Vectors, "an observing.Geometry, or None for one antenna")
        for law in self.law.values() if isinstance(self.law, dict) else [self.law]:
            instance(law, "law", RadarLaw, "a radar scattering law such as observing.Cosine(), or a dict of them")


#: The dimensions of the edges of bins.
DIMENSIONS = {"frequencies": "rate", "delays": "time"}


def bin_edges(system: SystemLike, edges: Mapping[str, Any], owner: str = "") -> dict[str, Floats]:
    """Return edges of bins by their names in a system's units, which are checked to be two or more and to increase."""
    result = {}
    for name, array in edges.items():
        what = f"{name} of {owner}" if owner else name
        values = system.context.units.numbers(array, DIMENSIONS[name], what, ("E",), FINITE)
        if len(values) < 2:
            raise InvalidInput(f"{what} has {len(values)} values; expected the edges of bins, two or more")
        if not (increases := np.diff(values) > 0.0).all():
            k = int(np.argmin(increases))
            raise InvalidInput(f"{what} has {values[k + 1]} after {values[k]}; expected edges of bins that increase")
        result[name] = values
    return result


@dataclass(frozen=True, eq=False)
class Echo:
    """The echoes of N bodies at K times, as the core takes them."""

    epochs: Epochs
    #: Frequency and delay (K, N, 2) of the echo of each centre of mass, from the echo of the system's barycentre.
    at_centre: Floats
    #: How both change with the position on the surface, inertial, (K, N, 2, 3).
    gradients: Floats


class EchoModel:
    """A radar, whose receiver has a geometry: computes cross sections of bodies in the system's units."""

    def __init__(self, system: SystemLike, geometry: Vectors, options: RadarOptions) -> None:
        self.system, self.options, names = system, options, system.context.names
        second, km = (size(system, "a radar echo") for size in (seconds, kilometres))
        limits = Limits(least=_LOWEST * second, text=f"a frequency of {_LOWEST / 1e6:g} MHz or more")
        self.transmit_frequency = system.context.units.number(
            options.transmit_frequency, "rate", "transmit_frequency", limits
        )
        self.light_speed = LIGHT_SPEED / km * second
        antennas = [geometry] if options.transmitter is None else [geometry, options.transmitter]
        self._antennas: list[SystemGeometry] = [local_geometry(antenna, system) for antenna in antennas]
        if len({local.distant for local in self._antennas}) > 1:
            raise InvalidInput(
                "one of the geometries of receiver and transmitter has directions only, plain numbers without light "
                "time; expected distances of both, or directions of both"
            )
        laws = [law._describe() for law in by_name(options.law, names, "law")]
        self._core = _core.Radar(list(system.context.bodies), laws, options.mutual)

    def echo(self, retarded: RetardedStates, states: dict[str, Floats]) -> Echo:
        """Return the echoes of bodies in their retarded states."""
        attitude = retarded.attitude(states["attitude"], states["spin"])
        spin = np.einsum("knij,knj->kni", matrices(attitude), states["spin"])
        times, centre = retarded.times, retarded.centre
        paths, vectors = [], []
        for what, local in zip(("receiver", "transmitter"), self._antennas, strict=False):
            vector = local.observer(times)
            refuse_near(self.system, local, what, vector, centre, attitude, times, 1.0, DISTANT + 1.0)
            paths.append(_path_differences(local, times, vector, centre, retarded.velocity))
            vectors.append(vector)
        # One antenna counts twice, on the way to the bodies and back.
        length, rate, direction, direction_rate = (sum(parts) for parts in zip(*(2 * paths)[:2], strict=True))
        factor = self.transmit_frequency / self.light_speed
        at_centre = np.stack([-factor * rate, length / self.light_speed], axis=-1)
        of_frequency = factor * (np.cross(direction, spin) + direction_rate)
        # A rotation about the line of sight would leave the rounding of the product, and split the echo at random.
        sizes = np.linalg.norm([direction, spin, direction_rate, of_frequency], axis=-1)
        of_frequency[sizes[3] <= _PARALLEL * factor * (sizes[0] * sizes[1] + sizes[2])] = 0.0
        gradients = np.stack([of_frequency, -direction / self.light_speed], axis=2)
        distant = all(local.distant for local in self._antennas)
        epochs = Epochs(times, centre, attitude, vectors[0], vectors[-1], None, distant)
        return Echo(epochs, at_centre, gradients)

    def mean_power(self, echo: Callable[[float], Echo], edges: dict[str, Floats]) -> Floats:
        """Return what :meth:`power` does, averaged over the exposure, of the echo at each time from its middle."""
        rule = exposure_rule(self.options.exposure, self.system)
        return np.asarray(sum(weight * self.power(echo(time), **edges) for time, weight in rule))

    def power(self, echo: Echo, frequencies: Floats, delays: Floats | None = None) -> Floats:
        """Return the cross section (K, N, D, F) of each body in bins; D is one without delays."""
        responses = [(frequencies, self.options.frequency_response)]
        responses += [] if delays is None else [(delays, self.options.delay_response)]
        cells = [
            edges if shape == "bin" else _cells(edges, self._span(echo, k))
            for k, (edges, shape) in enumerate(responses)
        ]
        power = self._core.echo(
            echo.epochs.core(),
            echo.at_centre.reshape(-1, 2),
            echo.gradients.reshape(-1, 3),
            cells[0].tolist(),
            [] if delays is None else cells[1].tolist(),
        )
        for (edges, shape), parts, product in zip(responses, cells, ("kndf,ef->knde", "kndf,ed->knef"), strict=False):
            if shape != "bin":
                power = np.einsum(product, power, _weights(shape, edges, parts))
        return np.asarray(power)

    def _span(self, echo: Echo, k: int) -> tuple[float, float]:
        """Return the lowest and the highest frequency, 0, or delay, 1, of all echoes."""
        half = self.half_widths(echo)[..., k]
        at_centre = echo.at_centre[..., k]
        return float((at_centre - half).min()), float((at_centre + half).max())

    def half_widths(self, echo: Echo) -> Floats:
        """Return half the widths (K, N, 2) in frequency and in delay that the echo of each body has at most."""
        radii = np.array([body.circumradius for body in self.system.context.bodies])
        return np.asarray(radii[:, None] * np.linalg.norm(echo.gradients, axis=-1))


def _path_differences(
    local: SystemGeometry, times: Floats, vector: Floats, centre: Floats, velocity: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return for bodies (K, N) the length of the path to an antenna minus that from the barycentre, the rate of change
    of this difference, the unit vectors to the antenna, and their rates of change.
    """
    from_barycentre, antenna_velocity = vector[:, None], local.observer_velocity(times)[:, None]
    distance = np.linalg.norm(from_barycentre, axis=-1)
    axis = from_barycentre / distance[..., None]
    rate = _dot(axis, antenna_velocity)
    if local.distant:
        axis_rate = (antenna_velocity - axis * rate[..., None]) / distance[..., None]
        direction, direction_rate = (np.broadcast_to(part, centre.shape) for part in (axis, axis_rate))
        difference_rate = -_dot(velocity, direction) - _dot(centre, direction_rate)
        return -_dot(centre, direction), difference_rate, direction, direction_rate
    separation, relative = from_barycentre - centre, antenna_velocity - velocity
    length = np.linalg.norm(separation, axis=-1)
    direction = separation / length[..., None]
    length_rate = _dot(direction, relative)
    direction_rate = (relative - direction * length_rate[..., None]) / length[..., None]
    # The difference of two nearly equal lengths is that of their squares over their sum.
    difference = _dot(centre, centre - 2.0 * from_barycentre) / (length + distance)
    delayed = 1.0 - _dot(direction, velocity) / local.light_speed
    return difference, length_rate / delayed - rate, direction, direction_rate


def _dot(first: Floats, second: Floats) -> Floats:
    return np.asarray(np.einsum("...x,...x->...", first, second))


def _cells(edges: Floats, span: tuple[float, float]) -> Floats:
    """Return the edges of cells that cover a span, within which the echo lies, with sixteen cells to a bin."""
    width = float(np.diff(edges).min()) / _CELLS
    first, last = np.floor(span[0] / width) - 1.0, np.ceil(span[1] / width) + 1.0
    return np.asarray(width * np.arange(first, last + 1.0))


def _weights(response: str, edges: Floats, parts: Floats) -> Floats:
    """Return the weights (B, C) of the echo in C cells in each of B bins.

    A response is a function of the distance from the middle of a bin in units of its width, with the integral one; its
    mean over a cell is exact.
    """
    middle, width = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    x = (parts - middle[:, None]) / width[:, None]
    integral = _integral_of_sinc2(x) if response == "sinc2" else _integral_of_triangle2(x)
    return np.asarray(np.diff(integral, axis=1) / np.diff(parts) * width[:, None])


def _integral_of_sinc2(x: Floats) -> Floats:
    """Return the integral from zero of sinc^2, the power response of a discrete Fourier transform."""
    with need("observing", "the response sinc2"):
        from scipy.special import sici

    return np.asarray(sici(2.0 * np.pi * x)[0] / np.pi - x * np.sinc(x) ** 2)


def _integral_of_triangle2(x: Floats) -> Floats:
    """Return the integral of 3/2 (1 - abs(x))^2, the power response of a decoder to a code of binary phases."""
    half = 0.5 * np.clip(1.0 - np.abs(x), 0.0, None) ** 3
    return np.where(x < 0.0, half, 1.0 - half)
