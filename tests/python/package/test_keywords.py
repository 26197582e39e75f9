"""Unknown keywords of everything public answer with this package's error, and other programs' words with ours."""

import inspect

import fullbody
import pytest
from fullbody import (
    InvalidInput,
    KeplerElements,
    State,
    ensembles,
    events,
    fields,
    forces,
    frames,
    observables,
    plots,
    spice,
    systems,
    view,
)
from support import points

#: Made by the package alone, or without options.
RESULTS = {
    *(
        fullbody.Dense,
        fullbody.Energy,
        fullbody.EventDerivatives,
        fullbody.FunctionDerivatives,
        fullbody.Gravity,
        fullbody.Interactions,
        fullbody.Invariants,
        fullbody.Jacobian,
        fullbody.Loads,
        fullbody.Samples,
        fullbody.Statistics,
        fullbody.Track,
    ),
    *(
        getattr(observables, name)
        for name in (
            "Eccentricity",
            "ElementRates",
            "Libration",
            "MutualPeriod",
            "OrbitShape",
            "Precession",
            "Tumbling",
        )
    ),
    *(fields.Equilibrium, fields.RocheLobe, fields.SurfaceField, fields.SurfaceRange),
    *(ensembles.Draws, ensembles.Paired, events.Occurrence, systems.Published, systems.Value, fullbody.vector_paths),
}
MODULES = (fullbody, ensembles, events, fields, forces, frames, observables, plots, spice, systems, view)


def public():
    """Functions, classes and public methods of classes."""
    for module in MODULES:
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isclass(thing) and not issubclass(thing, BaseException):
                if thing not in RESULTS:
                    yield f"{module.__name__}.{name}", thing
                for method, function in inspect.getmembers(thing):
                    if not method.startswith("_") and inspect.isroutine(function) and thing not in RESULTS:
                        yield f"{module.__name__}.{name}.{method}", function
            elif inspect.isroutine(thing) and thing not in RESULTS:
                yield f"{module.__name__}.{name}", thing


def passes_on(function):
    return any(p.kind is p.VAR_KEYWORD for p in inspect.signature(function).parameters.values())


THINGS = {name: thing for name, thing in public() if not name.endswith("Function.f")}


@pytest.mark.parametrize("name", [name for name, thing in THINGS.items() if not passes_on(thing)])
def test_what_nobody_knows_is_refused(name):
    """Before anything else is looked at: without arguments too."""
    with pytest.raises(InvalidInput, match=f"^'xyzzy' is not an option of {THINGS[name].__qualname__}; "):
        THINGS[name](xyzzy=1)
    # What editors and inspect see is the function itself.
    assert "kwargs" not in inspect.signature(THINGS[name]).parameters


def test_there_are_many():
    assert len(THINGS) > 80


SYSTEM, STATE = systems.case1()
RUN = SYSTEM.integrate(STATE, 1.0)
MOON = fullbody.Component(diameter=3)


@pytest.mark.parametrize(
    ("call", "wrong", "right"),
    [
        (lambda: SYSTEM.integrate(STATE, t_end=3.0), "t_end", "until"),
        (lambda: SYSTEM.integrate(STATE, tmax=3.0), "tmax", "until"),
        (lambda: SYSTEM.integrate(STATE, 3.0, t_eval=[1.0]), "t_eval", "output"),
        (lambda: SYSTEM.integrate(STATE, 3.0, rtol=1e-9), "rtol", "integrator=fullbody.Verner98(rtol=...)"),
        (lambda: SYSTEM.integrate(STATE, 3.0, atol=1e-9), "atol", "integrator=fullbody.Verner98(atol=...)"),
        (lambda: SYSTEM.integrate(STATE, 3.0, progres=True), "progres", "progress"),
        (lambda: fullbody.Simulation(SYSTEM, STATE, method=None), "method", "integrator"),
        (lambda: fullbody.Simulation(SYSTEM, STATE).integrate(t_end=3.0), "t_end", "until"),
        (lambda: fullbody.Verner98(tol=1e-9), "tol", "rtol"),
        (lambda: fullbody.SymplecticSplitting(dt=0.1), "dt", "step"),
        (lambda: KeplerElements(a=1, e=0, inc=0, Omega=0, omega=0, M=0), "inc", "i"),
        (lambda: KeplerElements(a=1, e=0, i=0, raan=0, omega=0, M=0), "raan", "Omega"),
        (lambda: KeplerElements(1, 0, 0, 0, 0, mean_anomaly=0), "mean_anomaly", "M"),
        (lambda: KeplerElements(1, 0, 0, 0, 0, 0).to_cartesian(GM=1), "GM", "mu"),
        (lambda: fullbody.Component(axes=(3, 2, 1)), "axes", "semi_axes"),
        (lambda: fullbody.Component(diameter=3, period=2), "period", "rotation_period"),
        (lambda: fullbody.Body(fullbody.Sphere(1), m=1), "m", "mass"),
        (lambda: fullbody.Sphere(r=1), "r", "radius"),
        (lambda: State(pos=[[0, 0, 0]], velocity=[[0, 0, 0]]), "pos", "position"),
        (lambda: State([[0, 0, 0]], [[0, 0, 0]], angles=1), "angles", "attitude, or State.from_tait_bryan(angles=...)"),
        (lambda: State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], angle=1), "angle", "angles"),
        (lambda: STATE.replace(vel=0), "vel", "velocity"),
        (lambda: fullbody.binary(MOON, MOON, eccentrity=0.1), "eccentrity", "eccentricity"),
        (lambda: RUN.elements(primary=0), "primary", "about"),
        (lambda: RUN.elements(secondary=1), "secondary", "body"),
        (lambda: RUN.plot.orbit(primary=0, color="red"), "primary", "about"),
        (lambda: RUN.plot(secondary=1), "secondary", "body"),
        (lambda: RUN.plot.elements(i=0), "i", "about"),
        (lambda: SYSTEM.mu(i=0, j=1), "i", "about"),
        (lambda: observables.obliquity(RUN, primary=0), "primary", "about"),
        (lambda: events.Separation(0, 1, distance=3.0), "distance", "value"),
        (lambda: events.Escape(0, 1, value=3.0), "value", "distance"),
        (lambda: events.Periapsis(body=1, about=0), "body", "i"),
        (lambda: systems.kw4(gravty="point"), "gravty", "gravity"),
        (lambda: frames.attitude(0, 0, angel=1), "angel", "angle"),
    ],
)
def test_other_words_for_ours(call, wrong, right):
    with pytest.raises(InvalidInput) as caught:
        call()
    assert str(caught.value).startswith(f"{wrong!r} is not an option of ")
    assert f"did you mean {right!r}? expected some of " in str(caught.value)


def test_arguments_that_are_there_or_missing_are_pythons_affair():
    with pytest.raises(TypeError, match="missing"):
        KeplerElements(1, 0)
    with pytest.raises(TypeError, match="positional"):
        fullbody.Sphere(1, 2, 3)
    assert points(1, 1, gravity="point").options["gravity"] == "point"
