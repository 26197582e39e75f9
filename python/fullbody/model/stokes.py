"""Shapes defined by their gravity: Stokes coefficients."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.arguments import refuse_mixture
from ..base.attributes import Attribute
from ..base.kinds import Number, choice, whole_number, with_unit
from ..base.limits import POSITIVE
from ..base.units import Units, as_quantity, is_quantity, need, numbers
from ..base.values import ScalarFields
from ..errors import InvalidInput
from ..typing import Floats
from .geodesic import degrees

#: The relative deviation of a tensor of inertia from the second degree that counts as rounding of published numbers.
_ROUNDED = 1e-6


class StokesCoefficients(ScalarFields):
    """A shape defined by its gravity: spherical-harmonic coefficients, inertia and the radius of a sphere.

    The potential outside the sphere is GM/r times the sum of (R/r)^l (C_lm cos m lambda + S_lm sin m lambda) P_lm(sin
    phi), with P_lm without the sign (-1)^m. The body has no surface: contact, occultations and light are refused, and
    its gravity is not known inside the sphere, where particles end.

    The coefficients may refer to any frame, the working frame. The body frame has its origin in the centre of mass,
    which degree 1 gives, and its axes along the principal axes of inertia, which degree 2 gives;
    :attr:`fullbody.Body.working_frame` is the position and attitude of the working frame in the body frame.

    Parameters
    ----------
    C, S : array_like, (L + 1, L + 1)
        Coefficients by degree l and order m, for degrees up to an L from 2 to 60. C[0, 0] is 1 or, as in many files, 0;
        numbers beyond m = l and S[:, 0] are zero.
    reference_radius : float or Quantity
        The radius R to which they refer.
    inertia : float, array_like or Quantity, (), (3,) or (3, 3)
        Inertia of unit mass about the centre of mass, a length squared: a third of the trace of its tensor, from which
        the moments follow by degree 2. The tensor's diagonal, or the whole tensor, along the axes of the working frame
        must agree with degree 2 to 1e-6.
    radius : float or Quantity, optional
        The radius of a sphere about the origin that contains the body; by default `reference_radius`.
    normalization : {"4pi", "unnormalized"}
        Whether the functions have a mean square of one over the sphere, as in geodesy (Kaula 1966, Theory of Satellite
        Geodesy), or no factors: C20 = ((A + B)/2 - C)/(M R^2), C22 = (B - A)/(4 M R^2) by moments of inertia A, B, C.

    Raises
    ------
    InvalidInput
        For arrays of other shapes, numbers that are not finite, an inertia that contradicts degree 2, that no body has,
        or that does not fit into the sphere, and if only some of the lengths have units.

    Examples
    --------
    >>> import fullbody
    >>> C, S = [[1, 0, 0], [0, 0, 0], [-0.02, 0, 0.003]], [[0] * 3] * 3
    >>> shape = fullbody.StokesCoefficients(
    ...     C, S, reference_radius=0.4, inertia=0.06, normalization="unnormalized"
    ... )
    >>> shape
    StokesCoefficients(degree 2, reference_radius=0.4)
    >>> fullbody.Body(shape, mass=2.0).inertia.round(6).tolist()
    [0.115947, 0.119787, 0.124267]
    """

    __slots__ = ("_C", "_S", "_inertia", "_made", "_mu", "_radius", "_reference_radius")

    def __init__(
        self,
        C: Any,
        S: Any,
        *,
        reference_radius: Any,
        inertia: Any,
        radius: Any = None,
        normalization: str = "4pi",
    ) -> None:
        self._C, self._S = _coefficients(C, "C"), _coefficients(S, "S")
        if self._C.shape != self._S.shape:
            raise InvalidInput(f"S is of shape {self._S.shape}; expected that of C, {self._C.shape}")
        if self._S[:, 0].any():
            raise InvalidInput("S[:, 0] is not zero; expected zeros, since these coefficients have no effect")
        if choice(normalization, "normalization", ("4pi", "unnormalized")) == "unnormalized":
            factors = _norms(len(self._C) - 1)
            self._C, self._S = self._C / factors, self._S / factors
        if self._C[0, 0] == 0.0:
            self._C[0, 0] = 1.0
        self._reference_radius = Number("length", POSITIVE)(reference_radius, "reference_radius")
        self._radius = self._reference_radius if radius is None else Number("length", POSITIVE)(radius, "radius")
        lengths = {"reference_radius": self._reference_radius, "radius": self._radius}
        has_units = refuse_mixture(lengths | {"inertia": as_quantity(inertia, "inertia", "area")})
        units = Units((self._reference_radius.unit, "s", "kg")) if has_units else Units()
        tensor = units.strip(inertia, "area", "inertia")
        if tensor.shape not in ((), (3,), (3, 3)):
            raise InvalidInput(f"inertia is of shape {tensor.shape}; expected (), (3,) or (3, 3)")
        mean = float(tensor if tensor.shape == () else (tensor.sum() if tensor.ndim == 1 else np.trace(tensor)) / 3.0)
        reference, largest = (units.number(length, "length", "radius") for length in lengths.values())
        self._made = _core.StokesCoefficients(_packed(self._C, self._S), reference, mean, largest)
        self._refuse_contradiction(tensor, mean)
        self._inertia = units.attach(mean, "area")
        self._mu: Any = None
        for array in (self._C, self._S):
            array.flags.writeable = False

    def _refuse_contradiction(self, tensor: Floats, mean: float) -> None:
        """Raise an error if a tensor of inertia, or its diagonal, differs from the one of degree 2."""
        _, attitude = self._made.working_frame
        rotation = _core.rotation_matrices(np.array([attitude]))[0]
        tensor_of_core = rotation.T @ np.diag(self._made.inertia_per_mass) @ rotation
        if tensor.ndim == 1:
            tensor_of_core = tensor_of_core.diagonal()
        if tensor.ndim and np.abs(tensor_of_core - tensor).max() > _ROUNDED * mean:
            expected = f"{tensor_of_core.tolist()}, which degree 2 gives for the same trace, or a third of that trace"
            raise InvalidInput(f"inertia is {tensor.tolist()}; expected {expected}")

    C = Attribute[Floats]("_C", "Cosine coefficients (L + 1, L + 1) in the 4 pi normalisation, in the working frame.")
    S = Attribute[Floats]("_S", "Sine coefficients (L + 1, L + 1) in the 4 pi normalisation, in the working frame.")
    degree = Attribute[int](lambda shape: len(shape._C) - 1, "The highest degree.")
    reference_radius = Attribute[Any]("_reference_radius", "The radius to which the coefficients refer.")
    radius = Attribute[Any]("_radius", "The radius of a sphere about the origin of the working frame around the body.")
    inertia = Attribute[Any]("_inertia", "A third of the trace of the inertia tensor of unit mass, a length squared.")
    mu = Attribute[Any]("_mu", "GM of the file that was read; ``None`` for coefficients of another origin.")
    semi_axes = Attribute[None](lambda shape: None, "``None``, since the shape has no surface.")

    def unnormalized(self) -> tuple[Floats, Floats]:
        """Return the coefficients C, S (L + 1, L + 1) without normalisation.

        Examples
        --------
        >>> import fullbody
        >>> ball = fullbody.Body(fullbody.Ellipsoid(2.0, 2.0, 1.0), mass=1.0).harmonics(4)
        >>> round(float(ball.unnormalized()[0][2, 0]), 12)  # (c^2 - a^2)/5 for a reference radius a = 2
        -0.15
        """
        factors = _norms(self.degree)
        return self._C * factors, self._S * factors

    @classmethod
    def read(
        cls, path: str | PathLike[str], *, inertia: Any, radius: Any = None, degree: int | None = None
    ) -> StokesCoefficients:
        """Read coefficients, and :attr:`mu`, from a file of the format ICGEM (``.gfc``) or SHADR (any other suffix).

        The reader is that of pyshtools (Wieczorek & Meschede 2018, Geochem. Geophys. Geosyst. 19, 2574).

        Parameters
        ----------
        path : path-like
        inertia, radius
            As for the class, with units; the files do not have them.
        degree : int, optional
            The highest degree to read, from 2 to 60; by default that of the file.

        Raises
        ------
        InvalidInput
            For a file that is not of the format, and as for the class.
        ModuleNotFoundError
            If pyshtools (the extra ``shapes``) is missing.
        """
        with need("shapes", "reading gravity coefficients"):
            from pyshtools.shio import read_icgem_gfc, shread
        from astropy import units as u

        path = Path(path)
        most = None if degree is None else whole_number(degree, "degree", 2, 60)
        try:
            if path.suffix.lower() == ".gfc":
                table, mu, reference = read_icgem_gfc(str(path), lmax=most, quiet=True)
                mu, reference = mu * u.m**3 / u.s**2, reference * u.m
            else:
                table, last, header = shread(str(path), lmax=most, header=True)
                table = table[:, : last + 1, : last + 1]
                mu, reference = float(header[1]) * u.km**3 / u.s**2, float(header[0]) * u.km
                if int(header[5]) != 1:
                    table = table / _norms(last)
        except FileNotFoundError:
            raise FileNotFoundError(f"no file {path}") from None
        except (ValueError, IndexError, KeyError, TypeError, AttributeError, RuntimeError, OSError) as error:
            raise InvalidInput(f"{path} is not a table of gravity coefficients that can be read: {error}") from error
        shape = cls(table[0], table[1], reference_radius=reference, inertia=inertia, radius=radius)
        shape._mu = mu
        return shape

    @classmethod
    def from_inertia_integrals(cls, integrals: Any, *, radius: Any) -> StokesCoefficients:
        """Take a body by its inertia integrals (Hou, Scheeres & Xin 2017, Celest. Mech. Dyn. Astron. 127, 369), as
        GUBAS.

        Parameters
        ----------
        integrals : array_like, (L + 1, L + 1, L + 1)
            Integrals of x^i y^j z^k dm at [i, j, k], in any unit of mass and powers of the unit of `radius`; numbers at
            i + j + k > L are not used. GUBAS takes kilometres.
        radius : float or Quantity
            The radius of a sphere about the origin that contains the body, and to which the coefficients refer.

        Raises
        ------
        InvalidInput
            For an array of another shape, and for the same reasons as the class.

        Examples
        --------
        >>> import fullbody
        >>> import numpy as np
        >>> integrals = np.zeros((3, 3, 3))  # two points of mass 1/2 at x = 1 and -1, and four on the other axes
        >>> integrals[0, 0, 0], integrals[2, 0, 0], integrals[0, 2, 0], integrals[0, 0, 2] = 1.0, 0.5, 0.3, 0.2
        >>> shape = fullbody.StokesCoefficients.from_inertia_integrals(integrals, radius=1.0)
        >>> fullbody.Body(shape, mass=1.0).inertia.round(12).tolist()
        [0.5, 0.7, 0.8]
        """
        table = numbers(integrals, "integrals")
        if table.ndim != 3 or len(set(table.shape)) != 1 or not 3 <= len(table) <= 61:
            expected = "(L + 1, L + 1, L + 1) with L from 2 to 60"
            raise InvalidInput(f"integrals is of shape {table.shape}; expected {expected}")
        if not table[0, 0, 0] > 0.0:
            raise InvalidInput(f"integrals[0, 0, 0] is {table[0, 0, 0]}; expected the mass, a number above zero")
        units = Units((radius.unit, "s", "kg")) if is_quantity(radius) else Units()
        length = Number("length", POSITIVE).unitless(radius, "radius", units)
        degree = len(table) - 1
        powers = np.indices(table.shape).sum(axis=0)
        means = np.where(powers <= degree, table, 0.0) / table[0, 0, 0] / length**powers
        centre = np.array([means[1, 0, 0], means[0, 1, 0], means[0, 0, 1]])
        trace = means[2, 0, 0] + means[0, 2, 0] + means[0, 0, 2] - centre @ centre
        C, S = _from_monomials(means)
        inertia = units.attach(2.0 / 3.0 * trace * length**2, "area")
        return cls(C, S, reference_radius=radius, inertia=inertia)

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        return {"radius": (self._radius, "length")}

    def _core(self, units: Units, name: str) -> _core.StokesCoefficients:
        """Return the core's form of the shape in a system's units."""
        if not is_quantity(self._reference_radius) or not units.defined:
            units.strip(self._reference_radius, "length", f"reference radius of {name}")
            return self._made
        reference = units.number(self._reference_radius, "length", f"reference radius of {name}")
        radius = units.number(self._radius, "length", f"radius of {name}")
        mean = units.number(self._inertia, "area", f"inertia of {name}")
        return _core.StokesCoefficients(_packed(self._C, self._S), reference, mean, radius)

    def _with(self, units: Units, G: float) -> StokesCoefficients:
        """Return the shape in a system with units: its plain numbers become Quantities in them."""
        if is_quantity(self._reference_radius):
            return self
        reference, radius = (with_unit(value, "length", units) for value in (self._reference_radius, self._radius))
        inertia = with_unit(self._inertia, "area", units)
        return StokesCoefficients(self._C, self._S, reference_radius=reference, inertia=inertia, radius=radius)

    def __repr__(self) -> str:
        return f"StokesCoefficients(degree {self.degree}, reference_radius={self._reference_radius})"

    def _parts(self) -> tuple[Any, ...]:
        return (self._C, self._S, self._reference_radius, self._inertia, self._radius)

    def __hash__(self) -> int:
        return hash((StokesCoefficients, self._C.tobytes(), self._S.tobytes()))

    def __reduce__(self) -> Any:
        packed = _packed(self._C, self._S)
        return from_packed, (packed, self._reference_radius, self._inertia, self._radius, self._mu)


def from_packed(packed: Any, reference: Any, inertia: Any, radius: Any, mu: Any = None) -> StokesCoefficients:
    """Return the shape of coefficients in the core's order, with the other arguments of the class."""
    shape = StokesCoefficients(*_unpacked(packed), reference_radius=reference, inertia=inertia, radius=radius)
    shape._mu = mu
    return shape


def harmonics_of(body: _core.Body, degree: int, units: Units, radius: float | None = None) -> StokesCoefficients:
    """Return the coefficients of a body in its own frame; its lengths are in these units.

    They refer to the radius of the sphere around the body, or to another ``radius`` that is not below that.
    """
    packed, reference, inertia, largest = body.harmonics(whole_number(degree, "degree", 2, 60)).given
    if radius is not None:
        packed = packed * (reference / radius) ** degrees(degree)
        reference = largest = radius
    lengths = map(units.attach, (reference, inertia, largest), ("length", "area", "length"))
    return from_packed(packed, *lengths)


def _coefficients(values: Any, what: str) -> Floats:
    """Return a table of coefficients (L + 1, L + 1)."""
    table = numbers(values, what)
    if table.ndim != 2 or table.shape[0] != table.shape[1] or not 3 <= len(table) <= 61:
        raise InvalidInput(f"{what} is of shape {table.shape}; expected (L + 1, L + 1) with L from 2 to 60")
    if np.triu(table, 1).any():
        raise InvalidInput(f"{what} has numbers at m > l; expected zeros there, and rows by degree l")
    return table


def _norms(degree: int) -> Floats:
    """Return the factors sqrt((2 - [m = 0]) (2 l + 1) (l - m)!/(l + m)!) by degree and order; one at m > l."""
    rows, orders = np.indices((degree + 1, degree + 1))
    squares: Any = np.where(orders == 0, 1.0, 2.0) * (2 * rows + 1)
    for k in range(1, 2 * degree + 1):
        squares[(rows - orders < k) & (k <= rows + orders)] /= k
    return np.where(orders <= rows, np.sqrt(squares), 1.0)


def _packed(C: Floats, S: Floats) -> Floats:
    """Return coefficients in the core's order: by degree, and from S_l,l to S_l,1 and C_l,0 to C_l,l."""
    return np.concatenate([np.concatenate([S[n, n:0:-1], C[n, : n + 1]]) for n in range(len(C))])


def _unpacked(packed: Any) -> tuple[Floats, Floats]:
    """Return the tables C and S of coefficients in the core's order."""
    rows = np.asarray(packed, dtype=np.float64)
    degree = int(np.sqrt(len(rows))) - 1
    C, S = np.zeros((degree + 1, degree + 1)), np.zeros((degree + 1, degree + 1))
    for n in range(degree + 1):
        row = rows[n * n : (n + 1) ** 2]
        C[n, : n + 1], S[n, 1 : n + 1] = row[n:], row[:n][::-1]
    return C, S


def _from_monomials(means: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients in the 4 pi normalisation from the means of x^i y^j z^k at [i, j, k].

    The solid harmonics in Schmidt's semi-normalisation are polynomials, made by their recurrences in degree and order;
    their means over the mass are sqrt(2 l + 1) times the coefficients.
    """
    size = len(means)
    C, S = np.zeros((size, size)), np.zeros((size, size))

    def times(polynomial: Floats, axis: int) -> Floats:
        """Return a polynomial times x, y or z; the highest power, which no harmonic has, is dropped."""
        raised = np.roll(polynomial, 1, axis)
        raised[(slice(None),) * axis + (0,)] = 0.0
        return raised

    first = np.zeros((2, *means.shape))
    first[0, 0, 0, 0] = 1.0
    for m in range(size):
        if m > 0:
            factor = np.sqrt((2 * m - 1) / (2 * m)) if m > 1 else 1.0
            cosine, sine = first
            first = factor * np.array([times(cosine, 0) - times(sine, 1), times(sine, 0) + times(cosine, 1)])
        previous, current = np.zeros_like(first), first
        for n in range(m, size):
            C[n, m], S[n, m] = (current * means).sum(axis=(1, 2, 3)) / np.sqrt(2 * n + 1)
            along = np.array([times(part, 2) for part in current])
            square = sum(np.array([times(times(part, axis), axis) for part in previous]) for axis in range(3))
            scale = np.sqrt((n + 1) ** 2 - m**2)
            previous, current = current, ((2 * n + 1) * along - np.sqrt(n**2 - m**2) * square) / scale
    return C, S
