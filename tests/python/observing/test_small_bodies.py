"""Light of a body partly behind a much larger or smaller one: closed forms in extended precision, and strips."""

import mpmath
import numpy as np
import pytest
from fullbody import Body, Ellipsoid, Sphere, State, System, observing
from fullbody.observing.brightness import Epochs, Photometer
from support import matrix
from support.strips import strips

LONG = np.longdouble
EPSILON = np.finfo(float).eps


def overlap(r, s, d):
    """The common area of two circles in extended precision, arrays (K,)."""
    near = np.clip((r + s - d) * (d + r - s) * (d - r + s) * (d + r + s), 0, None)
    half = np.sqrt(near) / (2 * d)

    def segment(r, s):
        x = (d * d + (r - s) * (r + s)) / (2 * d)
        return r * r * np.arctan2(half, x) - x * half

    inside = np.where(r < s, r, s) ** 2 * LONG(np.pi)
    return np.where(d >= r + s, 0, np.where(d <= abs(r - s), inside, segment(r, s) + segment(s, r)))


def test_ten_thousand_pairs_of_spheres_have_the_overlap_of_circles():
    assert np.finfo(LONG).eps < 1e-18, "this test needs extended precision"
    rng = np.random.default_rng(45)
    worst, partly, count = 0.0, 0, 100
    for ratio in 10.0 ** rng.uniform(-7.0, 0.0, 100):
        # The smaller body is somewhere across the outline of the larger one, or just touches it.
        offset = 1.0 + ratio * np.append(rng.uniform(-1.0, 1.0, count - 2), [-1.0, 1.0])
        angle = rng.uniform(0, 2 * np.pi, count)
        centre = np.stack([offset * np.cos(angle), offset * np.sin(angle), np.full(count, 3.0)], axis=1)
        sizes = (ratio, 1.0) if rng.random() < 0.8 else (1.0, ratio)
        behind, front = (LONG(size) for size in sizes)
        expected = 0.5 * (LONG(np.pi) * behind**2 - overlap(behind, front, np.hypot(*centre[:, :2].T.astype(LONG))))
        system = System([Body(Sphere(size), mass=1.0) for size in sizes], G=1.0)
        photometer = Photometer(system, observing.LommelSeeliger(), 1.0, True, 0.0)
        positions, attitude = np.stack([0 * centre, centre], axis=1), np.tile([1.0, 0, 0, 0], (count, 2, 1))
        direction = np.tile([0.0, 0.0, 1.0], (count, 1))
        result = photometer.brightness(Epochs(np.zeros(count), positions, attitude, direction, direction))[:, 0]
        worst = max(worst, float(np.max(np.abs(result - expected)) / behind**2))
        partly += np.sum((result < 0.49 * np.pi * ratio**2) & (result > 0.01 * np.pi * ratio**2))
    assert partly > 5_000
    assert worst < 1e-10


def uncovered(small, large, positions):
    """The area of the first ellipse that the second one does not cover, for 2 x 2 covariances, in high precision.

    The first is mapped to the unit circle; the area is an integral along arcs of both outlines.
    """
    with mpmath.workdps(50):
        c = mpmath.cholesky(small)
        inverse = c**-1
        q, centre = inverse * large * inverse.T, inverse * positions
        v = mpmath.cholesky(q)
        m = q**-1

        # The angles at which the circle crosses the other ellipse: a quartic in t = tan(phi / 2).
        def level(x, z):
            a, b = x - centre[0], z - centre[1]
            return m[0, 0] * a * a + 2 * m[0, 1] * a * b + m[1, 1] * b * b - 1

        samples = [mpmath.expjpi(2 * mpmath.mpf(k) / 5) for k in range(5)]
        values = [level(s.real, s.imag) for s in samples]
        phases = ([mpmath.expjpi(-2 * mpmath.mpf(k * n) / 5) for k in range(5)] for n in range(-2, 3))
        fourier = [mpmath.fdot(values, row) / 5 for row in phases]
        roots = mpmath.polyroots(fourier, maxsteps=500, extraprec=300, asc=True)
        angles = sorted(mpmath.arg(w) for w in roots if abs(abs(w) - 1) < mpmath.mpf(10) ** -20)
        total = mpmath.mpf(0)
        if not angles:
            # The outlines do not cross: all of the circle, what one inside it leaves, or nothing.
            if level(mpmath.mpf(1), mpmath.mpf(0)) <= 0:
                return 0.0
            inside = centre[0] ** 2 + centre[1] ** 2 < 1
            return float((mpmath.pi - (mpmath.pi * mpmath.det(v) if inside else 0)) * mpmath.det(c))
        for first, second in zip(angles, [*angles[1:], angles[0] + 2 * mpmath.pi], strict=True):
            middle = (first + second) / 2
            if level(mpmath.cos(middle), mpmath.sin(middle)) > 0:
                total += (second - first) / 2
                continue
            # The arc of the other ellipse from the first crossing to the second inside the circle.
            ends = [mpmath.matrix([mpmath.cos(a), mpmath.sin(a)]) for a in (first, second)]
            local = [mpmath.lu_solve(v, end - centre) for end in ends]
            theta = [mpmath.atan2(w[1], w[0]) for w in local]
            angle = (theta[0] - theta[1]) % (2 * mpmath.pi)
            # Along the other outline, clockwise from the first to the second crossing, the covered side is right.
            cross = centre[0] * (ends[1][1] - ends[0][1]) - centre[1] * (ends[1][0] - ends[0][0])
            total += (cross - mpmath.det(v) * angle) / 2
        return float(total * mpmath.det(c))


def projected(axes, attitude):
    """The covariance of an ellipsoid's outline across z, in high precision."""
    with mpmath.workdps(50):
        exact = np.vectorize(mpmath.mpf, otypes=[object])
        q = exact(attitude)
        rows = matrix(q / mpmath.sqrt(q @ q))[:2]
        return mpmath.matrix(rows @ np.diag(exact(axes) ** 2) @ rows.T)


def test_elongated_bodies_have_the_overlap_of_ellipses():
    rng = np.random.default_rng(46)
    partly = 0
    for _ in range(40):
        ratio = 10.0 ** rng.uniform(-7.0, 0.0)
        axes = [ratio * np.array([1.0, *rng.uniform(0.05, 1.0, 2)]), np.array([1.0, *rng.uniform(0.3, 1.0, 2)])]
        attitude = rng.normal(size=(2, 4))
        attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
        large, small = projected(axes[1], attitude[1]), projected(axes[0], attitude[0])
        direction = rng.uniform(0, 2 * np.pi)
        n = mpmath.matrix([np.cos(direction), np.sin(direction)])
        # A point of the large outline with the normal n, and a place within the small one's reach of it.
        edge = large * n / mpmath.sqrt((n.T * large * n)[0])
        offset = np.array([float(edge[0]), float(edge[1])]) + rng.uniform(-1.0, 1.0, 2) * ratio
        # The light goes along z, so that the place along it does not matter.
        state = State([[0, 0, 0], [*-offset, 4.0]], np.zeros((2, 3)), attitude)
        system = System([Body(Ellipsoid(*a), mass=1.0) for a in axes], G=1.0)
        result = observing.brightness(system, state, [0, 0, 1], [0, 0, 1])[0]
        area = np.pi * float(mpmath.sqrt(mpmath.det(small)))
        expected = uncovered(small, large, mpmath.matrix([float(-offset[0]), float(-offset[1])]))
        partly += 0.01 * area < expected < 0.99 * area
        # The attitude of the large body moves its outline by the last digit of its size.
        narrow = float(mpmath.sqrt(mpmath.eigsy(small, eigvals_only=True)[0]))
        assert abs(2 * result - expected) < (1e-10 + 20 * EPSILON / narrow) * area, (ratio, result, expected)
    assert partly > 20


@pytest.mark.parametrize("law", ["seeliger", "lambert"])
def test_small_spheres_at_a_phase_angle_are_sums_of_strips(law):
    rng = np.random.default_rng(47)
    laws = {"seeliger": observing.LommelSeeliger(), "lambert": observing.Lambert()}
    for _ in range(8):
        ratio = 10.0 ** rng.uniform(-7.0, 0.0)
        s = rng.normal(size=3)
        s[2] = abs(s[2])
        s /= np.linalg.norm(s)
        share = rng.uniform(-0.95, 0.95)
        position = 1.0 + ratio * share
        gap = float((LONG(position) - 1) / LONG(ratio))
        system = System([Body(Sphere(ratio), mass=1e-3), Body(Sphere(1.0), mass=1.0)], G=1.0)
        state = State([[0, 0, 0], [position, 0, 300.0]], np.zeros((2, 3)))
        # The Sun is not hidden where it is not right behind the other body.
        e = np.array([0, 0, 1.0])
        if abs(np.hypot(*(np.array([position, 0]) - 300.0 * s[:2] / s[2]))) < 1.5:
            continue
        result, alone = (observing.brightness(system, state, e, s, law=laws[law], mutual=m)[0] for m in (True, False))
        expected = strips(1.0 / ratio, gap, s, law) * ratio**2
        assert abs(result - expected) < 1e-10 * alone, (ratio, share, s, result, expected)
        # What an eclipse takes from Lommel-Seeliger's law is what an occultation takes with the directions exchanged.
        if law == "seeliger":
            other = observing.brightness(system, state, s, e)[0]
            assert abs(other - expected) < 1e-10 * alone
