"""Derivatives of observations with respect to the state of the bodies, from displaced states."""

import numpy as np

#: The kinds of components of a tangent vector.
KINDS = ("position", "velocity", "rotation", "spin")


def displaced(state, body, kind, axis, step):
    """A state with units, with one component of a body changed; rotations are about the body's own axes."""
    if kind == "rotation":
        return state.rotated(body, np.eye(3)[axis], step, along="body")
    values = getattr(state, kind).copy()
    values[body, axis] += step * values.unit
    return state.replace(**{kind: values})


def by_start(data, system, state, steps):
    """Derivatives (C, 12 N) of the pulls of one row with respect to the state at its time of emission, and differences
    of pulls.

    ``steps`` has a step for each of the kinds; differences of other kinds are zero.
    """
    options = {"output": "ends", "dense": False}
    end = state.time * (1.0 + 1e-9)
    run = system.integrate(state, end, derivatives=True, **options)
    exact = np.asarray(data.derivatives(run).start)[0]
    differences = np.zeros_like(exact)
    for body in range(len(system)):
        for kind, step in steps.items():
            for axis in range(3):
                ends = [
                    data.pulls(system.integrate(displaced(state, body, kind, axis, sign * step), end, **options))[0]
                    for sign in (1, -1)
                ]
                differences[:, 12 * body + 3 * KINDS.index(kind) + axis] = (ends[0] - ends[1]) / (2 * step)
    return exact, differences


def assert_by_kind(exact, differences, relative, absolute=0.0):
    """Derivatives (C, 12 N) equal differences, relative to the largest of their kind of component, for all kinds."""
    for kind in range(4):
        columns = [12 * body + 3 * kind + axis for body in range(exact.shape[1] // 12) for axis in range(3)]
        size = np.abs(differences[:, columns]).max()
        np.testing.assert_allclose(exact[:, columns], differences[:, columns], atol=relative * size + absolute)
