"""Radar spectra and delay-Doppler images of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.kinds import flag
from ..base.units import need
from ..base.values import ArrayFields
from ..errors import InvalidInput, interruptible
from ..record.record import Record
from .echoes import DIMENSIONS, Echo, EchoModel, RadarOptions, bin_edges
from .laws import Cosine, RadarLaw
from .states import retarded
from .times import to_system_times
from .vectors import Vectors, local_geometry

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RadarEcho(ArrayFields):
    """Cross sections of the bodies of a run in bins of frequency, or of delay and frequency.

    Attributes
    ----------
    times : ndarray or Quantity, (K,)
        Times when the echo arrives, in the system's unit of time since its epoch.
    frequencies : ndarray or Quantity, (F,)
        Edges of the bins of frequency.
    delays : ndarray or Quantity, (D,), or None
        Edges of the bins of delay; ``None`` for spectra.
    power : ndarray or Quantity, (K, F - 1) or (K, D - 1, F - 1), or with an axis (N,) of the bodies after the first
        Cross section in each bin.
    bodies : tuple of str
        Names of the bodies of that axis; empty if the power is that of all bodies together.
    """

    times: Any
    frequencies: Any
    delays: Any
    power: Any
    bodies: tuple[str, ...] = ()

    def to_xarray(self) -> xarray.DataArray:
        """Convert the cross sections to an ``xarray.DataArray``.

        Its dimensions are ``time``, ``body`` with bodies, ``delay`` with delays and ``frequency``. The coordinates of
        the latter two are the middles of the bins; ``delay_edges`` and ``frequency_edges`` are among the attributes.
        """
        with need("data", "an echo as a data array"):
            import xarray as xr

        axes = {"time": self.times, "body": self.bodies or None, "delay": self.delays, "frequency": self.frequencies}
        axes = {name: values for name, values in axes.items() if values is not None}
        coordinates: dict[str, Any] = {}
        attributes: dict[str, Any] = {"long_name": "radar cross section", **_unit_of(self.power)}
        for name, values in axes.items():
            numbers = np.asarray(getattr(values, "value", values))
            if name in ("delay", "frequency"):
                attributes[f"{name}_edges"] = numbers
                numbers = 0.5 * (numbers[1:] + numbers[:-1])
            coordinates[name] = (name, numbers, {"long_name": name, **_unit_of(values)})
        power = np.asarray(getattr(self.power, "value", self.power))
        return xr.DataArray(power, coordinates, list(axes), name="power", attrs=attributes)


def _unit_of(values: Any) -> dict[str, str]:
    unit = getattr(values, "unit", None)
    return {} if unit is None else {"units": str(unit)}


@interruptible("radar spectra")
def radar_spectrum(
    run: Record,
    times: Any,
    geometry: Vectors,
    frequencies: Any,
    *,
    transmit_frequency: Any,
    law: RadarLaw | dict[str, RadarLaw] = Cosine(),  # noqa: B008
    mutual: bool = True,
    transmitter: Vectors | None = None,
    exposure: Any = 0.0,
    frequency_response: str = "bin",
    per_body: bool = False,
) -> RadarEcho:
    """Compute the Doppler spectra of the radar echo of a run: the cross section in each bin of frequency.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``, of a system with units.
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the echo arrives.
    geometry : Geometry
        The geometry of the receiver; the Sun is not needed.
    frequencies : array_like or Quantity, (F,)
        Edges of the bins, which increase: the frequency from that of the echo of the system's barycentre, positive if
        the surface approaches. Plain numbers are in one over the system's unit of time.
    transmit_frequency : float or Quantity
        The frequency that is transmitted, 1 MHz or more.
    law : RadarLaw or dict
        The scattering law, such as :class:`Cosine`; or one for each body by its name.
    mutual : bool
        Whether the echo of a body is missing where another one hides it from an antenna. A body of several parts, or
        one that is not convex, hides parts of itself in any case.
    transmitter : Geometry, optional
        For a bistatic radar the vectors to the transmitter at the times when the echo arrives; otherwise the receiver
        transmits too.
    exposure : float or Quantity
        The time of integration about each of the times, over which a spectrum is averaged. It should be so short that
        no feature moves by many bins.
    frequency_response : str
        ``"bin"`` for the echo within the edges of a bin, or ``"sinc2"`` for the response of a discrete Fourier
        transform, sinc^2 of the distance from the middle of a bin in units of its width.
    per_body : bool
        Whether to return the echo of each body instead of that of all of them together.

    Returns
    -------
    RadarEcho
        Its ``.power`` is (K, F - 1), or (K, N, F - 1) with ``per_body``. Where nothing is seen it is zero.

    Raises
    ------
    Interrupted
        On Ctrl-C.
    InvalidInput
        For edges that do not increase, a transmitter below 1 MHz, a receiver or a transmitter inside the system or
        nearer to a body than about 300 times its radius, a system without units, and times outside the span of the
        geometry or of the run.

    Notes
    -----
    Ellipsoids have no mesh: the error is 1e-12 of their echo. Polyhedra and composites are computed from their facets,
    with what these hide of each other cut out exactly; ellipsoids beside them, where one hides the other, and in
    composites have 5,120 facets. Each body is seen at its own time, along the direction of its centre; the use of one
    direction for the whole surface has an error of its radius over the distance. A body without rotation relative to
    the radar has its whole echo in one bin. See :doc:`/theory/radar`.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> run = system.integrate(state, "20 h", dense=True)
    >>> view = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
    >>> options = {"transmit_frequency": 2380 * u.MHz, "law": observing.Cosine(C=1.0, R=0.1)}
    >>> echo = observing.radar_spectrum(run, [3.0, 10.0] * u.h, view, np.linspace(-40, 40, 81) * u.Hz, **options)
    >>> echo.power.shape, echo.power.sum(axis=1).to("km2").round(2)
    ((2, 80), <Quantity [0.18, 0.18] km2>)
    """
    options = RadarOptions(transmit_frequency, law, mutual, transmitter, exposure, frequency_response)
    return _echo(run, times, geometry, options, per_body, {"frequencies": frequencies})


@interruptible("delay-Doppler images")
def delay_doppler(
    run: Record,
    times: Any,
    geometry: Vectors,
    delays: Any,
    frequencies: Any,
    *,
    transmit_frequency: Any,
    law: RadarLaw | dict[str, RadarLaw] = Cosine(),  # noqa: B008
    mutual: bool = True,
    transmitter: Vectors | None = None,
    exposure: Any = 0.0,
    frequency_response: str = "bin",
    delay_response: str = "bin",
    per_body: bool = False,
) -> RadarEcho:
    """Compute delay-Doppler images of a run: the cross section in each bin of delay and frequency.

    Parameters
    ----------
    run, times, geometry
        As for :func:`radar_spectrum`.
    delays : array_like or Quantity, (D,)
        Edges of the bins of delay, which increase: the delay from the echo of the system's barycentre, positive if the
        surface is farther. Plain numbers are in the system's unit of time.
    frequencies, transmit_frequency, law, mutual, transmitter, exposure, frequency_response
        As for :func:`radar_spectrum`.
    delay_response : str
        ``"bin"`` for the echo within the edges of a bin, or ``"triangle2"`` for the response of a decoder to a code of
        binary phases, 3/2 (1 - x)^2 at the distance x from the middle of a bin in units of its width, with the
        integral one.
    per_body : bool
        Whether to return the echo of each body instead of that of all of them together.

    Returns
    -------
    RadarEcho
        Its ``.power`` is (K, D - 1, F - 1), or (K, N, D - 1, F - 1) with ``per_body``.

    Raises
    ------
    Interrupted, InvalidInput
        As for :func:`radar_spectrum`.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> run = system.integrate(state, "20 h", dense=True)
    >>> view = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
    >>> bins = np.linspace(-25, 25, 101) * u.us, np.linspace(-40, 40, 81) * u.Hz
    >>> echo = observing.delay_doppler(run, [3.0] * u.h, view, *bins, transmit_frequency=2380 * u.MHz, per_body=True)
    >>> echo.bodies, echo.power.shape
    (('Alpha', 'Beta'), (1, 2, 100, 80))
    """
    options = RadarOptions(transmit_frequency, law, mutual, transmitter, exposure, frequency_response, delay_response)
    return _echo(run, times, geometry, options, per_body, {"frequencies": frequencies, "delays": delays})


def _echo(
    run: Record, times: Any, geometry: Vectors, options: RadarOptions, per_body: bool, bins: dict[str, Any]
) -> RadarEcho:
    """Return spectra, or images if there are delays, averaged over the exposure."""
    system, units = run.system, run.context.units
    flag(per_body, "per_body")
    model, local = EchoModel(system, geometry, options), local_geometry(geometry, system)
    arrival = np.atleast_1d(to_system_times(times, system, "times"))
    if arrival.ndim != 1:
        raise InvalidInput(f"times has shape {arrival.shape}; expected (K,)")
    edges = bin_edges(system, bins)

    def echo(time: float) -> Echo:
        states, retarded_states = retarded(run, local, arrival + time, "time of a radar echo")
        return model.echo(retarded_states, states)

    power = model.mean_power(echo, edges)
    power = power if per_body else power.sum(axis=1)
    attached: dict[str, Any] = {name: units.attach(values, DIMENSIONS[name]) for name, values in edges.items()}
    return RadarEcho(
        units.attach(arrival, "time"),
        attached["frequencies"],
        attached.get("delays"),
        units.attach(power if "delays" in edges else power[..., 0, :], "area"),
        tuple(run.context.names) if per_body else (),
    )
