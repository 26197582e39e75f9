"""Hertha as a single convex body, and its light curves as two sets of observations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import astropy.units as u
import fullbody
import numpy as np
from astropy.time import Time
from fullbody import observing

__all__ = ["DEGREE", "EPOCH", "SMOOTHNESS", "Curves", "parameters", "setup", "shape"]

PATH = Path(__file__).parents[2] / "tests" / "data" / "observations" / "hertha" / "light_curves.lc"
#: The time at which the rotation angle is zero, that of the first magnitude.
EPOCH = Time(2443845.0, format="jd", scale="tdb")
#: The scattering law that is usual in the inversion of light curves.
LAW = observing.LommelSeeligerLambert(lambert=0.1)
#: The degree of the series of the areas, the prior standard error of its coefficients of degree one, and the power of
#: the degree with which those of others fall.
DEGREE, SMOOTHNESS, POWER = 6, 0.5, 1.0
#: Curves over more days than this are sparse photometry of surveys, calibrated to a few hundredths of a magnitude.
SPARSE = 30.0
#: The length of an apparition in days.
SEASON = 120.0
#: Standard errors in magnitudes. Those of nights contain the errors of a convex shape with one scattering law.
ERRORS = {"nights": 0.02, "surveys": 0.15}


def setup(
    longitude: Any, latitude: Any, period: Any, coefficients: Any, faces: int = 1002
) -> tuple[fullbody.System, fullbody.State]:
    """Return Hertha alone, rotating about a fixed pole.

    Parameters
    ----------
    longitude, latitude : Quantity
        The pole in the ecliptic.
    period : Quantity
        The sidereal period.
    coefficients : ndarray, ((L + 1)^2 - 1,)
        The coefficients of the areas of the facets, from degree one on. That of degree zero is zero, since relative
        light does not determine the size.
    faces : int
        The least number of facets.
    """
    body = fullbody.Body(shape(coefficients, faces), mass="1e18 kg", name="Hertha")
    system = fullbody.System([body], units=("km", "hour", "kg"), frame="ecliptic", epoch=EPOCH)
    return system, fullbody.State.rotating(body, longitude, latitude, period)


def shape(coefficients: Any, faces: int = 1002) -> fullbody.ConvexShape:
    """Return the convex shape of coefficients from degree one on."""
    return fullbody.ConvexShape(np.append(0.0, coefficients), reference_radius="38 km", faces=faces)


def parameters(
    period: Any, longitude: Any, latitude: Any, degree: int = DEGREE, power: float = POWER
) -> dict[str, Any]:
    """Return the parameters of a fit that starts from a sphere at a period and a pole."""
    sigma = fullbody.fitting.smoothness(degree, SMOOTHNESS, power)[1:]
    return {
        "longitude": longitude,
        "latitude": latitude,
        "period": period,
        "coefficients": fullbody.fitting.Free(np.zeros(len(sigma)), prior=(0.0, sigma)),
    }


class Curves:
    """The light curves: those of nights, and those of surveys over years.

    Parameters
    ----------
    step : int
        The step between the magnitudes that are used: 1 for all of them.

    Attributes
    ----------
    nights, surveys : Photometry
        The magnitudes of all nights together, and those of all surveys, each curve with its own zero point; the latter
        with a free slope in the phase angle.
    """

    def __init__(self, step: int = 1) -> None:
        self._step = step
        curves = observing.read_damit(PATH, sigma=1.0, law=LAW)
        self._curves = [curve for curve in curves if np.ptp(curve.times.jd) <= SPARSE]
        self.nights = _joined(self._curves, "nights", step)
        self.surveys = _joined([curve for curve in curves if np.ptp(curve.times.jd) > SPARSE], "surveys", step)

    def apparition(self) -> observing.Photometry:
        """Return the curves of the nights of the apparition that has the most magnitudes."""
        starts = np.array([curve.times[0].jd for curve in self._curves])
        seasons = [
            [c for c, jd in zip(self._curves, starts, strict=True) if 0.0 <= jd - start < SEASON] for start in starts
        ]
        return _joined(max(seasons, key=lambda curves: sum(map(len, curves))), "nights", self._step)

    @property
    def observations(self) -> list[Any]:
        """The observations of a fit: both sets, and the closure of the shape."""
        return [self.nights, self.surveys, fullbody.fitting.closure("Hertha")]


def _joined(curves: list[observing.Photometry], kind: str, step: int) -> observing.Photometry:
    """Return curves as one set of observations with a night for each."""
    dates = Time(np.concatenate([curve.times.jd for curve in curves]), format="jd", scale="tdb")
    order = np.argsort(dates.jd, kind="stable")
    columns = {
        "to_observer": np.concatenate([curve.geometry.to_observer(curve.times).to_value("au") for curve in curves]),
        "to_sun": np.concatenate([curve.geometry.to_sun(curve.times).to_value("au") for curve in curves]),
    }
    rows = order[::step]
    distinct = rows[np.unique(dates.jd[rows], return_index=True)[1]]
    view = {name: vectors[distinct] * u.au for name, vectors in columns.items()}
    return observing.Photometry(
        dates[rows],
        np.concatenate([curve.magnitude for curve in curves])[rows],
        ERRORS[kind],
        geometry=observing.Geometry(dates[distinct], **view, frame="ecliptic", light_time=False),
        law=LAW,
        night=np.concatenate([np.full(len(curve), curve.nights[0]) for curve in curves])[rows],
        phase_slope="free" if kind == "surveys" else None,
    )
