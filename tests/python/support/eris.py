"""The system of (136199) Eris for the tests of observations."""

import astropy.units as u
import fullbody
from astropy.time import Time

#: About the Sun, in the ecliptic of J2000.
ERIS = fullbody.KeplerElements(
    67.67 * u.au, 0.44177, *(angle * u.deg for angle in (44.187, 35.8696, 151.4305, 197.63427))
)
#: When its mean anomaly holds.
EPOCH = Time(2453800.5, format="jd", scale="tdb")
