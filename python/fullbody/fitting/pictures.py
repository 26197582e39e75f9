"""Plots of a fit, for :attr:`fullbody.fitting.Fit.plot`."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.figures import LINES, grid, legend, matplotlib, panels
from ..base.kinds import whole_number
from ..base.units import need, without_unit
from ..errors import InvalidInput
from ..observing.astrometry import Astrometry
from ..plots.sky_tracks import sky_track
from .uncertainty import rows_of


class FitPlots:
    """The plots of a fit.

    Parameters
    ----------
    fit : Fit
    """

    def __init__(self, fit: Any) -> None:
        self._fit = fit

    def __repr__(self) -> str:
        names = ", ".join(name for name in vars(FitPlots) if not name.startswith("_"))
        return f"<plots of a fit: {names}>"

    def residuals(self, ax: Any = None, **kwargs: Any) -> Any:
        """Draw the pulls, which are residuals over their errors, one panel for each of the observations.

        Parameters
        ----------
        ax : array of matplotlib Axes, optional
            Axes to draw on, one for each of the observations.
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, or the axes given
        """
        fit = self._fit
        flat, result = panels(kwargs.pop("axes", ax), (len(fit.pulls),), (7.0, 2.2 * len(fit.pulls) + 0.4))
        # A fit from a file has no observations to name the numbers of a row.
        observations = fit.observations or [None] * len(flat)
        for axes, label, times, pulls, data in zip(flat, fit.labels, fit.times, fit.pulls, observations, strict=True):
            unit = getattr(times, "unit", None)
            columns = np.reshape(pulls, (len(pulls), -1))
            across = without_unit(times)
            if len(across) != len(columns):
                # A measured value has no time.
                across = np.full(len(columns), across.max(initial=0.0))
            for k, column in enumerate(columns.T):
                style = {"marker": "os^v"[k % 4], "markersize": 3.5, "linestyle": "", "color": LINES[k]["color"]}
                if columns.shape[1] > 1:
                    style["label"] = dict(enumerate(getattr(data, "components", ()))).get(k, f"number {k + 1} of a row")
                axes.plot(across, column, **style | kwargs)
            axes.axhspan(-1.0, 1.0, color="0.92", zorder=0)
            axes.set_ylabel("residual / error")
            axes.set_title(label, fontsize="medium", loc="left")
            axes.set_xlabel("time since the epoch" + (f" [{unit}]" if unit is not None else ""))
            grid(axes)
            legend(axes, markerscale=1.0)
        return result

    def sky(self, ax: Any = None, *, data: int | None = None, **kwargs: Any) -> Any:
        """Draw the fitted track of a body on the sky, with the observed offsets; see :func:`fullbody.plots.sky_track`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Those to draw on, which are returned.
        data : int, optional
            The index of the astrometry among the observations; by default the first.
        **kwargs
            Passed to ``Axes.plot`` for the track.

        Returns
        -------
        Axes

        Raises
        ------
        InvalidInput
            For observations that are no astrometry, and for a fit from a file, which has none.
        """
        observations = self._fit.observations
        indices = [index for index, entry in enumerate(observations) if isinstance(entry, Astrometry)]
        if not indices or data not in (None, *indices):
            text = f"the index {' or '.join(map(str, indices))}" if indices else "a fit of an observing.Astrometry"
            raise InvalidInput(f"the fit has no astrometry to draw for data={data}; expected {text}")
        return sky_track(self._fit.run, observations[indices[0] if data is None else data], ax, **kwargs)

    def corner(self, samples: Any = None, *, n: int = 5000, rng: int | np.random.Generator = 0, **kwargs: Any) -> Any:
        """Draw the distributions of all parameters and of all pairs of them.

        Parameters
        ----------
        samples : xarray.Dataset, optional
            What :meth:`fullbody.fitting.Fit.sample` returns; draws from the normal distribution of the fit unless
            given.
        n : int
            Number of these draws.
        rng : int or numpy Generator
        **kwargs
            Passed to ``corner.corner``.

        Returns
        -------
        matplotlib Figure
        """
        matplotlib()
        with need("fit", "a corner plot"):
            import corner

        fit = self._fit
        if samples is None:
            rows = fit.draws_as_array(whole_number(n, "n", len(fit.parameters) + 1), rng)
        else:
            rows = rows_of(samples, fit.parameters)
        units = zip(fit.parameters.names, fit.parameters.units, strict=True)
        labels = [name if unit is None else f"{name} [{unit}]" for name, unit in units]
        truths = fit.numbers[: len(labels)].tolist()
        # Panels are so small that the texts have the size of those of other plots, with room for numbers and labels.
        side, room = 1.4 * len(labels) + 1.1, 1.0
        style: dict[str, Any] = {"labels": labels, "truths": truths, "max_n_ticks": 3, "labelpad": 0.25}
        if "fig" not in kwargs:
            style["fig"] = matplotlib().figure(figsize=(side, side))
        figure = corner.corner(rows, **style | kwargs)
        if "fig" not in kwargs:
            figure.subplots_adjust(left=room / side, bottom=room / side)
        for ax in figure.axes:
            for axis in (ax.xaxis, ax.yaxis):
                # A common part of the numbers beside the axis would be overlooked.
                if hasattr(axis.get_major_formatter(), "set_useOffset"):
                    axis.get_major_formatter().set_useOffset(False)
        return figure
