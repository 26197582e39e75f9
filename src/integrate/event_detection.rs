//! Event detection: the zeros of a function along a step.
//!
//! The function is sampled at fractions of the step. A change of sign between two samples is a zero. Between
//! three samples of which the middle one is nearest to zero the extremum is searched for, so that two zeros
//! in one interval are not lost; only a function with more extrema in an interval can hide some.

use super::{minimum, root};

/// The number of equal intervals of a step at whose ends functions are sampled.
const INTERVALS: usize = 8;

/// The number of samples: the ends of the intervals, and two fractions near the ends of the step, which show
/// the sign of the function's change there.
pub const SAMPLES: usize = INTERVALS + 3;

/// The distance of the two additional samples from the ends of the step, as a fraction of the step.
const NEAR: f64 = 1e-3;

/// Returns the fractions of a step at which functions are sampled, from its start up to the fraction `end`.
pub fn sample_fractions(end: f64) -> [f64; SAMPLES] {
    std::array::from_fn(|k| match k {
        0 => 0.0,
        1 => NEAR * end,
        k if k == SAMPLES - 2 => (1.0 - NEAR) * end,
        k if k == SAMPLES - 1 => end,
        k => (k - 1) as f64 / INTERVALS as f64 * end,
    })
}

/// Returns whether a zero matches the direction of an event: 1 where the function rises, -1 where it falls, 0
/// for both.
pub fn direction_matches(direction: i8, rises: bool) -> bool {
    direction == 0 || (direction > 0) == rises
}

/// The largest number of halvings of an interval between two samples.
const HALVINGS: u32 = 4;

/// Finds the zeros of a function of the fraction of a step, given its values at these fractions.
///
/// With a bound of the derivative, `slope_bound`, intervals that may contain zeros are halved. Each zero is
/// passed to `take_zero` with its fraction and whether the function rises there along the step. Zeros that
/// `accepts` rejects by their direction are not computed. A zero at the first sample belongs to the step
/// before.
pub fn zeros<E>(
    fractions: &[f64; SAMPLES],
    values: &[f64; SAMPLES],
    slope_bound: Option<f64>,
    mut f: impl FnMut(f64) -> Result<f64, E>,
    accepts: impl Fn(bool) -> bool,
    mut take_zero: impl FnMut(f64, bool),
) -> Result<(), E> {
    let mut locate = |a: (f64, f64), b: (f64, f64), f: &mut dyn FnMut(f64) -> Result<f64, E>| {
        let rises = b.1 > a.1;
        if accepts(rises) {
            take_zero(root(f, a, b)?, rises);
        }
        Ok(())
    };
    let clear = |a: (f64, f64), b: (f64, f64)| {
        a.1 * b.1 > 0.0 && slope_bound.is_some_and(|slope| (a.1 + b.1).abs() > slope * (b.0 - a.0))
    };
    let mut samples: Vec<(f64, f64)> = fractions.iter().copied().zip(values.iter().copied()).collect();
    if slope_bound.is_some() {
        samples = halved(&samples, clear, &mut f)?;
    }
    for k in 1..samples.len() {
        let (a, b) = (samples[k - 1], samples[k]);
        if a.1 * b.1 < 0.0 || (b.1 == 0.0 && a.1 != 0.0) {
            locate(a, b, &mut f)?;
        }
        let Some(&c) = samples.get(k + 1) else { break };
        if clear(a, b) && clear(b, c) {
            continue;
        }
        let sign = b.1.signum();
        let same = a.1 * sign > 0.0 && c.1 * sign > 0.0;
        if same && b.1.abs() < a.1.abs() && b.1.abs() <= c.1.abs() {
            let (theta, value) = minimum(|theta| f(theta).map(|v| v * sign), a.0, c.0)?;
            if value < 0.0 {
                let middle = (theta, value * sign);
                locate(a, middle, &mut f)?;
                locate(middle, c, &mut f)?;
            }
        }
    }
    Ok(())
}

/// Returns samples of a function with further ones between those that are not clear of zeros.
fn halved<E>(
    samples: &[(f64, f64)],
    clear: impl Fn((f64, f64), (f64, f64)) -> bool,
    f: &mut dyn FnMut(f64) -> Result<f64, E>,
) -> Result<Vec<(f64, f64)>, E> {
    let mut all = vec![samples[0]];
    // The samples that follow, the next one last, with the halvings of the interval before each.
    let mut ahead: Vec<_> = samples[1..].iter().rev().map(|sample| (*sample, 0)).collect();
    while let (Some(&last), Some((next, halvings))) = (all.last(), ahead.pop()) {
        if halvings == HALVINGS || clear(last, next) {
            all.push(next);
            continue;
        }
        let middle = 0.5 * (last.0 + next.0);
        ahead.push((next, halvings + 1));
        ahead.push(((middle, f(middle)?), halvings + 1));
    }
    Ok(all)
}
