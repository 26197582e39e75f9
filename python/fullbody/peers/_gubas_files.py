"""The two layouts of GUBAS's input, read into one set-up in km, s, kg."""

from __future__ import annotations

import re
from collections.abc import Callable
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

from ..base.rotations import is_rotation
from ._text import fail, not_negative, number, positive, read_lines

_Array = npt.NDArray[np.float64]
_Kind = Callable[[Any, int, str, str], float]


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
#: Units of an angle in a comment, and not of a rate.
_ANGLES = re.compile(r"\b(deg|rad)(?:rees?|ians?)?\b(?!\s*/|\s+per\b)", re.IGNORECASE)


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

    def has(self, section: str, option: str) -> bool:
        """Whether an option is there."""
        return self._parser.has_option(section, option)

    def number(self, section: str, option: str, kind: _Kind = number) -> float:
        """A number of a section."""
        if not self.has(section, option):
            fail(self.path, None, f"no {option!r} in the section [{section}]")
        return kind(self.path, self.line(section, option), self._parser.get(section, option), option)

    def asks_for(self, section: str, option: str) -> bool:
        """Whether a switch is on; without the option it is off."""
        return self.has(section, option) and self.flag(section, option, (0, 1)) == 1

    def flag(self, section: str, option: str, allowed: tuple[int, ...]) -> int:
        """A whole number out of a few."""
        value = self.number(section, option)
        if value not in allowed:
            fail(self.path, self.line(section, option), f"{option} is {value:g}; expected one of {allowed}")
        return int(value)

    def angles(self, section: str) -> set[str]:
        """What the comments of a section say that angles are in: "degree", "radian", both or neither."""
        own = ""
        said: set[str] = set()
        for text in self._lines:
            if text.strip().startswith("["):
                own = text.strip()
            elif own.startswith(f"[{section}]") and (comment := re.search("[#;](.*)", text)):
                said.update({"deg": "degree", "rad": "radian"}[unit.lower()] for unit in _ANGLES.findall(comment[1]))
        return said


def read_config(path: Any, euler: str | None) -> tuple[Setup, str | None]:
    """A ``.cfg``, and what is doubtful about its angles."""
    cfg = _Config(path)
    start, body = "Initial Conditions", "Body Model Definitions"
    _refuse_others(cfg, start)
    shapes = []
    for name in ("Primary", "Secondary"):
        shapes.append(cfg.flag(body, f"{name} Shape Flag", (0, 1, 2)))
        if shapes[-1] == 2:
            fail(path, cfg.line(body, f"{name} Shape Flag"), _POLYHEDRON)
    axes = [
        # Of a sphere's axes the first one counts.
        [
            cfg.number(body, f"{name} Semi-{size} Axis", positive if flag or size == "Major" else number) / 1000.0
            for size in ("Major", "Intermediate", "Minor")
        ]
        for name, flag in zip(("Primary", "Secondary"), shapes, strict=True)
    ]
    vectors = {
        name: np.array([cfg.number(start, f"{name} {axis}") for axis in "XYZ"])
        for name in (
            "Relative Position", "Relative Velocity", "Primary Angular Velocity", "Secondary Angular Velocity"
        )
    }  # fmt: skip
    density = [cfg.number(body, f"{name} Density", positive) * 1e12 for name in ("Primary", "Secondary")]
    turns = {name: _turn(cfg, start, name) for name in ("A into N", "B into A")}
    unit, doubt = euler, None
    if euler is None and any(turn.shape == (3,) and turn.any() for turn in turns.values()):
        unit, doubt = _unit_of_angles(cfg, start)
    matrices = {name: turn if turn.ndim == 2 else _from_angles(turn, unit) for name, turn in turns.items()}
    setup = Setup(
        G=cfg.number("Gravity Parameter", "G", not_negative) / 1e9,
        shapes=(shapes[0], shapes[1]),
        semi_axes=np.array(axes),
        densities=(density[0], density[1]),
        start=cfg.number("Integration Settings", "Start Time")
        if cfg.has("Integration Settings", "Start Time")
        else 0.0,
        position=vectors["Relative Position"] / 1000.0,
        velocity=vectors["Relative Velocity"] / 1000.0,
        spin_a=vectors["Primary Angular Velocity"],
        spin_b=vectors["Secondary Angular Velocity"],
        a_to_n=matrices["A into N"],
        b_to_a=matrices["B into A"],
    )
    return setup, doubt


def _refuse_others(cfg: _Config, start: str) -> None:
    """Refuse what this package does not have."""
    if cfg.asks_for(start, "Fahnestock Input File Flag"):
        fail(
            cfg.path,
            cfg.line(start, "Fahnestock Input File Flag"),
            "the file asks for initial conditions of separate files (Fahnestock's), which fullbody does not read",
        )
    extra = "Additional Forces and Perturbations"
    for option in ("Flyby", "Heliocentric Orbit", "Solar Gravity", "Tidal Torque"):
        if cfg.asks_for(extra, option):
            fail(cfg.path, cfg.line(extra, option), f"the file asks for {option!r}, which fullbody does not have")


def _turn(cfg: _Config, section: str, name: str) -> _Array:
    """A rotation matrix (3, 3), or Euler angles (3,)."""
    if cfg.flag(section, f"{name} Euler Flag", (0, 1)):
        return np.array([cfg.number(section, f"{name} Euler {i} {axis}") for i, axis in ((1, "X"), (2, "Y"), (3, "Z"))])
    entries = [[cfg.number(section, f"{name} ({i},{j})") for j in (1, 2, 3)] for i in (1, 2, 3)]
    return _rotation(cfg.path, cfg.line(section, f"{name} (1,1)"), name, np.array(entries))


def _rotation(path: Any, line: int, name: str, matrix: _Array) -> _Array:
    # Files written with a handful of digits are welcome.
    if not is_rotation(matrix, 1e-4):
        fail(path, line, f"{name} is no rotation matrix: {matrix.tolist()}; expected one to 1e-4")
    return matrix


def _unit_of_angles(cfg: _Config, section: str) -> tuple[str, str | None]:
    """The unit of angles by the comments, which differ between versions, and a doubt about it."""
    said = cfg.angles(section)
    ask = "say euler='degree' or euler='radian'"
    if len(said) == 2:
        fail(cfg.path, None, f"comments of [{section}] speak of degrees and of radians, and angles are given; {ask}")
    if said == {"degree"}:
        return "degree", f"taken in degrees as its comments say; GUBAS itself takes radians: {ask}"
    if said == {"radian"}:
        return "radian", None
    return "radian", f"taken in radians as GUBAS takes them; no comment of the file says what they are in: {ask}"


def _from_angles(angles: _Array, unit: str | None) -> _Array:
    x, y, z = np.radians(angles) if unit == "degree" else angles
    # About x, then the new y, then the new z: Rx Ry Rz turns components along the last axes into the first.
    rx = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    ry = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    rz = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    matrix: _Array = rx @ ry @ rz
    return matrix


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

    def value(index: int, what: str, kind: _Kind = number) -> float:
        return kind(path, index + 1, lines[index].split("#")[0].strip(), what)

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
    first = _BEFORE + _FILES + 1
    a_to_n, b_to_a = (
        _rotation(path, first + k, name, state[k : k + 9].reshape(3, 3))
        for name, k in (("A into N", 12), ("B into A", 21))
    )
    # Of a sphere's axes the first one counts.
    kinds = [positive if shapes[k // 3] or k % 3 == 0 else number for k in range(6)]
    axes = [value(4 + k, "a semi-axis", kind) for k, kind in enumerate(kinds)]
    return Setup(
        G=value(0, "G", not_negative),
        shapes=(shapes[0], shapes[1]),
        semi_axes=np.array(axes).reshape(2, 3) / 1000.0,
        densities=(value(12, "the primary's density", positive), value(13, "the secondary's density", positive)),
        start=value(14, "the start time"),
        position=state[0:3],
        velocity=state[3:6],
        spin_a=state[6:9],
        # The secondary's spin is written along the primary's axes here.
        spin_b=b_to_a.T @ state[9:12],
        a_to_n=a_to_n,
        b_to_a=b_to_a,
    )
