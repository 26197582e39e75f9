"""Input of any kind to every public function gives a right object or an error. ``make fuzz`` tries for an hour."""

import pytest
from hypothesis import HealthCheck, given, settings
from targets import TARGETS

#: How many inputs, for some seconds a target.
EXAMPLES = {"netcdf": 30, "netcdf-content": 12, "observations": 40, "run": 40, "fit": 10}


@pytest.mark.parametrize("name", TARGETS)
def test_any_input_to_a_target_gives_a_right_object_or_an_error(name):
    target = TARGETS[name]

    @settings(max_examples=EXAMPLES.get(name, 50), suppress_health_check=list(HealthCheck))
    @given(target.inputs)
    def enter(value):
        target.check(value)

    enter()


@pytest.mark.parametrize(
    ("name", "path"),
    [(target.name, path) for target in TARGETS.values() for path in target.corpus()],
    ids=lambda part: getattr(part, "name", part),
)
def test_inputs_of_former_faults_cause_none(name, path):
    TARGETS[name].check(path.read_bytes())
