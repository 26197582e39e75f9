"""Setting up a binary from the numbers that papers publish."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from ..base import rotations
from ..base.arguments import doubt_radians, named_options, options_of, refuse_unknown
from ..base.arguments import pole as angles_of
from ..base.tables import number
from ..base.units import USUAL, Units, gathered, is_quantity, numbers, scalar
from ..errors import InvalidInput, caution
from ..model.bodies import Body
from ..model.state import State
from ..motion.simulation import System
from ..orbit.elements import KeplerElements
from .component import Component, attitude, pointing, rate
from .masses import Known, solve
from .mean_orbit import in_attraction, kept

__all__ = ["Component", "binary"]

#: Semi-major axes by the primary's longest semi-axis; of the known binaries only a few beyond Neptune are wider.
_WIDE = 200.0


@named_options
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
    elements: Literal["osculating", "mean"] | None = None,
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
    elements : {"mean", "osculating"}, optional
        Whether the orbit is one of that mean period in the bodies' actual attraction, or the Kepler orbit of the start;
        see the notes. Unless given it is ``"mean"`` where there is a period, for observed periods are means, and
        ``"osculating"`` where there is a semi-major axis alone.
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
        Relative differences of two values of one quantity above which there is a warning, or an error; infinite for
        none.
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
    BodiesOverlap
        For bodies that overlap at the start.

    Warns
    -----
    InconsistentInput
        For a contradiction between the two limits, with both values; for an osculating eccentricity that is more than
        ``mismatch_warning`` below the one which the bodies' figures force (see the notes); for a period that no start
        has to 1e-6 over the revolutions that it is measured in, that does not last to 1e-4 over two and four times as
        many, or that cannot be measured over either, for the bodies meet (see the notes); for an implied density
        outside 100 to 20000 kg/m^3, where there are units; for a semi-major axis above 200 times the longest semi-axis
        of the primary; for a body that rotates by nothing that is stated, which starts without rotation
        (``rotation_period=float("inf")`` says that this is meant).

    Notes
    -----
    With ``elements="osculating"`` the start has the separation and the speed of a Kepler orbit. Over an oblate primary
    it falls inwards: the mutual period of the run is shorter than ``period`` by about 3 J2 (R/a)^2 of it, 4 per cent
    for Didymos. The figures also force an eccentricity. On a circle of radius r the speed is v^2 = mu'/r with mu' = r^2
    times the relative acceleration, and the osculating eccentricity mu'/mu - 1: in the equator of an oblate primary
    3/2 J2 (R/r)^2, 0.019 for Didymos. A smaller one makes no rounder orbit: as a vector that points at periapsis, the
    osculating eccentricity is the sum of a free one, which the distance follows, and of the forced one, which always
    points at the secondary. A start without any varies in distance as an ellipse of the forced eccentricity does.

    With ``elements="mean"`` the start is that of a Kepler orbit whose G (m1 + m2) is replaced by a^2 times the relative
    acceleration that the bodies have at the distance a (as they stand, or the mean over a turn of a primary that is not
    synchronous). Where the period is given, what is then left of the difference (by eccentricity, tilted equators, a
    secondary that librates) is measured in integrations of 16 revolutions, up to 64 for a locked body that librates
    slowly, and taken away: the mean sidereal period (of :func:`fullbody.observables.mutual_period`) of the run's first
    16 (to 64) revolutions is ``period`` to 1e-6, and its distance may differ a little from a published semi-major axis.
    Then the means over the first 32 and 64 (to 128 and 256) are compared with it. Where one differs by more than 1e-4
    there is no lasting mean, and a warning: where a body tumbles or librates irregularly, as long ones do on orbits of
    some eccentricity. Nothing is looked at beyond these revolutions, nor between spheres or points, whose orbits are
    Kepler's. All this takes some tenths of a second with the exact methods and with short series.

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
    for component in (primary, secondary):
        if not isinstance(component, Component):
            raise InvalidInput(f"{component!r} is no Component; expected fullbody.Component(...)")
    own = options_of(binary)
    refuse_unknown(options, [*own, *(o for o in options_of(System) if o not in (*own, "bodies"))], "binary")
    if "bodies" in options:
        raise InvalidInput("'bodies' is no option of binary, which makes them; expected primary and secondary")
    if at_rest not in ("barycentre", "primary"):
        raise InvalidInput(f"at_rest is {at_rest!r}; expected 'barycentre' or 'primary'")
    if elements not in (None, "osculating", "mean"):
        raise InvalidInput(f"elements is {elements!r}; expected 'osculating' or 'mean'")
    if elements is None:
        elements = "osculating" if period is None else "mean"
    if synchronous and secondary.rotation_period is not None:
        raise InvalidInput("the secondary has a rotation_period and is synchronous; expected one of the two")
    swing = Units().number(libration, "angle", "libration")
    if abs(swing) > 2 * np.pi:
        raise InvalidInput(f"libration is {libration!r}; expected radians, a turn at most, or a Quantity")
    if swing != 0.0 and not synchronous:
        raise InvalidInput(
            f"libration is {libration!r} of a secondary that is not synchronous; expected rotation_angle"
        )
    if synchronous and Units().number(secondary.rotation_angle, "angle", "rotation_angle") != 0.0:
        raise InvalidInput(
            f"rotation_angle is {secondary.rotation_angle!r} of a secondary that is synchronous; expected libration="
        )
    if G is None and not units:
        given = (total_mass, period, semi_major_axis, *_dimensional(primary), *_dimensional(secondary))
        if any(isinstance(value, str) or is_quantity(gathered(value, "a number")) for value in given):
            raise InvalidInput(f"the numbers have units and the system has none; expected units={USUAL}, or others")
        raise InvalidInput("G is not given; expected a number, or units=(length, time, mass)")
    round_or_not = scalar(numbers(eccentricity, "eccentricity"), "eccentricity")
    if not 0.0 <= round_or_not < 1.0:
        raise InvalidInput(f"eccentricity is {eccentricity!r}; expected 0 to below 1")
    convert = Units(units)
    gravity = convert.gravitational_constant if G is None else scalar(convert.strip(G, "G", "G"), "G")
    pair = (primary, secondary)
    known = _known(convert, gravity, pair, total_mass, mass_ratio, equal_density, period, semi_major_axis)
    worth_a_word = _tolerance(mismatch_warning, "mismatch_warning")
    too_much = _tolerance(mismatch_error, "mismatch_error")
    found, mismatches = solve(known)
    for mismatch in mismatches:
        if mismatch.relative > too_much:
            raise InvalidInput(f"{mismatch}; expected agreement to mismatch_error={mismatch_error}")
        if mismatch.relative > worth_a_word:
            caution(f"{mismatch}; the former is taken")
    bodies = []
    for component, mass in zip(pair, found.masses, strict=True):
        # A mass without a unit beside sizes without one, so that the density makes sense.
        value = convert.attach(mass, "mass") if is_quantity(component.shape.a) else mass
        bodies.append(Body(component.shape, mass=value, name=component.name))
    system = System(bodies, G=gravity, units=convert.names, **options)
    for doubt in _doubts(system, pair, synchronous, found.semi_major_axis):
        caution(doubt)

    node, inclination = (0.0, 0.0)
    if pole is not None:
        longitude, latitude = angles_of(pole, "pole")
        node, inclination = longitude + np.pi / 2, np.pi / 2 - latitude
    angles = (_angle(argument_of_periapsis, "argument_of_periapsis"), _angle(mean_anomaly, "mean_anomaly"))

    def orbit(size: float, mu: float) -> tuple[Any, Any]:
        return KeplerElements(size, eccentricity, inclination, node, *angles).to_cartesian(mu)

    mu = gravity * sum(found.masses)
    r = orbit(found.semi_major_axis, mu)[0]
    plane = rotations.product(rotations.turn(2, node), rotations.turn(0, inclination))
    locked = pointing(secondary, plane, -r) + swing if synchronous else None
    attitudes = np.array([attitude(primary, plane, None), attitude(secondary, plane, locked)])
    rates = [rate(component, convert, name) for component, name in zip(pair, system.names, strict=True)]
    _refuse_overlap(system, r, attitudes)
    share = np.array([0.0, 1.0])
    if at_rest == "barycentre":
        share = np.array([-found.masses[1], found.masses[0]]) / sum(found.masses)

    def start(size: float, mu: float, turn: float) -> State:
        """In plain numbers, for the secondary's turn in a period where it is synchronous."""
        r, v = orbit(size, mu)
        spins = [rates[0], 2 * np.pi / turn if synchronous else rates[1]]
        return State(share[:, None] * r, share[:, None] * v, attitudes, [[0.0, 0.0, spin] for spin in spins])

    rotation = rates[0] * found.period / (2 * np.pi) * rotations.matrices(attitudes[0])[:, 2]
    turning = bool(np.linalg.norm(rotation - rotations.matrices(plane)[:, 2]) > 1e-6)
    towards = r / np.linalg.norm(r)
    if elements == "mean":
        locked_places = [k for k, lock in enumerate((not turning, synchronous)) if lock]

        def mean(period: float) -> State:
            """Of an orbit made for a period, or for the distance where no period is given."""
            by_period = known.period is not None
            made, mu = in_attraction(system, replace(found, period=period), by_period, towards, attitudes, turning)
            return start(made.semi_major_axis, mu, found.period if by_period else made.period)

        if known.period is None:
            plain = mean(found.period)
        else:
            plain, irregular = kept(system, found.period, mean, locked_places)
            if irregular is not None:
                caution(irregular)
        _refuse_overlap(system, plain.position[1] - plain.position[0], attitudes)
    else:
        plain = start(found.semi_major_axis, mu, found.period)
        # At the distance of the start, where the bodies are known to be apart.
        there = replace(found, semi_major_axis=float(np.linalg.norm(r)))
        _, attracting = in_attraction(system, there, False, towards, attitudes, turning)
        forced = abs(attracting / mu - 1.0)
        if forced - round_or_not > worth_a_word:
            caution(_too_round(plain, round_or_not, forced, attracting))
    state = State(
        convert.attach(plain.position, "length"),
        convert.attach(plain.velocity, "velocity"),
        attitudes,
        convert.attach(plain.spin, "spin"),
        convert.attach(np.float64(scalar(convert.strip(time, "time", "time"), "time")), "time"),
    )
    return system, state._named(system.names)


def _too_round(start: State, given: float, forced: float, mu: float) -> str:
    """What is to be said of an osculating eccentricity below the forced one, mu being that of the actual attraction."""
    r, v = start.position[1] - start.position[0], start.velocity[1] - start.velocity[0]
    free = np.linalg.norm(np.cross(v, np.cross(r, v)) / mu - r / np.linalg.norm(r))
    return (
        f"the eccentricity of {given:.3g} is osculating and below that of {forced:.3g} which the figures of the bodies "
        f"force at this distance; the distance will vary as on an ellipse of eccentricity {free:.3g}; expected "
        "elements='mean', with the eccentricity that the distance is to show"
    )


def _dimensional(component: Component) -> tuple[Any, ...]:
    """What of a component may have units."""
    c = component
    return (c.semi_axes, c.diameters, c.diameter, c.mass, c.density, c.rotation_period)


def _doubts(
    system: System, components: tuple[Component, Component], synchronous: bool, separation: float
) -> Iterator[str]:
    """What can be computed with, but is probably a mistake."""
    units = system._units
    longest = max(units.number(axis, "length", "semi-axis") for axis in system.bodies[0].shape._lengths or ())
    if separation > _WIDE * longest:
        far, size = (number(units.attach(np.float64(value), "length"), 4) for value in (separation, longest))
        yield (
            f"the semi-major axis, {far}, is {separation / longest:.4g} times the longest semi-axis of the primary "
            f"{system.names[0]!r}, {size}; expected at most {_WIDE:g} times: check the units of the sizes, of the "
            "masses and of the period or the semi-major axis"
        )
    for k, (name, component) in enumerate(zip(system.names, components, strict=True)):
        called = f"{('primary', 'secondary')[k]} {name!r}"
        if component.rotation_period is None and not (synchronous and k == 1):
            yield (
                f"the {called} has no rotation_period and starts without rotation; expected one, infinite if that is "
                "meant"
            )
        if units.known:
            from astropy import units as u

            body = system.bodies[k]._core(units, k)
            density = (body.mass / body.volume * units.unit("density")).to_value(u.kg / u.m**3)
            if not 100.0 <= density <= 20000.0:
                yield f"the density of the {called} follows as {density:.4g} kg/m^3; expected 100 to 20000"


def _refuse_overlap(system: System, r: Any, attitudes: Any) -> None:
    state = State([np.zeros(3), r], np.zeros((2, 3)), attitudes)._core
    with system._explaining(lambda: state, " at the start"):
        system._core.energy(state)


def _known(
    convert: Units,
    gravity: float,
    components: tuple[Component, Component],
    total_mass: Any,
    mass_ratio: float | None,
    equal_density: bool,
    period: Any,
    semi_major_axis: Any,
) -> Known:
    """What is given, in plain numbers of one set of units."""

    def plain(value: Any, dimension: str, what: str) -> float | None:
        if value is None:
            return None
        number = scalar(convert.strip(value, dimension, what), what)
        if not (np.isfinite(number) and number > 0.0):
            raise InvalidInput(f"{what} is {value!r}; expected a finite number above zero")
        return number

    volumes, masses = [], []
    for place, component in enumerate(components):
        called = component.name if component.name is not None else f"body {place}"
        volume = Body(component.shape, density=1.0, name=component.name)._core(convert, 0).volume
        density = plain(component.density, "density", f"density of {called}")
        volumes.append(volume)
        masses.append(plain(component.mass, "mass", f"mass of {called}") if density is None else density * volume)
    return Known(
        gravity,
        (masses[0], masses[1]),
        plain(total_mass, "mass", "total_mass"),
        _ratio(mass_ratio, equal_density, volumes),
        plain(period, "time", "period"),
        plain(semi_major_axis, "length", "semi_major_axis"),
    )


def _angle(value: Any, what: str) -> float:
    doubt_radians(value, what)
    return Units().number(value, "angle", what)


def _tolerance(value: Any, what: str) -> float:
    """A relative difference."""
    try:
        tolerance = scalar(numbers(value, what), what)
    except InvalidInput:
        tolerance = np.nan
    if not tolerance >= 0.0:
        raise InvalidInput(f"{what} is {value!r}; expected a number, zero or above")
    return tolerance


def _ratio(mass_ratio: float | None, equal_density: bool, volumes: list[float]) -> float | None:
    if equal_density:
        if mass_ratio is not None:
            raise InvalidInput("both mass_ratio and equal_density are given; expected one of the two")
        return volumes[1] / volumes[0]
    if mass_ratio is None:
        return None
    ratio = scalar(numbers(mass_ratio, "mass_ratio"), "mass_ratio")
    if not (np.isfinite(ratio) and ratio > 0.0):
        raise InvalidInput(f"mass_ratio is {mass_ratio!r}; expected a finite number above zero")
    return ratio
