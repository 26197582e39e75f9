"""Meshes with small faults are repaired on request."""

import numpy as np
import pytest
from fullbody import Polyhedron
from support import refused


def test_faces_turned_inward_are_turned_outward(tmp_path):
    pytest.importorskip("networkx")
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip
    faces[[3, 7]] = faces[[3, 7], ::-1]
    rows = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path = tmp_path / "cube.tab"
    path.write_text("\n".join(rows))
    refused("heal=True mends small faults", lambda: Polyhedron.load(path))
    assert Polyhedron.load(path, heal=True).volume == pytest.approx(1.0)
