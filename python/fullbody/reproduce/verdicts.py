"""Every number and claim of the paper beside what comes out here, with a verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Literal

import numpy as np

from .. import paper

if TYPE_CHECKING:
    from .results import Results

__all__ = ["Verdict", "as_printed", "judge"]

Word = Literal["equal", "holds", "differs"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """One row of the table.

    Attributes
    ----------
    key, where, quantity, printed : str
        As in :data:`fullbody.paper.STATEMENTS`.
    ours : str
    verdict : {"equal", "holds", "differs"}
        Equal to the digits printed; a bound or a claim that holds; neither.
    why : str
        Where it differs, why, or what is known.
    """

    key: str
    where: str
    quantity: str
    printed: str
    ours: str
    verdict: Word
    why: str


def as_printed(value: float, printed: str) -> str:
    """A value rounded to the decimals of a printed number."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return f"{value:.{max(0, -exponent)}f}"


def judge(results: Results) -> list[Verdict]:
    """All verdicts, in the paper's order; one for each of its statements."""
    found: dict[str, tuple[str, Word, str]] = {}
    _cases(results, found)
    _year(results, found)
    _spin(results, found)
    _errors(results, found)
    return [Verdict(key, said.where, said.quantity, said.text, *found[key]) for key, said in paper.STATEMENTS.items()]


_SYMMETRY = (
    "A half turn about z swaps the bodies, so that z = 0 exactly. The printed motion is round-off; in case 1 an "
    "instability of the symmetric motion makes it grow."
)


def _cases(results: Results, found: dict[str, tuple[str, Word, str]]) -> None:
    one, two = results.cases[1], results.cases[2]

    def claim(key: str, ours: str, holds: bool, why: str = "") -> None:
        found[key] = (ours, "holds" if holds else "differs", "" if holds else why)

    for key, case in (("case1", one), ("case2", two)):
        ratio = case.z_max / case.xy_max
        found[f"{key}.z"] = (f"{-math.log10(ratio):.1f} orders: {case.z_max:.0e}", "differs", _SYMMETRY)
        claim(f"{key}.energy_error", f"{case.energy_step:.1e}", case.energy_step < paper.CASE_ERRORS)
        claim(f"{key}.momentum_error", f"{case.momentum_step:.1e}", case.momentum_step < paper.CASE_ERRORS)
        _cpu(found, f"{key}.cpu", paper.CPU_TIME[key], case.cpu_seconds)
    late = {name: float(motion.z[-4:].max()) for name, motion in results.z_motion.items()}
    found["case1.z_late"] = (
        f"{late['compensated']:.0e}; exactly symmetric {late['symmetric']:.0f}; from z = 1e-11 {late['seeded']:.0e}",
        "differs",
        "Round-off of any size grows to this in time; started with the motion along z that the paper has at first, the "
        "motion here reaches the same order.",
    )
    (low, high), (low2, high2) = results.late_separation
    change = max(abs(low2 - low), abs(high2 - high)) / high
    claim(
        "case1.xy_late",
        f"separation [{low:.2f}, {high:.2f}], late [{low2:.2f}, {high2:.2f}]",
        change < 0.05,
        "The tumbling exchanges energy with the orbit.",
    )
    claim("case1.force", f"at most {one.xy_force:.1e}; F_z {one.z_force:.0e}", 0.03 < one.xy_force < 0.3)
    claim("case1.tumbling", f"{one.turns[0]:.1f} and {one.turns[2]:.1f}", min(one.turns[0], one.turns[2]) > 2)
    claim("case1.spin_z", f"changes by {one.spin_z_change:.0e}", one.spin_z_change < 1e-14)
    claim(
        "case1.rotational",
        f"{one.rotational_from:.0f}: above 5 % of the total",
        60 < one.rotational_from < 90,
    )
    share = two.tilt / (math.pi / 32)
    claim("case2.angles", f"within {share:.3f} pi/32", abs(share - 1) < 0.01)
    claim("case2.psi", f"straight to {two.psi_bend:.0e} rad in 400", two.psi_bend < 0.01)
    claim("case2.spin_z", f"changes by {two.spin_z_change:.0e}", two.spin_z_change < 1e-14)
    orders = math.log10(2.0 / two.transverse)
    claim("case2.transverse", f"{orders:.1f} orders: {two.transverse:.2e}", 2.5 < orders < 3.5)
    close = two.transverse_close
    claim("case2.peaks", f"{close:.0%} of the largest tenth near an approach", close > 0.9)
    found["case2.four_times"] = (
        f"{results.four_times:.2f} times",
        "differs",
        "The torque on a tilted spheroid goes as sin(2 theta), which grows 3.6 times.",
    )
    low, high = two.rotational_range
    claim(
        "case2.rotational",
        f"[{low:.6f}, {high:.6f}] against at most {two.translational_max:.3f}",
        low > two.translational_max and (high - low) / low < 1e-3,
    )


def _cpu(found: dict[str, tuple[str, Word, str]], key: str, printed: float, ours: float) -> None:
    found[key] = (f"{ours:.2g} s: {printed / ours:.0f} times less", "differs", "Other machine, other code.")


_PERIOD = (
    "Kepler's third law for the same mean semi-major axis gives the printed digits, for both shapes, with "
    "G = 6.674e-11 in place of the run's 6.67408e-11. An inference."
)


def _year(results: Results, found: dict[str, tuple[str, Word, str]]) -> None:
    for shape, numbers in results.year.items():
        printed = paper.KW4[shape]
        for name in ("e_max", "a_min", "a_max", "a_mean", "period"):
            text = f"{getattr(printed, name):.4f}"
            ours = as_printed(getattr(numbers, name), text)
            why = _PERIOD if name == "period" else ""
            found[f"kw4.{shape}.{name}"] = (ours, "equal", "") if ours == text else (ours, "differs", why)
        found[f"kw4.{shape}.inclination_period"] = (
            f"{numbers.inclination_period:.0f}",
            "differs",
            f"Six ways to compute it agree. No inclination of the orbit gives the printed periods of both shapes. "
            f"{numbers.inclination_return:.0f} h after the start the inclination to the xy-plane is largest again, and "
            "it starts near its largest: that may be what was read off. An inference.",
        )
        _cpu(found, f"kw4.{shape}.cpu", paper.CPU_TIME[shape], numbers.cpu_seconds)
    means = {shape: numbers.e_mean for shape, numbers in results.year.items()}
    found["kw4.mean_e"] = (
        f"{means['ellipsoid']:.5f} and {means['spheroid']:.5f}",
        "holds" if means["spheroid"] > means["ellipsoid"] else "differs",
        "",
    )


def _spin(results: Results, found: dict[str, tuple[str, Word, str]]) -> None:
    best = results.search
    phi, theta, psi = best.angles
    why = (
        f"Not from the stated start, by six ways. All printed ranges come out, to {best.misfit:.3f}, when "
        f"Beta starts at phi, theta, psi = {phi:.1f}, {theta:.1f}, {psi:.1f} degrees in place of zero: turned about "
        "the orbit's normal by one hour of its motion. That start does not give the printed semi-major axes."
    )
    year = results.year["ellipsoid"]
    for axis, (low, high) in paper.KW4_SPIN.items():
        ours = getattr(year, f"spin_{axis}")
        equal = all(as_printed(o, f"{p:.2f}") == f"{p:.2f}" for o, p in zip(ours, (low, high), strict=True))
        found[f"kw4.spin_{axis}"] = (
            f"[{ours[0]:.2f}, {ours[1]:.2f}]",
            "equal" if equal else "differs",
            "" if equal else why,
        )
    round_ = results.year["spheroid"]
    width = round_.spin_z[1] - round_.spin_z[0]
    found["kw4.spheroid.spin_z"] = (f"changes by {width * 1e-5:.0e} rad/s", "holds" if width < 1e-10 else "differs", "")
    same = all(
        abs(a - b) < 0.1 * (max(getattr(year, f"spin_{axis}")) - min(getattr(year, f"spin_{axis}")))
        for axis in "xy"
        for a, b in zip(getattr(year, f"spin_{axis}"), getattr(round_, f"spin_{axis}"), strict=True)
    )
    x, y = round_.spin_x, round_.spin_y
    found["kw4.spheroid.spin_xy"] = (
        f"x [{x[0]:.2f}, {x[1]:.2f}], y [{y[0]:.2f}, {y[1]:.2f}]",
        "holds" if same else "differs",
        ""
        if same
        else "A spheroid's spin turns with one amplitude in x and y; that in x is larger than the ellipsoid's.",
    )
    e = max(numbers.e_max for numbers in results.year.values())
    found["kw4.excited_e"] = (f"{e:.4f}", "holds" if e < paper.EXCITED_E else "differs", "")
    widths = {motion.name: float(np.ptp(motion.spin[2])) for motion in results.physical}
    ours = year.spin_z[1] - year.spin_z[0]
    found["kw4.between_states"] = (
        f"width {ours:.2f}; our relaxed state {widths['relaxed']:.2f}, excited {widths['excited']:.2f}",
        "holds" if widths["relaxed"] < ours < widths["excited"] else "differs",
        "",
    )


def _errors(results: Results, found: dict[str, tuple[str, Word, str]]) -> None:
    def bound(key: str, error: float, limit: float) -> None:
        found[key] = (f"{error:.1e}", "holds" if error < limit else "differs", "")

    limit = paper.KW4_ERRORS
    for shape, numbers in results.year.items():
        bound(f"kw4.{shape}.energy_error", numbers.energy_step, limit["energy"])
    year = results.year["ellipsoid"]
    bound("kw4.momentum_error", year.angular_momentum_step, limit["angular_momentum"])
    found["kw4.momentum_drift"] = (
        f"{year.angular_momentum_drift:.0e} from the start after a year",
        "holds" if year.angular_momentum_drift > 3e-15 else "differs",
        "",
    )
    steps = [n.energy_step for n in results.year.values()] + [c.energy_step for c in results.cases.values()]
    steps += [n.angular_momentum_step for n in results.year.values()] + [
        c.momentum_step for c in results.cases.values()
    ]
    bound("all.errors", max(steps), paper.CASE_ERRORS)
