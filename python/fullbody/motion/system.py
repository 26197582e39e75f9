"""A system: bodies under their mutual gravity, their interactions at a state, and their integration."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal, Self, cast

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import epochs
from ..base.arguments import names_of, place, refuse_unknown, sequence
from ..base.progress import Progress
from ..base.tables import Table, Tabled
from ..base.units import Units, scalar
from ..errors import InvalidInput, caution
from ..events import Event
from ..model.bodies import Body
from ..model.composite import Composite, warn_of_cancelling
from ..model.context import Context
from ..model.failures import explaining
from ..model.force import Force, forces_of, rebuilt
from ..model.gravity import Gravity, gravity_at, points_in
from ..model.interactions import Energy, Interactions, Loads
from ..model.jacobian import Jacobian
from ..model.shapes import Solid
from ..model.state import State, strip, wrap
from ..particles.events import ParticleEvent
from ..particles.flight import Flight
from ..particles.given import Particles
from ..particles.rules import Bounce, Escape, Radiation
from ..particles.task import FlightTask
from ..record.dense import Dense
from ..record.integrators import Integrator
from ..typing import Array, Scalar
from .input_warnings import density_warning
from .integration import begin
from .integration import integrate as _integrate
from .options import sampling
from .run import Run
from .settings import quadrature_order, tolerance
from .tables import system_tables

__all__ = ["System"]

#: The names of the notes that a description keeps of a system, its bodies and its forces.
_NOTES = ("units", "epoch", "frame", "bodies", "forces")
_NOTED = {"bodies": ("named", "shape", "parts"), "forces": ("date",)}


class System(Tabled):
    """Bodies under their mutual gravity; ``system["Beta"]`` is one of them, by name or index.

    Parameters
    ----------
    bodies : sequence of Body
        Two or more bodies; a single body turns freely.
    G : float or Quantity, optional
        Gravitational constant in the units of all other numbers. With ``units`` it is that of astropy by default.
    gravity : str
        The method: ``"focal"`` (the focal rule) and ``"surface"`` (the paper's integrals, Eqs. 2-4) are exact;
        ``"harmonic"`` is the series of harmonic moments, exact to the tolerance where the spheres around the bodies are
        apart, which ``"focal"`` uses for polyhedra there; ``"multipole:N"`` is the series to the total degree N (2 to
        60), and ``"point"`` takes point masses.
    gravity_tolerance : float
        The tolerance of the quadrature, relative to the force, and for the torque on a body relative to the force times
        its longest semi-axis; 1e-14 by default. In the worst case the error is three to four times as large. Rounding
        adds 2e-14 to either. The error of the energy by ``"surface"`` may be thirty times the tolerance if surfaces
        nearly touch. If the quadrature cannot reach the tolerance, :class:`NotConverged` is raised.
    order : (int, int) or int, optional
        A fixed order (n, m) of the quadrature instead of the tolerance, with n Gauss points and m angles; for
        ``"harmonic"`` one degree, from 1 to 80.
    units : (length, time, mass) or bool, optional
        Names or astropy units; ``True`` for km, hour, kg. Results are then Quantities, and plain numbers are taken to
        be in these units. Text with a unit, such as ``"1 day"``, is accepted wherever a Quantity is.
    attitude_chart : {"quaternion", "tait_bryan"}
        The variables in which attitudes are integrated. ``"tait_bryan"`` takes the paper's kinematic equations, which
        are singular at theta = 90 degrees.
    vector_path : {"auto", "portable", "avx2", "avx512", "neon", "simd128"}
        Vector instructions of the hot loops, which change results at round-off only; ``"portable"`` gives the same bits
        on every machine.
    epoch : astropy Time or str, optional
        The date of time zero, such as ``"2022-09-26T00:00:00 TDB"``; for :attr:`Run.dates`.
    frame : str, optional
        Name of the inertial axes, such as ``"ecliptic"`` or ``"equatorial"``. No number depends on it; the elements of
        a run keep it for :meth:`fullbody.KeplerElements.to_frame`.
    forces : sequence of Force
        External forces from :mod:`fullbody.forces`, with distinct names.

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

    __slots__ = ("_G", "_bodies", "_calls", "_core", "_forces", "_options", "_units", "context")

    def __init__(
        self,
        bodies: Sequence[Body],
        G: Any = None,
        *,
        gravity: str = "focal",
        gravity_tolerance: float | None = None,
        order: tuple[int, int] | int | None = None,
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
        settings: dict[str, Any] = {
            "gravity": gravity,
            "order": None if order is None else quadrature_order(order, gravity),
            "attitude_chart": attitude_chart,
            "vector_path": vector_path,
        }
        if gravity_tolerance is not None:
            settings["gravity_tolerance"] = tolerance(gravity_tolerance)
        self._forces = forces_of(forces)
        date = None if epoch is None else epochs.to_text(epoch)
        names = tuple(b.name if b.name is not None else f"body {i}" for i, b in enumerate(self._bodies))
        handle = _core.System(core, self._G, settings, [], {})
        # Forces describe themselves in the context of the bodies.
        context = Context(self._units, self._G, names, tuple(core), handle, date, frame)
        calls = {force.name: call for force in self._forces if (call := force._call(context)) is not None}
        functions = {name: call.given() for name, call in calls.items()}
        described = [force._describe(context) for force in self._forces]
        if described:
            handle = _core.System(core, self._G, settings, described, functions)
        self.context = replace(
            context,
            core=handle,
            forces={force.name: force._kind for force in self._forces},
            calls=calls,
            notes={
                "units": self._units.names,
                "epoch": date,
                "frame": frame,
                "bodies": [body._notes() for body in self._bodies],
                "forces": [force._notes() for force in self._forces],
            },
        )
        self._core, self._calls = handle, calls
        reached = self._core.settings["gravity_tolerance"]
        for body, made, name in zip(self._bodies, core, self.names, strict=True):
            if (warning := density_warning(self._units, made, name)) is not None:
                caution(warning)
            if isinstance(body.shape, Composite):
                warn_of_cancelling(name, np.array([mass for _, mass, *_ in made.given]), reached)
        self._options: dict[str, Any] = self._core.settings | {"epoch": date, "frame": frame}
        if self._options["order"] is not None:
            self._options["order"] = tuple(self._options["order"])

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies; if the system has units, their plain numbers are Quantities in them."""
        return self._bodies

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies; a body without a name is called ``body i``."""
        return self.context.names

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
        """The method of gravity and its settings."""
        return dict(self._options)

    @property
    def forces(self) -> tuple[Force, ...]:
        """The external forces."""
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
        """Return G times the sum of two masses.

        Parameters
        ----------
        body, about : int or str
            Indices in :attr:`~fullbody.System.bodies`, or names, of two bodies.
        """
        return self._units.attach_mu(self.context.mu(*self.context.pair(body, about)))

    def index(self, body: int | str) -> int:
        """Return the index of a body.

        Parameters
        ----------
        body : int or str
            The body's name or index.

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
        """Return the index of a body from its index or name, or raise an error that lists the bodies."""
        return place(index, self.names, what)

    def with_options(self, **options: Any) -> Self:
        """Return a system of the same bodies and G with other settings.

        Parameters
        ----------
        **options
            Options of :class:`fullbody.System`, except bodies, G and units.

        Raises
        ------
        InvalidInput
            For invalid values, and for names that are not such options.

        See Also
        --------
        fullbody.System.with_body, fullbody.System.with_force

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.with_options(gravity="surface").options["gravity"]
        'surface'
        """
        refuse_unknown(options, (*self._options, "forces"), "with_options, which keeps bodies, G and units")
        options = {**self._options, "forces": self._forces, **options}
        return type(self)(self._bodies, self.G, units=self._units.names, **options)

    def with_body(self, body: int | str, shape: Solid | Composite, mass: Any = None, density: Any = None) -> Self:
        """Return the system with another shape of one body.

        Everything else stays the same: the body's name, its mass unless another one is given, the other bodies,
        settings, epoch, frame and forces.

        Parameters
        ----------
        body : int or str
            The body's index in the system, or its name.
        shape : Ellipsoid, Sphere, PointMass, Polyhedron or Composite
            The new shape. The masses of a composite's parts are scaled to the body's mass.
        mass, density : float or Quantity, optional
            Another mass, or the density from which it follows; give at most one of the two.

        Raises
        ------
        InvalidInput
            For a body that the system does not have, and for the same reasons as :class:`fullbody.Body`.

        Notes
        -----
        The state of a body is that of its centre of mass and of its principal axes, whatever its shape.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.didymos_after_dart(sun=True)
        >>> system = system.with_body("Dimorphos", fullbody.Sphere(0.075))
        >>> system["Dimorphos"].shape, [force.name for force in system.forces]
        (Sphere(radius=0.075), ['Sun'])
        """
        index = self._place(body, "body")
        old = self._bodies[index]
        if mass is None and density is None:
            mass = old.mass
        if isinstance(shape, Composite):
            if density is not None:
                raise InvalidInput(f"density of {self.names[index]} is {density!r}; expected a mass beside a composite")
            new = Body(shape._with(self._units).with_mass(mass), name=old.name)
        else:
            new = Body(shape, mass, density, old.name)
        bodies = (*self._bodies[:index], new, *self._bodies[index + 1 :])
        return type(self)(bodies, self.G, units=self._units.names, forces=self._forces, **self._options)

    def with_force(self, force: Force) -> Self:
        """Return the system with one more external force.

        Parameters
        ----------
        force : Force
            A force from :mod:`fullbody.forces`.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.didymos(sun=True)
        >>> tide = fullbody.forces.Tide(on="Didymos", by="Dimorphos", k2=1e-5, lag=0.01)
        >>> [force.name for force in system.with_force(tide).forces]
        ['Sun', 'tide on Didymos']
        """
        return self.with_options(forces=(*self._forces, *forces_of([force])))

    def with_forces(self, forces: Sequence[Force]) -> Self:
        """Return the system with these external forces in place of its own; :meth:`with_force` adds one.

        Parameters
        ----------
        forces : sequence of Force
            Forces from :mod:`fullbody.forces`; an empty list removes all external forces.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> system.with_forces([tide]).forces[0].name
        'tide on Alpha'
        """
        return self.with_options(forces=forces)

    def _core_bodies(self) -> list[_core.Body]:
        """Return the core's bodies in the system's units."""
        return [body._core(self._units, index) for index, body in enumerate(self._bodies)]

    def _functions(self) -> tuple[Force, ...]:
        """Return the forces that files cannot keep."""
        return tuple(force for force in self._forces if force.name in self._calls)

    def __len__(self) -> int:
        return len(self._bodies)

    def _describe(self) -> dict[str, Any]:
        """Return the core's description of the system, in numbers of its own units, with notes."""
        return self.context.describe()

    @classmethod
    def _rebuild(cls, described: dict[str, Any], functions: dict[str, Force] | None = None) -> Self:
        """Rebuild the system from such a description, which may come from a file; forces that are functions are given.

        Notes may be missing, since Rust programs write none.
        """
        notes = described.get("notes", {})
        refuse_unknown(notes, _NOTES, "the notes of a system")
        bodies, forces = (_noted(described[name], notes, name) for name in ("bodies", "forces"))
        units = notes.get("units")
        own = Units(None if units is None else tuple(units))
        given = functions or {}
        return cls(
            [Body._rebuild(body, note) for body, note in bodies],
            described["G"],
            units=own.names,
            epoch=notes.get("epoch"),
            frame=notes.get("frame"),
            forces=[given.get(force["name"]) or rebuilt(force | note, own) for force, note in forces],
            **described["settings"],
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, System) or self._describe() != other._describe():
            return False
        return self._functions() == other._functions()

    def __hash__(self) -> int:
        return hash(repr(self))

    def _tables(self) -> tuple[Table, ...]:
        return system_tables(self)

    def __repr__(self) -> str:
        units = "" if self._units.names is None else f", units={self._units.names}"
        forces = f", forces={[force.name for force in self._forces]}" if self._forces else ""
        gravity = f"gravity={self._options['gravity']!r}"
        return f"System({list(self.names)}, G={float(f'{self._G:.9g}')!r}, {gravity}{units}{forces})"

    def __reduce__(self) -> Any:
        return partial(System, units=self._units.names, forces=self._forces, **self._options), (self._bodies, self._G)

    def loads(self, state: State) -> dict[str, Loads]:
        """Return the loads of each external force in a state, by its name.

        The nominal barycentre is that of the state: a third body is where its path places it relative to this
        barycentre.

        Parameters
        ----------
        state : State

        Returns
        -------
        dict of Loads
            The forces (N, 3) in the inertial frame and the torques (N, 3) in body frames, by name.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> system.with_forces([tide]).loads(state)["tide on Alpha"].force.shape
        (2, 3)
        """
        core = self._strip(state)
        with explaining(self.context, core):
            forces, torques = self._core.external_loads(core)
        attach = self._units.attach
        both = zip(self._forces, forces, torques, strict=True)
        return {force.name: Loads(attach(f, "force"), attach(m, "torque")) for force, f, m in both}

    def third_body(self, name: str, time: Any) -> tuple[Array, Array]:
        """Return the position and velocity of a third body relative to the system's nominal barycentre.

        Parameters
        ----------
        name : str
            Name of a :class:`fullbody.forces.ThirdBody` of the system.
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
        """Return the index of a third body among the forces by its name, or raise an error that lists them."""
        return self.context.third_body(name, what)

    def interactions(self, state: State) -> Interactions:
        """Return the forces and torques on the bodies and the potential energy in a state.

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
            If the quadrature reaches its limit of nodes, as for bodies in contact with sharp rims.

        Notes
        -----
        The results are those of the paper's Eqs. (2) and (3), and for the potential energy minus Eq. (4).

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
        with explaining(self.context, core):
            force, torque, energy, truncation_error = self._core.interactions(core)
        attach = self._units.attach
        loads = (attach(force, "force"), attach(torque, "torque"))
        return Interactions(*loads, attach(energy, "energy"), truncation_error)

    def gravity(self, state: State, points: Any, body: int | str | None = None) -> Gravity:
        """Return potential, field and gravity gradient of the bodies at points of the inertial frame, outside or
        inside.

        The sum is over the bodies only and does not include external forces such as the pull of a third body.

        Parameters
        ----------
        state : State
        points : array_like or Quantity, (..., 3)
            Inertial.
        body : int or str, optional
            The body whose gravity is computed, by its name or index; by default all bodies.

        Returns
        -------
        Gravity
            ``.potential`` (...), ``.field`` (..., 3) and ``.gradient`` (..., 3, 3), inertial.

        Raises
        ------
        InvalidInput
            For a point at a point mass or with coordinates that are not finite, which the message gives by its index;
            for the gradient on a polyhedron's surface.

        See Also
        --------
        Body.gravity : The gravity of one body in its own frame.

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
        """The bodies' gravity, which is prepared at its first use."""
        return self.context.attraction

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters by which motions can be differentiated: ``"G"``, ``"mass of Alpha"`` and so on.

        - ``"mass of"`` and ``"density of"`` a body are taken at a fixed shape, ``"semi-axis a of"`` an ellipsoid at a
          fixed mass; ``"scale of"`` a polyhedron is a factor of all its lengths, whose value is one, at a fixed mass.
        - ``"mass of part 0 of"`` and ``"position x of part 0 of"`` a composite refer to its working frame: the centre
          of mass and the principal axes move with these parameters, while the state of the body is held fixed.
        - ``"mu of"`` or ``"mass of"`` a third body, as it was given; ``"a of"``, ``"e of"``, ``"i of"``,
          ``"Omega of"``, ``"omega of"``, ``"M of"`` and ``"time of"`` its orbit. The period of the orbit depends on the
          masses of both bodies, so that mu, ``"G"`` and masses act through it too.
        - ``"k2 of"`` and ``"lag of"`` a tide: only their product acts, so that a fit can free one of them.
        - ``"along of"`` and ``"across of"`` YORP are torques; YORP from a table has ``"factor of"`` instead, a factor
          of both torques whose value is one. BYORP has ``"force of"``.

        All are numbers in the system's own units. Other numbers of forces, such as the radius of a tide, are held
        fixed.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.systems.kw4()[0].parameters[:4]
        ('G', 'mass of Alpha', 'density of Alpha', 'semi-axis a of Alpha')
        """
        return tuple(self._core.parameters)

    def _changed(self, name: str, by: float) -> tuple[Self, float]:
        """Return the system with one of its :attr:`parameters` changed, and a natural size of such changes."""
        bodies, forces, G, size = self._core.changed(name, by)
        described = self._describe() | {"bodies": bodies, "forces": forces, "G": G}
        for body, note in zip(self.names, described["notes"]["bodies"], strict=True):
            if name.startswith("semi-axis") and name.endswith(f" of {body}"):
                # A sphere with one changed semi-axis is an ellipsoid.
                note.pop("shape", None)
        return self._rebuild(described, {force.name: force for force in self._functions()}), size

    def jacobian(self, state: State, parameters: Iterable[str] = ()) -> Jacobian:
        """Return the derivatives of forces, torques and rates of change at a state, exact to round-off.

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
        with explaining(self.context, core):
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
        """Return the energy of a state in its parts.

        Parameters
        ----------
        state : State

        Returns
        -------
        Energy
        """
        core = self._strip(state)
        with explaining(self.context, core):
            parts = self._core.energy(core)
        return Energy(*(self._units.attach(part, "energy") for part in parts))

    def momentum(self, state: State) -> Array:
        """Return the total momentum (3,) of a state in the inertial frame."""
        momentum: Array = self._units.attach(self._core.momentum(self._strip(state)), "momentum")
        return momentum

    def angular_momentum(self, state: State) -> Array:
        """Return the total angular momentum (3,) about the origin, inertial frame: the paper's ``eq:Total_angmom``."""
        momentum = self._core.angular_momentum(self._strip(state))
        total: Array = self._units.attach(momentum, "angular momentum")
        return total

    def _strip(self, state: State) -> _core.State:
        return strip(state, self.context)

    def _state(self, core: _core.State) -> State:
        """Return the core's state with units and the bodies' names."""
        return wrap(core, self.context)

    def integrate(
        self,
        state: State,
        until: Any,
        output: Any = None,
        integrator: Integrator | None = None,
        events: Iterable[Event] = (),
        dense: bool = False,
        progress: Any = False,
        autosave: tuple[Any, float] | None = None,
        derivatives: bool | Iterable[str] = False,
        chaos: bool = False,
    ) -> Run:
        """Integrate the motion from a state to a time.

        Parameters
        ----------
        state : State
        until : float, Quantity or text with a unit
            End of the run, such as ``"30 day"``; a time before ``state.time`` makes a run backwards.
        output : None, "ends", float, Quantity or array_like
            The times that are recorded. ``None`` means every accepted step, ``"ends"`` the start and the end, a number
            the spacing of times from the start to the end, and an array exactly these times; with an empty array only
            events (and ``dense``) are recorded.
        integrator : Integrator, optional
            :class:`fullbody.Verner98` unless given.
        events : iterable of Event
            Events to detect, from :mod:`fullbody.events`; a terminal one ends the run.
        dense : bool
            Whether the run is kept as a function of time, ``run(t)``, which takes 2.3 kB per step for two bodies.
        progress : bool, str or callable
            ``True`` or a title for a progress bar, or a function of (done, total, description) that is called at most
            every 50 ms with the time that has passed, the whole time, and a text. The result of the function is
            ignored; an error that it raises ends the run.
        autosave : (path, seconds), optional
            The path of a file and an interval. The simulation is written to the file when the run begins, at this
            interval and when the run ends; :meth:`fullbody.Simulation.load` continues from it.
        derivatives : bool or sequence of str
            Whether the run is differentiated with respect to its start, for ``run.transition``; or the names from
            ``system.parameters`` by which it is differentiated as well, for ``run.sensitivity``. The motion itself has
            the same bits with and without derivatives.
        chaos : bool
            Whether tangent growth is measured, for ``run.megno``, ``run.lyapunov`` and ``run.fast_lyapunov``.

        Returns
        -------
        Run

        Raises
        ------
        InvalidInput, BodiesOverlap, NotConverged, StepSizeTooSmall, ChartSingularity
            If an error ends the run; the run so far is in its attribute ``run``.
        Interrupted
            On Ctrl-C; it is a KeyboardInterrupt with the run so far in its attribute ``run``.

        Warns
        -----
        InconsistentInput
            For starts that are probably a mistake; see :class:`fullbody.Simulation`.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 10.0, output=1.0)
        >>> run.position.shape
        (11, 2, 3)
        """
        core, chosen = begin(self, state, integrator)
        return _integrate(
            self,
            chosen,
            core,
            until,
            output,
            events=events,
            dense=dense,
            progress=progress,
            autosave=autosave,
            derivatives=derivatives,
            chaos=chaos,
        )

    def fly(
        self,
        state: State,
        particles: Particles,
        until: Any,
        output: Any = None,
        *,
        integrator: Integrator | None = None,
        contact: str | Bounce = "stop",
        escape: Escape | None = None,
        radiation: Radiation | None = None,
        events: Iterable[ParticleEvent] = (),
        bodies_integrator: Integrator | None = None,
        threads: int | None = None,
        progress: Any = False,
    ) -> Flight:
        """Fly massless particles among the bodies, from a state to a time.

        The bodies are integrated first, as by :meth:`integrate`, and the particles are integrated along their
        continuous solution, which takes 2.3 kB per step for two bodies. For several flights along the same motion, keep
        a run with ``dense=True`` and use :meth:`fullbody.Run.fly`, where the other parameters are described.

        Parameters
        ----------
        state : State
            State of the bodies at the particles' time.
        particles : Particles
        until : float, Quantity or text with a unit
            End of the flight; a time before ``state.time`` makes a flight backwards.
        output : None, "ends", float, Quantity or array_like
        integrator : Integrator, optional
        contact : {"stop", "remove"} or Bounce
        escape : Escape, optional
        radiation : Radiation, optional
        events : iterable of ParticleEvent
        bodies_integrator : Integrator, optional
            Integrator of the bodies, as in :meth:`integrate`.
        threads : int, optional
        progress : bool, str or callable

        Returns
        -------
        Flight

        Raises
        ------
        InvalidInput, Interrupted
            For the same reasons as :meth:`fullbody.Run.fly` and :meth:`integrate`.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> up = fullbody.Particles.from_surface(system, state, "Beta", longitude=0.0, latitude=0.5, speed=0.1)
        >>> system.fly(state, up, 24.0).fate.tolist()
        ['impact']
        """
        options: dict[str, Any] = {"integrator": integrator, "contact": contact, "escape": escape}
        options |= {"radiation": radiation, "events": events, "threads": threads}
        task, samples = FlightTask(self, particles, **options), sampling(output, self._units)
        run = self.integrate(
            state, until, output=[], integrator=bodies_integrator, dense=True, progress=progress and "bodies"
        )
        dense = cast(Dense, run.dense)
        with Progress(progress if callable(progress) else progress and "particles") as report:
            return task.fly(dense, *dense.range, samples, report)


def _noted(parts: list[Any], notes: dict[str, Any], what: str) -> list[tuple[Any, dict[str, Any]]]:
    """Return each part of a description with its notes, which may be missing."""
    noted = notes.get(what, [{}] * len(parts))
    if len(noted) != len(parts):
        raise InvalidInput(f"the notes have {len(noted)} {what}; expected {len(parts)}, as the description has")
    for note in noted:
        refuse_unknown(note, _NOTED[what], f"the notes of {what}")
    return list(zip(parts, noted, strict=True))
