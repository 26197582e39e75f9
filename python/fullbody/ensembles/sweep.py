"""Maps: measures of runs over parameters of their setup."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import observables
from ..base.arguments import normal_form, seed_of, suggestion
from ..base.kinds import function, whole_number
from ..base.progress import Progress, Report
from ..base.units import need
from ..base.version import version
from ..errors import FullbodyError, Interrupted, InvalidInput, caution, once
from ..events import Event
from ..motion.integration import differentiated, watched
from ..record.integrators import Integrator, Verner98
from ..record.times import end_arguments
from . import store as stores
from .dataset import FAILURE, dataset
from .members import check_options, thread_count
from .parameters import RNG, ParameterTable, tabulated
from .sources import described
from .work import Job, Observable, Outcome, compute, submit_all

if TYPE_CHECKING:
    import xarray

#: The chunk size for an executor's worker, the least one in this process, and the one per thread of this process.
_WORKER_CHUNK, _LEAST_CHUNK, _THREAD_CHUNK = 16, 64, 16


def sweep(
    setup: Callable[..., Any],
    parameters: Any,
    until: Any = None,
    *,
    duration: Any = None,
    measure: str | Callable[..., Any] | Sequence[str | Callable[..., Any]],
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
    rng: int | np.random.Generator | None = None,
    chunk: int | None = None,
    progress: Any = False,
) -> xarray.Dataset:
    """Compute a map: set up, integrate and measure runs for all values of some parameters.

    Parameters
    ----------
    setup : callable
        ``setup(**parameters) -> (system, state)``. An argument ``rng`` receives a ``numpy.random.Generator`` of the
        row's own, which depends only on the sweep's ``rng`` and the row's number. If it has a default value, nothing is
        drawn without the sweep's ``rng``.
    parameters : mapping, pandas.DataFrame, Paired, Draws, or a list of these
        A mapping of names to values (numbers, Quantities or texts) makes a grid with a dimension for each list of
        values. A table, or :func:`fullbody.ensembles.paired`, has one dimension along its rows;
        :func:`fullbody.ensembles.draws` has one along random draws. A list makes the product of its parts.
    until, duration : float, Quantity, text or callable
        The end of the runs or their length, exactly one of the two, as for :meth:`fullbody.System.integrate`; or the
        name of a parameter that is it, or a function that returns it, ``until(**parameters)``.
    measure : text, callable, or list of these
        The name of an observable of :mod:`fullbody.observables`, such as ``"libration"``; or ``measure(run) -> dict``
        of numbers, arrays of numbers of the same shape in all rows, or texts, each under the name of its variable; or a
        function that returns the result of an observable, whose ``as_dict()`` is taken. Entries that a row omits, or
        returns as ``None``, are nan there. If one measure of a list fails, the values of the others remain.
    output, integrator, events, dense, derivatives, chaos
        Options of :func:`fullbody.integrate_many`, for all runs; by default a run keeps its start and its end.
    executor : optional
        Anything with the interface of ``concurrent.futures``: ``ProcessPoolExecutor()``, ``client.get_executor()`` of
        dask.distributed, ``mpi4py.futures.MPIPoolExecutor()``. Functions of notebooks and scripts reach its workers by
        cloudpickle.
    threads : int, optional
        Number of threads of this process, by default one per core; or of each worker of the executor, by default one.
    store : str or Path, optional
        Where to keep the outcomes: a name that ends in ``.nc``, or a folder. A sweep that was interrupted for any
        reason continues from there when it is called again, and ends with the map of an uninterrupted one, bit for bit
        on a machine with the same vector instructions. See the notes.
    key : str, optional
        A text of your own, needed with a store, that stands for everything that the sweep uses and that the store does
        not compare. Change it whenever something of that kind changes, such as a file that the setup reads.
    rng : int or numpy.random.Generator, optional
        The seed of random numbers, needed if anything is drawn, or without a store a generator that draws the seed.
    chunk : int, optional
        Number of rows that are stored at a time and whose runs are in memory together; by default 16 with an executor,
        otherwise 64, or 16 per thread if that is more. The map does not depend on it.
    progress : bool, str or callable
        As in :func:`fullbody.integrate_many`, counting rows.

    Returns
    -------
    xarray.Dataset
        Variables over the dimensions of the parameters, whose values are its coordinates, with units in their
        attributes; those of arrays have further dimensions, ``name_0`` and so on. Beside what ``measure`` returns there
        are ``error``, the name of the first error of a row, empty for none; ``error_stage``, which is ``"setup"``,
        ``"run"`` or ``"measure"``; and ``error_text``, which contains all.

    Raises
    ------
    InvalidInput
        If the store holds another sweep, with the differences, and if a file of it is damaged or belongs to something
        else, with its name. Errors in single rows do not raise.
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
    Every file is written completely or not at all. A store refuses a sweep that differs from its own, and names what
    differs: the key, the seed, an option; the version of fullbody, numpy or Python; or the source text of the setup, of
    the measures, and of the functions and classes of your own modules that these name, and so on. Comments do not
    count, and of an enclosing function the variables that are numbers or texts do.

    A store does not notice changes of data files, environment variables, values of global variables, default values
    that are computed, compiled code, installed packages other than fullbody and numpy, functions without a source text,
    functions that are looked up by a text or passed in as values of other objects, and the state of a notebook. Change
    ``key`` with them.

    A sweep with other parameters extends a stored sweep if all rows of the stored one are among the new ones: with more
    values in a grid, more rows of a table, or another dimension. Random numbers follow from the row's number, so that a
    sweep with ``rng`` keeps its rows only if they remain the first ones, as with more draws.

    Examples
    --------
    >>> import fullbody
    >>> def setup(tilt):
    ...     system, state = fullbody.systems.kw4()
    ...     return system, state.rotated("Beta", [1, 0, 0], tilt)
    >>> found = fullbody.sweep(setup, {"tilt": [0.0, 0.1, 0.2]}, 20.0, measure="drift")
    >>> found.energy_drift.dims, bool((found.energy_drift < 1e-12).all())
    (('tilt',), True)
    """
    with need("data", "a sweep"):
        import xarray  # noqa: F401
    function(setup, "setup")
    if store is not None and isinstance(rng, np.random.Generator):
        raise InvalidInput("rng is a generator; expected a whole number with a store, which has to draw the same again")
    seed = None if rng is None else seed_of(rng)
    table = tabulated(parameters, seed)
    for name in (*table.columns, *table.dimensions):
        if name in FAILURE:
            raise InvalidInput(f"parameters has the name {name!r}, which is kept for what goes wrong with a row")
    end = end_arguments(until, duration)
    named = {name: value for name, value in end.items() if isinstance(value, str) and value in table.columns}
    check_options(integrator, output, {} if named else end)
    options = {
        "output": output,
        "integrator": Verner98() if integrator is None else integrator,
        "events": watched(events),
        "dense": bool(dense),
        "derivatives": False if (names := differentiated(derivatives)) is None else names or True,
        "chaos": bool(chaos),
    }
    functions = {"setup": setup, "measure": _measures(measure), **end}
    workers = None if threads is None and executor is None else thread_count(1 if threads is None else threads)
    job = Job(setup, functions["measure"], end, options | {"threads": workers}, seed, _draws(setup, table, seed))
    of_process = max(_LEAST_CHUNK, _THREAD_CHUNK * (workers or os.cpu_count() or 1))
    size = of_process if executor is None else _WORKER_CHUNK
    size = size if chunk is None else whole_number(chunk, "chunk")
    if store is not None and (not isinstance(key, str) or not key):
        raise InvalidInput(f"key is {key!r}; expected a text that is not empty, since there is a store")
    notes = {"title": "fullbody sweep", "fullbody_version": version()} | ({} if seed is None else {"rng": seed})
    with once(), Progress(progress) as report:
        if store is None:
            return _warned(_computed(job, table, {}, notes, size, executor, report, None))
        manifest = {
            "key": normal_form(str(key)),
            "version of fullbody": version(),
            "version of numpy": np.__version__,
            "version of Python": ".".join(map(str, sys.version_info[:2])),
            "rng": str(seed),
        } | described({**options, **functions})
        with stores.opened(store, manifest, table) as open_store:
            if open_store.map is None:
                computed = _computed(job, table, open_store.outcomes, notes, size, executor, report, open_store)
                return _warned(open_store.finish(computed))
            return _warned(open_store.map)


def _measures(measure: Any) -> tuple[Callable[..., Any], ...]:
    """Return measures as functions, of which some may be given by the names of observables."""
    measures = tuple(measure) if isinstance(measure, list | tuple) else (measure,)
    names = [name for name in observables.__all__ if name[0].islower()]
    for name in measures:
        if isinstance(name, str) and name not in names:
            raise InvalidInput(f"measure has {name!r}, which is no observable; {suggestion(name, names)}")
    if not measures or not all(isinstance(part, str) or callable(part) for part in measures):
        raise InvalidInput(f"measure is {measure!r}; expected a function, the name of an observable, or a list of them")
    return tuple(Observable(part) if isinstance(part, str) else part for part in measures)


def _computed(
    job: Job,
    table: ParameterTable,
    outcomes: dict[int, Outcome],
    notes: dict[str, Any],
    size: int,
    executor: Any,
    report: Report | None,
    open_store: Any,
) -> xarray.Dataset:
    """Compute all rows that have no outcome yet; an error has the map so far in its attribute ``dataset``."""
    failed = sum(outcome.failure is not None for outcome in outcomes.values())

    def show(runs: int = 0) -> None:
        """Report the rows that are done, and finished runs of a chunk that is not."""
        if report is not None:
            errors = f", {failed} with errors" if failed else ""
            report(len(outcomes) + runs, len(table), f"{len(outcomes)} of {len(table)} rows{errors}")

    def keep(results: list[Outcome]) -> None:
        nonlocal failed
        results = sorted(results, key=attrgetter("row"))
        outcomes.update((outcome.row, outcome) for outcome in results)
        if open_store is not None:
            open_store.add(results)
        failed += sum(outcome.failure is not None for outcome in results)
        show()

    show()
    missing = [row not in outcomes for row in range(len(table))]
    ranges = (range(k, min(k + size, len(missing))) for k in range(0, len(missing), size))
    blocks = ([row for row in rows if missing[row]] for rows in ranges)
    tasks = ([(row, table.row(row)) for row in rows] for rows in blocks if rows)
    try:
        compute(job, tasks, keep, show) if executor is None else submit_all(executor, job, tasks, keep)
    except (KeyboardInterrupt, FullbodyError, OSError) as error:
        where = "in .dataset" if open_store is None else f"in {open_store.path} and in .dataset"
        done = f"{len(outcomes)} of {len(table)} rows are done, {where}"
        raised: Any = Interrupted(f"interrupted; {done}") if isinstance(error, KeyboardInterrupt) else error
        raised.dataset = dataset(table, outcomes.values(), notes)
        if raised is not error:
            raise raised from None
        error.add_note(done)
        raise
    return dataset(table, outcomes.values(), notes)


def _warned(dataset: xarray.Dataset) -> xarray.Dataset:
    """Return a map, after a warning if all of its rows have an error."""
    kinds, texts, stages = (dataset[name].values.ravel() for name in FAILURE)
    if all(kinds):
        rows = "the only row" if len(kinds) == 1 else f"all {len(kinds)} rows"
        caution(
            f"{rows} of the sweep ended with an error; that of the first is {kinds[0]} in {stages[0]}: {texts[0]}; the "
            "variables error, error_text and error_stage of the map have those of each row"
        )
    return dataset


def _arguments(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError):
        # Compiled functions may have no signature.
        return {}


def _draws(setup: Callable[..., Any], table: ParameterTable, seed: int | None) -> bool:
    """Return whether the setup receives random numbers, after a check of the names of its arguments."""
    arguments = _arguments(setup)
    rng = arguments.get(RNG)
    drawn = rng is not None and (seed is not None or rng.default is rng.empty)
    if drawn and seed is None:
        raise InvalidInput(f"rng is None, but the setup takes {RNG}; expected a whole number or a generator")
    if seed is not None and not (drawn or table.random):
        raise InvalidInput(f"rng is {seed!r}, but nothing is drawn; expected none")
    if not arguments or any(argument.kind is argument.VAR_KEYWORD for argument in arguments.values()):
        return drawn
    for name in table.columns:
        if name not in arguments:
            raise InvalidInput(f"parameters has {name!r}, which the setup does not take; {suggestion(name, arguments)}")
    for name, argument in arguments.items():
        needed = argument.default is argument.empty and argument.kind is not argument.VAR_POSITIONAL
        if needed and name not in table.columns and not (drawn and name == RNG):
            raise InvalidInput(f"parameters has no {name!r}, which the setup needs; it has {', '.join(table.columns)}")
    return drawn
