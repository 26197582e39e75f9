"""Count the instructions per interaction with valgrind's callgrind, which do not depend on the machine's load.

    python benches/instructions.py

Two counts are run and subtracted, so that the start of the program drops out. Valgrind knows no AVX-512.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile

METHODS = ("focal", "surface", "multipole:2", "multipole:4", "multipole:8", "point")
PROGRAM = ("target", "release", "examples", "interaction")


def instructions(method: str, path: str, count: int) -> int:
    """Return the number of instructions of a whole run."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out", "/".join(PROGRAM)]
        command += [method, "1e-14", path, str(count)]
        result = subprocess.run(command, capture_output=True, text=True, check=True)
    computed = re.search(r"Collected : (\d+)", result.stderr)
    if computed is None:
        raise RuntimeError(f"callgrind printed no count:\n{result.stderr}")
    return int(computed.group(1))


def main() -> None:
    """Print the table."""
    if shutil.which("valgrind") is None:
        print("valgrind is not installed; no instructions counted")
        return
    subprocess.run(["cargo", "build", "--quiet", "--release", "--example", PROGRAM[-1]], check=True)
    print("instructions of one interaction (force and both torques), 1999 KW4, tolerance 1e-14")
    for method in METHODS:
        for path in ("portable", "avx2") if method in ("focal", "surface") else ("portable",):
            short, long = (instructions(method, path, count) for count in (100, 600))
            print(f"  {method:<14}{path:<10}{(long - short) / 500:10.0f}")


if __name__ == "__main__":
    main()
