//! States between the steps.

use super::systems::*;
use fullbody::dynamics::AttitudeChart;
use fullbody::error::Error;
use fullbody::interrupt::InterruptCheck;
use fullbody::mutual::Method;
use fullbody::trajectory::{Output, Simulation};

/// Interpolated states against a run at a tolerance a hundred times tighter, in units of the tolerance, for
/// every pair; the energy of interpolated states.
#[test]
fn interpolated_states_are_within_the_tolerance() {
    let (system, state) = tumbling(Method::Multipole(6), AttitudeChart::Quaternion);
    let times: Vec<f64> = (0..=400).map(|k| 0.05 * f64::from(k)).collect();
    for tolerance in [1e-8, 1e-12] {
        let exact = Output::Times(times.clone());
        let tight = integrate(
            &mut Simulation::new(&system, &state, verner98(tolerance * 1e-2)).unwrap(),
            20.0,
            &exact,
            true,
        );
        let tight = tight.dense.unwrap();
        for integrator in all(tolerance, 0.01).into_iter().take(5) {
            let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
            let record = integrate(&mut simulation, 20.0, &exact, true);
            let dense = record.dense.unwrap();
            let steps = integrate(
                &mut Simulation::new(&system, &state, integrator).unwrap(),
                20.0,
                &Output::Steps,
                false,
            );
            let at = |time| {
                let (a, b) = (dense.state(time).unwrap(), tight.state(time).unwrap());
                difference(&a, &b).max(difference_of_rotation(&a, &b)) / tolerance
            };
            let ends = steps.time.iter().map(|&t| at(t)).fold(0.0, f64::max);
            let inside = times.iter().map(|&t| at(t)).fold(0.0, f64::max);
            let energy = record.energy.iter().step_by(4);
            let energy = energy.map(|e| (e / record.energy[0] - 1.0).abs()).fold(0.0, f64::max) / tolerance;
            println!(
                "{integrator:?}: errors in tolerances, steps' ends {ends:.1}, inside {inside:.1}, energy \
                 inside {energy:.2}"
            );
            assert!(inside < 2.0 * ends + 2.0 && energy < 20.0);
        }
    }
}

/// Asking for times does not change the steps, whatever the integrator.
#[test]
fn output_does_not_disturb() {
    let (system, state) = tumbling(Method::Focal, AttitudeChart::Quaternion);
    for integrator in all(1e-9, 0.05) {
        let mut plain = Simulation::new(&system, &state, integrator).unwrap();
        let steps = integrate(&mut plain, 3.0, &Output::Steps, false);
        let mut dense = Simulation::new(&system, &state, integrator).unwrap();
        let grid = integrate(&mut dense, 3.0, &Output::Spacing(0.01), true);
        assert_eq!(plain.state(), dense.state(), "{integrator:?}");
        assert_eq!(plain.statistics().steps, dense.statistics().steps);
        assert_eq!(grid.time.len(), 301);
        let solution = grid.dense.unwrap();
        assert!(solution.segments() >= steps.len() - 1);
        // The continuous solution holds the steps' ends: to round-off, and for fixed steps to what the
        // bridges leave.
        let mut replay = Simulation::new(&system, &state, integrator).unwrap();
        for &time in &steps.time[1..] {
            replay.step(3.0).unwrap();
            assert_eq!(replay.time(), time);
            let error = difference(&solution.state(time).unwrap(), &replay.state());
            assert!(error < 1e-14, "{integrator:?} at {time}: {error:e}");
        }
        // A grid is the continuous solution.
        let x = solution.state(grid.time[147]).unwrap().position()[1];
        assert_eq!(x.as_slice(), &grid.position[6 * 147 + 3..6 * 147 + 6]);
    }
}

#[test]
fn dense_output_covers_the_run_and_no_more() {
    let (system, state) = points(0.1);
    let mut simulation = Simulation::new(&system, &state, verner98(1e-10)).unwrap();
    let dense = integrate(&mut simulation, -2.0, &Output::Steps, true).dense.unwrap();
    assert_eq!(dense.range(), (0.0, -2.0));
    let mut back = dense.states(&[-2.0, -0.5, 0.0], &mut InterruptCheck::never()).unwrap();
    assert_eq!(back.pop().unwrap().position(), state.position());
    assert_eq!(back.len(), 2);
    println!("{} bytes a segment", dense.bytes() / dense.segments());
    for time in [0.1, -2.1, f64::NAN] {
        assert!(matches!(dense.state(time), Err(Error::InvalidInput { .. })));
    }
}

/// The bridge's error between fixed steps is the integrator's own.
#[test]
fn states_between_fixed_steps_are_as_accurate_as_the_steps() {
    let (system, state) = tumbling(Method::Multipole(6), AttitudeChart::Quaternion);
    let tight = integrate(
        &mut Simulation::new(&system, &state, verner98(1e-14)).unwrap(),
        10.0,
        &Output::Steps,
        true,
    );
    let tight = tight.dense.unwrap();
    for integrator in all(1e-9, 0.1).into_iter().skip(5) {
        let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
        let record = integrate(&mut simulation, 10.0, &Output::Spacing(0.1), true);
        let dense = record.dense.unwrap();
        let error = |times: &mut dyn Iterator<Item = f64>| {
            times.map(|t| difference(&dense.state(t).unwrap(), &tight.state(t).unwrap())).fold(0.0, f64::max)
        };
        let ends = error(&mut (0..=100).map(|k| 0.1 * f64::from(k)));
        let inside = error(&mut (0..100).map(|k| 0.1 * f64::from(k) + 0.037));
        println!("{integrator:?}: ends {ends:.1e} inside {inside:.1e}");
        assert!(inside < 1.2 * ends);
    }
}
