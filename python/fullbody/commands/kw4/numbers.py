"""Results as plain numbers, and files of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..._files import replacing

__all__ = ["plain", "write_numbers"]


def plain(value: Any) -> Any:
    """Dictionaries, lists, numbers and text only; a number that does not exist is ``None``."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def write_numbers(path: Path, value: Any) -> None:
    """Write JSON that every reader takes, whole or not at all."""
    text = json.dumps(plain(value), indent=1, allow_nan=False) + "\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
