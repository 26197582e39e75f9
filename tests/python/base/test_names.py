"""Every argument that takes a body's index also takes its name, and errors list the known names."""

import unicodedata

import fullbody
import numpy as np
import pytest
from fullbody import Body, PointMass, State, System, events, observables
from fullbody.base.arguments import argument_names, suggestion
from support import refused


@pytest.fixture(scope="module")
def kw4():
    system, state = fullbody.systems.kw4(gravity="multipole:2")
    return system, state, system.integrate(state, 100.0, output=0.5)


def test_elements_take_names_of_bodies(kw4):
    system, _, run = kw4
    assert system.mu("Alpha", "Beta") == system.mu(0, 1)
    assert system.mu("Beta", "Alpha") == system.mu(1, 0)
    assert run.elements(body="Alpha", about="Beta") == run.elements(body=0, about=1)


def test_a_system_finds_bodies_by_name(kw4):
    system = kw4[0]
    alpha, beta = system.bodies
    assert (system["Alpha"], system["Beta"], system[0], system[np.int64(1)]) == (alpha, beta, alpha, beta)
    assert (system.index("Beta"), system.index(1)) == (1, 1)
    assert list(system) == [alpha, beta]
    assert "Beta" in system
    assert beta in system
    assert "Moon" not in system
    for wrong, what in (
        ("Alfa", "body is 'Alfa'; did you mean 'Alpha'"),
        (2, "body is 2; expected 0 to 1"),
        (-1, "body is -1"),
        (slice(1), "body is slice"),
    ):
        refused(what, lambda wrong=wrong: system[wrong])


def test_an_inclination_is_not_suggested_for_a_body():
    for name in ("primary", "body", "about"):
        assert suggestion(name, ["a", "e", "i"]) == "expected some of a, e, i"
    assert suggestion("primary", ["body", "about"]).startswith("did you mean 'about'?")


@pytest.mark.parametrize("units", [False, True])
def test_a_run_finds_bodies_by_name(units):
    system, state = fullbody.systems.kw4(units=units)
    run = system.integrate(state, 10.0, output=1.0)
    beta = run["Beta"]
    assert (beta.name, len(beta.time)) == ("Beta", 11)
    for name in ("time", "position", "velocity", "attitude", "spin"):
        values = getattr(run, name)
        part, expected = getattr(beta, name), values if name == "time" else values[:, 1]
        assert type(part) is type(expected)
        assert np.array_equal(part, expected)
        assert not part.flags.writeable
    for k, sample in enumerate(run):
        assert np.array_equal(beta.rotation_matrix[k], sample.rotation_matrix[1])
        assert np.array_equal(beta.tait_bryan[k], sample.tait_bryan[1])
    assert run["Alpha"] != beta
    empty = system.integrate(state, 1.0, output=[])["Beta"]
    assert (empty.position.shape, empty.rotation_matrix.shape, empty.tait_bryan.shape) == ((0, 3), (0, 3, 3), (0, 3))
    refused("body is 'Betta'; did you mean 'Beta'", lambda: run["Betta"])


@pytest.mark.parametrize(
    "make",
    [
        lambda i, j: events.Periapsis(i, j),
        lambda i, j: events.Separation(i, j, 2.557),
        lambda i, j: events.Alignment(j, i),
        lambda i, j: events.PlaneCrossing(j, i, normal=(1.0, 0.0, 0.0)),
    ],
)
def test_events_take_names_of_bodies(kw4, make, tmp_path):
    system, state, _ = kw4
    by_name = system.integrate(state, 40.0, output=40.0, events=[make("Alpha", "Beta")])
    by_index = system.integrate(state, 40.0, output=40.0, events=[make(0, 1)])
    assert len(by_name.events) > 0
    assert [e.time for e in by_name.events] == [e.time for e in by_index.events]
    by_name.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc").events[0].event == by_name.events[0].event


@pytest.mark.parametrize(
    "name", ["element_rates", "mutual_period", "orbit_precession", "obliquity", "roll_pitch_yaw", "libration"]
)
def test_observables_take_names_of_bodies(kw4, name):
    function = getattr(observables, name)
    by_name, by_index = function(kw4[2], body="Beta", about="Alpha"), function(kw4[2], body=1, about=0)
    assert np.array_equal(by_name, by_index) if isinstance(by_index, np.ndarray) else by_name == by_index
    # The other body of a precession is that of a pair.
    assert observables.spin_precession(kw4[2], body="Alpha") == observables.spin_precession(kw4[2], body=0, about=1)


def test_plots_take_names_of_bodies(kw4):
    run = kw4[2]

    def curves(axes):
        return [line.get_xydata() for ax in np.ravel(axes) for line in ax.get_lines()]

    for by_name, by_index in (
        (run.plot.orbit(about="Beta"), run.plot.orbit(about=1)),
        (run.plot.elements(body="Alpha", about="Beta"), run.plot.elements(body=0, about=1)),
        (run.plot.spins(bodies=["Beta"]), run.plot.spins(bodies=[1])),
        (run.plot.angles(bodies=["Beta", 0]), run.plot.angles(bodies=[1, 0])),
        (list(run.plot(body="Beta", about="Alpha").axes.values()), list(run.plot().axes.values())),
        (run.plot.libration(body="Beta", about="Alpha"), run.plot.libration(body=1, about=0)),
    ):
        for first, second in zip(curves(by_name), curves(by_index), strict=True):
            np.testing.assert_array_equal(first, second)


def test_unknown_names_are_refused_with_those_known(kw4):
    system, state, run = kw4
    for call, what in (
        (lambda: system.mu("Alfa", "Beta"), "body is 'Alfa'; did you mean 'Alpha'"),
        (lambda: run.elements(body="Betta"), "body is 'Betta'; did you mean 'Beta'"),
        (lambda: system.integrate(state, 1.0, events=[events.Contact("Moon", "Beta")]), "body of Contact is 'Moon'; "),
        (lambda: observables.obliquity(run, body="Moon"), "body of an obliquity is 'Moon'; "),
        (lambda: run.plot.orbit(about="Moon"), "about is 'Moon'; "),
        (lambda: run.plot.spins(bodies=["Moon"]), "one of bodies is 'Moon'; "),
    ):
        refused(rf"^{what}.*expected one of Alpha, Beta$", call)
    refused("bodies is 'Alpha'; expected a list", lambda: run.plot.spins(bodies="Alpha"))


@pytest.mark.parametrize("name", ["a\0b", "two\nlines", "\x7f", "tab\t", "\x85", "half \ud800"])
def test_names_with_control_characters_are_refused(name):
    refused(r"name is .*; expected text without control characters", lambda: Body(PointMass(), mass=1.0, name=name))
    assert Body(PointMass(), mass=1.0, name="Ünicode 小 $x_1$").name == "Ünicode 小 $x_1$"


def test_bodies_without_names_are_called_by_their_indices():
    unnamed = System([Body(PointMass(), mass=1.0) for _ in range(2)], G=1.0)
    start = State([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 0.1, 0]])
    assert unnamed.mu("body 0", "body 1") == 2.0
    run = unnamed.integrate(start, 0.5, events=[events.Separation("body 0", "body 1", 0.9)])
    assert len(run.events) == 1


def test_names_are_found_in_another_normal_form():
    sphere, other = fullbody.Sphere(1.0), "B"
    body, force = (unicodedata.normalize("NFD", name) for name in ("Äpyän", "Jättiläinen"))
    far = fullbody.KeplerElements(100.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    third = fullbody.forces.ThirdBody(mass=1.0, orbit=far, of="body", name=force)
    bodies = [fullbody.Body(sphere, mass=1.0, name=body), fullbody.Body(sphere, mass=1.0, name=other)]
    system = fullbody.System(bodies, G=1.0, forces=[third])
    state = fullbody.State([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 0.6, 0.0]])
    mass = f"mass of {body}"
    assert system.names[0] != body
    assert body in system
    refused("name", lambda: fullbody.System([fullbody.Body(sphere, mass=1.0, name=n) for n in (body, "Äpyän")], G=1.0))
    run = system.integrate(state, 1.0, output="ends", derivatives=[mass])
    assert run.sensitivity[mass].shape == (2, 24)
    assert run.work[force].shape == (2,)
    assert system.changed(mass, 1.0)[body].mass == 2.0
    assert system.third_body(force, 0.0)[0].shape == (3,)
    assert system.loads(state)[force].force.shape == (2, 3)
    albedo = {body: 0.5, other: 1.0}
    light = fullbody.observing.brightness(system, state, [0, 0, 1], [0, 0, 1], albedo=albedo)
    assert light[0] == pytest.approx(light[1] / 2, rel=1e-14)
    with pytest.raises(KeyError):
        _ = run.work["Sun"]


def test_names_of_parameters_have_the_normal_form_of_python():
    system, state = fullbody.systems.case1()
    result = fullbody.sweep(
        lambda μ: (system, state), {"\N{MICRO SIGN}": [1.0, 2.0]}, 0.1, measure=lambda run: {"a": 1.0}
    )
    assert list(result["\N{GREEK SMALL LETTER MU}"].values) == [1.0, 2.0]
    assert argument_names({"\N{MICRO SIGN}": 1}) == {"\N{GREEK SMALL LETTER MU}": 1}
