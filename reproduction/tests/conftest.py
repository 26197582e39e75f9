"""The draft of the report on Ho et al. (2021), which many tests read."""

import json

import pytest


@pytest.fixture(scope="session")
def drafted(tmp_path_factory):
    """Return a draft of the report on Ho et al. (2021), and the results that are in it."""
    from reproduction.ho2021 import page

    compute, result = page.compute, []

    def compute_and_record(**options):
        result.append(compute(**options))
        return result[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "compute", compute_and_record)
        report = page.write_report(tmp_path_factory.mktemp("report"), draft=True)
    return report, result[0]


@pytest.fixture(scope="session")
def draft(drafted):
    """Return the draft alone."""
    return drafted[0]


@pytest.fixture(scope="session")
def numbers(draft):
    """Return the numbers that the draft writes for programs."""
    return json.loads(draft.numbers.read_text(), parse_constant=lambda name: pytest.fail(f"{name} in the numbers"))
