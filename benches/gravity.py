"""Speed of gravity at many points on one core, beside numpy with scipy and beside polyhedral-gravity.

    python benches/gravity.py

Prints nanoseconds a point and body. The ellipsoid is that of 1999 KW4 Alpha. Points and results stay in the processor's
caches, but for one row, which shows what it takes to bring them from memory and to have pages of it cleared.
"""

import os

os.environ["RAYON_NUM_THREADS"] = "1"

import time

import fullbody
import numpy as np
from scipy.special import elliprd

AXES = np.array([0.766, 0.7475, 0.6735])
COUNT = 50_000
BEYOND_CACHES = 10 * COUNT


def best(call, repeats=31):
    """Return the shortest CPU time of a call, in nanoseconds a point."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        count = call()
        times.append((time.process_time() - start) / count)
    return min(times) * 1e9


def cloud(low, high, count=COUNT):
    """Return points between two distances, in all directions."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1)[:, None] * rng.uniform(low, high, size=(count, 1))


def by_scipy(points):
    """Return the field of unit GM outside: Newton's iteration for kappa, and R_D thrice."""
    squares, x2 = AXES**2, points**2
    r2 = x2.sum(axis=1)
    kappa = np.maximum(0.0, r2 - x2 @ squares / r2)
    for _ in range(4):
        inverse = 1.0 / (squares + kappa[:, None])
        terms = x2 * inverse
        s = terms.sum(axis=1)
        kappa += s * (s - 1.0) / (terms * inverse).sum(axis=1)
    a, b, c = (squares + kappa[:, None]).T
    return -points * np.stack([elliprd(b, c, a), elliprd(c, a, b), elliprd(a, b, c)], axis=1)


def ellipsoid():
    body = fullbody.Body(fullbody.Ellipsoid(*AXES), mass=1.0, name="Alpha")
    state = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)))
    points_by_place = {
        "far, 3 to 30 km": cloud(3.0, 30.0),
        f"far, {BEYOND_CACHES} points": cloud(3.0, 30.0, BEYOND_CACHES),
        "near, 0.77 to 1 km": cloud(0.77, 1.0),
        "inside": cloud(0.0, 0.67),
        "0.3 to 300 km, mixed": cloud(0.3, 300.0),
    }
    paths = fullbody.vector_paths()
    print(
        f"{'ellipsoid, ns a point':24}" + "".join(f"{path + what:>20}" for path in paths for what in ("", ", gradient"))
    )
    for name, points in points_by_place.items():
        row = []
        for path in paths:
            system = fullbody.System([body], G=1.0, vector_path=path)

            def field(system=system, points=points):
                system.gravity(state, points)
                return len(points)

            def gradient(system=system, points=points):
                _ = system.gravity(state, points).gradient
                return len(points)

            both = best(field)
            row += [both, best(gradient) - both]
        print(f"{name:24}" + "".join(f"{value:20.1f}" for value in row))

    points = points_by_place["far, 3 to 30 km"]
    result = body.gravity(points, G=1.0).field

    def scipys():
        error = np.abs(by_scipy(points) / result - 1.0).max()
        assert error < 1e-11, error
        return len(points)

    print(f"{'numpy and scipy, far':24}{best(scipys, 3):20.1f}")


def icosphere(subdivisions):
    """Return vertices and faces of an icosahedron whose triangles are cut in four again and again."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return np.array(mesh.vertices), np.array(mesh.faces)


def polyhedron():
    vertices, faces = icosphere(3)
    body = fullbody.Body(fullbody.Polyhedron(vertices, faces), mass=1.0)
    points = cloud(1.2, 3.0, 2000)
    print(f"\nicosphere of {len(faces)} faces, ns a point")

    def ours():
        body.gravity(points, G=1.0)
        return len(points)

    print(f"{'fullbody':24}{best(ours):20.0f}")
    try:
        import polyhedral_gravity as peer
    except ModuleNotFoundError:
        print("polyhedral-gravity is not installed")
        return
    other = peer.Polyhedron(
        polyhedral_source=(vertices, faces),
        density=1.0,
        normal_orientation=peer.NormalOrientation.OUTWARDS,
        integrity_check=peer.PolyhedronIntegrity.DISABLE,
    )

    def peers():
        peer.evaluate(polyhedron=other, computation_points=points, parallel=False)
        return len(points)

    print(f"{'polyhedral-gravity':24}{best(peers, 3):20.0f}")


if __name__ == "__main__":
    ellipsoid()
    polyhedron()
