"""Reading of input files of GUBAS and GUBAS-RS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..base.atomic import as_path
from ..base.rotations import quaternion
from ..errors import InvalidInput, caution
from ..model.bodies import Body
from ..model.state import State
from ..motion.system import System
from ._meshes import along_body_axes
from ._text import naming

if TYPE_CHECKING:
    from ._gubas_files import Start

__all__ = ["read_gubas"]

_UNITS = ("km", "s", "kg")


def read_gubas(
    path: Any,
    *,
    euler: Literal["degree", "radian"] | None = None,
    units: bool = False,
    **options: Any,
) -> tuple[System, State]:
    """Read a system and its state from an input file of GUBAS: its ``.cfg``, or the numeric ``ic_input.txt``.

    In both, the relative position and velocity are components along the primary's axes, and "A into N" turns them into
    the inertial frame. The secondary's spin is along its own axes in the ``.cfg``, and along the primary's axes in
    ``ic_input.txt``. Densities are in g/cm^3 in the ``.cfg`` and in kg/km^3 in ``ic_input.txt``, whose semi-axes are in
    metres while its state is in kilometres. The barycentre is placed at rest at the origin. ``ic_input.txt`` is read in
    its three published layouts: without fly-by, with it, and with fly-by and heliocentric orbit.

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
        A file whose name ends in ``.cfg`` is read as such; other files are read as ``ic_input.txt``.
    euler : {"degree", "radian"}, optional
        The unit of the Euler angles in a ``.cfg``. Both programs take radians, but comments in the files that come with
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
    >>> numbers = [6.67e-20, 4, 4, 4, 400, 400, 300, 90, 80, 70, 1, 1, 2.1e12, 2.1e12, 0, 3600]
    >>> files = ["TDP_4.mat", "TDS_4.mat", "IDP.mat", "IDS.mat", "-", "-", "-", "-"]
    >>> identity = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    >>> start = [1.19, 0, 0, 0, 1.7e-4, 0, 0, 0, 7.7e-4, 0, 0, 1.5e-4, *identity, *identity]
    >>> rest = [1, 1, 30.0, 1e-15, 0, 0, 1.0, 149597870.7, 1e-5, 1e-5, 660, 225, 0.005, 0.005, 1.988e30]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "ic_input.txt")
    ...     with path.open("w") as file:
    ...         print(*numbers, *files, *start, *rest, sep=chr(10), file=file)
    ...     system, state = fullbody.read_gubas(path)
    >>> system.bodies[1].shape
    Ellipsoid(a=0.09, b=0.08, c=0.07)
    """
    from ._gubas_files import read_config, read_numbers

    if euler not in (None, "degree", "radian"):
        raise InvalidInput(f"euler is {euler!r}; expected 'degree' or 'radian'")
    if as_path(path).suffix.lower() == ".cfg":
        start, warning = read_config(path, euler)
        if warning is not None:
            caution(f"{path} gives Euler angles, {warning}", UserWarning)
    else:
        start = read_numbers(path)
    return _build(path, start, units, options)


def _build(path: Any, start: Start, units: bool, options: dict[str, Any]) -> tuple[System, State]:
    if not isinstance(units, bool):
        raise InvalidInput(f"units is {units!r}; expected True or False (GUBAS' files are in km, s and kg)")
    with naming(path):
        bodies = [
            Body(shape, density=density, name=name)
            for name, shape, density in zip(("primary", "secondary"), start.shapes, start.densities, strict=True)
        ]
        system = System(bodies, G=start.G, units=_UNITS if units else None, **options)
        q_a = quaternion(start.a_to_n)
        q_b = quaternion(start.a_to_n @ start.b_to_a)
        turns, spins = (start.a_to_n, start.a_to_n @ start.b_to_a), (start.spin_a, start.spin_b)
        relative = np.array([start.a_to_n @ start.position, start.a_to_n @ start.velocity])
        inertial = np.array([turn @ spin for turn, spin in zip(turns, spins, strict=True)])
        outside = start.outside.forces(start.time, relative, inertial)
        if outside:
            system = system.with_forces([*system.forces, *outside])
        total = sum(body.mass for body in bodies)
        share = np.array([-bodies[1].mass / total, bodies[0].mass / total])[:, None]
        own = np.array([q_a, q_b]), np.array([start.spin_a, start.spin_b])
        attitude, spin = along_body_axes(path, bodies, *own)
        attach = system._units.attach
        state = State(
            attach(share * (start.a_to_n @ start.position), "length"),
            attach(share * (start.a_to_n @ start.velocity), "velocity"),
            attitude,
            attach(spin, "spin"),
            attach(np.float64(start.time), "time"),
        )
    for warning in start.outside.input_warnings():
        caution(f"{path} asks for {warning}", UserWarning)
    return system, state._named(system.names)
