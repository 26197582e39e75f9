"""The centre of the light of all bodies of a system together, as a telescope sees it that does not resolve them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base import rotations
from ..base.values import ArrayFields
from ..errors import InvalidInput, interruptible
from ..record.record import Record
from ..typing import Array, Floats
from .brightness import Epochs, Photometer
from .laws import LommelSeeliger
from .light_curve import epochs_of
from .sky import in_mas, offsets, sky_axes
from .vectors import Vectors

if TYPE_CHECKING:
    from .laws import Law

#: The steps of differences of light: as a share of the size of a body, and of a radian.
_STEP = 1e-3


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class CombinedLight(ArrayFields):
    """The light of all bodies of a system together at K times.

    Attributes
    ----------
    offset : ndarray or Quantity, (K, 2)
        The direction of the centre of light from that of the barycentre, to the east and to the north: in mas if the
        system has units, otherwise in radians. Zero where no light comes from the system.
    centre : ndarray or Quantity, (K, 3)
        The centre of light from the barycentre, inertial frame: the mean of the positions of all visible surface
        elements, each weighted by its light.
    brightness : ndarray or Quantity, (K,)
        The brightness of all bodies together, as :func:`brightness` has it.
    """

    offset: Any
    centre: Any
    brightness: Any


@interruptible("a centre of light")
def combined_light(
    run: Record,
    times: Any,
    geometry: Vectors,
    *,
    law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
    albedo: float | Array | dict[str, Any] = 1.0,
    mutual: bool = True,
    sun_radius: Any = 0.0,
    frame: Any = "equatorial",
) -> CombinedLight:
    """Compute the centre of the light of all bodies together, with their phases, occultations and eclipses.

    It is what a telescope measures that does not resolve the bodies, such as Gaia: the photocentre wobbles about the
    barycentre.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    times : astropy Time, or array_like or Quantity, (K,)
        Times at which the light arrives at the observer.
    geometry : Geometry
        A geometry that includes the Sun.
    law, albedo, mutual, sun_radius
        Options of :func:`brightness`.
    frame : str or astropy frame
        The axes of the sky: ``"equatorial"`` (east and north), ``"ecliptic"`` (along longitude and latitude).

    Returns
    -------
    CombinedLight

    Raises
    ------
    Interrupted
        On Ctrl-C.
    InvalidInput
        For the reasons of :func:`light_curve`, for a system whose frame is not known, and for a geometry of directions
        alone, in which lengths have no angles.

    Notes
    -----
    The first moments of the light of ellipsoids are integrals along the parallels of the lune that is visible and
    illuminated, as the brightness is, and those of polyhedra sums over what is left of their facets. They have the
    accuracy of the brightness.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au, "frame": "ecliptic"}
    >>> geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    >>> light = observing.combined_light(run, np.linspace(1.0, 23.0, 100) * u.h, geometry)
    >>> light.offset.shape, light.offset.unit
    ((100, 2), Unit("mas"))
    """
    system = run.system
    axes = sky_axes(system, frame, "a centre of light")
    photometer = Photometer(system, law, albedo, mutual, sun_radius)
    parts = []
    for epochs in epochs_of(run, times, geometry, "a centre of light"):
        refuse_directions(epochs, "a centre of light")
        light = centre_of(epochs, photometer.moments(epochs))
        parts.append((offsets(-epochs.to_observer @ axes.T, light.centre @ axes.T), light.centre, light.total))
    offset, centre, total = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    attach = system.context.units.attach
    return CombinedLight(in_mas(offset, system), attach(centre, "length"), attach(total, "area"))


def refuse_directions(epochs: Epochs, what: str) -> None:
    """Raise an error for a distant observer, from whom lengths have no angles."""
    if epochs.distant:
        raise InvalidInput(
            f"{what} needs the distance of the observer, and the geometry has directions alone; expected vectors with "
            "a unit, or light_time=True"
        )


class CentreOfLight(NamedTuple):
    """The centre of light (K, 3) of all bodies together from the barycentre, and their light (K,)."""

    centre: Floats
    total: Floats


def centre_of(epochs: Epochs, moments: Floats) -> CentreOfLight:
    """Return the centre of light from the moments (K, N, 4) of the bodies; the barycentre where there is no light."""
    light = moments[..., 0]
    total = light.sum(axis=1)
    moment = np.einsum("kn,knx->kx", light, epochs.position) + moments[..., 1:].sum(axis=1)
    return CentreOfLight(moment / np.where(total > 0.0, total, 1.0)[:, None], total)


def derivatives(photometer: Photometer, epochs: Epochs, sizes: Floats) -> tuple[CentreOfLight, Floats, Floats]:
    """Return the centre of light and its derivatives with respect to the poses of N bodies of these sizes (N,).

    Let B be the brightness of a body, M its first moments and r its position. The centre is the sum of B r + M over the
    sum of B. What B and M add to the derivatives is differenced by the poses, with errors of fourth order.

    Returns
    -------
    CentreOfLight
    position, rotation : ndarray, (K, 3, N, 3)
        Derivatives of the centre with respect to the positions of the bodies, and to their rotation vectors in their
        body frames.
    """
    light = photometer.moments(epochs)
    centre = centre_of(epochs, light)
    count = len(sizes)
    result = np.zeros((2, len(light), 3, count, 3))
    separation = epochs.position - centre.centre[:, None]
    total = centre.total[:, None]
    for body in range(count):
        for kind, step in enumerate((_STEP * sizes[body], _STEP)):
            for axis in range(3):
                change = np.zeros_like(light)
                for weight, k in ((8.0, 1.0), (-8.0, -1.0), (-1.0, 2.0), (1.0, -2.0)):
                    change += weight * photometer.moments(_displaced(epochs, body, kind, axis, k * step))
                change /= 12.0 * step
                moment = np.einsum("kn,knx->kx", change[..., 0], separation) + change[..., 1:].sum(axis=1)
                result[kind, :, :, body, axis] = moment / total
        result[0, :, :, body] += (light[:, body, 0, None] / total)[..., None] * np.eye(3)
    return centre, *result


def _displaced(epochs: Epochs, body: int, kind: int, axis: int, step: float) -> Epochs:
    """Return epochs with one body displaced along an axis, or rotated about an axis of its body frame."""
    position, attitude = epochs.position.copy(), epochs.attitude.copy()
    if kind == 0:
        position[:, body, axis] += step
    else:
        rotation = rotations.of_vectors(step * np.eye(3)[axis])
        attitude[:, body] = rotations.products(attitude[:, body], rotation)
    return epochs._replace(position=position, attitude=attitude)
