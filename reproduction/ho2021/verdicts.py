"""Every number and claim of the paper beside what comes out here, with a verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from fullbody.commands.kw4 import printed

from . import paper
from .facts import Facts, facts
from .physical import FLAT, PAPER, TURNED

if TYPE_CHECKING:
    from .results import Results

__all__ = ["WORDS", "Verdict", "as_printed", "judge"]

Word = Literal["equal", "holds", "differs", "open", "faster", "slower"]
WORDS: tuple[Word, ...] = get_args(Word)


@dataclass(frozen=True, slots=True)
class Verdict:
    """One row of the table.

    Attributes
    ----------
    key, where, quantity, printed : str
        As in :data:`paper.STATEMENTS`.
    ours : str
    verdict : {"equal", "holds", "differs", "open", "faster", "slower"}
        Equal to the digits printed; a bound or a claim that holds; neither; not decided; CPU times.
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


class _Judge:
    """Collects the verdicts."""

    def __init__(self, results: Results) -> None:
        self.results = results
        self.facts: Facts = facts(results)
        self.found: dict[str, tuple[str, Word, str]] = {}

    def claim(self, key: str, ours: str, holds: bool, why: str = "It does not hold here.", note: str = "") -> None:
        """A bound or a statement in words; ``why`` it fails, or a ``note`` where it holds."""
        self.found[key] = (ours, "holds", note) if holds else (ours, "differs", why)

    def number(self, key: str, value: float, printed: str, why: str = "Another number comes out.") -> None:
        """A number to the digits printed."""
        ours = as_printed(value, printed)
        self.found[key] = (ours, "equal", "") if ours == printed else (ours, "differs", why)

    def cpu(self, key: str, printed: float, ours: float) -> None:
        """A CPU time."""
        less = ours < printed
        ratio = float(f"{max(printed / ours, ours / printed):.1g}")
        text = f"{ours:.2g} s: about {ratio:g} times {'less' if less else 'more'}"
        self.found[key] = (text, "faster" if less else "slower", "Another machine, another program.")


def as_printed(value: float, printed: str) -> str:
    """A value rounded to the decimals of a printed number."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return f"{value:.{max(0, -exponent)}f}"


def judge(results: Results) -> list[Verdict]:
    """All verdicts, in the paper's order; one for each of its statements."""
    judging = _Judge(results)
    for part in (_cases, _late, _tops, _year, _shapes, _orders, _spin, _errors):
        part(judging)
    found = judging.found
    return [Verdict(key, said.where, said.quantity, said.text, *found[key]) for key, said in paper.STATEMENTS.items()]


_SYMMETRY = (
    "A half turn about z swaps the bodies and the barycentre rests, so that z = 0 exactly. The printed motion is "
    "numerical: from round-off, quadrature or tolerance, which cannot be told."
)


def _cases(j: _Judge) -> None:
    for number, case in j.results.cases.items():
        key = f"case{number}"
        orders = -math.log10(case.z_max / case.xy_max) if case.z_max else math.inf
        j.claim(f"{key}.z", f"{orders:.1f} orders: {case.z_max:.0e}", abs(orders - 11) < 0.5, _SYMMETRY)
        j.claim(f"{key}.energy_error", f"{case.energy_step:.1e}", case.energy_step < paper.CASE_ERRORS)
        j.claim(f"{key}.momentum_error", f"{case.momentum_step:.1e}", case.momentum_step < paper.CASE_ERRORS)
        j.cpu(f"{key}.cpu", paper.CPU_TIME[key], case.cpu_seconds)
    one = j.results.cases[1]
    j.claim("case1.force", f"at most {one.xy_force:.1e}", 0.03 < one.xy_force < 0.3)
    why = "Zero by the same symmetry, whatever the tilt."
    j.claim("case1.force_z", f"{one.z_force:.0e}: round-off", one.z_force > 1e-14, why)
    j.claim(
        "case1.tumbling",
        f"{one.turns[0]:.1f} and {one.turns[2]:.1f}",
        min(one.turns[0], one.turns[2]) > 2,
        note="Counted in phi and psi; about their own axes of symmetry the bodies do not turn at all.",
    )
    j.claim("case1.spin_z", f"changes by {one.spin_z_change:.0e}", one.spin_z_change < 1e-14)
    ours = f"{one.rotational_from:.0f}: above 5 % of the total"
    j.claim("case1.rotational", ours, 60 < one.rotational_from < 90)
    tenth, quarter, half = one.rise
    ours = f"{tenth:.0f}, {quarter:.0f}, {half:.0f}: above a tenth, a quarter, half of the largest"
    j.claim("case1.rise", ours, tenth < 75 and 60 < quarter < 90)


def _late(j: _Judge) -> None:
    if j.facts.reached < paper.CASES_LATE - 1.0:
        for key in ("case1.z_late", "case1.xy_late"):
            j.found[key] = ("not run in a draft", "open", "")
        return
    late = {name: float(motion.z[-4:].max()) for name, motion in j.results.z_motion.items()}
    ours = f"{late['compensated']:.0e}; started with z = 1e-11, {late['seeded']:.0e}"
    why = (
        f"Zero by symmetry. Whatever breaks it grows: our round-off by {j.facts.z_orders:.0f} orders, far from its end "
        f"still; 1e-11, the printed size, passes 0.03 at t = {j.facts.seeded_at:.0f} already."
    )
    j.claim("case1.z_late", ours, 0.03 < late["compensated"] < 0.3, why)
    (low, high), (low2, high2) = j.results.late_separation
    ours = f"separation [{low:.2f}, {high:.2f}], at the end [{low2:.2f}, {high2:.2f}]"
    change = max(abs(low2 - low) / low, abs(high2 - high) / high)
    j.claim("case1.xy_late", ours, change < 0.1, note=f"Changed by {change:.0%} at most.")


def _tops(j: _Judge) -> None:
    two = j.results.cases[2]
    share = two.tilt / (math.pi / 32)
    j.claim("case2.angles", f"within {share:.3f} pi/32", abs(share - 1) < 0.01)
    j.claim("case2.psi", f"straight to {two.psi_bend:.0e} rad in 400", two.psi_bend < 0.01)
    j.claim("case2.spin_z", f"changes by {two.spin_z_change:.0e}", two.spin_z_change < 1e-14)
    orders = math.log10(2.0 / two.transverse)
    j.claim("case2.transverse", f"{orders:.1f} orders: {two.transverse:.2e}", 2.5 < orders < 3.5)
    close = two.transverse_close
    j.claim("case2.peaks", f"{close:.0%} of the largest tenth near an approach", close > 0.9)
    apart = j.results.from_coplanar
    j.claim("case2.coplanar", f"within {apart:.1%} of the distance", apart < 0.1)
    growth = j.results.growth
    why = (
        f"The torque on a tilted spheroid goes as sin(2 theta), which grows {j.facts.sine:.2f} times. With pi/16, "
        f"twice the angle, it is {growth['pi/16']:.2f} times, which would be nearly double."
    )
    j.claim("case2.four_times", f"{growth['pi/8']:.2f} times", abs(growth["pi/8"] - 2) < 0.3, why)
    low, high = two.rotational_range
    ours = f"[{low:.6f}, {high:.6f}] against at most {two.translational_max:.3f}"
    j.claim("case2.rotational", ours, low > two.translational_max and (high - low) / low < 1e-3)


def _year(j: _Judge) -> None:
    for shape, numbers in j.results.year.items():
        said = printed.YEAR[shape]
        for name in ("e_max", "a_min", "a_max", "a_mean"):
            j.number(f"kw4.{shape}.{name}", getattr(numbers, name), f"{getattr(said, name):.4f}")
        why = (
            f"Kepler's third law for the same semi-major axes gives {j.facts.rounded_g[shape]:.4f} h with "
            "G = 6.674e-11 in place of the run's 6.67408e-11. An inference."
        )
        j.number(f"kw4.{shape}.period", numbers.period, f"{said.period:.4f}", why)
        ours, asked, again = numbers.inclination_period, said.inclination_period, numbers.inclination_return
        why = (
            f"{_ways(j)}No retrograde inclination of the orbit has the printed period (the least is "
            f"{j.facts.nodal[shape].least:.0f} h). The inclination to the xy-plane starts near its largest and is "
            f"largest again after {again:.0f} h, {abs(again / asked - 1):.0%} from the printed: perhaps that was "
            "read off."
        )
        j.claim(f"kw4.{shape}.inclination_period", f"{ours:.0f}", abs(ours - asked) < 50, why)
        j.cpu(f"kw4.{shape}.cpu", paper.CPU_TIME[shape], numbers.cpu_seconds)


def _ways(j: _Judge) -> str:
    if not (j.facts.ways_agree and j.facts.ways_ran):
        return ""
    return f"{j.facts.ways} ways to compute it agree. "


def _shapes(j: _Judge) -> None:
    """How much the shape does."""
    one, two = (j.results.year[shape] for shape in ("ellipsoid", "spheroid"))
    apart = max(abs(getattr(two, name) / getattr(one, name) - 1) for name in ("a_min", "a_max", "a_mean"))
    j.claim("kw4.shape_a", f"{apart:.2%} at most", apart < 0.01)
    most, mean = two.e_max / one.e_max - 1, two.e_mean / one.e_mean - 1
    largest = [said.e_max for said in printed.YEAR.values()]
    why = f"What is negligible is not said; the printed largest differ by {largest[1] / largest[0] - 1:.0%} too."
    j.found["kw4.shape_e"] = (f"{mean:.0%} of its mean, {most:.0%} of its largest", "open", why)
    widths = [high - low for low, high in (one.spin_z, two.spin_z)]
    ranges = f"ranges {widths[0]:.2f} and {widths[1]:.2f} [1e-5 rad/s]"
    j.claim("kw4.shape_spin", ranges, widths[0] / one.spin_z[0] > max(most, apart) > widths[1])


def _orders(j: _Judge) -> None:
    """Which of the two shapes has more of what."""
    one, two = (j.results.year[shape] for shape in ("ellipsoid", "spheroid"))
    why = "Kepler's third law: the power is 3/2. That a larger orbit takes longer stands."
    power = j.facts.period_power
    j.claim("kw4.period_power", f"as its power {power:.2f}", abs(power - 1) < 0.1, why)
    j.claim("kw4.mean_e", f"{one.e_mean:.5f} and {two.e_mean:.5f}", two.e_mean > one.e_mean)
    j.claim("kw4.a_order", f"{one.a_mean:.4f} and {two.a_mean:.4f} km", two.a_mean > one.a_mean)
    periods = f"{one.period:.4f} and {two.period:.4f} h"
    j.claim("kw4.period_order", periods, two.period > one.period)
    why = "Section 4 and its own numbers say the opposite: a slip in the summary."
    j.claim("kw4.period_order_5", periods, one.period > two.period, why)
    ours, said = one.inclination_period / two.inclination_period, [p.inclination_period for p in printed.YEAR.values()]
    note = f"By {ours:.3f} here, {said[0] / said[1]:.3f} in print."
    both = f"{one.inclination_period:.0f} and {two.inclination_period:.0f} h"
    j.claim("kw4.inclination_order", both, ours > 1, note=note)
    ours = j.facts.rotation / j.facts.revolution
    j.claim("kw4.equal_periods", f"{j.facts.rotation:.2f} and {j.facts.revolution:.2f} h", abs(ours - 1) < 0.005)
    why = "The rates are equal, but the orbit runs the other way, retrograde to the spin."
    locked = not math.isnan(j.results.physical[0].libration)
    j.claim("kw4.synchronous", "Beta librates" if locked else "Beta turns round under Alpha", locked, why)


def _spin(j: _Judge) -> None:
    best = j.results.search.minima[0]
    phi, theta, psi = best.angles
    extent = "All six printed numbers come out" if best.equal else f"All six come out to {best.misfit:.3f}"
    sense = "against" if best.turn < 0 else "along"
    why = (
        f"{_ways(j)}{extent} when Beta starts at phi, theta, psi = {phi:.2f}, {theta:.2f}, {psi:.2f} degrees in place "
        f"of zero: turned by {abs(best.turn):.2f} degrees {sense} the orbital motion, about an axis "
        f"{best.off_normal:.1f} degrees off the orbit's normal. The mean motion is {j.facts.mean_motion:.2f} degrees "
        f"an hour. A year from there has another mean semi-major axis, {j.results.year_from_search.a_mean:.4f} km."
    )
    year, round_ = (j.results.year[shape] for shape in ("ellipsoid", "spheroid"))
    for axis, said in printed.SPIN.items():
        ours = getattr(year, f"spin_{axis}")
        equal = all(as_printed(o, f"{p:.2f}") == f"{p:.2f}" for o, p in zip(ours, said, strict=True))
        text = f"[{ours[0]:.2f}, {ours[1]:.2f}]"
        j.found[f"kw4.spin_{axis}"] = (text, "equal", "") if equal else (text, "differs", why)
        why = "As for x."
    width = round_.spin_z[1] - round_.spin_z[0]
    j.claim("kw4.spheroid.spin_z", f"changes by {width * 1e-5:.0e} rad/s", width < 1e-10)
    x, y = round_.spin_x, round_.spin_y
    ratio = max(map(abs, x)) / max(map(abs, year.spin_x))
    why = f"A spheroid's spin has one amplitude in x and y; that in x is {ratio:.1f} times the ellipsoid's."
    text = f"x [{x[0]:.2f}, {x[1]:.2f}], y [{y[0]:.2f}, {y[1]:.2f}]"
    j.claim("kw4.spheroid.spin_xy", text, abs(ratio - 1) < 0.1, why)
    _states(j)


def _states(j: _Judge) -> None:
    """What section 4 compares with Fahnestock & Scheeres (2008)."""
    e = max(numbers.e_max for numbers in j.results.year.values())
    j.claim("kw4.excited_e", f"{e:.4f}", e < paper.EXCITED_E)
    motions = {motion.name: motion for motion in j.results.physical}
    widths = {name: float(np.ptp(motion.spin[2])) for name, motion in motions.items()}
    j.found["kw4.between_states"] = (
        f"width {widths[PAPER]:.2f}; our relaxed state {widths['relaxed']:.2f}, excited {widths['excited']:.2f}",
        "open",
        "The paper gives no numbers of theirs; the width of an excited state is as large as one excites it.",
    )
    middles = {name: float(np.mean(motions[name].spin[2])) for name in (PAPER, "relaxed", "excited")}
    ours = "about {:.1f}; our relaxed state {:.1f}, excited {:.1f}".format(*middles.values())
    j.found["kw4.similar_spin"] = (ours, "open", "No numbers of theirs are printed; and section 4 speaks of ranges.")
    large, flat, turned = (float(np.abs(motions[name].spin[:2]).max()) for name in (PAPER, FLAT, TURNED))
    ours = f"{large:.2f}; Beta turned into the orbit's plane {turned:.2f}; i = 180 degrees {flat:.2f} [1e-5 rad/s]"
    note = (
        f"It is the tilt of Beta's equator to the orbit, {j.facts.equator:.1f} degrees, from whichever of the two: the "
        "stated start has it, a relaxed state has none."
    )
    j.claim("kw4.transverse", ours, max(flat, turned) < 0.1 * large, note=note)


def _errors(j: _Judge) -> None:
    limit = printed.ERRORS
    for shape, numbers in j.results.year.items():
        j.claim(f"kw4.{shape}.energy_error", f"{numbers.energy_step:.1e}", numbers.energy_step < limit["energy"])
    one, two = (j.results.year[shape].angular_momentum_step for shape in ("ellipsoid", "spheroid"))
    j.claim("kw4.momentum_error", f"{one:.1e}", one < limit["angular_momentum"])
    j.claim("kw4.momentum_error_spheroid", f"{two:.1e} and {one:.1e}", 0.1 < two / one < 10)
    places, apart = j.facts.momentum_growth
    ours = f"{places[0]:.0e} in the first quarter, {places[1]:.0e} in the last"
    note = (
        f"In the evaluation alone: the barycentre travels {j.facts.travelled:.0f} km, and r x m v about the origin "
        f"loses digits as r grows. With the barycentre's part kept apart {apart[0]:.0e} and {apart[1]:.0e}."
    )
    j.claim("kw4.momentum_drift", ours, places[1] > 2 * places[0] and apart[1] < 2 * apart[0], note=note)
    steps = [n.energy_step for n in j.results.year.values()] + [c.energy_step for c in j.results.cases.values()]
    steps += [one, two, *(c.momentum_step for c in j.results.cases.values())]
    note = "Section 4 says 1e-11 for the angular momentum of 1999 KW4."
    j.claim("all.errors", f"{max(steps):.1e}", max(steps) < paper.CASE_ERRORS, note=note)
    year = j.results.year["ellipsoid"]
    note = f"From the start it is {year.energy_drift_orbital:.0e} of the orbital energy, by the tolerance of the steps."
    ours = f"energy of the year, step to step {year.energy_step:.0e}"
    j.claim("all.machine", ours, year.energy_step < 10 * float(np.finfo(float).eps), note=note)
    run, most = max(j.facts.theta.items(), key=lambda item: item[1])
    j.claim("all.pole", f"largest abs(theta) {most:.1f} degrees, in {run}", most < 89.0)
