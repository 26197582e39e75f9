"""A checksum of a whole NetCDF-4 file, read before HDF5 opens it.

HDF5 trusts what it reads: zeros in one of its heaps keep it in an endless loop. But its first bytes say where the file
ends for HDF5, and no program that reads HDF5 or NetCDF looks at what follows. There the seal stands, a line of text
with the checksum of all bytes before it. Programs that write into the file cut it off.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import IO

from ..errors import InvalidInput

__all__ = ["check", "seal"]

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
#: Where the size of addresses and the end-of-file address stand in the superblock, by its version (HDF5 File Format
#: Specification, section II.A).
_SUPERBLOCKS = {0: (13, 40), 1: (13, 44), 2: (9, 28), 3: (9, 28)}
#: How a global heap begins, with its version (section III.E).
_HEAP = b"GCOL\x01\x00\x00\x00"
#: The size of its header, and of the header of each object in it.
_HEADER = 16
#: Bytes that are read at a time, which takes a few milliseconds.
_BLOCK = 2**22


def seal(file: IO[bytes]) -> bytes:
    """The line that belongs behind the bytes of a file of HDF5."""
    length = file.seek(0, 2)
    digest = hashlib.sha256()
    for block in _blocks(file, length):
        digest.update(block)
    return _line(length, digest.hexdigest())


def check(file: IO[bytes]) -> bool:
    """Refuse a file that is damaged, without HDF5.

    Returns
    -------
    bool
        Whether it has a seal. Without one, only the length and the heaps are known to be right.

    Raises
    ------
    InvalidInput
        For what is no NetCDF-4 file or a damaged one.
    """
    end, length = _end(file), file.seek(0, 2)
    if length < end:
        raise InvalidInput(f"it is truncated or damaged: it has {length} bytes; expected {end}")
    digest, heaps, before = hashlib.sha256(), [], b""
    for place, block in enumerate(_blocks(file, end)):
        digest.update(block)
        text = before + block
        found = text.find(_HEAP)
        while found >= 0:
            heaps.append(place * _BLOCK - len(before) + found)
            found = text.find(_HEAP, found + 1)
        before = text[1 - len(_HEAP) :]
    line = _line(end, digest.hexdigest())
    # One byte more than the line, to tell a longer rest.
    if length > end and file.read(len(line) + 1) != line:
        raise InvalidInput("it is truncated or damaged: the checksum at its end does not fit what stands before it")
    _check_heaps(file, heaps, end)
    return length > end


def _end(file: IO[bytes]) -> int:
    """Where the part of a file ends that HDF5 reads."""
    file.seek(0)
    begin = file.read(64)
    if not begin:
        raise InvalidInput("it is empty")
    if begin.startswith((b"FULLBODY", b"fullbody simulation")):
        raise InvalidInput("it is a simulation; fullbody.Simulation.load reads it")
    if begin.startswith(b"CDF"):
        raise InvalidInput("it is NetCDF of the classic kind; runs are NetCDF-4")
    if not begin.startswith(_SIGNATURE):
        raise InvalidInput("it is not a NetCDF file")
    version = begin[8] if len(begin) == 64 else -1
    width, place = _SUPERBLOCKS.get(version, (0, 16))
    # Two addresses before it stands where the file begins for HDF5.
    if begin[width] != 8 or any(begin[place - 16 : place - 8]):
        raise InvalidInput("it is truncated or damaged in its first bytes")
    return int.from_bytes(begin[place : place + 8], "little")


def _check_heaps(file: IO[bytes], heaps: list[int], end: int) -> None:
    """Refuse global heaps whose objects do not follow one another to the end: HDF5 would go round in them for ever."""
    room = end
    for heap in heaps:
        size = _length(file, heap)
        # Heaps lie beside each other, so that this takes no longer for a file that is made to have many.
        room -= size
        place, last = heap + _HEADER, heap + size
        sound = size >= _HEADER and last <= end and room >= 0
        while sound and last - place >= _HEADER:
            # The free space is an object of the number zero, whose length counts its header; other objects are filled
            # up to multiples of eight.
            free = _number(file, place, 2) == 0
            step = _length(file, place) if free else _HEADER + -(-_length(file, place) // 8) * 8
            place += step
            sound = step >= _HEADER and place <= last
        if not sound:
            raise InvalidInput(f"it is truncated or damaged: expected a whole global heap at byte {heap}")


def _length(file: IO[bytes], header: int) -> int:
    """The length in the header of a heap or of an object in it."""
    return _number(file, header + 8, 8)


def _number(file: IO[bytes], place: int, size: int) -> int:
    file.seek(place)
    return int.from_bytes(file.read(size), "little")


def _line(length: int, digest: str) -> bytes:
    return f"\nfullbody: sha256 of the {length} bytes before this line: {digest}\n".encode()


def _blocks(file: IO[bytes], length: int) -> Iterator[bytes]:
    """The first bytes of a file, a block at a time."""
    file.seek(0)
    for place in range(0, length, _BLOCK):
        yield file.read(min(_BLOCK, length - place))
