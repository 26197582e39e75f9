"""Kepler elements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Generic, overload

import numpy as np

import fullbody._core as _core

from ..base.arguments import refuse_mixture, warn_if_degrees
from ..base.tables import Table, Tabled, head
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, numbers, strip_to, without_unit
from ..base.values import ArrayFields, brief
from ..errors import InvalidInput
from ..typing import Array, Scalar
from .arguments import in_unit, mu_and_units, since_periapsis, single_name, usual_angles

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    # The type of the elements: a number or an array, with or without unit.
    _T = TypeVar("_T", default=Any)
else:
    from typing import TypeVar

    _T = TypeVar("_T")
_ANGLES = ("i", "Omega", "omega", "M")
#: The dimensions of the elements.
DIMENSIONS = {"a": "length", "e": "number", **dict.fromkeys(_ANGLES, "angle")}


class KeplerElements(ArrayFields, Generic[_T], Tabled):
    """The osculating elements of one two-body orbit or of arrays of orbits.

    Parameters
    ----------
    a : float, array_like or Quantity
        Semi-major axis; negative for a hyperbola.
    e : float or array_like
        Eccentricity: 0 <= e < 1 with a > 0, or e > 1 with a < 0. Parabolas have no semi-major axis and are refused.
    i, Omega, omega, M : float, array_like or Quantity
        Inclination, from 0 to pi, to the xy-plane; longitude of the ascending node, from the x-axis; argument of
        periapsis, from the node along the motion; mean anomaly, from periapsis, for a hyperbola e sinh H - H, of either
        sign. Floats are radians.
    pomega, f, l, theta : float, array_like or Quantity, optional
        Longitude of periapsis, in place of ``omega``; true anomaly, mean longitude or true longitude, one of them in
        place of ``M``.
    T : float, array_like or Quantity, optional
        Time of the passage through periapsis, in place of ``M``; it needs ``mu``, as for :meth:`to_cartesian`.
    mu, time : float or Quantity, optional
        With ``T`` the gravitational parameter, and the time at which the elements hold.
    frame : str or astropy frame, optional
        Reference frame of the angles, such as ``"ecliptic"``; see :mod:`fullbody.frames`. Third bodies, geometries and
        :meth:`to_frame` use it; :meth:`to_cartesian` gives components along its axes. Elements of a run have that of
        its system; it is ``None`` if it is not known.

    Attributes
    ----------
    a, e, i, Omega, omega, M : float, ndarray or Quantity
        The elements as given, or in the unit of the run or the position from which they follow.

    Raises
    ------
    InvalidInput
        For values that describe no orbit.

    Warns
    -----
    InconsistentInput
        For angles that look like degrees: plain numbers beyond two turns with six decimals at most.

    Notes
    -----
    The words for other angles are those of REBOUND. On a retrograde orbit longitudes are counted against the motion:
    pomega = Omega - omega, theta = pomega - f, l = pomega - M. Circular orbits have omega = 0 and M counted from the
    node; equatorial ones have Omega = 0 and angles counted from the x-axis.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> orbit = fullbody.KeplerElements(a=2.0, e=0.5, i=0.0, Omega=0.0, omega=0.0, M=0.0)
    >>> r, v = orbit.to_cartesian(mu=1.0)
    >>> float(r[0]), round(float(v[1]), 6)
    (1.0, 1.224745)

    A quarter of the period after its passage through periapsis the mean anomaly is a right angle:

    >>> orbit = fullbody.KeplerElements(4.0, 0.1, 0.0, 0.0, pomega=0.3, T=2.0, mu=1.0, time=2.0 + 4.0 * np.pi)
    >>> orbit.omega, round(orbit.M / np.pi, 12)
    (0.3, 0.5)
    """

    __slots__ = ("M", "Omega", "a", "e", "frame", "i", "omega")

    a: _T
    e: _T
    i: _T
    Omega: _T
    omega: _T
    M: _T
    frame: Any

    @overload
    def __init__(
        self: KeplerElements[Scalar],
        a: float,
        e: float,
        i: float,
        Omega: float,
        omega: float | None = None,
        M: float | None = None,
        *,
        frame: Any = None,
        f: float | None = None,
        T: float | None = None,
        l: float | None = None,
        pomega: float | None = None,
        theta: float | None = None,
        mu: Any = None,
        time: Any = 0.0,
    ) -> None: ...
    @overload
    def __init__(
        self: KeplerElements[Any],
        a: Any,
        e: Any,
        i: Any,
        Omega: Any,
        omega: Any = None,
        M: Any = None,
        *,
        frame: Any = None,
        f: Any = None,
        T: Any = None,
        l: Any = None,
        pomega: Any = None,
        theta: Any = None,
        mu: Any = None,
        time: Any = 0.0,
    ) -> None: ...
    def __init__(
        self,
        a: Any,
        e: Any,
        i: Any,
        Omega: Any,
        omega: Any = None,
        M: Any = None,
        *,
        frame: Any = None,
        f: Any = None,
        T: Any = None,
        l: Any = None,
        pomega: Any = None,
        theta: Any = None,
        mu: Any = None,
        time: Any = 0.0,
    ) -> None:
        object.__setattr__(self, "frame", frame)
        if omega is None or M is None or any(other is not None for other in (f, T, l, pomega, theta, mu)):
            if single_name({"M": M, "f": f, "T": T, "l": l, "theta": theta}) == "T":
                M = since_periapsis(a, T, mu, time)
            elif mu is not None:
                expected = "expected it beside a time of the passage through periapsis"
                raise InvalidInput(f"mu is {mu!r} without T; {expected}")
            anomaly = {"M": M, "f": f, "l": l, "theta": theta}
            omega, M = usual_angles(e, i, Omega, {"omega": omega, "pomega": pomega}, anomaly)
        for name, value in zip(DIMENSIONS, (a, e, i, Omega, omega, M), strict=True):
            value = as_quantity(value, name, DIMENSIONS[name])
            is_array = isinstance(value, list | tuple | np.ndarray) and not is_quantity(value)
            value = float(value) if isinstance(value, np.float64) else value
            object.__setattr__(self, name, numbers(value, name) if is_array else value)
        # The core checks the elements; the value of mu does not matter for this.
        _core.elements_to_cartesian(self._rows(_length_number(self.a))[0], 1.0)
        # The mean anomaly of a hyperbola is not an angle.
        bound = np.all(np.asarray(self.e, dtype=np.float64) < 1.0)
        for name in ("Omega", "omega", "M") if bound else ("Omega", "omega"):
            warn_if_degrees(getattr(self, name), name)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"elements cannot be changed; make new ones with another {name}")

    def _rows(self, a: Any) -> tuple[Any, tuple[int, ...]]:
        """Return elements as an array (K, 6), and their common shape."""
        columns = [numbers(a, "a"), numbers(self.e, "e")]
        columns += [UNITLESS.strip(getattr(self, name), "angle", name) for name in _ANGLES]
        try:
            columns = list(np.broadcast_arrays(*columns))
        except ValueError as error:
            raise InvalidInput(f"elements have shapes {[c.shape for c in columns]}; expected equal ones") from error
        return np.stack([c.ravel() for c in columns], axis=1), columns[0].shape

    def to_cartesian(self, mu: Any) -> tuple[Array, Array]:
        """Return the relative position and velocity.

        Parameters
        ----------
        mu : float or Quantity
            G times the sum of the masses: a Quantity if ``a`` is one, and otherwise a number in the unit of ``a`` and
            the wanted unit of time. If ``mu`` is the value of :meth:`fullbody.System.mu`, a plain ``a`` is in the unit
            of that system.

        Returns
        -------
        r, v : ndarray or Quantity, (3,) or (..., 3)
            Position and velocity, which are Quantities if ``mu`` is one.
        """
        mu, length, rate = mu_and_units(self.a, mu, "a")
        rows, shape = self._rows(in_unit(length, self.a, "a"))
        r, v = _core.elements_to_cartesian(rows, mu)
        position: Any = r.reshape(*shape, 3)
        velocity: Any = v.reshape(*shape, 3)
        return (position, velocity) if length is None else (position * length, velocity * (length * rate))

    @classmethod
    def from_cartesian(cls, r: Any, v: Any, mu: Any, *, frame: Any = None) -> KeplerElements[Any]:
        """Return the osculating elements of a relative position and velocity.

        Parameters
        ----------
        r, v : array_like or Quantity, (3,) or (..., 3)
        mu : float or Quantity
            G times the sum of the masses; as for :meth:`to_cartesian`.
        frame : str or astropy frame, optional
            The frame of ``r`` and ``v``, which becomes the frame of the elements.

        Returns
        -------
        KeplerElements
            Elements as floats, or as Quantities (angles in radians) if ``mu`` is one.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.KeplerElements.from_cartesian([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], mu=1.0).a
        1.0
        """
        r, v = as_quantity(r, "r", "length"), as_quantity(v, "v", "velocity")
        mu, length, rate = mu_and_units(r, mu, "r")
        refuse_mixture({"r": r, "v": v})
        r, v = in_unit(length, r, "r"), in_unit(None if length is None else length * rate, v, "v")
        if r.shape != v.shape or r.ndim == 0 or r.shape[-1] != 3:
            raise InvalidInput(f"r and v have shapes {r.shape} and {v.shape}; expected (..., 3) for both")
        rows = _core.cartesian_to_elements(r.reshape(-1, 3), v.reshape(-1, 3), mu)
        columns = [c.reshape(r.shape[:-1]) if r.ndim > 1 else float(c[0]) for c in rows.T]
        if length is not None:
            columns = [columns[0] * length, columns[1], *(c * unit_named("rad") for c in columns[2:])]
        return computed(columns, frame)

    def to_frame(self, origin: Any = None, target: Any = None) -> KeplerElements[_T]:
        """Return the elements of this orbit with its angles referred to another frame.

        Parameters
        ----------
        origin : str or astropy frame, optional
            The frame of these elements; by default their own ``frame``.
        target : str or astropy frame
            The new frame: ``"ecliptic"``, ``"equatorial"`` or a frame of astropy; see :mod:`fullbody.frames`.

        Raises
        ------
        InvalidInput
            If the frames differ by more than a rotation, and if the frame of the elements is not known.

        Examples
        --------
        An orbit in the ecliptic is inclined to the equator by the obliquity:

        >>> import fullbody, numpy as np
        >>> orbit = fullbody.KeplerElements(a=2.0, e=0.1, i=0.0, Omega=0.0, omega=0.5, M=1.0, frame="ecliptic")
        >>> round(float(np.degrees(orbit.to_frame(target="equatorial").i)), 4)
        23.4393
        """
        from ..frames import rotate

        if target is None:
            raise InvalidInput("the target of to_frame is not given; expected target='equatorial', or another frame")
        origin = self.frame if origin is None else origin
        if origin is None:
            # A wrong guess would rotate the elements and give a result that looks plausible.
            expected = "expected origin='ecliptic', or another, or the elements of a run whose system has a frame"
            raise InvalidInput(f"the frame that these elements are in is not known; {expected}")
        unitless = computed([_length_number(self.a), *(getattr(self, n) for n in ("e", *_ANGLES))])
        r, v = unitless.to_cartesian(1.0)
        rotated = KeplerElements.from_cartesian(rotate(r, origin, target), rotate(v, origin, target), 1.0)
        columns: list[Any] = [self.a, self.e]
        for name in _ANGLES:
            value, angle = getattr(rotated, name), getattr(self, name)
            if is_quantity(angle):
                value = (value * unit_named("rad")).to(angle.unit)
            columns.append(value)
        return computed(columns, target)

    def period(self, mu: Any) -> _T:
        """Return the orbital period; a hyperbola, which has none, is refused.

        Parameters
        ----------
        mu : float or Quantity
            Gravitational parameter, as for :meth:`to_cartesian`.

        Raises
        ------
        InvalidInput
            For a hyperbola.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.KeplerElements(1.0, 0.0, 0.0, 0.0, 0.0, 0.0).period(mu=1.0)
        6.283185307179586
        """
        mu, length, rate = mu_and_units(self.a, mu, "a")
        rows, shape = self._rows(in_unit(length, self.a, "a"))
        period = _core.period(rows, mu).reshape(shape)
        value: Any = float(period) if period.ndim == 0 else period
        return value if length is None else value / rate

    def __len__(self) -> int:
        shape = np.broadcast_shapes(*(np.shape(getattr(self, name)) for name in DIMENSIONS))
        if not shape:
            raise TypeError("the elements are those of one orbit and have no length; expected arrays of elements")
        return int(shape[0])

    def __getitem__(self, index: Any) -> KeplerElements[Any]:
        len(self)
        values = [getattr(self, name) for name in DIMENSIONS]
        return computed([value[index] if np.ndim(value) else value for value in values], self.frame)

    def _parts(self) -> tuple[Any, ...]:
        # The kinds of the frames are compared first, since astropy cannot compare frames of different kinds.
        return (*(getattr(self, name) for name in DIMENSIONS), type(self.frame), self.frame)

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of the elements: one value each, or the first, last, least and greatest; angles in degrees."""
        rows: list[Sequence[str]] = []
        count = 0
        for name in DIMENSIONS:
            value = getattr(self, name)
            unit = str(getattr(value, "unit", ""))
            if name not in "ae":
                value = np.rad2deg(value.to_value("rad") if unit else value)
                unit = "deg"
            flat = np.ravel(without_unit(value))
            shown = [flat[0]] if flat.size == 1 else [flat[0], flat[-1], flat.min(), flat.max()] if flat.size else []
            count = max(count, flat.size)
            rows.append((head(name, unit), *(f"{x:.8g}" for x in shown)))
        rows = [(*row, *[row[1]] * 3) if count > 1 and len(row) == 2 else row for row in rows]
        header = ("", "first", "last", "least", "greatest") if count > 1 else ()
        return (Table(f"Kepler elements, {count} sets" if count > 1 else "Kepler elements", header, rows),)

    def __repr__(self) -> str:
        parts = [f"{name}={brief(getattr(self, name))}" for name in DIMENSIONS]
        parts += [] if self.frame is None else [f"frame={self.frame!r}"]
        return f"KeplerElements({', '.join(parts)})"

    def __reduce__(self) -> Any:
        return (computed, ([getattr(self, n) for n in DIMENSIONS], self.frame))


def computed(columns: list[Any], frame: Any = None) -> KeplerElements[Any]:
    """Return elements that the core has computed, without checks."""
    elements = KeplerElements.__new__(KeplerElements)
    for name, value in zip((*DIMENSIONS, "frame"), (*columns, frame), strict=True):
        object.__setattr__(elements, name, value)
    return elements


def _length_number(a: Any) -> Any:
    if is_quantity(a):
        strip_to(a, unit_named("m"), "a")
        return a.value
    return a
