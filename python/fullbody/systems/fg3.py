"""(175706) 1996 FG3."""

from __future__ import annotations

from typing import Any

from ..model.state import State
from ..motion.system import System
from ..setups.component import Component
from ._build import Frame, UnitsChoice, published_binary
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric

__all__ = ["fg3_1996"]

FACTS = Published(
    values={
        "diameter of the primary": Value(1.69, "km", "0.18, 0.12", "W11"),
        "diameter of the secondary": Value(0.51, "km", "0.03", "W11"),
        "semi-major axis (not used)": Value(2.8, "km", "1.7, 0.7", "W11"),
        "density": Value(1.3, "g/cm^3", "0.6", "P06"),
        "rotation period of the primary": Value(3.595195, "h", "0.000003", "S15"),
        "orbital period": Value(16.1508, "h", "0.0002 (3 sigma)", "S15"),
        "pole (longitude, latitude)": Value((266.0, -83.0), "deg", "4 (3 sigma)", "S15"),
        **heliocentric((1.0538, 0.3497, 1.9911, 299.69, 24.052, 11.261), 2458600.5),
    },
    sources={
        "JPL": SOURCE,
        "W11": "Wolters et al. (2011), Mon. Not. R. Astron. Soc. 418, 1246, doi:10.48550/arXiv.1108.1831",
        "P06": "Pravec et al. (2006), Icarus 181, 63, doi:10.1016/j.icarus.2005.10.014",
        "S15": "Scheirich et al. (2015), Icarus 245, 56, doi:10.1016/j.icarus.2014.09.023",
    },
    assumed=(
        "both bodies have the published density",
        "the axis ratios are those of the arguments, spheres unless given",
        "the orbit is circular and starts on its node (0.05 +- 0.05 by Pravec et al. 2000, Icarus 146, 190, "
        "not confirmed against the source)",
        "the published orbit is one of mean elements: the run keeps the period, not the elements of the start",
        "the primary spins about the pole of the orbit",
        "the secondary spins about it at the mean motion, its longest axis towards the primary",
    ),
    frame="ecliptic",
    second_hand=("density", ELEMENTS, EPOCH),
    unconfirmed=("rotation period of the primary",),
)


@documented(FACTS)
def fg3_1996(
    *,
    primary_ratios: tuple[float, float] = (1.0, 1.0),
    secondary_ratios: tuple[float, float] = (1.0, 1.0),
    frame: Frame = "ecliptic",
    sun: bool = False,
    units: UnitsChoice = False,
    **options: Any,
) -> tuple[System, State]:
    """(175706) 1996 FG3.

    Parameters
    ----------
    primary_ratios, secondary_ratios : (a/b, b/c)
        Axis ratios at the published volumes.
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
    >>> system, state = fullbody.systems.fg3_1996(secondary_ratios=(1.3, 1.2))
    >>> print(f"{system.masses.sum():.2e} kg")
    3.38e+12 kg
    """
    density = 1e12 * FACTS["density"]
    return published_binary(
        FACTS,
        Component(
            diameter=FACTS["diameter of the primary"],
            axis_ratios=primary_ratios,
            density=density,
            rotation_period=FACTS["rotation period of the primary"],
            name="1996 FG3",
        ),
        Component(
            diameter=FACTS["diameter of the secondary"],
            axis_ratios=secondary_ratios,
            density=density,
            name="secondary",
        ),
        period=FACTS["orbital period"],
        pole=FACTS["pole (longitude, latitude)"],
        frame=frame,
        sun=sun,
        units=units,
        options=options,
    )
