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
    origin = "barycentre"             # moves the barycentre to rest at the origin; "given" leaves all as it stands
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

from . import integrators
from ._arguments import suggestion
from ._records import Record
from ._units import Units, from_text
from .bodies import Body, Ellipsoid, PointMass, Sphere
from .elements import KeplerElements
from .errors import FullbodyError, InvalidInput
from .state import State
from .system import System

if TYPE_CHECKING:
    from .run import Run

__all__ = ["Setup", "read_toml"]

_RUN = ("until", "output", "start", "origin", "file")
_BODY = (
    *("name", "semi_axes", "radius", "point", "mass", "density"),
    *("position", "velocity", "orbit", "angles", "attitude", "spin", "rotation_period"),
)
_STATE = ("time", "position", "velocity", "spin")
_DIMENSION = {"time": "time", "position": "length", "velocity": "velocity", "spin": "spin"}


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
        return self.system.integrate(self.state, end, output=self.output, integrator=self.integrator, progress=progress)


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
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.is_dir():
        raise InvalidInput(f"{path}: is a folder; expected a file of TOML")
    try:
        with path.open("rb") as file:
            content = tomllib.load(file)
    except UnicodeDecodeError as error:
        is_run = path.read_bytes()[:4] in (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
        what = "NetCDF, as runs are recorded; fullbody.load reads those" if is_run else "not text"
        raise InvalidInput(f"{path}: is {what}; expected a file of TOML") from error
    except tomllib.TOMLDecodeError as error:
        raise InvalidInput(f"{path}: not valid TOML: {error}") from error
    top = _Table(path, "", content).only("system", "body", "integrator", "run")
    system_table, run_table = top.table("system"), top.table("run").only(*_RUN)
    units = Units(_units(system_table))
    rows = [_body(table, units) for table in top.tables("body")]
    integrator = _integrator(top.table("integrator", required=False), units)
    with system_table.naming(""):
        system = _system(system_table, units, [body for body, _ in rows])
    state = _state(run_table, system, units, [start for _, start in rows])
    until = run_table.value("until", "time", units, ())
    output = run_table.value("output", "time", units, None) if "output" in run_table else None
    file = path.parent / (run_table.text("file") if "file" in run_table else f"{path.stem}.nc")
    attach = units.attach
    return Setup(
        path,
        system,
        state,
        integrator,
        attach(float(until), "time"),
        None if output is None else attach(output if output.ndim else float(output), "time"),
        file,
    )


class _Table:
    """A table of the file that knows its place."""

    def __init__(self, path: Path, place: str, content: dict[str, Any]) -> None:
        self.path, self.place, self.content = path, place, content

    def __contains__(self, key: str) -> bool:
        return key in self.content

    def fault(self, key: str, message: str) -> InvalidInput:
        """An error that names file and key."""
        place = ".".join(part for part in (self.place, key) if part)
        return InvalidInput(f"{self.path}: {place}: {message}" if place else f"{self.path}: {message}")

    def naming(self, key: str) -> _Naming:
        """A context in which this package's errors gain file and key."""
        return _Naming(self, key)

    def take(self, key: str, expected: str) -> Any:
        """A value that must be there."""
        if key not in self:
            raise self.fault(key, f"is missing; expected {expected}")
        return self.content[key]

    def text(self, key: str, expected: str = "text") -> str:
        """A text."""
        value = self.take(key, expected)
        if not isinstance(value, str):
            raise self.fault(key, f"is {value!r}; expected {expected}")
        return value

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """One of some texts; the first where nothing is said."""
        value = self.content[key] if key in self else choices[0]
        if value not in choices:
            raise self.fault(key, f"is {value!r}; expected one of {', '.join(map(repr, choices))}")
        return str(value)

    def table(self, key: str, required: bool = True) -> _Table:
        """A table below this one."""
        value = self.take(key, "a table") if required else self.content.get(key, {}) if key in self else {}
        if not isinstance(value, dict):
            raise self.fault(key, f"is {value!r}; expected a table")
        return _Table(self.path, f"{self.place}.{key}" if self.place else key, value)

    def tables(self, key: str) -> list[_Table]:
        """The tables of an array such as ``[[body]]``."""
        value = self.take(key, f"at least one [[{key}]]")
        if not isinstance(value, list) or not value or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, f"is {value!r}; expected tables, each headed [[{key}]]")
        return [_Table(self.path, f"{key}[{k}]", item) for k, item in enumerate(value)]

    def value(
        self, key: str, dimension: str | None, units: Units, shape: tuple[int, ...] | None
    ) -> npt.NDArray[np.float64]:
        """Numbers, or texts with units, as numbers in the system's units; ``shape`` None takes a number or a list."""
        expected = "a number" if shape == () else f"{shape[0]} numbers" if shape else "a number or a list of them"
        unit = "" if dimension is None else ", or text with a unit"
        value = self.take(key, expected + unit)
        items = value if isinstance(value, list) else [value]
        if shape is not None and (isinstance(value, list) != bool(shape) or (shape and len(items) != shape[0])):
            raise self.fault(key, f"is {value!r}; expected {expected}{unit}")
        plain = [self._number(key, item, dimension, units, expected + unit) for item in items]
        return np.array(plain if isinstance(value, list) else plain[0])

    def _number(self, key: str, item: Any, dimension: str | None, units: Units, expected: str) -> float:
        if isinstance(item, int | float) and not isinstance(item, bool):
            if not np.isfinite(item):
                raise self.fault(key, f"is {item!r}; expected a finite number")
            return float(item)
        if not isinstance(item, str) or dimension is None:
            raise self.fault(key, f"is {item!r}; expected {expected}")
        try:
            quantity = from_text(item, "", dimension)
        except InvalidInput as error:
            raise self.fault(key, str(error).strip()) from error
        with self.naming(key):
            return float(units.strip(quantity, dimension, repr(item)))

    def only(self, *known: str) -> _Table:
        """Refuse keys other than these, before a misspelt one is reported as missing."""
        for key in self.content:
            if key not in known:
                raise self.fault(key, f"is no key of this table; {suggestion(key, known)}")
        return self


class _Naming:
    """Adds file and key to errors raised inside."""

    def __init__(self, table: _Table, key: str) -> None:
        self.table, self.key = table, key

    def __enter__(self) -> None: ...

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, FullbodyError) and not str(error).startswith(f"{self.table.path}: "):
            raise self.table.fault(self.key, str(error)) from error


def _units(table: _Table) -> tuple[object, object, object] | None:
    if "units" not in table:
        return None
    value = table.content["units"]
    if not isinstance(value, list) or len(value) != 3 or not all(isinstance(name, str) for name in value):
        raise table.fault("units", f"is {value!r}; expected three texts, such as ['km', 'hour', 'kg']")
    with table.naming("units"):
        Units((value[0], value[1], value[2]))
    return (value[0], value[1], value[2])


def _body(table: _Table, units: Units) -> tuple[Body, _Table]:
    """The body, and its table for the start to be read from."""
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
        return Body(shape, name=name, **values), table


def _integrator(table: _Table, units: Units) -> Any:
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


def _system(table: _Table, units: Units, bodies: list[Body]) -> System:
    table.only(*(name for name in inspect.signature(System).parameters if name != "bodies"))
    parameters = [name for name in inspect.signature(System).parameters if name not in ("bodies", "G", "units")]
    options = {name: table.content[name] for name in parameters if name in table}
    if isinstance(options.get("order"), list):
        options["order"] = tuple(options["order"])
    G = float(table.value("G", "G", units, ())) if "G" in table else None
    return System(bodies, G, units=units.names, **options)


def _state(run: _Table, system: System, units: Units, tables: list[_Table]) -> State:
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
        return State(attitude=attitude, **{name: units.attach(values[name], _DIMENSION[name]) for name in _STATE})


def _motion(
    table: _Table, k: int, system: System, units: Units, position: Any, velocity: Any
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


def _attitude(table: _Table, units: Units) -> npt.NDArray[np.float64]:
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


def _spin(table: _Table, units: Units) -> npt.NDArray[np.float64]:
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
