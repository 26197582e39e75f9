"""Radar spectra and delay-Doppler images as data, to be compared with a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..base.figures import panels, unit_of
from ..base.units import without_unit
from ..record.record import Record
from .echoes import RadarOptions
from .laws import Cosine, RadarLaw
from .pictures import draw
from .radar_bins import RadarEchoes
from .vectors import Vectors


class RadarSpectrum(RadarEchoes):
    """Doppler spectra of the echo of all bodies of a system together.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times of arrival of the echo, in the middle of the exposures.
    power : array_like or Quantity, (K, F - 1)
        Cross sections in the bins; or with ``gain="free"`` the power in any unit, such as standard deviations of the
        noise. Plain numbers without a free gain are in the system's unit of area. Rows with masked or NaN values are
        left out, with a warning.
    sigma : float, array_like or Quantity, (), (K,) or (K, F - 1)
        Standard errors: one for all, for each row, or for each bin.
    frequencies : array_like or Quantity, (F,)
        Edges of the bins, as for :func:`radar_spectrum`.
    transmit_frequency : float or Quantity
        The frequency of the transmitted signal.
    geometry : Geometry
        The geometry of the receiver; the Sun is not needed.
    law, mutual, transmitter, exposure, frequency_response
        Options of :func:`radar_spectrum`.
    gain : float or "free"
        A factor of the cross sections; with ``"free"`` it is solved for wherever a run is compared with the data.
    frequency_offset : float or Quantity
        The frequency that is added to the prediction. For it to be a parameter of a fit, give the fit a function that
        takes it and returns the data.
    looks : float, optional
        The number of independent spectra of which a row is the mean. If it is given, the error of a bin is that of the
        receiver's noise, ``sigma``, plus the observed echo over the square root of the looks, since the echo is random
        as well.
    polarization : str, optional
        A label, such as "OC" for the opposite sense of circular polarization and "SC" for the same sense.

    Raises
    ------
    InvalidInput
        For errors that are not above zero, and for arrays whose shapes do not match; in comparisons with a run, for
        edges that do not increase and the other reasons of :func:`radar_spectrum`.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Notes
    -----
    Within an exposure bodies move uniformly on straight lines and rotate uniformly, so that a run needs one sample for
    each row.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> run = system.integrate(state, "20 h", dense=True)
    >>> view = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
    >>> bins, radar = np.linspace(-40, 40, 81) * u.Hz, {"transmit_frequency": 2380 * u.MHz}
    >>> power = observing.radar_spectrum(run, [3.0, 10.0] * u.h, view, bins, **radar).power
    >>> options = radar | {"frequencies": bins, "geometry": view, "gain": "free"}
    >>> data = observing.RadarSpectrum([3.0, 10.0] * u.h, 7.0 * power.value, 0.01, **options)
    >>> round(data.linear_values(run)["gain"], 9)
    7.0
    """

    _names = ("power",)

    def __init__(
        self,
        times: Any,
        power: Any,
        sigma: Any,
        *,
        frequencies: Any,
        transmit_frequency: Any,
        geometry: Vectors,
        law: RadarLaw | dict[str, RadarLaw] = Cosine(),  # noqa: B008
        mutual: bool = True,
        transmitter: Vectors | None = None,
        exposure: Any = 0.0,
        frequency_response: str = "bin",
        gain: float | str = 1.0,
        frequency_offset: Any = 0.0,
        looks: float | None = None,
        polarization: str | None = None,
    ) -> None:
        options = RadarOptions(transmit_frequency, law, mutual, transmitter, exposure, frequency_response)
        edges = {"frequencies": frequencies}
        super().__init__(times, power, sigma, edges, geometry, options, gain, frequency_offset, looks, polarization)

    def plot(
        self, run: Record, axes: Any = None, *, row: int = 0, linear: Mapping[str, Any] | None = None, **kwargs: Any
    ) -> Any:
        """Draw a spectrum with its errors and the prediction of a run, and below them the residuals.

        Parameters
        ----------
        run : Run
            A run as for :meth:`Observations.predict`.
        axes : array of matplotlib Axes, (2, 1), optional
        row : int
            The index of the time whose spectrum or image is drawn.
        linear : dict, optional
            The gain, as for :meth:`Observations.predict`.
        **kwargs
            Passed to ``Axes.errorbar``.

        Returns
        -------
        ndarray of Axes, (2, 1)
        """
        predicted, residuals = self._row(run, row, linear)
        edges, text = self._edge_numbers("frequencies", "Doppler frequency")
        across = 0.5 * (edges[1:] + edges[:-1]), text
        return draw(across, {"power": (predicted, residuals, self.sigma[row])}, axes, kwargs)


class DelayDoppler(RadarEchoes):
    """Delay-Doppler images of the echo of all bodies of a system together.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times of arrival of the echo, in the middle of the exposures.
    power : array_like or Quantity, (K, D - 1, F - 1)
        Cross sections in the bins, as for :class:`RadarSpectrum`.
    sigma : float, array_like or Quantity, (), (K,) or (K, D - 1, F - 1)
        Standard errors: one for all, for each image, or for each bin.
    delays, frequencies : array_like or Quantity, (D,) and (F,)
        Edges of the bins, as for :func:`delay_doppler`.
    delay_correction : sequence of float or Quantity
        Coefficients, constant first, of a polynomial in the time since the mean of the times: the delay that is added
        to the prediction, such as the error of an ephemeris. Its rate of change also shifts the frequency, by minus
        ``transmit_frequency`` times the rate. A fit takes coefficients as parameters as it does ``frequency_offset``.
    transmit_frequency, geometry, law, mutual, transmitter, exposure, frequency_response, delay_response
        Options of :func:`delay_doppler`.
    gain, frequency_offset, looks, polarization
        As for :class:`RadarSpectrum`.

    Raises
    ------
    InvalidInput
        As for :class:`RadarSpectrum`.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> run = system.integrate(state, "20 h", dense=True)
    >>> view = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
    >>> options = {"delays": np.linspace(-25, 25, 51) * u.us, "frequencies": np.linspace(-40, 40, 41) * u.Hz}
    >>> options |= {"transmit_frequency": 2380 * u.MHz, "geometry": view}
    >>> data = observing.DelayDoppler([3.0] * u.h, np.zeros((1, 50, 40)) * u.km**2, 0.01 * u.km**2, **options)
    >>> data.predict(run).shape
    (1, 50, 40)
    """

    def __init__(
        self,
        times: Any,
        power: Any,
        sigma: Any,
        *,
        delays: Any,
        frequencies: Any,
        transmit_frequency: Any,
        geometry: Vectors,
        law: RadarLaw | dict[str, RadarLaw] = Cosine(),  # noqa: B008
        mutual: bool = True,
        transmitter: Vectors | None = None,
        exposure: Any = 0.0,
        frequency_response: str = "bin",
        delay_response: str = "bin",
        gain: float | str = 1.0,
        delay_correction: Sequence[Any] = (),
        frequency_offset: Any = 0.0,
        looks: float | None = None,
        polarization: str | None = None,
    ) -> None:
        responses = frequency_response, delay_response
        options = RadarOptions(transmit_frequency, law, mutual, transmitter, exposure, *responses)
        edges = {"delays": delays, "frequencies": frequencies}
        self.delay_correction = tuple(delay_correction)
        super().__init__(times, power, sigma, edges, geometry, options, gain, frequency_offset, looks, polarization)

    def plot(
        self, run: Record, axes: Any = None, *, row: int = 0, linear: Mapping[str, Any] | None = None, **kwargs: Any
    ) -> Any:
        """Draw an image, the prediction of a run, and the residuals divided by their errors.

        Delay increases downwards, and frequency to the right.

        Parameters
        ----------
        run, row, linear
            As for :meth:`RadarSpectrum.plot`.
        axes : array of matplotlib Axes, (1, 3), optional
        **kwargs
            Passed to ``Axes.pcolormesh`` for all three.

        Returns
        -------
        ndarray of Axes, (1, 3)
        """
        predicted, residuals = self._row(run, row, linear)
        (x, across), (y, down) = (
            self._edge_numbers(*names) for names in (("frequencies", "Doppler frequency"), ("delays", "delay"))
        )
        flat, result = panels(axes, (1, 3), (12.0, 3.6))
        model, difference, errors = (without_unit(values) for values in (predicted, residuals, self.sigma[row]))
        observed = model + difference
        largest = max(model.max(), observed.max())
        unit = f" [{unit_of(residuals)}]" if hasattr(residuals, "unit") else ""
        parts = {f"observed power{unit}": (observed, largest), f"predicted power{unit}": (model, largest)}
        # The colours of residuals end at four standard errors.
        parts["residual / error"] = difference / errors, 4.0
        for ax, (label, (values, limit)) in zip(flat, parts.items(), strict=True):
            style = {"cmap": "RdBu_r", "vmin": -limit, "vmax": limit} | kwargs
            drawn = ax.pcolormesh(x, y, values, **style)
            ax.set(xlabel=across, ylabel=down, xlim=(x[0], x[-1]), ylim=(y[-1], y[0]))
            ax.figure.colorbar(drawn, ax=ax, label=label)
        return result

    @property
    def delays(self) -> Any:
        """The edges of the bins of delay, as they were given."""
        return self._edges["delays"]
