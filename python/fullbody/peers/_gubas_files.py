"""The two layouts of GUBAS's input, read into one set-up in km, s, kg."""

from __future__ import annotations

from configparser import (
    ConfigParser,
    DuplicateOptionError,
    DuplicateSectionError,
    MissingSectionHeaderError,
    ParsingError,
)
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._text import fail, number, read_lines

_Array = npt.NDArray[np.float64]


@dataclass
class Setup:
    """Relative state along the primary's axes; spins along each body's own; km, s, kg, rad."""

    G: float
    shapes: tuple[int, int]
    semi_axes: _Array
    densities: tuple[float, float]
    start: float
    position: _Array
    velocity: _Array
    spin_a: _Array
    spin_b: _Array
    a_to_n: _Array
    b_to_a: _Array


_POLYHEDRON = "the file asks for a polyhedron, which fullbody does not have"


class _Config:
    """A ``.cfg`` that knows its lines."""

    def __init__(self, path: Any) -> None:
        self.path = path
        self._lines = read_lines(path)
        # No interpolation: a per cent sign in a case name means nothing.
        self._parser = ConfigParser(interpolation=None, inline_comment_prefixes=("#", ";"))
        try:
            self._parser.read_string("\n".join(self._lines))
        except MissingSectionHeaderError as error:
            fail(path, error.lineno, "text before the first [section]")
        except (DuplicateOptionError, DuplicateSectionError) as error:
            fail(path, error.lineno, str(error).split("]: ", 1)[-1])
        except ParsingError as error:
            fail(path, error.errors[0][0], f"{self._lines[error.errors[0][0] - 1].strip()!r} is no 'name: value'")

    def line(self, section: str, option: str) -> int:
        """Where an option stands."""
        inside = False
        for line, text in enumerate(self._lines, start=1):
            stripped = text.strip()
            if stripped.startswith("["):
                inside = stripped.startswith(f"[{section}]")
            elif inside and stripped.replace("=", ":").split(":")[0].strip().lower() == option.lower():
                return line
        return 0

    def number(self, section: str, option: str, default: float | None = None) -> float:
        """A number of a section."""
        if not self._parser.has_option(section, option):
            if default is not None:
                return default
            fail(self.path, None, f"no {option!r} in the section [{section}]")
        return number(self.path, self.line(section, option), self._parser.get(section, option), option)

    def flag(self, section: str, option: str, allowed: tuple[int, ...], default: int | None = None) -> int:
        """A whole number out of a few."""
        value = self.number(section, option, default)
        if value not in allowed:
            fail(self.path, self.line(section, option), f"{option} is {value:g}; expected one of {allowed}")
        return int(value)


def read_config(path: Any, angle: str) -> tuple[Setup, bool]:
    """A ``.cfg``, and whether it turns bodies by Euler angles."""
    cfg = _Config(path)
    start, body, extra = "Initial Conditions", "Body Model Definitions", "Additional Forces and Perturbations"
    if cfg.flag(start, "Fahnestock Input File Flag", (0, 1), 0):
        line = cfg.line(start, "Fahnestock Input File Flag")
        fail(
            path,
            line,
            "the file asks for initial conditions of separate files (Fahnestock's), which fullbody does not read",
        )
    for option in ("Flyby", "Heliocentric Orbit", "Solar Gravity", "Tidal Torque"):
        if cfg.flag(extra, option, (0, 1), 0):
            fail(path, cfg.line(extra, option), f"the file asks for {option!r}, which fullbody does not have")
    shapes = []
    for name in ("Primary", "Secondary"):
        shapes.append(cfg.flag(body, f"{name} Shape Flag", (0, 1, 2)))
        if shapes[-1] == 2:
            fail(path, cfg.line(body, f"{name} Shape Flag"), _POLYHEDRON)
    axes = [
        [cfg.number(body, f"{name} Semi-{size} Axis") / 1000.0 for size in ("Major", "Intermediate", "Minor")]
        for name in ("Primary", "Secondary")
    ]
    vectors = {
        name: np.array([cfg.number(start, f"{name} {axis}") for axis in "XYZ"])
        for name in (
            "Relative Position", "Relative Velocity", "Primary Angular Velocity", "Secondary Angular Velocity"
        )
    }  # fmt: skip
    a_to_n, turned_a = _matrix(cfg, start, "A into N", angle)
    b_to_a, turned_b = _matrix(cfg, start, "B into A", angle)
    setup = Setup(
        G=cfg.number("Gravity Parameter", "G") / 1e9,
        shapes=(shapes[0], shapes[1]),
        semi_axes=np.array(axes),
        densities=(cfg.number(body, "Primary Density") * 1e12, cfg.number(body, "Secondary Density") * 1e12),
        start=cfg.number("Integration Settings", "Start Time", 0.0),
        position=vectors["Relative Position"] / 1000.0,
        velocity=vectors["Relative Velocity"] / 1000.0,
        spin_a=vectors["Primary Angular Velocity"],
        spin_b=vectors["Secondary Angular Velocity"],
        a_to_n=a_to_n,
        b_to_a=b_to_a,
    )
    return setup, turned_a or turned_b


def _matrix(cfg: _Config, section: str, name: str, angle: str) -> tuple[_Array, bool]:
    """A rotation matrix, and whether it comes from angles other than zero."""
    if not cfg.flag(section, f"{name} Euler Flag", (0, 1), 0):
        entries = [[cfg.number(section, f"{name} ({i},{j})") for j in (1, 2, 3)] for i in (1, 2, 3)]
        return np.array(entries), False
    angles = np.array([cfg.number(section, f"{name} Euler {i} {axis}") for i, axis in ((1, "X"), (2, "Y"), (3, "Z"))])
    x, y, z = np.radians(angles) if angle == "degree" else angles
    # About x, then the new y, then the new z: Rx Ry Rz turns components along the last axes into the first.
    rx = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    ry = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    rz = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    return rx @ ry @ rz, bool(angles.any())


#: Lines of ``ic_input.txt``: numbers, file names, the state, then settings whose number tells the layout.
_BEFORE, _FILES, _STATE = 16, 8, 30
#: Switches of each layout after four settings of the integrator, by the number of lines after the state.
_TOGGLES = {
    15: ("the Sun's gravity", "tidal torques"),
    23: ("a fly-by", "the Sun's gravity", "tidal torques"),
    31: ("a fly-by", "a heliocentric orbit", "the Sun's gravity", "tidal torques"),
}


def read_numbers(path: Any) -> Setup:
    """An ``ic_input.txt``."""
    lines = read_lines(path)
    while lines and not lines[-1].strip():
        lines.pop()
    rest = len(lines) - _BEFORE - _FILES - _STATE
    if rest not in _TOGGLES:
        known = ", ".join(str(_BEFORE + _FILES + _STATE + count) for count in _TOGGLES)
        fail(path, len(lines), f"the file ends after {len(lines)} lines; GUBAS writes {known}")

    def value(index: int, what: str) -> float:
        return number(path, index + 1, lines[index].split("#")[0].strip(), what)

    def values(first: int, count: int, what: str) -> _Array:
        return np.array([value(first + k, what) for k in range(count)])

    toggles = _BEFORE + _FILES + _STATE + 4
    for k, what in enumerate(_TOGGLES[rest]):
        if value(toggles + k, "a switch") != 0:
            fail(path, toggles + k + 1, f"the file asks for {what}, which fullbody does not have")
    shapes = []
    for index in (10, 11):
        flag = value(index, "a shape flag")
        if flag == 2:
            fail(path, index + 1, _POLYHEDRON)
        if flag not in (0, 1):
            fail(path, index + 1, f"the shape flag is {flag:g}; expected 0 (sphere), 1 (ellipsoid) or 2 (polyhedron)")
        shapes.append(int(flag))
    state = values(_BEFORE + _FILES, _STATE, "a number of the state")
    b_to_a = state[21:30].reshape(3, 3)
    return Setup(
        G=value(0, "G"),
        shapes=(shapes[0], shapes[1]),
        semi_axes=values(4, 6, "a semi-axis").reshape(2, 3) / 1000.0,
        densities=(value(12, "the primary's density"), value(13, "the secondary's density")),
        start=value(14, "the start time"),
        position=state[0:3],
        velocity=state[3:6],
        spin_a=state[6:9],
        # The secondary's spin is written along the primary's axes here.
        spin_b=b_to_a.T @ state[9:12],
        a_to_n=state[12:21].reshape(3, 3),
        b_to_a=b_to_a,
    )
