"""All runs of the report, and everything in them as numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from .. import paper
from ..run import Run
from . import cases, kw4, physical, starts
from .captions import CAPTIONS
from .cases import CaseNumbers
from .cases import Motion as MotionAlongZ
from .verdicts import Verdict, judge

__all__ = ["Results", "as_numbers", "compute", "counts"]

#: The scans' steps in degrees, the search's tries and the length of the long runs: in full, and as a draft.
_FULL = {
    "scan": 5.0,
    "tried": 512,
    "refined": 4,
    "inclinations": 11,
    "late": paper.CASES_LATE,
    "agreement": paper.KW4_YEAR,
}
_DRAFT = {"scan": 20.0, "tried": 32, "refined": 0, "inclinations": 3, "late": 250.0, "agreement": paper.KW4_SPIN_HOURS}


@dataclass(slots=True)
class Results:
    """All that was computed, in numbers and in runs."""

    cases: dict[int, CaseNumbers]
    case_runs: dict[int, Run]
    case_forces: Any
    four_times: float
    late_separation: tuple[tuple[float, float], tuple[float, float]]
    z_motion: dict[str, MotionAlongZ]
    year: dict[str, kw4.Numbers]
    year_focal: dict[str, kw4.Numbers]
    year_runs: dict[str, Run]
    agreement: list[starts.Agreement]
    scans: list[starts.Scan]
    search: starts.Search
    year_from_search: kw4.Numbers
    nodal: dict[str, Any]
    physical: list[physical.Motion]
    draft: bool = False
    verdicts: list[Verdict] = field(default_factory=list)


def compute(*, draft: bool = False, progress: bool = False) -> Results:
    """All runs, and the verdicts."""
    from tqdm.auto import tqdm

    effort = _DRAFT if draft else _FULL
    with tqdm(total=_STAGES, disable=not progress, unit="stage") as bar:

        def stage(name: str) -> None:
            bar.set_description(name)
            bar.update()

        results = _compute(effort, stage)
    results.draft = draft
    results.verdicts = judge(results)
    return results


_STAGES = 9


def _compute(effort: dict[str, float], stage: Any) -> Results:
    from .. import systems

    stage("cases 1 and 2")
    runs = {number: cases.case(number) for number in (1, 2)}
    stage("case 1 to t = 2200")
    system, state = systems.case1()
    late = system.integrate(state, effort["late"], output=1.0)
    stage("motion along z by arithmetic")
    z_motion = cases.z_motion(effort["late"])
    stage("1999 KW4, surface integrals")
    years = {shape: kw4.year(shape, "surface") for shape in kw4.SHAPES}
    stage("1999 KW4, focal rule")
    focal: dict[str, kw4.Numbers] = {shape: kw4.measure(*kw4.year(shape, "focal")) for shape in kw4.SHAPES}
    stage("six ways to compute")
    agreement = starts.agreement(effort["agreement"])
    stage("starts that give the printed spin")
    scans = [starts.scan(name, np.arange(-90.0, 91.0, effort["scan"])) for name in starts.SCANS]
    search = starts.search(int(effort["tried"]), int(effort["refined"]))
    stage("inclinations of the orbit")
    inclinations = np.linspace(139.0, 179.0, int(effort["inclinations"]))
    nodal: dict[str, Any] = {s: np.stack([inclinations, starts.nodal_period(s, inclinations)]) for s in kw4.SHAPES}
    stage("the physical 1999 KW4")
    return Results(
        cases={number: cases.measure(*run) for number, run in runs.items()},
        case_runs={number: run for number, (run, _) in runs.items()},
        case_forces=cases.forces(runs[1][0]),
        four_times=cases.four_times(),
        late_separation=cases.late_separation(late),
        z_motion=z_motion,
        year={shape: kw4.measure(*year) for shape, year in years.items()},
        year_focal=focal,
        year_runs={shape: run for shape, (run, _) in years.items()},
        agreement=agreement,
        scans=scans,
        search=search,
        year_from_search=starts.year_from(search.angles),
        nodal=nodal,
        physical=physical.motions(),
    )


def as_numbers(results: Results) -> dict[str, Any]:
    """Everything but the runs, as plain lists and numbers; numbers that do not exist are null."""
    from .. import __version__

    whole = {
        "program": f"fullbody {__version__}",
        "paper": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35",
        "draft": results.draft,
        "figures": CAPTIONS,
        "verdicts": [asdict(verdict) for verdict in results.verdicts],
        "cases": {f"case{number}": asdict(numbers) for number, numbers in results.cases.items()},
        "case2_four_times_theta": results.four_times,
        "case1_separation": {"first": results.late_separation[0], "last": results.late_separation[1]},
        "case1_z_motion": {name: asdict(motion) for name, motion in results.z_motion.items()},
        "kw4": {
            "surface": {shape: asdict(numbers) for shape, numbers in results.year.items()},
            "focal": {shape: asdict(numbers) for shape, numbers in results.year_focal.items()},
        },
        "agreement": [asdict(way) for way in results.agreement],
        "spin_scans": [{**asdict(scan), "misfit": scan.misfit} for scan in results.scans],
        "spin_search": asdict(results.search),
        "kw4_from_spin_search": asdict(results.year_from_search),
        "nodal_period_by_inclination": results.nodal,
        "physical": [
            {name: getattr(motion, name) for name in ("name", "start", "e", "a", "libration", "spin", "pole")}
            for motion in results.physical
        ],
    }
    plain: dict[str, Any] = _plain(whole)
    return plain


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def counts(verdicts: list[Verdict]) -> Iterator[tuple[str, int]]:
    """How many verdicts of each kind."""
    for word in ("equal", "holds", "differs"):
        yield word, sum(verdict.verdict == word for verdict in verdicts)
