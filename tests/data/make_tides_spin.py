"""Writes tides_spin.json: a pair under a tide by the effect tides_spin of REBOUNDx, without the bulges that do not lag.

REBOUNDx has the part that lags and the bulges of tide and rotation (Eggleton et al. 1998; Lu et al. 2023). The first goes with
k2 times the lag, the others with k2: with k2 = 1e-12 and the lag 1e12 times as long they are negligible.
Its tau is half the lag: its sigma = 4 tau G/(3 R^5 k2) makes 6 k2 G m^2 R^5 tau of the 3 k2 G m^2 R^5 lag of Mignard and Hut, while
its bulge that does not lag is that of k2. In its own words 1/Q = 2 n tau, where Mignard's lag has 1/Q = n lag.
Its orbit sees the spin of the last step: the error goes with the step and is extrapolated from two.
Run, where REBOUNDx is installed: python tests/data/make_tides_spin.py
"""

import json
import pathlib

import numpy as np
import rebound
import reboundx

K2_LAG, SMALL = 0.24, 1e-12
MASS, RADIUS, INERTIA = 0.2, 0.25, 0.4 * 0.25**2
SPIN = [0.3, -1.0, 2.5]
TIME = 20.0
ORBITS = [(1.0, 0.25, i, 0.4, 1.0, 2.0) for i in (0.35, 1.6, 2.8)]


def end(orbit, step):
    """Return the relative position and velocity, and the spin."""
    a, e, i, Omega, omega, M = orbit
    sim = rebound.Simulation()
    sim.integrator = "bs"
    sim.integrator.eps_rel = sim.integrator.eps_abs = 1e-13
    sim.integrator.max_dt = step
    sim.add(m=1.0)
    sim.add(m=MASS, a=a, e=e, inc=i, Omega=Omega, omega=omega, M=M)
    sim.move_to_com()
    extras = reboundx.Extras(sim)
    force = extras.load_force("tides_spin")
    extras.add_force(force)
    first, second = sim.particles
    first.r = RADIUS
    first.params["k2"] = SMALL
    first.params["tau"] = 0.5 * K2_LAG / SMALL
    first.params["I"] = INERTIA
    first.params["Omega"] = SPIN
    extras.initialize_spin_ode(force)
    sim.integrate(TIME, exact_finish_time=1)
    first, second = sim.particles
    relative = [second.x - first.x, second.y - first.y, second.z - first.z]
    speed = [second.vx - first.vx, second.vy - first.vy, second.vz - first.vz]
    return np.array([relative, speed, list(first.params["Omega"])])


cases = []
for orbit in ORBITS:
    wide, narrow = (end(orbit, step) for step in (8e-4, 4e-4))
    print(np.abs(wide - narrow).max())
    relative, speed, spin = (2 * narrow - wide).tolist()
    cases.append({"elements": list(orbit), "relative": relative, "relative_velocity": speed, "spin": spin})
data = {
    "note": "A pair under a tide by REBOUNDx's tides_spin, see make_tides_spin.py. G = 1, the first mass is one.",
    "versions": {"rebound": rebound.__version__, "reboundx": reboundx.__version__},
    "k2_lag": K2_LAG,
    "mass": MASS,
    "radius": RADIUS,
    "spin": SPIN,
    "time": TIME,
    "cases": cases,
}
pathlib.Path(__file__).with_name("tides_spin.json").write_text(json.dumps(data, indent=1) + "\n")
