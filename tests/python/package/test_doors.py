"""Input of any kind to every public function gives a right object or an error. ``make fuzz`` tries for an hour."""

import pytest
from doors import DOORS
from hypothesis import HealthCheck, given, settings

#: How many inputs, for some seconds a door.
EXAMPLES = {"netcdf": 30, "netcdf-content": 12, "observations": 40, "run": 40, "fit": 10}


@pytest.mark.parametrize("name", DOORS)
def test_any_input_to_a_door_gives_a_right_object_or_an_error(name):
    door = DOORS[name]

    @settings(max_examples=EXAMPLES.get(name, 50), suppress_health_check=list(HealthCheck))
    @given(door.inputs)
    def enter(value):
        door.enter(value)

    enter()


@pytest.mark.parametrize(
    ("name", "path"),
    [(door.name, path) for door in DOORS.values() for path in door.corpus()],
    ids=lambda part: getattr(part, "name", part),
)
def test_inputs_that_once_led_to_a_fault_do_no_more(name, path):
    DOORS[name].enter(path.read_bytes())
