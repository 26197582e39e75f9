"""Jupyter shows objects as complete, short tables with escaped text."""

from xml.etree import ElementTree

import fullbody
import numpy as np
import pytest
from astropy import units as u


def cells(thing):
    """The cells of all tables; tags that do not match are refused."""
    page = ElementTree.fromstring(f"<x>{thing._repr_html_()}</x>")
    tags = {element.tag for element in page.iter()}
    assert tags <= {"x", "table", "caption", "b", "thead", "tbody", "tr", "th", "td"}
    return ["".join(element.itertext()) for element in page.iter() if element.tag in ("td", "th")]


def test_tables_of_bodies_are_complete():
    shown = cells(fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), density=1.5, name="egg"))
    assert {"3, 2, 1", f"{1.5 * 4 / 3 * np.pi * 6:.8g}"} <= set(shown)
    assert cells(fullbody.Body(fullbody.PointMass(), mass=2.0)) == ["shape", "PointMass", "mass", "2"]


def test_tables_of_systems_states_and_runs_are_complete(kw4_run):
    shown = cells(kw4_run.system)
    assert {"Alpha", "Beta", "0.2975, 0.225, 0.1715", "1.35e+11", "semi-axes [km]", "mass [kg]"} <= set(shown)
    state = cells(kw4_run[-1])
    assert "position [km]" in state
    last = kw4_run.position.value[-1, 1]
    assert "(" + ", ".join(f"{x:.6g}" for x in last) + ")" in state
    run = cells(kw4_run)
    assert {"101", "0 h to 50 h", f"{np.abs(kw4_run.energy_drift).max():.2e}"} <= set(run)


def test_tables_of_runs_show_events_and_the_stop_reason(case1_run):
    system, state = fullbody.systems.case1()
    # They are at 48.7 and 92.9.
    assert "2 Apoapsis" in cells(system.integrate(state, 100.0, events=[fullbody.events.Apoapsis(0, 1)]))
    run = system.integrate(state, 100.0, events=[fullbody.events.Apoapsis(0, 1, terminal=True)])
    shown = cells(run)
    assert shown[shown.index("events") + 1] == "1 Apoapsis"
    assert shown[shown.index("stopped") + 1] == "by the last event"
    assert {"events", "stopped"}.isdisjoint(cells(case1_run))


def test_tables_have_no_negative_zeros():
    shown = cells(fullbody.State([[-0.0, 0, 1]], [[0, -0.0, 0]]))
    assert "(0, 0, 1)" in shown
    assert not any("-0" in cell for cell in shown)


def test_tables_of_elements_hold_one_orbit_or_many_with_units(case1_run, kw4_run):
    single = fullbody.KeplerElements(a=2.0, e=0.5, i=np.pi / 6, Omega=0.0, omega=0.0, M=np.pi)
    expected = "a, 2, e, 0.5, i [deg], 30, Omega [deg], 0, omega [deg], 0, M [deg], 180"
    assert cells(single) == expected.split(", ")
    elements = case1_run.elements()
    table = cells(elements)
    assert table[:5] == ["", "first", "last", "least", "greatest"]
    e = elements.e
    assert table[table.index("e") + 1 :][:4] == [f"{x:.8g}" for x in (e[0], e[-1], e.min(), e.max())]
    with_units = kw4_run.elements()
    assert {"a [km]", "i [deg]", f"{np.rad2deg(with_units.i.value[-1]):.8g}"} <= set(cells(with_units))


@pytest.mark.parametrize("units", [False, True])
def test_tables_of_energies_and_interactions_are_complete(units):
    system, state = fullbody.systems.kw4(units=units)
    energy, interactions = system.energy(state), system.interactions(state)
    unit = f" {energy.total.unit}" if units else ""
    shown = cells(energy)
    for name in ("total", "translational", "rotational", "potential"):
        value = getattr(energy, name)
        assert shown[shown.index(name) + 1] == f"{getattr(value, 'value', value):.8g}{unit}"
    shown = cells(interactions)
    assert shown[:2] == ["body", f"force [{interactions.force.unit}]" if units else "force"]
    force = np.asarray(interactions.force)[1] + 0.0
    assert shown[shown.index("1") + 1] == "(" + ", ".join(f"{x:.6g}" for x in force) + ")"
    energy_value = float(getattr(interactions.potential_energy, "value", interactions.potential_energy))
    assert f"potential energy {energy_value:.8g}{unit}<" in interactions._repr_html_()


def test_tables_of_components_have_what_is_given_and_nothing_else():
    assert cells(fullbody.Component(diameter=2.0, axis_ratios=(1.2, 1.1), pole=(0.1, 0.2), name="a<b")) == [
        *("diameter", "2", "axis ratios", "1.2, 1.1", "pole", "0.1, 0.2")
    ]
    with_units = fullbody.Component(
        semi_axes=[3, 2, 1] * u.km, mass="2 kg", rotation_period=float("inf"), tilt=3 * u.deg
    )
    assert cells(with_units) == [
        *("semi axes", "3 km, 2 km, 1 km", "mass", "2 kg", "rotation period", "inf", "tilt", "3 deg")
    ]
    assert "a&lt;b" in fullbody.Component(diameter=2.0, name="a<b")._repr_html_()


def test_names_are_escaped():
    name = "<script>alert('x')</script>&"
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name=name), fullbody.Body(fullbody.PointMass(), mass=0.1)]
    system = fullbody.System(bodies, G=1.0)
    run = system.integrate(fullbody.State([[0, 0, 0], [3, 0, 0]], [[0, 0, 0], [0, 0.6, 0]]), 1.0)
    for thing in (bodies[0], system, run):
        assert "<script" not in thing._repr_html_()
    assert name in cells(system)


def test_tables_of_short_runs_are_complete(kw4_run):
    for count in (0, 1):
        assert str(count) in cells(kw4_run[:count])
