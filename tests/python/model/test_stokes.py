"""Bodies by their Stokes coefficients, beside the bodies of which these are the coefficients."""

import pickle

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import StokesCoefficients, observing
from fullbody.errors import InvalidInput, NotConverged
from support import refused
from support.flows import central_of_state
from support.meshes import close
from support.toml_texts import PAIR, read

ALPHA = fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.7), mass=2.0, name="Alpha")
BETA = fullbody.Body(fullbody.Ellipsoid(0.5, 0.4, 0.3), mass=0.3, name="Beta")


def by_harmonics(body, degree=60):
    return fullbody.Body(body.harmonics(degree), mass=body.mass, name=body.name)


def posed(separation=3.0):
    """A state with both bodies turned, spinning and in motion."""
    attitude = np.array([[0.9, 0.1, -0.3, 0.2], [0.4, -0.5, 0.3, 0.6]])
    direction = np.array([0.8, 0.5, 0.33])
    return fullbody.State(
        [[0.0, 0.0, 0.0], separation * direction / np.linalg.norm(direction)],
        [[0.0, 0.0, 0.0], [-0.5, 0.8, 0.0]],
        attitude / np.linalg.norm(attitude, axis=1)[:, None],
        [[0.1, 0.2, 0.5], [0.3, -0.1, 0.7]],
    )


def points():
    """Random point masses as a composite, and their inertia integrals up to a degree, for a radius of 2."""
    rng = np.random.default_rng(3)
    positions, masses = rng.uniform([-0.8, -1.1, -0.7], [1.2, 0.9, 1.3], (7, 3)), rng.uniform(0.5, 1.5, 7)
    parts = [fullbody.Part(fullbody.PointMass(), mass=m, position=p) for m, p in zip(masses, positions, strict=True)]
    monomials = (positions[:, axis, None] ** np.arange(28) for axis in range(3))
    integrals = np.einsum("p,pi,pj,pk->ijk", masses, *monomials)
    return fullbody.Body(fullbody.Composite(parts), name="points"), integrals, masses.sum()


def test_low_coefficients_of_an_ellipsoid_are_the_closed_forms():
    a, b, c = 1.0, 0.8, 0.7
    C, S = ALPHA.harmonics(4).unnormalized()
    assert C[2, 0] == pytest.approx((c**2 - (a**2 + b**2) / 2) / 5, rel=1e-13)
    assert C[2, 2] == pytest.approx((a**2 - b**2) / 20, rel=1e-13)
    # Balmino (1994), Celest. Mech. Dyn. Astron. 60, 331.
    assert C[4, 0] == pytest.approx(15 / 7 * (C[2, 0] ** 2 + 2 * C[2, 2] ** 2), rel=1e-12)
    assert C[4, 2] == pytest.approx(5 / 7 * C[2, 0] * C[2, 2], rel=1e-12)
    assert C[4, 4] == pytest.approx(5 / 28 * C[2, 2] ** 2, rel=1e-12)
    assert np.abs(S).max() < 1e-17


def test_field_outside_the_sphere_is_that_of_the_ellipsoid():
    locations = np.random.default_rng(5).normal(size=(20, 3))
    locations *= np.linspace(1.6, 9.0, 20)[:, None] / np.linalg.norm(locations, axis=1, keepdims=True)
    result, exact = by_harmonics(ALPHA).gravity(locations, G=1.0), ALPHA.gravity(locations, G=1.0)
    for name in ("potential", "field", "gradient"):
        close(getattr(result, name), getattr(exact, name), 1e-13)


@pytest.mark.parametrize("other", [BETA, by_harmonics(BETA, 40), fullbody.Body(fullbody.PointMass(), mass=0.3)])
def test_force_torque_and_energy_are_those_of_the_ellipsoids(other):
    exact = fullbody.System([ALPHA, BETA if other.shape.semi_axes is None and other.name else other], G=1.0)
    system = fullbody.System([by_harmonics(ALPHA), other], G=1.0)
    result, reference = system.interactions(posed()), exact.interactions(posed())
    close(result.force, reference.force, 2e-13)
    close(result.torque, reference.torque, 2e-12)
    assert result.potential_energy == pytest.approx(reference.potential_energy, rel=1e-13)


def test_motion_is_that_of_the_ellipsoids():
    pairs = [ALPHA, BETA], [by_harmonics(ALPHA), by_harmonics(BETA, 40)]
    reference, result = (fullbody.System(pair, G=1.0).integrate(posed(), 30.0, output=30.0) for pair in pairs)
    np.testing.assert_allclose(result.position[-1], reference.position[-1], atol=1e-9)
    np.testing.assert_allclose(result.spin[-1], reference.spin[-1], atol=1e-9)
    assert np.abs(result.energy / result.energy[0] - 1.0).max() < 1e-12


def test_coefficients_in_any_frame_make_the_same_body():
    body, integrals, mass = points()
    result = fullbody.Body(StokesCoefficients.from_inertia_integrals(integrals, radius=2.0), mass=mass)
    np.testing.assert_allclose(result.inertia, body.inertia, rtol=1e-12)
    np.testing.assert_allclose(result.working_frame.position, body.working_frame.position, atol=1e-13)
    np.testing.assert_allclose(result.working_frame.attitude, body.working_frame.attitude, atol=1e-12)
    locations = np.random.default_rng(7).normal(size=(10, 3))
    locations *= 9.0 / np.linalg.norm(locations, axis=1, keepdims=True)
    item, other = result.gravity(locations, G=1.0), body.gravity(locations, G=1.0)
    np.testing.assert_allclose(item.potential, other.potential, rtol=1e-13)
    close(item.field, other.field, 1e-13)
    # Those of a composite are those of its parts, here far less of them.
    again = fullbody.Body(body.harmonics(12), mass=mass)
    close(again.gravity(locations, G=1.0).field, other.field, 1e-9)
    np.testing.assert_allclose(again.inertia, body.inertia, rtol=1e-12)


def test_normalisations_agree_with_each_other():
    C, S = ALPHA.harmonics(6).unnormalized()
    unitless = StokesCoefficients(C, S, reference_radius=1.0, inertia=0.142, normalization="unnormalized")
    np.testing.assert_allclose(unitless.C, ALPHA.harmonics(6).C, rtol=1e-14)


@pytest.mark.parametrize("name", ["C2,0", "C2,2", "C3,1", "S4,3", "mean moment of inertia"])
def test_sensitivities_are_differences_of_runs(name):
    _, integrals, mass = points()
    shape = StokesCoefficients.from_inertia_integrals(integrals[:6, :6, :6], radius=2.0)
    shape = fullbody.Body(shape, mass=mass).harmonics(5)
    orbit = fullbody.KeplerElements(40.0, 0.1, 0.4, 0.0, 0.0, 1.0)

    def run(by=0.0, **options):
        C, S, inertia = shape.C.copy(), shape.S.copy(), shape.inertia
        if name.startswith("mean"):
            inertia += by
        else:
            (C if name[0] == "C" else S)[int(name[1]), int(name[3])] += by
        changed = StokesCoefficients(C, S, reference_radius=shape.reference_radius, inertia=inertia)
        body = fullbody.Body(changed, mass=mass, name="A")
        sun = fullbody.forces.ThirdBody(name="Sun", mass=5000.0, of="body", orbit=orbit)
        system = fullbody.System([body, BETA], G=1.0, forces=[sun])
        return system.integrate(posed(7.0), 3.0, output=3.0, integrator=fullbody.Verner98(rtol=1e-13), **options)

    def vector(run):
        return np.stack([run.position[-1], run.velocity[-1], run.spin[-1]], axis=1)

    result = run(derivatives=[f"{name} of A"]).sensitivity[f"{name} of A"][-1]
    close(result.reshape(2, 4, 3)[:, [0, 1, 3]], central_of_state(lambda by: vector(run(by)), 1e-4), 1e-8)


def test_files_give_coefficients_and_gm(tmp_path):
    pytest.importorskip("pyshtools")
    rows = [(1, 0, 0, 0), (1, 1, 0, 0), (2, 0, -0.02, 0), (2, 1, 0, 0), (2, 2, 0.004, 0.001)]
    head = (
        "product_type gravity_field\nmodelname test\nearth_gravity_constant 35.0\nradius 400.0\nmax_degree 2\n"
        "errors no\nnorm fully_normalized\nend_of_head ====\ngfc 0 0 1.0 0.0\n"
    )
    gfc, shadr = tmp_path / "a.gfc", tmp_path / "a.tab"
    gfc.write_text(head + "".join(f"gfc {n} {m} {c} {s}\n" for n, m, c, s in rows))
    table = "".join(f"{n}, {m}, {c}, {s}, 0.0, 0.0\n" for n, m, c, s in rows)
    shadr.write_text(f"0.4, 3.5e-8, 0.0, 2, 2, 1, 0.0, 0.0\n{table}")
    for path in (gfc, shadr):
        shape = StokesCoefficients.read(path, inertia=0.06 * u.km**2)
        assert shape.C[2].tolist() == [-0.02, 0.0, 0.004]
        assert shape.S[2].tolist() == [0.0, 0.0, 0.001]
        assert shape.reference_radius.to_value(u.km) == pytest.approx(0.4, rel=1e-15)
        assert shape.mu.to_value(u.m**3 / u.s**2) == pytest.approx(35.0, rel=1e-15)
    gfc.write_text("nothing\n")
    refused("not a table of gravity coefficients", StokesCoefficients.read, gfc, inertia=0.06 * u.km**2)


def test_whatever_needs_a_surface_is_refused():
    system = fullbody.System([by_harmonics(ALPHA), BETA], G=1.0)
    run = system.integrate(posed(), 1.0)
    geometry = observing.Geometry([0.0], to_observer=[0, 0, 1e9], to_sun=[0, 1e9, 0], light_time=False)
    lacking = "Alpha is given by its Stokes coefficients"
    for call in (
        lambda: system.integrate(posed(), 1.0, events=[fullbody.events.Contact("Alpha", "Beta")]),
        lambda: observing.light_curve(run, [0.5], geometry),
        lambda: fullbody.Particles.from_surface(system, posed(), "Alpha", longitude=0.0, latitude=0.0, speed=0.1),
        lambda: fullbody.Particles.ejecta(system, posed(), "Alpha", longitude=0.0, latitude=0.0, speed=0.1, n=3),
        lambda: posed().impact(system, 0, mass=1e-9, velocity=[-1.0, 0, 0], longitude=0.0, latitude=0.0),
    ):
        refused(lacking, call)


def test_gravity_inside_the_sphere_parts_and_densities_are_refused():
    body = by_harmonics(ALPHA, 8)
    with pytest.raises(InvalidInput, match=r"point 1 is .* at least 1 from the centre of Alpha"):
        body.gravity([[0.0, 0.0, 2.0], [0.0, 0.0, 0.9]], G=1.0)
    system = fullbody.System([body, BETA], G=1.0)
    with pytest.raises(NotConverged, match="series of their moments diverges"):
        system.interactions(posed(1.3))
    shape = ALPHA.harmonics(4)
    refused("has no volume", fullbody.Body, shape, density=1.0)
    refused("shape of a part", fullbody.Part, shape, mass=1.0)


def test_particles_end_at_the_sphere():
    system = fullbody.System([by_harmonics(ALPHA, 8), fullbody.Body(fullbody.PointMass(), mass=1e-9)], G=1.0)
    state = fullbody.State([[0, 0, 0], [100.0, 0, 0]], np.zeros((2, 3)))
    flight = system.fly(state, fullbody.Particles([[0.0, 0.0, 3.0]], [[0.0, 0.0, 0.0]]), 100.0)
    assert flight.fate_body.tolist() == [0]
    assert flight.fate.tolist() == ["impact"]
    # A free fall from 3 to 1 in the field of a point mass of 2 lasts nearly as long.
    fall = np.sqrt(3.0**3 / 4.0) * (np.arccos(np.sqrt(1 / 3)) + np.sqrt(1 / 3 * 2 / 3))
    assert flight.fate_time[0] == pytest.approx(fall, rel=0.03)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"C": np.eye(3)[:2]}, r"C is of shape \(2, 3\); expected \(L \+ 1, L \+ 1\)"),
        ({"S": np.zeros((4, 4))}, r"S is of shape \(4, 4\); expected that of C"),
        ({"C": [[1, 1, 0], [0, 0, 0], [0, 0, 0]]}, "C has numbers at m > l"),
        ({"C": [[2, 0, 0], [0, 0, 0], [0, 0, 0]]}, "C00 is 2"),
        ({"C": [[1, 0, 0], [0, 0, 0], [np.nan, 0, 0]]}, "finite"),
        ({"inertia": -0.1}, "mean moment of inertia is -0.1"),
        ({"inertia": 0.9}, "the body lies in a sphere"),
        ({"inertia": [0.3, 0.3, 0.3]}, r"inertia is \[0.3, 0.3, 0.3\]; expected .* which degree 2 gives"),
        ({"inertia": [0.1, 0.2]}, r"inertia is of shape \(2,\)"),
        ({"inertia": 0.001}, "moments of inertia of the Stokes coefficients"),
        ({"reference_radius": 0.0}, "reference_radius is 0.0"),
        ({"radius": np.inf}, "radius is inf"),
        ({"normalization": "schmidt"}, "normalization is 'schmidt'"),
    ],
)
def test_bad_coefficients_are_refused(change, expected):
    good = {"C": np.array([[1, 0, 0], [0] * 3, [-0.05, 0, 0.01]]), "S": np.zeros((3, 3)), "inertia": 0.3}
    refused(expected, StokesCoefficients, **{"reference_radius": 1.0} | good | change)


def test_units_and_copies_keep_the_body():
    shape = ALPHA.harmonics(6)
    assert pickle.loads(pickle.dumps(shape)) == shape != ALPHA.harmonics(5)
    total = StokesCoefficients(shape.C, shape.S, reference_radius=1.0 * u.km, inertia=shape.inertia * 1e6 * u.m**2)
    with_units = fullbody.System([fullbody.Body(total, mass=2e12 * u.kg)], units=("m", "s", "kg"))
    np.testing.assert_allclose(with_units[0].inertia.to_value(u.kg * u.km**2), 1e12 * ALPHA.inertia, rtol=1e-12)


def test_a_toml_file_gives_coefficients(tmp_path):
    stokes = "{ C = [[1, 0, 0], [0, 0, 0], [-0.05, 0, 0.01]], reference_radius = 1.0, inertia = 0.3 }"
    shape = read(tmp_path, PAIR.replace("radius = 1.0", f"stokes = {stokes}", 1)).system.bodies[0].shape
    assert shape.C[2].tolist() == [-0.05, 0.0, 0.01]
    assert shape.inertia == 0.3
