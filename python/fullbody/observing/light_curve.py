"""Light curves: the brightness of the bodies of a run, as the observer sees them at given times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput, interruptible
from ..record.record import Record
from ..typing import Array
from .brightness import Photometer
from .laws import LommelSeeliger
from .states import RetardedStates, refuse_near
from .times import in_system
from .vectors import Vectors, local_geometry

if TYPE_CHECKING:
    from .laws import Law

__all__ = ["light_curve"]

_Array = npt.NDArray[np.float64]
#: The number of times between two looks at Ctrl-C: a few milliseconds of two ellipsoids.
_PART = 2048


def light_curve(
    run: Record,
    times: Any,
    geometry: Vectors,
    *,
    law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
    albedo: float | Array | dict[str, Any] = 1.0,
    mutual: bool = True,
    sun_radius: Any = 0.0,
    reduced: bool = True,
    per_body: bool = False,
) -> _Array:
    """Compute the magnitudes of the bodies of a run, with their mutual occultations and eclipses.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the light arrives.
    geometry : Geometry
        A geometry that includes the Sun.
    law, albedo, mutual, sun_radius
        Options of :func:`brightness`.
    reduced : bool
        Whether magnitudes are those at unit distances from the observer and from the Sun. Otherwise 5 log10 of the
        product of the two distances, in the system's unit of length, is added.
    per_body : bool
        Whether to return the magnitude of each body instead of that of all of them together.

    Returns
    -------
    ndarray, (K,) or (K, N)
        -2.5 log10 of the brightness in the square of the system's unit of length; infinite where a body is hidden.

    Raises
    ------
    Interrupted
        On Ctrl-C.
    InvalidInput
        For times outside the geometry's span or the run, a geometry without the Sun, and an observer or a Sun
        nearer than 300 times the reach of the bodies from the barycentre.

    Notes
    -----
    Each body is shown as it was when its light left it towards the observer, and its shadow is cast from where it was
    when the light passed it, as in :func:`mutual_events`; only its rotation in that time is neglected.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
    >>> geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    >>> observing.light_curve(run, np.linspace(1.0, 23.0, 100) * u.h, geometry).shape
    (100,)
    """
    system = run.system
    local = local_geometry(geometry, system)
    when = np.atleast_1d(in_system(times, system, "times"))
    if when.ndim != 1:
        raise InvalidInput(f"times has shape {when.shape}; expected (K,)")
    photometer = Photometer(system, law, albedo, mutual, sun_radius)
    curves = []
    with interruptible("a light curve"):
        for part in np.array_split(when, max(1, -(-len(when) // _PART))):
            states = run.states(local.emission(part), "time of a light curve")
            retarded = RetardedStates(local, part, system.context.masses, states)
            attitude = retarded.attitude(states["attitude"], states["spin"])
            to_sun = local.sun(part)
            for what, position in (("observer", retarded.observer), ("Sun", to_sun)):
                refuse_near(system, what, position, retarded.centre, attitude, part, local.light_speed)
            beta = retarded.velocity / retarded.light_speed
            light = photometer.brightness(part, retarded.centre, attitude, retarded.observer, to_sun, beta)
            total = light if per_body else light.sum(axis=1)
            curves.append(magnitudes(total, retarded.observer, to_sun, reduced))
    return np.concatenate(curves)


def magnitudes(light: _Array, to_observer: _Array, to_sun: _Array, reduced: bool) -> _Array:
    """Return the magnitudes (K,) or (K, N) of brightnesses in squared length."""
    with np.errstate(divide="ignore"):
        curves = -2.5 * np.log10(light)
    if not reduced:
        far = 5.0 * np.log10(np.linalg.norm(to_observer, axis=1) * np.linalg.norm(to_sun, axis=1))
        curves = curves + (far if curves.ndim == 1 else far[:, None])
    return np.asarray(curves)
