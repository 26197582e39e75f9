"""Absolute magnitudes: published sizes, albedos and H of asteroids, and the flux of a sphere in sunlight."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import observing
from fullbody.errors import InvalidInput
from support import refused

AT_REST = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)))
LAWS = [
    observing.LommelSeeliger(),
    observing.LommelSeeliger(phase_function=lambda g: 0.7 * np.exp(-g)),
    observing.Lambert(),
    observing.Hapke(single_scattering_albedo=0.3, opposition_amplitude=1.0, opposition_width=0.05, asymmetry=-0.3),
]


def sphere(diameter, units=("km", "hour", "kg")):
    return fullbody.System([fullbody.Body(fullbody.Sphere(diameter / 2), mass=1e15 * u.kg, name="A")], units=units)


def opposition(system, **options):
    """Return -2.5 log10 of the brightness at phase angle zero."""
    return -2.5 * np.log10(observing.brightness(system, AT_REST, [1, 0, 0], [1, 0, 0], **options)[0].value)


@pytest.mark.parametrize(
    ("diameter", "albedo", "H", "error"),
    [
        # (1) Ceres: 939.4 km, 0.090 +- 0.0033 and 3.34 (JPL's Small-Body Database); the albedo's error is 0.04 mag.
        (939.4, 0.090, 3.34, 0.05),
        # (253) Mathilde: 52.8 km, 0.0436 +- 0.004 and 10.3 (the same); 0.1 mag.
        (52.8, 0.0436, 10.3, 0.12),
    ],
)
@pytest.mark.parametrize("law", LAWS)
def test_published_sizes_and_albedos_give_the_published_magnitude(diameter, albedo, H, error, law):
    system = sphere(diameter * u.km)
    result = opposition(system, law=law) + observing.zero_point(system, geometric_albedo=albedo, law=law)
    assert result == pytest.approx(H, abs=error)
    assert result == pytest.approx(5.0 * np.log10(1329.0 / (diameter * np.sqrt(albedo))), rel=1e-13)


def test_a_geometric_albedo_is_the_ratio_to_the_flux_of_a_white_disc():
    """A sphere at 1 au from the Sun and the observer has p (R/au)^2 of the Sun's light, V = -26.76 (Willmer 2018)."""
    system = sphere(2.0 * u.km, ("m", "s", "kg"))
    result = opposition(system) + observing.zero_point(system, geometric_albedo=0.15)
    assert result == pytest.approx(-26.76 - 2.5 * np.log10(0.15 * (1.0 * u.km / u.au).to_value("") ** 2), abs=5e-3)


@pytest.mark.parametrize("law", LAWS)
def test_H_of_spheres_is_the_sum_of_their_light(law):
    """Two spheres of H = 18 and 20 have 18 - 2.5 log10(1 + 10^-0.8) together."""
    sizes = [1329.0 / np.sqrt(0.1) * 10.0 ** (-H / 5.0) for H in (18.0, 20.0)]
    bodies = [
        fullbody.Body(fullbody.Sphere(size / 2), mass=1.0, name=name) for size, name in zip(sizes, "AB", strict=True)
    ]
    pair = fullbody.System(bodies, units=("km", "hour", "kg"))
    together = 18.0 - 2.5 * np.log10(1.0 + 10.0**-0.8)
    assert observing.zero_point(pair, H=together, law=law) == pytest.approx(
        observing.zero_point(pair, geometric_albedo=0.1, law=law), rel=1e-13
    )
    # With an albedo of two the darker one shines as one of twice the area.
    double = observing.zero_point(pair, H=together, law=law, albedo={"A": 1.0, "B": 2.0})
    assert double - observing.zero_point(pair, H=together, law=law) == pytest.approx(
        2.5 * np.log10((1.0 + 2.0 * 10.0**-0.8) / (1.0 + 10.0**-0.8)), rel=1e-12
    )


def test_magnitudes_as_observed_take_the_distances_of_the_geometry():
    """V = H + 5 log10(r Delta) at phase angle zero, here with Delta = 0.2 au and r = 1.2 au."""
    system = sphere(0.8 * u.km)
    run = system.integrate(AT_REST, "1 day", dense=True)
    view = {"to_observer": [0.2, 0.0, 0.0] * u.au, "to_sun": [1.2, 0.0, 0.0] * u.au}
    geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    for reduced, expected in ((True, 18.16), (False, 18.16 + 5.0 * np.log10(0.2 * 1.2))):
        curve = observing.light_curve(run, [3.0, 9.0] * u.h, geometry, reduced=reduced)
        zero = observing.zero_point(system, H=18.16, reduced=reduced)
        np.testing.assert_allclose(curve + zero, expected, rtol=1e-12)
        data = observing.Photometry([3.0, 9.0] * u.h, [18.0] * 2, 0.1, geometry=geometry, zero=zero, reduced=reduced)
        np.testing.assert_allclose(data.predict(run), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "geometric_albedo and H are None and None; expected one of the two"),
        ({"H": 18.0, "geometric_albedo": 0.1}, "are 0.1 and 18.0; expected one of the two"),
        ({"geometric_albedo": -0.1}, "geometric_albedo is -0.1; expected a finite number above zero"),
        ({"H": np.nan}, "H is nan; expected a finite number"),
        ({"H": 18.0, "albedo": 0.0}, "the bodies have no size or no albedo"),
        ({"H": 18.0, "albedo": [0.1, 0.2]}, "albedo is an array over faces"),
    ],
)
def test_what_gives_no_zero_point_is_refused(options, message):
    refused(message, lambda: observing.zero_point(sphere(1.0 * u.km), **options))
    with pytest.raises(InvalidInput, match="a geometric albedo needs the system's units"):
        observing.zero_point(fullbody.systems.case1()[0], geometric_albedo=0.1)
    two, laws = fullbody.systems.didymos()[0], {"Didymos": observing.Lambert(), "Dimorphos": observing.LommelSeeliger()}
    with pytest.raises(InvalidInput, match="law differs between bodies beside a geometric_albedo"):
        observing.zero_point(two, geometric_albedo=0.1, law=laws)
