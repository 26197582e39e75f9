"""Branches, folds, and all equilibria of an angular momentum; two spheres in closed form."""

import fullbody
import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support import refused

analysis = fullbody.analysis


@pytest.fixture(scope="module")
def spheres():
    """Two spheres, their reduced mass and the sum of their moments of inertia; G = 1."""
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0), fullbody.Body(fullbody.Sphere(0.6), mass=0.4)]
    return fullbody.System(bodies, G=1.0), 0.4 / 1.4, 0.4 * (1.0 + 0.4 * 0.36)


def momentum(d, m, inertia):
    return np.sqrt(1.4) * (m * np.sqrt(d) + inertia / d**1.5)


def test_the_fold_of_two_spheres_is_that_of_the_closed_form(spheres):
    # dJ/dd = 0 where m d^2 = 3 I.
    system, m, inertia = spheres
    fold = np.sqrt(3 * inertia / m)
    far = analysis.relative_equilibrium(system, separation=4.0)
    for over, until, end in (("separation", 1.7, "reached"), ("angular_momentum", 0.1, "contact")):
        branch = analysis.branch(far, over, until=until)
        assert branch.end == end
        assert [result.quantity for result in branch.folds] == ["angular_momentum"]
        result = branch.folds[0].equilibrium
        # Near the fold the momentum is flat: the place has half the digits of the value.
        assert result.separation == pytest.approx(fold, rel=1e-9)
        assert result.angular_momentum == pytest.approx(momentum(fold, m, inertia), rel=1e-14)
        np.testing.assert_allclose(branch.angular_momentum, momentum(branch.separation, m, inertia), rtol=1e-12)
        assert np.array_equal(branch.energetically_stable, branch.separation > fold)
        # Spheres exert no torque: to leave the nearer ones they would have to lose energy.
        assert branch.linearly_stable.all()
    assert branch.separation[-1] == pytest.approx(1.6, abs=1e-5)


def test_equilibria_of_two_spheres_are_the_roots_of_a_quartic(spheres):
    system, m, inertia = spheres
    J = 0.7
    # m x^4 - J x^3 / sqrt(GM) + I = 0 with x^2 = d.
    quartic = np.roots([m, -J / np.sqrt(1.4), 0.0, 0.0, inertia])
    expected = np.sort([x.real**2 for x in quartic if abs(x.imag) < 1e-9 and x.real > 0 and x.real**2 > 1.6])
    result = analysis.equilibria(system, J)
    assert sorted(equilibrium.separation for equilibrium in result.apart) == pytest.approx(expected, rel=1e-12)
    energies = [J**2 / (2 * (m * d**2 + inertia)) - 0.4 / d for d in expected]
    assert sorted(equilibrium.energy for equilibrium in result.apart) == pytest.approx(sorted(energies), rel=1e-12)
    # At rest upon each other.
    assert result.least.energy == pytest.approx(min(*energies, J**2 / (2 * (m * 1.6**2 + inertia)) - 0.4 / 1.6))


def test_the_state_of_least_energy_changes_from_contact_to_an_orbit(spheres):
    system, m, inertia = spheres
    touching = m * 1.6**2 + inertia
    # They rest upon each other while J^2 m d / touching^2 < G m m / d^2.
    limit = np.sqrt(0.4 / 1.6**2 / (m * 1.6)) * touching
    for J, rests, orbits in ((0.4, True, 0), (0.99 * limit, True, None), (1.01 * limit, False, None)):
        result = analysis.equilibria(system, J)
        assert bool(result.touching) == rests
        if orbits is not None:
            assert len(result.apart) == orbits
            assert isinstance(result.least, analysis.Touching)
        if rests:
            assert result.touching[0].energy == pytest.approx(J**2 / (2 * touching) - 0.4 / 1.6, rel=1e-12)
    assert isinstance(result.least, analysis.RelativeEquilibrium)
    assert result.least.energetically_stable


def test_ellipsoids_with_long_axes_in_line_have_the_least_energy(ellipsoids):
    result = analysis.equilibria(ellipsoids, 0.75)
    assert not result.failures
    stable = [equilibrium for equilibrium in result.apart if equilibrium.energetically_stable]
    assert len(stable) == 1
    assert result.apart[0] is stable[0]
    # Two separations for each of the 36 alignments, but where the nearer one would overlap.
    assert 36 <= len(result.apart) <= 72
    same = analysis.relative_equilibrium(ellipsoids, angular_momentum=0.75)
    assert same.energy == pytest.approx(stable[0].energy, rel=1e-13)
    # Stationary points of the amended potential: J dOmega has no part in the energy, dE = Omega dJ along a family.
    lower, upper = (analysis.relative_equilibrium(ellipsoids, angular_momentum=0.75 * (1 + h)) for h in (-1e-4, 1e-4))
    slope = (upper.energy - lower.energy) / (upper.angular_momentum - lower.angular_momentum)
    assert slope == pytest.approx(same.rate, rel=1e-7)


def test_a_branch_is_drawn_with_its_stability_and_folds(spheres):
    import matplotlib.pyplot as plt

    far = analysis.relative_equilibrium(spheres[0], separation=3.0)
    branch = analysis.branch(far, until=1.9)
    _, (first, other) = plt.subplots(1, 2)
    assert branch.plot(first) is first
    assert branch.plot(other, x="angular_momentum", y="frequency") is other
    assert first.get_xlabel() == "separation [system units]"
    assert {text.get_text() for text in first.get_legend().get_texts()} == {
        "minimum of energy",
        "linearly stable",
        "fold in angular momentum",
    }
    assert len(far.modes.plot()) == len(far.modes) == 1
    result = analysis.section(spheres[0], far.state.kick(1, [0, 0.02, 0]), 90.0, fullbody.events.Periapsis(0, 1))
    drawn = result.plot(lambda state: state.time, lambda state: state.position[1, 0])
    assert len(drawn.lines[0].get_xdata()) == len(result.crossings[0]) > 1
    refused("y is 'mass'; expected 'separation'", lambda: branch.plot(y="mass"))
    plt.close("all")


def test_curvatures_are_those_of_the_second_order_model(ellipsoids):
    # Scheeres (2009), Celest. Mech. Dyn. Astron. 104, 103: long axes in line, to second degree in the moments.
    system = ellipsoids.with_options(gravity="multipole:2")
    inertia = [np.asarray(body.inertia) for body in system]
    masses = np.asarray(system.masses)
    m, total = masses.prod() / masses.sum(), masses.sum()
    excess = sum((i[1] + i[2] - 2 * i[0]) / mass for i, mass in zip(inertia, masses, strict=True))
    polar = inertia[0][2] + inertia[1][2]

    def momentum(r):
        rate = np.sqrt(total / r**3 * (1 + 1.5 * excess / r**2))
        return rate * (m * r**2 + polar)

    result = analysis.relative_equilibrium(system, separation=3.0)
    assert result.angular_momentum == pytest.approx(momentum(3.0), rel=1e-13)
    branch = analysis.branch(result, until=1.7)
    fold = minimize_scalar(momentum, bounds=(1.5, 4.0), method="bounded", options={"xatol": 1e-10}).x
    assert branch.folds[0].equilibrium.separation == pytest.approx(fold, rel=1e-6)
    assert branch.folds[0].equilibrium.angular_momentum == pytest.approx(momentum(fold), rel=1e-12)
    # Farther than the fold it is a minimum of energy, nearer it is unstable.
    assert np.array_equal(branch.energetically_stable, branch.separation > fold)
    assert np.array_equal(branch.linearly_stable, branch.separation > fold)
