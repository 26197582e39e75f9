"""What the report says in words, as numbers: derived from the results, for the verdicts and for the page."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from fullbody import systems
from fullbody.commands.kw4 import printed
from fullbody.commands.kw4 import year as kw4

if TYPE_CHECKING:
    from .results import Results

__all__ = ["Facts", "Nodal", "facts"]

#: Six ways count as agreeing when their spins differ by less than this, 1e-5 rad/s, and their periods by an hour.
_ALIKE = 1e-6
#: G with which Kepler's third law makes the printed mean periods, over the run's.
_ROUNDED_G = 6.674 / 6.67408


@dataclass(frozen=True, slots=True)
class Nodal:
    """How one shape's nodal period depends on the orbit's inclination.

    Attributes
    ----------
    stated : float
        At the stated inclination, hours.
    least : float
        The least of the retrograde orbits scanned, hours.
    prograde : float
        The prograde inclination that has the printed period, degrees; NaN where none of those scanned has.
    uneven : float
        Largest difference of the two fits to one run, relative.
    """

    stated: float
    least: float
    prograde: float
    uneven: float


@dataclass(frozen=True, slots=True)
class Facts:
    """Derived numbers.

    Attributes
    ----------
    ways, ways_agree : int, bool
        How many ways to compute the quantities in question, and whether they agree.
    ways_ran : bool
        Whether they ran for the whole year.
    z_orders : float
        Orders of magnitude by which case 1's motion along z grows from t = 100 to the end.
    seeded_at : float
        When the seeded motion along z passes 0.03; NaN where it does not.
    reached : float
        The end of those runs.
    mean_motion : float
        Of the stated orbit, degrees an hour.
    rotation, revolution : float
        Beta's period of rotation and of its orbit at the start, hours.
    theta : dict
        Largest |theta| by run, degrees: where the paper's angles are nearest to their pole.
    equator : float
        Between Beta's equator and the orbit in the paper's start, degrees.
    momentum_growth : tuple
        Ellipsoids' angular momentum against the start, of its length, medians of the first and the last quarter of the
        year: from the bodies' places, and with the barycentre's part kept apart.
    travelled : float
        How far the barycentre goes in the year, km.
    period_power : float
        Power of the mean semi-major axis with which the mean period goes, between the two shapes.
    sine : float
        Growth of sin 2 theta from pi/32 to pi/8.
    rounded_g : dict
        Mean period by shape with G = 6.674e-11, hours.
    energy_ratio : float
        Total over orbital energy of 1999 KW4.
    retrograde : float
        Between Alpha's pole and the orbit's normal in the paper's start, degrees.
    nodal : dict
        By shape.
    scanned : str
        Inclinations scanned.
    """

    ways: int
    ways_agree: bool
    ways_ran: bool
    z_orders: float
    seeded_at: float
    reached: float
    mean_motion: float
    rotation: float
    revolution: float
    theta: dict[str, float]
    equator: float
    momentum_growth: tuple[tuple[float, float], tuple[float, float]]
    travelled: float
    period_power: float
    sine: float
    rounded_g: dict[str, float]
    energy_ratio: float
    retrograde: float
    nodal: dict[str, Nodal]
    scanned: str


def facts(results: Results) -> Facts:
    """Derive them."""
    ranges = np.array([way.ranges for way in results.agreement])
    periods = np.array([way.inclination_period for way in results.agreement])
    ran = bool(np.isfinite(periods).all())
    alike = bool(np.ptp(ranges, axis=0).max() < _ALIKE) and (not ran or bool(np.ptp(periods) < 1.0))
    grown, seeded = results.z_motion["compensated"], results.z_motion["seeded"]
    passed = seeded.z > 0.03
    system, state = systems.kw4_ho2021()
    motion = math.sqrt(system.mu() / systems.ho2021.KW4_ORBIT["a"] ** 3)
    energy = system.energy(state)
    slopes = results.nodal["ellipsoid"][0]
    one, two = (results.year[shape] for shape in ("ellipsoid", "spheroid"))
    sides = [side for side in (slopes[slopes < 90], slopes[slopes > 90]) if len(side)]
    return Facts(
        ways=len(results.agreement),
        ways_agree=alike,
        ways_ran=ran,
        z_orders=float(np.log10(grown.z[-4:].max() / grown.z[(grown.time > 75) & (grown.time < 125)].max())),
        seeded_at=float(seeded.time[np.argmax(passed)]) if passed.any() else float("nan"),
        reached=float(grown.time[-1] + 12.5),
        mean_motion=math.degrees(motion),
        rotation=2 * math.pi / systems.ho2021.KW4_SPINS[1],
        revolution=2 * math.pi / motion,
        theta=_theta(results),
        equator=180.0 - _tilt(state, 1),
        momentum_growth=_momentum_growth(results.year_runs["ellipsoid"]),
        travelled=float(np.linalg.norm(system.momentum(state)) / np.sum(system.masses) * printed.YEAR_HOURS),
        period_power=math.log(two.period / one.period) / math.log(two.a_mean / one.a_mean),
        sine=math.sin(math.pi / 4) / math.sin(math.pi / 16),
        rounded_g={shape: numbers.period / math.sqrt(_ROUNDED_G) for shape, numbers in results.year.items()},
        energy_ratio=float(abs(energy.total / (energy.total - energy.rotational))),
        retrograde=_tilt(state, 0),
        nodal={shape: _nodal(results.nodal[shape], printed.YEAR[shape].inclination_period) for shape in results.nodal},
        scanned=" and ".join(
            f"{side.min():.0f} to {side.max():.0f}" if len(side) > 1 else f"{side[0]:.0f}" for side in sides
        ),
    )


def _theta(results: Results) -> dict[str, float]:
    """Largest |theta| by run, degrees."""
    found = {f"case {number}": math.degrees(case.theta) for number, case in results.cases.items()}
    for shape, run in results.year_runs.items():
        w, x, y, z = np.moveaxis(run.attitude, -1, 0)
        found[f"1999 KW4, {shape}s"] = float(np.rad2deg(np.arcsin(np.clip(2 * np.abs(w * y - x * z), 0, 1)).max()))
    return found


def _momentum_growth(run: Any) -> tuple[tuple[float, float], tuple[float, float]]:
    def quarters(drift: Any) -> tuple[float, float]:
        parts = np.array_split(drift, 4)
        return float(np.median(parts[0])), float(np.median(parts[-1]))

    return quarters(kw4.drift(kw4.momentum_of_places(run))), quarters(run.angular_momentum_drift)


def _tilt(state: Any, body: int) -> float:
    """Angle between a body's pole and the orbit's normal, degrees."""
    normal = np.cross(state.position[1] - state.position[0], state.velocity[1] - state.velocity[0])
    pole = state.rotation_matrix[body] @ state.spin[body]
    cosine = normal @ pole / np.linalg.norm(normal) / np.linalg.norm(pole)
    return math.degrees(math.acos(cosine))


def _nodal(by_slope: Any, printed: float) -> Nodal:
    slopes, periods, longer = by_slope
    retrograde, prograde = slopes > 90, slopes < 90
    stated = float(periods[slopes == systems.ho2021.KW4_SKY["i"]][0])
    crossing = float("nan")
    if prograde.any() and periods[prograde].min() <= printed <= periods[prograde].max():
        # The period grows with the inclination there.
        crossing = float(np.interp(printed, periods[prograde], slopes[prograde]))
    least = float(min(periods[retrograde].min(), longer[retrograde].min()))
    return Nodal(stated, least, crossing, float(np.abs(longer / periods - 1).max()))
