"""Radar scattering laws: the cross section per area of a surface by the angle of incidence."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ..base.kinds import Declared, Number, of_kind
from ..base.limits import Limits
from ..base.units import UNITLESS

#: The parameter C of laws without, and with, a peak; R; and the angle of incidence from which on there is no echo.
_EXPONENT, _PEAK = Limits(least=0.0, most=1e6), Limits(least=1e-6, most=1e6)
_CUTOFF = Limits(above=0.0, most=np.pi / 2, text="an angle above zero, at most pi/2")


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
