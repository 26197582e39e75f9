"""The predictions of the chords of an occultation from a run, with the offset of the ephemeris and the star."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import rotations
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record
from ..typing import Floats
from .contacts import ApparentBody, ContactRows, Passage, apparent_body
from .event import Event, Solution
from .limbs import limbs_of
from .linear import Held, LinearUnknown
from .observed_chords import ObservedChords
from .outline_contacts import passage_of
from .pictures import ChordPicture
from .states import IMAGINARY_STEP, RetardedStates, refuse_near
from .stations import StationPaths
from .vectors import local_geometry

#: Half the predicted duration is continued linearly in its square below this share of half the observed duration.
_SHORTEST = 0.25
#: The change of a contact, in standard errors, by the steps in the offset with which the design is differenced.
_STEP_OF_OFFSET = 0.1
#: The step of the polynomials that are the paths of stations: in s, or without units a share of the geometry's span.
_STEP_OF_PATH, _SHARE_OF_SPAN = 10.0, 1e-3
_STATES = ("position", "velocity", "attitude", "spin")


class PredictedChords(ObservedChords):
    """Base class of :class:`fullbody.observing.StellarOccultation`, where its parameters are described."""

    _names = ("time of contact",)
    _depends_on_figures = True

    def __init__(self, offset: Any, clock: Sequence[int] | None, **chords: Any) -> None:
        super().__init__(**chords)
        self.offset = offset
        self._fixed = None if isinstance(offset, str) and offset == "free" else self._fixed_offset(offset)
        self.clock = tuple(clock or ())
        for station in self.clock:
            if station not in range(len(self.stations)):
                raise InvalidInput(f"clock has {station!r}; expected indices of the {len(self.stations)} stations")
        #: The last event that was solved with its solution, and the context and the numbers that lead to them.
        self._last: tuple[Any, Any, tuple[Event, Solution]] | None = None
        #: Values of the linear unknowns at which predictions are made instead of those with the least chi2.
        self._unknowns: Floats | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_last": None}

    @staticmethod
    def _fixed_offset(offset: Any) -> Floats:
        """Return a given offset (2,) in radians."""
        expected = "expected 'free' or (east, north), angles as Quantities, or 0.0"
        if np.ndim(offset) == 0 and not isinstance(offset, str) and not is_quantity(offset) and offset == 0.0:
            return np.zeros(2)
        if isinstance(offset, str) or np.ndim(offset) != 1 or len(offset) != 2:
            raise InvalidInput(f"offset is {offset!r}; {expected}")
        parts = [UNITLESS.number(part, "angle", "offset") for part in offset]
        if not all(is_quantity(part) for part in offset) and any(parts):
            raise InvalidInput(f"offset is {offset!r}, angles without a unit; {expected}")
        return np.array(parts)

    def _linear_unknowns(self, system: SystemLike) -> tuple[LinearUnknown, ...]:
        units = system.context.units
        angle, time = (unit_named("mas"), units.unit("time")) if units.defined else (None, None)
        offsets = ("offset east", "offset north") if self._fixed is None else ()
        clocks = (LinearUnknown(f"clock of station {station}", time) for station in self.clock)
        return (*(LinearUnknown(name, angle) for name in offsets), *clocks)

    def _passages(self, system: SystemLike) -> dict[int, tuple[Any, Passage]]:
        """Return the passage of each body, with the rows that may be due to it."""
        interval, times = self._interval_in(system), self._clock(system)
        halves = 0.5 * (interval[:, 1] - interval[:, 0])
        halves = np.where(np.isfinite(halves) & (self.sign != 0.0), halves, 0.0)
        # A jitter does not change the predictions.
        shortest = np.maximum(_SHORTEST * halves, self._standard_errors(system, self._original_sigma)[:, 0])
        ends = np.where(np.isnan(interval), [-np.inf, np.inf], interval)
        local, units = local_geometry(self.geometry, system), system.context.units
        step = _SHARE_OF_SPAN * np.ptp(local.ends())
        if units.defined:
            step = float(units.strip(_STEP_OF_PATH * unit_named("s"), "time", "a step in time"))

        def path_of(rows: Any) -> StationPaths:
            def positions(moments: Floats) -> tuple[Floats, Floats]:
                return self.stations.positions(system, local, self.station[rows], moments, interval[rows])

            return StationPaths(times[rows], step, positions)

        passages: dict[int, tuple[Any, Passage]] = {}
        is_visible = np.zeros(len(self), dtype=bool)
        for body in range(len(system.context)):
            rows = self._rows_of(system, body)
            if len(rows) and (limbs := limbs_of(system, body)):
                contacts = ContactRows(times[rows], self.sign[rows], ends[rows], shortest[rows])
                passages[body] = rows, passage_of(contacts, path_of(rows), limbs)
                is_visible[rows] = True
        if not is_visible.all():
            station = int(self.station[np.argmin(is_visible)])
            raise InvalidInput(
                f"body of station {station} is a point, which hides no star; expected a body with a surface"
            )
        return passages

    def _axes(self, system: SystemLike, retarded: RetardedStates) -> tuple[Floats, Floats]:
        """Return displacements (K, 3) of bodies for an offset of one radian to the east and to the north."""
        if self._fixed is not None and not self._fixed.any():
            # A star at the pole has neither.
            return (np.zeros_like(retarded.observer),) * 2
        east, north = np.moveaxis(self.stations.sky_axes(system, retarded.times), 1, 0)
        distance = np.linalg.norm(retarded.observer, axis=1, keepdims=True)
        return distance * east, distance * north

    def _solved_event(self, system: SystemLike, states: dict[str, Any], masses: Any = None) -> tuple[Event, Solution]:
        """Return the event of states and its solution, which are kept for as long as these do not change."""
        masses = np.real(system.context.masses if masses is None else masses)
        # Complex states have further axes in front, along which the real parts are equal.
        real_parts = ((name, np.real(states[name])) for name in _STATES)
        real_states: dict[str, Any] = states | {name: part[(0,) * (part.ndim - 3)] for name, part in real_parts}
        key = (*(part.tobytes() for part in (*(real_states[name] for name in _STATES), masses, self._sigma)),)
        if self._last is None or self._last[0] is not system.context or self._last[1] != key:
            event = self._event(system, real_states, masses)
            self._last = system.context, key, (event, event.solution(self._unknowns))
        return self._last[2]

    def _event(self, system: SystemLike, states: dict[str, Any], masses: Floats) -> Event:
        """Return the event that states lead to."""
        retarded = self._retarded(system, states, masses)
        self._refuse_hidden(system, states, retarded)
        clocks = (self.station[:, None] == np.array(self.clock, dtype=np.intp)) & (self.sign != 0.0)[:, None]
        return Event(
            station=self.station,
            sign=self.sign,
            sigma=self._standard_errors(system)[:, 0],
            passages=self._passages(system),
            apparent=lambda body, displacement: apparent_body(retarded, states, body, displacement),
            axes=self._axes(system, retarded),
            scale=float(unit_named("mas").to("rad")) if system.context.units.defined else 1.0,
            fixed=self._fixed,
            clocks=clocks.astype(np.float64),
        )

    def _refuse_hidden(self, system: SystemLike, states: dict[str, Any], retarded: RetardedStates) -> None:
        """Raise an error for an observer within the system, and for a star on the observer's side of it."""
        local = local_geometry(self.geometry, system)
        attitude = retarded.attitude(states["attitude"], states["spin"])
        refuse_near(system, local, "observer", retarded.observer, retarded.centre, attitude, retarded.times, 1.0, 1.0)
        u = self.star.directions(system, retarded.times)
        if (is_behind := np.sum(retarded.observer * u, axis=1) >= 0.0).any():
            raise InvalidInput(
                f"star is on the observer's side of the system at {self.times[int(np.argmax(is_behind))]}, with no "
                "body between them; expected the direction from the observer to the star, past the system"
            )

    def _picture(self, run: Record) -> ChordPicture:
        """Return the chords and the outlines of the bodies in the plane of the sky, with the offset that fits best."""
        system, states, times = run.system, self._states(run), self._clock(run.system)
        event, solution = self._solved_event(system, states)
        axes, points, outlines = self.stations.sky_axes(system, times), np.zeros((len(self), 2)), {}
        for body, (rows, passage) in event.passages.items():
            index = np.flatnonzero(solution.body[rows] == body)
            if not index.size:
                continue
            apparent, chosen = event.apparent(body, solution.displacement).of_rows(rows), rows[index]
            w, u, attitude = passage.rays(apparent, index, times[chosen])
            points[chosen] = np.einsum("kax,kx->ka", axes[chosen], apparent.centre[index] + w)
            k = len(index) // 2
            matrix = rotations.matrices(attitude[k])
            lines = [limb.outline(u[k] @ matrix) @ matrix.T + apparent.centre[index[k]] for limb in passage.limbs]
            outlines[system.context.names[body]] = [line @ axes[chosen[k]].T for line in lines]
        chords, errors, timed = [], [], self.sign != 0.0
        for station in np.unique(self.station[timed]):
            rows = np.flatnonzero(timed & (self.station == station))
            chords.append(points[rows])
            if len(rows) == 2:
                bars = np.outer(event.sigma[rows], np.diff(points[rows], axis=0) / np.diff(times[rows]))
                errors += [np.stack([end - bar, end + bar]) for end, bar in zip(points[rows], bars, strict=True)]
        return ChordPicture(chords, errors, points[~timed], outlines)

    def _model(self, system: SystemLike, states: dict[str, Any], masses: Any = None, limbs: Any = None) -> Any:
        event, solution = self._solved_event(system, states, masses)
        prediction: Any = solution.prediction
        if limbs is not None or any(np.iscomplexobj(part) for part in (masses, *(states[name] for name in _STATES))):
            retarded = self._retarded(system, states, masses)

            def apparent(body: int, displacement: Any) -> ApparentBody:
                return apparent_body(retarded, states, body, displacement)

            prediction = event.linearised(apparent, solution.displacement, solution.body, limbs)
        offsets = len(solution.values) - len(self.clock)
        return (prediction - solution.design[:, :offsets] @ solution.values[:offsets])[..., None]

    def _design(self, system: SystemLike, states: dict[str, Any]) -> Floats:
        return self._solved_event(system, states)[1].design[:, None]

    def _partial(self, system: SystemLike, states: dict[str, Any], parameter: str) -> Floats:
        kind, _, name = parameter.partition(" of ")
        axis = "abc".find(kind.removeprefix("semi-axis "))
        if not kind.startswith("semi-axis ") or axis < 0:
            return super()._partial(system, states, parameter)
        body = system.context.index(name)
        semi_axes = np.array(system.context.bodies[body].parts[0][0], dtype=np.complex128)
        semi_axes[axis] += 1j * IMAGINARY_STEP
        limbs = {body: limbs_of(system, body, semi_axes)}
        return np.asarray(self._model(system, states, None, limbs).imag / IMAGINARY_STEP)

    def _of_changed(self, system: SystemLike, changed: SystemLike, states: dict[str, Any]) -> Any:
        # The contacts and the offset stay those of the system, and follow the limbs to first order.
        limbs = {body: limbs_of(changed, body) for body in self._solved_event(system, states)[0].passages}
        return self._model(system, states, None, limbs)

    def linear_derivatives(self, run: Record, held: Held) -> FunctionDerivatives:
        """Compute the derivatives of what :meth:`LinearModel.contracted` returns, as :meth:`derivatives` does.

        The design depends on the motion and on the offset, which follows it: the sum of the products of pulls and
        columns of the design stays zero, which gives the change of the offset. Derivatives of the design are
        differences between offsets, of which the largest moves a contact by a share of its standard error.
        """
        by = super().linear_derivatives(run, held)
        if self._fixed is not None:
            return by
        states, pulls = self._states(run), held.rows.ravel()
        event, solution = self._solved_event(run.system, states)
        sigma = event.sigma[:, None]
        derivatives, size = np.column_stack([by.start, *by.by_parameter.values()]), len(sigma)
        design, count = solution.design / sigma, len(solution.values)
        # The derivatives of the L columns of the design by the start and the parameters, and by the unknowns.
        direct, by_unknowns = np.zeros((count, size, derivatives.shape[1])), np.zeros((count, size, count))
        for column in range(2):
            step = _STEP_OF_OFFSET / np.abs(design[:, column]).max()
            for sign in (1.0, -1.0):
                other = copy.copy(self)
                other._last, other._unknowns = None, solution.values + sign * step * np.eye(count)[column]
                shifted = super(PredictedChords, other).linear_derivatives(run, held)
                derivative = np.column_stack([shifted.start, *shifted.by_parameter.values()])[:size]
                direct[column] -= sign * derivative / (2.0 * step)
                other_design = other._solved_event(run.system, states)[1].design / sigma
                by_unknowns[column] += sign * other_design / (2.0 * step)
        curvature = np.einsum("k,lkm->lm", pulls, by_unknowns)
        right_side = design.T @ derivatives[:size] + np.einsum("k,lkn->ln", pulls, direct)
        of_unknowns = np.linalg.solve(design.T @ design - curvature, right_side)
        total = direct + np.einsum("lkm,mn->lkn", by_unknowns, of_unknowns)
        derivatives[size:-1] += np.einsum("k,lkn->ln", pulls, total)
        derivatives[-1] += np.einsum("kl,lkn->n", held.design.reshape(size, count), total)
        start = by.start.shape[1]
        by_parameter = {name: derivatives[:, start + k] for k, name in enumerate(by.by_parameter)}
        return FunctionDerivatives(by.value, derivatives[:, :start], by_parameter)
