"""Runs as files and datasets: exact, atomic, with units; what cannot be read says which file."""

import gc
import subprocess
import sys
import textwrap
from pathlib import Path

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Body, Ellipsoid, PointMass, Sphere
from fullbody._files import replacing

NAMES = ("time", "position", "velocity", "attitude", "spin", "energy", "angular_momentum", "potential_energy")


def small_run(**options):
    system, state = fullbody.systems.case1(**options)
    return system.integrate(state, 10.0, output=2.0)


def other_runs():
    bodies = [
        Body(Ellipsoid(0.3, 0.2, 0.1), density=1.1, name="Größe 1999 KW₄"),
        Body(Sphere(0.1), mass=1 / 3),
        Body(PointMass(), mass=1e-7, name="probe"),
    ]
    three = fullbody.State(
        [[0, 0, 0], [3, 0, 0], [0, 7, 1]],
        [[0, 0, 0], [0, 0.3, 0], [0.2, 0, 0]],
        spin=[[0.1, 0.2, 0.3]] * 3,
        time=-1 / 3,
    )
    system = fullbody.System(bodies, G=np.pi, gravity_tolerance=1e-13, vector_path="portable")
    with_units, state = fullbody.systems.kw4(units=True, gravity="surface", order=(8, 16))
    with_quantities = fullbody.System(
        [Body(Sphere(100 * u.m), density=2 * u.g / u.cm**3), Body(PointMass(), mass=1 * u.t)],
        units=("km", "hour", "kg"),
    )
    pair = fullbody.State([[0, 0, 0], [1, 0, 0]] * u.km, np.zeros((2, 3)) * u.km / u.s)
    return {
        "plain": small_run(),
        "tait_bryan": small_run(attitude_chart="tait_bryan", gravity="multipole:4"),
        "three bodies": system.integrate(three, 1.0, integrator=fullbody.Verner98(rtol=1e-9, atol=0)),
        "units": with_units.integrate(state, 3 * u.hour, output=1 * u.hour),
        "bodies of quantities": with_quantities.integrate(pair, 0.01),
        "backwards": fullbody.systems.case2()[0].integrate(fullbody.systems.case2()[1], -3.0),
        "no samples": fullbody.systems.case2()[0].integrate(fullbody.systems.case2()[1], 3.0, output=[]),
    }


@pytest.mark.parametrize("name", other_runs())
def test_load_gives_back_every_bit(name, tmp_path):
    run = other_runs()[name]
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    for part in NAMES:
        assert np.array_equal(getattr(again, part), getattr(run, part)), part
        assert getattr(getattr(again, part), "unit", None) == getattr(getattr(run, part), "unit", None)
    assert again == run
    assert again.system == run.system
    assert again.statistics == run.statistics
    assert again.integrator == run.integrator
    assert again.system.names == run.system.names
    if len(run):
        assert again[-1] == run[-1]


def test_a_loaded_run_goes_on_with_the_same_bits(tmp_path):
    run = small_run()
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again.system.integrate(again[-1], 20.0) == run.system.integrate(run[-1], 20.0)


def test_path_may_be_text_and_relative(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    small_run().save("run.nc")
    assert fullbody.load("run.nc") == small_run()
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_saving_again_replaces(tmp_path):
    path = tmp_path / "run.nc"
    small_run().save(path)
    other = small_run(gravity="surface")
    other.save(path)
    assert fullbody.load(path) == other


def test_a_failing_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    """The disk fills up while the dataset is written: half of it is there, then an error."""
    import xarray as xr

    path = tmp_path / "run.nc"
    small_run().save(path)
    before = path.read_bytes()
    original = xr.Dataset.to_netcdf

    def full(self, target=None, *args, **options):
        original(self, target, *args, **options)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", full)
    with pytest.raises(OSError, match="No space left"):
        small_run(gravity="surface").save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_a_full_disk_is_an_error_and_not_the_end_of_the_session(tmp_path):
    """In a process that may write no more than 30 kB to a file: HDF5 itself would end it by a segmentation fault."""
    path = tmp_path / "run.nc"
    path.write_bytes(b"old")
    script = f"""
        import resource, signal
        import fullbody
        system, state = fullbody.systems.case1()
        run = system.integrate(state, 10.0, output=0.02)
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (30000, resource.RLIM_INFINITY))
        try:
            run.save({str(path)!r})
        except OSError as error:
            print(error.filename, len(run))
    """
    ended = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.strip()) == (0, f"{path} 501"), ended.stderr
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_numbers_lost_in_a_file_are_refused(tmp_path):
    """A damaged table of contents lets HDF5 give its filling, NaN, in place of numbers."""
    import xarray as xr

    path = tmp_path / "run.nc"
    small_run().save(path)
    with xr.open_dataset(path, decode_times=False) as dataset:
        whole = dataset.load()
    for name in ("energy", "angular_momentum"):
        lost = whole.copy(deep=True)
        lost[name][1] = np.nan
        lost.to_netcdf(path, engine="h5netcdf")
        with pytest.raises(fullbody.InvalidInput, match=rf"{name}\[1, 0\] is nan; expected finite numbers"):
            fullbody.load(path)


def test_a_folder_that_does_not_exist(tmp_path):
    with pytest.raises(OSError, match="nowhere"):
        small_run().save(tmp_path / "nowhere" / "run.nc")


def damaged(kind, path):
    if kind == "empty":
        path.write_bytes(b"")
    elif kind == "text":
        path.write_text("time,x,y,z\n0,1,2,3\n")
    elif kind.startswith("truncated"):
        small_run().save(path)
        data = path.read_bytes()
        path.write_bytes(data[: int(len(data) * float(kind.split()[1]))])
    elif kind == "classic":
        from scipy.io import netcdf_file

        with netcdf_file(path, "w") as file:
            file.createDimension("t", 2)
    elif kind == "simulation":
        fullbody.Simulation(*fullbody.systems.case1()).save(path)
    elif kind == "foreign":
        import xarray as xr

        xr.Dataset({"x": ("t", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    else:
        import xarray as xr

        dataset = small_run().to_xarray()
        if kind == "no spin":
            dataset = dataset.drop_vars("spin")
        elif kind == "broken setup":
            dataset.attrs["fullbody_setup"] = dataset.attrs["fullbody_setup"][:-20]
        elif kind == "other setup":
            dataset.attrs["fullbody_setup"] = '{"bodies": []}'
        elif kind == "unknown shape":
            dataset.attrs["fullbody_setup"] = dataset.attrs["fullbody_setup"].replace("Ellipsoid", "Potato")
        elif kind == "no format":
            del dataset.attrs["fullbody_format"]
        elif kind == "newer":
            dataset.attrs["fullbody_format"] = 99
        elif kind.startswith("junk "):
            dataset.attrs[kind.removeprefix("junk ")] = "junk{"
        elif kind.startswith("not finite "):
            name = kind.removeprefix("not finite ")
            values = dataset[name].values.copy()
            values[(3,) + (1,) * (values.ndim - 1)] = np.inf if name == "spin" else np.nan
            dataset[name] = (dataset[name].dims, values)
        elif kind == "wrong shape":
            dataset = dataset.drop_vars("spin").assign(spin=("time", np.zeros(6)))
        elif kind == "text for numbers":
            dataset = dataset.drop_vars("spin").assign(spin=("time", ["a"] * 6))
        dataset.to_netcdf(path, engine="h5netcdf")


DAMAGE = {
    "empty": "it is empty",
    "text": "it is not a NetCDF file",
    "truncated 0.1": "it is truncated or damaged",
    "truncated 0.5": "it is truncated or damaged",
    "truncated 0.97": "it is truncated or damaged",
    "foreign": "it has no attribute fullbody_format",
    "classic": "it is NetCDF of the classic kind; runs are NetCDF-4",
    "simulation": "it is a simulation; fullbody.Simulation.load reads it",
    "no spin": "it has no variable spin",
    "broken setup": "",
    "other setup": "it has no ",
    "unknown shape": "it has no 'Potato'",
    "no format": "it has no attribute fullbody_format",
    "newer": "a newer fullbody wrote it",
    "junk fullbody_format": "attribute fullbody_format is 'junk{'; expected a whole number above zero",
    "junk fullbody_setup": "attribute fullbody_setup is no JSON: Expecting value",
    "junk fullbody_statistics": "attribute fullbody_statistics is no JSON: Expecting value",
    "junk fullbody_events": "attribute fullbody_events is no JSON: Expecting value",
    "not finite time": r"time\[3\] is nan; expected finite numbers",
    "not finite position": r"position\[3, 1, 1\] is nan; expected finite numbers",
    "not finite velocity": r"velocity\[3, 1, 1\] is nan; expected finite numbers",
    "not finite attitude": r"attitude\[3, 1, 1\] is nan; expected finite numbers",
    "not finite spin": r"spin\[3, 1, 1\] is inf; expected finite numbers",
    "wrong shape": r"spin has shape \(6,\); expected \(6, 2, 3\)",
    "text for numbers": "",
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_what_is_no_run_is_refused_with_its_path_and_what_is_wrong(kind, tmp_path):
    path = tmp_path / "damaged.nc"
    damaged(kind, path)
    with pytest.raises(fullbody.InvalidInput, match=rf"damaged\.nc is not a readable run of fullbody: {DAMAGE[kind]}"):
        fullbody.load(path)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"^no file .*missing\.nc$"):
        fullbody.load(tmp_path / "missing.nc")
    with pytest.raises(fullbody.InvalidInput, match="it is a folder"):
        fullbody.load(tmp_path)


@pytest.mark.parametrize("name", ["run.txt", "run", "run.nc.gz", "run.sim"])
def test_names_of_other_kinds_of_files_are_refused(name, tmp_path):
    with pytest.raises(fullbody.InvalidInput, match=rf"{name}'; expected a name that ends in one of \.nc, \.nc4"):
        small_run().save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    for good in ("run.nc", "RUN.NC4"):
        small_run().save(tmp_path / good)


def test_dataset_has_names_units_and_provenance():
    system, state = fullbody.systems.kw4(units=True)
    run = system.integrate(state, 2.0, output=1.0)
    data = run.to_xarray()
    assert dict(data.sizes) == {"time": 3, "body": 2, "axis": 3, "quaternion": 4, "part": 4}
    assert data.body.values.tolist() == ["Alpha", "Beta"]
    assert data.axis.values.tolist() == ["x", "y", "z"]
    assert data.quaternion.values.tolist() == ["w", "x", "y", "z"]
    units = {
        "time": u.hour,
        "position": u.km,
        "velocity": u.km / u.hour,
        "spin": u.rad / u.hour,
        "energy": u.kg * u.km**2 / u.hour**2,
        "angular_momentum": u.kg * u.km**2 / u.hour,
    }
    for name, unit in units.items():
        assert u.Unit(data[name].attrs["units"]) == unit, name
        assert data[name].attrs["long_name"]
    assert np.array_equal(data.position.sel(body="Beta", axis="y"), run.position[:, 1, 1].value)
    assert np.array_equal(data.energy.sel(part="total"), run.energy.value)
    assert fullbody.__version__ in data.attrs.values()
    assert any("Ho, Wold" in str(value) for value in data.attrs.values())


def test_dataset_without_units_claims_none():
    data = small_run().to_xarray()
    assert not any("units" in data[name].attrs for name in data.variables)


def test_an_interrupted_run_can_be_saved(tmp_path):
    """What an error leaves behind is a run like any other."""
    system = fullbody.System([Body(Sphere(1.0), mass=1.0), Body(Sphere(1.0), mass=1.0)], G=1.0)
    with pytest.raises(fullbody.BodiesOverlap) as caught:
        system.integrate(fullbody.State([[0, 0, 0], [5, 0, 0]], np.zeros((2, 3))), 100.0)
    caught.value.run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc") == caught.value.run


def test_an_altered_number_is_refused(tmp_path):
    """A flipped bit in each variable's numbers, wherever they lie in the file."""
    run = small_run()
    path = tmp_path / "run.nc"
    run.save(path)
    data = path.read_bytes()
    for values in run._record.values():
        where = data.index(values.tobytes())
        for offset in (0, values.nbytes // 2, values.nbytes - 1):
            altered = bytearray(data)
            altered[where + offset] ^= 1
            path.write_bytes(altered)
            with pytest.raises(fullbody.InvalidInput, match=r"run\.nc is not .*: it is truncated or damaged"):
                fullbody.load(path)


def test_an_altered_byte_never_gives_another_run(tmp_path):
    run = small_run()
    path = tmp_path / "run.nc"
    run.save(path)
    data = path.read_bytes()
    random = np.random.default_rng(1)
    for place in random.integers(len(data), size=40):
        altered = bytearray(data)
        altered[place] ^= int(random.integers(1, 256))
        path.write_bytes(altered)
        try:
            again = fullbody.load(path)
        except fullbody.InvalidInput:
            continue
        assert again == run, place


@pytest.mark.parametrize(("old", "new"), [(b'"mass": ', b'"maff": '), (b'"G": 1.0', b'"G": 2.0')])
def test_an_altered_setup_is_refused(old, new, tmp_path):
    path = tmp_path / "run.nc"
    small_run().save(path)
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new))
    with pytest.raises(
        fullbody.InvalidInput, match=r"run\.nc is not .*(it has no 'mass'|fullbody_checksum does not fit)"
    ):
        fullbody.load(path)


def test_files_without_checksums_load(tmp_path):
    """As earlier versions and other programs write them."""
    run = small_run()
    run.to_xarray().to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    assert fullbody.load(tmp_path / "old.nc") == run


def test_a_file_edited_with_xarray_loads(tmp_path):
    import xarray as xr

    run = small_run()
    run.save(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as dataset:
        assert dataset.position.encoding["fletcher32"]
        few = dataset.isel(time=slice(1, 3)).assign(mine=("time", [1.0, 2.0])).assign_attrs(title="mine")
        few.to_netcdf(tmp_path / "few.nc", engine="h5netcdf")
        dataset.isel(time=slice(0)).to_netcdf(tmp_path / "none.nc", engine="h5netcdf")
    assert fullbody.load(tmp_path / "few.nc") == run[1:3]
    assert len(fullbody.load(tmp_path / "none.nc")) == 0


def test_a_damaged_file_is_told_once(tmp_path, monkeypatch):
    """Nothing on standard error from objects that the libraries left half made."""
    ignored = []
    monkeypatch.setattr(sys, "unraisablehook", ignored.append)
    path = tmp_path / "run.nc"
    small_run().save(path)
    data = path.read_bytes()
    # The header of the outermost group.
    path.write_bytes(data.replace(b"OHDR", b"XHDR", 1))
    with pytest.raises(fullbody.InvalidInput, match="it is truncated or damaged"):
        fullbody.load(path)
    gc.collect()
    assert ignored == []


# Places that cannot be written


def forbid(monkeypatch):
    """As in a folder where nobody may make a file; the tests may run as a user whom nothing is forbidden."""

    def refuse(path, *_, **__):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "touch", refuse)


WRITERS = {
    "run.nc": lambda run, path: run.save(path),
    "run.sim": lambda run, path: fullbody.Simulation(*fullbody.systems.case1()).save(path),
    "film.gif": lambda run, path: run.animate(path, seconds=0.1, fps=10, size=(1, 1), dpi=20),
    "film.html": lambda run, path: run.animate(path, seconds=0.1, fps=10, size=(1, 1), dpi=20),
    "view.html": lambda run, path: run.view().save_html(path),
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.filterwarnings("ignore:.*turns between two")
def test_a_place_that_cannot_be_written_is_named_as_it_was_given(name, tmp_path, monkeypatch):
    run, path = small_run(), tmp_path / name
    path.mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        WRITERS[name](run, path)
    assert str(caught.value) == f"[Errno 21] Is a directory: '{path}'"
    path.rmdir()
    forbid(monkeypatch)
    with pytest.raises(PermissionError) as caught:
        WRITERS[name](run, path)
    assert str(caught.value) == f"[Errno 13] Permission denied: '{path}'"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "error",
    [
        lambda path: PermissionError(13, "Permission denied", str(path)),
        lambda path: OSError(f"unable to create file (name = '{path}')"),
        lambda path: OSError(28, "No space left on device"),
    ],
    ids=["python", "unnumbered", "nameless"],
)
def test_errors_while_writing_name_the_wanted_path(error, tmp_path):
    path = tmp_path / "run.nc"
    with pytest.raises(OSError, match=r"run\.nc") as caught, replacing(path) as temporary:
        raise error(temporary)
    assert str(path) in str(caught.value)
    assert temporary.name not in str(caught.value)
    assert "HDF5" not in str(caught.value)
    if "Permission" in str(error(path)):
        assert type(caught.value) is PermissionError
    # Errors about other files stay as they are.
    other = FileNotFoundError(2, "No such file or directory", "ffmpeg")
    with pytest.raises(FileNotFoundError) as caught, replacing(path):
        raise other
    assert caught.value is other


def test_a_file_that_hdf5_cannot_make(tmp_path, monkeypatch):
    """HDF5's own text, from a folder that vanishes between the first look and the writing."""
    folder = tmp_path / "folder"
    folder.mkdir()

    def vanish(path, *_, **__):
        folder.rmdir()

    monkeypatch.setattr(Path, "touch", vanish)
    monkeypatch.setattr(Path, "unlink", lambda *_, **__: None)
    with pytest.raises(FileNotFoundError) as caught:
        small_run().save(folder / "run.nc")
    assert str(caught.value) == f"[Errno 2] No such file or directory: '{folder / 'run.nc'}'"
