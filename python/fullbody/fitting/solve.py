"""Fits by least squares, from one start or from many."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.arguments import generator
from ..base.kinds import whole_number
from ..base.progress import Progress
from ..base.units import need
from ..errors import InconsistentInput, Interrupted, InvalidInput, caution, once
from ..typing import Floats
from .free import Parameters
from .inputs import Observed
from .losses import Outliers, loss_of
from .poles import mirror_start
from .problem import Problem, Refused
from .result import Fit, Minimum
from .solver import Objective, Solver

if TYPE_CHECKING:
    from ..record.integrators import Integrator


#: The largest difference, in units of each parameter's error, between two fits at the same minimum.
_SAME = 0.1


def fit(
    setup: Callable[..., Any],
    parameters: Mapping[str, Any],
    observations: Observed | Callable[..., Observed] | Sequence[Observed | Callable[..., Observed]],
    *,
    integrator: Integrator | None = None,
    loss: str | Outliers | Callable[[Any], Any] = "linear",
    starts: int | Sequence[Mapping[str, Any]] = 1,
    rng: int | np.random.Generator | None = None,
    proposals: int | None = None,
    progress: bool | str | Callable[..., Any] = False,
) -> Fit:
    """Fit the parameters of a setup to observations by least squares.

    Each iteration integrates the motion once alone and once with its exact derivatives, forward and backward from the
    epoch of the state over all observations, whatever the number of parameters.

    Parameters
    ----------
    setup : callable
        ``setup(**parameters)`` returns ``(system, state)``, as for :func:`fullbody.sweep`.
    parameters : dict
        Names to initial values, numbers or Quantities, or to :class:`fullbody.fitting.Free` with bounds and priors. The
        setup is differentiated by differences over a thousandth of a value, or of a radian for angles with a unit, or
        less; over more where nothing changes.
    observations : Astrometry, Photometry, RadarAstrometry, Measured, or a list of them
        Observations may also be a function of parameters that returns them: ``lambda jitter: data.with_jitter(jitter)``
        frees a jitter, ``lambda albedo: observing.Photometry(..., albedo={"Alpha": 1.0, "Beta": albedo})`` an albedo.
        Their linear unknowns, such as zero points, are no parameters: each evaluation solves for them.
    integrator : Integrator, optional
        :class:`fullbody.Verner98` unless given.
    loss : {"linear", "soft_l1", "huber", "cauchy", "arctan"}, Outliers or callable
        The weight of pulls, as in ``scipy.optimize.least_squares`` with scale one; priors always count linearly. A
        function takes squares (...) and returns the loss with two derivatives (3, ...).
    starts : int or list of dict
        The starts themselves, or their number: the first has the given values, the others are spread by Latin hypercube
        between the bounds of each parameter, or over its prior if it has no bounds.
    rng : int or numpy Generator, optional
        The random numbers of starts, needed if ``starts`` is a number above one.
    proposals : int, optional
        The largest number of proposed values of the parameters, refused ones included, from each start; a hundred for
        each parameter unless given. A fit that stops there has a ``Fit.message`` and shows no errors.
    progress : bool, str or callable
        Whether to show the number of runs and chi2, or a title; or a function of (done, total, description): the number
        of runs, ``None``, and a text with chi2.

    Returns
    -------
    Fit
        The best minimum; ``Fit.minima`` lists all. A fit of :class:`~fullbody.observing.Photometry` of a body alone
        is repeated from the mirror of its pole, at the ecliptic longitude plus 180 degrees, if none of the fits ended
        near that: light curves hardly tell the two apart. Ctrl-C returns the best values so far, with the
        ``Fit.message`` that says so.

    Raises
    ------
    InvalidInput
        For invalid arguments, more parameters than data, a setup that jumps or rounds, and starts that are all refused.
    Interrupted
        On Ctrl-C before there is anything to return.

    Warns
    -----
    InconsistentInput
        If the data leave a combination of parameters unconstrained, and if the solver stops before it is at a minimum.
        Warnings of the setup are shown once.

    Notes
    -----
    The solver is scipy's ``least_squares`` ("trf"), in units of the errors that parameters have at the start. A step to
    values that the setup refuses, or to a collision, is shortened to a quarter and tried again; ``Fit.refused``
    counts these.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> from fullbody import observing
    >>> def setup(mass):
    ...     system, state = fullbody.systems.case1()
    ...     return system.with_body(1, system[1].shape, mass=mass), state
    >>> system, state = setup(2.0)
    >>> times, far = np.linspace(1.0, 20.0, 40), [1e6, 0.0, 0.0]
    >>> view = observing.Geometry([0.0, 30.0], to_observer=far, light_time=False)
    >>> options = {"sigma": 0.01, "body": 1, "about": 0, "geometry": view}
    >>> run = system.integrate(state, 20.0, dense=True)
    >>> ranges = observing.RadarAstrometry(times, range=0 * times, **options).predict(run).range
    >>> data = observing.RadarAstrometry(times, range=ranges, **options)
    >>> found = fullbody.fit(setup, {"mass": 2.01}, data)
    >>> round(found.values["mass"], 6), found.dof
    (2.0, 39)
    """
    with once():
        limit = None if proposals is None else whole_number(proposals, "proposals")
        with need("fit", "a fit"):
            import scipy.optimize  # noqa: F401
        free = Parameters(parameters)
        objective = Objective(problem := Problem(setup, free, observations, integrator, loss_of(loss)))
        start_values = _starts(free, starts, rng)
        solvers: list[Solver] = []

        def solve(start_value: Floats) -> Solver:
            solvers.append(Solver(objective, report, limit))
            solvers[-1].solve(start_value)
            return solvers[-1]

        with Progress(progress) as report:
            for start_value in start_values:
                try:
                    if solve(start_value).interrupted:
                        break
                except Refused as error:
                    if len(start_values) == 1:
                        raise InvalidInput(f"the start of the fit is refused: {error}") from error
            bests = sorted((solver.best for solver in solvers if solver.best), key=lambda best: best.cost)
            mirror = None if solvers[-1].interrupted else mirror_start(problem, [best.point for best in bests])
            if mirror is not None:
                start_values.append(mirror)
                with contextlib.suppress(Refused):
                    solve(mirror)
        fits = [Fit(objective, solver.best, solver.message, solver.iterations) for solver in solvers if solver.best]
        if not fits:
            if problem.differentiated or not problem.refused:
                raise Interrupted("interrupted before the first derivatives of the fit; there is nothing to return")
            raise InvalidInput(f"all {len(start_values)} starts of the fit are refused; the last: {problem.reason}")
        best = min(fits, key=lambda other: other.loss)
        best.minima, best.starts = _minima(problem, fits), len(start_values)
        if best.message:
            caution(f"the fit was {best.message}", InconsistentInput)
        elif best.unconstrained is not None:
            caution(f"the data do not constrain {best.unconstrained}", InconsistentInput)
        return best


def _starts(free: Parameters, starts: Any, rng: Any) -> list[Floats]:
    """Return the values from which the solver starts."""
    if isinstance(starts, list | tuple):
        if not starts:
            raise InvalidInput("starts is empty; expected a number, or one start or more")
        start_values = [free.numbers(start) for start in starts]
        for start_value in start_values:
            if ((start_value < free.lower) | (start_value > free.upper)).any():
                raise InvalidInput(f"starts has {free.named(start_value)}, which is not within the bounds")
        return start_values
    count = whole_number(starts, "starts", other=", or a list of starts")
    if count == 1 and rng is None:
        return [free.start]
    random = generator(rng)
    from scipy.stats import norm, qmc

    width = free.upper - free.lower
    bounded, prior = np.isfinite(width), np.isfinite(free.sigma)
    if not (bounded | prior).any():
        raise InvalidInput(f"starts is {count}, but no parameter has two bounds or a prior over which to spread them")
    parts = qmc.LatinHypercube(len(free), seed=random).random(count - 1)
    inside = free.lower + np.where(bounded, width, 0.0) * parts
    drawn = free.mean + np.where(prior, free.sigma, 0.0) * norm.ppf(np.clip(parts, 1e-6, 1.0 - 1e-6))
    spread = np.where(bounded, inside, np.where(prior, drawn, free.start))
    return [free.start, *np.clip(spread, free.lower, free.upper)]


def _minima(problem: Problem, fits: list[Fit]) -> tuple[Minimum, ...]:
    """Return the different minima of fits, the lowest first, with the number of fits that ended at each."""
    minima: list[tuple[Fit, int]] = []
    for fit in sorted(fits, key=lambda other: other.loss):
        for index, (other, count) in enumerate(minima):
            if _same(problem, fit, other):
                minima[index] = (other, count + 1)
                break
        else:
            minima.append((fit, 1))
    size = len(problem.parameters)
    return tuple(
        Minimum(problem.parameters.named(fit.numbers[:size]), fit.loss, fit.chi2, count, fit.message)
        for fit, count in minima
    )


def _same(problem: Problem, fit: Fit, other: Fit) -> bool:
    """Return whether two fits have the same values within their errors, up to full rotations of angles."""
    count = len(problem.parameters)
    values = fit.numbers[:count]
    difference = values - other.numbers[:count]
    periods = np.array([problem.parameters.period(k) for k in range(count)])
    rotations = np.round(difference / periods) * np.where(np.isfinite(periods), periods, 0.0)
    if not (np.abs(difference - rotations) <= _SAME * np.sqrt(np.diag(other.covariance))[:count]).all():
        return False
    return not rotations.any() or problem.unchanged(values, values - rotations)
