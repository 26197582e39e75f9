"""Invalid input to the analysis functions raises errors that name it; folds and contact raise errors too."""

import fullbody
import numpy as np
import pytest
import support
from fullbody.errors import InvalidInput, NotConverged
from support import refused
from support.meshes import box

analysis = fullbody.analysis
E, S = analysis.relative_equilibrium, fullbody.FullbodyError


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "none given; expected one of separation, angular_momentum and rate"),
        ({"separation": 3.0, "rate": 1.0}, "separation, rate given; expected one of"),
        ({"separation": -3.0}, "separation is -3.0; expected a finite number above zero"),
        ({"separation": np.nan}, "separation is nan; expected a finite number"),
        ({"separation": 0.9}, "A and B overlap, their centres 0.9 apart"),
        ({"angular_momentum": 1e-3}, "no relative equilibrium of these axes has the angular momentum 0.001; .* least"),
        ({"separation": 3.0, "spin": {"A": 1.0}}, r"A, which has no axis of symmetry; .*averaged\(system, 'A'\)"),
        ({"separation": 3.0, "spin": {"C": 1.0}}, "a body of spin is 'C'; expected one of A, B"),
        ({"separation": 3.0, "spin": 1.0}, "spin is 1.0; expected spins by names of bodies"),
        ({"separation": 3.0, "axes": {"B": "xx"}}, "axes of B is 'xx'; expected two of x, y and z"),
    ],
)
def test_bad_arguments_of_equilibria_are_refused(ellipsoids, arguments, message):
    with pytest.raises(S, match=message):
        E(ellipsoids, **arguments)


@pytest.mark.parametrize("copies", [2, 3])
def test_equal_moments_of_inertia_are_no_axis_of_symmetry(ellipsoids, copies):
    """The crossed ellipsoids have equal moments across z, and torques of degree 2 times their number of copies."""
    crossed = analysis.averaged(ellipsoids, "A", copies=copies)
    moments = crossed["A"].inertia
    assert moments[0] == pytest.approx(moments[1], rel=1e-15)
    with pytest.raises(S, match="A, which has no axis of symmetry"):
        E(crossed, separation=3.0, spin={"A": 1.0})


def test_a_cube_is_no_sphere():
    bodies = support.body_list(A=(box(1.0, 1.0, 1.0), 1.0), B=(fullbody.Sphere(0.5), 1.0))
    system = fullbody.System(bodies, G=1.0)
    with pytest.raises(S, match="A, which has no axis of symmetry"):
        E(system, separation=2.0, spin={"A": 1.0})


def test_systems_that_have_no_equilibria_are_refused(ellipsoids, locked):
    alone = fullbody.System([ellipsoids["A"]], G=1.0)
    refused("the system has 1 bodies; expected two", lambda: E(alone, separation=1.0))
    tide = fullbody.forces.Tide(on="A", by="B", k2=1e-5, lag=0.01)
    with pytest.raises(InvalidInput, match=r"external forces \(tide on A\); expected system.with_forces"):
        E(ellipsoids.with_forces([tide]), separation=3.0)
    still = fullbody.State([[0, 0, 0], [4, 0, 0]], np.zeros((2, 3)))
    refused("start has no angular momentum", lambda: E(ellipsoids, separation=3.0, start=still))
    refused("axes and start are both given", E, ellipsoids, separation=3.0, start=locked.state, axes={"B": "xz"})
    refused("copies is 1; expected a whole number, 2 or more", lambda: analysis.averaged(ellipsoids, "A", copies=1))


def test_errors_at_folds_name_the_quantity():
    # Two spheres at the fold in J, where Newton's step is singular.
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0), fullbody.Body(fullbody.Sphere(0.6), mass=0.4)]
    system = fullbody.System(bodies, G=1.0)
    fold = np.sqrt(3 * 0.4576 / (0.4 / 1.4))
    start = E(system, separation=fold * 1.05).state
    least = np.sqrt(1.4) * (0.4 / 1.4 * np.sqrt(fold) + 0.4576 / fold**1.5)
    with pytest.raises(NotConverged, match="angular momentum"):
        E(system, angular_momentum=least * (1 - 1e-6), start=start)
    with pytest.raises(NotConverged, match="no relative equilibrium of these axes"):
        E(system, angular_momentum=least * (1 - 1e-6))
    assert analysis.equilibria(system, least * 0.99).apart == ()


def test_the_equilibrium_of_two_points_is_keplers():
    # Kepler: no modes but the orbit's own, of the same frequency.
    system = support.points(1.0, 0.5)
    result = E(system, separation=2.0)
    assert result.rate == pytest.approx(np.sqrt(1.5 / 8.0), rel=1e-14)
    assert result.modes.frequency == pytest.approx([float(result.rate)], rel=1e-9)
    assert E(system, angular_momentum=0.7).separation == pytest.approx(0.7**2 / (1 / 9) / 0.5 * 1 / 3, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": -1.0}, "period is -1.0; expected a finite number above zero"),
        ({"period": 5.0, "segments": 0}, "segments is 0; expected a whole number above zero"),
        ({"period": 5.0, "tolerance": 0.0}, "tolerance is 0.0; expected a finite number above zero"),
        ({"period": 5.0, "hold": 3}, "hold is 3; expected some of period, energy, angular_momentum"),
        ({"period": 5.0, "hold": "momentum"}, "hold has 'momentum'; expected some of period, energy, angular_momentum"),
        ({"period": 11.0, "hold": ["energy", "period", "angular_momentum"]}, "no periodic orbit found"),
    ],
)
def test_bad_arguments_of_periodic_orbits_are_refused(ellipsoids, locked, options, message):
    start = locked.state.kick("B", [0.02, 0.01, 0.03]).rotated("B", [1, 2, 3], 0.4)
    with pytest.raises(S, match=message):
        analysis.periodic_orbit(ellipsoids, start, **options)


def test_bad_arguments_of_branches_and_sections_are_refused(ellipsoids, locked):
    refused(r"over is 'rate'; expected 'separation' or 'angular_momentum'", analysis.branch, locked, "rate", until=1.0)
    refused(r"until is -1\.0; expected a finite number above zero", lambda: analysis.branch(locked, until=-1.0))
    refused(r"equilibrium is 3; expected a RelativeEquilibrium", lambda: analysis.branch(3, until=1.0))
    assert analysis.branch(locked, until=3.0, steps=2).end == "steps"
    refused(r"angular_momentum is 0\.0; expected a finite number above zero", analysis.equilibria, ellipsoids, 0.0)
    refused("mode is 9; expected 0 to 6", lambda: locked.modes.excited(9, 0.1))
    refused(r"event is 3; expected one of fullbody\.events", lambda: analysis.section(ellipsoids, locked.state, 1.0, 3))
    run = ellipsoids.integrate(locked.state, 5.0, output=0.5)
    event = fullbody.events.Periapsis("A", "B")
    refused("states is 3; expected a State", lambda: analysis.section(ellipsoids, 3, 1.0, event))
    refused(r"quantity has shape \(3,\); expected \(11,\)", lambda: analysis.frequencies(run, np.zeros(3)))
    refused("quantity is 'yaw'; expected finite numbers", lambda: analysis.frequencies(run, "yaw"))
    refused(r"run is 3; expected a fullbody\.Run", lambda: analysis.frequencies(3, np.zeros(3)))
