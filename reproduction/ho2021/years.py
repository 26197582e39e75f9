"""The year of 1999 KW4 run otherwise: other semi-axes, another G, six ways to compute it, other inclinations."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from fullbody import Body, Ellipsoid, SymplecticSplitting, System, Verner98, systems

from . import kw4, paper
from .starts import SKY, start

__all__ = ["G_HELP", "G_RUN", "NODAL_HOURS", "Nodal", "Way", "nodal", "six_ways", "with_g", "with_printed_axes"]

_Array = npt.NDArray[np.float64]

#: Two values of Newton's constant in the authors' published program, m^3 kg^-1 s^-2: it computes with the first; the
#: help text of its option ``-units`` names the second (SIANS, https://github.com/alexhosians/SIANS, main.py).
G_RUN, G_HELP = 6.67408e-11, 6.674e-11
#: Length of the runs that the node's period is taken from: about three rounds.
NODAL_HOURS = 12000.0


def with_printed_axes(shape: kw4.Shape) -> kw4.Numbers:
    """Return the year from the semi-axes as Table 2 prints them."""
    system, state = systems.kw4_ho2021(shape)
    bodies = [
        Body(Ellipsoid(a, a if shape == "spheroid" else b, c), mass=body.mass, name=body.name)
        for body, (a, b, c) in zip(system.bodies, paper.KW4_AXES, strict=True)
    ]
    return kw4.measure(System(bodies, G=system.G).integrate(state, paper.YEAR_HOURS))


def with_g(shape: kw4.Shape, g: float) -> kw4.Numbers:
    """Return the year with another G, in m^3 kg^-1 s^-2, from the stated elements."""
    stated, state = systems.kw4_ho2021(shape)
    system = System(stated.bodies, G=stated.G * g / G_RUN)
    return kw4.measure(system.integrate(start(state, system.mu(), M=0.0), paper.YEAR_HOURS))


@dataclass(frozen=True, slots=True)
class Way:
    """One way to compute Beta's spin (its range, 1e-5 rad/s) and the period of the inclination (hours)."""

    gravity: str
    integrator: str
    chart: str
    ranges: _Array
    inclination_period: float


def six_ways(until: float = paper.YEAR_HOURS) -> list[Way]:
    """Return the results of two methods of gravity, each by two kinds of integrator and two charts of the attitudes.

    Ctrl-C takes effect when the runs under way have ended.
    """
    ways = [
        (gravity, *way)
        for gravity in kw4.METHODS
        for way in (
            ("Verner98", Verner98(1e-13, 1e-13), "quaternion"),
            ("Verner98", Verner98(1e-13, 1e-13), "tait_bryan"),
            ("ABA1064, 0.1 h", SymplecticSplitting(0.1, "ABA1064"), "quaternion"),
        )
    ]

    def compute(way: tuple[str, str, Verner98 | SymplecticSplitting, str]) -> Way:
        gravity, name, integrator, chart = way
        system, state = systems.kw4_ho2021(gravity=gravity, attitude_chart=chart)
        ranges = kw4.spin_range(system, state, integrator)
        period = float("nan")
        if until > paper.SPIN_HOURS:
            run = system.integrate(state, until, output=1.0, integrator=integrator)
            period = kw4.between_maxima(run.time, kw4.inclination_to_first(run))
        return Way(gravity, name, chart, ranges, period)

    with ThreadPoolExecutor() as pool:
        return list(pool.map(compute, ways))


@dataclass(frozen=True, slots=True)
class Nodal:
    """The node's period round the total angular momentum, hours, by the orbit's inclination at the start, degrees."""

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
        """Return the prograde inclination with some period; NaN where none of those scanned has it."""
        # The period grows with the inclination there.
        slopes, periods = (x[self.inclination < 90] for x in (self.inclination, self.period))
        return float(np.interp(period, periods, slopes, left=np.nan, right=np.nan)) if len(slopes) else float("nan")


def nodal(shape: kw4.Shape, inclinations: _Array) -> Nodal:
    """Let the orbit start with other inclinations; a straight line through the node's motion gives the period."""
    system, state = systems.kw4_ho2021(shape)
    mu = system.mu()

    def period(inclination: float) -> float:
        first = start(state, mu, i=inclination)
        run = system.integrate(first, NODAL_HOURS, output=2.0, integrator=Verner98(1e-10, 1e-10))
        # The node is computed here: a steep orbit's plane rotates too far for the longitudes that observables count.
        r, v = (x[:, 1] - x[:, 0] for x in (run.position, run.velocity))
        axis = run.angular_momentum[0] / np.linalg.norm(run.angular_momentum[0])
        east = np.cross(axis, [1.0, 0.0, 0.0])
        pole = np.cross(r, v)
        node = np.unwrap(np.arctan2(pole @ np.cross(axis, east), pole @ east))
        return float(abs(2 * np.pi / np.polynomial.Polynomial.fit(run.time, node, 1).convert().coef[1]))

    with ThreadPoolExecutor() as pool:
        return Nodal(inclinations, np.array(list(pool.map(period, inclinations))))
