"""A sweep by a worker of dask that is killed and by its successor: ``python cluster.py FOLDER``."""

import os
import signal
import sys
from pathlib import Path

import fullbody
import numpy as np

FOLDER = sys.argv[1]
ROWS = {"row": range(12)}


def setup(row, rng):
    """Return the setup of a row; the first worker that computes row 5 is killed."""
    with open(f"{FOLDER}/log", "a") as log:
        log.write(f"{row} {os.getpid()}\n")
    if row == 5:
        try:
            os.close(os.open(f"{FOLDER}/died", os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            pass
        else:
            os.kill(os.getpid(), signal.SIGKILL)
    mass = rng.uniform(0.1, 0.9)
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (1.0, mass)]
    speed = np.sqrt(1.0 + mass)
    return fullbody.System(bodies, G=1.0), fullbody.State([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, speed, 0]])


def measure(run):
    """Return the positions at the end."""
    return {"place": run.position[-1]}


def main():
    """Run the sweep with dask and a store, and then without dask."""
    from dask.distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster,
        Client(cluster) as client,
    ):
        fullbody.sweep(
            setup,
            ROWS,
            5.0,
            measure=measure,
            rng=3,
            chunk=2,
            key="cluster",
            store=Path(FOLDER, "dask.nc"),
            executor=client.get_executor(),
        )
        system, state = setup(1, np.random.default_rng(1))
        system.integrate(state, 1.0).save(Path(FOLDER, "run.nc"))
    Path(FOLDER, "log").rename(Path(FOLDER, "log of dask"))
    fullbody.sweep(setup, ROWS, 5.0, measure=measure, rng=3, store=Path(FOLDER, "alone.nc"), key="cluster")


if __name__ == "__main__":
    main()
