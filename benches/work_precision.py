"""Measure work and precision of every integrator on the paper's 1999 KW4.

    python benches/work_precision.py [--quick] [--shape ellipsoid]

Prints evaluations of the forces, CPU time, the largest error of a position at the end against Verner98 at 1e-15, and
the largest error of the energy on the way, relative to |potential + translational energy|.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

import fullbody
import numpy as np
from fullbody.record import integrators


def family(quick: bool) -> Iterator[tuple[str, str, integrators.Integrator]]:
    """Return name, setting and integrator of each row."""
    for name in ("Verner98", "Verner87", "Verner76", "Verner65", "DormandPrince54"):
        for rtol in (1e-8, 1e-12) if quick else (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14):
            yield name, f"rtol {rtol:g}", getattr(integrators, name)(rtol, rtol)
    for scheme in ("ABA1064", "ABA864", "leapfrog"):
        for step in (0.73,) if quick else (1.46, 0.73, 0.365, 0.1825, 0.09125):
            yield scheme, f"step {step:g} h", fullbody.SymplecticSplitting(step, scheme)
    for step in (0.04,) if quick else (0.08, 0.04, 0.02, 0.01, 0.005):
        yield "LieGroupVariational", f"step {step:g} h", fullbody.LieGroupVariational(step)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="20 h and a few settings instead of 200 h and all")
    parser.add_argument("--shape", choices=("spheroid", "ellipsoid"), default="spheroid")
    options = parser.parse_args()
    hours = 20.0 if options.quick else 200.0
    system, state = fullbody.systems.kw4_ho2021(options.shape)
    tightest = fullbody.Verner98(rtol=1e-15, atol=0.0)
    expected = system.integrate(state, hours, output=[hours], integrator=tightest).position[-1]

    print(f"1999 KW4, {options.shape}s, {hours:g} h")
    print(f"  {'method':<21}{'setting':<16}{'evaluations':>11}{'CPU s':>9}{'error km':>10}{'energy':>10}")
    for name, setting, integrator in family(options.quick):
        times = []
        for _ in range(1 if options.quick else 3):
            started = time.process_time()
            run = system.integrate(state, hours, output=[hours], integrator=integrator)
            times.append(time.process_time() - started)
        error = np.linalg.norm(run.position[-1] - expected, axis=-1).max()
        drift = np.abs(system.integrate(state, hours, integrator=integrator).energy_drift_orbital).max()
        evaluations = run.statistics.evaluations
        print(f"  {name:<21}{setting:<16}{evaluations:>11}{min(times):>9.4f}{error:>10.1e}{drift:>10.1e}")


if __name__ == "__main__":
    main()
