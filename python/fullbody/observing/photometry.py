"""Photometry: observed magnitudes of all bodies of a system together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.foreign import are_dates
from ..base.kinds import choice, flag, instance
from ..base.limits import Limits
from ..base.units import UNITLESS, is_quantity
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .brightness import phase_angle
from .columns import DataColumn, column, labels_of, positive_rows
from .laws import Law, LommelSeeliger
from .light_curve import magnitudes
from .linear import LinearUnknown
from .predictions import DesignArgument
from .series import RotationSeries, rotation_angle
from .sunlit import SunlitObservations, derivatives_by_states
from .times import exposure_rule
from .vectors import Vectors, local_geometry

#: The length of a gap, in hours, that separates two nights.
_GAP = 8.0


class Photometry(SunlitObservations):
    """Magnitudes of all bodies of a system together, unresolved in the sky.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the light arrived.
    magnitude : array_like or Quantity, (K,)
        Rows with masked or NaN values are left out, with a warning.
    sigma : float, array_like or Quantity, () or (K,)
        Standard errors in magnitudes.
    geometry : Geometry
        A geometry that includes the Sun.
    law, albedo, mutual, sun_radius
        Options of :func:`brightness`.
    zero : "free" or float
        The zero point, which is added to the magnitudes of :func:`light_curve`. With ``"free"`` each night has its own,
        or each ``filter``.
    night : array_like, (K,), optional
        Labels of the nights. Without them a night ends with a gap of more than eight hours; times that are plain
        numbers are one night.
    filter : array_like, (K,), optional
        Names of the filters of calibrated magnitudes, as in sparse photometry. Free zero points then belong to filters
        instead of nights, and data sets that have a filter in common share its zero point.
    airmass : array_like, (K,), optional
        Airmasses. With them each night has a free slope in airmass, its extinction.
    drift : "free", optional
        Whether each night has a free slope in time, in magnitudes per unit of time, from the mean of its times.
    phase_slope : "free", optional
        Whether the magnitudes have a free slope in the phase angle, per radian, one for all nights.
    rotation : RotationSeries, optional
        A free Fourier series in the rotation angle of a body.
    exposure : float or Quantity
        The time of integration about each of the times, over which the brightness is averaged by five values, with
        bodies that go on straight and rotate uniformly.
    reduced : bool
        Whether the magnitudes are reduced to unit distances from the observer and from the Sun.

    Raises
    ------
    InvalidInput
        For a geometry without the Sun, errors that are not above zero, and an unknown kind of zero point. When a run is
        compared, for free slopes, series and zero points that the data leave undetermined, such as a slope in airmass
        of a night with one airmass.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Notes
    -----
    Free zero points, slopes and series are linear in magnitudes: wherever a run is compared with the
    data, they are solved for at the least chi2, and a fit of other parameters takes no iterations for them.

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

    _columns = (
        DataColumn("magnitude"),
        DataColumn("sigma"),
        DataColumn("night", required=False, kind="labels", named=True),
        DataColumn("filter", required=False, kind="labels", named=True),
        DataColumn("airmass", required=False, kind="numbers", named=True),
    )
    _options = ("zero",)
    _error_unit = "mag"
    _names = ("magnitude",)

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
        filter: Any = None,
        airmass: Any = None,
        drift: str | None = None,
        phase_slope: str | None = None,
        rotation: RotationSeries | None = None,
        exposure: Any = 0.0,
        reduced: bool = True,
    ) -> None:
        numbers = {} if airmass is None else {"airmass": column(airmass, "airmass", "")[0]}
        columns = {"magnitude": magnitude, "sigma": sigma}
        rows, _ = self._read(times, columns, "mag", ("magnitude",), numbers, mixed=True)
        super().__init__(rows, geometry)
        self._set_light_options(law, albedo, mutual, sun_radius)
        self.magnitude = rows.column("magnitude")
        self._sigma = positive_rows(rows.column("sigma"), "sigma of Photometry")
        self.reduced, self.exposure = reduced, exposure
        flag(reduced, "reduced")
        if not (isinstance(zero, str) and zero == "free"):
            UNITLESS.number(zero, "number", "zero", Limits(text="'free' or a finite number"))
        self.zero = zero
        self.airmass = None if airmass is None else rows.column("airmass")
        self.drift = choice(drift, "drift", ("free", None))
        self.phase_slope = choice(phase_slope, "phase_slope", ("free", None))
        if rotation is not None:
            instance(rotation, "rotation", RotationSeries, "a RotationSeries")
        self.rotation = rotation
        #: Names of the nights, and the index of each row's night among them; those of the filters, if they are given.
        self.nights, self._night = labels_of(night, "night", rows, _nights(self.times))
        self.filters, self._filter = None, self._night
        if filter is not None and any(label is not None for label in np.ravel(filter)):
            self.filters, self._filter = labels_of(filter, "filter", rows, _nights(self.times))

    @property
    def sigma(self) -> Floats:
        """Standard errors (K,) in magnitudes."""
        return np.asarray(self._sigma)

    def _column(self, name: str) -> Any:
        if name == "night":
            return self.nights[self._night]
        if name == "filter":
            return None if self.filters is None else self.filters[self._filter]
        return super()._column(name)

    def zero_points(self, run: Record) -> Floats:
        """Compute the zero point of each of ``filters`` for a run, or without filters of each of ``nights``.

        Parameters
        ----------
        run : Run
            A run as for :meth:`Observations.predict`.

        Returns
        -------
        ndarray, (number of filters or nights,)
            Zero points in magnitudes.
        """
        count = len(self._zero_labels)
        if self.zero != "free":
            return np.full(count, float(self.zero))
        return np.array(list(self.linear_values(run).values())[:count])

    @property
    def _zero_labels(self) -> Any:
        return self.nights if self.filters is None else self.filters

    def _linear_unknowns(self, system: SystemLike) -> tuple[LinearUnknown, ...]:
        shared, labels = self.filters is not None, self._zero_labels if self.zero == "free" else ()
        unknowns = [LinearUnknown(f"zero point of {label}", shared=shared) for label in labels]
        if self.airmass is not None:
            unknowns += [LinearUnknown(f"airmass slope of {night}") for night in self.nights]
        if self.drift is not None:
            units = system.context.units
            per_time = units.unit("time") ** -1 if units.defined else None
            unknowns += [LinearUnknown(f"drift of {night}", per_time) for night in self.nights]
        if self.phase_slope is not None:
            unknowns.append(LinearUnknown("phase slope"))
        if self.rotation is not None:
            name = system.context.names[system.context.index(self.rotation.body, "body of RotationSeries")]
            unknowns += [LinearUnknown(coefficient, shared=True) for coefficient in self.rotation.names(name)]
        return tuple(unknowns)

    def _design(self, system: SystemLike, states: dict[str, Floats]) -> Floats:
        night = np.eye(len(self.nights))[self._night]
        columns = [np.eye(len(self._zero_labels))[self._filter]] if self.zero == "free" else []
        if self.airmass is not None:
            columns.append(night * self.airmass[:, None])
        if self.drift is not None:
            times = self._clock(system)
            middle = np.bincount(self._night, times) / np.bincount(self._night)
            columns.append(night * (times - middle[self._night])[:, None])
        if self.phase_slope is not None:
            columns.append(phase_angle(*self._directions(system))[:, None])
        if self.rotation is not None:
            columns.append(self.rotation.terms(self._rotation_angle(system, states)[0])[0])
        return np.concatenate(columns, axis=1)[:, None] if columns else np.zeros((len(self), 1, 0))

    def _directions(self, system: SystemLike) -> tuple[Floats, Floats]:
        """Return unit vectors (K, 3) from the barycentre to the observer and to the Sun."""
        local, times = local_geometry(self.geometry, system), self._clock(system)
        vectors = local.observer(times), local.sun(times)
        to_observer, to_sun = (vector / np.linalg.norm(vector, axis=1, keepdims=True) for vector in vectors)
        return to_observer, to_sun

    def _rotation_angle(self, system: SystemLike, states: dict[str, Floats]) -> tuple[Floats, Floats]:
        """Return the rotation angle (K,) of the series' body, and its derivatives (K, 3) by the body's rotation."""
        assert self.rotation is not None
        body = system.context.index(self.rotation.body, "body of RotationSeries")
        retarded = self._retarded(system, states)
        attitude = retarded.attitude(states["attitude"], states["spin"])
        bisector = np.sum(self._directions(system), axis=0)
        bisector /= np.linalg.norm(bisector, axis=1, keepdims=True)
        return rotation_angle(system.context.names[body], attitude[:, body], states["spin"][:, body], bisector)

    def _design_arguments(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str]
    ) -> list[DesignArgument]:
        if self.rotation is None:
            return []
        angle, by_rotation = self._rotation_angle(system, states)
        rotation = np.zeros_like(states["spin"])
        rotation[:, system.context.index(self.rotation.body, "body of RotationSeries")] = by_rotation
        by_state, by_mass = derivatives_by_states(
            system, states, self._retarded(system, states), 0.0 * rotation, rotation
        )
        slope = np.zeros((len(self), 1, len(self._linear_unknowns(system))))
        slope[:, 0, -2 * self.rotation.order :] = self.rotation.terms(angle)[1]
        masses = {f"mass of {body}": by_mass[:, [k]] for k, body in enumerate(system.context.names)}
        direct = {name: masses.get(name, np.zeros((len(self), 1))) for name in parameters}
        return [DesignArgument(slope, by_state[:, None], direct)]

    def _observed(self, system: SystemLike) -> Floats:
        return self.magnitude[:, None]

    def _attach(self, values: Floats, system: SystemLike) -> Floats:
        return values[:, 0]

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        photometer, light = self._photometer(system), np.zeros((len(self), len(system.context)))
        for time, weight in exposure_rule(self.exposure, system):
            epochs = self._epochs(system, states, self._retarded(system, states, masses, time))
            light += weight * photometer.brightness(epochs)
        zero = 0.0 if self.zero == "free" else float(self.zero)
        local, times = local_geometry(self.geometry, system), self._clock(system)
        return magnitudes(self._total(light), local.observer(times), local.sun(times), self.reduced)[:, None] + zero

    def _partials(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str] = ()
    ) -> tuple[Floats, dict[str, Floats]]:
        """Return derivatives (K, 1, 12 N) of the predictions with respect to the states, and (K, 1) by parameters.

        The photometer gives the derivatives with respect to poses, semi-axes and surfaces.
        """
        deformations = {
            name: system.context.deformations[name] for name in parameters if name in system.context.deformations
        }
        photometer, count = self._photometer(system), len(system.context)
        light, by_axes = np.zeros((len(self), count)), np.zeros((len(self), count, 3))
        by_state, by_mass = np.zeros((len(self), 12 * count)), np.zeros((len(self), count))
        by_surfaces = np.zeros((len(self), len(deformations)))
        for time, weight in exposure_rule(self.exposure, system):
            retarded = self._retarded(system, states, None, time)
            result = photometer.derivatives(self._epochs(system, states, retarded), bool(deformations))
            position, rotation = (weight * part.sum(axis=1) for part in (result.position, result.rotation))
            of_state, of_mass = derivatives_by_states(system, states, retarded, position, rotation)
            light += weight * result.brightness
            by_state += of_state
            by_mass += of_mass
            by_axes += weight * result.semi_axes.sum(axis=1)
            if deformations:
                by_surfaces += weight * result.along(list(deformations.values()))
        factor = -2.5 / np.log(10.0) / self._total(light)
        by_state, by_mass = factor[:, None] * by_state, factor[:, None] * by_mass
        known_derivatives: dict[str, Floats] = {
            f"semi-axis {axis} of {body}": factor[:, None] * by_axes[:, index, [k]]
            for index, body in enumerate(system.context.names)
            for k, axis in enumerate("abc")
        }
        known_derivatives |= {f"mass of {body}": by_mass[:, [k]] for k, body in enumerate(system.context.names)}
        known_derivatives |= {name: factor[:, None] * by_surfaces[:, [d]] for d, name in enumerate(deformations)}
        return by_state[:, None], self._direct_partials(system, states, parameters, known_derivatives)

    def _summary(self) -> list[tuple[str, str]]:
        free = [("drift", self.drift), ("phase slope", self.phase_slope), ("rotation", self.rotation)]
        free += [("airmass slope", None if self.airmass is None else "free")]
        options = [(what, str(value)) for what, value in free if value is not None]
        return [("nights", str(len(self.nights))), ("zero point", str(self.zero)), *options, ("law", repr(self.law))]


def _nights(times: Any) -> Any:
    """Return the label of the night of each of the sorted times; gaps separate nights."""
    if are_dates(times):
        hours = np.asarray((times - times[0]).to_value("h"))
    elif is_quantity(times):
        hours = times.to_value("h")
    else:
        return np.zeros(len(times), dtype=int)
    return np.concatenate([[0], np.cumsum(np.diff(hours) > _GAP)])
