"""The scans of the period, the fits of pole and shape, and the comparison with published numbers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import astropy.units as u
import fullbody
import numpy as np
from fullbody.fitting import Fit, PeriodScan
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem

from ..binaries.judging import Verdict, stated
from .model import DEGREE, Curves, parameters, setup, shape

__all__ = ["Figure", "Results", "figure_of", "pole_apart", "study", "timing", "verdicts"]

#: The range of periods of the first scan, of one apparition, in hours; a draft begins nearer.
RANGE, NEAR = (2.2, 24.0), (8.0, 8.8)
#: Torppa et al. (2003), Icarus 164, 346, as Wikipedia's article on 135 Hertha gives them: the period in hours, the two
#: poles that they could not tell apart, longitude and latitude in degrees, and the ratios of axes; and the solution in
#: the database DAMIT, as the file of the light curves came with it.
TORPPA = {"period": 8.40061, "poles": ((274.0, 53.0), (96.0, 58.0)), "a/b": 1.1, "b/c": 1.5}
DAMIT = {"period": 8.40060, "pole": (272.0, 52.0)}
#: Dotto et al. (1992), Astron. Astrophys. Suppl. Ser. 95, 195, as the same article gives them.
DOTTO = {"period": (8.398, 0.001), "a/b": (1.34, 0.03), "b/c": (1.22, 0.05)}
#: The angle in degrees within which two poles agree: the error that is usual for inversions of light curves.
USUAL = 5.0
#: Names of the fits.
BEST, SECOND, COARSE, FINE = "best minimum", "second minimum", "degree 4", "degree 8"


@dataclass(frozen=True)
class Figure:
    """The shape of a fit.

    Attributes
    ----------
    ratios : (float, float)
        The ratios a/b and b/c of the homogeneous ellipsoid with the same moments of inertia.
    tilt : float
        The angle in degrees between the spin and the axis of largest inertia.
    dark : float
        The length of the closure: the area of the dark facet that would close the surface, relative to the surface.
    """

    ratios: tuple[float, float]
    tilt: float
    dark: float


@dataclass(frozen=True)
class Results:
    """The results of the study.

    Attributes
    ----------
    curves : Curves
    coarse, scan : PeriodScan
        The scans of one apparition over all periods, and of all nights near the best of these.
    fits : dict of Fit
        The fits from the lowest and the second minimum of the scan, and from the best with other degrees. The lowest
        minimum of each fit and that at the mirror pole are in its ``minima``.
    figure : Figure
        The shape of the best fit.
    seconds : dict of float
        Processor time of each scan and fit.
    """

    curves: Curves
    coarse: PeriodScan
    scan: PeriodScan
    fits: dict[str, Fit]
    figure: Figure
    seconds: dict[str, float]

    @property
    def best(self) -> Fit:
        """The fit with the lowest chi2 of the degree of the study."""
        return min((self.fits[name] for name in (BEST, SECOND) if name in self.fits), key=lambda fit: fit.chi2)


def study(draft: bool = False, progress: Any = False) -> Results:
    """Scan the periods of one apparition, then those of all nights near the best, and fit from the lowest minima.

    A draft takes every third magnitude, a short range, and a shape of degree 3.
    """
    curves = Curves(3 if draft else 1)
    seconds: dict[str, float] = {}

    def timed(name: str, work: Callable[[], Any]) -> Any:
        started = time.process_time()
        found = work()
        seconds[name] = time.process_time() - started
        return found

    options = {"poles": 6, "progress": progress and "periods"}
    alone = curves.apparition()
    span = float(np.ptp(alone.times.jd)) * 24.0
    first = (NEAR if draft else RANGE) * u.h
    coarse = timed("scan of one apparition", lambda: fullbody.fitting.period_scan(alone, first, **options))
    middle = coarse.minima[0].period.to_value("h")
    width = (0.02 if draft else 0.5) * middle**2 / span
    near = [middle - width, middle + width] * u.h
    scan = timed("scan of all nights", lambda: fullbody.fitting.period_scan(curves.nights, near, **options))
    fits = {}
    degree = 3 if draft else DEGREE
    for name, minimum, order in (
        (BEST, 0, degree),
        (SECOND, 1, degree),
        *(() if draft else ((COARSE, 0, 4), (FINE, 0, 8))),
    ):
        found = scan.minima[minimum]
        start = parameters(found.period, found.longitude, found.latitude, order)
        fits[name] = timed(f"fit, {name}", lambda start=start: fullbody.fit(setup, start, curves.observations))
    return Results(curves, coarse, scan, fits, figure_of(fits[BEST]), seconds)


def figure_of(fit: Fit) -> Figure:
    """Return the shape of a fit."""
    convex = shape(fit.values["coefficients"])
    body = fullbody.Body(convex.polyhedron(), mass="1e18 kg", name="Hertha")
    ellipsoid = body.fitted_ellipsoid()
    axes = np.array([semi_axis.to_value("km") for semi_axis in (ellipsoid.a, ellipsoid.b, ellipsoid.c)])
    frame = body.working_frame
    turn = np.eye(3) if frame is None else fullbody.base.rotations.matrices(frame.attitude)
    shortest = int(np.argmin(axes))
    a, b, c = sorted(axes, reverse=True)
    tilt = np.degrees(np.arccos(min(1.0, abs(turn[shortest, 2]))))
    return Figure((a / b, b / c), float(tilt), float(np.linalg.norm(convex.closure)))


def pole_apart(first: tuple[float, float], other: tuple[float, float]) -> float:
    """Return the angle in degrees between two directions, longitudes and latitudes in degrees."""
    vectors = [fullbody.frames.pole_vector(*np.radians(pole)) for pole in (first, other)]
    return float(np.degrees(np.arccos(np.clip(vectors[0] @ vectors[1], -1.0, 1.0))))


def pole_of(values: Any) -> tuple[float, float]:
    """Return longitude and latitude in degrees, from 0 to 360 and -90 to 90."""
    vector = fullbody.frames.pole_vector(values["longitude"], values["latitude"])
    longitude, latitude = fullbody.frames.pole_angles(vector)
    return float(np.degrees(longitude)), float(np.degrees(latitude))


def scale(fit: Fit) -> float:
    """Return the factor of the errors by which chi2 equals the degrees of freedom."""
    return float(np.sqrt(fit.chi2 / fit.dof))


def verdicts(results: Results) -> list[Verdict]:
    """Compare the best fit with published numbers."""
    fit, rows = results.best, []
    period = fit.values["period"].to_value("h"), scale(fit) * fit.sigma["period"].to_value("h")
    # A published period without an error has that of its last digit.
    for name, published, error in (
        ("Torppa et al. 2003", TORPPA["period"], 5e-6),
        ("DAMIT", DAMIT["period"], 5e-6),
        ("Dotto et al. 1992", *DOTTO["period"]),
    ):
        apart = (period[0] - published) / np.hypot(error, period[1])
        holds = abs(apart) <= 2.0
        why = "" if holds else "a single apparition counts synodic rotations and leaves aliases"
        row = (f"{published:.7g} +- {error:g}", stated(*period), float(apart), "holds" if holds else "differs", why)
        rows.append(Verdict(name, "sidereal period [h]", *row))
    poles = {"best": pole_of(fit.minima[0].values)} | {
        "mirror": pole_of(minimum.values) for minimum in reversed(fit.minima[1:])
    }
    for name, which, published in (
        ("Torppa et al. 2003", "best", TORPPA["poles"][0]),
        ("Torppa et al. 2003", "mirror", TORPPA["poles"][1]),
        ("DAMIT", "best", DAMIT["pole"]),
    ):
        if which not in poles:
            continue
        apart = pole_apart(poles[which], published)
        text = [f"{longitude:.1f}, {latitude:.1f}" for longitude, latitude in (published, poles[which])]
        word = "holds" if apart <= USUAL else "differs"
        rows.append(Verdict(name, f"pole, {which} [deg]", *text, None, word, f"{apart:.1f} degrees apart"))
    ours = dict(zip(("a/b", "b/c"), results.figure.ratios, strict=True))
    for name, value in ours.items():
        published, error = DOTTO[name]
        near = f"{value:.2f}"
        word = "holds" if abs(value - TORPPA[name]) <= 0.1 else "differs"
        why = "the ellipsoid here has the moments of inertia of the shape; that of the publication is another"
        rows.append(
            Verdict("Torppa et al. 2003", name, f"{TORPPA[name]}", near, None, word, "" if word == "holds" else why)
        )
        word = "holds" if abs(value - published) <= 2.0 * error else "differs"
        why = (
            "" if word == "holds" else "theirs is an ellipsoid through the amplitudes of one method and few apparitions"
        )
        rows.append(Verdict("Dotto et al. 1992", name, f"{published} +- {error}", near, None, word, why))
    if len(fit.minima) > 1:
        rise = (fit.minima[1].chi2 - fit.minima[0].chi2) / scale(fit) ** 2
        told = rise > 9.0
        rows.append(
            Verdict(
                "Torppa et al. 2003",
                "rise of chi2 to the mirror pole, by chi2 over dof",
                "the two poles cannot be told apart",
                f"{rise:.1f}",
                None,
                "differs" if told else "holds",
                "the errors of the model are not independent, so that this is less than its number of sigma"
                if told
                else "",
            )
        )
    return rows


def timing(results: Results) -> dict[str, float]:
    """Return the processor seconds of the parts of one iteration of the best fit."""
    fit = results.best
    start = parameters(*(fit.values[name] for name in ("period", "longitude", "latitude")))
    start["coefficients"] = fit.values["coefficients"]
    problem = Problem(setup, Parameters(start), results.curves.observations, None)
    values = problem.parameters.start
    problem.jacobian(problem.point(values))

    def seconds(work: Callable[[], Any], n: int = 3) -> float:
        started = time.process_time()
        for _ in range(n):
            work()
        return (time.process_time() - started) / n

    return {
        "a setup": seconds(lambda: problem.make(values), 10),
        "motion and light": seconds(lambda: problem.point(values)),
        "all of an iteration": seconds(lambda: problem.jacobian(problem.point(values, differentiated=True))),
    }
