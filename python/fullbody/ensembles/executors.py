"""Execution of a sweep's chunks by the workers of an executor."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, CancelledError, Future, ThreadPoolExecutor
from functools import partial
from itertools import islice
from queue import SimpleQueue
from typing import Any

from ..base.units import need
from ..errors import FullbodyError, InvalidInput
from .work import Job, Outcome, Rows, work, work_sent

#: The number of chunks that an executor holds at a time.
_HELD = 4096
#: The number of attempts at a chunk whose worker dies or fails for another reason.
_TRIES = 3

_BROKEN = (
    "the executor has lost a worker, by a crash or for want of memory, and takes no more work; expected to be called "
    "again with a new one"
)

_Keep = Callable[[list[Outcome]], None]


def here(job: Job, chunks: Iterable[Rows], keep: _Keep, report: Callable[[int], None]) -> None:
    """Work on chunks in this process, one after another, and report how many runs of a chunk are done."""
    for rows in chunks:
        outcomes: list[Outcome] = []
        try:
            work(job, rows, outcomes, report)
        finally:
            if outcomes:
                keep(outcomes)


def _in_thread(job: Job, rows: Rows) -> list[Outcome]:
    outcomes: list[Outcome] = []
    work(job, rows, outcomes)
    return outcomes


def submitted(executor: Any, job: Job, chunks: Iterable[Rows], keep: _Keep) -> None:
    """Submit chunks to an executor, and keep the outcomes of each once it is done.

    An object that is not an executor, functions that cannot be sent to other processes, and dying workers are errors.
    """
    if isinstance(executor, type) or not callable(getattr(executor, "submit", None)):
        raise InvalidInput(
            f"executor is {executor!r}; expected one with the interface of concurrent.futures, such as "
            "ProcessPoolExecutor(), or client.get_executor() of dask.distributed"
        )
    call = partial(_in_thread, job) if isinstance(executor, ThreadPoolExecutor) else partial(work_sent, _packed(job))
    waiting = iter(chunks)
    done: SimpleQueue[Future[list[Outcome]]] = SimpleQueue()
    held: dict[Future[list[Outcome]], tuple[Rows, int]] = {}

    def submit(rows: Rows, tries: int) -> None:
        try:
            future = executor.submit(call, rows)
        except BrokenExecutor as error:
            raise FullbodyError(_BROKEN) from error
        except RuntimeError as error:
            raise FullbodyError(f"the executor takes no work: {error}; expected one that is not shut down") from error
        held[future] = rows, tries
        future.add_done_callback(done.put)

    try:
        for rows in islice(waiting, _HELD):
            submit(rows, 1)
        while held:
            future = done.get()
            rows, tries = held.pop(future)
            error = CancelledError("it was called off") if future.cancelled() else future.exception()
            if error is None:
                keep(future.result())
                for more in islice(waiting, 1):
                    submit(more, 1)
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
        for future in held:
            future.cancel()
        # Chunks that were done when another error occurred are kept.
        while not done.empty():
            future = done.get()
            if future in held and not future.cancelled() and future.exception() is None:
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
