"""The report: all fits, the verdicts and the conclusions."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fullbody.fitting import Fit
from tqdm import tqdm

from ..judging import LIMIT, counts, verdicts_table
from ..publishing import pictures, publish
from . import catalogue, eris, figures, findings, haumea, lempo, observations

__all__ = ["DRAFT", "write"]

#: The systems of a draft, which also leaves out Lempo and Haumea.
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
    verdicts = [verdict for refit in result.catalogue for verdict in catalogue.verdicts(refit)]
    verdicts += eris.verdicts(result.eris)
    drawn = {"catalogue": figures.catalogue(result.catalogue), "eris": figures.eris(result.eris)}
    if result.lempo is not None:
        verdicts += lempo.verdicts(result.lempo)
    if result.haumea is not None:
        verdicts += haumea.verdicts(result.haumea)
        drawn["poles"] = figures.poles(result.haumea)
    numbers = {
        "draft": draft,
        "counts": counts(verdicts),
        "within": [refit.catalogued.name for refit in result.catalogue if refit.holds],
        "systems": len(result.catalogue),
        "tested": findings.TESTED,
        "findings": findings.findings(result.catalogue, result.eris, result.lempo, result.haumea),
        "verdicts": [asdict(verdict) for verdict in verdicts],
        "fits": _fits(result),
        "figures": {name: figures.CAPTIONS[name] for name in drawn},
    }
    return publish(folder, drawn, numbers, _text)


def _fits(result: Results) -> dict[str, Any]:
    """Return the numbers of each fit by its name."""
    fits: dict[str, Any] = {refit.catalogued.name: refit.fit for refit in result.catalogue}
    for system, study in (("Eris", result.eris), ("Lempo", result.lempo), ("Haumea", result.haumea)):
        for name, fit in vars(study).items() if study is not None else ():
            for key, part in fit.items() if isinstance(fit, dict) else [("", fit)]:
                if isinstance(part, Fit):
                    fits[" ".join(str(text) for text in (system, name, key) if text != "")] = part
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


def _text(numbers: dict[str, Any]) -> str:
    sections = "\n\n".join(f"## {title}\n\n" + "\n\n".join(texts) for title, texts in numbers["findings"].items())
    return f"""# Binaries beyond Neptune, fitted again

{numbers["program"]}{", a draft: a few systems" if numbers["draft"] else ""}. \
{len(numbers["within"])} of {numbers["systems"]} systems of the catalogue have a, the period, e and i within {LIMIT:g} \
joint standard errors. Verdicts: {", ".join(f"{number} {word}" for word, number in numbers["counts"].items())}.

A number *holds* if it is within {LIMIT:g} joint standard errors, the root of the sum of both squares, and *differs* \
otherwise; the difference is in units of this error. {numbers["tested"]} Nothing is tuned.

{sections}

{pictures(numbers["figures"])}

## Verdicts

{verdicts_table(numbers["verdicts"])}
"""
