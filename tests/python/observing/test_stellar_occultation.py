"""Chords of stellar occultations as data: predictions, offset, derivatives, misses, clocks, what is refused."""

import pickle

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.coordinates import SkyCoord
from astropy.time import Time
from fullbody import observing
from fullbody.base import rotations
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
def test_predictions_are_the_times_of_40_digit_arithmetic(index, values):
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


def tilted(heights):
    """A star, stations and a geometry with the star at a declination of 90 degrees minus an angle."""
    angle = 0.3
    star = np.array([np.sin(angle), 0.0, np.cos(angle)])
    east, north = np.array([0.0, 1.0, 0.0]), np.array([-np.cos(angle), 0.0, np.sin(angle)])
    ends = np.array([400.0, 600.0])
    positions = -FAR * star + np.outer(SPEED * (ends - 500.0), east)
    geometry = observing.Geometry(ends * u.s, to_observer=positions * u.km, frame="equatorial")
    return star, np.outer(heights, north) * u.km, geometry, east, north


HEIGHTS = np.array([-30.0, -10.0, 5.0, 25.0])


def simulated(shape, heights=HEIGHTS, displaced=(0.0, 0.0), attitude=None, spin=None, **options):
    """Data of chords of a body that is displaced in the sky by lengths to the east and to the north, and its run."""
    star, stations, geometry, east, north = tilted(heights)
    run = run_of(shape, attitude=attitude, spin=spin, frame="equatorial")
    # The stations are moved instead of the body.
    changed = stations - (displaced[0] * east + displaced[1] * north) * u.km
    chords = observing.occultation_chords(run, star, changed, geometry)
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


def measured(exact, noise=0.0, seed=0, clock_error=0.0, heights=HEIGHTS, **options):
    """Data with the chords of exact data, normal errors of the times, and errors in s of the clocks of stations."""
    star, stations, geometry, _, _ = tilted(heights)
    options = {"star": star, "stations": stations, "geometry": geometry, "sigma": 0.05 * u.s} | options
    errors = np.random.default_rng(seed).normal(0.0, noise, (2, len(heights))) + clock_error
    begin, end = exact.chords[0].T + errors * u.s
    return observing.StellarOccultation(disappearance=begin, reappearance=end, **options)


ATTITUDE = [[0.8, 0.1, 0.3, 0.4]]


def pulls_of(data, setup, *values):
    """The pulls of a run of a set-up that has samples at the times of emission of the data alone."""
    system, state = setup(*values)
    emission = data.emission(system)
    return data.pulls(system.integrate(state, emission[-1], output=emission))[:, 0]


@pytest.mark.parametrize(
    "shape", [fullbody.Ellipsoid(60.0, 45.0, 40.0), box(70.0, 60.0, 90.0)], ids=["ellipsoid", "box"]
)
def test_the_offset_of_ephemeris_and_star_is_found(shape):
    data, run = simulated(shape, displaced=(7.0, -4.0), attitude=ATTITUDE)
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
    clock_error = np.where(np.arange(4) == 2, 1.7, 0.0)
    result = measured(data, clock_error=clock_error, clock=[2]).linear_values(run)
    assert result["clock of station 2"].to_value("s") == pytest.approx(1.7, abs=1e-6)
    assert result["offset east"].to_value("mas") == pytest.approx(0.0, abs=1e-4)
    assert measured(data, clock_error=clock_error).chi2(run) > 100.0


@pytest.mark.parametrize("clock", [None, [2]])
def test_derivatives_of_pulls_are_their_differences_with_the_offset_free(clock):
    exact, _ = simulated(fullbody.Ellipsoid(60.0, 45.0, 40.0), attitude=ATTITUDE, spin=[[0, 0, 4e-4]])
    data = measured(exact, 0.05, 2, clock=clock)

    def setup(a=60.0, spin=4e-4):
        return resting(fullbody.Ellipsoid(a, 45.0, 40.0), attitude=ATTITUDE, spin=[[0, 0, spin]], frame="equatorial")

    system, state = setup()
    emission = data.emission(system)
    run = system.integrate(state, emission[-1], output=emission, derivatives=["semi-axis a of A"])
    result, middle = data.derivatives(run), np.array([60.0, 4e-4])
    for derivative, step in (
        (result.by_parameter["semi-axis a of A"][:, 0], np.array([0.05, 0.0])),
        (result.start[:, 0, 11], np.array([0.0, 5e-6])),
    ):
        coarse, fine = (
            (pulls_of(data, setup, *(middle + h)) - pulls_of(data, setup, *(middle - h))) / (2 * h.sum())
            for h in (2 * step, step)
        )
        expected = (4.0 * fine - coarse) / 3.0
        assert abs(derivative - expected).max() < 2e-5 * abs(expected).max()


def test_derivatives_with_respect_to_a_polyhedron_s_pose_are_their_differences():
    data, run = simulated(box(70.0, 60.0, 90.0), attitude=ATTITUDE, offset=0.0)
    system, emission = run.system, data.emission(run.system)
    states = {name: np.array(value) for name, value in run.states(emission).items()}
    result, _ = data._partials(system, states)
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
    sides = [70.0, 60.0, 90.0]
    exact, _ = simulated(box(*sides), attitude=ATTITUDE, displaced=(7.0, -4.0))
    data = measured(exact, 0.2, 3)

    def setup(size):
        shape = box(*(size * side for side in sides))
        return resting(shape, attitude=ATTITUDE, frame="equatorial")

    def chi2(size):
        return np.sum(pulls_of(data, setup, size) ** 2)

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
    exact, _ = simulated(fullbody.Polyhedron(vertices, ball.faces), heights, attitude=ATTITUDE)
    data = measured(exact, 0.5, 1, heights=heights)

    def setup(size):
        shape = fullbody.Polyhedron(size * vertices, ball.faces)
        return resting(shape, attitude=ATTITUDE, frame="equatorial")

    expected = (pulls_of(data, setup, 1.001) - pulls_of(data, setup, 0.999)) / 0.002
    problem = Problem(setup, Parameters({"size": 1.0}), [data], None)
    computed = problem.jacobian(problem.point(np.array([1.0]), differentiated=True)).rows[:, 0]
    assert abs(computed - expected).max() < abs(expected).max()


def test_a_companion_without_a_surface_leaves_derivatives_exact():
    exact, _ = simulated(box(70.0, 60.0, 90.0), attitude=ATTITUDE)
    data = measured(exact, body="A")
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


def test_half_durations_are_continued_linearly_in_their_squares_where_a_body_misses():
    # A chord was seen at a height of 45, where the predicted sphere is too small by up to 10.
    half = 5.0
    data = observed([500.0 - half], [500.0 + half], heights=[45.0])
    for radius in (70.0, 46.0, 45.0, 44.0, 35.0):
        square = (radius**2 - 45.0**2) / SPEED**2
        least = 0.25 * half
        wanted = np.sqrt(square) if square >= least**2 else 0.5 * (least + square / least)
        result = data.residuals(run_of(fullbody.Sphere(radius), frame="equatorial")).to_value("s")
        assert result == pytest.approx([wanted - half, half - wanted], abs=1e-6)


def test_a_miss_counts_within_the_interval_that_the_station_watched():
    run = run_of(fullbody.Sphere(50.0), frame="equatorial")
    watched = ([NAN, 490.0, 490.0, 560.0] * u.s, [NAN, 520.0, 520.0, 580.0] * u.s)
    nothing = [495.0, NAN, NAN, NAN], [505.0, NAN, NAN, NAN]
    data = observed(*nothing, heights=[0.0, 40.0, 60.0, 40.0], watched=watched)
    assert data.sign.tolist() == [-1.0, 1.0, 0.0, 0.0, 0.0] or set(data.sign) == {-1.0, 0.0, 1.0}
    by_station = {k: data.residuals(run).to_value("s")[(data.station == k) & (data.sign == 0.0)] for k in (1, 2, 3)}
    # The line of sight is ten within the limb, and passes at the speed of 10.
    assert by_station[1] == pytest.approx([-1.0], abs=1e-6)
    assert by_station[2].tolist() == by_station[3].tolist() == [0.0]


def test_a_chord_with_one_timed_contact_has_one_row():
    run = run_of(fullbody.Sphere(50.0), frame="equatorial")
    data = observed([495.2, NAN], [NAN, 505.3], heights=[0.0, 0.0])
    assert data.residuals(run).to_value("s") == pytest.approx([0.2, 0.3], abs=1e-9)
    assert data.predict(run).to_value("s") == pytest.approx([495.0, 505.0], abs=1e-9)


def test_stations_given_at_two_times_move_uniformly():
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
