"""The size of (135) Hertha from the 18 chords of its occultation of 11 December 2008.

The file has the ends of the chords in the plane of the sky that moves with the shadow, to the west and to the north,
with the vector from Hertha to the Earth and its rate of change. The numbers confirm this: within each chord the ends
move by that rate across the line of sight, to 4 %, and the difference is the rotation of the Earth, which is to the
west of these axes by 0.2 to 0.3 km/s for stations in North America at night.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import astropy.units as u
import fullbody
import numpy as np
from astropy.time import Time
from fullbody import observing

from . import model

CHORDS = Path(__file__).parents[2] / "tests" / "data" / "observations" / "hertha" / "occultations.occ"
#: Diameters of a sphere of the same volume in km with their errors, and where they were published; all are second-hand,
#: from catalogues that list them. The first one is of a shape that was fitted to these chords, to light curves and to
#: images; the others are of thermal light and of several methods.
PUBLISHED = {
    "DAMIT model 1799, Hanus et al. (2017), A&A 601, A114": (79.0, 2.0),
    "Carry (2012), Planet. Space Sci. 73, 98": (76.12, 3.29),
    "IRAS, Tedesco et al. (2002), AJ 123, 1056": (79.24, 2.0),
}
#: The pole and the sidereal period of DAMIT's model 162, and the ratios of axes of Torppa et al. (2003), Icarus 164,
#: 346.
POLE, PERIOD = (272.0 * u.deg, 52.0 * u.deg), 8.40060 * u.h
RATIOS = (1.1, 1.5)
#: An error added to those of the file, for the deviations of the shape: three kilometres at 5.6 km/s.
MODEL_ERROR = 0.5 * u.s
EPOCH = Time("2008-12-11T07:30:00", scale="utc").tdb
#: The diameter in km from which fits start.
START = 77.0


@dataclass(frozen=True)
class Size:
    """A diameter in km with its error, which is multiplied by the root of the reduced chi2, and its fit."""

    diameter: float
    sigma: float
    fit: Any

    @property
    def rms(self) -> float:
        """The root of the mean square of the residuals of the contacts in s."""
        return float(np.sqrt(np.mean(self.fit.residuals[0].to_value("s") ** 2)))


def occultation() -> observing.StellarOccultation:
    """Return the chords, with the error of the shape added to those of the times."""
    return observing.StellarOccultation.read_koala(CHORDS, body="Hertha").with_jitter(MODEL_ERROR)


def rotating(
    shape: Any, angle: float, pole: tuple[Any, Any] = POLE, period: Any = PERIOD
) -> tuple[fullbody.System, fullbody.State]:
    """Return Hertha with a shape, rotated about its pole by an angle in radians at the epoch.

    The pole is the z-axis of an ellipsoid, and that of the frame in which the vertices of a polyhedron are given.
    """
    # The mass has no effect on a body alone.
    body = fullbody.Body(shape, mass=1e18 * u.kg, name="Hertha")
    system = fullbody.System([body], units=("km", "s", "kg"), epoch=EPOCH, frame="ecliptic")
    return system, fullbody.State.rotating(body, *pole, period, angle)


def ellipsoid(diameter: float, ratios: tuple[float, float]) -> fullbody.Ellipsoid:
    """Return the ellipsoid with the volume of a sphere of a diameter in km and the ratios a/b and b/c."""
    first, second = ratios
    b = 0.5 * diameter * (second / first) ** (1.0 / 3.0)
    return fullbody.Ellipsoid(first * b * u.km, b * u.km, b / second * u.km)


def size(
    setup: Callable[..., tuple[fullbody.System, fullbody.State]],
    start: dict[str, Any],
    data: observing.StellarOccultation | None = None,
    proposals: int | None = None,
) -> Size:
    """Return the size of a shape from the chords.

    The ``setup`` takes ``diameter`` in km and the other free parameters, by the names of ``start``, and returns the
    body with a shape of that diameter. The offset of ephemeris and star is fitted too. ``proposals`` limits the fit.
    """
    fit = fullbody.fit(setup, start, [occultation() if data is None else data], proposals=proposals)
    factor = max(1.0, fit.chi2 / fit.dof) ** 0.5
    return Size(float(fit.values["diameter"]), float(fit.sigma["diameter"] * factor), fit)


def rotation_angle(period: Any) -> float:
    """Return the rotation angle in radians at the epoch of the chords, from zero at that of the light curves."""
    return float(2.0 * np.pi * ((EPOCH - model.EPOCH).to_value("h") / period.to_value("h") % 1.0))


def size_of_light_shape(values: Mapping[str, Any], free_angle: bool = False, proposals: int | None = None) -> Size:
    """Return the size of the shape from an inversion of light curves, at its pole and its rotation angle.

    Parameters
    ----------
    values : dict
        The pole, the period and the coefficients of a minimum of the fit to the light curves, as
        :func:`reproduction.hertha.model.setup` takes them.
    free_angle : bool
        Whether a correction of the rotation angle, in radians, is free beside the diameter.
    proposals : int, optional
        The limit of the fit.
    """
    solid = model.shape(values["coefficients"]).polyhedron()
    diameter = np.cbrt(6.0 * solid.volume.to_value("km3") / np.pi)
    vertices, faces = solid.vertices.to_value("km") / diameter, solid.faces
    angle, pole = rotation_angle(values["period"]), (values["longitude"], values["latitude"])

    def setup(diameter: float, angle_correction: float = 0.0) -> tuple[fullbody.System, fullbody.State]:
        shape = fullbody.Polyhedron(diameter * vertices * u.km, faces)
        return rotating(shape, angle + angle_correction, pole, values["period"])

    start = {"diameter": START} | ({"angle_correction": 0.0} if free_angle else {})
    return size(setup, start, proposals=proposals)


def sizes_of_ellipsoids() -> dict[str, Size]:
    """Return the sizes of ellipsoids at the published pole, with free rotation angles; they need no light curves."""
    start = {"diameter": START, "angle": 1.5}
    return {
        "ellipsoid with a/b = 1.1, b/c = 1.5": size(
            lambda diameter, angle: rotating(ellipsoid(diameter, RATIOS), angle), start
        ),
        "ellipsoid with a/b free, b/c = 1.5": size(
            lambda diameter, angle, ratio: rotating(ellipsoid(diameter, (ratio, RATIOS[1])), angle),
            {**start, "ratio": 1.5},
        ),
    }
