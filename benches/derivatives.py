"""What derivatives cost: a year of 1999 KW4 with its transition matrices, beside the year alone and beside differences.

    python benches/derivatives.py [hours] [rounds]

The year is run alternately without derivatives, with the 24 x 24 transition matrix, with all masses and semi-axes too,
and with the indicators of chaos; the ratios are medians over the rounds. Differences of runs take 25 years for the
matrix (one beside the motion itself for each of the 24 numbers), twice as many with central ones, and have half of the
digits. GUBAS-RS (commit 2a07388) carries 30 dual numbers through its series: the matrix of two ellipsoids to its
order 4, by RK7(8) at 1e-13 for 12 hours, took it 25.7 s where the run alone took 0.51 s.
"""

import statistics
import sys
import time

import fullbody

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
        wanted = [name for name in system.parameters if name.startswith(("mass", "semi"))]
        kinds = {
            "transition": {"derivatives": True},
            "and masses" if series else "and masses, semi-axes": {
                "derivatives": wanted[:1] + wanted[4:5] if series else wanted
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


def seconds(system, state, **options):
    """Of the processor, of one run."""
    before = time.process_time()
    system.integrate(state, HOURS, output=24.0, **options)
    return time.process_time() - before


if __name__ == "__main__":
    main()
