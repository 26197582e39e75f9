"""Builds a page on which 1999 KW4 runs in the browser: ``python browser/build.py FOLDER``.

Into the folder go the page, a wheel for Pyodide, that of tqdm, and what this machine makes of the same run.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import fullbody

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = "wasm32-unknown-emscripten"
PACKAGES = [f"fullbody-{fullbody.__version__}-cp311-abi3-{TARGET.replace('-', '_')}.whl", "tqdm-py3-none-any.whl"]


def extension() -> Path:
    """The extension module, with WebAssembly's vector instructions."""
    prefix = f"CARGO_TARGET_{TARGET.upper().replace('-', '_')}"
    settings = {
        f"{prefix}_LINKER": str(HERE / "link.py"),
        f"{prefix}_RUSTFLAGS": "-C target-feature=+simd128",
        "PYO3_CROSS": "1",
        "PYO3_CROSS_PYTHON_VERSION": "3.11",
    }
    environment = {name: value for name, value in os.environ.items() if name != "PYO3_PYTHON"} | settings
    command = ["cargo", "rustc", "--locked", "--package", "fullbody-python", "--profile", "browser", "--target", TARGET]
    subprocess.run(command, cwd=ROOT, env=environment, check=True)
    return ROOT / "target" / TARGET / "browser" / "_core.wasm"


def wheel(path: Path, module: Path) -> None:
    """The package with this extension module, as an archive that Pyodide unpacks."""
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        command = ["maturin", "pep517", "write-dist-info", "--metadata-directory", folder]
        subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
        for base in (Path(folder), ROOT / "python"):
            for file in sorted(base.rglob("*")):
                if file.is_file() and file.suffix not in (".so", ".pyc", ".pyd"):
                    archive.write(file, file.relative_to(base))
        archive.write(module, "fullbody/_core.abi3.so")


def main(out: Path) -> None:
    """Build all."""
    out.mkdir(parents=True, exist_ok=True)
    wheel(out / PACKAGES[0], extension())
    with tempfile.TemporaryDirectory() as folder:
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder, "tqdm"]
        subprocess.run(pip, check=True)
        (found,) = Path(folder).iterdir()
        shutil.copy(found, out / PACKAGES[1])
    shutil.copy(HERE / "index.html", out)
    shutil.copy(HERE / "run.py", out)
    numbers = subprocess.run([sys.executable, HERE / "run.py"], capture_output=True, text=True, check=True).stdout
    (out / "here.json").write_text(json.dumps({"packages": PACKAGES, "run": json.loads(numbers)}))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
