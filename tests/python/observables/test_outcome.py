"""Fates and drifts of runs, and the tables of observables, against closed forms and setups with known results."""

import fullbody
import numpy as np
import pytest
from fullbody import State, events
from fullbody.errors import BodiesOverlap
from fullbody.observables import Drift, Fate, drift, fate, libration, mean_elements, mutual_period, tumbles
from support import body_list, points, refused


def spheres(distance, speed, across, radius=1.0, units=None):
    """Two equal spheres with G M = 1 for both together, and their relative motion."""
    bodies = [fullbody.Body(fullbody.Sphere(radius), mass=0.5, name=name) for name in "AB"]
    system = fullbody.System(bodies, G=1.0, units=units)
    return system, State([[0, 0, 0], [distance, 0, 0]], [[0, 0, 0], [speed, across, 0]])


def answer(member, until, **options):
    run = fullbody.integrate_many([member], until, **options)[0]
    return getattr(run, "run", None) or run


def fall(start, end, speed, mu=1.0):
    """The time of a radial way with a speed at its start, by quadrature."""
    r = np.linspace(start, end, 20001)
    return abs(np.trapezoid(1.0 / np.sqrt(speed**2 + 2 * mu * (1 / r - 1 / start)), r))


@pytest.mark.parametrize("watched", [(), [events.Contact(terminal=True)], [events.Contact("A", "B")]])
@pytest.mark.parametrize("output", ["ends", 1.0])
def test_contact_follows_from_the_error_or_an_event(watched, output):
    result = fate(answer(spheres(6.0, -0.5, 0.0), 20.0, output=output, events=watched))
    assert result.kind == "contact"
    assert result.time == pytest.approx(fall(6.0, 2.0, 0.5), rel=1e-7)
    assert result.as_dict() == {"fate": result.kind, "fate_time": result.time}


def test_contact_with_another_body_names_it():
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=0.2, name=name) for name in "ABC"]
    system = fullbody.System(bodies, G=1.0)
    state = State([[0, 0, 0], [10, 0, 0], [20, 0, 0]], [[0, 0, 0], [0, 0, 0], [-2.0, 0, 0]])
    with pytest.raises(BodiesOverlap) as caught:
        system.integrate(state, 10.0)
    run = caught.value.run
    assert type(run.error) is BodiesOverlap
    assert str(run.error) == str(caught.value)
    assert run.error.run is None
    assert run[1:].error is run.error
    for body, about in ((1, 0), (2, 0), ("C", "B")):
        assert fate(run, body=body, about=about) == Fate("contact", run.error.time)
    # A hit C and B; the first one goes on as it was until the run ends.
    assert fate(run, body="A", about="B").kind == "unfinished"


def test_separating_bodies_have_no_contact():
    apart = events.Contact(direction=1)
    result = fate(answer(spheres(2.0 + 1e-9, 0.1, 1.1), 10.0, output=0.5, events=[apart]))
    assert result == Fate("bound", 10.0)


@pytest.mark.parametrize("speed", [0.9, 1.1])
def test_the_speed_of_escape_separates_escape_from_bound(speed):
    # At distance 50 the speed of escape is 1/5; the default distance is 40.
    member = spheres(30.0, speed * np.sqrt(2 / 30.0), 0.0)
    result = fate(answer(member, 200.0, output=0.5))
    if speed < 1.0:
        assert result == Fate("bound", 200.0)
    else:
        # The first sample beyond.
        time = fall(30.0, 40.0, speed * np.sqrt(2 / 30.0))
        assert result.kind == "escape"
        assert 0.0 <= result.time - time <= 0.5
    # The event has the moment itself, and another distance.
    escape = events.Escape(distance=35.0, terminal=True)
    result = fate(answer(member, 200.0, output="ends", events=[escape]))
    assert result.kind == ("bound" if speed < 1.0 else "escape")
    if speed > 1.0:
        assert result.time == pytest.approx(fall(30.0, 35.0, speed * np.sqrt(2 / 30.0)), rel=1e-7)
        assert fate(answer(member, 200.0, output=0.5), beyond=1e3).kind == "bound"


def test_fates_have_units():
    u = pytest.importorskip("astropy.units")
    member = spheres(6.0, -0.5, 0.0, units=("km", "hour", "kg"))
    result = fate(answer(member, 20.0, output=1.0))
    assert result.time.to_value(u.hour) == pytest.approx(fall(6.0, 2.0, 0.5), rel=1e-7)
    escaping = spheres(30.0, 1.0, 0.0, units=("km", "hour", "kg"))
    assert fate(answer(escaping, 20.0, output=1.0), beyond=32e3 * u.m).time == 3 * u.hour


def test_a_fate_without_samples_is_refused():
    run = answer(spheres(6.0, 0.0, 0.4), 1.0, output=[])
    refused("no samples", lambda: fate(run))
    refused("body and about are 1 and 1, both", lambda: fate(run, about=1))
    refused("beyond is 0.0; expected a finite number above zero", lambda: fate(run, beyond=0.0))
    for measure in (fate, drift):
        refused(r"is a ValueError; expected a fullbody\.Run", measure, ValueError("in the place of a run"))
    assert drift(run) == Drift(None, None, None)
    # The function fails at time 3; the run ends with the last step before that.
    failing = events.Function(lambda state: 1.0 if state.time < 3.0 else None)
    result = fate(answer(spheres(6.0, 0.0, 0.4), 10.0, output=1.0, events=[failing]))
    assert result.kind == "unfinished"
    assert 2.0 < result.time < 3.0


def turning(rate):
    """A light triaxial moon on a circular orbit of n = 1 that rolls about its long axis, which points at the planet."""
    bodies = body_list(planet=(fullbody.Sphere(0.05), 1.0), moon=(fullbody.Ellipsoid(0.02, 0.017, 0.014), 1e-9))
    system = fullbody.System(bodies, G=1.0)
    state = State([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0]], spin=[[0, 0, 0], [rate, 0, 1]])
    return system, state


def test_a_full_roll_is_tumbling():
    run = answer(turning(12.0), 1.0, output=0.02)
    result = tumbles(run).as_dict()
    # The angle about the axis, to the first order in n over the rate.
    assert result["tumbling_time"] == pytest.approx(np.pi / 2 / 12, rel=0.05)
    assert (result["tumbles"], result["largest_roll"]) == (1.0, np.pi)
    assert abs(tumbles(run).largest[0] - 12.0) < 1.5
    quiet = tumbles(answer(turning(0.0), 20.0, output=0.2)).as_dict()
    assert (quiet["tumbles"], quiet["tumbling_time"]) == (0.0, None)
    assert max(quiet[f"largest_{name}"] for name in ("roll", "pitch", "yaw")) < 1e-2
    some = tumbles(run[:5], limit=np.radians(40))
    assert some.as_dict()["largest_roll"] == np.abs(some.largest[0]) < np.pi


def test_libration_has_the_frequency_of_the_linear_theory():
    # The frequency is w^2 = 3 n^2 (B - A)/C.
    system, state = turning(0.0)
    run = answer((system, state.rotated(1, [0, 0, 1], 0.05)), 60.0, output=0.1)
    result = libration(run).as_dict()
    a, b = 0.02, 0.017
    w = np.sqrt(3 * (a * a - b * b) / (a * a + b * b))
    # The moon's figure makes the start a little eccentric, which forces some more.
    assert result["libration"] == pytest.approx(0.05, rel=2e-2)
    assert result["libration_period"] == pytest.approx(2 * np.pi / w, rel=2e-3)
    rotating = libration(answer((system, state.replace(spin=[[0, 0, 0], [0, 0, 4.0]])), 20.0, output=0.1))
    assert rotating.as_dict() == {"libration": None, "libration_period": None}


@pytest.mark.parametrize("units", [False, True])
def test_means_of_a_kepler_orbit_are_its_elements(units):
    system = points(0.7, 0.3, units=("km", "hour", "kg") if units else None)
    elements = fullbody.KeplerElements(a=2.0, e=0.3, i=0.4, Omega=0.5, omega=0.6, M=0.0)
    r, v = elements.to_cartesian(1.0)
    run = answer((system, State([np.zeros(3), r], [np.zeros(3), v])), 200.0, output=0.5)
    result = mutual_period(run).as_dict() | mean_elements(run).as_dict()
    value = {name: getattr(number, "value", number) for name, number in result.items()}
    assert value["period"] == pytest.approx(2 * np.pi * 2.0**1.5, rel=1e-6)
    assert [value[name] for name in "aei"] == pytest.approx([2.0, 0.3, 0.4], rel=1e-10)
    assert hasattr(result["period"], "unit") == units


def test_means_do_not_depend_on_the_end_of_the_run():
    # The elements of the paper's KW4 swing; half a revolution more changes plain means a hundred times as much.
    system, state = fullbody.systems.kw4_ho2021()
    reference = system.integrate(state, 20 * 17.41, output=0.5)
    less = system.integrate(state, 19.5 * 17.41, output=0.5)
    means = (lambda run: run.elements().a.mean(), lambda run: mean_elements(run).a)
    unweighted, windowed = (abs(mean(reference) / mean(less) - 1) for mean in means)
    assert windowed < unweighted / 3


def test_drifts_are_the_largest_of_the_run():
    system, state = fullbody.systems.case1()
    run = system.integrate(state, 100.0, output=1.0, integrator=fullbody.DormandPrince54(1e-5))
    for name, value in drift(run).as_dict().items():
        assert value == np.abs(getattr(run, name)).max() > 1e-9


def test_fates_and_drifts_are_measures_of_a_sweep():
    pytest.importorskip("xarray")

    def setup(across):
        return spheres(6.0, 0.0, across)

    result = fullbody.sweep(setup, {"across": [0.05, 0.4, 2.0]}, 60.0, measure=["fate", "drift"], output=1.0)
    assert result.fate.values.tolist() == ["contact", "bound", "escape"]
    assert result.error.values.tolist() == ["BodiesOverlap", "", ""]
    assert (result.energy_drift < 1e-11).all()
