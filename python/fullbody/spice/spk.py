"""Positions of the bodies as an SPK kernel of type 13, Hermite interpolation between uneven times."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..base.atomic import as_path, check_suffix
from ..errors import InvalidInput
from ..record.record import Record
from .conventions import Conventions, body_numbers, number, spiceypy
from .kernel import binary
from .nodes import centres, nodes

#: The tolerance of the interpolation between the nodes, km.
_TOLERANCE = 1e-9


def to_spk(run: Record, path: Any, ids: dict[str, int], barycentre: int) -> Path:
    """Write the positions of the bodies as an SPK kernel of SPICE, for systems with units, an epoch and a frame.

    Positions are relative to the barycentre of the bodies, in km along the axes of the ICRF (SPICE's J2000), and
    times are seconds of TDB. SPICE's ECLIPJ2000 is the frame ``"eclipj2000"`` here; ``"ecliptic"`` differs from it
    by 0.04 arc seconds (:mod:`fullbody.frames`). Segments are of type 13. For a run with ``dense=True`` the nodes
    are so close that interpolated positions are accurate to 1e-9 km. Otherwise the nodes are the samples.

    Parameters
    ----------
    path : str or Path
        A name that ends in ``.bsp``.
    ids : dict of int
        NAIF's numbers of the bodies to write, by name.
    barycentre : int
        NAIF's number of the system as a whole, relative to which the kernel gives the bodies.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InvalidInput
        If the system has no units, epoch or frame, if a number is not valid, and if the run covers no span of time.
    OSError
        If the file cannot be written.

    Warns
    -----
    PrecisionWarning
        If the error of interpolated positions is larger; the message gives it.

    See Also
    --------
    fullbody.spice.state

    Examples
    --------
    >>> import fullbody, spiceypy, tempfile
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> system = system.with_options(epoch="2022-09-26T12:00:00 TDB")
    >>> run = system.integrate(state, 12.0, dense=True)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ids = {"Didymos": 920065803, "Dimorphos": 120065803}
    ...     path = str(run.to_spk(f"{folder}/didymos.bsp", ids, barycentre=20065803))
    ...     spiceypy.furnsh(path)
    ...     after_an_hour = 8304 * 86400.0 + 3600.0
    ...     found, light_time = spiceypy.spkgeo(120065803, after_an_hour, "ECLIPJ2000", 920065803)
    ...     spiceypy.unload(path)
    >>> float(abs(found[:3] - (run(1.0).position[1] - run(1.0).position[0]).value).max()) < 1e-6
    True
    """
    check_suffix(path, (".bsp",))
    conventions = Conventions(run.system, "an SPK kernel")
    bodies, centre = body_numbers(ids, run.context.names), number(barycentre, "barycentre")
    if centre in bodies.values():
        raise InvalidInput(f"barycentre is {centre}, the id of a body; expected the number of the system as a whole")
    result = nodes(run, conventions, centres(conventions, run.context.masses), _TOLERANCE, "{:.1e} km".format)
    spice = spiceypy()
    first, last = float(result.et[0]), float(result.et[-1])
    with binary(path, "spkopn", run) as handle:
        for k, body in bodies.items():
            states = np.hstack([result.values[:, k], result.rates[:, k]])
            name = _segment(run.context.names[k])
            spice.spkw13(
                handle, body, centre, "J2000", first, last, name, result.degree, len(states), states, result.et
            )
    return as_path(path)


def _segment(name: str) -> str:
    """Return the name of a segment, which has at most forty characters of ASCII."""
    return name.encode("ascii", "replace").decode()[:40]
