"""Prior knowledge of free-form shapes: smoothness, convexity, closed facets, and rotation about a principal axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.kinds import whole_number
from ..base.limits import NOT_NEGATIVE, POSITIVE
from ..base.units import UNITLESS, Units
from ..errors import InvalidInput
from ..model.freeform import ConvexShape
from ..model.geodesic import degrees
from ..model.polyhedron import Polyhedron, mass_properties
from ..model.surface import Surface, surface_of
from ..observing.measured import Measured
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record
from ..typing import Floats

#: The step of a derivative along the imaginary axis, which subtracts no nearly equal numbers.
_STEP = 1e-100

_Faces = npt.NDArray[np.int64]


def smoothness(degree: int, sigma: Any, power: float = 2.0) -> Floats:
    """Return standard errors of the coefficients of a series of spherical harmonics, smaller for higher degrees.

    They are the prior of a smooth shape: ``Free(zeros, prior=(0.0, smoothness(6, 0.3)[1:]))``, without the first
    coefficient, which is that of the size.

    Parameters
    ----------
    degree : int
        The highest degree L of the series.
    sigma : float
        The standard error s of coefficients of degree 1; those of degree l have s / l^p, infinite for l = 0.
    power : float
        The power p, zero or above. At 2 the logarithms of two neighbouring radii differ by about s times their angle,
        from whichever degrees.

    Returns
    -------
    ndarray, ((L + 1)^2,)

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.smoothness(2, 0.4)
    array([inf, 0.4, 0.4, 0.4, 0.1, 0.1, 0.1, 0.1, 0.1])
    """
    size = UNITLESS.number(sigma, "number", "sigma", POSITIVE)
    exponent = UNITLESS.number(power, "number", "power", NOT_NEGATIVE)
    by_coefficient = degrees(whole_number(degree, "degree", 0, 60))
    return np.divide(size, by_coefficient**exponent, out=np.full(len(by_coefficient), np.inf), where=by_coefficient > 0)


class Regularisation(Measured):
    """A number, or several, of the shape of a body that is zero up to an error; one of the observations of a fit.

    It is made by :func:`closure`, :func:`convexity` and :func:`principal_axis`. Its derivatives in a fit are exact.
    """

    def __init__(
        self,
        name: str,
        body: int | str,
        kind: type[Any],
        count: int,
        numbers: Callable[[Surface, Any], Any],
        sigma: Any,
    ) -> None:
        #: The ``numbers`` are an analytic function of the surface, and of the normals or the faces of the shape.
        self._body, self._kind, self._numbers = body, kind, numbers
        super().__init__(name, lambda run: np.real(numbers(*self._shape(run)[1:])), np.zeros(count), sigma, ())

    def _shape(self, run: Record) -> tuple[int, Surface, Any]:
        """Return the index of the body, its surface, and the faces or normals."""
        index = run.context.index(self._body, f"body of {self.name}")
        shape, surface = run.system.bodies[index].shape, surface_of(run.context.bodies[index])
        if surface is None or not isinstance(shape, self._kind):
            which = f"{run.context.names[index]} is a {type(shape).__name__}"
            raise InvalidInput(f"body of {self.name}: {which}; expected a {self._kind.__name__}")
        return index, surface, shape.normals if isinstance(shape, ConvexShape) else shape.faces

    def derivatives(self, run: Record) -> FunctionDerivatives:
        """Return the derivatives of the pulls by the start of a run, which are zero, and by its parameters."""
        index, surface, mesh = self._shape(run)
        errors = Units().strip(self.sigma, "number", "sigma")
        none = np.zeros(len(errors))
        by_parameter = dict.fromkeys(run.parameters, none)
        for name, deformation in run.context.deformations.items():
            if index in deformation:
                pairs = zip(surface, deformation[index], strict=True)
                moved = Surface(*(part + 1j * _STEP * displacement for part, displacement in pairs))
                by_parameter[name] = -np.imag(self._numbers(moved, mesh)) / _STEP / errors
        return FunctionDerivatives(none, np.zeros((len(errors), 12 * len(run.context))), by_parameter)

    def __repr__(self) -> str:
        return f"Regularisation({self.name!r}, {self.value} +- {self.sigma})"


def closure(body: int | str, sigma: Any = 0.01) -> Regularisation:
    """Return the closure of the facets of a :class:`fullbody.ConvexShape` as one of the observations of a fit.

    Parameters
    ----------
    body : int or str
    sigma : float
        The standard error of each component of :attr:`fullbody.ConvexShape.closure`: 0.01 lets a dark facet of about a
        hundredth of the surface.

    Returns
    -------
    Regularisation

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.closure("Hertha")
    Regularisation('closure of Hertha', [0. 0. 0.] +- [0.01 0.01 0.01])
    """

    def missing(surface: Surface, normals: Floats) -> Any:
        return surface.areas @ normals / surface.areas.sum()

    return Regularisation(f"closure of {body}", body, ConvexShape, 3, missing, sigma)


def convexity(body: int | str, sigma: Any = 0.02) -> Regularisation:
    """Return the concavity of a polyhedron, zero for a convex one, as one of the observations of a fit.

    It is the sum over the edges whose faces are inclined towards each other, by an angle t, of 1 - cos t times the
    areas of both faces over the area of all (after Kaasalainen & Viikinkoski 2012, Astron. Astrophys. 543, A97).

    Parameters
    ----------
    body : int or str
    sigma : float
        The standard error: the smaller, the more a convex shape is preferred. A bowl of a tenth of the surface of a
        :class:`fullbody.HarmonicShape` of 1,280 faces makes about 0.002.

    Returns
    -------
    Regularisation

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.convexity("Kalliope", 0.01)
    Regularisation('convexity of Kalliope', [0.] +- [0.01])
    """
    return Regularisation(f"convexity of {body}", body, Polyhedron, 1, _concavity, sigma)


def principal_axis(body: int | str, sigma: Any = "3 deg") -> Regularisation:
    """Return the tilt of a polyhedron's axis of largest inertia from z of its working frame, the axis of its spin.

    Parameters
    ----------
    body : int or str
    sigma : float, Quantity or str
        The standard error of the two components x and y of the tilt, radians.

    Returns
    -------
    Regularisation

    Notes
    -----
    The components are those of the unit vector along the axis, sines of angles. The axis of largest inertia must not be
    in the plane of x and y.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.principal_axis("Kalliope", "2 deg")
    Regularisation('principal axis of Kalliope', [0. 0.] +- [0.03490659 0.03490659])
    """
    error = Units().number(sigma, "angle", f"sigma of principal axis of {body}", POSITIVE)

    def tilt(surface: Surface, faces: _Faces) -> Any:
        _, inertia = mass_properties(surface.working, faces)
        values, axes = np.linalg.eigh(np.real(inertia))
        if values[2] - values[1] <= 1e-12 * values[2]:
            expected = "expected a shape with one axis of largest inertia"
            raise InvalidInput(f"principal axis of {body}: two of the moments of inertia are equal; {expected}")
        axes = axes * (np.sign(axes[2, 2]) or 1.0)
        # The change of an eigenvector with the matrix, to first order.
        change = axes[:, :2].T @ np.imag(inertia) @ axes[:, 2] / (values[2] - values[:2])
        return (axes[:, 2] + 1j * axes[:, :2] @ change)[:2]

    return Regularisation(f"principal axis of {body}", body, Polyhedron, 2, tilt, error)


def _concavity(surface: Surface, faces: _Faces) -> Any:
    """Return the concavity (1,) of a surface, as an analytic function of its vertices."""
    a, b, c = np.moveaxis(surface.working[faces], 1, 0)
    across = np.cross(b - a, c - a)
    double = np.sqrt(np.sum(across * across, axis=1))
    normals = across / double[:, None]
    first, second, opposite = _edges(faces)
    # The vertex of the second face that is not on the edge lies above the plane of the first one.
    above = np.sum(normals[first] * (surface.working[opposite] - a[first]), axis=1).real > 0.0
    sharpness = 1.0 - np.sum(normals[first] * normals[second], axis=1)
    areas = (double[first] + double[second]) / double.sum()
    return np.atleast_1d(np.sum((sharpness * areas)[above]))


def _edges(faces: _Faces) -> tuple[_Faces, _Faces, _Faces]:
    """Return for each edge its two faces, and the vertex of the second one that is not on it."""
    ends = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    face, opposite = np.tile(np.arange(len(faces)), 3), np.concatenate([faces[:, (k + 2) % 3] for k in range(3)])
    order = np.lexsort(np.sort(ends, axis=1).T)
    first, second = order[0::2], order[1::2]
    return face[first], face[second], opposite[second]
