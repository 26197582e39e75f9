"""The predictions of the chords of an occultation from a run, with the offset of the ephemeris and the star."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base import rotations
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record
from ..typing import Floats
from .columns import jitter_of
from .contacts import Passage, Rows, body_of
from .event import Event, Solution, picked
from .limbs import limbs_of
from .linear import Held, LinearUnknown
from .observed_chords import ObservedChords
from .outline_contacts import contacts_of
from .states import RetardedStates, refuse_near
from .stations import StationPaths
from .vectors import local_geometry

#: Half the predicted duration is continued linearly in its square below this share of half the observed duration.
_SHORT = 0.25
#: The change of a contact, in standard errors, by the steps in the offset with which the design is differenced.
_NUDGE = 0.1
#: The step of derivatives along the imaginary axis.
_STEP = 1e-100
#: The step of the polynomials that are the paths of stations: in s, or without units a share of the geometry's span.
_STEP_OF_PATH, _SHARE = 10.0, 1e-3


class Sky(NamedTuple):
    """The plane of the sky that moves with the barycentre, in a system's unit of length, to the east and to the north.

    Attributes
    ----------
    points : ndarray, (K, 2)
        The line of sight of each row at its time.
    outlines : dict of list of ndarray, (R, 2)
        Lines of the outline of each body, which has NaN between separate lines.
    """

    points: Floats
    outlines: dict[str, list[Floats]]


class PredictedChords(ObservedChords):
    """Base class of :class:`fullbody.observing.StellarOccultation`, where its parameters are described."""

    _error_names = ("_sigma",)
    _names = ("time of contact",)

    def __init__(self, offset: Any, clock: Sequence[int] | None, **chords: Any) -> None:
        super().__init__(**chords)
        self.offset = offset
        self._fixed = None if isinstance(offset, str) and offset == "free" else self._fixed_offset(offset)
        self.clock = tuple(clock or ())
        for station in self.clock:
            if station not in range(len(self.stations)):
                raise InvalidInput(f"clock has {station!r}; expected indices of the {len(self.stations)} stations")
        self._kept: tuple[Any, Solution] | None = None
        #: Values of the linear unknowns at which predictions are made instead of those with the least chi2.
        self._at: Floats | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_kept": None}

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
        angle = unit_named("mas") if system.context.units.defined else None
        time = system.context.units.unit("time") if system.context.units.defined else None
        names = ("offset east", "offset north") if self._fixed is None else ()
        shifts = (LinearUnknown(f"clock of station {station}", time) for station in self.clock)
        return (*(LinearUnknown(name, angle) for name in names), *shifts)

    def _rows(self, system: SystemLike) -> Rows:
        """Return the rows on the clock and in the units of a system."""
        interval = self.in_system(self.interval, system)
        halves = 0.5 * (interval[:, 1] - interval[:, 0])
        is_timed = np.isfinite(halves) & (self.sign != 0.0)
        # A jitter does not change the predictions.
        least = np.maximum(_SHORT * np.where(is_timed, halves, 0.0), self.errors_in(system, without_jitter=True))
        ends = np.where(np.isnan(interval), [-np.inf, np.inf], interval)
        return Rows(self._clock(system), self.sign, ends, least)

    def _path(self, system: SystemLike, rows: Rows, of: Any) -> StationPaths:
        """Return the paths of the stations of some of the rows."""
        local, stations = local_geometry(self.geometry, system), self.station[of]
        low, high = local.ends()
        interval = self.in_system(self.interval, system)[of]
        units = system.context.units
        step = self.in_system(_STEP_OF_PATH * unit_named("s"), system) if units.defined else _SHARE * (high - low)

        def places(times: Floats) -> tuple[Floats, Floats]:
            within = np.clip(times, low, high)
            rate, u = local.observer_velocity(within), self.star.directions(system, times)
            offset = self.stations.at(system, stations, times, interval)
            if self.stations.on_earth:
                offset = self.stations.retarded(system, times, offset, rate, u)
            return local.observer(within) + rate * (times - within)[:, None] + offset, u

        return StationPaths(rows.times, step, places)

    def _axes(self, system: SystemLike, retarded: RetardedStates) -> tuple[Floats, Floats]:
        """Return displacements (K, 3) of bodies for an offset of one radian to the east and to the north."""
        if self._fixed is not None and not self._fixed.any():
            # A star at the pole has neither.
            return (np.zeros_like(retarded.observer),) * 2
        east, north = np.moveaxis(self.stations.plane(system, retarded.times), 1, 0)
        far = np.linalg.norm(retarded.observer, axis=1, keepdims=True)
        return far * east, far * north

    def _solution(self, system: SystemLike, states: dict[str, Any], masses: Any) -> Solution:
        """Return the solution for states, which is kept for as long as these do not change."""
        masses = system.context.masses if masses is None else masses
        real_states = {name: np.real(states[name]) for name in ("position", "velocity", "attitude", "spin")}
        # Complex states have further axes in front, along which the real parts are equal.
        real_states = {name: part[(0,) * (part.ndim - 3)] for name, part in real_states.items()}
        if "curvature" in states:
            real_states["curvature"] = states["curvature"]
        parts = (*(real_states[name].tobytes() for name in ("position", "velocity", "attitude", "spin")),)
        key = (id(system.context), parts, np.real(masses).tobytes(), self._sigma.tobytes())
        if self._kept is None or self._kept[0] != (key, system.context):
            self._kept = (key, system.context), self._solve(system, real_states, np.real(masses))
        return self._kept[1]

    def solution(self, run: Record) -> Solution:
        """Return the solution for a run."""
        return self._solution(run.system, self._states(run), None)

    def _solve(self, system: SystemLike, states: dict[str, Any], masses: Floats) -> Solution:
        retarded = self._retarded(system, states, masses)
        self._refuse(system, states, retarded)
        rows, every = self._rows(system), np.arange(len(self))
        passages: dict[int, tuple[Any, Passage]] = {}
        for body in range(len(system.context)):
            of = every[self.may_be(system, body)]
            if len(of) and (limbs := limbs_of(system, body)):
                part = Rows(*(column[of] for column in rows))
                passages[body] = of, contacts_of(part, self._path(system, part, of), limbs)
        self._refuse_unseen(passages)
        clocks = (self.station[:, None] == np.array(self.clock, dtype=np.intp)) & (self.sign != 0.0)[:, None]
        event = Event(
            station=self.station,
            sign=self.sign,
            sigma=self.errors_in(system),
            passages=passages,
            seen=lambda body, shift: body_of(retarded, states, body, shift),
            axes=self._axes(system, retarded),
            scale=self._scale(system),
            fixed=self._fixed,
            clocks=clocks.astype(np.float64),
        )
        return event.solution(self._at)

    @staticmethod
    def _scale(system: SystemLike) -> float:
        """Return the number of radians in the unit of the offset."""
        return float(unit_named("mas").to("rad")) if system.context.units.defined else 1.0

    def sky(self, run: Record) -> Sky:
        """Return where the observed contacts and the outlines of the bodies are in the plane of the sky."""
        system, states, solution = run.system, self._states(run), self.solution(run)
        retarded = self._retarded(system, states)
        axes = self.stations.plane(system, retarded.times)
        points, outlines = np.zeros((len(self), 2)), {}
        for body, (of, contacts) in solution.contacts.items():
            rows_of_body = np.flatnonzero(solution.chosen[of] == body)
            if not rows_of_body.size:
                continue
            seen = body_of(retarded, states, body, solution.shift).of(of)
            w, u, attitude = contacts.lines(seen, rows_of_body, retarded.times[of[rows_of_body]])
            points[of[rows_of_body]] = np.einsum("kax,kx->ka", axes[of[rows_of_body]], seen.centre[rows_of_body] + w)
            k = len(rows_of_body) // 2
            matrix = rotations.matrices(attitude[k])
            lines = [limb.rim(u[k] @ matrix) @ matrix.T + seen.centre[rows_of_body[k]] for limb in contacts.limbs]
            outlines[system.context.names[body]] = [line @ axes[of[rows_of_body[k]]].T for line in lines]
        return Sky(points, outlines)

    def _refuse(self, system: SystemLike, states: dict[str, Any], retarded: RetardedStates) -> None:
        """Raise an error for an observer within the system, and for a star on the observer's side of it."""
        local = local_geometry(self.geometry, system)
        attitude = retarded.attitude(states["attitude"], states["spin"])
        refuse_near(system, local, "observer", retarded.observer, retarded.centre, attitude, retarded.times, 1.0, 1.0)
        u = self.star.directions(system, retarded.times)
        if (behind := np.sum(retarded.observer * u, axis=1) >= 0.0).any():
            raise InvalidInput(
                f"star is on the observer's side of the system at {self.times[int(np.argmax(behind))]}, with no body "
                "between them; expected the direction from the observer to the star, past the system"
            )

    def _refuse_unseen(self, passages: dict[int, Any]) -> None:
        """Raise an error for a chord of a body that can hide no star."""
        seen = np.zeros(len(self.sign), dtype=bool)
        for of, _ in passages.values():
            seen[of] = True
        if not seen.all():
            station = int(self.station[np.argmin(seen)])
            raise InvalidInput(
                f"body of station {station} is a point, which hides no star; expected a body with a surface"
            )

    def _model(self, system: SystemLike, states: dict[str, Any], masses: Any = None, limbs: Any = None) -> Any:
        solution = self._solution(system, states, masses)
        prediction: Any = solution.prediction
        complex_states = any(np.iscomplexobj(states[name]) for name in ("position", "velocity", "attitude", "spin"))
        if complex_states or np.iscomplexobj(masses) or limbs is not None:
            retarded = self._retarded(system, states, masses)
            x = {}
            for body, (of, contacts) in solution.contacts.items():
                seen = body_of(retarded, states, body, solution.shift).of(of)
                x[body] = of, contacts.linearised(seen, (limbs or {}).get(body))
            prediction = picked(x, solution.chosen)
        offset = solution.design[:, : len(solution.values) - len(self.clock)]
        return (prediction - offset @ solution.values[: offset.shape[1]])[..., None]

    def _design(self, system: SystemLike, states: dict[str, Any]) -> Floats:
        return self._solution(system, states, None).design[:, None]

    def _depends_on_figures(self) -> bool:
        return True

    def _partials(
        self, system: SystemLike, states: dict[str, Any], parameters: Sequence[str] = ()
    ) -> tuple[Floats, dict[str, Floats]]:
        by_state, direct = super()._partials(system, states, parameters)
        for body in range(len(system.context)):
            for axis in range(3):
                spin = states["spin"].astype(np.complex128)
                spin[:, body, axis] += 1j * _STEP
                by_state[..., 12 * body + 9 + axis] = self._model(system, {**states, "spin": spin}).imag / _STEP
        return by_state, direct

    def _partial(self, system: SystemLike, states: dict[str, Any], parameter: str) -> Floats:
        kind, _, name = parameter.partition(" of ")
        axis = "abc".find(kind.removeprefix("semi-axis "))
        if not kind.startswith("semi-axis ") or axis < 0:
            return super()._partial(system, states, parameter)
        body = system.context.index(name)
        semi_axes = np.array(system.context.bodies[body].parts[0][0], dtype=np.complex128)
        semi_axes[axis] += 1j * _STEP
        limbs = {body: limbs_of(system, body, semi_axes)}
        return np.asarray(self._model(system, states, None, limbs).imag / _STEP)

    def _of_changed(self, system: SystemLike, changed: SystemLike, states: dict[str, Any]) -> Any:
        # The contacts and the offset stay those that were found, which follow the limbs to first order.
        limbs = {body: limbs_of(changed, body) for body in self._solution(system, states, None).contacts}
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
        solution, sigma = self.solution(run), self.errors_in(run.system)[:, None]
        derivatives, size = np.column_stack([by.start, *by.by_parameter.values()]), len(sigma)
        design, count, pulls = solution.design / sigma, len(solution.values), held.rows.ravel()
        changes, bends = np.zeros((count, size, derivatives.shape[1])), np.zeros((count, size, count))
        for column in range(2):
            step = _NUDGE / np.abs(design[:, column]).max()
            for sign in (1.0, -1.0):
                other = copy.copy(self)
                other._kept, other._at = None, solution.values + sign * step * np.eye(count)[column]
                nudged = super(PredictedChords, other).linear_derivatives(run, held)
                derivative = np.column_stack([nudged.start, *nudged.by_parameter.values()])[:size]
                changes[column] -= sign * derivative / (2.0 * step)
                nudged_design = other.solution(run).design / sigma
                bends[column] += sign * nudged_design / (2.0 * step)
        curvature = np.einsum("k,lkm->lm", pulls, bends)
        right_side = design.T @ derivatives[:size] + np.einsum("k,lkn->ln", pulls, changes)
        moved = np.linalg.solve(design.T @ design - curvature, right_side)
        total = changes + np.einsum("lkm,mn->lkn", bends, moved)
        derivatives[size:-1] += np.einsum("k,lkn->ln", pulls, total)
        derivatives[-1] += np.einsum("kl,lkn->n", held.design.reshape(size, count), total)
        start = by.start.shape[1]
        by_parameter = {name: derivatives[:, start + k] for k, name in enumerate(by.by_parameter)}
        return FunctionDerivatives(by.value, derivatives[:, :start], by_parameter)

    def _widen(self, jitter: Any) -> None:
        self._sigma = np.hypot(self._sigma, jitter_of(jitter, "s" if self.is_united else None))

    def _observed(self, system: SystemLike) -> Floats:
        return np.zeros((len(self), 1))

    def _covariance(self, system: SystemLike) -> Floats:
        return np.asarray(self.errors_in(system)[:, None, None] ** 2)

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return system.context.units.attach(values[:, 0], "time")
