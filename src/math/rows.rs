//! Rows of doubles, one number of a vector in each column: weighted sums and largest changes, a register of columns at a time.

use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Registers of a row that are summed side by side.
const COLUMNS: usize = 4;

/// Length of rows that can be summed in whole groups of registers on every path.
pub fn stride(length: usize) -> usize {
    length.next_multiple_of(8 * COLUMNS)
}

/// Largest differences of rows from the first one, in the columns of a range.
pub struct LargestChanges<'a> {
    /// Rows, one after the other, each of the length of `out`, a [`stride`].
    pub rows: &'a [f64],
    /// The columns that are wanted.
    pub range: Range<usize>,
    /// The differences; the numbers in other columns mean nothing.
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
            let mut place = column + width;
            while place < rows.len() {
                largest = simd.max_f64s(largest, simd.abs_f64s(simd.sub_f64s(rows[place], first)));
                place += width;
            }
            out[column] = largest;
        }
    }
}

/// A term of a weighted sum of rows.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// The row.
    pub row: usize,
    /// Its weight.
    pub weight: f64,
    /// What rounding dropped of the weight.
    pub low: f64,
}

/// Weighted sums of rows, by the weights and by their low parts.
pub struct WeightedRows<'a> {
    /// The terms of the sum.
    pub terms: &'a [Term],
    /// Rows, one after the other.
    pub rows: &'a [f64],
    /// Length of a row, a [`stride`].
    pub stride: usize,
}

impl WeightedRows<'_> {
    /// Both sums of a group of columns.
    #[inline(always)]
    fn sums<S: Simd>(&self, simd: S, column: usize) -> [[S::f64s; COLUMNS]; 2] {
        let rows = S::as_simd_f64s(self.rows).0.as_chunks::<COLUMNS>().0;
        let width = rows.len() * self.stride / self.rows.len();
        let mut sums = [[simd.splat_f64s(0.0); COLUMNS]; 2];
        for term in self.terms {
            let (weight, low) = (simd.splat_f64s(term.weight), simd.splat_f64s(term.low));
            let values = &rows[term.row * width + column];
            for k in 0..COLUMNS {
                sums[0][k] = simd.mul_add_e_f64s(weight, values[k], sums[0][k]);
                sums[1][k] = simd.mul_add_e_f64s(low, values[k], sums[1][k]);
            }
        }
        sums
    }
}

/// The sums in as many columns as the slices have, a [`stride`]: by the weights, and by their low parts.
pub struct Increments<'a>(pub WeightedRows<'a>, pub [&'a mut [f64]; 2]);

impl WithSimd for Increments<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(rows, [out, tail]) = self;
        let out = S::as_mut_simd_f64s(out).0.as_chunks_mut::<COLUMNS>().0;
        let tail = S::as_mut_simd_f64s(tail).0.as_chunks_mut::<COLUMNS>().0;
        for (column, (out, tail)) in out.iter_mut().zip(tail).enumerate() {
            [*out, *tail] = rows.sums(simd, column);
        }
    }
}

/// A vector in two parts, to which a step of a size along the sums is added, as a vector in one part. All have a [`stride`] as their
/// length.
pub struct Advance<'a> {
    /// The sums.
    pub rows: WeightedRows<'a>,
    /// What is added to.
    pub from: [&'a [f64]; 2],
    /// Size of the step.
    pub size: f64,
    /// The result.
    pub out: &'a mut [f64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let high = S::as_simd_f64s(self.from[0]).0.as_chunks::<COLUMNS>().0;
        let low = S::as_simd_f64s(self.from[1]).0.as_chunks::<COLUMNS>().0;
        let out = S::as_mut_simd_f64s(self.out).0.as_chunks_mut::<COLUMNS>().0;
        let size = simd.splat_f64s(self.size);
        for (column, out) in out.iter_mut().enumerate() {
            let [sum, tail] = self.rows.sums(simd, column);
            for k in 0..COLUMNS {
                let low = simd.add_f64s(low[column][k], simd.mul_f64s(size, tail[k]));
                let change = simd.add_f64s(low, simd.mul_f64s(size, sum[k]));
                out[k] = simd.add_f64s(high[column][k], change);
            }
        }
    }
}

/// Weighted sums of rows of any length, one after the other, without fused operations: the same bits on every path.
pub struct Sums<'a> {
    /// Of every row the weights in all sums; behind those given there are zeros.
    pub weights: &'a [&'a [f64]],
    /// Rows, one after the other.
    pub rows: &'a [f64],
    /// From one row to the next.
    pub stride: usize,
    /// The sums, one after the other.
    pub out: &'a mut [f64],
    /// How many numbers of a row count.
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
