"""``fullbody kw4``: one year of the paper's 1999 KW4 beside the paper's numbers."""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from .. import paper, systems
from ..integrators import Verner98
from ..io import netcdf
from ..plots._style import matplotlib
from ..run import Run

_SHAPES: tuple[Literal["ellipsoid", "spheroid"], ...] = ("ellipsoid", "spheroid")
_METHODS = ("surface", "focal")
#: Runs are kept thinned by this factor; the numbers come from every step.
_KEPT = 8


@dataclass(frozen=True, slots=True)
class Numbers:
    """What a year of 1999 KW4 gives; lengths in km, times in hours, spins in 1e-5 rad/s."""

    e_max: float
    a_min: float
    a_max: float
    a_mean: float
    period: float
    inclination_period: float
    spin_x: tuple[float, float]
    spin_y: tuple[float, float]
    spin_z: tuple[float, float]
    energy_step: float
    energy_drift: float
    energy_drift_orbital: float
    angular_momentum_step: float
    angular_momentum_drift: float
    steps: int
    evaluations: int
    cpu_seconds: float


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "kw4",
        help="one year of 1999 KW4, both shapes, beside the paper's numbers",
        description="Run one year of the paper's (66391) 1999 KW4 with both shapes and both exact methods of gravity, "
        "print the numbers beside the paper's and write figures and data.",
    )
    parser.add_argument("--out", type=Path, default=Path("out/kw4"), help="folder for figures and data (%(default)s)")
    parser.add_argument("--gravity", choices=(*_METHODS, "both"), default="both", help="method (%(default)s)")
    parser.add_argument("--until", type=float, default=paper.KW4_YEAR, help="hours (%(default)s, a year)")
    parser.add_argument("--rtol", type=float, default=1e-13, help="tolerance of a step (%(default)s)")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run, print, write."""
    from . import kw4_figures as figures

    # What is missing is said before the work, not after it.
    netcdf()
    matplotlib("figure")
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    methods = _METHODS if arguments.gravity == "both" else (arguments.gravity,)
    integrator = Verner98(arguments.rtol, arguments.rtol)
    numbers: dict[str, dict[str, Numbers]] = {}
    runs: dict[str, Run] = {}
    for shape in _SHAPES:
        numbers[shape] = {}
        for method in methods:
            system, state = systems.kw4_ho2021(shape, gravity=method, units=True)
            label = f"{shape}s, {method}"
            started = time.process_time()
            whole = system.integrate(
                state, arguments.until, integrator=integrator, progress=False if arguments.quiet else label
            )
            seconds = time.process_time() - started
            numbers[shape][method] = measure(whole, seconds)
            whole[::_KEPT].save(out / f"kw4_{shape}_{method}.nc")
            runs[shape] = whole
    print(table(numbers, arguments.until))
    for name, figure in figures.all_figures(runs).items():
        figure.savefig(out / f"{name}.png", dpi=150)
        figure.savefig(out / f"{name}.pdf")
    (out / "numbers.json").write_text(
        json.dumps({s: {m: asdict(n) for m, n in by.items()} for s, by in numbers.items()}, indent=1) + "\n"
    )
    print(f"\nFigures, runs (every {_KEPT}th step) and numbers.json are in {out}/")
    return 0


def measure(run: Run, seconds: float) -> Numbers:
    """The quantities that the paper prints, from a run in km, hour, kg."""
    from astropy import units as u

    elements = run.elements()
    a = elements.a.to_value(u.km)
    hours = run.time.to_value(u.hour)
    first = hours <= 200.0
    spin = run.spin[first, 1].to_value(u.rad / u.s) * 1e5
    ranges = [(float(component.min()), float(component.max())) for component in spin.T]
    energy = run.energy.value
    momentum = run.angular_momentum.value
    return Numbers(
        e_max=float(np.max(elements.e)),
        a_min=float(a.min()),
        a_max=float(a.max()),
        a_mean=float(np.trapezoid(a, hours) / np.ptp(hours)),
        period=mean_period(run),
        inclination_period=between_maxima(hours, inclination_to_first(run)),
        spin_x=ranges[0],
        spin_y=ranges[1],
        spin_z=ranges[2],
        energy_step=float(np.max(np.abs(np.diff(energy) / energy[:-1]))),
        energy_drift=float(np.max(np.abs(run.energy_drift))),
        energy_drift_orbital=float(np.max(np.abs(run.energy_drift_orbital))),
        angular_momentum_step=float(np.max(np.abs(np.diff(momentum, axis=0) / momentum[:-1]))),
        angular_momentum_drift=float(np.max(run.angular_momentum_drift)),
        steps=run.statistics.steps,
        evaluations=run.statistics.evaluations,
        cpu_seconds=seconds,
    )


def mean_period(run: Run) -> float:
    """Mean over time of the osculating orbit's period, hours."""
    from astropy import units as u

    hours = run.time.to_value(u.hour)
    period = run.elements().period(run.system.mu()).to_value(u.hour)
    return float(np.trapezoid(period, hours) / np.ptp(hours))


def inclination_to_first(run: Run) -> Any:
    """Angle between the orbit's normal and that at the start, degrees (K,)."""
    r = (run.position[:, 1] - run.position[:, 0]).value
    v = (run.velocity[:, 1] - run.velocity[:, 0]).value
    normal = np.cross(r, v)
    across = np.linalg.norm(np.cross(normal, normal[0]), axis=1)
    return np.rad2deg(np.arctan2(across, normal @ normal[0]))


def between_maxima(hours: Any, values: Any, smoothing: float = 200.0) -> float:
    """Time between the first two maxima of a slow oscillation; NaN where there are not two.

    The oscillation is averaged over ``smoothing`` hours first, which many orbits share.
    """
    even = np.arange(hours[0], hours[-1], 1.0)
    width = int(smoothing)
    if len(even) < 4 * width:
        return float("nan")
    smooth = np.convolve(np.interp(even, hours, values), np.ones(width) / width, mode="valid")
    middle = even[: len(smooth)] + 0.5 * (width - 1)
    rising = np.diff(smooth) > 0
    tops = middle[1:-1][rising[:-1] & ~rising[1:]]
    # Ripples on the top of one maximum are one maximum.
    tops = tops[np.concatenate([[True], np.diff(tops) > 5 * smoothing])] if len(tops) else tops
    return float(tops[1] - tops[0]) if len(tops) > 1 else float("nan")


def table(numbers: dict[str, dict[str, Numbers]], until: float) -> str:
    """The numbers beside the paper's."""
    methods = list(next(iter(numbers.values())))
    lines = []
    for shape, by_method in numbers.items():
        printed = paper.KW4[shape]
        columns = [by_method[m] for m in methods]
        lines += ["", f"1999 KW4, {shape}s, {until:g} hours", ""]
        lines.append(f"  {'':<42}{'paper':>16}" + "".join(f"{m:>18}" for m in methods))

        def row(text: str, said: str, ours: list[str], lines: list[str] = lines) -> None:
            lines.append(f"  {text:<42}{said:>16}" + "".join(f"{value:>18}" for value in ours))

        row("largest eccentricity", f"{printed.e_max:.4f}", [f"{n.e_max:.4f}" for n in columns])
        for name, text in (("a_min", "smallest"), ("a_max", "largest"), ("a_mean", "mean")):
            said = f"{getattr(printed, name):.4f}"
            row(f"{text} semi-major axis [km]", said, [f"{getattr(n, name):.4f}" for n in columns])
        row("mean period [h] *", f"{printed.period:.4f}", [f"{n.period:.4f}" for n in columns])
        ours = [f"{n.inclination_period:.0f}" for n in columns]
        row("between maxima of the inclination [h] *", f"~{printed.inclination_period:.0f}", ours)
        for axis, (low, high) in paper.KW4_SPIN.items() if shape == "ellipsoid" else ():
            spins = [getattr(n, f"spin_{axis}") for n in columns]
            ours = [f"[{s[0]:.2f}, {s[1]:.2f}]" for s in spins]
            row(f"Beta's spin {axis}, 200 h [1e-5 rad/s] *", f"[{low}, {high}]", ours)
        limit = paper.KW4_ERRORS
        row("energy error, step to step", f"< {limit['energy']:.0e}", [f"{n.energy_step:.1e}" for n in columns])
        row("  from the start", "", [f"{n.energy_drift:.1e}" for n in columns])
        row("  from the start, of the orbital energy", "", [f"{n.energy_drift_orbital:.1e}" for n in columns])
        said = f"< {limit['angular_momentum']:.0e}"
        row("angular momentum error, step to step, each", said, [f"{n.angular_momentum_step:.1e}" for n in columns])
        row("  from the start, of its length", "", [f"{n.angular_momentum_drift:.1e}" for n in columns])
        row("evaluations of the forces", "", [str(n.evaluations) for n in columns])
        said = f"{paper.CPU_TIME[shape] / 3600:.1f} h"
        row("CPU time, output included", said, [f"{n.cpu_seconds:.1f} s" for n in columns])
    lines += ["", "  * does not follow from the stated start; see the documentation of fullbody.systems.kw4_ho2021"]
    return "\n".join(lines)
