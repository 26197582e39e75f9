"""Text files of numbers, with errors that name file and line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

from ..base.atomic import content
from ..base.limits import Limits
from ..errors import InvalidInput

NUMBER = Limits(text="a finite number")
POSITIVE = Limits(above=0.0, text="a number above zero")
NOT_NEGATIVE = Limits(least=0.0, text="a number, zero or above")


def refuse_underscores(text: str) -> str:
    """Return a text, or raise a ValueError if it has an underscore, which Python accepts between digits."""
    if "_" in text:
        raise ValueError
    return text


@contextmanager
def naming(path: Any) -> Iterator[None]:
    """Return a context manager that puts the name of a file before errors about its content."""
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error


class Text:
    """The lines of a file, numbered from one."""

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

    def number(self, line: int | None, text: str, what: str, limits: Limits = NUMBER) -> float:
        """Return the number that a text states, after checking that it is within limits."""
        expected = "a number"
        with suppress(ValueError):
            value = float(refuse_underscores(text))
            expected = limits.text if math.isfinite(value) else NUMBER.text
            if limits.contain(value):
                return value
        self.fail(line, f"{what} is {text!r}; expected {expected}")

    def whole_number(self, line: int, text: str, what: str, least: int = 0) -> int:
        """Return the whole number that a text states, after checking that it is not below ``least``."""
        with suppress(ValueError):
            if (value := int(refuse_underscores(text))) >= least:
                return value
        self.fail(line, f"{what} is {text!r}; expected a whole number from {least} on")

    def words(self) -> list[tuple[int, list[str]]]:
        """Return the number and the words of each line that is not blank."""
        return [(k, words) for k, line in enumerate(self.lines, 1) if (words := line.split())]

    def expected(
        self, rows: list[tuple[int, list[str]]], k: int, sizes: tuple[int, ...], what: str
    ) -> tuple[int, list[str]]:
        """Return the line and the words of row ``k``, which has to exist with an allowed number of words."""
        if not rows:
            self.fail(None, f"the file is empty; expected {what}")
        if k >= len(rows):
            self.fail(len(self.lines), f"the file ends here; expected {what}")
        line, words = rows[k]
        if len(words) not in sizes:
            self.fail(line, f"the line has {len(words)} columns; expected {what}")
        return line, words
