"""Bodies: a shape with a mass."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from functools import partial
from typing import Any, cast

import numpy as np

import fullbody._core as _core

from ..base.arguments import name_of, refuse_mixture
from ..base.attributes import Attribute
from ..base.kinds import Number, instance, with_unit
from ..base.limits import POSITIVE
from ..base.tables import Table, Tabled, number
from ..base.unit_names import unit_named
from ..base.units import Units, as_quantity, is_quantity, strip_to
from ..base.values import ScalarFields
from ..errors import InvalidInput
from ..typing import Scalar
from . import shapes
from .composite import SHOWN, Composite, Part, WorkingFrame
from .freeform import ConvexShape, HarmonicShape
from .gravity import Gravity, gravity_at, points_in
from .polyhedron import Polyhedron
from .shapes import Ellipsoid, Solid
from .stokes import StokesCoefficients, harmonics_of


class Body(ScalarFields, Tabled):
    """A shape with a mass.

    Parameters
    ----------
    shape : Ellipsoid, Sphere, PointMass, Polyhedron, HarmonicShape, ConvexShape, StokesCoefficients or Composite
    mass, density, GM : float or Quantity
        Give one of the three; none for a composite, whose parts have their own. A system divides GM, which is G times
        the mass, by its own G, and a body with units by itself by that of astropy.
    name : str, optional
        The name in errors, tables and plots. A body without a name is named after its index in the system.

    Raises
    ------
    InvalidInput
        If none or several of mass, density and GM are given, if a value is not a finite number above zero, and for the
        density of a point or of Stokes coefficients. For a composite if one is given beside those of its parts, if the
        sum of the parts' masses is not above zero, and if no body can have its moments of inertia.

    Examples
    --------
    >>> import fullbody
    >>> alpha = fullbody.Body(fullbody.Ellipsoid(0.766, 0.7475, 0.6735), mass=2.353e12, name="Alpha")
    >>> alpha
    Body(Ellipsoid(a=0.766, b=0.7475, c=0.6735), mass=2353000000000.0, name='Alpha')
    """

    __slots__ = ("_GM", "_attraction", "_density", "_mass", "_name", "_shape")

    def __init__(
        self,
        shape: Solid | Composite,
        *,
        mass: Any = None,
        density: Any = None,
        name: str | None = None,
        GM: Any = None,
    ) -> None:
        name = name_of(name)
        called = "the body" if name is None else name
        expected = "an Ellipsoid, a Sphere, a PointMass, a Polyhedron, a HarmonicShape, a ConvexShape, "
        expected += "StokesCoefficients or a Composite"
        if isinstance(instance(shape, f"shape of {called}", Solid | Composite, expected), Composite):
            if amounts := shapes.amounts(mass=mass, density=density, GM=GM):
                expected = "expected none beside those of its parts; Composite.with_mass scales them"
                raise InvalidInput(f"{called} is given {amounts[0]}, and is a composite; {expected}")
        else:
            shapes.refuse_amount(called, shape, mass=mass, density=density, GM=GM)
        self._attraction: tuple[Any, _core.Attraction] | None = None
        self._shape = shape
        self._mass = None if mass is None else Number("mass", POSITIVE)(mass, f"mass of {called}")
        self._density = None if density is None else Number("density", POSITIVE)(density, f"density of {called}")
        self._GM = None if GM is None else Number("mu", POSITIVE)(GM, f"GM of {called}")
        self._name = name
        have_units = {is_quantity(value) for value, _ in self._numbers().values()}
        if isinstance(shape, Composite) and len(have_units) == 1 and not (shape.has_GM and False in have_units):
            # A total mass of zero and impossible moments of inertia show only in the whole body. If only some numbers
            # have units, only a system can compute them.
            self._core(self._inferred_units(), 0)

    shape = Attribute[Solid | Composite]("_shape", "The shape.")
    name = Attribute[str | None]("_name", "The name.")

    @property
    def mass(self) -> Scalar:
        """Mass as given, density times volume, or GM by G; for a composite the sum of the masses of its parts."""
        return self._mass if self._mass is not None else self._computed("mass", "mass")

    @property
    def density(self) -> Scalar | None:
        """Density as given, or mass by volume; ``None`` for a shape without a volume, and for a composite."""
        density: Scalar | None = self._density
        if density is None and not isinstance(self._shape, (*shapes.WITHOUT_VOLUME, Composite)):
            density = self.mass / self._computed("volume", "volume")
        return density

    @property
    def inertia(self) -> Any:
        """Principal moments of inertia (3,) about the body axes, the paper's I_11, I_22, I_33: mass times length
        squared.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=5.0).inertia
        array([ 5., 10., 13.])
        """
        return self._computed("inertia", "inertia")

    @property
    def working_frame(self) -> WorkingFrame | None:
        """Where the working frame of a composite, a polyhedron or Stokes coefficients lies in the body frame, or
        ``None``. That of a :class:`ConvexShape` is the body frame itself.

        Examples
        --------
        >>> import fullbody
        >>> ends = [fullbody.Part(fullbody.Sphere(1.0), mass=1.0, position=(x, 0.0, 5.0)) for x in (1.0, 4.0)]
        >>> fullbody.Body(fullbody.Composite(ends)).working_frame.position
        array([-2.5,  0. , -5. ])
        """
        units = self._inferred_units()
        if isinstance(self._shape, ConvexShape):
            return WorkingFrame(units.attach(np.zeros(3), "length"), np.eye(4)[0])
        if (frame := self._core(units, 0).working_frame) is None:
            return None
        return WorkingFrame(units.attach(np.array(frame[0]), "length"), np.array(frame[1]))

    def fitted_ellipsoid(self) -> Ellipsoid:
        """Return the ellipsoid along the body frame that, homogeneous and of the same mass, has the moments of inertia.

        Raises
        ------
        InvalidInput
            If the body is a point, a :class:`ConvexShape` or a flat composite.

        Examples
        --------
        >>> import fullbody
        >>> ends = [fullbody.Part(fullbody.Sphere(1.0), mass=1.0, position=(x, 0.0, 0.0)) for x in (-1.0, 1.0)]
        >>> fullbody.Body(fullbody.Composite(ends)).fitted_ellipsoid().a
        2.449489742783178
        """
        units = self._inferred_units()
        axes = self._core(units, 0).semi_axes
        if isinstance(self._shape, ConvexShape):
            raise InvalidInput(f"{self._called} is a ConvexShape, without known moments; expected its polyhedron()")
        if not all(axes):
            raise InvalidInput(f"{self._called} has no fitted ellipsoid; expected one with extent in three directions")
        return Ellipsoid(*(units.attach(float(axis), "length") for axis in axes))

    def harmonics(self, degree: int) -> StokesCoefficients:
        """Return Stokes coefficients of the body in its own frame, of any shape.

        Parameters
        ----------
        degree : int
            The highest degree, from 2 to 60.

        Returns
        -------
        StokesCoefficients
            In the 4 pi normalisation, for the radius of a sphere about the centre of mass that contains the body. The
            body that has this shape attracts as this one does but for higher degrees.

        Raises
        ------
        InvalidInput
            For a point, which has no radius, and for another degree.

        Examples
        --------
        >>> import fullbody
        >>> alpha = fullbody.Body(fullbody.Ellipsoid(0.766, 0.7475, 0.6735), mass=2.353e12)
        >>> alpha.harmonics(4).C[2, 0].round(6)
        np.float64(-0.018163)
        """
        units = self._inferred_units()
        return harmonics_of(self._core(units, 0), degree, units)

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        """Return all dimensional numbers by their names, with their dimensions."""
        amounts = {"mass": (self._mass, "mass"), "density": (self._density, "density"), "GM": (self._GM, "mu")}
        present = {f"{name} of {self._called}": number for name, number in amounts.items() if number[0] is not None}
        return self._shape._numbers() | present

    @property
    def _called(self) -> str:
        """The name in errors."""
        return "the body" if self._name is None else self._name

    def _inferred_units(self) -> Units:
        return shapes.inferred_units(self._numbers())

    def _computed(self, name: str, dimension: str) -> Any:
        """Return a number of the core's body in the body's own units."""
        units = self._inferred_units()
        return units.attach(getattr(self._core(units, 0), name), dimension)

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of the shape, size, mass and density of the body."""
        rows: list[Sequence[str]] = [("shape", type(self.shape).__name__)]
        if isinstance(self.shape, Composite):
            rows.append(("parts", str(len(self.shape.parts))))
        elif isinstance(self.shape, Polyhedron):
            rows.append(("faces", str(len(self.shape.faces))))
        elif isinstance(self.shape, ConvexShape):
            rows.append(("facets", str(len(self.shape.normals))))
        elif isinstance(self.shape, StokesCoefficients):
            rows += [("degree", str(self.shape.degree)), ("reference radius", number(self.shape.reference_radius))]
        elif self.shape.semi_axes is not None:
            rows.append(("semi-axes", ", ".join(number(axis) for axis in self.shape.semi_axes)))
        # If only some of a body's numbers have units, only its system can compute what follows from them.
        for name in ("mass", "density"):
            with contextlib.suppress(InvalidInput):
                rows += [(name, number(value))] if (value := getattr(self, name)) is not None else []
        table = Table(f"Body {self.name}" if self.name is not None else "Body", (), rows)
        return (table, _table_of_parts(self.shape.parts)) if isinstance(self.shape, Composite) else (table,)

    def __repr__(self) -> str:
        values = (("mass", self._mass), ("density", self._density), ("GM", self._GM), ("name", self._name))
        present = [f"{name}={value!r}" for name, value in values if value is not None]
        return f"Body({', '.join([repr(self._shape), *present])})"

    def __reduce__(self) -> Any:
        return partial(Body, self._shape, mass=self._mass, density=self._density, name=self._name, GM=self._GM), ()

    def _parts(self) -> tuple[object, ...]:
        return (self._shape, self._mass, self._density, self._GM, self._name)

    def _with(self, units: Units, G: float) -> Body:
        """Return the body in a system with these units and G: its plain numbers become Quantities, and GM a mass."""
        has_GM = self._GM is not None or (isinstance(self._shape, Composite) and self._shape.has_GM)
        numbers = (value for value, _ in self._numbers().values())
        if not has_GM and (not units.defined or all(map(is_quantity, numbers))):
            return self
        mass, density = with_unit(self._mass, "mass", units), with_unit(self._density, "density", units)
        if self._GM is not None:
            mass = units.attach(units.number(self._GM, "mu", f"GM of {self._called}", POSITIVE) / G, "mass")
        return Body(self._shape._with(units, G), mass=mass, density=density, name=self._name)

    def _core(self, units: Units, index: int) -> _core.Body:
        """The body in a system's units."""
        if self._GM is not None:
            if not units.defined:
                follows = "follows from its GM and the G of a system"
                raise InvalidInput(f"mass of {self._called} {follows}; expected its system's")
            return self._with(units, units.gravitational_constant)._core(units, index)
        name = self._name if self._name is not None else f"body {index}"
        shape: Any = self._shape._core(units, name)
        if isinstance(self._shape, Composite):
            return shape
        mass, density = (
            None if value is None else units.number(value, dimension, f"{dimension} of {name}")
            for value, dimension in ((self._mass, "mass"), (self._density, "density"))
        )
        if isinstance(self._shape, ConvexShape):
            return _core.Body.of_facets(name, self._shape.normals, shape, cast(float, mass))
        return _core.Body(name, shape, mass, density)

    def _notes(self) -> dict[str, Any]:
        """Return whether the body was named and the names of its classes, which the core's description leaves out."""
        notes = {"named": self._name is not None, "shape": type(self._shape).__name__}
        if isinstance(self._shape, HarmonicShape | ConvexShape):
            notes |= self._shape._notes()
        if isinstance(self._shape, Composite):
            # The parts keep the vertices alone of a free-form shape.
            kinds = (
                Polyhedron if isinstance(part.shape, Polyhedron) else type(part.shape) for part in self._shape.parts
            )
            notes["parts"] = [kind.__name__ for kind in kinds]
        return notes

    @classmethod
    def _rebuild(cls, described: dict[str, Any], notes: dict[str, Any]) -> Body:
        """Rebuild a body from the core's description and such notes, which may be missing."""
        called = described["name"]
        if (named := notes.get("named", True)) not in (True, False):
            raise InvalidInput(f"the notes of {called} have {named!r} for named; expected true or false")
        name = called if named else None
        if "parts" not in described:
            axes = described.get("semi_axes", described.get("facets"))
            shape = shapes.rebuilt(axes, notes.get("shape"), called, notes.get("series"))
            return cls(shape, mass=described["mass"], name=name)
        kinds = notes.get("parts", [None] * len(described["parts"]))
        parts = []
        for k, (part, kind) in enumerate(zip(described["parts"], kinds, strict=True)):
            shape = shapes.rebuilt(part["semi_axes"], kind, f"part {k} of {called}")
            parts.append(Part(shape, **{key: part[key] for key in ("mass", "position", "attitude")}))
        return cls(Composite(parts), name=name)

    def gravity(self, points: Any, G: Any = None) -> Gravity:
        """Return potential, field and gravity gradient at points of the body frame, outside and inside.

        Parameters
        ----------
        points : array_like or Quantity, (..., 3)
            Quantities if the body's sizes and mass are Quantities, and otherwise numbers in the unit of the semi-axes.
        G : float or Quantity, optional
            Gravitational constant; with units it is that of astropy by default.

        Returns
        -------
        Gravity
            ``.potential`` (...), ``.field`` (..., 3) and ``.gradient`` (..., 3, 3), in the units of length and time of
            ``points`` and ``G``.

        Raises
        ------
        InvalidInput
            For a point at a point mass or with coordinates that are not finite, which the message gives by its index;
            if only some of points, G, sizes and mass have units; for the gradient on a polyhedron's surface.

        Notes
        -----
        The potential of an ellipsoid is the paper's ``eq:Potential_elliptic`` (MacMillan 1930) by Carlson's integrals,
        and inside a quadratic form; that of a polyhedron is the sum of Werner and Scheeres (1996), that of a composite
        the sum over its parts. On the surface of an ellipsoid the gradient is the limit from outside.

        Examples
        --------
        >>> import fullbody
        >>> ball = fullbody.Body(fullbody.Sphere(1.0), mass=3.0)
        >>> gravity = ball.gravity([0.0, 0.0, 2.0], G=1.0)
        >>> float(gravity.potential), gravity.field.tolist(), gravity.gradient.diagonal().tolist()
        (1.5, [0.0, 0.0, -0.75], [-0.375, -0.375, 0.75])
        """
        points, G = as_quantity(points, "points", "length"), as_quantity(G, "G", "G")
        if G is None:
            if not is_quantity(points):
                raise InvalidInput("G is not given; expected a number, or points and a body with units")
            from astropy import constants

            G = constants.G
        numbers = {label: value for label, (value, _) in self._numbers().items()}
        units = _units_of(points, G) if refuse_mixture({"points": points, "G": G, **numbers}) else Units()
        array = points_in(points, units)
        constant = units.number(G, "G", "G")
        key = (units.names, constant)
        if self._attraction is None or self._attraction[0] != key:
            # It is cached, since the sums of a polyhedron take long to prepare.
            self._attraction = key, _core.Attraction([self._with(units, constant)._core(units, 0)], constant, "auto")
        origin, unturned = np.zeros((1, 1, 3)), np.array([[[1.0, 0.0, 0.0, 0.0]]])
        return gravity_at(self._attraction[1], origin, unturned, array, units)


def _units_of(points: Any, G: Any) -> Units:
    """Return the units of points and G: the length of the points and the time of G."""
    strip_to(points, unit_named("m"), "points")
    strip_to(G, unit_named("m3 / (kg s2)"), "G")
    return Units((points.unit, next((base for base in G.unit.bases if base.is_equivalent("s")), "s"), "kg"))


def _table_of_parts(parts: Sequence[Part]) -> Table:
    """Return a table of the parts of a composite, one part per row."""

    def row(part: Part) -> Sequence[str]:
        if isinstance(part.shape, Polyhedron):
            size = f"{len(part.shape.faces)} faces"
        else:
            axes = part.shape.semi_axes
            size = "-" if axes is None else ", ".join(map(number, axes))
        amount = f"{number(part.mass)}" if part.density is None else f"density {number(part.density)}"
        position = "origin" if part.position is None else ", ".join(number(x) for x in part.position)
        return type(part.shape).__name__, size, amount, position

    more = len(parts) - SHOWN
    rows = [*map(row, parts[:SHOWN]), *([(f"{more} more", "", "", "")] if more > 0 else [])]
    return Table("Parts", ("shape", "semi-axes", "mass", "position"), rows)
