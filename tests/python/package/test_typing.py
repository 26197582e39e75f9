"""Types for mypy and editors: a user's script under ``mypy --strict``, and the names that are offered."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import fullbody
import jedi
import numpy as np
from fullbody import typing as fullbody_typing

ROOT = Path(__file__).parents[3]

#: A script of a user, with the type of what is computed or, after an exclamation mark, the mistake that mypy finds.
SCRIPT = """
import fullbody
import numpy as np
import numpy.typing as npt
from fullbody.typing import Array, Scalar

system, state = fullbody.systems.kw4(units=True)
run = system.integrate(state, 10.0, output=1.0, dense=True)
elements = run.elements()
plain: npt.NDArray[np.float64] = run.position
number: float = system.mu()
reveal_type(run.position)                                       # Array
reveal_type(run.time)                                           # Array
reveal_type(run.velocity[:, 1] - run.velocity[:, 0])            # Array
reveal_type(run.position.to("m"))                               # Array
reveal_type(run.energy.value)                                   # ndarray
reveal_type(run.attitude)                                       # ndarray
reveal_type(elements.e)                                         # Array
reveal_type(np.degrees(elements.i))                             # ndarray
reveal_type(elements[0].a)                                      # Any
reveal_type(run[-1])                                            # State
reveal_type(run[::2])                                           # Run
reveal_type(run["Beta"])                                        # Track
reveal_type(run["Beta"].rotation_matrix)                        # ndarray
reveal_type(run(3.5))                                           # State
reveal_type(run(np.array([1.0, 2.0])).spin)                     # Array
reveal_type(state.position)                                     # Array
reveal_type(state.time)                                         # Scalar
reveal_type(system.interactions(state).force)                   # Array
reveal_type(system.interactions(state).torque[0])               # Any
reveal_type(system.energy(state).total)                         # Scalar
reveal_type(system.angular_momentum(state))                     # Array
reveal_type(2 * system.mu())                                    # Scalar
reveal_type(system.mu() * run.position)                         # Array
reveal_type(system.masses)                                      # Array
reveal_type(system["Alpha"])                                    # Body
reveal_type(fullbody.KeplerElements(2.5, 0.1, 0.0, 0.0, 0.0, 0.0).a)    # Scalar
reveal_type(elements.to_frame(target="ecliptic").Omega)                # Array
reveal_type(fullbody.observables.mutual_period(run).mean)       # Scalar
reveal_type(fullbody.observables.obliquity(run))                # Array
reveal_type(run.plot.orbit())                                   # Axes
reveal_type(run.plot())                                         # Page
reveal_type(run.plot.elements())                                # ndarray
reveal_type(run.to_xarray())                                    # Dataset
reveal_type(fullbody.__version__)                               # str
mean = fullbody.analysis.averaged(system, "Alpha")
equilibrium = fullbody.analysis.relative_equilibrium(mean, separation=2.5)
reveal_type(mean)                                               # System
reveal_type(fullbody.analysis.periodic_orbit(mean, state, "17.4 hour"))  # PeriodicOrbit
reveal_type(equilibrium.modes.plot())                           # ndarray
reveal_type(run.transition)                                     # ndarray
reveal_type(run.sensitivity["G"])                               # ndarray
text: bytes = fullbody.observables.fate(run).kind               # !Incompatible types in assignment
more: bytes = fullbody.observables.drift(run).energy            # !Incompatible types in assignment
units: bytes = run.tangent_units                                # !Incompatible types in assignment
run.position.tu("m")                                            # !"Array" has no attribute "tu"
system.integrate(state, 10.0, rtol=1e-9)                        # !Unexpected keyword argument "rtol"
fullbody.Body(3.0, mass=1.0)                                    # !incompatible type "float"
fullbody.elements_of(run)                                       # !Module has no attribute "elements_of"


def separation(run: fullbody.Run) -> Array:
    return run["Beta"].position - run["Alpha"].position


def twice(value: Scalar, elements: fullbody.KeplerElements) -> Scalar:
    return value * 2
"""


def test_a_users_script_passes_mypy(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    # The types of libraries behind those that the script meets take as long as all others.
    behind = "pandas.*,dask.*,distributed.*,IPython.*,PIL.*"
    (tmp_path / "mypy.ini").write_text(f"[mypy]\nstrict = True\n[mypy-{behind}]\nfollow_imports = skip\n")
    command = [sys.executable, "-m", "mypy", "--no-color-output", "--no-error-summary", "--config-file=mypy.ini"]
    # A cache that stays saves the second time.
    command += [f"--cache-dir={ROOT / '.mypy_cache' / 'script'}", "script.py"]
    message = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False).stdout
    # Notes on other files say where a function is defined. Of an error and notes on it the error comes first.
    lines = [line.removeprefix("script.py:") for line in message.splitlines() if line.startswith("script.py:")]
    result = dict(line.split(": ", 1) for line in reversed(lines))
    expected = {k: line.partition("  # ")[2] for k, line in enumerate(SCRIPT.splitlines(), start=1) if "  # " in line}
    for line, text in expected.items():
        answer = result.pop(str(line))
        if text.startswith("!"):
            assert answer.startswith("error: ")
            assert text[1:] in answer
        else:
            kind = answer.removeprefix('note: Revealed type is "').rstrip('"').partition("[")[0]
            assert kind.rpartition(".")[2] == text, answer
    assert result == {}


def test_types_in_annotations_are_those_of_numpy_and_python():
    assert (fullbody_typing.Array, fullbody_typing.Scalar) == (np.ndarray, float)


def test_completion_offers_public_names_alone():
    assert dir(fullbody) == sorted(fullbody.__all__)
    assert sum(not inspect.ismodule(getattr(fullbody, name)) for name in fullbody.__all__) <= 45
    offered = {completion.name for completion in jedi.Interpreter("fullbody.", [{"fullbody": fullbody}]).complete()}
    assert {name for name in offered if not name.startswith("__")} == set(fullbody.__all__) - {"__version__"}


def test_names_bound_in_the_package_are_public():
    tree = ast.parse((ROOT / "python/fullbody/__init__.py").read_text())
    bound = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            bound |= {(name.asname or name.name).partition(".")[0] for name in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            bound.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            bound.add(node.id)
    local = {"_MODULES", "_typing", "__all__", "__dir__", "__getattr__", "import_module", "version"}
    assert bound - local == set(fullbody.__all__)
    assert not hasattr(fullbody, "_typing")
