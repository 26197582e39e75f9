//! Lists of different lengths, numbers that are none and impossible masses are refused where an object is
//! made, by name.

use fullbody::dynamics::{Parameter, Settings, State, System};
use fullbody::error::Error;
use fullbody::gravity::{Attractor, BodyField, GravityOutput, Points};
use fullbody::integrate::{Tolerance, VERNER98};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::{Mat3, Vec3};
use fullbody::mutual::Method;
use fullbody::particles::{
    ContactResponse, FlightPlan, FlightRecord, Particle, ParticleCondition, ParticleEvent, Rules,
};
use fullbody::photometry::{Law, Photometer, Surface, View};
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, Run, Simulation, TangentOptions, Trajectory};
use std::ops::ControlFlow;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn two_points() -> State {
    let rest = vec![Vec3::zeros(); 2];
    State::new(0.0, vec![Vec3::zeros(), Vec3::x()], rest.clone(), vec![UPRIGHT; 2], rest).unwrap()
}

fn points(names: &[&str]) -> System {
    let body = |name: &&str| Body::with_mass(*name, Shape::Point, 1.0).unwrap();
    System::new(names.iter().map(body).collect(), 1.0, Settings::default()).unwrap()
}

fn verner() -> Integrator {
    Integrator::Verner98(Tolerance::new(1e-9, 1e-9).unwrap())
}

#[track_caller]
fn refused<T>(outcome: Result<T, Error>, with: &str) {
    let Err(error) = outcome else { panic!("not refused; expected {with:?}") };
    let text = error.to_string();
    assert!(matches!(error, Error::InvalidInput { .. }) && text.contains(with), "{text}");
}

#[test]
fn invalid_states_are_refused() {
    let one = vec![Vec3::zeros()];
    refused(two_points().with_velocity(one.clone()), "number of bodies in velocity is 1; expected 2");
    refused(two_points().with_spin(one.clone()), "number of bodies in spin is 1; expected 2");
    refused(two_points().with_attitude(vec![UPRIGHT]), "number of bodies in attitude is 1; expected 2");
    refused(two_points().with_position(one), "number of bodies in velocity is 2; expected 1");
    refused(two_points().with_position(vec![]), "number of bodies in position is 0");
    refused(
        two_points().with_position(vec![Vec3::zeros(), Vec3::new(0.0, f64::NAN, 1.0)]),
        "position of body 1",
    );
    refused(two_points().with_attitude(vec![UPRIGHT, [0.0; 4]]), "attitude of body 1 is [0, 0, 0, 0]");
    refused(two_points().with_time(f64::INFINITY), "time");
}

#[test]
fn invalid_bodies_are_refused() {
    for mass in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        refused(Body::with_mass("Alpha", Shape::Point, mass), "mass of Alpha");
    }
    refused(Body::with_density("Alpha", Shape::sphere(1.0).unwrap(), -2.0), "density of Alpha");
    refused(Body::with_density("Alpha", Shape::Point, 2.0), "density of Alpha is 2; expected a mass");
}

#[test]
fn records_of_another_number_of_bodies() {
    let body = |name| Body::with_mass(name, Shape::Point, 1.0).unwrap();
    let system = System::new(vec![body("A"), body("B")], 1.0, Settings::default()).unwrap();
    let integrator = Integrator::Verner98(Tolerance::new(1e-9, 1e-9).unwrap());
    let mut simulation = Simulation::new(&system, &two_points(), integrator).unwrap();
    let mut record = Trajectory::new(5);
    let outcome = simulation.integrate(0.1, &Output::Ends, &mut record);
    refused(outcome, "number of bodies of the record is 5; expected 2, as in the system");
    assert!(record.is_empty());
}

/// A record gives what the state itself has.
#[test]
fn samples_by_body_are_those_of_the_state() {
    let body = |name| Body::with_mass(name, Shape::ellipsoid([0.3, 0.2, 0.1]).unwrap(), 1.0).unwrap();
    let system = System::new(vec![body("A"), body("B")], 1.0, Settings::default()).unwrap();
    let start = two_points().with_spin(vec![Vec3::new(0.1, 0.2, 0.3), Vec3::new(-0.3, 0.1, 0.2)]).unwrap();
    let integrator = Integrator::Verner98(Tolerance::new(1e-9, 1e-9).unwrap());
    let mut simulation = Simulation::new(&system, &start, integrator).unwrap();
    let mut record = Trajectory::new(2);
    simulation.integrate(0.05, &Output::Ends, &mut record).unwrap();
    assert_eq!((record.state(0), record.state(1)), (start, simulation.state()));
    assert_eq!(record.position(1, 1), simulation.state().position()[1]);
    assert_eq!(record.attitude(1, 0), simulation.state().attitude()[0]);
    assert_eq!(record.energy(0), simulation.start().energy);
    assert_eq!(record.angular_momentum(0), simulation.start().angular_momentum);
}

#[test]
fn records_whose_arrays_differ_in_length() {
    let mut simulation = Simulation::new(&points(&["A", "B"]), &two_points(), verner()).unwrap();
    let mut record = Trajectory::new(2);
    record.position = vec![1.0; 5];
    let outcome = simulation.integrate(0.1, &Output::Ends, &mut record);
    refused(outcome, "numbers of position in the record is 5; expected 0, as of 0 samples");
}

#[test]
fn degrees_of_the_series() {
    for degree in [0, 1, 61] {
        let settings = Settings { gravity: Method::Multipole(degree), ..Settings::default() };
        let body = Body::with_mass("A", Shape::Point, 1.0).unwrap();
        refused(System::new(vec![body], 1.0, settings), &format!("gravity is \"multipole:{degree}\""));
    }
}

#[test]
fn steps_towards_no_time() {
    for integrator in [verner(), Integrator::LieGroupVariational { step: 0.1 }] {
        let mut simulation = Simulation::new(&points(&["A", "B"]), &two_points(), integrator).unwrap();
        refused(simulation.step(f64::NAN), "end of a step is NaN");
        assert_eq!(simulation.time(), 0.0);
    }
}

#[test]
fn parameters_that_the_system_does_not_have() {
    let system = points(&["A", "B"]);
    for parameter in
        [Parameter::Mass(2), Parameter::SemiAxis(0, 3), Parameter::Scale(0), Parameter::Density(0, 1.0)]
    {
        refused(parameter.changed(&system, 0.1), &format!("parameter is {parameter:?}"));
        let mut simulation = Simulation::new(&system, &two_points(), verner()).unwrap();
        let tangent_options = &TangentOptions::derivatives(vec![parameter]);
        let run = Run { tangent_options, ..Run::new(&Output::Ends) };
        let outcome =
            simulation.run(0.1, run, &mut Trajectory::new(2), &mut |_, _| ControlFlow::Continue(()));
        refused(outcome, &format!("parameter is {parameter:?}"));
    }
}

#[test]
fn arrays_of_gravity_at_points() {
    let system = points(&["A"]);
    let interrupt = &mut InterruptCheck::never();
    let field = BodyField::new(&system.bodies()[0], 1.0, system.arch(), interrupt).unwrap();
    let attractor = Attractor { field: &field, position: Vec3::zeros(), rotation: Mat3::identity() };
    for (coordinates, potentials, fields) in [(4, 1, 3), (6, 1, 3), (3, 2, 3), (3, 1, 6)] {
        let (coordinates, mut potential) = (vec![2.0; coordinates], vec![0.0; potentials]);
        let asked = Points { coordinates: &coordinates, shape: &[1], first_index: 0 };
        let output = GravityOutput::Field(&mut potential, &mut vec![0.0; fields]);
        let outcome = asked.gravity(&[attractor], output, system.arch(), interrupt);
        refused(outcome, "lengths of the arrays of gravity at points");
    }
}

#[test]
fn invalid_flights_are_refused() {
    let system = points(&["A", "B"]);
    let mut record = Trajectory::new(2);
    let run = Run { dense: true, ..Run::new(&Output::Ends) };
    let mut simulation = Simulation::new(&system, &two_points(), verner()).unwrap();
    simulation.run(0.1, run, &mut record, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let dense = record.dense.unwrap();
    let tolerance = Tolerance::new(1e-9, 1e-9).unwrap();
    let rules = Rules { tableau: &VERNER98, tolerance, contact: ContactResponse::Stop, escape: None };
    let particle = |time| Particle::new(time, &Vec3::new(0.0, 0.0, 4.0), &Vec3::zeros(), 0.0);
    let fly = |system: &System, output: &[f64], events: &[ParticleEvent], mut particles: Vec<Particle>| {
        let plan = FlightPlan {
            system,
            dense: &dense,
            until: 0.1,
            output,
            rules: &rules,
            radiation: None,
            events,
            threads: None,
        };
        let mut record = FlightRecord { samples: vec![7.0; 5], occurrences: Vec::new() };
        plan.fly(&mut particles, &mut record, &mut |_| ControlFlow::Continue(())).map(|()| record.samples)
    };
    let one = || vec![particle(0.0)];
    // What the record held before is gone.
    assert_eq!(fly(&system, &[0.0], &[], one()).unwrap(), [0.0, 0.0, 4.0, 0.0, 0.0, 0.0]);
    refused(
        fly(&points(&["A", "B", "C"]), &[0.1], &[], one()),
        "number of bodies of the run is 2; expected 3",
    );
    refused(fly(&system, &[f64::NAN], &[], one()), "output");
    refused(fly(&system, &[0.1, 0.0], &[], one()), "output is 0.1 followed by 0");
    refused(fly(&system, &[0.2], &[], one()), "a time in output is 0.2");
    refused(fly(&system, &[0.1], &[], vec![particle(0.0), particle(0.05)]), "time of particle 1 is 0.05");
    let watch = ParticleEvent { condition: ParticleCondition::Periapsis { body: 2 }, direction: 0 };
    refused(fly(&system, &[0.1], &[watch], one()), "body of Periapsis is 2; expected 0 to 1");
}

#[test]
fn invalid_views_are_refused() {
    let body = |name| Body::with_mass(name, Shape::sphere(0.2).unwrap(), 1.0).unwrap();
    let surface = Surface { law: Law::LOMMEL_SEELIGER, albedo: vec![1.0] };
    let photometer = Photometer::new(vec![body("A"), body("B")], vec![surface; 2], true, 0.0).unwrap();
    let seen = |position: &[Vec3], attitude: &[[f64; 4]]| {
        let view = View {
            time: 0.0,
            position,
            attitude,
            velocity: &[],
            to_observer: Vec3::x(),
            to_sun: Vec3::x(),
            distant: true,
        };
        photometer.brightness(&view, &mut InterruptCheck::never())
    };
    let apart = [Vec3::zeros(), Vec3::x()];
    assert!(seen(&apart, &[UPRIGHT; 2]).is_ok());
    refused(seen(&apart, &[UPRIGHT, [0.0; 4]]), "attitude of body 1 is [0, 0, 0, 0]");
    refused(seen(&apart, &[[f64::NAN; 4], UPRIGHT]), "attitude of body 0");
    refused(seen(&[Vec3::zeros(), Vec3::new(f64::NAN, 0.0, 0.0)], &[UPRIGHT; 2]), "position of body 1");
    refused(seen(&apart[..1], &[UPRIGHT; 2]), "number of positions is 1; expected 2");
}
