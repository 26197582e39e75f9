"""The astrometry of Lempo and Haumea, which its collectors rotated from the equator to the ecliptic."""

from __future__ import annotations

import astropy.units as u
import numpy as np
import numpy.typing as npt
import pandas as pd
from astropy.time import Time
from fullbody import observing
from fullbody.frames import rotation

from .observations import FOLDER

__all__ = ["haumea", "lempo"]

_Array = npt.NDArray[np.float64]


def lempo(as_collected: bool = False) -> list[observing.Astrometry]:
    """Return Hiisi and Paha about Lempo, nine epochs (Benecchi et al. 2010); times are less light time.

    Parameters
    ----------
    as_collected : bool
        Offsets along the ecliptic whose errors have lost their correlation, instead of those on the equator.
    """
    return [_read("lempo", name, as_collected, independent=True, light_time=False) for name in ("Hiisi", "Paha")]


def haumea(east: int = 1, as_collected: bool = False) -> list[observing.Astrometry]:
    """Return Namaka and Hi'iaka about Haumea (Ragozzine & Brown 2009, Proudfoot et al. 2024).

    The errors cannot have been independent on the equator: in some rows those along the ecliptic differ by more than
    any such pair would make them. They are taken to be independent along the ecliptic, as they were collected.

    Parameters
    ----------
    east : {1, -1}
        The sign of the offsets in right ascension, relative to the table.
    as_collected : bool
    """
    return [
        _read("haumea", name, as_collected, independent=False, light_time=True, east=east)
        for name in ("Namaka", "Hiiaka")
    ]


def _read(
    system: str, moon: str, as_collected: bool, *, independent: bool, light_time: bool, east: int = 1
) -> observing.Astrometry:
    table = pd.read_csv(FOLDER / f"{system}.csv")
    position = pd.read_csv(FOLDER / f"{system}_geocentric.csv")[["x", "y", "z"]].to_numpy()
    observed = table[f"DeltaLat_{moon}"].notna().to_numpy()
    table, position = table[observed], position[observed]
    offsets, sigma = (
        table[[f"Delta{axis}_{moon}{end}" for axis in ("Long", "Lat")]].to_numpy() for end in ("", "_err")
    )
    correlation = np.zeros(len(table))
    if not as_collected:
        offsets, sigma, correlation = _on_equator(table, offsets, sigma, independent)
    dates = Time(table["time"].to_numpy(), format="jd", scale="utc")
    return observing.Astrometry(
        dates,
        east * offsets[:, 0] * u.arcsec,
        offsets[:, 1] * u.arcsec,
        sigma * u.arcsec,
        east * correlation,
        body=moon,
        about=system.title(),
        geometry=observing.Geometry(dates, to_observer=-position * u.km, frame="ecliptic", light_time=light_time),
        frame="ecliptic" if as_collected else "equatorial",
    )


def _on_equator(
    table: pd.DataFrame, offsets: _Array, sigma: _Array, independent: bool
) -> tuple[_Array, _Array, _Array]:
    """Rotate offsets and errors (K, 2) back about the direction (longitude, latitude) of the table.

    Parameters
    ----------
    table : DataFrame
    offsets, sigma : ndarray, (K, 2)
    independent : bool
        Whether the errors were independent on the equator. The squares of those along the ecliptic are then sums of
        their squares with known factors, which are solved for them. Otherwise the errors are taken to be independent
        along the ecliptic, and are correlated on the equator.

    Returns
    -------
    offsets, sigma : ndarray, (K, 2)
    correlation : ndarray, (K,)
    """
    lon, lat = np.radians(table[["Long_Prim", "Lat_Prim"]].to_numpy()).T
    axes = rotation("ecliptic", "equatorial")
    direction = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=1) @ axes.T
    east = np.stack([-np.sin(lon), np.cos(lon), np.zeros_like(lon)], axis=1) @ axes.T
    horizontal = np.hypot(direction[:, 0], direction[:, 1])
    cosine = (east[:, 1] * direction[:, 0] - east[:, 0] * direction[:, 1]) / horizontal
    sine = east[:, 2] / horizontal
    x, y = offsets.T
    rotated = np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
    c, s, squares = cosine[:, None] ** 2, sine[:, None] ** 2, sigma**2
    if independent:
        return rotated, np.sqrt((c * squares - s * squares[:, ::-1]) / (c - s)), np.zeros(len(table))
    errors = np.sqrt(c * squares + s * squares[:, ::-1])
    return rotated, errors, cosine * sine * (squares[:, 0] - squares[:, 1]) / np.prod(errors, axis=1)
