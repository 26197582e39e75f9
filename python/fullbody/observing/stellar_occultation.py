"""Stellar occultations: the chords of one event, and their comparison with a run."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from ..base.foreign import are_dates
from ..base.kinds import instance
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, is_quantity, need
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record
from ..typing import Floats
from .columns import jitter_of
from .contacts import Body, Contacts, Rows, body_of
from .koala import read_koala
from .limbs import limbs_of
from .linear import Held, LinearUnknown
from .observed_chords import ObservedChords
from .outline_contacts import contacts_of
from .states import RetardedStates, refuse_near
from .station_paths import StationPaths
from .vectors import local_geometry

#: The share of the observed duration below which a predicted one is continued, in halves of durations.
_SHORT = 0.25
#: The change of a contact, in standard errors, by the steps in the offset with which the design is differenced.
_NUDGE = 0.1
#: The step of derivatives along the imaginary axis.
_STEP = 1e-100
#: The relative changes at which the search for the offset ends.
_TOLERANCES = {"xtol": 1e-11, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 200}
#: The step of the polynomials that are the paths of stations, in s, or relative to the span of a geometry without units.
_STEP_OF_PATH, _SHARE = 10.0, 1e-3


class Solution(NamedTuple):
    """The predictions of K rows with the linear unknowns (L,) at which chi2 is least, and what leads to them.

    Attributes
    ----------
    values : ndarray, (L,)
    prediction : ndarray, (K,)
        Predictions relative to the times of the rows, with the offset and without errors of clocks.
    design : ndarray, (K, L)
    contacts : dict of int to (ndarray of int, Contacts)
        For each body the rows that it was compared with, and their contacts.
    chosen : ndarray of int, (K,)
        The body of each row.
    shift : ndarray, (K, 3)
    """

    values: Floats
    prediction: Floats
    design: Floats
    chosen: Any
    shift: Floats
    contacts: dict[int, tuple[Any, Contacts]]


class StellarOccultation(ObservedChords):
    """The chords of one stellar occultation by the bodies of a system, timed by S stations.

    Parameters
    ----------
    star : SkyCoord, (ra, dec) or array_like (3,)
        The star, as for :func:`occultation_chords`.
    stations : EarthLocation, sequence of them, or array_like or Quantity, (S, 3), (S, 2, 3) or (S, 2, 2)
        Places on the Earth, for a geometry from its centre; vectors from the observer of the geometry, along its axes,
        one for each station or one at each of the two times; or offsets to the east and to the north at both times in
        the plane of the sky through the observer.
    disappearance, reappearance : astropy Time, or array_like or Quantity, (S,)
        Times at the stations. One that is NaN, or masked, was not timed; both are for a miss: the station saw no
        occultation in its interval.
    sigma : float or Quantity, (), (S,) or (S, 2)
        Standard errors of the times: one, or one for each station, or for its disappearance and its reappearance.
    geometry : Geometry
    body : str, int or sequence of them (S,), optional
        The body of all chords, or of each, by its name or index in the system; ``None`` where it is not known: the body
        that fits a chord best counts, and a miss is one of all bodies.
    offset : "free" or (east, north)
        The offset of the ephemeris and the star together: the angle by which the system is to the east and to the north
        of where geometry and star have it. With ``"free"`` it is found wherever a run is compared with the data.
    clock : sequence of int, optional
        The stations whose clocks have a free error, which is added to the predicted times.
    watched : pair of (S,), optional
        First and last time of each station's watch, which counts for misses; without it a miss is one at any time.

    Raises
    ------
    InvalidInput
        For a reappearance that is not after its disappearance, standard errors that are not above zero, angles without a
        unit, and shapes that do not fit. When a run is compared, for an observer within the system, a star on the
        observer's side of it, and an offset that the data leave undetermined.

    Notes
    -----
    A body hides the star as for :func:`occultation_chords`. Residuals are observed minus predicted times. If the
    predicted chord is shorter than a quarter of the observed one, or than twice the standard error, half its duration is
    continued linearly in its square, also where the body misses the station, so that a fit finds its way back. A miss
    has the residual zero unless a body hides the star in the watched interval; then it is minus the time in which the
    line of sight would leave the body by the shortest way.

    Predicted times are not linear in the offset. It is found at the least chi2 for each run, by iterations that
    integrate nothing, and the predictions are linear about it. With one chord, the body may be on either side of it.

    The star is a point: its own diameter and diffraction are left out.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> system = system.with_options(frame="ecliptic")
    >>> run = system.integrate(state, "10 min", dense=True)
    >>> path = {"to_observer": [[1e7, -2.0, 0.0], [1e7, 4.0, 0.0]] * u.km, "frame": "ecliptic"}
    >>> geometry, star = observing.Geometry([0.0, 300.0] * u.s, **path), [-1.0, 0.0, 0.0]
    >>> stations = [[0.0, 0.0, 0.1], [0.0, 0.0, -0.2], [0.0, 0.0, 9.0]] * u.km
    >>> seen = {"disappearance": [80.0, 80.0, np.nan] * u.s, "reappearance": [118.0, 117.0, np.nan] * u.s}
    >>> options = {"star": star, "stations": stations, "geometry": geometry, "body": "Didymos"}
    >>> data = observing.StellarOccultation(**seen, sigma=0.1 * u.s, **options)
    >>> data.residuals(run).shape, list(data.linear_values(run))
    ((5,), ['offset east', 'offset north'])
    """

    _error_names = ("_sigma",)

    def __init__(
        self,
        *,
        star: Any,
        stations: Any,
        disappearance: Any,
        reappearance: Any,
        sigma: Any,
        geometry: Any,
        body: Any = None,
        offset: Any = "free",
        clock: Sequence[int] | None = None,
        watched: Any = None,
    ) -> None:
        super().__init__(star, stations, disappearance, reappearance, sigma, geometry, body, watched)
        self.offset = offset
        self._fixed = None if isinstance(offset, str) and offset == "free" else self._fixed_offset(offset)
        self.clock = tuple(clock or ())
        for station in self.clock:
            if station not in range(len(self.stations)):
                raise InvalidInput(f"clock has {station!r}; expected indices of the {len(self.stations)} stations")
        self._known: tuple[Any, Solution] | None = None
        #: Values of the linear unknowns at which predictions are made instead of those with the least chi2.
        self._at: Floats | None = None

    @classmethod
    def read_koala(
        cls, path: Any, *, body: Any = None, event: int | None = None, offset: Any = "free", scale: str = "utc"
    ) -> Self:
        """Read the chords of an event from a file in the format of KOALA, which ADAM reads too.

        Such a file has the vector from the body to the Earth and its rate of change, and for each chord two times, their
        errors in s, and the places of the station at both times, to the west and to the north in the plane of the sky
        that moves with the shadow.

        Parameters
        ----------
        path : path
        body : str, int or sequence of them, optional
            As for the class.
        event : int, optional
            The index of the event, in a file with several.
        offset : "free" or (east, north)
            As for the class; it counts from the mean of the places of the file.
        scale : str
            The time scale of the file's dates.

        Returns
        -------
        StellarOccultation
            Its geometry is the uniform motion of the file, for times within an hour of the chords.

        Raises
        ------
        InvalidInput
            For a file in another format, and one with several events if none is chosen.
        """
        return cls(**read_koala(path, event, scale), body=body, offset=offset)

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
        sigma = self.errors_in(system)
        known = np.isfinite(halves) & (self.sign != 0.0)
        least = np.maximum(np.where(known, _SHORT * np.where(known, halves, 0.0), 0.0), sigma)
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
        east, north = self.stations.plane(system, retarded.times)
        far = np.linalg.norm(retarded.observer, axis=1, keepdims=True)
        return far * east, far * north

    def _solution(self, system: SystemLike, states: dict[str, Any], masses: Any) -> Solution:
        """Return the solution for states, which is kept for as long as these do not change."""
        masses = system.context.masses if masses is None else masses
        plain = {name: np.real(states[name]) for name in ("position", "velocity", "attitude", "spin")}
        # Complex states have further axes in front, along which the real parts are equal.
        plain = {name: part[(0,) * (part.ndim - 3)] for name, part in plain.items()}
        if "curvature" in states:
            plain["curvature"] = states["curvature"]
        parts = (*(plain[name].tobytes() for name in ("position", "velocity", "attitude", "spin")),)
        key = (id(system.context), parts, np.real(masses).tobytes(), self._sigma.tobytes())
        if self._known is None or self._known[0] != (key, system.context):
            self._known = (key, system.context), self._solve(system, plain, np.real(masses))
        return self._known[1]

    def _solve(self, system: SystemLike, states: dict[str, Any], masses: Floats) -> Solution:
        retarded = self._retarded(system, states, masses)
        self._refuse(system, states, retarded)
        rows, axes = self._rows(system), self._axes(system, retarded)
        every = np.arange(len(rows.times))
        passages: dict[int, tuple[Any, Contacts]] = {}
        for body, name in enumerate(system.context.names):
            of = every[self.may_be(system, body)]
            if len(of) and (limbs := limbs_of(system, body)):
                part = Rows(*(column[of] for column in rows))
                passages[body] = of, contacts_of(part, self._path(system, part, of), limbs)
            elif len(of) == len(every):
                del name
        self._refuse_unseen(system, passages)
        clocks = (
            np.stack([self.station == station for station in self.clock], axis=1)
            if self.clock
            else np.zeros((len(every), 0))
        )
        clocks = clocks.astype(np.float64) * (self.sign != 0.0)[:, None]
        count = 2 if self._fixed is None else 0
        scale = self._scale(system)
        sigma = self.errors_in(system)
        evaluated: list[Any] = []

        def evaluate(values: Floats) -> tuple[Floats, Floats, Any, Floats]:
            """Return predictions, the design, the bodies and the displacement for values of the unknowns."""
            if evaluated and np.array_equal(evaluated[0], values):
                return evaluated[1]
            angles = self._fixed if self._fixed is not None else values[:2] * scale
            shift = angles[0] * axes[0] + angles[1] * axes[1]
            found = {
                n: (of, contacts.solve(self._seen(retarded, states, n, shift).of(of)))
                for n, (of, contacts) in passages.items()
            }
            chosen = self._chosen(found)
            prediction = _picked(found, chosen)
            columns = []
            for axis in axes[:count]:
                moved = shift + 1j * _STEP * scale * axis
                changed = {
                    n: (of, contacts.linearised(self._seen(retarded, states, n, moved).of(of)).imag / _STEP)
                    for n, (of, contacts) in passages.items()
                }
                columns.append(_picked(changed, chosen))
            design = np.concatenate([np.array(columns).reshape(count, len(every)).T, clocks], axis=1)
            evaluated[:] = values.copy(), (prediction, design, chosen, shift)
            return prediction, design, chosen, shift

        values = np.zeros(count + len(self.clock))
        if self._at is not None:
            values = self._at
        elif count and len(values) <= len(every):
            with need("observing", "the offset of an occultation"):
                from scipy.optimize import least_squares

            def pulls(unknowns: Floats) -> Floats:
                return np.asarray((evaluate(unknowns)[0] + clocks @ unknowns[count:]) / sigma)

            def jacobian(unknowns: Floats) -> Floats:
                return np.asarray(evaluate(unknowns)[1] / sigma[:, None])

            values = least_squares(pulls, values, jacobian, method="lm", x_scale="jac", **_TOLERANCES).x
        return Solution(values, *evaluate(values), passages)

    def _scale(self, system: SystemLike) -> float:
        """Return the number of radians in the unit of the offset."""
        return float(unit_named("mas").to("rad")) if system.context.units.defined else 1.0

    def _seen(self, retarded: RetardedStates, states: dict[str, Any], body: int, shift: Any) -> Body:
        return body_of(retarded, states, body, shift)

    def _chosen(self, found: dict[int, tuple[Any, Floats]]) -> Any:
        """Return the body of each row: for each station the one whose predictions are nearest to what was observed."""
        bodies = list(found)
        cost = np.full((len(bodies), len(self.sign)), np.inf)
        for place, (of, predictions) in enumerate(found.values()):
            # Of several bodies that should have been missed, the one that hides the star most counts.
            cost[place, of] = np.where(self.sign[of] == 0.0, -np.abs(predictions), predictions**2)
        best = np.empty(len(self.sign), dtype=np.intp)
        for station in set(self.station.tolist()):
            rows = self.station == station
            best[rows] = bodies[int(np.argmin(cost[:, rows].sum(axis=1)))]
        return best

    def _refuse(self, system: SystemLike, states: dict[str, Any], retarded: RetardedStates) -> None:
        """Raise an error for an observer within the system, and for a star on the observer's side of it."""
        local = local_geometry(self.geometry, system)
        attitude = retarded.attitude(states["attitude"], states["spin"])
        refuse_near(system, local, "observer", retarded.observer, retarded.centre, attitude, retarded.times, 1.0, 1.0)
        u = self.star.directions(system, retarded.times)
        if (behind := np.sum(retarded.observer * u, axis=1) >= 0.0).any():
            raise InvalidInput(
                f"star is on the observer's side of the system at {self.times[int(np.argmax(behind))]}, where no body is "
                "between them; expected the direction from the observer to the star, past the system"
            )

    def _refuse_unseen(self, system: SystemLike, passages: dict[int, Any]) -> None:
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
            found = {
                body: (
                    of,
                    contacts.linearised(
                        self._seen(retarded, states, body, solution.shift).of(of), (limbs or {}).get(body)
                    ),
                )
                for body, (of, contacts) in solution.contacts.items()
            }
            prediction = _picked(found, solution.chosen)
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

    def linear_derivatives(self, run: Record, held: Held) -> FunctionDerivatives:
        """Compute the derivatives of what :meth:`LinearModel.contracted` returns, as :meth:`derivatives` does.

        The design depends on the motion and on the offset, which follows it: the sum of the products of pulls and
        columns of the design stays zero, which gives the change of the offset. Derivatives of the design are
        differences between offsets, of which the largest moves a contact by a share of its standard error.
        """
        by = super().linear_derivatives(run, held)
        if self._fixed is not None:
            return by
        solution = self._solution(run.system, self._states(run), None)
        sigma = self.errors_in(run.system)
        design, size, pulls = solution.design / sigma[:, None], len(sigma), held.rows.ravel()
        whole = np.concatenate(
            [by.start, np.stack(list(by.by_parameter.values()), axis=1)] if by.by_parameter else [by.start], axis=1
        )
        count = len(solution.values)
        changes, bends = np.zeros((count, size, whole.shape[1])), np.zeros((count, size, count))
        for column in range(2):
            step = _NUDGE / np.abs(design[:, column]).max()
            for sign in (1.0, -1.0):
                other = copy.copy(self)
                other._known, other._at = None, solution.values + sign * step * np.eye(count)[column]
                nudged = super(StellarOccultation, other).linear_derivatives(run, held)
                columns = [nudged.start, *(part[:, None] for part in nudged.by_parameter.values())]
                changes[column] -= sign * np.concatenate(columns, axis=1)[:size] / (2.0 * step)
                at = other._solution(run.system, other._states(run), None).design / sigma[:, None]
                bends[column] += sign * at / (2.0 * step)
        curvature = np.einsum("k,lkm->lm", pulls, bends)
        right_side = design.T @ whole[:size] + np.einsum("k,lkn->ln", pulls, changes)
        moved = np.linalg.solve(design.T @ design - curvature, right_side)
        total = changes + np.einsum("lkm,mn->lkn", bends, moved)
        whole[size:-1] += np.einsum("k,lkn->ln", pulls, total)
        whole[-1] += np.einsum("kl,lkn->n", held.design.reshape(size, count), total)
        start = by.start.shape[1]
        by_parameter = {name: whole[:, start + k] for k, name in enumerate(by.by_parameter)}
        return FunctionDerivatives(by.value, whole[:, :start], by_parameter)

    def predict(self, run: Record, linear: Mapping[str, Any] | None = None) -> Any:
        """Compute the times of the contacts that were observed, from a run.

        Parameters
        ----------
        run : Run
            A run with ``dense=True``, or with samples at the times :meth:`emission` of its system.
        linear : dict, optional
            The offset and the errors of clocks, as :meth:`linear_values` returns them.

        Returns
        -------
        astropy Time, Quantity or ndarray, (K,)
            Times of the kind of ``times``; a miss has the middle of its interval, later by minus its residual.
        """
        later = self._attach(self._solved(run, linear)[0], run.system)
        return self.times + later if not are_dates(self.times) else self.times + later.to("s")

    def identified(self, run: Record) -> tuple[str, ...]:
        """Return for each of the K rows the name of the body that was compared with it.

        Parameters
        ----------
        run : Run
            A run as for :meth:`predict`.
        """
        solution = self._solution(run.system, self._states(run), None)
        return tuple(run.context.names[body] for body in solution.chosen)

    def _widen(self, jitter: Any) -> None:
        self._sigma = np.hypot(self._sigma, jitter_of(jitter, "s" if self.is_united else None))

    def _observed(self, system: SystemLike) -> Floats:
        return np.zeros((len(self), 1))

    def _covariance(self, system: SystemLike) -> Floats:
        return np.asarray(self.errors_in(system)[:, None, None] ** 2)

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return system.context.units.attach(values[:, 0], "time")


def _picked(found: dict[int, tuple[Any, Any]], chosen: Any) -> Any:
    """Return the predictions (..., K) of the chosen bodies."""
    first = next(iter(found.values()))[1]
    values = np.zeros(
        (*np.shape(first)[:-1], len(chosen)), dtype=np.result_type(*(np.asarray(v) for _, v in found.values()))
    )
    for body, (of, predictions) in found.items():
        own = chosen[of] == body
        values[..., of[own]] = predictions[..., own]
    return values


_CHECKED = instance
