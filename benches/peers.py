"""Measure GUBAS and F2BPtoolkit beside fullbody on the radar shapes of 1999 KW4: error of the force, processor time.

    python benches/peers.py [--gubas FOLDER/hou_cpp_final] [--f2bptoolkit FOLDER] [--flags TEXT] [--out FILE]

GUBAS is a program that its user has compiled; F2BPtoolkit is the folder of a clone in which its extension module has
been built. Without them fullbody alone is measured. Both truncate the mutual potential at a total degree, their order.
The force of a peer is the velocity that it gives to bodies that start at rest, after ten seconds. All errors are
relative to the force by the integrals over faces. The time is that of a thousand hours by the Runge-Kutta pair of each
program at the tolerance 1e-12, without the preparation of the shapes.
"""

from __future__ import annotations

import argparse
import contextlib
import datetime
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Each program has one thread, also in its linear algebra.
os.environ["RAYON_NUM_THREADS"] = "1"
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import fullbody
import numpy as np
from fullbody.base import rotations

HOUR, TOLERANCE = 3600.0, 1e-12
#: The seconds for which bodies at rest fall, and the seconds that are integrated at each order of a peer.
FALL = 10.0
SPANS = {2: 20000.0, 4: 5000.0, 8: 300.0}
#: The number of evaluations of the forces in a step of the peers' Runge-Kutta pair.
STAGES = 13
DEGREES = (2, 3, 4, 6, 8, 12, 16, 20)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)

#: A peer: the times (K,) and states (K, 30) of a run from a state over some seconds, and its processor time.
Peer = Callable[[int, np.ndarray, float], tuple[np.ndarray, np.ndarray, float]]

system, start = fullbody.systems.kw4(shape="radar")
resting = fullbody.State(start.position, np.zeros((2, 3)), attitude=start.attitude, spin=np.zeros((2, 3)))
G = system.G / HOUR**2


def tables(folder: Path) -> None:
    """Write the shapes in their body frames, in metres, with vertices numbered from one."""
    for name, body in zip("AB", system.bodies, strict=True):
        frame = body.working_frame
        points = body.shape.vertices @ rotations.matrices(frame.attitude).T + frame.position
        rows = [f"{k},{x!r},{y!r},{z!r}\n" for k, (x, y, z) in enumerate((1000.0 * points).tolist(), 1)]
        (folder / f"vertices{name}.csv").write_text("".join(rows))
        (folder / f"faces{name}.csv").write_text("".join(f"{a},{b},{c}\n" for a, b, c in (body.shape.faces + 1)))


def numbers(state: fullbody.State) -> np.ndarray:
    """Return the 30 numbers of the peers' state in km and s.

    Separation, relative velocity and both spins are along the axes of the first body; then follow the rotations of the
    first body into the inertial frame and of the second into the first.
    """
    first, second = state.rotation_matrix
    vectors = [np.diff(state.position, axis=0)[0], np.diff(state.velocity, axis=0)[0] / HOUR]
    vectors += [first @ state.spin[0] / HOUR, second @ state.spin[1] / HOUR]
    return np.concatenate([*(first.T @ vector for vector in vectors), first.ravel(), (first.T @ second).ravel()])


def gubas(program: Path, folder: Path) -> Peer:
    """Return a function that runs GUBAS, which reads ``ic_input.txt`` and writes binary files in its folder."""
    tables(folder)

    def run(order: int, state: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray, float]:
        # The integrals of the shapes are computed once for each order, by a run without an integrator.
        if not (folder / f"TDP_{order}.mat").exists():
            call(order, state, seconds, 1, 0)
        cpu_time = call(order, state, seconds, 0, 3)
        states = np.fromfile(folder / "output_x" / "x_out.bin").reshape(-1, 30)
        return np.fromfile(folder / "output_t" / "t_out.bin"), states, cpu_time

    def call(order: int, state: np.ndarray, seconds: float, fresh: int, integrator: int) -> float:
        files = ["facesA.csv", "verticesA.csv", "facesB.csv", "verticesB.csv"]
        shapes = [*[0.0] * 6, 2, 2, *(body.density for body in system.bodies)]
        # A planet, the Sun and tides are switched off, but the input needs their orbits, masses and constants.
        switched_off = [
            0,
            0,
            0,
            0,
            0.0,
            -1e6,
            1.5,
            0.0,
            0.0,
            0.0,
            0.0,
            1e30,
            1e8,
            *[0.0] * 5,
            1.0,
            1e8,
            0.0,
            0.0,
            1.0,
            1.0,
        ]
        lines = [G, order, order, order, *shapes, 0.0, seconds, *["-"] * 4, *files, *state.tolist()]
        lines += [fresh, integrator, 1.0, TOLERANCE, *switched_off, 0.0, 0.0, 1e30]
        (folder / "ic_input.txt").write_text("".join(f"{line}\n" for line in lines))
        started = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([program.resolve()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
        return ended.ru_utime + ended.ru_stime - started.ru_utime - started.ru_stime

    return run


def f2bptoolkit(package: Path, folder: Path) -> Peer:
    """Return a function that runs F2BPtoolkit by its Python interface."""
    sys.path.append(str(package))
    import f2bptoolkit as peer

    tables(folder)

    def run(order: int, state: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray, float]:
        simulation = peer.Simulation(G=G * 1e9)
        simulation.gravity_order = order
        for name, body in zip("AB", system.bodies, strict=True):
            twin = peer.Body(body.name)
            twin.shape = peer.PolyhedronShape(str(folder / f"vertices{name}.csv"), str(folder / f"faces{name}.csv"))
            twin.density = body.density / 1e9
            simulation.add(twin)
        # The program takes the second spin along the axes of the first body, contrary to its documentation.
        simulation.set_state(
            1000.0 * state[:3],
            1000.0 * state[3:6],
            state[6:9],
            state[9:12],
            A_to_N=state[12:21].reshape(3, 3),
            B_to_A=state[21:].reshape(3, 3),
        )
        started = time.process_time()
        result = simulation.integrate(seconds, integrator=peer.RK87(TOLERANCE))
        cpu_time = time.process_time() - started
        states = np.zeros((len(result.times), 30))
        states[:, :3], states[:, 3:6] = result.position / 1000.0, result.velocity / 1000.0
        states[:, 12:21] = result.A_to_N.reshape(-1, 9)
        return result.times, states, cpu_time

    return run


def inertial(state: np.ndarray, components: slice) -> np.ndarray:
    """Return a vector of a peer's state in the inertial frame."""
    return state[12:21].reshape(3, 3) @ state[components]


def peer_rows(name: str, run: Peer) -> list[dict[str, Any]]:
    """Measure a peer at each order; for lower orders, whose runs are short, the fastest of three counts."""

    def fastest(order: int, state: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray, float]:
        return min((run(order, state, seconds) for _ in range(3 if order < 8 else 1)), key=lambda result: result[2])

    rows: list[dict[str, Any]] = []
    tightest = fullbody.Verner98(1e-15, 1e-15)
    fall = system.with_options(gravity="surface").integrate(resting, FALL / HOUR, integrator=tightest)[-1]
    exact = np.diff(fall.velocity, axis=0)[0] / HOUR
    steps_per_hour = np.nan
    for order, span in SPANS.items():
        # The difference between the two runs contains neither the preparation of the shapes nor the first steps.
        fall_times, fallen, preparation = fastest(order, numbers(resting), FALL)
        times, states, cpu_time = fastest(order, numbers(start), span)
        row: dict[str, Any] = {"program": name, "order": order}
        row["force_error"] = error(inertial(fallen[-1], slice(3, 6)), exact)
        steps = len(times) - len(fall_times)
        seconds = (cpu_time - preparation) / (STAGES * steps)
        row["microseconds"] = 1e6 * seconds
        # The run of the highest order has too few steps to count; their rate is that of the order below.
        if order < 8:
            steps_per_hour = steps / (span - FALL) * HOUR
            series = system.with_options(gravity=f"multipole:{order}")
            end = series.integrate(start, span / HOUR, integrator=tightest)[-1]
            difference = inertial(states[-1], slice(0, 3)) - np.diff(end.position, axis=0)[0]
            row["integration_error_km"] = float(np.linalg.norm(difference))
        row["seconds_per_1000_hours"] = seconds * STAGES * steps_per_hour * 1000.0
        rows.append(row)
        print_row(row)
    return rows


def error(vector: np.ndarray, exact: np.ndarray) -> float:
    """Return the relative error of a vector."""
    return float(np.linalg.norm(vector - exact) / np.linalg.norm(exact))


def fullbody_rows(hours: float, repeats: int) -> list[dict[str, Any]]:
    """Measure fullbody's series to total degrees, and its exact harmonic rule at tolerances."""
    faces = system.with_options(gravity="surface", gravity_tolerance=1e-14).interactions(start).force[1]
    cases = [(f"multipole:{n}", 1e-14, n) for n in DEGREES] + [("harmonic", t, None) for t in TOLERANCES]
    rows = []
    for gravity, tolerance, order in cases:
        case = system.with_options(gravity=gravity, gravity_tolerance=tolerance)
        row = {"program": "fullbody", "gravity": gravity, "tolerance": tolerance, "order": order}
        row["force_error"] = error(case.interactions(start).force[1], faces)
        times, evaluations = [], 0
        for _ in range(repeats):
            started = time.process_time()
            run = case.integrate(start, hours, output=[hours], integrator=fullbody.Verner98(TOLERANCE, TOLERANCE))
            times.append(time.process_time() - started)
            evaluations = run.statistics.evaluations
        row["microseconds"] = 1e6 * min(times) / evaluations
        row["seconds_per_1000_hours"] = min(times) / hours * 1000.0
        rows.append(row)
        print_row(row)
    return rows


def print_row(row: dict[str, Any]) -> None:
    """Print a row of the table."""
    gravity = row.get("gravity") or f"order {row['order']}"
    if gravity == "harmonic":
        gravity += f" {row['tolerance']:.0e}"
    values = f"{row['force_error']:12.1e}{row['microseconds']:14.2f}{row['seconds_per_1000_hours']:14.2f}"
    print(f"{row['program']:<13}{gravity:<16}{values}", flush=True)


def commit(path: Path) -> str | None:
    """Return the commit of a clone of a repository."""
    call = ["git", "-C", str(path if path.is_dir() else path.parent), "rev-parse", "--short", "HEAD"]
    result = subprocess.run(call, capture_output=True, text=True, check=False)
    return result.stdout.strip() or None


def processor() -> str:
    """Return the name of the processor."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()


def main() -> None:
    """Print the table and write it as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gubas", type=Path, help="the compiled program hou_cpp_final")
    parser.add_argument("--f2bptoolkit", type=Path, help="the clone with the built extension")
    parser.add_argument("--flags", default="not stated", help="the compiler and flags of the peers, for the record")
    parser.add_argument("--hours", type=float, default=200.0, help="hours of fullbody's runs")
    parser.add_argument("--out", type=Path, help="the JSON file for the numbers")
    options = parser.parse_args()
    # Arguments that cannot be measured or written are refused before minutes of measurement.
    if not 0.0 < options.hours < np.inf:
        parser.error(f"--hours is {options.hours}; expected a number above zero")
    for name, path in (("gubas", options.gubas), ("f2bptoolkit", options.f2bptoolkit), ("out", options.out)):
        if path is not None and not (path.parent if name == "out" else path).exists():
            parser.error(f"--{name} is {path}; expected a path that exists")
    print(f"{'':<29}{'force error':>12}{'us/evaluation':>14}{'s/1000 h':>14}")
    rows = fullbody_rows(options.hours, 3)
    peers: dict[str, dict[str, str | None]] = {}
    for name, path, peer in (("GUBAS", options.gubas, gubas), ("F2BPtoolkit", options.f2bptoolkit, f2bptoolkit)):
        if path is not None:
            peers[name] = {"commit": commit(path), "built_by": options.flags}
            with tempfile.TemporaryDirectory() as folder:
                rows += peer_rows(name, peer(path, Path(folder)))
    if options.out is not None:
        about = {
            "measured": datetime.date.today().isoformat(),
            "processor": processor(),
            "fullbody": fullbody.__version__,
            "peers": peers,
            "integrator_tolerance": TOLERANCE,
        }
        options.out.write_text(json.dumps({"about": about, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
