"""Pages of thumbnails, made of the pictures of other pages: the gallery, and the index of the notebooks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.osutil import relative_uri


def cells(document: nodes.document) -> Iterator[tuple[nodes.literal_block, nodes.image]]:
    """Yield the code and the picture of each cell of an executed page that draws one."""
    for cell in document.findall(lambda node: isinstance(node, nodes.container) and "cell" in node["classes"]):
        code, picture = next(cell.findall(nodes.literal_block), None), next(cell.findall(nodes.image), None)
        if code is not None and picture is not None:
            yield code, picture


class Thumbnails(SphinxPostTransform):
    """Fills the gallery with all pictures of the how-to pages and the notebooks, and the index with one of each."""

    # At this priority the types of outputs have not been chosen, and the images of the page not been collected.
    default_priority = 1
    #: Each page of thumbnails, with the pages whose lists of contents name those that it shows.
    pages: ClassVar = {"gallery": ("howto/index", "notebooks"), "notebooks": ("notebooks",)}

    def run(self, **kwargs: Any) -> None:
        """Append the thumbnails to one page."""
        name = self.env.docname
        for index in self.pages.get(name, ()):
            cards = []
            for page in self.env.toctree_includes.get(index, ()):
                pictures = list(cells(self.env.get_doctree(page)))
                title = self.env.titles[page].astext()
                if name == "gallery":
                    cards += [self.card(page, title, code, picture) for code, picture in pictures]
                else:
                    picture = self.picture(page, pictures[0][1], title) if pictures else nodes.inline()
                    self.document += self.box("gallery-row", picture, self.caption(page, title))
            if name == "gallery":
                self.document += nodes.rubric("", "", self.link(index, self.env.titles[index].astext()))
                self.document += self.box("gallery", *cards)

    def card(self, page: str, title: str, code: nodes.literal_block, picture: nodes.image) -> nodes.container:
        """Return a picture with the title of its page and its code, which a click opens."""
        opened, closed = ("<details><summary>code</summary>", "</details>")
        parts = nodes.raw("", opened, format="html"), code.deepcopy(), nodes.raw("", closed, format="html")
        return self.box("gallery-card", self.picture(page, picture, title), self.caption(page, title), *parts)

    def caption(self, page: str, title: str) -> nodes.paragraph:
        """Return a link to a page as a paragraph."""
        return nodes.paragraph("", "", self.link(page, title))

    def picture(self, page: str, picture: nodes.image, title: str) -> nodes.reference:
        """Return a picture that is a link to its page."""
        copy = picture.deepcopy()
        copy["alt"] = copy.get("alt") or f"picture of the page {title}"
        for size in ("width", "height", "scale", "align"):
            copy.attributes.pop(size, None)
        link = self.link(page, "")
        link.clear()
        link += copy
        return link

    def link(self, page: str, title: str) -> nodes.reference:
        """Return a link to a page."""
        builder = self.app.builder
        target = relative_uri(builder.get_target_uri(self.env.docname), builder.get_target_uri(page))
        return nodes.reference("", title, internal=True, refuri=target)

    @staticmethod
    def box(name: str, *children: nodes.Node) -> nodes.container:
        """Return a container with a class for the style sheet."""
        return nodes.container("", *children, classes=[name])
