"""Numbers of a variable, read from where HDF5 says they lie in the file.

HDF5 itself takes the lengths of the pieces on trust when it decodes them, and reads beyond its memory where they are
wrong. So HDF5 gives the places and lengths alone, and the bytes there are read and decoded here.
"""

from __future__ import annotations

import zlib
from math import prod
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput

__all__ = ["read"]

#: How many bytes one byte of deflate can make at most.
_DEFLATE_RATIO = 1032


def read(name: str, variable: Any, file: IO[bytes]) -> npt.NDArray[Any]:
    """All numbers of a variable.

    Parameters
    ----------
    name : str
    variable : h5py.Dataset
    file : binary file
        The one that the variable is in.

    Raises
    ------
    InvalidInput
        For more numbers than the file is long enough for, for some that are not there, and for damaged ones.
    """
    import h5py

    properties = variable.id.get_create_plist()
    filters = [properties.get_filter(k)[0] for k in range(properties.get_nfilters())]
    known = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)
    for code in filters:
        if code not in known:
            raise InvalidInput(f"{name} has the filter {code} of HDF5; expected deflate, shuffle and fletcher32 alone")
    end = file.seek(0, 2)
    largest = max(variable.size, prod(variable.chunks or ())) * variable.dtype.itemsize
    if largest > end * (_DEFLATE_RATIO if h5py.h5z.FILTER_DEFLATE in filters else 1):
        raise InvalidInput(f"{name} has {largest} bytes by its header, more than a file of {end} bytes can hold")
    if properties.get_layout() == h5py.h5d.COMPACT or not variable.size:
        # In the header of the variable, or nowhere.
        return np.asarray(variable[()])
    values = np.empty(variable.shape, variable.dtype)
    for corner, place, size, skipped in _places(name, variable, end):
        if place is None or place + size > end:
            raise _incomplete(name)
        file.seek(place)
        # The filters were applied in their order, but for those with a bit in the mask.
        used = [code for k, code in enumerate(filters) if not skipped >> k & 1]
        shape = variable.chunks or variable.shape
        data = _decoded(name, file.read(size), used[::-1], variable.dtype.itemsize, prod(shape))
        piece = np.frombuffer(data, variable.dtype).reshape(shape)
        # The last pieces reach beyond the variable.
        inside: Any = tuple(slice(first, first + length) for first, length in zip(corner, shape, strict=True))
        values[inside] = piece[tuple(map(slice, values[inside].shape))]
    return values


def _places(name: str, variable: Any, end: int) -> list[tuple[tuple[int, ...], int | None, int, int]]:
    """For each piece its first element, its first byte, its length in bytes, and the filters that were left out."""
    if variable.chunks is None:
        return [((0,) * variable.ndim, variable.id.get_offset(), variable.id.get_storage_size(), 0)]
    counts = [-(-length // step) for length, step in zip(variable.shape, variable.chunks, strict=True)]
    places: list[tuple[tuple[int, ...], int | None, int, int]] = []

    def visit(piece: Any) -> bool | None:
        places.append((piece.chunk_offset, piece.byte_offset, piece.size, piece.filter_mask))
        # Anything but None ends the visit, which could go on for ever in a forged index.
        return True if len(places) > min(prod(counts), end) else None

    variable.id.chunk_iter(visit)
    corners = {place[0] for place in places}
    if len(places) != prod(counts) or len(corners) != len(places):
        raise _incomplete(name)
    for corner in corners:
        if any(
            first % step or first >= size
            for first, step, size in zip(corner, variable.chunks, variable.shape, strict=True)
        ):
            raise _incomplete(name)
    return places


def _decoded(name: str, data: bytes, filters: list[int], width: int, count: int) -> bytes:
    """What the filters made of a piece, undone in this order."""
    import h5py

    for code in filters:
        if code == h5py.h5z.FILTER_FLETCHER32:
            data, written = data[:-4], data[-4:]
            if _fletcher32(data) != int.from_bytes(written, "little"):
                raise InvalidInput(f"{name} is truncated or damaged: the checksum of its numbers does not fit")
        elif code == h5py.h5z.FILTER_DEFLATE:
            # Never more than the piece with its checksums.
            data = zlib.decompressobj().decompress(data, width * count + 4 * len(filters))
        else:
            whole = len(data) // width * width
            rows = np.frombuffer(data[:whole], np.uint8).reshape(width, -1)
            data = rows.T.tobytes() + data[whole:]
    if len(data) != width * count:
        raise _incomplete(name)
    return data


def _fletcher32(data: bytes) -> int:
    """HDF5's checksum: sums, and sums of sums, of two bytes each, with end-around carry."""
    words = np.frombuffer(data + b"\0" * (len(data) % 2), ">u2").astype(np.uint64)
    weights = np.arange(len(words), 0, -1, dtype=np.uint64) % 65535
    total = 0
    for sums in (words * weights, words):
        plain = int(sums.sum())
        # With that carry all multiples of 65535 but zero itself are 65535.
        total = total << 16 | (plain and (plain - 1) % 65535 + 1)
    return total


def _incomplete(name: str) -> InvalidInput:
    return InvalidInput(f"{name} is truncated or damaged: not all of its numbers are in the file")
