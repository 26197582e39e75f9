"""What a run recorded, as arrays, and how well it conserved what is conserved."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..model.interactions import Invariants
from . import conserved

if TYPE_CHECKING:
    from ..motion.system import System

__all__ = ["Recorded"]


class Recorded:
    """Base of :class:`fullbody.Run`: the arrays of K samples of N bodies."""

    system: System
    _record: dict[str, npt.NDArray[np.float64]]
    #: Numbers of the start, as in :mod:`fullbody._conserved`; ``None`` where a file does not tell.
    _start: npt.NDArray[np.float64] | None = None

    def _get(self, name: str, dimension: str) -> Any:
        return self.system._units.attach(self._record[name], dimension)

    @property
    def time(self) -> Any:
        """Times (K,)."""
        return self._get("time", "time")

    @property
    def dates(self) -> Any:
        """Dates (K,) of the samples as an ``astropy.time.Time``; for systems with an epoch and units."""
        if self.system.epoch is None:
            raise InvalidInput("this system has no epoch; give fullbody.System(..., epoch='2022-09-26 TDB')")
        from astropy import units as u

        return self.system.epoch + self._record["time"] * self.system._units.unit("time").to(u.s) * u.s

    @property
    def position(self) -> Any:
        """Centres (K, N, 3), inertial."""
        return self._get("position", "length")

    @property
    def velocity(self) -> Any:
        """Velocities (K, N, 3), inertial."""
        return self._get("velocity", "velocity")

    @property
    def attitude(self) -> Any:
        """Unit quaternions (K, N, 4), ``[w, x, y, z]``."""
        return self._record["attitude"]

    @property
    def spin(self) -> Any:
        """Angular velocities (K, N, 3), body frames."""
        return self._get("spin", "spin")

    @property
    def energy(self) -> Any:
        """Total energy (K,)."""
        return self._energy(0)

    @property
    def translational_energy(self) -> Any:
        """Kinetic energy of the centres (K,)."""
        return self._energy(1)

    @property
    def rotational_energy(self) -> Any:
        """Kinetic energy of the spins (K,)."""
        return self._energy(2)

    @property
    def potential_energy(self) -> Any:
        """Potential energy (K,), negative."""
        return self._energy(3)

    def _energy(self, part: int) -> Any:
        return self.system._units.attach(self._record["energy"][:, part], "energy")

    @property
    def angular_momentum(self) -> Any:
        """Total angular momentum (K, 3) about the origin, inertial.

        Formed about the barycentre, whose own constant part is added: it loses no digits as the system travels.
        """
        return self._get("angular_momentum", "angular momentum")

    @property
    def start(self) -> Invariants | None:
        """Time, energy and angular momentum at the start of the run, whether a sample was recorded there or not.

        A slice keeps the start of the whole run. ``None`` in a run from a file of version 0.1.0, which does not tell.
        """
        return None if self._start is None else conserved.named(self._start, self.system._units)

    @property
    def energy_drift(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start of the run, relative to it (K,); absolute where it is zero.

        Where ``start`` is ``None``, it is the change since the first sample, with a ``UserWarning``.
        """
        return self._told("energy_drift")

    @property
    def energy_drift_orbital(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start, relative to abs(potential + translational) there (K,).

        The energy of a fast spin can dwarf that of the orbit and hide its error. Absolute where there is no orbit.
        Where ``start`` is ``None``, it is the change since the first sample, with a ``UserWarning``.
        """
        return self._told("energy_drift_orbital")

    @property
    def angular_momentum_drift(self) -> npt.NDArray[np.float64]:
        """Length of the change of the angular momentum since the start, relative to its length (K,).

        Absolute where that is zero. Where ``start`` is ``None``, it is the change since the first sample, with a
        ``UserWarning``.
        """
        return self._told("angular_momentum_drift")

    def _told(self, name: str) -> npt.NDArray[np.float64]:
        if self._start is None and len(self._record["time"]):
            text = (
                f"{name} is counted from the first sample, at time {self.time[0]}: the file that the run comes from "
                "does not tell what energy and angular momentum were at its start"
            )
            warnings.warn(text, UserWarning, stacklevel=3)
        return self._drift(name)

    def _drift(self, name: str) -> npt.NDArray[np.float64]:
        record = self._record
        return conserved.drift(name, self._reference(), record["energy"], record["angular_momentum"])

    def _relative_to(self, name: str) -> float:
        """What a drift is relative to; zero where there is nothing, and in a run without samples."""
        return conserved.size(name, self._reference()) if len(self._record["time"]) else 0.0

    def _reference(self) -> npt.NDArray[np.float64]:
        """The start; or else the first sample; or else, where there is nothing to compare, zeros."""
        if self._start is not None:
            return self._start
        if not len(self._record["time"]):
            return np.zeros(8)
        return np.concatenate([np.atleast_1d(self._record[name][0]) for name in ("time", "energy", "angular_momentum")])
