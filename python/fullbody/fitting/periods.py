"""The scan of sidereal periods: chi2 of light curves against the period, with a convex shape fitted at each."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..base.atomic import as_path, content, replacing
from ..base.foreign import are_dates
from ..base.kinds import instance, whole
from ..base.limits import POSITIVE, Limits
from ..base.progress import Progress
from ..base.tables import Table, Tabled
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, Units, gathered, is_quantity, need
from ..errors import InconsistentInput, InvalidInput, caution, interruptible
from ..frames import pole_angles
from ..model.bodies import Body
from ..model.freeform import ConvexShape
from ..model.state import State
from ..motion.system import System
from ..observing import Photometry
from ..observing.brightness import Epochs, Photometer
from ..observing.times import in_system
from ..observing.vectors import local_geometry
from ..typing import Floats
from .convex import ConvexSeries, Harmonics
from .inner import InnerSolution, model_of
from .losses import LINEAR
from .poles import axes_along, lattice, tilted

#: The default range of periods in hours: from the limit of rubble piles to a day.
_RANGE = (2.2, 24.0)
#: The largest number of periods, the numbers of a batch, and the seconds between two files.
_MOST, _BATCH, _SAVED = 2_000_000, 2**20, 5.0


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
    """The chi2 of light curves against the sidereal period; made by :func:`period_scan`.

    Attributes
    ----------
    periods : ndarray or Quantity, (N,)
        In increasing order.
    chi2 : ndarray, (N,)
        The least chi2 at each period over all poles.
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
        """The least chi2 at each period (N,)."""
        return np.asarray(self.by_pole.min(axis=1))

    @property
    def minima(self) -> tuple[PeriodMinimum, ...]:
        """All local minima, the lowest first, with their fitted periods."""
        chi2 = np.concatenate([[np.inf], self.chi2, [np.inf]])
        lowest = np.flatnonzero((chi2[1:-1] < chi2[:-2]) & (chi2[1:-1] <= chi2[2:]))
        return tuple(self._at(int(k)) for k in lowest[np.argsort(chi2[1:-1][lowest], kind="stable")])

    def _at(self, k: int) -> PeriodMinimum:
        pole = int(np.argmin(self.by_pole[k]))
        return self._found(k, pole)

    def _found(self, k: int, pole: int) -> PeriodMinimum:
        found = self.longitude[k, pole], self.latitude[k, pole]
        return PeriodMinimum(self.fitted[k, pole], float(self.by_pole[k, pole]), *found)

    def poles_at(self, period: Any) -> tuple[PeriodMinimum, ...]:
        """Return all poles at the scanned period that is nearest to a given one, with their chi2, the lowest first."""
        k = int(np.argmin(np.abs(self.periods - period)))
        poles = (self._found(k, pole) for pole in range(self.by_pole.shape[1]))
        return tuple(sorted(poles, key=lambda found: found.chi2))

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
        periods = getattr(self.periods, "value", self.periods)
        ax.plot(periods, self.chi2 / self.dof, **line(0, {"linewidth": 0.8} | kwargs))
        best = self.minima[0]
        period = float(getattr(best.period, "value", best.period))
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
        def row(item: PeriodMinimum) -> Sequence[str]:
            return (f"{item.period:.9g}", f"{item.chi2:.6g}", f"{item.longitude:.1f}", f"{item.latitude:.1f}")

        rows = [row(item) for item in self.minima[:10]]
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
        A range, which is scanned in steps, or more than two periods themselves. By default the range is 2.2 to 24 hours.
    poles : int
        Number of poles, a Fibonacci lattice over the sphere, from each of which the pole is fitted too; chi2 at a period
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
    >>> scan.minima[0].period.round(3)
    <Quantity 5. h>
    """
    listed = [data] if isinstance(data, Photometry) else list(data)
    for item in listed or [data]:
        instance(item, "data", Photometry, "light curves: Photometry, or a list of them")
        if item.rotation is not None:
            raise InvalidInput("data has a RotationSeries, which describes any rotation; expected light curves without")
    whole(degree, "degree", 1, 12)
    UNITLESS.number(step, "number", "step", Limits(least=1e-3, most=1.0, text="a number from 0.001 to 1"))
    UNITLESS.number(smoothness, "number", "smoothness", POSITIVE)
    curves = _Curves(listed, frame)
    unit, hours = _periods(periods, curves, step)
    longitude, latitude = lattice(whole(poles, "poles"))
    settings = (hours, longitude, latitude, np.array([degree, smoothness]))
    known = _Store(store, (*curves.numbers, *settings), (len(hours), len(longitude), 4))
    unknowns = (degree + 1) ** 2 - 1
    dof = len(curves.sigma) - curves.basis.shape[1] - unknowns
    if dof < 1:
        raise InvalidInput(
            f"data has {len(curves.sigma)} magnitudes for {curves.basis.shape[1]} linear unknowns and {unknowns} "
            f"coefficients of degree {degree}; expected more"
        )
    # A grid of n poles is at most about this far from any pole.
    reach = min(0.9, 3.0 / np.sqrt(len(longitude))), 2.0 * np.pi * step
    batch = max(1, _BATCH // (len(curves.sigma) * unknowns))
    with Progress(progress) as report, known.kept():
        for pole in np.flatnonzero(np.isnan(known.minima).any(axis=(0, 2))):
            axes = axes_along(longitude[pole], latitude[pole])
            series = curves.series(axes, degree, smoothness, reach)
            column = np.empty((len(hours), 4))
            for first in range(0, len(hours), batch):
                part = slice(first, first + batch)
                found = series.least(2.0 * np.pi / hours[part])
                angles = pole_angles(tilted(axes, found.tilt)[:, 2])
                column[part] = np.column_stack([found.chi2, 2.0 * np.pi / found.frequency, *angles])
                if report is not None:
                    done = pole * len(hours) + min(first + batch, len(hours))
                    report(done, known.minima[..., 0].size, f"pole {pole + 1} of {len(longitude)}")
            known.take(int(pole), column)
    with need("units", "a scan of periods"):
        import astropy.units as u

    chi2, fitted, *angles = np.moveaxis(known.minima, -1, 0)
    scanned, fitted = ((part if unit is None else (part * unit_named("h")).to(unit)) for part in (hours, fitted))
    return PeriodScan(scanned, chi2, fitted, *(np.degrees(angle) * u.deg for angle in angles), dof)


class _Curves:
    """The light curves beside the light of a sphere: pulls, errors and linear unknowns, and the directions (2, K, 3)."""

    def __init__(self, data: list[Photometry], frame: str | None) -> None:
        self.united = are_dates(data[0].times) or is_quantity(data[0].times)
        options: dict[str, Any] = {"units": ("km", "hour", "kg"), "frame": frame} if self.united else {"G": 1.0}
        if are_dates(data[0].times):
            options["epoch"] = data[0].times[0].tdb
        self._sphere = ConvexShape([0.0], reference_radius="1 km" if self.united else 1.0)
        self._system = System([Body(self._sphere, mass="1e12 kg" if self.united else 1.0)], **options)
        models, times, lights = [], [], []
        for item in data:
            emission = item.emission(self._system)
            start = State(np.zeros((1, 3)), np.zeros((1, 3)), time=emission[0])
            models.append(model_of(item, self._system.integrate(start, emission[-1], output=emission)))
            local, clock = local_geometry(item.geometry, self._system), in_system(item.times, self._system, "times")
            times.append(self._system.context.units.strip(emission, "time", "times"))
            lights.append([local.observer(clock), local.sun(clock)])
        self._laws, self._counts = [item.law for item in data], [len(part) for part in times]
        self.times, self.sigma = np.concatenate(times), np.concatenate([item.sigma for item in data])
        self.pulls = np.concatenate([model.pulls.ravel() for model in models])
        self.basis = InnerSolution(models, LINEAR).projection.basis
        self.lights = np.concatenate(lights, axis=1)
        self.lights /= np.linalg.norm(self.lights, axis=-1, keepdims=True)

    @property
    def numbers(self) -> tuple[Floats, ...]:
        """All numbers on which a scan of these data depends."""
        return self.times, self.sigma, self.pulls, self.basis, self.lights

    def series(self, axes: Floats, degree: int, smoothness: float, reach: tuple[float, float]) -> ConvexSeries:
        """Return the light of a convex body about poles near the last of some axes (3, 3)."""
        harmonics = Harmonics.at(self._sphere.normals, degree)
        weighted = self._system.context.bodies[0].areas[:, None] * harmonics.values
        ends = np.cumsum([0, *self._counts])

        def integrals(tilt: Floats) -> Any:
            lights = self.lights @ tilted(axes, tilt).T
            parts = []
            for law, first, last in zip(self._laws, ends, ends[1:], strict=False):
                count = last - first
                poses = np.zeros((count, 1, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (count, 1, 1))
                epochs = Epochs(self.times[first:last], *poses, *lights[:, first:last])
                photometer = Photometer(self._system, law, 1.0, False, 0.0)
                parts.append(photometer.derivatives(epochs, True).areas[0][:, 0] @ weighted)
            return np.concatenate(parts)

        bisector = self.lights.sum(axis=0) @ axes.T
        rows = (bisector, self.times, self.pulls, self.sigma, self.basis)
        return ConvexSeries(integrals, harmonics, *rows, smoothness, reach)


class _Store:
    """Chi2, period, longitude and latitude (N, n, 4) at each period near each pole, NaN where it is not known yet, and their file."""

    def __init__(self, path: Any, numbers: Iterator[Floats] | tuple[Floats, ...], shape: tuple[int, ...]) -> None:
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

    def take(self, pole: int, column: Floats) -> None:
        """Keep the minima (N, 4) near a pole."""
        self.minima[:, pole] = column
        if time.monotonic() - self._saved > _SAVED:
            self.save()

    def save(self) -> None:
        """Write the file, if there is one."""
        if self._path is not None:
            with replacing(self._path) as temporary, temporary.open("wb") as file:
                np.savez(file, key=np.array(self._key), minima=self.minima)
        self._saved = time.monotonic()

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Write the file at the end, also that of an interrupt."""
        try:
            yield
        finally:
            self.save()


def _periods(given: Any, curves: _Curves, step: float) -> tuple[Any, Floats]:
    """Return the unit of the periods, None for plain numbers, and the periods (N,) in hours, or as plain numbers."""
    span = float(np.ptp(curves.times))
    if not span > 0.0:
        raise InvalidInput("data have no span of time, which would determine a period; expected two times or more")
    if given is None:
        if not curves.united:
            raise InvalidInput("periods is None beside times without a unit; expected (shortest, longest)")
        given = unit_named("h") * np.array(_RANGE)
    given = gathered(given, "periods", "time")
    if is_quantity(given) != curves.united:
        expected = "a Quantity" if curves.united else "plain numbers"
        raise InvalidInput(f"periods is {given!r}; expected {expected}, as the times of the data are")
    unit = given.unit if is_quantity(given) else None
    hours = np.atleast_1d(
        (Units(("km", "hour", "kg")) if unit else UNITLESS).numbers(
            given, "time" if unit else "number", "periods", ("N",), POSITIVE
        )
    )
    values = np.unique(hours)
    if len(values) != len(hours) or len(values) < 2:
        raise InvalidInput(f"periods is {given!r}; expected (shortest, longest), or different periods")
    fraction = np.diff(1.0 / values[::-1]) * span
    if len(values) == 2:
        # Equal steps of the frequency are steps of the period in proportion to P^2.
        count = float(fraction[0]) / step
        if count < 2.0:
            raise InvalidInput(
                f"periods is {given!r}, shorter than two steps of {step * values[0] ** 2 / span:.3g}; expected a longer "
                "range: data over this span of time cannot tell these periods apart"
            )
        if count > _MOST:
            raise InvalidInput(
                f"periods is {given!r}, which takes {count:.3g} steps for data over this span of time; expected a range "
                f"with at most {_MOST} steps"
            )
        values = 1.0 / np.linspace(1.0 / values[0], 1.0 / values[1], int(np.ceil(count)) + 1)
    elif fraction.max() > 0.5:
        caution(
            f"periods has steps of up to {fraction.max():.3g} P^2/T, where minima are half of that apart and may be missed",
            InconsistentInput,
        )
    return unit, values
