"""Random systems of all kinds, and differences of complete runs for comparison with a run's derivatives."""

from dataclasses import dataclass
from typing import Any

import fullbody
import numpy as np
from flows import deviation, displaced, scales
from meshes import box, octahedron
from support import worst

PAIRS = {
    "verner98": lambda: fullbody.Verner98(rtol=1e-13, atol=1e-13),
    "verner87": lambda: fullbody.Verner87(rtol=1e-13, atol=1e-13),
    "verner76": lambda: fullbody.Verner76(rtol=1e-12, atol=1e-12),
    "verner65": lambda: fullbody.Verner65(rtol=1e-11, atol=1e-11),
    "dormand-prince": lambda: fullbody.DormandPrince54(rtol=1e-10, atol=1e-10),
}
FIXED = {
    "lie": lambda: fullbody.LieGroupVariational(step=0.05),
    "splitting": lambda: fullbody.SymplecticSplitting(step=0.1),
}


@dataclass
class Case:
    """A system at a state, with what it is run and differentiated by."""

    system: Any
    state: Any
    until: float
    integrator: Any
    column: int
    names: list[str]
    label: str


def shape(rng, kind, factor=1.0):
    if kind == "point":
        return fullbody.PointMass()
    if kind == "sphere":
        return fullbody.Sphere(factor * rng.uniform(0.3, 0.9))
    if kind == "ellipsoid":
        return fullbody.Ellipsoid(*(factor * rng.uniform(0.3, 1.0, 3)))
    sides = factor * rng.uniform(0.4, 1.0, 3)
    return octahedron(*sides) if rng.random() < 0.5 else box(*(1.2 * sides))


def body(rng, kind, name, mass):
    if kind != "composite":
        return fullbody.Body(shape(rng, kind), mass=mass, name=name)
    kinds = rng.choice(["ellipsoid", "sphere", "polyhedron"], size=rng.integers(2, 4))
    turn = [q / np.linalg.norm(q) for q in rng.normal(size=(len(kinds), 4))]
    parts = [
        fullbody.Part(
            shape(rng, part, 0.6),
            mass=mass * rng.uniform(0.3, 0.7),
            position=0.5 * rng.uniform(-1, 1, 3),
            attitude=turn[k],
        )
        for k, part in enumerate(kinds)
    ]
    return fullbody.Body(fullbody.Composite(parts), name=name)


def forces(rng, kinds, fixed):
    """Forces strong enough to be seen; of those that depend on velocities none beside fixed steps."""
    made = []
    if rng.random() < 0.6:
        hyperbola = rng.random() < 0.3
        e = rng.uniform(1.2, 2.0) if hyperbola else rng.choice([0.0, rng.uniform(0.05, 0.7)])
        a = -20.0 if hyperbola else rng.uniform(25.0, 40.0) / (1 - e)
        angles = rng.uniform(0.1, 3.0, 4)
        orbit = fullbody.KeplerElements(a, e, *angles)
        given = {"mass": 30.0} if rng.random() < 0.5 else {"mu": 30.0}
        of = rng.choice(["system", "body"])
        made.append(fullbody.forces.ThirdBody(orbit=orbit, of=str(of), time=0.3, name="Sun", **given))
    if fixed or "point" in kinds:
        return made
    if rng.random() < 0.6:
        k2 = float(rng.choice([0.0, 0.3]))
        made.append(fullbody.forces.Tide(on="A", by="B", k2=k2, lag=0.05, radius=2.0, name="tide"))
    if rng.random() < 0.5:
        table = rng.random() < 0.5
        numbers = {"obliquity": [0.0, 0.8, 2.0, np.pi], "along": [2e-3, 1e-3, -1e-3, 1e-3], "across": [1e-3] * 4}
        torques = numbers if table else {"along": 2e-3, "across": 1e-3}
        made.append(fullbody.forces.Yorp(on="B", pole=[0.2, 0.1, 1.0], name="yorp", **torques))
    return made


def case(seed):
    """A system, a state and a run by a seed."""
    rng = np.random.default_rng(seed)
    kinds = [str(k) for k in rng.choice(["ellipsoid", "sphere", "point", "polyhedron", "composite"], size=2)]
    if kinds == ["point", "point"]:
        kinds[0] = "polyhedron"
    gravity = str(rng.choice(["focal", "focal", "surface", "multipole:2", "multipole:4", "point"]))
    name = str(rng.choice([*PAIRS, *FIXED]))
    fixed = name in FIXED
    bodies = [body(rng, kind, label, mass) for kind, label, mass in zip(kinds, "AB", (1.0, 0.4), strict=True)]
    system = fullbody.System(bodies, G=1.0, gravity=gravity, forces=forces(rng, kinds, fixed))
    away = rng.normal(size=3)
    away *= rng.uniform(2.9, 4.0) / np.linalg.norm(away)
    along = np.cross(away, rng.normal(size=3))
    along *= np.sqrt(1.4 / np.linalg.norm(away)) / np.linalg.norm(along)
    turn = rng.normal(size=(2, 4))
    spin = rng.uniform(-0.5, 0.5, (2, 3))
    state = fullbody.State(
        position=[-0.3 * away, 0.7 * away],
        velocity=[-0.3 * along, 0.7 * along],
        attitude=turn / np.linalg.norm(turn, axis=1, keepdims=True),
        spin=spin,
        time=0.2,
    )
    backward = rng.random() < 0.5
    until = state.time + (-1.0 if backward else 1.0) * rng.uniform(1.0, 2.0)
    names = list(system.parameters)
    chosen = [str(n) for n in rng.choice(names, size=min(3, len(names)), replace=False)]
    own = [name for name in names if any(f" of {force.name}" in name for force in system.forces)]
    chosen += [str(rng.choice(own))] if own else []
    # Without a k2 the lag does nothing.
    idle = ["lag of tide"] if any(getattr(force, "k2", 1.0) == 0.0 for force in system.forces) else []
    chosen = [name for name in dict.fromkeys(chosen) if name not in idle]
    forced = ", ".join(force.name for force in system.forces)
    way = "backward" if backward else "forward"
    label = f"{kinds} by {gravity}, {name}, {way}, with {forced or 'nothing'}"
    integrator = (PAIRS | FIXED)[name]()
    return Case(system, state, until, integrator, int(rng.integers(24)), chosen, label)


def errors(case):
    """The largest differences from complete runs, over the scale of each derivative, by the names of what is varied."""
    system, state, until, integrator = case.system, case.state, case.until, case.integrator
    size = scales(system, state)

    def end(system=system, state=state, wanted=()):
        found = system.integrate(state, until, output="ends", integrator=integrator, derivatives=wanted or False)
        return found

    run = end(wanted=case.names or True)
    place = (case.column // 12, case.column % 12 // 3, case.column % 3)

    def moved(by):
        return end(state=displaced(state, *place, by))[-1]

    def error(column, ends, step):
        try:
            change = differences(ends, step)
        except fullbody.InvalidInput:
            change = one_sided(ends, run[-1], step)
        return worst(column / size, change / size)

    def least(column, ends, natural):
        # Principal axes are named anew, and rules of the quadrature change, beyond some change: a shorter step decides.
        found = error(column, ends, 1e-3 * natural)
        return found if found < 1e-6 else min(found, error(column, ends, 1e-5 * natural))

    found = {f"column {case.column}": least(run.transition[-1][:, case.column], moved, size[case.column])}
    for name in case.names:
        _, natural = system._changed(name, 0.0)
        # Loads that are in proportion to their number allow for larger steps, in which they tell more.
        share = 20.0 if name.startswith(("k2", "lag", "along", "across", "factor")) else 1.0

        def changed(by, name=name):
            return end(system=system._changed(name, by)[0])[-1]

        found[name] = least(run.sensitivity[name][-1], changed, share * natural)
    return found


def differences(end, step):
    """Of sixth order."""
    by = [deviation(end(-k * step), end(k * step)) / (2 * k * step) for k in (1, 2, 3)]
    return 1.5 * by[0] - 0.6 * by[1] + 0.1 * by[2]


def one_sided(end, here, step):
    """Of fifth order, from the end of a parameter's range on."""
    weights = [5.0, -5.0, 10.0 / 3.0, -5.0 / 4.0, 1.0 / 5.0]
    return sum(w * deviation(here, end(k * step)) for k, w in enumerate(weights, 1)) / step
