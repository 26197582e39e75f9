"""Progress of computations: bars, titles and functions of the caller."""

import io
import sys

import pytest
from fullbody.base.progress import Progress, over_time
from support import refused


def test_a_function_gets_what_is_reported():
    seen = []
    with Progress(lambda *report_arguments: seen.append(report_arguments)) as report:
        report(1, 3, "one of three")
        over_time(report)(5.0, -1.0, -7.0)
    assert seen == [(1, 3, "one of three"), (6.0, 12.0, "t = -1")]


@pytest.mark.parametrize("nothing", [None, False])
def test_nothing_is_reported_unless_asked_for(nothing):
    with Progress(nothing) as report:
        assert report is None
    assert over_time(None) is None


@pytest.mark.parametrize(("total", "part"), [(4, " 50%|"), (None, "0:00")])
def test_a_bar_shows_its_title_the_part_that_is_done_and_the_description(monkeypatch, total, part):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with Progress("a title") as report:
        report(1, total, "at first")
        report(2, total, "half way")
    last = sys.stderr.getvalue().split("\r")[-1]
    assert all(text in last for text in ("a title", part, "half way"))


def test_a_progress_that_is_no_title_or_function_is_refused():
    for wrong in (3, [], 0.5):
        refused(r"progress is .*; expected True or False, a title, or a function", lambda wrong=wrong: Progress(wrong))
