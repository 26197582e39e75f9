"""Reading of configuration files of GUBAS and GUBAS-RS."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..base.kinds import choice, instance
from ..base.rotations import quaternion
from ..errors import caution
from ..model.bodies import Body
from ..model.state import State, from_numbers
from ..motion.system import System
from ._meshes import along_body_axes
from ._text import NOT_NEGATIVE, POSITIVE, naming

_UNITS = ("km", "s", "kg")
_BODIES, _TIME = ("Primary", "Secondary"), ("Integration Settings", "Start Time")


def read_gubas(
    path: Any,
    *,
    euler: Literal["degree", "radian"] | None = None,
    units: bool = False,
    **options: Any,
) -> tuple[System, State]:
    """Read a system and its state from an input file of GUBAS, its ``.cfg``.

    The relative position and velocity are components along the primary's axes, and "A into N" turns them into the
    inertial frame; spins are along each body's own axes, densities in g/cm^3. The barycentre is placed at rest at the
    origin.

    A polyhedron's tables of vertices and faces are searched for beside the file. Its state is that of its centre of
    mass and its principal axes. GUBAS takes the tables as given in these axes; a warning says if they are not.

    Effects that are switched on besides mutual gravity become forces of the system, which are computed correctly where
    GUBAS errs (see the warnings). "Flyby" and "Heliocentric Orbit" are a :class:`fullbody.forces.ThirdBody` each, named
    flyby and Sun. As in GUBAS, they move about the binary on the given elements. If the elements are those of the
    binary about the Sun, this places the Sun on the opposite side, where its tide is the same except for the odd
    orders. The Sun's mass is the option "Solar Mass". "Solar Gravity" is a Sun on a circular orbit in the plane z = 0,
    which is on the -x axis at the start. "Tidal Torque" is a :class:`fullbody.forces.Tide` on each body. The lag angle
    eps is converted to a time lag by sin(2 eps) = f lag, where f is the larger of 2 abs(omega - n) and n at the start,
    omega is the body's spin and n the orbit's rate.

    Parameters
    ----------
    path : str or Path
        The configuration file. The numeric ``ic_input.txt``, which GUBAS writes from it for its own use, is not read.
    euler : {"degree", "radian"}, optional
        The unit of Euler angles. Both programs take radians, but comments in the files that come with
        them say degrees or radians. Without this argument, angles other than zero are taken in the unit that the
        comments state, with a warning if it is degrees; if the comments state none, they are taken as radians with a
        warning.
    units : bool
        Whether the system returns Quantities. Numbers are in km, s, kg in either case.
    **options
        Options that are passed to :class:`fullbody.System`. The default is the exact gravity; ``gravity="multipole:4"``
        and others truncate the expansion as those programs do.

    Returns
    -------
    system : System
    state : State

    Raises
    ------
    InvalidInput
        For missing input; for values that are not numbers, not above zero or not a rotation, where the message names
        the line; for angles with comments of both units; for two Suns; for a polyhedron with an invalid face; and for
        Fahnestock's separate file of initial conditions, which is not supported.

    Warns
    -----
    UserWarning
        For Euler angles whose unit is in doubt, and for forces for which GUBAS's own result differs: GUBAS omits the
        torques of third bodies and displaces the secondary in their pull, its tides add energy, and its "Solar Gravity"
        has a fixed direction.

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
    from ._gubas_config import BODIES, START, Config, outside_of, rotations_of, shape_of

    choice(euler, "euler", (None, "degree", "radian"))
    instance(units, "units", bool, "True or False (GUBAS' files are in km, s and kg)")
    cfg = Config(path)
    if cfg.on(START, "Fahnestock Input File Flag"):
        cfg.fail(
            cfg.line(START, "Fahnestock Input File Flag"),
            "the file asks for initial conditions of separate files (Fahnestock's), which fullbody does not read",
        )
    relative = np.array([cfg.vector(START, f"Relative {what}") / 1000.0 for what in ("Position", "Velocity")])
    spin = np.array([cfg.vector(START, f"{body} Angular Velocity") for body in _BODIES])
    (a_to_n, b_to_a), warning = rotations_of(cfg, euler)
    if warning is not None:
        caution(f"{path} gives Euler angles, {warning}", UserWarning)
    rotation_matrices = np.array([a_to_n, a_to_n @ b_to_a])
    relative = relative @ a_to_n.T
    densities = [cfg.value(BODIES, f"{body} Density", POSITIVE) * 1e12 for body in _BODIES]
    shapes = [shape_of(cfg, body) for body in _BODIES]
    time = cfg.value(*_TIME) if cfg.has(*_TIME) else 0.0
    outside = outside_of(cfg)
    G = cfg.value("Gravity Parameter", "G", NOT_NEGATIVE) / 1e9
    with naming(path):
        bodies = [
            Body(shape, density=density, name=name.lower())
            for name, shape, density in zip(_BODIES, shapes, densities, strict=True)
        ]
        system = System(bodies, G=G, units=_UNITS if units else None, **options)
        forces = outside.forces(time, relative, np.einsum("nij,nj->ni", rotation_matrices, spin))
        if forces:
            system = system.with_forces([*system.forces, *forces])
        total = sum(body.mass for body in bodies)
        share = np.array([-bodies[1].mass / total, bodies[0].mass / total])[:, None]
        attitude, spin = along_body_axes(
            path, bodies, np.array([quaternion(matrix) for matrix in rotation_matrices]), spin
        )
        state = from_numbers(system.context, share * relative[0], share * relative[1], attitude, spin, time)
    for text in outside.input_warnings():
        caution(f"{path} asks for {text}", UserWarning)
    return system, state
