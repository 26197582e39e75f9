"""A sweep that is killed at random moments, again and again, beside the unbroken one.

python benches/killed.py [KILLS]
"""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROWS, KILLS, LONGEST = 1600, 20, 1.0


def sweep(store: str) -> None:
    """Return the librations of Beta by its first attitude; two rows in fifty have no setup or collide."""
    import fullbody
    import numpy as np
    import xarray  # noqa: F401  before the time counts

    def setup(row, rng):
        if row % 50 == 7:
            raise ValueError("no set-up")
        system, state = fullbody.systems.kw4("ellipsoid")
        if row % 50 == 8:
            return system, state.replace(velocity=np.zeros((2, 3)))
        return system, state.rotated("Beta", rng.normal(size=3), rng.normal(scale=0.3))

    def measure(run):
        return {"energy": run.energy_drift[-1], "attitude": run.attitude[-1], "reason": run.stop_reason}

    print("begun", flush=True)
    fullbody.sweep(setup, {"row": range(ROWS)}, 60.0, measure=measure, store=store, key="killed", rng=5, chunk=8)


def main(kills: int) -> int:
    """Kill and resume the sweep, and compare its file with that of the unbroken one."""
    rng = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        unbroken, broken = Path(folder, "unbroken.nc"), Path(folder, "broken.nc")
        start = time.perf_counter()
        subprocess.run([sys.executable, __file__, "--store", unbroken], check=True, stdout=subprocess.DEVNULL)
        print(f"unbroken: {time.perf_counter() - start:.1f} s, {unbroken.stat().st_size} bytes")
        killed = calls = 0
        while not broken.exists():
            calls += 1
            with subprocess.Popen([sys.executable, __file__, "--store", broken], stdout=subprocess.PIPE) as process:
                assert process.stdout is not None
                process.stdout.readline()
                if killed < kills:
                    try:
                        process.wait(rng.uniform(0.0, LONGEST))
                    except subprocess.TimeoutExpired:
                        process.kill()
                        killed += 1
            done = len(list(Path(folder, "broken.nc.parts").glob("*.npz")))
            print(f"call {calls}: {'done' if broken.exists() else f'{done} chunks are there'}")
        same = unbroken.read_bytes() == broken.read_bytes()
        print(f"killed {killed} times; the map is {'the same, byte for byte' if same else 'DIFFERENT'}")
        return 0 if same and killed >= min(kills, calls - 1) else 1


if __name__ == "__main__":
    if sys.argv[1:2] == ["--store"]:
        sweep(sys.argv[2])
    else:
        sys.exit(main(int(sys.argv[1]) if sys.argv[1:] else KILLS))
