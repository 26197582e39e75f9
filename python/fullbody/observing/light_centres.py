"""Centres of light of all bodies together, as a telescope sees them that does not resolve them, and of ellipsoids.

The centre of light of a body differs from its centre of mass unless the Sun is behind the observer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..base import rotations
from ..base.values import ArrayFields
from ..errors import InvalidInput, interruptible
from ..model.context import SystemLike
from ..model.shapes import Ellipsoid, PointMass, Sphere
from ..record.record import Record
from ..typing import Array, Floats
from .brightness import Epochs, Photometer
from .laws import Law, LommelSeeliger
from .light_curve import epochs_of
from .sky import in_mas, offsets, sky_axes
from .states import into_body
from .vectors import Vectors

#: The steps of differences of light: as a share of the size of a body, and of a radian.
_STEP = 1e-3
#: The least cosine at an end of an integral over the lit surface; smaller ones are replaced by it.
_LEAST = 1e-12


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
    sum of B. What B and M add to the derivatives is differenced by the poses, with errors of fourth order. The
    derivatives (K, 3, N, 3) are those with respect to the positions of the bodies, and to their rotation vectors in
    their body frames.
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
    return Epochs(epochs.times, position, attitude, *epochs[3:])


def semi_axes(system: SystemLike, body: int) -> Floats:
    """Return the semi-axes (3,) of an ellipsoid in the system's unit; zeros for a point."""
    shape = system.bodies[body].shape
    if isinstance(shape, PointMass):
        return np.zeros(3)
    if not isinstance(shape, Ellipsoid | Sphere):
        raise InvalidInput(
            f"{system.context.names[body]} is a {type(shape).__name__}; expected an ellipsoid, a sphere or a point for "
            "photocentre=True"
        )
    parts = [part for part, *_ in system.context.bodies[body].parts]
    return np.array(parts[0], dtype=np.float64)


def photocentre(axes: Floats, attitude: Any, to_observer: Floats, to_sun: Floats) -> Any:
    """Return the offset (..., 3) of a body's centre of light from its centre, by Lommel-Seeliger's law, without events.

    Let p = A^-1 e and q = A^-1 s in body axes with A = diag(a, b, c), the pole of the unit sphere along p x q, and l
    the longitude from p toward q. The light from longitude l and latitude b is g(l) cos(b)^2 db dl with g proportional
    to cos l cos(l - alpha) / cos(l - L), alpha the angle from p to q and L that from p to p + q. The mean of A u has
    closed forms: the integrals over b are pi/2 and 4/3, and those over l are elementary.

    The semi-axes are (3,), the attitudes (..., 4), and the vectors from the body (..., 3) and the offsets in the
    inertial frame; attitudes and vectors may be complex.
    """
    if not axes.any():
        return np.zeros_like(to_observer)
    e, s = (vector / np.sqrt(np.sum(vector * vector, axis=-1))[..., None] for vector in (to_observer, to_sun))
    p, q = (into_body(attitude, vector) / axes for vector in (e, s))
    size_p, size_q = (np.sqrt(np.sum(v * v, axis=-1)) for v in (p, q))
    first = p / size_p[..., None]
    cos_a = np.sum(first * q, axis=-1) / size_q
    perpendicular = q / size_q[..., None] - first * cos_a[..., None]
    sin_a = np.sqrt(np.sum(perpendicular * perpendicular, axis=-1))
    # At zero phase there is no direction perpendicular to the line of sight, and the offset along it is zero.
    second = perpendicular / np.where(sin_a == 0.0, 1.0, sin_a)[..., None]
    x, y = size_p + size_q * cos_a, size_q * sin_a
    length = np.sqrt(x * x + y * y)
    cos_l, sin_l = x / length, y / length
    cos_g, sin_g = cos_a * cos_l + sin_a * sin_l, sin_a * cos_l - cos_a * sin_l
    # The angle y = l - L runs from the terminator, l = alpha - pi/2, to the limb, l = pi/2.
    # At zero phase cos y vanishes at both ends, where the factor of its logarithm is zero.
    low, high = (
        (sine, np.where(np.real(cosine) < _LEAST, _LEAST, cosine)) for sine, cosine in ((-cos_g, sin_g), (cos_l, sin_l))
    )

    def between(antiderivative: Any) -> Any:
        return antiderivative(*high) - antiderivative(*low)

    def angle(sine: Any, cosine: Any) -> Any:
        # This is the arc tangent of y relative to the middle, for complex numbers too.
        return 2.0 * np.arctan(sine / (1.0 + cosine))

    # These are integrals over y of cos, of sin and of sin^n cos^m / cos, with n + m the number of factors.
    integrals = {
        (0, 2): between(lambda sine, cosine: sine),
        (1, 1): between(lambda sine, cosine: -cosine),
        (2, 0): between(lambda sine, cosine: 2.0 * np.arctanh(sine / (1.0 + cosine)) - sine),
        (0, 3): between(lambda sine, cosine: 0.5 * (angle(sine, cosine) + sine * cosine)),
        (1, 2): between(lambda sine, cosine: 0.5 * sine * sine),
        (2, 1): between(lambda sine, cosine: 0.5 * (angle(sine, cosine) - sine * cosine)),
        (3, 0): between(lambda sine, cosine: -np.log(cosine) - 0.5 * sine * sine),
    }

    def mean(factors: list[tuple[Any, Any]]) -> Any:
        """Return the integral over y of a product of factors a cos(y) + b sin(y), divided by cos(y)."""
        terms: dict[int, Any] = {0: 1.0}
        for of_cos, of_sin in factors:
            product: dict[int, Any] = {}
            for power, value in terms.items():
                product[power] = product.get(power, 0.0) + value * of_cos
                product[power + 1] = product.get(power + 1, 0.0) + value * of_sin
            terms = product
        return sum(value * integrals[power, len(factors) - power] for power, value in terms.items())

    # These are the coefficients of cos y and sin y in cos l, sin l and cos(l - alpha).
    cosine, sine, incidence = (cos_l, -sin_l), (sin_l, cos_l), (cos_g, sin_g)
    light = 0.5 * np.pi * mean([cosine, incidence])
    if not (np.real(light) > 0.0).all():
        raise InvalidInput("the Sun is behind a body, which has no centre of light; expected a phase angle below pi")
    along_first, along_second = (4.0 / 3.0 * mean([cosine, incidence, item]) / light for item in (cosine, sine))
    offset = (first * along_first[..., None] + second * along_second[..., None]) * axes
    return into_body(attitude * [1.0, -1.0, -1.0, -1.0], offset)
