"""Random systems of all kinds, and differences of complete runs for comparison with a run's derivatives."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import comb
from typing import Any

import fullbody
import numpy as np
from fullbody.errors import InvalidInput
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from support import worst
from support.flows import deviation, displaced, scales, symplectic_form
from support.meshes import box, octahedron

#: The largest error of a derivative, over its scale.
TOLERANCE = 1e-6
#: The rounding of the difference of two states, in natural sizes.
ROUNDING = 1e-15
#: Steps of the differences over natural sizes, the longest one last.
STEPS = (1e-3, 1e-4, 1e-5, 1e-2)
PAIRS = {
    "verner98": lambda: fullbody.Verner98(rtol=1e-13, atol=1e-13),
    "verner87": lambda: fullbody.Verner87(rtol=1e-13, atol=1e-13),
    "verner76": lambda: fullbody.Verner76(rtol=1e-12, atol=1e-12),
    "verner65": lambda: fullbody.Verner65(rtol=1e-13, atol=1e-13),
    "dormand-prince": lambda: fullbody.DormandPrince54(rtol=1e-10, atol=1e-10),
}
FIXED = {
    "lie": lambda: fullbody.LieGroupVariational(step=0.05),
    "splitting": lambda: fullbody.SymplecticSplitting(step=0.1),
    "leapfrog": lambda: fullbody.SymplecticSplitting(step=0.1, scheme="leapfrog"),
}


@dataclass
class Case:
    """A system at a state, with what it is run by and differentiated with respect to."""

    system: Any
    state: Any
    until: float
    integrator: Any
    event: Any
    column: int
    names: list[str]
    label: str

    @property
    def is_hamiltonian(self):
        return all(isinstance(force, fullbody.forces.ThirdBody) for force in self.system.forces)

    @property
    def is_of_second_order(self):
        return (
            isinstance(self.integrator, fullbody.LieGroupVariational)
            or getattr(self.integrator, "scheme", None) == "leapfrog"
        )

    def ended(self, wanted=False, **options):
        options = {"system": self.system, "state": self.state, "event": self.event} | options
        system, state, event = options.values()
        return system.integrate(
            state, self.until, output="ends", integrator=self.integrator, events=[event], derivatives=wanted
        )

    @cached_property
    def run(self):
        return self.ended(wanted=self.names or True)


def shape(rng, kind, factor=1.0):
    if kind == "point":
        return fullbody.PointMass()
    if kind == "sphere":
        return fullbody.Sphere(factor * rng.uniform(0.3, 0.9))
    if kind == "ellipsoid":
        return fullbody.Ellipsoid(*(factor * rng.uniform(0.3, 1.0, 3)))
    if kind == "spheroid":
        equator, polar = factor * rng.uniform(0.3, 1.0, 2)
        return fullbody.Ellipsoid(equator, equator, polar)
    sides = factor * rng.uniform(0.4, 1.0, 3)
    return octahedron(*sides) if rng.random() < 0.5 else box(*(1.2 * sides))


def body(rng, kind, name, mass):
    if kind != "composite":
        return fullbody.Body(shape(rng, kind), mass=mass, name=name)
    kinds = rng.choice(["ellipsoid", "sphere", "polyhedron"], size=rng.integers(2, 4))
    attitudes = [q / np.linalg.norm(q) for q in rng.normal(size=(len(kinds), 4))]
    parts = [
        fullbody.Part(
            shape(rng, part, 0.6),
            mass=mass * rng.uniform(0.3, 0.7),
            position=0.5 * rng.uniform(-1, 1, 3),
            attitude=attitudes[k],
        )
        for k, part in enumerate(kinds)
    ]
    if rng.random() < 0.5:
        # A void.
        empty = shape(rng, str(rng.choice(["ellipsoid", "sphere"])), 0.3)
        parts.append(fullbody.Part(empty, mass=-0.1 * mass, position=0.3 * rng.uniform(-1, 1, 3)))
    try:
        return fullbody.Body(fullbody.Composite(parts), name=name)
    except InvalidInput:
        # The void takes away more than there is.
        return body(rng, kind, name, mass)


def forces(rng, kinds, fixed):
    """Random forces with visible effects; fixed steps get none that depend on velocities."""
    made = []
    which = rng.random()
    if which < 0.2:
        times = np.linspace(-5.0, 5.0, 41)
        first, across = 30.0 * rng.normal(size=(2, 3))
        first *= 30.0 / np.linalg.norm(first)
        positions = np.cos(0.05 * times)[:, None] * first + 0.3 * np.sin(0.05 * times)[:, None] * across
        made.append(fullbody.forces.ThirdBody(mu=30.0, times=times, positions=positions, of="body", name="Sun"))
    elif which < 0.7:
        hyperbola = rng.random() < 0.3
        e = rng.uniform(1.2, 2.0) if hyperbola else rng.choice([0.0, rng.uniform(0.05, 0.7)])
        a = -20.0 if hyperbola else rng.uniform(25.0, 40.0) / (1 - e)
        angles = rng.uniform(0.1, 3.0, 4)
        orbit = fullbody.KeplerElements(a, e, *angles)
        options = {"mass": 30.0} if rng.random() < 0.5 else {"mu": 30.0}
        of = rng.choice(["system", "body"])
        made.append(fullbody.forces.ThirdBody(orbit=orbit, of=str(of), time=0.3, name="Sun", **options))
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
    if kinds[1] not in ("sphere", "spheroid") and rng.random() < 0.6:
        made.append(fullbody.forces.Byorp(on="B", about="A", force=5e-3, name="byorp"))
    return made


def tilted(rng, system, state):
    """The state with B's long axis towards A, and its short axis turning through 45 degrees from the orbit's normal."""
    separation, along = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
    momentum = np.cross(separation, along)
    line, normal = separation / np.linalg.norm(separation), momentum / np.linalg.norm(momentum)
    tilt = rng.choice([-1.0, 1.0]) * (0.25 * np.pi + rng.uniform(-0.15, 0.15))
    axes = np.empty((3, 3))
    order = np.argsort(system.bodies[1].inertia)
    axes[:, order[0]] = line
    axes[:, order[2]] = np.cos(tilt) * normal + np.sin(tilt) * np.cross(line, normal)
    axes[:, order[1]] = np.cross(axes[:, order[2]], line)
    if np.linalg.det(axes) < 0.0:
        axes[:, order[1]] *= -1.0
    rotation = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    spin = axes.T @ (momentum / (separation @ separation) + rng.choice([-1.0, 1.0]) * 0.4 * line)
    attitude, spins = np.array(state.attitude), np.array(state.spin)
    attitude[1], spins[1] = rotation, spin
    return state.replace(attitude=attitude, spin=spins)


def happening(rng, system, state, until, integrator):
    """An event in the middle of the run: the separation that the bodies have then, or the plane that B crosses then."""
    end = system.integrate(state, 0.5 * (state.time + until), output="ends", integrator=integrator)[-1]
    away, along = end.position[1] - end.position[0], end.velocity[1] - end.velocity[0]
    # Near an apsis the time of a separation is not a smooth function of the start.
    approach = abs(away @ along) / (np.linalg.norm(away) * np.linalg.norm(along))
    if rng.random() < 0.5 and approach > 0.05:
        return fullbody.events.Separation("A", "B", float(np.linalg.norm(away)))
    normal = along - away * (away @ along) / (away @ away)
    return fullbody.events.PlaneCrossing("B", "A", normal=normal / np.linalg.norm(normal))


def case(seed):
    """A system, a state and a run by a seed."""
    rng = np.random.default_rng(seed)
    every = ["ellipsoid", "spheroid", "sphere", "point", "polyhedron", "composite"]
    kinds = [str(k) for k in rng.choice(every, size=2)]
    if kinds == ["point", "point"]:
        kinds[0] = "polyhedron"
    gravity = str(rng.choice(["focal", "focal", "surface", "multipole:2", "multipole:4", "point"]))
    name = str(rng.choice([*PAIRS, *FIXED]))
    fixed = name in FIXED
    three = not fixed and rng.random() < 0.15
    kinds += [str(rng.choice(every))] if three else []
    bodies = [body(rng, kind, label, mass) for kind, label, mass in zip(kinds, "ABC", (1.0, 0.4, 0.2), strict=False)]
    system = fullbody.System(bodies, G=1.0, gravity=gravity, forces=forces(rng, kinds, fixed))
    direction = rng.normal(size=3)
    direction *= rng.uniform(2.9, 4.0) / np.linalg.norm(direction)
    along = np.cross(direction, rng.normal(size=3))
    along *= np.sqrt(1.4 / np.linalg.norm(direction)) / np.linalg.norm(along)
    along += rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 0.15) * direction / np.linalg.norm(direction)
    attitudes = rng.normal(size=(3, 4))
    count = len(bodies)
    state = fullbody.State(
        [-0.3 * direction, 0.7 * direction, [2.0, -8.0, 1.0]][:count],
        [-0.3 * along, 0.7 * along, [0.3, 0.1, 0.0]][:count],
        (attitudes / np.linalg.norm(attitudes, axis=1, keepdims=True))[:count],
        rng.uniform(-0.5, 0.5, (count, 3)),
        time=0.2,
    )
    if "byorp" in [force.name for force in system.forces]:
        state = tilted(rng, system, state)
    backward = rng.random() < 0.5
    until = state.time + (-1.0 if backward else 1.0) * rng.uniform(1.0, 2.0)
    names = list(system.parameters)
    chosen = [str(n) for n in rng.choice(names, size=min(3, len(names)), replace=False)]
    for force in system.forces:
        chosen.append(str(rng.choice([name for name in names if name.endswith(f" of {force.name}")])))
    # A lag without a k2 has no effect.
    idle = ["lag of tide"] if any(getattr(force, "k2", 1.0) == 0.0 for force in system.forces) else []
    chosen = [name for name in dict.fromkeys(chosen) if name not in idle]
    forced = ", ".join(force.name for force in system.forces)
    way = "backward" if backward else "forward"
    integrator = (PAIRS | FIXED)[name]()
    event = happening(rng, system, state, until, integrator)
    label = f"{kinds} by {gravity}, {name}, {way}, {type(event).__name__}, with {forced or 'nothing'}"
    return Case(system, state, until, integrator, event, int(rng.integers(12 * count)), chosen, label)


def errors(case):
    """The largest differences from complete runs, over the scales of derivatives, by the names of what is varied.

    Compared are the ends of the runs, and the states and times of the event on the way.
    """
    system, state, run = case.system, case.state, case.run
    size = scales(system, state)
    sizes = np.concatenate([size, size, [size[0] / size[3]]])

    def numbers(**options):
        run = case.ended(**options)
        return run[-1], run.events[0].state, run.events[0].time

    event = run.at_event(0)
    index = (case.column // 12, case.column % 12 // 3, case.column % 3)

    end, image = slice(0, len(size)), slice(len(size), None)

    # Within their steps, derivatives are those of the motion, from which these methods' own differ by their error.
    both = (end,) if case.is_of_second_order else (end, image)

    def error(columns, change, natural, parts):
        columns, change = np.concatenate(columns) / sizes, change / sizes
        # Differences do not have the digits of a derivative that is smaller.
        least = ROUNDING / (STEPS[-1] * natural) / TOLERANCE
        return max(worst(columns[part], change[part], max(np.abs(change[part]).max(), least)) for part in parts)

    def least(columns, ends, natural, parts=both):
        # Principal axes are named anew, and rules of the quadrature change, beyond some change: there a shorter step
        # decides, and beside a loose tolerance a longer one.
        results = []
        for step in STEPS:
            try:
                change = differences(ends, step * natural)
            except InvalidInput:
                change = one_sided(ends, step * natural)
            results.append(error(columns, change, natural, parts))
            if results[-1] < TOLERANCE:
                break
        return min(results)

    columns = run.transition[-1][:, case.column], event.transition[:, case.column], event.time[[case.column]]
    moved = least(columns, lambda by: numbers(state=displaced(state, *index, by)), size[case.column])
    results = {f"column {case.column}": moved}
    for name in case.names:
        natural = system.context.natural_size(name)
        # Loads that are in proportion to their number allow for larger steps, in which they tell more.
        share = 20.0 if name.startswith(("k2", "lag", "along", "across", "factor", "force")) else 1.0
        columns = run.sensitivity[name][-1], event.sensitivity[name], [event.time_sensitivity[name]]
        results[name] = least(columns, lambda by, name=name: numbers(system=system.changed(name, by)), share * natural)
    if case.is_of_second_order:
        return results
    name, changed = parameter_of(case.event)
    columns = np.zeros(len(size)), event.sensitivity[name], [event.time_sensitivity[name]]
    results[name] = least(columns, lambda by: numbers(event=changed(by)), 1.0, parts=(image,))
    return results


def parameter_of(event):
    """The name of a number of an event, and the event with it changed."""
    if isinstance(event, fullbody.events.Separation):
        return "value of Separation", lambda by: replace(event, value=event.value + by)
    x, y, z = event.normal
    return "normal x of PlaneCrossing", lambda by: replace(event, normal=(x + by, y, z))


def asymmetry(case):
    """The largest change of the symplectic form by the transition matrices at the end, in natural sizes.

    Beside a third body the barycentre of the start is the centre of its path, and stays where it is.
    """
    system, size = case.system, scales(case.system, case.state)
    first, last = (size[:, np.newaxis] * symplectic_form(system, case.run[k]) * size for k in (0, -1))
    scaled = case.run.transition[-1] * size / size[:, np.newaxis]
    basis = np.eye(len(size))
    if system.forces:
        means = [np.kron([body.mass for body in system], np.eye(12)[k]) for k in range(6)]
        basis = null_space(means)
    change = scaled.T @ last @ scaled - first
    return np.abs(basis.T @ change @ basis).max() / np.abs(first).max()


def differences(ends, step):
    """The derivative of the ends of runs by central differences of sixth order."""
    by = [change(ends(-k * step), ends(k * step)) / (2 * k * step) for k in (1, 2, 3)]
    return 1.5 * by[0] - 0.6 * by[1] + 0.1 * by[2]


def one_sided(ends, step):
    """The derivative of the ends of runs by differences of seventh order, from the end of a parameter's range on."""
    central, order = ends(0.0), 7
    weights = [(-1) ** (k + 1) * comb(order, k) / k for k in range(1, order + 1)]
    return sum(w * change(central, ends(k * step)) for k, w in enumerate(weights, 1)) / step


def change(first, other):
    """The change of the end of a run, of the state at its event, and of the event's time."""
    return np.concatenate([deviation(first[0], other[0]), deviation(first[1], other[1]), [other[2] - first[2]]])
