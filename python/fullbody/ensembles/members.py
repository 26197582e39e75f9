"""Many runs in one call, on all cores."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import repeat
from typing import Any, TypeAlias

import fullbody._core as _core

from ..base.kinds import instance, whole_number
from ..base.progress import Progress, Report
from ..base.units import from_text
from ..errors import Interrupted, InvalidInput, caution, once
from ..events import Event
from ..model.failures import explained
from ..model.state import State, strip
from ..motion.input_warnings import start_warnings
from ..motion.integration import Task, differentiated, integrator_of, watched
from ..motion.run import Run
from ..motion.system import System
from ..record.integrators import Integrator
from ..record.times import end_arguments, spacing_warning

Result: TypeAlias = Run | Exception

#: A larger number of threads than this is taken for a mistake.
_MAX_THREADS = 1024


def integrate_many(
    members: Iterable[tuple[System, State]],
    until: Any = None,
    *,
    duration: Any = None,
    output: Any = None,
    integrator: Integrator | Sequence[Integrator | None] | None = None,
    events: Iterable[Event] = (),
    dense: bool = False,
    progress: Any = False,
    threads: int | None = None,
    derivatives: bool | Iterable[str] = False,
    chaos: bool = False,
) -> list[Result]:
    """Integrate many systems, each from its state to a time, on all cores.

    Every run equals that of :meth:`fullbody.System.integrate` bit for bit, whatever the number of threads.

    Parameters
    ----------
    members : iterable of (System, State)
        Pairs of a system and its initial state. A generator is consumed only as members are needed.
    until, duration : float, Quantity, text with a unit, or a sequence of them
        The end of the runs or their length, exactly one of the two; a sequence has one for each member.
    output : None, "ends", float, Quantity or array_like
        Samples to keep, as in :meth:`fullbody.System.integrate`. They determine the memory that is used: ``"ends"``
        keeps two samples per run, and an empty array none.
    integrator : Integrator, or a sequence of them, optional
        Integrator of all runs, or one for each member; by default :class:`fullbody.Verner98`.
    events : iterable of Event
        Events to detect in every run. Functions of :class:`fullbody.events.Function` are called from other threads, one
        at a time.
    progress : bool, str or callable
        ``True`` or a title for a progress bar; or a function of (done, total, description), called about every 25 ms
        with the number of members done, which includes fractions of the running ones, the number of members
        (``None`` for a generator), and a text.
    threads : int, optional
        Number of threads; by default the number of cores that the process may use.
    dense, derivatives, chaos
        Options of :meth:`fullbody.System.integrate`.

    Returns
    -------
    list of Run or Exception
        The results in the order of the members. For a run that failed it is the error that
        :meth:`fullbody.System.integrate` would have raised, with the run so far in its attribute ``run`` (``None`` if
        the start is invalid): one member never stops the others.

    Raises
    ------
    Interrupted
        On Ctrl-C, within 100 ms; it is a KeyboardInterrupt. Its attribute ``runs`` is the list so far: complete runs,
        interrupted ones (see ``run.stop_reason``), and ``None`` for members that had not begun. Errors of the iterable
        and of the progress function stop the runs too, and have the same attribute.

    Warns
    -----
    InconsistentInput
        Once, for starts that are probably a mistake: their number, and the text of the first one.

    Notes
    -----
    If ``until``, ``duration`` or ``integrator`` is a sequence, a generator of members is first turned into a list.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> system, state = fullbody.systems.kw4()
    >>> turned = [(system, state.rotated("Beta", [0, 0, 1], angle)) for angle in (0.0, 0.2, 0.4)]
    >>> runs = fullbody.integrate_many(turned, 100.0, output=1.0)
    >>> [round(float(fullbody.observables.libration(run).amplitude), 2) for run in runs]
    [...]
    >>> runs[0] == system.integrate(state, 100.0, output=1.0)
    True
    """
    threads = None if threads is None else thread_count(threads)
    end = end_arguments(until, duration)
    # An empty list of parameters leaves the transition matrix.
    following = False if (names := differentiated(derivatives)) is None else names or True
    options = {"output": output, "events": watched(events), "dense": dense, "derivatives": following, "chaos": chaos}
    ensemble = _Ensemble(members, end, integrator, options)
    try:
        with once(), Progress(progress) as report:
            _core.integrate_many(ensemble.prepared(), ensemble.take, ensemble.counting(report), threads)
        ensemble.warn()
    except BaseException as error:
        # Members that the core never requested have an entry, too.
        ensemble.results += [None] * ((ensemble.total or 0) - len(ensemble.results))
        if isinstance(error, KeyboardInterrupt):
            interrupted = Interrupted(f"interrupted with {ensemble.count_done()} done; the runs so far are in .runs")
            interrupted.runs = ensemble.results
            raise interrupted from None
        with contextlib.suppress(AttributeError):
            error.runs = ensemble.results  # type: ignore[attr-defined]
        raise
    return ensemble.results


def check_options(integrator: Any, output: Any, end: dict[str, Any]) -> None:
    """Raise an error for options that are invalid for any system, whatever its units are."""
    if integrator is not None:
        instance(integrator, "integrator", Integrator, "one of fullbody's, such as Verner98(...)")
    for name, value in (("output", output), *end.items()):
        if isinstance(value, str) and not (name == "output" and value == "ends"):
            from_text(value, name, "time")


def thread_count(threads: Any) -> int:
    """Return a number of threads, or raise an error."""
    return whole_number(threads, "threads", 1, _MAX_THREADS, ", or None for all cores")


class _Ensemble:
    """An ensemble: its members and their results so far."""

    def __init__(self, members: Any, end: dict[str, Any], integrator: Any, options: dict[str, Any]) -> None:
        ((self._end, until),) = end.items()
        per_member = [value for value in (until, integrator) if _is_sequence(value)]
        try:
            self._members = members = list(members) if per_member and not hasattr(members, "__len__") else members
            iter(members)
        except TypeError as error:
            raise InvalidInput(f"members is {members!r}; expected an iterable of (system, state)") from error
        self.total = len(members) if hasattr(members, "__len__") else None
        for name, value in ((self._end, until), ("integrator", integrator)):
            if _is_sequence(value) and len(value) != self.total:
                expected = f"expected one, or {self.total}, one for each member"
                raise InvalidInput(f"{name} has {len(value)} values; {expected}")
        if isinstance(members, tuple | list) and members and isinstance(members[0], System):
            raise InvalidInput("members is one member; expected a list of them: [(system, state), ...]")
        check_options(None if _is_sequence(integrator) else integrator, options["output"], end)
        self._until, self._integrator, self._options = until, integrator, options
        self.results: list[Any] = []
        #: The number of members with invalid input, which are never run.
        self.refused = 0
        self._warnings: dict[int, str] = {}
        self._spacing: str | None = None

    def prepared(self) -> Iterator[Any]:
        """Yield the members as the core takes them; invalid ones receive their errors at once."""
        options = (value if _is_sequence(value) else repeat(value) for value in (self._until, self._integrator))
        for index, parts in enumerate(zip(self._members, *options, strict=False)):
            self.results.append(None)
            try:
                arguments = self._prepared(index, *parts)
            except Exception as error:
                # A traceback would keep all members alive in memory.
                self.results[index] = error.with_traceback(None)
                self.refused += 1
                continue
            yield arguments

    def _prepared(self, index: int, member: Any, until: Any, integrator: Integrator | None) -> Any:
        if not isinstance(member, tuple | list) or len(member) != 2:
            raise InvalidInput(f"member {index} is {member!r}; expected (system, state)")
        system, state = member
        instance(system, "system", System)
        integrator, start = integrator_of(integrator), strip(state, system.context)
        task = Task(system, integrator, start.time, **{self._end: until}, **self._options)
        tag = (index, task, start, integrator)
        options = (task.until, task.output, task.conditions, task.dense, task.following)
        return (tag, system.context.core, start, integrator._describe(system.context.units), *options)

    def take(self, tag: Any, record: Any, counts: Any, time: Any, error: BaseException | None) -> None:
        """Store the result of a member; without a record it was invalid at the start, or had not begun."""
        index, task, start, integrator = tag
        if record is not None:
            if (warning := next(start_warnings(task.context, start, integrator._tolerance), None)) is not None:
                self._warnings[index] = warning
            if (warning := spacing_warning(task.output, task.until - start.time, task.context.units)) is not None:
                self._spacing = warning
            run = task.run(record, counts)
            if error is None:
                self.results[index] = run
                return
            error = task.failed(error, run, time)
            if isinstance(error, Interrupted):
                self.results[index] = run
                raise KeyboardInterrupt
        elif error is not None:
            error = explained(error, task.context, start, " at the start")
        self.results[index] = error
        if error is not None and not isinstance(error, Exception):
            raise error

    def counting(self, report: Report | None) -> Callable[[int, float], Any] | None:
        """Return the function that the core calls with the number of members done and the sum of the fractions done of
        those that run.
        """
        if report is None:
            return None
        of = "" if self.total is None else f" of {self.total}"

        def count(done: int, parts: float) -> Any:
            done += self.refused
            return report(done + parts, self.total, f"{done}{of} runs")

        return count

    def count_done(self) -> str:
        """Return the number of members that are done."""
        of = "" if self.total is None else f" of {self.total}"
        done = [a for a in self.results if a is not None and getattr(a, "stop_reason", None) != "interrupted"]
        return f"{len(done)}{of} {'member' if (self.total or len(done)) == 1 else 'members'}"

    def warn(self) -> None:
        """Warn of starts and of a spacing that are probably mistakes."""
        if self._spacing is not None:
            caution(self._spacing)
        if self._warnings:
            first = min(self._warnings)
            count = f"the starts of {len(self._warnings)} of {len(self.results)} members are probably a mistake"
            caution(f"{count}; member {first}: {self._warnings[first]}")


def _is_sequence(value: Any) -> bool:
    """Return whether a value is a sequence with one entry for each member."""
    return isinstance(value, list | tuple) or getattr(value, "ndim", 0) == 1
