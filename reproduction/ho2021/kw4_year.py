"""``python -m reproduction.ho2021.kw4_year``: one year of the paper's 1999 KW4 beside the paper's numbers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from fullbody import Run
from fullbody.commands.kw4 import add_options, write, written, years

from ..publishing import as_json, formatted, run_command
from . import paper
from .kw4 import SHAPES, Numbers, Shape, measure
from .kw4_figures import all_figures

__all__ = ["main", "table"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m reproduction.ho2021.kw4_year",
        description="Run one year of the paper's (66391) 1999 KW4 with both shapes and both exact methods of gravity, "
        "print the numbers beside the paper's and write figures and data.",
    )
    add_options(parser)
    arguments = parser.parse_args(argv)

    def run_years() -> None:
        numbers: dict[Shape, dict[str, Numbers]] = {shape: {} for shape in SHAPES}
        runs: dict[Shape, Run] = {}
        for shape, method, run, seconds in years(arguments):
            numbers[shape][method] = measure(run, seconds)
            runs[shape] = run
        if not arguments.quiet:
            print(table(numbers, arguments.until), end="\n\n")
        write(arguments.out, all_figures(runs), as_json(numbers))
        if not arguments.quiet:
            print(written(arguments.out))

    return run_command(run_years)


def table(numbers: dict[Shape, dict[str, Numbers]], until: float) -> str:
    """Return a table of the numbers beside those of the paper."""
    methods = list(next(iter(numbers.values())))
    lines = []
    for shape, by_method in numbers.items():
        year = paper.YEAR[shape]
        columns = [by_method[m] for m in methods]
        note = "" if until >= paper.YEAR_HOURS else f"; the paper's numbers are of {paper.YEAR_HOURS:g} hours"
        lines += ["", f"1999 KW4, {shape}s, {until:g} hours{note}", ""]
        lines.append(f"  {'':<42}{'paper':>16}" + "".join(f"{m:>18}" for m in methods))

        def row(text: str, printed: str, computed: list[str], lines: list[str] = lines) -> None:
            lines.append(f"  {text:<42}{printed:>16}" + "".join(f"{value:>18}" for value in computed))

        row("largest eccentricity", f"{year.e_max:.4f}", [f"{n.e_max:.4f}" for n in columns])
        for name, text in (("a_min", "smallest"), ("a_max", "largest"), ("a_mean", "mean")):
            printed = f"{getattr(year, name):.4f}"
            row(f"{text} semi-major axis [km]", printed, [f"{getattr(n, name):.4f}" for n in columns])
        row("mean period [h] *", f"{year.period:.4f}", [f"{n.period:.4f}" for n in columns])
        # A short run does not have two maxima.
        periods = [formatted(n.inclination_period, ".0f") for n in columns]
        row("between maxima of the inclination [h] *", f"~{year.inclination_period:.0f}", periods)
        for axis, (low, high) in paper.SPIN.items() if shape == "ellipsoid" else ():
            spins = [getattr(n, f"spin_{axis}") for n in columns]
            ranges = [f"[{s[0]:.2f}, {s[1]:.2f}]" for s in spins]
            row(f"Beta's spin {axis}, 200 h [1e-5 rad/s] *", f"[{low}, {high}]", ranges)
        limit = paper.ERRORS
        row("energy error, step to step", f"< {limit['energy']:.0e}", [f"{n.energy_step:.1e}" for n in columns])
        row("  from the start", "", [f"{n.energy_drift:.1e}" for n in columns])
        row("  from the start, of the orbital energy", "", [f"{n.energy_drift_orbital:.1e}" for n in columns])
        printed, steps = f"< {limit['angular_momentum']:.0e}", [f"{n.angular_momentum_step:.1e}" for n in columns]
        row("angular momentum error, step to step", printed, steps)
        row("  about the barycentre, from the start", "", [f"{n.angular_momentum_drift:.1e}" for n in columns])
        row("evaluations of the forces", "", [str(n.evaluations) for n in columns])
        printed = f"{paper.CPU_TIME[shape] / 3600:.1f} h"
        row("CPU time, output included", printed, [f"{n.cpu_seconds:.1f} s" for n in columns])
    lines += ["", "  * does not follow from the stated start; the documentation's page on the paper shows the evidence"]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
