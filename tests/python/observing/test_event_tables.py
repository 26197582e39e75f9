"""Mutual events with their depths, the contacts of penumbra and umbra, and their tables."""

import astropy.units as u
import numpy as np
import pytest
from astropy.time import Time
from fullbody import observing
from support import refused
from test_mutual import R1, R2, A, circular

ALPHA = 0.02
FAR = observing.Geometry([-20.0, 20.0], to_observer=[1.0, 0, 0], to_sun=[1.0, 0, 0], light_time=False)


def events(kind, inclination=0.0, geometry=FAR, **options):
    """The events of a kind of two spheres on a circle, behind each other at 0.5 pi and 1.5 pi."""
    return [e for e in observing.mutual_events(circular(inclination)[2], geometry, **options) if e.kind == kind]


def test_contacts_of_penumbra_and_umbra_of_spheres_are_those_of_geometry():
    """Seen from a point of the limb at an angle to the centre, the conjunction comes earlier or later by that angle."""
    eclipses = events("eclipse", sun_radius=ALPHA)
    outer, inner = np.arcsin((R1 + R2) / A), np.arcsin((R1 - R2) / A)
    for event, middle in zip(eclipses, (0.5 * np.pi, 1.5 * np.pi), strict=True):
        contacts = [event.begin, event.umbra_begin, event.umbra_end, event.end]
        expected = middle + np.array([-outer - ALPHA, -outer + ALPHA, outer - ALPHA, outer + ALPHA])
        np.testing.assert_allclose(contacts, expected, atol=2e-7)
    first, second = eclipses
    expected = 0.5 * np.pi + np.array([-1.0, 1.0]) * (inner - ALPHA)
    np.testing.assert_allclose([first.total_begin, first.total_end], expected, atol=2e-7)
    assert second.total_begin is None
    # An occultation does not depend on the Sun.
    point_sun, disc = (events("occultation", sun_radius=radius) for radius in (0.0, ALPHA))
    assert point_sun == disc
    assert point_sun[0].umbra_begin is None


def test_contacts_of_an_inclined_orbit_are_those_of_shadows_that_are_wider_and_narrower():
    """The penumbra of distant spheres is wider than the shadow by the distance times the angle, to its second order."""
    inclination, alpha = 0.1, 1e-3
    event = events("eclipse", inclination, sun_radius=alpha)[0]
    for contact, sign in ((event.begin, 1.0), (event.umbra_begin, -1.0)):
        t = contact - 0.5 * np.pi
        across = A * np.sqrt(np.sin(t) ** 2 + np.cos(t) ** 2 * np.sin(inclination) ** 2)
        along = np.sqrt(A**2 - across**2)
        assert across - sign * along * alpha == pytest.approx(R1 + R2, abs=5.0 * A * alpha**2)


def test_an_eclipse_by_the_penumbra_alone_has_no_umbra():
    inclination = np.arcsin((R1 + R2 + 0.5 * A * ALPHA) / A)
    assert events("eclipse", inclination) == []
    results = events("eclipse", inclination, sun_radius=ALPHA)
    assert [e.by for e in results] == ["A", "B"]
    for event in results:
        assert event.umbra_begin is event.umbra_end is event.total_begin is None
        # At conjunction the centres are half a penumbra farther apart than the sum of the radii.
        assert event.begin < event.middle < event.end
        assert event.middle % np.pi == pytest.approx(0.5 * np.pi, abs=1e-6)


@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_the_depth_of_an_event_of_even_discs_is_that_of_the_area_it_hides(ratio):
    """At phase angle zero Lommel and Seeliger's law makes discs evenly bright, of the albedo times the area."""
    options = {"law": observing.LommelSeeliger(), "albedo": {"A": 1.0, "B": ratio}}
    view = observing.Geometry([-20.0, 20.0], to_observer=[1.0, 0, 0], to_sun=[1.0, 1e-9, 0], light_time=False)
    behind, front = events("occultation", geometry=view, **options)
    total = R1**2 + ratio * R2**2
    assert behind.depth == pytest.approx(2.5 * np.log10(total / R1**2), abs=1e-6)
    assert front.depth == pytest.approx(2.5 * np.log10(total / (total - R2**2)), abs=1e-6)
    assert behind.total_begin < behind.deepest < behind.total_end
    assert events("occultation", geometry=view)[0].depth is None


def test_the_depth_of_a_partial_event_is_the_lens_that_it_hides():
    inclination = 0.2
    options = {"law": observing.LommelSeeliger()}
    view = observing.Geometry([-20.0, 20.0], to_observer=[1.0, 0, 0], to_sun=[1.0, 0, 1e-9], light_time=False)
    event = events("occultation", inclination, view, **options)[0]
    d = A * np.sin(inclination)
    halves = [np.arccos((d * d + r * r - s * s) / (2 * d * r)) for r, s in ((R1, R2), (R2, R1))]
    lens = sum(r * r * (h - np.sin(h) * np.cos(h)) for r, h in zip((R1, R2), halves, strict=True))
    total = np.pi * (R1**2 + R2**2)
    assert event.depth == pytest.approx(2.5 * np.log10(total / (total - lens)), abs=1e-6)
    assert event.deepest == pytest.approx(0.5 * np.pi, abs=1e-3)


def test_a_table_of_events_has_dates_in_utc():
    epoch = "2021-11-28 TDB"
    run = circular(units=("km", "hour", "kg"), epoch=epoch, until=4.7)[2]
    view = observing.Geometry([-20.0, 20.0] * u.h, to_observer=[1.0, 0, 0], to_sun=[1.0, 0.2, 0], light_time=False)
    result = observing.mutual_events(run, view, sun_radius=0.3 * u.deg, law=observing.LommelSeeliger())
    table = result.to_table()
    assert table.colnames[:4] == ["kind", "body", "by", "begin"]
    contacts = {"umbra_begin", "total_begin", "total_end", "umbra_end", "end"}
    assert set(table.colnames[4:]) == {*contacts, "deepest", "depth"}
    assert list(table["kind"]) == [event.kind for event in result]
    # UTC was 37 s behind TAI, and TDB is 32.184 s ahead of that, to 2 ms.
    expected = Time("2021-11-28T00:00:00", scale="utc") + [event.begin.to_value("s") - 69.184 for event in result] * u.s
    assert np.abs((table["begin"] - expected).to_value("s")).max() < 2e-3
    assert table["begin"].scale == "utc"
    assert table["depth"].unit == u.mag
    assert list(table["umbra_begin"].mask) == [event.umbra_begin is None for event in result]
    # The run ends within the last of the events.
    assert list(table["end"].mask) == [event.end is None for event in result]
    assert table["end"].mask[-1]
    reference = observing.mutual_events(circular()[2], FAR).to_table()
    assert reference["begin"][0] == pytest.approx(0.5 * np.pi - np.arcsin((R1 + R2) / A))
    assert "depth" not in reference.colnames
    assert len(observing.mutual_events(circular(1.0)[2], FAR).to_table()) == 0
    refused("sun_radius is -0.1", lambda: observing.mutual_events(run, view, sun_radius=-0.1))
