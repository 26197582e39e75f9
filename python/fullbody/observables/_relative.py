"""The motion of one body of a run relative to another."""

from __future__ import annotations

from functools import cached_property, partialmethod
from typing import Any, NoReturn

import numpy as np

from ..base import rotations
from ..base.arguments import directions
from ..errors import InvalidInput
from ..record.record import Record
from ..typing import Floats
from . import _follow as follow
from . import _signal as signal

#: The least number of revolutions for a mean; from :data:`WINDOWED` on, a window separates it from periodic terms.
REVOLUTIONS, WINDOWED = 2, 5
#: The angle in radians between a pole and an axis below which the motion of the pole about the axis is round-off.
NEAREST = 1e-9
#: Limits: the part of a period between two samples, the relative error of a sample's Kepler orbit at the next sample,
#: the angle between directions without an orbit, and the number of points to which a run is interpolated.
_LARGEST_GAP, _LARGEST_ERROR, _LARGEST_TURN, _MAX_POINTS = 0.5, 0.1, 1.0, 2_000_000


def check_run(run: object, observable: str) -> None:
    """Raise an error if an object is not a run, such as an exception in its place."""
    if not isinstance(run, Record):
        raise InvalidInput(f"the run of {observable} is a {type(run).__name__}; expected a fullbody.Run")


class RelativeMotion:
    """The numbers of a run that observables need, and the units of their results.

    The orbited body ``about`` may be ``None``, for the first other body; ``samples`` and ``revolutions`` are the least
    numbers that the observable needs.
    """

    def __init__(
        self, run: Record, body: int | str, about: int | str | None, samples: int, observable: str, revolutions: int = 0
    ) -> None:
        check_run(run, observable)
        if about is None:
            about = int(run.context.index(body, f"body of {observable}") == 0)
        self.body, self.about = body, about = run.context.pair(body, about, f" of {observable}")
        self.observable = observable
        self.name = f"body {body} ({run.context.names[body]})"
        self.units = run.context.units
        record = run.arrays
        self.time = record["time"]
        if len(self.time) < samples:
            raise InvalidInput(f"the run has {len(self.time)} samples; {observable} needs {samples} or more")
        steps = np.diff(self.time)
        if not ((steps > 0).all() or (steps < 0).all()):
            raise InvalidInput(f"the times of the run neither increase nor decrease; {observable} needs that")
        self.r, self.v = (record[name][:, body] - record[name][:, about] for name in ("position", "velocity"))
        self._samples = follow.Path(self.time, self.r, self.v)
        normal = np.cross(self.r, self.v)
        size = np.linalg.norm(normal, axis=1)
        radial = size <= 1e-14 * np.linalg.norm(self.r, axis=1) * np.linalg.norm(self.v, axis=1)
        if radial.any():
            raise InvalidInput(
                f"at time {self.units.attach(self.time[radial][0], 'time')} {self.name} moves along its line to "
                f"{run.context.names[about]}, or not at all; {observable} needs the plane of an orbit"
            )
        self.normal = normal / size[:, None]
        self.matrix = rotations.matrices(record["attitude"][:, body])
        self.spin = record["spin"][:, body]
        self._start = record["angular_momentum"][0]
        if revolutions > 0:
            self._check_revolutions(revolutions)

    @cached_property
    def path(self) -> follow.Path:
        """The motion at even times that resolve its harmonics; samples that do so are taken as they are."""
        samples = self._samples
        if not self._orbits:
            self._check_directions()
            return samples
        revolutions = float(np.sum(self._revolutions_between))
        needed = follow.harmonics(samples, self._mu) * revolutions
        regular = signal.is_regular(self.time)
        if regular and len(self.time) > needed:
            return samples
        # Irregular samples may be dense to resolve something fast, so at least as many points are taken.
        count = int(max(needed, 0 if regular else 2 * len(self.time))) + 2
        if count > _MAX_POINTS:
            raise InvalidInput(
                f"the orbit is so eccentric that {count:.2g} points hold its {revolutions:.3g} revolutions; "
                f"{self.observable} takes {_MAX_POINTS:.0e} at most; expected a shorter run"
            )
        path, error = follow.interpolated(samples, self._mu, np.linspace(self.time[0], self.time[-1], count))
        self._check_gaps(error, _LARGEST_ERROR, "the orbit changes", "of the distance")
        return path

    def _check_directions(self) -> None:
        """Raise an error if samples are far apart and no orbit describes the motion between them."""
        rate = direction_rate(self._samples)
        cosine = np.sum(self.r[1:] * self.r[:-1], axis=1)
        sine = np.linalg.norm(np.cross(self.r[1:], self.r[:-1]), axis=1)
        fastest = np.maximum(rate[1:], rate[:-1]) * np.abs(np.diff(self.time))
        angle, reason = np.maximum(np.arctan2(sine, cosine), fastest), ", and its motion is not near to a Kepler orbit"
        self._check_gaps(angle, _LARGEST_TURN, f"the direction of {self.name} turns", "rad", reason)

    def _check_gaps(self, sizes: Floats, limit: float, change: str, unit: str, reason: str = "") -> None:
        """Raise an error for the two samples between which a change is largest, if it is above a limit."""
        if len(sizes) and sizes.max() > limit:
            k = int(sizes.argmax())
            raise InvalidInput(
                f"{change} by about {sizes[k]:.3g} {unit} {self._gap(k)}{reason}; {self.observable} needs less than "
                f"{limit:.3g} ({self.denser_output(2 * sizes[k] / limit)})"
            )

    def at(self, moments: Floats) -> follow.Path:
        """Return the motion at given times of the run."""
        return follow.interpolated(self._samples, self._mu, moments)[0]

    def every_second(self) -> follow.Path:
        """Return the path interpolated from every second sample."""
        indices = np.union1d(np.arange(0, len(self.time), 2), len(self.time) - 1)
        samples = follow.Path(*(values[indices] for values in self._samples))
        return follow.interpolated(samples, self._mu, self.path.time)[0]

    @cached_property
    def _mu(self) -> float:
        return follow.fitting_mu(self._samples)

    @cached_property
    def _periods(self) -> Floats:
        """Periods (K,) of the Kepler orbits through the samples."""
        return follow.periods(self._samples, self._mu)

    @property
    def _orbits(self) -> bool:
        """Whether the motion is near to one Kepler orbit; it need not be, as the body may orbit some other body."""
        return bool(np.isfinite(self._periods).all() and self._periods.max() < 2 * self._periods.min())

    @property
    def _revolutions_between(self) -> Floats:
        """The number of revolutions (K - 1,) between samples."""
        periods = self._periods
        return np.asarray(np.abs(np.diff(self.time)) / np.minimum(periods[1:], periods[:-1]))

    def denser_output(self, by: float = 2.0) -> str:
        """Return a suggested spacing of samples: a tenth of the period, or the present one divided by a number."""
        spacing = float(np.abs(np.diff(self.time)).max()) / by
        if self._orbits:
            spacing = min(spacing, float(np.median(self._periods)) / 10)
        return f"output= {self.span(float(f'{spacing:.2g}'))} or less"

    @cached_property
    def revolutions(self) -> float:
        """The number of revolutions that the run covers."""
        angle = self.longitude[0]
        return float(abs(angle[-1] - angle[0]) / (2 * np.pi))

    def _check_revolutions(self, least: int) -> None:
        gaps = self._revolutions_between
        if self._orbits and gaps.max() >= _LARGEST_GAP:
            k = int(np.argmax(gaps >= _LARGEST_GAP))
            self._refuse_sparse(k, gaps[k])
        angle, rate = self.longitude
        # The angle by the rates at both ends; if it differs by half a turn, the direction moved in the other sense.
        predicted = (rate[1:] + rate[:-1]) / 2 * np.diff(self.path.time)
        ambiguous = np.abs(predicted - np.diff(angle)) > np.pi
        if ambiguous.any():
            first = int(np.argmax(ambiguous))
            k = int(np.argmin(np.abs(self.time[:-1] - self.path.time[first])))
            self._refuse_sparse(k, abs(float(predicted[first])) / (2 * np.pi))
        if self.revolutions < least:
            covered = f"the run covers {self.revolutions:.3g} revolutions"
            raise InvalidInput(f"{covered}; {self.observable} needs {least} or more")

    def _gap(self, k: int) -> str:
        return f"between its samples at {self.span(self.time[k])} and {self.span(self.time[k + 1])}"

    def _refuse_sparse(self, k: int, revolutions: float) -> NoReturn:
        raise InvalidInput(
            f"{self._gap(k)} the run makes about {revolutions:.2g} revolutions; "
            f"{self.observable} needs several samples in each ({self.denser_output()})"
        )

    def check_rotation(self, rate: Floats, limit: float) -> None:
        """Raise an error if a direction or frame, at its rates (K,), may rotate too far between samples."""
        angle = (rate[1:] + rate[:-1]) / 2 * np.abs(np.diff(self.time))
        self._check_gaps(angle, limit, f"{self.name} turns", "rad in the orbit's frame")

    @property
    def relative_spin(self) -> Floats:
        """The body's angular velocity (K, 3) less that of the line to the other body, inertial frame."""
        return np.einsum("kij,kj->ki", self.matrix, self.spin) - direction_rate(self._samples)[:, None] * self.normal

    def attach(self, value: Any, dimension: str) -> Any:
        """Return numbers with their unit, if the system has units, and ``None`` as it is."""
        return None if value is None else self.units.attach(np.asarray(value)[()], dimension)

    rate = partialmethod(attach, dimension="spin")
    angle = partialmethod(attach, dimension="angle")
    span = partialmethod(attach, dimension="time")
    length = partialmethod(attach, dimension="length")

    @property
    def pole(self) -> Floats:
        """The direction (K, 3) of the spin, inertial frame."""
        size = np.linalg.norm(self.spin, axis=1)
        if not np.all(size > 0.0):
            raise InvalidInput("the body does not spin; it has no pole of rotation")
        return np.einsum("kij,kj->ki", self.matrix, self.spin / size[:, None])

    @cached_property
    def power(self) -> int:
        """The power of the window for the mean rate of an angle that changes with every revolution."""
        return 3 if self.revolutions >= WINDOWED else 1

    @cached_property
    def longitude(self) -> tuple[Floats, Floats]:
        """Longitudes along the path and their rates; see :func:`swept`."""
        return swept(self.path)

    def longitude_at(self, moments: Floats) -> tuple[Floats, Floats]:
        """Return the longitude and its rate at given times of the run."""
        angle, rate = self.longitude
        k = follow.interval(self.path.time, moments)
        path, sense = self.at(moments), np.sign(rate[k])
        start = follow.Path(*(values[k] for values in self.path))
        return angle[k] + swept_angles(start, path, sense, sense), sense * direction_rate(path)

    def mean_motion(self, path: follow.Path) -> float:
        """Return the mean rate of the longitude."""
        return abs(signal.slope(path.time, swept(path)[0], self.power))

    def precession(self, poles: Floats, axis: Any) -> tuple[float | None, Floats]:
        """Return the mean rate at which directions precess about an axis, and their angles from it.

        The default axis is the angular momentum at the start. The rate is ``None`` if the directions are mostly nearer
        to the axis than :data:`NEAREST`, or go about it another number of times by every second sample.
        """
        axis = self._start if axis is None else directions(axis, "axis", single=True)
        about, every = azimuth(poles, axis), azimuth(poles[::2], axis)
        angle: Floats = np.arctan2(np.linalg.norm(np.cross(poles, axis), axis=1), poles @ axis)
        # A direction nearly opposite to the axis, about which it precesses in the other sense, is as near to it.
        is_near = np.median(np.minimum(angle, np.pi - angle)) < NEAREST
        revolutions = [(result[-1] - result[0]) / (2 * np.pi) for result in (about[: 2 * len(every) - 1], every)]
        return None if is_near or abs(revolutions[0] - revolutions[1]) > 0.5 else signal.slope(self.time, about), angle

    def rate_from_node(self, axis: Any) -> float:
        """Return the mean rate of the angle from the ascending node on the plane normal to an axis."""
        axis = self._start if axis is None else directions(axis, "axis", single=True)
        _, r, v = self.path
        normal = np.cross(r, v)
        node = np.cross(axis, normal)
        forward = np.cross(normal, node) / np.linalg.norm(normal, axis=1)[:, None]
        angle = np.unwrap(np.arctan2(np.sum(r * forward, axis=1), np.sum(r * node, axis=1)))
        return abs(signal.slope(self.path.time, angle, self.power))


def normal_axes(axis: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors normal to an axis and to each other, the first in the xy-plane if possible."""
    start = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    x = np.cross(start, axis)
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def azimuth(poles: Floats, axis: Floats) -> Floats:
    """Return the angles of directions about an axis, without jumps."""
    size = np.linalg.norm(axis)
    if size == 0.0:
        raise InvalidInput("the angular momentum is zero; expected an axis=")
    x, y = normal_axes(axis / size)
    return np.unwrap(np.arctan2(poles @ y, poles @ x))


def direction_rate(path: follow.Path) -> Floats:
    """Return the rate (K,) at which the direction rotates: |r x v| / r^2."""
    _, r, v = path
    return np.asarray(np.linalg.norm(np.cross(r, v), axis=1) / np.sum(r**2, axis=1))


def swept_angles(start: follow.Path, end: follow.Path, start_sense: Floats, end_sense: Floats) -> Floats:
    """Return the angles (K,) that the direction sweeps from each point of one path to the next point of another.

    The angle is the great circle between both directions, plus the excess of the path that leaves and arrives along the
    velocities: a cubic normal to the circle, so that the error falls with the fourth power of the step. The senses (K,)
    are those of the motion in both paths, 1 or -1.
    """
    u, w = (path.r / np.linalg.norm(path.r, axis=1)[:, None] for path in (start, end))
    senses = ((start, start_sense), (end, end_sense))
    n, m = (sense[:, None] * _unit(np.cross(path.r, path.v)) for path, sense in senses)
    product = np.cross(u, w)
    sine = np.linalg.norm(product, axis=1)
    sign = np.where(np.sum(product * (n + m), axis=1) < 0.0, -1.0, 1.0)
    angle = sign * np.arctan2(sine, np.sum(u * w, axis=1))
    pole = (sign / np.where(sine > 0.0, sine, 1.0))[:, None] * product
    # Slopes of the path relative to the great circle, at its ends.
    a, b = np.sum(np.cross(n, u) * pole, axis=1), np.sum(np.cross(m, w) * pole, axis=1)
    return np.asarray(angle * (1.0 + (2 * a * a - a * b + 2 * b * b) / 30))


def swept(path: follow.Path) -> tuple[Floats, Floats]:
    """Return the longitude (K,) along a path and its rate, from a direction fixed in the moving orbital plane.

    It is the true longitude of Hansen's ideal frame: its rate is |r x v| / r^2, however the plane moves (Lara &
    Urrutxua 2023, Universe 9, 470), so that it is the length of the path of the direction on the sphere. If the motion
    comes to a stop and reverses, as of one moon seen from another, the longitude decreases from there.
    """
    normal = _unit(np.cross(path.r, path.v))
    signs = np.where(np.sum(normal[1:] * normal[:-1], axis=1) < 0.0, -1.0, 1.0)
    sense = np.concatenate([[1.0], np.cumprod(signs)])
    start, end = (follow.Path(*(values[part] for values in path)) for part in (slice(None, -1), slice(1, None)))
    angle = np.concatenate([[0.0], np.cumsum(swept_angles(start, end, sense[:-1], sense[1:]))])
    return angle, sense * direction_rate(path)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])
