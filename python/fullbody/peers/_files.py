"""The axes of the shapes that input files give."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import rotations
from ..errors import caution
from ..model.bodies import Body
from ..typing import Floats

#: The angle in radians, and the distance relative to the size, by which a shape may differ from its principal frame
#: without a warning, since files are rounded.
_OFF = 1e-3


def along_body_axes(path: Any, bodies: Sequence[Body], attitude: Floats, spin: Floats) -> tuple[Floats, Floats]:
    """Return quaternions (N, 4) and spins (N, 3) of the body frames, from those of the axes of the given shapes."""
    attitude, spin = attitude.copy(), spin.copy()
    for k, body in enumerate(bodies):
        frame = body.working_frame
        if frame is None:
            continue
        spin[k] = rotations.matrices(frame.attitude) @ spin[k]
        attitude[k] = rotations.product(attitude[k], rotations.inverse(frame.attitude))
        angle = 2.0 * np.arctan2(np.linalg.norm(frame.attitude[1:]), abs(frame.attitude[0]))
        offset = float(np.linalg.norm(frame.position) / max(body.fitted_ellipsoid().semi_axes))
        if angle > _OFF or offset > _OFF:
            caution(
                f"{path}: the shape of {body.name or f'body {k}'} is not given in its principal frame: it is turned by "
                f"{np.degrees(angle):.3g} degrees, and its centre of mass is {offset:.3g} of its size from the origin; "
                "the state is that of its centre of mass, and the attitude that of its principal axes",
                UserWarning,
            )
    return attitude, spin
