"""The shape of an orbit from its distances alone, and its mean eccentricity."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.values import ArrayFields
from ..record.record import Record
from ..typing import Floats
from ._follow import Path
from ._relative import WINDOWED, RelativeMotion
from .orbit import frequencies, passages

#: Number of Newton steps from a sampled extreme of the distance to the extreme itself.
_STEPS = 4


@dataclass(frozen=True, eq=False, repr=False)
class OrbitShape(ArrayFields):
    """Smallest and largest distances of each revolution, and the ellipse that has them.

    Attributes
    ----------
    time : ndarray or Quantity, (R,)
        Ends of the revolutions, with times counted from the earliest sample.
    periapsis, apoapsis : ndarray or Quantity, (R,)
        The smallest and the largest distance in each revolution.
    a : ndarray or Quantity, (R,)
        Half of the sum of both distances.
    e : ndarray, (R,)
        The difference of both distances divided by their sum.
    """

    time: Any
    periapsis: Any
    apoapsis: Any
    a: Any
    e: Any

    def as_dict(self) -> dict[str, Any]:
        """Return the extremes ``periapsis`` and ``apoapsis``, and means ``a_of_distances`` and ``e_of_distances``."""
        means = {f"{name}_of_distances": getattr(self, name).mean() for name in ("a", "e")}
        return {"periapsis": self.periapsis.min(), "apoapsis": self.apoapsis.max(), **means}


@dataclass(frozen=True, eq=False, repr=False)
class Eccentricity(ArrayFields):
    """The mean eccentricity of an orbit and the parts it consists of.

    Attributes
    ----------
    free : float or None
        The eccentricity of the ellipse that the distance follows, whose periapsis precesses. The argument
        ``eccentricity=`` of a mean orbit of :func:`fullbody.binary` sets it. ``None`` if the distance shows no
        periapsis.
    forced : float
        The mean part of the osculating eccentricity that is forced by the bodies' figures. A circular orbit has it too.
    osculating : float
        The mean of the osculating eccentricity. It lies between the difference of the other two and their sum.
    """

    free: float | None
    forced: float
    osculating: float

    def as_dict(self) -> dict[str, Any]:
        """Return the eccentricities for a table, under their names with ``_eccentricity``."""
        names = ("free", "forced", "osculating")
        return {f"{name}_eccentricity": getattr(self, name) for name in names}


def orbit_shape(run: Record, *, body: int | str = 1, about: int | str = 0) -> OrbitShape:
    """Compute semi-major axis and eccentricity from the distances alone, revolution by revolution.

    The distance is what an observer or a spacecraft measures, whatever the masses and figures of the bodies. Osculating
    elements, in contrast, give a circular orbit about an oblate body an eccentricity.

    Parameters
    ----------
    run : Run
    body, about : int or str

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
    # The samples of the path and the ends of the revolutions, in order.
    moments = np.union1d(motion.path.time, ends)
    sampled = motion.at(moments)
    distance, speed = _radial(sampled)
    first = np.searchsorted(moments, ends)
    nearest, farthest = (_extremes(motion, moments, speed, distance, sign, first) for sign in (1.0, -1.0))
    return OrbitShape(
        motion.span(ends[1:]),
        motion.length(nearest),
        motion.length(farthest),
        motion.length((farthest + nearest) / 2),
        (farthest - nearest) / (farthest + nearest),
    )


def _radial(path: Path) -> tuple[Floats, Floats]:
    """Return distances and their rates of change (K,)."""
    distance = np.linalg.norm(path.r, axis=1)
    return distance, np.sum(path.r * path.v, axis=1) / distance


def _extremes(
    motion: RelativeMotion, moments: Floats, speed: Floats, distance: Floats, sign: float, first: npt.NDArray[np.intp]
) -> Floats:
    """Return the smallest (sign 1) or largest (-1) distances of revolutions, at samples and between them."""
    depths = np.array([(sign * distance[k : m + 1]).min() for k, m in pairwise(first)])
    towards = sign * speed[first[0] : first[-1] + 1]
    starts = first[0] + np.flatnonzero((towards[:-1] < 0.0) & (towards[1:] >= 0.0))
    if not len(starts):
        return sign * depths
    low, high = moments[starts], moments[starts + 1]
    growth = (speed[starts + 1] - speed[starts]) / (high - low)
    time, rate = low, speed[starts]
    for _ in range(_STEPS):
        time = np.clip(time - rate / growth, low, high)
        extreme, rate = _radial(motion.at(time))
    np.minimum.at(depths, np.searchsorted(first, starts, side="right") - 1, sign * extreme)
    return sign * depths


def eccentricity(run: Record, *, mu: Any = None, body: int | str = 1, about: int | str = 0) -> Eccentricity:
    """Compute the mean eccentricity of an orbit: the free part, the part that figures force, and the osculating one.

    Parameters
    ----------
    run : Run
        More revolutions than five give better means.
    mu : float or Quantity, optional
        Gravitational parameter of the osculating elements; by default G times the sum of the two masses.
    body, about : int or str

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
    context = run.context
    total = context.mu(motion.body, motion.about) if mu is None else context.units.number(mu, "mu", "mu")
    path = motion.path
    longitude, rate = motion.longitude
    distance, growth = _radial(path)
    # In the moving plane vectors are complex numbers; h/r is the speed across the line to the body.
    h = rate * distance**2
    line = np.exp(1j * longitude)
    vector = h * (h / distance - 1j * growth) * line
    sidereal, radial = frequencies(motion, path)
    terms = [line]
    if radial is not None:
        phasor = np.exp(1j * (sidereal - radial) * (path.time - path.time[0]))
        terms += [phasor, 1j * phasor]
    basis = np.stack([np.concatenate([term.real, term.imag]) for term in terms], axis=1)
    depths = np.linalg.lstsq(basis, np.concatenate([vector.real, vector.imag]), rcond=None)[0]
    osculating = vector / total - line
    slow = np.zeros(1) if radial is None else (depths[1] + 1j * depths[2]) * phasor / total
    return Eccentricity(
        None if radial is None else float(np.hypot(depths[1], depths[2]) / depths[0]),
        float(np.abs(osculating - slow).mean()),
        float(np.abs(osculating).mean()),
    )
