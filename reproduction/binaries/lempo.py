"""Lempo, Hiisi and Paha: three points, the errors with and without their correlation, and the J2 of Lempo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import fullbody
import numpy as np
from astropy.time import Time
from fullbody import observing
from fullbody.fitting import Fit, Free
from scipy.optimize import brentq

from ..judging import Verdict, claimed, compared
from . import moons
from .pair import LOOSE, G
from .shapes import oblate, upright
from .triple import ORBIT, elements, nested, on_equator

__all__ = ["Lempo", "start", "study", "verdicts"]

EPOCH = Time(2453880.0, format="jd", scale="utc")
#: A fit of the same files as three points by an independent program: masses in 1e18 kg and their errors, and chi2.
INDEPENDENT = {"lempo": (5.75, 0.25), "hiisi": (7.71, 0.34), "paha": (0.22, 0.07)}
INDEPENDENT_CHI2 = 47.4
#: Benecchi et al. (2010): the mass of all three in 1e18 kg, and the radius of Lempo in km.
TOTAL_MASS, RADIUS = (12.75, 0.06), 143.0
#: The rise of chi2 at a one-sided limit of 95 per cent.
LIMIT_RISE = 2.71
#: The start of the fit near its minimum, on the ecliptic: period in days, e, and i, node, argument of periapsis and
#: mean anomaly in degrees; masses in 1e18 kg.
INNER = (1.906859, 0.1053, 67.96, 325.39, 82.55, 169.32)
OUTER = (50.50486, 0.29082, 59.344, 324.711, 358.594, 190.444)
START = {"lempo": 5.84, "hiisi": 7.85, "paha": 0.03}
NAMES = ("Lempo", "Hiisi", "Paha")


@dataclass(frozen=True)
class Lempo:
    """The fits of the study.

    Attributes
    ----------
    points : Fit
        Three points.
    uncorrelated : Fit
        Three points with the errors as the collection has them, without their correlation.
    heavy : Fit
        Three points with the mass of Paha of the independent fit.
    spheroid : Fit
        A free J2 of Lempo, which rotates once in each inner orbit about the normal of that orbit.
    limit : float
        The mass of Paha (1e18 kg) at which chi2 is higher than at its minimum by 2.71 times chi2 per degree of freedom:
        an upper limit at 95 per cent with errors scaled so that chi2 per degree of freedom is one.
    """

    points: Fit
    uncorrelated: Fit
    heavy: Fit
    spheroid: Fit
    limit: float


def start() -> dict[str, Any]:
    """Return masses and orbits near the minimum, on the equator."""
    inner, outer = _rotated(INNER, START["lempo"] + START["hiisi"]), _rotated(OUTER, sum(START.values()))
    orbits = {f"{name}_{moon}": orbit[name] for moon, orbit in (("hiisi", inner), ("paha", outer)) for name in ORBIT}
    return {**START, "paha": Free(START["paha"], min=1e-4), **orbits}


def _rotated(orbit: tuple[float, float, float, float, float, float], mass: float) -> dict[str, float]:
    """Return an orbit on the ecliptic about a mass (1e18 kg) by its elements on the equator."""
    period, e, i, node, argument, anomaly = orbit
    mu = G * 1e18 * mass
    a = (mu * (period / (2.0 * np.pi)) ** 2) ** (1.0 / 3.0)
    return elements(*on_equator(a, e, i, node, argument, anomaly, mu), mu)


def study() -> Lempo:
    """Fit everything."""
    data, parameters = moons.lempo(), start()
    result = fullbody.fit(_points, parameters, data, integrator=LOOSE)
    best = {**result.values, "paha": parameters["paha"]}
    without = fullbody.fit(_points, best, moons.lempo(as_collected=True), integrator=LOOSE)
    free = {name: value for name, value in result.values.items() if name != "paha"}
    heavy = fullbody.fit(_heavy, free, data, integrator=LOOSE)
    spheroid = fullbody.fit(_spheroid, {"J2": 0.01, **best}, data, integrator=LOOSE)
    return Lempo(result, without, heavy, spheroid, _limit(result, heavy, data, free))


def _points(lempo: float, hiisi: float, paha: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
    return nested(NAMES, (lempo * 1e18, hiisi * 1e18, paha * 1e18), *_orbits(orbits), EPOCH)


def _heavy(lempo: float, hiisi: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
    return _points(lempo, hiisi, INDEPENDENT["paha"][0], **orbits)


def _limit(result: Fit, heavy: Fit, data: list[observing.Astrometry], free: dict[str, float]) -> float:
    """Return the mass of Paha at which chi2 has risen by 2.71 times chi2 per degree of freedom."""
    rise = LIMIT_RISE * result.chi2 / result.dof
    best = dict(free)

    def excess(mass: float) -> float:
        nonlocal best

        def setup(lempo: float, hiisi: float, **orbits: float) -> tuple[fullbody.System, fullbody.State]:
            return _points(lempo, hiisi, mass, **orbits)

        fit = fullbody.fit(setup, best, data, integrator=LOOSE)
        best = dict(fit.values)
        return fit.chi2 - result.chi2 - rise

    low = high = INDEPENDENT["paha"][0]
    if heavy.chi2 - result.chi2 > rise:
        low = result.values["paha"]
    else:
        # The masses go up to a third of the total; without a change of sign the root finder raises an error.
        for high in (2.0 * low, 4.0 * low, 8.0 * low, 16.0 * low):
            if excess(high) > 0.0:
                break
            low = high
    return float(brentq(excess, low, high, xtol=0.02))


def _spheroid(
    J2: float, lempo: float, hiisi: float, paha: float, **orbits: float
) -> tuple[fullbody.System, fullbody.State]:
    inner, outer = _orbits(orbits)
    rate = 2.0 * np.pi / orbits["period_hiisi"]
    a = (G * 1e18 * (lempo + hiisi) / rate**2) ** (1.0 / 3.0)
    return nested(
        NAMES,
        (lempo * 1e18, hiisi * 1e18, paha * 1e18),
        inner,
        outer,
        EPOCH,
        oblate(RADIUS, J2),
        upright(orbits["i_hiisi"], orbits["node_hiisi"]),
        rate,
        1.0 + 1.5 * J2 * (RADIUS / a) ** 2,
    )


def _orbits(orbits: dict[str, float]) -> tuple[list[float], list[float]]:
    inner, outer = ([orbits[f"{name}_{moon}"] for name in ORBIT] for moon in ("hiisi", "paha"))
    return inner, outer


def verdicts(result: Lempo) -> list[Verdict]:
    """Compare the fits with that by another program and with the paper."""
    fit, rows = result.points, []
    at_zero = (
        f"chi2 is smallest where Paha has no mass; at {INDEPENDENT['paha'][0]}e18 kg it is "
        f"{result.heavy.chi2 - fit.chi2:.2f} larger. "
        f"The data give an upper limit, {result.limit:.2f}e18 kg, and no mass."
    )
    for name, published in INDEPENDENT.items():
        fitted = fit.values[name], fit.sigma[name]
        rows.append(
            compared("Lempo", f"mass of {name.title()} [1e18 kg], by another program", published, fitted, at_zero)
        )
    chi2 = result.uncorrelated.chi2
    rows.append(
        claimed(
            "Lempo",
            "chi2 of three points, by another program",
            f"{INDEPENDENT_CHI2}",
            f"{chi2:.2f}; {fit.chi2:.2f} with the correlation of the errors",
            chi2 <= INDEPENDENT_CHI2,
        )
    )
    total = float(sum(fit.values[name] for name in START))
    indices = [fit.names.index(name) for name in START]
    error = float(np.sqrt(fit.covariance[np.ix_(indices, indices)].sum()))
    why = (
        "This value is from Paha's orbit alone. The inner orbit of the same paper, 867 km in 1.907 days, needs 14.2e18 "
        "kg without Paha: two orbits that do not disturb each other disagree. Here one motion of three bodies fits "
        "both."
    )
    rows.append(
        compared("Lempo", "mass of all three [1e18 kg], Benecchi et al. (2010)", TOTAL_MASS, (total, error), why)
    )
    return rows
