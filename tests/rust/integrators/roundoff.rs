//! Brouwer's law: at the tightest settings the energy's error grows as the square root of the number of
//! steps, by what rounding leaves in each.

use super::problems::Kepler;
use fullbody::integrate::{Stepper, Tableau, Tolerance, VERNER96, VERNER98};
use fullbody::interrupt::InterruptCheck;
use fullbody::math::compensated::{Compensated, two_product};

/// The sum of a number and products of numbers with low parts, in twice the working precision.
fn add_square(total: &mut Compensated, high: f64, low: f64, factor: f64) {
    let (product, error) = two_product(high, high);
    total.add(factor * product);
    total.add(factor * (error + 2.0 * high * low));
}

/// v^2 / 2 - 1 / r of a vector and its low part, in twice the working precision.
fn energy(high: &[f64], low: &[f64]) -> Compensated {
    let (mut square, mut total) = (Compensated::default(), Compensated::default());
    for c in 0..2 {
        add_square(&mut square, high[c], low[c], 1.0);
        add_square(&mut total, high[c + 2], low[c + 2], 0.5);
    }
    // 1/r by one Newton step on the exact residual 1 - r^2 x^2.
    let x = 1.0 / square.high.sqrt();
    let (p, p_low) = two_product(x, x);
    let (q, q_low) = two_product(p, square.high);
    let residual = ((1.0 - q) - q_low) - p_low * square.high - p * square.low;
    total.add(-x);
    total.add(-0.5 * x * residual);
    total
}

const MEMBERS: usize = 32;
const TIMES: usize = 9;

/// Energy errors of every member at doubling times up to `end`; the steps of the last member, and what
/// rounding leaves of its energy: in each step the increment of the velocity, h / r^2, is off by 2^-53 /
/// sqrt(3) of its size, and the energy by that times the velocity.
fn ensemble(
    tableau: &'static Tableau,
    tolerance: Tolerance,
    eccentricity: f64,
    end: f64,
) -> (Vec<[f64; TIMES]>, u64, f64) {
    let mut steps = 0;
    let mut squares = 0.0;
    let members = (0..MEMBERS).map(|k| {
        let e = eccentricity + 1e-3 * (0.754_877_666 * k as f64).fract();
        let mut stepper = Stepper::new(tableau, tolerance, 0.0, Kepler::exact(e, 0.1).to_vec(), vec![0.0; 4]);
        let start = {
            let (high, low) = stepper.vector();
            energy(high, low)
        };
        squares = 0.0;
        let errors = std::array::from_fn(|n| {
            let time = end * 0.5_f64.powi((TIMES - 1 - n) as i32);
            while stepper.time() != time {
                let before = stepper.time();
                stepper.step(&mut Kepler, time, &mut InterruptCheck::never()).unwrap();
                let [x, y, u, v] = stepper.vector().0.try_into().unwrap();
                squares += ((stepper.time() - before) * u.hypot(v) / (x * x + y * y)).powi(2);
            }
            let (high, low) = stepper.vector();
            let now = energy(high, low);
            ((now.high - start.high) + (now.low - start.low)) / start.high
        });
        steps = stepper.statistics().steps;
        errors
    });
    (members.collect(), steps, 0.5 * f64::EPSILON / 3.0_f64.sqrt() * 2.0 * squares.sqrt())
}

/// Slope of log rms against log time.
fn slope(members: &[[f64; TIMES]], without: Option<usize>) -> f64 {
    let rms = |n: usize| {
        let squares = members.iter().enumerate().filter(|(k, _)| Some(*k) != without);
        squares.map(|(_, errors)| errors[n] * errors[n]).sum::<f64>().sqrt().ln()
    };
    let middle = 0.5 * (TIMES - 1) as f64;
    let x = |n: usize| (n as f64 - middle) * 2.0_f64.ln();
    let norm: f64 = (0..TIMES).map(|n| x(n) * x(n)).sum();
    (0..TIMES).map(|n| x(n) * rms(n)).sum::<f64>() / norm
}

fn check(tableau: &'static Tableau, tolerance: Tolerance, eccentricity: f64) {
    let (members, steps, expected) = ensemble(tableau, tolerance, eccentricity, 1000.0);
    let measured = slope(&members, None);
    // Jackknife.
    let spread: f64 = (0..MEMBERS).map(|k| (slope(&members, Some(k)) - measured).powi(2)).sum();
    let uncertainty = (spread * (MEMBERS - 1) as f64 / MEMBERS as f64).sqrt();
    let last = members.iter().map(|m| m[TIMES - 1]);
    let rms = (last.clone().map(|e| e * e).sum::<f64>() / MEMBERS as f64).sqrt();
    let mean = last.sum::<f64>() / MEMBERS as f64;
    println!(
        "{}: exponent {measured:.2} +- {uncertainty:.2}; after {steps} steps rms {rms:.1e} for \
         {expected:.1e}, mean {mean:.1e}",
        tableau.name
    );
    assert!((measured - 0.5).abs() < 0.2, "{measured}");
    // A drift would show in the mean: it is what chance makes of so many members.
    assert!(mean.abs() < 4.0 * rms / (MEMBERS as f64).sqrt());
    assert!((0.3..3.0).contains(&(rms / expected)));
}

#[test]
fn round_off_follows_brouwers_law() {
    let tolerance = Tolerance::new(1e-17, 0.0).unwrap();
    assert_eq!(tolerance.relative(), Tolerance::FLOOR);
    check(&VERNER98, tolerance, 0.1);
}

#[test]
fn brouwers_law_to_roundoff() {
    check(&VERNER96, Tolerance::TO_ROUNDOFF, 0.1);
}

#[test]
fn brouwers_law_of_an_eccentric_orbit() {
    check(&VERNER96, Tolerance::TO_ROUNDOFF, 0.5);
}
