"""Each number that a class declares refuses what is out of its range, of another kind or of another unit."""

import inspect
import reprlib
from dataclasses import is_dataclass

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Body, Component, Ellipsoid, Part, Sphere, Verner98, events, forces, observing, particles
from fullbody.base.kinds import Declared, Number, kinds_of
from fullbody.errors import InvalidInput

NAN, INF = float("nan"), float("inf")

# For each range: what errors expect, and numbers that are out of it.
FINITE = "a finite number", (NAN, INF, -INF)
NOT_NEGATIVE = "a finite number, zero or above", (NAN, INF, -INF, -1.5)
POSITIVE = "a finite number above zero", (NAN, INF, -INF, 0.0, -1.5)
NONZERO = "a finite number that is not zero", (NAN, INF, -INF, 0.0)
FRACTION = "a number from 0 to 1", (NAN, INF, -0.1, 1.1)
TOLERANCE = "a number from 0 to below 1", (NAN, INF, -1e-13, 1.0)
SHARE = "a number above 0 and below 1", (NAN, INF, 0.0, 1.0)
EXPONENT = "a number from 0 to 1e+06", (NAN, INF, -0.1, 1e20)
PEAK = "a number from 1e-06 to 1e+06", (NAN, INF, -0.1, 0.0, 1e20)
CUTOFF = "an angle above zero, at most pi/2", (NAN, INF, -0.1, 0.0, 1.6)
PERIOD = "a time other than zero", (NAN, 0.0)
LENGTH = u.m, POSITIVE
#: The fields of a law of radar with a peak.
PEAKED = {"C": (None, PEAK), "R": (None, EXPONENT), "cutoff": (u.rad, CUTOFF)}
PATH = {"times": [0, 1, 2, 3], "positions": np.ones((4, 3))}


def of(what, make, **fields):
    """Fields of one class by their names, with the words that errors add to these."""
    return {name: (f"{name}{what}", lambda x, name=name: make(**{name: x}), *field) for name, field in fields.items()}


def error(call):
    with pytest.raises(InvalidInput) as caught:
        call()
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, fullbody.FullbodyError)
    return str(caught.value)


def ellipsoid(**options):
    return Ellipsoid(**({"a": 1.0, "b": 1.0, "c": 1.0} | options))


def third_body(**options):
    path = {} if "orbit" in options else PATH
    return forces.ThirdBody(**path | ({} if {"mass", "GM"} & set(options) else {"mu": 1.0}) | options, of="body")


def occultation(**options):
    return events.Occultation("A", "B", toward=np.ones((4, 3)), **options)


def tide(**options):
    return forces.Tide(on="A", by="B", **{"k2": 0.1, "lag": 1.0} | options, name="T")


def yorp(**options):
    return forces.Yorp("A", along=1.0, **options, name="Y")


def byorp(**options):
    return forces.Byorp("B", "A", **({} if "coefficient" in options else {"force": 1.0}) | options, name="Y")


def heat(**options):
    return forces.BinaryYarkovsky("B", "A", **{"pressure": 1.0, "lag": 0.3} | options, name="Y")


def part(**options):
    return Part(Sphere(1.0), **({} if {"density", "GM"} & {*options} else {"mass": 1.0}) | options)


def component(**options):
    sizes = {"semi_axes", "diameters", "diameter"} & {*options}
    return Component(**({} if sizes else {"diameter": 1.0}) | options, name="Moon")


#: By class and field: the name in errors, a call that takes it, a unit, the range, and the shape of an array.
FIELDS = {
    "model.Ellipsoid": {
        name: (f"semi-axis {name}", lambda x, name=name: ellipsoid(**{name: x}), u.m, POSITIVE) for name in "abc"
    },
    "model.Sphere": of("", Sphere, radius=LENGTH),
    "model.Part": of(
        " of a part",
        part,
        **{"mass": (u.kg, NONZERO), "GM": (u.m**3 / u.s**2, NONZERO), "density": (u.kg / u.m**3, NONZERO)},
        **{"position": (u.m, FINITE, (3,)), "attitude": (None, FINITE, (4,))},
    ),
    "events.Separation": of(" of Separation", events.Separation, value=LENGTH),
    "events.Escape": of(" of Escape", events.Escape, distance=LENGTH),
    "events.Occultation": of(" of Occultation", occultation, times=(u.s, FINITE, (4,)), slowness=(None, FINITE)),
    "record._Adaptive": of("", Verner98, rtol=(None, TOLERANCE), atol=(None, TOLERANCE)),
    "record.LieGroupVariational": of("", fullbody.LieGroupVariational, step=(u.s, POSITIVE)),
    "record.SymplecticSplitting": of("", fullbody.SymplecticSplitting, step=(u.s, POSITIVE)),
    "forces.Yorp": of(" of Y", yorp, obliquity=(u.rad, FINITE, (4,)), pressure=(u.Pa, POSITIVE), radius=LENGTH),
    "forces.Byorp": of(
        " of Y",
        byorp,
        **{"force": (u.N, FINITE, (3,)), "coefficient": (None, FINITE, (3,)), "torque": (u.N * u.m, FINITE, (3,))},
        **{"pressure": (u.Pa, POSITIVE), "radius": LENGTH},
    ),
    "forces.BinaryYarkovsky": of(
        " of Y",
        heat,
        **{"pressure": (u.Pa, POSITIVE), "lag": (u.rad, FINITE), "radius": LENGTH, "primary_radius": LENGTH},
        **dict.fromkeys(("albedo", "emissivity"), (None, FRACTION)),
    ),
    "forces.ThirdBody": of(
        " of third body",
        third_body,
        **{"mass": (u.kg, POSITIVE), **dict.fromkeys(("mu", "GM"), (u.m**3 / u.s**2, POSITIVE))},
        **{"time": (u.s, FINITE), "times": (u.s, FINITE, (4,)), "positions": (u.m, FINITE, (4, 3))},
    ),
    "forces.Tide": of(" of T", tide, k2=(None, FINITE), lag=(u.s, FINITE), radius=LENGTH),
    "particles.Shadow": of(" of Shadow", particles.Shadow, visible=(None, SHARE)),
    "particles.Bounce": of(
        " of Bounce",
        lambda **x: particles.Bounce(**{"normal": 0.5, "rest_speed": 1.0} | x),
        **{"normal": (None, FRACTION), "tangential": (None, FRACTION), "rest_speed": (u.m / u.s, POSITIVE)},
    ),
    "particles.EscapeDistance": of(" of EscapeDistance", particles.EscapeDistance, distance=LENGTH),
    "particles.Radiation": of(" of Radiation", particles.Radiation, strength=(u.N, NOT_NEGATIVE), radius=LENGTH),
    "observing.LommelSeeligerLambert": of(
        " of LommelSeeligerLambert", observing.LommelSeeligerLambert, lambert=(None, FINITE)
    ),
    "observing.Hapke": of(
        " of Hapke",
        observing.Hapke,
        **dict.fromkeys(("single_scattering_albedo", "opposition_amplitude"), (None, FINITE)),
        **dict.fromkeys(("opposition_width", "asymmetry"), (None, FINITE)),
        roughness=(u.rad, FINITE),
    ),
    "observing.Cosine": of(" of Cosine", observing.Cosine, C=(None, EXPONENT), R=(None, EXPONENT)),
    "observing.PeakedLaw": of(" of Gaussian", lambda **x: observing.Gaussian(**{"C": 1.0} | x), **PEAKED),
    "setups.Component": of(
        " of Moon",
        component,
        **dict.fromkeys(("semi_axes", "diameters"), (u.m, POSITIVE, (3,))),
        **{"diameter": LENGTH, "mass": (u.kg, POSITIVE), "density": (u.kg / u.m**3, POSITIVE)},
        GM=(u.m**3 / u.s**2, POSITIVE),
        **{"rotation_period": (u.s, PERIOD), "rotation_angle": (u.rad, FINITE), "tilt": (u.rad, FINITE)},
    ),
}
#: Classes that check their numbers one by one, or have those of a base class.
OTHERS = {
    "observing.Hagfors": of(" of Hagfors", lambda **x: observing.Hagfors(**{"C": 1.0} | x), **PEAKED),
    "model.Body": of(
        " of Alpha",
        lambda **x: Body(Sphere(1.0), name="Alpha", **x),
        **{"mass": (u.kg, POSITIVE), "density": (u.kg / u.m**3, POSITIVE)},
    ),
}
ALL = {f"{owner}.{name}": field for owner, fields in (FIELDS | OTHERS).items() for name, field in fields.items()}


def test_every_declared_number_is_in_the_table():
    def classes(owner):
        return {owner}.union(*(classes(heir) for heir in owner.__subclasses__()))

    declared = {
        f"{owner.__module__.split('.')[1]}.{owner.__name__}.{name}"
        for owner in classes(Declared)
        for name, kind in (kinds_of(owner) if is_dataclass(owner) else {}).items()
        if isinstance(kind, Number)
        and owner.__module__.startswith("fullbody.")
        and name in inspect.get_annotations(owner)
    }
    assert declared == {f"{owner}.{name}" for owner, fields in FIELDS.items() for name in fields}


@pytest.mark.parametrize("name", ALL)
def test_each_declared_number_refuses_invalid_values(name):
    what, make, unit, (expected, outside), *shape = ALL[name]
    good = np.arange(1.0, 1.0 + np.prod(shape or 1)).reshape(shape[0] if shape else ())
    expected = expected.replace("a finite number", "finite numbers").replace("is not", "are not") if shape else expected

    def message_for(value):
        message = error(lambda: make(value))
        assert message.startswith(what + " ")
        return message

    for value in outside:
        arguments = good.copy()
        arguments[(-1,) * arguments.ndim] = value
        assert f"; expected {expected}" in message_for(arguments if shape else value)
        assert f"{value:g}" in message_for(arguments)
        assert len(message_for(arguments)) < 400
    for value in ("wide", True, 1j, b"1", 10**309):
        assert message_for(value).startswith(f"{what} is {reprlib.repr(value)}; expected {expected}")
    assert message_for(np.ma.masked) == f"{what} is masked; expected numbers throughout"
    assert "shape (1, 1, 2)" in message_for([[[1.0, 2.0]]])
    message = message_for(good * u.cd)
    if unit is None:
        assert message == f"{what} has the unit cd; expected pure numbers"
    else:
        assert message.startswith(f"{what} has the unit cd; expected a unit such as ")
        assert u.Unit(message.partition(" such as ")[2]).is_equivalent(unit)
