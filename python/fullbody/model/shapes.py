"""Shapes of bodies and of their parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self, cast, get_args

from ..base.arguments import refuse_mixture
from ..base.attributes import Attribute
from ..base.kinds import Declared, Number, of_kind, with_unit
from ..base.limits import POSITIVE
from ..base.unit_names import unit_named
from ..base.units import Units, as_quantity
from ..errors import InvalidInput
from .freeform import ConvexShape, HarmonicShape
from .polyhedron import Polyhedron
from .stokes import StokesCoefficients, from_packed

_AXES = ("semi-axis a", "semi-axis b", "semi-axis c")


class _Ellipsoidal(Declared):
    """Base class of shapes with semi-axes."""

    __slots__ = ()

    @property
    def _lengths(self) -> tuple[Any, ...]:
        lengths = self._parts()
        return lengths if len(lengths) == 3 else lengths * 3

    @property
    def semi_axes(self) -> Any:
        """Semi-axes (3,) along x, y, z: a tuple of numbers, or a Quantity."""
        return as_quantity(self._lengths, "semi_axes")

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return {name: (length, "length") for name, length in zip(_AXES, self._lengths, strict=True)}

    def _with(self, units: Units, G: float) -> Self:
        """Return the shape in a system with units: its plain numbers become Quantities in them."""
        return type(self)(*(with_unit(length, "length", units) for length in self._parts()))

    def _core(self, units: Units, name: str) -> tuple[float, ...]:
        """Return the core's form of the shape in a system's units."""
        labelled = zip(_AXES, self._lengths, strict=True)
        return tuple(units.number(axis, "length", f"{label} of {name}") for label, axis in labelled)

    def _layer(self, fraction: float) -> Self:
        """Return the shape scaled about its centre."""
        return type(self)(*(length * fraction for length in self._parts()))


@dataclass(frozen=True, slots=True, eq=False)
class Ellipsoid(_Ellipsoidal):
    """A homogeneous ellipsoid.

    Parameters
    ----------
    a, b, c : float or Quantity
        Semi-axes along the body frame's x, y and z, in any order of size; they may be equal.

    Raises
    ------
    InvalidInput
        If a semi-axis is not a finite number above zero, and if only some have units.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Ellipsoid("2 km", "1.5 km", "800 m").semi_axes
    <Quantity [2. , 1.5, 0.8] km>
    """

    a: Any = field(metadata=of_kind(Number("length", POSITIVE)))
    b: Any = field(metadata=of_kind(Number("length", POSITIVE)))
    c: Any = field(metadata=of_kind(Number("length", POSITIVE)))

    def _what(self, name: str, of: str = "") -> str:
        return f"semi-axis {name}"

    def __post_init__(self) -> None:
        self._check_fields()
        refuse_mixture({name: length for name, (length, _) in self._numbers().items()})


@dataclass(frozen=True, slots=True, eq=False)
class Sphere(_Ellipsoidal):
    """A homogeneous sphere.

    Parameters
    ----------
    radius : float or Quantity

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Sphere(1.5).semi_axes
    (1.5, 1.5, 1.5)
    """

    radius: Any = field(metadata=of_kind(Number("length", POSITIVE)))

    def _what(self, name: str, of: str = "") -> str:
        return name


@dataclass(frozen=True, slots=True)
class PointMass:
    """A body without extent: no torque acts on it and its spin does not change.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Body(fullbody.PointMass(), mass=1.0, name="probe")
    Body(PointMass(), mass=1.0, name='probe')
    """

    semi_axes = Attribute[None](lambda shape: None, "``None``, since a point has no semi-axes.")

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return {}

    def _with(self, units: Units, G: float) -> PointMass:
        return self

    def _core(self, units: Units, name: str) -> None:
        return None


#: The type of the shapes that consist of one piece.
Solid = Ellipsoid | Sphere | PointMass | Polyhedron | StokesCoefficients | ConvexShape
#: The shapes whose volume is zero or undefined, with their names in errors.
WITHOUT_VOLUME: dict[type[Any], str] = {
    PointMass: "a point",
    StokesCoefficients: "a shape by its Stokes coefficients",
    ConvexShape: "a ConvexShape",
}
SOLIDS: dict[str, type[Solid]] = {shape.__name__: shape for shape in get_args(Solid)}


def inferred_units(numbers: dict[str, tuple[Any, str]]) -> Units:
    """Return the units of the first length and of the first mass or density among numbers, if they have units."""
    if not refuse_mixture({label: value for label, (value, _) in numbers.items()}):
        return Units()
    first: dict[str, Any] = {}
    for value, dimension in numbers.values():
        first.setdefault(dimension, value.unit)
    length = first.get("length", unit_named("m"))
    mass = first["density"] * length**3 if "density" in first else "kg"
    return Units((length, "s", first.get("mass", mass)))


def amounts(**values: Any) -> list[str]:
    """Return the names, with an article, of those of a mass, a density and a GM that are not ``None``."""
    return [f"a {name}" for name, value in values.items() if value is not None]


def refuse_amount(called: str, shape: Any, **values: Any) -> None:
    """Raise an error unless one of a mass, a density and a GM is given, or if a density is given for a point."""
    names = amounts(**values)
    if len(names) != 1:
        amount = f"both {' and '.join(names)}" if names else f"neither {' nor '.join(values)}"
        raise InvalidInput(f"{called} is given {amount}; expected one of them")
    if (density := values["density"]) is not None and isinstance(shape, tuple(WITHOUT_VOLUME)):
        what = WITHOUT_VOLUME[type(shape)]
        raise InvalidInput(f"density of {called} is {density!r}; expected a mass: {what} has no volume")


def rebuilt(axes: Any, kind: str | None, what: str, series: Any = None) -> Solid:
    """Rebuild a shape of the class ``kind`` from the core's description of it: ``None`` for a point.

    A shape whose size or curvature is a series of harmonics also needs the coefficients of the ``series``.
    """
    if isinstance(axes, dict) and "areas" in axes:
        return ConvexShape._rebuild(axes["normals"], axes["areas"], series)
    if series is not None and isinstance(axes, dict):
        return HarmonicShape._rebuild(axes["vertices"], axes["faces"], series)
    if isinstance(axes, dict) and "coefficients" in axes:
        numbers = (axes[name] for name in ("reference_radius", "mean_inertia", "radius"))
        return from_packed(axes["coefficients"], *numbers)
    if isinstance(axes, dict):
        return Polyhedron(axes["vertices"], axes["faces"])
    shape_class = SOLIDS[kind if kind is not None else "PointMass" if axes is None else "Ellipsoid"]
    shape = cast(Any, shape_class)(*(axes or ())[: len(shape_class.__slots__)])
    if shape.semi_axes != (None if axes is None else tuple(axes)):
        raise InvalidInput(f"{what} is a {shape_class.__name__} of semi-axes {axes}; expected fitting ones")
    return cast(Solid, shape)
