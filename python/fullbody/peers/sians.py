"""Reading of input files of SIANS, the program of the paper's authors."""

from __future__ import annotations

import re
from math import pi, prod
from typing import Any

import numpy as np

from ..base.atomic import as_path
from ..base.kinds import choice
from ..base.units import Units
from ..errors import InvalidInput, caution
from ..files.text import POSITIVE, Text, naming
from ..forces import ThirdBody
from ..model.bodies import Body
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, PointMass
from ..model.state import State, wrap
from ..motion.system import System
from ..orbit.elements import KeplerElements
from ._files import along_body_axes

#: The program's own gravitational constant in m^3 kg^-1 s^-2, and its mass of the Sun in the file's unit of mass.
_G_SI = 6.67408e-11
_SUN = 1.989e30
#: SIANS's names of units, with (length, time, mass), G in these units, and the unit of periods (which is seconds for
#: "kms").
_UNITS: dict[str | None, tuple[tuple[str, str, str], float, float]] = {
    "SI": (("m", "s", "kg"), _G_SI, 86400.0),
    "kmhr": (("km", "hour", "kg"), _G_SI * 3600.0**2 / 1000.0**3, 24.0),
    "kms": (("km", "s", "kg"), _G_SI / 1000.0**3, 1.0),
}
_SETTINGS = ("t_end", "N", "ntol", "iabstol", "ireltol", "quadval", "quadnode", "hmax", "hmin", "t_start", "pmdist")
#: The switches that determine the meaning of the other input, with their values. Without ``sun`` there is no Sun;
#: without ``density`` the section of masses contains masses.
_SWITCHES = {"kepler": (0, 1, 2), "sun": (0, 1), "density": (0, 1)}
_PI = {"pi": pi, "-pi": -pi, "+pi": pi}
_SECTIONS = ("masses", "semi-axes", "positions", "velocities", "angles", "angular velocities", "binary ids", "names")


def read_sians(path: Any, units: Any = None, **options: Any) -> tuple[System, State]:
    """Read a system and its state from an input file of SIANS (``initial_values/*.txt``).

    Bodies are ellipsoids, points if all semi-axes are zero, or polyhedra in OBJ files beside the input file or in the
    folder above, with a factor of their size. A polyhedron's state is that of its centre of mass and its principal
    axes; a warning says if the file is in other axes. Angles are in degrees, as in that program (a comment in its
    example file says radians), and angular velocities are along the body axes, per unit time. With ``kepler: 2``
    (semi-major axis, eccentricity, inclination; node, argument of periapsis, mean anomaly) and ``kepler: 1`` (period,
    eccentricity, inclination; node, argument of periapsis, mean longitude counted from the node) the first body rests
    at the origin and the second body has the whole relative state, as in that program.

    With ``sun: 1`` positions and velocities are relative to the Sun, and the Kepler elements of the first body are
    those of its orbit about the Sun. The Sun, of mass 1.989e30 (in kg, or the file's unit), becomes a
    :class:`fullbody.forces.ThirdBody`, and the state is relative to the barycentre.

    Parameters
    ----------
    path : str or Path
    units : {None, "SI", "kmhr", "kms"} or (length, time, mass)
        The program's option ``-units``, which the file does not record. With ``None`` G is 1; with a name it is
        6.67408e-11 in SI, converted to m s kg, km h kg or km s kg; results are plain numbers, and Quantities with three
        units, such as ``("km", "hour", "kg")``. With ``kepler: 1`` periods are in days (in seconds with "kms").
    **options
        Options that are passed to :class:`fullbody.System`.

    Raises
    ------
    InvalidInput
        For missing or invalid input, where the message names the line (``kepler``, which decides whether positions are
        elements, has no default), and for Kepler elements of more than two bodies, which are not supported.

    Warns
    -----
    UserWarning
        If the file has a Sun: in SIANS it acts only on the bodies' centres, while here it also exerts torques on the
        bodies.

    Notes
    -----
    The file's integration settings (``t_end``, ``ntol``, ...) are not used. The program solves Kepler's equation by a
    series to third order in e; here it is solved exactly.

    References
    ----------
    SIANS, https://github.com/alexhosians/SIANS, of Ho, Wold, Poursina & Conway, "On the accuracy of mutual potential
    approximations in simulations of binary asteroids", Astron. Astrophys. (2023).

    Examples
    --------
    >>> import fullbody, pathlib, tempfile
    >>> rows = {"Masses": ("2", "4*1e-1"), "Semiaxes": ("1.0 0.9 0.8", "0.3 0.2 0.2"), "Positions": ("0 0 0", "5 0 0"),
    ...         "Velocities": ("0 0 0", "0 0.7 0"), "Angles, degrees": ("0 0 90", "0 0 0"),
    ...         "Angular velocities": ("0 0 1", "0 0 0.1")}
    >>> text = chr(10).join(["kepler: 0", *(line for name in rows for line in ("@ " + name, *rows[name]))])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "pair.txt")
    ...     _ = path.write_text(text)
    ...     system, state = fullbody.read_sians(path)
    >>> system
    System(['body 0', 'body 1'], G=1.0, gravity='focal')
    >>> state.position[1]
    array([5., 0., 0.])
    """
    names, G, day = _scale(units)
    file = _File(path)
    bodies = _bodies(file)
    angles = np.radians(file.vectors("angles"))
    spin = file.vectors("angular velocities")
    masses = np.array([body.mass for body in bodies])
    if file.switches["kepler"] == 0:
        motion = np.array([file.vectors("positions"), file.vectors("velocities")])
    else:
        motion = _from_elements(file, G, masses, day)
    forces = []
    if file.switches["sun"]:
        motion, orbit = _about_sun(file, motion, G, masses)
        forces.append(ThirdBody(mu=G * _SUN, orbit=orbit, of="system", name="Sun"))
    position, velocity = motion
    with naming(path):
        system = System(bodies, G=G, units=names, **options)
        system = system.with_forces([*system.forces, *forces]) if forces else system
        state = State.from_tait_bryan(position, velocity, angles, spin)
        if any(body.working_frame is not None for body in bodies):
            attitude, spin = along_body_axes(path, bodies, state.attitude, spin)
            state = State(position, velocity, attitude, spin)
    if forces:
        text = "the Sun's gravity: in SIANS it acts on the bodies' centres alone; here it also exerts torques on them"
        caution(f"{path} asks for {text}", UserWarning)
    return system, wrap(state.core, system.context)


def _scale(units: Any) -> tuple[tuple[str, str, str] | None, float, float | None]:
    """Return the units of results, G, and the length of a day in units of time."""
    if units is None:
        return None, 1.0, None
    if isinstance(units, str):
        return None, *_UNITS[choice(units, "units", _UNITS)][1:]
    target = Units(units)
    from astropy import units as u

    G = float((_G_SI * u.m**3 / (u.kg * u.s**2)).to_value(target.unit("G")))
    return target.names, G, float(u.day.to(target.unit("time")))


class _File(Text):
    """An input file: switches, and sections of rows of words."""

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        self.switches = {"sun": 0, "density": 0}
        #: For each section the line of its head, and (line, words) of each row.
        self._sections: list[tuple[int, list[tuple[int, list[str]]]]] = []
        for line, text in enumerate(self.lines, start=1):
            words = text.split("#")[0].split()
            if not words:
                continue
            if words[0].startswith("@"):
                self._sections.append((line, []))
                if len(self._sections) > len(_SECTIONS):
                    self.fail(line, f"one section too many; expected {', '.join(_SECTIONS)}")
            elif self._sections:
                self._sections[-1][1].append((line, words))
            else:
                self._setting(line, words)
        if "kepler" not in self.switches:
            values = " or ".join(f"'kepler: {value}'" for value in _SWITCHES["kepler"])
            self.fail(None, f"no parameter 'kepler'; expected a line {values} before the first section")
        # Only Kepler elements need the section that says which body orbits which.
        needed = _SECTIONS[: 7 if self.switches["kepler"] else 6]
        if missing := needed[len(self._sections) :]:
            self.fail(None, f"no section of {missing[0]}; expected, each after a line with @: {', '.join(needed)}")

    def _setting(self, line: int, words: list[str]) -> None:
        name = words[0].removesuffix(":")
        if name == words[0] or len(words) != 2:
            written = " ".join(words)
            self.fail(line, f"{written!r} is not a setting; expected a name, a colon and a number, such as 'sun: 0'")
        if name not in (options := (*_SETTINGS, *_SWITCHES)):
            self.fail(line, f"{name!r} is not a setting of SIANS; expected one of {', '.join(options)}")
        value = self.number(line, words[1], name)
        if name in _SWITCHES:
            if value not in _SWITCHES[name]:
                self.fail(line, f"{name} is {words[1]}; expected one of {_SWITCHES[name]}")
            self.switches[name] = int(value)

    def head(self, name: str) -> int:
        """Return the line of the head of a section."""
        return self._sections[_SECTIONS.index(name)][0]

    def rows(self, name: str, count: int | None = None) -> list[tuple[int, list[str]]]:
        """Return the rows of a section, one per body, or raise an error if their number differs from the count."""
        index = _SECTIONS.index(name)
        if index >= len(self._sections):
            return []
        start, rows = self._sections[index]
        if count is not None and len(rows) != count:
            text = f"{len(rows)} bodies in the section of {name}; expected {count}, as in the section of masses"
            self.fail(rows[count][0] if len(rows) > count else start, text)
        return rows

    def product(self, line: int, text: str, name: str) -> float:
        """Return the value of a number, or of products of numbers and pi with one division: ``(3*pi)/(2*2)``."""
        factors = re.sub("[()]", "", text).split("/")
        if len(factors) > 2:
            self.fail(line, f"{name} is {text!r}; expected at most one division")
        parts = (factors[0], factors[1] if len(factors) == 2 else "1")
        words = (part.split("*") for part in parts)
        numerator, denominator = (prod(_PI.get(w) or self.number(line, w, name) for w in factor) for factor in words)
        if denominator == 0.0:
            self.fail(line, f"{name} is {text!r}, a division by zero")
        return numerator / denominator

    def vectors(self, name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Return a section with three numbers per body as an array (N, 3)."""
        rows = self.rows(name, len(self.rows("masses")))
        for line, words in rows:
            if len(words) != 3:
                self.fail(line, f"{name} of a body are {len(words)} words; expected three numbers")
        return np.array([[self.product(line, word, name) for word in words] for line, words in rows])


def _bodies(file: _File) -> list[Body]:
    rows = file.rows("masses")
    if len(rows) < 2:
        file.fail(file.head("masses"), f"{len(rows)} bodies in the section of masses; expected two or more")
    names = _names(file, len(rows))
    bodies = []
    for name, (line, words), (axes_line, axes) in zip(names, rows, file.rows("semi-axes", len(rows)), strict=True):
        if len(words) != 1:
            file.fail(line, f"{len(words)} words for a mass; expected one number")
        if len(axes) not in (1, 2, 3):
            file.fail(axes_line, f"{len(axes)} words for semi-axes; expected three numbers, or a polyhedron's file")
        value = file.product(line, words[0], "mass")
        try:
            shape = _shape(file, axes_line, axes)
            # The program, too, multiplies a density by the volume.
            bodies.append(Body(shape, **{"density" if file.switches["density"] else "mass": value}, name=name))
        except InvalidInput as error:
            file.fail(axes_line if "axis" in str(error) else line, str(error))
    return bodies


def _shape(file: _File, line: int, words: list[str]) -> Ellipsoid | PointMass | Polyhedron:
    """Return the shape that a row describes by semi-axes, or by the file of a polyhedron and a factor of its size."""
    if len(words) == 3:
        sizes = [file.product(line, axis, "a semi-axis") for axis in words]
        return Ellipsoid(*sizes) if any(sizes) else PointMass()
    # The program runs in the folder above the folder of its input files.
    folder = as_path(file.path).parent
    paths = [path for path in (folder / words[0], folder.parent / words[0]) if path.is_file()]
    if not paths:
        file.fail(line, f"no file {words[0]!r} beside this one or in the folder above")
    shape = Polyhedron.load(paths[0])
    if len(words) == 1:
        return shape
    factor = file.number(line, words[1], "the factor of a polyhedron's size", POSITIVE)
    return Polyhedron(shape.vertices * factor, shape.faces)


def _names(file: _File, count: int) -> list[str | None]:
    names: list[str | None] = []
    for line, words in file.rows("names") and file.rows("names", count):
        if (name := " ".join(words)) in names:
            file.fail(line, f"{name!r} is the name of body {names.index(name)} too; expected distinct names")
        names.append(name)
    return names or [None] * count


def _from_elements(file: _File, G: float, masses: Any, day: float | None) -> Any:
    """Return positions and velocities (2, 2, 3) relative to the first body, or to the Sun if there is one."""
    if len(masses) > 2:
        file.fail(None, "the file gives Kepler elements for more than two bodies, which fullbody does not read")
    file.rows("binary ids", 2)
    first = np.zeros((2, 3))
    if file.switches["sun"]:
        first = _orbit(file, 0, G * (_SUN + masses[0]), day)
    return np.stack([first, first + _orbit(file, 1, G * masses.sum(), day)], axis=1)


def _orbit(file: _File, body: int, mu: float, day: float | None) -> Any:
    """Return position and velocity (2, 3) from the elements in the rows of a body."""
    angles, (size, e, inclination) = (file.vectors(name)[body] for name in ("positions", "velocities"))
    line = file.rows("velocities")[body][0]
    node, periapsis, angle, inclination = np.radians([*angles, inclination])
    if file.switches["kepler"] == 1:
        if day is None:
            file.fail(line, "the file gives a period in days; read it with units='kmhr' or others")
        size = np.cbrt(mu * (size * day / (2 * np.pi)) ** 2)
        angle -= periapsis
    try:
        return np.array(KeplerElements(size, e, inclination, node, periapsis, angle).to_cartesian(mu))
    except InvalidInput as error:
        file.fail(line, str(error))


def _about_sun(file: _File, motion: Any, G: float, masses: Any) -> tuple[Any, Any]:
    """Return positions and velocities (2, N, 3) from the barycentre, and its orbit about the Sun."""
    # The vectors are first made relative to the first body, which loses no digits.
    relative = motion - motion[:, :1]
    barycentre = np.einsum("n,knx->kx", masses / masses.sum(), relative)
    try:
        r, v = motion[:, 0] + barycentre
        orbit = KeplerElements.from_cartesian(r, v, G * (_SUN + masses.sum()))
    except InvalidInput as error:
        file.fail(file.head("positions"), f"orbit about the Sun: {error}")
    return relative - barycentre[:, None], orbit
