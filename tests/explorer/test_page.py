"""The page in a headless Chromium: it shows the numbers of Python's runs, also after a slider has been dragged.

``make test-explorer`` builds the page and runs these tests, and writes pictures of it into out/explorer-pictures.
"""

import functools
import http.server
import os
import shutil
import threading
from pathlib import Path

import fullbody
import numpy as np
import pytest
from playwright.sync_api import sync_playwright

PAGE = Path(__file__).parents[2] / "out" / "explorer"
PICTURES = PAGE.with_name("explorer-pictures")
#: Stores the newest result of the explorer, with lists instead of typed arrays, which Playwright does not return.
STORE = """() => document.getElementById("explorer").addEventListener("fullbody-result", ({ detail }) => {
  const curves = Object.fromEntries(detail.curves.map(({ label, values }) => [label, Array.from(values)]));
  window.newest = { values: detail.values, time: Array.from(detail.time), notice: detail.notice, curves };
})"""
IDLE = "() => document.getElementById('explorer').getAttribute('aria-busy') === 'false' && window.newest"


@pytest.fixture(scope="module")
def address():
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=PAGE)
    handler.func.log_message = lambda *_: None
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def browser():
    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    flags = [
        "--no-sandbox",
        "--disable-gpu",
        "--disable-background-networking",
        "--use-gl=angle",
        "--use-angle=swiftshader",
    ]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=[*flags, "--enable-unsafe-swiftshader"])
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser):
    page = browser.new_page(viewport={"width": 1200, "height": 1100})
    page.faults = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    yield page
    assert page.faults == []
    page.close()


def open_page(page, address):
    """Open the page; return its first result."""
    page.goto("about:blank")
    page.goto(address)
    page.wait_for_selector("#explorer canvas")
    page.evaluate(STORE)
    page.evaluate(
        "() => document.getElementById('reset').click()"
        if "#" not in address
        else "() => dispatchEvent(new Event('hashchange'))"
    )
    page.wait_for_function(IDLE, timeout=60_000)
    return page.evaluate("window.newest")


def drag_slider(page, name, value):
    """Drag a slider to a value; return the result."""
    page.evaluate("window.newest = null")
    page.evaluate(
        """([name, value]) => {
          const slider = document.querySelector(`input[type=range][name="${name}"]`);
          for (const part of [0.2, 0.6, 1]) {
            slider.value = +slider.defaultValue + part * (value - slider.defaultValue);
            if (part === 1) slider.value = value;
            slider.dispatchEvent(new Event("input"));
          }
        }""",
        [name, value],
    )
    page.wait_for_function(IDLE, timeout=60_000)
    return page.evaluate("window.newest")


def python_run(page):
    """Run the lines of Python that the page offers."""
    page.click(".fullbody-copy")
    page.wait_for_selector(".fullbody-code:not([hidden])")
    names = {}
    exec(page.inner_text(".fullbody-code"), names)
    return names["run"]


def check_numbers(result, run, body=1):
    """Check the curves of a result against the observables of a run of Python."""
    relative = run.position[:, body] - run.position[:, 0]
    curves = {name: np.array(values) for name, values in result["curves"].items()}
    assert np.allclose(result["time"], run.time, rtol=1e-14)
    assert np.allclose(curves["separation"], np.linalg.norm(relative, axis=1), rtol=1e-12)
    assert np.allclose(curves["semi-major axis"], run.elements().a, rtol=1e-11)
    assert np.allclose(curves["eccentricity"], run.elements().e, atol=1e-11)
    angles = np.degrees(fullbody.observables.roll_pitch_yaw(run))
    for k, name in enumerate(("roll", "pitch", "libration")):
        assert np.allclose(curves[name], angles[:, k], atol=1e-8)
    assert np.abs(curves["energy drift"]).max() < 1e-12


def test_1999_kw4_over_200_hours_has_the_numbers_of_python(page, address):
    result = open_page(page, address + "#system=kw4&duration=200")
    run = python_run(page)
    assert run.time[-1] == 200.0
    check_numbers(result, run)
    # The page's observer and Sun stand in the first orbit's plane, ten degrees apart.
    toward = [np.array([np.cos(angle), np.sin(angle), 0.0]) for angle in (0.0, np.radians(10.0))]
    light = [fullbody.observing.brightness(run.system, run[k], *toward).sum() for k in range(0, len(run), 50)]
    expected = -2.5 * np.log10(light)
    assert np.allclose(np.diff(result["curves"]["light curve"][::50]), np.diff(expected), atol=1e-9)


def test_a_dragged_slider_shows_the_run_of_python_with_its_value(page, address):
    open_page(page, address + "#system=kw4&duration=50")
    result = drag_slider(page, "e of Beta", 0.2)
    assert result["values"]["e of Beta"] == 0.2
    check_numbers(result, python_run(page))
    result = drag_slider(page, "semi-axis a of Beta", 0.31)
    result = drag_slider(page, "tilt of Beta", 20.0)
    run = python_run(page)
    assert np.isclose(run.system.bodies[1].shape.a, 0.31)
    check_numbers(result, run)
    page.screenshot(path=PICTURES / "kw4.png", full_page=True)


def test_an_impact_shortens_the_period_of_dimorphos_as_observed(page, address):
    """The momentum enhancement of Cheng et al. (2023), 3.61, corresponds to a period shorter by half an hour."""
    open_page(page, address + "#system=didymos&duration=100")
    initial = np.array(page.evaluate("window.newest")["curves"]["semi-major axis"]).mean()
    result = drag_slider(page, "beta", 3.61)
    changed = np.array(result["curves"]["semi-major axis"]).mean()
    assert np.isclose(11.92 * (1.0 - (changed / initial) ** 1.5), 0.55, atol=0.08)
    check_numbers(result, python_run(page))


def test_a_refused_value_has_its_error_beside_the_slider_and_keeps_the_run(page, address):
    open_page(page, address + "#system=kw4&duration=20")
    page.evaluate("window.previous = window.newest")
    page.evaluate(
        """() => {
          const number = document.querySelector('input[name="semi-axis a of Beta"]').nextSibling;
          number.value = -1;
          number.dispatchEvent(new Event("change"));
        }"""
    )
    page.wait_for_function(
        "() => document.querySelector('input[name=\"semi-axis a of Beta\"]').nextSibling.nextSibling.textContent"
    )
    assert page.evaluate("window.newest === window.previous")
    text = page.evaluate(
        "document.querySelector('input[name=\"semi-axis a of Beta\"]').nextSibling.nextSibling.textContent"
    )
    assert "semi-axis" in text


def test_a_contact_ends_the_run_with_a_notice(page, address):
    open_page(page, address + "#system=kw4&duration=50")
    drag_slider(page, "M of Beta", 180.0)
    result = drag_slider(page, "e of Beta", 0.75)
    assert "touch" in result["notice"] or "overlap" in result["notice"]
    assert result["time"][-1] < 50.0


def test_a_run_that_takes_too_long_ends_with_a_notice(page, address):
    result = open_page(page, address + "#system=haumea&duration=10000000")
    assert "after 5 seconds" in result["notice"]
    assert 0.0 < result["time"][-1] < 1e7


def test_every_system_runs_and_a_link_contains_its_values(page, address):
    open_page(page, address)
    first = page.evaluate("document.getElementById('system').value")
    assert first == "didymos_after_dart"
    for name in page.evaluate("[...document.getElementById('system').options].map(option => option.value)"):
        result = open_page(page, address + f"#system={name}")
        assert not result["notice"], name
        assert np.abs(result["curves"]["energy drift"]).max() < 1e-11, name
    result = open_page(page, address + "#system=kw4&duration=30&e+of+Beta=0.1")
    assert result["values"]["e of Beta"] == 0.1
    assert "e+of+Beta=0.1" in page.get_attribute("#link", "href")


def test_the_first_view_shows_dimorphos_beginning_to_roll(page, address):
    page.goto(address)
    page.wait_for_selector("#explorer canvas")
    page.evaluate(STORE)
    page.evaluate("() => dispatchEvent(new Event('hashchange'))")
    page.wait_for_function(IDLE, timeout=60_000)
    result = page.evaluate("window.newest")
    assert np.abs(result["curves"]["roll"]).max() > 30.0
    page.screenshot(path=PICTURES / "first.png", full_page=True)
    page.set_viewport_size({"width": 390, "height": 844})
    page.screenshot(path=PICTURES / "phone.png", full_page=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    heights = [page.locator(f".fullbody-{part}").bounding_box()["y"] for part in ("view", "controls", "curves")]
    assert heights == sorted(heights)


def test_the_widget_of_a_notebook_shows_the_runs_of_its_kernel(page):
    """The module runs in the browser, and its messages go to Python as the kernel of a notebook takes them."""

    class Kernel:
        def send(self, answer):
            self.answer = answer

    kernel = Kernel()
    explorer = fullbody.explore(fullbody.systems.didymos_after_dart, {"tilt": (0.0, 0.5)}, duration=50.0, show=["roll"])

    def answer(message):
        explorer._answer(kernel, message, [])
        return kernel.answer

    page.expose_function("answer", answer)
    page.set_content('<style></style><div id="explorer"></div>')
    page.evaluate(
        """async ([module, style]) => {
          document.querySelector("style").textContent = style;
          const widget = (await import(URL.createObjectURL(new Blob([module], { type: "text/javascript" })))).default;
          let hear;
          const model = {
            on: (_, take) => { hear = take; },
            off: () => {},
            send: message => window.answer(message).then(result => hear(result)),
          };
          const root = document.getElementById("explorer");
          root.addEventListener("fullbody-result", ({ detail }) => {
            window.newest = { values: detail.values, roll: Array.from(detail.curves[0].values) };
          });
          widget.render({ model, el: root });
        }""",
        [str(explorer._widget._esm), str(explorer._widget._css)],
    )
    page.wait_for_function(IDLE, timeout=60_000)
    assert page.evaluate("window.newest.values") == {"tilt": 0.0}
    result = drag_slider(page, "tilt", 0.3)
    assert result["values"] == {"tilt": 0.3}
    assert np.allclose(result["roll"], np.degrees(fullbody.observables.roll_pitch_yaw(explorer.run)[:, 0]))
    page.screenshot(path=PICTURES / "widget.png", full_page=True)
    page.evaluate("window.newest = null")
    slider = page.locator("input[type=range][name=tilt]")
    slider.focus()
    slider.press("ArrowLeft")
    page.wait_for_function(IDLE, timeout=60_000)
    assert np.isclose(explorer.values["tilt"], 0.295)


def test_the_scene_is_seen_from_the_observer_and_from_the_sun(page, address):
    open_page(page, address + "#system=kw4&duration=20")
    views = []
    for name in ("", "observer", "sun"):
        page.select_option(".fullbody-from", name)
        views.append(page.evaluate("document.querySelector('.fullbody-canvas').toDataURL()"))
    page.locator(".fullbody-view").screenshot(path=PICTURES / "from_the_sun.png")
    assert len(set(views)) == 3
