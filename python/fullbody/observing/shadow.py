"""Paths of the shadows of bodies in starlight over the Earth, for those who plan to watch an occultation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.figures import LINES, grid, legend, single
from ..base.kinds import instance, whole_number
from ..base.unit_names import unit_named
from ..base.units import as_quantity, is_quantity, strip_to
from ..errors import InvalidInput, interruptible
from ..record.record import Record
from ..typing import Floats
from .earth import Earth
from .event_tables import table_of, time_column
from .limbs import Limb, limbs_of
from .sightlines import Sight, SightLines
from .sky import east_and_north, pole_of
from .star import Star
from .states import into_body
from .times import kilometres, seconds
from .vectors import Vectors

#: The semi-axes of the Earth's ellipsoid (WGS84) in km.
_EARTH = np.array([6378.137, 6378.137, 6356.752314245])
#: The number of samples in which the time is found at which a shadow is on the Earth.
_SAMPLES = 721
#: The iterations of the light time within the Earth, each of which gains the digits of c over the speed.
_ITERATIONS = 3
_WHAT = "the path of a shadow on the Earth"
#: The lines of a path, with the factors of the half width and of the error.
_PATHS = {
    "centre": (0.0, 0.0),
    "north": (1.0, 0.0),
    "south": (-1.0, 0.0),
    "error_north": (1.0, 1.0),
    "error_south": (-1.0, -1.0),
}


@dataclass(frozen=True, eq=False, repr=False)
class ShadowPath:
    """The path of a body's shadow over the Earth during one occultation, at K times.

    Attributes
    ----------
    body : str
    times : list of Quantity
        Times on the system's clock.
    longitude, latitude : dict of masked array, (K,)
        Geodetic coordinates in degrees, masked where a line misses the Earth. The keys are ``"centre"``, the limits
        ``"north"`` and ``"south"``, and with errors ``"error_north"`` and ``"error_south"``, the limits moved outwards.
    duration : ndarray, (K,)
        The longest duration of the occultation on the central line, in s.
    star_altitude, sun_altitude : masked array, (K,)
        Altitudes in degrees on the central line.
    """

    body: str
    times: list[Any]
    longitude: dict[str, Any]
    latitude: dict[str, Any]
    duration: Floats
    star_altitude: Any
    sun_altitude: Any
    system: Any

    def to_table(self) -> Any:
        """Return an astropy ``QTable`` with a row for each time, for a planner.

        It has the columns ``time`` (UTC), ``longitude`` and ``latitude`` of the central line, those of the limits with
        the suffixes ``_north`` and ``_south`` (and ``_error_north``, ``_error_south``), ``duration``,
        ``star_altitude`` and ``sun_altitude``. What is not on the Earth is masked.
        """
        table = table_of({"time": time_column(self.times, self.system)})
        from astropy.table import MaskedColumn

        for name in self.longitude:
            suffix = "" if name == "centre" else f"_{name}"
            for what, lines in (("longitude", self.longitude), ("latitude", self.latitude)):
                table[f"{what}{suffix}"] = MaskedColumn(lines[name], unit="deg")
        table["duration"] = self.duration * unit_named("s")
        for what in ("star_altitude", "sun_altitude"):
            table[what] = MaskedColumn(getattr(self, what), unit="deg")
        return table

    def plot(self, ax: Any = None, *, stations: Any = None, color: Any = None) -> Any:
        """Draw the path in longitude and latitude: its limits, its central line and the band of its errors.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        stations : EarthLocation, optional
            Stations to mark.
        color : colour of matplotlib, optional
            The colour of limits and errors.

        Returns
        -------
        matplotlib Axes
        """
        ax = single(ax, (7.0, 4.5))
        color = LINES[0]["color"] if color is None else color

        def label(text: str) -> str | None:
            return None if text in ax.get_legend_handles_labels()[1] else text

        for inner in ("north", "south") if "error_north" in self.longitude else ():
            self._draw(ax, f"error_{inner}", color=color, linestyle=":", linewidth=1.0)
            self._fill(ax, inner, color=color, alpha=0.2, label=label("errors"))
        for name in ("north", "south"):
            self._draw(ax, name, color=color, linewidth=1.2, label=label(f"limits of {self.body}"))
        self._draw(ax, "centre", color=color, linestyle="--", linewidth=1.2)
        if stations is not None:
            geodetic = stations.to_geodetic("WGS84")
            ax.plot(geodetic.lon.deg, geodetic.lat.deg, "^", color=LINES[4]["color"], markersize=4.0, label="stations")
        grid(ax)
        ax.set_xlabel("longitude, east [deg]")
        ax.set_ylabel("latitude [deg]")
        legend(ax, markerscale=1.0)
        return ax

    def _draw(self, ax: Any, name: str, **kwargs: Any) -> None:
        """Draw a line, which is cut where it leaves the Earth or crosses the meridian of 180 degrees."""
        longitude, latitude = self.longitude[name], self.latitude[name]
        jumps = np.flatnonzero(np.abs(np.diff(longitude.filled(0.0))) > 180.0) + 1
        ax.plot(
            np.insert(longitude.filled(np.nan), jumps, np.nan),
            np.insert(latitude.filled(np.nan), jumps, np.nan),
            **kwargs,
        )

    def _fill(self, ax: Any, name: str, **kwargs: Any) -> None:
        """Fill the band between a limit and that with its error, unless it crosses the meridian of 180 degrees."""
        pairs = [(self.longitude[line], self.latitude[line]) for line in (name, f"error_{name}")]
        both = ~(pairs[0][0].mask | pairs[1][0].mask)
        sides = [(np.asarray(x)[both], np.asarray(y)[both]) for x, y in pairs]
        if all(np.abs(np.diff(x)).max(initial=0.0) < 180.0 for x, _ in sides):
            ax.fill(
                *(np.concatenate([inner, outer[::-1]]) for inner, outer in zip(*sides, strict=True)),
                linewidth=0.0,
                **kwargs,
            )

    def __repr__(self) -> str:
        return f"ShadowPath({self.body}, {len(self.times)} times from {self.times[0]} to {self.times[-1]})"


@interruptible("a search for shadows")
def shadow_paths(
    run: Record, star: Any, geometry: Vectors, span: Any = None, *, errors: Any = None, n: int = 121
) -> list[ShadowPath]:
    """Find the paths of the shadows of the bodies of a run over the Earth in the light of a star.

    Parameters
    ----------
    run : Run
        A run with ``dense=True`` of a system with units, an epoch and a frame.
    star : SkyCoord, (ra, dec) or array_like (3,)
        As for :func:`occultation_chords`.
    geometry : Geometry
        A geometry from the centre of the Earth.
    span : pair of times, optional
        As for :func:`occultation_chords`.
    errors : Quantity, () or (2, 2), optional
        The standard error of the offset of ephemeris and star, an angle, or the covariance of its components to the
        east and to the north, an angle squared, as a fit has it.
    n : int
        The number of times of a path.

    Returns
    -------
    list of ShadowPath
        In the order of bodies and times; empty if no shadow meets the Earth.

    Raises
    ------
    InvalidInput
        As for :func:`occultation_chords`, and for errors that are no angles.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> system = system.with_options(epoch="2024-03-01 TDB", frame="ecliptic")
    >>> run = system.integrate(state, "1 h", dense=True)
    >>> path = {"to_observer": [[1e7, -2e4, 500.0], [1e7, 3e4, 600.0]] * u.km, "frame": "ecliptic"}
    >>> geometry = observing.Geometry([0.0, 3000.0] * u.s, **path)
    >>> shadow = observing.shadow_paths(run, [-1.0, 0.0, 0.0], geometry, n=5)[0]
    >>> shadow.body, shadow.to_table().colnames[:3]
    ('Didymos', ['time', 'longitude', 'latitude'])
    """
    instance(geometry, "geometry", Vectors, "an observing.Geometry")
    whole_number(n, "n", 2)
    source = Star(star, geometry)
    lines = SightLines(run, geometry, source, None)
    first, last = lines.span(span)
    lines.refuse_inside(np.linspace(first, last, 64))
    covariance = _covariance(errors)
    shadows = []
    for body in range(len(run.context)):
        if not (limbs := limbs_of(run.system, body)):
            continue
        radius = _EARTH[0] / kilometres(run.system, _WHAT) + max(limb.radius for limb in limbs)
        shadow = _Shadow(lines, body, limbs, covariance)
        for encounter in lines.encounters(body, (first, last), radius):
            times = np.linspace(*encounter, _SAMPLES)
            on_earth = np.flatnonzero(shadow.is_on_earth(times))
            if on_earth.size:
                begin, end = times[max(on_earth[0] - 1, 0)], times[min(on_earth[-1] + 1, _SAMPLES - 1)]
                shadows.append(shadow.path(np.linspace(begin, end, n)))
    return shadows


def _covariance(errors: Any) -> Floats | None:
    """Return the covariance (2, 2) of the offset in squared radians."""
    if errors is None:
        return None
    errors = as_quantity(errors, "errors", "angle")
    expected = "expected an angle as a Quantity, or a covariance (2, 2) in an angle squared"
    if not is_quantity(errors) or np.shape(errors) not in ((), (2, 2)):
        raise InvalidInput(f"errors is {errors!r}; {expected}")
    power = 1 if np.shape(errors) == () else 2
    radians = strip_to(errors, unit_named("rad") ** power, "errors")
    matrix = radians**2 * np.eye(2) if power == 1 else radians
    if not (np.linalg.eigvalsh(matrix) >= 0.0).all() or not np.isfinite(matrix).all():
        raise InvalidInput(f"errors is {errors!r}, which is no covariance; {expected}")
    return matrix


class _Shadow:
    """The shadow of a body, of which lines parallel to its path are followed."""

    def __init__(self, lines: SightLines, body: int, limbs: list[Limb], covariance: Floats | None) -> None:
        self._lines, self._body, self._limbs, self._covariance = lines, body, limbs, covariance
        self._system, self._pole = lines.system, pole_of(lines.system)
        self._km = kilometres(lines.system, _WHAT)
        self._earth = Earth(lines.delayed)

    def _track(self, times: Floats) -> tuple[Sight, Floats, Floats]:
        """Return lines of sight, their velocities, and unit vectors (M, 3) perpendicular to the path to the north."""
        sight = self._lines.past(self._body, times)
        velocity = self._rate(lambda moments: self._lines.past(self._body, moments).w, times)
        across = np.cross(sight.u, velocity / np.linalg.norm(velocity, axis=1, keepdims=True))
        return sight, velocity, np.where((across @ self._pole)[:, None] < 0.0, -across, across)

    @staticmethod
    def _rate(function: Callable[[Floats], Floats], times: Floats) -> Floats:
        """Return the rate of change (M, ...) of a function at times (M,), a difference."""
        step = float(1e-3 * (times[-1] - times[0]))
        return np.asarray((function(times + step) - function(times - step)) / (2.0 * step))

    def _extent(self, sight: Sight, directions: Floats) -> Floats:
        """Return how far (M,) the body reaches along unit vectors (M, 3) of the system's axes."""
        normals = into_body(sight.attitude, directions)
        return np.asarray(np.max([limb.extent(normals) for limb in self._limbs], axis=0))

    def is_on_earth(self, times: Floats) -> Any:
        """Return at which times (M,) the shadow touches the Earth."""
        sight, _, across = self._track(times)
        lines = [-sight.w]
        lines += [sign * self._extent(sight, sign * across)[:, None] * across - sight.w for sign in (1.0, -1.0)]
        return np.any([self._ground(times, sight.u, line)[1] for line in lines], axis=0)

    def path(self, times: Floats) -> ShadowPath:
        """Return the path at times."""
        sight, velocity, across = self._track(times)
        error = self._error(times, sight.u, across)
        longitude: dict[str, Any] = {}
        latitude: dict[str, Any] = {}
        axes = self._earth.axes(self._system, times)
        ground, on_earth = self._ground(times, sight.u, -sight.w)
        for name, (side, outwards) in _PATHS.items():
            if outwards and error is None:
                continue
            offset = side * self._extent(sight, np.copysign(1.0, side) * across)
            offset = offset + (0.0 if error is None else outwards * error)
            points = self._ground(times, sight.u, offset[:, None] * across - sight.w)
            longitude[name], latitude[name] = _geodetic(*points)
        up = np.einsum("kij,kj->ki", axes, ground / _EARTH**2)
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        star, sun = (
            np.ma.array(np.degrees(np.arcsin(np.clip(np.sum(up * toward, axis=1), -1.0, 1.0))), mask=~on_earth)
            for toward in (sight.u, self._earth.sunward(self._system, times))
        )
        units, name = self._system.context.units, self._system.context.names[self._body]
        attached = [units.attach(float(time), "time") for time in times]
        duration = self._duration(times, sight, velocity, ground)
        return ShadowPath(name, attached, longitude, latitude, duration, star, sun, self._system)

    def _error(self, times: Floats, u: Floats, across: Floats) -> Floats | None:
        """Return the standard error (M,) of the path perpendicular to it."""
        if self._covariance is None:
            return None
        components = np.einsum("kax,kx->ka", east_and_north(u, self._pole), across)
        distance = np.linalg.norm(self._lines.local.observer(times), axis=1)
        variance = np.einsum("ka,ab,kb->k", components, self._covariance, components)
        return np.asarray(distance * np.sqrt(np.maximum(variance, 0.0)))

    def _duration(self, times: Floats, sight: Sight, velocity: Floats, ground: Floats) -> Floats:
        """Return the time (M,) in s in which the shadow passes over a point of its central line, which moves with the
        Earth.
        """
        axes_rate = self._rate(lambda moments: self._earth.axes(self._system, moments), times)
        rotation = np.einsum("kij,kj->ki", axes_rate, ground) / self._km
        relative = velocity + np.where(np.isfinite(rotation), rotation, 0.0)
        relative -= np.sum(relative * sight.u, axis=1)[:, None] * sight.u
        speed = np.linalg.norm(relative, axis=1)
        along = relative / speed[:, None]
        length = self._extent(sight, along) + self._extent(sight, -along)
        return np.asarray(length / speed * seconds(self._system, _WHAT))

    def _ground(self, times: Floats, u: Floats, lines: Floats) -> tuple[Floats, Any]:
        """Return points (M, 3) in km, in the frame of the Earth, where lines along u meet it, and which lines do."""
        axes = self._earth.axes(self._system, times)
        rate = self._lines.local.observer_velocity(times)
        depth = np.zeros(len(times))
        for _ in range(_ITERATIONS):
            offset = lines + depth[:, None] * u
            point = 2.0 * offset - self._earth.retarded(self._system, times, offset, rate, u)
            point = point - np.sum(point * u, axis=1)[:, None] * u
            p, q = (np.einsum("kji,kj->ki", axes, v) * size / _EARTH for v, size in ((point, self._km), (u, 1.0)))
            a, b, c = np.sum(q * q, axis=1), np.sum(p * q, axis=1), np.sum(p * p, axis=1) - 1.0
            discriminant = b * b - a * c
            depth = (-b + np.sqrt(np.maximum(discriminant, 0.0))) / a / self._km
        return np.einsum("kji,kj->ki", axes, point + depth[:, None] * u) * self._km, discriminant >= 0.0


def _geodetic(ground: Floats, on_earth: Any) -> tuple[Any, Any]:
    """Return longitudes and latitudes (M,) in degrees of points (M, 3) in km, masked where a line misses the Earth."""
    from astropy.coordinates import EarthLocation

    points = np.where(on_earth[:, None], ground, _EARTH)
    location = EarthLocation.from_geocentric(*points.T, unit="km").to_geodetic("WGS84")
    return np.ma.array(location.lon.deg, mask=~on_earth), np.ma.array(location.lat.deg, mask=~on_earth)
