"""``fullbody kw4``: one year of the paper's 1999 KW4 beside the paper's numbers."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ...base.atomic import replacing
from ...errors import InvalidInput
from ...files.reading import netcdf
from ...motion.run import Run
from ...plots._style import matplotlib
from ...record.integrators import Verner98
from . import printed
from .numbers import write_numbers
from .year import METHODS, SHAPES, Numbers, Shape, measure, run_year

__all__ = ["register", "table"]

#: Runs are kept thinned by this factor; the numbers come from every step.
_KEPT = 8


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "kw4",
        help="one year of 1999 KW4, both shapes, beside the paper's numbers",
        description="Run one year of the paper's (66391) 1999 KW4 with both shapes and both exact methods of gravity, "
        "print the numbers beside the paper's and write figures and data.",
    )
    parser.add_argument("--out", type=Path, default=Path("out/kw4"), help="folder for figures and data (%(default)s)")
    parser.add_argument("--gravity", choices=(*METHODS, "both"), default="both", help="method (%(default)s)")
    parser.add_argument("--until", type=float, default=printed.YEAR_HOURS, help="hours (%(default)s, a year)")
    parser.add_argument("--rtol", type=float, default=1e-13, help="tolerance of a step (%(default)s)")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run, print, write."""
    from . import figures

    if not 0.0 < arguments.until < float("inf"):
        raise InvalidInput(f"--until is {arguments.until:g}; expected hours above zero")

    # A missing package is reported before the work, not after it.
    netcdf()
    matplotlib("figure")
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    methods = METHODS if arguments.gravity == "both" else (arguments.gravity,)
    integrator = Verner98(arguments.rtol, arguments.rtol)
    numbers: dict[str, dict[str, Numbers]] = {}
    runs: dict[Shape, Run] = {}
    for shape in SHAPES:
        numbers[shape] = {}
        for method in methods:
            label = f"{shape}s, {method}"
            whole, seconds = run_year(
                shape,
                method,
                arguments.until,
                integrator=integrator,
                progress=False if arguments.quiet else label,
            )
            numbers[shape][method] = measure(whole, seconds)
            whole[::_KEPT].save(out / f"kw4_{shape}_{method}.nc")
            runs[shape] = whole
    print(table(numbers, arguments.until))
    for name, figure in figures.all_figures(runs).items():
        for suffix in (".png", ".pdf"):
            with replacing(out / f"{name}{suffix}") as path:
                figure.savefig(path, dpi=150)
    write_numbers(out / "numbers.json", numbers)
    print(f"\nFigures, runs (every {_KEPT}th step) and numbers.json are in {out}/")
    return 0


def table(numbers: dict[str, dict[str, Numbers]], until: float) -> str:
    """Return a table of the numbers beside those of the paper."""
    methods = list(next(iter(numbers.values())))
    lines = []
    for shape, by_method in numbers.items():
        paper = printed.YEAR[shape]
        columns = [by_method[m] for m in methods]
        part = "" if until >= printed.YEAR_HOURS else f"; the paper's numbers are of {printed.YEAR_HOURS:g} hours"
        lines += ["", f"1999 KW4, {shape}s, {until:g} hours{part}", ""]
        lines.append(f"  {'':<42}{'paper':>16}" + "".join(f"{m:>18}" for m in methods))

        def row(text: str, said: str, ours: list[str], lines: list[str] = lines) -> None:
            lines.append(f"  {text:<42}{said:>16}" + "".join(f"{value:>18}" for value in ours))

        row("largest eccentricity", f"{paper.e_max:.4f}", [f"{n.e_max:.4f}" for n in columns])
        for name, text in (("a_min", "smallest"), ("a_max", "largest"), ("a_mean", "mean")):
            said = f"{getattr(paper, name):.4f}"
            row(f"{text} semi-major axis [km]", said, [f"{getattr(n, name):.4f}" for n in columns])
        row("mean period [h] *", f"{paper.period:.4f}", [f"{n.period:.4f}" for n in columns])
        # A short run does not have two maxima.
        periods = [n.inclination_period for n in columns]
        ours = ["-" if period != period else f"{period:.0f}" for period in periods]
        row("between maxima of the inclination [h] *", f"~{paper.inclination_period:.0f}", ours)
        for axis, (low, high) in printed.SPIN.items() if shape == "ellipsoid" else ():
            spins = [getattr(n, f"spin_{axis}") for n in columns]
            ours = [f"[{s[0]:.2f}, {s[1]:.2f}]" for s in spins]
            row(f"Beta's spin {axis}, 200 h [1e-5 rad/s] *", f"[{low}, {high}]", ours)
        limit = printed.ERRORS
        row("energy error, step to step", f"< {limit['energy']:.0e}", [f"{n.energy_step:.1e}" for n in columns])
        row("  from the start", "", [f"{n.energy_drift:.1e}" for n in columns])
        row("  from the start, of the orbital energy", "", [f"{n.energy_drift_orbital:.1e}" for n in columns])
        said = f"< {limit['angular_momentum']:.0e}"
        row("angular momentum of the places, step to step", said, [f"{n.angular_momentum_step:.1e}" for n in columns])
        row("  about the barycentre, from the start", "", [f"{n.angular_momentum_drift:.1e}" for n in columns])
        row("evaluations of the forces", "", [str(n.evaluations) for n in columns])
        said = f"{printed.CPU_TIME[shape] / 3600:.1f} h"
        row("CPU time, output included", said, [f"{n.cpu_seconds:.1f} s" for n in columns])
    lines += ["", "  * does not follow from the stated start; the documentation's page on the paper shows the evidence"]
    return "\n".join(lines)
