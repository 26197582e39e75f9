"""How a run depends on its start and on parameters of its system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..typing import Array

__all__ = ["Differentiated", "EventDerivatives", "departures"]

_KINDS = ("position", "velocity", "rotation", "spin")


def departures(names: tuple[str, ...]) -> list[str]:
    """What the 12 numbers of each body in a departure are."""
    return [f"{name} {kind} {axis}" for name in names for kind in _KINDS for axis in "xyz"]


@dataclass(frozen=True, slots=True, eq=False)
class EventDerivatives(ArrayFields):
    """How the time and the state of a terminal event depend on the start of a run and on parameters.

    Attributes
    ----------
    time : ndarray, (12 N,)
        Derivatives of the event's time by the start.
    transition : ndarray, (12 N, 12 N)
        Those of the state at the event, whose time changes too.
    time_sensitivity : dict of float
        Derivatives of the time by the parameters.
    sensitivity : dict of ndarray, (12 N,)
        Those of the state.
    """

    time: npt.NDArray[np.float64]
    transition: npt.NDArray[np.float64]
    time_sensitivity: dict[str, float]
    sensitivity: dict[str, npt.NDArray[np.float64]]

    def __repr__(self) -> str:
        bodies, parameters = len(self.time) // 12, ", ".join(self.sensitivity)
        return f"EventDerivatives({bodies} bodies{', parameters ' + parameters if parameters else ''})"


class Differentiated:
    """What a run has that was integrated with ``derivatives=`` or ``chaos=True``.

    A departure from a run has 12 numbers a body, body after body: position and velocity in the inertial frame, a
    rotation vector theta in the body frame (R becomes R exp(theta), in rad), and spin in the body frame. All are
    numbers in the system's own units.
    """

    system: Any
    stop_reason: str
    events: list[Any]
    _record: dict[str, npt.NDArray[np.float64]]
    #: Names of the parameters that the run was differentiated by.
    _parameters: tuple[str, ...] = ()

    @property
    def transition(self) -> npt.NDArray[np.float64]:
        """Transition matrices (K, 12 N, 12 N): a departure from the start of the run times them is that from a sample.

        In the system's own units, per body position, velocity, rotation vector in the body frame and spin. The nominal
        barycentre departs with the start, and the paths of third bodies with it.

        Raises
        ------
        InvalidInput
            For a run that was not integrated with ``derivatives=``.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 10.0, output="ends", derivatives=True)
        >>> run.transition.shape
        (2, 24, 24)
        """
        if "transition" not in self._record:
            raise InvalidInput("this run keeps no transition matrices; integrate with derivatives=True")
        return self._record["transition"]

    @property
    def sensitivity(self) -> dict[str, npt.NDArray[np.float64]]:
        """Derivatives (K, 12 N) of the samples by parameters of the system, by their names; the start stays as it is.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 10.0, output="ends", derivatives=["G", "mass of Alpha"])
        >>> run.sensitivity["mass of Alpha"].shape
        (2, 24)
        """
        if "transition" not in self._record:
            raise InvalidInput("this run keeps no sensitivities; integrate with derivatives=['mass of ...', ...]")
        values = self._record.get("sensitivity")
        return {} if values is None else {name: values[:, k] for k, name in enumerate(self._parameters)}

    def at_last_event(self) -> EventDerivatives:
        """Derivatives of the time and the state of the terminal event that ended the run.

        At a zero of the event's function g the time changes by dt = -(grad g . dx + dg/dp dp) / (dg/dt), and the state
        by dx + f dt, with dx the departure at a fixed time and f the rates of change there. The derivatives of g itself
        are differences of eighth order. A :class:`fullbody.events.Function` knows the state alone and has no dg/dp; a
        third body is taken to stand where its path has it relative to the barycentre at the event.

        Returns
        -------
        EventDerivatives

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> apsis = fullbody.events.Apoapsis(0, 1, terminal=True)
        >>> run = system.integrate(state, 60.0, events=[apsis], derivatives=True)
        >>> run.at_last_event().time.shape
        (24,)
        """
        if self.stop_reason != "event" or not self.events:
            raise InvalidInput(f"stop_reason is {self.stop_reason!r}; expected a run that a terminal event ended")
        transition, sensitivity = self.transition[-1], self.sensitivity
        happened = self.events[-1]
        core = self.system._strip(happened.state)
        if self._record["time"][-1] != core.time:
            raise InvalidInput(
                f"the event that ended the run, at time {happened.time}, is not its last sample; expected a run whose "
                "last sample is that of the event, not a part of it"
            )
        condition = happened.event._condition(self.system)
        slopes, by_time, direct = condition.slopes(self.system._core, core, list(sensitivity))
        flow = self.system._core.jacobian(core, [])[3]
        rate = slopes @ flow + by_time
        if rate == 0.0:
            raise InvalidInput(
                f"the function of {happened.event!r} does not change along the run; expected one that does"
            )
        time = -(slopes @ transition) / rate
        pairs = zip(sensitivity.items(), direct, strict=True)
        times = {name: float(-(slopes @ values[-1] + own) / rate) for (name, values), own in pairs}
        return EventDerivatives(
            time,
            transition + np.outer(flow, time),
            times,
            {name: values[-1] + flow * times[name] for name, values in sensitivity.items()},
        )

    @property
    def megno(self) -> npt.NDArray[np.float64]:
        """Mean of MEGNO since the start of the run (K,): tends to 2 for regular motion, and grows with chaotic motion.

        Of a run with ``chaos=True``; zero at its start. See Cincotta & Simo (2000), Astron. Astrophys. Suppl. 147, 205.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 3000.0, output="ends", chaos=True)
        >>> bool(abs(run.megno[-1] - 2.0) < 0.1)
        True
        """
        return self._chaos(0)

    @property
    def lyapunov(self) -> Array:
        """Growth ``ln(|delta|/|delta_0|)`` of a departure over the time since the start (K,), in 1/time.

        Tends to the largest Lyapunov exponent; its inverse is the Lyapunov time. Of a run with ``chaos=True``;
        departures are measured in the natural sizes of their numbers at the start: separation, orbital speed or the
        body's own, rad, and the spin.
        """
        rate: Array = self.system._units.attach(self._chaos(1), "rate")
        return rate

    @property
    def fast_lyapunov(self) -> npt.NDArray[np.float64]:
        """The largest ``ln(|delta|/|delta_0|)`` so far (K,): the fast Lyapunov indicator. For ``chaos=True``."""
        return self._chaos(2)

    def _chaos(self, which: int) -> npt.NDArray[np.float64]:
        if "chaos" not in self._record:
            raise InvalidInput("this run keeps no indicators of chaos; integrate with chaos=True")
        return self._record["chaos"][:, which]
