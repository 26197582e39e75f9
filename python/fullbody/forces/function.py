"""Forces from a user's function in Python or compiled."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np

import fullbody._core as _core

from ..base.kinds import flag, of_kind
from ..base.units import Units
from ..base.values import UnstoredFunction
from ..errors import InvalidInput
from ..model.context import Call, Context
from ..model.force import Force
from ..model.state import wrap

_POINTER = ctypes.POINTER(ctypes.c_double)
#: The status of success of a Python function's wrapper: one that ctypes does not make up after an early Ctrl-C.
_SUCCESS = 0x5AFEC0DE
#: The base class of all function pointers of ctypes.
_FUNCTION_POINTER: Any = ctypes.CFUNCTYPE(None).__mro__[1]
#: The arguments: time, bodies, position, velocity, attitude, spin, force, torque, data; a result of zero is success.
SIGNATURE = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_double, ctypes.c_int64, *[_POINTER] * 4, *[_POINTER] * 2, ctypes.c_void_p
)


@dataclass(frozen=True, eq=False, repr=False)
class Function(Force):
    """A user's force: a function in Python, or a compiled one.

    A Python function is called with a time and a :class:`fullbody.State` at every evaluation. A call takes some tens of
    microseconds, so that a run takes twenty times as long. The function returns the forces (N, 3) in the inertial
    frame, or these and the torques (N, 3) in the body frames.

    A compiled function runs without the interpreter. It is given as a ``numba.cfunc``, a ``scipy.LowLevelCallable`` or
    a ``ctypes`` function pointer with the signature ::

        int f(double time, int64_t bodies, const double *position, const double *velocity, const double *attitude,
              const double *spin, double *force, double *torque, void *data)

    in the system's units. Arrays have shape (bodies, 3), the attitudes (bodies, 4); force and torque are zero on entry.
    A result other than zero ends the run. The data are those of the LowLevelCallable, and may be used from another
    thread.

    The function should be smooth: at a jump the step control takes many short steps. It must not depend on anything
    that it stores from call to call, since steps are tried and taken back.

    Parameters
    ----------
    function : callable, numba cfunc, LowLevelCallable or ctypes function
    depends_on_velocity : bool
        ``False`` states that the force depends only on the time, the positions and the attitudes, which integrators
        with fixed steps require.
    name : str, optional
        Name of the force; by default the function's own name.

    Raises
    ------
    ForceFailed
        In a run, if the function raises an exception, returns nan or a status other than zero. The run so far is in the
        error's attribute ``run``, and the function's exception is its cause.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> system, state = fullbody.systems.case1()
    >>> def drag(time, state):
    ...     return -1e-4 * state.velocity
    >>> run = system.with_forces([fullbody.forces.Function(drag)]).integrate(state, 10.0)
    >>> bool(run.work["drag"][-1] < 0.0)
    True
    """

    function: Any
    depends_on_velocity: bool = field(default=True, kw_only=True, metadata=of_kind(flag))  # type: ignore[misc]

    conserves_energy: ClassVar[bool] = False

    def _check(self) -> None:
        if not callable(self.function) and _compiled(self.function, self.name) is None:
            raise InvalidInput(
                f"function of {self.name} is {self.function!r}; expected a function of (time, state), a numba cfunc, a "
                "scipy.LowLevelCallable or a ctypes function"
            )

    def _usual_name(self) -> str:
        name = getattr(self.function, "__name__", None) or getattr(self.function, "name", None)
        return str(name or "function").strip("<>")

    def _describe(self, context: Context) -> dict[str, Any]:
        return {"kind": "Function", "name": self.name, "depends_on_velocity": self.depends_on_velocity}

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        kind = "of Python" if _compiled(self.function, self.name) is None else "compiled"
        return f"a function {kind}" + (" that depends on velocities" if self.depends_on_velocity else "")

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        name = described["name"]
        unstored = UnstoredFunction(name, "give it again: system.with_forces([Function(...), ...])")
        return cls(unstored, depends_on_velocity=described["depends_on_velocity"], name=name)

    def _call(self, context: Context) -> Call:
        compiled = _compiled(self.function, self.name)
        return _from_python(self, context) if compiled is None else compiled


def _compiled(function: Any, name: str) -> Call | None:
    """Return the addresses of a compiled function, or ``None`` for a Python function."""
    if isinstance(function, _FUNCTION_POINTER):
        return Call(_address(function, name), 0, function)
    if hasattr(function, "_wrapper_address") and isinstance(getattr(function, "address", None), int):
        return Call(function.address, 0, function)
    if type(function).__name__ != "LowLevelCallable":
        return None
    pointer, data = function.function, function.user_data
    if (address := getattr(pointer, "address", None)) is None:
        address = _address(pointer if isinstance(pointer, _FUNCTION_POINTER) else function[0], name)
    return Call(address, 0 if data is None else _address(data, name), function)


def _address(pointer: Any, name: str) -> int:
    """Return the address in a pointer of ctypes or a capsule."""
    if isinstance(pointer, (ctypes.c_void_p, ctypes._Pointer, _FUNCTION_POINTER)):
        return ctypes.cast(pointer, ctypes.c_void_p).value or 0
    api = ctypes.pythonapi
    api.PyCapsule_GetName.restype, api.PyCapsule_GetName.argtypes = ctypes.c_char_p, [ctypes.py_object]
    api.PyCapsule_GetPointer.restype = ctypes.c_void_p
    api.PyCapsule_GetPointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    try:
        return int(api.PyCapsule_GetPointer(pointer, api.PyCapsule_GetName(pointer)))
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"function of {name} has {pointer!r}; expected a capsule with a pointer") from error


def _from_python(model: Function, context: Context) -> Call:
    """Return a C callback through which the core calls a Python function."""
    name, units, bodies = model.name, context.units, len(context.bodies)

    def as_array(pointer: Any, width: int = 3) -> Any:
        return np.ctypeslib.as_array(pointer, (bodies, width))

    def loads(value: Any, dimension: str) -> Any:
        array = units.strip(value, dimension, f"{dimension} of {name}")
        if array.shape != (bodies, 3):
            raise InvalidInput(f"{dimension} of {name} has shape {array.shape}; expected {(bodies, 3)}")
        return array

    def call(
        time: float, _: int, position: Any, velocity: Any, attitude: Any, spin: Any, force: Any, torque: Any, data: Any
    ) -> int:
        try:
            if model.depends_on_velocity:
                core = _core.State(time, as_array(position), as_array(velocity), as_array(attitude, 4), as_array(spin))
            else:
                core = _core.State.from_poses(time, as_array(position), as_array(attitude, 4))
            state = wrap(core, context)
            answer = model.function(state.time, state)
            if isinstance(answer, tuple) and len(answer) != 2:
                raise InvalidInput(f"{name} returns {len(answer)} values; expected forces, or (forces, torques)")
            forces, torques = answer if isinstance(answer, tuple) else (answer, None)
            as_array(force)[:] = loads(forces, "force")
            if torques is not None:
                as_array(torque)[:] = loads(torques, "torque")
        except BaseException as error:
            return callback.store(error)
        return _SUCCESS

    pointer = SIGNATURE(call)
    callback = Call(_address(pointer, name), 0, pointer, _SUCCESS)
    return callback
