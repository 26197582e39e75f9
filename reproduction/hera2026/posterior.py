"""The joint posterior of the published values: a proposal, its draws, and their weights.

A draw from the proposal becomes one of the posterior by the weight

    w = prior * likelihood / proposal,

where the likelihood is that of the orbit of the draw in its motion in space. The proposal is made in two
steps. A fit of the motion within the plane of the orbit gives a normal distribution of starts. Pilot runs of draws from
it, in space, are fitted by a quadratic surrogate of the orbit's period, eccentricity and precession; the proposal is
the prior, with some widths larger, times the likelihood of the surrogate, whose own scatter is added to the errors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from fullbody import Run, SymplecticSplitting
from scipy.optimize import least_squares

from . import model
from .ellipse import fitted_ellipse
from .inputs import INPUTS, Input

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = [
    "FITTED",
    "OBSERVED",
    "OBSERVED_DAYS",
    "PRIORS",
    "Surrogate",
    "draws",
    "likelihood",
    "log_weights",
    "orbit",
    "pilot",
    "prior",
    "slope",
]

#: The days after the impact over which observers saw the orbit before it changed, 2022-12-02 (S24).
OBSERVED_DAYS: Final = 67.0
SAMPLES: Final = np.arange(0.0, OBSERVED_DAYS * model.DAY + 1.0, 2.0)
#: Quantities of the orbit after the impact that observers published.
OBSERVED: Final = ("period", "eccentricity", "precession")
#: The numbers on which the motion within the plane of the orbit depends.
FITTED: Final = (
    "separation",
    "equatorial",
    "polar",
    "diameter",
    "density",
    "along",
    "radial",
    "miss_radial",
    "a_b",
    "b_c",
    "yaw",
)
#: The numbers on which the motion within the plane does not depend.
PRIORS: Final = ("normal", "miss_normal", "log_k2_q", "log_k2_q_primary", "byorp", "pole_longitude", "pole_latitude")
#: The numbers that the surrogate depends on.
INPUT_NAMES: Final = (*FITTED, "normal", "miss_normal")
#: Factors of the widths of the priors in the proposal, so that wider priors can be tried by weights.
WIDER: Final = {"a_b": 2.0, "b_c": 2.0, "normal": 1.5, "log_k2_q": 1.5}
#: The error of the precession in the planar fit, as a factor: a motion in space has another precession.
PLANAR: Final = 4.0
#: The least ratio of axes a, b and c in this order.
LEAST_RATIO: Final = 1.01
#: The largest log10 of k2/Q: with Q = 10 a homogeneous body has k2 below 1.5.
LARGEST_K2_Q: Final = -1.0
#: The step of differences of the planar fit, in units of the errors.
STEP: Final = 0.05
#: The least coherence of an orbit that the surrogate describes.
COHERENT: Final = 0.9
#: The number of draws from the prior that are compared with the surrogate at a time.
BATCH: Final = 200_000


@dataclass(frozen=True)
class Surrogate:
    """A quadratic function of the numbers of a start for the observed values of its orbit.

    Attributes
    ----------
    centre, scale : ndarray, (P,)
        The mean and the standard deviation of the numbers :data:`INPUT_NAMES`.
    coefficients : ndarray, (F, 3)
    scatter : ndarray, (3,)
        The standard deviation of the orbits about the function.
    """

    centre: npt.NDArray[np.float64]
    scale: npt.NDArray[np.float64]
    coefficients: npt.NDArray[np.float64]
    scatter: npt.NDArray[np.float64]

    def features(self, columns: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the terms (M, F) of the function: a constant, the numbers, and their products."""
        x = (np.stack([columns[name] for name in INPUT_NAMES], axis=-1) - self.centre) / self.scale
        first, second = np.triu_indices(len(INPUT_NAMES))
        return np.concatenate([np.ones((len(x), 1)), x, x[:, first] * x[:, second]], axis=1)

    def log_likelihood(
        self, columns: Mapping[str, Any], inputs: Mapping[str, Input] = INPUTS
    ) -> npt.NDArray[np.float64]:
        """Return the logarithm of the likelihood (M,) of the function's values, with its scatter in the errors."""
        value = np.array([inputs[name].value for name in OBSERVED])
        error = np.hypot([inputs[name].sigma for name in OBSERVED], self.scatter)
        return np.asarray(-0.5 * np.sum(((self.features(columns) @ self.coefficients - value) / error) ** 2, axis=1))

    @classmethod
    def fitted(cls, columns: Mapping[str, Any], orbits: Mapping[str, Any]) -> Surrogate:
        """Fit the function to starts and their orbits, of those that are coherent.

        Parameters
        ----------
        columns : mapping of str to ndarray, (M,)
            Numbers of starts.
        orbits : mapping of str to ndarray, (M,)
            The fitted ``period``, ``eccentricity``, ``precession`` and ``coherence``.
        """
        coherent = np.asarray(orbits["coherence"]) > COHERENT
        inputs = {name: np.asarray(columns[name])[coherent] for name in INPUT_NAMES}
        table = np.stack([inputs[name] for name in INPUT_NAMES], axis=1)
        results = np.stack([np.asarray(orbits[name])[coherent] for name in OBSERVED], axis=1)
        blank = cls(table.mean(axis=0), table.std(axis=0), np.empty((0, 3)), np.empty(3))
        features = blank.features(inputs)
        # A weak ridge makes the coefficients of products small that the sample does not determine.
        weight = np.concatenate(
            [np.zeros(1 + len(INPUT_NAMES)), np.full(features.shape[1] - 1 - len(INPUT_NAMES), 2.0)]
        )
        coefficients = np.linalg.solve(features.T @ features + np.diag(weight), features.T @ results)
        return cls(blank.centre, blank.scale, coefficients, (results - features @ coefficients).std(axis=0))


def orbit(run: Run) -> list[float]:
    """Return the period in hours, the eccentricity, and the advance of the apses in degrees a day."""
    ellipse = fitted_ellipse(run)
    return [ellipse.period, ellipse.eccentricity, ellipse.precession]


def planar_fit(inputs: Mapping[str, Input]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Fit the numbers of the table of inputs to the published orbit in its plane; return mean (P,) and covariance."""
    value = {name: inputs[name].value for name in (*FITTED, *OBSERVED)}
    factors = WIDER | {"precession": PLANAR}
    sigma = {name: inputs[name].sigma * factors.get(name, 1.0) for name in value}
    centre, scale = (np.array([column[name] for name in FITTED]) for column in (value, sigma))
    lower = [(LEAST_RATIO - value[name]) / sigma[name] if name in ("a_b", "b_c") else -np.inf for name in FITTED]

    def pulls(offset: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the residuals of the observed values and of the priors, each in units of its error."""
        system, state = model.planar(**dict(zip(FITTED, centre + scale * offset, strict=True)))
        run = system.integrate(state, SAMPLES[-1], output=SAMPLES, integrator=SymplecticSplitting(step=0.5))
        observed = zip(OBSERVED, orbit(run), strict=True)
        return np.array([*((predicted - value[name]) / sigma[name] for name, predicted in observed), *offset])

    # The fitted ellipse of a run has numerical errors, so that its derivatives need long steps.
    fit = least_squares(pulls, np.zeros(len(FITTED)), bounds=(lower, np.inf), diff_step=STEP, x_scale=1.0, xtol=1e-4)
    return centre + scale * fit.x, np.linalg.inv(fit.jac.T @ fit.jac) * scale[:, None] * scale[None, :]


def slope(inputs: Mapping[str, Input] = INPUTS, step: float = 0.005) -> float:
    """Return the change of the planar precession with a/b, degrees a day per unit, about the table of inputs."""
    rates = []
    for sign in (1.0, -1.0):
        values = {name: inputs[name].value for name in FITTED}
        system, state = model.planar(**values | {"a_b": values["a_b"] + sign * step})
        run = system.integrate(state, SAMPLES[-1], output=SAMPLES, integrator=SymplecticSplitting(step=0.5))
        rates.append(orbit(run)[2])
    return (rates[0] - rates[1]) / (2.0 * step)


def pilot(inputs: Mapping[str, Input], count: int, seed: int) -> dict[str, npt.NDArray[np.float64]]:
    """Draw starts for pilot runs, each number a column (count,): the planar fit, and priors for the other numbers."""
    rng = np.random.default_rng([seed, 1])
    mean, covariance = planar_fit(inputs)

    def sample(size: int) -> dict[str, npt.NDArray[np.float64]]:
        rows = rng.multivariate_normal(mean, covariance, size)
        return dict(zip(FITTED, rows.T, strict=True)) | _normal(rng, PRIORS, inputs, size)

    return _possible(sample, count)


def draws(
    surrogate: Surrogate, count: int, seed: int, inputs: Mapping[str, Input] = INPUTS
) -> dict[str, npt.NDArray[np.float64]]:
    """Draw starts from the proposal, each number a column (count,): by rejection from the wider prior."""
    rng = np.random.default_rng([seed, 2])

    def sample(size: int) -> dict[str, npt.NDArray[np.float64]]:
        columns = _normal(rng, model.NAMES, inputs, BATCH)
        accepted = np.log(rng.random(BATCH)) < surrogate.log_likelihood(columns, inputs)
        return {name: column[accepted] for name, column in columns.items()}

    return _possible(sample, count)


def _normal(
    rng: np.random.Generator, names: tuple[str, ...], inputs: Mapping[str, Input], size: int
) -> dict[str, npt.NDArray[np.float64]]:
    """Draw numbers from their priors, whose widths are multiplied by :data:`WIDER`."""
    return {name: rng.normal(inputs[name].value, inputs[name].sigma * WIDER.get(name, 1.0), size) for name in names}


def _possible(sample: Callable[[int], dict[str, npt.NDArray[np.float64]]], count: int) -> dict[str, npt.NDArray[Any]]:
    """Collect samples until there are ``count`` with axes of Dimorphos in order and possible Love numbers."""
    parts: list[dict[str, npt.NDArray[np.float64]]] = []
    while sum(len(part["a_b"]) for part in parts) < count:
        part = sample(2 * count)
        possible = (np.minimum(part["a_b"], part["b_c"]) > LEAST_RATIO) & (
            np.maximum(part["log_k2_q"], part["log_k2_q_primary"]) < LARGEST_K2_Q
        )
        parts.append({name: column[possible] for name, column in part.items()})
    return {name: np.concatenate([part[name] for part in parts])[:count] for name in parts[0]}


def log_weights(
    columns: Mapping[str, Any], orbits: Mapping[str, Any], surrogate: Surrogate, inputs: Mapping[str, Input] = INPUTS
) -> npt.NDArray[np.float64]:
    """Return the logarithms of the weights (M,) that make draws from the proposal those of the posterior.

    Parameters
    ----------
    columns : mapping of str to ndarray, (M,)
        Numbers of starts, drawn from the proposal.
    orbits : mapping of str to ndarray, (M,)
        The fitted ``period``, ``eccentricity`` and ``precession`` of their motion in space.
    surrogate : Surrogate
        The surrogate of the proposal.
    inputs : mapping of str to Input
        The table of inputs of the proposal.
    """
    wider = {name: replace(inputs[name], sigma=inputs[name].sigma * factor) for name, factor in WIDER.items()}
    narrower = prior(columns, inputs) - prior(columns, {**inputs, **wider})
    return narrower + likelihood(orbits, inputs) - surrogate.log_likelihood(columns, inputs)


def prior(columns: Mapping[str, Any], inputs: Mapping[str, Input] = INPUTS) -> npt.NDArray[np.float64]:
    """Return the logarithm of the prior density (M,) of numbers of starts, up to a constant."""
    pulls = [(np.asarray(columns[name]) - inputs[name].value) / inputs[name].sigma for name in model.NAMES]
    return np.asarray(-0.5 * np.sum(np.square(pulls), axis=0))


def likelihood(columns: Mapping[str, Any], inputs: Mapping[str, Input] = INPUTS) -> npt.NDArray[np.float64]:
    """Return the logarithm of the likelihood (M,) of the orbit in the days observed, up to a constant.

    Parameters
    ----------
    columns : mapping of str to array_like, (M,)
        The fitted ``period``, ``eccentricity`` and ``precession``. Members without an orbit, whose values are NaN, have
        the likelihood zero.
    """
    pulls = [(np.asarray(columns[name]) - inputs[name].value) / inputs[name].sigma for name in OBSERVED]
    logarithm = np.asarray(-0.5 * np.sum(np.square(pulls), axis=0))
    return np.where(np.isfinite(logarithm), logarithm, -np.inf)
