"""Kalliope as a body of free form, Linus as a sphere: their shapes, and the state from which they start."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody.fitting import Free

from .model import AXES, PERIOD, binary

__all__ = ["FreeForm", "principal"]

Floats = npt.NDArray[np.float64]

#: The radius of Kalliope in km to which the series refers, about that of the published volume.
RADIUS = 75.0
#: Ferrais et al. (2022): the diameter of Kalliope in km, with its error.
DIAMETER = (150.0, 5.0)
#: The standard error of a coefficient of degree 2 in the prior that makes the shape smooth; it falls as degree^-2.
ROUGHNESS = 0.2


@dataclass(frozen=True)
class FreeForm:
    """Bodies whose size in all directions is a series of spherical harmonics.

    Attributes
    ----------
    degree : int
        The degree of the series of the logarithm of Kalliope's radius.
    faces, faces_of_linus : int
        The least numbers of faces of both bodies.
    """

    degree: int = 6
    faces: int = 1280
    faces_of_linus: int = 320

    @property
    def terms(self) -> list[tuple[int, int]]:
        """The degrees and orders of the free coefficients.

        That of degree 0 is the size. Those of degree 1 would move the shape in its frame, and the three that are
        missing here would turn it there.
        """
        terms = [(degree, order) for degree in range(2, self.degree + 1) for order in range(-degree, degree + 1)]
        return [term for term in terms if term not in [(2, -2), (2, -1), (2, 1)]]

    @property
    def prior(self) -> Floats:
        """The standard errors (C,) of the coefficients in the prior, whose mean is zero."""
        return np.array([ROUGHNESS * (2.0 / degree) ** 2 for degree, _ in self.terms])

    @property
    def growth(self) -> float:
        """The factor by which the vertices of Linus are farther from its centre than the surface of the sphere.

        Both then have the same area, and thus the same mean cross-section (Cauchy).
        """
        return _growth(self.faces_of_linus)

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
        ones = [self.shape(1.0, zero), *(self.shape(0.0, row) for row in unit)]
        design = np.stack([np.log(np.linalg.norm(one.vertices, axis=1) / RADIUS) for one in ones], axis=1)
        directions = np.asarray(self.shape(0.0, zero).vertices) / RADIUS
        radius = np.sum((directions / np.asarray(axes)) ** 2, axis=1) ** -0.5
        size, *coefficients = np.linalg.lstsq(design, np.log(radius / RADIUS), rcond=None)[0]
        return float(size), np.array(coefficients)

    def parameters(self, start: dict[str, float]) -> dict[str, Any]:
        """Return the parameters of a fit that starts from the shape of the ellipsoid and from these other values.

        The published diameter is the prior of the size: larger bodies whose events graze each other more, about another
        pole, fit the light as well.
        """
        size, coefficients = self.nearest(AXES)
        free = {
            "size": Free(size, prior=(np.log(0.5 * DIAMETER[0] / RADIUS), DIAMETER[1] / DIAMETER[0])),
            "coefficients": Free(coefficients, prior=(0.0, self.prior)),
        }
        return {**start, "period": PERIOD, **free}

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
        linus = fullbody.HarmonicShape([0.0], reference_radius=radius * self.growth, faces=self.faces_of_linus)
        angles = (longitude, pole_longitude, pole_latitude, phase)
        return binary(self.shape(size, coefficients), linus, angles, "harmonic", period)


def principal(shape: fullbody.Polyhedron) -> fullbody.Polyhedron:
    """Return a polyhedron in plain numbers with the centre of mass as the origin and the principal axes as axes."""
    frame = fullbody.Body(shape, density=1.0).working_frame
    assert frame is not None
    rotation = fullbody.base.rotations.matrices(frame.attitude)
    return fullbody.Polyhedron(np.asarray(shape.vertices) @ rotation.T + np.asarray(frame.position), shape.faces)


@functools.cache
def _growth(faces: int) -> float:
    """Return the radius of the vertices of a polyhedron with the area of a unit sphere."""
    ball = fullbody.HarmonicShape([0.0], faces=faces)
    a, b, c = np.moveaxis(np.asarray(ball.vertices)[np.asarray(ball.faces)], 1, 0)
    return float(np.sqrt(8.0 * np.pi / np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()))
