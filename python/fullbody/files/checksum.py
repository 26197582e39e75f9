"""The SHA-256 checksum of a NetCDF-4 file, in a line of text after the part that HDF5 reads.

The first bytes of an HDF5 file say where it ends for HDF5, and programs that read HDF5 or NetCDF ignore what follows.
The line there has the SHA-256 of all bytes before it. It is checked before HDF5, which trusts what it reads, opens the
file. Other programs cut the line off when they write into the file.
"""

from __future__ import annotations

import hashlib
from typing import IO

from ..errors import InvalidInput

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
#: The offsets of the size of addresses and of the end-of-file address in the superblock, by its version (HDF5 File
#: Format Specification, section II.A).
_SUPERBLOCKS = {0: (13, 40), 1: (13, 44), 2: (9, 28), 3: (9, 28)}
#: The number of bytes that are hashed at a time, which takes a few milliseconds.
_BLOCK = 2**22


def line(file: IO[bytes], length: int) -> bytes:
    """Return the checksum line for the first ``length`` bytes of a file."""
    digest = hashlib.sha256()
    file.seek(0)
    for offset in range(0, length, _BLOCK):
        digest.update(file.read(min(_BLOCK, length - offset)))
    return f"\nfullbody: sha256 of the {length} bytes before this line: {digest.hexdigest()}\n".encode()


def check(file: IO[bytes]) -> bool:
    """Return whether a file has a checksum, or raise an error if it is not NetCDF-4, or damaged."""
    end, length = _end(file), file.seek(0, 2)
    if length < end:
        raise InvalidInput(f"the file is truncated or damaged: it has {length} bytes; expected {end}")
    if length == end:
        return False
    expected = line(file, end)
    # One byte more than the line is read, to detect further bytes.
    if file.read(len(expected) + 1) != expected:
        damaged = "the checksum at its end does not fit what stands before it"
        raise InvalidInput(f"the file is truncated or damaged: {damaged}")
    return True


def _end(file: IO[bytes]) -> int:
    """Return the end of the part of a file that HDF5 reads, in bytes."""
    file.seek(0)
    begin = file.read(64)
    if not begin:
        raise InvalidInput("the file is empty")
    if begin.startswith(b"CDF"):
        raise InvalidInput("the file is NetCDF of the classic kind; runs are NetCDF-4")
    if not begin.startswith(_SIGNATURE):
        raise InvalidInput("the file is not a NetCDF file")
    version = begin[8] if len(begin) == 64 else -1
    width, offset = _SUPERBLOCKS.get(version, (0, 16))
    # The address where the file begins for HDF5 is stored two addresses before that of its end.
    if begin[width] != 8 or any(begin[offset - 16 : offset - 8]):
        raise InvalidInput("the file is truncated or damaged in its first bytes")
    return int.from_bytes(begin[offset : offset + 8], "little")
