"""Writes the column "exact" of hidden_light.json: the light of a body of which another one hides parts, in 18 digits.

Independent of the code: Lommel-Seeliger's law integrated over the plane of the sky, in mpmath. Lines parallel to the
plane's second axis cut the ellipsoid in ellipses. On each, the limb, the terminator and the edges of what is hidden are
the real roots of quartics in the tangent of half an angle. Between them the law is integrated by Gauss's rule, halved
until it has converged; across the lines by the doubly exponential rule between the places at which the roots change.
The poses are those of light_curve.json at the rows where that file's light of body B is off by more than 1e-11.
Run: python tests/data/make_hidden_light.py
"""

import functools
import itertools
import json
import operator
import pathlib

from mpmath import atan, cos, matrix, mp, mpf, polyroots, quad, sqrt, tan
from mpmath.calculus.quadrature import GaussLegendre

mp.dps = 22
FOLDER = pathlib.Path(__file__).parent
NODES = GaussLegendre(mp).calc_nodes(4, 90)
#: The cosine and the sine of an angle, and one, times 1 + t^2 with t the tangent of half the angle.
COS, SIN, ONE = ([mpf(x) for x in row] for row in ([1, 0, -1], [0, 2, 0], [1, 0, 1]))


def vector(numbers):
    return [mpf(float(x)) for x in numbers]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / sqrt(dot(a, a)) for x in a]


def rotation(quaternion):
    w, x, y, z = unit(vector(quaternion))
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def combined(factors, polynomials):
    """Return the sum of polynomials of one degree with factors."""
    return [dot(factors, column) for column in zip(*polynomials, strict=True)]


def product(p, q):
    out = [mpf(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += a * b
    return out


def value(p, t):
    total = mpf(0)
    for c in reversed(p):
        total = total * t + c
    return total


def gauss(f, a, b):
    middle, half = (a + b) / 2, (b - a) / 2
    return half * sum(w * f(middle + half * x) for x, w in NODES)


def adaptive(f, a, b, estimate=None):
    middle = (a + b) / 2
    low, high = gauss(f, a, middle), gauss(f, middle, b)
    if estimate is not None and abs(low + high - estimate) < mpf(10) ** -21:
        return low + high
    return adaptive(f, a, middle, low) + adaptive(f, middle, b, high)


class Scene:
    """An ellipsoid at the origin and one that may hide it, in axes of which the third is toward the observer."""

    def __init__(self, nights, row, mutual):
        e, s = (unit(vector(nights[name])) for name in ("to_observer", "to_sun"))
        first = unit(cross(e, vector([0.3, 0.5, -0.7])))
        frame = [first, cross(e, first), e]
        m, other = (
            self.shape(axes, q, frame) for axes, q in zip(nights["axes"][::-1], row["attitude"][::-1], strict=True)
        )
        offset = [a - b for a, b in zip(*(vector(x) for x in row["position"]), strict=True)]
        self.sun, self.offset = ([dot(axis, v) for axis in frame] for v in (s, offset))
        directions = [vector([0, 0, 1]), self.sun] if mutual else []
        self.hiding = [self.cylinder(other, d) for d in directions if dot(self.offset, d) > 0]
        self.m = m
        # The coordinates (z, y) of a line's ellipse: L L^T = [[m22, m12], [m12, m11]].
        low = sqrt(m[2][2])
        shear = m[1][2] / low
        self.high = sqrt(m[1][1] - shear**2)
        determinant = m[2][2] * m[1][1] - m[1][2] ** 2
        z = -(m[1][1] * m[0][2] - m[1][2] * m[0][1]) / determinant
        y = -(m[2][2] * m[0][1] - m[1][2] * m[0][2]) / determinant
        self.middle, self.square = [mpf(1), y, z], m[0][0] + m[0][1] * y + m[0][2] * z
        self.end = 1 / sqrt(self.square)
        self.axes = [[mpf(0), mpf(0), 1 / low], [mpf(0), 1 / self.high, -shear / (low * self.high)]]

    @staticmethod
    def shape(axes, quaternion, frame):
        columns = matrix(frame) * matrix(rotation(quaternion)) * mp.diag([1 / a for a in vector(axes)])
        return (columns * columns.T).tolist()

    @staticmethod
    def cylinder(m, d):
        md = [dot(row, d) for row in m]
        return [[m[i][j] - md[i] * md[j] / dot(d, md) for j in range(3)] for i in range(3)]

    def line(self, x):
        """Return the radius of a line's ellipse, its normals, and the functions that are positive on the visible part."""
        radius = sqrt(max(1 - self.square * x * x, mpf(0)))
        points = [
            combined([x * self.middle[i], radius * self.axes[0][i], radius * self.axes[1][i]], [ONE, COS, SIN])
            for i in range(3)
        ]
        normal = [combined(row, points) for row in self.m]
        conditions = [combined(self.sun, normal)]
        from_other = [
            [p - a * component for p, component in zip(point, ONE, strict=True)]
            for point, a in zip(points, self.offset, strict=True)
        ]
        for c in self.hiding:
            terms = [product(from_other[i], from_other[j]) for i in range(3) for j in range(3)]
            conditions.append(combined([*functools.reduce(operator.iadd, c, []), mpf(-1)], [*terms, product(ONE, ONE)]))
        return radius, normal, conditions

    def cuts(self, conditions):
        """Return the roots of the conditions between the limbs, each with the number of its condition."""
        cuts = [(mpf(-1), -1), (mpf(1), -1)]
        for number, condition in enumerate(conditions):
            p, largest = list(condition), max(abs(c) for c in condition)
            while len(p) > 1 and abs(p[-1]) < mpf(10) ** -mp.dps * largest:
                p.pop()
            roots = polyroots(p[::-1], maxsteps=300, extraprec=60) if len(p) > 1 else []
            cuts += [(t.real, number) for t in map(mp.mpc, roots) if abs(t.imag) < mpf(10) ** -16 and abs(t.real) < 1]
        return sorted(cuts)

    def parts(self, x):
        radius, normal, conditions = self.line(x)
        cuts = [t for t, _ in self.cuts(conditions)]
        pairs = [(a, b) for a, b in itertools.pairwise(cuts) if b - a > mpf(10) ** -17]
        seen = [(a, b) for a, b in pairs if all(value(c, (a + b) / 2) > 0 for c in conditions)]
        return radius, normal, conditions[0], seen

    def kind(self, x):
        conditions = self.line(x)[2]
        cuts = self.cuts(conditions)
        middles = [(a + b) / 2 for (a, _), (b, _) in itertools.pairwise(cuts)]
        return [n for _, n in cuts], [all(value(c, t) > 0 for c in conditions) for t in middles]

    def across(self, x):
        """Return the integral along a line."""
        radius, normal, light, seen = self.parts(x)

        def brightness(angle):
            t = tan(angle / 2)
            incident, emitted = value(light, t), value(normal[2], t)
            return incident / (emitted + incident) * radius * cos(angle) / self.high

        return sum(adaptive(brightness, 2 * atan(a), 2 * atan(b)) for a, b in seen)

    def total(self, count=1200):
        near = [self.end * (1 - mpf(2) ** -k / count) for k in range(40)]
        lines = [self.end * (2 * (k + mpf(1) / 3) / count - 1) for k in range(count)]
        lines = sorted([*lines, *near, *(-x for x in near)])
        breaks = [-self.end, self.end]

        def bisect(a, at_a, b, at_b):
            if at_a == at_b:
                return
            middle = (a + b) / 2
            if b - a < mpf(10) ** -19 * self.end:
                breaks.append(middle)
                return
            between = self.kind(middle)
            bisect(a, at_a, middle, between)
            bisect(middle, between, b, at_b)

        kinds = [self.kind(x) for x in lines]
        for k in range(len(lines) - 1):
            bisect(lines[k], kinds[k], lines[k + 1], kinds[k + 1])
        breaks.sort()
        pairs = [[a, b] for a, b in itertools.pairwise(breaks) if b - a > mpf(10) ** -18]
        return sum(quad(self.across, pair, maxdegree=6) for pair in pairs)


if __name__ == "__main__":
    nights = json.loads((FOLDER / "light_curve.json").read_text())
    path = FOLDER / "hidden_light.json"
    data = json.loads(path.read_text())
    for row in data["rows"]:
        row["exact"] = float(Scene(nights, row, True).total())
        print(row["row"], row["exact"], flush=True)
    path.write_text(json.dumps(data, indent=1) + "\n")
