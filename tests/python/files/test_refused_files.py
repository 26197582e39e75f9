"""Files whose content is no run are refused; the error names the file, the entry and the expectation."""

import json

import fullbody
import h5py
import numpy as np
import pytest
import xarray as xr
from fullbody import events, loading
from fullbody.files import reading
from support import refused


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.case1()
    return system.integrate(state, 10.0, output=2.0, events=[events.Separation(0, 1, 7.9)])


# Files that are no runs


def classic(path):
    from scipy.io import netcdf_file

    with netcdf_file(path, "w") as file:
        file.createDimension("t", 2)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: path.write_bytes(b""), "the file is empty"),
        (lambda path: path.write_text("time,x,y,z\n0,1,2,3\n"), "the file is not a NetCDF file"),
        (lambda path: xr.Dataset({"x": ("t", [1.0])}).to_netcdf(path, engine="h5netcdf"), "the file has no attribute"),
        (classic, "the file is NetCDF of the classic kind; runs are NetCDF-4"),
        (fullbody.Simulation(*fullbody.systems.case1()).save, "the file is not a NetCDF file; it is a simulation"),
    ],
    ids=["empty", "text", "foreign", "classic", "simulation"],
)
def test_files_without_a_run_are_refused(make, words, tmp_path):
    make(tmp_path / "other.nc")
    refused(rf"other\.nc is not a readable run of fullbody: {words}", lambda: fullbody.load(tmp_path / "other.nc"))


def attribute(name, text):
    return lambda dataset: dataset.assign_attrs({name: text})


def described(old, new):
    return lambda dataset: dataset.assign_attrs(fullbody_system=dataset.attrs["fullbody_system"].replace(old, new))


def values(name, index, value):
    """Replace one number of a variable."""

    def change(dataset):
        dataset = dataset.copy(deep=True)
        array = dataset[name].values.copy()
        array[index] = value
        dataset[name] = (dataset[name].dims, array, dataset[name].attrs)
        return dataset

    return change


def rotated(dataset):
    """Position with axes in another order, of two samples of the two bodies, so that its shape tells nothing."""
    few = dataset.isel(time=slice(2))
    return few.assign(position=few.position.transpose("body", "time", "axis"))


#: Attributes by name, without fullbody_, with values that are wrong and what errors say of them.
ATTRIBUTES = [
    ("system", '{"bodies": []}', "has no entry"),
    ("system", "[1]", ""),
    ("system", 3.0, "is 3.0; expected text"),
    ("system", "[" * 100_000, "has brackets in brackets"),
    ("events", '[{"a":' * 50_000, "has brackets in brackets"),
    ("events", "junk{", "is not JSON"),
    ("events", '[{"kind": "Eclipse"}]', "event is 'Eclipse'"),
    ("events", "[4]", ""),
    ("integrator", '{"name": "Euler"}', "integrator is 'Euler'"),
    ("statistics", "junk{", "is not JSON"),
    ("statistics", '["a", 1, 2]', "three counts"),
    ("statistics", "[1, 2]", "three counts"),
    ("statistics", "[1, -2, 3]", "three counts"),
    ("format", 5, "expected 2"),
    ("format", "junk{", "expected 2"),
    ("format", [1, 1], "expected 2"),
]
CONTENT = {
    **{
        f"{name} of {str(value)[:20]}": (attribute(f"fullbody_{name}", value), f"attribute fullbody_{name}.*{words}")
        for name, value, words in ATTRIBUTES
    },
    "no variable": (lambda d: d.drop_vars("spin"), "the file has no variable spin"),
    "no system": (lambda d: d.drop_attrs().assign_attrs(fullbody_format=2), "has no attribute fullbody_system"),
    "no format": (lambda d: d.drop_attrs(), "the file has no attribute fullbody_format"),
    "cut system": (described('"mass"', '"ma'), "attribute fullbody_system is not JSON"),
    "unknown shape": (described("Ellipsoid", "Potato"), "attribute fullbody_system has no entry 'Potato'"),
    "body without name": (described('"name": "A"', '"name": 7'), "attribute fullbody_system: name is 7; expected text"),
    "mass of nan": (described('"mass": 2.0', '"mass": NaN'), "attribute fullbody_system: mass .*nan"),
    "huge mass": (described('"mass": 2.0', f'"mass": 1{"0" * 400}'), "attribute fullbody_system: mass "),
    "other end": (attribute("stop_reason", "boredom"), "attribute stop_reason is 'boredom'; expected one of end"),
    **{
        f"{value} in {name}": (values(name, index, value), rf"{name}\[{shown}\] is {value}; expected finite numbers")
        for name, index, shown, value in (
            ("time", 3, "3", np.nan),
            ("position", (3, 1, 1), "3, 1, 1", np.nan),
            ("velocity", (3, 1, 1), "3, 1, 1", -np.inf),
            ("attitude", (3, 1, 1), "3, 1, 1", np.nan),
            ("spin", (3, 1, 1), "3, 1, 1", np.inf),
            ("energy", (1, 0), "1, 0", np.nan),
            ("angular_momentum", (1, 0), "1, 0", np.nan),
            ("event_position", (0, 1, 1), "0, 1, 1", np.nan),
        )
    },
    # NetCDF's fill value, which it reads where no number was written.
    "never written": (values("position", (2, 0, 0), 9.969209968386869e36), r"position\[2, 0, 0\] is 9.969.*e\+36; exp"),
    "repeated time": (values("time", 3, 4.0), r"time\[3\] is 4.0, after 4.0; expected times in the direction of the"),
    "unsorted time": (values("time", 2, 7.0), r"time\[3\] is 6.0, after 7.0; expected times in the direction of the"),
    "end first": (values("time", 0, 99.0), r"time\[2\] is 4.0, after 2.0; expected times in the direction of the run"),
    "zero attitude": (values("attitude", (2, 1), 0.0), r"attitude\[2, 1\] has the length 0.0; expected quaternions of"),
    "long attitude": (values("attitude", (2, 1), 1.0), r"attitude\[2, 1\] has the length 2.0; expected quaternions of"),
    "huge attitude": (values("attitude", (2, 1), 1e300), r"attitude\[2, 1\] has the length 2e\+300; expected quat"),
    "event attitude": (values("event_attitude", (0, 0), 0.1), r"event_attitude\[0, 0\] has the length 0.2; expected"),
    "event of none": (values("event_index", 0, 4), "event_index has 4; expected 0 to 0, an index in fullbody_events"),
    "fewer axes": (lambda d: d.assign(spin=("time", np.zeros(6))), "spin has the dimensions time; expected time, body"),
    "turned": (rotated, "position has the dimensions body, time, axis; expected time, body, axis"),
    "text": (lambda d: d.assign(spin=(d.spin.dims, d.spin.values.astype("U8"))), "spin is of the type <U8; exp"),
    "integers": (lambda d: d.assign(spin=(d.spin.dims, np.ones((6, 2, 3), int))), "spin is of the type int64; expect"),
}


@pytest.mark.parametrize("kind", CONTENT)
def test_content_that_is_no_run_is_refused_by_name(kind, run):
    change, words = CONTENT[kind]
    refused(words, lambda: loading.run_in(reading.Content(change(run.to_xarray()))))


def test_the_file_whose_content_is_no_run_is_named(run, tmp_path):
    values("energy", (1, 0), np.nan)(run.to_xarray()).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    text = r"other\.nc is not a readable run of fullbody: .*energy\[1, 0\] is nan; expected finite numbers"
    refused(text, lambda: fullbody.load(tmp_path / "other.nc"))


# Features of HDF5


@pytest.mark.filterwarnings("ignore::fullbody.errors.UncheckedFile")
def test_a_header_that_promises_more_than_the_file_holds_is_refused(run, tmp_path):
    # It would take eight terabytes of memory.
    path = tmp_path / "run.nc"
    run.save(path)
    with h5py.File(path, "r+") as file:
        del file["time"]
        file.create_dataset("time", (10**12,), "f8", chunks=(2**20,)).make_scale("time")
    refused(r"run\.nc is not a readable run of fullbody: time has 80000000000", lambda: fullbody.load(path))


@pytest.mark.filterwarnings("ignore::fullbody.errors.UncheckedFile")
def test_compressed_files_load(run, tmp_path):
    run.save(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf", decode_times=False) as dataset:
        packed = {"zlib": True, "complevel": 9, "shuffle": True, "fletcher32": True}
        for number, settings in enumerate((packed, {"contiguous": True, "dtype": ">f8"})):
            encoding = {name: settings for name in ("time", "position", "attitude", "event_position")}
            options = {"engine": "h5netcdf", "encoding": encoding, "unlimited_dims": ["time"][: 1 - number]}
            dataset.drop_encoding().to_netcdf(tmp_path / f"{number}.nc", **options)
            assert fullbody.load(tmp_path / f"{number}.nc") == run


def replacements(value, wrong):
    """Copies of a JSON value, each with another entry replaced."""
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        inner = [wrong] + [entry for entry in replacements(value[key], wrong)]
        for entry in inner:
            altered = dict(value) if isinstance(value, dict) else list(value)
            altered[key] = entry
            yield altered


@pytest.mark.parametrize("wrong", [{"x": [1]}, [[None]], 10**400, float("nan")], ids=["table", "list", "huge", "nan"])
def test_any_entry_of_the_system_and_events_is_checked(wrong, run):
    """The entries are checked beside the file, since files for all of them take minutes."""
    dataset = run.to_xarray()
    for name in ("fullbody_system", "fullbody_integrator", "fullbody_events", "fullbody_statistics"):
        for altered in replacements(json.loads(dataset.attrs[name]), wrong):
            content = reading.Content(dataset.assign_attrs({name: json.dumps(altered)}))
            refused(f"attribute {name}", lambda content=content: loading.run_in(content))
