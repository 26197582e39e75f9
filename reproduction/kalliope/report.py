"""The report: the fits, the table of events, the verdicts, and the processor time of the parts of a fit."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import fullbody
import numpy as np

from ..binaries.judging import LIMIT, Verdict, counts
from ..publishing import publish, table
from . import figures
from .model import Light
from .study import LONGITUDES, PHASES, Results, scale, shown, study, timing, verdicts

__all__ = ["COLUMNS", "write"]

#: The nonlinear parameters in the order of the tables.
COLUMNS = ("radius", "longitude", "pole_longitude", "pole_latitude", "phase", "albedo")
#: The columns of the table of events that are times.
TIMES = ("begin", "umbra_begin", "total_begin", "deepest", "total_end", "umbra_end", "end")


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Fit everything and write the report; a draft takes every fifth magnitude, one start and few steps."""
    light = Light(5 if draft else 1)
    results = study(light, starts=False, draws=3, proposals=15) if draft else study(light)
    rows = verdicts(results)
    best = results.fits["with Linus' albedo"]
    drawn = {"curves": figures.curves(light, best), "losses": figures.losses(light, best)}
    exact = results.fits["a series and events, in exact gravity"]
    parts = timing(light, exact.minima[0].values)
    numbers = {
        "program": f"fullbody {fullbody.__version__}",
        "draft": draft,
        "counts": counts(rows),
        "verdicts": [asdict(verdict) for verdict in rows],
        "fits": {name: _numbers(fit) for name, fit in results.fits.items()},
        "minima": [_minimum(minimum) for minimum in exact.minima],
        "seconds": {"fit": results.seconds, "iterations": results.iterations, **parts},
        "events": _events(results),
        "figures": figures.CAPTIONS,
    }
    results.table.write(folder / "events.ecsv", overwrite=True)
    return publish(folder, _text(numbers, rows, results), drawn, numbers)


def _numbers(fit: Any) -> dict[str, Any]:
    return {
        "chi2": fit.chi2,
        "dof": fit.dof,
        "scale": scale(fit),
        "values": dict(fit.values),
        "sigma": dict(fit.sigma),
        "correlation": fit.correlation.tolist(),
        "iterations": fit.iterations,
        "message": fit.message,
    }


def _minimum(minimum: Any) -> dict[str, Any]:
    return {**minimum.values, "chi2": minimum.chi2, "starts": minimum.starts, "message": minimum.message}


def _events(results: Results) -> dict[str, Any]:
    """Return the table of events as text: the head and the rows."""
    times = [name for name in TIMES if name in results.table.colnames]
    rows = []
    for row in results.table:
        contacts = ["-" if np.any(getattr(row[name], "mask", False)) else str(row[name].iso)[:19] for name in times]
        for name in ("begin", "end"):
            error = float(row[f"{name}_error"].value)
            if np.isfinite(error):
                contacts[times.index(name)] += f" +- {error:.0f} s"
        rows.append([row["kind"], row["body"], row["by"], *contacts, f"{float(row['depth'].value):.3f}"])
    return {"head": ["kind", "body", "by", *(name.replace("_", " ") for name in times), "depth, mag"], "rows": rows}


def fits_table(fits: dict[str, Any]) -> str:
    """Return the table of the fits in Markdown, from their numbers."""
    rows = []
    for name, fit in fits.items():
        cells = [
            f"{fit['values'][column]:.5g} +- {fit['scale'] * fit['sigma'][column]:.2g}"
            if column in fit["values"]
            else "-"
            for column in COLUMNS
        ]
        rows.append([name, f"{fit['chi2']:.0f} of {fit['dof']}", *cells, fit["message"]])
    return table(["model", "chi2", *(column.replace("_", " ") for column in COLUMNS), ""], rows)


def minima_table(minima: list[dict[str, Any]]) -> str:
    """Return the table of the minima in Markdown."""
    names = [name for name in COLUMNS if name in minima[0]]
    rows = [
        [
            f"{minimum['chi2']:.1f}",
            *(f"{minimum[name]:.5g}" for name in names),
            str(minimum["starts"]),
            minimum["message"],
        ]
        for minimum in minima
    ]
    return table(["chi2", *(name.replace("_", " ") for name in names), "starts", ""], rows)


def seconds_table(seconds: dict[str, Any]) -> str:
    """Return the table of the processor time in Markdown."""
    parts = [(name, value) for name, value in seconds.items() if name not in ("fit", "iterations")]
    return table(["part of an iteration", "seconds"], [[name, f"{value:.3f}"] for name, value in parts])


def _text(numbers: dict[str, Any], rows: list[Verdict], results: Results) -> str:
    head = ["system", "quantity", "published", "here", "difference", "verdict", "why"]
    cells = [
        [
            row.system,
            row.quantity,
            row.published,
            row.fitted,
            "" if row.difference is None else f"{row.difference:+.2f}",
            row.verdict,
            row.why,
        ]
        for row in rows
    ]
    pictures = "\n\n".join(f"![{caption}]({name}.png)\n\n*{caption}*" for name, caption in numbers["figures"].items())
    best = results.fits["with Linus' albedo"]
    event_table = numbers["events"]
    return f"""# The mutual events of Kalliope and Linus

{numbers["program"]}{", a draft with a part of the magnitudes" if numbers["draft"] else ""}. Four light curves of \
27 to 29 November 2021, fitted by a Fourier series of order 10 in the rotation angle of Kalliope, a zero \
point for each curve, and the events of two ellipsoids that move in their exact gravity. Linus has a radius of \
{shown(best, "radius")} km and {shown(best, "albedo")} of the albedo of Kalliope. Errors are those of the fit times \
the root of chi2 over the degrees of freedom, here {scale(best):.2f}. Nothing is tuned. Radii are in km, angles in \
degrees, poles in the ecliptic.

## Fits

{fits_table(numbers["fits"])}

Minima in exact gravity, from {len(LONGITUDES) * len(PHASES)} starts on a grid of the two phases at the published pole:

{minima_table(numbers["minima"])}

## Events

{table(event_table["head"], event_table["rows"])}

Times are UTC by the clock of the observer; eclipses have the contacts of the penumbra and of the umbra. The depth is \
the largest loss of the light of both bodies.

{pictures}

## Verdicts

A number *holds* if it is within {LIMIT:g} joint standard errors, and *differs* otherwise.

{table(head, cells)}

## Time

The fit in exact gravity from the best of the starts takes {numbers["seconds"]["fit"]:.1f} s of processor time for \
{numbers["seconds"]["iterations"]} iterations.

{seconds_table(numbers["seconds"])}
"""
