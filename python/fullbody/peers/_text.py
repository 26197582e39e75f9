"""Reading of text files of numbers, with errors that name file and line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

from ..base.atomic import content
from ..errors import InvalidInput

#: The kinds of numbers in the words of error messages.
NUMBER, POSITIVE, NOT_NEGATIVE = "a number", "a number above zero", "a number, zero or above"


@contextmanager
def naming(path: Any) -> Iterator[None]:
    """Context manager that makes errors about the content of a file name the file."""
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error


class Text:
    """The lines of a file, numbered from one.

    Raises
    ------
    FileNotFoundError, InvalidInput
        If there is no such file, or if it is not text.
    """

    def __init__(self, path: Any) -> None:
        self.path = path
        try:
            self.lines = content(path).decode("utf-8-sig").splitlines()
        except UnicodeDecodeError as error:
            raise InvalidInput(f"{path} is not a text file: {error}") from error

    def fail(self, line: int | None, message: str) -> NoReturn:
        """Raise :class:`fullbody.errors.InvalidInput` for a line, or for the whole file."""
        where = f"{self.path}" if line is None else f"{self.path}, line {line}"
        raise InvalidInput(f"{where}: {message}")

    def number(self, line: int, text: str, what: str, kind: str = NUMBER) -> float:
        """Return a finite number of a line, which must be of one of the three kinds."""
        try:
            value = float(text)
        except ValueError:
            self.fail(line, f"{what} is {text!r}; expected a number")
        if not math.isfinite(value):
            self.fail(line, f"{what} is {text!r}; expected a finite number")
        if (kind == POSITIVE and value <= 0.0) or (kind == NOT_NEGATIVE and value < 0.0):
            self.fail(line, f"{what} is {text!r}; expected {kind}")
        return value
