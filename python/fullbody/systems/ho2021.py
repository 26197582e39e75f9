"""1999 KW4 and the dimensionless cases of Ho, Wold, Conway & Poursina (2021)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..base.arguments import options_of, refuse_unknown
from ..base.units import Units
from ..errors import InvalidInput
from ..model.bodies import Body
from ..model.shapes import Ellipsoid
from ..model.state import State
from ..motion.system import System
from ..orbit.elements import KeplerElements
from ._build import UnitsChoice, base_units, in_units, with_epoch
from ._published import Published, Value, documented
from ._sun import ELEMENTS, EPOCH, SOURCE, heliocentric, with_sun

__all__ = ["case1", "case2", "kw4", "kw4_ho2021"]

#: Newton's constant of the authors' published program, 6.67408e-11 m^3 kg^-1 s^-2, in km^3 kg^-1 hour^-2.
_G_HO2021 = 6.67408e-11 * 1e-9 * 3600.0**2
_KW4_MASSES = (2.353e12, 0.135e12)
_KW4_AXES = ((0.766, 0.7475, 0.6735), (0.285, 0.2315, 0.1745))
_KW4_POLE_TILT = 3.2
#: The pole of the published inclination and node, referred to Earth's equator of J2000.
_KW4_POLE = (325.8, -61.8)
KW4_SPINS = (2.2728, 0.3611)
KW4_ORBIT = {"a": 2.548, "e": 0.0004, "M": 0.0}
KW4_SKY = {"i": 156.1, "Omega": 105.4, "omega": 319.7}

FACTS = Published(
    values={
        "semi-axes of Alpha": Value(_KW4_AXES[0], "km", "", "H21"),
        "semi-axes of Beta": Value(_KW4_AXES[1], "km", "", "H21"),
        "mass of Alpha": Value(_KW4_MASSES[0], "kg", "", "H21"),
        "mass of Beta": Value(_KW4_MASSES[1], "kg", "", "H21"),
        "rotation rate of Alpha": Value(KW4_SPINS[0], "rad/h", "", "H21"),
        "rotation rate of Beta (not used)": Value(KW4_SPINS[1], "rad/h", "", "H21"),
        "tilt of Alpha's pole from the orbit's": Value(_KW4_POLE_TILT, "deg", "", "O06"),
        "semi-major axis": Value(KW4_ORBIT["a"], "km", "", "O06"),
        "eccentricity": Value(KW4_ORBIT["e"], "", "", "O06"),
        "inclination (not used)": Value(KW4_SKY["i"], "deg", "", "O06"),
        "ascending node (not used)": Value(KW4_SKY["Omega"], "deg", "", "O06"),
        "argument of periapsis (not used)": Value(KW4_SKY["omega"], "deg", "", "O06"),
        "pole of the orbit (ecliptic longitude, latitude), for the Sun": Value(_KW4_POLE, "deg", "", "O06"),
        **heliocentric((0.6422, 0.6886, 38.884, 244.91, 192.62, 359.03), 2458000.5),
    },
    sources={
        "JPL": SOURCE,
        "H21": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35, "
        "doi:10.1007/s10569-021-10034-8; its Table 2, with the semi-axes unrounded as in the authors' input",
        "O06": "Ostro et al. (2006), Science 314, 1276, doi:10.1126/science.1133622, as [H21] quotes it",
    },
    assumed=(
        "the orbit's plane is the xy-plane, with periapsis at the start on the x-axis: to which plane the published "
        "inclination, node and argument of periapsis are referred, [H21] does not say",
        "Alpha's pole is tilted by the nominal angle ([O06]: 0 to 7.5 degrees), about the x-axis",
        "Beta spins about the pole of the orbit at the mean motion, its longest axis towards Alpha",
        "the Sun needs the orbit's pole in the ecliptic: it is that of the published inclination and node if these are "
        "referred to Earth's equator of J2000, and the x-axis is then the orbit's node on the ecliptic",
        "the elements are osculating, as [H21] takes them: the run keeps them, not the published period",
    ),
    frame="orbit",
    second_hand=(
        ELEMENTS,
        EPOCH,
        "tilt of Alpha's pole from the orbit's",
        "semi-major axis",
        "eccentricity",
        "inclination (not used)",
        "ascending node (not used)",
        "argument of periapsis (not used)",
    ),
)


def kw4_ho2021(
    shape: Literal["ellipsoid", "spheroid"] = "ellipsoid",
    *,
    units: UnitsChoice = False,
    **options: Any,
) -> tuple[System, State]:
    """The paper's run of (66391) 1999 KW4, to the letter (its Table 2 with the unrounded input).

    Alpha starts at rest at the origin with phi = 3.2 degrees; Beta has the whole relative state of
    (a, e, i, Omega, omega, M) with zero angles; both spin about the body z-axis. The paper combines the elements of
    Ostro et al. (2006), which refer to an astronomical frame that it does not name, with spins along the inertial
    z-axis: the orbit is retrograde to both spins (156.8 degrees), while the real one is prograde within a few degrees
    of Alpha's equator, as in :func:`kw4`. For the same reason ``frame=`` is refused: the axes belong to no frame.
    Referred to Earth's equator of J2000, i and Omega put the orbit's pole at ecliptic longitude 325.8 and latitude
    -61.8 degrees.

    Parameters
    ----------
    shape : {"ellipsoid", "spheroid"}
        Spheroids have b = a, as in the paper.
    units : bool or (length, time, mass)
        ``True`` for Quantities in km, hour, kg, or three units for Quantities in these. Plain numbers are km, hour, kg.
    **options
        Passed to :class:`fullbody.System`.

    Returns
    -------
    system : System
    state : State

    Notes
    -----
    One year from this start gives the paper's ranges and means of the semi-major axis and its largest eccentricities,
    to the digits printed and for both shapes. Three things that the paper prints do not follow from it, by two methods
    of gravity, two integrators and two charts that agree with each other. The documentation's page on the paper shows
    the evidence and sets possible explanations side by side.

    - The range of Beta's spin over the first 200 hours. The paper prints z in [9.55, 11.16]e-5 rad/s; here it is
      [9.05, 10.69]e-5. It prints x and y within 1.89e-5 and 3.23e-5; here they are within 2.15e-5 and 3.45e-5. All six
      printed numbers come out when Beta starts turned by 20.7 degrees (20.55 to 20.86) against the orbital motion, to
      (phi, theta, psi) = (-8.05, -0.87, 19.12) degrees. The orbit moves by 20.67 degrees an hour, and Beta's rate of
      spin read as an angle is 20.69 degrees. The year's semi-major axes are not the printed ones from there.
    - The time between maxima of the inclination. The paper prints about 3900 (ellipsoids) and 3400 h; here it is 4246
      and 3741 h. No retrograde inclination of the orbit gives the printed times. The inclination to the xy-plane starts
      near its largest and is largest again after 3928 and 3470 h, which may be what was read off.
    - The last digit of the mean period. The paper prints 17.4116 and 17.4177 h; here it is 17.4115 and 17.4176 h. The
      year run with G = 6.674e-11 in place of 6.67408e-11 gives the printed digits for both shapes. The paper does not
      print its G.

    References
    ----------
    Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35, doi:10.1007/s10569-021-10034-8.
    Ostro et al. (2006), Science 314, 1276, doi:10.1126/science.1133622.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4_ho2021("spheroid")
    >>> system.bodies[0].shape
    Ellipsoid(a=0.766, b=0.766, c=0.6735)
    """
    _refuse_frame(options, "the elements and the spins of this system are of different frames")
    system = _kw4_system(shape, units, with_epoch(options, None))
    angles = {name: np.deg2rad(value) for name, value in KW4_SKY.items()}
    position, velocity = KeplerElements(**KW4_ORBIT, **angles).to_cartesian(_kw4_mu())
    rest, spins = [0.0, 0.0, 0.0], [[0.0, 0.0, spin] for spin in KW4_SPINS]
    state = _kw4_state(system, [rest, position], [rest, velocity], spins)
    return in_units(system, state, units)


@documented(FACTS)
def kw4(
    shape: Literal["ellipsoid", "spheroid"] = "ellipsoid",
    *,
    frame: Literal["orbit"] | None = None,
    sun: bool = False,
    units: UnitsChoice = False,
    **options: Any,
) -> tuple[System, State]:
    """The physical (66391) 1999 KW4: prograde, near Alpha's equator, Beta synchronous.

    Bodies, masses, a and e are those of :func:`kw4_ho2021`, and so is the reading of a and e as elements of the start.
    By Kepler's third law they make the published period of 17.42 h; but Alpha is oblate and Beta long, which both add
    to the attraction, and the mutual period of the run is 17.10 h (spheroids: 17.12 h). :func:`fullbody.binary` makes a
    start that keeps a period. The barycentre rests at the origin.

    Parameters
    ----------
    shape : {"ellipsoid", "spheroid"}
        Spheroids have b = a.
    frame : "orbit", optional
        The only accepted value: the orbit's plane is the xy-plane. It cannot be turned to the ecliptic or the equator,
        since the frame of the published inclination and node is not known.
    sun : bool
        Whether the Sun's gravity acts, as a :class:`fullbody.forces.ThirdBody` on the heliocentric orbit of the table
        below: at time zero as at the epoch of its elements, unless the system has an ``epoch``. The
        orbit's pole in the ecliptic, which that needs, is known less well: see the assumptions.
    {units}

    Returns
    -------
    system : System
    state : State

    Notes
    -----
    {published}

    References
    ----------
    Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35, doi:10.1007/s10569-021-10034-8.
    Ostro et al. (2006), Science 314, 1276, doi:10.1126/science.1133622.
    Fahnestock & Scheeres (2008), Icarus 194, 410, doi:10.1016/j.icarus.2007.11.007.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> state.position[1, 0]
    <Quantity 2.40878048 km>
    """
    if frame is not None and not (isinstance(frame, str) and frame == "orbit"):
        raise InvalidInput(
            f"frame is {frame!r}; expected 'orbit': the frame of the published inclination and node is not known"
        )
    system = _kw4_system(shape, units, {**with_epoch(options, None), "frame": frame})
    mu = _kw4_mu()
    orbit = KeplerElements(**KW4_ORBIT, i=0.0, Omega=0.0, omega=0.0)
    position, velocity = orbit.to_cartesian(mu)
    share = np.array([-_KW4_MASSES[1], _KW4_MASSES[0]])[:, None] / sum(_KW4_MASSES)
    spins = [[0.0, 0.0, KW4_SPINS[0]], [0.0, 0.0, 2.0 * np.pi / orbit.period(mu)]]
    state = _kw4_state(system, share * position, share * velocity, spins)
    system, state = in_units(system, state, units)
    return with_sun(system, FACTS, sun, frame, _KW4_POLE), state


def case1(**options: Any) -> tuple[System, State]:
    """The paper's case 1: two oblate spheroids without spin, tilted about x; they begin to tumble near t = 75.

    Under a half turn about z the system maps onto itself with the bodies swapped: z stays zero, and the growing
    z-motion of the paper is numerical.

    Parameters
    ----------
    **options
        Passed to :class:`fullbody.System`.

    Returns
    -------
    system : System
    state : State

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> state.position[:, 0]
    array([-4.,  4.])
    """
    tilt = np.pi / 32
    return _case([[tilt, 0.0, 0.0], [-tilt, 0.0, 0.0]], 0.0, options)


def case2(theta_0: Any = np.pi / 32, **options: Any) -> tuple[System, State]:
    """The paper's case 2: two oblate spheroids that spin like tops, tilted about y.

    Parameters
    ----------
    theta_0 : float or Quantity
        The tilt, in radians unless it says otherwise; the paper also remarks on pi/8.
    **options
        Passed to :class:`fullbody.System`.

    Returns
    -------
    system : System
    state : State

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case2()
    >>> state.spin[0]
    array([0., 0., 2.])
    """
    tilt = Units().number(theta_0, "angle", "theta_0")
    return _case([[0.0, tilt, 0.0], [0.0, -tilt, 0.0]], 2.0, options)


def _case(angles: Any, spin: float, options: dict[str, Any]) -> tuple[System, State]:
    _refuse_frame(options, "this system is dimensionless, and its axes belong to no frame")
    refuse_unknown(
        options, (name for name in options_of(System) if name not in ("bodies", "G", "frame")), "this system"
    )
    bodies = [Body(Ellipsoid(1.0, 1.0, 0.25), mass=2.0, name=name) for name in "AB"]
    state = State.from_tait_bryan(
        position=[[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0]],
        velocity=[[0.0, 0.3, 0.0], [0.0, -0.3, 0.0]],
        angles=angles,
        spin=[[0.0, 0.0, spin]] * 2,
    )
    system = System(bodies, G=1.0, **options)
    return system, state._named(system.names)


def _refuse_frame(options: dict[str, Any], why: str) -> None:
    """Raise an error for the name of a frame, since the axes belong to none."""
    if (frame := options.pop("frame", None)) is not None:
        raise InvalidInput(f"frame is {frame!r}; expected none: {why}")


def _kw4_mu() -> float:
    return _G_HO2021 * sum(_KW4_MASSES)


def _kw4_system(shape: str, units: UnitsChoice, options: dict[str, Any]) -> System:
    if not isinstance(shape, str) or shape not in ("ellipsoid", "spheroid"):
        raise InvalidInput(f"shape is {shape!r}; expected 'ellipsoid' or 'spheroid'")
    bodies = []
    for name, mass, (a, b, c) in zip(("Alpha", "Beta"), _KW4_MASSES, _KW4_AXES, strict=True):
        bodies.append(Body(Ellipsoid(a, a if shape == "spheroid" else b, c), mass=mass, name=name))
    return System(bodies, G=_G_HO2021, units=base_units(units), **options)


def _kw4_state(system: System, position: Any, velocity: Any, spin: Any) -> State:
    """Return the state at time zero, with Alpha's pole tilted about the x-axis; numbers in km, hour."""
    attach = system._units.attach
    return State.from_tait_bryan(
        attach(np.array(position), "length"),
        attach(np.array(velocity), "velocity"),
        [[np.deg2rad(_KW4_POLE_TILT), 0.0, 0.0], [0.0, 0.0, 0.0]],
        attach(np.array(spin), "spin"),
        attach(np.float64(0.0), "time"),
    )
