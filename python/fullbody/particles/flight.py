"""What becomes of particles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import named_options
from ..base.tables import Table, Tabled, number
from ..base.values import ScalarFields
from ..typing import Array, Scalar
from .events import ParticleEvent
from .rules import FATES

if TYPE_CHECKING:
    import xarray

    from ..model.system import BaseSystem

__all__ = ["Flight", "Happened"]


@dataclass(frozen=True, slots=True, eq=False)
class Happened(ScalarFields):
    """An event of a particle.

    Attributes
    ----------
    event : ParticleEvent
        What was watched for.
    particle : int
    time : float or Quantity
    position, velocity : ndarray or Quantity, (3,)
        Inertial.
    rising : bool
        Whether the function rises along the flight: of a shadow, whether the particle leaves it.
    """

    event: ParticleEvent
    particle: int
    time: Scalar
    position: Array
    velocity: Array
    rising: bool


@named_options
class Flight(Tabled):
    """Particles that have flown.

    Values that a particle does not have are NaN: samples after it was removed or has escaped, the place of an impact
    that did not happen.

    Attributes
    ----------
    system : System
    time : ndarray or Quantity, (K,)
        Times of the samples.
    position, velocity : ndarray or Quantity, (K, P, 3)
        Inertial. Particles that lie on a body move with it.
    fate : ndarray of str, (P,)
        ``"flying"`` at the end; ``"impact"`` on a body; ``"escape"``; ``"rest"`` on a body; ``"lost"``, where a
        particle comes so near to a point mass that its steps no longer advance the time, or gets farther away or
        faster than 1e75 of the system's units.
    fate_time : ndarray or Quantity, (P,)
        When that happened; NaN of those that fly.
    fate_body : ndarray of int, (P,)
        The place of the body in the system; -1 without one.
    longitude, latitude : ndarray or Quantity, (P,)
        Of the place of the impact or of rest, from the body's centre in its frame.
    speed, incidence : ndarray or Quantity, (P,)
        Of the last impact: the speed relative to the surface, and the angle between the path and the normal.
    strikes : ndarray of int, (P,)
        How often a particle has struck a surface.
    last_time : ndarray or Quantity, (P,)
        To which each was followed.
    last_position, last_velocity : ndarray or Quantity, (P, 3)
        Then.
    events : list of Happened
        By particle, and along the flight of each.
    error : FullbodyError or None
        What cut the flight short.
    """

    error: BaseException | None = None

    def __init__(self, system: BaseSystem, record: dict[str, Any], watched: Sequence[ParticleEvent] = ()) -> None:
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
        """Positions (K, P, 3)."""
        values: Array = self.system._units.attach(self._record["samples"].transpose(1, 0, 2)[..., :3], "length")
        return values

    @property
    def velocity(self) -> Array:
        """Velocities (K, P, 3)."""
        values: Array = self.system._units.attach(self._record["samples"].transpose(1, 0, 2)[..., 3:], "velocity")
        return values

    @property
    def fate(self) -> npt.NDArray[np.str_]:
        """What became of each particle (P,)."""
        found: npt.NDArray[np.str_] = np.array(FATES)[self._record["fate"]]
        return found

    @property
    def fate_time(self) -> Array:
        """When it did (P,)."""
        return self._get("fate_time", "time")

    @property
    def fate_body(self) -> npt.NDArray[np.int32]:
        """On which body (P,); -1 without one."""
        found: npt.NDArray[np.int32] = self._record["fate_body"]
        return found

    @property
    def longitude(self) -> Array:
        """Longitudes (P,) in the body frame."""
        return self._get("longitude", "angle")

    @property
    def latitude(self) -> Array:
        """Latitudes (P,) in the body frame."""
        return self._get("latitude", "angle")

    @property
    def speed(self) -> Array:
        """Speeds (P,) relative to the surface."""
        return self._get("speed", "velocity")

    @property
    def incidence(self) -> Array:
        """Angles (P,) between path and normal."""
        return self._get("incidence", "angle")

    @property
    def strikes(self) -> npt.NDArray[np.uint32]:
        """How often each particle has struck a surface (P,)."""
        found: npt.NDArray[np.uint32] = self._record["strikes"]
        return found

    @property
    def last_time(self) -> Array:
        """The time (P,) to which each particle was followed."""
        return self._get("last_time", "time")

    @property
    def last_position(self) -> Array:
        """Positions (P, 3) then."""
        values: Array = self.system._units.attach(self._record["last"][:, :3], "length")
        return values

    @property
    def last_velocity(self) -> Array:
        """Velocities (P, 3) then."""
        values: Array = self.system._units.attach(self._record["last"][:, 3:], "velocity")
        return values

    @property
    def events(self) -> list[Happened]:
        """What happened, by particle."""
        r, attach = self._record, self.system._units.attach
        columns = zip(
            r["event"], r["event_particle"], r["event_time"], r["event_position"], r["event_velocity"],
            r["event_rising"], strict=True,
        )  # fmt: skip
        return [
            Happened(
                self.watched[k], int(p), attach(t, "time"), attach(x, "length"), attach(v, "velocity"), bool(rising)
            )
            for k, p, t, x, v, rising in columns
        ]

    @property
    def counts(self) -> dict[str, int]:
        """How many particles have each fate."""
        numbers = np.bincount(self._record["fate"], minlength=len(FATES))
        return {name: int(count) for name, count in zip(FATES, numbers, strict=True) if count}

    def __len__(self) -> int:
        return len(self._record["fate"])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Flight):
            return NotImplemented
        alike = all(np.array_equal(self._record[name], other._record[name], equal_nan=True) for name in self._record)
        described = [[event._describe(f.system) for event in f.watched] for f in (self, other)]
        return alike and self.system == other.system and described[0] == described[1]

    __hash__ = None  # type: ignore[assignment]

    def to_xarray(self) -> xarray.Dataset:
        """The flight as an ``xarray.Dataset``, with units and the system in its attributes.

        Returns
        -------
        xarray.Dataset
            Dimensions ``time``, ``particle``, ``axis`` and ``event``; ``fate`` counts into its attribute
            ``flag_meanings``.

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
        """Write a NetCDF file, exactly and atomically; read it with :func:`fullbody.load_flight`.

        As a run's, the file has a checksum of the whole. Functions that were watched for are kept by their names.

        Parameters
        ----------
        path : str or Path
            Ending in ``.nc`` or ``.nc4``.
        """
        from .files import save

        save(self, path)

    def _tables(self) -> tuple[Table, ...]:
        """Span and fates of a flight."""
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
