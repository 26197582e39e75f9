"""Shared helpers of the tests: textbook formulas, distances between rotations, strategies of hypothesis."""

import base64
import functools
import json
import os
import re
import tempfile
import warnings
from pathlib import Path

import fullbody
import numpy as np
import pytest
from fullbody import observables
from fullbody.errors import InvalidInput, UncheckedFile
from hypothesis import assume
from hypothesis import strategies as st

#: Observables that count revolutions.
OF_REVOLUTIONS = (
    observables.element_rates,
    observables.mutual_period,
    observables.orbit_precession,
    observables.spin_precession,
    observables.libration,
)
DATA = Path(__file__).parents[2] / "data"


def reference(name):
    """A file of tests/data, computed by other programs."""
    return json.loads((DATA / f"{name}.json").read_text())


@functools.cache
def ready(name, **options):
    """A ready-made system and its start, made once for all tests of a process: some search for a mean period."""
    return getattr(fullbody.systems, name)(**options)


def inertia(mass, axes):
    """Principal moments of a homogeneous ellipsoid: the paper's I_11, I_22, I_33 with m = 4/3 pi rho a b c."""
    a, b, c = axes
    return mass / 5.0 * np.array([b * b + c * c, c * c + a * a, a * a + b * b])


def angle_between(first, second):
    """Angles (...) between rotation matrices (..., 3, 3); exact also where they are tiny, unlike an arc cosine."""
    chord = np.linalg.norm(np.swapaxes(first, -1, -2) @ second - np.eye(3), axis=(-2, -1))
    return 2.0 * np.arcsin(np.minimum(chord / np.sqrt(8.0), 1.0))


def quaternion_product(p, q):
    """Hamilton's product, scalar first."""
    w, x, y, z = np.moveaxis(np.asarray(p, dtype=float), -1, 0)
    a, b, c, d = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    return np.stack(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ],
        axis=-1,
    )


def matrix(q):
    """Rotation matrix of a unit quaternion, scalar first (Shuster 1993, eq. 97, transposed to body -> inertial)."""
    w, v = q[0], np.asarray(q[1:])
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * cross


def rot_x(t):
    return np.array([[1, 0, 0], [0, np.cos(t), -np.sin(t)], [0, np.sin(t), np.cos(t)]])


def rot_y(t):
    return np.array([[np.cos(t), 0, np.sin(t)], [0, 1, 0], [-np.sin(t), 0, np.cos(t)]])


def rot_z(t):
    return np.array([[np.cos(t), -np.sin(t), 0], [np.sin(t), np.cos(t), 0], [0, 0, 1]])


def refused(match, call, *arguments, **options):
    """The call raises InvalidInput, in whose message the pattern is found."""
    with pytest.raises(InvalidInput, match=match):
        call(*arguments, **options)


def refused_with(pieces, call):
    """The call raises InvalidInput, in whose message these pieces, with dots between, come in this order."""
    with pytest.raises(InvalidInput) as caught:
        call()
    message = remainder = str(caught.value)
    for piece in pieces.split(" ... "):
        assert piece.lower() in remainder.lower(), message
        remainder = remainder[remainder.lower().index(piece.lower()) + len(piece) :]
    assert len(message) < 400


def body_list(*unnamed, **named):
    """Bodies by pairs of shape and mass, with names where they are given as keywords."""
    arguments = [(None, pair) for pair in unnamed] + list(named.items())
    return [fullbody.Body(shape, mass=mass, name=name) for name, (shape, mass) in arguments]


def points(*masses, G=1.0, **options):
    return fullbody.System([fullbody.Body(fullbody.PointMass(), mass=m) for m in masses], G=G, **options)


def worst(value, expected, scale=None):
    """Largest difference, relative to the largest expected value or to a scale."""
    value, expected = np.asarray(value, dtype=float), np.asarray(expected, dtype=float)
    scale = np.abs(expected).max() if scale is None else scale
    return np.abs(value - expected).max() / scale


def with_samples(run, **arrays):
    """A run with other samples, as another program would write them into its file."""
    dataset = run.to_xarray()
    for name, values in arrays.items():
        dataset[name] = (dataset[name].dims, values, dataset[name].attrs)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", UncheckedFile)
        dataset.to_netcdf(f"{folder}/run.nc", engine="h5netcdf")
        return fullbody.load(f"{folder}/run.nc")


def data_of(page):
    """The data that the page of an interactive view hands to its script, and its arrays of numbers."""
    data = json.loads(re.search(r"\nshow\((.*)\);\n", page)[1])
    unpacked = {
        name: np.frombuffer(base64.b64decode(data[name]), dtype=kind)
        for name, kind in (("time", "<f8"), ("position", "<f4"), ("attitude", "<f4"))
    }
    return data, unpacked


def fetched(page):
    """Whatever a page would fetch: links, sources, imports, addresses."""
    page = re.sub(r'(src|href)="data:[^"]*"', "", page)
    return re.findall(r"https?://|<link|\bsrc=|\bhref=|@import|\bfetch\(|XMLHttpRequest|import\(", page)


def forbid(monkeypatch):
    """Forbid making files; the tests may run as a user whom nothing is forbidden."""
    original = os.open

    def refuse(path, flags, *args, **options):
        if flags & os.O_CREAT:
            raise PermissionError(13, "Permission denied", str(path))
        return original(path, flags, *args, **options)

    monkeypatch.setattr(os, "open", refuse)


# Strategies

directions = (
    st.tuples(*[st.floats(-1, 1)] * 3)
    .filter(lambda v: 0.1 < np.linalg.norm(v) <= 1)
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)
quaternions = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: 0.1 < np.linalg.norm(q) <= 1)
    .map(lambda q: np.array(q) / np.linalg.norm(q))
)
semi_axes = st.tuples(*[st.floats(0.2, 1.0)] * 3)
vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


@st.composite
def pairs(draw, gravity=("focal", "surface")):
    """A system of two separate ellipsoids (semi-axes up to 1) with a state; G = 1."""
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(*draw(semi_axes)), mass=draw(st.floats(0.1, 2.0)), name=name) for name in "AB"
    ]
    system = fullbody.System(bodies, G=1.0, gravity=draw(st.sampled_from(gravity)))
    separation = draw(st.floats(2.2, 5.0)) * draw(directions)
    position = draw(vectors)
    # About the speed of a circular orbit, across the line of the centres: no collision for a quarter of a turn.
    across = np.cross(separation, draw(directions))
    assume(np.linalg.norm(across) > 1e-3)
    speed = np.sqrt(sum(b.mass for b in bodies) / np.linalg.norm(separation))
    velocity = across / np.linalg.norm(across) * speed
    drift = 0.3 * draw(vectors)
    state = fullbody.State(
        [position, position + separation],
        [drift, drift + velocity],
        [draw(quaternions), draw(quaternions)],
        [draw(vectors), draw(vectors)],
    )
    return system, state


def pair_of_points(e, **options):
    """A mass of one and a small one, with n = 1."""
    system = fullbody.System(
        [fullbody.Body(fullbody.PointMass(), mass=1 - 1e-3), fullbody.Body(fullbody.PointMass(), mass=1e-3)], G=1.0
    )
    r, v = fullbody.KeplerElements(1.0, e, 0.5, 1.0, 2.0, 0.3).to_cartesian(1.0)
    return system, fullbody.State([np.zeros(3), r], [np.zeros(3), v], **options)


def moon(axes, mass=1e-9, name=None, **options):
    """A small body about a ball of mass one that does not rotate, at distance one and with n = 1."""
    ball = fullbody.Component(diameter=0.1, mass=1.0, rotation_period=np.inf)
    second = fullbody.Component(semi_axes=axes, mass=mass, name=name)
    return fullbody.binary(ball, second, G=1.0 / (1 + mass), semi_major_axis=1.0, **options)
