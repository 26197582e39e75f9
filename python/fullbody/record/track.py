"""The motion of one body along a run."""

from __future__ import annotations

from dataclasses import dataclass

from ..base import rotations
from ..base.attributes import Attribute
from ..base.values import ArrayFields
from ..typing import Array, Floats


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Track(ArrayFields):
    """The motion of one body along a run of K samples: ``run["Beta"]``; a body without a name is ``"body 1"``, by
    index.

    Arrays are read-only; they are Quantities if the system has units.

    Attributes
    ----------
    name : str
        The body's name, or ``body i`` if none was given.
    time : ndarray or Quantity, (K,)
    position, velocity : ndarray or Quantity, (K, 3)
        Positions and velocities of the centre in the inertial frame.
    attitude : ndarray, (K, 4)
        Unit quaternions ``[w, x, y, z]`` from the body frame to the inertial frame.
    spin : ndarray or Quantity, (K, 3)
        Angular velocities in the body frame.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> beta = system.integrate(state, 10.0, output=1.0)["Beta"]
    >>> beta.position.shape, beta.rotation_matrix.shape
    ((11, 3), (11, 3, 3))
    """

    name: str
    time: Array
    position: Array
    velocity: Array
    attitude: Floats
    spin: Array

    rotation_matrix = Attribute[Floats](
        lambda track: rotations.matrices(track.attitude),
        "Rotation matrices (K, 3, 3) from the body frame to the inertial frame.",
    )
    tait_bryan = Attribute[Floats](
        lambda track: rotations.tait_bryan(track.attitude),
        "The paper's angles (K, 3): phi and psi in (-pi, pi], theta in [-pi/2, pi/2], radians.",
    )
