"""A run: the samples of an integration as arrays, and quantities that follow from them."""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.progress import Progress
from ..base.tables import Table, Tabled, number
from ..errors import FullbodyError, InvalidInput
from ..events import Occurrence
from ..files import netcdf
from ..model.gravity import Gravity
from ..model.interactions import Invariants
from ..model.state import State
from ..orbit.elements import KeplerElements
from ..particles.events import ParticleEvent
from ..particles.flight import Flight
from ..particles.given import Particles
from ..particles.rules import Bounce, Escape, Radiation
from ..particles.task import FlightTask
from ..record import conserved
from ..record.dense import Dense, Samples
from ..record.derivatives import Differentiated
from ..record.gravity import gravity
from ..record.integrators import Integrator
from ..record.statistics import STOP_REASONS, Statistics
from ..record.track import Track
from ..typing import Array
from .options import sampling

if TYPE_CHECKING:
    import pandas
    import xarray

    from ..observing.geometry import Geometry
    from ..plots import Plots
    from ..view import View
    from .system import System

__all__ = ["Run"]


class Run(Tabled, Differentiated):
    """The record of an integration: K samples of N bodies.

    ``run[k]`` is a :class:`State`, ``run["Beta"]`` the :class:`Track` of one body, and ``run[::k]`` a :class:`Run` with
    fewer samples, which keeps the start, statistics and events of the whole run. Arrays are read-only views; they are
    Quantities if the system has units. Pickles and files do not contain ``dense``.

    Attributes
    ----------
    system : System
    statistics : Statistics
    integrator : Integrator
    events : list of Occurrence
        The events that happened, in the order of the run.
    stop_reason : str
        ``"end"``, ``"event"`` (a terminal event, the last one of ``events``), ``"interrupted"`` or ``"unfinished"``
        (after an error).
    dense : Dense or None
        The run as a function of time, for ``dense=True``; ``run(t)`` is ``run.dense(t)``.
    error : FullbodyError or None
        The error that ended the run early, without its attribute ``run``, or ``None``. Files do not keep it.
    switched_off : dict of int
        How often each force that can be switched off was switched off in the run, by name:
        :class:`fullbody.forces.Byorp` is off while the secondary is not locked. A force that is off when the run begins
        counts as switched off once.
    """

    def __init__(
        self,
        system: System,
        integrator: Integrator,
        record: dict[str, npt.NDArray[np.float64]],
        start: npt.NDArray[np.float64],
        statistics: Statistics,
        *,
        events: Iterable[Occurrence] = (),
        stop_reason: str = "end",
        dense: Dense | None = None,
        switched_off: dict[str, int] | None = None,
        parameters: tuple[str, ...] = (),
    ) -> None:
        self.system = system
        self.integrator = integrator
        self.statistics = statistics
        self.events = list(events)
        self.stop_reason = stop_reason
        self.dense = dense
        self.switched_off = switched_off or {}
        self.error: FullbodyError | None = None
        self._record = record
        #: The eight numbers of the conserved quantities at the start; see :mod:`fullbody.record.conserved`.
        self._start = start
        self._parameters = parameters
        #: The drifts that have been computed so far, by name.
        self._drifts: dict[str, npt.NDArray[np.float64]] = {}
        self._protect()

    def _protect(self) -> None:
        for values in self._record.values():
            values.flags.writeable = False

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "dense": None, "_drifts": {}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._protect()

    def __copy__(self) -> Self:
        run = object.__new__(type(self))
        run.__dict__.update(self.__dict__)
        return run

    def __deepcopy__(self, memo: Any) -> Self:
        # Only the list of events can change.
        run = copy.copy(self)
        run.events = list(run.events)
        return run

    def elements(self, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> KeplerElements[Array]:
        """Return the osculating elements of one body about another.

        Parameters
        ----------
        mu : float or Quantity, optional
            The gravitational parameter; by default G times the sum of the two masses.
        body, about : int or str
            Indices in the system, or names.

        Returns
        -------
        KeplerElements
            Elements with arrays (K,), in the frame of the system.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> system.integrate(state, 10.0, output=1.0).elements().e.shape
        (11,)
        """
        units = self.system._units
        body, about = self.system._place(body, "body"), self.system._place(about, "about")
        mu = self.system.mu(body, about) if mu is None else mu
        number = units.number(mu, "mu", "mu")
        position, velocity = self._record["position"], self._record["velocity"]
        rows = _core.cartesian_to_elements(
            np.ascontiguousarray(position[:, body] - position[:, about]),
            np.ascontiguousarray(velocity[:, body] - velocity[:, about]),
            number,
        )
        a, e, *angles = (np.ascontiguousarray(column) for column in rows.T)
        return KeplerElements._trusted(
            [units.attach(a, "length"), e, *(units.attach(angle, "angle") for angle in angles)], self.system.frame
        )

    @overload
    def __call__(self, time: float | str) -> State: ...
    @overload
    def __call__(self, time: Sequence[float] | npt.NDArray[Any]) -> Samples: ...
    def __call__(self, time: Any) -> State | Samples:
        """Return the state at any time of a run with ``dense=True``; see :class:`Dense`.

        Parameters
        ----------
        time : float, Quantity or array_like, (K,)

        Returns
        -------
        State or Samples

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 10.0, output=10.0, dense=True)
        >>> run(3.7).position.shape, run([1.0, 2.0]).position.shape
        ((2, 3), (2, 2, 3))
        """
        if self.dense is None:
            raise InvalidInput("this run keeps no continuous solution; integrate with dense=True")
        found: State | Samples = self.dense(time)
        return found

    def __len__(self) -> int:
        return len(self._record["time"])

    @overload
    def __getitem__(self, index: int) -> State: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    @overload
    def __getitem__(self, index: str) -> Track: ...
    def __getitem__(self, index: int | slice | str) -> State | Self | Track:
        if isinstance(index, str):
            return self._track(self.system._place(index, "body"))
        if isinstance(index, slice):
            record = {name: np.ascontiguousarray(values[index]) for name, values in self._record.items()}
            run = copy.copy(self)
            run._record, run._drifts = record, {}
            run._protect()
            return run
        r = self._record
        core = _core.State(
            float(r["time"][index]),
            *(np.ascontiguousarray(r[n][index]) for n in ("position", "velocity", "attitude", "spin")),
        )
        return self.system._state(core)

    def _track(self, body: int) -> Track:
        arrays = (getattr(self, name)[:, body] for name in ("position", "velocity", "attitude", "spin"))
        return Track(self.system.names[body], self.time, *arrays)

    def __iter__(self) -> Iterator[State]:
        return (self[k] for k in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Run):
            return NotImplemented
        alike = self._record.keys() == other._record.keys() and self._parameters == other._parameters
        alike = alike and all(np.array_equal(values, other._record[name]) for name, values in self._record.items())
        alike = alike and np.array_equal(self._start, other._start)
        how = self.stop_reason == other.stop_reason and self.events == other.events
        how = how and self.switched_off == other.switched_off
        return alike and how and self.system == other.system and self.statistics == other.statistics

    __hash__ = None  # type: ignore[assignment]

    def _tables(self) -> tuple[Table, ...]:
        """Return a table with time span, counts, events and errors of the conserved quantities."""
        s, integrator = self.statistics, self.integrator
        rows: list[Sequence[str]] = [("samples", str(len(self)))]
        if len(self):
            rows.append(("time", f"{number(self.time[0])} to {number(self.time[-1])}"))
        start = self.start
        if not (len(self) and start.time == self.time[0]):
            rows.append(("start", number(start.time)))
        rows += [
            ("integrator", repr(integrator)),
            ("steps", f"{s.steps}, {s.rejected} rejected, {s.evaluations} evaluations"),
        ]
        kinds = Counter(type(happened.event).__name__ for happened in self.events)
        if kinds:
            rows.append(("events", ", ".join(f"{count} {kind}" for kind, count in kinds.items())))
        rows += [(f"{name} switched off", f"{times} times") for name, times in self.switched_off.items()]
        if early := STOP_REASONS[self.stop_reason]:
            rows.append(("stopped", early))
        drifts = {
            "energy_drift": "drift of the energy, relative to the total",
            "energy_drift_orbital": "drift of the energy, relative to the orbit's",
            "angular_momentum_drift": "drift of the angular momentum, relative",
        }
        # A drift that would be relative to zero is left out.
        rows += [
            (name, f"{np.abs(self._drift(of)).max():.2e}")
            for of, name in drifts.items()
            if len(self) and self._size_at_start(of)
        ]
        return (Table("Run", (), rows), *self.system._tables())

    def __repr__(self) -> str:
        if len(self) == 0:
            return f"Run(no samples, {self.system!r})"
        span = f"{self.time[0]} to {self.time[-1]}"
        s = self.statistics
        samples = f"{len(self)} sample{'s' if len(self) > 1 else ''}"
        return f"Run({samples} from {span}, {s.steps} steps, {s.evaluations} evaluations, {self.system!r})"

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
        """Positions of the centres (K, N, 3), inertial frame."""
        return self._get("position", "length")

    @property
    def velocity(self) -> Array:
        """Velocities of the centres (K, N, 3), inertial frame."""
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

        It is computed about the barycentre, whose constant own part is added, so that it loses no digits as the system
        travels.
        """
        return self._get("angular_momentum", "angular momentum")

    @property
    def work(self) -> dict[str, Array]:
        """Work (K,) of each external force since the start of the run, by its name.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
        >>> run = system.with_forces([tide]).integrate(state, 20.0)
        >>> list(run.work)
        ['tide on Alpha']
        >>> bool(abs(run.energy_drift).max() < 1e-14)
        True
        """
        return self._by_force("work", "energy")

    @property
    def impulse(self) -> dict[str, Array]:
        """Impulse (K, 3) of each external force since the start of the run, by its name."""
        return self._by_force("impulse", "momentum")

    @property
    def angular_impulse(self) -> dict[str, Array]:
        """Angular impulse (K, 3) of each external force since the start of the run, by its name."""
        return self._by_force("angular_impulse", "angular momentum")

    def _by_force(self, name: str, dimension: str) -> dict[str, Array]:
        forces = self.system.forces
        return {
            force.name: self.system._units.attach(self._record[name][:, k], dimension) for k, force in enumerate(forces)
        }

    @property
    def start(self) -> Invariants:
        """Time, energy and angular momentum at the start of the run, whether a sample was recorded there or not.

        A slice keeps the start of the whole run.
        """
        return conserved.named(self._start, self.system._units)

    @property
    def energy_drift(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start of the run (K,), relative to its value there, or absolute if that
        is zero.

        The work of external forces is subtracted, so that the drift is the error of the integration.
        """
        return self._drift("energy_drift")

    @property
    def energy_drift_orbital(self) -> npt.NDArray[np.float64]:
        """Change of the total energy since the start of the run (K,), relative to abs(potential + translational) there.

        The energy of a fast spin can be so large that the error of the orbit does not show in :attr:`energy_drift`. The
        drift is absolute if there is no orbit.
        """
        return self._drift("energy_drift_orbital")

    @property
    def angular_momentum_drift(self) -> npt.NDArray[np.float64]:
        """Length of the change of the angular momentum since the start of the run (K,), relative to its length there.

        The angular impulse of external forces is subtracted. The drift is absolute if the length at the start is zero.
        """
        return self._drift("angular_momentum_drift")

    def _size_at_start(self, name: str) -> float:
        """Return the size to which a drift is relative, which may be zero."""
        return conserved.size(name, self._start)

    def _drift(self, name: str) -> npt.NDArray[np.float64]:
        if name not in self._drifts:
            drift = conserved.drift(name, self._start, self._record)
            drift.flags.writeable = False
            self._drifts[name] = drift
        return self._drifts[name]

    @property
    def plot(self) -> Plots:
        """Plots of the run: ``run.plot()`` draws a page, ``run.plot.orbit()`` one plot; see :mod:`fullbody.plots`."""
        from ..plots import Plots

        return Plots(self)

    def gravity(self, time: Any, points: Any, body: int | str | None = None) -> Gravity:
        """Return the gravity of the bodies at points of the inertial frame and times of the run; see
        :meth:`System.gravity`.

        Parameters
        ----------
        time : float, Quantity or array_like, (...)
            Times of samples, or any times within a run with ``dense=True``. The shapes of times and points are
            broadcast: times (K,) and points (K, 3) are a track, times (K, 1) and points (P, 3) are all points at all
            times.
        points : array_like or Quantity, (..., 3)
        body : int or str, optional

        Returns
        -------
        Gravity

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 10.0, output=5.0, dense=True)
        >>> run.gravity([[1.0], [2.5]], [[0.0, 0.0, 5.0], [0.0, 3.0, 5.0], [0.0, 0.0, 9.0]]).potential.shape
        (2, 3)
        """
        return gravity(self, time, points, body)

    def animate(
        self,
        path: Any,
        *,
        seconds: float = 10.0,
        fps: int = 20,
        size: Any = (6.4, 4.8),
        dpi: float = 100.0,
        geometry: Geometry | None = None,
    ) -> Path:
        """Write an animation of the bodies to a file.

        Parameters
        ----------
        path : str or Path
            A name that ends in ``.mp4`` (which needs the program ffmpeg), ``.gif`` or ``.html`` (one page that works
            offline).
        seconds : float
            Length of the animation.
        fps : int
            Pictures per second, at equal steps of time; between samples they are drawn as in
            :meth:`fullbody.plots.Plots.scene`.
        size : (float, float)
            Width and height in inches.
        dpi : float
            Dots per inch.
        geometry : fullbody.observing.Geometry, optional
            Lights the bodies by its Sun, with their shadows on each other. A polyhedron casts the shadow of an
            ellipsoid.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InvalidInput
            For another ending, or a run without samples.
        FullbodyError
            If ffmpeg is needed but missing.

        Warns
        -----
        UserWarning
            If a body makes more than half a turn between two pictures, or between two samples of a run without
            ``dense=True``.
        """
        from ..plots.animation import animate

        return animate(self, path, seconds=seconds, fps=fps, size=size, dpi=dpi, geometry=geometry)

    def view(self, *, flight: Flight | None = None, samples: int = 20000, geometry: Geometry | None = None) -> View:
        """Return an interactive picture in 3D for Jupyter or as one HTML file, without server or network.

        Parameters
        ----------
        flight : Flight, optional
            A flight whose particles are shown as dots with their trails; at most 2000 of them, evenly selected, are
            shown. Trails follow the path between samples of the flight, end where a particle lies on a body, and can be
            switched off.
        samples : int
            The largest number of times of the run that are shown: its samples and times between them, or times at equal
            steps if it has more samples.
        geometry : fullbody.observing.Geometry, optional
            Lights the bodies by its Sun, with their shadows on each other. A polyhedron casts the shadow of an
            ellipsoid.

        Returns
        -------
        fullbody.view.View
            The picture, which Jupyter shows; ``.save_html(path)`` writes the page. At speed 1 the whole run takes 30
            seconds.

        Warns
        -----
        UserWarning
            If a body makes more than half a turn between two of these times, or between two samples of a run without
            ``dense=True``.
        """
        from ..view import View

        return View(self, flight=flight, samples=samples, geometry=geometry)

    def to_xarray(self) -> xarray.Dataset:
        """Convert the run to an ``xarray.Dataset``, with units, the system and the integrator in its attributes.

        Returns
        -------
        xarray.Dataset
            A dataset with the samples along the dimension ``time``. Events that happened have the dimension ``event``,
            labelled with their kinds, and variables ``event_time``, ``event_position`` and so on;
            ``.attrs["fullbody_events"]`` lists the requested events as JSON, and ``event_index`` is the index in that
            list. ``start_time``, ``start_energy`` and ``start_angular_momentum`` are those of ``run.start``. External
            forces have the dimension ``force``, labelled with their names, and variables ``work``, ``impulse`` and
            ``angular_impulse``; ``.attrs["fullbody_switched_off"]`` is ``run.switched_off`` as JSON.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 100.0, output=50.0, events=[fullbody.events.Apoapsis(0, 1)])
        >>> run.to_xarray().event_time.round(3).values.tolist()
        [48.719, 92.867]
        """
        return netcdf.to_xarray(self)

    def to_pandas(self) -> pandas.DataFrame:
        """Convert the run to a ``pandas.DataFrame`` with a row per sample and a column per number.

        Returns
        -------
        pandas.DataFrame
            A table whose columns are (quantity, body, component) and whose index is the time; ``.attrs["units"]`` names
            the units if the system has them.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> frame = system.integrate(state, 10.0, output=5.0).to_pandas()
        >>> frame["position", "A", "x"].round(3).to_list()
        [-4.0, -3.607, -2.444]
        """
        return netcdf.to_pandas(self)

    def save(self, path: Any) -> None:
        """Write the run to a NetCDF file, exactly and atomically; :func:`fullbody.load` reads it.

        A file keeps the samples, the start, the system, the integrator, the statistics, the events and the stop reason.
        It keeps neither the continuous solution of ``dense=True`` nor the functions of
        :class:`fullbody.events.Function`, of which it keeps the names with the times and states of the events. It does
        not keep the functions of :class:`fullbody.forces.Function` either: the system of a run from a file has the
        force, but its integration raises an error that names the force.

        The file ends with a checksum of its content, after the part that NetCDF reads. :func:`fullbody.load` checks it
        first. Other programs ignore the checksum and remove it when they write to the file; :func:`fullbody.load` then
        warns.

        The file is on the disk before it replaces another one. If the path is a symbolic link, the file that it points
        to is replaced, and other hard links to that file keep the old content. The permissions of a replaced file are
        kept; a new file has the permissions that the umask leaves.

        Parameters
        ----------
        path : str or Path
            A name that ends in ``.nc`` or ``.nc4``.

        Raises
        ------
        InvalidInput
            For another ending.
        OSError
            If the file cannot be written, for lack of space or permission, or because the path is a write-protected
            file, a folder or a device; the error has the path.
        """
        netcdf.save(self, path)

    def to_spk(self, path: Any, ids: dict[str, int], barycentre: int) -> Path:
        """Write the positions of the bodies as an SPK kernel of SPICE, for systems with units, an epoch and a frame.

        Positions are relative to the barycentre of the bodies, in km along the axes of the ICRF (SPICE's J2000), and
        times are seconds of TDB. SPICE's ECLIPJ2000 is the frame ``"eclipj2000"`` here; ``"ecliptic"`` differs from it
        by 0.04 arc seconds (:mod:`fullbody.frames`). Segments are of type 13. For a run with ``dense=True`` the nodes
        are so close that interpolated positions are accurate to 1e-9 km. Otherwise the nodes are the samples.

        Parameters
        ----------
        path : str or Path
            A name that ends in ``.bsp``.
        ids : dict of int
            NAIF's numbers of the bodies to write, by name.
        barycentre : int
            NAIF's number of the system as a whole, relative to which the kernel gives the bodies.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InvalidInput
            If the system has no units, epoch or frame, if a number is not valid, and if the run covers no span of time.
        OSError
            If the file cannot be written.

        Warns
        -----
        PrecisionWarning
            If the error of interpolated positions is larger; the message gives it.

        See Also
        --------
        fullbody.spice.state

        Examples
        --------
        >>> import fullbody, spiceypy, tempfile
        >>> system, state = fullbody.systems.didymos(units=True)
        >>> system = system.with_options(epoch="2022-09-26T12:00:00 TDB")
        >>> run = system.integrate(state, 12.0, dense=True)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     ids = {"Didymos": 920065803, "Dimorphos": 120065803}
        ...     path = str(run.to_spk(f"{folder}/didymos.bsp", ids, barycentre=20065803))
        ...     spiceypy.furnsh(path)
        ...     after_an_hour = 8304 * 86400.0 + 3600.0
        ...     found, light_time = spiceypy.spkgeo(120065803, after_an_hour, "ECLIPJ2000", 920065803)
        ...     spiceypy.unload(path)
        >>> float(abs(found[:3] - (run(1.0).position[1] - run(1.0).position[0]).value).max()) < 1e-6
        True
        """
        from ..spice import spk

        return spk.write(self, path, ids, barycentre)

    def to_ck(self, path: Any, ids: dict[str, int]) -> tuple[Path, Path, Path]:
        """Write the attitudes of the bodies as a CK kernel of SPICE, with its clock and frames.

        The requirements for the system are those of :meth:`to_spk`. The three files belong together. The CK gives
        frames along the bodies' principal axes, such as ``ALPHA_FIXED`` for Alpha, relative to the axes of the ICRF
        (SPICE's J2000). Segments are of type 5. For a run with ``dense=True`` the nodes are so close that interpolated
        angles are accurate to 1e-12 rad, or to the angle by which the body turns in the last digit of the run's time.
        Otherwise the nodes are the samples. A body's frame has the body's number with the opposite sign, or a thousand
        times a negative number.

        Parameters
        ----------
        path : str or Path
            A name that ends in ``.bc``; the name of the clock's kernel ends in ``.tsc`` and that of the frames' in
            ``.tf``.
        ids : dict of int
            NAIF's numbers of the bodies to write, by name.

        Returns
        -------
        tuple of Path
            The paths of the three files.

        Raises
        ------
        InvalidInput
            For the same reasons as :meth:`to_spk`, and for names of bodies from which no valid names of frames follow.
        OSError
            If a file cannot be written.

        Warns
        -----
        PrecisionWarning
            If the error of interpolated angles is larger; the message gives it.

        Examples
        --------
        >>> import fullbody, spiceypy, tempfile
        >>> system, state = fullbody.systems.didymos(units=True, frame="equatorial")
        >>> system = system.with_options(epoch="2022-09-26T12:00:00 TDB")
        >>> run = system.integrate(state, 12.0, dense=True)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     paths = [str(path) for path in run.to_ck(f"{folder}/didymos.bc", {"Dimorphos": 120065803})]
        ...     spiceypy.furnsh(paths)
        ...     matrix = spiceypy.pxform("DIMORPHOS_FIXED", "J2000", 8304 * 86400.0 + 3600.0)
        ...     spiceypy.unload(paths)
        >>> float(abs(matrix - run(1.0).rotation_matrix[1]).max()) < 1e-12
        True
        """
        from ..spice import ck

        return ck.write(self, path, ids)

    def fly(
        self,
        particles: Particles,
        until: Any = None,
        output: Any = None,
        *,
        start: Any = None,
        integrator: Integrator | None = None,
        contact: str | Bounce = "stop",
        escape: Escape | None = None,
        radiation: Radiation | None = None,
        events: Iterable[ParticleEvent] = (),
        threads: int | None = None,
        progress: Any = False,
    ) -> Flight:
        """Fly massless particles along a run with ``dense=True``.

        The particles are attracted by all bodies and by third bodies (relative to the system's nominal barycentre,
        which falls freely with the coordinates), and accelerated by radiation. Tides, YORP, BYORP and
        :class:`fullbody.forces.Function` act on bodies only; a warning says so for the latter.

        Parameters
        ----------
        particles : Particles
        until : float, Quantity or text with a unit, optional
            End of the flight, within the run; by default the end of the run. It is before the start for a flight
            backwards.
        output : None, "ends", float, Quantity or array_like
            The times that are recorded. With ``None`` only fates and last positions are recorded; ``"ends"`` means the
            start and the end, a number the spacing of times from the start to the end, and an array exactly these
            times.
        start : float, Quantity or text with a unit, optional
            Time of the particles, within the run; by default their own, or the start of the run if they have none.
        integrator : Integrator, optional
            Integrator of the particles, with step control; by default ``Verner98(rtol=1e-12, atol=1e-12)``. The error
            of a step is held below ``rtol`` times the distance from the nearest centre plus ``atol`` times that
            distance at the start; the error of the velocity likewise, relative to sqrt(v^2 + Phi) with the potential of
            the bodies' masses. The accuracy of the bodies' positions is the run's tolerance, so that a smaller one here
            gains nothing.
        contact : {"stop", "remove"} or Bounce
            The contact response: the flight ends and the particle stays at the surface (``"stop"``) or is removed, or
            the particle bounces.
        escape : Escape, optional
            The condition at which a particle has escaped, which ends its flight.
        radiation : Radiation, optional
            Radiation pressure of a third body.
        events : iterable of ParticleEvent
            Events to detect, from :mod:`fullbody.particles`.
        threads : int, optional
            Number of threads; by default as many as the machine runs at once. Results do not depend on it.
        progress : bool, str or callable
            Progress bar or function, as in :meth:`fullbody.System.integrate`.

        Returns
        -------
        Flight

        Raises
        ------
        InvalidInput
            If particles are inside a body or have another time than the start; if times are outside of the run; and if
            the run has no continuous solution.
        Interrupted
            On Ctrl-C, with the flight so far in the attribute ``flight``.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 24.0, dense=True)
        >>> flight = run.fly(fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]]), output="ends")
        >>> flight.position.shape
        (2, 1, 3)
        """
        options: dict[str, Any] = {"integrator": integrator, "contact": contact, "escape": escape}
        options |= {"radiation": radiation, "events": events, "threads": threads}
        task, samples = FlightTask(self.system, particles, **options), sampling(output, self.system._units)
        if self.dense is None:
            raise InvalidInput("this run keeps no continuous solution; integrate with dense=True")
        last = self.dense.range[1]
        with Progress(progress) as report:
            return task.fly(self.dense, start, last if until is None else until, samples, report)
