"""What can go wrong: one base class, and children that say what and when."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .run import Run

__all__ = [
    "BodiesOverlap",
    "ChartSingularity",
    "FullbodyError",
    "InconsistentInput",
    "Interrupted",
    "InvalidInput",
    "NotConverged",
    "PrecisionWarning",
    "StepSizeTooSmall",
]


class FullbodyError(Exception):
    """Base of all errors of this package.

    Attributes
    ----------
    run : Run or None
        Where an integration was cut short, what it had recorded until then.
    """

    run: Run | None = None


class InvalidInput(FullbodyError, ValueError):
    """An argument that describes nothing physical, has the wrong shape or the wrong unit."""


class InconsistentInput(UserWarning):
    """A warning: input to compute with that is hardly meant.

    Numbers given twice that differ a little, such as a period and a semi-major axis with the masses; a density of no
    asteroid; a body whose rotation is not stated.
    """


class BodiesOverlap(FullbodyError, RuntimeError):
    """Two bodies share interior points.

    Bodies count as touching, and not as overlapping, where their gap or depth is below 4e-15 times the sum of their
    longest semi-axes, which is about as far as rounding of attitudes and positions moves their surfaces. Of their
    thickness that is 1e-14 for compact bodies, and 2e-7 for discs of c/a = 1e-8 face to face. Where it is more than a
    thousandth (c/a below some 1e-12), bodies that nearly touch are refused as too thin to tell, with
    :class:`InvalidInput`.

    Attributes
    ----------
    bodies : tuple of str
        Their names.
    time : float
        When, in the system's units.
    """

    def __init__(self, message: str, bodies: tuple[str, str] = ("", ""), time: float = float("nan")) -> None:
        super().__init__(message, bodies, time)
        self.bodies = bodies
        self.time = time

    def __str__(self) -> str:
        return str(self.args[0])


class StepSizeTooSmall(FullbodyError, RuntimeError):
    """The error control asks for steps that no longer advance the time: a singularity.

    Attributes
    ----------
    time, step : float
        When, and the step asked for, in the system's units.
    """

    def __init__(self, message: str, time: float = float("nan"), step: float = float("nan")) -> None:
        super().__init__(message, time, step)
        self.time = time
        self.step = step

    def __str__(self) -> str:
        return str(self.args[0])


class NotConverged(FullbodyError, RuntimeError):
    """A quadrature or iteration that reached its stated limit."""


class ChartSingularity(FullbodyError, RuntimeError):
    """A body came too near the pole of the Tait-Bryan angles (theta = 90 degrees).

    Attributes
    ----------
    body : str
        Its name.
    time : float
        When, in the system's units.
    """

    def __init__(self, message: str, body: str = "", time: float = float("nan")) -> None:
        super().__init__(message, body, time)
        self.body = body
        self.time = time

    def __str__(self) -> str:
        return str(self.args[0])


class PrecisionWarning(UserWarning):
    """A tolerance below what doubles can do, which is raised to that."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during an integration; ``run`` holds what was recorded until then."""

    run: Run | None = None
