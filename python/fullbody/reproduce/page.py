"""The report as one HTML page."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import TYPE_CHECKING

from .. import paper

if TYPE_CHECKING:
    from .report import Results

__all__ = ["render"]


def render(results: Results, figures: Path) -> str:
    """The page, with the figures from a folder inside it."""
    from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

    from .. import __version__
    from .report import counts

    def picture(name: str) -> str:
        data = base64.b64encode((figures / f"{name}.png").read_bytes()).decode("ascii")
        return f"data:image/png;base64,{data}"

    environment = Environment(
        loader=PackageLoader("fullbody.reproduce", "templates"),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["e"] = lambda value: f"{value:.1e}"
    return environment.get_template("report.html").render(
        r=results, paper=paper, picture=picture, counts=dict(counts(results.verdicts)), version=__version__
    )
