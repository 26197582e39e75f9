"""Radar echoes compared with reference data, closed forms of spheres and boxes, meshes, and sums over points."""

import itertools

import astropy.units as u
import numpy as np
import pytest
from fullbody import Ellipsoid, Sphere, observing
from fullbody.base import rotations
from scipy.integrate import quad
from scipy.special import beta, betainc
from support import reference, worst
from support.echoes import C_LIGHT, F, at_rest, image, run_of, spectrum
from support.meshes import box, icosphere


@pytest.mark.parametrize("index", range(4))
def test_echoes_of_two_ellipsoids_are_those_of_an_independent_program(index):
    row = reference("radar")[index]
    names = ("position", "velocity", "attitude", "spin")
    run = run_of(*(Ellipsoid(*axes) for axes in row["semi_axes"]), masses=[1.0, 0.06], **{n: row[n] for n in names})
    geometry, law = at_rest(row["to_observer"]), observing.Cosine(row["C"], row["R"])
    options = {"transmit_frequency": row["transmitter_hz"], "law": law, "per_body": True}
    result = spectrum(run, row["frequency_edges_hz"], geometry, **options)
    images = image(run, row["delay_edges_s"], row["frequency_edges_hz"], geometry, **options)
    for body in range(2):
        assert worst(result[body], row["spectrum"][body]) < 2e-11
        assert worst(images[body], row["delay_doppler"][body]) < 2e-11
        assert (images[body][np.array(row["delay_doppler"][body]) == 0.0] == 0.0).all()
        assert result[body].sum() == pytest.approx(row["total"][body], rel=1e-11)


#: Exponents 2 C that are whole numbers and others, small and large, and laws with and without a cutoff.
LAWS = [observing.Cosine(C, 0.3) for C in (0.0, 0.2, 0.5, 1.0, 1.6, 7.3, 40.0)]
LAWS += [observing.Hagfors(30.0, 0.1), observing.Gaussian(4.0, 0.1), observing.Hagfors(30.0, 0.1, cutoff=0.4)]


def per_area(law, mu):
    """The cross section per area of the surface, by the laws of Magri et al. (2007)."""
    if isinstance(law, observing.Cosine):
        return law.R * (law.C + 1.0) * mu ** (2.0 * law.C)
    if isinstance(law, observing.Gaussian):
        return law.R * law.C * np.exp(-law.C * (1.0 / mu**2 - 1.0)) / mu**4
    return 0.5 * law.R * law.C * (mu**4 + law.C * (1.0 - mu**2)) ** -1.5


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_the_echo_of_a_sphere_in_a_bin_of_delay_is_the_integral_of_its_law(law):
    r, run = 0.7, run_of(Sphere(0.7), spin=[[0.0, 0.0, 1e-4]])
    mu = np.array([1.0, 0.97, 0.93, 0.6, 0.25, 1e-9])
    delays, one_bin = -2.0 * r * mu / C_LIGHT, [-100.0, 100.0]
    result = image(run, delays, one_bin, law=law)[:, 0]
    least = np.cos(getattr(law, "cutoff", np.pi / 2))
    ends = itertools.pairwise(np.maximum(mu, least))
    expected = [2 * np.pi * r**2 * quad(lambda x: per_area(law, x), b, a, epsrel=1e-13)[0] for a, b in ends]
    np.testing.assert_allclose(result, expected, rtol=1e-9, atol=1e-11 * sum(expected))


@pytest.mark.parametrize("C", [0.5, 1.0, 1.6, 0.2])
def test_the_spectrum_of_a_sphere_is_an_incomplete_beta_function(C):
    r, omega, R = 0.7, 1e-4, 0.3
    half_bandwidth = 2.0 * F / C_LIGHT * r * omega
    x = np.linspace(-1.1, 1.2, 24)
    result = spectrum(run_of(Sphere(r), spin=[[0.0, 0.0, omega]]), x * half_bandwidth, law=observing.Cosine(C, R))
    below = betainc(C + 1.0, C + 1.0, 0.5 * (1.0 + np.clip(x, -1.0, 1.0)))
    total = 2.0 * np.pi * r**2 * R * (C + 1.0) / (2.0 * C + 1.0)
    assert worst(result, total * np.diff(below)) < 2e-11
    assert (result[abs(x[1:] + x[:-1]) > 2.05] == 0.0).all()
    # The total is also a product of integrals over longitude and latitude.
    assert total == pytest.approx(R * (C + 1) * r**2 * beta(C + 0.5, 0.5) * beta(0.5, C + 1), rel=1e-12)


def test_the_side_that_approaches_has_positive_frequencies_and_the_near_side_negative_delays():
    # The radar is at +x. The pair rotates about +z: B, at y < 0, approaches and is nearer than A.
    run = run_of(
        Sphere(0.1), Sphere(0.1), position=[[-0.3, 0.3, 0], [0.3, -0.3, 0]], velocity=[[-1e-3, 0, 0], [1e-3, 0, 0]]
    )
    power = image(run, [-1e-5, 0.0, 1e-5], [-100.0, 0.0, 100.0], per_body=True)
    a, b = (image_of_body / image_of_body.sum() for image_of_body in power)
    # The far side, which recedes, and the near side, which approaches.
    assert a[1, 0] == pytest.approx(1.0)
    assert b[0, 1] == pytest.approx(1.0)


def test_the_echo_of_a_face_is_spread_evenly_over_its_frequencies():
    # A face of 0.6 by 0.4 km, seen along its normal, has one delay, and a bandwidth of 2 F omega / c times 0.6 km. Its
    # cross section is R (C + 1) times its area.
    run = run_of(box(1.0, 0.6, 0.4), spin=[[0.0, 0.0, 1e-4]])
    half_bandwidth = 2.0 * F / C_LIGHT * 0.3 * 1e-4
    edges = np.linspace(-2.0, 2.0, 9) * half_bandwidth
    delay = -2.0 * 0.5 / C_LIGHT
    result = image(run, delay * np.array([1.5, 1.1, 0.9, 0.5]), edges)
    expected = 0.3 * 2.0 * 0.6 * 0.4 * np.array([0, 0, 0.25, 0.25, 0.25, 0.25, 0, 0])
    np.testing.assert_allclose(result[1], expected, atol=1e-15)
    assert result[[0, 2]].max() == 0.0
    np.testing.assert_allclose(spectrum(run, edges), expected, atol=1e-15)


def test_an_ellipsoid_is_the_limit_of_its_meshes():
    axes, pose = (0.7, 0.5, 0.4), {"attitude": [[0.5, 0.1, -0.5, 0.7]], "spin": [[1e-4, 2e-4, 3e-4]]}
    delays, edges = np.linspace(-5e-6, 0.0, 9), np.linspace(-6.0, 6.0, 13)
    for law in (observing.Cosine(1.6, 0.3), observing.Hagfors(3.0, 0.3)):
        exact = image(run_of(Ellipsoid(*axes), **pose), delays, edges, law=law)
        errors = [worst(image(run_of(icosphere(n, axes), **pose), delays, edges, law=law), exact) for n in (3, 4)]
        assert errors[1] < 0.02
        assert errors[1] < 0.45 * errors[0]


def overlap(distance, r, R):
    """The area in which two discs overlap."""
    a, b = (distance**2 + r**2 - R**2) / (2 * distance), (distance**2 + R**2 - r**2) / (2 * distance)
    return r**2 * np.arccos(a / r) - a * np.sqrt(r**2 - a**2) + R**2 * np.arccos(b / R) - b * np.sqrt(R**2 - b**2)


def test_the_echo_of_what_another_body_hides_is_missing():
    # With C = 1/2 the echo is R (C + 1) = 1.5 times the projected visible area; the second sphere is nearer.
    r, R, separation = 0.7, 0.3, 0.6
    law = observing.Cosine(0.5, 1.0)
    position, spin = [[0, 0, 0], [2.0, 0, separation]], [[0.0, 2e-4, 1e-4], [0, 0, 0]]
    bins = np.linspace(-6.0, 6.0, 14)
    options = {"law": law, "per_body": True}
    expected = 1.5 * np.array([np.pi * r**2 - overlap(separation, r, R), np.pi * R**2])
    spheres = run_of(Sphere(r), Sphere(R), position=position, spin=spin)
    result = spectrum(spheres, bins, **options)
    np.testing.assert_allclose(result.sum(axis=1), expected, rtol=1e-11)
    images = image(spheres, np.linspace(-2e-5, 1e-5, 40), bins, **options)
    assert worst(images.sum(axis=1), result) < 1e-11
    faceted = spectrum(run_of(Sphere(r), icosphere(4, [R] * 3), position=position, spin=spin), bins, **options)
    assert worst(faceted[0], result[0]) < 5e-3
    alone = spectrum(spheres, bins, mutual=False, **options)
    assert alone[0].sum() == pytest.approx(1.5 * np.pi * r**2, rel=1e-12)
    assert (alone[0] >= result[0] - 1e-14).all()


def test_the_echo_for_a_bistatic_radar_is_that_of_the_surface_which_both_antennas_see():
    # Projected along the bisector, the surface that both antennas see is an ellipse with axis ratio cos(angle / 2).
    angle, edges = 0.8, np.linspace(-50.0, 50.0, 51)
    transmitter = at_rest([np.cos(angle), np.sin(angle), 0.0])
    run = run_of(Sphere(0.7), spin=[[1e-4, 2e-4, 3e-4]])
    options = {"law": observing.Cosine(0.5, 1.0), "transmitter": transmitter}
    result = spectrum(run, edges, **options)
    assert result.sum() == pytest.approx(1.5 * np.pi * 0.7**2 * np.cos(angle / 2), rel=1e-11)
    faceted = spectrum(run_of(icosphere(4, [0.7] * 3), spin=[[1e-4, 2e-4, 3e-4]]), edges, **options)
    assert worst(faceted, result) < 0.02
    assert worst(spectrum(run, edges, transmitter=at_rest()), spectrum(run, edges)) < 1e-12


def fibonacci(n):
    """Points on the unit sphere, evenly spaced."""
    k = np.arange(n) + 0.5
    z, angle = 1.0 - 2.0 * k / n, np.pi * (1.0 + 5.0**0.5) * k
    return np.stack([np.sqrt(1.0 - z * z) * np.cos(angle), np.sqrt(1.0 - z * z) * np.sin(angle), z], axis=1)


@pytest.mark.parametrize("bistatic", [False, True])
def test_frequencies_are_the_rates_of_change_of_the_path_lengths_of_points(bistatic):
    # Two rotating ellipsoids that orbit each other, 5e5 km from a radar that passes at 40 km/s.
    axes = (Ellipsoid(0.7, 0.6, 0.5), Ellipsoid(0.3, 0.2, 0.25))
    shares = np.array([-0.15, 1.0]) / 1.15
    position, velocity = np.outer(shares, [1.5, 1.8, 0.3]), np.outer(shares, [1e-5, 2e-4, -5e-5])
    spin = np.array([[1e-5, 2e-5, 3e-5], [-2e-5, 1e-5, 1e-5]])
    run = run_of(*axes, position=position, velocity=velocity, spin=spin, masses=[1.0, 0.15])
    # The bodies go on straight, and rotate about axes that are fixed for a while.
    rows, offset = np.linspace(-20.0, 20.0, 9), np.array([0.0, 2e5, 0.0])

    def antenna(t, far):
        return np.stack([far + 0 * t, 40.0 * t, 5.0 * t], axis=-1)

    geometry = observing.Geometry(rows * u.s, to_observer=antenna(rows, 5e5) * u.km)
    other = observing.Geometry(rows * u.s, to_observer=(antenna(rows, 4e5) + offset) * u.km)
    law = observing.Cosine(1.0, 0.3)
    edges, delays = np.linspace(-2.0, 4.0, 41), np.linspace(-2e-5, 1e-5, 21)
    # Light that arrives at this time has left the barycentre at time zero.
    moment = 5e5 / C_LIGHT
    for _ in range(5):
        moment = np.linalg.norm(antenna(np.array(moment), 5e5)) / C_LIGHT
    options = {"transmit_frequency": F, "law": law, "per_body": True, "transmitter": other if bistatic else None}
    result = observing.delay_doppler(run, [moment] * u.s, geometry, delays, edges, **options).power.to_value("km2")[0]

    def points_at(body, elapsed, normals):
        """Points of a body from its centre, their normals, and the centres, at times elapsed since the state."""
        rotation = rotations.matrices(rotations.of_vectors(spin[body] * elapsed[:, None]))
        semi_axes = np.array([axes[body].a, axes[body].b, axes[body].c])
        point = np.einsum("pij,pj->pi", rotation, normals * semi_axes)
        normal = np.einsum("pij,pj->pi", rotation, normals / semi_axes)
        return point, normal, position[body] + np.outer(elapsed, velocity[body])

    def path_lengths(t, body, normals):
        """Lengths of the paths of signals by points, minus that by the barycentre; normals; vectors to the antennas.

        The signals arrive at time t, to which the positions of both antennas belong.
        """
        receiver = antenna(np.array(t), 5e5)
        sender = antenna(np.array(t), 4e5) + offset if bistatic else receiver
        elapsed = np.full(len(normals), t - np.linalg.norm(receiver) / C_LIGHT)
        for _ in range(4):
            point, normal, centre = points_at(body, elapsed, normals)
            length = np.linalg.norm(receiver - centre - point, axis=1)
            elapsed = t - length / C_LIGHT
        point, normal, centre = points_at(body, elapsed, normals)
        out = np.linalg.norm(sender - centre - point, axis=1)
        excess = length + out - np.linalg.norm(receiver) - np.linalg.norm(sender)
        return excess, normal, [sender - centre[0], receiver - centre[0]]

    normals, step = fibonacci(200_000), 0.5
    for body in range(2):
        earlier, later = (path_lengths(moment + sign * step, body, normals)[0] for sign in (-1.0, 1.0))
        now, normal, antennas = path_lengths(moment, body, normals)
        frequency, delay = -F * (later - earlier) / (2 * step) / C_LIGHT, now / C_LIGHT
        e = [vector / np.linalg.norm(vector) for vector in antennas]
        bisector = (e[0] + e[1]) / np.linalg.norm(e[0] + e[1])
        size = np.linalg.norm(normal, axis=1)
        mu = np.where((normal @ e[0] > 0) & (normal @ e[1] > 0), normal @ bisector / size, 0.0)
        semi_axes = np.array([axes[body].a, axes[body].b, axes[body].c])
        # R (C + 1) cos^(2 C) is 0.6 mu^2; the other factors are the area of a point's share of the surface.
        weight = 0.6 * mu**2 * size * semi_axes.prod() * 4.0 * np.pi / len(normals)
        expected = np.histogram2d(delay, frequency, [delays, edges], weights=weight)[0]
        assert worst(result[body], expected) < 5e-3, body
    # The echo is within the bins.
    assert result.sum() > 0.3
