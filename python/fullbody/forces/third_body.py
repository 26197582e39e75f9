"""Third bodies, such as the Sun or a planet that passes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, Self

import numpy as np

import fullbody._core as _core

from ..base import epochs
from ..base.kinds import Number, instance, of_kind
from ..base.limits import POSITIVE
from ..base.splines import relative_error
from ..base.tables import number
from ..base.units import AnyUnits, Units
from ..errors import InvalidInput
from ..frames import rotation
from ..model.context import Context
from ..model.force import Force
from ..orbit.elements import DIMENSIONS, KeplerElements

#: The names of elements in errors.
_NOUNS = {"a": "semi-major axis", "e": "eccentricity"}
#: The relative error of a table's spline above which there is a warning; the error of the gravity is three times it.
_COARSE = 1e-3
#: The size of a tide relative to the gravity of the bodies below which it has no effect.
_SMALLEST_TIDE = 1e-16
#: Dates closer to each other than this, in s, are equal.
_SAME_DATE = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ThirdBody(Force):
    """The gravity of a point mass on a prescribed path: force and torque on every body, near and far.

    The path is a Kepler orbit or a table of positions, relative to the system's nominal barycentre, which moves as if
    there were no external forces. The system does not move the third body; the barycentre offset that forces cause,
    such as gravity on the quadrupoles, is computed.

    Parameters
    ----------
    mass, mu, GM : float or Quantity
        Mass of the third body, or G times it as ``mu`` or ``GM``; one of them is given.
    orbit : KeplerElements
        The path as an orbit; its mu is that of the third body and the system together. Elements with a frame are turned
        into the frame of the system, and others are taken to be in it.
    of : {"system", "body"}
        The body whose path is given: ``"system"`` for the path of the system about the third body (an orbit round the
        Sun), ``"body"`` for the path of the third body about the system (a planet that passes).
    time : float or Quantity
        Time of a state to which the mean anomaly of ``orbit`` refers.
    times, positions : array_like or Quantity, (T,) and (T, 3)
        The path as a table, interpolated by a cubic spline (not-a-knot). Runs beyond the table are refused, and there
        is a warning if rows are too far apart for the spline.
    frame : str or astropy frame, optional
        The axes of ``positions``, by a name of :mod:`fullbody.frames`; those of the system unless given.
    date : astropy Time or str, optional
        The date of time zero of the path. A system with a different :attr:`~fullbody.System.epoch` is refused.
    name : str

    Raises
    ------
    InvalidInput
        For invalid arguments, and when a system is made or run: for a third body that is or comes inside the system,
        and for a table that ends before the run does.

    Notes
    -----
    The acceleration of a point relative to the barycentre is Battin's (1999, section 8.4), which loses no digits. The
    effect of a body's extent, and the torque, follow by the third law from its own exact field at the third body.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> orbit = fullbody.KeplerElements(a=95.7e6, e=0.69, i=0.68, Omega=4.29, omega=3.37, M=0.2)
    >>> sun = fullbody.forces.ThirdBody(mass=1.98841e30, orbit=orbit, of="system", name="Sun")
    >>> run = system.with_forces([sun]).integrate(state, 20.0)
    >>> run.work["Sun"].shape == run.time.shape
    True
    """

    mass: Any = field(default=None, metadata=of_kind(Number("mass", POSITIVE)))
    mu: Any = field(default=None, metadata=of_kind(Number("mu", POSITIVE)))
    orbit: KeplerElements[Any] | None = field(
        default=None, metadata=of_kind(partial(instance, kind=KeplerElements, expected="KeplerElements"))
    )
    of: str | None = None
    time: Any = field(default=0.0, metadata=of_kind(Number("time")))
    times: Any = field(default=None, metadata=of_kind(Number("time", shape=("T",))))
    positions: Any = field(default=None, metadata=of_kind(Number("length", shape=("T", 3))))
    frame: Any = None
    date: Any = None
    GM: Any = field(default=None, metadata=of_kind(Number("mu", POSITIVE)))

    depends_on_velocity: ClassVar[bool] = False
    _called = "third body"

    def _check(self) -> None:
        name = self.name
        if self.GM is not None and self.mu is None:
            object.__setattr__(self, "mu", self.GM)
            object.__setattr__(self, "GM", None)
        if self.GM is not None:
            raise InvalidInput(f"GM and mu of {name} are {self.GM!r} and {self.mu!r}; expected one of the two")
        if (self.mass is None) == (self.mu is None):
            raise InvalidInput(f"mass and mu of {name} are {self.mass!r} and {self.mu!r}; expected one of the two")
        table = (self.times is not None, self.positions is not None)
        if (self.orbit is None) != all(table) or table[0] != table[1]:
            raise InvalidInput(f"the path of {name} is not clear; expected orbit, or else times and positions")
        if self.orbit is not None and self.frame is not None:
            expected = "expected KeplerElements(..., frame=)"
            raise InvalidInput(f"frame of {name} is {self.frame!r} beside an orbit; {expected}")
        if self.date is not None:
            object.__setattr__(self, "date", epochs.to_text(self.date, f"date of {name}"))
        if self.of not in ("system", "body"):
            raise InvalidInput(
                f"the argument 'of' of {name} is {self.of!r}; expected 'system' (the path is the system's about the "
                "third body) or 'body' (it is the third body's about the system)"
            )

    @classmethod
    def from_ephemeris(
        cls,
        name: str,
        date: Any,
        *,
        orbit: KeplerElements[Any],
        duration: Any,
        epoch: Any = None,
        ephemeris: str = "builtin",
        frame: Any = "ecliptic",
        units: tuple[object, object, object] | bool | None = None,
    ) -> Self:
        """Make the Sun or a planet, with positions of an ephemeris relative to a system on its orbit about the Sun.

        The table of positions is so dense that its cubic spline has an error of at most 1e-9 of the distance.

        Parameters
        ----------
        name : str
            ``"sun"``, ``"earth"``, ``"moon"``, ``"jupiter"`` and so on; capitalised, it becomes the third body's name.
        date : astropy Time or str
            Date of time zero of the states, such as ``"2022-09-26T00:00:00 TDB"``; a system with another epoch is
            refused.
        orbit : KeplerElements
            Orbit of the system about the Sun, in the ecliptic of J2000 or in its elements' own frame.
        duration : float, Quantity or str
            Length of the path from the date; negative for a path back in time.
        epoch : astropy Time or str, optional
            Date to which the mean anomaly of the orbit refers; by default ``date``.
        ephemeris : str
            ``"builtin"`` of astropy, ``"de432s"`` and others that it loads, or the path of a file; all but the first
            need the package jplephem.
        frame : str or array_like, (3, 3)
            The axes of the system: a name (see :mod:`fullbody.frames`), or the matrix that turns components in the
            ecliptic of J2000 into components along the system's axes.
        units : (length, time, mass) or bool, optional
            The units of plain numbers, for a system without units; otherwise all values are Quantities.

        Raises
        ------
        InvalidInput

        Notes
        -----
        The system moves on the Kepler orbit; perturbations by planets are neglected: for a close flyby give the orbit
        of the planet about the system. The built-in ephemeris is that of erfa, which has errors of some kilometres for
        the Earth and up to two arc minutes for the other planets, as seen from the Sun. G times masses are from DE440
        (Park et al. 2021, Astron. J. 161, 105, doi:10.3847/1538-3881/abd414).

        Examples
        --------
        >>> import astropy.units as u, fullbody
        >>> orbit = fullbody.KeplerElements(1.6442 * u.au, 0.38385, 3.408 * u.deg, 73.2 * u.deg, 319.3 * u.deg, 0.0)
        >>> sun = fullbody.forces.ThirdBody.from_ephemeris("sun", "2022-10-25 TDB", orbit=orbit, duration="20 day")
        >>> sun.name, sun.positions.unit
        ('Sun', Unit("km"))
        """
        from .ephemeris import path

        return cls(of="body", date=date, **path(name, date, orbit, duration, epoch, ephemeris, frame, units))

    def _describe(self, context: Context) -> dict[str, Any]:
        units, name = context.units, self.name
        if self.date is not None and context.epoch is not None:
            difference = (epochs.to_time(self.date).tdb - epochs.to_time(context.epoch).tdb).to_value("s")
            if abs(difference) > _SAME_DATE:
                raise InvalidInput(
                    f"the path of {name} is for the date {self.date} at time zero, and the epoch of the system is "
                    f"{context.epoch}; expected one date for both"
                )
        numbers = self._unitless(units)
        mu = context.G * numbers["mass"] if self.mu is None else numbers["mu"]
        path: dict[str, Any]
        frame = self.frame if self.orbit is None else self.orbit.frame
        rotation = None if frame is None else _rotation(frame, context, name)
        if self.orbit is not None:
            orbit = self.orbit if rotation is None else self.orbit.to_frame(target=context.frame)
            elements = {
                key: units.number(getattr(orbit, key), dimension, f"{_NOUNS.get(key, key)} of {name}")
                for key, dimension in DIMENSIONS.items()
            }
            path = {"orbit": {"elements": elements, "time": numbers["time"]}}
        else:
            times, positions = np.array(numbers["times"]), np.array(numbers["positions"])
            if len(positions) != len(times):
                shapes = f"{times.shape} and {positions.shape}"
                raise InvalidInput(f"times and positions of {name} have shapes {shapes}; expected (T,) and (T, 3)")
            positions = positions if rotation is None else positions @ rotation.T
            steps = np.abs(np.diff(times))
            if len(steps) and steps.min() <= 4.0 * np.spacing(np.abs(times).max()):
                row = int(np.argmin(steps))
                raise InvalidInput(
                    f"times of {name} are {times[row]} and {times[row + 1]} in rows {row} and {row + 1}; expected "
                    "rows further apart than the round-off of the times"
                )
            path = {"table": {"times": times.tolist(), "positions": positions.tolist()}}
        arguments = {} if self.mass is None else {"mass": numbers["mass"]}
        return {"kind": "ThirdBody", "name": name, "mu": mu, **arguments, "of": self.of, "path": path}

    def _notes(self) -> dict[str, Any]:
        return {} if self.date is None else {"date": self.date}

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        path, whose = described["path"], "it goes round" if described["of"] == "body" else "the system goes round it"
        mu = f"mu = {number(units.attach(described['mu'], 'mu'))}"
        if "orbit" in path:
            elements = path["orbit"]["elements"]
            return f"{mu}; {whose}, a = {number(units.attach(elements['a'], 'length'))}, e = {number(elements['e'])}"
        times = path["table"]["times"]
        first, last = (number(units.attach(time, "time")) for time in (times[0], times[-1]))
        return f"{mu}; {len(times)} positions from {first} to {last}"

    @classmethod
    def _input_warnings(cls, described: dict[str, Any], start: _core.State, context: Context) -> Iterator[str]:
        """Yield warnings of a tide that is lost in rounding, and of a table whose spline does not follow the path."""
        index = context.third_body(described["name"], "a third body")
        position, _ = context.core.third_body(index, np.array([start.time]))
        extent = np.linalg.norm(start.position - start.position[0], axis=1).max()
        # The ratio of the tidal acceleration to that of the bodies on each other.
        ratio = described["mu"] / np.linalg.norm(position[0]) ** 3 * extent**3 / (context.G * context.masses.sum())
        if 0.0 < ratio < _SMALLEST_TIDE:
            yield (
                f"the tide of {described['name']} is {ratio:.1g} of the bodies' own gravity, which double precision "
                "cannot resolve; check the units of its mass and of its path"
            )
        table = described["path"].get("table")
        if table is None:
            return
        error, row = relative_error(np.array(table["times"]), np.array(table["positions"]))
        if error > _COARSE:
            time = number(context.units.attach(table["times"][row], "time"), 4)
            yield (
                f"the positions of {described['name']} are so far apart in time that the spline between them is wrong "
                f"by about {error:.1g} of the distance near time {time}; expected rows nearer to each other, for an "
                f"error below {_COARSE:g}: check the unit of the times"
            )

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        path, kind = described["path"], "mass" if "mass" in described else "mu"
        arguments = {"of": described["of"], "date": described.get("date"), kind: units.attach(described[kind], kind)}
        if "orbit" in path:
            numbers = path["orbit"]["elements"]
            elements = {key: Number(of).attached(numbers[key], units) for key, of in DIMENSIONS.items()}
            arguments |= {"orbit": KeplerElements(**elements), "time": units.attach(path["orbit"]["time"], "time")}
        else:
            kinds = {"times": "time", "positions": "length"}
            arguments |= {key: units.attach(np.array(path["table"][key]), of) for key, of in kinds.items()}
        return cls(name=described["name"], **arguments)


def _rotation(frame: Any, context: Context, name: str) -> Any:
    """Return the matrix from the frame of a path to that of a system, or ``None`` if they are the same."""
    is_unbound = isinstance(context.units, AnyUnits)
    if context.frame is None and not is_unbound:
        raise InvalidInput(
            f"the path of {name} is in the frame {frame!r}, and that of the system is not known; "
            "give fullbody.System(..., frame='ecliptic')"
        )
    if isinstance(frame, str) and frame == context.frame:
        return None
    try:
        # A new force has no system yet, so that only its frame is checked.
        matrix = rotation(frame, "equatorial" if is_unbound else context.frame)
    except InvalidInput as error:
        raise InvalidInput(f"the path of {name}: {error}") from error
    return None if is_unbound else matrix
