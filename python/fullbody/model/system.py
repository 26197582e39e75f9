"""A system: bodies under their mutual gravity, and what it is asked at one state."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from .. import _core
from ..base.arguments import names_of, suggestion
from ..base.tables import number
from ..errors import BodiesOverlap, ForceFailed, FullbodyError, InvalidInput
from ..typing import Array
from .described import DescribedSystem
from .gravity import Gravity, gravity_at, points_in
from .interactions import Energy, Interactions, Loads
from .jacobian import Jacobian
from .state import State

__all__ = ["BaseSystem"]


class BaseSystem(DescribedSystem):  # noqa: D101
    __doc__ = DescribedSystem.__doc__

    __slots__ = ()

    def loads(self, state: State) -> dict[str, Loads]:
        """What each force from outside does in a state, by its name.

        The nominal barycentre of the state is its own: a third body stands where its path has it relative to that.

        Parameters
        ----------
        state : State

        Returns
        -------
        dict of Loads
            Force (N, 3), inertial, and torque (N, 3), in body frames.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> system.with_forces([tide]).loads(state)["tide on Alpha"].force.shape
        (2, 3)
        """
        core = self._strip(state)
        with self._explaining(lambda: core):
            try:
                forces, torques = self._core.outside(core)
            except ForceFailed as error:
                caused = self._caused(error)
                raise caused from caused.__cause__
        attach = self._units.attach
        both = zip(self._forces, forces, torques, strict=True)
        return {force.name: Loads(attach(f, "force"), attach(m, "torque")) for force, f, m in both}

    def third_body(self, name: str, time: Any) -> tuple[Array, Array]:
        """Position and velocity of a third body from the system's nominal barycentre.

        Parameters
        ----------
        name : str
            Of a :class:`fullbody.forces.ThirdBody` of the system.
        time : float, Quantity or array_like, () or (K,)

        Returns
        -------
        position, velocity : ndarray or Quantity, (3,) or (K, 3)
        """
        index = self._third_body(name, "name")
        times = self._units.strip(time, "time", "time")
        both = self._core.third_body(index, np.atleast_1d(times))
        position, velocity = (array.reshape(*times.shape, 3) for array in both)
        return self._units.attach(position, "length"), self._units.attach(velocity, "velocity")

    def _third_body(self, name: object, what: str) -> int:
        """The place of a third body among the forces by its name, or an error that says which there are."""
        kinds = {force.name: force._kind for force in self._forces}
        names = [name for name, kind in kinds.items() if kind == "ThirdBody"]
        if name not in names:
            is_other = f", a {kinds[name]}" if isinstance(name, str) and name in kinds else ""
            expected = (
                suggestion(str(name), names, "one") if names else "expected a ThirdBody of the system, which has none"
            )
            raise InvalidInput(f"{what} is {name!r}{is_other}; {expected}")
        return [force.name for force in self._forces].index(str(name))

    def interactions(self, state: State) -> Interactions:
        """Forces, torques and potential energy.

        Parameters
        ----------
        state : State

        Returns
        -------
        Interactions

        Raises
        ------
        BodiesOverlap
        NotConverged
            Where the quadrature reaches its limit of nodes; bodies in contact with sharp rims.

        Notes
        -----
        The paper's Eqs. (2), (3) and, for the potential energy, minus its Eq. (4).

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> f = system.interactions(state)
        >>> f.force.shape, f.torque.shape
        ((2, 3), (2, 3))
        >>> bool(abs(f.force.sum()) < 1e-15)
        True
        """
        core = self._strip(state)
        with self._explaining(lambda: core):
            force, torque, energy, left_out = self._core.interactions(core)
        attach = self._units.attach
        loads = (attach(force, "force"), attach(torque, "torque"))
        return Interactions(*loads, attach(energy, "energy"), left_out)

    def gravity(self, state: State, points: Any, body: int | str | None = None) -> Gravity:
        """Potential, field and gravity gradient of the bodies at points of the inertial frame, outside and inside.

        The sum is over the bodies alone: forces from outside, such as the pull of a third body, are not in it.

        Parameters
        ----------
        state : State
        points : array_like or Quantity, (..., 3)
            Inertial.
        body : int or str, optional
            The body whose gravity is wanted, by its name or place; that of all bodies unless given.

        Returns
        -------
        Gravity
            ``.potential`` (...), ``.field`` (..., 3) and ``.gradient`` (..., 3, 3), inertial.

        Raises
        ------
        InvalidInput
            For a point in a point mass, or one with coordinates that are no finite numbers, by its index; for the
            gradient on a polyhedron's surface.

        See Also
        --------
        Body.gravity : in the body frame.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> gravity = system.gravity(state, [[0.0, 0.0, 5.0], [0.0, 0.0, 6.0]])
        >>> gravity.field.shape, gravity.gradient.shape
        ((2, 3), (2, 3, 3))
        """
        core = self._strip(state)
        if len(core.position) != len(self):
            raise InvalidInput(f"state has {len(core.position)} bodies; expected {len(self)}, as in the system")
        place = None if body is None else self._place(body, "body")
        pose = core.position[None], core.attitude[None]
        return gravity_at(self._attracting, *pose, points_in(points, self._units), self._units, place)

    @property
    def _attracting(self) -> _core.Attraction:
        """The bodies' gravity, made at the first use."""
        if self._attraction is None:
            self._attraction = _core.Attraction(self._core_bodies(), self._G, self._options["vector_path"])
        return self._attraction

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the numbers that motions can be differentiated by: ``"G"``, ``"mass of Alpha"`` and so on.

        ``"mass of"`` and ``"density of"`` are at a body's shape, ``"semi-axis a of"`` at its mass; ``"mu of"`` a third
        body at its path. Semi-axes are among them but by ``gravity="multipole:N"``.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.systems.kw4()[0].parameters[:4]
        ('G', 'mass of Alpha', 'density of Alpha', 'semi-axis a of Alpha')
        """
        return tuple(self._core.parameters)

    def jacobian(self, state: State, parameters: Iterable[str] = ()) -> Jacobian:
        """Derivatives of forces, torques and rates of change at a state, exact to round-off.

        Parameters
        ----------
        state : State
        parameters : iterable of str
            Names from :attr:`parameters`.

        Returns
        -------
        Jacobian

        Examples
        --------
        >>> import fullbody, numpy as np
        >>> system, state = fullbody.systems.kw4()
        >>> jacobian = system.jacobian(state)
        >>> jacobian.rates.shape
        (24, 24)
        >>> bool(np.allclose(jacobian.force_by_position.sum(axis=2), 0.0))
        True
        """
        core = self._strip(state)
        names = names_of(parameters, "parameters")
        with self._explaining(lambda: core):
            loads, rates, forcing, flow = self._core.jacobian(core, names)
        n = len(self)
        blocks = loads.reshape(n, 2, 3, n, 2, 3)
        attach = self._units.attach
        return Jacobian(
            attach(np.ascontiguousarray(blocks[:, 0, :, :, 0]), "force gradient"),
            attach(np.ascontiguousarray(blocks[:, 0, :, :, 1]), "force"),
            attach(np.ascontiguousarray(blocks[:, 1, :, :, 0]), "force"),
            attach(np.ascontiguousarray(blocks[:, 1, :, :, 1]), "torque"),
            flow,
            rates,
            dict(zip(names, forcing, strict=True)),
        )

    def energy(self, state: State) -> Energy:
        """Energy of a state in its parts.

        Parameters
        ----------
        state : State

        Returns
        -------
        Energy
        """
        core = self._strip(state)
        with self._explaining(lambda: core):
            parts = self._core.energy(core)
        return Energy(*(self._units.attach(part, "energy") for part in parts))

    def momentum(self, state: State) -> Array:
        """Total momentum (3,), inertial."""
        momentum: Array = self._units.attach(self._core.momentum(self._strip(state)), "momentum")
        return momentum

    def angular_momentum(self, state: State) -> Array:
        """Total angular momentum (3,) about the origin, inertial: the paper's ``eq:Total_angmom``."""
        momentum = self._core.angular_momentum(self._strip(state))
        total: Array = self._units.attach(momentum, "angular momentum")
        return total

    def _caused(self, error: BaseException) -> BaseException:
        """The error with what the function of a force raised as its cause; Ctrl-C and an exit stay what they are."""
        call = self._calls.get(error.force) if isinstance(error, ForceFailed) else None
        if not isinstance(error, ForceFailed) or call is None:
            return error
        raised = call.raised(error.answer)
        if raised is None:
            return KeyboardInterrupt() if call.is_lost(error.answer) else error
        if not isinstance(raised, Exception):
            return raised
        what = f"{raised}" if isinstance(raised, FullbodyError) else f"{type(raised).__name__}: {raised}"
        caused = ForceFailed(f"force {error.force} at time {error.time}: {what}", error.force, error.time)
        caused.__cause__ = raised
        return caused

    def _strip(self, state: State) -> _core.State:
        if not isinstance(state, State):
            raise InvalidInput(f"state is {state!r}; expected a State")
        return state._in(self._units)

    def _state(self, core: _core.State) -> State:
        """The core's state with units and the bodies' names."""
        return State._wrap(core, self._units, self.names)

    def _explained(self, error: BodiesOverlap, start: _core.State | None, when: str = "") -> BodiesOverlap:
        """The error with the distance of the centres in a state; without a state, with the time in the run."""
        if start is not None:
            first, second = (start.position[self.names.index(name)] for name in error.bodies)
            apart = number(self._units.attach(np.float64(np.linalg.norm(second - first)), "length"))
            text = f"overlap{when}, their centres {apart} apart; expected interiors apart"
        else:
            time = number(self._units.attach(np.float64(error.time), "time"), 12)
            text = f"overlap at time {time}; expected interiors apart"
            text += " (events.Contact, terminal, ends a run at the contact)"
        return BodiesOverlap(f"{' and '.join(error.bodies)} {text}", error.bodies, error.time)

    @contextmanager
    def _explaining(self, state: Callable[[], _core.State], when: str = "") -> Iterator[None]:
        """A context in which the error about bodies that overlap tells how far apart they are in a state."""
        try:
            yield
        except BodiesOverlap as error:
            raise self._explained(error, state(), when) from None
