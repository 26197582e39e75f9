"""Polyhedra: solids that are bounded by triangles."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.atomic import other_reader
from ..base.attributes import Attribute
from ..base.kinds import Number
from ..base.units import Units, is_quantity, need, without_unit
from ..base.values import same
from ..errors import InvalidInput
from ..typing import Floats, Scalar
from .stokes import StokesCoefficients, harmonics_of

_Indices = npt.NDArray[np.signedinteger[Any]]


class Polyhedron:
    """A homogeneous polyhedron: a solid that is bounded by triangles.

    Its gravity is exact at every distance; near the body it is computed as a sum over faces and edges (Werner and
    Scheeres 1996). The body frame has its origin in the centre of mass and its axes along the principal axes of
    inertia, rotated as little as possible from the working frame in which the vertices are given;
    :attr:`fullbody.Body.working_frame` is the position and attitude of the working frame in the body frame.

    There may be several closed surfaces: pieces side by side, or a hollow, whose faces point away from the solid.

    Parameters
    ----------
    vertices : array_like or Quantity, (V, 3)
        Points in any working frame.
    faces : array_like of int, (F, 3)
        Indices of the three vertices of each face, from 0, counterclockwise as seen from outside.

    Raises
    ------
    InvalidInput
        For a surface that is not closed, and for faces that point inward or against each other, are doubled, without
        an area, or that cross or touch others, where the message names the face; for a volume of zero.

    Examples
    --------
    >>> import fullbody
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> wedge = fullbody.Polyhedron(corners, faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> wedge, round(wedge.volume, 6), wedge.harmonics(8).degree
    (Polyhedron(4 vertices, 4 faces), 0.166667, 8)
    >>> body = fullbody.Body(wedge, density=6.0)
    >>> body.gravity([0.0, 0.0, 100.0], G=1.0).potential.round(6)
    np.float64(0.01)
    """

    __slots__ = ("_faces", "_made", "_vertices")

    def __init__(self, vertices: Any, faces: Any) -> None:
        points = Number("length", shape=("V", 3))(vertices, "vertices")
        self._vertices: Any = points if is_quantity(points) else np.array(points, dtype=np.float64)
        expected = "expected whole numbers (F, 3)"
        try:
            table = np.asarray(faces)
            # Text and nan become integers that differ from what was given, which the comparison below detects.
            with np.errstate(invalid="ignore"):
                self._faces: npt.NDArray[np.int64] = table.astype(np.int64)
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"faces is not a table of numbers; {expected}") from error
        if table.ndim != 2 or table.shape[1] != 3 or table.dtype.kind == "b" or not np.all(self._faces == table):
            raise InvalidInput(f"faces is of shape {table.shape} and type {table.dtype}; {expected}")
        self._made = _core.Polyhedron(np.ascontiguousarray(without_unit(points)), np.ascontiguousarray(self._faces))
        for array in (self._vertices, self._faces):
            array.flags.writeable = False

    vertices = Attribute[Any]("_vertices", "Vertices (V, 3) as given, in the working frame.")
    faces = Attribute[npt.NDArray[np.int64]]("_faces", "Indices of the vertices of each face (F, 3).")

    @property
    def volume(self) -> Scalar:
        """Volume of the solid."""
        volume: Any = self._made.volume
        return volume * self._vertices.unit**3 if is_quantity(self._vertices) else volume

    def harmonics(self, degree: int) -> StokesCoefficients:
        """Return Stokes coefficients in the body frame, as :meth:`fullbody.Body.harmonics`, for the circumscribed
        radius.

        Examples
        --------
        >>> import fullbody
        >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> wedge = fullbody.Polyhedron(corners, faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> wedge.harmonics(8).degree
        8
        """
        units = Units((self._vertices.unit, "s", "kg")) if is_quantity(self._vertices) else Units()
        return harmonics_of(_core.Body("the polyhedron", self._made, mass=1.0), degree, units)

    @classmethod
    def load(cls, path: str | PathLike[str], unit: Any = None, *, heal: bool = False) -> Polyhedron:
        """Read a polyhedron from a file.

        Parameters
        ----------
        path : path-like
            A file in OBJ, PLY or STL format, by its suffix. Any other file is read as a table of shape archives: the
            numbers of vertices and faces, then a row for each, whose first column may be its number; or rows that begin
            with v and f. Such a table may be compressed, with the suffix .gz.
        unit : Unit or str, optional
            Unit of the file's numbers, which the formats do not record; without it they are plain numbers.
        heal : bool
            Whether to repair a surface that is not closed and oriented outward: vertices at one place are merged,
            doubled faces and faces without an area are left out, small holes are filled, and faces oriented outward.

        Raises
        ------
        InvalidInput
            For the same reasons as the class, and for a file that contains no such table.
        ModuleNotFoundError
            If trimesh (the extra ``shapes``) is missing, which OBJ, PLY, STL and ``heal`` need.
        """
        import gzip

        path = Path(path)
        try:
            vertices, faces = _read(path)
            if heal:
                vertices, faces = _healed(vertices, faces)
        except FileNotFoundError:
            raise FileNotFoundError(f"no file {path}") from None
        except (ValueError, IndexError, KeyError, TypeError, AttributeError, EOFError, gzip.BadGzipFile) as error:
            other = other_reader(path, "fullbody.Polyhedron.load")
            raise InvalidInput(f"{path} is not a shape that can be read: {error}{other}") from error
        if unit is not None:
            with need("units", "a unit"):
                from astropy import units as u
            try:
                vertices = u.Quantity(vertices, unit)
                vertices.to_value(u.m)
            except (TypeError, ValueError) as error:
                raise InvalidInput(f"unit is {unit!r}; expected a length, such as 'km'") from error
        try:
            return Polyhedron(vertices, faces)
        except InvalidInput as error:
            hint = "" if heal else " (heal=True mends small faults)"
            raise InvalidInput(f"{path}: {error}{hint}") from error

    def _core(self, units: Units, name: str) -> _core.Polyhedron:
        """Return the core's form of the shape in a system's units."""
        first = self._vertices[:1]
        if not is_quantity(first) or not units.defined:
            units.strip(first, "length", f"vertices of {name}")
            return self._made
        factor = units.strip(1.0 * first.unit, "length", f"vertices of {name}")
        return self._made if factor == 1.0 else self._made.scaled(float(factor))

    def _layer(self, fraction: float) -> Polyhedron:
        """Return the shape scaled about its centre of mass."""
        vertices = self._made.input_vertices
        centre, _ = mass_properties(vertices, self._faces)
        heights = np.linalg.det((vertices - centre)[self._faces])
        if fraction < 1.0 and (heights <= 0.0).any():
            raise InvalidInput(
                f"shape is {self!r}, whose face {int(heights.argmin())} points away from its centre of mass; "
                "expected one whose whole surface is seen from there: a smaller one is not within any other"
            )
        scaled = centre + fraction * (vertices - centre)
        unit = self._vertices.unit if is_quantity(self._vertices) else None
        return Polyhedron(scaled if unit is None else scaled * unit, self._faces)

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return {"vertices": (self._vertices, "length")}

    def _with(self, units: Units, G: float) -> Self:
        """Return the shape in a system with units: its plain numbers become Quantities in them."""
        if is_quantity(self._vertices):
            return self
        other = object.__new__(type(self))
        for name in (name for cls in type(self).__mro__ for name in getattr(cls, "__slots__", ())):
            setattr(other, name, getattr(self, name))
        other._vertices = units.attach(self._vertices, "length")
        return other

    def __repr__(self) -> str:
        return f"Polyhedron({len(self._vertices)} vertices, {len(self._faces)} faces)"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Polyhedron):
            return NotImplemented
        return same((self._vertices, self._faces), (other._vertices, other._faces))

    def __hash__(self) -> int:
        return hash((Polyhedron, self._faces.tobytes()))

    def __reduce__(self) -> Any:
        return Polyhedron, (self._vertices, self._faces)


def mass_properties(vertices: Any, faces: _Indices) -> tuple[Any, Any]:
    """Return the centre of mass (3,) of a homogeneous polyhedron, and the inertia tensor (3, 3) of unit mass about it.

    Both are analytic functions of the vertices (V, 3), which may be complex.
    """
    middle = vertices.mean(axis=0)
    a, b, c = np.moveaxis((vertices - middle)[faces], 1, 0)
    volumes = np.sum(a * np.cross(b, c), axis=1) / 6.0
    total, corners = a + b + c, (a, b, c)
    second = sum(np.einsum("f,fi,fj->ij", volumes, part, part) for part in (total, *corners)) / (20.0 * volumes.sum())
    centre = volumes @ total / (4.0 * volumes.sum())
    second = second - np.outer(centre, centre)
    return middle + centre, np.trace(second) * np.eye(3) - second


def _read(path: Path) -> tuple[Floats, _Indices]:
    import gzip

    kind = path.suffix.lower().removeprefix(".")
    if kind in ("obj", "ply", "stl"):
        return _by_trimesh(path, kind)
    with gzip.open(path, "rt", encoding="utf-8") if kind == "gz" else path.open(encoding="utf-8") as file:
        text = file.read()
    rows = [row.split() for line in text.splitlines() if (row := line.partition("#")[0].strip())]
    if rows and rows[0][0] in ("v", "V"):
        return (
            np.array([row[1:4] for row in rows if row[0] in ("v", "V")], dtype=np.float64),
            np.array([row[1:4] for row in rows if row[0] in ("f", "F")], dtype=np.int64) - 1,
        )
    return _table(rows)


def _table(rows: list[list[str]]) -> tuple[Floats, _Indices]:
    """Return vertices and faces from rows that follow their numbers; the number of faces may precede the faces."""
    if not rows or not 1 <= len(rows[0]) <= 2 or not all(number.isdigit() for number in rows[0]):
        expected = "expected the number of vertices, or the numbers of vertices and faces"
        raise ValueError(f"the first row is not a count; {expected}")
    count = int(rows[0][0])
    points, corners = rows[1 : count + 1], rows[count + 1 :]
    if len(rows[0]) == 2:
        faces = int(rows[0][1])
    else:
        faces, corners = int(corners[0][0]), corners[1:]
    if len(points) != count or len(corners) != faces:
        raise ValueError(f"the table has {len(points)} of {count} vertices and {len(corners)} of {faces} faces")
    if any(len(row) not in (3, 4) for row in points + corners):
        raise ValueError("a row has too few or too many numbers; expected three, or an index and three")
    vertices = np.array([row[-3:] for row in points], dtype=np.float64)
    indices = np.array([row[-3:] for row in corners], dtype=np.int64)
    # Archives count vertices from 1, programs from 0.
    return vertices, indices - 1 if indices.min() > 0 else indices


def _by_trimesh(path: Path, kind: str) -> tuple[Floats, _Indices]:
    with need("shapes", f"a shape from {path.suffix.upper().removeprefix('.')}"):
        import trimesh

    with path.open("rb") as file:
        mesh: Any = trimesh.load(file, file_type=kind, process=False, force="mesh")
    vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    if kind == "stl":
        # The format repeats each vertex for each of its faces.
        vertices, indices = np.unique(vertices, axis=0, return_inverse=True)
        faces = indices.reshape(-1)[faces]
    return vertices, faces


def _healed(vertices: Floats, faces: _Indices) -> tuple[Floats, _Indices]:
    with need("shapes", "healing a shape"):
        # Trimesh needs networkx to fill holes and to orient faces.
        import networkx  # noqa: F401
        import trimesh

    mesh: Any = trimesh.Trimesh(vertices, faces, process=True, validate=True)
    mesh.fill_holes()
    mesh.fix_normals(multibody=True)
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
