"""Bodies that meet within a step: the error has the time of contact, and no later samples are recorded."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import BodiesOverlap, StepSizeTooSmall
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

    # Single steps reach the same times, and lead back from there.
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


def test_the_error_of_a_collision_has_units():
    u = pytest.importorskip("astropy.units")
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1e3, name=name) for name in ("A", "B")]
    system = fullbody.System(bodies, units=("km", "hour", "kg"))
    state = fullbody.State([[-100, 0, 0], [0, 0, 0]] * u.km, [[10, 0, 0], [0, 0, 0]] * u.km / u.h)
    with pytest.raises(BodiesOverlap, match=r"A and B overlap at time 9\.(8|79999\d+) h; expected") as caught:
        system.integrate(state, 20 * u.h, integrator=fullbody.DormandPrince54(1e-3, 1e-3))
    assert caught.value.time == pytest.approx(9.8, abs=1e-10)
    assert caught.value.run.time[-1] < 9.8 * u.h


def test_falling_points_end_at_the_time_of_the_closed_form():
    # From rest at distance d two points meet after pi sqrt(d^3 / (8 G M)).
    system = fullbody.System([fullbody.Body(fullbody.PointMass(), mass=m) for m in (1.0, 3.0)], G=2.0)
    state = fullbody.State([[0, 0, 0], [1.5, 0, 0]], np.zeros((2, 3)), time=1.0)
    with pytest.raises(StepSizeTooSmall) as caught:
        system.integrate(state, 10.0)
    error = caught.value
    assert isinstance(error, fullbody.FullbodyError)
    assert isinstance(error, RuntimeError)
    assert error.time == pytest.approx(1.0 + np.pi * np.sqrt(1.5**3 / (8 * 2.0 * 4.0)), rel=1e-9)
    assert abs(error.step) < 1e-12
    assert "time" in str(error)
    assert error.run.time[-1] <= error.time
    assert np.isfinite(error.run.position).all()


@pytest.mark.filterwarnings("ignore:A and B start at 1 km / h relative to each other")
def test_errors_of_overlap_have_the_distance_or_the_time():
    system = fullbody.System(SPHERES, G=1.0)
    near = fullbody.State([[0, 0, 0], [1.5, 0, 0]], np.zeros((2, 3)))
    for call, what in (
        (lambda: system.integrate(near, 1.0), "A and B overlap at the start, their centres 1.5 apart;"),
        (lambda: fullbody.Simulation(system, near), "A and B overlap at the start, their centres 1.5 apart;"),
        (lambda: system.energy(near), "A and B overlap, their centres 1.5 apart;"),
        (lambda: system.interactions(near), "A and B overlap, their centres 1.5 apart;"),
    ):
        with pytest.raises(BodiesOverlap, match=what) as caught:
            call()
        assert "Contact" not in str(caught.value)
        assert caught.value.bodies == ("A", "B")
        assert isinstance(caught.value, RuntimeError)
    # From 5 apart at a speed of one they touch at 3.
    bodies = [fullbody.Body(body.shape, mass=1e9, name=body.name) for body in SPHERES]
    units = fullbody.System(bodies, units=("km", "hour", "kg"))
    falling = fullbody.State([[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [-1, 0, 0]])

    def steps():
        sim = fullbody.Simulation(units, falling, integrator=fullbody.SymplecticSplitting(step=0.1))
        while True:
            sim.step()

    for run in (steps, lambda: units.integrate(falling, 9.0, output=1.0)):
        with pytest.raises(BodiesOverlap, match=r"A and B overlap at time \d(\.\d+)? h; .*events\.Contact") as caught:
            run()
        assert 2.9 < caught.value.time < 9.0
    assert caught.value.run.time[-2].value == 2.0
    assert 2.0 < caught.value.run.time[-1].value < 3.0
