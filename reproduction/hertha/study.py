"""The scans of the period, the fits of pole and shape, and the comparison with published numbers."""

from __future__ import annotations

import functools
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

from ..binaries.judging import Verdict, Word, compared
from . import chords
from .chords import Size
from .model import DEGREE, Curves, parameters, setup, shape

__all__ = ["Figure", "Results", "figure_of", "pole_apart", "sizes_of", "study", "timing", "verdicts"]

#: The range of periods of the first scan, of one apparition, in hours; a draft begins nearer.
RANGE, NEAR = np.array([2.2, 24.0]), np.array([8.0, 8.8])
#: Torppa et al. (2003), Icarus 164, 346, as Wikipedia's article on 135 Hertha gives them: the period in hours, the two
#: poles that they could not tell apart, longitude and latitude in degrees, and the ratios of axes.
TORPPA, TORPPA_POLES, TORPPA_RATIOS = 8.40061, ((274.0, 53.0), (96.0, 58.0)), {"a/b": 1.1, "b/c": 1.5}
#: The period and the pole in the database DAMIT, as they came with the file of the light curves.
DAMIT, DAMIT_POLE = 8.40060, (272.0, 52.0)
#: Dotto et al. (1992), Astron. Astrophys. Suppl. Ser. 95, 195, as the same article gives them: the period and the
#: ratios of axes with their errors.
DOTTO, DOTTO_RATIOS = (8.398, 0.001), {"a/b": (1.34, 0.03), "b/c": (1.22, 0.05)}
#: The angle in degrees within which two poles agree: the error that is usual for inversions of light curves.
USUAL = 5.0
#: Names of the fits.
BEST, SECOND, SMOOTH = "best minimum", "second minimum", "best minimum, smoother prior"
#: Names of the minima of the best fit.
POLES = ("best pole", "mirror pole")
#: The rise of chi2, over the reduced chi2 of the lower one, from which on chords tell two poles apart.
RISE = 9.0


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
        The fits from the lowest and the second minimum of the scan, and from the lowest with a
        prior that falls faster with the degree. The lowest
        minimum of each fit and that at the mirror pole are in its ``minima``.
    figure : Figure
        The shape of the best fit.
    sizes : dict of Size
        The sizes from the chords of the occultation: of the shape from light with each pole, without and with a free
        rotation angle, and of ellipsoids.
    seconds : dict of float
        Processor time of each scan and fit.
    """

    curves: Curves
    coarse: PeriodScan
    scan: PeriodScan
    fits: dict[str, Fit]
    figure: Figure
    sizes: dict[str, Size]
    seconds: dict[str, float]

    @property
    def best(self) -> Fit:
        """The fit with the lowest chi2 of the degree of the study."""
        return lowest(self.fits)


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

    shown = progress and "periods"
    alone = curves.apparition()
    span = float(np.ptp(alone.times.jd)) * 24.0

    def scanned(data: Any, ends: Any, poles: int) -> PeriodScan:
        return fullbody.fitting.period_scan(data, ends * u.h, poles=poles, progress=shown)

    coarse = timed("scan of one apparition", lambda: scanned(alone, NEAR if draft else RANGE, 4))
    middle = coarse.minima[0].period.to_value("h")
    width = (0.1 if draft else 0.5) * middle**2 / span
    near = np.array([middle - width, middle + width])
    scan = timed("scan of all nights", lambda: scanned(curves.nights, near, 3 if draft else 6))
    degree, limit = (3, 12) if draft else (DEGREE, None)
    wanted = [(BEST, 0, 1.0)] if draft else [(BEST, 0, 1.0), (SECOND, 1, 1.0), (SMOOTH, 0, 2.0)]
    fits = {}
    for name, minimum, power in wanted:
        found = scan.minima[minimum]
        start = parameters(found.period, found.longitude, found.latitude, degree, power)
        made = functools.partial(fullbody.fit, setup, start, curves.observations, proposals=limit)
        fits[name] = timed(f"fit, {name}", made)
    best = lowest(fits)
    sizes = timed("sizes from chords", lambda: sizes_of(best, draft))
    return Results(curves, coarse, scan, fits, figure_of(best), sizes, seconds)


def lowest(fits: dict[str, Fit]) -> Fit:
    """Return the fit with the lowest chi2 of the degree of the study."""
    return min((fits[name] for name in (BEST, SECOND) if name in fits), key=lambda fit: fit.chi2)


def sizes_of(fit: Fit, draft: bool = False) -> dict[str, Size]:
    """Return the sizes from the chords: of the shape of each minimum of a fit, and of ellipsoids.

    A draft has few steps, and no free rotation angles.
    """
    sizes = {}
    for name, minimum in zip(POLES, fit.minima, strict=False):
        sizes[f"shape from light, {name}"] = chords.of_light(minimum.values, proposals=2 if draft else None)
        if not draft:
            sizes[f"shape from light, {name}, rotation angle free"] = chords.of_light(minimum.values, free_angle=True)
    return sizes | chords.of_ellipsoids()


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
    published_periods = {"Torppa et al. 2003": (TORPPA, 5e-6), "DAMIT": (DAMIT, 5e-6), "Dotto et al. 1992": DOTTO}
    for name, known in published_periods.items():
        why = "theirs is a period of one apparition, synodic within its error"
        rows.append(compared(name, "sidereal period [h]", known, period, why))
    poles = {name: pole_of(minimum.values) for name, minimum in zip(("best", "mirror"), fit.minima, strict=False)}
    for name, which, published in (
        ("Torppa et al. 2003", "best", TORPPA_POLES[0]),
        ("Torppa et al. 2003", "mirror", TORPPA_POLES[1]),
        ("DAMIT", "best", DAMIT_POLE),
    ):
        if which in poles:
            apart = pole_apart(poles[which], published)
            ours, theirs = (f"{longitude:.1f}, {latitude:.1f}" for longitude, latitude in (poles[which], published))
            why = f"{apart:.1f} degrees apart"
            rows.append(Verdict(name, f"pole, {which} [deg]", theirs, ours, None, judged(apart <= USUAL), why))
    for quantity, value in zip(("a/b", "b/c"), results.figure.ratios, strict=True):
        near, (published_ratio, error) = TORPPA_RATIOS[quantity], DOTTO_RATIOS[quantity]
        for name, text, within in (
            ("Torppa et al. 2003", f"{near}", abs(value - near) <= 0.1),
            ("Dotto et al. 1992", f"{published_ratio} +- {error}", abs(value - published_ratio) <= 2.0 * error),
        ):
            why = "" if within else "the ellipsoid here is that with the moments of inertia of the shape"
            rows.append(Verdict(name, quantity, text, f"{value:.2f}", None, judged(within), why))
    if len(fit.minima) > 1:
        rise = (fit.minima[1].chi2 - fit.minima[0].chi2) / scale(fit) ** 2
        statement = "rise of chi2 to the mirror pole, by chi2 over dof", "the two poles cannot be told apart"
        why = (
            ""
            if rise <= 9.0
            else "residuals are not independent, so that the rise counts for less than its root in sigma"
        )
        rows.append(Verdict("Torppa et al. 2003", *statement, f"{rise:.1f}", None, judged(rise <= 9.0), why))
    by_name = dict(zip(POLES, (pole_of(minimum.values) for minimum in fit.minima), strict=False))
    return rows + size_verdicts(results.sizes, by_name)


def size_verdicts(sizes: dict[str, Size], poles: dict[str, tuple[float, float]]) -> list[Verdict]:
    """Compare the diameters of the shape from light with published ones, and by the chords its two poles in degrees."""
    by_pole = {pole: sizes[f"shape from light, {pole}"] for pole in POLES if f"shape from light, {pole}" in sizes}
    rows = []
    for source, published in chords.PUBLISHED.items():
        for pole, size in by_pole.items():
            why = "the shape is that of light alone, and its outline leaves more than the errors of the chords"
            rows.append(compared(source, f"diameter, {pole} [km]", published, (size.diameter, size.sigma), why))
    if len(by_pole) == len(POLES):
        preferred, other = sorted(by_pole, key=lambda pole: by_pole[pole].fit.chi2)
        lower, higher = by_pole[preferred].fit, by_pole[other].fit
        rise = (higher.chi2 - lower.chi2) / max(1.0, lower.chi2 / lower.dof)
        quantity = "pole that the chords prefer [deg], and the rise of chi2 to the other one, by chi2 over dof"
        texts = ("{:.1f}, {:.1f}".format(*pole) for pole in (DAMIT_POLE, poles[preferred]))
        apart = [pole_apart(poles[pole], DAMIT_POLE) for pole in (preferred, other)]
        word: Word = "open" if rise <= RISE else judged(apart[0] < apart[1])
        why = "the chords do not tell the two poles apart" if word == "open" else f"it is the {preferred} of the light"
        published_pole, fitted_pole = texts
        rows.append(Verdict("DAMIT", quantity, published_pole, f"{fitted_pole}; {rise:.1f}", None, word, why))
    return rows


def judged(holds: bool) -> Word:
    """Return the word of a verdict."""
    return "holds" if holds else "differs"


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
