"""The cost of derivatives: a year of 1999 KW4 with transition matrices, beside the year alone and beside differences.

    python benches/derivatives.py [hours] [rounds]

The year is run alternately without derivatives, with the 24 x 24 transition matrix, with all masses and semi-axes too,
and with the indicators of chaos; the ratios are medians over the rounds. Differences of runs take 25 years for the
matrix (one beside the motion itself for each of the 24 numbers), twice as many with central ones, and have half of the
digits. GUBAS-RS (commit 2a07388) carries 30 dual numbers through its series: the matrix of two ellipsoids to its
order 4, by RK7(8) at 1e-13 for 12 hours, took it 25.7 s where the run alone took 0.51 s.

Then follow a polyhedron of 2,000 faces instead of Alpha, at the distance of 1999 KW4 and near contact, and the cost of
each parameter of forces, relative to the run without derivatives.
"""

import statistics
import sys
import time

import fullbody
import numpy as np
from polyhedra import globe

PEERS = "differences 25, GUBAS-RS 51"

HOURS = float(sys.argv[1]) if len(sys.argv) > 1 else 8766.0
ROUNDS = int(sys.argv[2]) if len(sys.argv) > 2 else 3


def main():
    """Print the table."""
    print(
        f"{HOURS:g} h of 1999 KW4, Verner98 at 1e-13, a sample a day; {ROUNDS} rounds; ratios to the run without them"
    )
    for gravity in ("focal", "surface", "multipole:4"):
        system, state = fullbody.systems.kw4(gravity=gravity)
        series = gravity.startswith("multipole")
        names = [name for name in system.parameters if name.startswith(("mass", "semi"))]
        kinds = {
            "transition": {"derivatives": True},
            "and masses" if series else "and masses, semi-axes": {
                "derivatives": names[:1] + names[4:5] if series else names
            },
            "chaos": {"chaos": True},
        }
        ratios = {name: [] for name in kinds}
        for _ in range(ROUNDS):
            alone = seconds(system, state)
            for name, options in kinds.items():
                ratios[name].append(seconds(system, state, **options) / alone)
        columns = ", ".join(f"{name} {statistics.median(values):.2f}" for name, values in ratios.items())
        print(f"{gravity:12} {columns}; {PEERS}")
    polyhedra()
    parameters()


def polyhedra():
    """Print the cost of the transition matrix of an ellipsoid with a polyhedron of 2,000 faces."""
    system, state = fullbody.systems.kw4()
    alpha, beta = system.bodies
    vertices, faces = globe(26, 40, (0.766, 0.7475, 0.6735))
    body = fullbody.Body(fullbody.Polyhedron(vertices, faces), mass=alpha.mass, name="Alpha")
    pair = fullbody.System([body, beta], G=system.G)
    close = np.array(state.position)
    close[1] = close[0] + (close[1] - close[0]) * 1.15 / np.linalg.norm(close[1] - close[0])
    for name, start, hours in (("at its distance", state, 200.0), ("near contact", state.replace(position=close), 0.2)):
        alone, matrix = [], []
        for _ in range(ROUNDS):
            alone.append(seconds(pair, start, hours))
            matrix.append(seconds(pair, start, hours, derivatives=True))
        ratio = statistics.median(b / a for a, b in zip(alone, matrix, strict=True))
        print(f"{len(faces)} faces, {name}: transition {ratio:.2f}; at most 6")


def parameters():
    """Print the cost of each parameter of forces relative to the run, among all parameters and by itself."""
    system, state = fullbody.systems.kw4()
    orbit = fullbody.KeplerElements(a=95.7e6, e=0.69, i=0.68, Omega=4.29, omega=3.37, M=0.2)
    forces = [
        fullbody.forces.ThirdBody(mass=1.98841e30, orbit=orbit, of="system", name="Sun"),
        fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01, name="tide"),
        fullbody.forces.Yorp(on="Alpha", along=1e9, across=1e8, pole=[0.1, 0.0, 1.0], name="yorp"),
        fullbody.forces.Byorp(on="Beta", about="Alpha", force=1e3, name="byorp"),
    ]
    system = system.with_forces(forces)
    names = [name for name in system.parameters if name.split(" of ")[-1] in ("Sun", "tide", "yorp", "byorp")]
    hours, costs, shared_costs = HOURS / 10.0, {name: [] for name in names}, []
    for _ in range(ROUNDS):
        alone, matrix = seconds(system, state, hours), seconds(system, state, hours, derivatives=True)
        shared_costs.append((seconds(system, state, hours, derivatives=names) - matrix) / alone / len(names))
        for name in names:
            costs[name].append((seconds(system, state, hours, derivatives=[name]) - matrix) / alone)
    columns = ", ".join(f"{name} {statistics.median(values):.2f}" for name, values in costs.items())
    print(f"each parameter, in runs: {statistics.median(shared_costs):.2f} among all; by itself {columns}; at most 0.5")


def seconds(system, state, hours=HOURS, **options):
    """Return the processor time of a run in seconds."""
    start = time.process_time()
    system.integrate(state, hours, output="ends" if hours < HOURS else 24.0, **options)
    return time.process_time() - start


if __name__ == "__main__":
    main()
