"""CPU time of a year of 1999 KW4 by the symplectic splitting, beside a year by Verner98 in the same process.

    python benches/splitting.py

Only ratios can be compared, since machines differ and are shared. In version 0.2.0 the splitting took 0.62 (ellipsoids)
and 0.34 (spheroids) of a year by the Verner98 of that version. Free rotations are now computed side by side, triaxial
ones in closed form, and a kick takes no root for the Kepler motion: 0.27 and 0.43 of that time.
"""

from __future__ import annotations

import time

import fullbody

STEP, YEAR, REPEATS = 0.365, 8766.0, 5


def year(shape: str, integrator: object) -> tuple[float, int, float]:
    """Return the CPU time in seconds, the evaluations of the forces, and the error of the orbit's energy at the end."""
    system, state = fullbody.systems.kw4_ho2021(shape)
    started = time.process_time()
    run = system.integrate(state, YEAR, output="ends", integrator=integrator)
    return time.process_time() - started, run.statistics.evaluations, abs(run.energy_drift_orbital[-1])


def main() -> None:
    """Print the table."""
    integrators = {"Verner98()": fullbody.Verner98(), "splitting": fullbody.SymplecticSplitting(step=STEP)}
    cases = [(shape, name) for shape in ("ellipsoid", "spheroid") for name in integrators]
    # The cases alternate, so that a load of the machine affects all of them.
    results = {case: [] for case in cases}
    for _ in range(REPEATS):
        for shape, name in cases:
            results[shape, name].append(year(shape, integrators[name]))
    unit = min(results["ellipsoid", "Verner98()"])[0]
    print(f"a year of 1999 KW4; steps of the splitting of {STEP} h, ABA864")
    print(f"  {'':<12}{'':<14}{'s CPU':>8}{'ratio':>8}{'evaluations':>13}{'us each':>9}{'energy':>10}")
    for shape, name in cases:
        seconds, evaluations, error = min(results[shape, name])
        cost = seconds / evaluations * 1e6
        print(f"  {shape:<12}{name:<14}{seconds:8.3f}{seconds / unit:8.3f}{evaluations:13}{cost:9.3f}{error:10.1e}")


if __name__ == "__main__":
    main()
