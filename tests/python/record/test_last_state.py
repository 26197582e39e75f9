"""A run that an error ends keeps the last state that it reached."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import BodiesOverlap


def falling():
    """Two spheres that meet after pi/2 sqrt(d^3 / (2 G m)) times a factor: long after the first samples."""
    bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=1.0, name=name) for name in "AB"]
    state = fullbody.State([[0, 0, 0], [2.0, 0, 0]], np.zeros((2, 3)))
    return fullbody.System(bodies, G=1.0), state


@pytest.mark.parametrize("output", ["ends", 100.0, [0.5, 90.0], None])
@pytest.mark.parametrize("derivatives", [False, True])
def test_the_last_sample_is_the_state_at_the_end_of_the_last_step(output, derivatives):
    system, state = falling()
    sim = fullbody.Simulation(system, state)
    with pytest.raises(BodiesOverlap) as caught:
        sim.integrate(100.0, output=output, derivatives=derivatives)
    run = caught.value.run
    assert run.time[-1] == sim.time > 1.5
    assert (run.position[-1] == sim.state.position).all()
    assert (np.diff(run.time) > 0).all()
    if derivatives:
        assert run.transition.shape == (len(run), 24, 24)
    # Free fall: v^2 = 2 G (m + m) (1/r - 1/d), from the start to that state.
    r = np.linalg.norm(run.position[-1, 1] - run.position[-1, 0])
    v = np.linalg.norm(run.velocity[-1, 1] - run.velocity[-1, 0])
    assert v**2 == pytest.approx(4.0 * (1.0 / r - 0.5), rel=1e-10)


def test_the_last_sample_of_an_interrupted_run_is_its_last_step():
    system, state = fullbody.systems.case1()
    seen = []

    def stop(done, total, description):
        seen.append(done)
        if done > 20.0:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError) as caught:
        system.integrate(state, 1e6, output="ends", progress=stop)
    run = caught.value.run
    assert len(run) == 2
    assert run.time[-1] == seen[-1]
