//! Particles among moving bodies: `cargo run --release --example particles`. A ring of dust starts from near the
//! equator of the larger body of 1999 KW4, in km, hours and kg. Prints what became of it.

use fullbody::dynamics::{Settings, State, System};
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::particles::{ContactResponse, Escape, Fate, FlightPlan, FlightRecord, Particle, Rules};
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, Run, Simulation, Trajectory};
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let alpha = Body::with_mass("Alpha", Shape::ellipsoid([0.766, 0.7475, 0.6735])?, 2.353e12)?;
    let beta = Body::with_mass("Beta", Shape::ellipsoid([0.285, 0.2315, 0.1745])?, 0.135e12)?;
    let system = System::new(vec![alpha, beta], 8.64960768e-13, Settings::default())?;
    let state = State::new(
        0.0,
        vec![Vec3::zeros(), Vec3::new(2.548, 0.0, 0.0)],
        vec![Vec3::zeros(), Vec3::new(0.0, 0.919, 0.0)],
        vec![[1.0, 0.0, 0.0, 0.0]; 2],
        vec![Vec3::new(0.0, 0.0, 2.27), Vec3::new(0.0, 0.0, 0.36)],
    )?;

    // The bodies move once, and the particles follow their continuous solution.
    let mut simulation =
        Simulation::new(&system, &state, Integrator::Verner98(Tolerance::new(1e-12, 1e-12)?))?;
    let mut record = Trajectory::new(2);
    let run = Run { dense: true, ..Run::new(&Output::Ends) };
    simulation.run(100.0, run, &mut record, &mut |_, _| ControlFlow::Continue(()))?;
    let dense = record.dense.ok_or("the continuous solution was asked for")?;

    let dust = |k: u32| {
        let (angle, speed) = (0.1 * f64::from(k), 1.6 + 0.012 * f64::from(k));
        let outwards = Vec3::new(angle.cos(), angle.sin(), 0.0);
        Particle::new(0.0, &(0.8 * outwards), &(speed * Vec3::new(-angle.sin(), angle.cos(), 0.1)), 0.0)
    };
    let mut particles: Vec<Particle> = (0..63).map(dust).collect();
    let rules = Rules {
        contact: ContactResponse::Stop,
        escape: Some(Escape { distance: 20.0, unbound: true }),
        ..Rules::new(Tolerance::new(1e-10, 1e-10)?)
    };
    let plan = FlightPlan::new(&system, &dense, 100.0, &rules);
    plan.fly(&mut particles, &mut FlightRecord::default(), &mut |_| ControlFlow::Continue(()))?;

    for (body, name) in ["Alpha", "Beta"].iter().enumerate() {
        let fallen = particles.iter().filter(|p| p.end.fate == Fate::Impact && p.end.body == Some(body));
        println!("on {name}: {}", fallen.count());
    }
    for fate in [Fate::Escape, Fate::Flying] {
        println!("{fate:?}: {}", particles.iter().filter(|p| p.end.fate == fate).count());
    }
    Ok(())
}
