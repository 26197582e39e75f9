"""Predicted times of contacts of a star with the limb of a body, from the states at the times that were observed.

Each row is a contact, a disappearance or a reappearance, or a miss. As a line of sight passes a body, the measure f of
the body's limb is nearly a quadratic function of time, nu^2 ((t - m)^2 - h^2), with the middle m of the
chord and the square h^2 of half its duration, which is negative where the body misses the station. A contact is at
m - h or m + h, located to the last digits. Below a bound h0, which depends on the data alone, h is continued linearly
in h^2 as (h0 + h^2 / h0) / 2, so that predictions are smooth functions of all parameters also for a body that misses.

A miss has the time that the line of sight, within the watched interval, takes to leave the body by the shortest way at
the speed at which it passes: zero where the body does not hide the star.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..typing import Floats
from .limbs import Limb, cross
from .states import RetardedStates, rotated

#: The iterations of a light time, of the middle of a chord, and of a contact; each gains several digits.
_LIGHT, _MIDDLE, _CONTACT = 4, 10, 6
#: The largest change of the middle of a chord in an iteration, in units of the time of a passage.
_FAR = 1e3
#: The changes of the middle and of a contact in these units at which the iterations end.
_NEAR, _CLOSE = 1e-6, 1e-8
#: The step along the imaginary axis of the derivative with respect to time.
_STEP = 1e-100

Indices = npt.NDArray[np.intp]


class Rows(NamedTuple):
    """K rows of observed contacts and misses, on a system's clock and in its units.

    Attributes
    ----------
    times : ndarray, (K,)
        Times of the contacts, and the middles of the intervals of misses.
    sign : ndarray, (K,)
        -1 for a disappearance, 1 for a reappearance, 0 for a miss.
    interval : ndarray, (K, 2)
        The ends of the chord of each row, infinite where they are not known, or of the interval of a miss.
    least : ndarray, (K,)
        The halves of durations below which they are continued linearly in their squares.
    """

    times: Floats
    sign: Floats
    interval: Floats
    least: Floats


class Path(NamedTuple):
    """Places and velocities (M, 3) of stations, and unit vectors (M, 3) to the star, at M times."""

    position: Floats
    velocity: Floats
    star: Floats


#: A function from indices of rows (M,) and times (M,) to the path.
Paths = Callable[[Indices, Floats], Path]


class Body(NamedTuple):
    """A body as the observer of the geometry sees it at the K times of the rows; arrays may be complex.

    Attributes
    ----------
    centre, velocity, spin : ndarray, (..., K, 3)
    attitude : ndarray, (..., K, 4)
    distance : ndarray, (..., K, 1)
        The distance from the observer.
    shift : ndarray, (..., K, 3)
        The displacement of the body by the offset of the event.
    light_speed : float
    """

    centre: Any
    velocity: Any
    spin: Any
    attitude: Any
    distance: Any
    shift: Any
    light_speed: float

    @property
    def real(self) -> Body:
        """The real parts, which are equal along all axes in front of that of the rows."""
        return self._changed(lambda part: np.real(part)[(0,) * (part.ndim - 2)])

    def of(self, index: Indices) -> Body:
        """Return the body at M of the rows."""
        return self._changed(lambda part: part[..., index, :])

    def _changed(self, change: Callable[[Any], Any]) -> Body:
        return self._replace(**{name: change(getattr(self, name)) for name in self._fields if name != "light_speed"})


def body_of(retarded: RetardedStates, states: dict[str, Any], index: int, shift: Any) -> Body:
    """Return one of the bodies of retarded states, with the displacement (..., K, 3) of all bodies."""
    attitude = retarded.attitude(states["attitude"], states["spin"])
    way = retarded.observer - retarded.centre[..., index, :]
    centre, velocity, spin, turned = (
        array[..., index, :] for array in (retarded.centre, retarded.velocity, states["spin"], attitude)
    )
    distance = np.sqrt(np.sum(way * way, axis=-1, keepdims=True))
    return Body(centre, velocity, spin, turned, distance, shift, retarded.light_speed)


def into_body(attitude: Any, vectors: Any) -> Any:
    """Return vectors (..., 3) in the frames of bodies with attitudes (..., 4); both may be complex."""
    scalar, vector = attitude[..., :1], attitude[..., 1:]
    turned = cross(vector, vectors)
    return vectors - 2.0 * scalar * turned + 2.0 * cross(vector, turned)


class Passage:
    """The passage of the lines of sight of K rows past one body with limbs.

    Parameters
    ----------
    rows : Rows
    path : callable
        The function from rows and times to a :class:`Path`.
    limbs : list of Limb
    """

    def __init__(self, rows: Rows, path: Paths, limbs: Sequence[Limb]) -> None:
        self.rows, self._path, self.limbs = rows, path, limbs
        self.every = np.arange(len(rows.times))
        self.reach = max(limb.reach for limb in limbs)

    def sight(self, body: Body, index: Indices, times: Floats, step: complex = 0.0) -> tuple[Any, Any]:
        """Return places and directions (..., M, 3) of rays in the body's frame, at times (M,) plus a step, of rows."""
        w, u, attitude = self.lines(body, index, times, step)
        return into_body(attitude, w), into_body(attitude, u)

    def lines(self, body: Body, index: Indices, times: Floats, step: complex = 0.0) -> tuple[Any, Any, Any]:
        """Return places and directions (..., M, 3) of rays from the body's centre, and the body's attitudes."""
        path, seen = self._path(index, times), body.of(index)
        position = path.position + path.velocity * step
        since = (times - self.rows.times[index] + step)[..., None]
        late = since
        for _ in range(_LIGHT if np.isfinite(body.light_speed) else 0):
            way = position - seen.centre - seen.velocity * late
            far = np.sqrt(np.sum(way * way, axis=-1, keepdims=True))
            late = since - (far - seen.distance) / body.light_speed
        way = position - seen.centre - seen.velocity * late - seen.shift
        depth = np.sum(way * path.star, axis=-1, keepdims=True)
        return way - depth * path.star, path.star, rotated(seen.attitude, seen.spin, late[..., 0])

    def rates(self, body: Body, index: Indices, times: Floats, limb: Limb) -> Floats:
        """Return the derivatives (M,) of the measure of a limb with respect to time."""
        return np.asarray(limb.measure(*self.sight(body.real, index, times, 1j * _STEP)).imag / _STEP)

    def solve(self, body: Body) -> Floats:
        """Find the contacts, and return predictions (K,) relative to the times of the rows."""
        raise NotImplementedError

    def linearised(self, body: Body, limbs: Sequence[Limb] | None = None) -> Any:
        """Return predictions (..., K) for changes of the body, or of its limbs, to first order about the contacts."""
        raise NotImplementedError

    def speed(self, body: Body) -> Floats:
        """Return the speeds (K,) of the lines of sight past the body."""
        path = self._path(self.every, self.rows.times)
        way = path.velocity - body.velocity.real
        speed = np.linalg.norm(way - np.sum(way * path.star, axis=-1)[:, None] * path.star, axis=-1)
        if not (speed > 0.0).all():
            raise InvalidInput(
                "the lines of sight of the stations do not move past the bodies; expected vectors to the observer that "
                "change with time"
            )
        return np.asarray(speed)


def continued(least: Floats, square: Any) -> Any:
    """Return half the durations of chords, continued linearly in their squares."""
    return 0.5 * (least + square / least)


class EllipsoidContacts(Passage):
    """The contacts of K rows with an ellipsoid, all at once."""

    def __init__(self, rows: Rows, path: Paths, limbs: Sequence[Limb]) -> None:
        super().__init__(rows, path, limbs)
        self._middle = self._times = self._width = rows.times
        self._exact = rows.sign != 0.0

    def solve(self, body: Body) -> Floats:
        """Find the contacts, and return predictions (K,) relative to the times of the rows."""
        rows, limb = self.rows, self.limbs[0]
        width, middle = self.reach / self.speed(body), rows.times
        for _ in range(_MIDDLE):
            _, slope, bend = self._parabola(body, middle, width, limb)
            step = width * np.clip(0.5 * slope / bend, -_FAR, _FAR)
            middle = middle - step
            if (np.abs(step) <= _NEAR * width).all():
                break
        value, slope, bend = self._parabola(body, middle, width, limb)
        half = np.sqrt(np.maximum(-value / bend, 0.0)) * width
        self._width, self._middle = width, middle
        self._exact = (rows.sign != 0.0) & (half >= rows.least)
        inside = np.clip(middle, *rows.interval.T)
        times = np.where(self._exact, middle + rows.sign * half, np.where(rows.sign == 0.0, inside, middle))
        for _ in range(_CONTACT):
            rate = self.rates(body, self.every, times, limb)
            error = limb.measure(*self.sight(body, self.every, times))
            step = np.where(self._exact, error / np.where(rate == 0.0, np.inf, rate), 0.0)
            times = times - step
            if (np.abs(step) <= _CLOSE * width).all():
                break
        self._times = times
        return np.asarray(self.linearised(body))

    def _parabola(self, body: Body, middle: Floats, width: Floats, limb: Limb) -> tuple[Any, Any, Any]:
        """Return the coefficients (..., K) of the measure as a quadratic function of time, in units of widths."""
        earlier, value, after = (
            limb.measure(*self.sight(body, self.every, middle + k * width)) for k in (-1.0, 0.0, 1.0)
        )
        return value, 0.5 * (after - earlier), 0.5 * (after + earlier) - value

    def linearised(self, body: Body, limbs: Sequence[Limb] | None = None) -> Any:
        """Return predictions (..., K) for changes of the body, or of its limbs, to first order about what was found."""
        rows, limb = self.rows, (self.limbs if limbs is None else limbs)[0]
        measured = limb.measure(*self.sight(body, self.every, self._times))
        rate = self.rates(body, self.every, self._times, self.limbs[0])
        contact = self._times - measured / np.where(self._exact, rate, np.inf)
        value, slope, bend = self._parabola(body, self._middle, self._width, limb)
        later = -0.5 * slope / bend
        half = continued(rows.least, (later * later - value / bend) * self._width**2)
        short = self._middle + later * self._width + rows.sign * half
        depth = (1.0 - np.sqrt(measured + 1.0)) * self._width / np.sqrt(bend)
        missed = np.where(np.real(depth) > 0.0, depth, 0.0)
        return np.where(rows.sign == 0.0, missed, np.where(self._exact, contact, short) - rows.times)
