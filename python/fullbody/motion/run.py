"""The verbs of a run: draw, film, view, turn into tables, save."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..record.base import BaseRun

if TYPE_CHECKING:
    import pandas
    import xarray

    from ..model.gravity import Gravity
    from ..particles.flight import Flight
    from ..plots import Plots
    from ..view import View

__all__ = ["RunVerbs"]


class RunVerbs(BaseRun):
    """Base of :class:`fullbody.Run`: its verbs."""

    @property
    def plot(self) -> Plots:
        """Pictures: ``run.plot()`` for a page, ``run.plot.orbit()`` and others for one; see :mod:`fullbody.plots`."""
        from ..plots import Plots

        return Plots(self)

    def gravity(self, time: Any, points: Any, body: int | str | None = None) -> Gravity:
        """Gravity of the bodies at points of the inertial frame, at times of the run; see :meth:`System.gravity`.

        Parameters
        ----------
        time : float, Quantity or array_like, (...)
            Times of samples; of a run with ``dense=True`` any time within it. Shapes of times and points are broadcast:
            times (K,) and points (K, 3) are a track, times (K, 1) and points (P, 3) have all points at all times.
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
        from ..record.gravity import gravity

        return gravity(self, time, points, body)

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
        from ..plots.animation import animate

        return animate(self, path, seconds=seconds, fps=fps, size=size, dpi=dpi)

    def view(self, *, flight: Flight | None = None, samples: int = 20000) -> View:
        """An interactive picture in 3D, for Jupyter or as one HTML file; no server, no network.

        Parameters
        ----------
        flight : Flight, optional
            Particles to be shown as dots with their trails: at most 2000 of them, taken evenly.
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
        from ..view import View

        return View(self, flight=flight, samples=samples)

    def to_xarray(self) -> xarray.Dataset:
        """The run as an ``xarray.Dataset``, with units and the set-up in its attributes.

        Returns
        -------
        xarray.Dataset
            Where events happened, they have a dimension ``event`` of their own, labelled with their kinds, and
            variables ``event_time``, ``event_position`` and so on; ``.attrs["fullbody_events"]`` lists what was asked
            for, as JSON, and ``event_asked`` counts into that list. ``start_time``, ``start_energy`` and
            ``start_angular_momentum`` are those of ``run.start``. Forces from outside have a dimension ``force``,
            labelled with their names, and variables ``work``, ``impulse`` and ``angular_impulse``;
            ``.attrs["fullbody_switched_off"]`` is ``run.switched_off`` as JSON.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 100.0, output=50.0, events=[fullbody.events.Apoapsis(0, 1)])
        >>> run.to_xarray().event_time.round(3).values.tolist()
        [48.719, 92.867]
        """
        from ..files.netcdf import to_xarray

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
        from ..files.netcdf import to_pandas

        return to_pandas(self)

    def save(self, path: Any) -> None:
        """Write a NetCDF file, exactly and atomically; read it with :func:`fullbody.load`.

        Kept are samples, the start, set-up, statistics, events and the stop reason. Not kept are the continuous
        solution of ``dense=True`` and the functions of :class:`fullbody.events.Function`, of which a file holds the
        name, with the times and states where they vanished. Nor are those of :class:`fullbody.forces.Function`: the
        system of a run from a file has the force, and fails with its name where it is integrated.

        The file ends with a checksum of the whole, behind what NetCDF reads. :func:`fullbody.load` checks it first.
        Other programs do not see it, and cut it off when they write to the file; load then warns.

        The file is on the disk before it takes the place of another. Through a symbolic link, what the link points to
        is replaced, and other hard links to that keep the old content. Permissions of a replaced file are kept; a new
        one has those that the umask leaves.

        Parameters
        ----------
        path : str or Path
            Ending in ``.nc`` or ``.nc4``.

        Raises
        ------
        InvalidInput
            For another ending.
        OSError
            Where the file cannot be written, with the path: for want of room or permission, over a write-protected
            file, a folder, a device.
        """
        from ..files.netcdf import save

        save(self, path)

    def to_spk(self, path: Any, ids: dict[str, int], barycentre: int) -> Path:
        """Write where the bodies are as an SPK kernel of SPICE, for systems with units, an epoch and a frame.

        Positions are about the barycentre of the bodies, in km and the axes of the ICRF (SPICE's J2000), at seconds of
        TDB. Segments are of type 13. Of a run with ``dense=True`` the nodes are so close that positions between them
        are right to 1e-9 km. Else the nodes are the samples.

        Parameters
        ----------
        path : str or Path
            Ending in ``.bsp``.
        ids : dict of int
            NAIF's numbers of the bodies to write, by name.
        barycentre : int
            The number of the system as a whole, to which the kernel refers the bodies.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InvalidInput
            For a system without units, epoch or frame, numbers that are none, a run without a stretch of time.
        OSError
            Where the file cannot be written.

        Warns
        -----
        PrecisionWarning
            Where positions between the nodes are off by more, with by how much.

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
        """Write how the bodies are turned as a CK kernel of SPICE, with its clock and frames.

        The system has to have what :meth:`to_spk` needs. The three files belong together. The CK turns frames along the
        bodies' principal axes, such as ``ALPHA_FIXED`` for Alpha, from the axes of the ICRF (SPICE's J2000). Segments
        are of type 5. Of a run with ``dense=True`` the nodes are so close that angles between them are right to 1e-12
        rad, and to what the body turns in the last digit of the run's time. Else the nodes are the samples. A body's
        frame has the body's number with the other sign, or a thousand times a number below zero.

        Parameters
        ----------
        path : str or Path
            Ending in ``.bc``; the clock's kernel ends in ``.tsc`` and the frames' in ``.tf``.
        ids : dict of int
            NAIF's numbers of the bodies to write, by name.

        Returns
        -------
        tuple of Path
            The three files.

        Raises
        ------
        InvalidInput
            As :meth:`to_spk`, and for names of bodies that give no names of frames.
        OSError
            Where a file cannot be written.

        Warns
        -----
        PrecisionWarning
            Where angles between the nodes are off by more, with by how much.

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
