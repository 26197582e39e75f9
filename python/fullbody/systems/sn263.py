"""(153591) 2001 SN263, a triple."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..base import rotations
from ..base.units import Units, numbers
from ..errors import InvalidInput
from ..frames import attitude, turn_pole
from ..model.bodies import Body
from ..model.state import State
from ..motion.system import System
from ..orbit.elements import KeplerElements
from ..setups.component import Component
from ._build import Frame, G, UnitsChoice, base_units, check_frame, in_frame, in_units, with_epoch
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric, with_sun

__all__ = ["sn263_2001"]

FACTS = Published(
    values={
        "mass of Alpha": Value(917.466e10, "kg", "2.235e10", "F11"),
        "mass of Beta": Value(24.039e10, "kg", "7.531e10", "F11"),
        "mass of Gamma": Value(9.773e10, "kg", "3.273e10", "F11"),
        "semi-major axis of Beta": Value(16.633, "km", "0.163", "F11"),
        "eccentricity of Beta": Value(0.015, "", "0.009", "F11"),
        "inclination of Beta": Value(157.486, "deg", "", "F11"),
        "ascending node of Beta": Value(161.144, "deg", "", "F11"),
        "argument of periapsis of Beta": Value(131.249, "deg", "", "F11"),
        "mean anomaly of Beta": Value(212.658, "deg", "", "F11"),
        "orbital period of Beta (not used)": Value(6.225, "day", "0.0953", "F11"),
        "semi-major axis of Gamma": Value(3.804, "km", "", "F11"),
        "eccentricity of Gamma": Value(0.016, "", "0.002", "F11"),
        "inclination of Gamma": Value(165.045, "deg", "", "F11"),
        "ascending node of Gamma": Value(198.689, "deg", "", "F11"),
        "argument of periapsis of Gamma": Value(292.435, "deg", "", "F11"),
        "mean anomaly of Gamma": Value(248.816, "deg", "", "F11"),
        "orbital period of Gamma (not used)": Value(0.686, "day", "0.00159", "F11"),
        "diameter of Alpha": Value(2.5, "km", "0.3", "B15"),
        "diameter of Beta": Value(0.77, "km", "0.12", "B15"),
        "diameter of Gamma": Value(0.43, "km", "0.14", "B15"),
        "rotation period of Alpha": Value(3.4256, "h", "0.0002", "B15"),
        "rotation period of Beta": Value(13.43, "h", "0.01", "B15"),
        "pole of Alpha (ecliptic longitude, latitude)": Value((309.0, -80.0), "deg", "15", "B15"),
        "J2 of Alpha (fang2011)": Value(0.013, "", "0.008", "F11"),
        "apsidal precession of Gamma (not used)": Value(1.1, "deg/day", "", "F11"),
        **heliocentric((1.9865, 0.4783, 6.6853, 325.83, 172.86, 148.57), 2458000.5),
    },
    sources={
        "JPL": SOURCE,
        "F11": "Fang et al. (2011), Astron. J. 141, 154, doi:10.1088/0004-6256/141/5/154",
        "B15": "Becker et al. (2015), Icarus 248, 499, doi:10.1016/j.icarus.2014.10.048",
    },
    assumed=(
        "the axis ratios are those of the arguments, spheres of the published volumes unless given",
        "with model='fang2011' Alpha is the homogeneous spheroid of its published volume that has the J2 of [F11], "
        "referred to the radius of that volume; which radius [F11] refers it to is not known here",
        "the elements are osculating, of Gamma about Alpha and of Beta about the barycentre of the two (taken about "
        "Alpha they make Beta's period 6.53 days)",
        "the semi-major axes go before the published periods: of spheres the mean periods of 100 days are 6.187 and "
        "0.6857 days (Beta's of 6.225 follows, to 6.223, from its axis and Kepler's law without the mass of Gamma; "
        "with it the law gives 6.191, and Alpha and Gamma, which act like an oblate body, take off the rest)",
        "the epoch, whose clock is not named, is in TT",
        "Gamma spins about the pole of its orbit at its mean motion (published: consistent with it), its longest axis "
        "towards Alpha",
        "Beta spins about the pole of its orbit",
        "the x-axes of Alpha and Beta start at the nodes of their equators",
    ),
    frame="equatorial",
    epoch="2008-02-13T00:00:00 TT",
    second_hand=(
        ELEMENTS,
        EPOCH,
        "mass of Alpha",
        *(
            f"{element} of {name}"
            for name in ("Beta", "Gamma")
            for element in (
                "semi-major axis",
                "eccentricity",
                "inclination",
                "ascending node",
                "argument of periapsis",
                "mean anomaly",
            )
        ),
        "orbital period of Beta (not used)",
        "orbital period of Gamma (not used)",
    ),
    unconfirmed=(
        "mass of Beta",
        "mass of Gamma",
        "uncertainty of semi-major axis of Beta",
        "uncertainty of eccentricity of Beta",
        "uncertainty of orbital period of Beta (not used)",
        "uncertainty of eccentricity of Gamma",
        "uncertainty of orbital period of Gamma (not used)",
        "J2 of Alpha (fang2011)",
    ),
)


@documented(FACTS)
def sn263_2001(
    *,
    model: Literal["spheres", "fang2011"] = "spheres",
    axis_ratios: tuple[tuple[float, float], ...] = ((1.0, 1.0), (1.0, 1.0), (1.0, 1.0)),
    frame: Frame = "equatorial",
    sun: bool = False,
    units: UnitsChoice = False,
    **options: Any,
) -> tuple[System, State]:
    """(153591) 2001 SN263: Alpha, the outer Beta and the inner Gamma, as three ellipsoids.

    Spheres do not precess as the real bodies do: the apses of Gamma advance by 0.14 degrees a day in 100 days, by the
    attraction of Beta alone, while Fang et al. (2011) find about 1.1 from observations with an oblate Alpha. With
    ``model="fang2011"`` they advance by 1.22 degrees a day; the first order of J2 alone, 3/2 n J2 (R/a)^2, is 1.11. The
    uncertainty of that J2 is more than half of its value.

    Parameters
    ----------
    model : {"spheres", "fang2011"}
        The shape of Alpha unless ``axis_ratios`` is given: a sphere, or the oblate spheroid of the J2 by Fang et al.
    axis_ratios : three pairs (a/b, b/c)
        Axis ratios of Alpha, Beta and Gamma, at the published volumes.
    frame : {"equatorial", "ecliptic", "orbit"}
        Frame of the state: the equator of J2000 (taken as the ICRS), the ecliptic of J2000, or the plane of Gamma's
        orbit as xy-plane with its node on the equator on the x-axis.
    sun : bool
        Whether the Sun's gravity acts, as a :class:`fullbody.forces.ThirdBody` on the heliocentric orbit of the table
        below. The state is nine years before the epoch of that orbit, so that the Sun's position has an error of some
        degrees: the Earth, which was at 0.066 au on 2008-02-20, is at 0.10 au by it.
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
    >>> system, state = fullbody.systems.sn263_2001()
    >>> system.names
    ('Alpha', 'Beta', 'Gamma')
    """
    check_frame(frame)
    ratios_of = _ratios(axis_ratios)
    if not isinstance(model, str) or model not in ("spheres", "fang2011"):
        raise InvalidInput(f"model is {model!r}; expected 'spheres' or 'fang2011'")
    if model == "fang2011":
        if ratios_of[0] != (1.0, 1.0):
            raise InvalidInput(
                f"axis_ratios of Alpha are {ratios_of[0]} and model is {model!r}; expected one of the two"
            )
        ratios_of[0] = (1.0, _oblate(FACTS["J2 of Alpha (fang2011)"]))
    options = with_epoch(options, FACTS.epoch)
    base = base_units(units)
    names = ("Alpha", "Beta", "Gamma")
    masses = np.array([FACTS[f"mass of {name}"] for name in names])
    shapes = [
        Component(diameter=FACTS[f"diameter of {name}"], axis_ratios=ratios, name=name).shape
        for name, ratios in zip(names, ratios_of, strict=True)
    ]
    bodies = [Body(shape, mass=mass, name=name) for shape, mass, name in zip(shapes, masses, names, strict=True)]
    position, velocity = np.zeros((3, 3)), np.zeros((3, 3))
    rates = [2 * np.pi / FACTS["rotation period of Alpha"], 2 * np.pi / FACTS["rotation period of Beta"], 0.0]
    lon, lat = np.radians(FACTS["pole of Alpha (ecliptic longitude, latitude)"])
    attitudes = [attitude(*turn_pole(lon, lat, "ecliptic", FACTS.frame)), np.zeros(4), np.zeros(4)]
    # The orbits are those of Gamma about Alpha, then of Beta about the barycentre of the two.
    for index, mass in ((2, masses[0] + masses[2]), (1, masses.sum())):
        orbit = _elements(names[index])
        r, v = orbit.to_cartesian(G * mass)
        position[index] = masses @ position / (masses[0] + masses[2]) + r
        velocity[index] = masses @ velocity / (masses[0] + masses[2]) + v
        plane = rotations.product(rotations.turn(2, float(orbit.Omega)), rotations.turn(0, float(orbit.i)))
        attitudes[index] = plane
        if names[index] == "Gamma":
            rates[index] = 2 * np.pi / orbit.period(G * mass)
            towards = -r @ rotations.matrices(plane)
            attitudes[index] = rotations.product(plane, rotations.turn(2, float(np.arctan2(towards[1], towards[0]))))
    position -= masses @ position / masses.sum()
    velocity -= masses @ velocity / masses.sum()
    if frame == "orbit":
        gamma = _elements("Gamma")
        back = rotations.product(rotations.turn(0, -float(gamma.i)), rotations.turn(2, -float(gamma.Omega)))
        matrix = rotations.matrices(back)
        position, velocity = position @ matrix.T, velocity @ matrix.T
        attitudes = [rotations.product(back, q) for q in attitudes]
    system = System(bodies, G=G, units=base, frame=frame, **options)
    attach = Units(base).attach
    state = State(
        attach(position, "length"),
        attach(velocity, "velocity"),
        np.array(attitudes),
        attach(np.array([[0.0, 0.0, rate] for rate in rates]), "spin"),
        attach(np.float64(0.0), "time"),
    )
    system, state = in_units(system, in_frame(state, FACTS, frame), units)
    pole = (FACTS["ascending node of Gamma"] - 90.0, 90.0 - FACTS["inclination of Gamma"])
    return with_sun(system, FACTS, sun, frame, pole), state


def _oblate(j2: float) -> float:
    """Return the axis ratio a/c of a homogeneous spheroid of this J2, which refers to the radius R of its volume.

    J2 R^2 = (a^2 - c^2)/5 and a^2 c = R^3, so that x = c/R is the real root of x^3 + 5 J2 x = 1.
    """
    half = np.sqrt(0.25 + (5 * j2) ** 3 / 27)
    return float((np.cbrt(0.5 + half) + np.cbrt(0.5 - half)) ** -1.5)


def _ratios(given: Any) -> list[tuple[float, float]]:
    """Return the axis ratios of the three bodies."""
    try:
        pairs = numbers(given, "axis_ratios")
    except InvalidInput:
        pairs = np.zeros(0)
    if pairs.shape != (3, 2):
        raise InvalidInput(
            f"axis_ratios is {given!r}; expected three pairs of numbers (a/b, b/c), of Alpha, of Beta and of Gamma"
        )
    return [(float(first), float(second)) for first, second in pairs]


def _elements(name: str) -> KeplerElements:
    """Return the published elements of a satellite."""
    angles = ("inclination", "ascending node", "argument of periapsis", "mean anomaly")
    return KeplerElements(
        FACTS[f"semi-major axis of {name}"],
        FACTS[f"eccentricity of {name}"],
        *(float(np.radians(FACTS[f"{angle} of {name}"])) for angle in angles),
    )
