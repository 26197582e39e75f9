"""The runs with radar shapes and with ellipsoids, what is measured in each, and the report."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fullbody
import numpy as np
from fullbody import Run, System, Verner98, observables
from fullbody.base.figures import LINES, legend, matplotlib

from ..publishing import formatted, publish, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["CAPTION", "by_degree", "measure", "runs", "tables", "write"]

#: A Julian year, a quarter of it and the spacing of samples, hours.
YEAR, QUARTER, SPACING = 8766.0, 2191.5, 0.5
#: The tolerance of the gravity and of the integration.
TOLERANCE = 1e-13
#: Total degrees to which the mutual potential of the radar shapes is computed, to see what each degree adds.
DEGREES = (2, 3, 4, 6)
#: Quantities of a run in the table of degrees.
COLUMNS = ("mean period, h", "largest eccentricity", "nodal rate, deg/day", "libration amplitude, deg")
CAPTION = "Libration of Beta in the first 200 hours."


def with_ellipsoids(system: System) -> System:
    """Return the system with homogeneous ellipsoids that have the bodies' masses and moments of inertia."""
    for index, body in enumerate(system.bodies):
        system = system.with_body(index, body.fitted_ellipsoid(), mass=body.mass)
    return system


def runs(until: float, progress: bool = False) -> dict[str, tuple[Run, float]]:
    """Return runs with radar shapes and with equivalent ellipsoids from one start, each with its CPU seconds."""
    radar, state = fullbody.systems.kw4(shape="radar", gravity_tolerance=TOLERANCE)
    smooth = with_ellipsoids(radar)
    results = {}
    for name, system in {"radar shapes": radar, "ellipsoids": smooth}.items():
        started = time.process_time()
        run = system.integrate(
            state, until, output=SPACING, integrator=Verner98(TOLERANCE, TOLERANCE), progress=progress and name
        )
        results[name] = run, time.process_time() - started
    return results


def by_degree(until: float) -> dict[str, dict[str, float]]:
    """Measure the radar shapes with their mutual potential to some total degrees, and the exact one."""
    radar, state = fullbody.systems.kw4(shape="radar")
    systems = {f"degree {n}": radar.with_options(gravity=f"multipole:{n}") for n in DEGREES} | {"exact": radar}
    integrator = Verner98(1e-10, 1e-10)
    return {
        name: measure(system.integrate(state, until, output=SPACING, integrator=integrator))
        for name, system in systems.items()
    }


def measure(run: Run) -> dict[str, float]:
    """Return drifts, periods, slow rates and the libration of Beta, with angles in degrees, times in hours and days."""
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
        "energy drift, relative to the orbit's energy": change / abs(energy.potential + energy.translational),
        "angular momentum drift": np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0]),
        "evaluations": float(run.statistics.evaluations),
    }


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything and write the report."""
    result = runs(200.0 if draft else YEAR, progress)
    measured = {name: measure(run) | {"CPU time, s": seconds} for name, (run, seconds) in result.items()}
    numbers = {
        "draft": draft,
        "year": measured,
        "degrees": by_degree(200.0 if draft else QUARTER),
    }
    return publish(folder, {"libration": _figure(result)}, numbers, _text)


def tables(numbers: Mapping[str, Any]) -> dict[str, str]:
    """Return the tables of the report as Markdown, by name; a dash for a rate that a run does not define."""
    radar, smooth = (numbers["year"][name] for name in ("radar shapes", "ellipsoids"))
    rows = [[name, *(formatted(run[name], ".5g") for run in (radar, smooth))] for name in radar]
    degrees = [
        [name, *(formatted(row[column], ".5g") for column in COLUMNS)] for name, row in numbers["degrees"].items()
    ]
    return {
        "year": table(["", "radar shapes", "ellipsoids"], rows),
        "degrees": table(["mutual potential", *COLUMNS], degrees),
    }


def _text(numbers: Mapping[str, Any]) -> str:
    parts = tables(numbers)
    return f"""# 1999 KW4 with its radar shapes

{numbers["program"]}{", a draft of 200 hours" if numbers["draft"] else ""}. A year of (66391) 1999 KW4 in exact gravity
at the tolerance 1e-13, once with the radar shapes of Ostro et al. (2006), 9,168 and 2,292 faces, and once with the
homogeneous ellipsoids of the same masses and moments of inertia. Both start from the same state. The ellipsoids have
the quadrupoles of the shapes, so that the differences come from the harmonics of degree 3 and above.

{parts["year"]}

![{CAPTION}](libration.png)

A quarter of a year of the radar shapes at the tolerance 1e-10, with their mutual potential to a total degree:

{parts["degrees"]}
"""


def _figure(result: dict[str, tuple[Run, float]]) -> Figure:
    """Draw the libration of Beta in the first 200 hours."""
    figure: Figure = matplotlib("figure").Figure(figsize=(8.0, 3.5), layout="constrained")
    ax = figure.subplots()
    for (name, (run, _)), style in zip(result.items(), LINES, strict=False):
        libration = observables.libration(run[run.time <= 200.0])
        ax.plot(libration.time, np.degrees(libration.angle), label=name, **style)
    ax.set(xlabel="time (h)", ylabel="angle of Beta's long axis (deg)")
    legend(ax)
    return figure
