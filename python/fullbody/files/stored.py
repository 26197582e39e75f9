"""What a NetCDF-4 file of a run holds, read on the assumption that anybody may have written it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..base.units import need
from ..errors import InvalidInput
from . import pieces, seal

__all__ = ["Stored", "check_order", "check_unit", "opened"]

#: NetCDF's own mark of numbers that were never written.
_NEVER = 9.969209968386869e36


@contextmanager
def opened(path: Path) -> Iterator[Stored]:
    """The content of a file, while it is open.

    Raises
    ------
    InvalidInput
        For what is no NetCDF-4 file, or a damaged one.
    FileNotFoundError
        Where there is none.
    """
    with need("data", "a run from a file"):
        import h5py

    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.is_dir():
        raise InvalidInput("it is a folder")
    with path.open("rb") as file:
        sealed = seal.check(file)
        # This is the open file that was checked, even if another has its name by now.
        with _readable("it"):
            content = h5py.File(file, "r")
        with content:
            yield Stored(content, file, sealed)


@contextmanager
def _readable(what: str) -> Iterator[None]:
    """A context in which the many kinds of errors of h5py about a damaged file become one error of this package."""
    try:
        yield
    except (InvalidInput, MemoryError):
        raise
    except Exception as error:
        raise InvalidInput(f"{what} is truncated or damaged") from error


class Stored:
    """Numbers and texts of an open file, each checked before it is read.

    Attributes
    ----------
    sealed : bool
        Whether a checksum vouches for the whole file.
    """

    def __init__(self, content: Any, file: IO[bytes], sealed: bool) -> None:
        self.sealed = sealed
        self._content, self._file = content, file

    def __contains__(self, name: str) -> bool:
        """Whether there is a variable of this name."""
        with _readable("it"):
            return name in self._content

    def attribute(self, name: str) -> Any:
        """A text or number that describes the whole file, or ``None``."""
        return _attribute(self._content, name, f"attribute {name}")

    def text(self, name: str, default: str | None = None) -> str:
        """A text that describes the whole file."""
        value = self.attribute(name)
        if value is None and default is None:
            raise InvalidInput(f"it has no attribute {name}")
        if value is not None and not isinstance(value, str):
            raise InvalidInput(f"attribute {name} is {value!r}; expected text")
        return default if value is None else value  # type: ignore[return-value]

    def numbers(
        self, name: str, sizes: dict[str, int | None], whole: bool = False, missing: bool = False
    ) -> npt.NDArray[Any]:
        """A variable.

        Parameters
        ----------
        name : str
        sizes : dict
            Its dimensions with their lengths, ``None`` for any.
        whole : bool
            Whether it has whole numbers; others are finite floats.
        missing : bool
            Whether NaN stands for values that there are not.
        """
        with _readable(name):
            variable = self._variable(name)
            self._check_kind(name, variable, "iu" if whole else "f")
            _check_shape(name, variable, sizes)
            values = pieces.read(name, variable, self._file).astype(np.int64 if whole else np.float64, copy=False)
            fills = [_attribute(variable, fill, name) for fill in ("_FillValue", "missing_value")]
            _check_values(name, np.nan_to_num(values, nan=0.0, posinf=np.inf) if missing else values, fills)
        return values

    def _variable(self, name: str) -> Any:
        import h5py

        if name not in self:
            raise InvalidInput(f"it has no variable {name}")
        if not isinstance(self._content.get(name, getlink=True), h5py.HardLink):
            raise InvalidInput(f"{name} is a link to elsewhere; expected a variable of this file")
        variable = self._content[name]
        if not isinstance(variable, h5py.Dataset):
            raise InvalidInput(f"{name} is a group; expected a variable")
        if variable.external or variable.is_virtual:
            raise InvalidInput(f"{name} is kept in another file; expected numbers in this one")
        return variable

    def _check_kind(self, name: str, variable: Any, kinds: str) -> None:
        if variable.dtype.kind not in kinds:
            wanted = "whole numbers" if "i" in kinds else "floating-point numbers"
            raise InvalidInput(f"{name} is of the type {variable.dtype}; expected {wanted}")
        for packing in ("scale_factor", "add_offset"):
            if (value := _attribute(variable, packing, name)) is not None:
                raise InvalidInput(f"{name} has the {packing} {value}; expected the numbers themselves, not packed")


def _attribute(owner: Any, name: str, what: str) -> Any:
    """A single text or number, or ``None`` where there is none."""
    with _readable(what):
        if name not in owner.attrs:
            return None
        value = np.asarray(owner.attrs[name])
        if value.size != 1:
            raise InvalidInput(f"{what} is of shape {value.shape}; expected one text or number")
        value = value.reshape(-1)[0]
        value = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, str):
            # What is no UTF-8 is an error now; h5py keeps it as halves of characters.
            value.encode()
        return value.decode() if isinstance(value, bytes) else value


def _check_shape(name: str, variable: Any, sizes: dict[str, int | None]) -> None:
    expected = ", ".join("any" if size is None else str(size) for size in sizes.values())
    found = dict(enumerate(variable.shape))
    if len(found) != len(sizes) or any(size not in (None, found[k]) for k, size in enumerate(sizes.values())):
        raise InvalidInput(f"{name} has shape {variable.shape}; expected ({expected})")
    own = [name] if variable.is_scale else [scale.name.lstrip("/") for dim in variable.dims for scale in dim.values()]
    if own != list(sizes):
        raise InvalidInput(f"{name} has the dimensions {', '.join(own) or 'of no name'}; expected {', '.join(sizes)}")


def _check_values(name: str, values: npt.NDArray[Any], fills: list[Any]) -> None:
    """Refuse a variable that is not numbers throughout."""
    missing = ~np.isfinite(values)
    for fill in (_NEVER, *fills):
        if isinstance(fill, int | float):
            missing |= values == fill
    if missing.any():
        place = tuple(np.argwhere(missing)[0].tolist())
        raise InvalidInput(f"{name}{list(place)} is {values[place]}; expected finite numbers that are not the filling")


def check_order(times: npt.NDArray[np.float64], name: str, repeated: bool) -> None:
    """Refuse times that do not all go one way; ``repeated`` says whether some may be equal."""
    before, after = times[:-1], times[1:]
    forward = len(after) > 0 and times[-1] > times[0]
    right = (after > before if forward else after < before) | ((after == before) & repeated)
    if not right.all():
        k = int(np.argmin(right))
        expected = "times in the direction of the run" + ("" if repeated else ", none twice")
        raise InvalidInput(f"{name}[{k + 1}] is {after[k]}, after {before[k]}; expected {expected}")


def check_unit(attitudes: npt.NDArray[np.float64], name: str) -> None:
    """Refuse quaternions that are not of length one, as far as single precision holds that."""
    lengths = np.hypot.reduce(attitudes, axis=-1)
    wrong = np.abs(lengths - 1.0) > 1e-6
    if wrong.any():
        place = tuple(np.argwhere(wrong)[0].tolist())
        raise InvalidInput(f"{name}{list(place)} has the length {lengths[place]}; expected quaternions of length 1")
