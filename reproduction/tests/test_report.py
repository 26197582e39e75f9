"""The report's verdicts, its findings and its files."""

import html
import json
import re
from html.parser import HTMLParser

import fullbody
import pytest
from fullbody.errors import InvalidInput

from reproduction.ho2021 import kw4_year, page, paper, starts
from reproduction.ho2021.__main__ import main as report
from reproduction.ho2021.page import write_report
from reproduction.typesetting import typeset


def test_each_statement_has_its_verdict(draft):
    assert [verdict.key for verdict in draft.verdicts] == list(paper.STATEMENTS)
    assert all(verdict.computed for verdict in draft.verdicts)
    assert all(verdict.why or verdict.finding for verdict in draft.verdicts if verdict.verdict == "differs")


def test_verdicts_are_those_of_earlier_versions(draft):
    by_word = {}
    for verdict in draft.verdicts:
        by_word.setdefault(verdict.verdict, set()).add(verdict.key)
    differ = {"case1.z", "case2.z", "case1.force_z", "case2.four_times", "kw4.spheroid.spin_xy", "kw4.synchronous"}
    differ |= {"kw4.period_order_5", "kw4.period_power", *(f"kw4.spin_{axis}" for axis in "xyz")}
    differ |= {f"kw4.{shape}.{name}" for shape in paper.YEAR for name in ("period", "inclination_period")}
    assert by_word["differs"] == differ
    # A draft stops short of t = 2200.
    assert by_word["open"] == {
        *("case1.rotational", "case1.rise", "kw4.between_states", "kw4.similar_spin", "kw4.shape_e"),
        *("case1.z_long", "case1.xy_long"),
    }
    assert {key.rpartition(".")[2] for key in by_word["faster"]} == {"cpu"}


def test_claims_in_words_have_an_interpretation(draft):
    compared = {"larger for spheroids", "longer for spheroids", "longer for ellipsoids", "below 0.03", "synchronous"}
    for verdict in draft.verdicts:
        number = re.match(r"[\[<\d]", verdict.printed) and not re.search("[a-z]{4}", verdict.printed)
        if verdict.verdict in ("holds", "differs") and not number:
            assert bool(verdict.interpretation) != (verdict.printed in compared), verdict


@pytest.mark.parametrize("key", ["case1.rotational", "case1.rise"])
def test_a_claim_that_a_threshold_would_decide_is_open(draft, key):
    (verdict,) = (verdict for verdict in draft.verdicts if verdict.key == key)
    assert verdict.verdict == "open"
    assert len(re.findall(r"\d+", verdict.computed)) == 6


def test_the_mean_periods_are_computed_with_both_values_of_g(draft, numbers):
    for shape, published in paper.YEAR.items():
        computed, other = (numbers["year"][run][shape]["period"] for run in ("surface", "other_g"))
        assert f"{other:.4f}" == f"{published.period:.4f}" != f"{computed:.4f}"
        stated, _ = fullbody.systems.kw4_ho2021(shape)
        system = fullbody.System(stated.bodies, G=6.674e-11 * 1e-9 * 3600**2)
        angles = {name: angle * 3.141592653589793 / 180 for name, angle in starts.SKY.items()}
        r, v = fullbody.KeplerElements(a=2.548, e=0.0004, M=0.0, **angles).to_cartesian(system.mu())
        _, start = fullbody.systems.kw4_ho2021(shape)
        start = start.replace(position=[[0, 0, 0], r], velocity=[[0, 0, 0], v])
        run = system.integrate(start, 8766.0, output=0.1, integrator=fullbody.Verner98(1e-10, 1e-10))
        assert other == pytest.approx(run.elements().period(system.mu()).mean(), abs=2e-6)
    (text,) = (
        " ".join(finding["text"]) for finding in numbers["findings"] if finding["title"] == "The mean period and G"
    )
    for value in ("6.67408e-11", "6.674e-11", "17.41159", "17.41771", "6.67397e-11 to 6.67403e-11"):
        assert value in text


def test_the_page_has_each_finding_once_as_in_the_numbers(draft, numbers):
    read = _Page()
    read.feed(draft.page.read_text(encoding="utf-8"))
    assert len(numbers["findings"]) == 8
    for finding in numbers["findings"]:
        for paragraph in finding["text"]:
            # The page has the paragraph with its numbers and symbols typeset.
            assert read.text.count(html.unescape(re.sub("<[^>]*>", "", typeset(paragraph)))) == 1
            assert not re.search(r"\b(nan|inf|None)\b|[{}]", paragraph)
    assert {verdict.finding for verdict in draft.verdicts} - {""} <= {
        finding["name"] for finding in numbers["findings"]
    }
    assert {source[1:] for source in read.sources if source.startswith("#")} <= set(read.names)


def test_equal_numbers_have_the_printed_digits(draft):
    equal = [verdict for verdict in draft.verdicts if verdict.verdict == "equal"]
    assert len(equal) == 8
    assert all(verdict.computed == verdict.printed for verdict in equal)


def test_the_kw4_command_and_the_report_have_the_same_numbers(numbers, tmp_path):
    assert kw4_year.main(["--out", str(tmp_path), "--gravity", "focal", "--quiet"]) == 0
    command = json.loads((tmp_path / "numbers.json").read_text())
    for shape in paper.YEAR:
        first, second = command[shape]["focal"], numbers["year"]["focal"][shape]
        for measured in (first, second):
            measured.pop("cpu_seconds")
        assert first == second


def test_statements_have_the_numbers_of_the_tables():
    assert paper.STATEMENTS["kw4.ellipsoid.a_min"].text == "2.5418"
    assert paper.STATEMENTS["kw4.spheroid.period"].text == "17.4177"
    assert paper.STATEMENTS["kw4.spin_z"].text == "[9.55, 11.16]"
    assert paper.STATEMENTS["kw4.ellipsoid.cpu"].text == "4.6 h"


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.sources, self.names, self.open, self.text = [], [], [], ""

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.sources += [values[name] for name in ("src", "href") if name in values]
        self.names += [values["id"]] if "id" in values else []
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


def test_figures_are_written_as_png_and_pdf(draft):
    assert sorted({path.suffix for path in draft.figures}) == [".pdf", ".png"]
    assert all(path.stat().st_size > 5000 for path in draft.figures)
    assert not [path for path in draft.page.parent.rglob("*") if ".part" in path.name]


def test_a_file_as_out_is_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    with pytest.raises(InvalidInput, match=r"out is '.*file', a file; expected a folder"):
        write_report(file)
    assert file.read_text() == "mine"


def test_numbers_of_an_earlier_report_are_removed_first(tmp_path, monkeypatch):
    (tmp_path / "numbers.json").write_text("{}")

    def fails(**options):
        raise KeyboardInterrupt

    monkeypatch.setattr(page, "compute", fails)
    with pytest.raises(KeyboardInterrupt):
        write_report(tmp_path)
    assert [path.name for path in tmp_path.rglob("*")] == ["figures"]


def test_command_prints_the_verdicts(monkeypatch, capsys, draft, tmp_path):
    monkeypatch.setattr("reproduction.ho2021.__main__.write_report", lambda out, **options: draft)
    assert report(["--draft", "--out", str(tmp_path)]) == 0
    output = capsys.readouterr().out
    assert "8 equal" in output
    assert str(draft.page) in output


def test_the_command_reports_an_error(capsys, tmp_path):
    (tmp_path / "file").write_text("mine")
    assert report(["--out", str(tmp_path / "file")]) == 1
    assert "a file; expected a folder" in capsys.readouterr().err
