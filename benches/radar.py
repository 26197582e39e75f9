"""Speed of radar echoes on one core.

    python benches/radar.py [primary.obj]

Prints microseconds of a spectrum of 64 bins and milliseconds of an image of 64 by 64 bins, of one ellipsoid for several
laws, of a pair of ellipsoids one of which is hidden in part, and with the path of an OBJ file of its polyhedron.
"""

import os
import sys

os.environ["RAYON_NUM_THREADS"] = "1"

import fullbody
import numpy as np
from fullbody import Body, Ellipsoid, observing
from fullbody.observing.brightness import Epochs
from fullbody.observing.echoes import Echo, EchoModel, RadarOptions
from timing import shortest

LAWS = [observing.Cosine(C=C, R=0.3) for C in (0.5, 1.0, 1.6)] + [observing.Gaussian(C=5.0), observing.Hagfors(C=30.0)]


def echo(count):
    """Return the echo of bodies along the x-axis with gradients of frequency and delay of about one."""
    position = np.zeros((1, count, 3))
    position[0, 1:] = [3.0, 0.5, 0.1]
    attitude = np.tile([0.5, 0.1, -0.5, 0.7], (1, count, 1))
    direction = np.array([[1.0, 0.0, 0.0]])
    gradients = np.tile([[0.0, 1.0, 0.3], [-2.0, 0.0, 0.0]], (1, count, 1, 1))
    return Echo(Epochs(np.zeros(1), position, attitude, direction, direction), np.zeros((1, count, 2)), gradients)


def row(title, shapes, law):
    """Print the times of a spectrum and of an image of bodies."""
    bodies = [Body(shape, mass=1e12 * 0.1**k) for k, shape in enumerate(shapes)]
    system = fullbody.System(bodies, units=("km", "s", "kg"), gravity="point")
    model = EchoModel(
        system, observing.Geometry([0.0], to_observer=[1, 0, 0], light_time=False), RadarOptions(2.38e9, law)
    )
    radar_echo, frequencies, delays = echo(len(shapes)), np.linspace(-1.1, 1.1, 65), np.linspace(-2.1, 0.1, 65)
    spectrum = shortest(lambda: model.power(radar_echo, frequencies), 20)
    image = shortest(lambda: model.power(radar_echo, frequencies, delays), 5)
    print(f"{title:44s} {1e6 * spectrum:10.0f} us {1e3 * image:10.2f} ms")


if __name__ == "__main__":
    print(f"{'':44s} {'spectrum':>13s} {'image':>13s}")
    for law in LAWS:
        row(f"ellipsoid, {law}", [Ellipsoid(1.0, 0.8, 0.7)], law)
    row("ellipsoid behind another one", [Ellipsoid(1.0, 0.8, 0.7), Ellipsoid(0.3, 0.2, 0.2)], observing.Cosine())
    for path in sys.argv[1:2]:
        row("polyhedron", [fullbody.Polyhedron.load(path)], observing.Cosine())
