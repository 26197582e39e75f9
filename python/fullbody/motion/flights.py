"""Flights of particles from a state of the bodies."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..base.progress import Progress
from ..model.context import S
from ..model.state import State
from ..particles.events import ParticleEvent
from ..particles.flight import Flight
from ..particles.initial import Particles
from ..particles.rules import Bounce, Escape, Radiation
from ..particles.task import FlightTask
from ..record.integrators import Integrator
from ..record.times import sampling
from .integration import integrate


def fly(
    system: S,
    state: State,
    particles: Particles,
    until: Any = None,
    *,
    duration: Any = None,
    output: Any = None,
    integrator: Integrator | None = None,
    contact: str | Bounce = "stop",
    escape: Escape | None = None,
    radiation: Radiation | None = None,
    events: Iterable[ParticleEvent] = (),
    bodies_integrator: Integrator | None = None,
    threads: int | None = None,
    progress: Any = False,
) -> Flight[S]:
    """Fly massless particles among the bodies, from a state to a time.

    The bodies are integrated first, as by :meth:`integrate`, and the particles are integrated along their continuous
    solution, which takes 2.3 kB per step for two bodies. For several flights along the same motion, keep a run with
    ``dense=True`` and use :meth:`fullbody.Run.fly`, where the other parameters are described.

    Parameters
    ----------
    state : State
        State of the bodies at the particles' time.
    particles : Particles
    until, duration : float, Quantity or text with a unit
        End of the flight, before ``state.time`` for a flight backwards, or its length.
    bodies_integrator : Integrator, optional
        Integrator of the bodies, as in :meth:`integrate`.

    Raises
    ------
    InvalidInput, Interrupted
        For the same reasons as :meth:`fullbody.Run.fly` and :meth:`integrate`.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> up = fullbody.Particles.from_surface(system, state, "Beta", longitude=0.0, latitude=0.5, speed=0.1)
    >>> system.fly(state, up, 24.0).fate.tolist()
    ['impact']
    """
    options: dict[str, Any] = {"integrator": integrator, "contact": contact, "escape": escape}
    options |= {"radiation": radiation, "events": events, "threads": threads}
    # Options that are refused are refused before the bodies move.
    task = FlightTask(system.context, particles, **options)
    sampling(output, system.context.units)
    options = {"output": [], "integrator": bodies_integrator, "dense": True, "progress": progress and "bodies"}
    dense = integrate(system, state, until, duration=duration, **options).continuous()
    start, end = dense.range
    with Progress(progress if callable(progress) else progress and "particles") as report:
        return task.fly(system, dense, start, end, None, output, report)
