"""A target of fuzzing: a function that takes external input, and the checks of what it returns."""

from __future__ import annotations

import contextlib
import pickle
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fullbody
import numpy as np
from hypothesis.strategies import SearchStrategy

CORPUS = Path(__file__).parents[1] / "corpus"


@dataclass(frozen=True)
class Target:
    """A function of the package that takes external input.

    Attributes
    ----------
    name : str
    inputs : SearchStrategy
        The strategy that makes inputs.
    check : callable
        A function that passes an input to the package, and raises an error unless the package returns a valid object
        or raises an error of its own.
    suffix : str
        The suffix of the names of files with such input; empty if the input is no file.
    """

    name: str
    inputs: SearchStrategy[Any]
    check: Callable[[Any], None]
    suffix: str = ""

    def corpus(self) -> list[Path]:
        """Return files that once led to a fault."""
        return sorted((CORPUS / self.name).glob(f"*{self.suffix}")) if self.suffix else []


@contextlib.contextmanager
def refusing() -> Iterator[None]:
    """Refuse all errors and warnings but the package's own."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The package's are of this kind, numpy's about numbers that are none are not.
        warnings.simplefilter("ignore", UserWarning)
        with contextlib.suppress(fullbody.FullbodyError):
            yield


class Content(bytes):
    """What is in a file; told by its length, where hypothesis would print all of it."""

    def __repr__(self) -> str:
        return f"<{len(self)} bytes>"


def file_target(name: str, suffix: str, inputs: SearchStrategy[bytes], read: Callable[[Path], Any]) -> Target:
    """Return a target for files; ``read`` opens one and checks what is in it. Errors have to name the file."""

    def enter(content: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"input{suffix}")
            path.write_bytes(content)
            with refusing():
                try:
                    read(path)
                except fullbody.FullbodyError as error:
                    if str(path) not in str(error):
                        raise AssertionError(f"the error does not name the file: {error}") from error

    return Target(name, inputs.map(Content), enter, suffix)


def check_finite(*values: Any) -> None:
    """Refuse numbers that are none."""
    for value in values:
        array = np.asarray(getattr(value, "value", value), dtype=float)
        assert np.isfinite(array).all(), f"{value} is not finite"


def check_object(value: Any) -> None:
    """Refuse what has no text, is not equal to itself, or does not survive a pickle."""
    assert repr(value)
    assert value == value
    assert pickle.loads(pickle.dumps(value)) == value


def check_start(system: fullbody.System, state: fullbody.State) -> None:
    """Refuse a system and a state that are not right; that they do not fit each other is an error of the package."""
    check_finite(system.masses, system.G)
    check_state(state)
    check_object(system)
    with refusing():
        check_finite(*_parts(system.interactions(state)))
        sim = fullbody.Simulation(system, state)
        check_finite(sim.time, system.energy(state).total, system.angular_momentum(state))


def check_state(state: fullbody.State) -> None:
    """Refuse a state that is not right."""
    check_finite(state.position, state.velocity, state.spin, state.time, state.rotation_matrix, state.tait_bryan)
    assert np.abs(np.linalg.norm(state.attitude, axis=-1) - 1.0).max(initial=0.0) < 1e-6
    check_object(state)


def _parts(interactions: fullbody.model.Interactions) -> tuple[Any, ...]:
    return interactions.force, interactions.torque, interactions.potential_energy
