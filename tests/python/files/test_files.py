"""Runs as files and as tables of other libraries."""

import os
import stat

import fullbody
import numpy as np
import pytest
from support import refused


def test_pandas_holds_every_number(kw4_run):
    frame = kw4_run.to_pandas()
    assert frame.shape == (101, 2 * 13 + 4 + 3)
    assert np.array_equal(frame.index, kw4_run.time.value)
    for k, name in enumerate(("Alpha", "Beta")):
        assert np.array_equal(frame["position", name], kw4_run.position.value[:, k])
        assert np.array_equal(frame["attitude", name][["w", "x", "y", "z"]], kw4_run.attitude[:, k])
        assert np.array_equal(frame["spin", name, "z"], kw4_run.spin.value[:, k, 2])
    assert np.array_equal(frame["energy", "", "potential"], kw4_run.potential_energy.value)
    assert np.array_equal(frame["angular_momentum", "", "y"], kw4_run.angular_momentum.value[:, 1])
    assert frame.columns.is_unique
    assert frame.attrs["units"]["velocity"] == "km / h"
    assert frame.attrs["units"]["time"] == "h"


def test_pandas_without_units_and_names(triple_run):
    frame = triple_run.to_pandas()
    assert np.array_equal(frame["position", "body 1", "x"], triple_run.position[:, 1, 0])
    assert frame.attrs["units"] == {}


def test_pandas_without_samples(kw4_run):
    empty = kw4_run[:0].to_pandas()
    assert empty.shape == (0, 2 * 13 + 4 + 3)
    assert empty.columns.equals(kw4_run.to_pandas().columns)


def test_xarray_and_pandas_agree(case1_run):
    dataset, frame = case1_run.to_xarray(), case1_run.to_pandas()
    assert np.array_equal(dataset["spin"].sel(body="B", axis="x"), frame["spin", "B", "x"])


def test_saved_file_is_whole_and_readable_by_others(kw4_run, tmp_path):
    path = tmp_path / "run.nc"
    mask = os.umask(0o022)
    try:
        kw4_run.save(path)
    finally:
        os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o644
    assert fullbody.load(path) == kw4_run
    assert list(tmp_path.iterdir()) == [path]


def test_failed_save_leaves_the_old_file(kw4_run, tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    kw4_run.save(path)
    before = path.read_bytes()
    monkeypatch.setattr("xarray.Dataset.dump_to_store", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        kw4_run.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(FileNotFoundError, match="no folder"):
        kw4_run.save(tmp_path / "nowhere" / "run.nc")


def test_settings_of_any_integrator_are_kept(kw4_run, tmp_path):
    from astropy import units as u

    system, state = fullbody.systems.kw4(units=True)
    run = system.integrate(state, 1.0, integrator=fullbody.SymplecticSplitting(30 * u.min, "ABA1064"))
    run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc").integrator == fullbody.SymplecticSplitting(0.5, "ABA1064")

    toml = tmp_path / "fixed.toml"
    setup = (
        "[system]\nG = 1.0\n[[body]]\nradius = 1.0\nmass = 1.0\n"
        "[integrator]\nname = 'LieGroupVariational'\n{}\n[run]\nuntil = 1.0\n"
    )
    toml.write_text(setup.format("step = 0.1"))
    assert fullbody.read_toml(toml).integrator == fullbody.LieGroupVariational(0.1)
    toml.write_text(setup.format(""))
    refused(r"integrator\.step: is missing; LieGroupVariational needs it", lambda: fullbody.read_toml(toml))


def test_an_unknown_integrator_is_named(kw4_run, tmp_path, monkeypatch):
    kw4_run.save(tmp_path / "run.nc")
    monkeypatch.setattr(fullbody.record.integrators, "__all__", [])
    refused(r"run\.nc is not .*integrator is 'Verner98'; expected one of ", lambda: fullbody.load(tmp_path / "run.nc"))
