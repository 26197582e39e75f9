"""A system: bodies under their mutual gravity and external forces, and questions about them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, Literal, Self

import fullbody._core as _core

from ..base import epochs
from ..base.arguments import integer, normal_form, refuse_unknown, sequence
from ..base.attributes import Attribute
from ..base.kinds import instance
from ..base.limits import Limits
from ..base.tables import Table, Tabled, head
from ..base.units import UNITLESS, Units
from ..errors import InvalidInput, caution
from ..model.bodies import Body
from ..model.composite import Composite
from ..model.context import Context
from ..model.description import arguments, changed, functions, notes_of
from ..model.force import Force, acted_on, forces_of
from ..model.freeform import ConvexShape
from ..model.gravity import gravity
from ..model.interactions import angular_momentum, energy, interactions, jacobian, loads, momentum, third_body
from ..model.polyhedron import Polyhedron
from ..model.shapes import Solid
from ..model.stokes import StokesCoefficients
from ..typing import Array, Scalar
from .input_warnings import body_warnings
from .integration import fly, integrate


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
        its longest semi-axis; 1e-14 by default. In the worst case the error is three to four times as large, and that
        of the energy by ``"surface"`` thirty times if surfaces nearly touch. Rounding adds 2e-14. If the quadrature
        cannot reach the tolerance, :class:`fullbody.errors.NotConverged` is raised.
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

    __slots__ = ("_bodies", "_forces", "_options", "context")

    interactions = interactions
    energy = energy
    momentum = momentum
    angular_momentum = angular_momentum
    gravity = gravity
    jacobian = jacobian
    loads = loads
    third_body = third_body
    integrate = integrate
    fly = fly
    changed = changed

    def __init__(
        self,
        bodies: Sequence[Body],
        *,
        G: Any = None,
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
        unit_system, several = Units(units), "a sequence of Body"
        checked = sequence(bodies, Body, "bodies", several, several)
        if G is None and not unit_system.defined:
            raise InvalidInput("G is not given; expected a number, or units=(length, time, mass)")
        constant = unit_system.gravitational_constant if G is None else unit_system.number(G, "G", "G")
        self._bodies = tuple(body._with(unit_system, constant) for body in checked)
        if frame is not None and not isinstance(frame, str):
            raise InvalidInput(f"frame is {frame!r}; expected a name, such as 'ecliptic'")
        texts = {"attitude_chart": attitude_chart, "vector_path": vector_path}
        settings = _settings(gravity, gravity_tolerance, order, **texts)
        core = tuple(body._core(unit_system, index) for index, body in enumerate(self._bodies))
        self._forces = forces_of(forces)
        date = None if epoch is None else epochs.to_text(epoch)
        names = tuple(body.name if body.name is not None else f"body {k}" for k, body in enumerate(self._bodies))
        handle = _core.System(core, constant, settings, [], {})
        notes = notes_of(unit_system, date, frame, self._bodies, self._forces)
        alone = Context(unit_system, constant, names, core, handle, date, frame, notes=notes)
        #: Units, names and bodies, with the core's handle, for the package's own modules.
        self.context = acted_on(alone, self._forces)
        pair = handle.settings["order"]
        self._options = {**handle.settings, "order": pair and tuple(pair), "epoch": date, "frame": frame}
        for warning in body_warnings(self.context):
            caution(warning)

    bodies = Attribute[tuple[Body, ...]](
        "_bodies", "The bodies; if the system has units, their plain numbers are Quantities in them."
    )
    forces = Attribute[tuple[Force, ...]]("_forces", "The external forces.")
    names = Attribute[tuple[str, ...]]("context.names", "Names of the bodies; one without a name is called ``body i``.")
    units = Attribute[tuple[str, str, str] | None](
        "context.units.names", "Units of length, time and mass, or ``None``."
    )
    frame = Attribute[str | None]("context.frame", "The name of the inertial frame, if one was given.")
    options = Attribute[dict[str, Any]](lambda system: dict(system._options), "The method of gravity and its settings.")
    G = Attribute[Scalar](lambda system: system.context.units.attach(system.context.G, "G"), "Gravitational constant.")
    masses = Attribute[Array](lambda system: system.context.units.attach(system.context.masses, "mass"), "Masses (N,).")

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
        return None if self.context.epoch is None else epochs.to_time(self.context.epoch)

    def mu(self, body: int | str = 1, about: int | str = 0) -> Scalar:
        """Return G times the sum of the masses of two bodies, given by indices or names."""
        return self.context.units.attach_mu(self.context.mu(*self.context.pair(body, about)))

    def index(self, body: int | str) -> int:
        """Return the index of a body from its name or index; one that the system does not have is refused.

        Raises
        ------
        InvalidInput
            For a body that the system does not have.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> system.index("Beta"), system["Beta"].shape
        (1, Ellipsoid(a=0.2975, b=0.225, c=0.1715))
        """
        return self.context.index(body)

    def __getitem__(self, body: int | str) -> Body:
        return self._bodies[self.index(body)]

    def __len__(self) -> int:
        return len(self._bodies)

    def __iter__(self) -> Iterator[Body]:
        return iter(self._bodies)

    def __contains__(self, body: object) -> bool:
        return normal_form(body) in self.names if isinstance(body, str) else body in self._bodies

    def with_options(self, **options: Any) -> Self:
        """Return a system of the same bodies and G with other settings: options of the class but bodies, G and units.

        Raises
        ------
        InvalidInput
            For invalid values, and for names that are not such options.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.with_options(gravity="surface").options["gravity"]
        'surface'
        """
        refuse_unknown(options, (*self._options, "forces"), "with_options, which keeps bodies, G and units")
        options = {**self._options, "forces": self._forces, **options}
        return type(self)(self._bodies, G=self.G, units=self.units, **options)

    def with_body(
        self, body: int | str, shape: Solid | Composite, *, mass: Any = None, density: Any = None, GM: Any = None
    ) -> Self:
        """Return the system with another shape of one body.

        Everything else stays the same: the body's name, its mass unless another one is given, the other bodies,
        settings, epoch, frame and forces. The state of a body is that of its centre of mass and principal axes,
        whatever its shape.

        Parameters
        ----------
        body : int or str
            The body's index in the system, or its name.
        shape : Ellipsoid, Sphere, PointMass, Polyhedron or Composite
            The new shape. The masses of a composite's parts are scaled to the body's mass.
        mass, density, GM : float or Quantity, optional
            Another mass, or the density or GM from which it follows; give at most one of them.

        Raises
        ------
        InvalidInput
            For a body that the system does not have, and for the same reasons as :class:`fullbody.Body`.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.didymos_after_dart(sun=True)
        >>> system = system.with_body("Dimorphos", fullbody.Sphere(0.075))
        >>> system["Dimorphos"].shape, [force.name for force in system.forces]
        (Sphere(radius=0.075), ['Sun'])
        """
        index = self.index(body)
        old = self._bodies[index]
        if mass is None and density is None and GM is None:
            mass = old.mass
        if isinstance(shape, Composite):
            for name, value in (("density", density), ("GM", GM)):
                if value is not None:
                    subject = f"{name} of {self.names[index]}"
                    raise InvalidInput(f"{subject} is {value!r}; expected a mass beside a composite")
            new = Body(shape._with(self.context.units, self.context.G).with_mass(mass), name=old.name)
        else:
            new = Body(shape, mass=mass, density=density, name=old.name, GM=GM)
        bodies = (*self._bodies[:index], new, *self._bodies[index + 1 :])
        return type(self)(bodies, G=self.G, units=self.units, forces=self._forces, **self._options)

    def with_force(self, force: Force) -> Self:
        """Return the system with one more external force from :mod:`fullbody.forces`.

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
        """Return the system with these external forces in place of its own, or without any for an empty list.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> system.with_forces([tide]).forces[0].name
        'tide on Alpha'
        """
        return self.with_options(forces=forces)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, System) or self.context.describe() != other.context.describe():
            return False
        return functions(self) == functions(other)

    def __hash__(self) -> int:
        return hash(repr(self))

    def _tables(self) -> tuple[Table, ...]:
        """Return tables of the constant, the method and the settings, the bodies and the forces, if there are any."""
        context, units = self.context, self.context.units
        rows: list[Sequence[str]] = [("units", ", ".join(units.names) if units.names else "none")]
        rows.append(("G", units.text(context.G, "G", 12)))
        rows += [
            (name.replace("_", " "), f"{value}")
            for name, value in self._options.items()
            if value not in (None, "auto") and not (name == "attitude_chart" and value == "quaternion")
        ]
        forces = [
            (force.name, type(force).__name__, force._summary(described, units))
            for force, described in zip(self._forces, context.core.forces, strict=True)
        ]
        table = (Table("Forces", ("force", "kind", "what"), list(forces)),) if forces else ()
        return (Table("System", (), rows), _table_of_bodies(context, self._bodies), *table)

    def __repr__(self) -> str:
        units = "" if self.units is None else f", units={self.units}"
        forces = f", forces={[force.name for force in self._forces]}" if self._forces else ""
        gravity = f"gravity={self._options['gravity']!r}"
        return f"System({list(self.names)}, G={float(f'{self.context.G:.9g}')!r}, {gravity}{units}{forces})"

    def __reduce__(self) -> Any:
        make = partial(System, G=self.context.G, units=self.units, forces=self._forces, **self._options)
        return make, (self._bodies,)

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
          of both torques whose value is one. BYORP has ``"force of"``, along the motion.

        All are numbers in the system's own units. Other numbers of forces, such as the radius of a tide, are held
        fixed.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.systems.kw4()[0].parameters[:4]
        ('G', 'mass of Alpha', 'density of Alpha', 'semi-axis a of Alpha')
        """
        return tuple(self.context.core.parameters)


def system_of(described: dict[str, Any], replacements: dict[str, Force] | None = None) -> System:
    """Rebuild a system from its description, which may come from a file; forces that are functions are given."""
    return System(**arguments(described, replacements))


def _settings(gravity: Any, gravity_tolerance: Any, order: Any, **texts: Any) -> dict[str, Any]:
    """Return the settings of a system as the core takes them, which checks their limits; ``texts`` are text."""
    for name, value in (("gravity", gravity), *texts.items()):
        instance(value, name, str, "text")
    settings: dict[str, Any] = {"gravity": gravity, "order": None, **texts}
    if order is not None:
        pair = order if gravity != "harmonic" or integer(order) is None else (order, order)
        numbers = [integer(part) for part in pair] if isinstance(pair, tuple | list) else []
        if len(numbers) != 2 or not all(part is not None and 0 <= part < 2**31 for part in numbers):
            expected = "expected (n, m), whole numbers: n Gauss points, m angles; or one degree for gravity='harmonic'"
            raise InvalidInput(f"order is {order!r}; {expected}")
        settings["order"] = tuple(numbers)
    if gravity_tolerance is not None:
        limits = Limits(infinite=True, text="a number such as 1e-14")
        settings["gravity_tolerance"] = UNITLESS.number(gravity_tolerance, "number", "gravity_tolerance", limits)
    return settings


def _table_of_bodies(context: Context, bodies: Sequence[Body]) -> Table:
    """Return a table of the bodies of a system, one per row, in its units."""
    units = context.units
    length, mass = (units.unit(d) if units.defined else "" for d in ("length", "mass"))
    header = ("body", "shape", head("semi-axes", length), head("mass", mass))
    rows: list[Sequence[str]] = []
    for name, body, described in zip(context.names, bodies, context.core.bodies, strict=True):
        shape, mass = body.shape, described.get("mass")
        if isinstance(shape, Composite):
            size, mass = f"{len(shape.parts)} parts", sum(part["mass"] for part in described["parts"])
        elif isinstance(shape, Polyhedron):
            size = f"{len(shape.faces)} faces"
        elif isinstance(shape, StokesCoefficients):
            size = f"degree {shape.degree}"
        elif isinstance(shape, ConvexShape):
            size = f"{len(shape.normals)} facets"
        else:
            axes = (described["semi_axes"] or ())[: len(shape.__slots__)]
            size = ", ".join(f"{value:.8g}" for value in axes)
        rows.append((name, type(shape).__name__, size or "-", f"{mass:.8g}"))
    return Table("Bodies", header, rows)
