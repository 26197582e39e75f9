"""Simulated radar observations of two points, and a fit of them, that several files of tests use."""

import fullbody
import pytest
from support.fits import START, pair, pair_radar


@pytest.fixture(scope="module")
def radar():
    return pair_radar()


@pytest.fixture(scope="module")
def fitted(radar):
    return fullbody.fit(pair, START, radar)
