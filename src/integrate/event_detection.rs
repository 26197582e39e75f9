//! Event detection: the zeros of a function along a step.
//!
//! The function is sampled at fractions of the step. A change of sign between two samples is a zero. Between
//! three samples of which the middle one is nearest to zero the extremum is searched for, so that two zeros
//! in one interval are not lost; only a function with more extrema in an interval can hide some.

use super::{extremum, root};

/// The number of equal intervals of a step at whose ends functions are sampled.
const SAMPLES: usize = 8;

/// The number of samples: the ends of the intervals, and two fractions near the ends of the step, which show
/// the sign of the function's change there.
pub const POINTS: usize = SAMPLES + 3;

/// The distance of the two additional samples from the ends of the step, as a fraction of the step.
const NEAR: f64 = 1e-3;

/// Returns the fractions of a step at which functions are sampled, from its start up to the fraction `end`.
pub fn sample_fractions(end: f64) -> [f64; POINTS] {
    std::array::from_fn(|k| match k {
        0 => 0.0,
        1 => NEAR * end,
        k if k == POINTS - 2 => (1.0 - NEAR) * end,
        k if k == POINTS - 1 => end,
        k => (k - 1) as f64 / SAMPLES as f64 * end,
    })
}

/// Returns whether a zero counts for an event of this direction: 1 where the function rises, -1 where it
/// falls, 0 always.
pub fn counts(direction: i8, rises: bool) -> bool {
    direction == 0 || (direction > 0) == rises
}

/// Finds the zeros of a function of the fraction of a step, given its values at these fractions.
///
/// Each zero is passed to `found` with its fraction and whether the function rises there along the step.
/// Zeros that `wanted` rejects by their direction are not computed. A zero at the first sample belongs to the
/// step before.
/// before.
pub fn zeros<E>(
    fractions: &[f64; POINTS],
    values: &[f64; POINTS],
    mut f: impl FnMut(f64) -> Result<f64, E>,
    wanted: impl Fn(bool) -> bool,
    mut found: impl FnMut(f64, bool),
) -> Result<(), E> {
    let mut refine = |a: (f64, f64), b: (f64, f64), f: &mut dyn FnMut(f64) -> Result<f64, E>| {
        let rises = b.1 > a.1;
        if wanted(rises) {
            found(root(f, a, b)?, rises);
        }
        Ok(())
    };
    for k in 1..POINTS {
        let (a, b) = ((fractions[k - 1], values[k - 1]), (fractions[k], values[k]));
        if a.1 * b.1 < 0.0 || (b.1 == 0.0 && a.1 != 0.0) {
            refine(a, b, &mut f)?;
        }
        if k + 1 == POINTS {
            break;
        }
        let c = (fractions[k + 1], values[k + 1]);
        let sign = b.1.signum();
        let same = a.1 * sign > 0.0 && c.1 * sign > 0.0;
        if same && b.1.abs() < a.1.abs() && b.1.abs() <= c.1.abs() {
            let (theta, value) = extremum(|theta| f(theta).map(|v| v * sign), a.0, c.0)?;
            if value < 0.0 {
                let middle = (theta, value * sign);
                refine(a, middle, &mut f)?;
                refine(middle, c, &mut f)?;
            }
        }
    }
    Ok(())
}
