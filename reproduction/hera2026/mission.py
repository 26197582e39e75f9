"""What two weeks of Hera's radio and camera would tell: simulated data, and the posterior that they leave.

The spacecraft coasts past the pair twice, a week each. Each pass is a body of its own of the system, with the mass of
the spacecraft, so that its motion feels the gravity of both asteroids and is differentiated with theirs.
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

__all__ = ["LENGTH", "PASSES", "Landmarks", "Truth", "fitted", "simulated", "survey"]

_Array = npt.NDArray[np.float64]

#: Hours of the middle of the passes after the start, distances at it (km), and directions from the pair.
PASSES: Final = ((84.0, 30.0, (0.8, 0.5, 0.33)), (252.0, 12.5, (0.9, 0.3, -0.31)))
LENGTH: Final = 336.0
#: km/h: 0.1 m/s. kg.
SPEED: Final = 0.36
CRAFT: Final = 1000.0
#: Errors: of a range, km; of a range rate over an hour, km/h (0.03 mm/s); of a direction, rad (one pixel).
RANGE_ERROR: Final = 0.005
RATE_ERROR: Final = 0.03 * model.MM_S
PIXEL: Final = 94e-6
#: Hours between images and between radio data.
IMAGES: Final = 2.0
RADIO: Final = 1.0
#: The earth, far away in a fixed direction: 1.29 au.
EARTH: Final = 1.29 * 1.495978707e8 * np.array([0.6, 0.8, 0.0])
#: Places on Dimorphos in units of its semi-axes.
PLACES: Final = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
SEED: Final = 33
ABOUT: Final = ("x", "y", "z")


@dataclass(frozen=True)
class Truth:
    """The pair as it is simulated at the start of the survey.

    Attributes
    ----------
    big, small : float
        Masses, kg.
    equatorial, polar, diameter, a_b, b_c : float
        Figures, as in :func:`reproduction.hera2026.model.setup`.
    state : ndarray, (2, 13)
        Positions, velocities, attitudes and spins of Didymos and Dimorphos.
    """

    big: float
    small: float
    equatorial: float
    polar: float
    diameter: float
    a_b: float
    b_c: float
    state: _Array


class Landmarks:
    """Directions from the spacecraft to places on a body, as an observation that a fit takes.

    Parameters
    ----------
    times : ndarray, (K,)
    places : ndarray, (L, 3)
        In the body's frame, km.
    body, camera : str
    lines : ndarray, (K, L, 3)
        Measured directions, unit vectors.
    seen : ndarray of bool, (K, L)
        Which of them were measured.
    sigma : float
        Error of a direction about each of two axes, rad.
    """

    def __init__(
        self,
        times: _Array,
        places: _Array,
        body: str,
        camera: str,
        lines: _Array,
        seen: npt.NDArray[np.bool_],
        sigma: float,
    ) -> None:
        self.times, self.places, self.body, self.camera = times, places, body, camera
        self.lines, self.seen, self.sigma = lines, seen, sigma
        # Two axes across each measured direction.
        across = np.cross(lines, [0.0, 0.0, 1.0])
        first = across / np.linalg.norm(across, axis=2)[..., None]
        self._axes = np.stack([first, np.cross(lines, first)], axis=2)

    def emission(self, system: System) -> _Array:
        """Return the times at which the fit has to sample the run."""
        return self.times

    @staticmethod
    def directions(run: Run, body: str, camera: str, places: _Array) -> _Array:
        """Return unit vectors (K, L, 3) from the camera to places on a body."""
        body_, camera_ = run.system.index(body), run.system.index(camera)
        rotated = np.einsum("kij,lj->kli", rotations.matrices(run.attitude[:, body_]), places)
        line = run.position[:, None, body_] + rotated - run.position[:, None, camera_]
        return np.asarray(line / np.linalg.norm(line, axis=2)[..., None])

    def pulls(self, run: Run) -> _Array:
        """Return the residuals about both axes, divided by their errors."""
        result = self.directions(run, self.body, self.camera, self.places)
        return np.asarray(np.einsum("klax,klx->kla", self._axes, self.lines - result)[self.seen].ravel() / self.sigma)

    def derivatives(self, run: Run) -> FunctionDerivatives:
        """Return the derivatives of the pulls with respect to the start of a run and to its parameters."""
        body, camera = run.system.index(self.body), run.system.index(self.camera)
        matrices = rotations.matrices(run.attitude[:, body])
        line = run.position[:, None, body] + np.einsum("kij,lj->kli", matrices, self.places)
        distance = np.linalg.norm(line - run.position[:, None, camera], axis=2)
        unit = (line - run.position[:, None, camera]) / distance[..., None]
        # A change of the vector to a place changes its direction by the part across it.
        across = self._axes - np.einsum("klax,klx->kla", self._axes, unit)[..., None] * unit[:, :, None]
        moved = -across / (distance[..., None, None] * self.sigma)
        # A small rotation vector t of the body moves a place p by R (t x p).
        rotated = np.einsum("klax,kxi,lji->klaj", moved, matrices, np.cross(np.eye(3)[None], self.places[:, None]))
        by_state = np.zeros((*moved.shape[:3], 12 * len(run.system.bodies)))
        by_state[..., 12 * body : 12 * body + 3] += moved
        by_state[..., 12 * body + 6 : 12 * body + 9] += rotated
        by_state[..., 12 * camera : 12 * camera + 3] -= moved
        start = np.einsum("klas,kst->klat", by_state, run.transition)[self.seen]
        by = {
            name: np.einsum("klas,ks->kla", by_state, sensitivity)[self.seen].ravel()
            for name, sensitivity in run.sensitivity.items()
        }
        return FunctionDerivatives(self.pulls(run), start.reshape(-1, start.shape[-1]), by)

    def __repr__(self) -> str:
        return f"Landmarks({len(self.places)} on {self.body} from {self.camera})"


def bodies(truth: Truth, big: float, small: float, polar: float, a_b: float, b_c: float) -> list[Body]:
    """Return Didymos, Dimorphos and the passes."""
    round_ = truth.equatorial / 1e3
    return [
        Body(Ellipsoid(round_, round_, polar / 1e3), mass=big, name="Didymos"),
        Body(model.ellipsoid(truth.diameter / 1e3, a_b, b_c), mass=small, name="Dimorphos"),
        *(Body(PointMass(), mass=CRAFT, name=f"Hera {k + 1}") for k in range(len(PASSES))),
    ]


def craft() -> tuple[_Array, _Array]:
    """Return positions and velocities (P, 3) of the passes at the start, on straight lines through their middles."""
    positions, speeds = [], []
    for middle, distance, direction in PASSES:
        u = np.array(direction) / np.linalg.norm(direction)
        w = np.cross([0.0, 0.0, 1.0], u)
        w = SPEED * w / np.linalg.norm(w)
        positions.append(distance * u - middle * w)
        speeds.append(w)
    return np.array(positions), np.array(speeds)


def survey(truth: Truth) -> tuple[Any, dict[str, Any]]:
    """Return the setup of the fit, and its parameters where the truth is: masses, figures, and departures of the state.

    Departures are of Dimorphos from Didymos, of Dimorphos' attitude (a rotation vector in its frame) and spin, and of
    each pass. The path of the pair's barycentre about the Sun counts as known.
    """
    kinds = [f"{kind}_{axis}" for kind in ("place", "speed", "turn", "spin") for axis in ABOUT]
    passes = [f"hera{k + 1}_{kind}_{axis}" for k in range(len(PASSES)) for kind in ("place", "speed") for axis in ABOUT]
    positions, speeds = craft()

    def setup(**values: float) -> tuple[System, State]:
        result = bodies(truth, *(values[name] for name in ("big", "small", "polar", "a_b", "b_c")))
        by = {
            kind: np.array([values[f"{kind}_{axis}"] for axis in ABOUT]) for kind in ("place", "speed", "turn", "spin")
        }
        of_passes = np.array([values[name] for name in passes]).reshape(len(PASSES), 2, 3)
        position, velocity, attitude, spin = np.split(truth.state, [3, 6, 10], axis=1)
        position = np.concatenate([position, positions + of_passes[:, 0]])
        velocity = np.concatenate([velocity, speeds + of_passes[:, 1]])
        position[1] += by["place"]
        velocity[1] += by["speed"]
        rotated = rotations.product(attitude[1], _rotation(by["turn"]))
        attitude = np.concatenate([[attitude[0], rotated], np.tile([1.0, 0.0, 0.0, 0.0], (len(PASSES), 1))])
        spin = np.concatenate([spin, np.zeros((len(PASSES), 3))])
        spin[1] += by["spin"]
        return System(result, G=model.G, gravity=model.GRAVITY), State(position, velocity, attitude, spin)

    figures = {"big": truth.big, "small": truth.small, "polar": truth.polar, "a_b": truth.a_b, "b_c": truth.b_c}
    return setup, figures | dict.fromkeys([*kinds, *passes], 0.0)


def _rotation(vector: _Array) -> _Array:
    """Return the quaternion of a small rotation vector."""
    angle = np.linalg.norm(vector)
    return np.concatenate([[np.cos(angle / 2)], 0.5 * np.sinc(angle / (2 * np.pi)) * vector])


def simulated(truth: Truth) -> list[Any]:
    """Return the range, range rate and directions that the spacecraft would give of the truth, with errors."""
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
        for body, positions in (("Dimorphos", PLACES * shape), ("Didymos", np.zeros((1, 3)))):
            lines = Landmarks.directions(images, body, name, positions)
            outward = np.einsum("kij,lj->kli", rotations.matrices(images.attitude[:, system.index(body)]), positions)
            seen = np.einsum("klx,klx->kl", outward, lines) <= 0.0
            lines = lines + rng.normal(0.0, PIXEL, lines.shape)
            lines /= np.linalg.norm(lines, axis=2)[..., None]
            data.append(Landmarks(times, positions, body, name, lines, seen, PIXEL))
    return data


def fitted(truth: Truth, progress: Any = False) -> Any:
    """Fit the simulated data, from a start that a preliminary fit of the same data would have, some errors off."""
    rng = np.random.default_rng([SEED, 1])
    setup, values = survey(truth)
    off = {"big": 1e-4 * truth.big, "small": 0.01 * truth.small, "polar": 0.5, "a_b": 1e-3, "b_c": 3e-3}
    kinds = {"place": 3e-4, "speed": 1e-5, "turn": 1e-3, "spin": 1e-5}
    start = {}
    for name, value in values.items():
        size = off[name] if name in off else next(kinds[kind] for kind in (*name.split("_"), name) if kind in kinds)
        start[name] = fullbody.fitting.Free(value + rng.normal(0.0, size), prior=(value, 1e3 * size))
    return fullbody.fit(setup, start, simulated(truth), integrator=Verner98(1e-9, 1e-9), progress=progress)
