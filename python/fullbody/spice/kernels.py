"""Runs as kernels: positions as an SPK, and attitudes as a CK with its clock and its frames.

The SPK is of type 13, Hermite interpolation between uneven times, and the CK is of type 5, the same for quaternions. A
CK of type 3 has a constant angular velocity between two nodes. For an error of 1e-12 rad it would need several nodes a
second for a tumbling body.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..base import rotations
from ..base.atomic import as_path, check_suffix, replacing
from ..base.version import version
from ..errors import FullbodyError, InvalidInput, PrecisionWarning, caution
from ..record.record import Record
from ..typing import Floats
from .state import Conventions, body_numbers, message_of, number, spiceypy

#: The tolerances of the interpolation between the nodes, km and rad.
_POSITION_TOLERANCE, _ANGLE_TOLERANCE = 1e-9, 1e-12
#: Ticks per second: a power of two, so that seconds past J2000 become ticks without rounding.
_TICKS = 1024
#: The number of seconds to which the clock of a CK counts.
_CLOCK_RANGE = 2**32
#: The maximum length of a frame's name: a variable of a kernel has 32 characters, of which ``FRAME_`` takes six.
_MAX_NAME_LENGTH = 26
#: A function from samples of a run to values (K, N, C) in SPICE's units and their rates per second.
Curve = Callable[[dict[str, Floats]], tuple[Floats, Floats]]
#: The number of nodes of which a polynomial fits value and rate: its degree is 11, which all versions of SPICE read.
_WINDOW = 6
#: The maximum number of doublings of the nodes, from one node for two steps of the run.
_MAX_DOUBLINGS = 8
#: The number of points at which the interpolation error is evaluated at once, to limit the memory.
_CHUNK = 4096


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
        The path of the file.

    Raises
    ------
    InvalidInput
        If the system has no units, epoch or frame, if a number is not valid, and if the run has no duration.

    Warns
    -----
    PrecisionWarning
        If the error of interpolated positions is larger than 1e-9 km; the message gives it.

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
    ...     state_vector, light_time = spiceypy.spkgeo(120065803, after_an_hour, "ECLIPJ2000", 920065803)
    ...     spiceypy.unload(path)
    >>> float(abs(state_vector[:3] - (run(1.0).position[1] - run(1.0).position[0]).value).max()) < 1e-6
    True
    """
    check_suffix(path, (".bsp",))
    conventions = Conventions(run.system, "an SPK kernel")
    bodies, centre = body_numbers(ids, run.context.names), number(barycentre, "barycentre")
    if centre in bodies.values():
        raise InvalidInput(f"barycentre is {centre}, the id of a body; expected the number of the system as a whole")
    curve = position_curve(conventions, run.context.masses)
    result = nodes(run, conventions, curve, _POSITION_TOLERANCE, "{:.1e} km".format)
    spice = spiceypy()
    first, last = float(result.et[0]), float(result.et[-1])
    with new_kernel(path, "spkopn", run) as handle:
        for k, body in bodies.items():
            states = np.hstack([result.values[:, k], result.rates[:, k]])
            # The name of a segment has at most forty ASCII characters.
            segment = (first, last, run.context.names[k].encode("ascii", "replace").decode()[:40], result.degree)
            spice.spkw13(handle, body, centre, "J2000", *segment, len(states), states, result.et)
    return as_path(path)


def to_ck(run: Record, path: Any, ids: dict[str, int]) -> tuple[Path, Path, Path]:
    """Write the attitudes of the bodies as a CK kernel of SPICE, with its clock and frames.

    The requirements for the system are those of :meth:`to_spk`. The three files belong together. The CK gives
    frames along the bodies' principal axes, such as ``ALPHA_FIXED`` for Alpha, relative to the axes of the ICRF
    (SPICE's J2000). Segments are of type 5. For a run with ``dense=True`` the nodes are so close that interpolated
    angles are accurate to 1e-12 rad, or to the angle by which the body rotates in the last digit of the run's time.
    Otherwise the nodes are the samples. A body's frame has the body's number with the opposite sign, or a thousand
    times a negative number.

    Parameters
    ----------
    path : str or Path
        A name that ends in ``.bc``; the name of the clock's kernel ends in ``.tsc`` and that of the frames' in
        ``.tf``.
    ids : dict of int
        NAIF's numbers of the bodies to write, by name.

    Returns
    -------
    tuple of Path
        The paths of the three files: CK, clock and frames.

    Raises
    ------
    InvalidInput
        For the same reasons as :meth:`to_spk`, and for names of bodies from which no valid names of frames follow.

    Warns
    -----
    PrecisionWarning
        If the error of interpolated angles is larger than that; the message gives it.

    Examples
    --------
    >>> import fullbody, spiceypy, tempfile
    >>> system, state = fullbody.systems.didymos(units=True, frame="equatorial")
    >>> system = system.with_options(epoch="2022-09-26T12:00:00 TDB")
    >>> run = system.integrate(state, 12.0, dense=True)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     paths = [str(path) for path in run.to_ck(f"{folder}/didymos.bc", {"Dimorphos": 120065803})]
    ...     spiceypy.furnsh(paths)
    ...     matrix = spiceypy.pxform("DIMORPHOS_FIXED", "J2000", 8304 * 86400.0 + 3600.0)
    ...     spiceypy.unload(paths)
    >>> float(abs(matrix - run(1.0).rotation_matrix[1]).max()) < 1e-12
    True
    """
    check_suffix(path, (".bc",))
    conventions = Conventions(run.system, "a CK kernel")
    bodies = body_numbers(ids, run.context.names)
    frames = _frame_names(bodies, run.context.names)
    # A quaternion changes by half the angle.
    result = nodes(
        run, conventions, attitude_curve(conventions), 0.5 * _ANGLE_TOLERANCE, lambda change: f"{2.0 * change:.1e} rad"
    )
    spice = spiceypy()
    clock = -abs(next(iter(bodies.values())))
    # The clock starts at an integer, which text kernels hold exactly.
    zero = math.floor(result.et[0])
    ticks = (result.et - zero) * _TICKS
    if ticks[-1] >= _CLOCK_RANGE * _TICKS:
        raise InvalidInput(f"the run covers {result.et[-1] - zero:.1e} s; SPICE's clock counts to {_CLOCK_RANGE:.1e} s")
    file = as_path(path)
    text = file.with_suffix(".tsc"), file.with_suffix(".tf")
    with replacing(text[0]) as first, replacing(text[1]) as second, new_kernel(file, "ckopn", run) as handle:
        first.write_text(_clock_kernel(clock, zero), encoding="ascii")
        second.write_text(_frame_kernel(bodies, frames, clock), encoding="ascii")
        for k, body in bodies.items():
            packets = np.hstack([result.values[:, k], result.rates[:, k]])
            segment = (result.degree, ticks[0], ticks[-1], _frame_number(body), "J2000", True, frames[k])
            spice.ckw05(handle, 0, *segment, ticks, packets, 1.0 / _TICKS, 1, ticks[:1])
    return file, *text


def _frame_number(body: int) -> int:
    """Return the number of a body's frame: minus the body's, or a thousand times that of a spacecraft (below zero)."""
    return -body if body > 0 else 1000 * body


def _frame_names(bodies: dict[int, int], names: tuple[str, ...]) -> dict[int, str]:
    """Return the names of the frames fixed to bodies, by the indices of the bodies."""
    result = {k: re.sub(r"[^A-Z0-9]+", "_", names[k].upper()).strip("_") + "_FIXED" for k in bodies}
    for k, name in result.items():
        if name == "_FIXED" or len(name) > _MAX_NAME_LENGTH or list(result.values()).count(name) > 1:
            raise InvalidInput(
                f"the name of {names[k]} gives {name!r} for its frame in SPICE; expected a unique one, of at most "
                f"{_MAX_NAME_LENGTH} characters: give the body another name"
            )
        if not abs(_frame_number(bodies[k])) < 2**31:
            raise InvalidInput(f"the id of {names[k]} is {bodies[k]}; expected one above {-(2**31) // 1000}")
    return result


def _clock_kernel(clock: int, zero: int) -> str:
    """Return the text of a clock kernel that counts ticks of TDB from ``zero``, in seconds of TDB past J2000."""
    return f"""KPL/SCLK

The clock of a CK kernel by fullbody {version()}: seconds of TDB and their {_TICKS}th parts from the run's first on.

\\begindata

SCLK_KERNEL_ID               = ( @2000-01-01 )
SCLK_DATA_TYPE_{-clock}      = ( 1 )
SCLK01_TIME_SYSTEM_{-clock}  = ( 1 )
SCLK01_N_FIELDS_{-clock}     = ( 2 )
SCLK01_MODULI_{-clock}       = ( {_CLOCK_RANGE} {_TICKS} )
SCLK01_OFFSETS_{-clock}      = ( 0 0 )
SCLK01_OUTPUT_DELIM_{-clock} = ( 1 )
SCLK_PARTITION_START_{-clock} = ( 0 )
SCLK_PARTITION_END_{-clock}  = ( {_CLOCK_RANGE * _TICKS} )
SCLK01_COEFFICIENTS_{-clock} = ( 0 {zero} 1 )

\\begintext
"""


def _frame_kernel(bodies: dict[int, int], frames: dict[int, str], clock: int) -> str:
    """Return the text of a frame kernel with the frames fixed to the bodies, along their principal axes."""
    parts = [f"KPL/FK\n\nFrames along the principal axes of bodies, by fullbody {version()}.\n\n\\begindata\n"]
    for k, body in bodies.items():
        name, code = frames[k], _frame_number(body)
        parts.append(
            f"""
FRAME_{name} = {code}
FRAME_{code}_NAME = '{name}'
FRAME_{code}_CLASS = 3
FRAME_{code}_CLASS_ID = {code}
FRAME_{code}_CENTER = {body}
CK_{code}_SCLK = {clock}
CK_{code}_SPK = {body}
OBJECT_{body}_FRAME = '{name}'
NAIF_BODY_NAME += ( '{name.removesuffix("_FIXED")}' )
NAIF_BODY_CODE += ( {body} )
"""
        )
    return "".join(parts) + "\n\\begintext\n"


@contextmanager
def new_kernel(path: Any, opener: str, run: Record) -> Iterator[int]:
    """Yield the handle of a new kernel that replaces ``path``, with comments on the run and the program."""
    spice = spiceypy()
    with replacing(path) as temporary:
        # SPICE creates its files itself.
        temporary.unlink()
        handle = None
        try:
            handle = getattr(spice, opener)(str(temporary), "fullbody", 0)
            lines = [f"Written by fullbody {version()}.", f"System: {run.system!r}", f"Integrator: {run.integrator!r}"]
            lines += [f"Epoch of the system: {run.system.options['epoch']}, its frame: {run.context.frame}"]
            # Comments in kernels have only ASCII characters.
            spice.dafac(handle, [line.encode("ascii", "backslashreplace").decode()[:1000] for line in lines])
            yield handle
        except spice.utils.exceptions.SpiceyError as error:
            raise FullbodyError(f"{path} cannot be written: {message_of(error)}") from error
        finally:
            if handle is not None:
                with suppress(spice.utils.exceptions.SpiceyError):
                    spice.dafcls(handle)


class Nodes(NamedTuple):
    """Nodes: times (K,) in seconds of TDB past J2000, values and rates (K, N, C), and the degree of the polynomials."""

    et: Floats
    values: Floats
    rates: Floats
    degree: int


def position_curve(conventions: Conventions, masses: Floats) -> Curve:
    """Return the function from samples to positions in km from the barycentre, and velocities in km/s, along J2000."""
    weights = masses / masses.sum()

    def from_barycentre(vectors: Floats) -> Floats:
        relative = vectors - np.einsum("n,knc->kc", weights, vectors)[:, None]
        return np.asarray(relative @ conventions.axes.T * conventions.km)

    return lambda samples: (
        from_barycentre(samples["position"]),
        from_barycentre(samples["velocity"]) / conventions.second,
    )


def attitude_curve(conventions: Conventions) -> Curve:
    """Return the function from samples to quaternions, J2000 to body frames, continuous in sign, and to their rates."""
    axes = rotations.quaternion(conventions.axes)

    def curve(samples: dict[str, Floats]) -> tuple[Floats, Floats]:
        q = rotations.products(axes, samples["attitude"])
        return rotations.inverse(q), rotations.inverse(rotations.rates(q, samples["spin"] / conventions.second))

    return curve


def nodes(
    run: Record, conventions: Conventions, curve: Curve, tolerance: float, error_text: Callable[[float], str]
) -> Nodes:
    """Return nodes for an interpolation error within the tolerance; for a run that is not dense, the samples.

    A warning gives a larger error.
    """
    if run.dense is None:
        et, values, rates = _sample_nodes(run, conventions, curve)
        result = Nodes(et, values, rates, _degree(len(et)))
        # The error is that of every other sample; for an even number the last one has no node after it.
        count = len(et) - 1 + len(et) % 2
        error = _error(et[:count], values[:count], rates[:count])
        reason = (
            "the run has no continuous solution, and every other sample follows from the others only to "
            f"within {error_text(error)}; integrate with dense=True, or with output= at a shorter spacing"
        )
    else:
        low, high = sorted(run.dense.core.range)
        first, last = conventions.et(low), conventions.et(high)
        # Seconds past J2000 are rounded, so the nodes are kept within the run.
        while conventions.time(first) < low:
            first = np.nextafter(first, np.inf)
        while conventions.time(last) > high:
            last = np.nextafter(last, -np.inf)
        if not first < last:
            raise InvalidInput(f"the run covers {last - first:.1g} s; a kernel needs a stretch of time")
        intervals = max(_WINDOW, run.statistics.steps // 2)
        for _ in range(_MAX_DOUBLINGS):
            et = np.linspace(first, last, 2 * intervals + 1)
            times = conventions.time(et)
            values, rates = curve(run.dense.core.states(times))
            error = _error(et, values, rates)
            # The rounding of the times limits the accuracy.
            rounding = 2.0 * np.spacing(np.abs(times).max()) * conventions.second * np.abs(rates).max()
            tolerance = max(tolerance, rounding)
            # The factor allows for larger errors elsewhere between the nodes.
            if error <= max(0.1 * tolerance, rounding):
                break
            intervals *= 2
        result = Nodes(et[::2].copy(), values[::2], rates[::2], _degree(intervals + 1))
        reason = (
            f"the kernel is off by {error_text(error)} between its nodes; the run's solution is not smooth enough for "
            "a smaller error"
        )
    if error > tolerance:
        caution(reason, PrecisionWarning)
    return result


def _degree(count: int) -> int:
    """Return the degree of the polynomials for a number of nodes."""
    return 2 * min(_WINDOW, count // 2 * 2) - 1


def _sample_nodes(run: Record, conventions: Conventions, curve: Curve) -> tuple[Floats, Floats, Floats]:
    """Return times in seconds past J2000, values and rates of the samples, forward in time."""
    record = run.arrays
    order = slice(None, None, -1 if len(run) > 1 and record["time"][-1] < record["time"][0] else 1)
    samples = {name: record[name][order] for name in ("time", "position", "velocity", "attitude", "spin")}
    et = conventions.et(samples["time"])
    if len(et) < 3 or np.diff(et).min() <= 0.0:
        raise InvalidInput(
            f"the run has {len(et)} samples; a kernel needs three or more, at least 2e-7 s apart, or dense=True"
        )
    values, rates = curve(samples)
    # Seconds past J2000 are rounded to 1e-7 s, in which a fast rotator rotates by more than the tolerance.
    rounding = ((et - conventions.epoch) - samples["time"] * conventions.second)[:, None, None]
    return et, values + rates * rounding, rates + np.gradient(rates, et, axis=0) * rounding


def _error(et: Floats, values: Floats, rates: Floats) -> float:
    """Return the largest distance between every other value and the interpolation of the rest."""
    distance = 0.0
    for start in range(1, len(et), 2 * _CHUNK):
        odd = slice(start, start + 2 * _CHUNK, 2)
        deviation = _hermite(et[::2], values[::2], rates[::2], et[odd]) - values[odd]
        distance = max(distance, float(np.linalg.norm(deviation, axis=-1).max()))
    return distance


def _hermite(et: Floats, values: Floats, rates: Floats, times: Floats) -> Any:
    """Evaluate the Hermite polynomials at times (M,), each through the nodes that SPICE would use there."""
    window = (_degree(len(et)) + 1) // 2 or 1
    first = np.clip(np.searchsorted(et, times) - window // 2, 0, len(et) - window)
    use = first[:, None] + np.arange(window)
    x = times[:, None] - et[use]
    between = et[use][:, :, None] - et[use][:, None, :] + np.eye(window)
    ratio = x[:, None, :] / between
    slope = (1.0 / between).sum(axis=2) - 1.0
    ratio[:, np.arange(window), np.arange(window)] = 1.0
    square = ratio.prod(axis=2) ** 2
    parts = ((1.0 - 2.0 * x * slope) * square, values[use]), (x * square, rates[use])
    return sum(np.einsum("mw,mwnc->mnc", *part) for part in parts)
