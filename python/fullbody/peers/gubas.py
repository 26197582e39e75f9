"""Reading of configuration files of GUBAS and GUBAS-RS."""

from __future__ import annotations

import configparser
import re
from typing import Any, Literal

import numpy as np

from ..base import rotations
from ..base.atomic import as_path
from ..base.kinds import choice, instance
from ..base.limits import Limits
from ..errors import InvalidInput, caution
from ..files.text import NOT_NEGATIVE, NUMBER, POSITIVE, Text, naming
from ..forces import Force, ThirdBody, Tide
from ..model.bodies import Body
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, Sphere
from ..model.state import State, from_numbers
from ..motion.system import System
from ..orbit.elements import KeplerElements
from ..typing import Floats
from ._files import along_body_axes

_UNITS = ("km", "s", "kg")
_NAMES, _TIME = ("Primary", "Secondary"), ("Integration Settings", "Start Time")
#: The names of sections.
_START, _BODIES, _FORCES = "Initial Conditions", "Body Model Definitions", "Additional Forces and Perturbations"
_ELEMENTS = ("Semimajor Axis", "Eccentricity", "Inclination", "RAAN", "Argument of Periapsis")
#: The differences of both kinds of third bodies from those of GUBAS.
_THIRD_BODIES = (
    "GUBAS leaves out its torques, which are computed here, and GUBAS puts the secondary at 1 - nu r instead of "
    "(1 - nu) r from the barycentre, so that its force is that at a constant vector (GUBAS-RS does not)"
)
#: The units of an angle in a comment, which are not part of the unit of a rate.
_ANGLES = re.compile(r"\b(deg|rad)(?:rees?|ians?)?\b(?!\s*/|\s+per\b)", re.IGNORECASE)


def read_gubas(
    path: Any, *, euler: Literal["degree", "radian"] | None = None, units: bool = False, **options: Any
) -> tuple[System, State]:
    """Read a system and its state from an input file of GUBAS, its ``.cfg``.

    The relative position and velocity are components along the primary's axes, and "A into N" turns them into the
    inertial frame; spins are along each body's own axes, densities in g/cm^3. The barycentre is placed at rest at the
    origin. A polyhedron's tables of vertices and faces are searched for beside the file; a warning says if they are not
    in its principal axes, as GUBAS takes them. Its state is that of its centre of mass and these axes.

    Effects that are switched on besides mutual gravity become forces of the system. "Flyby" and "Heliocentric Orbit"
    are a :class:`fullbody.forces.ThirdBody` each, named flyby and Sun, which move about the binary on the file's
    elements, as in GUBAS. If the elements are those of the binary about the Sun, this places the Sun on the opposite
    side, where its tide is the same except for the odd orders. "Solar Gravity" is a Sun on a circular orbit in the
    plane z = 0, which is on the -x axis at the start. "Tidal Torque" is a :class:`fullbody.forces.Tide` on each body.
    The lag angle eps is converted to a time lag by sin(2 eps) = f lag, where f is the larger of 2 abs(omega - n) and n
    at the start, omega is the body's spin and n the orbit's rate.

    Parameters
    ----------
    path : str or Path
        The configuration file. The numeric ``ic_input.txt``, which GUBAS writes from it for its own use, is not read.
    euler : {"degree", "radian"}, optional
        The unit of Euler angles; by default the one that the file's comments state, with a warning if that is degrees,
        since both programs take radians, or if they state none, for which radians are taken.
    units : bool
        Whether the system returns Quantities. Numbers are in km, s, kg in either case.
    **options
        Options that are passed to :class:`fullbody.System`. The default is the exact gravity; ``gravity="multipole:4"``
        and others truncate the expansion as those programs do.

    Raises
    ------
    InvalidInput
        For missing or invalid input, where the message names the line; for angles with comments of both units; for two
        Suns; and for Fahnestock's separate file of initial conditions, which is not supported.

    Warns
    -----
    UserWarning
        For Euler angles whose unit is in doubt, and for forces that are computed correctly where GUBAS errs: it omits
        the torques of third bodies and displaces the secondary in their pull, its tides add energy, and its "Solar
        Gravity" has a fixed direction.

    References
    ----------
    Davis & Scheeres (2020), Icarus 341, 113439; https://github.com/meyeralexj/gubas,
    https://github.com/giovannifereoli/GUBAS-RS.

    Examples
    --------
    >>> import fullbody, pathlib, tempfile
    >>> axes = zip(("Major", "Intermediate", "Minor"), (400, 400, 300), (90, 80, 70))
    >>> bodies = [f"{body} Semi-{name} Axis: {size}" for name, *sizes in axes
    ...           for body, size in zip(("Primary", "Secondary"), sizes)]
    >>> bodies += [f"{body} {text}" for body in ("Primary", "Secondary") for text in ("Shape Flag: 1", "Density: 2.1")]
    >>> motion = {"Relative Position": (1190, 0, 0), "Relative Velocity": (0, 0.17, 0),
    ...           "Primary Angular Velocity": (0, 0, 7.7e-4), "Secondary Angular Velocity": (0, 0, 1.5e-4)}
    >>> start = [f"{name} {axis}: {value}" for name in motion for axis, value in zip("XYZ", motion[name])]
    >>> for name in ("A into N Euler", "B into A Euler"):
    ...     start += [f"{name} Flag: 1", f"{name} 1 X: 0", f"{name} 2 Y: 0", f"{name} 3 Z: 0"]
    >>> lines = ["[Gravity Parameter]", "G: 6.67e-11", "[Body Model Definitions]", *bodies,
    ...          "[Initial Conditions]", *start]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "hou_config.cfg")
    ...     _ = path.write_text(chr(10).join(lines))
    ...     system, state = fullbody.read_gubas(path)
    >>> system.bodies[1].shape
    Ellipsoid(a=0.09, b=0.08, c=0.07)
    """
    choice(euler, "euler", (None, "degree", "radian"))
    instance(units, "units", bool, "True or False (GUBAS' files are in km, s and kg)")
    cfg = _Config(path)
    if cfg.on(_START, "Fahnestock Input File Flag"):
        cfg.fail(
            cfg.line(_START, "Fahnestock Input File Flag"),
            "the file asks for initial conditions of separate files (Fahnestock's), which fullbody does not read",
        )
    relative = np.array([cfg.vector(_START, f"Relative {name}") / 1000.0 for name in ("Position", "Velocity")])
    spin = np.array([cfg.vector(_START, f"{body} Angular Velocity") for body in _NAMES])
    a_to_n, b_to_a = _rotations(cfg, euler)
    attitude = np.array([a_to_n, a_to_n @ b_to_a])
    relative = relative @ a_to_n.T
    densities = [cfg.value(_BODIES, f"{body} Density", POSITIVE) * 1e12 for body in _NAMES]
    shapes = [_shape(cfg, body) for body in _NAMES]
    time = cfg.value(*_TIME) if cfg.has(*_TIME) else 0.0
    forces = _forces(cfg, time, relative, np.einsum("nij,nj->ni", attitude, spin))
    G = cfg.value("Gravity Parameter", "G", NOT_NEGATIVE) / 1e9
    with naming(path):
        parts = zip(_NAMES, shapes, densities, strict=True)
        bodies = [Body(shape, density=density, name=name.lower()) for name, shape, density in parts]
        system = System(bodies, G=G, units=_UNITS if units else None, **options)
        if forces:
            system = system.with_forces([*system.forces, *forces])
        factors = np.array([-bodies[1].mass, bodies[0].mass])[:, None] / sum(body.mass for body in bodies)
        quaternions, spin = along_body_axes(path, bodies, np.array(list(map(rotations.quaternion, attitude))), spin)
        state = from_numbers(system.context, factors * relative[0], factors * relative[1], quaternions, spin, time)
    return system, state


class _Config(Text):
    """A ``.cfg`` file: numbers by section and option."""

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        # Interpolation is switched off, since a per cent sign in a case name has no meaning.
        self._parser = configparser.ConfigParser(interpolation=None, inline_comment_prefixes=("#", ";"))
        try:
            self._parser.read_string("\n".join(self.lines))
        except configparser.MissingSectionHeaderError as error:
            self.fail(error.lineno, "text before the first [section]; expected a .cfg of GUBAS")
        except (configparser.DuplicateOptionError, configparser.DuplicateSectionError) as error:
            self.fail(error.lineno, str(error).split("]: ", 1)[-1])
        except configparser.ParsingError as error:
            line = error.errors[0][0]
            self.fail(line, f"{self.lines[line - 1].strip()!r} is no 'name: value'")
        #: Line numbers by section and option, and units of angles, "deg" or "rad", in the comments by section, neither
        #: of which the parser keeps.
        self._line_numbers: dict[tuple[str, str], int] = {}
        self.angles: dict[str, set[str]] = {}
        section = ""
        for line, text in enumerate(self.lines, start=1):
            if header := re.match(r"\s*\[([^]]*)\]", text):
                section = header[1]
                continue
            if option := re.match(r"\s*([^:=]*?)\s*[:=]", text):
                self._line_numbers.setdefault((section, option[1].lower()), line)
            if comment := re.search("[#;](.*)", text):
                self.angles.setdefault(section, set()).update(map(str.lower, _ANGLES.findall(comment[1])))

    def line(self, section: str, option: str) -> int:
        """Return the line of an option, 0 if there is none."""
        return self._line_numbers.get((section, option.lower()), 0)

    def has(self, section: str, option: str) -> bool:
        """Return whether there is an option of this name."""
        return self._parser.has_option(section, option)

    def vector(self, section: str, name: str) -> Floats:
        """Return the three numbers of a vector."""
        return np.array([self.value(section, f"{name} {axis}") for axis in "XYZ"])

    def value(self, section: str, option: str, limits: Limits = NUMBER) -> float:
        """Return a number of a section."""
        return self.number(*self.entry(section, option), option, limits)

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


def _rotations(cfg: _Config, euler: str | None) -> list[Floats]:
    """Return the rotations A into N and B into A, and warn of angles whose unit is in doubt."""
    orientations = [_rotation_matrix(cfg, name) for name in ("A into N", "B into A")]
    if euler is None and any(matrix.shape == (3,) and matrix.any() for matrix in orientations):
        euler = _unit_of_angles(cfg)
    return [matrix if matrix.ndim == 2 else _from_angles(matrix, euler) for matrix in orientations]


def _shape(cfg: _Config, name: str) -> Ellipsoid | Sphere | Polyhedron:
    """Return the shape of the body of a name; of a sphere only the first semi-axis is used."""
    flag = cfg.flag(_BODIES, f"{name} Shape Flag", (0, 1, 2))
    if flag == 2:
        return _mesh(cfg, *(cfg.entry(_BODIES, f"{name} {part} File") for part in ("Tetrahedron", "Vertex")))
    sizes = ("Major", "Intermediate", "Minor") if flag else ("Major",)
    axes = [cfg.value(_BODIES, f"{name} Semi-{size} Axis", POSITIVE) / 1000.0 for size in sizes]
    with naming(cfg.path):
        return Ellipsoid(*axes) if flag else Sphere(*axes)


def _forces(cfg: _Config, start: float, relative: Floats, spins: Floats) -> list[Force]:
    """Return the forces that are switched on, by inertial vectors (2, 3), and warn where GUBAS's own result differs."""
    switches = ("Flyby", "Heliocentric Orbit", "Solar Gravity", "Tidal Torque")
    flyby, helio, hill, tides = (cfg.on(_FORCES, name) for name in switches)
    if helio and hill:
        text = "the file asks for a heliocentric orbit and for the Sun of Hill's problem; expected one of the two"
        cfg.fail(cfg.line(_FORCES, "Solar Gravity"), text)
    forces: list[Force] = []
    differences = []

    def value(option: str, limits: Limits = NUMBER) -> float:
        return cfg.value(_FORCES, option, limits)

    def third(name: str, mass: str, prefix: str, periapsis: str) -> None:
        size = value(mass, POSITIVE)
        a, e, i, node, argument = (value(prefix + element) for element in _ELEMENTS)
        time = value(periapsis)
        with naming(cfg.path):
            orbit = KeplerElements(a, e, i, node, argument, 0.0)
            forces.append(ThirdBody(mass=size, orbit=orbit, of="body", time=time, name=name))

    if flyby:
        third("flyby", "Planetary Mass", "", "Flyby Time")
        differences.append(f"a flyby: {_THIRD_BODIES}")
    if helio:
        # The program uses this mass here, although the option belongs to the section on the circular orbit.
        third("Sun", "Solar Mass", "Heliocentric ", "Time of periapsis passage")
        differences.append(f"a heliocentric orbit: {_THIRD_BODIES}")
    if hill:
        distance = value("Solar Orbit Radius", POSITIVE) * value("AU Definition", POSITIVE) / 1000.0
        mass = value("Sun Mass" if cfg.has(_FORCES, "Sun Mass") else "Solar Mass", POSITIVE)
        orbit = KeplerElements(distance, 0.0, 0.0, 0.0, 0.0, 0.0)
        forces.append(ThirdBody(mass=mass, orbit=orbit, of="system", time=start, name="Sun"))
        differences.append(
            "the Sun of Hill's problem: GUBAS holds its direction fixed along x and adds the Coriolis acceleration of "
            "a rotating frame, but its state is inertial; here the Sun moves on a circle and exerts torques on bodies"
        )
    if tides:
        position, velocity = relative
        orbital = np.cross(position, velocity) / (position @ position)
        for name, other, spin in zip(_NAMES, reversed(_NAMES), spins, strict=True):
            radius = value(f"{name} Reference Radius", POSITIVE) / 1000.0
            k2, angle = (value(f"{name} {role}", NOT_NEGATIVE) for role in ("Love Number", "Tidal Lag Angle"))
            # The tide with the highest frequency has the shortest lag.
            frequency = max(2.0 * np.linalg.norm(spin - orbital), np.linalg.norm(orbital))
            lag = float(np.sin(2.0 * angle) / frequency)
            with naming(cfg.path):
                forces.append(Tide(name.lower(), other.lower(), k2, lag, radius=radius))
        differences.append(
            "tidal torques: GUBAS's have the sign that drives spins away from the orbit's rate, which adds energy, and "
            "take a radius in metres beside kilometres; here tides of a constant time lag dissipate"
        )
    for text in differences:
        caution(f"{cfg.path} asks for {text}", UserWarning)
    return forces


def _mesh(cfg: _Config, faces: tuple[int, str], vertices: tuple[int, str]) -> Polyhedron:
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


def _rotation_matrix(cfg: _Config, name: str) -> Floats:
    """Return a rotation matrix (3, 3), or Euler angles (3,)."""
    if cfg.flag(_START, f"{name} Euler Flag", (0, 1)):
        return np.array([cfg.value(_START, f"{name} Euler {i} {axis}") for i, axis in ((1, "X"), (2, "Y"), (3, "Z"))])
    entries = [[cfg.value(_START, f"{name} ({i},{j})") for j in (1, 2, 3)] for i in (1, 2, 3)]
    # The tolerance accepts files with only a few digits.
    if not rotations.is_rotation(np.array(entries), 1e-4):
        line = cfg.line(_START, f"{name} (1,1)")
        cfg.fail(line, f"{name} is not a rotation matrix: {entries}; expected one to 1e-4")
    return np.array(entries)


def _unit_of_angles(cfg: _Config) -> str:
    """Return the unit of angles according to the comments, which differ between versions, and warn about it."""
    units = cfg.angles.get(_START, set())
    advice = "give euler='degree' or euler='radian'"
    if len(units) == 2:
        cfg.fail(None, f"comments of [{_START}] name degrees and radians, and angles are given; {advice}")
    if units == {"rad"}:
        return "radian"
    unit = "degree" if units else "radian"
    reason = "as its comments say; GUBAS itself takes radians"
    reason = reason if units else "as GUBAS takes them; no comment of the file names their unit"
    caution(f"{cfg.path} gives Euler angles, taken in {unit}s {reason}: {advice}", UserWarning)
    return unit


def _from_angles(angles: Floats, unit: str | None) -> Floats:
    """Return the rotation by angles about x, then about the new y, then about the new z."""
    radians = np.radians(angles) if unit == "degree" else angles
    return rotations.matrices(rotations.product(*(rotations.about_axis(k, angle) for k, angle in enumerate(radians))))
