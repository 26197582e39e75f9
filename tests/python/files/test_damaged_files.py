"""Files of runs that are damaged or altered: the right run, or an error that says what is wrong."""

import contextlib
import gc
import hashlib
import sys
import warnings

import fullbody
import h5py
import numpy as np
import pytest
import xarray as xr
from fullbody import events
from fullbody.errors import InvalidInput, UncheckedFile
from support import refused


def small_run(**options):
    system, state = fullbody.systems.case1(**options)
    watched = events.Separation(0, 1, 7.9)
    return system.integrate(state, 10.0, output=2.0, events=[watched])


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A run, and the bytes of its file."""
    run = small_run()
    path = tmp_path_factory.mktemp("written") / "run.nc"
    run.save(path)
    return run, path.read_bytes()


def without_checksum(data):
    """The part of a file that NetCDF reads, as another program would have written it."""
    return data[: data.rindex(b"\nfullbody: sha256")]


def load(path):
    """The run in a file that may lack its checksum, or ``None`` where it is refused."""
    with warnings.catch_warnings(), contextlib.suppress(InvalidInput):
        warnings.simplefilter("ignore", UncheckedFile)
        return fullbody.load(path)
    return None


# The checksum


def test_the_last_line_is_the_checksum_of_all_that_stands_before_it(written):
    data = written[1]
    body, line = without_checksum(data), data[len(without_checksum(data)) :]
    digest = hashlib.sha256(body).hexdigest()
    assert line.decode() == f"\nfullbody: sha256 of the {len(body)} bytes before this line: {digest}\n"


def test_other_programs_read_a_file_with_checksum(written, tmp_path):
    run, data = written
    path = tmp_path / "run.nc"
    path.write_bytes(data)
    position = run.position
    with xr.open_dataset(path, decode_times=False) as dataset:
        assert np.array_equal(dataset.position.values, position)
        assert dataset.attrs["stop_reason"] == "end"
    with h5py.File(path, "r") as file:
        assert np.array_equal(file["position"][...], position)
    assert path.read_bytes() == data


def test_a_file_without_checksum_is_read_with_a_warning(written, tmp_path):
    run, data = written
    path = tmp_path / "run.nc"
    path.write_bytes(without_checksum(data))
    with pytest.warns(UncheckedFile, match=r"run\.nc has no checksum of the whole file: another program wrote it"):
        assert fullbody.load(path) == run
    # Saved again, it has one.
    load(path).save(path)
    assert fullbody.load(path) == run


def test_a_program_that_writes_into_a_file_takes_its_checksum_away(written, tmp_path):
    path = tmp_path / "run.nc"
    for change in ("nothing", "number", "text"):
        path.write_bytes(written[1])
        with h5py.File(path, "r+") as file:
            if change == "number":
                file["position"][1, 0, 0] = 0.25
            elif change == "text":
                file.attrs["mine"] = "words " * 500
        with pytest.warns(UncheckedFile):
            run = fullbody.load(path)
        assert (run.position[1, 0, 0] == 0.25) == (change == "number")


def test_a_file_edited_with_xarray_loads(written, tmp_path):
    run = written[0]
    (tmp_path / "run.nc").write_bytes(written[1])
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as dataset:
        few = dataset.isel(time=slice(1, 3)).assign(mine=("time", [1.0, 2.0])).assign_attrs(title="mine")
        few.to_netcdf(tmp_path / "few.nc", engine="h5netcdf")
        dataset.isel(time=slice(0)).to_netcdf(tmp_path / "none.nc", engine="h5netcdf")
    run.to_xarray().to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    assert load(tmp_path / "old.nc") == run
    assert load(tmp_path / "few.nc") == run[1:3]
    assert len(load(tmp_path / "none.nc")) == 0


# Damage


def test_zeros_instead_of_any_block_are_refused(written, tmp_path):
    run, data = written
    path = tmp_path / "run.nc"
    for first in range(0, len(data), 512):
        altered = bytearray(data)
        altered[first : first + 512] = bytes(len(altered[first : first + 512]))
        path.write_bytes(altered)
        if altered == data:
            assert fullbody.load(path) == run
        else:
            refused(r"run\.nc is not a readable run of fullbody: the file is ", lambda: fullbody.load(path))


def test_every_truncation_is_refused(written, tmp_path):
    data = written[1]
    path = tmp_path / "run.nc"
    size = len(without_checksum(data))
    for length in [*range(0, size, 997), size - 1, *range(size + 1, len(data), 13), len(data) - 1]:
        path.write_bytes(data[:length])
        refused(r"the file is (empty|not a NetCDF file|truncated or damaged)", lambda: fullbody.load(path))
    for longer in (b"\n", b"x", bytes(512)):
        path.write_bytes(data + longer)
        refused("the checksum at its end does not fit", lambda: fullbody.load(path))


def test_a_damaged_file_is_reported_once(written, tmp_path, monkeypatch):
    ignored = []
    monkeypatch.setattr(sys, "unraisablehook", ignored.append)
    path = tmp_path / "run.nc"
    # The header of the outermost group.
    path.write_bytes(without_checksum(written[1]).replace(b"OHDR", b"XHDR", 1))
    refused("is truncated or damaged", lambda: fullbody.load(path))
    gc.collect()
    assert ignored == []


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"^no file .*missing\.nc$"):
        fullbody.load(tmp_path / "missing.nc")
    refused("the file is a folder", lambda: fullbody.load(tmp_path))


@pytest.mark.parametrize("path", [None, 3, b"run.nc", "run\0.nc", "run\ud800.nc", ["run.nc"]])
def test_values_that_are_no_path_are_refused(path):
    for use in (fullbody.load, fullbody.Simulation.load, fullbody.read_toml, fullbody.read_sians, fullbody.read_gubas):
        refused(r"^path is .*; expected the name of a file", lambda use=use: use(path))
    for save in (small_run().save, fullbody.Simulation(*fullbody.systems.case1()).save):
        refused(r"^path is .*; expected the name of a file", lambda save=save: save(path))
