"""REBOUND's simulations, imported only when asked for: that package is optional and under the GPL."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bodies import Body, PointMass, Sphere
from ..errors import InvalidInput

if TYPE_CHECKING:
    from ..state import State
    from ..system import System

__all__ = ["from_rebound", "to_rebound"]


def from_rebound(sim: Any, **options: Any) -> tuple[System, State]:
    """A system and its state from a ``rebound.Simulation``.

    Particles with a radius become spheres, others points; all in the simulation's own units, with its G. Attitudes are
    the identity and spins zero: particles have none.

    Parameters
    ----------
    sim : rebound.Simulation
    **options
        Passed to :class:`fullbody.System`.

    Returns
    -------
    system : System
    state : State

    Raises
    ------
    InvalidInput
        For massless particles, which this package does not have, and for a simulation without particles.

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
    from ..state import State
    from ..system import System

    particles = list(sim.particles)
    if not particles:
        raise InvalidInput("the simulation has no particles; expected one or more")
    bodies = []
    for index, particle in enumerate(particles):
        if not particle.m > 0.0:
            raise InvalidInput(f"particle {index} has the mass {particle.m}; expected a mass above zero")
        shape = Sphere(float(particle.r)) if particle.r > 0.0 else PointMass()
        name = getattr(particle, "name", None)
        bodies.append(Body(shape, mass=float(particle.m), name=name if isinstance(name, str) and name else None))
    state = State(
        position=np.array([particle.xyz for particle in particles]),
        velocity=np.array([particle.vxyz for particle in particles]),
        time=float(sim.t),
    )
    return System(bodies, G=float(sim.G), **options), state


def to_rebound(system: System, state: State) -> Any:
    """A ``rebound.Simulation`` of the bodies as point masses.

    Radii are those of the spheres of equal volume. The numbers are in the system's own units, with its G; attitudes
    and spins are left out.

    Parameters
    ----------
    system : System
    state : State

    Returns
    -------
    rebound.Simulation

    Raises
    ------
    ImportError
        Without the package ``rebound``.

    Examples
    --------
    >>> import fullbody
    >>> sim = fullbody.to_rebound(*fullbody.systems.kw4())
    >>> round(sim.particles[1].a, 6)
    2.548
    """
    try:
        import rebound
    except ImportError as error:
        raise ImportError("to_rebound needs the package rebound: pip install rebound") from error

    core = system._strip(state)
    sim = rebound.Simulation()
    sim.G = system._G
    sim.t = core.time
    for index, body in enumerate(system.bodies):
        part = body._core(system._units, index)
        radius = float(np.cbrt(3.0 / (4.0 * np.pi) * part.volume))
        x, y, z = core.position[index]
        vx, vy, vz = core.velocity[index]
        sim.add(m=part.mass, r=radius, x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
    return sim
