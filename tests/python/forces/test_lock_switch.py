"""A lock that is lost and regained during a run: the switching of the force, and the jump of the derivatives."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import ForceFailed
from fullbody.forces import Byorp
from scipy.integrate import quad
from scipy.optimize import brentq
from support import body_list, worst
from support.flows import central, displaced

FORCE = 2e-4
TORQUE = (1e-7, 2e-7, 3e-7)


def swinging(force=FORCE, axes=(0.1, 0.08, 0.07), mass=1e-2, e=0.2, rate=1.3, G=1.0, primary=1.0, torque=TORQUE):
    """A secondary that swings near the separatrix on an eccentric orbit, so that its lock comes and goes."""
    bodies = body_list(A=(fullbody.Ellipsoid(0.3, 0.28, 0.25), primary), B=(fullbody.Ellipsoid(*axes), mass))
    system = fullbody.System(bodies, G=G, forces=[Byorp("B", "A", force, torque=torque, name="BYORP")])
    r, v = fullbody.KeplerElements(1.0, e, 0.1, 0.3, 0.2, 0.1).to_cartesian(1.01)
    share = 0.01 / 1.01
    state = fullbody.State(
        [-share * r, (1 - share) * r],
        [-share * v, (1 - share) * v],
        attitude=[[1.0, 0, 0, 0], [np.cos(0.35), 0.02, 0.03, np.sin(0.35)]],
        spin=[[0.1, 0.0, 2.0], [0.01, 0.02, rate]],
    )
    return system, state


def margin(state, bodies, G=1.0):
    """The margin of the lock, by the definition in the documentation of Byorp."""
    r = state.position[1] - state.position[0]
    v = state.velocity[1] - state.velocity[0]
    h = np.cross(r, v)
    normal, line = h / np.linalg.norm(h), r / np.linalg.norm(r)
    rotation, inertia = state.rotation_matrix[1], bodies[1].inertia
    long, short = rotation[:, np.argmin(inertia)], rotation[:, np.argmax(inertia)]
    psi = np.arctan2(long @ np.cross(normal, line), long @ line)
    rate = rotation @ state.spin[1] @ normal - np.linalg.norm(h) / (r @ r)
    a, b, c = np.sort(inertia)
    w2 = 3 * (b - a) / c * G * (bodies[0].mass + bodies[1].mass) / np.linalg.norm(r) ** 3
    return min(abs(short @ normal) - np.sqrt(0.5), np.cos(psi) ** 2 - rate**2 / w2)


UNTIL = 14.0


@pytest.fixture(scope="module")
def reference():
    system, state = swinging()
    return system.integrate(state, UNTIL, output="ends", dense=True)


def test_the_force_does_work_only_while_the_lock_lasts(reference):
    system, _ = swinging()
    times = np.linspace(0.0, UNTIL, 1001)
    at = lambda t: margin(reference(t), system.bodies)  # noqa: E731
    values = np.array([at(t) for t in times])
    edges = [brentq(at, times[k], times[k + 1], xtol=1e-13) for k in np.flatnonzero(values[1:] * values[:-1] < 0)]
    assert len(edges) >= 4
    lost = np.count_nonzero((values[1:] < 0) & (values[:-1] > 0))
    assert reference.switched_off == {"BYORP": lost + (values[0] < 0)}

    def power(t):
        state = reference(t)
        r, v = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
        rotation = state.rotation_matrix[1]
        outwards, up = (
            rotation[:, 0] * np.sign(rotation[:, 0] @ r),
            rotation[:, 2] * np.sign(rotation[:, 2] @ np.cross(r, v)),
        )
        axes = np.stack([outwards, np.cross(up, outwards), up], axis=1)
        return FORCE * axes[:, 1] @ state.velocity[1] + (axes @ TORQUE) @ (rotation @ state.spin[1])

    work = 0.0
    for first, last in zip([0.0, *edges], [*edges, UNTIL], strict=True):
        if at(0.5 * (first + last)) > 0:
            work += quad(power, first, last, epsabs=1e-13, epsrel=1e-11, limit=200)[0]
    assert reference.work["BYORP"][-1] == pytest.approx(work, rel=1e-9)


@pytest.mark.parametrize(
    "integrator",
    [
        fullbody.Verner98(rtol=1e-10, atol=1e-10),
        fullbody.Verner87(rtol=1e-12, atol=1e-12),
        fullbody.Verner76(rtol=1e-12, atol=1e-12),
        fullbody.Verner65(rtol=1e-12, atol=1e-12),
        fullbody.DormandPrince54(rtol=1e-11, atol=1e-11),
    ],
    ids=lambda i: type(i).__name__,
)
def test_the_motion_converges_with_the_tolerance(reference, integrator):
    system, state = swinging()
    run = system.integrate(state, UNTIL, integrator=integrator, output="ends")
    assert run.switched_off == reference.switched_off
    assert abs(run.position[-1] - reference.position[-1]).max() < 2e-8


def test_switches_do_not_depend_on_pieces_and_outputs(reference):
    system, state = swinging()
    sim = fullbody.Simulation(system, state)
    switched = sum(sim.integrate(UNTIL * k / 20, output="ends").switched_off["BYORP"] for k in range(1, 21))
    assert switched >= reference.switched_off["BYORP"]
    assert abs(sim.state.position - reference.position[-1]).max() < 1e-10
    spaced = system.integrate(state, UNTIL, output=UNTIL / 50, dense=True)
    assert abs(spaced.position[-1] - reference.position[-1]).max() < 1e-10


def test_an_archive_continues_through_switches_bit_for_bit(tmp_path):
    system, state = swinging()
    total, half = (fullbody.Simulation(system, state) for _ in range(2))
    for sim in (total, half):
        sim.integrate(UNTIL / 3, output="ends")
    half.save(tmp_path / "half.fb")
    resumed = fullbody.Simulation.load(tmp_path / "half.fb")
    ends = [sim.integrate(UNTIL, output="ends").position[-1] for sim in (total, resumed)]
    assert (ends[0] == ends[1]).all()


def test_a_backward_run_through_switches_returns_to_its_start(reference):
    system, state = swinging()
    back = system.integrate(reference[-1], 0.0, output="ends")
    assert abs(back.position[-1] - state.position).max() < 1e-9
    assert abs(back.spin[-1] - state.spin).max() < 1e-8


@pytest.mark.parametrize("until", [UNTIL / 2, -UNTIL / 2])
def test_the_transition_matrix_has_the_jumps_at_switches(until):
    system, state = swinging()
    run = system.integrate(state, until, output="ends", derivatives=True)
    assert run.switched_off["BYORP"] >= 1
    for point in [(1, 0, 0), (1, 1, 1), (1, 2, 2), (1, 3, 2), (0, 0, 1)]:
        expected = central(
            lambda by, point=point: system.integrate(displaced(state, *point, by), until, output="ends")[-1], 2e-5
        )
        assert worst(run.transition[-1][:, np.ravel_multi_index(point, (2, 4, 3))], expected) < 2e-6


@pytest.mark.parametrize(
    ("name", "arguments", "value"),
    [
        ("force of BYORP", "force", FORCE),
        ("G", "G", 1.0),
        ("mass of B", "mass", 1e-2),
        ("mass of A", "primary", 1.0),
        ("semi-axis a of B", "axes", 0.1),
        ("semi-axis c of B", "axes", 0.07),
    ],
)
def test_sensitivities_have_the_jumps_at_switches(name, arguments, value):
    def at(change):
        if arguments == "axes":
            axes = [0.1, 0.08, 0.07]
            axes[axes.index(value)] += change
            return swinging(axes=tuple(axes))
        return swinging(**{arguments: value + change})

    system, state = at(0.0)
    until = UNTIL / 2
    run = system.integrate(state, until, output="ends", derivatives=[name])
    expected = central(lambda by: at(by)[0].integrate(state, until, output="ends")[-1], 2e-5 * value)
    assert worst(run.sensitivity[name][-1], expected) < 2e-6


def test_a_force_that_undoes_its_own_switch_is_refused():
    system, state = swinging(force=0.5, mass=1e-3)
    with pytest.raises(ForceFailed, match="neither lasts nor ends"):
        system.integrate(state, UNTIL, output="ends")
