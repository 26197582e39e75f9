"""A flight of particles along a run: checks of its options, and the call of the core."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..base.arguments import integer, sequence
from ..base.progress import Report, over_time
from ..base.tables import number
from ..base.units import scalar
from ..errors import FullbodyError, Interrupted, InvalidInput, caution
from ..record.dense import Dense
from ..record.integrators import Integrator, Verner98
from .events import ParticleEvent, Shadow
from .flight import Flight
from .given import Particles
from .rules import Bounce, Escape, Radiation

if TYPE_CHECKING:
    from ..motion.system import System

__all__ = ["FlightTask"]


class FlightTask:
    """The options of a flight, checked before it starts."""

    def __init__(
        self,
        system: System,
        particles: Particles,
        *,
        integrator: Integrator | None,
        contact: str | Bounce,
        escape: Escape | None,
        radiation: Radiation | None,
        events: Iterable[ParticleEvent],
        threads: int | None,
    ) -> None:
        self._system = system
        if not isinstance(particles, Particles):
            raise InvalidInput(f"particles is {particles!r}; expected fullbody.Particles")
        self._numbers, self._time = particles._numbers(system._units), particles._time(system._units)
        integrator = Verner98(rtol=1e-12, atol=1e-12) if integrator is None else integrator
        if not isinstance(integrator, Integrator) or integrator._tolerance is None:
            raise InvalidInput(f"integrator is {integrator!r}; expected one with step control, such as Verner98(...)")
        self._integrator = integrator._describe(float)
        if not (isinstance(contact, Bounce) or contact in ("stop", "remove")):
            raise InvalidInput(f"contact is {contact!r}; expected 'stop', 'remove' or a fullbody.particles.Bounce")
        self._contact = contact._numbers(system.context) if isinstance(contact, Bounce) else contact
        for name, value, kind in (("escape", escape, Escape), ("radiation", radiation, Radiation)):
            if value is not None and not isinstance(value, kind):
                raise InvalidInput(f"{name} is {value!r}; expected a fullbody.particles.{kind.__name__}")
        self._escape = None if escape is None else escape._numbers(system.context)
        self._radiation = None if radiation is None else radiation._numbers(system.context)
        self.events = sequence(events, ParticleEvent, "events", "a list of them", "events of fullbody.particles")
        self._event_spec = [event._event_spec(system.context) for event in self.events]
        if threads is not None and ((count := integer(threads)) is None or count < 1):
            raise InvalidInput(f"threads is {threads!r}; expected a whole number above zero, or None")
        self._threads = threads
        lit = self._numbers[2].any()
        if self._radiation is None and lit:
            caution("the particles have an area_to_mass, and no light acts on them: radiation is not given")
        if self._radiation is not None and not lit and not any(isinstance(event, Shadow) for event in self.events):
            caution("radiation is given, and no particle has an area_to_mass: light does not act on them")
        for force in system.forces:
            if force._kind == "Function":
                caution(f"{force.name} is a function of the bodies' states, which particles do not feel")

    def fly(self, dense: Dense, start: Any, until: Any, output: Any, report: Report | None) -> Flight:
        """Integrate particles along a continuous solution, from the given start, the particles' time, or its first
        time.
        """
        units = self._system._units
        time = self._start(dense.range[0] if start is None and self._time is None else start)
        end = scalar(units.strip(until, "time", "until"), "until")
        if isinstance(output, float) and abs(end - time) / output * len(self._numbers[0]) * 48.0 > 2.0**34:
            raise InvalidInput(f"output is {output!r}, which asks for more than 17 GB; expected a longer spacing")
        record, error = _core.fly(
            self._system._core,
            dense._core,
            (time, *self._numbers),
            end,
            output,
            self._integrator,
            self._contact,
            self._escape,
            self._radiation,
            self._event_spec,
            self._threads,
            over_time(report),
        )
        for name, values in record.items():
            record[name] = values = np.asarray(values, dtype=np.int64) if isinstance(values, list) else values
            values.flags.writeable = False
        flight = Flight(self._system, record, self.events)
        if error is None:
            return flight
        if isinstance(error, KeyboardInterrupt):
            error = Interrupted("interrupted in a flight of particles; what there is of it is in .flight")
        if isinstance(error, FullbodyError):
            flight.error = type(error)(*error.args)
        with contextlib.suppress(AttributeError):
            error.flight = flight  # type: ignore[attr-defined]
        raise error

    def _start(self, start: Any) -> float:
        """Return the start of the flight, which has to agree with the particles' time if they have one."""
        units, own = self._system._units, self._time
        if start is None and own is not None:
            return own
        time = scalar(units.strip(start, "time", "start"), "start")
        if own is not None and abs(time - own) > 1e-12 * max(abs(time), abs(own)):
            there, here = (number(units.attach(np.float64(value), "time"), 12) for value in (own, time))
            raise InvalidInput(
                f"the particles are those of time {there}, but the flight starts at {here}; expected the state, run or "
                "start of that time, or Particles(particles.position, particles.velocity), which have no time"
            )
        return time
