"""Text files of numbers, with errors that name file and line, and the axes of the shapes that they give."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

import numpy as np

from ..base import rotations
from ..base.atomic import content
from ..base.limits import Limits
from ..errors import InvalidInput, caution
from ..model.bodies import Body
from ..typing import Floats

NUMBER = Limits(text="a finite number")
POSITIVE = Limits(above=0.0, text="a number above zero")
NOT_NEGATIVE = Limits(least=0.0, text="a number, zero or above")
#: The angle in radians, and the distance relative to the size, by which a shape may differ from its principal frame
#: without a warning, since files are rounded.
_OFF = 1e-3


@contextmanager
def naming(path: Any) -> Iterator[None]:
    """Context manager that makes errors about the content of a file name the file."""
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

    def number(self, line: int, text: str, what: str, limits: Limits = NUMBER) -> float:
        """Return a number of a line, which must be within limits."""
        expected = "a number"
        with suppress(ValueError):
            value = float(text)
            expected = limits.text if math.isfinite(value) else NUMBER.text
            if limits.hold(value):
                return value
        self.fail(line, f"{what} is {text!r}; expected {expected}")


def along_body_axes(path: Any, bodies: Sequence[Body], attitude: Floats, spin: Floats) -> tuple[Floats, Floats]:
    """Return quaternions (N, 4) and spins (N, 3) of the body frames, from those of the axes of the given shapes."""
    attitude, spin = attitude.copy(), spin.copy()
    for k, body in enumerate(bodies):
        frame = body.working_frame
        if frame is None:
            continue
        spin[k] = rotations.matrices(frame.attitude) @ spin[k]
        attitude[k] = rotations.product(attitude[k], rotations.inverse(frame.attitude))
        angle = 2.0 * np.arctan2(np.linalg.norm(frame.attitude[1:]), abs(frame.attitude[0]))
        offset = float(np.linalg.norm(frame.position) / max(body.fitted_ellipsoid().semi_axes))
        if angle > _OFF or offset > _OFF:
            caution(
                f"{path}: the shape of {body.name or f'body {k}'} is not given in its principal frame: it is turned by "
                f"{np.degrees(angle):.3g} degrees, and its centre of mass is {offset:.3g} of its size from the origin; "
                "the state is that of its centre of mass, and the attitude that of its principal axes",
                UserWarning,
            )
    return attitude, spin
