"""Ready-made systems, each with its source.

Each function returns ``(system, state)``. Options of :class:`fullbody.System` (``gravity=``, ``order=``, ...) are
passed on; ``epoch=`` is accepted if the published numbers have no epoch of their own. :func:`published` returns the
published numbers of a system with their uncertainties and sources, the further assumptions, and the names of numbers
that could not be read in the source itself.

Each system is a file of TOML, as :func:`fullbody.read_toml` reads, in the folder of this module: functions, signatures
and documentation follow from the files.

=========================== ===========================================================================================
:func:`kw4`                 1999 KW4 (66391), Moshup and Squannit: equivalent ellipsoids or the radar shapes
:func:`kw4_ho2021`          the same as Ho et al. (2021) start it
:func:`case1`               their case 1, two spheroids that begin to tumble, dimensionless
:func:`case2`               their case 2, two spheroids that spin like tops, dimensionless
:func:`didymos`             Didymos (65803) and Dimorphos before the impact of DART
:func:`didymos_after_dart`  the same after the impact and the weeks that followed
:func:`dinkinesh`           Dinkinesh (152830) and Selam, a satellite of two lobes
:func:`fg3_1996`            1996 FG3 (175706), with axis ratios to choose
:func:`dp107_2000`          2000 DP107 (185851), with axis ratios to choose
:func:`vh_1991`             1991 VH (35107), whose satellite is not synchronous
:func:`patroclus_menoetius` Patroclus (617) and Menoetius, a Trojan pair of almost equal bodies
:func:`antiope`             Antiope (90), a main-belt pair of almost equal bodies a diameter apart
:func:`kalliope_linus`      Kalliope (22) and its distant satellite Linus
:func:`pluto_charon`        Pluto (134340) and Charon, doubly synchronous spheres
:func:`eris_dysnomia`       Eris (136199) and Dysnomia, spheres
:func:`haumea`              Haumea (136108), an ellipsoid of three axes, with Namaka and Hi'iaka
:func:`lempo`               Lempo (47171), Hiisi and Paha, a triple beyond Neptune
:func:`sn263_2001`          2001 SN263 (153591), three ellipsoids with axis ratios to choose
=========================== ===========================================================================================

Examples
--------
>>> import fullbody
>>> print(fullbody.systems.published("sn263_2001").values["diameter of Beta"])
0.77 +- 0.12 km
>>> fullbody.systems.published("sn263_2001").epoch
'2008-02-13T00:00:00 TT'
"""

from typing import TYPE_CHECKING

from ._files import names
from ._functions import Ready, function
from ._published import Published, Value, published

if TYPE_CHECKING:
    antiope: Ready
    case1: Ready
    case2: Ready
    didymos: Ready
    didymos_after_dart: Ready
    dinkinesh: Ready
    dp107_2000: Ready
    eris_dysnomia: Ready
    fg3_1996: Ready
    haumea: Ready
    kalliope_linus: Ready
    kw4: Ready
    kw4_ho2021: Ready
    lempo: Ready
    patroclus_menoetius: Ready
    pluto_charon: Ready
    sn263_2001: Ready
    vh_1991: Ready

__all__ = ["Published", "Value", "published"]
__all__ += names()


def __getattr__(name: str) -> Ready:
    """Make the function of a system when it is first used, since each is read from a file."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = ready = function(name)
    return ready


def __dir__() -> list[str]:
    return __all__
