"""Composites: bodies of several parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, fields, replace
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.arguments import sequence
from ..base.kinds import Declared, Number, instance, of_kind, with_unit
from ..base.limits import NONZERO, NOT_NEGATIVE, POSITIVE, Limits
from ..base.units import UNITLESS, Units, is_quantity, without_unit
from ..base.values import ArrayFields, same
from ..errors import InvalidInput
from .polyhedron import Polyhedron
from .shapes import Ellipsoid, PointMass, Solid, Sphere, inferred_units, refuse_amount

#: The largest number of parts that the printed form of a composite lists one by one.
SHOWN = 20


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Part(Declared):
    """A part of a composite: a shape with a mass, a position and an attitude.

    Parameters
    ----------
    shape : Ellipsoid, Sphere, PointMass or Polyhedron
    mass, density, GM : float or Quantity
        Give one of the three; it is negative for a void, or for a deficit relative to matter that fills the same space.
    position : array_like or Quantity, (3,), optional
        The part's centre in the working frame, or for a polyhedron the origin of its vertices' frame; by default the
        origin of the working frame.
    attitude : array_like, (4,)
        The quaternion [w, x, y, z] that rotates vectors of the part's axes into the working frame.

    Raises
    ------
    InvalidInput
        If none or several of mass, density and GM are given, if numbers are not finite, for a mass of zero, and for the
        density of a point. A GM becomes a mass by the G of the part's system.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Part(fullbody.Sphere("110 m"), density="2.4 g/cm3", position=["105 m", "0 m", "0 m"])
    Part(Sphere(radius=<Quantity 110. m>), density=<Quantity 2.4 g / cm3>, position=<Quantity [105.,   0.,   0.] m>)
    """

    shape: Solid
    _: KW_ONLY
    mass: Any = field(default=None, metadata=of_kind(Number("mass", NONZERO)))
    density: Any = field(default=None, metadata=of_kind(Number("density", NONZERO)))
    GM: Any = field(default=None, metadata=of_kind(Number("mu", NONZERO)))
    position: Any = field(default=None, metadata=of_kind(Number("length", shape=(3,))))
    attitude: Any = field(default=(1.0, 0.0, 0.0, 0.0), metadata=of_kind(Number(shape=(4,))))

    def _what(self, name: str, of: str = "") -> str:
        return f"{name} of {of or 'a part'}"

    def __post_init__(self) -> None:
        solids = Ellipsoid | Sphere | PointMass | Polyhedron
        instance(self.shape, "shape of a part", solids, "an Ellipsoid, a Sphere, a PointMass or a Polyhedron")
        refuse_amount("a part", self.shape, mass=self.mass, density=self.density, GM=self.GM)
        self._check_fields()
        for name in ("position", "attitude"):
            value = getattr(self, name)
            if value is not None and not is_quantity(value):
                object.__setattr__(self, name, tuple(map(float, value)))
        quaternion = UNITLESS.strip(self.attitude, "number", "attitude of a part")
        if not quaternion.any():
            expected = "expected a quaternion [w, x, y, z] that is not zero"
            raise InvalidInput(f"attitude of a part is {self.attitude!r}; {expected}")
        object.__setattr__(self, "attitude", tuple(quaternion.tolist()))

    def __repr__(self) -> str:
        values = ((entry, getattr(self, entry.name)) for entry in fields(self)[1:])
        arguments = (f"{entry.name}={value!r}" for entry, value in values if not same(value, entry.default))
        return f"Part({self.shape!r}, {', '.join(arguments)})"

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return self.shape._numbers() | Declared._numbers(self)

    def _in(self, units: Units, what: str) -> tuple[Any, float | None, float | None, Any, Any]:
        """Return the part in the form that the core takes, in a system's units."""
        if self.GM is not None:
            raise InvalidInput(f"mass of {what} follows from its GM and the G of a system; expected its system's")
        numbers = self._unitless(units, of=what)
        position = [0.0, 0.0, 0.0] if self.position is None else numbers["position"]
        return self.shape._core(units, what), numbers["mass"], numbers["density"], position, self.attitude

    def _with(self, units: Units, G: float) -> Part:
        numbers = Declared._numbers(self)
        arguments = {name: with_unit(value, dimension, units) for name, (value, dimension) in numbers.items()}
        if self.GM is not None:
            mass = units.number(self.GM, "mu", "GM of a part") / G
            arguments |= {"mass": units.attach(mass, "mass"), "GM": None}
        return replace(self, shape=self.shape._with(units, G), **arguments)


@dataclass(frozen=True, slots=True)
class Composite:
    """A shape of several parts that form one rigid body: contact binaries, boulders, voids, cores, layers, mascons.

    Gravity is the sum over the parts, each exact by its own rule; densities add where parts overlap. The body frame has
    its origin in the centre of mass and its axes along the principal axes of inertia, ordered and directed as near as
    possible to the working frame in which the parts are given, also where moments are equal.
    :attr:`fullbody.Body.working_frame` is the position and attitude of the working frame in the body frame. Other
    bodies touch a composite where they touch a part, and also a void: one that opens to the surface counts as closed.

    Parameters
    ----------
    parts : sequence of Part
        Parts in any working frame, one at least.

    Raises
    ------
    InvalidInput
        If an element is not a Part, and if there are no parts.

    Examples
    --------
    Two lobes overlap a little, and their masses are those of whole ellipsoids:

    >>> import fullbody
    >>> lobes = [
    ...     fullbody.Part(fullbody.Ellipsoid(1.0, 0.8, 0.7), density=2.0),
    ...     fullbody.Part(fullbody.Sphere(0.6), density=2.0, position=(1.5, 0.0, 0.0)),
    ... ]
    >>> body = fullbody.Body(fullbody.Composite(lobes), name="Selam")
    >>> body.mass, body.inertia.round(3)
    (6.501002397828477, array([1.321, 4.597, 4.738]))
    """

    parts: tuple[Part, ...]

    def __init__(self, parts: Sequence[Part]) -> None:
        checked_parts = sequence(parts, Part, "parts", "a sequence of Part", "a sequence of Part")
        if not checked_parts:
            raise InvalidInput("parts is empty; expected at least one Part")
        object.__setattr__(self, "parts", checked_parts)

    def __repr__(self) -> str:
        more = len(self.parts) - SHOWN
        parts = [*map(repr, self.parts[:SHOWN]), *([f"... {more} more"] if more > 0 else [])]
        return f"Composite([{', '.join(parts)}])"

    @classmethod
    def layers(
        cls, shape: Ellipsoid | Sphere | Polyhedron, fractions: Sequence[float], densities: Sequence[Any]
    ) -> Composite:
        """Make a composite of homothetic layers: shells about one centre whose surfaces are scaled copies of one shape.

        The parts are whole solids with the differences of the densities. The centre of a polyhedron is its centre of
        mass, from which the whole surface has to be visible.

        Parameters
        ----------
        shape : Ellipsoid, Sphere or Polyhedron
            The outermost surface.
        fractions : sequence of float
            Sizes of the layers' outer surfaces relative to the outermost one, decreasing from 1.
        densities : sequence of float or Quantity
            Densities of the layers, from the outermost inwards; zero for a cavity.

        Raises
        ------
        InvalidInput

        Examples
        --------
        >>> import fullbody
        >>> shell = fullbody.Composite.layers(fullbody.Sphere(2.0), fractions=(1.0, 0.5), densities=(3.0, 0.0))
        >>> [part.density for part in shell.parts]
        [3.0, -3.0]
        """
        instance(shape, "shape", Ellipsoid | Sphere | Polyhedron, "an Ellipsoid, a Sphere or a Polyhedron")
        falling = Limits(above=0.0, text="numbers that fall from 1 and stay above zero")
        sizes = UNITLESS.numbers(fractions, "number", "fractions", ("L",), falling)
        if not sizes.size or sizes[0] != 1.0 or not (np.diff(sizes) < 0.0).all():
            raise InvalidInput(f"fractions is {fractions!r}; expected {falling.text}")
        listed = sequence(densities, object, "densities", "numbers, as many as fractions has", "numbers")
        checked = [Number("density", NOT_NEGATIVE)(value, "a density") for value in listed]
        if len({is_quantity(value) for value in checked if without_unit(value)}) == 2:
            raise InvalidInput(f"densities is {densities!r}; expected all with a unit or none")
        if len(checked) != len(sizes):
            raise InvalidInput(f"densities has {len(checked)} numbers; expected {len(sizes)}, as fractions has")
        parts, outer = [], None
        for size, density in zip(sizes.tolist(), checked, strict=True):
            step = density if outer is None else density - outer
            outer = density
            if without_unit(step):
                parts.append(Part(shape._layer(size), density=step))
        return cls(parts)

    def with_mass(self, mass: Any) -> Composite:
        """Return a composite whose masses and densities are all scaled so that the total mass is this one.

        Examples
        --------
        >>> import fullbody
        >>> pair = [fullbody.Part(fullbody.Sphere(1.0), mass=m, position=(m, 0.0, 0.0)) for m in (1.0, 3.0)]
        >>> [part.mass for part in fullbody.Composite(pair).with_mass(8.0).parts]
        [2.0, 6.0]
        """
        units = inferred_units(self._numbers())
        wanted = units.number(mass, "mass", "mass", POSITIVE)
        factor = wanted / self._core(units, "the composite").mass

        def scaled(part: Part) -> Part:
            amounts = {name: getattr(part, name) for name in ("mass", "density", "GM")}
            return replace(part, **{name: value * factor for name, value in amounts.items() if value is not None})

        return Composite([scaled(part) for part in self.parts])

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return {
            f"{name} of part {k}": value for k, part in enumerate(self.parts) for name, value in part._numbers().items()
        }

    @property
    def has_GM(self) -> bool:
        """Whether the mass of a part follows from its GM."""
        return any(part.GM is not None for part in self.parts)

    def _with(self, units: Units, G: float) -> Composite:
        return Composite([part._with(units, G) for part in self.parts])

    def _core(self, units: Units, name: str) -> _core.Body:
        if self.has_GM and units.defined:
            return self._with(units, units.gravitational_constant)._core(units, name)
        rows = [part._in(units, f"part {k} of {name}") for k, part in enumerate(self.parts)]
        return _core.Body.composite(name, rows)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class WorkingFrame(ArrayFields):
    """The position and attitude of the working frame of a composite or a polyhedron in the body frame.

    A point x of the working frame is R x + ``position`` in the body frame, where R is the rotation matrix of
    ``attitude``.

    Attributes
    ----------
    position : ndarray or Quantity, (3,)
        The working frame's origin.
    attitude : ndarray, (4,)
        The quaternion [w, x, y, z] that rotates vectors of the working frame into the body frame.
    """

    position: Any
    attitude: Any
