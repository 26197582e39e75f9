"""``python -m targets``: batches of input for all targets in turn, for some minutes.

Each batch runs in a separate process, which a fault may end: a crash, or sixty seconds of computing on one input. The
input of a fault is stored in a folder with the printed text.
"""

from __future__ import annotations

import argparse
import faulthandler
import hashlib
import itertools
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings

from . import TARGETS

#: Seconds of computing, not of waiting, that one input may take.
_LIMIT = 60.0
_MEMORY = 8 * 2**30
_BATCH = 500


def run_batches(names: list[str], minutes: float, first: int, folder: Path) -> int:
    """Send batches through the targets in turn; return the number of faults."""
    folder.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60.0 * minutes
    counts = dict.fromkeys(names, 0)
    faults = 0
    print(f"seeds from {first}; faults go to {folder}", flush=True)
    for number, name in zip(itertools.count(first), itertools.cycle(names)):
        if time.monotonic() > end:
            break
        command = [sys.executable, "-m", "targets", "--batch", name, "--seed", str(number), "--folder", str(folder)]
        process = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        counts[name] += _BATCH
        if process.returncode != 0:
            faults += 1
            print(f"{name}, seed {number}: {_store_fault(folder, name, process)}", flush=True)
    print(", ".join(f"{name} {count}" for name, count in counts.items()), f"inputs; {faults} faults")
    return faults


def _store_fault(folder: Path, name: str, process: subprocess.CompletedProcess[str]) -> str:
    """Store the last input of a batch, which hypothesis has minimised, and the printed text."""
    last = _last(folder, name)
    content = last.read_bytes() if last.exists() else b""
    path = folder / f"{name}-{hashlib.sha256(content).hexdigest()[:12]}{last.suffix}"
    path.write_bytes(content)
    path.with_suffix(".log").write_text(process.stdout)
    cause = (
        f"ended by signal {-process.returncode}" if process.returncode < 0 else process.stdout.strip().splitlines()[-1:]
    )
    return f"{path}: {cause}"


def _last(folder: Path, name: str) -> Path:
    return folder / f"last-{name}{TARGETS[name].suffix or '.txt'}"


def batch(name: str, number: int, folder: Path) -> None:
    """Send many inputs to a target."""
    target, last = TARGETS[name], _last(folder, name)
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    faulthandler.enable()
    # After the traceback is printed the signal ends the process, also within a library.
    faulthandler.register(signal.SIGPROF, chain=True)

    @seed(number)
    @settings(
        max_examples=_BATCH,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
        # A batch reports one fault, so that the last input is that of the fault.
        report_multiple_bugs=False,
    )
    @given(target.inputs)
    def check(value: Any) -> None:
        last.write_bytes(value if isinstance(value, bytes) else repr(value).encode(errors="backslashreplace"))
        signal.setitimer(signal.ITIMER_PROF, _LIMIT)
        try:
            target.check(value)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)

    check()


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m targets", description=__doc__)
    parser.add_argument("targets", nargs="*", help=f"some of {', '.join(TARGETS)}; all by default")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**9))
    parser.add_argument("--folder", type=Path, default=Path("out", "fuzz"))
    parser.add_argument("--batch", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.batch is not None:
        batch(arguments.batch, arguments.seed, arguments.folder)
        return 0
    if unknown := set(arguments.targets) - set(TARGETS):
        parser.error(f"no target {', '.join(unknown)}; expected some of {', '.join(TARGETS)}")
    return (
        1 if run_batches(arguments.targets or list(TARGETS), arguments.minutes, arguments.seed, arguments.folder) else 0
    )


if __name__ == "__main__":
    sys.exit(main())
