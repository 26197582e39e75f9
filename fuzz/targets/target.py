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
def package_errors_only() -> Iterator[None]:
    """Suppress the errors of the package, and turn the warnings of other packages into errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The warnings of the package are of this class; those of numpy about invalid numbers are not.
        warnings.simplefilter("ignore", UserWarning)
        with contextlib.suppress(fullbody.FullbodyError):
            yield


class Content(bytes):
    """The content of a file, which hypothesis prints as its length and not completely."""

    def __repr__(self) -> str:
        return f"<{len(self)} bytes>"


def file_target(name: str, suffix: str, inputs: SearchStrategy[bytes], read: Callable[[Path], Any]) -> Target:
    """Return a target for files; ``read`` opens a file and checks its content. Errors have to name the file."""

    def checked(content: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"input{suffix}")
            path.write_bytes(content)
            with package_errors_only():
                try:
                    read(path)
                except fullbody.FullbodyError as error:
                    if str(path) not in str(error):
                        raise AssertionError(f"the error does not name the file: {error}") from error

    return Target(name, inputs.map(Content), checked, suffix)


def check_finite(*values: Any) -> None:
    """Refuse numbers that are not finite."""
    for value in values:
        array = np.asarray(getattr(value, "value", value), dtype=float)
        assert np.isfinite(array).all(), f"{value} is not finite"


def check_object(value: Any) -> None:
    """Refuse an object without text, or that differs from itself or from its copy by pickle."""
    assert repr(value)
    assert value == value
    assert pickle.loads(pickle.dumps(value)) == value


def check_start(system: fullbody.System, state: fullbody.State) -> None:
    """Refuse an invalid system or state; the package raises an error if they do not fit each other."""
    check_finite(system.masses, system.G)
    check_state(state)
    check_object(system)
    with package_errors_only():
        check_finite(*_parts(system.interactions(state)))
        sim = fullbody.Simulation(system, state)
        check_finite(sim.time, system.energy(state).total, system.angular_momentum(state))


def check_state(state: fullbody.State) -> None:
    """Refuse an invalid state."""
    check_finite(state.position, state.velocity, state.spin, state.time, state.rotation_matrix, state.tait_bryan)
    assert np.abs(np.linalg.norm(state.attitude, axis=-1) - 1.0).max(initial=0.0) < 1e-6
    check_object(state)


def _parts(interactions: fullbody.model.Interactions) -> tuple[Any, ...]:
    return interactions.force, interactions.torque, interactions.potential_energy
