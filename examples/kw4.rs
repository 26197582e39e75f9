//! (66391) 1999 KW4 with plain numbers in km, hours and kg: `cargo run --release --example kw4 [HOURS]`.
//! Prints the orbit once a day and how well energy and angular momentum hold.

use fullbody::dynamics::{Settings, State, System};
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::orbit::KeplerElements;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, Simulation, Trajectory};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hours = std::env::args().nth(1).map_or(Ok(200.0), |text| text.parse())?;
    let alpha = Body::with_mass("Alpha", Shape::ellipsoid([0.766, 0.7475, 0.6735])?, 2.353e12)?;
    let beta = Body::with_mass("Beta", Shape::ellipsoid([0.285, 0.2315, 0.1745])?, 0.135e12)?;
    let system = System::new(vec![alpha, beta], 8.64960768e-13, Settings::default())?;
    let mu = 8.64960768e-13 * (2.353e12 + 0.135e12);

    // Beta's long axis points at Alpha, and it turns once an orbit; Alpha's pole is 3.2 degrees off the
    // orbit's.
    let orbit = KeplerElements::new(2.548, 0.0, 0.0, 0.0, 0.0, 0.0)?;
    let (position, velocity) = orbit.to_cartesian(mu)?;
    let state = State::from_tait_bryan(
        0.0,
        vec![Vec3::zeros(), position],
        vec![Vec3::zeros(), velocity],
        &[[3.2_f64.to_radians(), 0.0, 0.0], [0.0; 3]],
        vec![Vec3::new(0.0, 0.0, 2.27), Vec3::new(0.0, 0.0, orbit.mean_motion(mu)?)],
    )?;

    let mut simulation =
        Simulation::new(&system, &state, Integrator::Verner98(Tolerance::new(1e-13, 1e-13)?))?;
    let mut run = Trajectory::new(2);
    simulation.integrate(hours, &Output::Spacing(24.0), &mut run)?;

    println!("{:>8} {:>10} {:>10}", "hours", "a [km]", "e");
    for state in run.states() {
        let position = state.position()[1] - state.position()[0];
        let velocity = state.velocity()[1] - state.velocity()[0];
        let osculating = KeplerElements::from_cartesian(&position, &velocity, mu)?;
        println!("{:8.1} {:10.6} {:10.6}", state.time(), osculating.semi_major_axis, osculating.eccentricity);
    }
    let last = run.len() - 1;
    let (before, after) = (run.energy(0).total, run.energy(last).total);
    println!("energy, relative change: {:.1e}", (after - before) / before);
    let (before, after) = (run.angular_momentum(0), run.angular_momentum(last));
    println!("angular momentum, relative change: {:.1e}", (after - before).norm() / before.norm());
    Ok(())
}
