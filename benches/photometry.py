"""Speed of the brightness of ellipsoids on one core, beside facets in numpy.

    python benches/photometry.py [primary.obj secondary.obj]

With paths of OBJ files of two bodies, such as the radar shapes of 1999 KW4, their light by facets is timed, too.

Prints microseconds an epoch: of one body alone, of a pair during an event, with derivatives, and with their errors of a
numpy model of facets and, if shapely is installed, of facets from which the outline of the other body is clipped.
The last row is the time of the mutual events of Didymos in 28 days.
"""

import os
import sys

os.environ["RAYON_NUM_THREADS"] = "1"

import astropy.units as u
import fullbody
import numpy as np
from fullbody import observing
from fullbody.observing.brightness import Epochs, Photometer
from scipy.spatial import ConvexHull
from timing import shortest

try:
    import shapely
except ImportError:
    shapely = None

COUNT = 2000


def per_epoch(call, count, repeats=7):
    """Return the shortest processor time of a call in microseconds per epoch."""
    return shortest(call, repeats) / count * 1e6


def epochs(count, bodies):
    """Return a satellite that passes before the primary, and its shadow that follows."""
    path = np.linspace(-1.3, 1.3, count)
    position = np.zeros((count, bodies, 3))
    if bodies == 2:
        position[:, 1] = np.stack([np.full(count, 3.0), path, np.full(count, 0.2)], axis=1)
    attitude = np.tile([0.9, 0.1, 0.3, 0.2], (count, bodies, 1))
    vectors = (np.tile([1.0, 0.0, 0.0], (count, 1)), np.tile([1.0, 0.15, 0.05], (count, 1)))
    return (np.zeros(count), position, attitude, *vectors)


def by_facets(points, axes, position, e, s):
    """Return Lommel-Seeliger's brightness of the first of two ellipsoids, by equal-weight points on the unit sphere."""
    rotation = fullbody.base.rotations.matrices(np.array([[0.9, 0.1, 0.3, 0.2]]))[0]
    (p, q), x = (rotation.T @ d / axes[0] for d in (e, s)), (points * axes[0]) @ rotation.T
    sight, light = points @ p, points @ q
    visible = (sight > 0) & (light > 0)
    for d in (e, s):
        y, w = ((x - position) @ rotation) / axes[1], rotation.T @ d / axes[1]
        visible &= (y @ w) ** 2 < w @ w * (np.sum(y * y, axis=1) - 1)
    part = sight[visible] * light[visible] / (sight[visible] + light[visible])
    return part.sum() * np.prod(axes[0]) * 4 * np.pi / len(points)


def sphere(count):
    """Return a unit sphere's vertices on a spiral, and its facets with normals outward, grown to the sphere's area."""
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    angle = np.pi * (1 + 5**0.5) * np.arange(count)
    points = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)
    facets = ConvexHull(points).simplices
    a, b, c = np.moveaxis(points[facets], 1, 0)
    normals = np.cross(b - a, c - a)
    facets[np.sum(normals * a, axis=1) < 0] = facets[np.sum(normals * a, axis=1) < 0, ::-1]
    return points * np.sqrt(8 * np.pi / np.linalg.norm(normals, axis=1).sum()), facets


def by_clipping(points, facets, axes, position, e, s):
    """Return Lommel-Seeliger's brightness of the first of two ellipsoids with the second in front of it, by its facets.

    From each facet the outline of the second one is clipped, as the observer and as the Sun projects it on the facet.
    """
    rotation = fullbody.base.rotations.matrices(np.array([[0.9, 0.1, 0.3, 0.2]]))[0]
    first, second = ((points * a) @ rotation.T for a in axes)
    a, b, c = np.moveaxis(first[facets], 1, 0)
    normal = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(normal, axis=1)
    normal = normal / (2 * area[:, None])
    sight, light = normal @ e, normal @ s
    visible = (sight > 0) & (light > 0)
    a, b, c, normal, area, sight, light = (x[visible] for x in (a, b, c, normal, area, sight, light))
    left = np.broadcast_to(shapely.Polygon([(0, 0), (1, 0), (0, 1)]), len(a))
    # Shares of a facet's sides: w is the dual basis in its plane.
    u, v = b - a, c - a
    dual = np.linalg.inv(np.stack([u, v, normal], axis=-1))
    for d, slope in ((e, sight), (s, light)):
        plane = np.linalg.svd(d[None])[2][1:]
        outline = second[ConvexHull(second @ plane.T).vertices] + position
        # Only facets near the outline, as seen along d, are clipped.
        centre, size = second.mean(axis=0) + position, np.linalg.norm(second, axis=1).max()
        close = np.linalg.norm(((a + b + c) / 3 - centre) @ plane.T, axis=1) < size + np.linalg.norm(u, axis=1).max()
        vectors = outline[None] - a[close, None]
        projected = vectors - d * (np.einsum("fhx,fx->fh", vectors, normal[close]) / slope[close, None])[..., None]
        shares = np.einsum("fsx,fhx->fhs", dual[close, :2], projected)
        left = left.copy()
        left[close] = shapely.difference(left[close], shapely.polygons(shares))
    return np.sum(sight * light / (sight + light) * area * 2 * shapely.area(left))


def search():
    """Return the number of Didymos' mutual events in 28 days from the Earth, and the search's time in microseconds."""
    system, state = fullbody.systems.didymos_after_dart(units=True)
    run = system.integrate(state, "28 day", output=["28 day"], dense=True)
    view = {"to_observer": [0.07, 0.01, 0.01] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
    geometry = observing.Geometry([-1.0, 29.0] * u.day, **view)
    return len(observing.mutual_events(run, geometry)), per_epoch(lambda: observing.mutual_events(run, geometry), 1, 3)


def by_shapes(paths):
    """Return rows of the light of two shapes and of their convex hulls: alone, apart and in events."""
    shapes = [fullbody.Polyhedron.load(path) for path in paths]
    rng, count, rows = np.random.default_rng(1), 100, []

    def unit(vectors):
        return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)

    def hull(shape):
        points = np.asarray(shape.vertices)
        result = ConvexHull(points)
        vertices, facets = np.unique(result.simplices, return_inverse=True)
        points, facets = points[vertices], facets.reshape(-1, 3)
        a, b, c = np.moveaxis(points[facets], 1, 0)
        inward = np.sum(np.cross(b - a, c - a) * result.equations[:, :3], axis=1) < 0
        facets[inward] = facets[inward][:, ::-1]
        return fullbody.Polyhedron(points, facets)

    e, offset = (unit(rng.normal(size=(count, 3))) for _ in range(2))
    s = unit(e + 0.8 * offset)
    for kind, solids in (("", shapes), (", convex hull", [hull(shape) for shape in shapes])):
        bodies = [fullbody.Body(solid, mass=1.0) for solid in solids]
        size = np.linalg.norm(bodies[0].shape.vertices, axis=1).max()
        separate, hidden = 3.0 * size * unit(rng.normal(size=(count, 3))), e * 3.0 * size + offset * 0.6 * size
        cases = [(f"{len(b.shape.faces):,} facets{kind}", [b], None) for b in bodies]
        cases += [(f"both{kind}, apart", bodies, separate), (f"both{kind}, in events", bodies, hidden)]
        for name, case_bodies, distance in cases:
            position = np.zeros((count, len(case_bodies), 3))
            if distance is not None:
                position[:, 1] = distance
            sample = Epochs(np.zeros(count), position, unit(rng.normal(size=(count, len(case_bodies), 4))), e, s)
            photometer = Photometer(fullbody.System(case_bodies, G=1.0), observing.LommelSeeliger(), 1.0, True, 0.0)
            photometer.brightness(sample)
            rows.append((name, per_epoch(lambda p=photometer, g=sample: p.brightness(g), count, 3)))
            rows.append((f"{name}, derivatives", per_epoch(lambda p=photometer, g=sample: p.derivatives(g), count, 3)))
    return rows


def main():
    """Print the table."""
    axes = np.array([[1.0, 0.8, 0.6], [0.4, 0.35, 0.3]])
    bodies = [fullbody.Body(fullbody.Ellipsoid(*a), mass=1.0) for a in axes]
    rows = []
    for name, law in (("Lommel-Seeliger", observing.LommelSeeliger()), ("Lambert", observing.Lambert())):
        count = COUNT if name != "Lambert" else COUNT // 10
        single = Photometer(fullbody.System(bodies[:1], G=1.0), law, 1.0, True, 0.0)
        two = Photometer(fullbody.System(bodies, G=1.0), law, 1.0, True, 0.0)
        alone, pair = (Epochs(*epochs(count, n)) for n in (1, 2))
        rows.append((f"{name}, one body", per_epoch(lambda p=single, a=alone: p.brightness(a), count)))
        rows.append((f"{name}, a pair in an event", per_epoch(lambda p=two, a=pair: p.brightness(a), count)))
        rows.append((f"{name}, the same with derivatives", per_epoch(lambda p=two, a=pair: p.derivatives(a), count)))
    two = Photometer(fullbody.System(bodies, G=1.0), observing.LommelSeeliger(), 1.0, True, 0.0)
    sample = epochs(50, 2)
    exact = two.brightness(Epochs(*sample))[:, 0]
    for size in (1000, 10_000, 100_000):
        z = 1 - 2 * (np.arange(size) + 0.5) / size
        angle = np.pi * (1 + 5**0.5) * np.arange(size)
        points = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)
        e, s = (vector[0] / np.linalg.norm(vector[0]) for vector in sample[3:])
        call = lambda points=points, e=e, s=s: [by_facets(points, axes, position, e, s) for position in sample[1][:, 1]]  # noqa: E731
        error = np.abs(np.array(call()) / exact - 1).max()
        rows.append((f"numpy, {size} facets, error {error:.0e}", per_epoch(call, 50, 3)))
    for size in (200, 800, 3200) if shapely else ():
        points, facets = sphere(size)
        call = lambda points=points, facets=facets: [  # noqa: E731
            by_clipping(points, facets, axes, position, e, s) for position in sample[1][::5, 1]
        ]
        error = np.abs(np.array(call()) / exact[::5] - 1).max()
        rows.append((f"shapely, {len(facets)} facets clipped, error {error:.0e}", per_epoch(call, 10, 3)))
    count, duration = search()
    rows.append((f"search for {count} mutual events in 28 days", duration))
    rows += by_shapes(sys.argv[1:]) if len(sys.argv) > 2 else []
    for name, value in rows:
        print(f"{name:48} {value:10.2f}")


if __name__ == "__main__":
    main()
