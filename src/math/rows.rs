//! Rows of doubles, each holding one vector: weighted sums of rows and largest changes between them, a
//! register of columns at a time.

use super::compensated::two_sum_in;
use super::lanes::WIDEST;
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// The number of registers of a row that are summed side by side.
const COLUMNS: usize = 4;

/// Rounds a length up to whole registers.
pub fn whole(length: usize) -> usize {
    length.next_multiple_of(WIDEST)
}

/// Returns the distance from one row to the next: an odd number of whole registers. Rows that lie a power of
/// two apart would compete for the same cache lines.
pub fn stride(length: usize) -> usize {
    (length.div_ceil(WIDEST) | 1) * WIDEST
}

/// Computes, for the columns of a range, the largest difference of any row from the first one.
pub struct LargestChanges<'a> {
    /// The rows, one after the other, each of the length of `out`, a [`stride`].
    pub rows: &'a [f64],
    /// The columns that are computed.
    pub range: Range<usize>,
    /// The differences; the numbers in other columns are unspecified.
    pub out: &'a mut [f64],
}

impl WithSimd for LargestChanges<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let rows = S::as_simd_f64s(self.rows).0;
        let out = S::as_mut_simd_f64s(self.out).0;
        let width = out.len();
        let columns = self.range.start / S::F64_LANES..self.range.end.div_ceil(S::F64_LANES);
        for column in columns {
            let first = rows[column];
            let mut largest = simd.splat_f64s(0.0);
            let mut index = column + width;
            while index < rows.len() {
                largest = simd.max_f64s(largest, simd.abs_f64s(simd.sub_f64s(rows[index], first)));
                index += width;
            }
            out[column] = largest;
        }
    }
}

/// One term of a weighted sum of rows.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// The index of the row.
    pub row: usize,
    /// The weight of the row.
    pub weight: f64,
    /// The low part of the weight.
    pub low: f64,
}

/// A weighted sum of rows, formed separately with the weights and with their low parts.
pub struct WeightedRows<'a> {
    /// The terms of the sum.
    pub terms: &'a [Term],
    /// The rows, one after the other.
    pub rows: &'a [f64],
    /// The length of a row, a [`stride`].
    pub stride: usize,
}

impl WeightedRows<'_> {
    /// Returns both sums for a group of registers.
    #[inline(always)]
    fn sums<S: Simd, const N: usize>(&self, simd: S, column: usize) -> [[S::f64s; N]; 2] {
        let rows = S::as_simd_f64s(self.rows).0;
        let width = self.stride / S::F64_LANES;
        let mut sums = [[simd.splat_f64s(0.0); N]; 2];
        for term in self.terms {
            let (weight, low) = (simd.splat_f64s(term.weight), simd.splat_f64s(term.low));
            let values = &rows[term.row * width + column..][..N];
            for k in 0..N {
                sums[0][k] = simd.mul_add_e_f64s(weight, values[k], sums[0][k]);
                sums[1][k] = simd.mul_add_e_f64s(low, values[k], sums[1][k]);
            }
        }
        sums
    }
}

/// A step from a vector in two parts along weighted sums. All of them have equally many numbers, which fill
/// whole registers.
pub struct Advance<'a> {
    /// The weighted sums.
    pub rows: WeightedRows<'a>,
    /// The high and the low part of the vector at the start.
    pub from: [&'a [f64]; 2],
    /// The size of the step.
    pub size: f64,
}

impl Advance<'_> {
    /// Returns the changes of the high and of the low part for a group of registers.
    #[inline(always)]
    fn changes<S: Simd, const N: usize>(&self, simd: S, column: usize) -> [[S::f64s; N]; 2] {
        let size = simd.splat_f64s(self.size);
        let low = &S::as_simd_f64s(self.from[1]).0[column..][..N];
        let [mut sum, mut tail] = self.rows.sums(simd, column);
        for k in 0..N {
            sum[k] = simd.mul_f64s(size, sum[k]);
            tail[k] = simd.add_f64s(low[k], simd.mul_f64s(size, tail[k]));
        }
        [sum, tail]
    }
}

/// Writes the result of [`Advance`] as one vector.
pub struct InSinglePart<'a>(pub Advance<'a>, pub &'a mut [f64]);

impl InSinglePart<'_> {
    #[inline(always)]
    fn group<S: Simd, const N: usize>(&mut self, simd: S, column: usize) {
        let [change, low] = self.0.changes::<S, N>(simd, column);
        let high = &S::as_simd_f64s(self.0.from[0]).0[column..][..N];
        let out = &mut S::as_mut_simd_f64s(self.1).0[column..][..N];
        for k in 0..N {
            out[k] = simd.add_f64s(high[k], simd.add_f64s(low[k], change[k]));
        }
    }
}

impl WithSimd for InSinglePart<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (groups, all) = groups::<S>(self.1.len());
        (0..groups).step_by(COLUMNS).for_each(|column| self.group::<S, COLUMNS>(simd, column));
        (groups..all).for_each(|column| self.group::<S, 1>(simd, column));
    }
}

/// Writes the result of [`Advance`] as a high and a low part, without fused operations beside the sums.
pub struct InTwoParts<'a>(pub Advance<'a>, pub [&'a mut [f64]; 2]);

impl InTwoParts<'_> {
    #[inline(always)]
    fn group<S: Simd, const N: usize>(&mut self, simd: S, column: usize) {
        let [change, low] = self.0.changes::<S, N>(simd, column);
        let from = &S::as_simd_f64s(self.0.from[0]).0[column..][..N];
        let [high, tail] = &mut self.1;
        let high = &mut S::as_mut_simd_f64s(high).0[column..][..N];
        let tail = &mut S::as_mut_simd_f64s(tail).0[column..][..N];
        for k in 0..N {
            let (sum, lost) = two_sum_in(simd, from[k], change[k]);
            (high[k], tail[k]) = two_sum_in(simd, sum, simd.add_f64s(lost, low[k]));
        }
    }
}

impl WithSimd for InTwoParts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (groups, all) = groups::<S>(self.1[0].len());
        (0..groups).step_by(COLUMNS).for_each(|column| self.group::<S, COLUMNS>(simd, column));
        (groups..all).for_each(|column| self.group::<S, 1>(simd, column));
    }
}

/// Returns the number of registers in whole groups and the number of all registers, for a vector of this
/// length.
#[inline(always)]
fn groups<S: Simd>(length: usize) -> (usize, usize) {
    let all = length / S::F64_LANES;
    (all - all % COLUMNS, all)
}

/// Computes weighted sums of rows of any length without fused operations, so that every path gives the same
/// bits.
pub struct Sums<'a> {
    /// The weights of each row in all sums; zero for a sum to which the row does not contribute.
    pub weights: &'a [Vec<f64>],
    /// The rows, one after the other.
    pub rows: &'a [f64],
    /// The distance from one row to the next.
    pub stride: usize,
    /// The sums, one after the other.
    pub out: &'a mut [f64],
    /// The length of a row.
    pub length: usize,
}

impl WithSimd for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (index, out) in self.out.chunks_exact_mut(self.length).enumerate() {
            out.fill(0.0);
            let (out, out_rest) = S::as_mut_simd_f64s(out);
            for (row, weights) in self.weights.iter().enumerate() {
                let weight = weights.get(index).copied().unwrap_or(0.0);
                if weight == 0.0 {
                    continue;
                }
                let (values, rest) = S::as_simd_f64s(&self.rows[row * self.stride..][..self.length]);
                for k in 0..out.len() {
                    out[k] = simd.add_f64s(out[k], simd.mul_f64s(simd.splat_f64s(weight), values[k]));
                }
                for k in 0..out_rest.len() {
                    out_rest[k] += weight * rest[k];
                }
            }
        }
    }
}
