"""Light curves, shapes and spins of DAMIT, compared with its own program and an ephemeris; malformed files."""

import json

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.coordinates import get_body_barycentric
from astropy.time import Time
from fullbody import observing
from fullbody.base import rotations
from fullbody.errors import InconsistentInput
from support import DATA, refused, refused_with

#: Five light curves of (43) Ariadne, an ellipsoid whose long axis is not along x, and a spin; see make_lcgenerator.py.
FOLDER = DATA / "damit"
ARIADNE, SHAPE, SPIN = (FOLDER / name for name in ("lc.txt", "shape.txt", "spin.txt"))
HERTHA = DATA / "observations" / "hertha" / "light_curves.lc"


@pytest.fixture(scope="module")
def curves():
    return observing.read_damit(ARIADNE, sigma=0.01)


def run_of(data, model):
    system = fullbody.System([model.body], units=True, epoch=model.epoch, frame="ecliptic")
    hours = float((data.times[-1] - model.epoch).to_value("h"))
    return system.integrate(model.state, duration=hours + 1.0, dense=True)


def model_before(data):
    """The model an hour before the first of the data."""
    return observing.read_damit_model(SHAPE, SPIN, density="2 g/cm3", epoch=data.times[0] - 1.0 * u.h)


@pytest.mark.parametrize("k", range(5))
def test_a_model_gives_the_light_curves_that_damits_own_program_computes(curves, k):
    data, model = curves[k], model_before(curves[k])
    result = observing.light_curve(run_of(data, model), data.times, data.geometry, law=model.law, mutual=False)
    first = sum(map(len, curves[:k]))
    intensity = np.loadtxt(FOLDER / "lcgenerator.txt")[first : first + len(data)]
    if data.filters is None:
        # The program divides relative intensities by their mean, and prints six decimals.
        result += 2.5 * np.log10(np.mean(10.0 ** (-0.4 * result)))
    # The light varies, and the intensities are those printed, with fewer decimals where they are relative.
    assert np.ptp(result) > 0.09
    assert np.abs(result + 2.5 * np.log10(intensity)).max() < (1e-6 if data.filters is None else 1e-8)


def test_curves_have_the_numbers_of_the_file(curves):
    assert [len(data) for data in curves] == [91, 10, 7, 10, 11]
    rows = np.array([line.split() for line in ARIADNE.read_text().splitlines()[2:93]], dtype=float)
    data = curves[0]
    assert np.allclose(data.times.jd, rows[:, 0], atol=1e-9, rtol=0)
    assert data.times.scale == "tdb"
    assert np.allclose(10.0 ** (-0.4 * data.magnitude), rows[:, 1], rtol=1e-13)
    assert np.allclose(data.geometry.to_sun(data.times).to_value("au"), rows[:, 2:5], rtol=1e-12)
    assert np.allclose(data.geometry.to_observer(data.times).to_value("au"), rows[:, 5:], rtol=1e-12)
    assert not data.geometry.light_time
    assert data.geometry.frame == "ecliptic"
    assert data.reduced


@pytest.mark.parametrize(("path", "tolerance"), [(ARIADNE, 1e-6), (HERTHA, 4.26e-5 + 1e-6)])
def test_earth_and_sun_of_the_files_are_those_of_an_ephemeris(path, tolerance):
    # The curves of Hertha are seen from the surface of the Earth, whose radius is 4.26e-5 au.
    # The obliquity of the ecliptic of J2000 (IAU 1976).
    obliquity = np.radians(84381.448 / 3600.0)
    c, s = np.cos(obliquity), np.sin(obliquity)
    to_ecliptic = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    for data in observing.read_damit(path, sigma=0.01):
        time = data.times[0]
        result = (data.geometry.to_observer(time) - data.geometry.to_sun(time)).to_value("au")
        earth, sun = (get_body_barycentric(name, time).xyz.to_value("au") for name in ("earth", "sun"))
        assert np.linalg.norm(to_ecliptic @ (earth - sun) - result) < tolerance


def test_hertha_has_32_curves_with_plausible_estimated_errors():
    data = observing.read_damit(HERTHA, sigma="estimate")
    assert (len(data), sum(map(len, data))) == (32, 1285)
    assert all(0.001 < curve.sigma[0] < 0.03 for curve in data)


def test_calibrated_curves_share_a_zero_point_and_relative_ones_have_their_own(curves):
    names = []
    for data in curves:
        (unknown,) = data.linear(run_of(data, model_before(data))).unknowns
        names.append((unknown.name, unknown.shared))
    free_names = [(f"zero point of curve {k}", False) for k in (1, 2, 3)]
    assert names == [*free_names, *[("zero point of calibrated", True)] * 2]


def test_json_has_the_same_curves_whether_points_are_text_or_lists(curves, tmp_path):
    rows = ARIADNE.read_text().splitlines()[1:]
    content, row = [], 0
    for k in range(5):
        count, scale = map(int, rows[row].split())
        lines = rows[row + 1 : row + 1 + count]
        points = "\n".join(lines) if k % 2 else [[float(word) for word in line.split()] for line in lines]
        content.append({"id": 70 + k, "scale": scale, "points": points, "points_count": count, "created": "2020-01-01"})
        row += 1 + count
    path = tmp_path / "lc.json"
    path.write_text(json.dumps(content))
    result = observing.read_damit(path, sigma=0.01)
    for data, expected in zip(result, curves, strict=True):
        assert np.array_equal(data.magnitude, expected.magnitude)
        assert data.geometry == expected.geometry
    assert result[1].nights.tolist() == ["curve 71"]


def write_curve(path, days, magnitude):
    """Write one relative light curve at days after JD 2450000; return the path."""
    rows = [
        f"{2450000 + day:.8f} {10.0 ** (-0.4 * m):.12e} 1 0 0 1 0.1 0" for day, m in zip(days, magnitude, strict=True)
    ]
    path.write_text("\n".join(["1", f"{len(rows)} 0", *rows]))
    return path


def test_errors_are_estimated_from_the_scatter_with_a_warning_unless_they_are_asked_for(tmp_path):
    rng = np.random.default_rng(5)
    days = np.sort(rng.uniform(0.0, 0.3, 400))
    signal = 0.15 * np.cos(4.0 * np.pi * days / 0.35)
    noise = rng.normal(scale=0.02, size=400)
    noise[::40] += 0.5
    path = write_curve(tmp_path / "lc.txt", days, signal + noise)
    with pytest.warns(InconsistentInput, match=r"no standard errors of 1 curves; they are estimated.*give sigma="):
        (data,) = observing.read_damit(path)
    # The estimate is a median of 396 differences of five points each. It has an error of 6 %, and is raised by the
    # ten outliers, each of which is in five differences.
    assert np.ptp(data.sigma) == 0.0
    assert 0.85 < data.sigma[0] / 0.02 < 1.6
    (smooth,) = observing.read_damit(write_curve(path, days, signal), sigma="estimate")
    assert smooth.sigma[0] < 1e-5


def test_errors_are_given_for_all_curves_or_for_each():
    sigma = np.linspace(0.01, 0.05, 5)
    assert [curve.sigma[0] for curve in observing.read_damit(ARIADNE, sigma=sigma)] == sigma.tolist()
    assert all((curve.sigma == 0.02).all() for curve in observing.read_damit(ARIADNE, sigma=0.02 * u.mag))
    refused_with(
        "sigma has shape (3,); expected one number, or (5,)", lambda: observing.read_damit(ARIADNE, sigma=sigma[:3])
    )


def test_a_curve_of_few_points_is_refused_without_errors(tmp_path):
    path = write_curve(tmp_path / "lc.txt", np.arange(4) * 0.01, np.zeros(4))
    refused_with("curve 1 too few points to estimate them; give sigma=", lambda: observing.read_damit(path))


ROW = "2450000.5 1.0 1 0 0 1 0.1 0"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "lc.txt: the file is empty; expected the number of light curves"),
        ("one", "line 1: the number of light curves is 'one'; expected a whole number from 0 on"),
        ("0", "the file has no light curves"),
        ("1\n1 2\n" + ROW, "line 2: the scale is '2'; expected 0 for relative or 1 for calibrated"),
        ("1\n0 0\n" + ROW, "line 2: the number of points is '0'; expected a whole number from 1 on"),
        ("1\n2 0\n" + ROW, "line 3: the file ends here; expected JD, intensity"),
        ("1\n\n1 0\n" + ROW + " 0.01", "line 4: the line has 9 columns; expected JD, intensity"),
        ("1\n1 0\n" + ROW.replace("1.0", "nan", 1), "line 3: column 2 is 'nan'; expected a finite number"),
        ("1\n1 0\n" + ROW.replace("1.0", "0.0", 1), "line 3: the intensity is '0.0'; expected a number above zero"),
        ("1\n1 0\n" + ROW.replace("1.0", "1_0", 1), "line 3: column 2 is '1_0'; expected a number"),
        ("1\n1_0 0\n" + ROW, "line 2: the number of points is '1_0'; expected a whole number from 1 on"),
        ("1\n1 0\n" + ROW.replace("1 0 0", "0 0 0"), "line 3: the vector to the Sun is zero"),
        ("1\n1 0\n" + ROW + "\n" + ROW, "line 4: the line is after the last of the light curves"),
    ],
)
def test_malformed_light_curves_are_refused_with_the_line(tmp_path, text, message):
    path = tmp_path / "lc.txt"
    path.write_text(text)
    refused_with(message, lambda: observing.read_damit(path, sigma=0.01))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[\n{", "line 2: Expecting property name"),
        ("{}", "the content is no list; expected a list of objects with id, scale and points"),
        (f"[{'9' * 5000}]", "the content has a whole number of thousands of digits"),
        ('[{"scale": 3, "points": ""}]', "entry 1 is {'scale': 3"),
        ('[{"id": 8, "scale": 0, "points": "1 2"}]', "row 1 of curve 8 is ['1', '2']; expected JD"),
        ('[{"id": 8, "scale": 0, "points": "", "points_count": 2}]', "curve 8 has [] for 2 points"),
    ],
)
def test_malformed_json_is_refused_with_the_line_or_curve(tmp_path, text, message):
    path = tmp_path / "lc.json"
    path.write_text(text)
    refused_with(message, lambda: observing.read_damit(path, sigma=0.01))


def rotation(axis, angle):
    """The matrix of a rotation by degrees about the axis y (1) or z (2)."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]] if axis == 1 else [[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_a_model_rotates_by_the_formula_of_damit():
    # Rz(longitude) Ry(90 - latitude) Rz(angle), and the phase function 1 + a exp(-phase / d) + k phase.
    epoch = Time(2438882.0 + 100.7, format="jd", scale="tdb")
    model = observing.read_damit_model(SHAPE, SPIN, density="2 g/cm3", epoch=epoch, name="Ariadne")
    angle = 30.0 + 360.0 * 100.7 * 24.0 / 5.76198
    expected = rotation(2, 253.0) @ rotation(1, 90.0 + 15.0) @ rotation(2, angle)
    working = rotations.matrices(model.body.working_frame.attitude)
    assert np.allclose(model.state.rotation_matrix[0] @ working, expected, atol=1e-9)
    inertial = model.state.rotation_matrix[0] @ model.state.spin[0].to_value("rad/h")
    pole = fullbody.frames.pole_vector(np.radians(253.0), np.radians(-15.0))
    assert np.allclose(inertial, 2.0 * np.pi / 5.76198 * pole, atol=1e-9)
    assert abs((model.epoch - epoch).to_value("s")) < 1e-4
    assert model.period == 5.76198 * u.h
    assert model.body.name == "Ariadne"
    factors = model.law.phase_function(np.array([0.0, 0.2]))
    assert np.allclose(factors, [1.5, 1.0 + 0.5 * np.exp(-2.0) - 0.1])
    assert model.law.lambert == 0.1


def test_a_shape_is_scaled_to_a_diameter_or_by_a_unit():
    model = observing.read_damit_model(SHAPE, SPIN, diameter="60 km", mass="1e17 kg")
    assert np.isclose(model.body.shape.volume.to_value("km3"), np.pi / 6.0 * 60.0**3, rtol=1e-12)
    scaled = observing.read_damit_model(SHAPE, SPIN, mass="1e17 kg", unit="m")
    # A polyhedron of 98 vertices and the poles, in the ellipsoid with semi-axes of 30, 18 and 14.
    assert np.isclose(scaled.body.shape.volume.to_value("m3"), 4 / 3 * np.pi * 30 * 18 * 14, rtol=0.1)


def test_a_spin_off_the_principal_axis_is_warned_of(tmp_path):
    rows = SHAPE.read_text().splitlines()
    vertices = np.array([row.split() for row in rows[1:101]], dtype=float) @ rotation(1, 3.0).T
    path = tmp_path / "shape.txt"
    path.write_text("\n".join([rows[0], *(" ".join(map(str, row)) for row in vertices), *rows[101:]]))
    with pytest.warns(InconsistentInput, match=r"the spin is [1-9][\d.]* degrees from the principal axis"):
        observing.read_damit_model(path, SPIN, density="2 g/cm3")


def test_a_model_whose_spin_file_has_no_law_has_none(tmp_path):
    path = tmp_path / "spin.txt"
    path.write_text("253 -15 5.76198\n2438882.0 30.0\n")
    assert observing.read_damit_model(SHAPE, path, density="2 g/cm3").law is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("253 -15", "line 1: the line has 2 columns; expected longitude and latitude"),
        ("253 -95 5.7\n2438882 0", "line 1: the latitude of the pole is -95; expected -90 to 90 degrees"),
        ("253 -15 0\n2438882 0", "line 1: the period in hours is '0'; expected a number above zero"),
        ("253 -15 5.7\n2438882", "line 2: the line has 1 columns; expected JD and the rotation angle"),
        ("253 -15 5.7\n2438882 0\n0.5 0.1", "line 3: the line has 2 columns; expected a, d, k"),
        ("253 -15 5.7\n2438882 0\n0.5 0.1 -0.5", "line 3: the file ends here; expected the factor of Lambert's law"),
        ("253 -15 5.7\n2438882 0\n0 0 0\n0.1\n1", "line 5: the line is after the factor of Lambert's law"),
        ("253 -15 5.7\n2438882 0\n0.5 0 -0.5\n0.1", "d of LinearExponential is 0.0; expected a number above zero"),
    ],
)
def test_malformed_spins_are_refused_with_the_line(tmp_path, text, message):
    path = tmp_path / "spin.txt"
    path.write_text(text)
    refused_with(message, lambda: observing.read_damit_model(SHAPE, path, density="2 g/cm3"))


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (1, "100", "line 1: the line has 1 columns; expected the numbers of vertices and facets"),
        (1, "100 x", "line 1: the number of vertices or facets is 'x'"),
        (2, "1 2", "line 2: the line has 2 columns; expected the coordinates of a vertex"),
        (3, "1 inf 2", "line 3: a coordinate is 'inf'; expected a finite number"),
        (102, "1 2 101", "line 102: the triangle has vertex 101; expected at most 100"),
        (102, "0 1 2", "line 102: the number of a vertex is '0'; expected a whole number from 1 on"),
        (102, "1 1 1", "shape.txt: face 0 is (0, 0, 0); expected three different vertices"),
        (297, "1 2 3\n1 2 3", "line 298: the line is after the last facet"),
    ],
)
def test_malformed_shapes_are_refused_with_the_line(tmp_path, line, text, message):
    rows = SHAPE.read_text().splitlines()
    rows[line - 1] = text
    path = tmp_path / "shape.txt"
    path.write_text("\n".join(rows))
    refused_with(message, lambda: observing.read_damit_model(path, SPIN, density="2 g/cm3"))


def test_bad_options_of_the_readers_are_refused():
    message = "diameter is 77; expected a Quantity"
    refused_with(message, lambda: observing.read_damit_model(SHAPE, SPIN, density="2 g/cm3", diameter=77))
    message = "diameter is '-5 km'; expected a number above zero"
    refused_with(message, lambda: observing.read_damit_model(SHAPE, SPIN, density="2 g/cm3", diameter="-5 km"))
    message = "'radius' is not an option of read_damit_model; expected some of mass, density, GM"
    refused_with(message, lambda: observing.read_damit_model(SHAPE, SPIN, density="2 g/cm3", radius=3))
    refused_with("'zero' is not an option of read_damit", lambda: observing.read_damit(ARIADNE, sigma=0.01, zero=1.0))
    refused_with("scale is 'mjd'; expected 'tdb'", lambda: observing.read_damit(ARIADNE, sigma=0.01, scale="mjd"))
    refused("unit is 'kg'", observing.read_damit_model, SHAPE, SPIN, density="2 g/cm3", unit="kg")
