"""Every number and claim of the paper compared with the results here, with a verdict."""

from __future__ import annotations

import math

import numpy as np
from fullbody import systems

from . import cases, paper
from .findings import sine_growth
from .judging import Judge, Verdict
from .physical import EQUATOR_IN_ORBIT, ORBIT_IN_EQUATOR, PAPER
from .results import Results
from .starts import RATE

__all__ = ["judge"]


def judge(results: Results) -> list[Verdict]:
    """Return all verdicts, in the paper's order."""
    j = Judge()
    for part in (_cases, _case1, _case2, _year, _shapes, _spin, _states, _errors):
        part(j, results)
    return j.verdicts()


def _times(values: tuple[float, ...], shares: tuple[float, ...]) -> str:
    result = ", ".join("never" if value != value else f"{value:.0f}" for value in values)
    return f"{result}: above {', '.join(f'{100 * share:.0f}' for share in shares)} %"


def _cases(j: Judge, r: Results) -> None:
    """Judge the statements on both cases."""
    for number, case in r.cases.items():
        key = f"case{number}"
        orders = -math.log10(case.z_max / case.xy_max) if case.z_max else math.inf
        computed = f"{orders:.1f} orders: {case.z_max:.0e}"
        j.within(f"{key}.z", computed, orders, 10.5, 11.5, "orders", why="It is zero by symmetry.", finding="z")
        j.within(f"{key}.spin_z", f"changes by {case.spin_z_change:.0e}", case.spin_z_change, high=1e-14)
        j.bound(f"{key}.energy_error", case.energy_step, paper.CASE_ERRORS)
        j.bound(f"{key}.momentum_error", case.momentum_step, paper.CASE_ERRORS)
        j.cpu(f"{key}.cpu", paper.CPU_TIME[key], case.cpu_seconds)


def _case1(j: Judge, r: Results) -> None:
    """Judge the statements on case 1."""
    case = r.cases[1]
    j.within("case1.force", f"at most {case.xy_force:.1e}", case.xy_force, 0.03, 0.3)
    j.within("case1.force_z", f"{case.z_force:.0e}", case.z_force, 1e-14, why="It is zero by symmetry.", finding="z")
    phi, _, psi = case.revolutions
    note = "Revolutions of phi and psi. The bodies do not rotate about their own axes of symmetry."
    j.within("case1.tumbling", f"{phi:.1f} and {psi:.1f}", min(phi, psi), 2.0, unit="revolutions each", note=note)
    computed = f"t = {_times(case.noticeable, cases.NOTICEABLE)} of the total energy"
    j.leave_open(
        "case1.rotational",
        computed,
        "The paper does not state the size from which it is noticeable; these three are examples.",
    )
    computed = f"t = {_times(case.increased, cases.INCREASED)} of the largest spin about x or y"
    j.leave_open(
        "case1.rise",
        computed,
        "The paper does not state the size from which they count as increased; these three are examples.",
    )
    if r.long_end < paper.CASES_LONG_END:
        for key in ("case1.z_long", "case1.xy_long"):
            j.leave_open(key, "not run in a draft", "")
        return
    final = {name: float(motion.z[-4:].max()) for name, motion in r.z_motion.items()}
    computed = f"{final['compensated']:.0e}; from a start with z = 1e-11, {final['seeded']:.0e}"
    j.within("case1.z_long", computed, final["compensated"], 0.03, 0.3, why="It is zero by symmetry.", finding="z")
    (low, high), (low2, high2) = r.separation
    computed = f"separation [{low:.2f}, {high:.2f}], in the last 200 [{low2:.2f}, {high2:.2f}]"
    change = 100 * max(abs(low2 - low) / low, abs(high2 - high) / high)
    j.within("case1.xy_long", computed, change, high=10.0, unit="% change of its ends")


def _case2(j: Judge, r: Results) -> None:
    """Judge the statements on case 2."""
    second = r.cases[2]
    share = second.tilt / (math.pi / 32)
    j.within("case2.angles", f"largest {share:.3f} pi/32", share, 0.99, 1.01, "pi/32")
    computed = f"a straight line to within {second.psi_deviation:.0e} rad, over 400 rad"
    j.within("case2.psi", computed, second.psi_deviation, high=0.01, unit="rad from a straight line")
    orders = math.log10(2.0 / second.transverse)
    j.within("case2.transverse", f"{orders:.1f} orders: {second.transverse:.2e}", orders, 2.5, 3.5, "orders")
    computed = f"{100 * second.transverse_close:.0f} % of the largest tenth of the values are near an approach"
    interpretation = "above 90 %; near is within a quarter of the time between two approaches"
    j.claim("case2.peaks", computed, second.transverse_close > 0.9, interpretation)
    distance = 100 * r.deviation_from_coplanar
    j.within(
        "case2.coplanar",
        f"{distance:.1f} % apart at most",
        distance,
        high=10.0,
        unit="% of the distance from the centre",
    )
    growth = r.growth["pi/8"]
    why = f"The torque is proportional to sin(2 theta), which grows {sine_growth(math.pi / 8):.2f} times."
    j.within("case2.four_times", f"{growth:.2f} times", growth, 1.7, 2.3, "times", why=why, finding="tilt")
    low, high = second.rotational_range
    computed = f"[{low:.6f}, {high:.6f}] against at most {second.translational_max:.3f}"
    holds = low > second.translational_max and (high - low) / low < 1e-3
    j.claim("case2.rotational", computed, holds, "constant to 0.1 %")


def _year(j: Judge, r: Results) -> None:
    """Judge the numbers of section 4."""
    for shape, numbers in r.year["surface"].items():
        for name in ("e_max", "a_min", "a_max", "a_mean"):
            j.numbers(f"kw4.{shape}.{name}", "{}", [getattr(numbers, name)])
        other = r.year["other_g"][shape].period
        why = f"With G = 6.674e-11 instead of 6.67408e-11 it is {other:.4f}."
        j.numbers(f"kw4.{shape}.period", "{}", [numbers.period], why=why, finding="period")
        computed, stated = numbers.inclination_period, paper.YEAR[shape].inclination_period
        limits = (stated - 50.0, stated + 50.0)
        j.within(f"kw4.{shape}.inclination_period", f"{computed:.0f}", computed, *limits, finding="inclination")
        j.cpu(f"kw4.{shape}.cpu", paper.CPU_TIME[shape], numbers.cpu_seconds)


def _shapes(j: Judge, r: Results) -> None:
    """Judge the statements on the shape."""
    first, second = (r.year["surface"][shape] for shape in ("ellipsoid", "spheroid"))
    change = 100 * max(abs(getattr(second, name) / getattr(first, name) - 1) for name in ("a_min", "a_max", "a_mean"))
    j.within("kw4.shape_a", f"{change:.2f} % at most", change, high=1.0, unit="%")
    most, mean = 100 * (second.e_max / first.e_max - 1), 100 * (second.e_mean / first.e_mean - 1)
    largest = [stated.e_max for stated in paper.YEAR.values()]
    why = (
        "The paper does not state what is negligible. With the limit for the semi-major axis it would not hold; but "
        f"the printed largest eccentricities differ by {100 * (largest[1] / largest[0] - 1):.0f} % too."
    )
    j.leave_open("kw4.shape_e", f"{mean:.0f} % of its mean, {most:.0f} % of its largest", why)
    spin = 100 * float(np.ptp(first.spin_z)) / first.spin_z[0]
    computed = f"range {spin:.0f} % of its least for ellipsoids, none for spheroids"
    j.claim("kw4.shape_spin", computed, spin > max(most, change), "a larger share than the changes of e and a")
    j.claim("kw4.mean_e", f"{first.e_mean:.5f} and {second.e_mean:.5f}", second.e_mean > first.e_mean)
    j.claim("kw4.a_order", f"{first.a_mean:.4f} and {second.a_mean:.4f} km", second.a_mean > first.a_mean)
    power = math.log(second.period / first.period) / math.log(second.a_mean / first.a_mean)
    why = "By Kepler's third law the power is 3/2. A larger orbit does have a longer period."
    j.within("kw4.period_power", f"as its power {power:.2f}", power, 0.9, 1.1, why=why)
    periods = f"{first.period:.4f} and {second.period:.4f} h"
    j.claim("kw4.period_order", periods, second.period > first.period)
    why = "Section 4 and its numbers state the opposite: this is a slip in the summary."
    j.claim("kw4.period_order_5", periods, first.period > second.period, why=why)
    computed = f"{first.inclination_period:.0f} and {second.inclination_period:.0f} h"
    j.claim("kw4.inclination_order", computed, first.inclination_period > second.inclination_period)


def _spin(j: Judge, r: Results) -> None:
    """Judge the statements on Beta's spin."""
    ellipsoid, spheroid = (r.year["surface"][shape] for shape in ("ellipsoid", "spheroid"))
    for axis in "xyz":
        j.numbers(f"kw4.spin_{axis}", "[{}, {}]", getattr(ellipsoid, f"spin_{axis}"), finding="spin")
    width = float(np.ptp(spheroid.spin_z)) * 1e-5
    j.within("kw4.spheroid.spin_z", f"changes by {width:.0e}", width, high=1e-15, unit="rad/s")
    x, y = spheroid.spin_x, spheroid.spin_y
    ratio = max(map(abs, x)) / max(map(abs, ellipsoid.spin_x))
    why = f"A spheroid's spin has the same amplitude in x and y; in x it is {ratio:.1f} times the ellipsoid's."
    text = f"x [{x[0]:.2f}, {x[1]:.2f}], y [{y[0]:.2f}, {y[1]:.2f}]"
    j.within("kw4.spheroid.spin_xy", text, ratio, 0.9, 1.1, "times the amplitude in x", why=why)
    system, _ = systems.kw4_ho2021()
    rotation, revolution = 2 * math.pi / RATE, 2 * math.pi * math.sqrt(2.548**3 / system.mu())
    difference = 100 * abs(rotation / revolution - 1)
    computed = f"{rotation:.2f} and {revolution:.2f} h at the start"
    j.within("kw4.equal_periods", computed, difference, high=0.5, unit="% apart")
    why = "The rates are equal, but the orbit is retrograde with respect to the spin."
    locked = not math.isnan(r.physical[PAPER].libration)
    j.claim("kw4.synchronous", "Beta librates" if locked else "Beta circulates with respect to Alpha", locked, why=why)


def _states(j: Judge, r: Results) -> None:
    """Judge the comparisons of section 4 with Fahnestock & Scheeres (2008)."""
    e = max(numbers.e_max for numbers in r.year["surface"].values())
    j.claim("kw4.excited_e", f"{e:.4f}", e < paper.EXCITED_E)
    spins = {name: r.physical[name].spin for name in (PAPER, "relaxed", "excited")}
    computed = "width {:.2f}; our relaxed state {:.2f}, excited {:.2f}".format(*(np.ptp(s[2]) for s in spins.values()))
    why = "The paper gives no numbers of that study; the width of an excited state depends on its excitation."
    j.leave_open("kw4.between_states", computed, why)
    computed = "about {:.1f}; our relaxed state {:.1f}, excited {:.1f}".format(*(np.mean(s[2]) for s in spins.values()))
    j.leave_open(
        "kw4.similar_spin", computed, "The paper gives no numbers of that study, and section 4 refers to ranges."
    )
    largest, flat, rotated = (
        float(np.abs(r.physical[name].spin[:2]).max()) for name in (PAPER, ORBIT_IN_EQUATOR, EQUATOR_IN_ORBIT)
    )
    computed = (
        f"{largest:.2f}; Beta rotated into the orbit's plane {rotated:.2f}; i = 180 degrees {flat:.2f} [1e-5 rad/s]"
    )
    j.claim(
        "kw4.transverse",
        computed,
        max(flat, rotated) < 0.1 * largest,
        "less than a tenth without the tilt",
        finding="physical",
    )


def _errors(j: Judge, r: Results) -> None:
    """Judge the errors of the year and of all runs."""
    years = r.year["surface"]
    for shape, numbers in years.items():
        j.bound(f"kw4.{shape}.energy_error", numbers.energy_step, paper.ERRORS["energy"])
    ellipsoid, second = (years[shape].angular_momentum_step for shape in ("ellipsoid", "spheroid"))
    j.bound("kw4.momentum_error", ellipsoid, paper.ERRORS["angular_momentum"])
    j.within("kw4.momentum_error_spheroid", f"{second:.1e} and {ellipsoid:.1e}", second / ellipsoid, 0.1, 10.0, "times")
    first, last = r.momentum["positions"]
    computed = f"{first:.0e} in the first quarter, {last:.0e} in the last"
    j.claim(
        "kw4.momentum_drift",
        computed,
        last > 2 * first,
        "more than twice as large, formed from positions relative to the origin",
        finding="momentum",
    )
    steps = [n.energy_step for n in years.values()] + [c.energy_step for c in r.cases.values()]
    steps += [ellipsoid, second, *(c.momentum_step for c in r.cases.values())]
    note = "Section 4 says 1e-11 for the angular momentum of 1999 KW4."
    j.bound("all.errors", max(steps), paper.CASE_ERRORS, note=note)
    year = years["ellipsoid"]
    computed = f"energy of the year, step to step {year.energy_step:.0e}"
    note = f"From the start it drifts by {year.energy_drift_orbital:.0e} of the orbital energy."
    j.within(
        "all.machine",
        computed,
        year.energy_step,
        high=2e-15,
        unit="(doubles round at 2e-16)",
        note=note,
        finding="errors",
    )
    run, most = max(r.theta.items(), key=lambda item: item[1])
    j.within("all.pole", f"largest abs(theta) {most:.1f} degrees, in {run}", most, high=89.0, unit="degrees")
