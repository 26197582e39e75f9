"""A run: the record of the integration of a system."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import epochs
from ..base.attributes import Deferred
from ..base.tables import Table, number, tables_of
from ..base.unit_names import unit_named
from ..errors import InvalidInput
from ..files.netcdf import save, to_pandas, to_xarray
from ..model.context import S
from ..model.gravity import Gravity, gravity_at, points_in
from ..particles.task import fly
from ..record import conserved
from ..record.derivatives import at_event, derivative_of
from ..record.record import STOP_REASONS, Record

if TYPE_CHECKING:
    from ..plots import Plots
    from ..plots.animation import animate
    from ..spice.kernels import to_ck, to_spk
    from ..view import view
else:
    animate, view = Deferred(".plots.animation", "animate"), Deferred(".view", "view")
    to_spk, to_ck = Deferred(".spice.kernels", "to_spk"), Deferred(".spice.kernels", "to_ck")


#: The drifts of conserved quantities, with their descriptions.
_DRIFTS = {
    "energy_drift": "drift of the energy, relative to the total",
    "energy_drift_orbital": "drift of the energy, relative to the orbit's",
    "angular_momentum_drift": "drift of the angular momentum, relative",
}


class Run(Record[S]):
    """The record of an integration: K samples of N bodies.

    ``run[k]`` is a :class:`State`, ``run["Beta"]`` the :class:`fullbody.record.Track` of one body. ``run[::k]``,
    ``run[[0, 5, 9]]`` and ``run[mask]`` are runs with some of the samples, which keep the start, statistics and events
    of the whole run. Arrays are read-only views; they are Quantities if the system has units. Pickles and files do not
    contain ``dense``.

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
    parameters : tuple of str
        The names of the parameters by which the run was differentiated.
    arrays : dict of ndarray
        Times, positions and so on as numbers in the system's units, with a row per sample.
    """

    at_event = at_event
    derivative_of = derivative_of
    fly = fly
    to_xarray = to_xarray
    to_pandas = to_pandas
    save = save
    to_spk = to_spk
    to_ck = to_ck
    animate = animate
    view = view

    @property
    def plot(self) -> Plots:
        """Plots of the run: ``run.plot()`` draws a page, ``run.plot.orbit()`` one plot; see :mod:`fullbody.plots`."""
        from ..plots import Plots

        return Plots(self)

    @property
    def dates(self) -> Any:
        """Dates (K,) of the samples as an ``astropy.time.Time``; for systems with an epoch and units."""
        if self.context.epoch is None:
            raise InvalidInput("this system has no epoch; give fullbody.System(..., epoch='2022-09-26 TDB')")
        seconds = self.context.units.unit("time").to("s")
        return epochs.to_time(self.context.epoch) + self.arrays["time"] * seconds * unit_named("s")

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

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 10.0, output=5.0, dense=True)
        >>> run.gravity([[1.0], [2.5]], [[0.0, 0.0, 5.0], [0.0, 3.0, 5.0], [0.0, 0.0, 9.0]]).potential.shape
        (2, 3)
        """
        context = self.context
        times, array = context.units.strip(time, "time", "time"), points_in(points, context.units)
        try:
            shape = np.broadcast_shapes(times.shape, array.shape[:-1])
        except ValueError as error:
            shapes = f"times of shape {times.shape} and points of shape {array.shape}"
            raise InvalidInput(f"{shapes} do not match; expected shapes that numpy broadcasts") from error
        distinct, index = np.unique(times, return_inverse=True)
        states = self.states(distinct)
        poses, index = (states["position"], states["attitude"]), np.broadcast_to(index.reshape(times.shape), shape)
        only = None if body is None else context.index(body)
        return gravity_at(context.attraction, *poses, np.broadcast_to(array, (*shape, 3)), context.units, only, index)

    def _tables(self) -> tuple[Table, ...]:
        """Return a table with time span, counts, events and errors of the conserved quantities."""
        s = self.statistics
        rows: list[Sequence[str]] = [("samples", str(len(self)))]
        if len(self):
            rows.append(("time", f"{number(self.time[0])} to {number(self.time[-1])}"))
        if not (len(self) and self.start.time == self.time[0]):
            rows.append(("start", number(self.start.time)))
        rows.append(("integrator", repr(self.integrator)))
        rows.append(("steps", f"{s.steps}, {s.rejected} rejected, {s.evaluations} evaluations"))
        if kinds := Counter(type(happened.event).__name__ for happened in self.events):
            rows.append(("events", ", ".join(f"{count} {kind}" for kind, count in kinds.items())))
        rows += [(f"{name} switched off", f"{times} times") for name, times in self.switched_off.items()]
        if early := STOP_REASONS[self.stop_reason]:
            rows.append(("stopped", early))
        # A drift that would be relative to zero is left out.
        rows += [
            (name, f"{np.abs(getattr(self, drift)).max():.2e}")
            for drift, name in _DRIFTS.items()
            if len(self) and conserved.size(drift, self.invariants)
        ]
        return (Table("Run", (), rows), *tables_of(self.system))

    def __repr__(self) -> str:
        if len(self) == 0:
            return f"Run(no samples, {self.system!r})"
        span = f"{self.time[0]} to {self.time[-1]}"
        s = self.statistics
        samples = f"{len(self)} sample{'s' if len(self) > 1 else ''}"
        return f"Run({samples} from {span}, {s.steps} steps, {s.evaluations} evaluations, {self.system!r})"
