"""Turning vectors: quaternions ``[w, x, y, z]`` and matrices of a handful of rotations at set-up and in observables."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]


def turn(axis: int, angle: float) -> _Array:
    """The quaternion (4,) of a turn about axis 0, 1 or 2 by an angle in radians."""
    q = np.zeros(4)
    q[0], q[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def product(*quaternions: Any) -> _Array:
    """The turns one after another, the last first, as matrices multiply."""
    w, v = 1.0, np.zeros(3)
    for q in quaternions:
        u = np.asarray(q[1:], dtype=np.float64)
        w, v = w * q[0] - v @ u, w * u + q[0] * v + np.cross(v, u)
    return np.array([w, *v])


def quaternion(matrix: Any) -> _Array:
    """The quaternion (4,) of a rotation matrix (3, 3); Bar-Itzhack (2000), J. Guid. Control Dyn. 23, 1085."""
    m = np.asarray(matrix, dtype=np.float64)
    k = np.zeros((4, 4))
    k[1:, 1:] = m + m.T - np.trace(m) * np.eye(3)
    k[0, 1:] = k[1:, 0] = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    k[0, 0] = np.trace(m)
    q: _Array = np.linalg.eigh(k)[1][:, -1]
    return q if q[0] >= 0.0 else -q


def matrices(quaternions: Any) -> _Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), body frame to inertial."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, dtype=np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def is_rotation(matrix: Any, tolerance: float = 1e-9) -> bool:
    """Whether a matrix (3, 3) is orthogonal with determinant one."""
    m = np.asarray(matrix, dtype=np.float64)
    # Of a rotation no entry is above one; the squares of others may overflow.
    if not np.abs(m).max() <= 1.0 + tolerance:
        return False
    return bool(np.abs(m @ m.T - np.eye(3)).max() <= tolerance and np.linalg.det(m) > 0.0)
