"""Checks of the options of a run before it starts: output, events, autosave, progress."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..base.arguments import names_of, sequence
from ..base.atomic import as_path
from ..base.units import Units, from_text
from ..errors import InvalidInput
from ..events import Event
from ..record.integrators import Integrator

__all__ = ["Bar", "Tally", "autosaving", "check_for_all", "differentiated", "sampling", "watched"]


def sampling(output: Any, units: Units) -> Any:
    """Return the times to record in the form that the core takes: ``None``, ``"ends"``, a spacing, or times."""
    expected = "a spacing above zero, or times"
    if output is None or (isinstance(output, str) and output == "ends"):
        return output
    if isinstance(output, bool):
        raise InvalidInput(f"output is {output!r}; expected None, 'ends', {expected}")
    values = units.strip(output, "time", "output")
    if values.ndim > 1:
        raise InvalidInput(f"output has shape {values.shape}; expected a number or (K,)")
    if values.ndim == 1:
        return values
    if not values > 0.0:
        raise InvalidInput(f"output is {output!r}; expected {expected}")
    return float(values)


def check_for_all(integrator: Any, output: Any, until: Any) -> None:
    """Raise an error for options that are invalid for any system, whatever its units are."""
    if integrator is not None and not isinstance(integrator, Integrator):
        raise InvalidInput(f"integrator is {integrator!r}; expected one of fullbody's, such as Verner98(...)")
    for name, value in (("output", output), ("until", until)):
        if isinstance(value, str) and not (name == "output" and value == "ends"):
            from_text(value, name, "time")


def autosaving(autosave: Any) -> tuple[Path, float]:
    """Return the path to write to, and the number of seconds between two files."""
    try:
        where, every = autosave
        path, seconds = as_path(where), float(every)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"autosave is {autosave!r}; expected (path, seconds)") from error
    if not 0.0 <= seconds < 1e9:
        raise InvalidInput(f"seconds of autosave is {seconds!r}; expected a number from 0 to below 1e9")
    return path, seconds


def watched(events: Iterable[Event]) -> list[Event]:
    """Return the events as a list, or raise an error that shows what is not an event."""
    if isinstance(events, str):
        raise InvalidInput(f"events is {events!r}, which is text; expected a list of fullbody.events")
    return list(sequence(events, Event, "events", "a list of fullbody.events", "fullbody.events"))


def differentiated(derivatives: Any) -> list[str] | None:
    """Return the parameters by which a run is differentiated, or ``None`` if it is not differentiated."""
    if isinstance(derivatives, bool):
        return [] if derivatives else None
    return names_of(derivatives, "derivatives")


class Bar:
    """A progress bar as a context manager, which returns the function for the core to call, or ``None``."""

    _layout = "{l_bar}{bar}| {elapsed}<{remaining}{postfix}"

    def __init__(self, progress: Any) -> None:
        if not (progress is None or isinstance(progress, bool | str) or callable(progress)):
            raise InvalidInput(f"progress is {progress!r}; expected True or False, a label, or a function")
        self._progress = progress
        self._bar: Any = None
        self._end = ""

    def __enter__(self) -> Any:
        if not self._progress:
            return None
        if callable(self._progress):
            return self._progress
        from tqdm import TqdmWarning

        with warnings.catch_warnings():
            # Without ipywidgets tqdm draws a bar of text in Jupyter; its warning about this is suppressed.
            warnings.simplefilter("ignore", TqdmWarning)
            from tqdm.auto import tqdm

        label = self._progress if isinstance(self._progress, str) else None
        self._bar = tqdm(total=1.0, desc=label, bar_format=self._layout)
        return self._update

    def _update(self, start: float, time: float, end: float) -> None:
        # The rate is the system's time per second of the clock.
        rate = abs(time - start) / self._elapsed
        self._end = f"t = {end:.6g}, {rate:.3g}/s"
        self._show((time - start) / (end - start), f"t = {time:.6g}, {rate:.3g}/s")

    @property
    def _elapsed(self) -> float:
        return max(float(self._bar.format_dict["elapsed"]), 1e-9)

    def _show(self, part: float, text: str) -> None:
        self._bar.n = part
        self._bar.set_postfix_str(text, refresh=False)
        self._bar.refresh()

    def __exit__(self, kind: object, *_: object) -> None:
        if self._bar is not None:
            if kind is None:
                self._bar.n = 1.0
                self._bar.set_postfix_str(self._end, refresh=False)
            self._bar.close()


class Tally(Bar):
    """A progress bar for many runs, whose number may be unknown; it is called with the runs done and under way."""

    def __init__(self, progress: Any, total: int | None) -> None:
        super().__init__(progress)
        self._total = total
        if total is None:
            self._layout = "{desc}{elapsed}{postfix}"

    def __enter__(self) -> Any:
        report, total = super().__enter__(), self._total
        if report is None or self._bar is not None:
            return report
        return lambda done, under_way: report(done, total, under_way)

    def _update(self, done: int, under_way: float) -> None:  # type: ignore[override]
        of = "" if self._total is None else f"/{self._total}"
        self._end = f"{done}{of} runs, {(done + under_way) / self._elapsed:.3g}/s"
        self._show((done + under_way) / (self._total or 1), self._end)
