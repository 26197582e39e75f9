"""Many runs at once: how well threads are used, what is lost beside the runs, and what memory they take.

    python benches/ensemble.py [--members 200] [--days 200] [--slice 100] [--short 9990] [--repeats 1]

First members of Dimorphos that start turned by various angles: in a loop of single runs, and in one call on one and on
two threads. The members go in slices, in which the three take turns, and of repeated times the shortest counts. Then
the same with points, beside heyoka's ensemble where there is one (pip install heyoka) and otherwise beside rebound in
processes. Last, many short runs in a process of their own: its time of the processor beside that of their integration
alone, and its peak of memory with what is kept.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import fullbody
import numpy as np
from fullbody import _core

DAY = 24.0
#: The relative errors that all are asked for.
RTOL = 1e-13
Member = tuple[fullbody.System, fullbody.State]


def members(count: int) -> list[Member]:
    """Return Dimorphos turned by up to 0.3 rad at the start."""
    system, state = fullbody.systems.didymos()
    return [(system, state.rotated("Dimorphos", [0, 0, 1], angle)) for angle in np.linspace(0.0, 0.3, count)]


def points(count: int) -> list[Member]:
    """Return the members as two points, which do not rotate, with orbits of various widths."""
    system, state = fullbody.systems.didymos()
    both = fullbody.System([fullbody.Body(fullbody.PointMass(), mass=m) for m in system.masses], G=float(system.G))
    wider = np.array([[0.0, 0.0, 0.0], [1e-4, 0.0, 0.0]])
    position, velocity = np.asarray(state.position), np.asarray(state.velocity)
    return [(both, fullbody.State(position * (1 + k * wider), velocity)) for k in range(count)]


def seconds(work: Callable[[], Any]) -> tuple[float, float]:
    """Return the times of the wall's clock and of the processor, in seconds."""
    wall, processor = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - processor


def race(ways: dict[str, Callable[[int], Any]], parts: int, repeats: int) -> dict[str, tuple[float, float]]:
    """Return the sums over the parts of the shortest times of each way."""
    total = {name: np.zeros(2) for name in ways}
    for part in range(parts):
        best = {name: np.full(2, np.inf) for name in ways}
        for _ in range(repeats):
            for name, work in ways.items():
                best[name] = np.minimum(best[name], seconds(partial(work, part)))
        for name, times in best.items():
            total[name] += times
    return {name: (times[0], times[1]) for name, times in total.items()}


def table(title: str, results: dict[str, tuple[float, float]], count: int) -> None:
    """Print the runs a second and the ratios to the first way."""
    print(f"\n{title:<44}{'wall s':>9}{'processor s':>13}{'runs/s':>9}{'ratio':>8}")
    first = next(iter(results.values()))[0]
    for name, (wall, processor) in results.items():
        print(f"  {name:<42}{wall:9.2f}{processor:13.2f}{count / wall:9.3g}{first / wall:8.3f}")


def ours(batch_members: list[Member], days: float, size: int, repeats: int) -> dict[str, tuple[float, float]]:
    """Return the members run in a loop, on one thread, and on two threads."""
    parts = [batch_members[k : k + size] for k in range(0, len(batch_members), size)]
    until = days * DAY

    def batch(part: int, threads: int) -> Any:
        return fullbody.integrate_many(parts[part], until, output="ends", threads=threads)

    ways: dict[str, Callable[[int], Any]] = {
        "a loop of single runs": lambda k: [s.integrate(start, until, output="ends") for s, start in parts[k]],
        "integrate_many, one thread": lambda k: batch(k, 1),
        "integrate_many, two threads": lambda k: batch(k, 2),
    }
    return race(ways, len(parts), repeats)


def orbit() -> tuple[float, float, Any]:
    """Return two masses times G, and the relative position and velocity of Dimorphos."""
    system, state = fullbody.systems.didymos()
    first, second = float(system.G) * np.asarray(system.masses)
    (r0, r1), (v0, v1) = np.asarray(state.position), np.asarray(state.velocity)
    return first, second, np.concatenate([r1 - r0, v1 - v0])


def by_rebound(task: tuple[int, float, tuple[float, float, Any]]) -> float:
    """Integrate points by REBOUND, with the orbit a little wider for each."""
    import rebound

    number, until, (first, second, relative) = task
    sim = rebound.Simulation()
    sim.G = 1.0
    sim.add(m=first)
    x, y, z, u, v, w = relative
    sim.add(m=second, x=x * (1 + 1e-4 * number), y=y, z=z, vx=u, vy=v, vz=w)
    sim.integrate(until)
    return float(sim.particles[1].x)


def peers(count: int, days: float, repeats: int) -> dict[str, tuple[float, float]]:
    """Return the runs of points by another program on one and on two cores."""
    until = days * DAY
    try:
        import heyoka
    except ImportError:
        ways = {}
        for number, name in ((1, "one process"), (2, "two processes")):
            pool = ProcessPoolExecutor(number)
            list(pool.map(by_rebound, [(0, 1.0, orbit())] * number))
            ways[f"rebound (IAS15), {name}"] = lambda _, pool=pool: list(
                pool.map(by_rebound, [(k, until, orbit()) for k in range(count)])
            )
        return race(ways, 1, repeats)
    first, second, relative = orbit()
    system = heyoka.model.nbody(2, masses=[first, second])
    integrator = heyoka.taylor_adaptive(system, [0.0] * 12, tol=RTOL)

    def start(integrator: Any, number: int) -> Any:
        integrator.time = 0.0
        integrator.state[:6] = 0.0
        integrator.state[6:] = relative * [1 + 1e-4 * number, 1, 1, 1, 1, 1]
        return integrator

    def propagate(workers: int) -> Any:
        return heyoka.ensemble_propagate_until(integrator, until, count, start, max_workers=workers)

    return race({f"heyoka, {n} thread{'s' * (n > 1)}": lambda _, n=n: propagate(n) for n in (1, 2)}, 1, repeats)


def short(count: int, days: float, threads: int) -> None:
    """Print what many short runs take, from a process that does nothing else."""
    system, state = fullbody.systems.didymos()
    until = days * DAY

    def sample() -> Any:
        rng = np.random.default_rng(1)
        for _ in range(count):
            yield system, state.rotated("Dimorphos", [0, 0, 1], 0.3 * rng.random())

    # The overhead of integrate_many per member does not depend on the length of its run, and shows best for short runs.
    some = [member for _, member in zip(range(count // 20), sample(), strict=False)]
    described = fullbody.Verner98()._describe(system.context.units)
    start = _core.Simulation

    def alone(until: float) -> None:
        for system, state in some:
            single = start(system.context.core, state.in_units(system.context.units), described, "{}")
            single.integrate(until, "ends", [], False, None, None, (None, False))

    def together(until: float) -> None:
        fullbody.integrate_many(some, until, output="ends", threads=1)

    works = (partial(alone, until), partial(alone, 0.01), partial(together, 0.01))
    taken = [[seconds(work)[1] / len(some) for work in works] for _ in range(10)]
    core, short_alone, short_together = (min(times) for times in zip(*taken, strict=True))
    more = short_together - short_alone
    runs: list[Any] = []
    usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, used = seconds(lambda: runs.extend(fullbody.integrate_many(sample(), until, output="ends", threads=threads)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    kept = sum(values.nbytes for run in runs for values in run.arrays.values())
    print(f"\n{count} runs of {days:g} days on {threads} threads: {wall:.1f} s, {count / wall:.0f} a second")
    print(f"  of the processor {used:.1f} s, {1e3 * core:.2f} ms a run of integration alone and")
    print(f"  {1e6 * more:.0f} microseconds a run more, {100 * more / (core + more):.1f} %")
    print(f"  memory at most {peak / 1024:.0f} MiB, {usage / 1024:.0f} MiB before; {kept / 2**20:.1f} MiB of samples")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--members", type=int, default=200)
    parser.add_argument("--days", type=float, default=200.0)
    parser.add_argument("--slice", type=int, default=100)
    parser.add_argument("--short", type=int, default=9990)
    parser.add_argument("--short-days", type=float, default=2.0)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--only-short", action="store_true")
    arguments = parser.parse_args()
    if arguments.only_short:
        short(arguments.short, arguments.short_days, 2)
        return
    results = ours(members(arguments.members), arguments.days, arguments.slice, arguments.repeats)
    table(f"{arguments.members} members, {arguments.days:g} days of Dimorphos", results, arguments.members)
    results = ours(points(arguments.members), arguments.days, arguments.slice, arguments.repeats)
    table(f"{arguments.members} members, {arguments.days:g} days, points", results, arguments.members)
    results = peers(arguments.members, arguments.days, arguments.repeats)
    table("the same by another program", results, arguments.members)
    words = ["--only-short", f"--short={arguments.short}", f"--short-days={arguments.short_days}"]
    subprocess.run([sys.executable, __file__, *words], check=True)


if __name__ == "__main__":
    main()
