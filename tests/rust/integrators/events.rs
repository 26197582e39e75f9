//! Events against closed forms.

use super::systems::*;
use fullbody::dynamics::{AttitudeChart, Settings, State, System};
use fullbody::error::Error;
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::mutual::Method;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{
    Condition, Event, Integrator, Output, Run, Simulation, StopReason, TangentOptions, Trajectory,
};
use std::f64::consts::PI;
use std::ops::ControlFlow;

fn run(simulation: &mut Simulation, until: f64, output: &Output, events: &mut [Event]) -> Trajectory {
    let mut record = Trajectory::new(2);
    let run = Run { output, events, dense: false, tangent_options: &TangentOptions::default() };
    simulation.run(until, run, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
    record
}

fn apsides() -> [Event<'static>; 2] {
    [
        Event::new(Condition::Periapsis { first: 0, second: 1 }),
        Event::new(Condition::Apoapsis { first: 0, second: 1 }),
    ]
}

/// Apsides of Kepler's orbit, forwards and backwards, by every integrator to its own accuracy.
#[test]
fn apsides_are_at_the_times_of_keplers_orbit() {
    let (system, state) = points(0.3);
    for (integrator, accuracy) in
        all(1e-13, 0.05).into_iter().zip([2e-9, 1e-10, 1e-11, 1e-11, 1e-12, 0.1, 1e-11, 1e-11, 1e-11])
    {
        for direction in [1.0, -1.0] {
            let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
            let record = run(&mut simulation, direction * 20.0, &Output::Steps, &mut apsides());
            assert_eq!(record.stop_reason, StopReason::End);
            // The start is at periapsis, which is no event.
            let kinds: Vec<usize> = record.events.iter().map(|e| e.event).collect();
            assert_eq!(kinds, [1, 0, 1, 0, 1, 0], "{integrator:?}");
            for (k, event) in record.events.iter().enumerate() {
                let error = (event.time - direction * PI * (k + 1) as f64).abs();
                assert!(error < accuracy, "{integrator:?}: {error:e}");
            }
        }
    }
}

/// Two spheres fall from rest until they touch.
fn falling(tolerance: f64) -> (Simulation, f64) {
    let sphere = |name, radius, mass| Body::with_mass(name, Shape::sphere(radius).unwrap(), mass).unwrap();
    let bodies = vec![sphere("A", 0.2, 0.6), sphere("B", 0.1, 0.4)];
    let system = System::new(bodies, 1.0, Settings::default()).unwrap();
    let state = relative(Vec3::new(0.6, 0.0, 0.8), Vec3::zeros(), 0.4);
    // From distance 1 with mu = 1: t = (acos sqrt x + sqrt(x (1 - x))) / sqrt 2 at x = 0.3.
    let x: f64 = 0.3;
    let time = (x.sqrt().acos() + (x * (1.0 - x)).sqrt()) / 2.0_f64.sqrt();
    (Simulation::new(&system, &state, verner98(tolerance)).unwrap(), time)
}

#[test]
fn contact_of_falling_spheres() {
    let (mut simulation, expected) = falling(1e-13);
    let mut events = [Event::new(Condition::Contact { first: 0, second: 1 }).terminal()];
    let record = run(&mut simulation, 3.0, &Output::Spacing(0.1), &mut events);
    assert_eq!(record.stop_reason, StopReason::Event(0));
    let last = *record.time.last().unwrap();
    assert!((last - expected).abs() < 1e-13, "{:e}", last - expected);
    assert_eq!(simulation.time(), last);
    let state = simulation.state();
    assert!(((state.position()[1] - state.position()[0]).norm() - 0.3).abs() < 1e-13);
    // From there back to rest.
    let back = run(&mut simulation, 0.0, &Output::Steps, &mut events);
    assert_eq!(back.stop_reason, StopReason::End);
    assert!(back.events.is_empty());
    let state = simulation.state();
    assert!((state.position()[1] - state.position()[0] - Vec3::new(0.6, 0.0, 0.8)).norm() < 1e-12);
}

/// Ellipsoids that slide past each other dip below a distance for less than a step; one that does not quite
/// is no event.
#[test]
fn dips_shorter_than_a_step_are_found() {
    let (system, state) = points(0.5);
    let tolerance = Tolerance::new(1e-6, 1e-6).unwrap();
    let integrator = Integrator::Verner98(tolerance);
    // Half way round to periapsis: nearest distance 0.5 at 2 pi, with the start at apoapsis.
    let apoapsis =
        run(&mut Simulation::new(&system, &state, verner98(1e-14)).unwrap(), PI, &Output::Steps, &mut []);
    let k = apoapsis.len() - 1;
    let vector = |values: &[f64], body: usize| Vec3::from_column_slice(&values[6 * k + 3 * body..][..3]);
    let both = |values: &[f64]| vec![vector(values, 0), vector(values, 1)];
    let start = State::new(
        0.0,
        both(&apoapsis.position),
        both(&apoapsis.velocity),
        state.attitude().to_vec(),
        state.spin().to_vec(),
    )
    .unwrap();
    for (offset, count) in [(1e-3, 2), (1e-5, 2), (-1e-3, 0)] {
        let mut simulation = Simulation::new(&system, &start, integrator).unwrap();
        let value = 0.5 + offset;
        let mut events = [Event::new(Condition::Separation { first: 0, second: 1, value })];
        let record = run(&mut simulation, 2.0 * PI, &Output::Steps, &mut events);
        assert_eq!(record.events.len(), count, "{offset}");
        if count == 2 {
            let (a, b) = (record.events[0].time, record.events[1].time);
            // Distance = a (1 - e cos E): both are E = acos((1 - value)/e) from periapsis.
            let anomaly = ((1.0 - value) / 0.5).acos();
            let mean = anomaly - 0.5 * anomaly.sin();
            let steps = record.time.windows(2).filter(|w| w[0] < b && w[1] > a).count();
            println!("dip of {:.3} across {steps} steps: {:e}", b - a, (b - a) / (2.0 * mean) - 1.0);
            assert!(((b - a) / (2.0 * mean) - 1.0).abs() < 0.02);
        }
        // One direction only.
        let mut events = [Event::new(Condition::Separation { first: 0, second: 1, value }).directed(-1)];
        simulation = Simulation::new(&system, &start, integrator).unwrap();
        assert_eq!(run(&mut simulation, 2.0 * PI, &Output::Steps, &mut events).events.len(), count / 2);
    }
}

/// Surfaces of ellipsoids that graze: two contacts within a step, or one and a stop.
#[test]
fn grazing_contacts_within_a_step_are_found() {
    let shape = Shape::ellipsoid([0.3, 0.2, 0.1]).unwrap();
    let bodies = ["A", "B"].map(|name| Body::with_mass(name, shape.clone(), 1e-15).unwrap());
    let settings = Settings { gravity: Method::Point, ..Settings::default() };
    let system = System::new(bodies.to_vec(), 1.0, settings).unwrap();
    // Straight past each other without gravity to speak of, along x, 0.4 - 1e-4 apart in y where 0.4 touches:
    // sqrt(F) = 1 where (x/0.6)^2 + (y/0.4)^2 = 1.
    let y: f64 = 0.4 - 1e-4;
    let state = relative(Vec3::new(-3.0, y, 0.0), Vec3::new(1.0, 0.0, 0.0), 0.5).with_time(5.0).unwrap();
    let half = 0.6 * (1.0 - (y / 0.4).powi(2)).sqrt();
    let mut events = [Event::new(Condition::Contact { first: 0, second: 1 }).terminal()];
    let mut simulation = Simulation::new(&system, &state, verner98(1e-8)).unwrap();
    let record = run(&mut simulation, 12.0, &Output::Steps, &mut events);
    assert_eq!(record.stop_reason, StopReason::Event(0));
    assert!((simulation.time() - (8.0 - half)).abs() < 1e-7, "{}", simulation.time());
    // Past the touching distance there is nothing to stop for.
    let state = relative(Vec3::new(-3.0, 0.4 + 1e-6, 0.0), Vec3::new(1.0, 0.0, 0.0), 0.5);
    let mut simulation = Simulation::new(&system, &state, verner98(1e-8)).unwrap();
    assert!(run(&mut simulation, 6.0, &Output::Steps, &mut events).events.is_empty());
}

/// A run records the same before a terminal event as without it, and it goes on from there.
#[test]
fn a_terminal_event_leaves_the_past() {
    let (system, state) = tumbling(Method::Multipole(4), AttitudeChart::Quaternion);
    for integrator in all(1e-10, 0.02) {
        let output = Output::Spacing(0.1);
        let mut plain = Simulation::new(&system, &state, integrator).unwrap();
        let whole = run(&mut plain, 6.0, &output, &mut []);
        let mut stopped = Simulation::new(&system, &state, integrator).unwrap();
        let mut events =
            [Event::new(Condition::Function(Box::new(|s: &State| Ok(s.time() - 2.345)))).terminal()];
        let part = run(&mut stopped, 6.0, &output, &mut events);
        assert_eq!(part.stop_reason, StopReason::Event(0));
        let n = part.len() - 1;
        assert_eq!(n, 24);
        assert_eq!(part.position[..6 * n], whole.position[..6 * n], "{integrator:?}");
        assert_eq!(part.spin[..6 * n], whole.spin[..6 * n]);
        assert!((part.time[n] - 2.345).abs() < 1e-15);
        assert_eq!(part.events[0].state, stopped.state());
        // Going on does not stop at once at the same event.
        let rest = run(&mut stopped, 6.0, &output, &mut events);
        assert_eq!(rest.stop_reason, StopReason::End);
        let error = difference(&stopped.state(), &plain.state());
        println!("{integrator:?}: after a stop {error:.1e}");
    }
}

/// Several at once come in the order of time, whatever their place in the list, and after a terminal one
/// there are none.
#[test]
fn events_come_in_the_order_of_time() {
    let (system, state) = points(0.2);
    let at = |time: f64| Event::new(Condition::Function(Box::new(move |s: &State| Ok(s.time() - time))));
    let mut events =
        [at(1.03), at(1.01), at(1.02).terminal(), at(1.02 + 1e-9), at(1.0), at(1.01).directed(-1)];
    let mut simulation = Simulation::new(&system, &state, verner98(1e-8)).unwrap();
    let record = run(&mut simulation, 3.0, &Output::Steps, &mut events);
    let order: Vec<usize> = record.events.iter().map(|e| e.event).collect();
    assert_eq!(order, [4, 1, 2]);
    let times: Vec<f64> = record.events.iter().map(|e| e.time).collect();
    for (time, expected) in times.iter().zip([1.0, 1.01, 1.02]) {
        assert!((time - expected).abs() <= 2.0 * f64::EPSILON, "{time}");
    }
}

/// Nodes, escape and alignment are found on orbits where they are known.
#[test]
fn nodes_escapes_and_alignments_are_found() {
    // A circular orbit through the x axis, inclined by 0.4: nodes every half period, rising ones every
    // period.
    let (system, _) = points(0.0);
    let start = relative(Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 0.4_f64.cos(), 0.4_f64.sin()), 0.3);
    let z = Vec3::z() * 3.0;
    let nodes = |reference| Condition::PlaneCrossing { body: 1, reference, normal: z };
    let mut events = [Event::new(nodes(Some(0))), Event::new(nodes(None)).directed(1)];
    let mut simulation = Simulation::new(&system, &start, verner98(1e-13)).unwrap();
    let record = run(&mut simulation, 13.0, &Output::Steps, &mut events);
    let all: Vec<f64> = record.events.iter().filter(|e| e.event == 0).map(|e| e.time).collect();
    assert_eq!(all.len(), 4);
    assert!(all.iter().enumerate().all(|(k, t)| (t - PI * (k + 1) as f64).abs() < 1e-11));
    assert_eq!(record.events.iter().filter(|e| e.event == 1).count(), 2);

    // Escape: a hyperbola passes distance 3.
    let start = relative(Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.6, 0.0), 0.3);
    let escape = |distance| Condition::Escape { first: 0, second: 1, distance };
    let mut events = [Event::new(escape(3.0)).terminal()];
    let mut simulation = Simulation::new(&system, &start, verner98(1e-13)).unwrap();
    assert_eq!(run(&mut simulation, 13.0, &Output::Steps, &mut events).stop_reason, StopReason::Event(0));
    let state = simulation.state();
    assert!(((state.position()[1] - state.position()[0]).norm() - 3.0).abs() < 1e-12);
    // An ellipse does not.
    let (_, bound) = points(0.5);
    let mut simulation = Simulation::new(&system, &bound, verner98(1e-10)).unwrap();
    let mut events = [Event::new(escape(1.2))];
    assert!(run(&mut simulation, 13.0, &Output::Steps, &mut events).events.is_empty());

    // A body that keeps its attitude (no torque from points), its long axis y, circled by the other: aligned
    // at quarter periods.
    let bodies = vec![
        Body::with_mass("A", Shape::ellipsoid([0.1, 0.2, 0.1]).unwrap(), 0.7).unwrap(),
        Body::with_mass("B", Shape::Point, 0.3).unwrap(),
    ];
    let settings = Settings { gravity: Method::Point, ..Settings::default() };
    let system = System::new(bodies, 1.0, settings).unwrap();
    let (_, start) = points(0.0);
    let mut simulation = Simulation::new(&system, &start, verner98(1e-13)).unwrap();
    let mut events = [Event::new(Condition::Alignment { body: 0, other: 1 })];
    let record = run(&mut simulation, 6.0, &Output::Steps, &mut events);
    let times: Vec<f64> = record.events.iter().map(|e| e.time).collect();
    assert_eq!(times.len(), 2);
    assert!((times[0] - 0.5 * PI).abs() < 1e-12 && (times[1] - 1.5 * PI).abs() < 1e-12);
}

#[test]
fn invalid_events_are_refused() {
    let (system, state) = points(0.2);
    let cases = [
        Event::new(Condition::Contact { first: 0, second: 2 }),
        Event::new(Condition::Periapsis { first: 1, second: 1 }),
        Event::new(Condition::Periapsis { first: 0, second: 1 }).directed(-1),
        Event::new(Condition::Separation { first: 0, second: 1, value: -1.0 }),
        Event::new(Condition::Alignment { body: 0, other: 1 }),
        Event::new(Condition::Function(Box::new(|_| Ok(f64::NAN)))),
        Event::new(Condition::Function(Box::new(|_| Err(Error::invalid("mine", 1, "two"))))),
    ];
    for event in cases {
        let mut record = Trajectory::new(2);
        let mut simulation = Simulation::new(&system, &state, verner98(1e-8)).unwrap();
        let run = Run {
            output: &Output::Steps,
            events: &mut [event],
            dense: false,
            tangent_options: &TangentOptions::default(),
        };
        let outcome = simulation.run(1.0, run, &mut record, &mut |_, _| ControlFlow::Continue(()));
        println!("{}", outcome.as_ref().unwrap_err());
        assert!(matches!(outcome, Err(Error::InvalidInput { .. })));
    }
}
