"""Reading of GUBAS's input in its two layouts, as a start in km, s, kg."""

from __future__ import annotations

import re
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

from ..base import rotations
from ..base.atomic import as_path
from ..errors import InvalidInput
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, Sphere
from ._gubas_forces import Deformed, Orbit, Outside
from ._text import NOT_NEGATIVE, NUMBER, POSITIVE, Text, naming

_Array = npt.NDArray[np.float64]
_Shape = Ellipsoid | Sphere | Polyhedron


@dataclass
class Start:
    """A relative state along the primary's axes, with spins along each body's own axes, in km, s, kg, rad."""

    G: float
    shapes: tuple[_Shape, _Shape]
    densities: tuple[float, float]
    time: float
    position: _Array
    velocity: _Array
    spin_a: _Array
    spin_b: _Array
    a_to_n: _Array
    b_to_a: _Array
    outside: Outside


_TWO_SUNS = "the file asks for a heliocentric orbit and for the Sun of Hill's problem; expected one of the two"
#: The units of an angle in a comment, which are not part of the unit of a rate.
_ANGLES = re.compile(r"\b(deg|rad)(?:rees?|ians?)?\b(?!\s*/|\s+per\b)", re.IGNORECASE)


class _Config(Text):
    """A ``.cfg`` file: numbers by section and option."""

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        # Interpolation is switched off, since a per cent sign in a case name has no meaning.
        self._parser = ConfigParser(interpolation=None, inline_comment_prefixes=("#", ";"))
        try:
            self._parser.read_string("\n".join(self.lines))
        except MissingSectionHeaderError as error:
            self.fail(error.lineno, "text before the first [section]")
        except (DuplicateOptionError, DuplicateSectionError) as error:
            self.fail(error.lineno, str(error).split("]: ", 1)[-1])
        except ParsingError as error:
            line = error.errors[0][0]
            self.fail(line, f"{self.lines[line - 1].strip()!r} is no 'name: value'")
        #: Line numbers by section and option, and units of angles in the comments by section, neither of which the
        #: parser keeps.
        self._places: dict[tuple[str, str], int] = {}
        self._angles: dict[str, set[str]] = {}
        section = ""
        for line, text in enumerate(self.lines, start=1):
            if header := re.match(r"\s*\[([^]]*)\]", text):
                section = header[1]
                continue
            if option := re.match(r"\s*([^:=]*?)\s*[:=]", text):
                self._places.setdefault((section, option[1].lower()), line)
            if comment := re.search("[#;](.*)", text):
                self._angles.setdefault(section, set()).update(map(str.lower, _ANGLES.findall(comment[1])))

    def line(self, section: str, option: str) -> int:
        """Return the line of an option, 0 if there is none."""
        return self._places.get((section, option.lower()), 0)

    def has(self, section: str, option: str) -> bool:
        """Return whether there is an option of this name."""
        return self._parser.has_option(section, option)

    def value(self, section: str, option: str, kind: str = NUMBER) -> float:
        """Return a number of a section."""
        if not self.has(section, option):
            self.fail(None, f"no {option!r} in the section [{section}]")
        return self.number(self.line(section, option), self._parser.get(section, option), option, kind)

    def flag(self, section: str, option: str, allowed: tuple[int, ...]) -> int:
        """Return a whole number that must be one of a few."""
        value = self.value(section, option)
        if value not in allowed:
            self.fail(self.line(section, option), f"{option} is {value:g}; expected one of {allowed}")
        return int(value)

    def place(self, section: str, option: str) -> tuple[int, str]:
        """Return the line and the text of an option that names a file."""
        if not self.has(section, option):
            self.fail(None, f"no {option!r} in the section [{section}]")
        return self.line(section, option), self._parser.get(section, option).strip()

    def on(self, section: str, option: str) -> bool:
        """Return whether a switch is on; without the option it is off."""
        return self.has(section, option) and self.flag(section, option, (0, 1)) == 1

    def angles(self, section: str) -> set[str]:
        """Return the units, "deg" or "rad", that the comments of a section mention."""
        return self._angles.get(section, set())


def _axis_kinds(flag: int) -> tuple[str, str, str]:
    """Return the kinds of numbers of the semi-axes of an ellipsoid, or of a sphere, of which only the first is used."""
    return (POSITIVE, POSITIVE, POSITIVE) if flag else (POSITIVE, NUMBER, NUMBER)


def _ellipsoid(path: Any, flag: int, axes: list[float]) -> Ellipsoid | Sphere:
    """Return the ellipsoid with semi-axes in m, or a sphere if the flag is 0; errors name the file."""
    kilometres = [axis / 1000.0 for axis in axes]
    with naming(path):
        return Ellipsoid(*kilometres) if flag else Sphere(kilometres[0])


def read_config(path: Any, euler: str | None) -> tuple[Start, str | None]:
    """Read a ``.cfg``, and return the start with a warning about the unit of its angles, if there is one."""
    cfg = _Config(path)
    start, body = "Initial Conditions", "Body Model Definitions"
    if cfg.on(start, "Fahnestock Input File Flag"):
        line = cfg.line(start, "Fahnestock Input File Flag")
        cfg.fail(
            line, "the file asks for initial conditions of separate files (Fahnestock's), which fullbody does not read"
        )
    shapes = []
    for name in ("Primary", "Secondary"):
        shapes.append(cfg.flag(body, f"{name} Shape Flag", (0, 1, 2)))

    def shape(name: str, flag: int) -> _Shape:
        if flag == 2:
            return _mesh(cfg, *(cfg.place(body, f"{name} {part} File") for part in ("Tetrahedron", "Vertex")))
        kinds = zip(("Major", "Intermediate", "Minor"), _axis_kinds(flag), strict=True)
        return _ellipsoid(path, flag, [cfg.value(body, f"{name} Semi-{size} Axis", kind) for size, kind in kinds])

    position, velocity, spin_a, spin_b = (
        np.array([cfg.value(start, f"{name} {axis}") for axis in "XYZ"])
        for name in (
            "Relative Position", "Relative Velocity", "Primary Angular Velocity", "Secondary Angular Velocity"
        )
    )  # fmt: skip
    density = [cfg.value(body, f"{name} Density", POSITIVE) * 1e12 for name in ("Primary", "Secondary")]
    turns = [_turn(cfg, start, name) for name in ("A into N", "B into A")]
    unit, warning = euler, None
    if euler is None and any(turn.shape == (3,) and turn.any() for turn in turns):
        unit, warning = _unit_of_angles(cfg, start)
    a_to_n, b_to_a = (turn if turn.ndim == 2 else _from_angles(turn, unit) for turn in turns)
    settings = ("Integration Settings", "Start Time")
    read = Start(
        G=cfg.value("Gravity Parameter", "G", NOT_NEGATIVE) / 1e9,
        shapes=(shape("Primary", shapes[0]), shape("Secondary", shapes[1])),
        densities=(density[0], density[1]),
        time=cfg.value(*settings) if cfg.has(*settings) else 0.0,
        position=position / 1000.0,
        velocity=velocity / 1000.0,
        spin_a=spin_a,
        spin_b=spin_b,
        a_to_n=a_to_n,
        b_to_a=b_to_a,
        outside=_outside(cfg),
    )
    return read, warning


def _outside(cfg: _Config) -> Outside:
    """Return the forces that are switched on; only their numbers are read."""
    section = "Additional Forces and Perturbations"
    switches = ("Flyby", "Heliocentric Orbit", "Solar Gravity", "Tidal Torque")
    flyby, helio, hill, tides = (cfg.on(section, name) for name in switches)
    if helio and hill:
        cfg.fail(cfg.line(section, "Solar Gravity"), _TWO_SUNS)

    def value(name: str, kind: str = NUMBER) -> float:
        return cfg.value(section, name, kind)

    def orbit(prefix: str, periapsis: str) -> Orbit:
        names = ("Semimajor Axis", "Eccentricity", "Inclination", "RAAN", "Argument of Periapsis")
        a, e, i, node, argument = (value(prefix + name) for name in names)
        return a, e, i, node, argument, value(periapsis)

    def deformed(body: str) -> Deformed:
        radius = value(f"{body} Reference Radius", POSITIVE) / 1000.0
        return Deformed(
            value(f"{body} Love Number", NOT_NEGATIVE), radius, value(f"{body} Tidal Lag Angle", NOT_NEGATIVE)
        )

    found = Outside()
    if flyby:
        found.flyby = value("Planetary Mass", POSITIVE), orbit("", "Flyby Time")
    if helio:
        # The program uses this mass here, although the option belongs to the section on the circular orbit.
        found.sun = value("Solar Mass", POSITIVE), orbit("Heliocentric ", "Time of periapsis passage")
    if hill:
        distance = value("Solar Orbit Radius", POSITIVE) * value("AU Definition", POSITIVE) / 1000.0
        mass = "Sun Mass" if cfg.has(section, "Sun Mass") else "Solar Mass"
        found.circular = value(mass, POSITIVE), distance
    if tides:
        found.tides = deformed("Primary"), deformed("Secondary")
    return found


def _mesh(file: Text, faces: tuple[int, str], vertices: tuple[int, str]) -> Polyhedron:
    """Return a polyhedron from two tables beside the file: vertices in metres and faces, numbered from one.

    The program adds the tetrahedra from the origin without their signs, so that faces may have any orientation.
    """
    tables = []
    for line, name in (vertices, faces):
        if not (place := as_path(file.path).parent / name).is_file():
            file.fail(line, f"no file {name!r} of a polyhedron beside this one")
        text = Text(place)
        rows = [row for row in (re.split(r"[,\s]+", row.strip().strip(",")) for row in text.lines) if row != [""]]
        if len({len(row) for row in rows}) != 1 or len(rows[0]) < 3:
            file.fail(line, f"{name} is not a table with three numbers, or an index and three, in each row")
        tables.append(np.array([[text.number(k, word, "a number") for word in row] for k, row in enumerate(rows, 1)]))
    points, corners = tables[0][:, -3:] / 1000.0, tables[1][:, :3].astype(np.int64) - 1
    if corners.min() < 0 or corners.max() >= len(points):
        file.fail(faces[0], f"{faces[1]} names vertices from 1 to {corners.max() + 1}; expected 1 to {len(points)}")
    inward = np.linalg.det(points[corners]) < 0.0
    corners[inward] = corners[inward][:, ::-1]
    try:
        return Polyhedron(points, corners)
    except InvalidInput as error:
        file.fail(faces[0], f"{faces[1]}: {error}")


def _turn(cfg: _Config, section: str, name: str) -> _Array:
    """Return a rotation matrix (3, 3), or Euler angles (3,)."""
    if cfg.flag(section, f"{name} Euler Flag", (0, 1)):
        return np.array([cfg.value(section, f"{name} Euler {i} {axis}") for i, axis in ((1, "X"), (2, "Y"), (3, "Z"))])
    entries = [[cfg.value(section, f"{name} ({i},{j})") for j in (1, 2, 3)] for i in (1, 2, 3)]
    return _rotation(cfg, cfg.line(section, f"{name} (1,1)"), name, np.array(entries))


def _rotation(file: Text, line: int, name: str, matrix: _Array) -> _Array:
    # The tolerance accepts files with only a few digits.
    if not rotations.is_rotation(matrix, 1e-4):
        file.fail(line, f"{name} is not a rotation matrix: {matrix.tolist()}; expected one to 1e-4")
    return matrix


def _unit_of_angles(cfg: _Config, section: str) -> tuple[str, str | None]:
    """Return the unit of angles according to the comments, which differ between versions, and a warning about it."""
    units = cfg.angles(section)
    ask = "say euler='degree' or euler='radian'"
    if len(units) == 2:
        cfg.fail(None, f"comments of [{section}] speak of degrees and of radians, and angles are given; {ask}")
    if units == {"deg"}:
        return "degree", f"taken in degrees as its comments say; GUBAS itself takes radians: {ask}"
    if units == {"rad"}:
        return "radian", None
    return "radian", f"taken in radians as GUBAS takes them; no comment of the file says what they are in: {ask}"


def _from_angles(angles: _Array, unit: str | None) -> _Array:
    """Return the rotation by angles about x, then about the new y, then about the new z."""
    x, y, z = np.radians(angles) if unit == "degree" else angles
    turns = [rotations.turn(axis, angle) for axis, angle in enumerate((x, y, z))]
    return rotations.matrices(rotations.product(*turns))


#: Lines of ``ic_input.txt``: numbers, file names, the state, and then settings, whose count identifies the layout.
_BEFORE, _FILES, _STATE = 16, 8, 30
#: The switches of each layout, by the number of lines after the state; they follow four settings of the integrator.
#: After them come the numbers of the forces that are orbits (seven each), and then those of the others.
_TOGGLES = {
    15: ("hill", "tides"),
    23: ("flyby", "hill", "tides"),
    31: ("flyby", "sun", "hill", "tides"),
}


def read_numbers(path: Any) -> Start:
    """Read an ``ic_input.txt``."""
    file = Text(path)
    lines = file.lines
    while lines and not lines[-1].strip():
        lines.pop()
    rest = len(lines) - _BEFORE - _FILES - _STATE
    if rest not in _TOGGLES:
        known = ", ".join(str(_BEFORE + _FILES + _STATE + count) for count in _TOGGLES)
        file.fail(len(lines), f"the file ends after {len(lines)} lines; GUBAS writes {known}")

    def value(index: int, what: str, kind: str = NUMBER) -> float:
        return file.number(index + 1, lines[index].split("#")[0].strip(), what, kind)

    def values(first: int, count: int, what: str) -> _Array:
        return np.array([value(first + k, what) for k in range(count)])

    toggles = _BEFORE + _FILES + _STATE + 4
    names = _TOGGLES[rest]
    switched = {}
    for k, name in enumerate(names):
        flag = value(toggles + k, "a switch")
        if flag not in (0, 1):
            file.fail(toggles + k + 1, f"the switch is {flag:g}; expected 0 or 1")
        switched[name] = flag == 1
    if switched.get("sun") and switched["hill"]:
        file.fail(toggles + names.index("hill") + 1, _TWO_SUNS)
    outside, place = Outside(), toggles + len(names)
    for name in ("flyby", "sun"):
        if name in names:
            if switched[name]:
                a, e, i, node, argument, periapsis = values(place + 1, 6, "an element")
                setattr(outside, name, (value(place, "a mass", POSITIVE), (a, e, i, node, argument, periapsis)))
            place += 7
    if switched["hill"]:
        distance = value(place, "the Sun's distance", POSITIVE) * value(place + 1, "the length of an au", POSITIVE)
        outside.circular = value(place + 8, "the Sun's mass", POSITIVE), distance
    if switched["tides"]:
        tides = [
            Deformed(
                value(place + 2 + k, "a Love number", NOT_NEGATIVE),
                value(place + 4 + k, "a reference radius", POSITIVE) / 1000.0,
                value(place + 6 + k, "a lag angle", NOT_NEGATIVE),
            )
            for k in (0, 1)
        ]
        outside.tides = tides[0], tides[1]
    shapes = []
    for index in (10, 11):
        flag = value(index, "a shape flag")
        if flag not in (0, 1, 2):
            file.fail(index + 1, f"the shape flag is {flag:g}; expected 0 (sphere), 1 (ellipsoid) or 2 (polyhedron)")
        shapes.append(int(flag))
    state = values(_BEFORE + _FILES, _STATE, "a number of the state")
    first = _BEFORE + _FILES + 1
    a_to_n, b_to_a = (
        _rotation(file, first + k, name, state[k : k + 9].reshape(3, 3))
        for name, k in (("A into N", 12), ("B into A", 21))
    )

    def shape(body: int) -> _Shape:
        if shapes[body] == 2:
            places = (_BEFORE + 4 + 2 * body, _BEFORE + 5 + 2 * body)
            return _mesh(file, *((index + 1, lines[index].strip()) for index in places))
        kinds = enumerate(_axis_kinds(shapes[body]))
        return _ellipsoid(path, shapes[body], [value(4 + 3 * body + k, "a semi-axis", kind) for k, kind in kinds])

    return Start(
        G=value(0, "G", NOT_NEGATIVE),
        shapes=(shape(0), shape(1)),
        densities=(value(12, "the primary's density", POSITIVE), value(13, "the secondary's density", POSITIVE)),
        time=value(14, "the start time"),
        position=state[0:3],
        velocity=state[3:6],
        spin_a=state[6:9],
        # In this file the secondary's spin is along the primary's axes.
        spin_b=b_to_a.T @ state[9:12],
        a_to_n=a_to_n,
        b_to_a=b_to_a,
        outside=outside,
    )
