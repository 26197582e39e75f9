"""The record of a motion: samples of its states as arrays, and quantities that follow from them."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Any, Generic, Self, TypeVar, overload

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.attributes import Attribute
from ..base.tables import Tabled
from ..base.values import ByName
from ..errors import FullbodyError, InvalidInput
from ..events import Occurrence
from ..model.context import Context, S
from ..model.interactions import Invariants
from ..model.state import PARTS, State, sample, wrap
from ..orbit.elements import KeplerElements, computed
from ..typing import Array, Floats
from . import columns, conserved
from .columns import Column, Numbers
from .dense import Dense, Samples
from .integrators import Integrator
from .track import Track

#: The reasons for which a run may end, with texts that describe an early end.
STOP_REASONS = {
    "end": None,
    "event": "by the last event",
    "interrupted": "by an interrupt",
    "unfinished": "by an error",
}


@dataclass(frozen=True, slots=True)
class Statistics:
    """Counts of an integration.

    Attributes
    ----------
    steps, rejected, evaluations : int
        Accepted steps, rejected attempts, evaluations of the rates of change.
    """

    steps: int
    rejected: int
    evaluations: int


_R = TypeVar("_R", bound="Record[Any]")


class Record(Tabled, Generic[S]):
    """K samples of the motion of N bodies with the settings of their integration; see :class:`fullbody.Run`."""

    def __init__(
        self,
        system: S,
        integrator: Integrator,
        arrays: dict[str, Floats],
        start: Floats,
        statistics: Statistics,
        *,
        events: Iterable[Occurrence] = (),
        stop_reason: str = "end",
        dense: Dense | None = None,
        switched_off: dict[str, int] | None = None,
        parameters: tuple[str, ...] = (),
    ) -> None:
        self.system, self.integrator, self.arrays = system, integrator, arrays
        #: The conserved quantities at the start, eight numbers; see ``fullbody.record.conserved``.
        self.invariants = start
        self.statistics, self.stop_reason, self.dense = statistics, stop_reason, dense
        self.events, self.switched_off, self.parameters = list(events), switched_off or {}, parameters
        self.error: FullbodyError | None = None
        #: The drifts that have been computed so far, by name.
        self._drifts: dict[str, Floats] = {}
        self._protect()

    context = Attribute[Context]("system.context", "The units and the bodies of the system.")

    def _protect(self) -> None:
        for values in self.arrays.values():
            values.flags.writeable = False

    def _with(self, arrays: dict[str, Floats]) -> Self:
        """Return a copy with other samples."""
        record = copy.copy(self)
        record.arrays, record._drifts = arrays, {}
        record._protect()
        return record

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "dense": None, "_drifts": {}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._protect()

    def __copy__(self) -> Self:
        record = object.__new__(type(self))
        record.__dict__.update(self.__dict__)
        return record

    def __deepcopy__(self, memo: Any) -> Self:
        # Only the list of events can change.
        record = copy.copy(self)
        record.events = list(record.events)
        return record

    def __len__(self) -> int:
        return len(self.arrays["time"])

    @overload
    def __getitem__(self, index: int) -> State: ...
    @overload
    def __getitem__(self, index: str) -> Track: ...
    @overload
    def __getitem__(self, index: slice | Sequence[int] | npt.NDArray[Any]) -> Self: ...
    def __getitem__(self, index: Any) -> State | Self | Track:
        if isinstance(index, str):
            body = self.context.index(index)
            return Track(self.context.names[body], self.time, *(getattr(self, name)[:, body] for name in PARTS))
        if isinstance(index, slice) or np.ndim(index):
            samples = index if isinstance(index, slice) else self._selected(index)
            return self._with({name: np.ascontiguousarray(values[samples]) for name, values in self.arrays.items()})
        return wrap(sample(self.arrays, index), self.context)

    def _selected(self, index: Any) -> npt.NDArray[np.intp]:
        """Return the indices of samples from a list of indices or a mask; one without order is refused."""
        selected: npt.NDArray[np.intp] = np.arange(len(self))[np.asarray(index, dtype=None if len(index) else np.intp)]
        steps = np.diff(selected) if selected.ndim == 1 else np.zeros(1)
        if not ((steps > 0).all() or (steps < 0).all()):
            expected = "expected a list of distinct indices in the order of time or against it, or a mask (K,)"
            raise InvalidInput(f"the index of samples is {index!r}; {expected}")
        return selected

    def __iter__(self) -> Iterator[State]:
        return (self[k] for k in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Record):
            return NotImplemented
        names = ("parameters", "stop_reason", "events", "switched_off", "statistics", "system")
        return (
            all(getattr(self, name) == getattr(other, name) for name in names)
            and self.arrays.keys() == other.arrays.keys()
            and all(np.array_equal(values, other.arrays[name]) for name, values in self.arrays.items())
            and np.array_equal(self.invariants, other.invariants)
        )

    __hash__ = None  # type: ignore[assignment]

    @overload
    def __call__(self, time: float | str) -> State: ...
    @overload
    def __call__(self, time: Sequence[float] | npt.NDArray[Any]) -> Samples: ...
    def __call__(self, time: Any) -> State | Samples:
        """Return the state at any time of a run with ``dense=True``; see :class:`fullbody.record.Dense`.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 10.0, output=10.0, dense=True)
        >>> run(3.7).position.shape, run([1.0, 2.0]).position.shape
        ((2, 3), (2, 2, 3))
        """
        return self.continuous()(time)

    def continuous(self) -> Dense:
        """Return the continuous solution, or raise an error if the run keeps none."""
        if self.dense is None:
            raise InvalidInput("this run keeps no continuous solution; integrate with dense=True")
        return self.dense

    def states(self, times: Any, what: str = "time") -> dict[str, Floats]:
        """Return the states at times of the run, in numbers of the system's units.

        Parameters
        ----------
        times : array_like or Quantity, (K,)
            Any times of a run with ``dense=True``; otherwise times of samples, and others are refused.
        what : str
            What errors call a time.

        Returns
        -------
        dict of ndarray
            ``position``, ``velocity`` and ``spin`` (K, N, 3), ``attitude`` (K, N, 4).

        Raises
        ------
        InvalidInput
            For a time that the run does not have.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.integrate(state, 10.0, output=1.0).states([2.0, 5.0])["attitude"].shape
        (2, 2, 4)
        """
        values = np.atleast_1d(self.context.units.strip(times, "time", what))
        if values.ndim != 1:
            raise InvalidInput(f"{what} has shape {values.shape}; expected (K,)")
        if self.dense is not None:
            return self.dense.states(values, what)
        index = self.indices(values, what)
        return {name: self.arrays[name][index] for name in PARTS}

    def indices(self, times: Floats, what: str = "time") -> npt.NDArray[np.intp]:
        """Return the indices of the samples at times (K,), which are numbers in the system's units."""
        samples = self.arrays["time"]
        order = np.argsort(samples, kind="stable")
        nearest = np.minimum(np.searchsorted(samples, times, sorter=order), len(samples) - 1)
        index = order[nearest] if len(samples) else np.full(len(times), -1)
        missing = times[samples[index] != times] if len(samples) else times
        if missing.size:
            expected = "expected the time of a sample, or integrate with dense=True"
            raise InvalidInput(f"{what} is {self.context.units.attach(missing[0], 'time')}, of no sample; {expected}")
        return index

    time = Column("Times (K,).", "time", "time")
    position = Column("Positions of the centres (K, N, 3), inertial frame.", "position", "length")
    velocity = Column("Velocities of the centres (K, N, 3), inertial frame.", "velocity", "velocity")
    attitude = Numbers("Unit quaternions (K, N, 4), ``[w, x, y, z]``.", "attitude")
    spin = Column("Angular velocities (K, N, 3), body frames.", "spin", "spin")
    energy = Column("Total energy (K,).", "energy", "energy", 0)
    translational_energy = Column("Kinetic energy of the centres (K,).", "energy", "energy", 1)
    rotational_energy = Column("Kinetic energy of the spins (K,).", "energy", "energy", 2)
    potential_energy = Column("Potential energy (K,), negative.", "energy", "energy", 3)
    angular_momentum = Column(
        "Total angular momentum (K, 3) about the origin, inertial.", "angular_momentum", "angular momentum"
    )

    @property
    def work(self) -> dict[str, Array]:
        """Work (K,) of each external force since the start of the run, by its name.

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
        return self._by_force("work", "energy")

    impulse = Attribute[dict[str, Array]](
        lambda run: run._by_force("impulse", "momentum"),
        "Impulse (K, 3) of each external force since the start of the run, by its name.",
    )
    angular_impulse = Attribute[dict[str, Array]](
        lambda run: run._by_force("angular_impulse", "angular momentum"),
        "Angular impulse (K, 3) of each external force since the start of the run, by its name.",
    )

    def _by_force(self, name: str, dimension: str) -> dict[str, Array]:
        attach = self.context.units.attach
        forces = enumerate(self.context.forces)
        return ByName({force: attach(self.arrays[name][:, k], dimension) for k, force in forces})

    @property
    def start(self) -> Invariants:
        """Time, energy and angular momentum at the start of the whole run, whether it was recorded or not."""
        return conserved.named(self.invariants, self.context.units)

    @property
    def energy_drift(self) -> Floats:
        """Change of the total energy since the start of the run (K,), relative to its value there, or absolute if that
        is zero.

        The work of external forces is subtracted, so that the drift is the error of the integration.
        """
        return self._drift("energy_drift")

    @property
    def energy_drift_orbital(self) -> Floats:
        """Change of the total energy since the start of the run (K,), relative to abs(potential + translational) there.

        The energy of a fast spin can hide the error of the orbit in :attr:`energy_drift`. It is absolute without an
        orbit.
        """
        return self._drift("energy_drift_orbital")

    @property
    def angular_momentum_drift(self) -> Floats:
        """Length of the change of the angular momentum since the start of the run (K,), relative to its length there.

        The angular impulse of external forces is subtracted. The drift is absolute if the length at the start is zero.
        """
        return self._drift("angular_momentum_drift")

    def _drift(self, name: str) -> Floats:
        if name not in self._drifts:
            drift = conserved.drift(name, self.invariants, self.arrays)
            drift.flags.writeable = False
            self._drifts[name] = drift
        return self._drifts[name]

    is_differentiated = Attribute[bool](lambda run: "transition" in run.arrays, "Whether the run has derivatives.")
    tangent_units = columns.tangent_units
    transition = columns.transition
    sensitivity = columns.sensitivity
    megno = columns.megno
    lyapunov = columns.lyapunov
    fast_lyapunov = columns.fast_lyapunov

    def elements(self, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> KeplerElements[Array]:
        """Return the osculating elements of one body about another, with arrays (K,), in the frame of the system.

        Parameters
        ----------
        mu : float or Quantity, optional
            The gravitational parameter; by default G times the sum of the two masses.
        body, about : int or str
            Indices in the system, or names.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.integrate(state, 10.0, output=1.0).elements().e.shape
        (11,)
        """
        units = self.context.units
        first, second = self.context.pair(body, about)
        number = self.context.mu(first, second) if mu is None else units.number(mu, "mu", "mu")
        r, v = (self.arrays[name][:, first] - self.arrays[name][:, second] for name in ("position", "velocity"))
        a, e, *angles = (np.ascontiguousarray(column) for column in _core.cartesian_to_elements(r, v, number).T)
        elements = [units.attach(a, "length"), e, *(units.attach(angle, "angle") for angle in angles)]
        return computed(elements, self.context.frame)


def joined(forward: _R, backward: _R) -> _R:
    """Return the record with the samples of one forward and one backward from the same start, without events."""
    # A record without samples keeps no derivatives.
    source, following = forward if len(forward) else backward, forward.arrays
    arrays = {name: np.concatenate([a[::-1], following.get(name, a[:0])]) for name, a in backward.arrays.items()}
    record = source._with(arrays)
    counts = (astuple(item.statistics) for item in (forward, backward))
    record.statistics = Statistics(*map(sum, zip(*counts, strict=True)))
    record.events, record.dense = [], None
    return record
