"""Photometry: observed magnitudes of all bodies together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.foreign import are_dates, shown
from ..base.kinds import flag
from ..base.limits import Limits
from ..base.units import UNITLESS, is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .brightness import Epochs, Photometer
from .columns import DataColumn, Rows, column, jitter_of, positive_rows, refuse_rounded
from .data import Observations
from .laws import LommelSeeliger
from .light_curve import magnitudes
from .states import DISTANT, RetardedStates, refuse_near
from .vectors import Vectors, local_geometry

if TYPE_CHECKING:
    from .laws import Law

__all__ = ["Photometry"]

#: The length of a gap, in hours, that separates two nights.
_GAP = 8.0


class Photometry(Observations):
    """Magnitudes of all bodies of a system together, unresolved in the sky.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the light arrived.
    magnitude : array_like or Quantity, (K,)
        Rows with masked or NaN values are left out, with a warning.
    sigma : float, array_like or Quantity, () or (K,)
        Standard errors.
    geometry : Geometry
        A geometry that includes the Sun.
    law, albedo, mutual, sun_radius
        Options of :func:`brightness`.
    zero : "free" or float
        The zero point, which is added to the magnitudes of :func:`light_curve`. With ``"free"`` each night has its own
        zero point, at which chi2 is least: the weighted mean of observed minus computed magnitudes.
    night : array_like, (K,), optional
        Labels of the nights. Without them a night ends with a gap of more than eight hours; times that are plain
        numbers are one night.
    reduced : bool
        Whether the magnitudes are reduced to unit distances from the observer and from the Sun.

    Raises
    ------
    InvalidInput
        For a geometry without the Sun, errors that are not above zero, an unknown kind of zero point.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
    >>> geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    >>> times = np.linspace(1.0, 7.0, 50) * u.h
    >>> observed = 14.5 + observing.light_curve(run, times, geometry)
    >>> data = observing.Photometry(times, observed, 0.01, geometry=geometry)
    >>> bool(abs(data.residuals(run)).max() < 1e-12), data.zero_points(run).round(6)
    (True, array([14.5]))
    """

    _columns = (DataColumn("magnitude"), DataColumn("sigma"), DataColumn("night", required=False, kind="labels"))
    _error_names = ("sigma",)

    def __init__(
        self,
        times: Any,
        magnitude: Any,
        sigma: Any,
        *,
        geometry: Vectors,
        law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
        albedo: float | dict[str, float] = 1.0,
        mutual: bool = True,
        sun_radius: Any = 0.0,
        zero: str | float = "free",
        night: Any = None,
        reduced: bool = True,
    ) -> None:
        columns = (("magnitude", magnitude), ("sigma", sigma))
        numbers = {name: column(value, name, "mag")[0] for name, value in columns}
        refuse_rounded(magnitude, numbers["magnitude"], numbers["sigma"], "magnitude of Photometry")
        rows = Rows(times, numbers, ("magnitude",), "Photometry")
        super().__init__(rows, geometry)
        if not geometry.has_sun:
            raise InvalidInput("geometry of Photometry has no Sun; give to_sun=")
        self.magnitude = rows.of("magnitude")
        self.sigma = positive_rows(rows.of("sigma"), "sigma of Photometry")
        self.law, self.albedo, self.mutual, self.sun_radius = law, albedo, mutual, sun_radius
        self.reduced = reduced
        flag(mutual, "mutual")
        flag(reduced, "reduced")
        if not (isinstance(zero, str) and zero == "free"):
            UNITLESS.number(zero, "number", "zero", Limits(text="'free' or a finite number"))
        self.zero = zero
        if night is not None and np.shape(night) != (rows.given,):
            raise InvalidInput(f"night has shape {np.shape(night)}; expected ({rows.given},), one for each of times")
        if night is None or all(label is None for label in np.asarray(night)):
            labels = _nights(self.times)
        else:
            labels = np.asarray(night)[self.rows]
        try:
            #: Names of the nights, and the index of each row's night among them.
            self.nights, self._night = np.unique(labels, return_inverse=True)
        except TypeError as error:
            raise InvalidInput(f"night is {shown(night)}, labels of several kinds; expected one kind") from error

    def _in_table(self) -> tuple[dict[str, Any], dict[str, Any]]:
        columns = {"magnitude": self.magnitude, "sigma": self.sigma, "night": self.nights[self._night]}
        return columns, {"zero": self.zero}

    def zero_points(self, run: Any) -> Floats:
        """Compute the zero point of each of ``nights`` for a run.

        Parameters
        ----------
        run : Run

        Returns
        -------
        ndarray, (number of nights,)
        """
        return self._zeros(super()._residuals(run))[:, 0]

    @property
    def linear_unknowns(self) -> int:
        """The number of zero points that are solved for, which count as parameters of a fit."""
        return len(self.nights) if self.zero == "free" else 0

    def _design(self, system: SystemLike) -> Floats:
        return np.eye(len(self.nights))[self._night, None, : self.linear_unknowns]

    def _zeros(self, values: Floats) -> Floats:
        """Return weighted means (nights, ...) of values (K, ...) by night, or the zero point itself if it was given."""
        if self.zero != "free":
            return np.full((len(self.nights), *values.shape[1:]), float(self.zero))
        weights = self.sigma**-2.0
        sums = np.zeros((len(self.nights), *values.shape[1:]))
        np.add.at(sums, self._night, values * weights.reshape(-1, *[1] * (values.ndim - 1)))
        total = np.bincount(self._night, weights)
        return np.asarray(sums / total.reshape(-1, *[1] * (values.ndim - 1)))

    def _project(self, values: Floats) -> Floats:
        """Return derivatives of the predictions, including those of the zero points."""
        return values - self._zeros(values)[self._night] if self.zero == "free" else values

    def _residuals(self, run: Any) -> Floats:
        result = super()._residuals(run)
        return np.asarray(result - self._zeros(result)[self._night])

    def predict(self, run: Any) -> Floats:
        """Return the magnitudes (K,) that a run predicts, with the zero points of its nights."""
        return np.asarray(self.magnitude - self.residuals(run))

    def _observed(self, system: SystemLike) -> Floats:
        return self.magnitude[:, None]

    def _covariance(self, system: SystemLike) -> Floats:
        return np.asarray(self.sigma[:, None, None] ** 2)

    def _attach(self, values: Floats, system: SystemLike) -> Floats:
        return values[:, 0]

    def _widen(self, jitter: Any) -> None:
        self.sigma = np.hypot(self.sigma, jitter_of(jitter, "mag"))

    def _photometer(self, system: SystemLike) -> Photometer:
        return Photometer(system, self.law, self.albedo, self.mutual, self.sun_radius)

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        retarded = self._retarded(system, states, masses)
        view = self._view(system, states, retarded)
        total = self._total(self._photometer(system).brightness(view))
        return magnitudes(total, view.to_observer, view.to_sun, self.reduced)[:, None]

    def _view(self, system: SystemLike, states: dict[str, Floats], retarded: RetardedStates) -> Epochs:
        """Return what a photometer sees at the observations, after checking that observer and Sun are far enough."""
        attitude = retarded.attitude(states["attitude"], states["spin"])
        local = local_geometry(self.geometry, system)
        to_sun = local.sun(retarded.times)
        for what, position in (("observer", retarded.observer), ("Sun", to_sun)):
            refuse_near(system, local, what, position, retarded.centre, attitude, retarded.times, DISTANT, DISTANT)
        beta = retarded.velocity / retarded.light_speed
        return Epochs(retarded.times, retarded.centre, attitude, retarded.observer, to_sun, beta, local.distant)

    def _total(self, light: Floats) -> Floats:
        total = light.sum(axis=1)
        if not (total > 0.0).all():
            raise InvalidInput(
                f"no light comes from the system at {self.times[np.argmin(total)]}, but a magnitude was observed"
            )
        return np.asarray(total)

    def _partials(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str] = ()
    ) -> tuple[Floats, dict[str, Floats]]:
        """Return derivatives (K, 1, 12 N) of the predictions with respect to the states, and (K, 1) by parameters.

        The photometer gives the derivatives with respect to poses and semi-axes. Let e be the unit vector from a body
        to the observer, u the body's velocity and d its delay. Then c d' = e.(r' + d u' + u d') for a change r' of the
        position, which also changes the time at which the light left.
        """
        retarded = self._retarded(system, states)
        result = self._photometer(system).derivatives(self._view(system, states, retarded))
        factor = -2.5 / np.log(10.0) / self._total(result.brightness)
        position, rotation = (factor[:, None, None] * part.sum(axis=1) for part in (result.position, result.rotation))
        way = retarded.observer[:, None] - retarded.centre
        toward = way / np.linalg.norm(way, axis=-1, keepdims=True)
        later = np.sum(position * retarded.velocity + rotation * states["spin"], axis=-1)
        speed = retarded.light_speed - np.sum(toward * retarded.velocity, axis=-1)
        position = position + toward * (later / speed)[..., None]
        delay, weights = retarded.delay[..., None], (system.context.masses / system.context.masses.sum())[:, None]
        moving, spin = delay * position, delay * rotation
        parts = [
            position - weights * position.sum(axis=1, keepdims=True),
            moving - weights * moving.sum(axis=1, keepdims=True),
            rotation + np.cross(delay * states["spin"], rotation),
            spin,
        ]
        axes: dict[str, Floats] = {
            f"semi-axis {axis} of {body}": factor[:, None] * result.semi_axes.sum(axis=1)[:, position, [k]]
            for position, body in enumerate(system.context.names)
            for k, axis in enumerate("abc")
        }
        # A mass moves the barycentre, relative to which the directions and distances of observer and Sun are given.
        pull = np.einsum("kx,knx->kn", position.sum(axis=1), retarded.centre) / system.context.masses.sum()
        axes |= {f"mass of {body}": -pull[:, [k]] for k, body in enumerate(system.context.names)}
        direct = {name: axes[name] if name in axes else self._partial(system, states, name) for name in parameters}
        return np.concatenate(parts, axis=-1).reshape(len(self), 1, -1), direct

    def _described(self) -> list[tuple[str, str]]:
        return [("nights", str(len(self.nights))), ("zero point", str(self.zero)), ("law", repr(self.law))]


def _nights(times: Any) -> Any:
    """Return labels of nights, which gaps separate, for times in their order."""
    if are_dates(times):
        hours = np.asarray((times - times[0]).to_value("h"))
    elif is_quantity(times):
        hours = times.to_value("h")
    else:
        return np.zeros(len(times), dtype=int)
    return np.concatenate([[0], np.cumsum(np.diff(hours) > _GAP)])
