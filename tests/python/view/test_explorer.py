"""Sliders: what they are for a setup, what they answer, and the lines of Python that make the run again."""

import base64

import astropy.units as u
import fullbody
import numpy as np
import pytest
from support import refused

pytest.importorskip("anywidget")


class Page:
    """A browser's end of the widget: keeps the answers to its messages."""

    def __init__(self, explorer):
        self.explorer, self.answers = explorer, []

    def send(self, answer):
        self.answers.append(answer)

    def request(self, what, **values):
        self.explorer._answer(self, {"id": len(self.answers), "ask": what, "values": values}, [])
        return self.answers[-1]


def numbers(text):
    return np.frombuffer(base64.b64decode(text), "<f8")


def pair(e=0.1, distance=10.0):
    """Two spheres on a Kepler orbit of this eccentricity, at their least distance."""
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name=name) for name in "AB"]
    system = fullbody.System(bodies, G=1.0)
    speed = np.sqrt(2.0 * (1.0 + e) / distance)
    x, v = np.array([[-0.5, 0, 0], [0.5, 0, 0]]), np.array([[0, -0.5, 0], [0, 0.5, 0]])
    return system, fullbody.State(position=distance * x, velocity=speed * v)


def test_a_slider_moves_the_run_and_its_curves():
    curves = ["separation", "eccentricity", lambda run: run.time**2]
    explorer = fullbody.explore(pair, {"e": (0.0, 0.5)}, 400.0, show=curves)
    page = Page(explorer)
    control = {"name": "e", "label": "e", "min": 0.0, "max": 0.5, "value": 0.1, "unit": ""}
    assert page.request("start")["controls"] == [control]
    result = page.request("run", e=0.3)["result"]
    separation, eccentricity, square = (numbers(curve["values"]) for curve in result["curves"])
    assert np.allclose(eccentricity, 0.3, rtol=1e-9)
    assert np.isclose(separation.max() / separation.min(), 1.3 / 0.7, rtol=1e-4)
    assert np.array_equal(square, numbers(result["time"]) ** 2)
    assert explorer.values == {"e": 0.3}
    assert explorer.run.time[-1] == 400.0


@pytest.mark.parametrize("values", [{"e": 2.0, "distance": 1.0}, {"e": -5.0}])
def test_an_error_of_the_setup_is_shown_and_the_last_run_stays(values):
    explorer = fullbody.explore(pair, {"e": (0.0, 0.5), "distance": (5.0, 20.0)}, duration=10.0)
    page, previous = Page(explorer), explorer.run
    answer = page.request("run", **{"e": 0.1, "distance": 10.0} | values)
    assert answer["error"]
    assert "result" not in answer
    assert explorer.run is previous
    assert explorer.values == {"e": 0.1, "distance": 10.0}


def test_a_run_that_ends_in_a_collision_is_shown_with_its_reason():
    explorer = fullbody.explore(pair, {"e": (-0.95, 0.5)}, 400.0)
    result = Page(explorer).request("run", e=-0.9)["result"]
    assert "touch" in result["notice"] or "overlap" in result["notice"]
    assert 0.0 < numbers(result["time"])[-1] < 400.0


def test_ranges_have_units_and_the_code_reproduces_the_run():
    def didymos_after_dart(tilt):
        return fullbody.systems.didymos_after_dart(units=True, tilt=tilt)

    explorer = fullbody.explore(didymos_after_dart, {"tilt": (0 * u.deg, 90 * u.deg, 30 * u.deg)}, duration=30 * u.h)
    assert explorer.values == {"tilt": 30 * u.deg}
    names = {"didymos_after_dart": didymos_after_dart}
    exec(explorer.code(), names)
    assert np.array_equal(names["run"].position[-1], explorer.run.position[-1])
    assert np.isclose(fullbody.observables.obliquity(names["run"])[0].to_value("deg"), 30.0)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"parameters": {"e": 0.1}}, r"the range of e is 0\.1; expected \(lowest, highest\)"),
        ({"parameters": {"e": (0.3, 0.1)}}, r"the range of e is \(0\.3, 0\.1\)"),
        ({"parameters": {"e": (0.0, 0.5, 0.7)}}, r"the range of e is \(0\.0, 0\.5, 0\.7\)"),
        ({"parameters": {"e": (0.0, np.nan)}}, r"the range of e is nan"),
        ({"parameters": ["e"]}, r"parameters is \['e'\]; expected a dict"),
        ({"parameters": {"e": "ab"}}, "the range of e is 'a'; expected a finite number"),
        ({"parameters": {"e": (0.0 * u.km, 1.0)}}, r"the range of e is .*, all with units or none"),
        ({"parameters": {"e": (0.0 * u.km, 1.0 * u.s)}}, "the range of e has the unit s; expected a unit such as km"),
        ({"setup": None}, "setup is None; expected a function of the parameters"),
        ({"setup": lambda e: e}, r"the setup gives 0\.25; expected \(system, state\)"),
        ({"show": "separation"}, "show is 'separation'; expected a list of curves"),
        ({"show": [3]}, "show has 3; expected a function of a run"),
        ({"show": [lambda run: ["x"] * 1000]}, "the curve <lambda> is 'x'; expected numbers"),
        ({"show": ["seperation"]}, r"show has 'seperation'; expected a function of a run, or one of separation, "),
        ({"show": [lambda run: 1.0]}, r"the curve <lambda> has shape \(\); expected \(1000,\)"),
        ({"show": ["light curve"]}, "geometry is None; expected a Geometry"),
        ({"geometry": 3}, "geometry is 3; expected an observing.Geometry"),
        ({"samples": 1}, "samples is 1; expected a whole number from 2"),
        ({"until": None}, "neither until nor duration are given"),
    ],
)
def test_bad_arguments_of_the_explorer_are_refused(options, expected):
    refused(expected, fullbody.explore, **{"setup": pair, "parameters": {"e": (0.0, 0.5)}, "until": 10.0} | options)


def test_a_notebook_without_a_kernel_shows_the_scene():
    bundle = fullbody.explore(pair, {"e": (0.0, 0.5)}, 10.0)._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "application/vnd.jupyter.widget-view+json" in data
    assert "<iframe" in data["text/html"]
    assert data["text/plain"] == "<explorer of e; shown in Jupyter>"
