"""The year of 1999 KW4 with other semi-axes, another G, other methods and other inclinations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from fullbody import Body, Ellipsoid, SymplecticSplitting, System, Verner98, systems

from . import kw4, paper
from .spin import in_threads
from .starts import SKY, start

__all__ = ["G_HELP", "G_RUN", "NODAL_HOURS", "Nodal", "Variant", "nodal", "variants", "with_g", "with_printed_axes"]

_Array = npt.NDArray[np.float64]

#: Two values of Newton's constant in the authors' published program, m^3 kg^-1 s^-2: it computes with the first; the
#: help text of its option ``-units`` names the second (SIANS, https://github.com/alexhosians/SIANS, main.py).
G_RUN, G_HELP = 6.67408e-11, 6.674e-11
#: The length of the runs for the period of the node, about three periods.
NODAL_HOURS = 12000.0


def with_printed_axes(shape: kw4.Shape) -> kw4.Numbers:
    """Return the numbers of the year with the semi-axes as Table 2 prints them."""
    system, state = systems.kw4_ho2021(shape)
    bodies = [
        Body(Ellipsoid(a, a if shape == "spheroid" else b, c), mass=body.mass, name=body.name)
        for body, (a, b, c) in zip(system.bodies, paper.KW4_AXES, strict=True)
    ]
    return kw4.measure(System(bodies, G=system.G).integrate(state, paper.YEAR_HOURS))


def with_g(shape: kw4.Shape, g: float) -> kw4.Numbers:
    """Return the numbers of the year with another G, in m^3 kg^-1 s^-2, from the stated elements."""
    stated, state = systems.kw4_ho2021(shape)
    system = System(stated.bodies, G=stated.G * g / G_RUN)
    return kw4.measure(system.integrate(start(state, system.mu(), M=0.0), paper.YEAR_HOURS))


@dataclass(frozen=True, slots=True)
class Variant:
    """The range of Beta's spin (1e-5 rad/s) and the period of the inclination (hours) by one choice of methods."""

    gravity: str
    integrator: str
    chart: str
    ranges: _Array
    inclination_period: float


def variants(until: float = paper.YEAR_HOURS) -> list[Variant]:
    """Return the results of two methods of gravity, each with two kinds of integrator and two charts of the attitudes.

    The period of the inclination is computed if the runs are longer than those of the spin. Ctrl-C takes effect when
    the current runs have ended.
    """
    methods = [
        (gravity, *method)
        for gravity in kw4.METHODS
        for method in (
            ("Verner98", Verner98(1e-13, 1e-13), "quaternion"),
            ("Verner98", Verner98(1e-13, 1e-13), "tait_bryan"),
            ("ABA1064, 0.1 h", SymplecticSplitting(0.1, "ABA1064"), "quaternion"),
        )
    ]

    def compute(method: tuple[str, str, Verner98 | SymplecticSplitting, str]) -> Variant:
        gravity, name, integrator, chart = method
        system, state = systems.kw4_ho2021(gravity=gravity, attitude_chart=chart)
        ranges = kw4.spin_range(system, state, integrator)
        period = float("nan")
        if until > paper.SPIN_HOURS:
            run = system.integrate(state, until, output=1.0, integrator=integrator)
            period = kw4.between_maxima(run.time, kw4.inclination_to_first(run))
        return Variant(gravity, name, chart, ranges, period)

    return in_threads(compute, methods)


@dataclass(frozen=True, slots=True)
class Nodal:
    """The period of the node about the total angular momentum, h, by the initial inclination of the orbit, deg."""

    inclination: _Array
    period: _Array

    @property
    def stated(self) -> float:
        """The period at the stated inclination."""
        return float(self.period[self.inclination == SKY["i"]][0])

    @property
    def least(self) -> float:
        """The shortest period of the retrograde orbits scanned."""
        return float(self.period[self.inclination > 90].min())

    def prograde(self, period: float) -> float:
        """Return the prograde inclination with a period; NaN if it is outside the scanned range."""
        # The period increases with the inclination of prograde orbits.
        tilts, periods = (x[self.inclination < 90] for x in (self.inclination, self.period))
        return float(np.interp(period, periods, tilts, left=np.nan, right=np.nan)) if len(tilts) else float("nan")


def nodal(shape: kw4.Shape, inclinations: _Array) -> Nodal:
    """Return the period of the node, from a straight line fitted to its motion, for some initial inclinations."""
    system, state = systems.kw4_ho2021(shape)
    mu = system.mu()

    def period(inclination: float) -> float:
        first = start(state, mu, i=inclination)
        run = system.integrate(first, NODAL_HOURS, output=2.0, integrator=Verner98(1e-10, 1e-10))
        # The observables of the package do not cover the precession of orbits of such inclinations.
        r, v = (x[:, 1] - x[:, 0] for x in (run.position, run.velocity))
        axis = run.angular_momentum[0] / np.linalg.norm(run.angular_momentum[0])
        east = np.cross(axis, [1.0, 0.0, 0.0])
        pole = np.cross(r, v)
        node = np.unwrap(np.arctan2(pole @ np.cross(axis, east), pole @ east))
        return float(abs(2 * np.pi / np.polynomial.Polynomial.fit(run.time, node, 1).convert().coef[1]))

    return Nodal(inclinations, np.array(in_threads(period, inclinations)))
