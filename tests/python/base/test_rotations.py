"""Rotations, volumes and moments that the core gives to the package, against scipy and textbook formulas."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody.base import rotations
from scipy.spatial.transform import Rotation
from support import inertia, refused

RNG = np.random.default_rng(4)
ROTATIONS = Rotation.random(60, RNG)
QUATERNIONS = ROTATIONS.as_quat(scalar_first=True)


@pytest.mark.parametrize("shape", [(60,), (4, 15), (5, 3, 4)])
def test_rotation_matrices_are_scipys(shape):
    matrices = rotations.matrices(QUATERNIONS.reshape(*shape, 4))
    assert np.abs(matrices - ROTATIONS.as_matrix().reshape(*shape, 3, 3)).max() < 1e-15
    assert np.abs(rotations.matrices(QUATERNIONS[3]) - ROTATIONS[3].as_matrix()).max() < 1e-15
    assert rotations.matrices(np.zeros((0, 4))).shape == (0, 3, 3)


def test_products_of_rotations_are_scipys():
    a, b, c = ROTATIONS[:20], ROTATIONS[20:40], ROTATIONS[40:]
    for k in range(20):
        expected = (a[k] * b[k] * c[k]).as_matrix()
        result = rotations.product(*(rotation.as_quat(scalar_first=True) for rotation in (a[k], b[k], c[k])))
        assert np.abs(rotations.matrices(result) - expected).max() < 2e-15
        assert abs(np.linalg.norm(result) - 1) < 1e-15
    for axis in range(3):
        for angle in (0.0, 0.3, -2.5, np.pi, 7.0):
            expected = Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix()
            assert np.abs(rotations.matrices(rotations.about_axis(axis, angle)) - expected).max() < 2e-15


def test_volume_and_inertia_with_and_without_units():
    axes, density = (0.7, 0.52, 0.31), 1.9
    volume = 4 * np.pi / 3 * np.prod(axes)
    body = fullbody.Body(fullbody.Ellipsoid(*axes), density=density)
    assert body.mass == pytest.approx(density * volume, rel=1e-15)
    assert body.inertia == pytest.approx(inertia(density * volume, axes), rel=1e-15)
    body = fullbody.Body(fullbody.Ellipsoid(*axes), mass=2.5)
    assert body.density == pytest.approx(2.5 / volume, rel=1e-15)
    # Each semi-axis has another unit.
    shape = fullbody.Ellipsoid(0.7 * u.km, 520 * u.m, 3.1e4 * u.cm)
    body = fullbody.Body(shape, density=1.9 * u.g / u.cm**3)
    expected = 1.9e12 * volume
    assert body.mass.to_value(u.kg) == pytest.approx(expected, rel=1e-14)
    assert body.inertia.to_value(u.kg * u.km**2) == pytest.approx(inertia(expected, axes), rel=1e-14)
    body = fullbody.Body(shape, mass=expected * u.kg)
    assert body.density.to_value(u.g / u.cm**3) == pytest.approx(1.9, rel=1e-14)
    point = fullbody.Body(fullbody.PointMass(), mass=3 * u.kg)
    assert (point.inertia == 0 * u.kg * u.m**2).all()
    assert point.density is None
    assert (fullbody.Body(fullbody.PointMass(), mass=3.0).inertia == np.zeros(3)).all()
    for mixed in (
        fullbody.Body(fullbody.Sphere(1.0), mass=1 * u.kg),
        fullbody.Body(fullbody.Sphere(1 * u.km), mass=1.0, name="Moon"),
    ):
        for name in ("density", "inertia"):
            refused("expected both or neither", lambda mixed=mixed, name=name: getattr(mixed, name))


def test_rates_are_those_of_a_uniform_rotation():
    rng = np.random.default_rng(5)
    attitudes, spins = rng.normal(size=(6, 4)), rng.normal(size=(6, 3))
    attitudes /= np.linalg.norm(attitudes, axis=1, keepdims=True)
    step = 1e-3
    # A difference of the second order, extrapolated.
    ahead, back, far, farther = (
        rotations.products(attitudes, rotations.of_vectors(by * spins)) for by in (step, -step, 2 * step, -2 * step)
    )
    expected = (8.0 * (ahead - back) - (far - farther)) / (12.0 * step)
    assert np.abs(rotations.rates(attitudes, spins) - expected).max() < 1e-11


def test_the_inverse_undoes_a_rotation():
    rotation = rotations.about([1.0, 2.0, -0.5], 0.7)
    np.testing.assert_allclose(
        rotations.product(rotations.inverse(rotation), rotation), [1.0, 0.0, 0.0, 0.0], atol=1e-15
    )
