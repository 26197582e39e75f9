"""Derivatives of a run at its events."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.state import strip
from ..typing import Floats
from .record import Record


@dataclass(frozen=True, slots=True, eq=False)
class EventDerivatives(ArrayFields):
    """Derivatives of the time and the state of an event with respect to the start of a run and to parameters.

    Those of the state include the change of the event's time. Parameters are those of the run and of the event itself.

    Attributes
    ----------
    time : ndarray, (12 N,)
        Derivatives of the event's time with respect to the start of the run.
    transition : ndarray, (12 N, 12 N)
        Derivatives of the state at the event with respect to the start of the run.
    time_sensitivity : dict of float
        Derivatives of the event's time with respect to the parameters.
    sensitivity : dict of ndarray, (12 N,)
        Derivatives of the state at the event with respect to the parameters.
    """

    time: Floats
    transition: Floats
    time_sensitivity: dict[str, float]
    sensitivity: dict[str, Floats]

    def __repr__(self) -> str:
        bodies, parameters = len(self.time) // 12, ", ".join(self.sensitivity)
        return f"EventDerivatives({bodies} bodies{', parameters ' + parameters if parameters else ''})"


def at_event(run: Record, k: int = -1) -> EventDerivatives:
    """Return the derivatives of the time and the state of an event.

    At a zero of the event's function g the time changes by dt = -(grad g . dx + dg/dp dp) / (dg/dt), and the state by
    dx + f dt, with dx the tangent vector at a fixed time and f the rates of change there. The derivatives of g itself
    are differences of eighth order. A :class:`fullbody.events.Function` depends only on the state and has no dg/dp; for
    a closest approach, the third body keeps its position relative to the barycentre at the event.

    Parameters
    ----------
    k : int
        Index of the event in :attr:`events`; by default the last one.

    Returns
    -------
    EventDerivatives
        Its dictionaries have the parameters of the run and those of the event, such as ``"value of Separation"``.

    Raises
    ------
    InvalidInput
        For a run without ``derivatives=``, for an event that the run does not have, and for one whose function is
        constant along the run.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> apsis = fullbody.events.Periapsis(0, 1)
    >>> run = system.integrate(state, 40.0, output="ends", events=[apsis], derivatives=True)
    >>> run.at_event(0).time.shape
    (24,)
    """
    if not -len(run.events) <= k < len(run.events):
        raise InvalidInput(f"k is {k!r}; expected the index of one of the {len(run.events)} events of the run")
    happened = run.events[k]
    if happened.derivatives is None:
        raise InvalidInput("the events of this run keep no derivatives; integrate with derivatives=True")
    transition, sensitivity, flow = happened.derivatives
    condition, names = happened.event._condition(run.context), list(run.parameters)
    core = strip(happened.state, run.context)
    gradient, by_time, direct, by_condition = condition.derivatives(run.context.core, core, names)
    rate = gradient @ flow + by_time
    if rate == 0.0:
        raise InvalidInput(f"the function of {happened.event!r} does not change along the run; expected one that does")
    time = -(gradient @ transition) / rate
    fixed = dict(zip(names, sensitivity, strict=True)) | {name: np.zeros_like(flow) for name, _ in by_condition}
    by_parameter = dict(zip(names, direct, strict=True)) | dict(by_condition)
    times = {name: float(-(gradient @ values + by_parameter[name]) / rate) for name, values in fixed.items()}
    states = {name: values + flow * times[name] for name, values in fixed.items()}
    return EventDerivatives(time, transition + np.outer(flow, time), times, states)
