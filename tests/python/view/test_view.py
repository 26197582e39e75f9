"""The interactive view: one page that needs no network and shows the run's own numbers."""

import html
import re
import stat

import fullbody
import numpy as np
import pytest
from support import data_of, fetched, refused


@pytest.mark.parametrize("name", ["view.txt", "view", "view.html.gz"])
def test_views_are_saved_as_pages_alone(short_run, tmp_path, name):
    refused(rf"{name}'; expected a name that ends in one of \.html, \.htm", short_run.view().save_html, tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    for good in ("VIEW.HTML", "view.htm"):
        assert short_run.view().save_html(tmp_path / good).exists()


@pytest.mark.parametrize("until", [100.0, -100.0])
def test_views_have_at_most_the_requested_number_of_times_at_equal_steps(until):
    system, state = fullbody.systems.case1()
    _, arrays = data_of(system.integrate(state, until).view(samples=100).to_html())
    assert np.allclose(arrays["time"], np.linspace(0.0, until, 100), rtol=0, atol=1e-12)


def test_view_is_one_page_with_the_runs_numbers(kw4_run, tmp_path):
    path = kw4_run.view().save_html(tmp_path / "view.html")
    page = path.read_text(encoding="utf-8")
    assert fetched(page) == []
    assert stat.S_IMODE(path.stat().st_mode) & 0o444
    data, arrays = data_of(page)
    assert data["names"] == ["Alpha", "Beta"]
    assert data["surfaces"] == [
        [{"columns": np.diag(axes).ravel().tolist(), "position": [0.0] * 3}]
        for axes in ([0.7085, 0.6805, 0.5915], [0.2975, 0.225, 0.1715])
    ]
    assert (data["length"], data["unit"]) == ("km", "h")
    assert 500 < len(arrays["time"]) <= 1000
    # The samples, and others between them that make its paths smooth.
    samples = np.searchsorted(arrays["time"], kw4_run.time.value)
    assert np.array_equal(arrays["time"][samples], kw4_run.time.value)
    assert np.array_equal(np.unique(np.diff(samples)), [10 - 1])
    assert np.allclose(arrays["attitude"].reshape(-1, 2, 4)[samples], kw4_run.attitude, atol=1e-6)
    assert np.abs(np.diff(arrays["attitude"], axis=0)).max() < 2.0
    position = arrays["position"].reshape(-1, 2, 3)[samples].astype(float)
    relative = (kw4_run.position[:, 1] - kw4_run.position[:, 0]).value
    assert np.allclose(position[:, 1] - position[:, 0], relative, atol=1e-6)
    masses = kw4_run.system.masses.value
    assert np.allclose(np.einsum("n,knx->kx", masses / masses.sum(), position), 0.0, atol=1e-6)


def test_view_takes_no_more_samples_than_asked(kw4_run):
    _, arrays = data_of(kw4_run.view(samples=51).to_html())
    assert np.array_equal(arrays["time"], kw4_run.time.value[::2])
    refused("samples is 1; expected a whole number, 2 or more", lambda: kw4_run.view(samples=1))


def test_view_in_jupyter_is_the_same_page_in_a_frame(kw4_run):
    view = kw4_run.view()
    shown = view._repr_html_()
    assert html.unescape(re.search(r'srcdoc="([^"]*)"', shown)[1]) == view.to_html()
    assert 'sandbox="allow-scripts"' in shown
    assert repr(view).startswith("<view of Alpha and Beta, 901 times")


def test_names_of_bodies_are_escaped_in_the_page():
    name = '</script><b>"@DATA@"'
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name=name), fullbody.Body(fullbody.PointMass(), mass=0.1)]
    system = fullbody.System(bodies, G=1.0)
    run = system.integrate(fullbody.State([[0, 0, 0], [3, 0, 0]], [[0, 0, 0], [0, 0.6, 0]]), 1.0)
    page = run.view().to_html()
    assert page.count("</script>") == 1
    assert '<b>"' not in page.split("<script>")[0]
    data, _ = data_of(page)
    assert data["names"] == [name, "body 1"]
    assert data["surfaces"] == [[{"columns": np.eye(3).ravel().tolist(), "position": [0.0] * 3}], []]
