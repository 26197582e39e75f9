"""``python -m reproduction.ho2021.millennia``: 1999 KW4 for ten thousand years, in parts, each of which is saved."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fullbody import Run, Simulation, SymplecticSplitting, load
from fullbody.base.atomic import replacing
from fullbody.base.figures import LINES, grid, legend, matplotlib
from fullbody.base.tables import Table, to_text
from fullbody.errors import InvalidInput
from fullbody.files.reading import netcdf
from fullbody.systems import kw4_ho2021

from ..publishing import run_command, write_numbers
from .drawing import largest, new_figure, windows

__all__ = ["main", "measure"]

#: The number of hours in a Julian year.
_YEAR = 8766.0
#: The approximate number of samples per year.
_SAMPLES = 10.0
#: The name of the file with the simulation at the end of the last part.
_SIMULATION = "simulation.sim"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(
        prog="python -m reproduction.ho2021.millennia",
        description="Run the paper's (66391) 1999 KW4 for ten thousand years by the symplectic splitting, whose step "
        "is chosen by short trials, and write samples, numbers and a figure of the error of the energy. The same "
        "command resumes an interrupted run, and a longer one continues a shorter one.",
    )
    parser.add_argument("--out", type=Path, default=Path("out/millennia"), help="folder (%(default)s)")
    parser.add_argument("--years", type=float, default=10_000.0, help="of 365.25 days (%(default)g)")
    parser.add_argument("--shape", choices=("spheroid", "ellipsoid"), default="spheroid", help="(%(default)s)")
    parser.add_argument(
        "--energy-error", type=float, default=1e-9, help="largest, relative to the orbital energy (%(default)g)"
    )
    parser.add_argument("--step", type=float, help="the step in hours, without trials")
    parser.add_argument("--part", type=float, default=100.0, help="years of a part (%(default)g)")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    arguments = parser.parse_args(argv)
    return run_command(lambda: run(arguments))


def run(arguments: argparse.Namespace) -> None:
    """Run the missing parts, and print and draw the numbers of all parts."""
    for name in ("years", "part"):
        value = getattr(arguments, name)
        if not 0.0 < value < float("inf"):
            raise InvalidInput(f"--{name} is {value:g}; expected a number above zero")
    # A missing package is reported before the runs.
    netcdf()
    matplotlib("figure")
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    started = time.process_time()
    sim = _simulation(out / _SIMULATION, arguments)
    step: float = sim.integrator.step  # type: ignore[attr-defined]
    # Samples and ends of parts coincide with ends of steps, so that all steps have the same size.
    spacing = max(1, round(_YEAR / _SAMPLES / step))
    length, last = (
        spacing * max(1, round(years * _YEAR / step / spacing)) for years in (arguments.part, arguments.years)
    )
    first = done = round(float(sim.time) / step)
    runs = _parts(out, (done + 0.5) * step)
    while done < last:
        if not arguments.quiet and sys.stderr.isatty():
            print(f"\r{done * step / _YEAR:7.0f} of {arguments.years:g} years ", end="", file=sys.stderr)
        end = min(last, (done // length + 1) * length)
        samples = step * np.arange(done + (spacing if done else 0), end + 1, spacing)
        result = sim.integrate(samples[-1], output=samples)
        # The samples are saved first: if the command ends between the two files, the part is run again with the same
        # bits.
        result.save(out / f"part-{len(runs):04d}.nc")
        runs.append(result)
        sim.save(out / _SIMULATION)
        done = end
    seconds = time.process_time() - started
    measured = measure(runs)
    years = (done - first) * step / _YEAR
    table = Table(f"1999 KW4, {arguments.shape}s, {sim.integrator}")
    table.rows = [(name, text) for name, text in _rows(measured)]
    if years:
        table.rows.append(("CPU time of these years, trials of the step included", f"{years:g} in {seconds:.0f} s"))
    with replacing(out / "energy.png") as path:
        _figure(measured).savefig(path, dpi=150)
    write_numbers(
        out / "numbers.json", {"shape": arguments.shape, "step": step, **{name: text for name, text in table.rows}}
    )
    if not arguments.quiet:
        print(to_text(table))
        print(f"\nSamples, numbers.json and energy.png are in {out}/")


def _parts(out: Path, end: float) -> list[Run]:
    """Return the saved parts up to a time; the simulation at the end of a part beyond it was not saved."""
    runs: list[Run] = []
    previous = 0.0
    for path in sorted(out.glob("part-[0-9]*.nc")):
        part = load(path)
        last = float(part.time[-1])
        if not previous < last <= end:
            break
        runs.append(part)
        previous = last
    return runs


def _simulation(path: Path, arguments: argparse.Namespace) -> Simulation:
    """Return the simulation that was saved, or a new one."""
    system, state = kw4_ho2021(arguments.shape)
    if path.exists():
        sim = Simulation.load(path)
        same = sim.system == system and isinstance(sim.integrator, SymplecticSplitting)
        if not same or arguments.step not in (None, sim.integrator.step):  # type: ignore[attr-defined]
            raise InvalidInput(
                f"{path} is of {sim!r}; expected the shape and the step of this command, or another --out"
            )
        return sim
    if arguments.step is not None:
        return Simulation(system, state, integrator=SymplecticSplitting(step=arguments.step))
    return Simulation(
        system, state, integrator=SymplecticSplitting.suggest(system, state, energy_error=arguments.energy_error)
    )


def measure(runs: list[Run]) -> dict[str, Any]:
    """Return errors of the conserved quantities, and elements, at the samples of consecutive runs."""
    start = runs[0][0]
    energy = runs[0].system.energy(start)
    total = np.concatenate([run.energy for run in runs])
    momentum = np.concatenate([run.angular_momentum for run in runs])
    elements = [run.elements() for run in runs]
    change = momentum - momentum[0]
    return {
        "years": np.concatenate([run.time for run in runs]) / _YEAR,
        "energy": (total - total[0]) / abs(energy.potential + energy.translational),
        "angular_momentum": np.linalg.norm(change, axis=1) / np.linalg.norm(momentum[0]),
        "e": np.concatenate([orbit.e for orbit in elements]),
        "a": np.concatenate([orbit.a for orbit in elements]),
    }


def _rows(result: dict[str, Any]) -> list[tuple[str, str]]:
    years, energy = result["years"], np.abs(result["energy"])
    first = years <= 0.01 * years[-1]
    last = years >= 0.9 * years[-1]
    return [
        ("years", f"{years[-1]:.2f}"),
        ("samples", str(len(years))),
        ("largest energy error, relative to the orbit's energy", f"{energy.max():.1e}"),
        ("  in the first hundredth", f"{energy[first].max():.1e}"),
        ("  in the last tenth", f"{energy[last].max():.1e}"),
        ("  mean of the last tenth, with its sign", f"{result['energy'][last].mean():+.1e}"),
        ("largest relative angular momentum error", f"{result['angular_momentum'].max():.1e}"),
        ("eccentricity", f"{result['e'].min():.4f} to {result['e'].max():.4f}"),
        ("semi-major axis [km]", f"{result['a'].min():.4f} to {result['a'].max():.4f}"),
    ]


def _figure(result: dict[str, Any]) -> Any:
    """Return a figure of the errors in windows, and of the range of the eccentricity."""
    years = result["years"]
    width = max(years[-1] / 400, 2 / _SAMPLES)
    figure, axes = new_figure(2, 1, (8.0, 6.0), sharex=True)
    errors, orbit = axes[:, 0]
    for row, (name, label) in enumerate(
        (("energy", "energy, relative to the orbit's"), ("angular_momentum", "angular momentum"))
    ):
        errors.plot(*largest(years, result[name], width), label=label, **LINES[row])
    errors.set_yscale("log")
    errors.set_ylabel("|relative error|,\nlargest in each window")
    legend(errors)
    middle, low, high = windows(years, result["e"], width)
    orbit.fill_between(middle, low, high, color=LINES[0]["color"], alpha=0.4, linewidth=0.0)
    orbit.set_ylabel("eccentricity,\nrange in each window")
    orbit.set_xlabel("time [years]")
    for ax in (errors, orbit):
        ax.margins(x=0)
        grid(ax)
    return figure


if __name__ == "__main__":
    sys.exit(main())
