"""Didymos and Dimorphos just after the impact of DART, from the uncertain numbers."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import numpy as np
from fullbody import Body, Ellipsoid, State, System, forces, systems
from fullbody.base import rotations
from fullbody.frames import pole_vector

from .inputs import INPUTS

__all__ = ["DAY", "GRAVITY", "NAMES", "ORBIT", "beta", "masses", "planar", "rotated_to_pole", "setup"]

#: The hours in a day, the gravitational constant in km^3/(kg h^2), and a mm/s in km/h.
DAY: Final = 24.0
G: Final = 6.6743e-11 * 1e-9 * 3600.0**2
MM_S: Final = 1e-6 * 3600.0
#: The mean motion before the impact, and that of Didymos' rotation, rad/h.
ORBIT: Final = 2.0 * np.pi / INPUTS["period_before"].value
SPIN: Final = 2.0 * np.pi / INPUTS["rotation"].value
#: The quality factor of the tides.
Q: Final = 10.0
#: The exact rule for the gravity of two ellipsoids.
GRAVITY: Final = "focal"
#: The numbers that :func:`setup` takes.
NAMES: Final = (
    "separation",
    "equatorial",
    "polar",
    "diameter",
    "density",
    "along",
    "radial",
    "normal",
    "miss_radial",
    "miss_normal",
    "a_b",
    "b_c",
    "yaw",
    "log_k2_q",
    "log_k2_q_primary",
    "byorp",
    "pole_longitude",
    "pole_latitude",
)
#: The figure of Dimorphos before the impact, as ratios of axes.
BEFORE: Final = (INPUTS["a_b_before"].value, INPUTS["b_c_before"].value)


def ellipsoid(diameter: float, a_b: float, b_c: float) -> Ellipsoid:
    """Return an ellipsoid by the diameter of its volume and the ratios of its axes; km."""
    b = diameter / 2 * (b_c / a_b) ** (1 / 3)
    return Ellipsoid(b * a_b, b, b / b_c)


def masses(separation: float, equatorial: float, polar: float, diameter: float, density: float) -> tuple[float, float]:
    """Return masses of Didymos and Dimorphos, kg, from metres and kg/m3.

    The relative acceleration at the distance is that of the circular orbit of the period before the impact. It is
    linear in both masses, and the mass of Dimorphos is its density times its volume.
    """
    secondary = density * np.pi / 6 * diameter**3
    resting = State([[0.0, 0.0, 0.0], [separation / 1e3, 0.0, 0.0]], np.zeros((2, 3)))
    shapes = Ellipsoid(equatorial / 1e3, equatorial / 1e3, polar / 1e3), ellipsoid(diameter / 1e3, *BEFORE)
    pair = System([Body(shape, mass=1.0) for shape in shapes], G=1.0, gravity=GRAVITY)
    attraction = -pair.interactions(resting).force[1, 0]
    return ORBIT**2 * separation / 1e3 / (G * attraction) - secondary, secondary


def setup(
    *,
    log_k2_q: float,
    log_k2_q_primary: float,
    byorp: float,
    pole_longitude: float,
    pole_latitude: float,
    **values: float,
) -> tuple[System, State]:
    """Make the system and its state just after the impact, km, hours and kg, from the numbers :data:`NAMES`.

    Time zero is the impact. The frame is the ecliptic of J2000. ``values`` are the arguments of :func:`start`.
    """
    bodies, state = start(**values)
    system = System(
        bodies,
        G=G,
        gravity=GRAVITY,
        forces=_perturbations(log_k2_q, log_k2_q_primary, byorp),
        epoch=systems.published("didymos_after_dart").epoch,
        frame="ecliptic",
    )
    return system, rotated_to_pole(state, pole_longitude, pole_latitude)


def planar(**values: float) -> tuple[System, State]:
    """Make the system in the axes of its orbit for a motion within the plane of the orbit.

    ``values`` are the arguments of :func:`start` but ``normal`` and ``miss_normal``. The forces are left out, since
    their effects within months are negligible.
    """
    bodies, state = start(**values, normal=0.0, miss_normal=0.0)
    return System(bodies, G=G, gravity=GRAVITY), state


def start(
    *,
    separation: float,
    equatorial: float,
    polar: float,
    diameter: float,
    density: float,
    along: float,
    radial: float,
    normal: float,
    miss_radial: float,
    miss_normal: float,
    a_b: float,
    b_c: float,
    yaw: float,
) -> tuple[list[Body], State]:
    """Return bodies and state just after the impact: x from Didymos to Dimorphos, z along the orbit's pole."""
    primary, secondary = masses(separation, equatorial, polar, diameter, density)
    bodies = [
        Body(Ellipsoid(equatorial / 1e3, equatorial / 1e3, polar / 1e3), mass=primary, name="Didymos"),
        Body(ellipsoid(diameter / 1e3, a_b, b_c), mass=secondary, name="Dimorphos"),
    ]
    change = np.array([radial, along, normal]) * MM_S
    share = secondary / (primary + secondary)
    position = np.array([[-share, 0.0, 0.0], [1.0 - share, 0.0, 0.0]]) * separation / 1e3
    velocity = ORBIT * np.stack([-position[:, 1], position[:, 0], position[:, 2]], axis=1)
    velocity[1] += change
    velocity -= share * change
    angle = np.deg2rad(yaw)
    attitude = np.array([[1.0, 0.0, 0.0, 0.0], [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]])
    # The reshaping conserves the angular momentum, to which the impulse m dv beside the centre adds.
    inertia = bodies[1].inertia
    intact = Body(ellipsoid(diameter / 1e3, *BEFORE), mass=secondary).inertia[2] * ORBIT
    impulse = np.cross([miss_radial / 1e3, 0.0, miss_normal / 1e3], secondary * change)
    x, y = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])
    spin = np.array([[0.0, 0.0, SPIN], np.array([x @ impulse, y @ impulse, impulse[2] + intact]) / inertia])
    return bodies, State(position, velocity, attitude, spin)


def beta(along: Any, density: Any, diameter: Any) -> Any:
    """Return the momentum enhancement along the motion: Dimorphos' momentum over the spacecraft's, as in `setup`."""
    momentum = INPUTS["dart_mass"].value * INPUTS["dart_speed"].value
    return -along * 1e-3 * density * np.pi / 6 * diameter**3 / momentum


def _perturbations(log_k2_q: float, log_k2_q_primary: float, byorp: float) -> list[forces.Force]:
    lag = forces.lag_from_quality_factor(Q=Q, mean_motion=ORBIT, tide="libration")
    lag_primary = forces.lag_from_quality_factor(Q=Q, mean_motion=ORBIT, tide="semidiurnal", spin=SPIN)
    sun, pressure = _sunlight()
    return [
        sun,
        forces.Tide(on="Dimorphos", by="Didymos", k2=Q * 10.0**log_k2_q, lag=lag),
        forces.Tide(on="Didymos", by="Dimorphos", k2=Q * 10.0**log_k2_q_primary, lag=lag_primary),
        forces.Byorp(
            on="Dimorphos",
            about="Didymos",
            coefficient=byorp,
            normalization="jacobson_scheeres_2011",
            pressure=pressure,
        ),
    ]


@lru_cache(maxsize=1)
def _sunlight() -> tuple[forces.Force, float]:
    """Return the Sun as in the published system, and the mean pressure of its light, kg/(km h^2)."""
    published = systems.published("didymos_after_dart")
    a, e = published["heliocentric orbit (a, e, i, Omega, omega, M), ecliptic"][:2]
    system, _ = systems.didymos_after_dart(sun=True)
    return system.forces[0], forces.solar_pressure(f"{a} au", e).to_value("kg / (km h2)")


def rotated_to_pole(state: State, longitude: float, latitude: float) -> State:
    """Rotate a state from the axes of the orbit into the ecliptic of J2000, by the orbit's pole in degrees.

    The x-axis of the orbit is along its node.
    """
    z = pole_vector(np.deg2rad(longitude), np.deg2rad(latitude))
    x = np.array([-np.sin(np.deg2rad(longitude)), np.cos(np.deg2rad(longitude)), 0.0])
    matrix = np.stack([x, np.cross(z, x), z], axis=1)
    rotation = rotations.quaternion(matrix)
    return state.replace(
        position=state.position @ matrix.T,
        velocity=state.velocity @ matrix.T,
        attitude=np.array([rotations.product(rotation, q) for q in state.attitude]),
    )
