"""The recorded run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._arguments import named_options
from ._recorded import Recorded
from .dense import Dense, Samples
from .elements import KeplerElements
from .errors import InvalidInput
from .integrators import Integrator
from .state import State
from .track import Track
from .typing import Array

if TYPE_CHECKING:
    from pathlib import Path

    import pandas
    import xarray

    from .events import Occurrence
    from .plots import Plots
    from .system import System
    from .view import View

__all__ = ["Run", "Statistics"]


@dataclass(frozen=True, slots=True)
class Statistics:
    """Counts of an integration.

    Attributes
    ----------
    steps, rejected, evaluations : int
        Accepted steps, rejected attempts, evaluations of the rates of change.
    """

    steps: int
    rejected: int
    evaluations: int


@named_options
class Run(Recorded):
    """What an integration recorded; K samples of N bodies.

    ``run[k]`` is a :class:`State`, ``run["Beta"]`` the :class:`Track` of one body, and ``run[::k]`` a thinned
    :class:`Run` (its statistics and events are the whole run's).
    Arrays are read-only views; Quantities where the system has units. Pickles, like files, leave out ``dense``.

    Attributes
    ----------
    system : System
    statistics : Statistics
    integrator : Integrator
    events : list of Occurrence
        What was watched for and happened, in order of the run.
    stop_reason : str
        ``"end"``, ``"event"`` (a terminal one, the last of ``events``), ``"interrupted"`` or ``"unfinished"`` (by an
        error); ``"unknown"`` in a run from a file that does not tell.
    dense : Dense or None
        The run as a function of time, where it was asked for; ``run(t)`` is ``run.dense(t)``.
    """

    def __init__(
        self,
        system: System,
        record: dict[str, npt.NDArray[np.float64]],
        statistics: Statistics,
        integrator: Integrator,
    ) -> None:
        self.system = system
        self.statistics = statistics
        self.integrator = integrator
        self.events: list[Occurrence] = []
        self.stop_reason = "end"
        self.dense: Dense | None = None
        self._record = record
        self._protect()

    def _protect(self) -> None:
        for values in self._record.values():
            values.flags.writeable = False

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "dense": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._protect()

    def __copy__(self) -> Run:
        return self[:]

    def __deepcopy__(self, memo: Any) -> Run:
        # Nothing in it changes, but for the list of events.
        run = self[:]
        run.events = list(run.events)
        return run

    def elements(self, mu: Any = None, *, body: int | str = 1, about: int | str = 0) -> KeplerElements[Array]:
        """Osculating elements of one body about another.

        Parameters
        ----------
        mu : float or Quantity, optional
            G times the sum of the two masses, unless given.
        body, about : int or str
            Places in the system, or names.

        Returns
        -------
        KeplerElements
            Of arrays (K,), in the frame of the system.

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
        """The state at any time of a run with ``dense=True``; see :class:`Dense`.

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
    def __getitem__(self, index: slice) -> Run: ...
    @overload
    def __getitem__(self, index: str) -> Track: ...
    def __getitem__(self, index: int | slice | str) -> State | Run | Track:
        if isinstance(index, str):
            return Track._of(self, self.system._place(index, "body"))
        if isinstance(index, slice):
            record = {name: np.ascontiguousarray(values[index]) for name, values in self._record.items()}
            run = Run(self.system, record, self.statistics, self.integrator)
            run.events, run.stop_reason, run.dense = self.events, self.stop_reason, self.dense
            return run
        r = self._record
        core = _core.State(
            float(r["time"][index]),
            *(np.ascontiguousarray(r[n][index]) for n in ("position", "velocity", "attitude", "spin")),
        )
        return State._wrap(core, self.system._units)

    def __iter__(self) -> Iterator[State]:
        return (self[k] for k in range(len(self)))

    @property
    def plot(self) -> Plots:
        """Pictures: ``run.plot()`` for a page, ``run.plot.orbit()`` and others for one; see :mod:`fullbody.plots`."""
        from .plots import Plots

        return Plots(self)

    def animate(
        self, path: Any, *, seconds: float = 10.0, fps: int = 20, size: Any = (6.4, 4.8), dpi: float = 100.0
    ) -> Path:
        """Write a film of the tumbling bodies.

        Parameters
        ----------
        path : str or Path
            Ending in ``.mp4`` (needs the program ffmpeg), ``.gif`` or ``.html`` (one page, works offline).
        seconds : float
            Length of the film.
        fps : int
            Pictures a second, even in time; between samples as in :meth:`fullbody.plots.Plots.scene`.
        size : (float, float)
            Width and height in inches.
        dpi : float
            Dots an inch.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InvalidInput
            For another ending, or a run without samples.
        FullbodyError
            Where ffmpeg is needed and missing.

        Warns
        -----
        UserWarning
            Where a body makes more than half a turn between two pictures, or between two samples of a run without
            ``dense=True``.
        """
        from .plots.animation import animate

        return animate(self, path, seconds=seconds, fps=fps, size=size, dpi=dpi)

    def view(self, *, samples: int = 20000) -> View:
        """An interactive picture in 3D, for Jupyter or as one HTML file; no server, no network.

        Parameters
        ----------
        samples : int
            At most so many moments of the run: its samples and others between them, or where it has more samples,
            moments even in time.

        Returns
        -------
        fullbody.view.View
            Shows itself in Jupyter; ``.save_html(path)`` writes the page.

        Warns
        -----
        UserWarning
            Where a body makes more than half a turn between two moments, or between two samples of a run without
            ``dense=True``.
        """
        from .view import View

        return View(self, samples=samples)

    def to_xarray(self) -> xarray.Dataset:
        """The run as an ``xarray.Dataset``, with units and the set-up in its attributes.

        Returns
        -------
        xarray.Dataset
            Where events happened, they have a dimension ``event`` of their own, labelled with their kinds, and
            variables ``event_time``, ``event_position`` and so on; ``.attrs["fullbody_events"]`` lists what was asked
            for, as JSON, and ``event_asked`` counts into that list.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 100.0, output=50.0, events=[fullbody.events.Apoapsis(0, 1)])
        >>> run.to_xarray().event_time.round(3).values.tolist()
        [48.719, 92.867]
        """
        from .io import to_xarray

        return to_xarray(self)

    def to_pandas(self) -> pandas.DataFrame:
        """The run as a ``pandas.DataFrame``: a row a sample, a column a number.

        Returns
        -------
        pandas.DataFrame
            Columns are (quantity, body, component), the index is the time; ``.attrs["units"]`` names the units where
            the system has them.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> frame = system.integrate(state, 10.0, output=5.0).to_pandas()
        >>> frame["position", "A", "x"].round(3).to_list()
        [-4.0, -3.607, -2.444]
        """
        from .io import to_pandas

        return to_pandas(self)

    def save(self, path: Any) -> None:
        """Write a NetCDF file, exactly and atomically; read it with :func:`fullbody.load`.

        Kept are samples, set-up, statistics, events and the stop reason. Not kept are the continuous solution of
        ``dense=True`` and the functions of :class:`fullbody.events.Function`, of which a file holds the name, with the
        times and states where they vanished.

        Parameters
        ----------
        path : str or Path
            Ending in ``.nc`` or ``.nc4``.

        Raises
        ------
        InvalidInput
            For another ending.
        """
        from .io import save

        save(self, path)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Run):
            return NotImplemented
        same = all(np.array_equal(self._record[name], other._record[name]) for name in self._record)
        how = self.stop_reason == other.stop_reason and self.events == other.events
        return same and how and self.system == other.system and self.statistics == other.statistics

    __hash__ = None  # type: ignore[assignment]

    def _repr_html_(self) -> str:
        from . import tables

        return tables.to_html(tables.of_run(self), tables.of_system(self.system), tables.of_bodies(self.system))

    def __repr__(self) -> str:
        if len(self) == 0:
            return f"Run(no samples, {self.system!r})"
        span = f"{self.time[0]} to {self.time[-1]}"
        s = self.statistics
        samples = f"{len(self)} sample{'s' if len(self) > 1 else ''}"
        return f"Run({samples} from {span}, {s.steps} steps, {s.evaluations} evaluations, {self.system!r})"
