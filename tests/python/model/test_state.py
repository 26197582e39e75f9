"""State, Body, System and elements as Python objects: conversions, copies, pickles, equality, repr."""

import pickle

import fullbody
import numpy as np
import pytest
from fullbody import Body, Ellipsoid, KeplerElements, PointMass, Sphere, State, System, Verner98
from hypothesis import given
from hypothesis import strategies as st
from support import angle_between, matrix, quaternions, rot_x, rot_y, rot_z


def example(units=False):
    return fullbody.systems.kw4(units=units)


def test_copies_of_a_system_and_its_states_keep_every_bit():
    system, state = example()
    twin_system, twin_state = pickle.loads(pickle.dumps((system, state)))
    assert np.array_equal(twin_system.interactions(twin_state).force, system.interactions(state).force)
    run, again = (s.integrate(t, 20.0) for s, t in ((system, state), (twin_system, twin_state)))
    assert run == again
    end, twin = run[-1], pickle.loads(pickle.dumps(run[-1]))
    for name in ("position", "velocity", "attitude", "spin", "time"):
        assert np.array_equal(getattr(twin, name), getattr(end, name)), name


def test_other_things_are_unequal_and_equal_ones_have_equal_hashes():
    system, state = example()
    assert state != state.replace(time=1.0)
    assert state != state.replace(position=state.position + 1e-15)
    assert state != example(units=True)[1]
    assert state != "state"
    assert Body(Sphere(1.0), mass=1.0) != Body(Sphere(1.0), mass=2.0)
    assert Body(Sphere(1.0), mass=1.0) != Body(Sphere(1.0), density=1.0)
    assert Body(Sphere(1.0), mass=1.0, name="A") != Body(Sphere(1.0), mass=1.0, name="B")
    assert system != system.with_options(gravity="surface")
    assert system != "system"
    assert KeplerElements(1, 0, 0, 0, 0, 0) != KeplerElements(2, 0, 0, 0, 0, 0)
    assert Verner98() != Verner98(rtol=1e-12)
    for make in (lambda: Sphere(1.0), lambda: Body(Sphere(1.0), mass=1.0), lambda: example()[0], Verner98):
        assert hash(make()) == hash(make())


@pytest.mark.parametrize(
    "made",
    [
        Body(Ellipsoid(3.0, 2.0, 1.0), mass=2.0, name="a 'b'"),
        *(Body(Sphere(2.0), density=0.1), Body(PointMass(), mass=1 / 3, name="c"), Verner98(1e-9)),
    ],
)
def test_the_text_of_a_body_makes_it(made):
    assert eval(repr(made), vars(fullbody) | {"Verner98": Verner98}) == made


def test_reprs_name_class_and_contents():
    system, state = example()
    for word in ("Alpha", "Beta", "focal", "8.649"):
        assert word in repr(system)
    for word in ("position", "velocity", "attitude", "spin", "time=0.0", "2.416"):
        assert word in repr(state)
    assert "km" in repr(example(units=True)[1])
    assert "a=2.0" in repr(KeplerElements(2.0, 0, 0, 0, 0, 0))
    # The smallest double is below all powers of ten that are doubles.
    assert "nan" not in repr(State([[5e-324, 0, 0]], [[0, 0, 0]]))


def test_the_table_names_the_bodies_that_are_known():
    system, state = example()
    run = system.integrate(state, 1.0, output="ends")
    for named in (state, run[1], state.kick("Beta", [0.0, 0.0, 1e-6]), pickle.loads(pickle.dumps(state))):
        assert ">Alpha<" in named._repr_html_()
        assert ">Beta<" in named._repr_html_()
    page = State(state.position, state.velocity)._repr_html_()
    assert ">0<" in page
    assert "Alpha" not in page


def test_states_start_at_rest_in_the_identity_attitude():
    state = State([[1, 2, 3]], [[4, 5, 6]])
    assert state.time == 0.0
    assert state.attitude.tolist() == [[1, 0, 0, 0]]
    assert state.spin.tolist() == [[0, 0, 0]]
    assert len(state) == 1
    for array in (state.position, state.velocity, state.attitude, state.spin):
        assert array.dtype == np.float64
        assert array.flags.c_contiguous


def test_a_state_does_not_share_memory_with_its_input():
    position = np.array([[1.0, 2.0, 3.0]])
    state = State(position, [[0, 0, 0]])
    position[0, 0] = 99.0
    assert state.position[0, 0] == 1.0


@pytest.mark.parametrize("units", [False, True])
def test_arrays_of_a_state_are_read_only(units):
    system, start = example(units)
    for state in (start, system.integrate(start, 1.0)[-1], State.from_tait_bryan(*[[[1.0, 2.0, 3.0]]] * 3)):
        for name in ("position", "velocity", "attitude", "spin", "rotation_matrix", "tait_bryan"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(state, name)[0] *= 2
            with pytest.raises(ValueError, match="read-only"):
                getattr(state, name)[0] = 0 * getattr(state, name)[0]
            assert getattr(state, name).copy().flags.writeable


@given(quaternions, st.floats(1e-3, 1e3))
@pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
def test_attitude_is_scaled_to_unit_length(q, scale):
    state = State([[0, 0, 0]], [[0, 0, 0]], [q * scale])
    assert np.abs(state.attitude[0] - q).max() < 4e-16
    assert np.linalg.norm(state.attitude[0]) == pytest.approx(1.0, abs=3e-16)


@given(quaternions)
def test_rotation_matrix_is_that_of_the_quaternion(q):
    state = State([[0, 0, 0]], [[0, 0, 0]], [q])
    frame = state.rotation_matrix[0]
    assert np.abs(frame - matrix(q)).max() < 1e-15
    # Some roundings of 1.1e-16 each: of the quaternion's norm, of the entries and of the sums of three products.
    assert np.abs(frame @ frame.T - np.eye(3)).max() < 2e-15


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_tait_bryan_angles_are_the_papers(phi, theta, psi):
    # The paper's eq:RotationMatrix.
    state = State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], [[phi, theta, psi]])
    assert np.abs(state.rotation_matrix[0] - rot_z(psi) @ rot_y(theta) @ rot_x(phi)).max() < 1e-15
    limit = 1e-15 / np.cos(theta)
    assert state.tait_bryan[0] == pytest.approx([phi, theta, psi], abs=limit)


@pytest.mark.parametrize("theta", [np.pi / 2, -np.pi / 2])
def test_tait_bryan_angles_at_their_pole_give_the_same_matrix(theta):
    # Only psi -/+ phi is defined there; the matrix must come back.
    state = State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], [[0.4, theta, 1.1]])
    again = State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], state.tait_bryan)
    assert np.isfinite(state.tait_bryan).all()
    assert angle_between(state.rotation_matrix, again.rotation_matrix).max() < 1e-7


def test_replace_changes_one_quantity():
    _, state = example()
    other = state.replace(position=state.position * 2, time=7.0)
    assert np.array_equal(other.position, state.position * 2)
    assert other.time == 7.0
    assert np.array_equal(other.attitude, state.attitude)
    assert state.time == 0.0


def test_bodies_have_mass_volume_density_and_inertia():
    rock = Body(Ellipsoid(3.0, 2.0, 1.0), density=0.5)
    assert rock.mass == pytest.approx(0.5 * 4 / 3 * np.pi * 6.0, rel=1e-15)
    assert Body(Ellipsoid(3.0, 2.0, 1.0), mass=rock.mass).density == pytest.approx(0.5, rel=1e-15)
    assert Body(PointMass(), mass=1.0).density is None
    assert Sphere(2.0).semi_axes == (2.0, 2.0, 2.0)
    assert PointMass().semi_axes is None
    assert System([rock, rock], G=1.0).names == ("body 0", "body 1")


def test_energy_and_momenta_are_the_papers_formulas():
    # The paper's sections 2.3 and 2.4.
    a = np.array([[0.9, 0.7, 0.5], [0.6, 0.4, 0.3]])
    m = np.array([2.0, 0.7])
    system = System([Body(Ellipsoid(*axes), mass=mass) for axes, mass in zip(a, m, strict=True)], G=1.3)
    r, v = np.array([[1.0, 2, 3], [4, 2, 1]]), np.array([[0.1, 0.2, 0.3], [-0.4, 0.5, 0.6]])
    w, q = np.array([[1.0, -2, 0.5], [0.3, 0.2, 3]]), np.array([[0.5, 0.5, -0.5, 0.5], [0.8, 0, 0.6, 0]])
    state = State(r, v, q, w)
    moments = m[:, None] / 5 * (np.square(a).sum(axis=1)[:, None] - np.square(a))
    energy = system.energy(state)
    assert energy.translational == pytest.approx((m * (v * v).sum(axis=1)).sum() / 2, rel=1e-15)
    assert energy.rotational == pytest.approx((moments * w * w).sum() / 2, rel=1e-15)
    assert energy.potential == system.interactions(state).potential_energy
    assert energy.total == pytest.approx(energy.translational + energy.rotational + energy.potential, rel=1e-15)
    assert energy.potential < 0
    assert system.momentum(state) == pytest.approx((m[:, None] * v).sum(axis=0), rel=1e-15)
    spins = sum(matrix(p) @ (i * s) for p, i, s in zip(q, moments, w, strict=True))
    assert system.angular_momentum(state) == pytest.approx((m[:, None] * np.cross(r, v)).sum(axis=0) + spins, rel=1e-14)
