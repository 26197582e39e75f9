"""What a motion's derivatives are compared with: the equations of motion and the quantities that motions conserve."""

import fullbody
import numpy as np


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def inertia(body):
    """Principal moments (b^2 + c^2, ...) m / 5 of a homogeneous ellipsoid; none of a point."""
    squares = np.square([getattr(body.shape, axis, 0.0) for axis in "abc"])
    return body.mass / 5.0 * (squares.sum() - squares)


def rates(system, state):
    """Newton's and Euler's equations as a departure: velocity, acceleration, spin, its rate."""
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
    """Of the momentum and of the angular momentum about the origin: (6, 12 N)."""
    linear, angular = [], []
    for k, body in enumerate(system):
        turn, moments = state.rotation_matrix[k], np.diag(inertia(body))
        zero, mass = np.zeros((3, 3)), body.mass
        linear += [zero, mass * np.eye(3), zero, zero]
        angular += [
            -mass * cross(state.velocity[k]),
            mass * cross(state.position[k]),
            -turn @ cross(moments @ state.spin[k]),
            turn @ moments,
        ]
    return np.vstack([np.hstack(linear), np.hstack(angular)])


def symplectic_form(system, state):
    """The canonical two-form in these departures: m dv ^ dx, and d(I spin) ^ theta + (I spin) . (theta x theta)."""
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
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.6), mass=1.0, name="A"),
        fullbody.Body(fullbody.Ellipsoid(0.4, 0.7, 0.5), mass=0.4, name="B"),
    ]
    state = fullbody.State.from_tait_bryan(
        position=[[0.1, 0.0, 0.2], [2.6, 0.3, -0.4]],
        velocity=[[0.0, -0.1, 0.02], [0.1, 0.7, 0.1]],
        angles=[[0.2, -0.3, 0.9], [1.0, 0.4, -0.5]],
        spin=[[0.1, -0.2, 0.5], [0.3, 0.1, -0.4]],
    )
    return fullbody.System(bodies, G=1.0, gravity=gravity, **options), state
