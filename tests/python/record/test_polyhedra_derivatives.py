"""Derivatives of pairs with polyhedra against other rules, fine meshes and the laws of mechanics."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import NotConverged
from support import worst
from support.flows import TIGHT, energy_gradient, momentum_gradients, scales, solids, symplectic_form
from support.meshes import box


@pytest.mark.parametrize("second", ["sphere", "ellipsoid", "point"])
def test_the_surface_rule_beside_a_polyhedron_is_the_focal_one(second):
    focal, surface = (solids("box", second, 1.6, gravity) for gravity in ("focal", "surface"))
    loads = [system.interactions(state) for system, state in (focal, surface)]
    assert worst(loads[1].force, loads[0].force) < 1e-12
    assert worst(surface[0].jacobian(surface[1]).rates, focal[0].jacobian(focal[1]).rates) < 1e-11


@pytest.mark.parametrize(("first", "second"), [("box", "ellipsoid"), ("composite", "box")])
def test_transition_matrices_are_symplectic_and_conserve_integrals(first, second):
    system, state = solids(first, second, 1.5)
    size = scales(system, state)
    run = system.integrate(state, 0.6, output="ends", integrator=TIGHT, derivatives=True)
    phi = run.transition[1]
    form = [size[:, np.newaxis] * symplectic_form(system, run[k]) * size for k in (0, 1)]
    scaled = phi * size / size[:, np.newaxis]
    assert worst(scaled.T @ form[1] @ scaled, form[0]) < 1e-11
    now, then = (energy_gradient(system, run[k]) for k in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-9
    now, then = (momentum_gradients(system, run[k]) for k in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-11


def test_derivatives_reach_the_tolerance_or_warn():
    # Rounding over the faces of a thin plate is as much larger as it is thin. Which of the tolerances it hides depends
    # on the order of the sums, and so on the machine: the loosest never, the tightest always.
    _, state = solids("box", "ellipsoid", 1.0)
    state = state.replace(attitude=[[1.0, 0.0, 0.0, 0.0]] * 2, position=[[0.0, 0.0, 0.0], [0.05, 0.03, 0.25]])
    other = fullbody.Body(fullbody.Ellipsoid(0.4, 0.3, 0.2), mass=1.0, name="B")
    for thickness in (1e-3, 1e-4, 1e-6):
        plate = fullbody.Body(box(1.0, 0.8, thickness), mass=1.0, name="A")

        def rates(tolerance, plate=plate):
            return fullbody.System([plate, other], G=1.0, gravity_tolerance=tolerance).jacobian(state).rates

        reference = rates(1e-8)
        refused = []
        for tolerance in (1e-13, 1e-12, 1e-11, 1e-10):
            try:
                assert worst(rates(tolerance), reference) < 1e3 * tolerance
            except NotConverged:
                refused.append(tolerance)
        assert thickness > 1e-6 or 1e-13 in refused
