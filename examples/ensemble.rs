//! Many simulations on all cores: `cargo run --release --example ensemble`. A hundred binaries whose satellites
//! start at other angles; prints by how far each satellite librates within twenty revolutions.

use fullbody::dynamics::{Settings, State, System};
use fullbody::ensemble::{JobProgress, JobSource, Member, MemberOutcome, run};
use fullbody::integrate::Tolerance;
use fullbody::math::Vec3;
use fullbody::shape::{Body, Shape};
use fullbody::trajectory::{Integrator, Output, TangentOptions};
use std::ops::ControlFlow;

/// Hands out the members and keeps the largest angle of libration of each, in degrees.
struct Angles {
    system: System,
    next: usize,
    largest: Vec<f64>,
}

impl JobSource for Angles {
    type Job = (usize, Member);
    type Answer = (usize, MemberOutcome);

    fn next(&mut self) -> Option<(usize, Member)> {
        let index = self.next;
        self.next += 1;
        let angle = 0.01 * index as f64;
        let period = 2.0 * std::f64::consts::PI * 64.0_f64.sqrt();
        let state = State::from_tait_bryan(
            0.0,
            vec![Vec3::zeros(), Vec3::new(4.0, 0.0, 0.0)],
            vec![Vec3::zeros(), Vec3::new(0.0, 0.5, 0.0)],
            &[[0.0; 3], [0.0, 0.0, angle]],
            vec![Vec3::zeros(), Vec3::new(0.0, 0.0, 0.125)],
        );
        let member = Member {
            system: self.system.clone(),
            state: state.expect("finite numbers"),
            integrator: Integrator::Verner98(Tolerance::new(1e-10, 1e-10).expect("in range")),
            until: 20.0 * period,
            output: Output::Spacing(0.05 * period),
            events: Vec::new(),
            dense: false,
            tangent_options: TangentOptions::default(),
        };
        (index < self.largest.len()).then_some((index, member))
    }

    fn take(&mut self, (index, outcome): (usize, MemberOutcome)) -> ControlFlow<()> {
        // None is a member that had not begun when the program was interrupted.
        let Some(Ok(member)) = outcome else { return ControlFlow::Break(()) };
        let angle = |state: State| {
            let line = state.position()[0] - state.position()[1];
            let long_axis = fullbody::math::rotation::matrix(state.attitude()[1]).column(0).into_owned();
            (line.normalize().dot(&long_axis).abs().min(1.0)).acos().to_degrees()
        };
        self.largest[index] = member.record.states().map(angle).fold(0.0, f64::max);
        ControlFlow::Continue(())
    }

    fn proceed(&mut self, _: JobProgress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let primary = Body::with_mass("Primary", Shape::ellipsoid([1.0, 0.95, 0.9])?, 1.0)?;
    let satellite = Body::with_mass("Satellite", Shape::ellipsoid([0.3, 0.25, 0.2])?, 0.01)?;
    let system = System::new(vec![primary, satellite], 1.0, Settings::default())?;
    let mut angles = Angles { system, next: 0, largest: vec![f64::NAN; 100] };
    run(&mut angles, None)?;
    println!("{:>8} {:>8}", "start", "largest");
    for (index, largest) in angles.largest.iter().enumerate().step_by(10) {
        println!("{:8.2} {largest:8.2}", (0.01 * index as f64).to_degrees());
    }
    Ok(())
}
