"""Settings of all tests, with property tests that draw the same examples everywhere."""

import os
import signal
import sys

import pytest
from astropy.utils import iers
from hypothesis import HealthCheck, settings

# Old versions of astropy ask the network for the Earth's rotation even where they have a table of it.
iers.conf.auto_download = False
# Pictures appear on no screen, also in the processes that tests start.
os.environ["MPLBACKEND"] = "agg"
# Workers share the cores: threads of each one's linear algebra would wait for each other.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell starts commands in the background with this signal ignored; the tests of Ctrl-C send it.
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
