"""YORP at the pole of the obliquity, where a torque across the spin has no direction."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import ForceFailed
from fullbody.forces import Yorp
from support import body_list
from support.scenes import body_alone

C = 0.4 * 0.25  # of a sphere of mass one and radius 1/2


def tilted(obliquity, across, until=None, **arguments):
    """A sphere with a spin of 3 at an obliquity, which a torque across the spin changes at the rate across / (C 3)."""
    attitude = (np.cos(obliquity / 2), -np.sin(obliquity / 2), 0.0, 0.0)
    system, state = body_alone(fullbody.Sphere(0.5), spin=(0, 0, 3.0), attitude=attitude)
    return system.with_forces([Yorp(on="A", along=0.0, across=across, name="YORP", **arguments)]), state


@pytest.mark.parametrize(
    ("obliquity", "across", "until"),
    [(0.02, -1e-3, 100.0), (np.pi - 0.02, 1e-3, 100.0), (0.02, 1e-3, -100.0), (np.pi - 0.02, -1e-3, -100.0)],
)
@pytest.mark.parametrize("derivatives", [False, True])
def test_a_spin_that_is_driven_to_its_pole_is_an_error_that_names_it(obliquity, across, until, derivatives):
    system, state = tilted(obliquity, across)
    with pytest.raises(ForceFailed, match=r"spin of A, at an obliquity of .* rad, to the pole by time") as caught:
        system.integrate(state, until, derivatives=derivatives)
    # The obliquity falls evenly; the last good state is a step before the pole.
    expected = np.copysign(0.02 * C * 3.0 / 1e-3, until)
    run = caught.value.run
    assert 0.5 * abs(expected) < abs(run.time[-1]) <= abs(expected)
    assert run.statistics.steps < 200
    spin = run[-1].rotation_matrix[0] @ run.spin[-1, 0]
    from_pole = np.arctan2(np.hypot(spin[0], spin[1]), abs(spin[2]))
    assert from_pole == pytest.approx(0.02 * (1.0 - run.time[-1] / expected), abs=1e-12)


def test_a_tumbling_body_that_is_driven_to_its_pole_ends_the_run():
    bodies = body_list(A=(fullbody.Ellipsoid(1.0, 0.9, 0.8), 1.0), B=(fullbody.Sphere(0.2), 1e-3))
    system = fullbody.System(bodies, G=1.0, forces=[Yorp(on="A", along=0.0, across=-1e-3)])
    spin = [[0.0, np.sin(0.02), np.cos(0.02)], [0, 0, 0]]
    state = fullbody.State([[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [0, 0.45, 0]], spin=spin)
    with pytest.raises(ForceFailed, match="to the pole by time") as caught:
        system.integrate(state, 200.0)
    assert caught.value.run.statistics.steps < 2000


def test_a_table_that_vanishes_at_the_poles_is_approached_exponentially():
    """By d eps/dt = -k sin(2 eps) with k = 1e-3 / (C 3), tan eps falls exponentially at the rate 2 k."""
    obliquity = np.linspace(0.0, np.pi, 181)
    arguments = {"obliquity": obliquity}
    system, state = tilted(0.3, 0.0)
    yorp = Yorp(on="A", along=np.zeros(181), across=-1e-3 * np.sin(2 * obliquity), name="YORP", **arguments)
    run = system.with_forces([yorp]).integrate(state, 2000.0, output=400.0)
    spin = np.array([state.rotation_matrix[0] @ state.spin[0] for state in run])
    result = np.hypot(spin[:, 0], spin[:, 1]) / spin[:, 2]
    expected = np.tan(0.3) * np.exp(-2e-3 / (C * 3.0) * run.time)
    np.testing.assert_allclose(result, expected, rtol=1e-5)
