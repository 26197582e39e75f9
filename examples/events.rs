//! Events of a run: `cargo run --release --example events`. A small body falls past a larger one; the program
//! prints its nearest passage, and ends where it leaves.

use fullbody::dynamics::{Settings, State, System};
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Condition, Event, Integrator, Output, Run, Simulation, Trajectory};
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let large = Body::with_mass("Large", Shape::ellipsoid([1.2, 1.0, 0.8])?, 1.0)?;
    let small = Body::with_mass("Small", Shape::ellipsoid([0.2, 0.15, 0.1])?, 0.01)?;
    let system = System::new(vec![large, small], 1.0, Settings::default())?;
    let state = State::new(
        0.0,
        vec![Vec3::zeros(), Vec3::new(-8.0, 3.0, 0.2)],
        vec![Vec3::zeros(), Vec3::new(0.7, 0.0, 0.0)],
        vec![[1.0, 0.0, 0.0, 0.0]; 2],
        vec![Vec3::new(0.0, 0.0, 0.3), Vec3::zeros()],
    )?;

    let between = (0, 1);
    let nearest = Event::new(Condition::Periapsis { first: between.0, second: between.1 });
    let gone = Condition::Separation { first: between.0, second: between.1, value: 9.0 };
    // The distance grows through the value: the body leaves.
    let mut events = [nearest, Event::new(gone).directed(1).terminal()];
    let mut simulation =
        Simulation::new(&system, &state, Integrator::Verner98(Tolerance::new(1e-12, 1e-12)?))?;
    let mut record = Trajectory::new(2);
    let run = Run { events: &mut events, ..Run::new(&Output::Ends) };
    simulation.run(100.0, run, &mut record, &mut |_, _| ControlFlow::Continue(()))?;

    for occurrence in &record.events {
        let position = occurrence.state.position();
        let distance = (position[1] - position[0]).norm();
        println!("event {} at {:.6}, {distance:.6} apart", occurrence.event, occurrence.time);
    }
    println!("the run ended by {:?} at {:.6}", record.stop_reason, simulation.time());
    let spin = simulation.state().spin()[0];
    println!("the passage has left the large body with the spin {:.4} {:.4} {:.4}", spin.x, spin.y, spin.z);
    Ok(())
}
