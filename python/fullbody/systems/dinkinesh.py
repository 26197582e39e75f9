"""(152830) Dinkinesh and Selam."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..model.composite import Composite, Part
from ..model.shapes import Ellipsoid
from ..model.state import State
from ..motion.system import System
from ..setups.component import Component
from ._build import Frame, UnitsChoice, published_binary
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric

__all__ = ["dinkinesh"]

FACTS = Published(
    values={
        "effective diameter of Dinkinesh": Value(719.0, "m", "", "L24"),
        "rotation period of Dinkinesh": Value(3.7387, "h", "0.0013", "L24"),
        "axes of the inner lobe": Value((240.0, 200.0, 200.0), "m", "", "L24"),
        "axes of the outer lobe": Value((280.0, 220.0, 210.0), "m", "", "L24"),
        "effective diameter of the inner lobe (not used)": Value(212.0, "m", "21", "L24"),
        "effective diameter of the outer lobe (not used)": Value(234.0, "m", "23", "L24"),
        "rotation period of Selam (not used)": Value(52.44, "h", "0.14", "L24"),
        "semi-major axis": Value(3.11, "km", "0.05", "L24"),
        "orbital period": Value(52.67, "h", "0.04", "M23"),
        **heliocentric((2.191, 0.1120, 2.094, 21.380, 66.711, 25.239), 2460000.5),
    },
    sources={
        "JPL": SOURCE,
        "L24": "Levison et al. (2024), Nature 629, 1015, doi:10.1038/s41586-024-07378-0",
        "M23": "Mottola et al. (2023), Mon. Not. R. Astron. Soc. Lett. 524, L1, doi:10.1093/mnrasl/slad066",
    },
    assumed=(
        "Dinkinesh is a spheroid with a polar axis of 0.75 of its width, which is then 791 m",
        "the lobes of Selam are ellipsoids that touch in a point, their longest axes in one line with Dinkinesh",
        "all have one density: Selam has 5.7 per cent of the mass of 4.9e11 kg by the period and the semi-major axis",
        "the orbit is circular and starts on its node; its pole is opposite to that of the heliocentric orbit",
        "the period of the light curve is the orbit's, since Selam is locked",
        "the published orbit is one of mean elements: the run keeps the period, not the elements of the start",
        "both spin about the pole of the orbit, Selam at the mean motion",
    ),
    frame="ecliptic",
    second_hand=(
        ELEMENTS,
        EPOCH,
        "rotation period of Dinkinesh",
        "axes of the inner lobe",
        "axes of the outer lobe",
        "effective diameter of the inner lobe (not used)",
        "effective diameter of the outer lobe (not used)",
        "rotation period of Selam (not used)",
        "semi-major axis",
    ),
)


@documented(FACTS)
def dinkinesh(
    *, frame: Frame = "ecliptic", sun: bool = False, units: UnitsChoice = False, **options: Any
) -> tuple[System, State]:
    """(152830) Dinkinesh and its satellite Selam, a contact binary.

    Parameters
    ----------
    {frame}
    {sun}
    {units}

    Returns
    -------
    system : System
        Selam is a :class:`fullbody.Composite` of two lobes.
    state : State

    Notes
    -----
    {published}

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.dinkinesh()
    >>> [part.shape.a for part in system["Selam"].shape.parts]
    [0.12, 0.14]
    """
    diameter = FACTS["effective diameter of Dinkinesh"] / 1000.0
    primary = Component(
        diameter=diameter,
        axis_ratios=(1.0, 1.0 / 0.75),
        rotation_period=FACTS["rotation period of Dinkinesh"],
        name="Dinkinesh",
    )
    inner, outer = (np.array(FACTS[f"axes of the {side} lobe"]) / 2000.0 for side in ("inner", "outer"))
    # The body's x-axis points at the primary.
    lobes = [
        Part(Ellipsoid(*map(float, inner)), density=1.0, position=(inner[0], 0.0, 0.0)),
        Part(Ellipsoid(*map(float, outer)), density=1.0, position=(-outer[0], 0.0, 0.0)),
    ]
    node, inclination = (FACTS[ELEMENTS][k] for k in (3, 2))
    return published_binary(
        FACTS,
        primary,
        Component(composite=Composite(lobes), name="Selam"),
        mass_ratio=float((np.prod(inner) + np.prod(outer)) / (diameter / 2.0) ** 3),
        period=FACTS["orbital period"],
        semi_major_axis=FACTS["semi-major axis"],
        pole=(node + 90.0, inclination - 90.0),
        frame=frame,
        sun=sun,
        units=units,
        options=options,
    )
