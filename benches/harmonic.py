"""Measure the harmonic series of pairs: its cost beside ellipsoids, and its errors beside its bound.

    python benches/harmonic.py [--quick]

Prints the time of an evaluation of the radar shapes of 1999 KW4 by distance, in units of that of two ellipsoids by the
surface rule; the largest error of the series of random pairs of polyhedra and composites from the integrals over
surfaces; and the largest ratio of an error to the tolerance for which the bound has chosen the degrees, in random poses
of composites with voids. The ratio may not exceed one.
"""

from __future__ import annotations

import argparse
import os

os.environ["RAYON_NUM_THREADS"] = "1"

import time

import fullbody
import numpy as np
from fullbody import Body, Composite, Ellipsoid, Part, Polyhedron, State, System
from scipy.spatial import ConvexHull

#: The relative round-off of both rules.
ROUND_OFF = 5e-14


def unit(rng: np.random.Generator, size: int) -> np.ndarray:
    """Return a random unit vector."""
    vector = rng.normal(size=size)
    return vector / np.linalg.norm(vector)


def posed(rng: np.random.Generator, distance: float) -> State:
    """Return two bodies at rest in random attitudes."""
    attitude = [unit(rng, 4), unit(rng, 4)]
    zeros = np.zeros((2, 3))
    return State([np.zeros(3), distance * unit(rng, 3)], zeros, attitude=attitude, spin=zeros)


def rock(rng: np.random.Generator, size: float) -> Polyhedron:
    """Return the convex hull of 12 points about an ellipsoid."""
    points = np.array([unit(rng, 3) for _ in range(12)]) * rng.uniform(0.5, 1.0, 3) * size
    hull = ConvexHull(points)
    # The faces of a hull have no orientation; the mean of the points is inside.
    faces = hull.simplices.copy()
    inwards = np.linalg.det(points[faces] - points.mean(axis=0)) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    used = np.unique(faces)
    return Polyhedron(points[used], np.searchsorted(used, faces))


def hollow(rng: np.random.Generator, size: float) -> Composite:
    """Return an ellipsoid with a lobe and a void within it."""
    axes = size * rng.uniform(0.5, 1.0, 3)
    void = Part(Ellipsoid(*(0.4 * axes)), mass=-rng.uniform(0.05, 0.4), position=0.3 * axes.min() * unit(rng, 3))
    lobe = Part(Ellipsoid(*(0.5 * axes)), mass=rng.uniform(0.1, 0.5), position=1.6 * axes.max() * unit(rng, 3))
    return Composite([Part(Ellipsoid(*axes), mass=1.0, position=[0.0, 0.0, 0.0]), lobe, void])


def bounding_radius(body: Body) -> float:
    """Return the radius of a sphere about the body's centre of mass that contains the body."""
    if isinstance(body.shape, Polyhedron):
        middle = np.linalg.norm(body.working_frame.position)
        return float(np.linalg.norm(body.shape.vertices, axis=1).max() + middle)
    parts = body.shape.parts
    middle = np.linalg.norm(body.working_frame.position)
    return float(max(np.linalg.norm(part.position) + max(part.shape.semi_axes) for part in parts) + middle)


def error(bodies: list[Body], state: State, exact: str, tolerance: float) -> float:
    """Return the larger one of the relative error of the force and that of the torques over force times size."""
    reference = System(bodies, G=1.0, gravity=exact).interactions(state)
    result = System(bodies, G=1.0, gravity="harmonic", gravity_tolerance=tolerance).interactions(state)
    force = np.linalg.norm(reference.force[0])
    arms = force * np.array([bounding_radius(body) for body in bodies])
    torques = np.linalg.norm(result.torque - reference.torque, axis=1) / arms
    return float(max(np.linalg.norm(result.force[0] - reference.force[0]) / force, torques.max()))


def cost(hours: float) -> None:
    """Print the time of an evaluation at the distance of the bodies, by runs."""
    radar, start = fullbody.systems.kw4(shape="radar")
    smooth, beginning = fullbody.systems.kw4()

    def cost_of(system: System, state: State) -> float:
        times = []
        for _ in range(5):
            started = time.process_time()
            run = system.integrate(state, hours, output=[hours])
            times.append((time.process_time() - started) / run.statistics.evaluations)
        return 1e6 * min(times)

    surface = cost_of(smooth.with_options(gravity="surface"), beginning)
    print(f"two ellipsoids by the surface rule, 2.55 km: {surface:.2f} us")
    for tolerance in (1e-14, 1e-10, 1e-6):
        series = cost_of(radar.with_options(gravity_tolerance=tolerance), start)
        print(f"radar shapes at {tolerance:.0e}, 2.55 km: {series:.2f} us, {series / surface:.1f} times as long")


def sample(count: int) -> None:
    """Print the largest error of random pairs from the integrals over surfaces, over the tolerance."""
    rng = np.random.default_rng(20)
    worst = 0.0
    for k in range(count):
        shapes = [(rock, hollow)[k >> bit & 1](rng, size) for bit, size in enumerate((1.0, rng.uniform(0.2, 0.8)))]
        masses = [1.0 if isinstance(shape, Polyhedron) else None for shape in shapes]
        bodies = [Body(shape, mass=mass, name=name) for shape, mass, name in zip(shapes, masses, "AB", strict=True)]
        state = posed(rng, rng.uniform(1.3, 3.0) * sum(map(bounding_radius, bodies)))
        worst = max(worst, error(bodies, state, "surface", 1e-12))
    print(f"{count} pairs at the tolerance 1e-12: largest error {worst:.1e}")


def bound(systems: int, poses: int) -> None:
    """Print the largest ratio of an error to the tolerance, above round-off, in random poses."""
    rng = np.random.default_rng(21)
    ratios = []
    for _ in range(systems):
        bodies = [Body(hollow(rng, size), name=name) for size, name in ((1.0, "A"), (rng.uniform(0.2, 0.8), "B"))]
        for _ in range(poses):
            tolerance = 10.0 ** rng.uniform(-11.0, -2.0)
            state = posed(rng, rng.uniform(1.3, 4.0) * sum(map(bounding_radius, bodies)))
            ratios.append((error(bodies, state, "focal", tolerance) - ROUND_OFF) / tolerance)
    largest, median = max(ratios), np.median(ratios)
    print(f"{len(ratios)} poses with voids: error over tolerance at most {largest:.2f}, median {median:.1e}")
    if largest > 1.0:
        raise SystemExit("the error exceeds the bound")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a tenth of the work")
    quick = parser.parse_args().quick
    cost(20.0 if quick else 200.0)
    sample(50 if quick else 500)
    bound(20 if quick else 200, 50)
