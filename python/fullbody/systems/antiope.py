"""(90) Antiope."""

from __future__ import annotations

from typing import Any

from ..model.state import State
from ..motion.system import System
from ..setups.component import Component
from ._build import Frame, UnitsChoice, published_binary
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric

__all__ = ["antiope"]

FACTS = Published(
    values={
        "axes of the first": Value((93.0, 87.0, 83.6), "km", "1.0 (of the mean)", "D07"),
        "axes of the second": Value((89.4, 82.8, 79.6), "km", "1.0 (of the mean)", "D07"),
        "density (not used)": Value(1.25, "g/cm^3", "0.05", "D07"),
        "separation": Value(171.0, "km", "1", "D07"),
        "orbital period": Value(24.0 * 0.687713, "h", "0.0001", "D07"),
        "pole (longitude, latitude)": Value((200.0, 38.0), "deg", "2", "D07"),
        "refined pole (not used)": Value((199.5, 39.8), "deg", "0.5, 5", "D09"),
        "refined density (not used)": Value(1.28, "g/cm^3", "0.04", "D09"),
        "mass by a model that is not convex (not used)": Value(9.14e17, "kg", "", "B14"),
        "separation by that model (not used)": Value(176.0, "km", "", "B14"),
        "density by that model (not used)": Value(1.67, "g/cm^3", "", "B14"),
        **heliocentric((3.155, 0.1567, 2.2195, 70.21, 242.96, 304.12), 2455400.5),
    },
    sources={
        "JPL": SOURCE,
        "D07": "Descamps et al. (2007), Icarus 187, 482, doi:10.1016/j.icarus.2006.10.030",
        "B14": "Bartczak et al. (2014), Mon. Not. R. Astron. Soc. 443, 1802, doi:10.1093/mnras/stu1247",
        "D09": "Descamps et al. (2009), Icarus 203, 102, doi:10.48550/arXiv.0905.0631",
    },
    assumed=(
        "both bodies have one density; the total mass is that of the period and the separation, 8.4e17 kg ([B14], with "
        "shapes that are not convex: 9.14e17 kg at 176 km)",
        "the orbit is circular (published: an eccentricity below 0.006) and starts on its node",
        "the published orbit is one of mean elements: the run keeps the period, not the elements of the start",
        "both spin about the pole of the orbit at the mean motion, their longest axes towards each other",
    ),
    frame="ecliptic",
    second_hand=(
        ELEMENTS,
        EPOCH,
        "mass by a model that is not convex (not used)",
        "separation by that model (not used)",
        "density by that model (not used)",
        "axes of the first",
        "axes of the second",
        "density (not used)",
        "separation",
        "orbital period",
        "pole (longitude, latitude)",
    ),
)


@documented(FACTS)
def antiope(
    *, frame: Frame = "ecliptic", sun: bool = False, units: UnitsChoice = False, **options: Any
) -> tuple[System, State]:
    """(90) Antiope, two almost equal and nearly hydrostatic bodies a diameter apart.

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
    >>> system, state = fullbody.systems.antiope()
    >>> print(f"{system.bodies[0].density / 1e12:.2f} g/cm^3")
    1.26 g/cm^3
    """
    return published_binary(
        FACTS,
        Component(diameters=FACTS["axes of the first"], rotation_period=FACTS["orbital period"], name="Antiope"),
        Component(diameters=FACTS["axes of the second"], name="S/2000 (90) 1"),
        equal_density=True,
        period=FACTS["orbital period"],
        semi_major_axis=FACTS["separation"],
        pole=FACTS["pole (longitude, latitude)"],
        frame=frame,
        sun=sun,
        units=units,
        options=options,
    )
