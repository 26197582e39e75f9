"""The report: one HTML page, the figures and the numbers."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fullbody import __version__
from fullbody.base.atomic import check_target, replacing
from fullbody.errors import InvalidInput
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from ..judging import counts
from ..publishing import write_numbers
from ..typesetting import typeset
from . import case_figures, evidence_figures, kw4_figures
from .captions import CAPTIONS
from .findings import TITLES, findings
from .judging import WORDS, Verdict
from .results import Results, as_numbers, compute
from .tables import tables
from .verdicts import judge

__all__ = ["Report", "write_report"]


@dataclass(frozen=True, slots=True)
class Report:
    """The files of a report, ``report.html`` with its figures, ``numbers.json`` and the figures, and its verdicts."""

    page: Path
    numbers: Path
    figures: tuple[Path, ...]
    verdicts: tuple[Verdict, ...]


def write_report(out: Any, *, draft: bool = False, progress: bool = False) -> Report:
    """Repeat all computations of the paper and write the report.

    Parameters
    ----------
    out : str or Path
        The folder, which is made if it does not exist. ``report.html`` needs no other file; ``figures/`` has the same
        figures as PNG and PDF, and ``numbers.json`` has every number, verdict and finding.
    draft : bool
        Whether to make coarser scans and shorter long runs; the page states this.
    progress : bool
        Whether to show a bar.

    Returns
    -------
    Report
    """
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InvalidInput(f"out is {str(out)!r}, a file; expected a folder")
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    # The numbers are written last, so that the other files exist when they do.
    numbers, page = folder / "numbers.json", folder / "report.html"
    numbers.unlink(missing_ok=True)
    check_target(page)
    results = compute(draft=draft, progress=progress)
    verdicts, paragraphs = judge(results), findings(results)
    all_figures = {
        **case_figures.all_figures(results.runs),
        **kw4_figures.all_figures(results.runs.year),
        **evidence_figures.all_figures(results),
    }
    written = []
    for name, figure in all_figures.items():
        # The layout is computed once for both kinds of file.
        if layout := figure.get_layout_engine():
            layout.execute(figure)
            figure.set_layout_engine("none")
        for suffix in (".png", ".pdf"):
            path = folder / "figures" / f"{name}{suffix}"
            with replacing(path) as temporary:
                figure.savefig(temporary, dpi=130)
            written.append(path)
    with replacing(page) as temporary:
        temporary.write_text(_render(results, verdicts, paragraphs, folder / "figures"), encoding="utf-8")
    texts = [{"name": name, "title": TITLES[name], "text": text} for name, text in paragraphs.items()]
    write_numbers(numbers, {**as_numbers(results), "figures": CAPTIONS, "findings": texts, "verdicts": verdicts})
    return Report(page, numbers, tuple(written), tuple(verdicts))


def _render(results: Results, verdicts: list[Verdict], paragraphs: dict[str, list[str]], figures: Path) -> str:
    """Return the page, with the figures from a folder inside it."""

    def picture(name: str) -> str:
        data = base64.b64encode((figures / f"{name}.png").read_bytes()).decode("ascii")
        return f"data:image/png;base64,{data}"

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = lambda text: Markup(typeset(str(text)))
    return environment.get_template("report.html").render(
        r=results,
        tables=tables(results),
        picture=picture,
        captions=CAPTIONS,
        titles=TITLES,
        findings=paragraphs,
        verdicts=verdicts,
        counts=counts(verdicts, WORDS),
        version=__version__,
    )
