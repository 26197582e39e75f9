"""The cost of external forces: the year of 1999 KW4 with Sun, tide and BYORP beside the year without.

    python benches/forces.py [--hours 8766] [--repeats 3]

Prints the ratio of the two times, and that for each force alone; the overhead of a call of a compiled force, as the
difference between runs with and without a function in C that does nothing; the cost of the forces of radiation per
evaluation beside the tide, with a Beta that rotates three times in each revolution for the binary Yarkovsky effect; and
the time of the radiation coefficients of Beta's 2,292 faces. Runs with and without a force alternate, and the shortest
of each counts. Needs a C compiler.
"""

from __future__ import annotations

import argparse
import ctypes
import subprocess
import tempfile
import time
from pathlib import Path

import fullbody
from fullbody.forces import BinaryYarkovsky, Byorp, Force, Function, ThirdBody, Tide, radiation_coefficients

AU = 1.495978707e8
#: The Sun on the orbit of 1999 KW4, in km, hours and kg.
SUN = ThirdBody(
    mass=1.98841e30,
    orbit=fullbody.KeplerElements(a=0.642 * AU, e=0.688, i=0.68, Omega=4.27, omega=3.36, M=0.0),
    of="system",
    name="Sun",
)
TIDE = Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
#: BYORP with a coefficient of 0.02 as of Jacobson & Scheeres.
BYORP = Byorp(on="Beta", about="Alpha", force=200.6)
HEAT = BinaryYarkovsky("Beta", "Alpha", pressure=2e5, lag=0.3, name="binary Yarkovsky")
NOTHING = """
#include <stdint.h>
int nothing(double time, int64_t bodies, const double *position, const double *velocity, const double *attitude,
            const double *spin, double *force, double *torque, void *data) { return 0; }
"""


def compiled(folder: str) -> Function:
    """Return a force in C that does nothing."""
    source, library = Path(folder) / "nothing.c", Path(folder) / "nothing.so"
    source.write_text(NOTHING)
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
    return Function(ctypes.CDLL(str(library)).nothing, name="nothing", depends_on_velocity=False)


def compare(
    cases: dict[str, list[Force]], hours: float, repeats: int, spin_factor: float = 1.0
) -> dict[str, tuple[float, int]]:
    """Return the shortest processor time in seconds and the evaluations of each case; Beta's spin has a factor."""
    results: dict[str, tuple[float, int]] = {}
    for _ in range(repeats):
        for name, forces in cases.items():
            system, state = fullbody.systems.kw4()
            state = state.replace(spin=state.spin * [[1.0], [spin_factor]])
            system = system.with_forces(forces)
            started = time.process_time()
            run = system.integrate(state, hours, output=[hours])
            seconds = time.process_time() - started
            results[name] = (min(seconds, results.get(name, (seconds, 0))[0]), run.statistics.evaluations)
    return results


def main() -> None:
    """Print the ratios and the cost of a call."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=8766.0)
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    cases: dict[str, list[Force]] = {
        "without": [],
        "Sun": [SUN],
        "tide": [TIDE],
        "BYORP": [BYORP],
        "Sun, tide and BYORP": [SUN, TIDE, BYORP],
    }
    results = compare(cases, arguments.hours, arguments.repeats)
    base, _ = results["without"]
    print(f"1999 KW4, {arguments.hours:g} h{'':<15}seconds     ratio   evaluations")
    for name, (seconds, evaluations) in results.items():
        print(f"{name:<33}{seconds:8.3f}{seconds / base:10.3f}{evaluations:14}")
    with tempfile.TemporaryDirectory() as folder:
        nothing = compiled(folder)
        cases = {"none": [], "one": [nothing], "tide": [TIDE], "both": [TIDE, nothing]}
        results = compare(cases, arguments.hours, arguments.repeats)
    # Costs are per evaluation, since the numbers of evaluations may differ.
    costs = {name: 1e9 * seconds / evaluations for name, (seconds, evaluations) in results.items()}
    print(f"a compiled force that does nothing: {costs['one'] - costs['none']:.0f} ns a call as the only force,")
    print(f"{costs['both'] - costs['tide']:.0f} ns beside the tide; the first includes the record of work and impulse")
    radar = fullbody.systems.kw4(shape="radar")[0]
    started = time.process_time()
    coefficients = radiation_coefficients(radar["Beta"])
    print(f"radiation coefficients of 2,292 faces: {time.process_time() - started:.2f} s of the processor")
    shadow = {"other": radar["Alpha"], "position": (2.548, 0.0, 0.0)}
    started = time.process_time()
    radiation_coefficients(radar["Beta"], **shadow)
    print(f"with the shadow of Alpha's 9,168 faces: {time.process_time() - started:.2f} s")
    for spin_factor, named in (
        (1.0, {"YORP": coefficients.yorp(2e5, on="Beta"), "BYORP": BYORP}),
        (3.0, {"heat": HEAT}),
    ):
        cases = {"tide": [TIDE]} | {name: [TIDE, force] for name, force in named.items()}
        results = compare(cases, arguments.hours, arguments.repeats, spin_factor)
        costs = {name: 1e9 * seconds / evaluations for name, (seconds, evaluations) in results.items()}
        for name in named:
            print(f"{name}: {costs[name] - costs['tide']:.0f} ns an evaluation beside the tide")


if __name__ == "__main__":
    main()
