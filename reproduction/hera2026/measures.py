"""Measurements of a run: the orbits that observers would fit, and the attitude of Dimorphos at some dates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from fullbody import Run, observables
from fullbody.errors import InvalidInput

from . import model, posterior
from .ellipse import fitted_ellipse
from .inputs import ARRIVAL, DATES, IMPACT

__all__ = [
    "ARRIVAL_TIME",
    "CHANGE_DAYS",
    "END",
    "SPACING",
    "WINDOW",
    "early",
    "hours",
    "measure",
    "observed_orbit",
    "outcome",
    "outcome_at_arrival",
    "wrapped",
]


def hours(date: str) -> float:
    """Return the hours from the impact to a date."""
    return float((np.datetime64(date, "ms") - np.datetime64(IMPACT, "ms")) / np.timedelta64(1, "ms") / 3.6e6)


#: Hours: between samples; from the impact to the end of the runs and to arrival, multiples of the spacing; of a window.
SPACING: Final = 2.0
END: Final = SPACING * round(hours(DATES[-1]) / SPACING)
ARRIVAL_TIME: Final = SPACING * round(hours(ARRIVAL) / SPACING)
WINDOW: Final = posterior.OBSERVED_DAYS * model.DAY
#: The day after the impact at which the second interval of observations ends.
CHANGE_DAYS: Final = 120.0
#: The roll above which Dimorphos counts as rolling, and the pitch or yaw above which it tumbles end over end.
LIMIT: Final = np.deg2rad(60.0)
#: The hours before arrival whose angles are recorded.
LAST_HOURS: Final = 96.0


def early(run: Run) -> dict[str, Any]:
    """Return the orbits in both intervals of observations, and when a roll begins; nothing for a shorter run."""
    if len(run.time) <= _index(CHANGE_DAYS * model.DAY):
        return {}
    first, second = _index(WINDOW), _index(CHANGE_DAYS * model.DAY)
    return {
        **observed_orbit("", run[: first + 1]),
        **observed_orbit("_later", run[first : second + 1]),
        "tumbling_time": observables.tumbles(run[: second + 1], limit=LIMIT).time,
    }


def measure(run: Run, end: float = END) -> dict[str, Any]:
    """Return the measurements of a member, with the reasons for missing ones in ``unmeasured``."""
    reasons: list[str] = []

    def measured(part: Callable[[Run], dict[str, Any]], interval: Run) -> dict[str, Any]:
        try:
            return part(interval)
        except InvalidInput as error:
            reasons.append(str(error))
            return {}

    result = measured(_fate, run) | observables.drift(run).as_dict() | measured(early, run)
    result["lock_lost"] = float(sum(run.switched_off.values()))
    dates = [_index(SPACING * round(hours(date) / SPACING)) for date in DATES]
    largest = [_largest(run, last) for last in dates]
    result |= {
        f"{name}_by_date": np.array([angles[k] for angles in largest])
        for k, name in enumerate(("roll", "pitch", "yaw"))
    }
    last = _index(min(ARRIVAL_TIME, end))
    if len(run.time) > last:
        window = run[last - _index(WINDOW) : last + 1]
        angles = zip(("roll", "pitch", "yaw"), _largest(run, last), strict=True)
        result |= {f"last_{name}": angle for name, angle in angles} | _state(window)
        for part in (_rotation, _libration, _orbit):
            result |= measured(part, window)
    return result | {"unmeasured": "; ".join(reasons)}


def wrapped(angle: Any) -> Any:
    """Return an angle between minus and plus half a turn."""
    return (np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi


def _fate(run: Run) -> dict[str, Any]:
    return observables.fate(run).as_dict()


def _index(time: float) -> int:
    return round(time / SPACING)


def observed_orbit(suffix: str, run: Run) -> dict[str, float]:
    """Return the fitted ellipse of an interval by names that end in a suffix."""
    ellipse = fitted_ellipse(run)
    names = ("period", "eccentricity", "precession", "coherence")
    return {f"observed_{name}{suffix}": getattr(ellipse, name) for name in names}


def _largest(run: Run, last: int) -> npt.NDArray[np.float64]:
    """Return the largest roll, pitch and yaw in degrees of the window that ends at a sample; NaN without it."""
    if len(run.time) <= last:
        return np.full(3, np.nan)
    window = run[max(0, last - _index(WINDOW)) : last + 1]
    return np.asarray(np.rad2deg(np.minimum(observables.tumbles(window, limit=LIMIT).largest, np.pi)))


def _state(run: Run) -> dict[str, Any]:
    """Return the state at the end of a run and the angles of its last days."""
    end = run[-1]
    return {
        "angles": wrapped(observables.roll_pitch_yaw(run[-_index(LAST_HOURS) - 1 :])),
        "state": np.concatenate([end.position, end.velocity, end.attitude, end.spin], axis=1),
    }


def _rotation(run: Run) -> dict[str, Any]:
    """Return the mean rate of rotation and the obliquity."""
    obliquity = observables.obliquity(run)
    return {
        "spin": np.linalg.norm(run.spin[:, 1], axis=1).mean(),
        "obliquity": np.rad2deg(obliquity.mean()),
        "obliquity_largest": np.rad2deg(obliquity.max()),
    }


def _libration(run: Run) -> dict[str, Any]:
    """Return the amplitude in degrees and the period of the strongest term in hours."""
    libration = observables.libration(run, n=2)
    if libration.amplitude is None:
        return {}
    return {
        "libration": np.rad2deg(libration.amplitude),
        "libration_period": 2.0 * np.pi / libration.frequencies[0] if len(libration.frequencies) else np.nan,
    }


def _orbit(run: Run) -> dict[str, Any]:
    """Return the fitted ellipse, and the mean semi-major axis and eccentricity of single revolutions."""
    ellipse, shape = fitted_ellipse(run), observables.orbit_shape(run)
    return {
        "period": ellipse.period,
        "precession": ellipse.precession,
        "coherence": ellipse.coherence,
        "semi_major_axis": shape.a.mean(),
        "eccentricity": shape.e.mean(),
    }


def outcome_at_arrival(result: Any) -> npt.NDArray[Any]:
    """Return the outcome (M,) of each member of a dataset in the window before arrival."""
    return outcome(result.last_roll.values, result.last_pitch.values, result.last_yaw.values, result.fate.values)


def outcome(roll: Any, pitch: Any, yaw: Any, fate: Any) -> npt.NDArray[Any]:
    """Return a word for each member: the state of Dimorphos in a window, or why it is not known.

    Parameters
    ----------
    roll, pitch, yaw : array_like, (M,)
        The largest angles of the window, degrees; NaN without it.
    fate : array_like of str, (M,)
        ``"contact"``, ``"escape"`` and ``"unfinished"`` are fates of :func:`fullbody.observables.fate`; empty for a
        start that was refused, ``"failed"``.
    """
    limit = np.rad2deg(LIMIT)
    words = np.full(np.shape(roll), "locked", dtype=object)
    words[np.asarray(roll) > limit] = "rolling"
    words[(np.asarray(pitch) > limit) | (np.asarray(yaw) > limit)] = "end over end"
    words[~np.isfinite(yaw)] = "unmeasured"
    fates = np.asarray(fate, dtype=object)
    words[fates != "bound"] = fates[fates != "bound"]
    words[fates == ""] = "failed"
    return words
