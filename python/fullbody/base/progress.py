"""Progress of long computations, shown by a bar or reported to a function of the caller."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeAlias

from ..errors import InvalidInput

#: A function of how much is done, how much there is (``None`` if that is unknown), and a description.
Report: TypeAlias = Callable[[float, float | None, str], Any]

_LAYOUT = "{l_bar}{bar}| {elapsed}<{remaining}, {rate_noinv_fmt}{postfix}"
_LAYOUT_WITHOUT_TOTAL = "{desc}: {elapsed}, {rate_noinv_fmt}{postfix}"


class Progress:
    """Context manager that returns the function by which a computation reports its progress, or ``None``.

    It is given ``True`` or a title for a progress bar, or a function of (done, total or ``None``, description).
    """

    def __init__(self, progress: Any) -> None:
        if not (progress is None or isinstance(progress, bool | str) or callable(progress)):
            raise InvalidInput(f"progress is {progress!r}; expected True or False, a title, or a function")
        self._progress = progress
        self._bar: Any = None

    def __enter__(self) -> Report | None:
        report: Report | None = self._progress if callable(self._progress) else self._show if self._progress else None
        return report

    def _show(self, done: float, total: float | None, description: str) -> None:
        if self._bar is None:
            self._bar = _bar(self._progress if isinstance(self._progress, str) else None, done, total)
        self._bar.n = done
        self._bar.set_postfix_str(description, refresh=False)
        self._bar.refresh()

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()


def _bar(title: str | None, done: float, total: float | None) -> Any:
    from tqdm import TqdmWarning

    with warnings.catch_warnings():
        # Without ipywidgets tqdm draws a bar of text in Jupyter; its warning about this is suppressed.
        warnings.simplefilter("ignore", TqdmWarning)
        from tqdm.auto import tqdm

    layout = _LAYOUT_WITHOUT_TOTAL if total is None else _LAYOUT
    return tqdm(total=total, initial=done, desc=title, unit="", unit_scale=True, bar_format=layout)


def over_time(report: Report | None) -> Callable[[float, float, float], Any] | None:
    """Return the function of (start, time, end) that the core calls, which reports the time that has passed."""
    if report is None:
        return None
    return lambda start, time, end: report(abs(time - start), abs(end - start), f"t = {time:.6g}")
