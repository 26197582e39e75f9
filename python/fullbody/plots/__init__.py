"""Plots of a run, for :attr:`fullbody.Run.plot`, of the results of :mod:`fullbody.fields`, and of impacts.

Each plot has a file of its own; matplotlib is imported when a plot is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..errors import InvalidInput
from ..record.record import Record
from .fields import roche_lobes, surface_map, surface_scene, zero_velocity
from .particles import impacts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    from ..observing.geometry import Geometry
    from ._style import ArrayOfAxes
    from .summary import Page

__all__ = ["Plots", "impacts", "roche_lobes", "surface_map", "surface_scene", "zero_velocity"]


class Plots:
    """The plots of a run: ``run.plot()`` draws a page, ``run.plot.orbit()`` and so on one picture.

    Each method draws on the matplotlib axes it is given or makes its own, and returns them. Further keyword arguments
    are passed to matplotlib. Lengths, times and spins are in the system's units, angles in degrees.

    Parameters
    ----------
    run : Run
        A run with at least one sample.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> system.integrate(state, 10.0, output=1.0).plot
    <plots of 11 samples: angles, elements, energy, libration, light_curve, orbit, scene, spins, work; call it for a
    summary>
    """

    __slots__ = ("_run",)

    def __init__(self, run: Record) -> None:
        self._run = run

    def __eq__(self, other: object) -> bool:
        return self._run == other._run if isinstance(other, Plots) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __call__(self, figure: Any = None, *, body: int | str = 1, about: int | str = 0) -> Page:
        """Draw one page: orbit, elements, spins, librations, conservation, and the work of external forces.

        Parameters
        ----------
        figure : matplotlib Figure or SubFigure, optional
        body, about : int or str
            The body whose orbit is shown and the one it orbits; indices in the system, or names.

        Returns
        -------
        Page
            The ``figure`` and its ``axes`` by name. For motion along a line, notes replace the elements and the
            librations, which do not exist.
        """
        from .summary import summary

        places = {"body": self._place(body, "body"), "about": self._place(about, "about")}
        return summary(self._run, figure, **places)

    def orbit(
        self, ax: Any = None, *, about: int | str = 0, plane: str = "xy", shapes: bool = True, **kwargs: Any
    ) -> Axes:
        """Draw paths about one body, projected on a plane of the inertial frame, with the bodies' outlines at the end.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        about : int or str
            The body at the origin; its index in the system, or its name.
        plane : {"xy", "xz", "yz"}
        shapes : bool
            Whether to draw the bodies' outlines.
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InvalidInput
            For another plane, or a body that the system does not have.
        """
        from .orbit import orbit

        return orbit(self._run, ax, about=self._place(about, "about"), plane=plane, shapes=shapes, **kwargs)

    def elements(
        self, ax: Any = None, *, mu: Any = None, body: int | str = 1, about: int | str = 0, **kwargs: Any
    ) -> ArrayOfAxes:
        """Draw osculating a, e, i, Omega, omega, M against time, with angles in degrees.

        Parameters
        ----------
        ax : array of six matplotlib Axes, optional
            Axes to draw on; ``axes`` is another name of the argument.
        mu, body, about
            Options of :meth:`fullbody.Run.elements`.
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, (3, 2), or the axes given
        """
        from .elements import elements

        places = {"body": self._place(body, "body"), "about": self._place(about, "about")}
        return elements(self._run, kwargs.pop("axes", ax), mu=mu, **places, **kwargs)

    def spins(
        self, ax: Any = None, *, bodies: Sequence[int | str] | None = None, frame: str = "body", **kwargs: Any
    ) -> ArrayOfAxes:
        """Draw angular velocities against time, one panel per body.

        Parameters
        ----------
        ax : array of matplotlib Axes, optional
            Axes to draw on, one for each body; ``axes`` is another name of the argument.
        bodies : sequence of int or str, optional
            Indices in the system, or names; by default all bodies.
        frame : {"body", "inertial"}
            The frame of the components.
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, (number of bodies,), or the axes given
        """
        from .spins import spins

        return spins(self._run, kwargs.pop("axes", ax), bodies=self._places(bodies), frame=frame, **kwargs)

    def angles(self, ax: Any = None, *, bodies: Sequence[int | str] | None = None, **kwargs: Any) -> ArrayOfAxes:
        """Draw Tait-Bryan angles against time, in degrees: a row per body, with phi and theta in one panel, psi in
        another.

        Parameters
        ----------
        ax : array of matplotlib Axes, optional
            Axes to draw on, two for each body; ``axes`` is another name of the argument.
        bodies : sequence of int or str, optional
            Indices in the system, or names; by default all bodies.
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, (number of bodies, 2), or the axes given
        """
        from .angles import angles

        return angles(self._run, kwargs.pop("axes", ax), bodies=self._places(bodies), **kwargs)

    def libration(self, ax: Any = None, *, body: int | str = 1, about: int | str = 0, **kwargs: Any) -> Axes:
        """Draw roll, pitch and yaw of a body in its orbit's frame against time, in degrees.

        For a body that rotates relative to the line between the bodies, or whose samples are too far apart to follow
        its attitude, the angle of its z-axis from the orbit's normal is drawn instead; see
        :func:`fullbody.observables.roll_pitch_yaw`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        body, about : int or str
            Indices in the system, or names.
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InvalidInput
            If there is no orbit: a single body, or motion along a line.
        """
        from .libration import libration

        places = {"body": self._place(body, "body"), "about": self._place(about, "about")}
        return libration(self._run, ax, **places, **kwargs)

    def energy(self, ax: Any = None, **kwargs: Any) -> Axes:
        """Draw the drift of the energy, relative to the total and to the orbit's energy, and of the angular momentum.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Notes
        -----
        The axis is logarithmic; samples with a drift of exactly zero are left out. The orbit's energy is potential +
        translational.
        """
        from .energy import energy

        return energy(self._run, ax, **kwargs)

    def work(self, ax: Any = None, **kwargs: Any) -> Axes:
        """Draw the energy that each external force has added since the start of the run.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InvalidInput
            For a run without external forces.

        Notes
        -----
        If the largest work exceeds the smallest more than thirty times, the axis is linear up to the largest work of
        the smallest force and logarithmic beyond.
        """
        from .work import work

        return work(self._run, ax, **kwargs)

    def scene(
        self, time: Any = None, ax: Any = None, *, path: bool = True, geometry: Geometry | None = None, **kwargs: Any
    ) -> Axes3D:
        """Draw the bodies in 3D with their axes at a time.

        Parameters
        ----------
        time : float or Quantity, optional
            A time within the run; by default its end. Between samples the bodies are drawn from the continuous solution
            (``dense=True``); without one, from a cubic through positions and velocities and the shorter turn between
            attitudes.
        ax : matplotlib Axes3D, optional
        path : bool
            Whether to draw the paths of the centres.
        geometry : fullbody.observing.Geometry, optional
            The geometry whose Sun lights the bodies, with their shadows on each other. A polyhedron casts the shadow of
            an ellipsoid.
        **kwargs
            Passed to ``Axes3D.plot_surface``.

        Returns
        -------
        matplotlib Axes3D
            Axes centred on the barycentre.

        Raises
        ------
        InvalidInput
            For a time outside the run.
        """
        from .scene import scene

        return scene(self._run, time, ax, path=path, geometry=geometry, **kwargs)

    def light_curve(
        self,
        times: Any,
        geometry: Geometry,
        ax: Any = None,
        *,
        bodies: bool = False,
        events: bool = True,
        **kwargs: Any,
    ) -> Any:
        """Draw magnitudes against time, with mutual events marked as bars.

        Parameters
        ----------
        times : astropy Time, or array_like or Quantity, (K,)
            Times at which the light arrives.
        geometry : fullbody.observing.Geometry
        ax : matplotlib Axes, or array of them, optional
            Axes to draw on; with ``bodies`` one for all bodies together, and one for each body.
        bodies : bool
            Whether the magnitude of each body is drawn too, each in a panel of its own.
        events : bool
            Whether mutual events are marked.
        **kwargs
            ``law``, ``albedo``, ``mutual``, ``sun_radius`` and ``reduced`` are passed to
            :func:`fullbody.observing.light_curve`; others to ``Axes.plot``.

        Returns
        -------
        matplotlib Axes, or ndarray of them
            Axes with magnitudes decreasing upwards, and times in the system's unit since its epoch.
        """
        from .light_curve import light_curve

        return light_curve(self._run, times, geometry, ax, bodies=bodies, events=events, **kwargs)

    def _place(self, body: Any, what: str) -> Any:
        """Return the index of a named body, and anything else as it is."""
        return self._run.context.index(body, what) if isinstance(body, str) else body

    def _places(self, bodies: Any) -> Any:
        if isinstance(bodies, str):
            raise InvalidInput(f"bodies is {bodies!r}; expected a list of places or names")
        return None if bodies is None else [self._place(body, "one of bodies") for body in bodies]

    def __repr__(self) -> str:
        names = "angles, elements, energy, libration, light_curve, orbit, scene, spins, work"
        return f"<plots of {len(self._run)} samples: {names}; call it for a summary>"
