//! The bounds of a step's path, against the coefficients and the polynomials themselves.

use super::problems::Kepler;
use super::systems::*;
use fullbody::integrate::{
    DORMAND_PRINCE54, Stepper, Tableau, Tolerance, VERNER65, VERNER76, VERNER87, VERNER98,
};
use fullbody::interrupt::InterruptCheck;
use fullbody::trajectory::{Output, Simulation};
use std::sync::LazyLock;

static PAIRS: [&LazyLock<Tableau>; 5] = [&DORMAND_PRINCE54, &VERNER65, &VERNER76, &VERNER87, &VERNER98];

/// The interpolant and its stages bend from the chord as far as the tableau's sums say.
#[test]
fn interpolants_stay_within_the_spread_of_the_tableau() {
    for pair in PAIRS {
        let stages = pair.a.len();
        let a = |i: usize, j: usize| pair.a[i].get(j).copied().unwrap_or(0.0);
        let b = |i: usize| pair.b.get(i).copied().unwrap_or(0.0);
        // The weights of accelerations in places: b_i(theta) a_ij summed over i.
        let through =
            |weights: &dyn Fn(usize) -> f64, j: usize| (0..stages).map(|i| weights(i) * a(i, j)).sum::<f64>();
        let at_end: Vec<f64> = (0..stages).map(|j| through(&b, j)).collect();
        let mut largest = [0.0_f64; 2];
        let mut bend = |fraction: f64, weights: &dyn Fn(usize) -> f64| {
            let mut sums = [0.0; 2];
            let mut total = 0.0;
            for j in 0..stages {
                let difference = through(weights, j) - fraction * at_end[j];
                sums[usize::from(j >= pair.stages)] += difference.abs();
                total += difference;
            }
            // A uniform acceleration bends it by (theta - theta^2) / 2, an eighth at most.
            assert!((total + 0.5 * fraction * (1.0 - fraction)).abs() < 1e-10, "{} {total}", pair.name);
            (0..2).for_each(|k| largest[k] = largest[k].max(sums[k]));
        };
        for k in 0..=1000 {
            let theta = f64::from(k) / 1000.0;
            let weight = |i: usize| {
                let row = pair.interpolant.weights.get(i).map_or(&[][..], Vec::as_slice);
                // T_k(x) = cos(k acos x).
                let angle = (2.0 * theta - 1.0).clamp(-1.0, 1.0).acos();
                theta * row.iter().enumerate().map(|(k, w)| w * (k as f64 * angle).cos()).sum::<f64>()
            };
            bend(theta, &weight);
        }
        for stage in pair.stages..stages {
            bend(pair.c[stage], &|i| a(stage, i));
        }
        println!("{}: {largest:?} within {:?}", pair.name, pair.spread);
        for k in 0..2 {
            assert!(largest[k] <= pair.spread[k] && pair.spread[k] <= 1.05 * largest[k], "{}", pair.name);
        }
    }
}

/// Derivatives of a step's polynomial, by differences, stay within their bounds; single numbers are those of
/// the vector.
#[test]
fn derivatives_of_segments_stay_within_their_bounds() {
    for pair in PAIRS {
        let tolerance = Tolerance::new(1e-4, 1e-4).unwrap();
        let mut stepper = Stepper::new(pair, tolerance, 0.3, Kepler::exact(0.6, 0.3).to_vec(), vec![0.0; 4]);
        for _ in 0..5 {
            stepper.step(&mut Kepler, 9.0, &mut InterruptCheck::never()).unwrap();
            let segment = stepper.segment(&mut Kepler, &mut InterruptCheck::never()).unwrap();
            let bounds = segment.derivative_bounds(0, 2);
            let at = |theta: f64| {
                let mut y = [0.0; 4];
                segment.at(theta, &mut y);
                let basis = segment.basis(theta);
                (0..4).for_each(|k| assert_eq!(segment.number(&basis, k), y[k]));
                nalgebra::Vector2::new(y[0], y[1])
            };
            let h = 1e-3;
            for k in 2..=998 {
                let theta = f64::from(k) / 1000.0;
                let [l, a, m, b, r] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|x| at(theta + x * h));
                let derivatives = [
                    (b - a) / (2.0 * h),
                    (a - 2.0 * m + b) / (h * h),
                    (r - 2.0 * b + 2.0 * a - l) / (2.0 * h * h * h),
                ];
                for (derivative, bound) in derivatives.iter().zip(bounds) {
                    assert!(
                        derivative.norm() <= bound * (1.0 + 1e-9) + 1e-5,
                        "{}: {derivative:?} {bound}",
                        pair.name
                    );
                }
            }
        }
    }
}

/// Looking for contacts does not change a run of bodies that stay apart: not its steps, and of near ones not
/// its results.
#[test]
fn close_bodies_step_as_ever() {
    // Within each other's circumscribed spheres, turning with their orbit: every step is looked into.
    use fullbody::dynamics::{Settings, State, System};
    use fullbody::math::Vec3;
    use fullbody::shape::{Body, Shape};
    let body = |name| Body::with_mass(name, Shape::ellipsoid([0.5, 1.0, 0.5]).unwrap(), 0.5).unwrap();
    let system = System::new(vec![body("A"), body("B")], 1.0, Settings::default()).unwrap();
    let distance = 1.05;
    let (r, v) = (Vec3::new(distance, 0.0, 0.0), Vec3::new(0.0, 1.05, 0.0));
    let spin = vec![Vec3::new(0.0, 0.0, v.y / distance); 2];
    let state: State = relative(r, v, 0.5).with_spin(spin).unwrap();
    for integrator in all(1e-9, 0.01) {
        let run = |output: &Output| {
            let mut simulation = Simulation::new(&system, &state, integrator).unwrap();
            integrate(&mut simulation, 0.8, output, false);
            simulation.state()
        };
        assert_eq!(run(&Output::Times(vec![])), run(&Output::Spacing(0.03)), "{integrator:?}");
    }
}
