"""The file of a scan of periods, from which an interrupted scan continues."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..base.atomic import as_path, content, replacing
from ..errors import InvalidInput
from ..typing import Floats

#: The seconds between two files.
_SAVED = 5.0


class PeriodStore:
    """The minima that a scan has found, and the file that keeps them, if there is a path.

    The array ``minima`` (N, n, 4) has chi2, period, longitude and latitude near each of N periods and n poles, and NaN
    where they are not known yet. The ``numbers`` are all on which the scan depends: another scan does not continue it.
    """

    def __init__(self, path: Any, numbers: Iterable[Floats], shape: tuple[int, ...]) -> None:
        self._path: Path | None = None if path is None else as_path(path, "store")
        digest = hashlib.sha256()
        for array in numbers:
            digest.update(np.ascontiguousarray(array).tobytes())
        self._key, self._saved = digest.hexdigest(), time.monotonic()
        self.minima = np.full(shape, np.nan)
        if self._path is not None and self._path.exists():
            self.minima = self._read(self._path)

    def _read(self, path: Path) -> Floats:
        try:
            with np.load(BytesIO(content(path)), allow_pickle=False) as file:
                key, minima = str(file["key"]), file["minima"]
        except (ValueError, KeyError, OSError, EOFError) as error:
            raise InvalidInput(f"{path} is no store of a scan of periods; expected one, or a new name") from error
        if key != self._key or minima.shape != self.minima.shape:
            raise InvalidInput(
                f"{path} is the store of a scan of other data or with other arguments; expected a new name"
            )
        return np.asarray(minima, dtype=np.float64)

    def take(self, pole: int, column: Floats) -> None:
        """Keep the minima (N, 4) near a pole."""
        self.minima[:, pole] = column
        if time.monotonic() - self._saved > _SAVED:
            self.save()

    def save(self) -> None:
        """Write the file, if there is one."""
        if self._path is not None:
            with replacing(self._path) as temporary, temporary.open("wb") as file:
                np.savez(file, key=np.array(self._key), minima=self.minima)
        self._saved = time.monotonic()

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Write the file at the end, also that of an interrupt."""
        try:
            yield
        finally:
            self.save()
