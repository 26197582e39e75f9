"""Measure ``import fullbody`` and ``import numpy``, each in a fresh interpreter.

python benches/import_time.py
"""

from __future__ import annotations

import subprocess
import sys

CODE = "import time; start = time.perf_counter(); import {}; print(time.perf_counter() - start)"


def best(module: str, repeats: int = 10) -> float:
    """Return the shortest time in seconds."""
    command = [sys.executable, "-c", CODE.format(module)]
    return min(float(subprocess.run(command, capture_output=True, check=True).stdout) for _ in range(repeats))


if __name__ == "__main__":
    alone, package = best("numpy"), best("fullbody")
    print(f"import fullbody: {package:.3f} s, of which numpy {alone:.3f} s")
