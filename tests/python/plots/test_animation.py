"""Animations are valid files that need no network and show the run's own numbers."""

import base64
import re
import shutil

import fullbody
import numpy as np
import pytest
from PIL import Image
from support import fetched, refused

SMALL = {"seconds": 0.5, "fps": 10, "size": (3.01, 2.53), "dpi": 50}


def test_a_gif_has_frames_at_equal_steps_of_time(short_run, tmp_path):
    path = short_run.animate(tmp_path / "film.gif", **SMALL)
    with Image.open(path) as film:
        assert (film.format, film.n_frames, film.size) == ("GIF", 5, (150, 126))
        film.seek(0)
        first = np.asarray(film.convert("RGB"), dtype=int)
        film.seek(3)
        assert np.abs(np.asarray(film.convert("RGB"), dtype=int) - first).max() > 50
    assert [p.name for p in tmp_path.iterdir()] == ["film.gif"]


def test_an_html_animation_needs_no_network_and_shows_times_between_samples(short_run, tmp_path):
    page = short_run[:3:2].animate(tmp_path / "film.html", **SMALL).read_text()
    assert fetched(page) == []
    assert "fa-" not in page
    frames = re.findall(r'frames\[\d+\] = "data:image/png;base64,([^"]*)"', page)
    assert len(set(frames)) == len(frames) == 5
    assert all(base64.b64decode(frame.replace("\\\n", "")).startswith(b"\x89PNG") for frame in frames)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_an_mp4_is_written(short_run, tmp_path):
    content = short_run.animate(tmp_path / "film.mp4", **SMALL).read_bytes()
    assert content[4:8] == b"ftyp"
    assert len(content) > 1000


def test_the_error_of_a_missing_ffmpeg_names_other_formats(short_run, tmp_path, monkeypatch):
    from matplotlib import animation

    monkeypatch.setattr(animation.writers, "is_available", lambda name: False)
    with pytest.raises(fullbody.FullbodyError, match=r"needs the program ffmpeg.*write \.gif or \.html"):
        short_run.animate(tmp_path / "film.mp4")


def test_the_error_of_ffmpeg_on_a_full_disk_names_the_file(short_run, tmp_path, monkeypatch):
    import matplotlib

    program = tmp_path / "ffmpeg"
    # Half a film, and the words of the real one.
    fails = 'echo "Error writing trailer of $last: No space left on device" >&2\nexit 228\n'
    program.write_text('#!/bin/sh\nfor last; do :; done\nhead -c 1000 > "$last"\n' + fails)
    program.chmod(0o755)
    monkeypatch.setitem(matplotlib.rcParams, "animation.ffmpeg_path", str(program))
    path = tmp_path / "film.mp4"
    with pytest.raises(OSError, match=r"cannot be written; ffmpeg ended with: .*No space left on device") as caught:
        short_run.animate(path, **SMALL)
    assert str(caught.value).count(str(path)) == 2
    assert ".part" not in str(caught.value)
    assert list(tmp_path.iterdir()) == [program]


def test_bad_arguments_of_animations_are_refused(short_run, tmp_path):
    refused(r"ends in one of \.mp4, \.gif, \.html", lambda: short_run.animate(tmp_path / "film.avi"))
    refused("seconds is -1; expected a finite number above zero", short_run.animate, tmp_path / "film.gif", seconds=-1)
    refused("fps is 0; expected a whole number above zero", lambda: short_run.animate(tmp_path / "film.gif", fps=0))
    with pytest.raises(FileNotFoundError, match="no folder"):
        short_run.animate(tmp_path / "nowhere" / "film.gif")
    inches = r"size is .*; expected \(width, height\) in inches"
    for size in (3, "big", (3.0,), (1, 2, 3), (0.0, 2.0), (np.nan, 2.0), (2.0, np.inf), ("a", "b")):
        refused(inches, short_run.animate, tmp_path / "film.gif", size=size)
    for dpi in (np.nan, np.inf, 0.0, -100, "fine", None, (100, 100)):
        refused("dpi is .*; expected a finite number above zero", short_run.animate, tmp_path / "film.gif", dpi=dpi)
    for size, dpi in (((2.0, 3.0), 0.4), ((2.0, 3.0), 1e5), ((1e9, 1e9), 100)):
        refused("size is .* and dpi is .*; expected 1 to", short_run.animate, tmp_path / "film.gif", size=size, dpi=dpi)
    assert list(tmp_path.iterdir()) == []


def test_a_failing_animation_leaves_the_old_file(short_run, tmp_path, monkeypatch):
    path = tmp_path / "film.gif"
    path.write_text("old")
    monkeypatch.setattr("matplotlib.animation.PillowWriter.finish", lambda self: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        short_run.animate(path, **SMALL)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_pictures_too_far_apart_in_time_cause_a_warning(short_run, tmp_path):
    # Alpha turns in 2.76 h: samples half an hour apart show it, samples 1.5 h apart do not.
    system, state = fullbody.systems.kw4()
    run = system.integrate(state, 9.0, output=1.5)
    with pytest.warns(UserWarning, match=r"Alpha makes up to 0\.54 turns between two samples"):
        run.view()
    run = system.integrate(state, 9.0, output=1.5, dense=True)
    short_run.view()
    run.view()
    # Six hours apart.
    with pytest.warns(UserWarning, match=r"Alpha makes up to 2\.2 turns between two pictures"):
        system.integrate(state, 6.0, dense=True).animate(tmp_path / "a.gif", seconds=0.2, fps=10, size=(1, 1), dpi=20)
