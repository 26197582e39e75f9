"""Conversion of directions, poles and attitudes between the ecliptic, the equator and frames of astropy.

A frame is named ``"ecliptic"`` (the barycentric mean ecliptic of J2000), ``"eclipj2000"`` (SPICE's ECLIPJ2000),
``"equatorial"`` (the ICRS), or is a frame of astropy that differs from them by a rotation alone (``"galactic"``,
``BarycentricMeanEcliptic(equinox="J2015")``); frames that move or belong to an observer are refused. Only directions
are converted; positions keep their origin.

SPICE's ECLIPJ2000 is the ICRF rotated about its x-axis by 84381.448 arc seconds. The mean ecliptic of J2000 of astropy
(IAU 2006, with the bias of the frame) lies 0.04 arc seconds, 2e-7 rad, from it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import rotations
from ..base.arguments import directions, longitude_latitude, warn_if_degrees
from ..base.kinds import instance
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, need
from ..errors import InvalidInput
from ..model.state import State
from ..typing import Array, Floats

__all__ = ["attitude", "pole_angles", "pole_vector", "rotate", "rotate_pole", "rotate_state", "rotation"]

#: Names of frames here, with those in astropy.
_NAMES = {"ecliptic": "barycentricmeanecliptic", "equatorial": "icrs", "icrf": "icrs"}
#: The matrices from the ICRS to frames that need no astropy, the ecliptic as astropy has it to the last bit.
_FROM_ICRS = {
    "equatorial": np.eye(3),
    "icrf": np.eye(3),
    "ecliptic": np.array(
        [
            [0.9999999999999941, -7.078368954848322e-08, 8.05621398373642e-08],
            [3.2897004077419646e-08, 0.9174821299149584, 0.39777699944404793],
            [-1.0207044725484355e-07, -0.39777699944404304, 0.9174821299149556],
        ]
    ),
    "eclipj2000": rotations.matrices(rotations.about_axis(0, -np.deg2rad(84381.448 / 3600.0))),
}
_EXPECTED = (
    "expected 'ecliptic', 'eclipj2000', 'equatorial' or a frame of astropy that differs from them by a rotation alone: "
    "'galactic', 'supergalactic', 'fk5', 'fk4noeterms', 'barycentrictrueecliptic', "
    "BarycentricMeanEcliptic(equinox='J2015')"
)


def rotation(origin: Any, target: Any) -> Floats:
    """Return the matrix (3, 3) that converts components in one frame to components in another.

    Parameters
    ----------
    origin, target : str or astropy frame
        Names of frames or frames of astropy; see :mod:`fullbody.frames`.

    Raises
    ------
    InvalidInput
        For a frame that astropy does not know, and if the frames differ by more than a rotation.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.frames.rotation("equatorial", "ecliptic")[2, 1:].round(6)
    array([-0.397777,  0.917482])
    """
    named = [_FROM_ICRS.get(frame) if isinstance(frame, str) else None for frame in (origin, target)]
    if named[0] is not None and named[1] is not None:
        return np.eye(3) if origin == target else np.asarray(named[1] @ named[0].T)
    with need("units", "a frame"):
        from astropy import units as u
        from astropy.coordinates import BaseCoordinateFrame, ConvertError, SkyCoord, UnitSphericalRepresentation

    for frame in (origin, target):
        # Astropy would take None as the ICRS.
        kind = frame if isinstance(frame, type) else type(frame)
        if not issubclass(kind, str | BaseCoordinateFrame | SkyCoord):
            raise InvalidInput(f"cannot rotate from the frame {origin!r} to {target!r}; {_EXPECTED}")
    if "eclipj2000" in (origin, target):
        return np.asarray(rotation("equatorial", target) @ rotation(origin, "equatorial"))
    start, end = (_NAMES.get(frame, frame) if isinstance(frame, str) else frame for frame in (origin, target))
    axes = UnitSphericalRepresentation([0, 90, 0] * u.deg, [0, 0, 90] * u.deg)
    try:
        axes_in_target = SkyCoord(axes, frame=start).transform_to(end)
        matrix = np.array(axes_in_target.cartesian.xyz.value, dtype=np.float64)
    # A frame without the observer or the time that it needs raises an AttributeError within astropy.
    except (ValueError, TypeError, AttributeError, ConvertError) as error:
        raise InvalidInput(f"cannot rotate from the frame {origin!r} to {target!r}; {_EXPECTED}") from error
    if not rotations.is_rotation(matrix):
        raise InvalidInput(f"the frames {origin!r} and {target!r} differ by more than a rotation; {_EXPECTED}")
    return matrix


def rotate(vectors: Any, origin: Any, target: Any) -> Array:
    """Convert vectors (..., 3), numbers or a Quantity, between two frames; those of :func:`rotation` are accepted.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.frames.rotate([0.0, 0.0, 1.0], "ecliptic", "equatorial")[1:].round(6)
    array([-0.397777,  0.917482])
    """
    components = as_quantity(vectors, "vectors")
    UNITLESS.numbers(getattr(components, "value", components), "number", "vectors", ("...", 3))
    return components @ rotation(origin, target).T


def rotate_state(state: State, origin: Any, target: Any) -> State:
    """Convert positions, velocities and attitudes of a state between two frames.

    Spins are in body frames and do not change. The frames are those that :func:`rotation` accepts.

    Examples
    --------
    >>> import fullbody
    >>> state = fullbody.State(position=[[0, 0, 1]], velocity=[[0, 0, 0]])
    >>> fullbody.frames.rotate_state(state, "ecliptic", "equatorial").position[0, 1:].round(6)
    array([-0.397777,  0.917482])
    """
    matrix = rotation(origin, target)
    return rotated(instance(state, "state", State), matrix, rotations.quaternion(matrix))


def rotated(state: State, matrix: Floats, quaternion: Floats) -> State:
    """Return a state with positions, velocities and attitudes rotated by a matrix (3, 3) and its quaternion (4,)."""
    return state.replace(
        position=state.position @ matrix.T,
        velocity=state.velocity @ matrix.T,
        attitude=np.array([rotations.product(quaternion, q) for q in state.attitude]),
    )


def pole_vector(longitude: Any, latitude: Any) -> Floats:
    """Return the unit vector (3,) of a longitude and latitude (or right ascension and declination).

    Parameters
    ----------
    longitude, latitude : float or Quantity
        The angles; plain numbers are radians.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> fullbody.frames.pole_vector(np.pi / 2, 0.0).round(12)
    array([0., 1., 0.])
    """
    return rotations.unit_vectors(*longitude_latitude((longitude, latitude), "the direction"))


def pole_angles(vector: Any) -> tuple[Any, Any]:
    """Return the longitude, from 0 to 2 pi, and the latitude (...) of directions (..., 3) of any length, in radians.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.frames.pole_angles([0.0, 3.0, 3.0])
    (np.float64(1.5707963267948966), np.float64(0.7853981633974483))
    """
    x, y, z = np.moveaxis(directions(vector, "vector"), -1, 0)
    return np.mod(np.arctan2(y, x), 2 * np.pi), np.arctan2(z, np.hypot(x, y))


def rotate_pole(longitude: Any, latitude: Any, origin: Any, target: Any) -> tuple[Any, Any]:
    """Convert a pole's longitude and latitude, in radians or Quantities, from one frame to another.

    The frames are those that :func:`rotation` accepts. Results are in radians, or Quantities if ``longitude`` is one.

    Examples
    --------
    The pole of the ecliptic has the declination 90 degrees minus the obliquity:

    >>> import astropy.units as u, fullbody
    >>> ra, dec = fullbody.frames.rotate_pole(0 * u.deg, 90 * u.deg, "ecliptic", "equatorial")
    >>> ra.to(u.deg).round(4), dec.to(u.deg).round(4)
    (<Quantity 270. deg>, <Quantity 66.5607 deg>)
    """
    lon, lat = pole_angles(rotate(pole_vector(longitude, latitude), origin, target))
    unit = unit_named("rad") if is_quantity(longitude) else 1.0
    return lon * unit, lat * unit


def attitude(longitude: Any, latitude: Any, angle: Any = 0.0) -> Floats:
    """Return the attitude of a body from its pole: the quaternion (4,), ``[w, x, y, z]``, from the body frame.

    Plain numbers are radians. The quaternion leads to the frame in which the pole's direction is given.

    Parameters
    ----------
    longitude, latitude : float or Quantity
        The direction of the body's z-axis in the frame of the state.
    angle : float or Quantity
        The angle from the ascending node of the body's equator (at the longitude plus 90 degrees) to the body's x-axis,
        which the IAU's rotational elements call W (Archinal et al. 2018, Celest. Mech. Dyn. Astron. 130, 22).

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> q = fullbody.frames.attitude(0.3, 0.2)
    >>> state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]], attitude=[q])
    >>> np.allclose(state.rotation_matrix[0, :, 2], fullbody.frames.pole_vector(0.3, 0.2))
    True
    """
    lon, lat = longitude_latitude((longitude, latitude), "pole")
    w = UNITLESS.number(angle, "angle", "angle")
    warn_if_degrees(angle, "angle")
    return rotations.product(rotations.of_plane(lon + np.pi / 2, np.pi / 2 - lat), rotations.about_axis(2, w))
