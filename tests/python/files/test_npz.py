"""Runs as archives of numpy."""

import json
import zipfile

import fullbody
import numpy as np
import pytest
from support import refused

PARTS = ("time", "position", "transition", "sensitivity", "chaos", "event_time")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A run with events, derivatives and indicators of chaos, and its file."""
    system, state = fullbody.systems.kw4(units=True)
    options = {"events": [fullbody.events.Apoapsis("Beta", "Alpha")], "derivatives": ["mass of Beta"], "chaos": True}
    run = system.integrate(state, "1 day", output="6 h", **options)
    path = tmp_path_factory.mktemp("written") / "run.npz"
    run.save(path)
    return run, path


def test_a_loaded_run_equals_the_saved_one(written):
    run, path = written
    assert len(run.events) > 0
    assert fullbody.load(path) == run


def test_numpy_alone_reads_the_arrays(written):
    run, path = written
    dataset = run.to_xarray()
    with np.load(path, allow_pickle=False) as archive:
        for name in PARTS:
            np.testing.assert_array_equal(archive[name], dataset[name].values)
        attributes = json.loads(str(archive["description"]))["attributes"]
    assert attributes == {name: getattr(value, "item", lambda v=value: v)() for name, value in dataset.attrs.items()}


@pytest.mark.parametrize("length", [3, 40, 0.5, 0.99])
def test_a_truncated_archive_is_refused(written, tmp_path, length):
    data = written[1].read_bytes()
    (tmp_path / "short.npz").write_bytes(data[: length if length > 1 else int(length * len(data))])
    refused(r"short\.npz is not a readable run of fullbody", fullbody.load, tmp_path / "short.npz")


def test_a_changed_number_is_noticed(written, tmp_path):
    data = bytearray(written[1].read_bytes())
    offset = data.find(written[0].position.value.tobytes())
    data[offset + 5] ^= 1
    (tmp_path / "changed.npz").write_bytes(data)
    refused("truncated or damaged", fullbody.load, tmp_path / "changed.npz")


def test_an_archive_of_something_else_is_refused(written, tmp_path):
    np.savez(tmp_path / "other.npz", position=np.zeros(3))
    with zipfile.ZipFile(tmp_path / "text.npz", "w") as archive:
        archive.writestr("a.txt", "no arrays")
    for name in ("other", "text"):
        refused("without the description of a run", fullbody.load, tmp_path / f"{name}.npz")
