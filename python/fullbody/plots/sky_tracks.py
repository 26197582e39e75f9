"""The track of a body on the sky relative to another, with astrometry."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import figures
from ..base.kinds import instance
from ..base.units import without_unit
from ..observing.astrometry import Astrometry
from ..record.record import Record
from . import _style

#: The number of revolutions up to which all are drawn; of more, one is drawn.
_REVOLUTIONS = 3.0
#: The number of points of the track for each revolution.
_POINTS = 200


def sky_track(run: Record, data: Astrometry, ax: Any = None, **kwargs: Any) -> Any:
    """Draw the track of a run on the sky, the observed offsets with their errors, and lines to the predicted ones.

    Of many revolutions between the first and the last observation, the track is one in the middle of them. North is up
    and east to the left.

    Parameters
    ----------
    run : Run
        A run with ``dense=True`` over the observations.
    data : fullbody.observing.Astrometry
    ax : matplotlib Axes, optional
        Those to draw on, which are returned.
    **kwargs
        Passed to ``Axes.plot`` for the track.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInput
        If the run does not cover the observations.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing, plots
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> view = observing.Geometry([0.0, 12.0] * u.h, to_observer=[0.0, 0.0, 0.08] * u.au, frame="ecliptic")
    >>> times, zero = [1.0, 2.0] * u.h, [0.0, 0.0] * u.mas
    >>> data = observing.Astrometry(times, zero, zero, 1.0 * u.mas, body="Dimorphos", about="Didymos", geometry=view)
    >>> plots.sky_track(system.integrate(state, 3.0, dense=True), data).get_xlabel()
    'offset to the east [mas]'
    """
    instance(data, "data", Astrometry, "an observing.Astrometry")
    kwargs = figures.full_option_names(kwargs)
    ax = figures.single(ax, (5.5, 5.0))
    body, about = run.context.pair(data.body, data.about, " of Astrometry")
    predicted = without_unit(data.predict(run))
    observed = np.stack([without_unit(data.east), without_unit(data.north)], axis=1)
    times, revolutions = _times_of_track(run, data, body, about)
    zero = np.zeros(len(times)) if data.unit is None else np.zeros(len(times)) * data.unit
    error = 1.0 if data.unit is None else 1.0 * data.unit
    options = {name: getattr(data, name) for name in ("body", "about", "geometry", "frame", "photocentre")}
    track = without_unit(Astrometry(times, zero, zero, error, **options).predict(run))
    name = "track" if revolutions <= _REVOLUTIONS else "one turn of the track"
    ax.plot(*track.T, **figures.line(0, {"label": name, **kwargs}))
    for pair in zip(observed, predicted, strict=True):
        ax.plot(*np.transpose(pair), color="0.4", linewidth=0.7)
    errors = without_unit(data.sigma).T
    dots = {"linestyle": "none", "marker": ".", "markersize": 5.0, "elinewidth": 0.8}
    ax.errorbar(*observed.T, errors[1], errors[0], color="#D55E00", label="observed", **dots)
    ax.plot(0.0, 0.0, marker="+", color="black", linestyle="none", label=_style.label_of(run, about))
    unit = "rad" if data.unit is None else data.unit.to_string("unicode")
    ax.set(xlabel=f"offset to the east [{unit}]", ylabel=f"offset to the north [{unit}]")
    ax.set_aspect("equal", adjustable="datalim")
    if not ax.xaxis_inverted():
        ax.invert_xaxis()
    figures.grid(ax)
    figures.legend(ax, markerscale=1.0)
    return ax


def _times_of_track(run: Record, data: Astrometry, body: int, about: int) -> tuple[Any, float]:
    """Return times for a track, in the form of those of the observations, and how many revolutions these cover."""
    first, last = data.times[0], data.times[-1]
    span = last - first
    emitted = without_unit(data.emission(run.system))
    a = float(np.median(without_unit(run.elements(body=body, about=about).a)))
    mean_motion = np.sqrt(run.context.mu(body, about) / a**3) if a > 0.0 else 0.0
    revolutions = float(np.ptp(emitted) * mean_motion / (2.0 * np.pi))
    if revolutions <= _REVOLUTIONS:
        return first + span * np.linspace(0.0, 1.0, 1 + int(_POINTS * max(1.0, revolutions))), revolutions
    middle = int(np.argmin(np.abs(emitted - np.mean(emitted[[0, -1]]))))
    part = np.clip((emitted[middle] - emitted[0]) / np.ptp(emitted), 0.5 / revolutions, 1.0 - 0.5 / revolutions)
    return first + span * (part + np.linspace(-0.5, 0.5, 1 + _POINTS) / revolutions), revolutions
