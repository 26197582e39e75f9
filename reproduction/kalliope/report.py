"""The report: the fits, the table of events, the verdicts, and the processor time of the parts of a fit."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from astropy.table import QTable

from ..judging import LIMIT, counts, stated, verdicts_table
from ..publishing import pictures, publish, table, with_error
from . import figures
from .interior import QUANTITIES
from .model import Light
from .study import DRAFT, LONGITUDES, PHASES, SHAPE, scale, study, timing, verdicts

__all__ = ["COLUMNS", "write"]

#: The nonlinear parameters in the order of the tables.
COLUMNS = ("radius", "longitude", "pole_longitude", "pole_latitude", "phase", "albedo", "period", "size")
#: The columns of the table of events that are times.
TIMES = ("begin", "umbra_begin", "total_begin", "deepest", "total_end", "umbra_end", "end")


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Fit everything and write the report; a draft takes every fifth magnitude, one start and few steps."""
    light = Light(5 if draft else 1)
    results = study(light, starts=False, draws=3, proposals=15, form=DRAFT) if draft else study(light)
    rows = verdicts(results)
    best = results.fits["with Linus' albedo"]
    shape, form = results.fits[SHAPE], results.form
    drawn = {
        "curves": figures.curves(light, best),
        "losses": figures.losses(light, best),
        "shape_curves": figures.curves(light, shape),
        "shape": figures.shape(form.shape(shape.values["size"], shape.values["coefficients"]), shape.values["radius"]),
    }
    exact = results.fits["a series and events, in exact gravity"]
    parts = timing(light, exact.minima[0].values)
    numbers = {
        "draft": draft,
        "counts": counts(rows),
        "verdicts": [asdict(verdict) for verdict in rows],
        "fits": {name: _numbers(fit) for name, fit in results.fits.items()},
        "minima": [_minimum(minimum) for minimum in exact.minima],
        "seconds": {"fit": results.seconds, "iterations": results.iterations, **parts},
        "events": _events(results.table),
        "shape_events": _events(results.shape_table),
        "figure": asdict(results.figure),
        "cores": [asdict(core) for core in results.cores],
        "figures": figures.CAPTIONS,
    }
    results.table.write(folder / "events.ecsv", overwrite=True)
    results.shape_table.write(folder / "shape_events.ecsv", overwrite=True)
    return publish(folder, drawn, numbers, lambda numbers: _text(numbers, results.form.degree))


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


def _events(events: QTable) -> dict[str, Any]:
    """Return a table of events as text: the head and the rows."""
    times = [name for name in TIMES if name in events.colnames]
    rows = []
    for row in events:
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
            with_error(f"{fit['values'][column]:.5g}", fit["scale"] * fit["sigma"][column], fit["message"])
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


def figure_table(figure: dict[str, Any]) -> str:
    """Return the table of the figure of the free form in Markdown."""
    names = {"C20": "C20, radius of equal volume", "diameter": "diameter of equal volume", "density": "density"}
    rows = [
        [
            f"{names.get(name, f'half the extent along {name}')}{f' [{unit}]' if unit else ''}",
            stated(figure["values"][name], figure["errors"][name]),
            f"{figure['by_prior'][name]:.2g}",
        ]
        for name, unit in QUANTITIES.items()
    ]
    return table(["quantity", "fitted", "error by the prior alone"], rows)


def cores_table(cores: list[dict[str, Any]]) -> str:
    """Return the table of interiors in Markdown."""
    rows = [
        [core["name"], f"{core['radius']:.0f}", f"{core['mantle']:.2f}", f"{core['c20']:.3f}", f"{core['chi2']:.2f}"]
        for core in cores
    ]
    return table(["interior", "radius of the core [km]", "density of the mantle [g/cm3]", "C20", "chi2"], rows)


def seconds_table(seconds: dict[str, Any]) -> str:
    """Return the table of the processor time in Markdown."""
    parts = [(name, value) for name, value in seconds.items() if name not in ("fit", "iterations")]
    return table(["part of an iteration", "seconds"], [[name, f"{value:.3f}"] for name, value in parts])


def _text(numbers: dict[str, Any], degree: int) -> str:
    best, shape = numbers["fits"]["with Linus' albedo"], numbers["fits"][SHAPE]
    radius, albedo = (
        stated(best["values"][name], best["scale"] * best["sigma"][name]) for name in ("radius", "albedo")
    )
    event_table, shape_events = numbers["events"], numbers["shape_events"]
    return f"""# The mutual events of Kalliope and Linus

{numbers["program"]}{", a draft with a part of the magnitudes" if numbers["draft"] else ""}. Four light curves of \
27 to 29 November 2021, fitted by a Fourier series of order 10 in the rotation angle of Kalliope, a zero \
point for each curve, and the events of two ellipsoids that move in their exact gravity. Linus has a radius of \
{radius} km and {albedo} of the albedo of Kalliope. Errors are those of the fit times \
the root of chi2 over the degrees of freedom, here {best["scale"]:.2f}, in parentheses where a fit stopped before a \
minimum. Nothing is tuned. Radii are in km, angles in \
degrees, poles in the ecliptic.

## Fits

{fits_table(numbers["fits"])}

Minima in exact gravity, from {len(LONGITUDES) * len(PHASES)} starts on a grid of the two phases at the published pole:

{minima_table(numbers["minima"])}

## Events

{table(event_table["head"], event_table["rows"])}

Times are UTC by the clock of the observer; eclipses have the contacts of the penumbra and of the umbra. The depth is \
the largest loss of the light of both bodies.

## A free form

Kalliope is a series of harmonics of degree {degree} of the logarithm of its radius, with a prior on its \
coefficients that makes it smooth, and Linus a sphere; both move in their exact gravity. There is \
no series in the rotation angle. The published diameter is the prior of the size. The pole, the period of the orbit \
and the size are free too, and the separation is \
the published one. The posterior is the normal distribution of the fit: no samples are drawn from the exact one.

{figure_table(numbers["figure"])}

Errors are those of draws from the fit, times the root of chi2 over the degrees of freedom, {shape["scale"]:.2f}. \
Half an extent is no semi-axis of an ellipsoid. The last column has the errors of draws from the prior alone.

{cores_table(numbers["cores"])}

Shape and orbit are those of the fit: chi2 would rise less if the orbit were fitted again.

{table(shape_events["head"], shape_events["rows"])}

{pictures(numbers["figures"])}

## Verdicts

A number *holds* if it is within {LIMIT:g} joint standard errors, and *differs* otherwise.

{verdicts_table(numbers["verdicts"])}

## Time

The fit in exact gravity from the best of the starts takes {numbers["seconds"]["fit"]:.1f} s of processor time for \
{numbers["seconds"]["iterations"]} iterations.

{seconds_table(numbers["seconds"])}
"""
