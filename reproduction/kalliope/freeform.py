"""Kalliope as a body of free form and Linus as a sphere: their shapes and their initial state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody.fitting import Free

from .model import binary

__all__ = ["FreeForm", "principal"]

Floats = npt.NDArray[np.float64]

#: The radius of Kalliope in km to which the series refers, about that of the published volume.
RADIUS = 75.0
#: Ferrais et al. (2022): the diameter of Kalliope in km, with its error.
DIAMETER = (150.0, 5.0)
#: The standard error of a coefficient of degree 2 in the prior that makes the shape smooth; it falls as degree^-2.
ROUGHNESS = 0.1


@dataclass(frozen=True)
class FreeForm:
    """A body whose size in all directions is a series of spherical harmonics, beside a sphere.

    Attributes
    ----------
    degree : int
        The degree of the series of the logarithm of Kalliope's radius.
    faces : int
        The least number of Kalliope's faces.
    """

    degree: int = 6
    faces: int = 5120

    @property
    def terms(self) -> list[tuple[int, int]]:
        """The degrees and orders of the free coefficients.

        That of degree 0 is the size. Those of degree 1 would displace the shape in its frame, and the three of degree 2
        that are left out would rotate it.
        """
        terms = [(degree, order) for degree in range(2, self.degree + 1) for order in range(-degree, degree + 1)]
        return [term for term in terms if term not in [(2, -2), (2, -1), (2, 1)]]

    @property
    def prior(self) -> Floats:
        """The standard errors (C,) of the coefficients in the prior, whose mean is zero."""
        return np.array([ROUGHNESS * (2.0 / degree) ** 2 for degree, _ in self.terms])

    def shape(self, size: float, coefficients: Any) -> fullbody.HarmonicShape:
        """Return Kalliope's shape.

        Parameters
        ----------
        size : float
            The coefficient of degree 0: the mean logarithm of the radius over 75 km.
        coefficients : array_like, (C,)
            The coefficients of :attr:`terms`.
        """
        series = np.zeros((self.degree + 1) ** 2)
        series[0] = size
        series[[degree * (degree + 1) + order for degree, order in self.terms]] = coefficients
        return fullbody.HarmonicShape(series, reference_radius=RADIUS, faces=self.faces)

    def nearest(self, axes: Any) -> tuple[float, Floats]:
        """Return the size and the coefficients of the shape nearest to an ellipsoid with these semi-axes in km."""
        zero, unit = np.zeros(len(self.terms)), np.eye(len(self.terms))
        shapes = [self.shape(1.0, zero), *(self.shape(0.0, row) for row in unit)]
        design = np.stack([np.log(np.linalg.norm(shape.vertices, axis=1) / RADIUS) for shape in shapes], axis=1)
        directions = np.asarray(self.shape(0.0, zero).vertices) / RADIUS
        radius = np.sum((directions / np.asarray(axes)) ** 2, axis=1) ** -0.5
        size, *coefficients = np.linalg.lstsq(design, np.log(radius / RADIUS), rcond=None)[0]
        return float(size), np.array(coefficients)

    def parameters(self, start: Mapping[str, Any]) -> dict[str, Any]:
        """Return the parameters of a fit that starts from these values.

        The published diameter is the prior of the size: larger bodies whose events graze each other more, about another
        pole, fit the light as well.
        """
        priors = {
            "size": (np.log(0.5 * DIAMETER[0] / RADIUS), DIAMETER[1] / DIAMETER[0]),
            "coefficients": (0.0, self.prior),
        }
        return {**start, **{name: Free(start[name], prior=prior) for name, prior in priors.items()}}

    def setup(
        self,
        radius: float,
        longitude: float,
        pole_longitude: float,
        pole_latitude: float,
        phase: float,
        period: float,
        size: float,
        coefficients: Any,
    ) -> tuple[fullbody.System, fullbody.State]:
        """Return the system and its state at the epoch, as the setup of the ellipsoid does.

        Kalliope's principal axes take the place of those of the ellipsoid, so that it rotates about the pole. The
        ``period`` in days is that of two points on the circle on which Linus starts.
        """
        angles = (longitude, pole_longitude, pole_latitude, phase)
        return binary(self.shape(size, coefficients), fullbody.Sphere(radius), angles, "harmonic", period)


def principal(shape: fullbody.Polyhedron) -> fullbody.Polyhedron:
    """Return a polyhedron in plain numbers with the centre of mass as the origin and the principal axes as axes."""
    frame = fullbody.Body(shape, density=1.0).working_frame
    assert frame is not None
    rotation = fullbody.base.rotations.matrices(frame.attitude)
    return fullbody.Polyhedron(np.asarray(shape.vertices) @ rotation.T + np.asarray(frame.position), shape.faces)
