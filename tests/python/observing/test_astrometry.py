"""Relative astrometry and its errors; Eris against independent fits."""

import astropy.units as u
import fullbody
import numpy as np
import pandas
import pytest
from astropy.table import Table
from astropy.time import Time
from fullbody import observing
from fullbody.errors import InconsistentInput, InvalidInput
from fullbody.observing.light_centres import photocentre
from fullbody.record.record import joined
from scipy.optimize import least_squares
from support import DATA, body_list, matrix, refused
from support.displacements import assert_by_kind, by_start
from support.eris import EPOCH, ERIS

NAMES = {
    "times": "time",
    "east": "Delta-RA_Dysnomia",
    "north": "Delta-DEC_Dysnomia",
    "sigma": ("Delta-RA_Dysnomia-err", "Delta-DEC_Dysnomia-err"),
}
#: km^3 / (kg day^2)
G = 6.6743e-20 * 86400.0**2


@pytest.fixture(scope="module")
def eris():
    """The 19 epochs of Dysnomia from Brown & Schaller (2007) and Holler et al. (2021)."""
    table = pandas.read_csv(DATA / "observations" / "eris_dysnomia.csv")
    span = Time(table["time"].to_numpy(), format="jd", scale="utc")
    geometry = observing.Geometry.from_orbit(ERIS, EPOCH, span=span)
    return observing.Astrometry.from_table(
        table, columns=NAMES, unit=u.arcsec, dates=("jd", "utc"), body="Dysnomia", about="Eris", geometry=geometry
    )


def dysnomia(a, period, e, i, node, argument, mean):
    """Two points on a Kepler orbit along the axes of the equator, JD 2453979.0; km, days, degrees."""
    mu = 4 * np.pi**2 * a**3 / period**2
    share = 0.005
    masses = (1.0 - share) * mu / G, share * mu / G
    bodies = body_list(Eris=(fullbody.PointMass(), masses[0]), Dysnomia=(fullbody.PointMass(), masses[1]))
    options = {"units": ("km", "day", "kg"), "frame": "equatorial", "gravity": "point"}
    system = fullbody.System(bodies, G=G, epoch=Time(2453979.0, format="jd", scale="utc"), **options)
    r, v = fullbody.KeplerElements(a, e, *np.radians([i, node, argument, mean])).to_cartesian(mu)
    return system, fullbody.State(position=np.outer([-share, 1 - share], r), velocity=np.outer([-share, 1 - share], v))


def pulls(parameters, data):
    """Residuals of a run each way from the epoch, over the standard errors."""
    system, state = dysnomia(*parameters)
    times = data.emission(system).to_value("day")
    how = {"integrator": fullbody.Verner98(rtol=1e-10, atol=1e-10)}
    later = system.integrate(state, times.max(), output=times[times >= 0.0], **how)
    earlier = system.integrate(state, times.min(), output=times[times < 0.0][::-1], **how)
    return data.pulls(joined(later, earlier)).ravel()


def test_eris_has_the_chi2_and_the_orbit_of_independent_fits(eris):
    # Independent fits with light time: chi2 107.545 for 31 degrees of freedom, a 37272.3 +- 61.0 km, P 15.785897 +-
    # 0.000047 d, e 0.00624 +- 0.00101, i 45.50 +- 0.16, node 126.15 +- 0.27 degrees. Holler et al. (2021) have
    # 37273 +- 64 km, 15.785899 +- 0.000050 d, 0.0062 +- 0.0010, 45.49 +- 0.15, 126.17 +- 0.26.
    start = [37273.0, 15.785899, 0.0062, 45.49, 126.17, 181.06, 178.54]
    scale = [60.0, 5e-5, 1e-3, 0.15, 0.3, 10.0, 10.0]
    fit = least_squares(pulls, start, x_scale=scale, args=(eris,), max_nfev=5)
    error = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
    assert 2 * fit.cost == pytest.approx(107.545, abs=0.005)
    off = np.abs(fit.x[:5] - [37272.3, 15.785897, 0.00624, 45.50, 126.15])
    assert (off < [0.1, 1e-6, 1e-5, 0.01, 0.01]).all()
    np.testing.assert_allclose(error[:5], [61.0, 0.000047, 0.00101, 0.16, 0.27], rtol=0.03)


def test_partial_derivatives_are_differences_of_the_predictions(eris):
    system, state = dysnomia(37272.3, 15.785897, 0.00624, 45.50, 126.15, 181.0, 178.5)
    row = eris.times[-1:], [0.0] * u.rad, [0.0] * u.rad, 1.0 * u.rad
    last = observing.Astrometry(*row, body="Dysnomia", about="Eris", geometry=eris.geometry)
    time = last.emission(system).to_value("day")[0]
    moment = system.integrate(state, time, output="ends")[-1]
    exact, differences = by_start(last, system, moment, {"position": 100.0, "velocity": 1e4})
    assert_by_kind(exact, differences, 1e-8)


def pair(**options):
    """Two points at rest, far from each other; one au from the observer on the x-axis of the equator."""
    bodies = [fullbody.Body(fullbody.PointMass(), mass=1.0, name=name) for name in "AB"]
    system = fullbody.System(bodies, G=1e-30, gravity="point", units=True, frame="equatorial", **options)
    geometry = observing.Geometry([0.0, 10.0] * u.h, to_observer=[-1.0, 0.0, 0.0] * u.au)
    return system, geometry


def test_offsets_to_the_east_and_north_are_those_of_the_sky():
    system, geometry = pair()
    state = fullbody.State(position=[[0, 0, 0], [0, 725.0, 1450.0]], velocity=np.zeros((2, 3)))
    run = system.integrate(state, 10.0, dense=True)
    data = observing.Astrometry([5.0] * u.h, [0.0] * u.arcsec, [0.0] * u.arcsec, 1 * u.mas, geometry=geometry)
    # 725.27 km at 1 au is an arc second; the observer is at -x, so that the system is in the direction of ra = 0.
    expected = np.array([[725.0, 1450.0]]) / 149597870.7 * 206264.80625
    np.testing.assert_allclose(data.predict(run).to_value("arcsec"), expected, rtol=1e-10)
    np.testing.assert_allclose(data.residuals(run).to_value("arcsec"), -expected, rtol=1e-10)
    assert data.chi2(run) == pytest.approx(np.sum((expected / 1e-3) ** 2), rel=1e-9)
    swapped = observing.Astrometry([5.0] * u.h, [0.0], [0.0], 1.0, body="A", about="B", geometry=geometry)
    np.testing.assert_allclose(swapped.predict(run), -expected / 206264.80625, rtol=1e-4)


def test_errors_of_separation_and_angle_become_an_ellipse():
    _, geometry = pair()
    rng = np.random.default_rng(1)
    separation, angle, errors = 0.5, np.radians(130.0), (0.004, 0.02)
    errors_in = errors[0] * u.arcsec, errors[1] * u.rad
    values = [separation] * u.arcsec, [angle] * u.rad
    data = observing.Astrometry.from_polar([1.0] * u.h, *values, *errors_in, geometry=geometry)
    rho, theta = separation + errors[0] * rng.normal(size=100000), angle + errors[1] * rng.normal(size=100000)
    drawn = np.cov(rho * np.sin(theta), rho * np.cos(theta))
    np.testing.assert_allclose(data.covariance[0].to_value("arcsec2"), drawn, rtol=0.02)
    assert data.east[0].to_value("arcsec") == pytest.approx(separation * np.sin(angle))


def test_pulls_have_the_weights_of_the_covariance():
    system, geometry = pair()
    state = fullbody.State(position=[[0, 0, 0], [0, 725.0, 1450.0]], velocity=np.zeros((2, 3)))
    run = system.integrate(state, 10.0, dense=True)
    sigma, rho = np.array([[0.01, 0.03], [0.02, 0.01]]), np.array([0.7, -0.3])
    offsets = np.array([[0.9, 1.0], [2.05, 2.0]]) * u.arcsec
    data = observing.Astrometry([1.0, 5.0] * u.h, *offsets, sigma * u.arcsec, rho, geometry=geometry)
    residuals = data.residuals(run).to_value("arcsec")
    expected = 0.0
    for (x, y), (a, b), r in zip(residuals, sigma, rho, strict=True):
        # The exponent of the bivariate normal distribution.
        expected += (x**2 / a**2 - 2 * r * x * y / (a * b) + y**2 / b**2) / (1 - r**2)
    assert data.chi2(run) == pytest.approx(expected, rel=1e-10)
    np.testing.assert_allclose(data.pulls(run)[:, 0], residuals[:, 0] / sigma[:, 0], rtol=1e-10)


@pytest.mark.filterwarnings("ignore:the offsets of Astrometry")
def test_rows_are_sorted_with_their_data_and_missing_ones_are_reported():
    _, geometry = pair()
    east = np.ma.masked_array([3.0, 1.0, 2.0, 4.0], mask=[False, False, True, False])
    with pytest.warns(InconsistentInput, match="2 of 4 rows of Astrometry .* row 2, 3"):
        data = observing.Astrometry(
            [9.0, 1.0, 2.0, 3.0] * u.h, east, [30.0, 10.0, 20.0, np.nan], [0.3, 0.1, 0.2, 0.4], geometry=geometry
        )
    assert data.times.to_value("h").tolist() == [1.0, 9.0]
    assert data.east.tolist() == [1.0, 3.0]
    assert data.sigma[:, 0].tolist() == [0.1, 0.3]
    assert data.rows.tolist() == [1, 0]
    assert data.missing == (2, 3)
    assert "2 left out" in repr(data)


@pytest.mark.parametrize("pandas_too", [False, True])
def test_tables_are_written_and_read_back(pandas_too):
    _, geometry = pair()
    dates = Time(["2022-09-26T01:02:03.123456789", "2022-09-27"], scale="tdb")
    geometry = observing.Geometry(dates, to_observer=[1.0, 0, 0] * u.au)
    rows = {"sigma": [[0.1, 0.2], [0.3, 0.4]] * u.mas, "correlation": [0.1, -0.2], "body": "B", "about": "A"}
    data = observing.Astrometry(dates, [1.0, 2.0] * u.mas, [3.0, 4.0] * u.mas, **rows, geometry=geometry)
    table = data.to_table()
    options = {"body": "B", "about": "A", "geometry": geometry}
    if pandas_too:
        table = Table(table).to_pandas()
        table.attrs["time_scale"] = "tdb"
        options["unit"] = u.mas
    back = observing.Astrometry.from_table(table, **options)
    np.testing.assert_allclose((back.times - data.times).to_value("s"), 0.0, atol=2e-9)
    for name in ("east", "north", "sigma"):
        np.testing.assert_allclose(getattr(back, name).to_value("mas"), getattr(data, name).to_value("mas"), rtol=1e-14)
    np.testing.assert_array_equal(back.correlation, data.correlation)
    refused("no column 'RA'", lambda: observing.Astrometry.from_table(table, columns={"east": "RA"}, **options))


def test_offsets_without_a_dimension_are_radians():
    rows = {"sigma": [2e-6] * u.one, "geometry": pair()[1]}
    data = observing.Astrometry([5.0] * u.h, [100.0] * u.percent, [3e-6] * u.rad, **rows)
    np.testing.assert_allclose([data.east.to_value(u.one)[0], data.north.to_value(u.one)[0]], [1.0, 3e-6], rtol=1e-15)
    np.testing.assert_allclose(data.covariance[0].to_value(u.one), np.diag([4e-12, 4e-12]), rtol=1e-14)


@pytest.mark.filterwarnings("ignore:the offsets of Astrometry")
def test_correlations_are_read_from_a_table_with_other_names_of_columns():
    row = {"time": [1.0], "east": [2.0], "north": [3.0], "sigma_east": [1.0], "sigma_north": [1.0]}
    table = pandas.DataFrame(row | {"correlation": [0.3]})
    geometry = observing.Geometry([0.0, 2.0], to_observer=[1.0, 0.0, 0.0])
    data = observing.Astrometry.from_table(table, columns={"times": "time"}, geometry=geometry)
    assert data.correlation.tolist() == [0.3]


def test_runs_without_states_at_the_times_are_refused():
    system, geometry = pair()
    state = fullbody.State(position=[[0, 0, 0], [0, 725.0, 1450.0]], velocity=np.zeros((2, 3)))
    data = observing.Astrometry([1.0, 5.0] * u.h, [0.0, 0.0], [0.0, 0.0], 1.0, geometry=geometry)
    refused("integrate with dense=True", lambda: data.predict(system.integrate(state, 10.0, output=0.3)))
    refused("does not cover", lambda: data.predict(system.integrate(state, 3.0, dense=True)))
    same = observing.Astrometry([1.0] * u.h, [0.0], [0.0], 1.0, about="B", geometry=geometry)
    refused("both B; expected two bodies", same.predict, system.integrate(state, 3.0, dense=True))
    # Samples at the times of emission do, and give the same.
    exact = system.integrate(state, 10.0, output=data.emission(system))
    np.testing.assert_allclose(data.predict(exact), data.predict(system.integrate(state, 10.0, dense=True)), rtol=1e-12)


@pytest.mark.parametrize("phase", [0.0, 1e-6, 20.0, 75.0, 150.0])
def test_centre_of_light_is_the_mean_over_the_surface(phase):
    axes, q = np.array([1.3, 1.0, 0.7]), np.array([0.6, 0.3, -0.5, 0.5])
    q /= np.linalg.norm(q)
    e = np.array([1.0, 0.2, -0.3])
    e /= np.linalg.norm(e)
    side = np.cross(e, [0.1, 0.4, 1.0])
    angle = np.radians(phase)
    s = np.cos(angle) * e + np.sin(angle) * side / np.linalg.norm(side)
    result = photocentre(axes, q[None], 1e8 * e[None], 2e8 * s[None])[0]
    # The sum over a mesh of equal areas on the unit sphere, mapped to the ellipsoid.
    count = 400_000
    z, lon = 1 - (2 * np.arange(count) + 1) / count, np.pi * (1 + 5**0.5) * np.arange(count)
    u = np.stack([np.sqrt(1 - z * z) * np.cos(lon), np.sqrt(1 - z * z) * np.sin(lon), z], axis=1)
    rotation = matrix(q)
    p, r = (u @ (rotation.T @ v / axes) for v in (e, s))
    light = np.where((p > 0) & (r > 0), p * r / np.where(p + r > 0, p + r, 1.0), 0.0)
    expected = rotation @ (light @ (u * axes) / light.sum())
    np.testing.assert_allclose(result, expected, atol=5e-5)


def test_astrometry_of_centres_of_light_and_its_derivatives():
    big = fullbody.Body(fullbody.Ellipsoid(500.0, 400.0, 300.0), mass=1.0, name="A")
    small = fullbody.Body(fullbody.Sphere(200.0), mass=1.0, name="B")
    system = fullbody.System([big, small], G=1e-30, units=True, frame="equatorial")
    geometry = observing.Geometry(
        [0.0, 10.0] * u.h, to_observer=[-1.0, 0, 0] * u.au, to_sun=[-1.0, 1.0, 0.0] * u.au, light_time=False
    )
    state = fullbody.State([[0, 0, 0], [0, 2000.0, 500.0]], np.zeros((2, 3)), spin=[[0, 0, 0.1], [0, 0, 0]])
    run = system.integrate(state, 10.0, dense=True)
    arguments = [5.0] * u.h, [0.0] * u.arcsec, [0.0] * u.arcsec, 1 * u.mas
    data = observing.Astrometry(*arguments, geometry=geometry, photocentre=True)
    reference = observing.Astrometry(*arguments, geometry=geometry)
    # The Sun is in the east: both centres of light lie east of the centres, the larger body's by more.
    shift = (data.predict(run) - reference.predict(run)).to_value("rad")[0] * 149597870.7
    assert -150.0 < shift[0] < -20.0
    row = arguments[0], [0.0] * u.rad, [0.0] * u.rad, 1.0 * u.rad
    radians = observing.Astrometry(*row, geometry=geometry, photocentre=True)
    exact, differences = by_start(radians, system, run(radians.emission(system)[0]), {"rotation": 1e-4})
    rotation = np.arange(24) % 12 // 3 == 2
    np.testing.assert_allclose(exact[:, rotation], differences[:, rotation], atol=1e-7 * 500 / 1.5e8)
    with pytest.raises(InvalidInput, match="has no Sun, which photocentre=True needs"):
        observing.Astrometry(*arguments, geometry=pair()[1], photocentre=True)
