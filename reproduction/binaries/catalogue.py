"""The 27 systems of the catalogue: fits from the published orbits, and the reasons for differences."""

from __future__ import annotations

from dataclasses import dataclass, replace

import fullbody
import numpy as np
from fullbody.fitting import Fit, Free
from scipy.stats import chi2 as chi2_distribution

from ..judging import LIMIT, Verdict, compared, joint
from . import observations
from .pair import INTEGRATOR, points

__all__ = ["DECISIVE", "Refit", "exchanged", "fit", "refit", "verdicts", "within"]

#: The elements that decide whether a fit agrees with the published orbit.
DECISIVE = ("a", "period", "e", "i")
UNITS = {"a": "km", "period": "d", "e": "", "i": "deg", "node": "deg", "periapsis": "deg", "longitude": "deg"}
#: The factor by which chi2 of a row has to fall for its components to count as exchanged in the file.
EXCHANGED = 100.0
#: The published error of the period over that of the fit, below which the file probably lacks data.
LEAST_RATIO = 0.5


@dataclass(frozen=True)
class Refit:
    """The fit of a system, beside the published orbit.

    Attributes
    ----------
    catalogued : Catalogued
        The observations, with the components of the rows ``exchanged`` in the other order, and the published orbit.
    fit : Fit
    exchanged : tuple of int
        Rows in which the components are exchanged.
    file_chi2 : float
        chi2 of the rows as they are in the file, on the fitted orbit.
    rise, p_rise : float
        How much chi2 rises where the published orbit, with its errors, is a prior, and the probability of a larger
        rise, with seven degrees of freedom. NaN where the fit agrees with the published orbit.
    """

    catalogued: observations.Catalogued
    fit: Fit
    exchanged: tuple[int, ...]
    file_chi2: float
    rise: float
    p_rise: float

    @property
    def differences(self) -> dict[str, float]:
        """Fitted minus published values in joint standard errors."""
        entry, fit = self.catalogued, self.fit
        return {
            name: (fit.values[name] - value) / joint(entry.errors[name], fit.sigma[name])
            for name, value in entry.published.items()
        }

    @property
    def holds(self) -> bool:
        """Whether a, the period, e and i agree with the published values."""
        return within(self.differences)

    @property
    def ratio(self) -> float:
        """The published standard error of the period over that of the fit."""
        return float(self.catalogued.errors["period"] / self.fit.sigma["period"])

    @property
    def why(self) -> str:
        """The reasons why elements may differ."""
        last = self.catalogued.data.times[-1].decimalyear
        text = []
        if self.exchanged:
            rows = ", ".join(str(row) for row in self.exchanged)
            text.append(
                f"Rows {rows} of the file have the components exchanged; as given, chi2 on the fitted orbit is "
                f"{self.file_chi2:.0f}."
            )
        if self.ratio < LEAST_RATIO:
            text.append(
                f"The file probably lacks rows: it ends in {last:.1f} and determines the period {1.0 / self.ratio:.1f} "
                "times less well than published."
            )
        if np.isfinite(self.rise):
            text.append(f"With the published orbit as a prior chi2 rises by {self.rise:.1f} (p = {self.p_rise:.2g}).")
        return " ".join(text)


def within(differences: dict[str, float]) -> bool:
    """Return whether the differences of a, the period, e and i are within the limit of a verdict."""
    return all(abs(differences[name]) <= LIMIT for name in DECISIVE)


def refit(name: str) -> Refit:
    """Fit a system, with the components exchanged in rows that agree with the published orbit only then."""
    published = observations.catalogued(name)
    rows = exchanged(published)
    entry = observations.catalogued(name, rows) if rows else published
    result = fit(entry)
    file_chi2 = float(np.sum(published.data.pulls(result.run) ** 2))
    refitted = Refit(entry, result, rows, file_chi2, np.nan, np.nan)
    if refitted.holds:
        return refitted
    priors = {key: Free(value, prior=(value, entry.errors[key])) for key, value in entry.published.items()}
    rise = fit(entry, priors).chi2 - result.chi2
    return replace(refitted, rise=rise, p_rise=float(chi2_distribution.sf(rise, len(priors))))


def fit(entry: observations.Catalogued, parameters: dict[str, Free] | None = None) -> Fit:
    """Fit two points from the published orbit."""
    return fullbody.fit(
        points(entry.epoch, entry.share), parameters or entry.published, entry.data, integrator=INTEGRATOR
    )


def exchanged(entry: observations.Catalogued) -> tuple[int, ...]:
    """Find the rows whose components are in the other order, by the published orbit."""
    system, state = points(entry.epoch, entry.share)(**entry.published)
    times = entry.data.emission(system)
    first = system.integrate(state, times[0], output="ends", integrator=INTEGRATOR)[-1]
    run = system.integrate(first, times[-1], dense=True, integrator=INTEGRATOR)
    offsets, sigma = np.stack([entry.data.east, entry.data.north], axis=1), entry.data.sigma
    chi2, swapped = (
        np.sum(((sign * offsets - entry.data.predict(run)) / sigma).to_value("") ** 2, axis=1) for sign in (1.0, -1.0)
    )
    return tuple(int(row) for row in entry.data.rows[chi2 > EXCHANGED * np.maximum(swapped, 1.0)])


def verdicts(result: Refit) -> list[Verdict]:
    """Compare the elements of a system."""
    entry = result.catalogued
    return [
        compared(
            entry.name,
            f"{name} [{UNITS[name]}]" if UNITS[name] else name,
            (value, entry.errors[name]),
            (result.fit.values[name], result.fit.sigma[name]),
            result.why,
        )
        for name, value in entry.published.items()
    ]
