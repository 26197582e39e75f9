"""The attraction of two polyhedra by adaptive quadrature, from the closed potential of a polyhedron's faces."""

import numpy as np


def potential(corners, points):
    """Potential per unit G and density at points (P, 3) of a solid within triangles (F, 3, 3).

    The integral of half the outward component of the unit vector over the surface: for each face its height times
    the integral of 1/r over it, which is a sum of logarithms along the edges minus the height times the solid angle.
    """
    total = np.zeros(len(points))
    for a, b, c in corners:
        normal = np.cross(b - a, c - a)
        normal = normal / np.linalg.norm(normal)
        ends = [corner - points for corner in (a, b, c)]
        lengths = [np.linalg.norm(end, axis=1) for end in ends]
        height = ends[0] @ normal
        face = np.zeros(len(points))
        for k in range(3):
            p, q, r, s = ends[k], ends[k - 2], lengths[k], lengths[k - 2]
            edge = q[0] - p[0]
            length = np.linalg.norm(edge)
            across = p @ np.cross(edge / length, normal)
            # ln((r + s + e)/(r + s - e)) without cancellation.
            face += across * np.log1p(2.0 * length / np.maximum(r + s - length, 1e-300))
        triple = np.einsum("ij,ij->i", ends[0], np.cross(ends[1], ends[2]))
        below = lengths[0] * lengths[1] * lengths[2]
        for k in range(3):
            below += lengths[k] * np.einsum("ij,ij->i", ends[k - 2], ends[k - 1])
        total += 0.5 * height * (face - height * 2.0 * np.arctan2(triple, below))
    return total


def rule(n):
    """Points and weights of the conical product rule on a triangle, in barycentric coordinates."""
    x, w = np.polynomial.legendre.leggauss(n)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    u, v = np.meshgrid(x, x, indexing="ij")
    shares = np.stack([u, (1.0 - u) * v, (1.0 - u) * (1.0 - v)], axis=-1).reshape(-1, 3)
    return shares, (2.0 * np.outer(w * (1.0 - x), w)).ravel()


SHARES, WEIGHTS = rule(8)


def pressure(first, triangles):
    """Integrals over triangles (T, 3, 3) of the potential times normal, and times position cross normal: (T, 6)."""
    points = np.einsum("ns,tsk->tnk", SHARES, triangles)
    area = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    phi = potential(first, points.reshape(-1, 3)).reshape(points.shape[:2]) * WEIGHTS
    mean = np.einsum("tn,tnk->tk", phi, points)
    return np.concatenate([phi.sum(axis=1)[:, None] * area, np.cross(mean, area)], axis=1)


def volume(corners):
    return np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0


def attraction(first, second, centres, tolerance=1e-13):
    """Force on the second solid, and torques on both about the centres, per unit G m m: triangles (F, 3, 3).

    The triangles of the second one are divided until the sum over the parts of each agrees with the whole.
    """
    pending, total = second, np.zeros(6)
    estimate = pressure(first, pending)
    scale = np.abs(volume(first) * volume(second)) / np.linalg.norm(centres[1] - centres[0]) ** 2
    for _ in range(40):
        a, b, c = pending.transpose(1, 0, 2)
        d, e, f = 0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)
        parts = np.stack([np.stack(t, axis=1) for t in ((a, f, e), (f, b, d), (e, d, c), (d, e, f))], axis=1)
        finer = pressure(first, parts.reshape(-1, 3, 3)).reshape(-1, 4, 6)
        error = np.abs(finer.sum(axis=1) - estimate).max(axis=1)
        done = error <= tolerance * scale
        total += finer[done].sum(axis=(0, 1))
        pending, estimate = parts[~done].reshape(-1, 3, 3), finer[~done].reshape(-1, 6)
        if len(pending) == 0:
            break
    else:
        raise AssertionError("not converged")
    total /= volume(first) * volume(second)
    force = total[:3]
    on_second = total[3:] - np.cross(centres[1], force)
    return force, -on_second - np.cross(centres[1] - centres[0], force), on_second
