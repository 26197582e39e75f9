"""Every ready-made system: its sources, its start, its frames, units and epochs."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import PointMass, systems
from support import ready, refused
from support.ready_systems import PUBLISHED, TABULATED, WITHOUT_POLE

pytestmark = pytest.mark.usefixtures("memoised_searches")


@pytest.mark.parametrize("name", TABULATED)
def test_each_system_has_the_sources_of_its_numbers(name):
    facts = systems.published(name)
    text = getattr(systems, name).__doc__
    assert facts.assumed
    for value in facts.values.values():
        assert value.source in facts.sources
    for source in facts.sources.values():
        assert any(mark in source for mark in ("doi:10.", "bibcode", "https://ssd.jpl.nasa.gov"))
        assert source in text
    for sentence in facts.assumed:
        assert sentence in text
    bare = text.partition("- without an uncertainty, as far as could be read: ")[2].partition("\n")[0]
    for key, value in facts.values.items():
        assert value.uncertainty or "heliocentric" in key or f" {key}," in f" {bare},"
    for note in facts.second_hand + facts.unconfirmed:
        assert note.removeprefix("uncertainty of ") in facts.values
        assert note in text.partition("not confirmed against the source")[2]
    assert not set(facts.second_hand) & set(facts.unconfirmed)
    refused("antiope", lambda: systems.published("vulcan"))


@pytest.mark.parametrize("name", [*PUBLISHED, *WITHOUT_POLE])
def test_each_system_starts_at_rest_and_runs(name):
    system, state = ready(name)
    masses = system.masses
    scale = np.abs(state.position).max() * masses.min()
    np.testing.assert_allclose(masses @ state.position, 0.0, atol=1e-12 * scale)
    speed = np.abs(state.velocity).max() * masses.min()
    np.testing.assert_allclose(masses @ state.velocity, 0.0, atol=1e-12 * speed)
    assert abs(system.integrate(state, 10.0, output=5.0).energy_drift[-1]) < 1e-12
    with_units, quantities = ready(name, units=True)
    np.testing.assert_allclose(with_units.masses.to_value("kg"), masses, rtol=1e-14)
    np.testing.assert_allclose(quantities.position.to_value("km"), state.position, rtol=1e-14)
    np.testing.assert_allclose(quantities.spin.to_value("rad / hour"), state.spin, rtol=1e-14)
    assert with_units.frame == systems.published(name).frame


@pytest.mark.parametrize(
    ("name", "error"),
    [
        *(("didymos", 4e-6), ("didymos_after_dart", 4e-5), ("antiope", 1e-5), ("patroclus_menoetius", 6e-5)),
        *(("dinkinesh", 5e-5), ("fg3_1996", 1.6e-5), ("pluto_charon", 1.5e-4)),
    ],
)
def test_the_published_period_is_kept(name, error):
    facts = systems.published(name)
    period = facts["orbital period"] * (24.0 if facts.values["orbital period"].unit == "day" else 1.0)
    system, state = ready(name)
    run = system.integrate(state, 30 * period, output=period / 24)
    assert abs(fullbody.observables.mutual_period(run).mean - period) < error
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    assert np.ptp(distance) < (0.1 if name == "didymos_after_dart" else 0.02) * distance[0]


@pytest.mark.parametrize("name", PUBLISHED)
def test_position_velocity_and_attitude_are_rotated_between_frames(name):
    make = getattr(systems, name)
    system, ecliptic = ready(name, frame="ecliptic")
    _, equatorial = ready(name, frame="equatorial")
    _, plane = ready(name, frame="orbit")
    matrix = fullbody.frames.rotation("ecliptic", "equatorial")
    for name_of in ("position", "velocity"):
        rotated = getattr(ecliptic, name_of) @ matrix.T
        np.testing.assert_allclose(getattr(equatorial, name_of), rotated, atol=1e-12 * np.abs(rotated).max())
    np.testing.assert_allclose(equatorial.rotation_matrix, matrix @ ecliptic.rotation_matrix, atol=1e-12)
    # What does not depend on the frame.
    for state in (equatorial, plane):
        np.testing.assert_allclose(system.energy(state).total, system.energy(ecliptic).total, rtol=1e-9)
        sizes = [np.linalg.norm(system.angular_momentum(item)) for item in (state, ecliptic)]
        np.testing.assert_allclose(*sizes, rtol=1e-12)
    # The plane is that of Gamma's orbit in the triple.
    near = plane.position[2 if name == "sn263_2001" else 1] - plane.position[0]
    np.testing.assert_allclose(near[2], 0.0, atol=1e-12 * np.linalg.norm(near))
    refused("frame is 'sky'", lambda: make(frame="sky"))


@pytest.mark.parametrize("name", [*PUBLISHED, "kw4", "kw4_ho2021"])
def test_systems_in_other_units_are_the_same(name):
    make = getattr(systems, name)
    wanted = (u.m, "day", "t")
    (system, state), (usual, start) = ready(name, units=wanted), ready(name, units=True)
    assert system.units == ("m", "d", "t")
    assert usual.units == ("km", "h", "kg")
    assert make(units=("km", "hour", "kg")) == (usual, start)
    assert (system.epoch, system.frame) == (usual.epoch, usual.frame)
    for body, other in zip(system.bodies, usual.bodies, strict=True):
        assert body.mass.unit == u.t
        if body.shape == PointMass():
            continue
        solids = [part.shape for part in getattr(body.shape, "parts", ())] or [body.shape]
        assert {solid.semi_axes[0].unit for solid in solids} == {u.m}
        np.testing.assert_allclose((body.inertia / other.inertia).to_value(""), 1.0, rtol=1e-14)
    assert state.position.unit == u.m
    pairs = ((system, state), (usual, start))
    ours, theirs = ((t.position, t.velocity, t.spin, s.G, s.energy(t).total) for s, t in pairs)
    for item, other in zip(ours, theirs, strict=True):
        assert item.unit != other.unit
        np.testing.assert_allclose(item.to_value(other.unit), other.value, rtol=1e-11)
    np.testing.assert_array_equal(state.attitude, start.attitude)
    end, usual_end = (s.integrate(t, "3 hour")[-1].position[1] for s, t in pairs)
    np.testing.assert_allclose(end.to_value("km"), usual_end.value, rtol=1e-9)
    wrong = ("yes", "'yes'|'y'"), (1, "is 1; expected"), (("km", "kg", "hour"), "has 'kg'; expected a unit")
    for units, what in wrong:
        refused(f"units .*{what}", make, units=units)


@pytest.mark.parametrize("name", [*PUBLISHED, "kw4", "kw4_ho2021", "case1", "case2"])
def test_ready_made_systems_take_epochs_where_their_numbers_hold_at_none(name):
    make = getattr(systems, name)
    epoch = systems.published(name).epoch if name in PUBLISHED else None
    if epoch is None:
        assert make(epoch="2001-05-25T00:00:00 TDB")[0].options["epoch"] == "2001-05-25T00:00:00 TDB"
        refused("scale", lambda: make(epoch="2001-05-25"))
    else:
        refused(rf"epoch is '2001-05-25 TDB'; .* hold at its own, {epoch}", lambda: make(epoch="2001-05-25 TDB"))
        assert make(epoch=None)[0].options["epoch"] == epoch
    for option in ("G", "bodies", "gravty"):
        refused(f"'{option}' is not an option of this system", make, **{option: 1.0})


@pytest.mark.parametrize("name", ["kw4_ho2021", "case1", "case2"])
def test_frames_that_differ_by_more_than_a_rotation_are_refused(name):
    make = getattr(systems, name)
    assert make(frame=None)[0].frame is None
    for frame in ("equatorial", "ecliptic", "galactic"):
        refused(f"frame is '{frame}'; expected", make, frame=frame)
    # The orbit's plane is where it is.
    system, state = ready("kw4", frame="orbit")
    assert system.frame == "orbit"
    assert state == ready("kw4")[1]


def test_ratios_of_axes_change_no_mass():
    system, _ = systems.fg3_1996(secondary_ratios=(1.5, 1.1))
    np.testing.assert_allclose(system.masses, ready("fg3_1996")[0].masses, rtol=1e-14)
    assert system.bodies[1].shape.a > 1.4 * system.bodies[1].shape.b
    triple, _ = systems.sn263_2001(axis_ratios=((1.1, 1.05), (1.3, 1.1), (1.2, 1.0)))
    np.testing.assert_allclose(triple.masses, ready("sn263_2001")[0].masses, rtol=1e-14)


@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda: systems.didymos(frame=np.ones(3)), "frame is array.*; expected 'ecliptic'"),
        (lambda: systems.kw4(frame=np.ones(3)), "frame is array.*; expected 'ecliptic'"),
        (lambda: systems.kw4(shape=np.ones(3)), "shape is array.*; expected 'ellipsoid'"),
        (lambda: systems.published(["kw4"]), r"name is \['kw4'\]; expected one of"),
    ],
)
def test_what_is_no_text_is_refused_where_text_is_asked(call, what):
    refused(what, call)
