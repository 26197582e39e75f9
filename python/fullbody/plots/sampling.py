"""Checks whether pictures and samples are close enough together to show the true motion."""

from __future__ import annotations

import numpy as np

from ..errors import caution
from ..record.record import Record
from ..typing import Floats
from .between import at, track

#: The number of turns in a run that samples alone show; for more turns, the part of a turn between points, and the
#: largest number of points.
_SEEN, _PART, _MOST = 20.0, 1.0 / 48.0, 400_000


def followed(run: Record) -> tuple[Floats, Floats]:
    """Return times (T,) and attitudes (T, N, 4) for curves of angles, dense enough to resolve every turn of a body.

    Points at nearly equal phases of each turn would look like slow curves. If no body makes many turns, the samples are
    returned. A warning tells where samples are more than half a turn apart.
    """
    samples = run.arrays["time"]
    warn_if_aliased(run, samples, "samples")
    revolutions = _revolutions(run, samples, samples)
    if revolutions.sum(axis=1).max(initial=0.0) <= _SEEN or (run.dense is None and revolutions.max() > 0.5):
        return samples, np.asarray(run.arrays["attitude"])
    count = 1 + (len(samples) - 1) * int(np.ceil(revolutions.max() / _PART))
    times = track(run, float(samples[-1]), min(_MOST, count))
    return times, at(run, times)[1]


def _revolutions(run: Record, times: Floats, samples: Floats) -> Floats:
    """Return the turns (N, T - 1) of each body between times that increase or decrease."""
    order = np.unique(samples, return_index=True)[1]
    rate = np.linalg.norm(run.arrays["spin"][order], axis=2)
    fastest = [np.interp(times[:-1], samples[order], rate[:, body]) for body in range(len(run.context))]
    return np.asarray(np.array(fastest) * np.abs(np.diff(times)) / (2.0 * np.pi))


def warn_if_aliased(run: Record, times: Floats, shown: str = "pictures") -> None:
    """Warn if a body turns by more than half a turn between two pictures, as it would seem to turn otherwise.

    The same holds between two samples, unless the run has its continuous solution.
    """
    samples = run.arrays["time"]
    advice = {"pictures": "show more of them, or a shorter time"} if shown == "pictures" else {}
    if run.dense is None:
        advice["samples"] = "record more of them (output=), or with dense=True"
    # If two samples coincide, either of them is suitable.
    order = np.unique(samples, return_index=True)[1]
    for what, moments in (("pictures", np.sort(times)), ("samples", samples[order])):
        if what not in advice or len(moments) < 2:
            continue
        revolutions = _revolutions(run, moments, samples).max(axis=1)
        body = int(np.argmax(revolutions))
        if revolutions[body] > 0.5:
            caution(
                f"{run.context.names[body]} makes up to {revolutions[body]:.2g} turns between two {what} and will seem "
                f"to turn otherwise; {advice[what]}",
                UserWarning,
            )
            return
