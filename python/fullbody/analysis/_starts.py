"""Initial guesses: bodies with principal axes along the line between them and along the angular momentum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import permutations, product
from typing import TypeAlias

import numpy as np

from ..base import rotations
from ..errors import BodiesOverlap
from ..typing import Floats
from ._linear import Rotation
from ._newton import EquilibriumProblem
from ._pair import Pair, Pose

#: For both bodies, the body axes (0, 1 or 2) along the line and along the angular momentum.
Axes: TypeAlias = tuple[tuple[int, int], tuple[int, int]]

#: The ratio of neighbouring separations of a scan, and the ratio of the largest separation to that of contact.
_RATIO, _FARTHEST = 1.12, 100.0


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
    orders = [np.argsort(moments, kind="stable") for moments in pair.inertia]
    (a, b) = ((int(order[0]), int(order[2])) for order in orders)
    return a, b


def alignments(pair: Pair) -> Iterator[Axes]:
    """Yield all alignments of principal axes that differ by more than the symmetries of ellipsoids."""
    choices = []
    for k in range(2):
        moments = pair.inertia[k]
        seen, kept = set(), []
        for line, pole in permutations(range(3), 2):
            kind = (
                round(moments[line] / max(moments.max(), 1e-300), 12),
                round(moments[pole] / max(moments.max(), 1e-300), 12),
            )
            if kind not in seen:
                seen.add(kind)
                kept.append((line, pole))
        choices.append(kept)
    yield from product(*choices)


def rotation_at(problem: EquilibriumProblem, pose: Pose) -> Rotation | None:
    """Return the rotation whose rate balances the force along the line, or ``None`` where that force repels."""
    loads, _ = problem.pair.loads(pose)
    inward = -float(loads[:3] @ pose.r) / (problem.pair.mass * float(pose.r[:2] @ pose.r[:2]))
    return problem.rotation(pose, np.sqrt(inward)) if inward > 0.0 else None


def contact(pair: Pair, axes: Axes) -> float:
    """Return the least separation at which bodies of an alignment do not overlap; zero for points."""
    low, high = 0.0, sum(pair.reach)
    if high == 0.0:
        return 0.0
    # Contact does not depend on gravity, so the test bodies have none.
    core = pair.system.with_options(gravity="point").context.core
    while high - low > 4e-16 * high:
        middle = (low + high) / 2
        if not low < middle < high:
            break
        try:
            core.energy(pair.state(aligned(axes, middle)))
        except BodiesOverlap:
            low = middle
        else:
            high = middle
    return high


@dataclass(frozen=True)
class Scan:
    """One alignment at many separations (K,), with the angular momentum of uniform rotation at each."""

    axes: Axes
    separation: Floats
    angular_momentum: Floats

    def crossings(self, value: float) -> Floats:
        """Return separations near which the angular momentum has a value, the nearest first."""
        above = self.angular_momentum >= value
        indices = np.flatnonzero(above[1:] != above[:-1])
        d, j = self.separation, self.angular_momentum
        return d[indices] + (value - j[indices]) / (j[indices + 1] - j[indices]) * (d[indices + 1] - d[indices])


def scan(problem: EquilibriumProblem, axes: Axes, touching: float, until: float) -> Scan:
    """Scan separations from contact outwards until the angular momentum exceeds a value and grows."""
    pair = problem.pair
    distance = max(touching, 1e-3 * sum(pair.reach))
    if distance == 0.0:
        # For points J^2 = m^2 G M d.
        distance = 1e-2 * until**2 / (pair.mass * pair.strength)
    farthest = _FARTHEST * max(distance, until**2 / (pair.mass * pair.strength))
    samples: list[tuple[float, float]] = []

    def evaluate(distance: float) -> None:
        rotation = rotation_at(problem, aligned(axes, distance))
        if rotation is not None:
            samples.append((distance, float(rotation.angular_momentum[2])))

    while distance <= farthest and not (len(samples) > 1 and samples[-1][1] > max(until, samples[-2][1])):
        evaluate(distance)
        distance *= _RATIO if samples else 1.01
    for (a, j), (b, k), (c, m) in zip(samples, samples[1:], samples[2:], strict=False):
        # Near its minimum a parabola tells whether the angular momentum falls below the value between two separations.
        if k < min(j, m):
            slopes = (k - j) / (b - a), (m - k) / (c - b)
            evaluate((a + b) / 2 - slopes[0] * (c - a) / (2 * (slopes[1] - slopes[0])))
    table = np.array(sorted(samples)).reshape(-1, 2)
    return Scan(axes, table[:, 0], table[:, 1])
