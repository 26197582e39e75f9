"""``fullbody kw4``: one year of the 1999 KW4 of Ho et al. (2021), both shapes, by both exact methods of gravity."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from ..base.atomic import replacing
from ..base.figures import matplotlib
from ..base.tables import Table, to_text
from ..base.units import without_unit
from ..errors import InvalidInput
from ..files.reading import netcdf
from ..motion.run import Run
from ..record.integrators import Integrator, Verner98
from ..systems import kw4_ho2021
from ..typing import Floats
from .options import add_quiet, add_until, hours
from .pictures import page

Shape = Literal["ellipsoid", "spheroid"]
SHAPES: tuple[Shape, ...] = get_args(Shape)
METHODS = ("surface", "focal")
#: The length of the run and the part of it over which Beta's spin is measured, in hours.
_YEAR, _SPIN = 365.25 * 24.0, 200.0
#: One in this number of steps is saved; the printed numbers come from all steps.
_STRIDE = 8


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "kw4",
        help="one year of 1999 KW4 with both shapes",
        description="Run one year of (66391) 1999 KW4 as Ho et al. (2021) start it, with both shapes and both exact "
        "methods of gravity, print its numbers, and write figures and data.",
    )
    add_options(parser)
    parser.set_defaults(run=run)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the year."""
    parser.add_argument("--out", type=Path, default=Path("out/kw4"), help="folder for figures and data (%(default)s)")
    parser.add_argument("--gravity", choices=(*METHODS, "both"), default="both", help="method (%(default)s)")
    add_until(parser, "the end, a year unless given: a number of hours", type=hours, default=_YEAR)
    parser.add_argument("--rtol", type=float, default=1e-13, help="tolerance of a step (%(default)s)")
    add_quiet(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run, print, write."""
    numbers: dict[Shape, dict[str, dict[str, Any]]] = {shape: {} for shape in SHAPES}
    figures = {}
    for shape, method, year, seconds in years(arguments):
        numbers[shape][method] = measure(year, seconds)
        figures[f"page_{shape}"] = page(year[::_STRIDE])
    header = ("", *numbers["ellipsoid"])
    for shape, columns in numbers.items():
        rows = [(name, *(_text(column[name]) for column in columns.values())) for name in columns[header[1]]]
        if not arguments.quiet:
            print(to_text(Table(f"1999 KW4, {shape}s, {arguments.until:g} hours", header, list(rows))), end="\n\n")
    write(arguments.out, figures, numbers)
    if not arguments.quiet:
        print(written(arguments.out))
    return 0


def years(arguments: argparse.Namespace) -> Iterator[tuple[Shape, str, Run, float]]:
    """Run the years that the options ask for and save them; yield shape, method, run and CPU time in seconds."""
    if not 0.0 < arguments.until < float("inf"):
        raise InvalidInput(f"--until is {arguments.until:g}; expected hours above zero")
    # A missing package is reported before the work, not after it.
    netcdf()
    matplotlib("figure")
    arguments.out.mkdir(parents=True, exist_ok=True)
    integrator = Verner98(arguments.rtol, arguments.rtol)
    for shape in SHAPES:
        for method in METHODS if arguments.gravity == "both" else (arguments.gravity,):
            title = False if arguments.quiet else f"{shape}s, {method}"
            year, seconds = run_year(shape, method, arguments.until, integrator=integrator, progress=title)
            year[::_STRIDE].save(arguments.out / f"kw4_{shape}_{method}.nc")
            yield shape, method, year, seconds


def run_year(
    shape: Shape, method: str, until: float = _YEAR, *, integrator: Integrator | None = None, progress: Any = False
) -> tuple[Run, float]:
    """Integrate the paper's start and record every step; return the run and its CPU time in seconds."""
    system, state = kw4_ho2021(shape, gravity=method, units=True)
    started = time.process_time()
    year = system.integrate(state, until, integrator=integrator or Verner98(1e-13, 1e-13), progress=progress)
    return year, time.process_time() - started


def measure(year: Run, seconds: float = 0.0) -> dict[str, Any]:
    """Measure elements, Beta's spin in 1e-5 rad/s and errors since the start, on a run in km, hour, kg."""
    orbit = year.elements()
    a, hours = without_unit(orbit.a), without_unit(year.time)

    def mean(values: Any) -> float:
        return float(np.trapezoid(values, hours) / np.ptp(hours))

    ranges = map(tuple, spin_range(year.system, year[0]).tolist())
    return {
        "e_max": float(np.max(orbit.e)),
        "e_mean": mean(orbit.e),
        "a_min": float(a.min()),
        "a_max": float(a.max()),
        "a_mean": mean(a),
        "period": mean(without_unit(orbit.period(year.system.mu()))),
        **{f"spin_{axis}": span for axis, span in zip("xyz", ranges, strict=True)},
        "energy_drift": float(np.max(np.abs(year.energy_drift))),
        "energy_drift_orbital": float(np.max(np.abs(year.energy_drift_orbital))),
        "angular_momentum_drift": float(np.max(year.angular_momentum_drift)),
        "steps": year.statistics.steps,
        "evaluations": year.statistics.evaluations,
        "cpu_seconds": seconds,
    }


def spin_range(system: Any, state: Any, integrator: Integrator | None = None, spacing: float = 0.02) -> Floats:
    """Return the range of Beta's spin over the first 200 h, 1e-5 rad/s (3, 2), in a system of km, hour, kg."""
    spin = without_unit(system.integrate(state, _SPIN, output=spacing, integrator=integrator).spin)[:, 1] * (
        1e5 / 3600.0
    )
    return np.stack([spin.min(axis=0), spin.max(axis=0)], axis=1)


def _text(value: Any) -> str:
    return ", ".join(f"{number:.6g}" for number in np.atleast_1d(value))


def write(out: Path, figures: dict[str, Any], numbers: Any) -> None:
    """Write figures as PNG and PDF, and ``numbers.json``, each completely or not at all."""
    for name, figure in figures.items():
        for suffix in (".png", ".pdf"):
            with replacing(out / f"{name}{suffix}") as path:
                figure.savefig(path, dpi=150)
    with replacing(out / "numbers.json") as path:
        path.write_text(json.dumps(numbers, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def written(out: Path) -> str:
    """Return a sentence that lists the files of the folder."""
    return f"Figures, runs (every {_STRIDE}th step) and numbers.json are in {out}/"
