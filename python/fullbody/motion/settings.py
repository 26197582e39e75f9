"""Conversion of a system's settings to the form that the core takes; the core checks their limits."""

from __future__ import annotations

from typing import Any

from ..base.arguments import integer
from ..base.kinds import instance
from ..base.limits import Limits
from ..base.units import UNITLESS
from ..errors import InvalidInput


def core_settings(gravity: Any, gravity_tolerance: Any, order: Any, **texts: Any) -> dict[str, Any]:
    """Return the settings of a system as the core takes them; ``texts`` are those that are text."""
    for name, value in (("gravity", gravity), *texts.items()):
        instance(value, name, str, "text")
    settings = {"gravity": gravity, "order": None if order is None else _quadrature_order(order, gravity), **texts}
    if gravity_tolerance is not None:
        limits = Limits(infinite=True, text="a number such as 1e-14")
        settings["gravity_tolerance"] = UNITLESS.number(gravity_tolerance, "number", "gravity_tolerance", limits)
    return settings


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
