"""Conversion from and to simulations of REBOUND, an optional package under the GPL, which is imported when needed."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from ..base.kinds import instance
from ..base.units import Units, need
from ..errors import InvalidInput, caution
from ..model.bodies import Body
from ..model.shapes import PointMass, Sphere
from ..model.state import State, from_numbers, strip
from ..motion.system import System

#: The units of rebound that have a name in astropy too.
_NAMED = (
    ("m", "cm", "km", "au", "pc"),
    ("s", "hour", "day", "yr", "kyr", "Myr", "Gyr"),
    ("kg", "g", "solMass", "earthMass", "jupiterMass"),
)
#: The relative difference that a unit may have between the two packages. Masses of celestial bodies differ more, since
#: they follow from GM with each package's own G.
_ALIKE = (1e-9, 1e-9, 1e-4)
_KINDS = ("length", "time", "mass")


def from_rebound(sim: Any, *, units: Any = None, **options: Any) -> tuple[System, State]:
    """Convert a ``rebound.Simulation`` to a system and its state.

    Particles with a radius become spheres, others become points. Numbers are in the simulation's own units, with its G.
    Attitudes are the identity and spins are zero, since particles have none.

    Parameters
    ----------
    sim : rebound.Simulation
    units : (length, time, mass) or bool, optional
        The units of the simulation's numbers, which are not converted; ``True`` for ``sim.units``, or for km, hour, kg
        if it has none. Results are then Quantities, by default plain numbers.
    **options
        Options that are passed to :class:`fullbody.System`.

    Raises
    ------
    InvalidInput
        For massless particles and test particles with a mass (from ``N_active`` on), which this package does not have,
        and for units other than the simulation's own.

    Warns
    -----
    UserWarning
        If the simulation has additional forces or operators, such as those of REBOUNDx, which are left out.

    Examples
    --------
    >>> import fullbody, rebound
    >>> sim = rebound.Simulation()
    >>> sim.add(m=1.0)
    >>> sim.add(m=1e-3, a=1.0)
    >>> system, state = fullbody.from_rebound(sim)
    >>> fullbody.to_rebound(system, state).particles[1].a
    1.0
    """
    # A caller who has a simulation has imported the package.
    rebound = sys.modules.get("rebound")
    if rebound is None or not isinstance(sim, rebound.Simulation):
        raise InvalidInput(f"sim is {sim!r}; expected a rebound.Simulation")
    names = _units(sim, units)
    particles = list(sim.particles)
    if not particles:
        raise InvalidInput("the simulation has no particles; expected one or more")
    bodies = []
    for index, particle in enumerate(particles):
        if not particle.m > 0.0:
            raise InvalidInput(f"particle {index} has the mass {particle.m}; expected a mass above zero")
        # If all particles are active, N_active is negative or larger than the number of particles.
        if 0 <= sim.N_active <= index:
            raise InvalidInput(
                f"particle {index} has the mass {particle.m} and is a test particle, for N_active is {sim.N_active}; "
                f"expected all {len(particles)} particles active, for here all bodies attract each other"
            )
        shape = Sphere(float(particle.r)) if particle.r > 0.0 else PointMass()
        name = getattr(particle, "name", None)
        bodies.append(Body(shape, mass=float(particle.m), name=name if isinstance(name, str) and name else None))
    hooks = ("_additional_forces", "_pre_timestep_modifications", "_post_timestep_modifications")
    if any(bool(getattr(sim, hook, None)) for hook in hooks):
        text = "the simulation has additional forces or operators, which are left out: functions cannot be read"
        caution(f"{text}; expected fullbody.forces in their place", UserWarning)
    system = System(bodies, G=float(sim.G), units=names, **options)
    position, velocity = ([getattr(particle, name) for particle in particles] for name in ("xyz", "vxyz"))
    return system, from_numbers(system.context, position, velocity, time=sim.t)


def _units(sim: Any, units: Any) -> Any:
    """Return the units for the system, or raise an error if they are not the simulation's own."""
    if units is None or units is False:
        return None
    units_of_simulation = tuple(sim.units[kind] for kind in _KINDS)
    if None in units_of_simulation:
        return units
    from rebound import units as known

    tables = (known.lengths_SI, known.times_SI, known.masses_SI)
    sizes = [table[name] for table, name in zip(tables, units_of_simulation, strict=True)]
    if units is True:
        return tuple(map(_named, units_of_simulation, sizes, _NAMED, _ALIKE))
    requested = Units(units)
    for kind, size, within, si in zip(_KINDS, sizes, _ALIKE, ("m", "s", "kg"), strict=True):
        if not np.isclose(requested.unit(kind).to(si), size, rtol=within, atol=0.0):
            raise InvalidInput(
                f"units is {requested.names}, but the simulation carries its own, {units_of_simulation}; expected the "
                "same ones, units=True for Quantities in its own, or none for plain numbers"
            )
    return units


def _named(unit_name: str, size: float, names: tuple[str, ...], within: float) -> str:
    """Return astropy's name of a unit of rebound, which is found by its size in SI."""
    from astropy import units as u

    for name in names:
        if np.isclose(u.Unit(name).si.scale, size, rtol=within, atol=0.0):
            return name
    raise InvalidInput(
        f"the simulation carries the unit {unit_name!r}, which astropy has no name for; expected one of "
        f"{', '.join(names)}, or units left out for plain numbers"
    )


def to_rebound(system: System, state: State) -> Any:
    """Convert a system and its state to a ``rebound.Simulation`` of point masses.

    Radii are those of the spheres of equal volume. The numbers are in the system's own units, with its G; attitudes,
    spins and external forces are left out. Particles have the bodies' names if rebound supports names, from its version
    5 on.

    Parameters
    ----------
    system : System
    state : State

    Returns
    -------
    rebound.Simulation

    Raises
    ------
    InvalidInput
        If the state has another number of bodies.
    ModuleNotFoundError
        If the package ``rebound`` is missing.

    Warns
    -----
    UserWarning
        If the system has external forces.

    Examples
    --------
    >>> import fullbody
    >>> sim = fullbody.to_rebound(*fullbody.systems.kw4_ho2021())
    >>> round(sim.particles[1].a, 6)
    2.548
    """
    with need(None, "a simulation of rebound"):
        import rebound

    instance(system, "system", System)
    core = strip(state, system.context)
    if len(state) != len(system):
        raise InvalidInput(f"number of bodies in the state is {len(state)}; expected {len(system)}")
    if system.forces:
        names = ", ".join(force.name for force in system.forces)
        caution(f"the simulation of rebound has its own gravity alone, no external forces ({names})", UserWarning)
    sim = rebound.Simulation()
    sim.G = system.context.G
    sim.t = core.time
    for index, (body, part) in enumerate(zip(system.bodies, system.context.bodies, strict=True)):
        radius = float(np.cbrt(3.0 / (4.0 * np.pi) * part.volume))
        motion = zip(("x", "y", "z", "vx", "vy", "vz"), (*core.position[index], *core.velocity[index]), strict=True)
        named = {"name": body.name} if body.name is not None and hasattr(rebound.Particle, "name") else {}
        sim.add(m=part.mass, r=radius, **dict(motion), **named)
    return sim
