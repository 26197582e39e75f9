"""(134340) Pluto and Charon."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..model.state import State
from ..motion.system import System
from ..setups.component import Component
from ._build import Frame, G, UnitsChoice, published_binary
from ._published import Published, Value, documented

__all__ = ["pluto_charon"]

FACTS = Published(
    values={
        "radius of Pluto": Value(1188.3, "km", "1.6 (2 sigma)", "N17"),
        "radius of Charon": Value(606.0, "km", "1.0 (2 sigma)", "N17"),
        "GM of Pluto": Value(869.3, "km^3/s^2", "0.4", "B24"),
        "GM of Charon": Value(106.1, "km^3/s^2", "0.3", "B24"),
        "orbital period": Value(6.3872273, "day", "0.0000003", "B12"),
        "eccentricity": Value(0.0, "", "7.5e-5 (upper limit)", "B12"),
        "inclination to the equator": Value(96.218, "deg", "0.008", "B12"),
        "ascending node on the equator": Value(3.89249, "rad", "0.00012", "B12"),
        "pole (right ascension, declination) of 2024 (not used)": Value((133.0073, -6.2449), "deg", "", "B24"),
        "mean longitude": Value(4.50177, "rad", "0.00018", "B12"),
    },
    sources={
        "N17": "Nimmo et al. (2017), Icarus 287, 12, doi:10.1016/j.icarus.2016.06.027",
        "B24": "Brozovic & Jacobson (2024), Astron. J. 167, 256, doi:10.3847/1538-3881/ad39f0",
        "B12": "Buie, Tholen & Grundy (2012), Astron. J. 144, 15, doi:10.1088/0004-6256/144/1/15",
    },
    assumed=(
        "both are homogeneous spheres: [N17] finds no flattening, below 0.6 and 0.5 per cent",
        "the semi-major axis is that of the GM and the period, 19596 km ([B12] gives 19573 +- 2 of its own scale)",
        "the masses are of [B24], the orientation of the orbit is of [B12], whose mean longitude goes with it: the "
        "pole of [B24] is 0.031 degrees from that one",
        "both spin about the pole of the orbit at the mean motion, their x-axes towards each other",
    ),
    frame="equatorial",
    epoch="2002-11-22T00:00:00 TT",
    second_hand=("pole (right ascension, declination) of 2024 (not used)",),
)


@documented(FACTS)
def pluto_charon(*, frame: Frame = "equatorial", units: UnitsChoice = False, **options: Any) -> tuple[System, State]:
    """(134340) Pluto and Charon, doubly synchronous, without the small satellites.

    Parameters
    ----------
    frame : {"equatorial", "ecliptic", "orbit"}
        Frame of the state: the equator of J2000 (taken as the ICRS), the ecliptic of J2000, or the orbit's plane as
        xy-plane with its node on the equator on the x-axis.
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
    >>> system, state = fullbody.systems.pluto_charon()
    >>> orbit = fullbody.KeplerElements.from_cartesian(
    ...     state.position[1] - state.position[0], state.velocity[1] - state.velocity[0], system.mu())
    >>> round(orbit.a), round(orbit.Omega, 5)
    (19596, 3.89249)
    """
    period = 24.0 * FACTS["orbital period"]
    node = FACTS["ascending node on the equator"]
    pole = (np.degrees(node) - 90.0, 90.0 - FACTS["inclination to the equator"])
    phase = FACTS["mean longitude"] - node
    return published_binary(
        FACTS,
        Component(
            diameter=2.0 * FACTS["radius of Pluto"],
            mass=FACTS["GM of Pluto"] * 3600.0**2 / G,
            rotation_period=period,
            rotation_angle=phase,
            name="Pluto",
        ),
        Component(diameter=2.0 * FACTS["radius of Charon"], mass=FACTS["GM of Charon"] * 3600.0**2 / G, name="Charon"),
        period=period,
        mean_anomaly=phase,
        pole=pole,
        frame=frame,
        units=units,
        options=options,
    )
