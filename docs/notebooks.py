"""Executes notebooks and stores their pictures with 256 colours, in a third of the space: ``make notebooks``.

Arguments are the notebooks to execute; without any, all are executed.
"""

import base64
import io
import os
import shutil
import sys
import tempfile
from pathlib import Path

import nbclient
import nbformat
from PIL import Image

#: Code for a kernel that makes the text of a figure a list of its contents, which a test compares with new figures.
DESCRIBE = """
def _describe(figure):
    from collections import Counter

    parts = []
    for ax in figure.axes:
        artists = Counter(type(artist).__name__ for artist in (*ax.lines, *ax.collections, *ax.patches, *ax.images))
        legend = [text.get_text() for text in ax.get_legend().get_texts()] if ax.get_legend() else []
        titles = [ax.get_title(loc=loc) for loc in ("left", "center", "right")]
        labels = [text for text in (*titles, ax.get_xlabel(), ax.get_ylabel(), *legend) if text]
        parts.append(f"{', '.join(f'{count} {name}' for name, count in sorted(artists.items()))}: {'; '.join(labels)}")
    return "\\n".join(["Figure", *parts])


def _describe_figures():
    import matplotlib.figure

    matplotlib.figure.Figure.__repr__ = _describe


_describe_figures()
"""


def quiet_kernels() -> None:
    """Let kernels that start from now on report errors alone; they would warn of their connections each time."""
    folder = Path(tempfile.mkdtemp()) / "profile_default"
    folder.mkdir()
    (folder / "ipython_kernel_config.py").write_text('c.IPKernelApp.log_level = "ERROR"\n', encoding="utf-8")
    os.environ["IPYTHONDIR"] = str(folder.parent)


def main() -> None:
    """Execute the notebooks and write them."""
    quiet_kernels()
    folder = Path(__file__).parents[1] / "notebooks"
    for path in [Path(name) for name in sys.argv[1:]] or sorted(folder.glob("*.ipynb")):
        notebook = nbformat.read(path, as_version=4)
        # A notebook reads the files beside it, and the files that it writes are deleted.
        with tempfile.TemporaryDirectory() as work:
            for data in folder.glob("*.json"):
                shutil.copy(data, work)
            resources = {"metadata": {"path": work}}
            options = {"timeout": 3600, "record_timing": False, "store_widget_state": False}
            notebook.cells.insert(0, nbformat.v4.new_code_cell(DESCRIBE))
            client = nbclient.NotebookClient(notebook, resources=resources, kernel_name="python3", **options)
            client.execute()
        del notebook.cells[0]
        for count, cell in enumerate((cell for cell in notebook.cells if cell.cell_type == "code"), 1):
            cell.execution_count = count
            for output in cell.outputs:
                if output.output_type == "execute_result":
                    output.execution_count = count
        shrink(notebook)
        nbformat.write(notebook, path)
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB", flush=True)


def shrink(notebook: nbformat.NotebookNode) -> None:
    """Replace the pictures of a notebook by pictures with a palette."""
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                data["image/png"] = with_palette(data["image/png"])


def with_palette(picture: str) -> str:
    """Return a PNG in base64 with a palette of 256 colours, or the picture itself if that is smaller."""
    image = Image.open(io.BytesIO(base64.b64decode(picture))).convert("RGBA")
    opaque = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image).convert("RGB")
    written = io.BytesIO()
    opaque.quantize(256, dither=Image.Dither.NONE).save(written, "PNG", optimize=True)
    return min(base64.b64encode(written.getvalue()).decode() + "\n", picture, key=len)


if __name__ == "__main__":
    main()
