"""The figures of the dimensionless cases, panel by panel as in the paper's Figs. 2 to 6."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..plots._style import LINES, grid, legend
from ..run import Run
from . import cases
from .kw4_figures import positive

if TYPE_CHECKING:
    from .results import Results

__all__ = ["all_figures"]

_BODIES = ("A", "B")


def all_figures(results: Results) -> dict[str, Any]:
    """The figures by name."""
    one, two = results.case_runs[1], results.case_runs[2]
    return {
        "case1": motion(one, 1),
        "case1_force": force(one, results.case_forces),
        "case1_energy": energy(one, 1),
        "case2": motion(two, 2),
        "case2_energy": energy(two, 2),
    }


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def motion(run: Run, number: int) -> Any:
    """(a) orbits, (b) z, (c, d) sines of the angles, (e, f) spins."""
    figure, axes = _figure(3, 2, (9.0, 9.0))
    for body, name in enumerate(_BODIES):
        x, y, z = run.position[:, body].T
        axes[0, 0].plot(x, y, linewidth=0.8, label=name, **LINES[body])
        axes[0, 1].plot(run.time, z, linewidth=0.8, label=name, **LINES[body])
        sines = np.sin(cases.angles(run)[:, body])
        # As in the paper: psi of case 2 goes round, its spin about z stays at 2; neither is drawn.
        shown = 3 if number == 1 else 2
        for k, label in enumerate((r"$\phi$", r"$\theta$", r"$\psi$")[:shown]):
            axes[1, body].plot(run.time, sines[:, k], linewidth=0.8, label=rf"$\sin$ {label}", **LINES[k])
        for k, label in enumerate("xyz"[:shown]):
            axes[2, body].plot(
                run.time, run.spin[:, body, k], linewidth=0.8, label=rf"$\hat\omega_{label}$", **LINES[k]
            )
        axes[1, body].set_ylabel(f"sines of the angles of {name}")
        axes[2, body].set_ylabel(f"spin of {name} [rad per unit time]")
    axes[0, 0].set_xlabel("x")
    axes[0, 0].set_ylabel("y")
    axes[0, 0].set_aspect("equal", adjustable="datalim")
    axes[0, 1].set_ylabel("z")
    axes[0, 1].ticklabel_format(axis="y", style="sci", scilimits=(0, 0))
    for ax, letter in zip(axes.flat, "abcdef", strict=True):
        grid(ax)
        legend(ax)
        ax.set_title(f"({letter})", loc="left", fontsize="medium")
        if ax is not axes[0, 0]:
            ax.set_xlabel("time")
            ax.margins(x=0)
    figure.suptitle(f"Case {number}: motion of the two spheroids")
    return figure


def force(run: Run, forces: Any) -> Any:
    """F_z on A."""
    figure, axes = _figure(1, 1, (7.0, 3.2))
    ax = axes[0, 0]
    ax.plot(run.time, forces[:, 2], linewidth=0.8, **LINES[0])
    ax.set_xlabel("time")
    ax.set_ylabel("$F_z$ on A")
    ax.margins(x=0)
    grid(ax)
    largest = np.abs(forces[:, :2]).max()
    figure.suptitle(f"Case 1: the force along z is round-off; along x and y it reaches {largest:.2f}")
    return figure


def energy(run: Run, number: int) -> Any:
    """Energies, and the errors from step to step (the paper's) and from the start."""
    figure, axes = _figure(3, 1, (7.0, 8.5))
    top, middle, bottom = axes[:, 0]
    parts = (run.potential_energy, run.translational_energy, run.rotational_energy, run.energy)
    names = ("potential", "translational", "rotational", "total")
    for k, (values, name) in enumerate(zip(parts, names, strict=True)):
        top.plot(run.time, values, linewidth=1.0, label=name, **LINES[k])
    top.set_ylabel("energy")
    step = np.abs(np.diff(run.energy) / run.energy[:-1])
    middle.plot(run.time[1:], positive(step), ".", markersize=2, color="0.45", label="step to step")
    middle.plot(run.time, positive(np.abs(run.energy_drift)), linewidth=1.0, label="from the start", **LINES[0])
    orbital = positive(np.abs(run.energy_drift_orbital))
    middle.plot(run.time, orbital, linewidth=1.0, label="from the start, of the orbital energy", **LINES[1])
    middle.set_ylabel("relative energy error")
    momentum = run.angular_momentum
    for k, name in enumerate("xyz"):
        change = np.abs(np.diff(momentum[:, k]))
        style = {"color": LINES[k]["color"], "marker": "ox^"[k], "markersize": 2.0, "linestyle": "none"}
        bottom.plot(run.time[1:], positive(change), label=f"$J_{name}$", **style)
    bottom.set_ylabel("angular momentum error,\nstep to step")
    for ax in (middle, bottom):
        ax.set_yscale("log")
    for ax in axes[:, 0]:
        grid(ax)
        legend(ax, columns=4)
        ax.margins(x=0)
        ax.set_xlabel("time")
    figure.suptitle(f"Case {number}: energies and errors")
    return figure
