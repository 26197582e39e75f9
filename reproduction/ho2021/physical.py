"""The paper's bodies on the physical, prograde orbit (relaxed, nominal, excited), beside the paper's own state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import Component, KeplerElements, Run, State, System, binary, systems
from fullbody.observables import libration, obliquity
from scipy.spatial.transform import Rotation

from .starts import ORBIT, normal, rotated, start

__all__ = ["EQUATOR_IN_ORBIT", "HOURS", "ORBIT_IN_EQUATOR", "PAPER", "Motion", "motions", "states"]

_Array = npt.NDArray[np.float64]

#: The paper's start; the same with its orbit in the plane of Beta's equator; with Beta's equator in that of its orbit.
PAPER, ORBIT_IN_EQUATOR = "the paper's", "the paper's, i = 180 deg"
EQUATOR_IN_ORBIT = "the paper's, Beta rotated"
#: The length of the runs in hours, some 115 revolutions.
HOURS = 2000.0
#: The initial eccentricity of the excited state, and the initial angle of its libration in degrees.
_EXCITED_E, _EXCITED_LIBRATION = 0.03, 10.0


@dataclass(frozen=True, slots=True)
class Motion:
    """The motion from a state over ``HOURS``."""

    #: A description of the start.
    start: str
    #: Range of the osculating eccentricity.
    e: tuple[float, float]
    #: Half of peak to peak, degrees; NaN if Beta circulates.
    libration: float
    #: Range of Beta's spin, 1e-5 rad/s, (3, 2).
    spin: _Array
    #: Angles of the poles of Alpha and of Beta from the orbit's normal at the start, degrees.
    tilts: tuple[float, ...]


def states() -> dict[str, tuple[str, Any, State]]:
    """Return the states by name: a description, the system and the state."""
    paper_system, paper_state = systems.kw4_ho2021()
    system, nominal = _prograde(paper_system, paper_state)
    return {
        PAPER: ("retrograde to both spins, Beta's axes along the inertial ones", paper_system, paper_state),
        ORBIT_IN_EQUATOR: (
            "the same, the orbit rotated into the plane of Beta's equator",
            paper_system,
            start(paper_state, paper_system.mu(), i=180.0),
        ),
        EQUATOR_IN_ORBIT: (
            "the same, Beta's equator rotated into the plane of the orbit",
            paper_system,
            _equator_in_orbit(paper_state),
        ),
        "relaxed": (
            "circular orbit in Alpha's equator, Beta aligned and synchronous",
            system,
            _relaxed(system, nominal),
        ),
        "nominal": (
            "e = 0.0004, Alpha's pole tilted by 3.2 deg, Beta aligned, synchronous on average",
            system,
            nominal,
        ),
        "excited": (
            f"e = {_EXCITED_E}, Alpha's pole tilted by 3.2 deg, Beta {_EXCITED_LIBRATION:g} deg off the line to Alpha",
            system,
            _excited(system, nominal),
        ),
    }


def _prograde(system: System, state: State) -> tuple[System, State]:
    """Return the orbit in the xy-plane, Alpha's pole tilted from its normal, Beta aligned; osculating elements."""
    alpha, beta = system.bodies
    return binary(
        Component(
            semi_axes=alpha.fitted_ellipsoid().semi_axes,
            mass=alpha.mass,
            rotation_period=2 * np.pi / state.spin[0, 2],
            tilt=state.tait_bryan[0, 0],
            name=alpha.name,
        ),
        Component(semi_axes=beta.fitted_ellipsoid().semi_axes, mass=beta.mass, name=beta.name),
        semi_major_axis=ORBIT["a"],
        eccentricity=ORBIT["e"],
        mismatch_warning=np.inf,
        G=system.G,
    )


def _equator_in_orbit(state: State) -> State:
    """Return the start with Beta rotated by the smallest angle that brings its pole to that of the orbit."""
    pole = -normal(state)
    axis = np.cross([0.0, 0.0, 1.0], pole)
    return rotated(state, Rotation.from_rotvec(axis / np.linalg.norm(axis) * np.arccos(pole[2])))


def _relaxed(system: Any, state: State) -> State:
    """Return the circular orbit for the actual force, averaged over a rotation of Alpha."""
    alpha, beta = system.bodies
    rotation = 2 * np.pi / state.spin[0, 2]
    return binary(
        Component(semi_axes=alpha.shape.semi_axes, mass=alpha.mass, rotation_period=rotation),
        Component(semi_axes=beta.shape.semi_axes, mass=beta.mass),
        semi_major_axis=np.linalg.norm(state.position[1] - state.position[0]),
        elements="mean",
        G=system.G,
    )[1]


def _excited(system: Any, state: State) -> State:
    """Return an eccentric orbit with the long axis of Beta at an angle to the line of the centres."""
    orbit = KeplerElements(a=ORBIT["a"], e=_EXCITED_E, i=0.0, Omega=0.0, omega=0.0, M=0.0)
    r, v = orbit.to_cartesian(system.mu())
    m = [body.mass for body in system.bodies]
    share = np.array([-m[1], m[0]])[:, None] / sum(m)
    half = np.deg2rad(_EXCITED_LIBRATION) / 2
    attitude = [state.attitude[0], [np.cos(half), 0.0, 0.0, np.sin(half)]]
    return state.replace(position=share * r, velocity=share * v, attitude=attitude)


def motions() -> tuple[dict[str, Motion], dict[str, Run]]:
    """Return all states by name, run and measured, and their runs."""
    results, runs = {}, {}
    for name, (description, system, state) in states().items():
        run = runs[name] = system.integrate(state, HOURS, output=0.1)
        e = run.elements().e
        amplitude = libration(run).amplitude
        spin = run.spin[:, 1] * 1e5 / 3600.0
        results[name] = Motion(
            start=description,
            e=(float(e.min()), float(e.max())),
            libration=float("nan") if amplitude is None else float(np.rad2deg(amplitude)),
            spin=np.stack([spin.min(axis=0), spin.max(axis=0)], axis=1),
            tilts=tuple(float(np.rad2deg(obliquity(run, body=k, about=1 - k)[0])) for k in (0, 1)),
        )
    return results, runs
