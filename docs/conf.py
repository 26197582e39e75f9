"""The documentation site: ``make docs``.

Every code cell of a MyST page is executed by the build; an error or a warning ends it. The notebooks are shown with
their stored outputs, which the tests check.
"""

from __future__ import annotations

import inspect
import os
import re
import shutil
import sys
import tomllib
from importlib import metadata
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.osutil import relative_uri

DOCS = Path(__file__).parent
ROOT = DOCS.parent
sys.path.insert(0, str(DOCS))
from gallery import Thumbnails  # noqa: E402
from names import expand, write_pages  # noqa: E402

from notebooks import quiet_kernels  # noqa: E402

project = "fullbody"
author = "The fullbody developers"
project_copyright = "the fullbody developers"
release = metadata.version("fullbody")

# The folders of the results of `make study` that have a page, by page; the pages read them there.
OUT = ROOT / "out"
STUDIES = dict.fromkeys(("report", "full_report"), OUT / "ho2021") | {
    name: OUT / name for name in ("binaries", "kalliope", "hertha", "kw4_radar")
}
EXPLORER = OUT / "explorer"
RUST = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "doc"
os.environ.update({f"FULLBODY_{page.upper()}": str(folder) for page, folder in STUDIES.items()})
os.environ["FULLBODY_PEERS"] = str(ROOT / "notebooks" / "10-peers.json")
# These pages also use the package `reproduction`, which is not installed.
os.environ["PYTHONPATH"] = str(ROOT)


def note_missing_results(app: Any, page: str, source: list[str]) -> None:
    """Replace the results of a study that has not run by a notice."""
    if page == "explorer" and not EXPLORER.is_dir():
        head = source[0].partition("\n<iframe")[0]
        source[0] = f"{head}\n:::{{note}}\nThis site was built without the page. `make explorer` builds it.\n:::\n"
    folder = STUDIES.get(page)
    if folder is None or (folder / "numbers.json").is_file():
        return
    notice = f":::{{note}}\nThis page was built without results. `make study S={folder.name}` writes them.\n:::\n"
    head = source[0].partition("\n<iframe" if page == "full_report" else "\n## ")[0]
    source[0] = f"{re.sub(r'<p>.*?</p>', '', head, flags=re.DOTALL)}\n{notice}"


def copy_sources() -> None:
    """Copy the files of other folders that the site shows, if they have changed."""
    notebooks = DOCS / "notebooks"
    extra = DOCS / "_extra"
    for folder in (notebooks, extra):
        folder.mkdir(exist_ok=True)
    sources = {path.name: path for path in (ROOT / "notebooks").glob("*.ipynb")}
    for path in notebooks.glob("*.ipynb"):
        if path.name not in sources:
            path.unlink()
    for name, path in sources.items():
        copy(path, notebooks / name)
    if (STUDIES["report"] / "report.html").is_file():
        copy(STUDIES["report"] / "report.html", extra / "full-report.html")
    # The page that `make explorer` has built.
    if EXPLORER.is_dir():
        shutil.copytree(EXPLORER, extra / "explorer", dirs_exist_ok=True)
    # The crate's documentation with its source, which `make docs` has built.
    if RUST.is_dir():
        shutil.copytree(RUST, extra / "rust", dirs_exist_ok=True)
    # One file of MathJax, so that formulas show without a network.
    mathjax = next(f for f in metadata.files("sphinx-mathjax-offline") or [] if f.name == "tex-svg-full.js")
    copy(Path(str(mathjax.locate())), extra / "_static" / "tex-svg-full.js")


def copy(source: Path, target: Path) -> None:
    """Copy a file unless the target has the same content; Sphinx does not read an unchanged notebook again."""
    target.parent.mkdir(exist_ok=True)
    if not target.is_file() or source.read_bytes() != target.read_bytes():
        shutil.copyfile(source, target)


copy_sources()
write_pages()
quiet_kernels()

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinxcontrib.bibtex",
]
exclude_patterns = ["_extra", "README.md", "**.ipynb_checkpoints"]
nitpicky = True
# Names with their classes are too wide for the list beside a page.
toc_object_entries_show_parents = "hide"

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
mathjax_path = "tex-svg-full.js"

nb_execution_mode = "force"
# Each page is executed in a temporary folder, into which its examples write.
nb_execution_in_temp = True
nb_execution_show_tb = True
nb_execution_timeout = 240
# A widget needs a kernel, so that its output as HTML is shown.
nb_mime_priority_overrides = [("html", "text/html", 5)]
nb_execution_excludepatterns = ["notebooks/*.ipynb"]
nb_merge_streams = True
nb_render_markdown_format = "myst"

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

bibtex_bibfiles = ["references.bib"]
bibtex_default_style = "plain"
bibtex_reference_style = "author_year"

copybutton_exclude = ".linenos, .gp, .go"

html_theme = "pydata_sphinx_theme"
html_title = f"fullbody {release}"
html_favicon = "_static/favicon.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["_extra"]
WIDE = (
    "index",
    "gallery",
    "notebooks",
    "install",
    "comparison",
    "report",
    "full_report",
    "binaries",
    "kalliope",
    "hertha",
    "kw4_radar",
    "hera",
    "explorer",
    "reference/names",
)
html_sidebars = {page: [] for page in WIDE}
html_show_sourcelink = True
# The address of the source, which is shown if there is one.
ADDRESS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["fullbody"]["address"]
html_theme_options = {
    "icon_links": [{"name": "Source", "url": ADDRESS, "icon": "fa-brands fa-git-alt"}] if ADDRESS else [],
    "navigation_with_keys": False,
    "show_prev_next": True,
    "secondary_sidebar_items": {"**": ["page-toc", "sourcelink"], "gallery": [], "reference/names": []},
    "header_links_before_dropdown": 7,
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_toc_level": 2,
    "back_to_top_button": False,
}


class LinkSource(SphinxPostTransform):
    """Links literals such as ``src/gravity/near.rs`` or ``src/gravity`` to their pages in the crate's documentation."""

    default_priority = 500

    def run(self, **kwargs: object) -> None:
        """Replace the literals of one page; a file that does not exist is a warning."""
        for literal in list(self.document.findall(nodes.literal)):
            path = literal.astext().rstrip("/")
            if not path.startswith("src/") or isinstance(literal.parent, nodes.reference):
                continue
            if not (ROOT / path).exists():
                logging.getLogger(__name__).warning("no %s in the project", path, location=literal)
                continue
            inner = path.removeprefix("src/")
            # A module that is not public has no page, but a listing.
            listing = inner if path.endswith(".rs") else f"{inner}/mod.rs"
            target = f"fullbody/{inner}/index.html"
            target = f"rust/{target}" if (RUST / target).is_file() else f"rust/src/fullbody/{listing}.html"
            page = self.app.builder.get_target_uri(self.env.docname)
            link = nodes.reference("", "", internal=True, refuri=relative_uri(page, target))
            literal.replace_self(link)
            link += literal


class DescribeImages(SphinxPostTransform):
    """Gives each image without an alternative text its caption, or else the title of its section."""

    default_priority = 500

    def run(self, **kwargs: object) -> None:
        """Describe the images of one page; without this, the alternative text would be the name of a file."""
        for image in self.document.findall(nodes.image):
            if image.get("alt"):
                continue
            following = image.next_node(descend=False, siblings=True)
            if isinstance(following, nodes.paragraph) and isinstance(following[0], nodes.emphasis):
                image["alt"] = following.astext()
                continue
            section: Any = image.parent
            while section is not None and not isinstance(section, nodes.section):
                section = section.parent
            if section is not None:
                image["alt"] = f"Figure of the section: {section.next_node(nodes.title).astext()}"


def escape_number(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep a leading ``(65803)`` from being read as the number of a list's item."""
    first = next((index for index, line in enumerate(lines) if line.strip()), None)
    if first is not None and lines[first].startswith("("):
        lines[first] = "\\" + lines[first]


def add_return(app: object, what: str, name: str, obj: Any, options: object, lines: list[str]) -> None:
    """Add a section with the return type of the signature, unless the docstring has one."""
    if what not in ("function", "method") or {"Parameters", "Returns", "Yields"} & {*lines} != {"Parameters"}:
        return
    kind = inspect.signature(obj).return_annotation
    if kind not in (inspect.Signature.empty, None, "None", "Any"):
        later_sections = ("Raises", "Warns", "See Also", "Notes", "References", "Examples")
        index = next((k for k, line in enumerate(lines) if line in later_sections), len(lines))
        lines[index:index] = ["Returns", "-------", str(kind), ""]


def drop_modules_without_source(app: Any) -> list[Any]:
    """Remove modules without source, such as the extension, from the index of sources, where their links would fail."""
    modules = app.env._viewcode_modules
    for name in [name for name, entry in modules.items() if not entry]:
        del modules[name]
    return []


def correct_back_links(app: Any, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Correct the links from listings of sources to the names under which the reference documents their objects.

    Sphinx assumes that all objects of a file are documented as attributes of one module.
    """
    if not page.startswith("_modules/fullbody"):
        return
    objects = app.env.domains.python_domain.objects

    def corrected(link: re.Match[str]) -> str:
        head, docname, anchor = link.groups()
        if anchor not in objects:
            for name, entry in objects.items():
                if entry.docname == docname and anchor.endswith("." + name.rpartition(".")[2]) and not entry.aliased:
                    return f"{head}{docname}.html#{entry.node_id}"
        return link[0]

    context["body"] = re.sub(r"((?:\.\./)+)(reference/[\w/-]+)\.html#([\w.]+)", corrected, context["body"])


def drop_template(app: Any, error: Exception | None) -> None:
    """Remove a template that the theme copies with its files: it is no page, and its links are broken."""
    (Path(app.outdir) / "_static" / "webpack-macros.html").unlink(missing_ok=True)


def setup(app: Any) -> None:
    """Connect the functions of this file, before or after numpydoc, which parses the docstrings."""
    app.add_post_transform(Thumbnails)
    app.add_post_transform(LinkSource)
    app.add_post_transform(DescribeImages)
    app.connect("source-read", note_missing_results)
    app.connect("source-read", expand)
    app.connect("autodoc-process-docstring", add_return, priority=400)
    app.connect("autodoc-process-docstring", escape_number, priority=600)
    app.connect("html-collect-pages", drop_modules_without_source, priority=100)
    app.connect("html-page-context", correct_back_links)
    app.connect("build-finished", drop_template, priority=900)
