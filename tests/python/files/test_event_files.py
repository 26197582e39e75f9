"""Events and stop reasons come back from files as they were."""

import fullbody
import numpy as np
import pytest
import xarray as xr
from astropy import units as u
from fullbody import events, loading
from fullbody.errors import BodiesOverlap, InvalidInput
from fullbody.files import reading
from support import refused


def distance_from_usual(state):
    return np.linalg.norm(state.position[1] - state.position[0]) - 2.54


@pytest.fixture(scope="module")
def eventful():
    """A run without units with events of many kinds, some of them twice."""
    system, state = fullbody.systems.kw4_ho2021()
    watched = [
        events.Separation(0, 1, 2.545, direction=-1),
        events.Separation(0, 1, 2.545, direction=1),
        events.Periapsis(0, 1),
        events.Apoapsis(0, 1),
        events.PlaneCrossing(1, None, (1.0, 0.5, 0.0)),
        events.PlaneCrossing(0, 1, np.array([0.0, 1.0, 0.0]), direction=1),
        events.Alignment(1, 0),
        events.Function(distance_from_usual),
    ]
    run = system.integrate(state, 100.0, output=50.0, events=watched)
    assert {type(happened.event) for happened in run.events} == {type(event) for event in watched}
    return run


def test_every_bit_of_every_event_comes_back(eventful, tmp_path):
    eventful.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert len(again.events) == len(eventful.events) > 20
    for old, new in zip(eventful.events, again.events, strict=True):
        assert new.time == old.time
        assert new.state == old.state
        assert type(new.event) is type(old.event)
        for name in vars(old.event):
            if name != "f":
                assert np.array_equal(getattr(new.event, name), getattr(old.event, name)), name
    # One event that happened often is one object, as in the run that was saved.
    assert len({id(happened.event) for happened in again.events}) == 8
    # A file of a loaded run holds the same.
    again.save(tmp_path / "again.nc")
    assert xr.open_dataset(tmp_path / "again.nc").load().identical(xr.open_dataset(tmp_path / "run.nc").load())


def test_a_function_leaves_its_name(eventful, tmp_path):
    eventful.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    (event,) = {happened.event for happened in again.events if isinstance(happened.event, events.Function)}
    assert "distance_from_usual" in repr(event)
    with pytest.raises(InvalidInput, match="the function distance_from_usual is not in the file"):
        again.system.integrate(again[0], 1.0, events=[event])
    events_of_classes = [happened.event for happened in again.events if not isinstance(happened.event, events.Function)]
    assert again.system.integrate(again[0], 100.0, events=events_of_classes).stop_reason == "end"


def test_parameters_keep_the_unit_they_were_given_in(tmp_path):
    system, state = fullbody.systems.kw4(units=True)
    event = events.Separation(0, 1, 2557 * u.m, direction=np.int64(1))
    run = system.integrate(state, 90 * u.h, events=[event, events.Escape(0, 1, 1 * u.km)])
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again.events[0].event == events.Separation(0, 1, 2557 * u.m, direction=1)
    assert again.events[0].event.value.unit == u.m
    assert again.events[0].time == run.events[0].time
    assert again.events[0].time.unit == u.h
    assert again.events[0].state == run.events[0].state


def test_other_programs_read_the_times(tmp_path):
    # The orbit starts at apoapsis: its periapses follow after half a period and whole ones.
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (0.75, 0.25)]
    a, e = 2.0, 0.5
    fast = np.sqrt((1 - e) / (1 + e) / a)
    state = fullbody.State([[0, 0, 0], [a * (1 + e), 0, 0]], [[0, 0, 0], [0, fast, 0]])
    system = fullbody.System(bodies, G=1.0)
    system.integrate(state, 50.0, output=[50.0], events=[events.Periapsis(0, 1)]).save(tmp_path / "run.nc")
    data = xr.open_dataset(tmp_path / "run.nc")
    assert data.event.values.tolist() == ["Periapsis"] * 3
    period = 2 * np.pi * np.sqrt(a**3)
    assert np.allclose(data.event_time, period * np.array([0.5, 1.5, 2.5]), rtol=1e-11)
    relative = data.event_position.isel(body=1) - data.event_position.isel(body=0)
    assert np.allclose(relative.sel(axis="x"), -a * (1 - e), rtol=1e-11)
    assert "event_time" in data.coords


def test_stop_reasons_are_kept(tmp_path):
    system, state = fullbody.systems.case1()
    ended = system.integrate(state, 60.0, events=[events.Separation(0, 1, 7.9, terminal=True)])
    ended.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again.stop_reason == "event"
    assert again.events[-1].event.terminal is True
    assert again.events[-1].time == again.time[-1]
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)] * 2, G=1.0)
    with pytest.raises(BodiesOverlap) as caught:
        system.integrate(fullbody.State([[0, 0, 0], [5, 0, 0]], np.zeros((2, 3))), 100.0)
    caught.value.run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc") == caught.value.run
    assert caught.value.run.stop_reason == "unfinished"


def test_a_run_without_events_has_no_room_for_them(case1_run):
    assert not [name for name in case1_run.to_xarray().variables if str(name).startswith("event")]


def test_damaged_events_are_named(eventful):
    dataset = eventful.to_xarray()
    for change, message in (
        (("Apoapsis", "Aphelion"), "event is 'Aphelion'; expected one of Alignment, "),
        (('"direction": -1', '"direction": 7'), "direction of Separation is 7; expected -1, 0 or 1"),
        (("]", ""), "JSON|delimiter"),
    ):
        content = reading.Content(
            dataset.assign_attrs(fullbody_events=dataset.attrs["fullbody_events"].replace(*change))
        )
        refused(message, lambda content=content: loading.run_in(content))
    refused("has no .*event_spin", lambda: loading.run_in(reading.Content(dataset.drop_vars("event_spin"))))
