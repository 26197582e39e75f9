"""Setting up a binary from the numbers that papers publish."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _rotation, frames
from ._masses import Known, solve
from ._units import Units, is_quantity, scalar
from .bodies import Body, Ellipsoid
from .elements import KeplerElements
from .errors import InconsistentInput, InvalidInput

if TYPE_CHECKING:
    from .state import State
    from .system import System

__all__ = ["Component", "binary"]


@dataclass(frozen=True, slots=True)
class Component:
    """One of the two bodies of :func:`binary`, as published.

    Parameters
    ----------
    semi_axes : (a, b, c), optional
        Along the body's x, y and z. Of the three sizes give one.
    diameters : (2a, 2b, 2c), optional
        Whole axes instead of half ones.
    diameter : float or Quantity, optional
        Of the sphere of equal volume, with ``axis_ratios``.
    axis_ratios : (a/b, b/c)
        With ``diameter``; one and one for a sphere.
    mass, density : float or Quantity, optional
        At most one of the two. Without either the mass follows from what is known of the pair.
    rotation_period : float or Quantity, optional
        Of the spin about the body's z-axis; negative for a spin against it. Without it the primary does not spin.
    pole : (longitude, latitude), optional
        Of the body's z-axis, radians or Quantities, in the frame of the orbit's pole. Without it: the orbit's pole.
    rotation_angle : float or Quantity
        From the ascending node of the body's equator to its x-axis at the start; see :func:`fullbody.frames.attitude`.
        Not for a secondary that starts pointing at the primary.
    name : str, optional

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Component(diameter=2.0, axis_ratios=(1.2, 1.1)).shape
    Ellipsoid(a=1.16569..., b=0.97141..., c=0.88310...)
    """

    semi_axes: Any = None
    diameters: Any = None
    diameter: Any = None
    axis_ratios: tuple[float, float] = (1.0, 1.0)
    mass: Any = None
    density: Any = None
    rotation_period: Any = None
    pole: tuple[Any, Any] | None = None
    rotation_angle: Any = 0.0
    name: str | None = None

    def __post_init__(self) -> None:
        called = self.name if self.name is not None else "a component"
        sizes = [size for size in (self.semi_axes, self.diameters, self.diameter) if size is not None]
        if len(sizes) != 1:
            raise InvalidInput(f"{called} has {len(sizes)} of semi_axes, diameters, diameter; expected one of them")
        if self.diameter is None and tuple(self.axis_ratios) != (1.0, 1.0):
            raise InvalidInput(f"{called} has axis_ratios without a diameter; expected them beside a diameter only")
        if not all(np.isfinite(ratio) and ratio > 0.0 for ratio in self.axis_ratios):
            raise InvalidInput(f"axis_ratios of {called} are {self.axis_ratios}; expected two numbers above zero")
        if self.mass is not None and self.density is not None:
            raise InvalidInput(f"{called} is given both a mass and a density; expected at most one of the two")
        _ = self.shape

    @property
    def shape(self) -> Ellipsoid:
        """The ellipsoid."""
        if self.diameter is not None:
            first, second = self.axis_ratios
            b = self.diameter / 2 * (second / first) ** (1 / 3)
            return Ellipsoid(b * first, b, b / second)
        axes = self.semi_axes if self.semi_axes is not None else [d / 2 for d in self.diameters]
        try:
            a, b, c = axes
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"the axes are {axes!r}; expected three") from error
        return Ellipsoid(a, b, c)


def binary(
    primary: Component,
    secondary: Component,
    *,
    total_mass: Any = None,
    mass_ratio: float | None = None,
    equal_density: bool = False,
    period: Any = None,
    semi_major_axis: Any = None,
    eccentricity: float = 0.0,
    argument_of_periapsis: Any = 0.0,
    mean_anomaly: Any = 0.0,
    pole: tuple[Any, Any] | None = None,
    synchronous: bool = True,
    libration: Any = 0.0,
    at_rest: Literal["barycentre", "primary"] = "barycentre",
    mismatch_warning: float = 1e-3,
    mismatch_error: float = 0.05,
    G: Any = None,
    units: tuple[object, object, object] | None = None,
    time: Any = 0.0,
    **options: Any,
) -> tuple[System, State]:
    """A binary from published numbers: its system and its state.

    The masses, the period and the semi-major axis obey Kepler's third law, G (m1 + m2) P^2 = 4 pi^2 a^3. Give what is
    published: what is missing follows, and what is given twice is compared. Then the masses of the components go
    before a total mass, both go before what a period and a semi-major axis imply, and a period goes before a
    semi-major axis.

    Parameters
    ----------
    primary, secondary : Component
    total_mass : float or Quantity, optional
    mass_ratio : float, optional
        Secondary by primary.
    equal_density : bool
        Split the total mass by volume.
    period, semi_major_axis : float or Quantity, optional
        Of the mutual orbit; one of the two, or both.
    eccentricity : float
    argument_of_periapsis, mean_anomaly : float or Quantity
        At the start; the former from the ascending node.
    pole : (longitude, latitude), optional
        Of the mutual orbit, radians or Quantities, in the frame that the state is to be in: the node is at the
        longitude plus 90 degrees. Without it the orbit's plane is the xy-plane and its node the x-axis.
    synchronous : bool
        The secondary's spin is the orbit's mean motion, and its x-axis points at the primary at the start, as nearly as
        its pole allows. Otherwise its ``rotation_period`` and ``rotation_angle`` hold.
    libration : float or Quantity
        Turns a synchronous secondary about its z-axis away from that.
    at_rest : {"barycentre", "primary"}
        What starts at rest at the origin.
    mismatch_warning, mismatch_error : float
        Relative differences of two values of one quantity above which there is a warning, or an error.
    G, units
        As for :class:`fullbody.System`.
    time : float or Quantity
        Of the state.
    **options
        Passed to :class:`fullbody.System`; ``epoch=`` and ``frame=`` say what time zero and the axes are.

    Returns
    -------
    system : System
    state : State

    Raises
    ------
    InvalidInput
        For too little, for a contradiction beyond ``mismatch_error``, and for values that describe nothing.

    Warns
    -----
    InconsistentInput
        For a contradiction between the two limits, with both values.

    Notes
    -----
    The orbit is osculating: over an oblate primary the mutual period of the run is shorter than ``period`` by about
    3/2 J2 (R/a)^2 of it.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.binary(
    ...     fullbody.Component(diameters=(1.53, 1.50, 1.35), rotation_period=2.7650, name="Alpha"),
    ...     fullbody.Component(diameters=(0.57, 0.46, 0.35), name="Beta"),
    ...     total_mass=2.49e12, mass_ratio=0.057, period=17.42, units=("km", "hour", "kg"))
    >>> system.masses
    <Quantity [2.35572375e+12, 1.34276254e+11] kg>
    >>> fullbody.KeplerElements.from_cartesian(
    ...     state.position[1] - state.position[0], state.velocity[1] - state.velocity[0], system.mu()).a
    <Quantity 2.54868... km>
    """
    from .state import State
    from .system import System

    for component in (primary, secondary):
        if not isinstance(component, Component):
            raise InvalidInput(f"{component!r} is no Component; expected fullbody.Component(...)")
    if at_rest not in ("barycentre", "primary"):
        raise InvalidInput(f"at_rest is {at_rest!r}; expected 'barycentre' or 'primary'")
    system_units = Units(units)
    if G is None and not system_units.known:
        raise InvalidInput("G is not given; expected a number, or units=(length, time, mass)")

    def plain(value: Any, dimension: str, what: str) -> float | None:
        if value is None:
            return None
        number = scalar(system_units.strip(value, dimension, what), what)
        if dimension in ("mass", "density", "length", "time") and not (np.isfinite(number) and number > 0.0):
            raise InvalidInput(f"{what} is {value!r}; expected a finite number above zero")
        return number

    def angle(value: Any, what: str) -> float:
        return scalar(Units().strip(value, "angle", what), what)

    gravity = system_units.gravitational_constant if G is None else scalar(system_units.strip(G, "G", "G"), "G")
    volumes, masses = [], []
    for component in (primary, secondary):
        core = Body(component.shape, density=1.0, name=component.name)._core(Units(units), 0)
        density = plain(component.density, "density", "density")
        volumes.append(core.volume)
        masses.append(plain(component.mass, "mass", "mass") if density is None else density * core.volume)
    found, mismatches = solve(
        Known(
            gravity,
            (masses[0], masses[1]),
            plain(total_mass, "mass", "total_mass"),
            _ratio(mass_ratio, equal_density, volumes),
            plain(period, "time", "period"),
            plain(semi_major_axis, "length", "semi_major_axis"),
        )
    )
    for mismatch in mismatches:
        if mismatch.relative > mismatch_error:
            raise InvalidInput(f"{mismatch}; expected agreement to mismatch_error={mismatch_error}")
        if mismatch.relative > mismatch_warning:
            warnings.warn(f"{mismatch}; the former is taken", InconsistentInput, stacklevel=2)

    mu = gravity * sum(found.masses)
    node, inclination = (0.0, 0.0)
    if pole is not None:
        longitude, latitude = (angle(part, "pole") for part in pole)
        node, inclination = longitude + np.pi / 2, np.pi / 2 - latitude
    orbit = KeplerElements(
        found.semi_major_axis,
        eccentricity,
        inclination,
        node,
        angle(argument_of_periapsis, "argument_of_periapsis"),
        angle(mean_anomaly, "mean_anomaly"),
    )
    r, v = orbit.to_cartesian(mu)
    plane = _rotation.product(_rotation.turn(2, node), _rotation.turn(0, inclination))
    locked = None
    if synchronous:
        if secondary.rotation_period is not None:
            raise InvalidInput("the secondary has a rotation_period and is synchronous; expected one of the two")
        locked = _pointing(secondary, plane, -r) + angle(libration, "libration")
    attitudes = [_attitude(primary, plane, None), _attitude(secondary, plane, locked)]
    rates = [_rate(component, system_units) for component in (primary, secondary)]
    if synchronous:
        rates[1] = 2 * np.pi / found.period
    bodies = []
    for component, mass in zip((primary, secondary), found.masses, strict=True):
        # A mass without a unit beside sizes without one, so that the density makes sense.
        value = system_units.attach(mass, "mass") if is_quantity(component.shape.a) else mass
        bodies.append(Body(component.shape, mass=value, name=component.name))
    system = System(bodies, G=gravity, units=system_units.names, **options)
    share = np.array([0.0, 1.0])
    if at_rest == "barycentre":
        share = np.array([-found.masses[1], found.masses[0]]) / sum(found.masses)
    attach = system_units.attach
    state = State(
        attach(share[:, None] * r, "length"),
        attach(share[:, None] * v, "velocity"),
        np.array(attitudes),
        attach(np.array([[0.0, 0.0, rate] for rate in rates]), "spin"),
        attach(np.float64(scalar(system_units.strip(time, "time", "time"), "time")), "time"),
    )
    return system, state


def _ratio(mass_ratio: float | None, equal_density: bool, volumes: list[float]) -> float | None:
    if equal_density:
        if mass_ratio is not None:
            raise InvalidInput("both mass_ratio and equal_density are given; expected one of the two")
        return volumes[1] / volumes[0]
    if mass_ratio is not None and not (np.isfinite(mass_ratio) and mass_ratio > 0.0):
        raise InvalidInput(f"mass_ratio is {mass_ratio!r}; expected a finite number above zero")
    return mass_ratio


def _axes(component: Component, plane: Any) -> Any:
    """The attitude of a body's equator with its x-axis at the node."""
    return plane if component.pole is None else frames.attitude(*component.pole)


def _attitude(component: Component, plane: Any, angle: float | None) -> Any:
    """The attitude of a body at an angle from the node, its own if none is given."""
    if angle is None:
        angle = scalar(Units().strip(component.rotation_angle, "angle", "rotation_angle"), "rotation_angle")
    return _rotation.product(_axes(component, plane), _rotation.turn(2, angle))


def _pointing(component: Component, plane: Any, direction: Any) -> float:
    """How far about its z-axis a body turns from the node for its x-axis to point in a direction."""
    x, y, z = _rotation.matrices(_axes(component, plane)).T
    if np.linalg.norm(np.cross(z, direction)) <= 1e-12 * np.linalg.norm(direction):
        raise InvalidInput("the secondary's pole points at the primary; no turn about it aligns the long axis")
    return float(np.arctan2(y @ direction, x @ direction))


def _rate(component: Component, units: Units) -> float:
    if component.rotation_period is None:
        return 0.0
    period = scalar(units.strip(component.rotation_period, "time", "rotation_period"), "rotation_period")
    if not np.isfinite(period) or period == 0.0:
        raise InvalidInput(f"rotation_period is {component.rotation_period!r}; expected a number other than zero")
    return float(2 * np.pi / period)
