"""Normal modes of a relative equilibrium."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base.arguments import integer
from ..base.tables import Table, Tabled, head, number
from ..base.units import UNITLESS, without_unit
from ..errors import InvalidInput
from ..model.state import State
from ..motion.system import System
from ..typing import Array, Scalar
from . import pictures
from ._rotation import Rotation

_Complex = npt.NDArray[np.complex128]
#: Growth of a mode, relative to the fastest rate, that may be rounding of nearly equal eigenvalues.
STEADY = 1e-7


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Tabled):
    """Normal modes: small motions near a relative equilibrium are sums of them.

    Each mode changes in time as Re(shape exp((growth + i frequency) t)). Modes of symmetries are left out, so that two
    bodies without axes of symmetry have seven.

    Attributes
    ----------
    system : System
    rate : float or Quantity
        Rate at which the equilibrium rotates.
    frequency : ndarray or Quantity, (M,)
        Angular frequencies, ascending; zero for a mode that grows without oscillating.
    growth : ndarray or Quantity, (M,)
        Rates of growth. A mode of frequency zero that grows also stands for its counterpart, which decays; of two modes
        with the same frequency, one grows and the other decays.
    position : ndarray of complex, (M, 3)
        Changes of the separation relative to its length: x along the line away from each other, z along the angular
        momentum. The y component is zero since the frame follows the line of the bodies.
    rotation : ndarray of complex, (M, 2, 3)
        Rotation vectors of the bodies in their own frames, radians. The largest component of a mode's position and
        rotation is 1.
    energy_sign : ndarray of int, (M,)
        The sign of the energy that a mode adds to the equilibrium at fixed momenta; zero for one that grows or decays.
    in_plane : ndarray of bool, (M,)
        Whether a mode stays in the plane of the orbit, with all rotations about the plane's normal.
    """

    system: System
    rate: Scalar
    frequency: Array
    growth: Array
    position: _Complex
    rotation: _Complex
    energy_sign: npt.NDArray[np.int64]
    in_plane: npt.NDArray[np.bool_]
    _rotation: Rotation
    _deviations: _Complex

    @property
    def period(self) -> Array:
        """Periods (M,) of the modes, 2 pi divided by the frequency; infinite where the frequency is zero."""
        with np.errstate(divide="ignore"):
            return self.system.context.units.attach(2 * np.pi / without_unit(self.frequency), "time")

    def excited(self, mode: int, amplitude: float, phase: float = 0.0) -> State:
        """Return the state of the equilibrium with one mode added, to first order.

        Parameters
        ----------
        mode : int
            Index of the mode.
        amplitude : float
            The size of the largest component of its position and rotation: relative to the separation, or in radians.
        phase : float
            In radians.

        Examples
        --------
        >>> import fullbody
        >>> system, _ = fullbody.systems.didymos_after_dart()
        >>> equilibrium = fullbody.analysis.relative_equilibrium(
        ...     fullbody.analysis.averaged(system, "Didymos"), separation=1.2, spin={"Didymos": 2.78}
        ... )
        >>> equilibrium.modes.excited(0, 1e-3).position.shape
        (2, 3)
        """
        index = integer(mode)
        if index is None or not -len(self) <= index < len(self):
            raise InvalidInput(f"mode is {mode!r}; expected 0 to {len(self) - 1}, one of the {len(self)} modes")
        size, angle = UNITLESS.number(amplitude, "number", "amplitude"), UNITLESS.number(phase, "number", "phase")
        return self._rotation.displaced(np.real(size * np.exp(1j * angle) * self._deviations[:, index])).state

    plot = pictures.modes

    def __len__(self) -> int:
        return len(self.in_plane)

    def _tables(self) -> tuple[Table, ...]:
        unit = getattr(self.frequency, "unit", "")
        header = (head("frequency", unit), "by rate", head("growth", unit), "plane", "energy", "largest in")
        rows = []
        for k, (frequency, growth) in enumerate(
            zip(without_unit(self.frequency), without_unit(self.growth), strict=True)
        ):
            sizes = (number(frequency), number(frequency / without_unit(self.rate), 6), number(growth, 4))
            rows.append((*sizes, "in" if self.in_plane[k] else "out of", "0+-"[self.energy_sign[k]], self._part(k)))
        return (Table("Modes", header, list(rows)),)

    def _part(self, mode: int) -> str:
        """Describe the largest component of a mode in words."""
        names = self.system.names
        words = ["distance", "longitude", "latitude"]
        words += [f"rotation of {name} about {axis}" for name in names for axis in "xyz"]
        return words[int(np.abs([*self.position[mode], *self.rotation[mode].ravel()]).argmax())]

    def __repr__(self) -> str:
        frequency = np.array2string(without_unit(self.frequency), precision=6)
        growing = int(np.sum(without_unit(self.growth) > 0))
        unit = f" {self.frequency.unit}" if hasattr(self.frequency, "unit") else ""
        return f"Modes({len(self)}, frequency={frequency}{unit}, {growing or 'none'} growing)"


def modes_of(rotation: Rotation) -> Modes:
    """Compute the modes of a uniform rotation."""
    basis, rates, energy = rotation.reduced()
    values, vectors = np.linalg.eig(rates)
    steady = STEADY * np.abs(values).max(initial=0.0)
    values = np.where(np.abs(values.real) <= steady, 1j * values.imag, values)
    values = np.where(np.abs(values.imag) <= 1e-12 * steady / STEADY, values.real + 0j, values)
    values = np.where(np.abs(values) <= steady, 0.0, values)
    indices = _of_pairs(values)
    deviations = (basis @ vectors)[:, indices]
    # A rotation about the pole is subtracted, so that the line of the bodies keeps its longitude.
    about_pole = rotation.generators()[:, :1]
    deviations = deviations - about_pole * (deviations[1] / about_pole[1])
    parts = deviations[:9] / np.repeat([rotation.pose.distance, 1.0], [3, 6])[:, np.newaxis]
    scale = np.array([column[np.abs(column).argmax()] for column in parts.T])
    deviations, parts = deviations / scale, parts / scale
    signs = []
    for index, k in enumerate(indices):
        amount = np.real(vectors[:, k].conj() @ energy @ vectors[:, k]) / abs(scale[index]) ** 2
        signs.append(0 if values[k].real != 0.0 or values[k] == 0.0 else int(np.sign(amount)))
    body_rotations = np.ascontiguousarray(parts[3:].T.reshape(-1, 2, 3))
    inertial = np.einsum("kij,mkj->mki", rotation.pose.rotation, body_rotations)
    attach = rotation.pair.context.units.attach
    return Modes(
        rotation.pair.system,
        attach(rotation.rate, "spin"),
        attach(np.array([values[k].imag for k in indices]), "spin"),
        attach(np.array([values[k].real + 0.0 for k in indices]), "spin"),
        np.ascontiguousarray(parts[:3].T),
        body_rotations,
        np.array(signs, dtype=np.int64),
        np.maximum(np.abs(parts[2]), np.abs(inertial[:, :, :2]).max(axis=(1, 2))) < 1e-6,
        rotation,
        deviations,
    )


def _of_pairs(values: _Complex) -> list[int]:
    """Return indices of one eigenvalue of each pair: positive frequencies, else growing ones, and half of the zeros."""
    zeros = np.flatnonzero(values == 0.0)
    leading = (values.imag > 0.0) | ((values.imag == 0.0) & (values.real > 0.0))
    indices = [*zeros[: len(zeros) // 2], *np.flatnonzero(leading)]
    return sorted(indices, key=lambda k: (values[k].imag, -values[k].real))
