"""The fits of the light curves, the comparison with published numbers, and the table of events."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import fullbody
import numpy as np
from astropy.table import QTable
from fullbody import observing
from fullbody.fitting import Fit
from fullbody.fitting.free import Parameters
from fullbody.fitting.losses import LINEAR
from fullbody.fitting.point import InnerSolution, model_of
from fullbody.fitting.problem import Problem

from ..judging import Verdict, claimed, compared
from ..publishing import cpu_seconds
from .freeform import DIAMETER as SIZE
from .freeform import FreeForm
from .interior import Core, Figure, cores, figure_of_fit
from .model import AXES, INTEGRATOR, PERIOD, START, Light, setup

__all__ = ["FORM", "INDEPENDENT_CHI2", "SHAPE", "Results", "events", "scale", "study", "timing", "verdicts"]

#: Starting values in degrees: two opposite sides of the orbit, and four phases over half a rotation, after which an
#: ellipsoid looks the same.
LONGITUDES, PHASES = (176.0, 356.0), (0.0, 45.0, 90.0, 135.0)
#: The limit on proposals from each start.
PROPOSALS = 80
#: Broz et al. (2023): the diameter of Linus in km with its error, the pole in degrees, and the albedos of Linus and of
#: Kalliope; by the abstract Linus is the darker one in most solutions.
DIAMETER, POLE, ALBEDOS = (28.0, 1.0), (195.6, 2.2), (0.40, 0.44)
#: Chi2 of fits of the same magnitudes by another program, which uses this package for the brightness only.
INDEPENDENT_CHI2 = {
    "ellipsoids alone": 357302.0,
    "a series, without events": 18909.0,
    "a series and events, on a circle": 2537.0,
    "a series and events, in exact gravity": 2683.0,
}
#: Ferrais et al. (2022): the density in g/cm3 with its error. Broz et al. (2023): the period of the orbit in days, and
#: C20 with a spherical and with an elongated core of iron.
DENSITY, ORBIT, C20 = (4.36, 0.50), 3.59571, (-0.12, -0.22)
#: The name of the fit of a free form, the form of the study, and that of a draft.
SHAPE, FORM, DRAFT = "a free form and events, in exact gravity", FreeForm(), FreeForm(2, 80)
#: The limits on proposals of the fit of a free form with a quarter of the faces, and with all of them: with 42
#: coefficients chi2 falls by tenths at every further step.
FORM_PROPOSALS = 40, 25
#: The number of draws for the errors of the figure.
FIGURES = 200
#: The number of draws for the errors of contacts, and the least depth in magnitudes that the table shows.
DRAWS, SHALLOW = 24, 1e-3


@dataclass(frozen=True)
class Results:
    """The results of the study.

    Attributes
    ----------
    light : Light
        The light curves.
    fits : dict of Fit
        The fits by the names of :data:`INDEPENDENT_CHI2`, one at the published pole, one with a free albedo of Linus,
        and one of a free form of Kalliope.
    seconds, iterations : float, int
        Processor time and iterations of the fit in exact gravity from the best of the starts, without the others.
    table : QTable
        The events of the fit with a free albedo.
    form : FreeForm
    figure : Figure
        The figure of the fit of a free form.
    cores : list of Core
        Kalliope with and without a core.
    shape_table : QTable
        The events of the fit of a free form.
    """

    light: Light
    fits: dict[str, Fit]
    seconds: float
    iterations: int
    table: QTable
    form: FreeForm
    figure: Figure
    cores: list[Core]
    shape_table: QTable


def _fit(
    start: Mapping[str, Any],
    data: Any,
    starts: Sequence[Mapping[str, Any]],
    gravity: str = "focal",
    *,
    proposals: int,
) -> Fit:
    with_gravity = functools.partial(setup, gravity=gravity)
    return fullbody.fit(with_gravity, start, data, integrator=INTEGRATOR, starts=starts, proposals=proposals)


def study(
    light: Light, starts: bool = True, draws: int = DRAWS, proposals: int = PROPOSALS, form: FreeForm = FORM
) -> Results:
    """Fit the models, each from the starting values and not from another fit.

    Parameters
    ----------
    light : Light
    starts : bool
        Whether to start from all points of the grid, or from its best point only.
    draws, proposals : int
        Numbers of draws for the errors of contacts, and the limit on proposals from each start.
    form : FreeForm
    """
    fit_free = functools.partial(_fit, proposals=proposals)
    at_pole = functools.partial(_at_pole, proposals=proposals)
    grid = [START | {"longitude": x, "phase": y} for x in LONGITUDES for y in PHASES]
    data = light.data()
    best = min(grid, key=lambda start: _chi2(start, data))
    starting_values = grid if starts else [best]
    fits = {
        "ellipsoids alone": at_pole(best, light.data(order=0), ("radius", "longitude", "phase")),
        "a series, without events": at_pole(best, light.data(mutual=False), ("phase",)),
        "a series and events, on a circle": fit_free(best, data, [best], "point"),
        "a series and events, in exact gravity": fit_free(best, data, starting_values),
    }
    fits["at the published pole"] = at_pole(best, data, ("radius", "longitude", "phase"))
    started = time.process_time()
    single = fit_free(best, data, [best])
    seconds = time.process_time() - started
    values = fits["a series and events, in exact gravity"].minima[0].values
    start = {**values, "albedo": 1.0}
    with_albedo = fit_free(start, lambda albedo: light.data(albedo=albedo), [start])
    fits["with Linus' albedo"] = with_albedo
    fits[SHAPE] = shape = _fit_form(light, form, best, proposals)
    return Results(
        light,
        fits,
        seconds,
        single.iterations,
        events(light, with_albedo, draws, setup),
        form,
        figure_of_fit(form, shape, scale(shape), FIGURES if starts else draws),
        cores(form, light, shape),
        events(light, shape, draws, form.setup),
    )


def _fit_form(light: Light, form: FreeForm, start: Mapping[str, Any], proposals: int) -> Fit:
    """Fit a free form, from that nearest to the ellipsoid: first with a quarter of the faces, then with all of them."""
    size, coefficients = form.nearest(AXES)
    values = {**start, "period": PERIOD, "size": size, "coefficients": coefficients, "albedo": 1.0}
    for stage, limit in zip((replace(form, faces=form.faces // 4), form), FORM_PROPOSALS, strict=True):
        fit = fullbody.fit(
            stage.setup,
            stage.parameters(values),
            lambda albedo: light.data(order=0, albedo=albedo),
            integrator=INTEGRATOR,
            proposals=min(limit, proposals),
        )
        values = {name: fit.values[name] for name in values}
    return fit


def _chi2(start: Mapping[str, Any], data: observing.Photometry) -> float:
    problem = Problem(setup, Parameters(start), data, INTEGRATOR)
    return float(np.sum(problem.point(problem.parameters.start).rows ** 2))


def _at_pole(start: Mapping[str, Any], data: observing.Photometry, free: Sequence[str], *, proposals: int) -> Fit:
    """Fit the parameters ``free`` and fix the others, among them the published pole."""
    fixed: dict[str, Any] = {name: value for name, value in start.items() if name not in free}

    def setup_of_free(**parameters: Any) -> tuple[fullbody.System, fullbody.State]:
        return setup(**fixed, **parameters)

    return fullbody.fit(
        setup_of_free, {name: start[name] for name in free}, data, integrator=INTEGRATOR, proposals=proposals
    )


def scale(fit: Fit) -> float:
    """Return the factor by which errors grow if chi2 is to be that of its degrees of freedom."""
    return float(np.sqrt(max(1.0, fit.chi2 / fit.dof)))


def events(light: Light, fit: Fit, draws: int, setup: Callable[..., Any]) -> QTable:
    """Return the table of the mutual events within the light curves that change the light.

    Errors of contacts are standard deviations over draws of the fit, times the factor of :func:`scale`.
    """
    albedo = {"Kalliope": 1.0, "Linus": fit.values["albedo"]}
    options: dict[str, Any] = {"sun_radius": light.sun_radius, "law": observing.LommelSeeliger(), "albedo": albedo}
    fitted = observing.mutual_events(fit.run, light.geometry, **options)
    deep = [event.depth is not None and event.depth > SHALLOW for event in fitted]
    table = fitted.to_table()[deep]
    ends: dict[Any, list[list[float]]] = {}
    for row in fit.draws_as_array(draws, rng=1):
        system, state = setup(**{k: value for k, value in fit.parameters.named(row).items() if k != "albedo"})
        run = _run_over_data(system, state, fit)
        for event in observing.mutual_events(run, light.geometry, sun_radius=light.sun_radius):
            contacts = [np.nan if end is None else end.to_value("s") for end in (event.begin, event.end)]
            ends.setdefault((event.kind, event.body), []).append(contacts)
    for k, name in enumerate(("begin", "end")):
        table[f"{name}_error"] = [
            _spread(ends.get((row["kind"], row["body"]), []), event, k) * scale(fit)
            for row, event in zip(table, np.array(fitted, dtype=object)[deep], strict=True)
        ]
        table[f"{name}_error"].unit = "s"
    return table


def _run_over_data(system: fullbody.System, state: fullbody.State, fit: Fit) -> fullbody.Run:
    """Return a run with a continuous solution over all observations of a fit."""
    times = fit.times[0].to_value("day")
    simulation = fullbody.Simulation(system, state, integrator=INTEGRATOR)
    simulation.integrate(times.min())
    return simulation.integrate(times.max(), dense=True)


def _spread(ends: list[list[float]], event: observing.MutualEvent, k: int) -> float:
    """Return the standard deviation in s, over draws, of the contacts within an hour of an event's contact ``k``."""
    time = (event.begin, event.end)[k]
    if time is None:
        return np.nan
    differences = np.array([pair[k] for pair in ends]) - time.to_value("s")
    near = differences[np.abs(differences) < 3600.0]
    return float(np.std(near, ddof=1)) if len(near) > 1 else np.nan


def verdicts(results: Results) -> list[Verdict]:
    """Compare the results with the paper and with the fits by another program."""
    rows = []
    for name, chi2 in INDEPENDENT_CHI2.items() if results.light.is_complete else ():
        fit = results.fits[name]
        agrees = abs(fit.chi2 / chi2 - 1.0) < 0.01
        why = "" if agrees else "a lower minimum" if fit.chi2 < chi2 else "a higher minimum"
        texts = f"{chi2:.0f}, another program", f"{fit.chi2:.0f} of {fit.dof}"
        rows.append(claimed("chi2", name, *texts, agrees, why))
    for name, fit in results.fits.items():
        if "pole_longitude" not in fit.names:
            continue
        factor = scale(fit)
        value, error = 2.0 * fit.values["radius"], 2.0 * factor * fit.sigma["radius"]
        why = "the published errors are of other data too" if name == SHAPE else "Kalliope is no ellipsoid"
        rows.append(compared(name, "diameter of Linus [km]", DIAMETER, (value, error), why))
        for angle, published in zip(("longitude", "latitude"), POLE, strict=True):
            fitted = fit.values[f"pole_{angle}"], factor * fit.sigma[f"pole_{angle}"]
            why = (
                "no error is published"
                if name == SHAPE
                else "the shadows are those of an ellipsoid; no error is published"
            )
            rows.append(compared(name, f"{angle} of the pole [deg]", (published, 0.0), fitted, why))
        if "albedo" in fit.names:
            ratio = ALBEDOS[0] / ALBEDOS[1]
            fitted = fit.values["albedo"], factor * fit.sigma["albedo"]
            why = "no error is published"
            rows.append(compared(name, "albedo of Linus over Kalliope's", (ratio, 0.0), fitted, why))
    fixed, free = (results.fits[name] for name in ("at the published pole", "a series and events, in exact gravity"))
    rise = (fixed.chi2 - free.chi2) / scale(free) ** 2
    rows.append(
        claimed(
            "exact gravity",
            "rise of chi2 to the published pole, by chi2 over dof",
            "less than 6.2: within 95 % in two angles",
            f"{rise:.1f}",
            rise < 6.2,
            ""
            if rise < 6.2
            else "at a given latitude the shadows of an ellipsoid determine the longitude to hundredths of a degree",
        )
    )
    return rows + _figure_verdicts(results)


def _figure_verdicts(results: Results) -> list[Verdict]:
    """Compare the figure of the free form and the interior with the papers."""
    figure, fit = results.figure, results.fits[SHAPE]
    rows = []
    for name, quantity, published in (
        ("diameter", "diameter of Kalliope [km]", SIZE),
        ("density", "density [g/cm3]", DENSITY),
    ):
        fitted = figure.values[name], figure.errors[name]
        rows.append(
            compared(SHAPE, quantity, published, fitted, "the size is in units of the separation, 1063 +- 23 km")
        )
    fitted = fit.values["period"], scale(fit) * fit.sigma["period"]
    rows.append(compared(SHAPE, "period of the orbit at the start [day]", (ORBIT, 0.0), fitted, "an osculating period"))
    error, prior = figure.errors["C20"], figure.by_prior["C20"]
    for core, coefficient in zip(results.cores, C20[::-1], strict=False):
        row = compared("figure", f"C20, {core.name}", (coefficient, 0.0), (core.c20, error))
        if error >= 0.5 * prior:
            row = replace(row, verdict="open", why=f"the prior alone gives +- {prior:.2f}")
        rows.append(row)
    rise = results.cores[-1].chi2 - results.cores[0].chi2
    rows.append(
        claimed(
            "interior",
            "rise of chi2 with a core of iron, by chi2 over dof",
            "a homogeneous body is excluded",
            f"{rise / scale(fit) ** 2:+.2f}",
            None,
            "the published result is that of astrometry of 20 years, not of the light of three nights",
        )
    )
    return rows


def timing(light: Light, start: Mapping[str, Any]) -> dict[str, float]:
    """Return the processor seconds of the parts of one iteration of the fit in exact gravity."""
    data = light.data()
    problem = Problem(setup, Parameters(start), data, INTEGRATOR)
    values = problem.parameters.start
    problem.jacobian(problem.point(values))
    point = problem.point(values, differentiated=True)

    def seconds(function: Callable[[], Any]) -> float:
        return cpu_seconds(function, 3)

    run, names = point.run, list(point.run.parameters)
    times = np.unique(data.emission(point.setup_result.system).value)

    def motion(ends: bool) -> None:
        # The start is at time zero, between the data.
        for part in (times[times < 0.0][::-1], times[times >= 0.0]):
            if len(part):
                output = "ends" if ends else part
                options: dict[str, Any] = {"integrator": INTEGRATOR, "derivatives": names or True}
                point.setup_result.system.integrate(point.setup_result.state, part[-1], output=output, **options)

    iteration = seconds(lambda: problem.jacobian(problem.point(values, differentiated=True)))
    parts = {
        "motion with derivatives": seconds(lambda: motion(False)),
        "of which without samples at the data": seconds(lambda: motion(True)),
        "light, design and states": seconds(lambda: model_of(data, run)),
        "linear unknowns": seconds(lambda: InnerSolution(point.models, LINEAR)),
        "derivatives of light and design": seconds(lambda: data.linear_derivatives(run, point.inner.held[0])),
        "the setup, twice for each parameter": 2 * len(values) * seconds(lambda: problem.make(values)),
    }
    return {**parts, "all of an iteration": iteration}
