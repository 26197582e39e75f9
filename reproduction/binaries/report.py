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
    """Everything that was fitted; a draft has no triples."""

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
    found = compute(draft, progress)
    verdicts = [one for refit in found.catalogue for one in catalogue.verdicts(refit)] + eris.verdicts(found.eris)
    drawn = {"catalogue": figures.catalogue(found.catalogue), "eris": figures.eris(found.eris)}
    if found.lempo is not None:
        verdicts += lempo.verdicts(found.lempo)
    if found.haumea is not None:
        verdicts += haumea.verdicts(found.haumea)
        drawn["poles"] = figures.poles(found.haumea)
    learned = findings.findings(found.catalogue, found.eris, found.lempo, found.haumea)
    numbers = {
        "program": f"fullbody {fullbody.__version__}",
        "draft": draft,
        "counts": counts(verdicts),
        "within": [one.catalogued.name for one in found.catalogue if one.holds],
        "systems": len(found.catalogue),
        "tested": TESTED,
        "findings": learned,
        "verdicts": [asdict(one) for one in verdicts],
        "fits": _fits(found),
        "figures": {name: figures.CAPTIONS[name] for name in drawn},
    }
    return publish(folder, _text(numbers, verdicts), drawn, numbers)


def _fits(found: Results) -> dict[str, Any]:
    """Return each fit in numbers."""
    fits: dict[str, Any] = {one.catalogued.name: one.fit for one in found.catalogue}
    for what, study in (("Eris", found.eris), ("Lempo", found.lempo), ("Haumea", found.haumea)):
        for name, fit in vars(study).items() if study is not None else ():
            for key, one in fit.items() if isinstance(fit, dict) else [("", fit)]:
                if isinstance(one, Fit):
                    fits[" ".join(str(part) for part in (what, name, key) if part != "")] = one
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
            one.system,
            one.quantity,
            one.published,
            one.fitted,
            "" if one.difference is None else f"{one.difference:+.2f}",
            one.verdict,
            one.why,
        ]
        for one in verdicts
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
