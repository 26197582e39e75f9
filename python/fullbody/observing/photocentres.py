"""Astrometry of the light of all bodies together, along the scans of a telescope such as Gaia or in both directions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.kinds import choice
from ..base.unit_names import unit_named
from ..base.units import is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .columns import DataColumn, column, labels_of, positive_rows, refuse_rounded
from .heliocentric import ELEMENTS, displacements
from .laws import Law, LommelSeeliger
from .light_centres import centre_of, derivatives, refuse_directions
from .linear import LinearUnknown
from .sky import SkyObservations, in_unit, offsets, sky_axes
from .states import IMAGINARY_STEP
from .sunlit import SunlitObservations, derivatives_by_states
from .vectors import Vectors, local_geometry

_FREE = ("free", None)


class Photocentre(SunlitObservations, SkyObservations):
    """Offsets of the centre of light of all bodies together from the barycentre, in one direction or in two.

    A telescope that scans the sky, such as Gaia, measures well along its scan alone, where the offset is
    east sin(psi) + north cos(psi) with the scan angle psi.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the light arrived.
    offset : array_like or Quantity, (K,) or (K, 2)
        Offsets along the scan, or without ``scan_angle`` to the east and to the north, from the direction of the
        geometry's barycentre; plain numbers are radians. Rows with masked or NaN values are left out, with a warning.
    sigma : float, array_like or Quantity, (), (K,) or (K, 2)
        Standard errors of the offsets, independent of each other.
    scan_angle : float, array_like or Quantity, () or (K,), optional
        The angle from north through east to the scan. Plain numbers are radians and at most two pi in size.
    geometry : Geometry
        A geometry that includes the Sun.
    law, albedo, mutual, sun_radius
        Options of :func:`brightness`.
    frame : str or astropy frame
        The axes of the sky, as for :class:`Astrometry`.
    transit : array_like, (K,), optional
        Labels of the transits, within which the offsets share an error.
    sigma_transit : float, array_like or Quantity, () or (K,), optional
        The standard error that all offsets of a transit have in common.
    group : array_like, (K,), optional
        Labels of groups of transits, each with its own ``position`` and ``drift``; one group without them.
    position : "free", optional
        Whether each group has a free offset of the barycentre to the east and to the north.
    drift : "free", optional
        Whether each group has a free motion of the barycentre to the east and to the north, from the mean of its times.
    orbit : "free", optional
        Whether the six elements of the barycentre's orbit about the Sun have free corrections. They are those in the
        ecliptic at the mean of the times, and small enough to act linearly.

    Raises
    ------
    InvalidInput
        For a geometry without the Sun, errors that are not above zero, a scan angle above two pi without a unit, and
        ``sigma_transit`` without ``transit``. When a run is compared, for a system that gives no light, and for
        positions, drifts and corrections that the data leave undetermined.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Notes
    -----
    Positions, drifts and corrections of elements are linear: wherever a run is compared with the data, they are solved
    for at the least chi2. The derivatives for a fit are exact, but for those of the light and of its first moments with
    respect to the poses of the bodies, which are differenced to about nine digits.

    The scan angle is that of Gaia's catalogues: 0 towards the north, 90 degrees towards the east (Gaia Collaboration,
    Tanga et al. 2023, Astron. Astrophys. 674, A12, doi:10.1051/0004-6361/202243796).

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au, "frame": "ecliptic"}
    >>> geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    >>> times, scan = np.linspace(1.0, 23.0, 9) * u.h, np.linspace(0.0, 300.0, 9) * u.deg
    >>> data = observing.Photocentre(times, np.zeros(9) * u.mas, 0.2 * u.mas, scan_angle=scan, geometry=geometry)
    >>> data.predict(run).shape, data.predict(run).unit
    ((9,), Unit("mas"))
    """

    _columns = (
        DataColumn("offset"),
        DataColumn("sigma"),
        DataColumn("scan_angle", required=False),
        DataColumn("sigma_transit", required=False),
        DataColumn("transit", required=False, kind="labels", named=True),
        DataColumn("group", required=False, kind="labels", named=True),
    )
    _options = ("frame",)
    _quantity = "a photocentre"

    def __init__(
        self,
        times: Any,
        offset: Any,
        sigma: Any,
        *,
        scan_angle: Any = None,
        geometry: Vectors,
        law: Law | dict[str, Law] = LommelSeeliger(),  # noqa: B008
        albedo: Any = 1.0,
        mutual: bool = True,
        sun_radius: Any = 0.0,
        frame: Any = "equatorial",
        transit: Any = None,
        sigma_transit: Any = None,
        group: Any = None,
        position: str | None = None,
        drift: str | None = None,
        orbit: str | None = None,
    ) -> None:
        angles = {"offset": offset, "sigma": sigma}
        angles |= {} if sigma_transit is None else {"sigma_transit": sigma_transit}
        others = {} if scan_angle is None else {"scan_angle": _scan_angles(scan_angle)}
        if (sigma_transit is None) != (transit is None):
            raise InvalidInput(
                "only one of transit and sigma_transit of Photocentre is given; expected both or neither"
            )
        rows, unit = self._read(times, angles, "rad", (), others)
        size = () if scan_angle is not None else (2,)
        shape = rows.columns["offset"].shape
        if len(shape) != 1 + len(size) or shape[1:] != size:
            expected = "(K,), along the scan" if scan_angle is not None else "(K, 2), east and north, or scan_angle="
            raise InvalidInput(f"offset of Photocentre has shape {shape}; expected {expected}")
        super().__init__(rows, geometry)
        self._set_light_options(law, albedo, mutual, sun_radius)
        values, errors = (rows.column(name, *size).reshape(len(self), -1) for name in ("offset", "sigma"))
        refuse_rounded(offset, values.ravel(), errors.ravel(), "offset of Photocentre")
        self._set_angles(values, errors, unit, frame)
        self._scan = None if scan_angle is None else rows.column("scan_angle")
        self._scan_unit = scan_angle.unit if is_quantity(scan_angle) else None
        one_group = np.zeros(len(self), dtype=int)
        #: Names of the transits and of the groups, and the index of each row among them.
        self.transits, self._transit = labels_of(transit, "transit of Photocentre", rows, np.arange(len(self)))
        self.groups, self._group = labels_of(group, "group of Photocentre", rows, one_group)
        self._common = np.zeros(len(self))
        if sigma_transit is not None:
            self._common = positive_rows(rows.column("sigma_transit"), "sigma_transit of Photocentre")
        self.position = choice(position, "position", _FREE)
        self.drift = choice(drift, "drift", _FREE)
        self.orbit = choice(orbit, "orbit", _FREE)

    @property
    def offset(self) -> Any:
        """Offsets (K,) along the scan, or (K, 2) to the east and to the north."""
        return self._attach(self._values, None)

    @property
    def sigma(self) -> Any:
        """Standard errors (K,) or (K, 2) of the offsets, without those of transits."""
        return self._attach(self._sigma, None)

    @property
    def scan_angle(self) -> Any:
        """Scan angles (K,); ``None`` for offsets to the east and to the north."""
        return self._scan if self._scan is None else in_unit(self._scan, self._scan_unit)

    @property
    def _names(self) -> tuple[str, ...]:  # type: ignore[override]
        return ("east", "north") if self._scan is None else ("along the scan",)

    def _column(self, name: str) -> Any:
        has_transits, has_groups = self._common.any(), len(self.groups) > 1
        columns = {
            "transit": self.transits[self._transit] if has_transits else None,
            "sigma_transit": in_unit(self._common, self.unit) if has_transits else None,
            "group": self.groups[self._group] if has_groups else None,
        }
        return columns[name] if name in columns else super()._column(name)

    def _attach(self, values: Floats, system: Any) -> Any:
        return in_unit(values if self._scan is None else values[:, 0], self.unit)

    def _covariance(self, system: SystemLike) -> Floats:
        count, numbers = self._sigma.shape
        if not self._common.any():
            return super()._covariance(system)
        _, first, sizes = np.unique(self._transit, return_index=True, return_counts=True)
        # Transits of equally many rows that follow each other are blocks; otherwise all rows are a single block.
        regular = (sizes == sizes[0]).all() and all(len(set(self._transit[k : k + sizes[0]])) == 1 for k in first)
        size = int(sizes[0]) if regular else count
        transit, common = self._transit.reshape(-1, size), self._common.reshape(-1, size)
        shared = (transit[:, :, None] == transit[:, None]) * common[:, :, None] * common[:, None]
        blocks = np.einsum("bkl,cd->bkcld", shared, np.eye(numbers)).reshape(len(transit), size * numbers, -1)
        return np.asarray(blocks + self._sigma.reshape(len(transit), 1, -1) ** 2 * np.eye(size * numbers))

    def _components(self, sky: Floats) -> Floats:
        """Return the components (K, C, ...) that are observed of vectors (K, 2, ...) to the east and to the north."""
        if self._scan is None:
            return sky
        direction = np.stack([np.sin(self._scan), np.cos(self._scan)], axis=1)
        return np.asarray(np.einsum("kc,kc...->k...", direction, sky)[:, None])

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        axes = sky_axes(system, self.frame, "a photocentre")
        epochs = self._epochs(system, states, self._retarded(system, states, masses))
        refuse_directions(epochs, "a photocentre")
        moments = self._photometer(system).moments(epochs)
        self._total(moments[..., 0])
        centre = centre_of(epochs, moments).centre
        return self._components(offsets(-epochs.to_observer @ axes.T, centre @ axes.T))

    def _partials(
        self, system: SystemLike, states: dict[str, Floats], parameters: Sequence[str] = ()
    ) -> tuple[Floats, dict[str, Floats]]:
        axes = sky_axes(system, self.frame, "a photocentre")
        retarded = self._retarded(system, states)
        epochs = self._epochs(system, states, retarded)
        sizes = np.array([np.mean(body.semi_axes) for body in system.context.bodies])
        sizes = np.where(sizes > 0.0, sizes, sizes.max())
        light, by_position, by_rotation = derivatives(self._photometer(system), epochs, sizes)
        line = -epochs.to_observer @ axes.T
        centre = light.centre @ axes.T
        by_centre = self._components(np.stack([_derivative(line, centre, axis) for axis in axes.T], axis=-1))
        by_state, by_mass = [], []
        for row in np.moveaxis(by_centre, 1, 0):
            chained = (np.einsum("kx,kxny->kny", row, by) for by in (by_position, by_rotation))
            parts = derivatives_by_states(system, states, retarded, *chained)
            by_state.append(parts[0])
            by_mass.append(parts[1])
        known_derivatives = {
            f"mass of {body}": np.stack(by_mass, 1)[:, :, k] for k, body in enumerate(system.context.names)
        }
        return np.stack(by_state, axis=1), self._direct_partials(system, states, parameters, known_derivatives)

    def _linear_unknowns(self, system: SystemLike) -> tuple[LinearUnknown, ...]:
        units = system.context.units
        angle = unit_named("rad") if units.defined else None
        per_time = angle / units.unit("time") if angle is not None else None
        unknowns = []
        for free, what, unit in ((self.position, "position", angle), (self.drift, "drift", per_time)):
            for label in self.groups if free else ():
                of = f" of {label}" if len(self.groups) > 1 else ""
                unknowns += [LinearUnknown(f"{what} {axis}{of}", unit) for axis in ("east", "north")]
        for name, dimension in ELEMENTS.items() if self.orbit else ():
            unit = units.unit("length") if dimension == "length" and units.defined else None
            unknowns.append(LinearUnknown(f"correction of {name}", angle if dimension == "angle" else unit))
        return tuple(unknowns)

    def _design(self, system: SystemLike, states: dict[str, Floats]) -> Floats:
        group = np.eye(len(self.groups))[self._group]
        # The columns of a group are those of the east and of the north, next to each other.
        offsets_of_groups = np.einsum("kg,cd->kcgd", group, np.eye(2)).reshape(len(self), 2, -1)
        columns = [np.zeros((len(self), 2, 0))]
        if self.position:
            columns.append(offsets_of_groups)
        times = self._clock(system)
        if self.drift:
            middle = np.bincount(self._group, times) / np.bincount(self._group)
            columns.append(offsets_of_groups * (times - middle[self._group])[:, None, None])
        if self.orbit:
            local = local_geometry(self.geometry, system)
            axes = sky_axes(system, self.frame, "corrections of the elements")
            line = -local.observer(times) @ axes.T
            changes = displacements(system, local, times)
            columns.append(np.stack([_derivative(line, 0.0, change @ axes.T) for change in changes], axis=-1))
        return self._components(np.concatenate(columns, axis=2))

    def _summary(self) -> list[tuple[str, str]]:
        free = (("position", self.position), ("drift", self.drift), ("orbit", self.orbit))
        direction = "east and north" if self._scan is None else "along the scan"
        options = [(what, str(value)) for what, value in free if value is not None]
        return [("direction", direction), ("transits", str(len(self.transits))), *options, ("law", repr(self.law))]


def _derivative(line: Floats, centre: Any, change: Floats) -> Floats:
    """Return the derivatives (K, 2) of offsets in the sky by changes (K, 3) or (3,) of a centre (K, 3)."""
    return np.asarray(offsets(line, centre + 1j * IMAGINARY_STEP * change).imag / IMAGINARY_STEP)


def _scan_angles(scan_angle: Any) -> Floats:
    """Return scan angles in radians; those without a unit are at most two pi in size."""
    radians, unit = column(scan_angle, "scan_angle of Photocentre", "rad")
    if unit is None and (largest := np.nanmax(np.abs(radians), initial=0.0)) > 2.0 * np.pi:
        raise InvalidInput(
            f"scan_angle of Photocentre has the value {largest:.6g} without a unit; expected radians up to 2 pi in "
            f"size, or degrees as a Quantity, such as {largest:.6g} * u.deg"
        )
    return radians
