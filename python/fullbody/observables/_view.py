"""One body of a run as seen from another."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _rotation
from .._arguments import directions
from ..errors import InvalidInput
from . import _signal as signal

if TYPE_CHECKING:
    from ..run import Run

_Array = npt.NDArray[np.float64]
#: Fewer revolutions than these have no mean to speak of; from :data:`WINDOWED` on, a window tells it from what recurs.
REVOLUTIONS, WINDOWED = 2, 5
#: Radians. A pole nearer to an axis is there but for round-off, which alone would say how it goes about it.
NEAREST = 1e-9


class View:
    """Plain numbers of a run, and its units for what comes out.

    Parameters
    ----------
    about : int, str or None
        ``None`` for the first other body.
    least : int
        How many samples it takes to say something.
    revolutions : int
        How many of those it takes.
    """

    def __init__(
        self, run: Run, body: int | str, about: int | str | None, least: int, what: str, revolutions: int = 0
    ) -> None:
        from ..run import Run

        if not isinstance(run, Run):
            raise InvalidInput(f"the run of {what} is a {type(run).__name__}; expected a fullbody.Run")
        body = run.system._place(body, f"body of {what}")
        about = int(body == 0) if about is None else about
        about = run.system._place(about, f"about of {what}")
        if body == about:
            raise InvalidInput(f"{what} is asked of body {body} about itself; expected two bodies")
        self.body, self.name = body, f"body {body} ({run.system.names[body]})"
        self.units = run.system._units
        self.time = run._record["time"]
        signal.check_times(self.time, least, what)
        record = run._record
        self.r = record["position"][:, body] - record["position"][:, about]
        self.v = record["velocity"][:, body] - record["velocity"][:, about]
        normal = np.cross(self.r, self.v)
        size = np.linalg.norm(normal, axis=1)
        radial = size <= 1e-14 * np.linalg.norm(self.r, axis=1) * np.linalg.norm(self.v, axis=1)
        if radial.any():
            raise InvalidInput(
                f"at time {self.units.attach(self.time[radial][0], 'time')} {self.name} moves along its line to "
                f"{run.system.names[about]}, or not at all; {what} needs the plane of an orbit"
            )
        self.normal = normal / size[:, None]
        self.matrix = _rotation.matrices(record["attitude"][:, body])
        self.spin = record["spin"][:, body]
        self._start = record["angular_momentum"][0]
        if revolutions > 0:
            self._check_revolutions(what, revolutions)

    @property
    def turns(self) -> float:
        """How many revolutions the run covers."""
        angle = self.longitude[0]
        return float(abs(angle[-1] - angle[0]) / (2 * np.pi))

    def _check_revolutions(self, what: str, least: int) -> None:
        angle, rate = self.longitude
        # What the rates at both ends make of it: half a turn aside, and the angle has been unwrapped wrongly.
        by_rate = (rate[1:] + rate[:-1]) / 2 * np.diff(self.time)
        lost = np.round((by_rate - np.diff(angle)) / (2 * np.pi))
        if lost.any():
            first = int(np.argmax(lost != 0))
            own = np.linalg.norm(np.cross(self.r, self.v), axis=1) / np.sum(self.r**2, axis=1)
            if (own[first] + own[first + 1]) / 2 * abs(self.time[first + 1] - self.time[first]) < np.pi:
                raise InvalidInput(
                    f"the plane of the orbit turns so far from its mean in the run that {what} has no longitude to "
                    "count by; expected a shorter run"
                )
            turns = abs(np.diff(angle)[first] / (2 * np.pi) + lost[first])
            ends = [self.units.attach(self.time[k], "time") for k in (first, first + 1)]
            raise InvalidInput(
                f"between its samples at {ends[0]} and {ends[1]} the run makes about {turns:.2g} "
                f"revolutions; {what} needs several samples in each (output= a "
                "tenth of the period or less, and less in an eccentric orbit)"
            )
        if self.turns < least:
            raise InvalidInput(f"the run covers {self.turns:.3g} revolutions; {what} needs {least} or more")

    def check_rotation(self, speed: _Array, most: float, what: str) -> None:
        """Refuse samples between which a direction or a frame may turn by more than an angle, at its speeds (K,)."""
        turned = (speed[1:] + speed[:-1]) / 2 * np.abs(np.diff(self.time))
        if len(turned) and turned.max() > most:
            k = int(turned.argmax())
            raise InvalidInput(
                f"{self.name} turns by about {turned[k]:.3g} rad in the orbit's frame between the samples at "
                f"{self.units.attach(self.time[k], 'time')} and {self.units.attach(self.time[k + 1], 'time')}; {what} "
                f"needs less than {most:.3g} (a smaller output=)"
            )

    @property
    def relative_spin(self) -> _Array:
        """The body's angular velocity (K, 3) less that of the line to the other body, inertial."""
        turn = np.linalg.norm(np.cross(self.r, self.v), axis=1) / np.sum(self.r**2, axis=1)
        spin: _Array = np.einsum("kij,kj->ki", self.matrix, self.spin) - turn[:, None] * self.normal
        return spin

    def rate(self, value: Any) -> Any:
        return self.units.attach(value, "spin")

    def angle(self, value: Any) -> Any:
        return self.units.attach(value, "angle")

    def span(self, value: Any) -> Any:
        return self.units.attach(value, "time")

    @property
    def pole(self) -> _Array:
        """The direction of the spin (K, 3), inertial."""
        size = np.linalg.norm(self.spin, axis=1)
        if not np.all(size > 0.0):
            raise InvalidInput("the body does not spin; its pole is nowhere")
        direction: _Array = np.einsum("kij,kj->ki", self.matrix, self.spin / size[:, None])
        return direction

    def mean_rate(self, values: _Array) -> float:
        """The slope of what changes with every revolution."""
        return signal.slope(self.time, values, power=3 if self.turns >= WINDOWED else 1)

    @cached_property
    def longitude(self) -> tuple[_Array, _Array]:
        """The longitude in the mean orbital plane without jumps, and its rate."""
        x, y = across(mean(self.normal))
        a, b, da, db = self.r @ x, self.r @ y, self.v @ x, self.v @ y
        return signal.unwrapped(np.arctan2(b, a)), (a * db - b * da) / (a * a + b * b)

    def turning(self, poles: _Array, axis: Any) -> tuple[float | None, _Array]:
        """The mean rate at which directions go about an axis, and their angles from it.

        The axis is the angular momentum at the start unless given; there is no rate of directions that are mostly
        nearer to it than :data:`NEAREST`.
        """
        axis = self._start if axis is None else directions(axis, "axis", one=True)
        about = azimuth(poles, axis)
        angle: _Array = np.arctan2(np.linalg.norm(np.cross(poles, axis), axis=1), poles @ axis)
        # One that goes the other way round, nearly against the axis, is as near to it.
        if np.median(np.minimum(angle, np.pi - angle)) < NEAREST:
            return None, angle
        return signal.slope(self.time, about), angle


def mean(normals: _Array) -> _Array:
    total: _Array = normals.sum(axis=0)
    size = float(np.linalg.norm(total))
    if size <= 1e-6 * len(normals):
        raise InvalidInput("the orbit's pole goes all ways; it has no mean plane")
    return total / size


def across(axis: _Array) -> tuple[_Array, _Array]:
    """Two directions at right angles to an axis and to each other, the first in the xy-plane where it can be."""
    start = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    x = np.cross(start, axis)
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def azimuth(poles: _Array, axis: _Array) -> _Array:
    """The angle of directions about an axis, without jumps."""
    size = np.linalg.norm(axis)
    if size == 0.0:
        raise InvalidInput("the angular momentum is zero; expected an axis=")
    x, y = across(axis / size)
    return signal.unwrapped(np.arctan2(poles @ y, poles @ x))
