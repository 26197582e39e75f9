"""What sunlight does over many turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..base.arguments import directions, named_options
from ..errors import InvalidInput
from ..model.force import Force, Ground

if TYPE_CHECKING:
    from ..base.units import Units

__all__ = ["Byorp", "Yorp"]


@named_options
@dataclass(frozen=True, eq=False)
class Yorp(Force):
    """The torque of radiation on a body, a mean over its rotation and its orbit round the Sun.

    Parameters
    ----------
    on : int or str
        The body.
    along : float, Quantity or array_like
        Torque along the spin: a number, or one at each obliquity.
    across : float, Quantity or array_like
        Torque across the spin that raises the obliquity.
    obliquity : array_like or Quantity, optional
        Obliquities of a table, from 0 to pi, with a cubic spline between.
    pole : array_like, (3,)
        Normal of the orbit round the Sun, inertial; the obliquity counts from it.
    name : str, optional
        ``YORP on`` the body unless given.

    Notes
    -----
    Rubincam (2000). With C the moment of inertia the spin changes by ``along`` / C, and the obliquity by ``across`` / (C spin).
    """

    on: int | str
    along: Any
    across: Any = 0.0
    obliquity: Any = None
    pole: Any = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        pole = directions(self.pole, f"pole of {self.name}", one=True)
        object.__setattr__(self, "pole", tuple(float(component) for component in pole))

    def _usual_name(self) -> str:
        return f"YORP on {self.on}" if isinstance(self.on, str) else f"YORP on body {self.on}"

    def _describe(self, ground: Ground) -> dict[str, Any]:
        units, name = ground.units, self.name
        obliquity = np.zeros(0) if self.obliquity is None else units.strip(self.obliquity, "angle", f"obliquity of {name}")
        if obliquity.ndim != 1 or not np.isfinite(obliquity).all():
            raise InvalidInput(f"obliquity of {name} is {self.obliquity!r}; expected finite angles (T,)")
        rows = max(obliquity.size, 1)

        def torque(role: str) -> list[float]:
            array = units.strip(getattr(self, role), "torque", f"{role} of {name}")
            if array.ndim == 0:
                array = np.full(rows, float(array))
            if array.shape != (rows,) or not np.isfinite(array).all():
                raise InvalidInput(
                    f"{role} of {name} is {getattr(self, role)!r}; expected a finite torque, or one at each obliquity"
                )
            return [float(value) for value in array]

        return {
            "kind": "Yorp",
            "name": name,
            "on": ground.names[self._place(ground, "on")],
            "pole": list(self.pole),
            "obliquity": obliquity.tolist(),
            "along": torque("along"),
            "across": torque("across"),
        }

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        table = bool(described["obliquity"])

        def torque(role: str) -> Any:
            return units.attach(np.array(described[role]) if table else described[role][0], "torque")

        obliquity = units.attach(np.array(described["obliquity"]), "angle") if table else None
        given = {key: described[key] for key in ("name", "on", "pole")}
        return cls(**given, along=torque("along"), across=torque("across"), obliquity=obliquity)


@named_options
@dataclass(frozen=True, eq=False)
class Byorp(Force):
    """The force of radiation on a synchronous secondary along its motion, a mean over both orbits.

    It acts while the secondary is locked, which is decided at the start of every step: its short axis is within 45 degrees of
    the orbit's normal, and the angle psi of its long axis to the line to the other body is that of a pendulum which does not turn
    over, psi'^2 + w^2 sin^2 psi < w^2 with w^2 = 3 (B - A)/C mu/r^3. :attr:`Run.switched_off` counts how often it was lost.

    Parameters
    ----------
    on : int or str
        The secondary.
    about : int or str
        The body that it moves about.
    force : float or Quantity
        Along the motion: in the plane of the orbit, across the line to the other body. Above zero the orbit grows.
    name : str, optional
        ``BYORP on`` the body unless given.

    Notes
    -----
    Cuk & Burns (2005), McMahon & Scheeres (2010): a circular orbit drifts by da/dt = 2 F / (m n), where m is the
    secondary's mass.
    """

    on: int | str
    about: int | str
    force: Any

    def _usual_name(self) -> str:
        return f"BYORP on {self.on}" if isinstance(self.on, str) else f"BYORP on body {self.on}"

    def _describe(self, ground: Ground) -> dict[str, Any]:
        return {
            "kind": "Byorp",
            "name": self.name,
            "on": ground.names[self._place(ground, "on")],
            "about": ground.names[self._place(ground, "about")],
            "force": ground.units.number(self.force, "force", f"force of {self.name}"),
        }

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        given = {key: described[key] for key in ("name", "on", "about")}
        return cls(**given, force=units.attach(described["force"], "force"))
