"""The runs with radar shapes and with ellipsoids, what is measured in each, and the report."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import fullbody
import numpy as np
from fullbody import Body, Ellipsoid, Run, Verner98, observables
from fullbody.plots._style import LINES, legend, matplotlib

from ..publishing import publish, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["measure", "runs", "write"]

#: A Julian year and the spacing of samples, hours.
YEAR, SPACING = 8766.0, 0.5


def equivalent(body: Body) -> Ellipsoid:
    """The homogeneous ellipsoid with the moments of inertia per mass of a body."""
    moments = np.asarray(body.inertia) / float(body.mass)
    squares = 2.5 * (moments.sum() - 2.0 * moments)
    return Ellipsoid(*np.sqrt(squares))


def runs(until: float, progress: bool = False) -> dict[str, tuple[Run, float]]:
    """A run with the radar shapes and one with the equivalent ellipsoids from one start, each with its CPU seconds."""
    radar, state = fullbody.systems.kw4(shape="radar")
    smooth = radar
    for index, body in enumerate(radar.bodies):
        smooth = smooth.with_body(index, equivalent(body), mass=body.mass)
    found = {}
    for name, system in {"radar shapes": radar, "ellipsoids": smooth}.items():
        started = time.process_time()
        run = system.integrate(
            state, until, output=SPACING, integrator=Verner98(1e-13, 1e-13), progress=progress and name
        )
        found[name] = run, time.process_time() - started
    return found


def measure(run: Run) -> dict[str, float]:
    """Drifts, periods, slow rates and the libration of Beta, with angles in degrees, times in hours and days."""
    precession = observables.orbit_precession(run)
    libration = observables.libration(run)
    elements = run.elements()
    momentum = run.angular_momentum
    energy = run.system.energy(run[0])
    change = np.abs(run.energy - run.energy[0]).max()
    rate = np.degrees(24.0)
    return {
        "mean period, h": float(observables.mutual_period(run).mean),
        "smallest eccentricity": float(elements.e.min()),
        "largest eccentricity": float(elements.e.max()),
        "apsidal rate, deg/day": np.nan if precession.apsidal is None else rate * float(precession.apsidal),
        "nodal rate, deg/day": np.nan if precession.nodal is None else rate * float(precession.nodal),
        "libration amplitude, deg": np.nan if libration.amplitude is None else np.degrees(float(libration.amplitude)),
        "libration period, h": np.nan if libration.period is None else float(libration.period),
        "energy drift": change / abs(run.energy[0]),
        "energy drift, of the orbit's": change / abs(energy.potential + energy.translational),
        "angular momentum drift": np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0]),
        "evaluations": float(run.statistics.evaluations),
    }


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything and write the report."""
    found = runs(200.0 if draft else YEAR, progress)
    measured = {name: measure(run) | {"CPU time, s": seconds} for name, (run, seconds) in found.items()}
    numbers = {"program": f"fullbody {fullbody.__version__}", "draft": draft, **measured}
    return publish(folder, _text(measured, draft), {"libration": _figure(found)}, numbers)


def _text(measured: dict[str, dict[str, float]], draft: bool) -> str:
    radar, smooth = measured.values()
    rows = [[name, f"{radar[name]:.6g}", f"{smooth[name]:.6g}", f"{radar[name] - smooth[name]:+.3g}"] for name in radar]
    return f"""# 1999 KW4 with its radar shapes

{"A draft of 200 hours. " if draft else ""}A year of (66391) 1999 KW4 in exact gravity at the tolerance 1e-13, once with
the radar shapes of Ostro et al. (2006), 9,168 and 2,292 faces, and once with the homogeneous ellipsoids of the same
masses and moments of inertia. Both start from the same state. The ellipsoids have the quadrupole of the shapes, so that
the differences come from the harmonics of degree 3 and above.

{table(["", "radar shapes", "ellipsoids", "difference"], rows)}

![Libration of Beta](libration.png)
"""


def _figure(found: dict[str, tuple[Run, float]]) -> Figure:
    """The libration of Beta in the first 200 hours."""
    figure: Figure = matplotlib("figure").Figure(figsize=(8.0, 3.5), layout="constrained")
    ax = figure.subplots()
    for (name, (run, _)), style in zip(found.items(), LINES, strict=False):
        libration = observables.libration(run[run.time <= 200.0])
        ax.plot(libration.time, np.degrees(libration.angle), label=name, **style)
    ax.set(xlabel="time (h)", ylabel="angle of Beta's long axis (deg)")
    legend(ax)
    return figure
