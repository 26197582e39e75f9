"""Plots of a run, for :attr:`fullbody.Run.plot`, of the results of :mod:`fullbody.fields`, and of impacts.

Matplotlib is imported when a plot is drawn.
"""

from __future__ import annotations

from ._style import RunPlots
from .curves import angles, elements, energy, libration, light_curve, spins, work
from .fields import impacts, roche_lobes, surface_map, surface_scene, zero_velocity
from .scene import orbit, scene
from .summary import summary

__all__ = ["Plots", "impacts", "roche_lobes", "surface_map", "surface_scene", "zero_velocity"]


class Plots(RunPlots):
    """The plots of a run: ``run.plot()`` draws a page, ``run.plot.orbit()`` and so on one picture.

    Each method draws on the matplotlib axes ``ax`` or makes its own, and returns them; a plot of several panels takes
    and returns an array of axes. Further keyword arguments are passed to ``Axes.plot``. Lengths, times and spins are in
    the system's units, angles in degrees.

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

    __slots__ = ()

    angles = angles
    elements = elements
    energy = energy
    libration = libration
    light_curve = light_curve
    orbit = orbit
    scene = scene
    spins = spins
    work = work
    __call__ = summary

    def __eq__(self, other: object) -> bool:
        return self.run == other.run if isinstance(other, Plots) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        names = ", ".join(name for name in vars(Plots) if not name.startswith("_"))
        return f"<plots of {len(self.run)} samples: {names}; call it for a summary>"
