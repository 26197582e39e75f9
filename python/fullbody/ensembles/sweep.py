"""Maps: measures of runs over parameters of their setup."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.arguments import integer, suggestion
from ..base.progress import Progress, Report
from ..base.units import is_quantity, need
from ..base.version import version
from ..errors import FullbodyError, Interrupted, InvalidInput, caution
from ..events import Event
from ..motion.options import check_for_all, differentiated, watched
from ..record.integrators import Integrator, Verner98
from . import identity
from . import store as stores
from .dataset import FAILURE, dataset
from .executors import here, submitted
from .many import thread_count
from .parameters import RNG, Plan, chunks, columns_of, plan
from .work import Job, Outcome, ordered

if TYPE_CHECKING:
    import xarray

__all__ = ["sweep"]

#: The chunk size for an executor's worker, the least one in this process, and the number per thread in this process.
_OF_WORKER, _LEAST, _OF_THREAD = 16, 64, 16


def sweep(
    setup: Callable[..., Any],
    parameters: Any,
    until: Any,
    *,
    measure: Callable[..., Mapping[str, Any]] | Sequence[Callable[..., Mapping[str, Any]]],
    output: Any = "ends",
    integrator: Integrator | None = None,
    events: Iterable[Event] = (),
    dense: bool = False,
    derivatives: bool | Iterable[str] = False,
    chaos: bool = False,
    executor: Any = None,
    threads: int | None = None,
    store: Any = None,
    key: str | None = None,
    seed: Any = None,
    chunk: int | None = None,
    progress: Any = False,
) -> xarray.Dataset:
    """Compute a map: set up, integrate and measure runs for all values of some parameters.

    Parameters
    ----------
    setup : callable
        ``setup(**parameters) -> (system, state)``. An argument ``rng`` receives a ``numpy.random.Generator`` of the
        row's own, which depends only on ``seed`` and the row's number. If it has a default value and there is no seed,
        nothing is drawn.
    parameters : mapping, pandas.DataFrame, Paired, Draws, or a list of these
        A mapping of names to values makes a grid with a dimension for each list of values; a single value is a
        parameter without dimension. A table, or :func:`fullbody.ensembles.paired`, has one dimension along its rows;
        :func:`fullbody.ensembles.draws` has one along random draws. A list makes the product of its parts. Values are
        numbers, Quantities or texts.
    until : float, Quantity, text or callable
        The end of the runs, as for :meth:`fullbody.System.integrate`, or the name of the parameter that is the end, or
        a function that returns it, ``until(**parameters)``.
    measure : callable, or list of callables
        ``measure(run) -> dict`` of numbers, arrays of numbers of the same shape in all rows, or texts, each under the
        name of its variable. Numbers may be Quantities. Entries that a row omits, or returns as ``None``, are nan
        there. In a list each measure is called separately: if one fails, the values of the others remain.
    output, integrator, events, dense, derivatives, chaos
        Options of :func:`fullbody.integrate_many`, for all runs; by default a run keeps its start and its end.
    executor : optional
        Anything with the interface of ``concurrent.futures``: ``ProcessPoolExecutor()``, ``client.get_executor()`` of
        dask.distributed, ``mpi4py.futures.MPIPoolExecutor()``. Its workers take chunks of rows. Functions of notebooks
        and scripts reach other processes by cloudpickle.
    threads : int, optional
        Number of threads of this process, by default one per core; or of each worker of the executor, by default one.
    store : str or Path, optional
        Where to keep the outcomes: a name that ends in ``.nc``, or a folder. A sweep that was interrupted for any
        reason continues from there when it is called again, and ends with the map of an uninterrupted one, bit for bit
        on a machine with the same vector instructions. A sweep whose parameters include all rows of the stored one
        keeps those rows and computes the others. See the notes.
    key : str, optional
        A text that stands for the setup, the measure, the events, and an end that is a function. The store then
        compares this text instead of them, and it has to be changed whenever they change. It is needed if they use
        things that cannot be compared, such as open files, or functions found by ``eval``.
    seed : int or sequence of int, optional
        The seed of random numbers, needed if anything is drawn.
    chunk : int, optional
        Number of rows that are stored at a time and whose runs are in memory together; by default 16 with an executor,
        otherwise 64, or 16 per thread if that is more. The map does not depend on it.
    progress : bool, str or callable
        Progress bar, its title, or a function, as in :func:`fullbody.integrate_many`, which counts rows.

    Returns
    -------
    xarray.Dataset
        Variables over the dimensions of the parameters, whose values are its coordinates, with units in their
        attributes; those of arrays have further dimensions, ``name_0`` and so on. Numbers are floats. Beside what
        ``measure`` returns there are ``error``, the name of the error with which a row ended, empty for none;
        ``error_text``; and ``error_stage``: ``"setup"``, ``"run"`` or ``"measure"``. If several things fail, such as a
        run and a measure of it, ``error`` and ``error_stage`` are those of the first, and ``error_text`` contains all.

    Raises
    ------
    InvalidInput
        For invalid arguments; if the store holds another sweep, with the differences; and if a file of the store is
        damaged or belongs to something else, with its name. Errors in single rows do not raise.
    FullbodyError
        If another process has the store open, or the executor's workers die. Its attribute ``dataset`` is the map so
        far.
    Interrupted
        On Ctrl-C, with the map so far in the attribute ``dataset``. Rows that were not computed have the error
        ``"NotComputed"``.

    Warns
    -----
    InconsistentInput
        If every row has an error: the number of rows, and the first error.

    Notes
    -----
    If an error ends a run, the run up to there is measured as well, since a collision is a result. Then
    ``run.stop_reason`` is ``"unfinished"``, and the row has both its values and its error. Without these rows the map
    is ``map.where(map.error == "")``.

    A store ``map.nc`` is a folder of chunks, ``map.nc.parts``, until the sweep is complete, and then the map itself.
    Every file is written completely or not at all. A store refuses a sweep that differs from its own: in parameters,
    seeds, ends, output, integrators or events; in the version of fullbody, numpy or Python; and in the setup, the
    measure, or anything that these use: default values, attributes, variables of enclosing functions, and functions,
    classes and modules with all their content, unless they belong to an installed package. Objects that cannot be
    compared are refused, unless ``key`` stands for them. Changes of files and environment variables that functions read
    are not detected: change ``key`` with them.

    A sweep with other parameters extends a stored sweep if all rows of the stored one are among the new ones: with more
    values in a grid, more rows of a table, or another dimension. Random numbers follow from the row's number, so that a
    sweep with a seed keeps its rows only if they remain the first ones, as with more draws.

    Examples
    --------
    >>> import fullbody
    >>> def setup(tilt):
    ...     system, state = fullbody.systems.kw4()
    ...     return system, state.rotated("Beta", [1, 0, 0], tilt)
    >>> def drift(run):
    ...     return {"drift": abs(run.energy_drift[-1])}
    >>> found = fullbody.sweep(setup, {"tilt": [0.0, 0.1, 0.2]}, 20.0, measure=drift)
    >>> found.drift.dims, bool((found.drift < 1e-12).all())
    (('tilt',), True)
    """
    with need("data", "a sweep"):
        import xarray  # noqa: F401
    rows, job = _checked(
        setup,
        parameters,
        until,
        measure,
        output,
        integrator,
        events,
        dense,
        derivatives,
        chaos,
        executor,
        threads,
        seed,
    )
    size = _chunk_size(chunk, executor, job.threads)
    if key is not None and (store is None or not isinstance(key, str) or not key):
        raise InvalidInput(f"key is {key!r}; expected a text that is not empty, and only with a store")
    notes = {"title": "fullbody sweep", "fullbody_version": version()} | ({} if seed is None else {"seed": seed})
    if store is None:
        with Progress(progress) as report:
            return _warned(_computed(job, rows, {}, notes, size, executor, report, None))
    with stores.opened(store, _manifest(job, rows, key), rows) as kept:
        if kept.map is not None:
            return _warned(kept.map)
        with Progress(progress) as report:
            return _warned(kept.finish(_computed(job, rows, kept.outcomes(), notes, size, executor, report, kept)))


def _checked(
    setup: Any,
    parameters: Any,
    until: Any,
    measure: Any,
    output: Any,
    integrator: Any,
    events: Iterable[Event],
    dense: bool,
    derivatives: bool | Iterable[str],
    chaos: bool,
    executor: Any,
    threads: int | None,
    seed: Any,
) -> tuple[Plan, Job]:
    """Return the rows of a sweep and the job of each, or raise an error before any work."""
    if not callable(setup):
        raise InvalidInput(f"setup is {setup!r}; expected a function")
    measures = tuple(measure) if isinstance(measure, list | tuple) else (measure,)
    if not measures or not all(callable(one) for one in measures):
        raise InvalidInput(f"measure is {measure!r}; expected a function, or a list of functions")
    argument = _arguments(setup).get(RNG)
    rng = argument is not None and (seed is not None or argument.default is argument.empty)
    rows = plan(parameters, _seed(seed))
    for name in (*rows.columns, *rows.dimensions):
        if name in FAILURE:
            raise InvalidInput(f"parameters has the name {name!r}, which is kept for what goes wrong with a row")
    _check_names(setup, rows, rng)
    if rng and seed is None:
        raise InvalidInput(f"seed is None, but the setup takes {RNG}; expected a whole number")
    if seed is not None and not (rng or rows.random):
        raise InvalidInput(f"seed is {seed!r}, but nothing is drawn; expected none")
    width = None if threads is None and executor is None else thread_count(1 if threads is None else threads)
    check_for_all(integrator, output, None if isinstance(until, str) and until in rows.columns else until)
    names = differentiated(derivatives)
    wanted = False if names is None else tuple(names) or True
    return rows, Job(
        setup,
        measures,
        until,
        output,
        integrator,
        tuple(watched(events)),
        bool(dense),
        wanted,
        bool(chaos),
        width,
        seed,
        rng,
    )


def _chunk_size(chunk: Any, executor: Any, width: int | None) -> int:
    """Return the number of rows in a chunk."""
    usual = max(_LEAST, _OF_THREAD * (width or os.cpu_count() or 1)) if executor is None else _OF_WORKER
    size = usual if chunk is None else integer(chunk)
    if size is None or size < 1:
        raise InvalidInput(f"chunk is {chunk!r}; expected a whole number above zero")
    return size


def _computed(
    job: Job,
    rows: Plan,
    outcomes: dict[int, Outcome],
    notes: dict[str, Any],
    size: int,
    executor: Any,
    report: Report | None,
    kept: Any,
) -> xarray.Dataset:
    """Compute all rows that have no outcome yet and return the map.

    An error that ends the sweep has the map so far in its attribute ``dataset``.
    """
    count = _Count(report, len(rows), outcomes.values())

    def keep(found: list[Outcome]) -> None:
        found = ordered(found)
        outcomes.update((outcome.row, outcome) for outcome in found)
        if kept is not None:
            kept.add(found)
        count.add(found)

    missing = [row not in outcomes for row in range(len(rows))]
    tasks = ([(row, rows.row(row)) for row in numbers] for numbers in chunks(missing, size))
    try:
        here(job, tasks, keep, count.under_way) if executor is None else submitted(executor, job, tasks, keep)
    except (KeyboardInterrupt, FullbodyError, OSError) as error:
        where = "in .dataset" if kept is None else f"in {kept.path} and in .dataset"
        done = f"{len(outcomes)} of {len(rows)} rows are done, {where}"
        raised: Any = Interrupted(f"interrupted; {done}") if isinstance(error, KeyboardInterrupt) else error
        raised.dataset = dataset(rows, outcomes.values(), notes)
        if raised is not error:
            raise raised from None
        error.add_note(done)
        raise
    return dataset(rows, outcomes.values(), notes)


def _warned(found: xarray.Dataset) -> xarray.Dataset:
    """Return a map, after a warning if all of its rows have an error."""
    kinds, texts, stages = (found[name].values.ravel() for name in FAILURE)
    if all(kinds):
        rows = "the only row" if len(kinds) == 1 else f"all {len(kinds)} rows"
        caution(
            f"{rows} of the sweep ended with an error; that of the first is {kinds[0]} in {stages[0]}: {texts[0]}; the "
            "variables error, error_text and error_stage of the map have those of each row"
        )
    return found


def _arguments(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError):
        # Compiled functions may not tell their arguments.
        return {}


def _check_names(setup: Callable[..., Any], rows: Plan, rng: bool) -> None:
    """Raise an error for parameters that the setup does not take, and for missing ones."""
    arguments = _arguments(setup)
    if not arguments or any(a.kind is a.VAR_KEYWORD for a in arguments.values()):
        return
    for name in rows.columns:
        if name not in arguments:
            raise InvalidInput(f"parameters has {name!r}, which the setup does not take; {suggestion(name, arguments)}")
    for name, argument in arguments.items():
        needed = argument.default is argument.empty and argument.kind is not argument.VAR_POSITIONAL
        if needed and name not in rows.columns and not (rng and name == RNG):
            raise InvalidInput(f"parameters has no {name!r}, which the setup needs; it has {', '.join(rows.columns)}")


def _seed(seed: Any) -> Any:
    """Return a seed as numpy takes it: one integer or several."""
    if seed is None:
        return None
    many = isinstance(seed, list | tuple)
    numbers = [integer(number) for number in (seed if many else [seed])]
    if not numbers or any(number is None or number < 0 for number in numbers):
        raise InvalidInput(f"seed is {seed!r}; expected a whole number from zero, or a list of some")
    return numbers if many else numbers[0]


def _manifest(job: Job, rows: Plan, key: str | None) -> Mapping[str, str]:
    """Return digests of all that determines a sweep, by readable names. A key stands for all functions."""
    told = {
        "version of fullbody": version(),
        "version of numpy": np.__version__,
        "version of Python": ".".join(map(str, sys.version_info[:2])),
        "seed": repr(job.seed),
        "dimensions": identity.digest((dict(rows.dimensions), rows.labels)),
        "output": identity.digest(job.output),
        "integrator": identity.digest(Verner98() if job.integrator is None else job.integrator),
        **({"events": identity.digest(job.events)} if key is None else {"key": key}),
        "dense": repr(job.dense),
        **({"derivatives": repr(job.derivatives)} if job.derivatives else {}),
        **({"chaos": "True"} if job.chaos else {}),
    }
    told |= {f"parameter {name}": identity.digest(column) for name, column in columns_of(rows).items()}
    measures = {f"measure {place}" if place else "measure": one for place, one in enumerate(job.measures)}
    functions = {"setup": job.setup, **measures} if key is None else {}
    if key is None or is_quantity(job.until) or not callable(job.until):
        functions["until"] = job.until
    for name, thing in functions.items():
        for part, found in identity.parts(thing).items():
            told[f"{name} ({part})" if part else name] = found
    return told


class _Count:
    """The number of rows that are done and of those with errors, reported as they grow."""

    def __init__(self, report: Report | None, rows: int, outcomes: Iterable[Outcome]) -> None:
        self._report, self._rows, self._done, self._failed = report, rows, 0, 0
        self.add(outcomes)

    def add(self, outcomes: Iterable[Outcome]) -> None:
        """Count rows as done."""
        for outcome in outcomes:
            self._done += 1
            self._failed += outcome.failure is not None
        self.under_way(0)

    def under_way(self, runs: int) -> None:
        """Report finished runs of a chunk that is not done."""
        if self._report is not None:
            failed = f", {self._failed} with errors" if self._failed else ""
            self._report(self._done + runs, self._rows, f"{self._done} of {self._rows} rows{failed}")
