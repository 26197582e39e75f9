"""The error of a spline through a table of vectors, estimated from the table itself."""

from __future__ import annotations

import numpy as np

from ..typing import Floats

#: The ratio of the errors of the outer pieces to those of the inner ones, and the number of rows below which it counts.
_ENDS, _SHORT = 10.0, 9
#: The largest error of the polynomial through two, three or four rows of a rotation, by the angle between rows to the
#: power of their number.
_FEW = {2: 1 / 8, 3: np.sqrt(3) / 27, 4: 1 / 24}


def relative_error(times: Floats, vectors: Floats) -> tuple[float, int]:
    """Return the largest error of the cubic spline (not-a-knot) relative to the distance, and the row next to it.

    Each row is compared with the cubic through the two rows before it and the two after it; on evenly spaced rows the
    difference is 64 times the error of the spline. A table of less than five rows is taken for one of a rotation.
    """
    count = len(times) - 4
    if count < 1:
        # The vectors change by the sine of the angle between rows, or by their lengths.
        steps = np.linalg.norm(np.diff(vectors, axis=0), axis=1) / np.linalg.norm(vectors, axis=1).min()
        worst = int(np.argmax(steps)) if len(steps) else 0
        return (float(_FEW[len(times)] * steps[worst] ** len(times)) if len(steps) else 0.0), worst
    t = [times[k : k + count] for k in range(5)]
    interpolated = np.zeros((count, 3))
    with np.errstate(all="ignore"):
        for k in (0, 1, 3, 4):
            factors = [(t[2] - t[j]) / (t[k] - t[j]) for j in (0, 1, 3, 4) if j != k]
            interpolated += np.prod(factors, axis=0)[:, None] * vectors[k : k + count]
        error = np.linalg.norm(interpolated - vectors[2:-2], axis=1) / 64 / np.linalg.norm(vectors[2:-2], axis=1)
    worst = int(np.argmax(error))
    # The first and the last piece of a spline have larger errors, and are much of a short table.
    return float(error[worst]) * (_ENDS if len(times) < _SHORT else 1.0), worst + 2
