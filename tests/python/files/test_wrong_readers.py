"""Files that are given to the wrong reader: the error says what they are and what reads them."""

import fullbody
import pytest
import xarray as xr
from fullbody.errors import InvalidInput

READERS = {
    "fullbody.load": fullbody.load,
    "fullbody.load_flight": fullbody.load_flight,
    "fullbody.Simulation.load": fullbody.Simulation.load,
    "fullbody.Polyhedron.load": fullbody.Polyhedron.load,
    "fullbody.read_toml": fullbody.read_toml,
}


def made(system, state, folder):
    """Write a file of each kind, and return its path and its right reader by what it is."""
    run = system.integrate(state, 1.0, output="ends")
    run.save(folder / "run.nc")
    particle = fullbody.Particles([[9.0, 0.0, 0.0]], [[0.0, 0.1, 0.0]])
    system.fly(state, particle, 0.1).save(folder / "flight.nc")
    fullbody.Simulation(system, state).save(folder / "simulation.fb")
    xr.Dataset(attrs={"fullbody_fit": 1}).to_netcdf(folder / "fit.nc", engine="h5netcdf")
    setup = lambda x: (system, state)  # noqa: E731
    result = fullbody.sweep(setup, {"x": [1.0, 2.0]}, 0.1, measure=lambda run: {"steps": len(run)}, output="ends")
    result.to_netcdf(folder / "map.nc", engine="h5netcdf")
    (folder / "system.toml").write_text("[system]\nG = 1.0\n")
    (folder / "alpha.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    return {
        "a run": ("run.nc", "fullbody.load"),
        "a flight": ("flight.nc", "fullbody.load_flight"),
        "a simulation": ("simulation.fb", "fullbody.Simulation.load"),
        "a fit": ("fit.nc", "fullbody.load"),
        "a map": ("map.nc", "xarray.load_dataset"),
        "a system as text": ("system.toml", "fullbody.read_toml"),
        "a shape": ("alpha.obj", "fullbody.Polyhedron.load"),
    }


def test_every_reader_names_the_right_one_for_every_other_file(tmp_path):
    for kind, (name, reader_of_kind) in made(*fullbody.systems.case1(), tmp_path).items():
        for reader, read in READERS.items():
            what, right = kind, reader_of_kind
            if reader != right:
                with pytest.raises(InvalidInput) as caught:
                    read(tmp_path / name)
                if name.endswith(".nc") and not reader.startswith("fullbody.load"):
                    # HDF5 is not to open what may be damaged.
                    what, right = "NetCDF, as of runs, fits and flights", "fullbody.load or fullbody.load_flight"
                assert str(caught.value).endswith(f"; it is {what}, which {right} reads"), (name, reader)


def test_the_error_of_a_damaged_file_names_no_other_reader(tmp_path):
    system, state = fullbody.systems.case1()
    system.integrate(state, 1.0, output="ends").save(tmp_path / "run.nc")
    content = (tmp_path / "run.nc").read_bytes()
    (tmp_path / "run.nc").write_bytes(content[:-100])
    with pytest.raises(InvalidInput, match="is not a readable run of fullbody: the file is truncated") as caught:
        fullbody.load(tmp_path / "run.nc")
    assert "which" not in str(caught.value)
