"""A flight of particles along a run: checks of its options, and the call of the core."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.arguments import sequence
from ..base.kinds import instance, whole_number
from ..base.progress import Progress, Report, over_time
from ..errors import Interrupted, InvalidInput, caution, keep_result
from ..model.context import Context, S
from ..record.dense import Dense
from ..record.integrators import Integrator, Verner98
from ..record.times import end_of_run, refuse_flood, sampling, spacing_warning
from .events import ParticleEvent, Shadow
from .flight import Flight
from .initial import Particles
from .rules import Bounce, EscapeDistance, Radiation

#: The area to mass, in m2/kg, above which there is a warning.
_LIGHTEST = 1e3


class FlightTask:
    """The options of a flight, checked before it starts."""

    def __init__(
        self,
        context: Context,
        particles: Particles,
        *,
        integrator: Integrator | None,
        contact: str | Bounce,
        escape: EscapeDistance | None,
        radiation: Radiation | None,
        events: Iterable[ParticleEvent],
        threads: int | None,
    ) -> None:
        self._context = context
        instance(particles, "particles", Particles, "fullbody.Particles")
        self._numbers, self._time = particles._numbers(context.units), particles._time(context.units)
        integrator = Verner98(rtol=1e-12, atol=1e-12) if integrator is None else integrator
        if not isinstance(integrator, Integrator) or integrator._tolerance is None:
            raise InvalidInput(f"integrator is {integrator!r}; expected one with step control, such as Verner98(...)")
        self._integrator = integrator._describe(context.units)
        if not (isinstance(contact, Bounce) or contact in ("stop", "remove")):
            raise InvalidInput(f"contact is {contact!r}; expected 'stop', 'remove' or a fullbody.particles.Bounce")
        self._contact = contact._describe(context) if isinstance(contact, Bounce) else contact
        for name, value, kind in (("escape", escape, EscapeDistance), ("radiation", radiation, Radiation)):
            if value is not None:
                instance(value, name, kind, f"a fullbody.particles.{kind.__name__}")
        self._escape = None if escape is None else escape._describe(context)
        self._radiation = None if radiation is None else radiation._describe(context)
        self.events = sequence(events, ParticleEvent, "events", "a list of them", "events of fullbody.particles")
        self._event_spec = [event._event_spec(context) for event in self.events]
        self._threads = None if threads is None else whole_number(threads, "threads")
        has_area = self._numbers[2].any()
        if context.units.defined and has_area:
            largest = context.units.attach(self._numbers[2].max(), "area to mass").to("m2 / kg")
            if largest.value > _LIGHTEST:
                caution(
                    f"area_to_mass of particles has values up to {largest:.3g}, as of grains below half a micrometre; "
                    "expected Quantities, if it is in another unit than the system's"
                )
        if radiation is None and has_area:
            caution("the particles have an area_to_mass, and no light acts on them: radiation is not given")
        if radiation is not None and not has_area and not any(isinstance(event, Shadow) for event in self.events):
            caution("radiation is given, and no particle has an area_to_mass: light does not act on them")
        for force, of_kind in context.forces.items():
            if of_kind == "Function":
                caution(f"{force} is a function of the bodies' states, which particles do not feel")

    def fly(
        self, system: S, dense: Dense, start: Any, until: Any, duration: Any, output: Any, report: Report | None
    ) -> Flight[S]:
        """Integrate particles along a continuous solution, from the given start, their own time, or its first time."""
        units = self._context.units
        output = sampling(output, units)
        time = self._start(dense.range[0] if start is None and self._time is None else start)
        last = dense.core.range[1]
        end = last if until is None and duration is None else end_of_run(until, duration, time, units)
        if (warning := spacing_warning(output, end - time, units)) is not None:
            caution(warning)
        refuse_flood(output, time, end, 6 * len(self._numbers[0]), units)
        record, error = _core.fly(
            self._context.core,
            dense.core,
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
        samples, last_state = record.pop("samples").transpose(1, 0, 2), record.pop("last")
        arrays = {"position": samples[..., :3], "velocity": samples[..., 3:]}
        arrays |= {"last_position": last_state[:, :3], "last_velocity": last_state[:, 3:]}
        for name, values in record.items():
            arrays[name] = np.asarray(values, dtype=np.int64) if isinstance(values, list) else values
        flight = Flight(system, arrays, self.events)
        if error is None:
            return flight
        if isinstance(error, KeyboardInterrupt):
            error = Interrupted("interrupted in a flight of particles; the flight so far is in .flight")
        keep_result(error, "flight", flight)
        raise error

    def _start(self, start: Any) -> float:
        """Return the start of the flight, which has to agree with the particles' time if they have one."""
        units, particle_time = self._context.units, self._time
        if start is None and particle_time is not None:
            return particle_time
        time = units.number(start, "time", "start")
        if particle_time is not None and abs(time - particle_time) > 1e-12 * max(abs(time), abs(particle_time)):
            raise InvalidInput(
                f"the particles have the time {units.text(particle_time, 'time', 12)}, but the flight starts at "
                f"{units.text(time, 'time', 12)}; expected the state, run or start of that time, or "
                "Particles(particles.position, particles.velocity), which have no time"
            )
        return time


def fly(
    run: Any,
    particles: Particles,
    until: Any = None,
    *,
    duration: Any = None,
    output: Any = None,
    start: Any = None,
    integrator: Integrator | None = None,
    contact: str | Bounce = "stop",
    escape: EscapeDistance | None = None,
    radiation: Radiation | None = None,
    events: Iterable[ParticleEvent] = (),
    threads: int | None = None,
    progress: Any = False,
) -> Flight[Any]:
    """Fly massless particles along a run with ``dense=True``.

    The particles are attracted by all bodies and by third bodies (relative to the system's nominal barycentre, which
    falls freely with the coordinates), and accelerated by radiation. Tides, YORP, BYORP and
    :class:`fullbody.forces.Function` act on bodies only; a warning says so for the latter.

    Parameters
    ----------
    particles : Particles
    until, duration : float, Quantity or text with a unit, optional
        End of the flight, within the run, by default that of the run; or its length. It is before the start, or below
        zero, for a flight backwards.
    output : None, "ends", float, Quantity or array_like
        The times that are recorded. With ``None`` only fates and last positions are recorded; ``"ends"`` means the
        start and the end, a number the spacing of times from the start to the end, and an array exactly these times.
    start : float, Quantity or text with a unit, optional
        Time of the particles, within the run; by default their own, or the start of the run if they have none.
    integrator : Integrator, optional
        Integrator of the particles, with step control; by default ``Verner98(rtol=1e-12, atol=1e-12)``. The error of a
        step is held below ``rtol`` times the distance from the nearest centre plus ``atol`` times that distance at the
        start; the error of the velocity likewise, relative to sqrt(v^2 + Phi) with the potential of the bodies' masses.
        Below the run's tolerance, by which the bodies move, nothing is gained.
    contact : {"stop", "remove"} or Bounce
        The contact response: the flight ends and the particle stays at the surface (``"stop"``) or is removed, or the
        particle bounces.
    escape : EscapeDistance, optional
        The condition at which a particle has escaped, which ends its flight.
    radiation : Radiation, optional
        Radiation pressure of a third body.
    events : iterable of ParticleEvent
        Events to detect, from :mod:`fullbody.particles`.
    threads : int, optional
        Number of threads; by default as many as the machine runs at once. Results do not depend on it.
    progress : bool, str or callable
        Progress bar or function, as in :meth:`fullbody.System.integrate`.

    Raises
    ------
    InvalidInput
        If particles are inside a body or have another time than the start; if times are outside of the run; and if the
        run has no continuous solution.
    Interrupted
        On Ctrl-C, with the flight so far in the attribute ``flight``.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 24.0, dense=True)
    >>> flight = run.fly(fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]]), output="ends")
    >>> flight.position.shape
    (2, 1, 3)
    """
    options: dict[str, Any] = {"integrator": integrator, "contact": contact, "escape": escape}
    options |= {"radiation": radiation, "events": events, "threads": threads}
    task = FlightTask(run.context, particles, **options)
    dense = run.continuous()
    with Progress(progress) as report:
        return task.fly(run.system, dense, start, until, duration, output, report)
