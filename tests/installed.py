"""Installs the results of ``make wheel`` as a user does, and runs 1999 KW4: ``python tests/installed.py dist``.

The wheel is installed into an environment without Rust, the source distribution into one with Rust.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

# The range of Beta's spin about its z-axis in the first 200 h, 1e-5 rad/s, by two other programs.
SPIN_Z = (9.05, 10.69)

# 20 h of the run with numpy and tqdm alone.
SHORT = """
import fullbody
system, state = fullbody.systems.kw4_ho2021()
run = system.integrate(state, 20.0)
assert abs(run.energy_drift).max() < 1e-13, run.energy_drift
print(fullbody.__version__, fullbody.vector_paths(), fullbody.__file__)
"""


class Environment:
    """A new virtual environment in a folder."""

    def __init__(self, folder: Path, path: str) -> None:
        venv.create(folder, with_pip=True)
        self.folder = folder
        self.bin = folder / ("Scripts" if os.name == "nt" else "bin")
        self.variables = {
            name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")
        }
        self.variables["PATH"] = os.pathsep.join([str(self.bin), path])

    def run(self, *command: str, **variables: str) -> None:
        """Run a command of the environment in its folder, and raise an error if it fails."""
        program = shutil.which(command[0], path=str(self.bin))
        subprocess.run([program, *command[1:]], cwd=self.folder, env=self.variables | variables, check=True)


def path_without_rust() -> str:
    """Return the search path without the folders that contain Rust."""
    programs = ("cargo", "rustc", "rustup")
    folders = [f for f in os.environ["PATH"].split(os.pathsep) if not any(shutil.which(p, path=f) for p in programs)]
    return os.pathsep.join(folders)


def built_file(dist: Path, pattern: str) -> Path:
    """Return the only file in a folder that matches a pattern."""
    (path,) = dist.glob(pattern)
    return path.resolve()


def main(dist: Path) -> None:
    """Install both distributions and run them."""
    with tempfile.TemporaryDirectory() as temporary:
        without_rust = Environment(Path(temporary) / "wheel", path_without_rust())
        without_rust.run("python", "-m", "pip", "install", "--quiet", str(built_file(dist, "*.whl")))
        without_rust.run("python", "-c", SHORT)
        without_rust.run("python", "-m", "pip", "install", "--quiet", f"{built_file(dist, '*.whl')}[units,data,plot]")
        without_rust.run("fullbody", "kw4", "--until", "200", "--gravity", "focal", "--quiet", "--out", "kw4")
        numbers = json.loads((without_rust.folder / "kw4" / "numbers.json").read_text())["ellipsoid"]["focal"]
        spin = tuple(round(value, 2) for value in numbers["spin_z"])
        assert spin == SPIN_Z, f"Beta's spin is within {spin}; expected {SPIN_Z}"

        source = Environment(Path(temporary) / "source", os.environ["PATH"])
        # The test is whether it builds, and not how fast the result is.
        quick = {"CARGO_PROFILE_RELEASE_LTO": "off", "CARGO_PROFILE_RELEASE_OPT_LEVEL": "0"}
        quick |= {"CARGO_PROFILE_RELEASE_CODEGEN_UNITS": "16", "CARGO_PROFILE_RELEASE_DEBUG": "false"}
        source.run("python", "-m", "pip", "install", "--quiet", str(built_file(dist, "*.tar.gz")), **quick)
        source.run("python", "-c", SHORT)
    print("the wheel runs without Rust, and the source distribution builds with it")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
