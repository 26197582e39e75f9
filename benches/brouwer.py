"""Growth of the energy's error with the number of steps, beside REBOUND's IAS15.

    python benches/brouwer.py [--steps 1e7] [--starts 3] [--only KW4]

Truncation errors of steps add up: the error grows as their number. Round-off walks at random: the error grows as the
root of it (Brouwer 1937, Astron. J. 46, 149). Printed are steps and evaluations of the forces per orbit, the error's
root mean square over all starts and over the last half of so many steps, the exponent of its growth over the last
factor of 100, with an uncertainty where there are several starts, and the CPU time of all. The energy is measured in
doubles: of 1999 KW4, where Alpha's spin has 26 times the energy of the orbit, 5e-15 of that of the orbit and less
cannot be resolved. IAS15 has no rotation, so that it is compared for two points, whose motion the splitting solves
exactly in each step.
"""

from __future__ import annotations

import argparse
import time

import fullbody
import numpy as np
import rebound
from fullbody.record.integrators import Integrator

#: Samples in every doubling of the steps.
SAMPLES = 32
FIRST = 1000

Setup = tuple[fullbody.System, fullbody.State]
#: Steps per orbit, evaluations per orbit, and errors (octaves, SAMPLES).
Measured = tuple[float, float, np.ndarray]


def octaves(steps: float) -> np.ndarray:
    """Return the numbers of steps, doubling up to ``steps``."""
    return steps * 0.5 ** np.arange(int(np.log2(steps / FIRST)), -1, -1)


def sample_times(span: float, steps: float) -> np.ndarray:
    """Return sample times (octaves, SAMPLES) in the last half of each octave."""
    return octaves(steps)[:, np.newaxis] * (span / steps) * (1.0 - 0.5 * np.arange(SAMPLES)[::-1] / SAMPLES)


def two_points(rng: np.random.Generator) -> Setup:
    """Return two points on an orbit with a = 1, n = 1, e = 0.3 and a random orientation."""
    bodies = [fullbody.Body(fullbody.PointMass(), mass=mass) for mass in (0.7, 0.3)]
    inclination, *angles = rng.uniform(0.0, 2 * np.pi, 4)
    r, v = fullbody.KeplerElements(1.0, 0.3, 0.5 * inclination, *angles).to_cartesian(1.0)
    return fullbody.System(bodies, G=1.0), fullbody.State([-0.3 * r, 0.7 * r], [-0.3 * v, 0.7 * v])


def advanced(setup: Setup, time: float) -> Setup:
    """Return a system with the state at a time of its motion, as one at time zero."""
    system, state = setup
    return system, system.integrate(state, time, output=[time])[0].replace(time=0.0)


def case1(rng: np.random.Generator) -> Setup:
    """Return two flat spheroids close to each other, at a random time of its motion."""
    return advanced(fullbody.systems.case1(), rng.uniform(0.0, 200.0))


def kw4(rng: np.random.Generator) -> Setup:
    """Return 1999 KW4 at a random time of its first 1000 hours."""
    return advanced(fullbody.systems.kw4(), rng.uniform(0.0, 1000.0))


def by_fullbody(setup: Setup, integrator: Integrator, steps: float) -> Measured:
    """Measure a run of fullbody: the error of the energy is relative to the orbital energy."""
    system, state = setup
    r, v = (values[1] - values[0] for values in (state.position, state.velocity))
    orbit = float(fullbody.KeplerElements.from_cartesian(r, v, system.mu()).period(system.mu()))
    trial = system.integrate(state, 20.0 * orbit, output=[], integrator=integrator).statistics
    times = sample_times(20.0 * orbit * steps / trial.steps, steps)
    run = system.integrate(state, times[-1, -1], output=np.unique(times), integrator=integrator)
    drift = run.energy_drift_orbital[np.searchsorted(run.time, times)]
    return trial.steps / 20.0, trial.evaluations / 20.0, drift


def by_ias15(setup: Setup, _: object, steps: float) -> Measured:
    """Measure a run of IAS15 with its default settings."""
    system, state = setup

    def simulation() -> rebound.Simulation:
        sim = fullbody.to_rebound(system, state)
        sim.integrator = "ias15"
        return sim

    sim, count = simulation(), [0]

    def counted(_: object) -> None:
        count[0] += 1

    sim.additional_forces = counted
    duration = 40.0 * np.pi
    sim.integrate(duration, exact_finish_time=0)
    per_orbit = sim.steps_done / 20.0, count[0] / 20.0
    times = sample_times(duration * steps / sim.steps_done, steps)
    sim = simulation()
    first = sim.energy()
    errors = np.empty(times.shape)
    for index in np.argsort(times, axis=None):
        sim.integrate(times.flat[index], exact_finish_time=0)
        errors.flat[index] = (sim.energy() - first) / abs(first)
    return *per_orbit, errors


def square_mean(errors: np.ndarray) -> np.ndarray:
    """Return the root mean square (octaves,) of errors (starts, octaves, SAMPLES)."""
    return np.maximum(np.sqrt((errors**2).mean(axis=(0, 2))), 1e-17)


def exponent(errors: np.ndarray, number: np.ndarray) -> float:
    """Return the slope of the logarithm of the errors' root mean square, over the last factor of 100."""
    last = number > number[-1] / 100
    return float(np.polyfit(np.log(number[last]), np.log(square_mean(errors)[last]), 1)[0])


def growth(errors: np.ndarray, number: np.ndarray) -> str:
    """Return the exponent and its uncertainty, by leaving out one start at a time."""
    count = len(errors)
    without = [exponent(np.delete(errors, k, axis=0), number) for k in range(count)] if count > 2 else []
    error = f" +- {np.sqrt((count - 1) * np.var(without)):.2f}" if without else ""
    return f"{exponent(errors, number):.2f}{error}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=float, default=1e5, help="1e4 or more; 1e7 take a quarter of an hour a start")
    parser.add_argument("--starts", type=int, default=3, help="the number of random starts")
    parser.add_argument("--only", default="", help="tables with this in their titles")
    options = parser.parse_args()
    verners = {
        "Verner98()": fullbody.Verner98(),
        "Verner98(1e-15, 0)": fullbody.Verner98(1e-15, 0.0),
        "Verner98.to_roundoff()": fullbody.Verner98.to_roundoff(),
    }

    def splitting(step: float) -> dict[str, Integrator]:
        return {f"SymplecticSplitting({step})": fullbody.SymplecticSplitting(step)}

    tables = {
        "two points, e = 0.3": (two_points, verners | splitting(0.05) | {"IAS15": None}),
        "1999 KW4": (kw4, verners | splitting(0.1)),
        "case 1 of Ho et al. 2021": (case1, verners | splitting(0.05)),
    }
    number = octaves(options.steps)
    marks = 10.0 ** np.arange(4, np.log10(options.steps) + 1e-9)
    for title, (setup, integrators) in tables.items():
        if options.only not in title:
            continue
        print(f"\n{title}: error of the energy, relative to the orbit's, after steps")
        heads = "".join(f"{mark:>9.0e}" for mark in marks)
        print(f"  {'':<26}{'steps/orbit':>12}{'evaluations':>12}{heads}{'exponent':>15}{'CPU s':>8}")
        for name, integrator in integrators.items():
            measure = by_ias15 if integrator is None else by_fullbody
            rng = np.random.default_rng(1)
            started = time.process_time()
            starts = [measure(setup(rng), integrator, options.steps) for _ in range(options.starts)]
            seconds = time.process_time() - started
            errors = np.array([errors for *_, errors in starts])
            marked = np.exp(np.interp(np.log(marks), np.log(number), np.log(square_mean(errors))))
            row = "".join(f"{value:>9.1e}" for value in marked)
            steps, evaluations = (np.mean(values) for values in list(zip(*starts, strict=True))[:2])
            print(
                f"  {name:<26}{steps:>12.0f}{evaluations:>12.0f}{row}{growth(errors, number):>15}{seconds:>8.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
