"""Measures of runs for maps: fates, attitudes, librations, orbits and drifts, as numbers by names."""

from __future__ import annotations

from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from ..errors import BodiesOverlap, InvalidInput
from ..events import Contact, Escape
from ..motion.run import Run
from ..motion.system import System
from ..observables import libration as swings
from ..observables import mutual_period, tumbles
from ..observables._relative import check_run
from ..typing import Scalar

__all__ = ["Measures", "attitude", "drift", "fate", "libration", "orbit"]

#: The result of a measure: by name, numbers with or without units, texts, or ``None``.
Measures: TypeAlias = dict[str, Scalar | str | None]

#: The distance, in sums of the longest semi-axes, beyond which figures and spins change the energy of an orbit by less
#: than a thousandth of its parts.
_FAR = 20.0


def fate(run: Run, *, body: int | str = 1, about: int | str = 0, beyond: Any = None) -> Measures:
    """Determine whether and when a body hit another one or escaped.

    Parameters
    ----------
    run : Run
    body, about : int or str
        Indices in the system, or names.
    beyond : float or Quantity, optional
        The distance beyond which an unbound orbit counts as escape; by default 20 times the sum of both longest
        semi-axes.

    Returns
    -------
    dict
        ``fate``: ``"contact"`` with any body; ``"escape"``; ``"bound"`` at the end of the run; or ``"unfinished"``, if
        an error other than a contact, or Ctrl-C, ended the run. ``fate_time``: the time of the contact or of the
        escape, otherwise the end of the run.

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
        raise InvalidInput(
            "the run has no samples, which determine its fate; expected a run with its end, as of output='ends'"
        )
    gone = _gone(run, body, about, limit)
    if gone[-1]:
        since = len(gone) - int(np.argmin(gone[::-1])) if not gone.all() else 0
        return {"fate": "escape", "fate_time": run.time[since]}
    ended = run.stop_reason in ("end", "event")
    return {"fate": "bound" if ended else "unfinished", "fate_time": run.time[-1]}


def _places(system: System, event: Any) -> set[int]:
    return {system._place(event.i, "i"), system._place(event.j, "j")}


def _contact(run: Run, body: int) -> Any:
    """Return the time of a body's first contact, or ``None``."""
    for happened in run.events:
        event = happened.event
        # An occurrence at which bodies separate is not counted as a contact.
        if isinstance(event, Contact) and event.direction <= 0 and body in _places(run.system, event):
            return happened.time
    if isinstance(run.error, BodiesOverlap) and run.system.names[body] in run.error.bodies:
        return run.system._units.attach(np.float64(run.error.time), "time")
    return None


def _far(system: System, body: int, about: int) -> float:
    sizes = (system.bodies[place]._semi_axes(system._units) for place in (body, about))
    return _FAR * float(sum(max(axes) for axes in sizes if axes is not None))


def _gone(run: Run, body: int, about: int, limit: float) -> npt.NDArray[np.bool_]:
    """Return at which samples a body is far away and unbound."""
    record, masses = run._record, run.system._masses
    r, v = (record[name][:, body] - record[name][:, about] for name in ("position", "velocity"))
    distance, mu = np.linalg.norm(r, axis=1), run.system._G * (masses[body] + masses[about])
    found: npt.NDArray[np.bool_] = (distance > limit) & (np.sum(v * v, axis=1) * distance > 2.0 * mu)
    return found


def attitude(run: Run, limit: Any = np.pi / 2, *, body: int | str = 1, about: int | str = 0) -> Measures:
    """Determine the largest roll, pitch and yaw of a body in its orbit's frame, and whether it tumbles.

    Parameters
    ----------
    run : Run
        A run with samples close enough for :func:`fullbody.observables.tumbles`.
    limit : float or Quantity
        The angle beyond which the body counts as tumbling, for any of the three: at most a quarter turn.
    body, about : int or str
        Indices in the system, or names.

    Returns
    -------
    dict
        ``largest_roll``, ``largest_pitch``, ``largest_yaw``: absolute values in radians; half a turn if the body has
        gone round.
        ``tumbles``: 1 if the body tumbles, else 0. ``tumbling_time``: when it began, or ``None``.

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
        f"largest_{name}": attach(np.float64(min(size, np.pi)), "angle")
        for name, size in zip(("roll", "pitch", "yaw"), largest, strict=True)
    }
    return angles | {"tumbles": float(found.time is not None), "tumbling_time": found.time}


def libration(run: Run, *, body: int | str = 1, about: int | str = 0) -> Measures:
    """Determine the amplitude of a body's libration and the period of its strongest term.

    Parameters
    ----------
    run : Run
        A run that fulfils the conditions of :func:`fullbody.observables.libration`.
    body, about : int or str
        Indices in the system, or names.

    Returns
    -------
    dict
        ``libration``: half of the peak-to-peak angle, radians, and ``libration_period``; both ``None`` for a body that
        rotates relative to the line between the bodies.

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


def orbit(run: Run, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> Measures:
    """Determine the mean period of an orbit and the means of its osculating elements.

    Parameters
    ----------
    run : Run
        A run of two revolutions or more, sampled at even times.
    mu : float or Quantity, optional
        Gravitational parameter, as for :meth:`fullbody.Run.elements`.
    body, about : int or str
        Indices in the system, or names.

    Returns
    -------
    dict
        ``period``: the mean period from :func:`fullbody.observables.mutual_period`; ``a``, ``e`` and ``i``: means under
        a Hann window, which suppresses terms that recur several times in the run.

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
    # Each sample is weighted by the length of time around it.
    weight = np.sin(np.pi * (time - time[0]) / (time[-1] - time[0])) ** 2 * np.abs(np.gradient(time))
    weight /= weight.sum()
    means = {name: (getattr(elements, name) * weight).sum() for name in ("a", "e", "i")}
    return {"period": period, **means}


def drift(run: Run) -> Measures:
    """Determine the largest drifts of a run, which tell how exact its integration was.

    Parameters
    ----------
    run : Run

    Returns
    -------
    dict
        ``energy_drift``, ``energy_drift_orbital``, ``angular_momentum_drift``: the largest absolute values over the
        samples of :attr:`fullbody.Run.energy_drift` and the properties of the other names; ``None`` for a run without
        samples.

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
    found: Measures = {}
    for name in names:
        found[name] = cast(Scalar, float(np.abs(getattr(run, name)).max())) if len(run) else None
    return found
