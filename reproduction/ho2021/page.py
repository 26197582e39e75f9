"""The report: one HTML page, the figures and the numbers."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from fullbody._files import replacing
from fullbody._units import need
from fullbody.commands.kw4 import printed
from fullbody.commands.kw4.numbers import write_numbers
from fullbody.errors import InvalidInput

from . import paper
from .captions import CAPTIONS
from .facts import facts
from .results import Results, as_numbers, compute, counts
from .starts import NODAL_HOURS
from .verdicts import Verdict

__all__ = ["Report", "render", "write_report"]


@dataclass(frozen=True, slots=True)
class Report:
    """What was written.

    Attributes
    ----------
    page : Path
        ``report.html``, with the figures in it.
    numbers : Path
        ``numbers.json``.
    figures : tuple of Path
        PNG and PDF.
    verdicts : tuple of Verdict
    """

    page: Path
    numbers: Path
    figures: tuple[Path, ...]
    verdicts: tuple[Verdict, ...]


def write_report(out: Any, *, draft: bool = False, progress: bool = False) -> Report:
    """Run everything that the paper shows and write a report beside its numbers.

    Parameters
    ----------
    out : str or Path
        Folder; made where there is none. ``report.html`` needs no other file; ``figures/`` holds the same figures as
        PNG and PDF, ``numbers.json`` every number.
    draft : bool
        Coarser scans and shorter long runs; the page says so.
    progress : bool
        Whether to show a bar.

    Returns
    -------
    Report

    Examples
    --------
    >>> from reproduction.ho2021 import write_report
    >>> report = write_report("out/reproduce")  # doctest: +SKIP
    >>> [verdict.quantity for verdict in report.verdicts if verdict.verdict == "differs"]  # doctest: +SKIP
    """
    from fullbody.commands.kw4 import figures as kw4_figures

    from . import case_figures, evidence_figures

    # What is missing is said before the work, not after it.
    for extra, module in (("report", "jinja2"), ("plot", "matplotlib"), ("analysis", "scipy"), ("units", "astropy")):
        with need(extra, "the report"):
            import_module(module)
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InvalidInput(f"out is {str(out)!r}, a file; expected a folder")
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    numbers, page = folder / "numbers.json", folder / "report.html"
    # Written last, so that whoever finds it finds the rest; and what cannot be written is known before the work.
    numbers.unlink(missing_ok=True)
    with replacing(folder / "figures" / "probe") as temporary:
        temporary.touch()
    (folder / "figures" / "probe").unlink()
    results = compute(draft=draft, progress=progress)
    drawn = {
        **case_figures.all_figures(results),
        **kw4_figures.all_figures(results.year_runs),
        **evidence_figures.all_figures(results),
    }
    written = []
    for name, figure in drawn.items():
        for suffix in (".png", ".pdf"):
            path = folder / "figures" / f"{name}{suffix}"
            with replacing(path) as temporary:
                figure.savefig(temporary, dpi=130)
            written.append(path)
    with replacing(page) as temporary:
        temporary.write_text(render(results, folder / "figures"), encoding="utf-8")
    write_numbers(numbers, as_numbers(results))
    return Report(page, numbers, tuple(written), tuple(results.verdicts))


def render(results: Results, figures: Path) -> str:
    """The page, with the figures from a folder inside it."""
    from fullbody import __version__
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

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
    environment.filters["e"] = lambda value: f"{value:.1e}"
    environment.filters["fixed"] = lambda value, digits: "-" if value != value else f"{value:.{digits}f}"
    template = environment.get_template("report.html")
    return template.render(
        r=results,
        paper=paper,
        printed=printed,
        picture=picture,
        captions=CAPTIONS,
        n=facts(results),
        hours=NODAL_HOURS,
        counts=dict(counts(results.verdicts)),
        version=__version__,
    )
