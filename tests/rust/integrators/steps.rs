//! Steps: where they end, what they allocate.

use super::systems::*;
use crate::support::allocations;
use fullbody::dynamics::AttitudeChart;
use fullbody::error::Error;
use fullbody::integrate::Scheme;
use fullbody::interrupt::InterruptCheck;
use fullbody::math::Vec3;
use fullbody::mutual::Method;
use fullbody::trajectory::{Integrator, Output, Run, Simulation, StopReason, Trajectory};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Two points fall onto each other: the steps shrink until they no longer advance the time, at pi sqrt(d^3 /
/// (8 mu)).
#[test]
fn steps_end_at_a_singularity() {
    let (system, _) = points(0.0);
    let d: f64 = 1.7;
    let state = relative(Vec3::new(0.0, d, 0.0), Vec3::zeros(), 0.3);
    let collision = PI * (d.powi(3) / 8.0).sqrt();
    for integrator in all(1e-12, 0.1).into_iter().take(5) {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let mut record = Trajectory::new(2);
        let error = simulation.integrate(10.0, &Output::Steps, &mut record).unwrap_err();
        let Error::StepSizeTooSmall { time, step, .. } = &error else { panic!("{error}") };
        println!("{error}; off by {:.1e}", time - collision);
        assert!((time - collision).abs() < 1e-10 && step.abs() < 1e-14);
        assert_eq!(record.stop_reason, StopReason::Unfinished);
        assert_eq!(simulation.time(), *record.time.last().unwrap());
    }
}

/// An end as near as rounding brings it is reached, either way.
#[test]
fn ends_a_rounding_away() {
    let (system, state) = points(0.3);
    for integrator in all(1e-12, 0.1) {
        for time in [0.3, 1.0, 100.0] {
            for ulps in [-4_i64, -1, 1, 2, 4] {
                let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
                simulation.integrate(time, &Output::Steps, &mut Trajectory::new(2)).unwrap();
                let end = f64::from_bits(time.to_bits().wrapping_add_signed(ulps));
                simulation.integrate(end, &Output::Steps, &mut Trajectory::new(2)).unwrap();
                assert_eq!(simulation.time(), end);
                // It goes on from there as if nothing had been.
                simulation.integrate(time + 1.0, &Output::Steps, &mut Trajectory::new(2)).unwrap();
                assert_eq!(simulation.time(), time + 1.0);
            }
        }
    }
}

/// Accepted steps allocate nothing once the rules are there.
#[test]
fn steps_allocate_nothing() {
    let multipole = tumbling(Method::Multipole(6), AttitudeChart::Quaternion);
    let angles = tumbling(Method::Multipole(2), AttitudeChart::TaitBryan);
    let (focal, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    let mut settings = *focal.settings();
    settings.order = Some(fullbody::quadrature::Order { gauss: 12, angles: 24 });
    let fixed = |system: &fullbody::dynamics::System| {
        fullbody::dynamics::System::new(system.bodies().to_vec(), 1.0, settings).unwrap()
    };
    let (binary, start) = contact_binary();
    for (system, state) in [multipole, angles, (fixed(&focal), state), (fixed(&binary), start), triple()] {
        for integrator in all(1e-10, 0.02) {
            let Ok(mut simulation) = Simulation::new(&system, &state, integrator) else { continue };
            (0..5).for_each(|_| simulation.step(100.0).unwrap());
            let before = allocations();
            (0..20).for_each(|_| simulation.step(100.0).unwrap());
            assert_eq!(allocations() - before, 0, "{integrator:?}");
        }
    }
}

/// Fixed steps end where they are asked to, and count what they evaluate.
#[test]
fn fixed_steps_have_their_size() {
    let (system, state) = tumbling(Method::Multipole(2), AttitudeChart::Quaternion);
    let cases = [
        (Integrator::LieGroupVariational { step: 0.1 }, 1, 1),
        (Integrator::SymplecticSplitting { step: 0.1, scheme: Scheme::Leapfrog }, 1, 0),
        (Integrator::SymplecticSplitting { step: 0.1, scheme: Scheme::Aba864 }, 7, 0),
        (Integrator::SymplecticSplitting { step: 0.1, scheme: Scheme::Aba1064 }, 8, 0),
    ];
    for (integrator, each, first) in cases {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let record = integrate(&mut simulation, 10.0, &Output::Steps, false);
        assert_eq!(record.len(), 101);
        assert_eq!(simulation.time(), 10.0);
        assert_eq!(simulation.statistics().evaluations, 100 * each + first);
        // A last step that is cut short.
        let record = integrate(&mut simulation, 10.25, &Output::Steps, false);
        assert_eq!(record.len(), 4);
        assert_eq!(simulation.time(), 10.25);
    }
}

/// A run of more steps than a double counts is refused before its first one, with their number; one of fewer
/// is not.
#[test]
fn more_steps_than_can_be_counted() {
    let (system, state) = tumbling(Method::Point, AttitudeChart::Quaternion);
    let state = state.with_time(1e9).unwrap();
    let run = |step: f64, until: f64| {
        let integrator = Integrator::LieGroupVariational { step };
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let mut record = Trajectory::new(2);
        let (none, stop) = (Output::Times(vec![]), &mut |_: Option<&_>, _| ControlFlow::Break(()));
        let outcome = simulation.run(until, Run::new(&none), &mut record, stop);
        assert_eq!(simulation.state(), state);
        outcome.unwrap_err()
    };
    for until in [2e9, 0.0] {
        let error = run(1e-7, until);
        assert!(matches!(error, Error::InvalidInput { .. }), "{error}");
        for part in ["step is 1e-7", "takes 1.0e16 of them"] {
            assert!(error.to_string().contains(part), "{error}");
        }
        assert!(matches!(run(1e-6, until), Error::Interrupted { .. }));
    }
}

/// A simulation that is set to a state is one that began there, with its notes kept; a state that it cannot
/// have changes nothing.
#[test]
fn set_to_a_state() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    for integrator in [verner98(1e-10), Integrator::LieGroupVariational { step: 0.1 }] {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        simulation.notes = "kept".to_owned();
        integrate(&mut simulation, 1.0, &Output::Steps, false);
        let other = replaced(state.clone(), |[_, velocity, _]| velocity[1] *= 1.1).with_time(3.5).unwrap();
        simulation.set_state(&other, &mut InterruptCheck::never()).unwrap();
        let mut fresh = Simulation::new(&system, &other, integrator).unwrap();
        assert_eq!(simulation.notes, "kept");
        assert_eq!((simulation.state(), simulation.time()), (other.clone(), 3.5));
        assert_eq!(simulation.statistics(), fresh.statistics());
        assert_eq!(simulation.start(), fresh.start());
        let [a, b] = [&mut simulation, &mut fresh].map(|s| integrate(s, 5.0, &Output::Steps, false));
        assert_eq!(a, b);
        let present = simulation.state();
        let other = replaced(other, |[position, ..]| position[1] = position[0]);
        let refused = simulation.set_state(&other, &mut InterruptCheck::never());
        assert!(matches!(refused, Err(Error::BodiesOverlap { time: 3.5, .. })));
        assert_eq!((simulation.state(), simulation.notes.as_str()), (present, "kept"));
    }
}
