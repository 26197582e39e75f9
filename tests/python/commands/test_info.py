"""``fullbody info`` tells what every file of this package holds."""

import re

import fullbody
import numpy as np
from fullbody.commands.cli import main


def test_info_tells_what_maps_and_flights_hold(tmp_path, capsys):
    system, state = fullbody.systems.kw4()
    particles = fullbody.Particles([[4.0, 0.0, 0.0]], [[0.0, 0.0, 0.7]])
    system.fly(state, particles, 10.0, output=5.0).save(tmp_path / "flight.nc")

    def setup(angle):
        if angle > 0.15:
            raise ValueError("too far")
        return system, state.rotated("Beta", [0, 0, 1], angle)

    options = {"measure": lambda run: {"place": run.position[-1]}, "store": tmp_path / "map.nc", "key": "places"}
    fullbody.sweep(setup, {"angle": [0.0, 0.1, 0.2]}, 1.0, **options)
    system.integrate(state, 1.0).save(tmp_path / "run.nc")
    assert main(["info", *(str(tmp_path / f"{name}.nc") for name in ("flight", "map", "run"))]) == 0
    flight, found, run = capsys.readouterr().out.split(f"{tmp_path}/")[1:]
    for text in ("particles +1", "flying +1"):
        assert re.search(text, flight)
    for text in ("angle +3 values", "place +angle, place_0, place_1", "ValueError +1", "none +2"):
        assert re.search(text, found)
    assert "Integrator" in run or "steps" in run


def test_a_damaged_map_is_named(tmp_path, capsys):
    (tmp_path / "map.nc").write_bytes(np.arange(100).tobytes())
    assert main(["info", str(tmp_path / "map.nc")]) == 1
    assert "map.nc" in capsys.readouterr().err
