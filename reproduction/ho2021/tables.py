"""The report's tables beside that of the verdicts, as text."""

from __future__ import annotations

from collections.abc import Sequence

from ..publishing import formatted
from . import paper, spin
from .kw4 import SHAPES
from .results import Results

__all__ = ["tables"]

#: The header and the rows of a table.
_Table = tuple[list[str], list[list[str]]]

_AXES = ("x [1e-5 rad/s]", "y", "z")
_ORBIT = (
    ("e_max", "largest eccentricity", 4),
    ("a_min", "smallest semi-major axis, km", 4),
    ("a_max", "largest, km", 4),
    ("a_mean", "mean, km", 4),
    ("period", "mean period, h", 4),
    ("inclination_period", "between maxima of the inclination, h", 0),
)


def tables(r: Results) -> dict[str, _Table]:
    """Return all tables, by name."""
    builders = (_years, _variants, _readings, _families, _physical)
    return {table.__name__.lstrip("_"): table(r) for table in builders}


def _fixed(value: float, digits: int) -> str:
    return formatted(value, f".{digits}f")


def _range(ends: Sequence[float], digits: int) -> str:
    low, high = (_fixed(end, digits) for end in ends)
    return "-" if low == "-" else f"[{low}, {high}]"


def _years(r: Results) -> _Table:
    runs = ("surface", "other_g", "printed_axes")
    head = [
        "",
        *(
            f"{shape}s: {text}"
            for shape in SHAPES
            for text in ("printed", "run", "with G = 6.674e-11", "with Table 2's axes")
        ),
    ]
    rows = []
    for name, text, digits in _ORBIT:
        cells = [text]
        for shape in SHAPES:
            cells.append(_fixed(getattr(paper.YEAR[shape], name), digits))
            cells += [_fixed(getattr(r.year[run][shape], name), digits) for run in runs]
        rows.append(cells)
    spins = ["Beta's spin z in 200 h, 1e-5 rad/s"]
    for shape in SHAPES:
        spins.append(_range(paper.SPIN["z"], 2) if shape == "ellipsoid" else "constant")
        spins += [_range(r.year[run][shape].spin_z, 2) for run in runs]
    return head, [*rows, spins]


def _variants(r: Results) -> _Table:
    head = ["gravity", "integrator", "attitudes", *_AXES, "between maxima of the inclination [h]"]
    rows = [
        [
            variant.gravity,
            variant.integrator,
            variant.chart,
            *(_range(ends, 4) for ends in variant.ranges),
            _fixed(variant.inclination_period, 0),
        ]
        for variant in r.variants
    ]
    return head, rows


def _readings(r: Results) -> _Table:
    head = ["start", *_AXES, "largest difference", "mean semi-major axis of the year [km]", "largest eccentricity"]
    year = paper.YEAR["ellipsoid"]
    rows = [["printed", *(_range(ends, 2) for ends in spin.PRINTED), "", f"{year.a_mean:.4f}", f"{year.e_max:.4f}"]]
    for reading in r.readings:
        ranges = [_range(ends, 3) for ends in reading.ranges]
        rows.append([reading.name, *ranges, f"{reading.misfit:.4f}", f"{reading.a_mean:.4f}", f"{reading.e_max:.4f}"])
    return head, rows


def _families(r: Results) -> _Table:
    head = [
        "family of starts",
        "stated",
        "nearest",
        "largest difference [1e-5 rad/s]",
        f"all six within {spin.NEAR:g}e-5",
    ]
    rows = []
    for scan in r.scans:
        digits = 1 if scan.unit == "deg" else 3
        ends = (
            " to ".join(_fixed(end, digits + 1) for end in scan.near_range)
            if scan.near_range[0] == scan.near_range[0]
            else "nowhere"
        )
        value, misfit = scan.best
        rows.append(
            [scan.name, f"{scan.stated:g} {scan.unit}", f"{value:.{digits}f} {scan.unit}", f"{misfit:.4f}", ends]
        )
    return head, rows


def _physical(r: Results) -> _Table:
    head = ["state", "starts from", "e", "libration [deg]", *_AXES]
    rows = [
        [
            name,
            m.start,
            f"{m.e[0]:.4f} to {m.e[1]:.4f}",
            "none: circulates" if m.libration != m.libration else f"{m.libration:.1f}",
            *(_range(ends, 2) for ends in m.spin),
        ]
        for name, m in r.physical.items()
    ]
    return head, rows
