"""The parameters of a fit: their initial values, units, bounds and priors."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import argument_names, suggestion
from ..base.limits import LARGEST, SMALLEST, Limits
from ..base.units import UNITLESS, as_quantity, is_quantity, refuse_booleans, strip_to
from ..base.values import ArrayFields, ByName
from ..errors import InvalidInput
from ..typing import Floats

_RANGE = Limits(least=-LARGEST, most=LARGEST, text=f"a finite number, of at most {LARGEST} in size")
_SIGMA = Limits(least=SMALLEST, infinite=True, text=f"a number above zero, at least {SMALLEST}")
_BOUNDS = Limits(infinite=True, text="finite numbers, or infinite ones for none")
#: The arrays of parameters, with the numbers that stand for missing bounds and priors.
ARRAYS = {"start": 0.0, "lower": -np.inf, "upper": np.inf, "mean": 0.0, "sigma": np.inf}


@dataclass(frozen=True, eq=False, repr=False)
class Free(ArrayFields):
    """A parameter of a fit: its initial value, and the prior knowledge of it.

    A parameter may be an array, such as the coefficients of a :class:`fullbody.HarmonicShape`: the setup receives the
    array, and each of its numbers is a parameter of its own, named ``"coefficients[3]"``, or ``"x[0, 2]"`` in an array
    of two dimensions. Bounds and priors are then arrays of the same shape, or numbers for all.

    Parameters
    ----------
    value : float, array_like, Quantity or text with a unit
        The initial value.
    min, max : float, array_like or Quantity, optional
        Bounds; none unless given. An infinite number in an array is no bound.
    prior : (mean, sigma), optional
        Mean and standard error of a normal distribution, which enters as one more residual; of each number of an array,
        independently. An infinite standard error is no prior.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.Free(0.1, min=0.0, max=1.0)
    Free(value=0.1, min=0.0, max=1.0, prior=None)
    >>> fullbody.fitting.Free([0.0, 0.0, 0.0], prior=(0.0, [0.1, 0.05, 0.05]))
    Free(value=[0.0, 0.0, 0.0], min=None, max=None, prior=(0.0, [0.1, 0.05, 0.05]))
    """

    value: Any
    _: KW_ONLY
    min: Any = None
    max: Any = None
    prior: Any = None


class Parameters:
    """Parameters as arrays (P,) of plain numbers, each in the unit of its start, ``None`` without one.

    The numbers of an array are parameters of their own, one after the other. There are the ``names`` of all P numbers,
    the ``arguments`` of a setup that consist of them, the ``shapes`` of these by name, () for a number, and the
    argument to which each number belongs, ``argument_of``. Bounds ``lower`` and ``upper`` are infinite where there are
    none, and so is ``sigma`` of a prior.
    """

    start: Floats
    lower: Floats
    upper: Floats
    mean: Floats
    sigma: Floats

    def __init__(self, parameters: Any) -> None:
        if not isinstance(parameters, Mapping) or not parameters:
            raise InvalidInput(f"parameters is {parameters!r}; expected a dict of names to starts, one or more")
        items = argument_names(parameters).items()
        free = {name: value if isinstance(value, Free) else Free(value) for name, value in items}
        starts = {name: as_quantity(entry.value, f"start of {name}") for name, entry in free.items()}
        self.arguments = tuple(free)
        self._units = {name: value.unit if is_quantity(value) else None for name, value in starts.items()}
        self.shapes: dict[str, tuple[int, ...]] = {}
        columns = []
        for name, entry in free.items():
            start = self._numbers(name, starts[name], "start")
            self.shapes[name] = start.shape
            if not start.size:
                raise InvalidInput(f"start of {name} is an array of shape {start.shape}; expected one number or more")
            lower = self._broadcast(name, entry.min, "min", "lower")
            upper = self._broadcast(name, entry.max, "max", "upper")
            for label, low, value, high in zip(self._labels(name), lower, start.ravel(), upper, strict=True):
                least, most = _shown(entry.min, low), _shown(entry.max, high)
                if not low < high:
                    raise InvalidInput(f"bounds of {label} are {least} and {most}; expected min < max")
                if not low <= value <= high:
                    within = f"expected one between {least} and {most}"
                    raise InvalidInput(f"start of {label} is {_shown(entry.value, value)}; {within}")
            columns.append((start.ravel(), lower, upper, *self._prior(name, entry.prior)))
        for array, parts in zip(ARRAYS, zip(*columns, strict=True), strict=True):
            setattr(self, array, np.concatenate(parts))
        self._index()

    def _index(self) -> None:
        """Set the names, arguments and units of all numbers from the arguments and their shapes."""
        self.names = tuple(label for name in self.arguments for label in self._labels(name))
        self.argument_of = tuple(name for name in self.arguments for _ in range(self.size_of(name)))
        self.units = tuple(self._units[name] for name in self.argument_of)

    def size_of(self, name: str) -> int:
        """Return how many numbers an argument has."""
        return int(np.prod(self.shapes[name]))

    def _labels(self, name: str) -> Iterator[str]:
        shape = self.shapes[name]
        return (f"{name}[{', '.join(map(str, index))}]" if shape else name for index in np.ndindex(shape))

    def _numbers(self, name: str, value: Any, what: str, infinite: bool = False) -> Floats:
        what, unit = f"{what} of {name}", self._units[name]
        refuse_booleans(value, what)
        value = as_quantity(value, what)
        if is_quantity(value) != (unit is not None):
            expected = "a plain number" if unit is None else f"a unit such as {unit}"
            raise InvalidInput(f"{what} is {value!r}; expected {expected}, as its start has")
        numbers = value if unit is None else strip_to(value, unit, what)
        shape: tuple[int | str, ...] = ("...",) if np.ndim(numbers) else ()
        return UNITLESS.numbers(numbers, "number", what, shape, _BOUNDS if infinite and shape else _RANGE)

    def _broadcast(self, name: str, value: Any, what: str, array: str) -> Floats:
        """Return the numbers (n,) of an argument; without a value, those for missing bounds or priors."""
        shape = self.shapes[name]
        if value is None:
            return np.full(self.size_of(name), ARRAYS[array])
        numbers = self._numbers(name, value, what, infinite=True)
        try:
            return np.array(np.broadcast_to(numbers, shape)).ravel()
        except ValueError as error:
            expected = f"{shape}, as its start has, or a number"
            raise InvalidInput(f"{what} of {name} has shape {numbers.shape}; expected {expected}") from error

    def _prior(self, name: str, prior: Any) -> tuple[Floats, Floats]:
        try:
            mean, sigma = (None, None) if prior is None else prior
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"prior of {name} is {prior!r}; expected (mean, sigma)") from error
        means = self._broadcast(name, mean, "mean of the prior", "mean")
        sigmas = self._broadcast(name, sigma, "sigma of the prior", "sigma")
        for label, number in zip(self._labels(name), sigmas, strict=True):
            UNITLESS.number(float(number), "number", f"sigma of the prior of {label}", _SIGMA)
        # An array may have no mean where it has no prior either.
        return np.where(np.isfinite(sigmas), means, 0.0), sigmas

    def __len__(self) -> int:
        return len(self.names)

    def indices(self, arguments: Sequence[str]) -> list[int]:
        """Return the indices of the numbers of some arguments."""
        return [k for name in arguments for k, argument in enumerate(self.argument_of) if argument == name]

    def only(self, arguments: Sequence[str]) -> Parameters:
        """Return the parameters that belong to these arguments, in the same order."""
        selection, indices = copy.copy(self), self.indices(arguments)
        selection.arguments = tuple(arguments)
        for array in ARRAYS:
            setattr(selection, array, getattr(self, array)[indices])
        selection._index()
        return selection

    def extended(self, names: Sequence[str], units: Sequence[Any]) -> Parameters:
        """Return these parameters and further ones, which have neither bounds nor priors."""
        extended = copy.copy(self)
        extended.arguments = (*self.arguments, *names)
        extended._units = self._units | dict(zip(names, units, strict=True))
        extended.shapes = self.shapes | dict.fromkeys(names, ())
        for array, missing in ARRAYS.items():
            setattr(extended, array, np.append(getattr(self, array), np.full(len(names), missing)))
        extended._index()
        return extended

    def named(self, values: Floats) -> dict[str, Any]:
        """Return values (P,), or columns (P, n), by arguments with their units; the arrays of columns are (n, ...)."""
        named, first = ByName({}), 0
        for name in self.arguments:
            part = values[first : first + self.size_of(name)]
            first += len(part)
            numbers: Any = np.moveaxis(part, 0, -1).reshape((*part.shape[1:], *self.shapes[name])).copy()
            numbers = float(numbers) if numbers.ndim == 0 else numbers
            named[name] = numbers if self._units[name] is None else numbers * self._units[name]
        return named

    def numbers(self, values: Any) -> Floats:
        """Return the plain numbers (P,) of values by their arguments, or of an array in the order of the names."""
        if not isinstance(values, Mapping):
            expected = Limits(text=f"{len(self)} finite numbers, or a dict by names")
            return UNITLESS.numbers(values, "number", "values", (len(self),), expected)
        for name in values:
            if name not in self.arguments:
                raise InvalidInput(f"values has {name!r}; {suggestion(str(name), self.arguments, 'all')}")
        if missing := [name for name in self.arguments if name not in values]:
            raise InvalidInput(f"values has no {missing[0]!r}; expected all of {', '.join(self.arguments)}")
        parts = []
        for name in self.arguments:
            part = self._numbers(name, values[name], "value")
            if part.shape != self.shapes[name]:
                raise InvalidInput(f"value of {name} has shape {part.shape}; expected {self.shapes[name]}")
            parts.append(part.ravel())
        return np.concatenate(parts)

    def shifted(self, values: Floats, k: int, by: float) -> Floats:
        """Return values (P,) of which one is shifted, or raise an error if that is beyond its bounds."""
        moved = values.copy()
        moved[k] += by
        if not self.lower[k] <= moved[k] <= self.upper[k]:
            raise InvalidInput(f"{self.names[k]} is beyond its bounds")
        return moved

    def period(self, k: int) -> float:
        """Return the number by which a parameter changes in a full rotation, if it is an angle; infinity otherwise."""
        unit = self.units[k]
        if unit is None:
            return 2.0 * np.pi
        return float((1.0 * unit).to_value("rad") ** -1) * 2.0 * np.pi if self.is_angle(k) else np.inf

    def is_angle(self, k: int) -> bool:
        """Return whether a parameter has a unit of angle."""
        return getattr(self.units[k], "physical_type", None) == "angle"

    def size(self, k: int, value: float) -> float:
        """Return a length over which the results of a setup are smooth, as far as it is known: a radian for angles, and
        not much less than the error of a prior.
        """
        if self.is_angle(k):
            return self.period(k) / (2.0 * np.pi)
        error = 0.1 * self.sigma[k] if np.isfinite(self.sigma[k]) else 0.0
        return float(max(abs(value), abs(self.start[k]), error)) or self.width(k)

    def width(self, k: int) -> float:
        """Return a length for a parameter that is zero: the error of its prior, the width of its bounds, or one."""
        lengths = (self.sigma[k], self.upper[k] - self.lower[k])
        return next((float(length) for length in lengths if np.isfinite(length)), 1.0)

    def at_bounds(self, values: Floats, norms: Floats) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Return which values are at their bounds: within 0.05 of the errors 1 / norms and 0.01 of the width."""
        margin = np.divide(0.05, norms, out=np.zeros_like(norms), where=norms > 0.0)
        margin = np.minimum(margin, 0.01 * (self.upper - self.lower))
        return values - self.lower <= margin, self.upper - values <= margin

    def shown(self, k: int, value: float) -> str:
        """Return a parameter's value as text, with its unit."""
        return f"{value:.8g}" if self.units[k] is None else f"{value:.8g} {self.units[k]}"


def _shown(argument: Any, number: float) -> Any:
    """Return an argument for a message: the number of an array, and any other argument unchanged."""
    return number if np.ndim(argument) else argument
