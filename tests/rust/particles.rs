//! Massless particles: their motion, their events, and many of them over threads.

use crate::integrators::systems::{contact_binary, tumbling, verner98};
use fullbody::dynamics::{AttitudeChart, State, System};
use fullbody::error::{Error, Result};
use fullbody::integrate::{Tolerance, VERNER98};
use fullbody::math::Vec3;
use fullbody::mutual::Method;
use fullbody::particles::{
    ContactResponse, FlightPlan, FlightRecord, Particle, ParticleCondition, ParticleEvent, Rules,
};
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{
    Condition, Dense, Event, Output, Progress, Run, Simulation, TangentOptions, Trajectory,
};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;

/// Returns the continuous solution of a system and the times of its events.
fn motion(system: &System, state: &State, until: f64, events: &mut [Event]) -> (Dense, Vec<f64>) {
    let mut record = Trajectory::new(system.bodies().len());
    let run = Run { output: &Output::Ends, events, dense: true, tangent_options: &TangentOptions::default() };
    let mut simulation = Simulation::new(system, state, verner98(1e-13)).unwrap();
    simulation.run(until, run, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let times = record.events.iter().map(|event| event.time).collect();
    (record.dense.unwrap(), times)
}

/// The particles at the end of a flight, with its samples and events, and its result.
struct Flight {
    particles: Vec<Particle>,
    record: FlightRecord,
    outcome: Result<()>,
}

/// Integrates particles among the bodies of a system, with two outputs.
fn fly(
    (system, dense): (&System, &Dense),
    particles: &[Particle],
    until: f64,
    events: &[ParticleEvent],
    threads: usize,
    hook: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
) -> Flight {
    let tolerance = Tolerance::new(1e-13, 1e-13).unwrap();
    let rules = Rules { tableau: &VERNER98, tolerance, contact: ContactResponse::Stop, escape: None };
    let output = [0.5 * until, until];
    let plan = FlightPlan {
        system,
        dense,
        until,
        output: &output,
        rules: &rules,
        radiation: None,
        events,
        threads: NonZeroUsize::new(threads),
    };
    let (mut particles, mut record) = (particles.to_vec(), FlightRecord::default());
    let outcome = plan.fly(&mut particles, &mut record, hook);
    Flight { particles, record, outcome }
}

fn proceed(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Returns particles on nearly circular orbits of several radii about a mass of one.
fn circles(count: usize) -> Vec<Particle> {
    let circle = |k: usize| {
        let (radius, angle) = (4.0 + 0.01 * k as f64, k as f64);
        let (radial, tangential) =
            (Vec3::new(angle.cos(), angle.sin(), 0.1), Vec3::new(-angle.sin(), angle.cos(), 0.0));
        Particle::new(0.0, &(radial * radius), &(tangential / radius.sqrt()), 0.0)
    };
    (0..count).map(circle).collect()
}

/// Returns an event at the zeros of a function of time.
fn function(f: impl Fn(f64) -> f64 + Sync + 'static) -> ParticleEvent {
    ParticleEvent {
        condition: ParticleCondition::Function(Box::new(move |time, _, _| Ok(f(time)))),
        direction: 0,
    }
}

#[test]
fn a_particle_moves_as_a_body_of_hardly_any_mass() {
    let (system, state) = contact_binary();
    let (dense, _) = motion(&system, &state, 3.0, &mut []);
    let (position, velocity) = (Vec3::new(0.3, -1.4, 0.5), Vec3::new(0.8, 0.1, -0.1));
    let particle = Particle::new(0.0, &position, &velocity, 0.0);
    let flight = fly((&system, &dense), &[particle], 3.0, &[], 1, &mut proceed);
    flight.outcome.unwrap();
    let mut bodies = system.bodies().to_vec();
    bodies.push(Body::with_mass("C", Shape::Point, 1e-17).unwrap());
    let extended = System::new(bodies, 1.0, *system.settings()).unwrap();
    let append = |vectors: &[Vec3], last: Vec3| [vectors, &[last]].concat();
    let start = State::new(
        state.time(),
        append(state.position(), position),
        append(state.velocity(), velocity),
        [state.attitude(), &[[1.0, 0.0, 0.0, 0.0]]].concat(),
        append(state.spin(), Vec3::zeros()),
    )
    .unwrap();
    let mut simulation = Simulation::new(&extended, &start, verner98(1e-13)).unwrap();
    let mut record = Trajectory::new(3);
    simulation.integrate(3.0, &Output::Ends, &mut record).unwrap();
    let end = simulation.state();
    let [x, y, z, ..] = flight.particles[0].motion;
    assert!((Vec3::new(x, y, z) - end.position()[2]).norm() < 1e-10, "{x} {y} {z} for {}", end.position()[2]);
}

/// The function (t - 5)^2 - w^2 has both of its zeros between two neighbouring samples of a step.
#[test]
fn two_zeros_near_a_minimum_are_found_for_bodies_and_particles() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    for width in [0.03, 0.01, 1e-4] {
        let parabola = move |time: f64| (time - 5.0).powi(2) - width * width;
        let condition = Condition::Function(Box::new(move |state: &State| Ok(parabola(state.time()))));
        let (dense, times) = motion(&system, &state, 24.0, &mut [Event::new(condition)]);
        // The steps of the particle are long, since its distance is thirty times that between the bodies.
        let far = Particle::new(0.0, &Vec3::new(50.0, 0.0, 0.0), &Vec3::new(0.0, 0.14, 0.0), 0.0);
        let flight = fly((&system, &dense), &[far], 24.0, &[function(parabola)], 1, &mut proceed);
        let particle_times: Vec<f64> = flight.record.occurrences.iter().map(|event| event.time).collect();
        for times in [times, particle_times] {
            assert_eq!(times.len(), 2, "{width}: {times:?}");
            assert!((times[0] - (5.0 - width)).abs() + (times[1] - (5.0 + width)).abs() < 1e-11, "{times:?}");
        }
        let rising: Vec<bool> = flight.record.occurrences.iter().map(|event| event.rising).collect();
        assert_eq!(rising, [false, true]);
    }
}

#[test]
fn flights_have_the_same_bits_for_any_number_of_threads() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let (dense, _) = motion(&system, &state, 10.0, &mut []);
    let particles = circles(100);
    let events = || vec![function(|time| (2.0 * time).sin())];
    let alone = fly((&system, &dense), &particles[77..78], 10.0, &events(), 1, &mut proceed);
    let expected = fly((&system, &dense), &particles, 10.0, &events(), 1, &mut proceed);
    assert_eq!(expected.record.occurrences.len(), 6 * particles.len());
    assert_eq!(expected.particles[77].motion, alone.particles[0].motion);
    for threads in [2, 5] {
        let flight = fly((&system, &dense), &particles, 10.0, &events(), threads, &mut proceed);
        assert_eq!(flight.outcome, Ok(()));
        assert_eq!(flight.record.samples, expected.record.samples);
        assert_eq!(flight.record.occurrences, expected.record.occurrences);
        let ends = |flight: &Flight| flight.particles.iter().map(|p| (p.time, p.motion)).collect::<Vec<_>>();
        assert_eq!(ends(&flight), ends(&expected));
    }
}

#[test]
fn a_hook_that_breaks_leaves_the_particles_where_they_are() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let (dense, _) = motion(&system, &state, 10.0, &mut []);
    for allowed in [0, 1, 2] {
        let mut calls = 0;
        let mut hook = |progress: Progress| {
            assert!(progress.start == 0.0 && progress.end == 10.0 && (0.0..=10.0).contains(&progress.time));
            calls += 1;
            if calls > allowed { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let flight = fly((&system, &dense), &circles(300), 10.0, &[], 2, &mut hook);
        assert!(matches!(flight.outcome, Err(Error::Interrupted { .. })), "{:?}", flight.outcome);
        assert_eq!(flight.record.samples.len(), 2 * 6 * 300);
        for particle in &flight.particles {
            assert!((0.0..=10.0).contains(&particle.time) && particle.motion.iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn an_error_of_an_event_is_the_error_of_the_flight() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let (dense, _) = motion(&system, &state, 10.0, &mut []);
    let function_with_nan = |time| if time > 6.0 { f64::NAN } else { 1.0 };
    for threads in [1, 3] {
        let flight = fly(
            (&system, &dense),
            &circles(200),
            10.0,
            &[function(function_with_nan)],
            threads,
            &mut proceed,
        );
        let error = flight.outcome.unwrap_err().to_string();
        assert!(error.starts_with("value of an event of particle"), "{error}");
    }
}
