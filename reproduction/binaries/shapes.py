"""Spheroids by their J2, along the normal of an orbit."""

from __future__ import annotations

import fullbody
import numpy as np
import numpy.typing as npt

__all__ = ["oblate", "upright"]


def oblate(radius: float, j2: float) -> fullbody.Ellipsoid:
    """Return the homogeneous spheroid with the volume of a sphere and this J2, which refers to the sphere's radius.

    Its semi-axes A, A, C have J2 = (A^2 - C^2)/(5 R^2) and A^2 C = R^3: with x = (A/R)^2 that is x^3 - 5 J2 x^2 = 1.
    """
    roots = np.roots([1.0, -5.0 * j2, 0.0, -1.0])
    # Exactly one root is positive for any J2.
    x = float(roots.real[np.abs(roots.imag) < 1e-9].max())
    return fullbody.Ellipsoid(radius * x**0.5, radius * x**0.5, radius / x)


def upright(i: float, node: float) -> npt.NDArray[np.float64]:
    """Return the attitude (4,) of a body whose z-axis is the normal of an orbit with these elements, in degrees."""
    i, node = np.radians(i) / 2.0, np.radians(node) / 2.0
    return np.array(
        [np.cos(node) * np.cos(i), np.cos(node) * np.sin(i), np.sin(node) * np.sin(i), np.sin(node) * np.cos(i)]
    )
