"""Osculating elements against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import _style
from ._style import ArrayOfAxes, RunPlots

#: Name, symbol and description of each element.
_ROWS = (
    ("a", "$a$", "semi-major axis"),
    ("e", "$e$", "eccentricity"),
    ("i", "$i$", "inclination"),
    ("Omega", r"$\Omega$", "ascending node"),
    ("omega", r"$\omega$", "periapsis"),
    ("M", "$M$", "mean anomaly"),
)


def elements(
    plots: RunPlots,
    ax: Any = None,
    *,
    mu: Any = None,
    body: int | str = 1,
    about: int | str = 0,
    names: Sequence[str] = ("a", "e", "i", "Omega", "omega", "M"),
    **kwargs: Any,
) -> ArrayOfAxes:
    """Draw osculating a, e, i, Omega, omega, M against time, with angles in degrees.

    Parameters
    ----------
    ax : array of matplotlib Axes, optional
        Axes to draw on, one for each of ``names``; ``axes`` is another name of the argument.
    mu, body, about
        Options of :meth:`fullbody.Run.elements`.
    names : sequence of str
        Those of the six elements that are drawn.
    **kwargs
        Passed to ``Axes.plot``.

    Returns
    -------
    ndarray of Axes, (3, 2) or the number of names, or the axes given
    """
    run, ax = plots.sampled(), kwargs.pop("axes", ax)
    body, about = _style.check_body(run, body, "body"), _style.check_body(run, about, "about")
    rows = [row for row in _ROWS if row[0] in names]
    shape = (3, 2) if len(rows) == 6 else (len(rows),)
    flat, result = _style.panels(ax, shape, (9.0, 6.5))
    values = run.elements(mu, body=body, about=about)
    time = _style.times(run)
    for ax, (name, symbol, text) in zip(flat, rows, strict=True):
        value = np.asarray(getattr(getattr(values, name), "value", getattr(values, name)))
        style = _style.line(0, _style.wishes(kwargs))
        if name == "a":
            ax.plot(time, value, **style)
            ax.set_ylabel(_style.label(run, symbol, "length"))
        elif name == "e":
            ax.plot(time, value, **style)
            ax.set_ylabel(symbol)
        else:
            _style.draw_angle(ax, time, np.rad2deg(value), style)
            ax.set_ylabel(f"{symbol} [deg]")
            _style.degrees(ax)
        ax.set_title(text, fontsize="medium", loc="left")
        ax.ticklabel_format(axis="y", useOffset=False)
        # The changes of an eccentricity are compared with one, not with its size.
        _style.steady(ax, 1e-3 if name == "e" else 0.0)
        _style.grid(ax)
    for ax in flat[-2:] if len(rows) == 6 else flat[-1:]:
        _style.time_label(ax, run)
    return result
