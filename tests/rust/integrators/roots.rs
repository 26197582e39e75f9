//! Roots and minima of functions whose own are known, and in as few evaluations as scipy's `brentq` and
//! `fminbound`, which are the same algorithms, take for the same tolerances.

use fullbody::integrate::{minimum, root, sample_fractions, zeros};
use std::convert::Infallible;

/// A function with its interval, its root or minimum, and scipy's number of evaluations.
type Problem = (fn(f64) -> f64, [f64; 2], f64, usize);

#[test]
fn roots_are_found_to_rounding() {
    let problems: [Problem; 14] = [
        (|x| x * x * x - 2.0, [0.0, 2.0], 1.259_921_049_894_873_2, 9),
        (|x| x.cos() - x, [0.0, 1.0], 0.739_085_133_215_160_6, 8),
        (|x| x.cos() - x, [1.0, 0.0], 0.739_085_133_215_160_6, 8),
        (|x| x.exp() - 5.0, [-3.0, 4.0], 1.609_437_912_434_100_4, 13),
        (|x| (1e3 * (x - 0.3)).atan(), [-1.0, 1.0], 0.3, 16),
        (|x| (x - 0.1).powi(9), [-1.0, 1.3], 0.1, 150),
        (|x| (x - 0.1).powi(3), [-1.0, 1.3], 0.1, 162),
        (|x| if x < 1.0 / 3.0 { -1.0 } else { 1.0 }, [0.0, 1.0], 1.0 / 3.0, 54),
        (|x| 1.0 / (x - 4.0) + 1.0, [0.0, 3.9], 3.0, 5),
        (|x| 3.0 * x - 1.0, [-7.0, 5.0], 1.0 / 3.0, 4),
        (|x| 1e-200 * (x * x - 2e-8), [0.0, 1.0], 1.414_213_562_373_095_1e-4, 45),
        (|x| x * (-x * x).exp() + 0.1 * x - 0.3, [-5.0, 5.0], 2.996_217_551_956_826_7, 7),
        (|x| ((x - 1.0) * x - 1.0) * x - 1e-3, [0.5, 2.0], 1.618_310_300_616_527_8, 12),
        (|x| x.ln() + 20.0, [1e-12, 1.0], 2.061_153_622_438_558e-9, 31),
    ];
    for (k, (f, [a, b], expected, by_scipy)) in problems.into_iter().enumerate() {
        // The ends' values are given, and two evaluations of scipy's are theirs.
        let mut count = 2;
        let counted = |x| {
            count += 1;
            Ok::<_, Infallible>(f(x))
        };
        let Ok(found) = root(counted, (a, f(a)), (b, f(b)));
        // The logarithm is known no better than to 16 epsilon of its argument.
        assert!(
            (found - expected).abs() <= 16.0 * f64::EPSILON * expected,
            "{k}: {found:e} for {expected:e}"
        );
        assert!(count <= by_scipy + by_scipy / 20, "{k}: {count} evaluations, scipy {by_scipy}");
    }
}

#[test]
fn minima_are_found() {
    // Half the digits of the place are all of a value that is flat there; elsewhere a place good to 2e-9
    // makes the last column.
    let problems: [(Problem, f64); 10] = [
        ((|x| (x - 0.3).powi(2) + 1.0, [-1.0, 2.0], 0.3, 25), 4e-16),
        ((|x| (x - 0.3).powi(4) + 1.0, [-1.0, 2.0], 0.3, 24), 4e-16),
        ((|x| (x - 1.2).cosh(), [-3.0, 4.0], 1.2, 10), 4e-16),
        ((|x| x + 5.0, [0.0, 1.0], 0.0, 56), 4e-12),
        ((|x| 5.0 - x, [0.0, 1.0], 1.0, 37), 4e-9),
        ((|x| 2.0 - (x - 0.1).cos(), [-2.0, 2.0], 0.1, 20), 4e-16),
        ((|x| 1.0 + (x - 0.4).abs(), [0.0, 1.0], 0.4, 24), 2e-9),
        ((|x| 9.0 + x - 2.0 * x.ln(), [1e-3, 9.0], 2.0, 14), 4e-15),
        ((|x| 1.0 + (x - 0.7).abs().sqrt(), [0.0, 1.0], 0.7, 28), 5e-5),
        ((|x| x.exp() - 2.0 * x, [-4.0, 9.0], std::f64::consts::LN_2, 13), 4e-16),
    ];
    for (k, ((f, [a, b], expected, by_scipy), allowed)) in problems.into_iter().enumerate() {
        let mut count = 0;
        let counted = |x| {
            count += 1;
            Ok::<_, Infallible>(f(x))
        };
        let Ok((place, value)) = minimum(counted, a, b);
        assert_eq!(value, f(place));
        assert!(value - f(expected) <= allowed, "{k}: {place}");
        // Its tolerance of the place is coarser, by some golden sections.
        assert!(count <= by_scipy + 8, "{k}: {count} evaluations, scipy {by_scipy}");
    }
    // It stops as soon as the value is below zero.
    let mut count = 0;
    let Ok((_, value)) = minimum(
        |x| {
            count += 1;
            Ok::<_, Infallible>((x - 0.3).powi(2) - 0.5)
        },
        -1.0,
        2.0,
    );
    assert!(value < 0.0 && count == 1);
}

/// An error of the function is passed on.
#[test]
fn errors_of_the_function_are_returned() {
    assert_eq!(root(|_| Err("no"), (0.0, -1.0), (1.0, 1.0)), Err("no"));
    assert_eq!(minimum(|_| Err("no"), 0.0, 1.0), Err("no"));
}

/// The zeros of a function of the fraction of a step, of the samples that event detection takes.
fn zeros_of(f: impl Fn(f64) -> f64, end: f64) -> Vec<(f64, bool)> {
    let fractions = sample_fractions(end);
    let (values, mut found) = (fractions.map(&f), Vec::new());
    let value = |theta| Ok::<_, Infallible>(f(theta));
    let Ok(()) = zeros(&fractions, &values, None, value, |_| true, |theta, rises| found.push((theta, rises)));
    found
}

#[test]
fn zeros_on_both_sides_of_an_extremum_between_samples() {
    for end in [1.0, 0.37] {
        for place in [0.013, 0.2, 0.49, 0.5, 0.94, 0.999] {
            for sign in [1.0, -1.0] {
                let (middle, width) = (place * end, 1e-4 * end);
                let found = zeros_of(|theta| sign * ((theta - middle).powi(2) - width * width), end);
                let expected = [(middle - width, sign < 0.0), (middle + width, sign > 0.0)];
                assert_eq!(found.len(), 2, "{middle}");
                for ((theta, rises), (at, expected)) in found.into_iter().zip(expected) {
                    assert!((theta - at).abs() < 1e-10 && rises == expected, "{theta} for {at}");
                }
            }
        }
    }
}

#[test]
fn a_zero_at_the_start_belongs_to_the_step_before() {
    assert_eq!(zeros_of(|theta| theta, 1.0), []);
    assert_eq!(zeros_of(|theta| theta - 1.0, 1.0), [(1.0, true)]);
    assert_eq!(zeros_of(|theta| 2.0 + (9.0 * theta).cos(), 1.0), []);
}
