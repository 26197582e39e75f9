"""(65803) Didymos and Dimorphos, before and after DART."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..errors import InvalidInput
from ..model.state import State
from ..motion.system import System
from ..setups.binary import binary
from ..setups.component import Component
from ._build import Frame, G, UnitsChoice, published_binary
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric

__all__ = ["didymos", "didymos_after_dart"]

_SOURCES = {
    "D23": "Daly et al. (2023), Nature 616, 443, doi:10.1038/s41586-023-05810-5",
    "T23": "Thomas et al. (2023), Nature 616, 448, doi:10.1038/s41586-023-05805-2",
    "N20": "Naidu et al. (2020), Icarus 348, 113777, doi:10.1016/j.icarus.2020.113777",
    "JPL": SOURCE,
    "D24": "Daly et al. (2024), Planet. Sci. J. 5, 24, doi:10.3847/PSJ/ad0b07",
}
_BODIES = {
    "axes of Didymos": Value((0.851, 0.849, 0.620), "km", "0.015", "D23"),
    "rotation period of Didymos": Value(2.2600, "h", "0.0001", "N20"),
    "pole (longitude, latitude)": Value((310.0, -84.0), "deg", "20", "N20"),
    **heliocentric((1.6442, 0.38385, 3.4079, 73.196, 319.32, 232.01), 2459600.5),
}
_ASSUMED = (
    "period and semi-major axis before the impact are those of [T23] (some texts attribute them to [N20])",
    "both bodies have one density, so that the masses go by volume",
    "Dimorphos before the impact has the first published shape ([D24]: a volume smaller by 2.8 per cent)",
    "Didymos spins about the pole of the orbit",
    "Dimorphos spins about the pole of the orbit at the mean motion, its longest axis towards Didymos",
    "the published orbit is one of mean elements: the run keeps the period, not the elements of the start",
    "the orbit starts at periapsis on its node: the epoch is that of the elements and not of the phase",
)
_SECOND_HAND = (
    ELEMENTS,
    EPOCH,
    "axes of Didymos",
    "rotation period of Didymos",
    "pole (longitude, latitude)",
)
BEFORE = Published(
    values={
        **_BODIES,
        "axes of Dimorphos": Value((0.177, 0.174, 0.116), "km", "0.002, 0.004, 0.002", "D23"),
        "orbital period": Value(11.921473, "h", "0.000044", "T23"),
        "semi-major axis": Value(1.206, "km", "0.035", "T23"),
    },
    sources=_SOURCES,
    assumed=(*_ASSUMED, "the orbit is circular (published as nearly so)"),
    frame="ecliptic",
    epoch="2022-09-26T23:14:24.183 UTC",
    second_hand=(*_SECOND_HAND, "axes of Dimorphos", "orbital period", "semi-major axis"),
)
AFTER = Published(
    values={
        **_BODIES,
        "axes of Dimorphos before": BEFORE.values["axes of Dimorphos"],
        "semi-axes of Didymos (naidu2024)": Value((0.394, 0.394, 0.290), "km", "0.011, 0.011, 0.016", "N24"),
        "axis ratios a/b, a/c of Dimorphos": Value((1.3, 1.6), "", "", "N24"),
        "orbital period before": BEFORE.values["orbital period"],
        "semi-major axis before": BEFORE.values["semi-major axis"],
        "orbital period": Value(11.3674, "h", "0.0004", "N24"),
        "eccentricity": Value(0.028, "", "0.016 (3 sigma)", "S24"),
        "apsidal precession (not used)": Value(6.7, "deg/day", "0.2", "N24"),
    },
    sources={
        **_SOURCES,
        "N24": "Naidu et al. (2024), Planet. Sci. J. 5, 74, doi:10.3847/PSJ/ad26e7",
        "S24": "Scheirich et al. (2024), Planet. Sci. J. 5, 17, doi:10.3847/PSJ/ad12cf",
    },
    assumed=(
        *_ASSUMED,
        "the impact left the total mass and the volume of Dimorphos as they were ([S24]: 9 +- 9 per cent less volume)",
        "Didymos kept its shape and spin",
        "Dimorphos is upright unless tilted, and does not tumble at the start (it may; Richardson et al. 2024, "
        "doi:10.3847/PSJ/ad62f5)",
        "[N24] finds the axis ratios of Dimorphos together with its own Didymos, an oblate spheroid; with "
        "model='daly2023' they stand beside the shape of Didymos by [D23], whose quadrupole is 19 per cent larger",
        "with model='naidu2024' too, the total mass is that of the orbit before the impact and the volume of Dimorphos "
        "that of [D23]: which masses and which eccentricity [N24] goes with could not be read",
    ),
    frame="ecliptic",
    epoch="2022-09-26T23:14:24.183 UTC",
    second_hand=(
        *_SECOND_HAND,
        "axes of Dimorphos before",
        "orbital period before",
        "semi-major axis before",
    ),
)


@documented(BEFORE)
def didymos(
    *, frame: Frame = "ecliptic", sun: bool = False, units: UnitsChoice = False, **options: Any
) -> tuple[System, State]:
    """(65803) Didymos and Dimorphos before the impact of DART.

    The total mass is that of the published period and semi-major axis, 5.6e11 kg.

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
    >>> system, state = fullbody.systems.didymos()
    >>> print(f"{system.masses.sum():.2e} kg")
    5.63e+11 kg
    """
    return published_binary(
        BEFORE,
        _primary(),
        _secondary_before(),
        equal_density=True,
        period=BEFORE["orbital period"],
        semi_major_axis=BEFORE["semi-major axis"],
        pole=BEFORE["pole (longitude, latitude)"],
        frame=frame,
        sun=sun,
        units=units,
        options=options,
    )


@documented(AFTER)
def didymos_after_dart(
    *,
    model: Literal["daly2023", "naidu2024"] = "daly2023",
    tilt: Any = 0.0,
    frame: Frame = "ecliptic",
    sun: bool = False,
    units: UnitsChoice = False,
    **options: Any,
) -> tuple[System, State]:
    """(65803) Didymos and Dimorphos after the impact of DART and the weeks that followed.

    The advance of the apses here is no prediction of the 6.7 +- 0.2 degrees a day that Naidu et al. (2024) observe: it
    depends on the initial state of Dimorphos, which was not observed. In planar runs of 60 days (``frame="orbit"``),
    with the spin of Dimorphos at the start multiplied by the number in the first row:

    ===================== ===== ===== ===== ===== ===== ===== =====
    spin by mean motion   0.80  0.85  0.90  0.95  1.00  1.05  1.10
    daly2023, deg/day     5.48  5.46  5.64  5.99  6.51  7.17  7.94
    naidu2024, deg/day    3.38  3.34  3.50  3.83  4.31  4.94  5.67
    ===================== ===== ===== ===== ===== ===== ===== =====

    With Dimorphos upright the start is planar to the last bit, and this motion is unstable: a spin of Dimorphos that is
    slightly inclined to the orbit's normal grows into a roll about the long axis. Without a tilt it grows from
    round-off, so that the time at which it begins, after about a thousand hours, depends on the frame, the machine and
    the integrator, and has no meaning. With ``tilt=1e-3`` the roll exceeds 5 degrees after about 170 hours and 30
    degrees after about 260 hours, and over the first 60 days the apses advance by about 3 degrees a day. The later
    motion is chaotic. Of ten starts with tilts from 0.0010000 to 0.0010009, integrated for a year, two stayed below 50
    degrees of roll, and in eight Dimorphos rolled over, first after 1600 to 7400 hours; other rounding errors lead to
    other numbers. In all ten the long axis stayed directed at Didymos, with pitch below 30 and yaw below 45 degrees:
    Dimorphos rolls about that axis, and does not tumble end over end.

    Parameters
    ----------
    model : {"daly2023", "naidu2024"}
        The shape of Didymos: the ellipsoid of 851 x 849 x 620 m by Daly et al. (2023), or the spheroid of semi-axes 394
        and 290 m with which Naidu et al. (2024) find the axis ratios of Dimorphos. See the assumptions below.
    tilt : float or Quantity
        Angle of Dimorphos' pole from the orbit's normal, radians; the longest axis still points at Didymos.
    frame : {"ecliptic", "equatorial", "orbit"}
        Frame of the state; see :func:`didymos`.
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
    >>> system, state = fullbody.systems.didymos_after_dart()
    >>> shape = system.bodies[1].shape
    >>> round(shape.a / shape.b, 3), round(shape.a / shape.c, 3)
    (1.3, 1.6)
    >>> fullbody.systems.didymos_after_dart(model="naidu2024")[0].bodies[0].shape
    Ellipsoid(a=0.394, b=0.394, c=0.29)
    """
    if not isinstance(model, str) or model not in ("daly2023", "naidu2024"):
        raise InvalidInput(f"model is {model!r}; expected 'daly2023' or 'naidu2024'")
    to_b, to_c = AFTER["axis ratios a/b, a/c of Dimorphos"]
    diameter = float(np.cbrt(np.prod(AFTER["axes of Dimorphos before"])))
    # The masses from the orbit before the impact do not need the search for its mean period.
    before, _ = binary(
        _primary(),
        _secondary_before(),
        equal_density=True,
        period=BEFORE["orbital period"],
        semi_major_axis=BEFORE["semi-major axis"],
        elements="osculating",
        mismatch_warning=np.inf,
        G=G,
    )
    return published_binary(
        AFTER,
        _primary() if model == "daly2023" else _primary(semi_axes=AFTER["semi-axes of Didymos (naidu2024)"]),
        Component(diameter=diameter, axis_ratios=(to_b, to_c / to_b), tilt=tilt, name="Dimorphos"),
        equal_density=True,
        total_mass=float(before.masses.sum()),
        period=AFTER["orbital period"],
        eccentricity=AFTER["eccentricity"],
        pole=AFTER["pole (longitude, latitude)"],
        frame=frame,
        sun=sun,
        units=units,
        options=options,
    )


def _secondary_before() -> Component:
    return Component(diameters=BEFORE["axes of Dimorphos"], name="Dimorphos")


def _primary(**size: Any) -> Component:
    return Component(
        **(size or {"diameters": BEFORE["axes of Didymos"]}),
        rotation_period=BEFORE["rotation period of Didymos"],
        name="Didymos",
    )
