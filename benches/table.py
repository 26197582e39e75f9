"""Speed beside the same surface integrals written with numpy and scipy.special, in the same run.

    python benches/table.py

Prints, for the paper's 1999 KW4, the time of one interaction by method and vector path, the same integrals in numpy
over the same nodes, right-hand sides a second within a run, and the CPU time of a year. Only ratios can be compared,
since machines differ and are shared.
"""

from __future__ import annotations

import argparse
import subprocess
import time
from collections.abc import Callable

import fullbody
import numpy as np
from scipy.special import ellipeinc, ellipkinc, roots_legendre

PROGRAM = ("target", "release", "examples", "interaction")


def interaction(method: str, tolerance: float, path: str, count: int, repeats: int) -> tuple[int, float]:
    """Return the nodes and the shortest time of an interaction of the rotated bodies, 2.5 km apart, seconds."""
    command = ["/".join(PROGRAM), method, str(tolerance), path, str(count)]
    printed = [subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(repeats)]
    rows = [line.split() for line in printed]
    return int(rows[0][0]), min(float(seconds) for _, seconds in rows)


def best(call: Callable[[], object], repeats: int, number: int) -> float:
    """Return the shortest time per call, seconds."""
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        for _ in range(number):
            call()
        times.append((time.perf_counter() - started) / number)
    return min(times)


def potential(semi_axes: tuple[float, float, float], x: np.ndarray) -> np.ndarray:
    """Return MacMillan's exterior potential of unit GM, the paper's eq:Potential_elliptic, for a > b > c."""
    a, b, c = semi_axes
    a2, b2, c2 = a * a, b * b, c * c
    x2, y2, z2 = x[0] ** 2, x[1] ** 2, x[2] ** 2
    r2 = x2 + y2 + z2
    kappa = r2 - (a2 * x2 + b2 * y2 + c2 * z2) / r2
    for _ in range(4):
        s = x2 / (a2 + kappa) + y2 / (b2 + kappa) + z2 / (c2 + kappa)
        slope = x2 / (a2 + kappa) ** 2 + y2 / (b2 + kappa) ** 2 + z2 / (c2 + kappa) ** 2
        kappa += s * (s - 1) / slope
    omega = np.arcsin(np.sqrt((a2 - c2) / (a2 + kappa)))
    m = (a2 - b2) / (a2 - c2)
    first, second = ellipkinc(omega, m), ellipeinc(omega, m)
    root = np.sqrt((a2 - c2) / ((a2 + kappa) * (b2 + kappa) * (c2 + kappa)))
    bracket = (
        (1 - (x2 - y2) / (a2 - b2)) * first
        + (x2 / (a2 - b2) - (a2 - c2) * y2 / ((a2 - b2) * (b2 - c2)) + z2 / (b2 - c2)) * second
        + ((c2 + kappa) * y2 - (b2 + kappa) * z2) / (b2 - c2) * root
    )
    return 1.5 / np.sqrt(a2 - c2) * bracket


class NumpySurface:
    """The paper's Eqs. (2) and (3) over the surface of a body in the potential of another one, vectorised."""

    def __init__(
        self, axes: tuple[float, float, float], other: tuple[float, float, float], order: tuple[int, int]
    ) -> None:
        n, m = order
        z, weights = roots_legendre(n)
        alpha = 2 * np.pi * (np.arange(m) + 0.5) / m
        z, alpha = (grid.ravel() for grid in np.meshgrid(z, alpha, indexing="ij"))
        a, b, c = axes
        ring = np.sqrt(1 - z**2)
        self.y = np.array([a * ring * np.cos(alpha), b * ring * np.sin(alpha), c * z])
        weight = np.repeat(weights, m) * 2 * np.pi / m * 3 / (4 * np.pi * a * b * c)
        normal = np.array([b * c * ring * np.cos(alpha), a * c * ring * np.sin(alpha), a * b * z])
        self.normal = normal * weight
        self.lever = np.cross(self.y, normal, axis=0) * weight
        self.other = other

    def __call__(
        self, origin: np.ndarray, rotation: np.ndarray, rotation_other: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the force (inertial) and torque (body frame) on the body, at ``origin`` from the other body."""
        x = rotation_other.T @ (rotation @ self.y + origin[:, None])
        phi = potential(self.other, x)
        return rotation @ (self.normal @ phi), self.lever @ phi


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer repeats, a month instead of a year")
    quick = parser.parse_args().quick
    repeats = 3 if quick else 7

    system, state = fullbody.systems.kw4_ho2021(gravity="surface", gravity_tolerance=1e-13)
    sim = fullbody.Simulation(system, state)
    sim.step()
    rule = sim.quadrature[0]
    rotation = state.rotation_matrix
    axes = [body.shape.semi_axes for body in system.bodies]
    reference = NumpySurface(axes[1], axes[0], rule["order"])
    origin = state.position[1] - state.position[0]
    force, _ = reference(origin, rotation[1], rotation[0])
    strength = system.G * system.masses.prod()
    interactions = system.interactions(state)
    difference = np.linalg.norm(force * strength - interactions.force[1]) / np.linalg.norm(interactions.force[1])
    numpy_time = best(lambda: reference(origin, rotation[1], rotation[0]), repeats, 20 if quick else 200)
    print(f"same surface integrals in numpy and scipy.special, {rule['points']} nodes {rule['order']}:")
    print(f"  {numpy_time * 1e6:10.2f} us; the forces differ by {difference:.1e}, relative")

    # The core is timed by a program in Rust.
    build = ["cargo", "build", "--quiet", "--release", "--example", PROGRAM[-1]]
    subprocess.run(build, check=True)
    print("\ntime of one interaction (force and both torques), within the core")
    print(f"  {'method':<14}{'tolerance':>10}{'path':>10}{'nodes':>7}{'us':>10}{'numpy / this':>14}")
    cases = [("focal", t) for t in (1e-14, 1e-13, 1e-10, 1e-6)] + [("surface", t) for t in (1e-13, 1e-10)]
    cases += [(f"multipole:{n}", 1e-13) for n in (2, 4, 6, 8)] + [("point", 1e-13)]
    for method, tolerance in cases:
        for path in fullbody.vector_paths() if method in ("focal", "surface") else ["auto"]:
            nodes, seconds = interaction(method, tolerance, path, 2000 if quick else 20000, repeats)
            ratio = numpy_time / seconds
            print(f"  {method:<14}{tolerance:>10.0e}{path:>10}{nodes:>7}{seconds * 1e6:>10.3f}{ratio:>14.0f}")

    hours = 730.5 if quick else 8766.0
    print(f"\n1999 KW4, ellipsoids, {hours:g} h at rtol 1e-13, output at the end only")
    for method in ("focal", "surface"):
        system, state = fullbody.systems.kw4_ho2021(gravity=method)
        started = time.process_time()
        run = system.integrate(state, hours, output=[hours])
        seconds = time.process_time() - started
        evaluations = run.statistics.evaluations
        print(
            f"  {method:<10}{seconds:8.2f} s CPU, {evaluations} right-hand sides, "
            f"{evaluations / seconds / 1e6:.2f} million a second; numpy would take "
            f"{numpy_time * evaluations / seconds:.0f} times as long for its integrals alone"
        )


if __name__ == "__main__":
    main()
