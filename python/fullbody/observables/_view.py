"""One body of a run as seen from another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _rotation
from ..errors import InvalidInput
from . import _signal as signal

if TYPE_CHECKING:
    from ..run import Run

_Array = npt.NDArray[np.float64]


class View:
    """Plain numbers of a run, and its units for what comes out."""

    def __init__(self, run: Run, body: int, about: int, least: int, what: str) -> None:
        count = len(run.system.bodies)
        for index in (body, about):
            if not 0 <= index < count:
                raise InvalidInput(f"body {index} of {what} is none of the {count} of the system")
        if body == about:
            raise InvalidInput(f"{what} is asked of body {body} about itself; expected two bodies")
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

    def longitude(self) -> tuple[_Array, _Array]:
        """The longitude in the mean orbital plane without jumps, and its rate."""
        x, y = across(mean(self.normal))
        a, b, da, db = self.r @ x, self.r @ y, self.v @ x, self.v @ y
        return signal.unwrapped(np.arctan2(b, a)), (a * db - b * da) / (a * a + b * b)


def mean(directions: _Array) -> _Array:
    total: _Array = directions.sum(axis=0)
    size = float(np.linalg.norm(total))
    if size <= 1e-6 * len(directions):
        raise InvalidInput("the orbit's pole goes all ways; it has no mean plane")
    return total / size


def across(axis: _Array) -> tuple[_Array, _Array]:
    """Two directions at right angles to an axis and to each other, the first in the xy-plane where it can be."""
    start = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    x = np.cross(start, axis)
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def azimuth(directions: _Array, axis: Any) -> _Array:
    """The angle of directions about an axis, without jumps."""
    axis = np.asarray(axis, dtype=np.float64)
    size = np.linalg.norm(axis)
    if axis.shape != (3,) or not np.isfinite(size) or size == 0.0:
        raise InvalidInput(f"axis is {axis!r}; expected three finite numbers, not all zero")
    x, y = across(axis / size)
    return signal.unwrapped(np.arctan2(directions @ y, directions @ x))
