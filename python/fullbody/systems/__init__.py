"""Ready-made systems, each with its source.

Each function gives ``(system, state)``. Options of :class:`fullbody.System` (``gravity=``, ``order=``, ...) are passed
on. :func:`published` gives the numbers behind a system with their uncertainties and sources.
"""

from ._published import Published, Value, published
from .antiope import antiope
from .didymos import didymos, didymos_after_dart
from .fg3 import fg3_1996
from .ho2021 import case1, case2, kw4, kw4_ho2021
from .patroclus import patroclus_menoetius
from .pluto import pluto_charon
from .sn263 import sn263_2001

__all__ = [
    "Published",
    "Value",
    "antiope",
    "case1",
    "case2",
    "didymos",
    "didymos_after_dart",
    "fg3_1996",
    "kw4",
    "kw4_ho2021",
    "patroclus_menoetius",
    "pluto_charon",
    "published",
    "sn263_2001",
]


def __dir__() -> list[str]:
    """The functions and not the files they are in."""
    return sorted(__all__)
