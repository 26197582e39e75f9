"""Functions that the core calls, and the exceptions that they raise."""

from __future__ import annotations

from itertools import count
from typing import Any

#: The number of errors that a call can keep; their answers stay below this number.
_ANSWERS = 2**30


class Call:
    """A C function: its address, the address of its data, the object that keeps both alive, and errors raised in it.

    The function may run in many threads at once. If a Python function raises an error, the C function returns a number
    that belongs to this error alone, by which the error is found again wherever the number arrives.
    """

    def __init__(self, address: int, data: int, keep: Any, success: int = 0) -> None:
        self.address, self.data, self.keep, self.success = address, data, keep, success
        self._raised: dict[int, BaseException] = {}
        self._count = count()

    def kept(self, error: BaseException) -> int:
        """Keep an error and return the number that stands for it."""
        answer = next(self._count) % _ANSWERS + 1
        self._raised[answer] = error
        return answer

    def raised(self, answer: int | None) -> BaseException | None:
        """Return the error for which a number stands, if there is one, and forget it."""
        return None if answer is None else self._raised.pop(answer, None)

    def core_arguments(self) -> tuple[int, int, int, Any]:
        """Return the function in the form that the core takes."""
        return (self.address, self.data, self.success, self.keep)

    def is_lost(self, answer: int | None) -> bool:
        """Return whether a number without an error is one that no Python function returns, as after Ctrl-C in it."""
        return self.success != 0 and answer is not None
