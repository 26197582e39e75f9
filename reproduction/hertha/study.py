"""The scans of the period of (135) Hertha, the fits of pole and shape, and the comparison with published numbers."""

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

from ..judging import Verdict, claimed, compared
from ..publishing import cpu_seconds
from . import chords
from .chords import Size
from .model import DEGREE, POWER, Curves, parameters, setup, shape

__all__ = ["FittedShape", "Results", "angle_between", "fitted_shape", "sizes_of", "study", "timing", "verdicts"]

#: The range of periods of the first scan, of one apparition, in hours, and that of a draft.
RANGE, DRAFT_RANGE = np.array([2.2, 24.0]), np.array([8.0, 8.8])
#: Torppa et al. (2003), Icarus 164, 346, as Wikipedia's article on 135 Hertha gives them: the period in hours, the two
#: poles between which they could not decide, longitude and latitude in degrees, and the ratios of axes.
TORPPA_PERIOD, TORPPA_POLES, TORPPA_RATIOS = 8.40061, ((274.0, 53.0), (96.0, 58.0)), {"a/b": 1.1, "b/c": 1.5}
#: The period and the pole in the database DAMIT, as they came with the file of the light curves.
DAMIT_PERIOD, DAMIT_POLE = 8.40060, (272.0, 52.0)
#: Dotto et al. (1992), Astron. Astrophys. Suppl. Ser. 95, 195, as the same article gives them: the period and the
#: ratios of axes with their errors.
DOTTO_PERIOD, DOTTO_RATIOS = (8.398, 0.001), {"a/b": (1.34, 0.03), "b/c": (1.22, 0.05)}
#: The angle in degrees within which two poles agree: the error that is usual for inversions of light curves.
POLE_ERROR = 5.0
#: Names of the fits.
BEST, SECOND, SMOOTH = "best minimum", "second minimum", "best minimum, smoother prior"
#: Names of the minima of the best fit.
POLES = ("best pole", "mirror pole")
#: The rise of chi2 from the better to the other pole, over the reduced chi2 of the better one, above which data decide
#: between them: three standard errors.
RISE = 9.0


@dataclass(frozen=True)
class FittedShape:
    """The axes and the closure of the shape of a fit.

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
        The observations.
    coarse, scan : PeriodScan
        The scans of one apparition over all periods, and of all nights near the best of these.
    fits : dict of Fit
        The fits from the lowest and the second minimum of the scan, and from the lowest with a prior that falls faster
        with the degree. The lowest minimum of each fit and that at the mirror pole are in its ``minima``.
    shape : FittedShape
        The axes and the closure of the shape of the best fit.
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
    shape: FittedShape
    sizes: dict[str, Size]
    seconds: dict[str, float]

    @property
    def best(self) -> Fit:
        """The fit with the lowest chi2 of those with the same prior."""
        return lowest(self.fits)


def study(draft: bool = False, progress: Any = False) -> Results:
    """Scan the periods of one apparition, then those of all nights near the best, and fit from the lowest minima.

    A draft takes every third magnitude, a short range, and a shape of degree 3.
    """
    curves = Curves(3 if draft else 1)
    seconds: dict[str, float] = {}

    def timed(name: str, function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        started = time.process_time()
        result = function(*arguments, **options)
        seconds[name] = time.process_time() - started
        return result

    scan_of = functools.partial(fullbody.fitting.period_scan, progress=progress and "periods")
    apparition = curves.apparition()
    span = float(np.ptp(apparition.times.jd)) * 24.0
    periods = (DRAFT_RANGE if draft else RANGE) * u.h
    coarse = timed("scan of one apparition", scan_of, apparition, periods, poles=4)
    middle = coarse.minima[0].period.to_value("h")
    # A change of the period by middle^2 / span is one rotation over the apparition.
    width = (0.1 if draft else 0.5) * middle**2 / span
    periods = np.array([middle - width, middle + width]) * u.h
    scan = timed("scan of all nights", scan_of, curves.nights, periods, poles=3 if draft else 6)
    degree, limit = (3, 12) if draft else (DEGREE, None)
    starts = [(BEST, 0, POWER)] if draft else [(BEST, 0, POWER), (SECOND, 1, POWER), (SMOOTH, 0, 2 * POWER)]
    fits = {}
    for name, index, power in starts:
        minimum = scan.minima[index]
        start = parameters(minimum.period, minimum.longitude, minimum.latitude, degree, power)
        fits[name] = timed(f"fit, {name}", fullbody.fit, setup, start, curves.observations, proposals=limit)
    best = lowest(fits)
    sizes = timed("sizes from chords", sizes_of, best, draft)
    return Results(curves, coarse, scan, fits, fitted_shape(best), sizes, seconds)


def lowest(fits: dict[str, Fit]) -> Fit:
    """Return the fit with the lowest chi2 of those with the same prior."""
    return min((fits[name] for name in (BEST, SECOND) if name in fits), key=lambda fit: fit.chi2)


def sizes_of(fit: Fit, draft: bool = False) -> dict[str, Size]:
    """Return the sizes from the chords: of the shape of each minimum of a fit, and of ellipsoids.

    A draft has few steps, and no free rotation angles.
    """
    sizes = {}
    for name, minimum in zip(POLES, fit.minima, strict=False):
        sizes[f"shape from light, {name}"] = chords.size_of_light_shape(minimum.values, proposals=2 if draft else None)
        if not draft:
            free = chords.size_of_light_shape(minimum.values, free_angle=True)
            sizes[f"shape from light, {name}, rotation angle free"] = free
    return sizes | chords.sizes_of_ellipsoids()


def fitted_shape(fit: Fit) -> FittedShape:
    """Return the axes and the closure of the shape of a fit."""
    convex = shape(fit.values["coefficients"])
    body = fullbody.Body(convex.polyhedron(), mass="1e18 kg", name="Hertha")
    ellipsoid = body.fitted_ellipsoid()
    axes = np.array([semi_axis.to_value("km") for semi_axis in (ellipsoid.a, ellipsoid.b, ellipsoid.c)])
    frame = body.working_frame
    rotation = np.eye(3) if frame is None else fullbody.base.rotations.matrices(frame.attitude)
    shortest = int(np.argmin(axes))
    a, b, c = sorted(axes, reverse=True)
    tilt = np.degrees(np.arccos(min(1.0, abs(rotation[shortest, 2]))))
    return FittedShape((a / b, b / c), float(tilt), float(np.linalg.norm(convex.closure)))


def angle_between(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Return the angle in degrees between two directions, longitudes and latitudes in degrees."""
    vectors = [fullbody.frames.pole_vector(*np.radians(pole)) for pole in (first, second)]
    return float(np.degrees(np.arccos(np.clip(vectors[0] @ vectors[1], -1.0, 1.0))))


def pole_of(values: Any) -> tuple[float, float]:
    """Return longitude and latitude of the pole in degrees, from 0 to 360 and -90 to 90."""
    vector = fullbody.frames.pole_vector(values["longitude"], values["latitude"])
    longitude, latitude = fullbody.frames.pole_angles(vector)
    return float(np.degrees(longitude)), float(np.degrees(latitude))


def error_scale(fit: Fit) -> float:
    """Return the factor by which the errors have to grow for chi2 to equal the degrees of freedom."""
    return float(np.sqrt(fit.chi2 / fit.dof))


def verdicts(results: Results) -> list[Verdict]:
    """Compare the best fit with published numbers."""
    fit, rows = results.best, []
    period = fit.values["period"].to_value("h"), error_scale(fit) * fit.sigma["period"].to_value("h")
    # A published period without an error has that of its last digit.
    published_periods = {
        "Torppa et al. 2003": (TORPPA_PERIOD, 5e-6),
        "DAMIT": (DAMIT_PERIOD, 5e-6),
        "Dotto et al. 1992": DOTTO_PERIOD,
    }
    for name, published_period in published_periods.items():
        why = "theirs is a period of one apparition, synodic within its error"
        rows.append(compared(name, "sidereal period [h]", published_period, period, why))
    poles = {name: pole_of(minimum.values) for name, minimum in zip(POLES, fit.minima, strict=False)}
    for name, key, published in (
        ("Torppa et al. 2003", POLES[0], TORPPA_POLES[0]),
        ("Torppa et al. 2003", POLES[1], TORPPA_POLES[1]),
        ("DAMIT", POLES[0], DAMIT_POLE),
    ):
        if key in poles:
            angle = angle_between(poles[key], published)
            text, fitted_text = ("{:.1f}, {:.1f}".format(*pole) for pole in (published, poles[key]))
            quantity = f"pole, {key.removesuffix(' pole')} [deg]"
            why = f"{angle:.1f} degrees apart"
            rows.append(claimed(name, quantity, text, fitted_text, angle <= POLE_ERROR, why))
    # Ratios without errors are given to a tenth.
    for quantity, value in zip(("a/b", "b/c"), results.shape.ratios, strict=True):
        torppa, (dotto, error) = TORPPA_RATIOS[quantity], DOTTO_RATIOS[quantity]
        for name, text, within in (
            ("Torppa et al. 2003", f"{torppa}", abs(value - torppa) <= 0.1),
            ("Dotto et al. 1992", f"{dotto} +- {error}", abs(value - dotto) <= 2.0 * error),
        ):
            why = "" if within else "the ellipsoid here is that with the moments of inertia of the shape"
            rows.append(claimed(name, quantity, text, f"{value:.2f}", within, why))
    if len(fit.minima) > 1:
        rise = (fit.minima[1].chi2 - fit.minima[0].chi2) / error_scale(fit) ** 2
        statement = "rise of chi2 to the mirror pole, by chi2 over dof", "the two poles cannot be told apart"
        why = (
            ""
            if rise <= RISE
            else "residuals are not independent, so that the rise counts for less than its root in sigma"
        )
        rows.append(claimed("Torppa et al. 2003", *statement, f"{rise:.1f}", rise <= RISE, why))
    return rows + size_verdicts(results.sizes, poles)


def size_verdicts(sizes: dict[str, Size], poles: dict[str, tuple[float, float]]) -> list[Verdict]:
    """Compare the diameters of the shape from light with published ones, and the pole that the chords prefer."""
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
        near, far = (angle_between(poles[pole], DAMIT_POLE) for pole in (preferred, other))
        why = "the chords do not decide between the poles" if rise <= RISE else f"it is the {preferred} of the light"
        published_pole, fitted_pole = texts
        fitted_text = f"{fitted_pole}; {rise:.1f}"
        rows.append(claimed("DAMIT", quantity, published_pole, fitted_text, None if rise <= RISE else near < far, why))
    return rows


def timing(results: Results) -> dict[str, float]:
    """Return the processor seconds of the parts of one iteration of the best fit."""
    fit = results.best
    start = parameters(*(fit.values[name] for name in ("period", "longitude", "latitude")))
    start["coefficients"] = fit.values["coefficients"]
    problem = Problem(setup, Parameters(start), results.curves.observations, None)
    values = problem.parameters.start
    problem.jacobian(problem.point(values))
    return {
        "a setup": cpu_seconds(lambda: problem.make(values), 10),
        "motion and light": cpu_seconds(lambda: problem.point(values), 3),
        "all of an iteration": cpu_seconds(lambda: problem.jacobian(problem.point(values, differentiated=True)), 3),
    }
