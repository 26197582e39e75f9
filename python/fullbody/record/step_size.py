"""Search for the step of a symplectic splitting by trial runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.limits import POSITIVE, Limits
from ..base.units import UNITLESS
from ..errors import InvalidInput, NotConverged, StepSizeTooSmall
from ..model.context import Context
from ..model.failures import explained
from . import conserved

#: The length of a trial in the shortest orbital period.
_PERIODS = 64
#: The ratio of successive steps, and their range: an eighth of that period down to a 4096th.
_RATIO = 2.0**-0.25
_LONGEST, _SHORTEST = 1 / 8, 1 / 4096
#: A step must also be suitable if it is longer or shorter by this fraction, as a resonance moves with the spin.
_NEIGHBOUR = 0.02
#: The ratio of the errors in the second and first half of a trial above which the error counts as growing.
_GROWTH = 3.0
#: The relative distance to a resonance within which no step is tried, and the highest order of a resonance.
_RESONANCE_WIDTH, _ORDERS = 0.03, 3


def longest_step(
    describe: Callable[[float], dict[str, Any]], context: Context, start: _core.State, energy_error: float, trial: Any
) -> float:
    """Find the longest step that keeps the energy's error below a bound; ``describe`` describes the integrator with a
    step.
    """
    UNITLESS.number(energy_error, "number", "energy_error", Limits(above=0.0, below=1.0))
    if len(context) < 2:
        raise InvalidInput("the system has one body, whose motion the splitting solves at any step; expected more")
    rates = _orbital_rates(start.position, start.velocity, context.masses, context.G)
    period = 2 * math.pi / rates.max()
    length = _PERIODS * period if trial is None else context.units.number(trial, "time", "trial", POSITIVE)
    rotation_rates = _rotation_rates(context, start.spin, rates)

    def error(step: float) -> float:
        """Return the largest error of the energy relative to the orbital energy, or infinity if it grows."""
        core = _core.Simulation(context.core, start, describe(step), "")
        arrays, failed = core.integrate(start.time + length, None, [], False, None, None, (None, False))
        if failed is not None:
            raise explained(failed, context)
        drift = np.abs(conserved.drift("energy_drift_orbital", np.array(arrays["start"]), arrays))
        half = len(drift) // 2
        first, second = drift[:half].max(initial=0.0), drift[half:].max()
        return math.inf if second > _GROWTH * first and second > 0.1 * energy_error else float(max(first, second))

    step, least, reason = _LONGEST * period, (math.inf, math.nan), ""
    while step >= _SHORTEST * period:
        if _resonant(rotation_rates, step):
            step *= _RATIO
            continue
        try:
            size = error(step)
        except (NotConverged, StepSizeTooSmall) as failed:
            size, reason = math.inf, f"; {failed}"
        least = min(least, (size, step))
        neighbours = (step * (1 - _NEIGHBOUR), step * (1 + _NEIGHBOUR))
        if size <= energy_error and all(error(other) <= 2 * energy_error for other in neighbours):
            return _rounded(step)
        # The error falls with at least the sixth power of the step, but only until round-off remains.
        powers = math.log(size / energy_error) / math.log(1 / _RATIO) / 12 if energy_error < size < math.inf else 1.0
        step *= _RATIO ** max(1, math.floor(powers))
    attach = context.units.attach
    raise NotConverged(
        f"no step keeps the error of the energy below {energy_error:g} for {attach(length, 'time'):.5g}: the least is "
        f"{least[0]:.1e} at a step of {attach(least[1], 'time'):.3g}{reason}; take a larger energy_error, or Verner98"
    )


def _orbital_rates(position: Any, velocity: Any, masses: Any, constant: float) -> Any:
    """Return mean motions of bodies about the barycentre of those before them; circular ones for open orbits."""
    rates = []
    for body in range(1, len(masses)):
        fractions = masses[:body] / masses[:body].sum()
        r, v = (vectors[body] - fractions @ vectors[:body] for vectors in (position, velocity))
        mu, distance = constant * masses[: body + 1].sum(), np.linalg.norm(r)
        inverse = 2 / distance - v @ v / mu
        rates.append(math.sqrt(mu * (inverse if inverse > 0 else 1 / distance) ** 3))
    return np.array(rates)


def _rotation_rates(context: Context, spin: Any, rates: Any) -> Any:
    """Return the rates at which triaxial bodies rotate relative to others, for either sense of the orbit."""
    triaxial = [len(set(body.inertia.tolist())) == 3 for body in context.bodies]
    spin_sizes = np.linalg.norm(spin, axis=1)[triaxial]
    return np.abs(np.subtract.outer(spin_sizes, [rates, -rates])).ravel()


def _resonant(rotation_rates: Any, step: float) -> bool:
    """Return whether a body turns relative to another by about a multiple of a half turn in one, two or three steps, at
    which the torque is the same, so that the errors of the steps add up.
    """
    half_revolutions = np.outer(np.arange(1, _ORDERS + 1), rotation_rates * step / math.pi)
    multiples = np.round(half_revolutions)
    return bool((np.abs(half_revolutions - multiples) < _RESONANCE_WIDTH * multiples).any())


def _rounded(step: float) -> float:
    """Round a step down to three digits."""
    unit = 10.0 ** (math.floor(math.log10(step)) - 2)
    return float(f"{math.floor(step / unit) * unit:.3g}")
