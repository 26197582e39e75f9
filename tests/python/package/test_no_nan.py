"""Extreme numbers give an error of the package or finite numbers. Input of any kind is that of test_fuzz_targets.py."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import PrecisionWarning
from hypothesis import given, settings
from hypothesis import strategies as st
from support import refused

#: Random input also causes warnings.
pytestmark = pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")

#: Any double, with the troublemakers often.
anything = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(-10.0, 10.0),
    st.sampled_from([0.0, -0.0, 1.0, 5e-324, 1e-200, 1e-30, 1e30, 1e150, 1e200, 1.7e308, float("nan"), float("inf")]),
)


def numbers_of(value):
    for part in value if isinstance(value, tuple | list) else [value]:
        yield np.asarray(part, dtype=float)


def finite_or_refused(call):
    """The call raises a FullbodyError or gives finite numbers."""
    try:
        value = call()
    except fullbody.FullbodyError:
        return None
    for array in numbers_of(value):
        assert np.isfinite(array).all(), array
    return value


@pytest.mark.parametrize("size", [1e155, 1e200, 1e308])
def test_energies_and_momenta_that_overflow_are_finite_or_refused(size):
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)] * 2, G=1.0)

    def moving():
        return fullbody.State([[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [0, size, 0]], spin=[[0, 0, size]] * 2)

    finite_or_refused(lambda: system.energy(moving()).total)
    finite_or_refused(lambda: system.angular_momentum(moving()))
    finite_or_refused(lambda: fullbody.Body(fullbody.Ellipsoid(1, 2, 3), mass=1.0).gravity([size, 0, 0], 1.0).potential)


@pytest.mark.parametrize("gravity", ["surface", "focal", "multipole:2", "point"])
@pytest.mark.parametrize(("radius", "distance"), [(1.0, 1e110), (1.0, 1e160), (1.0, 1e300), (1e-50, 1e60)])
def test_separations_whose_force_would_underflow_are_refused(gravity, radius, distance):
    # The masses are such that the force itself is an ordinary number: zero would be wrong.
    shape = fullbody.Ellipsoid(radius, 0.9 * radius, 0.8 * radius)
    bodies = [fullbody.Body(shape, mass=1e150, name=name) for name in "AB"]
    system = fullbody.System(bodies, G=1.0, gravity=gravity)
    state = fullbody.State([[0, 0, 0], [0, distance, 0]], np.zeros((2, 3)))
    refused(r"separation of A and B is .*expected at most .*choose units", lambda: system.interactions(state))
    refused("separation of A and B", lambda: system.integrate(state, 1.0))


@pytest.mark.parametrize("gravity", ["surface", "focal", "multipole:2", "point"])
@pytest.mark.parametrize(("radius", "distance"), [(1.0, 1e100), (1e3, 1e99), (1e-50, 1e50)])
def test_the_largest_separations_keep_newtons_force(gravity, radius, distance):
    shape = fullbody.Ellipsoid(radius, 0.9 * radius, 0.8 * radius)
    system = fullbody.System([fullbody.Body(shape, mass=1e100)] * 2, G=1.0, gravity=gravity)
    force = system.interactions(fullbody.State([[0, 0, 0], [0, distance, 0]], np.zeros((2, 3)))).force
    newton = (1e100 / distance) ** 2
    assert np.allclose(force, [[0, newton, 0], [0, -newton, 0]], rtol=0, atol=1e-14 * newton)


@pytest.mark.parametrize("mass", [1e160, 1e308])
def test_forces_of_masses_whose_product_overflows_are_finite_or_refused(mass):
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=mass)] * 2, G=1.0)
    state = fullbody.State([[0, 0, 0], [5, 0, 0]], np.zeros((2, 3)))
    finite_or_refused(lambda: [system.interactions(state).force, system.energy(state).total])


@pytest.mark.parametrize("speed", [1e100, 1e200])
def test_runs_at_absurd_speed_end(speed):
    system = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)] * 2, G=1.0)
    state = fullbody.State([[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [speed, 0, 0]])
    finite_or_refused(lambda: system.integrate(state, 1.0).position)


@pytest.mark.parametrize("rtol", [1e-18, 1e-300])
def test_a_run_with_a_tolerance_below_round_off_ends(rtol):
    system, state = fullbody.systems.case1()

    def run():
        with pytest.warns(PrecisionWarning, match="raised to 6e-16"):
            integrator = fullbody.Verner98(rtol=rtol, atol=0.0)
        return system.integrate(state, 1.0, integrator=integrator).position

    finite_or_refused(run)


@given(*[anything] * 5, st.lists(anything, min_size=3, max_size=3), anything)
@settings(max_examples=100)
def test_the_field_of_any_body_is_finite_or_refused(a, b, c, mass, G, point, density):
    def evaluate():
        body = fullbody.Body(fullbody.Ellipsoid(a, b, c), mass=mass)
        return [(result := body.gravity(point, G)).potential, result.field, result.gradient]

    finite_or_refused(evaluate)
    finite_or_refused(lambda: fullbody.Body(fullbody.Ellipsoid(a, b, c), density=density).gravity(point, G).potential)
