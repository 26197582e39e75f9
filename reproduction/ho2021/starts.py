"""The paper's initial state of 1999 KW4 with single changes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import KeplerElements, State, System, systems
from scipy.spatial.transform import Rotation

__all__ = ["ORBIT", "RATE", "SKY", "advanced", "normal", "rotated", "start"]

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
    """Return the start with another attitude of Beta, whose spin remains along its z-axis."""
    return state.replace(attitude=[state.attitude[0], attitude.as_quat(scalar_first=True)])


def advanced(system: System, state: State, hours: float, *, alpha: bool = True) -> State:
    """Return the start with all but the attitude and the spin of Beta advanced by the motion of some hours.

    Without ``alpha`` the attitude and the spin of Alpha are those of the start.
    """
    advanced_state = system.integrate(state, hours, output=[hours])[-1] if hours else state
    alpha_source = advanced_state if alpha else state
    return state.replace(
        position=advanced_state.position,
        velocity=advanced_state.velocity,
        attitude=[alpha_source.attitude[0], state.attitude[1]],
        spin=[alpha_source.spin[0], state.spin[1]],
    )


def normal(state: State) -> npt.NDArray[np.float64]:
    """Return the orbit's normal, a unit vector."""
    normal_vector = np.cross(state.position[1] - state.position[0], state.velocity[1] - state.velocity[0])
    return np.asarray(normal_vector / np.linalg.norm(normal_vector))
