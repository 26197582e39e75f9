"""Fourier series in the rotation angle of a body, which describe the part of its light that its shape does not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base.kinds import Declared, body_index, instance, of_kind, whole_number
from ..base.rotations import matrices
from ..errors import InvalidInput
from ..typing import Floats

#: The least angle in radians between the z-axis of the body and the line of sight for which its rotation is seen.
_POLE_ON = 1e-6


@dataclass(frozen=True, eq=False)
class RotationSeries(Declared):
    """A Fourier series in the rotation angle of a body, in magnitudes, whose coefficients a fit solves for.

    It describes the part of the light curve that the body's shape does not. Observers subtract such a series to find
    mutual events.

    Parameters
    ----------
    body : int or str
        The body, by its index in the system or its name, which has to rotate about its z-axis.
    order : int
        The number of terms, up to 1000, each of which is a cosine and a sine of a multiple of the angle.
    name : str
        A prefix of the names of the coefficients. Data whose series have the same body and name share the
        coefficients; give different names for different filters.

    Notes
    -----
    The rotation angle is measured about the z-axis, from the bisector of the directions to the observer and to the Sun
    to the x-axis of the body. The period of the series is thus synodic.

    The series multiplies the light of all bodies of the system, although the light of a satellite does not vary
    with it: the relative error of the depth of a satellite's event is at most 0.92 times the amplitude of the series in
    magnitudes. Shadows and occultations remain those of the shape that the body has in the system.

    Examples
    --------
    >>> from fullbody import observing
    >>> observing.RotationSeries("Kalliope", order=2).names("Kalliope")
    ('cos 1 of Kalliope', 'sin 1 of Kalliope', 'cos 2 of Kalliope', 'sin 2 of Kalliope')
    """

    body: Any = field(metadata=of_kind(body_index))
    order: int = field(metadata=of_kind(lambda value, what: whole_number(value, what, 1, 1000)))
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
    """Return the rotation angles (K,) of a body, and their derivatives (K, 3) with respect to its body-frame rotation.

    The body, whose name is for errors, has attitudes (K, 4), and spins (K, 3) in its body frame. The unit vectors
    ``bisector`` (K, 3) are between the directions to the observer and to the Sun.
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
