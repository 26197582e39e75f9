"""The map of Dimorphos' largest roll, pitch and yaw, and the report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import fullbody
import numpy as np
from fullbody import Component, Run, State, System, Verner98, binary, ensembles

from ..publishing import publish, table
from . import figures, paper, theory

if TYPE_CHECKING:
    import xarray

__all__ = ["counts", "setup", "sweep", "write"]

#: km^3 / (kg h^2); km, hours.
G, DISTANCE, PERIOD = 6.6743e-11 * 1e-9 * 3600.0**2, 1.19, 11.9217
MASS = 4 * np.pi**2 * DISTANCE**3 / (G * PERIOD**2)
#: Momentum of the spacecraft, kg km/h; its angle out of the orbit's plane.
MOMENTUM, ELEVATION = 535.0 * 6.6 * 3600.0, np.deg2rad(10.0)
#: The angle from which on the attitude counts as unstable.
UNSTABLE = np.deg2rad(60.0)
RATIOS = np.round(np.arange(1.02, 1.51, 0.02), 2)
GRID = {"beta": [1.0, 3.0], "a_b": RATIOS, "b_c": RATIOS}
DRAFT = {"beta": [1.0, 3.0], "a_b": [1.1, 1.42], "b_c": [1.1, 1.3]}


def setup(beta: float, a_b: float, b_c: float) -> tuple[System, State]:
    """Didymos and a synchronous Dimorphos, in km, hours and kg, just after the impact."""
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
    along = [0.0, -change * np.cos(ELEVATION), change * np.sin(ELEVATION)]
    return system, state.kick("Dimorphos", along, along="orbit")


def measure(run: Run) -> dict[str, Any]:
    """The largest roll, pitch and yaw; when one of them passed the limit; and the drifts."""
    return ensembles.attitude(run, UNSTABLE) | ensembles.drift(run)


def sweep(folder: Path | None, draft: bool = False, progress: bool = False, **options: Any) -> xarray.Dataset:
    """The map, kept in the folder while it grows."""
    return fullbody.sweep(
        setup,
        DRAFT if draft else GRID,
        (10.0 if draft else 365.0) * 24.0,
        measure=measure,
        output=0.5,
        integrator=Verner98(1e-10, 1e-10),
        store=None if folder is None else folder / "map.nc",
        progress=progress,
        **options,
    )


def counts(found: xarray.Dataset) -> dict[str, Any]:
    """By beta: the share of unstable attitudes, among those near a resonance of the linear theory and far from all."""
    near = nearness(*np.meshgrid(found.a_b, found.b_c, indexing="ij")) < NEAR
    told = {}
    for beta in found.beta.values:
        part = found.sel(beta=beta)
        unstable = part.tumbles.values == 1.0
        days = part.tumbling_time.values[unstable] / 24.0
        told[f"{beta:g}"] = {
            "runs": part["roll"].size,
            "errors": int((part.error != "").sum()),
            "unstable": float(unstable.mean()),
            "near": float(near.mean()),
            "unstable_near": float(unstable[near].mean()) if near.any() else np.nan,
            "unstable_far": float(unstable[~near].mean()) if not near.all() else np.nan,
            "unstable_day_median": float(np.median(days)) if len(days) else np.nan,
            # Half a turn stands for all beyond it: a rotation about the long axis.
            "rolls_over": float((part["roll"] == np.pi).mean()),
            "yaw_beyond_90": float((part.yaw > np.pi / 2).mean()),
            "largest_drift": float(part.energy_drift_orbital.max()),
        }
    return told


#: Of frequencies from a resonance, in mean motions.
NEAR = 0.03


def nearness(a_b: Any, b_c: Any) -> Any:
    """How far the nearest of the resonances is, in mean motions."""
    three = theory.frequencies(a_b, b_c)
    return np.min([np.abs(vanishing(*three)) for vanishing in theory.RESONANCES.values()], axis=0)


def write(folder: Path, draft: bool, progress: bool) -> Path:
    """Run everything and write the report."""
    found = sweep(folder, draft, progress)
    numbers = {
        "program": f"fullbody {fullbody.__version__}",
        "paper": "Agrusa et al. (2021), Icarus 370, 114624, doi:10.1016/j.icarus.2021.114624",
        "draft": draft,
        "stated": paper.STATED,
        "assumed": paper.ASSUMED,
        "counts": counts(found),
    }
    return publish(folder, _text(numbers), figures.all_figures(found), numbers)


def _text(numbers: dict[str, Any]) -> str:
    names = ("unstable", "near", "unstable_near", "unstable_far", "rolls_over", "yaw_beyond_90")
    rows = [
        [beta, str(one["runs"]), *(_percent(one[name]) for name in names), _days(one["unstable_day_median"])]
        for beta, one in numbers["counts"].items()
    ]
    head = ["beta", "runs", "unstable", "near a resonance", "unstable of these", "unstable elsewhere", "rolls over"]
    listed = {
        name: "\n".join(f"- **{key}**: {value}." for key, value in numbers[name].items())
        for name in ("stated", "assumed")
    }
    drift = max(one["largest_drift"] for one in numbers["counts"].values())
    return f"""# The attitude of Dimorphos: {numbers["paper"]}

{numbers["program"]}{", a draft: a small grid and short runs" if numbers["draft"] else ""}. Only the abstract could be \
read. What it states stands below, with what is assumed.

![Largest roll, pitch and yaw](map.png)

{table([*head, "yaw beyond 90 deg", "unstable from day, median"], rows)}

Unstable is a roll, pitch or yaw beyond {np.rad2deg(UNSTABLE):g} degrees; near a resonance is where one of the \
combinations below is within {NEAR:g} mean motions of zero. The energy of the orbit drifts by at most {drift:.1g}.

The lines are resonances of the linear theory, on a circular orbit about a point:

{chr(10).join(f"- {name}" for name in theory.RESONANCES)}

with the mean motion as the unit and, for moments A < B < C,

    libration^2 = 3 (B - A)/C,
    A B x^2 - [4 A (C - A) + B (C - B) + (A + B - C)^2] x + 4 (C - A) (C - B) = 0,

x the squares of precession (the larger one) and nutation.

## Stated

{listed["stated"]}

## Assumed

{listed["assumed"]}
"""


def _percent(share: float) -> str:
    return "-" if np.isnan(share) else f"{100 * share:.1f} %"


def _days(time: float) -> str:
    return "-" if np.isnan(time) else f"{time:.0f}"
