//! The bound of the error of two fragments' series, and the lowest degrees whose bound is below a limit.
//!
//! The terms are those of [`crate::mutual::harmonic`]: the term (l, m) of the force over G m m'/d^2 is at most
//! (l + m + 1) C(l + m, l) mu_l mu'_m x^l y^m, with x and y the radii over the distance d.

use super::tree::Fragment;

/// The numbers (l + m + 1) C(l + m, l), by rows of m.
#[derive(Debug, Clone)]
pub(super) struct BoundWeights {
    size: usize,
    rows: Vec<f64>,
}

/// The degrees to which the series of a pair of fragments is summed, with the bound of the terms beyond them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeriesDegrees {
    pub degrees: [usize; 2],
    pub bound: f64,
}

/// The largest number of degrees, from zero on, which is the size of arrays on the stack.
pub(super) const MOST_DEGREES: usize = 38;
/// The largest sum of x and y, the radii over the distance, for which a series is summed.
const LARGEST_RADII: f64 = 0.95;

impl BoundWeights {
    /// Computes the weights of all degrees up to `degree + 1`.
    pub fn new(degree: usize) -> Self {
        let size = degree + 2;
        let mut rows = vec![1.0; size * size];
        for l in 1..size {
            for m in 1..size {
                rows[l * size + m] = rows[(l - 1) * size + m] + rows[l * size + m - 1];
            }
        }
        for l in 0..size {
            (0..size).for_each(|m| rows[l * size + m] *= (l + m + 1) as f64);
        }
        Self { size, rows }
    }

    /// Returns the lowest degrees for which the bound of the terms beyond them is below a limit, relative to
    /// the force of two points; `None` where the fragments are too near to each other.
    pub fn degrees(&self, [a, b]: [&Fragment; 2], distance: f64, limit: f64) -> Option<SeriesDegrees> {
        let [x, y] = [a.radius / distance, b.radius / distance];
        let radii = x + y;
        if radii.is_nan() || radii >= LARGEST_RADII {
            return None;
        }
        let (size, [p, q]) = (self.size, [a.degree(), b.degree()]);
        let scaled = |fragment: &Fragment, ratio: f64| {
            let mut out = [0.0; MOST_DEGREES];
            let mut power = 1.0;
            for (out, size) in out.iter_mut().zip(&fragment.sizes) {
                *out = size * power;
                power *= ratio;
            }
            (out, power)
        };
        let ((first, beyond_first), (second, beyond_second)) = (scaled(a, x), scaled(b, y));
        // The terms beyond the highest degree of one body fall at least as fast as a geometric series.
        let tail = |degree: usize, power: f64, ratio: f64, other: &[f64]| {
            let next = &self.rows[(degree + 1) * size..];
            let mut sum = 0.0;
            for m in 0..other.len() {
                let ratio_of_terms = ratio * (degree + m + 3) as f64 / (degree + 2) as f64;
                if ratio_of_terms >= 1.0 && other[m] > 0.0 {
                    return f64::INFINITY;
                }
                sum += next[m] * other[m] / (1.0 - ratio_of_terms);
            }
            sum * power
        };
        let n = p + q + 2;
        let product_tail = radii.powi(n as i32) * (1.0 + n as f64 * (1.0 - radii)) / (1.0 - radii).powi(2);
        let beyond = a.tail * tail(p, beyond_first, x, &second[..=q])
            + b.tail * tail(q, beyond_second, y, &first[..=p])
            + a.tail * b.tail * product_tail;
        if beyond.is_nan() || beyond > 0.5 * limit {
            return None;
        }
        let (mut rows, mut columns) = ([0.0; MOST_DEGREES], [0.0; MOST_DEGREES]);
        for (l, row) in self.rows.chunks_exact(size).take(p + 1).enumerate() {
            let mut sum = 0.0;
            for m in 0..=q {
                let term = row[m] * second[m];
                sum += term;
                columns[m] += row[m] * first[l];
            }
            rows[l] = sum * first[l];
        }
        (0..=q).for_each(|m| columns[m] *= second[m]);
        let limit_of_body = 0.5 * (limit - beyond);
        let mut bound = beyond;
        let degrees = [(rows, p), (columns, q)].map(|(sums, degree)| {
            let (mut omitted, mut highest) = (0.0, degree);
            while highest > 0 && omitted + sums[highest] <= limit_of_body {
                omitted += sums[highest];
                highest -= 1;
            }
            bound += omitted;
            highest
        });
        Some(SeriesDegrees { degrees, bound })
    }
}
