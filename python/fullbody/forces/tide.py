"""Dissipative tides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

import fullbody._core as _core

from ..base.arguments import refuse_mixture
from ..base.kinds import Number, body_index, choice, of_kind
from ..base.limits import POSITIVE
from ..base.rotations import matrices
from ..base.tables import number
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, Units, strip_to
from ..errors import InvalidInput
from ..model.context import Context
from ..model.force import Force


@dataclass(frozen=True, eq=False, repr=False)
class Tide(Force):
    """The tide that one body raises on another, with a constant time lag, valid for any orbit and any spin.

    The force acts on both bodies and the torque on the deformed one. Only the effect of the lag is computed: bodies are
    rigid, and the static bulges of tide and rotation are taken as part of their shapes.

    Parameters
    ----------
    on, by : int or str
        The deformed body, and the body that raises the tide.
    k2 : float
        Love's number of degree two of the deformed body, from 0 to 1.5.
    lag : float or Quantity
        The time by which the bulge lags behind; :func:`lag_from_quality_factor` computes it from a quality factor. The
        law is of first order in the angle by which the body rotates relative to the other one in that time; a run warns
        if this angle exceeds a radian at its start.
    radius : float or Quantity, optional
        Radius of the deformed body; by default that of the sphere of its volume.
    name : str, optional
        Name of the force; by default ``tide on`` the body.

    Notes
    -----
    The law is that of Mignard (1979) and Hut (1981), to first order in the lag; the theory of forces in the
    documentation has its formulas.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
    >>> run = system.with_forces([tide]).integrate(state, 20.0)
    >>> bool(run.work["tide on Alpha"][-1] < 0.0)
    True
    """

    _called = "tide on"

    on: int | str = field(metadata=of_kind(body_index))
    by: int | str = field(metadata=of_kind(body_index))
    k2: float = field(metadata=of_kind(Number()))
    lag: Any = field(metadata=of_kind(Number("time")))
    radius: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE)))

    def _describe(self, context: Context) -> dict[str, Any]:
        return super()._describe(context) | {"radius": self._radius(context, self._index(context, "on"))}

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        lag, radius = (number(units.attach(described[key], of)) for key, of in (("lag", "time"), ("radius", "length")))
        return f"by {described['by']} on {described['on']}, k2 = {number(described['k2'])}, lag {lag}, radius {radius}"

    @classmethod
    def _input_warnings(cls, described: dict[str, Any], start: _core.State, context: Context) -> Iterator[str]:
        """Yield a warning for a relative rotation or a revolution by more than a radian within the lag."""
        on, by, lag = (described[key] for key in ("on", "by", "lag"))
        deformed, raiser = context.index(on), context.index(by)
        r, v = start.position[raiser] - start.position[deformed], start.velocity[raiser] - start.velocity[deformed]
        orbital = np.cross(r, v) / (r @ r)
        spin = matrices(start.attitude[deformed]) @ start.spin[deformed]
        distance = np.linalg.norm(r)
        rates = (spin - orbital, orbital)
        # Only the part of a rate across the line of the centres displaces the bulge.
        relative, revolution = (lag * np.linalg.norm(np.cross(rate, r)) / distance for rate in rates)
        if max(relative, revolution) > 1.0:
            phrase = f"{on} turns relative to {by}" if relative >= revolution else f"{by} goes round {on}"
            yield (
                f"{described['name']} has a lag of {context.units.text(lag, 'time', 4)}, within which {phrase} by "
                f"{np.degrees(max(relative, revolution)):.4g} degrees; a constant time lag is a law of first order in "
                "that angle; expected an angle much smaller than a radian (57.3 degrees): check the unit of the lag"
            )


def lag_from_quality_factor(
    *, Q: float, mean_motion: Any, tide: Literal["eccentricity", "libration", "semidiurnal"], spin: Any = None
) -> Any:
    """Compute the time lag with the same dissipation as a quality factor at one frequency.

    A constant quality factor corresponds to a lag at one frequency only; its tide changes sign abruptly where the spin
    passes the mean motion, while that of a lag does not.

    Parameters
    ----------
    Q : float
        The quality factor.
    mean_motion, spin : float or Quantity
        Mean motion n of the orbit, an angle per time; and for ``"semidiurnal"`` the spin omega of the deformed body.
    tide : {"eccentricity", "libration", "semidiurnal"}
        The tide to which the factor refers. On a synchronous body eccentricity and libration raise a tide of frequency
        n: 1/Q = n lag. A body that turns at another rate omega has the semidiurnal tide: 1/Q = 2 abs(omega - n) lag.

    Examples
    --------
    >>> from fullbody.forces import lag_from_quality_factor
    >>> lag_from_quality_factor(Q=100.0, mean_motion=0.5, tide="semidiurnal", spin=2.5)
    0.0025
    """
    factor = UNITLESS.number(Q, "number", "Q", POSITIVE)
    rates = {"mean_motion": Number("spin", POSITIVE)(mean_motion, "mean_motion")}
    if choice(tide, "tide", ("eccentricity", "libration", "semidiurnal")) == "semidiurnal":
        if spin is None:
            raise InvalidInput("spin is not given; expected that of the deformed body, for the semidiurnal tide")
        rates["spin"] = Number("spin")(spin, "spin")
    elif spin is not None:
        raise InvalidInput(f"spin is {spin!r}; expected none for the tide of {tide}, which has the orbit's frequency")
    time: Any = 1.0
    if refuse_mixture(rates):
        bases = rates["mean_motion"].unit.bases
        time = next((base for base in bases if base.physical_type == "time"), unit_named("s"))
        rates = {name: strip_to(rate, unit_named("rad") / time, name) for name, rate in rates.items()}
    frequency = float(rates["mean_motion"])
    if tide == "semidiurnal":
        frequency = 2.0 * abs(float(rates["spin"]) - frequency)
        UNITLESS.number(frequency, "number", "2 |spin - mean_motion|", POSITIVE)
    return 1.0 / (factor * frequency) * time
