//! Nothing goes on for long without asking: by counted work, not by the clock.

use super::systems::*;
use crate::support::allocations;
use fullbody::dynamics::{Settings, State, System};
use fullbody::error::{Error, Refusal, Result};
use fullbody::integrate::{Equations, Scheme, Stepper, Tolerance, VERNER98};
use fullbody::interrupt::{HOOK_INTERVAL, InterruptCheck, UNITS};
use fullbody::math::lanes::VectorPath;
use fullbody::math::{Mat3, Vec3};
use fullbody::mutual::{Method, Pair, PartGravity, Pose};
use fullbody::shape::{Body, InputPart, Polyhedron, Proximity, Shape, gap_between};
use fullbody::trajectory::{
    Condition, Event, Integrator, Output, Run, Simulation, StopReason, TangentOptions, Trajectory,
};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

/// Calls with a hook that is due and breaks, so that whatever makes more than [`UNITS`] units of work is
/// interrupted at once.
fn impatient<T>(call: impl FnOnce(&mut InterruptCheck) -> Result<T>) -> Result<T> {
    let Some(long_ago) = Instant::now().checked_sub(2 * HOOK_INTERVAL) else {
        panic!("the clock began just now")
    };
    let mut hook = || ControlFlow::Break(());
    call(&mut InterruptCheck::since(long_ago, &mut hook))
}

#[track_caller]
fn interrupted<T>(outcome: Result<T>) -> f64 {
    match outcome {
        Err(Error::Interrupted { time }) => time,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not interrupted"),
    }
}

#[test]
fn asks_after_so_much_work() {
    impatient(|interrupt| (0..UNITS).try_for_each(|_| interrupt.charge(1, 0.0))).unwrap();
    assert_eq!(
        interrupted(impatient(|interrupt| (0..=UNITS).try_for_each(|_| interrupt.charge(1, 7.0)))),
        7.0
    );
    interrupted(impatient(|interrupt| interrupt.charge(UNITS + 1, 0.0)));
    // A hook that was called just now is not called again before its time, nor one that there is not.
    let mut hook = || ControlFlow::Break(());
    InterruptCheck::since(Instant::now() + HOOK_INTERVAL, &mut hook).charge(2 * UNITS, 0.0).unwrap();
    InterruptCheck::never().charge(u64::MAX, 0.0).unwrap();
    // What is done after a look counts: parts as large as may be are not made two at a time.
    let mut interrupt = InterruptCheck::never();
    (0..10).for_each(|_| interrupt.charge(UNITS, 0.0).unwrap());
    assert_eq!(interrupt.polls(), 9);
}

/// A lattice of bodies at rest.
fn lattice(count: usize, shape: Shape) -> (System, State) {
    let body = |k| Body::with_mass(format!("{k}"), shape.clone(), 1.0).unwrap();
    let system = System::new((0..count).map(body).collect(), 1.0, Settings::default()).unwrap();
    let place = |k: usize| Vec3::new((k % 10) as f64, (k / 10 % 10) as f64, (k / 100) as f64) * 10.0;
    let still = vec![Vec3::zeros(); count];
    let state = State::new(
        2.5,
        (0..count).map(place).collect(),
        still.clone(),
        vec![[1.0, 0.0, 0.0, 0.0]; count],
        still,
    );
    (system, state.unwrap())
}

/// Very many bodies: of one state, in the making of a simulation, and within one evaluation of their forces.
#[test]
fn forces_of_many_bodies_are_interrupted() {
    let (system, state) = lattice(60, Shape::sphere(1.0).unwrap());
    assert_eq!(interrupted(impatient(|interrupt| system.interactions_with(&state, interrupt))), 2.5);
    interrupted(impatient(|interrupt| system.energy_with(&state, interrupt)));
    interrupted(impatient(|interrupt| Simulation::begin(&system, &state, verner98(1e-9), interrupt)));
    let (system, state) = lattice(220, Shape::sphere(1.0).unwrap());
    interrupted(impatient(|interrupt| system.momentum_with(&state, interrupt)));
    interrupted(impatient(|interrupt| system.angular_momentum_with(&state, interrupt)));

    // 24,090 pairs, and a step chooses their rules before. A pair of spheres takes a quarter of a
    // microsecond, and twice that where memory is slow: a part of an evaluation has no more than 5,000 of
    // them, which take some milliseconds.
    for integrator in [verner98(1e-9), Integrator::LieGroupVariational { step: 0.1 }] {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        assert!(simulation.dynamics().parts() >= 24_090 / 5_000);
        assert_eq!(interrupted(impatient(|interrupt| simulation.step_with(9.0, interrupt))), 2.5);
        assert_eq!(simulation.state(), state);
    }
}

/// Archives of very many bodies are read, and the rules of their pairs chosen, with checks for interrupts.
#[test]
fn many_bodies_of_an_archive() {
    let (system, state) = lattice(60, Shape::ellipsoid([1.0, 0.9, 0.8]).unwrap());
    let mut simulation = Simulation::new(&system, &state, verner98(1e-9)).unwrap();
    simulation.step(9.0).unwrap();
    let bytes = simulation.to_bytes().unwrap();
    interrupted(impatient(|interrupt| Simulation::from_bytes(&bytes, interrupt)));
    assert_eq!(read(&bytes).unwrap().state(), simulation.state());
    // Making the pairs is most of it; their 1,770 rules have dozens of nodes each.
    let ((rules, switches), mut dynamics) = (simulation.dynamics().memory(), simulation.dynamics().clone());
    interrupted(impatient(|interrupt| dynamics.restore_memory(&rules, &switches, interrupt)));
    // 11,175 pairs.
    let (system, state) = lattice(150, Shape::sphere(1.0).unwrap());
    let simulation = Simulation::new(&system, &state, verner98(1e-9)).unwrap();
    let mut dynamics = simulation.dynamics().clone();
    interrupted(impatient(|interrupt| dynamics.copy_rules(simulation.dynamics(), interrupt)));
}

/// Two bodies so close that their rule is found by comparing some with ten thousands of nodes.
#[test]
fn comparisons_of_rules_are_interrupted() {
    let (system, state) = lattice(2, Shape::ellipsoid([1.0, 0.9, 0.05]).unwrap());
    let state = replaced(state, |[position, ..]| position[1] = Vec3::new(0.0, 0.0, 0.1 + 1e-4));
    let counted = |outcome: Result<()>| assert_eq!(interrupted(outcome), 2.5);
    let settings = Settings { gravity: Method::Surface, ..Settings::default() };
    let system = System::new(system.bodies().to_vec(), 1.0, settings).unwrap();
    counted(impatient(|interrupt| system.interactions_with(&state, interrupt).map(drop)));
    counted(impatient(|interrupt| Simulation::begin(&system, &state, verner98(1e-9), interrupt).map(drop)));
}

/// A cube of unit side whose triangles are cut in four so many times.
fn cube(cuts: usize) -> Polyhedron {
    let whole = crate::polyhedron::cuboid([-0.5; 3], [1.0; 3]);
    let mut vertices: Vec<Vec3> = whole.input_vertices().collect();
    let mut faces = whole.faces().to_vec();
    for _ in 0..cuts {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push(0.5 * (vertices[a as usize] + vertices[b as usize]));
                vertices.len() as u32 - 1
            })
        };
        let cut = |[a, b, c]: &[u32; 3]| {
            let [d, e, f] = [middle(*a, *b), middle(*b, *c), middle(*c, *a)];
            [[*a, d, f], [d, *b, e], [f, e, *c], [d, e, f]]
        };
        faces = faces.iter().flat_map(cut).collect();
    }
    Polyhedron::new(&vertices, &faces, &mut InterruptCheck::never()).unwrap()
}

/// Two cubes whose triangles are cut in four so many times.
fn two_cubes(cuts: usize, gravity: Method, distance: f64) -> (System, State) {
    let body = |name| Body::with_mass(name, Shape::Polyhedron(cube(cuts)), 1.0).unwrap();
    let settings = Settings { gravity, gravity_tolerance: 1e-3, ..Settings::default() };
    let system = System::new(vec![body("A"), body("B")], 1.0, settings).unwrap();
    let state = relative(Vec3::new(distance, 0.1, 0.2), Vec3::zeros(), 0.5);
    (system, state.with_time(2.5).unwrap())
}

/// One evaluation of two large polyhedra takes a second and more: it is made in pieces, which are the whole.
/// Two of 192 faces, a tenth of their side apart, already need more than one piece.
#[test]
fn large_polyhedra_near_by() {
    let (system, state) = two_cubes(2, Method::Focal, 1.1);
    let mut simulation = Simulation::new(&system, &state, verner98(1e-3)).unwrap();
    let mut dynamics = simulation.dynamics().clone();
    let [pair] = &dynamics.pairs().map(|(.., pair)| pair.clone()).collect::<Vec<_>>()[..] else { panic!() };
    // 192 faces as seen from four points on each of 192 others.
    let work = 192 * 192 * 4;
    assert!(pair.work() >= work);
    let few = |work: u64, times: u64| work.div_ceil(times) <= UNITS * 11 / 10;
    assert!(few(pair.work(), pair.pieces().len() as u64));
    assert_eq!(dynamics.parts(), pair.pieces().len());
    assert!(dynamics.work() <= UNITS * 11 / 10);

    let pose = Pose {
        separation: state.position()[1] - state.position()[0],
        rotation_first: Mat3::identity(),
        rotation_second: Mat3::identity(),
    };
    let whole = pair.interaction(&pose);
    let energy: f64 = pair.pieces().map(|nodes| pair.potential_energy_of(&pose, nodes)).sum();
    assert!((energy / pair.potential_energy(&pose) - 1.0).abs() < 1e-13);
    let (_, vector, _) = fullbody::dynamics::BarycentricFrame::new(system.layout(), &system.masses(), &state);
    (0..dynamics.parts()).for_each(|part| dynamics.load(part, 2.5, &vector).unwrap());
    let (acceleration, torque) = dynamics.loads();
    let force = whole.force_on_first.norm();
    assert!((acceleration[0] - whole.force_on_first).norm() < 1e-13 * force);
    assert!((acceleration[1] + whole.force_on_first).norm() < 1e-13 * force);
    assert!((torque[0] - whole.torque_first).norm() < 1e-13 * force);
    assert!((torque[1] - whole.torque_second).norm() < 1e-13 * force);

    // Looks at the clock in proportion to the work: choosing the rule takes two evaluations, the result one,
    // with its energy.
    let mut interrupt = InterruptCheck::never();
    system.interactions_with(&state, &mut interrupt).unwrap();
    assert!(few(4 * work, interrupt.polls()), "{}", interrupt.polls());
    assert_eq!(interrupted(impatient(|interrupt| system.interactions_with(&state, interrupt))), 2.5);
    assert_eq!(interrupted(impatient(|interrupt| system.energy_with(&state, interrupt))), 2.5);
    interrupted(impatient(|interrupt| Simulation::begin(&system, &state, verner98(1e-3), interrupt)));
    let velocities = vec![Vec3::zeros(); 2];
    assert_eq!(interrupted(impatient(|p| dynamics.energy(2.5, &vector, &velocities, p))), 2.5);
    assert_eq!(interrupted(impatient(|interrupt| simulation.step_with(9.0, interrupt))), 2.5);
    assert_eq!(simulation.state(), state);
}

/// A large polyhedron in an ellipsoid's field is evaluated in pieces too.
#[test]
fn a_large_polyhedron_beside_an_ellipsoid() {
    let store = Arc::default();
    let mesh = Shape::Polyhedron(cube(6));
    let stone = Shape::ellipsoid([0.3, 0.2, 0.1]).unwrap();
    let bodies = [PartGravity::new("A", &mesh, &store), PartGravity::new("B", &stone, &store)];
    let [first, second] = bodies;
    let arch = VectorPath::Auto.arch().unwrap();
    let mut pair = Pair::new(first, second, Method::Focal, 1e-6, None, arch);
    let pose = Pose {
        separation: Vec3::new(0.75, 0.1, 0.2),
        rotation_first: Mat3::identity(),
        rotation_second: Mat3::identity(),
    };
    pair.prepare(&pose, 0.0, &mut InterruptCheck::never()).unwrap();
    let whole = pair.interaction(&pose);
    assert!(pair.pieces().len() > 1 && pair.work() >= 4 * 49_152);
    let pieces: Vec<_> = pair.pieces().map(|nodes| pair.interaction_of(&pose, nodes)).collect();
    let force: Vec3 = pieces.iter().map(|piece| piece.force_on_first).sum();
    let torques: [Vec3; 2] = [
        pieces.iter().map(|piece| piece.torque_first).sum(),
        pieces.iter().map(|piece| piece.torque_second).sum(),
    ];
    let size = whole.force_on_first.norm();
    assert!((force - whole.force_on_first).norm() < 1e-13 * size);
    assert!((torques[0] - whole.torque_first).norm() < 1e-13 * size);
    assert!((torques[1] - whole.torque_second).norm() < 1e-13 * size);
    let pieces = pair.energy_pieces(&pose, &mut InterruptCheck::never()).unwrap();
    let energy: f64 = pieces.into_iter().map(|nodes| pair.potential_energy_of(&pose, nodes)).sum();
    assert!((energy / pair.potential_energy(&pose) - 1.0).abs() < 1e-13);
    // Faces are divided otherwise at another pose; the pieces have each part once all the same.
    let [nearer, before] = [Vec3::new(0.71, 0.15, 0.2), pose.separation];
    for separation in [nearer, before] {
        let pose = Pose { separation, ..pose };
        let whole = pair.interaction(&pose).force_on_first;
        let counted = allocations();
        let again = pair.interaction(&pose);
        assert_eq!(allocations(), counted);
        assert_eq!(again.force_on_first, whole);
        let sum: Vec3 = pair.pieces().map(|nodes| pair.interaction_of(&pose, nodes).force_on_first).sum();
        assert!((sum - whole).norm() < 1e-13 * size);
    }
    interrupted(impatient(|interrupt| pair.prepare(&pose, 0.0, interrupt)));
}

/// Whether composites of many parts overlap is asked part by part.
#[test]
fn overlap_of_many_parts() {
    let parts = |n: usize| {
        let part = |k: usize| InputPart {
            shape: Shape::sphere(0.4).unwrap(),
            mass: 1.0,
            position: [k as f64, (k * k % 7) as f64, 0.0],
            attitude: [1.0, 0.0, 0.0, 0.0],
        };
        Body::composite("A", (0..n).map(part).collect()).unwrap()
    };
    let (first, second) = (parts(400), parts(400));
    let turn = Mat3::identity();
    let separation = Vec3::new(0.0, 0.0, 0.81);
    let meet = |interrupt: &mut InterruptCheck| {
        Proximity::compute([&first, &second], &separation, [&turn, &turn], 2.5, interrupt)
    };
    assert!(!meet(&mut InterruptCheck::never()).unwrap().overlap);
    assert_eq!(interrupted(impatient(meet)), 2.5);
}

#[test]
fn overlap_of_two_large_polyhedra_is_interrupted() {
    let shape = Shape::Polyhedron(cube(4));
    let gap = |interrupt: &mut InterruptCheck| {
        gap_between([&shape; 2], &Vec3::new(0.5, 0.3, 0.2), [&Mat3::identity(); 2], 2.5, interrupt)
    };
    assert!(gap(&mut InterruptCheck::never()).unwrap().unwrap() < 0.0);
    assert_eq!(interrupted(impatient(gap)), 2.5);
}

/// The moments of a large mesh are computed once, when they are first needed.
#[test]
fn moments_of_a_large_polyhedron() {
    for (gravity, distance) in [(Method::Focal, 3.0), (Method::Multipole(16), 3.0)] {
        let make = || two_cubes(3, gravity, distance);
        let (system, state) = make();
        assert_eq!(interrupted(impatient(|interrupt| system.interactions_with(&state, interrupt))), 2.5);
        assert_eq!(interrupted(impatient(|interrupt| make().0.energy_with(&state, interrupt))), 2.5);
        interrupted(impatient(|interrupt| Simulation::begin(&make().0, &state, verner98(1e-3), interrupt)));
        // Once they are there nobody is asked.
        system.interactions(&state).unwrap();
        impatient(|interrupt| system.interactions_with(&state, interrupt)).unwrap();
    }
}

/// Whether an archive's polyhedra are solids is looked into once more when they are read.
#[test]
fn reading_a_large_polyhedron() {
    let body = |name, shape| Body::with_mass(name, shape, 1.0).unwrap();
    let bodies = vec![body("A", Shape::Polyhedron(cube(5))), body("B", Shape::Point)];
    let settings = Settings { gravity: Method::Point, ..Settings::default() };
    let state = relative(Vec3::new(3.0, 0.1, 0.2), Vec3::zeros(), 0.5);
    let simulation =
        Simulation::new(&System::new(bodies, 1.0, settings).unwrap(), &state, verner98(1e-3)).unwrap();
    let bytes = simulation.to_bytes().unwrap();
    interrupted(impatient(|interrupt| Simulation::from_bytes(&bytes, interrupt)));
    let read = Simulation::from_bytes(&bytes, &mut InterruptCheck::never()).unwrap();
    assert_eq!(read.description(), simulation.description());
}

/// Whether bodies have met in a step is asked of every pair: of 51,040 spheres, and of no points.
#[test]
fn the_watch_for_contacts_is_interrupted() {
    let looks = |shape| {
        let (system, state) = lattice(320, shape);
        let integrator = Integrator::LieGroupVariational { step: 1e-3 };
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let mut interrupt = InterruptCheck::never();
        simulation.step_with(9.0, &mut interrupt).unwrap();
        interrupt.polls()
    };
    let (spheres, points) = (looks(Shape::sphere(1.0).unwrap()), looks(Shape::Point));
    println!("{spheres} {points}");
    assert!(spheres >= points + 2, "{spheres} {points}");
}

/// An evaluation in parts is one evaluation.
#[test]
fn parts_make_a_whole() {
    let (system, state) = lattice(160, Shape::ellipsoid([1.0, 0.9, 0.8]).unwrap());
    let state = replaced(state, |[position, ..]| {
        for (k, place) in position.iter_mut().enumerate() {
            *place += Vec3::new((k as f64).sin(), (2.0 * k as f64).sin(), (3.0 * k as f64).sin());
        }
    });
    let simulation = Simulation::new(&system, &state, verner98(1e-9)).unwrap();
    let mut dynamics = simulation.dynamics().clone();
    assert!(dynamics.parts() > 1);
    let (_, vector, _) = fullbody::dynamics::BarycentricFrame::new(system.layout(), &system.masses(), &state);
    (0..dynamics.parts()).for_each(|part| dynamics.load(part, 0.0, &vector).unwrap());
    let expected = system.interactions(&state).unwrap();
    let largest = expected.force.iter().map(|force| force.norm()).fold(0.0, f64::max);
    for (acceleration, force) in dynamics.loads().0.iter().zip(&expected.force) {
        assert!((acceleration - force).norm() < 1e-13 * largest);
    }
    let largest = expected.torque.iter().map(|torque| torque.norm()).fold(0.0, f64::max);
    assert!(largest > 0.0);
    for (torque, expected) in dynamics.loads().1.iter().zip(&expected.torque) {
        assert!((torque - expected).norm() < 1e-12 * largest);
    }
}

/// Equations that cannot be evaluated any more after the first step has been planned.
struct Refusing {
    evaluations: u32,
}

impl Equations for Refusing {
    fn work(&self) -> u64 {
        UNITS / 10
    }

    fn prepare(&mut self, _: f64, _: &[f64], _: f64, _: &mut InterruptCheck) -> Result<()> {
        Ok(())
    }

    fn derivative(
        &mut self,
        _: usize,
        _: f64,
        _: &[f64],
        rate: &mut [f64],
    ) -> std::result::Result<(), Refusal> {
        rate.fill(1.0);
        self.evaluations += 1;
        if self.evaluations > 2 { Err(Refusal::Shorter("refused")) } else { Ok(()) }
    }

    fn norm(&mut self, _: &[f64], v: &[f64], _: &Tolerance) -> f64 {
        v[0].abs()
    }

    fn restore(&mut self, _: &mut [f64], _: &mut [f64]) {}
}

#[test]
fn endless_rejections_are_interrupted() {
    let tolerance = Tolerance::new(1e-9, 1e-9).unwrap();
    let mut stepper = Stepper::new(&VERNER98, tolerance, 0.0, vec![1.0], vec![0.0]);
    interrupted(impatient(|interrupt| stepper.step(&mut Refusing { evaluations: 0 }, 1.0, interrupt)));
    assert_eq!((stepper.time(), stepper.vector().0[0], stepper.statistics().steps), (0.0, 1.0, 0));
}

/// A sphere beside a point that spins fast: what is between the ends of a fixed step takes very many steps of
/// its own.
fn beside_a_spinning_point(spin: f64) -> (System, State) {
    let bodies = vec![
        Body::with_mass("A", Shape::sphere(1.0).unwrap(), 1.0).unwrap(),
        Body::with_mass("B", Shape::Point, 1.0).unwrap(),
    ];
    let system =
        System::new(bodies, 1.0, Settings { gravity: Method::Point, ..Settings::default() }).unwrap();
    let state = relative(Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, 0.8, 0.0), 0.5);
    (system, replaced(state, |[.., spins]| spins[1] = Vec3::new(0.0, 0.0, spin)))
}

#[test]
fn the_inside_of_a_fixed_step() {
    let (system, state) = beside_a_spinning_point(1e9);
    for integrator in [
        Integrator::LieGroupVariational { step: 0.1 },
        Integrator::SymplecticSplitting { step: 0.1, scheme: Scheme::Leapfrog },
    ] {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let go = |simulation: &mut Simulation, hook: &mut dyn FnMut() -> ControlFlow<()>| {
            let mut record = Trajectory::new(2);
            let run = Run {
                output: &Output::Steps,
                events: &mut [],
                dense: true,
                tangent_options: &TangentOptions::default(),
            };
            let outcome = simulation.run(1.0, run, &mut record, &mut |_, _| hook());
            (record, outcome)
        };
        // So many that they are refused, with what to do.
        let (_, outcome) = go(&mut simulation, &mut || ControlFlow::Continue(()));
        let error = outcome.unwrap_err();
        println!("{error}");
        assert!(matches!(error, Error::NotConverged { .. }));
        assert!(error.to_string().contains("use a shorter step"));
        assert_eq!(simulation.state(), state.clone());
    }
}

/// A body that turns too far in a step for the free rotation is refused with the numbers, and the step that
/// is advised does.
#[test]
fn steps_too_long_for_a_rotor_are_refused_with_advice() {
    let bodies = |name: &str, axes| Body::with_mass(name, Shape::ellipsoid(axes).unwrap(), 1.0).unwrap();
    let spinner = bodies("Spinner", [1.0, 0.8, 0.6]);
    let system =
        System::new(vec![bodies("Still", [1.0, 0.9, 0.8]), spinner], 1e-9, Settings::default()).unwrap();
    let state = relative(Vec3::new(8.0, 0.0, 0.0), Vec3::zeros(), 0.5);
    let state = replaced(state, |[.., spins]| spins[1] = Vec3::new(0.0, 3e6, 1e7));
    for make in [
        |step| Integrator::SymplecticSplitting { step, scheme: Scheme::Aba864 },
        |step| Integrator::LieGroupVariational { step },
    ] {
        let step = |step: f64| {
            let mut simulation = Simulation::new(&system, &state, make(step)).unwrap();
            let outcome = simulation.step(9.0);
            outcome.map(|()| simulation.time())
        };
        let message = step(0.5).unwrap_err().to_string();
        println!("{message}");
        assert!(
            message.contains("Spinner rotates by") && message.contains("use a step of at most "),
            "{message}"
        );
        let advised: f64 = message.rsplit(' ').next().unwrap().parse().unwrap();
        assert!(advised > 1e-9);
        assert_eq!(step(advised).unwrap(), advised);
    }
}

/// Samples without end, and events in pieces without end.
#[test]
fn samples_and_events_are_interrupted() {
    let (system, state) = points(0.3);
    for output in [Output::Spacing(1.1e-8), Output::Steps] {
        let mut simulation = Simulation::new(&system, &state, verner98(1e-9)).unwrap();
        let mut record = Trajectory::new(2);
        let mut events = [Event::new(Condition::Periapsis { first: 0, second: 1 })];
        let run = Run {
            output: &output,
            events: &mut events,
            dense: false,
            tangent_options: &TangentOptions::default(),
        };
        let mut calls = 0;
        let outcome = simulation.run(10.0, run, &mut record, &mut |_, _| {
            calls += 1;
            // The first call is that of the start.
            if calls > 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        // Steps of two points are over before the hook is due, or it breaks.
        if matches!(output, Output::Spacing(_)) {
            interrupted(outcome);
            assert_eq!((calls, record.stop_reason), (2, StopReason::Interrupted));
            assert!(!record.is_empty());
        }
    }
}
