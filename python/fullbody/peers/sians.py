"""Input files of SIANS, the program of the paper's authors."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.arguments import named_options
from ..base.units import Units
from ..errors import InvalidInput
from ..model.bodies import Body, Ellipsoid, PointMass
from ..orbit.elements import KeplerElements
from ._text import fail, naming, number, read_lines

if TYPE_CHECKING:
    from ..model.state import State
    from ..motion.simulation import System

__all__ = ["read_sians"]

#: The program's own constant, m^3 kg^-1 s^-2.
_G_SI = 6.67408e-11
#: Its names of units: (length, time, mass), G in them, and its periods in them (it takes "kms" periods as seconds).
_UNITS: dict[str | None, tuple[tuple[str, str, str], float, float]] = {
    "SI": (("m", "s", "kg"), _G_SI, 86400.0),
    "kmhr": (("km", "hour", "kg"), _G_SI * 3600.0**2 / 1000.0**3, 24.0),
    "kms": (("km", "s", "kg"), _G_SI / 1000.0**3, 1.0),
}
_SETTINGS = ("t_end", "N", "ntol", "iabstol", "ireltol", "quadval", "quadnode", "hmax", "hmin", "t_start", "pmdist")
#: What decides on the meaning of the rest, and its values. Without ``sun`` there is none, without ``density`` the
#: section of masses has masses.
_SWITCHES = {"kepler": (0, 1, 2), "sun": (0, 1), "density": (0, 1)}
_SECTIONS = ("masses", "semi-axes", "positions", "velocities", "angles", "angular velocities", "binary ids", "names")


@named_options
def read_sians(path: Any, units: Any = None, **options: Any) -> tuple[System, State]:
    """A system and its state from an input file of SIANS (``initial_values/*.txt``).

    Bodies are ellipsoids, or points where all semi-axes are zero. Angles are degrees, as that program takes them
    (a comment in its example file says radians), and angular velocities are along the body axes, per unit time.
    With ``kepler: 2`` (semi-major axis, eccentricity, inclination; node, argument of periapsis, mean anomaly) and
    ``kepler: 1`` (period, eccentricity, inclination; node, argument of periapsis, mean longitude counted from the
    node) the first body rests at the origin and the second carries the whole relative state, as there.

    Parameters
    ----------
    path : str or Path
    units : {None, "SI", "kmhr", "kms"} or (length, time, mass)
        The program's option ``-units``, which the file itself does not record: G = 1, or its G = 6.67408e-11 in m s kg,
        km h kg or km s kg, and results are plain numbers. Three units, such as ``("km", "hour", "kg")``: the same G in
        them, and results are Quantities. With ``kepler: 1`` periods are days (seconds with "kms").
    **options
        Passed to :class:`fullbody.System`.

    Returns
    -------
    system : System
    state : State

    Raises
    ------
    InvalidInput
        For what is not a number, with the file's line, or not there (``kepler`` decides whether positions are elements
        and has no default); and for what this package does not have: polyhedra, the Sun's gravity, Kepler elements of
        more than two bodies.

    Notes
    -----
    The file's integration settings (``t_end``, ``ntol``, ...) are read and not used. The program solves Kepler's
    equation by a series to the third order in e; here it is solved exactly.

    References
    ----------
    SIANS, https://github.com/alexhosians/SIANS, of Ho, Wold, Poursina & Conway, "On the accuracy of mutual potential
    approximations in simulations of binary asteroids", Astron. Astrophys. (2023).

    Examples
    --------
    >>> import fullbody, pathlib, tempfile
    >>> text = '''
    ... kepler: 0
    ... @ Masses
    ... 2.0
    ... 4*1e-1
    ... @ Semiaxes
    ... 1.0 0.9 0.8
    ... 0.3 0.2 0.2
    ... @ Positions
    ... 0 0 0
    ... 5 0 0
    ... @ Velocities
    ... 0 0 0
    ... 0 0.7 0
    ... @ Angles, degrees
    ... 0 0 90
    ... 0 0 0
    ... @ Angular velocities
    ... 0 0 1
    ... 0 0 0.1
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "pair.txt")
    ...     _ = path.write_text(text)
    ...     system, state = fullbody.read_sians(path)
    >>> system
    System(['body 0', 'body 1'], G=1.0, gravity='focal')
    >>> state.position[1]
    array([5., 0., 0.])
    """
    from ..model.state import State
    from ..motion.simulation import System

    names, G, day = _scale(units)
    file = _parse(path)
    bodies = _bodies(path, file)
    angles = np.radians(_vectors(path, file, "angles"))
    spin = _vectors(path, file, "angular velocities")
    if file.switches["kepler"] == 0:
        position, velocity = _vectors(path, file, "positions"), _vectors(path, file, "velocities")
    else:
        masses = [body.mass for body in bodies]
        position, velocity = _from_elements(path, file, G * sum(masses), day)
    with naming(path):
        system = System(bodies, G=G, units=names, **options)
        attach = system._units.attach
        state = State.from_tait_bryan(
            attach(position, "length"),
            attach(velocity, "velocity"),
            angles,
            attach(spin, "spin"),
            attach(np.float64(0.0), "time"),
        )
    return system, state._named(system.names)


def _scale(units: Any) -> tuple[tuple[str, str, str] | None, float, float | None]:
    """Units of results, G, and days in units of time."""
    if units is None:
        return None, 1.0, None
    if isinstance(units, str):
        if units not in _UNITS:
            raise InvalidInput(f"units is {units!r}; expected None, 'SI', 'kmhr', 'kms' or (length, time, mass)")
        _, G, day = _UNITS[units]
        return None, G, day
    wanted = Units(units)
    from astropy import units as u

    G = float((_G_SI * u.m**3 / (u.kg * u.s**2)).to_value(wanted.unit("G")))
    return wanted.names, G, float(u.day.to(wanted.unit("time")))


@dataclass
class _File:
    """Rows of a section are (line, words)."""

    switches: dict[str, int] = field(default_factory=lambda: {"sun": 0, "density": 0})
    sections: list[list[tuple[int, list[str]]]] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)

    def rows(self, name: str) -> list[tuple[int, list[str]]]:
        index = _SECTIONS.index(name)
        return self.sections[index] if index < len(self.sections) else []


def _parse(path: Any) -> _File:
    file = _File()
    for line, text in enumerate(read_lines(path), start=1):
        words = text.split("#")[0].split()
        if not words:
            continue
        if words[0].startswith("@"):
            file.sections.append([])
            file.starts.append(line)
            if len(file.sections) > len(_SECTIONS):
                fail(path, line, f"one section too many; expected {', '.join(_SECTIONS)}")
        elif file.sections:
            file.sections[-1].append((line, words))
        else:
            _setting(path, line, words, file)
    if "kepler" not in file.switches:
        values = " or ".join(f"'kepler: {value}'" for value in _SWITCHES["kepler"])
        fail(path, None, f"no parameter 'kepler'; expected a line {values} before the first section")
    # Which body goes about which is asked of Kepler elements only.
    needed = _SECTIONS[: 7 if file.switches["kepler"] else 6]
    missing = needed[len(file.sections) :]
    if missing:
        fail(path, None, f"no section of {missing[0]}; expected, each after a line with @: {', '.join(needed)}")
    return file


def _setting(path: Any, line: int, words: list[str], file: _File) -> None:
    name = words[0].removesuffix(":")
    if name == words[0] or len(words) != 2:
        fail(path, line, f"{' '.join(words)!r} is no setting; expected a name, a colon and a number, such as 'sun: 0'")
    if name not in (*_SETTINGS, *_SWITCHES):
        fail(path, line, f"{name!r} is no setting of SIANS; expected one of {', '.join((*_SETTINGS, *_SWITCHES))}")
    value = number(path, line, words[1], name)
    if name in _SWITCHES:
        if value not in _SWITCHES[name]:
            fail(path, line, f"{name} is {words[1]}; expected one of {_SWITCHES[name]}")
        if name == "sun" and value == 1:
            fail(path, line, "the file asks for the Sun's gravity, which fullbody does not have")
        file.switches[name] = int(value)


def _value(path: Any, line: int, text: str, what: str) -> float:
    """A number, or products with one division, of numbers and pi: ``(3*pi)/(2*2)``."""
    factors = re.sub("[()]", "", text).split("/")
    if len(factors) > 2:
        fail(path, line, f"{what} is {text!r}; expected at most one division")
    products = []
    for factor in factors:
        total = 1.0
        for term in factor.split("*"):
            total *= {"pi": pi, "-pi": -pi, "+pi": pi}.get(term) or number(path, line, term, what)
        products.append(total)
    if len(products) == 2 and products[1] == 0.0:
        fail(path, line, f"{what} is {text!r}, a division by zero")
    return products[0] / products[1] if len(products) == 2 else products[0]


def _vectors(path: Any, file: _File, name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """A section of three numbers a body (N, 3)."""
    count, rows = len(file.rows("masses")), file.rows(name)
    _check_count(path, file, name, count)
    for line, words in rows:
        if len(words) != 3:
            fail(path, line, f"{name} of a body are {len(words)} words; expected three numbers")
    return np.array([[_value(path, line, word, name) for word in words] for line, words in rows])


def _check_count(path: Any, file: _File, name: str, count: int) -> None:
    rows = file.rows(name)
    if len(rows) != count:
        start = file.starts[_SECTIONS.index(name)]
        line = rows[count][0] if len(rows) > count else start
        fail(path, line, f"{len(rows)} bodies in the section of {name}; expected {count}, as in the section of masses")


def _bodies(path: Any, file: _File) -> list[Body]:
    rows = file.rows("masses")
    if len(rows) < 2:
        fail(path, file.starts[0], f"{len(rows)} bodies in the section of masses; expected two or more")
    _check_count(path, file, "semi-axes", len(rows))
    names = _names(path, file, len(rows))
    bodies = []
    for index, ((line, words), (axes_line, axes)) in enumerate(zip(rows, file.rows("semi-axes"), strict=True)):
        if len(words) != 1:
            fail(path, line, f"{len(words)} words for a mass; expected one number")
        if len(axes) in (1, 2):
            fail(path, axes_line, f"the file asks for the polyhedron {axes[0]!r}, which fullbody does not have")
        if len(axes) != 3:
            fail(path, axes_line, f"{len(axes)} words for semi-axes; expected three numbers")
        value = _value(path, line, words[0], "mass")
        sizes = [_value(path, axes_line, axis, "a semi-axis") for axis in axes]
        name = names[index]
        try:
            point = not any(sizes)
            shape = PointMass() if point else Ellipsoid(*sizes)
            if file.switches["density"]:
                # The program multiplies density by volume in just this way.
                bodies.append(Body(shape, density=value, name=name))
            else:
                bodies.append(Body(shape, mass=value, name=name))
        except InvalidInput as error:
            fail(path, axes_line if "axis" in str(error) else line, str(error))
    return bodies


def _names(path: Any, file: _File, count: int) -> list[str | None]:
    rows = file.rows("names")
    if not rows:
        return [None] * count
    _check_count(path, file, "names", count)
    names: list[str | None] = []
    for line, words in rows:
        if (name := " ".join(words)) in names:
            fail(path, line, f"{name!r} is the name of body {names.index(name)} too; expected distinct names")
        names.append(name)
    return names


def _from_elements(path: Any, file: _File, mu: float, day: float | None) -> tuple[Any, Any]:
    if len(file.rows("masses")) > 2:
        fail(path, None, "the file gives Kepler elements for more than two bodies, which fullbody does not read")
    _check_count(path, file, "binary ids", 2)
    (node, periapsis, angle), (size, e, inclination) = (
        _vectors(path, file, name)[1] for name in ("positions", "velocities")
    )
    line = file.rows("velocities")[1][0]
    node, periapsis, angle, inclination = np.radians([node, periapsis, angle, inclination])
    if file.switches["kepler"] == 1:
        if day is None:
            fail(path, line, "the file gives a period in days; read it with units='kmhr' or others")
        size = np.cbrt(mu * (size * day / (2 * np.pi)) ** 2)
        angle -= periapsis
    try:
        r, v = KeplerElements(size, e, inclination, node, periapsis, angle).to_cartesian(mu)
    except InvalidInput as error:
        fail(path, line, str(error))
    return np.array([np.zeros(3), r]), np.array([np.zeros(3), v])
