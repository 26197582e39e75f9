"""Findings where the paper and its stated initial conditions differ, and on what the paper does not show."""

from __future__ import annotations

import math

import numpy as np

from . import paper, spin, years
from .kw4 import SHAPES
from .physical import EQUATOR_IN_ORBIT, ORBIT_IN_EQUATOR, PAPER
from .results import Results

__all__ = ["TITLES", "findings", "sine_growth"]

#: Titles of the findings by the names that the verdicts refer to.
TITLES = {
    "z": "There is no motion along z",
    "tilt": "Case 2 with a larger tilt",
    "period": "The mean period and G",
    "spin": "Beta's spin",
    "inclination": "The period of the inclination",
    "errors": "Errors from the start",
    "momentum": "The angular momentum does not drift",
    "physical": "The physical 1999 KW4",
}


def findings(r: Results) -> dict[str, list[str]]:
    """Return paragraphs of plain text by the names in ``TITLES``."""
    parts = (_z, _tilt, _period, _spin, _inclination, _errors, _momentum, _physical)
    return {
        name: [" ".join(paragraph.split()) for paragraph in part(r).split("\n\n")]
        for name, part in zip(TITLES, parts, strict=True)
    }


def sine_growth(theta: float) -> float:
    """Return the growth of sin(2 theta), to which the torque on a tilted spheroid is proportional, from pi/32."""
    return math.sin(2 * theta) / math.sin(math.pi / 16)


def _z(r: Results) -> str:
    grown, seeded = r.z_motion["compensated"], r.z_motion["seeded"]
    interval = (grown.time > 75) & (grown.time < 125)
    orders = np.log10(grown.z[-4:].max() / grown.z[interval].max())
    above = seeded.z > 0.03
    growth = (
        ""
        if not above.any()
        else f"""
        A run that starts with z = 1e-11, the size of the printed motion, exceeds 0.03 at t =
        {seeded.time[np.argmax(above)]:.0f} and then remains of the order of 0.1, which the paper prints for
        t = {paper.CASES_LONG_END:.0f}.
    """
    )
    return f"""
        A half turn about the z-axis maps the system of case 1, and that of case 2, to itself with the two bodies
        exchanged. Both bodies therefore have the same z, and since their barycentre is at rest at the origin, z is zero
        at all times. A nonzero z in a computation is round-off. In case 1 an instability of the motion amplifies it,
        here by {orders:.0f} orders of magnitude between t = 100 and t = {r.long_end:.0f}. If the rates are made exactly
        symmetric, z remains {r.z_motion["symmetric"].z.max():g}. {growth}
        The printed motion is larger than the round-off here, but it is numerical as well. The paper does not allow us
        to decide whether it began with round-off, with the quadrature or with the tolerance of the steps.
    """


def _tilt(r: Results) -> str:
    return f"""
        With theta_0 = pi/8 in place of pi/32 the largest spin about x or y is {r.growth["pi/8"]:.2f} times as large;
        according to the paper it nearly doubles. The torque on a tilted spheroid is proportional to sin(2 theta), which
        grows by a factor of {sine_growth(math.pi / 8):.2f}. With theta_0 = pi/16 the spin is
        {r.growth["pi/16"]:.2f} times as large. A possible explanation is that the tilt was made twice as large and not
        four times; nothing in the paper decides this.
    """


def _period(r: Results) -> str:
    computed, other = ([r.year[run][shape].period for shape in SHAPES] for run in ("surface", "other_g"))
    stated = [paper.YEAR[shape].period for shape in SHAPES]
    # A period is proportional to the inverse root of G; a printed one has an error of half a unit of its last digit.
    least = max(years.G_HELP * (period / (text + 5e-5)) ** 2 for period, text in zip(other, stated, strict=True))
    most = min(years.G_HELP * (period / (text - 5e-5)) ** 2 for period, text in zip(other, stated, strict=True))
    unchanged = all(
        f"{getattr(r.year['other_g'][shape], name):.4f}" == f"{getattr(paper.YEAR[shape], name):.4f}"
        for shape in SHAPES
        for name in ("e_max", "a_min", "a_max", "a_mean")
    )
    return f"""
        The paper does not print its G. The program that its authors have published, SIANS
        (https://github.com/alexhosians/SIANS), uses 6.67408e-11 m^3/(kg s^2), as do the runs here; the help text of its
        option -units names 6.674e-11. With the former value the mean periods of the year are {computed[0]:.5f} h
        (ellipsoids) and {computed[1]:.5f} h (spheroids), lower by one unit of the last printed digit. With 6.674e-11
        they
        are {other[0]:.5f} and {other[1]:.5f} h, which round to the printed {stated[0]:.4f} and {stated[1]:.4f};
        the largest eccentricities and the ranges and means of the semi-major axis
        {"keep" if unchanged else "do not keep"} their printed digits. By Kepler's third law any G from
        {least * 1e11:.5f}e-11 to {most * 1e11:.5f}e-11 gives both printed periods. A possible explanation
        is that the paper's year was run with 6.674e-11; the paper does not state this.
    """


def _spin(r: Results) -> str:
    search, best = r.search, r.search.minima[0]
    phi, theta, psi = best.angles
    agree = np.ptp([variant.ranges for variant in r.variants], axis=0).max() < 1e-6
    least, largest = sorted(abs(angle) for angle in search.rotation_range)
    rivals = [m for m in search.minima if abs(m.rotation - best.rotation) > 5.0]
    second = (
        ""
        if not rivals
        else f"""
        A search through {search.count} orientations, spread evenly over all orientations, with the best ones refined,
        finds a next best one that misses one of the six numbers by {rivals[0].misfit:.4f}e-5 rad/s; it is a rotation of
        {abs(rivals[0].rotation):.1f} degrees.
    """
    )
    slips = [reading for reading in r.readings[2:] if reading.misfit < spin.NEAR]
    exact = sum(reading.misfit <= spin.ROUNDING for reading in slips)
    return f"""
        The printed ranges do not follow from the stated initial conditions; the {len(r.variants)} ways to compute them
        {"agree" if agree else "do not agree"}. The printed range in z is as wide as ours but has another centre: the
        spin oscillates about a mean that depends on the initial angle between Beta's axes and the line to Alpha.

        With the stated spin along Beta's own z-axis, all six numbers agree with the printed ones if Beta starts at
        phi, theta, psi = {phi:.2f}, {theta:.2f}, {psi:.2f} degrees instead of zero. This is a rotation by
        {abs(best.rotation):.2f} degrees {"against" if best.rotation < 0 else "along"} the orbital motion. The rounding
        of the
        printed numbers allows rotations by {least:.2f} to {largest:.2f} degrees, about an axis within
        {search.largest_tilt:.1f} degrees of the orbit's normal. {second}

        Several simple slips have nearly the same effect; a table of the report compares them. With {len(slips)} of
        these no number differs by more than {spin.NEAR:g}e-5 rad/s, and with {exact or "none"} of the {len(slips)} all
        six agree within their rounding, {spin.ROUNDING:g}e-5. The printed numbers are too few to choose among the
        slips. The year from each of these initial conditions has a mean semi-major axis that differs from the printed
        {paper.YEAR["ellipsoid"].a_mean:.4f} km, which the stated initial conditions give. The paper's Figs. 7 and 8
        therefore do not seem to come from one run. The paper does not allow us to determine the initial conditions of
        Fig. 8.
    """


def _inclination(r: Results) -> str:
    first, second = (r.year["surface"][shape] for shape in SHAPES)
    stated = [paper.YEAR[shape].inclination_period for shape in SHAPES]
    nodes = [r.nodal[shape] for shape in SHAPES]
    tilts = nodes[0].inclination
    scanned = [f"{part.min():.0f} to {part.max():.0f}" for part in (tilts[tilts < 90], tilts[tilts > 90]) if len(part)]
    prograde = [node.prograde(period) for node, period in zip(nodes, stated, strict=True)]
    result = (
        ""
        if np.isnan(prograde).any()
        else f"""
        Prograde orbits at {prograde[0]:.1f} and {prograde[1]:.1f} degrees have them, far from the stated 156.1.
    """
    )
    return f"""
        The maxima of the inclination to the plane of the first orbit are {first.inclination_period:.0f} h (ellipsoids)
        and {second.inclination_period:.0f} h (spheroids) apart, with an error of some 10 h; the paper prints about
        {stated[0]:.0f} and {stated[1]:.0f} h. In this time the orbit's node precesses once about the total angular
        momentum: a straight line fitted to {years.NODAL_HOURS:.0f} h of its motion gives {nodes[0].stated:.0f} and
        {nodes[1].stated:.0f} h.

        Of the inclinations tried ({" and ".join(scanned)} degrees) no retrograde one has the printed periods; the
        shortest are {nodes[0].least:.0f} and {nodes[1].least:.0f} h. {result}

        The inclination to the xy-plane, a different quantity, starts near its maximum and returns to the maximum after
        {first.inclination_return:.0f} and {second.inclination_return:.0f} h. A possible explanation is that the paper
        gives these times; but the second would be rounded to 3500 and not to 3400, so this does not decide the
        question.
    """


def _errors(r: Results) -> str:
    year = r.year["surface"]["ellipsoid"]
    return f"""
        The paper gives errors from step to step. Such differences decrease with the step size and hide a drift.
        Measured from the start, the energy in the year with ellipsoids drifts by {year.energy_drift:.1e} of the total
        and by {year.energy_drift_orbital:.1e} of the orbital energy. The total is {r.energy_ratio:.0f} times the
        orbital energy, because most of it is in Alpha's spin. (The orbital energy includes that of the barycentre,
        which moves because Alpha starts at rest.)
    """


def _momentum(r: Results) -> str:
    samples, separate = r.momentum["positions"], r.momentum["separate"]
    return f"""
        In the paper the errors of the angular momentum grow through the year. Ours grow too if r x m v is formed from
        positions relative to the origin: from {samples[0]:.1e} of its length in the first quarter of the year to
        {samples[1]:.1e} in the last (medians). Alpha starts at rest, so that the barycentre travels
        {r.barycentre_displacement:.0f} km in the year, and the farther it is from the origin, the fewer digits remain
        for the
        separation of the bodies. If the constant part of the barycentre is treated separately, the errors of the same
        run are {separate[0]:.1e} and {separate[1]:.1e}, and never more than
        {r.year["surface"]["ellipsoid"].angular_momentum_drift:.1e}: the motion conserves the angular momentum, and only
        its evaluation drifts. The paper uses the same origin; we cannot decide whether its drift has this cause.
    """


def _physical(r: Results) -> str:
    alpha, beta = r.physical[PAPER].tilts
    spins = {name: float(np.abs(motion.spin[:2]).max()) for name, motion in r.physical.items()}
    prograde = max(spins[name] for name in spins if name not in (PAPER, ORBIT_IN_EQUATOR, EQUATOR_IN_ORBIT))
    return f"""
        The paper combines orbital elements that refer to an astronomical frame with spins along the inertial z-axis.
        Its orbit is therefore retrograde with respect to both spins, with a normal {alpha:.1f} degrees from Alpha's
        pole, while the real orbit is prograde within a few degrees. The paper quotes Fahnestock & Scheeres (2008),
        Icarus 194, 410, for spins of Beta about x and y that hardly change, and explains its own large ones by Beta's
        initial angles. These spins depend on the tilt between Beta's equator and the orbit, {180 - beta:.1f} degrees at
        the stated start, whether Beta or the orbit is tilted. The spins about x and y reach {spins[PAPER]:.2f}e-5 rad/s
        there, but {spins[EQUATOR_IN_ORBIT]:.2f}e-5 with Beta's equator rotated into the plane of the orbit,
        {spins[ORBIT_IN_EQUATOR]:.2f}e-5
        with the orbit rotated into the plane of Beta's equator, and at most {prograde:.2f}e-5 in the prograde states.
        The relaxed state is a circular orbit; its osculating eccentricity is due to the quadrupoles of the two bodies.
        The relaxed and the excited state here are states of these kinds and not those of Fahnestock & Scheeres, who use
        shape models and whose numbers the paper does not give; it quotes an eccentricity above {paper.EXCITED_E} for
        the excited state.
    """
