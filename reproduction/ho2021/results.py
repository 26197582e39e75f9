"""All runs of the report, and everything in them as numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from fullbody.commands.kw4 import printed
from fullbody.commands.kw4 import year as kw4
from fullbody.run import Run

from . import cases, paper, physical, starts
from .captions import CAPTIONS
from .cases import CaseNumbers
from .cases import Motion as MotionAlongZ
from .verdicts import WORDS, Verdict, judge

__all__ = ["Results", "as_numbers", "compute", "counts"]


@dataclass(frozen=True, slots=True)
class _Effort:
    """Steps of a scan to either side, orientations tried and refined, inclinations, lengths of the long runs."""

    scan: int = 18
    tried: int = 512
    refined: int = 8
    inclinations: tuple[float, ...] = (
        *np.linspace(5.0, 60.0, 12),
        *np.linspace(120.0, 150.0, 6),
        156.1,
        162.0,
        168.0,
        174.0,
        179.0,
    )
    late: float = paper.CASES_LATE
    agreement: float = printed.YEAR_HOURS


_DRAFT = _Effort(scan=3, tried=16, refined=0, inclinations=(45.0, 156.1, 179.0), late=250.0, agreement=0.0)


@dataclass(slots=True)
class Results:
    """All that was computed, in numbers and in runs."""

    cases: dict[int, CaseNumbers]
    case_runs: dict[int, Run]
    case_fine: dict[int, Run]
    growth: dict[str, float]
    from_coplanar: float
    late_separation: tuple[tuple[float, float], tuple[float, float]]
    z_motion: dict[str, MotionAlongZ]
    year: dict[str, kw4.Numbers]
    year_focal: dict[str, kw4.Numbers]
    year_printed_axes: dict[str, kw4.Numbers]
    year_runs: dict[str, Run]
    agreement: list[starts.Agreement]
    scans: list[starts.Scan]
    search: starts.Search
    year_from_search: kw4.Numbers
    year_from_anomaly: kw4.Numbers
    nodal: dict[str, Any]
    physical: list[physical.Motion]
    draft: bool = False
    verdicts: list[Verdict] = field(default_factory=list)


def compute(*, draft: bool = False, progress: bool = False) -> Results:
    """All runs, and the verdicts."""
    from tqdm.auto import tqdm

    with tqdm(total=_STAGES, disable=not progress, unit="stage") as bar:

        def stage(name: str) -> None:
            bar.set_description(name)
            bar.update()

        results = _compute(_DRAFT if draft else _Effort(), stage)
    results.draft = draft
    results.verdicts = judge(results)
    return results


_STAGES = 8


def _compute(effort: _Effort, stage: Any) -> Results:
    stage("cases 1 and 2")
    runs = {number: cases.case(number) for number in (1, 2)}
    drawn = {number: cases.fine(run) for number, (run, _) in runs.items()}
    stage("motion along z by arithmetic")
    z_motion, late = cases.z_motion(effort.late)
    stage("1999 KW4, surface integrals")
    years = {shape: kw4.run_year(shape, "surface") for shape in kw4.SHAPES}
    stage("1999 KW4, focal rule")
    focal: dict[str, kw4.Numbers] = {shape: kw4.measure(*kw4.run_year(shape, "focal")) for shape in kw4.SHAPES}
    printed: dict[str, kw4.Numbers] = {shape: starts.with_printed_axes(shape) for shape in kw4.SHAPES}
    stage("six ways to compute")
    agreement = starts.agreement(effort.agreement)
    stage("starts that give the printed spin")
    scans = [starts.scan(name, effort.scan) for name in starts.SCANS]
    search = starts.search(scans, effort.tried, effort.refined)
    anomaly = next(scan for scan in scans if scan.name == "mean anomaly").best[0]
    stage("inclinations of the orbit")
    slopes = np.array(effort.inclinations)
    nodal: dict[str, Any] = {shape: np.stack([slopes, *starts.nodal_period(shape, slopes)]) for shape in kw4.SHAPES}
    stage("the physical 1999 KW4")
    return Results(
        cases={number: cases.measure(run, drawn[number], seconds) for number, (run, seconds) in runs.items()},
        case_runs={number: run for number, (run, _) in runs.items()},
        case_fine=drawn,
        growth={"pi/16": cases.growth(np.pi / 16), "pi/8": cases.growth(np.pi / 8)},
        from_coplanar=cases.from_coplanar(),
        late_separation=cases.late_separation(late),
        z_motion=z_motion,
        year={shape: kw4.measure(*year) for shape, year in years.items()},
        year_focal=focal,
        year_printed_axes=printed,
        year_runs={shape: run for shape, (run, _) in years.items()},
        agreement=agreement,
        scans=scans,
        search=search,
        year_from_search=starts.year_from(angles=search.minima[0].angles),
        year_from_anomaly=starts.year_from(anomaly=anomaly),
        nodal=nodal,
        physical=physical.motions(),
    )


def as_numbers(results: Results) -> dict[str, Any]:
    """Everything but the runs."""
    from fullbody import __version__

    return {
        "program": f"fullbody {__version__}",
        "paper": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35",
        "draft": results.draft,
        "figures": CAPTIONS,
        "verdicts": [asdict(verdict) for verdict in results.verdicts],
        "cases": {f"case{number}": asdict(numbers) for number, numbers in results.cases.items()},
        "case2_growth_by_theta_0": results.growth,
        "case2_from_coplanar": results.from_coplanar,
        "case1_separation": {"first": results.late_separation[0], "last": results.late_separation[1]},
        "case1_z_motion": {name: asdict(motion) for name, motion in results.z_motion.items()},
        "kw4": {
            "surface": {shape: asdict(numbers) for shape, numbers in results.year.items()},
            "focal": {shape: asdict(numbers) for shape, numbers in results.year_focal.items()},
            "printed_axes": {shape: asdict(numbers) for shape, numbers in results.year_printed_axes.items()},
        },
        "agreement": [asdict(way) for way in results.agreement],
        "spin_scans": [{**asdict(scan), "misfit": scan.misfit} for scan in results.scans],
        "spin_search": asdict(results.search),
        "kw4_from_spin_search": asdict(results.year_from_search),
        "kw4_from_mean_anomaly": asdict(results.year_from_anomaly),
        "nodal_period_by_inclination": results.nodal,
        "physical": [
            {name: getattr(motion, name) for name in ("name", "start", "e", "a", "libration", "spin", "pole")}
            for motion in results.physical
        ],
    }


def counts(verdicts: list[Verdict]) -> Iterator[tuple[str, int]]:
    """How many verdicts of each kind."""
    for word in WORDS:
        yield word, sum(verdict.verdict == word for verdict in verdicts)
