//! A run that is interrupted, archived and gone on with equals the unbroken one bit for bit, also between its
//! steps: events, dense output, samples, counts.

use super::systems::*;
use fullbody::dynamics::{AttitudeChart, State, System};
use fullbody::error::{Error, Result};
use fullbody::integrate::{Scheme, Statistics};
use fullbody::math::Vec3;
use fullbody::mutual::Method;
use fullbody::trajectory::{
    Condition, Event, Integrator, Occurrence, Output, Run, Simulation, StopReason, TangentOptions, Trajectory,
};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Every kind of event that two bodies can have without touching.
fn events<'a>() -> Vec<Event<'a>> {
    let height = |state: &State| Ok(state.position()[1].z);
    [
        Condition::Periapsis { first: 0, second: 1 },
        Condition::Apoapsis { first: 0, second: 1 },
        Condition::Separation { first: 0, second: 1, value: 1.5 },
        Condition::Contact { first: 0, second: 1 },
        Condition::PlaneCrossing { body: 1, reference: Some(0), normal: Vec3::z() },
        Condition::PlaneCrossing { body: 1, reference: None, normal: Vec3::new(1.0, 0.3, 0.0) },
        Condition::Escape { first: 0, second: 1, distance: 0.5 },
        Condition::Function(Box::new(height)),
    ]
    .map(Event::new)
    .into()
}

/// An event that never happens, whose function fails after a time in the direction of a run: Ctrl-C within a
/// caller's function.
fn interruption<'a>(after: f64, direction: f64) -> Event<'a> {
    Event::new(Condition::Function(Box::new(move |state: &State| -> Result<f64> {
        if (state.time() - after) * direction > 0.0 {
            return Err(Error::Interrupted { time: state.time() });
        }
        Ok(1.0)
    })))
}

fn run(
    simulation: &mut Simulation,
    until: f64,
    times: &[f64],
    events: &mut [Event],
) -> (Trajectory, Result<()>) {
    let mut record = Trajectory::new(2);
    let run = Run {
        output: &Output::Times(times.to_vec()),
        events,
        dense: true,
        tangent_options: &TangentOptions::default(),
    };
    let outcome = simulation.run(until, run, &mut record, &mut |_, _| ControlFlow::Continue(()));
    (record, outcome)
}

fn sum(a: Statistics, b: Statistics) -> [u64; 3] {
    [a.steps + b.steps, a.rejected + b.rejected, a.evaluations + b.evaluations]
}

fn difference(a: Statistics, b: Statistics) -> Statistics {
    Statistics {
        steps: a.steps - b.steps,
        rejected: a.rejected - b.rejected,
        evaluations: a.evaluations - b.evaluations,
    }
}

/// Compares an unbroken run with one that is interrupted within a step after a time, archived, and gone on
/// with.
fn compare(
    system: &System,
    state: &State,
    integrator: Integrator,
    until: f64,
    share: f64,
) -> Vec<Occurrence> {
    let label = format!("{integrator:?} to {until}, interrupted at {share}");
    let times: Vec<f64> = (1..=80).map(|k| until * f64::from(k) / 80.0).collect();
    let mut whole = Simulation::new(system, state, integrator).unwrap();
    let (unbroken, outcome) = run(&mut whole, until, &times, &mut events());
    outcome.unwrap();

    let mut first = Simulation::new(system, state, integrator).unwrap();
    let mut watched = events();
    watched.push(interruption(share * until, until));
    let (begun, outcome) = run(&mut first, until, &times, &mut watched);
    assert!(matches!(outcome, Err(Error::Interrupted { .. })), "{label}");
    assert_eq!(begun.stop_reason, StopReason::Interrupted);
    let now = first.time();
    assert!((share * until - now) * until >= 0.0 && now.abs() < until.abs(), "{label}: {now}");
    assert_eq!(begun.dense.as_ref().unwrap().range(), (0.0, now));
    let mut second = read(&first.to_bytes().unwrap()).unwrap();
    let rest: Vec<f64> = times.iter().copied().filter(|t| t.abs() > now.abs()).collect();
    let (resumed, outcome) = run(&mut second, until, &rest, &mut events());
    outcome.unwrap();

    // A run that is cut short ends with the state that it came to; the samples before it are those asked for.
    assert_eq!(begun.time.last(), Some(&now), "{label}");
    let kept = times.iter().filter(|t| t.abs() <= now.abs()).count();
    assert_eq!(second.state(), whole.state(), "{label}");
    let found = [begun.events, resumed.events].concat();
    assert_eq!(found, unbroken.events, "{label}");
    for (of, [a, b], all) in [
        ("times", [&begun.time, &resumed.time], &unbroken.time),
        ("positions", [&begun.position, &resumed.position], &unbroken.position),
        ("velocities", [&begun.velocity, &resumed.velocity], &unbroken.velocity),
        ("attitudes", [&begun.attitude, &resumed.attitude], &unbroken.attitude),
        ("spins", [&begun.spin, &resumed.spin], &unbroken.spin),
        ("energies", [&begun.energy, &resumed.energy], &unbroken.energy),
        ("momenta", [&begun.angular_momentum, &resumed.angular_momentum], &unbroken.angular_momentum),
    ] {
        let width = all.len() / times.len();
        assert!(a[..width * kept].iter().chain(b).eq(all), "{of} of {label}");
    }
    let [a, b, all] = [begun.dense, resumed.dense, unbroken.dense].map(Option::unwrap);
    // Places all over the run, those where the parts meet and end among them.
    let places = (0..500).map(|k| until * (0.618_033_988_749_895 * f64::from(k)).fract());
    for time in places.chain([now, until, 0.0]) {
        let part = if time.abs() < now.abs() { &a } else { &b };
        assert_eq!(part.state(time).unwrap(), all.state(time).unwrap(), "{label} at {time}");
    }
    assert_eq!(a.state(now).unwrap(), b.state(now).unwrap(), "{label}");
    // What is found in a run does not depend on what else is asked of it.
    let mut plain = Simulation::new(system, state, integrator).unwrap();
    let mut record = Trajectory::new(2);
    let output = Output::Steps;
    let only = Run {
        output: &output,
        events: &mut events(),
        dense: false,
        tangent_options: &TangentOptions::default(),
    };
    plain.run(until, only, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!(record.events, found, "{label}");
    let counts = difference(second.statistics(), first.statistics());
    let expected = whole.statistics();
    assert_eq!(
        sum(first.statistics(), counts),
        [expected.steps, expected.rejected, expected.evaluations],
        "{label}"
    );
    assert_eq!(plain.statistics(), expected, "{label}");
    found
}

/// Every integrator, chart and direction; fixed steps so long that several polynomials are needed between
/// their ends.
#[test]
fn every_integrator_between_its_steps() {
    for (method, chart) in [
        (Method::Focal, AttitudeChart::Quaternion),
        (Method::Surface, AttitudeChart::Quaternion),
        (Method::Multipole(4), AttitudeChart::TaitBryan),
    ] {
        let (system, state) = tumbling(method, chart);
        for tolerance in [1e-6, 1e-11] {
            for integrator in all(tolerance, if tolerance > 1e-9 { 0.6 } else { 0.1 }) {
                if Simulation::new(&system, &state, integrator).is_err() {
                    assert_eq!(chart, AttitudeChart::TaitBryan);
                    continue;
                }
                for (until, share) in [(9.0, 0.0), (9.0, 0.31), (9.0, 0.77), (-9.0, 0.31)] {
                    let found = compare(&system, &state, integrator, until, share);
                    assert!(found.len() > 5, "{}", found.len());
                }
            }
        }
    }
}

/// Steps that end where the events happen, to rounding, and interruptions just there: the apsides and nodes
/// of Kepler's orbit are found once each.
#[test]
fn events_at_the_ends_of_steps() {
    let (system, state) = points(0.3);
    let mut bodies = system.bodies().to_vec();
    // The same orbit with a shape, so that every condition has a meaning.
    let ball = fullbody::shape::Shape::sphere(0.1).unwrap();
    bodies[0] = fullbody::shape::Body::with_mass(bodies[0].name(), ball, bodies[0].mass()).unwrap();
    let system = System::new(bodies, 1.0, *system.settings()).unwrap();
    for pieces in [4, 7, 16] {
        let step = PI / f64::from(pieces);
        for scheme in [Scheme::Leapfrog, Scheme::Aba864, Scheme::Aba1064] {
            let integrator = Integrator::SymplecticSplitting { step, scheme };
            for half_turn in 0..6 {
                let share = (f64::from(half_turn) + 1e-3) / 6.001;
                for until in [6.001 * PI, -6.001 * PI] {
                    let found = compare(&system, &state, integrator, until, share);
                    let apsides: Vec<_> = found.iter().filter(|found| found.event < 2).collect();
                    let kinds: Vec<_> = apsides.iter().map(|found| found.event).collect();
                    assert_eq!(kinds, [1, 0, 1, 0, 1, 0], "{integrator:?} to {until} at {share}");
                    for (k, found) in apsides.iter().enumerate() {
                        let expected = (PI * (k + 1) as f64).copysign(until);
                        assert!((found.time - expected).abs() < 1e-11, "{:e}", found.time - expected);
                    }
                }
            }
        }
    }
}

/// The state that a simulation is given is no event, and stays none through an archive.
#[test]
fn a_terminal_event_is_not_found_again() {
    let (system, state) = points(0.3);
    for integrator in all(1e-12, 0.1) {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let apoapsis = || Event::new(Condition::Apoapsis { first: 0, second: 1 }).terminal();
        let mut last = 0.0;
        for _ in 0..3 {
            simulation = read(&simulation.to_bytes().unwrap()).unwrap();
            let (record, outcome) = run(&mut simulation, 30.0, &[], &mut [apoapsis()]);
            outcome.unwrap();
            assert_eq!(record.stop_reason, StopReason::Event(0));
            assert!(simulation.time() > last + 3.0, "{integrator:?}: {} after {last}", simulation.time());
            last = simulation.time();
        }
    }
}
