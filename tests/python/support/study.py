"""Run sweeps whose process kills itself after DIE setups: ``python study.py FOLDER:DIE ...``.

It prints the exit code of each process.
"""

import os
import signal
import sys
from pathlib import Path

import fullbody
import h5netcdf  # noqa: F401  before the processes part
import numpy as np
import xarray  # noqa: F401

from support.maps import circle

LOGGED = []


def done(row):
    """Count a setup in a file, and kill the process after the last one that is allowed."""
    log, left = LOGGED
    with log.open("a") as file:
        file.write(f"{row}\n")
    LOGGED[1] = left - 1
    if LOGGED[1] == 0:
        os.kill(os.getpid(), signal.SIGKILL)


def setup(row, rng):
    """Return the system and state of a row; row 5 fails."""
    sys.modules["__main__"].done(row)
    if row == 5:
        raise ValueError("the fifth")
    return circle(rng.uniform(0.1, 0.9), rng.uniform(1.0, 2.0))


def measure(run):
    """Return numbers, nan and text."""
    return {"place": run.position[-1], "text": f"{run.statistics.steps} steps", "nothing": np.nan}


if __name__ == "__main__":
    for folder, _, die in (task.rpartition(":") for task in sys.argv[1:]):
        child = os.fork()
        if child == 0:
            LOGGED[:] = Path(folder, "log"), int(die)
            rows = {"row": range(12)}
            fullbody.sweep(setup, rows, 5.0, measure=measure, store=Path(folder, "map.nc"), key="study", rng=3, chunk=2)
            os._exit(0)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
