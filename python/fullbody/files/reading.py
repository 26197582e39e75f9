"""Reading of files, whose content is checked since any program may have written them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from ..base.arguments import integer
from ..base.atomic import as_path, other_reader
from ..base.units import need
from ..errors import InvalidInput, UncheckedFile, caution
from ..typing import Floats
from . import checksum, npz

_Built = TypeVar("_Built")

#: NetCDF's mark of numbers that were never written.
_NEVER = 9.969209968386869e36
#: The largest number of bytes into which one byte of deflate can expand.
_DEFLATE_RATIO = 1032


def netcdf() -> Any:
    """Import xarray with its packages for NetCDF, or raise an error that says how to install them."""
    with need("data", "a run as a file"):
        import h5netcdf  # noqa: F401
        import h5py  # noqa: F401
        import xarray as xr
    return xr


def read(path: Any, kind: str, build: Callable[[Content], _Built]) -> _Built:
    """Build an object from the content of a file that should hold a ``kind``, such as ``"run"``; errors name the file.

    A file that is neither NetCDF-4 nor an archive of numpy, or damaged, is refused, and content that ``build`` refuses;
    a file without a checksum is an :class:`UncheckedFile`, with a warning.
    """
    path = as_path(path)
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    attributes = None
    try:
        if path.is_dir():
            raise InvalidInput("the file is a folder")
        with path.open("rb") as file:
            # The open file is read that was checked, even if another file has its name by now.
            checked, dataset = _dataset(file)
            attributes = dataset.attrs
            result = build(Content(dataset))
    except InvalidInput as error:
        other = other_reader(path, "fullbody.load_flight" if kind == "flight" else "fullbody.load", attributes)
        raise InvalidInput(f"{path} is not a readable {kind} of fullbody: {error}{other}") from error
    if not checked:
        text = "another program wrote it, and damage may go unseen"
        caution(f"{path} has no checksum of the whole file: {text}", UncheckedFile)
    return result


def _dataset(file: Any) -> tuple[bool, Any]:
    """Return whether an open file has a checksum, and its whole content."""
    begin = file.read(len(npz.SIGNATURE))
    file.seek(0)
    if begin == npz.SIGNATURE:
        return True, npz.read(file)
    xr = netcdf()
    return checksum.check(file), _of_netcdf(xr, file, file.seek(0, 2))


def _of_netcdf(xr: Any, file: Any, size: int) -> Any:
    """Read the whole content of an open NetCDF-4 file."""
    import h5py

    try:
        # On its own h5netcdf would report a damaged file a second time, on standard error.
        with h5py.File(file, "r") as content:
            for name, variable in content.items():
                if isinstance(variable, h5py.Dataset) and variable.nbytes > size * _DEFLATE_RATIO:
                    header = f"{name} has {variable.nbytes} bytes by its header"
                    raise InvalidInput(f"{header}, more than a file of {size} bytes can hold")
        with xr.open_dataset(file, engine="h5netcdf", decode_times=False) as dataset:
            return dataset.load()
    except (InvalidInput, MemoryError):
        raise
    except Exception as error:
        # The libraries raise errors of many kinds for a damaged file.
        raise InvalidInput(f"the file is truncated or damaged ({error})") from error


class Content:
    """Numbers and texts of a file, each checked when it is read."""

    def __init__(self, dataset: Any) -> None:
        self._dataset = dataset

    def __contains__(self, name: str) -> bool:
        return name in self._dataset.variables

    def has_attribute(self, name: str) -> bool:
        """Return whether there is an attribute of this name."""
        return name in self._dataset.attrs

    def _attribute(self, name: str) -> Any:
        if not self.has_attribute(name):
            raise InvalidInput(f"the file has no attribute {name}")
        return self._dataset.attrs[name]

    def check_format(self, name: str, expected: int) -> None:
        """Raise an error if the attribute of this name is another format than the expected one."""
        value = self._attribute(name)
        if integer(value) != expected:
            expected_text = f"expected {expected}, which this version reads"
            raise InvalidInput(f"the file's format is {value}, by its attribute {name}; {expected_text}")

    def text(self, name: str) -> str:
        """Return a text attribute of the file."""
        value = self._attribute(name)
        if not isinstance(value, str):
            raise InvalidInput(f"attribute {name} is {value}; expected text")
        return value

    def parsed(self, name: str, build: Callable[[Any], _Built]) -> _Built:
        """Build an object from an attribute's JSON; errors name the attribute."""
        text = self.text(name)
        try:
            return build(json.loads(text))
        except json.JSONDecodeError as error:
            raise InvalidInput(f"attribute {name} is not JSON: {error}") from error
        except RecursionError as error:
            raise InvalidInput(f"attribute {name} has brackets in brackets, too deep to be read") from error
        except KeyError as error:
            raise InvalidInput(f"attribute {name} has no entry {error}") from error
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            # Errors are of many kinds, since the text may be any JSON.
            raise InvalidInput(f"attribute {name}: {error}") from error

    def numbers(
        self, name: str, sizes: dict[str, int | None], integers: bool = False, missing: bool = False
    ) -> npt.NDArray[Any]:
        """Return a variable after checking its type, dimensions, shape and values.

        The names of its dimensions have their lengths, with ``None`` for any length. The numbers are integers
        (``integers``) or finite floats; with ``missing`` NaN is accepted for missing values.
        """
        if name not in self:
            raise InvalidInput(f"the file has no variable {name}")
        variable = self._dataset.variables[name]
        if variable.dtype.kind not in ("iu" if integers else "f"):
            expected_text = "whole numbers" if integers else "floating-point numbers"
            raise InvalidInput(f"{name} is of the type {variable.dtype}; expected {expected_text}")
        if variable.dims != tuple(sizes):
            dims = ", ".join(map(str, variable.dims)) or "of no name"
            raise InvalidInput(f"{name} has the dimensions {dims}; expected {', '.join(sizes)}")
        if any(size not in (None, length) for size, length in zip(sizes.values(), variable.shape, strict=True)):
            expected = ", ".join("any" if size is None else str(size) for size in sizes.values())
            raise InvalidInput(f"{name} has shape {variable.shape}; expected ({expected})")
        values = np.array(variable.values, dtype=np.int64 if integers else np.float64, order="C")
        invalid = np.isinf(values) | (values == _NEVER) | (np.isnan(values) & (not missing))
        if invalid.any():
            index = tuple(np.argwhere(invalid)[0].tolist())
            raise InvalidInput(f"{name}{list(index)} is {values[index]}; expected finite numbers")
        return values


def check_order(times: Floats, name: str, repeated: bool) -> None:
    """Raise an error for times that are not in order; ``repeated`` says whether some may be equal."""
    previous, following = times[:-1], times[1:]
    forward = len(following) > 0 and times[-1] > times[0]
    right = (following > previous if forward else following < previous) | ((following == previous) & repeated)
    if not right.all():
        k = int(np.argmin(right))
        expected = "times in the direction of the run" + ("" if repeated else ", none twice")
        raise InvalidInput(f"{name}[{k + 1}] is {following[k]}, after {previous[k]}; expected {expected}")


def check_unit(attitudes: Floats, name: str) -> None:
    """Raise an error for quaternions that are not of length one to single precision."""
    lengths = np.hypot.reduce(attitudes, axis=-1)
    invalid = np.abs(lengths - 1.0) > 1e-6
    if invalid.any():
        index = tuple(np.argwhere(invalid)[0].tolist())
        raise InvalidInput(f"{name}{list(index)} has the length {lengths[index]}; expected quaternions of length 1")
