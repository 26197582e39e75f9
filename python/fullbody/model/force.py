"""The base class of external forces, and the context in which a force describes itself."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields
from itertools import count
from math import cbrt, pi
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias

from .. import _core
from ..base.arguments import integer, name_of, place, sequence
from ..base.units import AnyUnits, Units
from ..base.values import ScalarFields, brief, same
from ..errors import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .bodies import Body

__all__ = ["Call", "Context", "Force", "SystemContext", "forces_of", "rebuilt"]

#: The number of errors that a call can keep; their answers stay below this number.
_ANSWERS = 2**30

#: The classes of forces by the names of their kinds.
KINDS: dict[str, type[Force]] = {}


@dataclass(frozen=True)
class SystemContext:
    """The data of a system that a force needs to describe itself."""

    units: Units
    G: float
    bodies: tuple[Body, ...]
    names: tuple[str, ...]
    epoch: str | None = None

    def place(self, body: Any, what: str) -> int:
        """Return the place of a body from its place or name."""
        return place(body, self.names, what)

    def body(self, index: int) -> Any:
        """Return the core's body, with mass, volume and inertia in the system's units."""
        return self.bodies[index]._core(self.units, index)


class UnknownSystem:
    """A stand-in for the system of a new force, for the checks that do not depend on the system."""

    units = AnyUnits()
    G = 1.0
    epoch = None

    def __init__(self) -> None:
        self.names: list[str] = []

    def place(self, body: Any, what: str) -> int:
        """Return a place for a body that is given by its place or name."""
        index = integer(body)
        if not isinstance(body, str) and (index is None or index < 0):
            raise InvalidInput(f"{what} is {body!r}; expected the place or the name of a body")
        self.names.append(body if isinstance(body, str) else f"body {index}")
        return len(self.names) - 1

    def body(self, index: int) -> Any:
        """Return a body whose mass, volume and moments of inertia are one."""
        return SimpleNamespace(mass=1.0, volume=1.0, inertia=(1.0, 1.0, 1.0))


Context: TypeAlias = SystemContext | UnknownSystem


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

    def given(self) -> tuple[int, int, int, Any]:
        """Return the function in the form that the core takes."""
        return (self.address, self.data, self.success, self.keep)

    def is_lost(self, answer: int | None) -> bool:
        """Return whether a number without an error is one that a Python function does not return.

        This happens if Ctrl-C interrupts the function before its first line or after its last one.
        """
        return self.success != 0 and answer is not None


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Force(ScalarFields):
    """Base class of all forces.

    Attributes
    ----------
    name : str
        The name of the force, distinct among those of a system, which ``run.work`` and errors use.
    depends_on_velocity : bool
        Whether the force depends on velocities or spins. Integrators with fixed steps refuse such forces.
    conserves_energy : bool
        Whether the force conserves the energy of the bodies.
    """

    name: str = ""

    depends_on_velocity: ClassVar[bool] = True
    conserves_energy: ClassVar[bool] = False

    #: The core's name of the kind; a class derived from another kind keeps that kind's name.
    _kind: ClassVar[str] = "Force"

    def __init_subclass__(cls) -> None:
        KINDS[cls.__name__] = cls
        if Force in cls.__bases__:
            cls._kind = cls.__name__

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", name_of(self.name) or self._usual_name())
        self._check()
        if type(self) is not Force:
            _core.check_force(self._describe(UnknownSystem()))

    def _check(self) -> None:
        """Raise an error for arguments that are not compatible; the core checks their values."""

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
        """Return the name of a force to which no name is given."""
        return type(self).__name__

    def _place(self, system: Context, role: str) -> int:
        return system.place(getattr(self, role), f"{role} of {self.name}")

    def _radius(self, system: Context, index: int) -> float:
        """Return the radius that the force was given, or that of the sphere with the body's volume."""
        given = getattr(self, "radius", None)
        if given is not None:
            return system.units.number(given, "length", f"radius of {self.name}")
        volume = float(system.body(index).volume)
        if volume == 0.0:
            raise InvalidInput(
                f"radius of {self.name} is not given, and {system.names[index]} is a point; expected a radius"
            )
        return float(cbrt(0.75 * volume / pi))

    def _describe(self, system: Context) -> dict[str, Any]:
        """Return the description that the core takes, in numbers of a system's units."""
        raise InvalidInput(f"force is {self!r}; expected one of fullbody.forces, such as ThirdBody(...)")

    def _notes(self) -> dict[str, Any]:
        """Return data of the force that the core's description does not contain."""
        return {}

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        """Rebuild the force from such a description with such notes."""
        raise NotImplementedError

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        """Return a few words about the force, from its description in numbers of these units."""
        return ""

    def _input_warnings(
        self, described: dict[str, Any], names: tuple[str, ...], start: _core.State, units: Units
    ) -> Iterator[str]:
        """Return warnings about the force at a start, from its description in numbers of these units."""
        yield from ()

    def _call(self, system: SystemContext) -> Call | None:
        """Return the function that the core calls, for a force that has one."""
        return None


def rebuilt(described: dict[str, Any], units: Units) -> Force:
    """Rebuild a force from its description in numbers of these units, which may come from a file."""
    kind = described["kind"]
    if kind not in KINDS:
        raise InvalidInput(f"force is of the kind {kind!r}; expected one of {', '.join(KINDS)}")
    return KINDS[kind]._of_core(described, units)


def forces_of(given: Any) -> tuple[Force, ...]:
    """Return external forces as a tuple, or raise an error that shows what is not a force."""
    whole, each = "a sequence of forces, such as [ThirdBody(...)]", "forces of fullbody.forces, such as ThirdBody(...)"
    return sequence(given, Force, "forces", whole, each)
