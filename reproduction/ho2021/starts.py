"""The paper's start of 1999 KW4, changed in one thing."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import KeplerElements, State, System, systems
from scipy.spatial.transform import Rotation

__all__ = ["ORBIT", "RATE", "SKY", "ahead", "normal", "rotated", "start"]

_PUBLISHED = systems.published("kw4_ho2021")
#: Beta's stated rate of spin, rad/h, and its stated orbit: size and shape, and the angles in degrees.
RATE = _PUBLISHED["spin of Beta"][2]
ORBIT = {"a": _PUBLISHED["semi-major axis of Beta"], "e": _PUBLISHED["eccentricity of Beta"], "M": 0.0}
SKY = {
    "i": _PUBLISHED["inclination of Beta"],
    "Omega": _PUBLISHED["ascending node of Beta"],
    "omega": _PUBLISHED["argument of periapsis of Beta"],
}


def start(state: State, mu: float, *, spin: float | None = None, **elements: float) -> State:
    """Return the start with another rate of Beta's spin, rad/h, or other elements of the orbit, angles in degrees."""
    changes: dict[str, Any] = {}
    if spin is not None:
        changes["spin"] = [state.spin[0], [0.0, 0.0, spin]]
    if elements:
        orbit = {**ORBIT, **{name: np.deg2rad(angle) for name, angle in SKY.items()}}
        orbit.update({name: np.deg2rad(value) for name, value in elements.items()})
        r, v = KeplerElements(**orbit).to_cartesian(mu)
        changes["position"], changes["velocity"] = [state.position[0], r], [state.velocity[0], v]
    return state.replace(**changes)


def rotated(state: State, attitude: Rotation) -> State:
    """Return the start with another attitude of Beta; its spin stays along its own z-axis."""
    return state.replace(attitude=[state.attitude[0], attitude.as_quat(scalar_first=True)])


def ahead(system: System, state: State, hours: float, *, alpha: bool = True) -> State:
    """Return the start with all but Beta's attitude and spin taken some hours later from the motion itself.

    ``alpha`` tells whether Alpha's attitude and spin go on too.
    """
    later = system.integrate(state, hours, output=[hours])[-1] if hours else state
    first = later if alpha else state
    return state.replace(
        position=later.position,
        velocity=later.velocity,
        attitude=[first.attitude[0], state.attitude[1]],
        spin=[first.spin[0], state.spin[1]],
    )


def normal(state: State) -> npt.NDArray[np.float64]:
    """Return the orbit's normal, a unit vector."""
    across = np.cross(state.position[1] - state.position[0], state.velocity[1] - state.velocity[0])
    return np.asarray(across / np.linalg.norm(across))
