"""The rotating frame of a pair: equilibrium points, zero-velocity curves, Roche lobes."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from ..base.attributes import WithUnit
from ..base.kinds import whole_number
from ..base.limits import POSITIVE
from ..base.tables import number
from ..base.units import need, without_unit
from ..model.context import SystemLike
from ..model.state import State, strip
from ..typing import Array, Floats, Scalar
from .frame import Frame, equilibria, roche_lobe


class Synodic:
    """The frame that rotates with a pair of bodies, and the field in it.

    Its origin is the barycentre, x points from the heavier body to the lighter one, and z along the orbital angular
    momentum. The bodies have the poses of the state: the field is exact for a pair on a circular orbit whose figures do
    not rotate in the frame. Then Jacobi's constant C = 2 Phi + Omega^2 (x^2 + y^2) - v^2 is conserved.

    Parameters
    ----------
    system : System
        Two bodies that orbit each other.
    state : State

    Warns
    -----
    InconsistentInput
        If the pair is not at rest in the frame: the orbit is not a circle, or a figure rotates in the frame.

    Examples
    --------
    >>> import fullbody
    >>> balls = [fullbody.Body(fullbody.Sphere(0.1), mass=m, name=n) for n, m in (("A", 0.99), ("B", 0.01))]
    >>> system = fullbody.System(balls, G=1.0)
    >>> state = fullbody.State(position=[[-0.01, 0, 0], [0.99, 0, 0]], velocity=[[0, -0.01, 0], [0, 0.99, 0]])
    >>> pair = fullbody.fields.Synodic(system, state)
    >>> [(point.name, point.stable) for point in pair.equilibria()]
    [('L1', False), ('L2', False), ('L3', False), ('L4', True), ('L5', True)]
    """

    def __init__(self, system: SystemLike, state: State) -> None:
        self.system, self._state, self._units = system, state, system.context.units
        #: The frame in plain numbers.
        self.frame = Frame(system.context, strip(state, system.context))

    rate = WithUnit[Scalar]("Omega, the orbit's angular velocity in the state.", "frame.rate", "spin")
    separation = WithUnit[Scalar]("Distance between the centres.", "frame.distance", "length")
    position = WithUnit[Array]("Positions (2, 3) of the bodies' centres in the frame.", "frame.centres", "length")

    equilibria = equilibria
    roche_lobe = roche_lobe

    def to_inertial(self, points: Any, velocity: Any = None) -> tuple[Array, Array]:
        """Convert points of the frame, with velocities relative to it or at rest, to inertial positions and velocities.

        Parameters
        ----------
        points, velocity : array_like or Quantity, (..., 3)

        Returns
        -------
        position, velocity : ndarray or Quantity, (..., 3)
        """
        x = self._vectors(points, "length", "points")
        v = np.zeros(3) if velocity is None else self._vectors(velocity, "velocity", "velocity")
        frame = self.frame
        v = v + frame.rate * np.cross([0.0, 0.0, 1.0], x)
        position, velocity = frame.origin + x @ frame.rotation.T, frame.drift + v @ frame.rotation.T
        return self._units.attach(position, "length"), self._units.attach(velocity, "velocity")

    def jacobi(self, points: Any, velocity: Any = None) -> Array:
        """Compute Jacobi's constant C = 2 Phi + Omega^2 (x^2 + y^2) - v^2 at points of the frame.

        Parameters
        ----------
        points : array_like or Quantity, (..., 3)
        velocity : array_like or Quantity, (..., 3), optional
            Velocities relative to the frame; zero by default.

        Returns
        -------
        ndarray or Quantity, (...)
        """
        constant = self.frame.jacobi(self._vectors(points, "length", "points"))
        if velocity is not None:
            constant = constant - (self._vectors(velocity, "velocity", "velocity") ** 2).sum(axis=-1)
        return self._units.attach(constant, "potential")

    def _vectors(self, values: Any, dimension: str, name: str) -> Floats:
        return self._units.numbers(values, dimension, name, ("...", 3))

    def plane(self, extent: Any = None, *, n: int = 401) -> tuple[Array, Array, Array]:
        """Compute Jacobi's constant of particles at rest on a grid of the plane z = 0.

        Parameters
        ----------
        extent : float or Quantity, optional
            Half the side length of the square about the barycentre; by default 1.618 separations.
        n : int
            Number of points along a side.

        Returns
        -------
        x, y : ndarray or Quantity, (n,)
        jacobi : ndarray or Quantity, (n, n)
            Rows along y.
        """
        half = 0.5 * (1.0 + np.sqrt(5.0)) * self.frame.distance
        if extent is not None:
            half = self._units.number(extent, "length", "extent", POSITIVE)
        ticks = np.linspace(-half, half, whole_number(n, "n", 2))
        grid = np.stack([*np.meshgrid(ticks, ticks), np.zeros((n, n))], axis=-1)
        sides = (self._units.attach(ticks.copy(), "length") for _ in "xy")
        return *sides, self._units.attach(self.frame.jacobi(grid), "potential")

    def zero_velocity(self, level: Any, extent: Any = None, *, n: int = 801) -> list[Array]:
        """Return the curves of a Jacobi constant in the plane z = 0, which particles with that constant do not cross.

        Parameters
        ----------
        level : float or Quantity
        extent, n
            As for :meth:`plane`.

        Returns
        -------
        list of ndarray or Quantity, (P, 2)
            The curves, including those within the bodies.
        """
        with need("plot", "a zero-velocity curve"):
            from contourpy import contour_generator

        x, y, constant = self.plane(extent, n=n)
        curves = contour_generator(*map(without_unit, (x, y, constant))).lines(
            self._units.number(level, "potential", "level")
        )
        return [self._units.attach(np.asarray(curve), "length") for curve in curves]

    def __repr__(self) -> str:
        names = " and ".join(self.system.context.names)
        return f"Synodic({names}, {number(self.separation)} apart, rate {number(self.rate)})"

    def __reduce__(self) -> Any:
        # The warnings of a pair that is not at rest were given when it was made.
        return _without_warnings, (type(self), self.system, self._state)


def _without_warnings(kind: type[Synodic], system: SystemLike, state: State) -> Synodic:
    """Rebuild the frame of a copy or a pickle, without the warnings."""
    with warnings.catch_warnings(action="ignore"):
        return kind(system, state)
