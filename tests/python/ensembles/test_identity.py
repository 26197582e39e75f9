"""Whether two functions compute the same: what is noticed, and what is not."""

import functools
import os
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import fullbody
import helpers
import numpy as np
import pytest
from astropy import units as u
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
    def direct(x):
        return helpers.half(x)

    def later(x):
        from helpers import half

        return half(x)

    def other(x):
        return helpers.__name__

    before = digest(direct), digest(later), digest(other)
    monkeypatch.setattr(helpers, "half", lambda x: x / 4)
    assert [a == b for a, b in zip(before, (digest(direct), digest(later), digest(other)), strict=True)] == [0, 0, 1]
    assert list(parts(direct)) == ["", "helpers", "helpers.half"]


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


def test_what_cannot_be_told_is_refused():
    lock = threading.Lock()
    with pytest.raises(InvalidInput, match="cannot be told from another of the type lock"):
        digest(lambda: lock)


SAMPLE = (even, Some(1), {"a", "b", "c", "d"}, closed("x"), stats.norm(1, 2))


def test_every_process_says_the_same():
    code = "import test_identity as t; print(t.digest(t.SAMPLE))"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    around = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": "1"}
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, env=around, text=True).stdout
    assert told.strip() == digest(SAMPLE)
