"""Runs, simulations and pickles keep bodies of every shape bit for bit."""

import pickle

import fullbody
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Sphere
from support.meshes import box, icosphere, octahedron

PARTS = [
    *(Part(Sphere(0.5), mass=m, position=[x, 0.0, 0.0]) for x, m in ((3.0, 1.0), (-1.0, 3.0))),
    Part(Ellipsoid(0.5, 0.4, 0.3), density=-0.1, attitude=(0.5, 0.1, -0.7, 0.5)),
    *(Part(box(0.2, 0.3, 0.4), mass=0.1, position=[0.0, 0.5, 0.0]), Part(PointMass(), mass=0.1)),
]
ROCK, SMALL, EGG = octahedron(1.0, 0.8, 0.6), octahedron(0.5, 0.4, 0.3), Ellipsoid(0.5, 0.4, 0.3)
COEFFICIENTS = Body(ROCK, mass=2.0).harmonics(6)
UNITS = {"units": ("km", "hour", "kg"), "G": 1.0}
#: Two bodies, their separation and relative velocity, until when a simulation is saved and its runs go on.
CASES = {
    "composite": ([Body(Ellipsoid(3.0, 2.0, 1.0), mass=9.0), Body(Composite(PARTS))], [12, 0, 1], [0, 1, 0], 1.0, 4.0),
    "Stokes": ([Body(COEFFICIENTS, mass=2.0), Body(EGG, mass=0.3)], [3, 1, 0], [0, 1, 0], 1.0, 3.0),
    # The orbit is so eccentric that the degrees of the series change.
    "series": ([Body(icosphere(1), mass=2.0), Body(SMALL, mass=0.3)], [3.5, 0, 0], [0, 0.7, 0.1], 4.0, 12.0),
    "near": ([Body(ROCK, mass=1.0), Body(EGG, mass=0.2)], [2.6, 0.3, 0.1], [0, 0.8, 0.1], 0.5, 2.0),
    "two near": ([Body(ROCK, mass=1.0), Body(SMALL, mass=0.2)], [2.6, 0.3, 0], [0, 0.8, 0], 0.5, 2.0),
    "far": ([Body(ROCK, mass=1.0), Body(SMALL, mass=0.2)], [8.0, 0.3, 0], [0, 0.4, 0], 0.5, 2.0),
}


@pytest.mark.parametrize("name", CASES)
def test_a_resumed_run_of_any_shape_equals_the_unbroken_one_bit_for_bit(name, tmp_path):
    bodies, position, velocity, pause, until = CASES[name]
    system = fullbody.System(bodies, **UNITS)
    attitude, spin = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]], [[0.1, 0.2, 0.4], [0.3, 0.1, 0.0]]
    state = fullbody.State([[0] * 3, position], [[0] * 3, velocity], attitude, spin)
    simulation = fullbody.Simulation(system, state)
    run = simulation.integrate(pause)
    run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc") == run
    assert pickle.loads(pickle.dumps(system)) == fullbody.load(tmp_path / "run.nc").system == system
    simulation.save(tmp_path / "simulation")
    # The file makes the shapes anew, with nothing of what was computed before.
    resumed = fullbody.Simulation.load(tmp_path / "simulation")
    assert (resumed.system, resumed.quadrature) == (system, simulation.quadrature)
    again, unbroken = resumed.integrate(until), simulation.integrate(until)
    assert np.array_equal(again.position, unbroken.position)
    assert np.array_equal(again.attitude, unbroken.attitude)
    assert np.abs(unbroken.energy_drift_orbital).max() < 1e-10
    separation = np.linalg.norm(unbroken.position[:, 1] - unbroken.position[:, 0], axis=1)
    assert name != "series" or separation.max() > 1.3 * separation.min()
