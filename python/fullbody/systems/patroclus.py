"""(617) Patroclus and Menoetius."""

from __future__ import annotations

from typing import Any

from ..model.state import State
from ..motion.system import System
from ..setups.component import Component
from ._build import Frame, G, UnitsChoice, published_binary
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric

__all__ = ["patroclus_menoetius"]

FACTS = Published(
    values={
        "axes of Patroclus": Value((127.0, 117.0, 98.0), "km", "", "B15"),
        "axes of Menoetius": Value((117.0, 108.0, 90.0), "km", "", "B15"),
        "GM of the system": Value(0.0950, "km^3/s^2", "0.0012", "B24"),
        "orbital period": Value(4.282753, "day", "0.000023", "B24"),
        "semi-major axis (not used)": Value(692.5, "km", "4.0", "B24"),
        "eccentricity": Value(0.004, "", "0.004", "B24"),
        "pole (right ascension, declination)": Value((178.0, -74.1), "deg", "0.5, 0.2", "B24"),
        **heliocentric((5.2173868, 0.1385012, 22.047388, 44.356808, 308.444, 120.37132), 2457600.5),
    },
    sources={
        "JPL": SOURCE,
        "B15": "Buie et al. (2015), Astron. J. 149, 113, doi:10.1088/0004-6256/149/3/113",
        "B24": "Brozovic et al. (2024), Astron. J. 167, 104, bibcode 2024AJ....167..104B, tables at CDS J/AJ/167/104",
    },
    assumed=(
        "both bodies have one density, so that Menoetius has 44 per cent of the mass ([B24] assumed about 22)",
        "the semi-major axis is that of GM and the period, 690.7 km",
        "the published orbit is one of mean elements: the run keeps the period, not the elements of the start",
        "both spin about the pole of the orbit at the mean motion, their longest axes towards each other",
        "the orbit starts at periapsis on its node",
    ),
    frame="equatorial",
    second_hand=("axes of Patroclus", "axes of Menoetius", ELEMENTS, EPOCH),
)


@documented(FACTS)
def patroclus_menoetius(
    *, frame: Frame = "equatorial", sun: bool = False, units: UnitsChoice = False, **options: Any
) -> tuple[System, State]:
    """(617) Patroclus and Menoetius, a Trojan pair of almost equal bodies.

    Parameters
    ----------
    {frame}
    {sun}
    {units}

    Returns
    -------
    system : System
    state : State

    Notes
    -----
    {published}

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.patroclus_menoetius()
    >>> print(f"{system.masses[1] / system.masses.sum():.2f}")
    0.44
    """
    period = 24.0 * FACTS["orbital period"]
    return published_binary(
        FACTS,
        Component(diameters=FACTS["axes of Patroclus"], rotation_period=period, name="Patroclus"),
        Component(diameters=FACTS["axes of Menoetius"], name="Menoetius"),
        total_mass=FACTS["GM of the system"] * 3600.0**2 / G,
        equal_density=True,
        period=period,
        eccentricity=FACTS["eccentricity"],
        pole=FACTS["pole (right ascension, declination)"],
        frame=frame,
        sun=sun,
        units=units,
        options=options,
    )
