"""The onset of tumbling of a body that kept one face to another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..base.limits import Limits
from ..base.units import UNITLESS, is_quantity
from ..base.values import ArrayFields
from ..record.record import Record
from ..typing import Floats
from . import _signal as signal
from ._relative import RelativeMotion
from .spin import angles, in_orbit_frame

_NAMES: tuple[Literal["roll", "pitch", "yaw"], ...] = ("roll", "pitch", "yaw")
#: The half turns that leave an ellipsoid unchanged.
_HALF_TURNS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64)
#: Number of samples before and after a passage that a cubic goes through.
_AROUND = 2


@dataclass(frozen=True, eq=False, repr=False)
class Tumbling(ArrayFields):
    """The time at which a body first turned further than a limit from its equilibrium attitude.

    Attributes
    ----------
    time : float, Quantity or None
        The time of the first passage; ``None`` if the run has none.
    angle : {"roll", "pitch", "yaw"} or None
        The angle that passed the limit.
    largest : ndarray or Quantity, (3,)
        The largest absolute roll, pitch and yaw of the run's samples, radians; above half a turn the body has gone
        round.
    """

    time: Any
    angle: Literal["roll", "pitch", "yaw"] | None
    largest: Any

    def as_dict(self) -> dict[str, Any]:
        """Return ``largest_roll``, ``largest_pitch`` and ``largest_yaw``, which are half a turn if the body has gone
        round; ``tumbles``, 1 if the limit was passed, else 0; and ``tumbling_time``, or ``None``.
        """
        half_turn = np.pi * (self.largest.unit if is_quantity(self.largest) else 1.0)
        largest = zip(_NAMES, np.minimum(self.largest, half_turn), strict=True)
        sizes = {f"largest_{name}": size for name, size in largest}
        return {**sizes, "tumbles": float(self.time is not None), "tumbling_time": self.time}


def tumbles(run: Record, *, limit: Any = np.pi / 2, body: int | str = 1, about: int | str = 0) -> Tumbling:
    """Determine whether and when a body's roll, pitch or yaw passes a limit.

    The angles are those of :func:`roll_pitch_yaw`, but relative to the nearest of the attitudes in which an ellipsoid
    looks the same, so that a body that starts upside down or backwards starts near zero. From there they are followed
    without jumps, so that a roll of 370 degrees is not taken for one of 10.

    Parameters
    ----------
    run : Run
        Between its samples the body may turn by half a turn in its orbit's frame at most.
    limit : float or Quantity
        At most a quarter turn, which is the largest pitch possible.
    body, about : int or str

    Notes
    -----
    Between two samples the time is found on a cubic through those around it. A swing beyond the limit and back that
    falls between samples is not detected.

    Examples
    --------
    With its pole a little aside of the orbit's normal Dimorphos rolls, but does not tumble.

    >>> import fullbody, numpy as np
    >>> system, state = fullbody.systems.didymos_after_dart(tilt=1e-3)
    >>> run = system.integrate(state, 300.0, output=1.0)
    >>> found = fullbody.observables.tumbles(run, limit=np.radians(30))
    >>> found.angle, round(float(found.time))
    ('roll', 255)
    >>> fullbody.observables.tumbles(run).time is None
    True
    """
    quarter = Limits(above=0.0, most=np.pi / 2, text="an angle above zero, a quarter turn (pi/2) at most")
    most = UNITLESS.number(limit, "angle", "limit", quarter)
    motion = RelativeMotion(run, body, about, 1, "tumbling")
    relative = in_orbit_frame(motion)
    nearest = int(np.argmax(_HALF_TURNS @ np.diagonal(relative[0])))
    rotation_angles = angles(relative * _HALF_TURNS[nearest])
    size = np.abs(rotation_angles)
    largest = motion.angle(size.max(axis=0))
    # The run may go backwards in time: the first passage is the first one recorded.
    beyond = (size > most).any(axis=1)
    if not beyond.any():
        return Tumbling(None, None, largest)
    k = int(np.argmax(beyond))
    passages = [
        (_passage(motion.time, size[:, j], k, most), name) for j, name in enumerate(_NAMES) if size[k, j] > most
    ]
    forward = -1.0 if len(motion.time) > 1 and motion.time[1] < motion.time[0] else 1.0
    time, name = min(passages, key=lambda passage: forward * passage[0])
    return Tumbling(motion.span(time), name, largest)


def _passage(time: Floats, size: Floats, k: int, limit: float) -> float:
    """Return the time at which an angle passes a limit between the samples k - 1 and k."""
    if k == 0:
        return float(time[0])
    near = slice(max(k - _AROUND, 0), k + _AROUND)
    cubic = signal.scipy_module("interpolate").BarycentricInterpolator(time[near], size[near] - limit)
    return float(signal.scipy_module("optimize").brentq(cubic, time[k - 1], time[k]))
