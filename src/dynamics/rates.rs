//! The rates of change of departures, many at a time.

use crate::math::Vec3;
use pulp::{Scalar, Simd, WithSimd};

/// Numbers of a column that are multiplied at a time.
pub(super) const DEPTH: usize = 9;

/// The equations without the terms of parameters, over lanes of columns.
pub(super) struct Rates<'a> {
    /// Half the rows, and columns.
    pub size: [usize; 2],
    /// A and B, with the row of the columns that each begins with, and the length of their rows.
    pub parts: [(&'a [f64], usize); 2],
    pub stride: usize,
    /// The row of the first body's theta; spins and moments of inertia.
    pub turn: usize,
    pub spin: &'a [Vec3],
    pub inertia: &'a [Vec3],
    pub columns: &'a [f64],
    pub rates: &'a mut [f64],
}

impl WithSimd for Rates<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.size[1] < S::F64_LANES {
            return self.by(Scalar);
        }
        self.by(simd);
    }
}

impl Rates<'_> {
    #[inline(always)]
    fn by<S: Simd>(self, simd: S) {
        let Self { size: [half, width], parts, stride, columns, rates, .. } = self;
        let lanes = S::F64_LANES;
        let zero = simd.splat_f64s(0.0);
        for first in (0..width).step_by(lanes) {
            // The last lanes overlap those before.
            let first = first.min(width - lanes);
            let load =
                |values: &[f64], row: usize| S::as_simd_f64s(&values[row * width + first..][..lanes]).0[0];
            for k in 0..half {
                let p = load(columns, half + k);
                store::<S>(rates, k * width + first, p);
            }
            let blocks = parts.iter().flat_map(|&(matrix, from)| {
                (0..matrix.len().min(stride)).step_by(DEPTH).map(move |block| (matrix, from, block))
            });
            for (matrix, from, block) in blocks {
                let mut q = [zero; DEPTH];
                for k in 0..DEPTH.min(half - block) {
                    q[k] = load(columns, from + block + k);
                }
                for (row, weights) in matrix.chunks_exact(stride).enumerate() {
                    let weights = &weights[block..block + DEPTH];
                    let mut sum = if from + block == 0 { zero } else { load(rates, half + row) };
                    for k in 0..DEPTH {
                        sum = simd.mul_add_e_f64s(simd.splat_f64s(weights[k]), q[k], sum);
                    }
                    store::<S>(rates, (half + row) * width + first, sum);
                }
            }
            for (body, (spin, inertia)) in self.spin.iter().zip(self.inertia).enumerate() {
                let row = self.turn + 3 * body;
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let ratio = if inertia[i] > 0.0 { (inertia[k] - inertia[j]) / inertia[i] } else { 0.0 };
                    // -(spin x theta) and -(I_k - I_j)/I_i (spin_k dspin_j + spin_j dspin_k).
                    for (from, a, b) in [(0, spin[k], -spin[j]), (half, -ratio * spin[k], -ratio * spin[j])] {
                        let mut sum = load(rates, from + row + i);
                        sum = simd.mul_add_e_f64s(simd.splat_f64s(a), load(columns, from + row + j), sum);
                        sum = simd.mul_add_e_f64s(simd.splat_f64s(b), load(columns, from + row + k), sum);
                        store::<S>(rates, (from + row + i) * width + first, sum);
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn store<S: Simd>(values: &mut [f64], at: usize, lanes: S::f64s) {
    S::as_mut_simd_f64s(&mut values[at..][..S::F64_LANES]).0[0] = lanes;
}
