"""Fits: parameters of systems and starts from observations, with their covariance.

:func:`fullbody.fit` takes a setup, as :func:`fullbody.sweep` does, initial values of its parameters, and observations
of :mod:`fullbody.observing`. :class:`Free` gives a parameter bounds and a prior. The result is a :class:`Fit`.

Install the dependencies with the extra ``fit``.
"""

from __future__ import annotations

from .free import Free
from .losses import Outliers
from .periods import PeriodMinimum, PeriodScan, period_scan
from .poles import Poles, pole_grid
from .regularisation import Regularisation, closure, convexity, principal_axis, smoothness
from .result import Fit, Minimum
from .solve import fit
from .uncertainty import Derived

__all__ = [
    "Derived",
    "Fit",
    "Free",
    "Minimum",
    "Outliers",
    "PeriodMinimum",
    "PeriodScan",
    "Poles",
    "Regularisation",
    "closure",
    "convexity",
    "fit",
    "period_scan",
    "pole_grid",
    "principal_axis",
    "smoothness",
]


def __dir__() -> list[str]:
    return __all__
