"""Relative astrometry: positions of one body in the sky relative to another."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from ..base.arguments import warn_if_degrees
from ..base.kinds import flag
from ..errors import InvalidInput, caution
from ..model.context import SystemLike
from ..typing import Floats
from .centre_of_light import photocentre, semi_axes
from .columns import DataColumn, Rows, column, jitter_of, positive_rows, refuse_rounded
from .data import Observations
from .vectors import Vectors, local_geometry, turn

#: The largest offset, a degree in radians, that causes no warning if it is a plain number.
_WIDEST = np.pi / 180.0


class Astrometry(Observations):
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
        values = {"east": east, "north": north, "sigma": sigma}
        given = {name: column(value, name, "rad") for name, value in values.items()}
        plain = [name for name, (_, unit) in given.items() if unit is None]
        if plain and len(plain) < 3:
            raise InvalidInput(
                f"{plain[0]} has no unit, but others of east, north and sigma have; expected all or none"
            )
        numbers = {name: part for name, (part, _) in given.items()}
        for name in ("east", "north"):
            refuse_rounded(values[name], numbers[name], numbers["sigma"], f"{name} of Astrometry")
        numbers["correlation"], without = column(correlation, "correlation", "")
        if without is not None and not without.is_equivalent(""):
            raise InvalidInput(f"correlation has the unit {without}; expected plain numbers")
        rows = Rows(times, numbers, ("east", "north"), "Astrometry")
        super().__init__(rows, geometry)
        self.unit = given["east"][1]
        flag(photocentre, "photocentre")
        if photocentre and not geometry.has_sun:
            raise InvalidInput("geometry of Astrometry has no Sun, which photocentre=True needs; give to_sun=")
        self.body, self.about, self.frame, self.photocentre = body, about, frame, bool(photocentre)
        self._offsets = np.stack([rows.of("east"), rows.of("north")], axis=1)
        if plain:
            warn_if_wide(self._offsets, "the offsets of Astrometry")
        self._sigma = positive_rows(rows.of("sigma", 2), "sigma of Astrometry")
        self._correlation = rows.of("correlation")
        if not (np.abs(self._correlation) < 1.0).all():
            worst = self._correlation[np.argmax(np.abs(self._correlation))]
            raise InvalidInput(f"correlation has the value {worst}; expected numbers between -1 and 1")
        turn("equatorial", frame)

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
        along, turn = (positive_rows(column(sigma, name, "rad")[0], name) for name, sigma in errors.items())
        warn_if_degrees(position_angle, "position_angle")
        if not (rho > 0.0).all():
            raise InvalidInput("separation has values that are not above zero; expected lengths in the sky")
        if (turn > 0.5).any():
            raise InvalidInput(f"sigma_angle has the value {turn.max()} rad; expected errors of at most 0.5 rad")
        try:
            rho, angle, along, turn = np.broadcast_arrays(rho, angle, along, turn)
        except ValueError as error:
            shapes = ", ".join(str(one.shape) for one in (rho, angle, along, turn))
            raise InvalidInput(f"separation, position_angle and their errors have shapes {shapes}") from error
        across = rho * turn
        sine, cosine = np.sin(angle), np.cos(angle)
        east = np.sqrt((along * sine) ** 2 + (across * cosine) ** 2)
        north = np.sqrt((along * cosine) ** 2 + (across * sine) ** 2)
        correlation = (along**2 - across**2) * sine * cosine / (east * north)
        columns: dict[str, Any] = {"east": rho * sine, "north": rho * cosine, "sigma": np.stack([east, north], axis=-1)}
        if unit is not None:
            columns = {name: in_unit(values, unit) for name, values in columns.items()}
        return cls(times, correlation=correlation, **columns, **options)

    def _in_table(self) -> tuple[dict[str, Any], dict[str, Any]]:
        columns = {"east": self.east, "north": self.north, "sigma_east": self.sigma[:, 0]}
        columns |= {"sigma_north": self.sigma[:, 1], "correlation": self.correlation}
        return columns, {"body": self.body, "about": self.about, "frame": str(self.frame)}

    @property
    def east(self) -> Any:
        """Offsets (K,) along the parallel to the east."""
        return self._united(self._offsets[:, 0])

    @property
    def north(self) -> Any:
        """Offsets (K,) along the meridian to the north."""
        return self._united(self._offsets[:, 1])

    @property
    def sigma(self) -> Any:
        """Standard errors (K, 2) of east and north."""
        return self._united(self._sigma)

    @property
    def correlation(self) -> Floats:
        """Correlation (K,) between the errors of east and north in each row."""
        return self._correlation

    @property
    def covariance(self) -> Any:
        """Covariance (K, 2, 2) of east and north."""
        return in_unit(self._covariance(None), self.unit, 2)

    def _united(self, values: Floats) -> Any:
        return in_unit(values, self.unit)

    def _widen(self, jitter: Any) -> None:
        wide = np.hypot(self._sigma, jitter_of(jitter, "rad"))
        self._correlation = self._correlation * np.prod(self._sigma / wide, axis=1)
        self._sigma = wide

    def _covariance(self, system: Any) -> Floats:
        matrix = self._sigma[:, :, None] * self._sigma[:, None, :]
        matrix[:, 0, 1] *= self._correlation
        matrix[:, 1, 0] *= self._correlation
        return matrix

    def _observed(self, system: SystemLike) -> Floats:
        return self._offsets

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return self._united(values)

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        axes = sky_axes(system, self.frame, "astrometry")
        body, about = system.context.pair(self.body, self.about, " of Astrometry")
        retarded = self._retarded(system, states, masses)
        centres = {one: retarded.centre[..., one, :] for one in (body, about)}
        if self.photocentre:
            to_sun = local_geometry(self.geometry, system).sun(retarded.times)
            attitude = retarded.attitude(states["attitude"], states["spin"])
            for one, centre in centres.items():
                ways = retarded.observer - centre, to_sun - centre
                centres[one] = centre + photocentre(semi_axes(system, one), attitude[..., one, :], *ways)
        line = (centres[about] - retarded.observer) @ axes.T
        return offsets(line, (centres[body] - centres[about]) @ axes.T)

    def _depends_on_figures(self) -> bool:
        return self.photocentre

    def _described(self) -> list[tuple[str, str]]:
        return [("body", str(self.body)), ("about", str(self.about)), ("frame", str(self.frame))]


def sky_axes(system: SystemLike, frame: Any, what: str) -> Floats:
    """Return the matrix (3, 3) from a system's axes to those of the sky."""
    if system.context.frame is None:
        raise InvalidInput(f"{what} needs to know the axes of the system; give fullbody.System(..., frame='ecliptic')")
    return turn(system.context.frame, frame)


def warn_if_wide(radians: Floats, what: str) -> None:
    """Warn of offsets in the sky, given as plain numbers, that are too large for radians."""
    largest = float(np.abs(radians).max())
    if largest > _WIDEST:
        caution(
            f"{what} have values up to {largest:.6g} radians, {np.degrees(largest):.3g} degrees; give arc seconds as "
            f"Quantities, such as {largest:.6g} * u.arcsec"
        )


def in_unit(radians: Floats, unit: Any, power: int = 1) -> Any:
    """Return numbers in a power of radians as a Quantity in that power of a unit; unchanged without a unit."""
    if unit is None:
        return radians
    from astropy import units as u

    # The unit may be dimensionless.
    return (radians * u.rad**power).to(unit**power, equivalencies=u.dimensionless_angles())


def offsets(about: Floats, apart: Floats) -> Floats:
    """Return the offsets (K, 2) of bodies on the tangent plane, to the east and to the north.

    The vectors ``about`` (K, 3) go from the observer to the reference body, and ``apart`` (K, 3) from there to the
    other body. The function is analytic and takes complex numbers.
    """
    (x, y, z), (along, across, up) = (np.moveaxis(vectors, -1, 0) for vectors in (about, apart))
    level = np.sqrt(x * x + y * y)
    length = np.sqrt(x * x + y * y + z * z)
    outward = (x * along + y * across) / level
    depth = length + (level * outward + z * up) / length
    return np.stack([(x * across - y * along) / level / depth, (level * up - z * outward) / length / depth], axis=-1)
