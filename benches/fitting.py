"""Measure the cost of an iteration of a fit relative to a run, with exact derivatives and by differences of runs.

    python benches/fitting.py [hours] [rounds]

1999 KW4 as radar observes it: ranges and range rates, 200 of each. An iteration takes a run with the transition matrix
and the sensitivities that are needed, the derivatives of all predictions, and the setup twice for each parameter.
One-sided differences take a run for each parameter beside the run itself, central ones two. Times are those of the
processor, medians over the rounds.
"""

import statistics
import sys
import time

import astropy.units as u
import fullbody
import numpy as np
from fullbody import observing
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem

HOURS = float(sys.argv[1]) if len(sys.argv) > 1 else 8766.0
ROUNDS = int(sys.argv[2]) if len(sys.argv) > 2 else 5
SYSTEM, STATE = fullbody.systems.kw4(units=True, epoch="2001-05-25 TDB")


def setup(**values):
    """Return 1999 KW4 with masses and semi-axes multiplied by factors, and attitudes rotated by angles."""
    bodies = []
    for body in SYSTEM:
        axes = [getattr(body.shape, axis) * values.get(f"{axis}_{body.name}", 1.0) for axis in "abc"]
        mass = body.mass * values.get(f"mass_{body.name}", 1.0)
        bodies.append(fullbody.Body(fullbody.Ellipsoid(*axes), mass=mass, name=body.name))
    state = STATE
    for name in ("tilt_Alpha", "tilt_Beta"):
        if name in values:
            state = state.rotated(name[5:], [1.0, 0.0, 0.0], values[name])
    return fullbody.System(bodies, units=True, epoch=SYSTEM.epoch, frame="ecliptic"), state


def main():
    """Print the table."""
    geometry = observing.Geometry([0.0, HOURS + 1.0] * u.h, to_observer=[[0.05, 0.01, 0.0], [0.04, 0.03, 0.0]] * u.au)
    times, zero = np.linspace(1.0, HOURS, 200) * u.h, np.zeros(200)
    values = {"range": zero * u.km, "range_rate": zero * u.cm / u.s, "sigma": (75 * u.m, 1 * u.cm / u.s)}
    data = observing.RadarAstrometry(times, **values, body="Beta", about="Alpha", geometry=geometry)
    factors = {f"mass_{name}": 1.0 for name in SYSTEM.names} | {"tilt_Alpha": 0.02, "tilt_Beta": 0.02}
    factors |= {f"{axis}_{name}": 1.0 for axis in "abc" for name in SYSTEM.names}
    print(f"{HOURS:g} h of 1999 KW4, Verner98 at 1e-13, {ROUNDS} rounds; an iteration over a run")
    for count in (1, 2, 4, 7, 10):
        problem = Problem(setup, Parameters(dict(list(factors.items())[:count])), data, None)
        point = problem.point(problem.parameters.start)
        # The first call chooses the step sizes of the differences.
        problem.jacobian(point)
        parts = {"run": [], "iteration": []}
        for _ in range(ROUNDS):
            start = time.process_time()
            SYSTEM.integrate(STATE, HOURS, output=data.emission(SYSTEM))
            middle = time.process_time()
            problem.jacobian(problem.point(problem.parameters.start, differentiated=True))
            parts["run"].append(middle - start)
            parts["iteration"].append(time.process_time() - middle)
        run, iteration = (statistics.median(part) for part in parts.values())
        print(
            f"{count:3} parameters: {iteration / run:5.2f} runs of {1e3 * run:.0f} ms; "
            f"differences of runs {1 + count} to {1 + 2 * count}"
        )


if __name__ == "__main__":
    main()
