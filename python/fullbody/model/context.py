"""The context of a system, which forces, events and readers of runs receive, and the functions that the core calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

import fullbody._core as _core

from ..base.arguments import index_of, normal_form, suggestion
from ..base.tables import Table
from ..base.units import Units
from ..errors import InvalidInput
from ..typing import Floats
from .surface import Deformation, size_of

#: The number of errors that a call can keep; their answers stay below this number.
_ANSWERS = 2**30


class Call:
    """A C function: its address, the address of its data, the object that keeps both alive, and errors raised in it.

    The function may run in many threads at once. If a Python function raises an error, the C function returns a number
    that belongs to this error alone, by which the error is found again wherever the number arrives.
    """

    def __init__(self, address: int, data: int, owner: Any, success: int = 0) -> None:
        self.address, self.data, self.owner, self.success = address, data, owner, success
        self._raised: dict[int, BaseException] = {}
        self._count = count()

    def store(self, error: BaseException) -> int:
        """Store an error and return the number that stands for it."""
        answer = next(self._count) % _ANSWERS + 1
        self._raised[answer] = error
        return answer

    def raised(self, answer: int | None) -> BaseException | None:
        """Remove and return the error for which a number stands, ``None`` if there is none."""
        return None if answer is None else self._raised.pop(answer, None)

    def core_arguments(self) -> tuple[int, int, int, Any]:
        """Return the function in the form that the core takes."""
        return (self.address, self.data, self.success, self.owner)

    def is_lost(self, answer: int | None) -> bool:
        """Return whether a number without an error is one that no Python function returns, as after Ctrl-C in it."""
        return self.success != 0 and answer is not None


@dataclass(frozen=True, eq=False)
class Context:
    """The units, the constant and the bodies of a system, with the core's handle; numbers are in the system's units.

    A force describes itself in the context of the bodies, whose handle has no forces. The epoch is the date of time
    zero as text, and the frame the name of the inertial axes. ``forces`` has the kinds of the external forces by their
    names, in the order of the system, ``calls`` the functions of those that have one, and ``notes`` what the core's
    description of the system does not contain, for files. ``deformations`` are further parameters, by their names, that
    move the surfaces of bodies; see :mod:`fullbody.model.surface`.
    """

    units: Units
    G: float
    names: tuple[str, ...]
    bodies: tuple[_core.Body, ...]
    core: _core.System
    epoch: str | None = None
    frame: str | None = None
    forces: Mapping[str, str] = field(default_factory=dict)
    calls: Mapping[str, Call] = field(default_factory=dict)
    notes: Mapping[str, Any] = field(default_factory=dict)
    deformations: Mapping[str, Deformation] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def masses(self) -> Floats:
        """Masses (N,)."""
        return self.core.masses

    @cached_property
    def attraction(self) -> _core.Attraction:
        """The gravity of the bodies, which is prepared at its first use."""
        return _core.Attraction(list(self.bodies), self.G, self.core.settings["vector_path"])

    def index(self, body: object, what: str = "body") -> int:
        """Return the index of a body from its index or name, or raise an error that lists the bodies."""
        return index_of(body, self.names, what)

    def pair(self, body: object, about: object, of: str = "") -> tuple[int, int]:
        """Return the indices of two bodies, or raise an error if they are one; ``of`` names the owner in errors."""
        first, second = self.index(body, f"body{of}"), self.index(about, f"about{of}")
        if first == second:
            expected = "expected two bodies"
            raise InvalidInput(f"body and about{of} are {body!r} and {about!r}, both {self.names[first]}; {expected}")
        return first, second

    def mu(self, body: int, about: int) -> float:
        """Return G times the sum of the masses of two bodies."""
        masses = self.masses
        return float(self.G * (masses[body] + masses[about]))

    def third_body(self, name: object, what: str) -> int:
        """Return the index of a third body among the forces by its name, or raise an error that lists them."""
        name, names = normal_form(name), [name for name, kind in self.forces.items() if kind == "ThirdBody"]
        if name not in names:
            is_other = f", a {self.forces[name]}" if isinstance(name, str) and name in self.forces else ""
            expected = (
                suggestion(str(name), names, "one") if names else "expected a ThirdBody of the system, which has none"
            )
            raise InvalidInput(f"{what} is {name!r}{is_other}; {expected}")
        return list(self.forces).index(str(name))

    def natural_size(self, parameter: str) -> float:
        """Return a natural size of changes of a parameter of the system."""
        if parameter in self.deformations:
            return size_of(self.bodies, self.deformations[parameter])
        return self.core.changed(parameter, 0.0)[3]

    def describe(self) -> dict[str, Any]:
        """Return the core's description of the system with the notes, from which it can be rebuilt."""
        core = self.core
        described = {"bodies": core.bodies, "G": self.G, "settings": core.settings, "forces": core.forces}
        return described | {"notes": dict(self.notes)}


class SystemLike(Protocol):
    """An object with a context: a :class:`fullbody.System`, where that class itself uses the function."""

    @property
    def context(self) -> Context:
        """The context of the system."""

    @property
    def bodies(self) -> tuple[Any, ...]:
        """The bodies."""

    @property
    def forces(self) -> tuple[Any, ...]:
        """The external forces."""

    def changed(self, parameter: str, by: float) -> Self:
        """Return the system with one of its parameters changed."""

    def _tables(self) -> tuple[Table, ...]: ...


if TYPE_CHECKING:
    from typing_extensions import TypeVar as TypeVarWithDefault

    S = TypeVarWithDefault("S", bound=SystemLike, default=Any)
else:
    #: The class of the system of a run or a flight.
    S = TypeVar("S")
