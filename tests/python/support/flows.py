"""Equations of motion and conserved quantities with which a motion's derivatives are compared."""

import fullbody
import numpy as np

from support import body_list, quaternion_product
from support.meshes import box, octahedron

TIGHT = fullbody.Verner98(rtol=1e-14, atol=1e-14)
SOLIDS = {
    "box": box(1.0, 0.8, 0.6),
    "octahedron": octahedron(0.7, 0.6, 0.5),
    "ellipsoid": fullbody.Ellipsoid(0.7, 0.5, 0.4),
    "sphere": fullbody.Sphere(0.5),
    "point": fullbody.PointMass(),
    "composite": fullbody.Composite(
        [
            fullbody.Part(box(0.5, 0.4, 0.3), mass=0.3, position=[0.3, 0.0, 0.0], attitude=[0.9, 0.1, 0.3, 0.2]),
            fullbody.Part(fullbody.Ellipsoid(0.3, 0.2, 0.25), mass=0.2, position=[-0.2, 0.1, 0.0]),
        ]
    ),
}


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def inertia(body):
    """Principal moments (b^2 + c^2, ...) m / 5 of a homogeneous ellipsoid; none of a point; those of other bodies."""
    if isinstance(body.shape, (fullbody.Composite, fullbody.Polyhedron)):
        return body.inertia
    squares = np.square([getattr(body.shape, axis, 0.0) for axis in "abc"])
    return body.mass / 5.0 * (squares.sum() - squares)


def rates(system, state):
    """Newton's and Euler's equations as a deviation: velocity, acceleration, spin, its rate."""
    f = system.interactions(state)
    rows = []
    for k, body in enumerate(system):
        moments, spin = inertia(body), state.spin[k]
        turning = f.torque[k] - np.cross(spin, moments * spin)
        rate = turning / moments if moments.all() else np.zeros(3)
        rows += [state.velocity[k], f.force[k] / body.mass, spin, rate]
    return np.concatenate(rows)


def energy_gradient(system, state):
    f = system.interactions(state)
    rows = []
    for k, body in enumerate(system):
        rows += [-f.force[k], body.mass * state.velocity[k], -f.torque[k], inertia(body) * state.spin[k]]
    return np.concatenate(rows)


def momentum_gradients(system, state):
    """Gradients of the momentum and of the angular momentum about the origin: (6, 12 N)."""
    linear, angular = [], []
    for k, body in enumerate(system):
        rotation, moments = state.rotation_matrix[k], np.diag(inertia(body))
        zero, mass = np.zeros((3, 3)), body.mass
        linear += [zero, mass * np.eye(3), zero, zero]
        angular += [
            -mass * cross(state.velocity[k]),
            mass * cross(state.position[k]),
            -rotation @ cross(moments @ state.spin[k]),
            rotation @ moments,
        ]
    return np.vstack([np.hstack(linear), np.hstack(angular)])


def symplectic_form(system, state):
    """The canonical two-form in these deviations: m dv ^ dx, and d(I spin) ^ theta + (I spin) . (theta x theta)."""
    n = len(system)
    form = np.zeros((12 * n, 12 * n))
    for k, body in enumerate(system):
        x, v, t, w = (slice(12 * k + 3 * i, 12 * k + 3 * i + 3) for i in range(4))
        moments = np.diag(inertia(body))
        form[x, v], form[v, x] = body.mass * np.eye(3), -body.mass * np.eye(3)
        form[t, w], form[w, t] = moments, -moments
        form[t, t] = -cross(moments @ state.spin[k])
    return form


def scales(system, state):
    """Natural sizes of the 12 N numbers: separation and orbit's rate."""
    length = np.linalg.norm(state.position[1] - state.position[0])
    rate = np.sqrt(float(system.mu()) / length**3)
    return np.tile(np.repeat([length, length * rate, 1.0, rate], 3), len(system))


def tumbling(gravity="focal", **options):
    """Two triaxial ellipsoids near each other, tilted and tumbling."""
    bodies = body_list(A=(fullbody.Ellipsoid(1.0, 0.8, 0.6), 1.0), B=(fullbody.Ellipsoid(0.4, 0.7, 0.5), 0.4))
    state = fullbody.State.from_tait_bryan(
        [[0.1, 0.0, 0.2], [2.6, 0.3, -0.4]],
        [[0.0, -0.1, 0.02], [0.1, 0.7, 0.1]],
        [[0.2, -0.3, 0.9], [1.0, 0.4, -0.5]],
        [[0.1, -0.2, 0.5], [0.3, 0.1, -0.4]],
    )
    return fullbody.System(bodies, G=1.0, gravity=gravity, **options), state


def solids(first, second, distance, gravity="focal"):
    """Two of these solids at a distance, tilted and tumbling."""
    named = (("A", first, 1.0), ("B", second, 0.4))
    bodies = [fullbody.Body(SOLIDS[s], name=n, **({} if s == "composite" else {"mass": m})) for n, s, m in named]
    offset = distance * np.array([0.7, 0.6, -0.39])
    state = fullbody.State.from_tait_bryan(
        [-0.3 * offset, 0.7 * offset],
        [[0.0, -0.1, 0.02], [0.1, 0.5, 0.1]],
        [[0.2, -0.3, 0.9], [1.0, 0.4, -0.5]],
        [[0.1, -0.2, 0.5], [0.3, 0.1, -0.4]],
    )
    return fullbody.System(bodies, G=1.0, gravity=gravity), state


def scaled(matrix, system, state):
    """Numbers in natural sizes, so that all entries compare."""
    size = scales(system, state)
    return matrix * size / size[:, np.newaxis]


def displaced(state, body, kind, axis, by):
    """The state with one of its 12 N numbers changed."""
    parts = [np.array(part) for part in (state.position, state.velocity, state.attitude, state.spin)]
    if kind == 2:
        rotation = np.zeros(4)
        rotation[0], rotation[1 + axis] = np.cos(by / 2), np.sin(by / 2)
        parts[2][body] = quaternion_product(parts[2][body], rotation)
    else:
        parts[kind][body, axis] += by
    return fullbody.State(*parts, time=state.time)


def deviation(first, other):
    """The deviation of one state from another that is near by, in 12 N numbers."""
    rows = []
    for k in range(len(first.position)):
        rotation = quaternion_product(first.attitude[k] * [1, -1, -1, -1], other.attitude[k])
        rows += [other.position[k] - first.position[k], other.velocity[k] - first.velocity[k]]
        sine = np.linalg.norm(rotation[1:])
        rows += [2 * np.arcsin(sine) / max(sine, 1e-300) * rotation[1:] * np.sign(rotation[0])]
        rows += [other.spin[k] - first.spin[k]]
    return np.concatenate(rows)


def central(run_with, step):
    """Derivative of the end of a run by differences of fourth order."""
    single, double = (deviation(run_with(-k * step), run_with(k * step)) / (2 * k * step) for k in (1, 2))
    return (4 * single - double) / 3


def central_of_state(numbers, step):
    """Derivative of numbers by differences of fourth order."""
    single, double = ((numbers(k * step) - numbers(-k * step)) / (2 * k * step) for k in (1, 2))
    return (4 * single - double) / 3
