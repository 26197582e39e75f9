"""The map of Dimorphos' largest roll, pitch and yaw, and the report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import fullbody
import numpy as np
from fullbody import Component, Run, State, System, Verner98, binary, observables

from ..publishing import formatted, listed, percent, publish, table
from . import figures, paper, theory

if TYPE_CHECKING:
    import xarray

__all__ = ["counts", "setup", "sweep", "write"]

#: The gravitational constant in km^3 / (kg h^2), the separation in km and the orbital period in hours.
G, DISTANCE, PERIOD = 6.6743e-11 * 1e-9 * 3600.0**2, 1.19, 11.9217
MASS = 4 * np.pi**2 * DISTANCE**3 / (G * PERIOD**2)
#: The momentum of the spacecraft in kg km/h, and its angle out of the plane of the orbit.
MOMENTUM, ELEVATION = 535.0 * 6.6 * 3600.0, np.deg2rad(10.0)
#: The roll, pitch or yaw above which the attitude counts as unstable.
UNSTABLE = np.deg2rad(60.0)
RATIOS = np.round(np.arange(1.02, 1.51, 0.02), 2)
GRID = {"beta": [1.0, 3.0], "a_b": RATIOS, "b_c": RATIOS}
DRAFT = {"beta": [1.0, 3.0], "a_b": [1.1, 1.42], "b_c": [1.1, 1.3]}


def setup(beta: float, a_b: float, b_c: float) -> tuple[System, State]:
    """Return Didymos and a synchronous Dimorphos, in km, hours and kg, just after the impact."""
    system, state = binary(
        Component(diameters=(0.838, 0.832, 0.786), rotation_period=2.26, name="Didymos"),
        Component(diameter=0.164, axis_ratios=(a_b, b_c), name="Dimorphos"),
        total_mass=MASS,
        equal_density=True,
        semi_major_axis=DISTANCE,
        elements="mean",
        G=G,
    )
    change = beta * MOMENTUM / system.masses[1]
    components = [0.0, -change * np.cos(ELEVATION), change * np.sin(ELEVATION)]
    return system, state.kick("Dimorphos", components, along="orbit")


def measure(run: Run) -> dict[str, Any]:
    """Return the largest roll, pitch and yaw, the time at which one of them passed the limit, and the drifts."""
    return observables.tumbles(run, limit=UNSTABLE).as_dict() | observables.drift(run).as_dict()


def sweep(folder: Path | None, draft: bool = False, progress: bool = False, **options: Any) -> xarray.Dataset:
    """Return the map; runs are saved in the folder as they end."""
    return fullbody.sweep(
        setup,
        DRAFT if draft else GRID,
        (10.0 if draft else 365.0) * 24.0,
        measure=measure,
        output=0.5,
        integrator=Verner98(1e-10, 1e-10),
        store=None if folder is None else folder / "map.nc",
        key="agrusa2021",
        progress=progress,
        **options,
    )


#: The distance from a resonance, in mean motions, within which a combination of frequencies counts as near it.
TOLERANCE = 0.03


def counts(dataset: xarray.Dataset) -> dict[str, Any]:
    """Count, for each beta, the unstable shapes: among all, near each resonance of the theory, and far from them."""
    frequencies = theory.frequencies(*np.meshgrid(dataset.a_b, dataset.b_c, indexing="ij"))
    resonant = {name: np.abs(combination(*frequencies)) < TOLERANCE for name, combination in theory.RESONANCES.items()}
    regions = {"all": np.full(frequencies[0].shape, True), **resonant}
    regions["none of these"] = ~np.any(list(resonant.values()), axis=0)
    result = {}
    for beta in dataset.beta.values:
        part = dataset.sel(beta=beta)
        days = part.tumbling_time.values[part.tumbles.values == 1.0] / 24.0
        result[f"{beta:g}"] = {
            "errors": int((part.error != "").sum()),
            "unstable_day_median": float(np.median(days)) if len(days) else np.nan,
            "yaw_beyond_90": float((part.largest_yaw > np.pi / 2).mean()),
            "largest_drift": float(part.energy_drift_orbital.max()),
            "near": {name: _shapes(part, region) for name, region in regions.items()},
        }
    return result


def _shapes(part: xarray.Dataset, region: Any) -> dict[str, float]:
    """Return the number of shapes in a region of the map, the shares of unstable ones, and the median roll, degrees."""
    roll, tumbles = (part[name].values[region] for name in ("largest_roll", "tumbles"))
    if not len(roll):
        return {"shapes": 0, "unstable": np.nan, "rolls_over": np.nan, "roll_median": np.nan}
    return {
        "shapes": len(roll),
        "unstable": float(np.mean(tumbles == 1.0)),
        # Half a turn stands for all beyond it: a rotation about the long axis.
        "rolls_over": float(np.mean(roll == np.pi)),
        "roll_median": float(np.rad2deg(np.nanmedian(roll))),
    }


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything and write the report."""
    result = sweep(folder, draft, progress)
    numbers = {
        "paper": "Agrusa et al. (2021), Icarus 370, 114624, doi:10.1016/j.icarus.2021.114624",
        "draft": draft,
        "stated": paper.STATED,
        "assumed": paper.ASSUMED,
        "counts": counts(result),
    }
    return publish(folder, figures.all_figures(result), numbers, _text)


def _text(numbers: dict[str, Any]) -> str:
    rows = [
        [
            beta,
            name,
            str(shapes["shapes"]),
            percent(shapes["unstable"]),
            percent(shapes["rolls_over"]),
            formatted(shapes["roll_median"], ".1f"),
        ]
        for beta, count in numbers["counts"].items()
        for name, shapes in count["near"].items()
    ]
    head = ["beta", "near", "shapes", "unstable", "rolls over", "largest roll, median, degrees"]
    days = ", ".join(
        f"{formatted(count['unstable_day_median'], '.0f')} (beta {beta})" for beta, count in numbers["counts"].items()
    )
    drift = max(count["largest_drift"] for count in numbers["counts"].values())
    return f"""# The attitude of Dimorphos: {numbers["paper"]}

{numbers["program"]}{", a draft: a small grid and short runs" if numbers["draft"] else ""}. Only the abstract was \
available. Its statements and the assumptions of this study are listed below.

![Largest roll, pitch and yaw](map.png)

{table(head, rows)}

A shape is unstable if its roll, pitch or yaw exceeds {np.rad2deg(UNSTABLE):g} degrees within the year; the median day \
of the first time is {days}. Near means within {TOLERANCE:g} mean motions. The energy of the orbit drifts by at most \
{drift:.1g}.

The lines are resonances of the linear theory, on a circular orbit about a point:

{chr(10).join(f"- {name}" for name in theory.RESONANCES)}

with the mean motion as the unit and, for moments A < B < C,

    libration^2 = 3 (B - A)/C,
    A B x^2 - [4 A (C - A) + B (C - B) + (A + B - C)^2] x + 4 (C - A) (C - B) = 0,

where the roots x are the squares of the frequencies of precession (the larger one) and nutation.

## Stated

{listed(numbers["stated"])}

## Assumed

{listed(numbers["assumed"])}
"""
