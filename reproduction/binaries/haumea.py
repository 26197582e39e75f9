"""Haumea, Namaka and Hi'iaka: the sign of right ascension, and the J2 of a triaxial Haumea."""

from __future__ import annotations

from dataclasses import dataclass

import fullbody
import numpy as np
import numpy.typing as npt
from astropy.time import Time
from fullbody import observing
from fullbody.fitting import Fit, Free

from . import moons
from .judging import Verdict, compared, stated
from .pair import G, INTEGRATOR, points
from .shapes import oblate, upright
from .triple import ORBIT, elements, nested, on_equator

__all__ = ["Haumea", "pole", "study", "verdicts"]

_Array = npt.NDArray[np.float64]

EPOCH = Time(2454615.0, format="jd", scale="utc")
#: Ragozzine & Brown (2009), on the ecliptic of J2000: km, e, and i, node, argument of periapsis, mean anomaly in degrees.
HIIAKA = (49880.0, 0.0513, 126.356, 206.766, 154.1, 152.8)
NAMAKA = (25657.0, 0.249, 113.013, 205.016, 178.9, 178.5)
PERIOD, PERIOD_ERROR = 49.12, 0.03
E_HIIAKA = (0.0513, 0.0078)
#: Of Haumea (1e21 kg), Namaka and Hi'iaka (1e18 kg).
MASSES = {"haumea": (4.006, 0.040), "namaka": (1.79, 1.48), "hiiaka": (17.9, 1.1)}
#: The pole of Haumea's ring from a stellar occultation (Ortiz et al. 2017), right ascension and declination in degrees.
RING = ((285.1, 0.5), (-10.6, 1.2))
#: Semi-axes of Haumea in km, from the same occultation.
SEMI_AXES = (1161.0, 852.0, 513.0)
#: The radius of the sphere of equal volume, and the J2 of the triaxial figure for it, averaged over its fast rotation.
RADIUS = float(np.prod(SEMI_AXES) ** (1.0 / 3.0))
TRIAXIAL = (SEMI_AXES[0] ** 2 + SEMI_AXES[1] ** 2 - 2.0 * SEMI_AXES[2] ** 2) / (10.0 * RADIUS**2)
#: rad/day, from the period of the light curve, 3.915341 h.
SPIN = 2.0 * np.pi * 24.0 / 3.915341
#: A splitting turns free bodies exactly, however fast. By masses in its coordinates it has no exact derivatives, so
#: that the fit takes differences of complete runs, which are short. Half this step changes positions by 6 m.
SPLITTING = fullbody.SymplecticSplitting(step=0.5)
NAMES = ("Haumea", "Namaka", "Hiiaka")


@dataclass(frozen=True)
class Haumea:
    """The fits.

    Attributes
    ----------
    alone : dict
        Of Hi'iaka alone, by the sign of right ascension: from the published orbit and from its image under a half turn
        about the north of the sky, the better of the two.
    points : Fit
        Three points, the sign reversed.
    triaxial, spheroid : Fit
        With the J2 of the triaxial figure, and with a free one.
    """

    alone: dict[int, Fit]
    points: Fit
    triaxial: Fit
    spheroid: Fit


def study() -> Haumea:
    """Fit everything."""
    whole, central = G * sum(_kilograms().values()), G * _kilograms()["haumea"]
    hiiaka, namaka = on_equator(*HIIAKA, whole), on_equator(*NAMAKA, central)
    alone = {}
    for east in (1, -1):
        data = moons.haumea(east)[1]
        starts = [elements(*state, whole) for state in (hiiaka, _half_turned(*hiiaka))]
        fits = [fullbody.fit(points(EPOCH, 0.0045, ("Haumea", "Hiiaka")), start, data, integrator=INTEGRATOR) for start in starts]
        alone[east] = min(fits, key=lambda one: one.chi2)
    data = moons.haumea(-1)
    free = {"haumea": MASSES["haumea"][0]}
    for moon, state, mu in (
        ("namaka", namaka, central),
        ("hiiaka", hiiaka, whole),
    ):
        start = elements(*_half_turned(*state), mu)
        free |= {f"{name}_{moon}": start[name] for name in ORBIT}
    # The published orbits are good for the years up to 2008; those fits give starts for all years.
    early = [_until(one, 2009.0) for one in data]
    for rows in (early, data):
        free = dict(fullbody.fit(_with_masses, free, rows, integrator=INTEGRATOR).values)
    masses = {name: Free(MASSES[name][0], lower=0.01) for name in ("namaka", "hiiaka")}
    found = fullbody.fit(_points, {**free, **masses}, data, integrator=INTEGRATOR)
    best = dict(found.values)
    triaxial = fullbody.fit(_triaxial, best, data, integrator=SPLITTING)
    spheroid = fullbody.fit(_spheroid, {"J2": TRIAXIAL, **triaxial.values}, data, integrator=SPLITTING)
    return Haumea(alone, found, triaxial, spheroid)


def pole(i: float, node: float) -> tuple[float, float]:
    """Return right ascension and declination in degrees of the normal of an orbit on the equator."""
    return (node - 90.0) % 360.0, 90.0 - i


def _kilograms() -> dict[str, float]:
    return {name: mass * (1e21 if name == "haumea" else 1e18) for name, (mass, _) in MASSES.items()}


def _half_turned(r: _Array, v: _Array) -> tuple[_Array, _Array]:
    """Turn an orbit by 180 degrees about the north at Haumea's place in the sky of 2008."""
    ra, dec = np.radians([204.1, 19.2])
    north = np.array([-np.sin(dec) * np.cos(ra), -np.sin(dec) * np.sin(ra), np.cos(dec)])
    turn = 2.0 * np.outer(north, north) - np.eye(3)
    return turn @ r, turn @ v


def _until(data: observing.Astrometry, year: float) -> observing.Astrometry:
    kept = data.times.decimalyear < year
    return observing.Astrometry(
        data.times[kept],
        data.east[kept],
        data.north[kept],
        data.sigma[kept],
        body=data.body,
        about=data.about,
        geometry=data.geometry,
    )


def _points(haumea: float, namaka: float, hiiaka: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
    return nested(NAMES, (haumea * 1e21, namaka * 1e18, hiiaka * 1e18), *_orbits(orbits), EPOCH)


def _with_masses(haumea: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
    """Points with the published masses of the moons."""
    return _points(haumea, MASSES["namaka"][0], MASSES["hiiaka"][0], **orbits)


def _spheroid(
    J2: float, haumea: float, namaka: float, hiiaka: float, **orbits: float
) -> tuple[fullbody.System, fullbody.State]:
    """Haumea as the spheroid that has the time average of the triaxial figure's gravity, its axis that of the ring."""
    (ra, _), (dec, _) = RING
    return nested(
        NAMES,
        (haumea * 1e21, namaka * 1e18, hiiaka * 1e18),
        *_orbits(orbits),
        EPOCH,
        oblate(RADIUS, J2),
        upright(90.0 - dec, ra + 90.0),
        SPIN,
    )


def _triaxial(**parameters: float) -> tuple[fullbody.System, fullbody.State]:
    return _spheroid(TRIAXIAL, **parameters)


def _orbits(orbits: dict[str, float]) -> tuple[list[float], list[float]]:
    inner, outer = ([orbits[f"{name}_{moon}"] for name in ORBIT] for moon in ("namaka", "hiiaka"))
    return inner, outer
