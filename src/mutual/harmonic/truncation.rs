//! The degrees to which the series of a pair is summed.
//!
//! The term (l, l') of the energy over G m m'/r is at most C(l + l', l) mu_l mu'_l' (R/r)^l (R'/r)^l', since
//! along the line of the centres the coupling matrix of two degrees has no larger entry. The radial force
//! counts it l + l' + 1 times, and the torques on the bodies l and l' times. An omitted term counts in units
//! of the tolerance: relative to the force, and for the torque relative to the force times the radius.

use super::moments::Moments;
use crate::math::exchange::Exchange;

/// The degrees of both bodies in use, with the factors n! of the coupling.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Truncation {
    /// The highest degrees of the first and the second body.
    pub degrees: [usize; 2],
    /// The factors n!, (n + 1)! and (n + 2)! for the total degree n; zero beyond the highest total degree.
    pub(in crate::mutual) factors: [Vec<f64>; 3],
    /// The least separation for which the degrees reach the tolerance.
    pub valid_from: f64,
}

/// The degrees that a separation needs according to the bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RequiredDegrees {
    /// The degrees of both bodies.
    Degrees([usize; 2]),
    /// The moments of a body are known to too low a degree.
    Moments(usize),
    /// No degree up to the highest one suffices, or the circumscribed spheres meet.
    BeyondHighest,
}

impl Truncation {
    /// Makes the truncation at two degrees, and at a total degree.
    pub fn new(degrees: [usize; 2], total: usize, valid_from: f64) -> Self {
        let size = degrees[0] + degrees[1] + 1;
        let factors = [0, 1, 2].map(|more: usize| {
            let mut product = (1..=more).map(|k| k as f64).product::<f64>();
            (0..size)
                .map(|n| {
                    product *= if n > 0 { (n + more) as f64 } else { 1.0 };
                    if n <= total { product } else { 0.0 }
                })
                .collect()
        });
        Self { degrees, factors, valid_from }
    }
}

/// Returns the lowest degrees for which the omitted terms add up to less than the tolerance.
pub(super) fn required_degrees(bodies: [&Moments; 2], distance: f64, tolerance: f64) -> RequiredDegrees {
    let ratios = bodies.map(|body| body.radius / distance);
    let moment_degrees = bodies.map(Moments::degree);
    let arms = bodies.map(|body| if body.circumradius > 0.0 { distance / body.circumradius } else { 0.0 });
    let Some([rows, columns]) = sums(bodies, ratios, arms, moment_degrees) else {
        return RequiredDegrees::BeyondHighest;
    };
    let mut degrees = [0; 2];
    for (body, sums) in [rows, columns].iter().enumerate() {
        // The last sum contains all degrees beyond those that are known.
        let mut remainder = 0.0;
        let lowest = (0..sums.len()).rev().find(|&l| {
            remainder += sums[l];
            remainder > 0.5 * tolerance
        });
        degrees[body] = lowest.unwrap_or(0);
        if degrees[body] > moment_degrees[body] {
            return if moment_degrees[body] < Exchange::MAX_DEGREE {
                RequiredDegrees::Moments(body)
            } else {
                RequiredDegrees::BeyondHighest
            };
        }
    }
    RequiredDegrees::Degrees(degrees)
}

/// Returns the sums of the bounds over all degrees of the other body, for each degree of the first and of the
/// second body, and last for all degrees beyond those that are known. `None` where the spheres meet.
fn sums(
    bodies: [&Moments; 2],
    [x, y]: [f64; 2],
    arms: [f64; 2],
    moment_degrees: [usize; 2],
) -> Option<[Vec<f64>; 2]> {
    /// The highest degree to which tails are summed.
    const HIGHEST_DEGREE: usize = 600;
    /// The size of a term, relative to its tail, at which the sum ends.
    const NEGLIGIBLE: f64 = 1e-3;
    if x + y >= 1.0 {
        return None;
    }
    let size = |body: usize, l: usize| bodies[body].sizes.get(l).copied().unwrap_or(bodies[body].tail);
    let mut out = moment_degrees.map(|degree| vec![0.0; degree + 2]);
    // The lowest degrees are the monopole's: a torque is relative to the force times the radius.
    let weight = |l: usize, m: usize| {
        let force = (l + m + 1) as f64;
        force.max(l as f64 * arms[0]).max(m as f64 * arms[1])
    };
    let mut power = 1.0;
    let mut largest: f64 = 0.0;
    for l in 0..HIGHEST_DEGREE {
        let tail = l > moment_degrees[0];
        let mut term = power;
        let (mut row, mut end) = (0.0, 0.0_f64);
        for m in 0..HIGHEST_DEGREE {
            if m > 0 {
                term *= y * (l + m) as f64 / m as f64;
            }
            let bound = term * size(0, l) * size(1, m) * weight(l, m);
            row += bound;
            out[1][m.min(moment_degrees[1] + 1)] += bound;
            end = if m > moment_degrees[1] { bound } else { 0.0 };
            let falling = y * (l + m + 1) as f64 / ((m + 1) as f64) < 0.9;
            if m > moment_degrees[1]
                && (bound == 0.0
                    || falling && bound < NEGLIGIBLE * out[1][moment_degrees[1] + 1].max(f64::MIN_POSITIVE))
            {
                break;
            }
        }
        out[0][l.min(moment_degrees[0] + 1)] += row;
        largest = largest.max(end);
        if tail && (row == 0.0 || row < NEGLIGIBLE * out[0][moment_degrees[0] + 1]) {
            return Some(out);
        }
        power *= x;
    }
    None
}
