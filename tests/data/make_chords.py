"""Compute the chords of chords.json in 40 digits, by formulas that share nothing with the package.

Run ``python tests/data/make_chords.py``, which takes a minute: it reads bodies, star, stations and geometry from the file,
and writes the chords again. Bodies move on Kepler orbits about their barycentre, and rotate about their z-axes. A double
has 16 digits, and the square of a distance of 5e8 km has an error of 40 km^2: a formula with such squares is off by a second.
"""

import json
from pathlib import Path

import mpmath as mp

FILE = Path(__file__).with_name("chords.json")
C = mp.mpf("299792.458")
mp.mp.dps = 40


def vector(numbers):
    return mp.matrix([mp.mpf(float(x)) for x in numbers])


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def kepler(r, v, mu, t):
    """Return the relative position after a time t, by the change of the eccentric anomaly."""
    distance = mp.sqrt(dot(r, r))
    a = 1 / (2 / distance - dot(v, v) / mu)
    rate, s, c = mp.sqrt(mu / a**3), dot(r, v) / mp.sqrt(mu * a), 1 - distance / a
    change = mp.findroot(lambda e: rate * t - (e - c * mp.sin(e) + s * (1 - mp.cos(e))), rate * t)
    return r * (1 - a / distance * (1 - mp.cos(change))) + v * (t - (change - mp.sin(change)) / rate)


def rotation(q):
    w, x, y, z = q
    return mp.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def measure(case, station, body):
    """Return the function of time that is negative while the body hides the star."""
    first, last = (mp.mpf(t) for t in case["geometry_times"])
    begin, end = (vector(x) for x in case["to_observer"])
    star = vector(case["star"])
    star = star / mp.sqrt(dot(star, star))
    position, velocity = ([vector(x) for x in case[name]] for name in ("position", "velocity"))
    masses = [mp.mpf(x) for x in case["mass"]]
    share = masses[0] / sum(masses) if body == 1 else -masses[1] / sum(masses)
    quaternion = [mp.mpf(x) for x in case["attitude"][body]]
    size = mp.sqrt(sum(x * x for x in quaternion))
    start, spin = rotation([x / size for x in quaternion]), mp.mpf(case["spin"][body][2])
    axes = [mp.mpf(x) for x in case["semi_axes"][body]]
    mu = mp.mpf(case["G"]) * sum(masses)

    def f(t):
        observer = begin + (end - begin) * ((t - first) / (last - first)) + vector(case["stations"][station])
        emitted = t - mp.sqrt(dot(observer, observer)) / C
        for _ in range(6):
            line_of_sight = observer - kepler(position[1] - position[0], velocity[1] - velocity[0], mu, emitted) * share
            emitted = t - mp.sqrt(dot(line_of_sight, line_of_sight)) / C
        angle = spin * emitted
        spinning = mp.matrix([[mp.cos(angle), -mp.sin(angle), 0], [mp.sin(angle), mp.cos(angle), 0], [0, 0, 1]])
        to_body = (start * spinning).T
        p, q = ([(to_body * v)[i] / axes[i] for i in range(3)] for v in (line_of_sight, star))
        return dot(p, p) - dot(p, q) ** 2 / dot(q, q) - 1

    return f


def chord(case, station, body, near):
    """Return the times of disappearance and reappearance near a time; ``None`` without an occultation."""
    f, middle, half = measure(case, station, body), mp.mpf(near), mp.mpf(3)
    for _ in range(5):
        low, value, high = f(middle - half), f(middle), f(middle + half)
        curvature, slope = (low + high) / 2 - value, (high - low) / 2
        middle -= half * slope / (2 * curvature)
    if f(middle) >= 0:
        return None
    half_length = half * mp.sqrt(-f(middle) / curvature)
    return [float(mp.findroot(f, middle + sign * half_length)) for sign in (-1, 1)]


if __name__ == "__main__":
    data = json.loads(FILE.read_text())
    for case in data["cases"]:
        for entry in case["chords"]:
            times = chord(case, entry["station"], entry["body"], 0.5 * (entry["disappearance"] + entry["reappearance"]))
            entry["disappearance"], entry["reappearance"] = times
    FILE.write_text(json.dumps(data, separators=(",", ":")))
