"""The report: all parts of the study, run one after another, and their text."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from fullbody.base.atomic import replacing

from ..judging import stated
from ..publishing import listed, percent, publish, table
from . import (
    axes,
    binary_yarkovsky,
    convergence,
    earth,
    figures,
    inputs,
    knowledge,
    mission,
    posterior,
    results,
    study,
    weights,
)

if TYPE_CHECKING:
    import xarray

__all__ = ["RESULTS", "survey_errors", "write"]

#: The results of the study that the repository contains.
RESULTS: Final = Path(__file__).parent / "stored"
#: The number of members whose light curves are computed.
CURVES: Final = 24
#: Numbers of runs with the shape of Didymos of Daly et al. (2023).
OLDER_SHAPE: Final = study.Sizes(300, 500, 60.0)


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything that is not in the folder yet, and write the report.

    The variable HERA_WHOLE selects the numbers of runs of the page; without it the study is a small one.
    """
    full = bool(os.environ.get("HERA_WHOLE"))
    sizes = study.Sizes(200, 60, 4.0) if draft else study.FULL if full else study.SMALL
    with study.workers() as executor:
        candidates, result = study.members(folder, sizes, progress=progress, executor=executor)
        older = study.members(folder, OLDER_SHAPE, "daly2023", progress, executor=executor)[1] if full else None
        cases = _stored(folder / "convergence.json", lambda: convergence.by_case(folder, result)) if full else {}
    members = results.stored(result)
    results.save(members, folder / "members.nc")
    map_of_axes = axes.sweep(folder, draft, progress)
    rows = with_states(members)
    curves = _stored(folder / "night.json", lambda: earth.night(rows, np.arange(rows.sizes["row"])[:CURVES]))
    survey = _stored(folder / "survey.json", lambda: survey_errors(members, progress))
    return assemble(folder, sizes, candidates, members, older, cases, map_of_axes, curves, survey)


def assemble(
    folder: Path,
    sizes: study.Sizes,
    candidates: xarray.Dataset,
    dataset: xarray.Dataset,
    older: xarray.Dataset | None,
    cases: dict[str, Any],
    map_of_axes: xarray.Dataset,
    curves: dict[str, Any],
    survey: dict[str, Any],
) -> Path:
    """Write the report, its figures and its numbers from the results of all parts."""
    all_rows = np.ones(dataset.sizes["row"], dtype=bool)
    weight = weights.normalized(candidates.log_weight.values)
    groups = {"all": (all_rows, 1.0), "all, with the change": (all_rows, weights.EVIDENCE)}
    groups |= {word: (dataset.outcome.values == word, 1.0) for word in ("locked", "rolling")}
    predictions = {name: results.predictions(dataset, *group) for name, group in groups.items()}
    axis = predictions["all"]["semi_major_axis"][0]
    mass, mass_error = results.masses(dataset)
    numbers: dict[str, Any] = {
        "dated": inputs.STUDY_DATE,
        "arrival": inputs.ARRIVAL,
        "pilot": sizes.pilot,
        "candidates": int(candidates.sizes["row"]),
        "candidates, effective": weights.effective(weight),
        "members": int(dataset.sizes["row"]),
        "changed": float(weight @ candidates.changed.values),
        "by_evidence": results.by_evidence(dataset),
        "by_date": results.by_date(dataset),
        "by_width": results.by_width(dataset),
        "by_number": convergence.by_number(dataset),
        "convergence": cases,
        "older shape": None if older is None else results.by_evidence(results.stored(older)),
        "predictions": predictions,
        "criteria": {
            name: [weights.share(results.normal_weights(dataset, ratio), rows) for ratio in (1.0, weights.EVIDENCE)]
            for name, rows in results.criteria(dataset).items()
        },
        "scores": [results.scores(dataset, ratio) for ratio in (1.0, weights.EVIDENCE)],
        "sensitivities": results.sensitivities(dataset),
        "posterior": results.prior_and_posterior(dataset),
        "mass": [mass, mass_error],
        "slope": posterior.slope(),
        "rival": binary_yarkovsky.consequences(binary_yarkovsky.RATE, axis),
        "survey": survey,
        "night": events(curves),
    }
    drawn = {
        "outcomes": figures.outcomes(dataset, map_of_axes),
        "angles": figures.angles(dataset),
        "night": figures.night(curves),
        "sensitivity": figures.sensitivity(numbers["sensitivities"]),
    }
    return publish(folder, drawn, numbers, text)


def _stored(file: Path, compute: Any) -> dict[str, Any]:
    """Return the result of a part from its file, which is written by the first call."""
    if not file.exists():
        computed = compute()
        with replacing(file) as temporary:
            temporary.write_text(json.dumps(computed, default=lambda value: np.asarray(value).tolist()))
    result: dict[str, Any] = json.loads(file.read_text())
    return result


def with_states(dataset: xarray.Dataset) -> xarray.Dataset:
    """Return the members whose states are stored, with the states along the rows."""
    members = dataset.isel(row=dataset.member.values.astype(int))
    return members.drop_dims("kept").assign(state=(("row", "body", "component"), dataset.state.values))


def events(curves: dict[str, Any]) -> dict[str, list[float]]:
    """Return median and spread of the middles and durations of the mutual events of a night, hours."""
    table_of_events = {}
    for kind, values in curves["events"].items():
        middle, duration = np.array(values, dtype=float).T
        numbers = np.nanmedian(middle), np.nanstd(middle), np.nanmedian(duration), np.nanstd(duration)
        table_of_events[kind] = [float(value) for value in numbers]
    return table_of_events


def survey_errors(dataset: xarray.Dataset, progress: bool = False) -> dict[str, Any]:
    """Return the standard errors of the pair today, and after two weeks of simulated data of one member."""
    truth = knowledge.truth_of_member(with_states(dataset).isel(row=0))
    return knowledge.table(results.reweighted(dataset), truth, mission.fitted(truth, progress))


def shares(value: float, error: float) -> str:
    """Return a share and its sampling error in per cent, without decimals."""
    return f"{100 * value:.0f} ± {100 * error:.0f} %"


def tables(numbers: dict[str, Any]) -> dict[str, str]:
    """Return the tables of the report as Markdown, by name."""
    evidence, older = (
        [[row["ratio"], shares(row["locked"], row["error"]), f"{row['effective']:.0f}"] for row in numbers[name] or []]
        for name in ("by_evidence", "older shape")
    )
    head = ["likelihood ratio of the report of a change", "locked", "effective members"]
    conditions = ["without the change", f"with it, at {weights.EVIDENCE:.0f} to 1"]
    keys = (("share", "error"), ("share_changed", "error_changed"))
    groups = numbers["predictions"]
    return {
        "evidence": table(head, evidence),
        "older": table(head, older),
        "dates": table(
            ["locked on", *conditions],
            [[row["date"], *(shares(row[a], row[b]) for a, b in keys)] for row in numbers["by_date"]],
        ),
        "widths": table(
            ["width of the prior of", "times", *conditions, "effective members"],
            [
                [
                    row["prior"],
                    f"{row['factor']:g}",
                    *(shares(row[a], row[b]) for a, b in keys),
                    f"{row['effective']:.0f}",
                ]
                for row in numbers["by_width"]
            ],
        ),
        "convergence": table(
            ["case", "locked", "same outcome", "period, s", "apses, deg/day"],
            [
                [
                    name,
                    percent(row["locked"]),
                    percent(row["same outcome"]),
                    f"{row['period']:.2g}",
                    f"{row['precession']:.2g}",
                ]
                for name, row in numbers["convergence"].items()
            ],
        ),
        "number": table(
            ["members", "locked, without the change"],
            [[count, shares(*row)] for count, row in numbers["by_number"].items()],
        ),
        "predictions": table(
            ["median (middle 90 per cent)", "unit", *groups],
            [
                [name.replace("_", " "), unit, *(interval(groups[group][name], digits) for group in groups)]
                for name, (unit, digits) in results.PREDICTED.items()
            ],
        ),
        "criteria": table(
            ["finding", "", *conditions],
            [
                [name, results.CRITERIA[name], *(f"{100 * share:.1f} %" for share, _ in row)]
                for name, row in numbers["criteria"].items()
            ],
        ),
        "scored": table(
            ["quantity", "error"], [[name.replace("_", " "), f"{width:g}"] for name, width in results.SCORED.items()]
        ),
        "events": table(
            ["event", "middle (h)", "duration (h)"],
            [
                [kind, f"{row[0]:.2f} ± {row[1]:.2f}", f"{row[2]:.2f} ± {row[3]:.2f}"]
                for kind, row in numbers["night"].items()
            ],
        ),
        "survey": table(
            ["standard error", "unit", "today", "after two weeks"],
            [[name, row["unit"], row["today"], row["after"]] for name, row in numbers["survey"]["rows"].items()],
        ),
        "posterior": table(
            ["input", "prior", "posterior"],
            [
                [name, *(stated(*row[k : k + 2]).replace("+-", "±") for k in (0, 2))]
                for name, row in numbers["posterior"].items()
            ],
        ),
        "inputs": inputs_table(),
    }


def text(numbers: dict[str, Any]) -> str:
    """Return the report as Markdown."""
    parts = tables(numbers)
    pictures = {"evidence": "outcomes", "predictions": "angles", "events": "night", "posterior": "sensitivity"}
    titles = {
        "evidence": "Locked or rolling",
        "older": "The same with the shape of Didymos of Daly et al. (2023)",
        "dates": "By date",
        "widths": "By the widths of priors",
        "number": "By the number of members",
        "convergence": "Numerical convergence",
        "predictions": "At arrival",
        "criteria": "Findings that the prediction makes improbable",
        "survey": "Standard errors today, and after Hera",
        "events": f"Mutual events after the first occultation of Dimorphos on {earth.NIGHT[:10]}",
        "posterior": "Inputs before and after the observations",
        "inputs": "Published inputs",
    }
    sections = []
    for name, title in titles.items():
        picture = f"![{title}]({pictures[name]}.png)\n\n" if name in pictures else ""
        sections.append(f"## {title}\n\n{picture}{parts[name]}\n")
    return (
        f"# What Hera should find: a prediction of {numbers['dated']}\n\n{numbers['program']}, {numbers['candidates']} "
        f"candidates and {numbers['members']} members, for {numbers['arrival'][:10]}.\n\n"
        + "\n".join(sections)
        + f"\n## Assumed\n\n{listed(inputs.ASSUMED)}\n\n## Left out\n\n{listed(inputs.OMITTED)}\n\n"
        + "\n".join(f"- [{key}] {source}" for key, source in inputs.SOURCES.items())
        + "\n"
    )


def inputs_table() -> str:
    """Return the table of inputs as Markdown."""
    rows = [
        [
            name,
            f"{value.value:.10g} ± {value.sigma:.4g}",
            value.unit,
            value.source + (", second-hand" if value.second_hand else ""),
            value.note,
        ]
        for name, value in inputs.INPUTS.items()
    ]
    return table(["input", "value", "unit", "source", ""], rows)


def interval(percentiles: Any, digits: int) -> str:
    """Return a median and the limits of an interval with a number of decimals; a dash for NaN."""
    middle, low, high = percentiles
    return "-" if not np.isfinite(middle) else f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"
