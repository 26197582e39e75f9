"""Notebooks run from top to bottom, and are kept with their outputs."""

import itertools
import re
import runpy
import shutil
from pathlib import Path

import nbclient
import nbformat
import pytest

ROOT = Path(__file__).parents[3]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
#: Describes figures as text, in the kernel that stores the outputs and in that of the tests.
DESCRIBE = runpy.run_path(str(ROOT / "docs" / "notebooks.py"))["DESCRIBE"]


def code(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def kinds(cell):
    """Return the kinds of a cell's outputs; the kernel may send text in any number of pieces."""
    return [kind for kind, _ in itertools.groupby(output.output_type for output in cell.outputs)]


def wording(cell):
    """The words of a cell's outputs, pictures and pages included, without numbers, addresses and data."""
    texts = []
    for output in cell.outputs:
        data = output.get("data", {})
        texts += [output.get("text", ""), data.get("text/plain", ""), data.get("text/html", "")]
    words = re.sub(r"[A-Za-z0-9+/=]{80,}|[0-9a-f]{12,}", "#", "\n".join(texts))
    words = re.sub(r"[-+\u2212]?(\d[\d.,:]*(e[-+]?\d+)?|\b(inf|nan)\b)", "#", words)
    return sorted(set(words.split()))


def test_there_are_notebooks():
    assert {"01", "02", "03", "04", "05", "06", "07", "10"} <= {path.name[:2] for path in NOTEBOOKS}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_are_kept_with_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert [cell.execution_count for cell in code(notebook)] == list(range(1, len(code(notebook)) + 1))
    outputs = [output for cell in code(notebook) for output in cell.outputs]
    assert not [output for output in outputs if output.output_type == "error"]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    text = path.read_text(encoding="utf-8")
    assert "site-packages" not in text
    assert len(text) < 1_500_000


#: Only the imports of the previous notebook are kept. Pictures are drawn once, small, and their parts are not arranged,
#: which takes as long as drawing them.
FRESH = """
%cd -q {folder}
import matplotlib
from matplotlib.layout_engine import ConstrainedLayoutEngine
matplotlib.rcdefaults()
%matplotlib inline
%config InlineBackend.print_figure_kwargs = {{'bbox_inches': None, 'dpi': 30}}
ConstrainedLayoutEngine.execute = lambda *_: None
%reset -f -s
"""


@pytest.fixture(scope="module")
def kernel():
    """Return one kernel for all notebooks: starting it takes longer than most of them."""
    client = nbclient.NotebookClient(nbformat.v4.new_notebook(), timeout=240, kernel_name="python3")
    with client.setup_kernel():
        yield client


# Each takes some seconds on an idle machine.
@pytest.mark.timeout(600)
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path, tmp_path, kernel):
    notebook = nbformat.read(path, as_version=4)
    stored = [kinds(cell) for cell in code(notebook)]
    for data in path.parent.glob("*.json"):
        shutil.copy(data, tmp_path)
    words = [wording(cell) for cell in code(notebook)]
    fresh = FRESH.format(folder=tmp_path) + DESCRIBE
    notebook.cells.insert(0, nbformat.v4.new_code_cell(fresh))
    # Long computations are reduced: the metadata of a cell say which texts are replaced by which.
    for cell in code(notebook):
        for original, reduced in cell.metadata.get("small", {}).items():
            assert original in cell.source
            cell.source = cell.source.replace(original, reduced)
    kernel.nb = notebook
    for index, cell in enumerate(notebook.cells):
        kernel.execute_cell(cell, index)
    # There are no new warnings and no missing pictures.
    assert [kinds(cell) for cell in code(notebook)] == [[], *stored]
    # The outputs are not older than what the code writes and draws now; reduced computations may have other words.
    cells = itertools.takewhile(lambda cell: not cell.metadata.get("small"), code(notebook)[1:])
    for cell, text in zip(cells, words, strict=False):
        changed = set(wording(cell)) ^ set(text)
        assert not changed, f"`make notebooks NOTEBOOKS=notebooks/{path.name}` stores new outputs: {cell.source[:60]}"
