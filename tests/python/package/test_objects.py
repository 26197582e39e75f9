"""Every public class copies, pickles, compares and says what it is."""

import copy
import functools
import inspect
import pickle

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import errors, events, fitting, forces, frames, model, observables, observing, particles, record, systems

MODULES = (fullbody, errors, events, fitting, forces, frames, model, observables, particles, record, systems)
#: The classes of fits, which tests/python/fitting/test_fit_results.py and test_period_scan.py make.
OF_FITS = {fitting.Fit, fitting.Minimum, fitting.PeriodMinimum, fitting.PeriodScan, fitting.Regularisation}
TOML = """
[system]
units = ["km", "hour", "kg"]
[[body]]
radius = 1.0
mass = 1e12
[[body]]
point = true
mass = 1.0
position = [9, 0, 0]
[run]
until = 5
output = [1, 2, 5]
"""


@functools.cache
def example(units):
    system, state = systems.kw4(units=units)
    apsides = [events.Periapsis(0, 1)]
    return system, state, system.integrate(state, 100.0, output=1.0, dense=True, events=apsides)


def made(units=False):
    """Objects of every public class."""
    system, state, run = example(units)
    km, kg, hour = (u.km, u.kg, u.hour) if units else (1, 1, 1)
    integrators = (
        *(kind(1e-11, 1e-12) for kind in (fullbody.Verner98, fullbody.Verner87, fullbody.Verner76, fullbody.Verner65)),
        fullbody.DormandPrince54(1e-9),
        fullbody.LieGroupVariational(0.5 * hour),
        fullbody.SymplecticSplitting(0.5 * hour, "leapfrog"),
    )
    watched = (
        events.Event(),
        events.Separation(0, 1, 2.5 * km, direction=1, terminal=True),
        events.Contact(0, 1),
        events.Periapsis(0, 1),
        events.Apoapsis(0, 1),
        events.PlaneCrossing(1, normal=np.array([1.0, 2.0, 3.0])),
        events.Escape(0, 1, 100.0 * km),
        events.Alignment(1, 0),
        events.ClosestApproach("Sun"),
        events.Function(np.linalg.norm),
        events.Occultation(0, 1, toward=[1.0, 0.0, 0.0]),
    )
    times = np.linspace(0.0, 10.0, 5)
    outside = (
        forces.Force(),
        forces.ThirdBody(mass=3.0 * kg, orbit=fullbody.KeplerElements(9.0 * km, 0, 0, 0, 0, 0), of="body", name="Moon"),
        forces.ThirdBody(
            mu=3.0 * km**3 / hour**2, times=times * hour, positions=np.outer(times, [1, 2, 3]) * km, of="system"
        ),
        forces.Tide("Alpha", "Beta", k2=0.1, lag=0.2 * hour),
        forces.Yorp("Alpha", along=1.0 * kg * km**2 / hour**2),
        forces.Byorp("Beta", "Alpha", 1.0 * kg * km / hour**2),
        forces.BinaryYarkovsky("Beta", "Alpha", pressure=2.0 * kg / (km * hour**2), lag=0.3),
        forces.Function(np.linalg.norm),
    )
    shapes = (fullbody.Sphere(1.5 * km), fullbody.Ellipsoid(3 * km, 2 * km, 1 * km), fullbody.PointMass())
    positions = ((1.0, 0.2, 0.1), (-2.0, 0.3, 0.4), (5.0, 1.0, 0.5))
    attitude = (0.1, 0.2, 0.3, 0.4)
    parts = [
        fullbody.Part(shape, mass=2.0 * kg, position=x * km, attitude=attitude)
        for shape, x in zip(shapes, positions, strict=True)
    ]
    composite = fullbody.Body(fullbody.Composite(parts), name="Selam")
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.5]]) * km
    cloud = fullbody.Particles(np.array([[6.0, 0.0, 0.0]]) * km, np.array([[0.0, 0.4, 0.0]]) * km / hour)
    watched_of_cloud = (
        particles.ParticleEvent(),
        particles.ParticlePeriapsis("Alpha"),
        particles.Shadow(0.25),
        particles.ParticleFunction(np.linalg.norm),
    )
    flight = run.fly(cloud, 40.0, output=10.0, events=watched_of_cloud[1:2])
    ending = [events.Apoapsis(0, 1, terminal=True)]
    ended = system.integrate(state, 20.0, events=ending, derivatives=["G"])
    wedge = fullbody.Polyhedron(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    return (
        *shapes,
        *parts,
        fullbody.Part(shapes[0], density=-2.0 * kg / km**3),
        composite.shape,
        composite,
        composite.working_frame,
        *(fullbody.Body(shape, mass=2.0 * kg, name="Alpha") for shape in shapes),
        fullbody.Body(shapes[0], density=2.0 * kg / km**3),
        fullbody.Component(semi_axes=[3 * km, 2 * km, 1 * km], rotation_period=5 * hour, pole=(0.1, 0.2)),
        fullbody.Component(diameter=2 * km, mass=3 * kg, name="Alpha"),
        *integrators,
        *watched,
        *outside,
        system.with_forces(outside[3:6]).loads(state)["tide on Alpha"],
        system.with_forces(outside[3:6]),
        run.events[0],
        system,
        system.with_options(gravity="surface", order=(8, 16), attitude_chart="tait_bryan", vector_path="portable"),
        state,
        state.replace(attitude=[[0.1, 0.3, 0.3, 0.9], [0.5, -0.1, 0.7, 0.5]], time=3.25 * hour),
        system.interactions(state),
        system.gravity(state, np.array([[5.0, 0.0, 0.0], [0.0, 6.0, 1.0]]) * km),
        system.energy(state),
        system.jacobian(state, ["G"]),
        ended.at_event(),
        ended.derivative_of(lambda run: run.position[-1, 1], start=False),
        cloud,
        flight,
        flight.events[0],
        *watched_of_cloud,
        particles.Bounce(normal=0.5, rest_speed=1.0 * km / hour),
        particles.EscapeDistance(50.0 * km),
        particles.Radiation(strength=1.0 * kg * km / hour**2),
        fitting.Free(0.1 * km, min=0.0 * km),
        fitting.Free([0.1, 0.2], prior=(0.0, [1.0, 2.0])),
        fitting.Outliers(0.1, 5.0),
        fitting.Derived(0.1 * km, 0.2 * km),
        fitting.pole_grid(3),
        *(observing.Lambert(), observing.LommelSeeliger(), observing.Cosine(1.0, 2.0), observing.Gaussian(100.0)),
        fullbody.Simulation(system, state, integrator=integrators[0]),
        fullbody.KeplerElements(2.0 * km, 0.3, 0.4, 0.5, 0.6, 0.7),
        fullbody.KeplerElements([1.0, 2.0] * km, 0.3, 0.4, [0.5, 0.6], 0.6, 0.7),
        run.elements(),
        run,
        run[::2],
        run["Beta"],
        run.statistics,
        run.start,
        run([1.0, 2.0]),
        observables.element_rates(run),
        observables.mean_elements(run),
        observables.fate(run),
        observables.drift(run),
        observables.mutual_period(run),
        observables.orbit_precession(run),
        observables.libration(run),
        observables.orbit_shape(run),
        observables.eccentricity(run),
        observables.tumbles(run),
        systems.published("antiope"),
        systems.published("antiope").values["semi-major axis"],
        wedge,
        wedge.harmonics(4),
        fullbody.Body(wedge.harmonics(4), mass=2.0 * kg),
        fullbody.Body(wedge, density=2.0 * kg / km**3, name="wedge"),
        forces.radiation_coefficients(fullbody.Body(wedge, mass=2.0 * kg), longitudes=10, latitudes=5),
        pear := fullbody.HarmonicShape([0.1, 0.0, 0.05, 0.0], reference_radius=2.1 * km, faces=80),
        fullbody.Body(pear, mass=2.0 * kg),
        egg := fullbody.ConvexShape([0.1, 0.0, 0.05, 0.0], reference_radius=2.1 * km, faces=80),
        fullbody.Body(egg, mass=2.0 * kg),
    )


def test_texts_of_arrays_leave_round_off_out():
    state = fullbody.State([[1.25e-9, 1e-25, -1e-25], [2.5, 1e-16, -1e-12]], [[-0.0, 0, 0], [0, 1, 0]])
    text = repr(state)
    assert "[[1.25e-09 0.00e+00 0.00e+00]" in text
    assert "[2.50e+00 0.00e+00 0.00e+00]]" in text
    assert "-0" not in text.replace("e-0", "")
    kw4, start = systems.kw4(units=True)
    shown = repr(kw4.interactions(start))
    assert shown.count("0.000000e+00") == 4
    assert np.abs(kw4.interactions(start).force.value[:, 1:]).max() > 0.0


def setup_of(folder):
    path = folder / "system.toml"
    path.write_text(TOML)
    return fullbody.read_toml(path)


def classes():
    """The public classes, exceptions and warnings apart."""
    results = {getattr(module, name) for module in MODULES for name in module.__all__ if name != "__version__"}
    return {thing for thing in results if inspect.isclass(thing)}


def test_every_public_class_is_among_the_objects(tmp_path):
    kinds = {kind for kind in classes() if not issubclass(kind, BaseException)}
    objects = {type(thing) for thing in (*made(), setup_of(tmp_path))}
    assert {kind for kind in objects if kind.__module__.split(".")[1] != "observing"} == kinds - {
        fullbody.record.Dense,
        *OF_FITS,
    }


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
@pytest.mark.parametrize("units", [False, True])
def test_copies_are_equal(units, duplicate, tmp_path):
    for original in (*made(units), setup_of(tmp_path)):
        twin = duplicate(original)
        assert type(twin) is type(original)
        assert twin == original
        assert (twin != original) is False
        assert repr(twin) == repr(original)
        assert original != "something else"


@pytest.mark.parametrize("units", [False, True])
def test_objects_of_equal_arguments_are_equal_and_others_are_not(units):
    first, second = made(units), made(units)
    for k, thing in enumerate(first):
        for n, other in enumerate(second):
            assert (thing == other) is (k == n), (thing, other)


def test_equal_things_in_other_units_have_equal_hashes():
    km, m, kg, g, hour = u.km, u.m, u.kg, u.g, u.hour
    sphere, other = fullbody.Sphere(1 * km), fullbody.Sphere(1000 * m)
    for first, second in (
        (sphere, other),
        (fullbody.Ellipsoid(3 * km, 2 * km, 1 * km), fullbody.Ellipsoid(3000 * m, 2000 * m, 1000 * m)),
        (fullbody.Body(sphere, mass=1 * kg, name="A"), fullbody.Body(other, mass=1000 * g, name="A")),
        (fullbody.Body(sphere, density=1 * g / u.cm**3), fullbody.Body(other, density=1000 * kg / m**3)),
        (fullbody.SymplecticSplitting(1 * hour), fullbody.SymplecticSplitting(60 * u.min)),
        (fullbody.LieGroupVariational(1 * hour), fullbody.LieGroupVariational(3600 * u.s)),
        (events.Separation(0, 1, 1 * km), events.Separation(0, 1, 1000 * m)),
        (events.Escape(0, 1, distance=1 * km), events.Escape(0, 1, distance=1000 * m)),
        (fullbody.Sphere(2), fullbody.Sphere(np.array(2.0))),
    ):
        assert first == second
        assert len({first, second}) == 1
    for first, second in (
        (sphere, fullbody.Sphere(1.0)),
        (sphere, fullbody.Sphere(np.nextafter(1.0, 2.0) * km)),
        (events.Separation(0, 1, 1 * km), events.Separation(0, 1, 1.0)),
        (events.Periapsis(0, 1), events.Apoapsis(0, 1)),
        (fullbody.SymplecticSplitting(1 * hour), fullbody.LieGroupVariational(1 * hour)),
    ):
        assert first != second


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_plots_and_views_equal_their_copies(duplicate):
    run = example(True)[2]
    for picture, alternatives in (
        (run.plot, (run[:51].plot, run)),
        (run.view(), (run[:51].view(), run.view(samples=150))),
    ):
        assert duplicate(picture) == picture
        for other in alternatives:
            assert picture != other


def test_equal_numbers_of_other_units_are_unequal():
    for unitless, with_units in zip(made(False), made(True), strict=True):
        text = repr(unitless)
        if repr(with_units) != text:
            assert unitless != with_units


@pytest.mark.parametrize("units", [False, True])
def test_texts_name_the_class_and_are_short(units, tmp_path):
    for thing in (*made(units), setup_of(tmp_path)):
        text = repr(thing)
        assert text.startswith(type(thing).__name__ + "(")
        # A table of facts and sources is all words.
        assert len(text) < 1200 or isinstance(thing, systems.Published), text
        assert "object at 0x" not in text
        assert "array(" not in text


@pytest.mark.parametrize("kind", [getattr(errors, name) for name in errors.__all__])
def test_errors_pickle(kind):
    details = {
        "BodiesOverlap": (("Alpha", "Beta"), 3.0),
        "StepSizeTooSmall": (3.0, 1e-9),
        "ChartSingularity": ("Alpha", 3.0),
        "ForceFailed": ("Sun", 3.0, 7),
    }
    error = kind("what is wrong", *details.get(kind.__name__, ()))
    twin = pickle.loads(pickle.dumps(error))
    assert type(twin) is kind
    assert str(twin) == str(error) == "what is wrong"
    assert vars(twin) == vars(error)
    assert len(vars(error)) == len(details.get(kind.__name__, ()))


def test_a_run_keeps_all_but_its_continuous_solution():
    _, _, run = example(True)
    assert copy.copy(run)(1.5) == copy.deepcopy(run)(1.5) == run(1.5)
    twin = pickle.loads(pickle.dumps(run))
    assert twin.dense is None
    assert twin.events == run.events
    assert twin.stop_reason == run.stop_reason
    with pytest.raises(ValueError, match="read-only"):
        twin.attitude[0] = 0.0
    with pytest.raises(TypeError, match=r"does not pickle; pickle samples of it, dense\(times\)"):
        pickle.dumps(run.dense)
    assert repr(run.dense).startswith("Dense(from 0.0 h to 100.0 h")


def test_texts_of_arrays_are_short_and_of_numbers_complete():
    elements = fullbody.KeplerElements(np.array([1.0, 2.0]), 0.25, 0.1, 0.0, 0.0, [0.0, 1.5])
    assert repr(elements) == "KeplerElements(a=<(2,), 1 to 2>, e=0.25, i=0.1, Omega=0.0, omega=0.0, M=<(2,), 0 to 1.5>)"
    assert repr(elements[1]) == "KeplerElements(a=2.0, e=0.25, i=0.1, Omega=0.0, omega=0.0, M=1.5)"
    third = fullbody.KeplerElements(1 / 3 * u.km, 1 / 3, 0, 0, 0, 0)
    assert "a=0.3333333333333333 km, e=0.3333333333333333," in repr(third)
    ball = fullbody.Body(fullbody.PointMass(), mass=1.0)
    assert "G=8.6498928e-13," in repr(fullbody.System([ball], G=8.649892799999999e-13))
    assert fullbody.System([ball], G=8.649892799999999e-13).G == 8.649892799999999e-13


def test_public_names_exist_and_are_documented():
    for module in MODULES:
        assert set(module.__all__) <= set(dir(module))
        for name in module.__all__:
            assert getattr(module, name) is not None
    assert not hasattr(fullbody, "TYPE_CHECKING")
    for name in fullbody.__all__:
        thing = getattr(fullbody, name)
        if name != "__version__":
            assert (thing.__doc__ or "").strip(), name
