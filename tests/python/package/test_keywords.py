"""Unknown names in options that are passed on, and in State.replace, are refused with a suggestion."""

import fullbody
import pytest
from fullbody import systems
from fullbody.errors import InvalidInput

SYSTEM, STATE = systems.case1()
MOON = fullbody.Component(diameter=3)


@pytest.mark.parametrize(
    ("call", "wrong", "right"),
    [
        (lambda: STATE.replace(vel=0), "vel", "velocity"),
        (lambda: SYSTEM.with_options(gravty="point"), "gravty", "gravity"),
        (lambda: fullbody.binary(MOON, MOON, eccentrity=0.1), "eccentrity", "eccentricity"),
        (lambda: systems.kw4(gravty="point"), "gravty", "gravity"),
    ],
)
def test_unknown_options_are_refused_with_a_suggestion(call, wrong, right):
    with pytest.raises(InvalidInput) as caught:
        call()
    assert str(caught.value).startswith(f"{wrong!r} is not an option of ")
    assert f"did you mean {right!r}? expected some of " in str(caught.value)


@pytest.mark.parametrize(
    "call",
    [
        lambda: SYSTEM.integrate(STATE, t_end=3.0),
        lambda: fullbody.Sphere(r=1),
        lambda: fullbody.Body(fullbody.Sphere(1), m=1),
        lambda: SYSTEM.mu(i=0, j=1),
        lambda: fullbody.KeplerElements(1, 0, 0, 0, 0, mean_anomaly=0),
    ],
)
def test_unknown_keywords_raise_pythons_own_error(call):
    with pytest.raises(TypeError, match="unexpected keyword argument"):
        call()
