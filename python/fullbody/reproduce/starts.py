"""Beta's spin and the inclination's period as functions of the start: which start, if any, gives what is printed."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import paper, systems
from ..integrators import SymplecticSplitting, Verner98
from ..run import Run
from ..state import State
from . import kw4

__all__ = ["SCANS", "Agreement", "Scan", "Search", "agreement", "nodal_period", "scan", "search", "spin_range"]

_Array = npt.NDArray[np.float64]

#: The printed ranges, 1e-5 rad/s, (3, 2).
PRINTED = np.array([paper.KW4_SPIN[axis] for axis in "xyz"])
#: Scans and the search need four digits only.
_COARSE = Verner98(1e-10, 1e-10)
_PER_SECOND = 1e5 / 3600.0


@dataclass(frozen=True, slots=True)
class Scan:
    """Ranges of Beta's spin over the first 200 h along a family of starts.

    Attributes
    ----------
    name : str
    values : ndarray, (K,)
        The family's parameter, degrees.
    ranges : ndarray, (K, 3, 2)
        Smallest and largest component, 1e-5 rad/s.
    """

    name: str
    values: _Array
    ranges: _Array

    @property
    def misfit(self) -> _Array:
        """Largest difference from the printed six numbers (K,), 1e-5 rad/s."""
        return np.asarray(np.abs(self.ranges - PRINTED).max(axis=(1, 2)))

    @property
    def best(self) -> tuple[float, float]:
        """Parameter of the smallest misfit, and that misfit."""
        k = int(np.argmin(self.misfit))
        return float(self.values[k]), float(self.misfit[k])


@dataclass(frozen=True, slots=True)
class Search:
    """The orientation of Beta whose spin comes nearest to the printed ranges.

    Attributes
    ----------
    tried : int
        Orientations spread evenly over all there are, before the best were refined.
    within : int
        How many of them came within 0.1e-5 rad/s unrefined.
    angles : tuple
        The paper's phi, theta, psi, degrees.
    ranges : ndarray, (3, 2)
    misfit : float
        1e-5 rad/s.
    """

    tried: int
    within: int
    angles: tuple[float, float, float]
    ranges: _Array
    misfit: float


@dataclass(frozen=True, slots=True)
class Agreement:
    """The two quantities in question by one way of computing them."""

    gravity: str
    integrator: str
    chart: str
    ranges: _Array
    inclination_period: float


def start(state: State, mu: float, attitude: Any = None, spin: float | None = None, **elements: float) -> State:
    """The paper's start with another attitude or spin of Beta, or other elements of the orbit (angles in degrees)."""
    from ..elements import KeplerElements

    changes: dict[str, Any] = {}
    if attitude is not None:
        changes["attitude"] = [state.attitude[0], attitude.as_quat(scalar_first=True)]
    if spin is not None:
        changes["spin"] = [state.spin[0], [0.0, 0.0, spin]]
    if elements:
        orbit = {**systems.ho2021.KW4_ORBIT, **{n: np.deg2rad(x) for n, x in systems.ho2021.KW4_SKY.items()}}
        orbit.update({name: np.deg2rad(value) for name, value in elements.items()})
        r, v = KeplerElements(**orbit).to_cartesian(mu)
        changes["position"], changes["velocity"] = [state.position[0], r], [state.velocity[0], v]
    return state.replace(**changes)


def spin_range(run: Run) -> _Array:
    """Range of Beta's spin over the first 200 h of a run in hours, 1e-5 rad/s (3, 2)."""
    spin = run.spin[run.time <= paper.KW4_SPIN_HOURS, 1] * _PER_SECOND
    return np.stack([spin.min(axis=0), spin.max(axis=0)], axis=1)


def _range_of(system: Any, state: State) -> _Array:
    return spin_range(system.integrate(state, paper.KW4_SPIN_HOURS, output=0.1, integrator=_COARSE))


def _normal(state: State) -> _Array:
    """The orbit's normal."""
    normal = np.cross(state.position[1] - state.position[0], state.velocity[1] - state.velocity[0])
    return np.asarray(normal / np.linalg.norm(normal))


#: Families of starts: name, and what makes the start from the paper's, mu and an angle in degrees.
SCANS: dict[str, Callable[[State, float, float], State]] = {
    "mean anomaly of Beta": lambda state, mu, x: start(state, mu, M=x),
    "Beta turned about the orbit's normal": lambda state, mu, x: start(
        state, mu, _rotation().from_rotvec(np.deg2rad(x) * _normal(state))
    ),
    "Beta turned about its own pole (psi)": lambda state, mu, x: start(
        state, mu, _rotation().from_euler("z", x, degrees=True)
    ),
}


def _rotation() -> Any:
    from scipy.spatial.transform import Rotation

    return Rotation


def scan(name: str, values: _Array) -> Scan:
    """Beta's spin along one of the families in ``SCANS``."""
    system, state = systems.kw4_ho2021()
    mu = system.mu()
    # Integration leaves Python's lock alone, so threads share the work.
    with ThreadPoolExecutor() as pool:
        ranges = list(pool.map(lambda x: _range_of(system, SCANS[name](state, mu, x)), values))
    return Scan(name, values, np.array(ranges))


def search(tried: int = 1024, refined: int = 4) -> Search:
    """Look over all orientations of Beta, its spin along its own z-axis as stated, for the printed ranges."""
    from scipy.optimize import minimize
    from scipy.stats import qmc

    rotation = _rotation()
    system, state = systems.kw4_ho2021()
    mu = system.mu()

    def ranges(attitude: Any) -> _Array:
        return _range_of(system, start(state, mu, attitude))

    # Shoemake's uniform quaternions from evenly spread points; the turn about the normal is one of the candidates.
    a, b, c = qmc.Sobol(3, rng=1).random(tried).T
    quaternions = np.stack(
        [np.sqrt(1 - a) * f(2 * np.pi * b) for f in (np.sin, np.cos)]
        + [np.sqrt(a) * f(2 * np.pi * c) for f in (np.sin, np.cos)],
        axis=1,
    )
    everywhere = [rotation.from_quat(q) for q in quaternions]
    with ThreadPoolExecutor() as pool:
        misfits = np.array(list(pool.map(lambda q: np.abs(ranges(q) - PRINTED).max(), everywhere)))
    turned = rotation.from_rotvec(np.deg2rad(-20.0) * _normal(state))
    candidates = [turned, *(everywhere[k] for k in np.argsort(misfits)[:refined])]

    def refine(first: Any) -> Any:
        simplex = np.vstack([np.zeros(3), 0.1 * np.eye(3)])
        found = minimize(
            lambda d: float(np.sum((ranges(rotation.from_rotvec(d) * first) - PRINTED) ** 2)),
            np.zeros(3),
            method="Nelder-Mead",
            options={"initial_simplex": simplex, "maxfev": 160, "xatol": 1e-4, "fatol": 1e-9},
        )
        return rotation.from_rotvec(found.x) * first

    with ThreadPoolExecutor() as pool:
        finished = list(pool.map(refine, candidates))
    results = [ranges(q) for q in finished]
    k = int(np.argmin([np.abs(r - PRINTED).max() for r in results]))
    psi, theta, phi = finished[k].as_euler("ZYX", degrees=True)
    misfit = float(np.abs(results[k] - PRINTED).max())
    angles = (float(phi), float(theta), float(psi))
    return Search(tried, int(np.sum(misfits < 0.1)), angles, results[k], misfit)


def year_from(angles: tuple[float, float, float], shape: Any = "ellipsoid") -> kw4.Numbers:
    """The year's numbers when Beta starts at other phi, theta, psi, degrees."""
    system, state = systems.kw4_ho2021(shape, units=True)
    beta = _rotation().from_euler("ZYX", angles[::-1], degrees=True).as_quat(scalar_first=True)
    moved = state.replace(attitude=[state.attitude[0], beta])
    return kw4.measure(system.integrate(moved, paper.KW4_YEAR, integrator=Verner98(1e-12, 1e-12)))


def agreement(until: float = paper.KW4_YEAR) -> list[Agreement]:
    """Both quantities by two methods of gravity, two kinds of integrator and two charts of the attitudes."""
    ways = [
        (gravity, *way)
        for gravity in kw4.METHODS
        for way in (
            ("Verner98", Verner98(1e-13, 1e-13), "quaternion"),
            ("Verner98", Verner98(1e-13, 1e-13), "tait_bryan"),
            ("ABA1064, 0.1 h", SymplecticSplitting(0.1, "ABA1064"), "quaternion"),
        )
    ]

    def compute(way: tuple[str, str, Any, Any]) -> Agreement:
        gravity, name, integrator, chart = way
        system, state = systems.kw4_ho2021(gravity=gravity, attitude_chart=chart)
        run = system.integrate(state, until, output=0.1, integrator=integrator)
        period = kw4.between_maxima(run.time, kw4.inclination_to_first(run))
        return Agreement(gravity, name, chart, spin_range(run), period)

    with ThreadPoolExecutor() as pool:
        return list(pool.map(compute, ways))


def nodal_period(shape: Any, inclinations: _Array) -> _Array:
    """Period of the node on the total angular momentum's plane, hours, by the orbit's inclination in degrees."""
    from ..observables import orbit_precession

    system, state = systems.kw4_ho2021(shape)
    mu = system.mu()

    def period(inclination: float) -> float:
        run = system.integrate(start(state, mu, i=inclination), 6000.0, output=1.0, integrator=_COARSE)
        return abs(2 * np.pi / float(orbit_precession(run).nodal))

    with ThreadPoolExecutor() as pool:
        return np.array(list(pool.map(period, inclinations)))
