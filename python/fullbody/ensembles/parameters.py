"""Parameters of a sweep: grids, rows of a table, random draws, and products of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base.arguments import argument_names
from ..base.foreign import array_or_quantity
from ..base.kinds import whole_number
from ..base.units import as_quantity, is_quantity, need, refuse_masked
from ..errors import InvalidInput

#: A larger number of rows than this is taken for a mistake, as it exceeds any machine's memory.
_MAX_ROWS = 10**8
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

    n: int
    distributions: Mapping[str, Any]


def paired(**columns: Any) -> Paired:
    """Pair columns of equal length for :func:`fullbody.sweep`: the first values together, then the second ones.

    Parameters
    ----------
    **columns
        Numbers, Quantities or texts by the names of the parameters; for a parameter that is an array, one array (n,
        ...) of numbers, a row each.

    Returns
    -------
    Paired
        Parameters that give the map one dimension, ``row``.

    Examples
    --------
    >>> import fullbody
    >>> rows = fullbody.ensembles.paired(mass_ratio=[0.1, 0.2], case=["A", "B"])
    >>> list(rows.columns)
    ['mass_ratio', 'case']
    """
    return Paired(columns)


def draws(n: int, **distributions: Any) -> Draws:
    """Draw parameters at random in :func:`fullbody.sweep`, which then needs ``rng=``.

    Parameters
    ----------
    n : int
        Number of draws.
    **distributions
        For each parameter a function of a ``numpy.random.Generator`` that returns one number, Quantity or text, or a
        distribution of ``scipy.stats`` with its parameters. The draws of each row of the map have a generator of their
        own, made from ``rng`` and the row's number.

    Returns
    -------
    Draws
        Parameters that give the map one dimension, ``draw``. In a product with a grid, each grid point has draws of its
        own.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.ensembles.draws(100, mass_ratio=lambda rng: rng.uniform(0.01, 0.3)).n
    100
    """
    number = whole_number(n, "n")
    for name, distribution in distributions.items():
        if not callable(distribution) and not hasattr(distribution, "rvs"):
            raise InvalidInput(
                f"{name} is {distribution!r}; expected a function of a numpy.random.Generator, or a distribution of "
                "scipy.stats"
            )
    return Draws(number, dict(distributions))


@dataclass(frozen=True, slots=True)
class ParameterColumn:
    """The values of a parameter along some dimensions of the map, none for a fixed value.

    The values of a parameter that is an array have further dimensions, the ``inner`` ones.
    """

    values: Any
    dimensions: tuple[str, ...]
    unit: Any = None
    inner: tuple[str, ...] = ()

    def texts(self) -> Any:
        """Return an object array with a text for each value, equal for equal values."""
        unit = "" if self.unit is None else f" {self.unit}"
        values = np.asarray(self.values)
        outer = values.shape[: values.ndim - len(self.inner)]
        rows = values.reshape(-1, *values.shape[len(outer) :]).tolist()
        texts = np.empty(len(rows), dtype=object)
        texts[:] = [f"{value!r}{unit}" for value in rows]
        return texts.reshape(outer)


@dataclass(frozen=True, slots=True)
class ParameterTable:
    """The rows of a sweep: the lengths of its dimensions, of which the last varies fastest, parameters and labels."""

    dimensions: dict[str, int] = field(default_factory=dict)
    columns: dict[str, ParameterColumn] = field(default_factory=dict)
    labels: dict[str, ParameterColumn] = field(default_factory=dict)
    random: bool = False

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """The lengths of the dimensions."""
        return tuple(self.dimensions.values())

    @property
    def coordinates(self) -> dict[str, ParameterColumn]:
        """The parameters and the labels by name."""
        return self.columns | self.labels

    def row(self, number: int) -> dict[str, Any]:
        """Return the parameters of a row as Python's own types or as Quantities."""
        index = dict(zip(self.dimensions, np.unravel_index(number, self.shape), strict=True)) if self.dimensions else {}
        parameters = {}
        for name, column in self.columns.items():
            value = column.values[tuple(index[dimension] for dimension in column.dimensions)]
            number = value if column.inner else value.item()
            parameters[name] = number if column.unit is None else value << column.unit
        return parameters

    def texts(self) -> dict[str, str]:
        """Return texts of the dimensions and of each coordinate, by readable names, for comparison with others."""
        by_name = {"dimensions": "\n".join(f"{name}: {size}" for name, size in self.dimensions.items())}
        for name, column in self.coordinates.items():
            by_name[f"parameter {name}"] = "\n".join(["along " + ", ".join(column.dimensions), *column.texts().ravel()])
        return by_name

    def identities(self, numbered: bool) -> list[str]:
        """Return a text for each row: its parameters, its number if ``numbered``, and its count among equal rows."""
        texts = [[str(number) for number in range(len(self))]] if numbered else []
        for name, column in sorted(self.coordinates.items()):
            # Each column has some of the dimensions, in the table's order.
            shape = [size if dimension in column.dimensions else 1 for dimension, size in self.dimensions.items()]
            values = np.broadcast_to(column.texts().reshape(shape), self.shape)
            texts.append([f"{name} = {text}" for text in values.ravel()])
        counts = Counter[str]()
        identities = []
        for row in map("; ".join, zip(*texts, strict=True) if texts else [()] * len(self)):
            counts[row] += 1
            identities.append(row if counts[row] == 1 else f"{row} ({counts[row]})")
        return identities

    def add_dimension(self, name: str, size: int) -> None:
        """Add a dimension."""
        if name in self.dimensions:
            raise InvalidInput(f"parameters has two dimensions of the name {name!r}; expected one")
        if not is_valid_name(name):
            raise InvalidInput(f"parameters has a dimension of the name {name!r}; expected text without '/'")
        self.dimensions[name] = size

    def add(self, name: str, column: ParameterColumn) -> None:
        """Add a parameter."""
        if name == RNG:
            raise InvalidInput(f"parameters has the name {RNG!r}, which is kept for the random numbers of a row")
        if name in self.columns:
            raise InvalidInput(f"parameters has {name!r} twice; expected it once")
        self.columns[name] = column


def is_storable(text: str) -> bool:
    """Return whether files can hold a text."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return "\0" not in text


def is_valid_name(name: str) -> bool:
    """Return whether files can have a variable or dimension of that name."""
    return name not in ("", ".") and "/" not in name and is_storable(name)


def stream(seed: int, row: int, kind: int) -> np.random.Generator:
    """Return the random generator of a row: kind 0 for its drawn parameters, 1 for its setup."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(row, kind)))


def tabulated(parameters: Any, seed: int | None) -> ParameterTable:
    """Return the rows of the parameters of :func:`fullbody.sweep`."""
    parts = list(parameters) if isinstance(parameters, list | tuple) else [parameters]
    if not parts:
        raise InvalidInput(
            "parameters is empty; expected a mapping, a table, draws(...), paired(...) or a list of some"
        )
    table = ParameterTable()
    random: dict[str, Any] = {}
    for part in parts:
        match _kind(part):
            case Draws(n, distributions):
                table.add_dimension("draw", n)
                random |= (names := argument_names(distributions))
                for name in names:
                    table.add(name, ParameterColumn(None, ()))
            case Paired() as pairs:
                _add_pairs(table, pairs)
            case grid:
                for name, values in argument_names(grid).items():
                    column = _column(values, name, (name,))
                    # The name is checked before it becomes that of a dimension.
                    table.add(name, column)
                    if column.dimensions:
                        table.add_dimension(name, len(column.values))
    for name in table.dimensions.keys() & table.columns.keys():
        if table.columns[name].dimensions != (name,):
            raise InvalidInput(f"parameters has the name {name!r}, which is that of a dimension; expected another")
    if len(table) > _MAX_ROWS:
        product = " x ".join(f"{size} ({name})" for name, size in table.dimensions.items())
        raise InvalidInput(f"parameters has {product} rows; expected at most {_MAX_ROWS} in one sweep")
    return _with_draws(table, random, seed) if random else table


def _add_pairs(table: ParameterTable, pairs: Paired) -> None:
    dimensions = (pairs.dimension,)
    items = argument_names(pairs.columns).items()
    columns = {name: _column(values, name, dimensions, rows=True) for name, values in items}
    sizes = {name: len(column.values) if column.dimensions else None for name, column in columns.items()}
    lengths = set(sizes.values()) - {None}
    if len(lengths) != 1:
        texts = ", ".join(f"{name} has {size}" for name, size in sizes.items()) or "there are none"
        raise InvalidInput(f"parameters has columns that do not pair: {texts}; expected one length for all")
    table.add_dimension(pairs.dimension, lengths.pop() or 0)
    for name, column in columns.items():
        table.add(name, column)
    if pairs.labels is not None:
        table.labels[pairs.dimension] = _column(pairs.labels, pairs.dimension, dimensions)


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
    columns = {name: part[name].to_numpy() for name in part.columns}
    dimension = "row" if part.index.name is None else str(part.index.name)
    return Paired(columns, dimension, None if numbered else part.index.to_numpy())


def _column(argument: Any, name: str, dimensions: tuple[str, ...], rows: bool = False) -> ParameterColumn:
    """Return the values of a parameter, which lie along the dimensions unless there is a single one.

    With ``rows`` each value may be an array.
    """
    expected = "expected numbers, Quantities or texts, one or a list of them"
    if callable(argument) or hasattr(argument, "rvs"):
        raise InvalidInput(f"{name} is {argument!r}; expected values, or fullbody.ensembles.draws(..., {name}=...)")
    refuse_masked(argument, name)
    if isinstance(argument, Iterable) and not isinstance(argument, str) and not hasattr(argument, "__array__"):
        argument = list(argument)
    of_texts = getattr(getattr(argument, "dtype", None), "kind", "") in ("O", "T", "U")
    items = np.ravel(argument).tolist() if of_texts else argument if isinstance(argument, list) else [argument]
    texts = sum(isinstance(item, str) for item in items)
    if 0 < texts < len(items):
        raise InvalidInput(f"{name} is {argument!r}, texts and others; {expected}")
    argument = argument if texts else as_quantity(argument, name)
    try:
        values = np.asarray(getattr(argument, "value", argument))
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{name} is {argument!r}; {expected}") from error
    if texts:
        values = values.astype(str)
    elif isinstance(argument, list):
        values = _exact(argument, name)
    inner = tuple(f"{name}_{axis}" for axis in range(values.ndim - 1)) if rows else ()
    if values.ndim - len(inner) > 1 or not values.size or (inner and texts):
        raise InvalidInput(f"{name} has shape {values.shape}; {expected}")
    if values.dtype.kind not in "biufU" or (values.dtype.kind == "U" and not all(map(is_storable, values.ravel()))):
        raise InvalidInput(f"{name} is {argument!r}; {expected}")
    unit = argument.unit if is_quantity(argument) else None
    return ParameterColumn(values, dimensions[: values.ndim], unit, inner)


def _exact(items: list[Any], name: str) -> Any:
    """Return values as an array that holds each integer exactly, which numpy may convert to floats."""
    if any(type(value) is bool or not isinstance(value, int | float | np.integer) for value in items):
        return np.asarray(items)
    kinds = (np.float64,) if any(isinstance(value, float) for value in items) else (np.int64, np.uint64)
    for kind in kinds:
        with suppress(OverflowError):
            values = np.array(items, kind)
            if all(item != item or value == item for value, item in zip(values.tolist(), items, strict=True)):
                return values
    raise InvalidInput(
        f"{name} is {items!r}, whole numbers that one column cannot hold exactly; expected all of them from -2**63 to "
        "2**63 - 1, or from 0 to 2**64 - 1, and beside floats up to 2**53"
    )


def _with_draws(table: ParameterTable, random: Mapping[str, Any], seed: int | None) -> ParameterTable:
    """Return the table with the values of the drawn parameters."""
    if seed is None:
        raise InvalidInput(f"rng is None, but {next(iter(random))} is drawn; expected a whole number or a generator")
    values: dict[str, list[Any]] = {name: [] for name in random}
    for row in range(len(table)):
        rng = stream(seed, row, 0)
        for name, distribution in random.items():
            draw = distribution.rvs(random_state=rng) if hasattr(distribution, "rvs") else distribution(rng)
            draw = draw if isinstance(draw, str) else array_or_quantity(draw, f"a draw of {name}")
            if not isinstance(draw, str) and np.ndim(draw):
                raise InvalidInput(
                    f"a draw of {name} has shape {np.shape(draw)}; expected one number, Quantity or text (arrays are "
                    f"drawn in the setup, from its argument {RNG})"
                )
            values[name].append(draw if isinstance(draw, str) or is_quantity(draw) else np.asarray(draw).item())
    for name in random:
        column = _column(values[name], name, ("draw",))
        table.columns[name] = ParameterColumn(column.values.reshape(table.shape), tuple(table.dimensions), column.unit)
    return ParameterTable(table.dimensions, table.columns, table.labels, random=True)
