//! Measured orders of the pairs: of both weights and of the interpolant, on Kepler's problem.

use super::problems::{Kepler, distance};
use fullbody::integrate::{
    DORMAND_PRINCE54, Equations, Stepper, Tableau, Tolerance, VERNER65, VERNER76, VERNER87, VERNER96,
    VERNER98,
};
use fullbody::interrupt::InterruptCheck;
use std::sync::LazyLock;

static PAIRS: [&LazyLock<Tableau>; 6] =
    [&DORMAND_PRINCE54, &VERNER65, &VERNER76, &VERNER87, &VERNER96, &VERNER98];
const E: f64 = 0.3;

/// One step of size `h` from Kepler's state at `time`, with given weights.
fn step(tableau: &Tableau, weights: &[f64], time: f64, h: f64) -> Vec<f64> {
    let start = Kepler::exact(E, time);
    let mut rates: Vec<[f64; 4]> = Vec::new();
    for stage in 0..tableau.stages {
        let mut y = start;
        for (a, k) in tableau.a[stage].iter().zip(&rates) {
            (0..4).for_each(|c| y[c] += h * a * k[c]);
        }
        let mut rate = [0.0; 4];
        Kepler.derivative(0, 0.0, &y, &mut rate).unwrap();
        rates.push(rate);
    }
    (0..4).map(|c| start[c] + h * weights.iter().zip(&rates).map(|(b, k)| b * k[c]).sum::<f64>()).collect()
}

/// Exponent of the local error: slope between two step sizes, mean over starts around the orbit.
fn exponent(error: impl Fn(f64, f64) -> f64, h: f64) -> f64 {
    let total = |h: f64| (0..12).map(|k| error(0.5 * f64::from(k), h).ln()).sum::<f64>() / 12.0;
    (total(h) - total(h / 1.4)) / 1.4_f64.ln()
}

/// Verner's leading terms are so small that the next ones still show at steps above round-off.
#[track_caller]
fn check(pair: &Tableau, order: u32, measured: f64) {
    let excess = measured - f64::from(order);
    assert!((-0.3..1.1).contains(&excess), "{}: {measured} for {order}", pair.name);
}

#[test]
fn both_weights_have_their_orders() {
    for pair in PAIRS {
        for (weights, order) in [(&pair.b, pair.order), (&pair.b_hat, pair.error_order)] {
            let error = |t: f64, h: f64| distance(&step(pair, weights, t, h), &Kepler::exact(E, t + h));
            // The longest steps that are still in the asymptotic range, far above round-off.
            let h = [0.0, 0.0, 0.0, 0.0, 0.06, 0.08, 0.12, 0.18, 0.25, 0.35][order as usize];
            let measured = exponent(error, h) - 1.0;
            println!("{} weights of order {order}: {measured:.2}", pair.name);
            check(pair, order, measured);
        }
    }
}

#[test]
fn interpolants_have_their_orders() {
    for pair in PAIRS {
        let error = |t: f64, h: f64| {
            let tolerance = Tolerance::new(0.99, 0.0).unwrap();
            let mut stepper = Stepper::new(pair, tolerance, t, Kepler::exact(E, t).to_vec(), vec![0.0; 4]);
            stepper.step(&mut Kepler, t + h, &mut InterruptCheck::never()).unwrap();
            assert_eq!(stepper.time(), t + h);
            let mut y = [0.0; 4];
            let at = |k: u32| t + h * f64::from(k) / 16.0;
            (1..16).fold(0.0, |worst: f64, k| {
                stepper.interpolate(&mut Kepler, at(k), &mut y, &mut InterruptCheck::never()).unwrap();
                worst.max(distance(&y, &Kepler::exact(E, at(k))))
            })
        };
        let order = pair.interpolant.order;
        let h = [0.0, 0.0, 0.0, 0.0, 0.06, 0.08, 0.12, 0.18, 0.25, 0.35][order as usize];
        let measured = exponent(error, h) - 1.0;
        let end = |h: f64| {
            (0..12).map(|k| 0.5 * f64::from(k)).fold(0.0, |worst: f64, t| {
                worst.max(distance(&step(pair, &pair.b, t, h), &Kepler::exact(E, t + h)))
            })
        };
        let inside = (0..12).map(|k| error(0.5 * f64::from(k), h)).fold(0.0, f64::max);
        println!(
            "{} interpolant of order {order}: {measured:.2}, error {:.1} times the step's",
            pair.name,
            inside / end(h)
        );
        check(pair, order, measured);
    }
}
