"""Relative astrometry: positions of one body in the sky relative to another."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from ..base.arguments import warn_if_degrees
from ..base.kinds import flag
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .columns import DataColumn, column, jitter_of, positive_rows
from .light_centres import photocentre, semi_axes
from .sky import SkyPoints, in_unit, offsets, sky_axes
from .vectors import Vectors, local_geometry


class Astrometry(SkyPoints):
    """Offsets of one body from another in the sky.

    An offset lies in the tangent plane at the body ``about``: along the parallel to the east (right ascension times the
    cosine of the declination), and along the meridian to the north.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times when the light arrived: dates of any scale, or times since the system's epoch.
    east, north : array_like or Quantity, (K,)
        Offsets; plain numbers are radians. Rows with masked or NaN values are left out, with a warning.
    sigma : float, array_like or Quantity, (), (K,) or (K, 2)
        Standard errors of both offsets, or one column for each.
    correlation : float or array_like, (K,)
        Correlation of the errors of the two offsets of a row.
    body, about : int or str
        The observed body and the reference body; indices in the system, or names.
    geometry : Geometry
    frame : str or astropy frame
        The axes of the sky: ``"equatorial"`` (east and north), ``"ecliptic"`` (along longitude and latitude).
    photocentre : bool
        Whether the positions are those of the centres of light of the two bodies, by Lommel-Seeliger's law, instead of
        their centres of mass. Both have to be ellipsoids, spheres or points; the geometry needs the Sun.

    Raises
    ------
    InvalidInput
        For errors that are not above zero, correlations that are not between -1 and 1, and shapes that do not fit.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> view = observing.Geometry([0.0, 12.0] * u.h, to_observer=[0.0, 0.0, 0.08] * u.au, frame="ecliptic")
    >>> times, zero = [1.0, 2.0] * u.h, [0.0, 0.0] * u.mas
    >>> data = observing.Astrometry(times, zero, zero, 1.0 * u.mas, body="Dimorphos", about="Didymos", geometry=view)
    >>> run = system.integrate(state, 3.0, dense=True)
    >>> data.residuals(run).shape, data.residuals(run).unit
    ((2, 2), Unit("mas"))
    """

    _columns = (
        DataColumn("east"),
        DataColumn("north"),
        DataColumn("sigma", parts=("sigma_east", "sigma_north")),
        DataColumn("correlation", required=False, kind="numbers"),
    )
    _options = ("body", "about", "frame")
    _error_names = ("_sigma", "_correlation")
    _names = ("east", "north")

    def __init__(
        self,
        times: Any,
        east: Any,
        north: Any,
        sigma: Any,
        correlation: Any = 0.0,
        *,
        body: int | str = 1,
        about: int | str = 0,
        geometry: Vectors,
        frame: Any = "equatorial",
        photocentre: bool = False,
    ) -> None:
        numbers, unit = column(correlation, "correlation", "")
        if unit is not None and not unit.is_equivalent(""):
            raise InvalidInput(f"correlation has the unit {unit}; expected plain numbers")
        points = {"east": east, "north": north, "sigma": sigma}
        rows = self._read_points(times, points, {"correlation": numbers}, geometry, frame, 2)
        flag(photocentre, "photocentre")
        if photocentre and not geometry.has_sun:
            raise InvalidInput("geometry of Astrometry has no Sun, which photocentre=True needs; give to_sun=")
        self.body, self.about, self.photocentre = body, about, bool(photocentre)
        self._depends_on_figures = self.photocentre
        self._correlation = rows.column("correlation")
        if not (np.abs(self._correlation) < 1.0).all():
            worst = self._correlation[np.argmax(np.abs(self._correlation))]
            raise InvalidInput(f"correlation has the value {worst}; expected numbers between -1 and 1")

    @classmethod
    def from_polar(
        cls, times: Any, separation: Any, position_angle: Any, sigma_separation: Any, sigma_angle: Any, **options: Any
    ) -> Self:
        """Make astrometry from separations and position angles.

        Parameters
        ----------
        times : astropy Time, or array_like or Quantity, (K,)
        separation, position_angle : array_like or Quantity, (K,)
            The angle is measured from north through east; plain numbers are radians.
        sigma_separation, sigma_angle : float, array_like or Quantity, () or (K,)
            Standard errors of the separations and of the angles. Errors of angles above 0.5 rad are refused, since the
            errors in the sky then do not form an ellipse.
        **options
            Arguments of :class:`Astrometry`: ``body``, ``about``, ``geometry`` and ``frame``.

        Returns
        -------
        Astrometry
            Offsets with the covariance that follows from the errors, including their correlation.

        Examples
        --------
        >>> import astropy.units as u, numpy as np
        >>> from fullbody import observing
        >>> view = observing.Geometry([0.0, 12.0] * u.h, to_observer=[0.0, 0.0, 0.08] * u.au)
        >>> angle, errors = [45.0] * u.deg, (1.0 * u.mas, 0.1 * u.rad)
        >>> data = observing.Astrometry.from_polar([1.0] * u.h, [50.0] * u.mas, angle, *errors, geometry=view)
        >>> data.correlation.round(6)
        array([-0.923077])
        """
        rho, unit = column(separation, "separation", "rad")
        angle = column(position_angle, "position_angle", "rad")[0]
        errors = {"sigma_separation": sigma_separation, "sigma_angle": sigma_angle}
        along, tilt = (positive_rows(column(sigma, name, "rad")[0], name) for name, sigma in errors.items())
        warn_if_degrees(position_angle, "position_angle")
        if not (rho > 0.0).all():
            raise InvalidInput("separation has values that are not above zero; expected lengths in the sky")
        if (tilt > 0.5).any():
            raise InvalidInput(f"sigma_angle has the value {tilt.max()} rad; expected errors of at most 0.5 rad")
        try:
            rho, angle, along, tilt = np.broadcast_arrays(rho, angle, along, tilt)
        except ValueError as error:
            shapes = ", ".join(str(column.shape) for column in (rho, angle, along, tilt))
            raise InvalidInput(f"separation, position_angle and their errors have shapes {shapes}") from error
        across = rho * tilt
        sine, cosine = np.sin(angle), np.cos(angle)
        east = np.sqrt((along * sine) ** 2 + (across * cosine) ** 2)
        north = np.sqrt((along * cosine) ** 2 + (across * sine) ** 2)
        correlation = (along**2 - across**2) * sine * cosine / (east * north)
        columns: dict[str, Any] = {"east": rho * sine, "north": rho * cosine, "sigma": np.stack([east, north], axis=-1)}
        if unit is not None:
            columns = {name: in_unit(values, unit) for name, values in columns.items()}
        return cls(times, correlation=correlation, **columns, **options)

    @property
    def correlation(self) -> Floats:
        """Correlation (K,) between the errors of east and north in each row."""
        return self._correlation

    @property
    def covariance(self) -> Any:
        """Covariance (K, 2, 2) of east and north."""
        return in_unit(self._covariance(None), self.unit, 2)

    def _add_jitter(self, jitter: Any) -> None:
        wide = np.hypot(self._sigma, jitter_of(jitter, "rad"))
        self._correlation = self._correlation * np.prod(self._sigma / wide, axis=1)
        self._sigma = wide

    def _covariance(self, system: Any) -> Floats:
        matrix = self._sigma[:, :, None] * self._sigma[:, None, :]
        matrix[:, 0, 1] *= self._correlation
        matrix[:, 1, 0] *= self._correlation
        return matrix

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        axes = sky_axes(system, self.frame, "astrometry")
        body, about = system.context.pair(self.body, self.about, " of Astrometry")
        retarded = self._retarded(system, states, masses)
        centres = {index: retarded.centre[..., index, :] for index in (body, about)}
        if self.photocentre:
            to_sun = local_geometry(self.geometry, system).sun(retarded.times)
            attitude = retarded.attitude(states["attitude"], states["spin"])
            for index, centre in centres.items():
                vectors = retarded.observer - centre, to_sun - centre
                centres[index] = centre + photocentre(semi_axes(system, index), attitude[..., index, :], *vectors)
        line = (centres[about] - retarded.observer) @ axes.T
        return offsets(line, (centres[body] - centres[about]) @ axes.T)
