"""The data of a scene in 3D: surfaces, positions, attitudes, sunlight and particles of a run, as a dict for JSON."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.kinds import whole_number
from ..plots._style import check_samples, surfaces, unit
from ..plots.between import dense_times, poses, trails, warn_if_aliased
from ..plots.sunlight import directions, shadow_ellipsoids
from ..record.record import Record

if TYPE_CHECKING:
    from ..observing.geometry import Geometry
    from ..particles.flight import Flight

#: The largest numbers of particles that are shown, and of their positions together, which make a page of 12 megabytes.
_PARTICLES, _POSITIONS = 2000, 750_000


def pack(values: Any, kind: str) -> str:
    """Return numbers as little-endian bytes in base64."""
    return base64.b64encode(np.ascontiguousarray(values).astype(kind).tobytes()).decode("ascii")


def scene_data(run: Record, *, flight: Flight | None, samples: int, geometry: Geometry | None) -> dict[str, Any]:
    """Return the data that viewer.js loads; the arguments are those of :class:`fullbody.view.View`."""
    check_samples(run)
    whole_number(samples, "samples", 2)
    first, last = run.arrays["time"][[0, -1]]
    is_short = len(run) <= samples
    times = dense_times(run, float(last), min(samples, 1000)) if is_short else np.linspace(first, last, samples)
    warn_if_aliased(run, times)
    centres, attitudes = poses(run, times)
    data: dict[str, Any] = {
        "names": list(run.context.names),
        "surfaces": [
            [
                {"columns": s.columns.T.ravel().tolist(), "position": s.position.tolist()}
                | ({} if s.triangles is None else {"triangles": pack(s.triangles, "<f4")})
                for s in surfaces(run, k)
            ]
            for k in range(len(run.context))
        ],
        "length": unit(run, "length"),
        "unit": unit(run, "time"),
        "time": pack(times, "<f8"),
        "position": pack(centres, "<f4"),
        "attitude": pack(attitudes, "<f4"),
    }
    if geometry is not None:
        data |= {to: pack(directions(run, geometry, times, to), "<f4") for to in ("sun", "observer")}
        # WebGL takes matrices by columns.
        data["casts"] = [
            [
                {"inverse": inverse.T.ravel().tolist(), "position": centre.tolist()}
                for inverse, centre in shadow_ellipsoids(run, k)
            ]
            for k in range(len(run.context))
        ]
    if flight is not None:
        particles = trails(run, flight, _PARTICLES, _POSITIONS)
        data["particles"] = {
            "count": particles.position.shape[0],
            "time": pack(particles.time, "<f8"),
            "position": pack(particles.position, "<f4"),
            "landed": pack(particles.landed, "<f8"),
            "parts": particles.parts,
        }
    return data
