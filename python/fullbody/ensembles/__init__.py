"""Many runs at once, maps over parameters, and measures for them.

<<<<<<< HEAD
A measure takes a :class:`fullbody.Run` and gives numbers by names, for the ``measure=`` of :func:`fullbody.sweep`.
Several are one by ``fate(run) | drift(run)``.
"""

from .many import integrate_many
=======
>>>>>>> sweep
from .measures import attitude, drift, fate, libration, orbit
from .parameters import Draws, Paired, draws, paired
from .sweep import sweep

__all__ = [
    "Draws",
    "Paired",
    "attitude",
    "draws",
    "drift",
    "fate",
<<<<<<< HEAD
    "integrate_many",
=======
>>>>>>> sweep
    "libration",
    "orbit",
    "paired",
    "sweep",
]


def __dir__() -> list[str]:
    return __all__
