"""The report: all parts of the study, run one after another, and their text."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fullbody
import numpy as np
from fullbody.base.atomic import replacing

from ..publishing import listed, percent, publish, table
from . import axes, earth, figures, inputs, knowledge, mission, results, study

if TYPE_CHECKING:
    import xarray

__all__ = ["REFUTED", "RESULTS", "after_hera", "write"]

#: The results of the study that the repository contains.
RESULTS: Final = Path(__file__).parent / "kept"
#: Members whose light curves are computed.
CURVES: Final = 24
REFUTED: Final = {
    "tumbling": "the long axis of Dimorphos does not remain within 60 degrees of the direction to Didymos; no member "
    "does this",
    "rolling": "Dimorphos rolls, and b/c is below 1.05, or the eccentricity is above 0.027, or the obliquity is below "
    "7 degrees",
    "locked": "Dimorphos is locked, and its long axis swings by more than 40 degrees to either side of Didymos, or its "
    "obliquity is above 30 degrees",
    "locked, with apses that advance by 6.1 to 7.3 degrees a day": "b/c is above 1.25, or the eccentricity below 0.02",
    "period": "the period has changed since the months after the impact by more than 90 seconds",
}


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything that is not in the folder yet, and write the report."""
    count = 2 if draft else int(os.environ.get("HERA_MEMBERS", "24"))
    with study.workers() as executor:
        found = results.kept(study.sweep(folder, count, progress, executor=executor))
    results.save(found, folder / "members.nc")
    over_axes = axes.sweep(folder, draft, progress)
    shown = np.flatnonzero(found.fate.values[: results.KEPT] == "bound")[: 2 if draft else CURVES]
    curves = _remembered(folder / "night.json", lambda: earth.night(on_rows(found), shown))
    survey = _remembered(folder / "survey.json", lambda: after_hera(found, progress))
    return assemble(folder, found, over_axes, curves, survey)


def assemble(
    folder: Path, found: xarray.Dataset, over_axes: xarray.Dataset, curves: dict[str, Any], survey: dict[str, Any]
) -> Path:
    """Write the report, its figures and its numbers from the results of all parts."""
    everyone, seen = np.ones(found.sizes["row"], dtype=bool), results.consistent(found)
    numbers: dict[str, Any] = {
        "program": f"fullbody {fullbody.__version__}",
        "dated": inputs.DATED,
        "arrival": inputs.ARRIVAL,
        "members": int(found.sizes["row"]),
        "apses as observed": int(seen.sum()),
        "outcomes": {name: shares(found, chosen) for name, chosen in (("all", everyone), ("apses as observed", seen))},
        "predictions": {
            name: results.predictions(found, chosen)
            for name, chosen in (
                ("all", everyone),
                ("apses as observed", seen),
                ("locked", found.outcome.values == "locked"),
                ("rolling", found.outcome.values == "rolling"),
            )
        },
        "sensitivities": results.sensitivities(found, everyone),
        "survey": survey,
        "night": events(curves),
    }
    drawn = {
        "outcomes": figures.outcomes(found, over_axes),
        "angles": figures.angles(found),
        "night": figures.night(curves),
        "sensitivity": figures.sensitivity(numbers["sensitivities"]),
    }
    return publish(folder, text(numbers), drawn, numbers)


def _remembered(file: Path, make: Any) -> dict[str, Any]:
    """What a part has left in a file, or what it makes now."""
    if not file.exists():
        made = make()
        with replacing(file) as temporary:
            temporary.write_text(json.dumps(made, default=lambda value: np.asarray(value).tolist()))
    found: dict[str, Any] = json.loads(file.read_text())
    return found


def on_rows(found: xarray.Dataset) -> xarray.Dataset:
    """The members whose states are kept, with the states along the rows."""
    few = found.isel(row=slice(found.sizes["kept"]))
    return few.drop_dims("kept").assign(state=(("row", "body", "component"), found.state.values))


def shares(found: xarray.Dataset, chosen: Any) -> dict[str, float]:
    """The share of each outcome among some members."""
    words = found.outcome.values[chosen]
    return {word: float(np.mean(words == word)) for word in np.unique(found.outcome.values)} if len(words) else {}


def events(curves: dict[str, Any]) -> dict[str, list[float]]:
    """Median and spread of the middles and durations of the mutual events of a night, hours."""
    told = {}
    for kind, values in curves["events"].items():
        middle, long = np.array(values, dtype=float).T
        told[kind] = [
            float(value) for value in (np.nanmedian(middle), np.nanstd(middle), np.nanmedian(long), np.nanstd(long))
        ]
    shift = np.array(curves["shift"])
    told["time of the first"] = [float(np.mean(shift)), float(np.std(shift))]
    return told


def after_hera(found: xarray.Dataset, progress: bool = False) -> dict[str, Any]:
    """What is known of the pair today, and after two weeks of simulated data of one member."""
    member = int(np.flatnonzero(found.fate.values[: results.KEPT] == "bound")[0])
    truth = knowledge.of_member(on_rows(found).isel(row=member))
    return {"member": member, **knowledge.table(found, truth, mission.fitted(truth, progress))}


def text(numbers: dict[str, Any]) -> str:
    """The report as Markdown."""
    shares_ = [[name, *(percent(value) for value in row.values())] for name, row in numbers["outcomes"].items() if row]
    kinds = list(next(iter(numbers["outcomes"].values())))
    groups = numbers["predictions"]
    predicted = [
        [name, unit, *(interval(groups[group][name]) for group in groups)] for name, unit in results.PREDICTED.items()
    ]
    sky = [
        [kind, f"{row[0]:.2f} +- {row[1]:.2f}", f"{row[2]:.2f} +- {row[3]:.2f}"]
        for kind, row in numbers["night"].items()
        if len(row) == 4
    ]
    first = numbers["night"]["time of the first"]
    survey = [[name, row["unit"], row["today"], row["after"]] for name, row in numbers["survey"]["rows"].items()]
    return f"""# What Hera should find: a prediction of {numbers["dated"]}

{numbers["program"]}, {numbers["members"]} members from the impact of DART to {numbers["arrival"][:10]}, of which \
{numbers["apses as observed"]} show the published advance of the apses within three errors over their first 67 days.

![Outcomes over the axis ratios](outcomes.png)

{table(["share of", *kinds], shares_)}

## At arrival

The table gives the median and, in brackets, the limits of the middle 90 per cent. The period is that of the fit and \
not a prediction.

{table(["", "unit", *groups], predicted)}

![Yaw and roll over the last days](angles.png)

## Which inputs matter

![Rank correlations](sensitivity.png)

## Known today, and after Hera

The data are simulated for two weeks and member {numbers["survey"]["member"]}, with one pass at \
{numbers["survey"]["closest"][0]:.0f} km and one at {numbers["survey"]["closest"][1]:.0f} km. \
Errors are standard errors.

{table(["", "unit", "today", "after two weeks"], survey)}

## From the Earth

![A day's light curve](night.png)

Times are hours after the middle of an occultation of Dimorphos by Didymos on {earth.NIGHT[:10]}. The time of this \
occultation is not known: its standard deviation over the members is {first[1]:.1f} hours.

{table(["", "middle (h)", "duration (h)"], sky)}

## What would refute this

{listed(REFUTED)}

## Assumed

{listed(inputs.ASSUMED)}

## Published inputs

{inputs_table()}

{chr(10).join(f"- [{key}] {source}" for key, source in inputs.SOURCES.items())}
"""


def inputs_table() -> str:
    """The table of inputs as Markdown."""
    rows = [
        [
            name,
            f"{one.value:.10g} +- {one.sigma:.4g}",
            one.unit,
            one.source + (", second-hand" if one.second_hand else ""),
            one.note,
        ]
        for name, one in inputs.INPUTS.items()
    ]
    return table(["input", "value", "unit", "source", ""], rows)


def interval(three: Any) -> str:
    middle, low, high = three
    return "-" if not np.isfinite(middle) else f"{middle:.5g} ({low:.5g} to {high:.5g})"
