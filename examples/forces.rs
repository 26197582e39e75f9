//! External forces: `cargo run --release --example forces`. A binary, in km, hours and kg, under the Sun, a tide
//! and a drag of the program's own. Prints the work of each, and how well the energy without them holds.

use fullbody::dynamics::{Settings, State, System};
use fullbody::forces::{Force, Function, Path, ThirdBody, Tide, WhoseOrbit};
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::orbit::KeplerElements;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, Simulation, Trajectory};

const G: f64 = 8.64960768e-13;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let alpha = Body::with_mass("Alpha", Shape::ellipsoid([0.766, 0.7475, 0.6735])?, 2.353e12)?;
    let beta = Body::with_mass("Beta", Shape::ellipsoid([0.285, 0.2315, 0.1745])?, 0.135e12)?;

    let around_the_sun = KeplerElements {
        semi_major_axis: 0.6423 * 1.495978707e8,
        eccentricity: 0.6884,
        inclination: 0.68,
        longitude_of_node: 4.27,
        argument_of_periapsis: 3.37,
        mean_anomaly: 1.0,
    };
    let sun = ThirdBody {
        name: "Sun".into(),
        mu: 132712440041.279419 * 3600.0 * 3600.0,
        mass: None,
        of: WhoseOrbit::System,
        path: Path::Orbit { elements: around_the_sun, time: 0.0 },
    };
    let tide = Tide {
        name: "tide on Alpha".into(),
        on: "Alpha".into(),
        by: "Beta".into(),
        k2: 1e-5,
        lag: 0.01,
        radius: 0.73,
    };
    let drag = Function::new("drag", true, |motion, force, _torque| {
        force[1] = -1e4 * (motion.velocity[1] - motion.velocity[0]);
        force[0] = -force[1];
        Ok(())
    });
    let forces = vec![Force::ThirdBody(sun), Force::Tide(tide), Force::Function(drag)];
    let system = System::new(vec![alpha, beta], G, Settings::default())?.with_forces(forces)?;

    let orbit = KeplerElements::new(2.548, 0.0, 0.0, 0.0, 0.0, 0.0)?;
    let mu = G * (2.353e12 + 0.135e12);
    let (position, velocity) = orbit.to_cartesian(mu)?;
    let state = State::new(
        0.0,
        vec![Vec3::zeros(), position],
        vec![Vec3::zeros(), velocity],
        vec![[1.0, 0.0, 0.0, 0.0]; 2],
        vec![Vec3::new(0.0, 0.0, 2.27), Vec3::new(0.0, 0.0, orbit.mean_motion(mu)?)],
    )?;
    let mut simulation =
        Simulation::new(&system, &state, Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?))?;
    let mut run = Trajectory::new(2);
    simulation.integrate(100.0, &Output::Spacing(10.0), &mut run)?;

    let last = run.len() - 1;
    // Seven numbers for each force: its work, its impulse and its angular impulse.
    for (force, numbers) in system.forces().iter().zip(simulation.work_and_impulse().chunks(7)) {
        println!("work of {}: {:.6e} kg km^2 / h^2", force.name(), numbers[0]);
    }
    let energy = run.energy(0).total;
    println!("energy, relative change: {:.3e}", (run.energy(last).total - energy) / energy);
    println!("without the work of the forces: {:.1e}", (run.conserved_energy(last) - energy) / energy);
    Ok(())
}
