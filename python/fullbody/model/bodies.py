"""Shapes and bodies."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _core
from ..base.arguments import name_of, named_options, positive, refuse_mixture
from ..base.tables import Table, Tabled, number
from ..base.units import Units, gathered, is_quantity, strip_to
from ..base.values import ScalarFields, hashed, same
from ..errors import InvalidInput
from ..typing import Array, Scalar

__all__ = ["Body", "Ellipsoid", "PointMass", "Sphere"]

_AXES = ("semi-axis a", "semi-axis b", "semi-axis c")


@named_options
@dataclass(frozen=True, slots=True, eq=False)
class Ellipsoid(ScalarFields):
    """A homogeneous ellipsoid.

    Parameters
    ----------
    a, b, c : float or Quantity
        Semi-axes along the body frame's x, y and z, in any order of size; equal ones are welcome.

    Raises
    ------
    InvalidInput
        For a semi-axis that is not a finite number above zero, and where only some have units.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Ellipsoid(0.766, 0.7475, 0.6735)
    Ellipsoid(a=0.766, b=0.7475, c=0.6735)
    """

    a: Any
    b: Any
    c: Any

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            object.__setattr__(self, name, positive(getattr(self, name), "m", f"semi-axis {name}"))
        refuse_mixture(dict(zip(_AXES, self._lengths, strict=True)))

    @property
    def _lengths(self) -> tuple[Any, Any, Any]:
        return (self.a, self.b, self.c)

    @property
    def semi_axes(self) -> Any:
        """Semi-axes (3,) along x, y, z: a tuple of numbers, or a Quantity.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.Ellipsoid("2 km", "1.5 km", "800 m").semi_axes
        <Quantity [2. , 1.5, 0.8] km>
        """
        return gathered(self._lengths, "semi_axes")


@named_options
@dataclass(frozen=True, slots=True, eq=False)
class Sphere(ScalarFields):
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

    radius: Any

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive(self.radius, "m", "radius"))

    @property
    def _lengths(self) -> tuple[Any, Any, Any]:
        return (self.radius, self.radius, self.radius)

    @property
    def semi_axes(self) -> Any:
        """The radius three times (3,): a tuple of numbers, or a Quantity."""
        return gathered(self._lengths, "semi_axes")


@named_options
@dataclass(frozen=True, slots=True)
class PointMass:
    """A body without extent: no torque acts on it and its spin does not change.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Body(fullbody.PointMass(), mass=1.0, name="probe")
    Body(PointMass(), mass=1.0, name='probe')
    """

    _lengths = None

    @property
    def semi_axes(self) -> None:
        """A point has none."""
        return None


#: The shapes by name.
SHAPES = {shape.__name__: shape for shape in (Ellipsoid, Sphere, PointMass)}


@named_options
class Body(Tabled):
    """A shape with a mass.

    Parameters
    ----------
    shape : Ellipsoid, Sphere or PointMass
    mass, density : float or Quantity
        One of the two.
    name : str, optional
        The name in errors, tables and plots. A body without one is named after its place in the system.

    Raises
    ------
    InvalidInput
        For both or neither of mass and density, for values that are not finite numbers above zero, and for the density
        of a point.

    Examples
    --------
    >>> import fullbody
    >>> alpha = fullbody.Body(fullbody.Ellipsoid(0.766, 0.7475, 0.6735), mass=2.353e12, name="Alpha")
    >>> alpha
    Body(Ellipsoid(a=0.766, b=0.7475, c=0.6735), mass=2353000000000.0, name='Alpha')
    """

    __slots__ = ("_density", "_mass", "_name", "_shape")

    def __init__(
        self,
        shape: Ellipsoid | Sphere | PointMass,
        mass: Any = None,
        density: Any = None,
        name: str | None = None,
    ) -> None:
        called = "the body" if name_of(name) is None else name
        if not isinstance(shape, Ellipsoid | Sphere | PointMass):
            raise InvalidInput(f"shape of {called} is {shape!r}; expected an Ellipsoid, a Sphere or a PointMass")
        if (mass is None) == (density is None):
            given = "neither mass nor density" if mass is None else "both a mass and a density"
            raise InvalidInput(f"{called} is given {given}; expected one of the two")
        if density is not None and isinstance(shape, PointMass):
            raise InvalidInput(f"density of {called} is {density!r}; expected a mass: a point has no volume")
        self._shape = shape
        self._mass = None if mass is None else positive(mass, "kg", f"mass of {called}")
        self._density = None if density is None else positive(density, "kg / m3", f"density of {called}")
        self._name = name

    @property
    def shape(self) -> Ellipsoid | Sphere | PointMass:
        """The shape."""
        return self._shape

    @property
    def mass(self) -> Scalar:
        """Mass as given, or density times volume."""
        mass: Scalar = self._mass if self._mass is not None else self._own("mass", "mass")
        return mass

    @property
    def density(self) -> Scalar | None:
        """Density as given, or mass by volume; ``None`` for a point."""
        density: Scalar | None = self._density
        if density is None and self._shape._lengths is not None:
            density = self._mass / self._own("volume", "volume")
        return density

    @property
    def inertia(self) -> Any:
        """Principal moments of inertia (3,) about the body axes, mass times length squared; zeros for a point.

        The paper's I_11, I_22, I_33.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=5.0).inertia
        array([ 5., 10., 13.])
        """
        return self._own("inertia", "inertia")

    def _own(self, name: str, dimension: str) -> Any:
        """A number of the core's body, in the units of the first semi-axis and of the mass or density."""
        axes: Any = self._shape._lengths or ()
        what = "mass" if self._density is None else "density"
        amount: Any = self._mass if self._density is None else self._density
        called = self._name if self._name is not None else "the body"
        units = Units()
        if refuse_mixture({f"{what} of {called}": amount, **dict(zip(_AXES, axes, strict=False))}):
            from astropy import units as u

            length = axes[0].unit if axes else u.m
            units = Units((length, u.s, amount.unit if self._density is None else amount.unit * length**3))
        return units.attach(getattr(self._core(units, 0), name), dimension)

    @property
    def name(self) -> str | None:
        """The name."""
        return self._name

    def _tables(self) -> tuple[Table, ...]:
        """Shape, size, mass and density of one body."""
        rows: list[Sequence[str]] = [("shape", type(self.shape).__name__)]
        if self.shape.semi_axes is not None:
            rows.append(("semi-axes", ", ".join(number(axis) for axis in self.shape.semi_axes)))
        # Where only some of a body's numbers have units, only its system can compute what follows from them.
        for name in ("mass", "density"):
            with contextlib.suppress(InvalidInput):
                rows += [(name, number(value))] if (value := getattr(self, name)) is not None else []
        return (Table(f"Body {self.name}" if self.name is not None else "Body", (), rows),)

    def __repr__(self) -> str:
        value = f"density={self._density!r}" if self._mass is None else f"mass={self._mass!r}"
        name = "" if self._name is None else f", name={self._name!r}"
        return f"Body({self._shape!r}, {value}{name})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and same(self._parts(), other._parts())

    def __hash__(self) -> int:
        return hash(tuple(map(hashed, self._parts())))

    def _parts(self) -> tuple[object, ...]:
        return (self._shape, self._mass, self._density, self._name)

    def _with(self, units: Units) -> Body:
        """The body in a system with these units: its plain numbers become Quantities in them."""
        if not units.known:
            return self

        def attach(value: Any, dimension: str) -> Any:
            return value if value is None or is_quantity(value) else units.attach(value, dimension)

        sizes = (attach(getattr(self._shape, name), "length") for name in self._shape.__slots__)
        mass, density = attach(self._mass, "mass"), attach(self._density, "density")
        return Body(type(self._shape)(*sizes), mass=mass, density=density, name=self._name)

    def _semi_axes(self, units: Units, name: str = "the body") -> tuple[float, float, float] | None:
        """Semi-axes as numbers in a system's units; ``None`` for a point."""
        if self._shape._lengths is None:
            return None
        labelled = zip(self._shape._lengths, "abc", strict=True)
        a, b, c = (units.number(axis, "length", f"semi-axis {label} of {name}") for axis, label in labelled)
        return a, b, c

    def _core(self, units: Units, index: int) -> _core.Body:
        """The body in a system's units."""
        name = self._name if self._name is not None else f"body {index}"
        axes = self._semi_axes(units, name)
        mass, density = (
            None if value is None else units.number(value, dimension, f"{dimension} of {name}")
            for value, dimension in ((self._mass, "mass"), (self._density, "density"))
        )
        return _core.Body(name, axes, mass, density)

    def potential(self, points: Any, G: Any = None) -> Array:
        """Exterior potential Phi (positive) at points of the body frame.

        Parameters
        ----------
        points : array_like or Quantity, (3,) or (K, 3)
            Outside the body or on its surface. Quantities where the body's sizes and mass are; plain numbers, in the
            units of the semi-axes, where those are.
        G : float or Quantity, optional
            Gravitational constant; astropy's unless given, where there are units.

        Returns
        -------
        ndarray or Quantity, () or (K,)
            In the units of length and time of ``points`` and ``G``.

        Raises
        ------
        InvalidInput
            For a point inside the body, and where only some of points, G, sizes and mass have units.

        Notes
        -----
        Equal to the paper's ``eq:Potential_elliptic`` (MacMillan 1930), by Carlson's integrals.

        Examples
        --------
        >>> import fullbody
        >>> ball = fullbody.Body(fullbody.Sphere(1.0), mass=3.0)
        >>> float(ball.potential([0.0, 0.0, 2.0], G=1.0))
        1.5
        """
        potential: Array = self._exterior(points, G)[0]
        return potential

    def field(self, points: Any, G: Any = None) -> Array:
        """Exterior field g = grad Phi at points of the body frame; see :meth:`potential`.

        Parameters
        ----------
        points : array_like or Quantity, (3,) or (K, 3)
        G : float or Quantity, optional

        Returns
        -------
        ndarray or Quantity, (3,) or (K, 3)

        Examples
        --------
        >>> import astropy.units as u, fullbody
        >>> earth = fullbody.Body(fullbody.Sphere(6371 * u.km), mass=5.972e24 * u.kg)
        >>> earth.field([0.0, 0.0, 6371.0] * u.km)[2].to(u.m / u.s**2).round(2)
        <Quantity -9.82 m / s2>
        """
        field: Array = self._exterior(points, G)[1]
        return field

    def _exterior(self, points: Any, G: Any) -> tuple[Any, Any]:
        points, G = gathered(points, "points"), gathered(G, "G")
        if G is None:
            if not is_quantity(points):
                raise InvalidInput("G is not given; expected a number, or points and a body with units")
            from astropy import constants

            G = constants.G
        sizes = self._shape._lengths or ()
        amount = {"mass": self._mass} if self._density is None else {"density": self._density}
        known = refuse_mixture({"points": points, "G": G, **dict(zip(_AXES, sizes, strict=False)), **amount})
        units = _units_of(points, G) if known else Units()
        array = units.strip(points, "length", "points")
        if array.ndim not in (1, 2) or array.shape[-1] != 3:
            raise InvalidInput(f"points has shape {array.shape}; expected (3,) or (K, 3)")
        constant = units.number(G, "G", "G")
        potential, field = _core.exterior_gravity(self._core(units, 0), constant, np.atleast_2d(array))
        potential, field = units.attach(potential, "potential"), units.attach(field, "acceleration")
        return (potential, field) if array.ndim == 2 else (potential[0], field[0])


def _units_of(points: Any, G: Any) -> Units:
    """The length that points are in, and the time of G."""
    from astropy import units as u

    strip_to(points, u.m, "points")
    strip_to(G, u.m**3 / u.kg / u.s**2, "G")
    return Units((points.unit, next((base for base in G.unit.bases if base.is_equivalent(u.s)), u.s), u.kg))
