"""Parameters of a sweep: grids, rows of a table, random draws, and products of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..base.arguments import integer
from ..base.units import gathered, is_quantity, need, refuse_masked
from ..errors import InvalidInput

__all__ = ["RNG", "Columns", "Draws", "Paired", "Plan", "draws", "identities", "paired", "plain_columns", "plan"]

#: A larger number of rows than this is taken for a mistake, as it exceeds any machine's memory.
_MOST_ROWS = 10**8
#: Parameters as files hold them: by name, the dimensions, the values in order, and the unit.
Columns: TypeAlias = Mapping[str, tuple[Sequence[Hashable], Sequence[Any], str | None]]
#: The argument of a setup that receives the row's random generator; no parameter may have this name.
RNG = "rng"


@dataclass(frozen=True, slots=True)
class Paired:
    """Columns of equal length whose rows are taken together; made by :func:`paired`."""

    columns: Mapping[str, Any]
    dimension: str = "row"
    labels: Any = None


@dataclass(frozen=True, slots=True)
class Draws:
    """Random draws of parameters; made by :func:`draws`."""

    count: int
    distributions: Mapping[str, Any]


def paired(**columns: Any) -> Paired:
    """Pair columns of equal length for :func:`fullbody.sweep`: the first values together, then the second ones, and so
    on.

    Parameters
    ----------
    **columns
        Numbers, Quantities or texts by the names of the parameters.

    Returns
    -------
    Paired
        Parameters that give the map one dimension, ``row``.

    Raises
    ------
    InvalidInput
        For columns of different lengths.

    Examples
    --------
    >>> import fullbody
    >>> rows = fullbody.ensembles.paired(mass_ratio=[0.1, 0.2], case=["A", "B"])
    >>> list(rows.columns)
    ['mass_ratio', 'case']
    """
    return Paired(columns)


def draws(count: int, **distributions: Any) -> Draws:
    """Draw parameters at random in :func:`fullbody.sweep`, which then needs ``seed=``.

    Parameters
    ----------
    count : int
        Number of draws.
    **distributions
        For each parameter a function of a ``numpy.random.Generator`` that returns one number, Quantity or text, or a
        distribution of ``scipy.stats`` with its parameters. The draws of each row of the map have a generator of their
        own, made from the seed and the row's number.

    Returns
    -------
    Draws
        Parameters that give the map one dimension, ``draw``. In a product with a grid, each grid point has draws of its
        own.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.ensembles.draws(100, mass_ratio=lambda rng: rng.uniform(0.01, 0.3)).count
    100
    """
    number = integer(count)
    if number is None or number < 1:
        raise InvalidInput(f"count is {count!r}; expected a whole number above zero")
    for name, distribution in distributions.items():
        if not callable(distribution) and not hasattr(distribution, "rvs"):
            raise InvalidInput(
                f"{name} is {distribution!r}; expected a function of a numpy.random.Generator, or a distribution of "
                "scipy.stats"
            )
    return Draws(number, dict(distributions))


@dataclass(frozen=True, slots=True)
class Column:
    """The values of a parameter and the dimensions of the map along which they lie, none for a fixed value."""

    values: Any
    along: tuple[int, ...]

    def value(self, place: tuple[int, ...]) -> Any:
        """Return the value at an index of the map, as one of Python's own types or as a Quantity."""
        found = self.values[tuple(place[axis] for axis in self.along)] if self.along else self.values[()]
        return found if is_quantity(found) else found.item() if isinstance(found, np.generic) else found


@dataclass(frozen=True, slots=True)
class Plan:
    """The rows of a sweep.

    Attributes
    ----------
    dimensions : dict
        Lengths of the dimensions by name; rows are numbered with the last dimension varying fastest.
    columns : dict
        The parameters by name.
    labels : dict
        Labels of dimensions that are not parameters.
    random : bool
        Whether any parameters are drawn at random.
    """

    dimensions: dict[str, int]
    columns: dict[str, Column]
    labels: dict[str, Any]
    random: bool = False

    def __len__(self) -> int:
        return math.prod(self.dimensions.values())

    @property
    def shape(self) -> tuple[int, ...]:
        """The lengths of the dimensions."""
        return tuple(self.dimensions.values())

    def row(self, number: int) -> dict[str, Any]:
        """Return the parameters of a row."""
        place = tuple(int(k) for k in np.unravel_index(number, self.shape)) if self.dimensions else ()
        return {name: column.value(place) for name, column in self.columns.items()}


def storable(text: str) -> bool:
    """Return whether files can hold a text."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return "\0" not in text


def fits(name: str) -> bool:
    """Return whether files can have a variable or dimension of that name."""
    return name not in ("", ".") and "/" not in name and storable(name)


def stream(seed: Any, row: int, kind: int) -> np.random.Generator:
    """Return the random generator of a row: kind 0 for its drawn parameters, 1 for its setup."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(row, kind)))


def plan(parameters: Any, seed: Any) -> Plan:
    """Return the rows of what :func:`fullbody.sweep` takes as parameters."""
    parts = list(parameters) if isinstance(parameters, list | tuple) else [parameters]
    if not parts:
        raise InvalidInput(
            "parameters is empty; expected a mapping, a table, draws(...), paired(...) or a list of these"
        )
    dimensions: dict[str, int] = {}
    columns: dict[str, Column] = {}
    labels: dict[str, Any] = {}
    random: dict[str, Any] = {}

    def dimension(name: str, size: int) -> int:
        if name in dimensions:
            raise InvalidInput(f"parameters has two dimensions of the name {name!r}; expected one")
        if not fits(name):
            raise InvalidInput(f"parameters has a dimension of the name {name!r}; expected text without '/'")
        dimensions[name] = size
        return len(dimensions) - 1

    def column(name: Any, values: Any, along: tuple[int, ...]) -> None:
        if not isinstance(name, str) or not name.isidentifier():
            raise InvalidInput(
                f"parameters has the name {name!r}; expected one that an argument of a function may have"
            )
        if name == RNG:
            raise InvalidInput(f"parameters has the name {RNG!r}, which is kept for the random numbers of a row")
        if name in columns or name in random:
            raise InvalidInput(f"parameters has {name!r} twice; expected it once")
        columns[name] = Column(values, along)

    for part in parts:
        match _kind(part):
            case Draws() as drawn:
                dimension("draw", drawn.count)
                for name, distribution in drawn.distributions.items():
                    column(name, None, ())
                    random[name] = distribution
            case Paired() as table:
                known = {name: _values(values, name) for name, values in table.columns.items()}
                sizes = {name: np.size(values) if np.ndim(values) else None for name, values in known.items()}
                lengths = set(sizes.values()) - {None}
                if len(lengths) != 1:
                    found = ", ".join(f"{name} has {size}" for name, size in sizes.items()) or "there are none"
                    raise InvalidInput(f"parameters has columns that do not pair: {found}; expected one length for all")
                axis = dimension(table.dimension, lengths.pop())  # type: ignore[arg-type]
                for name, values in known.items():
                    column(name, values, (axis,) if np.ndim(values) else ())
                if table.labels is not None:
                    labels[table.dimension] = table.labels
            case grid:
                for name, given in grid.items():
                    values = _values(given, name)
                    # The name is checked before it becomes that of a dimension.
                    column(name, values, (len(dimensions),) if np.ndim(values) else ())
                    if np.ndim(values):
                        dimension(name, len(values))
    for name in {"row", "draw"} & dimensions.keys() & columns.keys():
        if columns[name].along != (list(dimensions).index(name),):
            raise InvalidInput(f"parameters has the name {name!r}, which is that of a dimension; expected another")
    without = Plan(dimensions, columns, labels)
    if math.prod(without.shape) > _MOST_ROWS:
        product = " x ".join(f"{size} ({name})" for name, size in dimensions.items())
        raise InvalidInput(f"parameters has {product} rows; expected at most {_MOST_ROWS} in one sweep")
    return _draw(without, random, seed)


def _kind(part: Any) -> Any:
    """Return a part of the parameters as a mapping, as draws or as paired columns."""
    if isinstance(part, Mapping | Draws | Paired):
        return part
    with need("data", "a sweep"):
        import pandas as pd

    if not isinstance(part, pd.DataFrame):
        raise InvalidInput(
            f"parameters has {part!r}; expected a mapping of names to values, a pandas table, "
            "fullbody.ensembles.paired(...), fullbody.ensembles.draws(...), or a list of these"
        )
    if isinstance(part.index, pd.MultiIndex):
        raise InvalidInput("parameters is a table with an index of many levels; expected table.reset_index()")
    numbered = isinstance(part.index, pd.RangeIndex) and part.index.name is None
    name = "row" if part.index.name is None else str(part.index.name)
    labels = None if numbered else _values(part.index.to_numpy(), name)
    return Paired({name: part[name].to_numpy() for name in part.columns}, name, labels)


def _values(given: Any, name: str) -> Any:
    """Return the values of a parameter as an array with at most one dimension, or as a Quantity."""
    expected = "expected numbers, Quantities or texts, one or a list of them"
    if isinstance(given, str):
        return np.array(given)
    if callable(given) or hasattr(given, "rvs"):
        raise InvalidInput(f"{name} is {given!r}; expected values, or fullbody.ensembles.draws(..., {name}=...)")
    refuse_masked(given, name)
    if isinstance(given, Iterable) and not hasattr(given, "__array__"):
        given = list(given)
        texts = sum(isinstance(value, str) for value in given)
        if 0 < texts < len(given):
            raise InvalidInput(f"{name} is {given!r}, texts and others; {expected}")
        if not texts:
            given = gathered(given, name)
        if not texts and not is_quantity(given):
            given = _exact(given, name)
    elif not is_quantity(given) and not isinstance(given, np.ndarray):
        # A column of an astropy table keeps its unit.
        given = gathered(given, name)
    try:
        values = given if is_quantity(given) else np.asarray(given)
        if not is_quantity(values) and values.dtype.kind in "OT" and all(isinstance(v, str) for v in values.flat):
            values = values.astype(str)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{name} is {given!r}; {expected}") from error
    if np.ndim(values) > 1 or (np.ndim(values) and not len(values)):
        raise InvalidInput(f"{name} has shape {np.shape(values)}; {expected}")
    texts_fit = is_quantity(values) or values.dtype.kind != "U" or all(map(storable, np.ravel(values).tolist()))
    if not texts_fit or (not is_quantity(values) and values.dtype.kind not in "biufU"):
        raise InvalidInput(f"{name} is {given!r}; {expected}")
    return values


def _exact(given: Any, name: str) -> Any:
    """Return values as an array that represents each integer exactly.

    Numpy converts integers to floats beside floats, and beside negative integers if they are near 2**64.
    """
    if any(type(value) is bool or not isinstance(value, int | float | np.integer) for value in given):
        return given
    kinds = (np.float64,) if any(isinstance(value, float) for value in given) else (np.int64, np.uint64)
    for kind in kinds:
        with suppress(OverflowError):
            values = np.array(given, kind)
            if all(value != value or kept == value for kept, value in zip(values.tolist(), given, strict=True)):
                return values
    raise InvalidInput(
        f"{name} is {given!r}, whole numbers that one column cannot hold exactly; expected all of them from -2**63 to "
        "2**63 - 1, or from 0 to 2**64 - 1, and beside floats up to 2**53"
    )


def _draw(without: Plan, random: Mapping[str, Any], seed: Any) -> Plan:
    """Return the plan with the values of the drawn parameters."""
    if not random:
        return without
    if seed is None:
        raise InvalidInput(f"seed is None, but {next(iter(random))} is drawn; expected a whole number")
    found: dict[str, list[Any]] = {name: [] for name in random}
    for row in range(len(without)):
        rng = stream(seed, row, 0)
        for name, distribution in random.items():
            found[name].append(_drawn(distribution, rng, name))
    along = tuple(range(len(without.dimensions)))
    columns = {
        name: Column(_values(found[name], name).reshape(without.shape), along) if name in random else column
        for name, column in without.columns.items()
    }
    return Plan(without.dimensions, columns, without.labels, random=True)


def _drawn(distribution: Callable[[np.random.Generator], Any] | Any, rng: np.random.Generator, name: str) -> Any:
    value = distribution.rvs(random_state=rng) if hasattr(distribution, "rvs") else distribution(rng)
    if isinstance(value, str):
        return value
    if np.ndim(value):
        raise InvalidInput(
            f"a draw of {name} has shape {np.shape(value)}; expected one number, Quantity or text (arrays are drawn in "
            f"the setup, from its argument {RNG})"
        )
    return value if is_quantity(value) else np.asarray(value).item()


def chunks(missing: Sequence[bool], size: int) -> Iterable[list[int]]:
    """Yield the numbers of the missing rows in chunks, one chunk for each block of ``size`` rows."""
    for start in range(0, len(missing), size):
        rows = [row for row in range(start, min(start + size, len(missing))) if missing[row]]
        if rows:
            yield rows


def columns_of(found: Plan) -> dict[str, tuple[tuple[str, ...], Any]]:
    """Return the dimensions' names and the values of each parameter."""
    names = list(found.dimensions)
    return {
        name: (tuple(itertools.compress(names, (k in column.along for k in range(len(names))))), column.values)
        for name, column in found.columns.items()
    }


def plain_columns(found: Plan) -> Columns:
    """Return the parameters of a plan as files hold them."""
    return {
        name: (
            along,
            np.ravel(values.value if is_quantity(values) else values).tolist(),
            str(values.unit) if is_quantity(values) else None,
        )
        for name, (along, values) in columns_of(found).items()
    }


def identities(dimensions: Mapping[str, int], columns: Columns) -> list[tuple[str, ...]]:
    """Return for each row of a sweep a tuple that is equal for rows of equal parameters."""
    shape = tuple(dimensions.values())
    parts = []
    for name in sorted(columns):
        along, values, unit = columns[name]
        texts = np.array([f"{name} = {value!r} {unit or ''}" for value in values], dtype=object)
        # Each column lies along some of the dimensions, in the plan's order.
        inner = texts.reshape([size if dimension in along else 1 for dimension, size in dimensions.items()])
        parts.append(np.broadcast_to(inner, shape).ravel().tolist())
    return list(zip(*parts, strict=True)) if parts else [()] * math.prod(shape)
