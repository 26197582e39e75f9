"""Values that would be right in another unit raise a warning."""

import warnings

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody.errors import InconsistentInput


@pytest.mark.parametrize("units", [True, False])
def test_angles_that_look_like_degrees_are_warned_of(units):
    state = fullbody.systems.didymos_after_dart(units=units)[1]
    for angle in (10, 10.0, -10.5, 90):
        with pytest.warns(
            InconsistentInput, match=f"angle is {abs(angle):g} radians in size.*such as '{abs(angle):g} deg'"
        ):
            state.rotated("Dimorphos", [0, 0, 1], angle)
    for angle in (np.radians(10), -np.pi, 3.0, "10 deg", 4000 * u.deg, np.radians(500.0)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            state.rotated("Dimorphos", [0, 0, 1], angle)


@pytest.mark.parametrize("shape", [fullbody.Ellipsoid, lambda *axes: fullbody.Composite([fullbody.Part(
    fullbody.Ellipsoid(*axes), mass=1 * u.kg)])])  # fmt: skip
def test_densities_of_another_unit_are_warned_of(shape):
    system, _ = fullbody.systems.didymos(units=True)
    for unit, density in ((u.m, "2.*e.12"), (u.au, "8.*e-22")):
        with pytest.warns(InconsistentInput, match=f"Dimorphos has a density of {density} kg/m3; expected 100"):
            system.with_body("Dimorphos", shape(*[0.0885, 0.087, 0.058] * unit))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        system.with_body("Dimorphos", shape(*[0.0885, 0.087, 0.058] * u.km))
        system.with_body("Dimorphos", fullbody.PointMass())
        # Without units nobody knows.
        fullbody.systems.case1()[0].with_body(0, fullbody.Sphere(1e-3))
