"""The report on the paper: its measures against closed forms, its findings against runs of their own, its files."""

import json
import re
from html.parser import HTMLParser

import fullbody
import numpy as np
import pytest
from fullbody.cli import main
from fullbody.commands.kw4 import printed
from fullbody.commands.kw4 import year as kw4

from reproduction.ho2021 import cases, page, paper, physical, starts, write_report
from reproduction.ho2021.__main__ import main as report
from reproduction.ho2021.verdicts import as_printed

DEGREE = np.pi / 180


@pytest.fixture(scope="module")
def draft(tmp_path_factory):
    return write_report(tmp_path_factory.mktemp("report"), draft=True)


@pytest.fixture(scope="module")
def numbers(draft):
    return json.loads(draft.numbers.read_text(), parse_constant=lambda name: pytest.fail(f"{name} in the numbers"))


# What is measured, against closed forms.


def test_rounding_follows_the_printed_decimals():
    assert as_printed(0.01256, "0.0126") == "0.0126"
    assert as_printed(17.41149, "17.4116") == "17.4115"
    assert as_printed(3928.5, "3900") == "3928"


def test_slow_maxima_of_a_rippled_cosine():
    hours = np.arange(0.0, 9000.0, 0.2)
    values = np.cos(2 * np.pi * (hours - 300.0) / 4000.0) + 0.01 * np.cos(2 * np.pi * hours / 8.7)
    assert kw4.slow_maxima(hours, values) == pytest.approx([300.0, 4300.0, 8300.0], abs=5.0)
    assert kw4.between_maxima(hours, values) == pytest.approx(4000.0, abs=5.0)
    assert np.isnan(kw4.between_maxima(hours[:1000], values[:1000]))


def test_inclination_to_the_first_plane_of_a_point_orbit_is_zero():
    system, state = fullbody.systems.kw4_ho2021(gravity="point")
    run = system.integrate(state, 100.0, output=1.0)
    assert kw4.inclination_to_first(run).max() < 1e-9


def test_energy_of_the_tops_dominates():
    """Case 2 starts with 2 * 1/2 I w^2 of rotation, I = 2/5 m a^2, and the least it can have is nearly that."""
    run, _ = cases.case(2)
    measured = cases.measure(run, cases.fine(run))
    assert measured.rotational_range[0] == pytest.approx(2 * 0.5 * (2 / 5 * 2.0) * 2.0**2, rel=1e-5)
    assert measured.tilt == pytest.approx(np.pi / 32, rel=0.01)


@pytest.mark.parametrize("theta", [np.pi / 16, np.pi / 8])
def test_growth_with_the_tilt_follows_the_sine_of_twice_the_angle(theta):
    assert cases.growth(theta) == pytest.approx(np.sin(2 * theta) / np.sin(np.pi / 16), rel=0.06)


def test_fine_samples_miss_no_peak():
    """Case 2's spins turn fast: of the accepted steps alone the largest is missed by a hundredth."""
    run, _ = cases.case(2)
    dense = run.system.integrate(run[0], 200.0, dense=True)
    largest = np.abs(dense(np.linspace(0.0, 200.0, 40001)).spin[..., :2]).max()
    assert cases.measure(run, cases.fine(run)).transverse == pytest.approx(largest, rel=2e-4)
    assert np.abs(run.spin[..., :2]).max() < 0.995 * largest


def test_momentum_of_places_is_that_of_the_states():
    system, state = fullbody.systems.kw4_ho2021(units=True)
    run = system.integrate(state, 100.0, output=10.0)
    expected = [system.angular_momentum(at).value for at in run]
    assert kw4.momentum_of_places(run) == pytest.approx(np.array(expected), rel=1e-13)
    assert run.angular_momentum.value == pytest.approx(np.array(expected), rel=1e-13)


def test_docstring_of_the_start_quotes_the_paper():
    text = fullbody.systems.kw4_ho2021.__doc__
    for shape in printed.YEAR.values():
        assert f"{shape.period:.4f}" in text
        assert f"{shape.inclination_period:.0f}" in text
    for value in (*printed.SPIN["z"], -printed.SPIN["x"][0], printed.SPIN["y"][1]):
        assert f"{value:.2f}" in text


def test_motion_along_z_by_arithmetic():
    curves, run = cases.z_motion(150.0)
    for name in ("compensated", "double"):
        assert 0.0 < curves[name].z.max() < 1e-13
    assert 5e-12 < curves["seeded"].z.max() < 5e-10
    assert np.abs(run.position[:, 0, 2]).max() == curves["compensated"].z.max()


def test_plain_doubles_follow_the_default_integrator():
    """Started off the symmetry, an independent integrator with rates written out anew finds the same motion along z."""
    system, state = fullbody.systems.case1()
    state = state.replace(position=np.add(state.position, [[0, 0, 1e-3], [0, 0, -1e-3]]))
    times, z = cases._dop853(system, state, 50.0, False)
    run = system.integrate(state, 50.0, output=[50.0])
    assert times[-1] == 50.0
    assert z[-1] == pytest.approx(run.position[0, 0, 2], rel=1e-6)


@pytest.mark.parametrize("inclination", [150.0, 179.0])
def test_node_goes_round_as_the_quadrupole_says(inclination):
    """Spin S and orbit L under the averaged quadrupole go round their sum J at 3/2 (G m_B (C - A)/a^3) cos J/(L S)."""
    (found,), (longer,) = starts.nodal_period("spheroid", np.array([inclination]))
    system, _ = fullbody.systems.kw4_ho2021("spheroid")
    m, axes = [b.mass for b in system.bodies], [b.shape.semi_axes for b in system.bodies]
    a, reduced, G = 2.5477, m[0] * m[1] / sum(m), system.G
    # C - A of Alpha; Beta's share is left out, as its own pole turns.
    flattening = m[0] * (axes[0][0] ** 2 - axes[0][2] ** 2) / 5
    orbit = reduced * np.sqrt(G * sum(m) * a)
    spin = 2 / 5 * m[0] * axes[0][0] ** 2 * 2.2728
    normal = np.array([0.0, np.sin(inclination * DEGREE), np.cos(inclination * DEGREE)])
    cosine = np.cos(inclination * DEGREE)
    total = np.linalg.norm(orbit * normal + np.array([0.0, 0.0, spin]))
    rate = 1.5 * G * m[1] * flattening / a**3 * abs(cosine) * total / (orbit * spin)
    assert found == pytest.approx(2 * np.pi / rate, rel=0.06)
    assert longer == pytest.approx(found, rel=0.01)


# What is found, by runs of their own.


def test_beta_turned_by_half_a_turn_spins_alike():
    """An ellipsoid is its own image under a half turn about its pole; x and y change their signs."""
    system, state = fullbody.systems.kw4_ho2021()
    make = starts.SCANS["turn about Beta's pole"][3]
    one, two = (kw4.spin_range(system, make(state, system.mu(), angle)) for angle in (-150.0, 30.0))
    assert one[2] == pytest.approx(two[2], abs=1e-9)
    assert one[:2] == pytest.approx(-two[:2, ::-1], abs=1e-9)


def test_scans_come_closer_near_the_printed_ranges():
    """Half a degree either way of the mean motion's hour the misfit is larger, and no rate of spin comes near."""
    found = starts.scan("turn about the orbit's normal", 6)
    motion = np.sqrt(fullbody.systems.kw4_ho2021()[0].mu() / 2.548**3) / DEGREE
    assert found.best[0] == pytest.approx(-motion, abs=0.7)
    assert found.best[1] < 0.01 < found.misfit[np.abs(found.values + motion) > 2.0].min()
    assert np.all(np.diff(found.values) > 0)
    assert starts.scan("Beta's rate of spin", 6).best[1] > 0.1


def test_an_orientation_gives_all_six_printed_numbers():
    system, state = fullbody.systems.kw4_ho2021()
    angles = np.array([[3.2, 0, 0], [-8.08, -0.84, 19.08]]) * DEGREE
    turned = fullbody.State.from_tait_bryan(state.position, state.velocity, angles, state.spin)
    run = system.integrate(turned, 200.0, output=0.02)
    spin = run.spin[:, 1] * 1e5 / 3600
    ranges = {axis: (spin[:, k].min(), spin[:, k].max()) for k, axis in enumerate("xyz")}
    for axis, limits in printed.SPIN.items():
        assert [round(value, 2) for value in ranges[axis]] == list(limits)
    # A turn the other way does not.
    other = fullbody.State.from_tait_bryan(state.position, state.velocity, angles * [[1], [-1]], state.spin)
    assert np.abs(kw4.spin_range(system, other) - starts.PRINTED).max() > 0.5


def test_that_orientation_is_an_hour_of_motion_about_the_normal(numbers):
    """The angle of the turn is the mean motion of the stated orbit, and its axis the orbit's normal."""
    from scipy.spatial.transform import Rotation

    best = numbers["spin_search"]["minima"][0]
    assert best["misfit"] < 0.006
    system, state = fullbody.systems.kw4_ho2021()
    turn = Rotation.from_euler("ZYX", best["angles"][::-1], degrees=True).as_rotvec()
    assert np.linalg.norm(turn) == pytest.approx(np.sqrt(system.mu() / 2.548**3), rel=0.01)
    normal = np.cross(state.position[1], state.velocity[1])
    cosine = -turn @ normal / np.linalg.norm(turn) / np.linalg.norm(normal)
    assert np.arccos(cosine) < 1.5 * DEGREE
    # Against the motion.
    assert best["turn"] == pytest.approx(-np.linalg.norm(turn) / DEGREE, abs=1e-9)
    assert best["off_normal"] == pytest.approx(np.arccos(cosine) / DEGREE, abs=1e-6)


def test_that_orientation_does_not_give_the_printed_year(numbers):
    for moved in (numbers["kw4_from_spin_search"], numbers["kw4_from_mean_anomaly"]):
        assert abs(moved["a_mean"] - printed.YEAR["ellipsoid"].a_mean) > 3e-4


def test_table_2_is_rounded(numbers):
    """With its axes the year misses digits that the authors' own axes give; the spin's range stays."""
    rounded, year = (numbers["kw4"][which]["ellipsoid"] for which in ("printed_axes", "surface"))
    assert as_printed(rounded["a_min"], "2.5418") != "2.5418" == as_printed(year["a_min"], "2.5418")
    assert rounded["spin_z"] == pytest.approx(year["spin_z"], abs=0.02)


def test_six_ways_agree(numbers):
    ranges = np.array([way["ranges"] for way in numbers["agreement"]])
    assert len(ranges) == 6
    assert np.ptp(ranges, axis=0).max() < 1e-9


def test_physical_states():
    motions = {motion.name: motion for motion in physical.motions()}
    assert motions["relaxed"].libration < 0.5 < motions["nominal"].libration < motions["excited"].libration
    assert motions["excited"].e[1] > paper.EXCITED_E
    assert np.isnan(motions[physical.PAPER].libration)
    # The same angles with the orbit in the plane of Beta's equator; the same orbit with that equator in its plane.
    assert np.abs(motions[physical.FLAT].spin[:2]).max() < 0.05
    assert np.abs(motions[physical.TURNED].spin[:2]).max() < 0.1
    assert np.array_equal(motions[physical.TURNED].run[0].position, motions[physical.PAPER].run[0].position)
    # Prograde: Beta's pole stays; retrograde and inclined: it does not.
    assert np.abs(motions["excited"].spin[:2]).max() < 0.2 < 2.0 < np.abs(motions[physical.PAPER].spin[:2]).max()
    # A circular orbit's osculating eccentricity is what the quadrupoles add to the attraction: Alpha's 3/2 J2 (R/r)^2,
    # and 3/2 (B + C - 2A)/(m r^2) of Beta, whose long axis points at Alpha.
    system, _ = fullbody.systems.kw4()
    (a, b, c), (p, q, r) = (body.shape.semi_axes for body in system.bodies)
    forced = 1.5 / 5 * (((a * a + b * b) / 2 - c * c) + (2 * p * p - q * q - r * r)) / 2.547**2
    assert np.mean(motions["relaxed"].e) == pytest.approx(forced, rel=0.05)


# The verdicts and the files.


def test_each_statement_has_its_verdict(draft):
    assert [verdict.key for verdict in draft.verdicts] == list(paper.STATEMENTS)
    assert all(verdict.ours for verdict in draft.verdicts)
    assert all(verdict.why for verdict in draft.verdicts if verdict.verdict == "differs")


def test_verdicts_are_the_known_ones(draft):
    by_word = {}
    for verdict in draft.verdicts:
        by_word.setdefault(verdict.verdict, set()).add(verdict.key)
    differ = {"case1.z", "case2.z", "case1.force_z", "case2.four_times", "kw4.spheroid.spin_xy", "kw4.synchronous"}
    differ |= {"kw4.period_order_5", "kw4.period_power", *(f"kw4.spin_{axis}" for axis in "xyz")}
    differ |= {f"kw4.{shape}.{what}" for shape in printed.YEAR for what in ("period", "inclination_period")}
    assert by_word["differs"] == differ
    # A draft stops short of t = 2200.
    assert by_word["open"] == {
        *("kw4.between_states", "kw4.similar_spin", "kw4.shape_e"),
        *("case1.z_late", "case1.xy_late"),
    }
    assert {key.rpartition(".")[2] for key in by_word["faster"]} == {"cpu"}


def test_equal_means_the_printed_digits(draft):
    equal = [verdict for verdict in draft.verdicts if verdict.verdict == "equal"]
    assert len(equal) == 8
    assert all(verdict.ours == verdict.printed for verdict in equal)


def test_statements_carry_the_numbers_of_the_tables():
    assert paper.STATEMENTS["kw4.ellipsoid.a_min"].text == "2.5418"
    assert paper.STATEMENTS["kw4.spheroid.period"].text == "17.4177"
    assert paper.STATEMENTS["kw4.spin_z"].text == "[9.55, 11.16]"
    assert paper.STATEMENTS["kw4.ellipsoid.cpu"].text == "4.6 h"


def test_kw4_command_and_report_measure_alike(numbers, tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path), "--gravity", "focal", "--quiet"]) == 0
    command = json.loads((tmp_path / "numbers.json").read_text())
    for shape in printed.YEAR:
        one, two = command[shape]["focal"], numbers["kw4"]["focal"][shape]
        for measured in (one, two):
            measured.pop("cpu_seconds")
        assert one == two


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.sources, self.open, self.text = [], [], ""

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.sources += [values[name] for name in ("src", "href") if name in values]
        if tag not in ("meta", "img", "br", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_page_needs_no_other_file(draft):
    page = _Page()
    page.feed(draft.page.read_text(encoding="utf-8"))
    assert page.open == []
    assert all(source.startswith(("data:image/png;base64,", "#")) for source in page.sources)
    figures = {path.stem for path in draft.figures}
    assert sum(source.startswith("data:") for source in page.sources) == len(figures) == 12
    assert "draft" in page.text
    assert not re.search(r"\b(nan|inf|None)\b", page.text)


def test_figures_are_written_twice(draft):
    assert sorted({path.suffix for path in draft.figures}) == [".pdf", ".png"]
    assert all(path.stat().st_size > 5000 for path in draft.figures)
    assert not [path for path in draft.page.parent.rglob("*") if ".part" in path.name]


def test_out_is_a_folder(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    with pytest.raises(fullbody.InvalidInput, match=r"out is '.*file', a file; expected a folder"):
        write_report(file)
    assert file.read_text() == "mine"


def test_numbers_of_an_earlier_report_do_not_outlive_it(tmp_path, monkeypatch):
    (tmp_path / "numbers.json").write_text("{}")

    def fails(**options):
        raise KeyboardInterrupt

    monkeypatch.setattr(page, "compute", fails)
    with pytest.raises(KeyboardInterrupt):
        write_report(tmp_path)
    assert [path.name for path in tmp_path.rglob("*")] == ["figures"]


def test_short_years_have_numbers_that_every_reader_takes(tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path), "--gravity", "focal", "--until", "300", "--quiet"]) == 0
    read = json.loads((tmp_path / "numbers.json").read_text(), parse_constant=lambda name: pytest.fail(name))
    assert read["spheroid"]["focal"]["inclination_period"] is None
    printed = capsys.readouterr().out
    assert "nan" not in printed
    assert "300 hours; the paper's numbers are of 8766 hours" in printed


@pytest.mark.parametrize("until", ["-3", "0", "nan", "inf"])
def test_years_have_hours(until, tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path / "kw4"), "--until", until, "--quiet"]) == 1
    assert f"--until is {until}; expected hours above zero" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_command_prints_the_verdicts(monkeypatch, capsys, draft, tmp_path):
    monkeypatch.setattr("reproduction.ho2021.__main__.write_report", lambda out, **options: draft)
    assert report(["--draft", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "8 equal" in said
    assert str(draft.page) in said


def test_command_says_why_it_cannot(capsys, tmp_path):
    (tmp_path / "file").write_text("mine")
    assert report(["--out", str(tmp_path / "file")]) == 1
    assert "a file; expected a folder" in capsys.readouterr().err
