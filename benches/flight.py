"""Particles in 1999 KW4: a flight, compared with an integration by scipy.

The integration by scipy takes the continuous solution of the run, the field of each body at all particles, and DOP853
with all particles in one vector. Errors are distances at the end from a flight at 1e-14; the
flight's tolerance is the largest power of ten with no larger error.
"""

import argparse
import resource
import time

import fullbody
import numpy as np
from scipy.integrate import solve_ivp


def particles(count, nearest=1.5, seed=1):
    """Return particles on circles of all inclinations, 1.5 to 8 km from the barycentre."""
    random = np.random.default_rng(seed)
    x = random.normal(size=(count, 3))
    x *= random.uniform(nearest, 8.0, count)[:, None] / np.linalg.norm(x, axis=1)[:, None]
    direction = np.cross(x, random.normal(size=(count, 3)))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    speed = np.sqrt(2.488e12 * 8.64960768e-13 / np.linalg.norm(x, axis=1))
    return x, direction * speed[:, None]


def by_scipy(run, x, v, until, rtol):
    """Return positions at the end, by the dense run, ``Body.gravity`` and DOP853."""
    bodies, G = run.system.bodies, run.system.G

    def rate(time, y):
        x, v = y.reshape(2, -1, 3)
        state, g = run(time), np.zeros_like(x)
        for k, body in enumerate(bodies):
            rotation = state.rotation_matrix[k]
            g += body.gravity((x - state.position[k]) @ rotation, G).field @ rotation.T
        return np.concatenate([v, g]).ravel()

    start = np.concatenate([x, v]).ravel()
    return solve_ivp(rate, (0.0, until), start, "DOP853", rtol=rtol, atol=rtol).y[:, -1].reshape(2, -1, 3)[0]


def timed(call):
    """Return the result of a call, its elapsed time and its processor time in seconds."""
    clock, cpu = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF).ru_utime
    result = call()
    return result, time.perf_counter() - clock, resource.getrusage(resource.RUSAGE_SELF).ru_utime - cpu


def main():
    """Print the comparison, and what a million particles take."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--particles", type=int, default=200)
    parser.add_argument("--hours", type=float, default=72.0)
    parser.add_argument(
        "--million", action="store_true", help="also a million particles, of which only the fates are recorded"
    )
    arguments = parser.parse_args()
    system, state = fullbody.systems.kw4()
    run = system.integrate(state, arguments.hours, output=[], dense=True)
    x, v = particles(arguments.particles)
    cloud = fullbody.Particles(x, v)

    def fly(rtol, threads=1):
        pair = fullbody.Verner98(rtol=rtol, atol=rtol)
        return run.fly(cloud, output="ends", integrator=pair, threads=threads)

    exact = fly(1e-14)
    free = exact.fate == "flying"
    print(f"{free.sum()} of {arguments.particles} particles fly for {arguments.hours:g} h")
    for rtol in (1e-8, 1e-10):
        reference, clock, cpu = timed(lambda rtol=rtol: by_scipy(run, x[free], v[free], arguments.hours, rtol))
        error = np.abs(reference - exact.position[-1, free]).max()
        print(f"scipy    rtol {rtol:.0e}: error {error:.1e} km, {clock:7.3f} s, processor {cpu:7.3f} s")
        for tolerance in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12):
            flight, flight_clock, flight_cpu = timed(lambda tolerance=tolerance: fly(tolerance))
            flight_error = np.abs(flight.position[-1, free] - exact.position[-1, free]).max()
            if flight_error <= error:
                break
        print(
            f"flight   rtol {tolerance:.0e}: error {flight_error:.1e} km, {flight_clock:7.3f} s, "
            f"processor {flight_cpu:7.3f} s"
        )
        print(f"         {cpu / flight_cpu:.0f} times quicker on one thread")
    if arguments.million:
        x, v = particles(1_000_000, nearest=4.0)
        start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        flight, clock, cpu = timed(lambda: system.fly(state, fullbody.Particles(x, v), 2.0))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        memory = f"{peak / 2**20:.2f} GiB at most, {start / 2**20:.2f} before"
        print(f"{flight}\n  {clock:.1f} s, processor {cpu:.1f} s, {memory}")


if __name__ == "__main__":
    main()
