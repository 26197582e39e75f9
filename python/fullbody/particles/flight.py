"""A flight: the samples, the fates and the events of particles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.tables import Table, Tabled, number
from ..base.values import ScalarFields
from ..typing import Array, Scalar
from .events import ParticleEvent
from .rules import FATES

if TYPE_CHECKING:
    import xarray

    from ..motion.system import System

__all__ = ["Flight", "ParticleOccurrence"]


@dataclass(frozen=True, slots=True, eq=False)
class ParticleOccurrence(ScalarFields):
    """The occurrence of an event of a particle.

    Attributes
    ----------
    event : ParticleEvent
        The event that was detected.
    particle : int
    time : float or Quantity
    position, velocity : ndarray or Quantity, (3,)
        Position and velocity in the inertial frame.
    rising : bool
        Whether the function rises along the flight; for a shadow, whether the particle leaves it.
    """

    event: ParticleEvent
    particle: int
    time: Scalar
    position: Array
    velocity: Array
    rising: bool


class Flight(Tabled):
    """The result of integrating particles along the motion of the bodies.

    A value that a particle does not have is NaN: samples after its removal or escape, and the location of an impact
    that did not happen.

    Attributes
    ----------
    system : System
    time : ndarray or Quantity, (K,)
        Times of the samples.
    position, velocity : ndarray or Quantity, (K, P, 3)
        Samples in the inertial frame. Particles that lie on a body move with it.
    fate : ndarray of str, (P,)
        ``"flying"`` at the end; ``"impact"`` on a body; ``"escape"``; ``"rest"`` on a body; or ``"lost"``, if a
        particle comes so close to a point mass that its steps no longer advance the time, or becomes more distant or
        faster than 1e75 of the system's units.
    fate_time : ndarray or Quantity, (P,)
        The time at which the particle reached its fate; NaN for particles that fly.
    fate_body : ndarray of int, (P,)
        The index of the body of the fate in the system; -1 if there is none.
    longitude, latitude : ndarray or Quantity, (P,)
        Body-fixed coordinates of the place of impact or rest, as directions from the body's centre in its frame.
    speed, incidence : ndarray or Quantity, (P,)
        The last impact's speed relative to the surface, and its angle between the path and the normal.
    strikes : ndarray of int, (P,)
        The number of times that a particle has struck a surface.
    last_time : ndarray or Quantity, (P,)
        The time up to which each particle was integrated.
    last_position, last_velocity : ndarray or Quantity, (P, 3)
        Inertial position and velocity at that time.
    events : list of ParticleOccurrence
        Occurrences ordered by particle, and along the flight of each.
    error : FullbodyError or None
        The error that ended the flight early, or ``None``.
    """

    error: BaseException | None = None

    def __init__(self, system: System, record: dict[str, Any], watched: Sequence[ParticleEvent] = ()) -> None:
        self.system = system
        self._record = record
        self.watched = tuple(watched)

    def _get(self, name: str, dimension: str) -> Array:
        values: Array = self.system._units.attach(self._record[name], dimension)
        return values

    @property
    def time(self) -> Array:
        """Times (K,) of the samples."""
        return self._get("time", "time")

    @property
    def position(self) -> Array:
        """Inertial positions (K, P, 3) of the particles at the samples."""
        values: Array = self.system._units.attach(self._record["samples"].transpose(1, 0, 2)[..., :3], "length")
        return values

    @property
    def velocity(self) -> Array:
        """Inertial velocities (K, P, 3) of the particles at the samples."""
        values: Array = self.system._units.attach(self._record["samples"].transpose(1, 0, 2)[..., 3:], "velocity")
        return values

    @property
    def fate(self) -> npt.NDArray[np.str_]:
        """The fate (P,) of each particle, as a text."""
        found: npt.NDArray[np.str_] = np.array(FATES)[self._record["fate"]]
        return found

    @property
    def fate_time(self) -> Array:
        """Times (P,) at which the particles reached their fate; NaN for particles that fly."""
        return self._get("fate_time", "time")

    @property
    def fate_body(self) -> npt.NDArray[np.int32]:
        """Index (P,) of the body on which each particle ended; -1 if there is none."""
        found: npt.NDArray[np.int32] = self._record["fate_body"]
        return found

    @property
    def longitude(self) -> Array:
        """Longitudes (P,) of impact or rest in the body frame."""
        return self._get("longitude", "angle")

    @property
    def latitude(self) -> Array:
        """Latitudes (P,) of impact or rest in the body frame."""
        return self._get("latitude", "angle")

    @property
    def speed(self) -> Array:
        """Speeds (P,) of the last impacts relative to the surface."""
        return self._get("speed", "velocity")

    @property
    def incidence(self) -> Array:
        """Angles (P,) between path and surface normal at the last impacts."""
        return self._get("incidence", "angle")

    @property
    def strikes(self) -> npt.NDArray[np.uint32]:
        """Number of times (P,) that each particle has struck a surface."""
        found: npt.NDArray[np.uint32] = self._record["strikes"]
        return found

    @property
    def last_time(self) -> Array:
        """Times (P,) up to which the particles were integrated."""
        return self._get("last_time", "time")

    @property
    def last_position(self) -> Array:
        """Inertial positions (P, 3) at :attr:`last_time`."""
        values: Array = self.system._units.attach(self._record["last"][:, :3], "length")
        return values

    @property
    def last_velocity(self) -> Array:
        """Inertial velocities (P, 3) at :attr:`last_time`."""
        values: Array = self.system._units.attach(self._record["last"][:, 3:], "velocity")
        return values

    @property
    def events(self) -> list[ParticleOccurrence]:
        """The detected events, ordered by particle."""
        r, attach = self._record, self.system._units.attach
        columns = zip(
            r["event"], r["event_particle"], r["event_time"], r["event_position"], r["event_velocity"],
            r["event_rising"], strict=True,
        )  # fmt: skip
        return [
            ParticleOccurrence(
                self.watched[k], int(p), attach(t, "time"), attach(x, "length"), attach(v, "velocity"), bool(rising)
            )
            for k, p, t, x, v, rising in columns
        ]

    @property
    def counts(self) -> dict[str, int]:
        """The number of particles with each fate."""
        numbers = np.bincount(self._record["fate"], minlength=len(FATES))
        return {name: int(count) for name, count in zip(FATES, numbers, strict=True) if count}

    def __len__(self) -> int:
        return len(self._record["fate"])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Flight):
            return NotImplemented
        alike = all(np.array_equal(self._record[name], other._record[name], equal_nan=True) for name in self._record)
        described = [[event._describe(f.system.context) for event in f.watched] for f in (self, other)]
        return alike and self.system == other.system and described[0] == described[1]

    __hash__ = None  # type: ignore[assignment]

    def to_xarray(self) -> xarray.Dataset:
        """Convert the flight to an ``xarray.Dataset``, with units, and the system in its attributes.

        Returns
        -------
        xarray.Dataset
            The dimensions are ``time``, ``particle``, ``axis`` and ``event``; numbers of ``fate`` are indices of its
            attribute ``flag_meanings``.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> flight = system.fly(state, fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]]), 2.0, output=1.0)
        >>> dict(flight.to_xarray().sizes)
        {'time': 3, 'particle': 1, 'axis': 3, 'event': 0}
        """
        from .files import to_xarray

        return to_xarray(self)

    def save(self, path: Any) -> None:
        """Write a NetCDF file exactly and atomically; :func:`fullbody.load_flight` reads it.

        The file has a checksum of its whole content, as a run's file has. Functions of events are kept by name only.

        Parameters
        ----------
        path : str or Path
            The file's name, which ends in ``.nc`` or ``.nc4``.
        """
        from .files import save

        save(self, path)

    def _tables(self) -> tuple[Table, ...]:
        """Return the tables of the flight's span and fates."""
        rows: list[Sequence[str]] = [("particles", str(len(self))), ("samples", str(len(self._record["time"])))]
        if len(self._record["time"]):
            rows.append(("time", f"{number(self.time[0])} to {number(self.time[-1])}"))
        rows += [(name, str(count)) for name, count in self.counts.items()]
        struck = self.fate_body[self._record["fate"] == FATES.index("impact")]
        rows += [(f"impact on {n}", str(int((struck == k).sum()))) for k, n in enumerate(self.system.names)]
        if len(self._record["event"]):
            rows.append(("events", str(len(self._record["event"]))))
        return (Table("Flight", (), rows), *self.system._tables())

    def __repr__(self) -> str:
        fates = ", ".join(f"{count} {name}" for name, count in self.counts.items())
        samples = len(self._record["time"])
        return f"Flight({len(self)} particles, {samples} sample{'s' if samples != 1 else ''}: {fates})"
