"""Measure interactions of polyhedra on one core: with an ellipsoid, and of two radar shapes at any distance."""

import os

os.environ["RAYON_NUM_THREADS"] = "1"

import time

import fullbody
import numpy as np
from fullbody.errors import BodiesOverlap
from fullbody.systems import kw4, kw4_ho2021
from timing import shortest


def globe(rings, meridians, axes):
    """Return triangles between meridians and parallels of an ellipsoid."""
    theta = np.pi * np.arange(1, rings) / rings
    phi = 2.0 * np.pi * np.arange(meridians) / meridians
    ring = np.stack(
        [np.outer(np.sin(theta), np.cos(phi)), np.outer(np.sin(theta), np.sin(phi)), np.outer(np.cos(theta), phi**0)],
        -1,
    )
    points = np.concatenate([[[0.0, 0.0, 1.0]], ring.reshape(-1, 3), [[0.0, 0.0, -1.0]]]) * axes
    faces, last = [], len(points) - 1
    for j in range(meridians):
        k = (j + 1) % meridians
        faces.append((0, 1 + j, 1 + k))
        for i in range(rings - 2):
            a, b = 1 + i * meridians, 1 + (i + 1) * meridians
            faces += [(a + j, b + j, b + k), (a + j, b + k, a + k)]
        base = 1 + (rings - 2) * meridians
        faces.append((last, base + k, base + j))
    return points, np.array(faces)


def interaction():
    system, state = kw4_ho2021()
    alpha, beta = system.bodies
    for rings, meridians in ((13, 20), (26, 40), (51, 100)):
        vertices, faces = globe(rings, meridians, (0.766, 0.7475, 0.6735))
        body = fullbody.Body(fullbody.Polyhedron(vertices, faces), mass=alpha.mass, name="Alpha")
        pair = fullbody.System([body, beta], G=system.G)
        # The moments are computed once.
        pair.interactions(state)
        run = pair.integrate(state, 20.0)
        seconds = shortest(lambda pair=pair: pair.integrate(state, 20.0), 3, time.perf_counter)
        cost = seconds / run.statistics.evaluations * 1e6
        print(f"interaction of {len(faces):6d} faces with an ellipsoid: {cost:6.1f} us")


def distances(tolerance=1e-10, pose=0):
    """Print processor time against distance for the radar shapes of 1999 KW4, from 2.55 km to contact.

    The time is that of an evaluation in a run, with the choice of the rule once in a step; the first interaction also
    computes the moments and trees of the shapes.
    """
    system, _ = kw4(shape="radar")
    alpha, beta = system.bodies
    pair = fullbody.System([alpha, beta], G=1e-24, gravity_tolerance=tolerance)
    rng = np.random.default_rng(pose)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    attitude = rng.normal(size=(2, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    radius = np.linalg.norm(beta.shape.vertices, axis=1).max()

    def at(distance):
        zeros = np.zeros((2, 3))
        return fullbody.State([np.zeros(3), distance * direction], zeros, attitude=attitude, spin=zeros)

    low, high = 0.3, 1.2
    for _ in range(30):
        middle = 0.5 * (low + high)
        try:
            pair.momentum(at(middle))
        except BodiesOverlap:
            low = middle
        else:
            high = middle
    gaps = [0.3, 0.1, 0.03, 0.01]
    print(f"contact at {high:.4f} km; tolerance {tolerance:g}")
    for distance in [2.55, 2.0, 1.7, 1.5, 1.35, 1.3, 1.25, 1.2, 1.15, 1.1, 1.08] + [high + g * radius for g in gaps]:
        start = time.process_time()
        result = pair.interactions(at(distance))
        first = time.process_time() - start
        times = []
        for _ in range(3):
            simulation = fullbody.Simulation(pair, at(distance), integrator=fullbody.Verner98(rtol=1e-6, atol=1e-6))
            start = time.process_time()
            run = simulation.integrate(1.0)
            times.append((time.process_time() - start) / run.statistics.evaluations)
        print(
            f"{distance:.4f} km: {min(times) * 1e3:9.3f} ms, first {first:6.2f} s, bound {result.truncation_error:.1e}"
        )


if __name__ == "__main__":
    interaction()
    distances()
