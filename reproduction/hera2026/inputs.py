"""The published values that the prediction rests on, with their sources, and the assumptions made beside them.

Lengths are in metres or kilometres, times in hours or days, angles in degrees, as in the sources.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

__all__ = [
    "ARRIVAL",
    "ASSUMED",
    "CHECKS",
    "DATES",
    "IMPACT",
    "INPUTS",
    "OMITTED",
    "SCHEDULE",
    "SHAPES",
    "SOURCES",
    "STUDY_DATE",
    "Input",
    "inputs_with_shape",
]

#: The date on which the predictions were made.
STUDY_DATE: Final = "2026-11-25"
#: The time of the impact of DART, UTC.
IMPACT: Final = "2022-09-26T23:14:24.183"
#: The time for which the predictions are made, and the times at which the state of Dimorphos is evaluated.
ARRIVAL: Final = "2026-11-15T00:00:00"
DATES: Final = (
    "2024-01-01T00:00:00",
    "2025-06-01T00:00:00",
    ARRIVAL,
    "2026-12-14T00:00:00",
    "2027-02-15T00:00:00",
    "2027-05-15T00:00:00",
)


@dataclass(frozen=True, slots=True)
class Input:
    """A published or assumed number.

    Attributes
    ----------
    value, sigma : float
        A value and its standard error; limits of a published range are taken as two standard errors.
    unit, source, note : str
        The source is a key of :data:`SOURCES`, or ``"assumed"``.
    second_hand : bool
        Whether the number was taken from a text that quotes the source, as the source could not be read.
    """

    value: float
    sigma: float
    unit: str
    source: str
    note: str = ""
    second_hand: bool = False


#: The sources by key, with the parts of each that were read in brackets.
SOURCES: Final = {
    "A21": "Agrusa et al. (2021), Icarus 370, 114624, doi:10.1016/j.icarus.2021.114624, arXiv:2107.07996 (abstract)",
    "B24": "Burnett, Fodde & Ferrari (2024), Exploring tidal dissipation in rubble pile binary secondaries using a "
    "discrete element model, arXiv:2410.09266 (abstract)",
    "C21": "Ćuk, Jacobson & Walsh (2021), Barrel instability in binary asteroids, arXiv:2110.08666 (abstract)",
    "C23": "Cheng et al. (2023), Nature 616, 457, doi:10.1038/s41586-023-05878-z (abstract and first page)",
    "C24": "Cueva et al. (2024), Planet. Sci. J., The secular dynamical evolution of binary asteroid system (65803) "
    "Didymos post-DART (abstract)",
    "Ć24": "Ćuk et al. (2024), BYORP and dissipation in binary asteroids: lessons from DART, arXiv:2406.20064 "
    "(abstract)",
    "D23": "Daly et al. (2023), Nature 616, 443, doi:10.1038/s41586-023-05810-5 (beginning of the text)",
    "D24": "Daly et al. (2024), Planet. Sci. J. 5, 24, doi:10.3847/PSJ/ad0b07 (abstract)",
    "ESA": "ESA, Hera operations, https://www.esa.int/Enabling_Support/Operations/Hera_operations, and ESA's Hera "
    "targets early arrival at Didymos asteroids, https://www.esa.int/Space_Safety/Hera/"
    "ESA_s_Hera_targets_early_arrival_at_Didymos_asteroids (the first read in a stored copy, the second only as "
    "others quote it)",
    "F25": "Farnham et al. (2025), Planet. Sci. J., doi:10.3847/PSJ/addd1a, arXiv:2506.16694 (abstract)",
    "J23": "NASA/NAIF, planetary constants of the DART mission, didymos_system_15.tpc, 2023-09-21, from JPL's solution "
    "542 (header; the numbers as public repositories quote them)",
    "J26": "JPL Horizons, reconstruction DART s547 of Dimorphos' orbit after the impact (as two public repositories "
    "quote it, checked by them in October 2026)",
    "JPL": "JPL's Small-Body Database, osculating elements of JD 2459600.5 (as in fullbody.systems.didymos)",
    "M23": "Meyer et al. (2023), Planet. Sci. J. 4, 141, The perturbed full two-body problem: application to post-DART "
    "Didymos (abstract)",
    "M23b": "Meyer et al. (2023), Icarus, Energy dissipation in synchronous binary asteroids, arXiv:2210.10877 "
    "(abstract)",
    "N20": "Naidu et al. (2020), Icarus 348, 113777, doi:10.1016/j.icarus.2020.113777",
    "N24": "Naidu et al. (2024), Planet. Sci. J. 5, 74, doi:10.3847/PSJ/ad26e7 (abstract)",
    "Nk24": "Nakano et al. (2024), Planet. Sci. J. 5, 133, doi:10.3847/PSJ/ad4350 (abstract)",
    "R24": "Richardson et al. (2024), Planet. Sci. J. 5, 182, doi:10.3847/PSJ/ad62f5, arXiv:2502.14990 (abstract)",
    "S05": "Sharma, Burns & Hui (2005), Mon. Not. R. Astron. Soc. 359, 79, doi:10.1111/j.1365-2966.2005.08864.x "
    "(abstract)",
    "S24": "Scheirich et al. (2024), Planet. Sci. J. 5, 17, doi:10.3847/PSJ/ad12cf, arXiv:2403.02804 (abstract and "
    "beginning of the introduction)",
    "SM23": "Daly, Barnouin, Ernst et al. (2023), DART shape model bundle, NASA PDS, doi:10.26007/96fn-p578: Didymos "
    "v003 and Dimorphos v004 (readme; volumes and extents of the meshes, and the pole and the accuracy in their "
    "documents, as a public atlas measured and quotes them)",
    "T23": "Thomas et al. (2023), Nature 616, 448, doi:10.1038/s41586-023-05805-2",
    "Z24": "Zhou et al. (2024), Astrophys. J. Lett. 968, L3, doi:10.3847/2041-8213/ad4f7f, arXiv:2405.16529 (abstract "
    "of its first version)",
}

#: The inputs of the study, by name.
INPUTS: Final = {
    # Before the impact.
    "period_before": Input(11.921473, 0.000044, "h", "T23", second_hand=True),
    "separation": Input(1189.0, 17.0, "m", "D23", "distance of the centres at the impact", second_hand=True),
    "equatorial": Input(
        405.0,
        7.0,
        "m",
        "SM23",
        "equatorial semi-axis of a spheroid for Didymos: extents of v003, 819 x 801 m, each +- 14 m",
        second_hand=True,
    ),
    "polar": Input(303.5, 7.0, "m", "SM23", "its polar semi-axis: extent 607 +- 14 m", second_hand=True),
    "rotation": Input(2.26, 0.0001, "h", "N20", "rotation period of Didymos", second_hand=True),
    "diameter": Input(
        149.8, 2.5, "m", "SM23", "of a sphere with the volume of Dimorphos v004, 0.00176 km3", second_hand=True
    ),
    "a_b_before": Input(
        1.054, 0.02, "", "SM23", "extents of v004, 178.4 x 169.2 x 114.6 m (Nk24: 1.06)", second_hand=True
    ),
    "b_c_before": Input(1.477, 0.04, "", "SM23", "extents of v004", second_hand=True),
    "density": Input(2400.0, 450.0, "kg/m3", "C23", "of Dimorphos: range of 1500 to 3300"),
    # The impact.
    "dart_mass": Input(579.4, 0.7, "kg", "C23", second_hand=True),
    "dart_speed": Input(6144.9, 0.3, "m/s", "C23", second_hand=True),
    "along": Input(-2.63, 0.06, "mm/s", "N24", "change of the velocity along the motion (C23: -2.70 +- 0.10)"),
    "radial": Input(0.0, 0.5, "mm/s", "assumed", "change of the velocity away from Didymos"),
    "normal": Input(0.0, 1.5, "mm/s", "F25", "across the orbit: boulders may have turned the plane by up to a degree"),
    "miss_radial": Input(0.0, 10.0, "m", "C23", "arm of the momentum in the orbit's plane: DART struck within 25 m"),
    "miss_normal": Input(0.0, 10.0, "m", "C23", "arm of the momentum across the plane, likewise"),
    # After the impact.
    "period": Input(
        11.3674,
        0.0042,
        "h",
        "N24",
        "the settled period; its own error is 0.0004 h. The further change by 34 +- 15 s in the weeks after the impact "
        "(S24: 27 or 19 s) is not modelled, and its error is the error here",
    ),
    "eccentricity": Input(0.028, 0.0053, "", "S24", "published 0.028 +- 0.016 (3 sigma), until 2022-12-02"),
    "precession": Input(6.7, 0.2, "deg/day", "N24", "S24: 7.3 +- 2.0 (3 sigma) until 2022-12-02"),
    "a_b": Input(1.3, 0.15, "", "N24", "'about 1.3', without an error: the width is assumed"),
    "b_c": Input(1.23, 0.12, "", "N24", "'about' 1.6/1.3, without an error: the width is assumed"),
    "yaw": Input(0.0, 10.0, "deg", "assumed", "long axis of the new figure from the line to Didymos"),
    # Slow forces.
    "log_k2_q": Input(-4.0, 1.0, "log10", "B24", "k2/Q of Dimorphos: the range of 1e-6 to 1e-2 that B24 quotes"),
    "log_k2_q_primary": Input(-6.0, 1.0, "log10", "assumed", "k2/Q of Didymos"),
    "byorp": Input(0.0, 0.005, "", "assumed", "coefficient as of Jacobson & Scheeres (2011); C24: a wide range"),
    # Directions.
    "pole_longitude": Input(
        309.8,
        9.3,
        "deg",
        "J23",
        "of the orbit, ecliptic: the pole before the impact at (69.700, -72.695) deg",
        second_hand=True,
    ),
    "pole_latitude": Input(
        -80.7,
        1.5,
        "deg",
        "J23",
        "as before; the error, 1.5 deg in each direction, is assumed: the pole of Didymos in SM23's document is 0.9 "
        "deg away",
        second_hand=True,
    ),
}

#: Published shapes of Didymos as a spheroid: the equatorial and the polar semi-axis in m.
SHAPES: Final[Mapping[str, tuple[Input, Input]]] = {
    "v003": (INPUTS["equatorial"], INPUTS["polar"]),
    "daly2023": (
        Input(425.0, 7.5, "m", "D23", "axes 851 and 849 m", second_hand=True),
        Input(310.0, 7.5, "m", "D23", "axis 620 +- 15 m", second_hand=True),
    ),
    "naidu2024": (Input(394.0, 11.0, "m", "N24", "equatorial radius"), Input(290.0, 16.0, "m", "N24", "polar radius")),
}


def inputs_with_shape(shape: str) -> dict[str, Input]:
    """Return the table of inputs with a published shape of Didymos, by its name in :data:`SHAPES`."""
    equatorial, polar = SHAPES[shape]
    return INPUTS | {"equatorial": equatorial, "polar": polar}


#: Values with unit and source that the study does not use, for comparison with its results.
CHECKS: Final = {
    "mass of both bodies, solution 542": (5.2284e11, "kg", "J23"),
    "mass of both bodies, solution s547": (5.3085e11, "kg", "J26"),
}

#: The schedule of Hera, as printed on the page of the study.
SCHEDULE: Final = {
    "launch": "7 October 2024 (ESA)",
    "plan at launch": "a deep-space manoeuvre in February 2026, an 'impulsive rendezvous' in October 2026 (ESA), and "
    "arrival in late December 2026 (R24)",
    "announced in 2026": "arrival in November 2026, one month early (ESA, as others quote it; the day could not be "
    "read, and one of those who quote it reads the rendezvous in October and the orbit by December)",
    "taken here": f"{ARRIVAL[:10]}, the middle of the announced month; the states are given at other dates, too",
    "public on the day of this page": f"whatever Hera has sent before {STUDY_DATE}: none of it could be read here, and "
    "nothing on this page uses it",
}

#: The assumptions by subject, as printed on the page of the study.
ASSUMED: Final = {
    "orbit before": "circular, with Dimorphos synchronous and both poles along that of the orbit; with the total mass "
    "this orbit has the published period at the drawn distance, in the gravity of the two bodies",
    "Didymos": "a homogeneous spheroid that the impact did not change, with the mean of the two equatorial extents; "
    "the ellipsoid of the extents has 2.5 % more volume than the mesh, and the inertia of the mesh could not be read",
    "Dimorphos": "a homogeneous ellipsoid with the volume from before the impact (S24: 9 +- 9 % less), which has its "
    "new axis ratios from the impact on; the reshaping keeps its angular momentum, and the off-centre impact adds an "
    "angular impulse",
    "impact": "the whole change of velocity occurs at once; ejecta that stayed in the system are not modelled",
    "phase": "the position of Dimorphos on its orbit at the impact is not taken from observations, so that only "
    "intervals between mutual events are predicted and not their absolute times",
    "what damps a roll": "the tide with a constant time lag alone, Q = 10 at the orbital frequency (Didymos: at its "
    "semidiurnal one), so that k2 follows from k2/Q. The inelastic dissipation of the non-principal rotation itself "
    "and episodes of moving material (Ć24) are left out: both would shorten a roll. The page estimates the first one "
    "(S05)",
    "BYORP": "the mean force along the motion while Dimorphos is locked (in the program of 2026-11-27 along its middle "
    "axis, fixed in its body frame), none while it is not, and no torque",
    "Sun": "a point mass on the heliocentric orbit of JPL's elements; no planets, no thermal radiation of the bodies",
    "observed values": "period, eccentricity and precession are those of an ellipse with a constant precession, fitted "
    "to the distances of the first 67 days, to 2022-12-02, in the motion in space",
}

#: The effects that the model leaves out, by subject.
OMITTED: Final = {
    "shapes": "asymmetries of both bodies, which may make the rotation unstable (Nk24), and later changes of shape",
    "observations": "the light curves themselves: published summaries stand for them, and those after 2022-12-02 are "
    "known to this study by one sentence of an abstract",
    "forces": "the binary Yarkovsky effect, which is set beside the result, and drag by ejecta",
    "model error": "the widths of a/b, b/c, k2/Q and the motion across the plane are assumed; the table of widths "
    "shows what they decide",
}
