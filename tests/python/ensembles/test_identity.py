"""The identity of functions changes with what they compute, and with nothing else."""

import collections
import contextlib
import functools
import os
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import fullbody
import helpers
import numba
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import Longitude
from fullbody import InvalidInput, events
from fullbody.ensembles.identity import digest, parts
from scipy import stats

LIMIT = 3.0


def source(text, **around):
    """A function ``f`` from its source, as a notebook defines it."""
    space = {"__name__": "__main__", "np": np, **around}
    exec(text, space)
    return space["f"]


BASE = "def f(x, k=1):\n    return np.sin(x) * k + LIMIT"


@pytest.mark.parametrize(
    "other",
    [
        BASE.replace("sin", "cos"),
        BASE.replace("k=1", "k=2"),
        BASE.replace("+", "-"),
        BASE.replace("k + LIMIT", "(lambda y: y * LIMIT)(k)"),
        BASE.replace("def f(x, k=1)", "def f(x, *, k=1)"),
    ],
)
def test_changed_code_is_noticed(other):
    assert digest(source(other, LIMIT=1.0)) != digest(source(BASE, LIMIT=1.0))


def test_where_a_function_stands_does_not_count():
    moved = "\n\n# A remark.\ndef helper():\n    return 3\n\n" + BASE.replace(
        "    return", "    # Another.\n    return"
    )
    assert digest(source(moved, LIMIT=1.0)) == digest(source(BASE, LIMIT=1.0, unused=5))
    documented = BASE.replace("    return", '    """What it is."""\n    return')
    assert digest(source(documented, LIMIT=1.0)) == digest(source(documented.replace("is", "was"), LIMIT=1.0))


@pytest.mark.parametrize(
    ("one", "two"),
    [
        (1.0, 2.0),
        (1.0, 1),
        (True, 1),
        ("1", 1),
        (b"1", "1"),
        (None, 0),
        (0.0, -0.0),
        ((1, (2,)), (1, 2)),
        ([1, 2], (1, 2)),
        ({"a": 1}, {"a": 2}),
        ({1, 2}, {1, 3}),
        (np.array([1.0, 2.0]), np.array([1.0, 2.5])),
        (np.array([1.0, 2.0]), np.array([[1.0], [2.0]])),
        (np.array([1]), np.array([1.0])),
        (1 * u.km, 1 * u.m),
        (1 * u.km, 1000 * u.m),
        (fullbody.Verner98(1e-9), fullbody.Verner98(1e-8)),
        (fullbody.Verner98(), fullbody.Verner87()),
        (events.Function(lambda s: s.time), events.Function(lambda s: s.time - 1.0)),
        (fullbody.systems.case1(), fullbody.systems.case2()),
        (np.random.default_rng(1), np.random.default_rng(2)),
        (functools.partial(max, 1), functools.partial(max, 2)),
        (np.sin, np.cos),
        (len, max),
        (stats.norm(1, 2), stats.norm(1, 3)),
        (fullbody.systems.kw4, fullbody.systems.case1),
        ("ab".upper, "ab".lower),
    ],
)
def test_values(one, two):
    """As a value from around a function, too."""
    assert digest(one) == digest(one)
    assert digest(one) != digest(two)
    assert digest(source(BASE, LIMIT=one)) == digest(source(BASE, LIMIT=one))
    assert digest(source(BASE, LIMIT=one)) != digest(source(BASE, LIMIT=two))


def closed(k):
    return lambda x: x + k


def test_what_is_around_counts():
    assert digest(closed(1)) == digest(closed(1)) != digest(closed(2))


def test_helpers_in_other_files_count(monkeypatch):
    """A module counts with all that it holds, for a function may hand it on or look things up in it by a text."""

    def direct(x):
        return helpers.half(x)

    def later(x):
        from helpers import half

        return half(x)

    def by_text(x):
        return getattr(helpers, "ha" + "lf")(x)

    def other(x):
        return x

    functions = [direct, later, by_text, other]
    before = [digest(function) for function in functions]
    monkeypatch.setattr(helpers, "half", lambda x: x / 4)
    assert [a == b for a, b in zip(before, map(digest, functions), strict=True)] == [False, False, False, True]
    assert list(parts(direct)) == ["", "helpers"]


class Base:
    def __call__(self, x):
        return self.one(x)

    def one(self, x):
        return x


@dataclass
class Some(Base):
    k: int = 0

    @functools.cached_property
    def twice(self):
        return 2 * self.k

    @property
    def three(self):
        return 3

    @staticmethod
    def four():
        return 4


def test_objects_count_with_their_classes(monkeypatch):
    assert digest(Some(1)) == digest(Some(1)) != digest(Some(2))
    assert digest(Some(1).one) == digest(Some(1).one) != digest(Some(2).one)
    before = digest(Some(1))
    with monkeypatch.context() as patch:
        patch.setattr(Base, "one", lambda self, x: x + 1)
        assert digest(Some(1)) != before
    with monkeypatch.context() as patch:
        patch.setattr(Some, "three", property(lambda self: 4))
        assert digest(Some(1)) != before
    assert digest(Some(1)) == before


def even(n):
    return n == 0 or odd(n - 1)


def odd(n):
    return n != 0 and even(n - 1)


def test_ring():
    """Things that hold each other."""
    assert digest(even) == digest(even) != digest(odd)
    ring = [1]
    ring.append(ring)
    assert digest(ring) == digest(ring)


@functools.lru_cache
def cached(x):
    return closed(x)


def test_wrapped_functions_are_what_they_wrap():
    first = digest(cached)
    cached(3)
    assert digest(cached) == first


class Scale:
    """A callable with the attributes of a wrapper."""

    def __init__(self, function, factor):
        functools.update_wrapper(self, function)
        self.py_func = function
        self.factor = factor

    def __call__(self, x):
        return self.factor * self.py_func(x)


class Labelled(dict):
    pass


class Listed(list):
    pass


class Measured(float):
    pass


def with_scale(thing, scale):
    thing.scale = scale
    return thing


def attributed(scale):
    return with_scale(lambda x: x, scale)


@functools.lru_cache
def scaled(x):
    return x


@pytest.mark.parametrize(
    ("one", "two"),
    [
        (Scale(closed, 1.0), Scale(closed, 5.0)),
        (with_scale(Labelled(), 1.0), with_scale(Labelled(), 7.0)),
        (with_scale(Listed([1]), 1.0), with_scale(Listed([1]), 7.0)),
        (with_scale(Measured(1.0), 1.0), with_scale(Measured(1.0), 7.0)),
        (collections.defaultdict(lambda: 1.0), collections.defaultdict(lambda: 3.0)),
        (np.ma.masked_array([1.0, 2.0], mask=[0, 0]), np.ma.masked_array([1.0, 2.0], mask=[0, 1])),
        (collections.namedtuple("P", "a b")(1, 2), collections.namedtuple("P", "b a")(1, 2)),
        (collections.OrderedDict(a=1), {"a": 1}),
        (attributed(1.0), attributed(2.0)),
        (np.zeros(2, [("a", "f8"), ("b", "f8")]), np.zeros(2, [("b", "f8"), ("a", "f8")])),
        (Longitude(1 * u.rad, wrap_angle=1 * u.rad), Longitude(1 * u.rad, wrap_angle=2 * u.rad)),
        (2 * u.def_unit("pace", 0.7 * u.m), 2 * u.def_unit("pace", 0.8 * u.m)),
        (np.vectorize(lambda x: x), np.vectorize(lambda x: 2 * x)),
        # A function that a library has made is not the only one of its name.
        (np.polynomial.Polynomial([1.0]), np.polynomial.Polynomial([2.0])),
        (contextlib.contextmanager(closed), contextlib.contextmanager(digest)),
        (numba.njit(closed), numba.njit(source(BASE, LIMIT=1.0))),
    ],
)
def test_complete_values(one, two):
    """Attributes, masks, factories, names of fields: whatever a value has beside what it shows."""
    assert digest(one) == digest(one)
    assert digest(one) != digest(two)
    assert digest(source(BASE, LIMIT=one)) != digest(source(BASE, LIMIT=two))


def test_what_was_computed_before_does_not_count():
    """Units and cached functions remember what they were used for."""
    length = 3 * u.imperial.mile
    first = digest((length, numba_sum, scaled))
    length.to("km"), length.si, numba_sum(2.0), scaled(1)
    assert digest((length, numba_sum, scaled)) == first


@numba.njit
def numba_sum(x):
    return x + 1


def test_what_cannot_be_compared_is_refused():
    lock = threading.Lock()
    with pytest.raises(InvalidInput, match=r"lock, whose value cannot be seen .*; expected .* or key=, a text of your"):
        digest(lambda: lock)
    with pytest.raises(InvalidInput, match=r"f uses eval, by which it may use anything, so that"):
        digest(source("def f(x):\n    return eval('LIM' + 'IT')", LIMIT=1.0))
    endless = []
    endless.append({1, functools.partial(max, endless)})
    with pytest.raises(InvalidInput, match=r"recursion"):
        digest(endless)


SAMPLE = (even, Some(1), {"a", "b", "c", "d"}, closed("x"), stats.norm(1, 2))


def test_every_process_says_the_same():
    code = "import test_identity as t; print(t.digest(t.SAMPLE))"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    around = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": "1"}
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, env=around, text=True).stdout
    assert told.strip() == digest(SAMPLE)
