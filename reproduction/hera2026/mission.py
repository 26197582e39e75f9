"""Simulated data of two weeks of Hera's radio and camera, and their fit.

The spacecraft coasts past the pair twice, a week each. Each pass is a body of the system with the mass of the
spacecraft, so that it moves in the gravity of both asteroids and is differentiated with them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody import Body, Ellipsoid, PointMass, Run, State, System, Verner98
from fullbody.base import rotations
from fullbody.observing import Geometry, RadarAstrometry
from fullbody.record.derivatives import FunctionDerivatives

from . import model

__all__ = ["FITTED", "LENGTH", "PASSES", "Landmarks", "Truth", "fitted", "simulated", "survey"]

_Array = npt.NDArray[np.float64]

#: Hours of the middle of the passes after the start, distances at it (km), and directions from the pair.
PASSES: Final = ((84.0, 30.0, (0.8, 0.5, 0.33)), (252.0, 12.5, (0.9, 0.3, -0.31)))
LENGTH: Final = 336.0
#: The speed of the spacecraft in km/h, 0.1 m/s, and its mass in kg.
SPEED: Final = 0.36
CRAFT_MASS: Final = 1000.0
#: Errors: of a range, km; of a range rate over an hour, km/h (0.03 mm/s); of a direction, rad (one pixel).
RANGE_ERROR: Final = 0.005
RATE_ERROR: Final = 0.03 * model.MM_S
PIXEL: Final = 94e-6
#: Hours between images and between radio data.
IMAGES: Final = 2.0
RADIO: Final = 1.0
#: The vector to the Earth, which is constant: 1.29 au.
EARTH: Final = 1.29 * 1.495978707e8 * np.array([0.6, 0.8, 0.0])
#: The landmarks on Dimorphos in units of its semi-axes.
LANDMARKS: Final = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
SEED: Final = 33
#: The masses and figures that are fitted, attributes of :class:`Truth`.
FITTED: Final = ("primary_mass", "secondary_mass", "polar", "a_b", "b_c")


@dataclass(frozen=True)
class Truth:
    """The pair as it is simulated at the start of the survey.

    Attributes
    ----------
    primary_mass, secondary_mass : float
        The masses of Didymos and Dimorphos, kg.
    equatorial, polar, diameter, a_b, b_c : float
        Figures, as in :func:`reproduction.hera2026.model.setup`.
    state : ndarray, (2, 13)
        Positions, velocities, attitudes and spins of Didymos and Dimorphos.
    """

    primary_mass: float
    secondary_mass: float
    equatorial: float
    polar: float
    diameter: float
    a_b: float
    b_c: float
    state: _Array


class Landmarks:
    """Directions from the spacecraft to landmarks on a body, as observations of a fit.

    Parameters
    ----------
    times : ndarray, (K,)
        Hours.
    positions : ndarray, (L, 3)
        The landmarks in the frame of the body, km.
    body, camera : str
        The names of the body and of the pass of the spacecraft.
    directions : ndarray, (K, L, 3)
        The measured directions, unit vectors.
    visible : ndarray of bool, (K, L)
        The directions that were measured.
    sigma : float
        The error of a direction about each of two axes, rad.
    """

    def __init__(
        self,
        times: _Array,
        positions: _Array,
        body: str,
        camera: str,
        directions: _Array,
        visible: npt.NDArray[np.bool_],
        sigma: float,
    ) -> None:
        self.times, self.positions, self.body, self.camera = times, positions, body, camera
        self.directions, self.visible, self.sigma = directions, visible, sigma
        # Two axes normal to each measured direction.
        normal = np.cross(directions, [0.0, 0.0, 1.0])
        first = normal / np.linalg.norm(normal, axis=2)[..., None]
        self._axes = np.stack([first, np.cross(directions, first)], axis=2)

    def emission(self, system: System) -> _Array:
        """Return the times at which the fit has to sample the run."""
        return self.times

    @staticmethod
    def predicted(run: Run, body: str, camera: str, positions: _Array) -> _Array:
        """Return unit vectors (K, L, 3) from the camera to landmarks on a body."""
        target, observer = run.system.index(body), run.system.index(camera)
        rotated = np.einsum("kij,lj->kli", rotations.matrices(run.attitude[:, target]), positions)
        vector = run.position[:, None, target] + rotated - run.position[:, None, observer]
        return np.asarray(vector / np.linalg.norm(vector, axis=2)[..., None])

    def pulls(self, run: Run) -> _Array:
        """Return the residuals about both axes, divided by their errors."""
        residual = self.directions - self.predicted(run, self.body, self.camera, self.positions)
        return np.asarray(np.einsum("klax,klx->kla", self._axes, residual)[self.visible].ravel() / self.sigma)

    def derivatives(self, run: Run) -> FunctionDerivatives:
        """Return the derivatives of the pulls with respect to the start of a run and to its parameters."""
        body, camera = run.system.index(self.body), run.system.index(self.camera)
        matrices = rotations.matrices(run.attitude[:, body])
        landmark = run.position[:, None, body] + np.einsum("kij,lj->kli", matrices, self.positions)
        distance = np.linalg.norm(landmark - run.position[:, None, camera], axis=2)
        unit = (landmark - run.position[:, None, camera]) / distance[..., None]
        # A displacement of a landmark changes its direction by the component normal to the direction.
        normal = self._axes - np.einsum("klax,klx->kla", self._axes, unit)[..., None] * unit[:, :, None]
        by_position = -normal / (distance[..., None, None] * self.sigma)
        # A small rotation vector t of the body displaces a landmark p by R (t x p).
        lever = np.cross(np.eye(3)[None], self.positions[:, None])
        by_rotation = np.einsum("klax,kxi,lji->klaj", by_position, matrices, lever)
        by_state = np.zeros((*by_position.shape[:3], 12 * len(run.system.bodies)))
        by_state[..., 12 * body : 12 * body + 3] += by_position
        by_state[..., 12 * body + 6 : 12 * body + 9] += by_rotation
        by_state[..., 12 * camera : 12 * camera + 3] -= by_position
        start = np.einsum("klas,kst->klat", by_state, run.transition)[self.visible]
        by_parameter = {
            name: np.einsum("klas,ks->kla", by_state, sensitivity)[self.visible].ravel()
            for name, sensitivity in run.sensitivity.items()
        }
        return FunctionDerivatives(self.pulls(run), start.reshape(-1, start.shape[-1]), by_parameter)

    def __repr__(self) -> str:
        return f"Landmarks({len(self.positions)} on {self.body} from {self.camera})"


def bodies(
    truth: Truth, primary_mass: float, secondary_mass: float, polar: float, a_b: float, b_c: float
) -> list[Body]:
    """Return Didymos, Dimorphos and the passes."""
    equatorial = truth.equatorial / 1e3
    return [
        Body(Ellipsoid(equatorial, equatorial, polar / 1e3), mass=primary_mass, name="Didymos"),
        Body(model.ellipsoid(truth.diameter / 1e3, a_b, b_c), mass=secondary_mass, name="Dimorphos"),
        *(Body(PointMass(), mass=CRAFT_MASS, name=f"Hera {k + 1}") for k in range(len(PASSES))),
    ]


def craft() -> tuple[_Array, _Array]:
    """Return positions and velocities (P, 3) of the passes at the start, on straight lines through their middles."""
    positions, velocities = [], []
    for middle, distance, direction in PASSES:
        u = np.array(direction) / np.linalg.norm(direction)
        w = np.cross([0.0, 0.0, 1.0], u)
        w = SPEED * w / np.linalg.norm(w)
        positions.append(distance * u - middle * w)
        velocities.append(w)
    return np.array(positions), np.array(velocities)


def survey(truth: Truth) -> tuple[Any, dict[str, Any]]:
    """Return the setup of the fit, and its parameters at the truth: masses, figures, and changes of the state.

    The changes are those of the position and velocity of Dimorphos and of each pass, of the attitude of Dimorphos (a
    rotation vector in its frame), and of its spin. The path of the pair's barycentre about the Sun counts as known.
    """
    kinds = ("position", "velocity", "rotation", "spin")
    changes = [f"{kind}_{axis}" for kind in kinds for axis in "xyz"]
    passes = [f"hera{k + 1}_{kind}_{axis}" for k in range(len(PASSES)) for kind in kinds[:2] for axis in "xyz"]
    positions, velocities = craft()

    def setup(**values: float) -> tuple[System, State]:
        result = bodies(truth, *(values[name] for name in FITTED))
        change = {kind: np.array([values[f"{kind}_{axis}"] for axis in "xyz"]) for kind in kinds}
        craft_change = np.array([values[name] for name in passes]).reshape(len(PASSES), 2, 3)
        position, velocity, attitude, spin = np.split(truth.state, [3, 6, 10], axis=1)
        position = np.concatenate([position, positions + craft_change[:, 0]])
        velocity = np.concatenate([velocity, velocities + craft_change[:, 1]])
        position[1] += change["position"]
        velocity[1] += change["velocity"]
        rotated = rotations.product(attitude[1], _rotation(change["rotation"]))
        attitude = np.concatenate([[attitude[0], rotated], np.tile([1.0, 0.0, 0.0, 0.0], (len(PASSES), 1))])
        spin = np.concatenate([spin, np.zeros((len(PASSES), 3))])
        spin[1] += change["spin"]
        return System(result, G=model.G, gravity=model.GRAVITY), State(position, velocity, attitude, spin)

    return setup, {name: getattr(truth, name) for name in FITTED} | dict.fromkeys([*changes, *passes], 0.0)


def _rotation(vector: _Array) -> _Array:
    """Return the quaternion of a small rotation vector."""
    angle = np.linalg.norm(vector)
    return np.concatenate([[np.cos(angle / 2)], 0.5 * np.sinc(angle / (2 * np.pi)) * vector])


def simulated(truth: Truth) -> list[Any]:
    """Return ranges, range rates and directions that the spacecraft would measure, with errors."""
    rng = np.random.default_rng(SEED)
    setup, values = survey(truth)
    system, state = setup(**values)
    run = system.integrate(state, LENGTH, dense=True, integrator=Verner98(1e-11, 1e-11))
    shape = np.array([system["Dimorphos"].shape.a, system["Dimorphos"].shape.b, system["Dimorphos"].shape.c])
    geometry = Geometry([-1.0, LENGTH + 1.0], to_observer=EARTH, light_time=False)
    data: list[Any] = []
    for k in range(len(PASSES)):
        first, last = (LENGTH * share / len(PASSES) for share in (k, k + 1))
        name = f"Hera {k + 1}"
        times = np.arange(first, last, RADIO)
        options: dict[str, Any] = {"sigma": (RANGE_ERROR, RATE_ERROR), "body": name, "geometry": geometry}
        exact = RadarAstrometry(times, range=0.0 * times, range_rate=0.0 * times, **options).predict(run)
        ranges = exact.range + rng.normal(0.0, RANGE_ERROR, len(times))
        rates = exact.range_rate + rng.normal(0.0, RATE_ERROR, len(times))
        data.append(RadarAstrometry(times, range=ranges, range_rate=rates, **options))
        times = np.arange(first + IMAGES / 2, last, IMAGES)
        images = system.integrate(state, times[-1], output=times, integrator=Verner98(1e-11, 1e-11))
        for body, positions in (("Dimorphos", LANDMARKS * shape), ("Didymos", np.zeros((1, 3)))):
            directions = Landmarks.predicted(images, body, name, positions)
            outward = np.einsum("kij,lj->kli", rotations.matrices(images.attitude[:, system.index(body)]), positions)
            visible = np.einsum("klx,klx->kl", outward, directions) <= 0.0
            directions = directions + rng.normal(0.0, PIXEL, directions.shape)
            directions /= np.linalg.norm(directions, axis=2)[..., None]
            data.append(Landmarks(times, positions, body, name, directions, visible, PIXEL))
    return data


def fitted(truth: Truth, progress: Any = False) -> Any:
    """Fit the simulated data, from a start that differs from the truth by some errors, as after a preliminary fit."""
    rng = np.random.default_rng([SEED, 1])
    setup, values = survey(truth)
    sizes = dict(zip(FITTED, (1e-4 * truth.primary_mass, 0.01 * truth.secondary_mass, 0.5, 1e-3, 3e-3), strict=True))
    kinds = {"position": 3e-4, "velocity": 1e-5, "rotation": 1e-3, "spin": 1e-5}
    start = {}
    for name, value in values.items():
        size = sizes[name] if name in sizes else next(kinds[part] for part in name.split("_") if part in kinds)
        start[name] = fullbody.fitting.Free(value + rng.normal(0.0, size), prior=(value, 1e3 * size))
    return fullbody.fit(setup, start, simulated(truth), integrator=Verner98(1e-9, 1e-9), progress=progress)
