"""A published binary in the frame and the units asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..base.arguments import options_of, refuse_unknown
from ..base.units import USUAL as UNITS
from ..base.units import Units
from ..errors import InvalidInput
from ..model.force import rebuilt
from ..setups.binary import binary
from ..setups.component import Component
from ._published import Published
from ._sun import with_sun

if TYPE_CHECKING:
    from ..model.state import State
    from ..motion.simulation import System

#: CODATA 2018, 6.67430e-11 m^3 kg^-1 s^-2, in km^3 kg^-1 hour^-2.
G = 6.67430e-11 * 1e-9 * 3600.0**2
Frame = Literal["ecliptic", "equatorial", "orbit"]
#: Whether results are Quantities: in km, hour, kg for ``True``, or in three other units.
UnitsChoice = bool | tuple[object, object, object]


def check_frame(frame: str) -> None:
    """Refuse a frame that is none of the three."""
    if not isinstance(frame, str) or frame not in ("ecliptic", "equatorial", "orbit"):
        raise InvalidInput(f"frame is {frame!r}; expected 'ecliptic', 'equatorial' or 'orbit'")


def with_epoch(options: dict[str, Any], epoch: str | None) -> dict[str, Any]:
    """The options of the system with its epoch: the published one, or the caller's where none is published."""
    from ..motion.simulation import System

    fixed = ("bodies", "G", "units", "frame")
    refuse_unknown(options, (name for name in options_of(System) if name not in fixed), "this system")
    given = options.get("epoch")
    if epoch is not None and given is not None:
        raise InvalidInput(f"epoch is {given!r}; expected none: the numbers of this system hold at its own, {epoch}")
    return {**options, "epoch": epoch if given is None else given}


def base_units(units: UnitsChoice) -> tuple[str, str, str] | None:
    """The units that a system is built in: none, or km, hour, kg. Units that are none raise an error."""
    return UNITS if Units(units).known else None


def in_units(system: System, state: State, units: UnitsChoice) -> tuple[System, State]:
    """A system in km, hour, kg and its state, in the units asked for."""
    from ..motion.simulation import System

    wanted = Units(units)
    if not wanted.known or wanted == Units(UNITS):
        return system, state._named(system.names)
    # With Quantities, for plain numbers are in km, hour, kg.
    united = [
        force if force in system._functions() else rebuilt(described, system._units)
        for force, described in zip(system.forces, system._core.forces, strict=True)
    ]
    turned = System(system.bodies, system.G, units=wanted.names, forces=united, **system.options)
    # It is rebuilt from its description, so that the bodies are in these units too.
    final = System._rebuild(turned._describe(), {force.name: force for force in system._functions()})
    return final, final._state(state._in(wanted))


def in_frame(state: State, facts: Published, frame: str) -> State:
    """A state in the frame of the published poles, or the orbit's, in the frame asked for."""
    if frame in ("orbit", facts.frame):
        return state
    from ..frames import turn_state

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
    """A binary in km, hour, kg about a published pole (degrees)."""
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
