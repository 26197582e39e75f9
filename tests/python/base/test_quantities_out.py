"""Dimensional results are Quantities in a system with units and plain numbers in one without."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import observables

KM, H, KG, PER_H = u.km, u.hour, u.kg, u.rad / u.hour
#: A result of a system, its start and its run, and its unit; None for pure numbers.
OUT = {
    "force": (lambda s, x, run: s.interactions(x).force, KG * KM / H**2),
    "torque": (lambda s, x, run: s.interactions(x).torque, KG * KM**2 / H**2),
    "potential energy": (lambda s, x, run: s.interactions(x).potential_energy, KG * KM**2 / H**2),
    **{
        f"energy {part}": (lambda s, x, run, part=part: getattr(s.energy(x), part), KG * KM**2 / H**2)
        for part in ("total", "translational", "rotational", "potential")
    },
    "momentum": (lambda s, x, run: s.momentum(x), KG * KM / H),
    "angular momentum": (lambda s, x, run: s.angular_momentum(x), KG * KM**2 / H),
    "G": (lambda s, x, run: s.G, KM**3 / KG / H**2),
    "mu": (lambda s, x, run: s.mu(), KM**3 / H**2),
    "masses": (lambda s, x, run: s.masses, KG),
    **{
        f"run {name}": (lambda s, x, run, name=name: getattr(run, name), unit)
        for name, unit in {
            "time": H,
            "position": KM,
            "velocity": KM / H,
            "attitude": None,
            "spin": PER_H,
            "energy": KG * KM**2 / H**2,
            "translational_energy": KG * KM**2 / H**2,
            "rotational_energy": KG * KM**2 / H**2,
            "potential_energy": KG * KM**2 / H**2,
            "angular_momentum": KG * KM**2 / H,
            "energy_drift": None,
            "energy_drift_orbital": None,
            "angular_momentum_drift": None,
        }.items()
    },
    **{
        f"elements {name}": (lambda s, x, run, name=name: getattr(run.elements(), name), unit)
        for name, unit in {"a": KM, "e": None, **dict.fromkeys(("i", "Omega", "omega", "M"), u.rad)}.items()
    },
    "period": (lambda s, x, run: run.elements().period(s.mu()), H),
    "range": (lambda s, x, run: run.dense.range[1], H),
    "simulation": (lambda s, x, run: fullbody.Simulation(s, x).time, H),
    "event": (lambda s, x, run: run.events[0].time, H),
    **{
        f"{kind} {name}": (lambda s, x, run, get=get, name=name: getattr(get(run), name), unit)
        for kind, get in {
            "last": lambda run: run[-1],
            "dense": lambda run: run(3.0),
            "samples": lambda run: run([3.0, 4.0]),
            "event": lambda run: run.events[0].state,
        }.items()
        for name, unit in {"time": H, "position": KM, "velocity": KM / H, "spin": PER_H, "attitude": None}.items()
    },
    "rotation matrix": (lambda s, x, run: x.rotation_matrix, None),
    "angles": (lambda s, x, run: x.tait_bryan, None),
    "rate of a": (lambda s, x, run: observables.element_rates(run).rates["a"], KM / H),
    "rate of e": (lambda s, x, run: observables.element_rates(run).mean_rates["e"], 1 / H),
    "rate of L": (lambda s, x, run: observables.element_rates(run).mean_rates["L"], PER_H),
    "mutual periods": (lambda s, x, run: observables.mutual_period(run).period, H),
    "mutual period": (lambda s, x, run: observables.mutual_period(run).mean, H),
    "passages": (lambda s, x, run: observables.mutual_period(run).time, H),
    "drift": (lambda s, x, run: observables.mutual_period(run).drift, None),
    "nodal": (lambda s, x, run: observables.orbit_precession(run).nodal, PER_H),
    "apsidal": (lambda s, x, run: observables.orbit_precession(run).apsidal, PER_H),
    "sidereal": (lambda s, x, run: observables.orbit_precession(run).sidereal_period, H),
    "anomalistic": (lambda s, x, run: observables.orbit_precession(run).anomalistic_period, H),
    "spin precession": (lambda s, x, run: observables.spin_precession(run), PER_H),
    "obliquity": (lambda s, x, run: observables.obliquity(run), u.rad),
    "roll, pitch, yaw": (lambda s, x, run: observables.roll_pitch_yaw(run), u.rad),
    "libration time": (lambda s, x, run: observables.libration(run).time, H),
    "libration angle": (lambda s, x, run: observables.libration(run).angle, u.rad),
    "libration amplitude": (lambda s, x, run: observables.libration(run).amplitude, u.rad),
    "libration amplitudes": (lambda s, x, run: observables.libration(run).amplitudes, u.rad),
    "libration frequencies": (lambda s, x, run: observables.libration(run).frequencies, PER_H),
}


@pytest.fixture(scope="module")
def runs():
    results = {}
    for units in (True, False):
        system, state = fullbody.systems.kw4(units=units)
        event = fullbody.events.Periapsis(0, 1)
        results[units] = (system, state, system.integrate(state, 100.0, output=1.0, dense=True, events=[event]))
    return results


@pytest.mark.parametrize("name", OUT)
def test_results_are_quantities_with_the_numbers_of_a_system_without_units(name, runs):
    call, unit = OUT[name]
    with_units, reference = call(*runs[True]), call(*runs[False])
    assert not isinstance(reference, u.Quantity)
    if unit is None:
        assert not isinstance(with_units, u.Quantity)
    else:
        assert with_units.unit.to(unit) == pytest.approx(1.0, rel=1e-15)
        with_units = with_units.value
    np.testing.assert_allclose(with_units, reference, rtol=1e-12, atol=0.0)
