"""Settings of all tests, with property tests that draw the same examples everywhere."""

import os
import signal
import sys

import pytest
from astropy.utils import iers
from hypothesis import HealthCheck, settings

# Old versions of astropy download the Earth's rotation even if they have a table of it.
iers.conf.auto_download = False
# Figures open no window, also in the processes that tests start.
os.environ["MPLBACKEND"] = "agg"
# Workers share the cores, so that threads of linear algebra in each of them would wait for each other.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# The tests of Ctrl-C send this signal, which a shell makes commands in the background ignore.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile(
    "suite", derandomize=True, deadline=None, max_examples=25, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("suite")


@pytest.fixture(autouse=True)
def close_figures():
    """Close the figures of each test."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
