"""The report: the scans, the fits and their mirror poles, the shape, the verdicts and the processor time."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fullbody.fitting import Fit, PeriodScan

from ..judging import counts, verdicts_table
from ..publishing import pictures, publish, table, with_error
from . import figures
from .chords import MODEL_ERROR, PUBLISHED, Size
from .model import ERRORS
from .study import POLE_ERROR, error_scale, pole_of, study, timing, verdicts

__all__ = ["fits_table", "minima_table", "scan_title", "seconds_table", "shape_text", "sizes_table", "write"]

#: The parameters in the table of fits, with their digits after the point.
DIGITS = {"longitude": 2, "latitude": 2, "period": 8}
#: The text above the table of sizes.
SIZE_TEXT = (
    "The 18 chords of the stellar occultation of 11 December 2008 scale the shape from light, with its pole and its "
    "rotation angle. Free are the diameter of the sphere of the same volume, and the offset of ephemeris and star. "
    f"An error of {MODEL_ERROR.to_value('s'):g} s is added to those of the contacts for what the shape leaves out, and "
    "the error of a diameter is that of its fit times the root of chi2 over the degrees of freedom."
)


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Scan and fit everything and write the report; a draft takes a third of the magnitudes and a coarse shape."""
    results = study(draft, progress)
    rows = verdicts(results)
    numbers = {
        "draft": draft,
        "counts": counts(rows),
        "verdicts": [asdict(verdict) for verdict in rows],
        "magnitudes": {"nights": len(results.curves.nights), "surveys": len(results.curves.surveys)},
        "scans": {"one apparition": _scan(results.coarse), "all nights": _scan(results.scan)},
        "fits": {name: _fit(fit) for name, fit in results.fits.items()},
        "shape": asdict(results.shape),
        "sizes": {name: _size(size) for name, size in results.sizes.items()},
        "published sizes": {source: list(size) for source, size in PUBLISHED.items()},
        "seconds": results.seconds,
        "iteration": timing(results),
        "figures": figures.CAPTIONS,
    }
    return publish(folder, figures.all_figures(results), numbers, _text)


def _size(size: Size) -> dict[str, Any]:
    angle = size.fit.values["angle_correction"] if "angle_correction" in size.fit.names else None
    return {
        "diameter": size.diameter,
        "sigma": size.sigma,
        "chi2": size.fit.chi2,
        "dof": size.fit.dof,
        "rms": size.rms,
        "angle": None if angle is None else math.degrees(angle),
    }


def _scan(scan: PeriodScan) -> dict[str, Any]:
    lowest = [
        {
            "period": minimum.period.to_value("h"),
            "chi2": minimum.chi2,
            "longitude": minimum.longitude.to_value("deg"),
            "latitude": minimum.latitude.to_value("deg"),
        }
        for minimum in scan.minima[:5]
    ]
    ends = [float(period) for period in scan.periods[[0, -1]].to_value("h")]
    return {"periods": len(scan.periods), "ends": ends, "dof": scan.dof, "minima": lowest}


def _fit(fit: Fit) -> dict[str, Any]:
    minima = []
    for minimum in fit.minima:
        longitude, latitude = pole_of(minimum.values)
        period = minimum.values["period"].to_value("h")
        minima.append({"chi2": minimum.chi2, "longitude": longitude, "latitude": latitude, "period": period})
    errors = {
        "longitude": fit.sigma["longitude"].to_value("deg"),
        "latitude": fit.sigma["latitude"].to_value("deg"),
        "period": fit.sigma["period"].to_value("h"),
    }
    nights = fit.residuals[0]
    return {
        "chi2": fit.chi2,
        "dof": fit.dof,
        "scale": error_scale(fit),
        "rms": float((nights**2).mean() ** 0.5),
        "parameters": len(fit.parameters),
        "coefficients": fit.values["coefficients"].tolist(),
        "sigma": errors,
        "minima": minima,
        "iterations": fit.iterations,
        "message": fit.message,
    }


def minima_table(scan: dict[str, Any]) -> str:
    """Return the table of the lowest minima of a scan in Markdown, from its numbers."""
    names = ("period", "chi2", "longitude", "latitude")
    rows = [
        [f"{minimum[name]:.8g}" if name == "period" else f"{minimum[name]:.1f}" for name in names]
        for minimum in scan["minima"]
    ]
    return table(["period, h", "chi2", "longitude", "latitude"], rows)


def fits_table(fits: dict[str, Any]) -> str:
    """Return the table of the fits in Markdown: the best minimum of each, and that at the mirror pole."""
    rows = []
    for name, fit in fits.items():
        for k, minimum in enumerate(fit["minima"]):
            factor = fit["scale"]
            texts = {name: f"{minimum[name]:.{digits}f}" for name, digits in DIGITS.items()}
            if k == 0:
                texts = {
                    key: with_error(text, factor * fit["sigma"][key], fit["message"]) for key, text in texts.items()
                }
            rows.append(
                [
                    name if k == 0 else "its mirror pole",
                    f"{minimum['chi2']:.1f} of {fit['dof']}",
                    *texts.values(),
                    f"{fit['rms']:.4f}" if k == 0 else "",
                    fit["message"] if k == 0 else "",
                ]
            )
    return table(["fit", "chi2", "longitude", "latitude", "period, h", "rms of nights, mag", ""], rows)


def scan_title(name: str, scan: dict[str, Any]) -> str:
    """Return the range, the number of periods and the degrees of freedom of a scan, as a line above its table."""
    first, last = scan["ends"]
    return f"{name}, {scan['periods']} periods from {first:.7g} to {last:.7g} h, {scan['dof']} degrees of freedom:"


def shape_text(figure: dict[str, Any]) -> str:
    """Return a description of the shape in two sentences."""
    return (
        "The shape has the ratios of axes a/b = {:.3f} and b/c = {:.3f}, ".format(*figure["ratios"]) + "those of "
        "the homogeneous ellipsoid with the same moments of inertia. Its axis of largest inertia is "
        f"{figure['tilt']:.1f} degrees from the spin, although no prior asks for that, and a dark facet of "
        f"{100 * figure['dark']:.2f} % of the surface would close it."
    )


def sizes_table(numbers: dict[str, Any]) -> str:
    """Return the table of the diameters by the chords in Markdown, with the published ones."""
    rows = []
    for name, size in numbers["sizes"].items():
        angle = "" if size["angle"] is None else f"{size['angle']:+.1f}"
        chi2 = f"{size['chi2']:.0f} of {size['dof']}"
        rows.append([name, f"{size['diameter']:.1f} +- {size['sigma']:.1f}", chi2, f"{size['rms']:.2f}", angle])
    rows += [
        [source, "{:.2f} +- {:.2f}".format(*size), "", "", ""] for source, size in numbers["published sizes"].items()
    ]
    return table(["shape", "diameter, km", "chi2", "rms of contacts, s", "correction of the angle"], rows)


def seconds_table(numbers: dict[str, Any]) -> str:
    """Return the table of the processor time in Markdown."""
    rows = [[name, f"{value:.1f}"] for name, value in numbers["seconds"].items()]
    rows += [[f"one iteration: {name}", f"{value:.4f}"] for name, value in numbers["iteration"].items()]
    return table(["part", "seconds"], rows)


def _text(numbers: dict[str, Any]) -> str:
    apparition, all_nights = numbers["scans"]["one apparition"], numbers["scans"]["all nights"]
    magnitudes = numbers["magnitudes"]
    return f"""# The rotation and the shape of Hertha

{numbers["program"]}{", a draft with a part of the magnitudes" if numbers["draft"] else ""}. {magnitudes["nights"]} \
magnitudes of nights and {magnitudes["surveys"]} of surveys. The period comes from a scan, and pole and shape from \
fits that start from a sphere at the minima of the scan; no published number is used. Standard errors of \
{ERRORS["nights"]} mag (nights) and {ERRORS["surveys"]} mag (surveys) are assumed, and the errors below are those of \
the fit times the root of chi2 over the degrees of freedom. Angles are in degrees, poles in the ecliptic.

## Scans

{scan_title("One apparition", apparition)}

{minima_table(apparition)}

{scan_title("All nights", all_nights)}

{minima_table(all_nights)}

## Fits

{fits_table(numbers["fits"])}

{shape_text(numbers["shape"])}

{pictures(numbers["figures"])}

## Size

{SIZE_TEXT}

{sizes_table(numbers)}

## Verdicts

A number *holds* if it is within two joint standard errors, and a pole if it is within {POLE_ERROR:g} degrees, the \
usual error of inversions.

{verdicts_table(numbers["verdicts"], "source")}

## Time

{seconds_table(numbers)}
"""
