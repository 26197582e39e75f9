"""The work on rows of a sweep (set up, integrate, measure), in this process or by the workers of an executor."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import islice
from queue import SimpleQueue
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .. import observables
from ..base.foreign import array_or_quantity
from ..base.units import is_quantity, need, refuse_masked
from ..errors import FullbodyError, InvalidInput, once
from ..model.state import State
from ..motion.system import System
from ..typing import Floats
from .members import integrate_many
from .parameters import RNG, is_storable, is_valid_name, stream

#: Row numbers with the parameters of the rows.
Rows: TypeAlias = Sequence[tuple[int, Mapping[str, Any]]]

#: Errors that end a single row; Ctrl-C ends the whole sweep.
_FAILURES = (Exception, SystemExit)
#: The largest number of chunks that an executor has at a time.
_MAX_FUTURES = 4096
#: The number of attempts at a chunk whose worker dies or fails for another reason.
_TRIES = 3

_BROKEN = (
    "the executor has lost a worker, by a crash or for want of memory, and takes no more work; expected to be called "
    "again with a new one"
)


@dataclass(frozen=True, slots=True)
class MeasuredValue:
    """Numbers (any shape) with the name of their unit, or a text."""

    value: Floats | str
    unit: str | None = None

    @property
    def missing(self) -> bool:
        """Whether the value is one nan without a unit, as a measure's ``None`` becomes: it suits any variable."""
        is_scalar = self.unit is None and not isinstance(self.value, str) and not self.value.shape
        return is_scalar and bool(np.isnan(self.value))


class Failure(NamedTuple):
    """The failure of a row: the name of the error, its text, and whether it came in setup, run or measure."""

    name: str
    text: str
    stage: str

    @classmethod
    def of(cls, error: BaseException, stage: str, part: str = "") -> Failure:
        """Make the failure of an error; the text begins with the part of the stage that failed, if it has several."""
        text = str(error).replace("\0", "\\0").encode("utf-8", "backslashreplace").decode()
        return cls(type(error).__name__, f"{part}: {text}" if part else text, stage)

    def combined(self, first: Failure | None) -> Failure:
        """Combine both failures into one with the name and the stage of the first, and both texts."""
        if first is None:
            return self
        return Failure(first.name, f"{first.text}; also {self.name} in {self.stage}: {self.text}", first.stage)


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a row: its values, or its failure."""

    row: int
    values: dict[str, MeasuredValue]
    failure: Failure | None = None


@dataclass(frozen=True, slots=True)
class Job:
    """The work on each row; see :func:`fullbody.sweep`."""

    setup: Callable[..., Any]
    measures: tuple[Callable[..., Any], ...]
    #: The end of the runs, under the name ``until`` or ``duration``.
    end: Mapping[str, Any]
    #: The other options of :func:`fullbody.integrate_many`.
    options: Mapping[str, Any]
    seed: int | None
    with_rng: bool


@dataclass(frozen=True, slots=True)
class Observable:
    """The measure that is an observable of :mod:`fullbody.observables`, given by its name."""

    name: str

    def __call__(self, run: Any) -> Any:
        """Return the result, under the observable's name if it has no names of its own."""
        result = getattr(observables, self.name)(run)
        return result if hasattr(result, "as_dict") else {self.name: result}

    @property
    def __name__(self) -> str:
        return self.name


#: A function that keeps the outcomes of a chunk.
_Keep: TypeAlias = Callable[[list[Outcome]], None]


def unpacked_outcomes(packed: bytes, rows: Rows) -> list[Outcome]:
    """Return the outcomes of rows, of a job that was packed for another process."""
    with once():
        return outcomes_of(pickle.loads(packed), rows)


def work(job: Job, rows: Rows, outcomes: list[Outcome], report: Callable[[int], None] | None = None) -> None:
    """Work on rows and append their outcomes, which an interrupt leaves; report the number of finished runs."""
    members: dict[int, tuple[System, State]] = {}
    ends: dict[int, Any] = {}
    ((kind, end),) = job.end.items()
    for row, parameters in rows:
        try:
            ends[row] = _end(end, parameters)
            random = {} if job.seed is None or not job.with_rng else {RNG: stream(job.seed, row, 1)}
            member = job.setup(**parameters, **random)
            match member:
                case (System(), State()):
                    members[row] = member
                case _:
                    raise InvalidInput(f"the setup gives {member!r}; expected (system, state)")
        except _FAILURES as error:
            outcomes.append(Outcome(row, {}, Failure.of(error, "setup")))
    options = {**job.options, kind: [ends[row] for row in members]}
    progress = False if report is None else lambda done, *_: report(int(done))
    try:
        runs = integrate_many(list(members.values()), progress=progress, **options)
    except KeyboardInterrupt as interrupt:
        runs = getattr(interrupt, "runs", [])
        for row, run in zip(members, runs, strict=False):
            if run is not None and getattr(run, "stop_reason", None) != "interrupted":
                outcomes.append(_outcome(job, row, run))
        raise
    for row, run in zip(members, runs, strict=True):
        outcomes.append(_outcome(job, row, run))


def _end(until: Any, parameters: Mapping[str, Any]) -> Any:
    if callable(until) and not is_quantity(until):
        return until(**parameters)
    return parameters[until] if isinstance(until, str) and until in parameters else until


def _outcome(job: Job, row: int, run: Any) -> Outcome:
    """Return the outcome of a run, or of the error that ended it with the run so far."""
    failure = None
    if isinstance(run, BaseException):
        failure = Failure.of(run, "run")
        run = getattr(run, "run", None)
    if run is None:
        return Outcome(row, {}, failure)
    values: dict[str, MeasuredValue] = {}
    for index, measure in enumerate(job.measures):
        part = _measure_name(measure, index) if len(job.measures) > 1 else ""
        # A measure that fails does not affect the others.
        try:
            result = measure(run)
            result = result.as_dict() if hasattr(result, "as_dict") else result
            if not isinstance(result, Mapping):
                raise InvalidInput(f"measure gives {result!r}; expected a dict of names to numbers, arrays or texts")
        except _FAILURES as error:
            failure = Failure.of(error, "measure", part).combined(failure)
            continue
        for name, value in result.items():
            try:
                if not isinstance(name, str) or not is_valid_name(name):
                    raise InvalidInput(f"measure gives the name {name!r}; expected text without '/'")
                if name in values:
                    text = f"measure gives {name}, which a measure before it gives too"
                    raise InvalidInput(f"{text}; expected each name once")
                values[name] = _value(value, name)
            except _FAILURES as error:
                failure = Failure.of(error, "measure", part).combined(failure)
    return Outcome(row, values, failure)


def _measure_name(measure: Any, index: int) -> str:
    """Return the name of one of several measures, or its index if it has none."""
    while isinstance(measure, partial):
        measure = measure.func
    name = getattr(measure, "__name__", "")
    return name if name.isidentifier() else f"number {index}"


def _value(value: Any, name: str) -> MeasuredValue:
    if isinstance(value, str):
        if not is_storable(value):
            raise InvalidInput(f"measure gives {name} = {value!r}; expected text that UTF-8 has, without zeros")
        return MeasuredValue(value)
    refuse_masked(value, name)
    value = array_or_quantity(value, name)
    unit = str(value.unit) if is_quantity(value) else None
    numbers = np.asarray(np.nan if value is None else value.value if unit is not None else value)
    if numbers.dtype.kind not in "biuf":
        raise InvalidInput(f"measure gives {name} = {value!r}; expected numbers, an array of numbers, or one text")
    return MeasuredValue(np.array(numbers, dtype=np.float64), unit)


def compute(job: Job, chunks: Iterable[Rows], keep: _Keep, report: Callable[[int], None]) -> None:
    """Work on chunks in this process, one after another, and report how many runs of a chunk are done."""
    for rows in chunks:
        outcomes: list[Outcome] = []
        try:
            work(job, rows, outcomes, report)
        finally:
            if outcomes:
                keep(outcomes)


def outcomes_of(job: Job, rows: Rows) -> list[Outcome]:
    """Return the outcomes of rows."""
    outcomes: list[Outcome] = []
    work(job, rows, outcomes)
    return outcomes


def submit_all(executor: Any, job: Job, chunks: Iterable[Rows], keep: _Keep) -> None:
    """Submit chunks to an executor, and keep the outcomes of each once it is done."""
    if isinstance(executor, type) or not callable(getattr(executor, "submit", None)):
        raise InvalidInput(
            f"executor is {executor!r}; expected one with the interface of concurrent.futures, such as "
            "ProcessPoolExecutor(), or client.get_executor() of dask.distributed"
        )
    call = (
        partial(outcomes_of, job)
        if isinstance(executor, ThreadPoolExecutor)
        else partial(unpacked_outcomes, _packed(job))
    )
    waiting = iter(chunks)
    done: SimpleQueue[Future[list[Outcome]]] = SimpleQueue()
    futures: dict[Future[list[Outcome]], tuple[Rows, int]] = {}

    def submit(rows: Rows, tries: int) -> None:
        try:
            future = executor.submit(call, rows)
        except BrokenExecutor as error:
            raise FullbodyError(_BROKEN) from error
        except RuntimeError as error:
            raise FullbodyError(f"the executor takes no work: {error}; expected one that is not shut down") from error
        futures[future] = rows, tries
        future.add_done_callback(done.put)

    try:
        for rows in islice(waiting, _MAX_FUTURES):
            submit(rows, 1)
        while futures:
            future = done.get()
            rows, tries = futures.pop(future)
            error = CancelledError("it was called off") if future.cancelled() else future.exception()
            if error is None:
                keep(future.result())
                for next_rows in islice(waiting, 1):
                    submit(next_rows, 1)
            elif not isinstance(error, Exception):
                raise error
            elif tries < _TRIES:
                submit(rows, tries + 1)
            else:
                raise FullbodyError(
                    f"rows {rows[0][0]} to {rows[-1][0]} failed in {_TRIES} workers, the last time with "
                    f"{type(error).__name__}: {error}"
                ) from error
    finally:
        for future in futures:
            future.cancel()
        # Chunks that were done when another error occurred are kept.
        while not done.empty():
            future = done.get()
            if future in futures and not future.cancelled() and future.exception() is None:
                keep(future.result())


def _packed(job: Job) -> bytes:
    """Pack the job for other processes, with functions of notebooks and scripts in full."""
    with need("data", "a sweep by other processes"):
        import cloudpickle
    try:
        packed: bytes = cloudpickle.dumps(job)
    except Exception as error:
        raise InvalidInput(
            f"the sweep cannot be sent to other processes: {error}; expected functions that use no open files and the "
            "like"
        ) from error
    return packed
