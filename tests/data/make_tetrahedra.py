"""Writes tetrahedra.json: the interaction of two tetrahedra in some poses, in 30 digits.

Independent of the code: the closed potential of a homogeneous polyhedron (Werner & Scheeres 1996), of the first body,
integrated over the faces of the second by Gauss's rule on the square that is folded to a triangle. By Gauss's theorem
the force on the second is the integral of the potential times the outward normal, and its torque that of the potential
times y x n; the torque on the first follows from the balance of torques. `error` is the difference of rules of 22 and
28 nodes on a side, relative to the force.
Run: python tests/data/make_tetrahedra.py
"""

import json
import pathlib

import mpmath as mp

mp.mp.dps = 40
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
FIRST = ((0.1, -0.2, -0.5), (0.9, 0.1, -0.3), (-0.3, 0.8, -0.2), (-0.1, 0.05, 0.7))
SECOND = ((-0.2, -0.3, -0.1), (0.5, -0.1, 0.05), (-0.1, 0.35, 0.0), (0.0, 0.1, 0.4))
SEPARATIONS = ((1.7, 0.6, -0.5), (-1.5, 2.0, 1.0), (3.0, -7.0, 5.0))


def vector(numbers):
    return [mp.mpf(number) for number in numbers]


def dot(a, b):
    return mp.fsum(p * q for p, q in zip(a, b, strict=True))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def less(a, b):
    return [p - q for p, q in zip(a, b, strict=True)]


def scaled(factor, a):
    return [factor * p for p in a]


def total(vectors):
    return [mp.fsum(components) for components in zip(*vectors, strict=True)]


def centre(corners):
    return scaled(mp.mpf(1) / 4, total(corners))


def volume(corners):
    a, b, c = (less(corner, corners[0]) for corner in corners[1:])
    return dot(a, cross(b, c)) / 6


def potential(corners, x):
    """Return the positive potential of a homogeneous tetrahedron of unit mass at an exterior point."""
    out = mp.mpf(0)
    for face in FACES:
        ends = [less(corners[k], x) for k in face]
        lengths = [mp.sqrt(dot(end, end)) for end in ends]
        normal = cross(less(ends[1], ends[0]), less(ends[2], ends[0]))
        normal = scaled(1 / mp.sqrt(dot(normal, normal)), normal)
        height = dot(normal, ends[0])
        for k in range(3):
            a, b, p, q = ends[k], ends[(k + 1) % 3], lengths[k], lengths[(k + 1) % 3]
            edge = less(b, a)
            length = mp.sqrt(dot(edge, edge))
            outward = dot(cross(scaled(1 / length, edge), normal), a)
            out += height * outward * mp.log((p + q + length) / (p + q - length))
        numerator = dot(ends[0], cross(ends[1], ends[2]))
        denominator = lengths[0] * lengths[1] * lengths[2]
        denominator += mp.fsum(lengths[k] * dot(ends[(k + 1) % 3], ends[(k + 2) % 3]) for k in range(3))
        out -= height * height * 2 * mp.atan2(numerator, denominator)
    return out / 2 / volume(corners)


def gauss(n):
    """Return the nodes and weights of Gauss's rule on the interval from 0 to 1."""
    out = []
    for k in range(n):
        x = mp.cos(mp.pi * (k + mp.mpf(3) / 4) / (n + mp.mpf(1) / 2))
        for _ in range(8):
            p, q = mp.mpf(1), x
            for j in range(2, n + 1):
                p, q = q, ((2 * j - 1) * x * q - (j - 1) * p) / j
            slope = n * (x * q - p) / (x * x - 1)
            x -= q / slope
        out.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
    return out


def interaction(first, second, n):
    """Return the force on the second body and the torques about both centres of mass, for unit masses and G."""
    force, torque = [], []
    middle = centre(second)
    rule = gauss(n)
    for face in FACES:
        a, b, c = (second[k] for k in face)
        normal = cross(less(b, a), less(c, a))
        for s, u in rule:
            for t, v in rule:
                y = total([scaled(1 - s, a), scaled(s * (1 - t), b), scaled(s * t, c)])
                weight = u * v * s * potential(first, y)
                force.append(scaled(weight, normal))
                torque.append(scaled(weight, cross(less(y, middle), normal)))
    density = 1 / volume(second)
    force, torque = (scaled(density, total(terms)) for terms in (force, torque))
    arm = less(middle, centre(first))
    return force, scaled(-1, total([torque, cross(arm, force)])), torque


def text(numbers):
    return [mp.nstr(number, 30) for number in numbers]


def main():
    cases = []
    for separation in SEPARATIONS:
        first = [vector(corner) for corner in FIRST]
        second = [total([vector(corner), vector(separation)]) for corner in SECOND]
        rough, fine = (interaction(first, second, n) for n in (22, 28))
        size = mp.sqrt(dot(fine[0], fine[0]))
        error = max(abs(p - q) for pair in zip(rough, fine, strict=True) for p, q in zip(*pair, strict=True))
        force, torque_first, torque_second = fine
        cases.append(
            {
                "separation": list(separation),
                "force_on_second": text(force),
                "torque_on_first": text(torque_first),
                "torque_on_second": text(torque_second),
                "error": mp.nstr(error / size, 3),
            }
        )
    note = "unit masses, G = 1; all vectors along the axes of the vertices, torques about the centres of mass"
    written = {"note": note, "faces": FACES, "first": FIRST, "second": SECOND, "cases": cases}
    path = pathlib.Path(__file__).with_name("tetrahedra.json")
    path.write_text(json.dumps(written, indent=1) + "\n")


if __name__ == "__main__":
    main()
