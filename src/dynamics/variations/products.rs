//! Products of the matrices of the variational equations with tangent vectors, a register of columns at a
//! time.

use pulp::{Scalar, Simd, WithSimd};

/// The number of entries of a column that are multiplied at a time.
pub(super) const DEPTH: usize = 9;

/// Returns `start` plus the product of some entries of a matrix's row and equally many rows of columns.
#[inline(always)]
pub(super) fn product<S: Simd>(
    simd: S,
    weights: &[f64; DEPTH],
    rows: &[S::f64s; DEPTH],
    start: S::f64s,
) -> S::f64s {
    let mut sum = start;
    for k in 0..DEPTH {
        sum = simd.mul_add_e_f64s(simd.splat_f64s(weights[k]), rows[k], sum);
    }
    sum
}

/// Adds a size times the product of a matrix and the first half of the rows of columns to the second half.
pub(super) struct KickProduct<'a> {
    /// The rows of the matrix, in whole multiples of `DEPTH`.
    pub matrix: &'a [f64],
    pub stride: usize,
    pub size: f64,
    /// The number of rows in either half, and the number of columns.
    pub shape: [usize; 2],
    pub columns: &'a mut [f64],
}

impl WithSimd for KickProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.shape[1] < S::F64_LANES { self.by(Scalar) } else { self.by(simd) }
    }
}

impl KickProduct<'_> {
    #[inline(always)]
    fn by<S: Simd>(self, simd: S) {
        let Self { matrix, stride, size, shape: [half, width], columns } = self;
        let lanes = S::F64_LANES;
        let (q, p) = columns.split_at_mut(half * width);
        let size = simd.splat_f64s(size);
        for first in (0..width).step_by(lanes) {
            // The last lanes overlap those before, and columns that are done are skipped.
            let at = first.min(width - lanes);
            for (row, weights) in matrix.chunks_exact(stride).enumerate() {
                let mut sum = simd.splat_f64s(0.0);
                for (block, weights) in weights.as_chunks::<DEPTH>().0.iter().enumerate() {
                    let mut rows = [simd.splat_f64s(0.0); DEPTH];
                    for (k, from) in (DEPTH * block..half).take(DEPTH).enumerate() {
                        rows[k] = S::as_simd_f64s(&q[from * width + at..][..lanes]).0[0];
                    }
                    sum = product(simd, weights, &rows, sum);
                }
                let mut pushed = [0.0; 8];
                let pushed = &mut pushed[..lanes];
                S::as_mut_simd_f64s(pushed).0[0] = simd.mul_f64s(size, sum);
                let done = first - at;
                let p = &mut p[row * width + first..][..lanes - done];
                p.iter_mut().zip(&pushed[done..]).for_each(|(p, by)| *p += by);
            }
        }
    }
}
