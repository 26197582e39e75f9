"""The reference: pages of few names, made from the lists in ``docs/reference/*.md``, and an index of all names.

A page of a subject has blocks of names, each with the module in which the names are::

    ```{names} fullbody.observing
    ## Radar echoes
    radar_spectrum
    RadarEcho :exclude-members: power
    ```

A block without a title becomes the documentation of its names. Below a title, names get a separate page, for which the
block shows a list of the names with their summaries. A member of a class, such as ``Run.fly``, is documented where it
is listed and not with its class. The text after a name are options of Sphinx' autodoc, and a line that begins with
``>`` is text of the page.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

REFERENCE = Path(__file__).parent / "reference"
#: The folder of the pages that are made, beside those of the subjects.
PAGES = REFERENCE / "pages"
_BLOCK = re.compile(r"^```\{names\} (\S+)\n(.*?)^```\n", re.MULTILINE | re.DOTALL)


class Group(NamedTuple):
    """Names of a module that are documented on one page; without a title, on the page of their subject."""

    module: str
    title: str
    text: str
    entries: list[tuple[str, str]]

    @property
    def names(self) -> list[str]:
        """The names, relative to the module."""
        return [name for name, _ in self.entries]


def groups(module: str, block: str) -> list[Group]:
    """Return the groups of a block of names."""
    title, *titled = re.split(r"^## ", "\n" + block, flags=re.MULTILINE)
    texts = ["\n" + title, *titled] if title.strip() else titled
    result = []
    for text in texts:
        heading, *lines = text.splitlines()
        text = "\n".join(line.removeprefix("> ") for line in lines if line.startswith("> "))
        rows = [line for line in lines if line and not line.startswith("> ")]
        entries = [(name, options) for name, _, options in (row.partition(" ") for row in rows)]
        result.append(Group(module, heading, text, entries))
    return result


def all_groups(page: Path) -> list[Group]:
    """Return the groups of all blocks of a page."""
    return [group for block in _BLOCK.findall(page.read_text(encoding="utf-8")) for group in groups(*block)]


def subjects() -> Iterator[Path]:
    """Yield the pages of the subjects, in the order of the index."""
    contents = re.search(r"```\{toctree\}(.*?)```", (REFERENCE / "index.md").read_text(encoding="utf-8"), re.DOTALL)
    assert contents is not None
    for name in re.findall(r"^\w+$", contents[1], re.MULTILINE):
        yield REFERENCE / f"{name}.md"


def resolved(module: str, name: str) -> tuple[Any, Any]:
    """Return the object of a name in a module, and the object that has it as an attribute."""
    parent: Any = None
    item: Any = import_module(module)
    for part in name.split("."):
        parent = item
        # A module that is imported on demand is no attribute before that.
        item = getattr(parent, part) if hasattr(parent, part) else import_module(f"{parent.__name__}.{part}")
    return item, parent


def documented(group: Group, members: dict[str, list[str]]) -> str:
    """Return the directives that document the names of a group, without ``members`` of classes documented elsewhere."""
    lines = [f".. currentmodule:: {group.module}", ""]
    for name, options in group.entries:
        item, parent = resolved(group.module, name)
        if inspect.isclass(parent):
            kind = "property" if isinstance(item, property) else "method" if callable(item) else "attribute"
        elif inspect.isclass(item):
            kind = "exception" if issubclass(item, BaseException) else "class"
        else:
            kind = "function" if callable(item) else "data"
        lines.append(f".. auto{kind}:: {group.module}.{name}")
        if kind == "class":
            # The fields of a tuple are described by its class.
            separate = [*members.get(f"{group.module}.{name}", []), *getattr(item, "_fields", [])]
            options += "" if ":members:" in options else " :members:"
            options += f" :exclude-members: {', '.join(separate)}" if separate else ""
        lines += [f"   {option.strip()}" for option in re.split(r" (?=:)", options) if option.strip()]
        lines.append("")
    return "\n".join(lines)


def summaries(module: str, names: list[str]) -> str:
    """Return a list of names with their summaries."""
    head = f".. currentmodule:: {module}\n\n.. autosummary::\n   :nosignatures:\n\n"
    return head + "".join(f"   {name}\n" for name in names)


def separate_members() -> dict[str, list[str]]:
    """Return the members that are documented separately, by the full names of their classes."""
    separate: dict[str, list[str]] = {}
    for page in subjects():
        for group in all_groups(page):
            for name in group.names:
                if inspect.isclass(resolved(group.module, name)[1]):
                    kind, _, member = f"{group.module}.{name}".rpartition(".")
                    separate.setdefault(kind, []).append(member)
    return separate


def rst(text: str) -> str:
    """Return text in reStructuredText as a block of a page in Markdown."""
    return f"```{{eval-rst}}\n{text}```\n"


def page_of(subject: Path, group: Group) -> Path:
    """Return the page of a group with a title."""
    return PAGES / f"{subject.stem}-{re.sub(r'[^a-z0-9]+', '-', group.title.lower()).strip('-')}.md"


def write_pages() -> None:
    """Write the pages of all groups with a title, and remove those of former groups."""
    separate = separate_members()
    PAGES.mkdir(exist_ok=True)
    pages = {}
    for subject in subjects():
        for group in (group for group in all_groups(subject) if group.title):
            listed = rst(summaries(group.module, group.names)) if len(group.entries) > 1 else ""
            parts = f"# {group.title}\n", f"{group.text}\n", listed, rst(documented(group, separate))
            pages[page_of(subject, group)] = "\n".join(parts)
    for page in PAGES.glob("*.md"):
        if page not in pages:
            page.unlink()
    for page, text in pages.items():
        if not page.is_file() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def expand(app: Any, name: str, source: list[str]) -> None:
    """Replace the blocks of a page by lists of names with links to their pages, or by their documentation."""
    subject = REFERENCE / f"{name.removeprefix('reference/')}.md"
    if name == "reference/names":
        source[0] = source[0].replace("```{names}\n```\n", index())
    elif subject in subjects():
        separate = separate_members()
        source[0] = _BLOCK.sub(lambda block: block_text(subject, groups(*block.groups()), separate), source[0])


def block_text(subject: Path, block: list[Group], separate: dict[str, list[str]]) -> str:
    """Return the text that replaces a block of names on the page of a subject."""
    parts, pages = [], []
    for group in block:
        listed = rst(summaries(group.module, group.names))
        if group.title:
            page = page_of(subject, group)
            pages.append(f"pages/{page.stem}")
            parts.append(f"**[{group.title}](pages/{page.name})**\n\n{listed}")
        else:
            parts.append((listed if len(group.entries) > 1 else "") + "\n" + rst(documented(group, separate)))
    contents = "```{toctree}\n:hidden:\n\n" + "\n".join(pages) + "\n```\n" if pages else ""
    return contents + "\n" + "\n".join(parts)


def index() -> str:
    """Return the list of all names by subject."""
    parts = []
    for subject in subjects():
        title = subject.read_text(encoding="utf-8").partition("# ")[2].partition("\n")[0]
        names: dict[str, list[str]] = {}
        for group in all_groups(subject):
            listed = (name for name in group.names if not inspect.isclass(resolved(group.module, name)[1]))
            names.setdefault(group.module, []).extend(listed)
        if names:
            lists = "\n".join(rst(summaries(module, listed)) for module, listed in names.items())
            parts.append(f"**[{title}]({subject.name})**\n\n{lists}")
    return "\n".join(parts)
