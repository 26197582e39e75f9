"""Light curves of runs and photometry: another program's nights, zero points, and derivatives."""

import inspect
import json

import astropy.units as u
import fullbody
import numpy as np
import pandas
import pytest
from astropy.time import Time
from fullbody import observing
from fullbody.errors import InconsistentInput, Interrupted, InvalidInput
from fullbody.observing.states import retarded
from support import DATA, refused
from support.displacements import by_start


@pytest.fixture(scope="module")
def nights():
    """Two nights of a binary by a program that shares the states alone: brightness of each body, times as observed."""
    return json.loads((DATA / "light_curve.json").read_text())


@pytest.fixture(scope="module")
def run(nights):
    shapes = [fullbody.Ellipsoid(*axes) for axes in nights["axes"]]
    bodies = [fullbody.Body(shape, mass=m, name=n) for shape, m, n in zip(shapes, nights["mass"], "AB", strict=True)]
    system = fullbody.System(bodies, G=nights["G"], units=("km", "hour", "kg"), frame="ecliptic")
    state = fullbody.State(**{name: nights[name] for name in ("position", "velocity", "attitude", "spin")})
    return system.integrate(state, 40.0, dense=True)


@pytest.fixture(scope="module")
def geometry(nights):
    vectors = {name: np.array(nights[name]) * u.km for name in ("to_observer", "to_sun")}
    return observing.Geometry([0.0, 41.0] * u.h, **vectors)


def test_light_curve_is_that_of_another_program(nights, run, geometry):
    light = np.array(nights["light"])
    # Rows at which the other program is off, by up to 1.5e-5 of the satellite.
    for row in json.loads((DATA / "hidden_light.json").read_text())["rows"]:
        light[row["row"], 1] = row["exact"]
    vectors = {name: np.array(nights[name]) for name in ("to_observer", "to_sun")}
    # Plain numbers are directions, which the other program takes for both bodies.
    emitted = observing.Geometry([0.0, 41.0] * u.h, **vectors, light_time=False)
    magnitudes = observing.light_curve(run, np.array(nights["emitted"]) * u.h, emitted, per_body=True)
    seen = light > 1e-6 * light.max(axis=0)
    np.testing.assert_allclose(magnitudes[seen], -2.5 * np.log10(light[seen]), rtol=0, atol=1e-8)
    # A body that is hidden has no light: an infinite magnitude, and no more than round-off otherwise.
    assert (10.0 ** (-0.4 * magnitudes[~seen]) < 1e-5 * light.max()).all()
    # The other program has one light time for both bodies, which differs from each one's own by microseconds, and one
    # distance: a body that is nearer to observer and Sun by x is brighter by the squares.
    both = observing.light_curve(run, np.array(nights["times"]) * u.h, geometry)
    radius = np.abs(run.position.to_value("km")).max()
    near = 2 * 1.0857 * radius * sum(1 / np.linalg.norm(vector) for vector in vectors.values())
    np.testing.assert_allclose(both, -2.5 * np.log10(light.sum(axis=1)), rtol=0, atol=1e-8 + near)


def test_magnitudes_follow_albedo_and_distance_and_not_the_frame(nights, run, geometry):
    times = np.array(nights["times"])[::40] * u.h
    reference = observing.light_curve(run, times, geometry)
    darker = observing.light_curve(run, times, geometry, albedo=0.1)
    np.testing.assert_allclose(darker - reference, 2.5, rtol=1e-12)
    distance = np.linalg.norm(nights["to_observer"]) * np.linalg.norm(nights["to_sun"])
    apparent = observing.light_curve(run, times, geometry, reduced=False)
    np.testing.assert_allclose(apparent - reference, 5.0 * np.log10(distance), rtol=1e-12)
    rotated = {
        name: fullbody.frames.rotate(nights[name], "ecliptic", "equatorial") * u.km
        for name in ("to_observer", "to_sun")
    }
    other = observing.Geometry([0.0, 41.0] * u.h, **rotated, frame="equatorial")
    np.testing.assert_allclose(observing.light_curve(run, times, other), reference, atol=1e-9)


def test_light_changes_between_the_contacts_of_mutual_events_and_only_there(run, geometry):
    events = [
        event for event in observing.mutual_events(run, geometry) if event.begin is not None and event.end is not None
    ]
    assert len(events) > 5

    def hidden(time, body):
        light = [
            observing.light_curve(run, [time.value] * u.h, geometry, per_body=True, mutual=m)[0, body]
            for m in (False, True)
        ]
        return light[1] - light[0]

    for event in events[:5]:
        body = run.system.index(event.body)
        remainder = [other for other in events if other is not event and other.body == event.body]
        for contact, inward in ((event.begin, 1.0), (event.end, -1.0)):
            outside, inside = contact - inward * 1e-3 * u.h, contact + inward * 4e-2 * u.h
            if any(other.begin < max(outside, inside) and other.end > min(outside, inside) for other in remainder):
                continue
            assert abs(hidden(outside, body)) < 1e-13
            # What is hidden may lie on the dark side, or beyond the limb.
            assert hidden(inside, body) > -1e-13


def test_zero_points_are_those_of_least_squares(nights, run, geometry):
    rng = np.random.default_rng(3)
    times = np.array(nights["times"])
    model = observing.light_curve(run, times * u.h, geometry)
    sigma = rng.uniform(0.005, 0.02, len(times))
    first = times < 15.0
    observed = model + np.where(first, 14.2, 14.5) + sigma * rng.normal(size=len(times))
    data = observing.Photometry(times * u.h, observed, sigma, geometry=geometry)
    assert len(data.nights) == 2
    design = np.stack([first, ~first], axis=1) / sigma[:, None]
    zeros, chi2, *_ = np.linalg.lstsq(design, (observed - model) / sigma, rcond=None)
    np.testing.assert_allclose(data.zero_points(run), zeros, rtol=1e-12)
    assert list(data.linear_values(run)) == ["zero point of 0", "zero point of 1"]
    assert data.chi2(run) == pytest.approx(chi2[0], rel=1e-9)
    np.testing.assert_allclose(data.predict(run), model + np.where(first, *zeros), rtol=1e-12)
    named = observing.Photometry(times * u.h, observed, sigma, geometry=geometry, night=np.where(first, "a", "b"))
    np.testing.assert_array_equal(named.residuals(run), data.residuals(run))
    fixed = observing.Photometry(times * u.h, observed, sigma, geometry=geometry, zero=14.2)
    np.testing.assert_allclose(fixed.residuals(run), observed - model - 14.2, atol=1e-12)
    assert fixed.linear_values(run) == {}


def test_partial_derivatives_are_differences(nights, run, geometry):
    # Moments of each kind: alone, in an occultation, in an eclipse; not at contacts.
    times = np.array(nights["times"])[[10, 60, 75, 90]]
    steps = {"position": 1e-6, "velocity": 1e-2, "rotation": 1e-6, "spin": 1.0}
    results = []
    for time in times:
        data = observing.Photometry([time] * u.h, [0.0], 1.0, geometry=geometry, zero=0.0)
        results.append(by_start(data, run.system, run(data.emission(run.system)[0]), steps))
    exact, differences = (np.array(values).reshape(4, 2, 4, 3) for values in zip(*results, strict=True))
    for kind, (name, step) in enumerate(steps.items()):
        size = np.abs(exact[:, :, kind]).max()
        np.testing.assert_allclose(
            exact[:, :, kind], differences[:, :, kind], atol=2e-6 * size + 1e-12 / step, err_msg=name
        )


def test_photometry_is_read_from_tables_with_masked_rows_and_dates(nights):
    table = pandas.DataFrame({"JD": [2459850.5, 2459850.25, 2459850.75], "V": [14.0, np.nan, 14.2], "e": [0.01] * 3})
    dated = observing.Geometry(
        Time([2459850.0, 2459852.0], format="jd", scale="tdb"),
        to_observer=[0.1, 0, 0] * u.au,
        to_sun=[1.0, 0, 0] * u.au,
    )
    with pytest.warns(InconsistentInput, match="1 of 3 rows of Photometry"):
        data = observing.Photometry.from_table(
            table, columns={"times": "JD", "magnitude": "V", "sigma": "e"}, dates=("jd", "utc"), geometry=dated
        )
    assert data.magnitude.tolist() == [14.0, 14.2]
    back = observing.Photometry.from_table(data.to_table(), night="night", geometry=dated)
    assert back.magnitude.tolist() == data.magnitude.tolist()
    assert (back.times == data.times).all()


def test_times_beyond_what_is_known_are_refused(run, geometry):
    refused("outside the span of the geometry", lambda: observing.light_curve(run, [42.0] * u.h, geometry))
    refused("does not cover", lambda: observing.light_curve(run, [40.9] * u.h, geometry))
    with pytest.raises(InvalidInput, match="has no Sun"):
        observing.light_curve(run, [1.0] * u.h, observing.Geometry([0.0, 2.0] * u.h, to_observer=[1.0, 0, 0] * u.au))


def test_ctrl_c_ends_a_light_curve(run, geometry, monkeypatch):
    # Ctrl-C comes while the second part of the times is computed: the third one is not begun.
    parts = []

    def states(*arguments):
        parts.append(arguments)
        if len(parts) == 2:
            raise KeyboardInterrupt
        return retarded(*arguments)

    monkeypatch.setitem(inspect.unwrap(observing.light_curve).__globals__, "retarded", states)
    with pytest.raises(Interrupted, match="interrupted in a light curve"):
        observing.light_curve(run, np.linspace(1.0, 39.0, 20_000) * u.h, geometry)
    assert len(parts) == 2


def test_a_near_observer_is_refused(run):
    # The bodies reach some kilometres from the barycentre.
    near = observing.Geometry([0.0, 41.0] * u.h, to_observer=[30.0, 0, 10.0] * u.km, to_sun=[1.0, 0.2, 0.0] * u.au)
    with pytest.raises(InvalidInput, match=r"the observer of the geometry is too near .* expected one from .* on"):
        observing.light_curve(run, [20.0] * u.h, near)
    # Contacts have no least distance but that of the bodies.
    assert observing.mutual_events(run, near)
    within = observing.Geometry([0.0, 41.0] * u.h, to_observer=[1.0, 0, 0.0] * u.km)
    refused(r"the observer of the geometry is .* expected one from", observing.mutual_events, run, within)
