"""What a run recorded, as arrays, and how well it conserved what is conserved."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .errors import InvalidInput
from .typing import Array

if TYPE_CHECKING:
    from .system import System

__all__ = ["Recorded"]


class Recorded:
    """Base of :class:`fullbody.Run`: the arrays of K samples of N bodies."""

    system: System
    _record: dict[str, npt.NDArray[np.float64]]

    def _get(self, name: str, dimension: str) -> Array:
        values: Array = self.system._units.attach(self._record[name], dimension)
        return values

    @property
    def time(self) -> Array:
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
    def position(self) -> Array:
        """Centres (K, N, 3), inertial."""
        return self._get("position", "length")

    @property
    def velocity(self) -> Array:
        """Velocities (K, N, 3), inertial."""
        return self._get("velocity", "velocity")

    @property
    def attitude(self) -> npt.NDArray[np.float64]:
        """Unit quaternions (K, N, 4), ``[w, x, y, z]``."""
        return self._record["attitude"]

    @property
    def spin(self) -> Array:
        """Angular velocities (K, N, 3), body frames."""
        return self._get("spin", "spin")

    @property
    def energy(self) -> Array:
        """Total energy (K,)."""
        return self._energy(0)

    @property
    def translational_energy(self) -> Array:
        """Kinetic energy of the centres (K,)."""
        return self._energy(1)

    @property
    def rotational_energy(self) -> Array:
        """Kinetic energy of the spins (K,)."""
        return self._energy(2)

    @property
    def potential_energy(self) -> Array:
        """Potential energy (K,), negative."""
        return self._energy(3)

    def _energy(self, part: int) -> Array:
        values: Array = self.system._units.attach(self._record["energy"][:, part], "energy")
        return values

    @property
    def angular_momentum(self) -> Array:
        """Total angular momentum (K, 3) about the origin, inertial.

        Formed about the barycentre, whose own constant part is added: it loses no digits as the system travels.
        """
        return self._get("angular_momentum", "angular momentum")

    @property
    def energy_drift(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start, relative to it (K,); absolute where it is zero."""
        energy = self._record["energy"][:, 0]
        return self._relative("energy_drift", energy - energy[:1])

    @property
    def energy_drift_orbital(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start, relative to abs(potential + translational) there (K,).

        The energy of a fast spin can dwarf that of the orbit and hide its error. Absolute where there is no orbit.
        """
        energy = self._record["energy"][:, 0]
        return self._relative("energy_drift_orbital", energy - energy[:1])

    @property
    def angular_momentum_drift(self) -> npt.NDArray[np.float64]:
        """Length of the change of the angular momentum since the start, relative to its length (K,).

        Absolute where that is zero.
        """
        momentum = self._record["angular_momentum"]
        return self._relative("angular_momentum_drift", np.linalg.norm(momentum - momentum[:1], axis=1))

    def _size(self, drift: str) -> float:
        """What a drift is relative to; zero where there is nothing, and in a run without samples."""
        if not len(self._record["time"]):
            return 0.0
        energy = self._record["energy"][0]
        if drift == "angular_momentum_drift":
            return float(np.linalg.norm(self._record["angular_momentum"][0]))
        return float(abs(energy[0] if drift == "energy_drift" else energy[1] + energy[3]))

    def _relative(self, drift: str, change: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.asarray(change / (self._size(drift) or 1.0))
