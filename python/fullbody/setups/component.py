"""One body of a binary as papers describe it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from .. import frames
from ..base import rotations
from ..base.arguments import longitude_latitude, warn_if_degrees
from ..base.kinds import Declared, Number, instance, kinds_of, of_kind
from ..base.limits import POSITIVE, Limits
from ..base.tables import Table, Tabled, number
from ..base.units import UNITLESS, Units, is_quantity
from ..base.values import ArrayFields, same
from ..errors import InvalidInput
from ..model.bodies import Body
from ..model.composite import Composite
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, amounts
from ..model.stokes import StokesCoefficients

#: The kind of a period, which is infinite for a body that does not rotate.
_PERIOD = Number("time", Limits(nonzero=True, infinite=True, text="a time other than zero"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Component(ArrayFields, Declared, Tabled):  # type: ignore[misc]
    """One of the two bodies of :func:`binary`, as published.

    Parameters
    ----------
    semi_axes, diameters : (a, b, c) or (2a, 2b, 2c), optional
        The semi-axes along the body's x, y and z, or the full axes. Give one of ``semi_axes``, ``diameters``,
        ``diameter`` and ``composite``.
    diameter : float or Quantity, optional
        The diameter of the sphere of equal volume; ``axis_ratios`` gives the shape.
    axis_ratios : (a/b, b/c)
        The ratios of neighbouring axes, as in models of light curves, to be given with ``diameter``; by default both
        are one, for a sphere. If a/b and a/c are published, b/c is the latter divided by the former:
        ``axis_ratios=(1.3, 1.6 / 1.3)`` for a/b = 1.3 and a/c = 1.6.
    composite : Composite, Polyhedron or StokesCoefficients, optional
        A shape other than an ellipsoid. The masses of a Composite's parts are scaled to the mass of the body. A
        Composite and StokesCoefficients take no ``density``.
    mass, density, GM : float or Quantity, optional
        At most one of the three. Without any, the mass follows from the other arguments of :func:`binary`.
    rotation_period : float or Quantity, optional
        The period of the spin about the body's z-axis: negative for a spin against it, infinite for none. Without it a
        body that is not synchronous starts without rotation, with a warning.
    pole : (longitude, latitude), optional
        The direction of the body's z-axis, radians or Quantities, in the frame in which the orbit's pole is given. By
        default it is the orbit's pole.
    rotation_angle : float or Quantity
        The angle from the ascending node of the body's equator to its x-axis at the start; see
        :func:`fullbody.frames.attitude`. A synchronous secondary takes none, since it points at the primary.
    name : str, optional
    tilt : float or Quantity
        The angle from the orbit's pole to the body's z-axis, a rotation about the line of nodes; instead of ``pole``.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Component(diameter=2.0, axis_ratios=(1.2, 1.1)).shape
    Ellipsoid(a=1.16569..., b=0.97141..., c=0.88310...)
    """

    semi_axes: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE, (3,))))
    diameters: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE, (3,))))
    diameter: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE)))
    axis_ratios: tuple[float, float] = (1.0, 1.0)
    mass: Any = field(default=None, metadata=of_kind(Number("mass", POSITIVE)))
    density: Any = field(default=None, metadata=of_kind(Number("density", POSITIVE)))
    rotation_period: Any = field(default=None, metadata=of_kind(_PERIOD))
    pole: tuple[Any, Any] | None = None
    rotation_angle: Any = field(default=0.0, metadata=of_kind(Number("angle")))
    name: str | None = None
    tilt: Any = field(default=0.0, metadata=of_kind(Number("angle")))
    composite: Composite | Polyhedron | StokesCoefficients | None = None
    GM: Any = field(default=None, metadata=of_kind(Number("mu", POSITIVE)))

    def __post_init__(self) -> None:
        called = self._called
        shapes = (self.semi_axes, self.diameters, self.diameter, self.composite)
        count = sum(shape is not None for shape in shapes)
        if count != 1:
            names = "semi_axes, diameters, diameter, composite"
            raise InvalidInput(f"{called} has {count} of {names}; expected one of them")
        kinds, expected = Composite | Polyhedron | StokesCoefficients, "a Composite, a Polyhedron or StokesCoefficients"
        instance(self.composite, f"composite of {called}", kinds | None, expected)
        if isinstance(self.composite, Composite | StokesCoefficients) and self.density is not None:
            conflict = f"is given a density, and has a {type(self.composite).__name__}"
            raise InvalidInput(f"{called} {conflict}; expected a mass, or GM, or neither")
        ratios = UNITLESS.numbers(self.axis_ratios, "number", f"axis_ratios of {called}", (2,), POSITIVE)
        if self.diameter is None and not (ratios == 1.0).all():
            raise InvalidInput(f"{called} has axis_ratios without a diameter; expected them beside a diameter only")
        self._check_fields()
        if UNITLESS.number(self.tilt, "angle", "tilt") != 0.0 and self.pole is not None:
            raise InvalidInput(f"{called} is given both a pole and a tilt; expected at most one of the two")
        warn_if_degrees(self.tilt, f"tilt of {called}")
        warn_if_degrees(self.rotation_angle, f"rotation_angle of {called}")
        if self.pole is not None:
            longitude_latitude(self.pole, f"pole of {called}")
        masses = amounts(mass=self.mass, density=self.density, GM=self.GM)
        if len(masses) > 1:
            raise InvalidInput(f"{called} is given both {' and '.join(masses)}; expected at most one of them")

    def _what(self, name: str, of: str = "") -> str:
        return f"{name} of {of or self._called}"

    @property
    def _called(self) -> str:
        """The name of the component in errors."""
        return "a component" if self.name is None else self.name

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of the fields that differ from their defaults."""
        rows: list[Sequence[str]] = []
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name != "name" and not same(value, entry.default):
                if isinstance(value, Composite | Polyhedron | StokesCoefficients):
                    rows.append(("composite", repr(value)))
                    continue
                shown = [number(x) for x in value] if np.ndim(value) or isinstance(value, tuple) else [number(value)]
                rows.append((entry.name.replace("_", " "), ", ".join(shown)))
        return (Table("Component" if self.name is None else f"Component {self.name}", (), rows),)

    @property
    def shape(self) -> Ellipsoid | Composite | Polyhedron | StokesCoefficients:
        """The shape: an ellipsoid, or the composite as given."""
        if self.composite is not None:
            return self.composite
        if self.diameter is not None:
            a_to_b, b_to_c = self.axis_ratios
            # The product a b c = b^3 (a/b) / (b/c) is that of the sphere.
            b = self.diameter / 2 * (b_to_c / a_to_b) ** (1 / 3)
            return Ellipsoid(b * a_to_b, b, b / b_to_c)
        a, b, c = self.semi_axes if self.semi_axes is not None else (d / 2 for d in self.diameters)
        return Ellipsoid(a, b, c)


#: The kinds of the numbers of a component.
KINDS: dict[str, Any] = kinds_of(Component)


def has_units(component: Component) -> bool:
    """Return whether the size of the shape is given with a unit."""
    return any(is_quantity(value) for value, _ in component.shape._numbers().values())


def body_of(component: Component, mass: Any) -> Body:
    """Return the body of a component, with a mass; the masses of a composite's parts are scaled to it."""
    if isinstance(component.composite, Composite):
        return Body(component.composite.with_mass(mass), name=component.name)
    return Body(component.shape, mass=mass, name=component.name)


def equator(component: Component, plane: Any) -> Any:
    """Return the attitude of a body with its x-axis at the node; ``plane`` is the attitude (4,) of the orbit's plane.

    The node is that of the equator on the reference plane, or that of the orbit if the body has no ``pole``.
    """
    if component.pole is not None:
        return frames.attitude(*component.pole)
    return rotations.product(plane, rotations.about_axis(0, UNITLESS.number(component.tilt, "angle", "tilt")))


def attitude(component: Component, plane: Any, angle: float | None) -> Any:
    """Return the attitude of a body whose x-axis is at an angle from the node, ``None`` for its ``rotation_angle``."""
    if angle is None:
        angle = UNITLESS.number(component.rotation_angle, "angle", "rotation_angle")
    return rotations.product(equator(component, plane), rotations.about_axis(2, angle))


def angle_towards(component: Component, plane: Any, direction: Any) -> float:
    """Return the angle from the node to the projection of a direction on the body's equator."""
    x, y, z = rotations.matrices(equator(component, plane)).T
    if np.linalg.norm(np.cross(z, direction)) <= 1e-12 * np.linalg.norm(direction):
        raise InvalidInput("the secondary's pole points at the primary; no rotation about it aligns the long axis")
    return float(np.arctan2(y @ direction, x @ direction))


def rotation_rate(component: Component, units: Units, called: str) -> float:
    """Return the angular rate about the z-axis; zero without a ``rotation_period``."""
    period = component._unitless(units, of=called)["rotation_period"]
    return 0.0 if period is None else float(2 * np.pi / period)
