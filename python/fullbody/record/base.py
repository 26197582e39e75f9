"""The samples of a run as arrays, and how well it kept energy and angular momentum."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, Self, overload

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.tables import Table, Tabled, number
from ..base.values import same
from ..errors import FullbodyError, InvalidInput
from ..events import Occurrence
from ..model.interactions import Invariants
from ..model.state import State
from ..model.system import BaseSystem
from ..orbit.elements import KeplerElements
from ..typing import Array
from . import conserved
from .dense import Dense, Samples
from .derivatives import Differentiated
from .integrators import Integrator
from .statistics import Statistics
from .track import Track

__all__ = ["STOP_REASONS", "BaseRun"]


#: Why a run may end, with words for an early end; ``"unknown"`` in a run from a file that does not tell.
STOP_REASONS = {
    "end": None,
    "event": "by the last event",
    "interrupted": "by an interrupt",
    "unfinished": "by an error",
    "unknown": None,
}


class BaseRun(Tabled, Differentiated):
    """The record of an integration: K samples of N bodies.

    ``run[k]`` is a :class:`State`, ``run["Beta"]`` the :class:`Track` of one body, and ``run[::k]`` a thinned
    :class:`Run` (its start, statistics and events are the whole run's).
    Arrays are read-only views; Quantities where the system has units. Pickles, like files, leave out ``dense``.

    Attributes
    ----------
    system : System
    statistics : Statistics
    integrator : Integrator
    events : list of Occurrence
        The events that happened, in order of the run.
    stop_reason : str
        ``"end"``, ``"event"`` (a terminal one, the last of ``events``), ``"interrupted"`` or ``"unfinished"`` (by an
        error); ``"unknown"`` in a run from a file that does not tell.
    dense : Dense or None
        The run as a function of time, where it was asked for; ``run(t)`` is ``run.dense(t)``.
    error : FullbodyError or None
        What cut the run short, if that was an error of this package: one like it, without the run. Files do not keep
        it.
    switched_off : dict of int
        How often forces that act at times only were switched off in the run, by their names:
        :class:`fullbody.forces.Byorp` while the secondary is not locked. One that is off when the run begins counts.
    """

    system: BaseSystem
    #: Numbers of the start, as in :mod:`fullbody.record.conserved`; ``None`` where a file does not tell.
    _start: npt.NDArray[np.float64] | None = None

    def __init__(
        self,
        system: BaseSystem,
        record: dict[str, npt.NDArray[np.float64]],
        statistics: Statistics,
        integrator: Integrator,
    ) -> None:
        self.system = system
        self.statistics = statistics
        self.integrator = integrator
        self.events: list[Occurrence] = []
        self.stop_reason = "end"
        self.dense: Dense | None = None
        self.error: FullbodyError | None = None
        self.switched_off: dict[str, int] = {}
        self._record = record
        self._protect()

    def _protect(self) -> None:
        for values in self._record.values():
            values.flags.writeable = False

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "dense": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._protect()

    def __copy__(self) -> Self:
        return self[:]

    def __deepcopy__(self, memo: Any) -> Self:
        # Nothing in it changes, but for the list of events.
        run = self[:]
        run.events = list(run.events)
        return run

    def elements(self, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> KeplerElements[Array]:
        """Osculating elements of one body about another.

        Parameters
        ----------
        mu : float or Quantity, optional
            G times the sum of the two masses, unless given.
        body, about : int or str
            Places in the system, or names.

        Returns
        -------
        KeplerElements
            Of arrays (K,), in the frame of the system.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.integrate(state, 10.0, output=1.0).elements().e.shape
        (11,)
        """
        units = self.system._units
        body, about = self.system._place(body, "body"), self.system._place(about, "about")
        mu = self.system.mu(body, about) if mu is None else mu
        number = units.number(mu, "mu", "mu")
        position, velocity = self._record["position"], self._record["velocity"]
        rows = _core.cartesian_to_elements(
            np.ascontiguousarray(position[:, body] - position[:, about]),
            np.ascontiguousarray(velocity[:, body] - velocity[:, about]),
            number,
        )
        a, e, *angles = (np.ascontiguousarray(column) for column in rows.T)
        return KeplerElements._trusted(
            [units.attach(a, "length"), e, *(units.attach(angle, "angle") for angle in angles)], self.system.frame
        )

    @overload
    def __call__(self, time: float | str) -> State: ...
    @overload
    def __call__(self, time: Sequence[float] | npt.NDArray[Any]) -> Samples: ...
    def __call__(self, time: Any) -> State | Samples:
        """The state at any time of a run with ``dense=True``; see :class:`Dense`.

        Parameters
        ----------
        time : float, Quantity or array_like, (K,)

        Returns
        -------
        State or Samples

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 10.0, output=10.0, dense=True)
        >>> run(3.7).position.shape, run([1.0, 2.0]).position.shape
        ((2, 3), (2, 2, 3))
        """
        if self.dense is None:
            raise InvalidInput("this run keeps no continuous solution; integrate with dense=True")
        found: State | Samples = self.dense(time)
        return found

    def __len__(self) -> int:
        return len(self._record["time"])

    @overload
    def __getitem__(self, index: int) -> State: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    @overload
    def __getitem__(self, index: str) -> Track: ...
    def __getitem__(self, index: int | slice | str) -> State | Self | Track:
        if isinstance(index, str):
            return self._track(self.system._place(index, "body"))
        if isinstance(index, slice):
            record = {name: np.ascontiguousarray(values[index]) for name, values in self._record.items()}
            run = type(self)(self.system, record, self.statistics, self.integrator)
            run.events, run.stop_reason, run.dense = self.events, self.stop_reason, self.dense
            run._start, run.switched_off, run.error = self._start, self.switched_off, self.error
            run._parameters = self._parameters
            return run
        r = self._record
        core = _core.State(
            float(r["time"][index]),
            *(np.ascontiguousarray(r[n][index]) for n in ("position", "velocity", "attitude", "spin")),
        )
        return self.system._state(core)

    def _track(self, body: int) -> Track:
        arrays = (getattr(self, name)[:, body] for name in ("position", "velocity", "attitude", "spin"))
        return Track(self.system.names[body], self.time, *arrays)

    def __iter__(self) -> Iterator[State]:
        return (self[k] for k in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BaseRun):
            return NotImplemented
        alike = self._record.keys() == other._record.keys() and self._parameters == other._parameters
        alike = alike and all(np.array_equal(values, other._record[name]) for name, values in self._record.items())
        alike = alike and same(self._start, other._start)
        how = self.stop_reason == other.stop_reason and self.events == other.events
        how = how and self.switched_off == other.switched_off
        return alike and how and self.system == other.system and self.statistics == other.statistics

    __hash__ = None  # type: ignore[assignment]

    def _tables(self) -> tuple[Table, ...]:
        """Span, counts, events and conservation of a run."""
        s, integrator = self.statistics, self.integrator
        rows: list[Sequence[str]] = [("samples", str(len(self)))]
        if len(self):
            rows.append(("time", f"{number(self.time[0])} to {number(self.time[-1])}"))
        start = self.start
        if start is not None and not (len(self) and start.time == self.time[0]):
            rows.append(("start", number(start.time)))
        rows += [
            ("integrator", repr(integrator)),
            ("steps", f"{s.steps}, {s.rejected} rejected, {s.evaluations} evaluations"),
        ]
        kinds = Counter(type(happened.event).__name__ for happened in self.events)
        if kinds:
            rows.append(("events", ", ".join(f"{count} {kind}" for kind, count in kinds.items())))
        rows += [(f"{name} switched off", f"{times} times") for name, times in self.switched_off.items()]
        if early := STOP_REASONS[self.stop_reason]:
            rows.append(("stopped", early))
        drifts = {
            "energy_drift": "drift of the energy{}, relative to the total",
            "energy_drift_orbital": "drift of the energy{}, relative to the orbit's",
            "angular_momentum_drift": "drift of the angular momentum{}, relative",
        }
        since = "" if start else " since the first sample"
        # A drift that is relative to nothing is left out.
        rows += [
            (name.format(since), f"{np.abs(self._drift(of)).max():.2e}")
            for of, name in drifts.items()
            if self._relative_to(of)
        ]
        return (Table("Run", (), rows), *self.system._tables())

    def __repr__(self) -> str:
        if len(self) == 0:
            return f"Run(no samples, {self.system!r})"
        span = f"{self.time[0]} to {self.time[-1]}"
        s = self.statistics
        samples = f"{len(self)} sample{'s' if len(self) > 1 else ''}"
        return f"Run({samples} from {span}, {s.steps} steps, {s.evaluations} evaluations, {self.system!r})"

    def _get(self, name: str, dimension: str) -> Array:
        values: Array = self.system._units.attach(self._record[name], dimension)
        return values

    @property
    def time(self) -> Array:
        """Times (K,)."""
        return self._get("time", "time")

    @property
    def dates(self) -> Any:
        """Dates (K,) of the samples as an ``astropy.time.Time``; for systems with an epoch and units."""
        if self.system.epoch is None:
            raise InvalidInput("this system has no epoch; give fullbody.System(..., epoch='2022-09-26 TDB')")
        from astropy import units as u

        return self.system.epoch + self._record["time"] * self.system._units.unit("time").to(u.s) * u.s

    @property
    def position(self) -> Array:
        """Centres (K, N, 3), inertial."""
        return self._get("position", "length")

    @property
    def velocity(self) -> Array:
        """Velocities (K, N, 3), inertial."""
        return self._get("velocity", "velocity")

    @property
    def attitude(self) -> npt.NDArray[np.float64]:
        """Unit quaternions (K, N, 4), ``[w, x, y, z]``."""
        return self._record["attitude"]

    @property
    def spin(self) -> Array:
        """Angular velocities (K, N, 3), body frames."""
        return self._get("spin", "spin")

    @property
    def energy(self) -> Array:
        """Total energy (K,)."""
        return self._energy(0)

    @property
    def translational_energy(self) -> Array:
        """Kinetic energy of the centres (K,)."""
        return self._energy(1)

    @property
    def rotational_energy(self) -> Array:
        """Kinetic energy of the spins (K,)."""
        return self._energy(2)

    @property
    def potential_energy(self) -> Array:
        """Potential energy (K,), negative."""
        return self._energy(3)

    def _energy(self, part: int) -> Array:
        values: Array = self.system._units.attach(self._record["energy"][:, part], "energy")
        return values

    @property
    def angular_momentum(self) -> Array:
        """Total angular momentum (K, 3) about the origin, inertial.

        Formed about the barycentre, whose own constant part is added: it loses no digits as the system travels.
        """
        return self._get("angular_momentum", "angular momentum")

    @property
    def work(self) -> dict[str, Array]:
        """What each force from outside has added to the energy since the start of the run (K,), by its name.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> run = system.with_forces([tide]).integrate(state, 20.0)
        >>> list(run.work)
        ['tide on Alpha']
        >>> bool(abs(run.energy_drift).max() < 1e-14)
        True
        """
        return self._book("work", "energy")

    @property
    def impulse(self) -> dict[str, Array]:
        """What each force from outside has added to the momentum since the start of the run (K, 3), by its name."""
        return self._book("impulse", "momentum")

    @property
    def angular_impulse(self) -> dict[str, Array]:
        """What each force from outside has added to the angular momentum since the start (K, 3), by its name."""
        return self._book("angular_impulse", "angular momentum")

    def _book(self, name: str, dimension: str) -> dict[str, Array]:
        forces = self.system.forces
        return {
            force.name: self.system._units.attach(self._record[name][:, k], dimension) for k, force in enumerate(forces)
        }

    @property
    def start(self) -> Invariants | None:
        """Time, energy and angular momentum at the start of the run, whether a sample was recorded there or not.

        A slice keeps the start of the whole run. ``None`` in a run from a file of version 0.1.0, which does not tell.
        """
        return None if self._start is None else conserved.named(self._start, self.system._units)

    @property
    def energy_drift(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start of the run, relative to it (K,); absolute where it is zero.

        The work of forces from outside is taken off: what is left is the error of the integration.
        Where ``start`` is ``None``, it is the change since the first sample, with a ``UserWarning``.
        """
        return self._drift_or_warning("energy_drift")

    @property
    def energy_drift_orbital(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start, relative to abs(potential + translational) there (K,).

        The energy of a fast spin can dwarf that of the orbit and hide its error. Absolute where there is no orbit.
        Where ``start`` is ``None``, it is the change since the first sample, with a ``UserWarning``.
        """
        return self._drift_or_warning("energy_drift_orbital")

    @property
    def angular_momentum_drift(self) -> npt.NDArray[np.float64]:
        """Length of the change of the angular momentum since the start, relative to its length (K,).

        The angular impulse of forces from outside is taken off.
        Absolute where that is zero. Where ``start`` is ``None``, it is the change since the first sample, with a
        ``UserWarning``.
        """
        return self._drift_or_warning("angular_momentum_drift")

    def _drift_or_warning(self, name: str) -> npt.NDArray[np.float64]:
        if self._start is None and len(self._record["time"]):
            text = (
                f"{name} is counted from the first sample, at time {self.time[0]}: the file that the run comes from "
                "does not tell what energy and angular momentum were at its start"
            )
            warnings.warn(text, UserWarning, stacklevel=3)
        return self._drift(name)

    def _drift(self, name: str) -> npt.NDArray[np.float64]:
        return conserved.drift(name, self._reference(), self._record)

    def _relative_to(self, name: str) -> float:
        """The size that a drift is relative to; zero in a run without samples."""
        return conserved.size(name, self._reference()) if len(self._record["time"]) else 0.0

    def _reference(self) -> npt.NDArray[np.float64]:
        """The start; or else the first sample; or else, where there is nothing to compare, zeros."""
        if self._start is not None:
            return self._start
        if not len(self._record["time"]):
            return np.zeros(8)
        return np.concatenate([np.atleast_1d(self._record[name][0]) for name in ("time", "energy", "angular_momentum")])
