"""Chords of stellar occultations: 40-digit arithmetic, outlines in closed form, stations on the Earth, refusals."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
import trimesh
from astropy.coordinates import EarthLocation, SkyCoord, get_body_barycentric, get_body_barycentric_posvel
from astropy.time import Time
from fullbody import observing
from fullbody.observing.star import Star
from scipy.optimize import brentq
from support import body_list, reference, refused
from support.meshes import box, torus

#: The direction to the star, and the speed at which the observer passes, in km/s.
STAR, SPEED, FAR = [0.0, 0.0, 1.0], 10.0, 1e8


def at_rest(*shapes, attitude=None, position=None, **options):
    """A run of bodies that hardly attract each other."""
    bodies = body_list(**{name: (shape, 1e3) for name, shape in zip("AB", shapes, strict=False)})
    system = fullbody.System(bodies, gravity="point", units=("km", "s", "kg"), **options)
    zeros = np.zeros((len(shapes), 3))
    state = fullbody.State(zeros if position is None else position, zeros, attitude=attitude)
    return system.integrate(state, 1200.0, dense=True)


def passing(first=400.0, last=600.0, **options):
    """An observer on the other side of the system from the star, who moves along x through x = 0 at 500 s."""
    positions = [[SPEED * (t - 500.0), 0.0, -FAR] for t in (first, last)]
    return observing.Geometry([first, last] * u.s, to_observer=positions * u.km, **options)


def times(chords):
    return [(chord.station, chord.body, chord.disappearance.value, chord.reappearance.value) for chord in chords]


def reference_run(case):
    shapes = (fullbody.Ellipsoid(*axes) for axes in case["semi_axes"])
    bodies = body_list(**dict(zip("AB", zip(shapes, case["mass"], strict=True), strict=True)))
    system = fullbody.System(bodies, G=case["G"], gravity="point", units=("km", "s", "kg"))
    state = fullbody.State(*(case[name] for name in ("position", "velocity", "attitude", "spin")))
    return system.integrate(state, case["geometry_times"][1], dense=True)


def reference_geometry(case):
    return observing.Geometry(case["geometry_times"] * u.s, to_observer=case["to_observer"] * u.km)


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
@pytest.mark.parametrize("index", range(4))
def test_chords_are_those_of_40_digit_arithmetic(index):
    case = reference("chords")["cases"][index]
    seen = sorted({chord["station"] for chord in case["chords"]})
    # The station 17 of the last case misses the body by one percent of its radius.
    stations = [*seen, *({0, 17} - {*seen})]
    positions = np.array(case["stations"])[stations] * u.km
    result = observing.occultation_chords(reference_run(case), case["star"], positions, reference_geometry(case))
    expected = [(c["station"], "AB"[c["body"]], c["disappearance"], c["reappearance"]) for c in case["chords"]]
    got = [(stations[station], *interval) for station, *interval in times(result)]
    assert [row[:2] for row in sorted(got)] == [row[:2] for row in sorted(expected)]
    for row, wanted in zip(sorted(got), sorted(expected), strict=True):
        assert row[2:] == pytest.approx(wanted[2:], abs=1e-7, rel=0)
    assert len(result) + len(result.misses) == 2 * len(stations)


def test_a_tilted_box_is_hidden_behind_for_the_width_of_its_outline():
    # A cube that is turned by 45 degrees about its z-axis, and is seen along z, is a square on its corner.
    attitude = [[np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8)]]
    run = at_rest(box(2.0, 2.0, 2.0), attitude=attitude)
    heights = np.array([0.3, -1.0, 1.4])
    stations = np.stack([0 * heights, heights, 0 * heights], axis=1) * u.km
    result = times(observing.occultation_chords(run, STAR, stations, passing()))
    half = (np.sqrt(2.0) - np.abs(heights)) / SPEED
    for (station, _, begin, end), wanted in zip(result, half, strict=True):
        assert (begin, end) == pytest.approx((500.0 - wanted, 500.0 + wanted), abs=1e-9), station


def test_a_ring_hides_the_star_twice_from_a_station_on_its_axis():
    count, (radius, tube) = 12, (5.0, 1.0)
    # The path crosses the middles of the sides of the outlines, which are regular polygons.
    half_turn = np.pi / count / 2.0
    run = at_rest(torus(radius, tube, count=count), attitude=[[np.cos(half_turn), 0.0, 0.0, np.sin(half_turn)]])
    result = times(observing.occultation_chords(run, STAR, [[0.0, 0.0, 0.0]] * u.km, passing()))
    inner, outer = ((radius + sign * tube) * np.cos(np.pi / count) / SPEED for sign in (-1.0, 1.0))
    assert [row[2:] for row in result] == [
        pytest.approx((500.0 - outer, 500.0 - inner), abs=1e-9),
        pytest.approx((500.0 + inner, 500.0 + outer), abs=1e-9),
    ]


def test_edges_within_the_outline_of_a_rough_body_end_no_chord():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    sizes = np.random.default_rng(1).uniform(0.85, 1.1, (len(mesh.vertices), 1))
    run = at_rest(fullbody.Polyhedron(40.0 * sizes * mesh.vertices * u.km, mesh.faces))
    heights = np.array([-31.0, -12.5, 3.3, 28.7])
    stations = np.stack([0 * heights, heights, 0 * heights], axis=1) * u.km
    chords = observing.occultation_chords(run, STAR, stations, passing())
    # A row at a height is within a triangle from one of its sides to another one, and within the body in all of these.
    shape = run.system.context.bodies[0].parts[0][0]
    corners = shape.vertices[shape.faces][:, :, :2]
    expected = []
    for station, height in enumerate(heights):
        rows = []
        for triangle in corners:
            sides = [(triangle[k], triangle[k - 1]) for k in range(3)]
            crossed = [(a, b) for a, b in sides if (a[1] < height) != (b[1] < height)]
            cut = [a[0] + (b[0] - a[0]) * (height - a[1]) / (b[1] - a[1]) for a, b in crossed]
            rows += [(min(cut), max(cut))] if cut else []
        joined = []
        for low, high in sorted(rows):
            if joined and low <= joined[-1][1] + 1e-9:
                joined[-1][1] = max(joined[-1][1], high)
            else:
                joined.append([low, high])
        expected += [(station, "A", 500.0 + low / SPEED, 500.0 + high / SPEED) for low, high in joined]
    assert [row[:2] for row in times(chords)] == [row[:2] for row in expected]
    np.testing.assert_allclose([row[2:] for row in times(chords)], [row[2:] for row in expected], atol=1e-9)


def test_a_composite_hides_what_one_of_its_parts_hides():
    dumb_bell = fullbody.Composite(
        [fullbody.Part(fullbody.Sphere(1.0), mass=500.0, position=(x, 0.0, 0.0)) for x in (-3.0, 3.0)]
    )
    body = fullbody.Body(dumb_bell, name="pair")
    system = fullbody.System([body], units=("km", "s", "kg"))
    run = system.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3))), 600.0, dense=True)
    result = times(observing.occultation_chords(run, STAR, [[0.0, 0.6, 0.0]] * u.km, passing()))
    assert [row[2:] for row in result] == [
        pytest.approx((500.0 + (x - 0.8) / SPEED, 500.0 + (x + 0.8) / SPEED), abs=1e-9) for x in (-3.0, 3.0)
    ]


def test_a_graze_of_a_micrometre_is_found_and_a_miss_by_it_is_none():
    run = at_rest(fullbody.Sphere(50.0))
    for deep, count in ((1e-9, 1), (-1e-9, 0)):
        stations = [[0.0, 50.0 * (1.0 - deep), 0.0]] * u.km
        result = observing.occultation_chords(run, STAR, stations, passing())
        assert len(result) == count
        if count:
            assert result[0].duration.value == pytest.approx(2 * 50.0 * np.sqrt(2 * deep) / SPEED, rel=1e-3)
        else:
            assert result.misses[0].distance.value == pytest.approx(50.0 * (1 + 1e-9), rel=1e-12)
            assert result.misses[0].time.value == pytest.approx(500.0, abs=1e-3)


@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_a_body_hides_the_star_from_where_it_was_when_the_light_passed():
    # The body moves across at 1 km/s, and the light takes FAR / c.
    bodies = body_list(A=(fullbody.Sphere(5.0), 1.0), B=(fullbody.PointMass(), 1e12))
    system = fullbody.System(bodies, G=1e-40, units=("km", "s", "kg"))
    state = fullbody.State([[0.0, 0.0, 0.0], [0.0, 1e5, 0.0]], [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    run = system.integrate(state, 700.0, dense=True)
    stations = [[0.0, -1e5, 0.0]] * u.km
    chord = observing.occultation_chords(run, STAR, stations, passing(100.0, 700.0))[0]
    # The observer is at SPEED (t - 500), and the body where it was at t - delay.
    middle = (SPEED * 500.0 - FAR / 299792.458) / (SPEED - 1.0)
    assert chord.duration.value == pytest.approx(2 * 5.0 / (SPEED - 1.0), rel=1e-5)
    assert chord.disappearance.value + 0.5 * chord.duration.value == pytest.approx(middle, abs=1e-4)


@pytest.fixture(scope="module")
def asteroid():
    """An asteroid that passes before a star: its path, the star, and the geometry from the centre of the Earth.

    Its motion is even with respect to the barycentre of the solar system, 18 km/s, and it comes near the line from the
    Earth to the star within the span.
    """
    start = Time("2024-03-01T02:00:00", scale="utc")
    star = SkyCoord(160.0 * u.deg, 15.0 * u.deg)
    direction = np.asarray(star.cartesian.xyz.value)
    earth = get_body_barycentric("earth", start).xyz.to_value("km")
    velocity = np.array([-9.0, 12.0, 6.0])
    middle = earth + 2e8 * direction - velocity * 2e8 / 299792.458 * -1.0 + np.array([300.0, 800.0, -200.0])

    def body(seconds):
        return middle + np.multiply.outer(seconds, velocity)

    def earth_at(seconds):
        return get_body_barycentric("earth", start + seconds * u.s).xyz.to_value("km").T

    def emitted(position, seconds):
        result = seconds
        for _ in range(8):
            result = seconds - np.linalg.norm(position - body(result), axis=-1) / 299792.458
        return result

    rows = np.linspace(-900.0, 900.0, 61)
    positions = earth_at(rows)
    geometry = observing.Geometry(
        start + rows * u.s, to_observer=(positions - body(emitted(positions, rows))) * u.km, frame="equatorial"
    )
    return start, star, direction, body, earth_at, emitted, geometry


def test_stations_on_the_earth_see_what_the_frame_of_the_solar_system_has(asteroid):
    start, star, direction, body, earth_at, emitted, geometry = asteroid
    radius = 3000.0
    options = {"units": ("km", "s", "kg"), "epoch": start, "frame": "equatorial"}
    system = fullbody.System(body_list(A=(fullbody.Sphere(radius), 1e15)), **options)
    # The light takes 670 s.
    run = system.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)), time=-2000.0), 500.0, dense=True)
    stations = EarthLocation.from_geodetic(
        [-30.0, 10.0, 60.0] * u.deg, [10.0, 50.0, -35.0] * u.deg, [0.0, 300.0, 2e3] * u.m
    )
    result = observing.occultation_chords(run, star, stations, geometry)
    assert {chord.station for chord in result} | {miss.station for miss in result.misses} == {0, 1, 2}
    assert len(result) >= 2

    def outside(t, station):
        seconds = np.array([t])
        position = earth_at(seconds)[0] + stations[station].get_gcrs_posvel(start + t * u.s)[0].xyz.to_value("km")
        vector = position - body(emitted(position, t))
        return np.linalg.norm(vector - (vector @ direction) * direction) - radius

    for chord in result:
        for time in (chord.disappearance.value, chord.reappearance.value):
            exact = brentq(outside, time - 1.0, time + 1.0, args=(chord.station,), xtol=1e-9)
            assert time == pytest.approx(exact, abs=2e-6)


def test_a_star_has_its_proper_motion_and_its_parallax():
    motion = {"pm_ra_cosdec": 900.0 * u.mas / u.yr, "pm_dec": -400.0 * u.mas / u.yr}
    motion |= {"radial_velocity": 20.0 * u.km / u.s, "obstime": Time("J2016")}
    star = SkyCoord(ra=50.0 * u.deg, dec=-20.0 * u.deg, distance=4.0 * u.pc, **motion)
    when = Time("2026-05-01", scale="tdb")
    options = {"units": ("km", "s", "kg"), "epoch": when, "frame": "equatorial"}
    system = fullbody.System(body_list((fullbody.Sphere(1.0), 1e3)), **options)
    geometry = passing(frame="equatorial")
    result = Star(star, geometry).directions(system, np.array([0.0]))[0]
    displaced = star.apply_space_motion(when).icrs.cartesian.xyz.to_value("km")
    exact = displaced - get_body_barycentric_posvel("earth", when)[0].xyz.to_value("km")
    exact /= np.linalg.norm(exact)
    # Half a milliarcsecond remains of the light time of the star's own motion.
    assert np.linalg.norm(result - exact) < 3e-9
    still = Star(SkyCoord(50.0 * u.deg, -20.0 * u.deg), geometry).directions(system, np.array([0.0]))[0]
    assert np.linalg.norm(still - exact) > 4e-5


def test_the_span_limits_the_search_and_cuts_chords():
    run = at_rest(fullbody.Sphere(50.0))
    station = [[0.0, 0.0, 0.0]] * u.km
    assert observing.occultation_chords(run, STAR, station, passing(), span=(400.0, 450.0) * u.s) == []
    cut = observing.occultation_chords(run, STAR, station, passing(), span=(400.0, 500.0) * u.s)[0]
    assert cut.disappearance.value == pytest.approx(495.0)
    assert cut.reappearance is None
    assert cut.duration is None


def test_points_hide_nothing_and_a_window_without_events_is_empty():
    run = at_rest(fullbody.PointMass(), fullbody.Sphere(1.0), position=[[0.0, 0.0, 0.0], [0.0, 900.0, 0.0]])
    assert observing.occultation_chords(run, STAR, [[0.0, 0.0, 0.0]] * u.km, passing()) == []


def test_tables_have_dates_where_the_system_has_an_epoch():
    run = at_rest(fullbody.Sphere(50.0), epoch="2024-01-01T00:00:00 UTC")
    table = observing.occultation_chords(run, STAR, [[0.0, 0.0, 0.0]] * u.km, passing()).to_table()
    # The middle is 500 s after the epoch.
    assert abs((table["disappearance"][0] - Time("2024-01-01T00:08:15", scale="utc")).to_value("s")) < 1e-6
    assert float(table["duration"][0].unmasked.to_value("s")) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"star": [0.0, 0.0, -1.0]}, "star is on the observer's side of the system"),
        ({"star": (1.0, 0.2)}, r"star is \(1.0, 0.2\), angles without a unit"),
        ({"star": "Vega"}, "star is 'Vega'"),
        ({"star": SkyCoord([1.0, 2.0] * u.deg, [0.0, 0.0] * u.deg)}, "star has 2 positions"),
        ({"star": (10.0 * u.deg, 20.0 * u.deg)}, "needs the axes of the system, which are not known"),
        (
            {"star": SkyCoord(1 * u.deg, 1 * u.deg, pm_ra_cosdec=1 * u.mas / u.yr, pm_dec=0 * u.mas / u.yr)},
            "without its date",
        ),
        ({"stations": [[0.0, 0.0]] * u.km}, r"stations has shape \(1, 2\)"),
        ({"stations": np.zeros((1, 2, 3)) * u.km}, "vectors at two times"),
        ({"stations": [[np.nan, 0.0, 0.0]] * u.km}, "stations is"),
        ({"stations": EarthLocation.from_geocentric(9e6, 0.0, 0.0, unit="m")}, "station 0 is 9000 km from the centre"),
        ({"span": (0.0, 500.0) * u.s}, "the run and the geometry cover the times"),
        ({"span": (500.0, 450.0) * u.s}, "expected the first time first"),
        ({"span": 5.0 * u.s}, "expected the first and the last time"),
        ({"geometry": None}, "geometry is None"),
        (
            {"geometry": observing.Geometry([400.0, 600.0] * u.s, to_observer=[[0, 0, -9.0], [0, 0.01, -9.0]] * u.km)},
            "inside A",
        ),
    ],
)
def test_bad_input_is_refused_by_name(options, message):
    run = at_rest(fullbody.Sphere(50.0))
    arguments = {"star": STAR, "stations": [[0.0, 0.0, 0.0]] * u.km, "geometry": passing()} | options
    refused(message, lambda: observing.occultation_chords(run, **arguments))


def test_a_run_without_its_continuous_solution_is_refused():
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)], units=("km", "s", "kg"))
    run = system.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3))), 600.0)
    refused("dense=True", lambda: observing.occultation_chords(run, STAR, [[0.0, 0.0, 0.0]] * u.km, passing()))
