"""The published values that the prediction rests on, with their sources, and what is assumed beside them.

Lengths are in metres or kilometres, times in hours or days, angles in degrees, as in the sources.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

__all__ = ["ARRIVAL", "ASSUMED", "DATED", "IMPACT", "INPUTS", "SOURCES", "Input"]

#: The day on which the statements of the study were made, and the moment that its predictions are for.
DATED: Final = "2026-11-23"
IMPACT: Final = "2022-09-26T23:14:24.183"
ARRIVAL: Final = "2026-12-14T00:00:00"


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


SOURCES: Final = {
    "A21": "Agrusa et al. (2021), Icarus 370, 114624, doi:10.1016/j.icarus.2021.114624 (abstract)",
    "C23": "Cheng et al. (2023), Nature 616, 457, doi:10.1038/s41586-023-05878-z (abstract and first page)",
    "C24": "Cueva et al. (2024), Planet. Sci. J., The Secular Dynamical Evolution of Binary Asteroid System (65803) "
    "Didymos Post-DART (abstract)",
    "D23": "Daly et al. (2023), Nature 616, 443, doi:10.1038/s41586-023-05810-5",
    "D24": "Daly et al. (2024), Planet. Sci. J. 5, 24, doi:10.3847/PSJ/ad0b07 (abstract)",
    "F25": "Farnham et al. (2025), Planet. Sci. J., doi:10.3847/PSJ/addd1a, arXiv:2506.16694 (abstract)",
    "G24": "Gramigna et al. (2024), The Hera radio science experiment at Didymos (abstract)",
    "M23": "Meyer et al. (2023), Planet. Sci. J. 4, 141, The Perturbed Full Two-Body Problem: Application to Post-DART "
    "Didymos (abstract)",
    "M23b": "Meyer et al. (2023), Icarus, Energy Dissipation in Synchronous Binary Asteroids, arXiv:2210.10877 "
    "(abstract)",
    "N22": "Naidu et al. (2022), Planet. Sci. J., Anticipating the DART impact, arXiv:2210.05101 (abstract)",
    "N24": "Naidu et al. (2024), Planet. Sci. J. 5, 74, doi:10.3847/PSJ/ad26e7 (abstract)",
    "R24": "Richardson et al. (2024), Planet. Sci. J. 5, 182, doi:10.3847/PSJ/ad62f5, arXiv:2502.14990 (abstract)",
    "S24": "Scheirich et al. (2024), Planet. Sci. J. 5, 17, doi:10.3847/PSJ/ad12cf, arXiv:2403.02804 (abstract)",
    "T23": "Thomas et al. (2023), Nature 616, 448, doi:10.1038/s41586-023-05805-2",
    "N20": "Naidu et al. (2020), Icarus 348, 113777, doi:10.1016/j.icarus.2020.113777",
    "JPL": "JPL's Small-Body Database, osculating elements of JD 2459600.5 (as in fullbody.systems.didymos)",
}

INPUTS: Final = {
    # Before the impact.
    "period_before": Input(11.921473, 0.000044, "h", "T23", "", True),
    "separation": Input(1189.0, 17.0, "m", "D23", "distance of the centres at the impact", True),
    "equatorial": Input(425.0, 7.5, "m", "D23", "mean equatorial semi-axis of Didymos: axes 851 and 849 m", True),
    "polar": Input(310.0, 7.5, "m", "D23", "polar semi-axis of Didymos: axis 620 +- 15 m", True),
    "rotation": Input(2.26, 0.0001, "h", "N20", "rotation period of Didymos", True),
    "diameter": Input(
        151.5, 2.5, "m", "D24", "of equal volume: axes of D23, 177 x 174 x 116 m, with 2.8 % less volume"
    ),
    "density": Input(2400.0, 450.0, "kg/m3", "C23", "of Dimorphos: range of 1500 to 3300"),
    # The impact.
    "dart_mass": Input(579.4, 0.7, "kg", "C23", "", True),
    "dart_speed": Input(6144.9, 0.3, "m/s", "C23", "", True),
    "along": Input(-2.63, 0.06, "mm/s", "N24", "change of the velocity along the motion (C23: -2.70 +- 0.10)"),
    "radial": Input(0.0, 0.5, "mm/s", "assumed", "change of the velocity away from Didymos"),
    "normal": Input(0.0, 1.5, "mm/s", "F25", "across the orbit: boulders may have turned the plane by up to a degree"),
    "miss_radial": Input(0.0, 10.0, "m", "C23", "arm of the momentum in the orbit's plane: DART struck within 25 m"),
    "miss_normal": Input(0.0, 10.0, "m", "C23", "arm of the momentum across the plane, likewise"),
    # After the impact.
    "period": Input(11.3674, 0.0004, "h", "N24", "S24: 11.3675 from its change by -33.240 +- 0.024 min"),
    "eccentricity": Input(
        0.028, 0.0053, "", "S24", "published 0.028 +- 0.016 (3 sigma); also quoted as 0.027 +- 0.015"
    ),
    "precession": Input(6.7, 0.2, "deg/day", "N24", "S24: 7.3 +- 2.0 (3 sigma) until 2022-12-02"),
    "a_b": Input(1.3, 0.15, "", "N24", "'about 1.3', without an error: the width is assumed"),
    "b_c": Input(1.23, 0.12, "", "N24", "'about' 1.6/1.3, without an error: the width is assumed"),
    "yaw": Input(0.0, 10.0, "deg", "assumed", "long axis of the new figure from the line to Didymos"),
    # Slow forces.
    "log_k2_q": Input(-5.0, 1.0, "log10", "assumed", "k2/Q of Dimorphos; dissipation may show within years (M23b)"),
    "log_k2_q_primary": Input(-6.0, 1.0, "log10", "assumed", "k2/Q of Didymos"),
    "byorp": Input(0.0, 0.005, "", "assumed", "coefficient as of Jacobson & Scheeres (2011); C24: a wide range"),
    "pole_longitude": Input(310.0, 7.0, "deg", "N20", "of the orbit, ecliptic; not varied", True),
    "pole_latitude": Input(-84.0, 7.0, "deg", "N20", "of the orbit, ecliptic; not varied", True),
}

ASSUMED: Final = {
    "orbit before": "circular, with Dimorphos synchronous and both poles along that of the orbit; with the total mass "
    "this orbit has the published period at the drawn distance, in the gravity of the two bodies",
    "Didymos": "a homogeneous spheroid that the impact did not change; its two equatorial axes differ by 0.2 % (D23)",
    "Dimorphos": "a homogeneous ellipsoid with the volume from before the impact (S24: 9 +- 9 % less), which has its "
    "new axis ratios from the impact on; its spin changes only by the angular impulse of the off-centre impact",
    "impact": "the whole change of velocity occurs at once and includes the further change of the period by 34 +- 15 s "
    "in the weeks after (N24); ejecta that stayed in the system are not modelled",
    "phase": "the position of Dimorphos on its orbit at the impact is not taken from observations, so that only "
    "intervals between mutual events are predicted and not their absolute times",
    "tides": "constant time lag, Q = 10 at the orbital frequency (Didymos: at its semidiurnal one), so that k2 follows "
    "from k2/Q; no elastic or viscous change of the figures",
    "BYORP": "the mean force along the motion while Dimorphos is locked, none while it is not",
    "Sun": "a point mass on the heliocentric orbit of JPL's elements; no planets",
    "observed values": "period, eccentricity and precession are compared with those of the first 67 days, to "
    "2022-12-02, in the plane of the orbit; the motion across that plane is drawn from its published limits and not "
    "fitted",
    "arrival": f"{ARRIVAL[:10]}: the state is evaluated over the last 67 days before",
}
