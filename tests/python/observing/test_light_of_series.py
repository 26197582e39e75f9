"""The light of shapes by series of harmonics: closed forms, each other, and convergence with the number of faces."""

import fullbody
import numpy as np
import pytest
from fullbody import ConvexShape, HarmonicShape, observing
from fullbody.model.geodesic import geodesic_mesh, mesh_harmonics

AXES = np.array([1.2, 1.0, 0.85])
VIEWS = [([1.0, 0.2, 0.3], [0.8, 0.6, 0.1]), ([-0.3, 1.0, 0.4], [0.5, 0.9, -0.6]), ([0.1, -0.2, 1.0], [1.0, 0.1, 0.9])]


def closed_form(axes, toward, sunward):
    """The Lommel-Seeliger light of an ellipsoid (Muinonen & Lumme 2015)."""
    e, s = (np.array(v) / np.linalg.norm(v) for v in (toward, sunward))
    p, q = e / axes, s / axes
    s1, s2 = np.linalg.norm(q), np.linalg.norm(p)
    cosine = p @ q / (s1 * s2)
    total, angle = np.sqrt(s1**2 + s2**2 + 2 * s1 * s2 * cosine), np.arccos(cosine)
    lam = np.arctan2(s2 * np.sin(angle) / total, (s1 + s2 * cosine) / total)
    log = np.log(1 / np.tan(lam / 2) / np.tan((angle - lam) / 2))
    terms = np.cos(lam - angle) + np.cos(lam) + np.sin(lam) * np.sin(lam - angle) * log
    return np.pi / 2 * np.prod(axes) * s1 * s2 / total * terms


def light(shape, toward, sunward, **options):
    system = fullbody.System([fullbody.Body(shape, mass=1.0)], G=1.0)
    attitude = None if isinstance(shape, ConvexShape) else [system[0].working_frame.attitude * [1, -1, -1, -1]]
    state = fullbody.State([[0.0] * 3], [[0.0] * 3], attitude=attitude)
    return observing.brightness(system, state, toward, sunward, **options)[0]


def series(function, degree):
    return np.linalg.lstsq(mesh_harmonics(20, degree), np.log(function(geodesic_mesh(20).points)), rcond=None)[0]


@pytest.mark.parametrize("kind", [ConvexShape, HarmonicShape])
def test_light_converges_to_the_closed_form_of_the_ellipsoid(kind):
    if kind is ConvexShape:
        result = series(lambda n: np.prod(AXES) ** 2 / np.sum((n * AXES) ** 2, axis=1) ** 2, 12)
    else:
        result = series(lambda x: np.sum((x / AXES) ** 2, axis=1) ** -0.5, 12)
    e = np.random.default_rng(5).normal(size=(20, 3))
    views = list(zip(e, e / np.linalg.norm(e, axis=1)[:, None] + 0.7 * np.roll(e, 1, axis=0), strict=True))
    errors = []
    for faces in (500, 4000):
        shape = kind(result, faces=faces)
        errors.append(np.sqrt(np.mean([(light(shape, *view) / closed_form(AXES, *view) - 1) ** 2 for view in views])))
    assert errors[0] < 2e-2
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize("law", [observing.LommelSeeliger(), observing.Lambert(), observing.Hapke(asymmetry=-0.2)])
def test_facets_alone_are_as_bright_as_the_polyhedron_of_minkowskis_problem(law):
    degrees = np.floor(np.sqrt(np.arange(25) + 0.5))
    # Only even degrees: the facets close, so that the polyhedron has their areas.
    result = np.where(degrees % 2 == 0, np.random.default_rng(3).normal(size=25) * 0.2, 0.0)
    shape = ConvexShape(result, faces=252)
    for view in VIEWS:
        alone, solid = (light(body, *view, law=law) for body in (shape, shape.polyhedron()))
        assert abs(alone / solid - 1) < 1e-7


def test_albedos_of_facets_and_the_suns_disc_count():
    shape, view = ConvexShape([0.0, 0, 0.2, 0], faces=252), VIEWS[0]
    spots = np.random.default_rng(1).uniform(0.5, 1.0, len(shape.normals))
    reference = light(shape, *view, albedo=0.5)
    assert abs(reference - 0.5 * light(shape, *view)) < 1e-14
    assert abs(light(shape, *view, albedo=spots) + light(shape, *view, albedo=1 - spots) - 2 * reference) < 1e-13
    disc = light(shape, *view, sun_radius=0.005)
    assert 0 < abs(disc / light(shape, *view) - 1) < 1e-4


def test_derivatives_of_the_light_of_facets_are_those_of_differences():
    shape = ConvexShape(np.random.default_rng(2).normal(size=16) * 0.1, faces=252)
    system = fullbody.System([fullbody.Body(shape, mass=1.0)], G=1.0)
    state = fullbody.State([[0.0] * 3], [[0.0] * 3], attitude=[[0.7, 0.1, -0.5, 0.5]])
    law = observing.LommelSeeligerLambert(observing.LinearExponential(0.5, 0.1, -0.3), lambert=0.1)
    result = observing.brightness_derivatives(system, state, *VIEWS[0], law=law)
    assert result.areas[0].shape == (1, 252)
    assert result.vertices[0].shape == (1, 0, 3)
    # The light is linear in the areas.
    assert abs(result.areas[0][0] @ shape.areas - result.brightness[0]) < 1e-13
    for k in range(3):
        rotated = [
            observing.brightness(system, state.rotated(0, np.eye(3)[k], by), *VIEWS[0], law=law)[0]
            for by in (-1e-5, 1e-5)
        ]
        assert abs((rotated[1] - rotated[0]) / 2e-5 - result.rotation[0, 0, k]) < 1e-6
        nearer = [np.array(VIEWS[0][0]) / np.linalg.norm(VIEWS[0][0]) + by * np.eye(3)[k] for by in (-1e-5, 1e-5)]
        light_at = [observing.brightness(system, state, view, VIEWS[0][1], law=law)[0] for view in nearer]
        assert abs((light_at[1] - light_at[0]) / 2e-5 - result.to_observer[0, k]) < 1e-6


def test_a_light_curve_of_a_convex_shape_needs_no_vertices(monkeypatch):
    monkeypatch.setattr("fullbody.model.freeform.polytope", None)
    system = fullbody.System([fullbody.Body(ConvexShape([0.0, 0, 0, 0, 0, 0, 0, 0, 0.3]), mass=1.0)], G=1.0)
    state = fullbody.State([[0.0] * 3], [[0.0] * 3], spin=[[0, 0, 2 * np.pi / 5]])
    run = system.integrate(state, 10.0, dense=True)
    view = observing.Geometry([0.0, 10.0], to_observer=[1e3, 2e2, 3e2], to_sun=[1e3, -3e2, 1e2], light_time=False)
    times = np.linspace(0.0, 5.0, 50)
    curve, later = (observing.light_curve(run, times + by, view) for by in (0.0, 5.0))
    assert np.ptp(curve) > 0.2
    np.testing.assert_allclose(later, curve, atol=1e-10)
    assert len(observing.mutual_events(run, view)) == 0
