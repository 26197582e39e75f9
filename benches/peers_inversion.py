"""Measure the inversion of Hertha's light curves beside that of convexinv, in the same run.

    python benches/peers_inversion.py [path of convexinv]

Both fit the thirty curves of nights from the pole (272, 52) degrees and the period 8.4006 h, and from the mirror pole,
with a series of degree 6. Convexinv (Kaasalainen & Durech, of the database DAMIT) takes 50 iterations, as in its own
example, and 512 triangles; without its path only the fit of this package is measured. It writes no standard errors.
Times are those of the processor.
"""

import os

os.environ["RAYON_NUM_THREADS"] = "1"
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import astropy.units as u
import fullbody
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from reproduction.hertha.model import PATH, SPARSE, Curves, parameters, setup

POLES, PERIOD = ((272.0, 52.0), (92.0, 52.0)), 8.4006
#: The input of convexinv: pole, period, JD and angle zero, weight of convexity, degree and order, rows of triangles,
#: parameters of the phase function and Lambert's factor, all fixed, and the number of iterations.
INPUT = """{} 1
{} 1
{} 1
2443845
0
0.1
6 6
8
0.5 0
0.1 0
-0.5 0
0.1 0
50
"""


def nights():
    """Return the curves of nights as the text that convexinv reads."""
    lines = PATH.read_text().splitlines()
    curves, first = [], 1
    while first < len(lines) and lines[first].split():
        count = int(lines[first].split()[0])
        rows = lines[first : first + 1 + count]
        if float(rows[-1].split()[0]) - float(rows[1].split()[0]) < SPARSE:
            curves += rows
        first += 1 + count
    total = sum(len(row.split()) == 2 for row in curves)
    return "\n".join([str(total), *curves]) + "\n"


def convexinv(program, text, pole):
    """Run convexinv, and return its processor time and the last two lines about its fit."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        (path / "input").write_text(INPUT.format(*pole, PERIOD))
        start = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [program, "-v", "-o", "areas", "input", "curves"]
        process = subprocess.run(command, input=text, cwd=path, capture_output=True, text=True, check=True)
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
    printed = [line for line in (process.stdout + process.stderr).splitlines() if line.strip()]
    summary = [line.strip() for line in printed if "dev" in line][-1:]
    summary += [line.strip() for line in printed if "lambda, beta and period" in line][-1:]
    return end.ru_utime - start.ru_utime, "; ".join(summary)


def inverted(data, pole):
    """Fit from a pole, and return the processor time and a summary of the fit."""
    longitude, latitude = pole * u.deg
    started = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        start = parameters(PERIOD * u.h, longitude, latitude)
        fit = fullbody.fit(setup, start, [data, fullbody.fitting.closure("Hertha")])
    seconds = time.process_time() - started
    rms = float(np.sqrt(np.mean(np.square(fit.residuals[0]))))
    minima = ", ".join(
        f"({minimum.values['longitude'].value % 360:.2f}, {minimum.values['latitude'].value:.2f}) at "
        f"{minimum.values['period'].value:.7f} h with chi2 {minimum.chi2:.0f}"
        for minimum in fit.minima
    )
    return seconds, f"rms {rms:.4f} mag, {fit.iterations} iterations of the best; {minima}"


def main():
    """Print the lines."""
    data = Curves().nights
    print(f"{len(data)} magnitudes of {len(data.nights)} nights, degree 6")
    seconds, summary = inverted(data, POLES[0])
    print(f"fullbody, both poles, with the covariance: {seconds:.1f} s; {summary}")
    if len(sys.argv) > 1:
        text = nights()
        for pole in POLES:
            seconds, summary = convexinv(str(Path(sys.argv[1]).resolve()), text, pole)
            print(f"convexinv from {pole}: {seconds:.1f} s; {summary}")


if __name__ == "__main__":
    main()
