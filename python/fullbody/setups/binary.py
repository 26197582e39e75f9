"""Setting up a binary from the numbers that papers publish."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal, Self

import numpy as np

from ..base.arguments import generator, options_of, refuse_unknown
from ..base.kinds import choice, instance, whole_number
from ..base.unit_names import error_of
from ..base.units import DEFAULT_UNITS, UNITLESS, Units, as_quantity, is_quantity
from ..errors import InvalidInput, caution, interruptible, once
from ..model.bodies import Body
from ..model.state import State, from_numbers
from ..motion.system import System
from .component import Component, body_of, has_units
from .masses import numbers_of, solve
from .start import Orbit, Start


class Binary(tuple[System, State]):
    """The system and the state of :func:`fullbody.binary`, which also knows the errors of its arguments."""

    _arguments: dict[str, Any]

    def __new__(cls, system: System, state: State, arguments: dict[str, Any]) -> Self:
        """Make the pair, with the arguments from which it follows."""
        pair = super().__new__(cls, (system, state))
        pair._arguments = arguments
        return pair

    def __reduce__(self) -> Any:
        return Binary, (*self, self._arguments)

    def draw(self, n: int, rng: Any) -> list[Binary]:
        """Draw ``n`` binaries whose arguments are distributed as their standard errors say.

        Numbers with an error, such as ``"(5.4 ± 0.4)e11 kg"``, follow normal distributions that are independent of each
        other; but for angles they keep their sign. Draws that contradict each other by Kepler's third law are not
        refused: masses have priority, as in :func:`fullbody.binary`. A ``start_period`` is searched anew.

        Parameters
        ----------
        n : int
        rng : int or numpy.random.Generator

        Returns
        -------
        list of Binary
            Pairs of a system and a state, as :func:`fullbody.integrate_many` takes them.

        Raises
        ------
        InvalidInput
            If no argument has a standard error, and for a drawn binary that :func:`fullbody.binary` refuses.

        Examples
        --------
        >>> import fullbody
        >>> pair = fullbody.binary(
        ...     fullbody.Component(diameter="780 m", rotation_period="2.26 h"),
        ...     fullbody.Component(diameter="151 m"),
        ...     total_mass="(5.4 ± 0.4)e11 kg", equal_density=True, semi_major_axis="1.19 ± 0.03 km", units=True)
        >>> [f"{system.masses.sum():.3g}" for system, state in pair.draw(2, rng=1)]
        ['5.54e+11 kg', '5.53e+11 kg']
        """
        source, binaries = generator(rng), []
        with once(), interruptible("draws of a binary"):
            for _ in range(whole_number(n, "n")):
                drawn = {name: _drawn(value, name, source) for name, value in self._arguments.items()}
                if all(drawn[name] is value for name, value in self._arguments.items()):
                    raise InvalidInput("no argument has a standard error; expected one such as '11.92 ± 0.01 h'")
                free = {"mismatch_warning": np.inf, "mismatch_error": np.inf, "start_period": None}
                binaries.append(binary(**(drawn | free)))
        return binaries


def _drawn(value: Any, what: str, source: np.random.Generator) -> Any:
    """Return a value drawn from the normal distribution of its standard error, and others unchanged."""
    if isinstance(value, Component):
        fields = {name: getattr(value, name) for name in value.__slots__}
        drawn = {name: _drawn(part, name, source) for name, part in fields.items()}
        same = all(drawn[name] is part for name, part in fields.items())
        return value if same else replace(value, **drawn)
    if isinstance(value, tuple | list):
        parts = [_drawn(part, what, source) for part in value]
        if all(new is old for new, old in zip(parts, value, strict=True)):
            return value
        if what != "pole":
            return parts
        # A latitude beyond a pole is that of a direction on the other side.
        longitude, latitude = (UNITLESS.number(part, "angle", what) for part in parts)
        return longitude + (np.pi if np.cos(latitude) < 0.0 else 0.0), float(np.arcsin(np.sin(latitude)))
    if isinstance(value, str) and value[:1] in "+-.(\N{MINUS SIGN}0123456789":
        value = as_quantity(value, what, "number")
    if (error := error_of(value)) is None:
        return value
    signed = value.unit.is_equivalent("rad")
    while True:
        number = source.normal(value.value, error)
        if signed or ((number < 0.0) == (value.value < 0.0)).all():
            return number * value.unit


#: The semi-major axis relative to the primary's longest semi-axis, which only few binaries, beyond Neptune, exceed.
_WIDE = 200.0


def binary(
    primary: Component,
    secondary: Component,
    *,
    total_mass: Any = None,
    GM: Any = None,
    mass_ratio: Any = None,
    equal_density: bool = False,
    period: Any = None,
    semi_major_axis: Any = None,
    eccentricity: float = 0.0,
    elements: Literal["osculating", "mean"] | None = None,
    start_period: Any = None,
    argument_of_periapsis: Any = 0.0,
    mean_anomaly: Any = 0.0,
    pole: tuple[Any, Any] | None = None,
    synchronous: bool = True,
    libration: Any = 0.0,
    at_rest: Literal["barycentre", "primary"] = "barycentre",
    mismatch_warning: float = 1e-3,
    mismatch_error: float = 0.05,
    G: Any = None,
    units: tuple[object, object, object] | bool | None = None,
    time: Any = 0.0,
    **options: Any,
) -> Binary:
    """Set up a binary from published numbers: its system and its state.

    The masses, the period and the semi-major axis obey Kepler's third law, G (m1 + m2) P^2 = 4 pi^2 a^3. Give what is
    published: missing values follow, and values that are given twice are compared. If they differ, masses of the
    components have priority over a total mass, both over what a period and a semi-major axis imply, and a period over a
    semi-major axis.

    Parameters
    ----------
    primary, secondary : Component
    total_mass, GM : float or Quantity, optional
        The total mass, or G times it.
    mass_ratio : float, optional
        The secondary's mass divided by the primary's.
    equal_density : bool
        Whether to split the total mass by volume.
    period, semi_major_axis : float or Quantity, optional
        Period and semi-major axis of the mutual orbit. Give one of them, or both.
    eccentricity : float
    elements : {"mean", "osculating"}, optional
        Whether the orbit has the given mean period in the bodies' actual attraction (``"mean"``, the default for a
        period, since observed periods are means), or the start is that of the Kepler orbit (``"osculating"``).
    start_period : float or Quantity, optional
        The period for which a start of mean elements is made, in place of a search (see the notes).
    argument_of_periapsis, mean_anomaly : float or Quantity
        The angles at the start; the former is measured from the ascending node.
    pole : (longitude, latitude), optional
        The pole of the mutual orbit, radians or Quantities, in the frame that the state is to be in: the node is at the
        longitude plus 90 degrees. By default the orbit's plane is the xy-plane and its node the x-axis.
    synchronous : bool
        Whether the secondary's spin is the orbit's mean motion, and its x-axis points at the primary at the start as
        nearly as its pole allows. Otherwise its ``rotation_period`` and ``rotation_angle`` hold.
    libration : float or Quantity
        The angle by which a synchronous secondary is rotated from that about its z-axis.
    at_rest : {"barycentre", "primary"}
        Whether the barycentre or the primary starts at rest at the origin.
    mismatch_warning, mismatch_error : float
        Relative differences between two values of one quantity above which there is a warning, or an error; infinite
        for no limit.
    time : float or Quantity
        The time of the state.
    G, units, **options
        Arguments of :class:`fullbody.System`; ``epoch=`` and ``frame=`` say what time zero and the axes are.

    Returns
    -------
    system : System
    state : State
        The two are a pair with a method :meth:`~fullbody.setups.binary.Binary.draw`, which returns binaries within the
        standard errors of numbers such as ``"11.92 ± 0.01 h"``.

    Raises
    ------
    InvalidInput
        For too few values, for a contradiction beyond ``mismatch_error``, and for invalid values.
    BodiesOverlap
        For bodies that overlap at the start.

    Warns
    -----
    InconsistentInput
        For a contradiction between the two limits; for an osculating eccentricity that is more than
        ``mismatch_warning`` below the forced one, and for a mean period that no start reaches or keeps (see the notes);
        for an implied density outside 100 to 20000 kg/m^3, if there are units; for a semi-major axis above 200 times
        the longest semi-axis of the primary; for a body whose rotation is not given
        (``rotation_period=float("inf")`` says that this is meant).

    Notes
    -----
    With ``elements="osculating"`` the start has the separation and the speed of a Kepler orbit. Over an oblate primary
    it falls inwards: the mutual period of the run is shorter than ``period`` by about 3 J2 (R/a)^2 of it, 4 per cent
    for Didymos. The figures also force an osculating eccentricity of mu'/mu - 1 on a circle of radius r, with mu' = r^2
    times the relative acceleration: in the equator of an oblate primary 3/2 J2 (R/r)^2, 0.019 for Didymos. Started with
    an osculating eccentricity of zero, the distance varies as on an ellipse of the forced one, which is a part of it
    that always points at the secondary.

    With ``elements="mean"`` the start is that of a Kepler orbit whose G (m1 + m2) is replaced by a^2 times the relative
    acceleration that the bodies have at the distance a (in their initial attitudes, or the mean over a rotation of a
    primary that is not synchronous). If the period is given, the remaining difference is measured in integrations over
    16 revolutions, up to 64 for a locked body that librates slowly, and removed: the start is made for a period that
    differs a little, ``start_period``. The mean sidereal period (see :func:`fullbody.observables.mutual_period`) of
    these revolutions is then ``period`` to 1e-6, and the distance may differ a little from a published semi-major axis.
    If the means over two and four times as many differ by more than 1e-4 there is a warning that the mean does not
    last, as for a body that tumbles or librates irregularly. All this takes some tenths of a second with the exact
    methods and with short series; spheres and points, whose orbits are Kepler orbits, need none of it.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.binary(
    ...     fullbody.Component(diameters=(1.53, 1.50, 1.35), rotation_period=2.7650, name="Alpha"),
    ...     fullbody.Component(diameters=(0.57, 0.46, 0.35), name="Beta"),
    ...     total_mass=2.49e12, mass_ratio=0.057, period=17.42, units=("km", "hour", "kg"))
    >>> system.masses
    <Quantity [2.35572375e+12, 1.34276254e+11] kg>
    >>> run = system.integrate(state, "20 day", output="1 hour")
    >>> print(f"{fullbody.observables.mutual_period(run).mean:.4f}")
    17.4200 h
    """
    arguments = {**locals()}
    arguments |= arguments.pop("options")
    # Many sessions set up no binary, and need no integrations for one.
    from .elements import mean_start, osculating_start

    components = (primary, secondary)
    _refuse_choices(components, at_rest, elements, options)
    if elements is None:
        elements = "osculating" if period is None else "mean"
    if start_period is not None and (elements != "mean" or period is None):
        raise InvalidInput(f"start_period is {start_period!r}; expected it beside a period of mean elements only")
    if synchronous and secondary.rotation_period is not None:
        raise InvalidInput("the secondary has a rotation_period and is synchronous; expected one of the two")
    convert, gravity = _units_and_gravity(units, G, (total_mass, GM, period, start_period, semi_major_axis), components)
    numbers = numbers_of(arguments, convert)
    if numbers["libration"] != 0.0 and not synchronous:
        which = f"{libration!r} of a secondary that is not synchronous"
        raise InvalidInput(f"libration is {which}; expected rotation_angle")
    if synchronous and UNITLESS.number(secondary.rotation_angle, "angle", "rotation_angle") != 0.0:
        which = f"{secondary.rotation_angle!r} of a secondary that is synchronous"
        raise InvalidInput(f"rotation_angle is {which}; expected libration=")
    orbit, warn_above = Orbit.published(arguments, numbers), numbers["mismatch_warning"]
    solution = solve(components, numbers, equal_density, gravity, convert)
    system = System(_bodies(components, solution.masses, convert), G=gravity, units=convert.names, **options)
    for text in _doubts(system, components, synchronous, solution.semi_major_axis):
        caution(text)
    start = Start.of(system, components, solution, orbit, numbers["libration"] if synchronous else None, at_rest)
    start.refuse_overlap(system, start.separation)
    if elements == "mean":
        relative, warning = mean_start(system, solution, start, period is not None, numbers["start_period"])
        start.refuse_overlap(system, relative.position[1] - relative.position[0])
    else:
        relative, warning = osculating_start(system, solution, start, warn_above)
    if warning is not None:
        caution(warning)
    start_time = convert.number(time, "time", "time")
    state = from_numbers(
        system.context, relative.position, relative.velocity, start.attitudes, relative.spin, start_time
    )
    return Binary(system, state, arguments)


def _refuse_choices(
    components: tuple[Component, Component], at_rest: str, elements: str | None, options: dict[str, Any]
) -> None:
    """Raise an error for invalid components, options and choices."""
    for name, component in zip(("primary", "secondary"), components, strict=True):
        instance(component, name, Component, "fullbody.Component(...)")
    names = options_of(binary)
    refuse_unknown(options, [*names, *(o for o in options_of(System) if o not in (*names, "bodies"))], "binary")
    if "bodies" in options:
        raise InvalidInput("'bodies' is not an option of binary, which makes them; expected primary and secondary")
    choice(at_rest, "at_rest", ("barycentre", "primary"))
    choice(elements, "elements", (None, "osculating", "mean"))


def _units_and_gravity(
    units: Any, G: Any, arguments: tuple[Any, ...], components: tuple[Component, Component]
) -> tuple[Units, float]:
    """Return the units of the system and its gravitational constant in them."""
    if G is None and not units:
        fields = (entry for component in components for entry in component._numbers().values())
        values = (*arguments, *(value for value, dimension in fields if dimension != "angle"))
        with_units = (isinstance(value, str) or is_quantity(as_quantity(value, "a number")) for value in values)
        if any(with_units) or any(map(has_units, components)):
            raise InvalidInput(
                f"the numbers have units and the system has none; expected units={DEFAULT_UNITS}, or others"
            )
        raise InvalidInput("G is not given; expected a number, or units=(length, time, mass)")
    convert = Units(units)
    return convert, convert.gravitational_constant if G is None else convert.number(G, "G", "G")


def _bodies(components: tuple[Component, Component], masses: tuple[float, float], convert: Units) -> list[Body]:
    # A mass without a unit is used if the sizes have none, so that the density makes sense.
    amounts = (convert.attach(m, "mass") if has_units(c) else m for c, m in zip(components, masses, strict=True))
    return [body_of(component, amount) for component, amount in zip(components, amounts, strict=True)]


def _doubts(
    system: System, components: tuple[Component, Component], synchronous: bool, separation: float
) -> Iterator[str]:
    """Yield warnings about sizes and spins; :class:`fullbody.System` itself warns of densities."""
    units = system.context.units
    longest = max(system.context.bodies[0].semi_axes)
    if separation > _WIDE * longest:
        distance, size = (units.text(value, "length", 4) for value in (separation, longest))
        yield (
            f"the semi-major axis, {distance}, is {separation / longest:.4g} times the longest semi-axis of the "
            f"primary {system.names[0]!r}, {size}; expected at most {_WIDE:g} times: check the units of the sizes, of "
            "the masses and of the period or the semi-major axis"
        )
    for k, (name, component) in enumerate(zip(system.names, components, strict=True)):
        called = f"{('primary', 'secondary')[k]} {name!r}"
        if component.rotation_period is None and not (synchronous and k == 1):
            expected = "expected one, infinite if that is meant"
            yield f"the {called} has no rotation_period and starts without rotation; {expected}"
