"""Speed of gravity at many points on one core, beside numpy with scipy and beside polyhedral-gravity.

    python benches/gravity.py

Prints nanoseconds a point and body. The ellipsoid is that of 1999 KW4 Alpha. Points and results stay in the processor's
caches, except in one row, which also contains the time of memory accesses and of clearing pages.
"""

import os

os.environ["RAYON_NUM_THREADS"] = "1"

import fullbody
import numpy as np
from scipy.special import elliprd
from timing import shortest

AXES = np.array([0.766, 0.7475, 0.6735])
COUNT = 50_000
BEYOND_CACHES = 10 * COUNT


def per_point(call, points, repeats=31):
    """Return the shortest processor time of a call in nanoseconds per point."""
    return shortest(call, repeats) / len(points) * 1e9


def cloud(low, high, count=COUNT):
    """Return points between two distances, in all directions."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1)[:, None] * rng.uniform(low, high, size=(count, 1))


def by_scipy(points):
    """Return the exterior field of unit GM, by Newton's iteration for kappa and three integrals R_D."""
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
    points_by_name = {
        "far, 3 to 30 km": cloud(3.0, 30.0),
        f"far, {BEYOND_CACHES} points": cloud(3.0, 30.0, BEYOND_CACHES),
        "near, 0.77 to 1 km": cloud(0.77, 1.0),
        "inside": cloud(0.0, 0.67),
        "0.3 to 300 km, mixed": cloud(0.3, 300.0),
    }
    paths = fullbody.vector_paths()
    print(
        f"{'ellipsoid, ns a point':24}"
        + "".join(f"{path + suffix:>20}" for path in paths for suffix in ("", ", gradient"))
    )
    for name, points in points_by_name.items():
        row = []
        for path in paths:
            system = fullbody.System([body], G=1.0, vector_path=path)

            def field(system=system, points=points):
                system.gravity(state, points)

            def gradient(system=system, points=points):
                _ = system.gravity(state, points).gradient

            field_time = per_point(field, points)
            row += [field_time, per_point(gradient, points) - field_time]
        print(f"{name:24}" + "".join(f"{value:20.1f}" for value in row))

    points = points_by_name["far, 3 to 30 km"]
    result = body.gravity(points, G=1.0).field

    def scipy_field():
        error = np.abs(by_scipy(points) / result - 1.0).max()
        assert error < 1e-11, error

    print(f"{'numpy and scipy, far':24}{per_point(scipy_field, points, 3):20.1f}")


def icosphere(subdivisions):
    """Return vertices and faces of an icosahedron whose triangles are repeatedly divided in four."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return np.array(mesh.vertices), np.array(mesh.faces)


def polyhedron():
    vertices, faces = icosphere(3)
    body = fullbody.Body(fullbody.Polyhedron(vertices, faces), mass=1.0)
    points = cloud(1.2, 3.0, 2000)
    print(f"\nicosphere of {len(faces)} faces, ns a point")

    print(f"{'fullbody':24}{per_point(lambda: body.gravity(points, G=1.0), points):20.0f}")
    try:
        import polyhedral_gravity as peer
    except ModuleNotFoundError:
        print("polyhedral-gravity is not installed")
        return
    peer_shape = peer.Polyhedron(
        polyhedral_source=(vertices, faces),
        density=1.0,
        normal_orientation=peer.NormalOrientation.OUTWARDS,
        integrity_check=peer.PolyhedronIntegrity.DISABLE,
    )

    def evaluate():
        peer.evaluate(polyhedron=peer_shape, computation_points=points, parallel=False)

    print(f"{'polyhedral-gravity':24}{per_point(evaluate, points, 3):20.0f}")


if __name__ == "__main__":
    ellipsoid()
    polyhedron()
