//! The exchange of y and z in solid harmonics, by which rotations about y become rotations about z.
//!
//! A rotation about z multiplies the harmonics of each order by cosines and sines. With P the exchange of y
//! and z, the rotation about y by minus an angle is P times the rotation about z by that angle times P
//! (White & Head-Gordon 1996, J. Chem. Phys. 105, 5061; Dehnen 2014, Comput. Astrophys. Cosmol. 1, 1). In
//! each degree P is a constant symmetric matrix K with S_lm(x, z, y) = sum_m' K_mm' S_lm'(x, y, z), and K
//! is its own inverse.
//!
//! The derivative by z of this equation relates the degrees: S_lm has the derivative sqrt(l^2 - m^2)
//! S_{l-1,m} by z, and its derivative by y is a sum of two harmonics of degree l - 1. P exchanges both
//! derivatives, so that K of degree l follows from that of degree l - 1, except for the corner that belongs
//! to two cosines of order l, where it is 2^(1 - l).
//!
//! Cosines and sines are even and odd in y, and harmonics with l - m even and odd are even and odd in z, so
//! that K has three blocks: between cosines of even l - m, between sines of odd l - m, and between sines of
//! even l - m and cosines of odd l - m.

use super::harmonics::{count, index};
use std::f64::consts::FRAC_1_SQRT_2;

/// The most orders of one parity in a degree up to [`Exchange::MAX_DEGREE`].
pub const MOST_ORDERS: usize = Exchange::MAX_DEGREE / 2 + 1;

/// The harmonics of one degree, by the parity of l - m and by kind; index k stands for the order l - 2k where
/// l - m is even and l - 1 - 2k where it is odd. The sine of order zero is zero.
#[derive(Debug, Clone, Copy)]
pub struct Parities {
    /// The cosines of even l - m.
    pub even_cosines: [f64; MOST_ORDERS],
    /// The sines of even l - m.
    pub even_sines: [f64; MOST_ORDERS],
    /// The cosines of odd l - m.
    pub odd_cosines: [f64; MOST_ORDERS],
    /// The sines of odd l - m.
    pub odd_sines: [f64; MOST_ORDERS],
}

impl Parities {
    /// Returns harmonics that are all zero.
    #[inline(always)]
    pub fn zeros() -> Self {
        let zeros = [0.0; MOST_ORDERS];
        Self { even_cosines: zeros, even_sines: zeros, odd_cosines: zeros, odd_sines: zeros }
    }

    /// Returns the numbers of orders with l - m even and odd.
    #[inline(always)]
    pub fn counts(degree: usize) -> [usize; 2] {
        [degree / 2 + 1, degree.div_ceil(2)]
    }
}

/// The blocks of the matrix of one degree, each by columns.
#[derive(Debug, Clone, PartialEq)]
struct ExchangeBlocks {
    cosines: Vec<f64>,
    sines: Vec<f64>,
    /// The block that maps odd cosines to even sines.
    mixed: Vec<f64>,
    /// The block that maps even sines to odd cosines.
    transposed: Vec<f64>,
}

/// The matrices of the exchange of y and z for all degrees up to a highest one.
#[derive(Debug, Clone, PartialEq)]
pub struct Exchange {
    degrees: Vec<ExchangeBlocks>,
}

impl Exchange {
    /// The highest degree.
    pub const MAX_DEGREE: usize = 80;

    /// Computes the matrices up to a degree, at most [`Self::MAX_DEGREE`].
    pub fn new(degree: usize) -> Self {
        let mut matrix = vec![vec![1.0]];
        let mut degrees = vec![ExchangeBlocks::of(&matrix, 0)];
        for l in 1..=degree.min(Self::MAX_DEGREE) {
            matrix = next_degree(&matrix, l);
            degrees.push(ExchangeBlocks::of(&matrix, l));
        }
        Self { degrees }
    }

    /// Returns the highest degree.
    pub fn degree(&self) -> usize {
        self.degrees.len() - 1
    }

    /// Exchanges y and z in the harmonics of a degree.
    #[inline(always)]
    pub fn apply(&self, degree: usize, of: &Parities) -> Parities {
        let [even, odd] = Parities::counts(degree);
        let blocks = &self.degrees[degree];
        let mut out = Parities::zeros();
        product(&blocks.cosines, &of.even_cosines[..even], &mut out.even_cosines[..even]);
        product(&blocks.sines, &of.odd_sines[..odd], &mut out.odd_sines[..odd]);
        product(&blocks.mixed, &of.odd_cosines[..odd], &mut out.even_sines[..even]);
        product(&blocks.transposed, &of.even_sines[..even], &mut out.odd_cosines[..odd]);
        out
    }
}

impl ExchangeBlocks {
    /// Sorts the matrix of a degree, whose rows and columns belong to the orders from -l to l.
    fn of(matrix: &[Vec<f64>], l: usize) -> Self {
        let [even, odd] = Parities::counts(l);
        let orders = |parity: usize| (0..[even, odd][parity]).map(move |k| l - parity - 2 * k);
        let block = |[from, sine_from]: [usize; 2], [to, sine_to]: [usize; 2]| {
            let index = |m: usize, sine: usize| if sine == 1 { l - m } else { l + m };
            let entry = |m: usize, n: usize| {
                let zero = (sine_to == 1 && m == 0) || (sine_from == 1 && n == 0);
                if zero { 0.0 } else { matrix[index(m, sine_to)][index(n, sine_from)] }
            };
            orders(from).flat_map(|n| orders(to).map(move |m| (m, n))).map(|(m, n)| entry(m, n)).collect()
        };
        Self {
            cosines: block([0, 0], [0, 0]),
            sines: block([1, 1], [1, 1]),
            mixed: block([1, 0], [0, 1]),
            transposed: block([0, 1], [1, 0]),
        }
    }
}

/// Returns the matrix of degree l from that of degree l - 1.
fn next_degree(matrix: &[Vec<f64>], l: usize) -> Vec<Vec<f64>> {
    let size = 2 * l + 1;
    let signed = |index: usize| index as isize - l as isize;
    let mut out = vec![vec![0.0; size]; size];
    for row in 0..size {
        for column in 0..size {
            let (m, n) = (signed(row), signed(column));
            // The matrix is symmetric, and the division is harmless where the column's order is the lower.
            if n.abs() > m.abs() || n.unsigned_abs() == l {
                continue;
            }
            let mut sum = 0.0;
            for (order, factor) in derivative_by_y(l, m).into_iter().flatten() {
                let inner = |order: isize| (order + l as isize - 1) as usize;
                sum += factor * matrix[inner(order)][inner(n)];
            }
            let value = sum / ((l * l) as f64 - (n * n) as f64).sqrt();
            (out[row][column], out[column][row]) = (value, value);
        }
    }
    out[size - 1][size - 1] = 0.5_f64.powi(l as i32 - 1);
    out
}

/// Returns the derivatives of the means of S_lm over a mass with respect to its displacement along an axis, up
/// to one degree more than the means.
pub fn displacement_derivatives(moments: &[f64], axis: usize) -> Vec<f64> {
    let degree = moments.len().isqrt();
    let mut out = vec![0.0; count(degree)];
    for l in 1..=degree {
        for m in -(l as isize)..=l as isize {
            let along_z = (m.unsigned_abs() < l).then(|| (m, ((l * l) as f64 - (m * m) as f64).sqrt()));
            let terms = match axis {
                0 => derivative_by_x(l, m),
                1 => derivative_by_y(l, m),
                _ => [along_z, None],
            };
            out[index(l, m)] =
                terms.iter().flatten().map(|(n, factor)| factor * moments[index(l - 1, *n)]).sum();
        }
    }
    out
}

/// Returns the derivative of S_lm by y: orders of harmonics of degree l - 1 with their factors. Orders below
/// zero are sines.
fn derivative_by_y(l: usize, m: isize) -> [Option<(isize, f64)>; 2] {
    derivative_across(l, m, true)
}

/// Returns the derivative of S_lm by x, as [`derivative_by_y`].
fn derivative_by_x(l: usize, m: isize) -> [Option<(isize, f64)>; 2] {
    derivative_across(l, m, false)
}

fn derivative_across(l: usize, m: isize, by_y: bool) -> [Option<(isize, f64)>; 2] {
    let (order, sine) = (m.unsigned_abs(), m < 0);
    // The factor between orders with and without the normalisation of order zero.
    let ratio = |order: usize, other: usize| match (order, other) {
        (0, 0) => 1.0,
        (0, _) => FRAC_1_SQRT_2,
        (_, 0) => std::f64::consts::SQRT_2,
        _ => 1.0,
    };
    let root = |product: usize| 0.5 * (product as f64).sqrt();
    let lower =
        (order > 0).then(|| (order - 1, ratio(order, order - 1) * root((l + order) * (l + order - 1))));
    let upper =
        (order + 1 < l).then(|| (order + 1, ratio(order, order + 1) * root((l - order) * (l - order - 1))));
    // The derivative by y exchanges cosines and sines. For order zero the two terms are equal.
    let into_sine = sine != by_y;
    let (sign_lower, sign_upper) = match (by_y, sine) {
        (false, _) => (1.0, -1.0),
        (true, false) => (-1.0, -1.0),
        (true, true) => (1.0, 1.0),
    };
    let twice = if order == 0 { 2.0 } else { 1.0 };
    let named = |(order, factor): (usize, f64), sign: f64| {
        let vanishes = into_sine && order == 0;
        let signed = if into_sine { -(order as isize) } else { order as isize };
        (!vanishes).then_some((signed, sign * factor))
    };
    [
        lower.and_then(|term| named(term, sign_lower)),
        upper.and_then(|(order, factor)| named((order, twice * factor), sign_upper)),
    ]
}

/// Adds the product of a matrix, stored by columns, and a vector.
#[inline(always)]
fn product(columns: &[f64], vector: &[f64], out: &mut [f64]) {
    if out.is_empty() {
        return;
    }
    for (column, x) in columns.chunks_exact(out.len()).zip(vector) {
        for (out, entry) in out.iter_mut().zip(column) {
            *out += entry * x;
        }
    }
}
