"""Reading of light curves, shapes and spins of DAMIT, the database of asteroid models from inversion techniques."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.arguments import refuse_unknown
from ..base.epochs import date
from ..base.kinds import choice
from ..base.unit_names import unit_named
from ..base.units import Units, is_quantity, need
from ..errors import InvalidInput, caution
from ..files.text import POSITIVE, Text, naming
from ..model.bodies import Body
from ..model.polyhedron import Polyhedron
from ..model.state import State
from ..typing import Floats
from .geometry import Geometry
from .laws import LinearExponential, LommelSeeligerLambert
from .photometry import Photometry
from .scatter import Curve, refuse_options, standard_errors

_POINT = "JD, intensity, and the vectors to the Sun and to the Earth, 8 numbers"
_SCALES = ("tdb", "tt", "utc", "tai")
#: The angle in radians between the spin and the principal axis above which a warning is given.
_TILT_LIMIT = 1e-3


class _LightCurve(NamedTuple):
    """A light curve of a file: its name, whether it is calibrated, and its rows (K, 8)."""

    name: str
    calibrated: bool
    rows: Floats


def read_damit(path: Any, *, sigma: Any = None, scale: str = "tdb", **options: Any) -> list[Photometry]:
    """Read the light curves of an asteroid in a file of DAMIT: ``lc.txt`` or its JSON.

    Parameters
    ----------
    path : str or Path
        A text file has the number of curves; for each curve a line with the number of points and 1 for calibrated or 0
        for relative; and lines with JD, intensity, and the vectors in au from the asteroid to the Sun and to the Earth
        in the ecliptic of J2000. A file with the suffix ``.json`` has a list of objects with ``id``, ``scale`` and
        ``points``.
    sigma : float, Quantity or array_like, () or (C,), or "estimate"
        Standard errors in magnitudes, which the files do not have: one number, or one for each of the C curves.
        Otherwise they are estimated from the scatter of each curve about cubics through neighbouring points, with a
        warning unless ``sigma`` is ``"estimate"``.
    scale : {"tdb", "tt", "utc", "tai"}
        The time scale of the JD, which the files do not say; their vectors from Earth to Sun are those of JD in TDB.
    **options
        Options of :class:`Photometry` other than ``geometry``, ``zero``, ``night``, ``filter`` and ``reduced``.

    Returns
    -------
    list of Photometry
        The curves in the order of the file, with the geometry of the file. Times are those at the asteroid, light time
        subtracted. The intensities become magnitudes reduced to unit distances. A relative curve has a zero point of
        its own, which is its factor; all calibrated curves share one, named ``calibrated``.

    Raises
    ------
    InvalidInput
        For content of another form, where the message names the line.

    Warns
    -----
    InconsistentInput
        If errors are estimated.

    Notes
    -----
    The system needs units, an epoch and a frame. The Earth of the files is where it was when the light left the
    asteroid, a difference of 1e-4 au.

    References
    ----------
    Durech, Sidorin & Kaasalainen 2010, Astron. Astrophys. 513, A46.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from fullbody import observing
    >>> rows = [f"{jd} {light} -0.32 -2.57 -0.10 -0.00 -1.63 -0.10" for jd, light in ((3845.85, 1.06), (3845.87, 1.03))]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "lc.txt")
    ...     _ = path.write_text(chr(10).join(["1", "2 0", *rows]))
    ...     curves = observing.read_damit(path, sigma=0.02)
    >>> curves[0].magnitude.round(3), curves[0].nights
    (array([-0.063, -0.032]), array(['curve 1'], dtype='<U7'))
    """
    refuse_options(options, "read_damit")
    choice(scale, "scale", _SCALES)
    text = Text(path)
    is_json = str(path).lower().endswith(".json")
    light_curves = list(_json_curves(text) if is_json else _text_curves(text))
    if not light_curves:
        text.fail(None, "the file has no light curves; expected one or more")
    magnitudes = [-2.5 * np.log10(light_curve.rows[:, 1]) for light_curve in light_curves]
    errors = standard_errors(
        sigma, [Curve(c.name, c.rows[:, 0], m) for c, m in zip(light_curves, magnitudes, strict=True)], path
    )
    return [
        _photometry(light_curve, magnitude, error, scale, options)
        for light_curve, magnitude, error in zip(light_curves, magnitudes, errors, strict=True)
    ]


def _photometry(
    light_curve: _LightCurve, magnitude: Floats, sigma: float, scale: str, options: dict[str, Any]
) -> Photometry:
    with need("observing", "dates of light curves"):
        import astropy.units as u
        from astropy.time import Time

    times = Time(light_curve.rows[:, 0], format="jd", scale=scale)
    first = np.unique(light_curve.rows[:, 0], return_index=True)[1]
    sun, earth = light_curve.rows[first, 2:5] * u.au, light_curve.rows[first, 5:8] * u.au
    geometry = Geometry(times[first], to_observer=earth, to_sun=sun, frame="ecliptic", light_time=False)
    filters = np.full(len(times), "calibrated") if light_curve.calibrated else None
    night = np.full(len(times), light_curve.name)
    return Photometry(times, magnitude, sigma, geometry=geometry, night=night, filter=filters, **options)


def _text_curves(text: Text) -> Iterator[_LightCurve]:
    rows = text.words()
    line, words = text.expected(rows, 0, (1,), "the number of light curves")
    first = 1
    for k in range(1, 1 + text.whole_number(line, words[0], "the number of light curves")):
        line, words = text.expected(rows, first, (2,), f"the number of points of curve {k}, and 0 or 1")
        last = first + text.whole_number(line, words[0], "the number of points", 1)
        if words[1] not in ("0", "1"):
            text.fail(line, f"the scale is {words[1]!r}; expected 0 for relative or 1 for calibrated")
        points = [_point(text, *text.expected(rows, j, (8,), _POINT)) for j in range(first + 1, last + 1)]
        yield _LightCurve(f"curve {k}", words[1] == "1", np.array(points))
        first = last + 1
    _refuse_more(text, rows, first, "the last of the light curves")


def _refuse_more(text: Text, rows: list[tuple[int, list[str]]], count: int, last: str) -> None:
    """Raise an error for a file with more than a number of lines."""
    if len(rows) > count:
        text.fail(rows[count][0], f"the line is after {last}; expected the end of the file")


def _json_curves(text: Text) -> Iterator[_LightCurve]:
    try:
        content = json.loads("\n".join(text.lines))
    except json.JSONDecodeError as error:
        text.fail(error.lineno, f"{error.msg}; expected JSON")
    except ValueError:
        text.fail(None, "the content has a whole number of thousands of digits; expected numbers of ordinary size")
    except RecursionError:
        text.fail(None, "the content is nested too deeply; expected a list of objects")
    expected = "expected a list of objects with id, scale and points"
    if not isinstance(content, list):
        text.fail(None, f"the content is no list; {expected}")
    for k, entry in enumerate(content, 1):
        if not (isinstance(entry, dict) and {"scale", "points"} <= entry.keys() and entry["scale"] in (0, 1)):
            text.fail(None, f"entry {k} is {entry!r:.60}; {expected}, scale 0 or 1")
        name, points = f"curve {entry.get('id', k)}", entry["points"]
        if isinstance(points, str):
            points = [words for row in points.splitlines() if (words := row.split())]
        if not isinstance(points, list) or not points or entry.get("points_count", len(points)) != len(points):
            text.fail(
                None, f"{name} has {points!r:.60} for {entry.get('points_count')} points; expected a row for each"
            )
        for j, row in enumerate(points, 1):
            if not isinstance(row, list) or len(row) != 8:
                text.fail(None, f"row {j} of {name} is {row!r:.60}; expected {_POINT}")
        yield _LightCurve(name, entry["scale"] == 1, np.array([_point(text, None, row, name) for row in points]))


def _point(text: Text, line: int | None, words: Sequence[Any], curve: str = "") -> list[float]:
    """Return the numbers of a point after checking them."""
    what = f" of {curve}" if curve else ""
    numbers = [text.number(line, str(word), f"column {k}{what}") for k, word in enumerate(words, 1)]
    text.number(line, str(words[1]), f"the intensity{what}", POSITIVE)
    for body, vector in (("Sun", numbers[2:5]), ("Earth", numbers[5:8])):
        if not any(vector):
            text.fail(line, f"the vector to the {body}{what} is zero; expected one in au")
    return numbers


class DamitModel(NamedTuple):
    """A model of DAMIT: a rotating body and its scattering law.

    Attributes
    ----------
    body : Body
    state : State
        The state of the body alone at ``epoch``, in the ecliptic of J2000, with its centre of mass at rest at 0.
    epoch : Time
        The time zero of the state.
    period : Quantity
        The sidereal period.
    law : LommelSeeligerLambert or None
        The scattering law with its phase function, if the file of the spin has it.
    """

    body: Body
    state: State
    epoch: Any
    period: Any
    law: LommelSeeligerLambert | None


def read_damit_model(
    shape: Any,
    spin: Any,
    *,
    diameter: Any = None,
    unit: Any = "km",
    epoch: Any = None,
    scale: str = "tdb",
    name: str | None = None,
    **amount: Any,
) -> DamitModel:
    """Read the shape and the spin of an asteroid in files of DAMIT: ``shape.txt`` and ``spin.txt``.

    Parameters
    ----------
    shape : str or Path
        The file lists the numbers of vertices and facets, the vertices, and the triangles by their vertices' numbers,
        which count from 1.
    spin : str or Path
        The file has four lines: longitude and latitude of the pole in degrees (ecliptic of J2000) and sidereal period
        in hours; JD and the rotation angle in degrees at this time; a, d and k of the phase function; the factor of
        Lambert's law. The last two lines may be missing.
    diameter : Quantity or str, optional
        The diameter of the sphere of the same volume, to which the shape is scaled: most shapes have no scale.
    unit : Unit or str
        The unit of the vertices; it has no effect if ``diameter`` is given.
    epoch : Time or str, optional
        The date of the state; by default the time in the file of the spin.
    scale : {"tdb", "tt", "utc", "tai"}
        The time scale of the file's JD.
    name : str, optional
        The name of the body.
    **amount
        The body's ``mass``, ``density`` or ``GM``, which the files do not have.

    Returns
    -------
    DamitModel

    Raises
    ------
    InvalidInput
        For content of another form, where the message names the line, and for a surface that is not closed.

    Warns
    -----
    InconsistentInput
        If the z-axis of the shape, about which it spins, is not a principal axis: the body then wobbles in a run,
        unlike the model of the database.

    Notes
    -----
    A vector of the shape is rotated into the ecliptic by Rz(longitude) Ry(90 degrees - latitude) Rz(angle), with the
    angle of the file plus 360 degrees times the time since its JD over the period (Kaasalainen & Torppa 2001, Icarus
    153, 24; Durech et al. 2010). These axes are the body's :attr:`~fullbody.Body.working_frame`.

    Examples
    --------
    >>> import numpy as np, pathlib, tempfile, warnings
    >>> from fullbody import observing
    >>> rows = ["4 4", "0 0 0", "1 0 0", "0 1 0", "0 0 1", "1 3 2", "1 2 4", "1 4 3", "2 3 4"]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     shape, spin = pathlib.Path(folder, "shape.txt"), pathlib.Path(folder, "spin.txt")
    ...     _ = shape.write_text(chr(10).join(rows)), spin.write_text(chr(10).join(["272 52 8.4006", "2443845 0"]))
    ...     with warnings.catch_warnings():
    ...         warnings.simplefilter("ignore")
    ...         model = observing.read_damit_model(shape, spin, diameter="77 km", density="2 g/cm3")
    >>> model.period, round(float(model.body.shape.volume.to_value("km3") / (np.pi / 6 * 77**3)), 12)
    (<Quantity 8.4006 h>, 1.0)
    """
    with need("observing", "a model with units"):
        import astropy.units as u
        from astropy.time import Time

    choice(scale, "scale", _SCALES)
    refuse_unknown(amount, ("mass", "density", "GM"), "read_damit_model")
    text = Text(spin)
    (longitude, latitude, hours, jd, angle), law = _spin(text)
    start = Time(jd, format="jd", scale=scale)
    state_epoch = start if epoch is None else date(epoch, "epoch")
    rotations_since = float((state_epoch - start).to_value("h")) / hours
    solid = _shape(Text(shape), diameter, unit)
    with naming(shape):
        body = Body(solid, name=name, **amount)
    # The angle of the database is measured from another direction than that of a state.
    rotation_angle = angle - 90.0 + 360.0 * (rotations_since % 1.0)
    state = State.rotating(body, longitude * u.deg, latitude * u.deg, hours * u.h, rotation_angle * u.deg)
    axis = state.core.spin[0] / np.linalg.norm(state.core.spin[0])
    tilt = float(np.arctan2(np.hypot(axis[0], axis[1]), abs(axis[2])))
    if tilt > _TILT_LIMIT:
        caution(
            f"{shape}: the spin is {np.degrees(tilt):.3g} degrees from the principal axis of the shape, so that the "
            "body wobbles in a run, unlike the model of the database"
        )
    return DamitModel(body, state, state_epoch, hours * u.h, law)


def _spin(text: Text) -> tuple[list[float], LommelSeeligerLambert | None]:
    rows = text.words()
    kinds = [
        ("longitude and latitude of the pole in degrees and the period in hours", 3),
        ("JD and the rotation angle in degrees", 2),
        ("a, d, k of the phase function", 3),
        ("the factor of Lambert's law", 1),
    ]
    numbers: list[float] = []
    for k, (what, size) in enumerate(kinds if len(rows) > 2 else kinds[:2]):
        line, words = text.expected(rows, k, (size,), what)
        numbers += [text.number(line, word, what) for word in words]
        if k == 0:
            text.number(line, words[2], "the period in hours", POSITIVE)
            if not abs(numbers[1]) <= 90.0:
                text.fail(line, f"the latitude of the pole is {words[1]}; expected -90 to 90 degrees")
    _refuse_more(text, rows, len(kinds), "the factor of Lambert's law")
    if len(numbers) == 5:
        return numbers, None
    with naming(text.path):
        return numbers[:5], LommelSeeligerLambert(LinearExponential(*numbers[5:8]), lambert=numbers[8])


def _shape(text: Text, diameter: Any, unit: Any) -> Polyhedron:
    import astropy.units as u

    rows = text.words()
    line, words = text.expected(rows, 0, (2,), "the numbers of vertices and facets")
    count, face_count = (text.whole_number(line, word, "the number of vertices or facets", 4) for word in words)
    vertices, faces = [], []
    for k in range(1, 1 + count):
        line, words = text.expected(rows, k, (3,), "the coordinates of a vertex")
        vertices.append([text.number(line, word, "a coordinate") for word in words])
    for k in range(1 + count, 1 + count + face_count):
        line, words = text.expected(rows, k, (3,), "the vertices of a triangle")
        faces.append([text.whole_number(line, word, "the number of a vertex", 1) - 1 for word in words])
        if max(faces[-1]) >= count:
            text.fail(line, f"the triangle has vertex {max(faces[-1]) + 1}; expected at most {count}")
    _refuse_more(text, rows, 1 + count + face_count, "the last facet")
    points = np.array(vertices)
    with naming(text.path):
        solid = Polyhedron(points, faces)
    if diameter is None:
        try:
            return Polyhedron(points * unit_named(unit), faces)
        except (ValueError, TypeError) as error:
            raise InvalidInput(f"unit is {unit!r}; expected a length, such as 'km'") from error
    if not (isinstance(diameter, str) or is_quantity(diameter)):
        raise InvalidInput(f"diameter is {diameter!r}; expected a Quantity, or text with a unit, such as '77 km'")
    km = Units(("km", "s", "kg")).number(diameter, "length", "diameter", POSITIVE)
    with naming(text.path):
        return Polyhedron(points * (km / np.cbrt(6.0 * solid.volume / np.pi)) * u.km, faces)
