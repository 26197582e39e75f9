"""What every force from outside is to a system."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields
from itertools import count
from math import cbrt, pi
from typing import TYPE_CHECKING, Any, ClassVar, Self

from ..base.arguments import name_of, named_options, place, sequence
from ..base.values import ScalarFields, brief, same
from ..errors import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .. import _core
    from ..base.units import Units
    from .bodies import Body

__all__ = ["Call", "Force", "Ground", "forces_of", "rebuilt"]

#: So many errors can be kept; below the answer for success.
_ANSWERS = 2**30

#: The kinds of forces by their names.
KINDS: dict[str, type[Force]] = {}


@dataclass(frozen=True)
class Ground:
    """What a force is told of the system that it acts in."""

    units: Units
    G: float
    bodies: tuple[Body, ...]
    names: tuple[str, ...]

    def body(self, index: int) -> Any:
        """The body as the core has it: mass, volume and inertia in the system's units."""
        return self.bodies[index]._core(self.units, index)


class Call:
    """A function in C: its address, that of its data, and what keeps both; errors of a function of Python.

    Such a function may run in many threads at once. Where it raises, it answers a number that no other error of it has,
    and the number finds the error wherever the answer ends up.
    """

    def __init__(self, address: int, data: int, keep: Any, success: int = 0) -> None:
        self.address, self.data, self.keep, self.success = address, data, keep, success
        self._raised: dict[int, BaseException] = {}
        self._count = count()

    def kept(self, error: BaseException) -> int:
        """Keep an error; what to answer for it."""
        answer = next(self._count) % _ANSWERS + 1
        self._raised[answer] = error
        return answer

    def raised(self, answer: int | None) -> BaseException | None:
        """Give back the error of an answer, if it has one."""
        return None if answer is None else self._raised.pop(answer, None)

    def given(self) -> tuple[int, int, int, Any]:
        """What the core takes."""
        return (self.address, self.data, self.success, self.keep)

    def is_lost(self, answer: int | None) -> bool:
        """Whether an answer without an error is one that a function of Python does not give.

        Ctrl-C before its first line or after its last has taken the place of the answer.
        """
        return self.success != 0 and answer is not None


@named_options
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Force(ScalarFields):
    """Base of all forces.

    Attributes
    ----------
    name : str
        The force's own among those of a system; by it ``run.work`` and errors name the force.
    depends_on_velocity : bool
        Whether it depends on velocities or spins. The integrators of fixed steps refuse such forces.
    conserves_energy : bool
        Whether the energy of the bodies alone stays what it is.
    """

    name: str = ""

    depends_on_velocity: ClassVar[bool] = True
    conserves_energy: ClassVar[bool] = False

    #: As the core calls it; a kind made from another one is that one there.
    _kind: ClassVar[str] = "Force"

    def __init_subclass__(cls) -> None:
        KINDS[cls.__name__] = cls
        if Force in cls.__bases__:
            cls._kind = cls.__name__

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", name_of(self.name) or self._usual_name())

    def __hash__(self) -> int:
        return hash((type(self), self.name))

    def __repr__(self) -> str:
        entries = sorted(fields(self), key=lambda entry: entry.name == "name")
        given = ((entry, getattr(self, entry.name)) for entry in entries)
        parts = (
            f"{entry.name}={brief(value)}"
            for entry, value in given
            if entry.default is MISSING or not same(value, entry.default)
        )
        return f"{type(self).__name__}({', '.join(parts)})"

    def _usual_name(self) -> str:
        """The name where none is given."""
        return type(self).__name__

    def _place(self, ground: Ground, role: str) -> int:
        return place(getattr(self, role), ground.names, f"{role} of {self.name}")

    def _radius(self, ground: Ground, index: int) -> float:
        """The radius that the force was given, or that of the sphere of the body's volume."""
        given = getattr(self, "radius", None)
        if given is not None:
            return ground.units.number(given, "length", f"radius of {self.name}")
        volume = float(ground.body(index).volume)
        if volume == 0.0:
            raise InvalidInput(
                f"radius of {self.name} is not given, and {ground.names[index]} is a point; expected a radius"
            )
        return float(cbrt(0.75 * volume / pi))

    def _describe(self, ground: Ground) -> dict[str, Any]:
        """The force in numbers of a system's units, as the core takes it."""
        raise InvalidInput(f"force is {self!r}; expected one of fullbody.forces, such as ThirdBody(...)")

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        """The force of such a description."""
        raise NotImplementedError

    def _words(self, described: dict[str, Any], units: Units) -> str:
        """What it is in a few words, from its description in numbers of these units."""
        return ""

    def _doubts(
        self, described: dict[str, Any], names: tuple[str, ...], start: _core.State, units: Units
    ) -> Iterator[str]:
        """Warnings about the force at a start, from its description in numbers of these units."""
        yield from ()

    def _call(self, ground: Ground) -> Call | None:
        """The function that the core calls, of a force that is one."""
        return None


def rebuilt(described: dict[str, Any], units: Units) -> Force:
    """The force of a description in numbers of these units, which may come from a file."""
    kind = described["kind"]
    if kind not in KINDS:
        raise InvalidInput(f"force is of the kind {kind!r}; expected one of {', '.join(KINDS)}")
    return KINDS[kind]._of_core(described, units)


def forces_of(given: Any) -> tuple[Force, ...]:
    """Forces from outside, or an error that says what is none."""
    whole, each = "a sequence of forces, such as [ThirdBody(...)]", "forces of fullbody.forces, such as ThirdBody(...)"
    return sequence(given, Force, "forces", whole, each)
