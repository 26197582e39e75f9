"""Datasets as archives of numpy (``.npz``), which need no other package."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput

SUFFIX = ".npz"
#: The first bytes of an archive.
SIGNATURE = b"PK\x03\x04"
#: The array with the dimensions and attributes of the others, as JSON.
_HEADER = "description"


class Variable(NamedTuple):
    """An array with the names of its dimensions."""

    dims: tuple[str, ...]
    values: npt.NDArray[Any]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of the values."""
        return self.values.dtype

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the values."""
        return self.values.shape


class Dataset(NamedTuple):
    """Variables and attributes by their names, as those of an ``xarray.Dataset``."""

    variables: dict[str, Variable]
    attrs: dict[str, Any]


def write(variables: dict[str, Any], attributes: dict[str, Any], path: Path) -> None:
    """Write variables, each as (dimensions, values, attributes), and attributes of the whole."""
    described: dict[str, Any] = {}
    arrays: dict[str, Any] = {}
    for name, (dims, values, *notes) in variables.items():
        described[name] = {"dims": [dims] if isinstance(dims, str) else list(dims), "attributes": dict(*notes)}
        arrays[name] = np.asarray(values)
    arrays[_HEADER] = np.array(json.dumps({"attributes": attributes, "variables": described}))
    np.savez(path, **arrays)


def read(file: IO[bytes]) -> Dataset:
    """Read an archive, whose parts have checksums; one that is damaged or has no description is refused."""
    try:
        # Objects of Python, which could run any code, are refused.
        with np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(str(arrays.pop(_HEADER)))
        variables = {name: Variable(tuple(part["dims"]), arrays[name]) for name, part in header["variables"].items()}
        return Dataset(variables, dict(header["attributes"]))
    except (zipfile.BadZipFile, EOFError, OSError, ArithmeticError, NotImplementedError, RuntimeError) as error:
        raise InvalidInput(f"the file is truncated or damaged ({error})") from error
    except (LookupError, TypeError, AttributeError, ValueError, MemoryError) as error:
        raise InvalidInput(f"the file is an archive of numpy without the description of a run ({error})") from error
