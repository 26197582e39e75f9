"""Elements, periods and precession of an orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import named_options
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..orbit.elements import KeplerElements
from ..typing import Array, Scalar
from . import _signal as signal
from ._follow import Path
from ._relative import REVOLUTIONS, WINDOWED, RelativeMotion

if TYPE_CHECKING:
    from ..record.base import BaseRun

__all__ = ["ElementRates", "MutualPeriod", "Precession", "element_rates", "mutual_period", "orbit_precession"]

_Array = npt.NDArray[np.float64]
#: How many periodic terms of the distance are computed, how near to the mean motion the frequency of periapsis is, and
#: the size of that term relative to the distance below which it may be an error of the run.
_TERMS, _NEAR, _ROUND = 5, 1 / 8, 1e-9
#: Two apsidal rates agree if they differ by less than this part of them plus this part of a turn over the run.
_AGREE, _TURNED = 0.02, 1e-4


@dataclass(frozen=True, eq=False, repr=False)
class ElementRates(ArrayFields):
    """Osculating elements and how fast they change.

    Attributes
    ----------
    elements : KeplerElements
        Elements with arrays (K,), whose angles have no jumps.
    rates : dict of str to ndarray or Quantity
        Present rates of ``a``, ``e``, ``i``, ``Omega``, ``omega``, ``M`` (K,), by differences of second order.
    mean_rates : dict of str to float or Quantity
        Slopes of straight lines through the whole run (least squares under a Hann window, from five revolutions on to
        the third power), also of the longitudes ``varpi`` = Omega + omega and ``L`` = varpi + M. Where perturbations
        rule a small eccentricity, varpi and M alone mean little.
    """

    elements: KeplerElements[Array]
    rates: dict[str, Array]
    mean_rates: dict[str, Scalar]


@dataclass(frozen=True, eq=False, repr=False)
class MutualPeriod(ArrayFields):
    """Revolutions of one body about another.

    Attributes
    ----------
    time : ndarray or Quantity, (R,)
        Ends of the revolutions, counted from the earliest time.
    period : ndarray or Quantity, (R,)
        The period of each revolution.
    mean : float or Quantity
        2 pi by the mean rate of the longitude over the run: the slope of a straight line of least squares under the
        third power of a Hann window. It takes all samples and leaves next to nothing of what recurs four times or more;
        the mean of ``period``, which the ends of the revolutions alone decide, differs a little. In a run of less than
        five revolutions it is that mean.
    drift : float
        Change of the period per unit of time (a pure number); nan for fewer than three revolutions.
    """

    time: Array
    period: Array
    mean: Scalar
    drift: float


@dataclass(frozen=True, eq=False, repr=False)
class Precession(ArrayFields):
    """Slow turns of an orbit.

    Attributes
    ----------
    apsidal : float, Quantity or None
        Mean rate of periapsis, in radians per unit of time and positive along the motion, from a direction in the
        orbit's plane that turns with the plane but not in it: the mean of d(omega)/dt + cos(i) d(Omega)/dt, whichever
        plane i, Omega and omega are referred to. It does not depend on the axis nor on how long the run is. ``None``
        where the distance shows no periapsis: in a circular orbit, and where what it shows is of other origin.
    nodal : float, Quantity or None
        Mean rate of the node about the axis, d(Omega)/dt. ``None`` where the orbit's pole is nearer to the axis, or to
        its opposite, than 1e-9 radians at half of the samples or more: such an orbit has no node but by round-off.
    argument_of_periapsis : float, Quantity or None
        Mean rate of periapsis from the node, d(omega)/dt, along the motion; ``None`` where either has none. It vanishes
        at the critical inclination. The longitude of periapsis, Omega + omega, moves by this and ``nodal`` together.
    anomalistic_period : float, Quantity or None
        The mean time from periapsis to periapsis.
    sidereal_period : float or Quantity
        The mean period of a revolution in the moving plane: 2 pi divided by the mean of ``|r x v| / r^2``, the rate of
        the angle from the direction that ``apsidal`` is measured from. A longitude about the axis, Omega + omega + M,
        is faster by (1 - cos i) d(Omega)/dt.
    inclination : ndarray or Quantity, (2,)
        The least and the greatest angle between the orbit's pole and the axis, radians.
    """

    apsidal: Scalar | None
    nodal: Scalar | None
    argument_of_periapsis: Scalar | None
    anomalistic_period: Scalar | None
    sidereal_period: Scalar
    inclination: Array


@named_options
def element_rates(run: BaseRun, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> ElementRates:
    """Osculating elements with their rates.

    Parameters
    ----------
    run : Run
    mu : float or Quantity, optional
        As for :meth:`fullbody.Run.elements`.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    ElementRates

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
    17.1
    """
    motion = RelativeMotion(run, body, about, 3, "a mean rate", REVOLUTIONS)
    elements = run.elements(mu, body=body, about=about)
    columns: dict[str, Any] = {}
    rates: dict[str, Any] = {}
    means: dict[str, Any] = {}
    for name in ("a", "e", "i", "Omega", "omega", "M"):
        dimension = {"a": "length", "e": None}.get(name, "angle")
        values = np.asarray(getattr(getattr(elements, name), "value", getattr(elements, name)))
        if name in ("Omega", "omega", "M"):
            values = signal.unwrapped(values)
        columns[name] = values
        unit = {"length": "velocity", "angle": "spin"}.get(dimension or "")
        for result, number in (
            (rates, np.gradient(values, motion.time, edge_order=2)),
            (means, motion.mean_rate(values)),
        ):
            result[name] = _per_time(motion, number) if unit is None else motion.units.attach(number, unit)
    varpi = signal.unwrapped(columns["Omega"] + columns["omega"])
    longitude = signal.unwrapped(columns["Omega"] + columns["omega"] + columns["M"])
    means["varpi"] = motion.rate(motion.mean_rate(varpi))
    means["L"] = motion.rate(motion.mean_rate(longitude))
    attached = [
        motion.units.attach(columns["a"], "length"),
        columns["e"],
        *(motion.angle(columns[name]) for name in ("i", "Omega", "omega", "M")),
    ]
    return ElementRates(KeplerElements._trusted(attached, run.system.frame), rates, means)


def _per_time(motion: RelativeMotion, number: Any) -> Any:
    return number / motion.units.unit("time") if motion.units.known else number


@named_options
def mutual_period(run: BaseRun, *, body: int | str = 1, about: int | str = 0) -> MutualPeriod:
    """The period of the mutual orbit, revolution by revolution, and its drift.

    Sidereal: a revolution is a whole turn in the orbit's plane, from a direction that turns with the plane but not in
    it; see :class:`Precession`. In a plane that stays, that is a direction among the stars.

    Parameters
    ----------
    run : Run
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    MutualPeriod

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
    17.1
    """
    motion = RelativeMotion(run, body, about, 8, "a mutual period", REVOLUTIONS)
    moments = passages(motion)
    turns = len(moments) - 1
    ends = moments[1:]
    period = np.diff(moments)
    drift = float("nan")
    if turns >= 3:
        drift = signal.slope(ends, period)
    mean = 2 * np.pi / motion.mean_motion(motion.path) if turns >= WINDOWED else period.mean()
    return MutualPeriod(motion.span(ends), motion.span(period), motion.span(np.float64(mean)), drift)


def passages(motion: RelativeMotion) -> _Array:
    """The times at which the longitude has made whole turns since the earliest time, which is the first of them."""
    longitude, rate = motion.longitude
    order = np.argsort(motion.path.time)
    t, angle, rate = motion.path.time[order], longitude[order], rate[order]
    start = angle[0]
    angle = np.sign(rate.mean()) * (angle - start)
    spline = signal.scipy_module("interpolate").CubicHermiteSpline(t, angle, np.sign(rate.mean()) * rate)
    solve = signal.scipy_module("optimize").brentq
    moments = [t[0]]
    for target in 2 * np.pi * np.arange(1, int(angle[-1] / (2 * np.pi)) + 1):
        after = int(np.argmax(angle >= target))
        moments.append(solve(lambda x, target=target: spline(x) - target, t[after - 1], t[after], xtol=1e-300))
    return _sharpened(motion, np.array(moments), start)


def _sharpened(motion: RelativeMotion, moments: _Array, start: float) -> _Array:
    """Passages of a longitude, improved by Newton's method along the Kepler orbits: a spline errs on eccentric ones."""
    for _ in range(3):
        angle, rate = motion.longitude_at(moments)
        missed = np.remainder(angle - start + np.pi, 2 * np.pi) - np.pi
        moments = moments - missed / rate
    return moments


@named_options
def orbit_precession(run: BaseRun, axis: Any = None, *, body: int | str = 1, about: int | str = 0) -> Precession:
    """Mean apsidal and nodal precession of an orbit.

    The apsidal rate is the mean motion in the orbit's plane less the frequency of the distance: unlike the slope of the
    osculating longitude of periapsis it holds for orbits so round that perturbations rule their osculating
    eccentricity. That frequency is the strongest within an eighth of the mean motion, if it is above 1e-9 of the
    distance and another there is not half as strong; the bodies' turning and librating beneath each other have
    frequencies of their own. The nodal rate is how fast the orbit's pole goes about an axis.

    Parameters
    ----------
    run : Run
        A run of several revolutions; the more, the better the means.
    axis : array_like, (3,), optional
        The pole of the plane that nodes lie in; the total angular momentum at the start unless given.
    body, about : int or str
        Places in the system, or names.

    Returns
    -------
    Precession

    Raises
    ------
    InvalidInput
        For a run of less than five revolutions; and for samples too far apart: the apsidal rate by every second of them
        has to agree with that by all, to a fiftieth of it or a ten-thousandth of a turn over the run.

    Notes
    -----
    Outside an oblate body that keeps its axis, to the first order in J2 and with n the mean motion and p = a (1 - e^2):
    the node moves by -3/2 n J2 (R/p)^2 cos i and the argument of periapsis by 3/4 n J2 (R/p)^2 (5 cos^2 i - 1) (Murray
    & Dermott 1999, Solar System Dynamics, Sec. 6.11), so that ``apsidal`` is 3/4 n J2 (R/p)^2 (3 cos^2 i - 1).

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
    nodal, inclination = motion.turning(motion.normal, axis)
    draconic = None if nodal is None or radial is None else motion.from_node(axis)
    return Precession(
        None if radial is None else motion.rate(np.float64(sidereal - radial)),
        None if nodal is None else motion.rate(np.float64(nodal)),
        None if draconic is None or radial is None else motion.rate(np.float64(draconic - radial)),
        None if radial is None else motion.span(np.float64(2 * np.pi / radial)),
        motion.span(np.float64(2 * np.pi / sidereal)),
        motion.angle(np.array([inclination.min(), inclination.max()])),
    )


def frequencies(motion: RelativeMotion, path: Path) -> tuple[float, float | None]:
    """The mean motion, and the frequency at which periapsis recurs, where there is one."""
    sidereal = motion.mean_motion(path)
    distance = np.linalg.norm(path.r, axis=1)
    terms = zip(*signal.lines(path.time, distance, _TERMS), strict=True)
    near = sorted(
        ((size, float(rate)) for rate, size in terms if abs(rate / sidereal - 1) < _NEAR), key=lambda t: -t[0]
    )
    if not near or near[0][0] < _ROUND * distance.mean():
        return sidereal, None
    if len(near) > 1 and near[1][0] > near[0][0] / 2:
        return sidereal, None
    return sidereal, near[0][1]


def _check_halved(motion: RelativeMotion, apsidal: float) -> None:
    """Refuse samples if every second one alone gives another precession."""
    sidereal, radial = frequencies(motion, motion.halved())
    allowed = _AGREE * abs(apsidal) + _TURNED * 2 * np.pi / abs(motion.time[-1] - motion.time[0])
    if radial is None or abs(sidereal - radial - apsidal) > allowed:
        found = "none" if radial is None else f"{motion.rate(np.float64(sidereal - radial)):.4g}"
        raise InvalidInput(
            f"the apsidal rate is {motion.rate(np.float64(apsidal)):.4g} by all samples, but {found} by every second "
            f"one; precession needs samples closer together ({motion.closer()})"
        )
