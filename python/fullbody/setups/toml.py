"""``system.toml``: a text file that describes a system, its start and its run.

A number is in the system's own units, radians for angles; a text such as ``"2.5 km"`` or ``"3.2 deg"`` names its own.

.. code-block:: toml

    [system]                          # the arguments of fullbody.System
    units = ["km", "hour", "kg"]      # without units: G = 1.0 or another number
    gravity = "focal"

    [[body]]
    name = "Alpha"
    semi_axes = [0.766, 0.7475, 0.6735]   # or radius = 0.7, or point = true, or polyhedron = "alpha.obj"
                                          # or { vertices = [[1, 0, 0], ...], faces = [[0, 1, 2], ...] }, or
                                          # stokes = { file = "alpha.gfc", inertia = "0.2 km2", radius = "0.8 km" }
    mass = 2.353e12                       # or density = "2 g/cm3" or GM = "157 m3/s2"
    angles = ["3.2 deg", 0, 0]            # Tait-Bryan; or attitude = [w, x, y, z]
    spin = [0, 0, 2.2728]                 # body frame; or rotation_period = "2.7645 hour", about the body's z

    [[body]]
    name = "Beta"
    semi_axes = [0.285, 0.2315, 0.1745]
    mass = 0.135e12
    orbit = { about = "Alpha", a = 2.548, e = 0.0004, i = 0, Omega = 0, omega = 0, M = 0 }
    # with pomega for omega, and f, l or theta for M; or position = [2.5, 0, 0] and velocity = [0, 0.9, 0]
    spin = [0, 0, 0.3611]
    # a body of several parts has, in place of semi_axes and mass, for each of them, in a frame of their own:
    #   [[body.part]]
    #   radius = "110 m"              # as above; a mass or density below zero makes a void
    #   density = "2.4 g/cm3"
    #   position = ["-105 m", 0, 0]   # or none; angles or attitude rotate the part

    [[forces]]                        # the arguments of a class of fullbody.forces; may be left out
    kind = "ThirdBody"
    name = "Sun"
    mass = "1 M_sun"                  # or mu = ...
    of = "system"                     # whose orbit it is: the system's about the Sun; "body": the third body's
    orbit = { a = "0.64 au", e = 0.69, i = "38.9 deg", Omega = "245 deg", omega = "193 deg", M = 0 }
    # or times = [0, 10, 20, 30] and positions = [[1e6, 0, 0], ...]

    [[forces]]
    kind = "Tide"                     # or "Yorp", "Byorp", "BinaryYarkovsky"
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

Two bodies may be described as they are published, by the arguments of :func:`fullbody.binary` and of
:class:`fullbody.Component`. The files of :mod:`fullbody.systems` are of this kind: each can be copied and changed.

.. code-block:: toml

    [system]
    units = ["km", "hour", "kg"]
    frame = "ecliptic"                # of the poles and the elements

    [[body]]
    name = "Didymos"                  # a published number may be a table, of which value and unit count here:
    diameters = { value = [851, 849, 620], unit = "m", error = "15", source = "Daly et al. (2023)" }
    rotation_period = 2.26            # pole = [longitude, latitude], tilt and rotation_angle as in Component

    [[body]]
    name = "Dimorphos"
    diameter = "151 m"                # with "a/b" and "a/c", or axis_ratios = [a/b, b/c], or the J2 of a spheroid
    "a/b" = 1.02
    "a/c" = 1.53

    [binary]                          # in place of position, velocity and orbit of the bodies
    equal_density = true              # or mass, density or GM of a body; mass_ratio; total_mass or GM of both
    period = "11.921 h"               # mean, in which a start is searched unless start_period says what was found
    semi_major_axis = 1.206
    pole = ["310 deg", "-84 deg"]     # or inclination and ascending_node; mean_longitude or mean_anomaly

    [run]
    until = "10 day"

A body with an orbit of its own may have ``pole = "orbit"``, or ``synchronous = true`` to point its x-axis at what it
orbits about; ``about`` may be a list of bodies. ``pole_frame`` names another frame of a body's ``pole``. Tables that
describe a ready-made system (``title``, ``text``, ``example``, ``assumed``, ``sources``, ``not_used``, ``sun``,
``variants``, ``parameters``, ``default_frame``, ``no_frame``) are no part of the setup that is read.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base.arguments import normal_form, options_of
from ..base.atomic import as_path, check_suffix, content, other_reader
from ..base.units import Units
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..files.netcdf import RUN_SUFFIXES
from ..model.state import State
from ..motion.run import Run
from ..motion.system import System
from ..record import integrators
from .binary import binary
from .toml_bodies import body, pair
from .toml_state import force, state_of
from .toml_table import METADATA, TomlTable, replaced, text_with_unit

_RUN = ("until", "output", "start", "origin", "file")
_TOP = ("system", "body", "binary", "forces", "integrator", "run")
#: The default is the first one.
_INTEGRATORS = tuple(sorted(integrators.__all__, key=lambda name: name != "Verner98"))


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
        """Integrate the system, to the time of the file unless another one is given, without writing a file.

        Parameters
        ----------
        until : float or Quantity, optional
        progress : bool or callable
        """
        end = self.until if until is None else until
        try:
            options = {"output": self.output, "integrator": self.integrator, "progress": progress}
            return self.system.integrate(self.state, end, **options)
        except InvalidInput as error:
            # Whether the times fit is known only when the end is.
            if "output" not in str(error):
                raise
            raise InvalidInput(f"{self.path}: run: {error}") from error


def read_toml(path: Any) -> Configuration:
    """Read a ``system.toml``.

    Parameters
    ----------
    path : str, Path or binary file
        The name of a file, or a file that is open, such as ``sys.stdin.buffer``; names of other files in it then refer
        to the working directory.

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
    stream = path if hasattr(path, "read") else None
    path = as_path(path if stream is None else "standard input")
    top = TomlTable(path, "", {}, Units())
    with top.naming(""):
        content = (toml_content(path) if stream is None else parsed(stream.read(), path)).items()
        top.content = {key: replaced(item, text_with_unit) for key, item in content if key not in METADATA}
    top.only(*_TOP)
    top.units = _units(top.table("system"))
    run, integrator = top.table("run").only(*_RUN), _integrator(top.table("integrator", required=False))
    with top.naming("binary" if "binary" in top else "system"):
        system, state = build(top, {"units": top.units.names})
    until = top.units.attach(run.number("until", "time"), "time")
    output = top.units.attach(_output(run), "time") if "output" in run else None
    return Configuration(path, system, state, integrator, until, output, path.parent / _file(run))


def build(top: TomlTable, options: dict[str, Any], planar: bool = False) -> tuple[System, State]:
    """Make the system and the state of a file, with the units of its plain numbers.

    The options are those of :class:`fullbody.System`, which have priority over those of the file; ``G`` or ``units`` is
    one. With ``planar`` the orbit of a binary is in the xy-plane with its node on the x-axis, whatever its pole is.
    """
    table, rows = top.table("system"), top.tables("body")
    names = [name for name in options_of(System) if name not in ("bodies", "forces")]
    options = {**table.only(*names).content, **options}
    if isinstance(options.get("order"), list):
        options["order"] = tuple(options["order"])
    if "G" in table:
        options["G"] = table.number("G", "G")
    if "forces" in top:
        options["forces"] = [*(force(row) for row in top.tables("forces")), *options.get("forces", ())]
    G = options.get("G")
    gravity = top.units.gravitational_constant if G is None and top.units.defined else (G or 0.0)
    if "binary" in top:
        arguments = pair(top.table("binary"), rows, gravity)
        if planar:
            arguments["pole"] = None
        return binary(**arguments, **{**options, "G": gravity})
    system = System([body(row, gravity) for row in rows], **options)
    return system, state_of(top.table("run", required=False), system, rows)


def toml_content(path: Path) -> dict[str, Any]:
    """Return the contents of a file of TOML."""
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.is_dir():
        raise InvalidInput(f"{path}: is a folder; expected a file of TOML")
    return parsed(content(path), path)


def parsed(written: bytes, path: Path) -> dict[str, Any]:
    """Return the contents of bytes of TOML; errors name the file."""
    import tomllib

    try:
        # The byte order mark that some editors write is accepted.
        return tomllib.loads(normal_form(written.decode("utf-8-sig")))
    # Python's limits on the digits of a number and on nested brackets raise these errors too.
    except (ValueError, RecursionError) as error:
        no_text = isinstance(error, UnicodeDecodeError)
        problem = "is not text; expected a file of TOML" if no_text else f"not valid TOML: {error}"
        raise InvalidInput(f"{path}: {problem}{other_reader(path, 'fullbody.read_toml')}") from error


def _units(system: TomlTable) -> Units:
    value = system.content.get("units")
    with system.naming("units"):
        return Units(tuple(value) if isinstance(value, list) else value)


def _output(run: TomlTable) -> Any:
    """Return the output: a positive spacing, or times."""
    value = run.content["output"]
    if isinstance(value, list):
        return run.vector("output", "time")
    spacing = run.number("output", "time")
    if spacing <= 0.0:
        raise run.fault("output", f"is {value!r}; expected a spacing above zero, or a list of times")
    return spacing


def _file(run: TomlTable) -> str:
    name = run.text("file") if "file" in run else f"{run.path.stem}.nc"
    with run.naming("file"):
        check_suffix(name, RUN_SUFFIXES)
    return name


def _integrator(table: TomlTable) -> Any:
    kind = getattr(integrators, table.choice("name", _INTEGRATORS))
    settings = {key: table.content[key] for key in table.fields_of(kind, "name")}
    if "step" in settings:
        settings["step"] = table.units.attach(table.number("step", "time"), "time")
    with table.naming(""):
        return kind(**settings)
