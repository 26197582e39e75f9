"""The common part of all kinds of observations: predictions, residuals, and their weights."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Self

import numpy as np

from ..base.arguments import options_of, refuse_unknown
from ..base.kinds import instance
from ..base.tables import Table, Tabled
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .columns import DataColumn, Rows, column, jitter_of, read_table, refuse_rounded
from .event_tables import table_of
from .pictures import draw, time_axis
from .predictions import Predictions
from .vectors import Vectors


class Observations(Predictions, Tabled):
    """Base of the observations of a system: K rows in the order of time, each of C numbers with their errors.

    Attributes
    ----------
    times : astropy Time, Quantity or ndarray, (K,)
        In the order of time, whatever the order in which they were given.
    rows : ndarray of int, (K,)
        The index of each row in the given data.
    missing : tuple of int
        The indices of rows that are left out, since a value is masked or NaN.
    geometry : Geometry
    """

    #: The columns of a table besides ``times``.
    _columns: ClassVar[tuple[DataColumn, ...]] = ()
    #: The options of the class that a table holds and that a summary shows.
    _options: ClassVar[tuple[str, ...]] = ()
    #: The attributes that hold the standard errors, and their unit.
    _error_names: ClassVar[tuple[str, ...]] = ("_sigma",)
    _error_unit: ClassVar[str] = ""
    #: The names of the C numbers of a row, for pictures.
    _names: ClassVar[tuple[str, ...]] = ()
    _sigma: Any

    def __init__(self, rows: Rows, geometry: Any) -> None:
        what = f"geometry of {type(self).__name__}"
        super().__init__(rows.times, instance(geometry, what, Vectors, "an observing.Geometry"))
        self.rows = rows.indices
        self.missing = rows.missing

    def _read(
        self,
        times: Any,
        columns: Mapping[str, Any],
        unit: str,
        observed: Sequence[str],
        others: dict[str, Floats],
        mixed: bool = False,
    ) -> tuple[Rows, Any]:
        """Return the rows of columns in a unit, and the unit in which the first of them is given.

        Unless units may be ``mixed``, all columns have a unit or none has. The ``observed`` ones have to be precise
        enough for the errors ``sigma``; ``others`` are columns that are read already.
        """
        owner = type(self).__name__
        read = {name: column(values, f"{name} of {owner}", unit) for name, values in columns.items()}
        (first, (_, first_unit)), *others_read = read.items()
        for name, (_, other_unit) in others_read:
            if not mixed and (other_unit is None) != (first_unit is None):
                raise InvalidInput(f"only one of {first} and {name} of {owner} has a unit; expected both or neither")
        numbers = {name: values for name, (values, _) in read.items()}
        for name in observed:
            refuse_rounded(columns[name], numbers[name], numbers["sigma"], f"{name} of {owner}")
        return Rows(times, numbers | others, observed, owner), first_unit

    @classmethod
    def from_table(
        cls,
        table: Any,
        *,
        columns: Mapping[str, Any] | None = None,
        unit: Any = None,
        dates: tuple[str, str] | None = None,
        **options: Any,
    ) -> Self:
        """Make observations from an astropy table or a pandas table.

        Parameters
        ----------
        table : Table, QTable or DataFrame
        columns : dict, optional
            Names of columns where they differ from those that :meth:`to_table` writes. The keys are ``times``; for
            :class:`Astrometry` ``east``, ``north``, ``sigma`` (a pair of names) and ``correlation``; for
            :class:`Photometry` ``magnitude`` and ``sigma``; for :class:`RadarSpectrum` and :class:`DelayDoppler`
            ``power`` and ``sigma``; for :class:`RadarAstrometry` ``range``, ``range_rate`` and their standard errors
            ``sigma_range`` and ``sigma_range_rate``; for :class:`StellarOccultation`, with a row for each station,
            ``disappearance``, ``reappearance``, ``sigma`` (a pair of names), ``body``, ``watched_from``,
            ``watched_until`` and the coordinates of the stations.
        unit : unit or dict of unit, optional
            Unit of columns that have none, or the unit of each by these keys. Correlations have no unit.
        dates : (format, scale), optional
            The format and scale of dates given as numbers, such as ``("jd", "utc")``; see astropy's ``Time``.
        **options
            The other arguments of the class, among them those that the table lacks. ``night``, ``filter`` and
            ``airmass`` of :class:`Photometry` may be names of columns.

        Returns
        -------
        Observations
            Data of the class.

        Examples
        --------
        >>> import astropy.units as u
        >>> from astropy.table import QTable
        >>> from fullbody import observing
        >>> geometry = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
        >>> table = QTable({"hours": [10.0, 11.0] * u.h, "range": [2.5, 2.6] * u.km, "sigma_range": [75.0, 75.0] * u.m})
        >>> data = observing.RadarAstrometry.from_table(table, columns={"times": "hours"}, geometry=geometry)
        >>> data.range, data.to_table().colnames
        (<Quantity [2.5, 2.6] km>, ['times', 'range', 'sigma_range'])
        """
        if columns is not None:
            instance(columns, f"columns of {cls.__name__}", Mapping, "a dict of arguments to names of columns")
        refuse_unknown(options, options_of(cls), cls.__name__)
        nameable = [c.name for c in cls._columns if c.named or c.kind == "labels"]
        named = [name for name in nameable if isinstance(options.get(name), str)]
        names = dict(columns or {}) | {name: options.pop(name) for name in named}
        declared = [c for c in cls._columns if c.name not in options]
        read = cls._arguments(read_table(table, declared, names, unit, dates, cls.__name__))
        return cls(**read | options)

    @classmethod
    def _arguments(cls, read: dict[str, Any]) -> dict[str, Any]:
        """Return the arguments of the class from what was read from the columns of a table."""
        return read

    def to_table(self) -> Any:
        """Return the observations as an astropy ``QTable``, which ``from_table`` reads."""
        columns: dict[str, Any] = {"times": self.times}
        for declared in self._columns:
            for name in (declared.name, declared.errors) if declared.errors else (declared.name,):
                if (values := self._column(name)) is not None:
                    parts = zip(declared.parts, np.moveaxis(values, -1, 0), strict=True) if declared.parts else ()
                    columns |= dict(parts) or {name: values}
        options = {name: getattr(self, name) for name in self._options}
        kinds = int, float, str, type(None)
        return table_of(columns, {name: v if isinstance(v, kinds) else str(v) for name, v in options.items()})

    def _column(self, name: str) -> Any:
        """Return the values of a column by its name, or ``None`` if the data have none."""
        return getattr(self, name)

    def __len__(self) -> int:
        return len(self.rows)

    def with_errors_of(self, other: Self) -> Self:
        """Return the observations with the standard errors of others of the same rows."""
        result = copy.copy(self)
        for name in self._error_names:
            setattr(result, name, getattr(other, name))
        return result

    def with_jitter(self, jitter: Any) -> Self:
        """Return the observations with a further error of the same size in each row, independent of the others.

        Parameters
        ----------
        jitter : float or Quantity
            Its standard deviation, zero or above; its square is added to the variances. For a :class:`RadarAstrometry`
            with both ranges and range rates, a pair. A fit that frees it starts above zero, where predictions do not
            change with it to first order.

        Returns
        -------
        Observations
            A copy that stores by how much its errors are widened, so that a fit can free the jitter.
        """
        result = copy.copy(self)
        result._original = self if self._original is None else self._original
        result._add_jitter(jitter)
        return result

    def plot(self, run: Record, axes: Any = None, *, linear: Mapping[str, Any] | None = None, **kwargs: Any) -> Any:
        """Draw the observations with their errors over the predictions of a run, and below them the residuals.

        Parameters
        ----------
        run : Run
            A run as for :meth:`predict`.
        axes : array of matplotlib Axes, (2, C), optional
            Axes to draw on; C is the count of numbers in a row, such as two for east and north.
        linear : dict, optional
            The linear unknowns, as for :meth:`predict`.
        **kwargs
            Passed to ``Axes.errorbar``.

        Returns
        -------
        ndarray of Axes, (2, C)
        """
        system = run.system
        predicted, residuals, _ = self._solved(run, linear)
        sigma = np.sqrt(np.diagonal(self.errors(system).covariance, axis1=1, axis2=2)).reshape(residuals.shape)
        columns = [self._by_name(self._attach(values, system)) for values in (predicted, residuals, sigma)]
        parts = {name: tuple(column[name] for column in columns) for name in columns[0]}
        return draw(time_axis(self.times), parts, axes, kwargs)

    @property
    def components(self) -> tuple[str, ...]:
        """The names of the C numbers of a row, such as east and north."""
        return self._names

    def _by_name(self, attached: Any) -> dict[str, Any]:
        """Return predictions as columns (K,) by their names."""
        columns = [attached] if attached.ndim == 1 else np.moveaxis(attached, 1, 0)
        return dict(zip(self._names, columns, strict=True))

    def _add_jitter(self, jitter: Any) -> None:
        """Add a jitter to the standard errors."""
        self._sigma = np.hypot(self._sigma, jitter_of(jitter, self._error_unit))

    def _standard_errors(self, system: SystemLike) -> Floats:
        """Return the standard errors (K, C) in the numbers of the predictions."""
        return np.asarray(self._sigma.reshape(len(self), -1))

    def _covariance(self, system: SystemLike) -> Floats:
        sigma = self._standard_errors(system)
        return np.asarray(sigma[:, :, None] ** 2 * np.eye(sigma.shape[1]))

    def _tables(self) -> tuple[Table, ...]:
        rows = [("observations", str(len(self)))]
        if self.missing:
            rows.append(("left out", f"{len(self.missing)} rows with masked or missing values"))
        rows += [("first", str(self.times[0])), ("last", str(self.times[-1])), ("geometry", repr(self.geometry))]
        return (Table(repr(self).partition("(")[0], (), [*rows, *self._summary()]),)

    def _summary(self) -> list[tuple[str, str]]:
        """Return the names and values of the options that a printed summary shows."""
        return [(name.replace("_", " "), str(getattr(self, name))) for name in self._options]

    def __repr__(self) -> str:
        missing = f", {len(self.missing)} left out" if self.missing else ""
        return f"{type(self).__name__}({len(self)} times from {self.times[0]} to {self.times[-1]}{missing})"
