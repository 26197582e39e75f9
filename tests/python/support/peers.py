"""Input files of other programs, with changes, and the relative acceleration that a force causes."""

from pathlib import Path

import numpy as np

DATA = Path(__file__).parents[2] / "data" / "peers"


def changed(tmp_path, name, old, new):
    """A copy of a sample with one text replaced."""
    text = (DATA / name).read_text()
    assert old in text
    path = tmp_path / name
    path.write_text(text.replace(old, new, 1))
    return path


def line_of(path, text):
    return next(k for k, line in enumerate(path.read_text().splitlines(), 1) if text in line)


def relative_acceleration(system, state, name):
    masses = np.asarray(getattr(system.masses, "value", system.masses))
    force = system.loads(state)[name].force
    force = np.asarray(getattr(force, "value", force))
    return force[1] / masses[1] - force[0] / masses[0]
