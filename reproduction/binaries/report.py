"""The report: everything fitted, the verdicts, and what was learned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import fullbody
from fullbody.fitting import Fit
from tqdm import tqdm

from ..publishing import publish, table
from . import catalogue, eris, figures, findings, haumea, lempo, observations
from .judging import LIMIT, TESTED, Verdict, counts

__all__ = ["DRAFT", "write"]

#: The systems of a draft, which leaves out Lempo and Haumea too.
DRAFT = ("1998_ww31", "2001_uq18", "2001_xr254")


@dataclass(frozen=True)
class Results:
    """All fits of the study; a draft has no triples."""

    catalogue: list[catalogue.Refit]
    eris: eris.Eris
    lempo: lempo.Lempo | None
    haumea: haumea.Haumea | None


def compute(draft: bool, progress: bool) -> Results:
    """Fit everything."""
    names = DRAFT if draft else observations.NAMES
    refits = [catalogue.refit(name) for name in tqdm(names, "binaries", disable=not progress)]
    return Results(refits, eris.study(), None if draft else lempo.study(), None if draft else haumea.study())


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Fit everything and write the report."""
    result = compute(draft, progress)
    verdicts = [entry for refit in result.catalogue for entry in catalogue.verdicts(refit)] + eris.verdicts(result.eris)
    drawn = {"catalogue": figures.catalogue(result.catalogue), "eris": figures.eris(result.eris)}
    if result.lempo is not None:
        verdicts += lempo.verdicts(result.lempo)
    if result.haumea is not None:
        verdicts += haumea.verdicts(result.haumea)
        drawn["poles"] = figures.poles(result.haumea)
    learned = findings.findings(result.catalogue, result.eris, result.lempo, result.haumea)
    numbers = {
        "program": f"fullbody {fullbody.__version__}",
        "draft": draft,
        "counts": counts(verdicts),
        "within": [entry.catalogued.name for entry in result.catalogue if entry.holds],
        "systems": len(result.catalogue),
        "tested": TESTED,
        "findings": learned,
        "verdicts": [asdict(entry) for entry in verdicts],
        "fits": _fits(result),
        "figures": {name: figures.CAPTIONS[name] for name in drawn},
    }
    return publish(folder, _text(numbers, verdicts), drawn, numbers)


def _fits(result: Results) -> dict[str, Any]:
    """Return each fit in numbers."""
    fits: dict[str, Any] = {entry.catalogued.name: entry.fit for entry in result.catalogue}
    for what, study in (("Eris", result.eris), ("Lempo", result.lempo), ("Haumea", result.haumea)):
        for name, fit in vars(study).items() if study is not None else ():
            for key, entry in fit.items() if isinstance(fit, dict) else [("", fit)]:
                if isinstance(entry, Fit):
                    fits[" ".join(str(part) for part in (what, name, key) if part != "")] = entry
    return {
        name: {
            "chi2": fit.chi2,
            "dof": fit.dof,
            "p_value": fit.p_value,
            "values": dict(fit.values),
            "sigma": dict(fit.sigma),
            "correlation": fit.correlation.tolist(),
            "at_bounds": list(fit.at_bounds),
            "differenced": dict(fit.differenced),
        }
        for name, fit in fits.items()
    }


def _text(numbers: dict[str, Any], verdicts: Sequence[Verdict]) -> str:
    rows = [
        [
            entry.system,
            entry.quantity,
            entry.published,
            entry.fitted,
            "" if entry.difference is None else f"{entry.difference:+.2f}",
            entry.verdict,
            entry.why,
        ]
        for entry in verdicts
    ]
    head = ["system", "quantity", "published", "here", "difference", "verdict", "why"]
    told = "\n\n".join(f"## {title}\n\n" + "\n\n".join(texts) for title, texts in numbers["findings"].items())
    pictures = "\n\n".join(f"![{caption}]({name}.png)\n\n*{caption}*" for name, caption in numbers["figures"].items())
    return f"""# Binaries beyond Neptune, fitted again

{numbers["program"]}{", a draft: a few systems" if numbers["draft"] else ""}. \
{len(numbers["within"])} of {numbers["systems"]} systems of the catalogue have a, the period, e and i within {LIMIT:g} \
joint standard errors. Verdicts: {", ".join(f"{number} {word}" for word, number in numbers["counts"].items())}.

A number *holds* if it is within {LIMIT:g} joint standard errors, the root of the sum of both squares, and *differs* \
otherwise; the difference is in units of this error. {numbers["tested"]} Nothing is tuned.

{told}

{pictures}

## Verdicts

{table(head, rows)}
"""
