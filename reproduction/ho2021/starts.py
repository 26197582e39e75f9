"""Beta's spin and the inclination's period as functions of the start: which start, if any, gives what is printed."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import systems
from fullbody.bodies import Body, Ellipsoid
from fullbody.commands.kw4 import printed
from fullbody.commands.kw4 import year as kw4
from fullbody.integrators import SymplecticSplitting, Verner98
from fullbody.state import State
from fullbody.system import System

from . import paper

__all__ = [
    "NODAL_HOURS",
    "SCANS",
    "Agreement",
    "Minimum",
    "Scan",
    "Search",
    "agreement",
    "nodal_period",
    "scan",
    "search",
    "year_from",
]

_Array = npt.NDArray[np.float64]

#: The printed ranges, 1e-5 rad/s, (3, 2).
PRINTED = np.array([printed.SPIN[axis] for axis in "xyz"])
#: Scans and the search need four digits only.
_COARSE = Verner98(1e-10, 1e-10)
#: Length of the runs that the node's period is taken from: about three rounds.
NODAL_HOURS = 12000.0


@dataclass(frozen=True, slots=True)
class Scan:
    """Ranges of Beta's spin over the first 200 h along a family of starts.

    Attributes
    ----------
    name, unit : str
        Of the family's parameter.
    start : float
        The parameter of the paper's start.
    values : ndarray, (K,)
        Of the parameter, closer together where the printed ranges are nearest.
    ranges : ndarray, (K, 3, 2)
        Smallest and largest component, 1e-5 rad/s.
    """

    name: str
    unit: str
    start: float
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
class Minimum:
    """An orientation of Beta that no small turn improves.

    Attributes
    ----------
    origin : str
        What it was refined from.
    angles : tuple
        The paper's phi, theta, psi, degrees.
    turn, off_normal : float
        Angle of the rotation from the paper's start, above zero in the sense of the orbital motion, and of its axis
        from the orbit's normal, degrees.
    ranges : ndarray, (3, 2)
    misfit : float
        Largest difference from the printed numbers, 1e-5 rad/s.
    """

    origin: str
    angles: tuple[float, float, float]
    turn: float
    off_normal: float
    ranges: _Array
    misfit: float

    @property
    def equal(self) -> bool:
        """Whether all six round to the printed digits."""
        return bool(np.all(np.round(self.ranges, 2) == PRINTED))


@dataclass(frozen=True, slots=True)
class Search:
    """The orientations of Beta whose spin comes nearest to the printed ranges, the best first.

    Attributes
    ----------
    tried : int
        Orientations spread evenly over all there are, before the best were refined.
    minima : list of Minimum
    """

    tried: int
    minima: list[Minimum]


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
    from fullbody.elements import KeplerElements

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


def _range_of(system: Any, state: State, spacing: float = 0.1) -> _Array:
    return kw4.spin_range(system, state, _COARSE, spacing)


def _normal(state: State) -> _Array:
    """The orbit's normal."""
    normal = np.cross(state.position[1] - state.position[0], state.velocity[1] - state.velocity[0])
    return np.asarray(normal / np.linalg.norm(normal))


#: Families of starts: unit of the parameter, its value and its range about that, and what makes the start from the
#: paper's, mu and the parameter.
SCANS: dict[str, tuple[str, float, float, Callable[[State, float, float], State]]] = {
    "mean anomaly": ("deg", 0.0, 90.0, lambda state, mu, x: start(state, mu, M=x)),
    "turn about the orbit's normal": (
        "deg",
        0.0,
        90.0,
        lambda state, mu, x: start(state, mu, _rotation().from_rotvec(np.deg2rad(x) * _normal(state))),
    ),
    "turn about Beta's pole": (
        "deg",
        0.0,
        90.0,
        lambda state, mu, x: start(state, mu, _rotation().from_euler("z", x, degrees=True)),
    ),
    "Beta's rate of spin": (
        "rad/h",
        systems.ho2021.KW4_SPINS[1],
        0.05,
        lambda state, mu, x: start(state, mu, spin=x),
    ),
}


def _rotation() -> Any:
    from scipy.spatial.transform import Rotation

    return Rotation


def scan(name: str, steps: int = 18) -> Scan:
    """Beta's spin along one of the families in ``SCANS``: ``steps`` to either side, then finer about the best."""
    system, state = systems.kw4_ho2021()
    mu = system.mu()
    unit, middle, reach, make = SCANS[name]

    def ranges(values: Any) -> _Array:
        # Integration leaves Python's lock alone, so threads share the work.
        with ThreadPoolExecutor() as pool:
            return np.array(list(pool.map(lambda x: _range_of(system, make(state, mu, x), 0.05), values)))

    step = reach / steps
    values: _Array = middle + step * np.arange(-steps, steps + 1, dtype=np.float64)
    found = Scan(name, unit, middle, values, ranges(values))
    for _ in range(2):
        step /= 5
        near = found.best[0] + step * np.array([-4, -3, -2, -1, 1, 2, 3, 4])
        values = np.concatenate([found.values, near])
        both, order = np.concatenate([found.ranges, ranges(near)]), np.argsort(values)
        found = Scan(name, unit, middle, np.asarray(values[order], dtype=np.float64), both[order])
    return found


def search(scans: list[Scan], tried: int = 512, refined: int = 8) -> Search:
    """Look over all orientations of Beta, its spin along its own z-axis as stated, for the printed ranges.

    The best ``refined`` of ``tried`` evenly spread ones, and the best of each scan that turns Beta, are refined.
    """
    from scipy.optimize import least_squares, minimize
    from scipy.stats import qmc

    rotation = _rotation()
    system, state = systems.kw4_ho2021()
    mu = system.mu()

    def ranges(attitude: Any, spacing: float = 0.1) -> _Array:
        return _range_of(system, start(state, mu, attitude), spacing)

    # Shoemake's uniform quaternions from evenly spread points.
    a, b, c = 2 * np.pi * qmc.Sobol(3, rng=1).random(tried).T
    low, high = np.sqrt(1 - a / (2 * np.pi)), np.sqrt(a / (2 * np.pi))
    quaternions = np.stack([low * np.sin(b), low * np.cos(b), high * np.sin(c), high * np.cos(c)], axis=1)
    everywhere = [rotation.from_quat(q) for q in quaternions]
    with ThreadPoolExecutor() as pool:
        misfits = np.array(list(pool.map(lambda q: np.abs(ranges(q) - PRINTED).max(), everywhere)))
    candidates = [("evenly spread", everywhere[k]) for k in np.argsort(misfits)[:refined]]
    for found in scans:
        if "turn" in found.name:
            turned = SCANS[found.name][3](state, mu, found.best[0]).attitude[1]
            candidates.append((f"scan: {found.name}", rotation.from_quat(turned, scalar_first=True)))

    def refine(candidate: tuple[str, Any]) -> Minimum:
        origin, attitude = candidate

        def misses(d: Any, of: Any) -> _Array:
            return np.asarray((ranges(rotation.from_rotvec(d) * of, 0.05) - PRINTED).ravel())

        # The extremes change place, so that the misfit has kinks: Gauss-Newton first, a simplex after it.
        slid = least_squares(misses, np.zeros(3), args=(attitude,), diff_step=1e-3, x_scale=0.1, max_nfev=20)
        attitude = rotation.from_rotvec(slid.x) * attitude
        simplex = np.vstack([np.zeros(3), 0.05 * np.eye(3)])
        options = {"initial_simplex": simplex, "maxfev": 150, "xatol": 1e-4, "fatol": 1e-6}
        settled = minimize(
            lambda d: float(np.sum(misses(d, attitude) ** 2)), np.zeros(3), method="Nelder-Mead", options=options
        )
        return _minimum(origin, rotation.from_rotvec(settled.x) * attitude)

    def _minimum(origin: str, attitude: Any) -> Minimum:
        psi, theta, phi = (float(x) for x in attitude.as_euler("ZYX", degrees=True))
        spin = ranges(attitude, 0.02)
        turn = attitude.as_rotvec()
        along, size = float(turn @ _normal(state)), float(np.linalg.norm(turn))
        off = float(np.rad2deg(np.arccos(np.clip(abs(along) / size, 0.0, 1.0))))
        misfit = float(np.abs(spin - PRINTED).max())
        return Minimum(origin, (phi, theta, psi), float(np.rad2deg(np.copysign(size, along))), off, spin, misfit)

    with ThreadPoolExecutor() as pool:
        minima = sorted(pool.map(refine, candidates), key=lambda minimum: minimum.misfit)
    return Search(tried, minima)


def year_from(angles: tuple[float, float, float] | None = None, anomaly: float | None = None) -> kw4.Numbers:
    """The ellipsoids' year when Beta starts at other phi, theta, psi, or at another mean anomaly; degrees."""
    system, state = systems.kw4_ho2021(units=True)
    plain, first = systems.kw4_ho2021()
    turned = None if angles is None else _rotation().from_euler("ZYX", angles[::-1], degrees=True)
    moved = start(first, plain.mu(), turned, **({} if anomaly is None else {"M": anomaly}))
    moved = state.replace(
        attitude=moved.attitude,
        position=moved.position * state.position.unit,
        velocity=moved.velocity * state.velocity.unit,
    )
    return kw4.measure(system.integrate(moved, printed.YEAR_HOURS, integrator=Verner98(1e-12, 1e-12)))


def with_printed_axes(shape: Any) -> kw4.Numbers:
    """A year from the semi-axes as Table 2 prints them, by the focal rule."""
    system, state = systems.kw4_ho2021(shape, units=True)
    bodies = [
        Body(Ellipsoid(a, a if shape == "spheroid" else b, c), mass=body.mass, name=body.name)
        for body, (a, b, c) in zip(system.bodies, paper.KW4_AXES, strict=True)
    ]
    return kw4.measure(System(bodies, G=system.G, units=system.units).integrate(state, printed.YEAR_HOURS))


def agreement(until: float = printed.YEAR_HOURS) -> list[Agreement]:
    """Both quantities by two methods of gravity, two kinds of integrator and two charts of the attitudes.

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

    def compute(way: tuple[str, str, Any, Any]) -> Agreement:
        gravity, name, integrator, chart = way
        system, state = systems.kw4_ho2021(gravity=gravity, attitude_chart=chart)
        ranges = kw4.spin_range(system, state, integrator)
        period = float("nan")
        if until > printed.SPIN_HOURS:
            run = system.integrate(state, until, output=1.0, integrator=integrator)
            period = kw4.between_maxima(run.time, kw4.inclination_to_first(run))
        return Agreement(gravity, name, chart, ranges, period)

    with ThreadPoolExecutor() as pool:
        return list(pool.map(compute, ways))


def nodal_period(shape: Any, inclinations: _Array) -> _Array:
    """Period of the node on the total angular momentum's plane, hours, by the orbit's inclination in degrees (2, K).

    Fitted to the first half of ``NODAL_HOURS``, and to all of them: where the two differ the node does not go round
    evenly.
    """
    system, state = systems.kw4_ho2021(shape)
    mu = system.mu()

    def period(inclination: float) -> list[float]:
        run = system.integrate(start(state, mu, i=inclination), NODAL_HOURS, output=2.0, integrator=_COARSE)
        # By hand: the plane of a steep orbit turns too far for the longitudes that observables count by.
        r, v = (x[:, 1] - x[:, 0] for x in (run.position, run.velocity))
        axis = run.angular_momentum[0] / np.linalg.norm(run.angular_momentum[0])
        east = np.cross(axis, [1.0, 0.0, 0.0])
        normal = np.cross(r, v)
        node = np.unwrap(np.arctan2(normal @ np.cross(axis, east), normal @ east))
        parts = (slice(len(node) // 2 + 1), slice(None))
        rates = [np.polynomial.Polynomial.fit(run.time[part], node[part], 1).convert().coef[1] for part in parts]
        return [float(abs(2 * np.pi / rate)) for rate in rates]

    with ThreadPoolExecutor() as pool:
        return np.array(list(pool.map(period, inclinations))).T
