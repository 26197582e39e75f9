"""The time of calls, for the measurements in this folder."""

from __future__ import annotations

import time
from collections.abc import Callable


def shortest(call: Callable[[], object], repeats: int, clock: Callable[[], float] = time.process_time) -> float:
    """Return the shortest time of a call in seconds, of the processor unless another clock is given."""
    times = []
    for _ in range(repeats):
        started = clock()
        call()
        times.append(clock() - started)
    return min(times)
