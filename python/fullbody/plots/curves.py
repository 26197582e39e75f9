"""Curves against time: angles, elements, energy, libration, spins, work."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import figures, rotations
from ..base.figures import full_option_names, line, single
from ..base.kinds import choice
from ..base.units import without_unit
from ..errors import InvalidInput
from ..observables import roll_pitch_yaw
from ..record import conserved
from ..record.record import Record
from . import _style, lines
from ._style import ArrayOfAxes, RunPlots, label, label_axes, label_of, time_label, times
from .between import dense_attitudes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SYMBOLS = (r"$\phi$", r"$\theta$", r"$\psi$")
#: Name, symbol and description of each element.
_ELEMENTS = (
    ("a", "$a$", "semi-major axis"),
    ("e", "$e$", "eccentricity"),
    ("i", "$i$", "inclination"),
    ("Omega", r"$\Omega$", "ascending node"),
    ("omega", r"$\omega$", "periapsis"),
    ("M", "$M$", "mean anomaly"),
)
_DRIFTS = {
    "energy_drift": "energy / total",
    "energy_drift_orbital": "energy / orbital",
    "angular_momentum_drift": "angular momentum",
}
#: Half the spacing of doubles at 1, the smallest relative change that exists.
_FLOOR = 0.5 * float(np.finfo(np.float64).eps)
#: The range of yaw in radians above which a body rotates relative to the line to the other body instead of librating.
_FULL_TURN = 2.0 * np.pi
#: The ratio of the largest to the smallest work above which a linear axis would show the smallest as zero.
_LINEAR_RATIO = 30.0
#: The longest name of a force that is shown in full, in characters.
_NAME = 24


def angles(plots: RunPlots, ax: Any = None, *, bodies: Sequence[int | str] | None = None, **kwargs: Any) -> ArrayOfAxes:
    """Draw Tait-Bryan angles in degrees: a row for each body, with phi, theta and psi in a panel each.

    An angle of too many turns to be seen is drawn as its departure from a uniform rotation, whose rate nu is in the
    legend.

    Parameters
    ----------
    ax : array of matplotlib Axes, optional
        Three for each body; ``axes`` is another name of the argument.
    bodies : sequence of int or str, optional
        Indices in the system, or names; by default all bodies.
    """
    run, ax, kwargs = plots.sampled(), kwargs.pop("axes", ax), full_option_names(kwargs)
    indices = _style.body_indices(run, bodies)
    flat, result = figures.panels(ax, (len(indices), 3), (10.0, 0.4 + 2.2 * len(indices)))
    moments, attitude = dense_attitudes(run)
    time = times(run, moments)
    for row, body in enumerate(indices):
        values = np.rad2deg(rotations.tait_bryan(attitude[:, body]))
        for ax, symbol, angle in zip(flat[3 * row : 3 * row + 3], _SYMBOLS, values.T, strict=True):
            name = lines.draw_angle(ax, time, angle, line(0, kwargs), symbol, _style.unit_of_rate(run))
            body_name = f"{label_of(run, body)}\n" if symbol == _SYMBOLS[0] else ""
            label_axes(ax, f"{body_name}{name} [deg]")
            lines.degrees(ax)
    for ax in flat[-3:]:
        time_label(ax, run)
    return result


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
    """Draw osculating elements, with angles in degrees.

    Parameters
    ----------
    ax : array of matplotlib Axes, optional
        One for each of ``names``, by default (3, 2) for all; ``axes`` is another name of the argument.
    mu, body, about
        Options of :meth:`fullbody.Run.elements`.
    names : sequence of str
        Those of a, e, i, Omega, omega, M that are drawn.
    """
    run, ax = plots.sampled(), kwargs.pop("axes", ax)
    body, about = run.context.index(body, "body"), run.context.index(about, "about")
    rows = [row for row in _ELEMENTS if row[0] in names]
    flat, result = figures.panels(ax, (3, 2) if len(rows) == 6 else (len(rows),), (9.0, 6.5))
    values = run.elements(mu, body=body, about=about)
    orbit = "" if len(run.context) == 2 else f", {label_of(run, body)} about {label_of(run, about)}"
    for ax, (name, symbol, text) in zip(flat, rows, strict=True):
        value, style = without_unit(getattr(values, name)), line(0, full_option_names(kwargs))
        if name in ("a", "e"):
            lines.draw(ax, times(run), value, style)
            label_axes(ax, label(run, symbol, "length") if name == "a" else symbol, text + orbit)
        else:
            symbol = lines.draw_angle(ax, times(run), np.rad2deg(value), style, symbol, _style.unit_of_rate(run))
            label_axes(ax, f"{symbol} [deg]", text + orbit)
            lines.degrees(ax)
        ax.ticklabel_format(axis="y", useOffset=False)
        # The changes of an eccentricity are compared with one, not with its size.
        lines.steady(ax, 1e-3 if name == "e" else 0.0)
    for ax in flat[-2:] if len(rows) == 6 else flat[-1:]:
        time_label(ax, run)
    return result


def energy(plots: RunPlots, ax: Any = None, **kwargs: Any) -> Axes:
    """Draw the drift of the energy, relative to the total and to the orbit's energy, and of the angular momentum.

    The axis is logarithmic; samples with a drift of exactly zero are left out. The orbit's energy is potential +
    translational.
    """
    run = plots.sampled()
    ax, kwargs = single(ax, (7.0, 3.2)), full_option_names(kwargs)
    for index, (of, name) in enumerate(_DRIFTS.items()):
        # A drift relative to zero is left out: a single body has no orbital energy, one at rest no angular momentum.
        if not conserved.size(of, run.invariants):
            continue
        drift = getattr(run, of)
        # Zero has no logarithm: the line joins the neighbouring samples.
        changed = drift != 0.0
        name = name if changed.any() else f"{name}: no change"
        lines.draw(ax, times(run)[changed], np.abs(drift[changed]), line(index, {"label": name, **kwargs}))
    ax.set_yscale("log")
    largest = ax.dataLim.y1 if np.isfinite(ax.dataLim.y1) else 0.0
    ax.set_ylim(_FLOOR / 2, 10.0 * max(largest, _FLOOR))
    label_axes(ax, "|relative drift|")
    time_label(ax, run)
    return ax


def libration(plots: RunPlots, ax: Any = None, *, body: int | str = 1, about: int | str = 0, **kwargs: Any) -> Axes:
    """Draw roll, pitch and yaw of a body in its orbit's frame, in degrees.

    For a body that rotates relative to the line between the bodies, or whose samples are too far apart to follow
    its attitude, the angle of its z-axis from the orbit's normal is drawn instead; see
    :func:`fullbody.observables.roll_pitch_yaw`.

    Parameters
    ----------
    body, about : int or str
        Indices in the system, or names, of bodies that do not move along a line.
    """
    run, kwargs = plots.sampled(), full_option_names(kwargs)
    body, about = run.context.index(body, "body"), run.context.index(about, "about")
    curves = _attitude(run, body, about)
    ax = single(ax, (7.0, 3.2))
    for index, (name, angle) in enumerate(curves.items()):
        style = line(index, {"label": name, **kwargs} if len(curves) > 1 else kwargs)
        lines.draw_angle(ax, times(run), np.rad2deg(angle), style, name, _style.unit_of_rate(run))
    title = "z-axis from the orbit's normal" if len(curves) == 1 else "in its orbit's frame"
    if len(run.context) > 2:
        title = f"{'tilt to' if len(curves) == 1 else 'in'} its orbit about {label_of(run, about)}"
    label_axes(ax, "angle [deg]", f"{label_of(run, body)}, {title}")
    lines.degrees(ax)
    time_label(ax, run)
    return ax


def _attitude(run: Record, body: int, about: int) -> dict[str, Any]:
    """Return roll, pitch and yaw (K,) of a body that librates, or the tilt of the z-axis of one that does not."""
    r, v = (run.arrays[name][:, body] - run.arrays[name][:, about] for name in ("position", "velocity"))
    normal = np.cross(r, v)
    try:
        values = np.asarray(roll_pitch_yaw(run, body=body, about=about))
        if np.ptp(values[:, 2]) <= _FULL_TURN:
            return dict(zip(("roll", "pitch", "yaw"), values.T, strict=True))
    except InvalidInput:
        # Samples too far apart to follow the attitude still give the tilt; motion along a line has no orbital frame.
        if not normal.any(axis=1).all():
            raise
    axis = _style.matrices(run, body)[:, :, 2]
    return {"tilt": np.arctan2(np.linalg.norm(np.cross(normal, axis), axis=1), np.sum(normal * axis, axis=1))}


def spins(
    plots: RunPlots, ax: Any = None, *, bodies: Sequence[int | str] | None = None, frame: str = "body", **kwargs: Any
) -> ArrayOfAxes:
    """Draw angular velocities, one panel per body.

    Parameters
    ----------
    ax : array of matplotlib Axes, optional
        One for each body; ``axes`` is another name of the argument.
    bodies : sequence of int or str, optional
        Indices in the system, or names; by default all bodies.
    frame : {"body", "inertial"}
        The frame of the components.
    """
    choice(frame, "frame", ("body", "inertial"))
    run, ax, kwargs = plots.sampled(), kwargs.pop("axes", ax), full_option_names(kwargs)
    indices = _style.body_indices(run, bodies)
    flat, result = figures.panels(ax, (len(indices),), (7.0, 0.4 + 2.2 * len(indices)))
    for body, ax in zip(indices, flat, strict=True):
        spin = run.arrays["spin"][:, body]
        if frame == "inertial":
            spin = np.einsum("kij,kj->ki", _style.matrices(run, body), spin)
        for component, letter in enumerate("xyz"):
            style = line(component, {"label": rf"$\omega_{letter}$", **kwargs})
            lines.draw(ax, times(run), spin[:, component], style, np.ptp(spin))
        label_axes(ax, label(run, "spin", "spin"), f"{label_of(run, body)}, {frame} frame")
        ax.ticklabel_format(axis="y", useOffset=False)
        lines.steady(ax)
    time_label(flat[-1], run)
    return result


def work(plots: RunPlots, ax: Any = None, **kwargs: Any) -> Axes:
    """Draw the energy that each external force has added since the start of the run, in joules for a system with units.

    If the largest work exceeds the smallest more than thirty times, the axis is linear up to the largest work of
    the smallest force and logarithmic beyond.
    """
    run = plots.sampled()
    forces = list(run.context.forces)
    if not forces:
        raise InvalidInput("the run has no external forces; expected a system with some to draw their work")
    ax, kwargs = single(ax, (7.0, 3.2)), full_option_names(kwargs)
    units = run.context.units
    factor, unit = (float(units.unit("energy").to("J")), "J") if units.defined else (1.0, "system units")
    energies = factor * run.arrays["work"]
    sizes = np.abs(energies).max(axis=0)
    for index, force in enumerate(forces):
        name = _style.escaped(_style.short(force, _NAME))
        name = name if sizes[index] > 0.0 else f"{name}: none"
        lines.draw(ax, times(run), energies[:, index], line(index, {"label": name, **kwargs}))
    sizes = sizes[sizes > 0.0]
    if len(sizes) and sizes.max() > _LINEAR_RATIO * sizes.min():
        # The axis is linear over all of the smallest force's work, then logarithmic.
        threshold = 10.0 ** np.ceil(np.log10(sizes.min()))
        ax.set_yscale("symlog", linthresh=threshold, linscale=1.5)
        locator = figures.matplotlib("ticker").SymmetricalLogLocator(base=10.0, linthresh=threshold)
        # The number of ticks is small enough for a page of plots too.
        locator.set_params(numticks=5)
        ax.yaxis.set_major_locator(locator)
    label_axes(ax, f"work [{unit}]")
    time_label(ax, run)
    return ax
