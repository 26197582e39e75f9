"""Fourier series in the rotation angle of a body, which describe the light that its shape does not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base.kinds import Declared, body_index, instance, of_kind, whole
from ..base.rotations import matrices
from ..errors import InvalidInput
from ..typing import Floats

#: The least angle in radians between the axis of the body and the line of sight, at which its rotation is seen.
_POLE_ON = 1e-6


@dataclass(frozen=True, eq=False)
class RotationSeries(Declared):
    """A Fourier series in the rotation angle of a body, in magnitudes, whose coefficients a fit solves for.

    It describes what the shape of the body leaves of its light curve, as observers do to find mutual events in it.

    Parameters
    ----------
    body : int or str
        The body, by its index in the system or its name, which has to rotate about its z-axis.
    order : int
        The number of terms, up to 1000: each is a cosine and a sine of a multiple of the angle.
    name : str
        A word before the names of the coefficients. Data whose series have the same body and name share the
        coefficients; give different names for different filters.

    Notes
    -----
    The rotation angle is that about the z-axis from the direction in the middle between observer and Sun, the bisector
    of the phase angle, to the x-axis of the body. A period of the series is thus a synodic one.

    The series multiplies the light of all bodies of the system, although the light of a satellite has no part in it: as
    a share, the depth of an event of the satellite is wrong by up to the amplitude of the series (0.92 of it in
    magnitudes). Shadows and occultations remain those of the shape that the body has in the system.

    Examples
    --------
    >>> from fullbody import observing
    >>> observing.RotationSeries("Kalliope", order=2).names("Kalliope")
    ('cos 1 of Kalliope', 'sin 1 of Kalliope', 'cos 2 of Kalliope', 'sin 2 of Kalliope')
    """

    body: Any = field(metadata=of_kind(body_index))
    order: int = field(metadata=of_kind(lambda value, what: whole(value, what, 1, 1000)))
    name: str = field(default="", metadata=of_kind(lambda value, what: instance(value, what, str, "text")))

    def names(self, body: str) -> tuple[str, ...]:
        """Return the names of the coefficients for the name of the body."""
        prefix = f"{self.name} " if self.name else ""
        return tuple(f"{prefix}{part} {k} of {body}" for k in range(1, self.order + 1) for part in ("cos", "sin"))

    def terms(self, angle: Floats) -> tuple[Floats, Floats]:
        """Return cosines and sines (K, 2 order) at angles (K,), and their derivatives."""
        k = np.arange(1.0, self.order + 1)
        cosine, sine = np.cos(k * angle[:, None]), np.sin(k * angle[:, None])

        def interleaved(*parts: Floats) -> Floats:
            return np.stack(parts, axis=-1).reshape(len(angle), -1)

        return interleaved(cosine, sine), interleaved(-k * sine, k * cosine)


def rotation_angle(body: str, attitude: Floats, spin: Floats, bisector: Floats) -> tuple[Floats, Floats]:
    """Return the rotation angles (K,) of a body, and their derivatives (K, 3) by its rotation vector in its own frame.

    Parameters
    ----------
    body : str
        The name of the body, for errors.
    attitude, spin : ndarray, (K, 4) and (K, 3)
    bisector : ndarray, (K, 3)
        Unit vectors between the directions to the observer and to the Sun.
    """
    if (np.abs(spin[:, 2]) < np.abs(spin[:, :2]).max(axis=1)).any():
        raise InvalidInput(
            f"{body} does not rotate about its z-axis, with the spin {spin[0]} in its own axes; expected rotation "
            "about the z-axis for a series in the rotation angle"
        )
    x, y, z = np.einsum("kji,kj->ik", matrices(attitude), bisector)
    across = x * x + y * y
    if across.min(initial=1.0) < _POLE_ON**2:
        raise InvalidInput(
            f"{body} is seen along its z-axis; expected a line of sight along which its rotation is seen"
        )
    return -np.arctan2(y, x), np.stack([-x * z / across, -y * z / across, np.ones_like(x)], axis=-1)
