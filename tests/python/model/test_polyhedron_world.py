"""Polyhedra in the rest of the package: contact, third bodies, files, pictures, other programs, bad meshes."""

import gzip
import json

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Body, Composite, Part, PointMass, Polyhedron, Sphere
from fullbody.errors import BodiesOverlap, NotConverged
from support import DATA, matrix, refused
from support.meshes import CORNERS, CUBE, box, close, icosphere, octahedron, pose, with_more_faces
from support.scenes import at_rest
from support.toml_texts import read


def cube_and_ball(position, velocity):
    """Two light bodies, of which the second moves."""
    bodies = [Body(box(2.0, 2.0, 2.0), mass=1e-9, name="cube"), Body(Sphere(0.5), mass=1e-9, name="ball")]
    state = fullbody.State([[0.0] * 3, position], [[0.0] * 3, velocity])
    return fullbody.System(bodies, G=1.0, gravity_tolerance=1e-8), state


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_a_ball_touches_a_face_an_edge_and_a_corner_when_it_should():
    for direction in ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]):
        n = np.array(direction) / np.linalg.norm(direction)
        system, state = cube_and_ball(5.0 * n, -2.0 * n)
        run = system.integrate(state, 3.0, events=[fullbody.events.Contact("cube", "ball", terminal=True)])
        touching = np.linalg.norm(direction) + 0.5
        assert run.events[0].time == pytest.approx((5.0 - touching) / 2.0, abs=1e-8)
        with pytest.raises(BodiesOverlap):
            system.integrate(state, 3.0)


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_a_quick_pass_through_a_corner_is_seen():
    for miss, met in ((0.499, True), (0.5001, False)):
        # Past the edge x = y = 1, at a right angle to its outward direction.
        n, along = np.array([1.0, 1.0, 0.0]) / 2**0.5, np.array([1.0, -1.0, 0.0]) / 2**0.5
        system, state = cube_and_ball((2**0.5 + miss) * n - 10.0 * along, 100.0 * along)
        if met:
            with pytest.raises(BodiesOverlap):
                system.integrate(state, 0.2)
        else:
            assert len(system.integrate(state, 0.2)) > 1


def test_third_bodies_torque_polyhedra_as_point_masses_do():
    solid, far = Body(box(1.0, 0.9, 0.5), mass=1.0, name="A"), np.array([30.0, 40.0, -20.0])
    state = pose(far)
    alone = fullbody.State([[0.0] * 3], [[0.0] * 3], state.attitude[:1])
    result = fullbody.System([solid], G=1.0, forces=[at_rest(far, 50.0)]).loads(alone)["Sun"]
    expected = fullbody.System([solid, Body(PointMass(), mass=50.0)], G=1.0).interactions(state)
    close(result.torque[0], expected.torque[0], 1e-11)


def write(path, vertices, faces):
    """Write a shape in the format that the name ends in."""
    vertices, corners = np.asarray(vertices), np.asarray(faces) + 1
    points = [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    match path.suffix:
        case ".tab":
            rows = [f"{len(vertices)} {len(faces)}", *(f"{n + 1} {p}" for n, p in enumerate(points))]
            rows += [f"{n + 1} {i} {j} {k}" for n, (i, j, k) in enumerate(corners.tolist())]
        case ".obj":
            rows = [f"v {p}" for p in points] + [f"f {i} {j} {k}" for i, j, k in corners.tolist()]
        case ".stl":
            facets = [["facet normal 0 0 0", "outer loop", *(f"vertex {points[i]}" for i in f)] for f in corners - 1]
            rows = ["solid box", *(row for f in facets for row in (*f, "endloop", "endfacet")), "endsolid box"]
        case ".ply":
            rows = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
            rows += [f"property double {c}" for c in "xyz"] + [f"element face {len(faces)}"]
            rows += ["property list uchar int vertex_indices", "end_header", *points]
            rows += [f"3 {i} {j} {k}" for i, j, k in (corners - 1).tolist()]
    path.write_text("\n".join(rows) + "\n")


@pytest.mark.parametrize("kind", ["tab", "obj", "ply", "stl"])
def test_shapes_are_read_from_files(tmp_path, kind):
    if kind != "tab":
        pytest.importorskip("trimesh")
    solid = octahedron(1.0, 0.75, 0.5)
    path = tmp_path / f"shape.{kind}"
    write(path, solid.vertices, solid.faces)
    result = Polyhedron.load(path, unit="km")
    assert result.volume.to_value(u.km**3) == pytest.approx(solid.volume, rel=1e-6 if kind == "stl" else 1e-14)
    assert len(result.faces) == 8
    if kind != "stl":
        assert Polyhedron.load(path) == solid
    for unit in ("kg", "kilometre-ish", 3, ("km",)):
        refused("expected a length, such as 'km'", Polyhedron.load, path, unit=unit)


@pytest.mark.parametrize("make", [fullbody.systems.kw4, fullbody.systems.didymos], ids=lambda make: make.__name__)
def test_shape_files_go_into_the_ready_made_systems(tmp_path, make):
    system, state = make(units=True)
    bodies, rotation = [], matrix(np.array([np.cos(0.05), 0.0, 0.0, np.sin(0.05)]))
    for body in system.bodies:
        axes = [axis.to_value(u.km) for axis in body.shape.semi_axes]
        solid = icosphere(2, axes)
        path = tmp_path / f"{body.name}.obj"
        write(path, solid.vertices @ rotation.T, solid.faces)
        shape = Polyhedron.load(path.rename(path.with_suffix(".tab")), unit="km")
        bodies.append(Body(shape, mass=body.mass, name=body.name))
        # The mesh lies within its ellipsoid.
        assert 0.93 < (shape.volume / (4.0 / 3.0 * np.pi * np.prod(axes) * u.km**3)).to_value("") < 1.0
    meshes = fullbody.System(bodies, units=("km", "hour", "kg"), gravity_tolerance=1e-8)
    result, expected = meshes.interactions(state), system.interactions(state)
    close(result.force.value, expected.force.value, 2e-3)
    quick = fullbody.Verner98(1e-8, 1e-8)
    runs = [entry.integrate(state, 5.0, output=[5.0], integrator=quick) for entry in (meshes, system)]
    ends = [(run.position[-1, 1] - run.position[-1, 0]).to_value(u.km) for run in runs]
    assert np.linalg.norm(ends[0] - ends[1]) < 0.01 * np.linalg.norm(ends[1])


def test_compressed_shape_files_are_read(tmp_path):
    solid = box(1.0, 2.0, 3.0)
    write(tmp_path / "box.tab", solid.vertices, solid.faces)
    written = (tmp_path / "box.tab").read_bytes()
    path = tmp_path / "box.tab.gz"
    path.write_bytes(gzip.compress(written))
    assert Polyhedron.load(path) == solid
    for broken in (written, gzip.compress(written)[:-20]):
        path.write_bytes(broken)
        refused(r"box\.tab\.gz is not a shape that can be read", lambda: Polyhedron.load(path))


def test_files_that_are_no_shapes_are_refused(tmp_path):
    path = tmp_path / "shape.tab"
    with pytest.raises(FileNotFoundError, match=r"shape\.tab"):
        Polyhedron.load(path)
    path.write_text("three vertices\n")
    refused("first row", lambda: Polyhedron.load(path))
    path.write_text("3 1\n0 0 0\n1 0 0\n0 1 0\n1 2 3\n")
    refused(r"shape\.tab: number of faces is 1", lambda: Polyhedron.load(path))
    solid = box(1.0, 1.0, 1.0)
    write(path, solid.vertices, solid.faces[:, ::-1])
    refused("face 0 is turned inward", lambda: Polyhedron.load(path))
    pytest.importorskip("trimesh")
    assert Polyhedron.load(path, heal=True).volume == pytest.approx(1.0)


def test_polyhedra_are_read_from_toml(tmp_path):
    solid = icosphere(0, (1.0, 0.8, 0.6))
    write(tmp_path / "a.tab", solid.vertices, solid.faces)
    mesh = f"{{ vertices = {box(1.0, 1.0, 1.0).vertices.tolist()}, faces = {CUBE.tolist()} }}"
    text = (
        '[system]\nG = 1.0\n[[body]]\nname = "A"\npolyhedron = "a.tab"\nmass = 2.0\n[run]\nuntil = 1.0\n'
        f'[[body]]\nname = "B"\npolyhedron = {mesh}\ndensity = 3.0\nposition = [4, 0, 0]\n'
    )
    bodies = read(tmp_path, text).system.bodies
    assert bodies[0] == Body(solid, mass=2.0, name="A")
    assert bodies[1].mass == pytest.approx(3.0)


def test_pictures_show_polyhedra():
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(Sphere(0.3), mass=0.2, name="B")]
    run = fullbody.System(bodies, G=1.0).integrate(pose([2.9, 1.5, -1.6]), 0.1)
    drawn = [c for c in run.plot.scene().collections if type(c).__name__ == "Poly3DCollection"]
    assert any(len(c._faces if hasattr(c, "_faces") else c._vec) for c in drawn)
    run.plot.orbit()
    assert json.dumps("triangles") in run.view().to_html()
    for thing in (run, run.system, bodies[0]):
        assert "8 faces" in thing._repr_html_().replace('faces</td><td style="text-align:left">8', "8 faces")


def test_films_show_polyhedra_and_composites(tmp_path):
    pytest.importorskip("matplotlib")
    image = pytest.importorskip("PIL.Image")
    lobes = [Part(Sphere(0.4), mass=0.2, position=(x, 0.0, 0.0)) for x in (-0.3, 0.3)]
    cube = Part(box(0.3, 0.3, 0.3), mass=0.1, position=(0.0, 0.5, 0.0))
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(Composite([*lobes, cube]), name="B")]
    system = fullbody.System(bodies, G=1.0, gravity_tolerance=1e-8)
    spin = [[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]]
    state = fullbody.State([[0.0] * 3, [3.0, 0.0, 0.0]], [[0.0] * 3, [0.0, 0.6, 0.0]], spin=spin)
    run = system.integrate(state, 1.0, output=0.5, integrator=fullbody.Verner98(1e-8, 1e-8))

    def pictures(run, name):
        with image.open(run.animate(tmp_path / name, seconds=0.3, fps=10, size=(3.0, 2.5), dpi=60)) as film:
            frames = []
            for frame in range(film.n_frames):
                film.seek(frame)
                frames.append(np.asarray(film.convert("RGB"), dtype=int))
        return frames

    frames = pictures(run, "film.gif")
    assert len(frames) == 3
    # Blue is the first body, and orange the second one; both are there, and move.
    for near, far in ((2, 0), (0, 2)):
        painted = [frame[..., near] - frame[..., far] > 25 for frame in frames]
        assert min(p.sum() for p in painted) > 100
        assert (painted[0] != painted[-1]).sum() > 30
    # The ball around the polyhedron makes another picture.
    ball = fullbody.System([Body(Sphere(1.0), mass=1.0, name="A"), bodies[1]], G=1.0, gravity_tolerance=1e-8)
    round_body = pictures(ball.integrate(state, 1e-3, output=1e-3), "ball.gif")[0]
    blue = [(frame[..., 2] - frame[..., 0] > 25).sum() for frame in (frames[0], round_body)]
    assert blue[0] < 0.8 * blue[1]


def test_what_polyhedra_lack_is_refused():
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(Sphere(0.3), mass=0.2, name="B")]
    refused("beside A, a polyhedron", lambda: fullbody.System(bodies, G=1.0, order=(8, 8)))
    # Faces so near to each other that each point of one is near to an edge of the other.
    flat = [Body(with_more_faces(with_more_faces(box(1.0, 1.0, 1.0))), mass=1.0, name=name) for name in "AB"]
    state = fullbody.State([[0.0] * 3, [1.0 + 1e-12, 0.0, 0.0]], np.zeros((2, 3)))
    with pytest.raises(NotConverged, match=r"over the faces of A, beside B, .* 1e8 evaluations"):
        fullbody.System(flat, G=1.0).interactions(state)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0.0, 0.0]], CUBE, "vertices"),
        (CORNERS, CUBE[:, :2], "faces is of shape"),
        (CORNERS, CUBE + 0.5, "faces is of shape"),
        (CORNERS, CUBE * np.nan, "and type float64; expected whole numbers"),
        (CORNERS, CUBE > 2, "and type bool; expected whole numbers"),
        (CORNERS, [[0, 1, 2], [1, 2]], "faces is not a table of numbers"),
        (CORNERS, CUBE - 1, "face 0, vertex 0"),
        (CORNERS, CUBE[:-1], "expected a closed surface"),
        (CORNERS, [*CUBE, CUBE[4]], "face 12 is the same three vertices as face 4; expected each face once"),
        (CORNERS, CUBE[:, ::-1], "turned inward"),
        (CORNERS * [1.0, 1.0, 0.0], CUBE, "face"),
        (CORNERS * np.nan, CUBE, "vert"),
        (CORNERS * 1e-150, CUBE, "largest coordinate of the vertices is 1e-150; expected one whose cube is in"),
        (CORNERS * 1e150, CUBE, "largest coordinate of the vertices is 1e150; expected one whose cube is in the range"),
    ],
)
def test_bad_meshes_are_refused(vertices, faces, message):
    refused(message, lambda: Polyhedron(vertices, faces))


def test_gubas_polyhedra_are_read(tmp_path):
    text = (DATA / "peers" / "gubas_pair.cfg").read_text()
    text = text.replace("Primary Shape Flag: 1", "Primary Shape Flag: 2")
    path = tmp_path / "pair.cfg"
    path.write_text(text)
    refused(r"line \d+: no file 'none' of a polyhedron", lambda: fullbody.read_gubas(path))
    for name, file in (("Vertex", "vertices.csv"), ("Tetrahedron", "faces.csv")):
        text = text.replace(f"Primary {name} File: none", f"Primary {name} File: {file}")
    path.write_text(text)
    q = np.array([np.cos(0.2), 0.0, 0.0, np.sin(0.2)])
    corners = (CORNERS - 0.5) * [400.0, 300.0, 200.0] @ matrix(q).T
    rows = [f"{k},{x!r},{y!r},{z!r}" for k, (x, y, z) in enumerate(corners.tolist())]
    (tmp_path / "vertices.csv").write_text("\n".join(rows) + "\n")
    faces = np.where(np.arange(12)[:, None] % 2, CUBE, CUBE[:, ::-1]) + 1
    (tmp_path / "faces.csv").write_text("\n".join(f"{i},{j},{k},," for i, j, k in faces) + "\n")
    with pytest.warns(UserWarning, match=r"turned by 22\.9 degrees"):
        system, state = fullbody.read_gubas(path)
    table_path = tmp_path / "plain.cfg"
    table_path.write_text((DATA / "peers" / "gubas_pair.cfg").read_text())
    unitless, other = fullbody.read_gubas(table_path)
    primary = system.bodies[0]
    close(primary.mass, primary.density * 0.4 * 0.3 * 0.2, 1e-13)
    close(primary.inertia, primary.mass / 12.0 * np.array([0.13, 0.2, 0.25]), 1e-13)
    # The vertices are where they were, and turn as they did.
    close(state.rotation_matrix[0], other.rotation_matrix[0] @ matrix(q), 1e-14)
    spin = other.rotation_matrix[0] @ other.spin[0]
    close(state.rotation_matrix[0] @ state.spin[0], spin, 1e-14)
    assert unitless.bodies[1] == system.bodies[1]


def test_sians_polyhedra_are_read(tmp_path):
    pytest.importorskip("trimesh")
    text = (DATA / "peers" / "sians_pair.txt").read_text()
    unitless, other = fullbody.read_sians(DATA / "peers" / "sians_pair.txt")
    (tmp_path / "initial_values").mkdir()
    write(tmp_path / "box.obj", *(getattr(box(1.0, 0.8, 0.6), name) for name in ("vertices", "faces")))
    head, _, remainder = text.partition("@ Semi")
    line, _, remainder = remainder.partition("\n")
    _, _, remainder = remainder.partition("\n")
    path = tmp_path / "initial_values" / "pair.txt"
    path.write_text(f"{head}@ Semi{line}\nbox.obj 0.5\n{remainder}")
    system, state = fullbody.read_sians(path)
    close(system.bodies[0].shape.volume, 0.48 / 8.0, 1e-14)
    assert system.bodies[1] == unitless.bodies[1]
    close(state.rotation_matrix, other.rotation_matrix, 1e-14)
    close(state.spin, other.spin, 1e-14)


def test_faces_that_point_inward_are_reversed(tmp_path):
    pytest.importorskip("networkx")
    faces = CUBE.copy()
    faces[[3, 7]] = faces[[3, 7], ::-1]
    path = tmp_path / "cube.tab"
    write(path, CORNERS, faces)
    refused("heal=True mends small faults", lambda: Polyhedron.load(path))
    assert Polyhedron.load(path, heal=True).volume == pytest.approx(1.0)
