"""The joint posterior of the published values: a fit of the motion in the plane of the orbit, and draws from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import fullbody
import numpy as np
from fullbody import InvalidInput, Run, SymplecticSplitting
from fullbody.observables import eccentricity, mutual_period, orbit_precession
from fullbody.observing import Measured

from . import model
from .inputs import INPUTS

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["FITTED", "OBSERVED_DAYS", "PRIORS", "draws", "orbit", "posterior", "published"]

#: The days after the impact over which observers saw the orbit before it changed, 2022-12-02 (S24).
OBSERVED_DAYS: Final = 67.0
SAMPLES: Final = np.arange(0.0, OBSERVED_DAYS * model.DAY + 1.0, 2.0)
#: The numbers that move the orbit within its plane, which observations of the orbit constrain together.
FITTED: Final = (
    "separation",
    "equatorial",
    "polar",
    "diameter",
    "density",
    "along",
    "radial",
    "miss_radial",
    "a_b",
    "b_c",
    "yaw",
)
#: Those that are drawn from what was known before.
PRIORS: Final = ("normal", "miss_normal", "log_k2_q", "log_k2_q_primary", "byorp")
#: Where the fit begins: near the minimum that it has found from the values of the table, which takes much longer.
START: Final = {
    "separation": 1199.17,
    "equatorial": 422.917,
    "polar": 311.534,
    "diameter": 151.43,
    "density": 2398.64,
} | {"along": -2.58334, "radial": 0.0, "miss_radial": -4.003, "a_b": 1.30821, "b_c": 1.17444, "yaw": 0.0}
#: Of axes that are a, b and c in this order.
LEAST_RATIO: Final = 1.01


def orbit(run: Run) -> list[float]:
    """The mean period in hours, the eccentricity by the distances, and the advance of the apses in degrees a day.

    Raises
    ------
    InvalidInput
        For an orbit whose apses cannot be followed, and for a run with derivatives: they contain the motion across the
        plane, which grows to nothing but round-off within the days observed. A fit then differences complete runs,
        which stay in the plane.
    """
    if run.is_differentiated:
        raise InvalidInput("the run has derivatives, of which those across the plane are round-off; expected none")
    shape, turning = eccentricity(run), orbit_precession(run)
    if shape.free is None or turning.apsidal is None:
        raise InvalidInput("the distance shows no periapsis; expected an orbit whose apses can be followed")
    return [float(mutual_period(run).mean), shape.free, float(np.rad2deg(turning.apsidal) * model.DAY)]


def published() -> Measured:
    """The values that are published of the orbit after the impact."""
    three = [INPUTS[name] for name in ("period", "eccentricity", "precession")]
    return Measured(
        "orbit after the impact", orbit, [one.value for one in three], [one.sigma for one in three], times=SAMPLES
    )


def posterior(progress: Any = False) -> Any:
    """Fit the numbers of the table of inputs to the published orbit."""
    parameters = {}
    for name in FITTED:
        one = INPUTS[name]
        lower = LEAST_RATIO if name in ("a_b", "b_c") else None
        parameters[name] = fullbody.fitting.Free(START[name], prior=(one.value, one.sigma), lower=lower)
    return fullbody.fit(
        model.planar, parameters, published(), integrator=SymplecticSplitting(step=0.5), progress=progress
    )


def draws(fit: Any, count: int, seed: int) -> dict[str, npt.NDArray[np.float64]]:
    """Members: draws from the posterior beside draws of what it does not contain."""
    rng = np.random.default_rng([seed, 1])
    found = {name: np.asarray(column) for name, column in fit.draw(count, seed).columns.items()}
    return found | {name: rng.normal(INPUTS[name].value, INPUTS[name].sigma, count) for name in PRIORS}
