"""Figures of the refits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from ..judging import LIMIT
from .catalogue import DECISIVE, Refit
from .haumea import RING, orbit_pole

if TYPE_CHECKING:
    from .eris import Eris
    from .haumea import Haumea

__all__ = ["CAPTIONS", "catalogue", "eris", "poles"]

CAPTIONS = {
    "catalogue": "Fitted minus published elements of the 27 systems, in joint standard errors (left; cut at 15), and "
    "the ratio of the published standard error of the period to that which the data of the file allow (right). The "
    "publication of systems left of the dotted line probably used more data than the file has.",
    "eris": "Dysnomia about Eris: the observations with their standard errors, enlarged five times, and the positions "
    "of Dysnomia on the fitted orbit at the same times.",
    "poles": "The normal of Hi'iaka's orbit, fitted with either sign of right ascension, Haumea's axis, and the pole "
    "of its ring.",
}


def catalogue(refits: Sequence[Refit]) -> Figure:
    """Draw the differences of the elements of each system, and the ratio of the errors of its period."""
    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[2, 1])
    rows = np.arange(len(refits))
    for name, marker in zip(DECISIVE, "osD^", strict=True):
        values = np.clip([refit.differences[name] for refit in refits], -15.0, 15.0)
        left.plot(values, rows, marker, ms=4, alpha=0.8, label=name)
    left.axvspan(-LIMIT, LIMIT, color="0.9", zorder=0)
    left.set(xlabel="fitted minus published, joint standard errors", yticks=rows, xlim=(-16, 16))
    left.set_yticklabels([refit.catalogued.name for refit in refits], fontsize=7)
    left.invert_yaxis()
    left.legend(fontsize=8)
    right.plot([refit.ratio for refit in refits], rows, "ko", ms=4)
    right.axvline(0.5, color="0.5", ls=":")
    right.set(xscale="log", xlim=(0.05, 3.0), xlabel="published over fitted error of the period")
    right.xaxis.set_minor_formatter(NullFormatter())
    return figure


def eris(result: Eris) -> Figure:
    """Draw the observed offsets and those of the fitted orbit in the sky."""
    fit = result.points
    (data,) = fit.observations
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    axes = figure.subplots()
    east, north, sigma = (x.to_value("arcsec") for x in (data.east, data.north, data.sigma))
    axes.errorbar(east, north, 5 * sigma[:, 1], 5 * sigma[:, 0], "none", ecolor="C0", elinewidth=1)
    positions = data.predict(fit.run).to_value("arcsec")
    axes.plot(*positions.T, "k.", ms=4)
    axes.plot(0, 0, "k+")
    axes.set(xlabel="east [arcsec]", ylabel="north [arcsec]", aspect="equal")
    axes.invert_xaxis()
    return figure


def poles(result: Haumea) -> Figure:
    """Draw poles in right ascension and declination; an axis and its opposite are the same plane."""
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = figure.subplots()
    names: Mapping[int, str] = {1: "sign as in the tables", -1: "sign reversed"}
    for (east, fit), marker in zip(result.alone.items(), "sD", strict=True):
        ra, dec = orbit_pole(fit.values["i"], fit.values["node"])
        if ra < 180.0:
            ra, dec = ra + 180.0, -dec
        axes.plot(ra, dec, marker, label=f"Hi'iaka, {names[east]}: chi2 {fit.chi2:.0f} of {fit.dof}")
    (ra, ra_error), (dec, dec_error) = RING
    axes.errorbar(ra, dec, dec_error, ra_error, "ko", label="ring (Ortiz et al. 2017)")
    values, errors = result.axis.values, result.axis.sigma
    axes.errorbar(
        values["ra"], values["dec"], errors["dec"], errors["ra"], "C2^", label="Haumea's axis, from both moons"
    )
    axes.set(xlabel="right ascension [deg]", ylabel="declination [deg]")
    axes.legend(fontsize=8)
    return figure
