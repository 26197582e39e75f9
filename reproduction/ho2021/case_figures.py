"""The figures of the dimensionless cases, panel by panel as in the paper's Figs. 2 to 6."""

from __future__ import annotations

from typing import Any

import numpy as np
from fullbody import Run
from fullbody.base.figures import LINES, grid, legend

from . import cases
from .drawing import floor, largest, new_figure, positive, power
from .results import Runs

__all__ = ["all_figures"]

_BODIES = ("A", "B")
#: The energies with the paper's colours, each with different dashes.
_ENERGIES = (
    ("potential $U$", "potential_energy", LINES[3]),
    ("translational $E_k$", "translational_energy", LINES[4]),
    ("rotational $E_{rot}$", "rotational_energy", {**LINES[1], "linestyle": (0, (1, 1.2))}),
    ("total $E_{tot}$", "energy", LINES[0]),
)
_TIME = "time (dimensionless)"
#: The length of time in which case 2's angles, which make some 60 revolutions, are enlarged.
_ZOOM = 20.0
#: The step between the fine samples that are drawn.
_THINNING = 5
#: The length of the windows in which the largest errors of the angular momentum are drawn.
_WINDOW = 4.0


def all_figures(runs: Runs) -> dict[str, Any]:
    """Return the figures by name."""
    steps = runs.cases
    thinned = {number: run[::_THINNING] for number, run in runs.fine.items()}
    return {
        "case1": motion(thinned[1], 1),
        "case1_force": force(thinned[1], cases.forces(thinned[1])),
        "case1_energy": energy(steps[1], 1),
        "case2": motion(thinned[2], 2),
        "case2_energy": energy(steps[2], 2),
    }


def motion(run: Run, number: int) -> Any:
    """Draw (a) orbits, (b) z, (c, d) sines of the angles, (e, f) spins; the fast angles of case 2 also in part."""
    fast = number == 2
    heights = (1.0, 0.45, 1.0, 1.0) if fast else (1.0, 1.0, 1.0)
    figure, axes = new_figure(len(heights), 2, (9.0, 10.5 if fast else 9.0), height_ratios=heights)
    exponent = power(run.position[..., 2])
    sine_values = np.sin(cases.angles(run))
    for body, name in enumerate(_BODIES):
        x, y, z = run.position[:, body].T
        axes[0, 0].plot(x, y, linewidth=0.9, label=name, **LINES[body])
        axes[0, 1].plot(run.time, z / 10.0**exponent, linewidth=0.9, label=name, **LINES[body])
        sines = sine_values[:, body]
        # Like the paper, the figure leaves out psi of case 2, which circulates, and its spin about z, which stays at 2.
        count = 2 if fast else 3
        rows = (axes[1, body], axes[2, body]) if fast else (axes[1, body],)
        for k, angle in enumerate((r"$\phi$", r"$\theta$", r"$\psi$")[:count]):
            for ax in rows:
                ax.plot(run.time, sines[:, k], linewidth=0.9, label=rf"$\sin$ {angle}", **LINES[k])
        rows[-1].set_ylabel(f"sines of the angles of {name}\n(dimensionless)")
        for k, axis in enumerate("xyz"[:count]):
            spin = run.spin[:, body, k]
            axes[-1, body].plot(run.time, spin, linewidth=0.9, label=rf"$\hat\omega_{axis}$", **LINES[k])
        axes[-1, body].set_ylabel(f"spin of {name}\n[rad per unit time]")
        if fast:
            rows[0].set_ylabel(f"sines of {name}\n(dimensionless)")
    axes[0, 0].set_xlabel("x (dimensionless)")
    axes[0, 0].set_ylabel("y (dimensionless)")
    axes[0, 0].set_aspect("equal", adjustable="datalim")
    axes[0, 1].set_ylabel(rf"z [$10^{{{exponent}}}$] (dimensionless)")
    letters = ("a", "b", "c", "d", "c", "d", "e", "f") if fast else tuple("abcdef")
    for ax, letter in zip(axes.flat, letters, strict=True):
        grid(ax)
        legend(ax)
        ax.set_title(f"({letter})", loc="left", fontsize="medium")
        if ax is not axes[0, 0]:
            ax.set_xlabel(_TIME)
            ax.margins(x=0)
    if fast:
        for ax, letter in zip(axes[2], "cd", strict=True):
            ax.set_xlim(0.0, _ZOOM)
            ax.set_title(f"({letter}) until {_ZOOM:g}", loc="left", fontsize="medium")
    figure.suptitle(f"Case {number}: motion of the two spheroids")
    return figure


def force(run: Run, forces: Any) -> Any:
    """Draw f_z on A."""
    figure, axes = new_figure(1, 1, (7.0, 3.2))
    ax = axes[0, 0]
    exponent = power(forces[:, 2])
    ax.plot(run.time, forces[:, 2] / 10.0**exponent, linewidth=0.9, **LINES[0])
    ax.set_xlabel(_TIME)
    ax.set_ylabel(rf"$F_z$ on A [$10^{{{exponent}}}$]" + "\n(dimensionless)")
    ax.margins(x=0)
    grid(ax)
    largest_force = np.abs(forces[:, :2]).max()
    figure.suptitle(f"Case 1: the force along z is round-off; along x and y it reaches {largest_force:.2f}")
    return figure


def energy(run: Run, number: int) -> Any:
    """Draw energies, and the errors from step to step (the paper's) and from the start."""
    figure, axes = new_figure(3, 1, (7.0, 8.5), sharex=True)
    top, middle, bottom = axes[:, 0]
    for name, values, style in _ENERGIES:
        top.plot(run.time, getattr(run, values), linewidth=1.3, label=name, **style)
    top.set_ylabel("energy (dimensionless)")
    _energy_errors(middle, run)
    momentum = run.angular_momentum
    for k, axis in enumerate("xyz"):
        change = largest(run.time[1:], np.diff(momentum[:, k]), _WINDOW)
        bottom.plot(*change, linewidth=1.2, label=f"$J_{axis}$", **LINES[k])
    bottom.set_title(f"step to step, largest in {_WINDOW:g} units of time", loc="left", fontsize="small")
    bottom.set_ylabel("error of the angular\nmomentum (dimensionless)")
    bottom.set_yscale("log")
    bottom.set_xlabel(_TIME)
    bottom.set_xlim(run.time[0], run.time[-1])
    for ax in axes[:, 0]:
        grid(ax)
        legend(ax)
    figure.align_ylabels()
    figure.suptitle(f"Case {number}: energies and errors")
    return figure


def _energy_errors(ax: Any, run: Run) -> None:
    step = np.abs(np.diff(run.energy) / run.energy[:-1])
    total, orbital = np.abs(run.energy_drift), np.abs(run.energy_drift_orbital)
    dots = {"linestyle": "none", "marker": ".", "markersize": 5.0, "markeredgewidth": 0.0, "color": "0.55"}
    ax.plot(*positive(run.time[1:], step), label=f"step to step ({np.mean(step == 0):.0%} are 0)", **dots)
    # Without initial spins all energy is orbital, and the two errors coincide.
    same = np.allclose(total, orbital, rtol=1e-6, atol=0.0)
    label = "from the start; all energy is orbital" if same else "from the start"
    if share := np.mean(total == 0):
        label += f" ({share:.0%} are 0)"
    ax.plot(*positive(run.time, total), linewidth=1.2, label=label, **LINES[0])
    if not same:
        label = "from the start, relative to the orbital energy"
        ax.plot(*positive(run.time, orbital), linewidth=1.2, label=label, **LINES[1])
    floor(ax, run.energy[0])
    ax.set_ylabel("error of the energy\n(relative)")
