"""Construction of a published binary in a given frame and given units."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..base.arguments import options_of, refuse_unknown
from ..base.units import USUAL as UNITS
from ..base.units import Units
from ..errors import InvalidInput
from ..frames import turn_state
from ..model.force import rebuilt
from ..model.state import State
from ..motion.system import System
from ..setups.binary import binary
from ..setups.component import Component
from ._published import Published
from ._sun import with_sun

#: CODATA 2018, 6.67430e-11 m^3 kg^-1 s^-2, in km^3 kg^-1 hour^-2.
G = 6.67430e-11 * 1e-9 * 3600.0**2
Frame = Literal["ecliptic", "equatorial", "orbit"]
#: Whether results are Quantities: ``True`` for km, hour, kg, or three other units.
UnitsChoice = bool | tuple[object, object, object]


def check_frame(frame: str) -> None:
    """Raise an error for a frame that is not one of the three."""
    if not isinstance(frame, str) or frame not in ("ecliptic", "equatorial", "orbit"):
        raise InvalidInput(f"frame is {frame!r}; expected 'ecliptic', 'equatorial' or 'orbit'")


def with_epoch(options: dict[str, Any], epoch: str | None) -> dict[str, Any]:
    """Return the options of the system with its epoch: the published one, or the caller's if none is published."""
    fixed = ("bodies", "G", "units", "frame")
    refuse_unknown(options, (name for name in options_of(System) if name not in fixed), "this system")
    given = options.get("epoch")
    if epoch is not None and given is not None:
        raise InvalidInput(f"epoch is {given!r}; expected none: the numbers of this system hold at its own, {epoch}")
    return {**options, "epoch": epoch if given is None else given}


def base_units(units: UnitsChoice) -> tuple[str, str, str] | None:
    """Return the units in which a system is built: none, or km, hour, kg. Invalid units raise an error."""
    return UNITS if Units(units).known else None


def in_units(system: System, state: State, units: UnitsChoice) -> tuple[System, State]:
    """Convert a system in km, hour, kg and its state to the given units."""
    wanted = Units(units)
    if not wanted.known or wanted == Units(UNITS):
        return system, state._named(system.names)
    # The forces take Quantities here, since plain numbers are in km, hour, kg.
    united = [
        force if force in system._functions() else rebuilt(described | force._notes(), system._units)
        for force, described in zip(system.forces, system._core.forces, strict=True)
    ]
    turned = System(system.bodies, system.G, units=wanted.names, forces=united, **system.options)
    # The system is rebuilt from its description, so that the bodies are in these units too.
    final = System._rebuild(turned._describe(), {force.name: force for force in system._functions()})
    return final, final._state(state._in(wanted))


def in_frame(state: State, facts: Published, frame: str) -> State:
    """Rotate a state from the frame of the published poles, or the orbit's, to a given frame."""
    if frame in ("orbit", facts.frame):
        return state
    return turn_state(state, facts.frame, frame)


def published_binary(
    facts: Published,
    primary: Component,
    secondary: Component,
    *,
    pole: tuple[float, float],
    frame: str,
    units: UnitsChoice,
    sun: bool = False,
    options: dict[str, Any],
    **orbit: Any,
) -> tuple[System, State]:
    """Set up a binary in km, hour, kg about a published pole (degrees)."""
    check_frame(frame)
    options = with_epoch(options, facts.epoch)
    lon, lat = np.radians(pole)
    system, state = binary(
        primary,
        secondary,
        pole=None if frame == "orbit" else (lon, lat),
        G=G,
        units=base_units(units),
        frame=frame,
        elements="mean",
        **orbit,
        **options,
    )
    system, state = in_units(system, in_frame(state, facts, frame), units)
    return with_sun(system, facts, sun, frame, pole), state
