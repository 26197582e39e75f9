//! Many simulations over threads: each as if it were alone, and all of them heard.

use crate::integrators::systems::{all, points, replaced, triple, tumbling, verner98};
use fullbody::dynamics::{AttitudeChart, State, System};
use fullbody::ensemble::{Member, MemberOutcome, run};
use fullbody::error::Error;
use fullbody::integrate::Statistics;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::mutual::{Method, Store};
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{
    Condition, Event, Integrator, Output, Run, Simulation, StopReason, TangentOptions, Trajectory,
};
use fullbody::workers::{JobProgress, JobSource};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::Arc;

type Start = (System, State, Integrator);

fn member((system, state, integrator): &Start, until: f64, condition: Option<Condition<'static>>) -> Member {
    Member {
        system: system.clone(),
        state: state.clone(),
        integrator: *integrator,
        until,
        output: Output::Spacing(0.7),
        events: condition.into_iter().map(Event::new).collect(),
        dense: true,
        tangent_options: TangentOptions::default(),
    }
}

/// Hands out what a function gives of each place, and keeps what comes back in that place.
struct Keeper<M> {
    next: M,
    asked: usize,
    answers: Vec<Option<MemberOutcome>>,
    /// The most members that were handed out and not answered.
    ahead: usize,
    /// The hook stops once something is under way, if this is set.
    stops: bool,
    seen: Vec<JobProgress>,
}

impl<M: FnMut(usize) -> Option<Member>> JobSource for Keeper<M> {
    type Job = (usize, Member);
    type Answer = (usize, MemberOutcome);

    fn next(&mut self) -> Option<(usize, Member)> {
        let member = (self.next)(self.asked)?;
        self.asked += 1;
        self.answers.push(None);
        self.ahead = self.ahead.max(self.answers.iter().filter(|answer| answer.is_none()).count());
        Some((self.asked - 1, member))
    }

    fn take(&mut self, (tag, answer): (usize, MemberOutcome)) -> ControlFlow<()> {
        assert!(self.answers[tag].replace(answer).is_none(), "member {tag} has two answers");
        ControlFlow::Continue(())
    }

    fn proceed(&mut self, progress: JobProgress) -> ControlFlow<()> {
        self.seen.push(progress);
        if self.stops && progress.under_way > 0.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

fn run_all(
    threads: usize,
    stops: bool,
    next: impl FnMut(usize) -> Option<Member>,
) -> Keeper<impl FnMut(usize) -> Option<Member>> {
    let mut keeper = Keeper { next, asked: 0, answers: Vec::new(), ahead: 0, stops, seen: Vec::new() };
    run(&mut keeper, NonZeroUsize::new(threads)).unwrap();
    keeper
}

fn starts() -> Vec<Start> {
    let mut starts = Vec::new();
    for (k, integrator) in all(1e-9, 0.05).into_iter().enumerate() {
        let (system, mut state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
        // At other distances, where other orders of the quadrature are enough.
        state = replaced(state, |[position, ..]| position[1].x += 0.2 * k as f64);
        starts.push((system, state, integrator));
    }
    let (system, state) = tumbling(Method::Surface, AttitudeChart::TaitBryan);
    starts.push((system, state, verner98(1e-9)));
    let (system, state) = triple();
    starts.push((system, state, verner98(1e-9)));
    starts
}

/// The records of a simulation on its own.
fn alone(start: &Start, until: f64) -> (Trajectory, Statistics) {
    let mut member = member(start, until, Some(Condition::Periapsis { first: 0, second: 1 }));
    let mut simulation = Simulation::new(&start.0, &start.1, start.2).unwrap();
    let mut record = Trajectory::new(start.0.bodies().len());
    let run = Run {
        output: &member.output,
        events: &mut member.events,
        dense: true,
        tangent_options: &TangentOptions::default(),
    };
    simulation.run(until, run, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
    (record, simulation.statistics())
}

#[test]
fn each_has_the_bits_of_a_single_run_for_any_number_of_threads() {
    let starts = starts();
    let expected: Vec<_> = starts.iter().map(|start| alone(start, 10.0)).collect();
    for threads in [1, 2, 5] {
        let periapsis = || Some(Condition::Periapsis { first: 0, second: 1 });
        let kept = run_all(threads, false, |k| Some(member(starts.get(k)?, 10.0, periapsis())));
        assert_eq!(kept.answers.len(), starts.len());
        let mut events = 0;
        for (k, (answer, (record, statistics))) in kept.answers.into_iter().zip(&expected).enumerate() {
            let ran = answer.unwrap().unwrap().unwrap();
            assert_eq!(ran.error, None);
            events += ran.record.events.len();
            assert!(
                ran.record == *record && ran.statistics == *statistics,
                "member {k} in {threads} threads"
            );
        }
        assert!(events > 0);
        assert_eq!(kept.seen.last(), Some(&JobProgress { done: starts.len(), under_way: 0.0 }));
    }
}

#[test]
fn members_are_asked_for_as_they_are_needed() {
    let (system, state) = points(0.3);
    let start = (system, state, verner98(1e-6));
    let kept = run_all(2, false, |k| (k < 200).then(|| member(&start, 1.0, None)));
    assert_eq!(kept.answers.len(), 200);
    assert!(kept.ahead <= 16, "{} were waiting", kept.ahead);
}

#[test]
fn one_that_fails_leaves_the_others_alone() {
    let starts = starts();
    let kept = run_all(2, false, |k| {
        let mut member = member(starts.get(k)?, 2.0, None);
        match k {
            1 => {
                member.state = replaced(member.state, |[position, ..]| {
                    position[1] = position[0] + Vec3::new(0.1, 0.0, 0.0);
                });
            }
            2 => {
                let failing =
                    |_: &State| Err(Error::invalid("a function", "out of order", "something better"));
                member.events.push(Event::new(Condition::Function(Box::new(failing))));
            }
            3 => member.until = f64::NAN,
            _ => {}
        }
        Some(member)
    });
    for (k, answer) in kept.answers.into_iter().enumerate() {
        match (k, answer.unwrap().unwrap()) {
            (1, Err(Error::BodiesOverlap { time, .. })) => assert_eq!(time, 0.0),
            (2 | 3, Ok(ran)) => {
                assert!(matches!(ran.error, Some(Error::InvalidInput { .. })));
                assert_eq!(ran.record.stop_reason, StopReason::Unfinished);
            }
            (_, answer) => assert_eq!(answer.unwrap().error, None, "member {k}"),
        }
    }
}

#[test]
fn a_caller_who_stops_has_what_there_is() {
    let (system, state) = points(0.3);
    let start = (system, state, verner98(1e-6));
    // The first two are short; the others would go on for years.
    let kept = run_all(2, true, |k| Some(member(&start, if k < 2 { 1.0 } else { 1e8 }, None)));
    let (mut whole, mut stopped, mut waiting) = (0, 0, 0);
    for (k, answer) in kept.answers.into_iter().enumerate() {
        match answer.unwrap() {
            Some(Ok(ran)) if k < 2 => {
                assert_eq!((ran.time, ran.error), (1.0, None));
                whole += 1;
            }
            Some(Ok(ran)) => {
                assert!(matches!(ran.error, Some(Error::Interrupted { .. })));
                assert_eq!(ran.record.stop_reason, StopReason::Interrupted);
                assert!(ran.time > 0.0 && ran.record.len() > 1);
                stopped += 1;
            }
            None => waiting += 1,
            Some(Err(error)) => panic!("{error}"),
        }
    }
    assert_eq!((whole, stopped), (2, 2));
    assert!(waiting > 0);
}

#[test]
#[should_panic(expected = "a fault in a thread")]
fn a_panic_comes_to_the_caller() {
    let (system, state) = points(0.3);
    let start = (system, state, verner98(1e-6));
    run_all(2, false, |k| {
        let fault = |_: &State| panic!("a fault in a thread");
        Some(member(&start, 1e8, (k == 0).then(|| Condition::Function(Box::new(fault)))))
    });
}

#[test]
fn nodes_and_series_of_equal_shapes_are_made_once() {
    for method in [Method::Focal, Method::Surface] {
        let store = Arc::new(Store::default());
        assert!(store.is_empty());
        let mut counts = Vec::new();
        for k in 0..3 {
            let (system, mut state) = tumbling(method, AttitudeChart::Quaternion);
            state = replaced(state, |[.., spin]| spin[1].z += 0.1 * f64::from(k));
            let system = system.with_store(store.clone());
            let mut record = Trajectory::new(2);
            let mut simulation =
                Simulation::begin(&system, &state, verner98(1e-9), &mut InterruptCheck::never()).unwrap();
            simulation.integrate(1.0, &Output::Ends, &mut record).unwrap();
            assert_eq!(record.time, [0.0, 1.0]);
            counts.push(store.len());
        }
        let [rules, series, ..] = counts[0];
        assert!(rules > 0 && series == 4, "{counts:?}");
        assert_eq!(counts, [counts[0]; 3]);
    }
}

/// The facets and layers of a polyhedron belong to it: to its copies, and to no other one that is the same.
#[test]
fn facets_and_layers_of_a_polyhedron_are_made_once() {
    let store = Arc::new(Store::default());
    let (start, mut state) = tumbling(Method::Surface, AttitudeChart::Quaternion);
    // Far enough for a layer.
    state = replaced(state, |[position, ..]| position[1] *= 2.0);
    let cuboid = || Shape::Polyhedron(crate::polyhedron::cuboid([-0.4, -0.3, -0.2], [0.8, 0.6, 0.4]));
    let mut counts = Vec::new();
    let mut forces = Vec::new();
    let given = cuboid();
    for shape in [given.clone(), given.clone(), cuboid()] {
        let bodies = vec![Body::with_mass("A", shape, 0.8).unwrap(), start.bodies()[1].clone()];
        let system = System::new(bodies, 1.0, *start.settings()).unwrap();
        let own = system.interactions(&state).unwrap();
        let system = system.with_store(store.clone());
        let shared = system.interactions(&state).unwrap();
        assert_eq!((own.force.clone(), own.torque), (shared.force, shared.torque));
        counts.push(store.len());
        forces.push(own.force);
    }
    let [_, _, facets, layers] = counts[0];
    assert_eq!((facets, layers), (1, 1));
    assert_eq!(counts[1], counts[0]);
    assert_eq!(counts[2][2..], [2, 2]);
    assert_eq!(forces[2], forces[0]);
}
