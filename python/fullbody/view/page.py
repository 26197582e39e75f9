"""An interactive picture of a run in 3D: one self-contained page with WebGL, without server or network."""

from __future__ import annotations

import html
import json
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.atomic import check_suffix, replacing
from ..plots._style import names_of
from ..record.record import Record
from .scene import scene_data

if TYPE_CHECKING:
    from ..observing.geometry import Geometry
    from ..particles.flight import Flight


def view(run: Record, *, flight: Flight | None = None, samples: int = 20000, geometry: Geometry | None = None) -> View:
    """Return an interactive picture in 3D for Jupyter or as one HTML file, without server or network.

    Parameters
    ----------
    run : Run
        A run with samples.
    flight : Flight, optional
        A flight whose particles are shown as dots with their trails; at most 2000 of them, evenly selected, are
        shown. Trails follow the path between samples of the flight, end where a particle lies on a body, and can be
        switched off.
    samples : int
        The largest number of times of the run that are shown: its samples and times between them, or times at equal
        steps if it has more samples.
    geometry : fullbody.observing.Geometry, optional
        The geometry whose Sun lights the bodies, with their shadows on each other. A polyhedron casts the shadow of an
        ellipsoid.

    Returns
    -------
    fullbody.view.View
        The picture, which Jupyter shows; ``.save_html(path)`` writes the page. At speed 1 the whole run takes 30
        seconds.

    Warns
    -----
    UserWarning
        If a body rotates by more than half a turn between two of these times, or between two samples of a run without
        ``dense=True``.
    """
    return View(run, flight=flight, samples=samples, geometry=geometry)


class View:
    """An interactive picture of a run; the arguments are those of :meth:`fullbody.Run.view` and the height in pixels.

    Drag the mouse to turn, use the wheel to zoom, and keys or buttons to play; the camera follows the barycentre or a
    body.

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
        self._data = scene_data(run, flight=flight, samples=samples, geometry=geometry)
        self._height, self._title = height, names_of(run)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, View):
            return NotImplemented
        return self._data == other._data and self._height == other._height

    __hash__ = None  # type: ignore[assignment]

    def to_html(self) -> str:
        """Return the page as text."""
        page, script, style = (
            resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
            for name in ("page.html", "viewer.js", "viewer.css")
        )
        # A body's name may contain "</", which would end the script element.
        data = json.dumps(self._data).replace("</", "<\\/").replace("<!--", "<\\!--")
        # Placeholders are filled in their order on the page, so that no body's name can be taken for one.
        pieces: list[str] = []
        placeholders = {"@TITLE@": html.escape(self._title), "@STYLE@": style, "@SCRIPT@": script, "@DATA@": data}
        for placeholder, text in placeholders.items():
            head, _, page = page.partition(placeholder)
            pieces += [head, text]
        return "".join([*pieces, page])

    def save_html(self, path: Any) -> Path:
        """Write the page as one file that needs no network.

        Parameters
        ----------
        path : str or Path
            A name that ends in ``.html`` or ``.htm``.

        Raises
        ------
        InvalidInput
            If the name has another suffix.
        """
        check_suffix(path, (".html", ".htm"))
        with replacing(path) as temporary:
            temporary.write_text(self.to_html(), encoding="utf-8")
        return Path(path)

    def framed(self) -> str:
        """Return the page in a frame, as Jupyter shows it."""
        page = html.escape(self.to_html(), quote=True)
        # A notebook that is not trusted shows only the text; in a trusted one the picture covers it.
        return (
            '<div style="height:1.6em;line-height:1.6em">Interactive view: run this cell, or trust the notebook.</div>'
            f'<iframe srcdoc="{page}" sandbox="allow-scripts" title="{html.escape(self._title)}" '
            'style="position:relative;display:block;margin-top:-1.6em;box-sizing:border-box;'
            f'width:100%;height:{self._height}px;border:1px solid #ccc;background:#fff"></iframe>'
        )

    _repr_html_ = framed

    def __repr__(self) -> str:
        count = len(self._data["time"]) * 3 // 32
        return f"<view of {self._title}, {count} times; shown in Jupyter, or .save_html(path)>"
