"""An interactive picture of a run in 3D: one self-contained page with WebGL, without server or network."""

from __future__ import annotations

import base64
import html
import json
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import check_suffix, replacing
from ..base.kinds import whole
from ..plots._style import check_samples, joined, surfaces, unit
from ..plots.between import at, track, trails
from ..plots.sampling import warn_if_aliased
from ..plots.sunlight import casts, directions
from ..record.record import Record

if TYPE_CHECKING:
    from ..observing.geometry import Geometry
    from ..particles.flight import Flight

__all__ = ["View", "view"]

#: The largest number of particles that are shown, and of their positions in all, which make a page of 12 megabytes.
_PARTICLES, _NUMBERS = 2000, 750_000


def view(run: Record, *, flight: Flight | None = None, samples: int = 20000, geometry: Geometry | None = None) -> View:
    """Return an interactive picture in 3D for Jupyter or as one HTML file, without server or network.

    Parameters
    ----------
    flight : Flight, optional
        A flight whose particles are shown as dots with their trails; at most 2000 of them, evenly selected, are
        shown. Trails follow the path between samples of the flight, end where a particle lies on a body, and can be
        switched off.
    samples : int
        The largest number of times of the run that are shown: its samples and times between them, or times at equal
        steps if it has more samples.
    geometry : fullbody.observing.Geometry, optional
        Lights the bodies by its Sun, with their shadows on each other. A polyhedron casts the shadow of an
        ellipsoid.

    Returns
    -------
    fullbody.view.View
        The picture, which Jupyter shows; ``.save_html(path)`` writes the page. At speed 1 the whole run takes 30
        seconds.

    Warns
    -----
    UserWarning
        If a body makes more than half a turn between two of these times, or between two samples of a run without
        ``dense=True``.
    """
    return View(run, flight=flight, samples=samples, geometry=geometry)


class View:
    """An interactive picture of a run; see :meth:`fullbody.Run.view`.

    Drag the mouse to turn, use the wheel to zoom, and keys or buttons to play; the camera follows the barycentre or a
    body.

    Parameters
    ----------
    run : Run
    flight : Flight, optional
        A flight whose particles are shown as dots with their trails.
    samples : int
        The largest number of times of the run that are shown.
    height : int
        The height of the frame in Jupyter, in pixels.
    geometry : fullbody.observing.Geometry, optional
        The geometry whose Sun lights the bodies.

    Raises
    ------
    InvalidInput
        For a run without samples, and for a flight of another system or with fewer than two samples.
    """

    def __init__(
        self,
        run: Record,
        *,
        flight: Flight | None = None,
        samples: int = 20000,
        height: int = 480,
        geometry: Geometry | None = None,
    ) -> None:
        check_samples(run)
        whole(samples, "samples", 2)
        sample_times = run.arrays["time"]
        few = len(run) <= samples
        times = (
            track(run, float(sample_times[-1]), min(samples, 1000))
            if few
            else np.linspace(sample_times[0], sample_times[-1], samples)
        )
        warn_if_aliased(run, times)
        centres, attitudes = at(run, times)
        self._height = height
        self._title = joined(run)
        self._data = {
            "names": list(run.context.names),
            "surfaces": [
                [
                    {"columns": s.columns.T.ravel().tolist(), "position": s.position.tolist()}
                    | ({} if s.triangles is None else {"triangles": _pack(s.triangles, "<f4")})
                    for s in surfaces(run, k)
                ]
                for k in range(len(run.context))
            ],
            "length": unit(run, "length"),
            "unit": unit(run, "time"),
            "time": _pack(times, "<f8"),
            "position": _pack(centres, "<f4"),
            "attitude": _pack(attitudes, "<f4"),
        }
        if geometry is not None:
            self._data["sun"] = _pack(directions(run, geometry, times), "<f4")
            # WebGL takes matrices by columns.
            self._data["casts"] = [
                [{"inverse": inverse.T.ravel().tolist(), "position": mark.tolist()} for inverse, mark in casts(run, k)]
                for k in range(len(run.context))
            ]
        if flight is not None:
            drawn = trails(run, flight, _PARTICLES, _NUMBERS)
            self._data["particles"] = {
                "count": drawn.position.shape[0],
                "time": _pack(drawn.time, "<f8"),
                "position": _pack(drawn.position, "<f4"),
                "landed": _pack(drawn.landed, "<f8"),
                "parts": drawn.parts,
            }
        self._moments = len(times)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, View):
            return NotImplemented
        return self._data == other._data and self._height == other._height

    __hash__ = None  # type: ignore[assignment]

    def to_html(self) -> str:
        """Return the page as text."""
        page = resources.files(__package__).joinpath("page.html").read_text(encoding="utf-8")
        script = resources.files(__package__).joinpath("viewer.js").read_text(encoding="utf-8")
        # A body's name may contain "</", which would end the script element.
        data = json.dumps(self._data).replace("</", "<\\/").replace("<!--", "<\\!--")
        # The page is filled piece by piece in its order, so that no body's name can be taken for a placeholder.
        pieces: list[str] = []
        for mark, text in (("@TITLE@", html.escape(self._title)), ("@SCRIPT@", script), ("@DATA@", data)):
            head, _, page = page.partition(mark)
            pieces += [head, text]
        return "".join([*pieces, page])

    def save_html(self, path: Any) -> Path:
        """Write the page as one file that needs no network.

        Parameters
        ----------
        path : str or Path
            A name that ends in ``.html`` or ``.htm``.

        Returns
        -------
        Path
            The path of the file.

        Raises
        ------
        InvalidInput
            If the name ends differently.
        """
        check_suffix(path, (".html", ".htm"))
        with replacing(path) as temporary:
            temporary.write_text(self.to_html(), encoding="utf-8")
        return Path(path)

    def _repr_html_(self) -> str:
        page = html.escape(self.to_html(), quote=True)
        # A notebook that is not trusted shows only the text; in a trusted one the picture covers it.
        return (
            '<div style="height:1.6em;line-height:1.6em">Interactive view: run this cell, or trust the notebook.</div>'
            f'<iframe srcdoc="{page}" sandbox="allow-scripts" title="{html.escape(self._title)}" '
            'style="position:relative;display:block;margin-top:-1.6em;box-sizing:border-box;'
            f'width:100%;height:{self._height}px;border:1px solid #ccc;background:#fff"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<view of {self._title}, {self._moments} moments; shown in Jupyter, or .save_html(path)>"


def _pack(values: Any, kind: str) -> str:
    """Return numbers as little-endian bytes in base64."""
    return base64.b64encode(np.ascontiguousarray(values).astype(kind).tobytes()).decode("ascii")
