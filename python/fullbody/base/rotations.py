"""Rotations: quaternions ``[w, x, y, z]``, matrices, rotation vectors and Tait-Bryan angles.

An attitude is the quaternion of the rotation from the body frame to the inertial one.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import fullbody._core as _core

from ..typing import Floats


def about_axis(axis: int, angle: float) -> Floats:
    """Return the quaternion (4,) of a rotation about axis 0, 1 or 2 by an angle in radians."""
    angles = [0.0, 0.0, 0.0]
    angles[axis] = angle
    return _core.quaternion_of_tait_bryan(angles)


def about(axis: Any, angle: float) -> Floats:
    """Return the quaternion (4,) of a rotation by an angle in radians about an axis (3,) of any length above zero."""
    direction = np.asarray(axis, dtype=np.float64)
    # The axis is scaled first, since squares of numbers near the limits of floats overflow or vanish.
    direction = direction / np.abs(direction).max()
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) / np.linalg.norm(direction) * direction)])


def of_plane(node: float, inclination: float) -> Floats:
    """Return the attitude (4,) of a plane: its x-axis points to the ascending node and its z-axis to the pole."""
    return product(about_axis(2, node), about_axis(0, inclination))


def shortest(first: Any, second: Any) -> Floats:
    """Return the quaternion (4,) of the smallest rotation from one unit vector (3,) to another that is not opposite."""
    rotation = np.append(1.0 + np.dot(first, second), np.cross(first, second))
    return np.asarray(rotation / np.linalg.norm(rotation))


def product(*quaternions: Any) -> Floats:
    """Return the product of quaternions: like a product of matrices, it applies the last rotation first."""
    return functools.reduce(_core.quaternion_product, quaternions)


def products(first: Floats, second: Floats) -> Floats:
    """Return the products (..., 4) of quaternions (..., 4), each of which rotates by ``second``, then by ``first``."""
    (w, v), (u, r) = ((q[..., :1], q[..., 1:]) for q in (first, second))
    scalar = w * u - (v * r).sum(axis=-1, keepdims=True)
    return np.concatenate([scalar, w * r + u * v + np.cross(v, r)], axis=-1)


def inverse(quaternions: Floats) -> Floats:
    """Return the quaternions (..., 4) of the inverse rotations."""
    return quaternions * [1.0, -1.0, -1.0, -1.0]


def unit_vectors(longitude: Any, latitude: Any) -> Floats:
    """Return the unit vectors (..., 3) of longitudes and latitudes (...) in radians."""
    lon, lat = np.asarray(longitude, dtype=np.float64), np.asarray(latitude, dtype=np.float64)
    return np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)


def rates(attitudes: Floats, spins: Floats) -> Floats:
    """Return the time derivatives (..., 4) of attitudes (..., 4), from the spins (..., 3) in their body frames."""
    return 0.5 * products(attitudes, np.insert(spins, 0, 0.0, axis=-1))


def of_vectors(vectors: Any) -> Floats:
    """Return the quaternions (..., 4) of rotation vectors (..., 3), whose length is the angle in radians."""
    v = np.asarray(vectors, dtype=np.float64)
    angle = np.linalg.norm(v, axis=-1, keepdims=True)
    # np.sinc(x) is sin(pi x) / (pi x), with a value at zero.
    return np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / np.pi) * v], axis=-1)


def between(first: Floats, second: Floats) -> Floats:
    """Return the shortest rotation vectors (..., 3) from attitudes (..., 4) to others, in the first body frames."""
    rotation = products(inverse(first), second)
    scalar, vector = rotation[..., :1], np.where(rotation[..., :1] < 0.0, -rotation[..., 1:], rotation[..., 1:])
    sine = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, np.abs(scalar))
    return np.asarray(vector * np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 0.0))


def quaternion(matrix: Any) -> Floats:
    """Return the quaternion (4,) with w >= 0 of a rotation matrix (3, 3).

    It is an eigenvector of the matrix of Bar-Itzhack (2000, J. Guid. Control Dyn. 23, 1085).
    """
    m = np.asarray(matrix, dtype=np.float64)
    k = np.zeros((4, 4))
    k[1:, 1:] = m + m.T - np.trace(m) * np.eye(3)
    k[0, 1:] = k[1:, 0] = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    k[0, 0] = np.trace(m)
    q: Floats = np.linalg.eigh(k)[1][:, -1]
    return q if q[0] >= 0.0 else -q


def matrices(quaternions: Any) -> Floats:
    """Return the rotation matrices (..., 3, 3) of quaternions (..., 4)."""
    q = np.asarray(quaternions, dtype=np.float64)
    return _core.rotation_matrices(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3, 3)


def tait_bryan(quaternions: Any) -> Floats:
    """Return the Tait-Bryan angles (K, 3) of quaternions (K, 4): phi, theta and psi of R = Rz(psi) Ry(theta) Rx(phi).

    Phi and psi are in (-pi, pi], theta is in [-pi/2, pi/2].
    """
    q = np.ascontiguousarray(quaternions, dtype=np.float64)
    zeros = np.zeros((len(q), 3))
    return _core.State(0.0, zeros, zeros, q, zeros).tait_bryan if len(q) else zeros


def is_rotation(matrix: Any, tolerance: float = 1e-9) -> bool:
    """Return whether a matrix (3, 3) is orthogonal with determinant one."""
    m = np.asarray(matrix, dtype=np.float64)
    # A rotation has no entry above one, and the squares of very large ones would overflow.
    if not np.abs(m).max() <= 1.0 + tolerance:
        return False
    return bool(np.abs(m @ m.T - np.eye(3)).max() <= tolerance and np.linalg.det(m) > 0.0)
