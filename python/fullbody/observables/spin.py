"""Poles, attitudes, libration and tumbling of a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..base.kinds import whole_number
from ..base.limits import Limits
from ..base.units import UNITLESS, is_quantity
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..record.record import Record
from ..typing import Array, Floats, Scalar
from . import _signal as signal
from ._relative import NEAREST, REVOLUTIONS, RelativeMotion

_NAMES: tuple[Literal["roll", "pitch", "yaw"], ...] = ("roll", "pitch", "yaw")
#: The half turns that leave an ellipsoid unchanged.
_HALF_TURNS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64)
#: Number of samples before and after a passage that a cubic goes through.
_AROUND = 2


@dataclass(frozen=True, eq=False, repr=False)
class Libration(ArrayFields):
    """Oscillations of a body's longest axis about the line to another body.

    Attributes
    ----------
    time : ndarray or Quantity, (K,)
    angle : ndarray or Quantity, (K,)
        The angle from the line to the longest axis, in the orbit's plane, positive along the motion. It has no jumps,
        so that it grows or falls without end where the body does not librate.
    amplitude : float, Quantity or None
        Half of the peak-to-peak angle; ``None`` if it exceeds a quarter turn, where the other end of the axis is nearer
        for part of the time: the body rotates relative to the line and does not librate.
    frequencies, amplitudes : ndarray or Quantity
        Angular frequencies and amplitudes of the strongest periodic terms, the strongest first; empty without a
        libration.
    period : float, Quantity or None
        The period of the strongest term.
    """

    time: Array
    angle: Array
    amplitude: Scalar | None
    frequencies: Array
    amplitudes: Array
    period: Scalar | None

    def as_dict(self) -> dict[str, Any]:
        """Return the amplitude as ``libration``, and ``libration_period``, both ``None`` without a libration."""
        return {"libration": self.amplitude, "libration_period": self.period}


def spin_precession(run: Record, *, axis: Any = None, body: int | str = 0, about: int | str | None = None) -> Scalar:
    """Compute the mean rate at which a body's pole of rotation precesses about an axis.

    Parameters
    ----------
    run : Run
        A run of two revolutions of ``body`` about ``about``, or more.
    axis : array_like, (3,), optional
        Reference axis; by default the total angular momentum at the start.
    body, about : int or str
        By default ``about`` is the first body other than ``body``.

    Returns
    -------
    float or Quantity
        Radians per unit of time, positive about the axis.

    Raises
    ------
    InvalidInput
        For a body that does not spin, and for a pole nearer to the axis than 1e-9 radians at half of the samples or
        more, since its motion about the axis is then round-off.

    Notes
    -----
    A fast oblate body with moments C > A, spin omega and obliquity epsilon, under a body of mass m on a circular orbit
    of mean motion n about the common mass M, precesses by -3/2 n^2 (m/M) (C - A)/(C omega) cos(epsilon) about the
    orbit's normal.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 200.0, output=0.25)
    >>> bool(fullbody.observables.spin_precession(run) < 0)
    True
    """
    motion = RelativeMotion(run, body, about, 3, "spin precession", REVOLUTIONS)
    rate, angle = motion.precession(motion.pole, axis)
    if rate is None:
        raise InvalidInput(
            f"the pole of {motion.name} stays within {np.minimum(angle, np.pi - angle).max():.1g} rad of the axis, and "
            f"below {NEAREST:g} or between the samples it is not known how it goes about it; expected another axis, or "
            f"samples closer together ({motion.denser_output()})"
        )
    return motion.rate(rate)


def obliquity(run: Record, *, body: int | str = 1, about: int | str = 0) -> Array:
    """Compute the angle (K,) between a body's pole of rotation and the pole of its orbit about another.

    Parameters
    ----------
    run : Run
    body, about : int or str

    Returns
    -------
    ndarray or Quantity, (K,)
        Angles from 0 to pi.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 1.0)
    >>> round(float(np.degrees(fullbody.observables.obliquity(run, body=0, about=1)[0])), 3)
    3.2
    """
    motion = RelativeMotion(run, body, about, 1, "an obliquity")
    sine = np.linalg.norm(np.cross(motion.pole, motion.normal), axis=1)
    return motion.angle(np.arctan2(sine, np.sum(motion.pole * motion.normal, axis=1)))


def roll_pitch_yaw(run: Record, *, body: int | str = 1, about: int | str = 0) -> Array:
    """Compute the attitude of a body in its orbit's frame as roll, pitch and yaw.

    The x-axis of the orbit's frame points from the body to the other one and its z-axis along the orbit's normal; the
    body's frame follows from it by R = Rz(yaw) Ry(pitch) Rx(roll), the paper's angles. An ellipsoid looks the same
    after a half turn about its z-axis: if the body starts nearer to backwards, it is taken as turned by that half turn
    throughout.

    Parameters
    ----------
    run : Run
        Between its samples the body may turn by half a turn in that frame at most.
    body, about : int or str

    Returns
    -------
    ndarray or Quantity, (K, 3)
        Roll, pitch and yaw; roll and yaw have no jumps.

    Raises
    ------
    InvalidInput
        For samples between which the body may turn by more than half a turn in that frame, so that the direction of the
        turn is ambiguous.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 1.0)
    >>> bool(abs(fullbody.observables.roll_pitch_yaw(run)[0]).max() < 1e-12)
    True
    """
    motion = RelativeMotion(run, body, about, 1, "roll, pitch and yaw")
    relative = in_orbit_frame(motion)
    if relative[0, 0, 0] < 0.0:
        relative = relative * np.array([-1.0, -1.0, 1.0])
    return motion.angle(angles(relative))


def libration(run: Record, *, body: int | str = 1, about: int | str = 0, n: int = 3) -> Libration:
    """Compute the libration of a body's longest axis, its amplitude and its strongest periodic terms.

    Parameters
    ----------
    run : Run
        A run of two revolutions or more, and several periods of the libration, sampled several times in each: the axis
        may turn by a quarter turn at most between two samples.
    body, about : int or str
    n : int
        The largest number of periodic terms.

    Raises
    ------
    InvalidInput
        For a body without a single longest axis, and for one whose longest axis is along the orbit's normal.

    Notes
    -----
    Small free librations in longitude of a nearly synchronous body of mass m and principal moments A < B < C, on a
    circular orbit of mean motion n about a distant sphere of mass M, have the frequency
    ``w = n * sqrt(3 * (B - A) / C * M / (M + m))``: the torque is 3 G M/r^3 (B - A) times the angle, and
    G (M + m)/r^3 is n^2. The last factor is one for a small moon, and 1/2 under the root for equal masses. An
    eccentricity e forces a libration at n: against uniform rotation by 2 e w^2/(w^2 - n^2), and against the line to the
    other body, as here, by 2 e n^2/(w^2 - n^2) (Murray & Dermott 1999, Sec. 5.4 and 5.5, where m is small).

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 200.0, output=0.25)
    >>> swings = fullbody.observables.libration(run)
    >>> swings.angle.shape
    (801,)
    """
    whole_number(n, "n")
    motion = RelativeMotion(run, body, about, 16, "a libration", REVOLUTIONS)
    axes = run.context.bodies[motion.body].semi_axes
    if not any(axes):
        raise InvalidInput(f"{motion.name} is a point; it has no axis to librate")
    longest = int(np.argmax(axes))
    if sorted(axes)[1] == axes[longest]:
        raise InvalidInput(f"{motion.name} has the semi-axes {list(axes)}, no single longest one to librate")
    x, y, _ = np.moveaxis(orbit_frame(motion), 2, 0)
    axis = motion.matrix[:, :, longest]
    sine = np.linalg.norm(np.cross(axis, motion.normal), axis=1)
    if np.median(sine) < NEAREST:
        raise InvalidInput(
            f"the longest axis of {motion.name} stays within {sine.max():.1g} rad of the orbit's normal; it has no "
            "direction in the orbit's plane"
        )
    # Both ends of the axis are equivalent.
    motion.check_rotation(np.linalg.norm(np.cross(motion.relative_spin, axis), axis=1), np.pi / 2)
    angle = np.unwrap(np.arctan2(np.sum(axis * y, axis=1), np.sum(axis * x, axis=1)), period=np.pi)
    angle = angle - np.pi * np.round(angle[0] / np.pi)
    fine = _between(motion, angle)
    swing = float(np.ptp(fine) / 2)
    librates = swing <= np.pi / 2
    frequencies, amplitudes = signal.periodic_terms(motion.path.time, fine, n) if librates else np.zeros((2, 0))
    return Libration(
        motion.span(motion.time),
        motion.angle(angle),
        motion.angle(swing if librates else None),
        motion.rate(frequencies),
        motion.angle(amplitudes),
        motion.span(2 * np.pi / frequencies[0] if len(frequencies) else None),
    )


def _between(motion: RelativeMotion, angle: Floats) -> Floats:
    """Return the angle of a direction from the line to the other body, along the path."""
    if motion.path.time is motion.time:
        return angle
    spline = signal.scipy_module("interpolate").CubicSpline
    order = np.argsort(motion.time)
    together = angle + motion.longitude_at(motion.time)[0]
    return spline(motion.time[order], together[order])(motion.path.time) - motion.longitude[0]


def in_orbit_frame(motion: RelativeMotion) -> Floats:
    """Return the body's attitude (K, 3, 3) in its orbit's frame, after checking that samples are close enough."""
    motion.check_rotation(np.linalg.norm(motion.relative_spin, axis=1), np.pi)
    return np.einsum("kji,kjl->kil", orbit_frame(motion), motion.matrix)


def angles(relative: Floats) -> Floats:
    """Return roll, pitch and yaw (K, 3) of attitudes, with roll and yaw free of jumps."""
    roll = np.arctan2(relative[:, 2, 1], relative[:, 2, 2])
    pitch = np.arcsin(np.clip(-relative[:, 2, 0], -1.0, 1.0))
    yaw = np.arctan2(relative[:, 1, 0], relative[:, 0, 0])
    return np.stack([np.unwrap(roll), pitch, np.unwrap(yaw)], axis=1)


def orbit_frame(motion: RelativeMotion) -> Floats:
    """Return axes (K, 3, 3) as columns: towards the other body, along its apparent motion, and along the normal."""
    x = -motion.r / np.linalg.norm(motion.r, axis=1)[:, None]
    return np.stack([x, np.cross(motion.normal, x), motion.normal], axis=2)


@dataclass(frozen=True, eq=False, repr=False)
class Tumbling(ArrayFields):
    """The time at which a body first rotated further than a limit from its equilibrium attitude.

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

    Raises
    ------
    InvalidInput
        For a limit that is not an angle in that range, and for samples between which the body may turn by more than
        half a turn in its orbit's frame.

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
    angle_limit = UNITLESS.number(limit, "angle", "limit", quarter)
    motion = RelativeMotion(run, body, about, 1, "tumbling")
    relative = in_orbit_frame(motion)
    nearest = int(np.argmax(_HALF_TURNS @ np.diagonal(relative[0])))
    rotation_angles = angles(relative * _HALF_TURNS[nearest])
    size = np.abs(rotation_angles)
    largest = motion.angle(size.max(axis=0))
    # The run may go backwards in time: the first passage is the first one recorded.
    beyond = (size > angle_limit).any(axis=1)
    if not beyond.any():
        return Tumbling(None, None, largest)
    k = int(np.argmax(beyond))
    columns = [(j, name) for j, name in enumerate(_NAMES) if size[k, j] > angle_limit]
    passages = [(_passage(motion.time, size[:, j], k, angle_limit), name) for j, name in columns]
    forward = -1.0 if motion.time[-1] < motion.time[0] else 1.0
    time, name = min(passages, key=lambda passage: forward * passage[0])
    return Tumbling(motion.span(time), name, largest)


def _passage(time: Floats, size: Floats, k: int, limit: float) -> float:
    """Return the time at which an angle passes a limit between the samples k - 1 and k."""
    if k == 0:
        return float(time[0])
    samples = slice(max(k - _AROUND, 0), k + _AROUND)
    cubic = signal.scipy_module("interpolate").BarycentricInterpolator(time[samples], size[samples] - limit)
    return float(signal.scipy_module("optimize").brentq(cubic, time[k - 1], time[k]))
