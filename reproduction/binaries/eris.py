"""Eris and Dysnomia: the fit of 19 epochs, what excludes a Keplerian orbit, and a free J2 of Eris."""

from __future__ import annotations

from dataclasses import dataclass

import fullbody
import numpy as np
from astropy.time import Time
from fullbody import observing
from fullbody.fitting import Fit
from scipy.stats import norm

from ..judging import Verdict, claimed, compared
from . import observations
from .pair import INTEGRATOR, LOOSE, UNITS, G, orbiting, points
from .shapes import oblate, upright

__all__ = ["Eris", "excluded", "keplerian", "study", "verdicts"]

#: Holler et al. (2021): km, days, degrees on the equator of J2000.
PUBLISHED = {
    "a": (37273.0, 64.0),
    "period": (15.785899, 0.000050),
    "e": (0.0062, 0.0010),
    "i": (45.49, 0.15),
    "node": (126.17, 0.26),
}
#: The standard deviations at which they exclude a Keplerian orbit.
EXCLUDED = 6.3
#: The values and errors of two-body fits of the same file by independent programs, and their chi2.
INDEPENDENT = {
    "a": (37272.3, 61.0),
    "period": (15.785897, 0.000047),
    "e": (0.00624, 0.00101),
    "i": (45.50, 0.16),
    "node": (126.15, 0.27),
}
INDEPENDENT_CHI2 = 107.54
EPOCH = Time(2453979.0, format="jd", scale="utc")
#: The start of the fit, near the published orbit.
START = {"a": 37270.0, "period": 15.7859, "e": 0.0062, "i": 45.5, "node": 126.2, "periapsis": 310.0, "longitude": 125.8}
#: Dysnomia's part of the mass (Brown & Butler 2023), which the relative orbit does not show.
SHARE = 0.0085
#: Mean radius of Eris in km (Sicardy et al. 2011).
RADIUS = 1163.0


@dataclass(frozen=True)
class Eris:
    """The fits of two points, with e = 0, without light time, and with a free J2 along the normal of the orbit."""

    points: Fit
    circular: Fit
    instant: Fit
    spheroid: Fit


def keplerian(data: observing.Astrometry) -> Fit:
    """Fit two points."""
    return fullbody.fit(points(EPOCH, SHARE), START, data, integrator=INTEGRATOR)


def excluded(fit: Fit) -> float:
    """Return the standard deviations of a normal distribution outside which the p-value of a fit lies."""
    assert fit.p_value is not None
    return float(norm.isf(fit.p_value / 2.0))


def study() -> Eris:
    """Fit everything."""
    data = observations.eris()
    result = keplerian(data)
    best = dict(result.values)
    free = {name: best[name] for name in ("a", "period", "i", "node", "longitude")}
    return Eris(
        result,
        fullbody.fit(_circular, free, data, integrator=INTEGRATOR),
        fullbody.fit(points(EPOCH, SHARE), best, observations.eris(light_time=False), integrator=INTEGRATOR),
        fullbody.fit(_spheroid, {"J2": 0.01, **best}, data, integrator=LOOSE),
    )


def _circular(
    a: float, period: float, i: float, node: float, longitude: float
) -> tuple[fullbody.System, fullbody.State]:
    return points(EPOCH, SHARE)(a, period, 0.0, i, node, node, longitude)


def _spheroid(
    J2: float, a: float, period: float, e: float, i: float, node: float, periapsis: float, longitude: float
) -> tuple[fullbody.System, fullbody.State]:
    """Return Eris as a spheroid that rotates once in each orbit about the normal of the orbit.

    The mass follows from the period of a circular orbit in the equator, n^2 a^3 = G M (1 + 3/2 J2 R^2/a^2).
    """
    mu, r, v = orbiting(a, period, e, i, node, periapsis, longitude)
    mass = mu / G / (1.0 + 1.5 * J2 * (RADIUS / a) ** 2)
    bodies = [
        fullbody.Body(oblate(RADIUS, J2), mass=(1.0 - SHARE) * mass, name="primary"),
        fullbody.Body(fullbody.PointMass(), mass=SHARE * mass, name="secondary"),
    ]
    system = fullbody.System(bodies, G=G, epoch=EPOCH, units=UNITS, frame="equatorial", gravity="focal")
    shares = [-SHARE, 1.0 - SHARE]
    state = fullbody.State(
        position=np.outer(shares, r),
        velocity=np.outer(shares, v),
        attitude=[upright(i, node), [1.0, 0.0, 0.0, 0.0]],
        spin=[[0.0, 0.0, 2.0 * np.pi / period], [0.0, 0.0, 0.0]],
    )
    return system, state


def verdicts(result: Eris) -> list[Verdict]:
    """Compare the fits with the paper and with fits by other programs."""
    fit, units = result.points, {"a": "a [km]", "period": "period [d]", "i": "i [deg]", "node": "node [deg]"}
    fitted = {name: (fit.values[name], fit.sigma[name]) for name in fit.names}
    chi2_agrees = abs(fit.chi2 - INDEPENDENT_CHI2) < 0.01
    return [
        *(compared("Eris", units.get(name, name), PUBLISHED[name], fitted[name]) for name in PUBLISHED),
        *(
            compared("Eris", f"{units.get(name, name)}, by other programs", INDEPENDENT[name], fitted[name])
            for name in INDEPENDENT
        ),
        claimed(
            "Eris",
            "a Keplerian orbit is excluded at [sigma]",
            f"{EXCLUDED}",
            f"{excluded(fit):.2f}: chi2 {fit.chi2:.2f} of {fit.dof}",
            round(excluded(fit), 1) == EXCLUDED,
        ),
        claimed("Eris", "chi2, by other programs", f"{INDEPENDENT_CHI2}", f"{fit.chi2:.2f}", chi2_agrees),
    ]
