"""What was found where the paper and its stated start part, and what the paper could not see, each told once."""

from __future__ import annotations

import math

import numpy as np
from fullbody.commands.kw4 import printed
from fullbody.commands.kw4.year import SHAPES

from . import paper, spin, years
from .physical import FLAT, PAPER, TURNED
from .results import Results

__all__ = ["TITLES", "findings", "sine_growth"]

#: By the names that the verdicts refer to.
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
    """Paragraphs of plain text by the names in ``TITLES``."""
    parts = (_z, _tilt, _period, _spin, _inclination, _errors, _momentum, _physical)
    return {
        name: [" ".join(paragraph.split()) for paragraph in part(r).split("\n\n")]
        for name, part in zip(TITLES, parts, strict=True)
    }


def sine_growth(theta: float) -> float:
    """Growth of sin(2 theta), as which the torque on a tilted spheroid goes, from pi/32."""
    return math.sin(2 * theta) / math.sin(math.pi / 16)


def _z(r: Results) -> str:
    grown, seeded = r.z_motion["compensated"], r.z_motion["seeded"]
    around = (grown.time > 75) & (grown.time < 125)
    orders = np.log10(grown.z[-4:].max() / grown.z[around].max())
    passed = seeded.z > 0.03
    large = (
        ""
        if not passed.any()
        else f"""
        A run that starts with z = 1e-11, the size of the printed motion, passes 0.03 at t =
        {seeded.time[np.argmax(passed)]:.0f} and then stays near the order of 0.1, which the paper prints for
        t = {paper.CASES_LATE:.0f}.
    """
    )
    return f"""
        A half turn about the z-axis turns the system of case 1, and that of case 2, into itself with the two bodies
        exchanged. So both bodies have the same z, and since their barycentre rests at the origin, z is zero at all
        times. What a computation finds is round-off. In case 1 an instability of the motion makes it grow, here by
        {orders:.0f} orders of magnitude between t = 100 and t = {r.late:.0f}. With rates made exactly symmetric z stays
        {r.z_motion["symmetric"].z.max():g}. {large}
        The printed motion is larger than the round-off here, but it is numerical as well. Whether it began with
        round-off, with the quadrature or with the tolerance of the steps cannot be told from the paper.
    """


def _tilt(r: Results) -> str:
    return f"""
        With theta_0 = pi/8 in place of pi/32 the largest spin about x or y is {r.growth["pi/8"]:.2f} times as large;
        the paper has it nearly doubled. The torque on a tilted spheroid goes as sin(2 theta), which grows
        {sine_growth(math.pi / 8):.2f} times. With theta_0 = pi/16 the spin is {r.growth["pi/16"]:.2f} times as large.
        A possible explanation is that the tilt was made twice as large and not four times; nothing in the paper
        decides it.
    """


def _period(r: Results) -> str:
    ours, other = ([r.year[way][shape].period for shape in SHAPES] for way in ("surface", "other_g"))
    said = [printed.YEAR[shape].period for shape in SHAPES]
    # A period goes as the inverse root of G, and a printed one stands for half a unit of its last digit to either side.
    least = max(years.G_HELP * (period / (text + 5e-5)) ** 2 for period, text in zip(other, said, strict=True))
    most = min(years.G_HELP * (period / (text - 5e-5)) ** 2 for period, text in zip(other, said, strict=True))
    kept = all(
        f"{getattr(r.year['other_g'][shape], name):.4f}" == f"{getattr(printed.YEAR[shape], name):.4f}"
        for shape in SHAPES
        for name in ("e_max", "a_min", "a_max", "a_mean")
    )
    return f"""
        The paper does not print its G. The program that its authors have published, SIANS
        (https://github.com/alexhosians/SIANS), computes with 6.67408e-11 m^3/(kg s^2), which the runs here take; the
        help text of its option -units names 6.674e-11. With the former the year's mean periods are {ours[0]:.5f} h
        (ellipsoids) and {ours[1]:.5f} h (spheroids), one unit below the last printed digit. Run with 6.674e-11, they
        are {other[0]:.5f} and {other[1]:.5f} h, which round to the printed {said[0]:.4f} and {said[1]:.4f}; the
        largest eccentricities and the ranges and means of the semi-major axis {"keep" if kept else "do not keep"}
        their printed digits. By Kepler's third law any G from {least * 1e11:.5f}e-11 to {most * 1e11:.5f}e-11 gives
        both printed periods. That the paper's year was run with 6.674e-11 is an explanation; the paper does not say it.
    """


def _spin(r: Results) -> str:
    search, best = r.search, r.search.minima[0]
    phi, theta, psi = best.angles
    agree = np.ptp([way.ranges for way in r.ways], axis=0).max() < 1e-6
    least, largest = sorted(abs(turn) for turn in search.turn)
    others = [m for m in search.minima if abs(m.turn - best.turn) > 5.0]
    second = (
        ""
        if not others
        else f"""
        Among {search.tried} orientations spread evenly over all there are, the best ones refined, the next misses one
        of the six by {others[0].misfit:.4f}e-5 rad/s; it is a turn of {abs(others[0].turn):.1f} degrees.
    """
    )
    slips = [reading for reading in r.readings[2:] if reading.misfit < spin.NEAR]
    exact = sum(reading.misfit <= spin.ROUNDING for reading in slips)
    return f"""
        The printed ranges do not follow from the stated start; the {len(r.ways)} ways to compute them
        {"agree" if agree else "do not agree"}. The printed range in z is as wide as ours but lies elsewhere: the spin
        swings about a mean that depends on how Beta stands to the line to Alpha at the start.

        With the stated spin along Beta's own z-axis, all six numbers come out as printed when Beta starts at phi,
        theta, psi = {phi:.2f}, {theta:.2f}, {psi:.2f} degrees in place of zero. That is a turn of {abs(best.turn):.2f}
        degrees {"against" if best.turn < 0 else "along"} the orbital motion. The rounding of the printed numbers leaves
        it between {least:.2f} and {largest:.2f} degrees, about an axis within {search.off_normal:.1f} degrees of the
        orbit's normal. {second}

        Several simple slips come to nearly the same; a table of the report sets them side by side. Of these,
        {len(slips)} miss none of the six numbers by more than {spin.NEAR:g}e-5 rad/s, and {exact or "none"} of the
        {len(slips)} are within the rounding of all six, {spin.ROUNDING:g}e-5. The printed numbers are too few to choose
        among them. The year from each of these starts has another mean semi-major axis than the printed
        {printed.YEAR["ellipsoid"].a_mean:.4f} km, which the stated start gives. So the paper's Figs. 7 and 8 do not
        seem to come from one start. Which start Fig. 8 had, and why, cannot be told from the paper.
    """


def _inclination(r: Results) -> str:
    one, two = (r.year["surface"][shape] for shape in SHAPES)
    said = [printed.YEAR[shape].inclination_period for shape in SHAPES]
    nodes = [r.nodal[shape] for shape in SHAPES]
    slopes = nodes[0].inclination
    scanned = [f"{s.min():.0f} to {s.max():.0f}" for s in (slopes[slopes < 90], slopes[slopes > 90]) if len(s)]
    prograde = [node.prograde(period) for node, period in zip(nodes, said, strict=True)]
    found = (
        ""
        if np.isnan(prograde).any()
        else f"""
        Prograde orbits at {prograde[0]:.1f} and {prograde[1]:.1f} degrees do, far from the stated 156.1.
    """
    )
    return f"""
        The maxima of the inclination to the first orbit's plane are {one.inclination_period:.0f} h (ellipsoids) and
        {two.inclination_period:.0f} h (spheroids) apart, known to some 10 h, where the paper prints about {said[0]:.0f}
        and {said[1]:.0f} h. In this time the orbit's node goes once round the total angular momentum: a straight line
        through {years.NODAL_HOURS:.0f} h of its motion gives {nodes[0].stated:.0f} and {nodes[1].stated:.0f} h.

        Of the inclinations tried ({" and ".join(scanned)} degrees) no retrograde one has the printed periods; the
        shortest are {nodes[0].least:.0f} and {nodes[1].least:.0f} h. {found}

        The inclination to the xy-plane, another quantity, starts near its largest and is largest again after
        {one.inclination_return:.0f} and {two.inclination_return:.0f} h. A possible explanation is that these times were
        read off; but the second would be rounded to 3500 and not to 3400, so this does not settle it.
    """


def _errors(r: Results) -> str:
    year = r.year["surface"]["ellipsoid"]
    return f"""
        The paper takes errors from step to step. Such differences shrink with the step and hide a drift. From the
        start, the energy of the ellipsoids' year drifts by {year.energy_drift:.1e} of the total and by
        {year.energy_drift_orbital:.1e} of the orbital energy. The total is {r.energy_ratio:.0f} times the orbital
        energy, for most of it is in Alpha's spin. (The orbital energy counts the motion of the barycentre too, which
        moves because Alpha starts at rest.)
    """


def _momentum(r: Results) -> str:
    places, apart = r.momentum["places"], r.momentum["apart"]
    return f"""
        The paper's errors of the angular momentum grow through the year. So do ours when r x m v is formed from the
        bodies' places about the origin: from {places[0]:.1e} of its length in the first quarter of the year to
        {places[1]:.1e} in the last (medians). But Alpha starts at rest, so that the barycentre travels
        {r.travelled:.0f} km in the year, and the farther it is, the fewer digits the places leave for the separation of
        the bodies. With the barycentre's part, which is constant, kept apart, the same run has {apart[0]:.1e} and
        {apart[1]:.1e}, and never more than {r.year["surface"]["ellipsoid"].angular_momentum_drift:.1e}: the motion
        conserves the angular momentum, and only its evaluation drifts. The paper computes about the same origin;
        whether its drift has this cause cannot be told.
    """


def _physical(r: Results) -> str:
    alpha, beta = r.physical[PAPER].tilts
    spins = {name: float(np.abs(motion.spin[:2]).max()) for name, motion in r.physical.items()}
    prograde = max(spins[name] for name in spins if name not in (PAPER, FLAT, TURNED))
    return f"""
        The paper puts orbital elements that refer to a frame of astronomy beside spins along the inertial z-axis. So
        its orbit is retrograde to both spins, {alpha:.1f} degrees from Alpha's pole, where the real one is prograde
        within a few degrees. The paper quotes Fahnestock & Scheeres (2008), Icarus 194, 410, for spins of Beta about x
        and y that hardly change, and explains its own large ones by Beta's angles at the start. What matters is the
        tilt of Beta's equator to the orbit, {180 - beta:.1f} degrees at the stated start, from whichever of the two it
        comes. The spins about x and y reach {spins[PAPER]:.2f}e-5 rad/s there, but {spins[TURNED]:.2f}e-5 with Beta's
        equator turned into the orbit's plane, {spins[FLAT]:.2f}e-5 with the orbit turned into Beta's equator, and
        {prograde:.2f}e-5 at most in the prograde states. The relaxed state is a circular orbit; its osculating
        eccentricity is what the two bodies' quadrupoles add to the attraction. The relaxed and the excited state here
        are states of these kinds and not those authors' own, which use shape models and whose numbers the paper does
        not give; it quotes an eccentricity above {paper.EXCITED_E} for the excited one.
    """
