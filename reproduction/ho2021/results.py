"""All runs of the report, and their numbers."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from fullbody import Run, systems
from tqdm.auto import tqdm

from ..publishing import PROGRAM
from . import cases, kw4, orientations, paper, physical, spin, symmetry, years

__all__ = ["Results", "Runs", "as_numbers", "compute"]


@dataclass(frozen=True, slots=True)
class _Effort:
    """Steps of a scan to either side, orientations tried and refined, inclinations, and ends of the long runs."""

    scan: int = 18
    orientations: int = 2048
    refined: int = 24
    inclinations: tuple[float, ...] = (
        *np.linspace(5.0, 60.0, 12),
        *np.linspace(120.0, 150.0, 6),
        156.1,
        162.0,
        168.0,
        174.0,
        179.0,
    )
    long_end: float = paper.CASES_LONG_END
    variants_end: float = paper.YEAR_HOURS


_DRAFT = _Effort(scan=3, orientations=16, refined=0, inclinations=(45.0, 156.1), long_end=250.0, variants_end=0.0)


@dataclass(frozen=True, slots=True)
class Runs:
    """The runs of the figures: the cases, with every step and with fine samples; the year; the physical states."""

    cases: dict[int, Run]
    fine: dict[int, Run]
    year: dict[kw4.Shape, Run]
    physical: dict[str, Run]


@dataclass(frozen=True, slots=True)
class Results:
    """All results of the study: angles in degrees, lengths in km, times of 1999 KW4 in hours."""

    draft: bool
    cases: dict[int, cases.CaseNumbers]
    #: Growth of case 2's spins about x and y, by the tilt that replaces pi/32.
    growth: dict[str, float]
    #: The largest distance of case 2's orbits from coplanar ones, relative to that from the centre.
    deviation_from_coplanar: float
    #: Range of case 1's separation until t = 200, and in the last 200 of the long run.
    separation: tuple[tuple[float, float], tuple[float, float]]
    #: Motion along z until ``long_end``, by the kind of arithmetic.
    z_motion: dict[str, symmetry.Motion]
    long_end: float
    #: Numbers of the year by the variant of the run (``surface`` and ``focal`` gravity, ``printed_axes``, ``other_g``)
    #: and by shape.
    year: dict[str, dict[kw4.Shape, kw4.Numbers]]
    #: The largest abs(theta) by run; at 90 degrees the paper's angles are singular.
    theta: dict[str, float]
    #: Total over orbital energy of the year.
    energy_ratio: float
    #: Change of the ellipsoids' angular momentum since the start, relative, medians of the year's first and last
    #: quarter: from the ``positions`` of the bodies, and with the part of the barycentre ``separate``.
    momentum: dict[str, tuple[float, float]]
    #: The displacement of the barycentre in the year.
    barycentre_displacement: float
    variants: list[years.Variant]
    scans: list[spin.Scan]
    search: orientations.Search
    readings: list[spin.Reading]
    nodal: dict[kw4.Shape, years.Nodal]
    physical: dict[str, physical.Motion]
    runs: Runs


def compute(*, draft: bool = False, progress: bool = False) -> Results:
    """Compute all results."""
    effort = _DRAFT if draft else _Effort()
    with tqdm(total=8, disable=not progress, unit="stage") as bar:

        def stage(name: str) -> None:
            bar.set_description(name)
            bar.update()

        stage("cases 1 and 2")
        timed = {number: cases.case(number) for number in (1, 2)}
        runs = {number: run for number, (run, _) in timed.items()}
        fine = {number: cases.fine(run) for number, run in runs.items()}
        stage("motion along z by arithmetic")
        z_motion, long_run = symmetry.z_motion(effort.long_end)
        stage("the year by surface integrals")
        surface = {shape: kw4.run_year(shape, "surface") for shape in kw4.SHAPES}
        year = {shape: run for shape, (run, _) in surface.items()}
        stage("the year with other settings")
        numbers = {
            "surface": {shape: kw4.measure(*run) for shape, run in surface.items()},
            "focal": {shape: kw4.measure(*kw4.run_year(shape, "focal")) for shape in kw4.SHAPES},
            "printed_axes": {shape: years.with_printed_axes(shape) for shape in kw4.SHAPES},
            "other_g": {shape: years.with_g(shape, years.G_HELP) for shape in kw4.SHAPES},
        }
        stage("other methods")
        variants = years.variants(effort.variants_end)
        stage("starts that give the printed spin")
        scans = [spin.scan(name, effort.scan) for name in spin.FAMILIES]
        search = orientations.search(scans, effort.orientations, effort.refined)
        readings = spin.readings(search.minima[0].angles)
        stage("inclinations of the orbit")
        nodal = {shape: years.nodal(shape, np.array(effort.inclinations)) for shape in kw4.SHAPES}
        stage("the physical 1999 KW4")
        motions, physical_runs = physical.motions()
    named_runs = {f"case {number}": run for number, run in fine.items()}
    named_runs |= {f"1999 KW4, {shape}s": run for shape, run in year.items()}
    system, state = systems.kw4_ho2021()
    energy = system.energy(state)
    return Results(
        draft=draft,
        cases={number: cases.measure(run, fine[number], seconds) for number, (run, seconds) in timed.items()},
        growth={"pi/16": cases.growth(np.pi / 16), "pi/8": cases.growth(np.pi / 8)},
        deviation_from_coplanar=cases.deviation_from_coplanar(),
        separation=symmetry.separation_ranges(long_run),
        z_motion=z_motion,
        long_end=effort.long_end,
        year=numbers,
        theta={name: float(np.rad2deg(np.abs(cases.angles(run)[..., 1]).max())) for name, run in named_runs.items()},
        energy_ratio=float(abs(energy.total / (energy.total - energy.rotational))),
        momentum=_momentum(year["ellipsoid"]),
        barycentre_displacement=float(
            np.linalg.norm(system.momentum(state)) / np.sum(system.masses) * paper.YEAR_HOURS
        ),
        variants=variants,
        scans=scans,
        search=search,
        readings=readings,
        nodal=nodal,
        physical=motions,
        runs=Runs(runs, fine, year, physical_runs),
    )


def _momentum(run: Run) -> dict[str, tuple[float, float]]:
    """Return the medians of the first and the last quarter of the drift of the angular momentum."""
    drifts = {"positions": kw4.drift(kw4.momentum_of_samples(run)), "separate": run.angular_momentum_drift}
    quarter = len(run) // 4
    return {name: (float(np.median(d[:quarter])), float(np.median(d[-quarter:]))) for name, d in drifts.items()}


def as_numbers(results: Results) -> dict[str, Any]:
    """Return all results except the runs."""
    return {
        "program": PROGRAM,
        "paper": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35",
        **{field.name: getattr(results, field.name) for field in fields(results) if field.name != "runs"},
    }
