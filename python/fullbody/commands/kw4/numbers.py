"""Results as plain numbers, and files of them."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...base.atomic import replacing

__all__ = ["as_json", "write_numbers"]


def as_json(value: Any) -> Any:
    """Return a value as dictionaries, lists, numbers and text only; a number that does not exist becomes ``None``."""
    if is_dataclass(value):
        return {field.name: as_json(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return as_json(value.tolist())
    if isinstance(value, list | tuple):
        return [as_json(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def write_numbers(path: Path, value: Any) -> None:
    """Write a file of JSON, without the NaN that some readers refuse; it is written completely or not at all."""
    text = json.dumps(as_json(value), indent=1, allow_nan=False) + "\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
