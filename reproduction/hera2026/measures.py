"""What is recorded of a member: its outcome, the orbit after the impact, and the state at arrival with its history."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from fullbody import InvalidInput, Run, ensembles, observables
from fullbody.frames import pole_vector

from . import model, posterior
from .inputs import ARRIVAL, IMPACT, INPUTS

__all__ = ["END", "SPACING", "WINDOW", "measure", "outcome", "within_the_window", "wrapped"]

#: Hours from the impact to arrival, between samples, and in the windows at both ends of a run.
END: Final = float(
    np.round((np.datetime64(ARRIVAL, "ms") - np.datetime64(IMPACT, "ms")) / np.timedelta64(1, "ms") / 3.6e6, 6)
)
SPACING: Final = 2.0
WINDOW: Final = posterior.OBSERVED_DAYS * model.DAY
#: Beyond this roll, pitch or yaw Dimorphos counts as turning over; and beyond this yaw as no longer locked.
LIMIT: Final = np.deg2rad(60.0)
#: The hours at the end of which the angles themselves are kept.
FAN: Final = 96.0


def measure(run: Run, end: float = END) -> dict[str, Any]:
    """All numbers of a member, and in ``unmeasured`` why some of them are missing."""
    missing: list[str] = []

    def told(part: Callable[[Run], dict[str, Any]], of: Run) -> dict[str, Any]:
        try:
            return part(of)
        except InvalidInput as error:
            missing.append(f"{part.__name__}: {error}")
            return {}

    found = told(ensembles.fate, run) | ensembles.drift(run)
    time = run.time
    if len(time) and time[-1] >= WINDOW:
        found |= told(_after, run[: int(WINDOW / SPACING) + 1])
    if len(time) > 1:
        found |= told(_attitude, run)
    if len(time) and time[-1] >= end:
        last = run[-int(WINDOW / SPACING) - 1 :]
        found |= _state(run) | told(_rotation, last) | told(_libration, last) | told(_orbit, last) | told(_apses, last)
    return found | {"unmeasured": "; ".join(missing), "lock_lost": float(sum(run.switched_off.values()))}


def within_the_window(run: Run) -> dict[str, Any]:
    """What observers would have seen of a run over the days observed, and the largest angles; ``None`` if unclear."""
    try:
        seen = _after(run)
    except InvalidInput:
        seen = {}
    return seen | _attitude(run)


def wrapped(angle: Any) -> Any:
    """An angle between minus and plus half a turn."""
    return (np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi


def _after(run: Run) -> dict[str, Any]:
    """The three values that observers published, as they are in this member's own motion in space."""
    shape, turning = observables.eccentricity(run), observables.orbit_precession(run)
    return {
        "period_after": observables.mutual_period(run).mean,
        "eccentricity_after": shape.free,
        "precession_after": None if turning.apsidal is None else np.rad2deg(turning.apsidal) * model.DAY,
    }


def _attitude(run: Run) -> dict[str, Any]:
    """The largest roll, pitch and yaw of the whole run, and when one of them first passed the limit."""
    return ensembles.attitude(run, LIMIT)


def _state(run: Run) -> dict[str, Any]:
    """The state at the end, the angles of the last days, and the longitude that Dimorphos has gone through."""
    position = run.position[:, 1] - run.position[:, 0]
    x, y = plane().T[:2]
    longitude = np.unwrap(np.arctan2(position @ y, position @ x))
    end = run[-1]
    angles = observables.roll_pitch_yaw(run[-int(FAN / SPACING) - 1 :])
    return {
        "longitude": longitude[-1] - longitude[0],
        "angles": wrapped(angles),
        "state": np.concatenate([end.position, end.velocity, end.attitude, end.spin], axis=1),
    }


def plane() -> npt.NDArray[np.float64]:
    """The axes of the published orbit as columns: along its node, across it in the plane, and its pole."""
    longitude, latitude = (np.deg2rad(INPUTS[f"pole_{name}"].value) for name in ("longitude", "latitude"))
    z = pole_vector(longitude, latitude)
    x = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    return np.stack([x, np.cross(z, x), z], axis=1)


def _rotation(run: Run) -> dict[str, Any]:
    """The rotation of the last window: rates, obliquity, and the largest angles in it."""
    largest = np.rad2deg(np.minimum(observables.tumbles(run, LIMIT).largest, np.pi))
    spin, turned = run.spin[:, 1], observables.obliquity(run)
    return {
        "spin": np.linalg.norm(spin, axis=1).mean(),
        "spin_about_pole": np.abs(spin[:, 2]).mean(),
        "obliquity": np.rad2deg(turned.mean()),
        "obliquity_largest": np.rad2deg(turned.max()),
        **{f"last_{name}": angle for name, angle in zip(("roll", "pitch", "yaw"), largest, strict=True)},
    }


def _libration(run: Run) -> dict[str, Any]:
    """Amplitude in degrees and the periods of the two strongest terms, in hours."""
    found = observables.libration(run, count=2)
    rates = [*found.frequencies, np.nan, np.nan][:2] if found.amplitude is not None else [np.nan, np.nan]
    return {
        "libration": None if found.amplitude is None else np.rad2deg(found.amplitude),
        "libration_period": 2.0 * np.pi / rates[0],
        "libration_period_second": 2.0 * np.pi / rates[1],
    }


def _orbit(run: Run) -> dict[str, Any]:
    """The orbit of the last window."""
    shape = observables.orbit_shape(run)
    return {
        "period": observables.mutual_period(run).mean,
        "semi_major_axis": shape.a.mean(),
        "eccentricity": shape.e.mean(),
    }


def _apses(run: Run) -> dict[str, Any]:
    """The precession of the last window and the mean anomaly at its end, where the distance has one period."""
    turning = observables.orbit_precession(run)
    if turning.apsidal is None:
        return {}
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    phase = 2.0 * np.pi * (run.time - run.time[-1]) / turning.anomalistic_period
    basis = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=1)
    _, cosine, sine = np.linalg.lstsq(basis, distance, rcond=None)[0]
    # r = a (1 - e cos M), with M the phase and a constant.
    return {
        "precession": np.rad2deg(turning.apsidal) * model.DAY,
        "mean_anomaly": np.rad2deg(np.arctan2(sine, -cosine)),
    }


def outcome(found: Any) -> npt.NDArray[Any]:
    """One word for each member: what Hera finds Dimorphos doing in the last window, or why there is none.

    ``"contact"``, ``"escape"`` and ``"unfinished"`` are fates of :func:`fullbody.ensembles.fate`, ``"failed"`` a start
    that was refused; the variables ``error`` and ``error_text`` give the reason.
    """
    turned = np.rad2deg(LIMIT)
    words = np.full(found.error.shape, "locked", dtype=object)
    words[found.last_roll.values > turned] = "rolling"
    words[(found.last_pitch.values > turned) | (found.last_yaw.values > turned)] = "tumbling"
    words[~np.isfinite(found.last_yaw.values)] = "unmeasured"
    fates = found.fate.values.astype(object)
    words[fates != "bound"] = fates[fates != "bound"]
    words[fates == ""] = "failed"
    return words
