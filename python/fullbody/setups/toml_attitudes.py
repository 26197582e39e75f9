"""Attitudes and spins in the tables ``[[body]]`` of a ``system.toml``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..frames import attitude as attitude_of_pole
from ..frames import rotate_pole
from ..model.state import State
from .toml_table import TomlTable

__all__ = ["ANGLES", "attitude", "flag", "spin"]

_Array = npt.NDArray[np.float64]

#: The keys of an attitude.
ANGLES = ("attitude", "angles", "pole", "pole_frame", "rotation_angle")


def attitude(table: TomlTable, frame: str | None = None) -> _Array:
    """Return the attitude of a body in a frame, or of a part, as a quaternion: none by default."""
    for key in ("rotation_angle", "pole_frame"):
        if key in table and "pole" not in table:
            raise table.fault(key, "is given without a pole; expected both")
    match table.one_of("attitude", "angles", "pole"):
        case "attitude":
            value = table.vector("attitude", "number", 4)
            if not value.any():
                raise table.fault("attitude", "is zero; expected a quaternion [w, x, y, z]")
            return value
        case "angles":
            zero = np.zeros((1, 3))
            angles = table.vector("angles", "angle", 3)
            return np.asarray(State.from_tait_bryan(zero, zero, angles[None]).attitude[0])
        case "pole":
            angle = table.number("rotation_angle", "angle") if "rotation_angle" in table else 0.0
            longitude, latitude = table.vector("pole", "angle", 2)
            if "pole_frame" in table:
                with table.naming("pole_frame"):
                    longitude, latitude = rotate_pole(longitude, latitude, table.text("pole_frame"), frame)
            with table.naming("pole"):
                return attitude_of_pole(longitude, latitude, angle)
    return np.array([1.0, 0.0, 0.0, 0.0])


def flag(table: TomlTable, key: str) -> bool:
    """Return a choice of yes or no; no by default."""
    value = table.content.get(key, False)
    if not isinstance(value, bool):
        raise table.fault(key, f"is {value!r}; expected true or false")
    return value


def spin(table: TomlTable) -> _Array:
    """Return the spin of a body in its own frame: none by default."""
    match table.one_of("spin", "rotation_period"):
        case "spin":
            return table.vector("spin", "spin", 3)
        case "rotation_period":
            period = table.number("rotation_period", "time")
            if period == 0.0:
                raise table.fault("rotation_period", "is 0; expected a time, negative for a retrograde spin")
            return np.array([0.0, 0.0, 2.0 * np.pi / period])
    return np.zeros(3)
