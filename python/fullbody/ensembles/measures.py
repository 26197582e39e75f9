"""What papers map: fates, attitudes, librations, orbits and drifts of runs, as numbers by names."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import named_options
from ..errors import BodiesOverlap, InvalidInput
from ..events import Contact, Escape
from ..model.system import BaseSystem
from ..observables import libration as swings
from ..observables import mutual_period, tumbles
from ..observables._relative import check_run
from ..record.base import BaseRun

__all__ = ["attitude", "drift", "fate", "libration", "orbit"]

#: Sums of the longest semi-axes. From there on figures and spins change the energy of an orbit by less than a
#: thousandth of its parts.
_FAR = 20.0


@named_options
def fate(run: BaseRun, *, body: int | str = 1, about: int | str = 0, beyond: Any = None) -> dict[str, Any]:
    """Whether a body hit another one, escaped or stayed, and when.

    Parameters
    ----------
    run : Run
    body, about : int or str
        Places in the system, or names.
    beyond : float or Quantity, optional
        The distance from which on an unbound orbit counts as escape; 20 times the sum of both longest semi-axes unless
        given.

    Returns
    -------
    dict
        ``fate``: ``"contact"``, with whatever body; ``"escape"``; ``"bound"``, at the end of the run; or
        ``"unfinished"``, where an error other than a contact or Ctrl-C ended it. ``fate_time``: the time of the
        contact, that of the escape, or the end of the run.

    Raises
    ------
    InvalidInput
        For a run without samples that no contact ended.

    Notes
    -----
    A contact is a :class:`fullbody.events.Contact` that happened, or the overlap that ended the run. An escape is a
    :class:`fullbody.events.Escape` that the run ended with. Otherwise the body has escaped if its last sample is beyond
    the distance with a positive energy of the relative motion as points, and the time is that of the first sample from
    which on that stays so.

    Examples
    --------
    >>> import fullbody
    >>> bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=0.5) for _ in range(2)]
    >>> system = fullbody.System(bodies, G=1.0)
    >>> starts = [fullbody.State([[0, 0, 0], [4, 0, 0]], [[0, 0, 0], [0, speed, 0]]) for speed in (0.1, 0.5, 1.5)]
    >>> runs = fullbody.integrate_many([(system, state) for state in starts], 100.0, output=1.0)
    >>> [fullbody.ensembles.fate(getattr(run, "run", run))["fate"] for run in runs]
    ['contact', 'bound', 'escape']
    """
    check_run(run, "a fate")
    system, units = run.system, run.system._units
    body, about = system._place(body, "body"), system._place(about, "about")
    limit = _far(system, body, about) if beyond is None else units.number(beyond, "length", "beyond")
    contact = _contact(run, body)
    if contact is not None:
        return {"fate": "contact", "fate_time": contact}
    last = run.events[-1] if run.events and run.stop_reason == "event" else None
    if last is not None and isinstance(last.event, Escape) and body in _places(system, last.event):
        return {"fate": "escape", "fate_time": last.time}
    if len(run) == 0:
        raise InvalidInput("the run has no samples to tell a fate by; expected a run with its end, as of output='ends'")
    gone = _gone(run, body, about, limit)
    if gone[-1]:
        since = len(gone) - int(np.argmin(gone[::-1])) if not gone.all() else 0
        return {"fate": "escape", "fate_time": run.time[since]}
    ended = run.stop_reason in ("end", "event", "unknown")
    return {"fate": "bound" if ended else "unfinished", "fate_time": run.time[-1]}


def _places(system: BaseSystem, event: Any) -> set[int]:
    return {system._place(event.i, "i"), system._place(event.j, "j")}


def _contact(run: BaseRun, body: int) -> Any:
    """The time of a body's first contact, or none."""
    for happened in run.events:
        event = happened.event
        # Bodies that part have not met.
        if isinstance(event, Contact) and event.direction <= 0 and body in _places(run.system, event):
            return happened.time
    if isinstance(run.error, BodiesOverlap) and run.system.names[body] in run.error.bodies:
        return run.system._units.attach(np.float64(run.error.time), "time")
    return None


def _far(system: BaseSystem, body: int, about: int) -> float:
    sizes = (system.bodies[place]._semi_axes(system._units) for place in (body, about))
    return _FAR * float(sum(max(axes) for axes in sizes if axes is not None))


def _gone(run: BaseRun, body: int, about: int, limit: float) -> npt.NDArray[np.bool_]:
    """At which samples a body is far away and unbound."""
    record, masses = run._record, run.system._masses
    r, v = (record[name][:, body] - record[name][:, about] for name in ("position", "velocity"))
    distance, mu = np.linalg.norm(r, axis=1), run.system._G * (masses[body] + masses[about])
    found: npt.NDArray[np.bool_] = (distance > limit) & (np.sum(v * v, axis=1) * distance > 2.0 * mu)
    return found


@named_options
def attitude(run: BaseRun, limit: Any = np.pi / 2, *, body: int | str = 1, about: int | str = 0) -> dict[str, Any]:
    """The largest roll, pitch and yaw of a body in its orbit's frame, and whether it tumbles.

    Parameters
    ----------
    run : Run
        With samples that :func:`fullbody.observables.tumbles` can follow.
    limit : float or Quantity
        The angle that one of the three passes when the body begins to tumble: a quarter turn at most.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    dict
        ``roll``, ``pitch``, ``yaw``: the largest of either sign, radians, half a turn where the body has gone round.
        ``tumbles``: 1 where it does, else 0. ``tumbling_time``: when it began, or ``None``.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.didymos_after_dart(tilt=1e-3)
    >>> found = fullbody.ensembles.attitude(system.integrate(state, 300.0, output=1.0))
    >>> found["tumbles"], found["tumbling_time"]
    (0.0, None)
    """
    found = tumbles(run, limit, body=body, about=about)
    attach = run.system._units.attach
    largest = run.system._units.strip(found.largest, "angle", "angle")
    angles = {
        name: attach(np.float64(min(size, np.pi)), "angle")
        for name, size in zip(("roll", "pitch", "yaw"), largest, strict=True)
    }
    return angles | {"tumbles": float(found.time is not None), "tumbling_time": found.time}


@named_options
def libration(run: BaseRun, *, body: int | str = 1, about: int | str = 0) -> dict[str, Any]:
    """The amplitude of a body's libration and the period of its strongest term.

    Parameters
    ----------
    run : Run
        As :func:`fullbody.observables.libration` needs it.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    dict
        ``libration``: half of peak to peak, radians, and ``libration_period``; both ``None`` for a body that turns
        round.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> found = fullbody.ensembles.libration(system.integrate(state, 200.0, output=0.25))
    >>> sorted(found)
    ['libration', 'libration_period']
    """
    found = swings(run, body=body, about=about, count=1)
    if found.amplitude is None or not len(found.frequencies):
        return {"libration": found.amplitude, "libration_period": None}
    rate = run.system._units.strip(found.frequencies, "spin", "frequency")[0]
    period = run.system._units.attach(np.float64(2 * np.pi / rate), "time")
    return {"libration": found.amplitude, "libration_period": period}


@named_options
def orbit(run: BaseRun, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> dict[str, Any]:
    """The mean period of an orbit and the means of its osculating elements.

    Parameters
    ----------
    run : Run
        Of two revolutions or more, sampled at even times.
    mu : float or Quantity, optional
        As for :meth:`fullbody.Run.elements`.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    dict
        ``period``, the mean one of :func:`fullbody.observables.mutual_period`; ``a``, ``e`` and ``i``, means under a
        Hann window, which leaves next to nothing of what recurs several times in the run.

    Raises
    ------
    InvalidInput
        For less than two revolutions, and for samples half a revolution apart or more.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> found = fullbody.ensembles.orbit(system.integrate(state, 500.0, output=1.0))
    >>> round(float(found["period"]), 1), round(float(found["a"]), 2)
    (17.1, 2.55)
    """
    period = mutual_period(run, body=body, about=about).mean
    elements = run.elements(mu, body=body, about=about)
    time = run._record["time"]
    # Each sample counts for the time that it stands for.
    weight = np.sin(np.pi * (time - time[0]) / (time[-1] - time[0])) ** 2 * np.abs(np.gradient(time))
    weight /= weight.sum()
    means = {name: (getattr(elements, name) * weight).sum() for name in ("a", "e", "i")}
    return {"period": period, **means}


@named_options
def drift(run: BaseRun) -> dict[str, Any]:
    """The largest drifts of a run, which tell how exact its integration was.

    Parameters
    ----------
    run : Run

    Returns
    -------
    dict
        ``energy_drift``, ``energy_drift_orbital``, ``angular_momentum_drift``: the largest size of
        :attr:`fullbody.Run.energy_drift` and the others over the samples, ``None`` without any.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> found = fullbody.ensembles.drift(system.integrate(state, 100.0, output="ends"))
    >>> all(size < 1e-12 for size in found.values())
    True
    """
    check_run(run, "a drift")
    names = ("energy_drift", "energy_drift_orbital", "angular_momentum_drift")
    return {name: float(np.abs(getattr(run, name)).max()) if len(run) else None for name in names}
