"""Kalliope and Linus as two bodies, their initial state from a few parameters, and their light curves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import astropy.units as u
import fullbody
import numpy as np
import pandas as pd
from astropy.time import Time
from fullbody import observing
from scipy.spatial.transform import Rotation

__all__ = ["AXES", "EPOCH", "INTEGRATOR", "PERIOD", "ROTATION", "START", "A", "Light", "binary", "setup"]

PATH = Path(__file__).parents[2] / "tests" / "data" / "observations" / "kalliope" / "light_curves.csv"
EPOCH = Time(2459547.7, format="jd", scale="tdb")
#: The gravitational constant in km^3 / (kg day^2).
G = 6.6743e-20 * 86400.0**2
#: Numbers that are not fitted: Kalliope's semi-axes and the separation in km, periods of orbit and rotation in days.
AXES, A, PERIOD, ROTATION = (103.5, 72.5, 61.0), 1063.0, 3.59571, 0.17284169
#: Starting values: the published pole in degrees and radius of Linus in km; longitude and phase come from a grid.
START = {"radius": 14.0, "longitude": 0.0, "pole_longitude": 195.6, "pole_latitude": 2.2, "phase": 0.0}
INTEGRATOR = fullbody.Verner98(rtol=1e-11, atol=1e-11)


def setup(
    radius: float,
    longitude: float,
    pole_longitude: float,
    pole_latitude: float,
    phase: float,
    gravity: str = "focal",
) -> tuple[fullbody.System, fullbody.State]:
    """Return the system and its state at the epoch.

    Linus is a sphere with the density of Kalliope. It starts on a circular orbit in the equator of Kalliope, with the
    published separation and period. The total mass is that of two points on such an orbit.

    Parameters
    ----------
    radius : float
        Radius of Linus in km.
    longitude, phase : float
        Angles in degrees along the equator, from the direction that the pole's longitude gives, to Linus and to the
        longest axis of Kalliope.
    pole_longitude, pole_latitude : float
        The pole of the orbit and of Kalliope in the ecliptic, in degrees.
    gravity : str
        The gravity of the system; with ``"point"`` the orbit remains circular.

    Returns
    -------
    tuple of System and State
        In km, days and kg, and in the ecliptic.
    """
    angles = (longitude, pole_longitude, pole_latitude, phase)
    return binary(fullbody.Ellipsoid(*AXES), fullbody.Sphere(radius), angles, gravity)


def binary(
    kalliope: Any, linus: Any, angles: tuple[float, float, float, float], gravity: str, period: float = PERIOD
) -> tuple[fullbody.System, fullbody.State]:
    """Return the system of two shapes in km and the state at the epoch, as :func:`setup` describes them.

    The angles are the longitude, the two of the pole, and the phase.
    """
    longitude, pole_longitude, pole_latitude, phase = angles
    volumes = np.array([fullbody.Body(shape, density=1.0).mass for shape in (kalliope, linus)])
    share = volumes[1] / volumes.sum()
    total = 4.0 * np.pi**2 * A**3 / period**2 / G
    bodies = [
        fullbody.Body(kalliope, mass=(1.0 - share) * total, name="Kalliope"),
        fullbody.Body(linus, mass=share * total, name="Linus"),
    ]
    units = ("km", "day", "kg")
    system = fullbody.System(bodies, G=G, units=units, frame="ecliptic", epoch=EPOCH, gravity=gravity)
    orbit, rotation = (
        Rotation.from_euler("zyz", [angle, 90.0 - pole_latitude, pole_longitude], degrees=True)
        for angle in (longitude, phase)
    )
    shares, rate = np.array([[-share], [1.0 - share]]), 2.0 * np.pi / period
    state = fullbody.State.from_scipy(
        position=orbit.apply(shares * [A, 0.0, 0.0]),
        velocity=orbit.apply(shares * [0.0, A * rate, 0.0]),
        rotation=Rotation.concatenate([rotation, orbit]),
        spin=[[0.0, 0.0, 2.0 * np.pi / ROTATION], [0.0, 0.0, rate]],
    )
    return system, state


class Light:
    """The light curves as observations.

    Parameters
    ----------
    step : int
        The step between the magnitudes that are used: 1 for all of them.

    Attributes
    ----------
    is_complete : bool
        Whether all magnitudes are used.
    table : DataFrame
        The magnitudes with their nights, errors and geometry.
    geometry : Geometry
        The directions to the observer and to the Sun.
    """

    def __init__(self, step: int = 1) -> None:
        self.is_complete = step == 1
        self.table = pd.read_csv(PATH)[::step]
        column = {name: self.table[name].to_numpy() for name in self.table}
        self._times = Time(column["jd_tdb"], format="jd", scale="tdb")
        sun = np.stack([column[f"sun_{axis}_au"] for axis in "xyz"], axis=1) * u.au
        self.geometry = observing.Geometry.from_radec(
            self._times,
            ra=column["ra_deg"] * u.deg,
            dec=column["dec_deg"] * u.deg,
            distance=column["distance_au"] * u.au,
            to_sun=sun,
        )
        self._sun_radius = float(np.arcsin(695700.0 / np.linalg.norm(sun.to_value("km"), axis=1).mean()))
        self._column = column

    @property
    def sun_radius(self) -> float:
        """The mean angular radius of the Sun at Kalliope, in radians."""
        return self._sun_radius

    def data(self, order: int = 10, albedo: float = 1.0, **options: Any) -> observing.Photometry:
        """Return the photometry.

        Parameters
        ----------
        order : int
            The order of the Fourier series in Kalliope's rotation angle; zero for no series.
        albedo : float
            The albedo of Linus over that of Kalliope.
        **options
            Further options of :class:`fullbody.observing.Photometry`.
        """
        series = observing.RotationSeries("Kalliope", order) if order else None
        return observing.Photometry(
            self._times,
            self._column["magnitude"],
            self._column["sigma"],
            geometry=self.geometry,
            night=self._column["night"],
            rotation=series,
            albedo={"Kalliope": 1.0, "Linus": albedo},
            reduced=False,
            **options,
        )
