"""Predictions of observations from a run, their linear unknowns, and the derivatives of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base import rotations
from ..base.differences import difference
from ..base.limits import Limits
from ..base.units import UNITLESS, strip_to
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record
from ..typing import Floats
from .linear import Held, LinearModel, LinearUnknown
from .states import IMAGINARY_STEP, RetardedStates, retarded
from .times import to_system_times
from .vectors import Vectors, local_geometry

#: The step of a difference, relative to the natural size of a parameter.
_RELATIVE_STEP = 1e-5


class Errors(NamedTuple):
    """The covariances (B, S, S) of the errors of B blocks of S numbers, with and without a jitter.

    The numbers of K rows of C numbers stand in their order; where rows are independent, each is a block.
    """

    covariance: Floats
    without_jitter: Floats


class DesignArgument(NamedTuple):
    """A quantity of K rows of C numbers, such as a rotation angle, through which the design depends on the motion."""

    #: The derivatives (K, C, L) of the design with respect to the quantity.
    slope: Floats
    #: The derivatives (K, C, 12 N) of the quantity with respect to the states.
    by_state: Floats
    #: The derivatives (K, C) of the quantity with respect to parameters of the system at constant states, by name.
    direct: dict[str, Floats]


class Predictions:
    """Base class of observations of K rows of C numbers, which predicts them from a run and compares the two."""

    #: Whether predictions depend on the shapes and attitudes of bodies.
    _depends_on_figures = False

    def __init__(self, times: Any, geometry: Vectors) -> None:
        self.times, self.geometry = times, geometry
        self._clocks: dict[Any, Floats] = {}
        #: These observations before a jitter was added.
        self._original: Predictions | None = None

    def emission(self, system: SystemLike) -> Any:
        """Return the times on a system's clock at which the observed light left its barycentre; runs need states there.

        Parameters
        ----------
        system : System

        Returns
        -------
        ndarray or Quantity, (K,)
            Times since the epoch, in the system's unit of time.
        """
        return system.context.units.attach(self._emission(system), "time")

    def _emission(self, system: SystemLike) -> Floats:
        return local_geometry(self.geometry, system).emission(self._clock(system))

    def _clock(self, system: SystemLike) -> Floats:
        """Return the times of the observations on a system's clock, converted once for each epoch and unit."""
        key = system.context.epoch, system.context.units.names
        if key not in self._clocks:
            self._clocks[key] = to_system_times(self.times, system, f"times of {type(self).__name__}")
        return self._clocks[key]

    def _retarded(
        self, system: SystemLike, states: dict[str, Floats], masses: Any = None, delay: float = 0.0
    ) -> RetardedStates:
        """Return the states of the bodies when the observed light left them; other masses move the barycentre.

        Light that arrives a time ``delay`` later left bodies that have moved and rotated uniformly.
        """
        masses = system.context.masses if masses is None else masses
        times = self._clock(system) + delay
        return RetardedStates(local_geometry(self.geometry, system), times, masses, states, -delay)

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        """Return predictions (..., K, C) in plain numbers from the states at the times of emission.

        Positions and velocities may have further leading axes, (..., K, N, 3).
        """
        raise NotImplementedError

    def _observed(self, system: SystemLike) -> Floats:
        """Return the observed values (K, C), in the numbers of the predictions."""
        raise NotImplementedError

    def _covariance(self, system: SystemLike) -> Floats:
        """Return the covariances (B, S, S) of blocks of S numbers in their order, as those of the rows, (K, C, C)."""
        raise NotImplementedError

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        """Return predictions or residuals with the units of the observations."""
        raise NotImplementedError

    def _partials(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str] = ()
    ) -> tuple[Floats, dict[str, Floats]]:
        """Return derivatives of the predictions with respect to the states, and to parameters of the system at given
        states.

        The former are (K, C, 12 N), in the components of tangent vectors. The predictions are analytic functions of the
        states: a step along the imaginary axis gives their derivatives to the last digits. The latter are (K, C) by
        the names of the parameters.
        """
        count, kinds = len(system.context), ("position", "velocity")
        by_state = np.zeros((*self._observed(system).shape, 12 * count))
        for body in range(count):
            # All six components of a body take one call, which costs hardly more than one component.
            shifted: dict[str, Any] = states | {name: np.tile(states[name] + 0j, (6, 1, 1, 1)) for name in kinds}
            for kind, name in enumerate(kinds):
                for axis in range(3):
                    shifted[name][3 * kind + axis, :, body, axis] += 1j * IMAGINARY_STEP
            by = self._model(system, shifted).imag / IMAGINARY_STEP
            by_state[..., 12 * body : 12 * body + 6] = np.moveaxis(by, 0, -1)
            for axis in range(3 if self._depends_on_figures else 0):
                direction = np.eye(3)[axis]
                changes: dict[str, Any] = {
                    "attitude": rotations.rates(states["attitude"][:, body], direction),
                    "spin": direction,
                }
                for kind, (name, change) in enumerate(changes.items(), len(kinds)):
                    changed = states[name].astype(np.complex128)
                    changed[:, body] += 1j * IMAGINARY_STEP * change
                    changed_states: dict[str, Any] = {**states, name: changed}
                    by = self._model(system, changed_states).imag / IMAGINARY_STEP
                    by_state[..., 12 * body + 3 * kind + axis] = by
        return by_state, {name: self._partial(system, states, name) for name in parameters}

    def _partial(self, system: SystemLike, states: dict[str, Floats], parameter: str) -> Floats:
        """Return derivatives (K, C) of the predictions with respect to a parameter of the system at given states.

        A mass acts through the barycentre, along the imaginary axis; any other change of the bodies is differenced.
        """
        kind, _, body = parameter.partition(" of ")
        if kind == "mass" and body in system.context.names:
            masses = system.context.masses.astype(np.complex128)
            masses[system.context.names.index(body)] += 1j * IMAGINARY_STEP
            return np.asarray(self._model(system, states, masses).imag / IMAGINARY_STEP)
        changes_figure = kind.startswith("semi-axis") or parameter in system.context.deformations
        if changes_figure and not self._depends_on_figures:
            return np.zeros(self._observed(system).shape)
        step = _RELATIVE_STEP * system.context.natural_size(parameter)
        prediction = self._model(system, states)

        def change(by: float) -> Floats:
            changed = system.changed(parameter, by)
            is_same = changed.context.core.bodies == system.context.core.bodies
            return np.asarray(0.0 * prediction if is_same else self._of_changed(system, changed, states) - prediction)

        return difference(change, step)

    def _of_changed(self, system: SystemLike, changed: SystemLike, states: dict[str, Floats]) -> Any:
        """Return the predictions (K, C) of a system whose bodies are slightly changed, for derivatives."""
        return self._model(changed, states)

    def _states(self, run: Record) -> dict[str, Any]:
        """Return the states of a run from which predictions follow."""
        local = local_geometry(self.geometry, run.system)
        return retarded(run, local, self._clock(run.system), f"time of {type(self).__name__}")[0]

    def _linear_unknowns(self, system: SystemLike) -> tuple[LinearUnknown, ...]:
        """Return the L unknowns on which the predictions depend linearly; none unless a class has some."""
        return ()

    def _design(self, system: SystemLike, states: dict[str, Floats]) -> Floats:
        """Return the derivatives (K, C, L) of the predictions with respect to the linear unknowns."""
        return np.zeros((*self._observed(system).shape, len(self._linear_unknowns(system))))

    def _design_arguments(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str]
    ) -> list[DesignArgument]:
        """Return the quantities through which the design depends on the motion; none unless a class has some."""
        return []

    def _parts(self, run: Record) -> tuple[Floats, Floats, Floats]:
        """Return predictions with all linear unknowns zero, (K, C), observed minus predicted values, and the design."""
        states = self._states(run)
        prediction = self._model(run.system, states)
        return prediction, self._observed(run.system) - prediction, self._design(run.system, states)

    def linear(self, run: Record) -> LinearModel:
        """Return the pulls of a run as a function of the linear unknowns.

        Parameters
        ----------
        run : Run
            A run as for :meth:`predict`.

        Returns
        -------
        LinearModel
        """
        _, residuals, design = self._parts(run)
        return self._linear_model(run.system, residuals, design)

    def _linear_model(self, system: SystemLike, residuals: Floats, design: Floats) -> LinearModel:
        """Return the pulls that belong to residuals (K, C) and a design (K, C, L)."""
        white = self._whiten(np.concatenate([residuals[..., None], design], axis=-1), system)
        return LinearModel(self._linear_unknowns(system), white[..., 0], white[..., 1:])

    def _solved(self, run: Record, linear: Any) -> tuple[Floats, Floats, dict[str, Any]]:
        """Return predictions and residuals (K, C), and the linear unknowns, solved for if ``linear`` is None."""
        prediction, residuals, design = self._parts(run)
        unknowns = self._linear_unknowns(run.system)
        if linear is None:
            values, _ = self._linear_model(run.system, residuals, design).solved()
        else:
            values = np.array([self._number_in(linear, unknown) for unknown in unknowns])
        change = design @ values
        named = zip(unknowns, values.tolist(), strict=True)
        return (
            prediction + change,
            residuals - change,
            {unknown.name: value if unknown.unit is None else value * unknown.unit for unknown, value in named},
        )

    def _number_in(self, linear: Any, unknown: LinearUnknown) -> float:
        """Return the value that a dict has of a linear unknown, in plain numbers."""
        if not isinstance(linear, Mapping) or unknown.name not in linear:
            raise InvalidInput(f"linear has no {unknown.name!r}; expected a dict with it, or None to solve for it")
        value, what = linear[unknown.name], f"{unknown.name} of linear"
        number = value if unknown.unit is None else strip_to(value, unknown.unit, what)
        return UNITLESS.number(number, "number", what, Limits())

    def linear_values(self, run: Record) -> dict[str, Any]:
        """Return the linear unknowns at which chi2 of a run is least, by their names; empty where there are none.

        Parameters
        ----------
        run : Run
            A run as for :meth:`predict`.

        Returns
        -------
        dict of str to float or Quantity

        Raises
        ------
        InvalidInput
            If the data leave a combination of them undetermined.
        """
        return self._solved(run, None)[2]

    def predict(self, run: Record, linear: Mapping[str, Any] | None = None) -> Any:
        """Compute the predictions of a run at the times of the observations.

        Parameters
        ----------
        run : Run
            A run with ``dense=True``, or with samples at the times :meth:`emission` of its system.
        linear : dict, optional
            The linear unknowns, such as zero points, as :meth:`linear_values` returns them; by default those at which
            chi2 of these observations is least.

        Returns
        -------
        ndarray, Quantity or a pair of them
            In the units of the observations: :class:`Astrometry` gives (K, 2), east and north,
            :class:`RadarAstrometry` a :class:`RangeAndRate`, and :class:`Photometry` magnitudes (K,).

        Raises
        ------
        InvalidInput
            If the run, or the geometry, does not cover the times.
        """
        return self._attach(self._solved(run, linear)[0], run.system)

    def residuals(self, run: Record, linear: Mapping[str, Any] | None = None) -> Any:
        """Return the observations minus the predictions, in the form of :meth:`predict`."""
        return self._attach(self._solved(run, linear)[1], run.system)

    def pulls(self, run: Record) -> Floats:
        """Return the residuals (K, C) made independent of each other and divided by their standard errors.

        They are L^-1 times the residuals, where L is the Cholesky factor of the covariance of a row, or of all rows
        whose errors are correlated. The first pull is the first residual divided by its standard error, and the sum of
        all squares is chi2.
        """
        return self.linear(run).solved()[1]

    def _whiten(self, values: Floats, system: SystemLike, transposed: bool = False) -> Floats:
        """Return values (K, C, ...) multiplied by the inverse of the Cholesky factors of the covariances."""
        factor = np.linalg.cholesky(self._covariance(system))
        factor = np.swapaxes(factor, 1, 2) if transposed else factor
        flat = values.reshape(*factor.shape[:2], -1)
        return np.asarray(np.linalg.solve(factor, flat).reshape(values.shape))

    def chi2(self, run: Record) -> float:
        """Return the sum of the squares of the :meth:`pulls`."""
        return float(np.sum(self.pulls(run) ** 2))

    def derivatives(self, run: Record) -> FunctionDerivatives:
        """Compute the derivatives of the :meth:`pulls` by the start of a run and by its parameters.

        Parameters
        ----------
        run : Run
            A run that was integrated with ``derivatives=`` and has samples at the times :meth:`emission`.

        Returns
        -------
        FunctionDerivatives
            Derivatives (K, C, 12 N) with respect to the start and (K, C) by each parameter, as
            ``run.derivative_of(data.pulls)`` gives them, but from the partial derivatives of the predictions instead of
            differences.
        """
        model = self.linear(run)
        projection, size = model.projection(), model.pulls.size
        held = Held(*model.solved(), np.zeros_like(model.design))
        by = self.linear_derivatives(run, held)

        def projected(columns: Floats) -> Floats:
            derivative = projection.derivative(columns[:size], columns[size:-1])
            return derivative.reshape(*model.pulls.shape, *columns.shape[1:])

        by_parameter = {name: projected(column[:, None])[..., 0] for name, column in by.by_parameter.items()}
        return FunctionDerivatives(held.rows, projected(by.start), by_parameter)

    def linear_derivatives(self, run: Record, held: Held) -> FunctionDerivatives:
        """Compute the derivatives of what :meth:`LinearModel.contracted` returns, as :meth:`derivatives` does."""
        system = run.system
        index = run.indices(self._emission(system), f"time of {type(self).__name__}")
        states = {name: run.arrays[name][index] for name in ("position", "velocity", "attitude", "spin")}
        names = list(run.sensitivity)
        tangents = [run.transition[index], *(values[index][..., None] for values in run.sensitivity.values())]
        tangent = np.concatenate(tangents, axis=-1)
        start = tangent.shape[-1] - len(names)

        def chained(by_state: Floats, direct: Mapping[str, Floats]) -> Floats:
            """Return derivatives (K, C, 12 N + P) with respect to the start and the P parameters."""
            derivative = np.asarray(by_state @ tangent)
            for k, name in enumerate(names, start):
                derivative[..., k] += direct[name]
            return derivative

        change = chained(*self._partials(system, states, run.parameters))
        size, count = held.rows.size, len(held.values)
        contracted = np.zeros((size + count + 1, tangent.shape[-1]))
        arguments = self._design_arguments(system, states, run.parameters)
        if arguments:
            weights = np.concatenate([held.rows[..., None], held.design], axis=-1)
            weights = self._whiten(weights, system, transposed=True)
        for argument in arguments:
            by = chained(argument.by_state, argument.direct)
            change += (argument.slope @ held.values)[..., None] * by
            flat = by.reshape(size, -1)
            contracted[size:-1] += (weights[..., :1] * argument.slope).reshape(size, count).T @ flat
            contracted[-1] += np.sum(weights[..., 1:] * argument.slope, axis=-1).ravel() @ flat
        contracted[:size] = -self._whiten(change, system).reshape(size, -1)
        by_parameter = {name: contracted[:, k] for k, name in enumerate(names, start)}
        return FunctionDerivatives(np.zeros(len(contracted)), contracted[:, :start], by_parameter)

    def errors(self, system: SystemLike) -> Errors:
        """Return the errors of the rows, with and without a jitter, in the system's units."""
        original = self if self._original is None else self._original
        return Errors(self._covariance(system), original._covariance(system))
