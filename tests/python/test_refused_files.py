"""Files whose content is no run: whatever stands in them, an error names the file, the place and what was expected."""

import json
import zlib

import fullbody
import h5py
import numpy as np
import pytest
import xarray as xr
from fullbody import events
from fullbody.files import netcdf, occurrences, pieces


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.case1()
    return system.integrate(state, 10.0, output=2.0, events=[events.Separation(0, 1, 7.9)])


# What is no run


def classic(path):
    from scipy.io import netcdf_file

    with netcdf_file(path, "w") as file:
        file.createDimension("t", 2)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: path.write_bytes(b""), "it is empty"),
        (lambda path: path.write_text("time,x,y,z\n0,1,2,3\n"), "it is not a NetCDF file"),
        (
            lambda path: xr.Dataset({"x": ("t", [1.0])}).to_netcdf(path, engine="h5netcdf"),
            "it has no attribute",
        ),
        (classic, "it is NetCDF of the classic kind; runs are NetCDF-4"),
        (
            lambda path: fullbody.Simulation(*fullbody.systems.case1()).save(path),
            r"it is a simulation; fullbody\.Simulation\.load reads it",
        ),
    ],
    ids=["empty", "text", "foreign", "classic", "simulation"],
)
def test_what_is_no_run_is_refused(make, words, tmp_path):
    make(tmp_path / "other.nc")
    with pytest.raises(fullbody.InvalidInput, match=rf"other\.nc is not a readable run of fullbody: {words}"):
        fullbody.load(tmp_path / "other.nc")


def attribute(name, text):
    return lambda dataset: dataset.assign_attrs({name: text})


def setup(old, new):
    return lambda dataset: dataset.assign_attrs(fullbody_setup=dataset.attrs["fullbody_setup"].replace(old, new))


def values(name, place, value):
    """One number of a variable replaced."""

    def change(dataset):
        dataset = dataset.copy(deep=True)
        array = dataset[name].values.copy()
        array[place] = value
        dataset[name] = (dataset[name].dims, array, dataset[name].attrs)
        return dataset

    return change


def turned(dataset):
    """Position with axes in another order, of two samples of the two bodies, so that its shape tells nothing."""
    few = dataset.isel(time=slice(2))
    return few.assign(position=few.position.transpose("body", "time", "axis"))


CONTENT = {
    "no variable": (lambda d: d.drop_vars("spin"), "it has no variable spin"),
    "no setup": (lambda d: d.drop_attrs().assign_attrs(fullbody_format=1), "it has no attribute fullbody_setup"),
    "cut setup": (setup('"rtol"', '"rt'), "attribute fullbody_setup is no JSON"),
    "other setup": (attribute("fullbody_setup", '{"bodies": []}'), "attribute fullbody_setup has no entry 'units'"),
    "list for setup": (attribute("fullbody_setup", "[1]"), "attribute fullbody_setup: "),
    "number for setup": (attribute("fullbody_setup", 3.0), r"attribute fullbody_setup is 3.0; expected text"),
    "deep setup": (attribute("fullbody_setup", "[" * 100_000), "attribute fullbody_setup has brackets in brackets"),
    "deep events": (attribute("fullbody_events", '[{"a":' * 50_000), "attribute fullbody_events has brackets in b"),
    "unknown shape": (setup("Ellipsoid", "Potato"), "attribute fullbody_setup has no entry 'Potato'"),
    "body without name": (setup('"name": "A"', '"name": 7'), "attribute fullbody_setup: name is 7; expected text"),
    "mass of nan": (setup('"mass": 2.0', '"mass": NaN'), "attribute fullbody_setup: mass .*nan"),
    "huge mass": (setup('"mass": 2.0', f'"mass": 1{"0" * 400}'), "attribute fullbody_setup: mass "),
    "unknown integrator": (setup("Verner98", "Euler"), "attribute fullbody_setup: integrator is 'Euler'"),
    "no format": (lambda d: d.drop_attrs(), "it has no attribute fullbody_format"),
    "newer": (attribute("fullbody_format", 99), f"a newer fullbody wrote it, {fullbody.__version__}"),
    "text for format": (
        attribute("fullbody_format", "junk{"),
        "attribute fullbody_format is 'junk{'; expected a whole",
    ),
    "many formats": (attribute("fullbody_format", [1, 1]), r"attribute fullbody_format is of shape \(2,\)"),
    "junk statistics": (attribute("fullbody_statistics", "junk{"), "attribute fullbody_statistics is no JSON"),
    "odd statistics": (
        attribute("fullbody_statistics", '["a", 1, 2]'),
        "attribute fullbody_statistics: .* three counts",
    ),
    "two statistics": (attribute("fullbody_statistics", "[1, 2]"), "attribute fullbody_statistics: .* three counts"),
    "below zero": (attribute("fullbody_statistics", "[1, -2, 3]"), "attribute fullbody_statistics: .* three counts"),
    "junk events": (attribute("fullbody_events", "junk{"), "attribute fullbody_events is no JSON"),
    "unknown event": (attribute("fullbody_events", '[{"kind": "Eclipse"}]'), "fullbody_events: event is 'Eclipse'"),
    "event of nothing": (attribute("fullbody_events", "[4]"), "attribute fullbody_events: "),
    "other end": (
        attribute("stop_reason", "boredom"),
        "attribute stop_reason is 'boredom'; expected one of end",
    ),
    **{
        f"{value} in {name}": (values(name, place, value), rf"{name}\[{shown}\] is {value}; expected finite numbers")
        for name, place, shown, value in (
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
    # What netCDF reads of numbers that were never written.
    "never written": (values("position", (2, 0, 0), 9.969209968386869e36), r"position\[2, 0, 0\] is 9.969.*e\+36; exp"),
    "repeated time": (values("time", 3, 4.0), r"time\[3\] is 4.0, after 4.0; expected times in the direction of the"),
    "unsorted time": (values("time", 2, 7.0), r"time\[3\] is 6.0, after 7.0; expected times in the direction of the"),
    "end first": (values("time", 0, 99.0), r"time\[2\] is 4.0, after 2.0; expected times in the direction of the run"),
    "zero attitude": (values("attitude", (2, 1), 0.0), r"attitude\[2, 1\] has the length 0.0; expected quaternions of"),
    "long attitude": (values("attitude", (2, 1), 1.0), r"attitude\[2, 1\] has the length 2.0; expected quaternions of"),
    "huge attitude": (values("attitude", (2, 1), 1e300), r"attitude\[2, 1\] has the length 2e\+300; expected quat"),
    "event attitude": (values("event_attitude", (0, 0), 0.1), r"event_attitude\[0, 0\] has the length 0.2; expected"),
    "event of none": (values("event_asked", 0, 4), "event_asked has 4; expected 0 to 0, a place in fullbody_events"),
    "fewer axes": (lambda d: d.assign(spin=("time", np.zeros(6))), r"spin has shape \(6,\); expected \(6, 2, 3\)"),
    "turned": (turned, "position has the dimensions body, time, axis; expected time, body, axis"),
    "text": (lambda d: d.assign(spin=(d.spin.dims, d.spin.values.astype("U8"))), "spin is of the type object; exp"),
    "integers": (lambda d: d.assign(spin=(d.spin.dims, np.ones((6, 2, 3), int))), "spin is of the type int64; expect"),
}


@pytest.mark.parametrize("kind", CONTENT)
def test_content_that_is_no_run_is_refused_by_name(kind, run, tmp_path):
    change, words = CONTENT[kind]
    path = tmp_path / "other.nc"
    change(run.to_xarray()).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(fullbody.InvalidInput, match=rf"other\.nc is not a readable run of fullbody: .*{words}"):
        fullbody.load(path)


# What HDF5 can do


def replaced(name, make):
    """A change of a file: another object under the name of a variable."""

    def change(file):
        numbers = file[name][...]
        del file[name]
        make(file, name, numbers)

    return change


def outside(file, name, numbers):
    with h5py.File(file.filename + ".other", "w") as other:
        other[name] = numbers


def external_link(file, name, numbers):
    outside(file, name, numbers)
    file[name] = h5py.ExternalLink(file.filename + ".other", name)


def soft_link(file, name, numbers):
    file["elsewhere"] = numbers
    file[name] = h5py.SoftLink("/elsewhere")


def virtual(file, name, numbers):
    outside(file, name, numbers)
    layout = h5py.VirtualLayout(numbers.shape, numbers.dtype)
    layout[...] = h5py.VirtualSource(file.filename + ".other", name, numbers.shape)
    file.create_virtual_dataset(name, layout)


def external_storage(file, name, numbers):
    raw = file.filename + ".raw"
    with open(raw, "wb") as other:
        other.write(numbers.tobytes())
    file.create_dataset(name, numbers.shape, numbers.dtype, external=[(raw, 0, numbers.nbytes)])


def packed(name, packing):
    def change(file):
        file[name].attrs[packing] = 2.0

    return change


def filling(value):
    def change(file):
        file["spin"][3, 1, 1] = value
        file["spin"].attrs["missing_value"] = value

    return change


def as_time(**options):
    """The times as another dataset of HDF5; it stays the scale of its dimension."""

    def make(file, name, numbers):
        file.create_dataset(name, **{"data": numbers, **options}).make_scale(name)

    return replaced("time", make)


def holes(file, name, numbers):
    variable = file.create_dataset(name, numbers.shape, numbers.dtype, chunks=(1,))
    variable[:3] = numbers[:3]
    variable.make_scale(name)


def bomb(file, name, numbers):
    """A piece of 48 bytes that becomes a hundred million."""
    variable = file.create_dataset(name, numbers.shape, numbers.dtype, chunks=numbers.shape, compression="gzip")
    variable.id.write_direct_chunk((0,), zlib.compress(bytes(10**8)))
    variable.make_scale(name)


TRICKS = {
    "external link": (replaced("spin", external_link), "spin is a link to elsewhere; expected a variable of this file"),
    "soft link": (replaced("spin", soft_link), "spin is a link to elsewhere; expected a variable of this file"),
    "virtual": (replaced("spin", virtual), "spin is kept in another file; expected numbers in this one"),
    "external storage": (replaced("spin", external_storage), "spin is kept in another file; expected numbers in"),
    "group": (replaced("spin", lambda file, name, _: file.create_group(name)), "spin is a group; expected a variable"),
    "scale": (packed("spin", "scale_factor"), "spin has the scale_factor 2.0; expected the numbers themselves"),
    "offset": (packed("time", "add_offset"), "time has the add_offset 2.0; expected the numbers themselves"),
    "filling": (filling(0.125), r"spin\[3, 1, 1\] is 0.125; expected finite numbers that are not the filling"),
    "1e12 samples": (as_time(data=None, shape=(10**12,), dtype="f8", chunks=(2**20,)), "time has 8000000000000 bytes"),
    "huge pieces": (
        as_time(chunks=(10**8,), shape=(6,), maxshape=(None,), data=None, dtype="f8"),
        "time has 800000000 bytes",
    ),
    "1e12 bytes at once": (
        as_time(data=None, shape=(10**11,), dtype="f8"),
        "time has 800000000000 bytes by its",
    ),
    "not written": (as_time(data=None, shape=(6,), dtype="f8"), "time is truncated or damaged: not all of its numbers"),
    "holes": (replaced("time", holes), "time is truncated or damaged: not all of its numbers are in the file"),
    "strange filter": (as_time(compression="lzf"), "time has the filter 32000 of HDF5; expected deflate, shuffle"),
    "lossy filter": (as_time(chunks=(6,), scaleoffset=2), "time has the filter 6 of HDF5; expected deflate, shuffle"),
    "bomb": (replaced("time", bomb), "time is truncated or damaged: not all of its numbers are in the file"),
    "complex": (as_time(data=np.arange(6.0) + 1j), "time is of the type complex128; expected floating-point numbers"),
}


@pytest.mark.parametrize("kind", TRICKS)
def test_tricks_of_hdf5_are_refused_by_name(kind, run, tmp_path):
    change, words = TRICKS[kind]
    path = tmp_path / "run.nc"
    run.save(path)
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(fullbody.InvalidInput, match=rf"run\.nc is not a readable run of fullbody: {words}"):
        fullbody.load(path)


@pytest.mark.filterwarnings("ignore::fullbody.UncheckedFile")
def test_compressed_files_load(run, tmp_path):
    """As people make them smaller; the pieces need not fit the variable."""
    run.save(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf", decode_times=False) as dataset:
        for number, settings in enumerate(
            (
                {"zlib": True, "complevel": 9, "shuffle": True, "fletcher32": True},
                {"zlib": True, "shuffle": False, "chunksizes": None},
                {"contiguous": True},
                {"dtype": ">f8"},
            )
        ):
            plain = dataset.drop_encoding()
            encoding = {name: settings for name in ("time", "position", "attitude", "event_position")}
            plain.to_netcdf(
                tmp_path / f"{number}.nc", engine="h5netcdf", encoding=encoding, unlimited_dims=["time"][: number < 2]
            )
            assert fullbody.load(tmp_path / f"{number}.nc") == run


@pytest.mark.parametrize("shape", [(), (1,), (7,), (50, 3), (3, 5, 7), (65536,)])
@pytest.mark.parametrize("kind", ["f8", ">f4", "u1", "i2"])
def test_pieces_are_read_as_hdf5_reads_them(shape, kind, tmp_path):
    path = tmp_path / "any.h5"
    random = np.random.default_rng(len(shape))
    data = {"random": random.integers(0, 255, shape), "zero": np.zeros(shape), "full": np.full(shape, 255)}
    settings = (
        [{}]
        if shape == ()
        else [
            {},
            {"fletcher32": True},
            {"chunks": tuple(-(-size // 2) for size in shape)},
            {"shuffle": True, "fletcher32": True, "chunks": tuple(max(1, size // 3) for size in shape)},
            {"compression": "gzip", "shuffle": True, "fletcher32": True},
            {"compression": "gzip", "maxshape": (None,) * len(shape)},
        ]
    )
    with h5py.File(path, "w") as file:
        for name, numbers in data.items():
            for number, setting in enumerate(settings):
                file.create_dataset(f"{name}{number}", data=numbers.astype(kind), **setting)
    with path.open("rb") as raw, h5py.File(raw, "r") as file:
        for name, variable in file.items():
            read = pieces.read(name, variable, raw)
            assert read.dtype == variable.dtype
            assert np.array_equal(read, variable[()]), name


def replacements(value, wrong):
    """Copies of a JSON value, in each of which one entry is another."""
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        inner = [wrong] + [entry for entry in replacements(value[key], wrong)]
        for entry in inner:
            altered = dict(value) if isinstance(value, dict) else list(value)
            altered[key] = entry
            yield altered


@pytest.mark.parametrize("wrong", [{"x": [1]}, [[None]], 10**400, float("nan")], ids=["table", "list", "huge", "nan"])
def test_any_entry_of_the_setup_and_events_is_checked(wrong, run):
    """By itself, since files for all of them take minutes."""
    dataset = run.to_xarray()
    system = fullbody.systems.case1()[0]

    class Text:
        def __init__(self, value):
            self.value = value

        def text(self, *_):
            return json.dumps(self.value)

    for name, build in (
        ("fullbody_setup", lambda setup: netcdf._restore(setup, fullbody.System)),
        ("fullbody_events", lambda described: occurrences.asked_for(described, system)),
        ("fullbody_statistics", netcdf._statistics),
    ):
        for altered in replacements(json.loads(dataset.attrs[name]), wrong):
            with pytest.raises(fullbody.InvalidInput, match=f"attribute {name}"):
                netcdf._parsed(Text(altered), name, None, build)
