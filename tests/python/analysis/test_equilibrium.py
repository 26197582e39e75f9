"""Relative equilibria and their modes: closed forms, limits of small figures, runs."""

import fullbody
import mpmath
import numpy as np
import pytest
import support
from scipy.special import elliprd
from support import body_list

analysis = fullbody.analysis
AXES = (0.5, 0.42, 0.37)


@pytest.mark.parametrize("line", "xyz")
@pytest.mark.parametrize("separation", [1.6, 2.5, 40.0])
def test_rate_of_sphere_and_ellipsoid_is_the_closed_form(line, separation):
    bodies = body_list(A=(fullbody.Sphere(1.0), 1.0), B=(fullbody.Ellipsoid(*AXES), 0.3))
    pole = {"x": "z", "y": "z", "z": "x"}[line]
    system = fullbody.System(bodies, G=1.0)
    result = analysis.relative_equilibrium(system, separation=separation, axes={"B": line + pole})
    # Outside along an axis, kappa = r^2 - a^2: g = G M r R_D(b^2 + kappa, c^2 + kappa; r^2).
    a = AXES["xyz".index(line)]
    squares = [AXES[k] ** 2 + separation**2 - a**2 for k in range(3) if "xyz"[k] != line]
    expected = 1.3 * elliprd(*squares, separation**2)
    assert abs(result.rate**2 / expected - 1) < 1e-14
    assert abs(result.separation / separation - 1) < 1e-15
    assert result.residual < 1e-14
    assert len(result.modes) == 4


def test_roll_and_yaw_frequencies_of_a_small_satellite_are_those_of_the_gravity_gradient():
    # Kane's and Hughes' quartic of a satellite under the gravity gradient, x along the line and z along the normal.
    a, b, c = 1.0, 0.9, 0.8
    A, B, C = b * b + c * c, a * a + c * c, a * a + b * b
    roll, yaw = (C - A) / B, (C - B) / A
    expected = np.sqrt(np.roots([1.0, -(1 + 3 * roll + roll * yaw), 4 * roll * yaw]))
    bodies = body_list((fullbody.PointMass(), 1.0), (fullbody.Ellipsoid(1e-3 * a, 1e-3 * b, 1e-3 * c), 1e-9))
    result = analysis.relative_equilibrium(fullbody.System(bodies, G=1.0), separation=1.0)
    out = result.modes.frequency[~result.modes.in_plane] / result.rate
    np.testing.assert_allclose(np.sort(out), np.sort(expected), rtol=1e-5)


def test_a_body_of_revolution_along_the_line_has_one_mode_out_of_the_plane():
    # The quartic above for B = C: its other root belongs to turns about the axis, which change nothing.
    a, b = 1.0, 0.8
    A, B = 2 * b * b, a * a + b * b
    bodies = body_list((fullbody.PointMass(), 1.0), (fullbody.Ellipsoid(1e-3 * a, 1e-3 * b, 1e-3 * b), 1e-9))
    equilibrium = analysis.relative_equilibrium(fullbody.System(bodies, G=1.0), separation=1.0)
    out = equilibrium.modes.frequency[~equilibrium.modes.in_plane] / equilibrium.rate
    np.testing.assert_allclose(out, [np.sqrt(1 + 3 * (B - A) / B)], rtol=1e-5)


def test_epicyclic_frequencies_about_a_spheroid_are_the_closed_form():
    # A light sphere about a heavy spheroid: the radial and the vertical frequency of a particle in its field.
    a, c, r = 1.0, 0.7, 1.9
    bodies = body_list(A=(fullbody.Ellipsoid(a, a, c), 1.0), B=(fullbody.Sphere(1e-4), 1e-9))
    result = analysis.relative_equilibrium(fullbody.System(bodies, G=1.0), separation=r, spin={"A": 2.3})

    def squared_rate(x):
        kappa = x * x - a * a
        return mpmath.elliprd(a * a + kappa, c * c + kappa, x * x)

    vertical = mpmath.sqrt(mpmath.elliprd(r * r, r * r, c * c + r * r - a * a))
    radial = mpmath.sqrt(r * mpmath.diff(squared_rate, r) + 4 * squared_rate(r))
    modes = result.modes
    assert modes.frequency[modes.in_plane][0] == pytest.approx(float(radial), rel=1e-8)
    assert np.abs(modes.frequency / float(vertical) - 1).min() < 1e-8
    assert result.locked == ("B",)
    # The third one is the free nutation of the spheroid, as seen from the turning frame.
    nutation = 2.3 * (2 * a * a / (a * a + c * c))
    assert np.abs(modes.frequency - (nutation - result.rate)).min() < 1e-8


def test_frequencies_of_modes_are_those_of_integrated_motions(ellipsoids, locked):
    modes = locked.modes
    for mode, coordinate in ((3, 1), (5, None)):
        assert modes.in_plane[mode] == (coordinate is not None), modes.frequency
        period = modes.period[mode]
        run = ellipsoids.integrate(modes.excited(mode, 1e-5), 40 * period, output=period / 16)
        angles = fullbody.observables.roll_pitch_yaw(run, body="B", about="A")
        angle = np.asarray(angles)[:, 2 if coordinate else 0]
        result = analysis.frequencies(run, angle, n=1)
        assert result.frequency[0] == pytest.approx(modes.frequency[mode], rel=1e-6)


def test_the_pose_of_an_equilibrium_is_constant_in_a_run():
    # Bodies without planes of symmetry, whose equilibrium no alignment of axes is.
    parts = [
        fullbody.Part(fullbody.Ellipsoid(0.6, 0.5, 0.4), mass=0.6, position=(0.0, 0.0, 0.0)),
        fullbody.Part(fullbody.Ellipsoid(0.3, 0.35, 0.25), mass=0.15, position=(0.7, 0.2, 0.3)),
    ]
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(1.0, 0.9, 0.8), mass=1.0, name="A"),
        fullbody.Body(fullbody.Composite(parts), name="B"),
    ]
    system = fullbody.System(bodies, G=1.0)
    result = analysis.relative_equilibrium(system, separation=3.0)
    assert result.residual < 1e-14
    assert len(result.modes) == 7
    tilt = np.degrees(np.arccos(np.abs(result.state.rotation_matrix[1]).max(axis=0)))
    assert tilt.max() > 0.5
    run = system.integrate(result.state, 2 * result.period, output=result.period / 7)
    apart = run.position[:, 1] - run.position[:, 0]
    assert np.ptp(np.linalg.norm(apart, axis=1)) < 1e-11
    R = np.array([state.rotation_matrix for state in run])
    relative = np.swapaxes(R[:, 0], 1, 2) @ R[:, 1]
    assert support.angle_between(relative, relative[0]).max() < 1e-10


def test_a_rotated_and_moving_start_gives_the_same_equilibrium(ellipsoids, locked):
    # A state that is rotated and moves on has the same equilibrium.
    q = np.array([0.9, 0.1, -0.3, 0.2]) / np.linalg.norm([0.9, 0.1, -0.3, 0.2])
    R = support.matrix(q)
    state = locked.state
    rotated = fullbody.State(
        state.position @ R.T + 1.0,
        state.velocity @ R.T + [0.1, 0.2, 0.3],
        [support.quaternion_product(q, a) for a in state.attitude],
        state.spin,
    )
    for options in ({"angular_momentum": locked.angular_momentum}, {"rate": locked.rate}, {"separation": 4.0}):
        result = analysis.relative_equilibrium(ellipsoids, start=rotated, **options)
        assert result.separation == pytest.approx(4.0, rel=1e-12)
        np.testing.assert_allclose(result.modes.frequency, locked.modes.frequency, rtol=1e-9)


def test_curvatures_are_second_derivatives_of_the_amended_potential(ellipsoids, locked):
    # With the pose changed along the eigenvector and the momenta chosen best, the energy grows by half the curvature.
    values, vectors = locked.rotation.amended_hessian()
    assert len(values) == 8
    J = np.array([0.0, 0.0, locked.angular_momentum])
    masses, inertia = ellipsoids.masses, [body.inertia for body in ellipsoids]

    def amended(pose):
        state = locked.rotation.pair.state(pose)
        total = np.zeros((3, 3))
        m = masses.prod() / masses.sum()
        total += m * (pose.r @ pose.r * np.eye(3) - np.outer(pose.r, pose.r))
        for R, moments in zip(np.asarray(state.rotation_matrix), inertia, strict=True):
            total += R @ np.diag(moments) @ R.T
        displaced_state = fullbody.State(state.position, state.velocity, state.attitude, state.spin)
        energy = ellipsoids.interactions(displaced_state).potential_energy
        return energy + J @ np.linalg.solve(total, J) / 2

    unit = masses.prod() / locked.separation
    for value, vector in zip(values, vectors.T, strict=True):
        h = 5e-4
        pose = locked.rotation.pose
        result = (
            (amended(pose.displaced(h * vector)) - 2 * amended(pose) + amended(pose.displaced(-h * vector)))
            / h**2
            / unit
        )
        assert result == pytest.approx(value, rel=1e-4, abs=1e-6)
    assert locked.energetically_stable


def test_the_energy_form_is_conserved_by_the_linear_equations(locked):
    # A^T Q + Q A = 0 for the rates A and the energy Q of deviations; with bodies that spin as well.
    bodies = body_list(A=(fullbody.Ellipsoid(1.0, 1.0, 0.8), 1.0), B=(fullbody.Ellipsoid(*AXES), 0.3))
    spinning = fullbody.System(bodies, G=1.0)
    other = analysis.relative_equilibrium(spinning, separation=2.5, spin={"A": -1.7})
    assert len(other.modes) == 6
    for result in (locked, other):
        A, Q = result.rotation.rates(), result.rotation.energy_form()
        assert np.abs(A.T @ Q + Q @ A).max() < 1e-14
        assert np.abs(A @ result.rotation.generators()).max() < 1e-15
        _, a, q = result.rotation.reduced()
        assert np.abs(a.T @ q + q @ a).max() < 1e-13 * np.abs(q).max()


def test_equilibrium_about_a_rotating_primary_is_that_of_its_mean_field():
    system, _ = fullbody.systems.kw4()
    mean = analysis.averaged(system, "Alpha", copies=8)
    result = analysis.relative_equilibrium(mean, separation=2.54, spin={"Alpha": 2.27})
    assert result.locked == ("Beta",)
    assert len(result.modes) == 6
    assert result.linearly_stable
    # The mean of the forces that the turning primary exerts.
    forces = []
    for angle in np.linspace(0.0, np.pi, 8, endpoint=False):
        rotated = result.state.rotated("Alpha", [0, 0, 1], angle)
        forces.append(system.interactions(rotated).force)
    mean_force = np.mean(forces, axis=0)
    scale = np.abs(mean_force).max()
    assert support.worst(mean.interactions(result.state).force, mean_force, scale) < 1e-13


def test_equilibria_have_the_units_of_the_system():
    unitless, _ = fullbody.systems.kw4()
    with_units, _ = fullbody.systems.kw4(units=True)
    reference = analysis.relative_equilibrium(unitless, separation=4.0)
    other = analysis.relative_equilibrium(with_units, separation="4000 m")
    assert other.rate.to_value("rad / h") == pytest.approx(reference.rate, rel=1e-9)
    assert str(other.modes.frequency.unit) == "rad / h"
    assert "4 km" in repr(other)
    assert "Modes" in other._repr_html_()
    run = with_units.integrate(other.state, other.period / 10)
    assert len(run) > 1
