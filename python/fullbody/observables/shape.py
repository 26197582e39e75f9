"""The shape of an orbit: by its distances alone, and its mean eccentricity."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import named_options
from ..base.values import ArrayFields
from ._follow import Path
from ._relative import WINDOWED, RelativeMotion
from .orbit import frequencies, passages

if TYPE_CHECKING:
    from ..record.base import BaseRun

__all__ = ["Eccentricity", "OrbitShape", "eccentricity", "orbit_shape"]

_Array = npt.NDArray[np.float64]
#: Steps from a sampled extreme of the distance to the extreme itself.
_STEPS = 4


@dataclass(frozen=True, eq=False, repr=False)
class OrbitShape(ArrayFields):
    """Least and greatest distances of each revolution, and the ellipse that has them.

    Attributes
    ----------
    time : ndarray or Quantity, (R,)
        Ends of the revolutions, counted from the earliest time.
    periapsis, apoapsis : ndarray or Quantity, (R,)
        The least and the greatest distance in each.
    a : ndarray or Quantity, (R,)
        Half of their sum.
    e : ndarray, (R,)
        Their difference by their sum.
    """

    time: Any
    periapsis: Any
    apoapsis: Any
    a: Any
    e: Any


@dataclass(frozen=True, eq=False, repr=False)
class Eccentricity(ArrayFields):
    """The eccentricity of an orbit in its parts.

    Attributes
    ----------
    free : float or None
        The eccentricity of the ellipse that the distance follows, whose periapsis precesses. ``eccentricity=`` of a
        mean orbit of :func:`fullbody.binary` sets it. ``None`` where the distance shows no periapsis.
    forced : float
        The mean part of the osculating eccentricity that the bodies' figures force. A circular orbit has it too.
    osculating : float
        The mean of the osculating eccentricity. Between the difference of the other two and their sum.
    """

    free: float | None
    forced: float
    osculating: float


@named_options
def orbit_shape(run: BaseRun, *, body: int | str = 1, about: int | str = 0) -> OrbitShape:
    """Semi-major axis and eccentricity by the distances alone, revolution by revolution.

    The distance is what an observer and a spacecraft see, whatever the masses and the figures of the bodies; osculating
    elements of a circular orbit about an oblate body have an eccentricity.

    Parameters
    ----------
    run : Run
        A run of one revolution at least.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    OrbitShape

    Raises
    ------
    InvalidInput
        For a run of less than one revolution, and for samples half a revolution apart or more.

    Notes
    -----
    With r_p and r_a the least and the greatest distance in a revolution, a = (r_a + r_p)/2 and
    e = (r_a - r_p)/(r_a + r_p): elements by the separation alone, as Meyer et al. (2023), Planet. Sci. J. 4, 141, take
    them for Didymos after DART. Revolutions are those of :func:`mutual_period`. A periapsis that precesses across the
    ends of the revolutions is at one time in none of them; that one's e is too small by less than a tenth of the square
    of the angle, in radians, that periapsis moves in a revolution, relative to e.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.didymos_after_dart(gravity="point")
    >>> run = system.integrate(state, 100.0, output=1.0)
    >>> shape = fullbody.observables.orbit_shape(run)
    >>> shape.e.round(4)
    array([...])
    """
    motion = RelativeMotion(run, body, about, 8, "an orbit's shape", 1)
    ends = passages(motion)
    # The path and the ends of the revolutions, in order.
    moments = np.union1d(motion.path.time, ends)
    sampled = motion.at(moments)
    distance, speed = _radial(sampled)
    first = np.searchsorted(moments, ends)
    extremes = []
    for sign, find in ((1.0, np.argmin), (-1.0, np.argmax)):
        place = np.array([k + int(find(distance[k : m + 1])) for k, m in pairwise(first)])
        extremes.append(_extremes(motion, moments, speed, distance, place, sign, ends))
    nearest, farthest = extremes
    return OrbitShape(
        motion.span(ends[1:]),
        motion.length(nearest),
        motion.length(farthest),
        motion.length((farthest + nearest) / 2),
        (farthest - nearest) / (farthest + nearest),
    )


def _radial(path: Path) -> tuple[_Array, _Array]:
    """Distances and how fast they grow (K,)."""
    distance = np.linalg.norm(path.r, axis=1)
    return distance, np.sum(path.r * path.v, axis=1) / distance


def _extremes(
    motion: RelativeMotion,
    moments: _Array,
    speed: _Array,
    distance: _Array,
    place: npt.NDArray[np.intp],
    sign: float,
    ends: _Array,
) -> _Array:
    """The least (sign 1) or greatest (-1) distances near samples of them, one in each revolution."""
    # The sample on the other side of the extreme, which has to lie in the revolution too.
    other = np.clip(np.where(sign * speed[place] < 0.0, place + 1, place - 1), 0, len(moments) - 1)
    within = (moments[other] >= ends[:-1]) & (moments[other] <= ends[1:]) & (speed[other] * speed[place] < 0.0)
    found = distance[place]
    if not within.any():
        return found
    k, m = place[within], other[within]
    low, high = np.minimum(moments[k], moments[m]), np.maximum(moments[k], moments[m])
    growth = (speed[m] - speed[k]) / (moments[m] - moments[k])
    time = moments[k]
    rate = speed[k]
    for _ in range(_STEPS):
        time = np.clip(time - rate / growth, low, high)
        there, rate = _radial(motion.at(time))
    found[within] = sign * np.minimum(sign * there, sign * found[within])
    return found


@named_options
def eccentricity(run: BaseRun, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> Eccentricity:
    """The mean eccentricity of an orbit: what is free, what the figures force, and the osculating one.

    Parameters
    ----------
    run : Run
        A run of five revolutions at least; the more, the better the means.
    mu : float or Quantity, optional
        G times the sum of the two masses unless given: what the osculating elements are formed with.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    Eccentricity

    Raises
    ------
    InvalidInput
        For a run of less than five revolutions, and for samples half a revolution apart or more.

    Notes
    -----
    With h = r x v, the vector v x h = mu (r / abs(r) + e) of an osculating orbit is, seen in the moving plane,

        v x h = A r / abs(r) + B,

    with a number A and a vector B that turns at the apsidal rate, by least squares over the run; what is left is of the
    order of e times the forced eccentricity. Then ``free`` is abs(B)/A, the eccentricity of a Kepler orbit with A for
    mu. At the distance r in the equator of an oblate body A = mu (1 + 3/2 J2 (R/r)^2), so that ``forced`` is
    3/2 J2 (R/r)^2: a circular orbit there has this osculating eccentricity, and is always at its periapsis.

    Examples
    --------
    The elements of a mean orbit, measured back.

    >>> import fullbody
    >>> system, state = fullbody.binary(
    ...     fullbody.Component(semi_axes=(1.0, 1.0, 0.9), rotation_period=float("inf"), mass=1.0),
    ...     fullbody.Component(diameter=0.1, mass=1e-6), G=1.0,
    ...     semi_major_axis=5.0, eccentricity=0.02, elements="mean")
    >>> run = system.integrate(state, 1500.0, output=2.0)
    >>> found = fullbody.observables.eccentricity(run)
    >>> round(found.free, 3), round(found.forced, 4)
    (0.02, 0.0023)
    """
    motion = RelativeMotion(run, body, about, 16, "an eccentricity", WINDOWED)
    total = float(motion.units.strip(run.system.mu(motion.about, motion.body) if mu is None else mu, "mu", "mu"))
    path = motion.path
    longitude, rate = motion.longitude
    distance, growth = _radial(path)
    # In the moving plane, as complex numbers; h/r is the speed across the line to the body.
    h = rate * distance**2
    line = np.exp(1j * longitude)
    vector = h * (h / distance - 1j * growth) * line
    sidereal, radial = frequencies(motion, path)
    terms = [line]
    if radial is not None:
        turned = np.exp(1j * (sidereal - radial) * (path.time - path.time[0]))
        terms += [turned, 1j * turned]
    basis = np.stack([np.concatenate([term.real, term.imag]) for term in terms], axis=1)
    found = np.linalg.lstsq(basis, np.concatenate([vector.real, vector.imag]), rcond=None)[0]
    osculating = vector / total - line
    slow = np.zeros(1) if radial is None else (found[1] + 1j * found[2]) * turned / total
    return Eccentricity(
        None if radial is None else float(np.hypot(found[1], found[2]) / found[0]),
        float(np.abs(osculating - slow).mean()),
        float(np.abs(osculating).mean()),
    )
