"""Settings of the whole suite, with property tests that draw the same examples everywhere; and costly fixtures."""

import json
import os

import pytest
from hypothesis import HealthCheck, settings

# Workers share the cores: threads of each one's linear algebra would wait for each other.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

settings.register_profile(
    "suite", derandomize=True, deadline=None, max_examples=25, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("suite")


@pytest.fixture(scope="session")
def draft(tmp_path_factory):
    """A draft of the report on Ho et al. (2021)."""
    from reproduction.ho2021.page import write_report

    return write_report(tmp_path_factory.mktemp("report"), draft=True)


@pytest.fixture(scope="session")
def numbers(draft):
    """What it writes for programs."""
    return json.loads(draft.numbers.read_text(), parse_constant=lambda name: pytest.fail(f"{name} in the numbers"))
