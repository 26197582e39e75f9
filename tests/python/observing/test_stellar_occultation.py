"""Chords of stellar occultations as data: predictions, offset, derivatives, misses, clocks, files, what is refused."""

import pickle

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.coordinates import EarthLocation, SkyCoord
from astropy.time import Time
from fullbody import observing
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem
from scipy.optimize import minimize_scalar
from support import reference, refused
from support.meshes import box, icosphere
from test_chords import FAR, SPEED, STAR, passing, reference_geometry, reference_run

pytestmark = pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
NAN = np.nan


def resting(shape, attitude=None, spin=None, **options):
    """A body at rest, as a system and its start."""
    system = fullbody.System([fullbody.Body(shape, mass=1e3, name="A")], units=("km", "s", "kg"), **options)
    return system, fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)), attitude=attitude, spin=spin)


def run_of(shape, **options):
    system, state = resting(shape, **options)
    return system.integrate(state, 1000.0, dense=True)


def observed(begin, end, heights=(0.0,), sigma=0.1, frame="equatorial", **options):
    """Stations at heights along y, with times of disappearance and reappearance."""
    heights = np.asarray(heights, dtype=float)
    options = {"stations": np.stack([0 * heights, heights, 0 * heights], axis=1) * u.km, "star": STAR} | options
    options = {"geometry": passing(frame=frame), "offset": 0.0} | options
    chords = {"disappearance": np.asarray(begin) * u.s, "reappearance": np.asarray(end) * u.s}
    return observing.StellarOccultation(**chords, sigma=sigma * u.s, **options)


@pytest.mark.parametrize("values", [True, False])
@pytest.mark.parametrize("index", range(4))
def test_predictions_are_the_times_of_forty_digits(index, values):
    case = reference("chords")["cases"][index]
    chords = case["chords"]
    data = observing.StellarOccultation(
        star=case["star"],
        stations=np.array([case["stations"][c["station"]] for c in chords]) * u.km,
        disappearance=[c["disappearance"] for c in chords] * u.s,
        reappearance=[c["reappearance"] for c in chords] * u.s,
        sigma=0.01 * u.s,
        geometry=reference_geometry(case),
        body=["AB"[c["body"]] for c in chords] if values else None,
        offset=0.0,
    )
    run = reference_run(case)
    assert abs(data.residuals(run).to_value("s")).max() < 1e-7
    assert data.identified(run) == tuple("AB"[chords[station]["body"]] for station in data.station)


def tilted(heights, angle=0.3):
    """A star, stations and a geometry with the star at a declination of 90 degrees minus an angle."""
    star = np.array([np.sin(angle), 0.0, np.cos(angle)])
    east, north = np.array([0.0, 1.0, 0.0]), np.array([-np.cos(angle), 0.0, np.sin(angle)])
    ends = np.array([400.0, 600.0])
    positions = -FAR * star + np.outer(SPEED * (ends - 500.0), east)
    geometry = observing.Geometry(ends * u.s, to_observer=positions * u.km, frame="equatorial")
    return star, np.outer(heights, north) * u.km, geometry, east, north


HEIGHTS = np.array([-30.0, -10.0, 5.0, 25.0])


def simulated(shape, heights=HEIGHTS, displaced=(0.0, 0.0), attitude=None, spin=None, angle=0.3, **options):
    """Data of chords of a body that is displaced in the sky by lengths to the east and to the north, and its run."""
    star, stations, geometry, east, north = tilted(heights, angle)
    run = run_of(shape, attitude=attitude, spin=spin, frame="equatorial")
    # The stations are moved instead of the body.
    moved = stations - (displaced[0] * east + displaced[1] * north) * u.km
    chords = observing.occultation_chords(run, star, moved, geometry)
    assert [chord.station for chord in chords] == list(range(len(heights)))
    data = observing.StellarOccultation(
        star=star,
        stations=stations,
        disappearance=[chord.disappearance for chord in chords],
        reappearance=[chord.reappearance for chord in chords],
        sigma=0.05 * u.s,
        geometry=geometry,
        **options,
    )
    return data, run


@pytest.mark.parametrize(
    "shape", [fullbody.Ellipsoid(60.0, 45.0, 40.0), box(70.0, 60.0, 90.0)], ids=["ellipsoid", "box"]
)
def test_the_offset_of_ephemeris_and_star_is_found(shape):
    data, run = simulated(shape, displaced=(7.0, -4.0), attitude=[[0.8, 0.1, 0.3, 0.4]])
    offset = data.linear_values(run)
    mas = u.rad.to("mas") / FAR
    assert offset["offset east"].to_value("mas") == pytest.approx(7.0 * mas, rel=1e-6)
    assert offset["offset north"].to_value("mas") == pytest.approx(-4.0 * mas, rel=1e-6)
    assert abs(data.residuals(run).to_value("s")).max() < 1e-6
    assert data.chi2(run) < 1e-9
    fixed = {name: value * 0.0 for name, value in offset.items()}
    assert abs(data.residuals(run, linear=fixed).to_value("s")).max() > 0.3


def test_the_free_error_of_a_clock_is_found_beside_the_offset():
    data, run = simulated(fullbody.Ellipsoid(60.0, 45.0, 40.0), clock=[2])
    late = np.where(np.arange(4) == 2, 1.7, 0.0) * u.s
    begin, end = (data.times[data.sign == sign][np.argsort(data.station[data.sign == sign])] for sign in (-1, 1))
    star, stations, geometry, _, _ = tilted(HEIGHTS)
    options = {"star": star, "stations": stations, "geometry": geometry, "sigma": 0.05 * u.s}
    chords = {"disappearance": begin + late, "reappearance": end + late}
    shifted = observing.StellarOccultation(**options, **chords, clock=[2])
    result = shifted.linear_values(run)
    assert result["clock of station 2"].to_value("s") == pytest.approx(1.7, abs=1e-6)
    assert result["offset east"].to_value("mas") == pytest.approx(0.0, abs=1e-4)
    assert observing.StellarOccultation(**options, **chords).chi2(run) > 100.0


@pytest.mark.parametrize("clock", [None, [2]])
def test_derivatives_of_pulls_are_their_differences_with_the_offset_free(clock):
    rng = np.random.default_rng(2)
    exact, _ = simulated(fullbody.Ellipsoid(60.0, 45.0, 40.0), attitude=[[0.8, 0.1, 0.3, 0.4]], spin=[[0, 0, 4e-4]])
    star, stations, geometry, _, _ = tilted(HEIGHTS)
    sides = [exact.times[exact.sign == s][np.argsort(exact.station[exact.sign == s])] for s in (-1, 1)]
    begin, end = (side + rng.normal(0.0, 0.05, 4) * u.s for side in sides)
    data = observing.StellarOccultation(
        star=star,
        stations=stations,
        disappearance=begin,
        reappearance=end,
        sigma=0.05 * u.s,
        geometry=geometry,
        clock=clock,
    )

    def system_and_state(a=60.0, spin=4e-4):
        shape = fullbody.Ellipsoid(a, 45.0, 40.0)
        return resting(shape, attitude=[[0.8, 0.1, 0.3, 0.4]], spin=[[0, 0, spin]], frame="equatorial")

    def pulls(**values):
        system, state = system_and_state(**values)
        emission = data.emission(system)
        return data.pulls(system.integrate(state, emission[-1], output=emission))[:, 0]

    system, state = system_and_state()
    emission = data.emission(system)
    run = system.integrate(state, emission[-1], output=emission, derivatives=["semi-axis a of A"])
    result = data.derivatives(run)
    cases = {"a": (result.by_parameter["semi-axis a of A"][:, 0], 0.05), "spin": (result.start[:, 0, 11], 5e-6)}
    for name, (derivative, step) in cases.items():
        middle = {"a": 60.0, "spin": 4e-4}[name]
        coarse, fine = ((pulls(**{name: middle + h}) - pulls(**{name: middle - h})) / (2 * h) for h in (2 * step, step))
        expected = (4.0 * fine - coarse) / 3.0
        assert abs(derivative - expected).max() < 2e-5 * abs(expected).max(), name


def test_derivatives_with_respect_to_a_polyhedron_s_pose_are_their_differences():
    data, run = simulated(box(70.0, 60.0, 90.0), attitude=[[0.8, 0.1, 0.3, 0.4]], offset=0.0)
    system, emission = run.system, data.emission(run.system)
    states = {name: np.array(value) for name, value in run.states(emission).items()}
    result, _ = data._partials(system, states)
    from fullbody.base import rotations

    for axis in range(3):
        values = []
        for sign in (1.0, -1.0):
            rotated = rotations.products(states["attitude"], rotations.of_vectors(sign * 1e-5 * np.eye(3)[axis]))
            values.append(data._model(system, states | {"attitude": rotated})[:, 0])
        expected = (values[0] - values[1]) / 2e-5
        np.testing.assert_allclose(result[:, 0, 6 + axis], expected, atol=1e-5 * abs(expected).max())


def test_a_fine_polyhedron_has_the_contacts_of_its_sphere():
    data, _ = simulated(fullbody.Sphere(50.0), offset=0.0)
    run = run_of(icosphere(3, (50.0, 50.0, 50.0)), frame="equatorial")
    # The corners are on the sphere, and the sides at most half a percent within it.
    residuals = data.residuals(run).to_value("s") * data.sign
    assert (residuals > -1e-9).all()
    assert residuals.max() < 0.1


def test_a_fit_finds_radius_and_offset():
    data, _ = simulated(fullbody.Sphere(50.0), displaced=(3.0, 2.0))

    def setup(radius):
        return resting(fullbody.Sphere(radius), frame="equatorial")

    fit = fullbody.fit(setup, {"radius": 37.0}, [data])
    assert fit.values["radius"] == pytest.approx(50.0, abs=1e-5)
    assert fit.chi2 < 1e-8
    assert {"offset east", "offset north"} <= set(fit.values)


def test_a_fit_finds_the_size_of_a_polyhedron_beside_the_offset():
    rng = np.random.default_rng(3)
    sides = [70.0, 60.0, 90.0]
    exact, _ = simulated(box(*sides), attitude=[[0.8, 0.1, 0.3, 0.4]], displaced=(7.0, -4.0))
    star, stations, geometry, _, _ = tilted(HEIGHTS)
    ends = [exact.times[exact.sign == s][np.argsort(exact.station[exact.sign == s])] for s in (-1, 1)]
    begin, end = (side + rng.normal(0.0, 0.2, 4) * u.s for side in ends)
    options = {"star": star, "stations": stations, "sigma": 0.05 * u.s, "geometry": geometry}
    data = observing.StellarOccultation(disappearance=begin, reappearance=end, **options)

    def setup(size):
        shape = box(*(size * side for side in sides))
        return resting(shape, attitude=[[0.8, 0.1, 0.3, 0.4]], frame="equatorial")

    def chi2(size):
        system, state = setup(size)
        emission = data.emission(system)
        return data.chi2(system.integrate(state, emission[-1], output=emission))

    fit = fullbody.fit(setup, {"size": 0.93}, [data])
    least = minimize_scalar(chi2, bracket=(0.97, 1.0, 1.03), options={"xtol": 1e-9})
    assert fit.values["size"] == pytest.approx(least.x, abs=1e-3 * fit.sigma["size"])
    assert fit.chi2 == pytest.approx(least.fun, rel=1e-9)
    assert abs(fit.values["size"] - 1.0) < 4.0 * (fit.chi2 / fit.dof) ** 0.5 * fit.sigma["size"]


def test_a_grazing_chord_leaves_the_derivative_by_the_size_of_a_polyhedron_near_its_difference():
    # Where a chord grazes corners, the offset of the least chi2 jumps by more than small changes of the size move it.
    ball = icosphere(4)
    vertices = np.asarray(ball.vertices) * [60.0, 45.0, 40.0]
    heights = np.array([-30.0, -10.0, 5.0, 25.0, 49.48])
    exact, _ = simulated(fullbody.Polyhedron(vertices, ball.faces), heights, attitude=[[0.8, 0.1, 0.3, 0.4]])
    star, stations, geometry, _, _ = tilted(heights)
    rng = np.random.default_rng(1)
    ends = [exact.times[exact.sign == s][np.argsort(exact.station[exact.sign == s])] for s in (-1, 1)]
    begin, end = (side + rng.normal(0.0, 0.5, 5) * u.s for side in ends)
    options = {"star": star, "stations": stations, "sigma": 0.05 * u.s, "geometry": geometry}
    data = observing.StellarOccultation(disappearance=begin, reappearance=end, **options)

    def setup(size):
        shape = fullbody.Polyhedron(size * vertices, ball.faces)
        return resting(shape, attitude=[[0.8, 0.1, 0.3, 0.4]], frame="equatorial")

    def pulls(size):
        system, state = setup(size)
        emission = data.emission(system)
        return data.pulls(system.integrate(state, emission[-1], output=emission))[:, 0]

    expected = (pulls(1.001) - pulls(0.999)) / 0.002
    problem = Problem(setup, Parameters({"size": 1.0}), [data], None)
    computed = problem.jacobian(problem.point(np.array([1.0]), differentiated=True)).rows[:, 0]
    assert abs(computed - expected).max() < abs(expected).max()


def test_a_companion_without_a_surface_leaves_derivatives_exact():
    exact, _ = simulated(box(70.0, 60.0, 90.0), attitude=[[0.8, 0.1, 0.3, 0.4]])
    star, stations, geometry, _, _ = tilted(HEIGHTS)
    begin, end = (exact.times[exact.sign == s][np.argsort(exact.station[exact.sign == s])] for s in (-1, 1))
    options = {"star": star, "stations": stations, "sigma": 0.05 * u.s, "geometry": geometry}
    data = observing.StellarOccultation(disappearance=begin, reappearance=end, body="A", **options)
    C, S = np.diag([1.0, 0.0, 0.0]), np.zeros((3, 3))
    field = fullbody.StokesCoefficients(C, S, reference_radius=1.0, inertia=[0.4] * 3, radius=1.0)

    def setup(size):
        bodies = [fullbody.Body(box(*(size * np.array([70.0, 60.0, 90.0]))), mass=1e3, name="A")]
        bodies.append(fullbody.Body(field, mass=1e-9, name="B"))
        system = fullbody.System(bodies, units=("km", "s", "kg"), frame="equatorial")
        attitude = [[0.8, 0.1, 0.3, 0.4], [1.0, 0.0, 0.0, 0.0]]
        return system, fullbody.State([[0.0] * 3, [0.0, 9e3, 0.0]], np.zeros((2, 3)), attitude=attitude)

    problem = Problem(setup, Parameters({"size": 1.0}), [data], None)
    jacobian = problem.jacobian(problem.point(np.array([1.0]), differentiated=True))
    assert jacobian.differenced_observations == {}


def test_a_body_that_misses_a_station_has_predictions_that_lead_back():
    # A chord was seen at a height of 45, where the predicted sphere is too small by up to 10.
    half = 5.0
    data = observed([500.0 - half], [500.0 + half], heights=[45.0])
    for radius in (70.0, 46.0, 45.0, 44.0, 35.0):
        square = (radius**2 - 45.0**2) / SPEED**2
        least = 0.25 * half
        wanted = np.sqrt(square) if square >= least**2 else 0.5 * (least + square / least)
        result = data.residuals(run_of(fullbody.Sphere(radius), frame="equatorial")).to_value("s")
        assert result == pytest.approx([wanted - half, half - wanted], abs=1e-6)


def test_a_miss_is_one_within_the_interval_that_the_station_watched():
    run = run_of(fullbody.Sphere(50.0), frame="equatorial")
    watched = ([NAN, 490.0, 490.0, 560.0] * u.s, [NAN, 520.0, 520.0, 580.0] * u.s)
    nothing = [495.0, NAN, NAN, NAN], [505.0, NAN, NAN, NAN]
    data = observed(*nothing, heights=[0.0, 40.0, 60.0, 40.0], watched=watched)
    assert data.sign.tolist() == [-1.0, 1.0, 0.0, 0.0, 0.0] or set(data.sign) == {-1.0, 0.0, 1.0}
    by_station = {k: data.residuals(run).to_value("s")[(data.station == k) & (data.sign == 0.0)] for k in (1, 2, 3)}
    # The line of sight is ten within the limb, and passes at the speed of 10.
    assert by_station[1] == pytest.approx([-1.0], abs=1e-6)
    assert by_station[2].tolist() == by_station[3].tolist() == [0.0]


def test_one_contact_of_a_chord_counts_alone():
    run = run_of(fullbody.Sphere(50.0), frame="equatorial")
    data = observed([495.2, NAN], [NAN, 505.3], heights=[0.0, 0.0])
    assert data.residuals(run).to_value("s") == pytest.approx([0.2, 0.3], abs=1e-9)
    assert data.predict(run).to_value("s") == pytest.approx([495.0, 505.0], abs=1e-9)


def test_stations_at_two_times_and_in_the_plane_of_the_sky_are_those_that_move():
    run = run_of(fullbody.Sphere(50.0), frame="equatorial")
    star, _, geometry, east, north = tilted([0.0])
    # The station moves to the west at 2 km/s, so that the line of sight passes at 8 km/s.
    begin, end = (500.0 + sign * 50.0 / 8.0 for sign in (-1.0, 1.0))
    positions = np.array([[-2.0 * (t - 500.0), 0.0] for t in (begin, end)])
    options = {"star": star, "geometry": geometry, "sigma": 0.1 * u.s, "offset": 0.0}
    chord = {"disappearance": [begin] * u.s, "reappearance": [end] * u.s}
    for stations in (positions[None], (positions @ np.array([east, north]))[None]):
        data = observing.StellarOccultation(stations=stations * u.km, **chord, **options)
        assert abs(data.residuals(run).to_value("s")).max() < 1e-9


def test_dates_and_numbers_give_the_same_residuals():
    shape = fullbody.Sphere(50.0)
    run = run_of(shape, frame="equatorial", epoch="2024-01-01T00:00:00 TDB")
    epoch = Time("2024-01-01T00:00:00", scale="tdb")
    star, stations, _, east, _ = tilted(HEIGHTS)
    ends = np.array([400.0, 600.0])
    path = (-FAR * star + np.outer(SPEED * (ends - 500.0), east)) * u.km
    begin, end = [497.0] * 4 * u.s, [503.0] * 4 * u.s
    results = []
    for times, first, last in ((ends * u.s, begin, end), (epoch + ends * u.s, epoch + begin, (epoch + end).utc)):
        geometry = observing.Geometry(times, to_observer=path, frame="equatorial")
        options = {"star": star, "stations": stations, "geometry": geometry, "sigma": 0.1 * u.s}
        data = observing.StellarOccultation(disappearance=first, reappearance=last, **options)
        results.append(data.residuals(run).to_value("s"))
    # The scales of time differ by microseconds from one conversion to another.
    np.testing.assert_allclose(results[0], results[1], atol=1e-5)
    masked = (epoch + begin).copy()
    masked[1] = np.ma.masked
    data = observing.StellarOccultation(disappearance=masked, reappearance=epoch + end, **options)
    assert len(data) == 7
    assert isinstance(data.predict(run), Time)


def test_data_that_were_compared_with_a_run_can_be_pickled():
    data, run = simulated(fullbody.Sphere(50.0), displaced=(3.0, 2.0))
    wanted = data.residuals(run)
    assert np.array_equal(pickle.loads(pickle.dumps(data)).residuals(run), wanted)


def test_a_jitter_widens_the_errors():
    data, run = simulated(fullbody.Sphere(50.0))
    wider = data.with_jitter(0.12 * u.s)
    assert wider.sigma.to_value("s") == pytest.approx([0.13] * 8)
    assert data.sigma.to_value("s") == pytest.approx([0.05] * 8)
    assert wider.chi2(run) < 1e-9


GIVEN = {"star": STAR, "stations": [[0.0, 0.0, 0.0]] * u.km, "sigma": 0.1 * u.s, "offset": 0.0}
CHORD = {"disappearance": [495.0] * u.s, "reappearance": [505.0] * u.s}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"reappearance": [494.0] * u.s},
            "reappearance of station 0 is 494.0 s, not after its disappearance at 495.0 s",
        ),
        ({"reappearance": [505.0, 506.0] * u.s}, r"reappearance has shape \(2,\); expected \(1,\)"),
        ({"disappearance": [NAN] * u.s, "reappearance": [NAN] * u.s}, "no time that is not NaN"),
        ({"sigma": 0.1}, "only one of the times and sigma has a unit"),
        ({"sigma": 0.0 * u.s}, "sigma of StellarOccultation has the value 0.0"),
        ({"sigma": [0.1, 0.1, 0.1] * u.s}, r"sigma has shape \(3,\)"),
        ({"sigma": 0.1 * u.km}, "sigma of StellarOccultation has the unit km"),
        ({"offset": (1.0, 2.0)}, "offset is .* angles without a unit"),
        ({"offset": "fixed"}, "offset is 'fixed'"),
        ({"clock": [3]}, "clock has 3"),
        ({"body": ["A", "B"]}, "body has 2 names"),
        ({"geometry": 5}, "geometry of StellarOccultation is 5"),
        ({"star": (1.0, 2.0)}, "star is .* angles without a unit"),
        ({"watched": ([500.0] * u.s, [400.0] * u.s)}, "watched of station 0 ends before it begins"),
        ({"disappearance": Time(["2024-01-01"])}, "times of the same kind"),
    ],
)
def test_bad_input_is_refused_by_name(options, message):
    arguments = GIVEN | CHORD | {"geometry": passing()} | options
    refused(message, lambda: observing.StellarOccultation(**arguments))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"body": "C"}, "body of StellarOccultation is 'C'"),
        ({"star": [0.0, 0.0, -1.0]}, "star is on the observer's side of the system at"),
        ({"star": SkyCoord(1 * u.deg, 1 * u.deg)}, "needs the axes of the system, which are not known"),
        (
            {"geometry": observing.Geometry([400.0, 600.0] * u.s, to_observer=[0.0, 0.0, -FAR] * u.km)},
            "do not move past",
        ),
        (
            {"geometry": observing.Geometry([400.0, 600.0] * u.s, to_observer=[[0, 0, -9.0], [0, 0.01, -9.0]] * u.km)},
            "the observer of the geometry is inside A",
        ),
    ],
)
def test_what_only_a_run_shows_is_refused_by_name(options, message):
    data = observing.StellarOccultation(**(GIVEN | CHORD | {"geometry": passing()} | options))
    refused(message, lambda: data.residuals(run_of(fullbody.Sphere(50.0))))


def test_an_offset_that_one_contact_leaves_open_is_refused():
    star, _, geometry, _, _ = tilted([0.0])
    alone = {"disappearance": [495.0] * u.s, "reappearance": [NAN] * u.s, "offset": "free"}
    data = observing.StellarOccultation(**(GIVEN | alone | {"geometry": geometry, "star": star}))
    refused("offset .* undetermined", lambda: data.residuals(run_of(fullbody.Sphere(50.0), frame="equatorial")))


@pytest.fixture
def event():
    """An event that three stations on the Earth saw by dates, a satellite among them, and one did not."""
    start = Time("2024-03-01T23:59:50", scale="utc")
    star = SkyCoord(160.0 * u.deg, 15.0 * u.deg)
    stations = EarthLocation.from_geodetic(
        [-30.25, 10.0, 60.0, 5.5] * u.deg, [10.0, 50.5, -35.0, 0.0] * u.deg, [0, 300, 2e3, 5] * u.m
    )
    toward = np.asarray(star.cartesian.xyz.value)
    ends = np.array([-3600.0, 3600.0])
    path = (-2e8 * toward + np.outer(ends, [5.0, 10.0, 0.0])) * u.km
    geometry = observing.Geometry(start + ends * u.s, to_observer=path, frame="equatorial")
    begin = (start + [0.25, 3.5, 11.125, 0.0] * u.s).copy()
    end = (start + [7.5, 9.25, 12.5, 0.0] * u.s).copy()
    begin[3] = end[3] = np.ma.masked
    chords = {"disappearance": begin, "reappearance": end}
    sigma = [[0.02, 0.03], [0.1, 0.1], [0.5, 0.25], [0.1, 0.1]] * u.s
    watched = (start - [60.0] * 4 * u.s, start + [80.0] * 4 * u.s)
    body = ["A", "A", "B", None]
    common = {"star": star, "geometry": geometry}
    return observing.StellarOccultation(
        stations=stations, sigma=sigma, body=body, watched=watched, **chords, **common
    ), common


def alike(result, wanted, tolerance=2e-3):
    """Two sets of chords have the same times, errors and stations."""
    (chords, watched), (expected, other_watch) = result.chords, wanted.chords
    assert np.array_equal(chords.mask, expected.mask)
    assert abs((chords - expected).to_value("s")[~np.asarray(chords.mask)]).max() < tolerance
    np.testing.assert_allclose(result.errors_of_chords.to_value("s"), wanted.errors_of_chords.to_value("s"), atol=1e-12)
    positions = [data.stations.locations.to_geocentric() for data in (result, wanted)]
    for first, other in zip(*positions, strict=True):
        assert abs((first - other).to_value("m")).max() < 1.0
    return watched, other_watch


def test_tables_of_chords_are_read_back(event):
    data, common = event
    watched, wanted = alike(observing.StellarOccultation.from_table(data.to_table(), **common), data, 1e-6)
    assert abs((watched - wanted).to_value("s")).max() < 1e-6
    template = observed([495.0, NAN, NAN], [505.0, 506.0, NAN], heights=[0.0, 1.0, 2.0])
    again = observing.StellarOccultation.from_table(
        template.to_table(), star=STAR, geometry=template.geometry, offset=0.0
    )
    assert np.array_equal(again.times, template.times)
    assert again.sign.tolist() == template.sign.tolist()


def test_other_names_of_columns_are_read_from_a_table(event):
    data, common = event
    table = data.to_table()
    names = {"sigma": ("first error", "last error"), "disappearance": "D"}
    table.rename_columns(
        ["sigma_disappearance", "sigma_reappearance", "disappearance"], ["first error", "last error", "D"]
    )
    alike(observing.StellarOccultation.from_table(table, columns=names, **common), data, 1e-6)
    refused(
        "'D' is not an option of columns", lambda: observing.StellarOccultation.from_table(table, columns={"D": "D"})
    )


def test_files_of_occult_are_read_back(event, tmp_path):
    data, common = event
    path = tmp_path / "event.xml"
    data.write_occult(path, asteroid=(22, "Kalliope"), satellite="B")
    found = observing.StellarOccultation.read_occult(path, geometry=common["geometry"], body="A", satellite="B")
    alike(found, data)
    assert found.body == ("A", "A", "B", None)
    assert found.star.coordinates == pytest.approx(data.star.coordinates, abs=1e-8)


#: An event as the description of the format has it, with misses, clouds, a second star and default errors.
OCCULT = """<?xml version="1.0"?>
<AsteroidOccultations><FileVersion>2.15</FileVersion><Event>
<Date>2008|12|11|7.7</Date>
<Details><Star>TYC|1215-00223-1|3|100|2.7904481530|+19.846293622|0.1|0.1|0.02|0|2.8|19.9|11|10|9|</Star>
<Asteroid>135|Hertha|3.1|1.2|0|0|0|0|5.9|0|77|2|10.5</Asteroid></Details>
<Observations><Prediction>0|-110 00 00.0|+32 00 00.0|7 44 00.0|</Prediction>
<Observer><ID>1|A. Alpha|B. Beta|0|Tucson|AZ|-110 57 30.5|+32 13
15.0|730|_|20|3|a|a</ID><Conditions>1|1|5||</Conditions> <D>7 43 50.25|D|0.02||5|</D><R>7 43 57.50|R|||5|</R></Observer>
<Observer><ID>2|C. Gamma||0|Phoenix|AZ|-112 04 00.0|+33 27 00.0|330|_|20|3|f|f</ID><Conditions>||||</Conditions>
<D>7 43 40.0|M||||</D><R>7 44 10.0|M||||</R></Observer>
<Observer><ID>3|D. Delta||0|Yuma|AZ|-114 37 00.0|+32 41 00.0|43|_|20|3|a|b</ID><Conditions>||||</Conditions>
<D>7 43 45.1|D||||</D><R>7 43 51.1|R||||z</R></Observer>
<Observer><ID>4|E. Epsilon||0|Yuma|AZ|-114 37 00.0|+32 41 00.0|43|_|20|3|a|b</ID><Conditions>||||</Conditions>
<D>7 43 45.1|C||||</D><R>7 43 51.1|C||||</R></Observer>
</Observations></Event></AsteroidOccultations>"""


def test_an_event_of_occult_has_its_star_stations_misses_and_default_errors(tmp_path):
    path = tmp_path / "hertha.xml"
    path.write_text(OCCULT)
    geometry = observing.Geometry(
        Time(["2008-12-11T07:00:00", "2008-12-11T08:00:00"]), to_observer=[[-1e8, 0, 0], [-1e8, 1e4, 0]] * u.km
    )
    with pytest.warns(fullbody.errors.InconsistentInput, match="the observers 4 are left out"):
        data = observing.StellarOccultation.read_occult(path, geometry=geometry, body="Hertha")
    assert data.star.coordinates == pytest.approx((15.0 * 2.7904481530, 19.846293622), abs=1e-9)
    assert [time.isot for time in data.times[data.sign != 0.0]] == [
        "2008-12-11T07:43:50.250",
        "2008-12-11T07:43:51.100",
        "2008-12-11T07:43:57.500",
    ]
    # A miss, the first contact of the first station, and the second contact of the third one, which has "R only".
    assert sorted(zip(data.station.tolist(), data.sign.tolist(), strict=True)) == [
        (0, -1.0),
        (0, 1.0),
        (1, 0.0),
        (2, 1.0),
    ]
    errors = data.errors_of_chords.to_value("s")
    assert errors[0].tolist() == [0.02, 0.5]
    assert errors[2].tolist() == [1.5, 1.5]
    position = data.stations.locations[0].to_geodetic("WGS84")
    assert position.lon.deg == pytest.approx(-(110 + 57 / 60 + 30.5 / 3600))
    assert position.height.to_value("m") == pytest.approx(730.0, abs=1e-6)


def test_reports_of_sodis_are_read_back_with_the_intervals_of_misses(event, tmp_path):
    data, common = event
    paths = data.write_sodis(tmp_path, asteroid=(22, "Kalliope"), star="UCAC4 526-049530", names=list("abcd"))
    assert len(paths) == 4
    assert "#D: D23:59:50.250\n" in paths[0].read_text()
    watched, wanted = alike(observing.StellarOccultation.read_sodis(paths, **common, body="A"), data)
    assert abs((watched - wanted).to_value("s")).max() < 2e-3


#: A file of KOALA with the Earth at a distance of 1e8 km along x, which moves against the pole of the ecliptic.
KOALA = """1
1.0e8 0.0 0.0
0.0 0.0 -10.0
0.0
3
2454811.50000000 0.02 0.0 0.0 2454811.50005787 0.03 19.8874 -45.8740 3
2454811.50000000 0.02 1.0 2.0 2454811.50005787 0.03 20.8874 -43.8740 3
2454811.50000000 0.02 900.0 0.0 2454811.50005787 0.03 919.9 -45.9 -1
"""


def test_files_of_koala_have_positions_to_the_west_and_north_in_a_plane_that_moves_with_the_shadow(tmp_path):
    path = tmp_path / "event.occ"
    path.write_text(KOALA)
    data = observing.StellarOccultation.read_koala(path, body="A")
    assert data.errors_of_chords.to_value("s")[0].tolist() == [0.02, 0.03]
    assert data.sign.tolist().count(0.0) == 1
    assert data.times[0].isot == "2008-12-11T00:00:00.000"
    # The Earth moves by -10 km/s along the ecliptic's pole, at the star to the west by 10 sin and to the south by 10
    # cos of the obliquity. The first station moves with it, so that it stays where it is from the Earth.
    positions = data.stations.vectors.to_value("km")
    assert positions[0, 1] == pytest.approx(positions[0, 0], abs=1e-2)
    assert positions[1] - positions[0] == pytest.approx(np.array([[-1.0, 2.0], [-1.0, 2.0]]), abs=1e-2)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "not in the format of KOALA"),
        (KOALA.replace("\n3\n", "\n5\n"), "a line for each chord"),
        (KOALA.replace("19.8874 -45.8740 3", "19.8874"), "9 columns"),
        (KOALA.replace("1\n", "two\n", 1), "not in the format of KOALA"),
    ],
)
def test_files_of_koala_in_another_form_are_refused(content, message, tmp_path):
    path = tmp_path / "event.occ"
    path.write_text(content)
    refused(message, lambda: observing.StellarOccultation.read_koala(path))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<a>", "is not a file of Occult"),
        ("<AsteroidOccultations></AsteroidOccultations>", "has 0 events"),
        (OCCULT.replace("<Date>2008|12|11|7.7</Date>", ""), "the tag Date is ''"),
        (OCCULT.replace("7 43 50.25", "7 43"), "a time is '7 43'"),
        (OCCULT.replace("-110 57 30.5|", "west|"), "longitude or latitude is 'west'"),
    ],
)
def test_files_of_occult_in_another_form_are_refused(content, message, tmp_path):
    path = tmp_path / "event.xml"
    path.write_text(content)
    refused(message, lambda: observing.StellarOccultation.read_occult(path, geometry=passing()))
