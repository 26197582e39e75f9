"""SPICE: runs as kernels that mission tools read, and states from such kernels.

:meth:`fullbody.Run.to_spk` writes where the bodies are, :meth:`fullbody.Run.to_ck` how they are turned, and
:func:`state` reads both, from kernels of any source. Kernels are in km, seconds of TDB past J2000 and axes of the ICRF,
which SPICE calls J2000: the system has to have units, an epoch and a frame. The extra ``spice`` has what this needs.
"""

from .state import state

__all__ = ["state"]


def __dir__() -> list[str]:
    return __all__
