"""The map of fates after fission, what is counted in it, and the report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import fullbody
import numpy as np
from fullbody import Run, State, System, Verner98, events, observables

from ..judging import word
from ..publishing import formatted, listed, percent, publish, table
from . import figures, paper
from .starts import CASES, fission, spin_limit

if TYPE_CHECKING:
    import xarray

__all__ = ["counts", "sweep", "write"]

#: Hours in a day.
DAY = 24.0
GRID = {
    "excess": [0.0, 0.01],
    "case": list(CASES),
    "mass_ratio": np.round(np.arange(1, 38) * 0.01, 2),
    "tilt": np.arange(0.0, 90.0, 2.0),
}
DRAFT = {**GRID, "mass_ratio": [0.05, 0.25], "tilt": [0.0, 4.0, 44.0]}
#: Events that end a run early.
ENDS = (events.Contact(0, 1, terminal=True), events.Escape(0, 1, distance=100.0, terminal=True))


def setup(excess: float, case: str, mass_ratio: float, tilt: float) -> tuple[System, State]:
    """Return the start, with spin and velocity larger by ``excess`` than those of the limit, relative to them."""
    system, state = fission(case, mass_ratio, tilt)
    return system, state.replace(velocity=state.velocity * (1 + excess), spin=state.spin * (1 + excess))


def measure(run: Run) -> dict[str, Any]:
    """Return the fate of a run, the largest separation, and when the secondary reached its spin limit."""
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    secondary: Any = run.system["secondary"]
    spin = np.linalg.norm(run.spin[:, 1], axis=1) / spin_limit(secondary.shape.semi_axes, secondary.density)
    fast = np.flatnonzero(spin >= 1.0)
    values = {"farthest": distance.max() / distance[0], "spin": spin.max()}
    values["fission"] = run.time[fast[0]] if len(fast) else None
    return observables.fate(run).as_dict() | observables.drift(run).as_dict() | values


def sweep(folder: Path | None, draft: bool = False, progress: bool = False, **options: Any) -> xarray.Dataset:
    """Return the map; runs are saved in the folder as they end."""
    return fullbody.sweep(
        setup,
        DRAFT if draft else GRID,
        (2.0 if draft else 200.0) * DAY,
        measure=measure,
        output=None,
        integrator=Verner98(1e-10, 1e-10),
        events=ENDS,
        store=None if folder is None else folder / "map.nc",
        key="ho2022",
        progress=progress,
        **options,
    )


def counts(dataset: xarray.Dataset) -> dict[str, Any]:
    """Return the shares of fates and of secondary fission, by excess and case; times in hours."""
    result: dict[str, Any] = {}
    for excess in dataset.excess.values:
        part = dataset.sel(excess=excess)
        cases = {str(case): _counts(part.sel(case=case)) for case in dataset.case.values}
        result[f"{excess:g}"] = {"all": _counts(part), **cases}
    return result


def _counts(part: xarray.Dataset) -> dict[str, float]:
    impact, fission = part.fate == "contact", np.isfinite(part.fission)
    times = part.fission.values[fission.values]
    ends = part.fate_time.values[impact.values]
    return {
        "runs": part.fate.size,
        "impact": float(impact.mean()),
        **{fate: float((part.fate == fate).mean()) for fate in ("escape", "bound")},
        "errors": float((part.error != "").mean()),
        # The share of runs with an impact after the separation had grown by a tenth.
        "impact_after_separation": float((impact & (part.farthest > 1.1)).mean()),
        "impact_within_a_minute": float((impact & (part.fate_time < 1 / 60)).mean()),
        "impact_hours_median": float(np.median(ends)) if len(ends) else np.nan,
        "fission": float(fission.mean()),
        "fission_hours_median": float(np.median(times)) if len(times) else np.nan,
        "fission_within_5_hours": float((times < 5.0).mean()) if len(times) else np.nan,
        "largest_drift": float(part.energy_drift.max()),
    }


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything and write the report."""
    result = sweep(folder, draft, progress)
    shares = counts(result)
    numbers = {
        "paper": "Ho, Wold, Poursina & Conway (2022), A&A 665, A43, doi:10.1051/0004-6361/202243706",
        "draft": draft,
        "stated": paper.STATED,
        "assumed": paper.ASSUMED,
        "counts": shares,
        "verdicts": verdicts(shares),
    }
    return publish(folder, figures.all_figures(result), numbers, _text)


def verdicts(shares: dict[str, Any]) -> list[dict[str, str]]:
    """Compare the statements of the abstract with the shares of runs, at the limit and above it."""
    results = []
    for excess, part in shares.items():
        start = "at the limit" if float(excess) == 0.0 else f"{100 * float(excess):g} per cent above it"
        total = part["all"]
        rapid = f"{percent(total['fission_within_5_hours'])} of {percent(total['fission'])} of the runs"
        rows = [("impacts", "more than 80 %", percent(total["impact"]), total["impact"] > 0.8)]
        for quantity, name in (("impact", "impacts"), ("fission", "secondary fission")):
            for cases, by in ((("A1", "A2", "A3"), "less dense"), (("B3", "B2", "B1"), "more elongated")):
                first, second, third = values = [part[case][quantity] for case in cases]
                text = ", ".join(f"{case} {percent(value)}" for case, value in zip(cases, values, strict=True))
                rows.append((f"{name}, {by}", "more common", text, first > second > third if any(values) else None))
        within = total["fission_within_5_hours"]
        rows.append(("secondary fission within 5 h", "typically", rapid, within > 0.5 if total["fission"] else None))
        results += [
            {"start": start, "quantity": quantity, "stated": stated, "result": text, "verdict": word(holds)}
            for quantity, stated, text, holds in rows
        ]
    return results


def _text(numbers: dict[str, Any]) -> str:
    rows = [list(verdict.values()) for verdict in numbers["verdicts"]]
    shares = ("impact", "impact_after_separation", "escape", "bound")
    fates = [
        [
            excess,
            case,
            *(percent(counts[name]) for name in shares),
            formatted(counts["impact_hours_median"], ".3g"),
            percent(counts["fission"]),
            formatted(counts["fission_hours_median"], ".3g"),
        ]
        for excess, part in numbers["counts"].items()
        for case, counts in part.items()
    ]
    head = ["excess", "case", "impact", "after separation", "escape", "bound", "impact, median h"]
    return f"""# Rotational fission: {numbers["paper"]}

{numbers["program"]}{", a draft: a small grid and short runs" if numbers["draft"] else ""}. Only the abstract was \
available. The table compares its statements with the results of this study; what it does not state is assumed.

{table(["start", "quantity", "the paper", "here", "verdict"], rows)}

![Fates at the limit](fates-0.png)

![Fates above the limit](fates-1.png)

![Secondary fission](fission.png)

The torque turns a tilted secondary back into line from the start. Exactly at the limit nothing separates the bodies, \
so that this rotation alone closes the gap of 1 cm, mostly within a minute: these bodies stay in contact rather than \
collide. "After separation" counts the impacts of bodies whose distance had grown by more than a tenth before.

{table([*head, "secondary fission", "its time, median h"], fates)}

## Stated

{listed(numbers["stated"])}

## Assumed

{listed(numbers["assumed"])}
"""
