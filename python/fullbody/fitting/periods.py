"""The scan of sidereal periods: chi2 of light curves against the period, with a convex shape fitted at each."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..base.atomic import as_path, content, replacing
from ..base.kinds import instance, whole_number
from ..base.limits import POSITIVE, Limits
from ..base.progress import Progress
from ..base.rotations import matrices
from ..base.tables import Table, Tabled
from ..base.units import UNITLESS, need, without_unit
from ..errors import InvalidInput, interruptible
from ..frames import attitude, pole_angles
from ..observing import Photometry
from ..typing import Floats
from .convex import ConvexSeries
from .curves import Curves, scanned_periods
from .poles import lattice, tilted

#: The largest numbers of periods times data times coefficients of a batch.
_BATCH = 2**20
#: The seconds after which the file of a scan is written again.
_SAVED = 5.0


class PeriodMinimum(NamedTuple):
    """A local minimum of chi2 against the period.

    Attributes
    ----------
    period : float or Quantity
    chi2 : float
    longitude, latitude : Quantity
        The pole with this chi2.
    """

    period: Any
    chi2: float
    longitude: Any
    latitude: Any


@dataclass(frozen=True, eq=False)
class PeriodScan(Tabled):
    """The chi2 of light curves against the sidereal period; made by :func:`fullbody.fitting.period_scan`.

    Attributes
    ----------
    periods : ndarray or Quantity, (N,)
        In increasing order.
    by_pole : ndarray, (N, n)
        The least chi2 near each period and each of the n poles of the grid.
    fitted : ndarray or Quantity, (N, n)
        The periods at which it is the least.
    longitude, latitude : Quantity, (N, n)
        The poles at which it is the least.
    dof : int
        Data minus linear unknowns and coefficients of the shape, at one period and pole.
    """

    periods: Any
    by_pole: Floats
    fitted: Any
    longitude: Any
    latitude: Any
    dof: int

    @property
    def chi2(self) -> Floats:
        """The least chi2 at each period (N,) over all poles."""
        return np.asarray(self.by_pole.min(axis=1))

    @property
    def minima(self) -> tuple[PeriodMinimum, ...]:
        """All local minima, the lowest first, with their fitted periods."""
        chi2 = np.concatenate([[np.inf], self.chi2, [np.inf]])
        lowest = np.flatnonzero((chi2[1:-1] < chi2[:-2]) & (chi2[1:-1] <= chi2[2:]))
        order = lowest[np.argsort(chi2[1:-1][lowest], kind="stable")]
        return tuple(self._minimum(k, int(np.argmin(self.by_pole[k]))) for k in order)

    def _minimum(self, k: int, pole: int) -> PeriodMinimum:
        direction = self.longitude[k, pole], self.latitude[k, pole]
        return PeriodMinimum(self.fitted[k, pole], float(self.by_pole[k, pole]), *direction)

    def poles_at(self, period: Any) -> tuple[PeriodMinimum, ...]:
        """Return all poles at the scanned period nearest to a period, with their chi2, the lowest first."""
        k = int(np.argmin(np.abs(self.periods - period)))
        poles = (self._minimum(k, pole) for pole in range(self.by_pole.shape[1]))
        return tuple(sorted(poles, key=lambda minimum: minimum.chi2))

    def plot(self, ax: Any = None, **kwargs: Any) -> Any:
        """Draw chi2 against the period, with its minimum marked.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        **kwargs
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib Axes
        """
        from ..base.figures import grid, line, single, unit_of

        ax = single(ax, (7.0, 3.5))
        periods = without_unit(self.periods)
        ax.plot(periods, self.chi2 / self.dof, **line(0, {"linewidth": 0.8} | kwargs))
        best = self.minima[0]
        period = float(without_unit(best.period))
        ax.plot([period], [best.chi2 / self.dof], "o", color="C3", markersize=5.0)
        ax.annotate(f"{period:.7g}", (period, best.chi2 / self.dof), (6, -3), textcoords="offset points", fontsize=8)
        ax.set_xlabel(f"sidereal period [{unit_of(self.periods)}]")
        ax.set_ylabel("chi2 / degrees of freedom")
        grid(ax)
        return ax

    def to_table(self) -> Any:
        """Return an astropy ``QTable`` with a row for each period: its chi2, and the pole that has it."""
        with need("observing", "a table"):
            from astropy.table import QTable

        pole = self.by_pole.argmin(axis=1)
        columns = {"period": self.periods, "chi2": self.chi2}
        rows = np.arange(len(pole))
        columns |= {"longitude": self.longitude[rows, pole], "latitude": self.latitude[rows, pole]}
        return QTable(columns, meta={"dof": self.dof})

    def _tables(self) -> tuple[Table, ...]:
        rows: list[Sequence[str]] = [
            (f"{item.period:.9g}", f"{item.chi2:.6g}", f"{item.longitude:.1f}", f"{item.latitude:.1f}")
            for item in self.minima[:10]
        ]
        return (Table("Lowest minima", ("period", "chi2", "longitude", "latitude"), rows),)

    def __repr__(self) -> str:
        first, last, best = self.periods[0], self.periods[-1], self.minima[0]
        return (
            f"PeriodScan({len(self.periods)} periods from {first:.7g} to {last:.7g}, {self.by_pole.shape[1]} poles, "
            f"lowest chi2 {best.chi2:.6g} at {best.period:.9g}, dof {self.dof})"
        )


@interruptible("a scan of periods")
def period_scan(
    data: Photometry | Sequence[Photometry],
    periods: Any = None,
    *,
    poles: int = 8,
    degree: int = 3,
    step: float = 0.25,
    smoothness: float = 0.5,
    frame: str | None = "ecliptic",
    store: Any = None,
    progress: Any = False,
) -> PeriodScan:
    """Compute chi2 of light curves against the sidereal period, with a convex shape fitted at each period and pole.

    Light curves far apart in time determine the period so well that chi2 has very many minima, about P^2/(2 T) apart
    for curves over a time T (Kaasalainen, Torppa & Muinonen 2001, Icarus 153, 37). A fit has to start in the right one,
    which a scan in steps below this distance finds.

    Parameters
    ----------
    data : Photometry or sequence of Photometry
        Light curves of one body alone. Their zero points and slopes are solved for at each period.
    periods : (shortest, longest) or array_like or Quantity, (N,), optional
        A range, which is scanned in steps, or more than two periods; from 2.2 to 24 hours unless given.
    poles : int
        Number of poles from which the fit starts at each period, a Fibonacci lattice over the sphere; chi2 at a period
        is the least of theirs.
    degree : int
        Degree of the series of spherical harmonics that describes the shape, from 1 to 12.
    step : float
        Steps of a range in units of P^2/T, above zero and at most one.
    smoothness : float
        The prior standard deviation of the coefficients of degree one, relative to the mean; that of degree l is
        smaller by the factor l.
    frame : str or None
        The frame of the poles, by a name of :mod:`fullbody.frames`; ``None`` for that of data whose geometries have no
        frame.
    store : str or Path, optional
        A file (``.npz``) to which finished poles are written, and from which a scan of the same data continues.
    progress : bool, str or callable
        Whether to show the progress, or a title; or a function of (done, total, description).

    Returns
    -------
    PeriodScan

    Raises
    ------
    InvalidInput
        For data without a span of time, a range that is shorter than one step or has too many of them, periods that are
        not above zero, more unknowns than data, data with a :class:`~fullbody.observing.RotationSeries`, and a store
        of another scan.
    Interrupted
        On Ctrl-C; a store keeps the poles that were finished.

    Warns
    -----
    InconsistentInput
        For given periods that are farther apart than half of P^2/T.

    Notes
    -----
    The area per solid angle of normals is a linear series of spherical harmonics, which may become negative where data
    are few: the scan is for the period and a first pole, and a fit of a shape such as :class:`fullbody.ConvexShape`
    follows. Light of the body's own shadows is not in the model.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> body = fullbody.Body(fullbody.Ellipsoid("3 km", "2 km", "1.5 km"), mass="1e14 kg")
    >>> system = fullbody.System([body], units=("km", "hour", "kg"))
    >>> run = system.integrate(fullbody.State.rotating(body, 1.0, 0.9, 5.0 * u.h), 4000.0, dense=True)
    >>> angle = np.linspace(0.0, 3.0, 80)
    >>> around = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    >>> hours = np.linspace(0.0, 4000.0, 80) * u.h
    >>> geometry = observing.Geometry(hours, to_observer=2.0 * u.au * around, to_sun=[3, 1, 0] * u.au, light_time=False)
    >>> times = np.sort(np.random.default_rng(0).uniform(0.0, 4000.0, 300)) * u.h
    >>> light = observing.light_curve(run, times, geometry)
    >>> data = observing.Photometry(times, light, 0.01, geometry=geometry, night=np.zeros(300, dtype=int))
    >>> scan = fullbody.fitting.period_scan(data, [4.95, 5.05] * u.h, poles=12, frame=None)
    >>> scan.minima[0].period.round(2)
    <Quantity 5. h>
    """
    listed: list[Any] = [data] if isinstance(data, Photometry) else list(data)
    for item in listed or [data]:
        instance(item, "data", Photometry, "light curves: Photometry, or a list of them")
        if item.rotation is not None:
            raise InvalidInput("data has a RotationSeries, which describes any rotation; expected light curves without")
    whole_number(degree, "degree", 1, 12)
    UNITLESS.number(step, "number", "step", Limits(least=1e-3, most=1.0, text="a number from 0.001 to 1"))
    UNITLESS.number(smoothness, "number", "smoothness", POSITIVE)
    curves = Curves(listed, frame)
    unit, hours = scanned_periods(periods, curves, step)
    longitude, latitude = lattice(whole_number(poles, "poles"))
    settings = (hours, longitude, latitude, np.array([degree, smoothness]))
    stored = _PeriodStore(store, (*curves.numbers, *settings), (len(hours), len(longitude), 4))
    unknowns = (degree + 1) ** 2 - 1
    dof = len(curves.sigma) - curves.basis.shape[1] - unknowns
    if dof < 1:
        raise InvalidInput(
            f"data has {len(curves.sigma)} magnitudes for {curves.basis.shape[1]} linear unknowns and {unknowns} "
            f"coefficients of degree {degree}; expected more"
        )
    # Any pole is at most about this far from a grid of n poles.
    limits = min(0.9, 3.0 / np.sqrt(len(longitude))), 2.0 * np.pi * step
    batch = max(1, _BATCH // (len(curves.sigma) * unknowns))
    with Progress(progress) as report, closing(stored):
        for pole in np.flatnonzero(np.isnan(stored.minima).any(axis=(0, 2))).tolist():
            axes = matrices(attitude(longitude[pole], latitude[pole])).T
            series = ConvexSeries(curves, axes, degree, smoothness, limits)
            column = np.empty((len(hours), 4))
            for first in range(0, len(hours), batch):
                part = slice(first, first + batch)
                least = series.minimum(2.0 * np.pi / hours[part])
                angles = pole_angles(tilted(axes, least.tilt)[:, 2])
                column[part] = np.column_stack([least.chi2, 2.0 * np.pi / least.frequency, *angles])
                if report is not None:
                    done = pole * len(hours) + min(first + batch, len(hours))
                    report(done, stored.minima[..., 0].size, f"pole {pole + 1} of {len(longitude)}")
            stored.add(pole, column)
    with need("units", "a scan of periods"):
        import astropy.units as u

    def in_given_unit(periods: Floats) -> Any:
        return periods if unit is None else (periods * u.h).to(unit)

    chi2, fitted, lon, lat = np.moveaxis(stored.minima, -1, 0)
    return PeriodScan(
        in_given_unit(hours), chi2, in_given_unit(fitted), np.degrees(lon) * u.deg, np.degrees(lat) * u.deg, dof
    )


class _PeriodStore:
    """The minima of a scan, and the file from which an interrupted scan continues, if there is a path.

    The array ``minima`` (N, n, 4) has chi2, period, longitude and latitude near each of N periods and n poles, and NaN
    where they are not computed yet. The scan depends on the ``numbers``; the file of other numbers is refused.
    """

    def __init__(self, path: Any, numbers: Iterable[Floats], shape: tuple[int, ...]) -> None:
        self._path: Path | None = None if path is None else as_path(path, "store")
        digest = hashlib.sha256()
        for array in numbers:
            digest.update(np.ascontiguousarray(array).tobytes())
        self._key, self._saved = digest.hexdigest(), time.monotonic()
        self.minima = np.full(shape, np.nan)
        if self._path is not None and self._path.exists():
            self.minima = self._read(self._path)

    def _read(self, path: Path) -> Floats:
        try:
            with np.load(BytesIO(content(path)), allow_pickle=False) as file:
                key, minima = str(file["key"]), file["minima"]
        except (ValueError, KeyError, OSError, EOFError) as error:
            raise InvalidInput(f"{path} is no store of a scan of periods; expected one, or a new name") from error
        if key != self._key or minima.shape != self.minima.shape:
            raise InvalidInput(
                f"{path} is the store of a scan of other data or with other arguments; expected a new name"
            )
        return np.asarray(minima, dtype=np.float64)

    def add(self, pole: int, minima: Floats) -> None:
        """Store the minima (N, 4) near a pole."""
        self.minima[:, pole] = minima
        if time.monotonic() - self._saved > _SAVED:
            self.close()

    def close(self) -> None:
        """Write the file, if there is one."""
        if self._path is not None:
            with replacing(self._path) as temporary, temporary.open("wb") as file:
                np.savez(file, key=np.array(self._key), minima=self.minima)
        self._saved = time.monotonic()
