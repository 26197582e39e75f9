"""Free-form shapes: bodies whose size in all directions, or whose curvature, is a series of spherical harmonics."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from ..base.attributes import Attribute
from ..base.kinds import Number, whole_number, with_unit
from ..base.limits import POSITIVE
from ..base.units import UNITLESS, Units, is_quantity, strip_to, without_unit
from ..base.values import ScalarFields
from ..errors import InvalidInput
from ..typing import Floats
from .geodesic import geodesic_mesh, mesh_harmonics, parts_of
from .minkowski import polytope
from .polyhedron import Polyhedron

#: The largest ratio of radii, and of areas per solid angle, of a shape.
_RATIO = 1e3, 1e9


class _Series:
    """What the shapes of a series of spherical harmonics have in common."""

    __slots__ = ()

    _coefficients: Floats
    _reference_radius: Any

    coefficients = Attribute[Floats]("_coefficients", "The coefficients ((L + 1)^2,) of the series.")
    degree = Attribute[int](lambda shape: _degree(shape._coefficients), "The degree L of the series.")
    reference_radius = Attribute[Any]("_reference_radius", "The radius to which the series refers.")

    def _notes(self) -> dict[str, Any]:
        return {"series": self._coefficients.tolist()}

    def _text(self, count: str) -> str:
        name = type(self).__name__
        return f"{name}(degree {self.degree}, reference_radius={self._reference_radius}, {count})"


class HarmonicShape(_Series, Polyhedron):
    """A polyhedron whose vertices lie where the logarithm of the radius is a series of spherical harmonics.

    The radius in the direction u of the working frame is R exp(sum of c_lm Y_lm(u)), above zero everywhere, so that the
    surface is star-shaped about the origin and never crosses itself (Kaasalainen & Viikinkoski 2012, Astron. Astrophys.
    543, A97). As for any :class:`Polyhedron` the body frame lies in the centre of mass along the principal axes; the
    series stays in the working frame, see :attr:`fullbody.Body.working_frame`.

    Parameters
    ----------
    coefficients : array_like, ((L + 1)^2,)
        The numbers c_lm by degree l and, within a degree, from m = -l to m = l. Y_lm has a mean square of one over the
        sphere, so that a coefficient is the root mean square of the logarithm of the radius that it makes; with x, y
        and z the components of u, Y_00 = 1, and Y_1m is sqrt(3) times y, z, x for m = -1, 0, 1. Orders below zero are
        sines.
    degree : int, optional
        The degree L, to be checked against the number of coefficients, from which it follows.
    reference_radius : float or Quantity
        The radius R, which gives the shape its unit of length: the radius of the sphere if all coefficients are zero.
    faces : int
        The least number of faces: the mesh is the geodesic one of the next 20 n^2 faces.

    Raises
    ------
    InvalidInput
        For a number of coefficients that is no square or does not fit the degree, for numbers that are not finite, and
        for radii of which the largest is more than a thousand times the smallest.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> shape = fullbody.HarmonicShape([0.1, 0.0, 0.0, 0.0], degree=1, reference_radius="80 km")
    >>> shape
    HarmonicShape(degree 1, reference_radius=80.0 km, 1280 faces)
    >>> np.linalg.norm(shape.vertices, axis=1).max().round(6)
    <Quantity 88.413673 km>
    """

    __slots__ = ("_coefficients", "_reference_radius")

    def __init__(
        self, coefficients: Any, *, degree: int | None = None, reference_radius: Any = 1.0, faces: int = 1280
    ) -> None:
        self._coefficients, parts = _series(coefficients, degree, "HarmonicShape"), _parts(faces, 20, 0)
        self._reference_radius = Number("length", POSITIVE)(reference_radius, "reference_radius of HarmonicShape")
        mesh = geodesic_mesh(parts)
        factors = _exponential(self._coefficients, parts, _RATIO[0], "radii of HarmonicShape")
        super().__init__(factors[:, None] * mesh.points * self._reference_radius, mesh.faces)

    @classmethod
    def _rebuild(cls, vertices: Any, faces: Any, coefficients: Any, reference_radius: Any = None) -> HarmonicShape:
        """Return the shape with exactly the vertices of a file or a pickle."""
        shape = object.__new__(cls)
        Polyhedron.__init__(shape, vertices, faces)
        shape._coefficients, parts = _series(coefficients, None, "HarmonicShape"), _parts(len(faces), 20, 0)
        mesh = geodesic_mesh(parts)
        expected = _exponential(shape._coefficients, parts, _RATIO[0], "radii of HarmonicShape")[:, None] * mesh.points
        size = float(np.linalg.norm(without_unit(vertices)[0]) / np.linalg.norm(expected[0]))
        same = np.shape(vertices) == expected.shape and np.array_equal(faces, mesh.faces)
        if not same or not np.allclose(without_unit(vertices), size * expected, rtol=0.0, atol=1e-9 * size):
            raise InvalidInput("coefficients of HarmonicShape do not give its vertices; expected those of one shape")
        shape._reference_radius = size if reference_radius is None else reference_radius
        return shape

    def _with(self, units: Units, G: float) -> Self:
        other = super()._with(units, G)
        other._reference_radius = with_unit(self._reference_radius, "length", units)
        return other

    def __repr__(self) -> str:
        return self._text(f"{len(self.faces)} faces")

    def __reduce__(self) -> Any:
        return HarmonicShape._rebuild, (self.vertices, self.faces, self._coefficients, self._reference_radius)


class ConvexShape(_Series, ScalarFields):
    """A convex shape defined by the areas and the normals of its facets, without vertices: its light follows.

    The normals n are the points of a geodesic mesh, and the area of a facet is R^2 exp(sum of c_lm Y_lm(n)) times the
    solid angle of its point (Kaasalainen & Torppa 2001, Icarus 153, 24). The light of a body follows from these alone.
    Its mass, moments of inertia and centre do not: a body of this shape must be alone in its system, its body frame is
    the frame of the normals, and it spins uniformly about any axis, as the bodies of light-curve inversion do. For
    gravity, contact and events, :meth:`polyhedron` gives the polyhedron of these facets.

    Parameters
    ----------
    coefficients : array_like, ((L + 1)^2,)
        The numbers c_lm, as for :class:`HarmonicShape`. The first one, c_00, has the effect of the size alone. Areas
        are large where the surface is flat: a positive c_20 flattens the shape along z.
    degree : int, optional
        The degree L, to be checked against the number of coefficients, from which it follows.
    reference_radius : float or Quantity
        The radius R, which gives the shape its unit of length: that of the sphere if all coefficients are zero.
    faces : int
        The least number of facets: the next 10 n^2 + 2.

    Raises
    ------
    InvalidInput
        For a number of coefficients that is no square or does not fit the degree, for numbers that are not finite, and
        for areas per solid angle of which the largest is more than 1e9 times the smallest.

    Notes
    -----
    The vectors of the facets, areas times normals, of a closed surface have the sum zero. A series does not ensure it;
    :attr:`closure` is the part that is missing. In the light it counts as a dark facet, which reflects nothing.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> shape = fullbody.ConvexShape([0.0, 0, 0, 0, 0, 0, 0.2, 0, -0.3], degree=2, reference_radius=2.0)
    >>> shape, shape.polyhedron()
    (ConvexShape(degree 2, reference_radius=2.0, 1002 facets), Polyhedron(2000 vertices, 3996 faces))
    """

    __slots__ = ("_areas", "_coefficients", "_mesh", "_reference_radius")

    def __init__(
        self, coefficients: Any, *, degree: int | None = None, reference_radius: Any = 1.0, faces: int = 1002
    ) -> None:
        self._coefficients, parts = _series(coefficients, degree, "ConvexShape"), _parts(faces, 10, 2)
        self._reference_radius = Number("length", POSITIVE)(reference_radius, "reference_radius of ConvexShape")
        self._mesh = geodesic_mesh(parts)
        factors = _exponential(self._coefficients, parts, _RATIO[1], "areas of ConvexShape per solid angle")
        #: The areas in the square of the unit of the reference radius.
        self._areas: Floats = factors * self._mesh.solid_angles * float(without_unit(self._reference_radius)) ** 2

    normals = Attribute[Floats]("_mesh.points", "The outward unit normals (F, 3) of the facets.")
    areas = Attribute[Any](lambda shape: shape._areas * shape._unit**2, "The areas (F,) of the facets.")
    semi_axes = Attribute[None](lambda shape: None, "``None``, since the shape has no vertices.")

    @property
    def closure(self) -> Floats:
        """The sum (3,) of areas times normals, over the sum of areas: zero for a closed surface."""
        return np.asarray(self._areas @ self.normals / self._areas.sum())

    def polyhedron(self) -> Polyhedron:
        """Return the convex polyhedron with these facets, whose vertices solve Minkowski's problem.

        Areas that do not close are changed by the least sum of squared changes over areas before. The facets of the
        polyhedron have these areas to 1e-9 of the largest; its working frame is the frame of the normals, with the
        origin in the middle of the vertices.

        Raises
        ------
        InvalidInput
            For areas that are too far from closed, so that one of them would fall below zero.
        NotConverged
            If the areas of the facets are not reached.
        ModuleNotFoundError
            If scipy is missing.

        Examples
        --------
        >>> import fullbody
        >>> ball = fullbody.ConvexShape([0.0], reference_radius=2.0).polyhedron()
        >>> round(ball.volume / (4 / 3 * 3.14159 * 2.0**3), 2)
        1.0
        """
        vertices, faces = polytope(self.normals, self._areas)
        return Polyhedron(vertices * self._unit, faces)

    @property
    def _unit(self) -> Any:
        """The unit of length, one without units."""
        return self._reference_radius.unit if is_quantity(self._reference_radius) else 1.0

    @classmethod
    def _rebuild(cls, normals: Any, areas: Any, coefficients: Any, reference_radius: Any = None) -> ConvexShape:
        """Return the shape with exactly the areas of a file or a pickle."""
        shape = cls(coefficients, faces=len(normals))
        stored = np.array(areas, dtype=np.float64)
        same = stored.shape == shape._areas.shape and np.allclose(normals, shape.normals, rtol=0.0, atol=1e-12)
        ratio = float(stored[0] / shape._areas[0]) if same else 1.0
        if not same or not np.allclose(ratio * shape._areas, stored, rtol=1e-9, atol=0.0):
            raise InvalidInput("coefficients of ConvexShape do not give its areas; expected those of one shape")
        radius = float(np.sqrt(ratio)) if reference_radius is None else reference_radius
        return shape._changed(stored, radius)

    def _changed(self, areas: Any, reference_radius: Any) -> ConvexShape:
        """Return the shape with other areas of its facets, as plain numbers, and another reference radius."""
        other = object.__new__(ConvexShape)
        other._coefficients, other._mesh = self._coefficients, self._mesh
        other._areas, other._reference_radius = areas, reference_radius
        return other

    def _core(self, units: Units, name: str) -> Floats:
        """Return the areas of the facets in a system's units."""
        unit = units.number(1.0 * self._unit, "length", f"reference_radius of {name}")
        return self._areas * unit**2

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return {"reference_radius": (self._reference_radius, "length")}

    def _with(self, units: Units, G: float) -> ConvexShape:
        """Return the shape in a system with units: its plain numbers become Quantities in them."""
        return self._changed(self._areas, with_unit(self._reference_radius, "length", units))

    def __repr__(self) -> str:
        return self._text(f"{len(self.normals)} facets")

    def _parts(self) -> tuple[Any, ...]:
        return (self._coefficients, self._reference_radius, self._areas)

    def __hash__(self) -> int:
        return hash((ConvexShape, self._coefficients.tobytes(), len(self.normals)))

    def __reduce__(self) -> Any:
        return ConvexShape._rebuild, (self.normals, self._areas, self._coefficients, self._reference_radius)


def with_areas(shape: ConvexShape, areas: Any) -> ConvexShape:
    """Return a shape with other areas (F,) of its facets and the coefficients of the first one, for derivatives."""
    numbers = strip_to(areas, shape._unit**2, "areas") if is_quantity(areas) else np.asarray(areas)
    return shape._changed(numbers, shape._reference_radius)


def _series(coefficients: Any, degree: int | None, of: str) -> Floats:
    """Return the coefficients ((L + 1)^2,) of a series, whose number has to fit its degree."""
    if isinstance(coefficients, list | tuple) and all(isinstance(number, float | int) for number in coefficients):
        # The checks of a list look at each of its numbers, which takes long.
        coefficients = np.array(coefficients)
    series: Floats = UNITLESS.numbers(coefficients, "number", f"coefficients of {of}", ("C",)).copy()
    count, size = len(series), int(np.sqrt(len(series)) + 0.5)
    expected = "(L + 1)^2 for a degree L from 0 to 60"
    if degree is not None:
        size = whole_number(degree, f"degree of {of}", 0, 60) + 1
        expected = f"{size**2} for degree {degree}"
    if not count or size**2 != count or size > 61:
        raise InvalidInput(f"coefficients of {of} has {count} numbers; expected {expected}")
    series.flags.writeable = False
    return series


def _degree(coefficients: Floats) -> int:
    return int(np.sqrt(len(coefficients)) + 0.5) - 1


def _parts(faces: int, per_square: int, more: int) -> int:
    return parts_of(whole_number(faces, "faces", 12, 10**6), per_square, more)


def _exponential(coefficients: Floats, parts: int, most: float, what: str) -> Floats:
    """Return the exponentials (V,) of a series at the points of a mesh."""
    values = mesh_harmonics(parts, _degree(coefficients)) @ coefficients
    low, high = float(values.min()), float(values.max())
    if high - low > np.log(most) or max(-low, high) > 100.0:
        expected = f"expected logarithms within 100 of zero that differ by less than {np.log(most):.3g}"
        raise InvalidInput(f"{what} have logarithms from {low:.6g} to {high:.6g}; {expected}")
    return np.asarray(np.exp(values))
