"""Kepler elements."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _core
from ._units import Units, gathered, is_quantity, numbers, scalar, strip_to
from .errors import InvalidInput

__all__ = ["KeplerElements"]

_ANGLES = ("i", "Omega", "omega", "M")


class KeplerElements:
    """Osculating elements of a two-body orbit: one orbit, or arrays of them.

    Parameters
    ----------
    a : float, array_like or Quantity
        Semi-major axis; negative for a hyperbola.
    e : float or array_like
        Eccentricity: 0 <= e < 1 with a > 0, or e > 1 with a < 0. Parabolas have no semi-major axis and are refused.
    i, Omega, omega, M : float, array_like or Quantity
        Inclination, longitude of the ascending node, argument of periapsis, mean anomaly; radians as floats.

    Raises
    ------
    InvalidInput
        For values that describe no orbit.

    Notes
    -----
    Circular orbits are given omega = 0 and M from the node; equatorial ones Omega = 0 and angles from the x-axis.

    Examples
    --------
    >>> import fullbody
    >>> orbit = fullbody.KeplerElements(a=2.0, e=0.5, i=0.0, Omega=0.0, omega=0.0, M=0.0)
    >>> r, v = orbit.to_cartesian(mu=1.0)
    >>> float(r[0]), round(float(v[1]), 6)
    (1.0, 1.224745)
    """

    __slots__ = ("M", "Omega", "a", "e", "i", "omega")

    a: Any
    e: Any
    i: Any
    Omega: Any
    omega: Any
    M: Any

    def __init__(self, a: Any, e: Any, i: Any, Omega: Any, omega: Any, M: Any) -> None:
        for name, value in zip(("a", "e", *_ANGLES), (a, e, i, Omega, omega, M), strict=True):
            object.__setattr__(self, name, gathered(value, name))
        # Any mu will do to have the core check the rest.
        _core.elements_to_cartesian(self._rows(_length_number(self.a))[0], 1.0)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"elements do not change; make new ones with another {name}")

    def _rows(self, a: Any) -> tuple[Any, tuple[int, ...]]:
        """Elements as (K, 6), and the shape they came in."""
        plain = Units()
        columns = [numbers(a, "a"), plain.strip(self.e, "angle", "e")]
        columns += [plain.strip(getattr(self, name), "angle", name) for name in _ANGLES]
        try:
            columns = list(np.broadcast_arrays(*columns))
        except ValueError as error:
            raise InvalidInput(f"elements have shapes {[c.shape for c in columns]}; expected equal ones") from error
        return np.stack([c.ravel() for c in columns], axis=1), columns[0].shape

    def to_cartesian(self, mu: Any) -> tuple[Any, Any]:
        """Relative position and velocity.

        Parameters
        ----------
        mu : float or Quantity
            G times the sum of the masses, in the units of ``a`` and of the time wanted. A Quantity where ``a`` is one.

        Returns
        -------
        r, v : ndarray or Quantity, (3,) or (..., 3)
        """
        length, rate = _orbit_units(self.a, mu)
        a = self.a if length is None else strip_to(self.a, length, "a")
        number = mu if length is None else strip_to(mu, length**3 * rate**2, "mu")
        rows, shape = self._rows(a)
        r, v = _core.elements_to_cartesian(rows, scalar(numbers(number, "mu"), "mu"))
        r, v = r.reshape(*shape, 3), v.reshape(*shape, 3)
        return (r, v) if length is None else (r * length, v * (length * rate))

    @classmethod
    def from_cartesian(cls, r: Any, v: Any, mu: Any) -> KeplerElements:
        """Osculating elements of a relative position and velocity.

        Parameters
        ----------
        r, v : array_like or Quantity, (3,) or (..., 3)
        mu : float or Quantity
            G times the sum of the masses.

        Returns
        -------
        KeplerElements
            With floats, or with Quantities (angles in radians) where ``r`` is one.

        Examples
        --------
        >>> import fullbody
        >>> fullbody.KeplerElements.from_cartesian([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], mu=1.0).a
        1.0
        """
        r, v = gathered(r, "r"), gathered(v, "v")
        length, rate = _orbit_units(r, mu)
        if length is not None:
            r = strip_to(r, length, "r")
            v = strip_to(v, length * rate, "v") if is_quantity(v) else numbers(v, "v")
            mu = strip_to(mu, length**3 * rate**2, "mu")
        elif is_quantity(v):
            raise InvalidInput(f"v has the unit {v.unit}, but r has none; expected both or neither")
        r, v = numbers(r, "r"), numbers(v, "v")
        if r.shape != v.shape or r.ndim == 0 or r.shape[-1] != 3:
            raise InvalidInput(f"r and v have shapes {r.shape} and {v.shape}; expected (..., 3) for both")
        rows = _core.cartesian_to_elements(r.reshape(-1, 3), v.reshape(-1, 3), scalar(numbers(mu, "mu"), "mu"))
        columns = [c.reshape(r.shape[:-1]) if r.ndim > 1 else float(c[0]) for c in rows.T]
        if length is not None:
            from astropy import units as u

            columns = [columns[0] * length, columns[1], *(c * u.rad for c in columns[2:])]
        return cls._trusted(columns)

    def to_frame(self, target: Any, origin: Any = "ecliptic") -> KeplerElements:
        """The same orbit with its angles referred to another frame.

        Parameters
        ----------
        target, origin : str or astropy frame
            The frame wanted and the one that the elements are in: ``"ecliptic"``, ``"equatorial"`` or any of astropy;
            see :mod:`fullbody.frames`.

        Returns
        -------
        KeplerElements

        Raises
        ------
        InvalidInput
            For a frame that astropy does not know.

        Examples
        --------
        An orbit in the ecliptic is inclined to the equator by the obliquity.

        >>> import fullbody, numpy as np
        >>> orbit = fullbody.KeplerElements(a=2.0, e=0.1, i=0.0, Omega=0.0, omega=0.5, M=1.0)
        >>> round(float(np.degrees(orbit.to_frame("equatorial").i)), 4)
        23.4393
        """
        from .frames import turn

        plain = KeplerElements._trusted([_length_number(self.a), *(getattr(self, n) for n in ("e", *_ANGLES))])
        r, v = plain.to_cartesian(1.0)
        turned = KeplerElements.from_cartesian(turn(r, origin, target), turn(v, origin, target), 1.0)
        columns: list[Any] = [self.a, self.e]
        for name in _ANGLES:
            value, given = getattr(turned, name), getattr(self, name)
            if is_quantity(given):
                from astropy import units as u

                value = (value * u.rad).to(given.unit)
            columns.append(value)
        return KeplerElements._trusted(columns)

    @classmethod
    def _trusted(cls, columns: list[Any]) -> KeplerElements:
        """Elements that the core has computed."""
        elements = cls.__new__(cls)
        for name, value in zip(("a", "e", *_ANGLES), columns, strict=True):
            object.__setattr__(elements, name, value)
        return elements

    def period(self, mu: Any) -> Any:
        """Orbital period.

        Parameters
        ----------
        mu : float or Quantity

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
        length, rate = _orbit_units(self.a, mu)
        a = self.a if length is None else strip_to(self.a, length, "a")
        number = mu if length is None else strip_to(mu, length**3 * rate**2, "mu")
        rows, shape = self._rows(a)
        period = _core.period(rows, scalar(numbers(number, "mu"), "mu")).reshape(shape)
        value: Any = float(period) if period.ndim == 0 else period
        return value if length is None else value / rate

    def __len__(self) -> int:
        return len(self.a)

    def __getitem__(self, index: Any) -> KeplerElements:
        return KeplerElements._trusted([getattr(self, name)[index] for name in ("a", "e", *_ANGLES)])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, KeplerElements):
            return NotImplemented
        return all(np.all(getattr(self, n) == getattr(other, n)) for n in ("a", "e", *_ANGLES))

    __hash__ = None  # type: ignore[assignment]

    def _repr_html_(self) -> str:
        from . import tables

        return tables.to_html(tables.of_elements(self))

    def __repr__(self) -> str:
        return "KeplerElements(" + ", ".join(f"{n}={getattr(self, n)}" for n in ("a", "e", *_ANGLES)) + ")"

    def __reduce__(self) -> Any:
        return (KeplerElements._trusted, ([getattr(self, n) for n in ("a", "e", *_ANGLES)],))


def _length_number(a: Any) -> Any:
    if is_quantity(a):
        from astropy import units as u

        strip_to(a, u.m, "a")
        return a.value
    return a


def _orbit_units(length: Any, mu: Any) -> tuple[Any, Any]:
    """Units of length and of inverse time, from a Quantity of length and mu; ``None`` for plain numbers."""
    if is_quantity(length) != is_quantity(mu):
        given, plain = ("the length", "mu") if is_quantity(length) else ("mu", "the length")
        raise InvalidInput(f"{given} has a unit and {plain} has none; expected both or neither")
    if not is_quantity(length):
        return None, None
    from astropy import units as u

    strip_to(length, u.m, "a length")
    strip_to(mu, u.m**3 / u.s**2, "mu")
    # The time that mu is given in, so that results come in the caller's units.
    times = [
        base for base, power in zip(mu.unit.bases, mu.unit.powers, strict=True) if base.is_equivalent(u.s) and power
    ]
    return length.unit, 1 / (times[0] if times else u.s)
