"""Construction of a ready-made system from its file, in a given frame and given units."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import rotations
from ..base.arguments import options_of, refuse_unknown
from ..base.kinds import choice, flag
from ..base.units import DEFAULT_UNITS, Units
from ..errors import InvalidInput
from ..forces import ThirdBody
from ..forces.ephemeris import GM
from ..frames import rotate_state, rotated, rotation
from ..model.description import functions
from ..model.force import rebuilt
from ..model.state import State, strip, wrap
from ..motion.system import System, system_of
from ..orbit.elements import KeplerElements
from ..setups.toml import build
from ..setups.toml_table import METADATA, TomlTable, in_usual_units, replaced
from ..typing import Floats
from . import _files

#: Methods of gravity for which the files have the starts of mean elements.
_EXACT = ("focal", "harmonic", "surface")
FRAMES = ("ecliptic", "equatorial", "orbit")
#: CODATA 2018, 6.67430e-11 m^3 kg^-1 s^-2, in km^3 kg^-1 hour^-2, to the last bit as astropy has it.
_G = 6.67430e-11 * 0.01296
#: G times the Sun's mass in km^3/hour^2.
_MU = GM["sun"] * 3600.0**2


def ready(
    name: str,
    variant: Any,
    changes: dict[str, dict[str, Any]],
    *,
    frame: Any = None,
    sun: Any = False,
    units: Any = False,
    **options: Any,
) -> tuple[System, State]:
    """Make a ready-made system from its file, a variant of it, and other values by names of bodies and keys."""
    content = _files.changed(_files.contents(name), variant, changes)
    table = content["system"]
    frame, published = _frame(content, frame), table.get("frame")
    options = _with_epoch(options, table.get("epoch"))
    # Numbers of a file without units are dimensionless, and have the units that the caller names.
    base, units = (DEFAULT_UNITS if Units(units).defined else None, units) if "units" in table else (units, False)
    if base is None and "G" not in table:
        options["G"] = _G
    described = {key: replaced(item, in_usual_units) for key, item in content.items() if key not in METADATA}
    if "binary" in described and (options.get("gravity", "focal") not in _EXACT or "forces" in options):
        # The period of the start holds for the exact attraction alone.
        described["binary"].pop("start_period", None)
    planar = frame == "orbit" and "binary" in described
    top = TomlTable(_files.path(name), "", described, Units(base))
    system, state = build(top, {**options, "units": base}, planar)
    system = system.with_options(frame=frame)
    # The quaternion rotates vectors into the axes of the orbit's plane.
    into = rotations.inverse(rotations.of_plane(*_plane(described))) if frame == "orbit" else None
    if into is not None and not planar:
        state = rotated(state, rotations.matrices(into), into)
    elif frame not in (None, "orbit", published):
        state = rotate_state(state, published, frame)
    system, state = _in_units(system, state, units)
    axes = (frame if into is None else published, into)
    return with_sun(system, content.get("sun"), sun, axes), state


def _frame(content: dict[str, Any], frame: Any) -> str | None:
    """Return the frame of the state: the given one, or the default of the system."""
    if "no_frame" in content:
        if frame is not None:
            raise InvalidInput(f"frame is {frame!r}; expected none: {content['no_frame']}")
        return None
    if frame is None:
        return str(content.get("default_frame", content["system"]["frame"]))
    return str(choice(frame, "frame", FRAMES))


def _with_epoch(options: dict[str, Any], epoch: str | None) -> dict[str, Any]:
    """Return the options of the system with its epoch: the published one, or the caller's if none is published."""
    fixed = ("bodies", "G", "frame")
    refuse_unknown(options, (name for name in options_of(System) if name not in fixed), "this system")
    date = options.get("epoch")
    if epoch is not None and date is not None:
        expected = f"expected none: the numbers of this system hold at its own, {epoch}"
        raise InvalidInput(f"epoch is {date!r}; {expected}")
    return {**options, "epoch": epoch if date is None else date}


def _plane(described: dict[str, Any]) -> tuple[float, float]:
    """Return node and inclination of the orbit of a binary, or of the orbit about a single body, in radians."""
    orbits = [body["orbit"] for body in described["body"] if isinstance(body.get("orbit", {}).get("about"), str)]
    binary = described.get("binary", {})
    if "pole" in binary:
        longitude, latitude = binary["pole"]
        return longitude + np.pi / 2, np.pi / 2 - latitude
    if binary:
        return binary["ascending_node"], binary["inclination"]
    return orbits[0]["Omega"], orbits[0]["i"]


def _in_units(system: System, state: State, units: Any) -> tuple[System, State]:
    """Convert a system in km, hour, kg and its state to the given units."""
    target = Units(units)
    if not target.defined or target == Units(DEFAULT_UNITS):
        return system, wrap(strip(state, system.context), system.context)
    # The forces take Quantities here, since plain numbers are in km, hour, kg.
    forces = [
        force if force.name in system.context.calls else rebuilt(described | force._notes(), system.context.units)
        for force, described in zip(system.forces, system.context.core.forces, strict=True)
    ]
    converted = System(system.bodies, G=system.G, units=target.names, forces=forces, **system.options)
    # The system is rebuilt from its description, so that the bodies are in these units too.
    final = system_of(converted.context.describe(), functions(system))
    return final, wrap(state.in_units(target), final.context)


def with_sun(system: System, table: dict[str, Any] | None, sun: Any, axes: tuple[str | None, Floats | None]) -> System:
    """Add the Sun's gravity to a system if it is requested.

    The table has the heliocentric orbit in the ecliptic of J2000 (au, degrees), and the Julian date of its mean
    anomaly; the axes of the state are a frame and a quaternion that rotates vectors from there, or ``None``.
    """
    flag(sun, "sun")
    if not sun:
        return system
    if table is None:
        raise InvalidInput("sun is True; expected False: the heliocentric orbit of this system is not tabulated")
    a, e, *degrees = table["orbit"]["value"]
    a = in_usual_units(a, "au")
    i, node, argument, mean = np.radians(degrees)
    if system.epoch is not None:
        mean += np.sqrt(_MU / a**3) * 24.0 * (system.epoch.tdb.jd - table["epoch"]["value"])
    r, v = KeplerElements(a, e, i, node, argument, np.remainder(mean, 2 * np.pi)).to_cartesian(_MU)
    frame, quaternion = axes
    matrix = rotation("ecliptic", frame)
    if quaternion is not None:
        matrix = rotations.matrices(quaternion) @ matrix
    orbit = KeplerElements.from_cartesian(matrix @ r, matrix @ v, _MU)
    attach = Units(None if system.units is None else DEFAULT_UNITS).attach
    angles = (orbit.i, orbit.Omega, orbit.omega, orbit.M)
    orbit = KeplerElements(attach(orbit.a, "length"), orbit.e, *angles)
    return system.with_force(ThirdBody(mu=attach(_MU, "mu"), orbit=orbit, of="system", name="Sun"))
