"""The base class of external forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields, replace
from math import cbrt, pi
from typing import Any, ClassVar, Self

import fullbody._core as _core

from ..base.arguments import integer, name_of, sequence
from ..base.kinds import Declared, Number, kinds_of
from ..base.limits import POSITIVE
from ..base.units import ANY, Units
from ..base.values import brief, same
from ..errors import InvalidInput
from .context import Call, Context

#: The classes of forces by the names of their kinds.
KINDS: dict[str, type[Force]] = {}


class _AnySystem(Context):
    """A stand-in for the context of a new force, for the checks that do not depend on the system."""

    def index(self, body: object, what: str = "body") -> int:
        """Return an index for a body that is given by its index or name."""
        index = integer(body)
        if not isinstance(body, str) and (index is None or index < 0):
            raise InvalidInput(f"{what} is {body!r}; expected the index or the name of a body")
        name = body if isinstance(body, str) else f"body {index}"
        # A dataclass that is frozen is changed only in this way.
        object.__setattr__(self, "names", (*self.names, name))
        object.__setattr__(self, "bodies", (*self.bodies, _BALL))
        return len(self.names) - 1


_BALL = _core.Body("body", (1.0, 1.0, 1.0), 1.0)
_SETTINGS = {"gravity": "focal", "order": None, "attitude_chart": "quaternion", "vector_path": "auto"}
_CORE = _core.System([_BALL], 1.0, _SETTINGS, [], {})


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Force(Declared):
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
    #: What a force without a name is called, which the name of the body that it acts on follows.
    _called: ClassVar[str] = "Force"

    def __init_subclass__(cls) -> None:
        KINDS[cls.__name__] = cls
        if Force in cls.__bases__:
            cls._kind = cls.__name__

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", name_of(self.name) or self._usual_name())
        self._check_fields()
        self._check()
        if type(self) is not Force:
            _core.check_force(self._describe(_AnySystem(ANY, 1.0, (), (), _CORE)))

    def _what(self, name: str, of: str = "") -> str:
        return f"{name} of {of or self.name}"

    def _check(self) -> None:
        """Raise an error for arguments that are not compatible; the core checks their values."""

    def __hash__(self) -> int:
        return hash((type(self), self.name))

    def __repr__(self) -> str:
        entries = sorted(fields(self), key=lambda entry: entry.name == "name")
        values = ((entry, getattr(self, entry.name)) for entry in entries)
        parts = [
            f"{entry.name}={brief(value)}"
            for entry, value in values
            if entry.default is MISSING or not same(value, entry.default)
        ]
        return f"{type(self).__name__}({', '.join(parts)})"

    def _usual_name(self) -> str:
        """Return the name of a force to which no name is given."""
        on = getattr(self, "on", None)
        return self._called if on is None else f"{self._called} {on if isinstance(on, str) else f'body {on}'}"

    def _index(self, context: Context, role: str) -> int:
        return context.index(getattr(self, role), self._what(role))

    def _radius(self, context: Context, index: int, role: str = "radius") -> float:
        """Return the radius that the force has as an argument, or that of the sphere with the body's volume."""
        if (radius := getattr(self, role, None)) is not None:
            return context.units.number(radius, "length", self._what(role), POSITIVE)
        volume = float(context.bodies[index].volume)
        if volume == 0.0:
            point = f"{context.names[index]} is a point"
            raise InvalidInput(f"{role} of {self.name} is not given, and {point}; expected a radius")
        return radius_of(volume)

    def _describe(self, context: Context) -> dict[str, Any]:
        """Return the description that the core takes, in numbers of a system's units."""
        if type(self) is Force:
            raise InvalidInput(f"force is {self!r}; expected one of fullbody.forces, such as ThirdBody(...)")

        def name_of_body(body: Any, what: str) -> str:
            # An index may add a name to those of the context of a new force.
            index = context.index(body, what)
            return context.names[index]

        return {"kind": self._kind, "name": self.name, **self._unitless(context.units, name_of_body)}

    def _notes(self) -> dict[str, Any]:
        """Return data of the force that the core's description does not contain."""
        return {}

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        """Rebuild the force from such a description with such notes."""
        kinds = kinds_of(cls)
        arguments = {name: value for name, value in described.items() if name != "kind"}
        for name in arguments:
            if isinstance(kind := kinds.get(name), Number):
                arguments[name] = kind.attached(arguments[name], units)
        return cls(**arguments)

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        """Return a few words about the force, from its description in numbers of these units."""
        return ""

    @classmethod
    def _input_warnings(cls, described: dict[str, Any], start: _core.State, context: Context) -> Iterator[str]:
        """Return warnings about a force of this kind at a start, from its description."""
        yield from ()

    def _call(self, context: Context) -> Call | None:
        """Return the function that the core calls, for a force that has one."""
        return None


def radius_of(volume: float) -> float:
    """Return the radius of the sphere of a volume."""
    return float(cbrt(0.75 * volume / pi))


def rebuilt(described: dict[str, Any], units: Units) -> Force:
    """Rebuild a force from its description in numbers of these units, which may come from a file."""
    kind = described["kind"]
    if kind not in KINDS:
        raise InvalidInput(f"force is of the kind {kind!r}; expected one of {', '.join(KINDS)}")
    return KINDS[kind]._of_core(described, units)


def acted_on(alone: Context, forces: tuple[Force, ...]) -> Context:
    """Return the context of bodies under forces, which describe themselves in that of the bodies alone."""
    if not forces:
        return alone
    calls = {force.name: call for force in forces if (call := force._call(alone)) is not None}
    described = [force._describe(alone) for force in forces]
    arguments = {name: call.core_arguments() for name, call in calls.items()}
    core = _core.System(list(alone.bodies), alone.G, alone.core.settings, described, arguments)
    return replace(alone, core=core, forces={force.name: force._kind for force in forces}, calls=calls)


def forces_of(value: Any) -> tuple[Force, ...]:
    """Return external forces as a tuple, or raise an error for an element that is not a force."""
    expected = "forces of fullbody.forces, such as ThirdBody(...)"
    return sequence(value, Force, "forces", "a sequence of forces, such as [ThirdBody(...)]", expected)
