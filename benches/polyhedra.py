"""Measure the interaction of polyhedra with an ellipsoid at the distance of 1999 KW4, on one core."""

import os

os.environ["RAYON_NUM_THREADS"] = "1"

import time

import fullbody
import numpy as np
from fullbody.systems import kw4_ho2021


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


def best(work, repeat=5):
    """Return the shortest of several times in seconds."""
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


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
        taken = best(lambda pair=pair: pair.integrate(state, 20.0), 3)
        each = taken / run.statistics.evaluations * 1e6
        print(f"interaction of {len(faces):6d} faces with an ellipsoid: {each:6.1f} us")


if __name__ == "__main__":
    interaction()
