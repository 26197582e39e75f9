"""Stores of sweeps: interrupted sweeps continue, changed ones are refused, and damaged files are named."""

import functools
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

import fullbody
import numpy as np
import pytest
import xarray as xr
from astropy import units as u
from fullbody import FullbodyError, Verner98, events
from fullbody.ensembles import store as stores
from fullbody.errors import Interrupted, InvalidInput
from support import refused
from support.maps import angle, assert_same, circle

TESTS = Path(__file__).parents[1]
GRID = {"mass": [0.1, 0.5, 0.9], "distance": [1.0, 200.0]}


def swept(store, **changes):
    arguments = {"setup": circle, "parameters": GRID, "until": 0.5, "measure": angle, "chunk": 2} | changes
    key = {} if store is None else {"key": "circles"}
    return fullbody.sweep(**{**key, **arguments}, store=store)


@pytest.fixture
def unfinished(tmp_path):
    folder = tmp_path / "map"
    swept(folder)
    (folder / "00000004.npz").unlink()
    return folder


def test_a_finished_sweep_is_one_file_that_is_not_written_again(tmp_path):
    result = swept(tmp_path / "map.nc")
    assert_same(result, swept(None))
    assert [path.name for path in tmp_path.iterdir()] == ["map.nc"]
    with xr.open_dataset(tmp_path / "map.nc") as file:
        assert_same(result, file.load())
    # Again: nothing is computed, since nothing may be written.
    content = (tmp_path / "map.nc").read_bytes()
    assert_same(result, swept(tmp_path / "map.nc"))
    assert (tmp_path / "map.nc").read_bytes() == content


def test_a_folder_of_chunks_gives_the_map_of_a_file(tmp_path):
    result = swept(tmp_path / "map")
    names = ["00000000.npz", "00000002.npz", "00000004.npz", "lock", "sweep.json"]
    assert sorted(path.name for path in (tmp_path / "map").iterdir()) == names
    assert_same(result, swept(None))
    assert_same(result, swept(tmp_path / "map"))


def test_a_killed_sweep_computes_only_unfinished_chunks_again(tmp_path):
    total, broken = tmp_path / "whole", tmp_path / "broken"
    total.mkdir()
    broken.mkdir()
    path = os.pathsep.join([str(TESTS), *sys.path])
    # Of 2, 5 and 4 setups, 0, 4 and 2 are those of whole chunks; 6 rows are left.
    command = [sys.executable, TESTS / "support/study.py", f"{total}:0", *(f"{broken}:{die}" for die in (2, 5, 4, 0))]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path})
    assert [int(code) for code in done.stdout.split()] == [0, *[-signal.SIGKILL] * 3, 0]
    assert (broken / "map.nc").read_bytes() == (total / "map.nc").read_bytes()
    rows = [int(row) for row in (broken / "log").read_text().split()]
    assert rows == [*range(2), *range(5), *range(4, 8), *range(6, 12)]
    with xr.open_dataset(total / "map.nc") as result:
        assert result.error.values.tolist() == [""] * 5 + ["ValueError"] + [""] * 6
        assert np.isfinite(result.place.where(result.error == "", 0.0)).all()


def test_a_sweep_resumes_with_another_chunk_size(unfinished):
    assert_same(swept(unfinished, chunk=5), swept(None))


def helper(run):
    return {"angle": 2.0 * angle(run)["angle"]}


def using(run):
    return helper(run)


def scaled(factor):
    return lambda run: {"angle": factor * angle(run)["angle"]}


SAME = {
    "measure": using,
    "setup": functools.partial(circle, distance=1.0),
    "parameters": {"mass": [0.1, 0.5]},
    "integrator": Verner98(1e-9),
    "events": [events.Separation(0, 1, 3.0)],
}


@pytest.fixture(scope="module", params=["map.nc", "map"])
def same(request, tmp_path_factory):
    """A store of a sweep, of which the number of threads is no part."""
    store = tmp_path_factory.mktemp("same") / request.param
    swept(store, **SAME)
    swept(store, **SAME, threads=1)
    return store


@pytest.mark.parametrize(
    ("change", "differences"),
    [
        ({"key": "others"}, "key (circles, here others)"),
        ({"setup": functools.partial(circle, distance=1.5)}, "setup (partial(circle, distance=1.0), here partial("),
        ({"setup": lambda mass: circle(mass)}, "setup (partial(circle, distance=1.0), here"),
        ({"measure": helper}, "measure ([using], here [helper]); source of helper (def helper(run):, here nothing)"),
        ({"measure": scaled(1.0)}, "measure ([using], here [scaled.<locals>.<lambda>]); source of helper"),
        ({"measure": [using, helper]}, "measure ([using], here [using, helper])"),
        ({"until": 0.6}, "until (0.5, here 0.6)"),
        ({"until": lambda mass: 0.5}, "until (0.5, here"),
        ({"output": 0.1}, "output ('ends', here 0.1)"),
        ({"integrator": Verner98(1e-8)}, "integrator (Verner98(rtol=1e-09, atol=1e-13), here Verner98(rtol=1e-08, "),
        ({"integrator": None}, "integrator (Verner98(rtol=1e-09, atol=1e-13), here Verner98(rtol=1e-13, "),
        ({"events": [events.Separation(0, 1, 4.0)]}, "events ([Separation("),
        ({"dense": True}, "dense (False, here True)"),
        ({"derivatives": ["G"]}, "derivatives (False, here ['G'])"),
        ({"chaos": True}, "chaos (False, here True)"),
        ({"parameters": {"mass": [0.1, 0.6]}}, "parameter mass (0.5, here 0.6)"),
        ({"parameters": {"mass": [0.1, 0.6, 0.7]}}, "dimensions (mass: 2, here mass: 3); parameter mass (0.5, here 0"),
        ({"parameters": {"mass": [0.1]}}, "dimensions (mass: 2, here mass: 1); parameter mass (0.5, here nothing)"),
        (
            {"parameters": {"mass": [0.1, 0.5], "distance": [1.0]}},
            "dimensions (nothing, here distance: 1); parameter distance (nothing, here along distance)",
        ),
        (
            {"parameters": fullbody.ensembles.draws(2, mass=lambda rng: 0.1), "rng": 1},
            "rng (None, here 1); dimensions (mass: 2, here draw: 2); parameter mass (along mass, here along draw)",
        ),
    ],
)
def test_a_store_of_another_sweep_is_refused_with_the_differences(same, change, differences):
    text = re.escape(f"{same.name} has a sweep that differs in: {differences}")
    refused(f"{text}.*; expected the same", lambda: swept(same, **{**SAME, **change}))


def test_a_changed_helper_function_is_refused_with_its_name_and_line(tmp_path, monkeypatch):
    swept(tmp_path / "map.nc", **SAME)

    def changed(run):
        return {"angle": 3.0 * angle(run)["angle"]}

    monkeypatch.setitem(globals(), "helper", changed)
    text = r"differs in: source of helper \(def helper\(run\):, here def changed\(run\):\); expected"
    refused(text, lambda: swept(tmp_path / "map.nc", **SAME))


def test_a_store_of_another_version_is_refused(tmp_path, monkeypatch):
    swept(tmp_path / "map.nc")
    monkeypatch.setattr(sys.modules["fullbody.ensembles.sweep"], "version", lambda: "99")
    refused(r"differs in: version of fullbody \(.*, here 99\);", lambda: swept(tmp_path / "map.nc"))


def test_a_store_needs_a_key(tmp_path):
    for key in (None, "", 3):
        with pytest.raises(InvalidInput, match=f"key is {key!r}; expected a text that is not empty, since there is a"):
            swept(tmp_path / "map", key=key)


def test_a_store_needs_a_seed_that_draws_the_same_again(tmp_path):
    draws = fullbody.ensembles.draws(2, mass=lambda rng: rng.uniform())
    with pytest.raises(InvalidInput, match="rng is a generator; expected a whole number with a store"):
        swept(tmp_path / "map", parameters=draws, rng=np.random.default_rng(1))


def test_functions_without_a_source_are_known_by_the_key(tmp_path):
    space = {"angle": angle}
    exec("def measure(run):\n    return angle(run)", space)
    assert_same(swept(tmp_path / "map", measure=space["measure"]), swept(None))
    lock = threading.Lock()

    def locked(run):
        with lock:
            return angle(run)

    assert_same(swept(tmp_path / "locked", measure=locked), swept(None))


def extended(store, computed, parameters, **options):
    """A sweep that counts its setups, and is interrupted at a mass above one until ``ran`` says otherwise."""

    def setup(mass, distance=1.0):
        if mass > 1.0 and "resumed" not in computed:
            raise KeyboardInterrupt
        computed.append((mass, distance))
        return circle(mass, distance)

    return fullbody.sweep(setup, parameters, 0.5, measure=angle, chunk=2, store=store, key="counted", **options)


@pytest.mark.parametrize("store", ["map.nc", "map"])
def test_an_extended_sweep_computes_only_new_rows(tmp_path, store):
    computed = []
    steps = [
        ({"mass": [0.1, 0.5], "distance": 2.0}, 2),
        ({"mass": [0.05, 0.1, 0.3, 0.5], "distance": 2.0}, 2),
        ({"mass": [0.5, 0.3, 0.05, 0.1], "distance": [200.0, 2.0]}, 4),
        ([{"distance": [2.0, 200.0, 3.0] * u.m}, {"mass": [0.1]}], None),
        ({"mass": [0.5, 0.3, 0.05, 0.1], "distance": [2.0, 200.0, 3.0]}, 4),
    ]
    for parameters, more in steps:
        previous = len(computed)
        if more is None:
            with pytest.raises(InvalidInput, match=r"differs in: dimensions .*; parameter .*include all of its rows"):
                extended(tmp_path / store, computed, parameters)
        else:
            result = extended(tmp_path / store, computed, parameters)
            assert len(computed) == previous + more
            assert_same(result, fullbody.sweep(circle, parameters, 0.5, measure=angle))
            # Once more, from the store alone.
            assert_same(extended(tmp_path / store, computed, parameters), result)
            assert len(computed) == previous + more


def test_an_interrupted_extension_resumes(tmp_path):
    computed = []
    extended(tmp_path / "map.nc", computed, {"mass": [0.1, 0.5]})
    for masses in ([0.9, 0.1, 0.8, 0.5, 2.0], [0.7, 0.9, 0.1, 0.8, 0.5, 2.0]):
        with pytest.raises(Interrupted):
            extended(tmp_path / "map.nc", computed, {"mass": masses})
    assert [mass for mass, _ in computed] == [0.1, 0.5, 0.9, 0.8, 0.7]
    computed.append("resumed")
    result = extended(tmp_path / "map.nc", computed, {"mass": [*masses, 0.6]})
    assert [mass for mass, _ in computed[6:]] == [2.0, 0.6]
    assert_same(result, fullbody.sweep(circle, {"mass": [*masses, 0.6]}, 0.5, measure=angle))
    assert [path.name for path in tmp_path.iterdir()] == ["map.nc"]


def test_a_sweep_with_more_draws_keeps_the_first_ones(tmp_path):
    computed = []
    mass = functools.partial(np.random.Generator.uniform, low=0.1, high=0.9)
    draws = functools.partial(fullbody.ensembles.draws, mass=mass)
    extended(tmp_path / "map.nc", computed, draws(3), rng=1)
    result = extended(tmp_path / "map.nc", computed, draws(5), rng=1)
    assert len(computed) == 5
    total = fullbody.sweep(circle, draws(5), 0.5, measure=angle, rng=1)
    assert_same(result, total)
    assert [mass for mass, _ in computed] == result.mass.values.tolist()
    with pytest.raises(InvalidInput, match="differs in: dimensions"):
        extended(tmp_path / "map.nc", computed, [{"distance": [1.0, 2.0]}, draws(5)], rng=1)


def outcome(store):
    """The error of a sweep, or the map as text."""
    try:
        return repr(swept(store).to_dict())
    except InvalidInput as error:
        return str(error)


def test_a_damaged_chunk_is_named(unfinished):
    chunk = unfinished / "00000002.npz"
    total, unbroken = chunk.read_bytes(), outcome(None)
    last = unfinished / "00000004.npz"
    rng = np.random.default_rng(1)
    result = []
    for point in rng.integers(len(total), size=60):
        damaged = bytearray(total)
        damaged[point] ^= 0x10
        chunk.write_bytes(damaged)
        result.append(outcome(unfinished))
        last.unlink(missing_ok=True)
    # The damage may be where nothing stands, such as a date.
    wrong = [text for text in result if text != unbroken]
    assert len(wrong) > 30
    assert {text.split(" cannot ")[0].split(" is ")[0] for text in wrong} == {str(chunk)}
    for size in (0, 10, len(total) // 2, len(total) - 1):
        chunk.write_bytes(total[:size])
        refused(r"00000002.npz is truncated or damaged; if it is deleted", lambda: swept(unfinished))
    chunk.unlink()
    assert_same(swept(unfinished), swept(None))


def test_a_foreign_chunk_is_named(unfinished, tmp_path):
    swept(tmp_path / "other", until=0.4)
    shutil.copy(tmp_path / "other" / "00000002.npz", unfinished)
    refused(r"00000002.npz cannot be used: the chunk belongs to another sweep", lambda: swept(unfinished))
    np.savez(unfinished / "00000002.npz", x=1.0)
    refused(r"00000002.npz is truncated or damaged", lambda: swept(unfinished))
    shutil.copy(unfinished / "00000000.npz", unfinished / "00000002.npz")
    refused(r"00000002.npz has row 0 once more", lambda: swept(unfinished))


def test_files_that_are_no_store_are_refused_and_unchanged(tmp_path):
    run = fullbody.systems.case1()[0].integrate(fullbody.systems.case1()[1], 1.0)
    run.save(tmp_path / "run.nc")
    (tmp_path / "text.nc").write_text("mine")
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "notes.txt").write_text("mine")
    swept(tmp_path / "changed.nc")
    changed = xr.load_dataset(tmp_path / "changed.nc")
    changed.to_netcdf(tmp_path / "changed.nc", engine="h5netcdf")
    previous = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    for name, text in {
        "run.nc": "run.nc is not a sweep's map: the file has no attribute fullbody_sweep",
        "text.nc": "text.nc is not a sweep's map: the file is not a NetCDF file",
        "changed.nc": "changed.nc is not a sweep's map: another program wrote or changed the file",
        "file": "file is a file; expected a folder, or a name that ends in .nc",
        "folder": "folder has notes.txt, but no sweep; expected a new or empty folder",
    }.items():
        refused(text, lambda name=name: swept(tmp_path / name))
    with pytest.raises(FileNotFoundError, match=r"no folder .*nowhere to keep map.nc in"):
        swept(tmp_path / "nowhere" / "map.nc")
    refused("store is 3; expected the name of a file", lambda: swept(3))
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == previous
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "sweep.json").write_text("[1")
    refused("damaged has a damaged description", lambda: swept(tmp_path / "damaged"))


def test_a_store_that_another_process_uses_is_refused(unfinished):
    code = "import fcntl, sys; f = open(sys.argv[1], 'a'); fcntl.lockf(f, fcntl.LOCK_EX); print(1, flush=True); input()"
    command = [sys.executable, "-c", code, unfinished / "lock"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline()
        with pytest.raises(FullbodyError, match=r"another process works on .*map; expected one at a time"):
            swept(unfinished)
        other.stdin.close()
    assert_same(swept(unfinished), swept(None))


def test_temporary_files_of_a_killed_process_are_removed(unfinished):
    left = unfinished / f".00000004.{'0' * 32}.part.npz"
    left.write_bytes(b"half")
    swept(unfinished)
    assert not left.exists()


class _Once:
    """Fails once; pickles and counts as if it had not, for a store looks at what a measure uses."""

    def __init__(self, error):
        self.error, self.left = error, 1

    def __reduce__(self):
        return _Once, ()

    def __call__(self, run):
        if self.left and run.system.masses[1] == 0.9:
            self.left = 0
            raise self.error
        return angle(run)


@pytest.mark.parametrize("store", [None, "map.nc"])
def test_ctrl_c_keeps_finished_rows(tmp_path, store):
    path = store and tmp_path / store
    measure = _Once(KeyboardInterrupt())
    rows = {"mass": [0.1, 0.3, 0.9, 0.5, 0.7]}
    text = rf"2 of 5 rows are done, in {'.*map.nc and in ' if store else ''}.dataset"
    with pytest.raises(Interrupted, match=text) as caught:
        swept(path, measure=measure, parameters=rows, chunk=4)
    assert caught.value.dataset.error.values.tolist() == ["", "", "NotComputed", "NotComputed", "NotComputed"]
    total = swept(None, parameters=rows)
    np.testing.assert_array_equal(caught.value.dataset.angle[:2], total.angle[:2])
    if store:
        assert json.loads((tmp_path / "map.nc.parts" / "sweep.json").read_text())["sweep"]["rng"] == "None"
        assert [path.name for path in tmp_path.rglob("*.npz")] == ["00000000.npz"]
        assert_same(swept(path, measure=measure, parameters=rows), total)


class _During(_Once):
    """An event's function that is interrupted in the middle of a run; runs end in their middle."""

    def __reduce__(self):
        return _During, (None,)

    def __call__(self, state):
        if self.left and np.linalg.norm(state.velocity[1]) > 1.35 and state.time > 0.2:
            self.left = 0
            raise self.error
        return 1.0


def test_ctrl_c_in_a_run_keeps_the_runs_before_it(tmp_path):
    watch = [events.Function(_During(KeyboardInterrupt()))]
    rows = {"mass": [0.1, 0.3, 0.9, 0.5]}
    with pytest.raises(Interrupted) as caught:
        swept(tmp_path / "map", parameters=rows, events=watch, chunk=4, threads=1)
    assert caught.value.dataset.error.values[[0, 2]].tolist() == ["", "NotComputed"]
    assert_same(swept(tmp_path / "map", parameters=rows, events=watch), swept(None, parameters=rows))


def test_a_full_disk_loses_no_finished_chunk(tmp_path, monkeypatch):
    add, calls = stores.Store.add, []

    def full(self, outcomes):
        calls.append(outcomes)
        if len(calls) == 2:
            raise OSError(28, "No space left on device")
        add(self, outcomes)

    monkeypatch.setattr(stores.Store, "add", full)
    with pytest.raises(OSError, match="No space left") as caught:
        swept(tmp_path / "map.nc")
    assert (caught.value.dataset.error != "NotComputed").sum() == 4
    assert "4 of 6 rows are done" in caught.value.__notes__[0]
    assert_same(swept(tmp_path / "map.nc"), swept(None))
