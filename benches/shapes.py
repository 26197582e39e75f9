"""Measure the cost of an iteration of a fit of a free-form shape to light, and that of Minkowski's problem.

    python benches/shapes.py [rounds]

A body alone is seen at 1,300 times, and its shape has 48 coefficients of degrees 1 to 6. An iteration takes a run, the
light and its derivatives, and the setup twice for each parameter. Times are those of the processor, medians.
"""

import statistics
import sys
import time

import fullbody
import numpy as np
from fullbody import observing
from fullbody.base import rotations
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem

ROUNDS = int(sys.argv[1]) if len(sys.argv) > 1 else 5
COUNT, HOURS, PERIOD = 1300, 600.0, 6.0


def setup_of(kind):
    """Return the setup of a body of a shape of this kind."""

    def setup(coefficients, period):
        body = fullbody.Body(kind([0.0, *coefficients], degree=6), mass=1.0)
        frame = body.working_frame
        spin = 2 * np.pi / period * rotations.matrices(frame.attitude)[:, 2]
        attitude = rotations.inverse(frame.attitude)
        return fullbody.System([body], G=1.0), fullbody.State(
            [[0.0] * 3], [[0.0] * 3], spin=[spin], attitude=[attitude]
        )

    return setup


def measured(call, *arguments):
    """Return the median processor time of a call in ms, after one call that is not counted."""
    call(*arguments)
    times = []
    for _ in range(ROUNDS):
        started = time.process_time()
        call(*arguments)
        times.append(1e3 * (time.process_time() - started))
    return statistics.median(times)


def main():
    """Print the table."""
    angle = np.linspace(0.0, 2 * np.pi, 100)
    earth = 1e6 * np.stack([np.cos(angle), np.sin(angle), 0.5 * np.sin(2 * angle)], axis=1)
    sun = 1e6 * np.stack([np.cos(angle + 0.4), np.sin(angle + 0.4), 0.3 * np.cos(angle)], axis=1)
    ends = np.linspace(0.0, HOURS, 100)
    view = observing.Geometry(ends, to_observer=earth, to_sun=sun, light_time=False)
    times = np.sort(np.random.default_rng(1).uniform(0.0, HOURS, COUNT))
    data = observing.Photometry(times, np.zeros(COUNT), 0.01, geometry=view)
    degrees = np.floor(np.sqrt(np.arange(1, 49) + 0.5))
    start = np.where(degrees > 1, 0.1 * np.random.default_rng(2).normal(size=48) / (1 + degrees), 0.0)
    start[[5, 7]] = -0.1, 0.1
    for kind in (fullbody.ConvexShape, fullbody.HarmonicShape):
        problem = Problem(setup_of(kind), Parameters({"coefficients": start, "period": PERIOD}), data, None)
        values = problem.parameters.start
        light, jacobian = measured(problem.point, values), measured(problem.jacobian, problem.point(values))
        print(f"{kind.__name__}: {light:.0f} ms for the run and the light, {jacobian:.0f} ms for the derivatives")
    shape = fullbody.ConvexShape([0.0, *start])
    print(f"Minkowski's problem for {len(shape.normals)} facets: {measured(shape.polyhedron):.0f} ms")


if __name__ == "__main__":
    main()
