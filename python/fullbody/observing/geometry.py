"""Directions of the observer and the Sun from a system: from vectors, the sky, orbits, the system and kernels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from ..base.units import Units, as_quantity, is_quantity, numbers
from ..errors import InvalidInput
from ..frames import pole_vector
from ..model.context import SystemLike
from ..orbit.elements import KeplerElements
from . import paths
from .vectors import Vectors


class Geometry(Vectors):
    """Vectors from a system's barycentre to the observer and to the Sun, with a cubic spline between the given times.

    The vector to the observer ends where the observer is at the given time, and begins where the barycentre was when
    the light left it: it is minus the astrometric position of ephemerides, which is corrected for light time but not
    for aberration. The vector to the Sun begins at the same place. In the system's frame of rest, light from a body at
    r arrives after the time abs(d - r)/c, where d is the vector to the observer, so that each body is seen at its own
    time.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        When the light arrives: dates, or times since the epoch of the system that the geometry is used with. Rows
        that are not in the order of time are sorted.
    to_observer : array_like or Quantity, (K, 3) or (3,)
        Vectors from the system's barycentre to the observer. One vector stands for all times.
    to_sun : array_like or Quantity, (K, 3) or (3,), optional
        Vectors from the system's barycentre to the Sun. Without them, the geometry serves only where no Sun is needed.
    frame : str or astropy frame, optional
        The axes of the vectors, by a name of :mod:`fullbody.frames`; those of the system itself unless given.
    light_time : bool
        Whether ``times`` are those at the observer. Otherwise they are times at the system ("less light time"), and
        all bodies are seen as they are at one and the same time.

    Raises
    ------
    InvalidInput
        For vectors of another shape, vectors of length zero, or a time that is given twice.

    Examples
    --------
    >>> import astropy.units as u, numpy as np
    >>> from fullbody import observing
    >>> geometry = observing.Geometry([0.0, 10.0] * u.day, to_observer=[1.0, 0, 0] * u.au, to_sun=[0, 2.0, 0] * u.au)
    >>> round(float(np.degrees(geometry.phase_angle(5 * u.day))), 9)
    90.0
    """

    @classmethod
    def from_radec(
        cls,
        times: Any,
        *,
        ra: Any,
        dec: Any,
        distance: Any,
        to_sun: Any = None,
        frame: Any = "equatorial",
        light_time: bool = True,
    ) -> Geometry:
        """Make the geometry of a system from its position in the sky, as catalogues of observations give it.

        Parameters
        ----------
        times : astropy Time, or array_like or Quantity, (K,)
        ra, dec : array_like or Quantity, (K,)
            Right ascension and declination of the system, or longitude and latitude in ``frame``; radians as floats.
        distance : array_like or Quantity, (K,)
            Distance from the observer to the system's position when the light left it.
        to_sun : array_like or Quantity, (K, 3) or (3,), optional
            Vectors from the system to the Sun, along the axes of ``frame``.
        frame : str or astropy frame
        light_time : bool

        Returns
        -------
        Geometry

        Examples
        --------
        >>> import astropy.units as u
        >>> from fullbody import observing
        >>> sky = {"ra": [1.66, 1.66] * u.hourangle, "dec": [-5.1, -5.1] * u.deg, "distance": [96.3, 96.3] * u.au}
        >>> observing.Geometry.from_radec([0, 1] * u.day, **sky).to_observer(0 * u.day).to("au").round(1)
        <Quantity [-87. , -40.4,   8.6] AU>
        """
        lon, lat = (Units().strip(value, "angle", what) for value, what in ((ra, "ra"), (dec, "dec")))
        length = as_quantity(distance, "distance", "length")
        size = np.asarray(length.value if is_quantity(length) else numbers(length, "distance"), dtype=np.float64)
        try:
            lon, lat, size = np.broadcast_arrays(np.atleast_1d(lon), lat, size)
        except ValueError as error:
            shapes = f"{lon.shape}, {lat.shape} and {size.shape}"
            raise InvalidInput(f"ra, dec and distance have shapes {shapes}; expected (K,) for each") from error
        if lon.ndim != 1 or not (size > 0.0).all():
            raise InvalidInput("distance has values that are not above zero; expected (K,) positive numbers")
        vectors = np.array([pole_vector(a, b) for a, b in zip(lon, lat, strict=True)]) * -size[:, None]
        observer = vectors * length.unit if is_quantity(length) else vectors
        return cls(times, to_observer=observer, to_sun=to_sun, frame=frame, light_time=light_time)

    @classmethod
    def from_orbit(
        cls,
        orbit: KeplerElements[Any],
        epoch: Any,
        *,
        span: Any,
        observer: Any = "earth",
        ephemeris: str = "builtin",
        light_time: bool = True,
    ) -> Geometry:
        """Make the geometry of a system on a Kepler orbit about the Sun.

        Parameters
        ----------
        orbit : KeplerElements
            Heliocentric elements of the system, ``a`` with a unit; in the ecliptic of J2000 or in their own frame.
        epoch : astropy Time or str
            Date to which the mean anomaly of the orbit refers.
        span : astropy Time, or sequence of dates
            Dates of observation; the geometry covers the time from the first to the last of them.
        observer : str or astropy EarthLocation
            ``"earth"`` (its centre), another body that the ephemeris has, or a place on the Earth.
        ephemeris : str
            ``"builtin"`` of astropy, ``"de440"`` and others that it loads, or the path of a JPL file; all but the
            first need the package jplephem.
        light_time : bool

        Returns
        -------
        Geometry
            In the ecliptic of J2000, in km, with rows so dense that the error of the spline is 1e-9 of the distance.

        Notes
        -----
        The Kepler orbit is one about the Sun, which itself moves about the barycentre of the solar system: a distant
        system departs from its osculating orbit by 1e-3 of the distance within some years. Directions are those of
        light in the frame of the solar system's barycentre, without aberration.

        Examples
        --------
        >>> import astropy.units as u, fullbody, numpy as np
        >>> from fullbody import observing
        >>> angles = [angle * u.deg for angle in (3.408, 73.196, 319.319, 225.0)]
        >>> orbit = fullbody.KeplerElements(1.6442 * u.au, 0.3837, *angles)
        >>> geometry = observing.Geometry.from_orbit(orbit, "2022-01-21 TDB", span=["2022-09-01 TDB", "2022-11-01 TDB"])
        >>> geometry.span[1].isot
        '2022-11-01T00:00:00.000'
        """
        return cls._of_table(*paths.from_orbit(orbit, epoch, observer, ephemeris, span, light_time), light_time)

    @classmethod
    def from_system(
        cls,
        system: SystemLike,
        *,
        span: Any,
        sun: str = "Sun",
        observer: Any = "earth",
        ephemeris: str = "builtin",
        light_time: bool = True,
    ) -> Geometry:
        """Make the geometry of a system that has the Sun among its forces.

        Parameters
        ----------
        system : System
            A system with units, an epoch and a frame.
        span : astropy Time, or sequence of dates
            Dates of observation, at which the path of the Sun has to be known.
        sun : str
            The name of the :class:`fullbody.forces.ThirdBody` that is the Sun.
        observer, ephemeris, light_time
            As for :meth:`from_orbit`.

        Returns
        -------
        Geometry
        """
        return cls._of_table(*paths.from_system(system, sun, observer, ephemeris, span, light_time), light_time)

    @classmethod
    def from_spice(
        cls,
        target: int | str,
        *,
        span: Any,
        observer: int | str = "EARTH",
        kernels: Sequence[Any] = (),
        light_time: bool = True,
    ) -> Geometry:
        """Make the geometry of a system from SPICE kernels.

        Parameters
        ----------
        target : int or str
            NAIF's number or name of the system's barycentre.
        span : astropy Time, or sequence of dates
        observer : int or str
            The Earth, another body, or a spacecraft.
        kernels : sequence of paths
            Kernels to load for the call, in addition to those already loaded. They also have to contain the Sun.
        light_time : bool

        Returns
        -------
        Geometry
            In the axes of the ICRF, in km, with rows so dense that the error of the spline is 1e-9 of the distance.
        """
        return cls._of_table(*paths.from_spice(target, observer, kernels, span, light_time), light_time)

    @classmethod
    def _of_table(cls, table: dict[str, Any], ends: tuple[float, float], light_time: bool) -> Self:
        """Make the geometry of a table; ``ends`` are the ends of its span in s since the first row."""
        geometry = cls(**table, light_time=light_time)
        geometry._ends = ends
        return geometry
