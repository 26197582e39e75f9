"""A notebook's sliders for the parameters of a setup, whose run is integrated again while they move."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.kinds import function, instance, whole_number
from ..base.units import UNITLESS, is_quantity, need, numbers, strip_to
from ..errors import FullbodyError, InvalidInput
from ..model.state import State
from ..observables.spin import obliquity, roll_pitch_yaw
from ..plots._style import unit
from ..record.record import Record
from ..record.times import end_of_run
from .page import View
from .scene import pack, scene_data

if TYPE_CHECKING:
    from ..observing.geometry import Geometry

Curve = Callable[[Record], Any]
#: The largest number of samples, which a browser still draws at once.
_MAX_SAMPLES = 200_000


def _separation(run: Any, body: Any, about: Any, _: Any) -> Any:
    return np.linalg.norm(np.diff(run.arrays["position"][:, run.context.pair(body, about)], axis=1)[:, 0], axis=1)


def _element(name: str) -> Any:
    return lambda run, body, about, _: getattr(run.elements(body=body, about=about), name)


def _angle(axis: int) -> Any:
    return lambda run, body, about, _: roll_pitch_yaw(run, body=body, about=about)[:, axis]


def _light(run: Any, _body: Any, _about: Any, geometry: Geometry | None) -> Any:
    if geometry is None:
        raise InvalidInput("geometry is None; expected a Geometry for the light curve")
    from ..observing import light_curve

    return light_curve(run, run.time, geometry)


#: The curves by their names: the dimension, and a function of (run, body, about, geometry) that returns values (K,).
CURVES: dict[str, tuple[str, Callable[..., Any]]] = {
    "separation": ("length", _separation),
    "semi-major axis": ("length", _element("a")),
    "eccentricity": ("", _element("e")),
    "inclination": ("angle", _element("i")),
    "roll": ("angle", _angle(0)),
    "pitch": ("angle", _angle(1)),
    "libration": ("angle", _angle(2)),
    "obliquity": ("angle", lambda run, body, about, _: obliquity(run, body=body, about=about)),
    "energy drift": ("", lambda run, *_: run.energy_drift_orbital),
    "light curve": ("magnitude", _light),
}


class Explorer:
    """Sliders for the parameters of a setup, with the scene and the curves of its run; see :func:`fullbody.explore`.

    Jupyter shows it as a widget. A notebook that is read without a kernel shows the scene of the first run.

    Attributes
    ----------
    run : Run
        The run that is shown.
    """

    def __init__(
        self,
        setup: Callable[..., Any],
        parameters: dict[str, Any],
        until: Any,
        duration: Any,
        show: Iterable[str | Curve],
        samples: int,
        integrator: Any,
        geometry: Geometry | None,
        pair: tuple[int | str, int | str],
    ) -> None:
        with need("explore", "fullbody.explore"):
            import anywidget
        whole_number(samples, "samples", 2, _MAX_SAMPLES)
        function(setup, "setup", "a function of the parameters")
        instance(parameters, "parameters", Mapping, "a dict of ranges by name")
        if isinstance(show, str) or not isinstance(show, Iterable):
            raise InvalidInput(f"show is {show!r}; expected a list of curves")
        self._setup, self._until, self._duration = setup, until, duration
        self._samples, self._integrator, self._geometry = samples, integrator, geometry
        self._pair = pair
        self._controls = {name: _control(name, span, setup) for name, span in parameters.items()}
        self._show = [(_curve_name(curve), curve) for curve in show]
        self.run: Any = None
        # An error of the first run is raised in the cell that makes the explorer.
        self._result({name: control["value"] for name, control in self._controls.items()})
        files = resources.files(__package__)
        page = {
            attribute: "".join(files.joinpath(name).read_text(encoding="utf-8") for name in names)
            for attribute, names in _FILES.items()
        }
        self._widget = type("ExplorerWidget", (anywidget.AnyWidget,), page)()
        self._widget.on_msg(self._answer)

    @property
    def values(self) -> dict[str, Any]:
        """The values of the parameters in the run that is shown, with their units."""
        return dict(self._values)

    def _with_units(self, numbers: dict[str, float]) -> dict[str, Any]:
        return {name: numbers[name] * control["factor"] for name, control in self._controls.items()}

    def _result(self, numbers: dict[str, float]) -> dict[str, Any]:
        """Integrate the setup at the sliders' numbers, keep run and values, and return what explorer.js shows."""
        values = self._with_units(numbers)
        result = self._setup(**values)
        if not (isinstance(result, tuple | list) and len(result) == 2 and isinstance(result[1], State)):
            raise InvalidInput(f"the setup gives {result!r:.200}; expected (system, state)")
        system, state = result
        units = system.context.units
        start = units.number(state.time, "time", "time")
        times = np.linspace(start, end_of_run(self._until, self._duration, start, units), self._samples)
        notice = ""
        end, output = (units.attach(value, "time") for value in (times[-1], times))
        try:
            run = system.integrate(state, end, output=output, integrator=self._integrator)
        except FullbodyError as error:
            run, notice = error.run, str(error)
            if run is None or len(run) < 2:
                raise
        curves = [self._curve(name, curve, run) for name, curve in self._show]
        scene = scene_data(run, flight=None, samples=self._samples, geometry=self._geometry)
        self.run, self._values = run, values
        packed = pack(run.arrays["time"], "<f8")
        return {"scene": scene, "curves": curves, "time": packed, "unit": unit(run, "time"), "notice": notice}

    def _curve(self, name: str, curve: str | Curve, run: Any) -> dict[str, Any]:
        dimension = ""
        if callable(curve):
            values = curve(run)
        else:
            dimension, function = CURVES[curve]
            values = function(run, *self._pair, self._geometry)
        text = unit(run, dimension) if dimension == "length" else "mag" if dimension == "magnitude" else ""
        if is_quantity(values):
            values, text = values.value, text or str(values.unit)
        values = numbers(values, f"the curve {name}")
        if values.shape != (len(run),):
            expected = f"expected ({len(run)},), a number for each sample"
            raise InvalidInput(f"the curve {name} has shape {values.shape}; {expected}")
        if dimension == "angle":
            values, text = np.degrees(values), "deg"
        return {"label": name, "unit": text, "values": pack(values, "<f8"), "inverted": dimension == "magnitude"}

    def _answer(self, widget: Any, message: dict[str, Any], _buffers: Any) -> None:
        """Answer a message of the page with the controls, the run for values, or its lines of Python."""
        answer: dict[str, Any] = {"id": message["id"]}
        try:
            if message["ask"] == "start":
                controls = [{**control, "label": control["name"]} for control in self._controls.values()]
                answer["controls"] = [{k: v for k, v in control.items() if k != "factor"} for control in controls]
            elif message["ask"] == "code":
                answer |= {"code": self.code(message["values"])}
            else:
                answer |= {"result": self._result(message["values"])}
        except Exception as error:  # the setup is the user's, and any error of it is shown beside the slider
            answer |= {"error": str(error) or type(error).__name__}
        widget.send(answer)

    def code(self, numbers: dict[str, float] | None = None) -> str:
        """Return lines of Python that make a run again.

        Parameters
        ----------
        numbers : dict of str to float, optional
            The numbers of the sliders, in the units of their ranges; by default those of the run that is shown.

        Returns
        -------
        str
        """
        values = self._values if numbers is None else self._with_units(numbers)
        arguments = ", ".join(f"{name!r}: {_literal(value)}" for name, value in values.items())
        end = f"{_literal(self._until)}" if self._duration is None else f"duration={_literal(self._duration)}"
        name = getattr(self._setup, "__name__", "setup")
        quantities = any(is_quantity(value) for value in (*values.values(), self._until, self._duration))
        lines = f"system, state = {name}(**{{{arguments}}})\nrun = system.integrate(state, {end})\n"
        return ("from astropy import units as u\n\n" if quantities else "") + lines

    def _repr_mimebundle_(self, **options: Any) -> Any:
        bundle = self._widget._repr_mimebundle_(**options)
        data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
        page = View(self.run, samples=self._samples, geometry=self._geometry)
        return {**data, "text/plain": repr(self), "text/html": page.framed()}, metadata

    def __repr__(self) -> str:
        names = ", ".join(self._controls)
        return f"<explorer of {names}; shown in Jupyter>"


#: The files of the widget by the attributes that hold their text.
_FILES = {"_esm": ("viewer.js", "explorer.js", "widget.js"), "_css": ("viewer.css", "explorer.css")}


def _curve_name(curve: Any) -> str:
    """Return the name of a curve after checking that there is one of this name."""
    if callable(curve):
        return getattr(curve, "__name__", type(curve).__name__)
    if curve not in list(CURVES):
        raise InvalidInput(f"show has {curve!r}; expected a function of a run, or one of {', '.join(CURVES)}")
    return str(curve)


def _control(name: str, span: Any, setup: Callable[..., Any]) -> dict[str, Any]:
    """Return the description of a slider: its numbers, and the factor by which they become the setup's argument."""
    message = f"the range of {name} is {span!r}; expected (lowest, highest) or (lowest, highest, start)"
    try:
        low, high, *start = span
    except (TypeError, ValueError):
        raise InvalidInput(message) from None
    factor: Any = 1.0
    limits = (low, high, *start)
    if any(map(is_quantity, limits)):
        if not all(map(is_quantity, limits)):
            raise InvalidInput(f"{message}, all with units or none")
        factor = 1.0 * low.unit
        limits = tuple(strip_to(value, low.unit, f"the range of {name}") for value in limits)
    low, high, *start = (UNITLESS.number(value, "number", f"the range of {name}") for value in limits)
    if len(start) > 1 or not low < high or not all(low <= value <= high for value in start):
        raise InvalidInput(f"{message}, in order")
    if not start:
        default = inspect.signature(setup).parameters.get(name)
        value: Any = None if default is None or default.default is inspect.Parameter.empty else default.default
        if is_quantity(value) and is_quantity(factor):
            value = float(strip_to(value, factor.unit, f"the default of {name}"))
        inside = isinstance(value, int | float | np.floating) and low <= value <= high
        start = [float(value) if inside else 0.5 * low + 0.5 * high]
    text = str(factor.unit) if is_quantity(factor) else ""
    return {"name": name, "min": low, "max": high, "value": start[0], "unit": text, "factor": factor}


def _literal(value: Any) -> str:
    """Return a number or Quantity as Python source."""
    if not is_quantity(value):
        return repr(float(value)) if isinstance(value, np.floating) else repr(value)
    return f"{value.value!r} * u.Unit({str(value.unit)!r})".replace("np.float64(", "(")


def explore(
    setup: Callable[..., Any],
    parameters: dict[str, Any],
    until: Any = None,
    *,
    duration: Any = None,
    show: Iterable[str | Curve] = ("separation", "eccentricity", "libration"),
    samples: int = 1000,
    integrator: Any = None,
    geometry: Geometry | None = None,
    body: int | str = 1,
    about: int | str = 0,
) -> Explorer:
    """Show sliders for the parameters of a setup, whose run, scene and curves are computed again while they move.

    Parameters
    ----------
    setup : callable
        ``setup(**parameters)`` returns ``(system, state)``, as for :func:`fullbody.sweep`.
    parameters : dict of str to (lowest, highest) or (lowest, highest, start)
        The range of each slider, plain numbers or Quantities. It starts at ``start``, at the setup's own default if
        that is in the range, or in the middle.
    until, duration : float or Quantity
        The end of the run, or its length; exactly one of them.
    show : iterable of str or callable
        The curves: ``"separation"``, ``"semi-major axis"``, ``"eccentricity"``, ``"inclination"``, ``"roll"``,
        ``"pitch"``, ``"libration"`` (the yaw of ``body`` in the frame of its orbit), ``"obliquity"``,
        ``"energy drift"``, ``"light curve"``, or functions of a run that return (K,) numbers.
    samples : int
        The number of samples of the run, which scene and curves show.
    integrator : Integrator, optional
        The integrator of the runs, by default that of :meth:`fullbody.System.integrate`.
    geometry : fullbody.observing.Geometry, optional
        The geometry whose Sun lights the scene, with shadows, and whose observer sees the ``"light curve"``.
    body, about : int or str
        The pair whose orbit and libration are shown.

    Returns
    -------
    Explorer
        The explorer, which Jupyter shows. ``.run`` and ``.values`` are the run that is shown and the values of its
        parameters, ``.code()`` are lines of Python that make it again.

    Raises
    ------
    FullbodyError
        If the first run fails. Later errors are shown beside the slider, and the last good run stays.

    Examples
    --------
    >>> import fullbody
    >>> explorer = fullbody.explore(fullbody.systems.didymos_after_dart, {"tilt": (0, 0.1)}, duration=100.0)
    >>> explorer.values
    {'tilt': 0.0}
    """
    return Explorer(setup, parameters, until, duration, show, samples, integrator, geometry, (body, about))
