"""Descriptions of systems in TOML that several tests read."""

import fullbody

KW4 = """
[system]
units = ["km", "hour", "kg"]
G = 8.64960768e-13
gravity = "surface"
gravity_tolerance = 1e-13

[[body]]
name = "Alpha"
semi_axes = [0.766, "747.5 m", 0.6735]
mass = "2.353e12 kg"
angles = ["3.2 deg", 0, 0]
spin = [0, 0, 2.2728]

[[body]]
name = "Beta"
semi_axes = [0.285, 0.2315, 0.1745]
mass = 0.135e12
orbit = { about = "Alpha", a = 2.548, e = 0.0004, i = "156.1 deg", Omega = "105.4 deg", omega = "319.7 deg", M = 0 }
spin = [0, 0, 0.3611]

[integrator]
rtol = 1e-12

[run]
until = "1 day"
output = "30 min"
"""


def read(tmp_path, text):
    """Read a text as the file ``system.toml``."""
    path = tmp_path / "system.toml"
    path.write_text(text)
    return fullbody.read_toml(path)


PAIR = """
[system]
G = 1.0
[[body]]
radius = 1.0
mass = 1.0
[[body]]
point = true
mass = 1e-3
position = [3, 0, 0]
velocity = [0, 0.6, 0]
[run]
until = 2.0
"""
