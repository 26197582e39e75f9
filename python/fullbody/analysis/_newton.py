"""Newton's method for uniform rotations of a pair, and initial guesses with aligned principal axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import permutations, product
from typing import NamedTuple, TypeAlias

import numpy as np

from ..base import rotations
from ..errors import BodiesOverlap, NotConverged
from ..typing import Floats
from ._pair import Pair, Pose, shortened
from ._rotation import Kind, Rotation

#: For both bodies, the body axes (0, 1 or 2) along the line and along the angular momentum.
Axes: TypeAlias = tuple[tuple[int, int], tuple[int, int]]

_STEPS = 60
#: One step moves the centres by at most this fraction of their distance and turns bodies by at most as many radians.
_LONGEST = 0.2
#: Residuals relative to the forces: the one that counts as solved, and the one below which further steps are round-off.
_SOLVED, _ROUNDING = 1e-10, 1e-14
#: A matrix is singular if its smallest singular value is below this fraction of its largest one.
_SINGULAR = 1e-9
#: The ratio of neighbouring separations of a scan, and the ratio of the largest separation to that of contact.
_RATIO, _FARTHEST = 1.12, 100.0


def converged(guess: Rotation, kind: Kind, value: float) -> Rotation:
    """Find by Newton's method the uniform rotation near a guess at which a quantity has a given value."""

    def row(rotation: Rotation, columns: Floats) -> tuple[Floats, float]:
        slope = rotation.quantity_gradient(kind) * columns
        unit = max(abs(value), np.abs(slope).max())
        return slope / unit, (rotation.quantity(kind) - value) / unit

    quantity = kind.replace("_", " ")
    return _solved(guess, row, f"{quantity} {value:.9g}", quantity)


def corrected(rotation: Rotation, tangent: Floats, length: float) -> Rotation:
    """Find the uniform rotation in the plane across a step (10,), which is in units of `scales`."""
    if length == 0.0:
        return rotation
    step = length * tangent * rotation.scales()[1]
    guess = rotation.at(rotation.pose.moved(step[:9]), rotation.rate + step[9])
    return _solved(guess, lambda rotation, columns: (tangent, 0.0), "the branch", "the branch", 12)


def _solved(
    rotation: Rotation,
    row: Callable[[Rotation, Floats], tuple[Floats, float]],
    wanted: str,
    quantity: str,
    most: int = _STEPS,
) -> Rotation:
    """Apply Newton's method with one additional equation, given by its row (10,) and its residual."""
    size = np.inf
    for _ in range(most):
        _, columns = rotation.scales()
        last, lack = row(rotation, columns)
        matrix, missing = rotation.equations()
        matrix, missing = np.concatenate([matrix, [last]]), np.append(missing, lack)
        previous, size = size, float(np.abs(missing).max())
        if size <= _ROUNDING or (size <= _SOLVED and size >= 0.5 * previous):
            return rotation
        left, values, right = np.linalg.svd(matrix, full_matrices=False)
        if values[-1] <= _SINGULAR * values[0]:
            raise NotConverged(
                f"a relative equilibrium of {wanted}: the matrix of Newton's step is singular (condition "
                f"{values[0] / max(values[-1], 1e-300):.2g}), as at a fold in {quantity}; expected another quantity to "
                "be given, or a start away from it"
            )
        step = -right.T @ ((left.T @ missing) / values)
        step *= min(1.0, _LONGEST / max(np.abs(step[:9]).max(), 1e-300))
        rotation = shortened(partial(_moved, rotation), step * columns)
    raise NotConverged(
        f"a relative equilibrium of {wanted}: not found in {most} steps of Newton's method, forces are out of balance "
        f"by {size:.2g} of their size; there may be none of this kind (fullbody.analysis.equilibria lists those of an "
        "angular momentum), or the start is too far from it"
    )


def _moved(rotation: Rotation, step: Floats) -> Rotation:
    """Return the rotation after a step, or raise the error of bodies that overlap."""
    pose = rotation.pose.moved(step[:9])
    rotation.pair.loads(pose)
    return rotation.at(pose, rotation.rate + step[9])


@cache
def _attitude(line: int, pole: int) -> Floats:
    """Return the quaternion that puts one body axis along x and another one along z."""
    matrix = np.zeros((3, 3))
    matrix[0, line] = matrix[2, pole] = 1.0
    matrix[1] = np.cross(matrix[2], matrix[0])
    return rotations.quaternion(matrix)


def aligned(axes: Axes, distance: float) -> Pose:
    """Return the pose with the given body axes along x, which is the line between the bodies, and along z."""
    return Pose(np.array([distance, 0.0, 0.0]), np.array([_attitude(*pair) for pair in axes]))


def long_axes(pair: Pair) -> Axes:
    """Return the axes of least inertia for the line and those of greatest inertia for the angular momentum."""
    (a, _, b), (c, _, d) = (map(int, np.argsort(moments, kind="stable")) for moments in pair.inertia)
    return (a, b), (c, d)


def alignments(pair: Pair) -> Iterator[Axes]:
    """Yield all alignments of principal axes that differ by more than the symmetries of ellipsoids."""
    choices = []
    for moments in pair.inertia:
        shares = np.round(moments / max(moments.max(), 1e-300), 12)
        # The first of equal alignments is entered last, and so it is kept.
        kinds = {(shares[line], shares[pole]): (line, pole) for line, pole in [*permutations(range(3), 2)][::-1]}
        choices.append(sorted(kinds.values()))
    yield from product(*choices)


def contact(pair: Pair, axes: Axes) -> float:
    """Return the least separation at which bodies of an alignment do not overlap; zero for points."""
    low, high = 0.0, sum(pair.reach)
    if high == 0.0:
        return 0.0
    # Contact does not depend on gravity, so the test bodies have none.
    core = pair.system.with_options(gravity="point").context.core
    while high - low > 4e-16 * high:
        middle = (low + high) / 2
        try:
            core.energy(pair.state(aligned(axes, middle)))
        except BodiesOverlap:
            low = middle
        else:
            high = middle
    return high


class Scan(NamedTuple):
    """Many separations (K,) of one alignment, with the angular momentum of uniform rotation at each."""

    separation: Floats
    angular_momentum: Floats

    def crossings(self, value: float) -> Floats:
        """Return separations near which the angular momentum has a value, the nearest first."""
        above = self.angular_momentum >= value
        indices = np.flatnonzero(above[1:] != above[:-1])
        d, j = self.separation, self.angular_momentum
        return d[indices] + (value - j[indices]) / (j[indices + 1] - j[indices]) * (d[indices + 1] - d[indices])


def scan(rotation: Rotation, axes: Axes, touching: float, until: float) -> Scan:
    """Scan separations from contact outwards until the angular momentum exceeds a value and grows."""
    pair = rotation.pair
    distance = max(touching, 1e-3 * sum(pair.reach))
    if distance == 0.0:
        # For points J^2 = m^2 G M d.
        distance = 1e-2 * until**2 / (pair.mass * pair.strength)
    farthest = _FARTHEST * max(distance, until**2 / (pair.mass * pair.strength))
    samples: list[tuple[float, float]] = []

    def evaluate(distance: float) -> None:
        if (sample := rotation.balanced(aligned(axes, distance))) is not None:
            samples.append((distance, sample.quantity("angular_momentum")))

    while distance <= farthest and not (len(samples) > 1 and samples[-1][1] > max(until, samples[-2][1])):
        evaluate(distance)
        distance *= _RATIO if samples else 1.01
    for (a, j), (b, k), (c, m) in zip(samples, samples[1:], samples[2:], strict=False):
        # Near its minimum a parabola tells whether the angular momentum falls below the value between two separations.
        if k < min(j, m):
            slopes = (k - j) / (b - a), (m - k) / (c - b)
            evaluate((a + b) / 2 - slopes[0] * (c - a) / (2 * (slopes[1] - slopes[0])))
    return Scan(*np.array(sorted(samples)).reshape(-1, 2).T)
