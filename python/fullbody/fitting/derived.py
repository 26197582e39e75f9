"""Quantities that follow from fitted parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..observing.measured import Measured
from .problem import Problem

__all__ = ["Derived", "derived"]


class Derived(NamedTuple):
    """A quantity derived from the parameters of a fit, with its standard error to first order."""

    value: Any
    sigma: Any


def derived(
    problem: Problem,
    values: npt.NDArray[np.float64],
    covariance: npt.NDArray[np.float64],
    function: Callable[[Any], Any],
    times: Any,
) -> Derived:
    """Return a quantity with its error; see :meth:`fullbody.fitting.Fit.derived`.

    Its derivatives are those of the pulls of a measured value of the same size, whose error is one.
    """
    indices = [problem.parameters.names.index(name) for name in problem.of_setup]
    made = problem.make(values)
    probe = Measured("the derived quantity", function, 0.0, 1.0, times)
    run = problem.sampled(made, [probe])
    value = function(run)
    unit = getattr(value, "unit", 1.0)
    measured = Measured(probe.name, function, value, np.ones(np.shape(value)) * unit, times)
    alone = Problem(problem.setup, problem.parameters.only(problem.of_setup), measured, problem.integrator)
    rows = alone.jacobian(alone.point(values[indices])).rows
    spread = np.sqrt(np.einsum("ck,kl,cl->c", rows, covariance[np.ix_(indices, indices)], rows))
    return Derived(value, spread.reshape(np.shape(value)) * unit)
