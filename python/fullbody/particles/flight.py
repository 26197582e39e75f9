"""A flight: the samples, the fates and the events of particles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic

import numpy as np
import numpy.typing as npt

from ..base.attributes import Attribute
from ..base.tables import Table, Tabled, number, tables_of
from ..base.values import ArrayFields
from ..model.context import Context, S
from ..record.columns import Column
from ..typing import Array, Scalar
from .events import ParticleEvent
from .files import save, to_xarray
from .rules import FATES


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ParticleOccurrence(ArrayFields):
    """The occurrence of an event of a particle.

    Attributes
    ----------
    event : ParticleEvent
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


class Flight(Tabled, Generic[S]):
    """The result of integrating particles along the motion of the bodies.

    A value that a particle does not have is NaN: samples after its removal or escape, and the location of an impact
    that did not happen.

    Attributes
    ----------
    system : System
    error : FullbodyError or None
        The error that ended the flight early, or ``None``.
    """

    error: BaseException | None = None

    def __init__(self, system: S, arrays: dict[str, Any], watched: Sequence[ParticleEvent] = ()) -> None:
        self.system, self.arrays, self.watched = system, arrays, tuple(watched)
        for values in arrays.values():
            values.flags.writeable = False

    context = Attribute[Context]("system.context", "The units and the bodies of the system.")
    fate = Attribute[npt.NDArray[np.str_]](
        lambda flight: np.array(FATES)[flight.arrays["fate"]],
        """The fate (P,) of each particle, as a text.

        It is ``"flying"`` at the end; ``"impact"`` on a body; ``"escape"``; ``"rest"`` on a body; or ``"lost"``, if a
        particle comes so close to a point mass that its steps no longer advance the time, or becomes more distant or
        faster than 1e75 of the system's units.
        """,
    )
    fate_body = Attribute[npt.NDArray[np.int32]](
        lambda flight: flight.arrays["fate_body"],
        "Index (P,) in the system of the body on which each particle ended; -1 if there is none.",
    )
    strikes = Attribute[npt.NDArray[np.uint32]](
        lambda flight: flight.arrays["strikes"], "Number of times (P,) that each particle has struck a surface."
    )
    time = Column("Times (K,) of the samples.", "time", "time")
    position = Column(
        "Inertial positions (K, P, 3) at the samples. Particles that lie on a body move with it.", "position", "length"
    )
    velocity = Column("Inertial velocities (K, P, 3) of the particles at the samples.", "velocity", "velocity")
    fate_time = Column("Times (P,) at which the particles reached their fate; NaN without one.", "fate_time", "time")
    longitude = Column(
        "Longitudes (P,) of impact or rest, as directions from the body's centre in its frame.", "longitude", "angle"
    )
    latitude = Column("Latitudes (P,) of impact or rest, like the longitudes.", "latitude", "angle")
    speed = Column("Speeds (P,) of the last impacts relative to the surface.", "speed", "velocity")
    incidence = Column("Angles (P,) between path and surface normal at the last impacts.", "incidence", "angle")
    last_time = Column("Times (P,) up to which the particles were integrated.", "last_time", "time")
    last_position = Column("Inertial positions (P, 3) at :attr:`last_time`.", "last_position", "length")
    last_velocity = Column("Inertial velocities (P, 3) at :attr:`last_time`.", "last_velocity", "velocity")

    @property
    def events(self) -> list[ParticleOccurrence]:
        """The detected events, ordered by particle, and along the flight of each."""
        names, attach = ("particle", "time", "position", "velocity", "rising"), self.context.units.attach
        columns = zip(self.arrays["event"], *(self.arrays[f"event_{name}"] for name in names), strict=True)
        events = []
        for k, particle, t, x, v, rising in columns:
            motion = attach(t, "time"), attach(x, "length"), attach(v, "velocity")
            events.append(ParticleOccurrence(self.watched[k], int(particle), *motion, bool(rising)))
        return events

    @property
    def counts(self) -> dict[str, int]:
        """The number of particles with each fate."""
        numbers = np.bincount(self.arrays["fate"], minlength=len(FATES))
        return {name: int(count) for name, count in zip(FATES, numbers, strict=True) if count}

    def __len__(self) -> int:
        return len(self.arrays["fate"])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Flight):
            return NotImplemented
        alike = all(np.array_equal(self.arrays[name], other.arrays[name], equal_nan=True) for name in self.arrays)
        described = [[event._describe(f.context) for event in f.watched] for f in (self, other)]
        return alike and self.system == other.system and described[0] == described[1]

    __hash__ = None  # type: ignore[assignment]

    to_xarray = to_xarray
    save = save

    def _tables(self) -> tuple[Table, ...]:
        """Return the tables of the flight's span and fates."""
        rows: list[Sequence[str]] = [("particles", str(len(self))), ("samples", str(len(self.arrays["time"])))]
        if len(self.arrays["time"]):
            rows.append(("time", f"{number(self.time[0])} to {number(self.time[-1])}"))
        rows += [(name, str(count)) for name, count in self.counts.items()]
        struck = self.fate_body[self.arrays["fate"] == FATES.index("impact")]
        rows += [(f"impact on {n}", str(int((struck == k).sum()))) for k, n in enumerate(self.context.names)]
        if len(self.arrays["event"]):
            rows.append(("events", str(len(self.arrays["event"]))))
        return (Table("Flight", (), rows), *tables_of(self.system))

    def __repr__(self) -> str:
        fates = ", ".join(f"{count} {name}" for name, count in self.counts.items())
        samples = len(self.arrays["time"])
        return f"Flight({len(self)} particles, {samples} sample{'s' if samples != 1 else ''}: {fates})"
