"""``system.toml``: a system, its start and its run, written by a person.

A number is in the system's own units, radians for angles; a text such as ``"2.5 km"`` or ``"3.2 deg"`` names its own.

.. code-block:: toml

    [system]                          # the arguments of fullbody.System
    units = ["km", "hour", "kg"]      # without units: G = 1.0 or another number
    gravity = "focal"

    [[body]]
    name = "Alpha"
    semi_axes = [0.766, 0.7475, 0.6735]   # or radius = 0.7, or point = true
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
import tomllib
from dataclasses import MISSING, dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import named_options
from ..base.atomic import as_path, check_suffix, content
from ..base.units import Units
from ..base.values import Record
from ..errors import InvalidInput
from ..files.netcdf import SUFFIXES
from ..model.bodies import Body, Ellipsoid, PointMass, Sphere
from ..model.state import State
from ..motion.simulation import System
from ..orbit.elements import KeplerElements
from ..record import integrators
from .toml_table import Table

if TYPE_CHECKING:
    from ..motion.simulation import Run

__all__ = ["Setup", "read_toml"]

_RUN = ("until", "output", "start", "origin", "file")
_BODY = (
    *("name", "semi_axes", "radius", "point", "mass", "density"),
    *("position", "velocity", "orbit", "angles", "attitude", "spin", "rotation_period"),
)
_STATE = ("time", "position", "velocity", "spin")
_DIMENSION = {"time": "time", "position": "length", "velocity": "velocity", "spin": "spin"}


@named_options
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Setup(Record):
    """What a ``system.toml`` asks for.

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
        Where the run is to be written.
    """

    path: Path
    system: System
    state: State
    integrator: Any
    until: Any
    output: Any
    file: Path

    def run(self, until: Any = None, progress: Any = False) -> Run:
        """Integrate; nothing is written.

        Parameters
        ----------
        until : float or Quantity, optional
            Another end.
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
            # Whether times fit is known only with the end.
            if "output" not in str(error):
                raise
            raise InvalidInput(f"{self.path}: run: {error}") from error


@named_options
def read_toml(path: Any) -> Setup:
    """Read a ``system.toml``.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Setup
        With ``.system``, ``.state`` and the rest; ``.run()`` integrates it.

    Raises
    ------
    InvalidInput
        Naming the file, the key and what is expected there.
    FileNotFoundError
        Where there is no such file.
    """
    path = as_path(path)
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.is_dir():
        raise InvalidInput(f"{path}: is a folder; expected a file of TOML")
    written = content(path)
    try:
        # With or without the byte order mark that some editors write.
        top = Table(path, "", tomllib.loads(written.decode("utf-8-sig")))
    except UnicodeDecodeError as error:
        is_run = written[:4] in (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
        what = "NetCDF, as runs are recorded; fullbody.load reads those" if is_run else "not text"
        raise InvalidInput(f"{path}: is {what}; expected a file of TOML") from error
    except (ValueError, RecursionError) as error:
        # Not of TOML's own kind where Python's limits end it: for digits, and for brackets in brackets.
        raise InvalidInput(f"{path}: not valid TOML: {error}") from error
    top.only("system", "body", "integrator", "run")
    system_table, run_table = top.table("system"), top.table("run").only(*_RUN)
    units = _units(system_table)
    rows = top.tables("body")
    bodies = [_body(table, units) for table in rows]
    integrator = _integrator(top.table("integrator", required=False), units)
    with system_table.naming(""):
        system = _system(system_table, units, bodies)
    state = _state(run_table, system, units, rows)
    until = run_table.value("until", "time", units, ())
    output = run_table.value("output", "time", units, None) if "output" in run_table else None
    if output is not None and output.ndim == 0 and output <= 0.0:
        raise run_table.fault(
            "output", f"is {run_table.content['output']!r}; expected a spacing above zero, or a list of times"
        )
    name = run_table.text("file") if "file" in run_table else f"{path.stem}.nc"
    with run_table.naming("file"):
        check_suffix(name, SUFFIXES)
    attach = units.attach
    return Setup(
        path,
        system,
        state,
        integrator,
        attach(float(until), "time"),
        None if output is None else attach(output if output.ndim else float(output), "time"),
        path.parent / name,
    )


def _units(table: Table) -> Units:
    value = table.content.get("units")
    with table.naming("units"):
        return Units(tuple(value) if isinstance(value, list) else value)


def _body(table: Table, units: Units) -> Body:
    table.only(*_BODY)
    name = table.text("name") if "name" in table else None
    shapes = [key for key in ("semi_axes", "radius", "point") if key in table]
    if len(shapes) != 1:
        given = " and ".join(shapes) or "none"
        raise table.fault("", f"has {given} of semi_axes, radius, point; expected one of the three")
    masses = [key for key in ("mass", "density") if key in table]
    shape: Ellipsoid | Sphere | PointMass
    with table.naming(shapes[0]):
        if shapes[0] == "semi_axes":
            shape = Ellipsoid(*map(float, table.value("semi_axes", "length", units, (3,))))
        elif shapes[0] == "radius":
            shape = Sphere(float(table.value("radius", "length", units, ())))
        elif table.content["point"] is True:
            shape = PointMass()
        else:
            raise table.fault("point", f"is {table.content['point']!r}; expected true")
    values = {key: float(table.value(key, key, units, ())) for key in masses}
    with table.naming(masses[0] if len(masses) == 1 else ""):
        return Body(shape, name=name, **values)


def _integrator(table: Table, units: Units) -> Any:
    kinds: dict[str, Any] = {
        name: kind for name in integrators.__all__ if is_dataclass(kind := getattr(integrators, name))
    }
    # The base of all integrators, if there is one, is none itself; the default of System.integrate comes first.
    bases = {base for kind in kinds.values() for base in kind.__mro__[1:]}
    names = sorted((n for n, kind in kinds.items() if kind not in bases), key=lambda name: name != "Verner98")
    kind = kinds[table.choice("name", tuple(names))]
    known = fields(kind)
    table.only("name", *(setting.name for setting in known))
    settings = {setting.name: table.content[setting.name] for setting in known if setting.name in table}
    for setting in known:
        if setting.default is MISSING and setting.name not in table:
            raise table.fault(setting.name, f"is missing; {kind.__name__} needs it")
    if "step" in settings:
        settings["step"] = units.attach(float(table.value("step", "time", units, ())), "time")
    with table.naming(""):
        return kind(**settings)


def _system(table: Table, units: Units, bodies: list[Body]) -> System:
    table.only(*(name for name in inspect.signature(System).parameters if name != "bodies"))
    parameters = [name for name in inspect.signature(System).parameters if name not in ("bodies", "G", "units")]
    options = {name: table.content[name] for name in parameters if name in table}
    if isinstance(options.get("order"), list):
        options["order"] = tuple(options["order"])
    G = float(table.value("G", "G", units, ())) if "G" in table else None
    return System(bodies, G, units=units.names, **options)


def _state(run: Table, system: System, units: Units, tables: list[Table]) -> State:
    count = len(tables)
    position, velocity, spin = np.zeros((3, count, 3))
    attitude = np.zeros((count, 4))
    for k, table in enumerate(tables):
        position[k], velocity[k] = _motion(table, k, system, units, position, velocity)
        attitude[k] = _attitude(table, units)
        spin[k] = _spin(table, units)
    if run.choice("origin", ("given", "barycentre")) == "barycentre":
        weights = np.array([body._core(units, k).mass for k, body in enumerate(system.bodies)])
        weights /= weights.sum()
        position, velocity = position - weights @ position, velocity - weights @ velocity
    start = float(run.value("start", "time", units, ())) if "start" in run else 0.0
    values = {"time": start, "position": position, "velocity": velocity, "spin": spin}
    with run.naming(""):
        state = State(attitude=attitude, **{name: units.attach(values[name], _DIMENSION[name]) for name in _STATE})
    return state._named(system.names)


def _motion(
    table: Table, k: int, system: System, units: Units, position: Any, velocity: Any
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    given = [key for key in ("position", "velocity", "orbit") if key in table]
    if "orbit" not in given:
        if k > 0 and "position" not in given:
            raise table.fault("", "has no position and no orbit; expected one of them")
        return tuple(  # type: ignore[return-value]
            table.value(key, _DIMENSION[key], units, (3,)) if key in given else np.zeros(3)
            for key in ("position", "velocity")
        )
    if len(given) > 1:
        raise table.fault("", f"has {' and '.join(given)}; expected an orbit, or position and velocity")
    orbit = table.table("orbit").only("about", "a", "e", "i", "Omega", "omega", "M")
    about = orbit.text("about", "the name of a body above this one")
    above = system.names[:k]
    if above.count(about) != 1:
        raise orbit.fault("about", f"is {about!r}; expected the name of one body above this one: {', '.join(above)}")
    values = {"a": float(orbit.value("a", "length", units, ())), "e": float(orbit.value("e", None, units, ()))}
    angles = {name: float(orbit.value(name, "angle", units, ())) for name in ("i", "Omega", "omega", "M")}
    j = above.index(about)
    with orbit.naming(""):
        mu = float(units.strip(system.mu(j, k), "mu", "mu"))
        r, v = KeplerElements(**values, **angles).to_cartesian(mu)
    return position[j] + r, velocity[j] + v


def _attitude(table: Table, units: Units) -> npt.NDArray[np.float64]:
    given = [key for key in ("attitude", "angles") if key in table]
    if len(given) == 2:
        raise table.fault("", "has attitude and angles; expected one of the two")
    if given == ["attitude"]:
        value = table.value("attitude", None, units, (4,))
        if not value.any():
            raise table.fault("attitude", "is zero; expected a quaternion [w, x, y, z]")
        return value
    angles = table.value("angles", "angle", units, (3,)) if given else np.zeros(3)
    zero = np.zeros((1, 3))
    return np.asarray(State.from_tait_bryan(zero, zero, angles[None]).attitude[0])


def _spin(table: Table, units: Units) -> npt.NDArray[np.float64]:
    given = [key for key in ("spin", "rotation_period") if key in table]
    if len(given) == 2:
        raise table.fault("", "has spin and rotation_period; expected one of the two")
    if given == ["spin"]:
        return table.value("spin", "spin", units, (3,))
    if not given:
        return np.zeros(3)
    period = float(table.value("rotation_period", "time", units, ()))
    if period == 0.0:
        raise table.fault("rotation_period", "is 0; expected a time, negative for a retrograde spin")
    return np.array([0.0, 0.0, 2.0 * np.pi / period])
