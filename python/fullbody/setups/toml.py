"""``system.toml``: a text file that describes a system, its start and its run.

A number is in the system's own units, radians for angles; a text such as ``"2.5 km"`` or ``"3.2 deg"`` names its own.

.. code-block:: toml

    [system]                          # the arguments of fullbody.System
    units = ["km", "hour", "kg"]      # without units: G = 1.0 or another number
    gravity = "focal"

    [[body]]
    name = "Alpha"
    semi_axes = [0.766, 0.7475, 0.6735]   # or radius = 0.7, or point = true, or polyhedron = "alpha.obj"
                                          # or { vertices = [[1, 0, 0], ...], faces = [[0, 1, 2], ...] }
    mass = 2.353e12                       # or density = "2 g/cm3"
    angles = ["3.2 deg", 0, 0]            # Tait-Bryan; or attitude = [w, x, y, z]
    spin = [0, 0, 2.2728]                 # body frame; or rotation_period = "2.7645 hour", about the body's z

    [[body]]
    name = "Beta"
    semi_axes = [0.285, 0.2315, 0.1745]
    mass = 0.135e12
    orbit = { about = "Alpha", a = 2.548, e = 0.0004, i = 0, Omega = 0, omega = 0, M = 0 }
    # or position = [2.5, 0, 0] and velocity = [0, 0.9, 0]
    spin = [0, 0, 0.3611]
    # a body of several parts has, in place of semi_axes and mass, for each of them, in a frame of their own:
    #   [[body.part]]
    #   radius = "110 m"              # as above; a mass or density below zero makes a void
    #   density = "2.4 g/cm3"
    #   position = ["-105 m", 0, 0]   # or none; angles or attitude turn the part

    [[forces]]                        # the arguments of a class of fullbody.forces; may be left out
    kind = "ThirdBody"
    name = "Sun"
    mass = "1 M_sun"                  # or mu = ...
    of = "system"                     # whose orbit it is: the system's about the Sun; "body": the third body's
    orbit = { a = "0.64 au", e = 0.69, i = "38.9 deg", Omega = "245 deg", omega = "193 deg", M = 0 }
    # or times = [0, 10, 20, 30] and positions = [[1e6, 0, 0], ...]

    [[forces]]
    kind = "Tide"                     # or "Yorp", "Byorp"
    on = "Alpha"
    by = "Beta"
    k2 = 1e-5
    lag = "30 s"

    [integrator]
    name = "Verner98"
    rtol = 1e-13

    [run]
    until = "30 day"
    output = "1 hour"                 # or a list of times; without it, every step
    start = 0                         # time of the state
    origin = "barycentre"             # moves the barycentre to rest at the origin; without it "given": all stays
    file = "kw4.nc"                   # beside this file; without it, this file's name with .nc
"""

from __future__ import annotations

import inspect
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import name_of
from ..base.atomic import as_path, check_suffix, content
from ..base.units import Units
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..files.netcdf import SUFFIXES
from ..model.bodies import Body
from ..model.composite import Composite, Part
from ..model.force import Force
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, PointMass, Solid, Sphere
from ..model.state import State
from ..motion.run import Run
from ..motion.system import System
from ..record import integrators
from .toml_forces import ELEMENTS, elements, force
from .toml_table import Table

__all__ = ["Configuration", "read_toml"]

_RUN = ("until", "output", "start", "origin", "file")
#: The keys that describe a shape with a mass.
_SOLID = ("semi_axes", "radius", "point", "polyhedron", "mass", "density")
_PART = (*_SOLID, "position", "angles", "attitude")
_BODY = (
    *("name", *_SOLID, "part"),
    *("position", "velocity", "orbit", "angles", "attitude", "spin", "rotation_period"),
)
#: The choices of ``origin``, the default first.
_INTEGRATORS = tuple(sorted(integrators.__all__, key=lambda name: name != "Verner98"))
_Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Configuration(ArrayFields):
    """A system, its start and the options of its run, as read from a ``system.toml``.

    Attributes
    ----------
    path : Path
        The file it was read from.
    system : System
    state : State
    integrator
        An integrator with its settings.
    until : float or Quantity
    output : None, float, ndarray or Quantity
    file : Path
        The file to which the run is to be written.
    """

    path: Path
    system: System
    state: State
    integrator: Any
    until: Any
    output: Any
    file: Path

    def run(self, until: Any = None, progress: Any = False) -> Run:
        """Integrate the system without writing a file.

        Parameters
        ----------
        until : float or Quantity, optional
            Another end time than that of the file.
        progress : bool or callable

        Returns
        -------
        Run
        """
        end = self.until if until is None else until
        try:
            return self.system.integrate(
                self.state, end, output=self.output, integrator=self.integrator, progress=progress
            )
        except InvalidInput as error:
            # Whether the times fit is known only when the end is.
            if "output" not in str(error):
                raise
            raise InvalidInput(f"{self.path}: run: {error}") from error


def read_toml(path: Any) -> Configuration:
    """Read a ``system.toml``.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Configuration
        The contents of the file, with the attributes ``system`` and ``state``; its method ``run()`` integrates it.

    Raises
    ------
    InvalidInput
        For invalid contents; the message names the file, the key and what is expected there.
    FileNotFoundError
        If there is no such file.
    """
    path = as_path(path)
    top = Table(path, "", _content(path), Units())
    top.only("system", "body", "forces", "integrator", "run")
    top.units = _units(top.table("system"))
    run, rows = top.table("run").only(*_RUN), top.tables("body")
    bodies = [_body(row) for row in rows]
    integrator = _integrator(top.table("integrator", required=False))
    forces = [force(row) for row in top.tables("forces")] if "forces" in top else []
    system = _system(top.table("system"), bodies, forces)
    state = _state(run, system, rows)
    attach = top.units.attach
    return Configuration(
        path,
        system,
        state,
        integrator,
        attach(run.number("until", "time"), "time"),
        attach(_output(run), "time") if "output" in run else None,
        path.parent / _file(run),
    )


def _content(path: Path) -> dict[str, Any]:
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.is_dir():
        raise InvalidInput(f"{path}: is a folder; expected a file of TOML")
    written = content(path)
    import tomllib

    try:
        # The byte order mark that some editors write is accepted.
        return tomllib.loads(written.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        is_run = written[:4] in (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
        what = "NetCDF, as runs are recorded; fullbody.load reads those" if is_run else "not text"
        raise InvalidInput(f"{path}: is {what}; expected a file of TOML") from error
    except (ValueError, RecursionError) as error:
        # Python's limits on the digits of a number and on nested brackets raise these errors.
        raise InvalidInput(f"{path}: not valid TOML: {error}") from error


def _units(system: Table) -> Units:
    value = system.content.get("units")
    with system.naming("units"):
        return Units(tuple(value) if isinstance(value, list) else value)


def _output(run: Table) -> Any:
    """Return the output: a positive spacing, or times."""
    value = run.content["output"]
    if isinstance(value, list):
        return run.vector("output", "time")
    spacing = run.number("output", "time")
    if spacing <= 0.0:
        raise run.fault("output", f"is {value!r}; expected a spacing above zero, or a list of times")
    return spacing


def _file(run: Table) -> str:
    name = run.text("file") if "file" in run else f"{run.path.stem}.nc"
    with run.naming("file"):
        check_suffix(name, SUFFIXES)
    return name


def _body(table: Table) -> Body:
    table.only(*_BODY)
    if "part" in table:
        return _composite(table)
    shape = _shape(table)
    masses = [key for key in ("mass", "density") if key in table]
    values = {key: table.number(key, key) for key in masses}
    name = _name(table)
    with table.naming(masses[0] if len(masses) == 1 else ""):
        return Body(shape, name=name, **values)


def _name(table: Table) -> str | None:
    """Return the name of a body, or ``None`` if it has none."""
    with table.naming("name"):
        return name_of(table.text("name") if "name" in table else None)


def _composite(table: Table) -> Body:
    """Make a body of several parts, each of which has its own table."""
    for key in _SOLID:
        if key in table:
            raise table.fault(key, "is given beside [[body.part]]; expected it in the parts")
    rows = table.tables("part")
    parts = []
    for row in rows:
        row.only(*_PART)
        shape = _shape(row)
        masses = {key: row.number(key, key) for key in ("mass", "density") if key in row}
        position = row.vector("position", "length", 3) if "position" in row else None
        with row.naming(""):
            parts.append(Part(shape, position=position, attitude=_attitude(row), **masses))
    name = _name(table)
    with table.naming("part"):
        return Body(Composite(parts), name=name)


def _shape(table: Table) -> Solid:
    key = table.one_of("semi_axes", "radius", "point", "polyhedron")
    if key is None:
        raise table.fault("", "has none of semi_axes, radius, point, polyhedron; expected one of them")
    if key == "polyhedron":
        return _polyhedron(table)
    with table.naming(key):
        if key == "semi_axes":
            return Ellipsoid(*map(float, table.vector(key, "length", 3)))
        if key == "radius":
            return Sphere(table.number(key, "length"))
        if table.content[key] is not True:
            raise table.fault(key, f"is {table.content[key]!r}; expected true")
        return PointMass()


def _polyhedron(table: Table) -> Polyhedron:
    """Make a polyhedron, in the system's units, from a file beside this one or from the table itself."""
    if isinstance(table.content["polyhedron"], str):
        with table.naming("polyhedron"):
            return Polyhedron.load(table.path.parent / table.text("polyhedron"))
    mesh = table.table("polyhedron").only("vertices", "faces")
    faces = mesh.take("faces", "lists of three whole numbers")
    mesh.take("vertices", "lists of three numbers")
    with mesh.naming(""):
        return Polyhedron(np.array(mesh.array("vertices", "length")), faces)


def _integrator(table: Table) -> Any:
    kind = getattr(integrators, table.choice("name", _INTEGRATORS))
    known = fields(kind)
    table.only("name", *(setting.name for setting in known))
    for setting in known:
        if setting.default is MISSING and setting.name not in table:
            raise table.fault(setting.name, f"is missing; {kind.__name__} needs it")
    settings = {key: value for key, value in table.content.items() if key != "name"}
    if "step" in settings:
        settings["step"] = table.units.attach(table.number("step", "time"), "time")
    with table.naming(""):
        return kind(**settings)


def _system(table: Table, bodies: list[Body], forces: list[Force]) -> System:
    known = [name for name in inspect.signature(System).parameters if name not in ("bodies", "forces")]
    options = dict(table.only(*known).content)
    if isinstance(options.get("order"), list):
        options["order"] = tuple(options["order"])
    if "G" in table:
        options["G"] = table.number("G", "G")
    with table.naming(""):
        return System(bodies, forces=forces, **{**options, "units": table.units.names})


def _state(run: Table, system: System, rows: list[Table]) -> State:
    count = len(rows)
    position, velocity, spin = np.zeros((3, count, 3))
    attitude = np.zeros((count, 4))
    for k, row in enumerate(rows):
        position[k], velocity[k] = _motion(row, system, position[:k], velocity[:k])
        attitude[k] = _attitude(row)
        spin[k] = _spin(row)
    if run.choice("origin", ("given", "barycentre")) == "barycentre":
        weights = system._masses / system._masses.sum()
        position, velocity = position - weights @ position, velocity - weights @ velocity
    start = run.number("start", "time") if "start" in run else 0.0
    attach = run.units.attach
    with run.naming(""):
        state = State(
            position=attach(position, "length"),
            velocity=attach(velocity, "velocity"),
            attitude=attitude,
            spin=attach(spin, "spin"),
            time=attach(start, "time"),
        )
    return state._named(system.names)


def _motion(table: Table, system: System, position: _Array, velocity: _Array) -> tuple[_Array, _Array]:
    """Return a body's position and velocity, given those of the bodies above it."""
    k = len(position)
    given = [key for key in ("position", "velocity", "orbit") if key in table]
    if "orbit" not in given:
        if k > 0 and "position" not in given:
            raise table.fault("", "has no position and no orbit; expected one of them")
        return (
            table.vector("position", "length", 3) if "position" in given else np.zeros(3),
            table.vector("velocity", "velocity", 3) if "velocity" in given else np.zeros(3),
        )
    if len(given) > 1:
        raise table.fault("", f"has {' and '.join(given)}; expected an orbit, or position and velocity")
    orbit = table.table("orbit").only("about", *ELEMENTS)
    about = orbit.text("about", "the name of a body above this one")
    above = system.names[:k]
    if above.count(about) != 1:
        raise orbit.fault("about", f"is {about!r}; expected the name of one body above this one: {', '.join(above)}")
    shape, j = elements(orbit), above.index(about)
    with orbit.naming(""):
        mu = float(table.units.strip(system.mu(j, k), "mu", "mu"))
        r, v = shape.to_cartesian(mu)
    return position[j] + r, velocity[j] + v


def _attitude(table: Table) -> _Array:
    if table.one_of("attitude", "angles") == "attitude":
        value = table.vector("attitude", None, 4)
        if not value.any():
            raise table.fault("attitude", "is zero; expected a quaternion [w, x, y, z]")
        return value
    angles = table.vector("angles", "angle", 3) if "angles" in table else np.zeros(3)
    zero = np.zeros((1, 3))
    return np.asarray(State.from_tait_bryan(zero, zero, angles[None]).attitude[0])


def _spin(table: Table) -> _Array:
    match table.one_of("spin", "rotation_period"):
        case "spin":
            return table.vector("spin", "spin", 3)
        case "rotation_period":
            period = table.number("rotation_period", "time")
            if period == 0.0:
                raise table.fault("rotation_period", "is 0; expected a time, negative for a retrograde spin")
            return np.array([0.0, 0.0, 2.0 * np.pi / period])
    return np.zeros(3)
