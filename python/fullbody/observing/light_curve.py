"""Light curves: the brightness of the bodies of a run, as the observer sees them at given times."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..base.limits import FINITE, POSITIVE
from ..base.units import UNITLESS
from ..errors import InvalidInput, interruptible
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Array, Floats
from .brightness import Epochs, Photometer, of_unit_sphere
from .laws import Law, LommelSeeliger
from .states import DISTANT, RetardedStates, refuse_near, retarded
from .times import exposure_rule, kilometres, to_system_times
from .vectors import SystemGeometry, Vectors, local_geometry

#: The diameter in km of a white sphere of absolute magnitude zero, and the astronomical unit in km.
_WHITE_DIAMETER, _AU = 1329.0, 149597870.7
#: The number of times between two interrupt checks, which takes a few milliseconds for two ellipsoids.
_CHUNK = 2048


@interruptible("a light curve")
def light_curve(
    run: Record,
    times: Any,
    geometry: Vectors,
    *,
    law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
    albedo: float | Array | dict[str, Any] = 1.0,
    mutual: bool = True,
    sun_radius: Any = 0.0,
    exposure: Any = 0.0,
    reduced: bool = True,
    per_body: bool = False,
) -> Floats:
    """Compute the magnitudes of the bodies of a run, with their mutual occultations and eclipses.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    times : astropy Time, or array_like or Quantity, (K,)
        Times at which the light arrives at the observer.
    geometry : Geometry
        A geometry that includes the Sun.
    law, albedo, mutual, sun_radius
        Options of :func:`brightness`.
    exposure : float or Quantity
        The time of integration about each of the times, over which the brightness is averaged by five values.
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
        For times outside the span of the geometry or of the run, for a geometry without the Sun, and for an observer or
        a Sun nearer to a body than about 300 times its radius.

    Notes
    -----
    Each body is at its position and attitude when its light left it, and is seen along the direction and from the
    distance of its own centre; magnitudes are reduced by the distances of the barycentre. A body casts its shadow from
    its position when the sunlight passed it, as in :func:`mutual_events`; only its rotation until the light left the
    other body is neglected. The use of one direction for the whole surface of a body has an error of up to
    twice its radius over the distance.

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
    photometer, rule = Photometer(system, law, albedo, mutual, sun_radius), exposure_rule(exposure, system)
    result = []
    for part in _parts(to_system_times(times, system, "times")):
        light = np.zeros((len(part), len(system.context)))
        for time, weight in rule:
            light += weight * photometer.brightness(_epochs_of_run(run, local, part + time, "a light curve"))
        total = light if per_body else light.sum(axis=1)
        result.append(magnitudes(total, local.observer(part), local.sun(part), reduced))
    return np.concatenate(result)


def epochs_of(run: Record, times: Any, geometry: Vectors, what: str) -> Iterator[Epochs]:
    """Iterate over what a photometer sees at times (K,) of arrival, in parts between which Ctrl-C is noticed."""
    system = run.system
    local = local_geometry(geometry, system)
    for part in _parts(to_system_times(times, system, "times")):
        yield _epochs_of_run(run, local, part, what)


def _parts(arrival: Floats) -> list[Floats]:
    """Return times () or (K,) in parts between which Ctrl-C is noticed."""
    arrival = np.atleast_1d(arrival)
    if arrival.ndim != 1:
        raise InvalidInput(f"times has shape {arrival.shape}; expected (K,)")
    return np.array_split(arrival, max(1, -(-len(arrival) // _CHUNK)))


def _epochs_of_run(run: Record, local: SystemGeometry, moments: Floats, what: str) -> Epochs:
    """Return what a photometer sees of a run at times (K,) of arrival."""
    states, retarded_states = retarded(run, local, moments, f"time of {what}")
    return epochs_at(run.system, local, states, retarded_states, 1.0, DISTANT + 1.0)


def epochs_at(
    system: SystemLike,
    local: SystemGeometry,
    states: dict[str, Floats],
    retarded_states: RetardedStates,
    orbits: float,
    sizes: float,
) -> Epochs:
    """Return what a photometer sees, after :func:`refuse_near` has checked the distances of observer and Sun."""
    attitude, times = retarded_states.attitude(states["attitude"], states["spin"]), retarded_states.times
    to_sun = local.sun(times)
    for name, vector in (("observer", retarded_states.observer), ("Sun", to_sun)):
        refuse_near(system, local, name, vector, retarded_states.centre, attitude, times, orbits, sizes)
    beta = retarded_states.velocity / retarded_states.light_speed
    return Epochs(times, retarded_states.centre, attitude, retarded_states.observer, to_sun, beta, local.distant)


def zero_point(
    system: SystemLike,
    *,
    geometric_albedo: Any = None,
    H: Any = None,
    law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
    albedo: float | dict[str, Any] = 1.0,
    reduced: bool = True,
) -> float:
    """Compute the zero point that makes the magnitudes of :func:`light_curve` absolute.

    Parameters
    ----------
    system : System
    geometric_albedo : float
        The geometric albedo of a body whose ``albedo`` is one. Either this or ``H`` is given.
    H : float
        The absolute magnitude of all bodies together.
    law, albedo
        Options of the same light curve; with a geometric albedo one law for all bodies.
    reduced : bool
        Whether the light curve is reduced to unit distances. With ``reduced=False`` the sum of its magnitude
        and the zero point is the apparent magnitude.

    Returns
    -------
    float
        The number to add to the magnitudes; :class:`Photometry` accepts it as ``zero=``.

    Raises
    ------
    InvalidInput
        Unless exactly one of ``geometric_albedo`` and ``H`` is given, and if the distances need units that the system
        does not have.

    Notes
    -----
    A sphere of diameter D and geometric albedo p, at phase angle zero and at 1 au from the Sun and from the observer,
    has the magnitude H of D = 1329 km p^(-1/2) 10^(-H/5) (Fowler & Chillemi 1992; Pravec & Harris 2007, Icarus 190,
    250, doi:10.1016/j.icarus.2007.02.023). For ``H`` each body counts as the sphere of its volume.

    Examples
    --------
    The magnitude of (1) Ceres, of diameter 939.4 km and albedo 0.09, is 3.37 by this formula:

    >>> import fullbody, numpy as np
    >>> from fullbody import observing
    >>> ceres = fullbody.System([fullbody.Body(fullbody.Sphere("469.7 km"), mass="9.38e20 kg")], units=True)
    >>> at_rest = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)))
    >>> light = observing.brightness(ceres, at_rest, [1, 0, 0], [1, 0, 0])[0].value
    >>> round(float(observing.zero_point(ceres, geometric_albedo=0.09) - 2.5 * np.log10(light)), 2)
    3.37
    """
    if (geometric_albedo is None) == (H is None):
        raise InvalidInput(f"geometric_albedo and H are {geometric_albedo!r} and {H!r}; expected one of the two")
    if any(map(np.ndim, albedo.values() if isinstance(albedo, dict) else [albedo])):
        raise InvalidInput("albedo is an array over faces; expected one number for each body beside a zero point")
    photometer = Photometer(system, law, albedo, False, 0.0)
    if H is None:
        p = UNITLESS.number(geometric_albedo, "number", "geometric_albedo", POSITIVE)
        if any(body_law != photometer.laws[0] for body_law in photometer.laws):
            raise InvalidInput("law differs between bodies beside a geometric_albedo; expected one law for all, or H")
        unit = kilometres(system, "a geometric albedo")
        zero = 5.0 * np.log10(_WHITE_DIAMETER / unit) - 2.5 * np.log10(4.0 * p / of_unit_sphere(photometer.laws[0]))
    else:
        radii = np.cbrt([0.75 * body.volume / np.pi for body in system.context.bodies])
        total = sum(
            body_albedo * of_unit_sphere(body_law) * radius**2
            for body_albedo, body_law, radius in zip(photometer.albedo, photometer.laws, radii, strict=True)
        )
        if not total > 0.0:
            raise InvalidInput("the bodies have no size or no albedo; expected light from one or more")
        zero = UNITLESS.number(H, "number", "H", FINITE) + 2.5 * np.log10(total)
    return float(zero if reduced else zero - 10.0 * np.log10(_AU / kilometres(system, "a magnitude as observed")))


def magnitudes(light: Floats, to_observer: Floats, to_sun: Floats, reduced: bool) -> Floats:
    """Return the magnitudes (K,) or (K, N) of brightnesses in squared length; the vectors are (K, 3)."""
    with np.errstate(divide="ignore"):
        result = -2.5 * np.log10(light)
    if not reduced:
        distances = 5.0 * np.log10(np.linalg.norm(to_observer, axis=1) * np.linalg.norm(to_sun, axis=1))
        result = result + (distances if result.ndim == 1 else distances[:, None])
    return np.asarray(result)
