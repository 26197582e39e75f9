"""Lines of a text file, with errors that name file and line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

from ..base.atomic import content
from ..errors import InvalidInput


def read_lines(path: Any) -> list[str]:
    """The lines of a file.

    Raises
    ------
    FileNotFoundError, InvalidInput
        The latter for a file that is not text.
    """
    try:
        return content(path).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{path} is not a text file: {error}") from error


@contextmanager
def naming(path: Any) -> Iterator[None]:
    """A context in which errors about the content of a file name it."""
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error


def fail(path: Any, line: int | None, message: str) -> NoReturn:
    """Raise :class:`fullbody.InvalidInput` for a line, counted from one."""
    where = f"{path}" if line is None else f"{path}, line {line}"
    raise InvalidInput(f"{where}: {message}")


def number(path: Any, line: int, text: str, what: str) -> float:
    """A finite number of a line."""
    try:
        value = float(text)
    except ValueError:
        fail(path, line, f"{what} is {text!r}; expected a number")
    if value != value or value in (float("inf"), float("-inf")):
        fail(path, line, f"{what} is {text!r}; expected a finite number")
    return value


def positive(path: Any, line: int, text: str, what: str) -> float:
    """A finite number above zero of a line."""
    value = number(path, line, text, what)
    if value <= 0.0:
        fail(path, line, f"{what} is {text!r}; expected a number above zero")
    return value


def not_negative(path: Any, line: int, text: str, what: str) -> float:
    """A finite number of a line, zero or above."""
    value = number(path, line, text, what)
    if value < 0.0:
        fail(path, line, f"{what} is {text!r}; expected a number, zero or above")
    return value
