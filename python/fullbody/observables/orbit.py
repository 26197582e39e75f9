"""Elements, periods and precession of an orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.units import without_unit
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..orbit.elements import KeplerElements, computed
from ..record.record import Record
from ..typing import Array, Floats, Scalar
from . import _signal as signal
from ._follow import Path
from ._relative import REVOLUTIONS, WINDOWED, RelativeMotion

#: The number of periodic terms of the distance, the relative range of the periapsis frequency about the mean motion,
#: and the relative size below which that term may be an error of the run.
_TERMS, _RANGE, _ROUNDING = 5, 1 / 8, 1e-9
#: Two apsidal rates agree if they differ by less than this fraction of them plus this fraction of a turn per run.
_AGREE, _AGREE_TURN = 0.02, 1e-4


class Rates(dict[str, Any]):
    """Rates by the names of elements, which raise an error for an angle that is not defined."""

    def __init__(self, undefined: dict[str, str]) -> None:
        self._undefined = undefined

    def __missing__(self, name: str) -> Any:
        if name in self._undefined:
            raise InvalidInput(f"{name} has no rate: {self._undefined[name]}")
        raise KeyError(name)

    def __reduce__(self) -> Any:
        return Rates, (self._undefined,), None, None, iter(self.items())


@dataclass(frozen=True, eq=False, repr=False)
class ElementRates(ArrayFields):
    """Osculating elements and their rates of change.

    Attributes
    ----------
    elements : KeplerElements
        Elements with arrays (K,), whose angles have no jumps.
    rates : dict of str to ndarray or Quantity
        Instantaneous rates (K,) of ``a``, ``e``, ``i``, ``Omega``, ``omega``, ``M``, ``varpi`` = Omega + omega, ``L`` =
        varpi + M, ``h`` = e sin(varpi) and ``k`` = e cos(varpi), by differences of second order.
    mean_rates : dict of str to float or Quantity
        Slopes of straight lines through the whole run (least squares under a Hann window, to its third power from five
        revolutions on). Both dicts lack angles that are not defined, and say why when they are asked for one: omega,
        varpi and M if the osculating eccentricity comes to zero within its scatter, or samples do not resolve
        periapsis, and Omega and omega if the inclination does so.
    """

    elements: KeplerElements[Array]
    rates: dict[str, Array]
    mean_rates: dict[str, Scalar]

    def as_dict(self) -> dict[str, Any]:
        """Return the mean rates for a table, each with ``_rate`` after the name of its element."""
        return {f"{name}_rate": rate for name, rate in self.mean_rates.items()}


@dataclass(frozen=True, eq=False, repr=False)
class MeanElements(ArrayFields):
    """Means of the osculating elements ``a``, ``e`` and ``i`` of an orbit."""

    a: Scalar
    e: Scalar
    i: Scalar

    def as_dict(self) -> dict[str, Any]:
        """Return ``a``, ``e`` and ``i`` for a table."""
        return {"a": self.a, "e": self.e, "i": self.i}


@dataclass(frozen=True, eq=False, repr=False)
class MutualPeriod(ArrayFields):
    """Periods of the revolutions of one body about another.

    Attributes
    ----------
    time : ndarray or Quantity, (R,)
        Ends of the revolutions, with times counted from the earliest sample.
    period : ndarray or Quantity, (R,)
        The period of each revolution.
    mean : float or Quantity
        2 pi divided by the mean rate of the longitude: the slope of a straight line by least squares under the third
        power of a Hann window, which suppresses terms that recur four times or more. In a run of less than five
        revolutions it is the mean of ``period``, which depends only on the ends of the revolutions.
    drift : float
        Change of the period per unit of time (a pure number); nan for fewer than three revolutions.
    """

    time: Array
    period: Array
    mean: Scalar
    drift: float

    def as_dict(self) -> dict[str, Any]:
        """Return the mean as ``period``, and ``period_drift``, for a table."""
        return {"period": self.mean, "period_drift": self.drift}


@dataclass(frozen=True, eq=False, repr=False)
class Precession(ArrayFields):
    """Precession of an orbit: of its periapsis and its node.

    Attributes
    ----------
    apsidal : float, Quantity or None
        Mean rate of periapsis, positive along the motion, from a direction in the orbit's plane that turns with the
        plane but not in it: the mean of d(omega)/dt + cos(i) d(Omega)/dt, whichever plane i, Omega and omega refer to.
        ``None`` if the distance shows no periapsis, as in a circular orbit, or only variations of another origin.
    nodal : float, Quantity or None
        Mean rate of the node about the axis, d(Omega)/dt. ``None`` if the orbit's pole is nearer to the axis or its
        opposite than 1e-9 radians at half of the samples or more, since the node is then round-off, and if the pole
        goes about the axis another number of times by every second sample.
    argument_of_periapsis : float, Quantity or None
        Mean rate of periapsis from the node, d(omega)/dt, along the motion; ``None`` if either is missing. It vanishes
        at the critical inclination.
    anomalistic_period : float, Quantity or None
        Mean time from periapsis to periapsis.
    sidereal_period : float or Quantity
        Mean period of a revolution in the moving plane: 2 pi divided by the mean of ``|r x v| / r^2``, the rate of the
        angle from the direction that ``apsidal`` is measured from. A longitude about the axis, Omega + omega + M, grows
        faster by (1 - cos i) d(Omega)/dt.
    inclination : ndarray or Quantity, (2,)
        The smallest and the largest angle between the orbit's pole and the axis.
    """

    apsidal: Scalar | None
    nodal: Scalar | None
    argument_of_periapsis: Scalar | None
    anomalistic_period: Scalar | None
    sidereal_period: Scalar
    inclination: Array

    def as_dict(self) -> dict[str, Any]:
        """Return the rates, each with ``_rate`` after its name, periods, ``smallest_`` and ``largest_inclination``."""
        rates = {f"{name}_rate": getattr(self, name) for name in ("apsidal", "nodal", "argument_of_periapsis")}
        periods = {name: getattr(self, name) for name in ("anomalistic_period", "sidereal_period")}
        smallest, largest = self.inclination
        return {**rates, **periods, "smallest_inclination": smallest, "largest_inclination": largest}


def element_rates(run: Record, *, mu: Any = None, body: int | str = 1, about: int | str = 0) -> ElementRates:
    """Compute osculating elements with their rates.

    Parameters
    ----------
    run : Run
    mu : float or Quantity, optional
        Gravitational parameter, as for :meth:`fullbody.Run.elements`.
    body, about : int or str

    Raises
    ------
    InvalidInput
        For a run of less than two revolutions, and for samples half a revolution apart or more.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 200.0, output=0.5)
    >>> rates = fullbody.observables.element_rates(run)
    >>> round(2 * 3.14159265 / rates.mean_rates["L"], 1)
    17.4
    """
    motion = RelativeMotion(run, body, about, 3, "a mean rate", REVOLUTIONS)
    elements = run.elements(mu, body=body, about=about)
    a, e, i, *angles = (without_unit(getattr(elements, name)) for name in ("a", "e", "i", "Omega", "omega", "M"))
    varpi = angles[0] + angles[1]
    columns: dict[str, Floats] = {"a": a, "e": e, "i": i, "h": e * np.sin(varpi), "k": e * np.cos(varpi)}
    for name, angle in zip(("Omega", "omega", "M", "varpi", "L"), (*angles, varpi, varpi + angles[2]), strict=True):
        columns[name] = np.unwrap(angle)
    undefined = _undefined(motion, e, i, *angles[:2])
    rates, means = Rates(undefined), Rates(undefined)
    for name in (name for name in columns if name not in undefined):
        unit = {"a": "velocity", "e": "rate", "h": "rate", "k": "rate"}.get(name, "spin")
        rates[name] = motion.attach(np.gradient(columns[name], motion.time, edge_order=2), unit)
        means[name] = motion.units.attach(signal.slope(motion.time, columns[name], motion.power), unit)
    angles = [motion.attach(columns[name], "angle") for name in ("i", "Omega", "omega", "M")]
    return ElementRates(computed([motion.attach(a, "length"), e, *angles], run.context.frame), rates, means)


def _undefined(motion: RelativeMotion, e: Floats, i: Floats, node: Floats, periapsis: Floats) -> dict[str, str]:
    """Return the angles that have no mean rate, with the reason: those from a node or a periapsis that is not defined.

    Such a direction is that of a vector which comes as near to zero as its length scatters within a revolution, or
    which turns about zero another number of times by every second sample.
    """
    retrograde = bool(np.median(i) > np.pi / 2)
    inclined = np.sin(i) * np.exp(1j * node)
    eccentric = e * np.exp(1j * (periapsis - node if retrograde else periapsis + node))
    reasons: dict[str, str] = {}
    for vector, quantity, names in (
        (inclined, "sine of the inclination", ("Omega", "omega", "varpi", "L") if retrograde else ("Omega", "omega")),
        (eccentric, "eccentricity", ("omega", "varpi", "M")),
    ):
        length = np.abs(vector)
        # A vector that is zero throughout has the direction that elements give it by convention.
        if not length.any():
            continue
        revolution = abs(np.ptp(motion.time)) / motion.revolutions
        scatter = float(np.std(length - signal.averaged(motion.time, length, revolution)))
        angles = (np.unwrap(np.angle(vector[::step])) for step in (1, 2))
        revolutions = [float(angle[-1] - angle[0]) / (2 * np.pi) for angle in angles]
        if length.min() <= scatter or abs(revolutions[0] - revolutions[1]) > 0.5:
            reason = (
                f"the osculating {quantity} of {motion.name} comes to {length.min():.2g}, with a scatter of "
                f"{scatter:.2g} in a revolution, and its direction makes {revolutions[0]:.4g} turns by all samples "
                f"and {revolutions[1]:.4g} by every second one; expected the rates of "
                "L, h = e sin(varpi) and k = e cos(varpi), or orbit_precession"
            )
            reasons |= dict.fromkeys(names, reason)
    return reasons


def mean_elements(run: Record, *, mu: Any = None, body: int | str = 1, about: int | str = 0) -> MeanElements:
    """Compute means of the osculating a, e and i under a Hann window, which suppresses terms that recur several times.

    Parameters
    ----------
    run : Run
    mu : float or Quantity, optional
        Gravitational parameter, as for :meth:`fullbody.Run.elements`.
    body, about : int or str

    Raises
    ------
    InvalidInput
        For a run of less than two revolutions, and for samples half a revolution apart or more.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 500.0, output=1.0)
    >>> round(float(fullbody.observables.mean_elements(run).a), 2)
    2.58
    """
    time = RelativeMotion(run, body, about, 8, "a mean element", REVOLUTIONS).time
    elements = run.elements(mu, body=body, about=about)
    # Each sample is weighted by the length of time around it.
    weight = np.sin(np.pi * (time - time[0]) / (time[-1] - time[0])) ** 2 * np.abs(np.gradient(time))
    weight /= weight.sum()
    return MeanElements(*((getattr(elements, name) * weight).sum() for name in ("a", "e", "i")))


def mutual_period(run: Record, *, body: int | str = 1, about: int | str = 0) -> MutualPeriod:
    """Compute the period of the mutual orbit, revolution by revolution, and its drift.

    The period is sidereal: a revolution is a full turn in the orbit's plane, from a direction that turns with the plane
    but not in it; see :class:`Precession`. In a fixed plane, that is a direction among the stars.

    Parameters
    ----------
    run : Run
    body, about : int or str

    Raises
    ------
    InvalidInput
        For a run of less than two revolutions, and for samples half a revolution apart or more.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 200.0, output=0.5)
    >>> round(float(fullbody.observables.mutual_period(run).mean), 1)
    17.4
    """
    motion = RelativeMotion(run, body, about, 8, "a mutual period", REVOLUTIONS)
    moments = passages(motion)
    ends, period = moments[1:], np.diff(moments)
    drift = signal.slope(ends, period) if len(ends) >= 3 else float("nan")
    mean = 2 * np.pi / motion.mean_motion(motion.path) if len(ends) >= WINDOWED else period.mean()
    return MutualPeriod(motion.span(ends), motion.span(period), motion.span(np.float64(mean)), drift)


def passages(motion: RelativeMotion) -> Floats:
    """Return the earliest time and those at which the longitude has made whole turns since then."""
    longitude, rate = motion.longitude
    order = np.argsort(motion.path.time)
    t, angle, rate = motion.path.time[order], longitude[order], rate[order]
    start = angle[0]
    angle = np.sign(rate.mean()) * (angle - start)
    spline = signal.scipy_module("interpolate").CubicHermiteSpline(t, angle, np.sign(rate.mean()) * rate)
    solve = signal.scipy_module("optimize").brentq
    moments = [t[0]]
    for target in 2 * np.pi * np.arange(1, int(angle[-1] / (2 * np.pi)) + 1):
        k = int(np.argmax(angle >= target))
        moments.append(solve(lambda x, target=target: spline(x) - target, t[k - 1], t[k], xtol=1e-300))
    times: Floats = np.array(moments)
    # A spline errs on eccentric orbits; Newton's method along the Kepler orbits refines its times.
    for _ in range(3):
        angle, rate = motion.longitude_at(times)
        times = times - (np.remainder(angle - start + np.pi, 2 * np.pi) - np.pi) / rate
    return times


def orbit_precession(run: Record, *, axis: Any = None, body: int | str = 1, about: int | str = 0) -> Precession:
    """Compute the mean apsidal and nodal precession of an orbit.

    The apsidal rate is the mean motion in the orbit's plane less the frequency of the distance. Unlike the slope of the
    osculating longitude of periapsis, it holds for orbits so nearly circular that perturbations dominate their
    osculating eccentricity. The frequency is the strongest within an eighth of the mean motion, if its term is above
    1e-9 of the distance and no other term there is half as strong; rotations and librations of the bodies have
    frequencies of their own. The nodal rate is the rate at which the orbit's pole turns about an axis.

    Parameters
    ----------
    run : Run
        More revolutions than five give better means.
    axis : array_like, (3,), optional
        The pole of the reference plane of the nodes; by default the total angular momentum at the start.
    body, about : int or str

    Raises
    ------
    InvalidInput
        For a run of less than five revolutions, and for samples too far apart: the apsidal rate from every second
        sample has to agree with that from all, to a fiftieth of it or a ten-thousandth of a turn over the run.

    Notes
    -----
    For an orbit about an oblate body with a fixed axis, to first order in J2 and with n the mean motion and p = a (1 -
    e^2): the node moves by -3/2 n J2 (R/p)^2 cos i and the argument of periapsis by 3/4 n J2 (R/p)^2 (5 cos^2 i - 1)
    (Murray & Dermott 1999, Solar System Dynamics, Sec. 6.11), so that ``apsidal`` is 3/4 n J2 (R/p)^2 (3 cos^2 i - 1).

    In a plane that turns there is no fixed direction to measure from. The node turns in it by cos(i) d(Omega)/dt, and
    a fixed plane that the orbit is projected on shows another rate after whole turns of the node than after a part of
    one. The direction that does not turn in the plane is the departure point of Hansen's ideal frame: from it the true
    longitude grows by ``|r x v| / r^2``, without a term of the plane's own motion (Deprit 1976, Celest. Mech. 13, 253;
    Lara & Urrutxua 2023, Universe 9, 470).

    Examples
    --------
    Two points do not precess.

    >>> import fullbody
    >>> system, state = fullbody.systems.kw4(gravity="point")
    >>> run = system.integrate(state, 20 * 17.4, output=0.5)
    >>> bool(abs(fullbody.observables.orbit_precession(run).apsidal) < 1e-6)
    True
    """
    motion = RelativeMotion(run, body, about, 16, "precession", WINDOWED)
    sidereal, radial = frequencies(motion, motion.path)
    if radial is not None:
        _check_halved(motion, sidereal - radial)
    nodal, inclination = motion.precession(motion.normal, axis)
    draconic = None if nodal is None or radial is None else motion.rate_from_node(axis) - radial
    return Precession(
        motion.rate(None if radial is None else sidereal - radial),
        motion.rate(nodal),
        motion.rate(draconic),
        motion.span(None if radial is None else 2 * np.pi / radial),
        motion.span(2 * np.pi / sidereal),
        motion.angle(np.array([inclination.min(), inclination.max()])),
    )


def frequencies(motion: RelativeMotion, path: Path) -> tuple[float, float | None]:
    """Return the mean motion, and the frequency at which periapsis recurs, or ``None`` without one."""
    sidereal = motion.mean_motion(path)
    distance = np.linalg.norm(path.r, axis=1)
    terms = zip(*signal.periodic_terms(path.time, distance, _TERMS), strict=True)
    radial = [(size, float(rate)) for rate, size in terms if abs(rate / sidereal - 1) < _RANGE]
    (first, rate), (second, _), *_ = *sorted(radial, reverse=True), (0.0, 0.0), (0.0, 0.0)
    if first == 0.0 or first < _ROUNDING * distance.mean() or second > first / 2:
        return sidereal, None
    return sidereal, rate


def _check_halved(motion: RelativeMotion, apsidal: float) -> None:
    """Raise an error if every second sample alone gives another precession."""
    sidereal, radial = frequencies(motion, motion.every_second())
    allowed = _AGREE * abs(apsidal) + _AGREE_TURN * 2 * np.pi / abs(motion.time[-1] - motion.time[0])
    if radial is None or abs(sidereal - radial - apsidal) > allowed:
        other = "none" if radial is None else f"{motion.rate(sidereal - radial):.4g}"
        raise InvalidInput(
            f"the apsidal rate is {motion.rate(apsidal):.4g} by all samples, but {other} by every second one; "
            f"precession needs samples closer together ({motion.denser_output()})"
        )
