"""Conversion of a system's settings to the form that the core takes; the core checks their limits."""

from __future__ import annotations

from typing import Any

from ..base.arguments import integer
from ..base.units import numbers, scalar
from ..errors import InvalidInput

__all__ = ["core_settings"]


def core_settings(gravity: Any, gravity_tolerance: Any, order: Any, **texts: Any) -> dict[str, Any]:
    """Return the settings of a system as the core takes them; ``texts`` are those that are text."""
    for name, value in (("gravity", gravity), *texts.items()):
        if not isinstance(value, str):
            raise InvalidInput(f"{name} is {value!r}; expected text")
    settings = {"gravity": gravity, "order": None if order is None else _quadrature_order(order, gravity), **texts}
    return settings if gravity_tolerance is None else settings | {"gravity_tolerance": _tolerance(gravity_tolerance)}


def _tolerance(value: Any) -> float:
    """Return the tolerance as a number; the core checks its limits."""
    try:
        return scalar(numbers(value, "gravity_tolerance"), "gravity_tolerance")
    except InvalidInput as error:
        raise InvalidInput(f"gravity_tolerance is {value!r}; expected a number such as 1e-14") from error


def _quadrature_order(value: Any, gravity: str) -> tuple[int, int]:
    """Return the order as two integers, which are equal for the harmonic series; the core checks their limits."""
    if gravity == "harmonic" and (degree := integer(value)) is not None:
        value = (degree, degree)
    numbers = [integer(part) for part in value] if isinstance(value, tuple | list) else []
    match numbers:
        case [int(gauss), int(angles)] if 0 <= gauss < 2**31 and 0 <= angles < 2**31:
            return gauss, angles
    raise InvalidInput(
        f"order is {value!r}; expected (n, m), whole numbers: n Gauss points, m angles; or one degree for "
        "gravity='harmonic'"
    )
