"""Photocentres along scans: predictions, derivatives, correlated errors, linear unknowns, and fits of Gaia's scans."""

import astropy.units as u
import fullbody
import numpy as np
import pandas
import pytest
from astropy.table import Table
from astropy.time import Time
from fullbody import observing
from fullbody.record.record import joined
from support import DATA, body_list, refused
from support.displacements import assert_by_kind, by_start

VIEW = {"to_observer": [0.1, 0.01, 0.03] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au, "frame": "ecliptic"}
TIMES = np.linspace(1.0, 23.0, 12) * u.h
SCAN = np.linspace(0.0, 330.0, 12) * u.deg


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.didymos(units=True)
    return system.integrate(state, "1 day", dense=True)


@pytest.fixture(scope="module")
def geometry():
    return observing.Geometry([0.0, 48.0] * u.h, **VIEW)


NOTHING = np.zeros(12) * u.mas


def photocentre(geometry, offset=NOTHING, sigma=0.2 * u.mas, **options):
    return observing.Photocentre(TIMES, offset, sigma, **({"scan_angle": SCAN, "geometry": geometry} | options))


def test_predictions_are_the_combined_light_along_the_scan(run, geometry):
    light = observing.combined_light(run, TIMES, geometry)
    expected = light.offset[:, 0] * np.sin(SCAN) + light.offset[:, 1] * np.cos(SCAN)
    data = photocentre(geometry)
    np.testing.assert_allclose(data.predict(run).to_value("mas"), expected.to_value("mas"), rtol=1e-12, atol=1e-14)
    both = photocentre(geometry, np.zeros((12, 2)) * u.mas, scan_angle=None)
    np.testing.assert_allclose(both.predict(run).to_value("mas"), light.offset.to_value("mas"), rtol=1e-12)
    assert both.plot(run).shape == (2, 2)
    assert data.plot(run)[0, 0].get_ylabel() == "along the scan [mas]"


@pytest.mark.parametrize("shape", ["ellipsoids", "in an event"])
def test_derivatives_are_differences_of_the_pulls(run, geometry, shape):
    system, state = fullbody.systems.didymos(units=True)
    time = 7.3 * u.h
    if shape == "in an event":
        event = next(
            e for e in observing.mutual_events(run, geometry) if e.kind == "occultation" and e.begin is not None
        )
        time = event.begin + 0.3 * event.duration
    row = [0.0] * u.mas, 1e-3 * u.mas
    data = observing.Photocentre([time.value] * u.h, *row, scan_angle=[0.7], geometry=geometry)
    moment = system.integrate(state, data.emission(system)[0], output="ends")[-1]
    steps = {"position": 2e-5, "velocity": 1e-4, "rotation": 2e-5, "spin": 1e-4}
    exact, differences = by_start(data, system, moment, steps)
    assert_by_kind(exact, differences, 3e-6, 1e-8 * np.abs(differences).max())


def test_derivatives_with_respect_to_masses_and_axes_are_differences_of_runs(geometry):
    data = photocentre(geometry)
    system, state = fullbody.systems.didymos(units=True)
    times = data.emission(system)
    names = ["mass of Didymos", "semi-axis a of Didymos", "semi-axis c of Dimorphos"]
    run = system.integrate(state, times[-1], output=times, derivatives=names)
    result = data.derivatives(run).by_parameter
    expected = run.derivative_of(data.pulls).by_parameter
    for name in names:
        np.testing.assert_allclose(result[name], expected[name], atol=1e-7 * np.abs(expected[name]).max())


def test_errors_of_a_transit_are_correlated(run, geometry):
    transit = ["a", "a", "b", "b", "b", "c", "d", "d", "e", "e", "f", "f"]
    offset = np.random.default_rng(3).normal(size=12) * u.mas
    common = {"transit": transit, "sigma_transit": 0.5 * u.mas}
    data = photocentre(geometry, offset, **common)
    residuals = data.residuals(run).to_value("mas")
    same = np.equal.outer(transit, transit)
    covariance = 0.2**2 * np.eye(12) + 0.5**2 * same
    assert data.chi2(run) == pytest.approx(residuals @ np.linalg.solve(covariance, residuals), rel=1e-10)
    # Transits of equal lengths are blocks, and give the same as one block of all rows.
    pairs = np.repeat(["a", "b", "c", "d", "e", "f"], 2)
    regular = photocentre(geometry, offset, **common | {"transit": pairs})
    covariance = 0.2**2 * np.eye(12) + 0.5**2 * np.equal.outer(pairs, pairs)
    assert regular.chi2(run) == pytest.approx(residuals @ np.linalg.solve(covariance, residuals), rel=1e-10)
    wider = regular.with_jitter(0.3 * u.mas)
    covariance += 0.3**2 * np.eye(12)
    assert wider.chi2(run) == pytest.approx(residuals @ np.linalg.solve(covariance, residuals), rel=1e-10)
    assert np.all(data.sigma == 0.2 * u.mas)


def test_positions_and_drifts_of_groups_are_solved_for(run, geometry):
    group = np.repeat([2021, 2022], 6)
    predicted = photocentre(geometry).predict(run).to_value("mas")
    sine, cosine, hours = np.sin(SCAN).value, np.cos(SCAN).value, TIMES.value
    shift = np.where(group == 2021, 3.0 * sine - 2.0 * cosine + 0.1 * (hours - hours[:6].mean()) * sine, 5.0 * cosine)
    data = photocentre(geometry, (predicted + shift) * u.mas, group=group, position="free", drift="free")
    results = {name: value for name, value in data.linear_values(run).items()}
    assert results["position east of 2021"].to_value("mas") == pytest.approx(3.0, abs=1e-9)
    assert results["position north of 2021"].to_value("mas") == pytest.approx(-2.0, abs=1e-9)
    assert results["position north of 2022"].to_value("mas") == pytest.approx(5.0, abs=1e-9)
    assert results["drift east of 2021"].to_value("mas / h") == pytest.approx(0.1, abs=1e-9)
    assert data.chi2(run) < 1e-15


ELEMENTS = {"a": 2.4 * u.au, "e": 0.12, "i": 8 * u.deg, "Omega": 100 * u.deg, "omega": 200 * u.deg, "M": 30 * u.deg}
SPAN = Time(["2022-10-01", "2024-10-01"], scale="utc")


def on_orbit(epoch="2023-09-25 TDB", **changes):
    elements = {name: value + changes.get(name, 0.0 * getattr(value, "unit", 1.0)) for name, value in ELEMENTS.items()}
    return observing.Geometry.from_orbit(fullbody.KeplerElements(**elements), epoch, span=SPAN)


def test_corrections_of_the_heliocentric_elements_displace_the_barycentre_as_another_orbit_does():
    bodies = body_list(A=(fullbody.Sphere(3.0), 9e12))
    system = fullbody.System(bodies, units=True, frame="ecliptic", epoch="2022-09-26 TDB")
    state = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)))
    times = Time("2023-09-25", scale="tdb") + np.linspace(-340.0, 340.0, 41) * u.day
    rad = u.rad
    true = {"a": 2e-8 * u.au, "e": 1e-8, "i": 2e-8 * rad, "Omega": -1e-7 * rad, "omega": 5e-8 * rad, "M": 1e-8 * rad}
    assumed, actual = on_orbit(), on_orbit(**true)
    lines = [
        -np.array(fullbody.frames.rotate(view.to_observer(times).to_value("km"), "ecliptic", "equatorial"))
        for view in (assumed, actual)
    ]
    (ra, dec), (ra_actual, dec_actual) = (
        (np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))) for x, y, z in (line.T for line in lines)
    )
    displaced = np.stack([(ra_actual - ra) * np.cos(dec), dec_actual - dec], axis=1) * rad
    run = system.integrate(state, 2.0 * u.yr, dense=True)
    light = observing.combined_light(run, times, assumed).offset
    data = observing.Photocentre(times, displaced + light, 1e-3 * u.mas, geometry=assumed, orbit="free")
    corrections = {f"correction of {name}": value for name, value in true.items()}
    predicted = (data.predict(run, linear=corrections) - light).to_value("rad")
    # The light time changes with the distance: 1e-4 of the effect of the velocity.
    np.testing.assert_allclose(predicted, displaced.value, atol=3e-4 * np.abs(displaced.value).max())
    assert np.abs(data.residuals(run)).max() < 1e-4 * np.abs(displaced).max()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"scan_angle": SCAN.value},
            "scan_angle of Photocentre has the value 330 without a unit; expected radians up to 2 pi",
        ),
        (
            {"scan_angle": None},
            r"offset of Photocentre has shape \(12,\); expected \(K, 2\), east and north, or scan_angle=",
        ),
        (
            {"offset": np.zeros((12, 2)) * u.mas},
            r"offset of Photocentre has shape \(12, 2\); expected \(K,\), along the scan",
        ),
        ({"sigma": 0.0 * u.mas}, "sigma of Photocentre has the value 0.0; expected standard errors above zero"),
        ({"sigma": 0.1}, "only one of offset and sigma of Photocentre has a unit"),
        ({"transit": np.arange(12)}, "only one of transit and sigma_transit of Photocentre is given"),
        ({"group": [1, 2]}, r"group of Photocentre has shape \(2,\); expected \(12,\)"),
        ({"position": True}, "position is True"),
        ({"orbit": "fixed"}, "orbit is 'fixed'"),
        ({"scan_angle": SCAN[:3]}, r"scan_angle of Photocentre has shape \(3,\); expected 12 rows"),
    ],
)
def test_bad_photocentres_are_refused_by_name(geometry, options, message):
    arguments = {"offset": np.zeros(12) * u.mas} | options
    refused(message, lambda: photocentre(geometry, **arguments))


def test_a_sun_that_does_not_move_gives_no_corrections_of_elements(run, geometry):
    data = photocentre(geometry, orbit="free")
    refused(
        "corrections of the heliocentric elements need a geometry in which the Sun moves", lambda: data.predict(run)
    )
    refused(
        "geometry of Photocentre has no Sun",
        lambda: photocentre(observing.Geometry([0.0] * u.h, to_observer=[1e6, 0, 0] * u.km)),
    )


def test_a_system_that_gives_no_light_has_no_photocentre():
    system = fullbody.System(body_list(A=(fullbody.Sphere(3.0), 9e13)), units=True, frame="ecliptic")
    run = system.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3))), 30.0, dense=True)
    behind = {"to_observer": [-1e6, 0, 0] * u.km, "to_sun": [1e8, 0, 0] * u.km, "light_time": False}
    data = photocentre(observing.Geometry([0.0, 48.0] * u.h, **behind))
    refused("no light comes from the system at 1.0 h, but a photocentre was observed", lambda: data.predict(run))


def test_tables_are_written_and_read_back(geometry):
    labels = {"transit": np.repeat(list("abcdef"), 2), "group": np.repeat([1, 2], 6)}
    data = photocentre(geometry, np.arange(12.0) * u.mas, sigma_transit=0.5 * u.mas, **labels)
    table = data.to_table()
    names = {"transit": "transit", "group": "group"}
    back = observing.Photocentre.from_table(table, **names, geometry=geometry)
    for name in ("offset", "sigma", "scan_angle"):
        np.testing.assert_allclose(getattr(back, name).value, getattr(data, name).value, rtol=1e-15)
    np.testing.assert_array_equal(back.transits, data.transits)
    np.testing.assert_array_equal(back.groups, data.groups)
    assert Table(table).colnames[:4] == ["times", "offset", "sigma", "scan_angle"]


# A binary whose light moves by about 1 mas, seen in 60 transits with the times and angles of Gaia.
MASS, RADII, TRUE = 2.3e17, (30.0, 1.95), {"period": 208.0, "mass": 2e14, "phase": 1.0}
G = 6.6743e-20 * 3600.0**2


def gaia():
    """Times and scan angles of 60 transits over 3.6 years; see the file for their source."""
    table = pandas.read_csv(DATA / "gaia_scan_angles.csv", comment="#")
    return Time(table["time_utc"].to_list(), scale="utc"), table["scan_angle_rad"].to_numpy() * u.rad


def binary(period, mass, phase, inclination=0.7, node=1.2):
    """Two spheres on a circular orbit, with the total mass fixed."""
    mu, share = G * MASS, mass / MASS
    bodies = body_list(A=(fullbody.Sphere(RADII[0]), MASS - mass), B=(fullbody.Sphere(RADII[1]), mass))
    epoch = Time("2016-07-28", scale="utc")
    system = fullbody.System(bodies, G=G, units=("km", "h", "kg"), epoch=epoch, frame="ecliptic", gravity="point")
    semi_axis = np.cbrt(mu * (period / (2.0 * np.pi)) ** 2)
    r, v = fullbody.KeplerElements(semi_axis, 0.0, inclination, node, 0.0, phase).to_cartesian(mu)
    shares = [-share, 1.0 - share]
    return system, fullbody.State(position=np.outer(shares, r), velocity=np.outer(shares, v))


@pytest.mark.filterwarnings("ignore:B has a density")
def test_sixty_transits_of_gaia_give_the_period_and_the_mass_for_the_light_and_false_twins_are_listed():
    times, scan = gaia()
    orbit = fullbody.KeplerElements(2.6 * u.au, 0.1, *([4.0, 60.0, 120.0, 30.0] * u.deg))
    geometry = observing.Geometry.from_orbit(orbit, "2014-09-01 TDB", span=times[[0, -1]])
    options = {"scan_angle": scan, "geometry": geometry}
    system, state = binary(**TRUE)
    integrator = fullbody.Verner98(rtol=1e-9, atol=1e-9)
    blank = observing.Photocentre(times, np.zeros(60) * u.mas, 0.2 * u.mas, **options)
    moments = blank.emission(system).to_value("h")
    parts = (moments[moments >= 0.0], moments[moments < 0.0][::-1])
    later, earlier = (system.integrate(state, part[-1], output=part, integrator=integrator) for part in parts)
    wobble = blank.predict(joined(later, earlier))
    assert 0.8 < wobble.std().to_value("mas") < 1.5
    noise = np.random.default_rng(5).normal(scale=0.2, size=60) * u.mas
    data = observing.Photocentre(times, wobble + noise, 0.2 * u.mas, **options)
    angles = {"inclination": 0.78, "node": 1.13}
    starts = [{"period": 208.1, "mass": 1e14, "phase": 0.8}, {"period": 208.1, "mass": 1.6e15, "phase": 3.9}]
    starts += [{"period": 210.2, "mass": 1.6e15, "phase": 2.4, "inclination": 2.9, "node": 0.5}]
    fit = fullbody.fit(
        binary, starts[0] | angles, data, integrator=integrator, starts=[angles | start for start in starts]
    )
    light, heavy = sorted((item for item in fit.minima if item.chi2 < 60.0), key=lambda item: item.values["mass"])
    assert abs(light.values["period"] - 208.0) < 3.0 * fit.sigma["period"] < 0.12
    assert abs(light.values["mass"] - 2e14) < 3.0 * fit.sigma["mass"] < 1.5e14
    assert fit.p_value > 0.01
    # The same wobble belongs to a satellite on the other side that is too massive for its light.
    share = RADII[1] ** 2 / (RADII[0] ** 2 + RADII[1] ** 2)
    assert heavy.values["mass"] / MASS - share == pytest.approx(share - light.values["mass"] / MASS, rel=1e-2)
    assert heavy.values["period"] == pytest.approx(light.values["period"], rel=1e-6)
    assert heavy.chi2 == pytest.approx(light.chi2, abs=0.01)
    # Another period, a percent away, is a minimum of its own that the data reject.
    false = max(fit.minima, key=lambda item: item.chi2)
    assert abs(false.values["period"] - 208.0) > 1.0
    assert false.chi2 > fit.chi2 + 100.0
