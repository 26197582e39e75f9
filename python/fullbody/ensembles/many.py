"""Many runs in one call, on all cores."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from itertools import repeat
from typing import Any, TypeAlias

from .. import _core
from ..base.arguments import integer, named_options
from ..errors import BodiesOverlap, Interrupted, InvalidInput, caution
from ..events import Event
from ..model.state import State
from ..motion.doubts import of_start
from ..motion.options import Tally, check_for_all, differentiated, watched
from ..motion.simulation import Run, System
from ..motion.task import Task, beginning
from ..record.integrators import Integrator

__all__ = ["integrate_many"]

Answer: TypeAlias = Run | Exception

#: More threads than any machine has cores are a mistake.
_MOST_THREADS = 1024


@named_options
def integrate_many(
    members: Iterable[tuple[System, State]],
    until: Any,
    output: Any = None,
    integrator: Integrator | Sequence[Integrator | None] | None = None,
    events: Iterable[Event] = (),
    dense: bool = False,
    progress: Any = False,
    threads: int | None = None,
    derivatives: bool | Iterable[str] = False,
    chaos: bool = False,
) -> list[Answer]:
    """Run many systems, each from its state to a time, on all cores.

    Every run equals that of :meth:`fullbody.System.integrate` bit for bit, whatever the number of threads.

    Parameters
    ----------
    members : iterable of (System, State)
        A generator is welcome: members are taken from it as they are needed.
    until : float, Quantity, text with a unit, or a sequence of them
        End of the runs, or of each member's.
    output : None, "ends", float, Quantity or array_like
        As in :meth:`fullbody.System.integrate`. What is kept is what takes memory: ``"ends"`` keeps two samples a run,
        and an empty array none.
    integrator : Integrator, or a sequence of them, optional
        :class:`fullbody.Verner98` unless given.
    events : iterable of Event
        What to watch for in every run. Functions of :class:`fullbody.events.Function` are called from other threads,
        one at a time.
    dense : bool
    progress : bool, str or callable
        ``True`` or a label for a progress bar; or a function of (done, total, under_way), called about every 25 ms: how
        many members are done, how many there are (``None`` for a generator), and how far those under way have come, in
        members.
    threads : int, optional
        As many as the process may run at once unless given.
    derivatives : bool or sequence of str
    chaos : bool
        As in :meth:`fullbody.System.integrate`.

    Returns
    -------
    list of Run or Exception
        In the order of the members. In place of a run that failed stands what :meth:`fullbody.System.integrate` would
        have raised, with the run so far in its ``.run`` (``None`` where the start is none): one member never stops the
        others.

    Raises
    ------
    InvalidInput
        For ``members``, ``events`` and ``threads`` that are none, and for sequences of another length than the members.
    Interrupted
        On Ctrl-C, within 100 ms; a KeyboardInterrupt. Its ``.runs`` is the list as far as it goes: whole runs,
        interrupted ones (``run.stop_reason`` tells), and ``None`` for members that had not begun. Errors of the
        iterable and of the progress function stop the runs too, and have the same ``.runs``.

    Warns
    -----
    InconsistentInput
        Once, for starts that are probably a mistake: how many there are, and what the first one is.

    Notes
    -----
    Where ``until`` or ``integrator`` is a sequence, a generator of members is made a list first.

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
    many = _Many(members, until, output, integrator, watched(events), dense, differentiated(derivatives), chaos)
    try:
        with Tally(progress, many.total) as report:
            counted = report and (lambda done, under_way: report(done + many.refused, under_way))
            _core.integrate_many(many.given(), many.take, counted, threads)
        many.warn()
    except BaseException as error:
        many.fill()
        if isinstance(error, KeyboardInterrupt):
            interrupted = Interrupted(f"interrupted with {many.whole()} done; the runs so far are in .runs")
            interrupted.runs = many.answers
            raise interrupted from None
        with contextlib.suppress(AttributeError):
            error.runs = many.answers  # type: ignore[attr-defined]
        raise
    return many.answers


def thread_count(threads: Any) -> int:
    """A number of threads, or an error."""
    number = integer(threads)
    if number is None or not 1 <= number <= _MOST_THREADS:
        raise InvalidInput(
            f"threads is {threads!r}; expected a whole number from 1 to {_MOST_THREADS}, or None for all cores"
        )
    return number


class _Many:
    """The members on their way to their answers."""

    def __init__(
        self,
        members: Any,
        until: Any,
        output: Any,
        integrator: Any,
        events: list[Event],
        dense: bool,
        derivatives: list[str] | None,
        chaos: bool,
    ) -> None:
        each = [value for value in (until, integrator) if _is_sequence(value)]
        try:
            self._members = members = list(members) if each and not hasattr(members, "__len__") else members
            iter(members)
        except TypeError as error:
            raise InvalidInput(f"members is {members!r}; expected an iterable of (system, state)") from error
        self.total = len(members) if hasattr(members, "__len__") else None
        for name, value in (("until", until), ("integrator", integrator)):
            if _is_sequence(value) and len(value) != self.total:
                raise InvalidInput(
                    f"{name} has {len(value)} values; expected one, or {self.total}, one for each member"
                )
        if isinstance(members, tuple | list) and members and isinstance(members[0], System):
            raise InvalidInput("members is one member; expected a list of them: [(system, state), ...]")
        check_for_all(None if _is_sequence(integrator) else integrator, output, until)
        self._until, self._integrator = until, integrator
        self._output, self._events, self._dense = output, events, dense
        self._following = (False if derivatives is None else derivatives or True, chaos)
        self.answers: list[Any] = []
        #: How many were no members at all.
        self.refused = 0
        self._doubts: dict[int, str] = {}

    def given(self) -> Iterator[Any]:
        """The members as the core takes them; those that are none have their errors at once."""
        until, integrator = (
            value if _is_sequence(value) else repeat(value) for value in (self._until, self._integrator)
        )
        for index, parts in enumerate(zip(self._members, until, integrator, strict=False)):
            self.answers.append(None)
            try:
                given = self._prepared(index, *parts)
            except Exception as error:
                # A traceback would keep all members alive.
                self.answers[index] = error.with_traceback(None)
                self.refused += 1
                continue
            yield given

    def _prepared(self, index: int, member: Any, until: Any, integrator: Integrator | None) -> Any:
        if not isinstance(member, tuple | list) or len(member) != 2:
            raise InvalidInput(f"member {index} is {member!r}; expected (system, state)")
        system, state = member
        start, integrator, described = beginning(system, state, integrator)
        task = Task(system, integrator, start.time, until, self._output, self._events, self._dense, *self._following)
        tag = (index, task, system, start, integrator)
        options = (task.until, task.output, task.conditions, task.dense, task.following)
        return (tag, system._core, start, described, *options)

    def take(self, tag: Any, record: Any, counts: Any, time: Any, error: BaseException | None) -> None:
        """Keep what became of a member."""
        index, task, system, start, integrator = tag
        if record is not None:
            if (doubt := next(of_start(system, start, integrator._tolerance), None)) is not None:
                self._doubts[index] = doubt
            run = task.run(Run, record, counts)
            if error is None:
                self.answers[index] = run
                return
            error = task.failed(error, run, time)
            if isinstance(error, Interrupted):
                self.answers[index] = run
                raise KeyboardInterrupt
        elif isinstance(error, BodiesOverlap):
            error = system._explained(error, start, " at the start")
        self.answers[index] = error
        if error is not None and not isinstance(error, Exception):
            raise error

    def fill(self) -> None:
        """Have a place for every member, also of those that were never asked for."""
        self.answers += [None] * ((self.total or 0) - len(self.answers))

    def whole(self) -> str:
        """How many members are done."""
        of = "" if self.total is None else f" of {self.total}"
        done = [a for a in self.answers if a is not None and getattr(a, "stop_reason", None) != "interrupted"]
        return f"{len(done)}{of} {'member' if (self.total or len(done)) == 1 else 'members'}"

    def warn(self) -> None:
        """Warn of doubtful starts."""
        if self._doubts:
            first = min(self._doubts)
            count = f"the starts of {len(self._doubts)} of {len(self.answers)} members are doubtful"
            caution(f"{count}; member {first}: {self._doubts[first]}")


def _is_sequence(value: Any) -> bool:
    """Whether a value is one for each member."""
    return isinstance(value, list | tuple) or getattr(value, "ndim", 0) == 1
