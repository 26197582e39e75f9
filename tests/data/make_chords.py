"""Compute the chords of chords.json in 40 digits, by formulas that share nothing with the package.

Run ``python tests/data/make_chords.py``, which takes a minute: it reads bodies, star, stations and geometry from the file,
and writes the chords again. Bodies move on Kepler orbits about their barycentre, and turn about their z-axes. A double has
16 digits, and the square of a distance of 5e8 km is known to 40 km^2 only: a formula with such squares is off by a second.
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
    """The relative position after a time t, by the change of the eccentric anomaly."""
    far = mp.sqrt(dot(r, r))
    a = 1 / (2 / far - dot(v, v) / mu)
    rate, s, c = mp.sqrt(mu / a**3), dot(r, v) / mp.sqrt(mu * a), 1 - far / a
    change = mp.findroot(lambda e: rate * t - (e - c * mp.sin(e) + s * (1 - mp.cos(e))), rate * t)
    return r * (1 - a / far * (1 - mp.cos(change))) + v * (t - (change - mp.sin(change)) / rate)


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
    """The function of time that is negative where the body hides the star."""
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
        place = begin + (end - begin) * ((t - first) / (last - first)) + vector(case["stations"][station])
        emitted = t - mp.sqrt(dot(place, place)) / C
        for _ in range(6):
            way = place - kepler(position[1] - position[0], velocity[1] - velocity[0], mu, emitted) * share
            emitted = t - mp.sqrt(dot(way, way)) / C
        angle = spin * emitted
        turn = mp.matrix([[mp.cos(angle), -mp.sin(angle), 0], [mp.sin(angle), mp.cos(angle), 0], [0, 0, 1]])
        back = (start * turn).T
        p, q = ([(back * v)[i] / axes[i] for i in range(3)] for v in (way, star))
        return dot(p, p) - dot(p, q) ** 2 / dot(q, q) - 1

    return f


def chord(case, station, body, near):
    """The times of disappearance and reappearance near a time; none where the body misses the station."""
    f, middle, half = measure(case, station, body), mp.mpf(near), mp.mpf(3)
    for _ in range(5):
        before, value, after = f(middle - half), f(middle), f(middle + half)
        bend, slope = (before + after) / 2 - value, (after - before) / 2
        middle -= half * slope / (2 * bend)
    if f(middle) >= 0:
        return None
    apart = half * mp.sqrt(-f(middle) / bend)
    return [float(mp.findroot(f, middle + sign * apart)) for sign in (-1, 1)]


if __name__ == "__main__":
    data = json.loads(FILE.read_text())
    for case in data["cases"]:
        for known in case["chords"]:
            times = chord(case, known["station"], known["body"], 0.5 * (known["disappearance"] + known["reappearance"]))
            known["disappearance"], known["reappearance"] = times
    FILE.write_text(json.dumps(data, separators=(",", ":")))
