"""The conclusions of the study, as paragraphs with the numbers of the fits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..judging import LIMIT, stated
from .catalogue import LEAST_RATIO, Refit
from .eris import RADIUS, Eris, excluded
from .haumea import RING, TRIAXIAL, Haumea, angle_between, deviation_from_ring, orbit_pole
from .lempo import Lempo

__all__ = ["TESTED", "findings"]

#: The text on what agreement with a published orbit shows.
TESTED = (
    "The fits start from the published orbits. Agreement therefore tests how the files are read, frames, light time, "
    "derivatives and the minimum next to the published one, by a program that shares nothing with the authors'. It "
    "does not test whether there is a better minimum elsewhere, nor whether observations, errors and model are right: "
    "most of the observations are those of the publication, so that both results share their errors."
)


def findings(
    catalogue: Sequence[Refit], eris: Eris, lempo: Lempo | None, haumea: Haumea | None
) -> dict[str, list[str]]:
    """Return the paragraphs of each section, by its title."""
    sections = {"The catalogue": _catalogue(catalogue), "Eris and Dysnomia": _eris(eris)}
    if lempo is not None:
        sections["Lempo, Hiisi and Paha"] = _lempo(lempo)
    if haumea is not None:
        sections["Haumea, Namaka and Hi'iaka"] = _haumea(haumea)
    return sections


def _catalogue(refits: Sequence[Refit]) -> list[str]:
    agreeing = [refit for refit in refits if refit.holds]
    text = [
        f"{len(agreeing)} of {len(refits)} systems have a, the period, e and i within {LIMIT:g} joint standard "
        "errors. The fits include the light time, with relative positions on the equator of J2000 and times in UTC at "
        "the observer.",
        "The observations are the copy of the published tables in the repository of the program MultiMoon "
        "(dragozzine/multimoon), and not the tables themselves: rows that are missing or exchanged may be faults of "
        "the copy.",
    ]
    for refit in refits:
        if refit.exchanged:
            text.append(
                f"{refit.catalogued.name}: the two components have nearly equal brightness, and in rows "
                f"{', '.join(map(str, refit.exchanged))} (counted from 0) their order is opposite to that in the "
                f"other rows. With these rows reversed chi2 is {refit.fit.chi2:.1f} for {refit.fit.dof} degrees of "
                "freedom, and all elements agree with the published ones. As given, chi2 on the same orbit is "
                f"{refit.file_chi2:.0f}."
            )
    incomplete = [refit for refit in refits if refit.ratio < LEAST_RATIO]
    factor = max(max(refit.ratio, 1.0 / refit.ratio) for refit in refits if refit.ratio >= LEAST_RATIO)
    if incomplete:
        text.append(
            "The published errors of the period are smaller than the data in the file allow, so that the file probably "
            "lacks rows, in "
            + ", ".join(f"{refit.catalogued.name} ({1 / refit.ratio:.1f} times)" for refit in incomplete)
            + f". In the other {len(refits) - len(incomplete)} systems the published errors of the period are the "
            f"fitted ones within a factor of {factor:.1f}."
        )
    for refit in refits:
        if not refit.holds:
            verdict = "agree with" if refit.p_rise > 0.05 else "contradict"
            text.append(f"{refit.catalogued.name}: {refit.why} The data {verdict} the published orbit.")
    poorly_fitted = [refit for refit in refits if refit.fit.p_value is not None and refit.fit.p_value < 0.02]
    if poorly_fitted:
        text.append(
            "Errors that are too small, or orbits that are not Keplerian, are likely where p is below 0.02: "
            + ", ".join(
                f"{refit.catalogued.name} (chi2 {refit.fit.chi2:.1f} of {refit.fit.dof})" for refit in poorly_fitted
            )
            + "."
        )
    return text


def _eris(eris: Eris) -> list[str]:
    fit, circle, free = eris.points, eris.circular, eris.spheroid
    j2 = free.values["J2"], free.sigma["J2"]
    return [
        f"The 19 epochs give chi2 {fit.chi2:.2f} for {fit.dof} degrees of freedom: a Keplerian orbit with these "
        f"errors is excluded at {excluded(fit):.1f} sigma. The eccentricity is "
        f"{fit.values['e'] / fit.sigma['e']:.1f} standard errors above zero; a circular orbit has chi2 "
        f"{circle.chi2:.1f} for {circle.dof}. Without light time chi2 is {eris.instant.chi2:.1f}, which is "
        "lower: chi2 does not reveal this error, which shifts the mean longitude by "
        f"{abs(eris.instant.values['longitude'] - fit.values['longitude']):.1f} degrees.",
        "The catalogue's file of the same system, 2003 UB313, ends in 2015 and gives another eccentricity and "
        f"period. With the seven epochs of 2018, e is {stated(fit.values['e'], fit.sigma['e'])} and the period "
        f"{fit.values['period']:.5f} days, as in the catalogue.",
        f"A free J2 of Eris, along the normal of the orbit and for a radius of {RADIUS:.0f} km, is {stated(*j2)}; "
        f"chi2 falls by {fit.chi2 - free.chi2:.1f} for one parameter, to {free.chi2:.1f}. A flattening "
        "about this axis does not explain the remaining excess of chi2. Possible, and not tried: another axis of Eris, "
        "the figure of Dysnomia, a further satellite, underestimated errors or errors that differ between the "
        "instruments, centres of light that are not the centres of mass. The "
        f"error of the periapsis grows from {fit.sigma['periapsis']:.0f} to {free.sigma['periapsis']:.0f} degrees, "
        "since J2 makes it precess.",
    ]


def _lempo(lempo: Lempo) -> list[str]:
    fit, without, free = lempo.points, lempo.uncorrelated, lempo.spheroid
    names = ("lempo", "hiisi", "paha")
    indices = [fit.names.index(name) for name in names]
    correlations = fit.correlation[np.ix_(indices, indices)]
    j2 = free.values["J2"], free.sigma["J2"]
    axis_ratio = float(np.sqrt(max(0.0, 1.0 - 5.0 * (j2[0] + 2.0 * j2[1]))))
    mass_difference = fit.values["hiisi"] - fit.values["lempo"]
    error = float(np.sqrt(np.array([-1.0, 1.0]) @ fit.covariance[np.ix_(indices[:2], indices[:2])] @ [-1.0, 1.0]))
    scale = float(np.sqrt(fit.chi2 / fit.dof))
    bound = ", at the bound of zero," if "paha" in fit.at_bounds else ""
    return [
        f"With three point masses chi2 is {without.chi2:.2f} for {without.dof} degrees of freedom with the errors as "
        "collected. The errors were independent in right ascension and declination; the rotation to the ecliptic "
        f"correlates them, but the collected table omits the correlation. After the rotation back, chi2 is "
        f"{fit.chi2:.2f}.",
        f"The masses in 1e18 kg are {stated(fit.values['lempo'], fit.sigma['lempo'])} (Lempo), "
        f"{stated(fit.values['hiisi'], fit.sigma['hiisi'])} (Hiisi) and{bound} {fit.values['paha']:.2f} +- "
        f"{fit.sigma['paha']:.2f} (Paha). Their correlations are {correlations[0, 1]:.2f} (Lempo and Hiisi), "
        f"{correlations[0, 2]:.2f} (Lempo and Paha) and {correlations[1, 2]:.2f} (Hiisi and Paha). These errors take "
        f"those of the observations as they are, with which the fit has a probability of {fit.p_value:.1g}. Scaled by "
        f"{scale:.2f}, so that chi2 is the number of degrees of freedom, they make Hiisi heavier than Lempo, the "
        f"brighter one, by {stated(mass_difference, scale * error)}, {mass_difference / (scale * error):.1f} standard "
        "errors: with a model that does not fit, this does not decide which is heavier. Paha has less than "
        f"{lempo.limit:.2f}e18 kg at 95 per cent with the scaled errors; with 0.22e18 kg chi2 is "
        f"{lempo.heavy.chi2 - fit.chi2:.2f} larger.",
        "Only diameters are published, and spheres attract like points. If Lempo is flattened along the normal of the "
        f"inner orbit and rotates with that orbit, J2 is {stated(*j2)} for a radius of 143 km, and chi2 is "
        f"{free.chi2:.2f}, lower by {fit.chi2 - free.chi2:.2f} for one parameter. At a J2 two standard errors above "
        f"this value the polar axis would be {100.0 * (1.0 - axis_ratio):.1f} per cent shorter than the others.",
    ]


def _haumea(haumea: Haumea) -> list[str]:
    return [*_parity(haumea), *_figure(haumea)]


def _parity(haumea: Haumea) -> list[str]:
    as_published, mirrored = haumea.alone[1], haumea.alone[-1]
    first, second = (orbit_pole(fit.values["i"], fit.values["node"]) for fit in (as_published, mirrored))
    (ra, ra_error), (dec, dec_error) = RING
    early, early_mirrored = haumea.early[1], haumea.early[-1]
    return [
        "The file has offsets along the ecliptic. If they are rotated back to the equator about the file's direction "
        "of Haumea, which is that from the Sun and not from the Earth, nearly all of them have five decimals again, "
        f"as in a printed table. Measured: taken as east, they leave chi2 {as_published.chi2:.1f} for "
        f"{as_published.dof} degrees of freedom with Hi'iaka alone, and the pole of its orbit at ({first[0]:.1f}, "
        f"{first[1]:.1f}) degrees; taken as west, chi2 {mirrored.chi2:.1f} and ({second[0]:.2f}, {second[1]:.2f}). "
        "With both moons, the J2 of the triaxial figure and a free axis the lowest chi2 that was found is "
        f"{haumea.mirror.chi2:.1f} and {haumea.axis.chi2:.1f} for {haumea.axis.dof}. Inferred, since parallax "
        "distinguishes an orbit from its mirror image: the sign of right ascension in the tables is reversed, and "
        "the published orbit of 2009 is the mirror image. The pole with the sign reversed is "
        f"{angle_between(second, (ra, dec)):.1f} degrees from that of the ring, ({ra} +- {ra_error}, {dec} +- "
        f"{dec_error}), which a stellar occultation gave (Ortiz et al. 2017); the other is "
        f"{angle_between(first, (ra, dec)):.0f} degrees from it.",
        "The observations up to 2008, to which that orbit was fitted, do not show this: both moons as points, with the "
        f"published masses, leave chi2 {early.chi2:.1f} for {early.dof} as in the tables and "
        f"{early_mirrored.chi2:.1f} with the sign reversed. The observations of 2010 and 2015, when Haumea was "
        "elsewhere in the sky, decide the question.",
    ]


def _figure(haumea: Haumea) -> list[str]:
    points, axis, free, chance = haumea.points, haumea.axis, haumea.axis_j2, haumea.chance
    ring, ring_j2 = haumea.ring, haumea.ring_j2
    correlation = free.correlation[free.names.index("J2"), free.names.index("hiiaka")]
    j2 = free.values["J2"], free.sigma["J2"]
    pole = axis.values["ra"], axis.values["dec"]
    hiiaka_pole = orbit_pole(axis.values["i_hiiaka"], axis.values["node_hiiaka"])
    (ra, _), (dec, _) = RING
    decrease = points.chi2 - free.chi2
    deviation = abs(j2[0] - TRIAXIAL) / j2[1]
    masses = [stated(fit.values["hiiaka"], fit.sigma["hiiaka"]) for fit in (axis, free)]
    return [
        f"With both moons as points chi2 is {points.chi2:.1f} for {points.dof} degrees of freedom. Measured: with the "
        f"J2 of the triaxial figure of the occultation, {TRIAXIAL:.3f} for the radius of equal volume, "
        f"and a free axis it is {axis.chi2:.1f} for {axis.dof}. The axis is "
        f"({stated(axis.values['ra'], axis.sigma['ra'])}, {stated(axis.values['dec'], axis.sigma['dec'])}) degrees, "
        f"and Hi'iaka has {masses[0]}e18 kg. If J2 is also free, it is {stated(*j2)} and chi2 is {free.chi2:.1f}. For "
        f"points chi2 is higher by {decrease:.1f}, with three parameters fewer. This decrease does not have the chi2 "
        "distribution of three degrees of freedom: without a flattening the axis has no effect, so that the decrease "
        "is the largest one over all axes. To first order in J2 the observations give a decrease of "
        f"{chance.fall:.1f}. In simulated observations of three point masses with the stated errors, also to first "
        f"order, it is as large in a fraction of {chance.p_first:.1g} ({chance.sigma:.1f} sigma), and as large as "
        f"that of the fits, which are not of first order, in a fraction of {chance.p_value:.1g}. Proudfoot et al. "
        "(2024), who have more observations, find J2 and the axis at 2.5 sigma or more. We claim no detection: the "
        "probability is that of random errors as stated, and the axis found is not that of the ring (below), so that "
        "errors of another kind may contribute.",
        f"Inferred: this J2 is {deviation:.1f} standard errors from that of the homogeneous figure. The mass of "
        "Hi'iaka depends on J2, since both have nearly the same effect on Namaka's orbit (correlation "
        f"{correlation:.2f}): with a free J2 it is {masses[1]}e18 kg, and as points the moons give "
        f"{points.values['hiiaka']:.1f}e18 kg.",
        f"The axis is {angle_between(pole, (ra, dec)):.1f} degrees from the pole of the ring, "
        f"{deviation_from_ring(axis):.1f} sigma for the errors of both, and "
        f"{angle_between(pole, hiiaka_pole):.1f} degrees from that of Hi'iaka's orbit; this is not explained. "
        f"With the axis of the ring and the J2 of the figure chi2 is {ring.chi2:.1f} for {ring.dof}, and a free J2 is "
        f"{stated(ring_j2.values['J2'], ring_j2.sigma['J2'])} with chi2 {ring_j2.chi2:.1f}: along that axis these "
        "data show no flattening.",
    ]
