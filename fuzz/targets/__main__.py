"""``python -m targets``: wrong input for every target in turn, until the time is over.

Each batch runs in a process of its own, which what it meets may end: a crash, or sixty seconds of computing on one
input. What led there is kept in a folder, with what was printed.
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


def hunt(names: list[str], minutes: float, first: int, folder: Path) -> int:
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
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        counts[name] += _BATCH
        if done.returncode != 0:
            faults += 1
            print(f"{name}, seed {number}: {_keep(folder, name, done)}", flush=True)
    print(", ".join(f"{name} {count}" for name, count in counts.items()), f"inputs; {faults} faults")
    return faults


def _keep(folder: Path, name: str, done: subprocess.CompletedProcess[str]) -> str:
    """Store the last input of a batch, which hypothesis has made as short as it can, and what was printed."""
    last = _last(folder, name)
    content = last.read_bytes() if last.exists() else b""
    path = folder / f"{name}-{hashlib.sha256(content).hexdigest()[:12]}{last.suffix}"
    path.write_bytes(content)
    path.with_suffix(".log").write_text(done.stdout)
    how = f"ended by signal {-done.returncode}" if done.returncode < 0 else done.stdout.strip().splitlines()[-1:]
    return f"{path}: {how}"


def _last(folder: Path, name: str) -> Path:
    return folder / f"last-{name}{TARGETS[name].suffix or '.txt'}"


def batch(name: str, number: int, folder: Path) -> None:
    """Go through one target with many inputs."""
    target, last = TARGETS[name], _last(folder, name)
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    faulthandler.enable()
    # Once the traceback is told the signal does what it is for: it ends the process, in whatever library that is.
    faulthandler.register(signal.SIGPROF, chain=True)

    @seed(number)
    @settings(
        max_examples=_BATCH,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
        # One fault a batch, so that the last input is the one of the fault that is told.
        report_multiple_bugs=False,
    )
    @given(target.inputs)
    def enter(value: Any) -> None:
        last.write_bytes(value if isinstance(value, bytes) else repr(value).encode(errors="backslashreplace"))
        signal.setitimer(signal.ITIMER_PROF, _LIMIT)
        try:
            target.check(value)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)

    enter()


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m targets", description=__doc__)
    parser.add_argument("targets", nargs="*", help=f"some of {', '.join(TARGETS)}; all, unless given")
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
    return 1 if hunt(arguments.targets or list(TARGETS), arguments.minutes, arguments.seed, arguments.folder) else 0


if __name__ == "__main__":
    sys.exit(main())
