"""The outcome of a run: the fate of a body, and the drifts of conserved quantities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..base.limits import POSITIVE
from ..base.values import ArrayFields
from ..errors import BodiesOverlap, InvalidInput
from ..events import Contact, Escape
from ..model.context import Context
from ..record.record import Record
from ..typing import Scalar
from ._relative import check_run

#: The distance, in sums of the longest semi-axes, beyond which figures and spins change the energy of an orbit by less
#: than a thousandth of its parts.
_FAR = 20.0
_DRIFTS = ("energy_drift", "energy_drift_orbital", "angular_momentum_drift")


@dataclass(frozen=True, eq=False, repr=False)
class Fate(ArrayFields):
    """The fate of a body in a run, and its time.

    Attributes
    ----------
    kind : {"contact", "escape", "bound", "unfinished"}
        A contact with any body; an escape; neither until the end of the run; or a run that an error other than a
        contact, or Ctrl-C, ended.
    time : float or Quantity
        The time of the contact or of the escape, otherwise the end of the run.
    """

    kind: Literal["contact", "escape", "bound", "unfinished"]
    time: Scalar

    def as_dict(self) -> dict[str, Any]:
        """Return ``fate`` and ``fate_time`` for a table."""
        return {"fate": self.kind, "fate_time": self.time}


@dataclass(frozen=True, eq=False, repr=False)
class Drift(ArrayFields):
    """The largest drifts of a run, which measure the accuracy of its integration.

    Attributes
    ----------
    energy, energy_orbital, angular_momentum : float or None
        The largest absolute values over the samples of :attr:`fullbody.Run.energy_drift`,
        :attr:`~fullbody.Run.energy_drift_orbital` and :attr:`~fullbody.Run.angular_momentum_drift`; ``None`` for a run
        without samples.
    """

    energy: float | None
    energy_orbital: float | None
    angular_momentum: float | None

    def as_dict(self) -> dict[str, Any]:
        """Return ``energy_drift``, ``energy_drift_orbital`` and ``angular_momentum_drift`` for a table."""
        return dict(zip(_DRIFTS, (self.energy, self.energy_orbital, self.angular_momentum), strict=True))


def fate(run: Record, *, body: int | str = 1, about: int | str = 0, beyond: Any = None) -> Fate:
    """Determine whether and when a body hit another one or escaped.

    Parameters
    ----------
    run : Run
        A run with samples, unless it ended with a contact.
    body, about : int or str
    beyond : float or Quantity, optional
        The distance beyond which an unbound orbit counts as escape; by default 20 times the sum of both longest
        semi-axes.

    Raises
    ------
    InvalidInput
        For a run without samples that did not end with a contact.

    Notes
    -----
    A contact is an occurrence of :class:`fullbody.events.Contact`, or the overlap that ended the run. An escape is a
    :class:`fullbody.events.Escape` that ended the run. Otherwise the body has escaped if its last sample is beyond the
    distance with a positive energy of the relative motion as points; the time is that of the first sample from which on
    this holds.

    Examples
    --------
    >>> import fullbody
    >>> bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=0.5) for _ in range(2)]
    >>> system = fullbody.System(bodies, G=1.0)
    >>> starts = [fullbody.State([[0, 0, 0], [4, 0, 0]], [[0, 0, 0], [0, speed, 0]]) for speed in (0.1, 0.5, 1.5)]
    >>> runs = fullbody.integrate_many([(system, state) for state in starts], 100.0, output=1.0)
    >>> [fullbody.observables.fate(getattr(run, "run", run)).kind for run in runs]
    ['contact', 'bound', 'escape']
    """
    check_run(run, "a fate")
    context = run.context
    first, second = context.pair(body, about)
    limit = _FAR * float(sum(max(context.bodies[index].semi_axes) for index in (first, second)))
    if beyond is not None:
        limit = context.units.number(beyond, "length", "beyond", POSITIVE)
    contact = _contact(run, first)
    if contact is not None:
        return Fate("contact", contact)
    last = run.events[-1] if run.events and run.stop_reason == "event" else None
    if last is not None and isinstance(last.event, Escape) and first in _bodies(context, last.event):
        return Fate("escape", last.time)
    if len(run) == 0:
        raise InvalidInput("the run has no samples; expected a run with its end, as of output='ends', for a fate")
    # Whether the body is far away and unbound at each sample.
    r, v = (run.arrays[name][:, first] - run.arrays[name][:, second] for name in ("position", "velocity"))
    distance = np.linalg.norm(r, axis=1)
    gone = (distance > limit) & (np.sum(v * v, axis=1) * distance > 2.0 * context.mu(first, second))
    if gone[-1]:
        since = len(gone) - int(np.argmin(gone[::-1])) if not gone.all() else 0
        return Fate("escape", run.time[since])
    return Fate("bound" if run.stop_reason in ("end", "event") else "unfinished", run.time[-1])


def _bodies(context: Context, event: Any) -> set[int]:
    return {context.index(event.body, "body"), context.index(event.about, "about")}


def _contact(run: Record, body: int) -> Any:
    """Return the time of a body's first contact, or ``None``."""
    for happened in run.events:
        event = happened.event
        # An occurrence at which bodies separate is not counted as a contact.
        if isinstance(event, Contact) and event.direction <= 0 and body in _bodies(run.context, event):
            return happened.time
    if isinstance(run.error, BodiesOverlap) and run.context.names[body] in run.error.bodies:
        return run.context.units.attach(np.float64(run.error.time), "time")
    return None


def drift(run: Record) -> Drift:
    """Determine the largest drifts of a run, which measure the accuracy of its integration.

    Parameters
    ----------
    run : Run

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> fullbody.observables.drift(system.integrate(state, 100.0, output="ends")).energy < 1e-12
    True
    """
    check_run(run, "a drift")
    return Drift(*(float(np.abs(getattr(run, name)).max()) if len(run) else None for name in _DRIFTS))
