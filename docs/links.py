"""Finds broken links within the built site: ``python docs/links.py out/docs``; `make docs` runs it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

#: Folders that are not checked: the pages of rustdoc, which checks its links, and the files of the theme.
UNCHECKED = ("rust", "_static")


class Page(HTMLParser):
    """The anchors of a page and the links on it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect the anchors and the links of an element."""
        values = dict(attrs)
        self.anchors |= {name for key in ("id", "name") if (name := values.get(key))}
        self.links |= {link for key in ("href", "src") if (link := values.get(key))}


def broken(site: Path) -> Iterator[str]:
    """Yield each link to a file or an anchor that does not exist, with the page that has it."""
    paths = [path for path in site.rglob("*.html") if path.relative_to(site).parts[0] not in UNCHECKED]
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in paths}
    for path, page in pages.items():
        for link in sorted(page.links):
            url = urlsplit(link)
            if url.scheme or url.netloc:
                continue
            target = (path.parent / unquote(url.path)).resolve() if url.path else path
            target = target / "index.html" if target.is_dir() else target
            anchor = unquote(url.fragment)
            has_no_anchor = anchor and target in pages and anchor not in pages[target].anchors
            if not target.exists() or has_no_anchor:
                yield f"{path.relative_to(site.resolve())}: {link}"


if __name__ == "__main__":
    links = list(broken(Path(sys.argv[1])))
    sys.exit("\n".join(["These links are broken:", *links]) if links else 0)
