"""Osculating elements against time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..record.record import Record
from ._style import (
    check_body,
    check_samples,
    degrees,
    draw_angle,
    grid,
    label,
    line,
    panels,
    steady,
    time_label,
    times,
    wishes,
)

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
    run: Record,
    axes: Any,
    *,
    mu: Any,
    body: int,
    about: int,
    names: tuple[str, ...] = ("a", "e", "i", "Omega", "omega", "M"),
    **kwargs: Any,
) -> Any:
    """Draw osculating elements; see :meth:`fullbody.plots.Plots.elements`. ``names`` chooses some of the six."""
    check_samples(run)
    body, about = check_body(run, body, "body"), check_body(run, about, "about")
    rows = [row for row in _ROWS if row[0] in names]
    shape = (3, 2) if len(rows) == 6 else (len(rows),)
    flat, result = panels(axes, shape, (9.0, 6.5))
    values = run.elements(mu, body=body, about=about)
    time = times(run)
    for ax, (name, symbol, text) in zip(flat, rows, strict=True):
        value = np.asarray(getattr(getattr(values, name), "value", getattr(values, name)))
        style = line(0, wishes(kwargs))
        if name == "a":
            ax.plot(time, value, **style)
            ax.set_ylabel(label(run, symbol, "length"))
        elif name == "e":
            ax.plot(time, value, **style)
            ax.set_ylabel(symbol)
        else:
            draw_angle(ax, time, np.rad2deg(value), style)
            ax.set_ylabel(f"{symbol} [deg]")
            degrees(ax)
        ax.set_title(text, fontsize="medium", loc="left")
        ax.ticklabel_format(axis="y", useOffset=False)
        # The changes of an eccentricity are compared with one, not with its size.
        steady(ax, 1e-3 if name == "e" else 0.0)
        grid(ax)
    for ax in flat[-2:] if len(rows) == 6 else flat[-1:]:
        time_label(ax, run)
    return result
