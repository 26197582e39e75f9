"""SPICE: runs as kernels that mission tools read, and states from such kernels.

:meth:`fullbody.Run.to_spk` writes positions of the bodies, :meth:`fullbody.Run.to_ck` their attitudes, and
:func:`state` reads both, from kernels of any source. Kernels are in km, seconds of TDB past J2000 and axes of the ICRF,
which SPICE calls J2000: the system needs units, an epoch and a frame. Install the dependencies with the extra
``spice``.
"""

from .state import state

__all__ = ["state"]
