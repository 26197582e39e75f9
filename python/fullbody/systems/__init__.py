"""Ready-made systems, each with its source.

Each function returns ``(system, state)``. Options of :class:`fullbody.System` (``gravity=``, ``order=``, ...) are
passed on; ``epoch=`` is accepted if the published numbers have no epoch of their own. :func:`published` returns the
published numbers of a system with their uncertainties and sources, the further assumptions, and the names of numbers
that could not be read in the source itself.

=========================== ===========================================================================================
:func:`kw4`                 (66391) 1999 KW4, prograde and synchronous
:func:`kw4_ho2021`          the same as Ho et al. (2021) start it
:func:`case1`               their case 1, two spheroids that begin to tumble, dimensionless
:func:`case2`               their case 2, two spheroids that spin like tops, dimensionless
:func:`didymos`             (65803) Didymos and Dimorphos before the impact of DART
:func:`didymos_after_dart`  the same after the impact and the weeks that followed
:func:`dinkinesh`           (152830) Dinkinesh and Selam, a satellite of two lobes
:func:`fg3_1996`            (175706) 1996 FG3, with axis ratios to choose
:func:`patroclus_menoetius` (617) Patroclus and Menoetius, a Trojan pair of almost equal bodies
:func:`antiope`             (90) Antiope, a main-belt pair of almost equal bodies a diameter apart
:func:`pluto_charon`        (134340) Pluto and Charon, doubly synchronous spheres
:func:`sn263_2001`          (153591) 2001 SN263, three ellipsoids with axis ratios to choose
=========================== ===========================================================================================

Examples
--------
>>> import fullbody
>>> print(fullbody.systems.published("sn263_2001").values["diameter of Beta"])
0.77 +- 0.12 km
>>> fullbody.systems.published("sn263_2001").epoch
'2008-02-13T00:00:00 TT'
"""

from ._published import Published, Value, published
from .antiope import antiope
from .didymos import didymos, didymos_after_dart
from .dinkinesh import dinkinesh
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
    "dinkinesh",
    "fg3_1996",
    "kw4",
    "kw4_ho2021",
    "patroclus_menoetius",
    "pluto_charon",
    "published",
    "sn263_2001",
]
