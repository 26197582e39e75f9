"""Predicted times of contacts of a star with the limb of a body, from the states at the times that were observed.

Each row is a contact, a disappearance or a reappearance, or a miss. As a line of sight passes a body, the measure f of
the body's limb is nearly a quadratic function of time, nu^2 ((t - m)^2 - h^2), with the middle m of the
chord and the square h^2 of half its duration, which is negative where the body misses the station. A contact is at
m - h or m + h, located to the last digits. Below a bound h0, which depends on the data alone, h is continued linearly
in h^2 as (h0 + h^2 / h0) / 2, so that predictions are smooth functions of all parameters also for a body that misses.

A miss has the time that the line of sight, within the watched interval, takes to leave the body by the shortest path at
the speed at which it passes: zero where the body does not hide the star.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..typing import Floats
from .limbs import Limb
from .states import IMAGINARY_STEP, RetardedStates, into_body, rotated

#: The iterations of a light time, of the middle of a chord, and of a contact; each gains several digits.
_LIGHT_TIMES, _MIDDLES, _CONTACTS = 4, 10, 6
#: The largest change of the middle of a chord in an iteration, in units of the time of a passage.
_LARGEST_STEP = 1e3
#: The changes of the middle and of a contact in these units at which the iterations end.
_MIDDLE_STEP, _CONTACT_STEP = 1e-6, 1e-8

Indices = npt.NDArray[np.intp]


class ContactRows(NamedTuple):
    """K rows of observed contacts and misses, on a system's clock and in its units."""

    #: Times (K,) of the contacts, and the middles of the intervals of misses.
    times: Floats
    #: -1 for a disappearance, 1 for a reappearance, 0 for a miss, (K,).
    sign: Floats
    #: The ends (K, 2) of the chord of each row, infinite where they are not known, or of the interval of a miss.
    interval: Floats
    #: The halves of durations (K,) below which they are continued linearly in their squares.
    shortest: Floats


class StationPath(NamedTuple):
    """Positions and velocities (M, 3) of stations, and unit vectors (M, 3) to the star, at M times."""

    position: Floats
    velocity: Floats
    star: Floats


#: A function from indices of rows (M,) and times (M,) to the path of their stations.
PathFunction = Callable[[Indices, Floats], StationPath]


class ApparentBody(NamedTuple):
    """A body as the observer of the geometry sees it at the K times of the rows; arrays may be complex."""

    #: Centre, velocity and spin, (..., K, 3), and attitude, (..., K, 4).
    centre: Any
    velocity: Any
    spin: Any
    attitude: Any
    #: The distance (..., K, 1) from the observer.
    distance: Any
    #: The displacement (..., K, 3) of the body by the offset of the event.
    displacement: Any
    light_speed: float

    @property
    def real(self) -> ApparentBody:
        """The real parts, which are equal along all axes in front of that of the rows."""
        return self._mapped(lambda part: np.real(part)[(0,) * (part.ndim - 2)])

    def of_rows(self, index: Indices) -> ApparentBody:
        """Return the body at M of the rows."""
        return self._mapped(lambda part: part[..., index, :])

    def _mapped(self, function: Callable[[Any], Any]) -> ApparentBody:
        parts = {name: function(getattr(self, name)) for name in self._fields[:-1]}
        return self._replace(**parts)


def apparent_body(retarded: RetardedStates, states: dict[str, Any], index: int, displacement: Any) -> ApparentBody:
    """Return one of the bodies of retarded states, with the displacement (..., K, 3) of all bodies."""
    attitude = retarded.attitude(states["attitude"], states["spin"])
    arrays = retarded.centre, retarded.velocity, states["spin"], attitude
    centre, velocity, spin, attitude = (array[..., index, :] for array in arrays)
    to_observer = retarded.observer - centre
    distance = np.sqrt(np.sum(to_observer * to_observer, axis=-1, keepdims=True))
    return ApparentBody(centre, velocity, spin, attitude, distance, displacement, retarded.light_speed)


class Passage:
    """Base of the passages of the lines of sight of K rows past one body with limbs, which find its contacts."""

    def __init__(self, rows: ContactRows, path: PathFunction, limbs: Sequence[Limb]) -> None:
        self.rows, self._path, self.limbs = rows, path, limbs
        self.indices = np.arange(len(rows.times))
        self.radius = max(limb.radius for limb in limbs)

    def rays(self, body: ApparentBody, index: Indices, times: Floats, step: complex = 0.0) -> tuple[Any, Any, Any]:
        """Return the rays of rows at times (M,) plus a step: points and directions (..., M, 3), and attitudes.

        The points are relative to the body's centre and perpendicular to the directions; the attitudes (..., M, 4) are
        those of the body when the light passed it.
        """
        path, body = self._path(index, times), body.of_rows(index)
        position = path.position + path.velocity * step
        elapsed = since_row = (times - self.rows.times[index] + step)[..., None]
        for _ in range(_LIGHT_TIMES if np.isfinite(body.light_speed) else 0):
            separation = position - body.centre - body.velocity * elapsed
            distance = np.sqrt(np.sum(separation * separation, axis=-1, keepdims=True))
            elapsed = since_row - (distance - body.distance) / body.light_speed
        separation = position - body.centre - body.velocity * elapsed - body.displacement
        depth = np.sum(separation * path.star, axis=-1, keepdims=True)
        return separation - depth * path.star, path.star, rotated(body.attitude, body.spin, elapsed[..., 0])

    def rays_in_body(self, body: ApparentBody, index: Indices, times: Floats, step: complex = 0.0) -> tuple[Any, Any]:
        """Return points and directions (..., M, 3) of the :meth:`rays` in the body's frame."""
        w, u, attitude = self.rays(body, index, times, step)
        return into_body(attitude, w), into_body(attitude, u)

    def rates(self, body: ApparentBody, index: Indices, times: Floats, limb: Limb) -> Floats:
        """Return the derivatives (M,) of the measure of a limb with respect to time."""
        measure = limb.measure(*self.rays_in_body(body.real, index, times, 1j * IMAGINARY_STEP))
        return np.asarray(measure.imag / IMAGINARY_STEP)

    def solve(self, body: ApparentBody) -> Floats:
        """Find the contacts, and return predictions (K,) relative to the times of the rows."""
        raise NotImplementedError

    def linearised(self, body: ApparentBody, limbs: Sequence[Limb] | None = None) -> Any:
        """Return predictions (..., K) for changes of the body, or of its limbs, to first order about the contacts."""
        raise NotImplementedError

    def speed(self, body: ApparentBody) -> Floats:
        """Return the speeds (K,) of the lines of sight past the body."""
        path = self._path(self.indices, self.rows.times)
        velocity = path.velocity - body.velocity.real
        speed = np.linalg.norm(velocity - np.sum(velocity * path.star, axis=-1)[:, None] * path.star, axis=-1)
        if not (speed > 0.0).all():
            raise InvalidInput(
                "the lines of sight of the stations do not move past the bodies; expected vectors to the observer that "
                "change with time"
            )
        return np.asarray(speed)


def continued(shortest: Floats, square: Any) -> Any:
    """Return half the durations of chords, continued linearly in their squares below the shortest."""
    return 0.5 * (shortest + square / shortest)


class EllipsoidContacts(Passage):
    """The contacts of K rows with an ellipsoid, all at once."""

    def __init__(self, rows: ContactRows, path: PathFunction, limbs: Sequence[Limb]) -> None:
        super().__init__(rows, path, limbs)
        #: Times of the middles of the chords, of the contacts, and in which the body's radius passes; which contacts
        #: are those of the body rather than continued.
        self._middle = self._times = self._width = rows.times
        self._is_exact = rows.sign != 0.0

    def solve(self, body: ApparentBody) -> Floats:
        """Find the contacts, and return predictions (K,) relative to the times of the rows."""
        rows, limb = self.rows, self.limbs[0]
        width, middle = self.radius / self.speed(body), rows.times
        for _ in range(_MIDDLES):
            _, slope, curvature = self._parabola(body, middle, width, limb)
            step = width * np.clip(0.5 * slope / curvature, -_LARGEST_STEP, _LARGEST_STEP)
            middle = middle - step
            if (np.abs(step) <= _MIDDLE_STEP * width).all():
                break
        value, slope, curvature = self._parabola(body, middle, width, limb)
        half = np.sqrt(np.maximum(-value / curvature, 0.0)) * width
        self._width, self._middle = width, middle
        self._is_exact = (rows.sign != 0.0) & (half >= rows.shortest)
        inside = np.clip(middle, *rows.interval.T)
        times = np.where(self._is_exact, middle + rows.sign * half, np.where(rows.sign == 0.0, inside, middle))
        for _ in range(_CONTACTS):
            rate = self.rates(body, self.indices, times, limb)
            error = limb.measure(*self.rays_in_body(body, self.indices, times))
            step = np.where(self._is_exact, error / np.where(rate == 0.0, np.inf, rate), 0.0)
            times = times - step
            if (np.abs(step) <= _CONTACT_STEP * width).all():
                break
        self._times = times
        return np.asarray(self.linearised(body))

    def _parabola(self, body: ApparentBody, middle: Floats, width: Floats, limb: Limb) -> tuple[Any, Any, Any]:
        """Return the coefficients (..., K) of the measure as a quadratic function of time, in units of widths."""
        previous, value, following = (
            limb.measure(*self.rays_in_body(body, self.indices, middle + k * width)) for k in (-1.0, 0.0, 1.0)
        )
        return value, 0.5 * (following - previous), 0.5 * (following + previous) - value

    def linearised(self, body: ApparentBody, limbs: Sequence[Limb] | None = None) -> Any:
        """Return predictions (..., K) for changes of the body, or of its limbs, to first order about the contacts."""
        rows, limb = self.rows, (self.limbs if limbs is None else limbs)[0]
        measure = limb.measure(*self.rays_in_body(body, self.indices, self._times))
        rate = self.rates(body, self.indices, self._times, self.limbs[0])
        contact = self._times - measure / np.where(self._is_exact, rate, np.inf)
        value, slope, curvature = self._parabola(body, self._middle, self._width, limb)
        vertex = -0.5 * slope / curvature
        half = continued(rows.shortest, (vertex * vertex - value / curvature) * self._width**2)
        continuation = self._middle + vertex * self._width + rows.sign * half
        depth = (1.0 - np.sqrt(measure + 1.0)) * self._width / np.sqrt(curvature)
        miss = np.where(np.real(depth) > 0.0, depth, 0.0)
        return np.where(rows.sign == 0.0, miss, np.where(self._is_exact, contact, continuation) - rows.times)
