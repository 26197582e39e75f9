"""A published pair in the frame and the units asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._arguments import options_of, refuse_unknown
from ..errors import InvalidInput
from ..pair import Component, binary
from ._published import Published

if TYPE_CHECKING:
    from ..state import State
    from ..system import System

#: CODATA 2018, 6.67430e-11 m^3 kg^-1 s^-2, in km^3 kg^-1 hour^-2.
G = 6.67430e-11 * 1e-9 * 3600.0**2
UNITS = ("km", "hour", "kg")
Frame = Literal["ecliptic", "equatorial", "orbit"]


def check_frame(frame: str) -> None:
    """Refuse a frame that is none of the three."""
    if frame not in ("ecliptic", "equatorial", "orbit"):
        raise InvalidInput(f"frame is {frame!r}; expected 'ecliptic', 'equatorial' or 'orbit'")


def in_frame(state: State, facts: Published, frame: str) -> State:
    """A state in the frame of the published poles, or the orbit's, in the frame asked for."""
    if frame in ("orbit", facts.frame):
        return state
    from ..frames import turn_state

    return turn_state(state, facts.frame, frame)


def pair(
    facts: Published,
    primary: Component,
    secondary: Component,
    *,
    pole: tuple[float, float],
    frame: str,
    units: bool,
    options: dict[str, Any],
    **orbit: Any,
) -> tuple[System, State]:
    """A binary in km, hour, kg about a published pole (degrees)."""
    from ..system import System

    check_frame(frame)
    fixed = ("bodies", "G", "units", "epoch", "frame")
    refuse_unknown(options, (name for name in options_of(System) if name not in fixed), "this system")
    lon, lat = np.radians(pole)
    system, state = binary(
        primary,
        secondary,
        pole=None if frame == "orbit" else (lon, lat),
        G=G,
        units=UNITS if units else None,
        epoch=facts.epoch,
        frame=frame,
        elements="mean",
        **orbit,
        **options,
    )
    return system, in_frame(state, facts, frame)
