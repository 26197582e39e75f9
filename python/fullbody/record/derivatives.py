"""Derivatives of a run with respect to its start and to parameters of its system."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..events import Occurrence
from ..typing import Array

if TYPE_CHECKING:
    from ..motion.system import System
    from .displaced import FunctionDerivatives

__all__ = ["Differentiated", "EventDerivatives", "tangent_labels"]

_KINDS = ("position", "velocity", "rotation", "spin")


def tangent_labels(names: tuple[str, ...]) -> list[str]:
    """Return the labels of the components of a tangent vector, 12 for each body."""
    return [f"{name} {kind} {axis}" for name in names for kind in _KINDS for axis in "xyz"]


@dataclass(frozen=True, slots=True, eq=False)
class EventDerivatives(ArrayFields):
    """Derivatives of the time and the state of an event with respect to the start of a run and to parameters.

    Attributes
    ----------
    time : ndarray, (12 N,)
        Derivatives of the event's time with respect to the start of the run.
    transition : ndarray, (12 N, 12 N)
        Derivatives of the state at the event with respect to the start of the run, including the change of the event's
        time.
    time_sensitivity : dict of float
        Derivatives of the event's time with respect to the parameters of the run and of the event itself.
    sensitivity : dict of ndarray, (12 N,)
        Derivatives of the state at the event with respect to the same parameters, including the change of the event's
        time.
    """

    time: npt.NDArray[np.float64]
    transition: npt.NDArray[np.float64]
    time_sensitivity: dict[str, float]
    sensitivity: dict[str, npt.NDArray[np.float64]]

    def __repr__(self) -> str:
        bodies, parameters = len(self.time) // 12, ", ".join(self.sensitivity)
        return f"EventDerivatives({bodies} bodies{', parameters ' + parameters if parameters else ''})"


class Differentiated:
    """The derivatives of a run that was integrated with ``derivatives=`` or ``chaos=True``.

    A tangent vector of a run has 12 components per body, body after body: changes of position and velocity in the
    inertial frame, a rotation vector theta in the body frame (R becomes R exp(theta), in rad), and the change of spin
    in the body frame. All are numbers in the system's own units.
    """

    system: System
    stop_reason: str
    events: list[Occurrence]
    _record: dict[str, npt.NDArray[np.float64]]
    #: Names of the parameters by which the run was differentiated.
    _parameters: tuple[str, ...] = ()

    @property
    def tangent_units(self) -> tuple[Any, ...] | None:
        """The units of the 12 N components of a tangent vector, or ``None`` for a system without units.

        The element (i, j) of a transition matrix has the unit ``tangent_units[i] / tangent_units[j]``. The element
        i of a sensitivity has the unit ``tangent_units[i]`` divided by that of the parameter, which is the system's
        own.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4(units=True)
        >>> units = system.integrate(state, "1 hour", derivatives=True).tangent_units
        >>> [str(unit) for unit in units[:12:3]]
        ['km', 'km / h', 'rad', 'rad / h']
        """
        units = self.system._units
        if not units.known:
            return None
        kinds = [units.unit(dimension) for dimension in ("length", "velocity", "angle", "spin")]
        return tuple(unit for _ in range(len(self.system)) for unit in kinds for _ in range(3))

    @property
    def is_differentiated(self) -> bool:
        """Whether the run was integrated with ``derivatives=``."""
        return "transition" in self._record

    @property
    def transition(self) -> npt.NDArray[np.float64]:
        """Transition matrices (K, 12 N, 12 N), which map a tangent vector at the start of the run to that at a sample.

        They are numbers in the system's own units (:attr:`tangent_units`), per body for position, velocity, rotation
        vector in the body frame and spin. The nominal barycentre moves with the start, and the paths of third bodies
        with it.

        Raises
        ------
        InvalidInput
            For a run that was not integrated with ``derivatives=``.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 10.0, output="ends", derivatives=True)
        >>> run.transition.shape
        (2, 24, 24)
        """
        if "transition" not in self._record:
            raise InvalidInput("this run keeps no transition matrices; integrate with derivatives=True")
        return self._record["transition"]

    @property
    def sensitivity(self) -> dict[str, npt.NDArray[np.float64]]:
        """Derivatives (K, 12 N) of the samples with respect to parameters of the system, by their names, at a fixed
        start.

        They are numbers in the system's own units: :attr:`tangent_units` divided by the unit of the parameter.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 10.0, output="ends", derivatives=["G", "mass of Alpha"])
        >>> run.sensitivity["mass of Alpha"].shape
        (2, 24)
        """
        if "transition" not in self._record:
            raise InvalidInput("this run keeps no sensitivities; integrate with derivatives=['mass of ...', ...]")
        values = self._record.get("sensitivity")
        return {} if values is None else {name: values[:, k] for k, name in enumerate(self._parameters)}

    def at_event(self, k: int = -1) -> EventDerivatives:
        """Return the derivatives of the time and the state of an event.

        At a zero of the event's function g the time changes by dt = -(grad g . dx + dg/dp dp) / (dg/dt), and the state
        by dx + f dt, with dx the tangent vector at a fixed time and f the rates of change there. The derivatives of g
        itself are differences of eighth order. A :class:`fullbody.events.Function` depends only on the state and has no
        dg/dp; for a closest approach, the third body keeps its position relative to the barycentre at the event.

        Parameters
        ----------
        k : int
            Index of the event in :attr:`events`; by default the last one.

        Returns
        -------
        EventDerivatives
            Derivatives whose dictionaries have the parameters of the run and those of the event itself, such as
            ``"value of Separation"``.

        Raises
        ------
        InvalidInput
            For a run without ``derivatives=``, for an event that the run does not have, and for one whose function is
            constant along the run.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> apsis = fullbody.events.Periapsis(0, 1)
        >>> run = system.integrate(state, 40.0, output="ends", events=[apsis], derivatives=True)
        >>> run.at_event(0).time.shape
        (24,)
        """
        if not -len(self.events) <= k < len(self.events):
            raise InvalidInput(f"k is {k!r}; expected the place of one of the {len(self.events)} events of the run")
        happened = self.events[k]
        if happened._derivatives is None:
            raise InvalidInput("the events of this run keep no derivatives; integrate with derivatives=True")
        transition, sensitivity, flow = happened._derivatives
        core = self.system._strip(happened.state)
        condition = happened.event._condition(self.system.context)
        names = list(self._parameters)
        gradient, by_time, direct, own = condition.derivatives(self.system._core, core, names)
        rate = gradient @ flow + by_time
        if rate == 0.0:
            raise InvalidInput(
                f"the function of {happened.event!r} does not change along the run; expected one that does"
            )
        time = -(gradient @ transition) / rate
        fixed = dict(zip(names, sensitivity, strict=True)) | {name: np.zeros_like(flow) for name, _ in own}
        known = dict(zip(names, direct, strict=True)) | dict(own)
        times = {name: float(-(gradient @ values + known[name]) / rate) for name, values in fixed.items()}
        return EventDerivatives(
            time,
            transition + np.outer(flow, time),
            times,
            {name: values + flow * times[name] for name, values in fixed.items()},
        )

    def derivative_of(self, function: Callable[[Any], Any], *, start: bool = True) -> FunctionDerivatives:
        """Compute the derivatives of a function of the run with respect to its start and its parameters.

        The function is evaluated on the run displaced along its own tangent vectors, twice for each of the 12 N
        components of the start and for each parameter; nothing is integrated. The function may use samples, events,
        elements, energies and angular momenta; a displaced run has no continuous solution, and no work of forces.

        Parameters
        ----------
        function : callable
            A function that takes a :class:`Run` and returns a number, a Quantity or an array. It has to be smooth, as a
            mean is; the largest of the samples is smooth as long as it stays the same sample.
        start : bool
            Whether to compute the derivatives with respect to the start.

        Returns
        -------
        FunctionDerivatives

        Raises
        ------
        InvalidInput
            For a run without ``derivatives=``, and for a function that uses what a displaced run does not have.

        Notes
        -----
        The derivatives are differences of second order over a hundred-thousandth of the natural sizes of the
        components; they are one-sided for a parameter at the end of its range, such as an eccentricity of zero. Their
        error is about 1e-9 of the scale of the derivative.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 40.0, output=1.0, derivatives=["mass of Alpha"])
        >>> found = run.derivative_of(lambda run: run.elements().e.mean())
        >>> found.start.shape, list(found.by_parameter)
        ((24,), ['mass of Alpha'])
        """
        from .displaced import derivatives_of

        if "transition" not in self._record:
            raise InvalidInput("this run keeps no derivatives; integrate with derivatives=True")
        run: Any = self
        return derivatives_of(run, function, start)

    @property
    def megno(self) -> npt.NDArray[np.float64]:
        """Mean MEGNO since the start of the run (K,): it tends to 2 for regular motion, and grows with chaotic motion.

        It needs a run with ``chaos=True``, and is zero at the start. See Cincotta & Simo (2000), Astron. Astrophys.
        Suppl. 147, 205.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 3000.0, output="ends", chaos=True)
        >>> bool(abs(run.megno[-1] - 2.0) < 0.1)
        True
        """
        return self._chaos(0)

    @property
    def lyapunov(self) -> Array:
        """Tangent growth ``ln(|delta|/|delta_0|)`` divided by the time since the start (K,), in 1/time.

        It tends to the largest Lyapunov exponent, whose inverse is the Lyapunov time, and needs a run with
        ``chaos=True``. Components of tangent vectors are measured in their natural sizes at the start: separation,
        orbital speed or the body's own, rad, and the spin.
        """
        rate: Array = self.system._units.attach(self._chaos(1), "rate")
        return rate

    @property
    def fast_lyapunov(self) -> npt.NDArray[np.float64]:
        """The fast Lyapunov indicator (K,): the largest ``ln(|delta|/|delta_0|)`` so far. It needs ``chaos=True``."""
        return self._chaos(2)

    def _chaos(self, which: int) -> npt.NDArray[np.float64]:
        if "chaos" not in self._record:
            raise InvalidInput("this run keeps no indicators of chaos; integrate with chaos=True")
        return self._record["chaos"][:, which]
