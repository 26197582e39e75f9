"""Scattering laws of light, phase functions that multiply them, and scattering laws of radar."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, ClassVar

import numpy as np

from ..base.kinds import Declared, Number, function, of_kind
from ..base.limits import FINITE, NOT_NEGATIVE, Limits
from ..base.units import UNITLESS, need, numbers
from ..errors import InvalidInput
from ..typing import Floats

#: The parameter C of laws without, and with, a peak; R; and the angle of incidence from which on there is no echo.
_EXPONENT, _PEAK = Limits(least=0.0, most=1e6), Limits(least=1e-6, most=1e6)
_CUTOFF = Limits(above=0.0, most=np.pi / 2, text="an angle above zero, at most pi/2")


@dataclass(frozen=True, eq=False)
class Law(Declared):
    """Base class of the scattering laws.

    With mu and mu0 the cosines of emission and incidence, the brightness of a surface element dS is the law times dS,
    times the phase function, times the body's albedo.
    """

    phase_function: Callable[[Floats], Any] | None = field(
        default=None, metadata=of_kind(partial(function, expected="a function of the phase angle, such as HG(0.15)"))
    )

    def _describe(self) -> tuple[float, ...]:
        """Return the law's two factors, or Hapke's five parameters; a law that the core does not have is refused."""
        raise InvalidInput(
            f"{type(self).__name__} is not one of the scattering laws LommelSeeliger, Lambert, LommelSeeligerLambert "
            "and Hapke; a function of your own can only be their phase_function"
        )

    def _phase(self, angle: Floats) -> Floats:
        """Return the factors for phase angles, after checking that they are finite and not negative."""
        if self.phase_function is None:
            return np.ones_like(angle)
        factor_values = self.phase_function(angle)
        factor = numbers(factor_values, f"what the phase function of {self!r} returns")
        if factor.shape not in ((), angle.shape):
            raise InvalidInput(
                f"the phase function of {self!r} returns an array of shape {factor.shape}; expected {angle.shape}"
            )
        factor = np.broadcast_to(factor, angle.shape)
        if not (good := NOT_NEGATIVE.contain(factor)).all():
            k = int(np.argmin(good))
            raise InvalidInput(
                f"the phase function of {self!r} returns {factor[k]} at the phase angle {angle[k]:.9g}; "
                "expected finite numbers, zero or above"
            )
        return np.array(factor)


@dataclass(frozen=True)
class LommelSeeliger(Law):
    """Lommel-Seeliger's law, mu mu0 / (mu + mu0), for dark surfaces with single scattering.

    Parameters
    ----------
    phase_function : callable, optional
        A function of the phase angles, an array (K,) in radians, that gives the factors (K,) of the brightness.

    Examples
    --------
    >>> from fullbody import observing
    >>> observing.LommelSeeliger(phase_function=observing.HG(0.15))
    LommelSeeliger(phase_function=HG(G=0.15))
    """

    def _describe(self) -> tuple[float, ...]:
        return (1.0, 0.0)


@dataclass(frozen=True)
class Lambert(Law):
    """Lambert's law, mu mu0, for bright diffuse surfaces.

    Parameters
    ----------
    phase_function : callable, optional
        A function of the phase angles, an array (K,) in radians, that gives the factors (K,) of the brightness.
    """

    def _describe(self) -> tuple[float, ...]:
        return (0.0, 1.0)


@dataclass(frozen=True)
class LommelSeeligerLambert(Law):
    """The sum of Lommel-Seeliger's and a fraction of Lambert's law: mu mu0 (1 / (mu + mu0) + lambert).

    Parameters
    ----------
    phase_function : callable, optional
        A function of the phase angles, an array (K,) in radians, that gives the factors (K,) of the brightness.
    lambert : float
        The factor of Lambert's law, zero or above; 0.1 is usual in the inversion of light curves (Kaasalainen & Torppa
        2001).
    """

    lambert: float = field(default=0.1, metadata=of_kind(Number()))

    def _describe(self) -> tuple[float, ...]:
        return 1.0, self._unitless(UNITLESS)["lambert"]


@dataclass(frozen=True)
class Hapke(Law):
    """Hapke's law (1981, 1984, 1986), pi times the bidirectional reflectance times mu.

    With w the single-scattering albedo, g the phase angle, H(x) = (1 + 2 x) / (1 + 2 x sqrt(1 - w)), the opposition
    surge B(g) = B0 / (1 + tan(g/2) / h) and the phase function P of Henyey & Greenstein,

    ``(w / 4) mu mu0 / (mu + mu0) [(1 + B(g)) P(g) + H(mu) H(mu0) - 1]``,

    with the correction of 1984 for macroscopic roughness.

    Parameters
    ----------
    phase_function : callable, optional
        A further factor. The law has its own dependence on the phase angle.
    single_scattering_albedo : float
        The number w, from 0 to 1.
    opposition_amplitude : float
        The number B0, zero or above.
    opposition_width : float
        The number h, above zero.
    asymmetry : float
        Asymmetry of P, between -1 and 1; negative values scatter back.
    roughness : float or Quantity
        Mean slope angle theta-bar, radians. The brightness of a rough surface is integrated to 1e-9 rather than to
        round-off, and has no derivatives.

    Notes
    -----
    The defaults are an example of a smooth surface, without roughness; they are no measurement of a body or of a class
    of asteroids. Take the parameters from a fit to the body's own phase curve.
    """

    single_scattering_albedo: float = field(default=0.23, metadata=of_kind(Number()))
    opposition_amplitude: float = field(default=1.32, metadata=of_kind(Number()))
    opposition_width: float = field(default=0.02, metadata=of_kind(Number()))
    asymmetry: float = field(default=-0.35, metadata=of_kind(Number()))
    roughness: Any = field(default=0.0, metadata=of_kind(Number("angle")))

    def _describe(self) -> tuple[float, ...]:
        return tuple(self._unitless(UNITLESS).values())


@dataclass(frozen=True)
class HG:
    """The phase function of the H, G system (Bowell et al. 1989, Asteroids II, 524), one at zero phase.

    Parameters
    ----------
    G : float
        Slope parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from fullbody import observing
    >>> np.round(-2.5 * np.log10(observing.HG(0.15)(np.radians([0.0, 10.0, 20.0]))), 3) + 0.0
    array([0.   , 0.647, 1.   ])
    """

    G: float = 0.15

    def __call__(self, angle: Any) -> Floats:
        """Return the factor of the brightness at phase angles in radians."""
        half = np.tan(0.5 * numbers(angle, "phase angle"))
        first, second = (np.exp(-a * half**b) for a, b in ((3.33, 0.63), (1.87, 1.22)))
        return (1.0 - self.G) * first + self.G * second


@dataclass(frozen=True)
class HG1G2:
    """The phase function of the H, G1, G2 system (Muinonen et al. 2010, Icarus 209, 542), one at zero phase.

    Parameters
    ----------
    G1, G2 : float

    Notes
    -----
    The nodes and end slopes of its splines are those of Penttilä et al. (2016), Planet. Space Sci. 123, 117. The slope
    of the third function at zero is -0.10630097, with which the slopes at its other nodes are the published ones;
    programs that take -1.0630097 differ by up to 0.001. It needs scipy.
    """

    G1: float
    G2: float

    def __call__(self, angle: Any) -> Floats:
        """Return the factor of the brightness at phase angles in radians."""
        basis = _basis_of_hg1g2(numbers(angle, "phase angle"))
        return self.G1 * basis[0] + self.G2 * basis[1] + (1.0 - self.G1 - self.G2) * basis[2]


@dataclass(frozen=True)
class LinearExponential:
    """The phase function 1 + a exp(-angle / d) + k angle of light-curve inversion (Kaasalainen et al. 2001, Icarus 153,
    37), which the database DAMIT takes.

    Parameters
    ----------
    a, d, k : float
        Amplitude and width of the opposition effect, and the slope; ``d`` in radians, above zero unless ``a`` is zero,
        and ``k`` per radian, mostly negative.

    Examples
    --------
    >>> from fullbody import observing
    >>> observing.LinearExponential(0.5, 0.1, -0.5)(0.0)
    np.float64(1.5)
    """

    a: float
    d: float
    k: float

    def __post_init__(self) -> None:
        for name in ("a", "d", "k"):
            UNITLESS.number(getattr(self, name), "number", f"{name} of LinearExponential", FINITE)
        if self.a != 0.0 and not self.d > 0.0:
            raise InvalidInput(f"d of LinearExponential is {self.d}; expected a number above zero")

    def __call__(self, angle: Any) -> Floats:
        """Return the factor of the brightness at phase angles in radians."""
        angle = numbers(angle, "phase angle")
        surge = self.a * np.exp(-angle / self.d) if self.a != 0.0 else 0.0
        return np.asarray(1.0 + surge + self.k * angle)[()]


@cache
def _splines() -> tuple[Any, Any, Any]:
    with need("analysis", "HG1G2"):
        from scipy.interpolate import CubicSpline

    def spline(degrees: list[float], values: list[float], first: float, last: float) -> Any:
        return CubicSpline(np.radians(degrees), values, bc_type=((1, first), (1, last)))

    wide = [7.5, 30.0, 60.0, 90.0, 120.0, 150.0]
    near = [0.0, 0.3, 1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 30.0]
    ordinates = [0.75, 0.33486016, 0.1341056, 0.051104756, 0.021465687, 0.0036396989]
    two = [0.925, 0.62884169, 0.31755495, 0.12716367, 0.022373903, 0.00016505689]
    surge = [1.0, 0.83381185, 0.57735424, 0.42144772, 0.2317423, 0.10348178, 0.061733473, 0.016107006, 0.0]
    return (
        spline(wide, ordinates, -6.0 / np.pi, -0.091328612),
        spline(wide, two, -9.0 / (5.0 * np.pi), -8.6573138e-8),
        spline(near, surge, -0.10630097, 0.0),
    )


def _basis_of_hg1g2(angle: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the basis functions: straight lines below 7.5 degrees, and constant beyond the last node."""
    first, second, surge = _splines()
    low, high = np.radians(7.5), np.radians(150.0)
    wide = np.clip(angle, low, high)
    return (
        np.where(angle < low, 1.0 - 6.0 * angle / np.pi, first(wide)),
        np.where(angle < low, 1.0 - 9.0 * angle / (5.0 * np.pi), second(wide)),
        surge(np.clip(angle, 0.0, np.radians(30.0))),
    )


@dataclass(frozen=True)
class RadarLaw(Declared):
    """Base class of the radar scattering laws.

    With theta the angle of incidence, a law is the cross section of a surface element over its own area, not over its
    projection. For a bistatic radar theta is the angle from the normal to the bisector of the directions to both
    antennas.
    """

    #: The name by which the core knows the law.
    _name: ClassVar[str] = ""

    def _describe(self) -> tuple[str, float, float, float]:
        """Return the law's name, C, R and the angle of incidence from which on there is no echo."""
        numbers = self._unitless(UNITLESS)
        return self._name, numbers["C"], numbers["R"], numbers.get("cutoff", np.pi / 2)


@dataclass(frozen=True)
class Cosine(RadarLaw):
    """The cosine law, R (C + 1) cos^(2C)(theta), for diffuse echoes.

    Parameters
    ----------
    C : float
        The exponent, zero or above: 0.5 for a uniformly bright disc, 1 for Lambert's law, larger for a smoother
        surface.
    R : float
        The reflectivity, zero or above. A sphere has the radar albedo R (C + 1) / (C + 1/2), the ratio of its cross
        section to its projected area.

    Examples
    --------
    >>> from fullbody import observing
    >>> observing.Cosine(C=1.6, R=0.3)
    Cosine(C=1.6, R=0.3)
    """

    C: float = field(default=1.0, metadata=of_kind(Number(limits=_EXPONENT)))
    R: float = field(default=1.0, metadata=of_kind(Number(limits=_EXPONENT)))
    _name = "cosine"


@dataclass(frozen=True)
class PeakedLaw(RadarLaw):
    """Base class of the laws with a peak at normal incidence, whose width is C."""

    C: float = field(metadata=of_kind(Number(limits=_PEAK)))
    R: float = field(default=1.0, metadata=of_kind(Number(limits=_EXPONENT)))
    cutoff: Any = field(default=np.pi / 2, metadata=of_kind(Number("angle", limits=_CUTOFF)))


class Gaussian(PeakedLaw):
    """The Gaussian law, R C exp(-C tan^2(theta)) / cos^4(theta), for echoes of gently sloping facets.

    Parameters
    ----------
    C : float
        Width of the peak, above zero: the root mean square of the slopes is about C^(-1/2).
    R : float
        The reflectivity, zero or above.
    cutoff : float or Quantity
        The angle of incidence from which on there is no echo, radians.
    """

    _name = "gaussian"


class Hagfors(PeakedLaw):
    """Hagfors' law, (R C / 2) (cos^4(theta) + C sin^2(theta))^(-3/2), for quasi-specular echoes (Hagfors 1964).

    Parameters
    ----------
    C, R, cutoff
        As for :class:`Gaussian`.
    """

    _name = "hagfors"
