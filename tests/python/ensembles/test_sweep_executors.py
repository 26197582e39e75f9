"""Sweeps with executors: threads, processes, clusters; and workers that die."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import fullbody
import numpy as np
import pytest
from fullbody import FullbodyError
from fullbody.errors import Interrupted, InvalidInput
from support.maps import angle, assert_same, circle

DATA = Path(__file__).parents[2] / "data"
SPAWN = multiprocessing.get_context("spawn")


def swept(**changes):
    arguments = {"setup": circle, "parameters": {"mass": np.linspace(0.1, 0.9, 7)}, "until": 0.5, "measure": angle}
    key = {"key": "circles"} if "store" in changes else {}
    return fullbody.sweep(**{**arguments, **key, "chunk": 2, **changes})


def random(mass, rng):
    return circle(mass, rng.uniform(1.0, 2.0))


class Inline:
    """The interface of concurrent.futures alone. Calls whose turn is in ``failing`` have the error instead."""

    def __init__(self, failing=(), error=None):
        self.failing, self.error, self.calls = failing, error, 0

    def submit(self, function, *args):
        future = Future()
        self.calls += 1
        if self.calls in self.failing:
            future.set_exception(self.error)
        else:
            future.set_result(function(*args))
        return future


def test_threads_give_the_map_of_one_process():
    with ThreadPoolExecutor(2) as executor:
        held = threading.Lock()

        def measure(run):
            with held:
                return angle(run)

        assert_same(swept(executor=executor, measure=measure), swept())
        assert_same(swept(executor=executor, setup=random, rng=1), swept(setup=random, rng=1, chunk=5))


@pytest.fixture(scope="module")
def processes():
    with ProcessPoolExecutor(2, mp_context=SPAWN) as executor:
        yield executor


def test_processes_give_the_map_of_one_process(processes, tmp_path):
    # Functions that are no module's go there whole.
    power = 2.0
    result = swept(
        executor=processes,
        setup=lambda mass, rng: random(mass, rng),
        measure=lambda run: {"angle": angle(run)["angle"] ** power, "process": float(os.getpid() == parent)},
        rng=12,
        store=tmp_path / "map.nc",
    )
    in_process = swept(setup=random, rng=12)
    np.testing.assert_array_equal(result.angle, in_process.angle**2)
    assert (result.process == 0.0).all()


parent = os.getpid()


def test_an_error_in_a_worker_affects_no_other_row(processes):
    def setup(mass):
        if mass > 0.8:
            raise SystemExit("no more")
        return circle(mass)

    result = swept(executor=processes, setup=setup)
    assert result.error.values.tolist() == [""] * 6 + ["SystemExit"]
    with pytest.raises(InvalidInput, match=r"the sweep cannot be sent to other processes: .*lock"):
        swept(executor=processes, setup=lambda mass, lock=threading.Lock(): circle(mass))  # noqa: B008


def test_workers_take_one_thread_each():
    threads = []

    class Spy(Inline):
        def submit(self, function, *args):
            threads.append(__import__("cloudpickle").loads(function.args[0]).options["threads"])
            return super().submit(function, *args)

    swept(executor=Spy())
    swept(executor=Spy(), threads=3)
    assert threads == [1] * 4 + [3] * 4


def test_a_chunk_that_fails_is_submitted_again():
    executor = Inline((2, 3), RuntimeError("a worker was lost"))
    assert_same(swept(executor=executor), swept())
    assert executor.calls == 6


def test_a_chunk_that_fails_everywhere_is_an_error(tmp_path):
    executor = Inline((2, 5, 6), RuntimeError("a worker was lost"))
    text = r"rows 2 to 3 failed in 3 workers, .* RuntimeError: a worker was lost"
    with pytest.raises(FullbodyError, match=text) as caught:
        swept(executor=executor, store=tmp_path / "map.nc")
    assert (caught.value.dataset.error == "NotComputed").values.tolist() == [False] * 2 + [True] * 2 + [False] * 3
    assert len(list((tmp_path / "map.nc.parts").glob("*.npz"))) == 3
    assert_same(swept(store=tmp_path / "map.nc"), swept())


def test_an_executor_that_is_shut_down_is_an_error_with_the_map_so_far():
    class Closing(Inline):
        def submit(self, function, *args):
            if self.calls == 2:
                raise RuntimeError("cannot schedule new futures after shutdown")
            return super().submit(function, *args)

    with pytest.raises(FullbodyError, match=r"takes no work: cannot .*; expected one that is not shut down") as caught:
        swept(executor=Closing())
    assert (caught.value.dataset.error == "").values.tolist() == [True] * 4 + [False] * 3


def test_the_progress_bar_of_a_sweep_counts_rows(capsys):
    for executor in (None, Inline()):
        swept(executor=executor, setup=lambda mass: circle(mass) if mass < 0.8 else None, progress="a map")
        text = capsys.readouterr().err.split("\r")[-1]
        assert "a map: 100%" in text
        assert "7 of 7 rows" in text
        assert "1 with errors" in text


def test_ctrl_c_in_a_worker_ends_the_sweep():
    with pytest.raises(Interrupted) as caught:
        swept(executor=Inline((3,), KeyboardInterrupt()))
    # Rows that were done at the interrupt are kept.
    assert (caught.value.dataset.error == "NotComputed").values.tolist() == [False] * 4 + [True] * 2 + [False]


def test_an_interrupt_cancels_waiting_chunks():
    held = []

    class Slow(Inline):
        def submit(self, function, *args):
            held.append(Future() if held else super().submit(function, *args))
            return held[-1]

    with pytest.raises(Interrupted):
        swept(executor=Slow((1,), KeyboardInterrupt()))
    assert [future.cancelled() for future in held] == [False, True, True, True]


def dying(folder):
    def setup(mass):
        if mass > 0.6 and not os.path.exists(f"{folder}/died"):
            Path(folder, "died").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return circle(mass)

    return setup


def test_rows_of_a_dead_process_are_computed_again(tmp_path):
    setup = dying(tmp_path)
    with ProcessPoolExecutor(1, mp_context=SPAWN) as executor:
        with pytest.raises(FullbodyError, match="has lost a worker, by a crash or for want of memory") as caught:
            swept(setup=setup, executor=executor, store=tmp_path / "map.nc")
        assert (caught.value.dataset.error == "NotComputed").values.tolist() == [False] * 4 + [True] * 3
        assert "4 of 7 rows are done" in caught.value.__notes__[0]
    assert_same(swept(setup=setup, store=tmp_path / "map.nc"), swept())


@pytest.mark.timeout(120)
def test_rows_of_a_dead_worker_of_dask_are_computed_by_another(tmp_path):
    subprocess.run([sys.executable, DATA / "cluster.py", tmp_path], check=True, timeout=110)
    assert (tmp_path / "died").exists()
    assert (tmp_path / "dask.nc").read_bytes() == (tmp_path / "alone.nc").read_bytes()
    rows, workers = zip(*(line.split() for line in (tmp_path / "log of dask").read_text().splitlines()), strict=True)
    # Rows that the dead worker had not returned are computed again, but are in the map once.
    assert set(rows) == {str(row) for row in range(12)}
    assert rows.count("5") >= 2
    assert len(set(workers)) >= 2
    # An active client does not keep a run from its file.
    assert len(fullbody.load(tmp_path / "run.nc"))
