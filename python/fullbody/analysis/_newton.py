"""Newton's method for uniform rotations of a pair, and initial guesses with aligned principal axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import permutations, product
from typing import NamedTuple, TypeAlias

import numpy as np

from ..base import rotations
from ..errors import BodiesOverlap, NotConverged
from ..typing import Floats
from ._pair import Pair, Pose, without_overlap
from ._rotation import Kind, Rotation

#: For each body, its axes (0, 1 or 2) along the line between the bodies and along the angular momentum.
Axes: TypeAlias = tuple[tuple[int, int], tuple[int, int]]

_MAX_STEPS = 60
#: The longest step, relative to the distance of the centres and in radians of rotations.
_LONGEST = 0.2
#: Residuals relative to the forces: the largest one of a solution, and the one below which further steps are round-off.
_TOLERANCE, _ROUNDING = 1e-10, 1e-14
#: A matrix is singular if its smallest singular value is below this fraction of its largest one.
_SINGULAR = 1e-9
#: The ratio of neighbouring separations of a scan, and the ratio of the largest separation to that of contact.
_RATIO, _FARTHEST = 1.12, 100.0


def converged(guess: Rotation, kind: Kind, value: float) -> Rotation:
    """Find by Newton's method the uniform rotation near a guess at which a quantity has a given value."""

    def equation(rotation: Rotation, columns: Floats) -> tuple[Floats, float]:
        gradient = rotation.quantity_gradient(kind) * columns
        unit = max(abs(value), np.abs(gradient).max())
        return gradient / unit, (rotation.quantity(kind) - value) / unit

    quantity = kind.replace("_", " ")
    return _solution(guess, equation, f"{quantity} {value:.9g}", quantity)


def corrected(rotation: Rotation, tangent: Floats, length: float) -> Rotation:
    """Find the uniform rotation in the plane normal to a tangent (10,), at a length along it, in units of `scales`."""
    if length == 0.0:
        return rotation
    step = length * tangent * rotation.scales()[1]
    guess = rotation.stepped(step)
    return _solution(guess, lambda rotation, columns: (tangent, 0.0), "the branch", "the branch", 12)


def _solution(
    rotation: Rotation,
    equation: Callable[[Rotation, Floats], tuple[Floats, float]],
    target: str,
    quantity: str,
    max_steps: int = _MAX_STEPS,
) -> Rotation:
    """Apply Newton's method with one additional equation, which is given by its row (10,) and its residual."""
    size = np.inf
    for _ in range(max_steps):
        _, columns = rotation.scales()
        row, row_residual = equation(rotation, columns)
        matrix, residual = rotation.equations()
        matrix, residual = np.concatenate([matrix, [row]]), np.append(residual, row_residual)
        previous, size = size, float(np.abs(residual).max())
        if size <= _ROUNDING or (size <= _TOLERANCE and size >= 0.5 * previous):
            return rotation
        left, values, right = np.linalg.svd(matrix, full_matrices=False)
        if values[-1] <= _SINGULAR * values[0]:
            raise NotConverged(
                f"a relative equilibrium of {target}: the matrix of Newton's step is singular (condition "
                f"{values[0] / max(values[-1], 1e-300):.2g}), as at a fold in {quantity}; expected another quantity to "
                "be given, or a start away from it"
            )
        step = -right.T @ ((left.T @ residual) / values)
        step *= min(1.0, _LONGEST / max(np.abs(step[:9]).max(), 1e-300))
        rotation = without_overlap(rotation.stepped, step * columns)
    raise NotConverged(
        f"a relative equilibrium of {target}: not found in {max_steps} steps of Newton's method, forces are out of "
        f"balance by {size:.2g} of their size; there may be none of this kind (fullbody.analysis.equilibria lists "
        "those of an angular momentum), or the start is too far from it"
    )


@cache
def _aligned_attitude(line: int, pole: int) -> Floats:
    """Return the quaternion that puts one body axis along x and another one along z."""
    matrix = np.zeros((3, 3))
    matrix[0, line] = matrix[2, pole] = 1.0
    matrix[1] = np.cross(matrix[2], matrix[0])
    return rotations.quaternion(matrix)


def aligned(axes: Axes, distance: float) -> Pose:
    """Return the pose with the given body axes along x, which is the line between the bodies, and along z."""
    return Pose(np.array([distance, 0.0, 0.0]), np.array([_aligned_attitude(*pair) for pair in axes]))


def long_axes(pair: Pair) -> Axes:
    """Return the axes of least inertia for the line and those of greatest inertia for the angular momentum."""
    (a, _, b), (c, _, d) = (map(int, np.argsort(moments, kind="stable")) for moments in pair.inertia)
    return (a, b), (c, d)


def alignments(pair: Pair) -> Iterator[Axes]:
    """Yield all alignments of principal axes that differ by more than the symmetries of ellipsoids."""
    choices = []
    for moments in pair.inertia:
        ratios = np.round(moments / max(moments.max(), 1e-300), 12)
        # Alignments with equal moments are one. The first of them is kept, since a dict keeps the last entry of a key.
        pairs = {(ratios[line], ratios[pole]): (line, pole) for line, pole in [*permutations(range(3), 2)][::-1]}
        choices.append(sorted(pairs.values()))
    yield from product(*choices)


def contact(pair: Pair, axes: Axes) -> float:
    """Return the least separation at which bodies of an alignment do not overlap; zero for points."""
    low, high = 0.0, pair.contact_distance
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
    distance = max(touching, 1e-3 * pair.contact_distance)
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
        # Near its minimum a parabola shows whether the angular momentum falls below the value between two separations.
        if k < min(j, m):
            slopes = (k - j) / (b - a), (m - k) / (c - b)
            evaluate((a + b) / 2 - slopes[0] * (c - a) / (2 * (slopes[1] - slopes[0])))
    return Scan(*np.array(sorted(samples)).reshape(-1, 2).T)
