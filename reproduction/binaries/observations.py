"""The published astrometry as observations of the package, with the published orbits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import astropy.units as u
import fullbody
import numpy as np
import numpy.typing as npt
import pandas as pd
from astropy.time import Time
from fullbody import observing

__all__ = ["NAMES", "Catalogued", "catalogued", "eris"]

_Array = npt.NDArray[np.float64]

FOLDER = Path(__file__).parents[2] / "tests" / "data" / "observations"
#: The systems of the catalogue, by the names of their files.
NAMES = tuple(sorted(path.name.removesuffix("_orbit.csv") for path in (FOLDER / "tno").glob("*_orbit.csv")))
#: The orbit of Eris about the Sun in the ecliptic of J2000, and the date of its mean anomaly.
ERIS_ORBIT = fullbody.KeplerElements(
    67.67 * u.au, 0.44177, *(angle * u.deg for angle in (44.187, 35.8696, 151.4305, 197.63427))
)
ERIS_EPOCH = Time(2453800.5, format="jd", scale="tdb")
#: Columns of the orbits, by the names of the parameters that are fitted.
ELEMENTS = {
    "a": "a",
    "period": "period",
    "e": "e",
    "i": "i",
    "node": "lan",
    "periapsis": "pomega",
    "longitude": "long_epoch",
}


@dataclass(frozen=True)
class Catalogued:
    """One system of the catalogue.

    Attributes
    ----------
    name : str
        The provisional designation.
    data : Astrometry
    epoch : Time
        The epoch of the elements.
    published, errors : dict
        The published elements (km, days, degrees on the equator of J2000) and their standard errors.
    share : float
        The secondary's share of the mass, from the published diameters and equal densities. It changes only the
        position of the barycentre, and with it the light time by less than a millisecond per kilometre.
    """

    name: str
    data: observing.Astrometry
    epoch: Time
    published: dict[str, float]
    errors: dict[str, float]
    share: float


def _dates(table: pd.DataFrame) -> Time:
    return Time(table["time"].to_numpy(), format="jd", scale="utc")


def catalogued(name: str, exchanged: Sequence[int] = ()) -> Catalogued:
    """Read a system of the catalogue, with the components of the rows ``exchanged`` in the other order."""
    table = pd.read_csv(FOLDER / "tno" / f"{name}_astrometry.csv", index_col=0)
    orbit = pd.read_csv(FOLDER / "tno" / f"{name}_orbit.csv").iloc[0]
    dates = _dates(table)
    geometry = observing.Geometry.from_radec(
        dates,
        ra=table["RA-Primary"].to_numpy() * u.hourangle,
        dec=table["DEC-Primary"].to_numpy() * u.deg,
        distance=table["dist"].to_numpy() * u.au,
    )
    sign = np.where(np.isin(np.arange(len(table)), exchanged), -1.0, 1.0)
    data = observing.Astrometry(
        dates,
        sign * table["Delta-RA"].to_numpy() * u.arcsec,
        sign * table["Delta-DEC"].to_numpy() * u.arcsec,
        table[["Delta-RA-err", "Delta-DEC-err"]].to_numpy() * u.arcsec,
        body="secondary",
        about="primary",
        geometry=geometry,
    )
    return Catalogued(
        name.replace("_", " ").upper(),
        data,
        Time(orbit["epoch_jd"], format="jd", scale="utc"),
        {key: float(orbit[column]) for key, column in ELEMENTS.items()},
        {key: float(orbit[f"{column}_err"]) for key, column in ELEMENTS.items()},
        float(1.0 / (1.0 + (orbit["diam_1"] / orbit["diam_2"]) ** 3)),
    )


def eris(light_time: bool = True) -> observing.Astrometry:
    """Return Dysnomia about Eris, 19 epochs from 2005 to 2018 (Brown & Schaller 2007, Holler et al. 2021)."""
    table = pd.read_csv(FOLDER / "eris_dysnomia.csv")
    dates = _dates(table)
    geometry = observing.Geometry.from_orbit(ERIS_ORBIT, ERIS_EPOCH, span=dates, light_time=light_time)
    columns = {"times": "time", "east": "Delta-RA_Dysnomia", "north": "Delta-DEC_Dysnomia"}
    errors = ("Delta-RA_Dysnomia-err", "Delta-DEC_Dysnomia-err")
    return observing.Astrometry.from_table(
        table,
        columns={**columns, "sigma": errors},
        unit=u.arcsec,
        dates=("jd", "utc"),
        body="secondary",
        about="primary",
        geometry=geometry,
    )
