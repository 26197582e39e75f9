"""Centres of light of ellipsoids, which differ from the centres of mass unless the Sun is behind the observer."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..model.context import SystemLike
from ..model.shapes import Ellipsoid, PointMass, Sphere
from ..typing import Floats
from .states import into_body

#: The least cosine; smaller ones are replaced by it.
_LEAST = 1e-12


def semi_axes(system: SystemLike, body: int) -> Floats:
    """Return the semi-axes (3,) of an ellipsoid in the system's unit; zeros for a point."""
    shape = system.bodies[body].shape
    if isinstance(shape, PointMass):
        return np.zeros(3)
    if not isinstance(shape, Ellipsoid | Sphere):
        raise InvalidInput(
            f"{system.context.names[body]} is a {type(shape).__name__}; expected an ellipsoid, a sphere or a point for "
            "photocentre=True"
        )
    parts = [part for part, *_ in system.context.bodies[body].parts]
    return np.array(parts[0], dtype=np.float64)


def photocentre(axes: Floats, attitude: Any, to_observer: Floats, to_sun: Floats) -> Any:
    """Return the offset (K, 3) of a body's centre of light from its centre, by Lommel-Seeliger's law, without events.

    Let p = A^-1 e and q = A^-1 s in body axes with A = diag(a, b, c), the pole of the unit sphere along p x q, and l
    the longitude from p toward q. The light from longitude l and latitude b is g(l) cos(b)^2 db dl with g proportional
    to cos l cos(l - alpha) / cos(l - L), alpha the angle from p to q and L that from p to p + q. The mean of A u has
    closed forms: the integrals over b are pi/2 and 4/3, and those over l are elementary.

    Parameters
    ----------
    axes : ndarray, (3,)
        Semi-axes.
    attitude : ndarray, (..., 4)
        Unit quaternions; they may be complex, as the vectors.
    to_observer, to_sun : ndarray, (..., 3)
        Vectors from the body, inertial frame.

    Returns
    -------
    ndarray, (..., 3)
        Offsets in the inertial frame.
    """
    if not axes.any():
        return np.zeros_like(to_observer)
    e, s = (vector / np.sqrt(np.sum(vector * vector, axis=-1))[..., None] for vector in (to_observer, to_sun))
    p, q = (into_body(attitude, vector) / axes for vector in (e, s))
    size_p, size_q = (np.sqrt(np.sum(v * v, axis=-1)) for v in (p, q))
    first = p / size_p[..., None]
    cos_a = np.sum(first * q, axis=-1) / size_q
    perpendicular = q / size_q[..., None] - first * cos_a[..., None]
    sin_a = np.sqrt(np.sum(perpendicular * perpendicular, axis=-1))
    # At zero phase there is no direction perpendicular to the line of sight, and the offset along it is zero.
    second = perpendicular / np.where(sin_a == 0.0, 1.0, sin_a)[..., None]
    x, y = size_p + size_q * cos_a, size_q * sin_a
    length = np.sqrt(x * x + y * y)
    cos_l, sin_l = x / length, y / length
    cos_g, sin_g = cos_a * cos_l + sin_a * sin_l, sin_a * cos_l - cos_a * sin_l
    # The angle y = l - L runs from the terminator, l = alpha - pi/2, to the limb, l = pi/2.
    # At zero phase cos y vanishes at both ends, where the factor of its logarithm is zero.
    low, high = (
        (sine, np.where(np.real(cosine) < _LEAST, _LEAST, cosine)) for sine, cosine in ((-cos_g, sin_g), (cos_l, sin_l))
    )

    def between(antiderivative: Any) -> Any:
        return antiderivative(*high) - antiderivative(*low)

    def angle(sine: Any, cosine: Any) -> Any:
        # This is the arc tangent of y relative to the middle, for complex numbers too.
        return 2.0 * np.arctan(sine / (1.0 + cosine))

    # These are integrals over y of cos, of sin and of sin^n cos^m / cos, with n + m the number of factors.
    integrals = {
        (0, 2): between(lambda sine, cosine: sine),
        (1, 1): between(lambda sine, cosine: -cosine),
        (2, 0): between(lambda sine, cosine: 2.0 * np.arctanh(sine / (1.0 + cosine)) - sine),
        (0, 3): between(lambda sine, cosine: 0.5 * (angle(sine, cosine) + sine * cosine)),
        (1, 2): between(lambda sine, cosine: 0.5 * sine * sine),
        (2, 1): between(lambda sine, cosine: 0.5 * (angle(sine, cosine) - sine * cosine)),
        (3, 0): between(lambda sine, cosine: -np.log(cosine) - 0.5 * sine * sine),
    }

    def mean(factors: list[tuple[Any, Any]]) -> Any:
        """Return the integral over y of a product of factors a cos(y) + b sin(y), divided by cos(y)."""
        terms: dict[int, Any] = {0: 1.0}
        for of_cos, of_sin in factors:
            product: dict[int, Any] = {}
            for power, value in terms.items():
                product[power] = product.get(power, 0.0) + value * of_cos
                product[power + 1] = product.get(power + 1, 0.0) + value * of_sin
            terms = product
        return sum(value * integrals[power, len(factors) - power] for power, value in terms.items())

    # These are the coefficients of cos y and sin y in cos l, sin l and cos(l - alpha).
    cosine, sine, incidence = (cos_l, -sin_l), (sin_l, cos_l), (cos_g, sin_g)
    light = 0.5 * np.pi * mean([cosine, incidence])
    if not (np.real(light) > 0.0).all():
        raise InvalidInput("the Sun is behind a body, which has no centre of light; expected a phase angle below pi")
    along_first, along_second = (4.0 / 3.0 * mean([cosine, incidence, item]) / light for item in (cosine, sine))
    offset = (first * along_first[..., None] + second * along_second[..., None]) * axes
    return into_body(attitude * [1.0, -1.0, -1.0, -1.0], offset)
