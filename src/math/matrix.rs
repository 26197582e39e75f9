//! Inlined products of 3 x 3 matrices, and their inverse. The products of `nalgebra` compile to calls of
//! generic loops, and its inverse to code for matrices of any size.

use super::{Mat3, Vec3};

/// Returns A B.
#[inline(always)]
pub fn times(a: &Mat3, b: &Mat3) -> Mat3 {
    entries(|i, j| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)])
}

/// Returns A B^T.
#[inline(always)]
pub fn times_transposed(a: &Mat3, b: &Mat3) -> Mat3 {
    entries(|i, j| a[(i, 0)] * b[(j, 0)] + a[(i, 1)] * b[(j, 1)] + a[(i, 2)] * b[(j, 2)])
}

/// Returns A^T B.
#[inline(always)]
pub fn transposed_times(a: &Mat3, b: &Mat3) -> Mat3 {
    entries(|i, j| a[(0, i)] * b[(0, j)] + a[(1, i)] * b[(1, j)] + a[(2, i)] * b[(2, j)])
}

/// Returns \[v\]x A, whose columns are the vector products v x a of v and the columns a of A.
#[inline(always)]
pub fn cross_times(v: &Vec3, a: &Mat3) -> Mat3 {
    entries(|i, j| {
        let (k, l) = ((i + 1) % 3, (i + 2) % 3);
        v[k] * a[(l, j)] - v[l] * a[(k, j)]
    })
}

/// Returns A \[v\]x, whose rows are the vector products a x v of the rows a of A and v.
#[inline(always)]
pub fn times_cross(a: &Mat3, v: &Vec3) -> Mat3 {
    entries(|i, j| {
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        a[(i, k)] * v[l] - a[(i, l)] * v[k]
    })
}

/// Returns the inverse; `None` for a matrix whose determinant is zero.
pub fn inverse(a: &Mat3) -> Option<Mat3> {
    let [x, y, z] = [0, 1, 2].map(|row| a.row(row).transpose());
    let adjugate = Mat3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)]);
    let determinant = x.dot(&y.cross(&z));
    (determinant != 0.0).then(|| adjugate / determinant)
}

/// Returns the matrix with the entries `of(row, column)`.
#[inline(always)]
fn entries(of: impl Fn(usize, usize) -> f64) -> Mat3 {
    Mat3::new(of(0, 0), of(0, 1), of(0, 2), of(1, 0), of(1, 1), of(1, 2), of(2, 0), of(2, 1), of(2, 2))
}
