"""A system: bodies under their mutual gravity."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Literal, Self

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import epochs
from ..base.arguments import integer, names_of, place, sequence, suggestion
from ..base.tables import Table, Tabled, head, number
from ..base.units import Units, numbers, scalar
from ..errors import BodiesOverlap, ForceFailed, FullbodyError, InvalidInput
from ..typing import Array, Scalar
from .bodies import Body
from .composite import Composite, warn_of_cancelling
from .force import Force, Ground, forces_of, rebuilt
from .gravity import Gravity, gravity_at, points_in
from .interactions import Energy, Interactions, Loads
from .jacobian import Jacobian
from .state import State

__all__ = ["BaseSystem"]


class BaseSystem(Tabled):
    """Bodies under their mutual gravity; ``system["Beta"]`` is one of them, by name or place.

    Parameters
    ----------
    bodies : sequence of Body
        Two or more; one alone turns freely.
    G : float or Quantity, optional
        Gravitational constant in the units of everything else. With ``units`` it is astropy's unless given.
    gravity : str
        ``"focal"`` (the focal rule), ``"surface"`` (the paper's integrals, Eqs. 2-4): both exact;
        ``"multipole:N"`` (the mutual expansion to total degree N, even, 2 to 16), ``"point"``.
    gravity_tolerance : float
        The error that the quadrature may have, relative to the size of the force, and for the torque on a body relative
        to the force times its longest semi-axis. At worst it has three to four times that. Rounding leaves 2e-14 of
        either. The energy by ``"surface"`` may be off by thirty times the tolerance where surfaces nearly touch. Where
        the quadrature cannot reach the tolerance, :class:`NotConverged` is raised.
    order : (int, int), optional
        A fixed order (n, m) of the quadrature instead of the tolerance: n Gauss points, m angles.
    units : (length, time, mass) or bool, optional
        Names or astropy units; ``True`` for km, hour, kg. Results are then Quantities, and plain numbers are taken to
        be in these units. Text with a unit, such as ``"1 day"``, is welcome wherever a Quantity is.
    attitude_chart : {"quaternion", "tait_bryan"}
        How attitudes are integrated. ``"tait_bryan"`` takes the paper's kinematic equations, which are singular at
        theta = 90 degrees.
    vector_path : {"auto", "portable", "avx2", "avx512", "neon", "simd128"}
        Instructions of the hot loops. They change results at round-off only; ``"portable"`` gives the same bits on
        every machine.
    epoch : astropy Time or str, optional
        The date of time zero, such as ``"2022-09-26T00:00:00 TDB"``; for :attr:`Run.dates`.
    frame : str, optional
        What the inertial axes are, such as ``"ecliptic"`` or ``"equatorial"``. No result depends on it; the elements of
        a run know it (:meth:`fullbody.KeplerElements.to_frame`).
    forces : sequence of Force
        What acts beside the bodies' gravity, from :mod:`fullbody.forces`, under distinct names.

    Raises
    ------
    InvalidInput

    Examples
    --------
    >>> import fullbody
    >>> alpha = fullbody.Body(fullbody.Ellipsoid(0.766, 0.7475, 0.6735), mass=2.353e12, name="Alpha")
    >>> beta = fullbody.Body(fullbody.Ellipsoid(0.285, 0.2315, 0.1745), mass=0.135e12, name="Beta")
    >>> fullbody.System([alpha, beta], G=8.64960768e-13)
    System(['Alpha', 'Beta'], G=8.64960768e-13, gravity='focal')
    """

    __slots__ = ("_G", "_attraction", "_bodies", "_calls", "_core", "_forces", "_options", "_units")

    def __init__(
        self,
        bodies: Sequence[Body],
        G: Any = None,
        *,
        gravity: str = "focal",
        gravity_tolerance: float = 1e-14,
        order: tuple[int, int] | None = None,
        units: tuple[object, object, object] | bool | None = None,
        attitude_chart: Literal["quaternion", "tait_bryan"] = "quaternion",
        vector_path: Literal["auto", "portable", "avx2", "avx512", "neon", "simd128"] = "auto",
        epoch: Any = None,
        frame: str | None = None,
        forces: Sequence[Force] = (),
    ) -> None:
        self._units = Units(units)
        given = sequence(bodies, Body, "bodies", "a sequence of Body", "a sequence of Body")
        self._bodies = tuple(body._with(self._units) for body in given)
        if G is None:
            if not self._units.known:
                raise InvalidInput("G is not given; expected a number, or units=(length, time, mass)")
            self._G = self._units.gravitational_constant
        else:
            self._G = scalar(self._units.strip(G, "G", "G"), "G")
        if frame is not None and not isinstance(frame, str):
            raise InvalidInput(f"frame is {frame!r}; expected a name, such as 'ecliptic'")
        for name, value in (("gravity", gravity), ("attitude_chart", attitude_chart), ("vector_path", vector_path)):
            if not isinstance(value, str):
                raise InvalidInput(f"{name} is {value!r}; expected text")
        core = self._core_bodies()
        tolerance = _tolerance(gravity_tolerance)
        settings = {
            "gravity": gravity,
            "gravity_tolerance": tolerance,
            "order": None if order is None else _order(order),
            "attitude_chart": attitude_chart,
            "vector_path": vector_path,
        }
        self._forces = forces_of(forces)
        ground = Ground(self._units, self._G, self._bodies, self.names)
        self._calls = {force.name: call for force in self._forces if (call := force._call(ground)) is not None}
        functions = {name: call.given() for name, call in self._calls.items()}
        described = [force._describe(ground) for force in self._forces]
        self._core = _core.System(core, self._G, settings, described, functions)
        for body, made, name in zip(self._bodies, core, self.names, strict=True):
            if isinstance(body.shape, Composite):
                warn_of_cancelling(name, np.array([mass for _, mass, *_ in made.given]), tolerance)
        self._attraction: _core.Attraction | None = None
        named = {"epoch": None if epoch is None else epochs.to_text(epoch), "frame": frame}
        self._options: dict[str, Any] = self._core.settings | named
        if self._options["order"] is not None:
            self._options["order"] = tuple(self._options["order"])

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies; where the system has units, their plain numbers are Quantities in them."""
        return self._bodies

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies; ``body i`` where none was given."""
        return tuple(b.name if b.name is not None else f"body {i}" for i, b in enumerate(self._bodies))

    @property
    def G(self) -> Scalar:
        """Gravitational constant."""
        constant: Scalar = self._units.attach(self._G, "G")
        return constant

    @property
    def units(self) -> tuple[str, str, str] | None:
        """Units of length, time and mass, if the system has any."""
        return self._units.names

    @property
    def epoch(self) -> Any:
        """The date of time zero as an ``astropy.time.Time``, or ``None``.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1(epoch="2022-09-26T12:00:00 TDB")
        >>> system.epoch.jd
        np.float64(2459849.0)
        """
        text = self._options["epoch"]
        return None if text is None else epochs.to_time(text)

    @property
    def frame(self) -> str | None:
        """The name of the inertial frame, if one was given."""
        name: str | None = self._options["frame"]
        return name

    @property
    def options(self) -> dict[str, Any]:
        """The method and its settings."""
        return dict(self._options)

    @property
    def forces(self) -> tuple[Force, ...]:
        """The forces from outside."""
        return self._forces

    @property
    def masses(self) -> Array:
        """Masses (N,)."""
        masses: Array = self._units.attach(self._masses, "mass")
        return masses

    @property
    def _masses(self) -> npt.NDArray[np.float64]:
        """Masses (N,) as numbers in the system's units."""
        return self._core.masses

    def mu(self, body: int | str = 1, about: int | str = 0) -> Scalar:
        """G times the sum of two masses.

        Parameters
        ----------
        body, about : int or str
            Places in :attr:`~fullbody.System.bodies`, or names, of two bodies.
        """
        first, second = self._place(body, "body"), self._place(about, "about")
        if first == second:
            raise InvalidInput(
                f"body and about are {body!r} and {about!r}, both {self.names[first]}; expected two bodies"
            )
        return self._units.attach_mu(float(self._G * (self._masses[first] + self._masses[second])))

    def index(self, body: int | str) -> int:
        """The place of a body.

        Parameters
        ----------
        body : int or str
            Its name, or its place itself.

        Raises
        ------
        InvalidInput
            For a body that the system does not have.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> system.index("Beta"), system["Beta"].shape
        (1, Ellipsoid(a=0.285, b=0.2315, c=0.1745))
        """
        return self._place(body, "body")

    def __getitem__(self, body: int | str) -> Body:
        return self._bodies[self.index(body)]

    def __iter__(self) -> Iterator[Body]:
        return iter(self._bodies)

    def __contains__(self, body: object) -> bool:
        return body in self.names if isinstance(body, str) else body in self._bodies

    def _place(self, index: object, what: str) -> int:
        """A place in the system from a place or a name, or an error that says which there are."""
        return place(index, self.names, what)

    def with_options(self, **options: Any) -> Self:
        """The same bodies and G with other settings.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.with_options(gravity="surface").options["gravity"]
        'surface'
        """
        options = {**self._options, "forces": self._forces, **options}
        return type(self)(self._bodies, self.G, units=self._units.names, **options)

    def with_forces(self, forces: Sequence[Force]) -> Self:
        """The same system with these forces from outside in place of its own.

        Parameters
        ----------
        forces : sequence of Force
            From :mod:`fullbody.forces`; none, for a system that is left to itself.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> system.with_forces([tide]).forces[0].name
        'tide on Alpha'
        """
        return self.with_options(forces=forces)

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

    def _core_bodies(self) -> list[_core.Body]:
        """The bodies in the system's units."""
        return [body._core(self._units, index) for index, body in enumerate(self._bodies)]

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the numbers that motions can be differentiated by: ``"G"``, ``"mass of Alpha"`` and so on.

        ``"mass of"`` and ``"density of"`` are at a body's shape, ``"semi-axis a of"`` at its mass; ``"mu of"`` a third
        body at its path. Semi-axes are among them only without third bodies, and not by ``gravity="multipole:N"``.

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

    def _functions(self) -> tuple[Force, ...]:
        """The forces that files cannot keep."""
        return tuple(force for force in self._forces if force.name in self._calls)

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

    def __len__(self) -> int:
        return len(self._bodies)

    def _describe(self) -> dict[str, Any]:
        """The system in numbers of its own units."""
        bodies = [body._describe(self._units, index) for index, body in enumerate(self._bodies)]
        parts = {"bodies": bodies, "G": self._G, "units": self._units.names, "options": self.options}
        return parts | ({"forces": self._core.forces} if self._forces else {})

    def _notes(self) -> dict[str, Any]:
        """What this package alone knows of the system; the numbers are the core's."""
        bodies = [{**body._shape_notes(), "named": body.name is not None} for body in self._bodies]
        return {
            "units": self._units.names,
            "epoch": self._options["epoch"],
            "frame": self._options["frame"],
            "bodies": bodies,
        }

    @classmethod
    def _of_core(cls, setup: dict[str, Any], notes: dict[str, Any], functions: dict[str, Force]) -> Self:
        """The system of a core's set-up and of such notes, which may be missing: a program in Rust leaves none."""
        bodies = []
        noted = notes.get("bodies", [{}] * len(setup["bodies"]))
        for index, (body, note) in enumerate(zip(setup["bodies"], noted, strict=True)):
            unnamed = body["name"] == f"body {index}" and not note.get("named", True)
            bodies.append(Body._noted(body, note) | {"name": None if unnamed else body["name"]})
        named = {name: notes.get(name) for name in ("epoch", "frame")}
        parts = {"bodies": bodies, "G": setup["G"], "units": notes.get("units"), "options": setup["settings"] | named}
        return cls._rebuild(parts | {"forces": setup["forces"]}, functions)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BaseSystem) or self._describe() != other._describe():
            return False
        return self._functions() == other._functions()

    def __hash__(self) -> int:
        return hash(repr(self))

    def _tables(self) -> tuple[Table, ...]:
        """Constant, method and settings of a system."""
        rows: list[Sequence[str]] = [("units", ", ".join(self.units) if self.units else "none")]
        rows.append(("G", number(self.G, 12)))
        rows += [
            (name.replace("_", " "), f"{value}")
            for name, value in self.options.items()
            if value not in (None, "auto") and not (name == "attitude_chart" and value == "quaternion")
        ]
        return (Table("System", (), rows), self._table_of_bodies(), *self._tables_of_forces())

    def _table_of_bodies(self) -> Table:
        """The bodies of a system, one a row, in its units."""
        units = self._units
        length, mass = (units.unit(d) if units.known else "" for d in ("length", "mass"))
        header = ("body", "shape", head("semi-axes", length), head("mass", mass))
        rows: list[Sequence[str]] = []
        for name, described in zip(self.names, self._describe()["bodies"], strict=True):
            parts = described.get("parts")
            sizes = described.get("size", {})
            if parts is not None:
                size = f"{len(parts)} parts"
            elif "faces" in sizes:
                size = f"{len(sizes['faces'])} faces"
            else:
                size = ", ".join(f"{value:.8g}" for value in sizes.values())
            mass = described["mass"] if parts is None else sum(part["mass"] for part in parts)
            rows.append((name, described["shape"], size or "-", f"{mass:.8g}"))
        return Table("Bodies", header, rows)

    def _tables_of_forces(self) -> tuple[Table, ...]:
        """The forces from outside, one a row, where there are some."""
        both = zip(self._forces, self._core.forces, strict=True)
        rows: list[Sequence[str]] = [
            (force.name, type(force).__name__, force._words(described, self._units)) for force, described in both
        ]
        return (Table("Forces", ("force", "kind", "what"), rows),) if rows else ()

    def __repr__(self) -> str:
        units = "" if self._units.names is None else f", units={self._units.names}"
        forces = f", forces={[force.name for force in self._forces]}" if self._forces else ""
        gravity = f"gravity={self._options['gravity']!r}"
        return f"System({list(self.names)}, G={float(f'{self._G:.9g}')!r}, {gravity}{units}{forces})"

    def __reduce__(self) -> Any:
        return (_assemble, (type(self), self._bodies, self._G, self._units.names, self._options, self._forces))

    @classmethod
    def _rebuild(cls, described: dict[str, Any], functions: dict[str, Force] | None = None) -> Self:
        """The system of a description, which may come from a file; forces that are functions are given beside it."""
        units = None if described["units"] is None else tuple(described["units"])
        bodies = [Body._rebuild(body) for body in described["bodies"]]
        options = dict(described["options"])
        options["order"] = None if options["order"] is None else tuple(options["order"])
        forces = [
            (functions or {}).get(force["name"]) or rebuilt(force, Units(units))
            for force in described.get("forces", ())
        ]
        return cls(bodies, described["G"], units=units, forces=forces, **options)


def _assemble(
    kind: type[BaseSystem], bodies: Any, G: float, units: Any, options: dict[str, Any], forces: Any
) -> BaseSystem:
    return kind(bodies, G, units=units, forces=forces, **options)


def _tolerance(value: Any) -> float:
    """The tolerance as a number; the core knows its limits."""
    try:
        return scalar(numbers(value, "gravity_tolerance"), "gravity_tolerance")
    except InvalidInput as error:
        raise InvalidInput(f"gravity_tolerance is {value!r}; expected a number such as 1e-14") from error


def _order(value: Any) -> tuple[int, int]:
    """The order as whole numbers that the core can take; it knows its limits."""
    numbers = [integer(part) for part in value] if isinstance(value, tuple | list) else []
    match numbers:
        case [int(gauss), int(angles)] if 0 <= gauss < 2**31 and 0 <= angles < 2**31:
            return gauss, angles
    raise InvalidInput(f"order is {value!r}; expected (n, m), whole numbers: n Gauss points, m angles")
