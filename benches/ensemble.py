"""Many runs at once: the use of threads, the overhead beside the runs, and the memory.

    python benches/ensemble.py [--members 200] [--days 200] [--slice 100] [--short 9990] [--repeats 1]

The first members are systems of Dimorphos rotated by various angles, run in a loop of single runs, and in one call on
one and on two threads. The three methods alternate over slices of the members, and the shortest of repeated times
counts. Then follow points, compared with heyoka's ensemble if it is installed (pip install heyoka) and otherwise with
rebound in processes. The last are many short runs in a process of their own: its processor time beside that of the
integrations alone, and its peak of memory beside the size of the results.
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
#: The relative tolerance of all integrators.
RTOL = 1e-13
Member = tuple[fullbody.System, fullbody.State]


def members(count: int) -> list[Member]:
    """Return systems with Dimorphos rotated by up to 0.3 rad at the start."""
    system, state = fullbody.systems.didymos()
    return [(system, state.rotated("Dimorphos", [0, 0, 1], angle)) for angle in np.linspace(0.0, 0.3, count)]


def points(count: int) -> list[Member]:
    """Return the members as two points, which do not rotate, with orbits of various widths."""
    system, state = fullbody.systems.didymos()
    pair = fullbody.System([fullbody.Body(fullbody.PointMass(), mass=m) for m in system.masses], G=float(system.G))
    direction = np.array([[0.0, 0.0, 0.0], [1e-4, 0.0, 0.0]])
    position, velocity = np.asarray(state.position), np.asarray(state.velocity)
    return [(pair, fullbody.State(position * (1 + k * direction), velocity)) for k in range(count)]


def seconds(call: Callable[[], Any]) -> tuple[float, float]:
    """Return the elapsed time and the processor time of a call in seconds."""
    wall, processor = time.perf_counter(), time.process_time()
    call()
    return time.perf_counter() - wall, time.process_time() - processor


def compare(methods: dict[str, Callable[[int], Any]], parts: int, repeats: int) -> dict[str, tuple[float, float]]:
    """Return the shortest times of each method, summed over the parts."""
    total = {name: np.zeros(2) for name in methods}
    for part in range(parts):
        best = {name: np.full(2, np.inf) for name in methods}
        for _ in range(repeats):
            for name, method in methods.items():
                best[name] = np.minimum(best[name], seconds(partial(method, part)))
        for name, times in best.items():
            total[name] += times
    return {name: (times[0], times[1]) for name, times in total.items()}


def table(title: str, results: dict[str, tuple[float, float]], count: int) -> None:
    """Print the runs per second and the ratios to the first method."""
    print(f"\n{title:<44}{'wall s':>9}{'processor s':>13}{'runs/s':>9}{'ratio':>8}")
    first = next(iter(results.values()))[0]
    for name, (wall, processor) in results.items():
        print(f"  {name:<42}{wall:9.2f}{processor:13.2f}{count / wall:9.3g}{first / wall:8.3f}")


def by_fullbody(batch_members: list[Member], days: float, size: int, repeats: int) -> dict[str, tuple[float, float]]:
    """Return the members run in a loop, on one thread, and on two threads."""
    parts = [batch_members[k : k + size] for k in range(0, len(batch_members), size)]
    until = days * DAY

    def batch(part: int, threads: int) -> Any:
        return fullbody.integrate_many(parts[part], until, output="ends", threads=threads)

    methods: dict[str, Callable[[int], Any]] = {
        "a loop of single runs": lambda k: [s.integrate(start, until, output="ends") for s, start in parts[k]],
        "integrate_many, one thread": lambda k: batch(k, 1),
        "integrate_many, two threads": lambda k: batch(k, 2),
    }
    return compare(methods, len(parts), repeats)


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
        methods = {}
        for number, name in ((1, "one process"), (2, "two processes")):
            pool = ProcessPoolExecutor(number)
            list(pool.map(by_rebound, [(0, 1.0, orbit())] * number))
            methods[f"rebound (IAS15), {name}"] = lambda _, pool=pool: list(
                pool.map(by_rebound, [(k, until, orbit()) for k in range(count)])
            )
        return compare(methods, 1, repeats)
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

    return compare({f"heyoka, {n} thread{'s' * (n > 1)}": lambda _, n=n: propagate(n) for n in (1, 2)}, 1, repeats)


def short(count: int, days: float, threads: int) -> None:
    """Print the time and the memory of many short runs, in a process that does nothing else."""
    system, state = fullbody.systems.didymos()
    until = days * DAY

    def sample() -> Any:
        rng = np.random.default_rng(1)
        for _ in range(count):
            yield system, state.rotated("Dimorphos", [0, 0, 1], 0.3 * rng.random())

    # The overhead of integrate_many per member does not depend on the length of its run, and shows best for short runs.
    few_members = [member for _, member in zip(range(count // 20), sample(), strict=False)]
    described = fullbody.Verner98()._describe(system.context.units)
    start = _core.Simulation

    def single_runs(until: float) -> None:
        for system, state in few_members:
            single = start(system.context.core, state.in_units(system.context.units), described, "{}")
            single.integrate(until, "ends", [], False, None, None, (None, False))

    def one_call(until: float) -> None:
        fullbody.integrate_many(few_members, until, output="ends", threads=1)

    calls = (partial(single_runs, until), partial(single_runs, 0.01), partial(one_call, 0.01))
    times = [[seconds(call)[1] / len(few_members) for call in calls] for _ in range(10)]
    core, short_alone, short_together = (min(column) for column in zip(*times, strict=True))
    overhead = short_together - short_alone
    runs: list[Any] = []
    usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wall, used = seconds(lambda: runs.extend(fullbody.integrate_many(sample(), until, output="ends", threads=threads)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    size = sum(values.nbytes for run in runs for values in run.arrays.values())
    print(f"\n{count} runs of {days:g} days on {threads} threads: {wall:.1f} s, {count / wall:.0f} a second")
    print(f"  of the processor {used:.1f} s, {1e3 * core:.2f} ms a run of integration alone and")
    print(f"  {1e6 * overhead:.0f} microseconds a run more, {100 * overhead / (core + overhead):.1f} %")
    print(f"  memory at most {peak / 1024:.0f} MiB, {usage / 1024:.0f} MiB before; {size / 2**20:.1f} MiB of samples")


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
    results = by_fullbody(members(arguments.members), arguments.days, arguments.slice, arguments.repeats)
    table(f"{arguments.members} members, {arguments.days:g} days of Dimorphos", results, arguments.members)
    results = by_fullbody(points(arguments.members), arguments.days, arguments.slice, arguments.repeats)
    table(f"{arguments.members} members, {arguments.days:g} days, points", results, arguments.members)
    results = peers(arguments.members, arguments.days, arguments.repeats)
    table("the same by another program", results, arguments.members)
    words = ["--only-short", f"--short={arguments.short}", f"--short-days={arguments.short_days}"]
    subprocess.run([sys.executable, __file__, *words], check=True)


if __name__ == "__main__":
    main()
