"""Bodies on collision courses: the number of collisions that are missed.

    python benches/head_on.py [--runs 24000] [--seed 1]

Random pairs of spheres, points and ellipsoids fly at each other: head-on, with or without spin and gravity, and
grazing, with hardly any gravity and no spin, so that the depth of the graze has a closed form. All integrators are
used, with loose and with tight tolerances, with short steps and with steps longer than the encounter, forwards and
backwards. Prints for each integrator the numbers of collisions that the run missed, of collisions that it reported only
after it had recorded overlapping bodies, of runs with another error (a fixed step that is too long for its bodies is
refused), and of passes without contact that it reported as a collision. Exits with 1 unless all but the other errors
are zero.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import sys
import time
import warnings

import fullbody
import numpy as np
from fullbody.errors import BodiesOverlap, InconsistentInput, NotConverged
from numpy.typing import NDArray

Vector = NDArray[np.float64]

#: Possible outcomes of a run; the first three are faults.
OUTCOMES = ("missed", "inside", "false alarm", "other error", "correct")


def direction(rng: np.random.Generator) -> Vector:
    n = rng.normal(size=3)
    return n / np.linalg.norm(n)


def attitude(rng: np.random.Generator) -> Vector:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def shape(rng: np.random.Generator, kind: str) -> fullbody.Ellipsoid | fullbody.PointMass:
    if kind == "point":
        return fullbody.PointMass()
    size = 10.0 ** rng.uniform(-1, 0)
    if kind == "sphere":
        return fullbody.Ellipsoid(size, size, size)
    return fullbody.Ellipsoid(*(size * rng.permutation([1.0, *rng.uniform(0.15, 1.0, 2)])))


def support_point(body: fullbody.Body, q: Vector, n: Vector) -> Vector:
    """Return the point of the surface of a body, from its centre, at which the outward normal is n."""
    if isinstance(body.shape, fullbody.PointMass):
        return np.zeros(3)
    w, v = q[0], q[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    frame = (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * cross
    spread = frame @ np.diag(np.square(body.shape.semi_axes)) @ frame.T
    return spread @ n / np.sqrt(n @ spread @ n)


def integrator(rng: np.random.Generator, crossing: float) -> fullbody.record.integrators.Integrator:
    """Return a random integrator; `crossing` is the time in which the bodies pass each other."""
    pairs = [fullbody.DormandPrince54, fullbody.Verner65, fullbody.Verner76, fullbody.Verner87, fullbody.Verner98]
    kind = rng.integers(len(pairs) + 4)
    if kind < len(pairs):
        tolerance = 10.0 ** -rng.uniform(2, 13)
        return pairs[kind](tolerance, tolerance)
    step = crossing * 10.0 ** rng.uniform(-0.7, 1.5)
    if kind == len(pairs):
        return fullbody.LieGroupVariational(step)
    return fullbody.SymplecticSplitting(step, ("leapfrog", "ABA864", "ABA1064")[kind - len(pairs) - 1])


def name(integrator: fullbody.record.integrators.Integrator) -> str:
    return getattr(integrator, "scheme", type(integrator).__name__)


def encounter(rng: np.random.Generator) -> tuple[str, str, str]:
    """Return the integrator, the kind of encounter, and the outcome of the run."""
    kinds = [("sphere", "sphere"), ("sphere", "point"), ("ellipsoid", "point"), ("ellipsoid", "ellipsoid")]
    kind = kinds[rng.integers(len(kinds))]
    bodies = [
        fullbody.Body(shape(rng, letter), mass=10.0 ** rng.uniform(-3, 0), name=label)
        for letter, label in zip(kind, "AB", strict=True)
    ]
    rotated = np.array([attitude(rng), attitude(rng)])
    size = max(max(body.shape.semi_axes) for body in bodies if body.shape.semi_axes)
    speed, course = 10.0 ** rng.uniform(-1, 1), direction(rng)
    distance = size * 10.0 ** rng.uniform(0.7, 2.0)
    style = ("head-on", "graze", "beside")[rng.choice(3, p=[0.4, 0.4, 0.2])]
    spin = np.zeros((2, 3))
    if style == "head-on":
        # The potential energy is at most of the order of the kinetic one; on a straight course they meet in any case.
        G = speed**2 * size * 10.0 ** rng.uniform(-12, 0)
        nearest = np.zeros(3)
        if rng.random() < 0.5:
            spin = rng.normal(size=(2, 3)) * speed / size
    else:
        # With a normal across the course, they touch if the centres are apart by the sum of the support points.
        G = speed**2 * size * 1e-22
        normal = np.cross(course, direction(rng))
        normal /= np.linalg.norm(normal)
        touching = sum(support_point(body, q, normal) for body, q in zip(bodies, rotated, strict=True))
        depth = 10.0 ** rng.uniform(-6, -0.5) * (1 if style == "graze" else -1)
        nearest = (1.0 - depth) * touching
    backwards = rng.random() < 0.5
    sign = -1.0 if backwards else 1.0
    share = bodies[1].mass / (bodies[0].mass + bodies[1].mass)
    r, v = nearest - distance * course, sign * speed * course
    state = fullbody.State([-share * r, (1 - share) * r], [-share * v, (1 - share) * v], rotated, spin)
    system = fullbody.System(bodies, G=G)
    chosen = integrator(rng, size / speed)
    until = sign * rng.uniform(1.5, 4.0) * distance / speed
    output = (None, np.linspace(0.0, until, 200))[rng.integers(2)]
    try:
        run = system.integrate(state, until, output=output, integrator=chosen)
    except BodiesOverlap as error:
        recorded = error.run
        if style == "beside":
            return name(chosen), style, "false alarm"
        for last in list(recorded)[-1:]:
            with contextlib.suppress(NotConverged):
                try:
                    system.interactions(last)
                except BodiesOverlap:
                    return name(chosen), style, "inside"
        return name(chosen), style, "correct"
    except fullbody.FullbodyError as error:
        return name(chosen), style, f"other error: {type(error).__name__}"
    del run
    return name(chosen), style, "correct" if style == "beside" else "missed"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=24000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    # The states are warned of, since the bodies collide.
    warnings.simplefilter("ignore", InconsistentInput)
    counts: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)
    errors: collections.Counter[str] = collections.Counter()
    started = time.perf_counter()
    for k in range(arguments.runs):
        method, style, outcome = encounter(np.random.default_rng([arguments.seed, k]))
        kind, _, error = outcome.partition(": ")
        counts[method][kind] += 1
        counts[method]["collisions"] += style != "beside"
        errors[error] += bool(error)
    columns = ("collisions", *OUTCOMES)
    print(f"{'':<22}" + "".join(f"{column:>14}" for column in columns))
    total: collections.Counter[str] = collections.Counter()
    for method in sorted(counts):
        print(f"{method:<22}" + "".join(f"{counts[method][column]:>14}" for column in columns))
        total += counts[method]
    print(f"{'all':<22}" + "".join(f"{total[column]:>14}" for column in columns))
    print(f"other errors: {', '.join(f'{n} {error}' for error, n in errors.items() if n) or 'none'}")
    print(f"{arguments.runs} runs in {time.perf_counter() - started:.0f} s")
    return int(any(total[fault] for fault in OUTCOMES[:3]))


if __name__ == "__main__":
    sys.exit(main())
