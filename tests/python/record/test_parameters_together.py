"""The derivative with respect to a parameter does not depend on the other parameters that are asked for."""

import fullbody
import numpy as np
import pytest


def sun_beside_a_composite(of):
    parts = [
        fullbody.Part(fullbody.Sphere(0.5), mass=0.6, position=(0.4, 0.1, 0.2)),
        fullbody.Part(fullbody.Ellipsoid(0.5, 0.4, 0.3), mass=0.4, position=(-0.5, 0.0, -0.1)),
    ]
    bodies = [
        fullbody.Body(fullbody.Composite(parts), name="A"),
        fullbody.Body(fullbody.Sphere(0.3), mass=0.2, name="B"),
    ]
    orbit = fullbody.KeplerElements(40.0, 0.2, 0.3, 0.4, 0.5, 0.6)
    sun = fullbody.forces.ThirdBody(orbit=orbit, of=of, time=0.3, mass=300.0, name="Sun")
    system = fullbody.System(bodies, G=1.0, gravity="multipole:2", forces=[sun])
    state = fullbody.State(
        position=[[-0.5, 0.0, 0.0], [2.5, 0.0, 0.0]],
        velocity=[[0.0, -0.1, 0.0], [0.0, 0.5, 0.1]],
        spin=[[0.1, 0.2, 0.5], [0.0, 0.0, 0.4]],
    )
    return system, state


@pytest.mark.parametrize("of", ["system", "body"])
@pytest.mark.parametrize("integrator", [fullbody.Verner98(1e-12, 1e-12), fullbody.LieGroupVariational(step=0.05)])
def test_each_derivative_is_the_same_alone_and_beside_others(integrator, of):
    system, state = sun_beside_a_composite(of)
    names = [name for name in system.parameters if name.endswith("of Sun")] + ["mass of A", "G"]
    together = system.integrate(state, 4.0, integrator=integrator, derivatives=names).sensitivity
    for name in names:
        alone = system.integrate(state, 4.0, integrator=integrator, derivatives=[name]).sensitivity[name][-1]
        # The steps of an adaptive integrator depend on the derivatives that are asked for.
        np.testing.assert_allclose(together[name][-1], alone, rtol=0, atol=1e-8 * np.abs(alone).max(), err_msg=name)
