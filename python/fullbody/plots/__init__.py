"""Pictures of a run, behind :attr:`fullbody.Run.plot`, of what :mod:`fullbody.fields` computes, and of impacts.

One file a plot; matplotlib is imported when one is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..base.arguments import named_options
from ..errors import InvalidInput
from .fields import roche_lobes, surface_map, surface_scene, zero_velocity
from .particles import impacts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    from ..record.base import BaseRun
    from ._style import ArrayOfAxes
    from .summary import Page

__all__ = ["Plots", "impacts", "roche_lobes", "surface_map", "surface_scene", "zero_velocity"]


def __dir__() -> list[str]:
    return __all__


@named_options
class Plots:
    """The plots of a run: ``run.plot()`` for a page, ``run.plot.orbit()`` and so on for one picture.

    Each takes matplotlib axes to draw on, makes its own without, and returns them. Further keyword arguments go to
    matplotlib. Lengths, times and spins are in the system's units, angles in degrees.

    Parameters
    ----------
    run : Run
        A run with at least one sample.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> system.integrate(state, 10.0, output=1.0).plot
    <plots of 11 samples: angles, elements, energy, libration, orbit, scene, spins, work; call it for a summary>
    """

    __slots__ = ("_run",)

    def __init__(self, run: BaseRun) -> None:
        self._run = run

    def __eq__(self, other: object) -> bool:
        return self._run == other._run if isinstance(other, Plots) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __call__(self, figure: Any = None, *, body: int | str = 1, about: int | str = 0) -> Page:
        """One page: orbit, elements, spins, librations, conservation, and the work of forces from outside.

        Parameters
        ----------
        figure : matplotlib Figure or SubFigure, optional
        body, about : int or str
            Whose orbit about whom is shown; places in the system, or names.

        Returns
        -------
        Page
            Its ``figure``, and its ``axes`` by name. Where the motion is along a line, notes stand in the places of the
            elements and of the librations, of which it has none.
        """
        from .summary import summary

        places = {"body": self._place(body, "body"), "about": self._place(about, "about")}
        return summary(self._run, figure, **places)

    def orbit(
        self, ax: Any = None, *, about: int | str = 0, plane: str = "xy", shapes: bool = True, **kwargs: Any
    ) -> Axes:
        """Paths about one body, projected on a plane of the inertial frame, with the bodies' outlines at the end.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        about : int or str
            The body at the origin; its place in the system, or its name.
        plane : {"xy", "xz", "yz"}
        shapes : bool
            Whether to draw the outlines.
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InvalidInput
            For another plane, or a place that the system does not have.
        """
        from .orbit import orbit

        drawn: Axes = orbit(self._run, ax, about=self._place(about, "about"), plane=plane, shapes=shapes, **kwargs)
        return drawn

    def elements(
        self, ax: Any = None, *, mu: Any = None, body: int | str = 1, about: int | str = 0, **kwargs: Any
    ) -> ArrayOfAxes:
        """Osculating a, e, i, Omega, omega, M against time; angles in degrees.

        Parameters
        ----------
        ax : array of six matplotlib Axes, optional
            Under the name ``axes`` too.
        mu, body, about
            As for :meth:`fullbody.Run.elements`.
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, (3, 2), or the axes given
        """
        from .elements import elements

        places = {"body": self._place(body, "body"), "about": self._place(about, "about")}
        drawn: ArrayOfAxes = elements(self._run, kwargs.pop("axes", ax), mu=mu, **places, **kwargs)
        return drawn

    def spins(
        self, ax: Any = None, *, bodies: Sequence[int | str] | None = None, frame: str = "body", **kwargs: Any
    ) -> ArrayOfAxes:
        """Angular velocities against time, a panel a body.

        Parameters
        ----------
        ax : array of matplotlib Axes, optional
            One for each of the bodies. Under the name ``axes`` too.
        bodies : sequence of int or str, optional
            Places in the system, or names; all of them without it.
        frame : {"body", "inertial"}
            The frame of the components.
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, (number of bodies,), or the axes given
        """
        from .spins import spins

        drawn: ArrayOfAxes = spins(
            self._run, kwargs.pop("axes", ax), bodies=self._places(bodies), frame=frame, **kwargs
        )
        return drawn

    def angles(self, ax: Any = None, *, bodies: Sequence[int | str] | None = None, **kwargs: Any) -> ArrayOfAxes:
        """Tait-Bryan angles against time, in degrees: phi and theta in one panel, psi in another, a row a body.

        Parameters
        ----------
        ax : array of matplotlib Axes, optional
            Two for each of the bodies. Under the name ``axes`` too.
        bodies : sequence of int or str, optional
            Places in the system, or names; all of them without it.
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        ndarray of Axes, (number of bodies, 2), or the axes given
        """
        from .angles import angles

        drawn: ArrayOfAxes = angles(self._run, kwargs.pop("axes", ax), bodies=self._places(bodies), **kwargs)
        return drawn

    def libration(self, ax: Any = None, *, body: int | str = 1, about: int | str = 0, **kwargs: Any) -> Axes:
        """Roll, pitch and yaw of a body in its orbit's frame against time, in degrees.

        For a body that goes round under the other one, or whose samples do not show how it turns, the angle of its
        z-axis from the orbit's normal is drawn instead; see :func:`fullbody.observables.roll_pitch_yaw`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        body, about : int or str
            Places in the system, or names.
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InvalidInput
            Where there is no orbit: a body alone, or motion along a line.
        """
        from .libration import libration

        places = {"body": self._place(body, "body"), "about": self._place(about, "about")}
        drawn: Axes = libration(self._run, ax, **places, **kwargs)
        return drawn

    def energy(self, ax: Any = None, **kwargs: Any) -> Axes:
        """Drift of the energy from the start, relative to the total and to the orbit's, and of the angular momentum.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Notes
        -----
        Logarithmic; samples whose drift is exactly zero are left out. The orbit's energy is potential + translational.
        """
        from .energy import energy

        drawn: Axes = energy(self._run, ax, **kwargs)
        return drawn

    def work(self, ax: Any = None, **kwargs: Any) -> Axes:
        """What each force from outside has added to the energy since the start of the run.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        **kwargs
            To ``Axes.plot``.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InvalidInput
            For a run without forces.

        Notes
        -----
        Where the forces' work differs by more than thirty times, the axis is linear up to the smallest one's largest
        work and logarithmic beyond.
        """
        from .work import work

        drawn: Axes = work(self._run, ax, **kwargs)
        return drawn

    def scene(self, time: Any = None, ax: Any = None, *, path: bool = True, **kwargs: Any) -> Axes3D:
        """The bodies in 3D with their axes at a time.

        Parameters
        ----------
        time : float or Quantity, optional
            Within the run; the end without it. Between samples the bodies are where the continuous solution has them
            (``dense=True``); without one, on a cubic through positions and velocities, turned the shorter way.
        ax : matplotlib Axes3D, optional
        path : bool
            Whether to draw the paths of the centres.
        **kwargs
            To ``Axes3D.plot_surface``.

        Returns
        -------
        matplotlib Axes3D
            Centred on the barycentre.

        Raises
        ------
        InvalidInput
            For a time outside the run.
        """
        from .scene import scene

        drawn: Axes3D = scene(self._run, time, ax, path=path, **kwargs)
        return drawn

    def _place(self, body: Any, what: str) -> Any:
        """The place of a named body; anything else as it is."""
        return self._run.system._place(body, what) if isinstance(body, str) else body

    def _places(self, bodies: Any) -> Any:
        if isinstance(bodies, str):
            raise InvalidInput(f"bodies is {bodies!r}; expected a list of places or names")
        return None if bodies is None else [self._place(body, "one of bodies") for body in bodies]

    def __repr__(self) -> str:
        names = "angles, elements, energy, libration, orbit, scene, spins, work"
        return f"<plots of {len(self._run)} samples: {names}; call it for a summary>"
