"""Haumea, Namaka and Hi'iaka: the sign of right ascension, and the axis and the J2 of a triaxial Haumea."""

from __future__ import annotations

from dataclasses import dataclass

import fullbody
import numpy as np
import numpy.typing as npt
from astropy.time import Time
from fullbody import observing
from fullbody.fitting import Fit, Free
from fullbody.frames import pole_vector
from scipy.stats import chi2, norm

from ..judging import LIMIT, Verdict, claimed, compared, stated, word
from . import moons
from .flattening import Chance, chance
from .pair import INTEGRATOR, LOOSE, G, points
from .shapes import oblate, upright
from .triple import ORBIT, elements, nested, on_equator

__all__ = ["Haumea", "angle_between", "deviation_from_ring", "mirrored", "orbit_pole", "study", "verdicts"]

_Array = npt.NDArray[np.float64]

EPOCH = Time(2454615.0, format="jd", scale="utc")
#: Ragozzine & Brown (2009), on the ecliptic of J2000: a in km, e, and i, node, argument of periapsis and mean anomaly.
HIIAKA = (49880.0, 0.0513, 126.356, 206.766, 154.1, 152.8)
NAMAKA = (25657.0, 0.249, 113.013, 205.016, 178.9, 178.5)
PERIOD, PERIOD_ERROR = 49.12, 0.03
E_HIIAKA = (0.0513, 0.0078)
#: Masses of Haumea (1e21 kg), Namaka and Hi'iaka (1e18 kg), and their errors.
MASSES = {"haumea": (4.006, 0.040), "namaka": (1.79, 1.48), "hiiaka": (17.9, 1.1)}
#: The pole of Haumea's ring from a stellar occultation (Ortiz et al. 2017), right ascension and declination in degrees.
RING = ((285.1, 0.5), (-10.6, 1.2))
#: Semi-axes of Haumea in km, from the same occultation.
SEMI_AXES = (1161.0, 852.0, 513.0)
#: The radius of the sphere of equal volume, and the J2 of the triaxial figure for it, averaged over its fast rotation.
RADIUS = float(np.prod(SEMI_AXES) ** (1.0 / 3.0))
TRIAXIAL = (SEMI_AXES[0] ** 2 + SEMI_AXES[1] ** 2 - 2.0 * SEMI_AXES[2] ** 2) / (10.0 * RADIUS**2)
#: The spin in rad/day, one rotation in two days. It only decides how stiff the axis of a spheroid is, and steps need
#: not follow the true rotation of 3.9 hours. At four times this rate chi2 of a fit with a free axis changes by 0.04 and
#: the axis by 0.02 degrees.
SPIN = np.pi
NAMES = ("Haumea", "Namaka", "Hiiaka")


@dataclass(frozen=True)
class Haumea:
    """The fits of the study.

    Attributes
    ----------
    alone : dict of Fit
        Hi'iaka alone, by the sign of right ascension: from the published orbit, and from its mirror image, whose
        offsets to the east are reversed.
    early : dict of Fit
        Both moons as points with the published masses, in the observations up to 2008, by the sign.
    points : Fit
        Three points, with the sign reversed.
    ring, ring_j2 : Fit
        Haumea's axis is that of the ring, with the J2 of the triaxial figure and with a free J2.
    axis, axis_j2 : Fit
        Haumea's axis is free, with the J2 of the triaxial figure and with a free J2.
    mirror : Fit
        As ``axis``, with the sign that the tables have; the lowest minimum that was found.
    chance : Chance
        The probability that chi2 falls from ``points`` to ``axis_j2`` by chance.
    """

    alone: dict[int, Fit]
    early: dict[int, Fit]
    points: Fit
    ring: Fit
    ring_j2: Fit
    axis: Fit
    axis_j2: Fit
    mirror: Fit
    chance: Chance


def study() -> Haumea:
    """Fit everything."""
    total, central = G * sum(_kilograms().values()), G * _kilograms()["haumea"]
    hiiaka, namaka = on_equator(*HIIAKA, total), on_equator(*NAMAKA, central)
    images = mirrored(*namaka), mirrored(*hiiaka)
    setup = points(EPOCH, 0.0045, ("Haumea", "Hiiaka"))
    alone, early, fits, axis = {}, {}, {}, {}
    for east, (inner, outer) in ((1, (namaka, hiiaka)), (-1, images)):
        data = moons.haumea(east)
        alone[east] = fullbody.fit(setup, elements(*outer, total), data[1], integrator=INTEGRATOR)
        # The published orbits hold for the years up to 2008; fits of these years give the starts for all years.
        early[east] = fullbody.fit(
            _with_masses,
            _start(inner, outer, central, total),
            [_until(data_set, 2009.0) for data_set in data],
            integrator=INTEGRATOR,
        )
        full = fullbody.fit(_with_masses, early[east].values, data, integrator=INTEGRATOR)
        masses = {name: Free(MASSES[name][0], min=0.01) for name in ("namaka", "hiiaka")}
        fits[east] = fullbody.fit(_points, {**full.values, **masses}, data, integrator=INTEGRATOR)
        best = fits[east].values
        ra, dec = orbit_pole(best["i_hiiaka"], best["node_hiiaka"])
        # The masses that points need are far from those with J2.
        axis[east] = fullbody.fit(triaxial, {"ra": ra, "dec": dec, **best, **masses}, data, integrator=LOOSE)
    ring = fullbody.fit(_on_ring, fits[-1].values, data, integrator=LOOSE)
    ring_j2 = fullbody.fit(_on_ring, {"J2": TRIAXIAL, **ring.values}, data, integrator=LOOSE)
    axis_j2 = fullbody.fit(_spheroid, {"J2": TRIAXIAL, **axis[-1].values}, data, integrator=LOOSE)
    fall = chance(fits[-1], _spheroid, fits[-1].chi2 - axis_j2.chi2)
    return Haumea(alone, early, fits[-1], ring, ring_j2, axis[-1], axis_j2, axis[1], fall)


def _start(
    inner: tuple[_Array, _Array], outer: tuple[_Array, _Array], central: float, total: float
) -> dict[str, float]:
    """Return the parameters of a fit from positions and velocities of Namaka and Hi'iaka, and G times the masses."""
    parameters = {"haumea": MASSES["haumea"][0]}
    for moon, state, mu in (("namaka", inner, central), ("hiiaka", outer, total)):
        start = elements(*state, mu)
        parameters |= {f"{name}_{moon}": start[name] for name in ORBIT}
    return parameters


def orbit_pole(i: float, node: float) -> tuple[float, float]:
    """Return right ascension and declination in degrees of the normal of an orbit on the equator."""
    return (node - 90.0) % 360.0, 90.0 - i


def _kilograms() -> dict[str, float]:
    return {name: mass * (1e21 if name == "haumea" else 1e18) for name, (mass, _) in MASSES.items()}


def angle_between(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Return the angle in degrees between two axes, without their sense."""
    vectors = [pole_vector(*np.radians(axis)) for axis in (first, second)]
    return float(np.degrees(np.arccos(min(1.0, abs(float(np.dot(*vectors)))))))


def mirrored(r: _Array, v: _Array) -> tuple[_Array, _Array]:
    """Rotate an orbit by 180 degrees about the north of the sky at Haumea, which reverses offsets to the east."""
    ra, dec = np.radians([204.1, 19.2])
    north = np.array([-np.sin(dec) * np.cos(ra), -np.sin(dec) * np.sin(ra), np.cos(dec)])
    rotation = 2.0 * np.outer(north, north) - np.eye(3)
    return rotation @ r, rotation @ v


def _until(data: observing.Astrometry, year: float) -> observing.Astrometry:
    rows = data.times.decimalyear < year
    return observing.Astrometry(
        data.times[rows],
        data.east[rows],
        data.north[rows],
        data.sigma[rows],
        data.correlation[rows],
        body=data.body,
        about=data.about,
        geometry=data.geometry,
    )


def _points(haumea: float, namaka: float, hiiaka: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
    return nested(NAMES, (haumea * 1e21, namaka * 1e18, hiiaka * 1e18), *_orbits(orbits), EPOCH)


def _with_masses(haumea: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
    """Return points with the published masses of the moons."""
    return _points(haumea, MASSES["namaka"][0], MASSES["hiiaka"][0], **orbits)


def _spheroid(
    J2: float, ra: float, dec: float, haumea: float, namaka: float, hiiaka: float, **orbits: float
) -> tuple[fullbody.System, fullbody.State]:
    """Return a spheroidal Haumea with the time average of the triaxial figure's gravity; its axis is in degrees."""
    return nested(
        NAMES,
        (haumea * 1e21, namaka * 1e18, hiiaka * 1e18),
        *_orbits(orbits),
        EPOCH,
        oblate(RADIUS, J2),
        upright(90.0 - dec, ra + 90.0),
        SPIN,
    )


def triaxial(**parameters: float) -> tuple[fullbody.System, fullbody.State]:
    return _spheroid(TRIAXIAL, **parameters)


def _on_ring(J2: float = TRIAXIAL, **parameters: float) -> tuple[fullbody.System, fullbody.State]:
    return _spheroid(J2, RING[0][0], RING[1][0], **parameters)


def _orbits(orbits: dict[str, float]) -> tuple[list[float], list[float]]:
    inner, outer = ([orbits[f"{name}_{moon}"] for name in ORBIT] for moon in ("namaka", "hiiaka"))
    return inner, outer


def deviation_from_ring(fit: Fit) -> float:
    """Return the standard deviations of a normal distribution that correspond to the angle between axis and ring."""
    indices = [fit.names.index(name) for name in ("ra", "dec")]
    difference = np.array([fit.values[name] - value for name, (value, _) in zip(("ra", "dec"), RING, strict=True)])
    spread = fit.covariance[np.ix_(indices, indices)] + np.diag([error**2 for _, error in RING])
    return float(norm.isf(0.5 * chi2.sf(difference @ np.linalg.solve(spread, difference), 2)))


def verdicts(result: Haumea) -> list[Verdict]:
    """Compare the fits with Ragozzine & Brown (2009) and with the ring."""
    reversed_sign, axis, free = result.alone[-1], result.axis, result.axis_j2
    rows = [_parity(result)]
    ra, dec = orbit_pole(reversed_sign.values["i"], reversed_sign.values["node"])
    errors = reversed_sign.sigma["node"], reversed_sign.sigma["i"]
    ring = RING[0][0], RING[1][0]
    names = ("right ascension", "declination")
    angle = angle_between((ra, dec), ring)
    why = f"The ring need not lie in the plane of the orbit. The axes are {angle:.1f} degrees apart."
    for name, published, fitted in zip(names, RING, zip((ra, dec), errors, strict=True), strict=True):
        quantity = f"{name} of the pole of Hi'iaka's orbit, against the ring [deg]"
        rows.append(compared("Haumea", quantity, published, fitted, why))
    angle = angle_between((axis.values["ra"], axis.values["dec"]), ring)
    why = (
        f"Not explained. The axes are {angle:.1f} degrees apart, which is {deviation_from_ring(axis):.1f} sigma for "
        "the errors of both."
    )
    for name, key, published in zip(names, ("ra", "dec"), RING, strict=True):
        quantity = f"{name} of Haumea's axis from the moons, against the ring [deg]"
        rows.append(compared("Haumea", quantity, published, (axis.values[key], axis.sigma[key]), why))
    alone = " and ".join(f"{fit.values['period']:.3f}" for fit in result.alone.values())
    why = f"Not explained. Hi'iaka alone gives {alone} days with the two signs of right ascension."
    for quantity, name, published in (
        ("period of Hi'iaka [d]", "period_hiiaka", (PERIOD, PERIOD_ERROR)),
        ("e of Hi'iaka", "e_hiiaka", E_HIIAKA),
    ):
        rows.append(compared("Haumea", quantity, published, (axis.values[name], axis.sigma[name]), why))
    correlation = free.correlation[free.names.index("J2"), free.names.index("hiiaka")]
    why = (
        "J2 and the mass of Hi'iaka have nearly the same effect on Namaka's orbit (correlation "
        f"{correlation:.2f}). As points the moons give {result.points.values['hiiaka']:.1f}e18 kg, and with a free J2 "
        f"{stated(free.values['hiiaka'], free.sigma['hiiaka'])}."
    )
    for name, published in MASSES.items():
        unit = "1e21 kg" if name == "haumea" else "1e18 kg"
        fitted = axis.values[name], axis.sigma[name]
        rows.append(compared("Haumea", f"mass of {name.title()} [{unit}]", published, fitted, why))
    rows.append(_figure(result))
    return rows


def _figure(result: Haumea) -> Verdict:
    """Judge whether the J2 that the moons show is that of the figure."""
    free = result.axis_j2
    j2, error = free.values["J2"], free.sigma["J2"]
    difference = (j2 - TRIAXIAL) / error
    holds = abs(difference) <= LIMIT
    return Verdict(
        "Haumea",
        "J2 for the radius of equal volume, axis free, against the homogeneous triaxial figure (Ortiz et al. 2017)",
        f"{TRIAXIAL:.3f}",
        stated(j2, error),
        difference,
        word(holds),
        "" if holds else "The difference is in our standard errors.",
    )


def _parity(result: Haumea) -> Verdict:
    """Judge which sign of right ascension the data have."""
    tables, reversed_sign = result.mirror, result.axis
    assert tables.p_value is not None
    assert reversed_sign.p_value is not None
    return claimed(
        "Haumea",
        "offsets in right ascension are positive to the east, as in the tables",
        "assumed",
        f"chi2 {tables.chi2:.1f} of {tables.dof} with this sign, {reversed_sign.chi2:.1f} with the sign reversed",
        tables.p_value > reversed_sign.p_value,
        "The parallax due to the motion of the Earth and Haumea distinguishes an orbit from its mirror image: in the "
        "tables the sign of right ascension is reversed. The fits include both moons, the J2 of the triaxial figure "
        "and a free axis.",
    )
