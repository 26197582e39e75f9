"""Reading of GUBAS's configuration file: shapes, rotations and forces in km, s, kg."""

from __future__ import annotations

import re
from collections.abc import Iterator
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
from ..forces import Force, ThirdBody, Tide
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, Sphere
from ..orbit.elements import KeplerElements
from ..typing import Floats
from ._text import NOT_NEGATIVE, NUMBER, POSITIVE, Text, naming

#: The elements of an orbit in the order of a file: semi-major axis, eccentricity, inclination, node, argument of
#: periapsis, time of periapsis.
Orbit = tuple[float, float, float, float, float, float]
_LEFT_OUT = "GUBAS leaves out its torques, which are computed here"
_DISPLACED = (
    "GUBAS puts the secondary at 1 - nu r instead of (1 - nu) r from the barycentre, so that its pull is one across a "
    "fixed vector (GUBAS-RS does not)"
)
_Shape = Ellipsoid | Sphere | Polyhedron
#: The names of sections.
START, BODIES = "Initial Conditions", "Body Model Definitions"
_TWO_SUNS = "the file asks for a heliocentric orbit and for the Sun of Hill's problem; expected one of the two"
#: The units of an angle in a comment, which are not part of the unit of a rate.
_ANGLES = re.compile(r"\b(deg|rad)(?:rees?|ians?)?\b(?!\s*/|\s+per\b)", re.IGNORECASE)


@dataclass
class Deformed:
    """The tide of a body: its Love number, radius in km and lag angle in radians."""

    k2: float
    radius: float
    angle: float


@dataclass
class Outside:
    """The forces in a file, each ``None`` if it is switched off; masses are in kg and lengths in km."""

    flyby: tuple[float, Orbit] | None = None
    sun: tuple[float, Orbit] | None = None
    #: The mass and the distance of a Sun on a circular orbit.
    circular: tuple[float, float] | None = None
    tides: tuple[Deformed, Deformed] | None = None

    def forces(self, start: float, relative: npt.NDArray[Any], spins: npt.NDArray[Any]) -> list[Force]:
        """Return the forces; tides need the relative position, velocity (2, 3) and spins (2, 3), all inertial."""
        found: list[Force] = []
        for name, third in (("flyby", self.flyby), ("Sun", self.sun)):
            if third is not None:
                mass, (a, e, i, node, argument, periapsis) = third
                orbit = KeplerElements(a, e, i, node, argument, 0.0)
                found.append(ThirdBody(mass=mass, orbit=orbit, of="body", time=periapsis, name=name))
        if self.circular is not None:
            mass, distance = self.circular
            orbit = KeplerElements(distance, 0.0, 0.0, 0.0, 0.0, 0.0)
            found.append(ThirdBody(mass=mass, orbit=orbit, of="system", time=start, name="Sun"))
        if self.tides is not None:
            position, velocity = relative
            orbital = np.cross(position, velocity) / (position @ position)
            names = ("primary", "secondary")
            for k, tide in enumerate(self.tides):
                # The tide with the highest frequency has the shortest lag.
                frequency = max(2.0 * np.linalg.norm(spins[k] - orbital), np.linalg.norm(orbital))
                lag = float(np.sin(2.0 * tide.angle) / frequency)
                found.append(Tide(names[k], names[1 - k], tide.k2, lag, radius=tide.radius))
        return found

    def input_warnings(self) -> Iterator[str]:
        """Return warnings of input for which GUBAS's own result differs from the result of this package."""
        if self.flyby is not None:
            yield f"a flyby: {_LEFT_OUT}, and {_DISPLACED}"
        if self.sun is not None:
            yield f"a heliocentric orbit: {_LEFT_OUT}, and {_DISPLACED}"
        if self.circular is not None:
            yield (
                "the Sun of Hill's problem: GUBAS holds its direction fixed along x and adds the Coriolis acceleration "
                "of axes that turn, which its state has not; here the Sun goes round on a circle, and turns the bodies"
            )
        if self.tides is not None:
            yield (
                "tidal torques: GUBAS's have the sign that drives spins away from the orbit's rate, which adds energy, "
                "and take a radius in metres beside kilometres; here tides of a constant time lag dissipate"
            )


class Config(Text):
    """A ``.cfg`` file: numbers by section and option."""

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        # Interpolation is switched off, since a per cent sign in a case name has no meaning.
        self._parser = ConfigParser(interpolation=None, inline_comment_prefixes=("#", ";"))
        try:
            self._parser.read_string("\n".join(self.lines))
        except MissingSectionHeaderError as error:
            self.fail(error.lineno, "text before the first [section]; expected a .cfg of GUBAS")
        except (DuplicateOptionError, DuplicateSectionError) as error:
            self.fail(error.lineno, str(error).split("]: ", 1)[-1])
        except ParsingError as error:
            line = error.errors[0][0]
            self.fail(line, f"{self.lines[line - 1].strip()!r} is no 'name: value'")
        #: Line numbers by section and option, and units of angles in the comments by section, neither of which the
        #: parser keeps.
        self._line_numbers: dict[tuple[str, str], int] = {}
        self._angles: dict[str, set[str]] = {}
        section = ""
        for line, text in enumerate(self.lines, start=1):
            if header := re.match(r"\s*\[([^]]*)\]", text):
                section = header[1]
                continue
            if option := re.match(r"\s*([^:=]*?)\s*[:=]", text):
                self._line_numbers.setdefault((section, option[1].lower()), line)
            if comment := re.search("[#;](.*)", text):
                self._angles.setdefault(section, set()).update(map(str.lower, _ANGLES.findall(comment[1])))

    def line(self, section: str, option: str) -> int:
        """Return the line of an option, 0 if there is none."""
        return self._line_numbers.get((section, option.lower()), 0)

    def has(self, section: str, option: str) -> bool:
        """Return whether there is an option of this name."""
        return self._parser.has_option(section, option)

    def vector(self, section: str, name: str) -> Floats:
        """Return the three numbers of a vector."""
        return np.array([self.value(section, f"{name} {axis}") for axis in "XYZ"])

    def value(self, section: str, option: str, kind: str = NUMBER) -> float:
        """Return a number of a section."""
        return self.number(*self.entry(section, option), option, kind)

    def flag(self, section: str, option: str, allowed: tuple[int, ...]) -> int:
        """Return a whole number that must be one of a few."""
        value = self.value(section, option)
        if value not in allowed:
            self.fail(self.line(section, option), f"{option} is {value:g}; expected one of {allowed}")
        return int(value)

    def entry(self, section: str, option: str) -> tuple[int, str]:
        """Return the line and the text of an option."""
        if not self.has(section, option):
            self.fail(None, f"no {option!r} in the section [{section}]")
        return self.line(section, option), self._parser.get(section, option).strip()

    def on(self, section: str, option: str) -> bool:
        """Return whether a switch is on; without the option it is off."""
        return self.has(section, option) and self.flag(section, option, (0, 1)) == 1

    def angles(self, section: str) -> set[str]:
        """Return the units, "deg" or "rad", that the comments of a section mention."""
        return self._angles.get(section, set())


def rotations_of(cfg: Config, euler: str | None) -> tuple[list[Floats], str | None]:
    """Return the rotations A into N and B into A, and a warning about the unit of their angles, if there is one."""
    rotations_read = [_rotation_matrix(cfg, name) for name in ("A into N", "B into A")]
    warning = None
    if euler is None and any(rotation.shape == (3,) and rotation.any() for rotation in rotations_read):
        euler, warning = _unit_of_angles(cfg)
    return [rotation if rotation.ndim == 2 else _from_angles(rotation, euler) for rotation in rotations_read], warning


def shape_of(cfg: Config, name: str) -> _Shape:
    """Return the shape of the body of a name; of a sphere only the first semi-axis is used."""
    flag = cfg.flag(BODIES, f"{name} Shape Flag", (0, 1, 2))
    if flag == 2:
        return _mesh(cfg, *(cfg.entry(BODIES, f"{name} {part} File") for part in ("Tetrahedron", "Vertex")))
    sizes = ("Major", "Intermediate", "Minor") if flag else ("Major",)
    axes = [cfg.value(BODIES, f"{name} Semi-{size} Axis", POSITIVE) / 1000.0 for size in sizes]
    with naming(cfg.path):
        return Ellipsoid(*axes) if flag else Sphere(*axes)


def outside_of(cfg: Config) -> Outside:
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

    outside = Outside()
    if flyby:
        outside.flyby = value("Planetary Mass", POSITIVE), orbit("", "Flyby Time")
    if helio:
        # The program uses this mass here, although the option belongs to the section on the circular orbit.
        outside.sun = value("Solar Mass", POSITIVE), orbit("Heliocentric ", "Time of periapsis passage")
    if hill:
        distance = value("Solar Orbit Radius", POSITIVE) * value("AU Definition", POSITIVE) / 1000.0
        mass = "Sun Mass" if cfg.has(section, "Sun Mass") else "Solar Mass"
        outside.circular = value(mass, POSITIVE), distance
    if tides:
        outside.tides = deformed("Primary"), deformed("Secondary")
    return outside


def _mesh(cfg: Config, faces: tuple[int, str], vertices: tuple[int, str]) -> Polyhedron:
    """Return a polyhedron from two tables beside the file: vertices in metres and faces, numbered from one.

    The program adds the tetrahedra from the origin without their signs, so that faces may have any orientation.
    """
    tables = []
    for line, name in (vertices, faces):
        if not (path := as_path(cfg.path).parent / name).is_file():
            cfg.fail(line, f"no file {name!r} of a polyhedron beside this one")
        text = Text(path)
        rows = [row for row in (re.split(r"[,\s]+", row.strip().strip(",")) for row in text.lines) if row != [""]]
        if len({len(row) for row in rows}) != 1 or len(rows[0]) < 3:
            cfg.fail(line, f"{name} is not a table with three numbers, or an index and three, in each row")
        tables.append(np.array([[text.number(k, word, "a number") for word in row] for k, row in enumerate(rows, 1)]))
    points, corners = tables[0][:, -3:] / 1000.0, tables[1][:, :3].astype(np.int64) - 1
    if corners.min() < 0 or corners.max() >= len(points):
        cfg.fail(faces[0], f"{faces[1]} names vertices from 1 to {corners.max() + 1}; expected 1 to {len(points)}")
    inward = np.linalg.det(points[corners]) < 0.0
    corners[inward] = corners[inward][:, ::-1]
    try:
        return Polyhedron(points, corners)
    except InvalidInput as error:
        cfg.fail(faces[0], f"{faces[1]}: {error}")


def _rotation_matrix(cfg: Config, name: str) -> Floats:
    """Return a rotation matrix (3, 3), or Euler angles (3,)."""
    if cfg.flag(START, f"{name} Euler Flag", (0, 1)):
        return np.array([cfg.value(START, f"{name} Euler {i} {axis}") for i, axis in ((1, "X"), (2, "Y"), (3, "Z"))])
    entries = [[cfg.value(START, f"{name} ({i},{j})") for j in (1, 2, 3)] for i in (1, 2, 3)]
    # The tolerance accepts files with only a few digits.
    if not rotations.is_rotation(np.array(entries), 1e-4):
        line = cfg.line(START, f"{name} (1,1)")
        cfg.fail(line, f"{name} is not a rotation matrix: {entries}; expected one to 1e-4")
    return np.array(entries)


def _unit_of_angles(cfg: Config) -> tuple[str, str | None]:
    """Return the unit of angles according to the comments, which differ between versions, and a warning about it."""
    units = cfg.angles(START)
    ask = "say euler='degree' or euler='radian'"
    if len(units) == 2:
        cfg.fail(None, f"comments of [{START}] speak of degrees and of radians, and angles are given; {ask}")
    if units == {"deg"}:
        return "degree", f"taken in degrees as its comments say; GUBAS itself takes radians: {ask}"
    if units == {"rad"}:
        return "radian", None
    return "radian", f"taken in radians as GUBAS takes them; no comment of the file says what they are in: {ask}"


def _from_angles(angles: Floats, unit: str | None) -> Floats:
    """Return the rotation by angles about x, then about the new y, then about the new z."""
    x, y, z = np.radians(angles) if unit == "degree" else angles
    rotations_read = [rotations.about_axis(axis, angle) for axis, angle in enumerate((x, y, z))]
    return rotations.matrices(rotations.product(*rotations_read))
