"""Saved runs, xarray datasets and pandas frames are exact and have units; errors name the file."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import Body, Ellipsoid, PointMass, Sphere
from support import refused

ARRAYS = ("time", "position", "velocity", "attitude", "spin", "energy", "angular_momentum", "potential_energy")


def small_run(**options):
    system, state = fullbody.systems.case1(**options)
    return system.integrate(state, 10.0, output=2.0)


def runs_by_kind():
    bodies = [
        Body(Ellipsoid(0.3, 0.2, 0.1), density=1.1, name="Größe 1999 KW₄"),
        Body(Sphere(0.1), mass=1 / 3),
        Body(PointMass(), mass=1e-7, name="probe"),
    ]
    state_of_three = fullbody.State(
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
    state_of_pair = fullbody.State([[0, 0, 0], [1, 0, 0]] * u.km, np.zeros((2, 3)) * u.km / u.s)
    return {
        "plain": small_run(),
        "tait_bryan": small_run(attitude_chart="tait_bryan", gravity="multipole:4"),
        "three bodies": system.integrate(state_of_three, 1.0, integrator=fullbody.Verner98.to_roundoff()),
        "units": with_units.integrate(state, 3 * u.hour, output=1 * u.hour),
        "bodies of quantities": with_quantities.integrate(state_of_pair, 0.01),
        "backwards": fullbody.systems.case2()[0].integrate(fullbody.systems.case2()[1], -3.0),
        "no samples": fullbody.systems.case2()[0].integrate(fullbody.systems.case2()[1], 3.0, output=[]),
    }


@pytest.mark.parametrize("name", runs_by_kind())
def test_a_loaded_run_equals_the_saved_one_bit_for_bit(name, tmp_path):
    run = runs_by_kind()[name]
    run.save(tmp_path / "run.nc")
    loaded = fullbody.load(tmp_path / "run.nc")
    for name_of_array in ARRAYS:
        actual, expected = getattr(loaded, name_of_array), getattr(run, name_of_array)
        assert np.array_equal(actual, expected), name_of_array
        assert getattr(actual, "unit", None) == getattr(expected, "unit", None)
    assert loaded == run
    assert loaded.system == run.system
    assert loaded.statistics == run.statistics
    assert loaded.integrator == run.integrator
    assert loaded.system.names == run.system.names
    if len(run):
        assert loaded[-1] == run[-1]


def test_save_takes_text_or_a_path_that_ends_in_nc_or_nc4(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = small_run()
    for name in ("run.txt", "run", "run.nc.gz", "run.sim"):
        refused(
            rf"{name}'; expected a name that ends in one of \.nc, \.nc4", lambda name=name: run.save(tmp_path / name)
        )
    assert list(tmp_path.iterdir()) == []
    run.save("RUN.NC4")
    assert fullbody.load("RUN.NC4") == run
    assert [path.name for path in tmp_path.iterdir()] == ["RUN.NC4"]


def test_xarray_dataset_has_names_units_and_provenance():
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
    unitless = small_run().to_xarray()
    assert not any("units" in unitless[name].attrs for name in unitless.variables)
    assert fullbody.__version__ in data.attrs.values()
    assert any("Ho, Wold" in str(value) for value in data.attrs.values())


def test_pandas_frame_contains_every_number(kw4_run):
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
    assert kw4_run[:0].to_pandas().shape == (0, 2 * 13 + 4 + 3)


def test_pandas_frame_of_unnamed_bodies_has_numbered_names_and_no_units(triple_run):
    frame = triple_run.to_pandas()
    assert np.array_equal(frame["position", "body 1", "x"], triple_run.position[:, 1, 0])
    assert frame.attrs["units"] == {}


def test_settings_of_an_integrator_are_read_from_netcdf_and_toml(tmp_path):
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


def test_the_error_for_an_unknown_integrator_names_file_and_integrator(kw4_run, tmp_path, monkeypatch):
    kw4_run.save(tmp_path / "run.nc")
    monkeypatch.setattr(fullbody.record.integrators, "__all__", [])
    refused(r"run\.nc is not .*integrator is 'Verner98'; expected one of ", lambda: fullbody.load(tmp_path / "run.nc"))
