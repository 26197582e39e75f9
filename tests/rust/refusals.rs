//! Lists of different lengths, numbers that are none and impossible masses are refused where an object is
//! made, by name.

use fullbody::dynamics::{Settings, State, System};
use fullbody::error::Error;
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, Simulation, Trajectory};
use std::ops::ControlFlow;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn two_points() -> State {
    let rest = vec![Vec3::zeros(); 2];
    State::new(0.0, vec![Vec3::zeros(), Vec3::x()], rest.clone(), vec![UPRIGHT; 2], rest).unwrap()
}

#[track_caller]
fn refused<T>(outcome: Result<T, Error>, with: &str) {
    let Err(error) = outcome else { panic!("not refused; expected {with:?}") };
    let text = error.to_string();
    assert!(matches!(error, Error::InvalidInput { .. }) && text.contains(with), "{text}");
}

#[test]
fn states() {
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
fn bodies() {
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
    let outcome = simulation.integrate(0.1, &Output::Ends, &mut record, &mut |_| ControlFlow::Continue(()));
    refused(outcome, "number of bodies of the record is 5; expected 2, as in the system");
    assert!(record.is_empty());
}

/// A record gives what the state itself has.
#[test]
fn samples_by_body() {
    let body = |name| Body::with_mass(name, Shape::ellipsoid([0.3, 0.2, 0.1]).unwrap(), 1.0).unwrap();
    let system = System::new(vec![body("A"), body("B")], 1.0, Settings::default()).unwrap();
    let start = two_points().with_spin(vec![Vec3::new(0.1, 0.2, 0.3), Vec3::new(-0.3, 0.1, 0.2)]).unwrap();
    let integrator = Integrator::Verner98(Tolerance::new(1e-9, 1e-9).unwrap());
    let mut simulation = Simulation::new(&system, &start, integrator).unwrap();
    let mut record = Trajectory::new(2);
    simulation.integrate(0.05, &Output::Ends, &mut record, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!((record.state(0), record.state(1)), (start, simulation.state()));
    assert_eq!(record.position(1, 1), simulation.state().position()[1]);
    assert_eq!(record.attitude(1, 0), simulation.state().attitude()[0]);
    assert_eq!(record.energy(0), simulation.start().energy);
    assert_eq!(record.angular_momentum(0), simulation.start().angular_momentum);
}
