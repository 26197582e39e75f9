"""Coverage of the error bars of fits to simulated light curves of a binary with a non-convex primary and mutual events.

    python benches/coverage.py [draws]

A primary of degree 4 with hollows and a spherical satellite are observed for three revolutions. For each draw of
noise a fit finds the satellite's radius, the mass, the phase of the orbit and four coefficients of the shape, from
a start near the truth. The bodies attract as points, which makes the motion cheap; the light is that of the
shapes. For each parameter it prints in how many of the draws the truth is within one and 1.96 standard errors, and
the mean and the standard deviation of the error over its standard error.
"""

import sys
import time
from multiprocessing import Pool

import fullbody
import numpy as np
from fullbody import HarmonicShape, observing
from fullbody.base import rotations

G = 6.6743e-20 * 3600.0**2
#: The coefficients of degrees 0 to 4; those with the indices FREE are fitted.
SERIES = np.zeros(25)
SERIES[[6, 8, 10, 16, 20, 24]] = -0.10, 0.12, 0.06, 0.05, -0.06, 0.05
FREE = [6, 8, 16, 24]
TRUTH = {"radius": 0.0, "mass": 7.0, "phase": 0.3, "coefficients": SERIES[FREE]}
NAMES = ("radius", "mass", "phase", *(f"coefficients[{k}]" for k in range(len(FREE))))
START = {"radius": 0.02, "mass": 7.004, "phase": 0.303, "coefficients": SERIES[FREE] + 0.003}
SIGMA = 0.005
TIMES = np.sort(np.random.default_rng(3).uniform(0.0, 130.0, 240))
VIEW = observing.Geometry([-10.0, 140.0], to_observer=[1e8, 1e7, 0.5e7], to_sun=[1e8, 3e7, -0.4e7], light_time=False)


def setup(radius, mass, phase, coefficients):
    series = SERIES.copy()
    series[FREE] = coefficients
    shape = HarmonicShape(series, reference_radius=80.0, faces=320)
    body = fullbody.Body(shape, mass=mass * 1e18, name="A")
    moon = fullbody.Body(HarmonicShape([radius], reference_radius=25.0, faces=320), mass=2e17, name="B")
    system = fullbody.System([body, moon], G=G, gravity="point")
    frame = body.working_frame
    inverse = np.array(frame.attitude) * [1.0, -1.0, -1.0, -1.0]
    axis = rotations.matrices(np.array(frame.attitude)).T @ [0.0, 0.0, 1.0]
    speed = np.sqrt(G * (mass * 1e18 + 2e17) / 400.0)
    cosine, sine = np.cos(phase), np.sin(phase)
    state = fullbody.State(
        [np.zeros(3), [400.0 * cosine, 400.0 * sine, 0.0]],
        [np.zeros(3), [-speed * sine, speed * cosine, 0.0]],
        spin=[1.7 * axis, [0.0, 0.0, 0.14]],
        attitude=[inverse, [1.0, 0.0, 0.0, 0.0]],
    )
    return system, state


def magnitudes():
    """Return the magnitudes of the truth."""
    system, state = setup(**TRUTH)
    run = system.integrate(state, 131.0, dense=True)
    events = observing.mutual_events(run, VIEW)
    return observing.light_curve(run, TIMES, VIEW), len(events)


def fitted(seed):
    """Return the errors of a fit in its standard errors, chi2, and whether it converged."""
    light, _ = magnitudes()
    noisy = light + SIGMA * np.random.default_rng(seed).normal(size=len(light))
    night = np.zeros(len(TIMES), dtype=int)
    data = observing.Photometry(TIMES, noisy, SIGMA, geometry=VIEW, night=night)
    fit = fullbody.fit(setup, START, data)
    truth = np.concatenate([np.atleast_1d(TRUTH[name]) for name in START])
    value, sigma = (np.concatenate([np.atleast_1d(part[name]) for name in START]) for part in (fit.values, fit.sigma))
    return (value - truth) / sigma, fit.chi2, fit.dof


def main(draws):
    started = time.perf_counter()
    light, events = magnitudes()
    print(f"{events} events, amplitude {np.ptp(light):.3f} mag, {len(light)} magnitudes of {SIGMA} mag")
    with Pool() as pool:
        results = pool.map(fitted, range(draws), chunksize=1)
    errors = np.array([error for error, *_ in results])
    finite = np.isfinite(errors).all(axis=1)
    errors = errors[finite]
    print(f"{finite.sum()} of {draws} fits have error bars, {time.perf_counter() - started:.0f} s")
    print(f"mean chi2 {np.mean([chi2 for _, chi2, _ in results]):.1f} for {results[0][2]} degrees of freedom")
    for name, column in zip(NAMES, errors.T, strict=True):
        narrow, wide = ((np.abs(column) < k).mean() for k in (1.0, 1.96))
        print(f"{name:16}{narrow:7.1%} {wide:7.1%}   mean {column.mean():+.2f}, deviation {column.std():.2f}")
    print(f"{'all':16}{(np.abs(errors) < 1).mean():7.1%} {(np.abs(errors) < 1.96).mean():7.1%}   expected 68.3% 95.0%")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
