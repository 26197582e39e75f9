"""The options of a run, checked before it starts: output, events, autosave, progress."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..base.arguments import sequence
from ..base.atomic import as_path
from ..base.units import Units
from ..errors import InvalidInput
from ..events import Event

__all__ = ["Bar", "autosaving", "sampling", "watched"]


def sampling(output: Any, units: Units) -> tuple[float | None, Any]:
    """Spacing or times."""
    if output is None:
        return None, None
    if isinstance(output, bool):
        raise InvalidInput(f"output is {output!r}; expected None, a spacing above zero, or times")
    values = units.strip(output, "time", "output")
    if values.ndim > 1:
        raise InvalidInput(f"output has shape {values.shape}; expected a number or (K,)")
    if values.ndim == 1:
        return None, values
    if not values > 0.0:
        raise InvalidInput(f"output is {output!r}; expected a spacing above zero, or times")
    return float(values), None


def autosaving(autosave: Any) -> tuple[Path, float]:
    """Where to write and how often."""
    try:
        where, every = autosave
        path, seconds = as_path(where), float(every)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"autosave is {autosave!r}; expected (path, seconds)") from error
    if not 0.0 <= seconds < 1e9:
        raise InvalidInput(f"seconds of autosave is {seconds!r}; expected a number from 0 to below 1e9")
    return path, seconds


def watched(events: Iterable[Event]) -> list[Event]:
    """The events as a list."""
    if isinstance(events, str):
        raise InvalidInput(f"events is {events!r}, which is text; expected a list of fullbody.events")
    return list(sequence(events, Event, "events", "a list of fullbody.events", "fullbody.events"))


class Bar:
    """A progress bar as a context; gives what the core is to call, or ``None``."""

    def __init__(self, progress: Any) -> None:
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
            # In Jupyter without ipywidgets the bar is one of text, which needs no warning.
            warnings.simplefilter("ignore", TqdmWarning)
            from tqdm.auto import tqdm

        layout = "{l_bar}{bar}| {elapsed}<{remaining}{postfix}"
        label = self._progress if isinstance(self._progress, str) else None
        self._bar = tqdm(total=1.0, desc=label, bar_format=layout)
        return self._update

    def _update(self, start: float, time: float, end: float) -> None:
        self._bar.n = (time - start) / (end - start)
        # The time of the system that passes in a second of the clock.
        rate = abs(time - start) / max(self._bar.format_dict["elapsed"], 1e-9)
        self._end = f"t = {end:.6g}, {rate:.3g}/s"
        self._bar.set_postfix_str(f"t = {time:.6g}, {rate:.3g}/s", refresh=False)
        self._bar.refresh()

    def __exit__(self, kind: object, *_: object) -> None:
        if self._bar is not None:
            if kind is None:
                self._bar.n = 1.0
                self._bar.set_postfix_str(self._end, refresh=False)
            self._bar.close()
