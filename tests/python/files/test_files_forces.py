"""Runs with external forces as files and datasets: every bit comes back, and damage is refused."""

import json

import fullbody
import numpy as np
import pytest
import xarray as xr
from astropy import units as u
from fullbody import events, forces, loading
from fullbody.errors import ForceFailed
from fullbody.files import reading
from support import refused

ORBIT = fullbody.KeplerElements(a=95.7e6, e=0.69, i=0.68, Omega=4.29, omega=3.37, M=0.2)
FLYBY = fullbody.KeplerElements(a=-10000.0, e=9.0, i=0.4, Omega=1.0, omega=2.0, M=-0.1)


def every_kind(units=False):
    """1999 KW4 with one force of each kind that files keep, the table twice: alone and of an orbit."""
    km, hour, newton = (u.km, u.hour, u.kg * u.km / u.hour**2) if units else (1.0, 1.0, 1.0)
    system, state = fullbody.systems.kw4(units=units)
    times = np.linspace(-5.0, 40.0, 40)
    moon = np.column_stack([4e5 * np.cos(times / 100), 4e5 * np.sin(times / 100), 100.0 * times])

    def with_units(orbit):
        return fullbody.KeplerElements(orbit.a * km, orbit.e, orbit.i, orbit.Omega, orbit.omega, orbit.M)

    kinds = [
        forces.ThirdBody(mass=1.98841e30, orbit=with_units(ORBIT), of="system", name="Sun"),
        forces.ThirdBody(mass=5.97e24, orbit=with_units(FLYBY), of="body", time=20.0 * hour, name="Earth"),
        forces.ThirdBody(mass=7.3e22, times=times * hour, positions=moon * km, of="body", name="Moon"),
        forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01 * hour),
        forces.Yorp(
            "Alpha",
            along=np.array([1e3, 5e2, 0.0, -1e3]) * newton * km,
            across=1e2 * newton * km,
            obliquity=[0.0, 1.0, 2.0, np.pi],
        ),
        forces.Byorp(on="Beta", about="Alpha", force=1e5 * newton),
    ]
    return system.with_forces(kinds), state


@pytest.fixture(scope="module")
def runs():
    results = []
    for units in (False, True):
        system, state = every_kind(units)
        results.append(system.integrate(state, 30.0, output=5.0, events=[events.ClosestApproach("Earth")]))
    return results


@pytest.mark.parametrize("which", [0, 1])
def test_every_bit_of_a_run_with_forces_comes_back(runs, which, tmp_path):
    run = runs[which]
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again == run
    assert again.system == run.system
    assert [type(force) for force in again.system.forces] == [type(force) for force in run.system.forces]
    # The flyby unlocks the secondary.
    assert again.switched_off == run.switched_off == {"BYORP on Beta": 1}
    for name in ("work", "impulse", "angular_impulse"):
        first, other = getattr(again, name), getattr(run, name)
        assert list(first) == list(other) == [force.name for force in run.system.forces]
        assert all(np.array_equal(first[name], other[name]) for name in first)
    assert np.array_equal(again.energy_drift, run.energy_drift)
    assert np.array_equal(again.angular_momentum_drift, run.angular_momentum_drift)
    assert [happened.event for happened in again.events] == [events.ClosestApproach("Earth")]
    # Units change no number; the loaded system moves as the saved one does.
    np.testing.assert_allclose(getattr(run.position, "value", run.position), runs[0].position, rtol=0, atol=1e-11)
    work = [[getattr(value[-1], "value", value[-1]) for value in other.work.values()] for other in (run, runs[0])]
    np.testing.assert_allclose(*work, rtol=1e-9)
    assert np.array_equal(again.system.integrate(again[0], 5.0).position, run.system.integrate(run[0], 5.0).position)
    again.save(tmp_path / "again.nc")
    assert xr.open_dataset(tmp_path / "again.nc").load().identical(xr.open_dataset(tmp_path / "run.nc").load())


def test_a_dataset_names_the_forces_and_has_units(runs):
    data = runs[1].to_xarray()
    assert data.force.values.tolist() == ["Sun", "Earth", "Moon", "tide on Alpha", "YORP on Alpha", "BYORP on Beta"]
    assert data.work.dims == ("time", "force")
    assert data.angular_impulse.dims == ("time", "force", "axis")
    assert np.array_equal(data.work.sel(force="Sun"), runs[1].work["Sun"].value)
    assert np.array_equal(data.impulse.sel(force="Earth", axis="y"), runs[1].impulse["Earth"].value[:, 1])
    for name, unit in (("work", u.J), ("impulse", u.N * u.s), ("angular_impulse", u.J * u.s)):
        assert u.Unit(data[name].attrs["units"]).is_equivalent(unit)
    # Energy and work close in the dataset alone.
    change = data.energy.sel(part="total") - data.start_energy.sel(part="total") - data.work.sum("force")
    assert float(abs(change).max() / abs(data.start_energy.sel(part="total"))) < 1e-13
    assert json.loads(data.attrs["fullbody_switched_off"]) == {"BYORP on Beta": 1}
    kinds = [force["kind"] for force in json.loads(data.attrs["fullbody_system"])["forces"]]
    assert kinds == ["ThirdBody", "ThirdBody", "ThirdBody", "Tide", "Yorp", "Byorp"]


def test_work_is_counted_from_the_start_whatever_is_recorded(tmp_path):
    system, state = every_kind()
    second_half = system.integrate(state, 10.0, output=[5.0, 10.0])
    assert np.abs(second_half.energy_drift).max() < 1e-14
    second_half.save(tmp_path / "late.nc")
    assert np.array_equal(fullbody.load(tmp_path / "late.nc").energy_drift, second_half.energy_drift)
    none = second_half[:0]
    none.save(tmp_path / "none.nc")
    assert fullbody.load(tmp_path / "none.nc") == none


def test_a_long_table_fits_in_a_file(tmp_path):
    """HDF5 holds 64 kB in the head of an object; this table is longer."""
    system, state = fullbody.systems.kw4()
    times = np.linspace(-5.0, 40.0, 5000)
    positions = np.column_stack([4e5 * np.cos(times / 100), 4e5 * np.sin(times / 100), 100.0 * times])
    moon = forces.ThirdBody(mass=7.3e22, times=times, positions=positions, of="body", name="Moon")
    run = system.with_forces([moon]).integrate(state, 1.0)
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again == run
    assert np.array_equal(again.system.forces[0].positions, positions)


def test_only_a_run_needs_the_function_that_a_file_lacks(tmp_path):
    system, state = fullbody.systems.case1()
    tide = forces.Tide(on=0, by=1, k2=0.1, lag=0.01)

    def drag(time, state):
        return -1e-4 * state.velocity

    run = system.with_forces([forces.Function(drag), tide]).integrate(state, 10.0, output=5.0)
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again == fullbody.load(tmp_path / "run.nc")
    assert "drag" in repr(again.system.forces)
    assert np.array_equal(again.work["drag"], run.work["drag"])
    assert again.energy_drift.shape == (3,)
    with pytest.raises(ForceFailed, match="the function drag is not in the file") as raised:
        again.system.integrate(again[-1], 20.0)
    assert raised.value.force == "drag"
    functions = [forces.Function(drag), again.system.forces[1]]
    assert (
        again.system.with_forces(functions).integrate(again[0], 10.0, output=5.0).position.tolist()
        == run.position.tolist()
    )


def test_a_damaged_description_of_forces_is_refused(runs):
    dataset = runs[0].to_xarray()

    def described(change):
        description = json.loads(dataset.attrs["fullbody_system"])
        change(description["forces"])
        return {"fullbody_system": json.dumps(description)}

    for attributes, message in [
        ({"fullbody_switched_off": '{"Mars": 1}'}, "'Mars' is not a force of the system"),
        ({"fullbody_switched_off": '{"Sun": -1}'}, "the count of Sun is -1; expected a whole number from 0"),
        ({"fullbody_switched_off": "[1]"}, "attribute fullbody_switched_off"),
        (described(lambda description: description[0].update(kind="Comet")), "of the kind 'Comet'; expected one of"),
        (described(lambda description: (description[0].pop("mass"), description[0].pop("mu"))), "no entry 'mu'"),
        (described(lambda description: description[3].update(lag=-1.0)), "lag"),
        (described(lambda description: description[3].update(name="Sun")), "distinct"),
        (described(lambda description: description[3].update(on="Gamma")), "on of tide on Alpha is 'Gamma'"),
        (described(lambda description: description.pop(0)), "the notes have 6 forces; expected 5"),
        (described(lambda description: description.clear()), "the notes have 6 forces; expected 0"),
    ]:
        content = reading.Content(dataset.assign_attrs(attributes))
        refused(message, lambda content=content: loading.run_in(content))
    del dataset.attrs["fullbody_switched_off"]
    refused("no attribute fullbody_switched_off", lambda: loading.run_in(reading.Content(dataset)))
    spoilt = runs[0].to_xarray().copy(deep=True)
    spoilt["work"][1, 2] = np.nan
    refused("work", lambda: loading.run_in(reading.Content(spoilt)))
