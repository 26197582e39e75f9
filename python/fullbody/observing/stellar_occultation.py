"""Stellar occultations: the chords of one event, and their comparison with a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from ..base.figures import unit_of
from ..base.foreign import are_dates
from ..errors import InvalidInput
from ..record.record import Record
from .koala import read_koala
from .occult import read_occult, write_occult
from .pictures import draw_chords
from .predicted_chords import PredictedChords
from .report import Report, read_sodis, reports_of, write_sodis


class StellarOccultation(PredictedChords):
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
        For a reappearance that is not after its disappearance, standard errors that are not above zero, angles without
        a unit, and shapes that do not fit. When a run is compared, for an observer within the system, a star on the
        observer's side of it, and an offset that the data leave undetermined.

    Notes
    -----
    A body hides the star as for :func:`occultation_chords`. Residuals are observed minus predicted times. If the
    predicted chord is shorter than a quarter of the observed one, or than twice the standard error, half its duration
    is continued linearly in its square, also where the body misses the station, so that a fit can return from there.
    A miss has the residual zero unless a body hides the star in the watched interval; then it is minus the time in
    which the line of sight would leave the body by the shortest path.

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
        chords = {"star": star, "stations": stations, "disappearance": disappearance, "reappearance": reappearance}
        chords |= {"sigma": sigma, "geometry": geometry, "body": body, "watched": watched}
        super().__init__(offset, clock, **chords)

    @classmethod
    def read_koala(
        cls, path: Any, *, body: Any = None, event: int | None = None, offset: Any = "free", scale: str = "utc"
    ) -> Self:
        """Read the chords of an event from a file in the format of KOALA, which ADAM reads too.

        Such a file has the vector from the body to the Earth and its rate of change, and for each chord two times,
        their errors in s, and the positions of the station at both times, to the west and to the north in the plane of
        the sky that moves with the shadow.

        Parameters
        ----------
        path : path
        body : str, int or sequence of them, optional
            As for the class.
        event : int, optional
            The index of the event, in a file with several.
        offset : "free" or (east, north)
            As for the class; it counts from the mean of the positions in the file.
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

    @classmethod
    def read_occult(
        cls,
        path: Any,
        *,
        geometry: Any,
        body: Any = None,
        satellite: Any = None,
        event: int | None = None,
        **options: Any,
    ) -> Self:
        """Read the chords of an event from a file of the program Occult, in version 2 of its format in XML.

        The star is that of the file. Times without a standard error have the one that Occult takes for the method and
        the source of time. Times of a second star and of rings, and those that the file excludes, are left out, with a
        warning. Personal equations and adjustments of clocks that a file lists are not applied.

        Parameters
        ----------
        path : path
        geometry : Geometry
            A geometry from the centre of the Earth.
        body, satellite : str or int, optional
            The bodies of chords by the main body and by a satellite.
        event : int, optional
            The index of the event, in a file with several.
        **options
            ``offset`` and ``clock`` of the class.

        Returns
        -------
        StellarOccultation

        Raises
        ------
        InvalidInput
            For a file in another format, and one with several events if none is chosen.
        """
        arguments, kinds = read_occult(path, event)
        bodies = [{"main": body, "satellite": satellite}.get(kind or "") for kind in kinds]
        return cls(geometry=geometry, body=bodies, **arguments, **options)

    @classmethod
    def read_sodis(cls, paths: Any, *, star: Any, geometry: Any, body: Any = None, **options: Any) -> Self:
        """Read the chords of an event from reports of SODIS, the data base of IOTA/ES: text files, one for each
        station.

        Parameters
        ----------
        paths : path or sequence of paths
        star : SkyCoord, (ra, dec) or array_like (3,)
            The star, of which a report has the name alone.
        geometry : Geometry
            A geometry from the centre of the Earth.
        body : str, int or sequence of them, optional
            As for the class.
        **options
            ``offset`` and ``clock`` of the class.

        Returns
        -------
        StellarOccultation
            The beginnings and ends of the observations are the intervals of misses.
        """
        return cls(star=star, geometry=geometry, body=body, **read_sodis(paths), **options)

    def write_occult(self, path: Any, *, asteroid: tuple[Any, str], satellite: Any = None, names: Any = None) -> None:
        """Write the chords as an event of the program Occult, which reads and completes it.

        Parameters
        ----------
        path : path
        asteroid : (number, name)
        satellite : str or int, optional
            The body whose chords are those of a satellite.
        names : sequence of str, (S,), optional
            The observers.

        Raises
        ------
        InvalidInput
            For stations that are not on the Earth, times that are no dates, and a star that is a vector.
        """
        write_occult(path, *self.star.coordinates, self._reports(satellite, names), asteroid)

    def write_sodis(self, folder: Any, *, asteroid: tuple[Any, str], star: str, names: Any = None) -> list[Path]:
        """Write the report of each station to SODIS, a text file, into a folder, and return their paths.

        Parameters
        ----------
        folder : path
        asteroid : (number, name)
        star : str
            The name of the star in a catalogue.
        names : sequence of str, (S,), optional
            The observers.
        """
        return write_sodis(folder, self._reports(None, names), asteroid, star)

    def _reports(self, satellite: Any, names: Any) -> list[Report]:
        """Return the reports of the stations."""
        chords, watched = self.chords
        if not are_dates(chords):
            raise InvalidInput("the times of the occultation are no dates; expected dates for a report of stations")
        names = [f"station {k}" for k in range(len(self.stations))] if names is None else list(names)
        kinds = ["satellite" if satellite is not None and body == satellite else "main" for body in self.body]
        return reports_of(self.stations.locations, chords, self.errors_of_chords.to_value("s"), watched, kinds, names)

    def predict(self, run: Record, linear: Mapping[str, Any] | None = None) -> Any:
        """Compute the times of the contacts that were observed, from a run.

        Parameters
        ----------
        run : Run
            A run with ``dense=True``, or with samples at the times :meth:`Observations.emission` of its system.
        linear : dict, optional
            The offset and the errors of clocks, as :meth:`Observations.linear_values` returns them.

        Returns
        -------
        astropy Time, Quantity or ndarray, (K,)
            Times of the kind of ``times``; a miss has the middle of its interval minus its residual.
        """
        change = self._attach(self._solved(run, linear)[0], run.system)
        return self.times + (change.to("s") if are_dates(self.times) else change)

    def identified(self, run: Record) -> tuple[str, ...]:
        """Return for each of the K rows the name of the body that was compared with it.

        Parameters
        ----------
        run : Run
            A run as for :meth:`predict`.
        """
        _, solution = self._solved_event(run.system, self._states(run))
        return tuple(run.context.names[body] for body in solution.body)

    def plot(self, run: Record, axes: Any = None, *, linear: Mapping[str, Any] | None = None, **kwargs: Any) -> Any:
        """Draw the chords in the plane of the sky beside the outlines of the bodies, with the offset that fits best.

        East is to the left. Contacts have bars of their standard errors along the chord; misses are dots.

        Parameters
        ----------
        run : Run
            A run as for :meth:`predict`.
        axes : matplotlib Axes, optional
        linear : None
            The offset is always that with the least chi2.
        **kwargs
            Passed to ``Axes.plot`` for the chords.

        Returns
        -------
        matplotlib Axes
        """
        if linear is not None:
            raise InvalidInput("linear is given; expected None, since the picture shows the offset with the least chi2")
        unit = unit_of(run.context.units.attach(1.0, "length"))
        return draw_chords(self._picture(run), unit, axes, kwargs)
