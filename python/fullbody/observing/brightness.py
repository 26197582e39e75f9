"""The brightness of the bodies of a system in sunlight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import fullbody._core as _core

from ..base.arguments import directions, normal_form, suggestion
from ..base.kinds import flag, instance
from ..base.units import Units, numbers
from ..base.values import ArrayFields
from ..errors import InvalidInput, caution
from ..model.context import SystemLike
from ..model.state import State, strip
from ..model.surface import Deformation
from ..typing import Array, Floats
from .laws import Law, LommelSeeliger

#: The step in the difference of a phase function: as a share of the angle to 0 and 180 degrees, and at least, radians.
_STEP, _LEAST = 2e-4, 1e-7
#: The largest radius of the Sun, in radians, that causes no warning if it is a plain number.
_SUN = np.radians(2.0)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class BrightnessDerivatives(ArrayFields):
    """The brightness of N bodies in squared length, and its derivatives.

    Attributes
    ----------
    brightness : ndarray or Quantity, (N,)
    position : ndarray or Quantity, (N, N, 3)
        Derivatives of each body's brightness with respect to the position of each body, inertial frame.
    rotation : ndarray or Quantity, (N, N, 3)
        Derivatives with respect to the rotation vector of each body, in its body frame.
    semi_axes : ndarray or Quantity, (N, N, 3)
        Derivatives with respect to the semi-axes of each body; zero for a polyhedron.
    albedo : ndarray or Quantity, (N,)
        Derivatives of each body's brightness with respect to its albedo.
    to_observer, to_sun : ndarray or Quantity, (N, 3)
        Derivatives with respect to the unit vectors to the observer and to the Sun, inertial frame; they are
        perpendicular to these.
    vertices : tuple of N ndarrays or Quantities, (N, V, 3)
        For each body the derivatives of the brightness of all bodies with respect to its V vertices, as vectors of the
        body frame, not of ``Body.working_frame``; the frame stays where it is. V is zero without a polyhedron.
    areas : tuple of N ndarrays, (N, F)
        For each body the derivatives of the brightness of all bodies with respect to the areas of its F facets. F is
        zero without a :class:`fullbody.ConvexShape`.
    """

    brightness: Any
    position: Any
    rotation: Any
    semi_axes: Any
    albedo: Any
    to_observer: Any
    to_sun: Any
    vertices: tuple[Any, ...] = ()
    areas: tuple[Any, ...] = ()

    def along(self, deformations: Sequence[Deformation]) -> Floats:
        """Return the derivatives (K, D) of the brightness of all bodies together along D deformations, at K epochs."""
        derivatives = np.zeros((len(self.brightness), len(deformations)))
        for body, pair in enumerate(zip(self.vertices, self.areas, strict=True)):
            for partials, kind in zip(pair, ("vertices", "areas"), strict=True):
                moving = [(d, deformation[body]) for d, deformation in enumerate(deformations) if body in deformation]
                if moving and partials.size:
                    indices, displacements = zip(*moving, strict=True)
                    columns = np.stack([getattr(displacement, kind).ravel() for displacement in displacements], axis=1)
                    derivatives[:, indices] += partials.sum(axis=1).reshape(len(derivatives), -1) @ columns
        return derivatives


class Epochs(NamedTuple):
    """What a photometer sees: the poses of N bodies at K epochs, and the vectors to the observer and to the Sun.

    With velocities over that of light, shadows include the time of light from body to body. Unless observer and Sun are
    distant, their vectors go from the origin of the positions, and each body appears in its own directions, as bright
    as if it were at the origin.
    """

    #: Times (K,), positions (K, N, 3) and attitudes (K, N, 4).
    times: Floats
    position: Floats
    attitude: Floats
    #: Vectors (K, 3), of any length if these are distant.
    to_observer: Floats
    to_sun: Floats
    #: Velocities (K, N, 3) over that of light.
    velocity: Floats | None = None
    distant: bool = True

    def core(self) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats, bool]:
        """Return the epochs in the form that the core takes."""
        return (
            np.ascontiguousarray(self.times, dtype=np.float64),
            np.reshape(self.position, (-1, 3)),
            np.reshape(self.attitude, (-1, 4)),
            np.asarray(self.to_observer),
            np.asarray(self.to_sun),
            np.empty((0, 3)) if self.velocity is None else np.reshape(self.velocity, (-1, 3)),
            self.distant,
        )

    def vectors(self) -> list[Floats]:
        """Return the vectors (K, N, 3) from the bodies to the observer and to the Sun."""
        origin = np.zeros_like(self.position) if self.distant else self.position
        return [vector[:, None] - origin for vector in (self.to_observer, self.to_sun)]


class Photometer:
    """The bodies of a system with their surfaces, for any number of epochs, in numbers of the system's units.

    Law, albedo, mutual and the Sun's radius are options of :func:`brightness`.
    """

    def __init__(
        self, system: SystemLike, law: Law | dict[str, Law], albedo: Any, mutual: bool, sun_radius: Any
    ) -> None:
        flag(mutual, "mutual")
        names = system.context.names
        self.laws: list[Law] = by_name(law, names, "law")
        for name, body_law in zip(names, self.laws, strict=True):
            instance(body_law, f"law of {name}", Law, "a law such as LommelSeeliger()")
        # One albedo for all of a body is multiplied in here, so that the derivative with respect to zero is known.
        if type(albedo) is float and 0.0 <= albedo < np.inf:
            self.albedo, faces = np.full(len(names), albedo), [[1.0]] * len(names)
        else:
            self.albedo, faces = _albedos(albedo, names)
        described = [body_law._describe() for body_law in self.laws]
        radius = sun_radius if type(sun_radius) is float else Units().number(sun_radius, "angle", "sun_radius")
        if isinstance(sun_radius, int | float) and radius > _SUN:
            caution(
                f"sun_radius is {radius:.6g} radians, {np.degrees(radius):.3g} degrees, as from 0.13 au or nearer; "
                f"give degrees as a Quantity, or as text such as '{radius:.6g} deg'"
            )
        self._core = _core.Photometer(list(system.context.bodies), described, faces, bool(mutual), radius)

    def brightness(self, epochs: Epochs) -> Floats:
        """Return the brightness (K, N) at epochs."""
        return self._multiplied(self._core.brightness(epochs.core()), epochs)

    def moments(self, epochs: Epochs) -> Floats:
        """Return the brightness and its first moments (K, N, 4), sums over the surface of the light and of it times the
        components of the vector from the body's centre.
        """
        return self._multiplied(self._core.moments(epochs.core()), epochs)

    def _multiplied(self, light: Floats, epochs: Epochs) -> Floats:
        """Return light (K, N, ...) of bodies times their albedos and their phase functions."""
        factors = [self.albedo]
        if any(law.phase_function is not None for law in self.laws):
            factors.append(self._by_law(phase_angle(*epochs.vectors())))
        for factor in factors:
            light *= factor.reshape(*factor.shape, *[1] * (light.ndim - 2))
        return light

    def _by_law(self, angle: Floats) -> Floats:
        """Return the phase functions (K, N) of the bodies at phase angles (K, N)."""
        return np.stack([law._phase(angle[:, k]) for k, law in enumerate(self.laws)], axis=-1)

    def derivatives(self, epochs: Epochs, vertices: bool = False) -> BrightnessDerivatives:
        """Return the brightness with its derivatives, each with a first axis of K epochs; on demand by vertices too.

        Those of hidden light leave out the perspective of a near observer or Sun.
        """
        lit, bodies, light, by_vertex, by_area = self._core.partials(epochs.core(), vertices)
        vectors = epochs.vectors()
        angle = phase_angle(*vectors)
        factor = self._by_law(angle)
        step = np.maximum(_STEP * np.minimum(angle, np.pi - angle), _LEAST)
        middle = np.clip(angle, 2.0 * step, np.pi - 2.0 * step)
        single, double = (self._by_law(middle + k * step) - self._by_law(middle - k * step) for k in (1, 2))
        slope = (8.0 * single - double) / (12.0 * step)
        lengths = [np.linalg.norm(vector, axis=-1, keepdims=True) for vector in vectors]
        units = [vector / length for vector, length in zip(vectors, lengths, strict=True)]
        light = light * factor[..., None, None]
        for k, (direction, other) in enumerate((units, units[::-1])):
            perpendicular = other - direction * np.sum(direction * other, axis=-1, keepdims=True)
            size = np.linalg.norm(perpendicular, axis=-1, keepdims=True)
            # The phase angle falls where one vector rotates toward the other.
            gradient = np.divide(perpendicular, size, out=np.zeros_like(perpendicular), where=size > 0.0)
            light[:, :, k] -= (lit * slope)[..., None] * gradient
        scale = self.albedo * factor
        bodies = bodies * factor[..., None, None]
        for k, length in enumerate([] if epochs.distant else lengths):
            by_vector = 2.0 * (lit * factor)[..., None] * units[k] - light[:, :, k]
            np.einsum("kiix->kix", bodies[..., :3])[:] += by_vector / length
        bodies *= self.albedo[:, None, None]
        light = light * self.albedo[:, None, None]
        return BrightnessDerivatives(
            lit * scale,
            bodies[..., 0:3],
            bodies[..., 3:6],
            bodies[..., 6:9],
            lit * factor,
            light[:, :, 0],
            light[:, :, 1],
            tuple(part * scale[..., None, None] for part in by_vertex),
            tuple(part * scale[..., None] for part in by_area),
        )


def brightness(
    system: SystemLike,
    state: State,
    to_observer: Any,
    to_sun: Any,
    *,
    law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
    mutual: bool = True,
    sun_radius: Any = 0.0,
    albedo: float | Array | dict[str, Any] = 1.0,
) -> Array:
    """Compute the brightness of each body: its scattering law over the visible and illuminated surface, times albedo.

    Ellipsoids and spheres are exact to round-off, with any number of bodies that occult or eclipse them at once.
    So is a body near the edge of a much larger one, up to the last digits of their positions: 1e-10 at a ratio of
    sizes of 1e-7. Events with observer and Sun in one direction to within 2e-12 radians are accurate to 1e-11.
    Polyhedra and composites are computed from their facets, from which the parts that they hide of each other are cut
    exactly; where parts share a plane, each point counts once. A :class:`fullbody.ConvexShape` hides nothing of itself:
    its light is the sum over its facets. Ellipsoids beside polyhedra have 5,120 facets where they hide
    light and 4,096 where light is hidden from them: an error of about 0.1 % of their light.

    Parameters
    ----------
    system : System
    state : State
    to_observer, to_sun : array_like or Quantity, (3,)
        Vectors toward the observer and the Sun, inertial frame, of any positive length. Both are taken as distant.
    law : Law or dict
        The scattering law, such as :class:`LommelSeeliger`; or one for each body by its name. The cosines of emission
        and incidence enter by these laws alone; the phase angle also by any function, ``phase_function=`` of a law.
    mutual : bool
        Whether bodies occult and eclipse each other. A body of several parts, or one that is not convex, hides parts
        of itself in any case.
    sun_radius : float, Quantity or str
        Angular radius of the Sun's disc, radians, for penumbrae: 0.00465 at 1 au. Zero for parallel light.
    albedo : float, array_like or dict
        Factor of the brightness, zero or above; an array (F,) for each face of a polyhedron or facet of a convex shape,
        in their order; or either for each body by its name.

    Returns
    -------
    ndarray or Quantity, (N,)
        In squared length; zero for a point mass. The flux at a distance D from the bodies is this times the solar flux
        at the bodies, over D^2. A white diffuse surface has Lambert's law and the albedo 1 / pi.

    Raises
    ------
    InvalidInput
        For vectors of another shape or of length zero, a negative albedo, and laws that give no finite brightness.
    BodiesOverlap
        With ``mutual``, for bodies that share interior points.

    See Also
    --------
    brightness_derivatives

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> from fullbody import observing
    >>> ball = fullbody.System([fullbody.Body(fullbody.Sphere(2.0), mass=1.0)], G=1.0)
    >>> state = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)))
    >>> light = observing.brightness(ball, state, [1, 0, 0], [1, 0, 0], law=observing.Lambert())
    >>> bool(abs(light[0] - 2 * np.pi / 3 * 2.0**2) < 1e-14)
    True
    """
    photometer = Photometer(system, law, albedo, mutual, sun_radius)
    light = photometer.brightness(_epochs_of(system, state, to_observer, to_sun))
    return system.context.units.attach(light[0], "area")


def of_unit_sphere(law: Law) -> float:
    """Return the brightness of a sphere of radius one and albedo one at phase angle zero."""
    ball = _core.Photometer([_core.Body("sphere", (1.0, 1.0, 1.0), 1.0, None)], [law._describe()], [[1.0]], False, 0.0)
    direction = np.array([[1.0, 0.0, 0.0]])
    epochs = Epochs(np.zeros(1), np.zeros((1, 3)), np.eye(1, 4), direction, direction)
    return float(ball.brightness(epochs.core())[0, 0] * law._phase(np.zeros(1))[0])


def brightness_derivatives(
    system: SystemLike,
    state: State,
    to_observer: Any,
    to_sun: Any,
    *,
    law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
    mutual: bool = True,
    sun_radius: Any = 0.0,
    albedo: float | Array | dict[str, Any] = 1.0,
) -> BrightnessDerivatives:
    """Compute the brightness of each body and its derivatives with respect to poses, semi-axes, albedos and directions.

    The derivatives are integrals over the visible and illuminated surface and along the outlines of what hides it; only
    a phase function is differentiated by differences. Those of polyhedra are exact with all shadows, and those of
    ellipsoids beside polyhedra or in composites have an error of about 1 % while light is hidden from them. Rough
    surfaces have none.

    Parameters
    ----------
    system, state, to_observer, to_sun, law, mutual, sun_radius, albedo
        As for :func:`brightness`.

    Returns
    -------
    BrightnessDerivatives

    Examples
    --------
    >>> import fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.kw4()
    >>> by = observing.brightness_derivatives(system, state, [1, 0, 0], [1, 0.1, 0])
    >>> by.position.shape, by.semi_axes.shape, by.to_sun.shape
    ((2, 2, 3), (2, 2, 3), (2, 3))
    """
    photometer = Photometer(system, law, albedo, mutual, sun_radius)
    derivatives = photometer.derivatives(_epochs_of(system, state, to_observer, to_sun), vertices=True)
    dimensions = {"position": "length", "semi_axes": "length"}
    attach = system.context.units.attach
    values = {
        name: attach(getattr(derivatives, name)[0], dimensions.get(name, "area"))
        for name in BrightnessDerivatives.__dataclass_fields__
        if name not in ("vertices", "areas")
    }
    by_vertex = tuple(attach(part[0], "length") for part in derivatives.vertices)
    return BrightnessDerivatives(**values, vertices=by_vertex, areas=tuple(part[0] for part in derivatives.areas))


def _epochs_of(system: SystemLike, state: State, to_observer: Any, to_sun: Any) -> Epochs:
    """Return the epoch of a state."""
    core = strip(state, system.context)
    if len(core.position) != len(system.context):
        raise InvalidInput(f"state has {len(core.position)} bodies; expected {len(system.context)}, as in the system")
    rows = (np.array([core.time]), core.position[None], core.attitude[None])
    return Epochs(*rows, _direction(to_observer, "to_observer"), _direction(to_sun, "to_sun"))


def phase_angle(e: Floats, s: Floats) -> Floats:
    """Return the angles (...) between vectors (..., 3)."""
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(e, s), axis=-1), np.sum(e * s, axis=-1)))


def _albedos(albedo: Any, names: tuple[str, ...]) -> tuple[Floats, list[list[float]]]:
    """Return one albedo for each body, and for the core one for each of its faces, or a single one."""
    if not isinstance(albedo, dict) and np.ndim(albedo) and len(names) > 1:
        raise InvalidInput(
            f"albedo has shape {np.shape(albedo)}; expected a number, or a dict by the names of the bodies"
        )
    factors, faces = np.ones(len(names)), []
    for index, (name, value) in enumerate(zip(names, by_name(albedo, names, "albedo"), strict=True)):
        factor = numbers(value, f"albedo of {name}")
        if factor.ndim > 1 or not (factor.size and factor.min() >= 0.0 and factor.max() < np.inf):
            expected = "a finite number, zero or above, or one for each face of a polyhedron"
            raise InvalidInput(f"albedo of {name} is {value!r}; expected {expected}")
        factors[index] = 1.0 if factor.ndim else factor
        faces.append(factor.tolist() if factor.ndim else [1.0])
    return factors, faces


def _direction(value: Any, what: str) -> Floats:
    """Return a vector (1, 3) of any length above zero; the core checks an array of numbers itself."""
    is_vector = type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (3,)
    vector: Floats = (value if is_vector else directions(value, what, True))[None]
    return vector


def by_name(value: Any, names: tuple[str, ...], what: str) -> list[Any]:
    """Return a list of values, one for each body, from one value for all or a dict by names."""
    if not isinstance(value, dict):
        return [value] * len(names)
    value = {normal_form(name): entry for name, entry in value.items()}
    if unknown := [name for name in value if name not in names]:
        raise InvalidInput(f"{what} names {unknown[0]!r}; {suggestion(str(unknown[0]), names, 'all')}")
    if missing := [name for name in names if name not in value]:
        raise InvalidInput(f"{what} has none for {missing[0]!r}; expected one for each of {', '.join(names)}")
    return [value[name] for name in names]
