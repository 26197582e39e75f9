"""Third bodies: the Sun, a planet that passes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from ..base.arguments import named_options
from ..errors import InvalidInput
from ..model.force import Force, Ground
from ..orbit.elements import KeplerElements

if TYPE_CHECKING:
    from ..base.units import Units

__all__ = ["ThirdBody"]

_ANGLES = ("i", "Omega", "omega", "M")


@named_options
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ThirdBody(Force):
    """The gravity of a point mass on a prescribed path: force and torque on every body, near and far.

    The path is a Kepler orbit or a table of positions, relative to the system's barycentre. The third body itself is
    not moved by the system. A path is that of the barycentre as it would go without the forces: what they change of
    it, such as the pull on the quadrupoles, is computed.

    Parameters
    ----------
    mass : float or Quantity
        Or else ``mu``.
    mu : float or Quantity
        G times the mass.
    orbit : KeplerElements
        The path as an orbit; its mu is that of the third body and the system together.
    of : {"system", "body"}
        Whose path about whom is given: ``"system"``, that of the system about the third body (an orbit round the Sun);
        ``"body"``, that of the third body about the system (a planet that passes).
    time : float or Quantity
        Time of a state at which the mean anomaly of ``orbit`` holds.
    times, positions : array_like or Quantity, (T,) and (T, 3)
        The path as a table, with a cubic spline (not-a-knot) between. Runs beyond it are refused.
    name : str

    Raises
    ------
    InvalidInput
        Also when a system is made or run: for a third body that is or comes inside the system, and a table that ends
        before the run does.

    Notes
    -----
    The acceleration of a point at r relative to the barycentre, by a third body at p, is Battin's (1999, section 8.4),
    which loses no digits: -(mu/d^3) (r + f(q) p) with d = r - p, q = r.(r - 2p)/p^2. What a body's extent adds, and the
    torque, come from its own exact exterior field at the third body, by the third law.

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

    mass: Any = None
    mu: Any = None
    orbit: KeplerElements[Any] | None = None
    of: str | None = None
    time: Any = 0.0
    times: Any = None
    positions: Any = None

    depends_on_velocity: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        name = self.name
        if (self.mass is None) == (self.mu is None):
            raise InvalidInput(f"mass and mu of {name} are {self.mass!r} and {self.mu!r}; expected one of the two")
        if self.of not in ("system", "body"):
            raise InvalidInput(
                f"of of {name} is {self.of!r}; expected 'system' (the path is the system's about the third body) "
                "or 'body' (it is the third body's about the system)"
            )
        table = (self.times is not None, self.positions is not None)
        if (self.orbit is None) != all(table) or table[0] != table[1]:
            raise InvalidInput(f"the path of {name} is not clear; expected orbit, or else times and positions")
        if self.orbit is not None and not isinstance(self.orbit, KeplerElements):
            raise InvalidInput(f"orbit of {name} is {self.orbit!r}; expected KeplerElements")

    def _usual_name(self) -> str:
        return "third body"

    def _describe(self, ground: Ground) -> dict[str, Any]:
        units, name = ground.units, self.name
        mu = (
            ground.G * units.number(self.mass, "mass", f"mass of {name}")
            if self.mu is None
            else units.number(self.mu, "mu", f"mu of {name}")
        )
        path: dict[str, Any]
        if self.orbit is not None:
            orbit = self.orbit
            elements = {
                "a": units.number(orbit.a, "length", f"semi-major axis of {name}"),
                "e": units.number(orbit.e, "angle", f"eccentricity of {name}"),
            }
            elements |= {key: units.number(getattr(orbit, key), "angle", f"{key} of {name}") for key in _ANGLES}
            path = {"orbit": {"elements": elements, "time": units.number(self.time, "time", f"time of {name}")}}
        else:
            times = units.strip(self.times, "time", f"times of {name}")
            positions = units.strip(self.positions, "length", f"positions of {name}")
            if times.ndim != 1 or positions.shape != (*times.shape, 3):
                raise InvalidInput(
                    f"times and positions of {name} have shapes {times.shape} and {positions.shape}; "
                    "expected (T,) and (T, 3)"
                )
            if not (np.isfinite(times).all() and np.isfinite(positions).all()):
                raise InvalidInput(f"times or positions of {name} are not finite; expected finite numbers")
            path = {"table": {"times": times.tolist(), "positions": positions.tolist()}}
        return {"kind": "ThirdBody", "name": name, "mu": mu, "of": self.of, "path": path}

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        path = described["path"]
        given: dict[str, Any] = {"mu": units.attach(described["mu"], "mu"), "of": described["of"]}
        if "orbit" in path:
            elements = dict(path["orbit"]["elements"])
            elements["a"] = units.attach(elements["a"], "length")
            elements |= {key: units.attach(elements[key], "angle") for key in _ANGLES}
            given |= {"orbit": KeplerElements(**elements), "time": units.attach(path["orbit"]["time"], "time")}
        else:
            table = path["table"]
            given["times"] = units.attach(np.array(table["times"]), "time")
            given["positions"] = units.attach(np.array(table["positions"]), "length")
        return cls(name=described["name"], **given)
