"""Bodies that meet within a step: the error has the time of contact, and no later samples are recorded."""

import fullbody
import numpy as np
import pytest
from fullbody import events
from fullbody.errors import BodiesOverlap
from scipy.integrate import quad

#: The bodies here are shot at each other.
pytestmark = pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")

SPHERES = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name=name) for name in ("A", "B")]
FLYING = fullbody.State([[-100, 0, 0], [0, 0, 0]], [[10, 0, 0], [0, 0, 0]])
ADAPTIVE = [getattr(fullbody, name) for name in ("DormandPrince54", "Verner65", "Verner76", "Verner87", "Verner98")]
#: Every integrator with steps that could pass from one side of the spheres to the other.
INTEGRATORS = [
    *(make(10.0**-digits, 10.0**-digits) for make in ADAPTIVE for digits in (2, 6, 13)),
    *(fullbody.LieGroupVariational(step) for step in (0.03, 1.7)),
    *(
        fullbody.SymplecticSplitting(step, scheme)
        for step in (0.03, 1.7)
        for scheme in ("leapfrog", "ABA864", "ABA1064")
    ),
]


def time_of_contact(mu):
    """Time from 100 apart at relative speed 10 to 2 apart, on a straight line under mu."""
    return quad(lambda r: 1.0 / np.sqrt(100.0 + 2.0 * mu * (1.0 / r - 0.01)), 2.0, 100.0, epsabs=1e-13)[0]


def accuracy(integrator, G):
    """The error of a time of contact, which gravity changes by 6 G at most."""
    if G < 1e-3:
        return 1e-10
    return 0.03 if getattr(integrator, "rtol", 1.0) > 1e-4 else 1e-5 if integrator.rtol > 1e-10 else 1e-10


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=str)
@pytest.mark.parametrize("G", [0.0, 1e-12, 1e-3])
def test_spheres_do_not_pass_through_each_other(G, integrator):
    system = fullbody.System(SPHERES, G=G)
    with pytest.raises(BodiesOverlap, match=r"A and B overlap at time 9\.[78]") as caught:
        system.integrate(FLYING, 20.0, integrator=integrator)
    error, run = caught.value, caught.value.run
    assert error.bodies == ("A", "B")
    assert error.time == pytest.approx(time_of_contact(2.0 * G), abs=accuracy(integrator, G))
    assert run.stop_reason == "unfinished"
    assert run.time[-1] < error.time
    assert run.statistics.steps == len(run) - 1
    assert np.linalg.norm(np.diff(run.position, axis=1), axis=2).min() >= 2.0

    # Samples between steps: all that were due, and none of bodies inside each other.
    with pytest.raises(BodiesOverlap) as caught:
        system.integrate(FLYING, 20.0, output=0.0723, integrator=integrator)
    assert caught.value.time == pytest.approx(error.time, abs=1e-10)
    samples, last = caught.value.run.time[:-1], caught.value.run.time[-1]
    due = np.arange(0.0, error.time, 0.0723)
    # The last sample is the end of the last step before the contact, unless a sample was due there or after it.
    if last != pytest.approx(due[-1], abs=1e-12):
        assert due[-1] < last < error.time
        assert samples == pytest.approx(due, abs=1e-12)
    else:
        assert samples == pytest.approx(due[:-1], abs=1e-12)

    # By hand, and back from there.
    sim = fullbody.Simulation(system, FLYING, integrator=integrator)
    states = []

    def steps():
        while sim.time < 20.0:
            states.append(sim.state)
            sim.step(20.0)

    with pytest.raises(BodiesOverlap) as caught:
        steps()
    assert caught.value.time == pytest.approx(error.time, abs=1e-10)
    assert sim.state == states[-1]
    back = sim.integrate(0.0)
    assert back.stop_reason == "end"


def test_time_of_contact_is_that_of_the_terminal_event():
    shapes = (fullbody.Ellipsoid(1.0, 0.8, 0.5), fullbody.Ellipsoid(0.7, 0.3, 0.2))
    bodies = [fullbody.Body(shape, mass=1.0, name=name) for shape, name in zip(shapes, "AB", strict=True)]
    state = fullbody.State([[-8, 0.2, 0], [0, 0, 0.1]], [[3, 0, 0], [0, 0, 0]], spin=[[0.3, 0.2, 2.0], [1.0, 3.0, 0.5]])
    system = fullbody.System(bodies, G=0.1)
    for integrator in (fullbody.Verner98(), fullbody.DormandPrince54(1e-4, 1e-4), fullbody.SymplecticSplitting(0.05)):
        with pytest.raises(BodiesOverlap) as caught:
            system.integrate(
                state, 10.0, integrator=integrator, events=[events.Contact(), events.Separation(value=4.0)]
            )
        run = caught.value.run
        assert [type(o.event).__name__ for o in run.events] == ["Separation", "Contact"]
        assert run.events[-1].time == caught.value.time > run.time[-1]
        ended = system.integrate(state, 10.0, integrator=integrator, events=[events.Contact(terminal=True)])
        assert ended.stop_reason == "event"
        assert ended.time[-1] == pytest.approx(caught.value.time, abs=1e-12)
        # Grown by a hair they overlap there.
        grown = [fullbody.Ellipsoid(*(np.array(b.shape.semi_axes) * (1 + 1e-9))) for b in bodies]
        larger = fullbody.System([fullbody.Body(shape, mass=1.0) for shape in grown], G=0.1)
        with pytest.raises(BodiesOverlap):
            larger.interactions(ended[-1])


def test_the_error_of_a_collision_has_units():
    u = pytest.importorskip("astropy.units")
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1e3, name=name) for name in ("A", "B")]
    system = fullbody.System(bodies, units=("km", "hour", "kg"))
    state = fullbody.State([[-100, 0, 0], [0, 0, 0]] * u.km, [[10, 0, 0], [0, 0, 0]] * u.km / u.h)
    with pytest.raises(BodiesOverlap, match=r"A and B overlap at time 9\.(8|79999\d+) h; expected") as caught:
        system.integrate(state, 20 * u.h, integrator=fullbody.DormandPrince54(1e-3, 1e-3))
    assert caught.value.time == pytest.approx(9.8, abs=1e-10)
    assert caught.value.run.time[-1] < 9.8 * u.h


def test_the_first_of_two_contacts_ends_the_run():
    sphere, point = fullbody.Sphere(1.0), fullbody.PointMass()
    shapes = {"left": sphere, "moon": point, "right": sphere, "grain": point}
    bodies = [fullbody.Body(shape, mass=1e-9, name=name) for name, shape in shapes.items()]
    position = [[-20, 0, 0], [0, 0, 0], [20, 0, 0], [0, 5, 0]]
    for speed, names, expected in ((-3.0, ("left", "moon"), 19 / 3), (4.0, ("moon", "right"), 19 / 4)):
        state = fullbody.State(position, [[0, 0, 0], [speed, 0, 0], [0, 0, 0], [0, 0, 0]])
        for integrator in INTEGRATORS:
            with pytest.raises(BodiesOverlap) as caught:
                fullbody.System(bodies, G=1e-3).integrate(state, 100.0, integrator=integrator)
            assert caught.value.bodies == names
            assert caught.value.time == pytest.approx(expected, abs=1e-9)
    passing = fullbody.State(position, [[0, 0, 0], [0, 1, 0], [0, 0, 0], [0, -1, 0.0001]])
    run = fullbody.System(bodies, G=1e-12).integrate(passing, 5.0)
    assert run.stop_reason == "end"
