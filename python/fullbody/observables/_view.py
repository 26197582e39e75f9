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
#: Fewer revolutions than these have no mean to speak of.
REVOLUTIONS = 2
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
    whole : bool
        Whether it takes revolutions too, at least :data:`REVOLUTIONS`.
    """

    def __init__(
        self, run: Run, body: int | str, about: int | str | None, least: int, what: str, whole: bool = False
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
        self.normal = normal / np.linalg.norm(normal, axis=1)[:, None]
        self.matrix = _rotation.matrices(record["attitude"][:, body])
        self.spin = record["spin"][:, body]
        self._start = record["angular_momentum"][0]
        if whole:
            self._check_revolutions(what)

    def _check_revolutions(self, what: str) -> None:
        angle, rate = self.longitude
        turns = abs(angle[-1] - angle[0]) / (2 * np.pi)
        by_rate = abs(np.sum((rate[1:] + rate[:-1]) / 2 * np.diff(self.time))) / (2 * np.pi)
        if abs(turns - by_rate) > max(0.5, 0.1 * by_rate):
            raise InvalidInput(
                f"the run has {len(angle)} samples in about {by_rate:.3g} revolutions; {what} needs several in each "
                "(output= a tenth of the period or less)"
            )
        if turns < REVOLUTIONS:
            raise InvalidInput(f"the run covers {turns:.3g} revolutions; {what} needs {REVOLUTIONS} or more")

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
